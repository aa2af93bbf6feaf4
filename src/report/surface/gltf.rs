//! A surface as glTF 2.0: normals, colours, and the raw field as attribute `_FIELD`; metres, y upwards as the format has it.
//!
//! Source: Khronos glTF 2.0 specification (ISO/IEC 12113); attributes whose names begin with an underscore are the application's own.

use serde_json::{Value, json};

use super::Legend;
use crate::model::field::SurfaceFields;

/// Component type and target codes of the format.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// One file with everything in it.
pub fn glb(surface: &SurfaceFields, legend: &Legend) -> Vec<u8> {
    let (document, mut binary) = parts(surface, legend, None);
    let mut text = document.to_string().into_bytes();
    // Chunks are padded to four bytes: text by spaces, data by zeros.
    text.resize(text.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + text.len() + 8 + binary.len();
    let mut out = Vec::with_capacity(total);
    out.extend(b"glTF");
    out.extend(2u32.to_le_bytes());
    out.extend((total as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &binary)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    out
}

/// Text, its data embedded in it.
pub fn gltf(surface: &SurfaceFields, legend: &Legend) -> Vec<u8> {
    let (_, binary) = parts(surface, legend, None);
    let uri = format!("data:application/octet-stream;base64,{}", base64(&binary));
    let (document, _) = parts(surface, legend, Some(uri));
    let mut text = format!("{document:#}").into_bytes();
    text.push(b'\n');
    text
}

/// The document and the buffer it is about.
fn parts(surface: &SurfaceFields, legend: &Legend, uri: Option<String>) -> (Value, Vec<u8>) {
    let up = |[x, y, z]: [f64; 3]| [x as f32, z as f32, -y as f32];
    let positions: Vec<[f32; 3]> = surface.positions.iter().map(|p| up(*p)).collect();
    let normals: Vec<[f32; 3]> = surface.normals.iter().map(|n| up(*n)).collect();
    // Colours of vertices are linear by the format's rule.
    let colours: Vec<[f32; 3]> = legend.values.iter().map(|v| legend.colour(*v).linear.map(|x| x as f32)).collect();
    let field: Vec<[f32; 1]> = legend.values.iter().map(|v| [*v as f32]).collect();
    let triangles = surface.triangles();
    let count = positions.len();
    let mut binary = Vec::new();
    let mut views = Vec::new();
    let mut accessors = Vec::new();
    let mut attribute = |bytes: Vec<u8>, kind: &str, bounds: Option<(Value, Value)>| {
        views.push(json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len(), "target": ARRAY_BUFFER}));
        binary.extend(bytes);
        let mut accessor = json!({"bufferView": views.len() - 1, "componentType": FLOAT, "count": count, "type": kind});
        if let Some((low, high)) = bounds {
            accessor["min"] = low;
            accessor["max"] = high;
        }
        accessors.push(accessor);
    };
    attribute(floats(&positions), "VEC3", Some(bounds(&positions)));
    attribute(floats(&normals), "VEC3", None);
    attribute(floats(&colours), "VEC3", None);
    attribute(floats(&field), "SCALAR", Some(bounds(&field)));
    let indices: Vec<u8> = triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
    views.push(json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": indices.len(), "target": ELEMENT_ARRAY_BUFFER}));
    binary.extend(indices);
    accessors.push(json!({"bufferView": 4, "componentType": UNSIGNED_INT, "count": 3 * triangles.len(), "type": "SCALAR"}));
    let mut buffer = json!({"byteLength": binary.len()});
    if let Some(uri) = uri {
        buffer["uri"] = uri.into();
    }
    let (low, high) = legend.range;
    let field = legend.field;
    let extras = json!({
        "form": surface.form,
        "folds": surface.folds,
        "field": field.name(),
        "unit": field.unit(),
        "range": [low, high],
        "least": surface.least(field),
        "greatest": surface.greatest(field),
        "colour_map": legend.map(),
        "colours_srgb": legend.scale(11).into_iter().map(|(value, rgb)| json!({"value": value, "rgb": rgb})).collect::<Vec<_>>(),
    });
    let document = json!({
        "asset": {"version": "2.0", "generator": concat!("hemline ", env!("CARGO_PKG_VERSION"))},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "skirt", "mesh": 0}],
        "meshes": [{
            "name": "skirt",
            "primitives": [{
                "attributes": {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2, "_FIELD": 3},
                "indices": 4,
                "material": 0,
                "mode": 4,
            }],
            "extras": extras,
        }],
        "materials": [{
            "name": "cloth",
            "doubleSided": true,
            "pbrMetallicRoughness": {"baseColorFactor": [1.0, 1.0, 1.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9},
        }],
        "buffers": [buffer],
        "bufferViews": views,
        "accessors": accessors,
    });
    (document, binary)
}

fn floats<const N: usize>(rows: &[[f32; N]]) -> Vec<u8> {
    rows.iter().flatten().flat_map(|v| v.to_le_bytes()).collect()
}

/// Least and greatest of each component.
fn bounds<const N: usize>(rows: &[[f32; N]]) -> (Value, Value) {
    let fold = |best: fn(f32, f32) -> f32, start: f32| -> Value {
        let mut found = [start; N];
        rows.iter().for_each(|row| row.iter().zip(&mut found).for_each(|(v, f)| *f = best(*f, *v)));
        found.iter().map(|v| json!(v)).collect()
    };
    (fold(f32::min, f32::INFINITY), fold(f32::max, f32::NEG_INFINITY))
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word = chunk.iter().fold(0u32, |word, b| (word << 8) | u32::from(*b)) << (8 * (3 - chunk.len()));
        for i in 0..4 {
            let sextet = (word >> (18 - 6 * i)) & 63;
            out.push(if i <= chunk.len() { char::from(LETTERS[sextet as usize]) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    #[test]
    fn base64_has_the_vectors_of_its_standard() {
        // RFC 4648, section 10.
        for (plain, coded) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")] {
            assert_eq!(super::base64(plain.as_bytes()), coded);
        }
    }
}
