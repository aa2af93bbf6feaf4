//! Delimited text: bytes of a CSV or TSV file → named columns of text cells, each row with its line in the file.
//!
//! Polars splits the cells. What it cannot know is settled before: the encoding mark, the separator, the unit tokens that a careless header
//! splits off, and which line of the file a row came from, so that a fault can be located.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use polars::prelude::{CsvParseOptions, CsvReadOptions, DataType, Field, Schema, SerReader};

use super::number::Numbers;
use super::source;
use crate::error::{Error, Place};
use crate::experiment::Quarantined;
use crate::experiment::Source;

/// Separators tried, in this order: the first that splits header and rows alike is it.
const SEPARATORS: [char; 3] = ['\t', ';', ','];
/// More columns than this are no table of profiles; it bounds the memory that a broken file can ask for.
const MOST_COLUMNS: usize = 10_000;

/// A table of text cells.
#[derive(Debug, Clone)]
pub(super) struct Delimited {
    pub source: Source,
    pub separator: char,
    /// Line of the header.
    pub header_line: usize,
    /// Column names as the header has them, trimmed.
    pub header: Vec<String>,
    /// `columns[c][r]`, trimmed; empty where the file has nothing.
    columns: Vec<Vec<String>>,
    /// `lines[r]`: 1 = the first line of the file.
    pub lines: Vec<usize>,
    /// Rows that could not be split like the header.
    pub quarantine: Vec<Quarantined>,
}

impl Delimited {
    pub(super) fn rows(&self) -> usize {
        self.lines.len()
    }

    pub(super) fn cell(&self, row: usize, column: usize) -> &str {
        &self.columns[column][row]
    }

    /// The cells of some columns, in file order, to settle how numbers are written.
    pub(super) fn numbers(&self, columns: &[usize]) -> Numbers {
        Numbers::of(columns.iter().flat_map(|&c| self.columns[c].iter().map(String::as_str)))
    }
}

/// Reads a delimited text file with one header line.
///
/// # Errors
/// [`Error::File`] if it cannot be read; [`Error::Input`] if it is no text, empty, or has a header only, or two columns of one name.
pub(super) fn read(path: &Path) -> Result<Delimited, Error> {
    let (bytes, source) = source::read(path)?;
    let text = decode(&bytes).map_err(|problem| Error::input(Place::file(path), problem, "save it as CSV, UTF-8"))?;
    // A line that is blank or a comment is no row; the rest keep their line numbers.
    let mut lines = records(&text).filter(|(_, line)| !(line.trim().is_empty() || line.starts_with('#')));
    let Some((header_line, first)) = lines.next() else {
        return Err(Error::input(Place::file(path), "the file is empty", "it needs a header line and one line per row"));
    };
    let rest: Vec<(usize, &str)> = lines.collect();
    let (separator, header) = dialect(first, &rest);
    if MOST_COLUMNS < header.len() {
        return Err(Error::input(
            Place::file(path).row(header_line),
            format!("{} columns", header.len()),
            format!("at most {MOST_COLUMNS} are read"),
        ));
    }
    for (i, name) in header.iter().enumerate() {
        if !name.is_empty() && header[..i].iter().any(|other| other.eq_ignore_ascii_case(name)) {
            let place = Place::file(path).row(header_line).column(name);
            return Err(Error::input(place, "two columns have this name", "give every column its own name"));
        }
    }
    let mut quarantine = Vec::new();
    let mut body = String::with_capacity(text.len());
    let mut kept = Vec::with_capacity(rest.len());
    for (line, row) in rest {
        let cells = split(row, separator).len();
        // Spreadsheets pad rows with empty cells; too few or too many with something in them would put values under wrong names.
        let padded = header.len() < cells && split(row, separator)[header.len()..].iter().all(|cell| cell.is_empty());
        if cells == header.len() || padded {
            kept.push(line);
            body.push_str(row);
            body.push('\n');
        } else if row.chars().any(|c| c != separator && !c.is_whitespace()) {
            quarantine.push(Quarantined {
                run: None,
                file: path.to_path_buf(),
                row: Some(line),
                value: shortened(row),
                problem: format!("{cells} cells where the header has {}", header.len()),
                remedy: "check for a missing cell, or a decimal comma in a file separated by commas".into(),
            });
        }
    }
    let columns = cells(path, body, separator, header.len())?;
    if columns.iter().any(|column| column.len() != kept.len()) {
        return Err(Error::input(Place::file(path), "the rows cannot be told apart", "check for a quotation mark that is never closed"));
    }
    Ok(Delimited { source, separator, header_line, header, columns, lines: kept, quarantine })
}

