//! The outline behind the points: a Fourier series in its own arc length, of an order chosen by evidence.
//!
//! Noise lengthens a polygon (it zigzags), so length, self-crossings and starting values are taken from this smooth curve instead.

use std::f64::consts::TAU;

use crate::experiment::{DrapeProfile, Point};

/// Samples of the polygon, and of the smooth curve: 512 resolve 24 folds with 20 samples each.
const SAMPLES: usize = 512;
/// Highest order tried: two harmonics of 24 folds with a few to spare.
const HIGHEST_ORDER: usize = 64;

/// A smooth closed outline at equal steps of its own length.
#[derive(Debug, Clone)]
pub struct Outline {
    /// [`SAMPLES`] points at equal steps of arc length, m, counter-clockwise.
    pub samples: Vec<Point>,
    /// Length, m.
    pub length: f64,
    /// Order of the series.
    pub order: usize,
    /// Root mean square distance of the points from the smooth curve in both coordinates, m.
    pub noise: f64,
    /// Root mean square distance of the samples from their centroid, m.
    pub radius: f64,
    /// How often the smooth curve crosses itself.
    pub crossings: usize,
}

/// The smooth outline of `profile`.
pub fn smooth(profile: &DrapeProfile) -> Outline {
    let points = profile.points();
    let n = points.len();
    let mut fraction = Vec::with_capacity(n);
    let mut length = 0.0;
    for (i, point) in points.iter().enumerate() {
        fraction.push(length);
        length += point.distance(points[(i + 1) % n]);
    }
    fraction.iter_mut().for_each(|f| *f /= length);

    let polygon = resample(points, &fraction);
    let highest = HIGHEST_ORDER.min(n / 4).max(1);
    let series = Series::of(&polygon, highest);
    let (order, noise) = order_by_evidence(&series, points, &fraction);

    // Twice through: the first pass gives equal steps of the polygon's length, the second of the curve's own.
    let fine: Vec<Point> = (0..8 * SAMPLES).map(|j| series.at(j as f64 / (8 * SAMPLES) as f64, order)).collect();
    let mut along = Vec::with_capacity(fine.len());
    let mut length = 0.0;
    for (i, point) in fine.iter().enumerate() {
        along.push(length);
        length += point.distance(fine[(i + 1) % fine.len()]);
    }
    along.iter_mut().for_each(|f| *f /= length);
    let samples = resample(&fine, &along);
    let (cx, cy) = centroid(&samples);
    let radius = (samples.iter().map(|p| (p.x - cx).powi(2) + (p.y - cy).powi(2)).sum::<f64>() / SAMPLES as f64).sqrt();
    let crossings = crossings(&samples);
    Outline { samples, length, order, noise, radius, crossings }
}

/// Mean of points at equal steps of length, m.
pub fn centroid(samples: &[Point]) -> (f64, f64) {
    let n = samples.len() as f64;
    (samples.iter().map(|p| p.x).sum::<f64>() / n, samples.iter().map(|p| p.y).sum::<f64>() / n)
}

/// How often a closed polygon crosses itself.
pub fn crossings(points: &[Point]) -> usize {
    let n = points.len();
    let side = |a: Point, b: Point, c: Point| (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    let mut count = 0;
    for i in 0..n {
        let (a, b) = (points[i], points[(i + 1) % n]);
        let (x_low, x_high) = (a.x.min(b.x), a.x.max(b.x));
        let (y_low, y_high) = (a.y.min(b.y), a.y.max(b.y));
        for j in i + 2..n {
            if i == 0 && j == n - 1 {
                continue;
            }
            let (c, d) = (points[j], points[(j + 1) % n]);
            if c.x.max(d.x) < x_low || x_high < c.x.min(d.x) || c.y.max(d.y) < y_low || y_high < c.y.min(d.y) {
                continue;
            }
            if side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0 {
                count += 1;
            }
        }
    }
    count
}

/// A closed polygon at [`SAMPLES`] equal steps of `fraction`, which ascends from 0 and stays below 1.
fn resample(points: &[Point], fraction: &[f64]) -> Vec<Point> {
    let n = points.len();
    let mut i = 0;
    (0..SAMPLES)
        .map(|j| {
            let target = j as f64 / SAMPLES as f64;
            while i + 1 < n && fraction[i + 1] <= target {
                i += 1;
            }
            let end = if i + 1 < n { fraction[i + 1] } else { 1.0 };
            let share = if fraction[i] < end { (target - fraction[i]) / (end - fraction[i]) } else { 0.0 };
            let (a, b) = (points[i], points[(i + 1) % n]);
            Point::new(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y))
        })
        .collect()
}

