//! The orthogonal distance fit of one hem curve of known fold count.
//!
//! Unknowns (x0, y0, φ, p, q, s). Each point's curve parameter is eliminated by projection: the foot point is stationary, so a row of the
//! Jacobian is `−n·∂c/∂θ` at the foot and nothing else (Ahn, Rauh & Warnecke, Pattern Recognition 34 (2001) 2283–2303).

use nalgebra::{DMatrix, DVector};

use super::foot_point::{Foot, centred, follow_all, nearest_within};
use super::limits::Limits;
use crate::error::Error;
use crate::experiment::Point;
use crate::model::hem::{Hem, Placement};
use crate::numerics::lanes::sines_and_cosines;
use crate::numerics::least_squares::{self, Limit, Loss, Options, Problem, Robust, State, Summary};

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
    /// Signed orthogonal distances, m. Those of the summary are multiplied by the roots of the weights.
    pub distances: Vec<f64>,
    pub summary: Summary,
    /// Residual vectors evaluated, restarts included.
    pub evaluations: usize,
}

/// What a fit is held to, besides its points.
#[derive(Debug, Clone, Copy)]
pub struct Conditions<'a> {
    /// Perimeter to hold, m.
    pub length: Option<f64>,
    /// Length of the outline, m: a free fit is abandoned when its curve grows beyond 1.6 times that. Infinity to follow it all the way.
    pub outline_length: f64,
    /// Weight of each point, 1/variance up to a factor; empty: all alike.
    pub weights: &'a [f64],
    pub limits: &'a Limits,
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
    let limits = Limits::default();
    fit_under(points, hem, placement, feet, &Conditions { length, outline_length, weights: &[], limits: &limits }, options)
}

/// The same with weights of the points, and unknowns that are fixed or bounded; the start is moved into the limits.
///
/// # Errors
/// [`Error::Unanswerable`] with fewer points than free unknowns, or a limit that allows no number.
pub fn fit_under(
    points: &[Point],
    hem: Hem,
    placement: Placement,
    feet: Vec<f64>,
    conditions: &Conditions,
    options: &Options,
) -> Result<Fitted, Error> {
    let (mut problem, mut unknowns, limits) = begin(points, hem, placement, feet, conditions);
    problem.roots = conditions.weights.iter().map(|w| w.sqrt()).collect();
    let mut evaluations = 0;
    let options = &known_rounding(points, &hem, options);
    // Feet that move between rounds lower the sum of squares, so this ends; in practice after one round, rarely three.
    for round in 0.. {
        let summary = least_squares::solve_within(&mut problem, &unknowns, limits.as_deref().unwrap_or_default(), options)?;
        evaluations += summary.evaluations;
        let (hem, placement) = curve(&summary.parameters, hem.folds);
        unknowns.clone_from(&summary.parameters);
        let finite = summary.parameters.iter().all(|v| v.is_finite());
        let last = round == LOOKS || !finite || summary.termination == least_squares::Termination::Abandoned;
        if last || !problem.look_again(&hem, &placement) {
            let distances = problem.unweighted(&summary.residuals);
            return Ok(Fitted { hem, placement, feet: problem.feet, distances, summary, evaluations });
        }
    }
    unreachable!("the last round returns")
}

/// The fit under a loss that forgives gross errors, from a curve that is nearly right and the feet of all points on it.
///
/// # Errors
/// As [`fit_under`].
pub fn fit_robustly(
    points: &[Point],
    hem: Hem,
    placement: Placement,
    feet: Vec<f64>,
    conditions: &Conditions,
    loss: Loss,
    options: &Options,
) -> Result<(Hem, Placement, Vec<f64>, Robust), Error> {
    let (mut problem, mut unknowns, limits) = begin(points, hem, placement, feet, conditions);
    let options = &known_rounding(points, &hem, options);
    let mut rounds = Vec::new();
    for look in 0.. {
        let limits = limits.as_deref().unwrap_or_default();
        let mut robust = least_squares::solve_robust(&mut problem, &unknowns, limits, loss, conditions.weights, options)?;
        rounds.append(&mut robust.rounds);
        let (hem, placement) = curve(&robust.summary.parameters, hem.folds);
        unknowns.clone_from(&robust.summary.parameters);
        let finite = unknowns.iter().all(|v| v.is_finite());
        if look == LOOKS || !finite || !problem.look_again(&hem, &placement) {
            robust.rounds = rounds;
            return Ok((hem, placement, problem.feet, robust));
        }
    }
    unreachable!("the last round returns")
}

