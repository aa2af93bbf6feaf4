//! `hemline check` as continuous integration runs it: small campaigns, sound and broken in each way.
//!
//! Twelve outlines of known p in a 2² × 3 design. The scatter of p within the four cells is laid out by hand, so that every verdict follows from
//! it; 0.2 mm of scatter in the points gives each fit an honest standard error.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use hemline::model::hem::{Hem, Placement};
use hemline::units::MILLIMETRE;
use serde_json::Value;
use tempfile::TempDir;

/// Scatter of p, mm, of the three runs of each cell; sums to 0 in each cell, with alike variances (1.17, 0.76, 1.03, 1.29), no trend, no tails.
const SOUND: [[f64; 3]; 4] = [[-1.2, 0.3, 0.9], [0.6, -1.0, 0.4], [1.1, -0.2, -0.9], [-0.5, 1.3, -0.8]];

/// Coefficients of p, mm: 1, a, b, a:b.
const PLAIN: [f64; 4] = [150.0, 5.0, 3.0, 0.0];

/// A campaign to be written.
struct Trial {
    scatter: [[f64; 3]; 4],
    coefficients: [f64; 4],
    /// Id of each run where it is not 1 … 12.
    renamed: Vec<(usize, &'static str)>,
    responses: &'static str,
    /// A skirt of known cloth has predictions, a drape tester without cloth has none.
    cloth: bool,
    /// Further tables of campaign.toml.
    tables: String,
}

impl Default for Trial {
    fn default() -> Self {
        Trial { scatter: SOUND, coefficients: PLAIN, renamed: vec![], responses: "[\"p\"]", cloth: false, tables: String::new() }
    }
}

impl Trial {
    fn write(&self) -> TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        self.write_to(folder.path());
        folder
    }

    fn write_to(&self, folder: &Path) {
        let scene = if self.cloth {
            "apparatus = \"skirt\"\n[geometry]\nwaist_radius_cm = 12.1\nhem_radius_cm = 23.62\nslant_length_cm = 53.0\n\
[cloth]\nareal_density_g_m2 = 200.0\nflexural_rigidity_un_m = 10.0\n"
        } else {
            "apparatus = \"drapemeter\"\n[geometry]\nsupport_radius_cm = 9.0\nspecimen_radius_cm = 18.0\n"
        };
        let toml = format!(
            "title = \"Trial\"\norigin = \"made by tests/check.rs\"\n{scene}\
[[factors]]\nname = \"a\"\nlow = 1\nhigh = 2\n[[factors]]\nname = \"b\"\nlow = 1\nhigh = 2\n\
[analysis]\nresponses = {}\nfolds = 6\nhem_length = \"free\"\n{}",
            self.responses, self.tables
        );
        fs::write(folder.join("campaign.toml"), toml).expect("written");
        let mut design = String::from("run,replicate,a,b,profile\n");
        for run in 0..12 {
            let (replicate, cell) = (run / 4, run % 4);
            let (a, b) = ([-1.0, 1.0][cell & 1], [-1.0, 1.0][cell >> 1]);
            let [mean, of_a, of_b, of_ab] = self.coefficients;
            let p = mean + of_a * a + of_b * b + of_ab * a * b + self.scatter[cell][replicate];
            let id = self.renamed.iter().find(|(of, _)| *of == run + 1).map_or((run + 1).to_string(), |(_, id)| id.to_string());
            design += &format!("\"{}\",{},{a},{b},p{}.csv\n", id.replace('"', "\"\""), replicate + 1, run + 1);
            fs::write(folder.join(format!("p{}.csv", run + 1)), outline(run, p)).expect("written");
        }
        fs::write(folder.join("design.csv"), design).expect("written");
    }
}

/// Sixty points of a hem of six folds, p in mm, with up to 0.2 mm of scatter that is the same in every program.
fn outline(run: usize, p: f64) -> String {
    let hem = Hem { p: p * MILLIMETRE, q: 20.0 * MILLIMETRE, s: 2.0 * MILLIMETRE, folds: 6 };
    let mut state = run as u64 + 1;
    let mut noise = || {
        // Knuth's linear congruential generator (The Art of Computer Programming 2, section 3.3.4); its high bits.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        0.4 * ((state >> 33) as f64 / (1u64 << 31) as f64 - 0.5)
    };
    let points = hem.outline(&Placement { x0: 0.003, y0: -0.002, phase: 0.2 }, 60);
    let rows = points.iter().map(|point| format!("{},{}\n", point.x / MILLIMETRE + noise(), point.y / MILLIMETRE + noise()));
    format!("x_mm,y_mm\n{}", rows.collect::<String>())
}

