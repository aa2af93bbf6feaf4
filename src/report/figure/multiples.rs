//! Figure: all hems at one scale, one row per cell of the design, so that forty runs are taken in at a glance.

use plotters::prelude::*;

use super::hem::{View, closed, curves};
use super::sheet::{self, Area, BLUE, Drawn, FULL_WIDTH, GREY, INK, LABEL, SMALL, VERMILLION, line, steps};
use crate::error::Error;
use crate::units::CENTIMETRE;

/// Tallest page, mm: the text height of A4 less a caption.
const PAGE_HEIGHT: f64 = 232.0;
const HEAD: f64 = 8.0;
/// Width of the column that names the cell.
const NAME: f64 = 22.0;
/// Caption below each hem.
const FOOT: f64 = 4.0;
/// A hem is not drawn larger than this, nor in more columns than stay readable, mm.
const LARGEST: f64 = 34.0;
const MOST_COLUMNS: usize = 6;

/// One cell of the design: its name in lines, and its hems in run order with what to print below each.
#[derive(Debug, Clone)]
pub struct Row {
    pub name: Vec<String>,
    pub hems: Vec<(View, String)>,
}

/// How many pages the small multiples take: cells with many replicates have several rows, many cells several pages.
pub fn pages(rows: &[Row]) -> usize {
    let layout = Layout::of(rows);
    rows.iter().map(|row| row.hems.len().div_ceil(layout.columns)).sum::<usize>().div_ceil(layout.per_page)
}

/// One page of small multiples, the first is 1; `None` beyond the last.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(rows: &[Row], page: usize) -> Result<Option<String>, Error> {
    let Layout { columns, width, height, per_page } = Layout::of(rows);
    let lines: Vec<Row> = rows.iter().flat_map(|row| split(row, columns)).collect();
    let reach = lines.iter().flat_map(|row| &row.hems).map(|(view, _)| view.reach()).fold(0.0, f64::max);
    let Some(lines) = lines.chunks(per_page).nth(page.saturating_sub(1)) else { return Ok(None) };
    let tall = HEAD + height * lines.len() as f64;
    sheet::draw(&format!("page {page} of small multiples"), FULL_WIDTH, tall, |area| paint(area, lines, width, height, reach)).map(Some)
}

/// How the hems are put on pages: columns, size of a place in mm, rows on a page.
struct Layout {
    columns: usize,
    width: f64,
    height: f64,
    per_page: usize,
}

impl Layout {
    fn of(rows: &[Row]) -> Self {
        let columns = rows.iter().map(|row| row.hems.len()).max().unwrap_or(0).clamp(1, MOST_COLUMNS);
        let width = (FULL_WIDTH - NAME) / columns as f64;
        // Wide cells are kept short enough that eight rows, a full 2³ design, fill one page.
        let height = (width + FOOT).min(LARGEST + FOOT).min((PAGE_HEIGHT - HEAD) / 8.0);
        let per_page = ((PAGE_HEIGHT - HEAD) / height).floor() as usize;
        Layout { columns, width, height, per_page }
    }
}

/// A row wider than the page goes on below; only its first line is named.
fn split(row: &Row, columns: usize) -> Vec<Row> {
    let line = |(i, hems): (usize, &[(View, String)])| Row { name: if i == 0 { row.name.clone() } else { vec![] }, hems: hems.to_vec() };
    row.hems.chunks(columns).enumerate().map(line).collect()
}

fn paint(area: &Area<'_>, rows: &[Row], width: f64, height: f64, reach: f64) -> Drawn {
    let side = (width - 1.0).min(height - FOOT - 1.0);
    legend(area, reach, side)?;
    for (r, row) in rows.iter().enumerate() {
        let top = HEAD + height * r as f64;
        area.draw(&PathElement::new(vec![(0, steps(top)), (steps(FULL_WIDTH), steps(top))], line(sheet::PALE, 0.15)))?;
        let first = top + 0.5 * (height - 3.2 * (row.name.len() as f64 - 1.0));
        for (i, name) in row.name.iter().enumerate() {
            sheet::text_left(area, name, 0.0, first + 3.2 * i as f64, SMALL, INK)?;
        }
        for (c, (view, caption)) in row.hems.iter().enumerate() {
            let left = NAME + width * c as f64;
            let cell = sheet::part(area, left + 0.5 * (width - side), top + 0.5, side, side);
            let half = 1.03 * reach / CENTIMETRE;
            let (cx, cy) = (view.centre.x / CENTIMETRE, view.centre.y / CENTIMETRE);
            let mut chart = ChartBuilder::on(&cell).build_cartesian_2d((cx - half)..(cx + half), (cy - half)..(cy + half))?;
            // A thumb's width resolves no more than about 130 points of a curve.
            curves(&mut chart, view, sheet::underlay(BLUE, 0.6), 0.4, 3)?;
            sheet::solid(&mut chart, &closed(&view.measured, 1), line(INK, 0.18))?;
            sheet::text_centre(area, caption, left + 0.5 * width, top + height - 1.9, 5.4, INK)?;
        }
    }
    Ok(())
}

/// Line styles, and a bar of ten centimetres in the common scale.
fn legend(area: &Area<'_>, reach: f64, side: f64) -> Drawn {
    let y = 3.0;
    area.draw(&PathElement::new(vec![(steps(0.0), steps(y)), (steps(6.0), steps(y))], line(INK, 0.18)))?;
    sheet::text_left(area, "measured", 7.5, y, LABEL, INK)?;
    area.draw(&PathElement::new(vec![(steps(27.0), steps(y)), (steps(33.0), steps(y))], sheet::underlay(BLUE, 0.6)))?;
    sheet::text_left(area, "fitted", 34.5, y, LABEL, INK)?;
    for i in 0..3 {
        let from = 49.0 + 2.4 * f64::from(i);
        area.draw(&PathElement::new(vec![(steps(from), steps(y)), (steps(from + 1.5), steps(y))], line(VERMILLION, 0.35)))?;
    }
    sheet::text_left(area, "predicted (at the fitted fold count)", 57.5, y, LABEL, INK)?;
    let scale = side / (2.0 * 1.03 * reach);
    let bar = 0.1 * scale;
    let right = FULL_WIDTH - 14.0;
    area.draw(&PathElement::new(vec![(steps(right - bar), steps(y)), (steps(right), steps(y))], line(GREY, 0.6)))?;
    sheet::text_left(area, "10 cm", right + 1.5, y, LABEL, INK)
}
