//! A report in another language: finished English strings are matched against a catalogue of templates with holes, and said again.
//!
//! No code that builds a sentence knows of this. What a laboratory wrote itself (titles, labels, names of runs and files) is never touched.

mod catalogue;
mod matching;
mod number;
mod room;
mod svg;

use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap};

use serde_json::Value;

use crate::experiment::campaign::Language;
use crate::study::campaign::CampaignStudy;
use catalogue::Catalogue;

pub use svg::Measure;

/// Says strings in one language. The same string is always said alike.
pub struct Translator {
    catalogue: Option<&'static Catalogue>,
    /// What a laboratory wrote itself, verbatim.
    names: BTreeSet<String>,
    /// What was asked before; looked up only.
    known: RefCell<HashMap<String, Option<String>>>,
    missing: RefCell<BTreeSet<String>>,
    /// Whether a word that stayed English inside a translation counts as missing too.
    strict: bool,
}

impl Translator {
    /// A translator into `language` that leaves `names` as they are.
    pub fn new(language: Language, names: BTreeSet<String>) -> Self {
        let catalogue = match language {
            Language::English => None,
            Language::Russian => Some(Catalogue::russian()),
        };
        Translator { catalogue, names, known: RefCell::default(), missing: RefCell::default(), strict: false }
    }

    /// The same, but every translation is searched for words that stayed as they were; slower, for checks.
    pub fn strict(language: Language, names: BTreeSet<String>) -> Self {
        Translator { strict: true, ..Translator::new(language, names) }
    }

    /// The text in the language; unchanged, and remembered as [`missing`](Self::missing), where the catalogue does not have it.
    pub fn say(&self, text: &str) -> String {
        let Some(catalogue) = self.catalogue else { return text.to_string() };
        match matching::find(self, catalogue, text) {
            Some(said) => {
                if self.strict && !self.foreign_words(&said).is_empty() {
                    self.missing.borrow_mut().insert(text.to_string());
                }
                said
            }
            None => {
                self.missing.borrow_mut().insert(text.to_string());
                text.to_string()
            }
        }
    }

    /// The same for words with blanks in braces that a script fills: `{n} of {all}`.
    pub fn say_with_blanks(&self, words: &str) -> String {
        self.say(&words.replace('{', "‹").replace('}', "›")).replace('‹', "{").replace('›', "}")
    }

    /// Every string of a value, except below the keys in `keep`.
    pub fn value(&self, value: &mut Value, keep: &[&str]) {
        if self.catalogue.is_none() {
            return;
        }
        match value {
            Value::String(text) => *text = self.say(text),
            Value::Array(items) => items.iter_mut().for_each(|item| self.value(item, keep)),
            Value::Object(map) => {
                map.iter_mut().filter(|(key, _)| !keep.contains(&key.as_str())).for_each(|(_, item)| self.value(item, keep));
            }
            Value::Null | Value::Bool(_) | Value::Number(_) => (),
        }
    }

    /// The text elements of a figure; where longer words, by `measure`, have no room they are set narrower.
    pub fn svg(&self, figure: &str, measure: &dyn Measure) -> String {
        if self.catalogue.is_none() { figure.to_string() } else { svg::say(figure, &|text| self.say(text), measure) }
    }

    /// What was to be said and could not be, in order.
    pub fn missing(&self) -> Vec<String> {
        self.missing.borrow().iter().cloned().collect()
    }

    /// Words in Latin letters in a text that are neither a laboratory's own nor symbols that every language shares.
    pub fn foreign_words(&self, text: &str) -> Vec<String> {
        let Some(catalogue) = self.catalogue else { return vec![] };
        // ‹1›, ‹run›: places that a template or script fills; `scale_mm`: what is to be typed.
        let filled = |(i, part): (usize, &str)| {
            if i == 0 { part.to_string() } else { part.split_once('›').map_or(part, |(_, rest)| rest).to_string() }
        };
        let text = text.split('‹').enumerate().map(filled).collect::<Vec<_>>().join(" ");
        let text = text.split('`').step_by(2).collect::<Vec<_>>().join(" ");
        let reader = |word: &&str| !word.contains(".csv") && !word.contains('@') && !matching::is_identifier(word);
        let mut rest = text.split_whitespace().filter(reader).collect::<Vec<_>>().join(" ");
        let mut names: Vec<&String> = self.names.iter().filter(|name| name.chars().any(|c| c.is_ascii_alphabetic())).collect();
        names.sort_by_key(|name| std::cmp::Reverse(name.len()));
        for name in names {
            rest = rest.replace(name.as_str(), " ").replace(&matching::capitalized(name), " ");
        }
        matching::latin_words(&rest).filter(|word| !catalogue.symbols.contains(*word)).map(str::to_string).collect()
    }
}

/// Everything in a campaign that the laboratory wrote itself.
pub fn names(study: &CampaignStudy) -> BTreeSet<String> {
    let campaign = &study.campaign;
    let mut names = BTreeSet::new();
    let mut add = |name: &str| {
        if !name.trim().is_empty() {
            names.insert(name.to_string());
        }
    };
    add(&campaign.title);
    add(&campaign.origin);
    add(&campaign.folder.display().to_string());
    for factor in &campaign.design.factors {
        add(&factor.name);
        add(&factor.label);
    }
    for run in &campaign.design.runs {
        add(&run.id);
        run.block.iter().for_each(|block| add(block));
        add(&run.profile.display().to_string());
    }
    for aside in &study.quarantine {
        add(&aside.file.display().to_string());
        add(&aside.value);
        aside.sheet.iter().chain(&aside.run).for_each(|name| add(name));
    }
    for source in &study.sources {
        add(&source.file.display().to_string());
        add(&source.digest);
    }
    names
}

#[cfg(test)]
mod tests;
