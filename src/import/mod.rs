//! Files → experiment; every input fault is found and located here.

mod archive;
pub mod campaign;
mod campaign_file;
pub mod batch;
mod cells;
mod check_table;
mod column;
mod columnar;
mod delimited;
mod design;
mod design_sheet;
pub mod dialect;
mod dialect_table;
mod document;
mod encoding;
mod expansion;
mod header;
pub mod image;
mod layout;
pub mod mesh;
mod number;
pub mod numbers;
mod points;
mod quarantine;
pub mod scene_file;
mod source;
mod sources;
mod store;
pub mod table;
pub mod tidy;
mod wishes;
mod workbook;

pub use campaign::{Imported, load, load_some};
