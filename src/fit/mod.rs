//! Inverse: profile → parameters, by orthogonal least squares.

mod base;
pub mod bias;
pub mod bootstrap;
pub mod circle;
mod estimating;
pub mod folds;
pub mod foot_point;
pub mod intervals;
pub mod lambda;
pub mod matching;
pub mod orthogonal;
pub mod outcome;
pub mod outline;
pub mod profile_likelihood;
pub mod rules;
pub mod start;
mod trial;
pub mod uncertainty;

pub use bias::BiasCorrection;
pub use folds::{Options, fit};
pub use intervals::Intervals;
pub use outcome::{Candidate, Estimate, HeldLength, HemFit, Rule, Termination};
