//! Accuracy asked, accuracy given: unknowns are added until the hem stops moving.

use super::{Fidelity, Folds, Prediction};
use crate::error::Error;

/// Harmonics of the ruled shell, level by level.
const RULED: [usize; 7] = [2, 4, 8, 12, 16, 24, 32];
/// Harmonics and modes of the graded shell.
const GRADED: [(usize, usize); 7] = [(2, 4), (3, 6), (4, 8), (5, 10), (6, 12), (8, 16), (10, 20)];

/// Refines `once` until the hem moves by less than `tolerance` (m) from one level to the next; the last move is the error estimate.
///
/// Both families converge geometrically, so what is left is smaller than the last move. Where the last level still moves more, a note says so.
pub(super) fn predict(
    asked: Fidelity,
    counts: Folds,
    tolerance: f64,
    once: impl Fn(Fidelity, Folds) -> Result<Prediction, Error>,
) -> Result<Prediction, Error> {
    if !(tolerance.is_finite() && 0.0 < tolerance) {
        return Err(Error::Invalid { quantity: "tolerance, m", value: tolerance, allowed: "> 0" });
    }
    let levels: Vec<Fidelity> = match asked {
        Fidelity::Ruled { .. } => RULED.iter().map(|k| Fidelity::Ruled { harmonics: *k }).collect(),
        Fidelity::Graded { shear, .. } => GRADED.iter().map(|(k, j)| Fidelity::Graded { harmonics: *k, modes: *j, shear }).collect(),
        fixed => vec![fixed],
    };
    let mut last: Option<Prediction> = None;
    let (mut evaluations, mut folds) = (0, counts);
    for fidelity in &levels {
        let mut next = once(*fidelity, folds)?;
        evaluations += next.evaluations;
        next.evaluations = evaluations;
        if let Some(last) = &last {
            if settled(last, &next) {
                folds = Folds::Exactly(next.folds);
            }
            if counts == Folds::Auto {
                keep_rivals(last, &mut next);
            }
        }
        next.error_estimate = last.as_ref().and_then(|last| distance(last, &next));
        if next.error_estimate.is_some_and(|error| error <= tolerance) {
            return Ok(next);
        }
        last = Some(next);
    }
    let mut best = last.ok_or_else(|| Error::Unanswerable("no level to refine".into()))?;
    best.notes.push(match (levels.len(), best.error_estimate) {
        (1, _) => "this theory has a fixed number of unknowns: there is nothing to refine".into(),
        (_, Some(_)) => "the tolerance is not met at the finest level".into(),
        (_, None) => "the fold count still changes at the finest level: the tolerance is not met".into(),
    });
    Ok(best)
}

/// Whether no other fold count can still win: the runner-up costs more by far than refinement still moves the energy.
fn settled(last: &Prediction, next: &Prediction) -> bool {
    let moved = (next.energy - last.energy).abs();
    let rival = next.branches.iter().filter(|b| b.folds != next.folds).map(|b| b.energy).fold(f64::INFINITY, f64::min);
    // Energies move together, and the next move is smaller than this one: four times it is a wide margin.
    next.folds != 0 && next.folds == last.folds && 4.0 * moved < rival - next.energy
}

/// Branches that were not solved again at this level, as the level before left them.
fn keep_rivals(last: &Prediction, next: &mut Prediction) {
    let kept: Vec<_> = last.branches.iter().filter(|b| next.branches.iter().all(|n| n.asked != b.asked)).cloned().collect();
    next.branches.extend(kept);
    next.branches.sort_by_key(|b| b.asked);
}

/// Greatest distance between the same points of cloth, m; `None` between hems of different fold counts.
fn distance(a: &Prediction, b: &Prediction) -> Option<f64> {
    if a.folds != b.folds {
        return None;
    }
    // Both outlines start on a crest on the x axis and are equally spaced in cloth length.
    Some(a.outline.iter().zip(&b.outline).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max))
}
