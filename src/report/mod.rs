//! Results → files; computes nothing.
