//! Readers take paths: an input becomes a file whose extension its first byte chooses.

use std::path::Path;

/// Calls `read` with a file that holds all but the first byte of `data`.
pub fn with_file(data: &[u8], extensions: &[&str], read: impl Fn(&Path)) {
    let Some((first, rest)) = data.split_first() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(format!("input.{}", extensions[usize::from(*first) % extensions.len()]));
    std::fs::write(&path, rest).expect("writable");
    read(&path);
}
