//! The Lagrange multiplier of a fitted hem, three ways, each with how well it holds.

use serde::Serialize;

use super::outcome::Estimate;

/// λ three ways (MODEL section 3); `None` where a quantity does not exist, with the reason in `missing`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Lambda {
    /// Slope of 2G on v along the curve, N/m²; and R².
    pub first_integral: Option<(Estimate, f64)>,
    /// Least squares of ∇J = λ∇Λ over (p, q, s), N/m²; and the angle between the gradients, degrees.
    pub ritz: Option<(Estimate, f64)>,
    /// The same with the energy of the ruled shell, N; and the angle, degrees.
    pub ruled: Option<(Estimate, f64)>,
    /// λ/(ρ_A g) with E = 0 by the first integral (dimensionless); exists without cloth data.
    pub over_weight: Option<(Estimate, f64)>,
    pub missing: Option<String>,
}
