//! Estimates that gross errors cannot carry away: a loss other than squares, by iteratively reweighted least squares.
//!
//! Each round weighs the residuals by the last one's and solves that least-squares problem from where the last one ended. The scale is found
//! anew in each round until it has settled, and then held, so that what is minimized no longer changes.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::covariance::{Covariance, covariance_of};
use super::limits::{Limit, State};
use super::loss::{Loss, median_scale};
use super::outcome::{Options, Summary, Termination};
use super::problem::Problem;
use super::solve::solve_within;
use crate::error::Error;

/// Rounds at most; linear convergence at a rate of about the share of downweighted residuals needs twenty to forty.
const ROUNDS: usize = 100;
/// The scale is held after so many rounds, settled or not: a median can jump to and fro between two residuals for ever.
const ROUNDS_OF_SCALE: usize = 50;
/// … or once it changes by less than this share.
const SETTLED_SCALE: f64 = 1e-8;
/// The rounds end when no parameter moves by more than this share of its standard error.
const SETTLED: f64 = 1e-7;
/// A residual of less weight than this is called downweighted: it counts less than half.
pub const DOWNWEIGHTED: f64 = 0.5;

/// One round of reweighting.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Round {
    /// Scale by which this round's weights were found; 0 for the first, which has none.
    pub scale: f64,
    /// Residual vectors evaluated, those for numeric derivatives not counted.
    pub evaluations: usize,
    pub termination: Termination,
}

/// Where reweighting ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Robust {
    /// The last weighted problem; its residuals and Jacobian are the **unweighted** ones, its sum of squares is of these times the weights given.
    pub summary: Summary,
    /// Standard deviation of the bulk of the residuals, [`median_scale`].
    pub scale: f64,
    /// Weight of each residual, 0…1, by the loss alone.
    pub weights: Vec<f64>,
    /// Residuals of less than half the weight.
    pub downweighted: usize,
    /// Evaluations spent, round by round.
    pub rounds: Vec<Round>,
    /// Whether the last round moved the parameters by less than a ten-millionth of their standard errors.
    pub settled: bool,
}

/// Minimizes `Σ ρ(√wᵢ rᵢ / scale)` from `start`, within `limits` (empty: all free); `prior` are the weights wᵢ (empty: all 1).
///
/// With [`Loss::Squares`] it is one round of plain (weighted) least squares. The start must be sane: a bounded loss has many minima.
///
/// # Errors
/// Those of [`solve_within`]; [`Error::Unanswerable`] if `prior` is neither empty nor as long as the residuals, or holds something else than finite
/// numbers ≥ 0.
pub fn solve_robust(
    problem: &mut impl Problem,
    start: &[f64],
    limits: &[Limit],
    loss: Loss,
    prior: &[f64],
    options: &Options,
) -> Result<Robust, Error> {
    let rows = problem.residual_count();
    check_weights(prior, rows)?;
    if let Some(tuning) = loss.tuning().filter(|tuning| !(0.0 < *tuning && tuning.is_finite())) {
        return Err(Error::Invalid { quantity: "tuning constant of the loss", value: tuning, allowed: "a finite number of scales, > 0" });
    }
    let root = |i: usize| prior.get(i).map_or(1.0, |w| w.sqrt());
    let mut weighted = Weighted { problem, roots: (0..rows).map(root).collect() };
    let mut rounds = Vec::new();
    let mut weights = vec![1.0; rows];
    let mut x = start.to_vec();
    let mut scale = 0.0;
    if loss != Loss::Squares {
        // The start has been found with care, so its residuals tell good from bad better than a fit to all of them would.
        let mut residuals = vec![0.0; rows];
        if weighted.residuals(&x, &mut residuals) {
            scale = median_scale(&residuals, prior);
            weigh(loss, &residuals, scale, prior, &mut weights, &mut weighted.roots);
        }
    }
    let mut held = false;
    let mut settled = loss == Loss::Squares;
    let (mut evaluations, mut jacobians, mut restarts) = (0, 0, 0);
    let mut options = *options;
    let mut last = loop {
        let summary = solve_within(&mut weighted, &x, limits, &options)?;
        rounds.push(Round { scale, evaluations: summary.evaluations, termination: summary.termination });
        evaluations += summary.evaluations;
        jacobians += summary.jacobians;
        restarts += summary.restarts;
        // From where a round ended the next one needs no caution.
        options.restarts = 0;
        let moved = moved_by(&x, &summary, &weighted.roots);
        x.clone_from(&summary.parameters);
        if loss == Loss::Squares || !matches!(summary.termination, Termination::Gradient | Termination::Step | Termination::Stalled) {
            break summary;
        }
        settled = held && moved <= SETTLED;
        if settled || ROUNDS <= rounds.len() {
            break summary;
        }
        // √w r without the loss: what the scale and the next weights are made of.
        let plain: Vec<f64> =
            summary.residuals.iter().enumerate().map(|(i, r)| if 0.0 < weights[i] { r / weights[i].sqrt() } else { 0.0 }).collect();
        // Residuals of weight 0 are lost in the product, so they are asked for again.
        let plain = if weights.contains(&0.0) { weighted.without_loss(&x, prior).unwrap_or(plain) } else { plain };
        if !held {
            let next = median_scale(&plain, prior);
            held = (next - scale).abs() <= SETTLED_SCALE * next || ROUNDS_OF_SCALE <= rounds.len();
            scale = next;
        }
        if scale <= 0.0 {
            // More than half of the residuals vanish: there is nothing left to weigh by.
            break summary;
        }
        weigh(loss, &plain, scale, prior, &mut weights, &mut weighted.roots);
    };
    // What the caller needs is the plain residuals and their Jacobian.
    let Weighted { problem, .. } = weighted;
    problem.residuals(&last.parameters, &mut last.residuals);
    problem.jacobian(&last.parameters, &mut last.jacobian);
    last.sum_of_squares = last.residuals.iter().enumerate().map(|(i, r)| prior.get(i).unwrap_or(&1.0) * r * r).sum();
    (last.evaluations, last.jacobians, last.restarts) = (evaluations, jacobians, restarts);
    let counted = |i: &usize| prior.get(*i).is_none_or(|&w| 0.0 < w);
    let downweighted = (0..rows).filter(counted).filter(|&i| weights[i] < DOWNWEIGHTED).count();
    Ok(Robust { summary: last, scale, weights, downweighted, rounds, settled })
}

