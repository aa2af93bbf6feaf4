//! Gauss–Legendre quadrature on the unit interval, and running integrals on its nodes.

use std::f64::consts::PI;
use std::sync::OnceLock;

/// Rules of fewer nodes than this are computed once.
const KEPT: usize = 100;

/// Nodes (ascending) and weights of the `n`-point Gauss–Legendre rule on [0, 1]; exact for polynomials up to degree 2n − 1.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    static RULES: [OnceLock<Vec<(f64, f64)>>; KEPT] = [const { OnceLock::new() }; KEPT];
    RULES.get(n).map_or_else(|| rule(n), |kept| kept.get_or_init(|| rule(n)).clone())
}

/// Newton's iteration on the Legendre polynomial from Tricomi's estimate of its roots: two or three steps reach rounding.
///
/// Source: Davis & Rabinowitz, Methods of Numerical Integration, 2nd ed. (1984), section 2.7.
fn rule(n: usize) -> Vec<(f64, f64)> {
    let order = n as f64;
    let mut rule = vec![(0.0, 0.0); n];
    for i in 0..n {
        let mut x = (PI * (i as f64 + 0.75) / (order + 0.5)).cos() * (1.0 - (order - 1.0) / (8.0 * order * order * order));
        let mut slope = 0.0;
        for _ in 0..8 {
            let (mut last, mut value) = (0.0, 1.0);
            for k in 0..n {
                let k = k as f64;
                (last, value) = (value, ((2.0 * k + 1.0) * x * value - k * last) / (k + 1.0));
            }
            slope = order * (x * value - last) / (x * x - 1.0);
            let step = value / slope;
            x -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        rule[n - 1 - i] = (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope));
    }
    rule
}

/// Row i: weights of `∫₀^{x_i}` on the nodes of [`gauss_legendre`]`(n)`; exact for polynomials below degree n.
pub fn running_integral(n: usize) -> Vec<Vec<f64>> {
    static ROWS: [OnceLock<Vec<Vec<f64>>>; KEPT] = [const { OnceLock::new() }; KEPT];
    ROWS.get(n).map_or_else(|| running(n), |kept| kept.get_or_init(|| running(n)).clone())
}

/// The interpolant in Legendre polynomials is integrated term by term: `∫ P_k = (P_{k+1} − P_{k−1})/(2k + 1)`.
fn running(n: usize) -> Vec<Vec<f64>> {
    let rule = gauss_legendre(n);
    // P_0 … P_n at each node, argument 2x − 1.
    let polynomials: Vec<Vec<f64>> = rule
        .iter()
        .map(|(x, _)| {
            let x = 2.0 * x - 1.0;
            let mut p = vec![1.0, x];
            for k in 1..n {
                let degree = k as f64;
                p.push(((2.0 * degree + 1.0) * x * p[k] - degree * p[k - 1]) / (degree + 1.0));
            }
            p
        })
        .collect();
    let entry = |i: usize, j: usize| {
        (0..n)
            .map(|k| {
                let integral =
                    if k == 0 { 1.0 + polynomials[i][1] } else { (polynomials[i][k + 1] - polynomials[i][k - 1]) / (2.0 * k as f64 + 1.0) };
                0.5 * (2.0 * k as f64 + 1.0) * polynomials[j][k] * integral * rule[j].1
            })
            .sum()
    };
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn running_integral_is_exact_for_polynomials_below_degree_n() {
        for n in [1, 2, 5, 16] {
            let (rule, running) = (gauss_legendre(n), running_integral(n));
            for degree in 0..n as i32 {
                for i in 0..n {
                    let sum: f64 = (0..n).map(|j| running[i][j] * rule[j].0.powi(degree)).sum();
                    let exact = rule[i].0.powi(degree + 1) / f64::from(degree + 1);
                    // Rounding of n² products.
                    assert!((sum - exact).abs() < 1e-13, "n {n}, degree {degree}, node {i}: {sum} {exact}");
                }
            }
        }
    }

    #[test]
    fn rule_is_exact_for_polynomials_of_degree_two_n_minus_one() {
        for n in 1..40 {
            let rule = gauss_legendre(n);
            for degree in [0, 1, n, 2 * n - 1] {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                // Rounding of n additions.
                assert!((sum - 1.0 / (degree as f64 + 1.0)).abs() < 1e-14, "n {n}, degree {degree}: {sum}");
            }
            let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(2 * n as i32)).sum();
            // One degree more is missed by (n!)⁴/((2n+1)(2n)!²): visible up to n = 10.
            assert!(10 < n || 1e-14 < (sum - 1.0 / (2.0 * n as f64 + 1.0)).abs());
        }
    }
}
