//! The outline behind the points: a Fourier series in its own arc length, of an order chosen by evidence, or the lines of even folds where
//! they describe the points better.
//!
//! Noise lengthens a polygon (it zigzags), so length, self-crossings and starting values are taken from this smooth curve instead.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use super::akaike;
use super::eight_places::{in_eights, points_at};
use super::even::{self, even_folds};
use crate::experiment::polygon::Polygon;
use crate::experiment::{DrapeProfile, Point};
use crate::model::hem::{Hem, Placement};
use crate::numerics::lanes::{Lanes, Vector, WIDTH, turned};
use crate::numerics::sine::sin_cos;
use crate::vectorized;

/// Samples of the polygon, and of the smooth curve: 1024 resolve 60 folds with 17 samples each.
const SAMPLES: usize = 1024;
/// Highest order tried: deep folds need about eight harmonics, 24 of them 192.
const HIGHEST_ORDER: usize = 192;
/// Orders tried in vain before giving up: the next harmonic of up to 60 folds lies within them.
const PATIENCE: usize = 61;
/// Noise above this share of the point spacing disturbs the polygon's own length as a parameter; the points are then parametrized anew by
/// their place along the smooth curve.
const DISTURBING_NOISE: f64 = 0.25;

/// A gap of more than this share of the outline's length is a missing piece if it is also wide for the number of points.
pub const MISSING: f64 = 1.0 / 12.0;

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
    /// Fraction of the outline's length at which each point of the profile lies.
    pub places: Vec<f64>,
    /// What even folds say of every fold count that the points can show, ascending.
    pub evidence: Vec<even::Evidence>,
    /// Whether even folds describe the points better than the free series.
    pub even: bool,
}

/// The smooth outline of `profile`.
pub fn smooth(profile: &DrapeProfile) -> Outline {
    let points = profile.points();
    let n = points.len();
    let (fraction, _) = fractions(points);
    let first = smoothed(points, &fraction);
    let (even, evidence) = even_folds(points).unzip();
    let evidence = evidence.unwrap_or_default();
    let better = even.as_ref().is_some_and(|even| even.criterion < first.criterion);
    // Nobody but even folds knows what a missing piece looked like.
    if let Some(even) = even.filter(|_| better || incomplete(&fraction)) {
        let parameter = ascending(&even.parameter);
        let fine: Vec<Point> = (0..4 * SAMPLES).map(|j| even.point(parameter[0] + j as f64 / (4 * SAMPLES) as f64)).collect();
        let (along, length) = fractions(&fine);
        let places = parameter.iter().map(|u| place(&along, (u - parameter[0]).min(1.0 - f64::EPSILON))).collect();
        let order = 1 + 2 * even.folds as usize;
        let smooth = Smooth { samples: resample(&fine, &along), length, order, noise: even.noise, criterion: even.criterion };
        return smooth.outline(places, evidence, better);
    }
    let disturbed = DISTURBING_NOISE * first.length / n as f64;
    let mut smooth = first;
    // Twice: the second time the parameter is right to the noise over the spacing squared.
    for _ in 0..2 {
        if smooth.noise <= disturbed {
            break;
        }
        let (sorted, places) = along(points, &fraction, &smooth.samples);
        smooth = smoothed(&sorted, &places);
    }
    // What noise the series keeps is roughness of its own: its mean squared slope, half of which is length too much.
    let roughness = (TAU / smooth.length).powi(2) * smooth.noise * smooth.noise * 2.0 * (smooth.order as f64).powi(3) / 3.0 / n as f64;
    smooth.length *= 1.0 - 0.5 * roughness.min(0.5);
    smooth.outline(fraction, evidence, false)
}

/// The same turn, run through in the order of the points: they come in order, whatever noise says of one of them.
fn ascending(turn: &[f64]) -> Vec<f64> {
    let n = turn.len() as f64;
    let shifts = turn.iter().enumerate().map(|(i, u)| (TAU * (u - i as f64 / n)).sin_cos());
    let (sin, cos) = shifts.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let shift = sin.atan2(cos) / TAU;
    let mut unwrapped: Vec<f64> = turn.iter().enumerate().map(|(i, u)| u - (u - i as f64 / n - shift).round()).collect();
    unwrapped.sort_by(f64::total_cmp);
    unwrapped
}

/// Whether a piece of the outline is missing: between two points lies far more than between most, and more than a fold of twelve.
fn incomplete(fraction: &[f64]) -> bool {
    let n = fraction.len();
    let gap = (0..n).map(|i| if i + 1 < n { fraction[i + 1] } else { 1.0 } - fraction[i]).fold(0.0, f64::max);
    MISSING < gap && 8.0 < gap * n as f64
}