/// What one call of `hemline check FOLDER --json --junit` gives.
struct Checked {
    code: i32,
    json: Value,
    junit: String,
    stderr: String,
}

fn hemline(folder: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hemline"));
    command.arg("check").arg(folder).args(more).env_remove("GITHUB_ACTIONS");
    command.output().expect("the program runs")
}

fn check(folder: &Path, more: &[&str]) -> Checked {
    let junit = folder.join("verdicts/check.xml");
    let path = junit.to_string_lossy().into_owned();
    let output = hemline(folder, &[more, &["--json", "--junit", &path]].concat());
    let stderr = String::from_utf8(output.stderr).expect("UTF-8");
    let json = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("no JSON ({e}); {stderr}"));
    let code = output.status.code().expect("no signal");
    Checked { code, json, junit: fs::read_to_string(junit).expect("a JUnit file"), stderr }
}

impl Checked {
    /// `(question, subject, status)` of everything that is neither held nor left unasked.
    fn faults(&self) -> Vec<(String, String, String)> {
        let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
        let subject = |value: &Value| value.as_object().map(|o| o.values().map(text).collect::<Vec<_>>().join(" ")).unwrap_or_default();
        let judgements = self.json["judgements"].as_array().expect("judgements");
        judgements
            .iter()
            .map(|j| (text(&j["question"]), subject(&j["subject"]), text(&j["status"])))
            .filter(|(_, _, status)| status != "holds" && status != "not_asked")
            .collect()
    }

    fn status(&self, question: &str, subject: (&str, &str)) -> &str {
        self.one(question, subject)["status"].as_str().expect("a status")
    }

    fn one(&self, question: &str, (key, name): (&str, &str)) -> &Value {
        let judgements = self.json["judgements"].as_array().expect("judgements");
        let found = judgements.iter().find(|j| j["question"] == question && j["subject"][key] == name);
        found.unwrap_or_else(|| panic!("nothing was asked about {question} of {name}"))
    }

    fn finding(&self, question: &str, subject: (&str, &str)) -> &str {
        self.one(question, subject)["finding"].as_str().expect("a finding")
    }

    /// The numbers in the head of the JUnit file agree with its cases and with the JSON.
    fn junit_agrees(&self) {
        let counts = &self.json["counts"];
        let count = |names: &[&str]| names.iter().map(|name| counts[*name].as_u64().expect("a count")).sum::<u64>();
        let (failures, errors) = (count(&["fails", "stale"]), count(&["unanswered"]));
        let skipped = count(&["expected", "not_asked"]);
        let tests = failures + errors + skipped + count(&["holds"]);
        let head = format!("tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\" skipped=\"{skipped}\"");
        assert!(self.junit.contains(&format!("<testsuites name=\"hemline check\" {head}>")), "{head} in\n{}", self.junit);
        let elements = |name: &str| self.junit.matches(&format!("<{name} ")).count() as u64;
        assert_eq!([elements("testcase"), elements("failure"), elements("error"), elements("skipped")], [tests, failures, errors, skipped]);
    }
}

const P: (&str, &str) = ("response", "p_mm");

#[test]
fn a_sound_campaign_holds() {
    let folder = Trial::default().write();
    let checked = check(folder.path(), &[]);
    assert_eq!((checked.code, checked.faults()), (0, vec![]), "{:#}", checked.json);
    assert_eq!((checked.json["conclusion"].as_str(), checked.json["exit_code"].as_u64()), (Some("holds"), Some(0)));
    // 12 fits and 4 tests of one response; theory and drift are not asked, and that is said.
    assert_eq!((checked.json["counts"]["holds"].as_u64(), checked.json["counts"]["not_asked"].as_u64()), (Some(16), Some(5)));
    checked.junit_agrees();
    let text = String::from_utf8(hemline(folder.path(), &[]).stdout).expect("UTF-8");
    assert!(text.contains("Holds: 16 hold.") && text.contains("sets no theory_rms_mm") && text.contains("give --baseline FILE"), "{text}");
}

