//! Documents: a file of any kind that holds tables → its tables, each with its header.
//!
//! The kind is told by the first bytes, not by the name: laboratories rename files.

use std::path::Path;

use super::cells::{Headed, MOST_COLUMNS, Row, shortened};
use super::dialect::Dialect;
use super::header;
use super::workbook::{self, Sheet};
use super::{columnar, delimited, source};
use crate::error::{Error, Place};
use crate::experiment::Source;

/// A file, read.
pub(super) struct Document {
    pub source: Source,
    /// `CSV`, `XLSX`, `XLS`, `ODS`, `Parquet` or `Arrow`.
    pub format: &'static str,
    /// One, or one per sheet that has anything in it.
    pub tables: Vec<Result<Headed, Error>>,
    /// Sheets that were passed over; one sentence each.
    pub notes: Vec<String>,
}

impl Document {
    /// The only table, or the one that `fits` among the sheets of a workbook; without one that fits, the first.
    ///
    /// # Errors
    /// [`Error::Input`] if several fit, or if the table is none.
    pub(super) fn into_one(self, fits: impl Fn(&Headed) -> bool) -> Result<Headed, Error> {
        let file = self.source.file;
        let fitting: Vec<usize> = (0..self.tables.len()).filter(|&i| self.tables[i].as_ref().is_ok_and(&fits)).collect();
        if 1 < fitting.len() {
            let sheet = |i: &usize| self.tables[*i].as_ref().ok().and_then(|table| table.sheet.clone()).unwrap_or_default();
            let names: Vec<String> = fitting.iter().map(|i| format!("“{}”", sheet(i))).collect();
            let problem = format!("several sheets hold such a table: {}", names.join(", "));
            return Err(Error::input(
                Place::file(file),
                problem,
                "keep one of them; or tell it: sheets = [\"…\"] in [tables] of campaign.toml",
            ));
        }
        let chosen = fitting.first().copied().unwrap_or(0);
        let empty = || Error::input(Place::file(file), "the workbook is empty", "it needs a header row and one row per entry");
        self.tables.into_iter().nth(chosen).ok_or_else(empty)?
    }
}

/// Extensions of files that hold tables.
const EXTENSIONS: [&str; 12] = ["csv", "tsv", "tab", "txt", "dat", "xlsx", "xls", "ods", "parquet", "arrow", "feather", "ipc"];

/// Whether a file is read as a table, by its extension; `.gz` may follow it.
pub fn is_table(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.rsplit_once('.').is_some_and(|(stem, extension)| !stem.is_empty() && EXTENSIONS.contains(&extension))
}

/// Reads the tables of a file; `wanted` tells a header from the rows above it.
///
/// # Errors
/// [`Error::File`] if it cannot be read; [`Error::Input`] if it is damaged, beyond the bounds, or has no sheet of a name that was told.
pub(super) fn read(path: &Path, dialect: &Dialect, wanted: &dyn Fn(&[String]) -> bool) -> Result<Document, Error> {
    let (bytes, source) = source::read_table(path)?;
    let refuse = |problem: String| Error::input(Place::file(path), problem, "save it again as XLSX, ODS or CSV, without a password");
    let single = |format, table| Document { source: source.clone(), format, tables: vec![table], notes: Vec::new() };
    if bytes.starts_with(b"PAR1") {
        return Ok(single("Parquet", Ok(columnar::read(path, bytes, true)?)));
    }
    if bytes.starts_with(b"ARROW1") {
        return Ok(single("Arrow", Ok(columnar::read(path, bytes, false)?)));
    }
    let (format, sheets) = if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
        workbook::zipped(&bytes).map_err(refuse)?
    } else if bytes.starts_with(b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1") {
        ("XLS", workbook::compound(bytes).map_err(refuse)?)
    } else {
        return Ok(single("CSV", Ok(delimited::read(path, bytes, dialect, wanted)?)));
    };
    let names: Vec<String> = sheets.iter().map(|sheet| format!("“{}”", sheet.name)).collect();
    if let Some(missing) = dialect.sheets.iter().find(|name| !sheets.iter().any(|sheet| sheet.name == **name)) {
        let problem = format!("there is no sheet “{missing}”");
        return Err(Error::input(Place::file(path), problem, format!("the sheets are {}", shortened(&names.join(", ")))));
    }
    let mut document = Document { source, format, tables: Vec::new(), notes: Vec::new() };
    for sheet in sheets {
        let asked = dialect.sheets.contains(&sheet.name);
        let reason = match () {
            () if !dialect.sheets.is_empty() && !asked => "was not asked for",
            () if !sheet.visible && !asked => "is hidden",
            () if sheet.rows.is_empty() => "is empty",
            () => {
                document.tables.push(headed(path, sheet, dialect, wanted));
                continue;
            }
        };
        document.notes.push(format!("sheet “{}” {reason}, and was passed over", sheet.name));
    }
    Ok(document)
}

fn headed(path: &Path, sheet: Sheet, dialect: &Dialect, wanted: &dyn Fn(&[String]) -> bool) -> Result<Headed, Error> {
    let place = || Place::file(path).sheet(Some(&sheet.name));
    let texts = |row: &Row| row.cells.iter().map(|cell| cell.text.clone()).collect::<Vec<_>>();
    let preview: Vec<(usize, Vec<String>)> = sheet.rows.iter().take(2 * header::SEARCHED).map(|row| (row.line, texts(row))).collect();
    let Some(found) = header::locate(&preview, dialect.header_row, wanted) else {
        return Err(Error::input(place(), "the row that was told to be the header is empty", "correct header_row"));
    };
    let titles = header::titles(&preview, &found);
    let mut header = found.names;
    while header.last().is_some_and(String::is_empty) {
        header.pop();
    }
    if MOST_COLUMNS < header.len() {
        return Err(Error::input(place(), format!("{} columns", header.len()), format!("at most {MOST_COLUMNS} are read")));
    }
    let mut table = Headed {
        file: path.to_path_buf(),
        sheet: Some(sheet.name.clone()),
        encoding: None,
        separator: None,
        header_line: preview[found.at].0,
        titles,
        units: Vec::new(),
        rows: sheet.rows.into_iter().skip(found.at + 1).collect(),
        quarantine: Vec::new(),
        notes: Vec::new(),
        header,
    };
    let width = table.header.len();
    let beside: usize = table.rows.iter().map(|row| row.cells.iter().skip(width).filter(|cell| !cell.is_empty()).count()).sum();
    if 0 < beside {
        table.notes.push(format!("{beside} cell(s) to the right of the table were not used"));
    }
    table.rows.iter_mut().for_each(|row| row.cells.truncate(width));
    table.rows.retain(|row| row.cells.iter().any(|cell| !cell.is_empty()));
    header::finish(table)
}
