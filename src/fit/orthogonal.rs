//! The orthogonal distance fit of one hem curve of known fold count.
//!
//! Unknowns (x0, y0, φ, p, q, s). Each point's curve parameter is eliminated by projection: the foot point is stationary, so a row of the
//! Jacobian is `−n·∂c/∂θ` at the foot and nothing else (Ahn, Rauh & Warnecke, Pattern Recognition 34 (2001) 2283–2303).

use nalgebra::{DMatrix, DVector};

use super::foot_point::{Foot, centred, follow, nearest_within};
use crate::error::Error;
use crate::experiment::Point;
use crate::model::hem::{Hem, Placement};
use crate::numerics::least_squares::{self, Options, Problem, Summary};

/// Names of the unknowns, in order.
pub const UNKNOWNS: [&str; 6] = ["x0", "y0", "phase", "p", "q", "s"];

/// The curve of one set of unknowns.
pub fn curve(unknowns: &[f64], folds: u32) -> (Hem, Placement) {
    let [x0, y0, phase, p, q, s] = unknowns else { unreachable!("six unknowns") };
    (Hem { p: *p, q: *q, s: *s, folds }, Placement { x0: *x0, y0: *y0, phase: *phase })
}

/// A fitted curve of known fold count, with the feet of all points.
#[derive(Debug, Clone)]
pub struct Fitted {
    pub hem: Hem,
    pub placement: Placement,
    pub feet: Vec<f64>,
    pub summary: Summary,
    /// Residual vectors evaluated, restarts included.
    pub evaluations: usize,
}

/// Fits from a curve and the feet of the points on it; holds the perimeter at `length` (m) if given.
///
/// A free fit is abandoned when its curve grows beyond 1.6 times `outline_length`: no sane curve lies behind such a one, and the way into
/// the space-filling trap is long. Use infinity to follow it all the way.
/// After convergence each foot is looked for anew between its neighbours' feet; where a nearer one is found, the fit goes on from there.
///
/// # Errors
/// [`Error::Unanswerable`] with fewer points than unknowns.
pub fn fit(
    points: &[Point],
    hem: Hem,
    placement: Placement,
    feet: Vec<f64>,
    length: Option<f64>,
    outline_length: f64,
    options: &Options,
) -> Result<Fitted, Error> {
    let mut unknowns = vec![placement.x0, placement.y0, placement.phase, hem.p, hem.q, hem.s];
    let mut problem = Orthogonal {
        points,
        folds: hem.folds,
        trial: vec![None; points.len()],
        feet,
        length,
        longest: 1.6 * outline_length,
        iterate: (hem, placement),
    };
    let mut evaluations = 0;
    // A distance is the difference of coordinates of this size.
    let size = points.iter().map(|p| p.x.abs().max(p.y.abs())).fold(hem.p.abs(), f64::max);
    let options = &Options { residual_rounding: 4.0 * f64::EPSILON * size, ..*options };
    // Feet that move between rounds lower the sum of squares, so this ends; in practice after one round, rarely three.
    for _ in 0..5 {
        let summary = least_squares::solve(&mut problem, &unknowns, options)?;
        evaluations += summary.evaluations;
        let (hem, placement) = curve(&summary.parameters, hem.folds);
        unknowns.clone_from(&summary.parameters);
        let settled = !summary.parameters.iter().all(|v| v.is_finite()) || !problem.look_again(&hem, &placement);
        if settled || summary.termination == least_squares::Termination::Abandoned {
            return Ok(Fitted { hem, placement, feet: problem.feet, summary, evaluations });
        }
    }
    let summary = least_squares::solve(&mut problem, &unknowns, options)?;
    evaluations += summary.evaluations;
    let (hem, placement) = curve(&summary.parameters, hem.folds);
    Ok(Fitted { hem, placement, feet: problem.feet, summary, evaluations })
}

