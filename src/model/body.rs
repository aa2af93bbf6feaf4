//! Whether hips touch a skirt: the gap between a round cone of cloth and a body of revolution below its waist.

use std::f64::consts::{PI, TAU};

use serde::Serialize;

use super::skirt::Cone;
use crate::error::Error;
use crate::experiment::scene::BodyShape;
use crate::units::Metre;

/// A body: girths over 2π, and the height between them, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    waist_radius: f64,
    hip_radius: f64,
    hip_depth: f64,
}

/// The gap between the round cone and a body of one shape.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HipGap {
    pub shape: BodyShape,
    /// Horizontal gap at hip height, m; negative where the hips are wider than the cone. `None` where the skirt ends above the hips.
    pub at_hips: Option<f64>,
    /// The least gap below the waist at right angles to the cloth, m; negative: so far the body pushes it out.
    pub least: f64,
    /// How far below the waist that is, m.
    pub least_depth: f64,
    /// Whether the body reaches the cloth of the round cone somewhere below the waist, within [`TOUCH`].
    pub touches: bool,
}

/// Cloth this near to a body lies on it, m: half the thickness of thin cloth.
pub const TOUCH: f64 = 1e-4;

impl Body {
    /// Girths of waist and hips and the height between them.
    ///
    /// # Errors
    /// [`Error::Invalid`] unless the waist girth is positive, the hip no narrower, and the height positive.
    pub fn new(waist_girth: Metre, hip_girth: Metre, hip_depth: Metre) -> Result<Self, Error> {
        if !(waist_girth.0.is_finite() && 0.0 < waist_girth.0) {
            return Err(Error::Invalid { quantity: "waist girth, m", value: waist_girth.0, allowed: "> 0" });
        }
        if !(hip_girth.0.is_finite() && waist_girth.0 <= hip_girth.0) {
            return Err(Error::Invalid { quantity: "hip girth, m", value: hip_girth.0, allowed: ">= the waist girth" });
        }
        if !(hip_depth.0.is_finite() && 0.0 < hip_depth.0) {
            return Err(Error::Invalid { quantity: "height between waist and hip, m", value: hip_depth.0, allowed: "> 0" });
        }
        Ok(Body { waist_radius: waist_girth.0 / TAU, hip_radius: hip_girth.0 / TAU, hip_depth: hip_depth.0 })
    }

    /// R_b, m.
    pub fn hip_radius(&self) -> f64 {
        self.hip_radius
    }

    /// Height between waist and hips, m.
    pub fn hip_depth(&self) -> f64 {
        self.hip_depth
    }

    /// Radius of the body `depth` (m) below the waist; `None` where it has no surface there.
    ///
    /// Below the hips a cone goes on upright, as the body that the paper's cone lies on; between waist and hips a cylinder is nowhere; an ellipsoid goes
    /// on to its lower pole.
    pub fn radius(&self, shape: BodyShape, depth: f64) -> Option<f64> {
        let (waist, hip, h) = (self.waist_radius, self.hip_radius, self.hip_depth);
        match shape {
            BodyShape::Cone => (0.0 <= depth).then(|| waist + (hip - waist) * (depth / h).min(1.0)),
            BodyShape::Cylinder => (h <= depth).then_some(hip),
            BodyShape::Ellipsoid => {
                // R_b √(1 − (z/c)²) about the hips, with c from the radius at the waist.
                let shrunk = 1.0 - (waist / hip).powi(2);
                let square = 1.0 - shrunk * (depth / h - 1.0).powi(2);
                (0.0 <= depth && 0.0 <= square).then(|| hip * square.sqrt())
            }
        }
    }

