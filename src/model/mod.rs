//! What could explain a profile: the hem curve, the tangent-angle family, the cone, the energy terms.

pub mod ansatz;
pub mod body;
pub mod energy;
pub mod field;
pub mod functional;
pub mod graded;
pub mod graded_terms;
pub mod height;
pub mod hem;
pub mod ruled_terms;
pub mod pattern;
pub mod skirt;
pub mod surface;
pub mod tangent;
pub mod tangent_hem;
