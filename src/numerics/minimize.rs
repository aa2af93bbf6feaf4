//! Smooth minima, free or under one equality: the only door to argmin.
//!
//! Both solvers are Newton trust-region methods with exact Hessians. The problems have few unknowns (1 … 60), so each step that is not
//! simply Newton's diagonalizes the Hessian and solves its subproblem exactly, which walks off saddles and needs no assumption of convexity.

use std::ops::AddAssign;

use argmin::core::{Error as ArgminError, Executor, IterState, KV, Problem, Solver, State, TerminationReason, TerminationStatus};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Value, gradient and Hessian at one point.
#[derive(Debug, Clone)]
pub struct Expansion {
    pub value: f64,
    pub gradient: DVector<f64>,
    pub hessian: DMatrix<f64>,
}

impl AddAssign for Expansion {
    /// Of the sum of two functions of the same unknowns.
    fn add_assign(&mut self, other: Expansion) {
        self.value += other.value;
        self.gradient += other.gradient;
        self.hessian += other.hessian;
    }
}

/// A twice differentiable function.
pub trait Smooth {
    /// Its expansion at `x`; `None` outside its domain.
    fn expand(&self, x: &DVector<f64>) -> Option<Expansion>;
}

/// When to stop. The unknowns are taken to be of order one.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// A Newton step shorter than this (relative to 1 + ‖x‖) is the last. Convergence is quadratic, so what remains is its square.
    pub step_tolerance: f64,
    /// First trust radius.
    pub radius: f64,
    /// Evaluations of the expansion.
    pub evaluations: u64,
}

impl Default for Options {
    /// 1e-9 leaves an error of 1e-18 in smooth problems; half a radian is where a sine stops being its tangent.
    fn default() -> Self {
        Options { step_tolerance: 1e-9, radius: 0.5, evaluations: 300 }
    }
}

/// How a minimization ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The last Newton step was below tolerance and the Hessian is not indefinite there.
    Converged,
    /// No step improves beyond rounding, yet the tolerance is not met.
    Stalled,
    /// The limit of evaluations was reached.
    EvaluationLimit,
}

/// A minimum, or the best point on the way to one.
#[derive(Debug, Clone)]
pub struct Minimum {
    pub x: DVector<f64>,
    pub at: Expansion,
    pub ending: Ending,
    pub evaluations: usize,
}

impl Minimum {
    /// Lowest eigenvalue of the Hessian: positive at a strict minimum.
    pub fn lowest_curvature(&self) -> f64 {
        self.at.hessian.symmetric_eigenvalues().iter().copied().fold(f64::INFINITY, f64::min)
    }
}

type Iterate = IterState<DVector<f64>, (), (), (), (), f64>;

/// The minimum of `problem` downhill from `start`; `None` if `start` is outside the domain.
pub fn minimize(problem: &impl Smooth, start: DVector<f64>, options: &Options) -> Option<Minimum> {
    let at = problem.expand(&start)?;
    let solver = TrustRegionNewton { at: Some(at), radius: options.radius, tolerance: options.step_tolerance, spent: false };
    let run =
        Executor::new(Borrowed(problem), solver).configure(|state: Iterate| state.param(start).max_iters(options.evaluations)).timer(false);
    // The solver itself returns no errors: what goes wrong is said in the ending.
    let result = run.run().ok()?;
    let evaluations = 1 + result.state.get_iter() as usize;
    let ending = match result.state.get_termination_reason() {
        Some(TerminationReason::SolverConverged) => Ending::Converged,
        Some(TerminationReason::MaxItersReached) => Ending::EvaluationLimit,
        _ => Ending::Stalled,
    };
    let x = result.state.param?;
    Some(Minimum { x, at: result.solver.at?, ending, evaluations })
}

/// A problem lent to argmin, which wants to own one.
struct Borrowed<'a, P>(&'a P);

