//! Where a fit begins, and which fold counts deserve one: the harmonics of the outline's radius by polar angle.
//!
//! To second order in lean and amplitude the hem curve seen in polar coordinates has the harmonics 0, m and 3m only:
//! r(θ) = p + (q + mqs/2p) cos mθ − (mqs/2p) cos 3mθ, from θ = t + (s/p) sin 2mt and r = p + q cos mt. Even multiples are of higher order.

use super::kernel::{Blocks, Curve};
use crate::experiment::Point;
use crate::model::hem::Hem;
use crate::numerics::lanes::{WIDTH, multiple_angle, turned};
use crate::vectorized;

/// Least ratio of the mean square of the harmonic 3m to what it and the first leave for it to be believed.
const STANDS_OUT: f64 = 0.1;

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

    /// The same with one harmonic only: that of `folds`.
    pub(super) fn of_folds(all: &Blocks, folds: u32) -> Spectrum {
        let Turned { mean, variance, first, .. } = harmonics_of(all, folds);
        let mut amplitudes = vec![(0.0, 0.0); folds as usize];
        amplitudes[folds as usize - 1] = first;
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

    /// The curve that has the harmonic m of the outline, without lean.
    pub(super) fn upright(&self, folds: u32) -> Curve {
        let first = self.amplitude(folds);
        curve(self.mean, first, folds, first.0.hypot(first.1), 0.0)
    }
}

/// The curve that has the harmonics m and 3m of the outline; `None` where the second does not stand out of what is left.
///
/// With E = mt and β = ms/p the angle is mθ = E + β sin 2E and the radius p + q cos E, so the harmonics of the radius are, by Bessel's integrals,
/// q (J₀(β) + J₁(β)) and −⅓ q (J₁(3β) + J₂(3β)), overhanging or not.
pub(super) fn leaning(all: &Blocks, folds: u32) -> Option<Curve> {
    /// Where the second of them is greatest in size, either way.
    const MOST: (f64, f64) = (-0.5, 0.62);
    let Turned { mean, variance, first, third } = harmonics_of(all, folds);
    let amplitude = first.0.hypot(first.1);
    let (sin, cos) = (3.0 * first.1.atan2(first.0)).sin_cos();
    let third = third.0 * cos + third.1 * sin;
    let left = variance - 0.5 * (amplitude * amplitude + third * third);
    if 0.5 * third * third < STANDS_OUT * left {
        return None;
    }
    let harmonics = |beta: f64| {
        let ([j0, j1, _], [_, k1, k2]) = (bessel(beta), bessel(3.0 * beta));
        (j0 + j1, -(k1 + k2) / 3.0)
    };
    let (mut low, mut high) = MOST;
    for _ in 0..10 {
        let beta = 0.5 * (low + high);
        let (one, three) = harmonics(beta);
        if three * amplitude < third * one {
            high = beta;
        } else {
            low = beta;
        }
    }
    let beta = 0.5 * (low + high);
    Some(curve(mean, first, folds, amplitude / harmonics(beta).0, beta * mean / f64::from(folds)))
}

/// J₀, J₁ and J₂ for |x| ≤ 2, to 1e-6.
fn bessel(x: f64) -> [f64; 3] {
    let (half, z) = (0.5 * x, 0.25 * x * x);
    let series = |n: f64| {
        let term = |k: f64, rest: f64| 1.0 - z / (k * (k + n)) * rest;
        term(1.0, term(2.0, term(3.0, term(4.0, term(5.0, 1.0)))))
    };
    [series(0.0), half * series(1.0), 0.5 * half * half * series(2.0)]
}

fn curve(mean: f64, first: (f64, f64), folds: u32, q: f64, s: f64) -> Curve {
    let (sin, cos) = (first.1.atan2(first.0) / f64::from(folds)).sin_cos();
    Curve { x0: 0.0, y0: 0.0, cos, sin, hem: Hem { p: mean, q, s, folds } }
}

vectorized! {
    /// Mean radius, its mean square departure, and the amplitudes of harmonics 1 … `highest`.
    fn harmonics<V>(all: &Blocks, highest: u32) -> (f64, f64, Vec<(f64, f64)>) {
        let n = all.count as f64;
        let mut mean = V::zero();
        for (index, block) in all.blocks.iter().enumerate() {
            let (x, y) = (V::of(&block.x), V::of(&block.y));
            mean = V::of(&all.live(index)).mul_add(x.mul_add(x, y * y).sqrt(), mean);
        }
        let mean = mean.sum() / n;
        let mut square = V::zero();
        let mut sums = vec![(V::zero(), V::zero()); highest as usize];
        for (index, block) in all.blocks.iter().enumerate() {
            let (x, y) = (V::of(&block.x), V::of(&block.y));
            let radius = x.mul_add(x, y * y).sqrt();
            let departure = V::of(&all.live(index)) * (radius - mean);
            square = departure.mul_add(departure, square);
            let inverse = V::all(1.0) / radius;
            let unit = (x * inverse, y * inverse);
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

/// Harmonics of the radius as a function of the angle, by the angle that the outline turns through from point to point, to and fro.
#[derive(Default)]
struct Turned {
    /// Mean radius, m.
    mean: f64,
    /// Mean square departure from it, m².
    variance: f64,
    /// Amplitudes (cos, sin) of the harmonics m and 3m.
    first: (f64, f64),
    third: (f64, f64),
}

vectorized! {
    fn harmonics_of<V>(all: &Blocks, folds: u32) -> Turned {
        let (mut turn, mut mean, mut square) = (V::zero(), V::zero(), V::zero());
        let mut sums = [V::zero(); 4];
        let mut bare = [V::zero(); 4];
        let blocks = &all.blocks;
        // Lanes beyond the last point hold the first one again.
        let (head, rear, end) = (&blocks[0], &blocks[blocks.len() - 1], (all.count - 1) % WIDTH);
        let mut before = (V::all(rear.x.0[end]), V::all(rear.y.0[end]));
        for (index, block) in blocks.iter().enumerate() {
            let next = blocks.get(index + 1).unwrap_or(head);
            let (x, y) = (V::of(&block.x), V::of(&block.y));
            let chord = (x.followed(V::of(&next.x)) - x.preceded(before.0), y.followed(V::of(&next.y)) - y.preceded(before.1));
            before = (x, y);
            let squared = x.mul_add(x, y * y);
            let radius = squared.sqrt();
            let inverse = V::all(1.0) / radius;
            let weight = V::of(&all.live(index)) * (x.mul_sub(chord.1, y * chord.0) * (inverse * inverse));
            let first = multiple_angle(folds, (x * inverse, y * inverse));
            let third = turned(turned(first, first), first);
            let heavy = weight * radius;
            turn = turn + weight;
            mean = mean + heavy;
            square = weight.mul_add(squared, square);
            let waves = [first.0, first.1, third.0, third.1];
            for k in 0..4 {
                sums[k] = heavy.mul_add(waves[k], sums[k]);
                bare[k] = weight.mul_add(waves[k], bare[k]);
            }
        }
        let turn = turn.sum();
        let mean = mean.sum() / turn;
        let mut amplitudes = [0.0; 4];
        for k in 0..4 {
            amplitudes[k] = 2.0 * (sums[k].sum() - mean * bare[k].sum()) / turn;
        }
        let [a, b, c, d] = amplitudes;
        Turned { mean, variance: square.sum() / turn - mean * mean, first: (a, b), third: (c, d) }
    }
}
