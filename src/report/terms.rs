//! Tables, sentences and figure of the study of what each energy term is worth.

use serde_json::{Value, json};

use super::csv::Table;
use super::figure::term_map;
use super::number;
use super::study_section::{Machine, SectionFigure, SectionTable, StudySection};
use crate::error::Error;
use crate::experiment::scene::Term;
use crate::simulate::scene::{HemNumbers, Switched};
use crate::study::terms::{SceneTerms, TermsStudy};
use crate::units::{MILLIMETRE, MILLINEWTON};

/// Of a second.
const MILLISECOND: f64 = 1e-3;

/// The study as a section of a report.
///
/// # Errors
/// [`Error::Output`] if the figure cannot be drawn.
pub fn section(study: &TermsStudy, machine: &Machine) -> Result<StudySection, Error> {
    let table = |stem: &str, caption: &str, table: Table, short: Vec<Vec<String>>| SectionTable {
        stem: stem.into(),
        caption: caption.into(),
        table,
        short,
    };
    // One scene is told term by term; of many there is the map, and what each term is worth over all.
    let (of_one, of_many) = match study.scenes.as_slice() {
        [(_, Ok(scene))] => (short(scene), vec![]),
        _ => (short_of_all(study), short_map(study)),
    };
    Ok(StudySection {
        stem: "study_terms".into(),
        title: "What each effect is worth".into(),
        sentences: sentences(study, machine),
        tables: vec![
            table("terms", "Every term switched off and on, the others as the screen chose", every_row(study, machine), of_one),
            table("terms_map", "Movement of the hem by each term, mm; a dot marks what the screen put in", map(study), of_many),
        ],
        figures: vec![SectionFigure {
            stem: "terms_map".into(),
            caption: "Which effects matter where: how far the hem moves when a term is switched, the others as the screen chose. Ringed dot: put in by the \
                      screen. Hatched: no hem without it, or no answer. Dash: the scene has no such term."
                .into(),
            svg: term_map::draw(study)?,
        }],
    })
}

/// A movement in mm as it is printed: to a micrometre, two digits or more.
pub fn millimetres(value: f64) -> String {
    match value {
        _ if value < 5e-4 => "0".into(),
        _ if value < 0.0995 => number::fixed(value, 3),
        _ if value < 0.995 => number::fixed(value, 2),
        _ if value < 9.95 => number::fixed(value, 1),
        _ => number::fixed(value, 0),
    }
}

/// `terms.csv`: every scene and term.
pub fn every_row(study: &TermsStudy, machine: &Machine) -> Table {
    let mut table = Table::new(&[
        "scene",
        "term",
        "on",
        "number",
        "tolerance_mm",
        "estimate_mm",
        "movement_mm",
        "folds_with",
        "folds_without",
        "folds_change",
        "lambda_with_n",
        "lambda_without_n",
        "lambda_change_n",
        "evaluations_with",
        "evaluations_without",
        "evaluations_saved",
        "seconds_with",
        "seconds_without",
        "seconds_saved",
        "screen_evaluations",
        "why",
        "machine",
        "threads",
    ]);
    let width = table.columns.len();
    for (name, answer) in &study.scenes {
        let scene = match answer {
            Ok(scene) => scene,
            Err(why) => {
                let mut cells = vec![name.clone().into()];
                cells.resize_with(width - 3, || None::<f64>.into());
                cells.extend([why.to_string().into(), machine.name.clone().into(), machine.threads.into()]);
                table.push(cells);
                continue;
            }
        };
        for row in &scene.rows {
            let (with, without) = (row.with.as_ref(), row.without.as_ref());
            table.push(vec![
                name.clone().into(),
                row.term.name().into(),
                row.screened.on.into(),
                row.screened.number.into(),
                (scene.tolerance / MILLIMETRE).into(),
                row.screened.movement.map(|m| m / MILLIMETRE).into(),
                row.movement.map(|m| m / MILLIMETRE).into(),
                with.map(|hem| hem.folds).into(),
                without.map(|hem| hem.folds).into(),
                change(row, |hem| Some(f64::from(hem.folds))).into(),
                with.and_then(|hem| hem.multiplier).into(),
                without.and_then(|hem| hem.multiplier).into(),
                change(row, |hem| hem.multiplier).into(),
                with.map(|hem| hem.evaluations).into(),
                without.map(|hem| hem.evaluations).into(),
                change(row, |hem| Some(hem.evaluations as f64)).into(),
                with.map(|hem| hem.seconds).into(),
                without.map(|hem| hem.seconds).into(),
                change(row, |hem| Some(hem.seconds)).into(),
                scene.screen_evaluations.into(),
                row.missing.as_ref().unwrap_or(&row.screened.why).clone().into(),
                machine.name.clone().into(),
                machine.threads.into(),
            ]);
        }
    }
    table
}

