//! Columnar files: Parquet and Arrow (IPC, also called Feather) → a table whose header is the names of the columns.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use polars::prelude::{AnyValue, DataFrame, IpcReader, ParallelStrategy, ParquetReader, PolarsError, SerReader};

use super::cells::{Cell, Headed, MOST_CELLS, MOST_COLUMNS, Row, one_line};
use super::header;
use crate::error::{Error, Place};

/// Parquet, where the file says so; Arrow otherwise.
///
/// # Errors
/// [`Error::Input`] if it is damaged, compressed in a way that is not known here, or too large.
pub(super) fn read(path: &Path, bytes: Vec<u8>, parquet: bool) -> Result<Headed, Error> {
    let refuse = |problem: String| Error::input(Place::file(path), problem, "write it again, or as CSV");
    // A damaged file may break the crate that reads it; that is a fault of the file.
    let frame = catch_unwind(AssertUnwindSafe(|| if parquet { parquet_frame(bytes) } else { arrow_frame(bytes) }))
        .unwrap_or_else(|_| Err("it is damaged".into()))
        .map_err(|why| refuse(format!("the file cannot be read ({})", one_line(&why))))?;
    let header: Vec<String> = frame.columns().iter().map(|column| column.name().trim().to_owned()).collect();
    let mut rows: Vec<Row> = (1..=frame.height()).map(|line| Row { line, cells: Vec::with_capacity(header.len()) }).collect();
    for column in frame.columns() {
        for (r, row) in rows.iter_mut().enumerate() {
            let value = column.get(r).map_err(|e| refuse(one_line(&e.to_string())))?;
            row.cells.push(cell(value));
        }
    }
    header::finish(Headed {
        file: path.to_path_buf(),
        sheet: None,
        encoding: None,
        separator: None,
        header_line: 1,
        header,
        units: Vec::new(),
        titles: Vec::new(),
        rows,
        quarantine: Vec::new(),
        notes: Vec::new(),
    })
}

pub(super) fn cell(value: AnyValue<'_>) -> Cell {
    match value {
        AnyValue::Null => Cell::default(),
        AnyValue::String(text) => Cell::text(text),
        AnyValue::StringOwned(text) => Cell::text(&text),
        AnyValue::Float64(value) => Cell::number(value),
        AnyValue::Float32(value) => Cell::number(value.into()),
        AnyValue::Boolean(value) => Cell::text(&value.to_string()),
        other => match other.extract::<f64>() {
            Some(value) if other.is_primitive_numeric() => Cell::number(value),
            _ => Cell::text(&other.to_string()),
        },
    }
}

fn parquet_frame(bytes: Vec<u8>) -> Result<DataFrame, String> {
    let said = |e: PolarsError| e.to_string();
    // One thread and no cleverness: these are small files, and the result is the same everywhere.
    let mut reader = ParquetReader::new(Cursor::new(bytes)).read_parallel(ParallelStrategy::None);
    let metadata = reader.get_metadata().map_err(said)?.clone();
    bounded(metadata.num_rows, reader.schema().map_err(said)?.len())?;
    // What the columns unfold to is stated in the file; a page that lies about it is bounded by its own 31-bit length.
    let unfolded: u64 = metadata.row_groups.iter().map(|group| group.total_byte_size() as u64).fold(0, u64::saturating_add);
    if super::source::LARGEST_TABLE < unfolded {
        return Err(super::source::too_large("unfolds to more than"));
    }
    reader.finish().map_err(said)
}

fn arrow_frame(bytes: Vec<u8>) -> Result<DataFrame, String> {
    let said = |e: PolarsError| e.to_string();
    let mut reader = IpcReader::new(Cursor::new(bytes));
    bounded(0, reader.schema().map_err(said)?.len())?;
    let frame = reader.finish().map_err(said)?;
    bounded(frame.height(), frame.width())?;
    Ok(frame)
}

fn bounded(rows: usize, columns: usize) -> Result<(), String> {
    if MOST_COLUMNS < columns {
        return Err(format!("{columns} columns; at most {MOST_COLUMNS} are read"));
    }
    if MOST_CELLS < rows.saturating_mul(columns) {
        return Err(format!("{rows} rows of {columns} columns; at most {MOST_CELLS} cells are read"));
    }
    Ok(())
}
