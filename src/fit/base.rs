//! A finished fit as a place to go on from: its curve, what is local at every foot, and what its distances have been shifted by.

use super::bias::{BiasCorrection, Uncorrected};
use super::estimating::{Linearized, Unknowns, linearize};
use super::outcome::{HemFit, Termination};
use super::uncertainty::{WhyMissing, residuals};
use crate::experiment::Point;
use crate::numerics::least_squares::State;

/// The root that a fit has reached.
pub(super) struct Base<'a> {
    pub points: &'a [Point],
    pub folds: u32,
    pub unknowns: Unknowns,
    pub at: Linearized,
    /// Distances less their mean shift, m.
    pub residuals: Vec<f64>,
    /// The mean shift of each distance, m.
    pub shift: Vec<f64>,
    pub free: [bool; 6],
    /// Perimeter that was held, m.
    pub length: Option<f64>,
    /// Whether the bias of curvature was taken out.
    pub corrected: bool,
}

/// The root that `fit` of the outline `points` has reached, or why it is none.
pub(super) fn base<'a>(points: &'a [Point], fit: &HemFit) -> Result<Base<'a>, WhyMissing> {
    match fit.termination {
        Termination::InOrder { .. } | Termination::NotPursued => return Err(WhyMissing::InOrder),
        Termination::Stalled | Termination::EvaluationLimit => return Err(WhyMissing::NotConverged),
        Termination::Converged | Termination::HeldLength { .. } | Termination::LengthAsAsked | Termination::NoFolds => (),
    }
    // Replicates and likelihoods are those of points that count alike.
    if fit.bias_correction == BiasCorrection::Left(Uncorrected::Weighted) {
        return Err(WhyMissing::Weighted);
    }
    let unknowns = [fit.placement.x0, fit.placement.y0, fit.placement.phase, fit.hem.p, fit.hem.q, fit.hem.s];
    let folds = fit.hem.folds;
    let at = linearize(points, &unknowns, folds, &fit.feet).ok_or(WhyMissing::NotDetermined)?;
    let residuals = residuals(&at, &fit.bias_correction);
    let shift = at.distances.iter().zip(&residuals).map(|(d, e)| d - e).collect();
    let round = folds == 0;
    Ok(Base {
        points,
        folds,
        unknowns,
        at,
        residuals,
        shift,
        free: std::array::from_fn(|j| [true, true, !round, true, !round, !round][j] && fit.states[j] == State::Free),
        length: fit.held.map(|held| held.length),
        corrected: fit.bias_correction.applied().is_some(),
    })
}
