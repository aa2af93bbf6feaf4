//! A surface with a field as a mesh that other programs open: glTF, OBJ, PLY, STL, coloured by the field.

mod colour;
mod gltf;
mod obj;
mod ply;
mod stl;

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

pub use self::gltf::{glb, gltf};
pub use colour::{Colour, Legend};
pub use obj::obj;
pub use ply::ply;
pub use stl::stl;

use super::csv::Table;
use super::output;
use crate::error::Error;
use crate::model::field::{Extreme, Field, SurfaceFields};
use crate::units::{MILLIMETRE, Metre};

/// How a mesh is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    pub field: Field,
    /// Length of one unit of the file, m; `None`: a metre, a millimetre in STL. glTF is in metres by its own rule.
    pub unit: Option<Metre>,
    /// Values at the ends of the colours, in the field's unit; `None`: its least and greatest, alike about 0 where both signs mean something.
    pub range: Option<(f64, f64)>,
}

impl Options {
    /// This field, everything else as usual.
    pub fn of(field: Field) -> Self {
        Options { field, unit: None, range: None }
    }
}

/// Writes the surface to `path`, whose ending says the format: .glb, .gltf, .obj, .ply or .stl.
///
/// # Errors
/// [`Error::Unanswerable`] for another ending, or a field of which cloth data are missing; [`Error::File`] if it cannot be written.
pub fn write(surface: &SurfaceFields, options: &Options, path: &Path) -> Result<PathBuf, Error> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let legend = Legend::of(surface, options.field, options.range)?;
    let per_unit = options.unit.map(|u| u.0);
    let bytes = match ending.as_str() {
        "glb" => glb(surface, &legend),
        "gltf" => gltf(surface, &legend),
        "obj" => obj(surface, &legend, per_unit.unwrap_or(1.0)).into_bytes(),
        "ply" => ply(surface, &legend, per_unit.unwrap_or(1.0)),
        "stl" => stl(surface, &legend, per_unit.unwrap_or(MILLIMETRE)),
        _ => return Err(Error::Unanswerable(format!("{}: a surface is written as .glb, .gltf, .obj, .ply or .stl", path.display()))),
    };
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    output::write(path.parent().unwrap_or(Path::new("")), &name, &bytes)
}

/// One line per field: its extremes and where they are, or why it has none.
pub fn extremes(surface: &SurfaceFields) -> Table {
    let columns = [
        "field",
        "unit",
        "least",
        "least_sigma_rad",
        "least_slant_mm",
        "least_x_mm",
        "least_y_mm",
        "least_z_mm",
        "greatest",
        "greatest_sigma_rad",
        "greatest_slant_mm",
        "greatest_x_mm",
        "greatest_y_mm",
        "greatest_z_mm",
        "missing",
    ];
    let mut table = Table::new(&columns);
    for field in Field::ALL {
        let place = |e: Option<Extreme>| {
            let mm = |pick: fn(&Extreme) -> f64| e.as_ref().map(|e| pick(e) / MILLIMETRE);
            [
                e.map(|e| e.value),
                e.map(|e| e.sigma),
                mm(|e| e.slant_distance),
                mm(|e| e.position[0]),
                mm(|e| e.position[1]),
                mm(|e| e.position[2]),
            ]
        };
        let mut row = vec![field.name().into(), field.unit().into()];
        row.extend(place(surface.least(field)).into_iter().chain(place(surface.greatest(field))).map(Into::into));
        row.push(surface.values(field).err().into());
        table.push(row);
    }
    table
}

/// The same as JSON, SI units.
pub fn extremes_json(surface: &SurfaceFields) -> Value {
    let field = |field: Field| {
        json!({
            "field": field.name(),
            "unit": field.unit(),
            "least": surface.least(field),
            "greatest": surface.greatest(field),
            "missing": surface.values(field).err(),
        })
    };
    json!({
        "form": surface.form,
        "folds": surface.folds,
        "rows": surface.rows,
        "columns": surface.columns,
        "fields": Field::ALL.into_iter().map(field).collect::<Vec<_>>(),
    })
}
