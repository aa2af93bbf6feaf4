//! Responses: which number of a run is regressed under which name.

use super::campaign::RunStudy;
use crate::experiment::Campaign;
use crate::experiment::campaign::{RESPONSES, Response};
use crate::units::{MILLIMETRE, PERCENT};

/// The response of that name; `lambda` is λ/(ρ_A g) in a campaign whose cloth was not weighed.
pub fn named(name: &str, weighed: bool) -> Option<Response> {
    let name = if name == "lambda" && !weighed { "lambda_over_weight" } else { name };
    RESPONSES.into_iter().find(|r| r.name == name || r.column == name)
}

/// Whether any run of the campaign has an areal density.
pub fn weighed(campaign: &Campaign) -> bool {
    campaign.design.runs.iter().any(|run| run.fabric.areal_density.is_some())
}

/// The value of a response for one run, in the unit of its column; `None` where it does not exist.
pub fn value(response: &Response, run: &RunStudy) -> Option<f64> {
    let fit = run.fit.as_ref().ok()?;
    let millimetres = |metres: f64| metres / MILLIMETRE;
    match response.name {
        "p" => Some(millimetres(fit.p.value)),
        "q" => fit.q.map(|q| millimetres(q.value)),
        "s" => fit.s.map(|s| millimetres(s.value)),
        "m" => fit.folds.map(f64::from),
        "lambda" => run.lambda.first_integral.map(|(estimate, _)| estimate.value),
        "lambda_over_weight" => run.lambda.over_weight.map(|(estimate, _)| estimate.value),
        "lambda_ritz" => run.lambda.ritz.map(|(estimate, _)| estimate.value),
        "lambda_ruled" => run.lambda.ruled.map(|(estimate, _)| estimate.value),
        "rms" => Some(millimetres(fit.rms)),
        "fold_depth" => Some(millimetres(fit.fold_depth)),
        "mean_radius" => Some(millimetres((fit.area / std::f64::consts::PI).sqrt())),
        "perimeter" => Some(millimetres(fit.perimeter)),
        "explained" => Some(fit.explained),
        "drape_coefficient" => run.drape_coefficient.map(|share| share / PERCENT),
        "theory_gap" => run.comparison.as_ref().map(|c| millimetres(c.rms)),
        _ => None,
    }
}

/// The standard error that the fit of a run gives a response, in the unit of its column; `None` where it gives none.
pub fn standard_error(response: &Response, run: &RunStudy) -> Option<f64> {
    let fit = run.fit.as_ref().ok()?;
    let estimate = match response.name {
        "p" => Some(fit.p),
        "q" => fit.q,
        "s" => fit.s,
        "lambda" => return run.lambda.first_integral.and_then(|(estimate, _)| estimate.standard_error),
        "lambda_over_weight" => return run.lambda.over_weight.and_then(|(estimate, _)| estimate.standard_error),
        "lambda_ritz" => return run.lambda.ritz.and_then(|(estimate, _)| estimate.standard_error),
        "lambda_ruled" => return run.lambda.ruled.and_then(|(estimate, _)| estimate.standard_error),
        _ => None,
    };
    estimate.and_then(|e| e.standard_error).map(|metres| metres / MILLIMETRE)
}

/// The response of the predicted hem of each run, `as_measured` being that hem treated like a measured one; or why theory has no such response.
pub fn predicted(response: &Response, runs: &[RunStudy], as_measured: &[Option<RunStudy>]) -> Result<Vec<Option<f64>>, String> {
    if matches!(response.name, "rms" | "explained" | "theory_gap") {
        return Err("it tells how well a curve meets measured points, which theory does not predict".into());
    }
    if runs.iter().all(|run| run.prediction.is_none()) {
        let why = runs.iter().find_map(|run| run.prediction_missing.clone());
        return Err(why.unwrap_or_else(|| "nothing is predicted".into()));
    }
    Ok(match response.name {
        // Also where no curve can be fitted to the predicted hem.
        "m" => runs.iter().map(|run| run.prediction.as_ref().map(|p| f64::from(p.folds))).collect(),
        _ => as_measured.iter().map(|run| value(response, run.as_ref()?)).collect(),
    })
}
