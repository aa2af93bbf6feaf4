//! One page for each response: coefficients, verdicts and figures, in words.

use serde_json::{Value, json};

use crate::experiment::Factor;
use crate::report::gallery::{Gallery, regression_stem};
use crate::report::number::{fixed, plain, probability, significant, to_error, with_error};
use crate::report::words::{self, Response};
use crate::statistics::box_wilson::{Analysis, Coefficient, ErrorSource, Verdict};
use crate::study::campaign::{CampaignStudy, Regression};

/// The page of one response.
pub fn page(regression: &Regression, study: &CampaignStudy, gallery: &Gallery) -> Value {
    let said = words::response(&regression.response);
    let stem = regression_stem(&regression.response);
    let figure = |kind: &str| Some(format!("{stem}_{kind}")).filter(|name| gallery.contains_key(name));
    let analysis = match &regression.analysis {
        Ok(analysis) => analysis,
        Err(reason) => return json!({ "label": said.label, "unit": said.unit, "failure": reason }),
    };
    let factors = &study.campaign.design.factors;
    let pareto = figure("pareto");
    json!({
        "label": said.label,
        "unit": said.unit,
        "failure": Value::Null,
        "n": analysis.used_runs.len().to_string(),
        "df": analysis.residual_df.to_string(),
        "quality": quality(analysis),
        "words": influences(analysis, factors, &said),
        "rows": analysis.coefficients.iter().map(row).collect::<Vec<_>>(),
        "equation": equation(&said, &analysis.reduced.natural),
        "verdicts": verdicts(analysis, study.campaign.alpha),
        "ranking-words": if pareto.is_some() { "standardized effects (filled: significant)" } else { "half-normal plot of the coefficients" },
        "ranking": pareto.or_else(|| figure("half_normal")),
        "main": figure("main_effects"),
        "interactions": figure("interactions"),
        "cube": figure("cube"),
        "residuals": figure("residuals"),
        "notes": analysis.notes.join(" "),
    })
}

/// “rigidity × conicity”; the constant is the mean of the coded model.
pub fn term(name: &str) -> String {
    if name == "1" { "mean".into() } else { name.replace(':', " × ") }
}

fn row(c: &Coefficient) -> Value {
    let optional = |value: Option<f64>, text: fn(f64) -> String| value.map(text).unwrap_or_default();
    let interval = c.ci_low.zip(c.ci_high).map(|(low, high)| format!("{} … {}", to_error(low, c.se), to_error(high, c.se)));
    json!([
        term(&c.term),
        to_error(c.estimate, c.se),
        optional(c.se, |e| significant(e, 2)),
        optional(c.t, |t| fixed(t, 2)),
        optional(c.p, probability),
        interval.unwrap_or_default(),
        optional(c.p_holm, probability),
        if c.significant { "yes" } else { "–" },
    ])
}

/// More sentences than these nobody reads, and the page would not hold the figures.
const MOST_SENTENCES: usize = 4;

/// What each significant term does, strongest first, in natural units.
fn influences(analysis: &Analysis, factors: &[Factor], said: &Response) -> Vec<String> {
    let mut found: Vec<&Coefficient> = analysis.coefficients.iter().filter(|c| c.significant && c.term != "1").collect();
    found.sort_by(|a, b| b.estimate.abs().total_cmp(&a.estimate.abs()));
    if found.is_empty() {
        return vec!["No factor changes this response beyond the scatter of the replicates.".into()];
    }
    let more = found.len().saturating_sub(MOST_SENTENCES);
    let mut sentences: Vec<String> = found.into_iter().take(MOST_SENTENCES).map(|c| influence(c, factors, said)).collect();
    match more {
        0 => (),
        1 => sentences.push("One more term is significant; the table has it.".into()),
        many => sentences.push(format!("{many} more terms are significant; the table has them.")),
    }
    sentences
}

