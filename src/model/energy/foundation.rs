//! The paper's elastic foundation: springs that draw the cloth to the cylinder below the waist.

use crate::experiment::Skirt;
use crate::numerics::jet::Jet;

/// `U = ∫∫ (E/2) (r − R_t)² dA`, E a foundation modulus in N/m³, r the distance from the axis: the paper's `(E/2)(R_t − r)²` (its equation 10), which it
/// writes for the hem alone, at every ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foundation {
    modulus: f64,
    waist: f64,
}

impl Foundation {
    /// `modulus` is E, N/m³.
    pub fn new(skirt: &Skirt, modulus: f64) -> Self {
        Foundation { modulus, waist: skirt.waist_radius().0 }
    }

    /// E, N/m³.
    pub fn modulus(&self) -> f64 {
        self.modulus
    }

    /// J/m² at plan position (x, y); `None` on the axis, where r has no derivative.
    pub fn density<const N: usize>(&self, x: Jet<N>, y: Jet<N>) -> Option<Jet<N>> {
        let square = x.square() + y.square();
        (0.0 < square.value).then(|| (square.sqrt() - self.waist).square() * (0.5 * self.modulus))
    }
}
