//! Analysis of variance: how much of the scatter goes to which source.

use serde::Serialize;

use crate::numerics::double_double::{DoubleDouble, sum};
use crate::statistics::variances::centred_squares;

/// One-way analysis of variance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OneWay {
    pub between_df: usize,
    pub between_sum_of_squares: f64,
    pub within_df: usize,
    pub within_sum_of_squares: f64,
    /// `None` if nothing scatters within the groups.
    pub f: Option<f64>,
    pub p: Option<f64>,
    /// Between over total; `None` if nothing scatters at all.
    pub r_squared: Option<f64>,
}

/// Groups of responses against their means; `None` with fewer than two groups, an empty one, or no run to spare for the scatter within.
///
/// Sums are taken about the means in twice the working precision, so the only loss is the rounding of the responses themselves.
pub fn one_way(groups: &[Vec<f64>]) -> Option<OneWay> {
    let runs: usize = groups.iter().map(Vec::len).sum();
    if groups.len() < 2 || runs <= groups.len() || groups.iter().any(Vec::is_empty) {
        return None;
    }
    let grand = sum(groups.iter().flatten().copied()) / DoubleDouble::from(runs as f64);
    let (mut between, mut within) = (DoubleDouble::ZERO, DoubleDouble::ZERO);
    for group in groups {
        let (mean, squares) = centred_squares(group);
        between = between + DoubleDouble::from(group.len() as f64) * (mean - grand) * (mean - grand);
        within = within + squares;
    }
    let (between_df, within_df) = (groups.len() - 1, runs - groups.len());
    let all: Vec<f64> = groups.iter().flatten().copied().collect();
    let scatters = !crate::statistics::linear_model::is_rounding(within.to_f64(), &all);
    let f = scatters.then(|| (between / DoubleDouble::from(between_df as f64) / (within / DoubleDouble::from(within_df as f64))).to_f64());
    let total = between + within;
    Some(OneWay {
        between_df,
        between_sum_of_squares: between.to_f64(),
        within_df,
        within_sum_of_squares: within.to_f64(),
        f,
        p: f.map(|f| crate::statistics::distribution::fisher_upper(f, between_df as f64, within_df as f64)),
        r_squared: (total.to_f64() > 0.0).then(|| (between / total).to_f64()),
    })
}

/// One line of an analysis-of-variance table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnovaRow {
    pub source: String,
    pub df: usize,
    pub sum_of_squares: f64,
    /// `None` on 0 degrees of freedom.
    pub mean_square: Option<f64>,
    /// Against the pure error where there is one, otherwise the residual; `None` where there is nothing to compare with.
    pub f: Option<f64>,
    pub p: Option<f64>,
}

impl AnovaRow {
    pub fn new(source: impl Into<String>, df: usize, sum_of_squares: f64) -> Self {
        let mean_square = (df > 0).then(|| sum_of_squares / df as f64);
        AnovaRow { source: source.into(), df, sum_of_squares, mean_square, f: None, p: None }
    }

    /// Tested against an error variance on `error_df`.
    pub fn against(mut self, error_variance: f64, error_df: usize) -> Self {
        if let Some(mean_square) = self.mean_square.filter(|_| error_variance > 0.0 && error_df > 0) {
            let f = mean_square / error_variance;
            self.f = Some(f);
            self.p = Some(crate::statistics::distribution::fisher_upper(f, self.df as f64, error_df as f64));
        }
        self
    }
}

/// The residual sum of squares of a model, split by replicates into lack of fit and pure error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LackOfFit {
    pub df: usize,
    pub sum_of_squares: f64,
    pub pure_error_df: usize,
    pub pure_error_sum_of_squares: f64,
}

impl LackOfFit {
    /// By subtraction: what the residuals hold beyond the scatter of the replicates.
    pub fn new(residual: (usize, f64), pure_error: (usize, f64)) -> Self {
        LackOfFit {
            df: residual.0 - pure_error.0,
            sum_of_squares: (residual.1 - pure_error.1).max(0.0),
            pure_error_df: pure_error.0,
            pure_error_sum_of_squares: pure_error.1,
        }
    }

    /// `None` without lack-of-fit or pure-error degrees of freedom, or if the replicates agree exactly.
    pub fn f(&self) -> Option<f64> {
        (self.df > 0 && self.pure_error_df > 0 && self.pure_error_sum_of_squares > 0.0)
            .then(|| self.sum_of_squares / self.df as f64 / (self.pure_error_sum_of_squares / self.pure_error_df as f64))
    }
}
