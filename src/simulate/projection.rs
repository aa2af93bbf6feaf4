//! The paper's p, q, s of a predicted hem: the nearest curve of that family.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use crate::experiment::Point;
use crate::model::hem::{Hem, Placement};
use crate::numerics::least_squares::{Options, Problem, solve};

/// p, q, s nearest to a centred hem of `folds` equal folds with a crest on the x axis, and the root mean square orthogonal distance that is left, m.
///
/// `outline` has the same number of points in every fold. `None` for a round hem, or where the iteration does not converge.
pub(super) fn onto_paper_curve(outline: &[Point], folds: u32) -> Option<(Hem, f64)> {
    let one_fold = outline.len().checked_div(folds as usize)?;
    // By symmetry one fold says everything.
    let points = &outline[..one_fold];
    let radii = || points.iter().map(|p| p.x.hypot(p.y));
    let (low, high) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
    // The lean is about a sixth of the amplitude in every hem that minimizes an energy.
    let start = [0.5 * (high + low), 0.5 * (high - low), 0.08 * (high - low)];
    let mut problem = Nearest { points, folds, feet: Vec::new() };
    let summary = solve(&mut problem, &start, &Options { step_tolerance: 1e-10, ..Options::default() }).ok()?;
    let [p, q, s] = summary.parameters[..] else { return None };
    summary.termination.converged().then(|| (Hem { p, q, s, folds }, (summary.sum_of_squares / one_fold as f64).sqrt()))
}

struct Nearest<'a> {
    points: &'a [Point],
    folds: u32,
    /// Parameter and unit normal of each foot point.
    feet: Vec<(f64, (f64, f64))>,
}

impl Nearest<'_> {
    /// For each point the nearest node of a grid on the curve.
    fn nodes(&self, hem: &Hem) -> Vec<f64> {
        const GRID: usize = 128;
        let fold = TAU / f64::from(self.folds);
        // Deep folds lean over their neighbours: look half a fold beyond both ends.
        let grid: Vec<(f64, Point)> =
            (0..=2 * GRID).map(|i| fold * (i as f64 / GRID as f64 - 0.5)).map(|t| (t, hem.point(&Placement::ORIGIN, t))).collect();
        let square = |a: &Point, b: &Point| (a.x - b.x).powi(2) + (a.y - b.y).powi(2);
        let nearest =
            |point: &Point| grid.iter().min_by(|a, b| square(&a.1, point).total_cmp(&square(&b.1, point))).map_or(0.0, |node| node.0);
        self.points.iter().map(nearest).collect()
    }

    /// Parameter of the foot of `point` on `hem` near `t`: Newton on the right angle.
    fn foot(&self, hem: &Hem, point: Point, mut t: f64) -> f64 {
        let reach = TAU / f64::from(self.folds) / 64.0;
        for _ in 0..20 {
            let (local, (sin, cos)) = (hem.local(t), t.sin_cos());
            // The point in the frame that turns with the parameter.
            let (dx, dy) = (local.position.0 - (point.x * cos + point.y * sin), local.position.1 - (point.y * cos - point.x * sin));
            let slope = dx * local.velocity.0 + dy * local.velocity.1;
            let bend = dx * local.acceleration.0 + dy * local.acceleration.1 + local.speed().powi(2);
            let step = -slope / if 0.0 < bend { bend } else { local.speed().powi(2) };
            t += step.clamp(-reach, reach);
            if step.abs() < 1e-14 {
                break;
            }
        }
        t
    }
}

impl Problem for Nearest<'_> {
    fn residual_count(&self) -> usize {
        self.points.len()
    }

    fn residuals(&mut self, x: &[f64], residuals: &mut [f64]) -> bool {
        let hem = Hem { p: x[0], q: x[1], s: x[2], folds: self.folds };
        // From one step of the fit to the next a foot moves little: only the first needs the grid.
        let starts = if self.feet.is_empty() { self.nodes(&hem) } else { self.feet.iter().map(|foot| foot.0).collect() };
        let mut feet = Vec::with_capacity(self.points.len());
        for ((point, residual), start) in self.points.iter().zip(residuals.iter_mut()).zip(starts) {
            let t = self.foot(&hem, *point, start);
            let (local, (sin, cos)) = (hem.local(t), t.sin_cos());
            let normal = (local.velocity.1 / local.speed(), -local.velocity.0 / local.speed());
            let (dx, dy) = (point.x * cos + point.y * sin - local.position.0, point.y * cos - point.x * sin - local.position.1);
            *residual = dx * normal.0 + dy * normal.1;
            feet.push((t, normal));
        }
        self.feet = feet;
        residuals.iter().all(|r| r.is_finite())
    }

    fn jacobian(&mut self, _: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
        // −n·∂c/∂(p, q, s): the foot point is stationary, so nothing else is needed.
        for (i, (t, normal)) in self.feet.iter().enumerate() {
            let phase = f64::from(self.folds) * t;
            jacobian[(i, 0)] = -normal.0;
            jacobian[(i, 1)] = -normal.0 * phase.cos();
            jacobian[(i, 2)] = -normal.1 * (2.0 * phase).sin();
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curve_of_the_family_projects_onto_itself() {
        let hem = Hem { p: 0.1315, q: 0.0527, s: 0.00873, folds: 5 };
        let (found, rms) = onto_paper_curve(&hem.outline(&Placement::ORIGIN, 720), 5).unwrap();
        // Gauss–Newton on a problem of zero residual.
        assert!(rms < 1e-14 && (found.p - hem.p).abs() < 1e-13 && (found.q - hem.q).abs() < 1e-13 && (found.s - hem.s).abs() < 1e-13);
        assert!(onto_paper_curve(&hem.outline(&Placement::ORIGIN, 720), 0).is_none());
    }
}
