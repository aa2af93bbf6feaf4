//! Lack of fit: does a curve leave more than the free outline says the points are in error?
//!
//! Fisher's test of a curve against the free outline that holds it: what the curve leaves beyond the free outline, over what that leaves, each over its degrees of
//! freedom. **Pure error** here is what no smooth outline of the chosen order follows; that it measures the error of the points assumes that their
//! distances are independent. Where they are not (neighbouring pixels, a smoothed contour) errors reach further along the outline, a larger
//! share of them falls on low harmonics, and F is too large; the test is then also given with F divided by that share.

use std::f64::consts::{PI, TAU};

use serde::Serialize;

use crate::statistics::distribution::fisher_upper;

/// Fisher's test of a curve against the free outline.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LackOfFit {
    /// What the curve leaves beyond the free outline, m².
    pub lack_sum_of_squares: f64,
    pub lack_df: usize,
    /// What the free outline leaves, m².
    pub error_sum_of_squares: f64,
    pub error_df: usize,
    pub f: f64,
    /// Of independent distances.
    pub p: f64,
    /// Correlation of neighbouring errors, estimated from what the free outline leaves.
    pub correlation: f64,
    /// By how much errors so correlated raise F where nothing lacks; at least 1.
    pub inflation: f64,
    /// Of F over the inflation, with the degrees of freedom that correlated errors leave: approximate.
    pub p_correlated: f64,
}

/// A curve's sum of squares (m²) and number of unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Left {
    pub sum_of_squares: f64,
    pub unknowns: usize,
}

/// The test of `curve` against a free outline of `order` harmonics that leaves `distances` (m, in order round the outline).
///
/// `None` if the free outline has no more unknowns than the curve, or leaves no degree of freedom.
pub fn lack_of_fit(curve: Left, free: Left, distances: &[f64], order: usize) -> Option<LackOfFit> {
    let lack_df = free.unknowns.checked_sub(curve.unknowns).filter(|df| 0 < *df)?;
    let error_df = distances.len().checked_sub(free.unknowns).filter(|df| 0 < *df)?;
    let lack = (curve.sum_of_squares - free.sum_of_squares).max(0.0);
    let f = lack / lack_df as f64 / (free.sum_of_squares / error_df as f64);
    let correlation = correlation(distances, order);
    let inflation = inflation(correlation, distances.len(), order).max(1.0);
    let p = fisher_upper(f, lack_df as f64, error_df as f64);
    let p_correlated = if 1.0 < inflation {
        let (lack, error) = effective(correlation, distances.len(), order);
        // The correlation is itself an estimate: its error moves the inflation, which widens F as fewer degrees of freedom would.
        let step = 0.01;
        let log = |rho: f64| self::inflation(rho, distances.len(), order).ln();
        let slope = (log(correlation + step) - log(correlation - step)) / (2.0 * step);
        let variance = slope * slope * (1.0 - correlation * correlation) / error_df as f64;
        let error_df = 1.0 / (1.0 / (error * error_df as f64) + 0.5 * variance);
        fisher_upper(f / inflation, lack * lack_df as f64, error_df)
    } else {
        p
    };
    f.is_finite().then_some(LackOfFit {
        lack_sum_of_squares: lack,
        lack_df,
        error_sum_of_squares: free.sum_of_squares,
        error_df,
        f,
        p,
        correlation,
        inflation,
        p_correlated,
    })
}

/// Power of first-order autoregressive errors at harmonic k of n, but for a factor.
fn power(correlation: f64, k: usize, n: usize) -> f64 {
    1.0 / (1.0 - 2.0 * correlation * (TAU * k as f64 / n as f64).cos() + correlation * correlation)
}

/// The first-order correlation of errors of which the harmonics up to `order` were taken out.
///
/// What is left is less alike from point to point than the errors were, and the more so the more was taken: the correlation is the one whose remaining
/// harmonics have the correlation that is seen.
fn correlation(distances: &[f64], order: usize) -> f64 {
    let n = distances.len();
    let square: f64 = distances.iter().map(|d| d * d).sum();
    let products: f64 = (0..n).map(|i| distances[i] * distances[(i + 1) % n]).sum();
    let seen = products / square;
    let remaining = |rho: f64| {
        let sums = (order + 1..=n / 2).map(|k| (power(rho, k, n), (2.0 * PI * k as f64 / n as f64).cos()));
        let (weighed, whole) = sums.fold((0.0, 0.0), |s, (p, c)| (s.0 + p * c, s.1 + p));
        weighed / whole
    };
    // Beyond ±0.95 a few hundred points do not tell correlation from a curve of too low an order.
    let (mut low, mut high) = (-0.95, 0.95);
    if !seen.is_finite() || n / 2 <= order + 1 {
        return 0.0;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if remaining(middle) < seen { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Shares of the degrees of freedom, up to `order` and above, that harmonics of unequal power are worth (Satterthwaite, Biometrics Bull. 2 (1946)
/// 110–114).
fn effective(correlation: f64, n: usize, order: usize) -> (f64, f64) {
    let share = |from: usize, to: usize| {
        let powers = (from..=to).map(|k| power(correlation, k, n));
        let (sum, square) = powers.fold((0.0, 0.0), |s, p| (s.0 + p, s.1 + p * p));
        sum * sum / square / (to + 1 - from) as f64
    };
    (share(1, order.max(1)), share(order + 1, n / 2))
}

/// Mean power of the harmonics up to `order` over that of the others.
fn inflation(correlation: f64, n: usize, order: usize) -> f64 {
    let mean = |from: usize, to: usize| (from..=to).map(|k| power(correlation, k, n)).sum::<f64>() / (to + 1 - from) as f64;
    if n / 2 <= order + 1 { 1.0 } else { mean(1, order.max(1)) / mean(order + 1, n / 2) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_test_is_the_textbook_one() {
        // Montgomery's form by hand: lack 30 on 3, error 40 on 8: F = 10/5 = 2; p = P(F(3, 8) > 2) = 0.19266 (scipy.stats.f.sf(2, 3, 8)).
        let distances: Vec<f64> = (0..12).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 } * (40.0_f64 / 12.0).sqrt()).collect();
        let test =
            lack_of_fit(Left { sum_of_squares: 70.0, unknowns: 1 }, Left { sum_of_squares: 40.0, unknowns: 4 }, &distances, 1).unwrap();
        assert_eq!((test.lack_df, test.error_df), (3, 8));
        assert!((test.f - 2.0).abs() < 1e-12 && (test.p - 0.192_66).abs() < 1e-5, "{test:?}");
    }

    #[test]
    fn alternating_errors_do_not_make_the_test_lenient() {
        let distances: Vec<f64> = (0..60).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let test =
            lack_of_fit(Left { sum_of_squares: 90.0, unknowns: 6 }, Left { sum_of_squares: 60.0, unknowns: 11 }, &distances, 5).unwrap();
        assert!(test.correlation < -0.8 && test.inflation == 1.0 && test.p == test.p_correlated);
    }
}
