//! The bias of curvature: how far noise has moved the fitted curve, and the fit without it.
//!
//! Noise of size σ in both directions about a curve of curvature κ shifts the mean signed distance by ½σ²κ, because the foot moves along the
//! bend. So least squares is not centred on the true curve; the root of Σ Jᵢ (dᵢ − ½σ̂²κᵢ) = 0 is, to that order (docs/uncertainty.md).

use serde::Serialize;

use super::estimating::{Equations, Shift, Unknowns, linearize, noise_variance};
use super::orthogonal::curve;
use super::outcome::{HeldLength, Termination};
use super::trial::{Trial, Work};
use crate::model::hem::Hem;
use crate::numerics::least_squares::State;

/// σ̂·max|κ| beyond which ½σ²κ is no longer the mean shift: the next term of the expansion is of relative size (σκ)², here a quarter. Measured at 0.45
/// it still leaves a quarter of a standard error of s, of 1.6 without it (docs/uncertainty.md).
pub const SHARPEST_BEND: f64 = 0.5;
/// … and beyond which standard errors, which are of first order in σκ, are too small by a tenth or more.
pub const NOTABLE_BEND: f64 = 0.3;
/// Step, as a share of p, at which the root is reached.
const TOLERANCE: f64 = 1e-11;

/// What became of the bias of curvature.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BiasCorrection {
    /// It was taken out.
    Applied(Correction),
    /// The curve is the least-squares optimum itself, or what else its termination says.
    Left(Uncorrected),
}

/// What the correction did.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Correction {
    /// Corrected minus uncorrected, m.
    pub p: f64,
    pub q: f64,
    pub s: f64,
    /// σ̂, the noise that it was made for, m.
    pub sigma: f64,
    /// σ̂·max|κ| before it: how sharp the bends are against the noise.
    pub bend: f64,
    /// Gauss–Newton rounds.
    pub rounds: usize,
}

/// Why the bias was left in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Uncorrected {
    /// Not asked for.
    Off,
    /// A curve matched in order is no optimum to start from.
    InOrder,
    /// The fit ended before its optimum.
    NotConverged,
    /// Bends as narrow as the noise: the expansion does not hold.
    SharpBends,
    /// The equations have no root near the optimum, or not one that the points determine.
    NoRoot,
    /// The corrected curve would break a rule that the uncorrected one keeps.
    BreaksRule,
    /// Points of different weight are not shifted alike.
    Weighted,
}

/// Whether bends are too sharp for the correction: `bend` is σ̂·max|κ|.
pub(super) fn too_sharp(bend: f64) -> bool {
    SHARPEST_BEND < bend
}

impl Uncorrected {
    /// As tables name it.
    pub fn name(self) -> &'static str {
        match self {
            Uncorrected::Off => "off",
            Uncorrected::InOrder => "in_order",
            Uncorrected::NotConverged => "not_converged",
            Uncorrected::SharpBends => "sharp_bends",
            Uncorrected::NoRoot => "no_root",
            Uncorrected::BreaksRule => "breaks_rule",
            Uncorrected::Weighted => "weighted",
        }
    }

    /// In words.
    pub fn reason(self) -> &'static str {
        match self {
            Uncorrected::Off => "it was not asked for",
            Uncorrected::InOrder => "the curve was matched in order",
            Uncorrected::NotConverged => "the fit ended before its optimum",
            Uncorrected::SharpBends => "the curve bends as narrowly as the noise is wide",
            Uncorrected::NoRoot => "the corrected equations have no root near the optimum",
            Uncorrected::BreaksRule => "the corrected curve would break a rule of a sane outline",
            Uncorrected::Weighted => "the points have weights, so noise has not shifted them alike",
        }
    }
}

impl BiasCorrection {
    /// What was done, if something was.
    pub fn applied(&self) -> Option<&Correction> {
        match self {
            BiasCorrection::Applied(correction) => Some(correction),
            BiasCorrection::Left(_) => None,
        }
    }
}

