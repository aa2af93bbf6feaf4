//! `design.csv`: one row per run → factor levels, cut, cloth and profile file of each.

use std::path::{Path, PathBuf};

use super::campaign_file::{CampaignFile, Levels, Quantity, unknown};
use super::cells::Headed;
use super::column::length_unit;
use super::document;
use super::number::Numbers;
use crate::error::Error;
use crate::experiment::Quarantined;
use crate::experiment::Source;
use crate::experiment::{Apparatus, Design, Fabric, Factor, Run, Skirt};
use crate::units::{KilogramPerSquareMetre, Metre, NewtonMetre};

/// The design table, read.
pub(super) struct DesignTable {
    pub design: Design,
    /// `rows[i]` is the line of the file (1 = the first) of run `i`.
    pub rows: Vec<usize>,
    pub quarantine: Vec<Quarantined>,
    pub notes: Vec<String>,
    pub source: Source,
}

/// Reads the design table that `file` describes.
///
/// A row whose run or level cannot be read is set aside; a cloth or cut cell that cannot be read is set aside and its run goes on without.
///
/// # Errors
/// [`Error::Input`] if the table is none, or a column that it needs or that `campaign.toml` names is not there.
pub(super) fn read(path: &Path, file: &CampaignFile) -> Result<DesignTable, Error> {
    let names_runs = |names: &[String]| {
        let has = |name: &str| names.iter().any(|other| other.eq_ignore_ascii_case(name));
        has("run") && file.factors.iter().all(|(factor, _)| has(&factor.name))
    };
    let document = document::read(path, &file.tables.of(path), &names_runs)?;
    let source = document.source.clone();
    let table = document.into_one(|table| names_runs(&table.header))?;
    let columns = Columns::find(&table, file)?;
    let mut reader =
        Reader { table: &table, file, numbers: table.numbers(&columns.numeric()), columns, quarantine: table.quarantine.clone() };
    let (mut runs, mut rows): (Vec<Run>, Vec<usize>) = (Vec::new(), Vec::new());
    // Every run that has a row, usable or not, with the line of its first row.
    let mut seen: Vec<(String, usize)> = Vec::new();
    for row in 0..table.rows.len() {
        if (0..table.header.len()).all(|c| table.cell(row, c).is_empty()) {
            continue;
        }
        let line = table.line(row);
        let id = table.cell(row, reader.columns.run).to_owned();
        if id.is_empty() {
            reader.set_aside(row, None, "", "column “run” is empty".into(), "number the run");
            continue;
        }
        if let Some((_, first)) = seen.iter().find(|(other, _)| *other == id) {
            let problem = format!("duplicate run: run {id} is already in row {first}");
            reader.set_aside(row, Some(&id), &id, problem, "the first row was used; delete one, or give this run its own number");
            continue;
        }
        seen.push((id.clone(), line));
        if let Some(run) = reader.run(row, id) {
            runs.push(run);
            rows.push(line);
        }
    }
    if seen.is_empty() {
        return Err(Error::input(table.place(), "the design table has no runs", "one row per run is needed"));
    }
    for id in missing_numbers(&seen) {
        let problem = format!("missing run: run {id} has no row in the design table");
        let id = id.to_string();
        reader.quarantine.push(table.fault(Some(&id), None, "", problem, "add its row, or number the runs without gaps"));
    }
    let quarantine = reader.quarantine;
    let design = Design { factors: file.factors.iter().map(|(factor, _)| factor.clone()).collect(), runs };
    let notes = notes(&design);
    Ok(DesignTable { design, rows, quarantine, notes, source })
}

/// Where runs are numbered 1, 2, …, the numbers that are left out.
fn missing_numbers(seen: &[(String, usize)]) -> Vec<usize> {
    let numbers: Option<Vec<usize>> = seen.iter().map(|(id, _)| id.parse().ok()).collect();
    let Some(numbers) = numbers else { return Vec::new() };
    let last = numbers.iter().copied().max().unwrap_or(0);
    // With more gaps than runs it is another way of numbering.
    if 2 * numbers.len() < last {
        return Vec::new();
    }
    (1..=last).filter(|n| !numbers.contains(n)).collect()
}

/// What a person should know about the balance of the design.
fn notes(design: &Design) -> Vec<String> {
    let mut cells: Vec<(Vec<f64>, usize)> = Vec::new();
    // The centre is no corner: any number of runs there leaves the design balanced.
    for run in design.runs.iter().filter(|run| !is_centre(&run.levels)) {
        match cells.iter_mut().find(|(levels, _)| *levels == run.levels) {
            Some((_, count)) => *count += 1,
            None => cells.push((run.levels.clone(), 1)),
        }
    }
    let mut notes = Vec::new();
    let all = 1_usize << design.factors.len().min(20);
    if cells.len() < all {
        notes.push(format!("{} of the {all} combinations of levels have no run", all - cells.len()));
    }
    let (low, high) = cells.iter().fold((usize::MAX, 0), |(low, high), (_, count)| (low.min(*count), high.max(*count)));
    if low < high {
        notes.push(format!("the design is unbalanced: {low} to {high} runs per combination of levels"));
    }
    notes
}

