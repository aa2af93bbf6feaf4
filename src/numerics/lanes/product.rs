//! Products of matrices of which one has its columns in lanes: linear maps of fields that lie eight points to a register.

use super::{Lanes, Vector};
use crate::vectorized;

/// A matrix of plain numbers, row by row.
#[derive(Debug, Clone, Copy)]
pub struct Rows<'a> {
    pub numbers: &'a [f64],
    /// From one row to the next.
    pub stride: usize,
    /// Numbers of a row that count.
    pub inner: usize,
}

vectorized! {
    /// `out = rows · factor`: `out[r·columns + c] = Σ_l rows[r][l] factor[l·columns + c]`, as many rows as `out` has.
    ///
    /// Each sum is taken in the order of l, every product fused with it.
    pub fn product<V>(rows: Rows<'_>, factor: &[Lanes], columns: usize, out: &mut [Lanes]) -> usize {
        let count = out.len().checked_div(columns).unwrap_or(0);
        let mut column = 0;
        while column < columns {
            let wide = if 4 <= columns - column { 4 } else if 2 <= columns - column { 2 } else { 1 };
            let mut row = 0;
            while row < count {
                let tall = if 4 <= count - row { 4 } else { 1 };
                match (tall, wide) {
                    (4, 4) => tile::<V, 4, 4>(rows, factor, columns, row, column, out),
                    (4, 2) => tile::<V, 4, 2>(rows, factor, columns, row, column, out),
                    (4, _) => tile::<V, 4, 1>(rows, factor, columns, row, column, out),
                    (_, 4) => tile::<V, 1, 4>(rows, factor, columns, row, column, out),
                    (_, 2) => tile::<V, 1, 2>(rows, factor, columns, row, column, out),
                    _ => tile::<V, 1, 1>(rows, factor, columns, row, column, out),
                }
                row += tall;
            }
            column += wide;
        }
        count
    }
}

/// R rows of C columns of the product, all sums in registers.
#[inline(always)]
fn tile<V: Vector, const R: usize, const C: usize>(
    rows: Rows<'_>,
    factor: &[Lanes],
    columns: usize,
    row: usize,
    column: usize,
    out: &mut [Lanes],
) {
    let mut sums = [[V::zero(); C]; R];
    let mut lines: [&[f64]; R] = [&[]; R];
    for (r, line) in lines.iter_mut().enumerate() {
        *line = &rows.numbers[(row + r) * rows.stride..][..rows.inner];
    }
    for (l, factors) in factor.chunks_exact(columns).take(rows.inner).enumerate() {
        let factors = &factors[column..column + C];
        for r in 0..R {
            let number = V::all(lines[r][l]);
            for c in 0..C {
                sums[r][c] = number.mul_add(V::of(&factors[c]), sums[r][c]);
            }
        }
    }
    for r in 0..R {
        for c in 0..C {
            out[(row + r) * columns + column + c] = sums[r][c].lanes();
        }
    }
}

vectorized! {
    /// `left · rightᵀ`, n × n, row by row: `out[i·n + j] = Σ left[i][…] right[j][…]`, fields of equal length one after another.
    pub fn inner_products<V>(left: &[Lanes], right: &[Lanes], n: usize) -> Vec<f64> {
        let mut out = vec![0.0; n * n];
        let length = left.len() / n.max(1);
        let mut i = 0;
        while i < n {
            let tall = if 3 <= n - i { 3 } else { 1 };
            let mut j = 0;
            while j < n {
                let wide = if 3 <= n - j { 3 } else { 1 };
                match (tall, wide) {
                    (3, 3) => dots::<V, 3, 3>(left, right, length, (i, j), n, &mut out),
                    (3, _) => dots::<V, 3, 1>(left, right, length, (i, j), n, &mut out),
                    (_, 3) => dots::<V, 1, 3>(left, right, length, (i, j), n, &mut out),
                    _ => dots::<V, 1, 1>(left, right, length, (i, j), n, &mut out),
                }
                j += wide;
            }
            i += tall;
        }
        out
    }
}

#[inline(always)]
fn dots<V: Vector, const R: usize, const C: usize>(
    left: &[Lanes],
    right: &[Lanes],
    length: usize,
    (i, j): (usize, usize),
    n: usize,
    out: &mut [f64],
) {
    let mut sums = [[V::zero(); C]; R];
    let (mut a, mut b): ([&[Lanes]; R], [&[Lanes]; C]) = ([&[]; R], [&[]; C]);
    for (r, a) in a.iter_mut().enumerate() {
        *a = &left[(i + r) * length..][..length];
    }
    for (c, b) in b.iter_mut().enumerate() {
        *b = &right[(j + c) * length..][..length];
    }
    for l in 0..length {
        for r in 0..R {
            let own = V::of(&a[r][l]);
            for c in 0..C {
                sums[r][c] = own.mul_add(V::of(&b[c][l]), sums[r][c]);
            }
        }
    }
    for r in 0..R {
        for c in 0..C {
            out[(i + r) * n + j + c] = sums[r][c].sum();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::lanes::WIDTH;

    fn fields(count: usize, phase: f64) -> Vec<Lanes> {
        (0..count).map(|i| Lanes(std::array::from_fn(|lane| (phase + 0.7 * (i * WIDTH + lane) as f64).sin()))).collect()
    }

    #[test]
    fn products_of_any_size_are_the_sums_that_define_them() {
        for (rows, inner, columns) in [(1, 1, 1), (4, 3, 4), (9, 7, 3), (6, 5, 7), (3, 2, 6)] {
            let stride = inner + 2;
            let numbers: Vec<f64> = (0..rows * stride).map(|i| (1.3 * i as f64).cos()).collect();
            let factor = fields(inner * columns, 0.1);
            let mut out = vec![Lanes::ZERO; rows * columns];
            product(Rows { numbers: &numbers, stride, inner }, &factor, columns, &mut out);
            for (i, lanes) in out.iter().enumerate() {
                let (r, c) = (i / columns, i % columns);
                for (lane, found) in lanes.0.iter().enumerate() {
                    let sum = (0..inner).fold(0.0, |sum, l| numbers[r * stride + l].mul_add(factor[l * columns + c].0[lane], sum));
                    assert_eq!(*found, sum, "{rows} × {inner} × {columns}");
                }
            }
        }
    }

    #[test]
    fn inner_products_of_any_number_of_fields_are_the_sums_that_define_them() {
        for n in [1, 2, 3, 5, 7] {
            let length = 5;
            let (left, right) = (fields(n * length, 0.3), fields(n * length, 1.9));
            let found = inner_products(&left, &right, n);
            for (i, found) in found.iter().enumerate() {
                let (a, b) = (&left[i / n * length..][..length], &right[i % n * length..][..length]);
                let sum: f64 = a.iter().zip(b).flat_map(|(a, b)| a.0.iter().zip(b.0).map(|(a, b)| a * b)).sum();
                // The same 40 products of numbers up to 1 in another order.
                assert!((found - sum).abs() < 1e-14, "{n}: {found} {sum}");
            }
        }
    }
}
