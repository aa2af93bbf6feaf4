//! Profile tables: columns x and y in a stated unit, and optionally the profile each point belongs to → checked profiles.

use std::path::{Path, PathBuf};

use super::delimited::{self, Delimited, shortened};
use super::number::Numbers;
use crate::error::{Error, Place};
use crate::experiment::Quarantined;
use crate::experiment::Source;
use crate::experiment::{DrapeProfile, Point};
use crate::units;

/// One profile of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedProfile {
    /// As the column `profile` has it; the file's stem where there is none.
    pub name: String,
    /// m.
    pub profile: DrapeProfile,
    /// `rows[i]` is the line of the file (1 = the first) that point `i` of the profile came from.
    pub rows: Vec<usize>,
}

/// What a profile table held.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// In order of first appearance.
    pub profiles: Vec<NamedProfile>,
    /// Rows and profiles that were set aside.
    pub quarantine: Vec<Quarantined>,
    pub source: Source,
    /// How the file was read: separator, decimal mark, units, columns not used.
    pub notes: Vec<String>,
}

/// What laboratories call the column that says which profile a point belongs to; the first that is there counts.
const PROFILE_COLUMNS: [&str; 7] = ["profile", "outline", "run", "specimen", "sample", "name", "id"];

/// Reads a table of profiles: columns `x_cm` and `y_cm` (or mm, m, in; also `x [cm]`, `x, mm`, `X (m)`), optionally `profile` (or `outline`, `run`,
/// `specimen`, `sample`, `name`, `id`).
///
/// Separated by comma, semicolon or tab; decimal point or comma. Rows with a fault are set aside; a profile goes on as long as enough points
/// remain. Other columns are left alone.
///
/// # Errors
/// [`Error::File`] if the file cannot be read; [`Error::Input`] if it is no table, if a column is missing or there are several that could be
/// meant, if x and y are in different units, or if it cannot be told whether commas are decimal.
pub fn profiles(path: &Path) -> Result<Table, Error> {
    let table = delimited::read(path)?;
    let coordinates = Coordinates::find(path, &table)?;
    let numbers = table.numbers(&[coordinates.x, coordinates.y]);
    if numbers == Numbers::Undecided {
        let problem = "every comma in x and y reads both as a decimal comma and as a separator of thousands";
        return Err(Error::input(Place::file(path), problem, "write decimal points"));
    }
    if numbers == Numbers::Contradictory {
        return Err(Error::input(Place::file(path), "x and y have decimal points and decimal commas", "use one of them throughout"));
    }
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let mut quarantine = table.quarantine.clone();
    let mut groups = Groups::default();
    for row in 0..table.rows() {
        let line = table.lines[row];
        let name = coordinates.profile.map_or(stem.as_str(), |c| table.cell(row, c));
        let (x, y) = (table.cell(row, coordinates.x), table.cell(row, coordinates.y));
        if x.is_empty() && y.is_empty() && (coordinates.profile.is_none() || name.is_empty()) {
            continue;
        }
        let mut fault = |value: &str, problem: String, remedy: &str| {
            quarantine.push(Quarantined {
                run: (!name.is_empty()).then(|| name.to_owned()),
                file: path.to_path_buf(),
                row: Some(line),
                value: shortened(value),
                problem,
                remedy: remedy.into(),
            });
        };
        if name.is_empty() {
            fault("", format!("column “{}” is empty", coordinates.profile_name), "name the profile that this point belongs to");
            continue;
        }
        let group = groups.of(name);
        let mut point = [0.0; 2];
        let mut sound = true;
        for (to, (cell, column)) in point.iter_mut().zip([(x, coordinates.x), (y, coordinates.y)]) {
            match numbers.read(cell) {
                Ok(value) => *to = value * coordinates.metres,
                Err(problem) => {
                    sound = false;
                    fault(
                        cell,
                        format!("column “{}” {problem}", table.header[column]),
                        "the point was set aside; correct it or delete the row",
                    );
                }
            }
        }
        if sound {
            group.points.push(Point::new(point[0], point[1]));
            group.lines.push(line);
        }
    }
    if groups.list.is_empty() {
        return Err(Error::input(Place::file(path), "the table has no rows", "one row per point of the outline is needed"));
    }
    let mut profiles = Vec::new();
    for Group { name, points, lines } in groups.list {
        match DrapeProfile::new(&points) {
            Ok(profile) => {
                let rows = profile.source_index().iter().map(|&i| lines[i]).collect();
                profiles.push(NamedProfile { name, profile, rows });
            }
            Err(error) => quarantine.push(refused(name, path.to_path_buf(), &lines, &error)),
        }
    }
    quarantine.sort_by_key(|q| q.row);
    let notes = notes(&table, &coordinates, numbers);
    Ok(Table { profiles, quarantine, source: table.source, notes })
}

fn refused(name: String, file: PathBuf, lines: &[usize], error: &Error) -> Quarantined {
    Quarantined {
        run: Some(name),
        file,
        row: lines.first().copied(),
        value: format!("{} points", lines.len()),
        problem: error.to_string(),
        remedy: "digitize the whole outline".into(),
    }
}

fn notes(table: &Delimited, coordinates: &Coordinates, numbers: Numbers) -> Vec<String> {
    let separator = match table.separator {
        '\t' => "tab",
        ';' => "semicolon",
        _ => "comma",
    };
    let mark = if numbers == Numbers::Comma { "comma" } else { "point" };
    let (x, y) = (&table.header[coordinates.x], &table.header[coordinates.y]);
    let mut notes = vec![format!("columns “{x}” and “{y}” in {}, separator {separator}, decimal {mark}", coordinates.unit)];
    let used = |c: usize| c == coordinates.x || c == coordinates.y || Some(c) == coordinates.profile;
    let unused: Vec<String> = (0..table.header.len()).filter(|&c| !used(c)).map(|c| format!("“{}”", table.header[c])).collect();
    if !unused.is_empty() {
        notes.push(format!("not used: {}", unused.join(", ")));
    }
    notes
}

