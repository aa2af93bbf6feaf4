//! How Russian writes numbers, and which form of a noun follows them.

/// Decimal points become commas; numbers that commas separated are then separated by semicolons.
pub fn with_commas(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    let digit = |i: usize| letters.get(i).is_some_and(char::is_ascii_digit);
    let is_point = |i: usize| letters[i] == '.' && 0 < i && digit(i - 1) && digit(i + 1);
    // Two points in one number make it a version, not a number.
    let versions: Vec<bool> = (0..letters.len()).map(|i| is_point(i) && is_version(&letters, i)).collect();
    let some = (0..letters.len()).any(|i| is_point(i) && !versions[i]);
    let mut said = String::with_capacity(text.len());
    for (i, &letter) in letters.iter().enumerate() {
        if is_point(i) && !versions[i] {
            said.push(',');
        } else if letter == ',' && some && letters.get(i + 1) == Some(&' ') && 0 < i && digit(i - 1) {
            said.push(';');
        } else {
            said.push(letter);
        }
    }
    said
}

/// Whether the run of digits and points round `at` has more than one point.
fn is_version(letters: &[char], at: usize) -> bool {
    let part = |c: &&char| c.is_ascii_digit() || **c == '.';
    let before = letters[..at].iter().rev().take_while(part).filter(|c| **c == '.').count();
    let after =
        letters[at + 1..].iter().take_while(part).zip(letters[at + 2..].iter()).filter(|(c, next)| **c == '.' && next.is_ascii_digit());
    0 < before + after.count()
}

/// Which of “складка, складки, складок” follows a number: one; two to four, and fractions; more, and what is no number.
pub fn form(number: &str) -> usize {
    let plain = number.trim().trim_start_matches(['+', '−', '-']);
    if plain.is_empty() || !plain.starts_with(|c: char| c.is_ascii_digit()) {
        return 2;
    }
    let Ok(count) = plain.parse::<u64>() else { return 1 };
    match (count % 10, count % 100) {
        (_, 11..=14) => 2,
        (1, _) => 0,
        (2..=4, _) => 1,
        _ => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_points_become_commas_but_not_those_of_versions_and_names() {
        assert_eq!(with_commas("131.52 ± 0.04"), "131,52 ± 0,04");
        assert_eq!(with_commas("1.5, 2.5, 3"), "1,5; 2,5; 3");
        assert_eq!(with_commas("5, 20, 250"), "5, 20, 250");
        assert_eq!(with_commas("0.1.0"), "0.1.0");
        assert_eq!(with_commas("1.0 to 2.0."), "1,0 to 2,0.");
    }

    #[test]
    fn nouns_agree_with_their_numbers() {
        // Rozental, Справочник по правописанию: 1, 21, 101 складка; 2–4, 22 складки; 5–20, 111 складок; 2,5 складки.
        let forms = ["складка", "складки", "складок"];
        for (number, expected) in [
            ("1", "складка"),
            ("2", "складки"),
            ("4", "складки"),
            ("5", "складок"),
            ("11", "складок"),
            ("14", "складок"),
            ("21", "складка"),
            ("22", "складки"),
            ("111", "складок"),
            ("0", "складок"),
            ("2.5", "складки"),
        ] {
            assert_eq!(forms[form(number)], expected, "{number}");
        }
    }
}
