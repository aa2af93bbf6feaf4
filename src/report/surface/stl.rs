//! A surface as binary STL, the colour of each triangle in its attribute (5 bits a channel, valid bit set: VisCAM, SolidView, MeshLab).

use super::Legend;
use crate::model::field::SurfaceFields;

/// `per_unit` is the length of one unit of the file, m. z upwards; a triangle has the colour of its mean value.
pub fn stl(surface: &SurfaceFields, legend: &Legend, per_unit: f64) -> Vec<u8> {
    let triangles = surface.triangles();
    let mut header = format!("hemline, {} by {}", surface.form, legend.field.name()).into_bytes();
    header.retain(u8::is_ascii);
    header.resize(80, b' ');
    let mut out = header;
    out.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| surface.positions[i as usize].map(|v| v / per_unit));
        let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let size = normal.iter().map(|x| x * x).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        let numbers = normal.iter().map(|x| x / size).chain(a).chain(b).chain(c);
        numbers.for_each(|x| out.extend((x as f32).to_le_bytes()));
        let mean = triangle.iter().map(|&i| legend.values[i as usize]).sum::<f64>() / 3.0;
        let [r, g, b] = legend.colour(mean).srgb().map(|x| (31.0 * x).round() as u16);
        out.extend((0x8000 | (r << 10) | (g << 5) | b).to_le_bytes());
    }
    out
}
