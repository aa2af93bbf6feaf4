//! Responses: which number of a run is regressed under which name.

use super::campaign::RunStudy;
use crate::experiment::Campaign;
use crate::units::MILLIMETRE;

/// A response by name: its unit and what it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Response {
    pub name: &'static str,
    pub unit: &'static str,
    pub meaning: &'static str,
}

/// Every response that a campaign may ask for.
pub const RESPONSES: [Response; 15] = [
    Response { name: "p", unit: "mm", meaning: "mean radius of the hem" },
    Response { name: "q", unit: "mm", meaning: "fold amplitude" },
    Response { name: "s", unit: "mm", meaning: "sideways lean of the folds" },
    Response { name: "m", unit: "folds", meaning: "fold count" },
    Response { name: "lambda", unit: "N/m²", meaning: "multiplier λ by the first integral" },
    Response { name: "lambda_over_weight", unit: "1", meaning: "multiplier over weight, λ/(ρ_A g), by the first integral" },
    Response { name: "lambda_ritz", unit: "N/m²", meaning: "multiplier λ by the Ritz condition" },
    Response { name: "lambda_ruled", unit: "mN", meaning: "multiplier λ of the ruled shell" },
    Response { name: "rms", unit: "mm", meaning: "root mean square distance of the outline from the curve" },
    Response { name: "fold_depth", unit: "mm", meaning: "fold depth, greatest minus least radius of the curve" },
    Response { name: "mean_radius", unit: "mm", meaning: "radius of the circle of equal area" },
    Response { name: "perimeter", unit: "mm", meaning: "perimeter of the curve" },
    Response { name: "explained", unit: "%", meaning: "share of the outline's departure from a circle that the curve explains" },
    Response { name: "drape_coefficient", unit: "%", meaning: "drape coefficient" },
    Response { name: "theory_gap", unit: "mm", meaning: "root mean square distance of the outline from the predicted hem" },
];

/// The response of that name; λ stands for λ/(ρ_A g) in a campaign whose cloth was not weighed.
pub fn named(name: &str, weighed: bool) -> Option<Response> {
    let name = if name == "lambda" && !weighed { "lambda_over_weight" } else { name };
    RESPONSES.into_iter().find(|r| r.name == name)
}

/// Whether any run of the campaign has an areal density.
pub fn weighed(campaign: &Campaign) -> bool {
    campaign.design.runs.iter().any(|run| run.fabric.areal_density.is_some())
}

/// The value of a response for one run, in the response's unit; `None` where it does not exist.
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
        "lambda_ruled" => run.lambda.ruled.map(|(estimate, _)| estimate.value / crate::units::MILLINEWTON),
        "rms" => Some(millimetres(fit.rms)),
        "fold_depth" => Some(millimetres(fit.fold_depth)),
        "mean_radius" => Some(millimetres((fit.area / std::f64::consts::PI).sqrt())),
        "perimeter" => Some(millimetres(fit.perimeter)),
        "explained" => Some(fit.explained / crate::units::PERCENT),
        "drape_coefficient" => run.drape_coefficient.map(|share| share / crate::units::PERCENT),
        "theory_gap" => run.comparison.as_ref().map(|c| millimetres(c.rms)),
        _ => None,
    }
}
