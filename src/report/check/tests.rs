//! Hostile words and every status survive in every format.

use std::path::Path;

use super::{annotations, baseline, json, junit, text};
use crate::experiment::check::Question;
use crate::study::baseline::{Baseline, CoefficientRecord, RunRecord, SCHEMA};
use crate::study::check::{Judgement, Measure, Status, Subject};

fn judgement(question: Question, subject: Subject, status: Status, measure: Option<Measure>, remark: &str) -> Judgement {
    Judgement { question, subject, status, measure, remark: remark.into() }
}

/// One judgement of each status and each measure, with words that every format has to escape.
fn all() -> Vec<Judgement> {
    let drift = |standard_error, moved| Some(Measure::Drift { baseline: 147.2, estimate: 149.1, standard_error, moved, limit: 1.0 });
    let test = |p| Some(Measure::Test { test: "Cochran G".into(), statistic: 0.52, p, alpha: 0.05 });
    let response = |name: &str| Subject::Response(name.into());
    vec![
        judgement(Question::Fitted, Subject::Run("1".into()), Status::Holds, None, ""),
        judgement(Question::Fitted, Subject::Run("a\"<&>\u{1}".into()), Status::Fails, None, "50 %, row 3: it's\nbroken"),
        judgement(Question::Reproducibility, response("p_mm"), Status::Expected { reason: "known".into() }, test(1e-9), ""),
        judgement(Question::Reproducibility, response("q_mm"), Status::Stale { reason: "was known".into() }, test(0.5), ""),
        judgement(Question::Adequacy, response("m"), Status::Unanswered, None, "no treatment was repeated"),
        judgement(Question::TheoryRms, Subject::Run("1".into()), Status::Fails, Some(Measure::Length { off: 0.0234, limit: 0.02 }), ""),
        judgement(Question::TheoryFoldCount, Subject::Run("1".into()), Status::Fails, Some(Measure::Folds { off: -1, limit: 0 }), ""),
        judgement(Question::Drift, Subject::Campaign, Status::NotAsked, None, "give --baseline FILE"),
        judgement(
            Question::Drift,
            Subject::Estimate { run: "1".into(), quantity: "p_mm".into() },
            Status::Fails,
            drift(Some(0.6), Some(3.17)),
            "",
        ),
        judgement(Question::Drift, Subject::Coefficient { response: "m".into(), term: "a:b".into() }, Status::Fails, drift(None, None), ""),
    ]
}

#[test]
fn the_terminal_shows_every_judgement_that_does_not_hold() {
    let shown = text::text("Trial", &all());
    for said in [
        "run 1, p_mm: 147.2 → 149.1, 3.2 standard errors of 0.60, limit 1",
        "m, term a:b: 147.200 → 149.100, without a standard error to allow it",
        "p_mm: Cochran G = 0.520, p < 0.0001, below 0.05; expected: known",
        "q_mm: Cochran G = 0.520, p = 0.50, not below 0.05; campaign.toml expects it to fail (was known), but it does not",
        "run 1: 23.4 mm off, limit 20 mm",
        "run 1: 1 fold too few, limit 0",
        "m: no treatment was repeated",
        "2 tests at α = 0.05: on sound data 0.1 would fail by chance.",
        "Could not be checked: 1 could not be answered, 5 failed, 1 did not fail as expected, 1 hold, 1 failed as expected.",
    ] {
        assert!(shown.contains(said), "{said} is not in\n{shown}");
    }
    super::super::sample::look("check.txt", shown.as_bytes());
}

#[test]
fn json_has_every_number_and_every_status() {
    let value = json::json("Trial", &all());
    let counts = ["holds", "fails", "expected", "stale", "unanswered", "not_asked"].map(|name| value["counts"][name].as_u64().unwrap());
    assert_eq!((counts, value["exit_code"].as_u64()), ([1, 5, 1, 1, 1, 1], Some(2)));
    assert_eq!(value["judgements"][1]["subject"]["run"], "a\"<&>\u{1}");
    assert!((value["judgements"][5]["off_mm"].as_f64().unwrap() - 23.4).abs() < 1e-12);
    assert_eq!(value["judgements"][2]["reason"], "known");
}

#[test]
fn xml_has_no_character_that_xml_has_not() {
    let xml = junit::junit(&all());
    assert!(xml.contains("name=\"run a&quot;&lt;&amp;&gt;\u{fffd}\"") && xml.contains("row 3: it's&#10;broken"), "{xml}");
    assert!(xml.starts_with("<?xml") && xml.contains("tests=\"10\" failures=\"6\" errors=\"1\" skipped=\"2\""), "{xml}");
    assert!(junit::failure("a < b").contains("<error message=\"a &lt; b\"/>"));
}

#[test]
fn annotations_are_one_line_each_and_escape_what_github_reads() {
    let commands = annotations::annotations(Path::new("a,b:c/campaign.toml"), &all());
    // Not answered: 1 question; failed: 4; stale: 1; expected: 1.
    assert_eq!(commands.lines().count(), 7, "{commands}");
    assert!(
        commands.lines().all(|line| line.starts_with("::error file=a%2Cb%3Ac/campaign.toml,title=") || line.starts_with("::notice file="))
    );
    assert!(commands.contains("50 %25, row 3: it's%0Abroken"), "{commands}");
}

#[test]
fn a_baseline_is_read_back_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let written = Baseline {
        schema: SCHEMA.into(),
        program: "hemline".into(),
        campaign: "Trial “\"”".into(),
        coefficients: vec![CoefficientRecord { response: "p_mm".into(), term: "1".into(), estimate: 0.1 + 0.2, se: Some(1e-3) }],
        runs: vec![RunRecord { run: "\\7\n".into(), quantity: "m".into(), estimate: 6.0, se: None }],
    };
    let path = folder.path().join("deep/baseline.json");
    baseline::write(&path, &written).unwrap();
    assert_eq!(baseline::read(&path).unwrap(), written);
    // One estimate a line: the two of them, two brackets round each list, two round all, three lines of head.
    assert_eq!(std::fs::read_to_string(&path).unwrap().lines().count(), 2 + 4 + 2 + 3);
}
