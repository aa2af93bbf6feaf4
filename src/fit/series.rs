//! The Fourier series of a closed curve through points, of an order chosen by evidence.

use std::f64::consts::{PI, TAU};

use super::akaike;
use super::eight_places::in_eights;
use super::outline::centroid;
use crate::experiment::Point;
use crate::numerics::lanes::{Lanes, Vector, WIDTH, sin_cos, turned};
use crate::vectorized;

/// Orders tried in vain before giving up: the next harmonic of up to 60 folds lies within them.
const PATIENCE: usize = 61;

/// Complex Fourier coefficients of a closed curve: `z(f) = Σ c_k e^{2πi k f}`, |k| ≤ order.
pub(super) struct Series {
    /// c_0, then (c_k, c_−k) for k = 1, 2, …; each (re, im).
    centre: (f64, f64),
    pairs: Vec<[(f64, f64); 2]>,
}

impl Series {
    /// The series of a polygon whose corners are `spacing` apart (as a fraction of the whole).
    ///
    /// Straight sides flatten the harmonic k by sinc²(k·spacing); that is undone.
    pub fn of(samples: &[Point], order: usize, spacing: f64) -> Series {
        let n = samples.len();
        let (x, y) = (in_eights(samples.iter().map(|p| p.x), 0.0), in_eights(samples.iter().map(|p| p.y), 0.0));
        let angles = in_eights((0..n).map(|j| TAU * j as f64 / n as f64), 0.0);
        let mut sums = vec![[0.0; 4]; order];
        harmonics(&angles, &x, &y, &mut sums);
        let pair = |k: usize, [x_cos, x_sin, y_cos, y_sin]: [f64; 4]| {
            let angle = PI * k as f64 * spacing;
            let flattened = if angle < 1e-6 { 1.0 } else { (angle.sin() / angle).powi(2) };
            let weight = 1.0 / (n as f64 * flattened.max(0.5));
            [((x_cos + y_sin) * weight, (y_cos - x_sin) * weight), ((x_cos - y_sin) * weight, (y_cos + x_sin) * weight)]
        };
        Series { centre: centroid(samples), pairs: (1..).zip(sums).map(|(k, sums)| pair(k, sums)).collect() }
    }

    /// `n` points at equal steps of the parameter.
    pub fn samples(&self, n: usize, order: usize) -> Vec<Point> {
        let mut points = Vec::with_capacity(n + WIDTH);
        let angles = in_eights((0..n).map(|j| TAU * j as f64 / n as f64), 0.0);
        add_harmonics(self.centre, &self.pairs[..order.min(self.pairs.len())], &angles, &mut points);
        points.truncate(n);
        points
    }
}

vectorized! {
    /// For k = 1, 2, … the sums of x and y times cosine and sine of k times the angle: x cos, x sin, y cos, y sin.
    fn harmonics<V>(angles: &[Lanes], x: &[Lanes], y: &[Lanes], sums: &mut [[f64; 4]]) -> () {
        let units: Vec<[Lanes; 2]> = unit_circle::<V>(angles);
        let mut turns = vec![[Lanes([1.0; WIDTH]), Lanes::ZERO]; angles.len()];
        for sum in sums {
            let mut parts = [V::zero(); 4];
            for (((turn, unit), x), y) in turns.iter_mut().zip(&units).zip(x).zip(y) {
                let (cos, sin) = turned((V::of(&turn[0]), V::of(&turn[1])), (V::of(&unit[0]), V::of(&unit[1])));
                *turn = [cos.lanes(), sin.lanes()];
                let (x, y) = (V::of(x), V::of(y));
                parts[0] = x.mul_add(cos, parts[0]);
                parts[1] = x.mul_add(sin, parts[1]);
                parts[2] = y.mul_add(cos, parts[2]);
                parts[3] = y.mul_add(sin, parts[3]);
            }
            *sum = [parts[0].sum(), parts[1].sum(), parts[2].sum(), parts[3].sum()];
        }
    }
}

