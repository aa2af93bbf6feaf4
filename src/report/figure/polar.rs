//! Figure: one hem unrolled, radius against polar angle; where the hem overhangs, its line runs back.

use std::f64::consts::{PI, TAU};

use plotters::prelude::*;

use super::hem::View;
use super::sheet::{self, Area, BLUE, Drawn, FULL_WIDTH, Frame, INK, PALE, SMALL, VERMILLION, chart, dashed, line, padded, solid, steps};
use crate::error::Error;
use crate::experiment::Point;
use crate::report::number::fixed;
use crate::units::CENTIMETRE;

/// Height on paper, mm; it is as wide as a page's text.
pub const HEIGHT: f64 = 66.0;

/// An eighth of a turn: what the ticks count in.
const TICK: f64 = PI / 4.0;
const LEFT: f64 = 13.0;

/// The figure of one run, its polar angles about the centre of the fitted curve, from 0° along the x axis of the measurement.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(view: &View) -> Result<String, Error> {
    sheet::draw(&format!("unrolled hem of run {}", view.run), FULL_WIDTH, HEIGHT, |area| paint(area, view))
}

fn paint(area: &Area<'_>, view: &View) -> Drawn {
    sheet::title(area, &format!("Run {}: the hem unrolled", view.run), 0.5, 2.5)?;
    sheet::text_left(area, &view.caption, 0.5, 6.8, SMALL, INK)?;
    let unrolled = |points: &[Point]| unroll(points, view.centre);
    let (measured, fitted, predicted) = (unrolled(&view.measured), unrolled(&view.fitted), unrolled(&view.predicted));
    let all = measured.iter().chain(&fitted).chain(&predicted);
    let y = padded(all.map(|p| p.1), 0.06);
    let plot = sheet::part(area, 0.0, 9.0, FULL_WIDTH - 3.0, HEIGHT - 14.0);
    let frame = Frame {
        x: (0.0, TAU / TICK),
        y,
        x_label: "polar angle, °",
        y_label: "radius, cm",
        x_ticks: 9,
        y_ticks: 6,
        left: LEFT,
        x_names: Some(&|v| fixed(45.0 * v, 0)),
        ..Frame::default()
    };
    let mut axes = chart(&plot, &frame)?;
    // Where the fitted hem overhangs, a ray from the centre meets it more than once.
    for (from, to) in overhangs(&fitted) {
        axes.draw_series(std::iter::once(Rectangle::new([(from, y.0), (to, y.1)], PALE.mix(0.8).filled())))?;
    }
    for piece in pieces(&predicted) {
        dashed(&mut axes, &piece, line(VERMILLION, 0.4), 2.0, 1.2)?;
    }
    let style = if view.is_dense() { sheet::underlay(BLUE, 0.8) } else { line(BLUE, 0.45) };
    for piece in pieces(&fitted) {
        solid(&mut axes, &piece, style)?;
    }
    if view.is_dense() {
        for piece in pieces(&measured) {
            solid(&mut axes, &piece, line(INK, 0.2))?;
        }
    } else {
        let once: Vec<(f64, f64)> = measured.iter().map(|p| (p.0.rem_euclid(TAU / TICK), p.1)).collect();
        sheet::dots(&mut axes, &once, 0.45, INK)?;
    }
    legend(area, view, !overhangs(&fitted).is_empty())
}

/// Polar angle (in ticks, going on round the centre, closed) and radius (cm) of points in order round the hem.
fn unroll(points: &[Point], centre: Point) -> Vec<(f64, f64)> {
    let mut unrolled: Vec<(f64, f64)> = Vec::with_capacity(points.len() + 1);
    for point in points.iter().chain(points.first()) {
        let (x, y) = (point.x - centre.x, point.y - centre.y);
        let angle = y.atan2(x);
        let before = unrolled.last().map_or(angle.rem_euclid(TAU), |last| last.0 * TICK);
        // The turn of this angle that is nearest to the point before.
        let angle = angle + TAU * ((before - angle) / TAU).round();
        unrolled.push((angle / TICK, x.hypot(y) / CENTIMETRE));
    }
    unrolled
}

/// The line cut where it leaves the sheet on one side, each piece brought back between 0 and a whole turn.
fn pieces(unrolled: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
    let turn = TAU / TICK;
    let mut pieces: Vec<Vec<(f64, f64)>> = vec![];
    let mut now = f64::NAN;
    for pair in unrolled.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let (first, last) = ((from.0 / turn).floor(), (to.0 / turn).floor());
        let at = |p: (f64, f64), round: f64| (p.0 - round * turn, p.1);
        if first != now {
            pieces.push(vec![at(from, first)]);
            now = first;
        }
        let piece = pieces.last_mut().expect("one was begun");
        if first == last {
            piece.push(at(to, first));
        } else {
            // It crosses a whole turn: both pieces end at the edge.
            let edge = turn * first.max(last);
            let share = (edge - from.0) / (to.0 - from.0);
            let radius = from.1 + share * (to.1 - from.1);
            piece.push((edge - first * turn, radius));
            pieces.push(vec![(edge - last * turn, radius), at(to, last)]);
            now = last;
        }
    }
    pieces
}

