//! What goes beyond the tests: residuals and transformation, what the design could see, permutations, where to go next, theory effect by effect.

use serde_json::{Value, json};

use super::regression::term;
use crate::experiment::Factor;
use crate::report::number::{fixed, plain, probability, signed, significant, to_error, with_error};
use crate::report::words;
use crate::statistics::box_wilson::Analysis;
use crate::statistics::effects::{Agreement, EffectComparison};
use crate::statistics::steepest_ascent::{Goal, Path};
use crate::study::campaign::{CampaignStudy, Regression};
use crate::study::further::{Detectable, Further};

/// Regressions with an analysis and what goes beyond it.
fn looked_at(study: &CampaignStudy) -> impl Iterator<Item = (&Regression, &Analysis, &Further)> {
    study.regressions.iter().filter_map(|r| Some((r, r.analysis.as_ref().ok()?, r.further.as_ref().ok()?)))
}

/// The chapter after the regressions; `null` where there are none.
pub fn chapter(study: &CampaignStudy) -> Value {
    if looked_at(study).next().is_none() {
        return Value::Null;
    }
    let factors = &study.campaign.design.factors;
    json!({
        "residuals": looked_at(study).map(|(r, _, f)| residuals(r, f, study)).collect::<Vec<_>>(),
        "power": looked_at(study).filter_map(|(r, _, f)| power(r, &f.detectable)).collect::<Vec<_>>(),
        "counts": looked_at(study).filter(|(r, ..)| r.response == "m").flat_map(|(_, a, f)| permutations(a, f)).collect::<Vec<_>>(),
        "step": step_words(),
        "ways": looked_at(study).filter_map(|(r, _, f)| way(r, f, factors)).collect::<Vec<_>>(),
        "next": next(study),
        "wishes": wishes(study),
    })
}

/// “Fold depth, mm”.
fn name(regression: &Regression) -> String {
    let said = words::response(&regression.response);
    if said.unit.is_empty() { said.label } else { format!("{}, {}", said.label, said.unit) }
}

fn residuals(regression: &Regression, further: &Further, study: &CampaignStudy) -> Value {
    let d = &further.diagnostics;
    let test = |statistic: Option<f64>, p: Option<f64>| {
        statistic.zip(p).map_or_else(String::new, |(s, p)| format!("{}, p {}", fixed(s, 3), equals(&probability(p))))
    };
    let power = further.box_cox.map_or_else(String::new, |found| {
        let end = |end: Option<f64>| end.map_or_else(|| "…".to_string(), |e| fixed(e, 1));
        let advice = if found.allows_none() { "as it is" } else { "transform" };
        format!("{} ({} to {}): {advice}", fixed(found.lambda, 1), end(found.low), end(found.high))
    });
    let suspects: Vec<&str> = d.suspects.iter().filter_map(|s| Some(study.runs.get(s.run)?.run.id.as_str())).collect();
    json!([
        name(regression),
        test(d.normality.as_ref().map(|n| n.w), d.normality.as_ref().map(|n| n.p)),
        test(d.durbin_watson, d.durbin_watson_p),
        power,
        if suspects.is_empty() { "none".to_string() } else { suspects.join(", ") },
    ])
}

/// “= 0.02”, but “< 0.0001”.
fn equals(p: &str) -> String {
    if p.starts_with('<') { p.to_string() } else { format!("= {p}") }
}

/// The smallest effect found as the runs were done, and with other numbers of replicates.
fn power(regression: &Regression, detectable: &[Detectable]) -> Option<Value> {
    let at = |n: usize| detectable.iter().find(|d| d.replicates == n).map_or_else(String::new, |d| significant(d.smallest_effect, 2));
    let done = detectable.iter().find(|d| d.done);
    let shown = done.map_or_else(String::new, |d| format!("{} (n = {})", significant(d.smallest_effect, 2), d.replicates));
    (!detectable.is_empty()).then(|| json!([name(regression), shown, at(2), at(3), at(4), at(5), at(6), at(8), at(10)]))
}

fn permutations(analysis: &Analysis, further: &Further) -> Vec<Value> {
    let row = |c: &crate::statistics::box_wilson::Coefficient| {
        let test = further.permutation.iter().find(|test| test.term == c.term)?;
        let p = |p: Option<f64>| p.map(probability).unwrap_or_default();
        let permuted =
            test.p_standard_error.map_or_else(|| probability(test.p), |e| format!("{} ± {}", fixed(test.p, 4), significant(e, 1)));
        Some(json!([term(&c.term), with_error(c.estimate, c.se), p(c.p), permuted, p(c.p_holm), p(c.p_benjamini_hochberg)]))
    };
    analysis.coefficients.iter().filter_map(row).collect()
}

/// The way up: what one step changes, where it leaves the explored region, and the response predicted there.
fn way(regression: &Regression, further: &Further, factors: &[Factor]) -> Option<Value> {
    let up = further.ways.iter().find(|way| way.goal == Goal::Increase)?;
    let path: &Path = match &up.path {
        Ok(path) => path,
        Err(why) => return Some(json!([name(regression), format!("None: {why}."), "", "", ""])),
    };
    let moves: Vec<String> = factors
        .iter()
        .zip(&path.natural_change)
        .filter(|(_, change)| **change != 0.0)
        .map(|(factor, change)| {
            let unit = factor.unit.as_deref().map(|u| format!(" {u}")).unwrap_or_default();
            let sign = if *change < 0.0 { "−" } else { "+" };
            format!("{} {sign}{}{unit}", factor.name, significant(change.abs(), 2))
        })
        .collect();
    let edge = path.steps.iter().rev().find(|step| step.explored)?;
    let half = |interval: Option<(f64, f64)>| interval.map(|(low, high)| 0.5 * (high - low));
    let place: Vec<String> = edge.natural.iter().map(|x| significant(*x, 3)).collect();
    let centre = path.steps.first()?;
    Some(json!([
        name(regression),
        moves.join(", "),
        to_error(centre.predicted, half(centre.ci)),
        place.join(", "),
        with_error(edge.predicted, half(edge.ci)),
    ]))
}

