//! All tables as one workbook: a sheet “About” with provenance and contents, then a sheet for each table.

use rust_xlsxwriter::{Color, DocProperties, ExcelDateTime, Format, FormatAlign, FormatBorder, Url, Workbook, Worksheet, XlsxError};

use super::Provenance;
use super::csv::{Cell, Table};
use super::language::Translator;
use super::tables::{Kind, Named, heading, kind};
use crate::error::Error;
use crate::study::campaign::CampaignStudy;

/// Rows that decide how wide a column is; more change nothing that a reader sees at once.
const LOOKED_AT: usize = 200;
/// Narrowest and widest column, letters.
const NARROWEST: usize = 6;
const WIDEST: usize = 48;

/// The bytes of `report.xlsx`: numbers are numbers, heads are frozen, bold and filter. The same study gives the same bytes.
///
/// # Errors
/// [`Error::Output`] if the writer refuses.
pub fn workbook(study: &CampaignStudy, tables: &[Named], provenance: &Provenance, translator: &Translator) -> Result<Vec<u8>, Error> {
    book(study, tables, provenance, translator).map_err(|e| Error::Output { what: "report.xlsx".into(), why: e.to_string() })
}

fn book(study: &CampaignStudy, tables: &[Named], provenance: &Provenance, translator: &Translator) -> Result<Vec<u8>, XlsxError> {
    let mut workbook = Workbook::new();
    // No clock: without a date from outside the workbook bears one that nobody takes for its own.
    let (year, month, day) = provenance.date.map_or((2000, 1, 1), |date| (date.year.clamp(1900, 9999) as u16, date.month, date.day));
    let properties = DocProperties::new()
        .set_title(&study.campaign.title)
        .set_comment(&study.campaign.origin)
        .set_author(concat!("hemline ", env!("CARGO_PKG_VERSION")))
        .set_creation_datetime(&ExcelDateTime::from_ymd(year, month, day)?);
    workbook.set_properties(&properties);
    about(workbook.add_worksheet(), study, tables, provenance, translator)?;
    for named in tables {
        sheet(workbook.add_worksheet(), named)?;
    }
    workbook.save_to_buffer()
}

fn about(
    sheet: &mut Worksheet,
    study: &CampaignStudy,
    tables: &[Named],
    provenance: &Provenance,
    translator: &Translator,
) -> Result<(), XlsxError> {
    let say = |text: &str| translator.say(text);
    sheet.set_name(say("About"))?;
    sheet.set_column_width(0, 26)?.set_column_width(1, 46)?.set_column_width(2, 20)?;
    let title = Format::new().set_bold().set_font_size(14);
    let bold = Format::new().set_bold();
    let wrapped = Format::new().set_text_wrap().set_align(FormatAlign::Top);
    sheet.write_string_with_format(0, 0, &study.campaign.title, &title)?;
    sheet.write_string(1, 0, &study.campaign.origin)?;
    let mut row = 3;
    let mut facts = vec![(say("Program"), concat!("hemline ", env!("CARGO_PKG_VERSION")).to_string())];
    facts.extend(provenance.date.map(|date| (say("Date"), date.to_string())));
    facts.push((say("Campaign folder"), study.campaign.folder.display().to_string()));
    facts.extend(provenance.settings.iter().map(|(option, value)| (say(option), say(value))));
    facts.push((
        say("Numbers"),
        say("Lengths in mm, angles and everything else as the head says; an empty cell: the quantity does not exist."),
    ));
    for (name, value) in facts {
        sheet.write_string_with_format(row, 0, name, &bold)?;
        sheet.write_string_with_format(row, 1, value, &wrapped)?;
        row += 1;
    }
    row += 1;
    for (c, head) in ["Sheet", "What a row is", "Rows"].into_iter().enumerate() {
        sheet.write_string_with_format(row, c as u16, say(head), &bold)?;
    }
    for named in tables {
        row += 1;
        sheet.write_url(row, 0, Url::new(format!("internal:'{}'!A1", named.stem)).set_text(named.stem))?;
        sheet.write_string_with_format(row, 1, say(named.about), &wrapped)?;
        sheet.write_number(row, 2, named.table.rows.len() as f64)?;
    }
    row += 2;
    for (c, head) in ["File", "Digest (FNV-1a, 64 bit)", "Bytes"].into_iter().enumerate() {
        sheet.write_string_with_format(row, c as u16, say(head), &bold)?;
    }
    for source in &study.sources {
        row += 1;
        sheet.write_string(row, 0, source.file.display().to_string())?;
        sheet.write_string(row, 1, &source.digest)?;
        sheet.write_number(row, 2, source.bytes as f64)?;
    }
    Ok(())
}

