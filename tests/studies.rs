//! The studies at their quickest: what was asked is delivered, nothing is wrong without saying, and counts are as they were.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use hemline::experiment::Point;
use hemline::experiment::campaign::{Language, PictureScale, Pictures};
use hemline::import::image;
use hemline::report::language::{Measure, Translator};
use hemline::report::study_section::{Machine, StudySection, write};
use hemline::report::{accuracy as accuracy_report, stability as stability_report, terms as terms_report};
use hemline::simulate::scene::HemNumbers;
use hemline::study::accuracy::picture::Picture;
use hemline::study::accuracy::{self, AccuracyStudy, Depth, Options};
use hemline::study::clock::Clock;
use hemline::study::hard_cases::{Outcome, SEVERITIES};
use hemline::study::stability::{self, StabilityStudy};
use hemline::study::terms::{self, TermsStudy};

const QUICK: Options = Options { depth: Depth::Quick, seed: 1 };

fn traced(picture: &Picture) -> Result<Vec<Point>, hemline::Error> {
    let found = image::outline_of_pixels(picture.side, &picture.values, &Pictures::of_scale(PictureScale::Pixel(picture.pixel)))?;
    Ok(found.profile.points().to_vec())
}

static ACCURACY: LazyLock<AccuracyStudy> = LazyLock::new(|| accuracy::study(&QUICK, &traced, &|_| ()).expect("every reference is reached"));
static STABILITY: LazyLock<StabilityStudy> = LazyLock::new(|| stability::study(&QUICK, &|| ()));

static TERMS: LazyLock<TermsStudy> =
    LazyLock::new(|| terms::study(terms::grid(Depth::Quick), terms::fidelity(Depth::Quick), &Clock::of(Depth::Quick), &|| ()));

