//! Figure: the Lagrange multiplier of every run, two ways, each above how well its relation holds.

use plotters::prelude::*;

use super::run_axes;
use super::sheet::{self, Area, BLUE, Chart, Drawn, FULL_WIDTH, GREY, INK, LABEL, SMALL, VERMILLION, dashed, line, padded, solid, steps};
use crate::error::Error;
use crate::report::number;

const TOP: f64 = 7.0;
const PANEL: f64 = 38.0;
const BELOW: f64 = 10.0;
const LEFT: f64 = 17.0;

/// How well the relation of a λ holds, as the document says it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holds {
    Well,
    Roughly,
    Badly,
}

impl Holds {
    /// By the R² of the first integral.
    pub fn by_determination(r2: f64) -> Self {
        match r2 {
            r2 if 0.9 <= r2 => Holds::Well,
            r2 if 0.5 <= r2 => Holds::Roughly,
            _ => Holds::Badly,
        }
    }

    /// By the angle between the gradients, degrees.
    pub fn by_angle(angle: f64) -> Self {
        match angle {
            angle if angle < 5.0 => Holds::Well,
            angle if angle < 20.0 => Holds::Roughly,
            _ => Holds::Badly,
        }
    }
}

/// One λ: value, standard error, and the measure of how well it holds.
#[derive(Debug, Clone, Copy)]
pub struct Way {
    pub value: f64,
    pub standard_error: Option<f64>,
    pub measure: f64,
    pub holds: Holds,
}

/// One run.
#[derive(Debug, Clone)]
pub struct Run {
    pub run: String,
    /// Number of its cell: runs of one cell stand together.
    pub cell: usize,
    pub first_integral: Option<Way>,
    pub ritz: Option<Way>,
}

/// Four panels over the runs: λ by the first integral and its R², λ by the Ritz condition and its angle. `unit` of λ, empty where it is a pure number;
/// `name` is “λ” or “λ/(ρg)”.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(runs: &[Run], name: &str, unit: &str) -> Result<String, Error> {
    let across = (LEFT, FULL_WIDTH - 1.0);
    let names: Vec<(f64, &str)> = runs.iter().enumerate().map(|(i, run)| (sheet::along(across, i, runs.len()), run.run.as_str())).collect();
    sheet::draw("figure of the multipliers", FULL_WIDTH, TOP + 4.0 * PANEL + BELOW, |area| {
        legend(area)?;
        let first =
            |pick: fn(&Way) -> f64| -> Vec<Option<(Way, f64)>> { runs.iter().map(|r| r.first_integral.map(|w| (w, pick(&w)))).collect() };
        let ritz = |pick: fn(&Way) -> f64| -> Vec<Option<(Way, f64)>> { runs.iter().map(|r| r.ritz.map(|w| (w, pick(&w)))).collect() };
        let label = if unit.is_empty() { name.to_string() } else { format!("{name}, {unit}") };
        let n = |values: &[Option<(Way, f64)>]| values.iter().flatten().count();
        let values = first(|w| w.value);
        let title = format!("First integral: {name}, n = {}; 95 % whiskers, cut at the edge", n(&values));
        panel(area, runs, 0, &title, &label, &values, true, &[])?;
        panel(area, runs, 1, "First integral: how well it holds (1 is best)", "R²", &first(|w| w.measure), false, &[0.5, 0.9])?;
        let values = ritz(|w| w.value);
        let title = format!("Ritz condition: {name}, n = {}; 95 % whiskers, cut at the edge", n(&values));
        panel(area, runs, 2, &title, &label, &values, true, &[])?;
        panel(
            area,
            runs,
            3,
            "Ritz condition: angle between the gradients (0 is best)",
            "angle, °",
            &ritz(|w| w.measure),
            false,
            &[5.0, 20.0],
        )?;
        sheet::names_along(area, &names, TOP + 4.0 * PANEL + 0.8)?;
        let y = TOP + 4.0 * PANEL + 6.0;
        sheet::text_centre(area, "run; runs of one cell stand together", LEFT + 0.5 * (FULL_WIDTH - LEFT), y, LABEL, INK)
    })
}

fn legend(area: &Area<'_>) -> Drawn {
    for (i, (holds, name)) in [
        (Holds::Well, "holds (R² from 0.9, angle below 5°)"),
        (Holds::Roughly, "holds roughly (from 0.5, below 20°)"),
        (Holds::Badly, "holds badly"),
    ]
    .into_iter()
    .enumerate()
    {
        let x = [LEFT, LEFT + 57.0, LEFT + 112.0][i];
        let spot = sheet::part(area, x - 2.0, 0.0, 4.0, 5.0);
        let mut axes = ChartBuilder::on(&spot).build_cartesian_2d(0.0..1.0, 0.0..1.0)?;
        mark(&mut axes, (0.5, 0.5), holds)?;
        sheet::text_left(area, name, x + 2.0, 2.5, SMALL, INK)?;
    }
    Ok(())
}

/// Shapes differ, so that they are told apart without colour.
fn mark(axes: &mut Chart<'_, '_>, at: (f64, f64), holds: Holds) -> Drawn {
    match holds {
        Holds::Well => sheet::dots(axes, &[at], 0.8, BLUE)?,
        Holds::Roughly => {
            axes.draw_series(std::iter::once(Circle::new(at, steps(0.75), line(BLUE, 0.3))))?;
        }
        Holds::Badly => {
            axes.draw_series(std::iter::once(Cross::new(at, steps(0.65), line(VERMILLION, 0.3))))?;
        }
    }
    Ok(())
}

#[expect(clippy::too_many_arguments)]
fn panel(
    area: &Area<'_>,
    runs: &[Run],
    row: usize,
    title: &str,
    unit: &str,
    values: &[Option<(Way, f64)>],
    whiskers: bool,
    limits: &[f64],
) -> Drawn {
    let top = TOP + PANEL * row as f64;
    sheet::title(area, title, 0.5, top + 2.5)?;
    let plot = sheet::part(area, 0.0, top + 5.5, FULL_WIDTH - 1.0, PANEL - 7.5);
    let end = runs.len() as f64 + 1.0;
    let y = padded(values.iter().flatten().map(|v| v.1).chain(limits.iter().copied()).chain([0.0]), 0.08);
    let mut axes =
        run_axes::axes(&plot, (LEFT, 0.0), end, y, unit, &|v| number::plain(if v.abs() < 1e-9 * (y.1 - y.0) { 0.0 } else { v }))?;
    solid(&mut axes, &[(0.0, 0.0), (end, 0.0)], line(INK, 0.2))?;
    for &limit in limits {
        dashed(&mut axes, &[(0.0, limit), (end, limit)], line(GREY, 0.2), 1.2, 0.8)?;
    }
    run_axes::between_cells(&mut axes, runs.iter().map(|run| run.cell), y)?;
    for (i, value) in values.iter().enumerate() {
        let Some((way, value)) = value else { continue };
        let x = i as f64 + 1.0;
        if let Some(error) = way.standard_error.filter(|_| whiskers) {
            // 95 % of a normal error, cut where the panel ends.
            let ends = [value - 1.96 * error, value + 1.96 * error].map(|end| end.clamp(y.0, y.1));
            solid(&mut axes, &[(x, ends[0]), (x, ends[1])], line(GREY, 0.2))?;
        }
        mark(&mut axes, (x, *value), way.holds)?;
    }
    Ok(())
}
