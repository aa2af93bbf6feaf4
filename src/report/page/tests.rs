//! What holds for the page without a browser: its words, its data, and that nothing of a user's is markup.

use super::*;
use crate::report::sample;
use crate::units::MILLIMETRE;

#[test]
fn every_word_that_template_and_script_ask_for_is_there_and_none_is_left_over() {
    let script = SCRIPT.concat();
    let identifier = |rest: &str| -> String { rest.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect() };
    let mut asked: Vec<String> = PAGE.match_indices("{{word.").map(|(at, found)| identifier(&PAGE[at + found.len()..])).collect();
    asked.extend(script.match_indices("W.").map(|(at, found)| identifier(&script[at + found.len()..])));
    // Asked for by the name of their curve.
    asked.extend(["measured", "fitted", "predicted", "free", "whiskers"].map(String::from));
    for name in &asked {
        assert!(words::WORDS.iter().any(|(known, _)| known == name), "no word “{name}”");
    }
    for (name, _) in words::WORDS {
        assert!(asked.iter().any(|asked| asked == name), "“{name}” is never shown");
    }
}

#[test]
fn the_script_makes_no_words_of_its_own() {
    // Two words in a row within quotes are a sentence that no translator would find.
    for part in SCRIPT {
        for line in part.lines().filter(|line| !line.trim_start().starts_with("//") && !line.trim_start().starts_with("/*")) {
            for quoted in line.split('"').skip(1).step_by(2) {
                let prose = quoted.split(' ').filter(|word| 2 < word.len() && word.chars().all(char::is_alphabetic)).count();
                // Class names and selectors are not read by anybody.
                let known = ["scroll tall", "main > section"].contains(&quoted) || quoted.starts_with("input, select");
                assert!(prose < 2 || known, "“{quoted}” in: {line}");
            }
        }
    }
}

#[test]
fn data_never_end_the_element_that_holds_them() {
    let text = "</script><!-- & \u{2028}\u{2029} \u{1F9F5}";
    let safe = in_script(&json!({ text: text }).to_string());
    assert!(!safe.contains(['<', '>', '&', '\u{2028}', '\u{2029}']));
    let back: Value = serde_json::from_str(&safe).unwrap();
    assert_eq!(back[text], text);
    assert_eq!(escaped("<a href=\"x\" title='&'>"), "&lt;a href=&quot;x&quot; title=&#39;&amp;&#39;&gt;");
}

#[test]
fn what_fills_a_blank_is_not_filled_again() {
    assert_eq!(filled("a {{x}} b {{y}}", |name| format!("{{{{{name}}}}}")), "a {{x}} b {{y}}");
}

#[test]
fn curves_on_the_page_are_those_of_the_study_to_a_hundredth_of_a_millimetre() {
    let study = sample::study();
    let data = data(&study, &Provenance::default());
    let (run, shown) = (&study.runs[3], &data["runs"][3]["hem"]);
    let (profile, fit) = (run.profile.as_ref().unwrap(), run.fit.as_ref().unwrap());
    let step = run::Detail::of(study.runs.len()).step;
    let whole: Vec<i64> = serde_json::from_value(shown["measured"].clone()).unwrap();
    assert_eq!(whole.len(), 2 * profile.points().len());
    let (mut x, mut y) = (0, 0);
    for (i, point) in profile.points().iter().enumerate() {
        (x, y) = (x + whole[2 * i], y + whole[2 * i + 1]);
        // Half a step of rounding, which does not add up along the curve.
        assert!((x as f64 * step - point.x).abs() <= 0.5001 * step && (y as f64 * step - point.y).abs() <= 0.5001 * step);
    }
    let distances: Vec<i64> = serde_json::from_value(shown["distance"].clone()).unwrap();
    for (shown, distance) in distances.iter().zip(&fit.distances) {
        assert!((*shown as f64 * step - distance).abs() <= 0.5001 * step);
    }
    assert!((shown["rms"].as_f64().unwrap() - fit.rms / MILLIMETRE).abs() <= 0.00501);
    // Run 17 was set aside.
    let aside = study.runs.iter().position(|r| r.run.id == "17").unwrap();
    assert!(data["runs"][aside]["hem"].is_null() && data["runs"][aside]["surfaces"].as_array().unwrap().is_empty());
}

#[test]
fn the_page_says_what_the_printed_report_says() {
    let study = sample::study();
    let (data, summary) = (data(&study, &Provenance::default()), story::summary(&study));
    for (part, key) in data["summary"].as_array().unwrap().iter().zip(["measured", "found", "theory", "cautions"]) {
        let said: Vec<String> = summary[key].as_array().unwrap().iter().map(|s| here(s.as_str().unwrap())).collect();
        assert_eq!(part["items"], json!(said));
    }
    // Nothing of the page has an appendix.
    assert!(!data["summary"].to_string().contains("appendix") && !data["facts"].to_string().contains("appendix"));
    let quarantine = data["tables"].as_array().unwrap().iter().find(|t| t["id"] == "quarantine").unwrap();
    assert_eq!(quarantine["table"]["rows"].as_array().unwrap().len(), 1);
    assert_eq!(data["overview"]["rows"].as_array().unwrap().len(), 40);
    assert_eq!(data["responses"].as_array().unwrap().len(), 6);
}

#[test]
fn every_estimate_has_a_standard_error_or_the_reason_why_not() {
    let study = sample::study();
    let data = data(&study, &Provenance::default());
    for run in data["runs"].as_array().unwrap() {
        for row in run["numbers"]["rows"].as_array().unwrap() {
            let name = row[0].as_str().unwrap();
            if ["mean radius p", "fold amplitude q", "lean s", "centre x₀", "centre y₀", "phase φ"].contains(&name) {
                assert!(!row[3].is_null() || row[5].as_str().is_some_and(|why| why.contains("standard error")), "run {}: {row}", run["id"]);
            }
        }
    }
}

#[test]
fn every_word_of_the_page_is_said_in_russian_too() {
    let study = sample::study();
    let translator = Translator::strict(Language::Russian, crate::report::language::names(&study));
    for (_, word) in words::WORDS {
        translator.say(word);
    }
    assert!(translator.missing().is_empty(), "{:?}", translator.missing());
    let options = Options { language: Language::Russian, ..Options::default() };
    let page = html(&study, &options, &translator);
    assert!(page.starts_with("<!DOCTYPE html>\n<html lang=\"ru\">") && page.contains("\"decimal\":\",\""));
    // What a laboratory wrote stays as it is.
    assert!(page.contains(&study.campaign.title));
}
