//! What the design can see: power, the smallest effect it would find, and the replicates a given effect needs.

use crate::error::Error;
use crate::statistics::distribution::{ln_gamma, student_critical};
use crate::statistics::incomplete_beta::regularized;

/// Most replicates that [`replicates_needed`] considers.
const MOST_REPLICATES: usize = 10_000;

/// Chance that the two-sided t test at `alpha` on `df` degrees of freedom finds a coefficient of true size `noncentrality` standard errors.
///
/// The square of that t is noncentral F on (1, df): a Poisson mixture of beta laws, summed outward from its largest weight.
/// Source: Johnson, Kotz & Balakrishnan, Continuous Univariate Distributions 2 (1995), chapter 30.
pub fn power(noncentrality: f64, df: f64, alpha: f64) -> f64 {
    if noncentrality == 0.0 { alpha } else { chance_beyond(student_critical(alpha, df), noncentrality, df) }
}

/// Chance that |t| on `df` degrees of freedom is above `critical` where its true value is `noncentrality` standard errors, not 0.
fn chance_beyond(critical: f64, noncentrality: f64, df: f64) -> f64 {
    let square = critical * critical;
    let (x, y) = (square / (df + square), df / (df + square));
    let rate = 0.5 * noncentrality * noncentrality;
    // Of not finding it.
    let part = |j: f64| (-rate + j * rate.ln() - ln_gamma(j + 1.0)).exp() * regularized(0.5 + j, 0.5 * df, x, y);
    let mode = rate.floor();
    let mut missed = part(mode);
    let mut j = mode;
    while j > 0.0 {
        j -= 1.0;
        let add = part(j);
        missed += add;
        if add < 1e-18 {
            break;
        }
    }
    j = mode;
    loop {
        j += 1.0;
        let add = part(j);
        missed += add;
        if add < 1e-18 || !add.is_finite() {
            break;
        }
    }
    (1.0 - missed).clamp(0.0, 1.0)
}

/// The smallest true coefficient (half the effect, units of the response) that a 2^k design of `cells` treatments with `replicates` ≥ 2 runs
/// each finds with the chance `wanted`, at error variance `variance`.
///
/// # Errors
/// [`Error::Invalid`] if a number is outside the range in which the question makes sense.
pub fn smallest_coefficient(variance: f64, cells: usize, replicates: usize, alpha: f64, wanted: f64) -> Result<f64, Error> {
    check(variance, alpha, wanted)?;
    if replicates < 2 || cells < 2 {
        return Err(Error::Invalid {
            quantity: "runs per treatment",
            value: replicates as f64,
            allowed: ">= 2, with at least two treatments",
        });
    }
    let df = (cells * (replicates - 1)) as f64;
    let standard_error = (variance / (cells * replicates) as f64).sqrt();
    // Power rises with the noncentrality; on one degree of freedom and at small alpha it needs a large one.
    let critical = student_critical(alpha, df);
    let lacking = |noncentrality: f64| wanted - chance_beyond(critical, noncentrality, df);
    let (mut low, mut high) = ((0.0, wanted - alpha), (1.0, lacking(1.0)));
    while 0.0 < high.1 {
        low = high;
        high = (2.0 * high.0, lacking(2.0 * high.0));
        if high.0 > 1e4 {
            return Err(Error::Unanswerable(format!(
                "on {df} degrees of freedom no effect is found with a chance of {wanted} at level {alpha}"
            )));
        }
    }
    Ok(root(lacking, low, high) * standard_error)
}

/// Where a falling function is 0 between two places with their values, to a relative 1e-14.
///
/// Source: Oliveira & Takahashi, ACM Trans. Math. Softw. 47 (2020) 5 (ITP): the secant's step, held so near to the middle that it never takes many
/// more steps than halving.
fn root(f: impl Fn(f64) -> f64, (mut low, mut at_low): (f64, f64), (mut high, mut at_high): (f64, f64)) -> f64 {
    let tolerance = 1e-14 * high;
    let (spread, most) = (high - low, ((high - low) / tolerance).log2().ceil() + 1.0);
    let mut step = 0.0;
    while tolerance < high - low {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let secant = (at_low * high - at_high * low) / (at_low - at_high);
        let towards = (middle - secant).signum();
        let truncated = secant + towards * (0.2 / spread * (high - low).powi(2)).min((middle - secant).abs());
        let reach = 0.5 * tolerance * f64::exp2(most - step) - half;
        let next = if (truncated - middle).abs() <= reach { truncated } else { middle - towards * reach.max(0.0) };
        let next = if low < next && next < high { next } else { middle };
        let at = f(next);
        if 0.0 < at {
            (low, at_low) = (next, at)
        } else {
            (high, at_high) = (next, at)
        }
        step += 1.0;
    }
    high
}

