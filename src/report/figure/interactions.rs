//! Figure: two-factor interactions, the response over one factor at either level of another.

use plotters::prelude::*;

use super::main_effects::{estimate, factor_name, level_name, with_unit};
use super::sheet::{self, BLUE, Drawn, INK, SMALL, VERMILLION, chart, dashed, dots, line, padded, solid, steps};
use crate::error::Error;
use crate::experiment::Factor;
use crate::statistics::box_wilson::Coefficient;

/// Size on paper, mm; the width is shared by three panels.
pub const WIDTH: f64 = 108.0;
pub const HEIGHT: f64 = 44.0;
const ACROSS: usize = 3;

/// One panel for each pair of factors. Parallel lines: no interaction. Where the interaction is significant the panel says so.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(response: &str, unit: &str, n: usize, factors: &[Factor], coefficients: &[Coefficient]) -> Result<String, Error> {
    let pairs: Vec<(usize, usize)> = (0..factors.len()).flat_map(|i| (i + 1..factors.len()).map(move |j| (i, j))).collect();
    let rows = pairs.len().div_ceil(ACROSS).max(1);
    sheet::draw(&format!("interactions of {response}"), WIDTH, HEIGHT * rows as f64, |area| {
        sheet::title(area, &format!("{response}: interactions, n = {n}"), 0.5, 2.5)?;
        let corners = pairs.iter().flat_map(|&(i, j)| corner_values(factors, coefficients, i, j));
        let y = padded(corners, 0.14);
        for (k, &(i, j)) in pairs.iter().enumerate() {
            panel(area, &with_unit(response, unit), factors, coefficients, (i, j), (k / ACROSS, k % ACROSS), y)?;
        }
        Ok(())
    })
}

/// The model at (−1, −1), (+1, −1), (−1, +1), (+1, +1) of factors `i`, `j`, the others at 0.
fn corner_values(factors: &[Factor], coefficients: &[Coefficient], i: usize, j: usize) -> [f64; 4] {
    let (a, b) = (&factors[i].name, &factors[j].name);
    let interaction = estimate(coefficients, &format!("{a}:{b}"));
    let at =
        |x: f64, z: f64| estimate(coefficients, "1") + x * estimate(coefficients, a) + z * estimate(coefficients, b) + x * z * interaction;
    [at(-1.0, -1.0), at(1.0, -1.0), at(-1.0, 1.0), at(1.0, 1.0)]
}

fn panel(
    area: &sheet::Area<'_>,
    label: &str,
    factors: &[Factor],
    coefficients: &[Coefficient],
    (i, j): (usize, usize),
    (row, column): (usize, usize),
    y: (f64, f64),
) -> Drawn {
    let left = 14.0;
    let width = (WIDTH - left) / ACROSS as f64;
    let margin = if column == 0 { left } else { 0.0 };
    let (from, top) = (left - margin + width * column as f64, HEIGHT * row as f64);
    let (first, second) = (&factors[i], &factors[j]);
    let names = |v: f64| level_name(first, v);
    let frame = sheet::Frame {
        x: (-1.5, 1.5),
        y,
        y_label: if column == 0 { label } else { "" },
        x_ticks: 3,
        left: margin,
        below: 6.0,
        x_names: Some(&names),
        ..sheet::Frame::default()
    };
    let plot = sheet::part(area, from, top + 13.0, width + margin - 1.5, HEIGHT - 17.5);
    let mut axes = chart(&plot, &frame)?;
    let [mm, pm, mp, pp] = corner_values(factors, coefficients, i, j);
    dashed(&mut axes, &[(-1.0, mm), (1.0, pm)], line(VERMILLION, 0.45), 1.4, 0.9)?;
    dots(&mut axes, &[(-1.0, mm), (1.0, pm)], 0.7, VERMILLION)?;
    solid(&mut axes, &[(-1.0, mp), (1.0, pp)], line(BLUE, 0.45))?;
    dots(&mut axes, &[(-1.0, mp), (1.0, pp)], 0.7, BLUE)?;
    let significant = coefficients.iter().any(|c| c.significant && c.term == format!("{}:{}", first.name, second.name));
    let x = left + width * column as f64;
    let name = factor_name(first);
    let size = sheet::fitted(&name, width - 2.0, sheet::LABEL);
    sheet::text_centre(area, &name, from + margin + 0.5 * width - 0.75, top + HEIGHT - 2.6, size, INK)?;
    let mark = if significant { ": significant" } else { "" };
    let head = format!("{}{mark}", factor_name(second));
    sheet::text_left(area, &head, x, top + 6.6, sheet::fitted(&head, width - 2.5, SMALL), INK)?;
    for (k, coded) in [-1.0, 1.0].into_iter().enumerate() {
        let at = x + 15.0 * k as f64;
        let y = top + 10.2;
        if k == 0 {
            area.draw(&PathElement::new(vec![(steps(at), steps(y)), (steps(at + 1.2), steps(y))], line(VERMILLION, 0.45)))?;
            area.draw(&PathElement::new(vec![(steps(at + 1.9), steps(y)), (steps(at + 3.1), steps(y))], line(VERMILLION, 0.45)))?;
        } else {
            area.draw(&PathElement::new(vec![(steps(at), steps(y)), (steps(at + 3.1), steps(y))], line(BLUE, 0.45)))?;
        }
        sheet::text_left(area, &level_name(second, coded), at + 3.8, y, 6.0, INK)?;
    }
    Ok(())
}
