//! The outline behind the points: a Fourier series in its own arc length, of an order chosen by evidence, or the lines of even folds where
//! they describe the points better.
//!
//! Noise lengthens a polygon (it zigzags), so length, self-crossings and starting values are taken from this smooth curve instead.

use std::f64::consts::TAU;

use super::crossings::crossings;
use super::even::{self, even_folds};
use super::series::{Series, order_by_evidence};
use crate::experiment::{DrapeProfile, Point};

/// Samples of the polygon, and of the smooth curve: 1024 resolve 60 folds with 17 samples each.
const SAMPLES: usize = 1024;
/// Highest order tried: deep folds need about eight harmonics, 24 of them 192.
const HIGHEST_ORDER: usize = 192;
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
}