/// Points of one profile while the table is read.
struct Group {
    name: String,
    points: Vec<Point>,
    lines: Vec<usize>,
}

/// Profiles in order of first appearance.
#[derive(Default)]
struct Groups {
    list: Vec<Group>,
    index: std::collections::BTreeMap<String, usize>,
}

impl Groups {
    fn of(&mut self, name: &str) -> &mut Group {
        let at = match self.index.get(name) {
            Some(&at) => at,
            None => {
                self.list.push(Group { name: name.to_owned(), points: Vec::new(), lines: Vec::new() });
                self.index.insert(name.to_owned(), self.list.len() - 1);
                self.list.len() - 1
            }
        };
        &mut self.list[at]
    }
}

/// Which columns hold what.
struct Coordinates {
    x: usize,
    y: usize,
    profile: Option<usize>,
    profile_name: String,
    unit: String,
    /// Metres per unit.
    metres: f64,
}

impl Coordinates {
    fn find(path: &Path, table: &Delimited) -> Result<Self, Error> {
        let header = &table.header;
        let refuse = |problem: String, remedy: &str| Error::input(Place::file(path).row(table.header_line), problem, remedy);
        let there = || {
            // A file that is no table has a first line of prose.
            const MOST: usize = 12;
            let names: Vec<String> = header.iter().take(MOST).map(|name| format!("“{}”", shortened(name))).collect();
            names.join(", ") + if MOST < header.len() { ", …" } else { "" }
        };
        let mut found: Vec<(usize, String)> = Vec::new();
        for axis in ["x", "y"] {
            let columns: Vec<(usize, Option<String>)> =
                header.iter().enumerate().filter_map(|(c, name)| axis_unit(name, axis).map(|unit| (c, unit))).collect();
            match &columns[..] {
                [] => {
                    let problem = format!("there is no column for {axis}; the columns are {}", there());
                    return Err(refuse(problem, "name the coordinates x_cm and y_cm (or _mm, _m, _in)"));
                }
                [(_, None)] => {
                    let problem = format!("column “{axis}” has no unit");
                    return Err(refuse(problem, "put it into the name: x_cm, y_cm (or _mm, _m, _in)"));
                }
                [(c, Some(unit))] => {
                    if length_unit(unit).is_none() {
                        let problem = format!("column “{}” is in “{unit}”, which is no unit of length known here", header[*c]);
                        return Err(refuse(problem, "use cm, mm, m, um or in"));
                    }
                    found.push((*c, unit.clone()));
                }
                several => {
                    let names: Vec<String> = several.iter().map(|(c, _)| format!("“{}”", header[*c])).collect();
                    return Err(refuse(
                        format!("several columns could be {axis}: {}", names.join(", ")),
                        "keep one x and one y, both in one unit",
                    ));
                }
            }
        }
        let [(x, x_unit), (y, y_unit)] = &found[..] else {
            return Err(refuse("there are no columns x and y".into(), "name them x_cm and y_cm"));
        };
        if length_unit(x_unit) != length_unit(y_unit) {
            let problem = format!("mixed units: column “{}” is in {x_unit}, column “{}” in {y_unit}", header[*x], header[*y]);
            return Err(refuse(problem, "give both coordinates in one unit"));
        }
        let named = |word: &str| header.iter().position(|name| name.trim().eq_ignore_ascii_case(word));
        let profile = PROFILE_COLUMNS.iter().find_map(|word| named(word));
        Ok(Coordinates {
            x: *x,
            y: *y,
            profile,
            profile_name: profile.map(|c| header[c].clone()).unwrap_or_default(),
            unit: x_unit.clone(),
            metres: length_unit(x_unit).unwrap_or(1.0),
        })
    }
}

/// `Some(unit)` if `name` is a column for `axis`: `x_cm`, `X [cm]`, `x, cm`, `x (cm)`, `x/cm`; the unit is `None` for a bare `x`.
fn axis_unit(name: &str, axis: &str) -> Option<Option<String>> {
    let name = name.to_lowercase().replace(['µ', 'μ'], "u");
    let tokens: Vec<&str> = name.split(|c: char| !(c.is_alphanumeric() || c == '"')).filter(|t| !t.is_empty()).collect();
    match tokens[..] {
        [first] if first == axis => Some(None),
        [first, unit] if first == axis => Some(Some(unit.to_owned())),
        _ => None,
    }
}

/// Metres per unit of length as people spell it.
pub(super) fn length_unit(unit: &str) -> Option<f64> {
    let suffix = match unit {
        "inch" | "inches" | "\"" => "in",
        "meter" | "metre" | "meters" | "metres" => "m",
        known @ ("um" | "mm" | "cm" | "m" | "in") => known,
        _ => return None,
    };
    units::factor(suffix)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_a_column_and_its_unit_are_understood() {
        for name in ["x_cm", "X_CM", "x [cm]", "x, cm", "x (cm)", "x/cm", "x cm", "x.cm"] {
            assert_eq!(axis_unit(name, "x"), Some(Some("cm".into())), "{name}");
        }
        assert_eq!(axis_unit("x", "x"), Some(None));
        for name in ["xx_cm", "z_cm", "max x cm", "y_cm", "run"] {
            assert_eq!(axis_unit(name, "x"), None, "{name}");
        }
        assert_eq!(axis_unit("x, µm", "x").flatten().as_deref().and_then(length_unit), Some(1e-6));
    }
}
