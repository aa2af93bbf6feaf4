//! The result of `hemline regress` for a person.

use super::document::{Adequacy, Document, WANTED_POWER};
use crate::statistics::factorial::Axis;

/// Coefficients first, then the answers to the questions in the order of the procedure, notes last.
pub(super) fn text_of(document: &Document) -> String {
    let mut lines = vec![
        format!("{} on {} — {} runs, {} treatments", document.response, names(&document.factors), document.runs, document.treatments),
        String::new(),
    ];
    let width = document.terms.iter().map(|term| term.term.chars().count()).max().unwrap_or(4).max(9);
    let level = 100.0 * (1.0 - document.alpha);
    lines.push(format!("{:width$}  {:>13} {:>11} {:>9} {:>9}  {level}% interval", "term", "estimate", "se", "t", "p"));
    for term in document.terms.iter().chain(&document.curvature).chain(&document.blocks) {
        let interval = match (term.ci_low, term.ci_high) {
            (Some(low), Some(high)) => format!("{} … {}", short(Some(low)), short(Some(high))),
            _ => "–".into(),
        };
        let mark = if term.significant { " *" } else { "" };
        lines.push(format!(
            "{:width$}  {:>13} {:>11} {:>9} {:>9}  {interval}{mark}",
            term.term,
            short(term.estimate),
            short(term.se),
            term.t.map_or("–".into(), |t| format!("{t:.2}")),
            term.p.map_or("–".into(), probability),
        ));
    }
    lines.push(match document.error_variance {
        Some(_) => format!("* significant at {}; error on {} degrees of freedom", document.alpha, document.residual_df),
        None => "No error to test against; see the notes.".into(),
    });
    lines.push(String::new());
    let verdict = document.equal_variances.as_ref();
    lines.push(verdict.map_or("Do all treatments scatter alike? not testable".into(), |v| {
        let answer = if v.holds { "yes" } else { "no" };
        format!("Do all treatments scatter alike? {answer}: {} {:.4}, critical {:.4}", v.test, v.statistic, v.critical)
    }));
    lines.push(match (&document.adequacy, document.adequate) {
        (Adequacy { f: Some(f), critical: Some(critical), df: Some(df) }, Some(holds)) => format!(
            "Are the significant terms enough? {}: Fisher F {f:.4} on ({}, {}), critical {critical:.4}",
            if holds { "yes" } else { "no" },
            df.0,
            df.1
        ),
        _ => "Are the significant terms enough? not testable".into(),
    });
    if !document.reduced_natural.is_empty() {
        let parts: Vec<String> = document
            .reduced_natural
            .iter()
            .map(|part| {
                let number = format!("{:+.6e}", part.coefficient);
                if part.term == "1" { number } else { format!("{number}·{}", part.term.replace(':', "·")) }
            })
            .collect();
        lines.push(format!("Reduced model in natural units: {} = {}", document.response, parts.join(" ")));
    }
    further(document, &mut lines);
    if !document.notes.is_empty() {
        lines.push(String::new());
        lines.extend(document.notes.iter().map(|note| format!("Note: {note}")));
    }
    lines.push(String::new());
    lines.join("\n")
}

