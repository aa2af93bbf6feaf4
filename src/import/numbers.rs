//! A table of numbers for a regression: named columns, every cell with its place.

use std::path::{Path, PathBuf};

use crate::error::{Error, Place};

/// One line of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// 1 = the first line of the file.
    pub row: usize,
    /// One per column, trimmed.
    pub cells: Vec<String>,
}

/// A delimited table as it stands in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberTable {
    pub file: PathBuf,
    pub columns: Vec<String>,
    pub lines: Vec<Line>,
    decimal_comma: bool,
}

/// What a cell holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    Number(f64),
    Empty,
}

impl NumberTable {
    /// Reads a comma-, semicolon- or tab-separated file with a header line; `#` lines and empty lines are passed over.
    ///
    /// The separator is the one that the header has; where it is not the comma, a comma in a number is a decimal comma.
    ///
    /// # Errors
    /// [`Error::File`] if the file cannot be read; [`Error::Input`] if it is not UTF-8 text, has no header, or names a column twice.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bytes = std::fs::read(path).map_err(|source| Error::file(path, source))?;
        let text = String::from_utf8(bytes)
            .map_err(|_| Error::input(Place::file(path), "the file is not UTF-8 text", "save the table as CSV in UTF-8"))?;
        Self::parse(path, text.trim_start_matches('\u{feff}'))
    }

    fn parse(path: &Path, text: &str) -> Result<Self, Error> {
        let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line)).filter(|(_, line)| {
            let line = line.trim();
            !line.is_empty() && !line.starts_with('#')
        });
        let Some((row, header)) = lines.next() else {
            return Err(Error::input(Place::file(path), "the file has no header line", "give the columns names in the first line"));
        };
        let separator = [';', '\t'].into_iter().find(|&mark| header.contains(mark)).unwrap_or(',');
        let columns = split(header, separator);
        for (i, name) in columns.iter().enumerate() {
            if !name.is_empty() && columns[..i].contains(name) {
                return Err(Error::input(
                    Place::file(path).row(row).column(name),
                    "the column is named twice",
                    "give each column a name of its own",
                ));
            }
        }
        let lines = lines.map(|(row, line)| Line { row, cells: split(line, separator) }).collect();
        Ok(NumberTable { file: path.to_path_buf(), columns, lines, decimal_comma: separator != ',' })
    }

    /// Index of a column.
    ///
    /// # Errors
    /// [`Error::Input`] that lists the columns there are.
    pub fn column(&self, name: &str) -> Result<usize, Error> {
        self.columns.iter().position(|column| column == name).ok_or_else(|| {
            Error::input(
                Place::file(&self.file).row(1).column(name),
                "there is no such column",
                format!("the columns are {}", self.columns.join(", ")),
            )
        })
    }

    /// What stands in a cell; `+` and `-` alone are the coded levels +1 and −1.
    ///
    /// # Errors
    /// [`Error::Input`] at the cell if the line has another number of cells than the header, or the cell is no finite number.
    pub fn value(&self, line: &Line, column: usize) -> Result<Value, Error> {
        let place = Place::file(&self.file).row(line.row);
        if line.cells.len() != self.columns.len() {
            let problem = format!("the line has {} cells, the header {}", line.cells.len(), self.columns.len());
            return Err(Error::input(place, problem, "give every line one cell per column"));
        }
        let text = &line.cells[column];
        let plain = text.replace('\u{2212}', "-");
        let number = match plain.as_str() {
            "" => return Ok(Value::Empty),
            "+" => Ok(1.0),
            "-" => Ok(-1.0),
            number if self.decimal_comma => number.replacen(',', ".", 1).parse::<f64>(),
            number => number.parse::<f64>(),
        };
        match number {
            Ok(number) if number.is_finite() => Ok(Value::Number(number)),
            _ => Err(Error::input(
                place.column(&self.columns[column]),
                format!("“{text}” is not a finite number"),
                "write a number; only a response that does not exist may be left empty",
            )),
        }
    }

    /// The text of a cell.
    pub fn text<'a>(&self, line: &'a Line, column: usize) -> Option<&'a str> {
        line.cells.get(column).map(String::as_str)
    }
}

/// Cells of one line; a cell in double quotes may hold the separator, and "" stands for a quote.
fn split(line: &str, separator: char) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    let mut marks = line.chars().peekable();
    while let Some(mark) = marks.next() {
        let last = cells.len() - 1;
        match mark {
            '"' if quoted && marks.peek() == Some(&'"') => {
                marks.next();
                cells[last].push('"');
            }
            '"' => quoted = !quoted,
            mark if mark == separator && !quoted => cells.push(String::new()),
            mark => cells[last].push(mark),
        }
    }
    cells.into_iter().map(|cell| cell.trim().to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> NumberTable {
        NumberTable::parse(Path::new("t.csv"), text).unwrap()
    }

    #[test]
    fn dialects_give_the_same_numbers() {
        for text in ["a,y\n-1,2.5\n", "a;y\r\n−1;2,5\r\n", "# note\na\ty\n\n-\t2,5\n", "\"a\",\"y\"\n\"-1\",\"2.5\"\n"] {
            let table = table(text);
            let line = &table.lines[0];
            assert_eq!((table.value(line, 0).unwrap(), table.value(line, 1).unwrap()), (Value::Number(-1.0), Value::Number(2.5)), "{text}");
        }
    }

    #[test]
    fn a_bad_cell_is_named_by_row_column_and_value() {
        let table = table("a,y\n1,2\n\n1,oops\n");
        let message = table.value(&table.lines[1], 1).unwrap_err().to_string();
        assert!(["t.csv", "row 4", "“y”", "“oops”"].iter().all(|part| message.contains(part)), "{message}");
    }
}
