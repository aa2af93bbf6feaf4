//! What holds for the Russian catalogue: every template is reached, names stay, and what it does not have is said.

use super::catalogue::{Kind, Part, Template};
use super::*;

fn russian(names: &[&str]) -> Translator {
    Translator::new(Language::Russian, names.iter().map(|name| name.to_string()).collect())
}

/// The template filled with something that may stand in each hole.
fn example(template: &Template) -> String {
    let filled = |part: &Part| match part {
        Part::Words(words) => words.clone(),
        Part::Hole(Kind::Number) => "12.5".into(),
        Part::Hole(Kind::Count) => "7".into(),
        Part::Hole(Kind::Name) => "Name".into(),
        Part::Hole(Kind::Own) => "Own9".into(),
        Part::Hole(Kind::Unit) => "mm".into(),
        Part::Hole(Kind::Text) => "graded".into(),
        Part::Hole(Kind::List) => "graded, ruled".into(),
    };
    template.parts.iter().map(filled).collect()
}

#[test]
fn every_template_is_matched_by_its_own_example_and_none_stands_in_its_way() {
    let catalogue = Catalogue::russian();
    assert!(300 < catalogue.phrases.len() + catalogue.templates.len());
    for template in &catalogue.templates {
        let translator = russian(&["Name"]);
        let example = example(template);
        let said = translator.say(&example);
        assert!(translator.missing().is_empty(), "“{}” is not matched by “{example}”", template.english);
        let foreign: Vec<String> = translator.foreign_words(&said).into_iter().filter(|word| word != "Own").collect();
        assert!(foreign.is_empty(), "“{example}” became “{said}”, with {foreign:?}");
        // What the template itself says; another one that says the same is no harm.
        for piece in &template.said {
            if let catalogue::Piece::Words(words) = piece {
                let letters = |text: &str| text.chars().filter(|c| c.is_alphabetic()).collect::<String>().to_lowercase();
                assert!(
                    letters(&said).contains(&letters(words)),
                    "“{example}” became “{said}” by another template than “{}”",
                    template.english
                );
            }
        }
    }
}

#[test]
fn no_phrase_keeps_a_word_of_english() {
    let translator = russian(&[]);
    for (english, said) in &Catalogue::russian().phrases {
        assert!(translator.foreign_words(said).is_empty(), "“{english}” became “{said}”");
    }
}

#[test]
fn what_a_laboratory_wrote_is_never_touched() {
    let translator = russian(&["fold depth", "1.5", "residuals of spring"]);
    for name in ["fold depth", "1.5", "residuals of spring"] {
        assert_eq!(translator.say(name), name);
    }
    assert_eq!(translator.say("fold depth 2.5 mm"), "fold depth 2,5 мм");
    assert_eq!(translator.say("report_1.csv"), "report_1.csv");
    assert_eq!(translator.say("a8a6d84ba85a614d"), "a8a6d84ba85a614d");
}

#[test]
fn numbers_take_commas_and_nouns_agree_with_them() {
    let translator = russian(&[]);
    assert_eq!(translator.say("131.52 ± 0.04"), "131,52 ± 0,04");
    assert_eq!(
        translator.say("2 of 3 hems were fitted: 1 folds in 1, 5 folds in 2."),
        "Кривые подобраны к 2 из 3 подолов: 1 складка у 1, 5 складок у 2."
    );
    assert_eq!(translator.say("(0.0116 ± 0.0013) N/m²"), "(0,0116 ± 0,0013) Н/м²");
    assert_eq!(translator.say("0.873, p = 0.0003"), "0,873; p = 0,0003");
}

#[test]
fn remarks_become_sentences_and_sentences_stand_together() {
    let translator = russian(&[]);
    let said =
        translator.say("No fit: the profile was set aside. The points came in no order; their order round the hem was reconstructed.");
    assert_eq!(said, "Кривой нет: профиль отложен. Точки были без порядка; их порядок вдоль подола восстановлен.");
    assert_eq!(translator.say("The cut is not known."), "Крой неизвестен.");
    assert_eq!(translator.say("Mean radius p: residuals, n = 40"), "Средний радиус p: остатки, n = 40");
}

#[test]
fn blanks_that_a_script_fills_stay() {
    assert_eq!(russian(&[]).say_with_blanks("{shown} of {all} runs"), "{shown} из {all} опытов");
}

#[test]
fn what_the_catalogue_does_not_have_stays_and_is_named() {
    let translator = russian(&[]);
    assert_eq!(translator.say("quite another thing"), "quite another thing");
    assert_eq!(translator.missing(), ["quite another thing"]);
}

#[test]
fn english_is_left_alone() {
    let translator = Translator::new(Language::English, BTreeSet::new());
    assert_eq!(translator.say("anything at 2.5 mm"), "anything at 2.5 mm");
    assert!(translator.missing().is_empty());
}
