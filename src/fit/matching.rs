//! The outline matched to the curve in order, once round, each stretched where that brings them nearer.
//!
//! Folds of one hem differ in width, so equal fractions of length drift apart. Dynamic time warping of two closed curves, in a band of about
//! half a fold, keeps the order and leaves out no piece of either curve (Sakoe & Chiba, IEEE Trans. ASSP 26 (1978) 43–49, symmetric form).

use std::f64::consts::TAU;

use nalgebra::{SMatrix, SVector};

use super::outline::{Outline, hem_crossings};
use super::start::{LengthTable, Start};
use crate::experiment::Point;
use crate::model::hem::{Hem, Placement};

/// A curve and its match to the outline.
#[derive(Debug, Clone)]
pub struct Matched {
    pub hem: Hem,
    pub placement: Placement,
    /// Curve parameter at equal fractions of the outline's length, ascending, one turn in all.
    pub parameters: Vec<f64>,
    /// Root mean square distance along the match, both curves weighed alike, m.
    pub rms: f64,
}

impl Matched {
    /// Curve parameter at fraction `f` (0…1) of the outline's length.
    pub fn parameter(&self, f: f64) -> f64 {
        let n = self.parameters.len();
        let scaled = f.clamp(0.0, 1.0) * n as f64;
        let i = (scaled as usize).min(n - 1);
        let next = if i + 1 < n { self.parameters[i + 1] } else { self.parameters[0] + TAU };
        self.parameters[i] + (scaled - i as f64) * (next - self.parameters[i])
    }
}

/// Half width of the band, in folds: a fold may slide by up to this against its neighbours without being taken for the next one.
const BAND: f64 = 0.6;
/// Rounds of warping and solving; the estimate is a start, or what is left when nothing else is sane, and settles within these.
const ROUNDS: usize = 12;

/// Relative error of the perimeter on the way, far below what a match is worth; the last curve has it to rounding.
const ROUGH: f64 = 1e-5;

/// Warps and solves in turn from `start`; holds the perimeter at `length` (m) if given.
pub fn warped(outline: &Outline, start: &Start, length: Option<f64>) -> Matched {
    let samples = thinned(outline, start.hem.folds);
    let (mut hem, mut placement) = (start.hem, start.placement);
    if let Some(length) = length {
        hem = stretched(hem, length, ROUGH);
    }
    let mut best: Option<Matched> = None;
    let mut pin = None;
    for _ in 0..ROUNDS {
        let (pairs, next) = warp(&samples, &hem, &placement, start.offset, pin);
        pin = Some(next);
        let rms = rms(&pairs, &samples, &hem, &placement);
        let settled = best.as_ref().is_some_and(|b| rms > b.rms * (1.0 - 1e-4));
        if best.as_ref().is_none_or(|b| rms < b.rms) {
            best = Some(Matched { hem, placement, parameters: parameters(&pairs, samples.len()), rms });
        }
        if settled {
            break;
        }
        let Some((next, at)) = solve(&samples, &pairs, hem, placement, length) else { break };
        (hem, placement) = (next, at);
    }
    let best = best.expect("at least one round");
    match length {
        Some(length) if best.rms.is_finite() => {
            let best = simple(best, outline, &samples, start.offset, length);
            Matched { hem: stretched(best.hem, length, 1e-13), ..best }
        }
        _ => best,
    }
}

