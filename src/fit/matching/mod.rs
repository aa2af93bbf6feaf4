//! The outline matched to the curve in order, once round, each stretched where that brings them nearer.
//!
//! Folds of one hem differ in width, so equal fractions of length drift apart. Dynamic time warping of two closed curves, in a band of about
//! half a fold, keeps the order and leaves out no piece of either curve (Sakoe & Chiba, IEEE Trans. ASSP 26 (1978) 43–49, symmetric form).

mod path;

use std::f64::consts::TAU;

use nalgebra::{SMatrix, SVector};

use self::path::{Band, path};
use super::crossings::crosses_more_than;
use super::eight_places::{Places, in_eights, points_at};
use super::outline::Outline;
use super::start::{LengthTable, Start};
use crate::experiment::Point;
use crate::model::hem::{Hem, Placement};
use crate::numerics::lanes::Lanes;
use crate::vectorized;

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
    let (mut pin, mut scratch) = (None, Vec::new());
    for _ in 0..ROUNDS {
        let nodes = Nodes::at(&hem, &placement, samples.len());
        let (pairs, next) = warp(&samples, &nodes, start.offset, pin, &mut scratch);
        pin = Some(next);
        let rms = rms(&pairs, &samples, &nodes);
        let settled = best.as_ref().is_some_and(|b| rms > b.rms * (1.0 - 1e-4));
        if best.as_ref().is_none_or(|b| rms < b.rms) {
            best = Some(Matched { hem, placement, parameters: parameters(&pairs, &nodes), rms });
        }
        if settled {
            break;
        }
        let Some((next, at)) = solve(&samples, &pairs, &nodes, length) else { break };
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
    let tangled = |hem: &Hem| crosses_more_than(hem, outline.crossings);
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
    let nodes = Nodes::at(&hem, &best.placement, samples.len());
    let (pairs, _) = warp(samples, &nodes, offset, None, &mut Vec::new());
    Matched { hem, placement: best.placement, parameters: parameters(&pairs, &nodes), rms: rms(&pairs, samples, &nodes) }
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
    let nodes = Nodes::at(hem, placement, samples.len());
    rms(&warp(&samples, &nodes, offset, None, &mut Vec::new()).0, &samples, &nodes)
}

/// About twenty samples a fold.
fn thinned(outline: &Outline, folds: u32) -> Vec<Point> {
    let stride = (outline.samples.len() / (20 * folds as usize).max(128)).max(1);
    outline.samples.iter().copied().step_by(stride).collect()
}

/// A hem at equal steps of its length.
struct Nodes {
    hem: Hem,
    placement: Placement,
    /// Curve parameter, ascending.
    parameters: Vec<f64>,
    /// m.
    points: Vec<Point>,
}

impl Nodes {
    fn at(hem: &Hem, placement: &Placement, n: usize) -> Self {
        let parameters: Vec<f64> = LengthTable::of(hem).parameters((0..n).map(|j| j as f64 / n as f64)).collect();
        let points = points_at(hem, placement, parameters.iter().copied());
        Nodes { hem: *hem, placement: *placement, parameters, points }
    }
}

/// One cell of the match.
struct Pair {
    sample: usize,
    node: usize,
    /// Whole turns by which the node is further on than its parameter.
    turns: f64,
    weight: f64,
}

/// From a pair's sample back to its node, m.
fn difference(pair: &Pair, samples: &[Point], nodes: &Nodes) -> (f64, f64) {
    let (sample, node) = (samples[pair.sample], nodes.points[pair.node]);
    (sample.x - node.x, sample.y - node.y)
}

fn rms(pairs: &[Pair], samples: &[Point], nodes: &Nodes) -> f64 {
    let square = |pair: &Pair| {
        let (ex, ey) = difference(pair, samples, nodes);
        pair.weight * (ex * ex + ey * ey)
    };
    (pairs.iter().map(square).sum::<f64>() / pairs.iter().map(|p| p.weight).sum::<f64>()).sqrt()
}

/// A sample and its lag that are known to belong together: where a path begins and ends.
type Pin = (usize, i64);

