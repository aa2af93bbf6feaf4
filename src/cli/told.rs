//! What is told about tables on the command line, for every command that reads them.

use clap::Args;

use crate::import::dialect::{self, AngleUnit, Decimal, Dialect, Layout};

/// Flags that fix the dialect of tables.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "How tables are written (found out unless told)")]
pub struct Told {
    /// Encoding of texts: utf-8, utf-16le, utf-16be, windows-1251, windows-1252, koi8-r …
    #[arg(long, value_parser = dialect::encoding, value_name = "NAME")]
    pub encoding: Option<String>,
    /// comma, semicolon, tab or bar.
    #[arg(long, value_parser = dialect::separator, value_name = "WORD")]
    pub separator: Option<char>,
    /// Decimal mark: point or comma.
    #[arg(long, value_parser = dialect::decimal, value_name = "MARK")]
    pub decimal: Option<Decimal>,
    /// Unit of lengths whose column states none: mm, cm, m, um or in.
    #[arg(long, value_parser = dialect::unit)]
    pub unit: Option<String>,
    /// Unit of angles whose column states none: deg, rad or gon.
    #[arg(long, value_parser = dialect::angle, value_name = "UNIT")]
    pub angle: Option<AngleUnit>,
    /// Angles grow clockwise.
    #[arg(long)]
    pub clockwise: bool,
    /// long (a row per point), rows (a row per profile) or columns (a column per profile).
    #[arg(long, value_parser = dialect::layout)]
    pub layout: Option<Layout>,
    /// Row of the header, 1 = the first of the file or sheet.
    #[arg(long, value_name = "ROW")]
    pub header_row: Option<usize>,
    /// A sheet to read; may be given several times; all sheets unless told.
    #[arg(long = "sheet", value_name = "NAME")]
    pub sheets: Vec<String>,
}

impl Told {
    pub(super) fn dialect(&self) -> Dialect {
        let Told { encoding, separator, decimal, unit, angle, clockwise, layout, header_row, sheets } = self.clone();
        let clockwise = clockwise.then_some(true);
        Dialect { encoding, separator, decimal, unit, angle, clockwise, layout, header_row, sheets }
    }
}
