//! The layout of a profile table: which columns hold which coordinates of which profile, in which unit.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use super::cells::{Headed, shortened};
use super::column::{self, Named, PROFILE_COLUMNS, Quantity, length_unit};
use super::dialect::{AngleUnit, Dialect, Layout};
use super::number::Numbers;
use crate::error::Error;
use crate::experiment::profile::FEWEST_POINTS;
use crate::units::{DEGREE, GON};

/// Where the points of a table stand.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Points {
    /// A row per point.
    Cartesian { x: usize, y: usize },
    /// A row per point.
    Polar { angle: usize, radius: usize },
    /// A row per profile; a column and its angle for each point.
    Across(Vec<(usize, f64)>),
    /// A row per angle; a column of radii and its name for each profile.
    Down { angle: usize, profiles: Vec<(usize, String)> },
}

/// A profile table, understood.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plan {
    pub points: Points,
    /// The column that says which profile a row belongs to.
    pub profile: Option<usize>,
    pub weight: Option<usize>,
    /// Unit of length as the table spells it.
    pub unit: String,
    /// Metres per unit of length.
    pub metres: f64,
    /// Of polar tables; `None` where only the range of the angles can tell.
    pub angle_unit: Option<AngleUnit>,
    pub clockwise: bool,
}

impl Plan {
    /// Every column of coordinates and weights.
    pub(super) fn numeric(&self) -> Vec<usize> {
        let mut columns = match &self.points {
            Points::Cartesian { x, y } => vec![*x, *y],
            Points::Polar { angle, radius } => vec![*angle, *radius],
            Points::Across(columns) => columns.iter().map(|(c, _)| *c).collect(),
            Points::Down { angle, profiles } => std::iter::once(*angle).chain(profiles.iter().map(|(c, _)| *c)).collect(),
        };
        columns.extend(self.weight);
        columns
    }

    /// Every column that is read.
    pub(super) fn used(&self) -> BTreeSet<usize> {
        self.numeric().into_iter().chain(self.profile).collect()
    }

    pub(super) fn layout(&self) -> Layout {
        match self.points {
            Points::Cartesian { .. } | Points::Polar { .. } => Layout::Long,
            Points::Across(_) => Layout::Rows,
            Points::Down { .. } => Layout::Columns,
        }
    }

    /// In words: `x, y`, or the unit of the angles and their direction.
    pub(super) fn coordinates(&self) -> String {
        if let Points::Cartesian { .. } = self.points {
            return "x, y".into();
        }
        let unit = match self.angle_unit {
            Some(AngleUnit::Degree) => "degrees",
            Some(AngleUnit::Radian) => "radians",
            Some(AngleUnit::Gon) => "gon",
            None => "angles",
        };
        format!("{unit}{}", if self.clockwise { " clockwise" } else { "" })
    }
}

/// Why a table holds no profiles.
#[derive(Debug)]
pub(super) enum Miss {
    /// It has no coordinates at all: it may be a design, or instructions.
    Foreign(Error),
    /// It has, and something about them is wrong.
    Fault(Error),
}

/// Whether a row of names can be the header of a profile table.
pub(super) fn is_header(names: &[String]) -> bool {
    let has = |quantity| names.iter().any(|name| column::named(name).is_some_and(|n| n.quantity == quantity));
    let filled = names.iter().filter(|name| !name.is_empty()).count();
    (has(Quantity::X) && has(Quantity::Y)) || (has(Quantity::Angle) && 1 < filled) || across(names).is_some()
}

/// Columns named after angles that go once round a hem.
fn across(names: &[String]) -> Option<Across> {
    let mut found = Across { columns: Vec::new(), angle: None, length: None };
    for (c, name) in names.iter().enumerate() {
        let Some((value, angle, length)) = column::angle_of(name) else { continue };
        found.columns.push((c, value));
        found.angle = found.angle.or(angle);
        found.length = found.length.or(length);
    }
    // A row of measured radii is not ascending throughout; a row of angles is.
    let ascending = found.columns.windows(2).all(|pair| pair[0].1 < pair[1].1);
    (FEWEST_POINTS <= found.columns.len() && ascending).then_some(found)
}

