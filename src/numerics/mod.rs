//! Mathematics with no textile word in it.

pub mod jet;
pub mod minimize;
pub mod quadrature;
pub mod double_double;
pub mod pivoted_qr;
