//! Tables as the page takes them: heads in words with units, cells that are shown one way and sorted by their value.

use serde_json::{Value, json};

use super::heading::{self, Kind};
use crate::report::csv::{Cell, Table};
use crate::report::document::regression::term;
use crate::report::number::{probability, significant};
use crate::report::words;

/// One column of a table that is put together by hand.
#[derive(Debug, Clone)]
pub struct Column {
    name: String,
    unit: String,
    kind: &'static str,
}

impl Column {
    /// Text.
    pub fn text(name: impl Into<String>) -> Self {
        Column { name: name.into(), unit: String::new(), kind: "text" }
    }

    /// Sentences, which may be broken into lines.
    pub fn words(name: impl Into<String>) -> Self {
        Column { kind: "words", ..Column::text(name) }
    }

    /// Numbers, aligned on the right; the unit stands below the name.
    pub fn number(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Column { unit: unit.into(), kind: "number", ..Column::text(name) }
    }
}

/// A table of texts; those in columns of numbers are sorted by the number that they begin with.
pub fn of_texts(columns: &[Column], rows: impl IntoIterator<Item = Vec<String>>) -> Value {
    let cell = |(column, text): (&Column, String)| match sort_value(&text).filter(|_| column.kind == "number") {
        Some(value) => json!([text, value]),
        None if text.is_empty() => Value::Null,
        None => json!(text),
    };
    let rows: Vec<Vec<Value>> = rows.into_iter().map(|row| columns.iter().zip(row).map(cell).collect()).collect();
    json!({ "columns": columns.iter().map(column).collect::<Vec<_>>(), "rows": rows })
}

fn column(column: &Column) -> Value {
    json!({ "name": column.name, "unit": column.unit, "number": column.kind == "number", "words": column.kind == "words" })
}

/// A result table as it is written to disk, rounded; columns without any entry are left out.
pub fn of_results(table: &Table) -> Value {
    let kept: Vec<usize> = (0..table.columns.len()).filter(|&i| table.rows.iter().any(|row| row[i] != Cell::Empty)).collect();
    let (mut columns, mut rows) = (vec![], vec![Vec::with_capacity(kept.len()); table.rows.len()]);
    for &i in &kept {
        let head = heading::of(&table.columns[i]);
        let numbers: Vec<f64> = table.rows.iter().filter_map(|row| value(&row[i])).collect();
        let rounding = Rounding::of(&numbers, head.kind, table.rows.iter().any(|row| matches!(row[i], Cell::Number(_))));
        let long = table.rows.iter().any(|row| matches!(&row[i], Cell::Text(text) if 40 < text.chars().count()));
        columns.push(json!({
            "name": head.name,
            "unit": head.unit,
            "number": !numbers.is_empty(),
            "decimals": if let Rounding::Decimals(decimals) = rounding { Some(decimals) } else { None },
            "words": long,
        }));
        for (out, row) in rows.iter_mut().zip(&table.rows) {
            out.push(match &row[i] {
                Cell::Empty => Value::Null,
                Cell::Text(text) => json!(said(text, head.kind)),
                Cell::Integer(value) if matches!(rounding, Rounding::Decimals(_)) => json!(value),
                Cell::Integer(value) => json!([value.to_string(), value]),
                Cell::Number(value) => rounding.cell(*value),
            });
        }
    }
    json!({ "columns": columns, "rows": rows })
}

fn value(cell: &Cell) -> Option<f64> {
    match cell {
        Cell::Integer(value) => Some(*value as f64),
        Cell::Number(value) if value.is_finite() => Some(*value),
        _ => None,
    }
}

/// A code of the files as a reader meets it.
fn said(text: &str, kind: Kind) -> String {
    match kind {
        Kind::Code => text.replace('_', " "),
        Kind::Response => {
            let said = words::response(text);
            if said.unit.is_empty() { said.label } else { format!("{}, {}", said.label, said.unit) }
        }
        Kind::Term => term(text),
        _ if text == "true" => "yes".into(),
        _ if text == "false" => "no".into(),
        _ => text.to_string(),
    }
}

/// How the numbers of one column are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Rounding {
    /// All to the same place: they stand below each other.
    Decimals(usize),
    /// Each to as many digits: they differ by powers of ten.
    Digits,
    Probability,
}

/// Significant digits of the largest number of a column.
const DIGITS: i32 = 4;
/// Lengths in mm are shown to this place: no profile is measured better.
const MILLIMETRE_DECIMALS: usize = 2;

