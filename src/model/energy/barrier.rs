//! A wall that cloth cannot pass: an energy that is zero at a distance and grows without bound as the gap closes.

use crate::numerics::jet::Jet;

/// `b(g) = −κ (g − ĝ)² ln(g/ĝ)` per area for a gap 0 < g < ĝ, zero beyond: twice continuously differentiable, so Newton's method sees no kink.
///
/// Source: Li et al., Incremental Potential Contact, ACM Transactions on Graphics 39 (2020) 49.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Barrier {
    /// κ, N/m³.
    pub stiffness: f64,
    /// ĝ, m: from here on the wall is not felt.
    pub reach: f64,
}

impl Barrier {
    /// A wall that holds some ten times the cloth's own weight per area (N/m²) at half its reach (m).
    pub fn against(weight: f64, reach: f64) -> Self {
        // −b′(ĝ/2) = 1.19 κ ĝ.
        Barrier { stiffness: 10.0 * weight / reach, reach }
    }

    /// J/m² at this gap, felt from `reach` on; `Some(None)` where it is not felt, `None` where the gap is closed.
    pub fn density<const N: usize>(&self, gap: Jet<N>, reach: f64) -> Option<Option<Jet<N>>> {
        let g = gap.value;
        if g.is_nan() || g <= 0.0 {
            return None;
        }
        if reach <= g {
            return Some(None);
        }
        let (past, log, k) = (g - reach, (g / reach).ln(), -self.stiffness);
        let first = k * (2.0 * past * log + past * past / g);
        let second = k * (2.0 * log + 4.0 * past / g - past * past / (g * g));
        Some(Some(gap.chain(k * past * past * log, first, second)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wall_is_felt_from_its_reach_on_and_never_passed() {
        let wall = Barrier::against(2.0, 3e-3);
        let at = |g: f64| wall.density(Jet::<1>::variable(g, 0), wall.reach);
        assert!(at(0.0).is_none() && at(-1e-3).is_none() && at(f64::NAN).is_none());
        assert_eq!((at(3e-3), at(1.0)), (Some(None), Some(None)));
        let force = |g: f64| -at(g).unwrap().unwrap().gradient[0];
        assert!((force(1.5e-3) - 10.0 * 2.0 * (2.0_f64.ln() + 0.5)).abs() < 1e-9);
        // Like κĝ²/g near the wall.
        assert!(0.9 < force(1e-8) * 1e-8 / (wall.stiffness * 9e-6));
    }
}
