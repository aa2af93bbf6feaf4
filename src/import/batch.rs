//! A Parquet file too large for memory: which rows hold which profile, and the profiles of some rows at a time.
//!
//! A table with a row per point, the rows of a profile together. Nothing is kept between two calls but where the columns and row groups are.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use polars::io::parquet::metadata::FileMetadataRef;
use polars::prelude::{AnyValue, Column, DataFrame, DataType, ParallelStrategy, ParquetReader, PolarsError, SerReader};

use super::cells::{Headed, Row, one_line, shortened};
use super::column::{self, Quantity};
use super::columnar;
use super::dialect::Dialect;
use super::header;
use super::layout::{self, Miss, Points, radians};
use super::source::fnv_1a;
use crate::error::{Error, Place};
use crate::experiment::{DrapeProfile, Point, Quarantined, Source};

/// Rows that show how the columns are to be read.
const SAMPLE_ROWS: usize = 100;
/// Stretches of fewer rows than this on average are no outlines, but points in another order.
const FEWEST_ROWS: usize = 3;
/// The digest samples so many blocks of so many bytes, evenly over the file, besides the footer.
const BLOCKS: (u64, usize) = (64, 1 << 16);

const CORRECT: &str = "the point was set aside; correct it or delete the row";

/// An open file, understood.
pub struct Batch {
    path: PathBuf,
    metadata: FileMetadataRef,
    /// Column of the profile's name; without one the file is one profile, `name`.
    profile: Option<String>,
    name: String,
    coordinates: Coordinates,
    weight: Option<String>,
    /// Bytes of the file, and a digest of its footer and of a sample of its blocks.
    pub source: Source,
    /// How the columns are read, in a sentence.
    pub reading: String,
}

enum Coordinates {
    /// Columns and metres per unit.
    Cartesian { x: String, y: String, metres: f64 },
    /// Radians come by `unit`.
    Polar { angle: String, radius: String, metres: f64, unit: super::dialect::AngleUnit, clockwise: bool },
}

/// Successive rows of one profile.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stretch {
    /// Empty for leading rows that name no profile.
    pub name: String,
    /// 0 = the first row of the file.
    pub rows: Range<usize>,
}

/// One profile of some rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    pub name: String,
    /// m.
    pub profile: DrapeProfile,
    /// One per point of the profile, or none.
    pub weights: Option<Vec<f64>>,
}

impl Batch {
    /// Opens a Parquet file and finds out how its columns are to be read.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read; [`Error::Input`] if it is not Parquet, damaged, or not a table with a row per point.
    pub fn open(path: &Path, dialect: &Dialect) -> Result<Batch, Error> {
        let mut file = File::open(path).map_err(|e| Error::file(path, e))?;
        let source = digest(path, &mut file)?;
        let metadata = guarded(path, || ParquetReader::new(&mut file).get_metadata().map(Arc::clone))?;
        let sample = frame(path, &metadata, 0..SAMPLE_ROWS.min(metadata.num_rows), None)?;
        let header: Vec<String> = sample.columns().iter().map(|c| c.name().trim().to_owned()).collect();
        let exact = |c: usize| sample.columns()[c].name().to_string();
        let rows = (0..sample.height())
            .map(|r| Row { line: r + 1, cells: sample.columns().iter().map(|c| columnar::cell(value(c, r))).collect() });
        let table = header::finish(Headed {
            file: path.to_path_buf(),
            sheet: None,
            encoding: None,
            separator: None,
            header_line: 1,
            header,
            units: Vec::new(),
            titles: Vec::new(),
            rows: rows.collect(),
            quarantine: Vec::new(),
            notes: Vec::new(),
        })?;
        let plan = layout::find(&table, dialect).map_err(|miss| match miss {
            Miss::Foreign(error) | Miss::Fault(error) => error,
        })?;
        let refuse = |problem: String, remedy: &str| Error::input(Place::file(path), problem, remedy);
        let coordinates = match plan.points {
            Points::Cartesian { x, y } => Coordinates::Cartesian { x: exact(x), y: exact(y), metres: plan.metres },
            Points::Polar { angle, radius } => {
                let unit = plan.angle_unit.or(dialect.angle).ok_or_else(|| refuse("the angle has no unit".into(), layout::UNTOLD_ANGLE))?;
                Coordinates::Polar { angle: exact(angle), radius: exact(radius), metres: plan.metres, unit, clockwise: plan.clockwise }
            }
            _ => return Err(refuse("the table has no row per point".into(), "a large table has columns profile, x_cm and y_cm")),
        };
        // Whether it is empty throughout only all rows can tell: each profile decides for itself.
        let weight = table.header.iter().position(|name| column::named(name).is_some_and(|n| n.quantity == Quantity::Weight)).map(exact);
        let numeric = coordinates.columns().into_iter().chain(weight.as_deref());
        for name in numeric {
            let column = sample.column(name).map_err(|e| refuse(one_line(&e.to_string()), "write it again"))?;
            if !column.dtype().is_primitive_numeric() && !column.dtype().is_null() {
                return Err(refuse(format!("column “{}” does not hold numbers", shortened(name)), "write it as numbers (float64)"));
            }
        }
        let [first, second] = coordinates.columns();
        let mut reading = format!("columns “{first}” and “{second}” in {}", plan.unit);
        if let Some(weight) = &weight {
            reading.push_str(&format!(", weights from “{weight}”"));
        }
        Ok(Batch {
            path: path.to_path_buf(),
            profile: plan.profile.map(exact),
            name: path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default(),
            metadata,
            coordinates,
            weight,
            source,
            reading,
        })
    }

