//! Figure: flexural rigidity identified from the hem against the one measured on the cloth, on logarithmic scales, with the 1:1 line.

use plotters::prelude::*;

use super::sheet::{
    self, Area, BLUE, Chart, Drawn, Frame, GREY, INK, LABEL, PALE, SMALL, VERMILLION, chart, dots, line, padded, solid, steps,
};
use crate::error::Error;
use crate::report::number;

/// Size on paper, mm.
pub const WIDTH: f64 = 110.0;
pub const HEIGHT: f64 = 108.0;

/// Round the axes, mm.
const TOP: f64 = 10.5;
const RIGHT: f64 = 2.0;
const UNDER: f64 = 0.5;

/// The estimates through one energy.
#[derive(Debug, Clone)]
pub struct Series {
    pub name: String,
    pub points: Vec<Point>,
}

/// One run, µN·m.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    pub known: f64,
    pub estimated: f64,
    /// Standard error of the estimate's natural logarithm.
    pub relative_error: f64,
}

/// Estimated over known; bars are one standard error either way.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(series: &[Series]) -> Result<String, Error> {
    sheet::draw("figure of identified rigidities", WIDTH, HEIGHT, |area| {
        sheet::title(area, "Flexural rigidity from the hem against that of the cloth", 0.5, 2.5)?;
        let points = || series.iter().flat_map(|s| &s.points);
        let range = padded(points().flat_map(|p| [p.known.log10(), p.estimated.log10()]), 0.08);
        let frame =
            Frame { x: range, y: range, x_label: "known B, µN·m", y_label: "B from the hem, µN·m", bare: true, ..Frame::default() };
        let plot = sheet::part(area, 0.0, TOP, WIDTH - RIGHT, HEIGHT - TOP - UNDER);
        let mut axes = chart(&plot, &frame)?;
        grid(area, &mut axes, range, (frame.left, frame.below))?;
        solid(&mut axes, &[(range.0, range.0), (range.1, range.1)], line(GREY, 0.25))?;
        for (i, series) in series.iter().enumerate() {
            for p in &series.points {
                let (x, y, half) = (p.known.log10(), p.estimated.log10(), p.relative_error * std::f64::consts::LOG10_E);
                let ends = [(x, (y - half).max(range.0)), (x, (y + half).min(range.1))];
                solid(&mut axes, &ends, line(if i == 0 { BLUE } else { VERMILLION }, 0.15))?;
                mark(&mut axes, i, (x, y))?;
            }
        }
        for (i, series) in series.iter().enumerate() {
            let x = 14.0 + 45.0 * i as f64;
            let spot = sheet::part(area, x, 5.5, 4.0, 5.0);
            let mut legend = ChartBuilder::on(&spot).build_cartesian_2d(0.0..1.0, 0.0..1.0)?;
            mark(&mut legend, i, (0.5, 0.5))?;
            sheet::text_left(area, &format!("{}, n = {}", series.name, series.points.len()), x + 4.5, 8.0, LABEL, INK)?;
        }
        Ok(())
    })
}

/// Lines and numbers at 1, 2 and 5 of every decade.
fn grid(area: &Area<'_>, axes: &mut Chart<'_, '_>, range: (f64, f64), (left, below): (f64, f64)) -> Drawn {
    let (right, bottom) = (WIDTH - RIGHT, HEIGHT - UNDER - below);
    let along = |v: f64| (v - range.0) / (range.1 - range.0);
    for decade in range.0.floor() as i32..=range.1.ceil() as i32 {
        for step in [1.0, 2.0, 5.0] {
            let value = step * 10f64.powi(decade);
            let at = value.log10();
            if !(range.0..=range.1).contains(&at) {
                continue;
            }
            solid(axes, &[(at, range.0), (at, range.1)], line(PALE, 0.1))?;
            solid(axes, &[(range.0, at), (range.1, at)], line(PALE, 0.1))?;
            let name = number::plain(value);
            sheet::text_centre(area, &name, left + along(at) * (right - left), bottom + 2.2, SMALL, INK)?;
            sheet::text_right(area, &name, left - 1.2, bottom - along(at) * (bottom - TOP), SMALL, INK)?;
        }
    }
    Ok(())
}

/// Discs and circles: told apart without colour.
fn mark(axes: &mut Chart<'_, '_>, series: usize, at: (f64, f64)) -> Drawn {
    if series == 0 {
        return dots(axes, &[at], 0.8, BLUE);
    }
    axes.draw_series(std::iter::once(Circle::new(at, steps(0.8), line(VERMILLION, 0.3))))?;
    Ok(())
}
