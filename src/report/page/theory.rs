//! Theory against measurement: pairs of predicted and fitted numbers, run by run, and the fidelities side by side.

use serde_json::{Value, json};

use super::response::texts;
use super::table::{Column, of_texts};
use crate::report::document::{beyond, cloth, theory};
use crate::study::campaign::{CampaignStudy, RunStudy};
use crate::units::MILLIMETRE;

/// `null` where nothing was predicted.
pub fn chapter(study: &CampaignStudy) -> Value {
    let printed = theory::chapter(study);
    if printed.is_null() {
        return Value::Null;
    }
    let of_run = |rows: &[Vec<String>]| -> Vec<Option<usize>> {
        rows.iter().map(|row| study.runs.iter().position(|run| run.run.id == row[0])).collect()
    };
    let rows = texts(&printed["rows"]);
    let mut parts = vec![];
    let effects = beyond::theory(study);
    if !effects.is_null() {
        parts.push(json!({
            "title": "Has the theory the right effects?",
            "items": [effects["words"]],
            "table": of_texts(&effect_columns(), filled_down(texts(&effects["rows"]))),
            "caption": "The same regression on the measured responses and on those of the predicted hems (least energy over all fold counts, fitted with the same \
                        curve), in coded units. The difference is tested run by run. Terms that are neither measured nor predicted beyond chance are left out.",
        }));
    }
    let runs = of_run(&rows);
    parts.push(json!({
        "title": "Theory and measurement in numbers",
        "table": of_texts(&run_columns(), rows),
        "runs": runs,
        "caption": "Radius: of the circle of equal area. Shape: rms distance of the measured points from the predicted and from the fitted hem. A row shows its run.",
    }));
    let sides = &printed["fidelities"];
    if !sides.is_null() {
        let solved = format!("Solved as {}.", sides["solved"].as_str().unwrap_or_default());
        parts.push(json!({
            "title": "Three theories side by side",
            "items": [
                "All three know only cloth and cut; nothing in them was fitted. Graded: every ring of cloth keeps its length and generatrices curve. Ruled: \
                 generatrices stay straight. Ansatz: the hem is one of the fitted family of curves. Shape and depth are compared at the fitted fold count, after \
                 the best shift and turn, because cloth is metastable; the fold count is the one of least energy."
            ],
            "table": of_texts(&cell_columns(), texts(&sides["cells"])),
            "caption": format!(
                "Over all runs and per cell: counts of runs, and medians over the runs whose fold count the theory has (rms distance of the points; depth, theory / fit; \
                 mean radius, theory − fit). {solved}"
            ),
        }));
        let rows = texts(&sides["runs"]);
        let runs = of_run(&rows);
        parts.push(json!({
            "title": "Three theories against every run",
            "table": of_texts(&side_columns(), rows),
            "runs": runs,
            "caption": format!("Fold count of least energy; at the fitted fold count rms distance of the points, and depth, theory / fit. {solved}"),
        }));
    }
    let cloth = cloth::chapter(study);
    if !cloth.is_null() {
        let rows = texts(&cloth["rows"]);
        let runs = of_run(&rows);
        let mut items = vec![json!(cloth::ABOUT)];
        items.extend(cloth["words"].as_array().into_iter().flatten().cloned());
        parts.push(json!({
            "title": "Cloth from its drape",
            "items": items,
            "table": of_texts(&cloth_columns(), rows),
            "runs": runs,
            "caption": "Flexural rigidity, µN·m. Misfit: rms distance between the hem of the theory at that rigidity and the fitted one.",
        }));
    }
    json!({ "words": printed["words"], "scatters": scatters(study), "parts": parts })
}

/// Predicted over fitted, mm or counts.
fn scatters(study: &CampaignStudy) -> Value {
    let mm = |v: f64| format!("{:.2}", v / MILLIMETRE).parse::<f64>().unwrap_or(v);
    let pairs = |pick: &dyn Fn(&RunStudy) -> Option<(f64, f64)>| -> Vec<Value> {
        let each = study.runs.iter().enumerate().filter_map(|(i, run)| Some((i, pick(run)?)));
        each.map(|(run, (x, y))| json!({ "run": run, "x": x, "y": y })).collect()
    };
    // The circle of equal area, as the comparison means it.
    let radius = |run: &RunStudy| {
        let (fit, c) = (run.fit.as_ref().ok()?, run.comparison.as_ref()?);
        let mean = (fit.area / std::f64::consts::PI).sqrt();
        Some((mm(mean), mm(mean + c.mean_radius)))
    };
    let depth = |run: &RunStudy| {
        let (fit, c) = (run.fit.as_ref().ok()?, run.comparison.as_ref()?);
        Some((mm(fit.fold_depth), mm(fit.fold_depth + c.depth)))
    };
    let folds = |run: &RunStudy| Some((f64::from(run.fit.as_ref().ok()?.folds?), f64::from(run.prediction.as_ref()?.folds)));
    json!([
        { "label": "Mean radius", "unit": "mm", "whole": false, "points": pairs(&radius) },
        { "label": "Fold depth", "unit": "mm", "whole": false, "points": pairs(&depth) },
        { "label": "Fold count", "unit": "", "whole": true, "points": pairs(&folds) },
    ])
}

/// A response is printed on the first of its rows only; sorted, every row needs it.
fn filled_down(mut rows: Vec<Vec<String>>) -> Vec<Vec<String>> {
    for i in 1..rows.len() {
        if rows[i][0].is_empty() {
            rows[i][0] = rows[i - 1][0].clone();
        }
    }
    rows
}

fn effect_columns() -> [Column; 7] {
    [
        Column::text("Response"),
        Column::text("Term"),
        Column::number("Measured", ""),
        Column::number("Predicted", ""),
        Column::number("Predicted − measured", ""),
        Column::number("p of the difference", ""),
        Column::text("Theory"),
    ]
}

fn run_columns() -> [Column; 10] {
    let n = |name: &str, unit: &str| Column::number(name, unit);
    [
        Column::text("Run"),
        n("m fitted", ""),
        n("m theory", ""),
        n("Radius fitted", "mm"),
        n("Radius, theory − fit", "mm"),
        n("Depth fitted", "mm"),
        n("Depth, theory − fit", "mm"),
        n("Shape, theory rms", "mm"),
        n("Shape, fit rms", "mm"),
        n("Energy", "mJ"),
    ]
}

fn cloth_columns() -> [Column; 10] {
    let n = |name: &str, unit: &str| Column::number(name, unit);
    [
        Column::text("Run"),
        n("Known", "µN·m"),
        n("Graded", "µN·m"),
        n("s.e., %", ""),
        n("Graded / known", ""),
        n("Misfit, mm", ""),
        n("Ruled", "µN·m"),
        n("s.e., %", ""),
        n("Ruled / known", ""),
        n("Misfit, mm", ""),
    ]
}

const SIDES: [&str; 3] = ["graded", "ruled", "ansatz"];

fn cell_columns() -> Vec<Column> {
    let groups = ["m exact", "m within one", "rms, mm", "Depth ratio", "Radius diff., mm"];
    let mut columns = vec![Column::words("Cell"), Column::number("n", "")];
    columns.extend(groups.iter().flat_map(|group| SIDES.map(|side| Column::number(*group, side))));
    columns
}

fn side_columns() -> Vec<Column> {
    let groups = ["m", "rms, mm", "Depth ratio"];
    let mut columns = vec![Column::text("Run"), Column::number("m", "fitted")];
    columns.extend(groups.iter().flat_map(|group| SIDES.map(|side| Column::number(*group, side))));
    columns
}
