//! A table as a Parquet file; the only door of `report` to polars.

use polars::prelude::{Column, DataFrame, IntoColumn, NamedFrom, ParquetCompression, ParquetWriter, PolarsError, Series};

use super::csv::{Cell, Table};
use super::tables::{Kind, kind};
use crate::error::Error;

/// The bytes of the file, columns named as in the CSV: text, booleans, 64-bit whole and floating numbers, null where a quantity does not exist.
/// The same table gives the same bytes.
///
/// # Errors
/// [`Error::Output`] if the writer refuses.
pub fn parquet(name: &str, table: &Table) -> Result<Vec<u8>, Error> {
    let failed = |e: PolarsError| Error::Output { what: name.to_string(), why: e.to_string() };
    let columns = (0..table.columns.len()).map(|i| column(table, i)).collect();
    let mut frame = DataFrame::new(table.rows.len(), columns).map_err(failed)?;
    let mut bytes = Vec::new();
    // One thread and one group of rows: the bytes depend on nothing but the table. Snappy is what every reader of Parquet knows.
    ParquetWriter::new(&mut bytes)
        .with_compression(ParquetCompression::Snappy)
        .with_row_group_size(Some(frame.height().max(1)))
        .set_parallel(false)
        .finish(&mut frame)
        .map_err(failed)?;
    Ok(bytes)
}

fn column(table: &Table, index: usize) -> Column {
    let name = table.columns[index].as_str();
    let cells = || table.rows.iter().map(|row| &row[index]);
    let series = match kind(table, index) {
        Kind::Text => Series::new(name.into(), cells().map(text).collect::<Vec<Option<String>>>()),
        Kind::Flag => Series::new(name.into(), cells().map(flag).collect::<Vec<Option<bool>>>()),
        Kind::Whole => Series::new(name.into(), cells().map(whole).collect::<Vec<Option<i64>>>()),
        Kind::Number => Series::new(name.into(), cells().map(number).collect::<Vec<Option<f64>>>()),
    };
    series.into_column()
}

fn text(cell: &Cell) -> Option<String> {
    match cell {
        Cell::Empty => None,
        Cell::Text(text) => Some(text.clone()),
        Cell::Integer(value) => Some(value.to_string()),
        Cell::Number(value) => Some(value.to_string()),
    }
}

fn flag(cell: &Cell) -> Option<bool> {
    text(cell).map(|text| text == "true")
}

fn whole(cell: &Cell) -> Option<i64> {
    if let Cell::Integer(value) = cell { Some(*value) } else { None }
}

fn number(cell: &Cell) -> Option<f64> {
    match cell {
        Cell::Integer(value) => Some(*value as f64),
        Cell::Number(value) => Some(*value).filter(|value| value.is_finite()),
        Cell::Empty | Cell::Text(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use polars::prelude::{ParquetReader, SerReader};

    use super::*;

    fn read(bytes: &[u8]) -> DataFrame {
        ParquetReader::new(std::io::Cursor::new(bytes)).finish().unwrap()
    }

    #[test]
    fn what_is_written_is_read_back_with_its_kinds_and_gaps() {
        let mut table = Table::new(&["run", "m", "p_mm", "overhangs", "notes"]);
        table.push(vec!["1".into(), 5_usize.into(), 131.25.into(), true.into(), Cell::Empty]);
        table.push(vec!["б".into(), Cell::Empty, f64::NAN.into(), Cell::Empty, Cell::Empty]);
        let bytes = parquet("a.parquet", &table).unwrap();
        assert_eq!(bytes, parquet("a.parquet", &table).unwrap());
        let frame = read(&bytes);
        assert_eq!(frame.shape(), (2, 5));
        let kinds: Vec<String> = frame.columns().iter().map(|c| c.dtype().to_string()).collect();
        assert_eq!(kinds, ["str", "i64", "f64", "bool", "str"]);
        assert_eq!(frame.column("run").unwrap().str().unwrap().get(1), Some("б"));
        assert_eq!(frame.column("p_mm").unwrap().f64().unwrap().get(0), Some(131.25));
        assert_eq!(frame.column("p_mm").unwrap().f64().unwrap().get(1), None);
        assert_eq!(frame.column("m").unwrap().null_count(), 1);
    }

    #[test]
    fn a_table_without_rows_keeps_its_columns() {
        let frame = read(&parquet("a.parquet", &Table::new(&["run", "p_mm"])).unwrap());
        assert_eq!(frame.shape(), (0, 2));
    }
}
