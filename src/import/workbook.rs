//! Workbooks: XLSX, XLS and ODS → the cells of every sheet, as values; formulas are never evaluated, only what they last gave is read.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use calamine::{Data, DataRef, Dimensions, ExcelDateTime, Ods, Range, Reader, SheetType, SheetVisible, Xls, Xlsx};

use super::archive::{self, Archive};
use super::cells::{Cell, MOST_CELLS, Row, one_line};
use super::expansion;

/// A sheet of a workbook.
#[derive(Debug)]
pub(super) struct Sheet {
    pub name: String,
    pub visible: bool,
    /// Rows that have anything in them.
    pub rows: Vec<Row>,
}

/// XLSX or ODS, by the parts of the archive.
///
/// # Errors
/// The problem, as a sentence.
pub(super) fn zipped(bytes: &[u8]) -> Result<(&'static str, Vec<Sheet>), String> {
    let archive = archive::repack(bytes)?;
    let xlsx = archive.parts.iter().any(|(name, _)| name.starts_with("xl/"));
    match archive.part("content.xml") {
        _ if xlsx => Ok(("XLSX", guarded(|| xlsx_sheets(archive))?)),
        Some(content) => {
            too_many(expansion::of_ods(content))?;
            Ok(("ODS", guarded(|| ods_sheets(archive))?))
        }
        None => Err("this is an archive, and no workbook is in it".into()),
    }
}

/// XLS.
///
/// # Errors
/// The problem, as a sentence.
pub(super) fn compound(bytes: Vec<u8>) -> Result<Vec<Sheet>, String> {
    // A workbook with a password is wrapped into a compound file too.
    let encrypted: Vec<u8> = "EncryptedPackage".encode_utf16().flat_map(u16::to_le_bytes).collect();
    if bytes.windows(encrypted.len()).any(|window| window == encrypted) {
        return Err("the workbook is protected by a password".into());
    }
    too_many(expansion::of_xls(&bytes)?)?;
    guarded(|| {
        let mut workbook = Xls::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
        let sheets = visible_worksheets(workbook.sheets_metadata());
        let read = |(name, visible): (String, bool)| {
            let range = workbook.worksheet_range(&name).map_err(|e| e.to_string())?;
            let merged = workbook.merge_cells_by_sheet_name(&name).unwrap_or_default();
            Ok(Sheet { rows: rows(dense(range), &merged)?, name, visible })
        };
        sheets.into_iter().map(read).collect()
    })
}

fn too_many(cells: u64) -> Result<(), String> {
    match cells <= MOST_CELLS as u64 {
        true => Ok(()),
        false => Err(format!("a sheet spans {cells} cells; at most {MOST_CELLS} are read")),
    }
}

/// A damaged workbook may break the crate that reads it; that is a fault of the file.
fn guarded(read: impl FnOnce() -> Result<Vec<Sheet>, String>) -> Result<Vec<Sheet>, String> {
    let read = catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| Err("it is damaged".into()));
    read.map_err(|why| format!("the workbook cannot be read ({})", one_line(&why)))
}

fn visible_worksheets(sheets: &[calamine::Sheet]) -> Vec<(String, bool)> {
    let worksheets = sheets.iter().filter(|sheet| sheet.typ == SheetType::WorkSheet);
    worksheets.map(|sheet| (sheet.name.clone(), sheet.visible == SheetVisible::Visible)).collect()
}

