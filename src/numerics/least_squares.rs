//! Nonlinear least squares by Levenberg–Marquardt, with at most one equality constraint.
//!
//! Problem, options, summary and covariance are four things. The step comes from a QR decomposition of the Jacobian with its columns
//! scaled to unit length, never from normal equations; the damping follows the gain ratio (Nielsen, Damping Parameter in Marquardt's
//! Method, IMM-REP-1999-05, DTU). An equality constraint `h(x) = 0` is met in its null space, with an ℓ1 merit function.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::error::Error;

/// A vector of residuals to be made small. Implementors may keep state from one evaluation to the next (warm starts).
pub trait Problem {
    /// Length of the residual vector.
    fn residual_count(&self) -> usize;

    /// Fills `residuals` at `x`. `false`: the problem is not defined there, and the step is shortened.
    fn residuals(&mut self, x: &[f64], residuals: &mut [f64]) -> bool;

    /// Fills the Jacobian (rows = residuals, columns = parameters) at the point of the last call of [`Problem::residuals`].
    fn jacobian(&mut self, x: &[f64], jacobian: &mut DMatrix<f64>) -> bool;

    /// The last evaluated point was taken as the new iterate. `false`: nothing good can come of going on from there.
    fn accept(&mut self) -> bool {
        true
    }

    /// Value and gradient of the equality constraint `h(x) = 0`, if there is one.
    fn constraint(&mut self, _x: &[f64]) -> Option<(f64, DVector<f64>)> {
        None
    }
}

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Largest cosine between the residual vector and any column of the Jacobian; 1e-10 leaves the sum of squares right to about 1e-18.
    pub gradient_tolerance: f64,
    /// Relative length of the last step, in scaled parameters.
    pub step_tolerance: f64,
    /// Evaluations of the residual vector.
    pub evaluation_limit: usize,
    /// Absolute rounding error of one residual, where it is known; 0 leaves relative rounding only. A gradient or a decrease below what this
    /// makes of it is noise.
    pub residual_rounding: f64,
    /// First damping relative to the unit columns: 1e-3 trusts the start moderately.
    pub initial_damping: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options { gradient_tolerance: 1e-10, step_tolerance: 1e-13, evaluation_limit: 200, residual_rounding: 0.0, initial_damping: 1e-3 }
    }
}

/// How the iteration ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Termination {
    /// The gradient vanishes.
    Gradient,
    /// The step is below rounding of the parameters.
    Step,
    /// The residuals vanish to rounding.
    Exact,
    /// No downhill step was found although the gradient does not vanish.
    Stalled,
    EvaluationLimit,
    /// The problem itself gave up: an iterate was where no acceptable minimum can lie.
    Abandoned,
    /// A residual or derivative was not finite at the start or at an iterate.
    NotFinite,
}

impl Termination {
    /// Whether the point reached is a minimum to the asked tolerance.
    pub fn converged(self) -> bool {
        matches!(self, Termination::Gradient | Termination::Step | Termination::Exact)
    }
}

/// Where the iteration ended and what it cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    pub parameters: Vec<f64>,
    pub residuals: Vec<f64>,
    /// Jacobian at the end, residuals × parameters.
    pub jacobian: DMatrix<f64>,
    /// Sum of squared residuals.
    pub sum_of_squares: f64,
    /// Gradient of the constraint at the end, if there is one.
    pub constraint_gradient: Option<DVector<f64>>,
    /// Lagrange multiplier of the constraint: derivative of half the sum of squares by the held value.
    pub multiplier: Option<f64>,
    pub termination: Termination,
    /// Residual vectors evaluated.
    pub evaluations: usize,
    /// Jacobians evaluated.
    pub jacobians: usize,
}

