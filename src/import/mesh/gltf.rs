//! glTF 2.0, text or binary → vertices in metres, y up, and triangles; the only door to gltf.

use base64::Engine;
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf};

use super::raw::{Raw, Refusal};
use crate::import::cells::shortened;

const REMEDY: &str = "export the mesh again as one .glb file, plain triangles";
/// Nodes of a scene that are followed; the standard wants a tree, a file may hold anything.
const MOST_NODES: usize = 100_000;
/// One mesh may be placed by many nodes, so a small file could ask for any number of vertices and corners: at most this many beyond one a byte.
const MOST_REPEATED: usize = 1_000_000;

/// A transformation as glTF has it: columns of a 4 × 4 matrix.
type Matrix = [[f64; 4]; 4];

const IDENTITY: Matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// Reads a glTF file: the meshes of its scene, each where its node puts it. Only data inside the file are read; no other file is opened.
pub(super) fn read(bytes: &[u8]) -> Result<Raw, Refusal> {
    // The crate subtracts the header from the stated length unasked.
    let binary = bytes.starts_with(b"glTF");
    if binary && bytes.get(8..12).is_none_or(|length| u32::from_le_bytes([length[0], length[1], length[2], length[3]]) < 20) {
        return Err(Refusal::new("this GLB file is too short to hold anything", REMEDY));
    }
    let refuse = |e: gltf::Error| Refusal::new(format!("this is no glTF file that can be read ({})", shortened(&e.to_string())), REMEDY);
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(refuse)?;
    // The crate's own validation takes for granted that positions are there.
    let root = document.into_json();
    let there = |index: &gltf::json::Index<gltf::json::Accessor>| index.value() < root.accessors.len();
    if !root.meshes.iter().flat_map(|mesh| &mesh.primitives).flat_map(|primitive| primitive.attributes.values()).all(there) {
        return Err(Refusal::new("a mesh names data that are not there", REMEDY));
    }
    let document = Document::from_json(root).map_err(refuse)?;
    if let Some(required) = document.extensions_required().next() {
        return Err(Refusal::new(format!("the file requires the extension “{required}”"), "export without compression or quantization"));
    }
    let buffers = buffers(&document, blob)?;
    // The standard: metres, y upwards.
    let mut raw = Raw::default();
    (raw.up, raw.metres) = (Some([0.0, 1.0, 0.0]), Some(1.0));
    let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) else {
        return Err(Refusal::new("the file has no scene", REMEDY));
    };
    let mut seen = vec![false; document.nodes().len()];
    let mut open: Vec<(gltf::Node, Matrix)> = scene.nodes().map(|node| (node, IDENTITY)).collect();
    let mut skinned = false;
    let mut room = MOST_REPEATED.saturating_add(bytes.len());
    while let Some((node, above)) = open.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            return Err(Refusal::new(format!("node {} stands in the tree of nodes twice", node.index()), REMEDY));
        }
        let here = product(&above, &node.transform().matrix().map(|column| column.map(f64::from)));
        skinned |= node.skin().is_some();
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                let positions = primitive.get(&gltf::Semantic::Positions);
                let positions = positions.ok_or_else(|| Refusal::new("a mesh has no positions", REMEDY))?;
                place(&mut raw, &buffers, &positions, primitive.indices().as_ref(), primitive.mode(), &here, &mut room)?;
            }
        }
        open.extend(node.children().map(|child| (child, here)));
        if MOST_NODES < open.len() {
            return Err(Refusal::new(format!("more than {MOST_NODES} nodes"), REMEDY));
        }
    }
    if skinned {
        raw.notes.push("a skeleton was not applied: the mesh is taken in its rest position".into());
    }
    Ok(raw)
}

/// The bytes of every buffer.
fn buffers(document: &Document, mut blob: Option<Vec<u8>>) -> Result<Vec<Vec<u8>>, Refusal> {
    let mut all = Vec::new();
    for buffer in document.buffers() {
        let data = match buffer.source() {
            gltf::buffer::Source::Bin => blob.take().ok_or_else(|| Refusal::new("the binary part of the file is missing", REMEDY))?,
            gltf::buffer::Source::Uri(uri) => {
                let Some((_, encoded)) = uri.strip_prefix("data:").and_then(|rest| rest.split_once(";base64,")) else {
                    let name = shortened(uri);
                    let problem = format!("the data stand in another file, “{name}”, and a mesh may not open other files");
                    return Err(Refusal::new(problem, "export the mesh as one .glb file"));
                };
                base64::engine::general_purpose::STANDARD
                    .decode(encoded)
                    .map_err(|e| Refusal::new(format!("the data inside the file are not base64 ({e})"), REMEDY))?
            }
        };
        if data.len() < buffer.length() {
            return Err(Refusal::new(format!("a buffer of {} bytes has only {}", buffer.length(), data.len()), REMEDY));
        }
        all.push(data);
    }
    Ok(all)
}

