//! The report as a reader gets it: its language, its tables in three formats, its summary against the schema, its paper and head, and what is
//! written when.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use calamine::{Data, Reader, Xlsx};
use hemline::experiment::Quarantined;
use hemline::experiment::campaign::Language;
use hemline::fit::bias::Uncorrected;
use hemline::import;
use hemline::report::csv::{Cell, Table};
use hemline::report::letterhead::Letterhead;
use hemline::report::section::{Figure, Grid, Section};
use hemline::report::tables::{self, heading};
use hemline::report::{self, Date, Options, Paper, Part, Provenance, summary};
use hemline::study::campaign::{CampaignStudy, Measured, analyse};
use polars::prelude::{AnyValue, DataFrame, ParquetReader, SerReader};
use serde_json::Value;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn campaign(folder: &Path) -> CampaignStudy {
    let import::Imported { campaign, profiles, quarantine, sources, notes, .. } = import::load(folder).unwrap();
    analyse(Measured { campaign, profiles, quarantine, sources, notes }, &|| ())
}

/// The shipped campaign, analysed once.
fn shipped() -> &'static CampaignStudy {
    static STUDY: LazyLock<CampaignStudy> = LazyLock::new(|| campaign(&root().join("data")));
    &STUDY
}

/// The shipped campaign after a bad day: a file that is damaged, a fit that failed, theory that is missing, a response without values.
fn troubled() -> CampaignStudy {
    let mut study = shipped().clone();
    study.quarantine.push(Quarantined {
        run: Some("3".into()),
        file: "profiles/run_03.csv".into(),
        sheet: Some("Sheet of May".into()),
        row: Some(4),
        value: "1o.5".into(),
        problem: "the x is not a number".into(),
        remedy: "write it as a number such as 12.3".into(),
    });
    study.notes.push("no regression: the campaign names no factors".into());
    let run = &mut study.runs[2];
    (run.profile, run.fit, run.irregular) = (None, Err("the profile was set aside; the quarantine says why".into()), None);
    (run.prediction, run.prediction_at_fitted_folds, run.comparison) = (None, None, None);
    run.lambda = Default::default();
    // What fits remark that the shipped profiles give no reason for.
    if let Ok(fit) = &mut study.runs[6].fit {
        let remarks = [
            "the outline is 3.5 % longer than the hem was cut (tilted hem, wrong scale or missing cloth?): its own length counts",
            "the outline is 3.5 % shorter than the hem was cut (tilted hem, wrong scale or missing cloth?): its own length counts",
            "no fold count gave a sane curve nearer than the circle, which misses the outline by far more than its noise",
            "the noise is wide against the sharpest bend: standard errors are too small by a tenth or more",
            "the weights of the points have not settled",
        ];
        let reasons = [
            Uncorrected::InOrder,
            Uncorrected::NotConverged,
            Uncorrected::SharpBends,
            Uncorrected::NoRoot,
            Uncorrected::BreaksRule,
            Uncorrected::Weighted,
        ];
        fit.notes = remarks.map(String::from).into();
        fit.notes.extend(reasons.map(|why| format!("the bias of curvature was left in: {}", why.reason())));
    }
    study.runs[4].on_support = Some(0.25);
    study.runs[4].drape_coefficient = Some(0.625);
    (study.runs[5].prediction, study.runs[5].prediction_at_fitted_folds, study.runs[5].comparison) = (None, None, None);
    study.runs[5].prediction_missing = Some("the areal density is not known".into());
    let last = study.regressions.last_mut().unwrap();
    last.analysis = Err("no run has this number".into());
    last.further = Err("no run has this number".into());
    study
}

fn russian() -> Options {
    Options { language: Language::Russian, provenance: provenance(), ..Options::default() }
}

fn provenance() -> Provenance {
    let settings = [
        ("Fold count", "by evidence among 2 to 24"),
        ("Hem length", "free"),
        ("Bias of curvature", "taken out"),
        ("Free fall", "9.81 m/s²"),
    ];
    Provenance {
        settings: settings.map(|(name, value)| (name.to_string(), value.to_string())).to_vec(),
        date: Some(Date::from_epoch(1_709_251_199)),
    }
}

fn only(parts: &[Part]) -> Options {
    Options { parts: parts.iter().copied().collect(), provenance: provenance(), ..Options::default() }
}

/// Writes and returns the names below the folder.
fn written(study: &CampaignStudy, folder: &Path, options: &Options) -> Vec<String> {
    let paths = report::write(study, folder, options).unwrap();
    paths.iter().map(|path| path.strip_prefix(folder).unwrap().display().to_string()).collect()
}

