//! Dialect: what a person says about how tables are written, where the tables themselves do not.

use super::column::length_unit;
use super::encoding;

/// The mark between the whole and the broken part of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decimal {
    Point,
    Comma,
}

/// What an angle is counted in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleUnit {
    Degree,
    Radian,
    /// 1/400 of a turn.
    Gon,
}

/// How profiles lie in a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// One row per point.
    Long,
    /// One row per profile, one column per angle.
    Rows,
    /// One row per angle, one column per profile.
    Columns,
}

impl Layout {
    /// As campaign.toml and flags spell it.
    pub fn name(self) -> &'static str {
        match self {
            Layout::Long => "long",
            Layout::Rows => "rows",
            Layout::Columns => "columns",
        }
    }
}

/// What was told; `None` is found out from the file. A unit that a column states itself is not overruled.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Dialect {
    /// Label of the WHATWG Encoding Standard, such as `windows-1251`; a byte order mark overrules it.
    pub encoding: Option<String>,
    pub separator: Option<char>,
    pub decimal: Option<Decimal>,
    /// Of lengths whose column states none: `mm`, `cm`, `m`, `um` or `in`.
    pub unit: Option<String>,
    /// Of angles whose column states none.
    pub angle: Option<AngleUnit>,
    /// Whether angles grow clockwise; counter-clockwise unless a column says so itself.
    pub clockwise: Option<bool>,
    pub layout: Option<Layout>,
    /// 1 = the first row of the file or sheet.
    pub header_row: Option<usize>,
    /// The sheets of a workbook to read; all if empty.
    pub sheets: Vec<String>,
}

impl Dialect {
    /// What is told here, and for the rest what `other` tells.
    pub fn or(&self, other: &Dialect) -> Dialect {
        Dialect {
            encoding: self.encoding.clone().or_else(|| other.encoding.clone()),
            separator: self.separator.or(other.separator),
            decimal: self.decimal.or(other.decimal),
            unit: self.unit.clone().or_else(|| other.unit.clone()),
            angle: self.angle.or(other.angle),
            clockwise: self.clockwise.or(other.clockwise),
            layout: self.layout.or(other.layout),
            header_row: self.header_row.or(other.header_row),
            sheets: if self.sheets.is_empty() { other.sheets.clone() } else { self.sheets.clone() },
        }
    }
}

/// `.` or `,`, also `point` or `comma`.
pub fn decimal(text: &str) -> Result<Decimal, String> {
    match text {
        "." | "point" => Ok(Decimal::Point),
        "," | "comma" => Ok(Decimal::Comma),
        _ => Err(format!("“{text}” is no decimal mark: use “.” or “,”")),
    }
}

/// One character, or its name.
pub fn separator(text: &str) -> Result<char, String> {
    match text {
        "," | "comma" => Ok(','),
        ";" | "semicolon" => Ok(';'),
        "\t" | "\\t" | "tab" => Ok('\t'),
        "|" | "bar" => Ok('|'),
        _ => Err(format!("“{text}” is no separator: use comma, semicolon, tab or bar")),
    }
}

/// `deg`, `rad` or `gon`.
pub fn angle(text: &str) -> Result<AngleUnit, String> {
    match text {
        "deg" => Ok(AngleUnit::Degree),
        "rad" => Ok(AngleUnit::Radian),
        "gon" => Ok(AngleUnit::Gon),
        _ => Err(format!("“{text}” is no unit of angle: use deg, rad or gon")),
    }
}

/// `long`, `rows` or `columns`.
pub fn layout(text: &str) -> Result<Layout, String> {
    match text {
        "long" => Ok(Layout::Long),
        "rows" => Ok(Layout::Rows),
        "columns" => Ok(Layout::Columns),
        _ => Err(format!("“{text}” is no layout: use long (a row per point), rows (a row per profile) or columns (a column per profile)")),
    }
}

/// A unit of length.
pub fn unit(text: &str) -> Result<String, String> {
    match length_unit(text) {
        Some(_) => Ok(text.to_owned()),
        None => Err(format!("“{text}” is no unit of length: use mm, cm, m, um or in")),
    }
}

/// The label of an encoding.
pub fn encoding(text: &str) -> Result<String, String> {
    match encoding::known(text) {
        Some(_) => Ok(text.to_owned()),
        None => Err(format!("“{text}” is no encoding: use utf-8, utf-16le, utf-16be, windows-1251, windows-1252, koi8-r …")),
    }
}
