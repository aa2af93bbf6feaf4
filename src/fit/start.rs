//! First guess of a fit: the outline matched to the curve by equal fractions of arc length.
//!
//! Matching by length walks once round both curves in order, so it cannot fall for a curve that fills space; given the match, the problem
//! is linear in the centre, p, q and s.

use std::f64::consts::TAU;

use std::sync::OnceLock;

use nalgebra::{SMatrix, SVector};

use super::eight_places::{Places, in_eights};
use super::outline::{Outline, centroid};
use crate::model::hem::{Hem, Placement};
use crate::numerics::lanes::{Lanes, WIDTH};
use crate::vectorized;

/// A matched curve.
#[derive(Debug, Clone)]
pub struct Start {
    pub hem: Hem,
    pub placement: Placement,
    /// Fraction of the outline's length at which the curve's crest `t = 0` lies.
    pub offset: f64,
    /// Root mean square distance between matched points, m: an upper bound of what an orthogonal fit reaches.
    pub rms: f64,
}

/// Nodes a fold of the length table; the match is a start, so 1e-3 of a fold is ample.
const TABLE: usize = 64;
/// Rounds of matching and solving; the change after eight is far below what the orthogonal fit then moves.
const ROUNDS: usize = 8;

/// Parameter of the curve as a function of the fraction of its length.
pub struct LengthTable {
    folds: f64,
    /// Fraction of one fold's length at equal steps of t, 0 … 1.
    fraction: [f64; TABLE + 1],
}

impl LengthTable {
    pub fn of(hem: &Hem) -> LengthTable {
        let folds = f64::from(hem.folds.max(1));
        let mut speeds = [Lanes::ZERO; TABLE / WIDTH];
        speeds_of_a_fold(hem, fold_angles(), &mut speeds);
        let speed = |i: usize| speeds[i % TABLE / WIDTH].0[i % WIDTH];
        let mut fraction = [0.0; TABLE + 1];
        for i in 1..=TABLE {
            fraction[i] = fraction[i - 1] + 0.5 * (speed(i - 1) + speed(i));
        }
        let whole = fraction[TABLE];
        fraction.iter_mut().for_each(|f| *f /= whole);
        LengthTable { folds, fraction }
    }

    /// Fraction of the whole length at parameter `t` (any real number; one turn is 1).
    pub fn fraction(&self, t: f64) -> f64 {
        let scaled = t * self.folds / TAU;
        let fold = scaled.floor();
        let within = (scaled - fold) * TABLE as f64;
        let i = (within as usize).min(TABLE - 1);
        let share = within - i as f64;
        (fold + self.fraction[i] + share * (self.fraction[i + 1] - self.fraction[i])) / self.folds
    }

    /// t at fraction `f` of the whole length (any real number; 1 is one turn).
    pub fn parameter(&self, f: f64) -> f64 {
        self.parameter_near(f, &mut 1)
    }

    /// The same at many fractions, fast where they ascend.
    pub fn parameters(&self, fractions: impl ExactSizeIterator<Item = f64>) -> impl ExactSizeIterator<Item = f64> {
        let mut near = 1;
        fractions.map(move |f| self.parameter_near(f, &mut near))
    }

    /// The same, looked for from the entry `near` of the table on, which is moved to where it was found.
    fn parameter_near(&self, f: f64, near: &mut usize) -> f64 {
        let scaled = f * self.folds;
        // Rounded down by hand: the system's function costs as much as all else here.
        let towards_zero = scaled as i64 as f64;
        let fold = if scaled < towards_zero { towards_zero - 1.0 } else { towards_zero };
        let within = scaled - fold;
        if within < self.fraction[*near - 1] {
            *near = 1;
        }
        while *near < TABLE && self.fraction[*near] <= within {
            *near += 1;
        }
        let i = *near;
        let (low, high) = (self.fraction[i - 1], self.fraction[i]);
        let share = if low < high { (within - low) / (high - low) } else { 0.0 };
        TAU / self.folds * (fold + ((i - 1) as f64 + share) / TABLE as f64)
    }
}

/// Cosine and sine of the fold's own angle at equal steps of it.
fn fold_angles() -> &'static [[Lanes; 2]; TABLE / WIDTH] {
    static ANGLES: OnceLock<[[Lanes; 2]; TABLE / WIDTH]> = OnceLock::new();
    ANGLES.get_or_init(|| {
        let angle = |block: usize, lane: usize| TAU * (WIDTH * block + lane) as f64 / TABLE as f64;
        std::array::from_fn(|b| {
            [Lanes(std::array::from_fn(|lane| angle(b, lane).cos())), Lanes(std::array::from_fn(|lane| angle(b, lane).sin()))]
        })
    })
}