/// Ranges of the polar angle, within one turn, over which the line runs back.
fn overhangs(unrolled: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let turn = TAU / TICK;
    let forward = match (unrolled.first(), unrolled.last()) {
        (Some(first), Some(last)) => (last.0 - first.0).signum(),
        _ => return vec![],
    };
    let mut ranges: Vec<(f64, f64)> = vec![];
    let mut back: Option<(f64, f64)> = None;
    for pair in unrolled.windows(2) {
        let (a, b) = (pair[0].0, pair[1].0);
        if (b - a) * forward < 0.0 {
            let (low, high) = back.unwrap_or((a, a));
            back = Some((low.min(b), high.max(b)));
        } else {
            ranges.extend(back.take());
        }
    }
    ranges.extend(back);
    let within = |(low, high): (f64, f64)| {
        let shift = (low / turn).floor() * turn;
        let (low, high) = (low - shift, high - shift);
        if high <= turn { vec![(low, high)] } else { vec![(low, turn), (0.0, high - turn)] }
    };
    ranges.into_iter().flat_map(within).collect()
}

fn legend(area: &Area<'_>, view: &View, overhangs: bool) -> Drawn {
    let y = HEIGHT - 2.2;
    let mut x = LEFT;
    let rule =
        |from: f64, to: f64, style: ShapeStyle| area.draw(&PathElement::new(vec![(steps(from), steps(y)), (steps(to), steps(y))], style));
    if view.is_dense() {
        rule(x, x + 4.0, line(INK, 0.2))?;
    } else {
        area.draw(&Circle::new((steps(x + 2.0), steps(y)), steps(0.5), sheet::fill(INK)))?;
    }
    sheet::text_left(area, "measured", x + 5.0, y, SMALL, INK)?;
    x += 24.0;
    if !view.fitted.is_empty() {
        rule(x, x + 4.5, if view.is_dense() { sheet::underlay(BLUE, 0.8) } else { line(BLUE, 0.45) })?;
        sheet::text_left(area, "fitted", x + 5.5, y, SMALL, INK)?;
        x += 20.0;
    }
    if !view.predicted.is_empty() {
        for i in 0..2 {
            let from = x + 2.7 * f64::from(i);
            rule(from, from + 1.8, line(VERMILLION, 0.4))?;
        }
        sheet::text_left(area, "predicted", x + 5.5, y, SMALL, INK)?;
        x += 25.0;
    }
    if overhangs {
        area.draw(&Rectangle::new([(steps(x), steps(y - 1.2)), (steps(x + 4.5), steps(y + 1.2))], PALE.mix(0.8).filled()))?;
        sheet::text_left(area, "the fitted hem overhangs", x + 5.5, y, SMALL, INK)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::hem::{Hem, Placement};

    #[test]
    fn a_hem_that_overhangs_runs_back_in_every_fold_and_another_nowhere() {
        let outline = |s: f64| Hem { p: 0.2, q: 0.05, s, folds: 6 }.outline(&Placement { x0: 0.1, y0: 0.0, phase: 0.3 }, 600);
        let centre = Point::new(0.1, 0.0);
        assert!(overhangs(&unroll(&outline(0.005), centre)).is_empty());
        let back = overhangs(&unroll(&outline(0.03), centre));
        // Two flanks a fold; one of them may straddle the edge of the sheet and then counts twice.
        assert!((12..=13).contains(&back.len()), "{back:?}");
        assert!(back.iter().all(|(low, high)| 0.0 <= *low && *high <= 8.0 && low < high));
    }

    #[test]
    fn every_piece_stays_on_the_sheet_and_together_they_are_the_whole_hem() {
        let outline = Hem { p: 0.2, q: 0.05, s: 0.03, folds: 6 }.outline(&Placement { x0: 0.0, y0: 0.0, phase: 0.1 }, 600);
        let unrolled = unroll(&outline, Point::new(0.0, 0.0));
        assert!((unrolled.last().unwrap().0 - unrolled[0].0 - 8.0).abs() < 1e-9);
        let pieces = pieces(&unrolled);
        assert!(pieces.iter().flatten().all(|p| -1e-9 <= p.0 && p.0 <= 8.0 + 1e-9));
        let length = |piece: &[(f64, f64)]| piece.windows(2).map(|p| p[1].0 - p[0].0).sum::<f64>();
        assert!((pieces.iter().map(|p| length(p)).sum::<f64>() - 8.0).abs() < 1e-9);
    }
}
