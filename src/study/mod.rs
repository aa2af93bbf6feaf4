//! Questions that need several layers at once.

pub mod campaign;
pub mod comparison;
pub mod fidelities;
pub mod overview;
pub mod paper;
pub mod response;
