//! How sure the estimates of a finished problem are.

use nalgebra::{DMatrix, DVector};

use super::limits::State;
use super::outcome::Summary;
use super::step::null_space;
use crate::error::Error;

/// The covariance of the estimates of a finished problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Covariance {
    /// `σ̂² (JᵀJ)⁻¹` over the free parameters, in the constraint's null space if there is one; parameters × parameters. Rows and columns of
    /// parameters that are fixed or at a bound are zero: it holds under the condition that they stay there.
    pub matrix: DMatrix<f64>,
    /// σ̂², the sum of squares over its degrees of freedom.
    pub variance: f64,
    pub degrees_of_freedom: usize,
    /// Ratio of the largest to the smallest singular value of the Jacobian with unit columns.
    pub condition: f64,
}

/// Scaled covariance `σ̂² (JᵀJ)⁻¹` from the Jacobian at the end of [`solve`](super::solve), over the parameters that were free to move.
///
/// # Errors
/// [`Error::Unanswerable`] if no degree of freedom is left, or the Jacobian is rank-deficient; the message names the parameters (by `names`) that
/// are not determined.
pub fn covariance(summary: &Summary, names: &[&str]) -> Result<Covariance, Error> {
    let rows = summary.jacobian.nrows();
    covariance_of(summary, names, rows)
}

/// The same where only `rows` of the residuals say something (the others have weight 0).
pub(super) fn covariance_of(summary: &Summary, names: &[&str], rows: usize) -> Result<Covariance, Error> {
    let all = summary.jacobian.ncols();
    let free: Vec<usize> = (0..all).filter(|&j| summary.states[j] == State::Free).collect();
    let names: Vec<&str> = free.iter().map(|&j| names[j]).collect();
    let jacobian = if free.len() == all { summary.jacobian.clone() } else { summary.jacobian.select_columns(&free) };
    let normal = summary.constraint_gradient.as_ref().map(|normal| normal.select_rows(&free)).filter(|normal| 0.0 < normal.norm());
    let columns = free.len();
    let held = usize::from(normal.is_some());
    let Some(degrees_of_freedom) = (rows + held).checked_sub(columns).filter(|&f| 0 < f) else {
        return Err(Error::Unanswerable(format!("{rows} residuals leave no degree of freedom for the error of {columns} parameters")));
    };
    let variance = summary.sum_of_squares / degrees_of_freedom as f64;
    if columns == held {
        return Ok(Covariance { matrix: DMatrix::zeros(all, all), variance, degrees_of_freedom, condition: 1.0 });
    }
    let norms: Vec<f64> = jacobian.column_iter().map(|c| c.norm()).collect();
    if let Some(j) = norms.iter().position(|&n| n == 0.0 || !n.is_finite()) {
        return Err(Error::Unanswerable(format!("{} does not move the residuals", names[j])));
    }
    let mut scaled = jacobian;
    for (j, mut column) in scaled.column_iter_mut().enumerate() {
        column /= norms[j];
    }
    let unit = DVector::from_vec(norms);
    let basis = match &normal {
        Some(normal) => null_space(&normal.component_div(&unit)),
        None => DMatrix::identity(columns, columns),
    };
    let triangle = scaled.qr().r() * &basis;
    let svd = triangle.svd(false, true);
    let (largest, smallest) = (svd.singular_values.max(), svd.singular_values.min());
    let condition = largest / smallest;
    // Columns are of unit length, so this is the angle to the nearest dependent set: below 1e-8 no digit of the weakest combination is left.
    if !condition.is_finite() || 1e8 < condition {
        let v_t = svd.v_t.expect("asked for");
        let weakest = &basis * v_t.row(svd.singular_values.imin()).transpose();
        let involved: Vec<&str> = (0..columns).filter(|&j| 0.3 * weakest.amax() < weakest[j].abs()).map(|j| names[j]).collect();
        return Err(Error::Unanswerable(format!("the points do not determine {} separately", involved.join(", "))));
    }
    let v_t = svd.v_t.expect("asked for");
    let mut inverse = DMatrix::zeros(columns, columns);
    for (row, singular) in v_t.row_iter().zip(svd.singular_values.iter()) {
        let direction = (&basis * row.transpose()) / *singular;
        inverse += &direction * direction.transpose();
    }
    let mut matrix = DMatrix::zeros(all, all);
    for (i, &row) in free.iter().enumerate() {
        for (j, &column) in free.iter().enumerate() {
            matrix[(row, column)] = variance * inverse[(i, j)] / (unit[i] * unit[j]);
        }
    }
    Ok(Covariance { matrix, variance, degrees_of_freedom, condition })
}