/// The fit without the bias of curvature, if asked and where that can be had.
pub(super) fn correct(trial: Trial, work: &Work, asked: bool) -> (Trial, BiasCorrection) {
    if !asked {
        return (trial, BiasCorrection::Left(Uncorrected::Off));
    }
    if !work.weights.is_empty() {
        return (trial, BiasCorrection::Left(Uncorrected::Weighted));
    }
    match trial.termination {
        Termination::NoFolds => round(trial, work),
        Termination::InOrder { .. } | Termination::NotPursued => (trial, BiasCorrection::Left(Uncorrected::InOrder)),
        Termination::Stalled | Termination::EvaluationLimit => (trial, BiasCorrection::Left(Uncorrected::NotConverged)),
        Termination::Converged | Termination::HeldLength { .. } | Termination::LengthAsAsked => folded(trial, work),
    }
}

fn folded(trial: Trial, work: &Work) -> (Trial, BiasCorrection) {
    let unknowns: Unknowns = [trial.placement.x0, trial.placement.y0, trial.placement.phase, trial.hem.p, trial.hem.q, trial.hem.s];
    let equations = Equations {
        points: work.points,
        counts: None,
        folds: trial.folds,
        length: trial.held.map(|held| held.length),
        free: trial.states.map(|state| state == State::Free),
        shift: Shift::Curvature,
        tolerance: TOLERANCE,
        gain: 0.0,
    };
    let Some(at) = linearize(work.points, &unknowns, trial.folds, &trial.feet) else {
        return (trial, BiasCorrection::Left(Uncorrected::NoRoot));
    };
    let sigma = noise_variance(&at.distances, None, equations.determined()).sqrt();
    let bend = sigma * at.curvatures.iter().fold(0.0, |most: f64, kappa| most.max(kappa.abs()));
    if SHARPEST_BEND < bend {
        return (trial, BiasCorrection::Left(Uncorrected::SharpBends));
    }
    let Some(root) = equations.root(unknowns, &trial.feet) else { return (trial, BiasCorrection::Left(Uncorrected::NoRoot)) };
    let (hem, placement) = curve(&root.unknowns, trial.folds);
    if work.broken(&hem, &placement, &root.at.feet, &root.at.distances).is_some() {
        return (trial, BiasCorrection::Left(Uncorrected::BreaksRule));
    }
    let correction = Correction {
        p: hem.p - trial.hem.p,
        // Of the canonical q ≥ 0.
        q: hem.q.abs() - trial.hem.q.abs(),
        s: hem.s - trial.hem.s,
        sigma: root.variance.sqrt(),
        bend,
        rounds: root.rounds,
    };
    let held = trial.held.map(|held| HeldLength { multiplier: root.multiplier.unwrap_or(held.multiplier), ..held });
    let sum_of_squares = root.at.distances.iter().map(|d| d * d).sum();
    let evaluations = trial.evaluations + root.rounds + 1;
    let corrected = Trial { hem, placement, feet: root.at.feet, distances: root.at.distances, sum_of_squares, held, evaluations, ..trial };
    (corrected, BiasCorrection::Applied(correction))
}

/// The circle in closed form: all points are shifted alike, by ½σ²/R, so its centre stays and `R' = R − ½σ²/R'`.
fn round(trial: Trial, work: &Work) -> (Trial, BiasCorrection) {
    let radius = trial.hem.p;
    let variance = noise_variance(&trial.distances, None, 3);
    let bend = variance.sqrt() / radius;
    if SHARPEST_BEND < bend {
        return (trial, BiasCorrection::Left(Uncorrected::SharpBends));
    }
    let corrected = 0.5 * (radius + (radius * radius - 2.0 * variance).sqrt());
    let change = corrected - radius;
    let distances: Vec<f64> = trial.distances.iter().map(|d| d - change).collect();
    debug_assert_eq!(distances.len(), work.points.len());
    let correction = Correction { p: change, q: 0.0, s: 0.0, sigma: variance.sqrt(), bend, rounds: 0 };
    let sum_of_squares = distances.iter().map(|d| d * d).sum();
    let hem = Hem { p: corrected, ..trial.hem };
    (Trial { hem, distances, sum_of_squares, ..trial }, BiasCorrection::Applied(correction))
}
