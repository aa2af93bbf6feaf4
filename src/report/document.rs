//! The report as a document: what the template shows, in words and rounded numbers.

pub(super) mod beyond;
pub(super) mod cloth;
mod exhibits;
pub mod irregular;
pub(super) mod regression;
mod runs;
pub(super) mod story;
pub(super) mod theory;
mod words;

use serde_json::{Value, json};

use super::gallery::Gallery;
use super::language::Translator;
use super::number::plain;
use super::section::Section;
use super::typeset::Manuscript;
use super::{Options, Paper, Provenance, number};
use crate::experiment::campaign::{Folds, HemLength};
use crate::experiment::{Apparatus, Campaign};
use crate::study::campaign::CampaignStudy;
use crate::units::{CENTIMETRE, MILLIMETRE};

/// The document's markup; it reads `data.json`, `words.json`, `figures/*.svg` and the passages with formulas of its language.
const TEMPLATE: &str = include_str!("template/report.typ");

/// Passages that are more formula than word, one file a language.
const PROSE: [(&str, &str); 2] =
    [("prose-en.typ", include_str!("template/prose-en.typ")), ("prose-ru.typ", include_str!("template/prose-ru.typ"))];

/// Longest origin that the footer of every page can hold, in characters.
const FOOTER: usize = 200;

/// Keys of the data below which nothing is translated: the laboratory's own, and names of files.
const VERBATIM: [&str; 8] = ["title", "origin", "origin-short", "program", "date", "letterhead", "look", "sources"];

/// The report of a campaign, to be set, with the figures of its gallery, whose words are in the language already.
pub fn manuscript(study: &CampaignStudy, gallery: Gallery, options: &Options, translator: &Translator) -> Manuscript {
    let own = options.letterhead.own_template.as_deref();
    let template = own.unwrap_or(TEMPLATE);
    let mut manuscript = Manuscript { template: template.into(), date: options.provenance.date, ..Manuscript::default() };
    let mut file = |name: &str, bytes: Vec<u8>| drop(manuscript.files.insert(name.into(), bytes));
    file("data.json", data(study, &gallery, options, translator).to_string().into_bytes());
    file("words.json", words::said(template, translator).to_string().into_bytes());
    for (name, prose) in PROSE {
        file(name, prose.into());
    }
    if let Some(logo) = &options.letterhead.logo {
        file(&format!("logo.{}", logo.format), logo.bytes.clone());
    }
    for (stem, svg) in gallery {
        file(&format!("figures/{stem}.svg"), svg.into_bytes());
    }
    manuscript
}

/// Everything that a template shows, in the language of the report.
pub fn data(study: &CampaignStudy, gallery: &Gallery, options: &Options, translator: &Translator) -> Value {
    let mut data = english(study, gallery, options);
    translator.value(&mut data, &VERBATIM);
    data["sections"] = sections(&options.sections, translator);
    data
}

/// Says everything that the shipped template shows, for a translator that takes note of what it cannot say.
pub fn untranslated(study: &CampaignStudy, gallery: &Gallery, options: &Options, translator: &Translator) {
    data(study, gallery, options, translator);
    words::said(TEMPLATE, translator);
}

/// The chapters of studies; their figures are in the gallery.
fn sections(sections: &[Section], translator: &Translator) -> Value {
    let say = |text: &String| translator.say(text);
    let one = |section: &Section| {
        json!({
            "title": say(&section.title),
            "paragraphs": section.paragraphs.iter().map(say).collect::<Vec<_>>(),
            "tables": section.tables.iter().map(|table| json!({
                "caption": say(&table.caption),
                "columns": table.columns.iter().map(say).collect::<Vec<_>>(),
                "rows": table.rows.iter().map(|row| row.iter().map(say).collect::<Vec<_>>()).collect::<Vec<_>>(),
                "text-columns": table.text_columns,
            })).collect::<Vec<_>>(),
            "figures": section.figures.iter().map(|figure| json!({ "stem": figure.stem, "caption": say(&figure.caption) })).collect::<Vec<_>>(),
        })
    };
    sections.iter().map(one).collect()
}

fn english(study: &CampaignStudy, gallery: &Gallery, options: &Options) -> Value {
    let (campaign, provenance) = (&study.campaign, &options.provenance);
    let fidelity = study.runs.iter().find_map(|r| r.prediction.as_ref()).map_or("ruled shell", |p| p.fidelity.as_str());
    json!({
        "title": campaign.title,
        "origin": campaign.origin,
        "origin-short": shortened(&campaign.origin),
        "program": concat!("hemline ", env!("CARGO_PKG_VERSION")),
        "date": provenance.date.map(|d| d.to_string()),
        "look": {
            "language": options.language.code(),
            "paper": match options.paper {
                Paper::A4 => "a4",
                Paper::Letter => "us-letter",
            },
            "logo": options.letterhead.logo.as_ref().map(|logo| format!("logo.{}", logo.format)),
        },
        "letterhead": options.letterhead,
        "apparatus": apparatus(campaign.apparatus),
        "alpha": plain(campaign.alpha),
        "facts": facts(study, provenance),
        "summary": story::summary(study),
        "multiples": gallery.keys().filter(|stem| stem.starts_with("all_runs_")).collect::<Vec<_>>(),
        "regressions": study.regressions.iter().map(|r| regression::page(r, study, gallery)).collect::<Vec<_>>(),
        "beyond": beyond::chapter(study),
        "irregular": irregular::chapter(study, gallery),
        "exhibits": exhibits::exhibits(study, gallery),
        "theory": theory::chapter(study),
        "cloth": cloth::chapter(study),
        "theory-effects": beyond::theory(study),
        "runs": study.runs.iter().map(|r| runs::block(r, &campaign.design.factors, gallery)).collect::<Vec<_>>(),
        "fits": study.runs.iter().map(runs::row).collect::<Vec<_>>(),
        "lambda-name": if runs::has_cloth(study) { "λ, N/m²" } else { "λ/(ρg)" },
        "foundation": plain(campaign.foundation_modulus),
        "fidelity": fidelity,
        "quarantine": study.quarantine.iter().map(|q| json!([
            q.run.clone().unwrap_or_default(),
            q.sheet.iter().fold(q.file.display().to_string(), |file, sheet| format!("{file}, sheet “{sheet}”")),
            q.row.map(|r| r.to_string()).unwrap_or_default(),
            q.value,
            q.problem,
            q.remedy,
        ])).collect::<Vec<_>>(),
        "settings": provenance.settings.iter().map(|(k, v)| json!([k, v])).collect::<Vec<_>>(),
        "sources": study.sources.iter().map(|s| json!([s.file.display().to_string(), s.bytes.to_string(), s.digest])).collect::<Vec<_>>(),
    })
}

