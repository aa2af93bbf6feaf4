//! Questions that need several layers at once.

pub mod baseline;
pub mod campaign;
pub mod check;
pub mod comparison;
pub mod overview;
pub mod response;
