//! Stresses in the cloth: bending from its curvatures, membrane stress from the weight below, and von Mises' stress of both at either face.
//!
//! The cloth is flat before it is sewn, so all its curvature strains it. With `E_f = 12 B (1 − ν²)/h_T³` plane stress at the faces is
//! `± (6B/h_T²) ((1 − ν) κ + ν tr κ 1)` of the curvature tensor κ. A strip of cloth dσ wide carries its own weight below ℓ along its generatrix:
//! `N(ℓ) = ρ_A g ∫_ℓ^L R dℓ / (R · steepness)`, on the cone `ρ_A g · area below/(2πR sin β)`. Tension along the rings is left out: in equilibrium the
//! round cone presses there with ρ_A g R cot β, which slack cloth gives way to by folding.

use super::sample::{Grid, Shape};
use super::{Field, sample};
use crate::experiment::Skirt;

/// What is known of the cloth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sheet {
    /// ρ_A g, N/m².
    pub weight: Option<f64>,
    /// B, N·m.
    pub rigidity: Option<f64>,
    /// h_T, m.
    pub thickness: Option<f64>,
    /// ν.
    pub poisson: Option<f64>,
}

impl Sheet {
    /// What of `wanted` is not known, in words.
    fn missing(&self, wanted: &[&str]) -> Option<String> {
        let known = [
            ("areal density", self.weight.is_some()),
            ("flexural rigidity", self.rigidity.is_some()),
            ("thickness", self.thickness.is_some()),
            ("Poisson's ratio", self.poisson.is_some()),
        ];
        let absent: Vec<&str> = known.iter().filter(|(name, known)| !known && wanted.contains(name)).map(|(name, _)| *name).collect();
        (!absent.is_empty()).then(|| format!("not known of the cloth: {}", absent.join(", ")))
    }

    /// E_f = 12 B (1 − ν²)/h_T³, Pa; `None` where one of them is not known.
    pub fn modulus(&self) -> Option<f64> {
        let (rigidity, thickness, poisson) = (self.rigidity?, self.thickness?, self.poisson?);
        Some(12.0 * rigidity * (1.0 - poisson * poisson) / thickness.powi(3))
    }
}

/// Generatrices flatter than this hang from nothing: their tension grows beyond all bounds.
const FLATTEST: f64 = 1e-6;

/// The fields of stress, for each sample; or what is not known.
pub(super) fn stress(field: Field, skirt: &Skirt, grid: &Grid, shapes: &[Shape], sheet: &Sheet) -> Result<Vec<f64>, String> {
    const BENDING: [&str; 3] = ["flexural rigidity", "thickness", "Poisson's ratio"];
    const ALL: [&str; 4] = ["areal density", "flexural rigidity", "thickness", "Poisson's ratio"];
    let wanted: &[&str] = match field {
        Field::MembraneForce => &["areal density"],
        Field::MembraneStress => &["areal density", "thickness"],
        Field::BendingStressOuter | Field::BendingStressInner => &BENDING,
        _ => &ALL,
    };
    if let Some(reason) = sheet.missing(wanted) {
        return Err(reason);
    }
    let needs_weight = wanted.contains(&"areal density");
    if needs_weight && shapes.iter().any(|s| s.steepness < FLATTEST) {
        return Err("generatrices lie flat or rise somewhere: the weight below them does not hang from them".into());
    }
    let (weight, rigidity) = (sheet.weight.unwrap_or(0.0), sheet.rigidity.unwrap_or(0.0));
    let (thickness, poisson) = (sheet.thickness.unwrap_or(1.0), sheet.poisson.unwrap_or(0.0));
    let columns = grid.sigma.len();
    let cone = crate::model::skirt::Cone::of(skirt);
    // Per unit of cloth width: ρ_A g ∫ R dℓ below, over R.
    let hanging: Vec<f64> = grid
        .slant_distance
        .iter()
        .map(|&l| {
            let ring = cone.ring_radius(l);
            weight * (cone.slant_length - l) * 0.5 * (ring + cone.hem_radius) / ring
        })
        .collect();
    let force = |i: usize| hanging[i / columns] / shapes[i].steepness;
    let bending = |s: &Shape| {
        let (greatest, least) = s.principal();
        let kappa = if least.abs() <= greatest.abs() { greatest } else { least };
        sheet.modulus().unwrap_or(0.0) * thickness * kappa / 2.0
    };
    let intensity = |i: usize, face: f64| {
        let moment = face * 6.0 * rigidity / (thickness * thickness);
        let pull = force(i) / thickness;
        let sample::Shape { tensor: [k11, k12, k22], along: [d1, d2], .. } = shapes[i];
        let s11 = pull * d1 * d1 + moment * (k11 + poisson * k22);
        let s22 = pull * d2 * d2 + moment * (k22 + poisson * k11);
        let s12 = pull * d1 * d2 + moment * (1.0 - poisson) * k12;
        (s11 * s11 - s11 * s22 + s22 * s22 + 3.0 * s12 * s12).sqrt()
    };
    let all = |pick: &dyn Fn(usize, &Shape) -> f64| shapes.iter().enumerate().map(|(i, s)| pick(i, s)).collect();
    Ok(match field {
        Field::MembraneForce => all(&|i, _| force(i)),
        Field::MembraneStress => all(&|i, _| force(i) / thickness),
        Field::BendingStressOuter => all(&|_, s| bending(s)),
        Field::BendingStressInner => all(&|_, s| -bending(s)),
        Field::StressIntensityOuter => all(&|i, _| intensity(i, 1.0)),
        Field::StressIntensityInner => all(&|i, _| intensity(i, -1.0)),
        _ => all(&|i, _| intensity(i, 1.0).max(intensity(i, -1.0))),
    })
}
