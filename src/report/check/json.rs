//! The judgements for scripts.
//!
//! - `schema`: "hemline-check-1"
//! - `conclusion`: "holds", "fails" or "unanswered"; `exit_code`: 0, 1, 2
//! - `campaign`: its title; `error`: why nothing could be checked, otherwise null
//! - `counts`: judgements by status
//! - `judgements` [{`question`, `subject` {one or two of `run`, `input`, `response`, `term`, `quantity`}, `status` "holds" | "fails" | "expected" |
//!   "stale" | "unanswered" | "not_asked", `finding`: in words, `reason`: of an expected failure, and the numbers: `test`, `statistic`, `p`, `alpha`;
//!   `off_mm`, `limit_mm`; `off`, `limit`; `baseline`, `estimate`, `se`, `moved_se`, `limit_se`}]

use serde_json::{Map, Value, json};

use super::{finding, status};
use crate::study::check::{Conclusion, Judgement, Measure, Status, Subject, conclusion};
use crate::units::MILLIMETRE;

/// The exit code of a conclusion.
pub fn exit_code(conclusion: Conclusion) -> u8 {
    match conclusion {
        Conclusion::Holds => 0,
        Conclusion::Fails => 1,
        Conclusion::Unanswered => 2,
    }
}

/// The whole result.
pub fn json(campaign: &str, judgements: &[Judgement]) -> Value {
    let concluded = conclusion(judgements);
    let mut counts = Map::new();
    for name in ["holds", "fails", "expected", "stale", "unanswered", "not_asked"] {
        counts.insert(name.into(), judgements.iter().filter(|j| status(&j.status) == name).count().into());
    }
    let word = match concluded {
        Conclusion::Holds => "holds",
        Conclusion::Fails => "fails",
        Conclusion::Unanswered => "unanswered",
    };
    json!({
        "schema": "hemline-check-1",
        "conclusion": word,
        "exit_code": exit_code(concluded),
        "campaign": campaign,
        "error": null,
        "counts": counts,
        "judgements": judgements.iter().map(one).collect::<Vec<_>>(),
    })
}

/// The result where there was nothing to judge, because the campaign could not be read.
pub fn failure(why: &str) -> Value {
    json!({
        "schema": "hemline-check-1",
        "conclusion": "unanswered",
        "exit_code": exit_code(Conclusion::Unanswered),
        "campaign": null,
        "error": why,
        "counts": {},
        "judgements": [],
    })
}

fn one(judgement: &Judgement) -> Value {
    let subject = match &judgement.subject {
        Subject::Campaign => json!({}),
        Subject::Run(run) => json!({ "run": run }),
        Subject::Input(input) => json!({ "input": input }),
        Subject::Response(response) => json!({ "response": response }),
        Subject::Coefficient { response, term } => json!({ "response": response, "term": term }),
        Subject::Estimate { run, quantity } => json!({ "run": run, "quantity": quantity }),
    };
    let mut object = Map::new();
    object.insert("question".into(), judgement.question.name().into());
    object.insert("subject".into(), subject);
    object.insert("status".into(), status(&judgement.status).into());
    object.insert("finding".into(), finding(judgement).into());
    if let Status::Expected { reason } | Status::Stale { reason } = &judgement.status {
        object.insert("reason".into(), reason.as_str().into());
    }
    let numbers = match &judgement.measure {
        None => json!({}),
        Some(Measure::Test { test, statistic, p, alpha }) => json!({ "test": test, "statistic": statistic, "p": p, "alpha": alpha }),
        Some(Measure::Length { off, limit }) => json!({ "off_mm": off / MILLIMETRE, "limit_mm": limit / MILLIMETRE }),
        Some(Measure::Folds { off, limit }) => json!({ "off": off, "limit": limit }),
        Some(Measure::Drift { baseline, estimate, standard_error, moved, limit }) => {
            json!({ "baseline": baseline, "estimate": estimate, "se": standard_error, "moved_se": moved, "limit_se": limit })
        }
    };
    if let Value::Object(numbers) = numbers {
        object.extend(numbers);
    }
    Value::Object(object)
}
