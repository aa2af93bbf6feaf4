//! Figure: flexural rigidity identified from the hem against the one measured on the cloth, on logarithmic scales, with the 1:1 line.

use plotters::prelude::*;

use super::sheet::{self, BLUE, Chart, Drawn, Frame, GREY, INK, LABEL, VERMILLION, chart, dots, line, padded, solid, steps};
use crate::error::Error;
use crate::report::number;

/// Size on paper, mm.
pub const WIDTH: f64 = 110.0;
pub const HEIGHT: f64 = 108.0;

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
        let names = |v: f64| number::significant(10f64.powf(v), 2);
        let frame = Frame {
            x: range,
            y: range,
            x_label: "known B, µN·m",
            y_label: "B from the hem, µN·m",
            x_ticks: 7,
            y_ticks: 7,
            x_names: Some(&names),
            y_names: Some(&names),
            ..Frame::default()
        };
        let plot = sheet::part(area, 0.0, 10.5, WIDTH - 2.0, HEIGHT - 11.0);
        let mut axes = chart(&plot, &frame)?;
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

/// Discs and circles: told apart without colour.
fn mark(axes: &mut Chart<'_, '_>, series: usize, at: (f64, f64)) -> Drawn {
    if series == 0 {
        return dots(axes, &[at], 0.8, BLUE);
    }
    axes.draw_series(std::iter::once(Circle::new(at, steps(0.8), line(VERMILLION, 0.3))))?;
    Ok(())
}
