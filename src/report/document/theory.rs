//! The chapter on theory against measurement: by how much they disagree, in mm.

use serde_json::{Value, json};

use crate::report::gallery::{cell_name, cells};
use crate::report::number::{fixed, signed, significant};
use crate::study::campaign::{CampaignStudy, RunStudy};
use crate::study::fidelities::{FIDELITIES, FidelitySummary, described, summarize};
use crate::study::overview::{Spread, TheoryOverview, overview};
use crate::units::{MILLIJOULE, MILLIMETRE};

/// For what does not exist.
const NONE: &str = "–";

/// `null` where nothing was predicted.
pub fn chapter(study: &CampaignStudy) -> Value {
    let Some(theory) = overview(&study.runs).theory else { return Value::Null };
    let rows: Vec<Value> = cells(&study.runs).iter().flat_map(|(_, runs)| runs).filter_map(|run| row(run)).collect();
    json!({ "words": words(&theory), "rows": rows, "fidelities": fidelities(study) })
}

/// The fidelities side by side: over all runs and per cell, and run by run; `null` where none was compared.
fn fidelities(study: &CampaignStudy) -> Value {
    if study.fidelities.is_empty() {
        return Value::Null;
    }
    let factors = &study.campaign.design.factors;
    let summaries = summarize(&study.fidelities);
    let millimetres = |v: Option<f64>| v.map_or_else(|| NONE.into(), mm);
    let ratio = |v: Option<f64>| v.map_or_else(|| NONE.into(), |r| fixed(r, 2));
    let line = |name: String, levels: Option<&[f64]>| {
        let rows = FIDELITIES.map(|(name, _)| summaries.iter().find(|s| s.fidelity == name && s.levels.as_deref() == levels && 0 < s.runs));
        let n = rows.iter().flatten().next()?.runs;
        let each = |said: &dyn Fn(&FidelitySummary) -> String| rows.map(|row| row.map_or_else(|| NONE.into(), said));
        let mut line = vec![name, n.to_string()];
        line.extend(each(&|s| s.exact.to_string()));
        line.extend(each(&|s| s.within_one.to_string()));
        line.extend(each(&|s| millimetres(s.rms)));
        line.extend(each(&|s| ratio(s.depth_ratio)));
        line.extend(each(&|s| s.mean_radius.map_or_else(|| NONE.into(), |v| signed(v / MILLIMETRE, 1))));
        Some(line)
    };
    let mut table: Vec<Vec<String>> = line("All runs".into(), None).into_iter().collect();
    table.extend(cells(&study.runs).iter().filter_map(|(levels, _)| line(cell_name(factors, levels).join(", "), Some(levels))));
    let runs: Vec<Value> = cells(&study.runs)
        .iter()
        .flat_map(|(_, runs)| runs)
        .filter_map(|run| {
            let of = |name: &str| study.fidelities.iter().find(|row| row.run == run.run.id && row.fidelity == name);
            let rows = FIDELITIES.map(|(name, _)| of(name));
            let known = rows.iter().flatten().next()?;
            let mut line = vec![known.run.clone(), known.fitted_folds.to_string()];
            line.extend(rows.iter().map(|row| row.map_or_else(|| NONE.into(), |r| r.predicted_folds.to_string())));
            line.extend(rows.iter().map(|row| millimetres(row.and_then(|r| r.comparison.as_ref()).map(|c| c.rms))));
            line.extend(rows.iter().map(|row| ratio(row.and_then(|r| r.depth_ratio))));
            Some(json!(line))
        })
        .collect();
    json!({ "solved": described().join("; "), "cells": table, "runs": runs })
}

/// What the comparison says, in sentences.
pub fn words(theory: &TheoryOverview) -> Vec<String> {
    let mut words = vec![format!(
        "Theory, {}, knows only cloth and cut; nothing in it was fitted. It predicts the fitted fold count in {} of {} runs and is within one in {}.",
        theory.fidelity, theory.folds_right, theory.runs, theory.folds_within_one
    )];
    if let Some(rms) = theory.rms {
        words.push(format!(
            "At the fitted fold count the measured points lie {} mm rms from the predicted hem (median; {} to {} mm).",
            mm(rms.median),
            mm(rms.low),
            mm(rms.high)
        ));
    }
    if let Some(radius) = theory.mean_radius {
        words.push(format!(
            "The predicted hem hangs {} (mean radius; {}).",
            sided(radius.median, "further out", "further in"),
            range(&radius)
        ));
    }
    if let Some(depth) = theory.depth {
        words.push(format!("The predicted folds are {} ({}).", sided(depth.median, "deeper", "shallower"), range(&depth)));
    }
    words
}

/// Why nothing was predicted, each reason once.
pub fn missing(study: &CampaignStudy) -> Vec<String> {
    let mut reasons: Vec<&str> = vec![];
    for reason in study.runs.iter().filter_map(|run| run.prediction_missing.as_deref()) {
        if !reasons.contains(&reason) {
            reasons.push(reason);
        }
    }
    reasons.into_iter().map(|reason| format!("There is no prediction to compare with: {}.", reason.trim_end_matches('.'))).collect()
}

fn mm(metres: f64) -> String {
    fixed(metres / MILLIMETRE, 1)
}

/// “9.1 mm further in”.
fn sided(metres: f64, positive: &str, negative: &str) -> String {
    format!("{} mm {}", mm(metres.abs()), if metres < 0.0 { negative } else { positive })
}

fn range(spread: &Spread) -> String {
    let signed = |v: f64| signed(v / MILLIMETRE, 1);
    format!("median of {} runs; {} to {} mm, theory − fit", spread.n, signed(spread.low), signed(spread.high))
}

fn row(study: &RunStudy) -> Option<Value> {
    let (fit, comparison, prediction) = (study.fit.as_ref().ok()?, study.comparison.as_ref()?, study.prediction.as_ref()?);
    let radius = (fit.area / std::f64::consts::PI).sqrt();
    let differs = Some(prediction.folds) != fit.folds;
    Some(json!([
        study.run.id,
        fit.folds.map_or_else(|| "round".into(), |m| m.to_string()),
        format!("{}{}", prediction.folds, if differs { " ≠" } else { "" }),
        mm(radius),
        signed(comparison.mean_radius / MILLIMETRE, 1),
        mm(fit.fold_depth),
        signed(comparison.depth / MILLIMETRE, 1),
        mm(comparison.rms),
        mm(fit.rms),
        significant(prediction.energy / MILLIJOULE, 4),
    ]))
}