/// Residuals, transformation, power, permutation, path and next runs, as far as they exist.
fn further(document: &Document, lines: &mut Vec<String>) {
    let against = |p: f64| if p < document.alpha { "no" } else { "yes" };
    if let Some(diagnostics) = &document.diagnostics {
        if let Some(test) = diagnostics.normality {
            lines.push(format!("Are the residuals normal? {}: Shapiro–Wilk W {:.4}, p {}", against(test.p), test.w, probability(test.p)));
        }
        if let (Some(d), Some(p)) = (diagnostics.durbin_watson, diagnostics.durbin_watson_p) {
            lines.push(format!("Are they independent in run order? {}: Durbin–Watson {d:.3}, p {}", against(p), probability(p)));
        }
        for suspect in &diagnostics.suspects {
            let cook = suspect.cook_distance.map_or(String::new(), |cook| format!(", Cook's distance {cook:.2}"));
            lines.push(format!(
                "The run of row {} is not expected by the others: deleted residual {:.1}, p {}{cook}",
                document.rows[suspect.run],
                suspect.deleted_residual,
                probability(suspect.p)
            ));
        }
    }
    if let Some(terms) = &document.without_suspects {
        let list: Vec<String> = terms.iter().map(|c| format!("{} {} ± {}", c.term, short(c.estimate), short(c.se))).collect();
        lines.push(format!("Without these: {}", list.join("; ")));
    }
    if let Some(found) = &document.box_cox {
        let end = |end: Option<f64>| end.map_or("beyond ±5".into(), |end| format!("{end:.2}"));
        let advice = if found.allows_none() { "no transformation needed" } else { "consider this power of the response" };
        lines.push(format!("Box–Cox λ {:.2} ({} … {}): {advice}", found.lambda, end(found.low), end(found.high)));
    }
    if let Some(smallest) = document.smallest_coefficient {
        lines.push(format!("Smallest coefficient found with a chance of {}%: {}", 100.0 * WANTED_POWER, short(Some(smallest))));
    }
    if let Some(needed) = &document.replicates_needed {
        let chance = 100.0 * WANTED_POWER;
        lines.push(format!(
            "An effect of {} needs {} runs of each treatment to be found with a chance of {chance}%",
            needed.effect, needed.replicates
        ));
    }
    for test in document.permutation.iter().flatten() {
        let how = test.p_standard_error.map_or("all arrangements".into(), |se| format!("± {se:.4}, drawn at random"));
        lines.push(format!("Permutation p of {}: {} ({how})", test.term, probability(test.p)));
    }
    if let Some(rows) = &document.sums_of_squares {
        lines.push(format!("{:>27}  df  sum of squares            F          p", "source"));
        lines.extend(rows.iter().map(|row| {
            let (f, p) = (row.f.map_or("–".into(), |f| format!("{f:.3}")), row.p.map_or("–".into(), probability));
            format!("{:>27} {:>3} {:>15} {f:>12} {p:>10}", row.source, row.df, short(Some(row.sum_of_squares)))
        }));
    }
    if let Some(known) = &document.known_errors {
        lines.push(format!("Weighted by the responses' own errors; scatter between runs beyond them: {}", short(Some(known.between_runs))));
        lines.extend(
            known
                .coefficients
                .iter()
                .map(|c| format!("  {}  {} ± {}  p {}", c.term, short(Some(c.estimate)), short(Some(c.se)), probability(c.p))),
        );
    }
    if let Some(path) = &document.path {
        lines.push(String::new());
        lines.push(format!("Path from the centre, {} steps to the edge of the explored region:", path.leaves_after));
        for step in &path.steps {
            let place: Vec<String> = step.natural.iter().map(|x| short(Some(*x))).collect();
            let interval =
                step.prediction.map_or(String::new(), |(low, high)| format!("  a run: {} … {}", short(Some(low)), short(Some(high))));
            let edge = if step.explored { "" } else { "  (extrapolated)" };
            lines.push(format!("  {:2}  ({})  {}{interval}{edge}", step.number, place.join(", "), short(Some(step.predicted))));
        }
        lines.extend(path.notes.iter().map(|note| format!("  {note}")));
    }
    for suggestion in document.next_runs.iter().flatten() {
        lines.push(format!("Next: {}", suggestion.reason));
        let rows: Vec<String> = suggestion
            .natural
            .iter()
            .map(|row| format!("({})", row.iter().map(|x| short(Some(*x))).collect::<Vec<_>>().join(", ")))
            .collect();
        lines.push(format!("  {}", rows.join(" ")));
    }
}

fn names(factors: &[Axis]) -> String {
    factors.iter().map(|factor| factor.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// Six significant digits.
fn short(value: Option<f64>) -> String {
    match value {
        None => "–".into(),
        Some(0.0) => "0".into(),
        Some(value) => {
            let decimals = 5 - value.abs().log10().floor() as i32;
            if (0..=9).contains(&decimals) { format!("{value:.*}", decimals as usize) } else { format!("{value:.5e}") }
        }
    }
}

fn probability(p: f64) -> String {
    if p < 1e-4 { format!("{p:.1e}") } else { format!("{p:.4}") }
}
