//! Profile-likelihood intervals: how far one parameter can go before the best the others can do is too bad.
//!
//! With ψ fixed and the others fitted anew, `τ(ψ) = ±√((S(ψ) − S(ψ̂))/σ̂²)`, S the sum of squared distances (less their mean shift), is
//! Student's t under linearity and nearly so without it; the interval is where |τ| stays below the quantile given. That equals the likelihood
//! ratio against F(1, ν).
//!
//! Sources: Bates & Watts, Nonlinear Regression Analysis and its Applications (1988), section 6.1; Venzon & Moolgavkar, Applied Statistics 37
//! (1988) 87–94.

use std::f64::consts::PI;

use super::base::{Base, base};
use super::estimating::{Equations, Shift, Unknowns};
use super::intervals::{End, Interval};
use super::outcome::HemFit;
use super::uncertainty::{Unknown, WhyMissing};
use crate::experiment::DrapeProfile;

/// |τ| meets its cut-off to this share: the ends are right to as much of half the interval.
pub const TOLERANCE: f64 = 1e-7;
/// A side is open if the cut-off is not met within this many times the step that linearity would need.
const FARTHEST: f64 = 50.0;
/// Curves of a profile are fitted to this share of p; their sum of squares is then right to its square.
const CURVE_TOLERANCE: f64 = 1e-9;
/// … or to this share of it.
const GAIN: f64 = 1e-12;

/// The interval of one parameter within which |τ| < `cutoff` (Student's t on [`HemFit::degrees_of_freedom`] for a level).
///
/// # Errors
/// Why there is no likelihood to follow: the fit is no minimum, or the hem has no such parameter.
pub fn interval(profile: &DrapeProfile, fit: &HemFit, parameter: Unknown, cutoff: f64) -> Result<Interval, WhyMissing> {
    let base = base(profile.points(), fit)?;
    let index = parameter as usize;
    if !base.free[index] {
        return Err(WhyMissing::NoFolds);
    }
    let sum_of_squares: f64 = base.residuals.iter().map(|e| e * e).sum();
    let mut free = base.free;
    free[index] = false;
    // Where folds are lost in the noise, phase and s hardly move the curve and nothing tells them; p does not depend on them.
    if parameter == Unknown::P && fit.standard_error_missing.iter().any(|missing| missing.why == WhyMissing::FoldsWithinNoise) {
        (free[Unknown::Phase as usize], free[Unknown::S as usize]) = (false, false);
    }
    let trace = Trace {
        index,
        sum_of_squares,
        sigma: (sum_of_squares / fit.degrees_of_freedom as f64).sqrt(),
        cutoff,
        bounds: match parameter {
            Unknown::P => (f64::MIN_POSITIVE, f64::INFINITY),
            Unknown::Q => (0.0, f64::INFINITY),
            Unknown::Phase => {
                // Half a period either way is everywhere.
                let half = PI / f64::from(fit.hem.folds.max(1));
                (fit.placement.phase - half, fit.placement.phase + half)
            }
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        },
        equations: Equations {
            points: base.points,
            counts: None,
            folds: base.folds,
            length: base.length,
            free,
            shift: Shift::Given(&base.shift),
            tolerance: CURVE_TOLERANCE,
            gain: GAIN,
        },
    };
    // Exact points: nothing but the estimate is likely.
    if trace.sigma <= 4.0 * f64::EPSILON * fit.hem.p.abs() {
        let here = End::At(base.unknowns[index]);
        return Ok(Interval { low: here, high: here });
    }
    let start = Place { value: base.unknowns[index], tau: 0.0, unknowns: base.unknowns, feet: base.at.feet.clone() };
    let first = first_step(&base, index, &trace);
    Ok(Interval { low: trace.end(&start, -first), high: trace.end(&start, first) })
}