// ---------------------------------------------------------------- language

/// `cargo test --release --test report untranslated -- --nocapture` prints what the catalogue lacks, one string a line.
fn assert_all_said(study: &CampaignStudy) {
    let missing = report::untranslated(study, &russian()).unwrap();
    missing.iter().for_each(|text| println!("{text}"));
    assert!(
        missing.is_empty(),
        "{} strings have no Russian words (src/report/language/russian/*.txt):\n{}",
        missing.len(),
        missing.join("\n")
    );
}

#[test]
fn no_string_of_the_shipped_campaigns_report_is_left_untranslated() {
    assert_all_said(shipped());
}

#[test]
fn no_string_of_a_report_on_a_campaign_with_failures_is_left_untranslated() {
    assert_all_said(&troubled());
}

#[test]
fn english_reports_are_untouched() {
    let options = Options { language: Language::English, ..russian() };
    assert!(report::untranslated(shipped(), &options).unwrap().is_empty());
}

#[test]
fn prose_of_both_languages_has_the_same_passages() {
    let prose = |name: &str| fs::read_to_string(root().join("src/report/template").join(name)).unwrap();
    let count = |text: &str, mark: &str| text.matches(mark).count();
    let (english, russian) = (prose("prose-en.typ"), prose("prose-ru.typ"));
    for mark in ["\n  [*", "$ <", "  [_", "#let ", "#list(", "@"] {
        assert_eq!(count(&english, mark), count(&russian, mark), "{mark}");
    }
    // Equations are the same but for the words in them.
    let formulas =
        |text: &str| -> Vec<String> { text.split('$').skip(1).step_by(2).filter(|f| !f.contains('"')).map(str::to_string).collect() };
    let (mut english, mut russian) = (formulas(&english), formulas(&russian));
    english.sort();
    russian.sort();
    assert_eq!(english.iter().collect::<BTreeSet<_>>(), russian.iter().collect::<BTreeSet<_>>());
}

// ---------------------------------------------------------------- the document

fn pdf(options: &Options) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    // Few runs: the pages are of all kinds, and the test is quick.
    let mut study = troubled();
    study.runs.truncate(6);
    study.fidelities.retain(|row| study.runs.iter().any(|run| run.run.id == row.run));
    study.regressions.truncate(1);
    study.regressions[0].analysis = Err("no run has this number".into());
    study.regressions[0].further = Err("no run has this number".into());
    let names = written(&study, folder.path(), &Options { parts: [Part::Pdf].into(), ..options.clone() });
    assert_eq!(names, ["report.pdf"]);
    fs::read(folder.path().join("report.pdf")).unwrap()
}

fn holds(bytes: &[u8], text: &str) -> bool {
    bytes.windows(text.len()).any(|window| window == text.as_bytes())
}

#[test]
fn a_page_is_a4_or_letter_as_asked() {
    // 210 × 297 mm and 8½ × 11 inch, in points of 1/72 inch.
    assert!(holds(&pdf(&only(&[])), "MediaBox[0 0 595.2756 841.8898]"));
    let letter = pdf(&Options { paper: Paper::Letter, ..only(&[]) });
    assert!(holds(&letter, "MediaBox[0 0 612 792]"));
    assert!(!holds(&letter, "841.8898"));
}

#[test]
fn the_document_says_its_title_and_language_and_is_the_same_twice() {
    let once = pdf(&russian());
    assert!(once == pdf(&russian()), "two documents of the same study differ");
    assert!(holds(&once, "/Lang(ru)"), "the language of the text is not said");
    assert!(holds(&once, "/StructTreeRoot") && holds(&once, "/MarkInfo"), "the document is not tagged");
    assert!(holds(&once, "<dc:title>"), "the title is not in the metadata");
    assert!(holds(&once, "2024-02-29"), "the date of the document is not that of its provenance");
    assert!(holds(&once, "DejaVuSansCondensed") && holds(&once, "LibertinusSerif"), "fonts are not embedded");
}

