//! The catalogue as data: a text with English templates and what they are in another language.
//!
//! ```text
//! # a remark
//! @symbols p q s            words in Latin letters that are alike in both languages
//! @unit mm мм               a unit, after a number or alone
//! {i} of {i} hems           English; {x} is a hole of a kind below
//! = {1} {1:подол|подола|подолов} из {2}      a hole by number, and a noun that agrees with it
//! ```
//!
//! Holes: `{n}` a number as reports print it, `{i}` a count, `{w}` one of the laboratory's own names, `{u}` anything, kept as it is, `{f}` a unit,
//! `{t}` a text that the catalogue has, `{l}` several of those with commas between.

use std::collections::{BTreeSet, HashMap};
use std::sync::LazyLock;

/// What may stand in a hole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Number,
    Count,
    Name,
    Own,
    Unit,
    Text,
    List,
}

/// A piece of an English template.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Part {
    Words(String),
    Hole(Kind),
}

/// A piece of its translation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Piece {
    Words(String),
    /// What stood in a hole, counted from 0.
    Hole(usize),
    /// The form of a noun that follows the number in a hole.
    Noun(usize, [String; 3]),
}

/// One sentence, word or label.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Template {
    /// As the catalogue has it, for messages.
    pub english: String,
    pub parts: Vec<Part>,
    pub said: Vec<Piece>,
}

/// All of one language.
#[derive(Debug)]
pub struct Catalogue {
    /// Whole strings without holes.
    pub phrases: HashMap<String, String>,
    /// Templates with holes, those with most words of their own first.
    pub templates: Vec<Template>,
    pub units: HashMap<String, String>,
    pub symbols: BTreeSet<String>,
}

impl Catalogue {
    /// The shipped Russian one.
    pub fn russian() -> &'static Catalogue {
        static RUSSIAN: LazyLock<Catalogue> = LazyLock::new(|| {
            // A catalogue that cannot be read is our mistake, and a test reads it.
            RUSSIAN_TEXTS
                .iter()
                .try_fold(Catalogue::empty(), |all, (name, text)| all.with(name, text))
                .map(Catalogue::sorted)
                .unwrap_or_else(|e| panic!("{e}"))
        });
        &RUSSIAN
    }

    fn empty() -> Self {
        Catalogue { phrases: HashMap::new(), templates: vec![], units: HashMap::new(), symbols: BTreeSet::new() }
    }

    /// More of it; `name` is for messages.
    fn with(mut self, name: &str, text: &str) -> Result<Self, String> {
        let mut pending: Option<(usize, &str)> = None;
        for (i, line) in text.lines().enumerate() {
            let at = || format!("{name}, line {}", i + 1);
            let line = line.trim_end();
            if line.is_empty() || line.starts_with("# ") {
                continue;
            } else if let Some(words) = line.strip_prefix("@symbols ") {
                self.symbols.extend(words.split_whitespace().map(str::to_string));
            } else if let Some(unit) = line.strip_prefix("@unit ") {
                let (english, said) = unit.split_once(' ').ok_or_else(|| format!("{}: a unit without its translation", at()))?;
                self.units.insert(english.to_string(), said.to_string());
            } else if let Some(said) = line.strip_prefix("= ") {
                let (_, english) = pending.take().ok_or_else(|| format!("{}: a translation of nothing", at()))?;
                self.add(english, said).map_err(|why| format!("{}: {why}", at()))?;
            } else if let Some((_, english)) = pending.replace((i, line)) {
                return Err(format!("{}: “{english}” is not translated", at()));
            }
        }
        match pending {
            Some((_, english)) => Err(format!("{name}: “{english}” is not translated")),
            None => Ok(self),
        }
    }

    fn add(&mut self, english: &str, said: &str) -> Result<(), String> {
        let parts = parts(english)?;
        let holes = parts.iter().filter(|part| matches!(part, Part::Hole(_))).count();
        let said_pieces = pieces(said, holes)?;
        if holes == 0 {
            if self.phrases.insert(english.to_string(), said.to_string()).is_some() {
                return Err(format!("“{english}” stands there twice"));
            }
        } else {
            if self.templates.iter().any(|t| t.english == english) {
                return Err(format!("“{english}” stands there twice"));
            }
            self.templates.push(Template { english: english.to_string(), parts, said: said_pieces });
        }
        Ok(())
    }

    /// Templates that say most themselves are tried first; among equals the order of the catalogue.
    fn sorted(mut self) -> Self {
        self.templates.sort_by_key(|template| std::cmp::Reverse(template.own_letters()));
        self
    }
}

