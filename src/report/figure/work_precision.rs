//! Figure: error against work, one panel for each problem, with the Pareto front and the program's default on it.

use plotters::prelude::*;

use super::sheet::{self, BLUE, Chart, Drawn, FULL_WIDTH, Frame, GREEN, GREY, INK, ORANGE, SKY, SMALL, VERMILLION, line, steps};
use crate::error::Error;
use crate::study::accuracy::front::{Cost, front};
use crate::study::accuracy::{Panel, Row};
use crate::units::MILLIMETRE;

const COLUMNS: usize = 2;
/// Height of a panel, mm; the legend is inside, at the right.
const PANEL: f64 = 50.0;
const TITLE: f64 = 6.0;
/// Room for the names of methods right of a chart, mm.
const NAMES: f64 = 31.0;
/// Errors below this are rounding, and are drawn here, mm.
const FLOOR: f64 = 1e-14;

/// All panels in two columns.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(panels: &[Panel], cost: Cost) -> Result<String, Error> {
    let rows = panels.len().div_ceil(COLUMNS);
    let width = FULL_WIDTH / COLUMNS as f64;
    sheet::draw("figure of work and precision", FULL_WIDTH, PANEL * rows as f64, |area| {
        for (i, panel) in panels.iter().enumerate() {
            let part = sheet::part(area, width * (i % COLUMNS) as f64, PANEL * (i / COLUMNS) as f64, width, PANEL);
            paint(&part, panel, cost, width)?;
        }
        Ok(())
    })
}

/// Marks that differ in shape as well as in colour.
const COLOURS: [RGBColor; 6] = [BLUE, VERMILLION, GREEN, INK, ORANGE, SKY];

fn paint(area: &sheet::Area<'_>, panel: &Panel, cost: Cost, width: f64) -> Drawn {
    sheet::title(area, panel.title, 1.0, 3.0)?;
    let error = |row: &Row| row.error.map(|e| (e.rms / MILLIMETRE).max(FLOOR).log10());
    let place = |row: &Row| cost.of(row).filter(|c| 0.0 < *c).map(f64::log10);
    let x = decades(panel.rows.iter().filter_map(place));
    let y = decades(panel.rows.iter().filter_map(error));
    // A tenth of the height above is for what has no error.
    let y = (y.0, y.1 + 0.12 * (y.1 - y.0));
    let names: Vec<String> = groups(panel);
    let plot = sheet::part(area, 0.0, TITLE, width - NAMES, PANEL - TITLE - 1.0);
    let power = |v: f64| power_of_ten(v);
    let x_label = match cost {
        Cost::Seconds => "seconds".to_string(),
        Cost::Evaluations => panel.unit.to_string(),
    };
    let frame = Frame {
        x,
        y,
        x_label: &x_label,
        y_label: "error, mm",
        x_ticks: ticks(x),
        y_ticks: ticks(y),
        x_names: Some(&power),
        y_names: Some(&power),
        ..Frame::default()
    };
    let mut chart = sheet::chart(&plot, &frame)?;
    let on_front: Vec<(f64, f64)> =
        front(panel, cost).into_iter().filter_map(|i| Some((place(&panel.rows[i])?, error(&panel.rows[i])?))).collect();
    // Between two settings nothing better is known than the cheaper one: a stair.
    let mut stair = Vec::new();
    for (i, at) in on_front.iter().enumerate() {
        if 0 < i {
            stair.push((at.0, on_front[i - 1].1));
        }
        stair.push(*at);
    }
    sheet::solid(&mut chart, &stair, line(GREY, 0.35))?;
    for row in &panel.rows {
        let group = names.iter().position(|name| *name == group(row)).unwrap_or(0);
        let Some(across) = place(row) else { continue };
        match error(row) {
            Some(up) => mark(&mut chart, group, (across, up))?,
            None => {
                let at = (across, y.1 - 0.04 * (y.1 - y.0));
                chart.draw_series(std::iter::once(Cross::new(at, steps(0.8), line(COLOURS[group % 6], 0.35))))?;
            }
        }
        if let (true, Some(up)) = (row.default, error(row)) {
            chart.draw_series(std::iter::once(Circle::new((across, up), steps(1.7), line(INK, 0.35))))?;
        }
    }
    for (i, name) in names.iter().enumerate() {
        let top = TITLE + 2.0 + 5.0 * i as f64;
        let spot = sheet::part(area, width - NAMES + 1.0, top, 3.0, 3.0);
        let mut axes = ChartBuilder::on(&spot).build_cartesian_2d(0.0..1.0, 0.0..1.0)?;
        mark(&mut axes, i, (0.5, 0.5))?;
        sheet::text_left(area, name, width - NAMES + 4.5, top + 1.5, sheet::fitted(name, NAMES - 5.0, SMALL), INK)?;
    }
    Ok(())
}

/// Methods that differ in a size only are one group.
fn group(row: &Row) -> String {
    if row.method.starts_with("graded, K") && row.knob == "unknowns" {
        return "graded, K × J".into();
    }
    row.method.split(", close ones").next().unwrap_or_default().into()
}

fn groups(panel: &Panel) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for row in &panel.rows {
        let name = group(row);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// Whole decades about values that are logarithms already.
pub(super) fn decades(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if high < low { (0.0, 1.0) } else { (low.floor(), high.ceil().max(low.floor() + 1.0)) }
}

/// About how many ticks so many decades want.
pub(super) fn ticks((low, high): (f64, f64)) -> usize {
    ((high - low).round() as usize + 1).min(7)
}

/// 10 to a whole number; nothing between.
pub(super) fn power_of_ten(v: f64) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let whole = v.round();
    if 1e-6 < (v - whole).abs() {
        return String::new();
    }
    let sign = if whole < 0.0 { "⁻" } else { "" };
    let digits: String = format!("{}", whole.abs()).bytes().map(|b| DIGITS[usize::from(b - b'0')]).collect();
    format!("10{sign}{digits}")
}

fn mark(chart: &mut Chart<'_, '_>, group: usize, at: (f64, f64)) -> Drawn {
    let color = COLOURS[group % 6];
    match group % 3 {
        0 => sheet::dots(chart, &[at], 0.75, color)?,
        1 => {
            chart.draw_series(std::iter::once(Circle::new(at, steps(0.75), line(color, 0.35))))?;
        }
        _ => {
            chart.draw_series(std::iter::once(TriangleMarker::new(at, steps(1.0), sheet::fill(color))))?;
        }
    }
    Ok(())
}
