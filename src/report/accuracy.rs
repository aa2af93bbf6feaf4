//! Tables, sentences and figures of the study of what accuracy costs in time.

use serde_json::{Value, json};

use super::csv::{Cell, Table};
use super::figure::{asked, work_precision};
use super::number;
use super::study_section::{Machine, SectionFigure, SectionTable, StudySection};
use crate::error::Error;
use crate::study::accuracy::front::{Cost, default_excess, front};
use crate::study::accuracy::{AccuracyStudy, Measure, Panel, Row};
use crate::units::MILLIMETRE;

/// Of a second.
const MILLISECOND: f64 = 1e-3;

/// The study as a section of a report.
///
/// # Errors
/// [`Error::Output`] if a figure cannot be drawn.
pub fn section(study: &AccuracyStudy, machine: &Machine) -> Result<StudySection, Error> {
    let figure = |stem: &str, caption: String, svg: String| SectionFigure { stem: stem.into(), caption, svg };
    let legend = "Each mark is one setting; the line is the Pareto front, the ring what the program does unless told, crosses on the upper edge have no result.";
    let figures = vec![
        figure(
            "accuracy_seconds",
            format!("Error on the profile against seconds, on {} ({} threads). {legend}", machine.name, machine.threads),
            work_precision::draw(&study.panels, Cost::Seconds)?,
        ),
        figure(
            "accuracy_evaluations",
            format!("Error on the profile against evaluations, the same on every machine. {legend}"),
            work_precision::draw(&study.panels, Cost::Evaluations)?,
        ),
        figure(
            "accuracy_asked",
            "Error that was asked for and error that was delivered; below the line everything is as promised.".into(),
            asked::draw(&study.panels)?,
        ),
    ];
    Ok(StudySection {
        stem: "study_accuracy".into(),
        title: "What accuracy costs in time".into(),
        sentences: sentences(study, machine),
        tables: vec![SectionTable {
            stem: "accuracy".into(),
            caption: "The program's defaults beside the cheapest setting that is at least as accurate".into(),
            table: table(study, machine),
            short: short(study),
        }],
        figures,
    })
}

/// `accuracy.csv`: every row.
pub fn table(study: &AccuracyStudy, machine: &Machine) -> Table {
    let mut table = Table::new(&[
        "panel",
        "method",
        "knob",
        "setting",
        "asked_mm",
        "asked_measure",
        "slack",
        "error_rms_mm",
        "error_max_mm",
        "delivered",
        "seconds",
        "evaluations",
        "evaluation",
        "termination",
        "default",
        "on_front_seconds",
        "on_front_evaluations",
        "reference",
        "machine",
        "threads",
    ]);
    for panel in &study.panels {
        let (seconds, evaluations) = (front(panel, Cost::Seconds), front(panel, Cost::Evaluations));
        for (i, row) in panel.rows.iter().enumerate() {
            let cells: Vec<Cell> = vec![
                panel.name.into(),
                row.method.clone().into(),
                row.knob.into(),
                row.setting.into(),
                row.asked.map(|asked| asked.error / MILLIMETRE).into(),
                row.asked.map(|asked| measure(asked.measure)).into(),
                row.asked.map(|asked| asked.slack).into(),
                row.error.map(|error| error.rms / MILLIMETRE).into(),
                row.error.map(|error| error.max / MILLIMETRE).into(),
                row.delivered().into(),
                row.seconds.into(),
                row.evaluations.into(),
                panel.unit.into(),
                row.termination.clone().into(),
                row.default.into(),
                seconds.contains(&i).into(),
                evaluations.contains(&i).into(),
                panel.reference.clone().into(),
                machine.name.clone().into(),
                machine.threads.into(),
            ];
            table.push(cells);
        }
    }
    table
}

fn measure(measure: Measure) -> &'static str {
    match measure {
        Measure::Rms => "rms",
        Measure::Max => "max",
    }
}

fn default_row(panel: &Panel) -> Option<&Row> {
    panel.rows.iter().find(|row| row.default)
}

/// Settings are round numbers: 1 × 10⁻¹⁰ has no digits behind the point.
fn setting(row: &Row) -> String {
    let said = number::plain(row.setting);
    match said.split_once(" × ") {
        Some((number, power)) => format!("{} × {power}", number.trim_end_matches('0').trim_end_matches('.')),
        None => said,
    }
}

/// Defaults, one line a panel.
fn short(study: &AccuracyStudy) -> Vec<Vec<String>> {
    let mut rows =
        vec![["Computation", "Default", "Error, mm", "Seconds", "Seconds × cheapest", "Evaluations × cheapest"].map(String::from).to_vec()];
    for panel in &study.panels {
        let Some(row) = default_row(panel) else { continue };
        let ratio = |cost: Cost| default_excess(panel, cost).map_or_else(|| "–".into(), |ratio| number::significant(ratio, 2));
        rows.push(vec![
            panel.title.into(),
            format!("{}, {} {}", row.method, row.knob, setting(row)),
            row.error.map_or_else(|| "none".into(), |error| number::significant(error.rms / MILLIMETRE, 2)),
            number::significant(row.seconds, 2),
            ratio(Cost::Seconds),
            ratio(Cost::Evaluations),
        ]);
    }
    rows
}

/// What there is to be said.
fn sentences(study: &AccuracyStudy, machine: &Machine) -> Vec<String> {
    let rows = || study.panels.iter().flat_map(|panel| &panel.rows);
    let (asked, kept) = (rows().filter(|r| r.delivered().is_some()).count(), rows().filter(|r| r.delivered() == Some(true)).count());
    let unmet = rows().filter(|r| r.asked.is_some() && !r.claims).count();
    let failed = rows().filter(|r| r.error.is_none()).count();
    let mut sentences = vec![
        format!(
            "{} computations; times on {} with {} threads, each the least of a few repeats after a warm-up, one computation at a time.",
            rows().count(),
            machine.name,
            machine.threads
        ),
        format!("An accuracy was asked for {} times and claimed {asked} times; it was delivered in {kept} of these.", asked + unmet),
    ];
    if 0 < unmet {
        sentences[1] += &format!(" Where it could not be reached ({unmet}), the program said so.");
    }
    if 0 < failed {
        sentences.push(format!("{failed} computations gave no result; they are rows of the table, with the reason."));
    }
    for panel in &study.panels {
        if let (Some(row), Some(ratio)) = (default_row(panel), default_excess(panel, Cost::Seconds)) {
            let error = row
                .error
                .map_or_else(String::new, |e| format!(" {} mm rms from the reference", number::significant(e.rms / MILLIMETRE, 2)));
            let place = if ratio <= 1.0 + 1e-9 {
                "no setting is as accurate and faster".to_string()
            } else {
                format!("the fastest setting as accurate takes {} of its time", number::significant(1.0 / ratio, 2))
            };
            sentences.push(format!(
                "{}: the default ({}, {} {}) is{error} in {} ms; {place}.",
                panel.title,
                row.method,
                row.knob,
                setting(row),
                number::significant(row.seconds / MILLISECOND, 2)
            ));
        }
    }
    sentences
}

/// Everything, SI units, with the machine.
pub fn json(study: &AccuracyStudy, machine: &Machine) -> Value {
    json!({ "machine": machine.name, "threads": machine.threads, "options": study.options, "panels": study.panels })
}
