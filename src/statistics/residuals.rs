//! What the residuals say about the model: normal? independent in run order? a run that does not belong?

use serde::Serialize;

use crate::error::Error;
use crate::numerics::double_double::{DoubleDouble, sum};
use crate::statistics::box_wilson::{Analysis, Options, analyse};
use crate::statistics::distribution::{normal_critical, normal_upper, student_two_sided};
use crate::statistics::factorial::FactorialDesign;
use crate::statistics::variances::centred_squares;

/// The Shapiro–Wilk test of normality.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ShapiroWilk {
    pub w: f64,
    pub p: f64,
}

/// Shapiro and Wilk's W of 3 to 5000 values; `None` outside that or if they do not vary.
///
/// On residuals of a fitted model the p-value is approximate: they are slightly correlated and have unequal variances.
///
/// Source: Royston, Algorithm AS R94, Appl. Statist. 44 (1995) 547–551.
pub fn shapiro_wilk(values: &[f64]) -> Option<ShapiroWilk> {
    let n = values.len();
    if !(3..=5000).contains(&n) {
        return None;
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    if sorted[n - 1] <= sorted[0] {
        return None;
    }
    let weights = shapiro_weights(n);
    let mean = sum(sorted.iter().copied()) / DoubleDouble::from(n as f64);
    let centred: Vec<f64> = sorted.iter().map(|&x| (DoubleDouble::from(x) - mean).to_f64()).collect();
    let squares: f64 = centred.iter().map(|x| x * x).sum();
    let weighted: f64 = centred.iter().zip(&weights).map(|(x, a)| x * a).sum();
    let w = (weighted * weighted / squares).min(1.0);
    let size = n as f64;
    let p = if n == 3 {
        // Exact for three values.
        let smallest = 0.75_f64.sqrt().asin();
        (6.0 / std::f64::consts::PI * (w.sqrt().asin() - smallest)).clamp(0.0, 1.0)
    } else {
        let (mut y, m, s) = if n <= 11 {
            let gamma = polynomial(&[-2.273, 0.459], size);
            let y = (1.0 - w).ln();
            if y >= gamma {
                return Some(ShapiroWilk { w, p: 1e-99 });
            }
            (
                -(gamma - y).ln(),
                polynomial(&[0.544, -0.39978, 0.025054, -6.714e-4], size),
                polynomial(&[1.3822, -0.77857, 0.062767, -0.0020322], size).exp(),
            )
        } else {
            let log = size.ln();
            (
                (1.0 - w).ln(),
                polynomial(&[-1.5861, -0.31082, -0.083751, 0.0038915], log),
                polynomial(&[-0.4803, -0.082676, 0.0030302], log).exp(),
            )
        };
        y = (y - m) / s;
        normal_upper(y)
    };
    Some(ShapiroWilk { w, p })
}

/// Antisymmetric weights of the order statistics, of unit length.
fn shapiro_weights(n: usize) -> Vec<f64> {
    let half = n / 2;
    let mut weights = vec![0.0; n];
    let set = |weights: &mut Vec<f64>, i: usize, a: f64| {
        weights[n - 1 - i] = a;
        weights[i] = -a;
    };
    if n == 3 {
        set(&mut weights, 0, 0.5_f64.sqrt());
        return weights;
    }
    // Blom's approximation to the expected normal order statistics, largest first.
    let m: Vec<f64> = (0..half).map(|i| normal_critical((i as f64 + 1.0 - 0.375) / (n as f64 + 0.25))).collect();
    let squares = 2.0 * m.iter().map(|m| m * m).sum::<f64>();
    let (length, root) = (squares.sqrt(), 1.0 / (n as f64).sqrt());
    let first = polynomial(&[0.0, 0.221157, -0.147981, -2.07119, 4.434685, -2.706056], root) + m[0] / length;
    set(&mut weights, 0, first);
    let (corrected, rest) = if n > 5 {
        let second = polynomial(&[0.0, 0.042981, -0.293762, -1.752461, 5.682633, -3.582633], root) + m[1] / length;
        set(&mut weights, 1, second);
        let rest = (squares - 2.0 * (m[0] * m[0] + m[1] * m[1])) / (1.0 - 2.0 * (first * first + second * second));
        (2, rest)
    } else {
        (1, (squares - 2.0 * m[0] * m[0]) / (1.0 - 2.0 * first * first))
    };
    let scale = rest.sqrt();
    (corrected..half).for_each(|i| set(&mut weights, i, m[i] / scale));
    weights
}

fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Durbin and Watson's d of residuals in run order: near 2 if neighbours are unrelated, towards 0 if they drift together, towards 4 if they
/// alternate. `None` with fewer than two residuals or if all are 0.
///
/// Source: Durbin & Watson, Biometrika 37 (1950) 409–428.
pub fn durbin_watson(residuals: &[f64]) -> Option<f64> {
    let squares: f64 = sum(residuals.iter().map(|e| e * e)).to_f64();
    let steps: f64 = sum(residuals.windows(2).map(|pair| (pair[1] - pair[0]).powi(2))).to_f64();
    (residuals.len() > 1 && squares > 0.0).then(|| steps / squares)
}

/// Correlation of each value with the next, `Σ (xᵢ − x̄)(xᵢ₊₁ − x̄)/Σ (xᵢ − x̄)²`; `None` if they do not vary.
///
/// Source: Box, Jenkins & Reinsel, Time Series Analysis (3rd ed., 1994), section 2.1.5.
pub fn lag_one_autocorrelation(values: &[f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let (mean, squares) = centred_squares(values);
    let centred: Vec<DoubleDouble> = values.iter().map(|&x| DoubleDouble::from(x) - mean).collect();
    let products: DoubleDouble = centred.windows(2).map(|pair| pair[0] * pair[1]).sum();
    (squares.to_f64() > 0.0).then(|| (products / squares).to_f64())
}

/// Probability, under independent normal errors, of a Durbin–Watson d at least as far from its expectation, for residuals `(I − H) y` of the
/// model whose column space has this orthonormal basis (`basis[j][run]`, runs in order).
///
/// By a beta law on (0, 4) with d's exact mean and variance, the approximation that Durbin & Watson (Biometrika 38 (1951) 159–178, section 4)
/// found good to about 0.005 near the usual levels.
pub fn durbin_watson_p(d: f64, basis: &[Vec<f64>]) -> Option<f64> {
    let runs = basis.first().map_or(0, Vec::len);
    let df = runs.checked_sub(basis.len()).filter(|df| *df > 2)? as f64;
    // tr(MA) and tr((MA)²) for M = I − QQᵀ and A the second-difference matrix: A q is cheap, M A stays implicit.
    let difference = |v: &[f64]| -> Vec<f64> {
        let last = v.len() - 1;
        (0..v.len())
            .map(|i| {
                let own = if i == 0 || i == last { v[i] } else { 2.0 * v[i] };
                own - if i > 0 { v[i - 1] } else { 0.0 } - if i < last { v[i + 1] } else { 0.0 }
            })
            .collect()
    };
    let inner = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let applied: Vec<Vec<f64>> = basis.iter().map(|q| difference(q)).collect();
    let size = runs as f64;
    let (trace_a, trace_aa) = (2.0 * (size - 1.0), 2.0 * (3.0 * size - 4.0));
    let trace_b: f64 = basis.iter().zip(&applied).map(|(q, aq)| inner(q, aq)).sum();
    let trace_aab: f64 = applied.iter().map(|aq| inner(aq, aq)).sum();
    let trace_bb: f64 = basis.iter().flat_map(|q| applied.iter().map(|aq| inner(q, aq).powi(2))).sum();
    let first = trace_a - trace_b;
    let second = trace_aa - 2.0 * trace_aab + trace_bb;
    let mean = first / df;
    let variance = 2.0 * (second - first * mean) / (df * (df + 2.0));
    let (scaled, spread) = (mean / 4.0, variance / 16.0);
    let strength = scaled * (1.0 - scaled) / spread - 1.0;
    if strength.is_nan() || strength <= 0.0 {
        return None;
    }
    let (a, b) = (scaled * strength, (1.0 - scaled) * strength);
    let below = crate::statistics::incomplete_beta::regularized(a, b, d / 4.0, 1.0 - d / 4.0);
    Some((2.0 * below.min(1.0 - below)).min(1.0))
}

/// A run that the others do not expect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Suspect {
    /// Index of the run in the design.
    pub run: usize,
    pub deleted_residual: f64,
    /// Of that residual, times the number of runs: each was looked at.
    pub p: f64,
    /// How far the coefficients move without it, in units of their own error; above 1 is much (Cook & Weisberg 1982, section 3.5).
    pub cook_distance: Option<f64>,
}

/// Runs whose deleted residual is too large for chance at level `alpha`, Bonferroni over all runs; the most striking first.
///
/// Source: Cook & Weisberg, Residuals and Influence in Regression (1982), section 2.2.2.
pub fn suspects(analysis: &Analysis, alpha: f64) -> Vec<Suspect> {
    let model = &analysis.full;
    let cook = model.cook_distances();
    let count = model.residuals.len() as f64;
    let mut found: Vec<Suspect> = model
        .deleted_residuals()
        .into_iter()
        .enumerate()
        .filter_map(|(i, residual)| {
            let residual = residual?;
            let p = (count * student_two_sided(residual, model.residual_df as f64 - 1.0)).min(1.0);
            (p < alpha).then(|| Suspect { run: analysis.used_runs[i], deleted_residual: residual, p, cook_distance: cook[i] })
        })
        .collect();
    found.sort_by(|a, b| b.deleted_residual.abs().total_cmp(&a.deleted_residual.abs()));
    found
}

/// All that the residuals of the full model say, at once.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagnostics {
    /// `None` where there are no residuals to look at.
    pub normality: Option<ShapiroWilk>,
    pub durbin_watson: Option<f64>,
    /// Two-sided; small if neighbours in run order are related.
    pub durbin_watson_p: Option<f64>,
    pub suspects: Vec<Suspect>,
}

