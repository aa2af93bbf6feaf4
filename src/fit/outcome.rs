//! What a fit returns: estimates with their uncertainty, and how the fit ended.

use serde::Serialize;

use super::bias::BiasCorrection;
use super::intervals::Intervals;
use super::uncertainty::MissingError;
use crate::experiment::Point;
use crate::model::hem::{Hem, Placement};
use crate::numerics::least_squares::{Loss, Round, State};

/// A value with its standard error; `None` where the data do not determine it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    pub value: f64,
    pub standard_error: Option<f64>,
}

/// A rule that a sane fit of an outline obeys (MODEL section 6).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Rule {
    /// Points meet the curve in order, once round.
    Order,
    /// The curve is about as long as the outline.
    Length,
    /// The curve crosses itself only if the outline does.
    Simplicity,
    /// The curve is near the outline everywhere, not only near every point.
    Nearness,
}

/// How a fit ended.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Termination {
    /// The free orthogonal optimum, and it is a sane curve.
    Converged,
    /// The free optimum broke a rule; this is the optimum at the held hem length.
    HeldLength { broken: Rule },
    /// Even the fit at the held length broke a rule; this is the curve matched to the outline in order at that length, which is not a
    /// minimum of the orthogonal distance.
    InOrder { broken: Rule },
    /// The hem length was held because it was asked.
    LengthAsAsked,
    /// Of a candidate only: its match is too far from the outline for any fit of it to compete with the best.
    NotPursued,
    /// The outline is round within its noise: no folds to count.
    NoFolds,
    /// The iteration stopped making progress before its tolerance; the estimates are usable with care.
    Stalled,
    /// The evaluation limit was reached.
    EvaluationLimit,
}

/// One fold count that was tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Candidate {
    /// Fold count; 0 is the circle.
    pub folds: u32,
    /// Root mean square orthogonal distance, m.
    pub rms: f64,
    /// Akaike's criterion, corrected for few points.
    pub aicc: f64,
    /// Akaike weight among the sane candidates; `None` if this one is not sane.
    pub weight: Option<f64>,
    pub termination: Termination,
    /// The rule it breaks, if it does: then it was not chosen from.
    pub broken: Option<Rule>,
}

/// A hem length that was held, and what it cost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HeldLength {
    /// m.
    pub length: f64,
    /// Change of half the sum of squared distances per metre of hem length, m.
    pub multiplier: f64,
}

/// What a loss other than squares made of the points.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RobustOutcome {
    pub loss: Loss,
    /// Standard deviation of the distances of the bulk of the points, 1.4826 · median |d|, m (of √w d where points have weights).
    pub scale: f64,
    /// Weight that the loss gives to each point of the profile, 0…1.
    pub weights: Vec<f64>,
    /// Points that weigh less than one half.
    pub downweighted: usize,
    /// Evaluations spent, and how it ended, for each round of reweighting.
    pub rounds: Vec<Round>,
    /// Whether the weights came to rest.
    pub settled: bool,
}

/// The paper's curve fitted to one outline.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HemFit {
    /// p, q, s, m in canonical form.
    pub hem: Hem,
    /// Centre and phase.
    pub placement: Placement,
    pub p: Estimate,
    /// `None` where the outline shows no folds.
    pub q: Option<Estimate>,
    pub s: Option<Estimate>,
    /// Standard errors of x0, y0 (m) and phase (rad).
    pub placement_errors: [Option<f64>; 3],
    /// Covariance of (p, q, s), m²: `σ̂²(JᵀJ)⁻¹`; `None` where the outline does not determine them.
    pub covariance: Option<[[f64; 3]; 3]>,
    /// Correlation of (x0, y0, phase, p, q, s); `None` where one of them has no standard error.
    pub correlation: Option<[[f64; 6]; 6]>,
    /// Every estimate without a standard error, and why.
    pub standard_error_missing: Vec<MissingError>,
    /// Points less determined unknowns.
    pub degrees_of_freedom: usize,
    /// What became of the bias of curvature; distances, feet and rms are those of the curve reported, corrected or not.
    pub bias_correction: BiasCorrection,
    /// Confidence intervals, where they were asked for (`study::intervals`).
    pub intervals: Option<Intervals>,
    /// `None` where the outline shows no folds.
    pub folds: Option<u32>,
    /// Akaike weight of the chosen fold count among the sane candidates.
    pub folds_weight: f64,
    /// Fold counts that are as credible as the one chosen, which is among them, ascending, 0 for the circle; empty where there is but one.
    pub ties: Vec<u32>,
    /// Every fold count tried, ascending.
    pub candidates: Vec<Candidate>,
    /// Signed orthogonal distance of each outline point, m; positive outside; `distances[i]` belongs to point `i` of the profile.
    pub distances: Vec<f64>,
    /// The curve parameter of each foot point.
    pub feet: Vec<f64>,
    /// Root mean square distance, m.
    pub rms: f64,
    /// Perimeter of the fitted curve, m.
    pub perimeter: f64,
    /// Area inside the fitted curve, m².
    pub area: f64,
    /// max r − min r of the fitted curve about its centre, m.
    pub fold_depth: f64,
    /// The outline's own smoothed length, m.
    pub outline_length: f64,
    /// Share of the outline's mean squared departure from its best circle that the curve explains, 0…1.
    pub explained: f64,
    pub held: Option<HeldLength>,
    pub termination: Termination,
    /// What became of x0, y0, phase, p, q, s: free, fixed, or at a bound.
    pub states: [State; 6],
    /// How the points were weighed, if the loss was not that of least squares. `rms` and `explained` are then over the points with these weights.
    pub robust: Option<RobustOutcome>,
    /// Evaluations of the residual vector, over all candidates.
    pub evaluations: usize,
    /// What a reader of the numbers should know, in words.
    pub notes: Vec<String>,
}

impl HemFit {
    /// The fitted curve as `n` points round, in the frame of the measurement, m.
    pub fn outline(&self, n: usize) -> Vec<Point> {
        self.hem.outline(&self.placement, n)
    }
}