struct TrustRegionNewton {
    /// Expansion at the current iterate; always there, `Option` only so that it can be moved out.
    at: Option<Expansion>,
    radius: f64,
    tolerance: f64,
    /// The radius fell below what rounding resolves.
    spent: bool,
}

impl<P: Smooth> Solver<Borrowed<'_, P>, Iterate> for TrustRegionNewton {
    fn name(&self) -> &str {
        "trust-region Newton, exact subproblem"
    }

    fn next_iter(&mut self, problem: &mut Problem<Borrowed<'_, P>>, mut state: Iterate) -> Result<(Iterate, Option<KV>), ArgminError> {
        let (Some(x), Some(at)) = (state.take_param(), self.at.take()) else {
            return Ok((state.terminate_with(TerminationReason::SolverExit("no iterate".into())), None));
        };
        let step = trust_step(&at.gradient, &at.hessian, self.radius);
        let length = step.step.norm();
        let trial = &x + &step.step;
        let scale = 1.0 + x.norm();
        let next = problem.problem("expansions", |p| Ok(p.0.expand(&trial)))?;
        // Below this a change of the value is rounding: judge the step by its model alone.
        let noise = 64.0 * f64::EPSILON * at.value.abs();
        let gain = next.as_ref().map(|n| at.value - n.value);
        let ratio =
            gain.map_or(f64::NEG_INFINITY, |gain| if step.predicted <= noise && -noise <= gain { 1.0 } else { gain / step.predicted });
        if !(0.25..).contains(&ratio) {
            self.radius = 0.25 * length;
        } else if 0.75 < ratio && !step.interior {
            self.radius *= 2.0;
        }
        let last = step.interior && length <= self.tolerance * scale;
        let flat = step.interior && step.predicted <= f64::EPSILON * at.value.abs();
        let state = match next {
            Some(next) if 1e-4 < ratio => {
                self.at = Some(next);
                state.param(trial)
            }
            _ => {
                self.at = Some(at);
                self.spent = self.radius <= f64::EPSILON * scale;
                state.param(x)
            }
        };
        let cost = self.at.as_ref().map_or(f64::INFINITY, |at| at.value);
        let state = state.cost(cost);
        Ok((if last || flat { state.terminate_with(TerminationReason::SolverConverged) } else { state }, None))
    }

    fn terminate(&mut self, _: &Iterate) -> TerminationStatus {
        if self.spent {
            return TerminationStatus::Terminated(TerminationReason::SolverExit("no step improves".into()));
        }
        TerminationStatus::NotTerminated
    }
}

struct TrustStep {
    step: DVector<f64>,
    /// Decrease of the quadratic model, ≥ 0.
    predicted: f64,
    /// The plain Newton step of a positive semidefinite Hessian, not cut by the radius.
    interior: bool,
}

/// The exact minimum of g·s + ½ s·H·s over ‖s‖ ≤ radius: the plain Newton step where H is safely positive definite and it is short enough, else by
/// diagonalizing H.
///
/// Source: Conn, Gould & Toint, Trust-Region Methods (2000), section 7.3, with its hard case.
fn trust_step(gradient: &DVector<f64>, hessian: &DMatrix<f64>, radius: f64) -> TrustStep {
    newton_step(gradient, hessian, radius).unwrap_or_else(|| diagonal_step(gradient, hessian, radius))
}

/// A tenth of the time of a diagonalization. `None` where a pivot is so small that the diagonalization has to judge.
fn newton_step(gradient: &DVector<f64>, hessian: &DMatrix<f64>, radius: f64) -> Option<TrustStep> {
    let factor = hessian.clone().cholesky()?;
    let pivots = factor.l_dirty().diagonal();
    if pivots.min().powi(2) <= 1e-10 * pivots.max().powi(2) {
        return None;
    }
    let step = -factor.solve(gradient);
    let predicted = -0.5 * gradient.dot(&step);
    // NaN is not short enough.
    (step.norm() <= radius).then(|| TrustStep { step, predicted: predicted.max(0.0), interior: true })
}

