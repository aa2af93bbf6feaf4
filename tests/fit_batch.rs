//! `hemline fit --into`: campaigns in Parquet, part by part.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use polars::prelude::{Column, DataFrame, IntoColumn, NamedFrom, ParquetWriter, Series};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const POINTS: usize = 72;

/// One row of the table: name, x, y in cm.
type Rows = Vec<(Option<String>, Option<f64>, Option<f64>)>;

/// Seeded hems of five to seven folds.
fn campaign(profiles: usize) -> Rows {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut rows = Rows::new();
    for k in 0..profiles {
        let folds = f64::from(random.random_range(5..8));
        let phase = TAU * random.random::<f64>();
        for i in 0..POINTS {
            let t = TAU * (i as f64 + 0.5 * random.random::<f64>()) / POINTS as f64;
            let (rho, tau) = (20.0 + 2.5 * (folds * t).cos(), 0.3 * (2.0 * folds * t).sin());
            let mut noise = || 0.1 * (random.random::<f64>() - 0.5);
            let x = rho * (t + phase).cos() - tau * (t + phase).sin() + noise();
            let y = rho * (t + phase).sin() + tau * (t + phase).cos() + noise();
            rows.push((Some(format!("skirt {}", k + 1)), Some(x), Some(y)));
        }
    }
    rows
}

fn write(path: &Path, rows: &Rows, weights: Option<Vec<f64>>, group: usize) {
    let column = |name: &str, values: Vec<Option<f64>>| -> Column { Series::new(name.into(), values).into_column() };
    let names: Vec<Option<&str>> = rows.iter().map(|row| row.0.as_deref()).collect();
    let mut columns = vec![
        Series::new("profile".into(), names).into_column(),
        column("x_cm", rows.iter().map(|row| row.1).collect()),
        column("y_cm", rows.iter().map(|row| row.2).collect()),
    ];
    columns.extend(weights.map(|w| column("weight", w.into_iter().map(Some).collect())));
    let mut frame = DataFrame::new_infer_height(columns).expect("a table");
    let file = fs::File::create(path).expect("writable");
    ParquetWriter::new(file).with_row_group_size(Some(group)).finish(&mut frame).expect("written");
}

fn hemline(folder: &Path, threads: usize, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hemline"));
    command.current_dir(folder).env("RAYON_NUM_THREADS", threads.to_string()).args(arguments);
    command.output().expect("the program starts")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Every file of a folder with its bytes.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("readable").path());
    entries.map(|path| (path.file_name().expect("a name").into(), fs::read(&path).expect("readable"))).collect()
}

/// The rows of all parts in order, below one header.
fn joined(folder: &Path, kind: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for (name, bytes) in contents(folder) {
        let name = name.to_string_lossy().into_owned();
        if name.starts_with(kind) && name.ends_with(".csv") {
            let text = String::from_utf8(bytes).expect("text");
            lines.extend(text.lines().skip(usize::from(!lines.is_empty())).map(String::from));
        }
    }
    lines
}

#[test]
fn parts_hold_the_rows_that_fit_prints_whatever_the_row_groups_and_the_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let rows = campaign(150);
    // 1000 rows a group: nearly every group ends within a profile; 500: groups are put together; 10800: one group is cut into slices.
    for group in [500, 1000, 10_800] {
        write(&at.join("campaign.parquet"), &rows, None, group);
        let printed = hemline(at, 2, &["fit", "campaign.parquet", "--folds", "4-8"]);
        let expected: Vec<String> = String::from_utf8(printed.stdout).expect("text").lines().map(String::from).collect();
        assert_eq!(expected.len(), 151);
        for threads in [1, 2] {
            let into = format!("of {group} on {threads}");
            let output = hemline(at, threads, &["fit", "campaign.parquet", "--folds", "4-8", "--into", &into, "--part-rows", "2000"]);
            assert!(output.status.success(), "{}", said(&output));
            assert!(said(&output).contains("150 profiles in "), "{}", said(&output));
            assert_eq!(joined(&at.join(&into), "part-"), expected, "{into}");
        }
        let [one, two] = [1, 2].map(|threads| contents(&at.join(format!("of {group} on {threads}"))));
        assert!(8 < one.len() && one == two, "{} files", one.len());
    }
}