vectorized! {
    fn speeds_of_a_fold<V>(hem: &Hem, angles: &[[Lanes; 2]; TABLE / WIDTH], speeds: &mut [Lanes; TABLE / WIDTH]) -> () {
        let m = f64::from(hem.folds);
        for ([cos, sin], speed) in angles.iter().zip(speeds) {
            let (cos, sin) = (V::of(cos), V::of(sin));
            let cos_lean = V::all(1.0) - sin * sin * 2.0;
            let radial = sin * (hem.q * m) + sin * cos * (2.0 * hem.s);
            let tangential = cos * hem.q + hem.p + cos_lean * (2.0 * m * hem.s);
            *speed = (radial * radial + tangential * tangential).sqrt().lanes();
        }
    }
}

/// The best match of a curve with `folds` folds.
pub fn matched(outline: &Outline, folds: u32) -> Start {
    Radii::of(outline).matched(folds)
}

/// An outline's distances from its centroid, from which every fold count is matched.
pub struct Radii<'a> {
    outline: &'a Outline,
    centre: (f64, f64),
    /// At equal steps of length, m.
    radii: Vec<f64>,
    mean: f64,
    /// (sin, cos) of the whole turn at as many equal steps.
    turn: Vec<(f64, f64)>,
}

impl<'a> Radii<'a> {
    pub fn of(outline: &'a Outline) -> Self {
        let n = outline.samples.len();
        let (cx, cy) = centroid(&outline.samples);
        let radii: Vec<f64> = outline.samples.iter().map(|point| (point.x - cx).hypot(point.y - cy)).collect();
        let mean = radii.iter().sum::<f64>() / n as f64;
        let turn = (0..n).map(|j| (TAU * j as f64 / n as f64).sin_cos()).collect();
        Radii { outline, centre: (cx, cy), radii, mean, turn }
    }

    /// The best match of a curve with `folds` folds.
    pub fn matched(&self, folds: u32) -> Start {
        let (n, m, mean) = (self.radii.len(), f64::from(folds), self.mean);
        // The m-th harmonic of the radius along the length: its phase is exact for folds that are mirror images of themselves.
        let (mut re, mut im) = (0.0, 0.0);
        for (j, radius) in self.radii.iter().enumerate() {
            let (sin, cos) = self.turn[j * folds as usize % n];
            re += radius * cos;
            im += radius * sin;
        }
        let amplitude = 2.0 * re.hypot(im) / n as f64;
        let crest = im.atan2(re) / (TAU * m);
        let samples = Samples::of(self.outline, folds);
        // Folds of unequal depth can hide the true crest from that harmonic: a quarter of a fold further is tried as well.
        let from = |quarter: f64, lean: f64| self.refine(&samples, Hem { p: mean, q: amplitude, s: lean, folds }, crest + quarter / m);
        let mut best = nearer(from(0.0, 0.0), from(0.25, 0.0));
        // Even folds can be matched to the noise. Where they are not, they lean so much that a straight fold does not lead there.
        if self.outline.even && self.outline.noise < best.rms {
            for lean in [0.5 * mean / m, mean / m] {
                best = [(0.0, lean), (0.25, lean), (0.0, -lean), (0.25, -lean)]
                    .into_iter()
                    .fold(best, |best, (q, s)| nearer(best, from(q, s)));
            }
        }
        best
    }