/// `terms_map.csv`: a row a scene, a column a term, mm.
pub fn map(study: &TermsStudy) -> Table {
    let columns: Vec<String> = Term::ALL.iter().map(|term| format!("{}_mm", term.name())).collect();
    let mut table = Table::new(&[&["scene"], columns.iter().map(String::as_str).collect::<Vec<_>>().as_slice()].concat());
    for (name, answer) in &study.scenes {
        let movement = |term: Term| answer.as_ref().ok().and_then(|scene| row(scene, term)?.movement).map(|m| m / MILLIMETRE);
        let mut cells = vec![name.clone().into()];
        cells.extend(Term::ALL.map(|term| movement(term).into()));
        table.push(cells);
    }
    table
}

/// With the term less without it, where both are known: of work, what is saved where it is left out.
fn change(row: &Switched, of: impl Fn(&HemNumbers) -> Option<f64>) -> Option<f64> {
    Some(of(row.with.as_ref()?)? - of(row.without.as_ref()?)?)
}

fn row(scene: &SceneTerms, term: Term) -> Option<&Switched> {
    scene.rows.iter().find(|row| row.term == term)
}

fn short_map(study: &TermsStudy) -> Vec<Vec<String>> {
    let terms: Vec<Term> = Term::ALL.into_iter().filter(|term| study.rows().any(|(_, row)| row.term == *term)).collect();
    let mut rows = vec![std::iter::once("Scene".to_string()).chain(terms.iter().map(|term| name(*term))).collect::<Vec<_>>()];
    for (scene, answer) in &study.scenes {
        let cell = |term: &Term| {
            let Some(row) = answer.as_ref().ok().and_then(|scene| row(scene, *term)) else { return "–".to_string() };
            let moved = row.movement.map_or_else(|| "–".into(), |m| millimetres(m / MILLIMETRE));
            if row.screened.on { format!("{moved} •") } else { moved }
        };
        rows.push(std::iter::once(scene.clone()).chain(terms.iter().map(cell)).collect());
    }
    rows
}

/// “body contact”.
fn name(term: Term) -> String {
    term.name().replace('_', " ")
}

/// “Body contact”, where a sentence begins.
fn title(term: Term) -> String {
    let name = name(term);
    let (first, rest) = name.split_at(1);
    format!("{}{rest}", first.to_uppercase())
}

fn moved(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), |m| millimetres(m / MILLIMETRE))
}

fn state(row: &Switched) -> &'static str {
    if row.screened.on { "in" } else { "out" }
}

/// Of λ, mN.
fn multiplier(hem: &HemNumbers) -> Option<f64> {
    hem.multiplier.map(|value| value / MILLINEWTON)
}

fn evaluations(hem: &HemNumbers) -> Option<f64> {
    Some(hem.evaluations as f64)
}

fn milliseconds(hem: &HemNumbers) -> Option<f64> {
    Some(hem.seconds / MILLISECOND)
}

/// One scene, a row a term.
fn short(scene: &SceneTerms) -> Vec<Vec<String>> {
    let header =
        ["Term", "Screen", "Estimate, mm", "Moves, mm", "Folds with", "without", "λ with, mN", "without", "Evaluations saved", "ms saved"];
    let mut rows = vec![header.map(String::from).to_vec()];
    for row in &scene.rows {
        let (with, without) = (row.with.as_ref(), row.without.as_ref());
        let dash = |text: Option<String>| text.unwrap_or_else(|| "–".into());
        let folds = |hem: Option<&HemNumbers>| dash(hem.map(|hem| hem.folds.to_string()));
        let lambda = |hem: Option<&HemNumbers>| dash(hem.and_then(multiplier).map(|value| number::significant(value, 3)));
        rows.push(vec![
            name(row.term),
            state(row).into(),
            moved(row.screened.movement),
            moved(row.movement),
            folds(with),
            folds(without),
            lambda(with),
            lambda(without),
            dash(change(row, evaluations).map(|saved| number::fixed(saved, 0))),
            dash(change(row, milliseconds).map(|saved| number::significant(saved, 2))),
        ]);
    }
    rows
}

