//! `[tables]` of `campaign.toml`: what a laboratory tells about its tables, for all of them or for the files of a pattern.

use std::path::{Path, PathBuf};

use glob::Pattern;
use serde::Deserialize;
use toml::Spanned;

use super::campaign_file::Reader;
use super::dialect::{self, Dialect};
use crate::error::Error;

/// What was told, by file.
#[derive(Debug, Clone, Default)]
pub(super) struct Told {
    /// Of the campaign; patterns are below it.
    folder: PathBuf,
    all: Dialect,
    files: Vec<(Pattern, Dialect)>,
}

impl Told {
    /// The dialect of a file: what its patterns tell, the later ones first, and then what is told for all.
    pub(super) fn of(&self, path: &Path) -> Dialect {
        let path = path.strip_prefix(&self.folder).unwrap_or(path);
        let fitting = self.files.iter().rev().filter(|(pattern, _)| pattern.matches_path(path));
        fitting.fold(Dialect::default(), |told, (_, dialect)| told.or(dialect)).or(&self.all)
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct DialectTable {
    #[serde(default)]
    files: Vec<FilesEntry>,
    encoding: Option<Spanned<String>>,
    separator: Option<Spanned<String>>,
    decimal: Option<Spanned<String>>,
    unit: Option<Spanned<String>>,
    angle: Option<Spanned<String>>,
    clockwise: Option<bool>,
    layout: Option<Spanned<String>>,
    header_row: Option<usize>,
    #[serde(default)]
    sheets: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FilesEntry {
    #[serde(rename = "match")]
    pattern: Spanned<String>,
    encoding: Option<Spanned<String>>,
    separator: Option<Spanned<String>>,
    decimal: Option<Spanned<String>>,
    unit: Option<Spanned<String>>,
    angle: Option<Spanned<String>>,
    clockwise: Option<bool>,
    layout: Option<Spanned<String>>,
    header_row: Option<usize>,
    #[serde(default)]
    sheets: Vec<String>,
}

impl DialectTable {
    /// Checks every value.
    ///
    /// # Errors
    /// [`Error::Input`] with the row of a value that is none.
    pub(super) fn told(self, reader: &Reader) -> Result<Told, Error> {
        let folder = reader.path.parent().map(Path::to_path_buf).unwrap_or_default();
        let DialectTable { files, encoding, separator, decimal, unit, angle, clockwise, layout, header_row, sheets } = self;
        let mut told = Told { folder, all: Dialect::default(), files: Vec::new() };
        told.all = check(reader, [encoding, separator, decimal, unit, angle, layout], clockwise, header_row, sheets)?;
        for entry in files {
            let FilesEntry { pattern, encoding, separator, decimal, unit, angle, clockwise, layout, header_row, sheets } = entry;
            let fault = |e: glob::PatternError| {
                let problem = format!("“{}” is no pattern of file names: {}", pattern.get_ref(), e.msg);
                Error::input(reader.place(&pattern.span()), problem, "write one such as \"old/*.csv\"")
            };
            let compiled = Pattern::new(pattern.get_ref()).map_err(fault)?;
            told.files.push((compiled, check(reader, [encoding, separator, decimal, unit, angle, layout], clockwise, header_row, sheets)?));
        }
        Ok(told)
    }
}

fn check(
    reader: &Reader,
    [encoding, separator, decimal, unit, angle, layout]: [Option<Spanned<String>>; 6],
    clockwise: Option<bool>,
    header_row: Option<usize>,
    sheets: Vec<String>,
) -> Result<Dialect, Error> {
    fn value<T>(reader: &Reader, given: Option<Spanned<String>>, read: impl Fn(&str) -> Result<T, String>) -> Result<Option<T>, Error> {
        let Some(given) = given else { return Ok(None) };
        let refuse = |problem: String| Error::input(reader.place(&given.span()), problem, "docs/import.md lists what can be told");
        read(given.get_ref()).map(Some).map_err(refuse)
    }
    Ok(Dialect {
        encoding: value(reader, encoding, dialect::encoding)?,
        separator: value(reader, separator, dialect::separator)?,
        decimal: value(reader, decimal, dialect::decimal)?,
        unit: value(reader, unit, dialect::unit)?,
        angle: value(reader, angle, dialect::angle)?,
        clockwise,
        layout: value(reader, layout, dialect::layout)?,
        header_row,
        sheets,
    })
}