#[test]
fn a_run_without_its_profile_fails() {
    let folder = Trial { renamed: vec![(5, "5 <&\"")], ..Trial::default() }.write();
    fs::remove_file(folder.path().join("p5.csv")).expect("removed");
    let checked = check(folder.path(), &[]);
    assert_eq!(checked.code, 1, "{:#}", checked.json);
    assert_eq!(checked.faults(), [("fitted".to_string(), "5 <&\"".to_string(), "fails".to_string())]);
    assert!(checked.finding("fitted", ("run", "5 <&\"")).contains("no such file"));
    assert!(checked.stderr.contains("set aside"));
    // The run's name is text, in XML too.
    assert!(checked.junit.contains("name=\"run 5 &lt;&amp;&quot;\""), "{}", checked.junit);
    checked.junit_agrees();
}

#[test]
fn a_run_without_a_row_fails_too() {
    let folder = Trial::default().write();
    let design = fs::read_to_string(folder.path().join("design.csv")).expect("read");
    let without: String = design.lines().filter(|line| !line.starts_with("\"7\"")).map(|line| format!("{line}\n")).collect();
    fs::write(folder.path().join("design.csv"), without).expect("written");
    let checked = check(folder.path(), &[]);
    assert_eq!((checked.code, checked.status("fitted", ("run", "7"))), (1, "fails"));
}

#[test]
fn cells_of_unequal_scatter_fail() {
    let mut scatter = SOUND;
    scatter[3] = scatter[3].map(|e| 12.0 * e);
    let folder = Trial { scatter, ..Trial::default() }.write();
    let checked = check(folder.path(), &[]);
    assert_eq!((checked.code, checked.status("reproducibility", P)), (1, "fails"));
    // The variances by hand: 144 · 1.29/(1.17 + 0.76 + 1.03 + 144 · 1.29); 0.2 mm on a point are 0.02 mm on p, 2 % of a cell's deviation.
    let g = checked.one("reproducibility", P)["statistic"].as_f64().expect("G");
    assert!((g - 185.76 / 188.72).abs() < 2e-3, "{g}");
    checked.junit_agrees();
}

#[test]
fn terms_too_small_alone_but_not_together_are_a_lack_of_fit() {
    // s² = 8.5/8, so s_b = 0.2976 and t = 2.21 for both b and a:b: below t(0.975; 8) = 2.306 each, and F = 2.21² = 4.88 above F(0.95; 2, 8) = 4.459.
    let small = 2.21 * (8.5_f64 / 8.0 / 12.0).sqrt();
    let folder = Trial { coefficients: [150.0, 5.0, small, small], ..Trial::default() }.write();
    let checked = check(folder.path(), &[]);
    assert_eq!((checked.code, checked.faults()), (1, vec![("adequacy".into(), "p_mm".into(), "fails".into())]), "{:#}", checked.json);
    assert!((checked.one("adequacy", P)["statistic"].as_f64().expect("F") - 4.88).abs() < 0.2);
}

#[test]
fn residuals_of_two_values_are_not_normal() {
    let scatter = [[2.0, -1.0, -1.0], [-1.0, 2.0, -1.0], [-1.0, -1.0, 2.0], [2.0, -1.0, -1.0]];
    let checked = check(Trial { scatter, ..Trial::default() }.write().path(), &[]);
    assert_eq!((checked.code, checked.status("normality", P), checked.status("reproducibility", P)), (1, "fails", "holds"));
}

#[test]
fn a_trend_in_run_order_fails() {
    let checked = check(Trial { scatter: [[-1.0, 0.0, 1.0]; 4], ..Trial::default() }.write().path(), &[]);
    assert_eq!((checked.code, checked.status("independence", P), checked.status("reproducibility", P)), (1, "fails", "holds"));
    // Two steps of 1 in squares of sum 8: d = 0.25.
    assert!((checked.one("independence", P)["statistic"].as_f64().expect("d") - 0.25).abs() < 0.02);
}