fn xlsx_sheets(archive: Archive) -> Result<Vec<Sheet>, String> {
    let mut workbook = Xlsx::new(Cursor::new(archive.bytes)).map_err(|e| e.to_string())?;
    let mut sheets = Vec::new();
    for (name, visible) in visible_worksheets(workbook.sheets_metadata()) {
        let merged = workbook.merge_cells_by_sheet_name(&name).unwrap_or_default();
        // Cell by cell: two cells in opposite corners must not ask for the rectangle between them.
        let mut reader = workbook.worksheet_cells_reader(&name).map_err(|e| e.to_string())?;
        let mut cells = Vec::new();
        while let Some(cell) = reader.next_cell().map_err(|e| e.to_string())? {
            let place = cell.get_position();
            let found = match cell.get_value() {
                DataRef::Empty => continue,
                DataRef::Int(value) => Cell::number(*value as f64),
                DataRef::Float(value) => Cell::number(*value),
                DataRef::String(text) => Cell::text(text),
                DataRef::SharedString(text) => Cell::text(text),
                DataRef::Bool(value) => Cell::text(&value.to_string()),
                DataRef::DateTime(date) => Cell::text(&spelt(date)),
                DataRef::DateTimeIso(text) | DataRef::DurationIso(text) => Cell::text(text),
                DataRef::Error(error) => Cell::text(&error.to_string()),
            };
            cells.push((place, found));
            too_many(cells.len() as u64)?;
        }
        sheets.push(Sheet { rows: rows(cells.into_iter(), &merged)?, name, visible });
    }
    Ok(sheets)
}

fn ods_sheets(archive: Archive) -> Result<Vec<Sheet>, String> {
    let mut workbook = Ods::new(Cursor::new(archive.bytes)).map_err(|e| e.to_string())?;
    let sheets = visible_worksheets(workbook.sheets_metadata());
    let read = |(name, visible): (String, bool)| {
        let range = workbook.worksheet_range(&name).map_err(|e| e.to_string())?;
        Ok(Sheet { rows: rows(dense(range), &[])?, name, visible })
    };
    sheets.into_iter().map(read).collect()
}

fn dense(range: Range<Data>) -> impl Iterator<Item = ((u32, u32), Cell)> {
    let (first_row, first_column) = range.start().unwrap_or_default();
    let used: Vec<_> = range
        .used_cells()
        .map(|(row, column, value)| {
            let cell = match value {
                Data::Int(value) => Cell::number(*value as f64),
                Data::Float(value) => Cell::number(*value),
                Data::String(text) | Data::DateTimeIso(text) | Data::DurationIso(text) => Cell::text(text),
                Data::Bool(value) => Cell::text(&value.to_string()),
                Data::DateTime(date) => Cell::text(&spelt(date)),
                Data::Error(error) => Cell::text(&error.to_string()),
                Data::Empty => Cell::default(),
            };
            ((first_row + row as u32, first_column + column as u32), cell)
        })
        .collect();
    used.into_iter()
}

/// A date, so that a number that a spreadsheet turned into one is seen for what it is.
fn spelt(date: &ExcelDateTime) -> String {
    let (year, month, day, hour, minute, ..) = date.to_ymd_hms_milli();
    if date.is_duration() { format!("the time {hour}:{minute:02}") } else { format!("the date {year}-{month:02}-{day:02}") }
}

/// Cells in any order → rows; a cell that is merged over several rows stands in each of them.
fn rows(cells: impl Iterator<Item = ((u32, u32), Cell)>, merged: &[Dimensions]) -> Result<Vec<Row>, String> {
    let mut rows: BTreeMap<u32, BTreeMap<u32, Cell>> = BTreeMap::new();
    for ((row, column), cell) in cells.filter(|(_, cell)| !cell.is_empty()) {
        rows.entry(row).or_default().insert(column, cell);
    }
    for area in merged.iter().filter(|area| area.start.0 < area.end.0) {
        let Some(cell) = rows.get(&area.start.0).and_then(|row| row.get(&area.start.1)).cloned() else { continue };
        // Only rows that have something else in them: the others are no rows of a table.
        let below: Vec<u32> = rows.range(area.start.0 + 1..=area.end.0).map(|(&row, _)| row).collect();
        for row in below {
            rows.entry(row).or_default().entry(area.start.1).or_insert_with(|| cell.clone());
        }
    }
    let mut total = 0_u64;
    let mut found = Vec::with_capacity(rows.len());
    for (row, columns) in rows {
        let width = columns.keys().last().map_or(0, |&last| last as usize + 1);
        total += width as u64;
        too_many(total)?;
        let mut cells = vec![Cell::default(); width];
        columns.into_iter().for_each(|(column, cell)| cells[column as usize] = cell);
        found.push(Row { line: row as usize + 1, cells });
    }
    Ok(found)
}
