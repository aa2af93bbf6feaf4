//! Your own model: any residual function, fitted in one call, with standard errors and the story of the fit.

use std::fmt;

use nalgebra::DMatrix;

use super::covariance::Covariance;
use super::differences::Differences;
use super::limits::{Bounds, Limit, State};
use super::loss::Loss;
use super::outcome::{Options, Termination};
use super::problem::Problem;
use super::robust::{Round, check_weights, solve_robust};
use crate::error::Error;

/// How a residual function is fitted. Everything has a default; give what you have.
#[derive(Debug, Clone, PartialEq)]
pub struct FitOptions {
    /// Names of the parameters, for messages and print; `b1`, `b2` … where there are none.
    pub names: Vec<String>,
    /// Free, fixed or bounded, one for each parameter; empty: all free.
    pub limits: Vec<Limit>,
    /// Weight of each residual, 1/variance up to a common factor; empty: all alike. Residuals are given unweighted.
    pub weights: Vec<f64>,
    pub loss: Loss,
    /// The observations, if the residuals are their differences from a model: needed for R² only.
    pub observed: Vec<f64>,
    pub solver: Options,
}

impl Default for FitOptions {
    /// Least squares, all parameters free, all residuals alike; [`Options::thorough`], because nothing is known of the problem.
    fn default() -> Self {
        FitOptions { names: vec![], limits: vec![], weights: vec![], loss: Loss::Squares, observed: vec![], solver: Options::thorough() }
    }
}

/// A parameter found.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    pub name: String,
    pub value: f64,
    /// `None` where it is fixed, at a bound, or not determined; [`Fit::notes`] say which and why.
    pub standard_error: Option<f64>,
    pub state: State,
}

/// A fitted residual function.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    pub parameters: Vec<Parameter>,
    /// Residuals at the end, as the function gives them (unweighted).
    pub residuals: Vec<f64>,
    /// Jacobian at the end, unweighted, residuals × parameters.
    pub jacobian: DMatrix<f64>,
    /// Covariance over the free parameters; `None` where some are not determined.
    pub covariance: Option<Covariance>,
    /// Σ w r².
    pub sum_of_squares: f64,
    /// Residuals of positive weight less free parameters.
    pub degrees_of_freedom: usize,
    /// 1 − Σ w r² / Σ w (y − ȳ)²; `None` without observations, or where they are all alike. For a nonlinear model it is a description, not a test.
    pub r_squared: Option<f64>,
    pub loss: Loss,
    /// Standard deviation of the bulk of the (weighted) residuals, by their median; of a robust loss only.
    pub scale: Option<f64>,
    /// Weight of each residual by the loss, 0…1.
    pub weights: Vec<f64>,
    /// How many residuals weigh less than one half.
    pub downweighted: usize,
    pub termination: Termination,
    /// Residual vectors evaluated by the iteration.
    pub evaluations: usize,
    /// Jacobians evaluated.
    pub jacobians: usize,
    /// Residual vectors evaluated for numeric derivatives.
    pub derivative_evaluations: usize,
    /// How often the iteration was begun anew.
    pub restarts: usize,
    /// Evaluations of each round of reweighting; one round without a robust loss.
    pub rounds: Vec<Round>,
    /// What a reader of the numbers should know, in words.
    pub notes: Vec<String>,
}

impl Fit {
    /// Estimates, in the order of the parameters.
    pub fn values(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.value).collect()
    }

    /// √(Σ w r² / degrees of freedom); `None` where none is left.
    pub fn residual_standard_deviation(&self) -> Option<f64> {
        (0 < self.degrees_of_freedom).then(|| (self.sum_of_squares / self.degrees_of_freedom as f64).sqrt())
    }
}

/// Fits `residuals` (it fills the slice of `count` values at the parameters given) from `start`, with numeric derivatives.
///
/// The function may give anything that is not finite where it is not defined; the step is then shortened. See the
/// [module](super) for an example.
///
/// # Errors
/// [`Error::Unanswerable`] with fewer residuals than parameters, or names, limits, weights or observations that do not fit the problem;
/// [`Error::Invalid`] for a weight that is none. A fit that ends badly is no error: see [`Fit::termination`].
pub fn fit(residuals: impl FnMut(&[f64], &mut [f64]), count: usize, start: &[f64], options: &FitOptions) -> Result<Fit, Error> {
    let differences = Differences::new(count, start, &options.limits);
    finish(&mut Numeric { residuals, count, differences }, start, options)
}

