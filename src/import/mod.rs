//! Files → experiment; every input fault is found and located here.

pub mod campaign;
mod campaign_file;
mod check_table;
mod delimited;
mod design;
mod edge;
pub mod image;
pub mod mesh;
mod number;
pub mod numbers;
mod quarantine;
mod source;
pub mod table;
mod wishes;

pub use campaign::{Imported, load};