#[test]
fn without_replicates_the_tests_cannot_be_answered_and_that_is_loud() {
    let folder = Trial::default().write();
    let design = fs::read_to_string(folder.path().join("design.csv")).expect("read");
    fs::write(folder.path().join("design.csv"), design.lines().take(5).map(|line| format!("{line}\n")).collect::<String>())
        .expect("written");
    let checked = check(folder.path(), &[]);
    assert_eq!((checked.code, checked.json["conclusion"].as_str()), (2, Some("unanswered")));
    for question in ["reproducibility", "adequacy", "normality", "independence"] {
        assert_eq!(checked.status(question, P), "unanswered");
    }
    assert!(checked.finding("reproducibility", P).contains("no treatment was repeated"));
    checked.junit_agrees();
}

#[test]
fn a_response_that_no_run_has_cannot_be_answered() {
    // Without cloth there is no λ of the ruled shell.
    let folder = Trial { responses: "[\"p\", \"lambda_ruled\"]", ..Trial::default() }.write();
    let checked = check(folder.path(), &[]);
    assert_eq!((checked.code, checked.status("adequacy", ("response", "lambda_ruled_n"))), (2, "unanswered"));
    assert_eq!(checked.status("adequacy", P), "holds");
    // Not asked, it stands in nobody's way.
    Trial { responses: "[\"p\", \"lambda_ruled\"]", tables: "[check]\nresponses = [\"p_mm\"]\n".into(), ..Trial::default() }
        .write_to(folder.path());
    assert_eq!(check(folder.path(), &[]).code, 0);
}

#[test]
fn a_baseline_of_the_same_campaign_holds_and_one_that_moved_names_what_moved() {
    let folder = Trial::default().write();
    let baseline = folder.path().join("baseline.json").to_string_lossy().into_owned();
    let written = check(folder.path(), &["--baseline", &baseline, "--update-baseline"]);
    assert_eq!(written.code, 0);
    let same = check(folder.path(), &["--baseline", &baseline]);
    assert_eq!((same.code, same.faults()), (0, vec![]));
    // 4 coefficients, and p, q, s, m of 12 runs.
    let drifts = same.json["judgements"].as_array().expect("judgements").iter().filter(|j| j["question"] == "drift").count();
    assert_eq!(drifts, 4 + 12 * 4);

    // Run 3 (a low, b high, first replicate) grows by 0.4 mm: ten times the standard error of its fit (0.2 mm · √(2/60)/√3 ≈ 0.02 mm), a tenth of
    // that of the coefficients (0.4/12 = 0.033 mm against 0.3 mm).
    let mut scatter = SOUND;
    scatter[2][0] += 0.4;
    Trial { scatter, ..Trial::default() }.write_to(folder.path());
    let moved = check(folder.path(), &["--baseline", &baseline]);
    assert_eq!((moved.code, moved.faults()), (1, vec![("drift".into(), "p_mm 3".into(), "fails".into())]), "{:#}", moved.json);
    let drift = moved.json["judgements"].as_array().expect("judgements").iter().find(|j| j["status"] == "fails").expect("one").clone();
    let by = drift["moved_se"].as_f64().expect("a drift") * drift["se"].as_f64().expect("an error");
    assert!((by - 0.4).abs() < 1e-3 && drift["estimate"].as_f64() > drift["baseline"].as_f64(), "{drift:#}");
    moved.junit_agrees();

    // A limit that allows it, and a new baseline that has it.
    Trial { scatter, tables: "[check]\ndrift_standard_errors = 1000.0\n".into(), ..Trial::default() }.write_to(folder.path());
    assert_eq!(check(folder.path(), &["--baseline", &baseline]).code, 0);
    Trial { scatter, ..Trial::default() }.write_to(folder.path());
    assert_eq!(check(folder.path(), &["--baseline", &baseline, "--update-baseline"]).code, 0);
    assert_eq!(check(folder.path(), &["--baseline", &baseline]).code, 0);
}