    /// Rows of the file.
    pub fn rows(&self) -> usize {
        self.metadata.num_rows
    }

    /// Ranges of rows for one unit of work each, ascending: row groups, small ones together, large ones in equal slices of at
    /// most `most` rows.
    pub fn units(&self, most: usize) -> Vec<Range<usize>> {
        let mut units: Vec<Range<usize>> = Vec::new();
        let mut first = 0;
        for group in &self.metadata.row_groups {
            let (rows, end) = (group.num_rows(), first + group.num_rows());
            match units.last_mut() {
                Some(last) if end - last.start <= most => last.end = end,
                _ => {
                    let slices = rows.div_ceil(most);
                    units.extend((0..slices).map(|i| first + rows * i / slices..first + rows * (i + 1) / slices));
                }
            }
            first = end;
        }
        units
    }

    /// Which rows hold which profile, within a range. A row that names none belongs to the stretch that it stands in.
    ///
    /// # Errors
    /// [`Error::Input`] if the file is damaged, or the rows of a profile do not stand together.
    pub fn stretches(&self, rows: Range<usize>) -> Result<Vec<Stretch>, Error> {
        let mut found: Vec<Stretch> = Vec::new();
        let Some(column) = &self.profile else {
            return Ok(vec![Stretch { name: self.name.clone(), rows }]);
        };
        let frame = frame(&self.path, &self.metadata, rows.clone(), Some(&[column]))?;
        for (offset, name) in changes(&frame.columns()[0]) {
            let at = rows.start + offset;
            if let Some(last) = found.last_mut() {
                last.rows.end = at;
            } else if rows.start < at {
                found.push(Stretch { name: String::new(), rows: rows.start..at });
            }
            found.push(Stretch { name, rows: at..rows.end });
        }
        if found.is_empty() {
            found.push(Stretch { name: String::new(), rows: rows.clone() });
        }
        if 100 < found.len() && rows.len() < FEWEST_ROWS * found.len() {
            let problem = format!("the rows of a profile do not stand together: {} stretches in {} rows", found.len(), rows.len());
            return Err(Error::input(Place::file(&self.path).row(rows.start + 1).column(column), problem, "sort the rows by profile"));
        }
        Ok(found)
    }

