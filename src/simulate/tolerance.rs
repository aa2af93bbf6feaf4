//! Accuracy asked, accuracy given: unknowns are added until the hem stops moving.

use super::{Fidelity, Options, Prediction, predict_once};
use crate::error::Error;
use crate::experiment::{Fabric, Skirt};

/// Harmonics of the ruled shell, level by level.
const RULED: [usize; 7] = [2, 4, 8, 12, 16, 24, 32];
/// Harmonics and modes of the graded shell.
const GRADED: [(usize, usize); 7] = [(2, 4), (3, 6), (4, 8), (5, 10), (6, 12), (8, 16), (10, 20)];

/// Refines until the hem moves by less than `tolerance` (m) from one level to the next; the last move is the error estimate.
///
/// Both families converge geometrically, so what is left is smaller than the last move. Where the last level still moves more, a note says so.
pub(super) fn predict(skirt: &Skirt, fabric: &Fabric, options: &Options, tolerance: f64) -> Result<Prediction, Error> {
    if !(tolerance.is_finite() && 0.0 < tolerance) {
        return Err(Error::Invalid { quantity: "tolerance, m", value: tolerance, allowed: "> 0" });
    }
    let levels: Vec<Fidelity> = match options.fidelity {
        Fidelity::Ruled { .. } => RULED.iter().map(|k| Fidelity::Ruled { harmonics: *k }).collect(),
        Fidelity::Graded { shear, .. } => GRADED.iter().map(|(k, j)| Fidelity::Graded { harmonics: *k, modes: *j, shear }).collect(),
        fixed => vec![fixed],
    };
    let mut last: Option<Prediction> = None;
    let mut evaluations = 0;
    for fidelity in &levels {
        let mut next = predict_once(skirt, fabric, &Options { fidelity: *fidelity, tolerance: None, ..*options })?;
        evaluations += next.evaluations;
        next.evaluations = evaluations;
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

/// Greatest distance between the same points of cloth, m; `None` between hems of different fold counts.
fn distance(a: &Prediction, b: &Prediction) -> Option<f64> {
    if a.folds != b.folds {
        return None;
    }
    // Both outlines start on a crest on the x axis and are equally spaced in cloth length.
    Some(a.outline.iter().zip(&b.outline).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max))
}
