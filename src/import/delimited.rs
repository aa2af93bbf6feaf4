//! Delimited text: bytes of a CSV or TSV file → a table with its header, each row with its line in the file.
//!
//! Polars splits the cells. What it cannot know is settled before: the encoding, the separator, where the header stands, the unit tokens that a
//! careless header splits off, and which line of the file a row came from, so that a fault can be located.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use polars::prelude::{CsvParseOptions, CsvReadOptions, DataType, Field, Schema, SerReader};

use super::cells::{Cell, Headed, MOST_CELLS, MOST_COLUMNS, Row, one_line};
use super::dialect::Dialect;
use super::encoding;
use super::header::{self, Header};
use crate::error::{Error, Place};

/// Separators tried, in this order: the first that splits the rows alike under a header that is looked for is it.
const SEPARATORS: [char; 4] = ['\t', ';', ',', '|'];
/// A longer line is no row of a table: ten thousand columns of a hundred characters. Bytes.
const LONGEST_LINE: usize = 1 << 20;
/// What a line begins with that is for people.
const COMMENTS: [&str; 3] = ["#", "%", "//"];

/// Reads a delimited text with one header row.
///
/// # Errors
/// [`Error::Input`] if it is no text, empty, too wide, too long, or has two columns of one name.
pub(super) fn read(path: &Path, bytes: Vec<u8>, dialect: &Dialect, wanted: &dyn Fn(&[String]) -> bool) -> Result<Headed, Error> {
    let refuse = |problem: String, remedy: &str| Error::input(Place::file(path), problem, remedy);
    let decoded = encoding::decode(&bytes, dialect.encoding.as_deref())
        .map_err(|problem| refuse(problem, "save it as CSV, UTF-8; or as XLSX, ODS or Parquet"))?;
    drop(bytes);
    let text = decoded.text;
    // A line that is blank or a comment is no row; the rest keep their line numbers.
    let comment = |line: &str| COMMENTS.iter().any(|mark| line.trim_start().starts_with(mark));
    let mut comments = 0;
    let mut lines: Vec<(usize, &str)> = Vec::new();
    for (line, record) in records(&text) {
        if LONGEST_LINE < record.len() {
            let problem = format!("row {line} has {} bytes", record.len());
            return Err(refuse(problem, "a row has at most 1 MiB; check for a quotation mark that is never closed"));
        }
        if comment(record) {
            comments += 1;
        } else if !record.trim().is_empty() {
            lines.push((line, record));
        }
    }
    let preview: Vec<(usize, &str)> = lines.iter().take(2 * header::SEARCHED).copied().collect();
    let Some((separator, found, split_rows)) = split_by(&preview, dialect, wanted) else {
        if let (Some(row), false) = (dialect.header_row, lines.is_empty()) {
            return Err(refuse(format!("row {row}, told to be the header, is not among the first rows with text"), "correct header_row"));
        }
        return Err(refuse("the file is empty".into(), "it needs a header line and one line per row"));
    };
    let header_line = split_rows[found.at].0;
    if MOST_COLUMNS < found.names.len() {
        return Err(Error::input(
            Place::file(path).row(header_line),
            format!("{} columns", found.names.len()),
            format!("at most {MOST_COLUMNS} are read"),
        ));
    }
    let mut table = Headed {
        file: path.to_path_buf(),
        sheet: None,
        encoding: Some(decoded.name),
        separator: Some(separator),
        header_line,
        titles: header::titles(&split_rows, &found),
        units: Vec::new(),
        rows: Vec::new(),
        quarantine: Vec::new(),
        notes: Vec::new(),
        header: found.names,
    };
    if 0 < comments {
        table.notes.push(format!("{comments} comment line(s) were passed over"));
    }
    fill(path, &mut table, &lines[found.at + 1..], separator)?;
    header::finish(table)
}

/// Splits the rows below the header and sets aside those of another width.
fn fill(path: &Path, table: &mut Headed, lines: &[(usize, &str)], separator: char) -> Result<(), Error> {
    let width = table.header.len();
    if MOST_CELLS < width.saturating_mul(lines.len()) {
        let problem = format!("{} rows of {width} columns", lines.len());
        return Err(Error::input(Place::file(path), problem, format!("at most {MOST_CELLS} cells are read; split the file")));
    }
    let mut body = String::new();
    let mut kept = Vec::with_capacity(lines.len());
    for &(line, row) in lines {
        let cells = split(row, separator);
        // Spreadsheets pad rows with empty cells; too few or too many with something in them would put values under wrong names.
        let padded = width < cells.len() && cells[width..].iter().all(|cell| cell.is_empty());
        if cells.len() == width || padded {
            kept.push(line);
            body.push_str(row);
            body.push('\n');
        } else if row.chars().any(|c| c != separator && !c.is_whitespace()) {
            let problem = format!("{} cells where the header has {width}", cells.len());
            let remedy = "check for a missing cell, or a decimal comma in a file separated by commas";
            table.quarantine.push(table.fault(None, Some(line), row, problem, remedy));
        }
    }
    table.rows = cells(path, body, separator, width, &kept)?;
    Ok(())
}

