//! The frame in which a fit is computed: near the origin, and of a size at which no tolerance is too wide or too narrow.
//!
//! Shifting by one of the points and scaling by a power of two cost no digit, so the same outline in micrometres, or a kilometre away, gives the
//! same curve.

use super::bias::{BiasCorrection, Correction};
use super::folds::Options;
use super::limits::Limits;
use super::outcome::{Candidate, Estimate, HeldLength, HemFit, RobustOutcome};
use crate::experiment::campaign::HemLength;
use crate::experiment::{DrapeProfile, Point};
use crate::model::hem::{Hem, Placement};
use crate::numerics::lanes::WIDTH;

/// Extents of a hem (m) that need no scaling: what skirts and drape testers are.
const USUAL: std::ops::RangeInclusive<f64> = 0.0625..=4.0;
/// Further from the origin than this many extents, differences of coordinates lose digits that count.
const FAR: f64 = 64.0;

/// Where the outline lies and how large it is, if that is out of the ordinary.
pub(super) struct Frame {
    origin: Point,
    /// Metres of the outline to one of the frame, a power of two.
    scale: f64,
    /// Extent of the outline, m.
    extent: f64,
    /// Largest coordinate, m.
    farthest: f64,
}

impl Frame {
    /// `None` if the outline can be fitted as it is.
    pub(super) fn of(profile: &DrapeProfile) -> Option<Frame> {
        let points = profile.points();
        // Eight at a time: one maximum after the other would wait for each.
        let (mut farthest, mut square) = ([0.0_f64; WIDTH], [0.0_f64; WIDTH]);
        for chunk in points.chunks(WIDTH) {
            for ((point, farthest), square) in chunk.iter().zip(&mut farthest).zip(&mut square) {
                *farthest = farthest.max(point.x.abs().max(point.y.abs()));
                let (dx, dy) = (point.x - points[0].x, point.y - points[0].y);
                *square = square.max(dx * dx + dy * dy);
            }
        }
        let greatest = |values: [f64; WIDTH]| values.into_iter().fold(0.0, f64::max);
        let (farthest, extent) = (greatest(farthest), greatest(square).sqrt());
        let usual = USUAL.contains(&extent);
        if usual && farthest <= FAR * extent {
            return None;
        }
        let scale = if usual { 1.0 } else { extent.log2().floor().exp2() };
        let origin = if farthest <= FAR * extent { Point::new(0.0, 0.0) } else { points[0] };
        Some(Frame { origin, scale, extent, farthest })
    }

    pub(super) fn profile(&self, profile: &DrapeProfile) -> DrapeProfile {
        profile.map(|p| Point::new((p.x - self.origin.x) / self.scale, (p.y - self.origin.y) / self.scale))
    }

    pub(super) fn options(&self, options: &Options) -> Options {
        let length = match options.length {
            HemLength::Held(length) => HemLength::Held(length / self.scale),
            other => other,
        };
        let (o, unit) = (self.origin, self.scale);
        let limits = &options.limits;
        let limits = Limits {
            x0: limits.x0.map(|x| (x - o.x) / unit),
            y0: limits.y0.map(|y| (y - o.y) / unit),
            phase: limits.phase,
            p: limits.p.map(|p| p / unit),
            q: limits.q.map(|q| q / unit),
            s: limits.s.map(|s| s / unit),
        };
        Options { length, cut_length: options.cut_length.map(|cut| cut / unit), limits, ..options.clone() }
    }

    /// The fit as one of the outline itself.
    pub(super) fn back(&self, fit: HemFit) -> HemFit {
        let unit = self.scale;
        let hem = Hem { p: unit * fit.hem.p, q: unit * fit.hem.q, s: unit * fit.hem.s, ..fit.hem };
        let placement = Placement {
            x0: self.origin.x + unit * fit.placement.x0,
            y0: self.origin.y + unit * fit.placement.y0,
            phase: fit.placement.phase,
        };
        let estimate = |e: Estimate| Estimate { value: unit * e.value, standard_error: e.standard_error.map(|error| unit * error) };
        let [x0_error, y0_error, phase_error] = fit.placement_errors;
        let correction = match fit.bias_correction {
            BiasCorrection::Applied(c) => {
                BiasCorrection::Applied(Correction { p: unit * c.p, q: unit * c.q, s: unit * c.s, sigma: unit * c.sigma, ..c })
            }
            left => left,
        };
        let robust = fit.robust.map(|robust| RobustOutcome { scale: unit * robust.scale, ..robust });
        let n = fit.distances.len() as f64;
        let candidate = |c: Candidate| Candidate { rms: unit * c.rms, aicc: c.aicc + 2.0 * n * unit.ln(), ..c };
        let mut notes = fit.notes;
        let lost = f64::EPSILON * self.farthest;
        if 1e-12 * self.extent < lost {
            notes.push(format!(
                "the origin is {:.1e} times the hem's extent away: coordinates are rounded to {lost:.0e} m, and nothing is known more finely",
                self.farthest / self.extent
            ));
        }
        HemFit {
            hem,
            placement,
            p: estimate(fit.p),
            q: fit.q.map(estimate),
            s: fit.s.map(estimate),
            placement_errors: [x0_error.map(|e| unit * e), y0_error.map(|e| unit * e), phase_error],
            bias_correction: correction,
            robust,
            covariance: fit.covariance.map(|c| c.map(|row| row.map(|value| unit * unit * value))),
            candidates: fit.candidates.into_iter().map(candidate).collect(),
            distances: fit.distances.into_iter().map(|d| unit * d).collect(),
            rms: unit * fit.rms,
            perimeter: unit * fit.perimeter,
            area: unit * unit * fit.area,
            fold_depth: unit * fit.fold_depth,
            outline_length: unit * fit.outline_length,
            held: fit.held.map(|held| HeldLength { length: unit * held.length, multiplier: unit * held.multiplier }),
            notes,
            ..fit
        }
    }
}
