//! Files → experiment; every input fault is found and located here.

pub mod numbers;

pub use crate::experiment::provenance::{Quarantined, Source};