/// The least-cost match in order, once round from `pin`; and a pin half way round, for the next match.
///
/// Without a pin the match begins at sample 0, and again from the pin that this gives, so that neither end is pinned wrongly.
fn warp(samples: &[Point], nodes: &Nodes, offset: f64, pin: Option<Pin>, scratch: &mut Vec<f64>) -> (Vec<Pair>, Pin) {
    let n = samples.len();
    let base = (-offset * n as f64).round() as i64;
    let half = ((BAND * n as f64 / f64::from(nodes.hem.folds.max(1))) as i64).max(4);
    let mut way = |(from, lag): Pin| path(samples, &nodes.points, from, lag, Band { base, half }, scratch);
    let half_way = |cells: &[(usize, i64)], from: usize| {
        let (i, lag) = cells.iter().find(|(i, _)| *i == from + n / 2).expect("the path visits every sample");
        (i % n, *lag)
    };
    let pin = pin.unwrap_or_else(|| half_way(&way((0, 0)), 0));
    let path = way(pin);
    let next = half_way(&path, pin.0);
    let mut pairs = Vec::with_capacity(path.len());
    let mut last: Option<(usize, i64)> = None;
    for &(i, lag) in &path {
        let weight = match last {
            Some((before, lag_before)) if before + 1 == i && lag_before == lag => 2.0,
            _ => 1.0,
        };
        last = Some((i, lag));
        let node = i as i64 + lag + base;
        // Samples past the end are those of the next turn.
        let turns = (node.div_euclid(n as i64) - (i / n) as i64) as f64;
        pairs.push(Pair { sample: i % n, node: node.rem_euclid(n as i64) as usize, turns, weight });
    }
    // The closing cell repeats the first one.
    pairs.pop();
    (pairs, next)
}

/// Mean parameter of the cells of each sample: ascending, because the path is.
fn parameters(pairs: &[Pair], nodes: &Nodes) -> Vec<f64> {
    let mut sum = vec![(0.0, 0.0); nodes.points.len()];
    for pair in pairs {
        sum[pair.sample].0 += nodes.parameters[pair.node] + TAU * pair.turns;
        sum[pair.sample].1 += 1.0;
    }
    sum.into_iter().map(|(total, count)| total / count).collect()
}

/// One Gauss–Newton step for the match at hand, on the length constraint if there is one.
fn solve(samples: &[Point], pairs: &[Pair], nodes: &Nodes, length: Option<f64>) -> Option<(Hem, Placement)> {
    let Nodes { hem, placement, .. } = nodes;
    let mut pulls = vec![[0.0; 3]; nodes.points.len()];
    for pair in pairs {
        let (ex, ey) = difference(pair, samples, nodes);
        let [weight, x, y] = &mut pulls[pair.node];
        *weight += pair.weight;
        *x += pair.weight * ex;
        *y += pair.weight * ey;
    }
    let eights = |part: usize| in_eights(pulls.iter().map(|pull| pull[part]), 0.0);
    let (normal, right) =
        normal_equations(hem, placement, &in_eights(nodes.parameters.iter().copied(), 0.0), &[eights(0), eights(1), eights(2)]);
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

vectorized! {
    /// Normal matrix and right-hand side in x0, y0, phase, p, q and s, of nodes with their weight and weighed differences in x and y.
    fn normal_equations<V>(
        hem: &Hem,
        placement: &Placement,
        parameters: &[Lanes],
        pulls: &[Vec<Lanes>; 3],
    ) -> (SMatrix<f64, 6, 6>, SVector<f64, 6>) {
        let mut normal = [[V::zero(); 6]; 6];
        let mut right = [V::zero(); 6];
        for (i, t) in parameters.iter().enumerate() {
            let moved = Places::at(hem, placement, V::of(t)).moved();
            let (weight, ex, ey) = (V::of(&pulls[0][i]), V::of(&pulls[1][i]), V::of(&pulls[2][i]));
            for a in 0..6 {
                right[a] = moved[a][0].mul_add(ex, moved[a][1].mul_add(ey, right[a]));
                let (by_x, by_y) = (moved[a][0] * weight, moved[a][1] * weight);
                for b in 0..=a {
                    normal[a][b] = by_x.mul_add(moved[b][0], by_y.mul_add(moved[b][1], normal[a][b]));
                }
            }
        }
        (SMatrix::from_fn(|a, b| normal[a.max(b)][a.min(b)].sum()), SVector::from_fn(|a, _| right[a].sum()))
    }
}
