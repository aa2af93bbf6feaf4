//! The judgements as annotations of a GitHub workflow.
//!
//! GitHub shows at most ten of each kind for a step, so there is one for each question and kind of answer, not one for each subject.
//! Source: <https://docs.github.com/actions/reference/workflow-commands-for-github-actions>.

use std::path::Path;

use super::{finding, subject};
use crate::experiment::check::Question;
use crate::study::check::{Judgement, Status};

/// Which statuses a list is about.
type Wanted = fn(&Status) -> bool;

/// More lines than these nobody reads in an annotation.
const MOST_LINES: usize = 12;

/// One workflow command a line; `file` is the campaign's `campaign.toml`. Empty if everything holds.
pub fn annotations(file: &Path, judgements: &[Judgement]) -> String {
    let kinds: [(&str, &str, Wanted); 4] = [
        ("error", "could not be answered", |s| matches!(s, Status::Unanswered)),
        ("error", "fails", |s| matches!(s, Status::Fails)),
        ("error", "does not fail as expected", |s| matches!(s, Status::Stale { .. })),
        ("notice", "fails as expected", |s| matches!(s, Status::Expected { .. })),
    ];
    let mut out = String::new();
    for (command, words, wanted) in kinds {
        for question in Question::ALL {
            let lines: Vec<String> = judgements
                .iter()
                .filter(|j| j.question == question && wanted(&j.status))
                .map(|j| format!("{}: {}", subject(&j.subject), finding(j)))
                .collect();
            if lines.is_empty() {
                continue;
            }
            let mut message = lines[..lines.len().min(MOST_LINES)].join("\n");
            if MOST_LINES < lines.len() {
                message += &format!("\nand {} more", lines.len() - MOST_LINES);
            }
            out += &annotation(command, file, &format!("{} {words}", question.name()), &message);
        }
    }
    out
}

/// One annotation.
pub fn annotation(command: &str, file: &Path, title: &str, message: &str) -> String {
    format!("::{command} file={},title={}::{}\n", property(&file.display().to_string()), property(title), data(message))
}

fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}
