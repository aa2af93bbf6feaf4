//! Tables: the cloth identified from every hem, beside what is known of it.

use serde_json::{Value, json};

use super::csv::Table;
use crate::study::identify::{Agreement, Identification, Identified};
use crate::units::{MICRONEWTON_METRE, MILLIMETRE};

/// `identify.csv`: one line per run and energy.
pub fn runs<'a>(rows: impl IntoIterator<Item = &'a Identified>) -> Table {
    let columns = [
        "run",
        "through",
        "known_rigidity_un_m",
        "rigidity_un_m",
        "rigidity_se_un_m",
        "rigidity_low_un_m",
        "rigidity_high_un_m",
        "estimated_over_known",
        "lambda_n",
        "lambda_se_n",
        "m",
        "harmonics",
        "chi_square",
        "degrees_of_freedom",
        "inflation",
        "misfit_mm",
        "gravity_lengths",
        "evaluations",
        "missing",
    ];
    let mut table = Table::new(&columns);
    for row in rows {
        let found = row.found.as_ref().ok();
        let rigidity = |pick: &dyn Fn(&Identification) -> Option<f64>| found.and_then(pick).map(|v| v / MICRONEWTON_METRE);
        table.push(vec![
            row.run.as_str().into(),
            row.through.name().into(),
            row.known.map(|v| v / MICRONEWTON_METRE).into(),
            rigidity(&|f| Some(f.rigidity.value)).into(),
            rigidity(&|f| f.rigidity.standard_error).into(),
            rigidity(&|f| Some(f.interval[0])).into(),
            rigidity(&|f| Some(f.interval[1])).into(),
            found.zip(row.known).map(|(f, known)| f.rigidity.value / known).into(),
            found.map(|f| f.lambda.value).into(),
            found.and_then(|f| f.lambda.standard_error).into(),
            found.map(|f| f.folds).into(),
            found.map(|f| f.harmonics).into(),
            found.map(|f| f.chi_square).into(),
            found.map(|f| f.degrees_of_freedom).into(),
            found.map(|f| f.inflation).into(),
            found.map(|f| f.misfit / MILLIMETRE).into(),
            found.map(|f| f.gravity_lengths).into(),
            found.map(|f| f.evaluations).into(),
            row.found.as_ref().err().map(String::as_str).into(),
        ]);
    }
    table
}

/// The same as JSON, SI units; null where a quantity does not exist.
pub fn to_json(rows: &[Identified], agreement: &[Agreement]) -> Value {
    let row = |row: &Identified| {
        json!({
            "run": row.run,
            "through": row.through,
            "known_rigidity_n_m": row.known,
            "found": row.found.as_ref().ok(),
            "missing": row.found.as_ref().err(),
        })
    };
    json!({ "profiles": rows.iter().map(row).collect::<Vec<_>>(), "against_known": agreement })
}
