//! How many digits a number deserves on paper: as many as its standard error allows. Files keep all of them; only prose rounds.

/// The true minus sign; a hyphen is too short beside figures.
const MINUS: char = '−';

/// `value` with `decimals` places after the point, never “−0.0”.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{:.decimals$}", value.abs());
    let zero = text.bytes().all(|b| matches!(b, b'0' | b'.'));
    if value < 0.0 && !zero { format!("{MINUS}{text}") } else { text }
}

/// As [`fixed`], with a plus before positive numbers: for differences.
pub fn signed(value: f64, decimals: usize) -> String {
    let text = fixed(value, decimals);
    if 0.0 < value && text.bytes().any(|b| matches!(b, b'1'..=b'9')) { format!("+{text}") } else { text }
}

/// `value` to `digits` significant digits; a power of ten is split off where plain figures would be hard to read.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".into() } else { "–".into() };
    }
    let exponent = exponent(value, digits);
    if (-4..6).contains(&exponent) {
        return fixed(value, decimals_for(exponent, digits));
    }
    format!("{} × 10{}", fixed(value / 10f64.powi(exponent), digits.saturating_sub(1)), superscript(exponent))
}

/// `value` as it would be said: up to four significant digits, no trailing zeros. For levels and ticks.
pub fn plain(value: f64) -> String {
    let text = significant(value, 4);
    if text.contains('×') || !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// `value ± standard_error`, the error to two significant digits where it begins with 1 or 2, else to one, the value to the same place.
/// Without an error four significant digits stand alone.
pub fn with_error(value: f64, standard_error: Option<f64>) -> String {
    let Some(error) = standard_error.filter(|e| e.is_finite() && 0.0 < *e) else {
        return significant(value, 4);
    };
    let leading = error / 10f64.powi(exponent(error, 2));
    let digits = if leading < 2.95 { 2 } else { 1 };
    let last_place = exponent(error, digits) - (digits as i32 - 1);
    let top = exponent(value.abs().max(error), 3);
    if (-4..6).contains(&top) {
        let decimals = (-last_place).max(0) as usize;
        return format!("{} ± {}", fixed(value, decimals), fixed(error, decimals));
    }
    let scale = 10f64.powi(top);
    let decimals = (top - last_place).max(0) as usize;
    format!("({} ± {}) × 10{}", fixed(value / scale, decimals), fixed(error / scale, decimals), superscript(top))
}

/// `value` to the place that its standard error reaches; the error itself is not shown. For columns whose error stands beside it.
pub fn to_error(value: f64, standard_error: Option<f64>) -> String {
    let text = with_error(value, standard_error);
    match text.split_once(" ± ") {
        Some((left, right)) => match right.split_once(')') {
            Some((_, power)) => format!("{}{power}", left.trim_start_matches('(')),
            None => left.to_string(),
        },
        None => text,
    }
}

/// A probability as tables print it.
pub fn probability(p: f64) -> String {
    if p < 0.0001 { "< 0.0001".into() } else { fixed(p, 4) }
}

/// Decimal exponent of `value` after rounding to `digits` significant digits.
fn exponent(value: f64, digits: usize) -> i32 {
    let text = format!("{:.*e}", digits.saturating_sub(1), value.abs());
    text.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0)
}

fn decimals_for(exponent: i32, digits: usize) -> usize {
    (digits as i32 - 1 - exponent).max(0) as usize
}

fn superscript(exponent: i32) -> String {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = |c: char| if c == '-' { '⁻' } else { c.to_digit(10).map_or(c, |d| digits[d as usize]) };
    exponent.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_rounded_to_the_place_of_its_error() {
        assert_eq!(with_error(131.5237, Some(0.0412)), "131.52 ± 0.04");
        assert_eq!(with_error(131.5237, Some(0.0142)), "131.524 ± 0.014");
        assert_eq!(with_error(-0.02, Some(3.9)), "0 ± 4");
        assert_eq!(with_error(0.0237, Some(0.0996)), "0.02 ± 0.10");
        assert_eq!(with_error(2.37e-6, Some(4.1e-8)), "(2.37 ± 0.04) × 10⁻⁶");
        assert_eq!(with_error(131.5237, None), "131.5");
    }

    #[test]
    fn a_value_beside_its_error_keeps_the_same_place() {
        assert_eq!(to_error(131.5237, Some(0.0412)), "131.52");
        assert_eq!(to_error(2.37e-6, Some(4.1e-8)), "2.37 × 10⁻⁶");
        assert_eq!(to_error(131.5237, None), "131.5");
    }

    #[test]
    fn significant_digits_survive_rounding_up() {
        assert_eq!(significant(0.09996, 3), "0.100");
        assert_eq!(significant(-1234.6, 3), "−1235");
        assert_eq!(significant(1.5e-7, 2), "1.5 × 10⁻⁷");
        assert_eq!(significant(0.0, 3), "0");
    }

    #[test]
    fn levels_are_said_without_trailing_zeros() {
        assert_eq!(plain(20.0), "20");
        assert_eq!(plain(0.05), "0.05");
        assert_eq!(plain(-12.25), "−12.25");
        assert_eq!(plain(250.0), "250");
    }

    #[test]
    fn zero_has_no_sign() {
        assert_eq!(fixed(-0.004, 2), "0.00");
        assert_eq!(signed(0.004, 2), "0.00");
        assert_eq!(signed(0.4, 2), "+0.40");
        assert_eq!(signed(-0.4, 2), "−0.40");
    }

    #[test]
    fn small_probabilities_are_bounds() {
        assert_eq!(probability(3e-9), "< 0.0001");
        assert_eq!(probability(0.04871), "0.0487");
    }
}
