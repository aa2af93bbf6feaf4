//! Inverse: profile → parameters, by orthogonal least squares.

pub mod circle;
pub mod even;
pub mod folds;
pub mod foot_point;
mod frame;
pub mod lambda;
pub mod matching;
pub mod orthogonal;
pub mod outcome;
pub mod outline;
pub mod rules;
mod sampling;
pub mod start;
mod swift;
mod trial;

pub use folds::{Options, fit};
pub use outcome::{Candidate, Estimate, HeldLength, HemFit, Rule, Termination};
