//! The triangle of a tall matrix by Householder's reflections, and what they make of a right-hand side.
//!
//! Operation by operation that of `nalgebra`'s QR, eight numbers at a time: the same bits, at a third of the time.

use nalgebra::DMatrix;

use crate::numerics::lanes::{Lanes, Vector, WIDTH};
use crate::vectorized;

/// R of `matrix = Q R`, its diagonal not negative; `right` becomes `Qᵀ right`.
pub(super) fn triangle(mut matrix: DMatrix<f64>, right: &mut [f64]) -> DMatrix<f64> {
    let (rows, columns) = matrix.shape();
    let used = rows.min(columns);
    let mut diagonal = vec![0.0; used];
    if 0 < used {
        reflect_all(matrix.as_mut_slice(), rows, right, &mut diagonal);
    }
    DMatrix::from_fn(used, columns, |i, j| match i.cmp(&j) {
        std::cmp::Ordering::Less => matrix[(i, j)],
        std::cmp::Ordering::Equal => diagonal[i],
        std::cmp::Ordering::Greater => 0.0,
    })
}

vectorized! {
    /// Clears column after column of a matrix (by columns of `rows` entries) below its diagonal.
    fn reflect_all<V>(matrix: &mut [f64], rows: usize, right: &mut [f64], diagonal: &mut [f64]) -> () {
        for (i, length) in diagonal.iter_mut().enumerate() {
            let (left, others) = matrix.split_at_mut(rows * (i + 1));
            let axis = &mut left[rows * i + i..];
            let square = dot::<V>(axis, axis);
            let norm = square.sqrt();
            let sign = if 0.0 <= axis[0] { 1.0 } else { -1.0 };
            let factor = (square + axis[0].abs() * norm) * 2.0;
            *length = norm;
            axis[0] += sign * norm;
            if factor == 0.0 {
                // Nothing to clear. What is below is 0, and what was turned already stays.
                continue;
            }
            divide::<V>(axis, factor.sqrt());
            // Once more, which leaves it of unit length to rounding.
            let again = dot::<V>(axis, axis).sqrt();
            divide::<V>(axis, again);
            for column in others.chunks_exact_mut(rows) {
                reflect::<V>(axis, &mut column[i..], -sign);
            }
            reflect::<V>(axis, &mut right[i..], -sign);
        }
    }
}

/// The eight sums are added in one fixed order, then what is left over.
#[inline(always)]
fn dot<V: Vector>(a: &[f64], b: &[f64]) -> f64 {
    let (mut a, mut b, mut sums) = (a.chunks_exact(WIDTH), b.chunks_exact(WIDTH), V::zero());
    for (a, b) in (&mut a).zip(&mut b) {
        sums = sums + V::read(a) * V::read(b);
    }
    let Lanes([s0, s1, s2, s3, s4, s5, s6, s7]) = sums.lanes();
    let mut sum = 0.0;
    for pair in [s0 + s4, s1 + s5, s2 + s6, s3 + s7] {
        sum += pair;
    }
    for (a, b) in a.remainder().iter().zip(b.remainder()) {
        sum += a * b;
    }
    sum
}

#[inline(always)]
fn divide<V: Vector>(values: &mut [f64], by: f64) {
    let mut eights = values.chunks_exact_mut(WIDTH);
    for eight in &mut eights {
        eight.copy_from_slice(&(V::read(eight) / V::all(by)).lanes().0);
    }
    for value in eights.into_remainder() {
        *value /= by;
    }
}

/// The column mirrored along the unit vector `axis`, times `sign`.
#[inline(always)]
fn reflect<V: Vector>(axis: &[f64], column: &mut [f64], sign: f64) {
    let factor = dot::<V>(axis, column) * (sign * -2.0);
    let (mut along, mut eights) = (axis.chunks_exact(WIDTH), column.chunks_exact_mut(WIDTH));
    for (a, eight) in (&mut along).zip(&mut eights) {
        eight.copy_from_slice(&(V::read(a) * factor + V::read(eight) * sign).lanes().0);
    }
    for (a, value) in along.remainder().iter().zip(eights.into_remainder()) {
        *value = factor * a + sign * *value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    #[test]
    fn triangle_and_right_hand_side_are_those_of_nalgebra_to_the_bit() {
        for (rows, columns) in [(1, 1), (7, 3), (8, 8), (9, 4), (180, 11), (5, 9), (33, 17)] {
            let entry = |i: usize, j: usize| ((3 * i + 7 * j + i * j) as f64 * 0.37).sin();
            let mut matrix = DMatrix::from_fn(rows, columns, entry);
            if 3 < columns {
                // A column that is nothing, and one that is another's double.
                matrix.column_mut(1).fill(0.0);
                matrix.set_column(3, &(matrix.column(0) * 2.0));
            }
            let mut right = DVector::from_fn(rows, |i, _| entry(i, 99));
            let mut expected = right.clone();
            let qr = matrix.clone().qr();
            qr.q_tr_mul(&mut expected);
            assert_eq!(triangle(matrix, right.as_mut_slice()), qr.r(), "{rows} × {columns}");
            assert_eq!(right, expected, "{rows} × {columns}");
        }
    }
}
