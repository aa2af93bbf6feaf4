//! Figure: signed distance of the measured points from the fitted curve, along the outline.

use plotters::prelude::*;

use super::sheet::{self, BLUE, Drawn, Frame, GREY, INK, SMALL, chart, dashed, line, padded, solid};
use crate::error::Error;
use crate::experiment::Point;
use crate::report::number;
use crate::units::{CENTIMETRE, MILLIMETRE};

/// Size on paper, mm.
pub const WIDTH: f64 = 82.0;
pub const HEIGHT: f64 = 48.0;

/// Distances (m, positive outside) of `outline[i]`, drawn over the length travelled round the measured outline.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(run: &str, outline: &[Point], distances: &[f64], rms: f64) -> Result<String, Error> {
    let mut travelled = 0.0;
    let mut trace = Vec::with_capacity(outline.len());
    for (i, (point, distance)) in outline.iter().zip(distances).enumerate() {
        if 0 < i {
            travelled += point.distance(outline[i - 1]);
        }
        trace.push((travelled / CENTIMETRE, distance / MILLIMETRE));
    }
    sheet::draw(&format!("figure of the distances of run {run}"), WIDTH, HEIGHT, |area| paint(area, run, &trace, rms / MILLIMETRE))
}

fn paint(area: &sheet::Area<'_>, run: &str, trace: &[(f64, f64)], rms: f64) -> Drawn {
    sheet::title(area, &format!("Run {run}: distance along the outline, n = {}", trace.len()), 0.5, 2.5)?;
    sheet::text_right(area, &format!("dashed: ± rms = {} mm", number::fixed(rms, 2)), WIDTH - 1.0, 6.6, SMALL, INK)?;
    let plot = sheet::part(area, 0.0, 9.0, WIDTH - 1.0, HEIGHT - 9.0);
    let end = trace.last().map_or(1.0, |p| p.0);
    let frame = Frame {
        x: (0.0, end),
        y: padded(trace.iter().map(|p| p.1).chain([0.0, -1.3 * rms, 1.3 * rms]), 0.06),
        x_label: "length along the measured outline, cm",
        y_label: "outside +, mm",
        y_ticks: 6,
        left: 13.0,
        below: 9.5,
        ..Frame::default()
    };
    let mut axes = chart(&plot, &frame)?;
    let mut below = trace.to_vec();
    below.extend([(end, 0.0), (0.0, 0.0)]);
    axes.draw_series(std::iter::once(Polygon::new(below, sheet::SKY.mix(0.45))))?;
    solid(&mut axes, &[(0.0, 0.0), (end, 0.0)], line(INK, 0.2))?;
    for side in [-rms, rms] {
        dashed(&mut axes, &[(0.0, side), (end, side)], line(GREY, 0.2), 1.2, 0.8)?;
    }
    solid(&mut axes, trace, line(BLUE, 0.3))?;
    Ok(())
}
