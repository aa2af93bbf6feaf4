//! Which effects stand out when there are no replicates: Lenth's pseudo standard error.

use serde::Serialize;

use crate::statistics::distribution;
use crate::statistics::variances::median;

/// Fewer contrasts than this give the pseudo standard error less than one degree of freedom.
pub const LEAST_CONTRASTS: usize = 3;

/// Scale of the contrasts that are noise, and the margins drawn from it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Lenth {
    /// `1.5 · median{|c| : |c| < 2.5 s₀}`, `s₀ = 1.5 · median |c|`; in the units of the contrasts.
    pub pseudo_standard_error: f64,
    /// A third of the number of contrasts.
    pub df: f64,
    /// One contrast taken alone is noise below this.
    pub margin: f64,
    /// All contrasts taken together are noise below this.
    pub simultaneous_margin: f64,
}

/// Lenth's method on the coefficients (or effects) of an orthogonal unreplicated design, the constant left out.
///
/// `None` with fewer than [`LEAST_CONTRASTS`] contrasts or if more than half of them vanish (nothing to measure noise with).
///
/// Source: Lenth, Technometrics 31 (1989) 469–473.
pub fn lenth(contrasts: &[f64], alpha: f64) -> Option<Lenth> {
    if contrasts.len() < LEAST_CONTRASTS {
        return None;
    }
    let sizes: Vec<f64> = contrasts.iter().map(|c| c.abs()).collect();
    let first = 1.5 * median(&sizes);
    let small: Vec<f64> = sizes.into_iter().filter(|size| *size < 2.5 * first).collect();
    if small.is_empty() {
        return None;
    }
    let pseudo_standard_error = 1.5 * median(&small);
    let count = contrasts.len() as f64;
    let df = count / 3.0;
    // Both tails of one contrast; then of all at once, (1 − α)^(1/m) each.
    let each = -((-alpha).ln_1p() / count).exp_m1();
    (pseudo_standard_error > 0.0).then(|| Lenth {
        pseudo_standard_error,
        df,
        margin: pseudo_standard_error * distribution::student_critical(alpha, df),
        simultaneous_margin: pseudo_standard_error * distribution::student_critical(each, df),
    })
}
