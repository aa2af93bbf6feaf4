//! A surface as Wavefront OBJ, colours as the three numbers after a vertex (which Blender, MeshLab and Rhino read).

use super::Legend;
use crate::model::field::SurfaceFields;

/// `per_unit` is the length of one unit of the file, m. y upwards, as programs take an OBJ to be; the raw field stands in no OBJ.
pub fn obj(surface: &SurfaceFields, legend: &Legend, per_unit: f64) -> String {
    let (low, high) = legend.range;
    let mut out = format!(
        "# hemline {}, {}; one unit is {per_unit} m, y upwards\n# colours: {} from {low} to {high} {}, {}\no skirt\n",
        env!("CARGO_PKG_VERSION"),
        surface.form,
        legend.field.name(),
        legend.field.unit(),
        legend.map()
    );
    for (p, value) in surface.positions.iter().zip(&legend.values) {
        let [x, y, z] = p.map(|v| v / per_unit);
        let [r, g, b] = legend.colour(*value).srgb();
        out += &format!("v {x:.7} {z:.7} {:.7} {r:.4} {g:.4} {b:.4}\n", -y);
    }
    for [x, y, z] in &surface.normals {
        out += &format!("vn {x:.5} {z:.5} {:.5}\n", -y);
    }
    for triangle in surface.triangles() {
        let [a, b, c] = triangle.map(|i| i + 1);
        out += &format!("f {a}//{a} {b}//{b} {c}//{c}\n");
    }
    out
}
