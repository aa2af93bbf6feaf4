//! Do all cells scatter alike? Cochran's test for equal numbers of replicates, Brown and Forsythe's for unequal ones.

use crate::numerics::double_double::{DoubleDouble, sum};
use crate::statistics::distribution;

/// Mean of a cell and, from two runs on, its variance with n − 1 degrees of freedom.
pub fn mean_and_variance(values: &[f64]) -> (f64, Option<f64>) {
    let (mean, squares) = centred_squares(values);
    (mean.to_f64(), (values.len() > 1).then(|| (squares / DoubleDouble::from(values.len() as f64 - 1.0)).to_f64()))
}

/// The mean and `Σ (y − mean)²`, both in twice the working precision.
pub(crate) fn centred_squares(values: &[f64]) -> (DoubleDouble, DoubleDouble) {
    let mean = sum(values.iter().copied()) / DoubleDouble::from(values.len() as f64);
    let squares = values.iter().map(|&y| (DoubleDouble::from(y) - mean) * (DoubleDouble::from(y) - mean)).sum();
    (mean, squares)
}

/// Statistic, critical value at `alpha`, p and degrees of freedom of a test that the variances are equal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VarianceTest {
    pub statistic: f64,
    pub critical: f64,
    pub p: f64,
    pub df: (f64, f64),
}

/// Cochran's `G = max s² / Σ s²` of cells with `replicates` ≥ 2 runs each; `None` if no cell scatters.
///
/// `G_crit = F/(F + N − 1)` with F the upper α/N point on (n − 1, (N − 1)(n − 1)): exact where G > ½, otherwise conservative by less than α²/2.
///
/// Source: Cochran, Ann. Eugen. 11 (1941) 47–52.
pub fn cochran(variances: &[f64], replicates: usize, alpha: f64) -> Option<VarianceTest> {
    let cells = variances.len() as f64;
    let total = sum(variances.iter().copied()).to_f64();
    if variances.len() < 2 || replicates < 2 || total <= 0.0 {
        return None;
    }
    let df = ((replicates - 1) as f64, (cells - 1.0) * (replicates - 1) as f64);
    let statistic = variances.iter().fold(0.0, |most: f64, v| most.max(*v)) / total;
    let f = (cells - 1.0) * statistic / (1.0 - statistic);
    let p = if f.is_finite() { (cells * distribution::fisher_upper(f, df.0, df.1)).min(1.0) } else { 0.0 };
    Some(VarianceTest { statistic, critical: cochran_critical(variances.len(), replicates, alpha), p, df })
}

/// Upper `alpha` point of Cochran's G for `cells` ≥ 2 cells of `replicates` ≥ 2 runs.
pub fn cochran_critical(cells: usize, replicates: usize, alpha: f64) -> f64 {
    let (n, cells) = ((replicates - 1) as f64, cells as f64);
    let f = distribution::fisher_critical(alpha / cells, n, (cells - 1.0) * n);
    f / (f + cells - 1.0)
}

/// Brown and Forsythe's F: one-way analysis of variance of the distances from the cell medians. Cells of a single run say nothing and are left
/// out; `None` if fewer than two remain or the distances do not vary.
///
/// Source: Brown & Forsythe, J. Amer. Statist. Assoc. 69 (1974) 364–367.
pub fn brown_forsythe(cells: &[Vec<f64>], alpha: f64) -> Option<VarianceTest> {
    let distances: Vec<Vec<f64>> = cells
        .iter()
        .filter(|values| values.len() > 1)
        .map(|values| {
            let middle = median(values);
            values.iter().map(|y| (y - middle).abs()).collect()
        })
        .collect();
    let one_way = crate::statistics::anova::one_way(&distances)?;
    let f = one_way.f?;
    let df = (one_way.between_df as f64, one_way.within_df as f64);
    Some(VarianceTest {
        statistic: f,
        critical: distribution::fisher_critical(alpha, df.0, df.1),
        p: distribution::fisher_upper(f, df.0, df.1),
        df,
    })
}

/// Middle value; mean of the middle two.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[half] } else { 0.5 * (sorted[half - 1] + sorted[half]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cochran_critical_values_agree_with_the_published_row() {
        // Eisenhart, Hastay & Wallis, Techniques of Statistical Analysis (1947), α = 0.01, 8 groups, n = 2 … 11, four digits.
        let published = [0.7945, 0.6152, 0.5209, 0.4627, 0.4226, 0.3932, 0.3704, 0.3522, 0.3373, 0.3248];
        for (n, published) in (2..=11).zip(published) {
            assert!((cochran_critical(8, n, 0.01) - published).abs() < 1e-4, "n = {n}: {}", cochran_critical(8, n, 0.01));
        }
        assert!((cochran_critical(8, 5, 0.05) - 0.3910).abs() < 5e-5);
    }

    #[test]
    fn one_cell_that_scatters_alone_has_g_one_and_p_zero() {
        let test = cochran(&[0.0, 0.0, 2.0], 3, 0.05).unwrap();
        assert_eq!((test.statistic, test.p), (1.0, 0.0));
        assert_eq!(cochran(&[0.0, 0.0], 3, 0.05), None);
    }
}
