//! `hemline regress`: the factorial regression of one column of a table, all interactions.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use serde::Serialize;

use crate::error::Error;
use crate::import::numbers::{Line, NumberTable, Value};
use crate::statistics::box_wilson::{Analysis, Coefficient, Options, Verdict, analyse};
use crate::statistics::factorial::{Axis, FactorialDesign};
use crate::statistics::family;

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
    /// Significance level of every test; intervals cover 1 - alpha.
    #[arg(long, default_value_t = 0.05)]
    pub alpha: f64,
    /// Write JSON instead of a table; null where a quantity does not exist, and the reason in `notes`.
    #[arg(long)]
    pub json: bool,
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
        println!("{text}");
    } else {
        print!("{}", table_of(&document));
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
    Ok(Document::new(args, &design, &analysis, observed.set_aside))
}

/// The usable lines.
struct Observed {
    /// `natural[run][factor]`, as in the table.
    natural: Vec<Vec<f64>>,
    response: Vec<Option<f64>>,
    blocks: Vec<String>,
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
    let mut observed = Observed { natural: Vec::new(), response: Vec::new(), blocks: Vec::new(), set_aside: Vec::new() };
    for line in &table.lines {
        match usable(table, line, &factors, response) {
            Ok((row, y)) => {
                observed.natural.push(row);
                observed.response.push(y);
                if let Some(block) = block {
                    observed.blocks.push(table.text(line, block).unwrap_or_default().to_string());
                }
            }
            Err(why) => observed.set_aside.push(format!("{why}; this line is left out.")),
        }
    }
    Ok(observed)
}

