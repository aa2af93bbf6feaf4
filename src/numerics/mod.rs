//! Mathematics with no textile word in it.

pub mod double_double;
pub mod dual;
pub mod jet;
pub mod lanes;
pub mod layers;
pub mod least_squares;
pub mod minimize;
pub mod pivoted_qr;
pub mod quadrature;
