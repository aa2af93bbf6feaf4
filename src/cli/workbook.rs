//! The workbook of `hemline init --workbook`: instructions, the design, and empty tables for the outlines, to be filled in and imported.

use std::path::Path;

use rust_xlsxwriter::{
    DataValidation, DataValidationRule, DocProperties, ExcelDateTime, Format, FormatAlign, FormatBorder, Workbook, Worksheet, XlsxError,
};

use crate::error::Error;

/// Where the outlines are written down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outlines {
    /// One sheet for all, with a column for the run.
    Long,
    /// One sheet for each run, named like it.
    Sheets,
}

/// What the workbook is to hold.
pub(super) struct Contents<'a> {
    /// Columns of the design.
    pub columns: Vec<&'a str>,
    /// Cells of the design, one row per run, the run first; empty where the laboratory fills in.
    pub design: &'a [Vec<Option<f64>>],
    /// Columns of the design that hold a level.
    pub factors: std::ops::Range<usize>,
    pub outlines: Outlines,
    /// The folder of the campaign, as the instructions name it.
    pub campaign: &'a str,
}

/// The last row of an XLSX sheet, counted from 0; validation reaches down to it.
const LAST_ROW: u32 = 1_048_575;

/// Writes the workbook.
///
/// # Errors
/// [`Error::Output`] if it cannot be written.
pub(super) fn write(path: &Path, contents: &Contents) -> Result<(), Error> {
    let failed = |why: String| Error::Output { what: path.display().to_string(), why };
    let bytes = bytes(contents).map_err(|e| failed(e.to_string()))?;
    std::fs::write(path, bytes).map_err(|e| failed(e.to_string()))
}

fn bytes(contents: &Contents) -> Result<Vec<u8>, XlsxError> {
    let mut workbook = Workbook::new();
    // No clock: the same call gives the same workbook.
    workbook.set_properties(&DocProperties::new().set_creation_datetime(&ExcelDateTime::from_ymd(2000, 1, 1)?));
    let header = Format::new().set_bold().set_background_color("#DCE6F1").set_border_bottom(FormatBorder::Thin);
    instructions(workbook.add_worksheet(), contents)?;
    design(workbook.add_worksheet(), contents, &header)?;
    match contents.outlines {
        Outlines::Long => outline(workbook.add_worksheet(), "Profiles", &["run", "x_cm", "y_cm", "weight"], &header)?,
        Outlines::Sheets => {
            for row in contents.design {
                let run = row.first().copied().flatten().unwrap_or_default();
                outline(workbook.add_worksheet(), &format!("run {run}"), &["x_cm", "y_cm", "weight"], &header)?;
            }
        }
    }
    workbook.save_to_buffer()
}

fn instructions(sheet: &mut Worksheet, contents: &Contents) -> Result<(), XlsxError> {
    sheet.set_name("Instructions")?;
    sheet.set_column_width(0, 110)?;
    let place = match contents.outlines {
        Outlines::Long => {
            "Sheet “Profiles”: one row per point of the hem seen from above. The column “run” says which run the point belongs to."
        }
        Outlines::Sheets => {
            "Sheets “run 1”, “run 2” …: one row per point of the hem seen from above. A sheet that stays empty is passed over."
        }
    };
    let lines = [
        "How to fill in this workbook".to_owned(),
        "1. Sheet “Design”: the runs are laid out in random order; carry them out in this order. −1 and 1 are the low and the high level of a factor.".into(),
        "    Fill in what was measured on each cloth; leave empty what was not. Add a row for a centre point with 0 in all factors.".into(),
        format!("2. {place}"),
        "    At least 12 points round the whole hem, in any order; centre and rotation do not matter. The header says the unit: x_cm may become x_mm.".into(),
        "    Instead of x_cm and y_cm the columns may be angle_deg and radius_cm. The column “weight” is optional: leave it empty where all points count alike.".into(),
        "3. campaign.toml, beside this workbook: fill in the lines marked with an arrow.".into(),
        format!("4. Look at how it will be read:   hemline import {0}/workbook.xlsx --into {0} --dry-run", contents.campaign),
        format!("    Take it over:                          hemline import {0}/workbook.xlsx --into {0}", contents.campaign),
        format!("    Analyse:                                  hemline run {}", contents.campaign),
        "    After a correction here, import again: it takes the place of what was imported before. Nothing of this workbook is changed.".into(),
    ];
    let title = Format::new().set_bold().set_font_size(14);
    let text = Format::new().set_text_wrap().set_align(FormatAlign::Top);
    for (row, line) in lines.iter().enumerate() {
        sheet.write_string_with_format(row as u32, 0, line, if row == 0 { &title } else { &text })?;
    }
    Ok(())
}

fn design(sheet: &mut Worksheet, contents: &Contents, header: &Format) -> Result<(), XlsxError> {
    sheet.set_name("Design")?;
    head(sheet, &contents.columns, header)?;
    for (r, row) in contents.design.iter().enumerate() {
        for (c, value) in row.iter().enumerate() {
            if let Some(value) = value {
                sheet.write_number(r as u32 + 1, c as u16, *value)?;
            }
        }
    }
    let level = DataValidation::new().allow_list_strings(&["-1", "0", "1"])?.set_error_message("−1, 1, or 0 for a centre point")?;
    let positive = positive("a positive number, or empty where it was not measured")?;
    let (first, last) = (contents.factors.start as u16, contents.factors.end as u16 - 1);
    sheet.add_data_validation(1, first, LAST_ROW, last, &level)?;
    if usize::from(last) + 1 < contents.columns.len() {
        sheet.add_data_validation(1, last + 1, LAST_ROW, contents.columns.len() as u16 - 1, &positive)?;
    }
    Ok(())
}

fn outline(sheet: &mut Worksheet, name: &str, columns: &[&str], header: &Format) -> Result<(), XlsxError> {
    sheet.set_name(name)?;
    head(sheet, columns, header)?;
    let weight = columns.len() as u16 - 1;
    let number = DataValidation::new()
        .allow_decimal_number(DataValidationRule::Between(-1e6, 1e6))
        .set_error_message("a number; if it is one and is refused, check the decimal mark")?;
    sheet.add_data_validation(1, weight - 2, LAST_ROW, weight - 1, &number)?;
    sheet.add_data_validation(1, weight, LAST_ROW, weight, &positive("a positive number, or the whole column empty")?)?;
    Ok(())
}

fn positive(message: &str) -> Result<DataValidation, XlsxError> {
    DataValidation::new().allow_decimal_number(DataValidationRule::GreaterThan(0.0)).set_error_message(message)
}

fn head(sheet: &mut Worksheet, columns: &[&str], header: &Format) -> Result<(), XlsxError> {
    for (c, name) in columns.iter().enumerate() {
        sheet.write_string_with_format(0, c as u16, *name, header)?;
        sheet.set_column_width(c as u16, name.chars().count().max(8) as f64 + 2.0)?;
    }
    sheet.set_freeze_panes(1, 0)?;
    Ok(())
}
