//! Contact of neighbouring folds: by symmetry a wall in the mirror planes of each fold.
//!
//! Between a crest and the next valley the cloth of one half fold meets its own copies in two planes through the axis: that of the crest, where the two
//! flanks of one fold touch, and that of the valley, where neighbouring folds do. The gap is the distance from the plane; the true one is twice that.

use std::f64::consts::PI;

use super::barrier::Barrier;
use crate::numerics::jet::Jet;
use crate::units::MILLIMETRE;

/// From how far the wall is felt at most, m.
const REACH: f64 = 2.0 * MILLIMETRE;

/// The walls between folds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfContact {
    barrier: Barrier,
    /// Half the thickness of the cloth, m.
    half_thickness: f64,
}

impl SelfContact {
    /// `weight` is ρ_A g, N/m²; `thickness` of the cloth and its `slant`, m.
    pub fn new(weight: f64, thickness: f64, slant: f64) -> Self {
        // Never more than a fiftieth of the slant, so that a doll's skirt is judged like a large one.
        SelfContact { barrier: Barrier::against(weight, REACH.min(slant / 50.0)), half_thickness: 0.5 * thickness }
    }

    pub fn barrier(&self) -> Barrier {
        self.barrier
    }

    /// How much of the wall is felt at arc length `s` from the plane along the ring: cloth that joins the plane at right angles is no contact.
    fn share(&self, s: f64) -> f64 {
        // Full some reaches away; near the plane the reach shrinks faster than the cloth approaches it.
        let square = s * s;
        square / (square + (4.0 * self.barrier.reach).powi(2))
    }

    /// Distances from the planes of crest and valley, m, of the cloth at material angle `sigma` whose position in the frame that turns with it is (x, y).
    fn distances<const N: usize>(&self, folds: u32, sigma: f64, x: Jet<N>, y: Jet<N>) -> [Jet<N>; 2] {
        let (sin, cos) = sigma.sin_cos();
        let (sin_rest, cos_rest) = (PI / f64::from(folds) - sigma).sin_cos();
        [x * sin + y * cos, x * sin_rest - y * cos_rest]
    }

    /// J/m² of the cloth of a ring of cut radius `ring`; `Some(None)` out of reach, `None` where the folds would pass through each other.
    pub fn density<const N: usize>(&self, folds: u32, sigma: f64, ring: f64, x: Jet<N>, y: Jet<N>) -> Option<Option<Jet<N>>> {
        let arcs = [ring * sigma, ring * (PI / f64::from(folds) - sigma)];
        let mut sum: Option<Jet<N>> = None;
        for (distance, arc) in self.distances(folds, sigma, x, y).into_iter().zip(arcs) {
            let share = self.share(arc.max(0.0));
            let reach = self.barrier.reach * share;
            // On the plane itself the cloth is its own copy.
            if reach <= 1e-9 * self.barrier.reach {
                continue;
            }
            if let Some(felt) = self.barrier.density(distance - self.half_thickness * share, reach)? {
                sum = Some(sum.map_or(felt, |sum| sum + felt));
            }
        }
        Some(sum)
    }

    /// Free distance between the faces of neighbouring flanks, m; `None` so near to the plane that cloth is its own neighbour.
    pub fn gap_at(&self, folds: u32, sigma: f64, ring: f64, x: f64, y: f64) -> Option<f64> {
        let arcs = [ring * sigma, ring * (PI / f64::from(folds) - sigma)];
        let distances = self.distances(folds, sigma, Jet::<0>::constant(x), Jet::constant(y));
        let gaps = distances.into_iter().zip(arcs).filter(|(_, arc)| 4.0 * self.barrier.reach <= *arc);
        gaps.map(|(distance, _)| 2.0 * (distance.value - self.half_thickness)).min_by(f64::total_cmp)
    }
}
