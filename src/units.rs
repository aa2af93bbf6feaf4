//! SI newtypes for public signatures, and the only conversion factors in the crate.
//!
//! SI in memory; suffixes (`radius_mm`, `areal_density_g_m2`) live in files and flags and die at the border, here.

use serde::{Deserialize, Serialize};

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub f64);
    };
}

quantity!(
    /// Length, m.
    Metre
);
quantity!(
    /// Mass per area of a sheet, kg/m².
    KilogramPerSquareMetre
);
quantity!(
    /// Flexural rigidity of a sheet per width, N·m.
    NewtonMetre
);

/// One millimetre in metres.
pub const MILLIMETRE: f64 = 1e-3;
/// One centimetre in metres.
pub const CENTIMETRE: f64 = 1e-2;
/// One degree in radians.
pub const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// One gon, 1/400 of a turn, in radians.
pub const GON: f64 = std::f64::consts::PI / 200.0;
/// One inch in metres (exact by definition).
pub const INCH: f64 = 0.0254;
/// One gram per square metre in kg/m².
pub const GRAM_PER_SQUARE_METRE: f64 = 1e-3;
/// One micronewton metre in N·m.
pub const MICRONEWTON_METRE: f64 = 1e-6;
/// One millijoule in joules.
pub const MILLIJOULE: f64 = 1e-3;
/// One millinewton in newtons.
pub const MILLINEWTON: f64 = 1e-3;
/// One percent as a share.
pub const PERCENT: f64 = 1e-2;
/// Acceleration of free fall, m/s², as the reference numbers of docs/model.md use it.
pub const STANDARD_GRAVITY: f64 = 9.81;

/// The SI factor of a unit suffix as files and flags spell it (`mm`, `cm`, `m`, `in`, `g_m2`, `un_m` …); `None` if unknown.
pub fn factor(suffix: &str) -> Option<f64> {
    Some(match suffix {
        "um" => 1e-6,
        "mm" => MILLIMETRE,
        "cm" => CENTIMETRE,
        "m" => 1.0,
        "in" => INCH,
        "g_m2" => GRAM_PER_SQUARE_METRE,
        "kg_m2" => 1.0,
        "un_m" => MICRONEWTON_METRE,
        "n_m" | "n_m3" => 1.0,
        _ => return None,
    })
}
