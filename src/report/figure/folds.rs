//! Figure: every fold of every run, its depth and its width, so that even and uneven hems are told apart at a glance.

use plotters::prelude::*;

use super::run_axes;
use super::sheet::{self, Area, BLUE, Drawn, FULL_WIDTH, INK, LABEL, line, padded, solid, steps};
use crate::error::Error;
use crate::report::number;

const TOP: f64 = 6.5;
const PANEL: f64 = 46.0;
const BELOW: f64 = 10.0;
const LEFT: f64 = 14.0;

/// The folds of one run: depth in mm, width as a multiple of the even one.
#[derive(Debug, Clone)]
pub struct Hem {
    pub run: String,
    /// Number of its cell: runs of one cell stand together.
    pub cell: usize,
    pub depths: Vec<f64>,
    pub widths: Vec<f64>,
    /// Depth of the fitted curve's folds, which are all alike, mm.
    pub fitted: Option<f64>,
}

/// What a panel shows of a hem: a value for each fold, and where a bar goes.
type Pick<'a> = &'a dyn Fn(&Hem) -> (&[f64], Option<f64>);

/// Both panels over all runs.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(hems: &[Hem]) -> Result<String, Error> {
    sheet::draw("figure of all folds", FULL_WIDTH, TOP + 2.0 * PANEL + BELOW, |area| {
        area.draw(&Circle::new((steps(LEFT + 1.0), steps(2.5)), steps(0.6), sheet::fill(BLUE)))?;
        sheet::text_left(area, "a fold of the outline", LEFT + 3.0, 2.5, LABEL, INK)?;
        area.draw(&PathElement::new(vec![(steps(LEFT + 40.0), steps(2.5)), (steps(LEFT + 43.5), steps(2.5))], line(INK, 0.35)))?;
        sheet::text_left(area, "the folds of the paper’s curve, and folds all as wide", LEFT + 45.0, 2.5, LABEL, INK)?;
        let folds: usize = hems.iter().map(|h| h.depths.len()).sum();
        let depth = format!("Depth of each fold: crest above the mean of its valleys; n = {} hems, {folds} folds", hems.len());
        paint(area, hems, 0, &depth, "mm", &|hem| (&hem.depths, hem.fitted))?;
        paint(area, hems, 1, "Width of each fold: length from valley to valley, times the number of folds", "1 = even", &|hem| {
            (&hem.widths, Some(1.0))
        })?;
        let across = (LEFT, FULL_WIDTH - 1.0);
        let names: Vec<(f64, &str)> =
            hems.iter().enumerate().map(|(i, hem)| (sheet::along(across, i, hems.len()), hem.run.as_str())).collect();
        sheet::names_along(area, &names, TOP + 2.0 * PANEL + 0.8)?;
        let y = TOP + 2.0 * PANEL + 6.0;
        sheet::text_centre(area, "run; runs of one cell stand together", LEFT + 0.5 * (FULL_WIDTH - LEFT), y, LABEL, INK)
    })
}

fn paint(area: &Area<'_>, hems: &[Hem], row: usize, title: &str, unit: &str, pick: Pick<'_>) -> Drawn {
    let top = TOP + PANEL * row as f64;
    sheet::title(area, title, 0.5, top + 2.5)?;
    let plot = sheet::part(area, 0.0, top + 5.5, FULL_WIDTH - 1.0, PANEL - 7.5);
    let end = hems.len() as f64 + 1.0;
    let all = hems.iter().flat_map(|hem| pick(hem).0.iter().copied().chain(pick(hem).1));
    let (low, high) = padded(all, 0.08);
    let low = if row == 0 { low.min(0.0) } else { low };
    let mut axes = run_axes::axes(&plot, (LEFT, 0.0), end, (low, high), unit, &|v| number::fixed(v, usize::from(high - low < 4.0)))?;
    run_axes::between_cells(&mut axes, hems.iter().map(|hem| hem.cell), (low, high))?;
    for (i, hem) in hems.iter().enumerate() {
        let x = i as f64 + 1.0;
        let (values, reference) = pick(hem);
        let span = values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        if span.0 < span.1 {
            solid(&mut axes, &[(x, span.0), (x, span.1)], line(sheet::SKY, 0.25))?;
        }
        if let Some(reference) = reference {
            solid(&mut axes, &[(x - 0.38, reference), (x + 0.38, reference)], line(INK, 0.35))?;
        }
        sheet::dots(&mut axes, &values.iter().map(|v| (x, *v)).collect::<Vec<_>>(), 0.6, BLUE)?;
    }
    Ok(())
}
