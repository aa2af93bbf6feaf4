//! Inverse: profile → parameters, by orthogonal least squares.

pub mod circle;
pub mod folds;
pub mod foot_point;
pub mod lambda;
pub mod limits;
pub mod matching;
pub mod orthogonal;
pub mod outcome;
pub mod outline;
pub mod rules;
pub mod start;
mod robust;
mod trial;

pub use folds::{Options, fit};
pub use limits::Limits;
pub use outcome::{Candidate, Estimate, HeldLength, HemFit, RobustOutcome, Rule, Termination};

// The words in which a fit is asked, for those who may not look into the numerics.
pub use crate::numerics::least_squares::{Limit, Loss};
