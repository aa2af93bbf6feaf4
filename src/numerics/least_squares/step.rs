//! One damped step, within the limits and on the constraint.

use nalgebra::{DMatrix, DVector};

use super::limits::Bounds;
use super::reflections::triangle as triangle_of;

/// The linear model of the residuals at an iterate, in scaled parameters.
pub(super) struct Linear {
    /// R of the Jacobian with unit columns.
    pub triangle: DMatrix<f64>,
    /// Qᵀ r.
    pub projected: DVector<f64>,
    /// Value and gradient of the constraint.
    pub constraint: Option<(f64, DVector<f64>)>,
    /// Scale of each parameter: `d = unit · Δx`.
    pub unit: DVector<f64>,
}

impl Linear {
    /// The step that minimizes `|R d + c|² + μ|d|²`, subject to `n·d = −h`, with the parameters not in `moving` held, within the limits from `x`.
    ///
    /// A parameter that would pass its bound stops there, and the others are solved for again.
    pub(super) fn step(&self, x: &[f64], limits: &Bounds, moving: &[bool], damping: f64) -> Option<DVector<f64>> {
        let columns = x.len();
        if !limits.limited() {
            let basis = self.basis(moving);
            return damped_step(&self.triangle, &self.projected, self.constraint.as_ref(), &basis, damping);
        }
        let mut moving = moving.to_vec();
        let mut stopped = DVector::zeros(columns);
        loop {
            let basis = self.basis(&moving);
            let projected = &self.projected + &self.triangle * &stopped;
            let constraint = self.constraint.as_ref().and_then(|(value, normal)| {
                let kept = masked(normal, &moving);
                (0.0 < kept.norm()).then(|| (value + normal.dot(&stopped), kept))
            });
            let step = if basis.ncols() == 0 && constraint.is_none() {
                DVector::zeros(columns)
            } else {
                damped_step(&self.triangle, &projected, constraint.as_ref(), &basis, damping)?
            };
            let mut again = false;
            for j in 0..columns {
                if moving[j]
                    && let Some(bound) = limits.crossed(j, x[j] + step[j] / self.unit[j])
                {
                    moving[j] = false;
                    stopped[j] = (bound - x[j]) * self.unit[j];
                    again = true;
                }
            }
            if !again {
                return Some(step + stopped);
            }
        }
    }

    /// Orthonormal basis of the directions in which the parameters may move without leaving the constraint.
    pub(super) fn basis(&self, moving: &[bool]) -> DMatrix<f64> {
        let columns = moving.len();
        if moving.iter().all(|&m| m) {
            return match &self.constraint {
                Some((_, normal)) => null_space(normal),
                None => DMatrix::identity(columns, columns),
            };
        }
        let free: Vec<usize> = (0..columns).filter(|&j| moving[j]).collect();
        let within = match self.constraint.as_ref().map(|(_, normal)| normal.select_rows(&free)) {
            Some(normal) if 0.0 < normal.norm() => null_space(&normal),
            _ => DMatrix::identity(free.len(), free.len()),
        };
        let mut basis = DMatrix::zeros(columns, within.ncols());
        for (i, &j) in free.iter().enumerate() {
            basis.row_mut(j).copy_from(&within.row(i));
        }
        basis
    }
}

fn masked(vector: &DVector<f64>, kept: &[bool]) -> DVector<f64> {
    DVector::from_fn(vector.len(), |j, _| if kept[j] { vector[j] } else { 0.0 })
}

/// The step that minimizes `|R d + c|² + μ|d|²`, subject to `n·d = −h`, in the directions `free`.
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
    if unknowns == 0 {
        return Some(particular);
    }
    let root = damping.sqrt();
    let mut augmented = DMatrix::zeros(used + unknowns, unknowns);
    augmented.view_mut((0, 0), (used, unknowns)).copy_from(&reduced);
    for j in 0..unknowns {
        augmented[(used + j, j)] = root;
    }
    let mut right = DVector::zeros(used + unknowns);
    right.rows_mut(0, used).copy_from(&(-(projected + triangle * &particular)));
    let solution = triangle_of(augmented, right.as_mut_slice()).solve_upper_triangular(&right.rows(0, unknowns))?;
    let step = particular + free * solution;
    step.iter().all(|s| s.is_finite()).then_some(step)
}

/// An orthonormal basis of the directions perpendicular to `normal`: the columns of its Householder reflection but the first.
pub(super) fn null_space(normal: &DVector<f64>) -> DMatrix<f64> {
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
