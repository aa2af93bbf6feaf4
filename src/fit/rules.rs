//! The rules that tell a sane fit from a curve that merely fills space near the points.
//!
//! The sum of squared orthogonal distances is small for a curve that winds to and fro until some piece of it passes near every point. The
//! criterion is wrong there, not the solver, so every fit is held against what is known about an outline: its points come in order, cloth
//! does not stretch, the hem does not pass through itself, and a curve is near the outline only if the outline is near the curve.

use std::f64::consts::TAU;

use super::crossings::crosses_more_than;
use super::eight_places::points_at;
use super::outcome::Rule;
use super::outline::{MISSING, Outline};
use super::start::LengthTable;
use crate::experiment::Point;
use crate::experiment::polygon::Polygon;
use crate::model::hem::{Hem, Placement};

/// Relative difference of curve and outline length above which a free fit is not believed. Sane free optima of uneven folds are up to
/// 4 % shorter than their outline (they average the folds); curves that fill space begin at 10 % longer.
pub const LENGTH_SLACK: f64 = 0.05;

/// The same where the curve leaves hardly more than the noise.
const NOISY_LENGTH_SLACK: f64 = 0.1;

/// A point this many median distances from the curve is a gross outlier: 5.4 standard deviations of normal ones …
const ASTRAY: f64 = 8.0;
/// … if no more than this share of the points are.
const ASTRAY_SHARE: f64 = 0.3;

/// What is checked besides the curve itself.
pub struct Evidence<'a> {
    pub outline: &'a Outline,
    /// The measured points, in outline order, m.
    pub points: &'a [Point],
    /// Curve parameter of each outline point's foot, in outline order.
    pub feet: &'a [f64],
    /// Distance of each outline point from the curve, m.
    pub distances: &'a [f64],
    /// Largest of them, m.
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
    // A hem goes round its waist: a curve whose valleys reach the centre winds round it more than once.
    if hem.p <= hem.q.abs() {
        return Some(Rule::Simplicity);
    }
    let perimeter = hem.perimeter();
    // A curve as near to the points as the freest smooth one cannot have got there by filling space; noise blurs the outline's length.
    let slack = if evidence.rms <= 1.5 * evidence.outline.noise { NOISY_LENGTH_SLACK } else { LENGTH_SLACK };
    if slack < (perimeter / evidence.length - 1.0).abs() && !evidence.coarsely_as_long(hem, placement, perimeter) {
        return Some(Rule::Length);
    }
    if out_of_order(hem, evidence, perimeter) {
        return Some(Rule::Order);
    }
    if crosses_more_than(hem, evidence.outline.crossings) {
        return Some(Rule::Simplicity);
    }
    let around = 48 * hem.folds.max(6) as usize;
    let curve = points_at(hem, placement, (0..around).map(|i| TAU * i as f64 / around as f64));
    let (smooth, points) = (Polygon::new(&evidence.outline.samples), Polygon::new(evidence.points));
    if curve.iter().any(|&p| evidence.strays(p, &smooth, &points)) {
        return Some(Rule::Nearness);
    }
    None
}

impl Evidence<'_> {
    /// Distance beyond which a point is a gross outlier, m; infinite where too many would be.
    fn astray(&self) -> f64 {
        let mut sizes: Vec<f64> = self.distances.iter().map(|d| d.abs()).collect();
        let middle = sizes.len() / 2;
        let limit = ASTRAY * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
        let few = sizes.iter().filter(|size| limit < **size).count() as f64 <= ASTRAY_SHARE * sizes.len() as f64;
        if few { limit } else { f64::INFINITY }
    }

    /// Whether a point of the curve is further from the outline (`smooth`, and the `points` themselves) than the outline is from the curve.
    fn strays(&self, point: Point, smooth: &Polygon<'_>, points: &Polygon<'_>) -> bool {
        // 1 % of the radius: where the fit is excellent, the smooth outline between the points is itself not better known.
        let reach = 1.5 * self.farthest + 0.01 * self.outline.radius;
        if smooth.nearest(point).square.sqrt() <= reach {
            return false;
        }
        // Between distant points nobody knows the outline better than a share of their distance: the sag of an arc of 120° over its chord.
        let nearest = points.nearest(point);
        let (distance, chord) = (nearest.square.sqrt(), nearest.side.0.hypot(nearest.side.1));
        // Over a missing piece the folds come on top of the sag.
        let sag = if MISSING * self.outline.length < chord { 0.6 } else { 0.3 };
        reach + sag * chord < distance
    }

    /// Whether a coarsely sampled outline is as long as the curve seen through the same samples: few points cut the corners of both alike.
    fn coarsely_as_long(&self, hem: &Hem, placement: &Placement, perimeter: f64) -> bool {
        let n = self.points.len();
        let coarseness = f64::from(hem.folds) / n as f64;
        if coarseness < 1.0 / 32.0 {
            return false;
        }
        let on_curve: Vec<Point> = self.feet.iter().map(|&t| hem.point(placement, t)).collect();
        let (seen, measured) = (polygon_length(&on_curve), polygon_length(self.points));
        // A fold of n/m chords is shorter than its arc by about 8 (m/n)² where it is as deep as it is wide.
        (seen / measured - 1.0).abs() <= LENGTH_SLACK && perimeter / seen - 1.0 <= LENGTH_SLACK + 8.0 * coarseness * coarseness
    }
}

fn polygon_length(points: &[Point]) -> f64 {
    points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| a.distance(*b)).sum()
}

/// Whether the feet run back along the curve further than noise makes them, or do not run round it once.
fn out_of_order(hem: &Hem, evidence: &Evidence, perimeter: f64) -> bool {
    // Measured in length, not in t: where the curve turns sharply it moves little while t runs.
    let table = LengthTable::of(hem);
    // A gross outlier has its foot anywhere; the order is that of the others.
    let astray = evidence.astray();
    let feet = evidence.feet.iter().zip(evidence.distances).filter(|(_, d)| d.abs() <= astray);
    let places: Vec<f64> = feet.map(|(&t, _)| table.fraction(t)).collect();
    let n = places.len();
    let (mut turned, mut back) = (0.0, 0.0_f64);
    let mut high = f64::NEG_INFINITY;
    for i in 0..n {
        let step = places[(i + 1) % n] - places[i];
        turned += step - step.round();
        high = high.max(turned);
        back = back.max(high - turned);
    }
    // Noise moves a foot along the curve by about its own size, the largest of many by four; where the fit is coarse, feet near a bend bunch
    // by the misfit.
    let allowed = (5.0 * evidence.outline.noise + 0.5 * evidence.rms) / perimeter + 0.01;
    (turned - 1.0).abs() > 1e-6 || allowed < back
}