/// All scenes together, a row a term.
fn short_of_all(study: &TermsStudy) -> Vec<Vec<String>> {
    let header = ["Term", "Put in", "Moves, mm", "Folds change by", "λ changes by, mN", "Evaluations saved", "ms saved"];
    let mut table = vec![header.map(String::from).to_vec()];
    for term in Term::ALL {
        let rows: Vec<&Switched> = study.rows().map(|(_, row)| row).filter(|row| row.term == term).collect();
        if rows.is_empty() {
            continue;
        }
        let range = |of: &dyn Fn(&Switched) -> Option<f64>, say: &dyn Fn(f64) -> String| {
            let mut values: Vec<f64> = rows.iter().filter_map(|row| of(row)).collect();
            values.sort_by(f64::total_cmp);
            match values.as_slice() {
                [] => "–".to_string(),
                [first, .., last] if say(*first) != say(*last) => format!("{} … {}", say(*first), say(*last)),
                [first, ..] => say(*first),
            }
        };
        let whole = |value: f64| number::fixed(value, 0);
        let two = |value: f64| number::significant(value, 2);
        // λ has nine digits: a change below them is none.
        let force = |value: f64| if value.abs() < 1e-6 { "0".to_string() } else { two(value) };
        table.push(vec![
            name(term),
            format!("{} of {}", rows.iter().filter(|row| row.screened.on).count(), rows.len()),
            range(&|row| row.movement.map(|m| m / MILLIMETRE), &millimetres),
            range(&|row| change(row, |hem| Some(f64::from(hem.folds))), &whole),
            range(&|row| change(row, multiplier), &force),
            range(&|row| change(row, evaluations), &whole),
            range(&|row| change(row, milliseconds), &two),
        ]);
    }
    // What no scene has (λ has a closed form under few terms only) is no column.
    let told: Vec<bool> = (0..header.len()).map(|column| table[1..].iter().any(|row| row[column] != "–")).collect();
    table.into_iter().map(|row| row.into_iter().zip(&told).filter(|(_, told)| **told).map(|(cell, _)| cell).collect()).collect()
}

/// Whether the screen judged a term as switching it shows, of those that it judges and that have a hem on either side.
fn judged(scene: &SceneTerms, row: &Switched) -> Option<bool> {
    let free = !matches!(row.term, Term::Gravity | Term::Bending);
    row.movement.filter(|_| free).map(|moved| row.screened.on == (scene.tolerance < moved))
}

fn sentences(study: &TermsStudy, machine: &Machine) -> Vec<String> {
    let answered = study.scenes.iter().filter(|(_, answer)| answer.is_ok()).count();
    let of = if study.scenes.len() == 1 { "scene" } else { "scenes" };
    let mut said =
        vec![format!("{} {of}, {answered} with an answer; {} terms switched off or on.", study.scenes.len(), study.rows().count())];
    for term in Term::ALL {
        let rows: Vec<&Switched> = study.rows().map(|(_, row)| row).filter(|row| row.term == term).collect();
        if rows.is_empty() {
            continue;
        }
        let on = rows.iter().filter(|row| row.screened.on).count();
        let mut moved: Vec<f64> = rows.iter().filter_map(|row| row.movement).map(|m| m / MILLIMETRE).collect();
        moved.sort_by(f64::total_cmp);
        let recount = |row: &&&Switched| row.with.as_ref().zip(row.without.as_ref()).is_some_and(|(a, b)| a.folds != b.folds);
        let folds = rows.iter().filter(recount).count();
        let range = match moved.as_slice() {
            [] => "there is no hem to compare".to_string(),
            [one] => format!("it moves the hem by {} mm", millimetres(*one)),
            [least, .., most] => format!("it moves the hem by {} to {} mm", millimetres(*least), millimetres(*most)),
        };
        said.push(format!("{}: in {on} of {}; {range}; the fold count changes in {folds}.", title(term), rows.len()));
    }
    let verdicts: Vec<_> = study.rows().filter_map(|(scene, row)| Some((scene, row, judged(scene, row)?))).collect();
    let right = verdicts.iter().filter(|(_, _, right)| *right).count();
    said.push(format!("Of {} terms that the screen was free to choose it judged {right} as switching them shows.", verdicts.len()));
    said.push(format!(
        "Seconds are those of one core, on {} with {} threads; what leaving a term out saves is negative where it costs.",
        machine.name, machine.threads
    ));
    for (scene, row, _) in verdicts.iter().filter(|(_, _, right)| !right) {
        let moved = millimetres(row.movement.unwrap_or(0.0) / MILLIMETRE);
        said.push(format!("Judged otherwise: {} in “{}” is {} and moves the hem by {moved} mm.", title(row.term), scene.name, state(row)));
    }
    let refused = study.scenes.iter().filter_map(|(name, answer)| Some((name, answer.as_ref().err()?)));
    said.extend(refused.map(|(name, why)| format!("No answer: “{name}”: {why}.")));
    said
}

/// Everything, SI units.
pub fn json(study: &TermsStudy) -> Value {
    let one = |(name, answer): &(String, Result<SceneTerms, Error>)| match answer {
        Ok(scene) => json!(scene),
        Err(why) => json!({ "name": name, "missing": why.to_string() }),
    };
    json!({ "scenes": study.scenes.iter().map(one).collect::<Vec<_>>() })
}