/// Splits the rows with polars; every column is text.
fn cells(path: &Path, body: String, separator: char, width: usize) -> Result<Vec<Vec<String>>, Error> {
    if body.is_empty() {
        return Ok(vec![Vec::new(); width]);
    }
    let refuse = |e: polars::error::PolarsError| Error::input(Place::file(path), one_line(&e.to_string()), "save it as plain CSV, UTF-8");
    let schema = Schema::from_iter((0..width).map(|c| Field::new(format!("{c}").into(), DataType::String)));
    let parse = CsvParseOptions::default().with_separator(separator as u8).with_truncate_ragged_lines(true);
    let options = CsvReadOptions::default()
        .with_has_header(false)
        .with_schema(Some(Arc::new(schema)))
        .with_parse_options(parse)
        .with_n_threads(Some(1));
    let frame = options.into_reader_with_file_handle(Cursor::new(body)).finish().map_err(refuse)?;
    frame
        .columns()
        .iter()
        .map(|column| {
            let text = column.str().map_err(refuse)?;
            Ok(text.iter().map(|cell| cell.unwrap_or_default().trim().to_owned()).collect())
        })
        .collect()
}

/// UTF-8, with or without its mark.
fn decode(bytes: &[u8]) -> Result<String, String> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF") {
        return Err("the text is encoded as UTF-16".into());
    }
    if bytes.starts_with(b"PK\x03\x04") {
        return Err("this is a spreadsheet or archive, not text".into());
    }
    if bytes.contains(&0) {
        return Err("this is no text file".into());
    }
    String::from_utf8(bytes.to_vec()).map_err(|e| {
        let line = bytes[..e.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count() + 1;
        format!("row {line} is not UTF-8 text")
    })
}

/// Records with the number of their first line. A line break inside quotes does not end a record.
fn records(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut rest = text;
    let mut line = 1;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let (mut quoted, mut end, mut breaks) = (false, rest.len(), 0);
        let bytes = rest.as_bytes();
        for (i, &byte) in bytes.iter().enumerate() {
            match byte {
                b'"' => quoted = !quoted,
                // Old Macintosh files end lines with a bare carriage return.
                b'\n' | b'\r' if !(byte == b'\r' && bytes.get(i + 1) == Some(&b'\n')) => {
                    breaks += 1;
                    if !quoted {
                        end = i;
                        break;
                    }
                }
                _ => (),
            }
        }
        let record = (line, rest[..end].trim_end_matches('\r'));
        line += breaks;
        rest = rest.get(end + 1..).unwrap_or("");
        Some(record)
    })
}

/// Cells of one record, quotes taken off, trimmed.
fn split(record: &str, separator: char) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    for c in record.chars() {
        match c {
            '"' => quoted = !quoted,
            c if c == separator && !quoted => cells.push(String::new()),
            c => cells[..].last_mut().into_iter().for_each(|cell| cell.push(c)),
        }
    }
    cells.into_iter().map(|cell| cell.trim().to_owned()).collect()
}

/// The separator and the header cells: the first separator that splits the header like most of the first rows.
fn dialect(header: &str, rows: &[(usize, &str)]) -> (char, Vec<String>) {
    let width = |separator| {
        let mut widths: Vec<usize> = rows.iter().take(20).map(|(_, row)| split(row, separator).len()).collect();
        widths.sort_unstable();
        widths.get(widths.len() / 2).copied()
    };
    for separator in SEPARATORS {
        let cells = split(header, separator);
        let joined = with_units_joined(&cells);
        for names in [cells, joined] {
            if 1 < names.len() && width(separator).is_none_or(|w| w == names.len()) {
                return (separator, names);
            }
        }
    }
    let separator = SEPARATORS.into_iter().find(|&s| header.contains(s)).unwrap_or(',');
    (separator, split(header, separator))
}

/// `x, mm, y, mm` is two columns: a cell that is a unit belongs to the name before it.
fn with_units_joined(cells: &[String]) -> Vec<String> {
    let mut joined: Vec<String> = Vec::new();
    for cell in cells {
        match joined.last_mut() {
            Some(name) if crate::units::factor(&cell.to_lowercase()).is_some() => *name = format!("{name}, {cell}"),
            _ => joined.push(cell.clone()),
        }
    }
    joined
}

/// A value short enough for one sentence.
pub(super) fn shortened(value: &str) -> String {
    const LONGEST: usize = 60;
    let value = one_line(value);
    if value.chars().count() <= LONGEST { value } else { value.chars().take(LONGEST).chain(['…']).collect() }
}

/// A message on one line.
pub(super) fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separators_and_split_off_units_are_found() {
        let dialect = |header: &str, row: &str| dialect(header, &[(2, row)]);
        assert_eq!(dialect("x_cm;y_cm", "1,5;2,5"), (';', vec!["x_cm".into(), "y_cm".into()]));
        assert_eq!(dialect("x, mm;y, mm", "1;2"), (';', vec!["x, mm".into(), "y, mm".into()]));
        assert_eq!(dialect("x, mm,y, mm", "1,2"), (',', vec!["x, mm".into(), "y, mm".into()]));
        assert_eq!(dialect("\"x, mm\"\ty", "1\t2"), ('\t', vec!["x, mm".into(), "y".into()]));
    }

    #[test]
    fn records_keep_their_line_numbers_past_blank_lines_and_quoted_breaks() {
        let found: Vec<(usize, &str)> = records("a\r\n\r\n\"b\nc\"\nd").collect();
        assert_eq!(found, [(1, "a"), (2, ""), (3, "\"b\nc\""), (5, "d")]);
    }
}