/// Adds the triangles of one primitive, transformed.
fn place(
    raw: &mut Raw,
    buffers: &[Vec<u8>],
    positions: &Accessor,
    indices: Option<&Accessor>,
    mode: Mode,
    transform: &Matrix,
    room: &mut usize,
) -> Result<(), Refusal> {
    if (positions.data_type(), positions.dimensions()) != (DataType::F32, Dimensions::Vec3) {
        return Err(Refusal::new("positions are not three 32-bit numbers each", "export without compression or quantization"));
    }
    let first = raw.vertices.len() as u32;
    *room = room.checked_sub(positions.count()).ok_or_else(|| Refusal::new("the same mesh is placed too often", REMEDY))?;
    for item in items(buffers, positions, 12)? {
        let [x, y, z] = [0, 4, 8].map(|at| f64::from(f32::from_le_bytes([item[at], item[at + 1], item[at + 2], item[at + 3]])));
        raw.vertices
            .push(std::array::from_fn(|row| transform[0][row] * x + transform[1][row] * y + transform[2][row] * z + transform[3][row]));
    }
    let corners: Vec<u32> = match indices {
        None => (0..positions.count() as u32).collect(),
        Some(accessor) => match (accessor.data_type(), accessor.dimensions()) {
            (DataType::U8, Dimensions::Scalar) => items(buffers, accessor, 1)?.map(|item| u32::from(item[0])).collect(),
            (DataType::U16, Dimensions::Scalar) => {
                items(buffers, accessor, 2)?.map(|item| u32::from(u16::from_le_bytes([item[0], item[1]]))).collect()
            }
            (DataType::U32, Dimensions::Scalar) => {
                items(buffers, accessor, 4)?.map(|item| u32::from_le_bytes([item[0], item[1], item[2], item[3]])).collect()
            }
            _ => return Err(Refusal::new("corners are no whole numbers", REMEDY)),
        },
    };
    *room = room.checked_sub(corners.len()).ok_or_else(|| Refusal::new("the same mesh is placed too often", REMEDY))?;
    let number = |i: u32| first.saturating_add(i);
    match mode {
        Mode::Triangles => corners.chunks_exact(3).for_each(|c| raw.polygon([number(c[0]), number(c[1]), number(c[2])])),
        Mode::TriangleStrip => corners.windows(3).for_each(|c| raw.polygon([number(c[0]), number(c[1]), number(c[2])])),
        Mode::TriangleFan => corners.windows(2).skip(1).for_each(|c| raw.polygon([number(corners[0]), number(c[0]), number(c[1])])),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => {
            raw.notes.push("points and lines among the meshes were left out".into());
        }
    }
    Ok(())
}

/// The items of an accessor, each of `size` bytes or more, after a check that they lie inside their buffer.
fn items<'a>(buffers: &'a [Vec<u8>], accessor: &Accessor, size: usize) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, Refusal> {
    if accessor.sparse().is_some() {
        return Err(Refusal::new("the data are sparse, which is not read", "export the mesh without morph targets or compression"));
    }
    let outside = || Refusal::new("data reach beyond the end of their buffer", REMEDY);
    let view = accessor.view().ok_or_else(|| Refusal::new("data without a place in a buffer", REMEDY))?;
    let end = view.offset().checked_add(view.length()).ok_or_else(outside)?;
    let data = buffers.get(view.buffer().index()).and_then(|buffer| buffer.get(view.offset()..end)).ok_or_else(outside)?;
    let stride = view.stride().unwrap_or(size);
    if stride < size {
        return Err(Refusal::new("data overlap", REMEDY));
    }
    let (from, count) = (accessor.offset(), accessor.count());
    let needed =
        count.checked_sub(1).and_then(|n| n.checked_mul(stride)).and_then(|n| n.checked_add(from)).and_then(|n| n.checked_add(size));
    if needed.is_none_or(|needed| data.len() < needed) {
        return Err(outside());
    }
    Ok((0..count).map(move |i| &data[from + i * stride..from + i * stride + size]))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|column| std::array::from_fn(|row| (0..4).map(|k| a[k][row] * b[column][k]).sum()))
}
