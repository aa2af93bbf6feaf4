//! A surface as binary PLY: normals, colours, and every field that exists as a property of its own.

use super::Legend;
use crate::model::field::{Field, SurfaceFields};

/// `per_unit` is the length of one unit of the file, m. z upwards. A field's property is its name with underscores, in SI units.
pub fn ply(surface: &SurfaceFields, legend: &Legend, per_unit: f64) -> Vec<u8> {
    let fields: Vec<(Field, &[f64])> = Field::ALL.into_iter().filter_map(|f| Some((f, surface.values(f).ok()?))).collect();
    let triangles = surface.triangles();
    let (low, high) = legend.range;
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\ncomment hemline {}, {}; one unit is {per_unit} m, z upwards\n\
         comment colours: {} from {low} to {high} {}, {}\nelement vertex {}\n",
        env!("CARGO_PKG_VERSION"),
        surface.form,
        legend.field.name(),
        legend.field.unit(),
        legend.map(),
        surface.positions.len()
    );
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        out += &format!("property float {name}\n");
    }
    for name in ["red", "green", "blue"] {
        out += &format!("property uchar {name}\n");
    }
    for (field, _) in &fields {
        out += &format!("property float {}\n", field.name().replace('-', "_"));
    }
    out += &format!("element face {}\nproperty list uchar int vertex_indices\nend_header\n", triangles.len());
    let mut out = out.into_bytes();
    for (i, (p, n)) in surface.positions.iter().zip(&surface.normals).enumerate() {
        let numbers = p.iter().map(|v| v / per_unit).chain(n.iter().copied());
        numbers.for_each(|v| out.extend((v as f32).to_le_bytes()));
        out.extend(legend.colour(legend.values[i]).bytes());
        fields.iter().for_each(|(_, values)| out.extend((values[i] as f32).to_le_bytes()));
    }
    for triangle in triangles {
        out.push(3);
        triangle.iter().for_each(|&i| out.extend((i as i32).to_le_bytes()));
    }
    out
}