/// How far the parameter goes until τ meets its cut-off, were everything linear; m or rad.
fn first_step(base: &Base, index: usize, trace: &Trace) -> f64 {
    // What of the column the other columns cannot make up for, by modified Gram–Schmidt: 1/√((JᵀJ)⁻¹)ⱼⱼ.
    let column = |j: usize| -> Vec<f64> { base.at.rows.iter().map(|row| row[j]).collect() };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let others = (0..6).filter(|&j| j != index && base.free[j]);
    for j in others.chain([index]) {
        let mut rest = column(j);
        let whole = dot(&rest, &rest).sqrt();
        for earlier in &basis {
            let share = dot(earlier, &rest);
            rest.iter_mut().zip(earlier).for_each(|(r, e)| *r -= share * e);
        }
        let norm = dot(&rest, &rest).sqrt();
        if j == index {
            let own = norm.max(1e-6 * whole).max(f64::MIN_POSITIVE);
            return trace.cutoff * trace.sigma / own;
        }
        if 1e-8 * whole < norm {
            rest.iter_mut().for_each(|r| *r /= norm);
            basis.push(rest);
        }
    }
    unreachable!("the parameter comes last")
}

struct Trace<'a> {
    index: usize,
    /// At the estimate, m².
    sum_of_squares: f64,
    sigma: f64,
    cutoff: f64,
    /// How far the parameter can go at all.
    bounds: (f64, f64),
    equations: Equations<'a>,
}

/// A fitted place on the profile.
#[derive(Clone)]
struct Place {
    value: f64,
    /// |τ|.
    tau: f64,
    unknowns: Unknowns,
    feet: Vec<f64>,
}

impl Trace<'_> {
    /// The others fitted anew with the parameter at `value`, from two known places on the way (the second for the direction).
    fn at(&self, value: f64, from: &Place, before: Option<&Place>) -> Option<Place> {
        let mut start = from.unknowns;
        if let Some(before) = before.filter(|b| b.value != from.value) {
            let share = (value - from.value) / (from.value - before.value);
            (0..6).for_each(|j| start[j] += share * (from.unknowns[j] - before.unknowns[j]));
        }
        start[self.index] = value;
        let mut plain = from.unknowns;
        plain[self.index] = value;
        let root = self.equations.root(start, &from.feet).or_else(|| self.equations.root(plain, &from.feet))?;
        let rise = (root.sum_of_squares(None) - self.sum_of_squares).max(0.0);
        Some(Place { value, tau: rise.sqrt() / self.sigma, unknowns: root.unknowns, feet: root.at.feet })
    }

    /// Where |τ| meets the cut-off on the side of `step`.
    fn end(&self, start: &Place, step: f64) -> End {
        let (lowest, highest) = self.bounds;
        let limit = start.value + FARTHEST * step;
        let (mut below, mut before): (Place, Option<Place>) = (start.clone(), None);
        let mut reach = step;
        let mut failures = 0;
        let above = loop {
            let value = (below.value + reach).clamp(limit.min(start.value), limit.max(start.value)).clamp(lowest, highest);
            if value == below.value {
                return if self.index == Unknown::Q as usize && value == lowest { End::Bound(lowest) } else { End::Open };
            }
            match self.at(value, &below, before.as_ref()) {
                Some(place) if self.cutoff <= place.tau => break place,
                Some(place) => {
                    // As if τ went on straight, a little further; at most thrice as far as so far.
                    let gone = place.value - start.value;
                    let straight = gone * (1.05 * self.cutoff / place.tau.max(1e-3 * self.cutoff) - 1.0);
                    reach = if straight.abs() < 2.0 * gone.abs() { straight } else { 2.0 * gone };
                    before = Some(std::mem::replace(&mut below, place));
                }
                None => {
                    failures += 1;
                    reach *= 0.5;
                    if 6 < failures {
                        return End::Lost;
                    }
                }
            }
        };
        self.between(below, above)
    }

    /// Regula falsi between a place below the cut-off and one above it (Illinois: the end that stays counts half).
    fn between(&self, mut below: Place, mut above: Place) -> End {
        let (mut low, mut high) = (below.tau - self.cutoff, above.tau - self.cutoff);
        for _ in 0..60 {
            let value = (below.value * high - above.value * low) / (high - low);
            let Some(place) = self.at(value, &below, Some(&above)) else { return End::Lost };
            let off = place.tau - self.cutoff;
            if off.abs() <= TOLERANCE * self.cutoff {
                return End::At(value);
            }
            if off < 0.0 {
                (below, low, high) = (place, off, 0.5 * high);
            } else {
                (above, high, low) = (place, off, 0.5 * low);
            }
            if (above.value - below.value).abs() <= TOLERANCE * self.cutoff * self.sigma * 1e-3 {
                return End::At(0.5 * (above.value + below.value));
            }
        }
        End::At(0.5 * (below.value + above.value))
    }
}
