//! The tangent-angle family fitted to an outline: m equal folds, inextensible, K harmonics by evidence.
//!
//! `c' = i R e^{i(σ + φ + ψ)}`, `ψ = Σ_k a_k sin kmσ` (docs/model.md, section 5): its length is 2πR exactly.

use std::f64::consts::{PI, TAU};

use nalgebra::DMatrix;

use super::aicc;
use super::outcome::{Estimate, HemFit, Termination};
use super::outline::{Outline, fractions};
use super::sane_curve;
use super::start::{LengthTable, Radii};
use super::tangent_curve::TangentCurve;
use super::tangent_fit::{Family, Fitted, Placed, fit};
use crate::error::Error;
use crate::experiment::Point;
use crate::model::hem::{Hem, Placement};
use crate::numerics::least_squares::{self, covariance};

/// Most harmonics of the tangent angle: the exact hem of a skirt needs four to eight to a tenth of a millimetre.
const MOST_HARMONICS: usize = 8;
/// Harmonics tried in vain before giving up: folds that are alike on both sides of the mean radius lack every second one.
const PATIENCE: usize = 2;
/// A neighbouring fold count is looked at only where its match by length is within this factor of that of the paper's fit.
const CONTENDER: f64 = 1.25;

/// A fitted hem of equal folds.
#[derive(Debug, Clone)]
pub struct TangentFit {
    pub placed: Placed,
    pub folds: u32,
    /// Length over 2π, m; without a standard error where it was held.
    pub radius: Estimate,
    /// a_1 … a_K, rad.
    pub coefficients: Vec<Estimate>,
    /// Covariance of a_1 … a_K; `None` where they have no standard errors.
    pub covariance: Option<DMatrix<f64>>,
    /// Whether R was held, because the cut is known or the free optimum of the paper's curve was no sane one.
    pub held: bool,
    pub sum_of_squares: f64,
    /// Signed distances, m, positive outside.
    pub distances: Vec<f64>,
    pub feet: Vec<f64>,
    pub unknowns: usize,
    pub termination: least_squares::Termination,
    /// Why there are no standard errors, where there are none.
    pub undetermined: Option<String>,
}

/// Fits the family at the paper's fold count and at its neighbours; K and m of least AICc among the curves that obey the rules.
///
/// `feet` are those of `points` on the paper's curve. R is held at the length that the paper's fit was held to, if it was.
///
/// # Errors
/// [`Error::Unanswerable`] if the outline is round, or if no curve of the family is sane.
pub fn tangent_family(points: &[Point], outline: &Outline, paper: &HemFit, feet: &[f64]) -> Result<TangentFit, Error> {
    let Some(folds) = paper.folds else {
        return Err(Error::Unanswerable("the outline is round: no folds to give a tangent angle".into()));
    };
    let held = match (&paper.termination, &paper.held) {
        (Termination::Converged | Termination::Stalled | Termination::EvaluationLimit, None) => None,
        (_, Some(held)) => Some(held.length / TAU),
        _ => Some(outline.length / TAU),
    };
    let table = LengthTable::of(&paper.hem);
    let own: Vec<f64> = feet.iter().map(|&t| TAU * table.fraction(t)).collect();
    let mut best = ladder(points, outline, &paper.hem, paper.placement, &own, held);
    let (places, _) = fractions(points);
    let radii = Radii::of(outline);
    let reference = radii.matched(folds).rms;
    for neighbour in [folds - 1, folds + 1].into_iter().filter(|m| 2 <= *m && 8 * *m as usize <= points.len()) {
        let start = radii.matched(neighbour);
        if CONTENDER * reference < start.rms {
            continue;
        }
        let feet: Vec<f64> = places.iter().map(|f| TAU * (f - start.offset)).collect();
        let other = ladder(points, outline, &start.hem, start.placement, &feet, held);
        let criterion = |f: &Option<TangentFit>| f.as_ref().map_or(f64::INFINITY, |f| aicc(f.sum_of_squares, points.len(), f.unknowns));
        if criterion(&other) < criterion(&best) {
            best = other;
        }
    }
    best.ok_or_else(|| Error::Unanswerable(format!("no sane curve of {folds} equal folds by its tangent angle")))
}

