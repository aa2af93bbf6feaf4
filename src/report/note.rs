//! What a reader must know about one run beyond its numbers, in sentences: the same ones in the tables and in the document.

use crate::fit::{HemFit, Rule, Termination};
use crate::report::number::{fixed, significant};
use crate::study::campaign::RunStudy;
use crate::units::{MILLIMETRE, PERCENT};

/// Below this share of the explained departure from a circle the curve is no description of the hem.
pub const SMALL_SHARE: f64 = 0.5;
/// Above this share of points on the support disc's edge the outline is partly the disc's.
const NOTABLE_SUPPORT: f64 = 0.05;
/// Below this Akaike weight another fold count is a serious candidate.
const UNSURE_WEIGHT: f64 = 0.9;

/// The notes on one run, most important first; empty where there is nothing to say.
pub fn of(study: &RunStudy) -> Vec<String> {
    let mut notes = match &study.fit {
        Err(reason) => vec![format!("No fit: {}.", reason.trim_end_matches('.'))],
        Ok(fit) => of_fit(fit),
    };
    if let (Ok(fit), Some(prediction)) = (&study.fit, &study.prediction)
        && let Some(folds) = fit.folds
        && prediction.folds != folds
    {
        let predicted = if prediction.folds == 0 { "a round hem".into() } else { format!("{} folds", prediction.folds) };
        notes.push(format!("The theory predicts {predicted}, {folds} are fitted; the predicted hem drawn here has {folds}."));
    }
    if let (Ok(_), Some(reason)) = (&study.fit, &study.prediction_missing) {
        notes.push(format!("No prediction: {}.", reason.trim_end_matches('.')));
    }
    if let Some(share) = study.on_support.filter(|share| NOTABLE_SUPPORT < *share) {
        notes.push(format!(
            "{} % of the outline lies on the edge of the support disc: there the disc is seen, not the cloth, whose folds reach further in.",
            fixed(share / PERCENT, 0)
        ));
    }
    for prediction in [&study.prediction, &study.prediction_at_fitted_folds].into_iter().flatten() {
        for remark in prediction.notes.iter().map(|note| format!("Theory: {}", sentence(note))) {
            if !notes.contains(&remark) {
                notes.push(remark);
            }
        }
    }
    if study.profile.as_ref().is_some_and(|p| p.was_scattered()) {
        notes.push("The points came in no order; their order round the hem was reconstructed.".into());
    }
    notes
}

/// The notes on a fit alone.
pub fn of_fit(fit: &HemFit) -> Vec<String> {
    let mut notes = vec![];
    let length = |m: f64| fixed(m / MILLIMETRE, 0);
    match (&fit.termination, fit.held) {
        (Termination::HeldLength { broken }, Some(held)) => notes.push(format!(
            "Hem length held at {} mm, because the free optimum {}; the outline itself is {} mm long.",
            length(held.length),
            rule(*broken),
            length(fit.outline_length)
        )),
        (Termination::HeldLength { broken }, None) => notes.push(format!("Hem length held, because the free optimum {}.", rule(*broken))),
        (Termination::InOrder { broken }, held) => {
            let length = held.map(|h| format!(" ({} mm)", length(h.length))).unwrap_or_default();
            notes.push(format!(
                "Even at the held hem length{length} the best fit {}; shown is the curve matched to the outline in order, which is no least-squares optimum.",
                rule(*broken)
            ));
        }
        (Termination::NotPursued, _) => notes.push("This fold count was not pursued: its match is too far from the outline.".into()),
        (Termination::LengthAsAsked, Some(held)) => notes.push(format!("Hem length held at {} mm, as asked.", length(held.length))),
        (Termination::LengthAsAsked, None) => notes.push("Hem length held, as asked.".into()),
        (Termination::NoFolds, _) => notes.push("Round within its noise: there are no folds to count.".into()),
        (Termination::Stalled, _) => notes.push("The fit stopped making progress before its tolerance; use its numbers with care.".into()),
        (Termination::EvaluationLimit, _) => notes.push("The fit reached its evaluation limit; use its numbers with care.".into()),
        (Termination::Converged, _) => (),
    }
    if fit.folds.is_some() && fit.explained < SMALL_SHARE {
        notes.push(format!(
            "Irregular folds: the curve explains only {} % of the outline's departure from a circle.",
            fixed(fit.explained / PERCENT, 0)
        ));
    }
    if fit.folds.is_some() && fit.folds_weight < UNSURE_WEIGHT {
        notes.push(format!("The fold count is uncertain: weight of evidence {}{}.", fixed(fit.folds_weight, 2), rival(fit)));
    }
    if fit.hem.overhangs() {
        notes.push("The fitted hem overhangs: some rays from the centre meet it more than once.".into());
    }
    notes.extend(fit.notes.iter().map(|note| sentence(note)));
    notes
}

/// A remark of a computation as a sentence: capital first, full stop last.
pub fn sentence(remark: &str) -> String {
    let mut letters = remark.trim().trim_end_matches('.').chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

/// The next best fold count, where there is one.
fn rival(fit: &HemFit) -> String {
    let others = fit.candidates.iter().filter(|c| Some(c.folds) != fit.folds);
    let best = others.filter_map(|c| Some((c.weight?, c.folds))).max_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(weight, folds)| format!(", next is m = {folds} with {}", significant(weight, 2))).unwrap_or_default()
}

fn rule(rule: Rule) -> &'static str {
    match rule {
        Rule::Order => "does not meet the points in their order round the hem",
        Rule::Length => "is much longer or shorter than the outline",
        Rule::Simplicity => "crosses itself where the outline does not",
        Rule::Nearness => "strays from the outline between the points",
    }
}

/// How a fit ended, as tables name it.
pub fn termination(ended: &Termination) -> &'static str {
    match ended {
        Termination::Converged => "converged",
        Termination::HeldLength { .. } => "held_length",
        Termination::InOrder { .. } => "in_order",
        Termination::LengthAsAsked => "length_as_asked",
        Termination::NotPursued => "not_pursued",
        Termination::NoFolds => "no_folds",
        Termination::Stalled => "stalled",
        Termination::EvaluationLimit => "evaluation_limit",
    }
}

/// The name of a rule, as tables spell it.
pub fn rule_name(rule: Rule) -> &'static str {
    match rule {
        Rule::Order => "order",
        Rule::Length => "length",
        Rule::Simplicity => "simplicity",
        Rule::Nearness => "nearness",
    }
}
