//! Axes that several figures share: a place for every run, runs of one cell together.

use plotters::prelude::*;

use super::sheet::{self, Area, Chart, Drawn, GREY, INK, LABEL, SMALL, line, solid, steps};

/// Axes from 0 to `end` in runs and over `y`, with a label area of `left` mm and `below` mm kept free; `tick` says a value of y.
///
/// # Errors
/// What the backend refuses.
pub fn axes<'a, 'b>(
    plot: &'a Area<'b>,
    (left, below): (f64, f64),
    end: f64,
    y: (f64, f64),
    unit: &str,
    tick: &dyn Fn(f64) -> String,
) -> Result<Chart<'a, 'b>, Box<dyn std::error::Error>> {
    let mut axes = ChartBuilder::on(plot)
        .set_label_area_size(LabelAreaPosition::Left, steps(left))
        .set_label_area_size(LabelAreaPosition::Bottom, steps(below))
        .build_cartesian_2d(0.0..end, y.0..y.1)?;
    axes.configure_mesh()
        .disable_x_mesh()
        .disable_x_axis()
        .y_labels(5)
        .max_light_lines(0)
        .bold_line_style(line(sheet::PALE, 0.1))
        .axis_style(line(GREY, 0.15))
        .set_all_tick_mark_size(steps(1.0))
        .label_style(sheet::font(SMALL).color(&INK))
        .axis_desc_style(sheet::font(LABEL).color(&INK))
        .y_desc(unit)
        .y_label_formatter(&|v| tick(*v))
        .draw()?;
    Ok(axes)
}

/// A pale line between runs whose cells, in the order of the runs, differ.
///
/// # Errors
/// What the backend refuses.
pub fn between_cells(axes: &mut Chart<'_, '_>, cells: impl IntoIterator<Item = usize>, y: (f64, f64)) -> Drawn {
    let mut last = None;
    for (i, cell) in cells.into_iter().enumerate() {
        if last.is_some_and(|last| last != cell) {
            let x = i as f64 + 0.5;
            solid(axes, &[(x, y.0), (x, y.1)], line(sheet::PALE, 0.2))?;
        }
        last = Some(cell);
    }
    Ok(())
}
