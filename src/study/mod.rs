//! Questions that need several layers at once.

pub mod accuracy;
mod as_measured;
pub mod baseline;
pub mod campaign;
pub mod check;
pub mod clock;
pub mod comparison;
pub mod further;
pub mod desirable;
pub mod draped;
pub mod drawn;
pub mod fidelities;
pub mod hard_cases;
pub mod identify;
pub mod intervals;
pub mod irregular;
pub mod lack_of_fit;
pub mod optimum;
pub mod overview;
pub mod paper;
pub mod part;
pub mod response;
pub mod stability;
pub mod terms;
pub mod surface;
