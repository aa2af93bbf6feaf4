//! Which tables the page holds besides those of its chapters: the result files, what was set aside, what was read and asked.

use serde_json::{Value, json};

use super::table::{Column, of_results, of_texts};
use crate::report::csv::Table;
use crate::report::{Provenance, analysis_table, fidelities, identify, irregular, table};
use crate::study::campaign::CampaignStudy;
use crate::study::fidelities::summarize;

/// Columns of fits.csv that the page shows; the file has more.
const FITS: [&str; 43] = [
    "run",
    "n_points",
    "termination",
    "broken_rule",
    "m",
    "m_weight",
    "p_mm",
    "p_se_mm",
    "q_mm",
    "q_se_mm",
    "s_mm",
    "s_se_mm",
    "x0_mm",
    "y0_mm",
    "phase_rad",
    "phase_se_rad",
    "rms_mm",
    "perimeter_mm",
    "outline_length_mm",
    "held_length_mm",
    "area_mm2",
    "mean_radius_mm",
    "fold_depth_mm",
    "explained_share",
    "overhangs",
    "drape_coefficient_percent",
    "lambda_first_integral_n_m2",
    "lambda_first_integral_se_n_m2",
    "lambda_first_integral_r2",
    "lambda_ritz_n_m2",
    "lambda_ritz_angle_deg",
    "lambda_ruled_n",
    "lambda_over_weight",
    "lambda_over_weight_r2",
    "p_low_mm",
    "p_high_mm",
    "q_low_mm",
    "q_high_mm",
    "s_low_mm",
    "s_high_mm",
    "standard_error_missing",
    "predicted_m",
    "theory_gap_mm",
];

/// The tables with many rows for each run.
const LONG: [&str; 4] = ["candidates", "models", "folds", "predictions"];

/// All tables that have rows, the long ones only if asked for: (id, title, about, table).
pub fn all(study: &CampaignStudy, provenance: &Provenance, long: bool) -> Vec<Value> {
    let rows = || study.runs.iter().map(Into::into);
    let (regressions, factors) = (study.regressions.as_slice(), study.campaign.design.factors.as_slice());
    let ids: Vec<&str> = study.runs.iter().map(|run| run.run.id.as_str()).collect();
    let names: Vec<&str> = factors.iter().map(|f| f.name.as_str()).collect();
    let uneven = || study.runs.iter().filter_map(|run| Some((run.run.id.as_str(), run.irregular.as_ref()?)));
    let results: [(&str, &str, &str, Table); 17] = [
        (
            "quarantine",
            "Set aside",
            "Nothing is dropped silently: what could not be used, where it stands, and what would be right.",
            table::quarantine(&study.quarantine),
        ),
        ("fits", "Fits", "One row for each run; fits.csv has more columns.", only(table::fits(rows()), &FITS)),
        ("candidates", "Fold counts tried", "Every fold count tried for every run; 0 is the circle.", table::candidates(rows())),
        (
            "models",
            "Curves compared",
            "The paper’s curve, equal folds of any shape and a free outline through every outline, with the test of lack of fit.",
            irregular::models(uneven()),
        ),
        ("folds", "Fold by fold", "Every fold of every outline.", irregular::folds(uneven())),
        ("predictions", "Branches of the theory", "Every branch of the theory for every run.", table::predictions(&study.runs)),
        ("regression", "Regression", "Coefficients in coded units, in the unit of the response.", analysis_table::regression(regressions)),
        (
            "weighted",
            "Regression, runs weighed",
            "Each run weighed by the standard error that its fit gives the response.",
            analysis_table::weighted(regressions),
        ),
        ("diagnostics", "Verdicts and residuals", "One row for each response.", analysis_table::diagnostics(regressions, &ids)),
        ("power", "Power", "The smallest effect that so many replicates find with a chance of 90 %.", analysis_table::power(regressions)),
        (
            "ascent",
            "Steepest ascent and descent",
            "Factors in natural units, the response predicted at each step.",
            analysis_table::ascent(regressions, factors),
        ),
        ("next_runs", "Runs that would teach most next", "", analysis_table::next_runs(regressions, factors)),
        ("desirability", "Wishes met best", "", analysis_table::desirability(study)),
        ("theory_effects", "Effects, theory and measurement", "", analysis_table::theory_effects(regressions)),
        ("fidelities", "Theories against every run", "", fidelities::runs(&study.fidelities)),
        (
            "identify",
            "Cloth from its drape",
            "The flexural rigidity B that each hem tells through each energy, beside the known one.",
            identify::runs(&study.identified),
        ),
        (
            "fidelity_summary",
            "Theories per cell",
            "Factors in coded units; empty: all runs.",
            fidelities::summary(&summarize(&study.fidelities), &names),
        ),
    ];
    let entry = |id: &str, title: &str, about: &str, table: Value| json!({ "id": id, "title": title, "about": about, "table": table });
    let mut tables: Vec<Value> = results
        .iter()
        .filter(|(id, ..)| long || !LONG.contains(id))
        // Without a theory the summary has lines, but nothing in them.
        .filter(|(id, .., table)| !table.rows.is_empty() && (*id != "fidelity_summary" || !study.fidelities.is_empty()))
        .map(|(id, title, about, table)| entry(id, title, about, of_results(table)))
        .collect();
    if !study.sources.is_empty() {
        let columns = [Column::text("File"), Column::number("Bytes", ""), Column::text("Digest (FNV-1a, 64 bit)")];
        let rows = study.sources.iter().map(|s| vec![s.file.display().to_string(), s.bytes.to_string(), s.digest.clone()]);
        tables.push(entry("inputs", "Inputs", "Every file that was read.", of_texts(&columns, rows)));
    }
    if !provenance.settings.is_empty() {
        let columns = [Column::text("Option"), Column::words("Value")];
        let rows = provenance.settings.iter().map(|(name, value)| vec![name.clone(), value.clone()]);
        tables.push(entry("settings", "Options", "", of_texts(&columns, rows)));
    }
    tables
}

/// The columns named, in their order.
fn only(table: Table, columns: &[&str]) -> Table {
    let places: Vec<usize> =
        columns.iter().map(|name| table.columns.iter().position(|c| c == name).unwrap_or_else(|| panic!("no column {name}"))).collect();
    let mut kept = Table::new(columns);
    for row in &table.rows {
        kept.push(places.iter().map(|&i| row[i].clone()).collect());
    }
    kept
}
