//! Regression when every response comes with its own standard error: how much scatter is left beyond them?

use serde::Serialize;

use crate::error::Error;
use crate::statistics::distribution::{chi_squared_upper, normal_critical, normal_upper};
use crate::statistics::linear_model::{Decomposition, Regressors};

/// One coefficient; its error holds the responses' own errors and the scatter between runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KnownErrorCoefficient {
    pub term: String,
    pub estimate: f64,
    pub se: f64,
    pub z: f64,
    pub p: f64,
    pub ci_low: f64,
    pub ci_high: f64,
}

/// Weighted regression with weights `1/(τ² + se²)`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KnownErrorRegression {
    pub coefficients: Vec<KnownErrorCoefficient>,
    /// Standard deviation between runs beyond their own errors, τ; 0 if their own errors explain all scatter.
    pub between_runs: f64,
    /// `Σ (residual/se)²` with weights `1/se²`: χ² on `residual_df` if τ = 0.
    pub q: f64,
    /// Probability of a q at least as large if τ = 0; `None` without residual degrees of freedom.
    pub q_p: Option<f64>,
    pub residual_df: usize,
}

/// Regresses responses with known standard errors (> 0, same unit); intervals at 1 − alpha by the normal law.
///
/// τ² is the one at which the weighted squares of the residuals have their expectation, n − rank; 0 if they are below it already. With τ² = 0
/// this is plain weighted least squares with known errors; with τ² ≫ se² it becomes ordinary least squares.
///
/// Source: Paule & Mandel, J. Res. Natl. Bur. Stand. 87 (1982) 377–385; with regressors DerSimonian & Kacker, Contemp. Clin. Trials 28 (2007)
/// 105–114.
///
/// # Errors
/// [`Error::Invalid`] if a standard error is not positive and finite; [`Error::Unanswerable`] if numbers do not match the runs.
pub fn regress(regressors: &Regressors, response: &[f64], standard_errors: &[f64], alpha: f64) -> Result<KnownErrorRegression, Error> {
    if let Some(&value) = standard_errors.iter().find(|se| !(se.is_finite() && **se > 0.0)) {
        return Err(Error::Invalid { quantity: "standard error of a response", value, allowed: "finite and > 0" });
    }
    if !(alpha > 0.0 && alpha < 1.0) {
        return Err(Error::Invalid { quantity: "significance level", value: alpha, allowed: "> 0 and < 1" });
    }
    let decompose = |between: f64| -> Result<Decomposition, Error> {
        let weights: Vec<f64> = standard_errors.iter().map(|se| 1.0 / (between + se * se)).collect();
        regressors.decompose_weighted(&weights)
    };
    let squares = |between: f64| -> Result<f64, Error> { Ok(decompose(between)?.fit(response)?.residual_sum_of_squares) };
    let own = decompose(0.0)?;
    let residual_df = own.rows() - own.rank();
    let q = own.fit(response)?.residual_sum_of_squares;
    let mut between = 0.0;
    if residual_df > 0 && q > residual_df as f64 {
        // The weighted squares fall with τ², and at τ² = s² of the unweighted fit they are at most n − rank.
        let expected = residual_df as f64;
        let (mut low, mut high) = (0.0, regressors.decompose().fit(response)?.residual_sum_of_squares / expected);
        // 60 halvings leave 1e-18 of that.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if squares(middle)? > expected { low = middle } else { high = middle }
        }
        between = 0.5 * (low + high);
    }
    let decomposition = decompose(between)?;
    let critical = normal_critical(0.5 * alpha);
    let model = decomposition.fit(response)?;
    let coefficients = model
        .estimates
        .iter()
        .enumerate()
        .map(|(i, estimate)| {
            let se = decomposition.inverse_gram(i, i).sqrt();
            let z = estimate.estimate / se;
            KnownErrorCoefficient {
                term: estimate.term.clone(),
                estimate: estimate.estimate,
                se,
                z,
                p: (2.0 * normal_upper(z.abs())).min(1.0),
                ci_low: estimate.estimate - critical * se,
                ci_high: estimate.estimate + critical * se,
            }
        })
        .collect();
    let q_p = (residual_df > 0).then(|| chi_squared_upper(q, residual_df as f64));
    Ok(KnownErrorRegression { coefficients, between_runs: between.sqrt(), q, q_p, residual_df })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_errors_give_the_mean_and_the_moment_estimate_of_the_scatter() {
        // Variance 2.5 of 1…5; own errors 0.5: τ² = 2.5 − 0.25, and the mean has √(2.5/5).
        let constant = Regressors::new(vec!["1".into()], vec![vec![1.0; 5]]).unwrap();
        let found = regress(&constant, &[1.0, 2.0, 3.0, 4.0, 5.0], &[0.5; 5], 0.05).unwrap();
        assert!((found.between_runs.powi(2) - 2.25).abs() < 1e-12);
        assert!((found.coefficients[0].estimate - 3.0).abs() < 1e-14 && (found.coefficients[0].se - 0.5_f64.sqrt()).abs() < 1e-12);
        assert!((found.q - 40.0).abs() < 1e-12);
    }

    #[test]
    fn errors_that_explain_the_scatter_leave_none_between_runs() {
        let constant = Regressors::new(vec!["1".into()], vec![vec![1.0; 3]]).unwrap();
        let found = regress(&constant, &[1.0, 2.0, 4.0], &[1.0, 2.0, 4.0], 0.05).unwrap();
        // Weights 1, 1/4, 1/16: mean (1 + 1/2 + 1/4)/(21/16) = 4/3, se √(16/21).
        assert_eq!(found.between_runs, 0.0);
        assert!(
            (found.coefficients[0].estimate - 4.0 / 3.0).abs() < 1e-14
                && (found.coefficients[0].se - (16.0_f64 / 21.0).sqrt()).abs() < 1e-14
        );
    }
}
