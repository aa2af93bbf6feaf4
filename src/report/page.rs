//! The report as one page for a browser: `report.html`, which needs nothing but itself.
//!
//! The script only draws: every number, and every word, comes from here in one JSON element. User text (titles, run ids, file names, notes) reaches
//! the page in that element or escaped, and the script makes text nodes of it, so that nothing a user wrote is ever parsed as markup.

mod heading;
mod overview;
mod packed;
mod response;
mod run;
mod shared;
mod surface;
mod table;
mod tables;
mod theory;
mod words;

#[cfg(test)]
mod tests;

use serde_json::{Value, json};

use super::document::{self, beyond, irregular, story};
use super::language::Translator;
use super::{Options, Provenance, gallery};
use crate::experiment::campaign::Language;
use crate::study::campaign::CampaignStudy;
use crate::units::MILLIMETRE;

const PAGE: &str = include_str!("template/page/page.html");
const STYLE: &str = include_str!("template/page/page.css");
/// The parts of the script; each uses those before it.
const SCRIPT: [&str; 8] = [
    include_str!("template/page/core.js"),
    include_str!("template/page/table.js"),
    include_str!("template/page/overview.js"),
    include_str!("template/page/hem.js"),
    include_str!("template/page/skirt.js"),
    include_str!("template/page/regression.js"),
    include_str!("template/page/theory.js"),
    include_str!("template/page/main.js"),
];
const PROGRAM: &str = concat!("hemline ", env!("CARGO_PKG_VERSION"));

/// Keys below which nothing is translated: names for the script, the language and its decimal sign.
const VERBATIM: [&str; 4] = ["id", "key", "language", "decimal"];

/// The page of a campaign, in the language of its options.
pub fn html(study: &CampaignStudy, options: &Options, translator: &Translator) -> String {
    let provenance = &options.provenance;
    let mut shown = data(study, provenance);
    shown["language"] = json!(options.language.code());
    shown["decimal"] = json!(if options.language == Language::English { "." } else { "," });
    translator.value(&mut shown, &VERBATIM);
    shared::shared(&mut shown);
    let data = in_script(&shown.to_string());
    let nonce = digest(&data);
    let date = provenance.date.map(|date| format!(" · {date}")).unwrap_or_default();
    let text = |value: &Value| escaped(value.as_str().unwrap_or_else(|| panic!("the template asks for a text that is {value}")));
    let blank = |name: &str| -> String {
        match name {
            "nonce" => nonce.clone(),
            "program" => PROGRAM.into(),
            "title" => escaped(&study.campaign.title),
            "origin" => escaped(&study.campaign.origin),
            "footer" => format!("{PROGRAM}{date}"),
            "style" => STYLE.into(),
            "script" => format!("\"use strict\";\n(() => {{\n{}}})();", SCRIPT.concat()),
            "data" => data.clone(),
            "language" | "apparatus" => text(&shown[name]),
            _ => text(&shown["words"][name.strip_prefix("word.").unwrap_or(name)]),
        }
    };
    filled(PAGE, blank)
}

/// `{{name}}` in the template replaced; what replaces it is not looked at again.
fn filled(template: &str, blank: impl Fn(&str) -> String) -> String {
    let mut out = String::with_capacity(template.len());
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, after) = after.split_once("}}").expect("every blank of the template ends");
        out.push_str(before);
        out.push_str(&blank(name));
        rest = after;
    }
    out + rest
}

/// Text as markup shows it.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;").replace('\'', "&#39;")
}

/// JSON that no parser of markup takes for markup: nothing in it ends the element that holds it.
fn in_script(json: &str) -> String {
    let mut out = String::with_capacity(json.len() + json.len() / 50);
    for c in json.chars() {
        match c {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => out.push_str(&format!("\\u{:04x}", c as u32)),
            _ => out.push(c),
        }
    }
    out
}

/// FNV-1a of the data, hex: names the script that may run. It differs from page to page and is the same for the same page.
fn digest(text: &str) -> String {
    let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    format!("{hash:016x}")
}

/// A sentence of the printed report whose pointer to another place of it points to that of the page.
fn here(sentence: &str) -> String {
    PLACES.iter().fold(sentence.to_string(), |said, (printed, shown)| said.replace(printed, shown))
}

const PLACES: [(&str, &str); 2] = [
    ("the chapter before the appendix says", "the table “Set aside” below says"),
    ("all digests in the appendix", "all digests in the table “Inputs” below"),
];

/// Everything that the page shows, in English; a translator has all its strings here.
fn data(study: &CampaignStudy, provenance: &Provenance) -> Value {
    let said: serde_json::Map<String, Value> = words::WORDS.iter().map(|(name, word)| (name.to_string(), json!(word))).collect();
    let summary = story::summary(study);
    let sentences = |key: &str| summary[key].as_array().into_iter().flatten().filter_map(Value::as_str).map(here).collect::<Vec<_>>();
    let part = |title: &str, key: &str| json!({ "title": title, "items": sentences(key) });
    let detail = run::Detail::of(study.runs.len());
    let facts = document::facts(study, provenance).into_iter().map(|[name, value]| [name, here(&value)]);
    let facts: Vec<[String; 2]> = facts.chain(detail.said().map(|said| ["This page".into(), said])).collect();
    let scales = surface::scales(study, &detail.surface);
    let theory = theory::chapter(study);
    json!({
        "language": "en",
        "decimal": ".",
        "apparatus": document::apparatus(study.campaign.apparatus),
        "words": said,
        "step": detail.step / MILLIMETRE,
        "space_step": detail.coarse * surface::STEP / MILLIMETRE,
        "summary": [
            part("What was measured", "measured"),
            part("What was found", "found"),
            part("Theory against measurement", "theory"),
            part("Read with care", "cautions"),
        ],
        "verdicts": table::of_texts(&response::verdict_columns(), response::texts(&summary["verdicts"])),
        "facts": facts,
        "overview": overview::runs(study),
        "filters": overview::filters(study),
        "fields": scales.iter().map(surface::Scale::json).collect::<Vec<_>>(),
        "runs": study.runs.iter().map(|r| run::view(r, study, &detail)).collect::<Vec<_>>(),
        "irregular": run::irregular(study, &irregular::chapter(study, &gallery::Gallery::new())),
        "responses": study.regressions.iter().map(|r| response::page(r, study)).collect::<Vec<_>>(),
        "beyond": response::beyond(&beyond::chapter(study), study),
        "theory_missing": if theory.is_null() { document::theory::missing(study) } else { vec![] },
        "theory": theory,
        "tables": tables::all(study, provenance, detail.long_tables),
    })
}
