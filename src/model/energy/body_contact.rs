//! Contact with the hips: a wall around a body of revolution about the axis of the skirt.

use super::barrier::Barrier;
use crate::error::Error;
use crate::experiment::Skirt;
use crate::experiment::scene::{Body, BodyShape};
use crate::numerics::jet::Jet;
use crate::units::MILLIMETRE;

/// Ease of the waist where the body's own waist is not given, m: the thickness of a waistband.
pub const EASE: f64 = 2.0 * MILLIMETRE;
/// From how far the wall is felt, m: a few thicknesses of cloth, and wide enough for the grid to see.
pub const REACH: f64 = 3.0 * MILLIMETRE;
/// The cone and the cylinder of the hips meet in a rounding of about this size, m.
const ROUNDING: f64 = 20.0 * MILLIMETRE;

/// The wall around one body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyContact {
    form: Form,
    barrier: Barrier,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Form {
    /// Radius at the waist and at the hips, and their slope.
    Cone {
        waist: f64,
        hip: f64,
        slope: f64,
    },
    Cylinder {
        radius: f64,
    },
    Ellipsoid {
        equator: f64,
        depth: f64,
        half_height: f64,
    },
}

impl BodyContact {
    /// `weight` is ρ_A g, N/m²: the wall is made firm enough to hold it.
    ///
    /// # Errors
    /// [`Error::Unanswerable`] where the body does not go through the waist of the skirt, or its hips through the skirt.
    pub fn new(skirt: &Skirt, body: &Body, weight: f64) -> Result<Self, Error> {
        let ring = skirt.waist_radius().0;
        let hip = body.hip_radius.0;
        let waist = body.waist_radius.map_or((ring - EASE).min(hip), |radius| radius.0);
        let depth = body.hip_depth.map_or(0.0, |depth| depth.0);
        let needs_depth = || Error::Unanswerable("hips that are no cylinder need the height of the waist above them".into());
        let form = match body.shape {
            BodyShape::Cylinder => Form::Cylinder { radius: hip },
            BodyShape::Cone if depth <= 0.0 => return Err(needs_depth()),
            BodyShape::Cone if hip <= waist => {
                return Err(Error::Unanswerable("a cone of hips must be wider than its waist; use shape = \"cylinder\"".into()));
            }
            BodyShape::Cone => Form::Cone { waist, hip, slope: (hip - waist) / depth },
            BodyShape::Ellipsoid if depth <= 0.0 => return Err(needs_depth()),
            // Through the waist: (R_waist/a)² + (depth/c)² = 1.
            BodyShape::Ellipsoid => {
                let share = 1.0 - (waist / hip).powi(2);
                if share <= 1e-6 {
                    return Err(Error::Unanswerable("an ellipsoid of hips must be wider than its waist; use shape = \"cylinder\"".into()));
                }
                Form::Ellipsoid { equator: hip, depth, half_height: depth / share.sqrt() }
            }
        };
        let contact = BodyContact { form, barrier: Barrier::against(weight, REACH) };
        let millimetres = |x: f64| x / MILLIMETRE;
        let at_waist = contact.gap(Jet::<0>::constant(ring), Jet::constant(0.0)).value;
        if at_waist.is_nan() || at_waist <= 0.0 {
            let problem = format!("the body does not go through the waist: it is {:.1} mm wider in radius there", millimetres(-at_waist));
            return Err(Error::Unanswerable(problem));
        }
        if let Some((depth, lack)) = contact.tightest(skirt) {
            let (depth, lack) = (millimetres(depth), millimetres(lack));
            return Err(Error::Unanswerable(format!(
                "the hips do not go through the skirt: {depth:.0} mm below the waist its ring is {lack:.1} mm too narrow in radius"
            )));
        }
        Ok(contact)
    }

    /// Where along the round skirt a ring is narrower than the body, and by how much, m.
    fn tightest(&self, skirt: &Skirt) -> Option<(f64, f64)> {
        let (waist, slant, conicity) = (skirt.waist_radius().0, skirt.slant_length().0, skirt.conicity());
        let fall = (1.0 - conicity * conicity).sqrt();
        (1..=400)
            .map(|i| f64::from(i) / 400.0 * slant)
            .map(|l| (l * fall, -self.gap(Jet::<0>::constant(waist + l * conicity), Jet::constant(l * fall)).value))
            .filter(|(_, lack)| 0.0 <= *lack)
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Distance from the body, m, at distance `radius` from the axis and `depth` below the waist; never more than the true one.
    pub fn gap<const N: usize>(&self, radius: Jet<N>, depth: Jet<N>) -> Jet<N> {
        match self.form {
            Form::Cylinder { radius: own } => radius - own,
            Form::Cone { waist, hip, slope } => {
                // The lesser of cone and cylinder, rounded where they meet.
                let (cone, past) = (depth * slope + waist, depth * slope + (waist - hip));
                let body = (cone + hip - (past.square() + (slope * ROUNDING).powi(2)).sqrt()) * 0.5;
                (radius - body) * (1.0 / slope.hypot(1.0))
            }
            Form::Ellipsoid { equator, depth: centre, half_height } => {
                let level = ((radius * (1.0 / equator)).square() + ((depth - centre) * (1.0 / half_height)).square()).sqrt();
                (level - 1.0) * equator.min(half_height)
            }
        }
    }

    /// J/m² at (x, y, z); `Some(None)` out of the wall's reach, `None` inside the body.
    pub fn density<const N: usize>(&self, x: Jet<N>, y: Jet<N>, z: Jet<N>) -> Option<Option<Jet<N>>> {
        let radius = (x.square() + y.square()).sqrt();
        self.barrier.density(self.gap(radius, z * -1.0), self.barrier.reach)
    }

    /// Gap at (x, y, z), m.
    pub fn gap_at(&self, x: f64, y: f64, z: f64) -> f64 {
        self.gap(Jet::<0>::constant(x.hypot(y)), Jet::constant(-z)).value
    }

    pub fn barrier(&self) -> Barrier {
        self.barrier
    }
}