/// Minimizes half the sum of squared residuals from `start`.
///
/// # Errors
/// [`Error::Unanswerable`] if there are fewer residuals (plus constraint) than parameters. Everything that happens later is in [`Summary::termination`].
pub fn solve(problem: &mut impl Problem, start: &[f64], options: &Options) -> Result<Summary, Error> {
    let (rows, columns) = (problem.residual_count(), start.len());
    let mut x = start.to_vec();
    let mut residuals = vec![0.0; rows];
    let mut jacobian = DMatrix::zeros(rows, columns);
    let mut evaluations = 1;
    let mut jacobians = 1;
    let defined = problem.residuals(&x, &mut residuals) && problem.jacobian(&x, &mut jacobian);
    let mut constraint = problem.constraint(&x);
    if rows + usize::from(constraint.is_some()) < columns {
        return Err(Error::Unanswerable(format!("{columns} parameters cannot be found from {rows} residuals")));
    }
    let mut cost = half_square(&residuals);
    let end = |x,
               residuals: Vec<f64>,
               jacobian,
               constraint: Option<(f64, DVector<f64>)>,
               multiplier,
               termination,
               evaluations,
               jacobians| {
        let sum_of_squares = residuals.iter().map(|r| r * r).sum();
        let constraint_gradient = constraint.map(|(_, gradient)| gradient);
        Summary { parameters: x, residuals, jacobian, sum_of_squares, constraint_gradient, multiplier, termination, evaluations, jacobians }
    };
    if !defined || !cost.is_finite() || jacobian.iter().any(|j| !j.is_finite()) {
        return Ok(end(x, residuals, jacobian, constraint, None, Termination::NotFinite, evaluations, jacobians));
    }
    if !problem.accept() {
        return Ok(end(x, residuals, jacobian, constraint, None, Termination::Abandoned, evaluations, jacobians));
    }
    let first_cost = cost;
    let mut scale = DVector::from_element(columns, 0.0_f64);
    let mut damping = options.initial_damping;
    let mut growth = 2.0;
    let mut penalty = 0.0_f64;
    let mut trial = vec![0.0; columns];
    let mut trial_residuals = vec![0.0; rows];
    let mut multiplier = None;

    let termination = 'outer: loop {
        // Scaled columns: the largest norm a column has had (Moré), so that a vanishing column does not blow up its step.
        for (j, column) in jacobian.column_iter().enumerate() {
            scale[j] = scale[j].max(column.norm());
        }
        let unit = scale.map(|s| if 0.0 < s { s } else { 1.0 });
        let mut scaled = jacobian.clone();
        for (j, mut column) in scaled.column_iter_mut().enumerate() {
            column /= unit[j];
        }
        let right = DVector::from_column_slice(&residuals);
        let gradient = scaled.tr_mul(&right);
        let qr = scaled.qr();
        let mut projected = right;
        qr.q_tr_mul(&mut projected);
        let triangle = qr.r();
        let used = triangle.nrows();
        let projected = projected.rows(0, used).into_owned();

        // The constraint in scaled parameters, and a basis of its null space.
        let scaled_constraint = constraint.as_ref().map(|(value, gradient)| (*value, gradient.component_div(&unit)));
        let free = match &scaled_constraint {
            Some((_, normal)) => {
                multiplier = Some(normal.dot(&gradient) / normal.norm_squared());
                null_space(normal)
            }
            None => DMatrix::identity(columns, columns),
        };
        let residual_norm = (2.0 * cost).sqrt();
        let free_gradient = free.tr_mul(&gradient);
        let infeasible = scaled_constraint.as_ref().map_or(0.0, |(value, normal)| value.abs() / normal.norm());
        let size = x.iter().zip(unit.iter()).map(|(x, u)| (x * u).powi(2)).sum::<f64>().sqrt();
        let feasible = infeasible <= 1e-12 * size.max(f64::MIN_POSITIVE);
        // Residuals that are rounding noise have no meaningful direction.
        let exact = residual_norm <= 1e-15 * size;
        if feasible && exact {
            break Termination::Exact;
        }
        // Columns are of unit length, so the gradient is as noisy as one residual.
        if feasible && free_gradient.amax() <= options.gradient_tolerance * residual_norm + 8.0 * options.residual_rounding {
            break Termination::Gradient;
        }

        let mut failures = 0;
        loop {
            if options.evaluation_limit <= evaluations {
                break 'outer Termination::EvaluationLimit;
            }
            let Some(step) = damped_step(&triangle, &projected, scaled_constraint.as_ref(), &free, damping) else {
                damping = (damping * growth).max(1e-12);
                growth *= 2.0;
                failures += 1;
                if 60 < failures {
                    break 'outer Termination::Stalled;
                }
                continue;
            };
            for j in 0..columns {
                trial[j] = x[j] + step[j] / unit[j];
            }
            evaluations += 1;
            let defined = problem.residuals(&trial, &mut trial_residuals);
            let trial_cost = half_square(&trial_residuals);
            let trial_constraint = if defined { problem.constraint(&trial) } else { None };
            // ℓ1 merit: the penalty must exceed the multiplier for its minimum to be the constrained one.
            if let Some(multiplier) = multiplier {
                penalty = penalty.max(2.0 * multiplier.abs());
            }
            let violation = |c: &Option<(f64, DVector<f64>)>| c.as_ref().map_or(0.0, |(value, _)| value.abs());
            let (merit, trial_merit) = (cost + penalty * violation(&constraint), trial_cost + penalty * violation(&trial_constraint));
            // The linear model's cost, by its orthogonal part: what QR cannot reach stays.
            let model = &triangle * &step + &projected;
            let reachable = projected.norm_squared();
            let predicted = 0.5 * (reachable - model.norm_squared()) + penalty * violation(&constraint);
            let actual = merit - trial_merit;
            let relative_step = step.norm() / size.max(f64::MIN_POSITIVE);
            // Near the minimum the decrease drowns in rounding: there a step that does not visibly increase the merit is taken.
            let rounding = 4.0 * f64::EPSILON * merit.abs() + options.residual_rounding * residual_norm * (rows as f64).sqrt();
            let good = defined
                && trial_merit.is_finite()
                && (0.0 < actual || actual.abs() <= rounding && predicted.abs() <= rounding.max(1e-12 * merit));
            if good {
                let finite = problem.jacobian(&trial, &mut jacobian) && jacobian.iter().all(|j| j.is_finite());
                jacobians += 1;
                if !finite {
                    // Back to the last good point, whose Jacobian the caller needs.
                    problem.residuals(&x, &mut residuals);
                    problem.jacobian(&x, &mut jacobian);
                    break 'outer Termination::NotFinite;
                }
                let worthwhile = problem.accept();
                std::mem::swap(&mut x, &mut trial);
                std::mem::swap(&mut residuals, &mut trial_residuals);
                cost = trial_cost;
                constraint = trial_constraint;
                if !worthwhile {
                    break 'outer Termination::Abandoned;
                }
                let gain = if 0.0 < predicted { actual / predicted } else { 1.0 };
                damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(1.0 / 10.0, 2.0);
                growth = 2.0;
                let settled = relative_step <= options.step_tolerance || actual.abs() <= rounding && relative_step <= 1e-11;
                if settled && violation(&constraint) <= 1e-9 * first_cost.max(1.0) {
                    break 'outer Termination::Step;
                }
                continue 'outer;
            }
            failures += 1;
            if relative_step <= options.step_tolerance {
                break 'outer if feasible && free_gradient.amax() <= 1e-6 * residual_norm {
                    Termination::Step
                } else {
                    Termination::Stalled
                };
            }
            if 60 < failures {
                break 'outer Termination::Stalled;
            }
            damping = (damping * growth).max(1e-12);
            growth *= 2.0;
        }
    };
    Ok(end(x, residuals, jacobian, constraint, multiplier, termination, evaluations, jacobians))
}

