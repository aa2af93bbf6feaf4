//! Mathematics with no textile word in it.