/// Suggestions of further runs, each with the responses that ask for it, the most asked for first.
fn next(study: &CampaignStudy) -> Vec<String> {
    let mut found: Vec<(&str, usize, Vec<String>)> = vec![];
    for (regression, _, further) in looked_at(study) {
        let label = words::response(&regression.response).label;
        for suggestion in &further.next_runs {
            match found.iter_mut().find(|(reason, ..)| *reason == suggestion.reason) {
                Some((_, _, labels)) => labels.push(label.clone()),
                None => found.push((&suggestion.reason, suggestion.natural.len(), vec![label.clone()])),
            }
        }
    }
    found.sort_by_key(|(.., labels)| std::cmp::Reverse(labels.len()));
    let all = looked_at(study).count();
    let one = |(reason, runs, labels): (&str, usize, Vec<String>)| {
        let of = if labels.len() == all && 1 < all { "all responses".to_string() } else { labels.join(", ") };
        format!("{reason} ({of}; {runs} run{}.)", if runs == 1 { "" } else { "s" })
    };
    found.into_iter().map(one).collect()
}

/// The setting that meets the campaign's wishes best; empty where it has none.
fn wishes(study: &CampaignStudy) -> Vec<String> {
    match &study.desirable {
        None => vec![],
        Some(Err(why)) => vec![format!("No setting meets the wishes: {why}.")],
        Some(Ok(best)) => {
            let factors = study.campaign.design.factors.iter().zip(&best.natural);
            let place: Vec<String> = factors
                .map(|(factor, x)| {
                    let unit = factor.unit.as_deref().map(|u| format!(" {u}")).unwrap_or_default();
                    format!("{} {}{unit}", factor.label, significant(*x, 3))
                })
                .collect();
            let met: Vec<String> = best
                .met
                .iter()
                .map(|met| {
                    let said = words::response(&met.response);
                    let unit = if said.unit.is_empty() { String::new() } else { format!(" {}", said.unit) };
                    format!("{} {}{unit} (desirability {})", said.label, significant(met.predicted, 3), fixed(met.desirability, 2))
                })
                .collect();
            vec![format!(
                "The wishes of the campaign are met best (desirability {}, 1 is perfect) at {}: {}.",
                fixed(best.desirability, 2),
                place.join(", "),
                met.join(", ")
            )]
        }
    }
}

/// Theory effect by effect: rows for all terms that are measured or predicted beyond chance, and a sentence that counts them.
pub fn theory(study: &CampaignStudy) -> Value {
    let compared: Vec<(&Regression, &[EffectComparison])> =
        looked_at(study).filter_map(|(r, _, f)| Some((r, f.theory.as_deref().ok()?))).collect();
    let effects = || compared.iter().flat_map(|(_, terms)| terms.iter()).filter(|c| c.term != "1");
    let count = |wanted: Agreement| effects().filter(|c| c.agreement == wanted).count();
    let measured = effects().filter(|c| c.measured.significant).count();
    if compared.is_empty() {
        return Value::Null;
    }
    let sentence = format!(
        "Of {measured} effects that were measured beyond chance, theory has {} in sign and size, {} with the right sign but another size, and {} with the \
         wrong sign; it has {} where none was measured. The rows “mean” compare the responses in the middle of the design.",
        count(Agreement::Agrees),
        count(Agreement::WrongSize),
        count(Agreement::WrongSign),
        count(Agreement::NotMeasured)
    );
    let rows: Vec<Value> = compared
        .iter()
        .flat_map(|(r, terms)| {
            terms.iter().filter(|c| shown(c)).enumerate().map(|(i, c)| effect(if i == 0 { name(r) } else { String::new() }, c))
        })
        .collect();
    json!({ "words": sentence, "rows": rows })
}

fn shown(c: &EffectComparison) -> bool {
    !matches!(c.agreement, Agreement::BothAbsent)
}

fn effect(response: String, c: &EffectComparison) -> Value {
    let verdict = match c.agreement {
        Agreement::Agrees => "agrees",
        Agreement::WrongSize => "another size",
        Agreement::WrongSign => "wrong sign",
        Agreement::NotMeasured => "not measured",
        Agreement::BothAbsent => "none, as measured",
        Agreement::Undecided => "no error to judge with",
    };
    let difference = match c.difference.se {
        Some(se) => with_error(c.difference.estimate, Some(se)),
        None => signed(c.difference.estimate, 3),
    };
    json!([
        response,
        term(&c.term),
        with_error(c.measured.estimate, c.measured.se),
        to_error(c.predicted, c.measured.se),
        difference,
        c.difference.p.map(probability).unwrap_or_default(),
        verdict,
    ])
}

/// The explored steps are shorter than intervals of variation; said under the table of ways.
fn step_words() -> String {
    format!(
        "One step is {} of the interval of variation of the factor that moves most.",
        plain(crate::statistics::steepest_ascent::Options::default().step)
    )
}
