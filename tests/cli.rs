//! The program as its users call it: scripts read its JSON and CSV, laboratories its reports.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn hemline(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hemline"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env_remove("SOURCE_DATE_EPOCH")
        .output()
        .expect("the program starts")
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("UTF-8")
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}{}", stdout(output), stderr(output)))
}

/// Rows of a CSV text by column name. The tables of these tests quote no commas before the columns looked at.
fn rows(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    lines.map(|line| header.iter().map(|h| h.to_string()).zip(line.split(',').map(String::from)).collect()).collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} is “{}”", row[column]))
}

const FIRST_COLUMNS: &str = "run,n_points,termination,m,m_weight,p_mm,p_se_mm,q_mm,q_se_mm,s_mm,s_se_mm,x0_mm,y0_mm,phase_rad,rms_mm,\
perimeter_mm,area_mm2,fold_depth_mm,lambda_first_integral_n_m2,lambda_first_integral_r2,lambda_ritz_n_m2,lambda_ritz_angle_deg,lambda_ruled_n";

/// A table of two hems with known p, q, s, m, one outline each.
fn two_hems(folder: &Path) -> PathBuf {
    let mut text = String::from("profile,x_mm,y_mm\n");
    for (name, p, q, s, m) in [("six", 150.0, 25.0, 4.0, 6.0), ("nine", 180.0, 12.0, -2.0, 9.0)] {
        for i in 0..240 {
            let t = f64::from(i) * std::f64::consts::TAU / 240.0;
            let (rho, tau) = (p + q * f64::cos(m * t), s * f64::sin(2.0 * m * t));
            let (sin, cos) = (t + 0.2_f64).sin_cos();
            text.push_str(&format!("{name},{:.6},{:.6}\n", 31.0 + rho * cos - tau * sin, -12.0 + rho * sin + tau * cos));
        }
    }
    let path = folder.join("two.csv");
    fs::write(&path, text).expect("writable");
    path
}

#[test]
fn every_command_teaches_itself() {
    for command in ["run", "fit", "predict", "regress", "init"] {
        let output = hemline(&[command, "--help"]);
        let text = stdout(&output);
        assert!(output.status.success() && text.contains("Usage:") && text.len() > 400, "{command}: {text}");
    }
}

