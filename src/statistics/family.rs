//! Many tests at once: p-values adjusted over the whole family of responses and terms.

use crate::statistics::box_wilson::Analysis;

/// Holm's step-down adjustment, in the order given: the chance of one false rejection or more stays below the level, whatever the dependence.
///
/// Source: Holm, Scand. J. Statist. 6 (1979) 65–70.
pub fn holm(p: &[f64]) -> Vec<f64> {
    let order = ascending(p);
    let mut adjusted = vec![0.0; p.len()];
    let mut largest: f64 = 0.0;
    for (rank, &index) in order.iter().enumerate() {
        largest = largest.max((p.len() - rank) as f64 * p[index]).min(1.0);
        adjusted[index] = largest;
    }
    adjusted
}

/// Benjamini and Hochberg's step-up adjustment: the expected share of false ones among the rejections stays below the level, for independent
/// or positively dependent tests.
///
/// Source: Benjamini & Hochberg, J. R. Statist. Soc. B 57 (1995) 289–300.
pub fn benjamini_hochberg(p: &[f64]) -> Vec<f64> {
    let order = ascending(p);
    let mut adjusted = vec![0.0; p.len()];
    let mut smallest: f64 = 1.0;
    for (rank, &index) in order.iter().enumerate().rev() {
        smallest = smallest.min(p.len() as f64 / (rank + 1) as f64 * p[index]);
        adjusted[index] = smallest;
    }
    adjusted
}

/// Writes both adjusted p-values into every coefficient that has a p, the family being all responses × all terms (the constant included:
/// it is tested like the others). Returns the size of the family.
pub fn adjust(analyses: &mut [Analysis]) -> usize {
    let p: Vec<f64> = analyses.iter().flat_map(|analysis| &analysis.coefficients).filter_map(|coefficient| coefficient.p).collect();
    let (mut step_down, mut step_up) = (holm(&p).into_iter(), benjamini_hochberg(&p).into_iter());
    for coefficient in analyses.iter_mut().flat_map(|analysis| &mut analysis.coefficients).filter(|coefficient| coefficient.p.is_some()) {
        coefficient.p_holm = step_down.next();
        coefficient.p_benjamini_hochberg = step_up.next();
    }
    p.len()
}

fn ascending(p: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&i, &j| p[i].total_cmp(&p[j]));
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    // statsmodels 0.15.0, multipletests(p, method="holm" / "fdr_bh"), scripts/statistics_reference.py.
    const P: [f64; 6] = [0.01, 0.04, 0.03, 0.005, 0.5, 0.02];

    #[test]
    fn holm_agrees_with_hand_calculation() {
        // Sorted 0.005·6, 0.01·5, 0.02·4, 0.03·3, 0.04·2 (raised to 0.09), 0.5·1.
        let exact = [0.05, 0.09, 0.09, 0.03, 0.5, 0.08];
        assert!(holm(&P).iter().zip(exact).all(|(found, exact)| (found - exact).abs() < 1e-15));
    }

    #[test]
    fn benjamini_hochberg_agrees_with_hand_calculation() {
        // 0.005·6/1, 0.01·6/2, 0.02·6/3, 0.03·6/4, 0.04·6/5, 0.5.
        let exact = [0.03, 0.048, 0.045, 0.03, 0.5, 0.04];
        assert!(benjamini_hochberg(&P).iter().zip(exact).all(|(found, exact)| (found - exact).abs() < 1e-15));
    }
}
