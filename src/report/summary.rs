//! `summary.json`: the results of a campaign for a script to read.
//!
//! Schema `hemline-summary-1`, described in docs/results.md: every key always present, `null` where a quantity does not exist, lengths in mm as
//! the key says.

use serde_json::{Value, json};

use super::{Provenance, note, words};
use crate::study::campaign::{CampaignStudy, Regression, RunStudy};
use crate::study::overview::overview;
use crate::units::MILLIMETRE;

/// The whole summary.
pub fn summary(study: &CampaignStudy, provenance: &Provenance) -> Value {
    let campaign = &study.campaign;
    let settings: serde_json::Map<String, Value> = provenance.settings.iter().map(|(k, v)| (k.clone(), json!(v))).collect();
    json!({
        "schema": "hemline-summary-1",
        "program": { "name": "hemline", "version": env!("CARGO_PKG_VERSION") },
        "date": provenance.date.map(|d| d.to_string()),
        "title": campaign.title,
        "origin": campaign.origin,
        "apparatus": campaign.apparatus,
        "settings": settings,
        "sources": provenance.sources,
        "factors": campaign.design.factors,
        "overview": overview(&study.runs),
        "runs": study.runs.iter().map(run).collect::<Vec<_>>(),
        "regressions": study.regressions.iter().map(regression).collect::<Vec<_>>(),
        "quarantine": provenance.quarantine,
        "notes": study.notes,
    })
}

fn run(study: &RunStudy) -> Value {
    let fit = study.fit.as_ref().ok();
    let mm = |v: f64| v / MILLIMETRE;
    json!({
        "run": study.run.id,
        "replicate": study.run.replicate,
        "levels": study.run.levels,
        "termination": fit.map(|f| note::termination(&f.termination)),
        "m": fit.and_then(|f| f.folds),
        "m_weight": fit.and_then(|f| f.folds.map(|_| f.folds_weight)),
        "p_mm": fit.map(|f| mm(f.p.value)),
        "q_mm": fit.and_then(|f| f.q).map(|e| mm(e.value)),
        "s_mm": fit.and_then(|f| f.s).map(|e| mm(e.value)),
        "rms_mm": fit.map(|f| mm(f.rms)),
        "fold_depth_mm": fit.map(|f| mm(f.fold_depth)),
        "explained_share": fit.and_then(|f| f.folds.map(|_| f.explained)),
        "lambda_first_integral_n_m2": study.lambda.first_integral.map(|(e, _)| e.value),
        "lambda_first_integral_r2": study.lambda.first_integral.map(|(_, r2)| r2),
        "lambda_over_weight": study.lambda.over_weight.map(|(e, _)| e.value),
        "predicted_m": study.prediction.as_ref().map(|p| p.folds),
        "theory_gap_mm": study.comparison.as_ref().map(|c| mm(c.rms)),
        "notes": note::of(study),
    })
}

fn regression(regression: &Regression) -> Value {
    let analysis = regression.analysis.as_ref().ok();
    json!({
        "response": regression.response,
        "unit": words::response(&regression.response).unit,
        "n": analysis.map(|a| a.used_runs.len()),
        "terms": analysis.map(|a| &a.coefficients),
        "residual_df": analysis.map(|a| a.residual_df),
        "t_critical": analysis.and_then(|a| a.t_critical),
        "equal_variances": analysis.and_then(|a| a.equal_variances.as_ref()),
        "adequacy": analysis.and_then(|a| a.adequacy.as_ref()),
        "r_squared": analysis.and_then(|a| a.full.r_squared()),
        "notes": analysis.map(|a| &a.notes),
        "failure": regression.analysis.as_ref().err(),
    })
}
