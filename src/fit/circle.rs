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

/// Gauss–Newton from the mean point; quadratic-like convergence because the residuals are linear in all but the direction.
pub fn fit(points: &[Point]) -> Circle {
    let (blocks, middle) = about_the_mean(points);
    // Any radius does to begin with: the distances are linear in it.
    let (mut x0, mut y0, mut radius) = (0.0, 0.0, 0.0);
    for _ in 0..50 {
        let Sums { normal, right, .. } = sums(&blocks, x0, y0, radius);
        let Some(factor) = normal.cholesky() else {
            // No centre is better than another: the mean distance from this one.
            radius += right[2] / points.len() as f64;
            break;
        };
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

vectorized! {
    /// The points about their mean, so that a far origin costs no digits of the squares; and that mean.
    fn about_the_mean<V>(points: &[Point]) -> (Vec<Block>, Point) {
        let o = points[0];
        let mut blocks = Vec::with_capacity(points.len().div_ceil(WIDTH));
        let (mut sum_x, mut sum_y) = (V::zero(), V::zero());
        for chunk in points.chunks(WIDTH) {
            let mut block = Block { x: Lanes::ZERO, y: Lanes::ZERO, weight: Lanes::ZERO };
            for (lane, point) in chunk.iter().enumerate() {
                (block.x.0[lane], block.y.0[lane], block.weight.0[lane]) = (point.x - o.x, point.y - o.y, 1.0);
            }
            (sum_x, sum_y) = (sum_x + V::of(&block.x), sum_y + V::of(&block.y));
            blocks.push(block);
        }
        let n = points.len() as f64;
        let (x, y) = (sum_x.sum() / n, sum_y.sum() / n);
        for block in &mut blocks {
            block.x = (V::of(&block.x) - x).lanes();
            block.y = (V::of(&block.y) - y).lanes();
        }
        (blocks, Point::new(o.x + x, o.y + y))
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
            let r = dx.mul_add(dx, dy * dy).sqrt().max(V::all(f64::MIN_POSITIVE));
            let inverse = w / r;
            let (u, v) = (dx * inverse, dy * inverse);
            let distance = w * (r - radius);
            normal[0] = u.mul_add(u, normal[0]);
            normal[1] = u.mul_add(v, normal[1]);
            normal[2] = v.mul_add(v, normal[2]);
            normal[3] = normal[3] + u;
            normal[4] = normal[4] + v;
            normal[5] = normal[5] + w;
            right[0] = u.mul_add(distance, right[0]);
            right[1] = v.mul_add(distance, right[1]);
            right[2] = right[2] + distance;
            square = distance.mul_add(distance, square);
        }
        let [uu, uv, vv, u, v, w] = [normal[0].sum(), normal[1].sum(), normal[2].sum(), normal[3].sum(), normal[4].sum(), normal[5].sum()];
        Sums {
            normal: Matrix3::new(uu, uv, u, uv, vv, v, u, v, w),
            right: Vector3::new(right[0].sum(), right[1].sum(), right[2].sum()),
            square: square.sum(),
        }
    }
}