#[test]
fn sections_of_studies_and_a_laboratorys_head_are_printed() {
    let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" width="50mm" height="20mm"><text x="2" y="12" font-family="DejaVu Sans">steps</text></svg>"#;
    let section = Section {
        title: "Stability".into(),
        paragraphs: vec!["Every run was fitted again.".into(), "*No* #markup here.".into()],
        tables: vec![Grid {
            caption: "Changes.".into(),
            columns: vec!["Run".into(), "Δ, mm".into()],
            rows: vec![vec!["1".into(), "0.5".into()]],
            text_columns: 1,
        }],
        figures: vec![Figure { stem: "study_stability".into(), caption: "Changes drawn.".into(), svg: svg.into() }],
    };
    let plain = pdf(&only(&[]));
    let more = pdf(&Options { sections: vec![section.clone()], ..only(&[]) });
    assert!(plain.len() < more.len());
    let letterhead = Letterhead::read(&root().join("docs/letterhead")).unwrap();
    assert!(letterhead.laboratory.is_some() && letterhead.logo.is_some());
    assert!(plain.len() < pdf(&Options { letterhead, ..only(&[]) }).len());
    // The figures of a section are written beside the others.
    let folder = tempfile::tempdir().unwrap();
    let mut study = shipped().clone();
    (study.runs, study.regressions, study.fidelities) = (vec![], vec![], vec![]);
    let names = written(&study, folder.path(), &Options { sections: vec![section], ..only(&[Part::Figures]) });
    assert!(names.contains(&"figures/study_stability.png".to_string()), "{names:?}");
}

#[test]
fn a_template_of_ones_own_reads_the_same_data_and_faults_in_it_are_located() {
    let own =
        |text: &str| Options { letterhead: Letterhead { own_template: Some(text.into()), ..Letterhead::default() }, ..only(&[Part::Pdf]) };
    let folder = tempfile::tempdir().unwrap();
    let good = own("#let data = json(\"data.json\")\n#data.title: #data.runs.len() runs, #json(\"words.json\").len() words");
    assert_eq!(written(shipped(), folder.path(), &good), ["report.pdf"]);
    let fault = report::write(shipped(), folder.path(), &own("\n#nothing")).unwrap_err().to_string();
    assert!(fault.contains("line 2"), "{fault}");
}

// ---------------------------------------------------------------- what is written when

#[test]
fn only_what_is_asked_for_is_written() {
    let mut study = shipped().clone();
    study.runs.truncate(2);
    study.regressions.clear();
    let folder = tempfile::tempdir().unwrap();
    let names = |parts: &[Part]| written(&study, folder.path(), &only(parts));
    assert_eq!(names(&[Part::Summary]), ["summary.json"]);
    let tables = names(&[Part::Tables]);
    assert!(tables.iter().all(|name| name.ends_with(".csv") || name.ends_with(".parquet") || name == "report.xlsx"), "{tables:?}");
    assert!(tables.contains(&"fits.csv".to_string()) && tables.contains(&"parquet/fits.parquet".to_string()));
    assert!(names(&[Part::Figures]).iter().all(|name| name.starts_with("figures/")));
    assert_eq!(names(&[Part::Pdf]), ["report.pdf"]);
}

// ---------------------------------------------------------------- tables

fn number(cell: &Cell) -> Option<f64> {
    match cell {
        Cell::Integer(value) => Some(*value as f64),
        Cell::Number(value) if value.is_finite() => Some(*value),
        _ => None,
    }
}

fn assert_sheet_is(table: &Table, rows: &[Vec<Data>], stem: &str) {
    assert_eq!(
        rows[0].iter().map(ToString::to_string).collect::<Vec<_>>(),
        table.columns.iter().map(|c| heading(c)).collect::<Vec<_>>(),
        "{stem}"
    );
    assert_eq!(rows.len(), table.rows.len() + 1, "{stem}");
    for (row, read) in table.rows.iter().zip(&rows[1..]) {
        for (cell, data) in row.iter().zip(read) {
            match (cell, data) {
                (Cell::Empty, Data::Empty) => (),
                (Cell::Text(text), Data::String(read)) => assert_eq!(text, read, "{stem}"),
                (Cell::Text(text), Data::Bool(read)) => assert_eq!(text, &read.to_string(), "{stem}"),
                // Runs that are numbered are numbers.
                (Cell::Text(text), Data::Float(read)) => assert_eq!(text, &read.to_string(), "{stem}"),
                // A spreadsheet keeps every digit of a double.
                (cell, Data::Float(read)) => assert_eq!(number(cell), Some(*read), "{stem}"),
                (Cell::Number(value), Data::Empty) => assert!(!value.is_finite(), "{stem}"),
                (cell, data) => panic!("{stem}: {cell:?} became {data:?}"),
            }
        }
    }
}

