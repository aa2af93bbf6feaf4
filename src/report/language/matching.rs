//! Which template a finished string came from, and what it says in the other language.

use super::Translator;
use super::catalogue::{Catalogue, Kind, Part, Piece, Template};
use super::number::{form, with_commas};

/// The text said again; `None` where the catalogue has nothing for it, or for a part of it.
pub fn find(translator: &Translator, catalogue: &Catalogue, text: &str) -> Option<String> {
    if let Some(known) = translator.known.borrow().get(text) {
        return known.clone();
    }
    let found = Finder { translator, catalogue }.look_for(text);
    translator.known.borrow_mut().insert(text.to_string(), found.clone());
    found
}

/// Marks between labels, and what they are where a label has a decimal comma.
const MARKS: [(&str, &str); 9] = [
    (" · ", " · "),
    ("; ", "; "),
    (", ", "; "),
    (": ", ": "),
    (" × ", " × "),
    (" + ", " + "),
    (" − ", " − "),
    (" = ", " = "),
    ("\n", "\n"),
];

struct Finder<'a> {
    translator: &'a Translator,
    catalogue: &'a Catalogue,
}

impl Finder<'_> {
    fn look_for(&self, text: &str) -> Option<String> {
        let bare = text.trim();
        if bare.len() != text.len() {
            // Blanks at the ends stay: they part a label from its neighbour.
            let (before, after) = (text.len() - text.trim_start().len(), text.trim_end().len());
            return Some(format!(
                "{}{}{}",
                &text[..before.min(after)],
                find(self.translator, self.catalogue, bare)?,
                &text[after.max(before)..]
            ));
        }
        if bare.is_empty() || self.translator.names.contains(text) || is_identifier(text) {
            return Some(text.to_string());
        }
        // A blank that holds two words together is one like any other to the catalogue, and holds what is said together too.
        if text.contains('\u{a0}') && !text.contains(' ') {
            return self.again(&text.replace('\u{a0}', " ")).map(|said| said.replace(' ', "\u{a0}"));
        }
        let plain = &text.replace('\u{a0}', " ");
        let whole = self
            .exactly(plain)
            .or_else(|| self.as_quantity(plain))
            .or_else(|| self.as_numbers(plain))
            .or_else(|| self.as_sentence(plain))
            .or_else(|| self.in_sentences(plain));
        whole.or_else(|| self.in_parts(text))
    }

    fn again(&self, text: &str) -> Option<String> {
        find(self.translator, self.catalogue, text)
    }

    /// By a phrase or template.
    fn exactly(&self, text: &str) -> Option<String> {
        if let Some(said) = self.catalogue.phrases.get(text).or_else(|| self.catalogue.units.get(text)) {
            return Some(said.clone());
        }
        self.catalogue.templates.iter().find_map(|template| self.by(template, text))
    }

    fn by(&self, template: &Template, text: &str) -> Option<String> {
        // Most templates are told apart by how they begin and end.
        if let Some(Part::Words(words)) = template.parts.first()
            && !text.starts_with(words.as_str())
        {
            return None;
        }
        if let Some(Part::Words(words)) = template.parts.last()
            && !text.ends_with(words.as_str())
        {
            return None;
        }
        let mut holes: Vec<(&str, String)> = vec![];
        self.fill(&template.parts, text, &mut holes).then(|| {
            let said = |piece: &Piece| match piece {
                Piece::Words(words) => words.clone(),
                Piece::Hole(i) => holes[*i].1.clone(),
                Piece::Noun(i, forms) => forms[form(holes[*i].0)].clone(),
            };
            template.said.iter().map(said).collect()
        })
    }

    /// Finds what stands in each hole; the shortest that fits, and longer where what follows then does not fit.
    fn fill<'t>(&self, parts: &[Part], text: &'t str, holes: &mut Vec<(&'t str, String)>) -> bool {
        match parts {
            [] => text.is_empty(),
            [Part::Words(words), rest @ ..] => text.strip_prefix(words.as_str()).is_some_and(|text| self.fill(rest, text, holes)),
            [Part::Hole(kind)] => self.holds(*kind, text, holes),
            [Part::Hole(kind), rest @ ..] => {
                let Some(Part::Words(words)) = rest.first() else { return false };
                let reached = holes.len();
                for (at, _) in text.match_indices(words.as_str()) {
                    if self.holds(*kind, &text[..at], holes) {
                        if self.fill(rest, &text[at..], holes) {
                            return true;
                        }
                        holes.truncate(reached);
                    }
                }
                false
            }
        }
    }

    /// Whether a text may stand in a hole; if so it is put there.
    fn holds<'t>(&self, kind: Kind, text: &'t str, holes: &mut Vec<(&'t str, String)>) -> bool {
        if text.is_empty() {
            return false;
        }
        let said = match kind {
            Kind::Number => is_number(text).then(|| with_commas(text)),
            Kind::Count => text.bytes().all(|b| b.is_ascii_digit()).then(|| text.to_string()),
            Kind::Name => self.translator.names.contains(text).then(|| text.to_string()),
            Kind::Own => Some(text.to_string()),
            Kind::Unit => {
                self.catalogue.units.get(text).cloned().or_else(|| (!text.contains([' ', ',', '.', ';', ':'])).then(|| text.to_string()))
            }
            Kind::Text => self.again(text),
            Kind::List => self.list(text),
        };
        said.map(|said| holes.push((text, said))).is_some()
    }

    fn list(&self, text: &str) -> Option<String> {
        let items: Vec<String> = text.split(", ").map(|item| self.again(item)).collect::<Option<_>>()?;
        Some(joined(&items, ", ", "; "))
    }

    /// What has no word in Latin letters but symbols that every language shares.
    fn as_numbers(&self, text: &str) -> Option<String> {
        latin_words(text).all(|word| self.catalogue.symbols.contains(word)).then(|| with_commas(text))
    }

    /// A remark that was made a sentence, and a sentence that lost its full stop.
    fn as_sentence(&self, text: &str) -> Option<String> {
        let remark = text.strip_suffix('.').filter(|rest| !rest.ends_with('.'));
        let small = |text: &str| {
            let mut letters = text.chars();
            letters.next().filter(|c| c.is_uppercase()).map(|first| first.to_lowercase().to_string() + letters.as_str())
        };
        if let Some(remark) = remark {
            if let Some(said) = self.exactly(remark) {
                return Some(said + ".");
            }
            if let Some(said) = small(remark).and_then(|remark| self.exactly(&remark)) {
                return Some(capitalized(&said) + ".");
            }
        }
        if let Some(said) = small(text).and_then(|text| self.exactly(&text)) {
            return Some(capitalized(&said));
        }
        let whole = self.exactly(&format!("{text}."))?;
        Some(whole.strip_suffix('.').map(str::to_string).unwrap_or(whole))
    }

    /// Several sentences, each by itself.
    fn in_sentences(&self, text: &str) -> Option<String> {
        for (at, _) in text.match_indices(". ") {
            let (first, rest) = (&text[..=at], &text[at + 2..]);
            let first = self.exactly(first).or_else(|| self.as_sentence(first)).or_else(|| self.as_numbers(first));
            if let Some((first, rest)) = first.and_then(|first| Some((first, self.again(rest)?))) {
                return Some(format!("{first} {rest}"));
            }
        }
        None
    }

    /// Labels with a mark between them, each by itself.
    fn in_parts(&self, text: &str) -> Option<String> {
        for (mark, otherwise) in MARKS {
            if text.contains(mark) {
                let items: Option<Vec<String>> = text.split(mark).map(|item| self.again(item)).collect();
                if let Some(items) = items {
                    return Some(joined(&items, mark, otherwise));
                }
            }
        }
        None
    }

    /// A number and its unit.
    fn as_quantity(&self, text: &str) -> Option<String> {
        let (number, unit) = text.rsplit_once(' ')?;
        let unit = self.catalogue.units.get(unit)?;
        Some(format!("{} {unit}", self.as_numbers(number)?))
    }
}

