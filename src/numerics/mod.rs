//! Mathematics with no textile word in it.

pub mod dual;
pub mod jet;
pub mod minimize;
pub mod quadrature;
