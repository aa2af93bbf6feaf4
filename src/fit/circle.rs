//! The circle of least squared orthogonal distances: the hem without folds.

use nalgebra::{Matrix3, Vector3};

use crate::experiment::Point;
use crate::numerics::lanes::{Lanes, WIDTH};
use crate::vectorized;

/// A fitted circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    pub x0: f64,
    pub y0: f64,
    /// m.
    pub radius: f64,
    /// Sum of squared distances, m².
    pub sum_of_squares: f64,
}

/// Gauss–Newton from the centroid; quadratic-like convergence because the residuals are linear in all but the direction.
pub fn fit(points: &[Point]) -> Circle {
    let n = points.len() as f64;
    // About the mean point, so that a far origin costs no digits of the squares.
    let o = points[0];
    let middle =
        Point::new(o.x + points.iter().map(|p| p.x - o.x).sum::<f64>() / n, o.y + points.iter().map(|p| p.y - o.y).sum::<f64>() / n);
    let blocks: Vec<Block> = points.chunks(WIDTH).map(|chunk| Block::new(chunk, middle)).collect();
    let (mut x0, mut y0, mut radius) = (0.0, 0.0, sums(&blocks, 0.0, 0.0, 0.0).right[2] / n);
    for _ in 0..50 {
        let Sums { normal, right, .. } = sums(&blocks, x0, y0, radius);
        let Some(factor) = normal.cholesky() else { break };
        let step = factor.solve(&right);
        x0 += step[0];
        y0 += step[1];
        radius += step[2];
        // The sum of squares is right to the square of what is left.
        if step.amax() <= 1e-9 * radius {
            break;
        }
    }
    let sum_of_squares = sums(&blocks, x0, y0, radius).square;
    Circle { x0: middle.x + x0, y0: middle.y + y0, radius, sum_of_squares }
}

/// Eight points; lanes without a point weigh nothing.
struct Block {
    x: Lanes,
    y: Lanes,
    weight: Lanes,
}

impl Block {
    fn new(points: &[Point], origin: Point) -> Block {
        let at = |lane: usize| points.get(lane).unwrap_or(&points[0]);
        Block {
            x: Lanes(std::array::from_fn(|lane| at(lane).x - origin.x)),
            y: Lanes(std::array::from_fn(|lane| at(lane).y - origin.y)),
            weight: Lanes(std::array::from_fn(|lane| f64::from(u8::from(lane < points.len())))),
        }
    }
}

/// Normal matrix, right-hand side and sum of squares of the distances from one circle.
struct Sums {
    normal: Matrix3<f64>,
    right: Vector3<f64>,
    square: f64,
}

vectorized! {
    fn sums<V>(blocks: &[Block], x0: f64, y0: f64, radius: f64) -> Sums {
        let mut normal = [V::zero(); 6];
        let mut right = [V::zero(); 3];
        let mut square = V::zero();
        for Block { x, y, weight } in blocks {
            let (dx, dy, w) = (V::of(x) - x0, V::of(y) - y0, V::of(weight));
            let r = (dx * dx + dy * dy).sqrt().max(V::all(f64::MIN_POSITIVE));
            let inverse = w / r;
            let (u, v) = (dx * inverse, dy * inverse);
            let distance = w * (r - radius);
            for (sum, value) in normal.iter_mut().zip([u * u, u * v, v * v, u, v, w]) {
                *sum = *sum + value;
            }
            for (sum, value) in right.iter_mut().zip([u, v, w]) {
                *sum = *sum + value * distance;
            }
            square = square + distance * distance;
        }
        let [uu, uv, vv, u, v, w] = [normal[0].sum(), normal[1].sum(), normal[2].sum(), normal[3].sum(), normal[4].sum(), normal[5].sum()];
        Sums {
            normal: Matrix3::new(uu, uv, u, uv, vv, v, u, v, w),
            right: Vector3::new(right[0].sum(), right[1].sum(), right[2].sum()),
            square: square.sum(),
        }
    }
}
