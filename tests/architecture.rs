//! Who may use whom: a plain text scan over `src/`, against the table in ARCHITECTURE.md.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Layer → the layers it may name, and the outside crates that may enter there.
fn allowed() -> BTreeMap<&'static str, (Vec<&'static str>, Vec<&'static str>)> {
    let rows: [(&str, &[&str], &[&str]); 11] = [
        ("error", &[], &["thiserror"]),
        ("units", &[], &["serde"]),
        ("numerics", &["error"], &["nalgebra", "argmin", "argmin_math", "serde"]),
        ("experiment", &["error", "units"], &["serde"]),
        (
            "import",
            &["error", "units", "experiment"],
            &[
                "polars",
                "calamine",
                "flate2",
                "encoding_rs",
                "glob",
                "image",
                "serde",
                "tempfile",
                "toml",
                "tobj",
                "ply_rs_bw",
                "stl_io",
                "gltf",
                "base64",
            ],
        ),
        ("model", &["error", "units", "numerics", "experiment"], &["nalgebra", "serde"]),
        ("simulate", &["error", "units", "numerics", "experiment", "model"], &["nalgebra", "serde"]),
        ("fit", &["error", "units", "numerics", "experiment", "model"], &["nalgebra", "serde"]),
        ("statistics", &["error", "numerics"], &["nalgebra", "statrs", "serde", "rand", "rand_chacha"]),
        (
            "study",
            &["error", "units", "numerics", "experiment", "model", "simulate", "fit", "statistics"],
            &["nalgebra", "rayon", "serde", "rand", "rand_chacha"],
        ),
        (
            "report",
            &["error", "units", "experiment", "model", "simulate", "fit", "statistics", "study"],
            &[
                "plotters",
                "plotters_backend",
                "png",
                "typst",
                "typst_assets",
                "typst_layout",
                "typst_pdf",
                "usvg",
                "vello_cpu",
                "dejavu",
                "rayon",
                "serde",
                "serde_json",
                "tempfile",
                "toml",
                "polars",
                "rust_xlsxwriter",
            ],
        ),
    ];
    rows.into_iter().map(|(layer, layers, crates)| (layer, (layers.to_vec(), crates.to_vec()))).collect()
}

/// Crates that must enter by these doors only; most have one.
const DOORS: [(&str, &str); 25] = [
    ("argmin", "numerics/minimize.rs"),
    ("statrs", "statistics/"),
    ("clap", "cli/"),
    ("libc", "cli/memory.rs"),
    ("indicatif", "cli/"),
    ("polars", "import/"),
    ("polars", "report/columnar.rs"),
    ("tobj", "import/mesh/obj.rs"),
    ("ply_rs_bw", "import/mesh/ply.rs"),
    ("stl_io", "import/mesh/stl.rs"),
    ("gltf", "import/mesh/gltf.rs"),
    ("base64", "import/mesh/gltf.rs"),
    ("calamine", "import/workbook.rs"),
    ("encoding_rs", "import/encoding.rs"),
    ("flate2", "import/"),
    ("glob", "import/"),
    ("rust_xlsxwriter", "cli/workbook.rs"),
    ("rust_xlsxwriter", "report/spreadsheet.rs"),
    ("toml", "report/letterhead.rs"),
    ("toml", "import/"),
    ("plotters", "report/figure/"),
    ("plotters_backend", "report/figure/drawing.rs"),
    ("png", "report/raster/"),
    ("usvg", "report/raster/"),
    ("vello_cpu", "report/raster/"),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("src is there").map(|e| e.expect("readable").path()) {
        if entry.is_dir() {
            sources(&entry, found);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            found.push(entry);
        }
    }
    found.sort();
}

/// `(path below src, text without comments)` of every source file that ships: what only tests use enters nowhere.
fn files() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    sources(&root, &mut found);
    let code = |path: &Path| {
        let text = fs::read_to_string(path).expect("readable");
        let shipped = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        shipped.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
    };
    found.retain(|path| path.file_name().is_some_and(|name| name != "tests.rs"));
    found.iter().map(|path| (path.strip_prefix(&root).expect("below src").to_string_lossy().replace('\\', "/"), code(path))).collect()
}

