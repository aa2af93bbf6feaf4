//! Small systems of linear equations: least squares by normal equations, for a handful of well-scaled unknowns.

/// Normal equations of a least squares problem, filled row by row.
pub(super) struct Normal<const N: usize> {
    pub matrix: [[f64; N]; N],
    pub right: [f64; N],
}

impl<const N: usize> Normal<N> {
    pub fn new() -> Self {
        Normal { matrix: [[0.0; N]; N], right: [0.0; N] }
    }

    /// One more equation `row · unknowns = value`.
    pub fn add(&mut self, row: &[f64; N], value: f64, weight: f64) {
        for i in 0..N {
            let scaled = weight * row[i];
            self.matrix[i].iter_mut().zip(row).for_each(|(sum, other)| *sum += scaled * other);
            self.right[i] += scaled * value;
        }
    }

    /// The unknowns; `None` where the equations do not fix them.
    pub fn solve(&self) -> Option<[f64; N]> {
        solve(self.matrix, self.right)
    }

    /// The inverse of the matrix: times the variance of one equation, the covariance of the unknowns.
    pub fn inverse(&self) -> Option<[[f64; N]; N]> {
        let mut columns = [[0.0; N]; N];
        for (k, column) in columns.iter_mut().enumerate() {
            let mut unit = [0.0; N];
            unit[k] = 1.0;
            *column = solve(self.matrix, unit)?;
        }
        Some(columns)
    }
}

/// Gauss elimination with column pivots.
fn solve<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> Option<[f64; N]> {
    let largest = matrix.iter().flatten().fold(0.0_f64, |a, b| a.max(b.abs()));
    for k in 0..N {
        let pivot = (k..N).max_by(|&a, &b| matrix[a][k].abs().total_cmp(&matrix[b][k].abs()))?;
        let size = matrix[pivot][k].abs();
        if size.is_nan() || size <= 1e-14 * largest {
            return None;
        }
        matrix.swap(k, pivot);
        right.swap(k, pivot);
        for i in k + 1..N {
            let factor = matrix[i][k] / matrix[k][k];
            let above = matrix[k];
            matrix[i][k..].iter_mut().zip(&above[k..]).for_each(|(value, other)| *value -= factor * other);
            right[i] -= factor * right[k];
        }
    }
    for k in (0..N).rev() {
        let known: f64 = (k + 1..N).map(|j| matrix[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / matrix[k][k];
    }
    right.iter().all(|x| x.is_finite()).then_some(right)
}