pub(super) fn apparatus(apparatus: Apparatus) -> &'static str {
    match apparatus {
        Apparatus::Skirt => "conic skirts",
        Apparatus::Drapemeter => "drape tester",
    }
}

/// The title page's table: what, how, from which files.
pub(super) fn facts(study: &CampaignStudy, provenance: &Provenance) -> Vec<[String; 2]> {
    let campaign = &study.campaign;
    let mut facts = vec![];
    let mut fact = |name: &str, value: String| facts.push([name.to_string(), value]);
    fact("Program", concat!("hemline ", env!("CARGO_PKG_VERSION")).into());
    if let Some(date) = provenance.date {
        fact("Date", date.to_string());
    }
    fact("Campaign folder", campaign.folder.display().to_string());
    let profiles = study.runs.iter().filter(|r| r.profile.is_some()).count();
    fact("Runs", format!("{}, {profiles} with a usable profile", study.runs.len()));
    for factor in &campaign.design.factors {
        let unit = factor.unit.as_deref().map(|u| format!(" {u}")).unwrap_or_default();
        let label = if factor.label == factor.name { String::new() } else { format!("{}: ", factor.label) };
        fact(&format!("Factor “{}”", factor.name), format!("{label}{} (−1), {} (+1){unit}", plain(factor.low), plain(factor.high)));
    }
    if let Some(cut) = cut(campaign) {
        fact("Cut", cut);
    }
    fact("Folds", folds(campaign.folds));
    fact("Hem length", hem_length(campaign.hem_length));
    fact("Bias of curvature", if campaign.bias_correction { "taken out of every fit".into() } else { "left in, as asked".into() });
    if let Some(prediction) = study.runs.iter().find_map(|run| run.prediction.as_ref()) {
        let compared = if study.fidelities.is_empty() { vec![prediction.fidelity.clone()] } else { crate::study::fidelities::described() };
        fact("Theory", compared.join("; "));
        let terms: Vec<&str> = prediction.terms.iter().map(|term| term.term).collect();
        fact("Energy terms", terms.join(", "));
    }
    fact("Gravity", format!("{} m/s²", plain(campaign.gravity)));
    fact("Significance level", plain(campaign.alpha));
    match study.sources.as_slice() {
        [] => (),
        sources => {
            let bytes: u64 = sources.iter().map(|s| s.bytes).sum();
            let first: Vec<String> = sources.iter().take(2).map(|s| format!("{} {}", s.file.display(), s.digest)).collect();
            fact("Inputs", format!("{} files, {bytes} bytes; {}; all digests in the appendix", sources.len(), first.join("; ")));
        }
    }
    facts
}

/// The dimensions that all runs share, and that some do not.
fn cut(campaign: &Campaign) -> Option<String> {
    let skirts: Vec<_> = campaign.design.runs.iter().filter_map(|r| r.skirt).collect();
    let first = skirts.first()?;
    let said = |name: &str, pick: fn(&crate::experiment::Skirt) -> f64| {
        let value = pick(first) / CENTIMETRE;
        let alike = skirts.iter().all(|s| pick(s) == pick(first));
        if alike { format!("{name} {} cm", plain(value)) } else { format!("{name} as each run has it") }
    };
    let parts = [
        said(if campaign.apparatus == Apparatus::Drapemeter { "support radius" } else { "waist radius" }, |s| s.waist_radius().0),
        said(if campaign.apparatus == Apparatus::Drapemeter { "specimen radius" } else { "hem radius" }, |s| s.hem_radius().0),
        said("slant length", |s| s.slant_length().0),
    ];
    Some(parts.join(", "))
}

fn folds(folds: Folds) -> String {
    match folds {
        Folds::Among { from, to } => format!("by weight of evidence among {from}…{to}"),
        Folds::Exactly(m) => format!("given: {m}"),
    }
}

fn hem_length(length: HemLength) -> String {
    match length {
        HemLength::Auto => "free; held at the outline’s length where the free optimum is no sane curve".into(),
        HemLength::Free => "free".into(),
        HemLength::Held(m) => format!("held at {} mm", number::fixed(m / MILLIMETRE, 1)),
    }
}

/// The first sentence where the whole is too long for a footer, and at most as much as fits.
fn shortened(origin: &str) -> String {
    if origin.chars().count() <= FOOTER {
        return origin.to_string();
    }
    let sentence = origin.split_inclusive(". ").next().unwrap_or(origin).trim();
    if sentence.chars().count() <= FOOTER {
        return sentence.to_string();
    }
    let cut: String = sentence.chars().take(FOOTER - 1).collect();
    format!("{}…", cut.trim_end())
}
