//! Figure: half-normal plot of the coefficients, for telling effects from noise where there are no replicates, and for seeing outliers among them.

use plotters::style::text_anchor::HPos;

use super::sheet::{self, BLUE, Drawn, GREY, INK, SMALL, chart, dashed, dots, line};
use crate::error::Error;
use crate::report::number;

/// Size on paper, mm.
pub const WIDTH: f64 = 82.0;
pub const HEIGHT: f64 = 55.0;

/// One coefficient: its term, |estimate| and the half-normal quantile that its rank corresponds to.
#[derive(Debug, Clone)]
pub struct Score {
    pub term: String,
    pub magnitude: f64,
    pub quantile: f64,
}

/// `margin` is Lenth's margin of error, beyond which a coefficient stands out.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(response: &str, unit: &str, n: usize, scores: &[Score], margin: Option<f64>) -> Result<String, Error> {
    sheet::draw(&format!("half-normal plot of {response}"), WIDTH, HEIGHT, |area| {
        sheet::title(area, &format!("{response}: half-normal plot, n = {n}"), 0.5, 2.5)?;
        paint(area, unit, scores, margin)
    })
}

fn paint(area: &sheet::Area<'_>, unit: &str, scores: &[Score], margin: Option<f64>) -> Drawn {
    let most = scores.iter().map(|s| s.magnitude).chain(margin).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let label = if unit.is_empty() { "|coefficient|".to_string() } else { format!("|coefficient|, {unit}") };
    let top = scores.iter().map(|s| s.quantile).fold(1.0, f64::max) * 1.12;
    let frame =
        sheet::Frame { x: (0.0, 1.25 * most), y: (0.0, top), x_label: &label, y_label: "half-normal quantile", ..sheet::Frame::default() };
    let plot = sheet::part(area, 0.0, 9.0, WIDTH - 1.0, HEIGHT - 9.0);
    let mut axes = chart(&plot, &frame)?;
    if let Some(margin) = margin {
        dashed(&mut axes, &[(margin, 0.0), (margin, top)], line(sheet::VERMILLION, 0.3), 1.2, 0.8)?;
        let text = format!("Lenth’s margin {}", number::significant(margin, 3));
        sheet::text_right(area, &text, WIDTH - 1.0, 6.6, SMALL, GREY)?;
    }
    let points: Vec<(f64, f64)> = scores.iter().map(|s| (s.magnitude, s.quantile)).collect();
    dots(&mut axes, &points, 0.8, BLUE)?;
    let mut below = f64::NEG_INFINITY;
    for score in scores.iter().filter(|s| 0.25 * most < s.magnitude) {
        // Neighbouring ranks are a line apart; a closer one stays unnamed rather than overprinted.
        if 0.06 * top < score.quantile - below {
            sheet::note(
                &mut axes,
                &score.term.replace(':', " × "),
                (score.magnitude, score.quantile),
                1.3,
                sheet::mark(SMALL, INK, HPos::Left),
            )?;
            below = score.quantile;
        }
    }
    Ok(())
}
