//! The summary page: what was measured, what was found, what to be careful with, in sentences.

use serde_json::{Value, json};

use super::regression::term;
use super::theory;
use crate::experiment::Apparatus;
use crate::fit::Termination;
use crate::report::note::SMALL_SHARE;
use crate::report::number::{fixed, to_error, with_error};
use crate::report::words;
use crate::statistics::box_wilson::{Analysis, Coefficient, Verdict};
use crate::study::campaign::{CampaignStudy, RunStudy};
use crate::study::overview::{Overview, overview, spread};
use crate::units::{MILLIMETRE, PERCENT};

/// The parts of the summary page.
pub fn summary(study: &CampaignStudy) -> Value {
    let seen = overview(&study.runs);
    json!({
        "judgements": judgements(study, &seen),
        "measured": measured(study, &seen),
        "found": found(study, &seen),
        "verdicts": study.regressions.iter().filter_map(|r| Some(verdict_row(&r.response, r.analysis.as_ref().ok()?))).collect::<Vec<_>>(),
        "theory": seen.theory.as_ref().map_or_else(|| theory::missing(study), theory::words),
        "cautions": cautions(study, &seen),
    })
}

/// Verdicts in words: a question, and its answer.
fn judgements(study: &CampaignStudy, seen: &Overview) -> Vec<[String; 2]> {
    let mut said = vec![];
    let mut judge = |question: &str, answer: String| said.push([question.to_string(), answer]);
    let whole = seen.fitted == seen.runs;
    judge("Were all hems fitted?", format!("{}, {} of {}", if whole { "yes" } else { "no" }, seen.fitted, seen.runs));
    if let Some(explained) = seen.explained {
        let how = match explained.median {
            share if 0.9 <= share => "well",
            share if SMALL_SHARE <= share => "roughly",
            _ => "badly",
        };
        let answer = format!("{how}: {} % of the departure from a circle (median)", fixed(explained.median / PERCENT, 0));
        judge("Does the curve of equal folds describe them?", answer);
    }
    let analyses: Vec<(String, &Analysis)> =
        study.regressions.iter().filter_map(|r| Some((words::response(&r.response).label, r.analysis.as_ref().ok()?))).collect();
    let influenced = analyses.iter().filter(|(_, a)| a.coefficients.iter().any(|c| c.significant && c.term != "1")).count();
    if !analyses.is_empty() {
        judge("Do the factors matter?", format!("for {influenced} of {} responses", analyses.len()));
    }
    let held = |question: &str, pick: fn(&Analysis) -> Option<&Verdict>| {
        let tested: Vec<(&str, bool)> = analyses.iter().filter_map(|(label, a)| Some((label.as_str(), pick(a)?.holds))).collect();
        let broken: Vec<&str> = tested.iter().filter(|(_, holds)| !holds).map(|(label, _)| *label).collect();
        (!tested.is_empty()).then(|| {
            let answer = match broken.as_slice() {
                [] => format!("yes, for all {} responses", tested.len()),
                some => format!("for {} of {} responses; not for {}", tested.len() - some.len(), tested.len(), some.join("; ")),
            };
            (question.to_string(), answer)
        })
    };
    let tests = [
        held("Do replicates scatter alike?", |a| a.equal_variances.as_ref()),
        held("Do the significant terms alone suffice?", |a| a.adequacy.as_ref()),
    ];
    for (question, answer) in tests.into_iter().flatten() {
        judge(&question, answer);
    }
    if let Some(theory) = &seen.theory {
        let answer = format!("in {} of {} runs, within one in {}", theory.folds_right, theory.runs, theory.folds_within_one);
        judge("Does theory predict the fold count?", answer);
    }
    said
}

fn measured(study: &CampaignStudy, seen: &Overview) -> Vec<String> {
    let what = match study.campaign.apparatus {
        Apparatus::Skirt => "hems of conic skirts hanging from a waist ring",
        Apparatus::Drapemeter => "hems of flat discs of cloth on a drape tester",
    };
    let factors: Vec<&str> = study.campaign.design.factors.iter().map(|f| f.label.as_str()).collect();
    let cells = crate::report::gallery::cells(&study.runs);
    let replicates: Vec<usize> = cells.iter().map(|(_, runs)| runs.len()).collect();
    let (fewest, most) = (replicates.iter().min().copied().unwrap_or(0), replicates.iter().max().copied().unwrap_or(0));
    let each = if fewest == most { fewest.to_string() } else { format!("{fewest} to {most}") };
    let points: Vec<f64> = study.runs.iter().filter_map(|r| r.profile.as_ref()).map(|p| p.points().len() as f64).collect();
    let mut said = vec![format!("{} {what}, {} of them usable.", seen.runs, seen.profiles)];
    if !factors.is_empty() {
        said.push(format!("Factors: {}; {} cells with {each} replicates each.", factors.join(", "), cells.len()));
    }
    if let Some(points) = spread(points) {
        let many =
            if points.low == points.high { fixed(points.low, 0) } else { format!("{} to {}", fixed(points.low, 0), fixed(points.high, 0)) };
        said.push(format!("Each hem as {many} points of its outline seen from above."));
    }
    said
}

