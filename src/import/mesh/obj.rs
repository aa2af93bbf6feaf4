//! Wavefront OBJ → vertices and polygons; the only door to tobj.

use tobj::{LoadError, LoadOptions};

use super::raw::{Raw, Refusal};

/// Reads an OBJ file. Objects and groups are put together; materials, normals and textures are not read, and no other file is opened.
pub(super) fn read(bytes: &[u8]) -> Result<Raw, Refusal> {
    // Names and comments may be in any old encoding; numbers are not.
    let text = String::from_utf8_lossy(bytes);
    let options = LoadOptions { single_index: false, triangulate: false, ignore_points: true, ignore_lines: true };
    let no_other_file = |_: &std::path::Path| Err(LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_other_file).map_err(|error| refused(&text, error))?;
    let mut raw = Raw::default();
    for model in models {
        let mesh = model.mesh;
        let first = raw.vertices.len() as u32;
        raw.vertices.extend(mesh.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        let mut corners = mesh.indices.iter().map(|i| first.saturating_add(*i));
        if mesh.face_arities.is_empty() {
            mesh.indices.chunks_exact(3).for_each(|_| raw.polygon(corners.by_ref().take(3)));
        }
        mesh.face_arities.iter().for_each(|&n| raw.polygon(corners.by_ref().take(n as usize)));
    }
    Ok(raw)
}

fn refused(text: &str, error: LoadError) -> Refusal {
    let remedy = "export the mesh again as OBJ, with faces";
    match error {
        // tobj does not say where: the first row of the kind that does not parse is looked for.
        LoadError::PositionParseError => at_row(text, "v", "a vertex has coordinates that are no numbers", remedy),
        LoadError::FaceParseError => at_row(text, "f", "a face has corners that are no numbers", remedy),
        LoadError::FaceVertexOutOfBounds => Refusal::new("a face names a vertex that is not there", remedy),
        LoadError::FaceNormalOutOfBounds | LoadError::FaceTexCoordOutOfBounds => {
            Refusal::new("a face names a normal or texture coordinate that is not there", remedy)
        }
        other => Refusal::new(format!("this is no OBJ file that can be read ({other})"), remedy),
    }
}

fn at_row(text: &str, key: &str, problem: &str, remedy: &str) -> Refusal {
    let faulty = |line: &str| {
        let mut words = line.split_whitespace();
        let number = |word: &str| if key == "v" { word.parse::<f64>().is_ok() } else { corner(word) };
        words.next() == Some(key) && {
            if key == "v" { words.clone().count() < 3 || !words.take(3).all(number) } else { !words.all(number) }
        }
    };
    Refusal { row: text.lines().position(faulty).map(|at| at + 1), ..Refusal::new(problem, remedy) }
}

/// Whether a word reads as `7`, `7/1`, `7//3` or `7/1/3`, numbers of either sign.
fn corner(word: &str) -> bool {
    word.split('/').enumerate().all(|(i, part)| 0 < i && part.is_empty() || part.parse::<i64>().is_ok())
}