fn assert_frame_is(table: &Table, frame: &DataFrame, stem: &str) {
    assert_eq!(frame.get_column_names_owned().iter().map(|name| name.to_string()).collect::<Vec<_>>(), table.columns, "{stem}");
    assert_eq!(frame.height(), table.rows.len(), "{stem}");
    for (c, column) in frame.columns().iter().enumerate() {
        for (r, row) in table.rows.iter().enumerate() {
            match (&row[c], column.get(r).unwrap()) {
                (Cell::Empty, AnyValue::Null) => (),
                (Cell::Text(text), read @ (AnyValue::String(_) | AnyValue::StringOwned(_))) => {
                    assert_eq!(Some(text.as_str()), read.get_str(), "{stem}")
                }
                (Cell::Text(text), AnyValue::Boolean(read)) => assert_eq!(text, &read.to_string(), "{stem}"),
                (Cell::Integer(value), AnyValue::Int64(read)) => assert_eq!(*value, read, "{stem}"),
                (cell, AnyValue::Float64(read)) => assert_eq!(number(cell), Some(read), "{stem}"),
                (Cell::Number(value), AnyValue::Null) => assert!(!value.is_finite(), "{stem}"),
                (cell, read) => panic!("{stem}: {cell:?} became {read:?}"),
            }
        }
    }
}

#[test]
fn every_table_is_the_same_in_all_three_formats() {
    let study = troubled();
    let folder = tempfile::tempdir().unwrap();
    let names = written(&study, folder.path(), &only(&[Part::Tables]));
    let mut book: Xlsx<_> = calamine::open_workbook(folder.path().join("report.xlsx")).unwrap();
    let tables = tables::all(&study);
    let sheets = book.sheet_names();
    assert_eq!(sheets[0], "About");
    assert_eq!(sheets[1..].iter().collect::<Vec<_>>(), tables.iter().map(|named| named.stem).collect::<Vec<_>>());
    for named in &tables {
        let rows: Vec<Vec<Data>> = book.worksheet_range(named.stem).unwrap().rows().map(<[Data]>::to_vec).collect();
        assert_sheet_is(&named.table, &rows, named.stem);
        let parquet = fs::File::open(folder.path().join(format!("parquet/{}.parquet", named.stem))).unwrap();
        assert_frame_is(&named.table, &ParquetReader::new(parquet).finish().unwrap(), named.stem);
        assert_eq!(fs::read(folder.path().join(format!("{}.csv", named.stem))).unwrap(), named.table.bytes());
    }
    // Nothing of a second writing differs by a byte.
    let again = tempfile::tempdir().unwrap();
    assert_eq!(names, written(&study, again.path(), &only(&[Part::Tables])));
    for name in &names {
        assert!(fs::read(folder.path().join(name)).unwrap() == fs::read(again.path().join(name)).unwrap(), "{name} differs");
    }
}

#[test]
fn text_that_looks_like_a_formula_stays_text() {
    let mut study = troubled();
    study.quarantine[0].value = "=1+1".into();
    let folder = tempfile::tempdir().unwrap();
    written(&study, folder.path(), &only(&[Part::Tables]));
    let mut book: Xlsx<_> = calamine::open_workbook(folder.path().join("report.xlsx")).unwrap();
    assert!(book.worksheet_formula("quarantine").unwrap().cells().all(|(.., formula)| formula.is_empty()));
    assert!(book.worksheet_range("quarantine").unwrap().cells().any(|(.., cell)| *cell == Data::String("=1+1".into())));
}

// ---------------------------------------------------------------- summary.json