impl Rounding {
    fn of(numbers: &[f64], kind: Kind, fractions: bool) -> Rounding {
        let most = numbers.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let least = numbers.iter().filter(|v| **v != 0.0).fold(f64::INFINITY, |least, v| least.min(v.abs()));
        match kind {
            Kind::Probability => Rounding::Probability,
            _ if !fractions => Rounding::Decimals(0),
            _ if most == 0.0 => Rounding::Decimals(1),
            // Beyond these plain figures are hard to read, or the small ones vanish.
            _ if !(1e-3..1e6).contains(&most) || least < 1e-5 * most => Rounding::Digits,
            Kind::Millimetres => Rounding::Decimals(MILLIMETRE_DECIMALS),
            _ => Rounding::Decimals((DIGITS - 1 - most.log10().floor() as i32).clamp(0, 6) as usize),
        }
    }

    fn cell(self, value: f64) -> Value {
        if !value.is_finite() {
            return Value::Null;
        }
        match self {
            Rounding::Decimals(decimals) => json!(format!("{value:.decimals$}").parse::<f64>().unwrap_or(value) + 0.0),
            Rounding::Digits => json!([significant(value, DIGITS as usize), value]),
            Rounding::Probability => json!([probability(value), value]),
        }
    }
}

const SUPERSCRIPTS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// The number that a text of a column of numbers begins with: “−12.4 ± 0.3”, “(2.37 ± 0.04) × 10⁻⁶”, “< 0.0001”, “85 %”.
fn sort_value(text: &str) -> Option<f64> {
    let plain = text.replace('−', "-").replace(['+', '(', '[', '<'], " ");
    let first = plain.split_whitespace().next()?.trim_end_matches([',', ')', ']', ';']);
    let value: f64 = first.parse().ok().filter(|v: &f64| v.is_finite())?;
    let power = text.split_once("× 10").map(|(_, raised)| {
        let digit = |c: char| SUPERSCRIPTS.iter().position(|s| *s == c).and_then(|i| char::from_digit(i as u32, 10));
        let digits: String = raised.chars().filter_map(|c| if c == '⁻' { Some('-') } else { digit(c) }).collect();
        digits.parse::<i32>().unwrap_or(0)
    });
    // A bound on a probability comes before all that are told.
    let value = if text.trim_start().starts_with('<') { 0.5 * value } else { value };
    Some(value * 10f64.powi(power.unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_sort_by_the_number_they_begin_with() {
        assert_eq!(sort_value("−12.4 ± 0.3"), Some(-12.4));
        assert_eq!(sort_value("+1.5"), Some(1.5));
        assert!((sort_value("(2.37 ± 0.04) × 10⁻⁶").unwrap() - 2.37e-6).abs() < 1e-20);
        assert!((sort_value("1.2 × 10¹²").unwrap() - 1.2e12).abs() < 1.0);
        assert_eq!(sort_value("< 0.0001"), Some(0.00005));
        assert_eq!(sort_value("85 %"), Some(85.0));
        assert_eq!(sort_value("[3.1]"), Some(3.1));
        assert_eq!(sort_value("round"), None);
        assert_eq!(sort_value("–"), None);
        assert_eq!(sort_value("inf"), None);
    }

    #[test]
    fn a_column_keeps_one_place_unless_its_numbers_differ_by_powers_of_ten() {
        assert_eq!(Rounding::of(&[153.0967, 0.2], Kind::Millimetres, true), Rounding::Decimals(2));
        assert_eq!(Rounding::of(&[0.98, 0.2], Kind::Plain, true), Rounding::Decimals(4));
        assert_eq!(Rounding::of(&[3.0, 4.0], Kind::Plain, false), Rounding::Decimals(0));
        assert_eq!(Rounding::of(&[1e-9, 0.2], Kind::Plain, true), Rounding::Digits);
        assert_eq!(Rounding::Decimals(2).cell(-0.001), json!(0.0));
    }

    #[test]
    fn empty_columns_are_left_out_and_codes_are_words() {
        let mut table = Table::new(&["run", "termination", "lambda_missing", "p_mm", "significant"]);
        table.push(vec!["a_b".into(), "held_length".into(), Cell::Empty, 153.0967.into(), true.into()]);
        table.push(vec!["c".into(), Cell::Empty, Cell::Empty, Cell::Empty, false.into()]);
        let page = of_results(&table);
        assert_eq!(page["rows"], json!([["a_b", "held length", 153.1, "yes"], ["c", null, null, "no"]]));
        assert_eq!(page["columns"][2]["unit"], "mm");
    }
}
