//! When a swift fit may be believed without the careful path: a proof, cheaper than [`super::super::rules`] and stricter, that they all hold.
//!
//! Only a curve that leaves nothing but noise is certified. Then its feet come in order, no stretch of it lies between two neighbours' feet
//! that they could not see, and its half folds lie in wedges of their own: it is in order, as long as the outline, near it both ways, and simple.

use std::f64::consts::{PI, TAU};

use super::kernel::{Blocks, Finish, spread};
use crate::model::hem::Hem;

/// Largest departure of curve length from the outline's, relative: what [`super::super::rules`] allows where only noise is left.
const LENGTH_SLACK: f64 = 0.1;
/// Nodes in half a fold: a crossing smaller than this is not seen, as in the rule itself.
const NODES: usize = 64;
/// Least ratio of the mean square difference of neighbouring distances to twice their mean square: 1 for noise, 0 for a smooth misfit. For noise at
/// fifty points this is four standard deviations down.
const WHITENESS: f64 = 0.5;
/// A root mean square distance below this share of the radius needs no such proof: the curve is the outline.
const EXACT: f64 = 1e-6;

/// The outline's length, m, if the curve obeys every rule beyond doubt.
pub(super) fn outline_length(all: &Blocks, hem: &Hem, finish: &Finish) -> Option<f64> {
    if !(hem.p.is_finite() && hem.q.is_finite() && hem.s.is_finite() && hem.q.abs() < hem.p) {
        return None;
    }
    let (squares, differences) = spread(all, false);
    let rms = (squares / all.count as f64).sqrt();
    if EXACT * hem.p < rms && differences < WHITENESS * 2.0 * squares {
        return None;
    }
    let perimeter = hem.perimeter_to(1e-3).0;
    let sure = in_order(finish, perimeter, rms) && (finish.length / perimeter - 1.0).abs() <= LENGTH_SLACK;
    (sure && (finish.ascends || is_simple(hem))).then_some(finish.length)
}

/// Whether feet run back no further than noise makes them, go round once, and leave no stretch of curve between them that no point sees.
fn in_order(finish: &Finish, perimeter: f64, rms: f64) -> bool {
    let allowed = 5.5 * rms + 0.01 * perimeter;
    let round = (finish.turned - TAU).abs() < 1e-6 && finish.excess <= 6.0 * rms;
    // No run back is longer than all of them together.
    round && (-allowed <= finish.back || furthest_back(&finish.arcs) <= allowed)
}

/// The longest way back from any foot to a later one, m.
fn furthest_back(arcs: &[f64]) -> f64 {
    let (mut along, mut high, mut back) = (0.0, 0.0_f64, 0.0_f64);
    for arc in arcs {
        along += arc;
        high = high.max(along);
        back = back.max(high - along);
    }
    back
}

/// Whether the curve certainly does not cross itself: each half fold stays in its wedge and goes on in one direction.
fn is_simple(hem: &Hem) -> bool {
    let m = f64::from(hem.folds);
    let (wedge_sin, wedge_cos) = (PI / m).sin_cos();
    // e^{it} and e^{imt} go on by equal turns: no sine of their own.
    let (step_sin, step_cos) = (PI / (m * NODES as f64)).sin_cos();
    let (fold_step_sin, fold_step_cos) = (PI / NODES as f64).sin_cos();
    let ((mut cos, mut sin), (mut cos_fold, mut sin_fold)) = ((1.0, 0.0), (1.0, 0.0));
    let mut velocities = [(0.0, 0.0); NODES + 1];
    for (i, velocity) in velocities.iter_mut().enumerate() {
        let sin_lean = 2.0 * sin_fold * cos_fold;
        let (rho, tau) = (hem.p + hem.q * cos_fold, hem.s * sin_lean);
        let (x, y) = (rho * cos - tau * sin, rho * sin + tau * cos);
        if 0 < i && i < NODES && !(0.0 < y && 0.0 < x * wedge_sin - y * wedge_cos) {
            return false;
        }
        let radial = -m * hem.q * sin_fold - tau;
        let tangential = rho + 2.0 * m * hem.s * (1.0 - 2.0 * sin_fold * sin_fold);
        *velocity = (radial * cos - tangential * sin, radial * sin + tangential * cos);
        (cos, sin) = (cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin);
        (cos_fold, sin_fold) = (cos_fold * fold_step_cos - sin_fold * fold_step_sin, sin_fold * fold_step_cos + cos_fold * fold_step_sin);
    }
    let direction = velocities.iter().fold((0.0, 0.0), |a, v| (a.0 + v.0, a.1 + v.1));
    velocities.iter().all(|v| 0.0 < v.0 * direction.0 + v.1 * direction.1)
}