fn is_centre(levels: &[f64]) -> bool {
    levels.iter().all(|level| *level == 0.0)
}

/// Where the quantities stand in the table.
struct Columns {
    run: usize,
    replicate: Option<usize>,
    block: Option<usize>,
    profile: Option<usize>,
    factors: Vec<usize>,
    geometry: Vec<Option<usize>>,
    density: Option<usize>,
    rigidity: Option<usize>,
}

impl Columns {
    fn find(table: &Headed, file: &CampaignFile) -> Result<Self, Error> {
        let names: Vec<&str> = table.header.iter().map(String::as_str).collect();
        let position = |name: &str| table.header.iter().position(|h| h.eq_ignore_ascii_case(name));
        let needed = |name: &str| {
            let problem = || format!("there is no column “{name}”");
            position(name).ok_or_else(|| unknown(table.place().row(table.header_line), &problem(), name, &names))
        };
        let named = |name: &str, what: &str| {
            let problem = || format!("unknown column: campaign.toml names “{name}” for {what}, but the design table has no such column");
            position(name).ok_or_else(|| unknown(table.place().row(table.header_line), &problem(), name, &names))
        };
        let of = |quantity: &Quantity, what: &str| match quantity {
            Quantity::Number(_) => Ok(None),
            Quantity::Column { name, si_factor } => {
                let column = named(name, what)?;
                let unit = table.units[column].as_deref();
                if unit.and_then(length_unit).is_some_and(|metres| metres != *si_factor) {
                    let problem = format!("mixed units: column “{name}” has {} in the row of units", unit.unwrap_or_default());
                    let place = table.place().row(table.header_line);
                    return Err(Error::input(place, problem, "let its key in campaign.toml end in the same unit"));
                }
                Ok(Some(column))
            }
        };
        let cloth = |quantity: &Option<Quantity>, what: &str| quantity.as_ref().map_or(Ok(None), |q| of(q, what));
        Ok(Columns {
            run: needed("run")?,
            replicate: position("replicate"),
            block: file.block.as_ref().map(|name| named(name, "the block")).transpose()?,
            profile: match file.store {
                Some(_) => position("profile"),
                None => Some(needed("profile")?),
            },
            factors: file.factors.iter().map(|(f, _)| named(&f.name, "a factor")).collect::<Result<_, _>>()?,
            geometry: file.geometry.iter().map(|q| of(q, "the geometry")).collect::<Result<_, _>>()?,
            density: cloth(&file.areal_density, "the areal density")?,
            rigidity: cloth(&file.flexural_rigidity, "the flexural rigidity")?,
        })
    }

    fn numeric(&self) -> Vec<usize> {
        let geometry = self.geometry.iter().flatten().copied();
        self.factors.iter().copied().chain(geometry).chain(self.density).chain(self.rigidity).collect()
    }
}

struct Reader<'a> {
    table: &'a Headed,
    file: &'a CampaignFile,
    numbers: Numbers,
    columns: Columns,
    quarantine: Vec<Quarantined>,
}