/// Splits the rows with polars; every column is text.
fn cells(path: &Path, body: String, separator: char, width: usize, lines: &[usize]) -> Result<Vec<Row>, Error> {
    if body.is_empty() {
        return Ok(Vec::new());
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
    if frame.height() != lines.len() {
        return Err(Error::input(Place::file(path), "the rows cannot be told apart", "check for a quotation mark that is never closed"));
    }
    let mut rows: Vec<Row> = lines.iter().map(|&line| Row { line, cells: Vec::with_capacity(width) }).collect();
    for column in frame.columns() {
        let text = column.str().map_err(refuse)?;
        rows.iter_mut().zip(text.iter()).for_each(|(row, cell)| row.cells.push(Cell::text(cell.unwrap_or_default())));
    }
    Ok(rows)
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

/// The first rows with their lines, each split into cells.
type SplitRows = Vec<(usize, Vec<String>)>;

/// The separator, the header, and the first rows split by it: the first separator that splits most rows alike, under a header that is wanted
/// if there is one. `None` if there are no rows, or the header that was told is not among them.
fn split_by(rows: &[(usize, &str)], dialect: &Dialect, wanted: &dyn Fn(&[String]) -> bool) -> Option<(char, Header, SplitRows)> {
    let with = |separator: char| {
        let split_rows: SplitRows = rows.iter().map(|(line, row)| (*line, split(row, separator))).collect();
        let header = header::locate(&split_rows, dialect.header_row, wanted)?;
        Some((separator, header, split_rows))
    };
    if let Some(told) = dialect.separator {
        return with(told);
    }
    let alike: Vec<_> = SEPARATORS.into_iter().filter(|&separator| splits_alike(rows, separator)).filter_map(with).collect();
    let best = alike.iter().position(|(_, header, _)| header.wanted).unwrap_or(0);
    match alike.into_iter().nth(best) {
        Some(found) => Some(found),
        None => with(SEPARATORS.into_iter().find(|&s| rows.iter().any(|(_, row)| row.contains(s))).unwrap_or(',')),
    }
}

/// Whether more than half of the rows have one and the same number of cells, more than one.
fn splits_alike(rows: &[(usize, &str)], separator: char) -> bool {
    let mut widths: Vec<usize> = rows.iter().map(|(_, row)| split(row, separator).len()).collect();
    widths.sort_unstable();
    let most = widths.chunk_by(|a, b| a == b).filter(|group| 1 < group[0]).map(<[usize]>::len).max();
    most.is_some_and(|most| rows.len() <= 2 * most)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dialect(text: &str) -> (char, Vec<String>) {
        let rows: Vec<(usize, &str)> = records(text).collect();
        let (separator, header, _) = split_by(&rows, &Dialect::default(), &|_| false).expect("rows");
        (separator, header.names)
    }

    #[test]
    fn separators_and_split_off_units_are_found() {
        assert_eq!(dialect("x_cm;y_cm\n1,5;2,5"), (';', vec!["x_cm".into(), "y_cm".into()]));
        assert_eq!(dialect("x, mm;y, mm\n1;2"), (';', vec!["x, mm".into(), "y, mm".into()]));
        assert_eq!(dialect("x, mm,y, mm\n1,2"), (',', vec!["x, mm".into(), "y, mm".into()]));
        assert_eq!(dialect("\"x, mm\"\ty\n1\t2"), ('\t', vec!["x, mm".into(), "y".into()]));
        assert_eq!(dialect("x_cm|y_cm\n1|2"), ('|', vec!["x_cm".into(), "y_cm".into()]));
    }

    #[test]
    fn records_keep_their_line_numbers_past_blank_lines_and_quoted_breaks() {
        let found: Vec<(usize, &str)> = records("a\r\n\r\n\"b\nc\"\nd").collect();
        assert_eq!(found, [(1, "a"), (2, ""), (3, "\"b\nc\""), (5, "d")]);
    }

    #[test]
    fn bounds_are_said_and_held() {
        let read = |text: String| {
            let refused = read(Path::new("t.csv"), text.into_bytes(), &Dialect::default(), &|_| false);
            refused.map(|table| table.rows.len()).expect_err("refused").to_string()
        };
        assert!(read(format!("x,y\n{}\n", "1,".repeat(600_000))).contains("at most 1 MiB"));
        assert!(read(format!("{}\n1\n", "c,".repeat(20_000))).contains("at most 10000 are read"));
        assert!(read(String::from("x,y\n\"1,2\n") + &"3,4\n".repeat(1 << 19)).contains("quotation mark"));
    }
}
