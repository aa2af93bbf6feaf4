//! Figure: the design as a square or cube, with what the full model gives at each corner.

use plotters::prelude::*;

use super::main_effects::{estimate, level_name, with_unit};
use super::sheet::{self, BLUE, Drawn, GREY, INK, SMALL, fill, line, steps};
use crate::error::Error;
use crate::experiment::Factor;
use crate::report::number;
use crate::statistics::box_wilson::Coefficient;

/// Size on paper, mm.
pub const WIDTH: f64 = 60.0;
pub const HEIGHT: f64 = 44.0;

/// Corner values of the full model; in a full factorial these are the cell means. `None` unless there are two or three factors.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(response: &str, unit: &str, n: usize, factors: &[Factor], coefficients: &[Coefficient]) -> Result<Option<String>, Error> {
    if !(2..=3).contains(&factors.len()) {
        return Ok(None);
    }
    let svg = sheet::draw(&format!("cube of {response}"), WIDTH, HEIGHT, |area| {
        sheet::title(area, &format!("{}, n = {n}", with_unit(response, unit)), 0.5, 2.5)?;
        paint(area, factors, coefficients)
    })?;
    Ok(Some(svg))
}

fn paint(area: &sheet::Area<'_>, factors: &[Factor], coefficients: &[Coefficient]) -> Drawn {
    let three = factors.len() == 3;
    let place = |x: f64, y: f64, z: f64| {
        let (dx, dy) = if three { (9.5 * z, -6.0 * z) } else { (0.0, 0.0) };
        (28.0 + 13.5 * x + 0.5 * dx, 21.5 - 8.6 * y + 0.5 * dy)
    };
    let mut corners = vec![];
    for i in 0..1 << factors.len() {
        let level = |k: usize| if i >> k & 1 == 1 { 1.0 } else { -1.0 };
        corners.push([level(0), level(1), if three { level(2) } else { -1.0 }]);
    }
    for a in &corners {
        for b in &corners {
            let apart = a.iter().zip(b).filter(|(p, q)| p != q).count();
            if apart == 1 && a < b {
                let (from, to) = (place(a[0], a[1], a[2]), place(b[0], b[1], b[2]));
                let hidden = three && a[2] == 1.0 && b[2] == 1.0;
                let style = if hidden { line(GREY, 0.2) } else { line(INK, 0.3) };
                area.draw(&PathElement::new(vec![(steps(from.0), steps(from.1)), (steps(to.0), steps(to.1))], style))?;
            }
        }
    }
    let values: Vec<f64> = corners.iter().map(|c| at_corner(factors, coefficients, c)).collect();
    let spread = values.iter().fold(0.0_f64, |m, v| m.max((v - values[0]).abs()));
    let places = (2.0 - spread.max(1e-12).log10().floor()).clamp(0.0, 6.0) as usize;
    for (corner, value) in corners.iter().zip(&values) {
        let (x, y) = place(corner[0], corner[1], corner[2]);
        area.draw(&Circle::new((steps(x), steps(y)), steps(0.8), fill(BLUE)))?;
        let text = number::fixed(*value, places);
        let half = 0.66 * text.chars().count() as f64 + 0.4;
        let (cx, cy) = (x, y - 2.6);
        area.draw(&Rectangle::new([(steps(cx - half), steps(cy - 1.3)), (steps(cx + half), steps(cy + 1.2))], fill(WHITE)))?;
        sheet::text_centre(area, &text, cx, cy, SMALL, INK)?;
    }
    axis_names(area, factors)
}

/// Which way each factor rises.
fn axis_names(area: &sheet::Area<'_>, factors: &[Factor]) -> Drawn {
    let between = |name: &str, factor: &Factor, direction: &str| {
        let unit = factor.unit.as_deref().map(|u| format!(" {u}")).unwrap_or_default();
        format!("{name}: {} → {}{unit}, {direction}", level_name(factor, -1.0), level_name(factor, 1.0))
    };
    let directions = ["to the right", "upwards", "to the back"];
    for (i, (factor, direction)) in factors.iter().zip(directions).enumerate() {
        let y = HEIGHT - 7.8 + 3.0 * i as f64;
        // What it is where that fits, else its name.
        let (size, room) = (5.8, WIDTH - 2.0);
        let whole = between(&factor.label, factor, direction);
        let text = if size <= sheet::fitted(&whole, room, size) { whole } else { between(&factor.name, factor, direction) };
        sheet::text_left(area, &text, 1.0, y, sheet::fitted(&text, room, size), INK)?;
    }
    Ok(())
}

/// The full model at one corner: the sum over all terms of the estimate times the product of its factors' levels.
fn at_corner(factors: &[Factor], coefficients: &[Coefficient], corner: &[f64; 3]) -> f64 {
    let mut sum = 0.0;
    for subset in 0..1usize << factors.len() {
        let chosen: Vec<usize> = (0..factors.len()).filter(|k| subset >> k & 1 == 1).collect();
        let term =
            if chosen.is_empty() { "1".into() } else { chosen.iter().map(|&k| factors[k].name.as_str()).collect::<Vec<_>>().join(":") };
        let sign: f64 = chosen.iter().map(|&k| corner[k]).product();
        sum += sign * estimate(coefficients, &term);
    }
    sum
}
