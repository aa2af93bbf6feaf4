//! Profile tables: a file of any kind, with the points of one or several outlines in any usual layout → checked profiles.

use std::path::Path;

use super::cells::{Headed, shortened};
use super::dialect::{Decimal, Dialect, Layout};
use super::document;
use super::layout::{self, Miss, Plan, Points};
use super::number::Numbers;
use super::points::{self, Reader};
use super::quarantine::refused;
use crate::error::{Error, Place};
use crate::experiment::Quarantined;
use crate::experiment::Source;
use crate::experiment::{DrapeProfile, Point};

pub use super::document::is_table;

/// One profile of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedProfile {
    /// As the table has it; the name of its sheet, or the file's stem, where there is none.
    pub name: String,
    /// The sheet of a workbook that it came from.
    pub sheet: Option<String>,
    /// m.
    pub profile: DrapeProfile,
    /// `rows[i]` is the line of the file or sheet (1 = the first) that point `i` of the profile came from.
    pub rows: Vec<usize>,
    /// The points as they stand in the file, m, repeats too; point `i` of the profile is `input[profile.source_index()[i]]`.
    pub input: Vec<Point>,
    /// `input_rows[k]` is the line that `input[k]` came from.
    pub input_rows: Vec<usize>,
    /// `weights[k]` is the weight of `input[k]`, > 0; empty where the table has none.
    pub weights: Vec<f64>,
}

impl NamedProfile {
    /// The weight of each point of the profile, in its order; `None` if the table has none.
    pub fn weights_in_order(&self) -> Option<Vec<f64>> {
        (!self.weights.is_empty()).then(|| self.profile.source_index().iter().map(|&k| self.weights[k]).collect())
    }
}

/// How one table of a file was read, for a person to check.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    pub sheet: Option<String>,
    /// `CSV`, `XLSX`, `XLS`, `ODS`, `Parquet` or `Arrow`.
    pub format: &'static str,
    /// Of texts.
    pub encoding: Option<String>,
    /// Of texts: `comma`, `semicolon`, `tab` or `bar`.
    pub separator: Option<&'static str>,
    /// `point` or `comma` where a text says its numbers so; `none` where neither occurs, or the file holds numbers.
    pub decimal: &'static str,
    /// Of lengths, as the table spells it.
    pub unit: String,
    /// `x, y`, or `degrees`, `radians`, `gon` with their direction.
    pub coordinates: String,
    pub layout: Layout,
    pub header_row: usize,
    pub profiles: usize,
    pub points: usize,
    /// Rows, cells and profiles that were set aside.
    pub rejected: usize,
}

/// What a profile table held.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// In order of first appearance.
    pub profiles: Vec<NamedProfile>,
    /// Rows and profiles that were set aside.
    pub quarantine: Vec<Quarantined>,
    pub source: Source,
    /// One per table of the file that holds profiles.
    pub readings: Vec<Reading>,
    /// How the file was read: separator, decimal mark, units, columns not used.
    pub notes: Vec<String>,
}

/// Reads the profiles of a table with nothing told about it: [`read`].
///
/// # Errors
/// Those of [`read`].
pub fn profiles(path: &Path) -> Result<Table, Error> {
    read(path, &Dialect::default())
}

