//! Quarantine: how a refused file is set aside instead of stopping everything.

use std::path::PathBuf;

use crate::error::Error;
use crate::experiment::Quarantined;

/// What a refused file left behind.
pub(super) fn refused(run: Option<String>, file: PathBuf, error: Error) -> Quarantined {
    match error {
        Error::Input { place, problem, remedy } => {
            let problem = match &place.column {
                Some(column) => format!("column “{column}”: {problem}"),
                None => problem,
            };
            Quarantined {
                run,
                file: place.file,
                sheet: place.sheet.map(String::from),
                row: place.row,
                value: String::new(),
                problem,
                remedy,
            }
        }
        Error::File { path, source } if source.kind() == std::io::ErrorKind::NotFound => Quarantined {
            run,
            value: path.display().to_string(),
            file: path,
            sheet: None,
            row: None,
            problem: "there is no such file".into(),
            remedy: "add the file, or correct its name".into(),
        },
        other => Quarantined {
            run,
            file,
            sheet: None,
            row: None,
            value: String::new(),
            problem: other.to_string(),
            remedy: "measure it again, or leave it out of the design table".into(),
        },
    }
}
