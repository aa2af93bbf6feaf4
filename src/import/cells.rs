//! Cells: what stands in a table before anybody asks what it means, each row with its place in the file.

use std::path::PathBuf;

use super::number::Numbers;
use crate::error::Place;
use crate::experiment::Quarantined;

/// More columns than this are no table of profiles; it bounds the memory that a broken file can ask for.
pub(super) const MOST_COLUMNS: usize = 10_000;
/// … and so do more cells than this: two million points with four columns each.
pub(super) const MOST_CELLS: usize = 8_000_000;

/// One cell: its text, trimmed; empty where the file has nothing.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Cell {
    pub text: String,
    /// Whether the file holds a number there, not characters: its text then is the shortest that reads back as the same number.
    pub native: bool,
}

impl Cell {
    pub(super) fn text(text: &str) -> Self {
        Cell { text: text.trim().to_owned(), native: false }
    }

    pub(super) fn number(value: f64) -> Self {
        Cell { text: format!("{value}"), native: true }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.text.is_empty()
    }
}

/// One row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
    /// 1 = the first line of the file, or the first row of the sheet.
    pub line: usize,
    pub cells: Vec<Cell>,
}

/// A table whose header was found.
#[derive(Debug, Clone)]
pub(super) struct Headed {
    pub file: PathBuf,
    /// Of a workbook.
    pub sheet: Option<String>,
    /// Of a text.
    pub encoding: Option<String>,
    pub separator: Option<char>,
    pub header_line: usize,
    /// Column names as the header has them, trimmed.
    pub header: Vec<String>,
    /// `units[c]`, from a row of units below the header.
    pub units: Vec<Option<String>>,
    /// What stands above the header, in order, without empty cells.
    pub titles: Vec<String>,
    /// None wider than the header; cells that are not there are empty.
    pub rows: Vec<Row>,
    /// Rows that do not fit the header.
    pub quarantine: Vec<Quarantined>,
    /// How the table was found, where that is not plain; one sentence each.
    pub notes: Vec<String>,
}

impl Headed {
    pub(super) fn cell(&self, row: usize, column: usize) -> &str {
        self.rows[row].cells.get(column).map_or("", |cell| cell.text.as_str())
    }

    pub(super) fn line(&self, row: usize) -> usize {
        self.rows[row].line
    }

    /// How the numbers of some columns are written.
    pub(super) fn numbers(&self, columns: &[usize]) -> Numbers {
        Numbers::of(self.texts(columns))
    }

    /// The cells of some columns that are characters, in file order.
    pub(super) fn texts(&self, columns: &[usize]) -> impl Iterator<Item = &str> {
        let written = self.rows.iter().flat_map(|row| columns.iter().filter_map(|&c| row.cells.get(c)));
        written.filter(|cell| !cell.native).map(|cell| cell.text.as_str())
    }

    /// The finite number in a cell, or why there is none, as the end of a sentence that starts with the cell.
    pub(super) fn number(&self, row: usize, column: usize, numbers: Numbers) -> Result<f64, String> {
        match self.rows[row].cells.get(column) {
            Some(cell) if cell.native => Numbers::Point.read(&cell.text),
            Some(cell) => numbers.read(&cell.text),
            None => numbers.read(""),
        }
    }

    pub(super) fn place(&self) -> Place {
        Place::file(&self.file).sheet(self.sheet.as_deref())
    }

    /// Something in row `line` that is set aside.
    pub(super) fn fault(&self, run: Option<&str>, line: Option<usize>, value: &str, problem: String, remedy: &str) -> Quarantined {
        Quarantined {
            run: run.map(String::from),
            file: self.file.clone(),
            sheet: self.sheet.clone(),
            row: line,
            value: shortened(value),
            problem,
            remedy: remedy.into(),
        }
    }
}

/// A value short enough for one sentence.
pub(super) fn shortened(value: &str) -> String {
    const LONGEST: usize = 60;
    // Far more than is shown, so that a cell of a megabyte is not split into words.
    let value: String = value.chars().take(8 * LONGEST).collect();
    let value = one_line(&value);
    if value.chars().count() <= LONGEST { value } else { value.chars().take(LONGEST).chain(['…']).collect() }
}

/// A message on one line.
pub(super) fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
