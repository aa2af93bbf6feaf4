//! The judgements on a terminal: how many hold, and everything that does not.

use super::{finding, subject};
use crate::experiment::check::Question;
use crate::report::number::{fixed, plain};
use crate::study::check::{Conclusion, Judgement, Measure, Status, conclusion};

/// Which statuses a list is about.
type Wanted = fn(&Status) -> bool;

/// A table of counts, then one line for each judgement that does not hold, then the conclusion.
pub fn text(title: &str, judgements: &[Judgement]) -> String {
    let mut out = format!("{title}\n\n{:<20}{:>7}{:>7}{:>10}{:>12}\n", "", "holds", "fails", "expected", "unanswered");
    for question in Question::ALL {
        let count = |wanted: Wanted| judgements.iter().filter(|j| j.question == question && wanted(&j.status)).count();
        let counts = [
            count(|s| matches!(s, Status::Holds)),
            count(|s| matches!(s, Status::Fails | Status::Stale { .. })),
            count(|s| matches!(s, Status::Expected { .. })),
            count(|s| matches!(s, Status::Unanswered)),
        ];
        if counts == [0; 4] {
            let why = judgements.iter().find(|j| j.question == question).map_or("", |j| j.remark.as_str());
            out += &format!("{:<20}  not asked: {why}\n", question.name());
            continue;
        }
        let shown = counts.map(|n| if n == 0 { "–".to_string() } else { n.to_string() });
        out += &format!("{:<20}{:>7}{:>7}{:>10}{:>12}\n", question.name(), shown[0], shown[1], shown[2], shown[3]);
    }
    let lists: [(&str, Wanted); 4] = [
        ("Could not be answered", |s| matches!(s, Status::Unanswered)),
        ("Fails", |s| matches!(s, Status::Fails)),
        ("Does not fail as expected", |s| matches!(s, Status::Stale { .. })),
        ("Fails as expected", |s| matches!(s, Status::Expected { .. })),
    ];
    for (heading, wanted) in lists {
        let listed: Vec<&Judgement> = judgements.iter().filter(|j| wanted(&j.status)).collect();
        if !listed.is_empty() {
            out += &format!("\n{heading}\n");
            listed.iter().for_each(|j| out += &format!("  {:<18}{}: {}\n", j.question.name(), subject(&j.subject), finding(j)));
        }
    }
    out + "\n" + &chance(judgements) + &concluded(judgements) + "\n"
}

/// What chance alone would do to so many tests.
fn chance(judgements: &[Judgement]) -> String {
    let levels: Vec<f64> = judgements
        .iter()
        .filter_map(|j| match j.measure {
            Some(Measure::Test { alpha, .. }) => Some(alpha),
            _ => None,
        })
        .collect();
    match levels.first() {
        Some(alpha) => format!(
            "{} tests at α = {}: on sound data {} would fail by chance.\n",
            levels.len(),
            plain(*alpha),
            fixed(levels.iter().sum(), 1)
        ),
        None => String::new(),
    }
}

/// The conclusion in one sentence.
pub fn concluded(judgements: &[Judgement]) -> String {
    let count = |wanted: Wanted| judgements.iter().filter(|j| wanted(&j.status)).count();
    let (fails, stale) = (count(|s| matches!(s, Status::Fails)), count(|s| matches!(s, Status::Stale { .. })));
    let (expected, unanswered) = (count(|s| matches!(s, Status::Expected { .. })), count(|s| matches!(s, Status::Unanswered)));
    let mut parts = Vec::new();
    let mut say = |n: usize, what: &str| {
        if 0 < n {
            parts.push(format!("{n} {what}"));
        }
    };
    say(unanswered, "could not be answered");
    say(fails, "failed");
    say(stale, "did not fail as expected");
    say(count(|s| matches!(s, Status::Holds)), "hold");
    say(expected, "failed as expected");
    let verdict = match conclusion(judgements) {
        Conclusion::Holds => "Holds",
        Conclusion::Fails => "Fails",
        Conclusion::Unanswered => "Could not be checked",
    };
    format!("{verdict}: {}.", parts.join(", "))
}