#[test]
fn a_profile_larger_than_its_row_groups_and_parts_is_one_profile() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let mut rows = campaign(3);
    let large: Rows = (0..5000)
        .map(|i| TAU * f64::from(i) / 5000.0)
        .map(|t| (Some("large".into()), Some((20.0 + 3.0 * (6.0 * t).cos()) * t.cos()), Some((20.0 + 3.0 * (6.0 * t).cos()) * t.sin())))
        .collect();
    rows.splice(POINTS..POINTS, large);
    write(&at.join("a.parquet"), &rows, None, 700);
    let output = hemline(at, 2, &["fit", "a.parquet", "--into", "out", "--part-rows", "1000"]);
    assert!(output.status.success(), "{}", said(&output));
    let lines = joined(&at.join("out"), "part-");
    let names: Vec<&str> = lines.iter().skip(1).map(|line| line.split(',').next().expect("a cell")).collect();
    assert_eq!(names, ["skirt 1", "large", "skirt 2", "skirt 3"]);
    assert!(lines[2].starts_with("large,5000,converged,6,"), "{}", lines[2]);
}

#[test]
fn a_stopped_run_goes_on_and_keeps_what_was_done() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    write(&at.join("a.parquet"), &campaign(150), None, 1000);
    let run = || hemline(at, 2, &["fit", "a.parquet", "--into", "out", "--part-rows", "1000"]);
    let into = at.join("out");
    assert!(run().status.success());
    let whole = contents(&into);
    // As a kill leaves it: a part without its tally, a tally without its part, half a part, an unfinished file of another name.
    fs::remove_file(into.join("part-00001.json")).expect("a tally");
    fs::remove_file(into.join("part-00003.csv")).expect("a part");
    let half = &whole[Path::new("part-00005.csv")];
    fs::write(into.join("part-00005.csv"), &half[..half.len() / 2]).expect("writable");
    let unfinished = into.join(".hemline-abc.part");
    fs::write(&unfinished, b"run,n_poi").expect("writable");
    // A kept part is not written again: what stands in it stays.
    let marked = into.join("part-00000.csv");
    let mut bytes = fs::read(&marked).expect("readable");
    let last = bytes.len() - 2;
    bytes[last] = b'!';
    fs::write(&marked, &bytes).expect("writable");
    let output = run();
    assert!(output.status.success(), "{}", said(&output));
    let kept = said(&output).rsplit("; ").next().and_then(|end| end.split(' ').next()?.parse::<usize>().ok());
    assert!(kept.is_some_and(|kept| (100..150).contains(&kept)), "{}", said(&output));
    fs::remove_file(&unfinished).expect("it was left alone");
    let mut again = contents(&into);
    assert_eq!(again.insert("part-00000.csv".into(), whole[Path::new("part-00000.csv")].clone()), Some(bytes));
    assert!(again == whole, "the parts differ from those of a run that was not stopped");
}

#[test]
fn parts_of_another_task_are_refused_unless_told_to_begin_anew() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let rows = campaign(40);
    write(&at.join("a.parquet"), &rows, None, 1000);
    let fit = |more: &[&str]| {
        let output = hemline(at, 2, &[&["fit", "a.parquet", "--into", "out", "--part-rows", "1000"], more].concat());
        (output.status.code(), said(&output))
    };
    assert_eq!(fit(&[]).0, Some(0));
    let before = contents(&at.join("out"));
    for (options, reason) in [(["--folds", "6"], "with other options"), (["--level", "0.9"], "with other intervals")] {
        let (code, said) = fit(&options);
        assert!(code == Some(2) && said.contains(reason) && said.contains("--again"), "{said}");
    }
    assert!(contents(&at.join("out")) == before, "a refusal changes nothing");
    write(&at.join("a.parquet"), &rows[..30 * POINTS].to_vec(), None, 1000);
    let (code, said) = fit(&[]);
    assert!(code == Some(2) && said.contains("from other files"), "{said}");
    let (code, said) = fit(&["--again"]);
    assert!(code == Some(0) && said.contains("30 profiles") && said.contains("0 profiles kept"), "{said}");
    assert_eq!(joined(&at.join("out"), "part-").len(), 31);
    fs::remove_file(at.join("out/manifest.json")).expect("a manifest");
    let (code, said) = fit(&[]);
    assert!(code == Some(2) && said.contains("no manifest.json"), "{said}");
}

