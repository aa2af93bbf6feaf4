//! A table of numbers for a regression: named columns, every cell with its place.

use std::path::{Path, PathBuf};

use super::cells::{Headed, shortened};
use super::dialect::Dialect;
use super::document;
use super::number::Numbers;
use crate::error::{Error, Place};
use crate::experiment::Quarantined;

/// One line of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// 1 = the first line of the file.
    pub row: usize,
    /// One per column, trimmed.
    pub cells: Vec<String>,
    /// Which of them the file holds as numbers; there is no doubt about their marks.
    native: Vec<bool>,
}

/// A table as it stands in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberTable {
    pub file: PathBuf,
    pub columns: Vec<String>,
    pub lines: Vec<Line>,
    /// Lines that have another number of cells than the header.
    pub set_aside: Vec<Quarantined>,
    header_row: usize,
    /// `numbers[c]`: how column `c` writes its numbers.
    numbers: Vec<Numbers>,
}

/// What a cell holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    Number(f64),
    Empty,
}

impl NumberTable {
    /// Reads a CSV, TSV, XLSX, XLS, ODS, Parquet or Arrow file with a header row; `#` lines and empty lines are passed over. Of a workbook the first
    /// sheet with two columns or more.
    ///
    /// Decimal points and decimal commas are told apart by all numbers of the table together; a column that could be read both ways is
    /// refused cell by cell.
    ///
    /// # Errors
    /// [`Error::File`] if the file cannot be read; [`Error::Input`] if it is no table, has no header, or names a column twice.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let mut document = document::read(path, &Dialect::default(), &|_| false)?;
        let wide = |table: &Result<Headed, Error>| table.as_ref().is_ok_and(|table| 1 < table.header.len());
        if let Some(first) = document.tables.iter().position(wide) {
            document.tables = vec![document.tables.swap_remove(first)];
        }
        let table = document.into_one(|_| true)?;
        let all: Vec<usize> = (0..table.header.len()).collect();
        let whole = table.numbers(&all);
        // A column of names with commas in it must not upset the numbers beside it.
        let numbers = all.iter().map(|&c| if whole == Numbers::Contradictory { table.numbers(&[c]) } else { whole }).collect();
        let cells = |row: usize| all.iter().map(|&c| table.cell(row, c).to_owned()).collect();
        let native = |row: usize| all.iter().map(|&c| table.rows[row].cells.get(c).is_some_and(|cell| cell.native)).collect();
        let lines = (0..table.rows.len()).map(|row| Line { row: table.line(row), cells: cells(row), native: native(row) }).collect();
        Ok(NumberTable {
            file: path.to_path_buf(),
            lines,
            header_row: table.header_line,
            numbers,
            columns: table.header,
            set_aside: table.quarantine,
        })
    }

    /// Index of a column.
    ///
    /// # Errors
    /// [`Error::Input`] that lists the columns there are.
    pub fn column(&self, name: &str) -> Result<usize, Error> {
        self.columns.iter().position(|column| column == name).ok_or_else(|| {
            Error::input(
                Place::file(&self.file).row(self.header_row).column(name),
                "there is no such column",
                format!("the columns are {}", self.columns.join(", ")),
            )
        })
    }

    /// What stands in a cell; `+` and `-` alone are the coded levels +1 and −1.
    ///
    /// # Errors
    /// [`Error::Input`] at the cell if it is no finite number.
    pub fn value(&self, line: &Line, column: usize) -> Result<Value, Error> {
        let text = &line.cells[column];
        match text.as_str() {
            "" => return Ok(Value::Empty),
            "+" => return Ok(Value::Number(1.0)),
            "-" | "−" => return Ok(Value::Number(-1.0)),
            _ => (),
        }
        let numbers = if line.native[column] { Numbers::Point } else { self.numbers[column] };
        numbers.read(text).map(Value::Number).map_err(|problem| {
            let place = Place::file(&self.file).row(line.row).column(&self.columns[column]);
            let problem = format!("“{}” {problem}", shortened(text));
            Error::input(place, problem, "write a finite number; only a response that does not exist may be left empty")
        })
    }

    /// The text of a cell.
    pub fn text<'a>(&self, line: &'a Line, column: usize) -> Option<&'a str> {
        line.cells.get(column).map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> NumberTable {
        let folder = tempfile::TempDir::new().expect("a folder");
        let path = folder.path().join("t.csv");
        std::fs::write(&path, text).expect("writable");
        NumberTable::read(&path).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn dialects_give_the_same_numbers() {
        for text in ["a,y\n-1,2.5\n", "a;y\r\n−1;2,5\r\n", "# note\na\ty\n\n-\t2,5\n", "\"a\",\"y\"\n\"-1\",\"2.5\"\n", "a,y\n-,\"2,5\"\n"]
        {
            let table = table(text);
            let line = &table.lines[0];
            let values = (table.value(line, 0).unwrap(), table.value(line, 1).unwrap());
            assert_eq!(values, (Value::Number(-1.0), Value::Number(2.5)), "{text}");
        }
    }

    #[test]
    fn a_bad_cell_is_named_by_row_column_and_value() {
        let table = table("a,y\n1,2\n\n1,oops\n1,NaN\n");
        for (line, value, row) in [(1, "“oops”", "row 4"), (2, "“NaN”", "row 5")] {
            let message = table.value(&table.lines[line], 1).unwrap_err().to_string();
            assert!(["t.csv", row, "“y”", value, "finite number"].iter().all(|part| message.contains(part)), "{message}");
        }
    }

    #[test]
    fn a_line_with_a_cell_too_many_is_set_aside() {
        let table = table("a,y\n1,2,5\n1,2\n");
        assert_eq!((table.lines.len(), table.set_aside.len(), table.set_aside[0].row), (1, 1, Some(2)));
    }
}
