//! Figure: the symbols of the hem curve, drawn on one exaggerated hem.

use std::f64::consts::{PI, TAU};

use plotters::prelude::*;

use super::sheet::{self, BLUE, Drawn, GREY, INK, LABEL, VERMILLION, fill, line, steps};
use crate::error::Error;
use crate::model::hem::{Hem, Placement};

/// Size on paper, mm.
pub const WIDTH: f64 = 80.0;
pub const HEIGHT: f64 = 70.0;

/// A five-fold hem with its centre, mean radius p, fold amplitude q, lean s and phase φ.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw() -> Result<String, Error> {
    sheet::draw("drawing of the symbols", WIDTH, HEIGHT, paint)
}

fn paint(area: &sheet::Area<'_>) -> Drawn {
    // In millimetres on the sheet.
    let hem = Hem { p: 22.0, q: 8.0, s: 2.6, folds: 5 };
    let (cx, cy) = (36.0, 35.0);
    let placement = Placement { x0: 0.0, y0: 0.0, phase: 0.35 };
    let on = |x: f64, y: f64| (steps(cx + x), steps(cy - y));
    let path = |points: Vec<(f64, f64)>, style| PathElement::new(points.into_iter().map(|(x, y)| on(x, y)).collect::<Vec<_>>(), style);
    let dashed_circle = |radius: f64, style: ShapeStyle| -> Drawn {
        for i in 0..60 {
            let arc = |k: f64| (radius * (TAU * k / 60.0).cos(), radius * (TAU * k / 60.0).sin());
            let i = f64::from(i);
            area.draw(&path(vec![arc(i), arc(i + 0.3), arc(i + 0.55)], style))?;
        }
        Ok(())
    };
    dashed_circle(hem.p, line(GREY, 0.2))?;
    let whole: Vec<(f64, f64)> = (0..=400).map(|i| hem.point(&placement, TAU * f64::from(i) / 400.0)).map(|p| (p.x, p.y)).collect();
    // The same hem without lean, to show what s does.
    let upright = Hem { s: 0.0, ..hem };
    let plain: Vec<(f64, f64)> = (0..=400).map(|i| upright.point(&placement, TAU * f64::from(i) / 400.0)).map(|p| (p.x, p.y)).collect();
    area.draw(&path(plain, line(sheet::SKY, 0.25)))?;
    area.draw(&path(whole, line(BLUE, 0.6)))?;
    // Axes through the centre, which lies at (x0, y0) of the measurement.
    area.draw(&path(vec![(0.0, 0.0), (34.0, 0.0)], line(GREY, 0.2)))?;
    area.draw(&Circle::new(on(0.0, 0.0), steps(0.7), fill(INK)))?;
    sheet::text_left(area, "(x₀, y₀)", cx - 12.5, cy + 2.6, LABEL, INK)?;
    sheet::text_left(area, "x", cx + 35.0, cy, LABEL, GREY)?;
    // Phase: the angle to the first crest.
    let crest = (placement.phase.cos(), placement.phase.sin());
    area.draw(&path(vec![(0.0, 0.0), (30.0 * crest.0, 30.0 * crest.1)], line(INK, 0.25)))?;
    area.draw(&path(
        (0..=20).map(|i| placement.phase * f64::from(i) / 20.0).map(|a| (12.0 * a.cos(), 12.0 * a.sin())).collect(),
        line(INK, 0.25),
    ))?;
    sheet::text_left(area, "φ", cx + 13.2, cy - 2.3, LABEL, INK)?;
    // p: to the mean circle, under the second crest.
    let toward = placement.phase + TAU / 5.0;
    area.draw(&path(vec![(0.0, 0.0), (hem.p * toward.cos(), hem.p * toward.sin())], line(VERMILLION, 0.35)))?;
    let mid = (0.52 * hem.p * toward.cos(), 0.52 * hem.p * toward.sin());
    sheet::text_left(area, "p", cx + mid.0 + 1.4, cy - mid.1, LABEL, VERMILLION)?;
    // q: from the mean circle to the first crest.
    area.draw(&path(vec![(hem.p * crest.0, hem.p * crest.1), (30.0 * crest.0, 30.0 * crest.1)], line(VERMILLION, 0.6)))?;
    sheet::text_left(area, "q", cx + 26.3 * crest.0 - 2.2, cy - 26.3 * crest.1 - 2.2, LABEL, VERMILLION)?;
    // s: sideways shift at an eighth of a fold's period, where sin 2mt = 1.
    let t = PI / 20.0 + 3.0 * TAU / 5.0;
    let (from, to) = (upright.point(&placement, t), hem.point(&placement, t));
    area.draw(&path(vec![(from.x, from.y), (to.x, to.y)], line(VERMILLION, 0.6)))?;
    area.draw(&Circle::new(on(from.x, from.y), steps(0.5), fill(VERMILLION)))?;
    area.draw(&Circle::new(on(to.x, to.y), steps(0.5), fill(VERMILLION)))?;
    sheet::text_left(area, "s", cx + to.x + 1.6, cy - to.y + 1.2, LABEL, VERMILLION)?;
    sheet::text_left(area, "thick: the hem, m = 5 folds", 1.0, 2.5, sheet::SMALL, BLUE)?;
    sheet::text_left(area, "thin: the same with s = 0", 1.0, 67.5, sheet::SMALL, INK)
}
