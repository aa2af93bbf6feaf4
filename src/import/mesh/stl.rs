//! STL, text or binary → vertices and triangles; the only door to stl_io.

use std::io::Cursor;

use super::raw::{Raw, Refusal};
use crate::import::cells::shortened;

/// Bytes of the header of a binary file and of its count, and of each triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

const REMEDY: &str = "export the mesh again as STL";

/// Reads an STL file. Every triangle brings its own three vertices: they are put together later.
pub(super) fn read(bytes: &[u8]) -> Result<Raw, Refusal> {
    let mut raw = Raw::default();
    // Some programs begin binary files with “solid” too: there the length decides.
    let text = bytes.starts_with(b"solid") && exact_length(bytes).is_none_or(|needed| needed != bytes.len());
    let mut unsolid;
    let bytes = if text {
        possible_text(bytes)?;
        &with_name(bytes)
    } else {
        let needed = exact_length(bytes).ok_or_else(|| Refusal::new(format!("{} bytes are no STL file", bytes.len()), REMEDY))?;
        if bytes.len() < needed {
            let problem = format!("the header promises {needed} bytes, the file has {}", bytes.len());
            return Err(Refusal::new(problem, "the file was cut off or its header is wrong: copy or export it again"));
        }
        if needed < bytes.len() {
            raw.notes.push(format!("{} bytes after the last triangle were not read", bytes.len() - needed));
        }
        unsolid = bytes[..needed].to_vec();
        unsolid[..5].fill(b' ');
        &unsolid
    };
    let mut cursor = Cursor::new(bytes);
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(refused)?;
    for triangle in triangles {
        let triangle = triangle.map_err(refused)?;
        let first = raw.vertices.len() as u32;
        raw.vertices.extend(triangle.vertices.iter().map(|v| v.0.map(f64::from)));
        raw.polygon(first..first + 3);
    }
    Ok(raw)
}

/// Length of a binary file with the count that this one states; `None` if it is too short to have one.
fn exact_length(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    let count = u32::from_le_bytes(count.try_into().ok()?) as usize;
    Some(HEADER + TRIANGLE * count)
}

/// Text is UTF-8 for the reader; names in old encodings and a bare “solid” are put right.
fn with_name(bytes: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(bytes);
    let rest = text.split_once('\n').map_or("", |(_, rest)| rest);
    format!("solid named\n{rest}").into_bytes()
}

fn possible_text(bytes: &[u8]) -> Result<(), Refusal> {
    if bytes.contains(&0) {
        return Err(Refusal::new("this begins like a text STL and goes on in binary, and its length is that of neither", REMEDY));
    }
    Ok(())
}

fn refused(error: std::io::Error) -> Refusal {
    let text = shortened(&error.to_string());
    Refusal::new(format!("this is no STL file that can be read ({text})"), REMEDY)
}
