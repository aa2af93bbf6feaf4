//! The rules of a sane outline for a curve given by its tangent angle: order, length, simplicity, nearness.
//!
//! The same as [`super::rules`] asks of the paper's curve, on such curves: their σ is their length, which makes two of them simple.

use std::f64::consts::TAU;

use super::crossings::crossings;
use super::outcome::Rule;
use super::outline::Outline;
use super::rules::LENGTH_SLACK;
use super::tangent_fit::Placed;
use crate::experiment::Point;

/// Samples of the curve that are held against the outline.
const SAMPLES: usize = 256;

/// The first rule that the curve breaks, if any; `farthest` is the largest distance of a point from it, `length` what it should have, m.
pub fn broken(placed: &Placed, outline: &Outline, feet: &[f64], farthest: f64, length: f64) -> Option<Rule> {
    if !placed.radius.is_finite() || LENGTH_SLACK < (TAU * placed.radius / length - 1.0).abs() {
        return Some(Rule::Length);
    }
    // Noise moves a foot along the curve by about its own size; where the fit is coarse, feet near a bend bunch by the misfit.
    let allowed = TAU * ((5.0 * outline.noise + 0.5 * farthest) / length + 0.01);
    let (mut turned, mut high, mut back) = (0.0, 0.0_f64, 0.0_f64);
    for i in 0..feet.len() {
        let step = feet[(i + 1) % feet.len()] - feet[i];
        turned += step - TAU * (step / TAU).round();
        high = high.max(turned);
        back = back.max(high - turned);
    }
    if 1e-6 < (turned - TAU).abs() || allowed < back {
        return Some(Rule::Order);
    }
    let curve = placed.outline(SAMPLES);
    if outline.crossings < crossings(&curve) {
        return Some(Rule::Simplicity);
    }
    // As for the paper's curve: 1.5 times what the outline is from it, and 1 % of the radius; half the spacing of the samples on either side.
    let reach = (1.5 * farthest + 0.01 * outline.radius + length / SAMPLES as f64).powi(2);
    let stride = (outline.samples.len() / SAMPLES).max(1);
    let near = |p: &&Point| outline.samples.iter().step_by(stride).any(|q| (p.x - q.x).powi(2) + (p.y - q.y).powi(2) <= reach);
    (curve.iter().filter(near).count() < SAMPLES).then_some(Rule::Nearness)
}
