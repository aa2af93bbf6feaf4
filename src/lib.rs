//! How cloth drapes: import, fit, predict, regress, report.
//!
//! The layers in dependency order; data flows down this list and never up.

/// One file per command: arguments → options → library call → report.
pub mod cli;
/// What could not be done, where, with which value.
pub mod error;
/// What was measured, on what, under which treatment.
pub mod experiment;
/// Inverse: profile → parameters, by orthogonal least squares.
pub mod fit;
/// Files → experiment; every input fault is found and located here.
pub mod import;
/// What could explain a profile: the hem curve, the tangent-angle family, the cone, the energy terms.
pub mod model;
/// Mathematics with no textile word in it.
pub mod numerics;
/// Results → files; computes nothing.
pub mod report;
/// Forward: skirt + fabric + terms → predicted hem.
pub mod simulate;
/// Responses over the design; knows nothing of curves or cloth.
pub mod statistics;
/// Questions that need several layers at once.
pub mod study;
/// SI newtypes for public signatures, and the only conversion factors in the crate.
pub mod units;

pub use error::Error;
