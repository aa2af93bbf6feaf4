//! Tail probabilities and quantiles of t, F, χ² and the normal law; the only door to `statrs`.
//!
//! Tails are computed as tails (never as 1 − cdf), so they keep their relative accuracy down to the smallest double; quantiles invert
//! exactly these tails by bisection on a logarithmic scale.
//!
//! What of `statrs` 0.19 is used and what is not, measured against 50-digit arithmetic (worst relative error over the grid of
//! `scripts/statistics_reference.py`): its incomplete gamma function is good to 2e-13 and serves χ² and the normal law; its `erfc` to 9e-11
//! only (at z = 1), its `beta_reg` to 4e-9 on Student's t with many degrees of freedom, so the latter is replaced by
//! [`crate::statistics::incomplete_beta`].

use statrs::function::gamma::gamma_ur;
pub use statrs::function::gamma::ln_gamma;

use crate::statistics::incomplete_beta::{ln_beta, regularized};

/// P(|T| ≥ |t|) for Student's t with `df` > 0 degrees of freedom.
pub fn student_two_sided(t: f64, df: f64) -> f64 {
    let square = t * t;
    if t.is_finite() && !square.is_finite() {
        // So far out the tail is its leading term, x^{ν/2}/(ν/2 · B(ν/2, ½)) at x = ν/t².
        let half = 0.5 * df;
        return (half * (df.ln() - 2.0 * t.abs().ln()) - half.ln() - ln_beta(half, 0.5)).exp();
    }
    if !square.is_finite() {
        return 0.0;
    }
    regularized(0.5 * df, 0.5, df / (df + square), square / (df + square))
}

/// The t that |T| exceeds with probability `alpha` (0 < alpha < 1), both tails together.
pub fn student_critical(alpha: f64, df: f64) -> f64 {
    upper_quantile(|t| student_two_sided(t, df), alpha)
}

/// P(F ≥ f) on (`numerator`, `denominator`) degrees of freedom. Relative error below 10⁻¹² however many they are, as long as the fewer are not above
/// 10⁷; beyond that the rounding of `f` itself is felt (10⁻¹¹ at 10⁹ of both).
pub fn fisher_upper(f: f64, numerator: f64, denominator: f64) -> f64 {
    if f <= 0.0 {
        return 1.0;
    }
    let scaled = numerator * f;
    if !scaled.is_finite() {
        return 0.0;
    }
    regularized(0.5 * denominator, 0.5 * numerator, denominator / (denominator + scaled), scaled / (denominator + scaled))
}

/// The f that F exceeds with probability `alpha`.
pub fn fisher_critical(alpha: f64, numerator: f64, denominator: f64) -> f64 {
    upper_quantile(|f| fisher_upper(f, numerator, denominator), alpha)
}

/// P(X ≥ x) for χ² with `df` degrees of freedom.
pub fn chi_squared_upper(x: f64, df: f64) -> f64 {
    if x <= 0.0 {
        1.0
    } else if x.is_finite() {
        gamma_ur(0.5 * df, 0.5 * x)
    } else {
        0.0
    }
}

/// The x that χ² exceeds with probability `alpha`.
pub fn chi_squared_critical(alpha: f64, df: f64) -> f64 {
    upper_quantile(|x| chi_squared_upper(x, df), alpha)
}

/// P(Z ≥ z) for the standard normal law.
pub fn normal_upper(z: f64) -> f64 {
    match z {
        z if z > 0.0 => 0.5 * chi_squared_upper(z * z, 1.0),
        z if z < 0.0 => 1.0 - 0.5 * chi_squared_upper(z * z, 1.0),
        _ => 0.5,
    }
}

/// The z that Z exceeds with probability `alpha`; negative for alpha > ½.
pub fn normal_critical(alpha: f64) -> f64 {
    if alpha == 0.5 {
        0.0
    } else if alpha > 0.5 {
        -normal_critical(1.0 - alpha)
    } else {
        upper_quantile(normal_upper, alpha)
    }
}

/// x > 0 with `tail(x) = p`, for a tail that falls from at least p to 0.
fn upper_quantile(tail: impl Fn(f64) -> f64, p: f64) -> f64 {
    let (mut low, mut high) = (-700.0_f64, 700.0_f64);
    // 1400 · 2⁻⁶⁴ is below the spacing of doubles near 1: nothing is left to gain.
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if tail(middle.exp()) > p {
            low = middle;
        } else {
            high = middle;
        }
    }
    (0.5 * (low + high)).exp()
}
