//! The rules that tell a sane fit from a curve that merely fills space near the points.
//!
//! The sum of squared orthogonal distances is small for a curve that winds to and fro until some piece of it passes near every point. The
//! criterion is wrong there, not the solver, so every fit is held against what is known about an outline: its points come in order, cloth
//! does not stretch, the hem does not pass through itself, and a curve is near the outline only if the outline is near the curve.

use std::f64::consts::TAU;

use super::outcome::Rule;
use super::outline::{Outline, crossings};
use crate::experiment::Point;
use crate::model::hem::{Hem, Placement};

/// Relative difference of curve and outline length above which a free fit is not believed. Sane free optima of uneven folds are up to
/// 4 % shorter than their outline (they average the folds); curves that fill space begin at 10 % longer.
pub const LENGTH_SLACK: f64 = 0.05;

/// What is checked besides the curve itself.
pub struct Evidence<'a> {
    pub outline: &'a Outline,
    /// Curve parameter of each outline point's foot, in outline order.
    pub feet: &'a [f64],
    /// Largest distance of an outline point from the curve, m.
    pub farthest: f64,
    /// Root mean square distance of the outline points from the curve, m.
    pub rms: f64,
    /// The length the curve should have, m.
    pub length: f64,
}

/// The first rule that the curve breaks, if any.
pub fn broken(hem: &Hem, placement: &Placement, evidence: &Evidence) -> Option<Rule> {
    // Cheapest first.
    if !hem.p.is_finite()
        || !hem.q.is_finite()
        || !hem.s.is_finite()
        || hem.p <= 0.0
        || 10.0 * evidence.length < hem.p.max(hem.q.abs()).max(hem.s.abs())
    {
        return Some(Rule::Length);
    }
    let perimeter = hem.perimeter();
    if LENGTH_SLACK < (perimeter / evidence.length - 1.0).abs() {
        return Some(Rule::Length);
    }
    if out_of_order(evidence, perimeter) {
        return Some(Rule::Order);
    }
    let curve = hem.outline(placement, 48 * hem.folds.max(6) as usize);
    if evidence.outline.crossings < crossings(&curve) {
        return Some(Rule::Simplicity);
    }
    if curve.iter().any(|&p| evidence.reach() < distance_to_polygon(p, &evidence.outline.samples)) {
        return Some(Rule::Nearness);
    }
    None
}

impl Evidence<'_> {
    /// How far the curve may be from the outline: hardly further than the outline is from the curve.
    fn reach(&self) -> f64 {
        // 1 % of the radius: where the fit is excellent, the smooth outline between the points is itself not better known.
        1.5 * self.farthest + 0.01 * self.outline.radius
    }
}

/// Whether the feet run back along the curve further than noise makes them, or do not run round it once.
fn out_of_order(evidence: &Evidence, perimeter: f64) -> bool {
    let n = evidence.feet.len();
    let (mut turned, mut back) = (0.0, 0.0_f64);
    let mut high = f64::NEG_INFINITY;
    for i in 0..n {
        let step = evidence.feet[(i + 1) % n] - evidence.feet[i];
        let step = step - TAU * (step / TAU).round();
        turned += step;
        high = high.max(turned);
        back = back.max(high - turned);
    }
    // Noise moves a foot along the curve by about its own size; where the fit is coarse, feet near a bend bunch by the misfit.
    let allowed = (4.0 * evidence.outline.noise + 0.5 * evidence.rms) / perimeter * TAU + 0.01 * TAU;
    (turned - TAU).abs() > 1e-6 || allowed < back
}

/// Distance of a point from a closed polygon, m.
fn distance_to_polygon(point: Point, polygon: &[Point]) -> f64 {
    let n = polygon.len();
    let mut least = f64::INFINITY;
    for i in 0..n {
        let (a, b) = (polygon[i], polygon[(i + 1) % n]);
        let (ex, ey) = (b.x - a.x, b.y - a.y);
        let (dx, dy) = (point.x - a.x, point.y - a.y);
        let share = ((dx * ex + dy * ey) / (ex * ex + ey * ey).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        least = least.min((dx - share * ex).powi(2) + (dy - share * ey).powi(2));
    }
    least.sqrt()
}