/// Rows of a fixture; docs/studies.md says how it is made.
fn fixture(name: &str) -> Vec<String> {
    let path = format!("{}/tests/fixtures/studies/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).expect("the fixture").lines().map(String::from).collect()
}

/// Counts must be the same but for what rounding decides: whether a last step is still needed, one evaluation or 2 %.
fn compare(found: &[(String, Option<usize>)], golden: &[String]) {
    let faults: Vec<String> = found
        .iter()
        .zip(golden)
        .filter_map(|((name, count), line)| {
            let (known, expected) = line.rsplit_once('|').expect("name|count");
            let expected: Option<usize> = expected.parse().ok();
            let same = match (count, expected) {
                (Some(count), Some(expected)) => count.abs_diff(expected) <= 1.max(expected / 50),
                (a, b) => a.is_none() && b.is_none(),
            };
            (known != name || !same).then(|| format!("{name}|{} where {line} was", count.map_or_else(String::new, |n| n.to_string())))
        })
        .collect();
    assert!(
        faults.is_empty() && found.len() == golden.len(),
        "{} rows, {} in the fixture\n{}",
        found.len(),
        golden.len(),
        faults.join("\n")
    );
}

fn accuracy_counts() -> Vec<(String, Option<usize>)> {
    let rows = ACCURACY.panels.iter().flat_map(|panel| panel.rows.iter().map(move |row| (panel, row)));
    // Distances and nodes are counts times sizes: a step of rounding is then a whole size, which 2 % and one do not cover.
    rows.map(|(panel, row)| (format!("{}|{}|{}|{}", panel.name, row.method, row.knob, row.setting), row.evaluations)).collect()
}

fn stability_counts() -> Vec<(String, Option<usize>)> {
    let cells = STABILITY.cases.iter().flat_map(|case| case.cells.iter().map(move |cell| (case, cell)));
    cells
        .map(|(case, cell)| {
            (format!("{}|{:e}|{}", case.name, cell.severity, stability_report::outcome_name(cell.outcome)), cell.evaluations)
        })
        .collect()
}

/// Evaluations with and without each term, and in the name what it is about: whether the term is in and the folds on either side.
fn terms_counts() -> Vec<(String, Option<usize>)> {
    let sides = |row: &hemline::simulate::scene::Switched| [("with", row.with.clone()), ("without", row.without.clone())];
    let rows = TERMS.rows().flat_map(|(scene, row)| sides(row).map(|(side, hem)| (scene, row, side, hem)));
    rows.map(|(scene, row, side, hem): (_, _, _, Option<HemNumbers>)| {
        let state = if row.screened.on { "in" } else { "out" };
        let folds = hem.as_ref().map_or_else(|| "no hem".into(), |hem| format!("{} folds", hem.folds));
        (format!("{}|{}|{state}|{side}|{folds}", scene.name, row.term.name()), hem.map(|hem| hem.evaluations))
    })
    .collect()
}

/// Prints the fixtures: `cargo test --release --test studies -- --ignored --nocapture`.
#[test]
#[ignore = "makes the fixtures"]
fn print_the_counts() {
    for (name, counts) in [("accuracy", accuracy_counts()), ("stability", stability_counts()), ("terms", terms_counts())] {
        for (row, count) in counts {
            println!("{name}: {row}|{}", count.map_or_else(String::new, |n| n.to_string()));
        }
    }
}

#[test]
fn an_accuracy_that_is_asked_for_and_claimed_is_delivered() {
    let rows: Vec<_> = ACCURACY.panels.iter().flat_map(|panel| &panel.rows).filter(|row| row.asked.is_some()).collect();
    let broken: Vec<_> = rows.iter().filter(|row| row.delivered() == Some(false)).collect();
    assert!(broken.is_empty(), "{broken:#?}");
    // The promise must not be kept by promising nothing.
    assert!(20 <= rows.iter().filter(|row| row.delivered() == Some(true)).count(), "{}", rows.len());
}

#[test]
fn computations_that_fail_are_rows_with_their_reason() {
    let failed: Vec<_> = ACCURACY.panels.iter().flat_map(|panel| &panel.rows).filter(|row| row.error.is_none()).collect();
    // 24 points for eight folds, twenty pixels a side, sixteen replicates are asked on purpose.
    assert!(4 <= failed.len() && failed.iter().all(|row| row.termination.starts_with("refused: ")), "{failed:#?}");
}

#[test]
fn every_panel_has_a_front_and_its_default_has_a_place_beside_it() {
    use accuracy::front::{Cost, default_excess, front};
    for panel in &ACCURACY.panels {
        assert!(!front(panel, Cost::Evaluations).is_empty() && panel.rows.iter().filter(|row| row.default).count() <= 1, "{}", panel.name);
    }
    let with_default = ACCURACY.panels.iter().filter(|panel| default_excess(panel, Cost::Seconds).is_some()).count();
    assert!(7 <= with_default, "{with_default}");
}

#[test]
fn accuracy_counts_are_as_they_were() {
    compare(&accuracy_counts(), &fixture("accuracy_counts.txt"));
}

#[test]
fn nothing_is_wrong_without_saying() {
    let wrong: Vec<String> = STABILITY.wrong().map(|(case, cell)| format!("{} at {:e}: {}", case.name, cell.severity, cell.said)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_hard_case_begins_with_a_right_answer_and_has_all_its_severities() {
    for case in &STABILITY.cases {
        assert_eq!(case.cells.len(), SEVERITIES, "{}", case.name);
        // An outlier of one standard deviation is none, and cloth of 1 mN·m hangs round.
        let easy = case.cells.iter().position(|cell| cell.outcome == Outcome::Right);
        assert!(easy.is_some_and(|i| i <= 2), "{}: {:?}", case.name, case.cells);
    }
    let right = STABILITY.cases.iter().flat_map(|case| &case.cells).filter(|cell| cell.outcome == Outcome::Right).count();
    // Refusing everything is no stability.
    assert!(3 * STABILITY.cases.len() * SEVERITIES < 4 * right, "{right}");
}

#[test]
fn stability_outcomes_and_counts_are_as_they_were() {
    compare(&stability_counts(), &fixture("stability_counts.txt"));
}

#[test]
fn every_scene_of_the_quick_grid_has_its_terms_switched() {
    let failed: Vec<_> = TERMS.scenes.iter().filter_map(|(name, answer)| Some((name, answer.as_ref().err()?))).collect();
    assert!(TERMS.scenes.len() == 8 && failed.is_empty(), "{failed:?}");
    // Gravity, bending, shear and stretch everywhere, hips in half of the scenes, contact of folds but in the two short ones that hang round over hips.
    assert_eq!(TERMS.rows().count(), 4 * 8 + 4 + 6);
}

#[test]
fn the_screen_leaves_out_no_term_that_moves_the_hem_by_more_than_the_tolerance() {
    let missed: Vec<String> = TERMS
        .rows()
        .filter(|(scene, row)| !row.screened.on && row.movement.is_some_and(|moved| scene.tolerance < moved))
        .map(|(scene, row)| {
            format!("{}: {} moves {:?} m, estimated {:?}", scene.name, row.term.name(), row.movement, row.screened.movement)
        })
        .collect();
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

#[test]
fn terms_counts_are_as_they_were() {
    compare(&terms_counts(), &fixture("terms_counts.txt"));
}

/// Every letter is half an em wide.
struct Even;

impl Measure for Even {
    fn width(&self, text: &str) -> f64 {
        0.5 * text.chars().count() as f64
    }
}

#[test]
fn no_string_of_the_chapters_is_left_untranslated() {
    let machine = Machine { name: "hemline".into(), threads: 1 };
    let translator = Translator::strict(Language::Russian, BTreeSet::new());
    let sections = [
        accuracy_report::section(&ACCURACY, &machine).expect("drawn"),
        stability_report::section(&STABILITY).expect("drawn"),
        terms_report::section(&TERMS, &machine).expect("drawn"),
    ];
    for chapter in sections.iter().map(StudySection::chapter) {
        let words = std::iter::once(&chapter.title).chain(&chapter.paragraphs);
        let cells = chapter.tables.iter().flat_map(|t| std::iter::once(&t.caption).chain(&t.columns).chain(t.rows.iter().flatten()));
        words.chain(cells).chain(chapter.figures.iter().map(|f| &f.caption)).for_each(|text| {
            translator.say(text);
        });
        for figure in &chapter.figures {
            translator.svg(&figure.svg, &Even);
        }
    }
    let missing = translator.missing();
    assert!(missing.is_empty(), "{} strings have no Russian words:\n{}", missing.len(), missing.join("\n"));
}

#[test]
fn sections_are_written_whole_with_figures_that_hold_numbers_only() {
    let machine = Machine { name: "a test".into(), threads: 1 };
    let sections: [StudySection; 3] = [
        accuracy_report::section(&ACCURACY, &machine).expect("drawn"),
        stability_report::section(&STABILITY).expect("drawn"),
        terms_report::section(&TERMS, &machine).expect("drawn"),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    for section in &sections {
        let written = write(section, folder.path()).expect("written");
        assert_eq!(written.len(), 1 + section.tables.len() + 2 * section.figures.len());
        for figure in &section.figures {
            assert!(figure.svg.contains("mm\" viewBox") && !figure.svg.contains("NaN") && !figure.svg.contains("inf"), "{}", figure.stem);
        }
        let page = std::fs::read_to_string(&written[0]).expect("a page");
        assert!(section.sentences.iter().all(|sentence| page.contains(sentence.as_str())));
    }
    let header = |i: usize| sections[i].tables[0].table.columns.join(",");
    assert!(
        header(0).starts_with("panel,method,knob,setting,asked_mm,") && header(1).starts_with("subject,case,what_grows,severity,outcome,")
    );
    assert!(header(2).starts_with("scene,term,on,number,tolerance_mm,estimate_mm,movement_mm,"));
}