/// Reads the profiles of a CSV, TSV, XLSX, XLS, ODS, Parquet or Arrow file, also `.gz`.
///
/// Columns `x_cm` and `y_cm` (or mm, m, in; also `x [cm]`, `x, mm`, `X (m)`, `радиус, см`), or angle and radius, one row per point, optionally with
/// `profile` (or `outline`, `run`, `specimen`, `sample`, `name`, `id`) and `weight`; or one column per angle and one row per profile; or one row
/// per angle and one column per profile. Units stand in the name of a column or in a row below. What `dialect` does not tell is found out; see
/// [`Table::readings`]. Rows with a fault are set aside; a profile goes on as long as enough points remain. Other columns are left alone.
///
/// # Errors
/// [`Error::File`] if the file cannot be read; [`Error::Input`] if it is no table, beyond the bounds, if a column is missing or there are several
/// that could be meant, if x and y are in different units, or if it cannot be told whether commas are decimal.
pub fn read(path: &Path, dialect: &Dialect) -> Result<Table, Error> {
    let document = document::read(path, dialect, &layout::is_header)?;
    let several = 1 < document.tables.len();
    let mut table =
        Table { profiles: Vec::new(), quarantine: Vec::new(), source: document.source, readings: Vec::new(), notes: document.notes };
    let (mut foreign, mut faults) = (Vec::new(), Vec::new());
    let mut plans: Vec<(Headed, Plan)> = Vec::new();
    for headed in document.tables {
        let planned = headed.map_err(Miss::Fault).and_then(|headed| {
            let plan = layout::find(&headed, dialect)?;
            Ok((headed, plan))
        });
        match planned {
            Ok(found) => plans.push(found),
            Err(Miss::Foreign(error)) => foreign.push(error),
            Err(Miss::Fault(error)) => faults.push(error),
        }
    }
    let only = plans.len() == 1;
    for (headed, plan) in plans {
        let name = fallback_name(path, headed.sheet.as_deref(), only);
        if let Err(error) = one(&mut table, document.format, headed, plan, &name, dialect) {
            faults.push(error);
        }
    }
    if table.readings.is_empty() {
        let nothing = || Error::input(Place::file(path), "the workbook is empty", "one row per point of the outline is needed");
        return Err(faults.into_iter().chain(foreign).next().unwrap_or_else(nothing));
    }
    debug_assert!(several || faults.is_empty());
    for error in foreign {
        if let Error::Input { place, problem, .. } = error {
            table.notes.push(format!("sheet “{}” holds no profiles: {problem}", place.sheet.unwrap_or_default()));
        }
    }
    table.quarantine.extend(faults.into_iter().map(|error| refused(None, path.to_path_buf(), error)));
    Ok(table)
}

/// The name of a profile that has none of its own: its sheet's, unless that is what the program called it and it is the only one.
fn fallback_name(path: &Path, sheet: Option<&str>, only: bool) -> String {
    const UNNAMED: [&str; 6] = ["sheet", "лист", "tabelle", "feuil", "hoja", "foglio"];
    let stem = || {
        let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        match path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz")) {
            true => Path::new(&stem).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or(stem),
            false => stem,
        }
    };
    let unnamed = |sheet: &str| UNNAMED.contains(&sheet.to_lowercase().trim_end_matches(|c: char| c.is_ascii_digit()).trim_end());
    match sheet {
        Some(sheet) if !(only && unnamed(sheet)) => sheet.to_owned(),
        _ => stem(),
    }
}

/// Adds the profiles of one table.
fn one(to: &mut Table, format: &'static str, table: Headed, mut plan: Plan, name: &str, dialect: &Dialect) -> Result<(), Error> {
    let columns = plan.numeric();
    let numbers = settle(&table, &columns, dialect.decimal)?;
    if plan.angle_unit.is_none()
        && let Points::Polar { angle, .. } | Points::Down { angle, .. } = plan.points
    {
        let values: Vec<f64> = (0..table.rows.len()).filter_map(|row| table.number(row, angle, numbers).ok()).collect();
        let refuse = |problem: String| Error::input(table.place().row(table.header_line), problem, layout::UNTOLD_ANGLE);
        plan.angle_unit = Some(layout::by_range(&values).map_err(refuse)?);
    }
    let Reader { groups, mut quarantine, empty, .. } = Reader::read(&table, &plan, numbers, name);
    if groups.is_empty() {
        return Err(Error::input(table.place(), "the table has no rows", "one row per point of the outline is needed"));
    }
    let before = to.profiles.len();
    for points::Group { name, points, lines, weights } in groups {
        let said = format!("{} points", points.len());
        if let Some(other) = to.profiles[..before].iter().find(|other| other.name == name) {
            let problem = format!("there is a profile of this name on the sheet “{}”", other.sheet.clone().unwrap_or_default());
            quarantine.push(table.fault(Some(&name), lines.first().copied(), &said, problem, "give every profile its own name"));
            continue;
        }
        match DrapeProfile::new(&points) {
            Ok(profile) => {
                let rows = profile.source_index().iter().map(|&i| lines[i]).collect();
                to.profiles.push(NamedProfile {
                    name,
                    sheet: table.sheet.clone(),
                    profile,
                    rows,
                    input: points,
                    input_rows: lines,
                    weights,
                });
            }
            Err(error) => {
                quarantine.push(table.fault(Some(&name), lines.first().copied(), &said, error.to_string(), "digitize the whole outline"));
            }
        }
    }
    quarantine.sort_by_key(|q| q.row);
    let found = &to.profiles[before..];
    let reading = Reading {
        sheet: table.sheet.clone(),
        format,
        encoding: table.encoding.clone(),
        separator: table.separator.map(separator_name),
        decimal: decimal_name(&table, &columns, numbers),
        unit: plan.unit.clone(),
        coordinates: plan.coordinates(),
        layout: plan.layout(),
        header_row: table.header_line,
        profiles: found.len(),
        points: found.iter().map(|p| p.input.len()).sum(),
        rejected: quarantine.len(),
    };
    to.notes.extend(notes(&table, &plan, &reading, empty));
    to.readings.push(reading);
    to.quarantine.extend(quarantine);
    Ok(())
}