impl Robust {
    /// The covariance of the estimates.
    ///
    /// With squares `σ̂²(JᵀWJ)⁻¹`. With another loss Huber's for M-estimates in regression,
    /// `K² · [Σψ²s²/(n − k)] / [Σψ′/n]² · (JᵀWJ)⁻¹` with `K = 1 + (k/n) var(ψ′)/mean(ψ′)²` (Huber, Robust Statistics, Wiley 1981,
    /// section 7.6, the first of his three): it takes the spread of the errors from ψ, so gross errors do not inflate it. W are the prior weights.
    ///
    /// # Errors
    /// Those of [`covariance`](super::covariance).
    pub fn covariance(&self, loss: Loss, prior: &[f64], names: &[&str]) -> Result<Covariance, Error> {
        let rows = self.summary.residuals.len();
        let weight = |i: usize| prior.get(i).copied().unwrap_or(1.0);
        let counted: Vec<usize> = (0..rows).filter(|&i| 0.0 < weight(i)).collect();
        let mut summary = self.summary.clone();
        if !prior.is_empty() {
            for i in 0..rows {
                summary.jacobian.row_mut(i).scale_mut(weight(i).sqrt());
            }
        }
        let plain = covariance_of(&summary, names, counted.len())?;
        if loss == Loss::Squares {
            return Ok(plain);
        }
        if self.scale <= 0.0 {
            return Err(Error::Unanswerable("more than half of the residuals vanish, so their scale is zero".into()));
        }
        let n = counted.len() as f64;
        let free = n - plain.degrees_of_freedom as f64;
        let (mut square, mut bend, mut bend_square) = (0.0, 0.0, 0.0);
        for &i in &counted {
            let u = weight(i).sqrt() * self.summary.residuals[i] / self.scale;
            square += (u * loss.weight(u) * self.scale).powi(2);
            let curvature = loss.curvature(u);
            bend += curvature / n;
            bend_square += curvature * curvature / n;
        }
        if bend <= 0.0 {
            return Err(Error::Unanswerable("the loss curves downwards at most residuals: too many of them are far off".into()));
        }
        let correction = 1.0 + free / n * (bend_square - bend * bend).max(0.0) / (bend * bend);
        let variance = correction * correction * square / (n - free) / (bend * bend);
        let factor = variance / plain.variance;
        let matrix = if 0.0 < plain.variance { plain.matrix * factor } else { plain.matrix };
        Ok(Covariance { matrix, variance, ..plain })
    }
}

