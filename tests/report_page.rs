//! `report.html` as a reader meets it: used in headless Chromium where one is installed, read as text everywhere.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use hemline::experiment::campaign::Language;
use hemline::import;
use hemline::model::field::Field;
use hemline::report::language::{Translator, names};
use hemline::report::{Date, Options, Provenance, page};
use hemline::study::campaign::{CampaignStudy, Measured, analyse};
use hemline::study::{draped, surface};
use serde_json::Value;

/// Text that would act if any of it were parsed as markup or script.
const HOSTILE: &str = "</script><img src=x onerror=\"window.faults.push('injected')\"><!--<script>'\"&amp;\u{2028}{{data}}";

/// The shipped campaign, analysed once for all tests.
static SHIPPED: LazyLock<CampaignStudy> = LazyLock::new(|| {
    let imported = import::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data")).expect("the shipped campaign");
    let import::Imported { campaign, profiles, quarantine, sources, notes, .. } = imported;
    analyse(Measured { campaign, profiles, quarantine, sources, notes }, &|| ())
});

fn provenance() -> Provenance {
    Provenance { settings: vec![("Fold count".into(), "by evidence".into())], date: Some(Date::from_epoch(1_709_251_199)) }
}

/// The page in English.
fn english(study: &CampaignStudy) -> String {
    let options = Options { provenance: provenance(), ..Options::default() };
    page::html(study, &options, &Translator::new(Language::English, names(study)))
}

/// A run without a fit, without cloth, without anything, and hostile text wherever a user can write.
fn hostile() -> CampaignStudy {
    let mut study = SHIPPED.clone();
    study.runs.truncate(6);
    study.campaign.design.runs.truncate(6);
    study.regressions.truncate(2);
    for regression in &mut study.regressions {
        regression.analysis = Err(HOSTILE.into());
        regression.further = Err(HOSTILE.into());
    }
    study.fidelities.clear();
    study.campaign.title = HOSTILE.into();
    study.campaign.origin = HOSTILE.into();
    study.notes = vec![HOSTILE.into()];
    for factor in &mut study.campaign.design.factors {
        (factor.name, factor.label, factor.unit) = (HOSTILE.into(), HOSTILE.into(), Some(HOSTILE.into()));
    }
    for source in &mut study.sources {
        source.file = PathBuf::from(HOSTILE);
    }
    study.runs[1].run.id = format!("{HOSTILE} 2");
    if let Ok(fit) = &mut study.runs[1].fit {
        fit.notes = vec![HOSTILE.into()];
    }
    // No cloth, then no cut, no fit, no profile.
    study.runs[2].run.fabric.flexural_rigidity = None;
    study.runs[3].run.skirt = None;
    for i in [2, 3, 4, 5] {
        let run = &mut study.runs[i];
        (run.prediction, run.prediction_at_fitted_folds, run.comparison) = (None, None, None);
        run.prediction_missing = Some(HOSTILE.into());
    }
    for i in [4, 5] {
        study.runs[i].fit = Err(HOSTILE.into());
        (study.runs[i].irregular, study.runs[i].lambda) = (None, Default::default());
    }
    study.runs[5].profile = None;
    study
}

/// One run alone, of a campaign that regressed nothing.
fn single() -> CampaignStudy {
    let mut study = SHIPPED.clone();
    study.runs.truncate(1);
    study.campaign.design.runs.truncate(1);
    study.campaign.design.factors.clear();
    study.runs[0].run.levels.clear();
    study.regressions.clear();
    study.fidelities.clear();
    study
}

/// The embedded data of a page.
fn embedded(page: &str) -> Value {
    let json = page.split_once("id=\"data\">").and_then(|(_, rest)| rest.split_once("</script>")).expect("the data element").0;
    serde_json::from_str(json).expect("the data are JSON")
}

#[test]
fn the_page_needs_nothing_but_itself() {
    let html = english(&SHIPPED);
    assert!(html.len() < 2_000_000, "{} bytes", html.len());
    // The one address is the name of a vocabulary, which no browser fetches.
    assert_eq!(html.matches("://").count(), html.matches("http://www.w3.org/2000/svg").count());
    for attribute in ["src=", "href="] {
        for (at, _) in html.match_indices(attribute) {
            let value = &html[at + attribute.len()..at + attribute.len() + 12];
            assert!(value.starts_with("\"#") || value.starts_with("\"data:,\""), "{attribute}{value}");
        }
    }
    for word in ["@import", "url(", "fetch(", "XMLHttpRequest", "import(", "innerHTML", "insertAdjacentHTML", "document.write", "eval("] {
        // A clip path within a drawing is named by url(#…).
        assert_eq!(html.matches(word).count(), html.matches(&format!("{word}#")).count(), "{word}");
    }
    assert!(html.contains("default-src 'none'"));
    assert_eq!(embedded(&html)["runs"].as_array().unwrap().len(), 40);
}

