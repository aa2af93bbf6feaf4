//! Mathematics with no textile word in it.

pub mod least_squares;