/// Perimeter by 32 nodes a fold, m: right to a few percent, which is all a bound needs.
fn rough_perimeter(hem: &Hem) -> f64 {
    const NODES: usize = 32;
    let step = std::f64::consts::TAU / (f64::from(hem.folds.max(1)) * NODES as f64);
    (0..NODES).map(|i| hem.local(step * i as f64).speed()).sum::<f64>() * std::f64::consts::TAU / NODES as f64
}

struct Orthogonal<'a> {
    points: &'a [Point],
    folds: u32,
    /// Feet at the last evaluated unknowns.
    trial: Vec<Option<Foot>>,
    /// Feet at the current iterate: where the next search begins.
    feet: Vec<f64>,
    length: Option<f64>,
    /// Perimeter beyond which a free fit is abandoned, m.
    longest: f64,
    /// The curve last evaluated.
    iterate: (Hem, Placement),
}

impl Orthogonal<'_> {
    /// Whether some point has a nearer foot in order between its neighbours' feet; moves those feet.
    fn look_again(&mut self, hem: &Hem, placement: &Placement) -> bool {
        let n = self.points.len();
        let window = std::f64::consts::TAU / (2.0 * f64::from(hem.folds.max(1)));
        let mut moved = false;
        for i in 0..n {
            let point = centred(self.points[i], placement);
            let here = Foot::at(hem, point, self.feet[i]);
            let found = nearest_within(hem, point, self.feet[i] - window, self.feet[i] + window, 16);
            if found.square() < here.square() * (1.0 - 1e-6) - 1e-18 && (found.t - self.feet[i]).abs() <= window {
                self.feet[i] = found.t;
                moved = true;
            }
        }
        moved
    }
}

impl Problem for Orthogonal<'_> {
    fn residual_count(&self) -> usize {
        self.points.len()
    }

    fn residuals(&mut self, unknowns: &[f64], residuals: &mut [f64]) -> bool {
        let (hem, placement) = curve(unknowns, self.folds);
        self.iterate = (hem, placement);
        for (i, (point, residual)) in self.points.iter().zip(residuals).enumerate() {
            let foot = follow(&hem, centred(*point, &placement), self.feet[i]);
            *residual = foot.distance();
            self.trial[i] = Some(foot);
            if !residual.is_finite() {
                return false;
            }
        }
        true
    }

    fn jacobian(&mut self, unknowns: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
        let phase = unknowns[2];
        for (i, foot) in self.trial.iter().enumerate() {
            let Some(foot) = foot else { return false };
            let local = &foot.local;
            let speed = local.speed();
            // Outward normal in the turning frame.
            let (nr, nt) = (local.velocity.1 / speed, -local.velocity.0 / speed);
            let (sin, cos) = (foot.t + phase).sin_cos();
            jacobian[(i, 0)] = -(nr * cos - nt * sin);
            jacobian[(i, 1)] = -(nr * sin + nt * cos);
            jacobian[(i, 2)] = nr * local.position.1 - nt * local.position.0;
            jacobian[(i, 3)] = -nr;
            jacobian[(i, 4)] = -nr * local.cos_fold;
            jacobian[(i, 5)] = -nt * local.sin_lean;
        }
        true
    }

    fn accept(&mut self) -> bool {
        for (foot, trial) in self.feet.iter_mut().zip(&self.trial) {
            if let Some(trial) = trial {
                *foot = trial.t;
            }
        }
        self.length.is_some() || rough_perimeter(&self.iterate.0) < self.longest
    }

    fn constraint(&mut self, unknowns: &[f64]) -> Option<(f64, DVector<f64>)> {
        let length = self.length?;
        let (hem, _) = curve(unknowns, self.folds);
        let (perimeter, [by_p, by_q, by_s]) = hem.perimeter_gradient();
        Some((perimeter - length, DVector::from_vec(vec![0.0, 0.0, 0.0, by_p, by_q, by_s])))
    }
}
