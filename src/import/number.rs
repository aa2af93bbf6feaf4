//! Numbers as people write them: decimal point or comma, settled for a whole file, never guessed cell by cell.

use super::dialect::Decimal;

/// How the numbers of a file are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Numbers {
    /// `1234.5`; a comma separates thousands, as in `1,234.5`.
    Point,
    /// `1234,5`; a point separates thousands, as in `1.234,5`.
    Comma,
    /// Every cell with a comma reads both ways, as `1,234` does.
    Undecided,
    /// Some cells can only be read with a decimal point, others only with a decimal comma.
    Contradictory,
}

impl Numbers {
    /// As told.
    pub(super) fn told(decimal: Decimal) -> Self {
        match decimal {
            Decimal::Point => Numbers::Point,
            Decimal::Comma => Numbers::Comma,
        }
    }

    /// What the cells say together. Cells that are no numbers say nothing.
    pub(super) fn of<'a>(cells: impl Iterator<Item = &'a str>) -> Self {
        let (mut point, mut comma, mut open) = (false, false, false);
        for cell in cells {
            let number = bare(cell);
            if !number.contains(',') {
                // A point alone is a decimal point: `1.234` for 1234 occurs only beside decimal commas, which show themselves.
                point |= number.contains('.') && number.parse::<f64>().is_ok();
                continue;
            }
            let with_point = read(&number, '.', ',');
            let with_comma = read(&number, ',', '.');
            match (with_point, with_comma) {
                (Some(_), Some(_)) => open = true,
                (Some(_), None) => point = true,
                (None, Some(_)) => comma = true,
                (None, None) => (),
            }
        }
        match (point, comma, open) {
            (true, true, _) => Numbers::Contradictory,
            (false, true, _) => Numbers::Comma,
            (false, false, true) => Numbers::Undecided,
            (_, false, _) => Numbers::Point,
        }
    }

    /// Both readings of the first cell that has two, as `(decimal comma, thousands)`.
    pub(super) fn readings<'a>(cells: impl Iterator<Item = &'a str>) -> Option<(&'a str, f64, f64)> {
        let both = |cell: &'a str| Some((cell, read(&bare(cell), ',', '.')?, read(&bare(cell), '.', ',')?));
        cells.filter(|cell| cell.contains(',')).find_map(both)
    }

    /// The finite number that a cell says, or why it says none, as the end of a sentence that starts with the cell.
    pub(super) fn read(self, cell: &str) -> Result<f64, String> {
        let number = bare(cell);
        if number.is_empty() {
            return Err("is empty".into());
        }
        let value = match self {
            Numbers::Comma => read(&number, ',', '.'),
            Numbers::Point | Numbers::Undecided | Numbers::Contradictory => read(&number, '.', ','),
        };
        match (value, self) {
            (Some(_), Numbers::Undecided) if number.contains(',') => {
                let both = (read(&number, ',', '.').unwrap_or(f64::NAN), value.unwrap_or(f64::NAN));
                Err(format!("reads both {} and {}", both.0, both.1))
            }
            (Some(_), Numbers::Contradictory) if number.contains([',', '.']) => {
                Err("stands in a file that has decimal points and decimal commas".into())
            }
            (Some(value), _) => Ok(value),
            (None, _) if number.parse::<f64>().is_ok_and(|v| !v.is_finite()) => Err("is not a finite number".into()),
            (None, _) => Err("is not a number".into()),
        }
    }
}

/// Without surrounding blanks, with a plain minus sign, and without the blanks and apostrophes that separate thousands.
fn bare(cell: &str) -> String {
    let blank = |c: char| matches!(c, ' ' | '\u{a0}' | '\u{202f}' | '\u{2009}' | '\'' | '’');
    let number: String = cell.trim().chars().map(|c| if c == '−' { '-' } else { c }).collect();
    let whole = number.find(['.', ',', 'e', 'E']).unwrap_or(number.len());
    if !number[..whole].contains(blank) {
        return number;
    }
    // `1 234` is one number; `12 34` is two, and stays as it is.
    let groups: Vec<&str> = number[..whole].trim_start_matches(['+', '-']).split(blank).collect();
    let digits = |group: &&str| group.bytes().all(|b| b.is_ascii_digit());
    let grouped = groups.iter().all(digits) && (1..=3).contains(&groups[0].len()) && groups[1..].iter().all(|group| group.len() == 3);
    if grouped { number.chars().filter(|&c| !blank(c)).collect() } else { number }
}

