//! What holds for a whole report, on the sample campaign.

use std::path::PathBuf;

use super::*;

fn provenance() -> Provenance {
    let source = |i: u32| Source {
        file: PathBuf::from(format!("data/profiles/run_{i:02}.csv")),
        bytes: 4_000,
        digest: format!("{:016x}", 0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(u64::from(i))),
    };
    Provenance {
        sources: (1..=40).map(source).collect(),
        quarantine: vec![Quarantined {
            run: Some("17".into()),
            file: "data/profiles/run_17.csv".into(),
            row: Some(4),
            value: "3 points".into(),
            problem: "a profile of 3 distinct points #strong[markup] *is* text".into(),
            remedy: "at least 12 points round the whole hem are needed".into(),
        }],
        settings: vec![("Hem length".into(), "auto".into()), ("Folds".into(), "auto".into())],
        date: Some(Date::from_epoch(1_709_251_199)),
    }
}

#[test]
fn a_report_is_written_whole_and_is_the_same_twice() {
    let study = sample::study();
    let options = Options { provenance: provenance(), pictures: true };
    let folder = tempfile::tempdir().unwrap();
    let once = write(&study, &folder.path().join("a"), &options).unwrap();
    let twice = write(&study, &folder.path().join("b"), &options).unwrap();
    let names: Vec<String> = once.iter().map(|p| p.strip_prefix(folder.path().join("a")).unwrap().display().to_string()).collect();
    for expected in ["report.pdf", "fits.csv", "regression.csv", "quarantine.csv", "candidates.csv", "summary.json", "figures/hem_1.png"] {
        assert!(names.iter().any(|n| n == expected), "{expected} is missing of {names:?}");
    }
    for (a, b) in once.iter().zip(&twice) {
        let (first, second) = (std::fs::read(a).unwrap(), std::fs::read(b).unwrap());
        assert!(!first.is_empty());
        assert!(first == second, "{} differs", a.display());
        sample::look(&a.strip_prefix(folder.path().join("a")).unwrap().display().to_string(), &first);
    }
}

#[test]
fn the_fits_table_begins_with_the_columns_that_are_fixed() {
    let study = sample::study();
    let table = table::fits(study.runs.iter().map(Into::into));
    let fixed = "run,n_points,termination,m,m_weight,p_mm,p_se_mm,q_mm,q_se_mm,s_mm,s_se_mm,x0_mm,y0_mm,phase_rad,rms_mm,perimeter_mm,\
                 area_mm2,fold_depth_mm,lambda_first_integral_n_m2,lambda_first_integral_r2,lambda_ritz_n_m2,lambda_ritz_angle_deg,lambda_ruled_n";
    let text = String::from_utf8(table.bytes()).unwrap();
    assert!(text.starts_with(&format!("{fixed},")));
    assert_eq!(text.lines().count(), 41);
    let set_aside = text.lines().find(|l| l.starts_with("17,")).unwrap();
    assert!(set_aside.starts_with("17,,set_aside,,,,"), "{set_aside}");
    assert!(!text.contains("NaN") && !text.contains("inf"));
}

#[test]
fn millimetres_in_the_table_are_metres_of_the_fit() {
    let study = sample::study();
    let table = table::fits(study.runs.iter().take(1).map(Into::into));
    let column = |name: &str| table.columns.iter().position(|c| c == name).unwrap();
    let fit = study.runs[0].fit.as_ref().unwrap();
    assert_eq!(table.rows[0][column("p_mm")], csv::Cell::Number(fit.hem.p / 1e-3));
    assert_eq!(table.rows[0][column("area_mm2")], csv::Cell::Number(fit.area / (1e-3 * 1e-3)));
    assert_eq!(table.rows[0][column("m")], csv::Cell::Integer(i64::from(fit.hem.folds)));
}

#[test]
fn the_summary_says_where_the_numbers_come_from_and_what_does_not_exist() {
    let study = sample::study();
    let summary = summary::summary(&study, &provenance());
    assert_eq!(summary["schema"], "hemline-summary-1");
    assert_eq!(summary["origin"], study.campaign.origin.as_str());
    assert_eq!(summary["date"], "2024-02-29");
    let runs = summary["runs"].as_array().unwrap();
    let set_aside = runs.iter().find(|r| r["run"] == "17").unwrap();
    assert!(set_aside["p_mm"].is_null() && set_aside["m"].is_null());
    assert_eq!(summary["regressions"].as_array().unwrap().len(), 6);
}

#[test]
fn a_campaign_without_regressions_theory_or_cloth_still_has_a_document() {
    let mut study = sample::study();
    study.regressions.clear();
    for run in &mut study.runs {
        (run.prediction, run.prediction_at_fitted_folds, run.comparison) = (None, None, None);
        run.lambda = Default::default();
    }
    let gallery = gallery::draw(&study).unwrap();
    let pdf = document::pdf(&study, &gallery, &Provenance::default()).unwrap();
    assert!(pdf.starts_with(b"%PDF"));
}

#[test]
fn where_the_time_of_a_report_goes_is_printed() {
    let study = sample::study();
    let mut spent = vec![];
    let mut clock = std::time::Instant::now();
    let mut lap = |name: &str| {
        spent.push(format!("{name} {:.0} ms", 1e3 * clock.elapsed().as_secs_f64()));
        clock = std::time::Instant::now();
    };
    let gallery = gallery::draw(&study).unwrap();
    lap("figures");
    let first = document::pdf(&study, &gallery, &provenance()).unwrap();
    lap("document");
    let second = document::pdf(&study, &gallery, &provenance()).unwrap();
    lap("again");
    let tiny = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"84mm\" height=\"95mm\"/>".to_string();
    let empty = gallery.keys().map(|k| (k.clone(), tiny.clone())).collect();
    document::pdf(&study, &empty, &provenance()).unwrap();
    lap("empty figures");
    let pictures = rasterize(&gallery).unwrap();
    lap("pictures");
    println!("{}; {} figures, {} bytes of PDF", spent.join(", "), pictures.len(), first.len());
    assert_eq!(first, second);
}