impl Reader<'_> {
    fn set_aside(&mut self, row: usize, run: Option<&str>, value: &str, problem: String, remedy: &str) {
        self.quarantine.push(self.table.fault(run, Some(self.table.line(row)), value, problem, remedy));
    }

    fn run(&mut self, row: usize, id: String) -> Option<Run> {
        let table = self.table;
        let mut levels = Vec::new();
        for (i, (factor, coding)) in self.file.factors.iter().enumerate() {
            let column = self.columns.factors[i];
            match self.level(factor, *coding, row, column) {
                Ok(level) => levels.push(level),
                Err((problem, remedy)) => {
                    let problem = format!("column “{}” {problem}", table.header[column]);
                    self.set_aside(row, Some(&id), table.cell(row, column), problem, &remedy);
                    return None;
                }
            }
        }
        if levels.contains(&0.0) && !is_centre(&levels) {
            let written: Vec<&str> = self.columns.factors.iter().map(|&column| table.cell(row, column)).collect();
            let problem = "the run is at the centre in some factors and at a level in others".into();
            self.set_aside(
                row,
                Some(&id),
                &written.join(", "),
                problem,
                "a two-level design has corners and centre points; correct the levels",
            );
            return None;
        }
        let block = self.columns.block.map(|column| table.cell(row, column).to_owned());
        if let Some("") = block.as_deref() {
            self.set_aside(
                row,
                Some(&id),
                "",
                "the run has no block".into(),
                "name its block, as the other rows do; the run was set aside",
            );
            return None;
        }
        let replicate = self.replicate(row, &id);
        let columns = self.columns.geometry.clone();
        let lengths: Vec<Option<f64>> = self.file.geometry.iter().zip(columns).map(|(q, column)| self.value(row, &id, q, column)).collect();
        let skirt = lengths.into_iter().collect::<Option<Vec<f64>>>().and_then(|lengths| self.skirt(row, &id, &lengths));
        let file = self.file;
        let (density, rigidity) = (self.columns.density, self.columns.rigidity);
        let areal_density = file.areal_density.as_ref().and_then(|q| self.value(row, &id, q, density)).map(KilogramPerSquareMetre);
        let flexural_rigidity = file.flexural_rigidity.as_ref().and_then(|q| self.value(row, &id, q, rigidity)).map(NewtonMetre);
        // Windows spreadsheets write backslashes.
        let profile = PathBuf::from(self.columns.profile.map_or("", |column| table.cell(row, column)).replace('\\', "/"));
        Some(Run { id, replicate, block, levels, skirt, fabric: Fabric { areal_density, flexural_rigidity }, profile })
    }

    /// The coded level that a cell says: −1, +1, or 0 for the centre.
    fn level(&self, factor: &Factor, coding: Levels, row: usize, column: usize) -> Result<f64, (String, String)> {
        let value =
            self.table.number(row, column, self.numbers).map_err(|problem| (problem, "correct it; the run was set aside".to_owned()))?;
        let coded = match coding {
            Levels::Coded => value,
            Levels::Natural => factor.coded(value),
        };
        // Natural levels that went through a spreadsheet carry its rounding.
        if (coded.abs() - 1.0).abs() < 1e-6 {
            return Ok(coded.signum());
        }
        if coded.abs() < 1e-6 {
            return Ok(0.0);
        }
        let Factor { name, low, high, .. } = factor;
        let other = (factor.coded(value).abs() - 1.0).abs() < 1e-6;
        Err(match coding {
            Levels::Coded if other => (
                "is a natural level where a coded one is expected".into(),
                format!("write levels = \"natural\" for factor “{name}” in campaign.toml"),
            ),
            Levels::Coded => (
                "is no level of a two-level design".into(),
                "write −1 or 1, or 0 in all factors for a centre point; the run was set aside".into(),
            ),
            Levels::Natural if value.abs() == 1.0 => (
                "is a coded level where a natural one is expected".into(),
                format!("write levels = \"coded\" for factor “{name}” in campaign.toml"),
            ),
            Levels::Natural => ("is neither level of this factor".into(), format!("write {low} or {high}; the run was set aside")),
        })
    }

    fn replicate(&mut self, row: usize, id: &str) -> Option<u32> {
        let column = self.columns.replicate?;
        let cell = self.table.cell(row, column);
        let value = cell.parse().ok();
        if value.is_none() && !cell.is_empty() {
            let problem = format!("column “{}” is no counting number", self.table.header[column]);
            self.set_aside(row, Some(id), cell, problem, "the run goes on without it; replicates are counted by their levels");
        }
        value
    }

    /// A positive quantity in SI; a cell that says none is set aside.
    fn value(&mut self, row: usize, id: &str, quantity: &Quantity, column: Option<usize>) -> Option<f64> {
        match (quantity, column) {
            (Quantity::Number(value), _) => Some(*value),
            (Quantity::Column { .. }, None) => None,
            (Quantity::Column { si_factor, .. }, Some(column)) => {
                let cell = self.table.cell(row, column);
                let problem = match self.table.number(row, column, self.numbers) {
                    Ok(value) if 0.0 < value => return Some(value * si_factor),
                    Ok(_) => "is not positive".to_owned(),
                    Err(problem) => problem,
                };
                let problem = format!("column “{}” {problem}", self.table.header[column]);
                self.set_aside(row, Some(id), cell, problem, "correct it; the run goes on without this property");
                None
            }
        }
    }

    fn skirt(&mut self, row: usize, id: &str, lengths: &[f64]) -> Option<Skirt> {
        let skirt = match (self.file.apparatus, lengths) {
            (Apparatus::Skirt, &[waist, hem, slant]) => Skirt::new(Metre(waist), Metre(hem), Metre(slant)),
            (Apparatus::Drapemeter, &[support, specimen]) => Skirt::drapemeter(Metre(support), Metre(specimen)),
            _ => return None,
        };
        match skirt {
            Ok(skirt) => Some(skirt),
            Err(error) => {
                self.set_aside(row, Some(id), "", format!("no such cut: {error}"), "correct the geometry; the run goes on without its cut");
                None
            }
        }
    }
}
