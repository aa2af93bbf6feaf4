//! Shear of the weave: the angle between rings and generatrices.

use crate::numerics::jet::Jet;

/// `U = ∫∫ (S/2) γ² dA`, `γ² = F²/(E G)` with the first fundamental form of the cloth along ring and generatrix, which cross at right angles in the cone.
///
/// The graded shell has this term in its own sweep (`graded`), where rings and generatrices keep their length; this is the same density for any shell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shear {
    stiffness: f64,
}

impl Shear {
    /// `stiffness` is S, N/m.
    pub fn new(stiffness: f64) -> Self {
        Shear { stiffness }
    }

    /// S, N/m.
    pub fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// J/m² from F, E and G in one unit.
    pub fn density<const N: usize>(&self, f: Jet<N>, e: Jet<N>, g: Jet<N>) -> Jet<N> {
        f.square() / (e * g) * (0.5 * self.stiffness)
    }
}