/// The covariance of the estimates of a finished problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Covariance {
    /// `σ̂² (JᵀJ)⁻¹`, in the constraint's null space if there is one; parameters × parameters.
    pub matrix: DMatrix<f64>,
    /// σ̂², the sum of squares over its degrees of freedom.
    pub variance: f64,
    pub degrees_of_freedom: usize,
    /// Ratio of the largest to the smallest singular value of the Jacobian with unit columns.
    pub condition: f64,
}

/// Scaled covariance `σ̂² (JᵀJ)⁻¹` from the Jacobian at the end of [`solve`].
///
/// # Errors
/// [`Error::Unanswerable`] if no degree of freedom is left, or the Jacobian is rank-deficient; the message names the parameters (by `names`) that
/// are not determined.
pub fn covariance(summary: &Summary, names: &[&str]) -> Result<Covariance, Error> {
    let (rows, columns) = summary.jacobian.shape();
    let held = usize::from(summary.constraint_gradient.is_some());
    let Some(degrees_of_freedom) = (rows + held).checked_sub(columns).filter(|&f| 0 < f) else {
        return Err(Error::Unanswerable(format!("{rows} residuals leave no degree of freedom for the error of {columns} parameters")));
    };
    let norms: Vec<f64> = summary.jacobian.column_iter().map(|c| c.norm()).collect();
    if let Some(j) = norms.iter().position(|&n| n == 0.0 || !n.is_finite()) {
        return Err(Error::Unanswerable(format!("{} does not move the residuals", names[j])));
    }
    let mut scaled = summary.jacobian.clone();
    for (j, mut column) in scaled.column_iter_mut().enumerate() {
        column /= norms[j];
    }
    let unit = DVector::from_vec(norms);
    let free = match &summary.constraint_gradient {
        Some(normal) => null_space(&normal.component_div(&unit)),
        None => DMatrix::identity(columns, columns),
    };
    let triangle = scaled.qr().r() * &free;
    let svd = triangle.svd(false, true);
    let (largest, smallest) = (svd.singular_values.max(), svd.singular_values.min());
    let condition = largest / smallest;
    // Columns are of unit length, so this is the angle to the nearest dependent set: below 1e-8 no digit of the weakest combination is left.
    if !condition.is_finite() || 1e8 < condition {
        let v_t = svd.v_t.expect("asked for");
        let weakest = &free * v_t.row(svd.singular_values.imin()).transpose();
        let involved: Vec<&str> = (0..columns).filter(|&j| 0.3 * weakest.amax() < weakest[j].abs()).map(|j| names[j]).collect();
        return Err(Error::Unanswerable(format!("the points do not determine {} separately", involved.join(", "))));
    }
    let v_t = svd.v_t.expect("asked for");
    let mut inverse = DMatrix::zeros(columns, columns);
    for (row, singular) in v_t.row_iter().zip(svd.singular_values.iter()) {
        let direction = (&free * row.transpose()) / *singular;
        inverse += &direction * direction.transpose();
    }
    let variance = summary.sum_of_squares / degrees_of_freedom as f64;
    let matrix = DMatrix::from_fn(columns, columns, |i, j| variance * inverse[(i, j)] / (unit[i] * unit[j]));
    Ok(Covariance { matrix, variance, degrees_of_freedom, condition })
}