fn influence(c: &Coefficient, factors: &[Factor], said: &Response) -> String {
    let names: Vec<&str> = c.term.split(':').collect();
    let label = |name: &str| factors.iter().find(|f| f.name == name).map_or_else(|| name.to_string(), |f| f.label.clone());
    let unit = if said.unit.is_empty() { String::new() } else { format!(" {}", said.unit) };
    let with_unit = |factor: f64| {
        let text = with_error(factor * c.estimate.abs(), c.se.map(|e| factor * e));
        if unit.is_empty() || !text.contains('±') || text.starts_with('(') { format!("{text}{unit}") } else { format!("({text}){unit}") }
    };
    let unsure = c.p_holm.is_some_and(|p| 0.05 < p);
    let doubt = if unsure { " (Not after Holm’s correction.)" } else { "" };
    let sentence = match names.as_slice() {
        [one] => {
            let Some(factor) = factors.iter().find(|f| f.name == *one) else { return format!("{}: {}.", c.term, with_unit(2.0)) };
            let direction = if 0.0 < c.estimate { "raises" } else { "lowers" };
            let natural = factor.unit.as_deref().map(|u| format!(" {u}")).unwrap_or_default();
            format!(
                "Going from {} to {}{natural} in {} {direction} it by {}.",
                plain(factor.low),
                plain(factor.high),
                factor.label,
                with_unit(2.0)
            )
        }
        [one, other] => {
            let more = if 0.0 < c.estimate { "larger" } else { "smaller" };
            format!(
                "Where {} is high, the change that {} makes is {more} by {} than where it is low.",
                label(other),
                label(one),
                with_unit(4.0)
            )
        }
        many => {
            format!("{} act together: {} in coded units.", many.iter().map(|n| label(n)).collect::<Vec<_>>().join(", "), with_unit(1.0))
        }
    };
    let mut capital = sentence.chars();
    let first = capital.next().map(|l| l.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}{doubt}", capital.as_str())
}

/// `y = b0 + b1·rigidity + …` with four significant digits.
fn equation(said: &Response, natural: &[(String, f64)]) -> String {
    let name = said.label.split(' ').next_back().filter(|w| w.chars().count() == 1).unwrap_or("y");
    let mut text = format!("{name} = ");
    if natural.is_empty() {
        text.push('0');
    }
    for (i, (term, b)) in natural.iter().enumerate() {
        let sign = match (i, *b < 0.0) {
            (0, true) => "−",
            (0, false) => "",
            (_, true) => " − ",
            (_, false) => " + ",
        };
        let factor = if term == "1" { String::new() } else { format!(" · {}", term.replace(':', " · ")) };
        text.push_str(&format!("{sign}{}{factor}", significant(b.abs(), 4)));
    }
    text
}

fn quality(analysis: &Analysis) -> String {
    let mut parts = vec![];
    if let Some(error) = &analysis.error {
        let source = match error.source {
            ErrorSource::PureError => "scatter of the replicates",
            ErrorSource::Residual => "residuals of the full model",
        };
        parts.push(format!("Standard deviation from the {source}: {}.", significant(error.variance.sqrt(), 3)));
    }
    let shares = [
        ("R²", analysis.full.r_squared()),
        ("adjusted", analysis.full.adjusted_r_squared()),
        ("predicted", analysis.full.predicted_r_squared()),
    ];
    let shares: Vec<String> = shares.iter().filter_map(|(name, r2)| r2.map(|r2| format!("{name} {}", fixed(r2, 2)))).collect();
    if !shares.is_empty() {
        parts.push(format!("{} of the full model.", shares.join(", ")));
    }
    parts.join(" ")
}

fn verdicts(analysis: &Analysis, alpha: f64) -> Vec<Value> {
    let mut rows = vec![];
    if let Some(v) = &analysis.equal_variances {
        let words = if v.holds {
            "Holds: replicates scatter alike in all cells."
        } else {
            "Rejected: some cells scatter more than others; t tests are approximate."
        };
        rows.push(verdict(v, words.into()));
    }
    if let Some(critical) = analysis.t_critical {
        let tested = analysis.coefficients.iter().filter(|c| c.term != "1").count();
        let found = analysis.coefficients.iter().filter(|c| c.term != "1" && c.significant).count();
        let words = format!("{found} of {tested} coefficients are significant at α = {}.", plain(alpha));
        rows.push(json!([format!("Student t ({} df)", analysis.residual_df), "", fixed(critical, 3), "", words]));
    }
    if let Some(v) = &analysis.adequacy {
        let words = if v.holds {
            "Holds: the significant terms alone meet the cell means."
        } else {
            "Rejected: the significant terms alone miss the cell means by more than the scatter."
        };
        rows.push(verdict(v, words.into()));
    }
    rows
}

fn verdict(v: &Verdict, words: String) -> Value {
    let df = format!("{}, {} df", plain(v.df.0), plain(v.df.1));
    json!([format!("{} ({df})", v.test), fixed(v.statistic, 3), fixed(v.critical, 3), v.p.map(probability).unwrap_or_default(), words])
}
