//! Where numbers come from: files read, and what was set aside on the way.

use std::fmt;
use std::path::PathBuf;

use serde::Serialize;

/// One thing that was set aside, and why; nothing is dropped silently.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quarantined {
    /// The run it belonged to, where that is known.
    pub run: Option<String>,
    pub file: PathBuf,
    /// Of a workbook.
    pub sheet: Option<String>,
    /// 1 = the first line of the file, or the first row of the sheet.
    pub row: Option<usize>,
    /// The offending value as it stands in the file.
    pub value: String,
    pub problem: String,
    pub remedy: String,
}

/// Header of the quarantine table, in the order of [`Quarantined::cells`].
pub const QUARANTINE_COLUMNS: [&str; 7] = ["run", "file", "sheet", "row", "value", "problem", "remedy"];

impl Quarantined {
    /// The cells of one row of the quarantine table; an empty cell where nothing is known.
    pub fn cells(&self) -> [String; 7] {
        [
            self.run.clone().unwrap_or_default(),
            self.file.display().to_string(),
            self.sheet.clone().unwrap_or_default(),
            self.row.map(|row| row.to_string()).unwrap_or_default(),
            self.value.clone(),
            self.problem.clone(),
            self.remedy.clone(),
        ]
    }
}

impl fmt::Display for Quarantined {
    /// One sentence: run, file, sheet, row, value, problem; remedy.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(run) = &self.run {
            write!(f, "run {run}: ")?;
        }
        write!(f, "{}", self.file.display())?;
        if let Some(sheet) = &self.sheet {
            write!(f, ", sheet “{sheet}”")?;
        }
        if let Some(row) = self.row {
            write!(f, ", row {row}")?;
        }
        if !self.value.is_empty() {
            write!(f, ", “{}”", self.value)?;
        }
        write!(f, ": {}; {}", self.problem, self.remedy)
    }
}

/// A file that was read, and the digest of its bytes (FNV-1a, 64 bit, hex).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Source {
    pub file: PathBuf,
    pub bytes: u64,
    pub digest: String,
}