/// The step that minimizes `|R d + c|² + μ|d|²`, subject to `n·d = −h`.
fn damped_step(
    triangle: &DMatrix<f64>,
    projected: &DVector<f64>,
    constraint: Option<&(f64, DVector<f64>)>,
    free: &DMatrix<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    let columns = triangle.ncols();
    let particular = match constraint {
        Some((value, normal)) => normal * (-value / normal.norm_squared()),
        None => DVector::zeros(columns),
    };
    let reduced = triangle * free;
    let (used, unknowns) = reduced.shape();
    let root = damping.sqrt();
    let mut augmented = DMatrix::zeros(used + unknowns, unknowns);
    augmented.view_mut((0, 0), (used, unknowns)).copy_from(&reduced);
    for j in 0..unknowns {
        augmented[(used + j, j)] = root;
    }
    let mut right = DVector::zeros(used + unknowns);
    right.rows_mut(0, used).copy_from(&(-(projected + triangle * &particular)));
    let qr = augmented.qr();
    qr.q_tr_mul(&mut right);
    let solution = qr.r().solve_upper_triangular(&right.rows(0, unknowns))?;
    let step = particular + free * solution;
    step.iter().all(|s| s.is_finite()).then_some(step)
}

/// An orthonormal basis of the directions perpendicular to `normal`: the columns of its Householder reflection but the first.
fn null_space(normal: &DVector<f64>) -> DMatrix<f64> {
    let columns = normal.len();
    let norm = normal.norm();
    if norm == 0.0 {
        return DMatrix::identity(columns, columns);
    }
    let mut mirror = normal / norm;
    let sign = if mirror[0] < 0.0 { -1.0 } else { 1.0 };
    mirror[0] += sign;
    let factor = 2.0 / mirror.norm_squared();
    DMatrix::from_fn(columns, columns - 1, |i, j| f64::from(u8::from(i == j + 1)) - factor * mirror[i] * mirror[j + 1])
}

