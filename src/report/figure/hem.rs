//! Figure: one hem from above, measured points, fitted and predicted curve over each other, equal axes.

use plotters::prelude::*;

use super::sheet::{self, Area, BLUE, Chart, Drawn, Frame, GREY, INK, SMALL, VERMILLION, chart, dashed, line, solid, steps, underlay};
use crate::error::Error;
use crate::experiment::Point;
use crate::fit::HemFit;
use crate::model::hem::Placement;
use crate::simulate::Prediction;
use crate::study::campaign::RunStudy;
use crate::units::{CENTIMETRE, MILLIMETRE};

/// Size on paper, mm.
pub const WIDTH: f64 = 84.0;
pub const HEIGHT: f64 = 95.0;

/// Points on a drawn curve, and about as many kept of a predicted one: at 70 mm across, a chord is nowhere off by the width of its line.
const NODES: usize = 300;

/// More points than these round the hem are closer than a dot is wide.
const DENSE: usize = 300;

/// One hem as a figure sees it, m, in the frame of the measurement.
#[derive(Debug, Clone)]
pub struct View {
    pub run: String,
    pub measured: Vec<Point>,
    pub fitted: Vec<Point>,
    /// Foot points of the measured points on the fitted curve; empty where there is no fit.
    pub feet: Vec<Point>,
    pub predicted: Vec<Point>,
    /// Where the hem's own axis stands.
    pub centre: Point,
    /// Fold count, rms, λ: the line below the title.
    pub caption: String,
}

impl View {
    /// What is known of one run; `None` if its profile was set aside.
    pub fn of(study: &RunStudy) -> Option<View> {
        let profile = study.profile.as_ref()?;
        let measured = profile.points().to_vec();
        let fit = study.fit.as_ref().ok();
        let centre = fit.map_or_else(|| middle(&measured), |fit| Point::new(fit.placement.x0, fit.placement.y0));
        let placed = study.prediction_at_fitted_folds.as_ref().zip(study.comparison.as_ref());
        Some(View {
            run: study.run.id.clone(),
            fitted: fit.map(|fit| fit.outline(NODES)).unwrap_or_default(),
            feet: fit.map(|fit| fit.feet.iter().map(|&t| fit.hem.point(&fit.placement, t)).collect()).unwrap_or_default(),
            predicted: placed.map(|(prediction, comparison)| place(prediction, &comparison.placement)).unwrap_or_default(),
            centre,
            caption: caption(measured.len(), fit, study),
            measured,
        })
    }

    /// Whether the measured points stand so close that dots would run into each other: then they are drawn as a thin line.
    pub fn is_dense(&self) -> bool {
        DENSE < self.measured.len()
    }

    /// Half the side of the square about the centre that holds everything, m.
    pub fn reach(&self) -> f64 {
        let all = self.measured.iter().chain(&self.fitted).chain(&self.predicted);
        all.map(|p| (p.x - self.centre.x).abs().max((p.y - self.centre.y).abs())).fold(0.0, f64::max)
    }
}

/// The figure of one run.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(view: &View) -> Result<String, Error> {
    sheet::draw(&format!("figure of the hem of run {}", view.run), WIDTH, HEIGHT, |area| paint(area, view))
}

fn paint(area: &Area<'_>, view: &View) -> Drawn {
    sheet::title(area, &format!("Run {}", view.run), 0.5, 2.5)?;
    sheet::text_left(area, &view.caption, 0.5, 6.8, SMALL, INK)?;
    let (left, below, top) = (12.0, 9.5, 10.0);
    let side = WIDTH - left - 1.5;
    let plot = sheet::part(area, 0.0, top, left + side, side + below);
    let half = 1.06 * view.reach() / CENTIMETRE;
    let (cx, cy) = (view.centre.x / CENTIMETRE, view.centre.y / CENTIMETRE);
    let frame = Frame { left, below, ..Frame::plan((cx, cy), half) };
    let mut hem = chart(&plot, &frame)?;
    let magnified = whiskers(&mut hem, view)?;
    if view.is_dense() {
        curves(&mut hem, view, underlay(BLUE, 0.8), 0.6, 1)?;
        solid(&mut hem, &closed(&view.measured, 1), line(INK, 0.2))?;
    } else {
        curves(&mut hem, view, line(BLUE, 0.45), 0.45, 1)?;
        sheet::dots(&mut hem, &centimetres(&view.measured), 0.45, INK)?;
    }
    hem.draw_series(std::iter::once(Cross::new((cx, cy), steps(1.0), line(GREY, 0.2))))?;
    legend(area, view, top + side + below + 2.0, magnified)
}

/// The predicted line, `width` mm, and the fitted one, every `stride`th of their points.
pub fn curves(chart: &mut Chart<'_, '_>, view: &View, fitted_line: ShapeStyle, width: f64, stride: usize) -> Drawn {
    let predicted = closed(&view.predicted, stride * (view.predicted.len() / NODES).max(1));
    if !predicted.is_empty() {
        dashed(chart, &predicted, line(VERMILLION, 0.8 * width), 5.0 * width, 3.0 * width)?;
    }
    let fitted = closed(&view.fitted, stride);
    if !fitted.is_empty() {
        solid(chart, &fitted, fitted_line)?;
    }
    Ok(())
}