    /// Reads the profiles of successive stretches: those that can be used, and what was set aside, by row.
    ///
    /// # Errors
    /// [`Error::Input`] if the file is damaged.
    pub fn read(&self, stretches: &[Stretch]) -> Result<(Vec<Outline>, Vec<Quarantined>), Error> {
        let (Some(first), Some(last)) = (stretches.first(), stretches.last()) else { return Ok((vec![], vec![])) };
        let rows = first.rows.start..last.rows.end;
        let columns: Vec<&String> = self.profile.iter().chain(self.coordinates.columns_owned()).chain(&self.weight).collect();
        let frame = frame(&self.path, &self.metadata, rows.clone(), Some(&columns))?;
        let column = |name: &str| frame.column(name).map_err(|e| self.damaged(&e.to_string()));
        let names = self.profile.as_deref().map(column).transpose()?;
        let unnamed = names.is_some_and(|c| 0 < c.null_count() || stretches.iter().any(|s| s.name.is_empty()) || c.dtype().is_string());
        let [a, b] = self.coordinates.columns();
        let coordinates = [(a, column(a)?), (b, column(b)?)];
        let values = [numbers(coordinates[0].1).map_err(|e| self.damaged(&e))?, numbers(coordinates[1].1).map_err(|e| self.damaged(&e))?];
        let weight = self.weight.as_deref().map(|name| Ok::<_, Error>((name, column(name)?))).transpose()?;
        let weights = weight.map(|(_, c)| numbers(c).map_err(|e| self.damaged(&e))).transpose()?;
        let mut outlines = Vec::with_capacity(stretches.len());
        let mut quarantine = Vec::new();
        let (mut points, mut lines, mut point_weights) = (Vec::new(), Vec::new(), Vec::new());
        for stretch in stretches {
            points.clear();
            lines.clear();
            point_weights.clear();
            let here = stretch.rows.start - rows.start..stretch.rows.end - rows.start;
            let weighed = weights.as_ref().filter(|w| here.clone().any(|r| !w[r].is_nan()));
            for row in here {
                let line = rows.start + row + 1;
                let name = stretch.name.as_str();
                if let (true, Some(names)) = (unnamed, names)
                    && columnar::cell(value(names, row)).is_empty()
                {
                    if coordinates.iter().any(|(_, c)| !matches!(value(c, row), AnyValue::Null)) {
                        let problem = format!("column “{}” is empty", shortened(names.name()));
                        quarantine.push(self.fault(None, line, "", problem, "name the profile that this point belongs to"));
                    }
                    continue;
                }
                let (first, second) = (values[0][row], values[1][row]);
                let mut good = true;
                for (which, v) in [first, second].into_iter().enumerate() {
                    let polar = which == 1 && matches!(self.coordinates, Coordinates::Polar { .. });
                    if !v.is_finite() || polar && v <= 0.0 {
                        let (title, column) = coordinates[which];
                        quarantine.push(self.bad(name, line, title, column, row));
                        good = false;
                    }
                }
                if let (Some(weighed), Some((title, column))) = (weighed, weight)
                    && !(weighed[row].is_finite() && 0.0 < weighed[row])
                {
                    quarantine.push(self.bad(name, line, title, column, row));
                    good = false;
                }
                if good {
                    points.push(self.coordinates.point(first, second));
                    lines.push(line);
                    point_weights.extend(weighed.map(|w| w[row]));
                }
            }
            if stretch.name.is_empty() {
                continue;
            }
            match DrapeProfile::new(&points) {
                Ok(profile) => {
                    let weights = weighed.map(|_| profile.source_index().iter().map(|&i| point_weights[i]).collect());
                    outlines.push(Outline { name: stretch.name.clone(), profile, weights });
                }
                Err(error) => {
                    let line = lines.first().copied().unwrap_or(stretch.rows.start + 1);
                    let said = format!("{} points", points.len());
                    quarantine.push(self.fault(Some(&stretch.name), line, &said, error.to_string(), "digitize the whole outline"));
                }
            }
        }
        Ok((outlines, quarantine))
    }

    /// A profile whose rows stand in several places: no place holds the whole outline, so none is fitted.
    pub fn scattered(&self, stretch: &Stretch) -> Quarantined {
        let said = format!("{} points", stretch.rows.len());
        let problem = "the rows of this profile stand in several places of the file".to_owned();
        self.fault(
            Some(&stretch.name),
            stretch.rows.start + 1,
            &said,
            problem,
            "sort the rows by profile, or give each outline its own name",
        )
    }

    fn bad(&self, run: &str, line: usize, title: &str, column: &Column, row: usize) -> Quarantined {
        let cell = columnar::cell(value(column, row));
        let wrong = match cell.text.parse::<f64>() {
            _ if cell.is_empty() => "is empty",
            Ok(number) if number.is_finite() => "is not positive",
            _ => "is not a finite number",
        };
        self.fault(Some(run), line, &cell.text, format!("column “{}” {wrong}", shortened(title)), CORRECT)
    }

    fn fault(&self, run: Option<&str>, line: usize, value: &str, problem: String, remedy: &str) -> Quarantined {
        let run = run.filter(|run| !run.is_empty()).map(String::from);
        Quarantined { run, file: self.path.clone(), sheet: None, row: Some(line), value: shortened(value), problem, remedy: remedy.into() }
    }

    fn damaged(&self, why: &str) -> Error {
        damaged(&self.path, why)
    }
}

impl Coordinates {
    fn columns(&self) -> [&str; 2] {
        self.columns_owned().map(String::as_str)
    }

    fn columns_owned(&self) -> [&String; 2] {
        match self {
            Coordinates::Cartesian { x, y, .. } => [x, y],
            Coordinates::Polar { angle, radius, .. } => [angle, radius],
        }
    }

    /// m.
    fn point(&self, first: f64, second: f64) -> Point {
        match self {
            Coordinates::Cartesian { metres, .. } => Point::new(first * metres, second * metres),
            Coordinates::Polar { metres, unit, clockwise, .. } => {
                let (sine, cosine) = radians(first, *unit).sin_cos();
                let radius = second * metres;
                Point::new(radius * cosine, if *clockwise { -radius * sine } else { radius * sine })
            }
        }
    }
}

