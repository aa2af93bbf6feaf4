//! Bootstrap replicates of a fit: outlines drawn anew, each fitted from the fitted curve at the same fold count.
//!
//! Nothing here is random: every replicate asks for the integers it needs, so it depends on nothing but them (`study::intervals` draws them).
//!
//! - *Residual*: about each foot a point at a distance drawn from all distances, and moved along the curve by another draw, as far as the
//!   distances are noise. Without the latter the replicates would not have the bias of curvature that the measurement has.
//! - *Case*: as many points as there are, drawn from them with replacement; a point drawn twice counts twice, and the order stays.
//!
//! Source: Efron & Tibshirani, An Introduction to the Bootstrap (1993), chapters 9 and 14.

use std::f64::consts::{PI, TAU};

use super::base::{Base, base};
use super::estimating::{Equations, Shift, Unknowns, noise_variance};
use super::orthogonal::curve;
use super::outcome::HemFit;
use super::uncertainty::{Whitened, WhyMissing};
use crate::experiment::{DrapeProfile, Point};

/// Replicates are fitted to this share of p, far below their scatter.
const TOLERANCE: f64 = 1e-9;
/// … or to where a step would take less than this share off the sum of squares: it is then a thousandth of a standard error, and is taken.
const GAIN: f64 = 1e-9;

/// A fit, ready to be replicated.
pub struct Bootstrap<'a> {
    base: Base<'a>,
    /// Foot points (m) and outward normals.
    feet: Vec<(Point, (f64, f64))>,
    /// Distances less their mean shift, each divided by √(1 − its leverage) so that all have the variance of the errors, centred, m.
    errors: Vec<f64>,
    /// What of an error is noise, and moves points along the curve as well as across it, 0…1.
    noise: f64,
    /// How each estimate changes when one point is left out: (x0, y0, phase, p, q, s) for each point.
    influence: Vec<Unknowns>,
}

impl<'a> Bootstrap<'a> {
    /// # Errors
    /// Why the fit cannot be replicated: it is no minimum, or its unknowns are not determined.
    pub fn of(profile: &'a DrapeProfile, fit: &HemFit) -> Result<Self, WhyMissing> {
        let base = base(profile.points(), fit)?;
        if let Some(missing) = fit.standard_error_missing.iter().find(|m| m.why == WhyMissing::NotDetermined) {
            return Err(missing.why);
        }
        let n = base.residuals.len();
        let whitened = Whitened::of(&base.at, &base.free, base.length.map(|_| fit.hem.perimeter_gradient().1));
        let leverage: Vec<f64> = base.at.rows.iter().map(|row| whitened.leverage(row).min(0.99)).collect();
        let mut errors: Vec<f64> = base.residuals.iter().zip(&leverage).map(|(e, h)| e / (1.0 - h).sqrt()).collect();
        let mean = errors.iter().sum::<f64>() / n as f64;
        errors.iter_mut().for_each(|e| *e -= mean);
        let influence = (0..n).map(|i| whitened.solve(&base.at.rows[i]).map(|v| v * base.residuals[i] / (1.0 - leverage[i]))).collect();
        let spread = base.residuals.iter().map(|e| e * e).sum::<f64>() / n as f64;
        let unknowns = n - fit.degrees_of_freedom;
        let noise = if 0.0 < spread {
            let of_noise = noise_variance(&base.residuals, None, unknowns) * (n - unknowns) as f64 / n as f64;
            (of_noise / spread).min(1.0).sqrt()
        } else {
            0.0
        };
        let (hem, placement) = curve(&base.unknowns, base.folds);
        let feet = base
            .at
            .feet
            .iter()
            .map(|&t| {
                let local = hem.local(t);
                let speed = local.speed();
                let (nr, nt) = (local.velocity.1 / speed, -local.velocity.0 / speed);
                let (sin, cos) = (t + placement.phase).sin_cos();
                (hem.point(&placement, t), (nr * cos - nt * sin, nr * sin + nt * cos))
            })
            .collect();
        Ok(Bootstrap { base, feet, errors, noise, influence })
    }

    /// (x0, y0, phase, p, q, s) of the fit itself.
    pub fn estimate(&self) -> Unknowns {
        self.base.unknowns
    }

    /// Change of (x0, y0, phase, p, q, s) when point `i` is left out, to first order.
    pub fn influence(&self) -> &[Unknowns] {
        &self.influence
    }

    /// (x0, y0, phase, p, q, s) of one residual replicate; `draw(k)` is an integer below k. `None` if it cannot be fitted.
    pub fn residual(&self, mut draw: impl FnMut(usize) -> usize) -> Option<Unknowns> {
        let n = self.errors.len();
        let points: Vec<Point> = self
            .feet
            .iter()
            .map(|(foot, (nx, ny))| {
                let across = self.errors[draw(n)];
                let along = self.noise * self.errors[draw(n)];
                Point::new(foot.x + across * nx - along * ny, foot.y + across * ny + along * nx)
            })
            .collect();
        self.fitted(&points, None, &self.base.at.feet)
    }

    /// (x0, y0, phase, p, q, s) of one case replicate; `draw(k)` is an integer below k. `None` if it cannot be fitted.
    pub fn case(&self, mut draw: impl FnMut(usize) -> usize) -> Option<Unknowns> {
        let n = self.base.points.len();
        let mut times = vec![0.0; n];
        (0..n).for_each(|_| times[draw(n)] += 1.0);
        let drawn: Vec<usize> = (0..n).filter(|&i| 0.0 < times[i]).collect();
        let points: Vec<Point> = drawn.iter().map(|&i| self.base.points[i]).collect();
        let counts: Vec<f64> = drawn.iter().map(|&i| times[i]).collect();
        let feet: Vec<f64> = drawn.iter().map(|&i| self.base.at.feet[i]).collect();
        self.fitted(&points, Some(&counts), &feet)
    }

    fn fitted(&self, points: &[Point], counts: Option<&[f64]>, feet: &[f64]) -> Option<Unknowns> {
        let equations = Equations {
            points,
            counts,
            folds: self.base.folds,
            length: self.base.length,
            free: self.base.free,
            shift: if self.base.corrected { Shift::Curvature } else { Shift::None },
            tolerance: TOLERANCE,
            gain: GAIN,
        };
        let mut unknowns = equations.root(self.base.unknowns, feet)?.unknowns;
        // Another curve than the one replicated: it has wandered off.
        if !(0.5 * self.base.unknowns[3]..=2.0 * self.base.unknowns[3]).contains(&unknowns[3]) || 2.0 * unknowns[3] < unknowns[4].abs() {
            return None;
        }
        let m = f64::from(self.base.folds.max(1));
        if unknowns[4] < 0.0 {
            unknowns[4] = -unknowns[4];
            unknowns[2] += PI / m;
        }
        // The phase nearest to the estimate's.
        let period = TAU / m;
        unknowns[2] -= period * ((unknowns[2] - self.base.unknowns[2]) / period).round();
        Some(unknowns)
    }
}
