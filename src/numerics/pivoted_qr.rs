//! Orthogonal factorization of a tall matrix, and which of its columns say nothing new.
//!
//! Householder reflections in double-double arithmetic on columns scaled by powers of two (so without rounding). Columns
//! keep their order; one that is a combination of those before it is moved behind the others, so a later column is called dependent, never an
//! earlier one (the limited pivoting of LINPACK's `dqrdc` as statisticians use it: the intercept outranks a main effect, that an interaction).

use super::double_double::DoubleDouble;

/// A column is dependent if what is left of it after the earlier ones is shorter than this part of it.
///
/// The entries are doubles, so an exact dependency shows as a few 1e-16; the hardest certified polynomial (degree 10 on x ∈ (−9, −3)) leaves
/// 5e-11 of its last column.
pub const DEPENDENT: f64 = 1e-14;

/// `A = Q R` on the independent columns of A.
#[derive(Debug, Clone)]
pub struct PivotedQr {
    rows: usize,
    /// Indices of the independent columns, ascending.
    independent: Vec<usize>,
    dependent: Vec<usize>,
    /// Orthonormal columns, one per independent column.
    q: Vec<Vec<DoubleDouble>>,
    /// Upper triangle by columns: `r[j]` has j + 1 entries; in the units of A.
    r: Vec<Vec<DoubleDouble>>,
    /// Of each dependent column, its coefficients in the independent ones.
    combinations: Vec<Vec<f64>>,
}

impl PivotedQr {
    /// Factorizes the matrix with these columns; all columns have `rows` finite entries.
    pub fn new(columns: &[Vec<DoubleDouble>], rows: usize) -> Self {
        let mut reflectors: Vec<Vec<DoubleDouble>> = Vec::new();
        let mut triangle: Vec<Vec<DoubleDouble>> = Vec::new();
        let mut independent = Vec::new();
        let mut dependent = Vec::new();
        let mut dependent_heads = Vec::new();
        for (index, column) in columns.iter().enumerate() {
            debug_assert_eq!(column.len(), rows);
            let scale = power_of_two_near(column.iter().fold(0.0, |most: f64, entry| most.max(entry.abs().to_f64())));
            let mut work: Vec<DoubleDouble> = column.iter().map(|entry| entry.scale(1.0 / scale)).collect();
            for (step, reflector) in reflectors.iter().enumerate() {
                reflect(reflector, step, &mut work);
            }
            let step = reflectors.len();
            let length = norm(&work).to_f64();
            let left = if step < rows { norm(&work[step..]) } else { DoubleDouble::ZERO };
            if left.to_f64() <= DEPENDENT * length || length == 0.0 {
                dependent.push(index);
                dependent_heads.push(work[..step.min(rows)].iter().map(|entry| entry.scale(scale)).collect::<Vec<_>>());
                continue;
            }
            // The sign that avoids cancellation in the first entry of the reflector.
            let diagonal = if work[step].to_f64() > 0.0 { -left } else { left };
            let mut reflector = work[step..].to_vec();
            reflector[0] = reflector[0] - diagonal;
            let reflector_norm = norm(&reflector);
            for entry in &mut reflector {
                *entry = *entry / reflector_norm;
            }
            let mut head: Vec<DoubleDouble> = work[..step].iter().map(|entry| entry.scale(scale)).collect();
            head.push(diagonal.scale(scale));
            triangle.push(head);
            reflectors.push(reflector);
            independent.push(index);
        }
        let q = (0..independent.len())
            .map(|j| {
                let mut unit = vec![DoubleDouble::ZERO; rows];
                unit[j] = DoubleDouble::ONE;
                for (step, reflector) in reflectors.iter().enumerate().rev() {
                    reflect(reflector, step, &mut unit);
                }
                unit
            })
            .collect();
        let mut factorization = PivotedQr { rows, independent, dependent, q, r: triangle, combinations: Vec::new() };
        factorization.combinations = dependent_heads
            .into_iter()
            .map(|mut head| {
                head.resize(factorization.rank(), DoubleDouble::ZERO);
                factorization.back_substitute(head).into_iter().map(DoubleDouble::to_f64).collect()
            })
            .collect();
        factorization
    }

    pub fn rank(&self) -> usize {
        self.independent.len()
    }

    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns of A that are used, ascending.
    pub fn independent(&self) -> &[usize] {
        &self.independent
    }

    /// Columns of A that are combinations of earlier ones, ascending.
    pub fn dependent(&self) -> &[usize] {
        &self.dependent
    }

    /// Coefficients of the i-th dependent column in the independent ones, in their order.
    pub fn combination(&self, i: usize) -> &[f64] {
        &self.combinations[i]
    }

