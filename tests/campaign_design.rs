//! Centre points, blocks and wishes of a campaign, from its folder to the tables of the report.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use hemline::model::hem::{Hem, Placement};
use hemline::units::MILLIMETRE;
use tempfile::TempDir;

/// Levels of a and b in natural units, block, and p in mm; written as a campaign whose campaign.toml ends with `more`.
fn campaign(rows: &[(f64, f64, &str, f64)], more: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let toml = "title = \"Trial\"\norigin = \"made by tests/campaign_design.rs\"\napparatus = \"skirt\"\n\
[geometry]\nwaist_radius_cm = 12.1\nhem_radius_cm = 23.62\nslant_length_cm = 53\n\
[cloth]\nareal_density_g_m2 = 200\nflexural_rigidity_un_m = 10\n\
[[factors]]\nname = \"a\"\nlow = 10\nhigh = 20\nlevels = \"natural\"\n[[factors]]\nname = \"b\"\nlow = -1\nhigh = 1\n\
[analysis]\nresponses = [\"p\", \"m\", \"rms\"]\nfolds = 6\nhem_length = \"free\"\nblock = \"day\"\n";
    fs::write(folder.path().join("campaign.toml"), format!("{toml}{more}")).expect("written");
    let mut design = String::from("run,day,a,b,profile\n");
    for (i, (a, b, day, p)) in rows.iter().enumerate() {
        design += &format!("{},{day},{a},{b},p{i}.csv\n", i + 1);
        let hem = Hem { p: p * MILLIMETRE, q: 20.0 * MILLIMETRE, s: 2.0 * MILLIMETRE, folds: 6 };
        let points = hem.outline(&Placement::ORIGIN, 60);
        let text: String = points.iter().map(|point| format!("{},{}\n", point.x / MILLIMETRE, point.y / MILLIMETRE)).collect();
        fs::write(folder.path().join(format!("p{i}.csv")), format!("x_mm,y_mm\n{text}")).expect("written");
    }
    fs::write(folder.path().join("design.csv"), design).expect("written");
    folder
}

fn run(folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hemline"));
    command.arg("run").arg(folder).arg("--out").arg(folder.join("report")).arg("--no-pictures");
    command.output().expect("the program runs")
}

/// Estimate and p of a term.
fn term(folder: &Path, name: &str) -> (f64, f64) {
    let table = fs::read_to_string(folder.join("report/regression.csv")).expect("a table");
    let row = table.lines().find(|line| line.starts_with(&format!("p_mm,{name},"))).unwrap_or_else(|| panic!("{name} is not in {table}"));
    let cell = |i: usize| row.split(',').nth(i).and_then(|c| c.parse().ok()).expect("a number");
    (cell(2), cell(5))
}

/// p = 150 + 3 a + 2 b at the corners, 5 mm more at the centre, 1 mm more on Tuesday than the mean of the days; scatter ±0.1 that cancels in each
/// cell of each day.
fn rows() -> Vec<(f64, f64, &'static str, f64)> {
    let mut rows = vec![];
    for (day, of_day) in [("Monday", -1.0), ("Tuesday", 1.0)] {
        for (scatter, (a, b)) in [0.1, -0.1].into_iter().flat_map(|e| [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|x| (e, x)))
        {
            rows.push((15.0 + 5.0 * a, b, day, 150.0 + 3.0 * a + 2.0 * b + of_day + scatter));
        }
        rows.extend([0.1, -0.1].map(|scatter| (15.0, 0.0, day, 155.0 + of_day + scatter)));
    }
    rows
}

#[test]
fn curvature_and_blocks_are_estimated_apart_from_the_effects() {
    let folder = campaign(&rows(), "");
    let output = run(folder.path());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // The outlines are exact, and the fit ends within 1e-6 mm.
    for (name, exact) in [("1", 150.0), ("a", 3.0), ("b", 2.0), ("a:b", 0.0), ("curvature", 5.0), ("block Monday", -1.0)] {
        let (estimate, p) = term(folder.path(), name);
        assert!((estimate - exact).abs() < 1e-5, "{name}: {estimate}");
        assert_eq!(p < 0.01, exact != 0.0, "{name}: p = {p}");
    }
    assert!(fs::read(folder.path().join("report/report.pdf")).expect("a report").starts_with(b"%PDF"));
    let summary = fs::read_to_string(folder.path().join("report/summary.json")).expect("a summary");
    assert!(!summary.contains("unbalanced"), "four runs at the centre do not unbalance the corners");
}

#[test]
fn a_level_between_and_a_run_without_a_block_are_set_aside_with_a_reason() {
    let mut rows = rows();
    (rows[1].1, rows[2].2) = (0.0, "");
    let folder = campaign(&rows, "");
    let output = run(folder.path());
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(said.contains("row 3") && said.contains("at the centre in some factors"), "{said}");
    assert!(said.contains("row 4") && said.contains("the run has no block"), "{said}");
}

#[test]
fn a_block_column_that_is_not_there_is_named() {
    let folder = campaign(&rows(), "");
    let design = fs::read_to_string(folder.path().join("design.csv")).expect("read").replace("run,day", "run,date");
    fs::write(folder.path().join("design.csv"), design).expect("written");
    let output = run(folder.path());
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(output.status.code() == Some(2) && said.contains("“day” for the block"), "{said}");
}

