//! `hemline regress`: the factorial regression of one column of a table, all interactions.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::error::{Error, Place};
use crate::import::numbers::{Line, NumberTable, Value};
use crate::statistics::box_wilson::{Options, analyse};
use crate::statistics::factorial::{Axis, FactorialDesign};
use crate::statistics::family;
use crate::statistics::known_errors;
use clap::{Args, ValueEnum};
use document::Document;

mod document;
mod text;

/// Regress a response on two-level factors with all their interactions.
///
/// One line of the table is one run; lines with equal factor levels are replicates. Factors may be coded (-1, 0, 1 or -, +) or natural: the
/// lowest value becomes -1, the highest +1. Coefficients are in coded units. Tests compare with the scatter of the replicates.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  hemline regress table.csv --factors conicity,rigidity,density --response depth\n\n\
Exit code: 0 all lines used (empty responses are missing runs), 1 some lines were set aside, 2 no regression possible.")]
pub struct Regress {
    /// Table with a header line; comma, semicolon or tab between cells.
    pub table: PathBuf,
    /// Columns of the factors, separated by commas; 1 to 6.
    #[arg(long, value_delimiter = ',', required = true, value_name = "A,B,C")]
    pub factors: Vec<String>,
    /// Column of the response.
    #[arg(long, value_name = "Y")]
    pub response: String,
    /// Column that names the block (day, operator …) of each run.
    #[arg(long, value_name = "COLUMN")]
    pub block: Option<String>,
    /// Column of the response's own standard errors: adds the regression weighted by them.
    #[arg(long, value_name = "COLUMN")]
    pub se: Option<String>,
    /// Significance level of every test; intervals cover 1 - alpha.
    #[arg(long, default_value_t = 0.05)]
    pub alpha: f64,
    /// Add sums of squares by this adjustment: sequential (type I), hierarchical (II) or partial (III).
    #[arg(long, value_name = "KIND")]
    pub sums_of_squares: Option<Kind>,
    /// Add how many runs of each treatment would find a change this large, from low to high level, with a chance of 90 %.
    #[arg(long, value_name = "SIZE")]
    pub effect: Option<f64>,
    /// Add permutation p-values, for responses that are not normal (a fold count, say).
    #[arg(long)]
    pub permutation: bool,
    /// Add the path of steepest ascent or descent, and which runs to do next.
    #[arg(long, value_name = "WISH")]
    pub next: Option<Wish>,
    /// Write JSON instead of a table; null where a quantity does not exist, and the reason in `notes`.
    #[arg(long)]
    pub json: bool,
}

/// What the sum of squares of a term is adjusted for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// The terms before it.
    Sequential,
    /// The terms that do not contain it.
    Hierarchical,
    /// All other terms.
    Partial,
}

/// What is wanted of the response.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Wish {
    Larger,
    Smaller,
}

