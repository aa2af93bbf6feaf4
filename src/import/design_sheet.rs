//! The design on a sheet of a workbook: taken over as `design.csv`, as it stands there.

use std::path::Path;

use super::cells::Headed;
use super::dialect::Dialect;
use super::{document, layout};
use crate::error::Error;

/// What a `design.csv` that was taken over begins with.
const MARK: &str = "# taken over by hemline import from ";

/// A design table.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub sheet: Option<String>,
    pub runs: usize,
    table: Headed,
}

/// The design in a workbook: a sheet with the column `run` and every factor that campaign.toml names, and without coordinates.
///
/// # Errors
/// Those of reading the file; a file that is no workbook has none.
pub(super) fn find(file: &Path, factors: &[String], dialect: &Dialect) -> Result<Option<Found>, Error> {
    let has = |names: &[String], name: &str| names.iter().any(|other| other.trim().eq_ignore_ascii_case(name));
    let wanted = |names: &[String]| {
        !factors.is_empty() && has(names, "run") && factors.iter().all(|factor| has(names, factor)) && !layout::is_header(names)
    };
    // Where the header of outlines stands says nothing about that of the design.
    let dialect = Dialect { header_row: None, ..dialect.clone() };
    let document = document::read(file, &dialect, &wanted)?;
    let table = document.tables.into_iter().flatten().find(|table| table.sheet.is_some() && wanted(&table.header));
    Ok(table.map(|table| Found { sheet: table.sheet.clone(), runs: table.rows.len(), table }))
}

impl Found {
    /// The bytes of `design.csv`.
    pub(super) fn csv(&self, source: &str, digest: &str) -> Vec<u8> {
        let table = &self.table;
        let sheet = self.sheet.as_ref().map(|sheet| format!(", sheet {sheet}")).unwrap_or_default();
        let mut text =
            format!("{MARK}{}{sheet} (digest {digest}); it is replaced when that is imported again\n", super::cells::one_line(source));
        let mut line = |cells: &mut dyn Iterator<Item = &str>| {
            let cells: Vec<String> = cells.map(field).collect();
            text.push_str(&cells.join(","));
            text.push('\n');
        };
        line(&mut table.header.iter().map(String::as_str));
        if table.units.iter().any(Option::is_some) {
            line(&mut table.units.iter().map(|unit| unit.as_deref().unwrap_or("")));
        }
        for row in 0..table.rows.len() {
            line(&mut (0..table.header.len()).map(|c| table.cell(row, c)));
        }
        text.into_bytes()
    }
}

/// Whether `bytes` may stand where `path` is: nothing is there, the same is, or what an earlier import took over.
pub(super) fn may_replace(path: &Path, bytes: &[u8]) -> bool {
    match std::fs::read(path) {
        Ok(there) => there == bytes || there.starts_with(MARK.as_bytes()),
        Err(_) => !path.exists(),
    }
}

fn field(text: &str) -> String {
    let comment = ["#", "%", "//"].iter().any(|mark| text.starts_with(mark));
    let plain = !comment && !text.contains([',', '"', '\n', '\r', ';', '\t', '|']);
    if plain { text.to_owned() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}