#[test]
fn the_setting_that_meets_a_wish_is_found() {
    let folder = campaign(&rows(), "[[wishes]]\nresponse = \"p\"\ntarget = { low = 140, target = 154, high = 160 }\n");
    assert!(run(folder.path()).status.success());
    let table = fs::read_to_string(folder.path().join("report/desirability.csv")).expect("a table");
    let cells: Vec<&str> = table.lines().nth(1).expect("a row").split(',').collect();
    let [predicted, desirability, overall, a, b] = [1, 2, 3, 4, 5].map(|i| cells[i].parse::<f64>().expect("a number"));
    // On 150 + 3 (a − 15)/5 + 2 b = 154 the wish is met; the search steps by 2⁻²⁰ of an interval.
    assert!((predicted - 154.0).abs() < 1e-4 && (150.0 + 0.6 * (a - 15.0) + 2.0 * b - predicted).abs() < 1e-4, "{table}");
    assert!(desirability > 0.9999 && overall == desirability);
}

#[test]
fn a_wish_that_says_nothing_or_two_things_is_refused_with_its_row() {
    let wish = |words: &str| format!("[[wishes]]\nresponse = \"p\"\n{words}\n");
    let cases = [
        (wish(""), "does not say one thing"),
        (wish("larger = { worthless = 1, perfect = 2 }\nsmaller = { worthless = 2, perfect = 1 }"), "does not say one thing"),
        (wish("larger = { worthless = 3, perfect = 2 }"), "out of order"),
        (wish("target = { low = 1, target = 2, high = nan }"), "out of order"),
        (wish("larger = { worthless = 1, perfect = 2 }\nimportance = 0"), "importance is 0"),
        (wish("").replace("\"p\"", "\"q\""), "response “q” is not among those that are regressed"),
    ];
    for (words, said) in cases {
        let folder = campaign(&rows(), &words);
        let error = String::from_utf8(run(folder.path()).stderr).expect("UTF-8");
        assert!(error.contains("campaign.toml, row 25: ") && error.contains(said), "{words}{error}");
    }
}

#[test]
fn theory_is_regressed_like_the_measurement_and_laid_beside_it() {
    let folder = campaign(&rows(), "");
    assert!(run(folder.path()).status.success());
    let read = |name: &str| fs::read_to_string(folder.path().join("report").join(name)).expect("a table");
    let (effects, predictions) = (read("theory_effects.csv"), read("predictions.csv"));
    let row = |response: &str, term: &str| -> Vec<String> {
        let row = effects.lines().find(|line| line.starts_with(&format!("{response},{term},"))).unwrap_or_else(|| panic!("{effects}"));
        row.split(',').map(String::from).collect()
    };
    let number = |cells: &[String], i: usize| cells[i].parse::<f64>().unwrap_or_else(|_| panic!("{cells:?}"));
    // All skirts are cut alike from one cloth, so theory has one hem for all: its fold count is the mean, and no factor changes anything.
    let header: Vec<&str> = predictions.lines().next().expect("a header").split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).expect("a column");
    let chosen = predictions.lines().find(|line| line.split(',').nth(column("chosen")) == Some("true")).expect("a chosen branch");
    let folds: f64 = chosen.split(',').nth(column("m")).and_then(|m| m.parse().ok()).expect("a fold count");
    assert!((number(&row("m", "1"), 5) - folds).abs() < 1e-12, "{effects}");
    for (term, agreement) in [("a", "wrong_size"), ("b", "wrong_size"), ("a:b", "both_absent")] {
        let cells = row("p_mm", term);
        assert!(number(&cells, 5).abs() < 1e-9 && cells[9] == agreement, "{cells:?}");
    }
    // Its mean radius is that of a hem shorter in plan than 2π·236 mm, and larger than the waist.
    assert!((121.0..236.2).contains(&number(&row("p_mm", "1"), 5)));
    // How well a curve meets measured points is no prediction.
    assert!(!effects.contains("\nrms_mm,"));
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).expect("JSON");
    assert!(
        summary["regressions"][2]["theory_missing"].as_str().expect("a reason").contains("does not predict"),
        "{}",
        summary["regressions"][2]
    );
}

#[test]
fn what_the_design_could_see_and_where_to_go_are_tables() {
    // Without centre points and blocks: four corners, four runs of each.
    let corners: Vec<_> = rows().into_iter().filter(|row| row.1 != 0.0).map(|(a, b, _, p)| (a, b, "Monday", p)).collect();
    let folder = campaign(&corners, "");
    assert!(run(folder.path()).status.success());
    let read = |name: &str| fs::read_to_string(folder.path().join("report").join(name)).expect("a table");
    let power = read("power.csv");
    let done: Vec<&str> = power.lines().filter(|line| line.starts_with("p_mm,") && line.ends_with(",true")).collect();
    assert!(matches!(&done[..], [row] if row.starts_with("p_mm,4,")), "{power}");
    let ascent = read("ascent.csv");
    let step = |goal: &str| -> Vec<f64> {
        let row = ascent.lines().find(|line| line.starts_with(&format!("p_mm,{goal},4,"))).unwrap_or_else(|| panic!("{ascent}"));
        row.split(',').skip(3).take(3).map(|cell| cell.parse().expect("a number")).collect()
    };
    // Four quarter steps up: a by 5 to its high level, b by 2/3; p = 150 + 3 + 4/3. Down is the mirror image.
    let (up, down) = (step("increase"), step("decrease"));
    assert!((up[0] - 20.0).abs() < 1e-5 && (up[1] - 2.0 / 3.0).abs() < 1e-5 && (up[2] - 154.0 - 1.0 / 3.0).abs() < 1e-4, "{up:?}");
    assert!((down[0] - 10.0).abs() < 1e-5 && (down[2] - 145.0 - 2.0 / 3.0).abs() < 1e-4, "{down:?}");
    assert!(read("next_runs.csv").contains("No run at the centre"));
    assert!(read("weighted.csv").lines().any(|line| line.starts_with("p_mm,a:b,")));
    assert!(read("diagnostics.csv").lines().nth(1).expect("a row").starts_with("p_mm,Cochran G,"));
}
