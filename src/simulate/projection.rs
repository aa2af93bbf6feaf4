//! The paper's p, q, s of a predicted hem: the nearest curve of that family.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use crate::experiment::Point;
use crate::model::functional::Places;
use crate::model::hem::{Hem, Placement};
use crate::numerics::lanes::{Lanes, WIDTH, multiple_angle, small_angle, turned};
use crate::numerics::least_squares::{Options, Problem, solve};
use crate::vectorized;

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
    /// Of eight points each; the last point as often as it takes.
    feet: Vec<Feet>,
}

/// Eight points and their feet on the curve.
struct Feet {
    point: [Lanes; 2],
    /// cos t and sin t.
    place: [Lanes; 2],
    /// cos mt and sin mt.
    phase: [Lanes; 2],
    normal: [Lanes; 2],
    /// Signed distance of the point, m.
    distance: Lanes,
}

impl Nearest<'_> {
    /// For each point the nearest node of a grid on the curve.
    fn nodes(&self, hem: &Hem) -> Vec<Feet> {
        const GRID: usize = 128;
        let fold = TAU / f64::from(self.folds);
        // Deep folds lean over their neighbours: look half a fold beyond both ends.
        let grid: Vec<(f64, Point)> =
            (0..=2 * GRID).map(|i| fold * (i as f64 / GRID as f64 - 0.5)).map(|t| (t, hem.point(&Placement::ORIGIN, t))).collect();
        let square = |a: &Point, b: &Point| (a.x - b.x).powi(2) + (a.y - b.y).powi(2);
        let nearest =
            |point: &Point| grid.iter().min_by(|a, b| square(&a.1, point).total_cmp(&square(&b.1, point))).map_or(0.0, |node| node.0);
        let block = |points: &[Point]| {
            let point = |lane: usize| points[lane.min(points.len() - 1)];
            let starts: [f64; WIDTH] = std::array::from_fn(|lane| nearest(&point(lane)));
            Feet {
                point: [Lanes(std::array::from_fn(|lane| point(lane).x)), Lanes(std::array::from_fn(|lane| point(lane).y))],
                place: [Lanes(starts.map(f64::cos)), Lanes(starts.map(f64::sin))],
                phase: [Lanes::ZERO; 2],
                normal: [Lanes::ZERO; 2],
                distance: Lanes::ZERO,
            }
        };
        self.points.chunks(WIDTH).map(block).collect()
    }
}

vectorized! {
    /// The feet on `hem` near to where they were: Newton on the right angle.
    fn walk<V>(hem: &Hem, feet: &mut [Feet]) -> () {
        let m = f64::from(hem.folds);
        let reach = TAU / m / 64.0;
        for feet in feet {
            let [x, y] = [V::of(&feet.point[0]), V::of(&feet.point[1])];
            let mut place = (V::of(&feet.place[0]), V::of(&feet.place[1]));
            let mut still = false;
            for left in (0..=STEPS).rev() {
                let phase = multiple_angle(hem.folds, place);
                let Places { position, velocity, acceleration } = Places::<V, 0>::at(hem, phase);
                let (vx, vy) = (velocity.0.value, velocity.1.value);
                // The point in the frame that turns with the parameter.
                let dx = position.0.value - x.mul_add(place.0, y * place.1);
                let dy = position.1.value - y.mul_sub(place.0, x * place.1);
                let square = vx.mul_add(vx, vy * vy);
                if still || left == 0 {
                    let speed = square.sqrt();
                    let normal = (vy / speed, -(vx / speed));
                    feet.place = [place.0.lanes(), place.1.lanes()];
                    feet.phase = [phase.0.lanes(), phase.1.lanes()];
                    feet.normal = [normal.0.lanes(), normal.1.lanes()];
                    feet.distance = (-dx.mul_add(normal.0, dy * normal.1)).lanes();
                    break;
                }
                let bend = dx.mul_add(acceleration.0.value, dy.mul_add(acceleration.1.value, square));
                let slope = dx.mul_add(vx, dy * vy);
                let step = (-slope / bend.where_above(V::zero(), square)).within(reach);
                place = turned(place, small_angle(step));
                // What is left is about its square.
                still = step.abs().greatest() < 1e-9;
            }
        }
    }
}

/// Newton takes three or four steps from the grid, one or two from where a foot was.
const STEPS: usize = 20;

impl Problem for Nearest<'_> {
    fn residual_count(&self) -> usize {
        self.points.len()
    }

    fn residuals(&mut self, x: &[f64], residuals: &mut [f64]) -> bool {
        let hem = Hem { p: x[0], q: x[1], s: x[2], folds: self.folds };
        // From one step of the fit to the next a foot moves little: only the first needs the grid.
        if self.feet.is_empty() {
            self.feet = self.nodes(&hem);
        }
        walk(&hem, &mut self.feet);
        for (i, residual) in residuals.iter_mut().enumerate() {
            *residual = self.feet[i / WIDTH].distance.0[i % WIDTH];
        }
        residuals.iter().all(|r| r.is_finite())
    }

    fn jacobian(&mut self, _: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
        // −n·∂c/∂(p, q, s): the foot point is stationary, so nothing else is needed.
        for i in 0..self.points.len() {
            let (feet, lane) = (&self.feet[i / WIDTH], i % WIDTH);
            let [cos, sin] = [feet.phase[0].0[lane], feet.phase[1].0[lane]];
            let normal = [feet.normal[0].0[lane], feet.normal[1].0[lane]];
            jacobian[(i, 0)] = -normal[0];
            jacobian[(i, 1)] = -normal[0] * cos;
            jacobian[(i, 2)] = -normal[1] * 2.0 * sin * cos;
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