/// One more harmonic at a time, from the paper's curve.
fn ladder(points: &[Point], outline: &Outline, hem: &Hem, at: Placement, feet: &[f64], held: Option<f64>) -> Option<TangentFit> {
    let sines = sines_of(hem, MOST_HARMONICS);
    let radius = held.unwrap_or(hem.perimeter() / TAU);
    let most = MOST_HARMONICS.min(points.len() / (4 * hem.folds as usize)).max(1);
    let options = least_squares::Options { gradient_tolerance: 1e-8, evaluation_limit: 60, ..least_squares::Options::default() };
    let mut best: Option<(f64, TangentFit)> = None;
    let mut last: Option<Fitted> = None;
    let mut in_vain = 0;
    for harmonics in 1..=most {
        let (placed, feet) = match &last {
            // What was found goes on, the new harmonic from 0.
            Some(fitted) => {
                let mut sines = fitted.placed.curve.sines().to_vec();
                sines.push(0.0);
                (
                    Placed { curve: TangentCurve::new(hem.folds, &vec![0.0; harmonics], &sines), ..fitted.placed.clone() },
                    fitted.feet.clone(),
                )
            }
            None => {
                let curve = TangentCurve::new(hem.folds, &vec![0.0; harmonics], &sines[..harmonics]);
                (Placed { curve, centre: Point::new(at.x0, at.y0), phase: at.phase, radius }, feet.to_vec())
            }
        };
        let family = Family::EqualFolds { folds: hem.folds, radius: held };
        let Ok(fitted) = fit(points, &family, placed, feet, &options) else { break };
        let farthest = fitted.summary.residuals.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
        let length = held.map_or(outline.length, |r| TAU * r);
        let sane =
            fitted.summary.termination.converged() && sane_curve::broken(&fitted.placed, outline, &fitted.feet, farthest, length).is_none();
        let unknowns = fitted.summary.parameters.len();
        let criterion = if sane { aicc(fitted.summary.sum_of_squares, points.len(), unknowns) } else { f64::INFINITY };
        if best.as_ref().map_or(f64::INFINITY, |b| b.0) <= criterion {
            in_vain += 1;
        } else {
            in_vain = 0;
            best = Some((criterion, outcome(&fitted, hem.folds, held)));
        }
        if PATIENCE < in_vain {
            break;
        }
        last = Some(fitted);
    }
    best.map(|b| b.1)
}

fn outcome(fitted: &Fitted, folds: u32, held: Option<f64>) -> TangentFit {
    let names: Vec<String> = ["x0", "y0", "phase"]
        .into_iter()
        .map(String::from)
        .chain(held.is_none().then(|| "R".to_string()))
        .chain((1..=fitted.placed.curve.sines().len()).map(|k| format!("a_{k}")))
        .collect();
    let known = covariance(&fitted.summary, &names.iter().map(String::as_str).collect::<Vec<_>>());
    let error = |i: usize| known.as_ref().ok().map(|c| c.matrix[(i, i)].max(0.0).sqrt());
    let first = if held.is_some() { 3 } else { 4 };
    let sines = fitted.placed.curve.sines();
    TangentFit {
        folds,
        radius: Estimate { value: fitted.placed.radius, standard_error: held.is_none().then(|| error(3)).flatten() },
        coefficients: sines.iter().enumerate().map(|(k, a)| Estimate { value: *a, standard_error: error(first + k) }).collect(),
        covariance: known.as_ref().ok().map(|c| c.matrix.view((first, first), (sines.len(), sines.len())).into_owned()),
        held: held.is_some(),
        sum_of_squares: fitted.summary.sum_of_squares,
        distances: fitted.summary.residuals.clone(),
        feet: fitted.feet.clone(),
        unknowns: fitted.summary.parameters.len(),
        termination: fitted.summary.termination,
        undetermined: known.err().map(|e| e.to_string()),
        placed: fitted.placed.clone(),
    }
}

/// a_1 … a_K of the paper's curve: the sine series of its tangent angle over its own length.
pub(super) fn sines_of(hem: &Hem, harmonics: usize) -> Vec<f64> {
    /// Nodes in a fold, enough for 32 harmonics.
    const NODES: usize = 512;
    let m = f64::from(hem.folds);
    let step = TAU / m / NODES as f64;
    let speed: Vec<f64> = (0..=NODES).map(|j| hem.local(step * j as f64).speed()).collect();
    let mut travelled = vec![0.0; NODES + 1];
    for j in 1..=NODES {
        // Trapezoid with the next order: speeds are smooth.
        travelled[j] = travelled[j - 1] + 0.5 * (speed[j - 1] + speed[j]);
    }
    let whole = travelled[NODES];
    let x: Vec<f64> = travelled.iter().map(|t| TAU * t / whole).collect();
    let psi: Vec<f64> = (0..=NODES)
        .map(|j| {
            let t = step * j as f64;
            let (radial, tangential) = hem.local(t).velocity;
            (-radial).atan2(tangential) + t - x[j] / m
        })
        .collect();
    let coefficient = |k: usize| {
        let terms: Vec<f64> = psi.iter().zip(&x).map(|(psi, x)| psi * (k as f64 * x).sin()).collect();
        (1..=NODES).map(|j| 0.5 * (terms[j - 1] + terms[j]) * (x[j] - x[j - 1])).sum::<f64>() / PI
    };
    (1..=harmonics).map(coefficient).collect()
}
