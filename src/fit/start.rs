//! First guess of a fit: the outline matched to the curve by equal fractions of arc length.
//!
//! Matching by length walks once round both curves in order, so it cannot fall for a curve that fills space; given the match, the problem
//! is linear in the centre, p, q and s.

use std::f64::consts::TAU;

use nalgebra::{SMatrix, SVector};

use super::outline::{Outline, centroid};
use crate::model::hem::{Hem, Placement};

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
        let mut fraction = [0.0; TABLE + 1];
        let speed = |i: usize| hem.local(TAU / folds * i as f64 / TABLE as f64).speed();
        let mut last = speed(0);
        for i in 1..=TABLE {
            let next = speed(i);
            fraction[i] = fraction[i - 1] + 0.5 * (last + next);
            last = next;
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
        let scaled = f * self.folds;
        let fold = scaled.floor();
        let within = scaled - fold;
        let i = self.fraction.partition_point(|&f| f <= within).clamp(1, TABLE);
        let (low, high) = (self.fraction[i - 1], self.fraction[i]);
        let share = if low < high { (within - low) / (high - low) } else { 0.0 };
        TAU / self.folds * (fold + ((i - 1) as f64 + share) / TABLE as f64)
    }
}

/// The best match of a curve with `folds` folds.
pub fn matched(outline: &Outline, folds: u32) -> Start {
    let m = f64::from(folds);
    let samples = &outline.samples;
    let n = samples.len();
    let (cx, cy) = centroid(samples);
    // The m-th harmonic of the radius along the length: its phase is exact for folds that are mirror images of themselves.
    let (mut re, mut im, mut mean) = (0.0, 0.0, 0.0);
    for (j, point) in samples.iter().enumerate() {
        let radius = (point.x - cx).hypot(point.y - cy);
        let (sin, cos) = (TAU * m * j as f64 / n as f64).sin_cos();
        re += radius * cos;
        im += radius * sin;
        mean += radius;
    }
    let amplitude = 2.0 * re.hypot(im) / n as f64;
    let crest = im.atan2(re) / (TAU * m);
    let mean = mean / n as f64;
    // Folds of unequal depth can hide the true crest from that harmonic: a quarter of a fold further is tried as well.
    let from = |quarter: f64, lean: f64| refine(outline, Hem { p: mean, q: amplitude, s: lean, folds }, crest + quarter / m);
    let mut best = nearer(from(0.0, 0.0), from(0.25, 0.0));
    // Even folds can be matched to the noise. Where they are not, they lean so much that a straight fold does not lead there.
    if outline.even && outline.noise < best.rms {
        for lean in [0.5 * mean / m, mean / m] {
            best = [(0.0, lean), (0.25, lean), (0.0, -lean), (0.25, -lean)].into_iter().fold(best, |best, (q, s)| nearer(best, from(q, s)));
        }
    }
    best
}

fn nearer(a: Start, b: Start) -> Start {
    if b.rms < a.rms { b } else { a }
}

/// Matches and solves in turn from `hem`, its crest at the fraction `crest` of the outline's length.
fn refine(outline: &Outline, mut hem: Hem, crest: f64) -> Start {
    let folds = hem.folds;
    let samples = &outline.samples;
    // Sixteen samples a fold are enough for a start.
    let stride = (samples.len() / (16 * folds as usize).max(128)).max(1);
    let fractions: Vec<usize> = (0..samples.len()).step_by(stride).collect();
    let (cx, cy) = centroid(samples);
    let mut offset = crest;
    // On a circle the direction of the crest from the centroid is the phase.
    let first = samples[((offset.rem_euclid(1.0) * samples.len() as f64) as usize).min(samples.len() - 1)];
    let mut placement = Placement { x0: cx, y0: cy, phase: (first.y - cy).atan2(first.x - cx) };
    let mut best = Start { hem, placement, offset, rms: f64::INFINITY };
    for _ in 0..ROUNDS {
        let table = LengthTable::of(&hem);
        let length = outline.length;
        let mut normal = SMatrix::<f64, 7, 7>::zeros();
        let mut right = SVector::<f64, 7>::zeros();
        let mut square = 0.0;
        for &j in &fractions {
            let f = j as f64 / samples.len() as f64;
            let t = table.parameter(f - offset);
            let local = hem.local(t);
            let (sin, cos) = (t + placement.phase).sin_cos();
            let (rho, tau) = local.position;
            let x = placement.x0 + rho * cos - tau * sin;
            let y = placement.y0 + rho * sin + tau * cos;
            let (ex, ey) = (samples[j].x - x, samples[j].y - y);
            square += ex * ex + ey * ey;
            // Sliding the match by a fraction of the length moves the matched point backwards along the curve.
            let speed = local.speed().max(f64::MIN_POSITIVE);
            let slide = -length / speed;
            let (vr, vt) = local.velocity;
            let columns_x = SVector::from([
                1.0,
                0.0,
                -rho * sin - tau * cos,
                cos,
                local.cos_fold * cos,
                -local.sin_lean * sin,
                slide * (vr * cos - vt * sin),
            ]);
            let columns_y = SVector::from([
                0.0,
                1.0,
                rho * cos - tau * sin,
                sin,
                local.cos_fold * sin,
                local.sin_lean * cos,
                slide * (vr * sin + vt * cos),
            ]);
            normal += columns_x * columns_x.transpose() + columns_y * columns_y.transpose();
            right += columns_x * ex + columns_y * ey;
        }
        let rms = (square / fractions.len() as f64).sqrt();
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
        placement.x0 += step[0];
        placement.y0 += step[1];
        placement.phase += step[2].clamp(-0.5 / f64::from(folds), 0.5 / f64::from(folds));
        hem.p += step[3];
        hem.q += step[4];
        hem.s += step[5];
        offset += step[6].clamp(-0.1 / f64::from(folds), 0.1 / f64::from(folds));
    }
    best
}
