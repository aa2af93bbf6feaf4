//! Figure: residual panel of one response: against the fitted value, in run order and against the normal law.

use super::main_effects::with_unit;
use super::sheet::{self, BLUE, Drawn, GREY, chart, dashed, dots, line, padded, solid};
use crate::error::Error;

/// Size on paper, mm.
pub const WIDTH: f64 = 170.0;
pub const HEIGHT: f64 = 36.0;

/// One observation of a response, in run order.
#[derive(Debug, Clone)]
pub struct Residual {
    pub run: String,
    pub fitted: f64,
    /// Observed − fitted.
    pub residual: f64,
    /// The normal quantile that this residual's rank corresponds to.
    pub normal_quantile: Option<f64>,
}

/// Three panels over residuals in the response's unit; runs whose residual stands out are named.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(response: &str, unit: &str, residuals: &[Residual]) -> Result<String, Error> {
    sheet::draw(&format!("residuals of {response}"), WIDTH, HEIGHT, |area| {
        sheet::title(area, &format!("{response}: residuals, n = {}", residuals.len()), 0.5, 2.5)?;
        let against_fitted: Vec<_> = residuals.iter().map(|r| (r.fitted, r)).collect();
        panel(area, 0, &with_unit("fitted value", unit), &with_unit("residual", unit), &against_fitted)?;
        let in_order: Vec<_> = residuals.iter().enumerate().map(|(i, r)| ((i + 1) as f64, r)).collect();
        panel(area, 1, "run order", "", &in_order)?;
        let normal: Vec<_> = residuals.iter().filter_map(|r| Some((r.normal_quantile?, r))).collect();
        panel(area, 2, "normal quantile", "", &normal)
    })
}

fn panel(area: &sheet::Area<'_>, column: usize, x_label: &str, y_label: &str, points: &[(f64, &Residual)]) -> Drawn {
    let left = 15.0;
    let width = (WIDTH - left) / 3.0;
    let margin = if column == 0 { left } else { 0.0 };
    let plot = sheet::part(area, left - margin + width * column as f64, 6.0, width + margin - 2.5, HEIGHT - 6.0);
    let frame = sheet::Frame {
        x: padded(points.iter().map(|p| p.0), 0.08),
        y: padded(points.iter().map(|p| p.1.residual).chain([0.0]), 0.24),
        x_label,
        y_label,
        left: margin,
        ..sheet::Frame::default()
    };
    let mut axes = chart(&plot, &frame)?;
    dashed(&mut axes, &[(frame.x.0, 0.0), (frame.x.1, 0.0)], line(GREY, 0.2), 1.2, 0.8)?;
    let marks: Vec<(f64, f64)> = points.iter().map(|p| (p.0, p.1.residual)).collect();
    if column == 1 {
        solid(&mut axes, &marks, line(sheet::SKY, 0.2))?;
    }
    dots(&mut axes, &marks, 0.6, BLUE)?;
    name_extremes(&mut axes, points, &frame)
}

/// The largest residual either way is named by its run.
fn name_extremes(axes: &mut sheet::Chart<'_, '_>, points: &[(f64, &Residual)], frame: &sheet::Frame<'_>) -> Drawn {
    let by_residual = |a: &&(f64, &Residual), b: &&(f64, &Residual)| a.1.residual.total_cmp(&b.1.residual);
    let (lowest, highest) = (points.iter().min_by(by_residual), points.iter().max_by(by_residual));
    let names = [(lowest, false), (highest.filter(|_| points.len() != 1), true)];
    for (point, above) in names {
        if let Some((x, residual)) = point {
            sheet::name_run(axes, &residual.run, (*x, residual.residual), frame.x, above)?;
        }
    }
    Ok(())
}
