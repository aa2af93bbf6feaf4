//! How a result file gets onto the disk: written beside its place, then renamed, so that nobody ever reads half of one.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::Error;

/// Writes `bytes` to `folder/name` (making folders as needed) and returns the path. A file that was there is replaced in one step.
///
/// # Errors
/// [`Error::File`] if the operating system refuses; the file that was there is then untouched.
pub fn write(folder: &Path, name: &str, bytes: &[u8]) -> Result<PathBuf, Error> {
    let path = folder.join(name);
    let parent = path.parent().unwrap_or(folder);
    fs::create_dir_all(parent).map_err(|source| Error::file(parent, source))?;
    let mut beside = path.clone().into_os_string();
    beside.push(".part");
    let beside = PathBuf::from(beside);
    let written = fs::write(&beside, bytes).and_then(|()| fs::rename(&beside, &path));
    if let Err(source) = written {
        // What remains of a failed write is of no use; that it cannot be removed either changes nothing about the error.
        let _ = fs::remove_file(&beside);
        return Err(Error::file(path, source));
    }
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_file_replaces_the_old_one_and_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), "tables/a.csv", b"old").unwrap();
        let path = write(folder.path(), "tables/a.csv", b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn a_refused_write_names_the_path() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), b"").unwrap();
        let error = write(folder.path(), "file/inside.csv", b"x").unwrap_err();
        assert!(error.to_string().contains("file"), "{error}");
    }
}
