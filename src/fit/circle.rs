//! The circle of least squared orthogonal distances: the hem without folds.

use nalgebra::{Matrix3, Vector3};

use crate::experiment::Point;

/// A fitted circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    pub x0: f64,
    pub y0: f64,
    /// m.
    pub radius: f64,
    /// Sum of squared distances, m².
    pub sum_of_squares: f64,
    /// Standard error of the radius, m.
    pub radius_error: f64,
}

/// Gauss–Newton from the centroid; quadratic-like convergence because the residuals are linear in all but the direction.
pub fn fit(points: &[Point]) -> Circle {
    let n = points.len() as f64;
    let mut x0 = points.iter().map(|p| p.x).sum::<f64>() / n;
    let mut y0 = points.iter().map(|p| p.y).sum::<f64>() / n;
    let mut radius = points.iter().map(|p| (p.x - x0).hypot(p.y - y0)).sum::<f64>() / n;
    let mut inverse = 0.0;
    for _ in 0..50 {
        let mut normal = Matrix3::<f64>::zeros();
        let mut right = Vector3::<f64>::zeros();
        for point in points {
            let (dx, dy) = (point.x - x0, point.y - y0);
            let r = dx.hypot(dy).max(f64::MIN_POSITIVE);
            let row = Vector3::new(dx / r, dy / r, 1.0);
            normal += row * row.transpose();
            right += row * (r - radius);
        }
        let Some(factor) = normal.cholesky() else { break };
        inverse = factor.inverse()[(2, 2)];
        let step = factor.solve(&right);
        x0 += step[0];
        y0 += step[1];
        radius += step[2];
        if step.amax() <= 1e-15 * radius {
            break;
        }
    }
    let sum_of_squares: f64 = points.iter().map(|p| ((p.x - x0).hypot(p.y - y0) - radius).powi(2)).sum();
    Circle { x0, y0, radius, sum_of_squares, radius_error: (sum_of_squares / (n - 3.0) * inverse).sqrt() }
}
