//! Levenberg–Marquardt: from a start to a minimum.

use nalgebra::{DMatrix, DVector};

use super::limits::{Bounds, Limit, State};
use super::outcome::{Options, Summary, Termination};
use super::problem::Problem;
use super::reflections::triangle;
use super::step::Linear;
use crate::error::Error;

/// A column of the Jacobian that has shrunk to this share of the longest it has been says nothing any more: the iterate lies on a plateau.
const PLATEAU: f64 = 1e-7;
/// How a run that ended badly is begun anew, one after the other: the measure of a step, and the first damping.
const CAUTIOUS: [(Metric, f64); 3] = [(Metric::Parameters, 1.0), (Metric::Columns, 1e3), (Metric::Parameters, 1e3)];
/// A parameter that has become small against its start is measured by this share of it.
const LEAST_SIZE: f64 = 1e-3;

/// So many accepted steps in a row without visible gain end the iteration,
const IDLE: usize = 3;
/// … where gain is a gradient below this share of the least so far.
const FALLING: f64 = 0.9;

/// Minimizes half the sum of squared residuals from `start`.
///
/// # Errors
/// [`Error::Unanswerable`] if there are fewer residuals (plus constraint) than parameters. Everything that happens later is in [`Summary::termination`].
pub fn solve(problem: &mut impl Problem, start: &[f64], options: &Options) -> Result<Summary, Error> {
    solve_within(problem, start, &[], options)
}

/// The same with parameters that are fixed or bounded: `limits` has one entry for each parameter, or none where all are free.
///
/// The start is moved into the limits. At a minimum on a bound the projected gradient vanishes; [`Summary::states`] says which bounds are active.
///
/// # Errors
/// [`Error::Unanswerable`] if there are fewer residuals (plus constraint) than parameters to be found, or if a limit allows no number.
pub fn solve_within(problem: &mut impl Problem, start: &[f64], limits: &[Limit], options: &Options) -> Result<Summary, Error> {
    let bounds = Bounds::new(limits, start.len())?;
    let mut start = start.to_vec();
    bounds.clamp(&mut start);
    // Each run gets its share, so that one that crawls along a canyon leaves something for the others.
    let share = Options { evaluation_limit: options.evaluation_limit.div_ceil(options.restarts + 1), ..*options };
    let (mut best, mut plateau) = run(problem, &start, &bounds, &share, Metric::Columns)?;
    for attempt in 0..options.restarts {
        let hopeless = matches!(best.termination, Termination::NotFinite | Termination::Abandoned);
        if hopeless || best.termination.converged() && !plateau {
            break;
        }
        let (metric, caution) = CAUTIOUS[attempt % CAUTIOUS.len()];
        let (mut next, level) = run(problem, &start, &bounds, &Options { initial_damping: caution, ..share }, metric)?;
        let spent = (best.evaluations + next.evaluations, best.jacobians + next.jacobians, attempt + 1);
        let better = next.sum_of_squares < best.sum_of_squares || plateau && !level && next.termination.converged();
        if better && next.termination != Termination::NotFinite {
            std::mem::swap(&mut best, &mut next);
            plateau = level;
        }
        (best.evaluations, best.jacobians, best.restarts) = spent;
    }
    best.derivative_evaluations = problem.derivative_evaluations();
    Ok(best)
}

/// In which measure a step is held short.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Metric {
    /// By what it does to the residuals: each column of the Jacobian counts by the longest it has been (Moré). Usually the best.
    Columns,
    /// Relative to the size of the parameters: where the residuals at the start are absurdly large, their columns say nothing.
    Parameters,
}

