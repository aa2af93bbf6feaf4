//! The header of a table: which row names the columns, whether a row of units stands below it, and what is title above it.

use super::cells::{Cell, Headed, Row, shortened};
use super::column::bare_unit;
use crate::error::Error;

/// Rows that are looked through for a header: titles, notes and a date stand above it, never a page.
pub(super) const SEARCHED: usize = 60;

/// A header row, found.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    /// Index into the rows that were looked through.
    pub at: usize,
    pub names: Vec<String>,
    /// Whether it names what was looked for.
    pub wanted: bool,
}

/// The header among the first rows: the row that was told; else the first that is `wanted`; else the first with two names; else the first.
///
/// `told` is a line of the file; every row has its line and its cells, trimmed.
pub(super) fn locate(rows: &[(usize, Vec<String>)], told: Option<usize>, wanted: &dyn Fn(&[String]) -> bool) -> Option<Header> {
    let searched = &rows[..rows.len().min(SEARCHED)];
    if let Some(line) = told {
        let at = rows.iter().position(|(l, _)| *l == line)?;
        return Some(Header { at, names: names(rows, at, wanted).0, wanted: true });
    }
    for at in 0..searched.len() {
        if let (names, true) = names(searched, at, wanted) {
            return Some(Header { at, names, wanted: true });
        }
    }
    let filled = |cells: &[String]| cells.iter().filter(|cell| !cell.is_empty()).count();
    let at = searched.iter().position(|(_, cells)| 1 < filled(cells)).unwrap_or(0);
    (!rows.is_empty()).then(|| Header { at, names: names(rows, at, wanted).0, wanted: false })
}

/// The names that row `at` gives, and whether they are wanted. `x, mm, y, mm` above rows of two cells is two names.
fn names(rows: &[(usize, Vec<String>)], at: usize, wanted: &dyn Fn(&[String]) -> bool) -> (Vec<String>, bool) {
    let cells = &rows[at].1;
    let mut widths: Vec<usize> = rows[at + 1..].iter().take(20).map(|(_, row)| row.len()).collect();
    widths.sort_unstable();
    let typical = widths.get(widths.len() / 2).copied();
    let joined = with_units_joined(cells);
    if typical == Some(joined.len()) && joined.len() < cells.len() {
        let found = wanted(&joined);
        return (joined, found);
    }
    (cells.clone(), wanted(cells))
}

/// A cell that is a unit belongs to the name before it.
fn with_units_joined(cells: &[String]) -> Vec<String> {
    let mut joined: Vec<String> = Vec::new();
    for cell in cells {
        match joined.last_mut() {
            Some(name) if bare_unit(cell).is_some() => *name = format!("{name}, {cell}"),
            _ => joined.push(cell.clone()),
        }
    }
    joined
}

/// What stands above the header.
pub(super) fn titles(rows: &[(usize, Vec<String>)], header: &Header) -> Vec<String> {
    // `radius, cm` is one title, also in a file separated by commas.
    rows[..header.at].iter().flat_map(|(_, cells)| with_units_joined(cells)).filter(|cell| !cell.is_empty()).collect()
}

/// Takes a row of units off the rows, refuses names that stand there twice, and says what was found above the header.
///
/// # Errors
/// [`Error::Input`] at the header if two columns have one name.
pub(super) fn finish(mut table: Headed) -> Result<Headed, Error> {
    for (i, name) in table.header.iter().enumerate() {
        if !name.is_empty() && table.header[..i].iter().any(|other| other.to_lowercase() == name.to_lowercase()) {
            let place = table.place().row(table.header_line).column(shortened(name));
            return Err(Error::input(place, "two columns have this name", "give every column its own name"));
        }
    }
    table.units = vec![None; table.header.len()];
    if let Some(first) = table.rows.first().filter(|row| is_units(row)) {
        table.units = (0..table.header.len()).map(|c| first.cells.get(c).and_then(|cell| bare_unit(&cell.text))).collect();
        table.notes.push(format!("row {} holds units", first.line));
        table.rows.remove(0);
    }
    if !table.titles.is_empty() {
        let titles: Vec<String> = table.titles.iter().map(|title| format!("“{}”", shortened(title))).collect();
        table.notes.push(format!("above the header in row {}: {}", table.header_line, shortened(&titles.join(", "))));
    }
    Ok(table)
}

/// At least one unit, and nothing but units, dashes and remarks in brackets.
fn is_units(row: &Row) -> bool {
    let said = |cell: &&Cell| !cell.is_empty();
    let unit = |cell: &Cell| !cell.native && bare_unit(&cell.text).is_some();
    let silent = |cell: &Cell| matches!(cell.text.as_str(), "-" | "–" | "—") || cell.text.starts_with(['[', '(']);
    row.cells.iter().any(unit) && row.cells.iter().filter(said).all(|cell| unit(cell) || silent(cell))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Vec<(usize, Vec<String>)> {
        text.lines().enumerate().map(|(i, line)| (i + 1, line.split(';').map(String::from).collect())).collect()
    }

    #[test]
    fn titles_are_passed_over_where_a_wanted_row_follows() {
        let rows = rows("Institute of Drape\nday;2 May;operator;N\nrun;x_cm;y_cm\n1;2;3\n");
        let wanted = |names: &[String]| names.iter().any(|name| name == "x_cm");
        let header = locate(&rows, None, &wanted).expect("a header");
        assert_eq!((header.at, header.wanted), (2, true));
        assert_eq!(titles(&rows, &header), ["Institute of Drape", "day", "2 May", "operator", "N"]);
        let header = locate(&rows, None, &|_| false).expect("a header");
        assert_eq!((header.at, header.wanted), (1, false));
        assert_eq!(locate(&rows, Some(4), &wanted).map(|h| h.at), Some(3));
        assert_eq!(locate(&rows, Some(9), &wanted), None);
    }

    #[test]
    fn units_that_a_careless_header_splits_off_are_joined_where_the_rows_say_so() {
        let header = locate(&rows("x; mm;y; mm\n1;2\n3;4\n"), None, &|_| false).expect("a header");
        assert_eq!(header.names, ["x,  mm", "y,  mm"]);
        let header = locate(&rows("x;mm;y;mm\n1;2;3;4\n"), None, &|_| false).expect("a header");
        assert_eq!(header.names.len(), 4);
    }
}