/// The match with as much of its sideways lean as leaves the curve without crossings that the outline does not have.
///
/// Without lean the curve has one radius for each polar angle and cannot cross itself; its folds are deepened to keep the length.
fn simple(best: Matched, outline: &Outline, samples: &[Point], offset: f64, length: f64) -> Matched {
    let leaning = |share: f64| stretched(Hem { s: share * best.hem.s, ..best.hem }, length, ROUGH);
    let tangled = |hem: &Hem| outline.crossings < hem_crossings(hem);
    if !tangled(&best.hem) {
        return best;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..8 {
        let middle = 0.5 * (low + high);
        if tangled(&leaning(middle)) { high = middle } else { low = middle }
    }
    // Not the last curve that does not cross: folds that touch are no better.
    let hem = leaning(0.9 * low);
    let (pairs, _) = warp(samples, &hem, &best.placement, offset, None);
    let rms = rms(&pairs, samples, &hem, &best.placement);
    Matched { hem, placement: best.placement, parameters: parameters(&pairs, samples.len()), rms }
}

/// The same curve with its folds deepened or flattened until its perimeter is `length` to a relative `tolerance`, as nearly as folds can do it.
pub fn stretched(hem: Hem, length: f64, tolerance: f64) -> Hem {
    // A curve without folds has none to deepen: a small one shows the direction.
    let hem = if hem.q.abs() + hem.s.abs() < 0.02 * hem.p { Hem { q: 0.02 * hem.p, ..hem } } else { hem };
    let scaled = |factor: f64| Hem { q: factor * hem.q, s: factor * hem.s, ..hem };
    if length <= scaled(0.0).perimeter_to(tolerance).0 {
        let shrink = length / hem.perimeter_to(tolerance).0;
        return Hem { p: hem.p * shrink, q: hem.q * shrink, s: hem.s * shrink, ..hem };
    }
    // Perimeter grows with the factor, convexly: Newton from above descends monotonically.
    let mut factor = 1.0;
    while scaled(factor).perimeter_to(tolerance).0 < length {
        factor *= 2.0;
    }
    for _ in 0..30 {
        let (perimeter, [_, by_q, by_s]) = scaled(factor).perimeter_to(tolerance);
        let slope = by_q * hem.q + by_s * hem.s;
        let step = (perimeter - length) / slope;
        if !step.is_finite() {
            break;
        }
        factor -= step;
        if step.abs() <= tolerance * factor {
            break;
        }
    }
    scaled(factor)
}

/// Root mean square distance of a curve and the outline matched in order, both weighed alike, m; `offset` is the fraction of the outline's
/// length at which the crest `t = 0` lies.
pub fn apart(outline: &Outline, hem: &Hem, placement: &Placement, offset: f64) -> f64 {
    let samples = thinned(outline, hem.folds);
    rms(&warp(&samples, hem, placement, offset, None).0, &samples, hem, placement)
}

/// About twenty samples a fold.
fn thinned(outline: &Outline, folds: u32) -> Vec<Point> {
    let stride = (outline.samples.len() / (20 * folds as usize).max(128)).max(1);
    outline.samples.iter().copied().step_by(stride).collect()
}

fn rms(pairs: &[Pair], samples: &[Point], hem: &Hem, placement: &Placement) -> f64 {
    let square = |p: &Pair| {
        let on = hem.point(placement, p.parameter);
        p.weight * ((samples[p.sample].x - on.x).powi(2) + (samples[p.sample].y - on.y).powi(2))
    };
    (pairs.iter().map(square).sum::<f64>() / pairs.iter().map(|p| p.weight).sum::<f64>()).sqrt()
}

/// One cell of the match.
struct Pair {
    sample: usize,
    parameter: f64,
    weight: f64,
}

/// A sample and its lag that are known to belong together: where a path begins and ends.
type Pin = (usize, i64);

/// The least-cost match in order, once round from `pin`; and a pin half way round, for the next match.
///
/// Without a pin the match begins at sample 0, and again from the pin that this gives, so that neither end is pinned wrongly.
fn warp(samples: &[Point], hem: &Hem, placement: &Placement, offset: f64, pin: Option<Pin>) -> (Vec<Pair>, Pin) {
    let n = samples.len();
    let table = LengthTable::of(hem);
    let nodes: Vec<(f64, Point)> = (0..n).map(|j| table.parameter(j as f64 / n as f64)).map(|t| (t, hem.point(placement, t))).collect();
    let base = (-offset * n as f64).round() as i64;
    let half = ((BAND * n as f64 / f64::from(hem.folds.max(1))) as i64).max(4);
    let half_way = |cells: &[(usize, i64)], from: usize| {
        let (i, lag) = cells.iter().find(|(i, _)| *i == from + n / 2).expect("the path visits every sample");
        (i % n, *lag)
    };
    let (from, lag) = pin.unwrap_or_else(|| half_way(&path(samples, &nodes, 0, 0, base, half), 0));
    let path = path(samples, &nodes, from, lag, base, half);
    let next = half_way(&path, from);
    let mut pairs = Vec::with_capacity(path.len());
    let mut last: Option<(usize, i64)> = None;
    for &(i, lag) in &path {
        let weight = match last {
            Some((before, lag_before)) if before + 1 == i && lag_before == lag => 2.0,
            _ => 1.0,
        };
        last = Some((i, lag));
        let node = i as i64 + lag + base;
        let turn = node.div_euclid(n as i64);
        // Samples past the end are those of the next turn.
        let turns_back = (i / n) as f64;
        let parameter = nodes[node.rem_euclid(n as i64) as usize].0 + TAU * (turn as f64 - turns_back);
        pairs.push(Pair { sample: i % n, parameter, weight });
    }
    // The closing cell repeats the first one.
    pairs.pop();
    (pairs, next)
}

/// Cells (sample, lag) of the cheapest path from (`from`, `lag`) once round to (`from + n`, `lag`).
fn path(samples: &[Point], nodes: &[(f64, Point)], from: usize, lag: i64, base: i64, half: i64) -> Vec<(usize, i64)> {
    let n = samples.len();
    let width = (2 * half + 1) as usize;
    // Nodes in the order in which the band meets them: row `step`, column `k` is `band[step + k]`.
    let first = from as i64 - half + base;
    let band: Vec<Point> = (0..n + width).map(|j| nodes[(first + j as i64).rem_euclid(n as i64) as usize].1).collect();
    let start = (lag + half) as usize;
    let mut total = vec![f64::INFINITY; (n + 1) * width];
    // 0: both advance, 1: the sample advances, 2: the node advances.
    let mut came = vec![0_u8; (n + 1) * width];
    // The row above, with one column more than the band, so that its end needs no question.
    let mut above = vec![f64::INFINITY; width + 1];
    for step in 0..=n {
        let sample = samples[(from + step) % n];
        let row = &mut total[step * width..(step + 1) * width];
        let came = &mut came[step * width..(step + 1) * width];
        let mut left = f64::INFINITY;
        for k in 0..width {
            let node = band[step + k];
            let here = (sample.x - node.x).powi(2) + (sample.y - node.y).powi(2);
            let mut best = (above[k] + 2.0 * here, 0);
            if above[k + 1] + here < best.0 {
                best = (above[k + 1] + here, 1);
            }
            if left + here < best.0 {
                best = (left + here, 2);
            }
            if step == 0 && k == start {
                best = (here, 0);
            }
            (row[k], came[k]) = best;
            left = best.0;
        }
        above[..width].copy_from_slice(row);
    }
    let mut cells = Vec::with_capacity(2 * n);
    let (mut step, mut k) = (n, start);
    loop {
        cells.push((from + step, k as i64 - half));
        if step == 0 && k == start {
            break;
        }
        match came[step * width + k] {
            0 => step -= 1,
            1 => {
                step -= 1;
                k += 1;
            }
            _ => k -= 1,
        }
    }
    cells.reverse();
    cells
}

/// Mean parameter of the cells of each sample: ascending, because the path is.
fn parameters(pairs: &[Pair], n: usize) -> Vec<f64> {
    let mut sum = vec![(0.0, 0.0); n];
    for pair in pairs {
        sum[pair.sample].0 += pair.parameter;
        sum[pair.sample].1 += 1.0;
    }
    sum.into_iter().map(|(total, count)| total / count).collect()
}

/// One Gauss–Newton step for the match at hand, on the length constraint if there is one.
fn solve(samples: &[Point], pairs: &[Pair], hem: Hem, placement: Placement, length: Option<f64>) -> Option<(Hem, Placement)> {
    let mut normal = SMatrix::<f64, 6, 6>::zeros();
    let mut right = SVector::<f64, 6>::zeros();
    for pair in pairs {
        let local = hem.local(pair.parameter);
        let (sin, cos) = (pair.parameter + placement.phase).sin_cos();
        let (rho, tau) = local.position;
        let ex = samples[pair.sample].x - placement.x0 - (rho * cos - tau * sin);
        let ey = samples[pair.sample].y - placement.y0 - (rho * sin + tau * cos);
        let by_x = SVector::from([1.0, 0.0, -rho * sin - tau * cos, cos, local.cos_fold * cos, -local.sin_lean * sin]);
        let by_y = SVector::from([0.0, 1.0, rho * cos - tau * sin, sin, local.cos_fold * sin, local.sin_lean * cos]);
        normal += pair.weight * (by_x * by_x.transpose() + by_y * by_y.transpose());
        right += pair.weight * (by_x * ex + by_y * ey);
    }
    let factor = normal.cholesky()?;
    let mut step = factor.solve(&right);
    if let Some(length) = length {
        let (perimeter, [by_p, by_q, by_s]) = hem.perimeter_to(ROUGH);
        let gradient = SVector::from([0.0, 0.0, 0.0, by_p, by_q, by_s]);
        let across = factor.solve(&gradient);
        step += across * ((length - perimeter - gradient.dot(&step)) / gradient.dot(&across));
    }
    // A match is only as good as the curve it was made for: large steps wait for the next match.
    let largest = 0.3 * hem.p / step.rows(3, 3).amax().max(f64::MIN_POSITIVE);
    let step = step * largest.min(1.0);
    let next = Hem { p: hem.p + step[3], q: hem.q + step[4], s: hem.s + step[5], folds: hem.folds };
    let at = Placement { x0: placement.x0 + step[0], y0: placement.y0 + step[1], phase: placement.phase + step[2] };
    let next = match length {
        Some(length) if next.p > 0.0 => stretched(next, length, ROUGH),
        _ => next,
    };
    (next.p.is_finite() && next.q.is_finite() && next.s.is_finite()).then_some((next, at))
}
