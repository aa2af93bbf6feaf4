//! Inverse: profile → parameters, by orthogonal least squares.

pub mod lambda;
pub mod outcome;

pub use outcome::{Candidate, Estimate, HeldLength, HemFit, Rule, Termination};
