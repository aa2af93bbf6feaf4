//! Profiles → fits → responses → regression: one campaign, all of it.

use serde::Serialize;

use crate::experiment::{Campaign, DrapeProfile, Run};
use crate::fit::HemFit;
use crate::fit::lambda::Lambda;
use crate::simulate::Prediction;
use crate::statistics::box_wilson::Analysis;

/// Theory against measurement for one run, after the best shift and turn; metres.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Predicted fold count minus fitted fold count.
    pub folds: i64,
    /// Root mean square distance of the measured points from the predicted hem at the measured fold count, m.
    pub rms: f64,
    /// Predicted minus fitted fold depth, m.
    pub depth: f64,
    /// Predicted minus fitted mean radius (of equal area), m.
    pub mean_radius: f64,
    /// Where the prediction at the measured fold count was laid over the measurement.
    pub placement: crate::model::hem::Placement,
}

/// Everything known about one run.
#[derive(Debug, Clone)]
pub struct RunStudy {
    pub run: Run,
    /// `None`: the profile was set aside; the reason is in the quarantine.
    pub profile: Option<DrapeProfile>,
    /// The fit, or why there is none.
    pub fit: Result<HemFit, String>,
    pub lambda: Lambda,
    /// The hem of least energy over all fold counts.
    pub prediction: Option<Prediction>,
    /// The hem of least energy at the fitted fold count.
    pub prediction_at_fitted_folds: Option<Prediction>,
    pub comparison: Option<Comparison>,
}

/// One campaign, analysed.
#[derive(Debug, Clone)]
pub struct CampaignStudy {
    pub campaign: Campaign,
    /// In run order.
    pub runs: Vec<RunStudy>,
    /// One for each response of the campaign, in its order.
    pub regressions: Vec<Regression>,
    /// What a reader should know about the whole, in words.
    pub notes: Vec<String>,
}

/// One response regressed on the factors.
#[derive(Debug, Clone)]
pub struct Regression {
    /// Named like its column of the fits table, unit suffix included: the analysis is in that unit.
    pub response: String,
    /// The analysis, or why there is none.
    pub analysis: Result<Analysis, String>,
}
