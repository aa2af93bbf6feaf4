//! Files → experiment; every input fault is found and located here.

pub mod campaign;
mod campaign_file;
mod delimited;
mod design;
mod edge;
pub mod image;
mod number;
pub mod numbers;
mod quarantine;
mod source;
pub mod table;

pub use campaign::{Imported, load};