/// The same with the derivatives given: `jacobian` fills the matrix (row = residual, column = parameter) at the parameters given.
///
/// # Errors
/// As [`fit`].
pub fn fit_with_jacobian(
    residuals: impl FnMut(&[f64], &mut [f64]),
    jacobian: impl FnMut(&[f64], &mut DMatrix<f64>),
    count: usize,
    start: &[f64],
    options: &FitOptions,
) -> Result<Fit, Error> {
    finish(&mut Analytic { residuals, jacobian, count }, start, options)
}

fn finish(problem: &mut impl Problem, start: &[f64], options: &FitOptions) -> Result<Fit, Error> {
    let (rows, columns) = (problem.residual_count(), start.len());
    let names: Vec<String> =
        if options.names.is_empty() { (1..=columns).map(|j| format!("b{j}")).collect() } else { options.names.clone() };
    if names.len() != columns {
        return Err(Error::Unanswerable(format!("{} names for {columns} parameters", names.len())));
    }
    if !options.observed.is_empty() && options.observed.len() != rows {
        return Err(Error::Unanswerable(format!("{} observations for {rows} residuals", options.observed.len())));
    }
    for (name, limit) in names.iter().zip(&options.limits) {
        limit.check(name)?;
    }
    if let Some(j) = start.iter().position(|value| !value.is_finite()) {
        return Err(Error::Unanswerable(format!("the start of {} is {}; a finite number is needed", names[j], start[j])));
    }
    Bounds::new(&options.limits, columns)?;
    check_weights(&options.weights, rows)?;
    let solver = options.solver;
    let start = if options.loss == Loss::Squares {
        start.to_vec()
    } else {
        // A loss that forgives needs a start that is nearly right: least squares, then the loss that has one minimum only.
        let plain = solve_robust(problem, start, &options.limits, Loss::Squares, &options.weights, &solver)?.summary;
        let convex = solve_robust(problem, &plain.parameters, &options.limits, Loss::HUBER, &options.weights, &solver)?.summary;
        convex.parameters
    };
    let robust = solve_robust(problem, &start, &options.limits, options.loss, &options.weights, &solver)?;
    let mut notes = Vec::new();
    let labels: Vec<&str> = names.iter().map(String::as_str).collect();
    let covariance = match robust.covariance(options.loss, &options.weights, &labels) {
        Ok(covariance) => Some(covariance),
        Err(reason) => {
            notes.push(format!("no standard errors: {reason}"));
            None
        }
    };
    let summary = robust.summary;
    for (name, state) in names.iter().zip(&summary.states) {
        match state {
            State::AtLower => notes.push(format!("{name} is at its lower bound; the other standard errors hold while it stays there")),
            State::AtUpper => notes.push(format!("{name} is at its upper bound; the other standard errors hold while it stays there")),
            State::Fixed | State::Free => (),
        }
    }
    if options.loss != Loss::Squares && !robust.settled {
        notes.push("the weights of the residuals have not settled".into());
    }
    let weight = |i: usize| options.weights.get(i).copied().unwrap_or(1.0);
    let counted = (0..rows).filter(|&i| 0.0 < weight(i)).count();
    let free = summary.states.iter().filter(|&&s| s == State::Free).count();
    let parameters = names
        .into_iter()
        .enumerate()
        .map(|(j, name)| Parameter {
            name,
            value: summary.parameters[j],
            standard_error: covariance
                .as_ref()
                .filter(|_| summary.states[j] == State::Free && summary.termination.converged())
                .map(|c| c.matrix[(j, j)].sqrt()),
            state: summary.states[j],
        })
        .collect();
    let r_squared = (!options.observed.is_empty()).then(|| {
        let whole: f64 = (0..rows).map(weight).sum();
        let mean = (0..rows).map(|i| weight(i) * options.observed[i]).sum::<f64>() / whole;
        1.0 - summary.sum_of_squares / (0..rows).map(|i| weight(i) * (options.observed[i] - mean).powi(2)).sum::<f64>()
    });
    if covariance.is_some() && !summary.termination.converged() {
        notes.push("no standard errors: the iteration did not converge".into());
    }
    Ok(Fit {
        parameters,
        residuals: summary.residuals,
        jacobian: summary.jacobian,
        covariance,
        sum_of_squares: summary.sum_of_squares,
        degrees_of_freedom: counted.saturating_sub(free),
        r_squared: r_squared.filter(|r| r.is_finite()),
        loss: options.loss,
        scale: (options.loss != Loss::Squares).then_some(robust.scale),
        weights: robust.weights,
        downweighted: robust.downweighted,
        termination: summary.termination,
        evaluations: summary.evaluations,
        jacobians: summary.jacobians,
        derivative_evaluations: summary.derivative_evaluations.max(problem.derivative_evaluations()),
        restarts: summary.restarts,
        rounds: robust.rounds,
        notes,
    })
}

