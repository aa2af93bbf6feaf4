//! Provenance: which bytes were read.

use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;

use crate::error::{Error, Place};
use crate::experiment::Source;

/// Larger files are no photograph of a drape; it bounds the memory that an input can ask for. Bytes.
const LARGEST: u64 = 1 << 30;
/// Larger files are no table: two million points in text are a tenth of it. The same bound holds for what a compressed file unfolds to. Bytes.
pub(super) const LARGEST_TABLE: u64 = 1 << 27;

/// Reads a whole file.
pub(super) fn read(path: &Path) -> Result<(Vec<u8>, Source), Error> {
    read_up_to(path, LARGEST)
}

/// Reads the file of a table; the contents of a `.gz`, with the digest of the file as it lies there.
pub(super) fn read_table(path: &Path) -> Result<(Vec<u8>, Source), Error> {
    let (bytes, source) = read_up_to(path, LARGEST_TABLE)?;
    if !bytes.starts_with(b"\x1f\x8b") {
        return Ok((bytes, source));
    }
    let mut unfolded = Vec::new();
    let refuse = |problem: String, remedy: &str| Error::input(Place::file(path), problem, remedy);
    MultiGzDecoder::new(&bytes[..])
        .take(LARGEST_TABLE + 1)
        .read_to_end(&mut unfolded)
        .map_err(|e| refuse(format!("the compressed file cannot be unfolded ({e})"), "compress it again, or leave it as it was"))?;
    if LARGEST_TABLE < unfolded.len() as u64 {
        return Err(refuse(too_large("unfolds to more than"), "split it; a table of a million points is smaller"));
    }
    Ok((unfolded, source))
}

pub(super) fn too_large(verb: &str) -> String {
    format!("the file {verb} {} MiB, the largest table that is read", LARGEST_TABLE >> 20)
}

fn read_up_to(path: &Path, largest: u64) -> Result<(Vec<u8>, Source), Error> {
    let status = std::fs::metadata(path).map_err(|e| Error::file(path, e))?;
    if status.is_dir() {
        return Err(Error::input(Place::file(path), "this is a folder", "name a file"));
    }
    let refuse = |size: u64| Error::input(Place::file(path), format!("{size} bytes"), format!("files of at most {largest} bytes are read"));
    if largest < status.len() {
        return Err(refuse(status.len()));
    }
    let file = std::fs::File::open(path).map_err(|e| Error::file(path, e))?;
    let mut bytes = Vec::with_capacity(status.len() as usize);
    // A pipe or device says that it has no bytes and may have any number of them.
    file.take(largest + 1).read_to_end(&mut bytes).map_err(|e| Error::file(path, e))?;
    if largest < bytes.len() as u64 {
        return Err(refuse(bytes.len() as u64));
    }
    let source = Source { file: path.to_path_buf(), bytes: bytes.len() as u64, digest: format!("{:016x}", fnv_1a(&bytes)) };
    Ok((bytes, source))
}

/// The digest of a file, as [`Source::digest`] has it.
pub(super) fn digest_of(path: &Path) -> Result<String, Error> {
    read(path).map(|(_, source)| source.digest)
}

/// Fowler, Noll & Vo, variant 1a, 64 bit (IETF draft-eastlake-fnv): it finds accidental changes, not forgeries.
pub(super) fn fnv_1a(bytes: &[u8]) -> u64 {
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