#[test]
fn a_page_of_six_hundred_runs_stays_below_ten_megabytes_and_says_what_it_leaves_out() {
    let mut study = SHIPPED.clone();
    for copy in 1..15 {
        for original in &SHIPPED.runs {
            let mut run = original.clone();
            run.run.id = format!("{}-{copy}", run.run.id);
            for row in SHIPPED.identified.iter().filter(|row| row.run == original.run.id) {
                let mut row = row.clone();
                row.run.clone_from(&run.run.id);
                study.identified.push(row);
            }
            for row in SHIPPED.fidelities.iter().filter(|row| row.run == original.run.id) {
                let mut row = row.clone();
                row.run.clone_from(&run.run.id);
                study.fidelities.push(row);
            }
            study.campaign.design.runs.push(run.run.clone());
            study.runs.push(run);
        }
    }
    let html = english(&study);
    println!("600 runs: {} bytes", html.len());
    assert!(html.len() < 10_000_000, "{} bytes", html.len());
    let data = embedded(&html);
    assert_eq!(data["runs"].as_array().unwrap().len(), 600);
    assert!(data["facts"].to_string().contains("candidates.csv"), "{}", data["facts"]);
    assert!(data["tables"].as_array().unwrap().iter().all(|table| table["id"] != "candidates"));
    // One of forty shows everything and says nothing of it.
    let all = embedded(&english(&SHIPPED));
    assert!(!all["facts"].to_string().contains("candidates.csv"));
    assert!(all["tables"].as_array().unwrap().iter().any(|table| table["id"] == "candidates"));
}

#[test]
fn the_page_has_the_rigidity_that_every_hem_tells() {
    let data = embedded(&english(&SHIPPED));
    let parts = data["theory"]["parts"].as_array().unwrap();
    let cloth = parts.iter().find(|part| part["title"] == "Cloth from its drape").unwrap();
    let rows = cloth["table"]["rows"].as_array().unwrap();
    assert_eq!(rows.len(), SHIPPED.runs.len());
    let first = SHIPPED.identified.iter().find(|row| row.found.is_ok()).unwrap();
    let (found, row) = (first.found.as_ref().unwrap(), rows.iter().find(|row| row[0] == first.run.as_str()).unwrap());
    let column = if first.through.name() == "graded" { 2 } else { 6 };
    let shown = row[column][1].as_f64().unwrap();
    // Three digits are shown, in µN·m.
    assert!((shown / (1e6 * found.rigidity.value) - 1.0).abs() < 0.005, "{row}");
    let table = data["tables"].as_array().unwrap().iter().find(|table| table["id"] == "identify").unwrap();
    assert_eq!(table["table"]["rows"].as_array().unwrap().len(), SHIPPED.identified.len());
}

#[test]
fn the_same_study_gives_the_same_bytes() {
    assert!(english(&SHIPPED) == english(&SHIPPED));
}

#[test]
fn what_a_user_wrote_is_never_markup() {
    let study = hostile();
    let html = english(&study);
    assert!(!html.contains("<img") && !html.contains("<!--<script"));
    assert_eq!(html.matches("</script>").count(), 2, "the data and the program, and nothing that ends them early");
    let data = embedded(&html);
    assert_eq!(data["runs"][1]["id"], study.runs[1].run.id, "text arrives as it was written");
    let notes = data["runs"][1]["notes"].to_string();
    assert!(notes.contains("onerror"), "{notes}");
}

/// Chromium by one of its names, if it is on the path.
fn browser() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    std::env::split_paths(&path).flat_map(|folder| names.map(|name| folder.join(name))).find(|program| program.is_file())
}

