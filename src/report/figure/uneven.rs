//! Figure: one uneven hem under three curves, its folds numbered, and how deep and wide each of them is.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::hem::{centimetres, closed};
use super::sheet::{
    self, Area, BLUE, Drawn, FULL_WIDTH, Frame, GREEN, GREY, INK, LABEL, SMALL, VERMILLION, chart, dashed, line, solid, steps,
};
use crate::error::Error;
use crate::experiment::Point;
use crate::report::number;
use crate::units::CENTIMETRE;

const HEIGHT: f64 = 98.0;
const LEFT: f64 = 92.0;

/// One fold: its crest (m), depth (mm) and width (% of the length), each with its standard error.
#[derive(Debug, Clone)]
pub struct Fold {
    pub crest: Point,
    pub depth: (f64, Option<f64>),
    pub width: (f64, Option<f64>),
    /// mm; 0 if it does not lean over.
    pub overhang: f64,
}

/// One hem, m, in the frame of the measurement.
#[derive(Debug, Clone)]
pub struct View {
    pub run: String,
    pub measured: Vec<Point>,
    pub paper: Vec<Point>,
    pub tangent: Vec<Point>,
    pub free: Vec<Point>,
    pub centre: Point,
    /// Names of the three curves with their rms.
    pub names: [String; 3],
    pub folds: Vec<Fold>,
}

/// The figure.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(view: &View) -> Result<String, Error> {
    sheet::draw(&format!("figure of the uneven folds of run {}", view.run), FULL_WIDTH, HEIGHT, |area| {
        plan(area, view)?;
        let depth = |f: &Fold| f.depth;
        bars(area, view, 0.0, "Depth of each fold, mm", &depth, 0)?;
        bars(area, view, 0.5 * HEIGHT, "Width of each fold, % of the hem’s length", &|f| f.width, 1)
    })
}

fn plan(area: &Area<'_>, view: &View) -> Drawn {
    let head = sheet::part(area, 0.0, 0.0, LEFT, 5.0);
    sheet::title(&head, &format!("Run {}, n = {}", view.run, view.measured.len()), 0.5, 2.5)?;
    let (left, below, top) = (12.0, 9.5, 5.0);
    let side = LEFT - left - 8.0;
    let plot = sheet::part(area, 0.0, top, left + side, side + below);
    let all = view.measured.iter().chain(&view.paper).chain(&view.tangent).chain(&view.free);
    let reach = all.map(|p| (p.x - view.centre.x).abs().max((p.y - view.centre.y).abs())).fold(0.0, f64::max);
    let half = 1.18 * reach / CENTIMETRE;
    let (cx, cy) = (view.centre.x / CENTIMETRE, view.centre.y / CENTIMETRE);
    let mut axes = chart(&plot, &Frame { left, below, ..Frame::plan((cx, cy), half) })?;
    // Broad and pale below thin and dark: the two solid lines stay apart in grey.
    solid(&mut axes, &closed(&view.paper, 1), sheet::underlay(BLUE, 0.8))?;
    if !view.tangent.is_empty() {
        dashed(&mut axes, &closed(&view.tangent, 1), line(GREEN, 0.4), 1.6, 0.9)?;
    }
    solid(&mut axes, &closed(&view.free, 1), line(VERMILLION, 0.3))?;
    let every = view.measured.len().div_ceil(300);
    let dots: Vec<Point> = view.measured.iter().copied().step_by(every).collect();
    sheet::dots(&mut axes, &centimetres(&dots), 0.4, INK)?;
    for (i, fold) in view.folds.iter().enumerate() {
        let (x, y) = ((fold.crest.x - view.centre.x) / CENTIMETRE, (fold.crest.y - view.centre.y) / CENTIMETRE);
        let out = 1.0 + 0.11 * half / x.hypot(y);
        axes.draw_series(std::iter::once(Text::new(
            format!("{}", i + 1),
            (cx + out * x, cy + out * y),
            sheet::mark(LABEL, INK, HPos::Center),
        )))?;
    }
    let mut y = top + side + below + 1.5;
    area.draw(&Circle::new((steps(13.5), steps(y)), steps(0.5), sheet::fill(INK)))?;
    sheet::text_left(area, "measured", 17.0, y, SMALL, INK)?;
    for (i, (name, color)) in view.names.iter().zip([BLUE, GREEN, VERMILLION]).enumerate() {
        if name.is_empty() {
            continue;
        }
        if i == 1 {
            y += 3.4;
        }
        let x = [48.0, 12.0, 48.0][i];
        let ends = if i == 1 { vec![(x, x + 1.7), (x + 2.4, x + 4.1)] } else { vec![(x, x + 4.1)] };
        for (from, to) in ends {
            let style = if i == 0 { sheet::underlay(color, 0.8) } else { line(color, 0.4) };
            area.draw(&PathElement::new(vec![(steps(from), steps(y)), (steps(to), steps(y))], style))?;
        }
        sheet::text_left(area, name, x + 5.0, y, SMALL, INK)?;
    }
    Ok(())
}

fn bars(area: &Area<'_>, view: &View, top: f64, title: &str, pick: &dyn Fn(&Fold) -> (f64, Option<f64>), decimals: usize) -> Drawn {
    let (right, room) = (FULL_WIDTH - LEFT - 1.0, 0.5 * HEIGHT);
    let panel = sheet::part(area, LEFT, top, FULL_WIDTH - LEFT, room);
    sheet::title(&panel, title, 0.5, 2.5)?;
    let plot = sheet::part(area, LEFT, top + 5.5, right, room - 8.0);
    let highest = view.folds.iter().map(|f| pick(f).0).fold(0.0, f64::max);
    let mean = view.folds.iter().map(|f| pick(f).0).sum::<f64>() / view.folds.len().max(1) as f64;
    let end = view.folds.len() as f64;
    let frame = Frame {
        x: (0.4, end + 0.6),
        y: (0.0, 1.08 * highest),
        x_ticks: view.folds.len() + 1,
        y_ticks: 5,
        left: 10.0,
        below: 5.0,
        x_names: Some(&|v| if (v - v.round()).abs() < 1e-6 { number::fixed(v, 0) } else { String::new() }),
        ..Frame::default()
    };
    let mut axes = chart(&plot, &frame)?;
    for (i, fold) in view.folds.iter().enumerate() {
        let x = i as f64 + 1.0;
        let (value, error) = pick(fold);
        axes.draw_series(std::iter::once(Rectangle::new([(x - 0.3, 0.0), (x + 0.3, value)], sheet::SKY.mix(0.55).filled())))?;
        if let Some(error) = error {
            // 95 % of a normal error.
            let reach = 1.96 * error;
            solid(&mut axes, &[(x, value - reach), (x, value + reach)], line(INK, 0.3))?;
            for at in [value - reach, value + reach] {
                solid(&mut axes, &[(x - 0.08, at), (x + 0.08, at)], line(INK, 0.25))?;
            }
        }
        // At the foot of the bar, where neither the whisker nor the mean crosses it.
        let said = number::fixed(value, decimals);
        axes.draw_series(std::iter::once(Text::new(said, (x, 0.06 * highest), sheet::mark(SMALL, INK, HPos::Center))))?;
    }
    dashed(&mut axes, &[(0.4, mean), (end + 0.6, mean)], line(GREY, 0.25), 1.2, 0.8)
}