/// The smallest number of runs per treatment with which a true coefficient of size `coefficient` is found with the chance `wanted`.
///
/// # Errors
/// [`Error::Invalid`] if a number is outside its range; [`Error::Unanswerable`] if 10 000 runs per treatment are not enough.
pub fn replicates_needed(coefficient: f64, variance: f64, cells: usize, alpha: f64, wanted: f64) -> Result<usize, Error> {
    check(variance, alpha, wanted)?;
    if !(coefficient.is_finite() && coefficient != 0.0) {
        return Err(Error::Invalid { quantity: "coefficient to find", value: coefficient, allowed: "finite and not 0" });
    }
    if cells < 2 {
        return Err(Error::Invalid { quantity: "number of treatments", value: cells as f64, allowed: ">= 2" });
    }
    let enough = |replicates: usize| {
        let noncentrality = coefficient.abs() * ((cells * replicates) as f64 / variance).sqrt();
        // Beyond this the chance is 1 to the last digit, and the series would be long for nothing.
        noncentrality > 100.0 || power(noncentrality, (cells * (replicates - 1)) as f64, alpha) >= wanted
    };
    let mut high = 2;
    while !enough(high) {
        if high >= MOST_REPLICATES {
            return Err(Error::Unanswerable(format!(
                "a coefficient of {coefficient} needs more than {MOST_REPLICATES} runs per treatment"
            )));
        }
        high *= 2;
    }
    let mut low = 1;
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if middle >= 2 && enough(middle) { high = middle } else { low = middle }
    }
    Ok(high)
}

fn check(variance: f64, alpha: f64, wanted: f64) -> Result<(), Error> {
    if !(variance.is_finite() && variance > 0.0) {
        return Err(Error::Invalid { quantity: "error variance", value: variance, allowed: "finite and > 0" });
    }
    if !(alpha > 0.0 && alpha < 1.0) {
        return Err(Error::Invalid { quantity: "significance level", value: alpha, allowed: "> 0 and < 1" });
    }
    if !(wanted > alpha && wanted < 1.0) {
        return Err(Error::Invalid { quantity: "wanted power", value: wanted, allowed: "> the significance level and < 1" });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_coefficient_of_a_design_needs_just_its_replicates() {
        for (cells, replicates) in [(2, 3), (4, 4), (8, 5), (16, 2)] {
            let smallest = smallest_coefficient(2.5, cells, replicates, 0.05, 0.9).unwrap();
            assert_eq!(replicates_needed(1.000_001 * smallest, 2.5, cells, 0.05, 0.9).unwrap(), replicates);
            assert_eq!(replicates_needed(0.999_999 * smallest, 2.5, cells, 0.05, 0.9).unwrap(), replicates + 1);
        }
    }

    #[test]
    fn power_without_an_effect_is_the_level_and_with_a_huge_one_certainty() {
        assert_eq!(power(0.0, 8.0, 0.05), 0.05);
        // Nothing happens between no effect and almost none.
        assert!((power(1e-6, 8.0, 0.05) - 0.05).abs() < 1e-10);
        assert!(power(60.0, 8.0, 0.05) > 1.0 - 1e-12);
    }

    #[test]
    fn questions_without_an_answer_are_refused() {
        assert!(smallest_coefficient(0.0, 8, 5, 0.05, 0.9).is_err());
        assert!(smallest_coefficient(1.0, 8, 1, 0.05, 0.9).is_err());
        assert!(replicates_needed(0.0, 1.0, 8, 0.05, 0.9).is_err());
        assert!(replicates_needed(1e-6, 1.0, 8, 0.05, 0.9).is_err());
    }
}
