//! Which power of the response suits a linear model with equal variances: Box and Cox's λ with its interval.

use serde::Serialize;

use crate::error::Error;
use crate::statistics::distribution::chi_squared_critical;
use crate::statistics::factorial::FactorialDesign;

/// λ is sought here; beyond it the response is close to its largest or smallest value alone.
const RANGE: f64 = 5.0;

/// The power transformation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BoxCox {
    /// Of largest likelihood; 1 = leave the response as it is, 0 = take logarithms.
    pub lambda: f64,
    /// Ends of the likelihood-ratio interval; `None` where it runs beyond ±5.
    pub low: Option<f64>,
    pub high: Option<f64>,
}

impl BoxCox {
    /// Whether the interval allows the response as it is.
    pub fn allows_none(&self) -> bool {
        self.low.is_none_or(|low| low <= 1.0) && self.high.is_none_or(|high| high >= 1.0)
    }
}

/// λ for the full factorial model (with blocks and curvature where they are); interval at 1 − alpha.
///
/// `None` if the model leaves no residual degrees of freedom or fits perfectly, or if the likelihood still rises at ±5: then the runs do not
/// determine a power.
///
/// Source: Box & Cox, J. R. Statist. Soc. B 26 (1964) 211–252.
///
/// # Errors
/// [`Error::Unanswerable`] if a response is not positive, or responses do not match the runs.
pub fn box_cox(design: &FactorialDesign, response: &[Option<f64>], alpha: f64) -> Result<Option<BoxCox>, Error> {
    if response.len() != design.runs() {
        return Err(Error::Unanswerable(format!("{} responses for {} runs", response.len(), design.runs())));
    }
    let used: Vec<usize> = (0..response.len()).filter(|&run| response[run].is_some()).collect();
    let y: Vec<f64> = response.iter().copied().flatten().collect();
    if let Some(&value) = y.iter().find(|value| !(value.is_finite() && **value > 0.0)) {
        return Err(Error::Unanswerable(format!("a power transformation needs positive responses; one is {value}")));
    }
    if y.is_empty() {
        return Err(Error::Unanswerable("no run has a response".into()));
    }
    let design = design.subset(&used);
    let decomposition = design.regressors_of(&design.term_factors(), design.has_centre())?.decompose();
    if decomposition.rank() == y.len() || decomposition.fit(&y)?.perfect {
        return Ok(None);
    }
    let basis = decomposition.basis();
    let count = y.len() as f64;
    let mean_log = y.iter().map(|y| y.ln()).sum::<f64>() / count;
    let logs: Vec<f64> = y.iter().map(|y| y.ln() - mean_log).collect();
    // Likelihood up to a constant. y/g instead of y (g the geometric mean) only shifts and scales what the constant and s² absorb.
    let likelihood = |lambda: f64| -> f64 {
        let transformed: Vec<f64> = logs.iter().map(|log| if lambda == 0.0 { *log } else { (lambda * log).exp_m1() / lambda }).collect();
        let mut left = transformed;
        for q in &basis {
            let share: f64 = q.iter().zip(&left).map(|(q, z)| q * z).sum();
            left.iter_mut().zip(q).for_each(|(z, q)| *z -= share * q);
        }
        -0.5 * count * (left.iter().map(|z| z * z).sum::<f64>() / count).ln()
    };
    // The likelihood may have shoulders: a grid finds the right hill, the golden section its top.
    let grid: Vec<f64> = (-50..=50).map(|i| f64::from(i) * RANGE / 50.0).collect();
    let best = grid.iter().copied().fold((f64::NEG_INFINITY, 0.0), |best, lambda| {
        let value = likelihood(lambda);
        if value > best.0 { (value, lambda) } else { best }
    });
    let step = RANGE / 50.0;
    let lambda = golden_section(&likelihood, (best.1 - step).max(-RANGE), (best.1 + step).min(RANGE));
    if lambda.abs() > RANGE - 1e-6 {
        return Ok(None);
    }
    let target = likelihood(lambda) - 0.5 * chi_squared_critical(alpha, 1.0);
    let end = |limit: f64| -> Option<f64> {
        if likelihood(limit) > target {
            return None;
        }
        // The crossing nearest to λ: walk out on the grid, then halve.
        let direction = (limit - lambda).signum();
        let mut inside = lambda;
        while likelihood(inside + direction * step) > target {
            inside += direction * step;
        }
        let mut outside = inside + direction * step;
        for _ in 0..60 {
            let middle = 0.5 * (inside + outside);
            if likelihood(middle) > target { inside = middle } else { outside = middle }
        }
        Some(inside)
    };
    Ok(Some(BoxCox { lambda, low: end(-RANGE), high: end(RANGE) }))
}

/// Place of the largest value of a function with one hill in the interval, to about the root of the rounding error.
fn golden_section(value: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let ratio = 0.5 * (5_f64.sqrt() - 1.0);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (value(left), value(right));
    // 0.618⁴⁰ = 4e-9 of the interval.
    for _ in 0..40 {
        if at_left < at_right {
            low = left;
            (left, at_left) = (right, at_right);
            right = low + ratio * (high - low);
            at_right = value(right);
        } else {
            high = right;
            (right, at_right) = (left, at_left);
            left = high - ratio * (high - low);
            at_left = value(left);
        }
    }
    0.5 * (low + high)
}
