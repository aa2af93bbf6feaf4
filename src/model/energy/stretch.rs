//! Stretch of rings and generatrices: a stiffness in place of exact inextensibility.

use crate::numerics::jet::Jet;

/// `U = ∫∫ (K_r/2) ε² + (K_g/2) η² dA`: ε the relative stretch of a ring, η that of a generatrix, beyond what the theory holds to its length.
///
/// Both are unknowns that exist only where this term is in. As K grows they vanish like 1/K, and the inextensible hem is left. In the ruled shell,
/// whose rings between waist and hem are not held to their length, a stretch ε of the hem adds `ε u R_n/R(u)` to the ring at fraction u, and that is charged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// K_r, N/m.
    pub rings: f64,
    /// K_g, N/m.
    pub generatrices: f64,
}

impl Stretch {
    /// Strain that corresponds to one unit of an unknown, for rings and generatrices: of the order of what the cloth's own weight causes, so that the
    /// unknowns are of order one whatever the stiffness. `load` is a tension, N/m.
    pub fn scales(&self, load: f64) -> (f64, f64) {
        (load / self.rings, load / self.generatrices)
    }

    /// J/m² of cloth.
    pub fn density<const N: usize>(&self, ring: Jet<N>, generatrix: Jet<N>) -> Jet<N> {
        ring.square() * (0.5 * self.rings) + generatrix.square() * (0.5 * self.generatrices)
    }
}
