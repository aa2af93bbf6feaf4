//! Names of columns: which quantity a header cell names, in which unit, as laboratories spell it.

use super::dialect::AngleUnit;
use crate::units;

/// What a column of a profile table may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    X,
    Y,
    Angle,
    Radius,
    Weight,
}

/// Names of the quantities in lower case; Cyrillic х and у look like Latin x and y.
const NAMES: [(Quantity, &[&str]); 5] = [
    (Quantity::X, &["x", "х"]),
    (Quantity::Y, &["y", "у"]),
    (Quantity::Angle, &["angle", "theta", "θ", "ϑ", "phi", "φ", "ϕ", "azimuth", "azimut", "winkel", "угол", "азимут"]),
    (Quantity::Radius, &["radius", "r", "rho", "ρ", "радиус", "rayon"]),
    (Quantity::Weight, &["weight", "weights", "w", "вес", "gewicht", "poids"]),
];

/// What laboratories call the column that says which profile a point belongs to; the first that is there counts.
pub(super) const PROFILE_COLUMNS: [&str; 14] =
    ["profile", "outline", "run", "specimen", "sample", "name", "id", "профиль", "опыт", "образец", "profil", "versuch", "probe", "muster"];

/// Which way angles grow, in words; the longer ones first, because they contain the shorter.
const DIRECTIONS: [(&str, &str); 10] = [
    ("counterclockwise", " ccw "),
    ("counter-clockwise", " ccw "),
    ("anticlockwise", " ccw "),
    ("anti-clockwise", " ccw "),
    ("против часовой стрелки", " ccw "),
    ("gegen den uhrzeigersinn", " ccw "),
    ("clockwise", " cw "),
    ("по часовой стрелке", " cw "),
    ("im uhrzeigersinn", " cw "),
    ("sens horaire", " cw "),
];

/// A header cell, understood.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Named {
    pub quantity: Quantity,
    /// As it is spelt; not known to be a unit.
    pub unit: Option<String>,
    /// Whether angles grow clockwise, where the cell says so.
    pub clockwise: Option<bool>,
}

/// What `x_cm`, `X [cm]`, `x, cm`, `x (cm)`, `x/cm`, `радиус, см`, `Winkel (°)`, `angle_cw_deg` name; `None` for anything else, also for a name
/// with more words in it, such as `max x cm`.
pub(super) fn named(cell: &str) -> Option<Named> {
    let mut text = lower(cell);
    for (words, short) in DIRECTIONS {
        text = text.replace(words, short);
    }
    let mut tokens = tokens(&text);
    let direction = |token: &&str| match *token {
        "cw" => Some(true),
        "ccw" => Some(false),
        _ => None,
    };
    let clockwise = tokens.iter().find_map(direction);
    tokens.retain(|token| direction(token).is_none());
    let quantity = |word: &str| NAMES.iter().find(|(_, names)| names.contains(&word)).map(|(quantity, _)| *quantity);
    let (first, unit) = match tokens[..] {
        [first] => (first, None),
        // `r_10` is the radius at 10, and `x_1` one of several x.
        [first, unit] if unit.parse::<f64>().is_err() => (first, Some(unit.to_owned())),
        _ => return None,
    };
    Some(Named { quantity: quantity(first)?, unit, clockwise })
}

fn lower(cell: &str) -> String {
    cell.to_lowercase().replace(['µ', 'μ'], "u").replace("''", "\"")
}

fn tokens(text: &str) -> Vec<&str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '"' || c == '°')).filter(|t| !t.is_empty()).collect()
}

/// The unit that a cell of a row of units holds: `mm`, `[cm]`, `(deg)`, `°`.
pub(super) fn bare_unit(cell: &str) -> Option<String> {
    let text = lower(cell);
    match tokens(&text)[..] {
        [unit] if length_unit(unit).is_some() || angle_unit(unit).is_some() => Some(unit.to_owned()),
        _ => None,
    }
}

/// Name and unit of a column that is named after its profile: `run 3 [cm]`, `run 3, cm`, `17_mm`, `17`.
pub(super) fn name_and_unit(cell: &str) -> (String, Option<String>) {
    let text = cell.trim().trim_end_matches([']', ')']);
    if let Some((name, unit)) = text.rsplit_once(['[', '(', ',', '_', '/'])
        && let Some(unit) = bare_unit(unit)
        && length_unit(&unit).is_some()
    {
        return (name.trim().to_owned(), Some(unit));
    }
    (cell.trim().to_owned(), None)
}

/// The angle that a column of radii is named after, with the units that stand beside it: `10`, `10°`, `10 deg`, `r_10`, `0,5 rad`, `r10_cm`.
pub(super) fn angle_of(cell: &str) -> Option<(f64, Option<String>, Option<String>)> {
    let text = lower(cell);
    let (name, length) = match name_and_unit(&text) {
        (name, Some(unit)) => (name, Some(unit)),
        (name, None) => (name, None),
    };
    let name = NAMES[3].1.iter().chain(NAMES[2].1).find_map(|word| name.strip_prefix(word)).unwrap_or(&name);
    let name = name.trim_matches(|c: char| !(c.is_alphanumeric() || c == '°' || c == '-' || c == '.'));
    let end = name.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | ',' | '-' | '+'))).unwrap_or(name.len());
    let value: f64 = name[..end].trim_end_matches(',').replace(',', ".").parse().ok().filter(|v: &f64| v.is_finite())?;
    let unit = name[end..].trim_matches(|c: char| !(c.is_alphanumeric() || c == '°'));
    match unit {
        "" => Some((value, None, length)),
        unit if angle_unit(unit).is_some() => Some((value, Some(unit.to_owned()), length)),
        unit if length.is_none() && length_unit(unit).is_some() => Some((value, None, Some(unit.to_owned()))),
        _ => None,
    }
}

