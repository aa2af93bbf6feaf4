//! The template's own strings: every literal that it hands to `w` (plain) or `m` (markup), with what it is in the report's language.

use std::collections::BTreeSet;

use serde_json::{Map, Value};

use crate::report::language::Translator;

/// `words.json`: English → said, for each literal of the template.
pub fn said(template: &str, translator: &Translator) -> Value {
    literals(template)
        .into_iter()
        .map(|text| {
            let said = translator.say(&text);
            (text, Value::String(said))
        })
        .collect::<Map<_, _>>()
        .into()
}

/// Every `w("…")` and `m("…")` of a template.
fn literals(template: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for call in ["w(", "m("] {
        for (at, _) in template.match_indices(call) {
            let longer = template[..at].ends_with(|c: char| c.is_alphanumeric() || c == '-' || c == '_' || c == '.');
            if let Some(text) = template[at + call.len()..].trim_start().strip_prefix('"').filter(|_| !longer) {
                found.insert(literal(text));
            }
        }
    }
    found
}

/// The string up to its closing quote, escapes resolved.
fn literal(text: &str) -> String {
    let mut said = String::new();
    let mut letters = text.chars();
    while let Some(letter) = letters.next() {
        match letter {
            '"' => break,
            '\\' => match letters.next() {
                Some('n') => said.push('\n'),
                Some(quoted @ ('"' | '\\')) => said.push(quoted),
                // Typst keeps the backslash of an escape that it does not know: a line break in markup.
                Some(other) => said.extend(['\\', other]),
                None => break,
            },
            other => said.push(other),
        }
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_are_found_with_their_escapes_and_nothing_else_is() {
        let template = "#w(\n  \"One\") #m(\"two \\\"three\\\" a\\ b\", x) #show(\"no\") #bow(\"no\") text w(x)";
        let found: Vec<String> = literals(template).into_iter().collect();
        assert_eq!(found, ["One", "two \"three\" a\\ b"]);
    }
}
