//! Questions that need several layers at once.

mod as_measured;
pub mod baseline;
pub mod campaign;
pub mod check;
pub mod comparison;
pub mod further;
pub mod desirable;
pub mod fidelities;
pub mod identify;
pub mod intervals;
pub mod irregular;
pub mod lack_of_fit;
pub mod overview;
pub mod paper;
pub mod response;
pub mod surface;