/// Metres per unit of length as people spell it.
pub(super) fn length_unit(unit: &str) -> Option<f64> {
    let suffix = match unit {
        "inch" | "inches" | "\"" | "zoll" | "дюйм" => "in",
        "meter" | "metre" | "meters" | "metres" | "м" => "m",
        "мм" => "mm",
        "см" => "cm",
        "мкм" => "um",
        known @ ("um" | "mm" | "cm" | "m" | "in") => known,
        _ => return None,
    };
    units::factor(suffix)
}

/// Unit of angle as people spell it; `grad` is none, because it is a degree to some and 1/400 of a turn to others.
pub(super) fn angle_unit(unit: &str) -> Option<AngleUnit> {
    match unit {
        "deg" | "degree" | "degrees" | "°" | "град" | "градус" | "градусы" => Some(AngleUnit::Degree),
        "rad" | "radian" | "radians" | "radiant" | "рад" | "радиан" | "радианы" => Some(AngleUnit::Radian),
        "gon" | "gradian" | "gradians" | "гон" => Some(AngleUnit::Gon),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_of(cell: &str, quantity: Quantity) -> Option<Option<String>> {
        named(cell).filter(|n| n.quantity == quantity).map(|n| n.unit)
    }

    #[test]
    fn spellings_of_a_column_and_its_unit_are_understood() {
        for name in ["x_cm", "X_CM", "x [cm]", "x, cm", "x (cm)", "x/cm", "x cm", "x.cm"] {
            assert_eq!(unit_of(name, Quantity::X), Some(Some("cm".into())), "{name}");
        }
        assert_eq!(unit_of("x", Quantity::X), Some(None));
        for name in ["xx_cm", "z_cm", "max x cm", "y_cm", "run"] {
            assert_eq!(unit_of(name, Quantity::X), None, "{name}");
        }
        assert_eq!(unit_of("x, µm", Quantity::X).flatten().as_deref().and_then(length_unit), Some(1e-6));
        assert_eq!(unit_of("радиус, см", Quantity::Radius).flatten().as_deref().and_then(length_unit), Some(0.01));
        assert_eq!(unit_of("х, мм", Quantity::X).flatten().as_deref().and_then(length_unit), Some(0.001));
        for name in ["Winkel (°)", "угол, град", "theta_deg", "φ [deg]", "angle/degrees"] {
            assert_eq!(unit_of(name, Quantity::Angle).flatten().as_deref().and_then(angle_unit), Some(AngleUnit::Degree), "{name}");
        }
        assert_eq!(unit_of("Winkel [Grad]", Quantity::Angle).flatten().as_deref().and_then(angle_unit), None);
    }

    #[test]
    fn the_direction_of_angles_is_read_from_their_column() {
        for (name, clockwise) in [
            ("angle_cw_deg", Some(true)),
            ("angle, clockwise, deg", Some(true)),
            ("угол по часовой стрелке, град", Some(true)),
            ("Winkel gegen den Uhrzeigersinn [deg]", Some(false)),
            ("counter-clockwise angle (rad)", Some(false)),
            ("angle_deg", None),
        ] {
            let named = named(name).unwrap_or_else(|| panic!("{name}"));
            assert_eq!((named.quantity, named.clockwise), (Quantity::Angle, clockwise), "{name}");
            assert!(named.unit.is_some());
        }
    }

    #[test]
    fn columns_named_after_an_angle_give_it_with_its_units() {
        let some = |value, angle: Option<&str>, length: Option<&str>| Some((value, angle.map(String::from), length.map(String::from)));
        assert_eq!(angle_of("10"), some(10.0, None, None));
        assert_eq!(angle_of("10°"), some(10.0, Some("°"), None));
        assert_eq!(angle_of("10 deg"), some(10.0, Some("deg"), None));
        assert_eq!(angle_of("r_10"), some(10.0, None, None));
        assert_eq!(angle_of("r10_cm"), some(10.0, None, Some("cm")));
        assert_eq!(angle_of("10°, cm"), some(10.0, Some("°"), Some("cm")));
        assert_eq!(angle_of("0,5 rad"), some(0.5, Some("rad"), None));
        assert_eq!(angle_of("-12.5"), some(-12.5, None, None));
        for name in ["run", "x_cm", "2026-01-02", "10 apples", ""] {
            assert_eq!(angle_of(name), None, "{name}");
        }
    }

    #[test]
    fn columns_named_after_a_profile_keep_its_name() {
        assert_eq!(name_and_unit("run 3 [cm]"), ("run 3".into(), Some("cm".into())));
        assert_eq!(name_and_unit("17_mm"), ("17".into(), Some("mm".into())));
        assert_eq!(name_and_unit("run_3"), ("run_3".into(), None));
        assert_eq!(name_and_unit("опыт 3, см"), ("опыт 3".into(), Some("см".into())));
    }
}