    /// Matches and solves in turn from `hem`, its crest at the fraction `crest` of the outline's length.
    fn refine(&self, samples: &Samples, mut hem: Hem, crest: f64) -> Start {
        let all = &self.outline.samples;
        let (cx, cy) = self.centre;
        let mut offset = crest;
        // On a circle the direction of the crest from the centroid is the phase.
        let first = all[((offset.rem_euclid(1.0) * all.len() as f64) as usize).min(all.len() - 1)];
        let mut placement = Placement { x0: cx, y0: cy, phase: (first.y - cy).atan2(first.x - cx) };
        let mut best = Start { hem, placement, offset, rms: f64::INFINITY };
        for _ in 0..ROUNDS {
            let table = LengthTable::of(&hem);
            let parameters = in_eights(table.parameters(samples.places.iter().map(|f| f - offset)), 0.0);
            let Sums { mut normal, right, square } = sums(&hem, &placement, self.outline.length, samples, &parameters);
            let rms = (square / samples.places.len() as f64).sqrt();
            if rms < best.rms {
                best = Start { hem, placement, offset, rms };
            }
            // On a circle sliding and turning are the same: a little damping settles which of them moves.
            for i in 0..7 {
                normal[(i, i)] *= 1.0 + 1e-3;
                normal[(i, i)] += f64::MIN_POSITIVE;
            }
            let Some(step) = normal.cholesky().map(|c| c.solve(&right)) else { break };
            if step.iter().any(|s| !s.is_finite()) {
                break;
            }
            let folds = f64::from(hem.folds);
            placement.x0 += step[0];
            placement.y0 += step[1];
            placement.phase += step[2].clamp(-0.5 / folds, 0.5 / folds);
            hem.p += step[3];
            hem.q += step[4];
            hem.s += step[5];
            offset += step[6].clamp(-0.1 / folds, 0.1 / folds);
        }
        best
    }
}

fn nearer(a: Start, b: Start) -> Start {
    if b.rms < a.rms { b } else { a }
}

/// Some samples of an outline, at equal steps of its length.
struct Samples {
    /// Fraction of the length at which each lies.
    places: Vec<f64>,
    x: Vec<Lanes>,
    y: Vec<Lanes>,
    /// 1; 0 where there are no more.
    weight: Vec<Lanes>,
}

impl Samples {
    /// Sixteen samples a fold are enough for a start.
    fn of(outline: &Outline, folds: u32) -> Self {
        let all = &outline.samples;
        let stride = (all.len() / (16 * folds as usize).max(128)).max(1);
        let some = || all.iter().step_by(stride);
        let places: Vec<f64> = (0..all.len()).step_by(stride).map(|j| j as f64 / all.len() as f64).collect();
        let weight = in_eights(places.iter().map(|_| 1.0), 0.0);
        Samples { x: in_eights(some().map(|p| p.x), 0.0), y: in_eights(some().map(|p| p.y), 0.0), weight, places }
    }
}

/// Normal equations in x0, y0, phase, p, q, s and a slide of the match by a fraction of the length; and the sum of squares.
struct Sums {
    normal: SMatrix<f64, 7, 7>,
    right: SVector<f64, 7>,
    square: f64,
}

vectorized! {
    fn sums<V>(hem: &Hem, placement: &Placement, length: f64, samples: &Samples, parameters: &[Lanes]) -> Sums {
        let mut normal = [[V::zero(); 7]; 7];
        let mut right = [V::zero(); 7];
        let mut square = V::zero();
        for (i, t) in parameters.iter().enumerate() {
            let places = Places::at(hem, placement, V::of(t));
            let weight = V::of(&samples.weight[i]);
            let [x, y] = places.point(placement);
            let (ex, ey) = ((V::of(&samples.x[i]) - x) * weight, (V::of(&samples.y[i]) - y) * weight);
            square = square + (ex * ex + ey * ey);
            // Sliding the match by a fraction of the length moves the matched point backwards along the curve.
            let slide = V::all(-length) / places.speed().max(V::all(f64::MIN_POSITIVE));
            let [vx, vy] = places.velocity();
            let [x0, y0, phase, p, q, s] = places.moved();
            let columns = [x0, y0, phase, p, q, s, [slide * vx, slide * vy]];
            for a in 0..7 {
                let (by_x, by_y) = (columns[a][0] * weight, columns[a][1] * weight);
                right[a] = by_x.mul_add(ex, by_y.mul_add(ey, right[a]));
                for b in 0..=a {
                    normal[a][b] = by_x.mul_add(columns[b][0], by_y.mul_add(columns[b][1], normal[a][b]));
                }
            }
        }
        Sums {
            normal: SMatrix::from_fn(|a, b| normal[a.max(b)][a.min(b)].sum()),
            right: SVector::from_fn(|a, _| right[a].sum()),
            square: square.sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ascending_fractions_are_found_as_any_others_are() {
        let table = LengthTable::of(&Hem { p: 0.13, q: 0.05, s: 0.03, folds: 6 });
        let fractions: Vec<f64> = (0..500).map(|i| 0.004 * f64::from(i) - 0.7).collect();
        for (f, t) in fractions.iter().zip(table.parameters(fractions.iter().copied())) {
            assert_eq!(t, table.parameter(*f));
            // The table is linear between its entries, both ways.
            assert!((table.fraction(t) - f).abs() < 1e-14, "{f} {t}");
        }
    }
}
