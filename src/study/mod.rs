//! Questions that need several layers at once.

pub mod campaign;
pub mod paper;