/// What the probe saw on the page of a study; `None` without a browser.
fn used(study: &CampaignStudy, size: &str) -> Option<Value> {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium on the path, so the page was not used in a browser");
        return None;
    };
    let folder = tempfile::tempdir().unwrap();
    let html = english(study);
    let nonce = html.split_once("nonce-").and_then(|(_, rest)| rest.split_once('\'')).unwrap().0;
    // Faults are collected from the first line on; the probe comes last.
    let watch = "window.faults = [];\
        addEventListener('error', (event) => faults.push(event.message));\
        addEventListener('unhandledrejection', (event) => faults.push(String(event.reason)));\
        addEventListener('securitypolicyviolation', (event) => faults.push('policy: ' + event.violatedDirective));\
        for (const level of ['error', 'warn']) console[level] = (...said) => faults.push(said.join(' '));";
    let probe = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/report_page_probe.js")).unwrap();
    let html = html.replacen("<meta charset=\"utf-8\">", &format!("<meta charset=\"utf-8\"><script nonce=\"{nonce}\">{watch}</script>"), 1);
    let end = html.rfind("</body>").unwrap();
    let html = format!("{}<script nonce=\"{nonce}\">{probe}</script>{}", &html[..end], &html[end..]);
    let file = folder.path().join("report.html");
    fs::write(&file, html).unwrap();
    let dom = folder.path().join("dom.html");
    let mut child = Command::new(browser)
        .args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--no-first-run",
            "--virtual-time-budget=10000",
        ])
        .args([
            format!("--user-data-dir={}", folder.path().join("profile").display()),
            format!("--window-size={size}"),
            "--dump-dom".into(),
        ])
        .arg(format!("file://{}", file.display()))
        .stdout(fs::File::create(&dom).unwrap())
        .stderr(Stdio::null())
        .spawn()
        .expect("Chromium starts");
    // A browser that hangs is a fault, not a reason to wait for ever.
    let patience = Instant::now() + Duration::from_secs(180);
    while child.try_wait().unwrap().is_none() {
        if patience < Instant::now() {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("Chromium did not end");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let dom = String::from_utf8_lossy(&fs::read(dom).unwrap()).into_owned();
    let seen = dom.split_once("<pre id=\"probe\">").and_then(|(_, rest)| rest.split_once("</pre>")).map(|(json, _)| json.to_string());
    let seen = seen.unwrap_or_else(|| panic!("the probe saw nothing: {}", &dom.chars().take(400).collect::<String>()));
    Some(serde_json::from_str(&seen).unwrap())
}

fn texts(value: &Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect()
}

#[test]
fn a_reader_gets_about_the_shipped_campaign_by_mouse_and_by_keyboard() {
    let Some(seen) = used(&SHIPPED, "1400,1000") else { return };
    assert_eq!(seen["faults"], Value::Array(vec![]), "nothing may go wrong in the browser");
    let ids: Vec<&str> = SHIPPED.runs.iter().map(|run| run.run.id.as_str()).collect();
    assert_eq!(texts(&seen["runs"]), ids);
    assert_eq!(seen["heading"], SHIPPED.campaign.title.as_str());
    assert_eq!(seen["first"], ids[0]);
    assert!(5 < seen["summary"].as_u64().unwrap());

    // A click, Enter, arrow keys, buttons and the list switch the run; the address keeps it.
    assert_eq!((&seen["clicked"]["run"], &seen["clicked"]["head"]), (&ids[2].into(), &format!("Run {}", ids[2]).into()));
    assert_eq!((&seen["clicked"]["hash"], &seen["clicked"]["marked"]), (&format!("#run={}", ids[2]).into(), &1.into()));
    assert_eq!(
        [&seen["entered"], &seen["right"], &seen["left"], &seen["next"], &seen["selected"]],
        [ids[3], ids[4], ids[3], ids[4], ids[0]]
    );
    assert_eq!((&seen["hashed"], seen["jumped"].is_string()), (&ids[39].into(), true));

    // Sorting by a column of numbers is by number, and is told.
    let numbers = |sorted: &Value| -> Vec<f64> { texts(&sorted["values"]).iter().map(|text| text.parse().unwrap()).collect() };
    let (up, down) = (numbers(&seen["ascending"]), numbers(&seen["descending"]));
    assert!(up.is_sorted() && down.is_sorted_by(|a, b| b <= a) && up[0] < up[39], "{up:?}");
    assert_eq!((&seen["ascending"]["state"], &seen["descending"]["state"]), (&"ascending".into(), &"descending".into()));
    assert_ne!(texts(&seen["ascending"]["runs"]), ids);
    assert_eq!([&seen["nothing"], &seen["filtered"], &seen["unfiltered"]], [0, 20, 40]);

    // Curves, hover, toggles, whiskers.
    assert_eq!(seen["curves"], serde_json::json!([1, 1, 1]));
    for said in ["hover", "stepped"] {
        let text = seen[said].as_str().unwrap();
        assert!(text.contains("mm") && text.contains('°') && text.contains("from the fitted curve"), "{text}");
    }
    assert_ne!(seen["hover"], seen["stepped"]);
    assert_eq!((&seen["untoggled"], &seen["magnified"]), (&0.into(), &true.into()));

    // The skirt is painted, turns, and has its fields.
    assert!(1000 < seen["faces"].as_u64().unwrap() && 0.02 < seen["painted"].as_f64().unwrap() && seen["turned"] == true, "{seen}");
    assert_eq!(seen["field_options"], serde_json::json!([2, 4]));

    assert_eq!(seen["responses"], SHIPPED.regressions.len());
    // Eight terms: seven bars beside the mean.
    assert_eq!((&seen["response"]["head"], &seen["response"]["bars"]), (&seen["response"]["name"], &7.into()));
    assert_ne!(seen["response_key"], seen["response"]["head"]);
    // On paper nothing can be switched: all responses and the short tables are there, and gone again afterwards.
    let paper = &seen["paper"];
    assert_eq!([&paper["before"], &paper["after"], &paper["left"]], [0, 0, 0]);
    assert!(4 < paper["open"].as_u64().unwrap() && paper["responses"] == SHIPPED.regressions.len() - 1, "{paper}");
    assert!(seen["tip"].as_str().unwrap().contains("predicted"));
    assert!(10 < seen["tables"].as_u64().unwrap() && seen["table_rows"].as_array().unwrap().iter().all(|n| 0 < n.as_u64().unwrap()));
    assert_eq!((&seen["unnamed"], &seen["foreign"]), (&0.into(), &4.into()), "every control has a name; two scripts are this test's own");
    assert!(seen["wide"].as_i64().unwrap() <= 0, "the page scrolls sideways by {} px", seen["wide"]);
}

#[test]
fn hostile_text_is_shown_and_never_runs_and_every_run_has_a_view() {
    let study = hostile();
    let Some(seen) = used(&study, "700,900") else { return };
    assert_eq!(seen["faults"], Value::Array(vec![]));
    assert_eq!((&seen["images"], &seen["foreign"]), (&0.into(), &4.into()));
    assert_eq!(seen["heading"], HOSTILE);
    assert_eq!(texts(&seen["runs"])[1], study.runs[1].run.id);
    // The last run has no profile: no chart of it is left from another run.
    assert_eq!(seen["hashed"], study.runs[5].run.id.as_str());
    assert_eq!(seen["responses"], 2);
}

#[test]
fn one_run_alone_has_a_page() {
    let Some(seen) = used(&single(), "1000,900") else { return };
    assert_eq!(seen["faults"], Value::Array(vec![]));
    assert_eq!((seen["runs"].as_array().unwrap().len(), &seen["plan"], &seen["responses"]), (1, &1.into(), &0.into()));
    assert!(1000 < seen["faces"].as_u64().unwrap());
}

#[test]
fn stress_of_the_page_is_that_of_exported_surfaces() {
    let greatest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let mut compared = 0;
    for run in &SHIPPED.runs {
        let (Ok(fit), Some(skirt)) = (&run.fit, &run.run.skirt) else { continue };
        let sheet = surface::assumed_sheet(&run.run.fabric, SHIPPED.campaign.gravity);
        for drawn in draped::draped(run, SHIPPED.campaign.gravity, &draped::Options::default()) {
            let faces = drawn.round - 1;
            // An exported surface has as many columns in either half of a fold.
            if faces % 2 != 0 {
                continue;
            }
            let options = surface::Options { rows: drawn.down, columns: faces * drawn.copies as usize };
            let exported = match drawn.hem_of {
                draped::HemOf::Fit => surface::of_fit(skirt, fit, surface::Form::Linear, &sheet, &options),
                draped::HemOf::Theory => surface::of_prediction(skirt, run.prediction_at_fitted_folds.as_ref().unwrap(), &sheet, &options),
            };
            let exported = exported.unwrap();
            let shown = drawn.fields.iter().find(|f| f.quantity == draped::Quantity::StressIntensity).unwrap();
            let (shown, exported) = (greatest(&shown.values), greatest(exported.values(Field::StressIntensity).unwrap()));
            // The page takes derivatives of the theory's hem by differences of fourth order, and its columns may miss a crest by half a 240th of a fold.
            assert!((shown / exported - 1.0).abs() < 1e-2, "run {}, {:?}: {shown} {exported}", run.run.id, drawn.hem_of);
            compared += 1;
        }
    }
    assert!(40 < compared, "{compared}");
}