fn diagonal_step(gradient: &DVector<f64>, hessian: &DMatrix<f64>, radius: f64) -> TrustStep {
    let eigen = SymmetricEigen::new(hessian.clone());
    let (e, v) = (&eigen.eigenvalues, &eigen.eigenvectors);
    let g = v.tr_mul(gradient);
    let largest = e.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let lowest = e.imin();
    let shifted =
        |mu: f64| DVector::from_iterator(g.len(), g.iter().zip(e.iter()).map(|(g, e)| if *g == 0.0 { 0.0 } else { -g / (e + mu) }));
    let floor = (-e[lowest]).max(0.0);
    let tiny = 1e-14 * largest;
    let (mut s, mut interior) = if tiny < e[lowest] { (shifted(0.0), true) } else { (shifted(floor + tiny.max(f64::MIN_POSITIVE)), false) };
    if radius < s.norm() {
        interior = false;
        // ‖s(μ)‖ falls from above the radius at `floor` to below it at ‖g‖/radius + floor: bisect, then Newton on 1/‖s‖.
        let (mut low, mut high) = (floor, floor + g.norm() / radius);
        let mut mu = high;
        for _ in 0..100 {
            s = shifted(mu);
            let norm = s.norm();
            if (norm - radius).abs() <= 1e-10 * radius {
                break;
            }
            if radius < norm {
                low = mu
            } else {
                high = mu
            }
            let slope: f64 = s.iter().zip(e.iter()).map(|(s, e)| s * s / (e + mu)).sum::<f64>() / norm.powi(3);
            let next = mu + (1.0 / radius - 1.0 / norm) / slope;
            mu = if low < next && next < high { next } else { 0.5 * (low + high) };
        }
    } else if !interior && e[lowest] < -tiny {
        // Hard case: the shifted step stays inside; go on to the boundary along the direction of lowest curvature.
        let rest = (radius * radius - s.norm_squared()).max(0.0).sqrt();
        s[lowest] += if s[lowest] < 0.0 { -rest } else { rest };
    } else if !interior {
        interior = true;
    }
    let predicted = -s.iter().zip(g.iter().zip(e.iter())).map(|(s, (g, e))| s * (g + 0.5 * e * s)).sum::<f64>();
    TrustStep { step: v * s, predicted: predicted.max(0.0), interior }
}

/// A function to minimize where another one, the constraint, is zero.
pub trait Constrained {
    /// Expansions of the objective and of the constraint at `x`; `None` outside the domain.
    fn expand(&self, x: &DVector<f64>) -> Option<(Expansion, Expansion)>;
}

/// A minimum under a constraint, with its Lagrange multiplier: ∇f = λ ∇c.
#[derive(Debug, Clone)]
pub struct ConstrainedMinimum {
    pub x: DVector<f64>,
    pub objective: Expansion,
    pub constraint: Expansion,
    pub multiplier: f64,
    pub ending: Ending,
    pub evaluations: usize,
}

impl ConstrainedMinimum {
    /// Lowest curvature of the Lagrangian along the constraint: positive at a strict minimum. `None` for a single unknown.
    pub fn lowest_curvature(&self) -> Option<f64> {
        let basis = tangent_basis(&self.constraint.gradient)?;
        let lagrangian = &self.objective.hessian - self.multiplier * &self.constraint.hessian;
        Some((basis.tr_mul(&lagrangian) * &basis).symmetric_eigenvalues().iter().copied().fold(f64::INFINITY, f64::min))
    }
}