    /// Orthonormal basis of the column space; `basis()[j][row]`.
    pub fn basis(&self) -> &[Vec<DoubleDouble>] {
        &self.q
    }

    /// `Qᵀ b`.
    pub fn project(&self, right: &[DoubleDouble]) -> Vec<DoubleDouble> {
        self.q.iter().map(|column| dot(column, right)).collect()
    }

    /// Least-squares coefficients of the independent columns for `Qᵀ b`.
    pub fn solve(&self, projected: &[DoubleDouble]) -> Vec<DoubleDouble> {
        self.back_substitute(projected.to_vec())
    }

    /// `(AᵀA)⁻¹` on the independent columns, row by row, from R alone.
    pub fn inverse_gram(&self) -> Vec<Vec<DoubleDouble>> {
        let rank = self.rank();
        // Columns of R⁻¹.
        let inverse: Vec<Vec<DoubleDouble>> = (0..rank)
            .map(|j| {
                let mut unit = vec![DoubleDouble::ZERO; rank];
                unit[j] = DoubleDouble::ONE;
                self.back_substitute(unit)
            })
            .collect();
        let mut gram = vec![vec![DoubleDouble::ZERO; rank]; rank];
        for i in 0..rank {
            for k in i..rank {
                let entry = (k..rank).map(|j| inverse[j][i] * inverse[j][k]).sum();
                gram[i][k] = entry;
                gram[k][i] = entry;
            }
        }
        gram
    }

    fn back_substitute(&self, mut right: Vec<DoubleDouble>) -> Vec<DoubleDouble> {
        for j in (0..self.rank()).rev() {
            right[j] = right[j] / self.r[j][j];
            let solved = right[j];
            for (entry, &factor) in right.iter_mut().zip(&self.r[j][..j]) {
                *entry = *entry - factor * solved;
            }
        }
        right
    }
}

/// Σ aᵢ bᵢ.
pub fn dot(a: &[DoubleDouble], b: &[DoubleDouble]) -> DoubleDouble {
    a.iter().zip(b).map(|(&x, &y)| x * y).sum()
}

fn norm(vector: &[DoubleDouble]) -> DoubleDouble {
    dot(vector, vector).sqrt()
}

/// Applies `I − 2 v vᵀ`, v of unit length, to the entries from `step` on.
fn reflect(reflector: &[DoubleDouble], step: usize, vector: &mut [DoubleDouble]) {
    let twice = dot(reflector, &vector[step..]).scale(2.0);
    for (entry, &part) in vector[step..].iter_mut().zip(reflector) {
        *entry = *entry - part * twice;
    }
}

/// So that squares neither overflow nor vanish.
fn power_of_two_near(length: f64) -> f64 {
    if length > 0.0 { 2f64.powi(length.log2().round() as i32) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(values: &[&[f64]]) -> Vec<Vec<DoubleDouble>> {
        values.iter().map(|column| column.iter().copied().map(DoubleDouble::from).collect()).collect()
    }

    #[test]
    fn a_dependent_column_is_named_with_its_combination() {
        let qr = PivotedQr::new(&columns(&[&[1.0, 1.0, 1.0, 1.0], &[1.0, 2.0, 3.0, 4.0], &[3.0, 5.0, 7.0, 9.0], &[0.0, 0.0, 1.0, 5.0]]), 4);
        assert_eq!((qr.independent(), qr.dependent()), (&[0, 1, 3][..], &[2][..]));
        // 1 + 2x, and nothing of a column that comes later.
        for (found, exact) in qr.combination(0).iter().zip([1.0, 2.0, 0.0]) {
            assert!((found - exact).abs() < 1e-28);
        }
    }

    #[test]
    fn the_hilbert_matrix_is_solved_to_the_last_digit() {
        // Condition number 1.6e13 for n = 10: double arithmetic would leave three digits. b is chosen so that every coefficient is 1.
        let n = 10;
        let hilbert: Vec<Vec<DoubleDouble>> =
            (0..n).map(|j| (0..n).map(|i| DoubleDouble::ONE / DoubleDouble::from((i + j + 1) as f64)).collect()).collect();
        let right: Vec<DoubleDouble> = (0..n).map(|i| (0..n).map(|j| hilbert[j][i]).sum()).collect();
        let qr = PivotedQr::new(&hilbert, n);
        assert_eq!(qr.rank(), n);
        for coefficient in qr.solve(&qr.project(&right)) {
            assert!((coefficient.to_f64() - 1.0).abs() < 1e-15);
        }
    }
}
