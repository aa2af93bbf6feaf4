//! Forward: skirt + fabric + terms → predicted hem. Nothing here is fitted.

use serde::Serialize;

use crate::experiment::Point;

/// How a minimization ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Termination {
    Converged,
    Stalled,
    EvaluationLimit,
    /// The round cone is stable: there are no folds. An answer, not a failure.
    Round,
}

/// The energy of one term at the solution.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TermEnergy {
    pub term: &'static str,
    /// J.
    pub energy: f64,
    pub evaluations: usize,
}

/// One branch of solutions: its fold count and what it costs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Branch {
    /// Fold count that was asked for.
    pub asked: u32,
    /// True period of the solution: a branch may slide to a subharmonic.
    pub folds: u32,
    /// J.
    pub energy: f64,
    /// max r − min r, m.
    pub depth: f64,
    pub termination: Termination,
}

/// A predicted hem.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prediction {
    /// `ruled(K = 8)` …
    pub fidelity: String,
    /// 0: round, no folds.
    pub folds: u32,
    /// J.
    pub energy: f64,
    pub terms: Vec<TermEnergy>,
    /// m.
    pub hem_radius_min: f64,
    /// m.
    pub hem_radius_max: f64,
    /// a_1 … a_K, a_1 > 0.
    pub coefficients: Vec<f64>,
    /// The hem, m: centred, a crest on the x axis, counter-clockwise, equally spaced in cloth length.
    #[serde(skip)]
    pub outline: Vec<Point>,
    pub termination: Termination,
    pub evaluations: usize,
    /// Every fold count tried.
    pub branches: Vec<Branch>,
}
