//! Figure 4 of the paper: the middle curve of Table 1's skirt as the approximate solution has it.

use std::f64::consts::TAU;

use plotters::prelude::*;

use super::sheet::{self, Area, BLUE, Drawn, Frame, GREY, INK, SMALL, chart, dashed, line, solid, steps};
use crate::error::Error;
use crate::experiment::Skirt;
use crate::model::hem::{Hem, Placement};
use crate::report::number::fixed;
use crate::units::{CENTIMETRE, MILLIMETRE};

/// Size on paper, mm.
pub const WIDTH: f64 = 100.0;
pub const HEIGHT: f64 = 112.0;

/// The curve with the circles between which it runs: p, the round hem R_n, and the waist R_t.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(heading: &str, origin: &str, skirt: &Skirt, hem: &Hem) -> Result<String, Error> {
    sheet::draw("the paper's Figure 4", WIDTH, HEIGHT, |area| paint(area, heading, origin, skirt, hem))
}

fn paint(area: &Area<'_>, heading: &str, origin: &str, skirt: &Skirt, hem: &Hem) -> Drawn {
    sheet::title(area, heading, 0.5, 2.5)?;
    let mm = |metres: f64| fixed(metres / MILLIMETRE, 1);
    let text = format!("p = {} mm, q = {} mm, s = {} mm, m = {}; {origin}", mm(hem.p), mm(hem.q), mm(hem.s), hem.folds);
    sheet::text_left(area, &text, 0.5, 6.8, SMALL, INK)?;
    let (left, below, top) = (12.0, 9.5, 9.5);
    let side = WIDTH - left - 2.0;
    let plot = sheet::part(area, 0.0, top, left + side, side + below);
    let half = 1.08 * skirt.hem_radius().0 / CENTIMETRE;
    let frame = Frame { left, below, ..Frame::plan((0.0, 0.0), half) };
    let mut axes = chart(&plot, &frame)?;
    let circle = |radius: f64| -> Vec<(f64, f64)> {
        (0..=240).map(|i| TAU * f64::from(i) / 240.0).map(|a| (radius * a.cos() / CENTIMETRE, radius * a.sin() / CENTIMETRE)).collect()
    };
    solid(&mut axes, &circle(skirt.hem_radius().0), line(GREY, 0.2))?;
    dashed(&mut axes, &circle(hem.p), line(INK, 0.25), 1.4, 0.9)?;
    dashed(&mut axes, &circle(skirt.waist_radius().0), line(GREY, 0.25), 0.5, 0.7)?;
    let points: Vec<(f64, f64)> = (0..=720)
        .map(|i| hem.point(&Placement::ORIGIN, TAU * f64::from(i) / 720.0))
        .map(|p| (p.x / CENTIMETRE, p.y / CENTIMETRE))
        .collect();
    solid(&mut axes, &points, line(BLUE, 0.55))?;
    axes.draw_series(std::iter::once(Cross::new((0.0, 0.0), steps(1.0), line(GREY, 0.2))))?;
    let y = HEIGHT - 2.2;
    let rule =
        |from: f64, to: f64, style: ShapeStyle| area.draw(&PathElement::new(vec![(steps(from), steps(y)), (steps(to), steps(y))], style));
    rule(1.0, 6.0, line(BLUE, 0.55))?;
    rule(26.0, 31.0, line(GREY, 0.2))?;
    for i in 0..3 {
        let from = f64::from(i);
        rule(55.0 + 2.0 * from, 56.2 + 2.0 * from, line(INK, 0.25))?;
        rule(79.0 + 1.4 * from, 79.6 + 1.4 * from, line(GREY, 0.3))?;
    }
    for (x, name) in [(7.0, "middle curve"), (32.0, "round hem Rₙ"), (61.5, "radius p"), (83.5, "waist Rₜ")] {
        sheet::text_left(area, name, x, y, SMALL, INK)?;
    }
    Ok(())
}