fn usable(table: &NumberTable, line: &Line, factors: &[usize], response: usize) -> Result<(Vec<f64>, Option<f64>), Error> {
    let mut row = Vec::with_capacity(factors.len());
    for &column in factors {
        match table.value(line, column)? {
            Value::Number(x) => row.push(x),
            Value::Empty => {
                let place = crate::error::Place::file(&table.file).row(line.row).column(&table.columns[column]);
                return Err(Error::input(place, "the factor has no level", "give its level, coded or natural"));
            }
        }
    }
    Ok((
        row,
        match table.value(line, response)? {
            Value::Number(y) => Some(y),
            Value::Empty => None,
        },
    ))
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

#[derive(Serialize)]
struct Term {
    term: String,
    estimate: Option<f64>,
    se: Option<f64>,
    t: Option<f64>,
    p: Option<f64>,
    ci_low: Option<f64>,
    ci_high: Option<f64>,
    p_holm: Option<f64>,
    p_benjamini_hochberg: Option<f64>,
    significant: bool,
}

impl From<&Coefficient> for Term {
    fn from(c: &Coefficient) -> Self {
        Term {
            term: c.term.clone(),
            estimate: Some(c.estimate),
            se: c.se,
            t: c.t,
            p: c.p,
            ci_low: c.ci_low,
            ci_high: c.ci_high,
            p_holm: c.p_holm,
            p_benjamini_hochberg: c.p_benjamini_hochberg,
            significant: c.significant,
        }
    }
}

#[derive(Serialize)]
struct Cochran {
    g: Option<f64>,
    critical: Option<f64>,
}

#[derive(Serialize)]
struct Adequacy {
    f: Option<f64>,
    critical: Option<f64>,
    df: Option<(f64, f64)>,
}

#[derive(Serialize)]
struct Monomial {
    term: String,
    coefficient: f64,
}

#[derive(Serialize)]
struct Document {
    table: String,
    response: String,
    factors: Vec<Axis>,
    alpha: f64,
    runs: usize,
    treatments: usize,
    terms: Vec<Term>,
    curvature: Option<Term>,
    blocks: Vec<Term>,
    error_variance: Option<f64>,
    residual_df: usize,
    t_critical: Option<f64>,
    cochran: Cochran,
    equal_variances: Option<Verdict>,
    adequacy: Adequacy,
    adequate: Option<bool>,
    reduced_natural: Vec<Monomial>,
    anova: Vec<crate::statistics::anova::AnovaRow>,
    r_squared: Option<f64>,
    adjusted_r_squared: Option<f64>,
    predicted_r_squared: Option<f64>,
    press: Option<f64>,
    notes: Vec<String>,
    set_aside: Vec<String>,
}

impl Document {
    fn new(args: &Regress, design: &FactorialDesign, analysis: &Analysis, set_aside: Vec<String>) -> Self {
        // Every term of the model is listed, in its place; one without a coefficient of its own has nulls.
        let terms = design
            .term_factors()
            .iter()
            .map(|term| design.term_name(term))
            .map(|name| match analysis.coefficients.iter().find(|c| c.term == name) {
                Some(coefficient) => coefficient.into(),
                None => Term {
                    term: name,
                    estimate: None,
                    se: None,
                    t: None,
                    p: None,
                    ci_low: None,
                    ci_high: None,
                    p_holm: None,
                    p_benjamini_hochberg: None,
                    significant: false,
                },
            })
            .collect();
        let cochran = analysis.equal_variances.as_ref().filter(|verdict| verdict.test == "Cochran G");
        let adequacy = analysis.adequacy.as_ref();
        Document {
            table: args.table.display().to_string(),
            response: args.response.clone(),
            factors: design.factors().to_vec(),
            alpha: args.alpha,
            runs: analysis.used_runs.len(),
            treatments: analysis.cells.len(),
            terms,
            curvature: analysis.curvature.as_ref().map(Term::from),
            blocks: analysis.blocks.iter().map(Term::from).collect(),
            error_variance: analysis.error.map(|error| error.variance),
            residual_df: analysis.residual_df,
            t_critical: analysis.t_critical,
            cochran: Cochran { g: cochran.map(|v| v.statistic), critical: cochran.map(|v| v.critical) },
            equal_variances: analysis.equal_variances.clone(),
            adequacy: Adequacy { f: adequacy.map(|v| v.statistic), critical: adequacy.map(|v| v.critical), df: adequacy.map(|v| v.df) },
            adequate: adequacy.map(|v| v.holds),
            reduced_natural: analysis.reduced.natural.iter().map(|(term, b)| Monomial { term: term.clone(), coefficient: *b }).collect(),
            anova: analysis.anova.clone(),
            r_squared: analysis.full.r_squared(),
            adjusted_r_squared: analysis.full.adjusted_r_squared(),
            predicted_r_squared: analysis.full.predicted_r_squared(),
            press: analysis.full.press(),
            notes: analysis.notes.clone(),
            set_aside,
        }
    }
}

/// The result for a person.
fn table_of(document: &Document) -> String {
    let mut lines = vec![
        format!("{} on {} — {} runs, {} treatments", document.response, names(&document.factors), document.runs, document.treatments),
        String::new(),
    ];
    let width = document.terms.iter().map(|term| term.term.chars().count()).max().unwrap_or(4).max(9);
    let level = 100.0 * (1.0 - document.alpha);
    lines.push(format!("{:width$}  {:>13} {:>11} {:>9} {:>9}  {level}% interval", "term", "estimate", "se", "t", "p"));
    for term in document.terms.iter().chain(&document.curvature).chain(&document.blocks) {
        let interval = match (term.ci_low, term.ci_high) {
            (Some(low), Some(high)) => format!("{} … {}", short(Some(low)), short(Some(high))),
            _ => "–".into(),
        };
        let mark = if term.significant { " *" } else { "" };
        lines.push(format!(
            "{:width$}  {:>13} {:>11} {:>9} {:>9}  {interval}{mark}",
            term.term,
            short(term.estimate),
            short(term.se),
            term.t.map_or("–".into(), |t| format!("{t:.2}")),
            term.p.map_or("–".into(), probability),
        ));
    }
    lines.push(format!("* significant at {}; error on {} degrees of freedom", document.alpha, document.residual_df));
    lines.push(String::new());
    let verdict = document.equal_variances.as_ref();
    lines.push(verdict.map_or("Do all treatments scatter alike? not testable".into(), |v| {
        let answer = if v.holds { "yes" } else { "no" };
        format!("Do all treatments scatter alike? {answer}: {} {:.4}, critical {:.4}", v.test, v.statistic, v.critical)
    }));
    lines.push(match (&document.adequacy, document.adequate) {
        (Adequacy { f: Some(f), critical: Some(critical), df: Some(df) }, Some(holds)) => format!(
            "Are the significant terms enough? {}: Fisher F {f:.4} on ({}, {}), critical {critical:.4}",
            if holds { "yes" } else { "no" },
            df.0,
            df.1
        ),
        _ => "Are the significant terms enough? not testable".into(),
    });
    if !document.reduced_natural.is_empty() {
        let parts: Vec<String> = document
            .reduced_natural
            .iter()
            .map(|part| {
                let number = format!("{:+.6e}", part.coefficient);
                if part.term == "1" { number } else { format!("{number}·{}", part.term.replace(':', "·")) }
            })
            .collect();
        lines.push(format!("In natural units, significant terms only: {} = {}", document.response, parts.join(" ")));
    }
    if !document.notes.is_empty() {
        lines.push(String::new());
        lines.extend(document.notes.iter().map(|note| format!("Note: {note}")));
    }
    lines.push(String::new());
    lines.join("\n")
}

fn names(factors: &[Axis]) -> String {
    factors.iter().map(|factor| factor.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// Six significant digits.
fn short(value: Option<f64>) -> String {
    match value {
        None => "–".into(),
        Some(0.0) => "0".into(),
        Some(value) => {
            let decimals = 5 - value.abs().log10().floor() as i32;
            if (0..=9).contains(&decimals) { format!("{value:.*}", decimals as usize) } else { format!("{value:.5e}") }
        }
    }
}

fn probability(p: f64) -> String {
    if p < 1e-4 { format!("{p:.1e}") } else { format!("{p:.4}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn json_of(name: &str, text: &str, factors: &str) -> serde_json::Value {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join(name);
        std::fs::write(&table, text).unwrap();
        let factors = factors.split(',').map(String::from).collect();
        let args = Regress { table, factors, response: "y".into(), block: None, alpha: 0.05, json: true };
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
    fn a_table_that_cannot_be_regressed_says_which_column_is_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join("t.csv");
        std::fs::write(&table, "a,y\n1,1\n1,2\n").unwrap();
        let mut args = Regress { table, factors: vec!["a".into()], response: "y".into(), block: None, alpha: 0.05, json: true };
        let why = regress(&args).err().unwrap().to_string();
        assert!(why.contains("factor “a” has levels 1 and 1"), "{why}");
        args.response = "z".into();
        let why = regress(&args).err().unwrap().to_string();
        assert!(why.contains("column “z”: there is no such column; the columns are a, y"), "{why}");
    }
}
