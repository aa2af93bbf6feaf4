//! Figure: main effects, the response that the full model gives at either level of each factor, the others at their middle.

use super::sheet::{self, BLUE, Drawn, GREY, INK, chart, dashed, dots, line, padded, solid};
use crate::error::Error;
use crate::experiment::Factor;
use crate::report::number;
use crate::statistics::box_wilson::Coefficient;

/// Size on paper, mm.
pub const WIDTH: f64 = 82.0;
pub const HEIGHT: f64 = 44.0;

/// One panel a factor: `b0 ± b_i` with the 95 % interval of the effect as a whisker; dashed where the coefficient is not significant.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(response: &str, unit: &str, n: usize, factors: &[Factor], coefficients: &[Coefficient]) -> Result<String, Error> {
    sheet::draw(&format!("main effects of {response}"), WIDTH, HEIGHT, |area| {
        sheet::title(area, &format!("{response}: main effects, n = {n}"), 0.5, 2.5)?;
        paint(area, &with_unit(response, unit), factors, coefficients)
    })
}

fn paint(area: &sheet::Area<'_>, label: &str, factors: &[Factor], coefficients: &[Coefficient]) -> Drawn {
    let mean = estimate(coefficients, "1");
    let effects: Vec<(&Factor, Option<&Coefficient>)> =
        factors.iter().map(|f| (f, coefficients.iter().find(|c| c.term == f.name))).collect();
    let spread = effects.iter().filter_map(|(_, c)| *c).flat_map(|c| {
        let half = half_width(c);
        [mean - c.estimate.abs() - half, mean + c.estimate.abs() + half]
    });
    let y = padded(spread.chain([mean]), 0.08);
    let left = 14.0;
    let width = (WIDTH - left - 1.0) / factors.len().max(1) as f64;
    for (i, (factor, coefficient)) in effects.iter().enumerate() {
        let first = i == 0;
        let margin = if first { left } else { 0.0 };
        let from = left - margin + width * i as f64;
        let panel = sheet::part(area, from, 6.0, width + margin - 1.5, HEIGHT - 10.5);
        let names = |v: f64| level_name(factor, v);
        let frame = sheet::Frame {
            x: (-1.6, 1.6),
            y,
            y_label: if first { label } else { "" },
            x_ticks: 3,
            left: margin,
            below: 6.0,
            x_names: Some(&names),
            ..sheet::Frame::default()
        };
        let mut axes = chart(&panel, &frame)?;
        let name = factor_name(factor);
        let size = sheet::fitted(&name, width - 2.0, sheet::LABEL);
        sheet::text_centre(area, &name, from + margin + 0.5 * width - 0.75, HEIGHT - 2.6, size, INK)?;
        dashed(&mut axes, &[(-1.6, mean), (1.6, mean)], line(GREY, 0.15), 1.0, 0.8)?;
        let Some(c) = coefficient else { continue };
        let ends = [(-1.0, mean - c.estimate), (1.0, mean + c.estimate)];
        if c.significant {
            solid(&mut axes, &ends, line(BLUE, 0.5))?;
        } else {
            dashed(&mut axes, &ends, line(BLUE, 0.35), 1.2, 0.9)?;
        }
        let half = half_width(c);
        for (x, middle) in ends {
            solid(&mut axes, &[(x, middle - half), (x, middle + half)], line(INK, 0.2))?;
        }
        dots(&mut axes, &ends, 0.8, BLUE)?;
    }
    Ok(())
}

/// Natural level at ±1, nothing elsewhere.
pub fn level_name(factor: &Factor, coded: f64) -> String {
    if (coded.abs() - 1.0).abs() > 1e-6 {
        return String::new();
    }
    number::plain(factor.natural(coded))
}

/// A factor's name, as the coefficients have it, with its unit.
pub fn factor_name(factor: &Factor) -> String {
    with_unit(&factor.name, factor.unit.as_deref().unwrap_or_default())
}

/// “fold depth, mm”.
pub fn with_unit(response: &str, unit: &str) -> String {
    if unit.is_empty() { response.to_string() } else { format!("{response}, {unit}") }
}

/// A coefficient's estimate; a term that is not in the model counts nothing.
pub fn estimate(coefficients: &[Coefficient], term: &str) -> f64 {
    coefficients.iter().find(|c| c.term == term).map_or(0.0, |c| c.estimate)
}

fn half_width(c: &Coefficient) -> f64 {
    c.ci_high.zip(c.ci_low).map_or(0.0, |(high, low)| 0.5 * (high - low))
}