#[test]
fn an_estimate_that_is_gone_fails_and_a_new_one_cannot_be_answered() {
    let folder = Trial::default().write();
    let baseline = folder.path().join("baseline.json");
    let path = baseline.to_string_lossy().into_owned();
    assert_eq!(check(folder.path(), &["--baseline", &path, "--update-baseline"]).code, 0);
    let text = fs::read_to_string(&baseline).expect("read");
    // Run 2 was not there when the baseline was written.
    let lines: Vec<&str> = text.lines().filter(|line| !line.contains("{\"run\":\"2\"")).collect();
    fs::write(&baseline, lines.join("\n")).expect("written");
    let newcomer = check(folder.path(), &["--baseline", &path]);
    assert_eq!(newcomer.code, 2);
    assert!(newcomer.finding("drift", ("run", "2")).contains("not in the baseline"));
    // And run 4 has lost its profile since.
    fs::write(&baseline, text).expect("written");
    fs::remove_file(folder.path().join("p4.csv")).expect("removed");
    let gone = check(folder.path(), &["--baseline", &path]);
    assert_eq!((gone.code, gone.status("drift", ("run", "4"))), (1, "fails"));
    assert!(gone.finding("drift", ("run", "4")).contains("does not exist any more"));
}

#[test]
fn a_baseline_that_cannot_be_used_is_no_answer_and_the_rest_is_still_checked() {
    let folder = Trial::default().write();
    let baseline = folder.path().join("baseline.json");
    let path = baseline.to_string_lossy().into_owned();
    let cases = [
        (None, "there is no such baseline"),
        (Some("{ \"schema\": \"hemline-base"), "row 1: this baseline is broken"),
        (Some("{ \"schema\": \"hemline-baseline-99\" }"), "of the kind “hemline-baseline-99”"),
        (Some("[1, 2]"), "it has no “schema”"),
        (Some("{\n\"schema\": \"hemline-baseline-1\",\n\"runs\": 3 }"), "row 3: this baseline is broken"),
    ];
    for (text, said) in cases {
        if let Some(text) = text {
            fs::write(&baseline, text).expect("written");
        }
        let checked = check(folder.path(), &["--baseline", &path]);
        let drift = checked.json["judgements"].as_array().expect("judgements").iter().find(|j| j["question"] == "drift").expect("drift");
        let finding = drift["finding"].as_str().unwrap_or_default();
        assert_eq!((checked.code, drift["status"].as_str()), (2, Some("unanswered")), "{text:?}");
        assert!(finding.contains(said) && finding.contains("--update-baseline"), "{finding}");
        assert_eq!(checked.json["counts"]["holds"].as_u64(), Some(16));
        checked.junit_agrees();
    }
}

#[test]
fn theory_further_off_than_the_limit_fails() {
    let limits = |rms: f64, folds: u32| format!("[check]\ntheory_rms_mm = {rms}\ntheory_fold_count_off = {folds}\n");
    let folder = Trial { cloth: true, tables: limits(0.5, 0), ..Trial::default() }.write();
    let strict = check(folder.path(), &[]);
    assert_eq!((strict.code, strict.status("theory_rms", ("run", "1"))), (1, "fails"), "{:#}", strict.json);
    let finding = strict.finding("theory_rms", ("run", "1"));
    assert!(finding.contains("mm off, limit 0.5 mm"), "{finding}");
    strict.junit_agrees();
    // No hem of this cut is half a metre from another one.
    Trial { cloth: true, tables: limits(500.0, 30), ..Trial::default() }.write_to(folder.path());
    let lenient = check(folder.path(), &[]);
    assert_eq!((lenient.code, lenient.json["counts"]["holds"].as_u64()), (0, Some(16 + 24)), "{:#}", lenient.json);
}

#[test]
fn theory_that_was_asked_for_and_is_not_there_is_no_answer() {
    let folder = Trial { tables: "[check]\ntheory_rms_mm = 10\n".into(), ..Trial::default() }.write();
    let checked = check(folder.path(), &[]);
    assert_eq!((checked.code, checked.status("theory_rms", ("run", "1"))), (2, "unanswered"), "{:#}", checked.json);
}