struct Across {
    /// Column and angle, as it stands there.
    columns: Vec<(usize, f64)>,
    angle: Option<String>,
    length: Option<String>,
}

/// Finds the layout of a table.
///
/// # Errors
/// [`Miss`], with what the table lacks and how to give it.
pub(super) fn find(table: &Headed, dialect: &Dialect) -> Result<Plan, Miss> {
    let finder = Finder { table, dialect, named: table.header.iter().map(|name| column::named(name)).collect() };
    let has = |quantity| finder.named.iter().flatten().any(|n| n.quantity == quantity);
    let told = dialect.layout;
    let wide = across(&table.header);
    if matches!(told, None | Some(Layout::Long)) && (has(Quantity::X) || has(Quantity::Y)) {
        return finder.cartesian().map_err(Miss::Fault);
    }
    if matches!(told, None | Some(Layout::Long)) && has(Quantity::Radius) {
        return finder.polar().map_err(Miss::Fault);
    }
    if matches!(told, None | Some(Layout::Columns)) && has(Quantity::Angle) {
        return finder.down().map_err(Miss::Fault);
    }
    if let (None | Some(Layout::Rows), Some(wide)) = (told, wide) {
        return finder.across(wide).map_err(Miss::Fault);
    }
    let (lacking, remedy) = match told {
        Some(Layout::Rows) => ("there are no columns named after angles", "name at least twelve columns 0, 10, 20 … in ascending order"),
        Some(Layout::Columns) => ("there is no column for the angle", "name it angle_deg or angle_rad"),
        _ => ("there is no column for x", "name the coordinates x_cm and y_cm (or _mm, _m, _in), or angle_deg and radius_cm"),
    };
    let miss = Error::input(table.place().row(table.header_line), format!("{lacking}; the columns are {}", finder.there()), remedy);
    Err(if told.is_some() { Miss::Fault(miss) } else { Miss::Foreign(miss) })
}

struct Finder<'a> {
    table: &'a Headed,
    dialect: &'a Dialect,
    named: Vec<Option<Named>>,
}

