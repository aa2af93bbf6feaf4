//! One response: coefficients, tests and effects in the order of their size; and what goes beyond the tests.

use serde_json::{Value, json};

use super::table::{Column, of_texts};
use crate::report::document::regression as document;
use crate::report::gallery::Gallery;
use crate::report::number::{fixed, plain, probability, significant, to_error, with_error};
use crate::report::words;
use crate::statistics::box_wilson::Coefficient;
use crate::statistics::effects::pareto;
use crate::study::campaign::{CampaignStudy, Regression};

/// Rows of texts out of a chapter of the document.
pub fn texts(rows: &Value) -> Vec<Vec<String>> {
    let text = |cell: &Value| cell.as_str().map_or_else(|| cell.to_string(), String::from);
    rows.as_array().into_iter().flatten().map(|row| row.as_array().into_iter().flatten().map(text).collect()).collect()
}

/// The columns of the verdicts on the summary page.
pub fn verdict_columns() -> [Column; 6] {
    [
        Column::text("Response"),
        Column::number("Mean", ""),
        Column::words("Significant effects, strongest first"),
        Column::text("Replicates scatter alike?"),
        Column::text("Reduced model adequate?"),
        Column::number("R²", ""),
    ]
}

/// Everything shown of one response.
pub fn page(regression: &Regression, study: &CampaignStudy) -> Value {
    let said = words::response(&regression.response);
    let name = if said.unit.is_empty() { said.label.clone() } else { format!("{}, {}", said.label, said.unit) };
    let analysis = match &regression.analysis {
        Ok(analysis) => analysis,
        Err(reason) => return json!({ "name": name, "failure": format!("No regression: {}.", reason.trim_end_matches('.')) }),
    };
    // The sentences of the printed report; its figures are not asked for.
    let printed = document::page(regression, study, &Gallery::new());
    let coded = if said.unit.is_empty() { String::new() } else { format!(", {}", said.unit) };
    let (bars, line) = pareto(analysis);
    let tested = analysis.t_critical.is_some();
    let unit = if said.unit.is_empty() { String::new() } else { format!(" {}", said.unit) };
    let bar = |bar: &crate::statistics::effects::ParetoBar| {
        let c = analysis.coefficients.iter().find(|c| c.term == bar.term);
        json!({
            "term": document::term(&bar.term),
            "size": significant_number(bar.height),
            "significant": if tested { c.is_some_and(|c| c.significant) } else { line.is_some_and(|line| line < bar.height) },
            "about": c.map(|c| about(c, &unit)),
        })
    };
    json!({
        "name": name,
        "failure": Value::Null,
        "words": printed["words"],
        "coefficients": of_texts(&coefficient_columns(&said.unit), analysis.coefficients.iter().map(|c| coefficient(c, study.campaign.alpha))),
        "caption": format!(
            "Coefficients in coded units{coded}. n = {}, {} degrees of freedom. {}",
            analysis.used_runs.len(),
            analysis.residual_df,
            printed["quality"].as_str().unwrap_or_default()
        ),
        "verdicts": of_texts(&test_columns(), texts(&printed["verdicts"])),
        "equation": printed["equation"],
        "notes": printed["notes"],
        "bars": bars.iter().map(bar).collect::<Vec<_>>(),
        "bars_title": if tested { "Standardized effects (filled: significant)" } else { "Sizes of the coefficients (filled: beyond Lenth’s margin)" },
        "bars_axis": if tested { "|t| = |coefficient| / standard error".to_string() } else { format!("|coefficient|{coded}") },
        "line": line.map(significant_number),
        "line_words": line.map(|line| match tested {
            true => format!("t = {} at α = {}", fixed(line, 2), plain(study.campaign.alpha)),
            false => format!("Lenth’s margin {}", significant(line, 3)),
        }),
    })
}