/// Some rows and columns of the file; only the row groups that hold them are touched, and nothing of the file stays in memory afterwards.
fn frame(path: &Path, metadata: &FileMetadataRef, rows: Range<usize>, columns: Option<&[&String]>) -> Result<DataFrame, Error> {
    let mut part = (**metadata).clone();
    let (mut first, mut offset) = (0, 0);
    part.row_groups.retain(|group| {
        let held = first..first + group.num_rows();
        first = held.end;
        let wanted = rows.start < held.end && held.start < rows.end;
        if held.end <= rows.start {
            offset = held.end;
        }
        wanted
    });
    part.num_rows = part.row_groups.iter().map(|group| group.num_rows()).sum();
    let file = File::open(path).map_err(|e| Error::file(path, e))?;
    guarded(path, || {
        // Row groups are the unit of parallel work, so each is read by one thread.
        let mut reader = ParquetReader::new(file)
            .read_parallel(ParallelStrategy::None)
            .with_slice(Some((rows.start - offset, rows.len())))
            .with_columns(columns.map(|names| names.iter().map(|name| (*name).clone()).collect()));
        reader.set_metadata(Arc::new(part));
        reader.finish()
    })
}

/// Runs a reader; a damaged file may break the crate that reads it, and that is a fault of the file.
fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, PolarsError>) -> Result<T, Error> {
    catch_unwind(AssertUnwindSafe(read)).map_err(|_| damaged(path, "it is damaged"))?.map_err(|e| damaged(path, &e.to_string()))
}

fn damaged(path: &Path, why: &str) -> Error {
    let problem = format!("the file cannot be read as Parquet ({})", one_line(why));
    Error::input(Place::file(path), problem, "write it again; a batch is read from Parquet")
}

fn value(column: &Column, row: usize) -> AnyValue<'_> {
    column.get(row).unwrap_or(AnyValue::Null)
}

/// The numbers of a column; NaN where there is none.
fn numbers(column: &Column) -> Result<Vec<f64>, String> {
    let column = column.cast(&DataType::Float64).map_err(|e| e.to_string())?;
    let values = column.f64().map_err(|e| e.to_string())?;
    if 0 < values.null_count() {
        return Ok(values.iter().map(|v| v.unwrap_or(f64::NAN)).collect());
    }
    let mut numbers = Vec::with_capacity(values.len());
    values.downcast_iter().for_each(|chunk| numbers.extend_from_slice(chunk.values()));
    Ok(numbers)
}

/// The rows at which another name begins, with the name; rows without a name change nothing.
fn changes(column: &Column) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let signed = matches!(column.dtype(), DataType::Int8 | DataType::Int16 | DataType::Int32 | DataType::Int64 | DataType::UInt32);
    if let (true, Ok(cast)) = (signed, column.cast(&DataType::Int64))
        && let Ok(values) = cast.i64()
    {
        let mut last = None;
        for (row, value) in values.iter().enumerate() {
            if value.is_some() && value != last {
                found.push((row, value.unwrap_or_default().to_string()));
                last = value;
            }
        }
    } else if let Ok(values) = column.str() {
        let mut last = "";
        for (row, value) in values.iter().enumerate() {
            // Trimmed only where it changes: most rows repeat the one before.
            if let Some(value) = value
                && value != last
            {
                last = value;
                let name = value.trim();
                if !name.is_empty() && found.last().is_none_or(|(_, before)| before != name) {
                    found.push((row, name.to_owned()));
                }
            }
        }
    } else {
        for row in 0..column.len() {
            let name = columnar::cell(value(column, row)).text;
            if !name.is_empty() && found.last().is_none_or(|(_, before)| *before != name) {
                found.push((row, name));
            }
        }
    }
    found
}

/// Digest of the footer, which has the place, size and range of every column, and of a sample of blocks; a whole campaign is not read for it.
fn digest(path: &Path, file: &mut File) -> Result<Source, Error> {
    let failed = |e| Error::file(path, e);
    let bytes = file.metadata().map_err(failed)?.len();
    let mut taken: Vec<u8> = Vec::new();
    let mut take = |from: u64, count: u64| {
        file.seek(SeekFrom::Start(from))?;
        file.by_ref().take(count).read_to_end(&mut taken)
    };
    let (blocks, size) = BLOCKS;
    if bytes <= blocks * size as u64 {
        take(0, bytes).map_err(failed)?;
    } else {
        for block in 0..blocks {
            take((bytes - size as u64) / (blocks - 1) * block, size as u64).map_err(failed)?;
        }
        let mut tail = [0; 8];
        file.seek(SeekFrom::Start(bytes - 8)).map_err(failed)?;
        file.read_exact(&mut tail).map_err(failed)?;
        let footer = u64::from(u32::from_le_bytes([tail[0], tail[1], tail[2], tail[3]])).min(bytes);
        file.seek(SeekFrom::Start(bytes - footer)).map_err(failed)?;
        file.by_ref().take(footer).read_to_end(&mut taken).map_err(failed)?;
    }
    file.rewind().map_err(failed)?;
    Ok(Source { file: path.to_path_buf(), bytes, digest: format!("{:016x}", fnv_1a(&taken)) })
}