impl fmt::Display for Fit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.termination)?;
        let width = self.parameters.iter().map(|p| p.name.chars().count()).max().unwrap_or(0);
        for parameter in &self.parameters {
            write!(f, "{:width$}  {:>17.9e}  ", parameter.name, parameter.value)?;
            match (parameter.state, parameter.standard_error) {
                (_, Some(error)) => writeln!(f, "± {error:.3e}")?,
                (State::Fixed, None) => writeln!(f, "fixed")?,
                (State::AtLower, None) => writeln!(f, "at its lower bound")?,
                (State::AtUpper, None) => writeln!(f, "at its upper bound")?,
                (State::Free, None) => writeln!(f, "not determined")?,
            }
        }
        write!(f, "sum of squares {:.9e}, {} degrees of freedom", self.sum_of_squares, self.degrees_of_freedom)?;
        if let Some(deviation) = self.residual_standard_deviation() {
            write!(f, ", residual standard deviation {deviation:.6e}")?;
        }
        if let Some(r) = self.r_squared {
            write!(f, ", R² {r:.6}")?;
        }
        writeln!(f)?;
        if let Some(scale) = self.scale {
            writeln!(f, "{}, scale {scale:.6e}, {} of {} downweighted", self.loss, self.downweighted, self.residuals.len())?;
        }
        write!(f, "{} evaluations in {} rounds, {} Jacobians", self.evaluations, self.rounds.len(), self.jacobians)?;
        if 0 < self.derivative_evaluations {
            write!(f, " ({} evaluations for numeric ones)", self.derivative_evaluations)?;
        }
        for note in &self.notes {
            write!(f, "\nnote: {note}")?;
        }
        Ok(())
    }
}

/// Residuals with numeric derivatives.
struct Numeric<F> {
    residuals: F,
    count: usize,
    differences: Differences,
}

impl<F: FnMut(&[f64], &mut [f64])> Problem for Numeric<F> {
    fn residual_count(&self) -> usize {
        self.count
    }

    fn residuals(&mut self, x: &[f64], residuals: &mut [f64]) -> bool {
        (self.residuals)(x, residuals);
        residuals.iter().all(|r| r.is_finite())
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
        self.differences.fill(&mut self.residuals, x, jacobian)
    }

    fn refine(&mut self) -> bool {
        self.differences.refine()
    }

    fn derivative_evaluations(&self) -> usize {
        self.differences.evaluations
    }
}

/// Residuals with derivatives given.
struct Analytic<F, J> {
    residuals: F,
    jacobian: J,
    count: usize,
}

impl<F: FnMut(&[f64], &mut [f64]), J: FnMut(&[f64], &mut DMatrix<f64>)> Problem for Analytic<F, J> {
    fn residual_count(&self) -> usize {
        self.count
    }

    fn residuals(&mut self, x: &[f64], residuals: &mut [f64]) -> bool {
        (self.residuals)(x, residuals);
        residuals.iter().all(|r| r.is_finite())
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
        (self.jacobian)(x, jacobian);
        true
    }
}
