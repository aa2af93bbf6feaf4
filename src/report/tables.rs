//! Every table of a report, defined once: its name, what it is for, and its rows; written as CSV, Parquet and sheets of one workbook.

use super::csv::{Cell, Table};
use super::{analysis_table, fidelities, identify, irregular, table, words};
use crate::study::campaign::CampaignStudy;

/// One table.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// Name of its file without the ending, and of its sheet.
    pub stem: &'static str,
    /// One line: what a row is.
    pub about: &'static str,
    pub table: Table,
}

/// All tables of a campaign, in the order of the report.
pub fn all(study: &CampaignStudy) -> Vec<Named> {
    let rows = || study.runs.iter().map(Into::into);
    let (regressions, factors) = (study.regressions.as_slice(), study.campaign.design.factors.as_slice());
    let ids: Vec<&str> = study.runs.iter().map(|run| run.run.id.as_str()).collect();
    let factor_names: Vec<&str> = factors.iter().map(|f| f.name.as_str()).collect();
    let uneven = || study.runs.iter().filter_map(|run| Some((run.run.id.as_str(), run.irregular.as_ref()?)));
    let named = |stem, about, table| Named { stem, about, table };
    vec![
        named("fits", "A row for each run: the fitted curve, λ, how well, the prediction", table::fits(rows())),
        named("regression", "A row for each response and term, coded units", analysis_table::regression(regressions)),
        named("weighted", "The same, each run weighed by the standard error of its fit", analysis_table::weighted(regressions)),
        named("diagnostics", "A row for each response: verdicts and residuals", analysis_table::diagnostics(regressions, &ids)),
        named("power", "The smallest effect that so many replicates would find", analysis_table::power(regressions)),
        named("ascent", "Steps of steepest ascent and descent", analysis_table::ascent(regressions, factors)),
        named("next_runs", "Runs that would teach most next", analysis_table::next_runs(regressions, factors)),
        named("desirability", "The setting that meets all wishes best", analysis_table::desirability(study)),
        named("theory_effects", "The same regression on measured and predicted responses", analysis_table::theory_effects(regressions)),
        named("candidates", "Every fold count that was tried for every run", table::candidates(rows())),
        named("predictions", "Every branch of the theory for every run", table::predictions(&study.runs)),
        named("fidelities", "Every theory against every run", fidelities::runs(&study.fidelities)),
        named(
            "fidelity_summary",
            "Every theory against all runs and every cell",
            fidelities::summary(&crate::study::fidelities::summarize(&study.fidelities), &factor_names),
        ),
        named("identify", "The cloth of every run, from its hem", identify::runs(&study.identified)),
        named("models", "Three curves through every outline", irregular::models(uneven())),
        named("folds", "Every fold of every outline", irregular::folds(uneven())),
        named("points", "Every point of every outline with its distance", table::points(rows())),
        named("quarantine", "What was set aside, where it stands, what would be right", table::quarantine(&study.quarantine)),
    ]
}

/// What a column holds, the same whatever rows there are where its name says it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Text,
    /// `true` or `false`.
    Flag,
    Whole,
    Number,
}

/// Columns of text that may be empty throughout.
const TEXTS: [&str; 32] = [
    "run",
    "through",
    "termination",
    "broken_rule",
    "notes",
    "lambda_missing",
    "prediction_missing",
    "predicted_fidelity",
    "standard_error_missing",
    "bias_correction",
    "interval_kind",
    "intervals_open",
    "response",
    "term",
    "goal",
    "reason",
    "agreement",
    "suspect_runs",
    "variances_test",
    "fidelity",
    "model",
    "missing",
    "lack_missing",
    "file",
    "sheet",
    "value",
    "problem",
    "remedy",
    "name",
    "profile",
    "block",
    "note",
];

/// Columns of `true` and `false` that may be empty throughout.
const FLAGS: [&str; 7] = ["overhangs", "points_scattered", "chosen", "at_fitted_m", "significant", "done", "explored"];

/// Columns of counts that may be empty throughout.
const WHOLES: [&str; 13] = [
    "n_points",
    "m",
    "evaluations",
    "predicted_m",
    "theory_minus_fit_m",
    "degrees_of_freedom",
    "bias_rounds",
    "replicates",
    "replicates_failed",
    "point",
    "fold",
    "row",
    "harmonics",
];

/// What the column at `index` of a table holds.
pub fn kind(table: &Table, index: usize) -> Kind {
    let name = table.columns[index].as_str();
    let cells = || table.rows.iter().map(|row| &row[index]).filter(|cell| **cell != Cell::Empty);
    let flag = |cell: &Cell| matches!(cell, Cell::Text(text) if text == "true" || text == "false");
    if cells().next().is_none() {
        return match name {
            _ if TEXTS.contains(&name) => Kind::Text,
            _ if FLAGS.contains(&name) => Kind::Flag,
            _ if WHOLES.contains(&name) => Kind::Whole,
            _ => Kind::Number,
        };
    }
    if cells().all(flag) && !TEXTS.contains(&name) {
        Kind::Flag
    } else if cells().all(|cell| matches!(cell, Cell::Integer(_))) {
        Kind::Whole
    } else if cells().all(|cell| matches!(cell, Cell::Integer(_) | Cell::Number(_))) {
        Kind::Number
    } else {
        Kind::Text
    }
}

/// “p_se, mm” of `p_se_mm`: what a person reads at the head of a column.
pub fn heading(column: &str) -> String {
    match words::column_unit(column) {
        (stem, Some(unit)) => format!("{stem}, {unit}"),
        (stem, None) => stem.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_of_a_known_name_holds_the_same_kind_with_and_without_rows() {
        let full = all(&crate::report::sample::study());
        for Named { stem, table, .. } in &full {
            let empty = Table { columns: table.columns.clone(), rows: vec![] };
            for (i, column) in table.columns.iter().enumerate() {
                let seen = kind(table, i);
                // A whole number may be the only kind of number in a column of numbers by chance.
                if table.rows.iter().any(|row| row[i] != Cell::Empty) && seen != Kind::Whole {
                    assert_eq!(kind(&empty, i), seen, "{stem}: {column}");
                }
            }
        }
    }

    #[test]
    fn headings_have_the_unit_apart_from_the_name() {
        assert_eq!(heading("p_se_mm"), "p_se, mm");
        assert_eq!(heading("lambda_ritz_n_m2"), "lambda_ritz, N/m²");
        assert_eq!(heading("predicted_m"), "predicted_m");
        assert_eq!(heading("run"), "run");
    }
}
