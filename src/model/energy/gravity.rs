//! The weight of the cloth: what lifting it above its straight-down position costs.

use crate::experiment::Skirt;
use crate::numerics::lanes::Vector;

/// Gravity of a ruled shell: `U = ρ_A g L (R_t/2 + (R_n − R_t)/3) ∮ (L − √(L² − |d|²)) dσ`.
///
/// The factor is the first moment of the cone's area about the waist along the slant: a straight generatrix lifts each ring in proportion to u.
#[derive(Debug, Clone, Copy)]
pub struct Gravity {
    factor: f64,
    slant: f64,
}

/// How far a straight generatrix of length L lifts its foot when it leans out by |d|: `L − √(L² − |d|²)`, with two derivatives by |d|².
#[derive(Debug, Clone, Copy)]
pub struct Rise {
    pub value: f64,
    pub first: f64,
    pub second: f64,
}

impl Gravity {
    pub const NAME: &'static str = "gravity";

    /// `weight` is ρ_A g, N/m².
    pub fn new(skirt: &Skirt, weight: f64) -> Self {
        let (waist, hem, slant) = (skirt.waist_radius().0, skirt.hem_radius().0, skirt.slant_length().0);
        Gravity { factor: weight * slant * (0.5 * waist + (hem - waist) / 3.0), slant }
    }

    /// Energy density per radian of σ (J) and its derivatives by |d|², m²; `None` where the generatrix does not reach that far.
    pub fn density(&self, lean_squared: f64) -> Option<Rise> {
        let height_squared = self.slant * self.slant - lean_squared;
        if height_squared.is_nan() || height_squared <= 0.0 {
            return None;
        }
        let height = height_squared.sqrt();
        // |d|²/(L + √…) is the same number without the cancellation at small lean.
        let value = self.factor * lean_squared / (self.slant + height);
        Some(Rise { value, first: 0.5 * self.factor / height, second: 0.25 * self.factor / (height * height_squared) })
    }

    /// The same of eight generatrices: density, first and second derivative; and 1 where the generatrix reaches so far, else 0.
    #[inline(always)]
    pub fn densities<V: Vector>(&self, lean_squared: V) -> ([V; 3], V) {
        let height_squared = V::all(self.slant * self.slant) - lean_squared;
        let reaches = V::choose(V::zero(), height_squared, V::all(1.0), V::zero());
        let height = height_squared.sqrt();
        let value = lean_squared * self.factor / (height + self.slant);
        let first = V::all(0.5 * self.factor) / height;
        ([value, first, first * 0.5 / height_squared], reaches)
    }
}
