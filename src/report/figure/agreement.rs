//! Figure: predicted against fitted radius, depth and fold count, with the 1:1 line.

use std::collections::BTreeMap;

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::sheet::{self, BLUE, Drawn, Frame, GREY, INK, SMALL, chart, dots, line, padded, solid, steps};
use crate::error::Error;
use crate::report::number;

/// Size on paper, mm.
pub const WIDTH: f64 = 170.0;
pub const HEIGHT: f64 = 60.0;

/// One run: fitted and predicted; lengths in mm.
#[derive(Debug, Clone)]
pub struct Pair {
    pub run: String,
    pub fitted: f64,
    pub predicted: f64,
}

/// Three panels: mean radius and depth at the fitted fold count, and the fold count that the theory chooses itself.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(mean_radius: &[Pair], depth: &[Pair], folds: &[Pair]) -> Result<String, Error> {
    sheet::draw("figure of prediction against measurement", WIDTH, HEIGHT, |area| {
        lengths(area, 0, "Mean radius", "mm", mean_radius)?;
        lengths(area, 1, "Fold depth", "mm", depth)?;
        counts(area, 2, folds)
    })
}

fn panel<'a>(area: &sheet::Area<'a>, column: usize, name: &str, n: usize) -> Result<sheet::Area<'a>, Box<dyn std::error::Error>> {
    let width = WIDTH / 3.0;
    let left = width * column as f64;
    sheet::title(area, &format!("{name}, n = {n}"), left + 1.0, 2.5)?;
    // The square plot is 13 mm less wide and 10 mm less high than its panel.
    Ok(sheet::part(area, left, 6.0, width - 2.0, width - 2.0 - 13.0 + 10.0))
}

fn lengths(area: &sheet::Area<'_>, column: usize, name: &str, unit: &str, pairs: &[Pair]) -> Drawn {
    let plot = panel(area, column, name, pairs.len())?;
    let range = padded(pairs.iter().flat_map(|p| [p.fitted, p.predicted]), 0.08);
    let (x_label, y_label) = (format!("fitted, {unit}"), format!("predicted, {unit}"));
    let frame = Frame { x: range, y: range, x_label: &x_label, y_label: &y_label, x_ticks: 5, left: 13.0, ..Frame::default() };
    let mut axes = chart(&plot, &frame)?;
    one_to_one(&mut axes, range)?;
    dots(&mut axes, &pairs.iter().map(|p| (p.fitted, p.predicted)).collect::<Vec<_>>(), 0.8, BLUE)?;
    // The run that the theory misses by most is named.
    let worst = pairs.iter().max_by(|a, b| (a.predicted - a.fitted).abs().total_cmp(&(b.predicted - b.fitted).abs()));
    if let Some(pair) = worst {
        named(&mut axes, pair, pairs, range)?;
    }
    Ok(())
}

/// Names a run where no other mark lies, on the far side from the 1:1 line if that is free; with a thin line to its mark where that is not the nearest.
fn named(axes: &mut sheet::Chart<'_, '_>, pair: &Pair, pairs: &[Pair], range: (f64, f64)) -> Drawn {
    let scale = (WIDTH / 3.0 - 15.0) / (range.1 - range.0);
    // On the sheet, mm from the lower left corner of the plot, up.
    let place = |p: &Pair| (scale * (p.fitted - range.0), scale * (p.predicted - range.0));
    let (side, (x, y)) = (scale * (range.1 - range.0), place(pair));
    let text = format!("run {}", sheet::shortened(&pair.run, 10));
    // Half a width and half a height of the letters, with some air.
    let (half, high) = (0.5 * 0.62 * 0.353 * SMALL * text.chars().count() as f64 + 0.4, 1.4);
    let away = if pair.fitted < pair.predicted { 1.0 } else { -1.0 };
    let mut best: Option<(usize, f64, f64)> = None;
    for distance in [2.4, 4.4, 6.6, 9.0] {
        for up in [away, -away] {
            for aside in [0.0, half, -half, 2.0 * half, -2.0 * half] {
                let (cx, cy) = (x + aside, y + up * distance);
                if cx - half < 0.3 || side - 0.3 < cx + half || cy - high < 0.3 || side - 0.3 < cy + high {
                    continue;
                }
                let hit = pairs.iter().map(place).filter(|p| (p.0 - cx).abs() < half + 0.8 && (p.1 - cy).abs() < high + 0.8).count();
                // The 1:1 line crosses the box if its upper left and lower right corners lie on either side.
                let crossed = usize::from((cy + high > cx - half) && (cy - high < cx + half));
                if best.is_none_or(|(known, ..)| hit + crossed < known) {
                    best = Some((hit + crossed, cx, cy));
                }
            }
        }
    }
    let Some((_, cx, cy)) = best else { return Ok(()) };
    let back = |x: f64, y: f64| (range.0 + x / scale, range.0 + y / scale);
    if 3.0 < (cy - y).abs() {
        let edge = if y < cy { cy - high } else { cy + high };
        solid(axes, &[back(x, y), back(cx, edge)], line(INK, 0.12))?;
    }
    axes.draw_series(std::iter::once(Circle::new((pair.fitted, pair.predicted), steps(0.8), line(INK, 0.3))))?;
    sheet::note(axes, &text, back(cx, cy), 0.0, sheet::mark(SMALL, INK, HPos::Center))
}

/// Counts coincide: a disc's area is the number of runs, and the number stands in it.
fn counts(area: &sheet::Area<'_>, column: usize, pairs: &[Pair]) -> Drawn {
    let plot = panel(area, column, "Fold count", pairs.len())?;
    let (low, high) = padded(pairs.iter().flat_map(|p| [p.fitted, p.predicted]), 0.0);
    let range = (low.floor() - 1.0, high.ceil() + 1.0);
    let ticks = (range.1 - range.0) as usize + 1;
    let frame = Frame {
        x: range,
        y: range,
        x_label: "fitted m",
        y_label: "predicted m",
        x_ticks: ticks.min(12),
        y_ticks: ticks.min(12),
        left: 13.0,
        x_names: Some(&|v| number::fixed(v, 0)),
        y_names: Some(&|v| number::fixed(v, 0)),
        ..Frame::default()
    };
    let mut axes = chart(&plot, &frame)?;
    one_to_one(&mut axes, range)?;
    let mut together: BTreeMap<(i64, i64), usize> = BTreeMap::new();
    for pair in pairs {
        *together.entry((pair.fitted.round() as i64, pair.predicted.round() as i64)).or_default() += 1;
    }
    for (&(fitted, predicted), &runs) in &together {
        let at = (fitted as f64, predicted as f64);
        let radius = 1.1 * (runs as f64).sqrt().min(2.4) + 0.5;
        axes.draw_series(std::iter::once(Circle::new(at, steps(radius), sheet::fill(sheet::SKY))))?;
        sheet::note(&mut axes, &runs.to_string(), at, 0.0, sheet::mark(SMALL, INK, HPos::Center))?;
    }
    Ok(())
}

fn one_to_one(axes: &mut sheet::Chart<'_, '_>, range: (f64, f64)) -> Drawn {
    solid(axes, &[(range.0, range.0), (range.1, range.1)], line(GREY, 0.25))
}