/// How the numbers of a table are written: as told, or as all of them together say.
fn settle(table: &Headed, columns: &[usize], told: Option<Decimal>) -> Result<Numbers, Error> {
    if let Some(decimal) = told {
        return Ok(Numbers::told(decimal));
    }
    match table.numbers(columns) {
        Numbers::Undecided => {
            let example = Numbers::readings(table.texts(columns));
            let example = example.map(|(cell, comma, thousands)| format!("; “{}” is {comma} or {thousands}", shortened(cell)));
            let problem = "every comma in the coordinates reads both as a decimal comma and as a separator of thousands";
            Err(Error::input(table.place(), format!("{problem}{}", example.unwrap_or_default()), UNTOLD_DECIMAL))
        }
        Numbers::Contradictory => {
            let problem = "the coordinates have decimal points and decimal commas";
            Err(Error::input(table.place(), problem, "use one of them throughout"))
        }
        settled => Ok(settled),
    }
}

const UNTOLD_DECIMAL: &str = "write decimal points; or tell it: decimal = \",\" (or \".\") in [tables] of campaign.toml, --decimal";

fn separator_name(separator: char) -> &'static str {
    match separator {
        '\t' => "tab",
        ';' => "semicolon",
        '|' => "bar",
        _ => "comma",
    }
}

fn decimal_name(table: &Headed, columns: &[usize], numbers: Numbers) -> &'static str {
    if !table.texts(columns).any(|cell| cell.contains(['.', ','])) {
        return "none";
    }
    if numbers == Numbers::Comma { "comma" } else { "point" }
}

fn notes(table: &Headed, plan: &Plan, reading: &Reading, empty: usize) -> Vec<String> {
    let on = table.sheet.as_ref().map(|sheet| format!("sheet “{sheet}”: ")).unwrap_or_default();
    let column = |c: usize| format!("“{}”", shortened(&table.header[c]));
    let columns = match &plan.points {
        Points::Cartesian { x, y } => format!("columns {} and {} in {}", column(*x), column(*y), plan.unit),
        Points::Polar { angle, radius } => {
            format!("columns {} in {} and {} in {}", column(*angle), plan.coordinates(), column(*radius), plan.unit)
        }
        Points::Across(angles) => {
            format!("{} columns named after angles in {}, one row per profile, in {}", angles.len(), plan.coordinates(), plan.unit)
        }
        Points::Down { angle, profiles } => {
            format!("column {} in {}, one column per profile ({}), in {}", column(*angle), plan.coordinates(), profiles.len(), plan.unit)
        }
    };
    let mut how = columns;
    if let Some(encoding) = reading.encoding.as_ref().filter(|name| *name != "UTF-8") {
        how.push_str(&format!(", {encoding}"));
    }
    if let Some(separator) = reading.separator {
        how.push_str(&format!(", separator {separator}"));
    }
    if reading.decimal != "none" {
        how.push_str(&format!(", decimal {}", reading.decimal));
    }
    let mut notes = vec![format!("{on}{how}")];
    if let Some(weight) = plan.weight {
        notes.push(format!("{on}weights of the points from column {}", column(weight)));
    }
    let used = plan.used();
    const MOST: usize = 20;
    let unused: Vec<usize> = (0..table.header.len()).filter(|c| !used.contains(c) && !table.header[*c].is_empty()).collect();
    if !unused.is_empty() {
        let more = if MOST < unused.len() { format!(" and {} more", unused.len() - MOST) } else { String::new() };
        let names: Vec<String> = unused.iter().take(MOST).map(|&c| column(c)).collect();
        notes.push(format!("{on}not used: {}{more}", names.join(", ")));
    }
    if 0 < empty {
        notes.push(format!("{on}{empty} empty cell(s) in the columns of radii hold no point"));
    }
    notes.extend(table.notes.iter().map(|note| format!("{on}{note}")));
    notes
}