/// Fraction of the length at parameter `u`, where `along` are the fractions at equal steps of it.
fn place(along: &[f64], u: f64) -> f64 {
    let scaled = u * along.len() as f64;
    let i = (scaled as usize).min(along.len() - 1);
    let next = along.get(i + 1).copied().unwrap_or(1.0);
    along[i] + (scaled - i as f64) * (next - along[i])
}

/// A smooth curve by evidence.
struct Smooth {
    samples: Vec<Point>,
    length: f64,
    order: usize,
    noise: f64,
    /// Akaike's criterion over both coordinates of all points.
    criterion: f64,
}

impl Smooth {
    fn outline(self, places: Vec<f64>, evidence: Vec<even::Evidence>, even: bool) -> Outline {
        let Smooth { samples, length, order, noise, .. } = self;
        let (cx, cy) = centroid(&samples);
        let radius = (samples.iter().map(|p| (p.x - cx).powi(2) + (p.y - cy).powi(2)).sum::<f64>() / SAMPLES as f64).sqrt();
        // Every second sample: crossings of folds, not of noise.
        let every_second: Vec<Point> = samples.iter().copied().step_by(2).collect();
        let crossings = crossings(&every_second);
        Outline { samples, length, order, noise, radius, crossings, places, evidence, even }
    }
}

/// The smooth curve through points at the fractions given.
fn smoothed(points: &[Point], fraction: &[f64]) -> Smooth {
    let highest = HIGHEST_ORDER.min(points.len() / 4).max(1);
    let series = Series::of(&resample(points, fraction), highest, effective_spacing(fraction));
    let (order, noise, criterion) = order_by_evidence(&series, points, fraction);
    let fine = series.samples(4 * SAMPLES, order);
    let (along, length) = fractions(&fine);
    Smooth { samples: resample(&fine, &along), length, order, noise, criterion }
}

/// Each point's place along the smooth curve near its old fraction; points and places in ascending order of place.
fn along(points: &[Point], fraction: &[f64], samples: &[Point]) -> (Vec<Point>, Vec<f64>) {
    let n = samples.len() as i64;
    // A twentieth of the outline each way: half a fold of ten.
    let window = n / 20;
    let mut placed: Vec<(f64, Point)> = points
        .iter()
        .zip(fraction)
        .map(|(point, f)| {
            let middle = (f * n as f64) as i64;
            let at = |j: i64| samples[j.rem_euclid(n) as usize];
            let nearest = (middle - window..=middle + window).min_by(|a, b| point.distance(at(*a)).total_cmp(&point.distance(at(*b))));
            let j = nearest.unwrap_or(middle);
            // Between the neighbours of the nearest sample.
            let (before, after) = (at(j - 1), at(j + 1));
            let (ex, ey) = (after.x - before.x, after.y - before.y);
            let share = ((point.x - before.x) * ex + (point.y - before.y) * ey) / (ex * ex + ey * ey).max(f64::MIN_POSITIVE);
            (((j as f64 - 1.0 + 2.0 * share.clamp(0.0, 1.0)) / n as f64).rem_euclid(1.0), *point)
        })
        .collect();
    placed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let first = placed[0].0;
    (placed.iter().map(|p| p.1).collect(), placed.iter().map(|p| p.0 - first).collect())
}

/// Fraction of a closed polygon's length at which each corner lies, from 0; and the length, m.
pub fn fractions(points: &[Point]) -> (Vec<f64>, f64) {
    let mut fractions = Vec::with_capacity(points.len());
    let mut length = 0.0;
    for (i, point) in points.iter().enumerate() {
        fractions.push(length);
        length += point.distance(points[(i + 1) % points.len()]);
    }
    fractions.iter_mut().for_each(|f| *f /= length);
    (fractions, length)
}

/// Mean of points at equal steps of length, m.
pub fn centroid(samples: &[Point]) -> (f64, f64) {
    let n = samples.len() as f64;
    (samples.iter().map(|p| p.x).sum::<f64>() / n, samples.iter().map(|p| p.y).sum::<f64>() / n)
}

/// How often a closed polygon crosses itself.
pub fn crossings(points: &[Point]) -> usize {
    Polygon::new(points).crossings_of(points.len())
}

/// Whether the hem curve crosses itself more than so often; a crossing of two folds is counted from both.
pub fn crosses_more_than(hem: &Hem, crossings: usize) -> bool {
    let winds_once = hem.q.abs() < hem.p;
    let Bends { overhangs, lean } = bends(hem, bend_angles());
    // One radius for each polar angle: nothing to cross.
    if winds_once && !overhangs {
        return false;
    }
    // A crossing smaller than a hundredth of a fold is not seen.
    const NODES: usize = 128;
    let folds = hem.folds.max(1) as usize;
    // All folds are alike: the sides of one are held against all. A hem of few folds gets the nodes of six.
    let nodes = NODES * 6_usize.div_ceil(folds);
    let n = nodes * folds;
    let corners = points_at(hem, &Placement::ORIGIN, (0..n).map(|i| TAU * i as f64 / n as f64));
    // Where the curve winds once round its centre, points that meet lean over by as much as they are apart; a little more, because the lean is known
    // at some places only.
    let reach = if winds_once { (2.2 * lean.atan() / TAU * n as f64) as usize + nodes / 8 } else { n };
    crossings / folds < Polygon::new(&corners).crossings_within(nodes, reach, crossings / folds + 1)
}

