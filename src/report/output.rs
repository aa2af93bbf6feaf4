//! How a result file gets onto the disk: written beside its place, then renamed, so that nobody ever reads half of one.

use std::fs;
use std::io::Write;
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
    let refused = |source| Error::file(&path, source);
    // A name of its own: two programs that write the same report do not write into each other's unfinished file.
    let mut beside = unfinished(parent).map_err(refused)?;
    beside.write_all(bytes).and_then(|()| beside.flush()).map_err(refused)?;
    beside.persist(&path).map_err(|failed| refused(failed.error))?;
    Ok(path)
}

/// An unfinished file in `folder`; it vanishes if it is not renamed.
fn unfinished(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".hemline-").suffix(".part");
    #[cfg(unix)]
    {
        // As readable as any new file: a report is for others, the umask decides.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
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
