//! The chapter on cloth from its drape: identified rigidities beside known ones, bias and scatter in words.

use serde_json::{Value, json};

use crate::report::number::{fixed, significant};
use crate::study::campaign::CampaignStudy;
use crate::study::identify::{Agreement, Identified, Through, agreement};
use crate::units::{MICRONEWTON_METRE, MILLIMETRE};

/// What the numbers are, for the page; the template says the same.
pub const ABOUT: &str = "The other way round: weight and cut are known, the hem is measured, and the flexural rigidity is the one whose hem of as many folds, \
                         in equilibrium, has the measured coefficients of the tangent angle. Standard errors are those of the hem’s own scatter; what the theory \
                         neglects is in the factor to the known rigidity, not in them.";

/// `null` where no cloth was identified.
pub fn chapter(study: &CampaignStudy) -> Value {
    let rows = &study.identified;
    if rows.iter().all(|row| row.found.is_err()) {
        return Value::Null;
    }
    let table: Vec<Value> = study.runs.iter().filter_map(|run| line(&run.run.id, rows)).collect();
    json!({ "words": words(rows), "rows": table, "figure": rows.iter().any(|row| row.known.is_some() && row.found.is_ok()) })
}

/// One run through both energies.
fn line(run: &str, rows: &[Identified]) -> Option<Value> {
    let of = |through: Through| rows.iter().find(|row| row.run == run && row.through == through);
    let known = of(Through::Graded)?.known;
    let un = |value: f64| significant(value / MICRONEWTON_METRE, 3);
    let mut cells = vec![run.to_string(), known.map_or_else(|| "–".into(), un)];
    for through in Through::ALL {
        match of(through).map(|row| &row.found) {
            Some(Ok(found)) => cells.extend([
                un(found.rigidity.value),
                fixed(100.0 * found.relative_error, 0),
                known.map_or_else(|| "–".into(), |k| fixed(found.rigidity.value / k, 2)),
                fixed(found.misfit / MILLIMETRE, 1),
            ]),
            _ => cells.extend(["–"; 4].map(String::from)),
        }
    }
    Some(json!(cells))
}

/// Bias and scatter, and who was refused.
pub fn words(rows: &[Identified]) -> Vec<String> {
    let mut said: Vec<String> = agreement(rows).iter().map(compared).collect();
    let mut refused: Vec<String> = Vec::new();
    for row in rows {
        if let Err(reason) = &row.found {
            refused.push(format!("run {} ({}): {}", row.run, row.through.name(), reason.trim_end_matches('.')));
        }
    }
    if !refused.is_empty() {
        said.push(format!("Not identified: {}.", refused.join("; ")));
    }
    said
}

fn compared(a: &Agreement) -> String {
    let name = a.through.name();
    match (a.factor, a.scatter) {
        (Some(factor), Some(scatter)) => {
            let claimed =
                a.claimed.map_or_else(String::new, |c| format!("; their standard errors claim {} % (median)", fixed(100.0 * c, 0)));
            format!(
                "Through the {name} energy the rigidity comes out {} times the known one (geometric mean of {} of {} runs), with a scatter of a factor of {} about that{claimed}.",
                fixed(factor, 2),
                a.compared,
                a.runs,
                fixed(scatter, 2)
            )
        }
        _ => format!("Through the {name} energy {} of {} runs have a rigidity to compare.", a.compared, a.runs),
    }
}