fn layer(file: &str) -> &str {
    file.split(['/', '.']).next().expect("a first part")
}

/// The words that follow `marker` in `text`.
fn words_after<'a>(text: &'a str, marker: &'a str) -> impl Iterator<Item = &'a str> + 'a {
    text.match_indices(marker).map(move |(at, _)| {
        let rest = &text[at + marker.len()..];
        &rest[..rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len())]
    })
}

#[test]
fn every_layer_uses_only_the_layers_below_it() {
    let allowed = allowed();
    let layers: Vec<&str> = allowed.keys().copied().chain(["cli"]).collect();
    let mut faults = Vec::new();
    for (file, text) in files() {
        let own = layer(&file);
        let Some((may, _)) = allowed.get(own) else { continue };
        for used in words_after(&text, "crate::").filter(|word| layers.contains(word)) {
            if used != own && !may.contains(&used) {
                faults.push(format!("{file} uses {used}"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn outside_crates_enter_by_their_doors_only() {
    let manifest = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml")).expect("the manifest");
    let dependencies = manifest.split("[dependencies]").nth(1).and_then(|rest| rest.split("\n[").next()).expect("a dependency section");
    let crates: Vec<String> =
        dependencies.lines().filter_map(|line| line.split_once(" = ")).map(|(name, _)| name.trim().replace('-', "_")).collect();
    assert!(crates.len() > 10, "the manifest was not understood: {crates:?}");
    let allowed = allowed();
    let mut faults = Vec::new();
    for (file, text) in files() {
        for name in &crates {
            // A crate is named as `name::` or `use name;`, not as part of a longer path.
            let used = text
                .match_indices(&format!("{name}::"))
                .any(|(at, _)| !text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':'));
            if !used {
                continue;
            }
            if let Some((_, enter)) = allowed.get(layer(&file))
                && !enter.contains(&name.as_str())
            {
                faults.push(format!("{file} uses the crate {name}"));
            }
            let doors: Vec<&str> = DOORS.iter().filter(|(door, _)| door == name).map(|(_, file)| *file).collect();
            if !doors.is_empty() && !doors.iter().any(|door| file.starts_with(door)) {
                faults.push(format!("{file} uses {name}, whose door is {}", doors.join(" or ")));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn files_are_only_touched_where_files_are_the_subject() {
    let faults: Vec<String> = files()
        .into_iter()
        .filter(|(file, _)| !["import", "report", "cli", "main"].contains(&layer(file)))
        .filter(|(file, text)| {
            // The studies that give seconds have a clock, and that in one file.
            let clock = text.contains("std::time") && file != "study/clock.rs";
            clock || ["std::fs", "std::env", "std::process", "println!("].iter().any(|word| text.contains(word))
        })
        .map(|(file, _)| file)
        .collect();
    assert!(faults.is_empty(), "files, clock, environment or console in {}", faults.join(", "));
}

#[test]
fn every_file_says_its_question_in_the_first_line() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for (file, _) in files() {
        let text = fs::read_to_string(root.join(&file)).expect("readable");
        assert!(text.starts_with("//! "), "{file} does not begin with //!");
    }
}

#[test]
fn unit_factors_stand_in_one_place() {
    let faults: Vec<String> = files()
        .into_iter()
        .filter(|(file, _)| file != "units.rs")
        .flat_map(|(file, text)| {
            let found: Vec<String> = text
                .lines()
                .filter(|line| ["* 1e3", "* 1000.0", "/ 1e3", "/ 1000.0", "* 1e6", "/ 1e-3", "* 1e-3;"].iter().any(|w| line.contains(w)))
                .map(|line| format!("{file}: {}", line.trim()))
                .collect();
            found
        })
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