/// One run, and whether it ended on a plateau.
fn run(problem: &mut impl Problem, start: &[f64], bounds: &Bounds, options: &Options, metric: Metric) -> Result<(Summary, bool), Error> {
    let (rows, columns) = (problem.residual_count(), start.len());
    let mut x = start.to_vec();
    let mut residuals = vec![0.0; rows];
    let mut jacobian = DMatrix::zeros(rows, columns);
    let mut evaluations = 1;
    let mut jacobians = 1;
    let defined = problem.residuals(&x, &mut residuals) && problem.jacobian(&x, &mut jacobian);
    let mut constraint = problem.constraint(&x);
    let movable: Vec<bool> = (0..columns).map(|j| !bounds.fixed(j)).collect();
    let sought = movable.iter().filter(|&&m| m).count();
    if rows + usize::from(constraint.is_some()) < sought {
        return Err(Error::Unanswerable(format!("{sought} parameters cannot be found from {rows} residuals")));
    }
    let mut cost = half_square(&residuals);
    let mut scale = DVector::from_element(columns, 0.0_f64);
    let mut states: Vec<State> = movable.iter().map(|&m| if m { State::Free } else { State::Fixed }).collect();
    let mut multiplier = None;
    let mut early = None;
    if !defined || !cost.is_finite() || jacobian.iter().any(|j| !j.is_finite()) {
        early = Some(Termination::NotFinite);
    } else if !problem.accept() {
        early = Some(Termination::Abandoned);
    }
    let first_cost = cost;
    let mut damping = options.initial_damping;
    let mut growth = 2.0;
    let mut penalty = 0.0_f64;
    let mut trial = vec![0.0; columns];
    let mut trial_residuals = vec![0.0; rows];
    // Accepted steps in a row that changed nothing but rounding, and the least offset reached on them.
    let mut idle = 0;
    let mut least_offset = f64::INFINITY;
    let mut refined = false;
    let searching = options.offset_tolerance < f64::INFINITY;

    let termination = 'outer: loop {
        if let Some(termination) = early {
            break termination;
        }
        // Scaled columns: the largest norm a column has had (Moré), so that a vanishing column does not blow up its step.
        for (j, column) in jacobian.column_iter().enumerate() {
            scale[j] = scale[j].max(column.norm());
        }
        let unit = match metric {
            Metric::Columns => scale.map(|s| if 0.0 < s { s } else { 1.0 }),
            Metric::Parameters => relative(&jacobian, &x, start),
        };
        let mut scaled = jacobian.clone();
        for (j, mut column) in scaled.column_iter_mut().enumerate() {
            column /= unit[j];
        }
        let mut projected = DVector::from_column_slice(&residuals);
        let gradient = scaled.tr_mul(&projected);
        let triangle = triangle(scaled, projected.as_mut_slice());
        let projected = projected.rows(0, triangle.nrows()).into_owned();

        // The constraint in scaled parameters, and a basis of the directions that leave it and the active bounds alone.
        let scaled_constraint = constraint.as_ref().map(|(value, gradient)| (*value, gradient.component_div(&unit)));
        let mut moving = movable.clone();
        if let Some((_, normal)) = &scaled_constraint {
            multiplier = Some(multiplier_of(normal, &gradient, |j| movable[j] && (!bounds.limited() || bounds.inside(j, x[j]))));
        }
        if bounds.limited() {
            for j in 0..columns {
                let pull = scaled_constraint.as_ref().map_or(0.0, |(_, normal)| multiplier.unwrap_or(0.0) * normal[j]);
                states[j] = bounds.state(j, x[j], gradient[j] - pull);
                moving[j] = states[j] == State::Free;
            }
        }
        let linear = Linear { triangle, projected, constraint: scaled_constraint, unit };
        let free = linear.basis(&moving);
        let Linear { triangle, projected, constraint: scaled_constraint, unit } = &linear;
        let residual_norm = (2.0 * cost).sqrt();
        let free_gradient = free.tr_mul(&gradient);
        let infeasible = scaled_constraint.as_ref().map_or(0.0, |(value, normal)| value.abs() / normal.norm());
        let size = x.iter().zip(unit.iter()).map(|(x, u)| (x * u).powi(2)).sum::<f64>().sqrt();
        let feasible = infeasible <= 1e-12 * size.max(f64::MIN_POSITIVE);
        // Residuals that are rounding noise have no meaningful direction.
        if feasible && residual_norm <= 1e-15 * size {
            break Termination::Exact;
        }
        // Columns are of unit length, so the gradient is as noisy as one residual.
        if feasible
            && largest(&free_gradient) <= options.gradient_tolerance * residual_norm + 8.0 * options.residual_rounding
            && (!searching
                || offset(triangle, &free, projected) <= options.offset_tolerance * residual_norm + 8.0 * options.residual_rounding)
        {
            if !refined && problem.refine() {
                refined = true;
                if problem.jacobian(&x, &mut jacobian) && jacobian.iter().all(|j| j.is_finite()) {
                    jacobians += 1;
                    continue 'outer;
                }
                break Termination::NotFinite;
            }
            break Termination::Gradient;
        }

        // Where the sum of squares no longer tells steps apart the gradient still may: the way goes on while it falls.
        if searching && 0 < idle {
            let offset = offset(triangle, &free, projected);
            if offset < FALLING * least_offset {
                least_offset = offset;
                idle = 0;
            }
        }

        // A step that damping alone has made short says nothing of a minimum: there the gradient must.
        let flat = largest(&free_gradient) <= 1e-6 * residual_norm + 8.0 * options.residual_rounding;
        let mut failures = 0;
        let stop = loop {
            if IDLE <= idle {
                break Termination::Step;
            }
            if options.evaluation_limit <= evaluations {
                break Termination::EvaluationLimit;
            }
            let Some(step) = linear.step(&x, bounds, &moving, damping) else {
                damping = (damping * growth).max(1e-12);
                growth *= 2.0;
                failures += 1;
                if 60 < failures {
                    break Termination::Stalled;
                }
                continue;
            };
            for j in 0..columns {
                trial[j] = x[j] + step[j] / unit[j];
            }
            if bounds.limited() {
                // On a bound to the last bit.
                bounds.clamp(&mut trial);
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
            let model = triangle * &step + projected;
            let reachable = projected.norm_squared();
            let predicted = 0.5 * (reachable - model.norm_squared()) + penalty * violation(&constraint);
            let actual = merit - trial_merit;
            let relative_step = step.norm() / size.max(f64::MIN_POSITIVE);
            // Near the minimum the decrease drowns in rounding: there a step that does not visibly increase the merit is taken. A residual is
            // at least as uncertain as the rounding of the parameters makes it.
            let noise = (options.residual_rounding * (rows as f64).sqrt()).max(if searching { 4.0 } else { 0.0 } * f64::EPSILON * size);
            let rounding = 4.0 * f64::EPSILON * merit.abs() + noise * residual_norm;
            let drowned = actual.abs() <= rounding && predicted.abs() <= rounding.max(1e-12 * merit);
            if defined && trial_merit.is_finite() && (0.0 < actual || drowned) {
                let finite = problem.jacobian(&trial, &mut jacobian) && jacobian.iter().all(|j| j.is_finite());
                jacobians += 1;
                if !finite {
                    // Back to the last good point, whose Jacobian the caller needs.
                    problem.residuals(&x, &mut residuals);
                    problem.jacobian(&x, &mut jacobian);
                    break Termination::NotFinite;
                }
                let worthwhile = problem.accept();
                std::mem::swap(&mut x, &mut trial);
                std::mem::swap(&mut residuals, &mut trial_residuals);
                cost = trial_cost;
                constraint = trial_constraint;
                if !worthwhile {
                    break Termination::Abandoned;
                }
                let gain = if 0.0 < predicted { actual / predicted } else { 1.0 };
                let taken = damping;
                // A gain that drowned in rounding says nothing; so near the minimum the linear model may be trusted.
                damping *= if searching && drowned { 0.1 } else { (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(1.0 / 10.0, 2.0) };
                growth = 2.0;
                idle = if searching && drowned { idle + 1 } else { 0 };
                // Where the offset is asked for it decides: a step may be short by its damping, and estimates surer than its tolerance.
                let settled = !searching && (relative_step <= options.step_tolerance || actual.abs() <= rounding && relative_step <= 1e-11);
                if settled && violation(&constraint) <= 1e-9 * first_cost.max(1.0) {
                    break if flat || taken <= 1.0 { Termination::Step } else { Termination::Stalled };
                }
                continue 'outer;
            }
            failures += 1;
            if relative_step <= options.step_tolerance {
                break if feasible && (flat || damping <= 1.0 && predicted.abs() <= rounding) {
                    Termination::Step
                } else {
                    Termination::Stalled
                };
            }
            if 60 < failures {
                break Termination::Stalled;
            }
            damping = (damping * growth).max(1e-12);
            growth *= 2.0;
        };
        if matches!(stop, Termination::Step | Termination::Stalled) && !refined && problem.refine() {
            refined = true;
            idle = 0;
            // What went wrong by rough derivatives may go well by good ones.
            damping = options.initial_damping;
            growth = 2.0;
            problem.residuals(&x, &mut residuals);
            if problem.jacobian(&x, &mut jacobian) && jacobian.iter().all(|j| j.is_finite()) {
                jacobians += 1;
                continue 'outer;
            }
            break Termination::NotFinite;
        }
        break stop;
    };
    let plateau = jacobian.column_iter().enumerate().any(|(j, column)| movable[j] && column.norm() <= PLATEAU * scale[j]);
    if bounds.limited() && early.is_none() {
        // The last step may have come to a bound, or left one.
        let slope = jacobian.tr_mul(&DVector::from_column_slice(&residuals));
        let pull = constraint.as_ref().map(|(_, normal)| {
            let multiplier = multiplier_of(normal, &slope, |j| bounds.inside(j, x[j]) && movable[j]);
            normal * multiplier
        });
        for j in 0..columns {
            states[j] = bounds.state(j, x[j], slope[j] - pull.as_ref().map_or(0.0, |pull| pull[j]));
        }
    }
    let summary = Summary {
        parameters: x,
        states,
        sum_of_squares: residuals.iter().map(|r| r * r).sum(),
        residuals,
        jacobian,
        constraint_gradient: constraint.map(|(_, gradient)| gradient),
        multiplier,
        termination,
        evaluations,
        jacobians,
        derivative_evaluations: 0,
        restarts: 0,
    };
    Ok((summary, plateau))
}

/// The scale of each parameter by which steps are measured relative to the parameters; the longest column is then of unit length.
fn relative(jacobian: &DMatrix<f64>, x: &[f64], start: &[f64]) -> DVector<f64> {
    let size = |j: usize| {
        let least = LEAST_SIZE * start[j].abs();
        if least == 0.0 && x[j] == 0.0 { 1.0 } else { x[j].abs().max(least) }
    };
    let longest = jacobian.column_iter().enumerate().map(|(j, column)| column.norm() * size(j)).fold(0.0, f64::max);
    DVector::from_fn(x.len(), |j, _| if 0.0 < longest { longest / size(j) } else { 1.0 })
}

/// The Lagrange multiplier that makes the gradient as small as can be over the parameters that may move.
fn multiplier_of(normal: &DVector<f64>, gradient: &DVector<f64>, moves: impl Fn(usize) -> bool) -> f64 {
    let (mut along, mut square) = (0.0, 0.0);
    for j in (0..normal.len()).filter(|&j| moves(j)) {
        along += normal[j] * gradient[j];
        square += normal[j] * normal[j];
    }
    if 0.0 < square { along / square } else { 0.0 }
}

/// Length of the part of the residuals that the free directions can take away.
fn offset(triangle: &DMatrix<f64>, free: &DMatrix<f64>, projected: &DVector<f64>) -> f64 {
    if free.ncols() == 0 {
        return 0.0;
    }
    let mut reachable = projected.clone();
    let reduced = triangle * free;
    let directions = reduced.ncols().min(reduced.nrows());
    reduced.qr().q_tr_mul(&mut reachable);
    reachable.rows(0, directions).norm()
}

fn largest(vector: &DVector<f64>) -> f64 {
    if vector.is_empty() { 0.0 } else { vector.amax() }
}

fn half_square(residuals: &[f64]) -> f64 {
    0.5 * residuals.iter().map(|r| r * r).sum::<f64>()
}
