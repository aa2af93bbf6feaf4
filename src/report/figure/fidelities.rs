//! Figure: every fidelity of the theory against every run: distance, depth, fold count.

use plotters::prelude::*;

use super::run_axes;
use super::sheet::{self, Area, BLUE, Chart, Drawn, FULL_WIDTH, INK, LABEL, VERMILLION, line, padded, solid, steps};
use crate::error::Error;
use crate::report::number;

const TOP: f64 = 6.0;
const PANEL: f64 = 42.0;
const BELOW: f64 = 11.0;
const LEFT: f64 = 14.0;

/// One quantity of all runs.
#[derive(Debug, Clone)]
pub struct Panel<'a> {
    pub title: &'a str,
    pub unit: &'a str,
    /// Where a theory that is right would lie.
    pub reference: f64,
    /// For each fidelity the value of each run; `None` where the theory has no such hem.
    pub series: Vec<Vec<Option<f64>>>,
}

/// The runs along the x axis, one panel for each quantity. `cells[i]` numbers the cell of run `names[i]`; runs of one cell stand together.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(names: &[String], cells: &[usize], fidelities: &[&str], panels: &[Panel<'_>]) -> Result<String, Error> {
    let height = TOP + PANEL * panels.len() as f64 + BELOW;
    sheet::draw("figure of all fidelities against all runs", FULL_WIDTH, height, |area| {
        for (i, name) in fidelities.iter().enumerate() {
            let x = LEFT + 26.0 * i as f64;
            let spot = sheet::part(area, x, 0.0, 4.0, 5.0);
            let mut axes = ChartBuilder::on(&spot).build_cartesian_2d(0.0..1.0, 0.0..1.0)?;
            mark(&mut axes, i, (0.5, 0.5))?;
            sheet::text_left(area, name, x + 4.5, 2.5, LABEL, INK)?;
        }
        for (row, panel) in panels.iter().enumerate() {
            paint(area, names, cells, panel, row, row + 1 == panels.len())?;
        }
        let y = TOP + PANEL * panels.len() as f64 + 6.5;
        sheet::text_centre(area, "run; runs of one cell stand together", LEFT + 0.5 * (FULL_WIDTH - LEFT), y, LABEL, INK)
    })
}

fn paint(area: &Area<'_>, names: &[String], cells: &[usize], panel: &Panel<'_>, row: usize, last: bool) -> Drawn {
    let top = TOP + PANEL * row as f64;
    sheet::title(area, &format!("{}, n = {}", panel.title, names.len()), 0.5, top + 2.5)?;
    let plot = sheet::part(area, 0.0, top + 5.5, FULL_WIDTH - 1.0, PANEL - 7.5);
    let end = names.len() as f64 + 1.0;
    let y = padded(panel.series.iter().flatten().copied().flatten().chain([panel.reference]), 0.08);
    let mut axes = run_axes::axes(&plot, (LEFT, 0.0), end, y, panel.unit, &|v| number::fixed(v, usize::from(y.1 - y.0 < 4.0)))?;
    solid(&mut axes, &[(0.0, panel.reference), (end, panel.reference)], line(INK, 0.25))?;
    run_axes::between_cells(&mut axes, cells.iter().copied(), y)?;
    // Marks of one run stand side by side.
    let fidelities = panel.series.len() as f64;
    for (fidelity, values) in panel.series.iter().enumerate() {
        let aside = 0.5 * ((fidelity as f64 + 0.5) / fidelities - 0.5);
        for (i, value) in values.iter().enumerate() {
            if let Some(value) = value {
                mark(&mut axes, fidelity, (i as f64 + 1.0 + aside, *value))?;
            }
        }
    }
    if last {
        let across = (LEFT, FULL_WIDTH - 1.0);
        let marks: Vec<(f64, &str)> =
            names.iter().enumerate().map(|(i, name)| (sheet::along(across, i, names.len()), name.as_str())).collect();
        sheet::names_along(area, &marks, top + PANEL + 1.2)?;
    }
    Ok(())
}

/// The mark of a fidelity: shapes differ, so that they are told apart without colour.
fn mark(axes: &mut Chart<'_, '_>, fidelity: usize, at: (f64, f64)) -> Drawn {
    match fidelity {
        0 => sheet::dots(axes, &[at], 0.75, BLUE)?,
        1 => {
            axes.draw_series(std::iter::once(Circle::new(at, steps(0.7), line(VERMILLION, 0.3))))?;
        }
        _ => {
            axes.draw_series(std::iter::once(Cross::new(at, steps(0.65), line(INK, 0.25))))?;
        }
    }
    Ok(())
}