impl Finder<'_> {
    fn refuse(&self, problem: String, remedy: &str) -> Error {
        Error::input(self.table.place().row(self.table.header_line), problem, remedy)
    }

    /// The columns there are; a file that is no table has a first line of prose.
    fn there(&self) -> String {
        const MOST: usize = 12;
        let header = &self.table.header;
        let names: Vec<String> = header.iter().take(MOST).map(|name| format!("“{}”", shortened(name))).collect();
        names.join(", ") + if MOST < header.len() { ", …" } else { "" }
    }

    fn header(&self, column: usize) -> String {
        shortened(&self.table.header[column])
    }

    /// The only column of a quantity.
    fn one(&self, quantity: Quantity, word: &str, remedy: &str) -> Result<usize, Error> {
        let columns: Vec<usize> =
            (0..self.named.len()).filter(|&c| self.named[c].as_ref().is_some_and(|n| n.quantity == quantity)).collect();
        match columns[..] {
            [only] => Ok(only),
            [] => Err(self.refuse(format!("there is no column for {word}; the columns are {}", self.there()), remedy)),
            _ => {
                let names: Vec<String> = columns.iter().map(|&c| format!("“{}”", self.header(c))).collect();
                Err(self.refuse(
                    format!("several columns could be {word}: {}", names.join(", ")),
                    &format!("keep one for {word}, or one x and one y, both in one unit"),
                ))
            }
        }
    }

    fn profile(&self) -> Option<usize> {
        let header = &self.table.header;
        let named = |word: &str| header.iter().position(|name| name.trim().to_lowercase() == word);
        PROFILE_COLUMNS.iter().find_map(|word| named(word))
    }

    fn weight(&self) -> Option<usize> {
        let column = self.named.iter().position(|n| n.as_ref().is_some_and(|n| n.quantity == Quantity::Weight))?;
        // A column that is there to be filled in, and was not, says nothing.
        (0..self.table.rows.len()).any(|row| !self.table.cell(row, column).is_empty()).then_some(column)
    }

    /// The unit that a column states, in its name or in the row of units.
    fn stated(&self, column: usize, in_name: Option<&str>) -> Result<Option<String>, Error> {
        let below = self.table.units[column].as_deref();
        if let (Some(name), Some(below)) = (in_name, below)
            && (length_unit(name), column::angle_unit(name)) != (length_unit(below), column::angle_unit(below))
        {
            let problem = format!("mixed units: column “{}” has {below} in the row of units", self.header(column));
            return Err(self.refuse(problem, "state one unit"));
        }
        Ok(in_name.or(below).map(String::from))
    }

    /// Unit and metres of a column of lengths.
    fn length(&self, column: usize, in_name: Option<&str>) -> Result<(String, f64), Error> {
        let unit = self.stated(column, in_name)?.or_else(|| self.dialect.unit.clone());
        let Some(unit) = unit else {
            let problem = format!("column “{}” has no unit", self.header(column));
            let remedy =
                "put it into the name: x_cm, y_cm (or _mm, _m, _in); or tell it: unit = \"cm\" in [tables] of campaign.toml, --unit cm";
            return Err(self.refuse(problem, remedy));
        };
        let Some(metres) = length_unit(&unit) else {
            let problem = format!("column “{}” is in “{unit}”, which is no unit of length known here", self.header(column));
            return Err(self.refuse(problem, "use cm, mm, m, um or in"));
        };
        Ok((unit, metres))
    }

    fn unit_in_name(&self, column: usize) -> Option<&str> {
        self.named[column].as_ref().and_then(|n| n.unit.as_deref())
    }

    /// Unit of the angles and whether they grow clockwise.
    fn angle(&self, stated: Option<&str>, clockwise: Option<bool>) -> Result<(Option<AngleUnit>, bool), Error> {
        let unit = match stated {
            None => self.dialect.angle,
            Some(unit) => match column::angle_unit(unit).or(self.dialect.angle) {
                Some(unit) => Some(unit),
                None if unit == "grad" => {
                    let problem = "“grad” is a degree to some, and 1/400 of a turn to others".into();
                    return Err(
                        self.refuse(problem, "write deg or gon; or tell it: angle = \"deg\" in [tables] of campaign.toml, --angle deg")
                    );
                }
                None => {
                    let problem = format!("the angle is in “{unit}”, which is no unit of angle known here");
                    return Err(self.refuse(problem, "use deg, rad or gon"));
                }
            },
        };
        Ok((unit, clockwise.or(self.dialect.clockwise).unwrap_or(false)))
    }

    fn plan(&self, points: Points, (unit, metres): (String, f64)) -> Plan {
        Plan { points, profile: self.profile(), weight: self.weight(), unit, metres, angle_unit: None, clockwise: false }
    }

    fn cartesian(&self) -> Result<Plan, Error> {
        let remedy = "name the coordinates x_cm and y_cm (or _mm, _m, _in)";
        let (x, y) = (self.one(Quantity::X, "x", remedy)?, self.one(Quantity::Y, "y", remedy)?);
        let (unit, metres) = self.length(x, self.unit_in_name(x))?;
        let (other, other_metres) = self.length(y, self.unit_in_name(y))?;
        if metres != other_metres {
            let problem =
                format!("mixed units: column “{}” is in {unit}, column “{}” in {other}", self.table.header[x], self.table.header[y]);
            return Err(self.refuse(problem, "give both coordinates in one unit"));
        }
        Ok(self.plan(Points::Cartesian { x, y }, (unit, metres)))
    }

    fn polar(&self) -> Result<Plan, Error> {
        let angle = self.one(Quantity::Angle, "the angle", "name it angle_deg or angle_rad")?;
        let radius = self.one(Quantity::Radius, "the radius", "name it radius_cm (or _mm, _m, _in)")?;
        let length = self.length(radius, self.unit_in_name(radius))?;
        self.with_angle(self.plan(Points::Polar { angle, radius }, length), angle)
    }

    fn with_angle(&self, plan: Plan, column: usize) -> Result<Plan, Error> {
        let stated = self.stated(column, self.unit_in_name(column))?;
        let clockwise = self.named[column].as_ref().and_then(|n| n.clockwise);
        let (angle_unit, clockwise) = self.angle(stated.as_deref(), clockwise)?;
        Ok(Plan { angle_unit, clockwise, ..plan })
    }

    fn down(&self) -> Result<Plan, Error> {
        let angle = self.one(Quantity::Angle, "the angle", "name it angle_deg or angle_rad")?;
        let columns: Vec<usize> = (0..self.named.len())
            .filter(|&c| self.named[c].is_none() && !self.table.header[c].is_empty() && self.holds_numbers(c))
            .collect();
        if columns.is_empty() {
            let problem = format!("there is an angle, but no column of radii; the columns are {}", self.there());
            return Err(self.refuse(problem, "add radius_cm, or one column of radii for each profile, named after it"));
        }
        let mut length: Option<(String, f64)> = None;
        let mut profiles = Vec::new();
        for &c in &columns {
            let (name, unit) = column::name_and_unit(&self.table.header[c]);
            let unit = unit.or_else(|| self.in_titles());
            let found = self.length(c, unit.as_deref())?;
            match &length {
                Some((unit, metres)) if *metres != found.1 => {
                    let problem = format!("mixed units: column “{}” is in {}, the others in {unit}", self.header(c), found.0);
                    return Err(self.refuse(problem, "give all radii in one unit"));
                }
                _ => length = Some(found),
            }
            profiles.push((c, name));
        }
        let length = length.unwrap_or_else(|| unreachable!("there is a column"));
        let plan = Plan { profile: None, weight: None, ..self.plan(Points::Down { angle, profiles }, length) };
        self.with_angle(plan, angle)
    }

    fn across(&self, wide: Across) -> Result<Plan, Error> {
        let first = wide.columns[0].0;
        let unit = wide.length.or_else(|| self.table.units[first].clone().filter(|unit| length_unit(unit).is_some()));
        let unit = unit.or_else(|| self.in_titles()).or_else(|| self.dialect.unit.clone());
        let Some(unit) = unit else {
            let problem = "the columns are named after angles, but the radii have no unit".to_owned();
            let remedy = "write it above the table (radius, cm), in a row of units, or tell it: unit = \"cm\" in [tables] of campaign.toml, --unit cm";
            return Err(self.refuse(problem, remedy));
        };
        let metres = length_unit(&unit).unwrap_or(1.0);
        let (angle_unit, clockwise) = self.angle(wide.angle.as_deref(), self.title_direction())?;
        let values: Vec<f64> = wide.columns.iter().map(|(_, value)| *value).collect();
        let angle_unit = match angle_unit {
            Some(unit) => unit,
            None => by_range(&values).map_err(|problem| self.refuse(problem, UNTOLD_ANGLE))?,
        };
        let radians = wide.columns.iter().map(|&(c, value)| (c, radians(value, angle_unit))).collect();
        let beside = |c: usize| wide.columns.iter().all(|(column, _)| *column != c);
        let plan = self.plan(Points::Across(radians), (unit, metres));
        // What stands before the angles is the name of the row.
        let profile = plan.profile.filter(|&c| beside(c)).or((0..first).find(|&c| beside(c)));
        Ok(Plan { profile, weight: None, angle_unit: Some(angle_unit), clockwise, ..plan })
    }

    /// A unit of length above the table, as in `radius, cm`.
    fn in_titles(&self) -> Option<String> {
        let radius = |title: &String| column::named(title).filter(|n| n.quantity == Quantity::Radius)?.unit;
        let corner = self.table.header.first().and_then(|name| radius(&name.rsplit(['\\', '/']).next()?.to_owned()));
        self.table.titles.iter().find_map(radius).or(corner).filter(|unit| length_unit(unit).is_some())
    }

    fn title_direction(&self) -> Option<bool> {
        self.table.titles.iter().find_map(|title| column::named(title).filter(|n| n.quantity == Quantity::Angle)?.clockwise)
    }

    /// Whether at least half of what stands in a column reads as numbers.
    fn holds_numbers(&self, column: usize) -> bool {
        let (mut numbers, mut others) = (0, 0);
        for row in 0..self.table.rows.len() {
            let reads = |marks: Numbers| self.table.number(row, column, marks).is_ok();
            match self.table.cell(row, column) {
                "" => (),
                _ if reads(Numbers::Point) || reads(Numbers::Comma) => numbers += 1,
                _ => others += 1,
            }
        }
        0 < numbers && others <= numbers
    }
}

