//! What a column of the fits table is called in prose, and its unit: `fold_depth_mm` → “Fold depth”, “mm”.

/// A response as a reader meets it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Response {
    /// “Mean radius p”.
    pub label: String,
    /// “mm”; empty for a pure number.
    pub unit: String,
}

/// Words for a response; a name that is not known is spelled out, with the unit that its suffix tells.
pub fn response(name: &str) -> Response {
    let (stem, unit) = UNITS.iter().find_map(|(suffix, unit)| Some((name.strip_suffix(suffix)?, *unit))).unwrap_or((name, ""));
    let label = LABELS.iter().find(|(known, _)| *known == stem).map(|(_, label)| label.to_string());
    Response { label: label.unwrap_or_else(|| spelled(stem)), unit: unit.to_string() }
}

/// A column of a table without its suffix, and the unit that the suffix tells. Tables have no lengths in m: `predicted_m` is a fold count.
pub fn column_unit(name: &str) -> (&str, Option<&'static str>) {
    let told =
        UNITS.iter().filter(|(suffix, _)| *suffix != "_m").find_map(|(suffix, unit)| Some((name.strip_suffix(suffix)?, Some(*unit))));
    told.unwrap_or((name, None))
}

/// Unit suffixes, longest first where one ends with another.
const UNITS: [(&str, &str); 10] = [
    ("_percent", "%"),
    ("_n_m2", "N/m²"),
    ("_mm2", "mm²"),
    ("_mm", "mm"),
    ("_cm", "cm"),
    ("_m", "m"),
    ("_deg", "°"),
    ("_rad", "rad"),
    ("_n", "N"),
    ("_j", "J"),
];

const LABELS: [(&str, &str); 17] = [
    ("p", "Mean radius p"),
    ("q", "Fold amplitude q"),
    ("s", "Lean s"),
    ("m", "Fold count m"),
    ("rms", "Misfit rms"),
    ("fold_depth", "Fold depth"),
    ("mean_radius", "Radius of equal area"),
    ("drape_coefficient", "Drape coefficient"),
    ("theory_gap", "Distance from the predicted hem"),
    ("perimeter", "Perimeter"),
    ("area", "Area"),
    ("explained_share", "Explained share"),
    ("lambda_first_integral", "λ, first integral"),
    ("lambda_ritz", "λ, Ritz"),
    ("lambda_ruled", "λ, ruled shell"),
    ("lambda_over_weight", "λ/(ρg), first integral"),
    ("lambda_over_weight_ritz", "λ/(ρg), Ritz"),
];

fn spelled(stem: &str) -> String {
    let words = stem.replace('_', " ");
    let mut letters = words.chars();
    letters.next().map(|c| c.to_uppercase().collect::<String>() + letters.as_str()).unwrap_or_default()
}

/// A name as part of a file's: letters, digits, `-` and `_` stay, everything else is percent-encoded, so that different names stay different.
pub fn file_stem(name: &str) -> String {
    let mut stem = String::with_capacity(name.len());
    for c in name.chars() {
        if c.is_alphanumeric() || c == '_' || c == '-' {
            stem.push(c);
        } else {
            let mut bytes = [0; 4];
            c.encode_utf8(&mut bytes).bytes().for_each(|b| stem.push_str(&format!("%{b:02X}")));
        }
    }
    stem
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_response_has_words_and_a_unit() {
        let said = |name: &str| {
            let r = response(name);
            (r.label, r.unit)
        };
        assert_eq!(said("p_mm"), ("Mean radius p".into(), "mm".into()));
        assert_eq!(said("m"), ("Fold count m".into(), String::new()));
        assert_eq!(said("lambda_first_integral_n_m2"), ("λ, first integral".into(), "N/m²".into()));
        assert_eq!(said("drape_coefficient"), ("Drape coefficient".into(), String::new()));
    }

    #[test]
    fn file_names_hold_no_separators_and_stay_different() {
        assert_eq!(file_stem("3/a ü"), "3%2Fa%20ü");
        assert_ne!(file_stem("3/a"), file_stem("3-a"));
        assert_ne!(file_stem("3/a"), file_stem("3%2Fa"));
    }
}
