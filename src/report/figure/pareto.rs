//! Figure: Pareto chart of standardized effects |t|, with the line beyond which a coefficient is significant.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::sheet::{self, BLUE, Drawn, GREY, INK, PALE, SMALL, fill, line, steps};
use crate::error::Error;
use crate::report::number;
use crate::statistics::box_wilson::Coefficient;

/// Width on paper, mm.
pub const WIDTH: f64 = 82.0;

/// From bar to bar, mm.
const PITCH: f64 = 4.0;

/// The coefficients of one response but the mean, largest |t| first; `critical` is the t beyond which |t| is significant at `alpha`.
/// A coefficient without a standard error has no t and is left out.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(response: &str, n: usize, coefficients: &[Coefficient], critical: f64, alpha: f64) -> Result<String, Error> {
    let mut bars: Vec<(String, f64, bool)> = coefficients
        .iter()
        .filter(|c| c.term != "1")
        .filter_map(|c| Some((c.term.replace(':', " × "), c.t?.abs(), c.significant)))
        .collect();
    bars.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let height = 19.0 + PITCH * bars.len() as f64;
    sheet::draw(&format!("Pareto chart of {response}"), WIDTH, height, |area| {
        sheet::title(area, &format!("{response}: standardized effects, n = {n}"), 0.5, 2.5)?;
        paint(area, &bars, critical, alpha, height)
    })
}

fn paint(area: &sheet::Area<'_>, bars: &[(String, f64, bool)], critical: f64, alpha: f64, height: f64) -> Drawn {
    let longest = bars.iter().map(|b| b.0.chars().count()).max().unwrap_or(1) as f64;
    // DejaVu Sans is about 0.21 mm wide per point and letter.
    let left = (1.36 * longest + 2.0).clamp(8.0, 38.0);
    let (top, bottom) = (9.0, height - 9.0);
    let most = bars.iter().map(|b| b.1).fold(critical, f64::max);
    let room = WIDTH - left - 12.0;
    let across = |t: f64| left + room * t / most;
    let ticks = ticks(most);
    for &tick in &ticks {
        area.draw(&PathElement::new(vec![(steps(across(tick)), steps(top)), (steps(across(tick)), steps(bottom))], line(PALE, 0.1)))?;
        sheet::text_centre(area, &number::plain(tick), across(tick), bottom + 2.2, SMALL, INK)?;
    }
    sheet::text_centre(area, "|t| = |coefficient| / standard error", left + 0.5 * room, bottom + 6.2, sheet::LABEL, INK)?;
    for (i, (term, t, significant)) in bars.iter().enumerate() {
        let y = top + 0.6 + PITCH * i as f64;
        let corners = [(steps(left), steps(y)), (steps(across(*t)), steps(y + 2.8))];
        // Significance is told by filling, so it survives grey print.
        if *significant {
            area.draw(&Rectangle::new(corners, fill(BLUE)))?;
        } else {
            area.draw(&Rectangle::new(corners, fill(PALE)))?;
        }
        area.draw(&Rectangle::new(corners, line(BLUE, 0.2)))?;
        sheet::text_right(area, term, left - 1.2, y + 1.4, SMALL, INK)?;
        let at = across(*t) + 1.0;
        let beyond_line = (across(critical) - at).abs() < 7.0 && at < across(critical);
        let at = if beyond_line { across(critical) + 1.0 } else { at };
        area.draw_text(&number::fixed(*t, 1), &sheet::mark(SMALL, INK, HPos::Left), (steps(at), steps(y + 1.4)))?;
    }
    area.draw(&PathElement::new(vec![(steps(left), steps(top)), (steps(left), steps(bottom))], line(GREY, 0.2)))?;
    let mut from = top - 1.0;
    while from < bottom {
        let to = (from + 1.2).min(bottom);
        area.draw(&PathElement::new(
            vec![(steps(across(critical)), steps(from)), (steps(across(critical)), steps(to))],
            line(sheet::VERMILLION, 0.3),
        ))?;
        from += 2.0;
    }
    let text = format!("t = {} (α = {})", number::fixed(critical, 2), number::plain(alpha));
    sheet::text_left(area, &text, across(critical).min(WIDTH - 32.0), top - 2.4, SMALL, sheet::VERMILLION)
}

/// Round values from 0 to `most`: a step of 1, 2 or 5 times a power of ten that gives three to six of them.
fn ticks(most: f64) -> Vec<f64> {
    let raw = most / 4.0;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|s| s * power).find(|s| raw <= *s).unwrap_or(10.0 * power);
    (0..).map(|i| f64::from(i) * step).take_while(|t| *t <= most).collect()
}