    /// The gap between the round cone and this body.
    pub fn gap(&self, cone: &Cone, shape: BodyShape) -> HipGap {
        let growth = if cone.height <= 0.0 { 0.0 } else { (cone.hem_radius - cone.waist_radius) / cone.height };
        // At right angles to the cloth a horizontal gap is sin β of itself.
        let sine = cone.base_angle.sin();
        let gap = |depth: f64| self.radius(shape, depth).map(|body| cone.waist_radius + growth * depth - body);
        // The waist itself is where the skirt is held. The least gap is at an end of a straight piece, or where the ellipsoid is parallel to the
        // cone; a golden section between thousandths of the height finds the latter.
        const CELLS: usize = 1000;
        let first = cone.height / CELLS as f64;
        let depths = (1..=CELLS).map(|i| first * i as f64).chain([self.hip_depth]).filter(|d| *d <= cone.height);
        let known = depths.filter_map(|depth| gap(depth).map(|g| (g, depth)));
        let (mut least, mut at) = known.fold((f64::INFINITY, 0.0), |a, b| if b.0 < a.0 { b } else { a });
        if shape == BodyShape::Ellipsoid && least.is_finite() {
            let (mut low, mut high) = ((at - first).max(first), (at + first).min(cone.height));
            let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
            for _ in 0..60 {
                let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
                let worse = |d: f64| gap(d).unwrap_or(f64::INFINITY);
                if worse(a) < worse(b) { high = b } else { low = a }
            }
            let middle = 0.5 * (low + high);
            if let Some(g) = gap(middle).filter(|g| *g < least) {
                (least, at) = (g, middle);
            }
        }
        let at_hips = if self.hip_depth <= cone.height { gap(self.hip_depth) } else { None };
        HipGap { shape, at_hips, least: least * sine, least_depth: at, touches: least * sine <= TOUCH }
    }
}

/// Area of the cone's cloth between waist and hem, m²: that of the flat pattern without allowances.
pub fn cloth_area(cone: &Cone) -> f64 {
    PI * (cone.waist_radius + cone.hem_radius) * cone.slant_length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Skirt;
    use crate::model::skirt::from_body;

    fn body() -> Body {
        Body::new(Metre(0.76), Metre(1.04), Metre(0.20)).unwrap()
    }

    #[test]
    fn the_skirt_cut_for_a_body_lies_on_it_as_a_cone_and_meets_a_cylinder_at_the_hips() {
        let cone = Cone::of(&from_body(Metre(0.76), Metre(1.04), Metre(0.20), Metre(0.53)).unwrap());
        for shape in [BodyShape::Cone, BodyShape::Cylinder] {
            let gap = body().gap(&cone, shape);
            assert!(gap.at_hips.unwrap().abs() < 1e-12 && gap.touches && gap.least.abs() < 1e-12, "{gap:?}");
        }
        assert!((body().gap(&cone, BodyShape::Cylinder).least_depth - 0.20).abs() < 1e-12);
    }

    #[test]
    fn round_hips_bulge_out_of_the_cone_by_the_closed_form() {
        let cone = Cone::of(&from_body(Metre(0.76), Metre(1.04), Metre(0.20), Metre(0.53)).unwrap());
        let gap = body().gap(&cone, BodyShape::Ellipsoid);
        // The chord r = R_t + z g of an ellipse r²/R² + (z − h)²/c² = 1: the point of the ellipse with the chord's slope is furthest out,
        // r = R cos φ, z − h = −c sin φ with tan φ = g c/R; its height over the chord is R cos φ + c g sin φ − (R_t + g h).
        let (waist, hip, h) = (0.76 / TAU, 1.04 / TAU, 0.20);
        let c = h / (1.0 - (waist / hip) * (waist / hip)).sqrt();
        let g = (hip - waist) / h;
        let phi = (g * c / hip).atan();
        let bulge = hip * phi.cos() + c * g * phi.sin() - (waist + g * h);
        assert!((gap.least + bulge * cone.base_angle.sin()).abs() < 1e-10, "{gap:?} {bulge}");
        assert!((gap.least_depth - (h - c * phi.sin())).abs() < 1e-6 && gap.touches);
    }

    #[test]
    fn a_wider_cone_is_free_and_a_short_one_says_that_it_ends_above_the_hips() {
        let wide = Cone::of(&Skirt::new(Metre(0.121), Metre(0.36), Metre(0.53)).unwrap());
        let gap = body().gap(&wide, BodyShape::Cylinder);
        let growth = (0.36 - 0.121) / wide.height;
        assert!(!gap.touches && (gap.at_hips.unwrap() - (0.121 + 0.2 * growth - 1.04 / TAU)).abs() < 1e-12);
        let short = Cone::of(&Skirt::new(Metre(0.121), Metre(0.14), Metre(0.1)).unwrap());
        assert_eq!(body().gap(&short, BodyShape::Cone).at_hips, None);
        assert!(Body::new(Metre(1.0), Metre(0.9), Metre(0.2)).is_err() && Body::new(Metre(0.0), Metre(0.9), Metre(0.2)).is_err());
    }
}
