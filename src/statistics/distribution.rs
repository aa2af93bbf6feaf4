//! Tail probabilities and quantiles of t, F, χ² and the normal law; the only door to `statrs`.
//!
//! Tails are computed as tails (never as 1 − cdf), so they keep their relative accuracy down to the smallest double; quantiles invert
//! exactly these tails by bisection on a logarithmic scale.

use statrs::function::beta::beta_reg;
use statrs::function::erf::erfc;
use statrs::function::gamma::gamma_ur;

/// P(|T| ≥ |t|) for Student's t with `df` > 0 degrees of freedom.
pub fn student_two_sided(t: f64, df: f64) -> f64 {
    let square = t * t;
    if !square.is_finite() {
        return 0.0;
    }
    // The larger of h and 1 − h is not representable near 1; the tail needs h = df/(df + t²) itself, which is.
    beta_reg(0.5 * df, 0.5, df / (df + square))
}

/// The t that |T| exceeds with probability `alpha` (0 < alpha < 1), both tails together.
pub fn student_critical(alpha: f64, df: f64) -> f64 {
    upper_quantile(|t| student_two_sided(t, df), alpha)
}

/// P(F ≥ f) on (`numerator`, `denominator`) degrees of freedom.
pub fn fisher_upper(f: f64, numerator: f64, denominator: f64) -> f64 {
    if f <= 0.0 {
        return 1.0;
    }
    beta_reg(0.5 * denominator, 0.5 * numerator, denominator / (denominator + numerator * f))
}

/// The f that F exceeds with probability `alpha`.
pub fn fisher_critical(alpha: f64, numerator: f64, denominator: f64) -> f64 {
    upper_quantile(|f| fisher_upper(f, numerator, denominator), alpha)
}

/// P(X ≥ x) for χ² with `df` degrees of freedom.
pub fn chi_squared_upper(x: f64, df: f64) -> f64 {
    if x <= 0.0 { 1.0 } else { gamma_ur(0.5 * df, 0.5 * x) }
}

/// The x that χ² exceeds with probability `alpha`.
pub fn chi_squared_critical(alpha: f64, df: f64) -> f64 {
    upper_quantile(|x| chi_squared_upper(x, df), alpha)
}

/// P(Z ≥ z) for the standard normal law.
pub fn normal_upper(z: f64) -> f64 {
    0.5 * erfc(z * std::f64::consts::FRAC_1_SQRT_2)
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
