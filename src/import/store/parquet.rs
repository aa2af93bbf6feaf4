//! The tidy Parquet file: one row per point, with where it came from and how it was read.

use std::path::Path;

use polars::prelude::{Column, DataFrame, IntoColumn, NamedFrom, ParquetCompression, ParquetWriter, Series};

use crate::error::{Error, Place};
use crate::import::cells::Headed;
use crate::import::columnar;
use crate::import::number::Numbers;
use crate::import::source;

/// One point.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredPoint {
    /// m.
    pub x: f64,
    /// m.
    pub y: f64,
    pub weight: Option<f64>,
    /// Line of the file or row of the sheet; pictures have none.
    pub row: Option<usize>,
}

/// One profile, and where it came from.
#[derive(Debug, Clone, PartialEq)]
pub struct Stored {
    pub name: String,
    /// Path of the file, with forward slashes; relative to the campaign where it lies in it.
    pub source: String,
    pub sheet: Option<String>,
    /// FNV-1a of the file's bytes, hex.
    pub digest: String,
    /// `CSV`, `XLSX` …, `PNG` ….
    pub format: String,
    pub encoding: Option<String>,
    pub separator: Option<String>,
    pub decimal: Option<String>,
    /// `long`, `rows`, `columns` or `picture`.
    pub layout: String,
    pub coordinates: String,
    /// Of lengths, as the file has it.
    pub unit: String,
    pub points: Vec<StoredPoint>,
}

/// The columns in order; `x_m` and `y_m` have the point, `point` counts from 1.
const COLUMNS: [&str; 16] = [
    "profile",
    "point",
    "x_m",
    "y_m",
    "weight",
    "source",
    "sheet",
    "row",
    "digest",
    "format",
    "encoding",
    "separator",
    "decimal",
    "layout",
    "coordinates",
    "unit",
];

/// The bytes of the file; the same profiles give the same bytes.
pub fn write(profiles: &[Stored]) -> Result<Vec<u8>, Error> {
    let failed = |e: polars::error::PolarsError| Error::Output { what: "the Parquet file".into(), why: e.to_string() };
    let text = |name: &str, of: &dyn Fn(&Stored) -> Option<&str>| -> Column {
        let values: Vec<Option<&str>> = profiles.iter().flat_map(|p| std::iter::repeat_n(of(p), p.points.len())).collect();
        Series::new(name.into(), values).into_column()
    };
    let points = || profiles.iter().flat_map(|p| p.points.iter());
    let counts: Vec<i64> = profiles.iter().flat_map(|p| 1..=p.points.len() as i64).collect();
    let numbers = |name: &str, values: Vec<Option<f64>>| Series::new(name.into(), values).into_column();
    let columns = vec![
        text(COLUMNS[0], &|p| Some(&p.name)),
        Series::new(COLUMNS[1].into(), counts).into_column(),
        numbers(COLUMNS[2], points().map(|p| Some(p.x)).collect()),
        numbers(COLUMNS[3], points().map(|p| Some(p.y)).collect()),
        numbers(COLUMNS[4], points().map(|p| p.weight).collect()),
        text(COLUMNS[5], &|p| Some(&p.source)),
        text(COLUMNS[6], &|p| p.sheet.as_deref()),
        Series::new(COLUMNS[7].into(), points().map(|p| p.row.map(|row| row as i64)).collect::<Vec<_>>()).into_column(),
        text(COLUMNS[8], &|p| Some(&p.digest)),
        text(COLUMNS[9], &|p| Some(&p.format)),
        text(COLUMNS[10], &|p| p.encoding.as_deref()),
        text(COLUMNS[11], &|p| p.separator.as_deref()),
        text(COLUMNS[12], &|p| p.decimal.as_deref()),
        text(COLUMNS[13], &|p| Some(&p.layout)),
        text(COLUMNS[14], &|p| Some(&p.coordinates)),
        text(COLUMNS[15], &|p| Some(&p.unit)),
    ];
    let mut frame = DataFrame::new_infer_height(columns).map_err(failed)?;
    let mut bytes = Vec::new();
    // One thread and one group of rows: the bytes depend on nothing but the rows. Snappy is what every reader of Parquet knows.
    ParquetWriter::new(&mut bytes)
        .with_compression(ParquetCompression::Snappy)
        .with_row_group_size(Some(frame.height().max(1)))
        .set_parallel(false)
        .finish(&mut frame)
        .map_err(failed)?;
    Ok(bytes)
}

/// The profiles of a file that [`write`] wrote, in its order.
///
/// # Errors
/// [`Error::File`] if it cannot be read; [`Error::Input`] if it is another Parquet file.
pub fn read(path: &Path) -> Result<Vec<Stored>, Error> {
    let (bytes, _) = source::read_table(path)?;
    let remedy = "move it away, or name another file under [profiles] in campaign.toml";
    let foreign = || Error::input(Place::file(path), "this Parquet file was not written by `hemline import`", remedy);
    if !bytes.starts_with(b"PAR1") {
        return Err(foreign());
    }
    let table = columnar::read(path, bytes, true)?;
    if table.header != COLUMNS {
        return Err(foreign());
    }
    let mut profiles: Vec<Stored> = Vec::new();
    for row in 0..table.rows.len() {
        let text = |c: usize| table.cell(row, c).to_owned();
        let optional = |c: usize| Some(text(c)).filter(|text| !text.is_empty());
        if table.cell(row, 1) == "1" {
            profiles.push(Stored {
                name: text(0),
                source: text(5),
                sheet: optional(6),
                digest: text(8),
                format: text(9),
                encoding: optional(10),
                separator: optional(11),
                decimal: optional(12),
                layout: text(13),
                coordinates: text(14),
                unit: text(15),
                points: Vec::new(),
            });
        }
        let number = |table: &Headed, c: usize| table.number(row, c, Numbers::Point).ok();
        let (Some(x), Some(y)) = (number(&table, 2), number(&table, 3)) else { return Err(foreign()) };
        let point = StoredPoint { x, y, weight: number(&table, 4), row: table.cell(row, 7).parse().ok() };
        profiles.last_mut().ok_or_else(foreign)?.points.push(point);
    }
    Ok(profiles)
}
