//! Provenance: which bytes were read.

use std::path::Path;

use crate::error::{Error, Place};
use crate::experiment::Source;

/// Larger files are no profile, table or photograph of one; it bounds the memory that an input can ask for. Bytes.
const LARGEST: u64 = 1 << 30;

/// Reads a whole file.
pub(super) fn read(path: &Path) -> Result<(Vec<u8>, Source), Error> {
    let size = std::fs::metadata(path).map_err(|e| Error::file(path, e))?;
    if size.is_dir() {
        return Err(Error::input(Place::file(path), "this is a folder", "name a file"));
    }
    if LARGEST < size.len() {
        return Err(Error::input(Place::file(path), format!("{} bytes", size.len()), format!("files of at most {LARGEST} bytes are read")));
    }
    let bytes = std::fs::read(path).map_err(|e| Error::file(path, e))?;
    let source = Source { file: path.to_path_buf(), bytes: bytes.len() as u64, digest: format!("{:016x}", fnv_1a(&bytes)) };
    Ok((bytes, source))
}

/// Fowler, Noll & Vo, variant 1a, 64 bit (IETF draft-eastlake-fnv): it finds accidental changes, not forgeries.
fn fnv_1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    #[test]
    fn digests_agree_with_the_published_test_vectors() {
        // draft-eastlake-fnv, test vectors for FNV-1a, 64 bit.
        for (text, digest) in [("", 0xcbf29ce484222325_u64), ("a", 0xaf63dc4c8601ec8c), ("foobar", 0x85944171f73967e8)] {
            assert_eq!(super::fnv_1a(text.as_bytes()), digest);
        }
    }
}