/// With a capital first.
pub fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().to_string()).unwrap_or_default() + letters.as_str()
}

/// Items with `mark` between, or `otherwise` where an item has a decimal comma.
fn joined(items: &[String], mark: &str, otherwise: &str) -> String {
    let comma = |item: &String| item.as_bytes().windows(3).any(|w| w[0].is_ascii_digit() && w[1] == b',' && w[2].is_ascii_digit());
    items.join(if items.iter().any(comma) { otherwise } else { mark })
}

/// A number as reports print it: sign, decimals, error, power of ten, bound, range; or the dash for what does not exist.
fn is_number(text: &str) -> bool {
    let inside = |c: char| c.is_ascii_digit() || "⁰¹²³⁴⁵⁶⁷⁸⁹⁻.−-+±×()<>=≤≥≈…–%° \u{a0}".contains(c);
    text == "–"
        || text == "…"
        || (text.contains(|c: char| c.is_ascii_digit()) && text.chars().all(inside) && !text.ends_with('.') && text.trim() == text)
}

/// A file, a key, a digest: one word in which an underscore, a slash or a digit says that no reader is meant.
pub fn is_identifier(text: &str) -> bool {
    let one = !text.contains(|c: char| c.is_whitespace());
    let marked = text.contains('_') && text.chars().all(|c| c.is_alphanumeric() || "_-%./".contains(c));
    let digest = text.len() == 16 && text.bytes().all(|b| b.is_ascii_hexdigit());
    one && (marked || digest)
}

/// Words of two or more Latin letters, and single ones.
pub fn latin_words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_ascii_alphabetic()).filter(|word| !word.is_empty())
}
