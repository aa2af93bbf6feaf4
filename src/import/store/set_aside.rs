//! `quarantine.csv` of a campaign: every row, cell and file that was set aside on import, and why.

use std::path::Path;

use super::QUARANTINE;
use crate::error::{Error, Place};
use crate::import::delimited;
use crate::import::dialect::Dialect;
use crate::import::source;

/// One thing that was set aside.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SetAside {
    pub source: String,
    /// `profile, sheet, row, value, problem, remedy, digest`; empty where there is none.
    pub cells: [String; 7],
}

impl SetAside {
    pub fn digest(&self) -> &str {
        &self.cells[6]
    }
}

const COLUMNS: [&str; 8] = ["source", "profile", "sheet", "row", "value", "problem", "remedy", "digest"];

/// The bytes of the file.
pub fn write(set_aside: &[SetAside]) -> Vec<u8> {
    let mut text = COLUMNS.join(",") + "\n";
    for item in set_aside {
        let cells: Vec<String> = std::iter::once(&item.source).chain(&item.cells).map(|cell| field(cell)).collect();
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text.into_bytes()
}

/// What [`write`] wrote; nothing if the file is not there.
///
/// # Errors
/// [`Error::File`] if it cannot be read; [`Error::Input`] if it is another table.
pub fn read(folder: &Path) -> Result<Vec<SetAside>, Error> {
    let path = folder.join(QUARANTINE);
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let (bytes, _) = source::read_table(&path)?;
    let dialect = Dialect { encoding: Some("utf-8".into()), separator: Some(','), header_row: Some(1), ..Dialect::default() };
    let table = delimited::read(&path, bytes, &dialect, &|_| true)?;
    if table.header != COLUMNS || !table.quarantine.is_empty() {
        return Err(Error::input(Place::file(&path), "this table was not written by `hemline import`", "move it away"));
    }
    let cells = |row: usize| std::array::from_fn(|c| table.cell(row, c + 1).to_owned());
    Ok((0..table.rows.len()).map(|row| SetAside { source: table.cell(row, 0).to_owned(), cells: cells(row) }).collect())
}

/// Quoted where it could be taken for more than one cell, for a comment, or for nothing.
fn field(text: &str) -> String {
    let comment = ["#", "%", "//"].iter().any(|mark| text.starts_with(mark));
    let plain = !comment && !text.contains([',', '"', '\n', '\r', ';', '\t', '|']) && text.trim() == text;
    if plain { text.to_owned() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}

/// A cell that no spreadsheet takes for a formula when a person opens the table.
pub fn harmless(text: &str) -> String {
    let formula = text.starts_with(['=', '+', '-', '@', '\t']) && text.parse::<f64>().is_err();
    if formula { format!("'{text}") } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_again() {
        let folder = tempfile::TempDir::new().expect("a folder");
        let item = |source: &str, value: &str| SetAside {
            source: source.into(),
            cells: ["5", "", "3", value, "“x, mm” is not a number; no \"way\"", "correct it", "00ff"].map(String::from),
        };
        let items = vec![item("a.csv", "n/a"), item("#b;c.csv", "1,5;2"), item("", &harmless("=cmd|'/c calc'!A1"))];
        std::fs::write(folder.path().join(QUARANTINE), write(&items)).expect("writable");
        assert_eq!(read(folder.path()).unwrap_or_else(|e| panic!("{e}")), items);
        assert_eq!(read(&folder.path().join("elsewhere")).expect("nothing"), []);
        assert_eq!((harmless("=A1"), harmless("-1.5"), harmless("-x")), ("'=A1".into(), "-1.5".into(), "'-x".into()));
    }
}
