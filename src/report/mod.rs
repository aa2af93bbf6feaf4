//! Results → files; computes nothing.

pub mod csv;
pub mod date;
pub mod figure;
pub mod note;
pub mod number;
pub mod output;
pub mod raster;
pub mod table;
pub mod typeset;

#[cfg(test)]
mod sample;