/// The minimum of the objective on the constraint, downhill from `start`; `None` if `start` is outside the domain.
///
/// Newton's method on the Lagrangian, split into a step back to the constraint and a trust-region step along it; steps are judged by the
/// merit f + ν|c| with a second-order correction. Source: Nocedal & Wright, Numerical Optimization, 2nd ed. (2006), section 18.5.
pub fn minimize_constrained(problem: &impl Constrained, start: DVector<f64>, options: &Options) -> Option<ConstrainedMinimum> {
    let (objective, constraint) = problem.expand(&start)?;
    let solver = ReducedNewton {
        at: Some((objective, constraint)),
        radius: options.radius,
        penalty: 0.0,
        tolerance: options.step_tolerance,
        spent: false,
    };
    let run =
        Executor::new(Borrowed(problem), solver).configure(|state: Iterate| state.param(start).max_iters(options.evaluations)).timer(false);
    let result = run.run().ok()?;
    let evaluations = 1 + result.problem.counts.get("expansions").copied().unwrap_or(0) as usize;
    let ending = match result.state.get_termination_reason() {
        Some(TerminationReason::SolverConverged) => Ending::Converged,
        Some(TerminationReason::MaxItersReached) => Ending::EvaluationLimit,
        _ => Ending::Stalled,
    };
    let x = result.state.param?;
    let (objective, constraint) = result.solver.at?;
    let multiplier = multiplier(&objective.gradient, &constraint.gradient);
    Some(ConstrainedMinimum { x, objective, constraint, multiplier, ending, evaluations })
}

/// Least squares of ∇f = λ∇c for λ.
fn multiplier(objective: &DVector<f64>, constraint: &DVector<f64>) -> f64 {
    objective.dot(constraint) / constraint.norm_squared()
}

/// Orthonormal columns perpendicular to `normal`; `None` where there is no room.
fn tangent_basis(normal: &DVector<f64>) -> Option<DMatrix<f64>> {
    let n = normal.len();
    if n < 2 {
        return None;
    }
    // The Householder reflection that maps the normal onto an axis maps the other axes onto the tangent space.
    let unit = normal / normal.norm();
    let axis = unit.iamax();
    let mut mirror = unit.clone();
    mirror[axis] += unit[axis].signum();
    let reflection = DMatrix::identity(n, n) - &mirror * mirror.transpose() * (2.0 / mirror.norm_squared());
    Some(reflection.remove_column(axis))
}

struct ReducedNewton {
    at: Option<(Expansion, Expansion)>,
    radius: f64,
    penalty: f64,
    tolerance: f64,
    spent: bool,
}

