//! Theory against measurement: a predicted hem laid over a measured outline.

use nalgebra::DMatrix;
use serde::Serialize;

use crate::experiment::polygon::{NearestPlace, Polygon};
use crate::experiment::profile::signed_area;
use crate::experiment::{DrapeProfile, Point};
use crate::fit::HemFit;
use crate::model::hem::Placement;
use crate::numerics::least_squares::{self, Problem};
use crate::simulate::Prediction;

/// Theory against measurement for one run, after the best shift and turn; metres.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Predicted fold count minus fitted fold count.
    pub folds: i64,
    /// Root mean square distance of the measured points from the predicted hem at the measured fold count, m.
    pub rms: f64,
    /// Predicted minus fitted fold depth, m.
    pub depth: f64,
    /// Predicted minus fitted mean radius (of equal area), m.
    pub mean_radius: f64,
    /// Where the prediction at the measured fold count was laid over the measurement.
    pub placement: Placement,
}

/// Compares the hem `predicted` at the fitted fold count, and the fold count of least energy `chosen`, with the measured outline and its fit.
///
/// The predicted hem is shifted and turned (not scaled) until the squared distances of the measured points from it are least.
pub fn compare(profile: &DrapeProfile, fit: &HemFit, predicted: &Prediction, chosen: &Prediction) -> Comparison {
    let (placement, rms) = lay_over(profile.points(), &predicted.outline, &fit.placement);
    Comparison {
        folds: i64::from(chosen.folds) - i64::from(fit.folds.unwrap_or(0)),
        rms,
        depth: predicted.depth() - fit.fold_depth,
        mean_radius: equal_area_radius(signed_area(&predicted.outline)) - equal_area_radius(fit.area),
        placement,
    }
}

/// Radius of the circle of this area.
fn equal_area_radius(area: f64) -> f64 {
    (area.abs() / std::f64::consts::PI).sqrt()
}

/// The shift and turn of `hem` that bring it nearest to `points`, from `start`; and the root mean square distance there.
fn lay_over(points: &[Point], hem: &[Point], start: &Placement) -> (Placement, f64) {
    let mut problem = Overlay { points, hem: Polygon::new(hem), near: vec![None; points.len()], rows: vec![[0.0; 3]; points.len()] };
    let options = least_squares::Options { gradient_tolerance: 1e-6, step_tolerance: 1e-8, evaluation_limit: 60, ..Default::default() };
    let summary =
        least_squares::solve(&mut problem, &[start.x0, start.y0, start.phase], &options).expect("a profile has more points than three");
    let [x0, y0, phase] = summary.parameters[..] else { unreachable!("three unknowns") };
    (Placement { x0, y0, phase }, (summary.sum_of_squares / points.len() as f64).sqrt())
}

/// Distances of points from a polygon that is shifted and turned.
struct Overlay<'a> {
    points: &'a [Point],
    hem: Polygon<'a>,
    /// The corner of the hem to which each point was nearest last.
    near: Vec<Option<usize>>,
    rows: Vec<[f64; 3]>,
}

impl Problem for Overlay<'_> {
    fn residual_count(&self) -> usize {
        self.points.len()
    }

    fn residuals(&mut self, unknowns: &[f64], residuals: &mut [f64]) -> bool {
        let (sin, cos) = unknowns[2].sin_cos();
        for (i, point) in self.points.iter().enumerate() {
            let (dx, dy) = (point.x - unknowns[0], point.y - unknowns[1]);
            // The point in the frame of the hem.
            let (x, y) = (dx * cos + dy * sin, dy * cos - dx * sin);
            let nearest = match self.near[i] {
                Some(corner) => self.hem.nearest_from(Point::new(x, y), corner),
                None => self.hem.nearest(Point::new(x, y)),
            };
            self.near[i] = Some(nearest.corner);
            let (foot, normal) = foot_and_normal(&nearest, Point::new(x, y));
            residuals[i] = (x - foot.x) * normal.0 + (y - foot.y) * normal.1;
            self.rows[i] = [-(normal.0 * cos - normal.1 * sin), -(normal.0 * sin + normal.1 * cos), normal.0 * y - normal.1 * x];
        }
        residuals.iter().all(|r| r.is_finite())
    }

    fn jacobian(&mut self, _unknowns: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
        for (i, row) in self.rows.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                jacobian[(i, j)] = *value;
            }
        }
        true
    }
}

/// The foot of `point` on a closed polygon and the unit vector from it towards the point, outward where the point lies on it.
fn foot_and_normal(nearest: &NearestPlace, point: Point) -> (Point, (f64, f64)) {
    let NearestPlace { square, foot, side, .. } = *nearest;
    let length = side.0.hypot(side.1).max(f64::MIN_POSITIVE);
    let outward = (side.1 / length, -side.0 / length);
    let distance = square.sqrt();
    if distance <= 1e-12 {
        return (foot, outward);
    }
    let (nx, ny) = ((point.x - foot.x) / distance, (point.y - foot.y) / distance);
    let sign = if nx * outward.0 + ny * outward.1 < 0.0 { -1.0 } else { 1.0 };
    (foot, (sign * nx, sign * ny))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::hem::Hem;

    #[test]
    fn a_hem_laid_over_itself_finds_its_own_place() {
        let hem = Hem { p: 0.15, q: 0.03, s: 0.005, folds: 6 };
        let at = Placement { x0: 0.012, y0: -0.007, phase: 0.41 };
        let measured = hem.outline(&at, 180);
        let predicted = hem.outline(&Placement::ORIGIN, 7200);
        let (found, rms) = lay_over(&measured, &predicted, &Placement { x0: 0.0, y0: 0.0, phase: 0.38 });
        // The polygon's edges are 0.2 mm long and sag by less than 1e-7 m.
        assert!(rms < 1e-6, "{rms}");
        assert!((found.x0 - at.x0).abs() < 1e-6 && (found.y0 - at.y0).abs() < 1e-6 && (found.phase - at.phase).abs() < 1e-5, "{found:?}");
    }
}
