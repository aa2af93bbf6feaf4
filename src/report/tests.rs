//! What holds for a whole report, on the sample campaign.

use super::*;

fn provenance() -> Provenance {
    Provenance {
        settings: vec![("Hem length".into(), "auto".into()), ("Folds".into(), "auto".into())],
        date: Some(Date::from_epoch(1_709_251_199)),
    }
}

fn english(study: &CampaignStudy) -> Translator {
    Translator::new(Language::English, language::names(study))
}

#[test]
fn a_report_is_written_whole_and_is_the_same_twice() {
    let study = sample::study();
    let options = Options { provenance: provenance(), ..Options::default() };
    let folder = tempfile::tempdir().unwrap();
    let once = write(&study, &folder.path().join("a"), &options).unwrap();
    let twice = write(&study, &folder.path().join("b"), &options).unwrap();
    let names: Vec<String> = once.iter().map(|p| p.strip_prefix(folder.path().join("a")).unwrap().display().to_string()).collect();
    for expected in [
        "report.pdf",
        "report.html",
        "fits.csv",
        "regression.csv",
        "quarantine.csv",
        "candidates.csv",
        "fidelities.csv",
        "identify.csv",
        "fidelity_summary.csv",
        "summary.json",
        "report.xlsx",
        "parquet/fits.parquet",
        "figures/hem_1.png",
    ] {
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
    let number = |name: &str| match table.rows[0][column(name)] {
        csv::Cell::Number(value) => value,
        ref other => panic!("{name} is {other:?}"),
    };
    // Millimetres in a metre; a rounding or two in each product.
    const MILLIMETRES: f64 = 1000.0;
    assert!((number("p_mm") / fit.hem.p - MILLIMETRES).abs() < 1e-12);
    assert!((number("area_mm2") / fit.area - MILLIMETRES * MILLIMETRES).abs() < 1e-9);
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
fn all_three_theories_stand_against_every_run_of_known_cloth() {
    let study = sample::study();
    // One of the forty runs is set aside.
    let runs = fidelities::runs(&study.fidelities);
    assert_eq!(runs.rows.len(), 3 * 39);
    let summary = fidelities::summary(&crate::study::fidelities::summarize(&study.fidelities), &["rigidity", "density", "conicity"]);
    assert_eq!(summary.rows.len(), 3 * (1 + 8));
    // The campaign's own theory says the same in both tables.
    let fits = table::fits(study.runs.iter().map(Into::into));
    let place = |table: &csv::Table, name: &str| table.columns.iter().position(|c| c == name).unwrap();
    for row in runs.rows.iter().filter(|row| row[1] == csv::Cell::from("ruled")) {
        let fit = fits.rows.iter().find(|fit| fit[0] == row[0]).unwrap();
        assert_eq!(row[place(&runs, "predicted_m")], fit[place(&fits, "predicted_m")]);
        assert_eq!(row[place(&runs, "rms_mm")], fit[place(&fits, "theory_gap_mm")]);
    }
    assert!(gallery::draw(&study).unwrap().contains_key("theory_fidelities"));
}

#[test]
fn a_campaign_without_regressions_theory_or_cloth_still_has_a_document() {
    let mut study = sample::study();
    study.regressions.clear();
    study.fidelities.clear();
    study.identified.clear();
    for run in &mut study.runs {
        (run.prediction, run.prediction_at_fitted_folds, run.comparison) = (None, None, None);
        run.lambda = Default::default();
    }
    let gallery = gallery::draw(&study).unwrap();
    let pdf = typeset::pdf(document::manuscript(&study, gallery, &Options::default(), &english(&study))).unwrap();
    assert!(pdf.starts_with(b"%PDF"));
}

#[test]
fn every_column_and_key_is_described_in_the_docs() {
    let docs = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/results.md")).unwrap();
    let summary = summary::summary(&sample::study(), &provenance());
    for key in summary.as_object().unwrap().keys() {
        assert!(docs.contains(&format!("`{key}`")), "summary.json: {key}");
    }
    for key in summary["runs"][0].as_object().unwrap().keys().chain(summary["regressions"][0].as_object().unwrap().keys()) {
        assert!(docs.contains(&format!("`{key}`")), "summary.json: {key}");
    }
    // Columns are described singly or by their common beginning, as in `theory_minus_fit_…`.
    let described = |column: &str| {
        let mut beginnings = column.match_indices('_').map(|(at, _)| &column[..=at]);
        docs.contains(&format!("`{column}`"))
            || beginnings.any(|b| docs.contains(&format!("`{b}…")) || docs.contains(&format!("`{}…", b.trim_end_matches('_'))))
    };
    for column in table::FIT_COLUMNS.iter().filter(|c| !["p_se_mm", "q_mm", "q_se_mm", "s_mm"].contains(c)) {
        assert!(described(column), "fits.csv: {column}");
    }
}

#[test]
fn a_campaign_in_which_everything_failed_still_has_a_document() {
    let mut study = sample::study();
    study.fidelities.clear();
    study.identified.clear();
    for run in &mut study.runs {
        run.profile = None;
        run.fit = Err("the profile was set aside".into());
        (run.prediction, run.prediction_at_fitted_folds, run.comparison) = (None, None, None);
        run.lambda = Default::default();
    }
    for regression in &mut study.regressions {
        regression.analysis = Err("no run has this number".into());
    }
    let gallery = gallery::draw(&study).unwrap();
    assert!(typeset::pdf(document::manuscript(&study, gallery, &Options::default(), &english(&study))).unwrap().starts_with(b"%PDF"));
    assert!(!summary::summary(&study, &Provenance::default()).to_string().contains("NaN"));
}
