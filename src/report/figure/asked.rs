//! Figure: the error that was asked for against the error that was delivered.

use plotters::prelude::*;

use super::sheet::{self, BLUE, Drawn, Frame, GREEN, GREY, INK, ORANGE, SKY, SMALL, VERMILLION, line, steps};
use super::work_precision::{decades, power_of_ten, ticks};
use crate::error::Error;
use crate::study::accuracy::{Measure, Panel, Row};
use crate::units::MILLIMETRE;

const WIDTH: f64 = 120.0;
const HEIGHT: f64 = 84.0;
const NAMES: f64 = 38.0;
/// Errors below this are rounding, and are drawn here, mm.
const FLOOR: f64 = 1e-14;
const COLOURS: [RGBColor; 6] = [BLUE, VERMILLION, GREEN, INK, ORANGE, SKY];

/// Every row that was asked for an accuracy: filled where it claims to have reached it, open where it says that it has not.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(panels: &[Panel]) -> Result<String, Error> {
    let rows: Vec<(&Row, f64, f64)> = panels
        .iter()
        .flat_map(|panel| &panel.rows)
        .filter_map(|row| {
            let (asked, error) = (row.asked?, row.error?);
            let error = match asked.measure {
                Measure::Rms => error.rms,
                Measure::Max => error.max,
            };
            Some((row, (asked.slack * asked.error / MILLIMETRE).log10(), (error / MILLIMETRE).max(FLOOR).log10()))
        })
        .collect();
    sheet::draw("figure of accuracy asked and delivered", WIDTH, HEIGHT, |area| {
        sheet::title(area, &format!("Accuracy asked and delivered, n = {}", rows.len()), 1.0, 3.0)?;
        paint(area, &rows)
    })
}

fn paint(area: &sheet::Area<'_>, rows: &[(&Row, f64, f64)]) -> Drawn {
    let half_a_decade = |(low, high): (f64, f64)| (low - 0.5, high + 0.5);
    let (x, y) = (half_a_decade(decades(rows.iter().map(|r| r.1))), half_a_decade(decades(rows.iter().map(|r| r.2))));
    let plot = sheet::part(area, 0.0, 6.0, WIDTH - NAMES, HEIGHT - 7.0);
    let frame = Frame {
        x,
        y,
        x_label: "asked, times its slack, mm",
        y_label: "error, mm",
        x_ticks: ticks(x),
        y_ticks: ticks(y),
        x_names: Some(&power_of_ten),
        y_names: Some(&power_of_ten),
        ..Frame::default()
    };
    let mut chart = sheet::chart(&plot, &frame)?;
    let (low, high) = (x.0.max(y.0), x.1.min(y.1));
    if low < high {
        sheet::solid(&mut chart, &[(low, low), (high, high)], line(GREY, 0.35))?;
    }
    let mut names: Vec<&str> = Vec::new();
    for (row, across, up) in rows {
        let group = names.iter().position(|name| *name == row.method).unwrap_or_else(|| {
            names.push(&row.method);
            names.len() - 1
        });
        let color = COLOURS[group % 6];
        if row.claims {
            sheet::dots(&mut chart, &[(*across, *up)], 0.9, color)?;
        } else {
            chart.draw_series(std::iter::once(Circle::new((*across, *up), steps(0.9), line(color, 0.35))))?;
        }
    }
    let left = WIDTH - NAMES + 2.0;
    for (i, name) in names.iter().enumerate() {
        let y = 9.0 + 4.6 * i as f64;
        area.draw(&Circle::new((steps(left), steps(y)), steps(0.9), sheet::fill(COLOURS[i % 6])))?;
        sheet::text_left(area, name, left + 2.0, y, SMALL, INK)?;
    }
    let y = 9.0 + 4.6 * names.len() as f64 + 3.0;
    for (i, text) in ["open: the program says", "that it did not get there;", "line: error = asked × slack"].iter().enumerate() {
        sheet::text_left(area, text, left - 1.0, y + 3.6 * i as f64, SMALL, GREY)?;
    }
    Ok(())
}