fn found(study: &CampaignStudy, seen: &Overview) -> Vec<String> {
    let folds: Vec<String> = seen
        .folds
        .iter()
        .map(|(m, runs)| {
            let shape = if *m == 0 { "round".into() } else { format!("{m} folds") };
            format!("{shape} in {runs}")
        })
        .collect();
    let mut said = vec![];
    if !folds.is_empty() {
        said.push(format!("{} of {} hems were fitted: {}.", seen.fitted, seen.runs, folds.join(", ")));
    }
    if let (Some(rms), Some(explained)) = (seen.rms, seen.explained) {
        said.push(format!(
            "The fitted curve passes the points at {} mm rms (median; {} to {} mm) and explains {} % of their departure from a circle (median; {} to {} %).",
            fixed(rms.median / MILLIMETRE, 1),
            fixed(rms.low / MILLIMETRE, 1),
            fixed(rms.high / MILLIMETRE, 1),
            fixed(explained.median / PERCENT, 0),
            fixed(explained.low / PERCENT, 0),
            fixed(explained.high / PERCENT, 0),
        ));
    }
    let r2 = study.runs.iter().filter_map(|r| r.lambda.first_integral.or(r.lambda.over_weight)).map(|(_, r2)| r2);
    if let Some(r2) = spread(r2) {
        let verdict = if r2.median < 0.5 { "holds badly: λ is reported, but means little" } else { "holds at least roughly" };
        said.push(format!(
            "The relation behind λ (first integral) {verdict}: R² {} in the median ({} to {}).",
            fixed(r2.median, 2),
            fixed(r2.low, 2),
            fixed(r2.high, 2)
        ));
    }
    said
}

fn verdict_row(response: &str, analysis: &Analysis) -> Value {
    let said = words::response(response);
    let label = if said.unit.is_empty() { said.label } else { format!("{}, {}", said.label, said.unit) };
    let mean = analysis.coefficients.iter().find(|c| c.term == "1");
    let holds = |v: &Option<Verdict>, yes, no| v.as_ref().map_or("not tested", |v| if v.holds { yes } else { no });
    json!([
        label,
        mean.map(|c| with_error(c.estimate, c.se)).unwrap_or_default(),
        influences(analysis),
        holds(&analysis.equal_variances, "scatter alike", "scatter differently"),
        holds(&analysis.adequacy, "adequate", "not adequate"),
        analysis.full.r_squared().map(|r2| fixed(r2, 2)).unwrap_or_default(),
    ])
}

/// “conicity +34.8, rigidity −4.1, [density +1.2]”: effects, twice the coefficients, in the unit of the response.
fn influences(analysis: &Analysis) -> String {
    let mut found: Vec<&Coefficient> = analysis.coefficients.iter().filter(|c| c.significant && c.term != "1").collect();
    found.sort_by(|a, b| b.estimate.abs().total_cmp(&a.estimate.abs()));
    let name = |c: &&Coefficient| {
        let size = to_error(c.effect().abs(), c.se.map(|e| 2.0 * e));
        // No line break inside one influence.
        let text = format!("{} {}{size}", term(&c.term), if 0.0 < c.estimate { "+" } else { "−" }).replace(' ', "\u{a0}");
        if c.p_holm.is_some_and(|p| 0.05 < p) { format!("[{text}]") } else { text }
    };
    if found.is_empty() { "none".into() } else { found.iter().map(name).collect::<Vec<_>>().join(", ") }
}

fn cautions(study: &CampaignStudy, seen: &Overview) -> Vec<String> {
    let mut said = vec![];
    let list =
        |pick: &dyn Fn(&RunStudy) -> bool| -> Vec<&str> { study.runs.iter().filter(|r| pick(r)).map(|r| r.run.id.as_str()).collect() };
    let aside = list(&|r| r.fit.is_err());
    if !aside.is_empty() {
        said.push(format!("Without a fit: {}.", named(&aside)));
    }
    if !study.quarantine.is_empty() {
        let (n, verb) = match study.quarantine.len() {
            1 => ("One thing".to_string(), "was"),
            many => (format!("{many} things"), "were"),
        };
        said.push(format!("{n} in the input {verb} set aside; the chapter before the appendix says what and why."));
    }
    let irregular = list(&|r| r.fit.as_ref().is_ok_and(|f| f.folds.is_some() && f.explained < SMALL_SHARE));
    if !irregular.is_empty() {
        said.push(format!("Irregular folds, of which the curve explains less than half: {}.", named(&irregular)));
    }
    let in_order = list(&|r| r.fit.as_ref().is_ok_and(|f| matches!(f.termination, Termination::InOrder { .. })));
    if !in_order.is_empty() {
        said.push(format!(
            "Matched in order at the hem's length, because even at that length the orthogonal optimum was no sane curve; no standard errors: {}.",
            named(&in_order)
        ));
    }
    if 0 < seen.held {
        let held = list(&|r| r.fit.as_ref().is_ok_and(|f| f.held.is_some()));
        said.push(format!("Hem length held, because the free optimum was no sane curve or as asked: {}.", named(&held)));
    }
    said.extend(study.notes.iter().map(|note| crate::report::note::sentence(note)));
    said
}

/// More names than these nobody reads on a page that is to be one.
const MOST_NAMES: usize = 30;

/// “run 7” or “runs 3, 7, 12”.
fn named(runs: &[&str]) -> String {
    match runs {
        [one] => format!("run {one}"),
        many if many.len() <= MOST_NAMES => format!("runs {}", many.join(", ")),
        many => format!("runs {} and {} more", many[..MOST_NAMES].join(", "), many.len() - MOST_NAMES),
    }
}