#[test]
fn an_expected_failure_is_accepted_with_its_reason_until_it_is_none() {
    let tables = "[[check.expected]]\ncheck = \"reproducibility\"\nresponses = [\"p\"]\nreason = \"cell four hangs over a seam\"\n";
    let mut scatter = SOUND;
    scatter[3] = scatter[3].map(|e| 12.0 * e);
    let folder = Trial { scatter, tables: format!("{tables}[check]\nresponses = [\"p\"]\nalpha = 0.001\n"), ..Trial::default() }.write();
    let accepted = check(folder.path(), &[]);
    assert_eq!(
        (accepted.code, accepted.faults()),
        (0, vec![("reproducibility".into(), "p_mm".into(), "expected".into())]),
        "{:#}",
        accepted.json
    );
    assert!(accepted.finding("reproducibility", P).contains("cell four hangs over a seam"));
    accepted.junit_agrees();

    Trial { tables: tables.into(), ..Trial::default() }.write_to(folder.path());
    let stale = check(folder.path(), &[]);
    assert_eq!((stale.code, stale.status("reproducibility", P)), (1, "stale"));
    assert!(stale.finding("reproducibility", P).contains("take that entry out"));
    stale.junit_agrees();
}

#[test]
fn slips_in_the_table_are_named_with_their_row_and_what_was_meant() {
    // The row of the slip, counted from the table's own first line.
    let slips = [
        ("[check]\ntheory_rms = 10\n", (2, "did you mean “theory_rms_mm”?")),
        ("[check]\ntheory_rms_mm = -1\n", (2, "it must be positive")),
        ("[check]\nalpha = 1.5\n", (2, "between 0 and 1")),
        ("[check]\nresponses = [\"q\"]\n", (2, "Known are “p”")),
        ("[[check.expected]]\ncheck = \"normalty\"\nresponses = [\"p\"]\nreason = \"r\"\n", (1, "did you mean “normality”?")),
        ("[[check.expected]]\ncheck = \"normality\"\nruns = [\"1\"]\nreason = \"r\"\n", (1, "is about responses")),
        ("[[check.expected]]\ncheck = \"fitted\"\nruns = [\"99\"]\nreason = \"r\"\n", (1, "there is no run “99”")),
        ("[[check.expected]]\ncheck = \"fitted\"\nruns = [\"1\"]\nreason = \" \"\n", (1, "“reason” is empty")),
        ("[[check.expected]]\ncheck = \"drift\"\nruns = [\"1\"]\nreason = \"r\"\n", (1, "--update-baseline")),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    for (table, (row, said)) in slips {
        Trial { tables: table.into(), ..Trial::default() }.write_to(folder.path());
        let text = fs::read_to_string(folder.path().join("campaign.toml")).expect("read");
        let row = format!("row {}:", text.lines().count() - table.lines().count() + row);
        let said = [row.as_str(), said];
        let checked = check(folder.path(), &[]);
        let error = checked.json["error"].as_str().unwrap_or_default();
        assert!(checked.code == 2 && said.iter().all(|word| error.contains(word)), "{table}{error}");
        assert!(checked.stderr.contains(error) && checked.junit.contains("<error message="));
    }
}

#[test]
fn failures_are_annotated_where_github_runs_it() {
    let mut scatter = SOUND;
    scatter[3] = scatter[3].map(|e| 12.0 * e);
    let folder = Trial { scatter, ..Trial::default() }.write();
    let run = |more: &[&str], on_github: bool| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hemline"));
        command.arg("check").arg(folder.path()).args(more).env_remove("GITHUB_ACTIONS");
        if on_github {
            command.env("GITHUB_ACTIONS", "true");
        }
        let output = command.output().expect("the program runs");
        (String::from_utf8(output.stdout).expect("UTF-8"), String::from_utf8(output.stderr).expect("UTF-8"))
    };
    let annotation = |text: &str| text.lines().find(|line| line.starts_with("::error file=")).map(String::from);
    let shown = annotation(&run(&[], true).0).expect("an annotation");
    assert!(shown.contains("campaign.toml,title=reproducibility fails::p_mm: Cochran G = 0.984"), "{shown}");
    assert_eq!(annotation(&run(&[], false).0), None);
    // JSON has stdout for itself.
    let (stdout, stderr) = run(&["--json"], true);
    assert!(serde_json::from_str::<Value>(&stdout).is_ok() && annotation(&stderr).is_some());
}
