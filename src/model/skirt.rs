//! The cone and its flat pattern (paper, Figure 1 and Table 1).

use std::f64::consts::{FRAC_PI_2, TAU};

use serde::Serialize;

use crate::error::Error;
use crate::experiment::{Point, Skirt};
use crate::units::Metre;

/// Everything that follows from waist radius, hem radius and slant; m and rad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cone {
    /// R_t.
    pub waist_radius: f64,
    /// R_n.
    pub hem_radius: f64,
    /// L.
    pub slant_length: f64,
    /// β between generatrix and base; π/2 for a cylinder.
    pub base_angle: f64,
    /// H = L sin β.
    pub height: f64,
    /// R_v = R_t/cos β, the inner radius of the flat pattern; `None` for a cylinder, whose pattern is a rectangle.
    pub pattern_radius: Option<f64>,
    /// α = 2π cos β, the central angle of the flat pattern.
    pub pattern_angle: f64,
}

impl Cone {
    pub fn of(skirt: &Skirt) -> Self {
        let (waist, hem, slant) = (skirt.waist_radius().0, skirt.hem_radius().0, skirt.slant_length().0);
        let cos = skirt.conicity();
        // (L − ΔR)(L + ΔR) keeps its digits where the cone is nearly flat.
        let lean = hem - waist;
        let height = ((slant - lean).max(0.0) * (slant + lean)).sqrt();
        Cone {
            waist_radius: waist,
            hem_radius: hem,
            slant_length: slant,
            base_angle: if lean == 0.0 { FRAC_PI_2 } else { height.atan2(lean) },
            height,
            pattern_radius: (0.0 < lean).then(|| waist * slant / lean),
            pattern_angle: TAU * cos,
        }
    }

    /// R(ℓ) = R_t + ℓ cos β at slant distance ℓ from the waist, m.
    pub fn ring_radius(&self, slant_distance: f64) -> f64 {
        self.waist_radius + (self.hem_radius - self.waist_radius) * slant_distance / self.slant_length
    }

    /// The closed outline of the flat pattern, m: waist arc and hem arc of `n` points each, symmetric about the y axis; a rectangle for a cylinder.
    pub fn pattern(&self, n: usize) -> Vec<Point> {
        let at = |fraction: f64, distance: f64| match self.pattern_radius {
            Some(inner) => {
                let (sin, cos) = (self.pattern_angle * (fraction - 0.5)).sin_cos();
                Point::new((inner + distance) * sin, -(inner + distance) * cos)
            }
            None => Point::new(TAU * self.waist_radius * (fraction - 0.5), -distance),
        };
        let steps = n.max(2) - 1;
        let waist = (0..=steps).map(|i| at(i as f64 / steps as f64, 0.0));
        let hem = (0..=steps).rev().map(|i| at(i as f64 / steps as f64, self.slant_length));
        waist.chain(hem).collect()
    }
}

/// The skirt that touches waist and hip of a body: `tan β = h/(R_hip − R_waist)`, girths and the height h between them in m, slant L.
///
/// # Errors
/// [`Error::Invalid`] unless the waist girth is positive, the hip no narrower than it, and h and L positive.
pub fn from_body(waist_girth: Metre, hip_girth: Metre, hip_depth: Metre, slant_length: Metre) -> Result<Skirt, Error> {
    Skirt::from_body(waist_girth, hip_girth, hip_depth, slant_length)
}

/// The paper's thin-shell test (1): δ = h_T/(2πR_t), and whether it is below 1/20. `thickness` in m.
pub fn thinness(skirt: &Skirt, thickness: f64) -> (f64, bool) {
    let delta = thickness / (TAU * skirt.waist_radius().0);
    (delta, delta < 1.0 / 20.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table_one() -> Skirt {
        from_body(Metre(0.76), Metre(1.04), Metre(0.20), Metre(0.53)).unwrap()
    }

    #[test]
    fn table_one_follows_from_the_body() {
        // Birthplace: the paper's Table 1, cm and rad as printed; half a unit of the last digit, plus its own rounding.
        let cone = Cone::of(&table_one());
        let expected = [
            (cone.waist_radius, 0.121, 0.5e-3),
            (cone.base_angle, 1.35, 0.5e-2),
            (cone.hem_radius, 0.2362, 0.5e-4),
            (cone.height, 0.5173, 0.5e-4),
            (cone.pattern_radius.unwrap(), 0.5562, 0.5e-4),
            (cone.pattern_angle, 1.37, 0.5e-2),
        ];
        for (value, printed, half_a_unit) in expected {
            assert!((value - printed).abs() <= half_a_unit, "{value} {printed}");
        }
        assert!((cone.ring_radius(0.53) - cone.hem_radius).abs() < 1e-15);
    }

    #[test]
    fn pattern_rolls_up_into_the_cone() {
        for skirt in [
            table_one(),
            Skirt::new(Metre(0.121), Metre(0.121), Metre(0.53)).unwrap(),
            Skirt::drapemeter(Metre(0.09), Metre(0.15)).unwrap(),
        ] {
            let cone = Cone::of(&skirt);
            let outline = cone.pattern(4000);
            let length = |part: &[Point]| part.windows(2).map(|p| p[0].distance(p[1])).sum::<f64>();
            // 4 000 chords of an arc of α ≤ 2π are short by α²/24n² ~ 1e-7.
            assert!((length(&outline[..4000]) / (TAU * cone.waist_radius) - 1.0).abs() < 1e-6);
            assert!((length(&outline[4000..]) / (TAU * cone.hem_radius) - 1.0).abs() < 1e-6);
            assert!((outline[3999].distance(outline[4000]) - cone.slant_length).abs() < 1e-12);
        }
    }

    #[test]
    fn flat_and_upright_cones_have_their_limits() {
        let upright = Cone::of(&Skirt::new(Metre(0.121), Metre(0.121), Metre(0.53)).unwrap());
        assert_eq!((upright.base_angle, upright.height, upright.pattern_radius, upright.pattern_angle), (FRAC_PI_2, 0.53, None, 0.0));
        let flat = Cone::of(&Skirt::drapemeter(Metre(0.09), Metre(0.15)).unwrap());
        assert!(flat.base_angle < 1e-7 && flat.height < 1e-8);
        assert!((flat.pattern_radius.unwrap() - 0.09).abs() < 1e-15);
        assert!(from_body(Metre(1.0), Metre(0.9), Metre(0.2), Metre(0.5)).is_err());
        assert_eq!(thinness(&table_one(), 1e-3), (1e-3 / 0.76, true));
    }
}
