//! Losses: how much a residual counts, the further it is from the others.
//!
//! With `u` the residual over the scale, ρ is the loss, ψ = ρ′ its influence and w = ψ/u the weight of the equivalent weighted least squares.

use std::fmt;

use serde::Serialize;

/// What is summed over the residuals.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Loss {
    /// Half the square: least squares. Every residual counts in full.
    #[default]
    Squares,
    /// Square near zero, linear beyond `tuning` scales (Huber, Annals of Mathematical Statistics 35 (1964) 73–101).
    Huber { tuning: f64 },
    /// Bounded: beyond `tuning` scales a residual does not count at all (biweight; Beaton & Tukey, Technometrics 16 (1974) 147–185).
    Tukey { tuning: f64 },
    /// Logarithmic far out: the likelihood of Cauchy's distribution.
    Cauchy { tuning: f64 },
}

impl Loss {
    /// With the constants that leave 95 % efficiency at normal errors (Holland & Welsch, Communications in Statistics A6 (1977) 813–827).
    pub const HUBER: Loss = Loss::Huber { tuning: 1.345 };
    pub const TUKEY: Loss = Loss::Tukey { tuning: 4.685 };
    pub const CAUCHY: Loss = Loss::Cauchy { tuning: 2.385 };

    /// ρ(u).
    pub fn value(self, u: f64) -> f64 {
        match self {
            Loss::Squares => 0.5 * u * u,
            Loss::Huber { tuning } if u.abs() <= tuning => 0.5 * u * u,
            Loss::Huber { tuning } => tuning * (u.abs() - 0.5 * tuning),
            Loss::Tukey { tuning } if u.abs() <= tuning => {
                let left = 1.0 - (u / tuning).powi(2);
                tuning * tuning / 6.0 * (1.0 - left.powi(3))
            }
            Loss::Tukey { tuning } => tuning * tuning / 6.0,
            Loss::Cauchy { tuning } => 0.5 * tuning * tuning * (u / tuning).powi(2).ln_1p(),
        }
    }

    /// ψ(u)/u, between 0 and 1.
    pub fn weight(self, u: f64) -> f64 {
        match self {
            Loss::Squares => 1.0,
            Loss::Huber { tuning } if u.abs() <= tuning => 1.0,
            Loss::Huber { tuning } => tuning / u.abs(),
            Loss::Tukey { tuning } if u.abs() <= tuning => (1.0 - (u / tuning).powi(2)).powi(2),
            Loss::Tukey { .. } => 0.0,
            Loss::Cauchy { tuning } => 1.0 / (1.0 + (u / tuning).powi(2)),
        }
    }

    /// ψ′(u).
    pub fn curvature(self, u: f64) -> f64 {
        match self {
            Loss::Squares => 1.0,
            Loss::Huber { tuning } => f64::from(u8::from(u.abs() <= tuning)),
            Loss::Tukey { tuning } if u.abs() <= tuning => {
                let square = (u / tuning).powi(2);
                (1.0 - square) * (1.0 - 5.0 * square)
            }
            Loss::Tukey { .. } => 0.0,
            Loss::Cauchy { tuning } => {
                let square = (u / tuning).powi(2);
                (1.0 - square) / (1.0 + square).powi(2)
            }
        }
    }

    /// The tuning constant, in scales.
    pub fn tuning(self) -> Option<f64> {
        match self {
            Loss::Squares => None,
            Loss::Huber { tuning } | Loss::Tukey { tuning } | Loss::Cauchy { tuning } => Some(tuning),
        }
    }
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Loss::Squares => f.write_str("least squares"),
            Loss::Huber { tuning } => write!(f, "Huber's loss (tuning {tuning})"),
            Loss::Tukey { tuning } => write!(f, "Tukey's biweight (tuning {tuning})"),
            Loss::Cauchy { tuning } => write!(f, "Cauchy's loss (tuning {tuning})"),
        }
    }
}

/// Consistent at normal errors: 1/Φ⁻¹(3/4).
const NORMAL: f64 = 1.482_602_218_505_602;

/// The normalized median absolute residual, 1.4826 · median |r|: a standard deviation that up to half of the residuals cannot spoil.
///
/// About zero, because a fit leaves residuals about zero; residuals of weight 0 are left out. 0 where more than half of the residuals vanish.
pub fn median_scale(residuals: &[f64], weights: &[f64]) -> f64 {
    let counted = |i: &usize| weights.get(*i).is_none_or(|&w| 0.0 < w);
    let mut sizes: Vec<f64> = (0..residuals.len()).filter(counted).map(|i| residuals[i].abs()).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let middle = sizes.len() / 2;
    let even = sizes.len().is_multiple_of(2);
    let (below, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    let median = if even { 0.5 * (*median + below.iter().copied().fold(0.0, f64::max)) } else { *median };
    NORMAL * median
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Loss; 4] = [Loss::Squares, Loss::HUBER, Loss::TUKEY, Loss::CAUCHY];

    #[test]
    fn weight_and_curvature_are_the_derivatives_of_the_loss() {
        for loss in ALL {
            for i in -80..=80 {
                // Off the corner of Huber's influence.
                let u = 0.1 * f64::from(i) + 0.013;
                let h = 1e-5;
                let slope = (loss.value(u + h) - loss.value(u - h)) / (2.0 * h);
                // Truncation h²/6 ~ 2e-11, rounding eps·ρ/h ~ 1e-10.
                assert!((slope - u * loss.weight(u)).abs() < 1e-9, "{loss} at {u}");
                let bend = ((u + h) * loss.weight(u + h) - (u - h) * loss.weight(u - h)) / (2.0 * h);
                assert!((bend - loss.curvature(u)).abs() < 1e-9, "{loss} at {u}");
            }
        }
    }

    #[test]
    fn the_usual_tuning_leaves_ninety_five_percent_efficiency_at_normal_errors() {
        // (E ψ′)² / E ψ² by the trapezoid rule over ±12, which converges spectrally but for Huber's corner.
        for loss in &ALL[1..] {
            let (mut bend, mut square) = (0.0, 0.0);
            let step = 1e-3;
            for i in -12_000..=12_000 {
                let u = step * f64::from(i);
                let density = step * (-0.5 * u * u).exp() / std::f64::consts::TAU.sqrt();
                bend += density * loss.curvature(u);
                square += density * (u * loss.weight(u)).powi(2);
            }
            let efficiency = bend * bend / square;
            assert!((efficiency - 0.95).abs() < 5e-4, "{loss}: {efficiency}");
        }
    }

    #[test]
    fn the_median_scale_is_that_of_the_clean_half() {
        // Quartiles of the normal distribution at ±0.67449: five even residuals with the median there.
        let residuals = [0.1, -0.2, 0.674_489_750_196_081_7, -500.0, 1e9];
        assert!((median_scale(&residuals, &[]) - 1.0).abs() < 1e-15);
        assert_eq!(median_scale(&[1.0, -3.0, 77.0], &[1.0, 1.0, 0.0]), 2.0 * NORMAL);
        assert_eq!(median_scale(&[], &[]), 0.0);
    }
}
