//! Points: the cells of a table whose layout is known → points in metres by profile, and the cells that hold none.

use std::collections::BTreeMap;

use super::cells::Headed;
use super::layout::{Plan, Points, radians};
use super::number::Numbers;
use crate::experiment::{Point, Quarantined};

/// The points of one profile, in the order of the table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Group {
    pub name: String,
    /// m.
    pub points: Vec<Point>,
    /// `lines[i]` is the line of point `i`.
    pub lines: Vec<usize>,
    /// One per point, or none.
    pub weights: Vec<f64>,
}

/// A table while it is read, and what it gave.
pub(super) struct Reader<'a> {
    table: &'a Headed,
    plan: &'a Plan,
    numbers: Numbers,
    /// In order of first appearance.
    pub groups: Vec<Group>,
    index: BTreeMap<String, usize>,
    /// Rows and cells that were set aside.
    pub quarantine: Vec<Quarantined>,
    /// Cells of wide tables that have nothing in them.
    pub empty: usize,
}

const CORRECT: &str = "the point was set aside; correct it or delete the row";

impl<'a> Reader<'a> {
    /// Reads every row. `name` is that of the profile where the table names none.
    pub(super) fn read(table: &'a Headed, plan: &'a Plan, numbers: Numbers, name: &str) -> Self {
        let quarantine = table.quarantine.clone();
        let mut reader = Reader { table, plan, numbers, groups: Vec::new(), index: BTreeMap::new(), quarantine, empty: 0 };
        match &plan.points {
            Points::Cartesian { x, y } => reader.long([*x, *y], name),
            Points::Polar { angle, radius } => reader.long([*angle, *radius], name),
            Points::Across(columns) => reader.across(columns, name),
            Points::Down { angle, profiles } => reader.down(*angle, profiles),
        }
        reader
    }

    fn fault(&mut self, run: &str, row: usize, value: &str, problem: String, remedy: &str) {
        let run = (!run.is_empty()).then_some(run);
        self.quarantine.push(self.table.fault(run, Some(self.table.line(row)), value, problem, remedy));
    }

    fn group(&mut self, name: &str) -> usize {
        if let Some(&at) = self.index.get(name) {
            return at;
        }
        self.groups.push(Group { name: name.to_owned(), points: Vec::new(), lines: Vec::new(), weights: Vec::new() });
        self.index.insert(name.to_owned(), self.groups.len() - 1);
        self.groups.len() - 1
    }

    fn push(&mut self, group: usize, row: usize, point: Point, weight: Option<f64>) {
        let line = self.table.line(row);
        let group = &mut self.groups[group];
        group.points.push(point);
        group.lines.push(line);
        group.weights.extend(weight);
    }

    /// The number in a cell; one that is none is set aside.
    fn number(&mut self, run: &str, row: usize, column: usize, good: impl Fn(f64) -> Result<(), &'static str>) -> Option<f64> {
        let table = self.table;
        let problem = match table.number(row, column, self.numbers) {
            Ok(value) => match good(value) {
                Ok(()) => return Some(value),
                Err(problem) => problem.to_owned(),
            },
            Err(problem) => problem,
        };
        let problem = format!("column “{}” {problem}", super::cells::shortened(&table.header[column]));
        self.fault(run, row, table.cell(row, column), problem, CORRECT);
        None
    }

    /// A row per point.
    fn long(&mut self, columns: [usize; 2], fallback: &str) {
        let (table, plan) = (self.table, self.plan);
        let polar = matches!(plan.points, Points::Polar { .. });
        for row in 0..table.rows.len() {
            let name = plan.profile.map_or(fallback, |c| table.cell(row, c));
            let blank = columns.iter().all(|&c| table.cell(row, c).is_empty());
            if blank && (plan.profile.is_none() || name.is_empty()) {
                continue;
            }
            if let (Some(c), true) = (plan.profile, name.is_empty()) {
                let problem = format!("column “{}” is empty", table.header[c]);
                self.fault("", row, "", problem, "name the profile that this point belongs to");
                continue;
            }
            let group = self.group(name);
            let first = self.number(name, row, columns[0], |_| Ok(()));
            let second = self.number(name, row, columns[1], |value| if polar { positive(value) } else { Ok(()) });
            let weight = plan.weight.map(|c| self.number(name, row, c, positive));
            let (Some(first), Some(second), false) = (first, second, weight == Some(None)) else { continue };
            let point = match plan.points {
                Points::Polar { .. } => self.polar(self.angle(first), second),
                _ => Point::new(first * plan.metres, second * plan.metres),
            };
            self.push(group, row, point, weight.flatten());
        }
    }

    /// A row per profile.
    fn across(&mut self, columns: &[(usize, f64)], fallback: &str) {
        let (table, plan) = (self.table, self.plan);
        for row in 0..table.rows.len() {
            if columns.iter().all(|&(c, _)| table.cell(row, c).is_empty()) {
                continue;
            }
            let name = match plan.profile {
                Some(c) => table.cell(row, c).to_owned(),
                None if table.rows.len() == 1 => fallback.to_owned(),
                None => format!("{fallback}, row {}", table.line(row)),
            };
            if name.is_empty() {
                self.fault("", row, "", "the row has radii but no name".into(), "name the profile that it holds, in the first column");
                continue;
            }
            if self.index.contains_key(&name) {
                self.fault(
                    &name,
                    row,
                    &name,
                    "there is a row of this name above".into(),
                    "give every profile its own name; the first row was used",
                );
                continue;
            }
            let group = self.group(&name);
            for &(c, angle) in columns {
                self.radius(group, &name, row, c, angle);
            }
        }
    }

    /// A row per angle.
    fn down(&mut self, angle: usize, profiles: &[(usize, String)]) {
        let table = self.table;
        for (_, name) in profiles {
            self.group(name);
        }
        for row in 0..table.rows.len() {
            if profiles.iter().all(|&(c, _)| table.cell(row, c).is_empty()) {
                continue;
            }
            let Some(value) = self.number("", row, angle, |_| Ok(())) else { continue };
            let value = self.angle(value);
            for (group, (c, name)) in profiles.iter().enumerate() {
                self.radius(group, name, row, *c, value);
            }
        }
    }

    /// One cell of a wide table. An empty one holds no point: profiles of one table need not have the same angles.
    fn radius(&mut self, group: usize, name: &str, row: usize, column: usize, angle: f64) {
        if self.table.cell(row, column).is_empty() {
            self.empty += 1;
        } else if let Some(radius) = self.number(name, row, column, positive) {
            let point = self.polar(angle, radius);
            self.push(group, row, point, None);
        }
    }

    fn angle(&self, value: f64) -> f64 {
        self.plan.angle_unit.map_or(value, |unit| radians(value, unit))
    }

    /// A point at an angle, rad, and a radius in the unit of the table.
    fn polar(&self, angle: f64, radius: f64) -> Point {
        let (sine, cosine) = angle.sin_cos();
        let radius = radius * self.plan.metres;
        Point::new(radius * cosine, if self.plan.clockwise { -radius * sine } else { radius * sine })
    }
}

fn positive(value: f64) -> Result<(), &'static str> {
    if 0.0 < value { Ok(()) } else { Err("is not positive") }
}