impl<P: Constrained> Solver<Borrowed<'_, P>, Iterate> for ReducedNewton {
    fn name(&self) -> &str {
        "reduced Newton on one equality"
    }

    fn next_iter(&mut self, problem: &mut Problem<Borrowed<'_, P>>, mut state: Iterate) -> Result<(Iterate, Option<KV>), ArgminError> {
        let (Some(x), Some((f, c))) = (state.take_param(), self.at.take()) else {
            return Ok((state.terminate_with(TerminationReason::SolverExit("no iterate".into())), None));
        };
        let lambda = multiplier(&f.gradient, &c.gradient);
        self.penalty = self.penalty.max(2.0 * lambda.abs());
        let lagrangian = &f.hessian - lambda * &c.hessian;
        let mut normal = &c.gradient * (-c.value / c.gradient.norm_squared());
        let reach = 0.8 * self.radius;
        let cut = reach < normal.norm();
        if cut {
            normal *= reach / normal.norm();
        }
        let mut step = normal.clone();
        let mut interior = !cut;
        if let Some(basis) = tangent_basis(&c.gradient) {
            let gradient = basis.tr_mul(&(&f.gradient + &lagrangian * &normal));
            let rest = (self.radius * self.radius - normal.norm_squared()).sqrt();
            let tangential = trust_step(&gradient, &(basis.tr_mul(&lagrangian) * &basis), rest);
            interior &= tangential.interior;
            step += &basis * tangential.step;
        }
        let merit = |f: f64, c: f64, penalty: f64| f + penalty * c.abs();
        let model = |s: &DVector<f64>| f.gradient.dot(s) + 0.5 * s.dot(&(&lagrangian * s));
        let linear = c.value + c.gradient.dot(&step);
        // Enough penalty that restoring the constraint pays for what it costs.
        let restored = c.value.abs() - linear.abs();
        if 0.0 < restored {
            self.penalty = self.penalty.max(2.0 * model(&step).max(0.0) / restored);
        }
        let now = merit(f.value, c.value, self.penalty);
        let predicted = -model(&step) + self.penalty * restored;
        let noise = 64.0 * f64::EPSILON * (f.value.abs() + self.penalty * x.norm() * c.gradient.norm());
        let judge = |trial: &Option<(Expansion, Expansion)>, penalty: f64| {
            trial.as_ref().map_or(f64::NEG_INFINITY, |(f, c)| {
                let gain = now - merit(f.value, c.value, penalty);
                if predicted <= noise && -noise <= gain { 1.0 } else { gain / predicted }
            })
        };
        let mut trial = &x + &step;
        let mut next = problem.problem("expansions", |p| Ok(p.0.expand(&trial)))?;
        let mut ratio = judge(&next, self.penalty);
        if ratio < 0.1
            && let Some((_, bent)) = &next
        {
            // The constraint curves away from its tangent: step back onto it before judging (second-order correction).
            let corrected = &trial - &c.gradient * ((bent.value - linear) / c.gradient.norm_squared());
            let again = problem.problem("expansions", |p| Ok(p.0.expand(&corrected)))?;
            let second = judge(&again, self.penalty);
            if ratio < second {
                (trial, next, ratio) = (corrected, again, second);
            }
        }
        let length = step.norm();
        let scale = 1.0 + x.norm();
        if !(0.25..).contains(&ratio) {
            self.radius = 0.25 * length;
        } else if 0.75 < ratio && !interior {
            self.radius *= 2.0;
        }
        let last = interior && length <= self.tolerance * scale;
        let state = match next {
            Some(next) if 1e-4 < ratio => {
                self.at = Some(next);
                state.param(trial)
            }
            _ => {
                self.at = Some((f, c));
                self.spent = self.radius <= f64::EPSILON * scale;
                state.param(x)
            }
        };
        let cost = self.at.as_ref().map_or(f64::INFINITY, |(f, _)| f.value);
        let state = state.cost(cost);
        Ok((if last { state.terminate_with(TerminationReason::SolverConverged) } else { state }, None))
    }

    fn terminate(&mut self, _: &Iterate) -> TerminationStatus {
        if self.spent {
            return TerminationStatus::Terminated(TerminationReason::SolverExit("no step improves".into()));
        }
        TerminationStatus::NotTerminated
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Rosenbrock;

    impl Smooth for Rosenbrock {
        fn expand(&self, x: &DVector<f64>) -> Option<Expansion> {
            let (a, b) = (x[0], x[1]);
            let d = b - a * a;
            Some(Expansion {
                value: (1.0 - a).powi(2) + 100.0 * d * d,
                gradient: DVector::from_vec(vec![-2.0 * (1.0 - a) - 400.0 * a * d, 200.0 * d]),
                hessian: DMatrix::from_row_slice(2, 2, &[2.0 - 400.0 * d + 800.0 * a * a, -400.0 * a, -400.0 * a, 200.0]),
            })
        }
    }

    #[test]
    fn rosenbrock_valley_is_followed_to_its_end() {
        let minimum = minimize(&Rosenbrock, DVector::from_vec(vec![-1.2, 1.0]), &Options::default()).unwrap();
        assert_eq!(minimum.ending, Ending::Converged);
        // Quadratic convergence leaves rounding only.
        assert!((minimum.x - DVector::from_vec(vec![1.0, 1.0])).norm() < 1e-12);
        assert!(minimum.evaluations < 40, "{}", minimum.evaluations);
    }

    /// x⁴/4 − x²/2 + y²/2, undefined past |x| = 3: a saddle at the origin, minima at (±1, 0).
    struct DoubleWell;

    impl Smooth for DoubleWell {
        fn expand(&self, x: &DVector<f64>) -> Option<Expansion> {
            let (a, b) = (x[0], x[1]);
            (a.abs() < 3.0).then(|| Expansion {
                value: 0.25 * a.powi(4) - 0.5 * a * a + 0.5 * b * b,
                gradient: DVector::from_vec(vec![a.powi(3) - a, b]),
                hessian: DMatrix::from_row_slice(2, 2, &[3.0 * a * a - 1.0, 0.0, 0.0, 1.0]),
            })
        }
    }

    #[test]
    fn newton_step_is_that_of_the_diagonalization() {
        let hessian = DMatrix::from_fn(6, 6, |i, j| ((i * j) as f64).cos() + if i == j { 8.0 } else { 0.0 });
        let hessian = 0.5 * (&hessian + hessian.transpose());
        let gradient = DVector::from_fn(6, |i, _| (i as f64 + 0.3).sin());
        let (fast, exact) = (newton_step(&gradient, &hessian, 1.0).unwrap(), diagonal_step(&gradient, &hessian, 1.0));
        assert!(exact.interior && (fast.step - &exact.step).norm() < 1e-14 && (fast.predicted - exact.predicted).abs() < 1e-14);
        // Too long, and not positive definite.
        assert!(newton_step(&gradient, &hessian, 0.5 * exact.step.norm()).is_none());
        assert!(newton_step(&gradient, &(hessian - DMatrix::identity(6, 6) * 9.0), 1.0).is_none());
    }

    #[test]
    fn saddle_is_left_even_from_its_very_top() {
        let minimum = minimize(&DoubleWell, DVector::zeros(2), &Options::default()).unwrap();
        assert_eq!(minimum.ending, Ending::Converged);
        assert!((minimum.x[0].abs() - 1.0).abs() < 1e-12 && minimum.x[1].abs() < 1e-12);
        assert!((minimum.lowest_curvature() - 1.0).abs() < 1e-10);
    }

    #[test]
    fn edge_of_the_domain_is_not_crossed_and_a_start_outside_has_no_answer() {
        let wide = Options { radius: 50.0, ..Options::default() };
        let minimum = minimize(&DoubleWell, DVector::from_vec(vec![0.1, 40.0]), &wide).unwrap();
        assert!((minimum.x[0] - 1.0).abs() < 1e-12);
        assert!(minimize(&DoubleWell, DVector::from_vec(vec![3.5, 0.0]), &wide).is_none());
    }

    /// x·y on the unit circle: least −1/2 at (1, −1)/√2, with λ = −1/2 for c = x² + y² − 1.
    struct Circle;

    impl Constrained for Circle {
        fn expand(&self, x: &DVector<f64>) -> Option<(Expansion, Expansion)> {
            let (a, b) = (x[0], x[1]);
            let objective = Expansion {
                value: a * b,
                gradient: DVector::from_vec(vec![b, a]),
                hessian: DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 1.0, 0.0]),
            };
            let constraint = Expansion {
                value: a * a + b * b - 1.0,
                gradient: DVector::from_vec(vec![2.0 * a, 2.0 * b]),
                hessian: DMatrix::identity(2, 2) * 2.0,
            };
            Some((objective, constraint))
        }
    }

    #[test]
    fn constrained_minimum_has_the_known_multiplier_from_any_start() {
        for start in [[2.0, 0.3], [0.1, 0.1], [-0.2, 3.0], [1.0, 1.0001]] {
            let minimum = minimize_constrained(&Circle, DVector::from_row_slice(&start), &Options::default()).unwrap();
            assert_eq!(minimum.ending, Ending::Converged, "{start:?}");
            assert!((minimum.objective.value + 0.5).abs() < 1e-12, "{start:?} {:?}", minimum.x);
            assert!((minimum.multiplier + 0.5).abs() < 1e-9);
            // The Lagrangian xy + (x² + y²)/2 has curvature 2 along (1, 1)/√2.
            assert!((minimum.lowest_curvature().unwrap() - 2.0).abs() < 1e-8);
        }
    }
}
