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
