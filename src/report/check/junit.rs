//! The judgements as JUnit XML: one suite for each question, one case for each subject.
//!
//! A failure is a `failure`, a question without an answer an `error`; what is expected to fail or not asked is `skipped`, with the reason. There
//! are no times in it: a result has none.

use super::{finding, subject};
use crate::experiment::check::Question;
use crate::study::check::{Judgement, Status};

/// The whole file.
pub fn junit(judgements: &[Judgement]) -> String {
    let mut out = header(judgements.iter());
    for question in Question::ALL {
        let own = || judgements.iter().filter(move |j| j.question == question);
        if own().next().is_none() {
            continue;
        }
        let (tests, failures, errors, skipped) = counts(own());
        out += &format!(
            "  <testsuite name=\"{}\" tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\" skipped=\"{skipped}\">\n",
            question.name()
        );
        own().for_each(|j| out += &case(j));
        out += "  </testsuite>\n";
    }
    out + "</testsuites>\n"
}

/// The file where nothing could be checked.
pub fn failure(why: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
<testsuites name=\"hemline check\" tests=\"1\" failures=\"0\" errors=\"1\" skipped=\"0\">\n  \
<testsuite name=\"campaign\" tests=\"1\" failures=\"0\" errors=\"1\" skipped=\"0\">\n    \
<testcase classname=\"hemline.campaign\" name=\"campaign\">\n      <error message=\"{}\"/>\n    </testcase>\n  </testsuite>\n</testsuites>\n",
        escaped(why)
    )
}

fn header<'a>(all: impl Iterator<Item = &'a Judgement>) -> String {
    let (tests, failures, errors, skipped) = counts(all);
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
<testsuites name=\"hemline check\" tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\" skipped=\"{skipped}\">\n"
    )
}

/// Tests, failures, errors, skipped.
fn counts<'a>(judgements: impl Iterator<Item = &'a Judgement>) -> (usize, usize, usize, usize) {
    judgements.fold((0, 0, 0, 0), |(tests, failures, errors, skipped), j| match j.status {
        Status::Holds => (tests + 1, failures, errors, skipped),
        Status::Fails | Status::Stale { .. } => (tests + 1, failures + 1, errors, skipped),
        Status::Unanswered => (tests + 1, failures, errors + 1, skipped),
        Status::Expected { .. } | Status::NotAsked => (tests + 1, failures, errors, skipped + 1),
    })
}

fn case(judgement: &Judgement) -> String {
    let name = escaped(&subject(&judgement.subject));
    let open = format!("    <testcase classname=\"hemline.{}\" name=\"{name}\"", judgement.question.name());
    let element = match judgement.status {
        Status::Holds => return open + "/>\n",
        Status::Fails | Status::Stale { .. } => "failure",
        Status::Unanswered => "error",
        Status::Expected { .. } | Status::NotAsked => "skipped",
    };
    format!("{open}>\n      <{element} message=\"{}\"/>\n    </testcase>\n", escaped(&finding(judgement)))
}

/// Text as the value of an attribute; characters that XML 1.0 has no way to write become U+FFFD.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' | '\r' | '\t' => out.push_str(&format!("&#{};", c as u32)),
            c if c < ' ' || c == '\u{fffe}' || c == '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}
