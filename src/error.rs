//! What could not be done, where, with which value.

use std::fmt;
use std::path::PathBuf;

/// Where in the input something stands: a file, and if known its sheet, row (1 = the first line of the file or sheet) and column.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    pub file: PathBuf,
    /// Of a workbook.
    pub sheet: Option<Box<str>>,
    pub row: Option<usize>,
    pub column: Option<Box<str>>,
}

impl Place {
    pub fn file(file: impl Into<PathBuf>) -> Self {
        Place { file: file.into(), sheet: None, row: None, column: None }
    }

    /// On a sheet of a workbook; `None` where the file has no sheets.
    pub fn sheet(mut self, sheet: Option<&str>) -> Self {
        self.sheet = sheet.map(Box::from);
        self
    }

    pub fn row(mut self, row: usize) -> Self {
        self.row = Some(row);
        self
    }

    pub fn column(mut self, column: impl Into<String>) -> Self {
        self.column = Some(column.into().into_boxed_str());
        self
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(sheet) = &self.sheet {
            write!(f, ", sheet “{sheet}”")?;
        }
        if let Some(row) = self.row {
            write!(f, ", row {row}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ", column “{column}”")?;
        }
        Ok(())
    }
}

/// Why no result exists. How a computation that did start ended is data, not an error.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused to read or write.
    #[error("{}: {source}", path.display())]
    File {
        path: PathBuf,
        #[source]
        source: std::io::Error,
    },
    /// Something in an input file is not what it should be; `remedy` says what would be right.
    #[error("{place}: {problem}; {remedy}")]
    Input { place: Place, problem: String, remedy: String },
    /// A quantity lies outside the range in which the question makes sense.
    #[error("{quantity} is {value}; allowed is {allowed}")]
    Invalid { quantity: &'static str, value: f64, allowed: &'static str },
    /// The question cannot be answered from what was given (too few points, a singular design …).
    #[error("{0}")]
    Unanswerable(String),
    /// A document or picture could not be produced; a defect of this program or of the machine, never of the input.
    #[error("{what} could not be written: {why}")]
    Output { what: String, why: String },
}

impl Error {
    /// A fault at `place`, with what would be right.
    pub fn input(place: Place, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Error::Input { place, problem: problem.into(), remedy: remedy.into() }
    }

    /// An operating-system fault at `path`.
    pub fn file(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Error::File { path: path.into(), source }
    }
}
