//! Where numbers come from: files read, and what was set aside on the way.

use std::path::PathBuf;

use serde::Serialize;

/// One thing that was set aside, and why; nothing is dropped silently.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quarantined {
    /// The run it belonged to, where that is known.
    pub run: Option<String>,
    pub file: PathBuf,
    /// 1 = the first line of the file.
    pub row: Option<usize>,
    /// The offending value as it stands in the file.
    pub value: String,
    pub problem: String,
    pub remedy: String,
}

/// A file that was read, and the digest of its bytes (FNV-1a, 64 bit, hex).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Source {
    pub file: PathBuf,
    pub bytes: u64,
    pub digest: String,
}