/// Four digits are more than a bar shows.
fn significant_number(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// Lines on one coefficient.
fn about(c: &Coefficient, unit: &str) -> Vec<String> {
    let effect = with_error(c.effect(), c.se.map(|e| 2.0 * e));
    let effect = if effect.contains('±') && !unit.is_empty() && !effect.starts_with('(') { format!("({effect})") } else { effect };
    let mut said = vec![document::term(&c.term), format!("effect {effect}{unit}")];
    if let (Some(t), Some(p)) = (c.t, c.p) {
        said.push(format!("t {}, p {}", fixed(t, 2), probability(p)));
    }
    if let Some(p) = c.p_holm {
        said.push(format!("p (Holm) {}", probability(p)));
    }
    said
}

fn coefficient_columns(unit: &str) -> [Column; 9] {
    [
        Column::text("Term"),
        Column::number("Coefficient", unit),
        Column::number("Std. error", unit),
        Column::number("t", ""),
        Column::number("p", ""),
        Column::number("95 % from", unit),
        Column::number("95 % to", unit),
        Column::number("p (Holm)", ""),
        Column::text("Significant"),
    ]
}

fn coefficient(c: &Coefficient, alpha: f64) -> Vec<String> {
    let optional = |value: Option<f64>, text: &dyn Fn(f64) -> String| value.map(text).unwrap_or_default();
    let verdict = match (c.significant, c.p_holm) {
        (true, Some(p)) if alpha < p => "yes, not after Holm",
        (true, _) => "yes",
        (false, _) => "no",
    };
    vec![
        document::term(&c.term),
        to_error(c.estimate, c.se),
        optional(c.se, &|e| significant(e, 2)),
        optional(c.t, &|t| fixed(t, 2)),
        optional(c.p, &probability),
        optional(c.ci_low, &|v| to_error(v, c.se)),
        optional(c.ci_high, &|v| to_error(v, c.se)),
        optional(c.p_holm, &probability),
        verdict.into(),
    ]
}

fn test_columns() -> [Column; 5] {
    [
        Column::text("Test"),
        Column::number("Statistic", ""),
        Column::number("Critical", ""),
        Column::number("p", ""),
        Column::words("Verdict"),
    ]
}

/// The parts below the responses; none where nothing was analysed.
pub fn beyond(chapter: &Value, study: &CampaignStudy) -> Vec<Value> {
    if chapter.is_null() {
        return vec![];
    }
    let alpha = plain(study.campaign.alpha);
    let (text, number) = (|name: &str| Column::text(name), |name: &str| Column::number(name, ""));
    let residuals = [
        text("Response"),
        text("Normal? Shapiro–Wilk W"),
        text("Unrelated in run order? Durbin–Watson d"),
        text("Power that suits a linear model (Box–Cox)"),
        Column::words("Runs that stand apart"),
    ];
    let counts = ["Coefficient", "p of t", "p by permutation", "p (Holm)", "p (Benjamini–Hochberg)"];
    let counts: Vec<Column> = std::iter::once(text("Term")).chain(counts.map(number)).collect();
    let power = ["As done", "n = 2", "3", "4", "5", "6", "8", "10"];
    let power: Vec<Column> = std::iter::once(text("Response")).chain(power.map(number)).collect();
    let ways = [
        text("Response"),
        Column::words("One step up"),
        number("At the centre"),
        text("Edge of what was explored"),
        number("Predicted there"),
    ];
    let part = |title: &str, columns: &[Column], rows: &Value, caption: String| {
        let rows = texts(rows);
        (!rows.is_empty()).then(|| json!({ "title": title, "table": of_texts(columns, rows), "caption": caption }))
    };
    let sentences: Vec<&Value> = ["wishes", "next"].iter().filter_map(|key| chapter[key].as_array()).flatten().collect();
    [
        part(
            "Residuals",
            &residuals,
            &chapter["residuals"],
            format!(
                "Residuals of the full models. A small p speaks against the assumption; the tests of the coefficients are then approximate. A power of 1 \
                 leaves the response as it is, 0 takes its logarithm. A run stands apart if its deleted residual is too large for chance at α = {alpha}, \
                 Bonferroni over all runs."
            ),
        ),
        part(
            "The fold count, by permutation",
            &counts,
            &chapter["counts"],
            "The fold count is a small integer, so its scatter is not normal: how often would a random arrangement of the runs show as large an effect? ± is \
             the error of the random draw."
                .into(),
        ),
        part(
            "What this design could see",
            &power,
            &chapter["power"],
            format!(
                "The smallest effect (change of the response from low to high, in its unit) that n runs of each corner find with a chance of 90 % at α = \
                 {alpha}. To find a given effect, take the first n whose number is below it."
            ),
        ),
        part(
            "Where to go next",
            &ways,
            &chapter["ways"],
            format!(
                "Steepest ascent along the significant main effects. {} Edge: the last step within the levels of the experiment (factors in their order); ± half \
                 the 95 % interval.",
                chapter["step"].as_str().unwrap_or_default()
            ),
        ),
        (!sentences.is_empty()).then(|| json!({ "title": "", "items": sentences })),
    ]
    .into_iter()
    .flatten()
    .collect()
}
