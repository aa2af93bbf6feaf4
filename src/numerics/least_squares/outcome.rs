//! When an iteration stops, and where and how it ended.

use std::fmt;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::limits::State;

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Largest cosine between the residual vector and any column of the Jacobian; 1e-10 leaves the sum of squares right to about 1e-18.
    pub gradient_tolerance: f64,
    /// Largest cosine between the residual vector and the space of all columns: how far the end is from the minimum, in standard errors over
    /// √n (Bates & Watts, Technometrics 23 (1981) 179–183). Where columns are nearly dependent this asks far more than the gradient does.
    /// Infinite: not asked, which is right for a handful of well separated parameters.
    pub offset_tolerance: f64,
    /// Relative length of the last step, in scaled parameters.
    pub step_tolerance: f64,
    /// Evaluations of the residual vector, those for numeric derivatives not counted.
    pub evaluation_limit: usize,
    /// Absolute rounding error of one residual, where it is known; 0 leaves relative rounding only. A gradient or a decrease below what this
    /// makes of it is noise.
    pub residual_rounding: f64,
    /// First damping relative to the unit columns: 1e-3 trusts the start moderately.
    pub initial_damping: f64,
    /// Where the iteration ends on a plateau (a parameter has lost all influence) or without converging, it is begun anew so many times, each
    /// time more cautiously; the least sum of squares counts. The evaluations are shared evenly. Not for a problem that must not be thrown back
    /// to its start.
    pub restarts: usize,
}

impl Default for Options {
    /// For a problem within a larger one, whose start is good and whose state follows the iteration.
    fn default() -> Self {
        Options {
            gradient_tolerance: 1e-10,
            offset_tolerance: f64::INFINITY,
            step_tolerance: 1e-13,
            evaluation_limit: 200,
            residual_rounding: 0.0,
            initial_damping: 1e-3,
            restarts: 0,
        }
    }
}

impl Options {
    /// For a problem of which nothing is known: badly scaled, nearly dependent, begun far away. What [`fit`](super::fit) uses unless told.
    pub fn thorough() -> Self {
        Options {
            // What rounding usually allows.
            offset_tolerance: 1e-10,
            // The hardest certified problems need a few hundred in one of four runs.
            evaluation_limit: 2000,
            restarts: 3,
            ..Options::default()
        }
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

impl fmt::Display for Termination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Termination::Gradient => "converged: the gradient vanishes",
            Termination::Step => "converged: the step is below rounding",
            Termination::Exact => "converged: the residuals vanish to rounding",
            Termination::Stalled => "not converged: no step leads downhill although the gradient does not vanish",
            Termination::EvaluationLimit => "not converged: the evaluation limit was reached",
            Termination::Abandoned => "given up: no acceptable minimum lies that way",
            Termination::NotFinite => "not converged: a residual or derivative is not finite",
        })
    }
}

/// Where the iteration ended and what it cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    pub parameters: Vec<f64>,
    /// What became of each parameter: free, fixed, or at a bound.
    pub states: Vec<State>,
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
    /// Residual vectors evaluated, those for numeric derivatives not counted; restarts included.
    pub evaluations: usize,
    /// Jacobians evaluated; restarts included.
    pub jacobians: usize,
    /// Residual vectors evaluated for numeric derivatives; restarts included.
    pub derivative_evaluations: usize,
    /// How often the iteration was begun anew from the start, more cautiously.
    pub restarts: usize,
}
