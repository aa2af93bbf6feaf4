//! Figure: theory minus measurement in mm, run by run.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::run_axes;
use super::sheet::{self, BLUE, Drawn, FULL_WIDTH, INK, SMALL, VERMILLION, dashed, line, padded, solid, steps};
use crate::error::Error;
use crate::report::number;

const PANEL: f64 = 40.0;
const BELOW: f64 = 11.0;

/// One run's differences, mm, in the order in which they are drawn.
#[derive(Debug, Clone)]
pub struct Gap {
    pub run: String,
    /// Runs of one cell of the design have the same number and stand together.
    pub cell: usize,
    /// Root mean square distance of the measured points from the predicted hem.
    pub rms: f64,
    /// Predicted minus fitted.
    pub mean_radius: f64,
    /// Predicted minus fitted.
    pub depth: f64,
    /// Root mean square distance of the measured points from the fitted curve: what no hem of this family can beat by much.
    pub fit_rms: f64,
}

/// Three panels over the runs: shape, mean radius, depth. `medians` are drawn as reference lines.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(gaps: &[Gap], medians: [f64; 3]) -> Result<String, Error> {
    sheet::draw("figure of theory minus measurement", FULL_WIDTH, 3.0 * PANEL + BELOW, |area| {
        let rms: Vec<f64> = gaps.iter().map(|g| g.rms).collect();
        let floor: Vec<f64> = gaps.iter().map(|g| g.fit_rms).collect();
        panel(
            area,
            gaps,
            0,
            "Shape: rms distance of the points from the predicted hem (open: from the fitted curve)",
            &rms,
            Some(&floor),
            medians[0],
        )?;
        let radius: Vec<f64> = gaps.iter().map(|g| g.mean_radius).collect();
        panel(area, gaps, 1, "Mean radius, predicted − fitted", &radius, None, medians[1])?;
        let depth: Vec<f64> = gaps.iter().map(|g| g.depth).collect();
        panel(area, gaps, 2, "Fold depth, predicted − fitted", &depth, None, medians[2])
    })
}

fn panel(area: &sheet::Area<'_>, gaps: &[Gap], row: usize, name: &str, values: &[f64], floor: Option<&[f64]>, median: f64) -> Drawn {
    let top = PANEL * row as f64;
    let last = row == 2;
    sheet::title(area, &format!("{name}, n = {}", gaps.len()), 0.5, top + 2.5)?;
    let left = 14.0;
    let below = if last { BELOW } else { 2.0 };
    let plot = sheet::part(area, 0.0, top + 5.5, FULL_WIDTH - 1.0, PANEL - 7.5 + below);
    // The last tenth is left to the median's label.
    let end = 1.1 * gaps.len() as f64 + 1.0;
    let y = padded(values.iter().chain(floor.unwrap_or_default()).copied().chain([0.0]), 0.08);
    let mut axes = run_axes::axes(&plot, (left, below), end, y, "mm", &|v| number::fixed(v, usize::from(y.1 - y.0 < 4.0)))?;
    solid(&mut axes, &[(0.0, 0.0), (end, 0.0)], line(INK, 0.25))?;
    dashed(&mut axes, &[(0.0, median), (end, median)], line(VERMILLION, 0.3), 1.4, 0.9)?;
    run_axes::between_cells(&mut axes, gaps.iter().map(|gap| gap.cell), y)?;
    for (i, value) in values.iter().enumerate() {
        let x = (i + 1) as f64;
        solid(&mut axes, &[(x, 0.0), (x, *value)], line(BLUE, 0.35))?;
        sheet::dots(&mut axes, &[(x, *value)], 0.75, BLUE)?;
        if let Some(floor) = floor {
            axes.draw_series(std::iter::once(Circle::new((x, floor[i]), steps(0.7), line(INK, 0.25))))?;
        }
    }
    if last {
        let at = |i: usize| left + (FULL_WIDTH - 1.0 - left) * (i as f64 + 1.0) / end;
        let names: Vec<(f64, &str)> = gaps.iter().enumerate().map(|(i, gap)| (at(i), gap.run.as_str())).collect();
        sheet::names_along(area, &names, top + PANEL + 1.2)?;
    }
    // On the side of its line that has more paper.
    let up = median < 0.5 * (y.0 + y.1);
    let place = Pos::new(HPos::Right, if up { VPos::Bottom } else { VPos::Top });
    let aside = steps(if up { -0.5 } else { 0.5 });
    for (lines, text) in
        [(if up { 1 } else { 0 }, "median".to_string()), (if up { 0 } else { 1 }, format!("{} mm", number::signed(median, 1)))]
    {
        let down = aside + if up { -lines } else { lines } * steps(2.6);
        let label = Text::new(text, (0, down), sheet::mark(SMALL, VERMILLION, HPos::Right).pos(place));
        axes.draw_series(std::iter::once(EmptyElement::at((end, median)) + label))?;
    }
    if last {
        sheet::text_centre(
            area,
            "run; runs of one cell stand together",
            left + 0.5 * (FULL_WIDTH - left),
            top + PANEL + 6.5,
            sheet::LABEL,
            INK,
        )?;
    }
    Ok(())
}