/// How often nearer feet are looked for.
const LOOKS: usize = 5;

/// The problem, its start within the limits, and the limits in order (`None`: all free).
fn begin<'a>(
    points: &'a [Point],
    hem: Hem,
    placement: Placement,
    mut feet: Vec<f64>,
    conditions: &Conditions,
) -> (Orthogonal<'a>, Vec<f64>, Option<Vec<Limit>>) {
    let mut placement = placement;
    let mut unknowns = vec![placement.x0, placement.y0, placement.phase, hem.p, hem.q, hem.s];
    let limits = (!conditions.limits.none()).then(|| conditions.limits.in_order().to_vec());
    if let Some(limits) = &limits {
        // The curve looks the same turned by a fold: of all its crests the one nearest to where the phase may be.
        let fold = std::f64::consts::TAU / f64::from(hem.folds.max(1));
        let turn = fold * ((limits[2].nearest(placement.phase) - placement.phase) / fold).round();
        placement.phase += turn;
        feet.iter_mut().for_each(|t| *t -= turn);
        unknowns[2] = placement.phase;
        unknowns.iter_mut().zip(limits).for_each(|(value, limit)| *value = limit.nearest(*value));
    }
    let problem = Orthogonal {
        points,
        folds: hem.folds,
        trial: Vec::new(),
        feet,
        length: conditions.length,
        longest: 1.6 * conditions.outline_length,
        iterate: (hem, placement),
        roots: Vec::new(),
    };
    (problem, unknowns, limits)
}

/// The options with the rounding error of a distance: it is the difference of coordinates of this size.
fn known_rounding(points: &[Point], hem: &Hem, options: &Options) -> Options {
    let size = points.iter().map(|p| p.x.abs().max(p.y.abs())).fold(hem.p.abs(), f64::max);
    Options { residual_rounding: 4.0 * f64::EPSILON * size, ..*options }
}

/// How many unknowns were free to move.
pub fn free(states: &[State]) -> usize {
    states.iter().filter(|&&state| state == State::Free).count()
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
    /// Feet at the last evaluated unknowns; none before the first.
    trial: Vec<Foot>,
    /// Feet at the current iterate: where the next search begins.
    feet: Vec<f64>,
    length: Option<f64>,
    /// Perimeter beyond which a free fit is abandoned, m.
    longest: f64,
    /// The curve last evaluated.
    iterate: (Hem, Placement),
    /// Root of each point's weight; empty where all are alike.
    roots: Vec<f64>,
}

impl Orthogonal<'_> {
    /// Distances without the roots of the weights.
    fn unweighted(&self, residuals: &[f64]) -> Vec<f64> {
        if self.roots.is_empty() { residuals.to_vec() } else { residuals.iter().zip(&self.roots).map(|(r, root)| r / root).collect() }
    }

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
        self.trial = follow_all(&hem, &placement, self.points, &self.feet);
        for (i, (foot, residual)) in self.trial.iter().zip(residuals).enumerate() {
            *residual = foot.distance();
            if !residual.is_finite() {
                return false;
            }
            if let Some(root) = self.roots.get(i) {
                *residual *= root;
            }
        }
        true
    }

    fn jacobian(&mut self, unknowns: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
        let phase = unknowns[2];
        if self.trial.is_empty() {
            return false;
        }
        let turns = sines_and_cosines(self.trial.iter().map(|foot| foot.t + phase));
        for (i, (foot, (sin, cos))) in self.trial.iter().zip(turns).enumerate() {
            let local = &foot.local;
            let speed = local.speed();
            // Outward normal in the turning frame.
            let (nr, nt) = (local.velocity.1 / speed, -local.velocity.0 / speed);
            jacobian[(i, 0)] = -(nr * cos - nt * sin);
            jacobian[(i, 1)] = -(nr * sin + nt * cos);
            jacobian[(i, 2)] = nr * local.position.1 - nt * local.position.0;
            jacobian[(i, 3)] = -nr;
            jacobian[(i, 4)] = -nr * local.cos_fold;
            jacobian[(i, 5)] = -nt * local.sin_lean;
            if let Some(root) = self.roots.get(i) {
                jacobian.row_mut(i).scale_mut(*root);
            }
        }
        true
    }

    fn accept(&mut self) -> bool {
        for (foot, trial) in self.feet.iter_mut().zip(&self.trial) {
            *foot = trial.t;
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
