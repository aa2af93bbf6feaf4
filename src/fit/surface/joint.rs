//! The joint orthogonal fit of a surface to its points, from a surface that is nearly right.

use nalgebra::{DMatrix, DVector};

use super::super::foot_point::{Foot, centred, follow, nearest, nearest_within};
use super::Options;
use super::lines::{Lines, curve};
use crate::error::Error;
use crate::experiment::Point;
use crate::numerics::least_squares::{self, Problem, Summary};

/// Starts a fold when a foot is looked for anew.
const FOOT_STARTS: usize = 16;

/// The joint fit from `start`; `None` if it does not converge.
pub(super) fn joint(
    start: &Lines,
    places: &[[f64; 3]],
    options: &Options,
    evaluations: &mut usize,
) -> Result<Option<(Lines, Summary)>, Error> {
    let feet = places.iter().map(|place| foot(start, place).t).collect();
    let size = places.iter().map(|[x, y, _]| x.abs().max(y.abs())).fold(0.0, f64::max);
    let solver = least_squares::Options { residual_rounding: 4.0 * f64::EPSILON * size, ..options.solver };
    let mut problem = Joint { places, lines: *start, feet, trial: vec![None; places.len()] };
    let mut lines = *start;
    // Feet that are nearer on another flank are moved, and the fit goes on; in practice after one round.
    for _ in 0..4 {
        let summary = least_squares::solve(&mut problem, &lines.values, &solver)?;
        *evaluations += summary.evaluations;
        if !summary.termination.converged() && summary.termination != least_squares::Termination::Stalled {
            return Ok(None);
        }
        lines.values.copy_from_slice(&summary.parameters);
        if !problem.look_again(&lines) {
            return Ok(Some((lines, summary)));
        }
    }
    Ok(None)
}

/// The nearest foot on the curve at the place's height.
pub(super) fn foot(lines: &Lines, [x, y, z]: &[f64; 3]) -> Foot {
    let (hem, placement) = lines.curve(*z);
    nearest(&hem, centred(Point::new(*x, *y), &placement), FOOT_STARTS)
}

/// Signed distances of places from the surface, m.
pub(super) fn distances(lines: &Lines, places: &[[f64; 3]]) -> Vec<f64> {
    places.iter().map(|place| foot(lines, place).distance()).collect()
}

/// Residuals: the horizontal distance of every point from the curve at its height.
struct Joint<'a> {
    places: &'a [[f64; 3]],
    /// Fold count and mean height; the values change.
    lines: Lines,
    /// Feet at the current iterate.
    feet: Vec<f64>,
    /// Feet at the last evaluated unknowns.
    trial: Vec<Option<Foot>>,
}

impl Joint<'_> {
    /// Whether some point has a nearer foot elsewhere within half a fold; moves those feet.
    fn look_again(&mut self, lines: &Lines) -> bool {
        let half = std::f64::consts::PI / f64::from(lines.folds.max(1));
        let mut moved = false;
        for (place, t) in self.places.iter().zip(&mut self.feet) {
            let (hem, placement) = lines.curve(place[2]);
            let point = centred(Point::new(place[0], place[1]), &placement);
            let here = Foot::at(&hem, point, *t);
            let found = nearest_within(&hem, point, *t - half, *t + half, FOOT_STARTS);
            if found.square() < here.square() * (1.0 - 1e-6) - 1e-18 {
                *t = found.t;
                moved = true;
            }
        }
        moved
    }
}

impl Problem for Joint<'_> {
    fn residual_count(&self) -> usize {
        self.places.len()
    }

    fn residuals(&mut self, x: &[f64], residuals: &mut [f64]) -> bool {
        for (i, (place, residual)) in self.places.iter().zip(residuals).enumerate() {
            let (hem, placement) = curve(x, self.lines.folds, place[2] - self.lines.middle);
            let foot = follow(&hem, centred(Point::new(place[0], place[1]), &placement), self.feet[i]);
            *residual = foot.distance();
            self.trial[i] = Some(foot);
            if !residual.is_finite() {
                return false;
            }
        }
        true
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
        for (i, (foot, place)) in self.trial.iter().zip(self.places).enumerate() {
            let Some(foot) = foot else { return false };
            let local = &foot.local;
            let speed = local.speed();
            let (nr, nt) = (local.velocity.1 / speed, -local.velocity.0 / speed);
            let (sin, cos) = (foot.t + x[2]).sin_cos();
            let dz = place[2] - self.lines.middle;
            let by = [-(nr * cos - nt * sin), -(nr * sin + nt * cos), -nr, -nr * local.cos_fold, -nt * local.sin_lean];
            jacobian[(i, 2)] = nr * local.position.1 - nt * local.position.0;
            for (by, (value, slope)) in by.into_iter().zip([(0, 6), (1, 7), (3, 8), (4, 9), (5, 10)]) {
                jacobian[(i, value)] = by;
                jacobian[(i, slope)] = dz * by;
            }
        }
        true
    }

    fn accept(&mut self) -> bool {
        for (foot, trial) in self.feet.iter_mut().zip(&self.trial) {
            if let Some(trial) = trial {
                *foot = trial.t;
            }
        }
        true
    }

    fn constraint(&mut self, _: &[f64]) -> Option<(f64, DVector<f64>)> {
        None
    }
}