/// Distances from the fitted curve as whiskers, magnified by a round factor so that they can be seen; returns the factor.
fn whiskers(chart: &mut Chart<'_, '_>, view: &View) -> Result<Option<u32>, Box<dyn std::error::Error>> {
    let longest = view.measured.iter().zip(&view.feet).map(|(m, f)| m.distance(*f)).fold(0.0, f64::max);
    if longest == 0.0 {
        return Ok(None);
    }
    // A tenth of the hem's reach is as long as a whisker may grow before whiskers of neighbouring folds meet.
    let factor = [50, 20, 10, 5, 2].into_iter().find(|f| f64::from(*f) * longest < 0.1 * view.reach()).unwrap_or(1);
    let by = f64::from(factor);
    let every = view.measured.len().div_ceil(DENSE);
    let lines = view.measured.iter().zip(&view.feet).step_by(every).map(|(m, f)| {
        let end = Point::new(f.x + by * (m.x - f.x), f.y + by * (m.y - f.y));
        PathElement::new(centimetres(&[*f, end]), line(sheet::ORANGE, 0.28))
    });
    chart.draw_series(lines)?;
    Ok(Some(factor))
}

fn legend(area: &Area<'_>, view: &View, y: f64, magnified: Option<u32>) -> Drawn {
    let mut x = 1.0;
    if view.is_dense() {
        area.draw(&PathElement::new(vec![(steps(x), steps(y)), (steps(x + 3.0), steps(y))], line(INK, 0.2)))?;
    } else {
        area.draw(&Circle::new((steps(x + 1.5), steps(y)), steps(0.5), sheet::fill(INK)))?;
    }
    sheet::text_left(area, "measured", x + 3.5, y, SMALL, INK)?;
    x += 19.0;
    if !view.fitted.is_empty() {
        let style = if view.is_dense() { underlay(BLUE, 0.8) } else { line(BLUE, 0.45) };
        area.draw(&PathElement::new(vec![(steps(x), steps(y)), (steps(x + 4.5), steps(y))], style))?;
        sheet::text_left(area, "fitted", x + 5.5, y, SMALL, INK)?;
        x += 15.5;
    }
    if !view.predicted.is_empty() {
        for i in 0..2 {
            let from = x + 2.7 * f64::from(i);
            area.draw(&PathElement::new(vec![(steps(from), steps(y)), (steps(from + 1.8), steps(y))], line(VERMILLION, 0.4)))?;
        }
        sheet::text_left(area, "predicted", x + 5.5, y, SMALL, INK)?;
        x += 20.0;
    }
    if let Some(factor) = magnified {
        area.draw(&PathElement::new(vec![(steps(x), steps(y)), (steps(x + 3.0), steps(y))], line(sheet::ORANGE, 0.28)))?;
        let text = if factor == 1 { "distance".to_string() } else { format!("distance × {factor}") };
        sheet::text_left(area, &text, x + 4.0, y, SMALL, INK)?;
    }
    Ok(())
}

/// A predicted hem where it was laid over the measurement: turned by the phase, shifted to the centre.
pub fn place(prediction: &Prediction, placement: &Placement) -> Vec<Point> {
    let (sin, cos) = placement.phase.sin_cos();
    let moved = |p: &Point| Point::new(placement.x0 + p.x * cos - p.y * sin, placement.y0 + p.x * sin + p.y * cos);
    prediction.outline.iter().map(moved).collect()
}

fn caption(n: usize, fit: Option<&HemFit>, study: &RunStudy) -> String {
    use crate::report::number::{fixed, to_error};
    let Some(fit) = fit else { return format!("n = {n} · no fit") };
    let folds = fit.folds.map_or_else(|| "no folds".into(), |m| format!("m = {m}"));
    let lambda = match (&study.lambda.first_integral, &study.lambda.over_weight) {
        (Some((estimate, r2)), _) => format!(" · λ = {} N/m² (R² {})", to_error(estimate.value, estimate.standard_error), fixed(*r2, 2)),
        (None, Some((estimate, r2))) => format!(" · λ/(ρg) = {} (R² {})", to_error(estimate.value, estimate.standard_error), fixed(*r2, 2)),
        (None, None) => String::new(),
    };
    format!("n = {n} · {folds} · rms {} mm{lambda}", fixed(fit.rms / MILLIMETRE, 2))
}

/// Points in cm, as a chart takes them.
pub fn centimetres(points: &[Point]) -> Vec<(f64, f64)> {
    points.iter().map(|p| (p.x / CENTIMETRE, p.y / CENTIMETRE)).collect()
}

/// The same, every `stride`th, with the first point repeated at the end.
pub fn closed(points: &[Point], stride: usize) -> Vec<(f64, f64)> {
    let mut round: Vec<(f64, f64)> = centimetres(points).into_iter().step_by(stride).collect();
    round.extend(round.first().copied());
    round
}

/// The middle of the smallest upright rectangle round the points.
fn middle(points: &[Point]) -> Point {
    let (mut low, mut high) = (points[0], points[0]);
    for p in points {
        low = Point::new(low.x.min(p.x), low.y.min(p.y));
        high = Point::new(high.x.max(p.x), high.y.max(p.y));
    }
    Point::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y))
}
