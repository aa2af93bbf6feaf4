//! Mathematics with no textile word in it.

pub mod double_double;
pub mod pivoted_qr;
