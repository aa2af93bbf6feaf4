//! A table as text: comma-separated, one header line, quoted only where needed, an empty cell for what does not exist.
//!
//! The dialect is RFC 4180 with `\n` line ends; numbers have a decimal point and as many digits as they carry, never NaN.

use std::io::{self, Write};

/// One cell.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// The quantity does not exist.
    Empty,
    Text(String),
    Integer(i64),
    Number(f64),
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.to_string())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Cell::Text(text)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Cell::Number(value)
    }
}

impl From<usize> for Cell {
    fn from(value: usize) -> Self {
        Cell::Integer(value as i64)
    }
}

impl From<u32> for Cell {
    fn from(value: u32) -> Self {
        Cell::Integer(i64::from(value))
    }
}

impl From<i64> for Cell {
    fn from(value: i64) -> Self {
        Cell::Integer(value)
    }
}

impl From<bool> for Cell {
    fn from(value: bool) -> Self {
        Cell::Text(value.to_string())
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Cell::Empty, Into::into)
    }
}

/// A header and rows of as many cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub columns: Vec<String>,
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    pub fn new(columns: &[&str]) -> Self {
        Table { columns: columns.iter().map(|c| c.to_string()).collect(), rows: vec![] }
    }

    /// The rows as a JSON array of objects, null where a quantity does not exist.
    ///
    /// # Errors
    /// What the writer refuses.
    pub fn write_json(&self, to: &mut impl Write) -> io::Result<()> {
        let value = |cell: &Cell| match cell {
            Cell::Empty => serde_json::Value::Null,
            Cell::Text(text) => text.as_str().into(),
            Cell::Integer(integer) => (*integer).into(),
            Cell::Number(number) => (*number).into(),
        };
        let object = |row: &Vec<Cell>| self.columns.iter().cloned().zip(row.iter().map(value)).collect::<serde_json::Map<_, _>>();
        let rows: Vec<_> = self.rows.iter().map(object).collect();
        serde_json::to_writer_pretty(&mut *to, &rows)?;
        writeln!(to)
    }

    /// Adds one row; a row of the wrong width is our mistake.
    pub fn push(&mut self, row: Vec<Cell>) {
        assert_eq!(row.len(), self.columns.len(), "a row of {} cells under {} columns", row.len(), self.columns.len());
        self.rows.push(row);
    }

    /// Writes the table.
    ///
    /// # Errors
    /// What `out` fails with.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let mut text = String::new();
        line(&mut text, self.columns.iter().map(|c| field(c)));
        for row in &self.rows {
            line(&mut text, row.iter().map(cell));
        }
        out.write_all(text.as_bytes())
    }

    /// The table as a file's bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![];
        self.write(&mut bytes).unwrap_or_else(|_| unreachable!("memory takes every byte"));
        bytes
    }
}

fn line(text: &mut String, fields: impl Iterator<Item = String>) {
    for (i, field) in fields.enumerate() {
        if 0 < i {
            text.push(',');
        }
        text.push_str(&field);
    }
    text.push('\n');
}

fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Empty => String::new(),
        Cell::Text(text) => field(text),
        Cell::Integer(value) => value.to_string(),
        Cell::Number(value) => number(*value),
    }
}

fn field(text: &str) -> String {
    let plain = !text.contains([',', '"', '\n', '\r']) && text.trim() == text;
    if plain { text.to_string() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}

/// Fifteen significant digits: all that survive a change of unit, and none that are only the rounding of it.
fn number(value: f64) -> String {
    if !value.is_finite() {
        return String::new();
    }
    let rounded: f64 = format!("{value:.14e}").parse().unwrap_or(value);
    let size = rounded.abs();
    if rounded == 0.0 {
        "0".into()
    } else if (1e-5..1e15).contains(&size) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_exist_is_an_empty_cell() {
        let mut table = Table::new(&["a", "b", "c"]);
        table.push(vec![None::<f64>.into(), f64::NAN.into(), 2.5.into()]);
        assert_eq!(table.bytes(), b"a,b,c\n,,2.5\n");
    }

    #[test]
    fn text_with_separators_is_quoted() {
        let mut table = Table::new(&["note"]);
        table.push(vec!["held, because \"Order\"\nbroke".into()]);
        table.push(vec![" spaced".into()]);
        assert_eq!(table.bytes(), b"note\n\"held, because \"\"Order\"\"\nbroke\"\n\" spaced\"\n");
    }

    #[test]
    fn numbers_keep_fifteen_digits_and_lose_the_rounding_of_a_change_of_unit() {
        assert_eq!(number(0.1315 / 1e-3), "131.5");
        assert_eq!(number(std::f64::consts::PI), "3.14159265358979");
        assert_eq!(number(2.5e-9), "2.5e-9");
        assert_eq!(number(-0.0), "0");
    }
}
