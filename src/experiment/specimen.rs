//! The cloth and its cut: what hangs.

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::units::{KilogramPerSquareMetre, Metre, NewtonMetre};

/// What the specimen hangs from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Apparatus {
    /// A conic skirt hanging from a waist ring.
    Skirt,
    /// A flat disc of cloth on a support disc (Cusick): a cone of base angle β = 0.
    Drapemeter,
}

/// Cloth as the theory sees it; `None` where the laboratory did not measure it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Fabric {
    /// Mass per area ρ_A.
    pub areal_density: Option<KilogramPerSquareMetre>,
    /// Flexural rigidity B.
    pub flexural_rigidity: Option<NewtonMetre>,
}

/// The cut: a truncated cone of cloth, waist radius R_t, hem radius R_n, slant length L. `cos β = (R_n − R_t)/L`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Skirt {
    waist_radius: Metre,
    hem_radius: Metre,
    slant_length: Metre,
}

impl Skirt {
    /// A cone cut from cloth.
    ///
    /// # Errors
    /// [`Error::Invalid`] unless 0 < R_t ≤ R_n and R_n − R_t ≤ L, all finite: no cone has a hem further out than its cloth reaches.
    pub fn new(waist_radius: Metre, hem_radius: Metre, slant_length: Metre) -> Result<Self, Error> {
        let (waist, hem, slant) = (waist_radius.0, hem_radius.0, slant_length.0);
        if !(waist.is_finite() && 0.0 < waist) {
            return Err(Error::Invalid { quantity: "waist radius, m", value: waist, allowed: "> 0" });
        }
        if !(hem.is_finite() && waist <= hem) {
            return Err(Error::Invalid { quantity: "hem radius, m", value: hem, allowed: ">= the waist radius" });
        }
        // The drape tester is the limit R_n − R_t = L; allow for the rounding of that subtraction.
        if !(slant.is_finite() && 0.0 < slant && hem - waist <= slant * (1.0 + 1e-12)) {
            return Err(Error::Invalid { quantity: "slant length, m", value: slant, allowed: ">= hem radius − waist radius, > 0" });
        }
        Ok(Skirt { waist_radius, hem_radius, slant_length })
    }

    /// The skirt that touches waist and hip of a body: `tan β = h/(R_hip − R_waist)`, girths and the height h between them in m, slant L.
    ///
    /// # Errors
    /// [`Error::Invalid`] unless the waist girth is positive, the hip no narrower than it, and h and L positive.
    pub fn from_body(waist_girth: Metre, hip_girth: Metre, hip_depth: Metre, slant_length: Metre) -> Result<Self, Error> {
        let (waist, hip) = (waist_girth.0 / std::f64::consts::TAU, hip_girth.0 / std::f64::consts::TAU);
        if !(hip.is_finite() && waist <= hip) {
            return Err(Error::Invalid { quantity: "hip girth, m", value: hip_girth.0, allowed: ">= the waist girth" });
        }
        if !(hip_depth.0.is_finite() && 0.0 < hip_depth.0) {
            return Err(Error::Invalid { quantity: "height between waist and hip, m", value: hip_depth.0, allowed: "> 0" });
        }
        let cos = (hip - waist) / (hip - waist).hypot(hip_depth.0);
        Skirt::new(Metre(waist), Metre(waist + slant_length.0 * cos), slant_length)
    }

    /// The disc of a drape tester: support disc R_t, specimen R_n, L = R_n − R_t, β = 0.
    ///
    /// # Errors
    /// [`Error::Invalid`] unless 0 < R_t < R_n.
    pub fn drapemeter(support_radius: Metre, specimen_radius: Metre) -> Result<Self, Error> {
        Skirt::new(support_radius, specimen_radius, Metre(specimen_radius.0 - support_radius.0))
    }

    /// R_t, m.
    pub fn waist_radius(&self) -> Metre {
        self.waist_radius
    }

    /// R_n, m.
    pub fn hem_radius(&self) -> Metre {
        self.hem_radius
    }

    /// L, m.
    pub fn slant_length(&self) -> Metre {
        self.slant_length
    }

    /// cos β = (R_n − R_t)/L, at most 1.
    pub fn conicity(&self) -> f64 {
        ((self.hem_radius.0 - self.waist_radius.0) / self.slant_length.0).min(1.0)
    }
}