/// A finite number with the given decimal mark and separator of thousands.
fn read(number: &str, decimal: char, thousands: char) -> Option<f64> {
    let digits = number.trim_start_matches(['+', '-']);
    if !digits.starts_with(|c: char| c.is_ascii_digit() || c == decimal) {
        return None;
    }
    let whole = digits.split([decimal, 'e', 'E']).next().unwrap_or("");
    let groups: Vec<&str> = whole.split(thousands).collect();
    let grouped = 1 < groups.len();
    // A separator of thousands has three digits after it, one to three before, and no number starts with the group 0.
    if grouped && !(groups[1..].iter().all(|g| g.len() == 3) && (1..=3).contains(&groups[0].len()) && !groups[0].starts_with('0')) {
        return None;
    }
    if digits[whole.len()..].contains(thousands) {
        return None;
    }
    let plain: String = number.chars().filter(|&c| c != thousands).map(|c| if c == decimal { '.' } else { c }).collect();
    plain.parse().ok().filter(|v: &f64| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(cells: &[&str]) -> (Numbers, Vec<Result<f64, String>>) {
        let numbers = Numbers::of(cells.iter().copied());
        (numbers, cells.iter().map(|cell| numbers.read(cell)).collect())
    }

    #[test]
    fn one_clear_cell_settles_the_unclear_ones() {
        assert_eq!(all(&["1,234", "0,5"]), (Numbers::Comma, vec![Ok(1.234), Ok(0.5)]));
        assert_eq!(all(&["-8,353", "−0,121"]), (Numbers::Comma, vec![Ok(-8.353), Ok(-0.121)]));
        assert_eq!(all(&["1,234", "1,234.5"]), (Numbers::Point, vec![Ok(1234.0), Ok(1234.5)]));
        assert_eq!(all(&["1.234,5", "2"]), (Numbers::Comma, vec![Ok(1234.5), Ok(2.0)]));
        assert_eq!(all(&["1 234,5", "12 345"]), (Numbers::Comma, vec![Ok(1234.5), Ok(12345.0)]));
        assert_eq!(all(&["1'234.5", "-1\u{a0}234"]), (Numbers::Point, vec![Ok(1234.5), Ok(-1234.0)]));
        assert_eq!(all(&["12 34"]).1, [Err("is not a number".into())]);
        assert_eq!(all(&["1.5e-3", "+2", ".5"]), (Numbers::Point, vec![Ok(1.5e-3), Ok(2.0), Ok(0.5)]));
    }

    #[test]
    fn what_reads_both_ways_is_refused_with_both_readings() {
        let (numbers, values) = all(&["1,234", "5,678"]);
        assert_eq!(numbers, Numbers::Undecided);
        assert_eq!(values[0], Err("reads both 1.234 and 1234".into()));
    }

    #[test]
    fn points_and_commas_in_one_file_are_refused() {
        let (numbers, values) = all(&["1,5", "2.5", "3"]);
        assert_eq!(numbers, Numbers::Contradictory);
        assert!(values[0].is_err() && values[1].is_err() && values[2] == Ok(3.0));
    }

    #[test]
    fn what_is_no_number_says_so() {
        for (cell, reason) in [
            ("", "is empty"),
            ("NaN", "is not a finite number"),
            ("inf", "is not a finite number"),
            ("1e999", "is not a finite number"),
            ("twelve", "is not a number"),
            ("1.2.3", "is not a number"),
            ("=A1", "is not a number"),
        ] {
            assert_eq!(Numbers::Point.read(cell), Err(reason.into()), "{cell}");
        }
    }
}
