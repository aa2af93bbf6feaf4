//! A measured surface: horizontal sections of a drape, and the measured points beside them.

use super::profile::DrapeProfile;

/// The outline of a drape at one height.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// m, upwards.
    pub height: f64,
    pub profile: DrapeProfile,
}

/// What was measured of a surface, for the fit of the surface.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasuredSurface {
    /// Ascending in height.
    pub sections: Vec<Section>,
    /// Places on the surface, m: x, y in plan, z upwards. Of a mesh: its own vertices on either side of each section, because those were
    /// measured, while the points of a section are interpolated between them.
    pub points: Vec<[f64; 3]>,
    /// Pairs of neighbouring points, by their places in `points`; what their distances have in common is no chance.
    pub neighbours: Vec<[usize; 2]>,
}