/// Complex Fourier coefficients of a closed curve: `z(f) = Σ c_k e^{2πi k f}`, |k| ≤ order.
struct Series {
    /// c_0, then (c_k, c_−k) for k = 1, 2, …; each (re, im).
    centre: (f64, f64),
    pairs: Vec<[(f64, f64); 2]>,
}

impl Series {
    fn of(samples: &[Point], order: usize) -> Series {
        let n = samples.len();
        let table: Vec<(f64, f64)> = (0..n).map(|j| (TAU * j as f64 / n as f64).sin_cos()).collect();
        let coefficient = |k: usize, sign: f64| {
            let (mut re, mut im) = (0.0, 0.0);
            for (j, p) in samples.iter().enumerate() {
                let (sin, cos) = table[j * k % n];
                let sin = sign * sin;
                re += p.x * cos + p.y * sin;
                im += p.y * cos - p.x * sin;
            }
            (re / n as f64, im / n as f64)
        };
        Series { centre: coefficient(0, 1.0), pairs: (1..=order).map(|k| [coefficient(k, 1.0), coefficient(k, -1.0)]).collect() }
    }

    /// The contribution of ±k at fraction `f`.
    fn pair(&self, k: usize, f: f64) -> (f64, f64) {
        let [(a, b), (c, d)] = self.pairs[k - 1];
        let (sin, cos) = (TAU * k as f64 * f).sin_cos();
        ((a + c) * cos + (d - b) * sin, (b + d) * cos + (a - c) * sin)
    }

    fn at(&self, f: f64, order: usize) -> Point {
        let (mut x, mut y) = self.centre;
        for k in 1..=order {
            let (dx, dy) = self.pair(k, f);
            x += dx;
            y += dy;
        }
        Point::new(x, y)
    }
}

/// The order of least AICc, and the root mean square distance that it leaves.
fn order_by_evidence(series: &Series, points: &[Point], fraction: &[f64]) -> (usize, f64) {
    let values = 2.0 * points.len() as f64;
    let mut left: Vec<(f64, f64)> = points.iter().map(|p| (p.x - series.centre.0, p.y - series.centre.1)).collect();
    let mut best = (f64::INFINITY, 1, 0.0);
    for k in 1..=series.pairs.len() {
        let mut square = 0.0;
        for ((x, y), &f) in left.iter_mut().zip(fraction) {
            let (dx, dy) = series.pair(k, f);
            *x -= dx;
            *y -= dy;
            square += *x * *x + *y * *y;
        }
        let parameters = 2.0 * (2.0 * k as f64 + 1.0) + 1.0;
        let spare = values - parameters - 1.0;
        if spare <= 0.0 {
            break;
        }
        let criterion =
            values * (square / values).max(f64::MIN_POSITIVE).ln() + 2.0 * parameters + 2.0 * parameters * (parameters + 1.0) / spare;
        if criterion < best.0 {
            best = (criterion, k, (square / values).sqrt());
        }
    }
    (best.1, best.2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::hem::{Hem, Placement};

    const HEM: Hem = Hem { p: 0.1315, q: 0.0527, s: 0.00873, folds: 5 };

    #[test]
    fn length_of_a_clean_outline_is_the_curves_own() {
        let profile = DrapeProfile::new(&HEM.outline(&Placement::ORIGIN, 360)).unwrap();
        let outline = smooth(&profile);
        // 360 chords cut corners by about (spacing κ)²/24 ~ 1e-4 of the length.
        assert!((outline.length / HEM.perimeter() - 1.0).abs() < 1e-3, "{} {}", outline.length, HEM.perimeter());
        assert_eq!(outline.crossings, 0);
    }

    #[test]
    fn zigzag_does_not_lengthen_the_outline() {
        let mut points = HEM.outline(&Placement::ORIGIN, 720);
        for (i, p) in points.iter_mut().enumerate() {
            // One millimetre in and out in turn, at 2 mm spacing: the polygon grows by 40 %.
            let scale = 1.0 + if i % 2 == 0 { 0.001 } else { -0.001 } / p.x.hypot(p.y);
            p.x *= scale;
            p.y *= scale;
        }
        let outline = smooth(&DrapeProfile::new(&points).unwrap());
        assert!((outline.length / HEM.perimeter() - 1.0).abs() < 0.01, "{} {}", outline.length, HEM.perimeter());
    }

    #[test]
    fn a_figure_of_eight_crosses_itself_once() {
        let points: Vec<Point> =
            (0..200).map(|i| f64::from(i) * TAU / 200.0 + 0.01).map(|t| Point::new(t.cos(), (2.0 * t).sin())).collect();
        assert_eq!(crossings(&points), 1);
    }
}