/// Checks weights: none, or one finite number ≥ 0 for each of `rows` residuals.
///
/// # Errors
/// [`Error::Unanswerable`] or [`Error::Invalid`] with the weight that is none.
pub fn check_weights(weights: &[f64], rows: usize) -> Result<(), Error> {
    if !weights.is_empty() && weights.len() != rows {
        return Err(Error::Unanswerable(format!("{} weights for {rows} residuals; one for each is needed", weights.len())));
    }
    match weights.iter().find(|w| !(0.0..f64::INFINITY).contains(*w)) {
        Some(&value) => {
            Err(Error::Invalid { quantity: "a weight", value, allowed: "a finite number ≥ 0 (1/variance up to a common factor)" })
        }
        None => Ok(()),
    }
}

fn weigh(loss: Loss, residuals: &[f64], scale: f64, prior: &[f64], weights: &mut [f64], roots: &mut [f64]) {
    for (i, weight) in weights.iter_mut().enumerate() {
        *weight = if 0.0 < scale { loss.weight(residuals[i] / scale) } else { 1.0 };
        roots[i] = (*weight * prior.get(i).unwrap_or(&1.0)).sqrt();
    }
}

/// The longest way of a free parameter in this round, in units of its standard error by the round's own Jacobian.
fn moved_by(before: &[f64], summary: &Summary, roots: &[f64]) -> f64 {
    let counted = roots.iter().filter(|&&root| 0.0 < root).count();
    let free: Vec<usize> = (0..before.len()).filter(|&j| summary.states[j] == State::Free).collect();
    let way = DVector::from_iterator(before.len(), summary.parameters.iter().zip(before).map(|(new, old)| new - old));
    let spread = (summary.sum_of_squares / counted.saturating_sub(free.len()).max(1) as f64).sqrt();
    // |J Δx|, the way as the residuals see it: a bound of Δxᵢ over its standard error, and defined where no standard error is.
    let seen = (&summary.jacobian * way).norm();
    if seen == 0.0 { 0.0 } else { seen / spread }
}

/// A problem whose residuals are multiplied by weights.
struct Weighted<'a, P> {
    problem: &'a mut P,
    /// Square root of each weight.
    roots: Vec<f64>,
}

impl<P: Problem> Weighted<'_, P> {
    /// Residuals times the roots of the prior weights, without those of the loss.
    fn without_loss(&mut self, x: &[f64], prior: &[f64]) -> Option<Vec<f64>> {
        let mut residuals = vec![0.0; self.roots.len()];
        let defined = self.problem.residuals(x, &mut residuals);
        residuals.iter_mut().enumerate().for_each(|(i, r)| *r *= prior.get(i).map_or(1.0, |w| w.sqrt()));
        defined.then_some(residuals)
    }
}

impl<P: Problem> Problem for Weighted<'_, P> {
    fn residual_count(&self) -> usize {
        self.problem.residual_count()
    }

    fn residuals(&mut self, x: &[f64], residuals: &mut [f64]) -> bool {
        let defined = self.problem.residuals(x, residuals);
        // A residual that does not count may be anything.
        residuals.iter_mut().zip(&self.roots).for_each(|(r, root)| *r = if *root == 0.0 { 0.0 } else { *r * root });
        defined
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
        let defined = self.problem.jacobian(x, jacobian);
        for (i, root) in self.roots.iter().enumerate() {
            if *root == 0.0 { jacobian.row_mut(i).fill(0.0) } else { jacobian.row_mut(i).scale_mut(*root) }
        }
        defined
    }

    fn accept(&mut self) -> bool {
        self.problem.accept()
    }

    fn constraint(&mut self, x: &[f64]) -> Option<(f64, DVector<f64>)> {
        self.problem.constraint(x)
    }

    fn refine(&mut self) -> bool {
        self.problem.refine()
    }

    fn derivative_evaluations(&self) -> usize {
        self.problem.derivative_evaluations()
    }
}
