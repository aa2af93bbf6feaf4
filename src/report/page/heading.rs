//! What a column of a result table is called on the page: `p_se_mm` → “p, std. error”, “mm”.

/// A head of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Heading {
    pub name: String,
    /// Empty for text and pure numbers.
    pub unit: &'static str,
    pub kind: Kind,
}

/// What its cells are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Plain,
    Millimetres,
    Probability,
    /// Words of the files, joined by underscores.
    Code,
    /// The column of a response.
    Response,
    /// A term of a linear model.
    Term,
}

/// The head of the column `column`.
pub fn of(column: &str) -> Heading {
    let (stem, unit) = if WITHOUT_UNIT.contains(&column) {
        (column, "")
    } else {
        UNITS.iter().find_map(|(suffix, unit)| Some((column.strip_suffix(suffix)?, *unit))).unwrap_or((column, ""))
    };
    let kind = match column {
        "response" => Kind::Response,
        "term" => Kind::Term,
        _ if CODES.contains(&column) => Kind::Code,
        _ if stem == "p" && unit.is_empty()
            || stem.ends_with("_p")
            || stem.starts_with("p_holm")
            || stem.starts_with("p_benj")
            || stem == "lack_p_correlated" =>
        {
            Kind::Probability
        }
        _ if unit == "mm" => Kind::Millimetres,
        _ => Kind::Plain,
    };
    let (stem, error) = match stem.strip_suffix("_se") {
        Some(estimate) => (estimate, true),
        None => (stem, false),
    };
    let known = NAMES.iter().find(|(name, _)| *name == stem).map(|(_, said)| said.to_string());
    let name = known.unwrap_or_else(|| spelled(stem));
    Heading { name: if error { format!("{name}, std. error") } else { name }, unit, kind }
}

fn spelled(stem: &str) -> String {
    let words = stem.replace('_', " ");
    let mut letters = words.chars();
    // A single letter is a symbol and stays small.
    if stem.chars().count() < 3 {
        return words;
    }
    letters.next().map(|c| c.to_uppercase().collect::<String>() + letters.as_str()).unwrap_or_default()
}

/// Longest first where one ends with another.
const UNITS: [(&str, &str); 11] = [
    ("_un_m", "µN·m"),
    ("_sum_of_squares_mm2", "mm²"),
    ("_n_m2", "N/m²"),
    ("_mm2", "mm²"),
    ("_mm", "mm"),
    ("_percent", "%"),
    ("_deg", "°"),
    ("_rad", "rad"),
    ("_n", "N"),
    ("_j", "J"),
    ("_share", "share"),
];

/// Whose end only looks like a unit.
const WITHOUT_UNIT: [&str; 3] = ["explained_share", "width_share", "place_share"];

const CODES: [&str; 9] = [
    "termination",
    "broken_rule",
    "model",
    "agreement",
    "interval_kind",
    "bias_correction",
    "standard_error_missing",
    "intervals_open",
    "goal",
];

const NAMES: [(&str, &str); 74] = [
    ("n_points", "Points"),
    ("termination", "Ended"),
    ("m_weight", "Weight of m"),
    ("x0", "x₀"),
    ("y0", "y₀"),
    ("phase", "Phase φ"),
    ("rms", "Misfit rms"),
    ("fold_depth", "Fold depth"),
    ("explained_share", "Explained share"),
    ("mean_radius", "Radius of equal area"),
    ("drape_coefficient", "Drape coefficient"),
    ("outline_length", "Outline length"),
    ("held_length", "Held hem length"),
    ("lambda_first_integral", "λ, first integral"),
    ("lambda_first_integral_r2", "R² of it"),
    ("lambda_ritz", "λ, Ritz"),
    ("lambda_ritz_angle", "Angle of it"),
    ("lambda_ruled", "λ, ruled shell"),
    ("lambda_ruled_angle", "Angle of it"),
    ("lambda_over_weight", "λ/(ρg), first integral"),
    ("lambda_over_weight_r2", "R² of it"),
    ("lambda_over_weight_ritz", "λ/(ρg), Ritz"),
    ("lambda_over_weight_ritz_angle", "Angle of it"),
    ("lambda_missing", "Why there is no λ"),
    ("broken_rule", "Rule broken"),
    ("predicted_m", "m predicted"),
    ("fitted_m", "m fitted"),
    ("m_asked", "m asked"),
    ("at_fitted_m", "At the fitted m"),
    ("predicted_energy", "Energy"),
    ("predicted_fidelity", "Fidelity"),
    ("prediction_missing", "Why there is no prediction"),
    ("theory_gap", "Theory, rms distance"),
    ("theory_minus_fit_fold_depth", "Fold depth, theory − fit"),
    ("theory_minus_fit_mean_radius", "Mean radius, theory − fit"),
    ("theory_minus_fit_m", "m, theory − fit"),
    ("depth_difference", "Fold depth, theory − fit"),
    ("mean_radius_difference", "Mean radius, theory − fit"),
    ("depth_ratio", "Fold depth, theory / fit"),
    ("fold_count_exact", "m exact"),
    ("fold_count_within_one", "m within one"),
    ("standard_error_missing", "Without a standard error"),
    ("p_low", "p from"),
    ("p_high", "p to"),
    ("q_low", "q from"),
    ("q_high", "q to"),
    ("s_low", "s from"),
    ("s_high", "s to"),
    ("se", "Std. error"),
    ("ci_low", "95 % from"),
    ("ci_high", "95 % to"),
    ("p_holm", "p (Holm)"),
    ("p_benjamini_hochberg", "p (Benjamini–Hochberg)"),
    ("p_permutation", "p by permutation"),
    ("between_runs_sd", "Std. deviation between runs"),
    ("q_p", "p of Q"),
    ("aicc", "AICc"),
    ("delta_aicc", "ΔAICc"),
    ("lack_f", "Lack of fit F"),
    ("lack_p", "Lack of fit p"),
    ("lack_p_correlated", "p, errors correlated"),
    ("single_run_low", "Single run from"),
    ("single_run_high", "Single run to"),
    ("smallest_effect", "Smallest effect found"),
    ("suspect_runs", "Runs that stand apart"),
    ("crest_radius", "Crest radius"),
    ("through", "Energy through which"),
    ("known_rigidity", "B known"),
    ("rigidity", "B from the hem"),
    ("rigidity_low", "B, 95 % from"),
    ("rigidity_high", "B, 95 % to"),
    ("estimated_over_known", "B over known"),
    ("chi_square", "χ²"),
    ("lambda", "λ"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_said_with_their_units() {
        let said = |column: &str| {
            let h = of(column);
            (h.name, h.unit, h.kind)
        };
        assert_eq!(said("p_se_mm"), ("p, std. error".into(), "mm", Kind::Millimetres));
        assert_eq!(said("lambda_first_integral_n_m2"), ("λ, first integral".into(), "N/m²", Kind::Plain));
        assert_eq!(said("predicted_m"), ("m predicted".into(), "", Kind::Plain));
        assert_eq!(said("p_holm"), ("p (Holm)".into(), "", Kind::Probability));
        assert_eq!(said("p"), ("p".into(), "", Kind::Probability));
        assert_eq!(said("p_mm"), ("p".into(), "mm", Kind::Millimetres));
        assert_eq!(said("bend_radius_mm").0, "Bend radius");
        assert_eq!(said("explained_share").1, "");
    }

    #[test]
    fn no_column_is_named_twice() {
        for (i, (name, _)) in NAMES.iter().enumerate() {
            assert!(NAMES[..i].iter().all(|(other, _)| other != name), "{name}");
        }
    }
}
