//! Table, sentences and figure of the study of hard cases.

use serde_json::{Value, json};

use super::csv::Table;
use super::figure::heat_map;
use super::number;
use super::study_section::{SectionFigure, SectionTable, StudySection};
use crate::error::Error;
use crate::study::hard_cases::{Outcome, Subject};
use crate::study::stability::StabilityStudy;

/// The study as a section of a report.
///
/// # Errors
/// [`Error::Output`] if the figure cannot be drawn.
pub fn section(study: &StabilityStudy) -> Result<StudySection, Error> {
    let figure = SectionFigure {
        stem: "stability".into(),
        caption: "Hard cases at growing severity (left to right; the severity is printed small), coloured by the decimal digits kept, which are printed \
                  large. Hatched: refused with a reason. Dot: an answer with a warning. A crossed red cell would be wrong without saying."
            .into(),
        svg: heat_map::draw(&study.cases)?,
    };
    Ok(StudySection {
        stem: "study_stability".into(),
        title: "What stays stable".into(),
        sentences: sentences(study),
        tables: vec![SectionTable {
            stem: "stability".into(),
            caption: "Hard cases: up to which severity the answer is right, and what follows".into(),
            table: table(study),
            short: short(study),
        }],
        figures: vec![figure],
    })
}

/// As tables name it.
pub fn outcome_name(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Right => "right",
        Outcome::Warned => "warned",
        Outcome::NoAnswer => "no answer",
        Outcome::Wrong => "wrong",
    }
}

fn subject_name(subject: Subject) -> &'static str {
    match subject {
        Subject::Fit => "fit",
        Subject::Theory => "theory",
        Subject::Statistics => "statistics",
    }
}

/// `stability.csv`: every cell.
pub fn table(study: &StabilityStudy) -> Table {
    let mut table = Table::new(&[
        "subject",
        "case",
        "what_grows",
        "severity",
        "outcome",
        "digits_kept",
        "digits_promised",
        "condition",
        "evaluations",
        "draws",
        "said",
        "reference",
    ]);
    for case in &study.cases {
        for cell in &case.cells {
            table.push(vec![
                subject_name(case.subject).into(),
                case.name.into(),
                case.title.into(),
                cell.severity.into(),
                outcome_name(cell.outcome).into(),
                cell.digits.into(),
                cell.promised.into(),
                cell.condition.filter(|c| c.is_finite()).into(),
                cell.evaluations.into(),
                cell.draws.into(),
                cell.said.clone().into(),
                case.reference.into(),
            ]);
        }
    }
    table
}

/// A line a case: the last severity of an unbroken run of right answers, and what comes next.
fn short(study: &StabilityStudy) -> Vec<Vec<String>> {
    let mut rows = vec![["Subject", "What grows", "Right up to", "Digits there", "Then"].map(String::from).to_vec()];
    for case in &study.cases {
        let right = case.cells.iter().take_while(|cell| cell.outcome == Outcome::Right).count();
        let last = right.checked_sub(1).map(|i| &case.cells[i]);
        let digits = last.and_then(|cell| cell.digits);
        rows.push(vec![
            subject_name(case.subject).into(),
            case.title.into(),
            last.map_or_else(|| "–".into(), |cell| severity(cell.severity)),
            digits.map_or_else(|| "–".into(), |digits| number::fixed(digits, 0)),
            case.cells.get(right).map_or("right throughout", |cell| outcome_name(cell.outcome)).into(),
        ]);
    }
    rows
}

/// A severity in few letters.
pub fn severity(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".into()
    } else if (1e-3..1e4).contains(&size) {
        format!("{}", (value * 1e4).round() / 1e4)
    } else {
        format!("{value:e}")
    }
}

fn sentences(study: &StabilityStudy) -> Vec<String> {
    let cells = || study.cases.iter().flat_map(|case| &case.cells);
    let of = |outcome: Outcome| cells().filter(|cell| cell.outcome == outcome).count();
    let draws: usize = cells().map(|cell| cell.draws).sum();
    let wrong = of(Outcome::Wrong);
    let mut sentences = vec![
        format!(
            "{} hard cases at {} severities each, {draws} computations.",
            study.cases.len(),
            study.cases.first().map_or(0, |case| case.cells.len())
        ),
        format!(
            "{} cells are right, {} have an answer with a warning, {} were refused with a reason, {wrong} {} wrong without saying.",
            of(Outcome::Right),
            of(Outcome::Warned),
            of(Outcome::NoAnswer),
            if wrong == 1 { "is" } else { "are" }
        ),
    ];
    for (case, cell) in study.wrong() {
        sentences.push(format!("Wrong: {} at {}: {}.", case.title, severity(cell.severity), cell.said));
    }
    sentences
}

/// Everything, SI units.
pub fn json(study: &StabilityStudy) -> Value {
    // JSON has no infinity: a condition without bound is null there.
    json!({ "options": study.options, "cases": study.cases })
}
