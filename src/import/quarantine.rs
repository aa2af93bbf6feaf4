//! Quarantine: what was set aside, where it stood, why, and what would be right.

use std::fmt;
use std::path::PathBuf;

use serde::Serialize;

use crate::error::Error;

/// One thing that was set aside, and why; nothing is dropped silently.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quarantined {
    /// The run (or profile) it belonged to, where that is known.
    pub run: Option<String>,
    pub file: PathBuf,
    /// 1 = the first line of the file.
    pub row: Option<usize>,
    /// The offending value as it stands in the file.
    pub value: String,
    pub problem: String,
    pub remedy: String,
}

/// Header of the quarantine table, in the order of [`Quarantined::cells`].
pub const COLUMNS: [&str; 6] = ["run", "file", "row", "value", "problem", "remedy"];

impl Quarantined {
    /// What a refused file left behind.
    pub(super) fn from_error(run: Option<String>, file: PathBuf, error: Error) -> Self {
        match error {
            Error::Input { place, problem, remedy } => {
                let problem = match &place.column {
                    Some(column) => format!("column “{column}”: {problem}"),
                    None => problem,
                };
                Quarantined { run, file: place.file, row: place.row, value: String::new(), problem, remedy }
            }
            Error::File { path, source } if source.kind() == std::io::ErrorKind::NotFound => Quarantined {
                run,
                value: path.display().to_string(),
                file: path,
                row: None,
                problem: "there is no such file".into(),
                remedy: "add the file, or correct its name".into(),
            },
            other => Quarantined {
                run,
                file,
                row: None,
                value: String::new(),
                problem: other.to_string(),
                remedy: "measure it again, or leave it out of the design table".into(),
            },
        }
    }

    /// The cells of one row of the quarantine table; an empty cell where nothing is known.
    pub fn cells(&self) -> [String; 6] {
        [
            self.run.clone().unwrap_or_default(),
            self.file.display().to_string(),
            self.row.map(|row| row.to_string()).unwrap_or_default(),
            self.value.clone(),
            self.problem.clone(),
            self.remedy.clone(),
        ]
    }
}

impl fmt::Display for Quarantined {
    /// One sentence: run, file, row, value, problem; remedy.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(run) = &self.run {
            write!(f, "run {run}: ")?;
        }
        write!(f, "{}", self.file.display())?;
        if let Some(row) = self.row {
            write!(f, ", row {row}")?;
        }
        if !self.value.is_empty() {
            write!(f, ", “{}”", self.value)?;
        }
        write!(f, ": {}; {}", self.problem, self.remedy)
    }
}
