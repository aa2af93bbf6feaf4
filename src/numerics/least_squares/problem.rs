//! What is to be minimized: residuals, their derivatives, and at most one equality constraint.

use nalgebra::{DMatrix, DVector};

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

    /// The iteration has come to rest. `true`: derivatives were rough so far and are accurate from now on, so it is worth going on.
    fn refine(&mut self) -> bool {
        false
    }

    /// Residual vectors evaluated for the sake of derivatives so far.
    fn derivative_evaluations(&self) -> usize {
        0
    }
}
