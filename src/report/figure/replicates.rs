//! Figures: the replicates of one cell laid over each other, and all cells so at one scale.
//!
//! Every hem is moved to its own centre and turned by the phase of its fitted curve, so that a crest of each points to the right. A hem without folds has no
//! phase and is not turned.

use plotters::prelude::*;

use super::sheet::{
    self, Area, BLUE, Chart, Drawn, FULL_WIDTH, Frame, GREEN, GREY, INK, LABEL, ORANGE, PALE, SMALL, VERMILLION, chart, dashed, line,
    solid, steps,
};
use crate::error::Error;
use crate::experiment::Point;
use crate::report::number::fixed;
use crate::units::{CENTIMETRE, MILLIMETRE};

/// How the hems were laid over each other, as the figures say it.
const ALIGNED: &str = "each centred, and turned so that a crest of its fitted curve points right";

/// Height of the figure of one cell, less its legend, mm.
const PANEL: f64 = 96.0;
const ROW: f64 = 4.0;
/// Of the cells at one scale: columns, and room for the name and the runs of each, mm.
const COLUMNS: usize = 4;
const HEAD: f64 = 9.0;
const NAME: f64 = 3.2;
const FOOT: f64 = 4.5;

/// One replicate, m, aligned.
#[derive(Debug, Clone)]
pub struct Replicate {
    pub run: String,
    pub measured: Vec<Point>,
    pub fitted: Vec<Point>,
    pub folds: Option<u32>,
    /// Root mean square distance from its fitted curve, m.
    pub rms: f64,
}

/// A cell of the design: its name in lines and its replicates.
#[derive(Debug, Clone)]
pub struct Cell {
    pub name: Vec<String>,
    pub replicates: Vec<Replicate>,
}

impl Cell {
    fn reach(&self) -> f64 {
        let points = self.replicates.iter().flat_map(|r| r.measured.iter().chain(&r.fitted));
        points.map(|p| p.x.abs().max(p.y.abs())).fold(0.0, f64::max)
    }
}

/// Measured outlines on the left, fitted curves on the right.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(cell: &Cell) -> Result<String, Error> {
    let rows = cell.replicates.len().div_ceil(3);
    let height = PANEL + ROW * rows as f64 + 1.0;
    sheet::draw("overlay of replicates", FULL_WIDTH, height, |area| paint(area, cell))
}

fn paint(area: &Area<'_>, cell: &Cell) -> Drawn {
    let name = if cell.name.is_empty() { "All runs".to_string() } else { cell.name.join(", ") };
    sheet::title(area, &name, 0.5, 2.5)?;
    let text = format!("n = {} replicates; {ALIGNED}", cell.replicates.len());
    sheet::text_left(area, &text, 0.5, 6.8, SMALL, INK)?;
    let (top, left, below) = (14.0, 12.0, 9.5);
    let side = 0.5 * FULL_WIDTH - left - 3.5;
    let half = 1.05 * cell.reach() / CENTIMETRE;
    for (column, name) in ["Measured", "Fitted"].into_iter().enumerate() {
        let from = 0.5 * FULL_WIDTH * column as f64;
        sheet::text_left(area, name, from + left, 11.6, LABEL, INK)?;
        let plot = sheet::part(area, from, top, left + side, side + below);
        let mut axes = chart(&plot, &Frame { left, below, ..Frame::plan((0.0, 0.0), half) })?;
        for (i, replicate) in cell.replicates.iter().enumerate() {
            outline(&mut axes, if column == 0 { &replicate.measured } else { &replicate.fitted }, i, 0.35)?;
        }
        axes.draw_series(std::iter::once(Cross::new((0.0, 0.0), steps(1.0), line(GREY, 0.2))))?;
    }
    for (i, replicate) in cell.replicates.iter().enumerate() {
        let (x, y) = (left + 52.0 * (i % 3) as f64, PANEL + ROW * (i / 3) as f64);
        key(area, i, x, y)?;
        sheet::text_left(area, &said(replicate), x + 9.0, y, SMALL, INK)?;
    }
    Ok(())
}

fn said(replicate: &Replicate) -> String {
    let folds = replicate.folds.map_or_else(|| "no folds".to_string(), |m| format!("m = {m}"));
    format!("run {} · {folds} · rms {} mm", replicate.run, fixed(replicate.rms / MILLIMETRE, 1))
}

/// The colour of the `i`th replicate, and the lengths of dash and gap of its line, mm: the first five differ in both, and no two of 25 are drawn
/// alike.
fn style(i: usize) -> (RGBColor, Option<(f64, f64)>) {
    const COLORS: [RGBColor; 5] = [INK, BLUE, VERMILLION, GREEN, ORANGE];
    const DASHES: [Option<(f64, f64)>; 5] = [None, Some((2.4, 0.9)), Some((1.2, 0.8)), Some((0.5, 0.6)), Some((3.6, 1.8))];
    // The second round of colours is shifted against the dashes.
    (COLORS[(i + i / 5) % 5], DASHES[i % 5])
}