/// Normality, independence in run order (the order of the design) and suspects at level `alpha`.
///
/// # Errors
/// None that an analysis of this design would not have had.
pub fn diagnose(design: &FactorialDesign, analysis: &Analysis, alpha: f64) -> Result<Diagnostics, Error> {
    if analysis.full.residual_df == 0 || analysis.full.perfect {
        return Ok(Diagnostics { normality: None, durbin_watson: None, durbin_watson_p: None, suspects: Vec::new() });
    }
    let used = design.subset(&analysis.used_runs);
    let basis = used.regressors_of(&used.term_factors(), used.has_centre())?.decompose().basis();
    let d = durbin_watson(&analysis.full.residuals);
    Ok(Diagnostics {
        normality: shapiro_wilk(&analysis.full.residuals),
        durbin_watson: d,
        durbin_watson_p: d.and_then(|d| durbin_watson_p(d, &basis)),
        suspects: suspects(analysis, alpha),
    })
}

/// The analysis without the runs that [`suspects`] finds in the first one, to lay beside it; `None` if there are none.
///
/// # Errors
/// Those of [`analyse`].
pub fn without_suspects(
    design: &FactorialDesign,
    response: &[Option<f64>],
    analysis: &Analysis,
    options: &Options,
) -> Result<Option<Analysis>, Error> {
    let suspects = suspects(analysis, options.alpha);
    if suspects.is_empty() {
        return Ok(None);
    }
    let mut kept = response.to_vec();
    suspects.iter().for_each(|suspect| kept[suspect.run] = None);
    analyse(design, &kept, options).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::variances::mean_and_variance;

    #[test]
    fn large_offsets_cost_nothing_but_the_rounding_of_the_values() {
        // The rules of NIST's NumAcc1 … NumAcc4: mean, standard deviation and autocorrelation follow by hand.
        let alternating = |offset: &str| -> Vec<f64> {
            let parse = |tenth: u32| format!("{offset}.{tenth}").parse().unwrap();
            std::iter::once(parse(2)).chain((0..1000).map(|i| parse(if i % 2 == 0 { 1 } else { 3 }))).collect()
        };
        let cases = [
            (vec![10_000_001.0, 10_000_003.0, 10_000_002.0], 10_000_002.0, 1.0, -0.5, 1e-15),
            (alternating("1"), 1.2, 0.1, -0.999, 1e-14),
            // 1000000.1 is read with an error of up to 6e-11, that is 6e-10 of 0.1.
            (alternating("1000000"), 1_000_000.2, 0.1, -0.999, 1e-9),
            (alternating("10000000"), 10_000_000.2, 0.1, -0.999, 1e-8),
        ];
        for (values, mean, deviation, autocorrelation, tolerance) in cases {
            let (found, variance) = mean_and_variance(&values);
            assert!((found / mean - 1.0_f64).abs() < 1e-15);
            assert!((variance.unwrap().sqrt() / deviation - 1.0_f64).abs() < tolerance, "{:?}", variance.map(f64::sqrt));
            assert!((lag_one_autocorrelation(&values).unwrap() / autocorrelation - 1.0_f64).abs() < tolerance);
        }
    }

    #[test]
    fn normality_of_too_few_or_equal_values_cannot_be_tested() {
        assert_eq!((shapiro_wilk(&[1.0, 2.0]), shapiro_wilk(&[3.0; 10]), durbin_watson(&[0.0, 0.0])), (None, None, None));
    }
}
