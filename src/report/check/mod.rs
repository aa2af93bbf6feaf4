//! The judgements of `hemline check` for readers and machines: a table, JSON, JUnit XML, annotations on GitHub.

pub mod annotations;
pub mod baseline;
pub mod json;
pub mod junit;
pub mod text;

#[cfg(test)]
mod tests;

use super::number::{fixed, plain, significant};
use crate::study::check::{Judgement, Measure, Status, Subject};
use crate::units::MILLIMETRE;

/// What a judgement is about, in words.
pub fn subject(subject: &Subject) -> String {
    match subject {
        Subject::Campaign => "campaign".into(),
        Subject::Run(id) => format!("run {id}"),
        Subject::Input(place) => place.clone(),
        Subject::Response(column) => column.clone(),
        Subject::Coefficient { response, term } => format!("{response}, term {term}"),
        Subject::Estimate { run, quantity } => format!("run {run}, {quantity}"),
    }
}

/// What was found, against which limit; for an expected failure with the reason.
pub fn finding(judgement: &Judgement) -> String {
    let mut parts = Vec::new();
    match &judgement.measure {
        None => (),
        Some(Measure::Test { test, statistic, p, alpha }) => {
            let (p_text, alpha_text) =
                (if *p < 1e-4 { "< 0.0001".to_string() } else { format!("= {}", significant(*p, 2)) }, plain(*alpha));
            let side = if alpha <= p { "not below" } else { "below" };
            parts.push(format!("{test} = {}, p {p_text}, {side} {alpha_text}", significant(*statistic, 3)));
        }
        Some(Measure::Length { off, limit }) => {
            parts.push(format!("{} mm off, limit {} mm", fixed(off / MILLIMETRE, 1), plain(limit / MILLIMETRE)));
        }
        Some(Measure::Folds { off, limit }) => {
            let many = if *off < 0 { "too few" } else { "too many" };
            let folds = off.unsigned_abs();
            parts.push(format!("{folds} fold{} {many}, limit {limit}", if folds == 1 { "" } else { "s" }));
        }
        Some(Measure::Drift { baseline, estimate, standard_error, moved, limit }) => parts.push(match (standard_error, moved) {
            (Some(error), Some(moved)) => {
                let (before, now) = (super::number::to_error(*baseline, Some(*error)), super::number::to_error(*estimate, Some(*error)));
                format!(
                    "{before} → {now}, {} standard errors of {}, limit {}",
                    significant(moved.abs(), 2),
                    significant(*error, 2),
                    plain(*limit)
                )
            }
            _ => format!("{} → {}, without a standard error to allow it", significant(*baseline, 6), significant(*estimate, 6)),
        }),
    }
    if !judgement.remark.is_empty() {
        parts.push(judgement.remark.clone());
    }
    match &judgement.status {
        Status::Expected { reason } => parts.push(format!("expected: {reason}")),
        Status::Stale { reason } => {
            parts.push(format!(
                "campaign.toml expects it to fail ({reason}), but it does not: take that entry out, it would hide the next failure"
            ));
        }
        _ => (),
    }
    parts.join("; ")
}

/// The name of a status in results.
pub fn status(status: &Status) -> &'static str {
    match status {
        Status::Holds => "holds",
        Status::Fails => "fails",
        Status::Expected { .. } => "expected",
        Status::Stale { .. } => "stale",
        Status::Unanswered => "unanswered",
        Status::NotAsked => "not_asked",
    }
}
