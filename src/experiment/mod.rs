//! What was measured, on what, under which treatment.

pub mod campaign;
pub mod check;
pub mod design;
mod neighbours;
mod ordering;
pub mod polygon;
pub mod profile;
pub mod provenance;
pub mod scene;
pub mod specimen;
pub mod surface;
mod tour;

pub use campaign::Campaign;
pub use check::CheckRules;
pub use design::{Design, Factor, Run};
pub use profile::{DrapeProfile, Point};
pub use provenance::{Quarantined, Source};
pub use scene::Scene;
pub use specimen::{Apparatus, Fabric, Skirt};