/// What of a value the schema does not allow; knows the words of JSON Schema (draft 2020-12) that the schema uses, and refuses others.
fn faults(value: &Value, schema: &Value, whole: &Value, at: &str, found: &mut Vec<String>) {
    let rules = schema.as_object().expect("a schema is an object");
    for (word, rule) in rules {
        let mut fault = |what: String| found.push(format!("{at}: {what}"));
        match word.as_str() {
            "description" | "title" | "$schema" | "$id" | "$defs" => (),
            "$ref" => {
                let name = rule.as_str().unwrap().strip_prefix("#/$defs/").unwrap();
                faults(value, &whole["$defs"][name], whole, at, found);
            }
            "type" => {
                let kinds: Vec<&str> = rule
                    .as_array()
                    .map_or_else(|| vec![rule.as_str().unwrap()], |kinds| kinds.iter().map(|k| k.as_str().unwrap()).collect());
                let is = |kind: &&str| match *kind {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "number" => value.is_number(),
                    "integer" => value.is_i64() || value.is_u64(),
                    "boolean" => value.is_boolean(),
                    "null" => value.is_null(),
                    other => panic!("unknown type {other}"),
                };
                if !kinds.iter().any(is) {
                    fault(format!("{value} is none of {kinds:?}"));
                }
            }
            "const" if rule != value => fault(format!("{value} is not {rule}")),
            "enum" if !rule.as_array().unwrap().contains(value) => fault(format!("{value} is none of {rule}")),
            "anyOf" => {
                let fits = |one: &Value| {
                    let mut faults_of_one = vec![];
                    faults(value, one, whole, at, &mut faults_of_one);
                    faults_of_one.is_empty()
                };
                if !rule.as_array().unwrap().iter().any(fits) {
                    fault(format!("{value} fits no alternative"));
                }
            }
            "minimum" if value.as_f64().is_some_and(|v| v < rule.as_f64().unwrap()) => fault(format!("{value} < {rule}")),
            "minItems" if value.as_array().is_some_and(|v| (v.len() as u64) < rule.as_u64().unwrap()) => fault("too few items".into()),
            "maxItems" if value.as_array().is_some_and(|v| rule.as_u64().unwrap() < v.len() as u64) => fault("too many items".into()),
            "pattern" => {
                let date = |text: &str| {
                    text.len() == 10 && text.bytes().enumerate().all(|(i, b)| if i == 4 || i == 7 { b == b'-' } else { b.is_ascii_digit() })
                };
                assert_eq!(rule, "^[0-9]{4}-[0-9]{2}-[0-9]{2}$", "the only pattern that is known here");
                if value.as_str().is_some_and(|text| !date(text)) {
                    fault(format!("{value} is no date"));
                }
            }
            "required" => {
                for key in rule.as_array().unwrap() {
                    if value.as_object().is_some_and(|map| !map.contains_key(key.as_str().unwrap())) {
                        fault(format!("{key} is missing"));
                    }
                }
            }
            "additionalProperties" | "properties" => {
                let (Some(map), known) = (value.as_object(), schema["properties"].as_object()) else { continue };
                for (key, inside) in map {
                    match known.and_then(|known| known.get(key)) {
                        Some(one) if word == "properties" => faults(inside, one, whole, &format!("{at}/{key}"), found),
                        None if word == "additionalProperties" && rule == &Value::Bool(false) => {
                            found.push(format!("{at}: {key} is not in the schema"))
                        }
                        None if word == "additionalProperties" => faults(inside, rule, whole, &format!("{at}/{key}"), found),
                        _ => (),
                    }
                }
            }
            "items" => {
                for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                    faults(item, rule, whole, &format!("{at}/{i}"), found);
                }
            }
            "const" | "enum" | "minimum" | "minItems" | "maxItems" => (),
            other => panic!("the checker does not know “{other}”"),
        }
    }
}

fn schema() -> Value {
    serde_json::from_str(&fs::read_to_string(root().join("docs/summary.schema.json")).unwrap()).unwrap()
}

fn faults_of(summary: &Value) -> Vec<String> {
    let (schema, mut found) = (schema(), vec![]);
    faults(summary, &schema, &schema, "", &mut found);
    found
}

#[test]
fn summaries_are_what_the_schema_says() {
    let mut bare = troubled();
    bare.regressions
        .iter_mut()
        .for_each(|r| (r.analysis, r.further) = (Err("no run has this number".into()), Err("no run has this number".into())));
    for (name, study) in [("shipped", shipped().clone()), ("troubled", troubled()), ("bare", bare)] {
        for provenance in [provenance(), Provenance::default()] {
            // As a reader gets it: through text.
            let read: Value = serde_json::from_str(&summary::text(&study, &provenance).unwrap()).unwrap();
            let found = faults_of(&read);
            assert!(found.is_empty(), "{name}:\n{}", found.join("\n"));
        }
    }
}

#[test]
fn a_key_that_is_not_in_the_schema_or_missing_or_of_another_kind_is_found() {
    let good = summary::summary(shipped(), &provenance());
    let with = |change: &dyn Fn(&mut Value)| {
        let mut changed = good.clone();
        change(&mut changed);
        faults_of(&changed)
    };
    assert!(with(&|v| v["runs"][0]["new_key"] = 1.into())[0].contains("new_key"));
    assert!(with(&|v| drop(v["runs"][3].as_object_mut().unwrap().remove("p_mm")))[0].contains("p_mm"));
    assert!(!with(&|v| v["runs"][0]["p_mm"] = "131".into()).is_empty());
    assert!(!with(&|v| v["date"] = "yesterday".into()).is_empty());
    assert!(!with(&|v| v["regressions"][0]["terms"][0]["p"] = Value::Bool(true)).is_empty());
}
