//! Figure: scenes against energy terms, coloured by how far the hem moves when the term is switched.

use plotters::prelude::*;

use super::heat_map::shade;
use super::sheet::{self, Area, Drawn, FULL_WIDTH, GREY, INK, LABEL, SMALL, line, steps};
use crate::error::Error;
use crate::experiment::scene::Term;
use crate::report::terms::millimetres;
use crate::simulate::scene::Switched;
use crate::study::terms::TermsStudy;
use crate::units::MILLIMETRE;

/// Room for the names of scenes, mm.
const NAMES: f64 = 46.0;
const ROW: f64 = 6.2;
/// Most that the rows together may take, mm: with title and legend they stay on a page.
const ROWS: f64 = 190.0;
const TOP: f64 = 12.0;
const LEGEND: f64 = 13.0;
/// The scale goes from 10⁻³ to 10² mm.
const DECADES: (f64, f64) = (-3.0, 2.0);

/// One row a scene, in the order given; terms of which no scene has data are left out.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(study: &TermsStudy) -> Result<String, Error> {
    let terms: Vec<Term> = Term::ALL.into_iter().filter(|term| study.rows().any(|(_, row)| row.term == *term)).collect();
    let pitch = ROW.min(ROWS / study.scenes.len().max(1) as f64);
    let height = TOP + pitch * study.scenes.len() as f64 + LEGEND;
    let width = (FULL_WIDTH - NAMES - 0.5) / terms.len().max(1) as f64;
    sheet::draw("map of energy terms", FULL_WIDTH, height, |area| {
        sheet::title(area, &format!("Movement of the hem by each term, mm, {} scenes", study.scenes.len()), 0.5, 3.0)?;
        for (i, term) in terms.iter().enumerate() {
            let name = term.name().replace('_', " ");
            sheet::text_centre(area, &name, NAMES + width * (i as f64 + 0.5), TOP - 3.0, sheet::fitted(&name, width - 1.0, LABEL), INK)?;
        }
        for (k, (name, answer)) in study.scenes.iter().enumerate() {
            let y = TOP + pitch * k as f64;
            // A name that is too long for any readable size is cut.
            let name = sheet::shortened(name, 40);
            let size = sheet::fitted(&name, NAMES - 3.0, SMALL).min(SMALL * pitch / ROW * 1.3);
            sheet::text_right(area, &name, NAMES - 1.5, y + 0.5 * pitch, size, INK)?;
            for (i, term) in terms.iter().enumerate() {
                let row = answer.as_ref().ok().and_then(|scene| scene.rows.iter().find(|row| row.term == *term));
                paint(area, row, answer.is_err(), (NAMES + width * i as f64, y), (width - 0.5, pitch - 0.08 * pitch))?;
            }
        }
        legend(area, TOP + pitch * study.scenes.len() as f64 + 3.5)
    })
}

/// Place of a movement (mm) on the scale.
fn place(movement: f64) -> f64 {
    (movement.max(1e-300).log10() - DECADES.0) / (DECADES.1 - DECADES.0)
}

fn paint(area: &Area<'_>, row: Option<&Switched>, refused: bool, (x, y): (f64, f64), (w, h): (f64, f64)) -> Drawn {
    let movement = row.and_then(|row| row.movement).map(|m| m / MILLIMETRE);
    let ink = match (row, movement) {
        // The scene has no such term: nothing is drawn.
        (None, _) if !refused => return sheet::text_centre(area, "–", x + 0.5 * w, y + 0.5 * h, SMALL, GREY),
        (_, None) => hatch(area, (x, y), (w, h))?,
        (_, Some(movement)) => {
            let (fill, dark) = shade(place(movement));
            area.draw(&Rectangle::new([(steps(x), steps(y)), (steps(x + w), steps(y + h))], sheet::fill(fill)))?;
            if dark { WHITE } else { INK }
        }
    };
    if let Some(movement) = movement {
        sheet::text_right(area, &millimetres(movement), x + 0.5 * w + 4.0, y + 0.5 * h, LABEL.min(1.9 * h), ink)?;
    }
    if row.is_some_and(|row| row.screened.on) {
        chosen(area, (x, y), (w, h))?;
    }
    Ok(())
}

/// A frame and a disc that has its own rim: seen on light and dark cells alike.
fn chosen(area: &Area<'_>, (x, y): (f64, f64), (_, h): (f64, f64)) -> Drawn {
    let centre = (steps(x + 2.2), steps(y + 0.5 * h));
    let radius = (0.22 * h).min(1.1);
    area.draw(&Circle::new(centre, steps(radius), sheet::fill(WHITE)))?;
    area.draw(&Circle::new(centre, steps(radius), line(INK, 0.15)))?;
    area.draw(&Circle::new(centre, steps(0.5 * radius), sheet::fill(INK)))?;
    Ok(())
}

fn hatch(area: &Area<'_>, (x, y): (f64, f64), (w, h): (f64, f64)) -> Result<RGBColor, Box<dyn std::error::Error>> {
    let mut at = -h;
    while at < w {
        let (from, to) = (at.max(0.0), (at + h).min(w));
        let path = vec![(steps(x + from), steps(y + h - (from - at))), (steps(x + to), steps(y + h - (to - at)))];
        area.draw(&PathElement::new(path, line(GREY, 0.12)))?;
        at += 1.5;
    }
    area.draw(&Rectangle::new([(steps(x), steps(y)), (steps(x + w), steps(y + h))], line(GREY, 0.15)))?;
    Ok(INK)
}

fn legend(area: &Area<'_>, y: f64) -> Drawn {
    sheet::text_left(area, "movement, mm", 0.5, y + 2.0, SMALL, INK)?;
    for (k, text) in ["0.001", "0.01", "0.1", "1", "10", "100"].into_iter().enumerate() {
        let x = 22.0 + 9.0 * k as f64;
        let (fill, dark) = shade(k as f64 / (DECADES.1 - DECADES.0));
        area.draw(&Rectangle::new([(steps(x), steps(y)), (steps(x + 9.0), steps(y + 4.0))], sheet::fill(fill)))?;
        sheet::text_centre(area, text, x + 4.5, y + 2.0, SMALL, if dark { WHITE } else { INK })?;
    }
    chosen(area, (82.0, y), (8.0, 4.0))?;
    sheet::text_left(area, "put in by the screen", 87.0, y + 2.0, SMALL, INK)?;
    hatch(area, (119.0, y), (8.0, 4.0))?;
    sheet::text_left(area, "no answer", 128.5, y + 2.0, SMALL, INK)?;
    sheet::text_left(area, "–  no data", 150.0, y + 2.0, SMALL, INK)
}
