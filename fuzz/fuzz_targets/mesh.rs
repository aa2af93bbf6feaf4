#![no_main]
//! Meshes: hem, sections.

mod on_disk;

use hemline::import::mesh;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    on_disk::with_file(data, &["obj", "ply", "stl", "gltf", "glb"], |path| {
        let options = mesh::Options::default();
        let _ = mesh::hem(path, &options);
        if let Ok(mesh) = mesh::read(path, &options) {
            let cuts: Vec<mesh::Cut> = mesh.heights(4).into_iter().map(|height| mesh.cut(height)).collect();
            let _ = mesh.measured(&cuts);
        }
    });
});