fn half_square(residuals: &[f64]) -> f64 {
    0.5 * residuals.iter().map(|r| r * r).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y = a exp(b x), with exact data.
    struct Exponential {
        x: Vec<f64>,
        y: Vec<f64>,
        sum_held_at: Option<f64>,
    }

    impl Problem for Exponential {
        fn residual_count(&self) -> usize {
            self.x.len()
        }
        fn residuals(&mut self, p: &[f64], residuals: &mut [f64]) -> bool {
            for (i, r) in residuals.iter_mut().enumerate() {
                *r = p[0] * (p[1] * self.x[i]).exp() - self.y[i];
            }
            true
        }
        fn jacobian(&mut self, p: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
            for (i, &x) in self.x.iter().enumerate() {
                jacobian[(i, 0)] = (p[1] * x).exp();
                jacobian[(i, 1)] = p[0] * x * (p[1] * x).exp();
            }
            true
        }
        fn constraint(&mut self, p: &[f64]) -> Option<(f64, DVector<f64>)> {
            self.sum_held_at.map(|sum| (p[0] + p[1] * p[1] - sum, DVector::from_vec(vec![1.0, 2.0 * p[1]])))
        }
    }

    fn exponential(noise: f64, sum_held_at: Option<f64>) -> Exponential {
        let x: Vec<f64> = (0..20).map(|i| 0.1 * f64::from(i)).collect();
        let y = x.iter().enumerate().map(|(i, x)| 2.0 * (-1.3 * x).exp() + if i % 2 == 0 { noise } else { -noise }).collect();
        Exponential { x, y, sum_held_at }
    }

    #[test]
    fn exact_data_give_the_parameters_to_rounding() {
        let summary = solve(&mut exponential(0.0, None), &[1.0, 0.0], &Options::default()).unwrap();
        assert!(summary.termination.converged(), "{:?}", summary.termination);
        // Rounding of y, 2e-16, times the condition of the problem, about 10.
        assert!((summary.parameters[0] - 2.0).abs() < 1e-13 && (summary.parameters[1] + 1.3).abs() < 1e-13);
    }

    #[test]
    fn the_gradient_vanishes_at_the_end() {
        let summary = solve(&mut exponential(0.1, None), &[1.0, 0.0], &Options::default()).unwrap();
        let gradient = summary.jacobian.transpose() * DVector::from_vec(summary.residuals.clone());
        // The asked cosine, 1e-10, times the norms involved, about 3 and 0.5.
        assert!(summary.termination.converged() && gradient.amax() < 1e-9);
    }

    #[test]
    fn a_held_value_is_met_exactly_and_its_multiplier_is_the_slope_of_the_cost() {
        let held = |sum: f64| solve(&mut exponential(0.1, Some(sum)), &[1.0, -0.5], &Options::default()).unwrap();
        let (middle, low, high) = (held(3.0), held(3.0 - 1e-4), held(3.0 + 1e-4));
        assert!(middle.termination.converged(), "{:?}", middle.termination);
        let [a, b] = middle.parameters[..] else { unreachable!() };
        assert!((a + b * b - 3.0).abs() < 1e-12);
        let slope = 0.5 * (high.sum_of_squares - low.sum_of_squares) / 2e-4;
        // Central difference of a smooth function: h² times its third derivative.
        assert!((middle.multiplier.unwrap() - slope).abs() < 1e-6, "{:?} {slope}", middle.multiplier);
    }

    #[test]
    fn parameters_that_the_data_do_not_tell_apart_have_no_covariance_and_are_named() {
        struct Sum;
        impl Problem for Sum {
            fn residual_count(&self) -> usize {
                5
            }
            fn residuals(&mut self, p: &[f64], residuals: &mut [f64]) -> bool {
                for (i, r) in residuals.iter_mut().enumerate() {
                    *r = p[0] + p[1] + p[2] * i as f64 - if i == 2 { 1.0 } else { 0.0 };
                }
                true
            }
            fn jacobian(&mut self, _p: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
                for i in 0..5 {
                    jacobian.row_mut(i).copy_from_slice(&[1.0, 1.0, i as f64]);
                }
                true
            }
        }
        let summary = solve(&mut Sum, &[0.3, 0.1, 0.0], &Options::default()).unwrap();
        let message = covariance(&summary, &["level", "offset", "slope"]).unwrap_err().to_string();
        assert!(message.contains("level") && message.contains("offset") && !message.contains("slope"), "{message}");
    }

    #[test]
    fn covariance_of_a_straight_line_is_the_textbook_one() {
        struct Line(Vec<f64>);
        impl Problem for Line {
            fn residual_count(&self) -> usize {
                self.0.len()
            }
            fn residuals(&mut self, p: &[f64], residuals: &mut [f64]) -> bool {
                for (i, r) in residuals.iter_mut().enumerate() {
                    *r = p[0] + p[1] * i as f64 - self.0[i];
                }
                true
            }
            fn jacobian(&mut self, _p: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
                for i in 0..self.0.len() {
                    jacobian.row_mut(i).copy_from_slice(&[1.0, i as f64]);
                }
                true
            }
        }
        let summary = solve(&mut Line(vec![1.0, 2.5, 2.0, 4.5, 4.0]), &[0.0, 0.0], &Options::default()).unwrap();
        let covariance = covariance(&summary, &["level", "slope"]).unwrap();
        // Σ(x − x̄)² = 10, Σx² = 30, n = 5.
        let variance = summary.sum_of_squares / 3.0;
        assert!((covariance.matrix[(1, 1)] - variance / 10.0).abs() < 1e-14);
        assert!((covariance.matrix[(0, 0)] - variance * 30.0 / 50.0).abs() < 1e-14);
    }
}
