//! Sources: files, folders and patterns that a person names → the files that are meant, each once, in a fixed order.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::image::is_picture;
use super::mesh::is_mesh;
use super::table::is_table;
use crate::error::{Error, Place};

/// More files than this are no campaign; a slip such as `/` should not read a disk.
const MOST_FILES: usize = 100_000;
/// Folders below a folder are followed this deep.
const DEEPEST: usize = 16;

/// What was named, file by file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Sources {
    pub files: Vec<PathBuf>,
    /// Files of folders that are neither table, picture nor mesh.
    pub others: Vec<PathBuf>,
}

/// Expands files, folders (with the folders in them) and patterns with `*`, `?`, `[…]`, `**`.
///
/// # Errors
/// [`Error::Input`] if a name means nothing, or too much; [`Error::File`] if a folder cannot be read.
pub(super) fn expand(named: &[PathBuf]) -> Result<Sources, Error> {
    let (mut found, mut seen) = (Sources::default(), BTreeSet::new());
    for name in named {
        let before = found.files.len();
        let pattern = name.to_string_lossy();
        if name.is_dir() {
            walk(name, 0, &mut found, &mut seen)?;
        } else if name.is_file() || !pattern.contains(['*', '?', '[']) {
            std::fs::metadata(name).map_err(|e| Error::file(name, e))?;
            add(name, &mut found.files, &mut seen)?;
        } else {
            let refuse =
                |e: glob::PatternError| Error::input(Place::file(name), format!("this is no pattern: {}", e.msg), "use *, ? and […]");
            // Sorted by the crate; what cannot be read is no file of ours.
            for path in glob::glob(&pattern).map_err(refuse)?.flatten().filter(|path| path.is_file()) {
                add(&path, &mut found.files, &mut seen)?;
            }
        }
        if found.files.len() == before && !seen.contains(name) {
            let problem = "no table, picture or mesh is there";
            let remedy = "name files (CSV, TSV, XLSX, XLS, ODS, Parquet, Arrow, also .gz; PNG, JPEG …; OBJ, PLY, STL, glTF), folders, or patterns such as \"*.csv\"";
            return Err(Error::input(Place::file(name), problem, remedy));
        }
    }
    Ok(found)
}

fn add(path: &Path, to: &mut Vec<PathBuf>, seen: &mut BTreeSet<PathBuf>) -> Result<(), Error> {
    if MOST_FILES <= seen.len() {
        return Err(Error::input(Place::file(path), format!("more than {MOST_FILES} files"), "name the folder of the campaign"));
    }
    if seen.insert(path.to_path_buf()) {
        to.push(path.to_path_buf());
    }
    Ok(())
}

fn walk(folder: &Path, depth: usize, found: &mut Sources, seen: &mut BTreeSet<PathBuf>) -> Result<(), Error> {
    let entries = std::fs::read_dir(folder).map_err(|e| Error::file(folder, e))?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        // Hidden files, and the lock files of spreadsheet programs.
        if name.starts_with('.') || name.starts_with("~$") {
            continue;
        }
        if path.is_dir() {
            // A link to a folder may lead in a circle.
            if depth < DEEPEST && !path.is_symlink() {
                walk(&path, depth + 1, found, seen)?;
            }
        } else if is_table(&path) || is_picture(&path) || is_mesh(&path) {
            add(&path, &mut found.files, seen)?;
        } else {
            add(&path, &mut found.others, seen)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_folders_and_patterns_mean_their_files_once_and_in_order() {
        let folder = tempfile::TempDir::new().expect("a folder");
        for name in ["b.csv", "a.csv", "deep/c.xlsx", "notes.pdf", ".hidden.csv", "~$deep.xlsx", "x.png"] {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
            std::fs::write(path, "").expect("writable");
        }
        let names = |found: &[PathBuf]| -> Vec<String> {
            let inside = |path: &PathBuf| path.strip_prefix(folder.path()).expect("inside").to_string_lossy().replace('\\', "/");
            found.iter().map(inside).collect()
        };
        let all = expand(&[folder.path().join("a.csv"), folder.path().to_path_buf()]).expect("there");
        assert_eq!(names(&all.files), ["a.csv", "b.csv", "deep/c.xlsx", "x.png"]);
        assert_eq!(names(&all.others), ["notes.pdf"]);
        let some = expand(&[folder.path().join("**/*.csv")]).expect("there");
        assert_eq!(names(&some.files), [".hidden.csv", "a.csv", "b.csv"]);
        for nothing in ["*.ods", "gone.csv"] {
            assert!(expand(&[folder.path().join(nothing)]).is_err());
        }
    }
}