#[test]
fn the_shipped_campaign_becomes_a_report() {
    let out = tempfile::tempdir().unwrap();
    let output = hemline(&["run", "--out", out.path().to_str().unwrap(), "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let summary = json(&output);
    assert!(summary["origin"].as_str().unwrap().contains("imulated"), "the origin of simulated data is said");

    let fits = fs::read_to_string(out.path().join("fits.csv")).unwrap();
    assert!(fits.lines().next().unwrap().starts_with(FIRST_COLUMNS));
    let fits = rows(&fits);
    assert_eq!(fits.len(), 40);
    for row in &fits {
        assert!(row.values().all(|cell| !["NaN", "inf", "-inf"].contains(&cell.as_str())), "{row:?}");
        assert!((3.0..=9.0).contains(&number(row, "m")) && number(row, "rms_mm") < 25.0, "{row:?}");
        assert!(0.0 <= number(row, "lambda_first_integral_r2") && number(row, "lambda_first_integral_r2") <= 1.0);
    }
    // Seven responses, eight terms each.
    let regression = fs::read_to_string(out.path().join("regression.csv")).unwrap();
    assert!(regression.lines().next().unwrap().starts_with("response,term,estimate,se,t,p,ci_low,ci_high"));
    assert_eq!(rows(&regression).len(), 7 * 8);
    // Balanced design: the constant is the mean of the responses.
    let mean = fits.iter().map(|row| number(row, "q_mm")).sum::<f64>() / 40.0;
    let constant = rows(&regression).into_iter().find(|r| r["response"] == "q_mm" && r["term"] == "1").unwrap();
    assert!((number(&constant, "estimate") - mean).abs() < 1e-9 * mean);

    let pdf = fs::read(out.path().join("report.pdf")).unwrap();
    assert!(pdf.starts_with(b"%PDF") && pdf.len() > 500_000, "{} bytes", pdf.len());
    for name in ["quarantine.csv", "summary.json", "predictions.csv", "candidates.csv", "figures/hem_1.png"] {
        assert!(out.path().join(name).is_file(), "{name}");
    }
    let leftovers: Vec<_> =
        fs::read_dir(out.path()).unwrap().map(|e| e.unwrap().file_name()).filter(|n| n.to_string_lossy().ends_with(".part")).collect();
    assert!(leftovers.is_empty(), "{leftovers:?}");
}

#[test]
fn fit_finds_the_curve_that_made_the_points() {
    let folder = tempfile::tempdir().unwrap();
    let path = two_hems(folder.path());
    let output = hemline(&["fit", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).starts_with(FIRST_COLUMNS));
    let rows = rows(&stdout(&output));
    for (row, (name, p, q, s, m)) in rows.iter().zip([("six", 150.0, 25.0, 4.0, 6.0), ("nine", 180.0, 12.0, -2.0, 9.0)]) {
        assert_eq!(row["run"], name);
        assert_eq!(row["termination"], "converged");
        for (column, truth) in [("p_mm", p), ("q_mm", q), ("s_mm", s), ("m", m), ("x0_mm", 31.0), ("y0_mm", -12.0)] {
            // Coordinates are rounded to 1e-6 mm; 240 of them average that.
            assert!((number(row, column) - truth).abs() < 1e-6, "{name} {column}: {}", row[column]);
        }
        assert!(row["lambda_ritz_n_m2"].is_empty(), "λ without cloth does not exist");
    }
}

#[test]
fn a_held_hem_length_is_met() {
    let folder = tempfile::tempdir().unwrap();
    let path = two_hems(folder.path());
    let output = hemline(&["fit", path.to_str().unwrap(), "--folds", "6-9", "--hem-length-cm", "125"]);
    let rows = rows(&stdout(&output));
    for row in rows.iter().filter(|row| !row["perimeter_mm"].is_empty()) {
        assert!((number(row, "perimeter_mm") - 1250.0).abs() < 1e-9 * 1250.0, "{}", row["perimeter_mm"]);
    }
    assert!(rows.iter().any(|row| !row["perimeter_mm"].is_empty()));
}

#[test]
fn predict_gives_the_reference_hem() {
    let cut = ["--waist-radius-cm", "12.1", "--hem-radius-cm", "23.62", "--slant-length-cm", "53"];
    let cloth = ["--areal-density-g-m2", "200", "--rigidity-un-m", "10"];
    let output = hemline(&[&["predict"], &cut[..], &cloth[..], &["--harmonics", "12", "--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let hem = json(&output);
    assert_eq!(hem["folds"], 5);
    // The table of the ruled shell at K = 12: energy to its ten digits, radii to eight.
    let close = |key: &str, value: f64, tolerance: f64| {
        let found = hem[key].as_f64().unwrap_or_else(|| panic!("{key}"));
        assert!((found - value).abs() < tolerance, "{key} {found} {value}");
    };
    close("energy_j", 0.002156002405, 1e-12);
    close("gravity_j", 0.001020628956, 1e-10);
    close("bending_j", 0.001135373449, 1e-10);
    close("hem_radius_min_m", 0.07845656, 1e-8);
    close("hem_radius_max_m", 0.18741830, 1e-8);
    assert!(hem["coefficients"][0].as_f64().unwrap() > 0.0);
    assert_eq!(hem["termination"], "converged");

    let stiff = hemline(&[&["predict"], &cut[..], &["--areal-density-g-m2", "200", "--rigidity-un-m", "100000", "--json"]].concat());
    assert_eq!((stiff.status.code(), &json(&stiff)["folds"]), (Some(0), &Value::from(0)), "a stiff cone stays round");
    let tester = hemline(&[
        "predict",
        "--waist-radius-cm",
        "9",
        "--hem-radius-cm",
        "15",
        "--slant-length-cm",
        "6",
        "--areal-density-g-m2",
        "200",
        "--rigidity-un-m",
        "10",
    ]);
    assert_eq!(tester.status.code(), Some(2), "no theory here for a drape tester");
}

#[test]
fn regress_gives_coefficients_and_tests() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    let mut text = String::from("a,b,y\n");
    for replicate in 0..3 {
        for (a, b) in [(-1, -1), (1, -1), (-1, 1), (1, 1)] {
            let scatter = f64::from((7 * replicate + 3 * a + 5 * b) % 4) * 0.05;
            text.push_str(&format!("{a},{b},{}\n", 10.0 + 2.0 * f64::from(a) - f64::from(b) + scatter));
        }
    }
    fs::write(&path, text).unwrap();
    let output = hemline(&["regress", path.to_str().unwrap(), "--factors", "a,b", "--response", "y", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let result = json(&output);
    let terms: Vec<&str> = result["terms"].as_array().unwrap().iter().map(|t| t["term"].as_str().unwrap()).collect();
    assert_eq!(terms, ["1", "a", "b", "a:b"]);
    assert_eq!(result["residual_df"], 8);
    for term in result["terms"].as_array().unwrap() {
        assert!(["estimate", "se", "t", "p"].iter().all(|key| term[key].is_f64()), "{term}");
    }
    // Cochran's 5 % point for 4 variances of 2 degrees of freedom, 0.7679 (Eisenhart, Hastay & Wallis 1947).
    assert!((result["cochran"]["critical"].as_f64().unwrap() - 0.7679).abs() < 5e-4, "{}", result["cochran"]);
    assert!(
        result["adequacy"].get("f").is_some() && result["adequacy"].get("critical").is_some() && result["adequacy"].get("df").is_some()
    );
}

#[test]
fn one_bad_run_does_not_hide_the_others_and_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = folder.path().join("campaign");
    fs::create_dir_all(campaign.join("profiles")).unwrap();
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("data/profiles")).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, campaign.join("profiles").join(path.file_name().unwrap())).unwrap();
    }
    for name in ["campaign.toml", "design.csv"] {
        fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name), campaign.join(name)).unwrap();
    }
    fs::remove_file(campaign.join("profiles/run_07.csv")).unwrap();
    fs::write(campaign.join("profiles/run_09.csv"), "x_cm,y_cm\n1,2\n3,4\n5,0\n").unwrap();
    let out = folder.path().join("out");
    let output = hemline(&["run", campaign.to_str().unwrap(), "--out", out.to_str().unwrap(), "--no-pictures"]);
    assert_eq!(output.status.code(), Some(1), "{}{}", stdout(&output), stderr(&output));
    let quarantine = fs::read_to_string(out.join("quarantine.csv")).unwrap();
    assert!(quarantine.contains("run_07.csv") && quarantine.contains("run_09.csv") && quarantine.contains("3"), "{quarantine}");
    let fits = rows(&fs::read_to_string(out.join("fits.csv")).unwrap());
    assert_eq!(fits.iter().filter(|row| !row["p_mm"].is_empty()).count(), 38);
    assert_eq!(fits.len(), 40, "a run without a fit keeps its row");
    assert!(stderr(&output).contains("run_07.csv"));
}