vectorized! {
    fn add_harmonics<V>(centre: (f64, f64), pairs: &[[(f64, f64); 2]], angles: &[Lanes], points: &mut Vec<Point>) -> () {
        for unit in unit_circle::<V>(angles) {
            let unit = (V::of(&unit[0]), V::of(&unit[1]));
            let (mut x, mut y) = (V::all(centre.0), V::all(centre.1));
            let mut turn = unit;
            for pair in pairs {
                let [dx, dy] = contribution(pair, turn);
                (x, y) = (x + dx, y + dy);
                turn = turned(turn, unit);
            }
            let (x, y) = (x.lanes().0, y.lanes().0);
            for lane in 0..WIDTH {
                points.push(Point::new(x[lane], y[lane]));
            }
        }
    }
}

/// (cos, sin) of angles.
#[inline(always)]
fn unit_circle<V: Vector>(angles: &[Lanes]) -> Vec<[Lanes; 2]> {
    let mut units = Vec::with_capacity(angles.len());
    for angle in angles {
        let (sin, cos) = sin_cos(V::of(angle));
        units.push([cos.lanes(), sin.lanes()]);
    }
    units
}

/// What the harmonics ±k add where k times the angle has this (cosine, sine).
#[inline(always)]
fn contribution<V: Vector>([(a, b), (c, d)]: &[(f64, f64); 2], (cos, sin): (V, V)) -> [V; 2] {
    [cos * (a + c) + sin * (d - b), cos * (b + d) + sin * (a - c)]
}

/// The order of least AICc, the root mean square distance that it leaves in each coordinate, and the criterion.
pub(super) fn order_by_evidence(series: &Series, points: &[Point], fraction: &[f64]) -> (usize, f64, f64) {
    let values = 2.0 * points.len() as f64;
    let mut squares = vec![0.0; series.pairs.len()];
    // Where there is no point nothing is left.
    let left = |of: fn(&Point) -> f64, centre: f64| in_eights(points.iter().map(|p| of(p) - centre), 0.0);
    let weight = in_eights(points.iter().map(|_| 1.0), 0.0);
    let angles = in_eights(fraction.iter().map(|f| TAU * f), 0.0);
    take_harmonics(&series.pairs, &angles, &weight, left(|p| p.x, series.centre.0), left(|p| p.y, series.centre.1), &mut squares);
    let mut best = (f64::INFINITY, 1, 0.0);
    for (k, square) in (1..).zip(squares) {
        if best.1 + PATIENCE < k {
            break;
        }
        let parameters = 2.0 * (2.0 * k as f64 + 1.0) + 1.0;
        let criterion = akaike(square / values, values, parameters);
        if criterion == f64::INFINITY {
            break;
        }
        if criterion < best.0 {
            best = (criterion, k, (square / values).sqrt());
        }
    }
    (best.1, best.2, best.0)
}

vectorized! {
    /// What is left of x and y, squared and added up, as one pair of harmonics after the other is taken off.
    fn take_harmonics<V>(
        pairs: &[[(f64, f64); 2]],
        angles: &[Lanes],
        weight: &[Lanes],
        x: Vec<Lanes>,
        y: Vec<Lanes>,
        squares: &mut [f64],
    ) -> () {
        let units = unit_circle::<V>(angles);
        let mut turns = units.clone();
        let (mut x, mut y) = (x, y);
        for (pair, square) in pairs.iter().zip(squares) {
            let mut sum = V::zero();
            for (i, unit) in units.iter().enumerate() {
                let turn = (V::of(&turns[i][0]), V::of(&turns[i][1]));
                let ([dx, dy], weight) = (contribution(pair, turn), V::of(&weight[i]));
                let (left_x, left_y) = (V::of(&x[i]) - dx * weight, V::of(&y[i]) - dy * weight);
                sum = sum + (left_x * left_x + left_y * left_y);
                (x[i], y[i]) = (left_x.lanes(), left_y.lanes());
                let (cos, sin) = turned(turn, (V::of(&unit[0]), V::of(&unit[1])));
                turns[i] = [cos.lanes(), sin.lanes()];
            }
            *square = sum.sum();
        }
    }
}