fn sheet(sheet: &mut Worksheet, named: &Named) -> Result<(), XlsxError> {
    let table = &named.table;
    sheet.set_name(named.stem)?;
    let head = Format::new().set_bold().set_background_color(Color::RGB(0xDC_E6F1)).set_border_bottom(FormatBorder::Thin);
    for c in 0..table.columns.len() {
        let kind = kind(table, c);
        let name = heading(&table.columns[c]);
        let letters = widest(table, c).max(name.chars().count() + 3);
        sheet.set_column_width(c as u16, letters.clamp(NARROWEST, WIDEST) as f64 + 1.0)?;
        sheet.write_string_with_format(0, c as u16, name, &head)?;
        let format = match kind {
            Kind::Number => Format::new().set_num_format(number_format(table, c)),
            Kind::Whole => Format::new().set_num_format("0"),
            Kind::Text | Kind::Flag => Format::new(),
        };
        // Runs that are all numbered are numbers: they sort as such.
        let numbered = kind == Kind::Text && table.columns[c] == "run" && table.rows.iter().all(|row| canonical(&row[c]).is_some());
        for (r, row) in table.rows.iter().enumerate() {
            let at = (r as u32 + 1, c as u16);
            match &row[c] {
                Cell::Empty => (),
                Cell::Integer(value) => drop(sheet.write_number_with_format(at.0, at.1, *value as f64, &format)?),
                Cell::Number(value) if value.is_finite() => drop(sheet.write_number_with_format(at.0, at.1, *value, &format)?),
                Cell::Number(_) => (),
                Cell::Text(text) if kind == Kind::Flag => drop(sheet.write_boolean(at.0, at.1, text == "true")?),
                cell @ Cell::Text(text) => match canonical(cell).filter(|_| numbered) {
                    Some(value) => drop(sheet.write_number(at.0, at.1, value)?),
                    // Text is text whatever it begins with: no cell of a laboratory's file becomes a formula.
                    None => drop(sheet.write_string(at.0, at.1, text)?),
                },
            }
        }
    }
    sheet.set_freeze_panes(1, 1)?;
    sheet.autofilter(0, 0, table.rows.len() as u32, table.columns.len() as u16 - 1)?;
    sheet.set_landscape().set_repeat_rows(0, 0)?;
    Ok(())
}

/// The number that a text is, if it is written as that number would be.
fn canonical(cell: &Cell) -> Option<f64> {
    let Cell::Text(text) = cell else { return None };
    // Fifteen digits: more would not come back from a spreadsheet.
    text.parse::<u64>().ok().filter(|n| n.to_string() == *text && text.len() <= 15).map(|n| n as f64)
}

/// Decimals by the size of the largest number: four significant digits of it and more of none.
fn number_format(table: &Table, column: usize) -> &'static str {
    let size = |row: &Vec<Cell>| if let Cell::Number(value) = row[column] { value.abs() } else { 0.0 };
    let largest = table.rows.iter().map(size).filter(|size| size.is_finite()).fold(0.0, f64::max);
    match largest {
        l if 1e7 <= l => "0.000E+00",
        l if 1e3 <= l => "0.0",
        l if 1e2 <= l => "0.00",
        l if 1.0 < l => "0.000",
        l if 1e-2 < l => "0.0000",
        0.0 => "0",
        _ => "0.000E+00",
    }
}

/// Letters of the longest cell as it shows.
fn widest(table: &Table, column: usize) -> usize {
    let letters = |cell: &Cell| match cell {
        Cell::Empty => 0,
        Cell::Text(text) => text.chars().count(),
        Cell::Integer(value) => value.to_string().len(),
        Cell::Number(_) => 10,
    };
    table.rows.iter().take(LOOKED_AT).map(|row| letters(&row[column])).max().unwrap_or(0)
}