/// Reads the table, analyses the response, prints the result on stdout; lines set aside go to stderr, one sentence each.
///
/// # Errors
/// Those of the table, of [`FactorialDesign::new`] and of [`analyse`].
pub fn run(args: &Regress) -> Result<ExitCode, Error> {
    let document = regress(args)?;
    for sentence in &document.set_aside {
        eprintln!("{sentence}");
    }
    if args.json {
        let text = serde_json::to_string_pretty(&document)
            .map_err(|why| Error::Output { what: "the JSON result".into(), why: why.to_string() })?;
        crate::cli::print(&format!("{text}\n"))?;
    } else {
        crate::cli::print(&text::text_of(&document))?;
    }
    Ok(if document.set_aside.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

fn regress(args: &Regress) -> Result<Document, Error> {
    let table = NumberTable::read(&args.table)?;
    let observed = observe(&table, args)?;
    if observed.natural.is_empty() {
        let mut why = format!("{}: no line has all factors and a response to regress", args.table.display());
        if let Some(first) = observed.set_aside.first() {
            why = format!("{why}; the first fault: {first}");
        }
        return Err(Error::Unanswerable(why));
    }
    let mut notes = Vec::new();
    let axes: Vec<Axis> = args.factors.iter().enumerate().map(|(i, name)| axis(name, observed.column(i), &mut notes)).collect();
    let levels =
        observed.natural.iter().map(|row| row.iter().zip(&axes).map(|(x, axis)| (x - axis.centre()) / axis.interval()).collect()).collect();
    let mut design = FactorialDesign::new(axes, levels)?;
    if !observed.blocks.is_empty() {
        design = design.with_blocks(observed.blocks.clone())?;
    }
    let mut analysis = analyse(&design, &observed.response, &Options { alpha: args.alpha })?;
    family::adjust(std::slice::from_mut(&mut analysis));
    notes.append(&mut analysis.notes);
    analysis.notes = notes;
    let mut document = Document::new(args, &design, &analysis, observed.rows, observed.set_aside);
    if args.se.is_some() {
        let used = design.subset(&analysis.used_runs);
        let regressors = used.regressors_of(&used.term_factors(), used.has_centre())?;
        let y: Vec<f64> = observed.response.iter().copied().flatten().collect();
        document.known_errors = Some(known_errors::regress(&regressors, &y, &observed.standard_errors, args.alpha)?);
    }
    document.look_further(args, &design, &observed.response, &analysis)?;
    Ok(document)
}

/// The usable lines.
struct Observed {
    /// `natural[run][factor]`, as in the table.
    natural: Vec<Vec<f64>>,
    response: Vec<Option<f64>>,
    /// Line of the file of each run.
    rows: Vec<usize>,
    blocks: Vec<String>,
    /// One per run that has a response, if asked for.
    standard_errors: Vec<f64>,
    set_aside: Vec<String>,
}

impl Observed {
    fn column(&self, factor: usize) -> Vec<f64> {
        self.natural.iter().map(|row| row[factor]).collect()
    }
}

fn observe(table: &NumberTable, args: &Regress) -> Result<Observed, Error> {
    let factors = args.factors.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
    let response = table.column(&args.response)?;
    let block = args.block.as_ref().map(|name| table.column(name)).transpose()?;
    let se = args.se.as_ref().map(|name| table.column(name)).transpose()?;
    let mut observed = Observed {
        natural: Vec::new(),
        response: Vec::new(),
        rows: Vec::new(),
        blocks: Vec::new(),
        standard_errors: Vec::new(),
        set_aside: table.set_aside.iter().map(|line| format!("{line}; this line is left out.")).collect(),
    };
    for line in &table.lines {
        match usable(table, line, &factors, response, block, se) {
            Ok((row, y, own)) => {
                observed.natural.push(row);
                observed.response.push(y);
                observed.standard_errors.extend(own);
                observed.rows.push(line.row);
                if let Some(block) = block {
                    observed.blocks.push(table.text(line, block).unwrap_or_default().to_string());
                }
            }
            Err(why) => observed.set_aside.push(format!("{why}; this line is left out.")),
        }
    }
    Ok(observed)
}

/// Factor levels, response and its own standard error of one line.
type Cells = (Vec<f64>, Option<f64>, Option<f64>);

fn usable(
    table: &NumberTable,
    line: &Line,
    factors: &[usize],
    response: usize,
    block: Option<usize>,
    se: Option<usize>,
) -> Result<Cells, Error> {
    let fault = |column: usize, problem: &str, remedy: &str| {
        Error::input(Place::file(&table.file).row(line.row).column(&table.columns[column]), problem, remedy)
    };
    let mut row = Vec::with_capacity(factors.len());
    for &column in factors {
        match table.value(line, column)? {
            Value::Number(x) => row.push(x),
            Value::Empty => return Err(fault(column, "the factor has no level", "give its level, coded or natural")),
        }
    }
    if let Some(column) = block.filter(|&column| table.text(line, column).is_none_or(str::is_empty)) {
        return Err(fault(column, "the run has no block", "name its block"));
    }
    let Value::Number(y) = table.value(line, response)? else { return Ok((row, None, None)) };
    let own = match se.map(|column| Ok::<_, Error>((column, table.value(line, column)?))).transpose()? {
        None => None,
        Some((_, Value::Number(own))) if own > 0.0 => Some(own),
        Some((column, _)) => return Err(fault(column, "the standard error is not positive", "give the standard error of the response")),
    };
    Ok((row, Some(y), own))
}

/// How a column of levels is coded: as it is if it holds −1 and +1 (and 0), otherwise by its lowest and highest value.
fn axis(name: &str, levels: Vec<f64>, notes: &mut Vec<String>) -> Axis {
    let low = levels.iter().copied().fold(f64::INFINITY, f64::min);
    let high = levels.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if (low, high) == (-1.0, 1.0) {
        return Axis::coded(name);
    }
    notes.push(format!("Factor {name} is natural: {low} is coded −1, {high} is coded +1."));
    Axis { name: name.into(), low, high }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arguments(table: PathBuf, factors: &[&str]) -> Regress {
        let factors = factors.iter().map(|name| name.to_string()).collect();
        Regress {
            table,
            factors,
            response: "y".into(),
            block: None,
            se: None,
            alpha: 0.05,
            sums_of_squares: None,
            effect: None,
            permutation: false,
            next: None,
            json: true,
        }
    }

    fn json_of(name: &str, text: &str, factors: &str) -> serde_json::Value {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join(name);
        std::fs::write(&table, text).unwrap();
        let args = arguments(table, &factors.split(',').collect::<Vec<_>>());
        serde_json::to_value(regress(&args).unwrap()).unwrap()
    }

    #[test]
    fn natural_levels_are_coded_and_said() {
        // ȳ = 2.5 and 6.5 at the two levels: constant 4.5, coefficient 2; s² = 0.5 on 2 degrees of freedom, s_b = √(0.5/4).
        let json = json_of("t.csv", "rigidity,y\n20,2\n80,6\n20,3\n80,7\n", "rigidity");
        let close = |value: &serde_json::Value, exact: f64| (value.as_f64().unwrap() - exact).abs() < 1e-14;
        assert!(close(&json["terms"][0]["estimate"], 4.5) && close(&json["terms"][1]["estimate"], 2.0));
        assert!(close(&json["terms"][1]["se"], 0.125_f64.sqrt()) && json["residual_df"] == 2);
        // Both variances are equal: G = 1/2.
        assert!(close(&json["cochran"]["g"], 0.5));
        // Both terms are significant, so nothing is left to test adequacy with.
        assert_eq!(json["adequacy"], serde_json::json!({"f": null, "critical": null, "df": null}));
        let notes = json["notes"].to_string();
        assert!(notes.contains("20 is coded −1") && notes.contains("Adequacy cannot be tested"), "{notes}");
    }

    #[test]
    fn a_bad_cell_sets_its_line_aside_and_an_empty_response_is_a_missing_run() {
        let json = json_of("t.csv", "a,b,y\n-1,-1,1\n1,-1,oops\n1,-1,2\n-1,1,3\n1,1,\n1,1,4.5\n-1,-1,1.5\n", "a,b");
        assert_eq!((json["runs"].as_u64(), json["set_aside"].as_array().map(Vec::len)), (Some(5), Some(1)));
        let sentence = json["set_aside"][0].as_str().unwrap();
        assert!(sentence.contains("row 3, column “y”: “oops”"), "{sentence}");
        assert!(json["notes"].to_string().contains("1 of 6 runs have no response"));
    }

    #[test]
    fn a_run_that_does_not_belong_is_named_by_its_row_and_left_out_beside() {
        let noise = [0.1, -0.2, 0.15, 0.05, -0.1, 0.0, 0.2, -0.15, 0.05, -0.05, 0.1, -0.1];
        let mut text = String::from("a,y\n");
        for (i, e) in noise.iter().enumerate() {
            let shift = if i == 6 { 30.0 } else { 0.0 };
            text += &format!("{},{}\n", [-1, 1][i % 2], 5.0 + e + shift);
        }
        let json = json_of("t.csv", &text, "a");
        let suspects = json["diagnostics"]["suspects"].as_array().unwrap();
        assert_eq!((suspects.len(), suspects[0]["run"].as_u64(), json["rows"][6].as_u64()), (1, Some(6), Some(8)));
        // Without it, the mean of the low level is 5 + (0.1 + 0.15 − 0.1 + 0.05 + 0.1)/5 = 5.06, of the high one 5 − 0.45/6 = 4.925.
        assert!((json["without_suspects"][1]["estimate"].as_f64().unwrap() - (4.925 - 5.06) / 2.0).abs() < 1e-14);
    }

    #[test]
    fn own_standard_errors_weigh_the_runs() {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join("t.csv");
        std::fs::write(&table, "a,y,e\n-1,1,0.5\n-1,1.2,0.5\n1,2,0.5\n1,2.4,0.5\n1,9,0\n").unwrap();
        let args = Regress { se: Some("e".into()), ..arguments(table, &["a"]) };
        let document = regress(&args).unwrap();
        assert!(document.set_aside[0].contains("row 6, column “e”: the standard error is not positive"), "{:?}", document.set_aside);
        let known = document.known_errors.unwrap();
        // The scatter (variances 0.02 and 0.08) is below the errors' 0.25: none is left between runs, and se = 0.5/√4.
        assert_eq!(known.between_runs, 0.0);
        assert!((known.coefficients[1].estimate - 0.55).abs() < 1e-14 && (known.coefficients[1].se - 0.25).abs() < 1e-14);
    }

    #[test]
    fn an_effect_asked_for_gets_its_replicates() {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join("t.csv");
        std::fs::write(&table, "a,y\n-1,2\n1,6\n-1,3\n1,7\n").unwrap();
        let of = |effect: f64| {
            regress(&Regress { effect: Some(effect), ..arguments(table.clone(), &["a"]) }).map(|d| d.replicates_needed.unwrap())
        };
        // The smallest effect that two replicates find is twice the smallest coefficient; a little less needs a third.
        let smallest = regress(&arguments(table.clone(), &["a"])).unwrap().smallest_coefficient.unwrap();
        assert_eq!((of(2.001 * smallest).unwrap().replicates, of(1.999 * smallest).unwrap().replicates), (2, 3));
        assert!(of(0.0).err().unwrap().to_string().contains("coefficient to find is 0"));
    }

    #[test]
    fn a_table_that_cannot_be_regressed_says_which_column_is_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join("t.csv");
        std::fs::write(&table, "a,y\n1,1\n1,2\n").unwrap();
        let mut args = arguments(table, &["a"]);
        let why = regress(&args).err().unwrap().to_string();
        assert!(why.contains("factor “a” has levels 1 and 1"), "{why}");
        args.response = "z".into();
        let why = regress(&args).err().unwrap().to_string();
        assert!(why.contains("column “z”: there is no such column; the columns are a, y"), "{why}");
    }
}
