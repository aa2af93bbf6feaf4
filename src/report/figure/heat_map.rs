//! Figure: hard cases against severity, coloured by the digits kept.

use plotters::prelude::*;

use super::sheet::{self, Area, Drawn, FULL_WIDTH, GREY, INK, LABEL, SMALL, VERMILLION, line, steps};
use crate::error::Error;
use crate::report::stability::severity;
use crate::study::hard_cases::{Outcome, SEVERITIES, Subject};
use crate::study::stability::{CaseStudy, Cell};

/// Room for the names of cases, mm.
const NAMES: f64 = 62.0;
const ROW: f64 = 6.2;
/// Above the first case of a subject, mm.
const HEAD: f64 = 6.0;
const TOP: f64 = 6.0;
const LEGEND: f64 = 13.0;
/// Digits of a double.
const MOST: f64 = 16.0;

/// Cividis (Nuñez, Anderton & Renslow, PLoS ONE 13 (2018) e0199239) from few digits to many: the same to colour-blind eyes, darkening evenly in grey.
const SCALE: [(u8, u8, u8); 6] = [(254, 232, 56), (200, 184, 102), (148, 142, 119), (102, 105, 112), (53, 69, 108), (0, 34, 78)];

/// One row a case, in the order given, subject by subject.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(cases: &[CaseStudy]) -> Result<String, Error> {
    let subjects = [(Subject::Fit, "Fit"), (Subject::Theory, "Theory"), (Subject::Statistics, "Statistics")];
    let height = TOP + ROW * cases.len() as f64 + HEAD * subjects.len() as f64 + LEGEND;
    let width = (FULL_WIDTH - NAMES - 0.5) / SEVERITIES as f64;
    sheet::draw("heat map of hard cases", FULL_WIDTH, height, |area| {
        let cells = cases.iter().map(|case| case.cells.len()).sum::<usize>();
        sheet::title(area, &format!("Digits kept in hard cases, severity growing to the right, n = {cells}"), 0.5, 3.0)?;
        let mut y = TOP;
        for (subject, name) in subjects {
            sheet::text_left(area, name, 0.5, y + 0.6 * HEAD, LABEL, INK)?;
            y += HEAD;
            for case in cases.iter().filter(|case| case.subject == subject) {
                sheet::text_right(area, case.title, NAMES - 1.5, y + 0.5 * ROW, sheet::fitted(case.title, NAMES - 4.0, SMALL), INK)?;
                for (i, cell) in case.cells.iter().enumerate() {
                    paint(area, cell, NAMES + width * i as f64, y, width)?;
                }
                y += ROW;
            }
        }
        legend(area, y + 3.5)
    })
}

/// Colour of so many digits, and whether white text is read on it.
fn colour(digits: f64) -> (RGBColor, bool) {
    shade(digits / MOST)
}

/// Colour at a place from 0 (light) to 1 (dark) of the scale, and whether white text is read on it.
pub(super) fn shade(place: f64) -> (RGBColor, bool) {
    let place = place.clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let i = (place as usize).min(SCALE.len() - 2);
    let rest = place - i as f64;
    let mix = |a: u8, b: u8| (f64::from(a) + rest * (f64::from(b) - f64::from(a))).round() as u8;
    let (a, b) = (SCALE[i], SCALE[i + 1]);
    (RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2)), 0.5 < place / (SCALE.len() - 1) as f64)
}

fn paint(area: &Area<'_>, cell: &Cell, x: f64, y: f64, width: f64) -> Drawn {
    let (w, h) = (width - 0.5, ROW - 0.5);
    let ink = body(area, cell.outcome, cell.digits, x, y, w, h)?;
    let digits = match (cell.outcome, cell.digits) {
        (Outcome::NoAnswer, _) | (_, None) => String::new(),
        (_, Some(digits)) => format!("{digits:.0}"),
    };
    sheet::text_left(area, &digits, x + 1.0, y + 0.5 * h, LABEL, ink)?;
    let text = severity(cell.severity);
    sheet::text_right(area, &text, x + w - 0.6, y + 0.5 * h, sheet::fitted(&text, w - 4.6, 5.2), ink)
}

/// The cell without its text; the colour in which text is read on it.
fn body(
    area: &Area<'_>,
    outcome: Outcome,
    digits: Option<f64>,
    x: f64,
    y: f64,
    w: f64,
    h: f64,
) -> Result<RGBColor, Box<dyn std::error::Error>> {
    let corners = [(steps(x), steps(y)), (steps(x + w), steps(y + h))];
    match outcome {
        Outcome::NoAnswer => {
            let mut at = -h;
            while at < w {
                let (from, to) = (at.max(0.0), (at + h).min(w));
                let path = vec![(steps(x + from), steps(y + h - (from - at))), (steps(x + to), steps(y + h - (to - at)))];
                area.draw(&PathElement::new(path, line(GREY, 0.12)))?;
                at += 1.5;
            }
            area.draw(&Rectangle::new(corners, line(GREY, 0.15)))?;
            Ok(INK)
        }
        Outcome::Wrong => {
            area.draw(&Rectangle::new(corners, sheet::fill(VERMILLION)))?;
            for ends in [(0.0, h), (h, 0.0)] {
                area.draw(&PathElement::new(vec![(steps(x), steps(y + ends.0)), (steps(x + w), steps(y + ends.1))], line(INK, 0.4)))?;
            }
            Ok(INK)
        }
        Outcome::Right | Outcome::Warned => {
            let (fill, dark) = colour(digits.unwrap_or(0.0));
            let ink = if dark { WHITE } else { INK };
            area.draw(&Rectangle::new(corners, sheet::fill(fill)))?;
            if outcome == Outcome::Warned {
                area.draw(&Circle::new((steps(x + 5.7), steps(y + 0.5 * h)), steps(0.55), sheet::fill(ink)))?;
            }
            Ok(ink)
        }
    }
}

fn legend(area: &Area<'_>, y: f64) -> Drawn {
    sheet::text_left(area, "digits kept", 0.5, y + 2.0, SMALL, INK)?;
    for k in 0..=8 {
        let (x, digits) = (17.0 + 6.0 * f64::from(k), 2.0 * f64::from(k));
        let ink = body(area, Outcome::Right, Some(digits), x, y, 6.0, 4.0)?;
        sheet::text_centre(area, &format!("{digits}"), x + 3.0, y + 2.0, SMALL, ink)?;
    }
    let entries = [(Outcome::Warned, "answer with a warning"), (Outcome::NoAnswer, "refused"), (Outcome::Wrong, "wrong")];
    for ((outcome, text), x) in entries.into_iter().zip([78.0, 121.0, 146.0]) {
        body(area, outcome, Some(6.0), x, y, 8.0, 4.0)?;
        sheet::text_left(area, text, x + 9.0, y + 2.0, SMALL, INK)?;
    }
    Ok(())
}
