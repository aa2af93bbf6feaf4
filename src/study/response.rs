//! Responses: which number of a run is regressed under which name.

use super::campaign::RunStudy;
use crate::experiment::Campaign;
use crate::units::{MILLIMETRE, PERCENT};

/// A response: the short name by which a campaign asks for it, and its column of the fits table, whose suffix is its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Response {
    pub name: &'static str,
    pub column: &'static str,
}

/// Every response that a campaign may ask for, by either name.
pub const RESPONSES: [Response; 15] = [
    Response { name: "p", column: "p_mm" },
    Response { name: "q", column: "q_mm" },
    Response { name: "s", column: "s_mm" },
    Response { name: "m", column: "m" },
    Response { name: "lambda", column: "lambda_first_integral_n_m2" },
    Response { name: "lambda_over_weight", column: "lambda_over_weight" },
    Response { name: "lambda_ritz", column: "lambda_ritz_n_m2" },
    Response { name: "lambda_ruled", column: "lambda_ruled_n" },
    Response { name: "rms", column: "rms_mm" },
    Response { name: "fold_depth", column: "fold_depth_mm" },
    Response { name: "mean_radius", column: "mean_radius_mm" },
    Response { name: "perimeter", column: "perimeter_mm" },
    Response { name: "explained", column: "explained_share" },
    Response { name: "drape_coefficient", column: "drape_coefficient_percent" },
    Response { name: "theory_gap", column: "theory_gap_mm" },
];

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