/// What one fold shows of where its curve may meet another's.
struct Bends {
    /// Whether there are several radii for one polar angle, as [`Hem::overhangs`] says.
    overhangs: bool,
    /// The largest |τ|/ρ.
    lean: f64,
}

/// Places of one fold that are looked at.
const BENDS: usize = 256;

/// (cos, sin) of the fold's angle at equal steps of it.
fn bend_angles() -> &'static [[Lanes; 2]] {
    static ANGLES: OnceLock<Vec<[Lanes; 2]>> = OnceLock::new();
    ANGLES.get_or_init(|| {
        let angles = in_eights((0..BENDS).map(|i| TAU * i as f64 / BENDS as f64), 0.0);
        angles.iter().map(|eight| [Lanes(eight.0.map(f64::cos)), Lanes(eight.0.map(f64::sin))]).collect()
    })
}

vectorized! {
    fn bends<V>(hem: &Hem, angles: &[[Lanes; 2]]) -> Bends {
        let m = f64::from(hem.folds);
        let (mut least, mut lean) = (V::all(-f64::INFINITY), V::zero());
        for [cos, sin] in angles {
            let (cos, sin) = (V::of(cos), V::of(sin));
            let (sin_lean, cos_lean) = (sin * cos * 2.0, V::all(1.0) - sin * sin * 2.0);
            let (rho, tau) = (cos * hem.q + hem.p, sin_lean * hem.s);
            let (radial, tangential) = (sin * (-hem.q * m) - tau, rho + cos_lean * (2.0 * m * hem.s));
            least = (tau * radial - rho * tangential).max(least);
            lean = (tau.abs() / rho.abs()).max(lean);
        }
        Bends { overhangs: 0.0 < least.greatest(), lean: lean.greatest() }
    }
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

/// The spacing of even corners that would flatten the harmonics as these do: √Σh³ of the sides h.
fn effective_spacing(fraction: &[f64]) -> f64 {
    let n = fraction.len();
    (0..n).map(|i| (if i + 1 < n { fraction[i + 1] } else { 1.0 } - fraction[i]).powi(3)).sum::<f64>().sqrt()
}

/// Complex Fourier coefficients of a closed curve: `z(f) = Σ c_k e^{2πi k f}`, |k| ≤ order.
struct Series {
    /// c_0, then (c_k, c_−k) for k = 1, 2, …; each (re, im).
    centre: (f64, f64),
    pairs: Vec<[(f64, f64); 2]>,
}

impl Series {
    /// The series of a polygon whose corners are `spacing` apart (as a fraction of the whole).
    ///
    /// Straight sides flatten the harmonic k by sinc²(k·spacing); that is undone.
    fn of(samples: &[Point], order: usize, spacing: f64) -> Series {
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
    fn samples(&self, n: usize, order: usize) -> Vec<Point> {
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
fn order_by_evidence(series: &Series, points: &[Point], fraction: &[f64]) -> (usize, f64, f64) {
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

#[cfg(test)]
mod tests {
    use super::*;

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
    fn a_hem_crosses_itself_as_often_as_all_its_sides_cross_one_another() {
        let mut seen = [false; 2];
        for (folds, q) in [(2, 0.3), (3, 0.05), (6, 0.05), (7, 0.01), (12, 0.04), (24, 0.1), (9, 0.16)] {
            for share in 0..12 {
                let hem = Hem { p: 0.15, q, s: 0.012 * f64::from(share), folds };
                let nodes = 128 * 6_usize.div_ceil(folds as usize);
                let corners = hem.outline(&Placement::ORIGIN, nodes * folds as usize);
                let count = Polygon::new(&corners).crossings_of(nodes) * folds as usize;
                let count = if hem.q < hem.p && !hem.overhangs() { 0 } else { count };
                for limit in [0, 1, 5, 12, 100, count.saturating_sub(1), count, count + 1] {
                    assert_eq!(crosses_more_than(&hem, limit), limit < count, "{hem:?}: {count}, {limit}");
                    seen[usize::from(limit < count)] = true;
                }
            }
        }
        assert_eq!(seen, [true; 2]);
    }

    #[test]
    fn a_figure_of_eight_crosses_itself_once() {
        let points: Vec<Point> =
            (0..200).map(|i| f64::from(i) * TAU / 200.0 + 0.01).map(|t| Point::new(t.cos(), (2.0 * t).sin())).collect();
        assert_eq!(crossings(&points), 1);
    }
}