impl Template {
    fn own_letters(&self) -> usize {
        self.parts.iter().map(|part| if let Part::Words(words) = part { words.chars().count() } else { 0 }).sum()
    }
}

/// `“{i} of {i}”` in pieces.
fn parts(english: &str) -> Result<Vec<Part>, String> {
    let mut parts = vec![];
    let mut rest = english;
    while let Some(at) = rest.find('{') {
        let kind = rest[at + 1..].split_once('}').and_then(|(letter, _)| kind(letter));
        let Some(kind) = kind else { return Err(format!("“{rest}”: no such hole")) };
        if 0 < at {
            parts.push(Part::Words(rest[..at].to_string()));
        } else if matches!(parts.last(), Some(Part::Hole(_))) {
            return Err(format!("“{english}”: two holes without a word between"));
        }
        parts.push(Part::Hole(kind));
        rest = &rest[at + 3..];
    }
    if !rest.is_empty() {
        parts.push(Part::Words(rest.to_string()));
    }
    Ok(parts)
}

fn kind(letter: &str) -> Option<Kind> {
    Some(match letter {
        "n" => Kind::Number,
        "i" => Kind::Count,
        "w" => Kind::Name,
        "u" => Kind::Own,
        "f" => Kind::Unit,
        "t" => Kind::Text,
        "l" => Kind::List,
        _ => return None,
    })
}

/// `“{1} {1:складка|складки|складок}”` in pieces.
fn pieces(said: &str, holes: usize) -> Result<Vec<Piece>, String> {
    let mut pieces = vec![];
    let mut rest = said;
    while let Some(at) = rest.find('{') {
        let (inside, after) = rest[at + 1..].split_once('}').ok_or_else(|| format!("“{said}”: a hole that does not end"))?;
        if 0 < at {
            pieces.push(Piece::Words(rest[..at].to_string()));
        }
        let (number, forms) = inside.split_once(':').map_or((inside, None), |(number, forms)| (number, Some(forms)));
        let number =
            number.parse::<usize>().ok().filter(|n| (1..=holes).contains(n)).ok_or_else(|| format!("“{said}”: no hole {number}"))?;
        pieces.push(match forms {
            None => Piece::Hole(number - 1),
            Some(forms) => {
                let forms: Vec<String> = forms.split('|').map(str::to_string).collect();
                let forms = <[String; 3]>::try_from(forms).map_err(|_| format!("“{said}”: a noun has three forms"))?;
                Piece::Noun(number - 1, forms)
            }
        });
        rest = after;
    }
    if !rest.is_empty() {
        pieces.push(Piece::Words(rest.to_string()));
    }
    Ok(pieces)
}

/// The texts of the Russian catalogue, by subject.
const RUSSIAN_TEXTS: [(&str, &str); 8] = [
    ("russian/words.txt", include_str!("russian/words.txt")),
    ("russian/document.txt", include_str!("russian/document.txt")),
    ("russian/figures.txt", include_str!("russian/figures.txt")),
    ("russian/studies.txt", include_str!("russian/studies.txt")),
    ("russian/remarks.txt", include_str!("russian/remarks.txt")),
    ("russian/input.txt", include_str!("russian/input.txt")),
    ("russian/page.txt", include_str!("russian/page.txt")),
    ("russian/page_results.txt", include_str!("russian/page_results.txt")),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_catalogue_that_leaves_something_out_is_refused_with_its_line() {
        let with = |text: &str| Catalogue::empty().with("a.txt", text);
        assert!(with("One\n= Один\nTwo\nThree\n= Три\n").unwrap_err().contains("Two"));
        assert!(with("= Один\n").unwrap_err().contains("line 1"));
        assert!(with("{i} folds\n= {2}\n").unwrap_err().contains("no hole 2"));
        assert!(with("{x}\n= {1}\n").unwrap_err().contains("no such hole"));
        assert!(with("{i} folds\n= {1:складка|складок}\n").unwrap_err().contains("three forms"));
        assert!(with("{i}{i}\n= {1}\n").unwrap_err().contains("without a word"));
        assert!(with("One\n= Один\nOne\n= Раз\n").unwrap_err().contains("twice"));
        assert_eq!(with("One\n= Один\n{i} folds\n= {1} {1:складка|складки|складок}\n").unwrap().templates.len(), 1);
    }
}
