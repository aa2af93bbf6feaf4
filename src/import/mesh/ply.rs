//! Stanford PLY, text or binary of either byte order → vertices and polygons; the only door to ply-rs-bw.

use std::io::Cursor;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType};

use super::raw::{Raw, Refusal};
use crate::import::cells::shortened;

const REMEDY: &str = "export the mesh again as PLY, with vertices x, y, z and faces";

/// Reads a PLY file. Elements other than `vertex` and `face`, and properties other than places and corners, are passed over.
pub(super) fn read(bytes: &[u8]) -> Result<Raw, Refusal> {
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = Parser::<Vertex>::new().read_header(&mut reader).map_err(|e| refused(&e))?;
    possible(&header.elements.values().collect::<Vec<_>>(), header.encoding, bytes.len() - reader.get_ref().position() as usize)?;
    if header.elements.contains_key("tristrips") {
        return Err(Refusal::new("the faces are written as strips of triangles, which are not read", "export plain faces"));
    }
    let mut raw = Raw::default();
    for (name, element) in &header.elements {
        match name.as_str() {
            "vertex" => {
                if let Some(axis) = ["x", "y", "z"].iter().find(|&&axis| !element.properties.contains_key(axis)) {
                    return Err(Refusal::new(format!("the vertices have no property “{axis}”"), REMEDY));
                }
                let vertices = Parser::<Vertex>::new().read_payload_for_element(&mut reader, element, &header).map_err(|e| refused(&e))?;
                raw.vertices = vertices.into_iter().map(|v| v.0).collect();
            }
            "face" => {
                let faces = Parser::<Face>::new().read_payload_for_element(&mut reader, element, &header).map_err(|e| refused(&e))?;
                for face in faces {
                    // A number that cannot be a vertex becomes one that is not there, which is said later.
                    raw.polygon(face.0.into_iter().map(|i| u32::try_from(i).unwrap_or(u32::MAX)));
                }
            }
            _ => {
                Parser::<Other>::new().read_payload_for_element(&mut reader, element, &header).map_err(|e| refused(&e))?;
            }
        }
    }
    Ok(raw)
}

/// A header may promise more than the file holds: every entry takes some bytes.
fn possible(elements: &[&ElementDef], encoding: Encoding, bytes: usize) -> Result<(), Refusal> {
    let mut needed = 0_usize;
    for element in elements {
        let least: usize = match encoding {
            // A row of text: a digit and a separator for each.
            Encoding::Ascii => 2 * element.properties.len(),
            _ => element.properties.values().map(|p| least_bytes(&p.data_type)).sum(),
        };
        if least == 0 && 0 < element.count {
            return Err(Refusal::new(format!("the element “{}” has entries but no properties", shortened(&element.name)), REMEDY));
        }
        // The last row of a text may lack its line break.
        needed = needed.saturating_add(element.count.saturating_mul(least).saturating_sub(1));
    }
    if bytes < needed {
        let problem = format!("the header promises at least {needed} bytes of data, the file has {bytes}");
        return Err(Refusal::new(problem, "the file was cut off or its header is wrong: copy or export it again"));
    }
    Ok(())
}

fn least_bytes(kind: &PropertyType) -> usize {
    let (PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) = kind;
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// The parser's message quotes the whole offending line, which may be the whole file.
fn refused(error: &ParseError) -> Refusal {
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default();
    let first = first.split_once(": ").filter(|_| error.line().is_some()).map_or(first, |(_, rest)| rest);
    Refusal { row: error.line(), ..Refusal::new(format!("this is no PLY file that can be read ({})", shortened(first)), REMEDY) }
}

/// A place.
struct Vertex([f64; 3]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Vertex([f64::NAN; 3])
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return PropertyAccessResult::Ignored,
        };
        self.0[axis] = match value {
            Property::Char(v) => v.into(),
            Property::UChar(v) => v.into(),
            Property::Short(v) => v.into(),
            Property::UShort(v) => v.into(),
            Property::Int(v) => v.into(),
            Property::UInt(v) => v.into(),
            Property::Float(v) => v.into(),
            Property::Double(v) => v,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// Corners of a polygon.
struct Face(Vec<i64>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Face(Vec::new())
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if name != "vertex_indices" && name != "vertex_index" {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match value {
            Property::ListChar(v) => v.into_iter().map(i64::from).collect(),
            Property::ListUChar(v) => v.into_iter().map(i64::from).collect(),
            Property::ListShort(v) => v.into_iter().map(i64::from).collect(),
            Property::ListUShort(v) => v.into_iter().map(i64::from).collect(),
            Property::ListInt(v) => v.into_iter().map(i64::from).collect(),
            Property::ListUInt(v) => v.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// What is of no interest; only its length matters.
struct Other;

impl PropertyAccess for Other {
    fn new() -> Self {
        Other
    }
}