fn outline(axes: &mut Chart<'_, '_>, points: &[Point], i: usize, width: f64) -> Drawn {
    // Closer points than a tenth of a millimetre show nothing, and a dash must be longer than its chord.
    let stride = (points.len() / 360).max(1);
    let mut round: Vec<(f64, f64)> = points.iter().step_by(stride).map(|p| (p.x / CENTIMETRE, p.y / CENTIMETRE)).collect();
    round.extend(round.first().copied());
    if round.is_empty() {
        return Ok(());
    }
    match style(i) {
        (color, None) => solid(axes, &round, line(color, width)),
        (color, Some((dash, gap))) => dashed(axes, &round, line(color, width), dash, gap),
    }
}

fn key(area: &Area<'_>, i: usize, x: f64, y: f64) -> Drawn {
    let (color, dashes) = style(i);
    let (dash, gap) = dashes.unwrap_or((8.0, 0.0));
    let mut from = 0.0;
    while from < 7.9 {
        let to = (from + dash).min(8.0);
        area.draw(&PathElement::new(vec![(steps(x + from), steps(y)), (steps(x + to), steps(y))], line(color, 0.4)))?;
        from = to + gap;
    }
    Ok(())
}

/// All cells at one scale, each with the measured outlines of its replicates.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw_cells(cells: &[Cell]) -> Result<String, Error> {
    let columns = cells.len().clamp(1, COLUMNS);
    let width = FULL_WIDTH / columns.max(2) as f64;
    let lines = cells.iter().map(|cell| cell.name.len()).max().unwrap_or(0) as f64;
    let side = width - 3.0;
    let height = NAME * lines + side + FOOT + 3.0;
    let sheet_height = HEAD + height * cells.len().div_ceil(columns) as f64;
    let reach = cells.iter().map(Cell::reach).fold(0.0, f64::max);
    sheet::draw("small multiples of the cells", FULL_WIDTH, sheet_height, |area| {
        let runs: usize = cells.iter().map(|cell| cell.replicates.len()).sum();
        sheet::text_left(area, &format!("Measured hems cell by cell, n = {runs} runs"), 0.5, 2.2, LABEL, INK)?;
        sheet::text_left(area, ALIGNED, 0.5, 6.0, SMALL, INK)?;
        scale_bar(area, side / (2.0 * 1.03 * reach))?;
        for (i, cell) in cells.iter().enumerate() {
            let (left, top) = (width * (i % columns) as f64, HEAD + height * (i / columns) as f64);
            area.draw(&PathElement::new(vec![(steps(left), steps(top)), (steps(left + width - 1.5), steps(top))], line(PALE, 0.2)))?;
            for (k, name) in cell.name.iter().enumerate() {
                sheet::text_left(area, name, left + 0.5, top + 2.4 + NAME * k as f64, SMALL, INK)?;
            }
            let from = top + 1.0 + NAME * lines;
            let plot = sheet::part(area, left + 1.0, from, side, side);
            let half = 1.03 * reach / CENTIMETRE;
            let mut axes = ChartBuilder::on(&plot).build_cartesian_2d(-half..half, -half..half)?;
            for (k, replicate) in cell.replicates.iter().enumerate() {
                outline(&mut axes, &replicate.measured, k, 0.25)?;
            }
            axes.draw_series(std::iter::once(Cross::new((0.0, 0.0), steps(0.6), line(GREY, 0.2))))?;
            let runs: Vec<&str> = cell.replicates.iter().map(|r| r.run.as_str()).collect();
            let said = format!("{} {}", if runs.len() == 1 { "run" } else { "runs" }, runs.join(", "));
            let size = sheet::fitted(&said, width - 2.0, SMALL);
            sheet::text_centre(area, &said, left + 1.0 + 0.5 * side, from + side + 2.0, size, INK)?;
        }
        Ok(())
    })
}

/// A bar of ten centimetres; `scale` in mm of paper for a metre.
fn scale_bar(area: &Area<'_>, scale: f64) -> Drawn {
    let (y, right) = (2.6, FULL_WIDTH - 14.0);
    let bar = 0.1 * scale;
    area.draw(&PathElement::new(vec![(steps(right - bar), steps(y)), (steps(right), steps(y))], line(GREY, 0.6)))?;
    sheet::text_left(area, "10 cm", right + 1.5, y, LABEL, INK)
}

/// Moved to the origin and turned back by the phase.
pub fn aligned(points: &[Point], centre: Point, phase: f64) -> Vec<Point> {
    let (sin, cos) = phase.sin_cos();
    let turned = |p: &Point| {
        let (x, y) = (p.x - centre.x, p.y - centre.y);
        Point::new(x * cos + y * sin, y * cos - x * sin)
    };
    points.iter().map(turned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::hem::{Hem, Placement};

    #[test]
    fn the_same_hem_laid_down_elsewhere_comes_to_lie_on_itself() {
        let hem = Hem { p: 0.2, q: 0.05, s: 0.01, folds: 6 };
        let placed = |x0: f64, y0: f64, phase: f64| aligned(&hem.outline(&Placement { x0, y0, phase }, 100), Point::new(x0, y0), phase);
        for (a, b) in placed(0.0, 0.0, 0.0).iter().zip(placed(0.3, -0.1, 0.7)) {
            assert!(a.distance(b) < 1e-15);
        }
    }

    #[test]
    fn twenty_five_replicates_are_drawn_in_as_many_ways() {
        let styles: Vec<_> = (0..25).map(style).collect();
        for (i, a) in styles.iter().enumerate() {
            assert!(styles[..i].iter().all(|b| a != b), "{i}");
        }
    }
}
