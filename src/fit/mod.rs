//! Inverse: profile → parameters, by orthogonal least squares.

mod base;
pub mod bias;
pub mod bootstrap;
pub mod circle;
mod estimating;
pub mod even;
pub mod folds;
pub mod foot_point;
mod frame;
pub mod intervals;
pub mod lambda;
pub mod matching;
pub mod orthogonal;
pub mod outcome;
pub mod outline;
pub mod profile_likelihood;
pub mod rules;
mod sampling;
pub mod start;
mod swift;
mod trial;
pub mod uncertainty;

pub use bias::BiasCorrection;
pub use folds::{Options, fit};
pub use intervals::Intervals;
pub use outcome::{Candidate, Estimate, HeldLength, HemFit, Rule, Termination};
