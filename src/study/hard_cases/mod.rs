//! Hard cases of fit, theory and statistics, each at growing severity: one catalogue for `hemline study stability` and for the tests.
//!
//! An answer is *right* if it keeps the digits that are promised of it; *warned* if it does not, or may not, and says so; *none* if the question was
//! refused with a reason; and *wrong* if it is not right and nothing was said. Wrong must not happen.

pub mod fit;
pub mod statistics;
pub mod theory;

use serde::Serialize;

/// How a case ended at one severity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    Right,
    /// It was refused, with a reason.
    NoAnswer,
    /// An answer with what a reader should know of it: a note, a tie, a missing standard error, an ending short of convergence.
    Warned,
    /// Wrong without saying.
    Wrong,
}

/// What the program made of a case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    pub outcome: Outcome,
    /// Decimal digits that agree with the reference, 0 … 16; `None` without an answer or a reference.
    pub digits: Option<f64>,
    /// Digits that are promised, where some are.
    pub promised: Option<f64>,
    /// Of the problem: how many times errors of the data may be enlarged.
    pub condition: Option<f64>,
    pub evaluations: Option<usize>,
    /// What the program said, or what is wrong with its answer.
    pub said: String,
}

impl Answer {
    pub(super) fn refused(reason: impl ToString) -> Self {
        let said = reason.to_string();
        Answer { outcome: Outcome::NoAnswer, digits: None, promised: None, condition: None, evaluations: None, said }
    }

    /// Right if enough digits are kept, else warned if something was `said`, else wrong.
    pub(super) fn judged(digits: f64, promised: f64, said: Option<String>) -> Self {
        let outcome = match (promised <= digits, &said) {
            (true, _) => Outcome::Right,
            (false, Some(_)) => Outcome::Warned,
            (false, None) => Outcome::Wrong,
        };
        let said = match outcome {
            Outcome::Wrong => format!("{digits:.1} digits where {promised:.1} are promised"),
            _ => said.unwrap_or_default(),
        };
        Answer { outcome, digits: Some(digits), promised: Some(promised), condition: None, evaluations: None, said }
    }
}

/// Decimal digits in common, from the relative error: at most 16, at least 0.
pub fn digits(relative_error: f64) -> f64 {
    if relative_error.is_nan() { 0.0 } else { (-relative_error.abs().max(1e-16).log10()).clamp(0.0, 16.0) + 0.0 }
}

/// What a case is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Subject {
    Fit,
    Theory,
    Statistics,
}

/// How many severities every case has.
pub const SEVERITIES: usize = 8;

/// One way to make things hard.
#[derive(Clone, Copy)]
pub struct Case {
    pub subject: Subject,
    /// `far_centre` …
    pub name: &'static str,
    /// What grows: `centre away, radii`.
    pub title: &'static str,
    /// What digits are counted against.
    pub reference: &'static str,
    /// From easy to beyond breakdown.
    pub severities: [f64; SEVERITIES],
    /// The answer at a severity; the seed counts where something is drawn.
    pub run: fn(f64, u64) -> Answer,
}

/// Every case: fit, theory, statistics.
pub fn catalogue() -> Vec<Case> {
    let mut all = fit::cases();
    all.extend(theory::cases());
    all.extend(statistics::cases());
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_short_of_its_promise_is_wrong_unless_something_was_said() {
        let outcome = |kept: f64, said: Option<&str>| Answer::judged(kept, 8.0, said.map(String::from)).outcome;
        assert_eq!(
            (outcome(9.0, None), outcome(7.0, Some("rough")), outcome(7.0, None)),
            (Outcome::Right, Outcome::Warned, Outcome::Wrong)
        );
        assert_eq!((digits(1e-3), digits(0.0), digits(7.0), digits(f64::NAN)), (3.0, 16.0, 0.0, 0.0));
    }

    #[test]
    fn cases_have_names_of_their_own() {
        let mut names: Vec<&str> = catalogue().iter().map(|case| case.name).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
