//! The estimates of one analysis, to hold a later one against.

use serde::{Deserialize, Serialize};

use super::campaign::CampaignStudy;
use crate::fit::Estimate;
use crate::units::MILLIMETRE;

/// Name and version of the format.
pub const SCHEMA: &str = "hemline-baseline-1";

/// Every coefficient of every response, and p, q, s, m of every fitted run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    /// [`SCHEMA`].
    pub schema: String,
    /// Program and version that made the estimates.
    pub program: String,
    /// Title of the campaign.
    pub campaign: String,
    pub coefficients: Vec<CoefficientRecord>,
    pub runs: Vec<RunRecord>,
}

/// A coefficient in coded units; the response's suffix is the unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoefficientRecord {
    pub response: String,
    pub term: String,
    pub estimate: f64,
    pub se: Option<f64>,
}

/// An estimate of one run; the quantity's suffix is the unit. The fold count has no standard error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    pub run: String,
    pub quantity: String,
    pub estimate: f64,
    pub se: Option<f64>,
}

impl Baseline {
    /// What `study` found.
    pub fn of(study: &CampaignStudy) -> Self {
        let coefficients =
            study.regressions.iter().filter_map(|r| Some((&r.response, r.analysis.as_ref().ok()?))).flat_map(|(response, analysis)| {
                analysis.coefficients.iter().chain(&analysis.curvature).chain(&analysis.blocks).map(|c| CoefficientRecord {
                    response: response.clone(),
                    term: c.term.clone(),
                    estimate: c.estimate,
                    se: c.se,
                })
            });
        let fitted = study.runs.iter().filter_map(|run| Some((&run.run.id, run.fit.as_ref().ok()?)));
        let runs = fitted.flat_map(|(id, fit)| {
            let length = |quantity: &str, estimate: Option<Estimate>| {
                let Estimate { value, standard_error } = estimate?;
                Some((quantity.to_string(), value / MILLIMETRE, standard_error.map(|e| e / MILLIMETRE)))
            };
            let folds = fit.folds.map(|m| ("m".to_string(), f64::from(m), None));
            [length("p_mm", Some(fit.p)), length("q_mm", fit.q), length("s_mm", fit.s), folds]
                .into_iter()
                .flatten()
                .map(|(quantity, estimate, se)| RunRecord { run: id.clone(), quantity, estimate, se })
        });
        Baseline {
            schema: SCHEMA.into(),
            program: concat!("hemline ", env!("CARGO_PKG_VERSION")).into(),
            campaign: study.campaign.title.clone(),
            coefficients: coefficients.collect(),
            runs: runs.collect(),
        }
    }

    /// How many estimates there are.
    pub fn len(&self) -> usize {
        self.coefficients.len() + self.runs.len()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
