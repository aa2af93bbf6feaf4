//! Where a fit begins, and which fold counts deserve one: the harmonics of the outline's radius by polar angle.
//!
//! To second order in lean and amplitude the hem curve seen in polar coordinates has the harmonics 0, m and 3m only:
//! r(θ) = p + (q + mqs/2p) cos mθ − (mqs/2p) cos 3mθ, from θ = t + (s/p) sin 2mt and r = p + q cos mt. Even multiples are of higher order.

use super::kernel::{Blocks, Curve};
use crate::experiment::Point;
use crate::model::hem::Hem;
use crate::numerics::lanes::{Lanes, multiple_angle, turned};
use crate::vectorized;

/// Harmonics of the radius about the blocks' origin, which is the centroid.
pub(super) struct Spectrum {
    /// Mean radius, m.
    mean: f64,
    /// Mean square departure from it, m².
    variance: f64,
    /// Amplitudes (cos, sin) of harmonics 1, 2, …, m.
    amplitudes: Vec<(f64, f64)>,
}

/// Centroid of the area inside a closed outline; `None` if that hardly encloses any.
pub(super) fn centroid(points: &[Point]) -> Option<Point> {
    let o = points[0];
    let (mut area, mut cx, mut cy) = (0.0, 0.0, 0.0);
    let mut last = (0.0, 0.0);
    let mut reach: f64 = 0.0;
    for point in &points[1..] {
        let (x, y) = (point.x - o.x, point.y - o.y);
        let cross = last.0 * y - x * last.1;
        area += cross;
        cx += (last.0 + x) * cross;
        cy += (last.1 + y) * cross;
        reach = reach.max(x * x + y * y);
        last = (x, y);
    }
    (1e-3 * reach < area).then(|| Point::new(o.x + cx / (3.0 * area), o.y + cy / (3.0 * area)))
}

impl Spectrum {
    /// Harmonics up to `highest` of the radius about the origin of the blocks, which is their centroid.
    pub(super) fn new(all: &Blocks, highest: u32) -> Spectrum {
        let (mean, variance, amplitudes) = harmonics(all, highest);
        Spectrum { mean, variance, amplitudes }
    }

    /// The same with two harmonics only: those of `folds`.
    pub(super) fn of_folds(all: &Blocks, folds: u32) -> Spectrum {
        let (mean, variance, [first, third]) = harmonics_of(all, folds);
        let mut amplitudes = vec![(0.0, 0.0); 3 * folds as usize];
        amplitudes[folds as usize - 1] = first;
        amplitudes[3 * folds as usize - 1] = third;
        Spectrum { mean, variance, amplitudes }
    }

    fn amplitude(&self, harmonic: u32) -> (f64, f64) {
        self.amplitudes.get(harmonic as usize - 1).copied().unwrap_or((0.0, 0.0))
    }

    /// Root mean square radius that `folds` folds leave, m: about the distance that a fit of them can reach.
    pub(super) fn left_by(&self, folds: u32) -> f64 {
        let explained: f64 = [folds, 3 * folds].map(|k| self.amplitude(k)).iter().map(|a| 0.5 * (a.0 * a.0 + a.1 * a.1)).sum();
        (self.variance - explained).max(0.0).sqrt()
    }

    /// The curve that has the harmonic m of the outline, with a lean by the third multiple if `lean`.
    pub(super) fn curve(&self, folds: u32, lean: bool) -> Curve {
        let m = f64::from(folds);
        let (re, im) = self.amplitude(folds);
        let amplitude = re.hypot(im);
        let phase = im.atan2(re) / m;
        let (sin, cos) = phase.sin_cos();
        let (mut q, mut s) = (amplitude, 0.0);
        if lean {
            let (re, im) = self.amplitude(3 * folds);
            let (sin, cos) = (3.0 * m * phase).sin_cos();
            let third = re * cos + im * sin;
            // What the lean adds to the first harmonic it takes from the third.
            if 0.3 * amplitude < amplitude + third {
                q = amplitude + third;
                s = (-2.0 * self.mean * third / (m * q)).clamp(-0.15 * self.mean, 0.15 * self.mean);
            }
        }
        Curve { x0: 0.0, y0: 0.0, cos, sin, hem: Hem { p: self.mean, q, s, folds } }
    }
}

vectorized! {
    /// Mean radius, its mean square departure, and the amplitudes of harmonics 1 … `highest`.
    fn harmonics(all: &Blocks, highest: u32) -> (f64, f64, Vec<(f64, f64)>) {
        let n = all.count as f64;
        let mut mean = Lanes::ZERO;
        for (index, block) in all.blocks.iter().enumerate() {
            mean = mean + all.live(index) * (block.x * block.x + block.y * block.y).sqrt();
        }
        let mean = mean.sum() / n;
        let mut square = Lanes::ZERO;
        let mut sums = vec![(Lanes::ZERO, Lanes::ZERO); highest as usize];
        for (index, block) in all.blocks.iter().enumerate() {
            let radius = (block.x * block.x + block.y * block.y).sqrt();
            let departure = all.live(index) * (radius - mean);
            square = square + departure * departure;
            let inverse = 1.0 / radius;
            let unit = (block.x * inverse, block.y * inverse);
            let mut power = (departure * unit.0, departure * unit.1);
            for sum in &mut sums {
                (sum.0, sum.1) = (sum.0 + power.0, sum.1 + power.1);
                power = turned(power, unit);
            }
        }
        let amplitudes = sums.into_iter().map(|(re, im)| (2.0 * re.sum() / n, 2.0 * im.sum() / n)).collect();
        (mean, square.sum() / n, amplitudes)
    }
}

vectorized! {
    /// Mean radius, its mean square departure, and the amplitudes of harmonics `folds` and 3 `folds`.
    fn harmonics_of(all: &Blocks, folds: u32) -> (f64, f64, [(f64, f64); 2]) {
        let n = all.count as f64;
        let mut mean = Lanes::ZERO;
        let mut square = Lanes::ZERO;
        let mut sums = [(Lanes::ZERO, Lanes::ZERO); 2];
        let mut bare = [(Lanes::ZERO, Lanes::ZERO); 2];
        for (index, block) in all.blocks.iter().enumerate() {
            let live = all.live(index);
            let squared = block.x * block.x + block.y * block.y;
            let radius = squared.sqrt();
            let inverse = 1.0 / radius;
            mean = mean + live * radius;
            square = square + live * squared;
            let first = multiple_angle(folds, (block.x * inverse, block.y * inverse));
            let third = turned(turned(first, first), first);
            for (k, (cos, sin)) in [first, third].into_iter().enumerate() {
                sums[k] = (sums[k].0 + live * (radius * cos), sums[k].1 + live * (radius * sin));
                bare[k] = (bare[k].0 + live * cos, bare[k].1 + live * sin);
            }
        }
        let mean = mean.sum() / n;
        let amplitude = |k: usize| {
            // Points that are not even in angle: the mean radius has a share of its own in the sums.
            let (re, im) = (sums[k].0.sum() - mean * bare[k].0.sum(), sums[k].1.sum() - mean * bare[k].1.sum());
            (2.0 * re / n, 2.0 * im / n)
        };
        (mean, square.sum() / n - mean * mean, [amplitude(0), amplitude(1)])
    }
}