pub(super) const UNTOLD_ANGLE: &str =
    "name the column angle_deg or angle_rad; or tell it: angle = \"deg\" in [tables] of campaign.toml, --angle deg";

/// The unit in which angles go once round a hem.
///
/// # Errors
/// The problem, as a sentence, if they do so in neither degrees nor radians.
pub(super) fn by_range(values: &[f64]) -> Result<AngleUnit, String> {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)));
    // Round the whole hem: more than three quarters of a turn, and no more than one, with a rounded last digit.
    let round = |turn: f64| 0.75 * turn < high - low && high - low <= 1.001 * turn;
    match () {
        () if round(TAU) => Ok(AngleUnit::Radian),
        () if round(TAU / DEGREE) => Ok(AngleUnit::Degree),
        () => Err(format!("the angle has no unit, and from {low} to {high} it goes round a hem neither in degrees nor in radians")),
    }
}

/// An angle within one turn, rad.
pub(super) fn radians(value: f64, unit: AngleUnit) -> f64 {
    // Reduced in its own unit, where a whole turn is exact: the point at 360° then repeats that at 0°.
    match unit {
        AngleUnit::Degree => value.rem_euclid(360.0) * DEGREE,
        AngleUnit::Gon => value.rem_euclid(400.0) * GON,
        AngleUnit::Radian => value.rem_euclid(TAU),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_without_a_unit_are_told_by_their_range_or_refused() {
        let degrees: Vec<f64> = (0..36).map(|i| f64::from(10 * i)).collect();
        let turn: Vec<f64> = (0..36).map(|i| TAU * f64::from(i) / 36.0).collect();
        assert_eq!(by_range(&degrees), Ok(AngleUnit::Degree));
        assert_eq!(by_range(&turn), Ok(AngleUnit::Radian));
        for sector in [vec![0.0, 90.0], vec![0.0, 1.0], vec![0.0, 399.0]] {
            assert!(by_range(&sector).unwrap_err().contains("neither"), "{sector:?}");
        }
    }

    #[test]
    fn a_whole_turn_is_no_turn() {
        assert_eq!((radians(360.0, AngleUnit::Degree), radians(-400.0, AngleUnit::Gon)), (0.0, 0.0));
    }

    #[test]
    fn a_row_of_measured_radii_is_no_header() {
        let cells = |text: &str| text.split(' ').map(String::from).collect::<Vec<_>>();
        assert!(is_header(&cells("run 0 30 60 90 120 150 180 210 240 270 300 330")));
        assert!(!is_header(&cells("1 20.1 20.3 20.2 20.5 20.1 20.0 19.8 19.9 20.0 20.1 20.2 20.1")));
        assert!(!is_header(&cells("run stiff wide profile")));
    }
}
