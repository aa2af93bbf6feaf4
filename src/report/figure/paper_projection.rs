//! Figure 2 of the paper: the plan view of a skirt of big conicity, whose hem meets a ray from the axis more than once.

use std::f64::consts::TAU;

use plotters::prelude::*;

use super::sheet::{self, Area, BLUE, Drawn, Frame, GREY, INK, SMALL, VERMILLION, chart, dashed, line, solid, steps};
use crate::error::Error;
use crate::experiment::Skirt;
use crate::model::hem::{Hem, Placement};
use crate::report::number::fixed;
use crate::units::CENTIMETRE;

/// Size on paper, mm.
pub const WIDTH: f64 = 100.0;
pub const HEIGHT: f64 = 112.0;
/// Points on the curve.
const POINTS: usize = 1440;

/// The hem of `skirt` with its waist and a ray that it crosses three times.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(heading: &str, origin: &str, skirt: &Skirt, hem: &Hem) -> Result<String, Error> {
    sheet::draw("the paper's Figure 2", WIDTH, HEIGHT, |area| paint(area, heading, origin, skirt, hem))
}

fn paint(area: &Area<'_>, heading: &str, origin: &str, skirt: &Skirt, hem: &Hem) -> Drawn {
    sheet::title(area, heading, 0.5, 2.5)?;
    let cm = |metres: f64, places: usize| fixed(metres / CENTIMETRE, places);
    let dimensions = format!(
        "Rₜ = {} cm, Rₙ = {} cm, L = {} cm; {origin} m = {}",
        cm(skirt.waist_radius().0, 1),
        cm(skirt.hem_radius().0, 1),
        cm(skirt.slant_length().0, 1),
        hem.folds
    );
    sheet::text_left(area, &dimensions, 0.5, 6.8, SMALL, INK)?;
    let (left, below, top) = (12.0, 9.5, 9.5);
    let side = WIDTH - left - 2.0;
    let plot = sheet::part(area, 0.0, top, left + side, side + below);
    let half = 1.12 * hem.radius_range().1 / CENTIMETRE;
    let frame = Frame { left, below, ..Frame::plan((0.0, 0.0), half) };
    let mut axes = chart(&plot, &frame)?;
    let waist = skirt.waist_radius().0 / CENTIMETRE;
    dashed(&mut axes, &circle(waist), line(GREY, 0.3), 1.4, 0.9)?;
    let outline: Vec<(f64, f64)> = (0..=POINTS)
        .map(|i| hem.point(&Placement::ORIGIN, TAU * i as f64 / POINTS as f64))
        .map(|p| (p.x / CENTIMETRE, p.y / CENTIMETRE))
        .collect();
    solid(&mut axes, &outline, line(BLUE, 0.55))?;
    axes.draw_series(std::iter::once(Cross::new((0.0, 0.0), steps(1.0), line(GREY, 0.2))))?;
    let ray = ray(hem);
    if let Some((direction, crossings)) = &ray {
        let on = |radius: f64| (radius * direction.cos() / CENTIMETRE, radius * direction.sin() / CENTIMETRE);
        solid(&mut axes, &[(0.0, 0.0), on(0.98 * half * CENTIMETRE)], line(VERMILLION, 0.25))?;
        let marks: Vec<(f64, f64)> = crossings.iter().map(|&r| on(r)).collect();
        sheet::dots(&mut axes, &marks, 0.8, VERMILLION)?;
    }
    let y = HEIGHT - 2.2;
    let rule =
        |from: f64, to: f64, style: ShapeStyle| area.draw(&PathElement::new(vec![(steps(from), steps(y)), (steps(to), steps(y))], style));
    rule(1.0, 6.0, line(BLUE, 0.55))?;
    for from in [17.0, 18.9, 20.8] {
        rule(from, from + 1.2, line(GREY, 0.3))?;
    }
    for (x, name) in [(7.2, "hem"), (23.2, "waist")] {
        sheet::text_left(area, name, x, y, SMALL, INK)?;
    }
    if ray.is_some() {
        rule(36.0, 41.0, line(VERMILLION, 0.3))?;
        sheet::text_left(area, "a ray from the axis and where it meets the hem", 42.2, y, SMALL, INK)?;
    }
    Ok(())
}

fn circle(radius: f64) -> Vec<(f64, f64)> {
    (0..=240).map(|i| TAU * f64::from(i) / 240.0).map(|a| (radius * a.cos(), radius * a.sin())).collect()
}

/// A direction in which the hem is met more than once, and the distances: midway between the turns of the polar angle along the first flank.
fn ray(hem: &Hem) -> Option<(f64, Vec<f64>)> {
    let at = |i: usize| {
        let t = TAU * i as f64 / POINTS as f64;
        let local = hem.local(t).position;
        (t + local.1.atan2(local.0), local.0.hypot(local.1))
    };
    let polar: Vec<(f64, f64)> = (0..=POINTS).map(at).collect();
    let turn = (1..POINTS).find(|&i| polar[i + 1].0 < polar[i].0)?;
    let back = (turn + 1..POINTS).find(|&i| polar[i].0 < polar[i + 1].0)?;
    let direction = 0.5 * (polar[turn].0 + polar[back].0);
    let crossings = polar
        .windows(2)
        .filter(|pair| (pair[0].0 < direction) != (pair[1].0 < direction))
        .map(|pair| pair[0].1 + (pair[1].1 - pair[0].1) * (direction - pair[0].0) / (pair[1].0 - pair[0].0))
        .collect();
    Some((direction, crossings))
}