#[test]
fn a_campaign_that_is_not_there_is_one_sentence_with_a_remedy() {
    let output = hemline(&["run", "no/such/folder"]);
    assert_eq!(output.status.code(), Some(2));
    let sentence = stderr(&output);
    assert!(sentence.contains("no/such/folder") && sentence.contains("init") && sentence.lines().count() == 1, "{sentence}");
}

#[test]
fn the_same_input_gives_the_same_report() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |threads: &str| {
        let out = folder.path().join(threads);
        let status = Command::new(env!("CARGO_BIN_EXE_hemline"))
            .args(["run", "--no-pictures", "--out", out.to_str().unwrap()])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .env("RAYON_NUM_THREADS", threads)
            .env("SOURCE_DATE_EPOCH", "1700000000")
            .output()
            .unwrap()
            .status;
        assert!(status.success());
        ["report.pdf", "fits.csv", "regression.csv", "summary.json"].map(|name| fs::read(out.join(name)).unwrap())
    };
    assert!(bytes("1") == bytes("3"), "the report depends on the number of threads");
}

#[test]
fn forty_real_silhouettes_are_fitted() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/cusick40");
    if !source.is_dir() {
        println!("skipped: {} is not here", source.display());
        return;
    }
    println!("with the forty silhouettes in {}", source.display());
    let folder = tempfile::tempdir().unwrap();
    let campaign = folder.path().join("campaign");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/cusick40_campaign.sh");
    assert!(Command::new("bash").arg(script).arg(&source).arg(&campaign).output().unwrap().status.success());
    let out = folder.path().join("out");
    let output = hemline(&["run", campaign.to_str().unwrap(), "--out", out.to_str().unwrap(), "--no-pictures"]);
    assert_eq!(output.status.code(), Some(0), "{}{}", stdout(&output), stderr(&output));
    let fits = rows(&fs::read_to_string(out.join("fits.csv")).unwrap());
    assert_eq!(fits.len(), 40);
    for row in &fits {
        // A shadow is some 0.9 m round; a curve that fills space is much longer.
        assert!((number(row, "perimeter_mm") / number(row, "outline_length_mm") - 1.0).abs() < 0.06, "{row:?}");
        assert!(row["lambda_ritz_n_m2"].is_empty() && !row["lambda_over_weight"].is_empty(), "{row:?}");
        assert!((0.0..=1.0).contains(&number(row, "explained_share")));
    }
    // The fabric is what was varied: it must show in the mean radius, and the negative controls must not dominate it.
    let regression = rows(&fs::read_to_string(out.join("regression.csv")).unwrap());
    let t = |term: &str| number(regression.iter().find(|r| r["response"] == "p_mm" && r["term"] == term).unwrap(), "t").abs();
    assert!(t("fabric") > 20.0 && t("capture") < 0.2 * t("fabric") && t("batch") < 0.2 * t("fabric"));
}