#[test]
fn nothing_is_dropped_silently() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let mut rows = campaign(30);
    rows[5].1 = None;
    rows[100].2 = Some(f64::NAN);
    rows[200].0 = None;
    // Profile 10 stands in two places, profile 20 has too few points.
    for row in &mut rows[25 * POINTS..25 * POINTS + 30] {
        row.0 = Some("skirt 10".into());
    }
    rows.drain(19 * POINTS..20 * POINTS - 5);
    write(&at.join("a.parquet"), &rows, None, 700);
    let output = hemline(at, 2, &["fit", "a.parquet", "--into", "out", "--part-rows", "1000"]);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    let aside = joined(&at.join("out"), "quarantine-");
    let of = |row: &str, problem: &str| aside.iter().any(|line| line.contains(&format!(",{row},")) && line.contains(problem));
    assert!(of("6", "“x_cm” is empty") && of("101", "“y_cm” is not a finite number") && of("201", "“profile” is empty"), "{aside:#?}");
    assert_eq!(aside.iter().filter(|line| line.starts_with("skirt 10,") && line.contains("several places")).count(), 2, "{aside:#?}");
    assert!(aside.iter().any(|line| line.starts_with("skirt 20,") && line.contains("5 distinct points")), "{aside:#?}");
    let fits = joined(&at.join("out"), "part-");
    let row = |name: &str| fits.iter().find(|line| line.split(',').next() == Some(name)).cloned();
    assert!(row("skirt 10").is_none() && row("skirt 20").is_none());
    for (name, points) in [("skirt 1", 71), ("skirt 2", 71), ("skirt 3", 71), ("skirt 4", 72)] {
        assert!(row(name).is_some_and(|line| line.starts_with(&format!("{name},{points},"))), "{name}");
    }
    let text = said(&output);
    assert!(text.contains("31 profiles") && text.contains("28 fitted") && text.contains("quarantine-*.csv"), "{text}");
}

#[test]
fn weights_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let mut rows = campaign(4);
    // The first point of each profile is far off, and its weight next to nothing.
    (0..4).for_each(|k| rows[k * POINTS].1 = rows[k * POINTS].1.map(|x| x + 1.5));
    let fitted = |weights: Option<Vec<f64>>| {
        write(&at.join("a.parquet"), &rows, weights, 1000);
        let output = hemline(at, 2, &["fit", "a.parquet", "--into", "out", "--again"]);
        assert!(output.status.success(), "{}", said(&output));
        let rms = |line: &String| line.split(',').nth(14).and_then(|cell| cell.parse::<f64>().ok()).expect("rms_mm");
        joined(&at.join("out"), "part-").iter().skip(1).map(rms).collect::<Vec<f64>>()
    };
    let alike = fitted(None);
    let weighed = fitted(Some((0..4 * POINTS).map(|i| if i % POINTS == 0 { 1e-6 } else { 1.0 }).collect()));
    // Uniform noise of ±0.5 mm across the curve: 0.29 mm; a point about 15 mm off among 72 adds its share.
    assert!(alike.iter().zip(&weighed).all(|(alike, weighed)| *weighed < 0.4 && weighed < alike), "{alike:?} {weighed:?}");
}

#[test]
fn what_cannot_be_read_part_by_part_says_what_would_be_right() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let refused = |file: &str| {
        let output = hemline(at, 1, &["fit", file, "--into", "out"]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        said(&output)
    };
    fs::write(at.join("a.csv"), "profile,x_cm,y_cm\n1,2,3\n").expect("writable");
    assert!(refused("a.csv").contains("Parquet"));
    assert!(refused("missing.parquet").contains("missing.parquet"));
    let mut rows = campaign(20);
    write(&at.join("whole.parquet"), &rows, None, 1000);
    let bytes = fs::read(at.join("whole.parquet")).expect("readable");
    fs::write(at.join("half.parquet"), &bytes[..bytes.len() / 2]).expect("writable");
    assert!(refused("half.parquet").contains("half.parquet"));
    rows.sort_by(|a, b| a.1.partial_cmp(&b.1).expect("numbers"));
    write(&at.join("mixed.parquet"), &rows, None, 1000);
    assert!(refused("mixed.parquet").contains("sort the rows by profile"));
    assert!(!at.join("out/manifest.json").exists());
}
