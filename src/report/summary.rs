//! `summary.json`: the results of a campaign for a script to read.
//!
//! Schema `hemline-summary-1`, described in docs/results.md: every key always present, `null` where a quantity does not exist, lengths in mm as
//! the key says.

use serde_json::{Value, json};

use super::analysis_table::{agreement, goal};
use super::{Provenance, note, words};
use crate::error::Error;
use crate::statistics::effects::EffectComparison;
use crate::study::campaign::{CampaignStudy, Regression, RunStudy};
use crate::study::further::Way;
use crate::study::overview::overview;
use crate::units::MILLIMETRE;

/// The file's text.
///
/// # Errors
/// [`Error::Output`] if a number of it cannot be written.
pub fn text(study: &CampaignStudy, provenance: &Provenance) -> Result<String, Error> {
    let failed = |error: serde_json::Error| Error::Output { what: "summary.json".into(), why: error.to_string() };
    serde_json::to_string_pretty(&summary(study, provenance)).map(|text| text + "\n").map_err(failed)
}

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
        "sources": study.sources,
        "factors": campaign.design.factors,
        "overview": overview(&study.runs),
        "runs": study.runs.iter().map(run).collect::<Vec<_>>(),
        "regressions": study.regressions.iter().map(regression).collect::<Vec<_>>(),
        "desirable": study.desirable.as_ref().and_then(|d| d.as_ref().ok()),
        "desirable_missing": study.desirable.as_ref().and_then(|d| d.as_ref().err()),
        "quarantine": study.quarantine,
        "notes": study.notes,
    })
}

fn run(study: &RunStudy) -> Value {
    let fit = study.fit.as_ref().ok();
    let mm = |v: f64| v / MILLIMETRE;
    let irregular = study.irregular.as_ref();
    let lack = irregular.and_then(|i| i.lack_of_fit.as_ref().ok());
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
        "p_se_mm": fit.and_then(|f| f.p.standard_error).map(mm),
        "q_se_mm": fit.and_then(|f| f.q).and_then(|e| e.standard_error).map(mm),
        "s_se_mm": fit.and_then(|f| f.s).and_then(|e| e.standard_error).map(mm),
        "standard_error_missing": fit.map(|f| &f.standard_error_missing),
        "correlation": fit.and_then(|f| f.correlation),
        "bias_correction": fit.map(|f| &f.bias_correction),
        "intervals": fit.and_then(|f| f.intervals.as_ref()),
        "rms_mm": fit.map(|f| mm(f.rms)),
        "fold_depth_mm": fit.map(|f| mm(f.fold_depth)),
        "explained_share": fit.and_then(|f| f.folds.map(|_| f.explained)),
        "lambda_first_integral_n_m2": study.lambda.first_integral.map(|(e, _)| e.value),
        "lambda_first_integral_r2": study.lambda.first_integral.map(|(_, r2)| r2),
        "lambda_over_weight": study.lambda.over_weight.map(|(e, _)| e.value),
        "lack_of_fit_f": lack.map(|t| t.f),
        "lack_of_fit_p": lack.map(|t| t.p),
        "crests": irregular.map(|i| i.table.folds.len()),
        "depth_variation": irregular.and_then(|i| i.table.depth_variation),
        "width_variation": irregular.and_then(|i| i.table.width_variation),
        "predicted_m": study.prediction.as_ref().map(|p| p.folds),
        "theory_gap_mm": study.comparison.as_ref().map(|c| mm(c.rms)),
        "notes": note::of(study),
    })
}

fn regression(regression: &Regression) -> Value {
    let (analysis, further) = (regression.analysis.as_ref().ok(), regression.further.as_ref().ok());
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
        "curvature": analysis.and_then(|a| a.curvature.as_ref()),
        "blocks": analysis.map(|a| &a.blocks),
        "diagnostics": further.map(|f| &f.diagnostics),
        "permutation": further.map(|f| &f.permutation),
        "box_cox": further.and_then(|f| f.box_cox),
        "power": further.map(|f| &f.detectable),
        "steepest": further.map(|f| f.ways.iter().map(way).collect::<Vec<_>>()),
        "next_runs": further.map(|f| &f.next_runs),
        "weighted": further.and_then(|f| f.weighted.as_ref()),
        "theory": further.and_then(|f| f.theory.as_ref().ok()).map(|terms| terms.iter().map(theory).collect::<Vec<_>>()),
        "theory_missing": further.and_then(|f| f.theory.as_ref().err()),
        "notes": analysis.map(|a| &a.notes),
        "failure": regression.analysis.as_ref().err(),
    })
}

fn way(way: &Way) -> Value {
    json!({ "goal": goal(way.goal), "path": way.path.as_ref().ok(), "missing": way.path.as_ref().err() })
}

fn theory(c: &EffectComparison) -> Value {
    json!({
        "term": c.term,
        "measured": c.measured.estimate,
        "measured_se": c.measured.se,
        "predicted": c.predicted,
        "difference": c.difference.estimate,
        "difference_se": c.difference.se,
        "difference_p": c.difference.p,
        "agreement": agreement(c.agreement),
    })
}
