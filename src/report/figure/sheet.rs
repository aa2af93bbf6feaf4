//! The sheet that every figure is drawn on: its size on paper, its type, its lines and colours.
//!
//! A sheet is measured in millimetres and drawn on a grid of [`GRID`] steps each, so that curves are smooth although the backend counts in integers.

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::drawing::{Drawing, FONT_FACTOR};
use crate::error::Error;
use crate::report::number;

/// Grid steps per millimetre.
pub const GRID: f64 = 40.0;
/// One typographic point, mm.
const POINT: f64 = 25.4 / 72.0;
/// Width of a full-width figure: the text width of an A4 page, mm.
pub const FULL_WIDTH: f64 = 170.0;

/// Kept free at the edges of a chart, mm.
const EDGE: f64 = 0.8;

/// The family that both the PDF and the PNG embed.
const FAMILY: &str = "DejaVu Sans";

/// Sizes of type, points.
pub const TITLE: f64 = 8.5;
pub const LABEL: f64 = 7.5;
pub const SMALL: f64 = 6.5;

/// Okabe & Ito's palette: told apart by colour-blind readers, and ordered in lightness. Source: Okabe & Ito, Color Universal Design, 2008.
pub const INK: RGBColor = RGBColor(0, 0, 0);
pub const BLUE: RGBColor = RGBColor(0, 114, 178);
pub const VERMILLION: RGBColor = RGBColor(213, 94, 0);
pub const GREEN: RGBColor = RGBColor(0, 158, 115);
pub const ORANGE: RGBColor = RGBColor(230, 159, 0);
pub const SKY: RGBColor = RGBColor(86, 180, 233);
/// For what must be seen last: grids, reference lines, secondary text.
pub const GREY: RGBColor = RGBColor(110, 110, 110);
pub const PALE: RGBColor = RGBColor(222, 222, 222);

pub type Area<'a> = DrawingArea<Drawing<'a>, Shift>;
pub type Chart<'a, 'b> = ChartContext<'a, Drawing<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
/// What a figure's drawing may fail with.
pub type Drawn = Result<(), Box<dyn std::error::Error>>;

/// Draws on a white sheet of `width` × `height` mm and returns the SVG; `what` names the figure in an error.
///
/// # Errors
/// [`Error::Output`] if the backend refuses.
pub fn draw(what: &str, width: f64, height: f64, paint: impl FnOnce(&Area<'_>) -> Drawn) -> Result<String, Error> {
    let mut svg = String::new();
    let size = (steps(width) as u32, steps(height) as u32);
    let painted = {
        let area = Drawing::new(&mut svg, size, (width, height)).into_drawing_area();
        let filled = area.fill(&WHITE).map_err(Into::into);
        filled.and_then(|()| paint(&area)).and_then(|()| area.present().map_err(Into::into))
    };
    painted.map_err(|error: Box<dyn std::error::Error>| Error::Output { what: what.to_string(), why: error.to_string() })?;
    Ok(svg)
}

/// A length on the sheet in grid steps.
pub fn steps(millimetres: f64) -> i32 {
    (millimetres * GRID).round() as i32
}

/// A part of a sheet: left, top, width, height in mm.
pub fn part<'a>(area: &Area<'a>, left: f64, top: f64, width: f64, height: f64) -> Area<'a> {
    area.clone().shrink((steps(left), steps(top)), (steps(width), steps(height)))
}

/// A solid line `width` mm wide.
pub fn line(color: RGBColor, width: f64) -> ShapeStyle {
    ShapeStyle { color: color.to_rgba(), filled: false, stroke_width: (width * GRID).round().max(1.0) as u32 }
}

/// A broad line in a lighter shade, for a thin dark one to lie on: the two stay apart in grey too.
pub fn underlay(color: RGBColor, width: f64) -> ShapeStyle {
    ShapeStyle { color: color.mix(0.5), ..line(color, width) }
}

/// A filled shape.
pub fn fill(color: RGBColor) -> ShapeStyle {
    ShapeStyle { color: color.to_rgba(), filled: true, stroke_width: 0 }
}

/// Type of `size` points.
pub fn font(size: f64) -> FontDesc<'static> {
    FontDesc::new(FontFamily::Name(FAMILY), size * POINT * GRID * FONT_FACTOR, FontStyle::Normal)
}

fn anchored(size: f64, color: RGBColor, bold: bool, horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    let style = if bold { FontStyle::Bold } else { FontStyle::Normal };
    TextStyle { font: font(size).style(style), color: color.to_backend_color(), pos: Pos::new(horizontal, vertical) }
}

/// The size, points, at which `text` is at most `width` mm wide: `size`, or smaller.
pub fn fitted(text: &str, width: f64, size: f64) -> f64 {
    // DejaVu Sans sets mixed text 0.58 em wide a letter.
    let natural = 0.58 * POINT * size * text.chars().count() as f64;
    if natural <= width { size } else { size * width / natural }
}

/// Names below marks at `x` mm, from left to right, on one line at `y`: all where they fit side by side, evenly thinned where they do not.
pub fn names_along(area: &Area<'_>, names: &[(f64, &str)], y: f64) -> Drawn {
    let size = if names.len() < 30 { SMALL } else { 5.8 };
    let letters = names.iter().map(|(_, name)| name.chars().count()).max().unwrap_or(0) as f64;
    // Figures are 0.64 em wide; half a letter of room between neighbours.
    let width = 0.64 * POINT * size * (letters + 0.5);
    let pitch = names.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(f64::INFINITY, f64::min);
    let every = (width / pitch).ceil().max(1.0) as usize;
    names.iter().step_by(every).try_for_each(|(x, name)| text_centre(area, name, *x, y, size, INK))
}

/// Where the `i`th of `n` runs stands on an axis from `from` to `to` that begins one place before the first and ends one after the last.
pub fn along((from, to): (f64, f64), i: usize, n: usize) -> f64 {
    from + (to - from) * (i as f64 + 1.0) / (n as f64 + 1.0)
}

/// Text whose left edge is at `x`, its middle line at `y` (mm on the area).
pub fn text_left(area: &Area<'_>, text: &str, x: f64, y: f64, size: f64, color: RGBColor) -> Drawn {
    put(area, text, x, y, &anchored(size, color, false, HPos::Left, VPos::Center))
}

/// Text whose right edge is at `x`.
pub fn text_right(area: &Area<'_>, text: &str, x: f64, y: f64, size: f64, color: RGBColor) -> Drawn {
    put(area, text, x, y, &anchored(size, color, false, HPos::Right, VPos::Center))
}

/// Text centred on (x, y).
pub fn text_centre(area: &Area<'_>, text: &str, x: f64, y: f64, size: f64, color: RGBColor) -> Drawn {
    put(area, text, x, y, &anchored(size, color, false, HPos::Center, VPos::Center))
}

/// The title of a figure or panel: bold, its left edge at `x`, smaller where it would not fit on the sheet.
pub fn title(area: &Area<'_>, text: &str, x: f64, y: f64) -> Drawn {
    // Bold letters are a seventh wider.
    let room = (f64::from(area.dim_in_pixel().0) / GRID - x) / 1.14;
    put(area, text, x, y, &anchored(fitted(text, room, TITLE), INK, true, HPos::Left, VPos::Center))
}

fn put(area: &Area<'_>, text: &str, x: f64, y: f64, style: &TextStyle<'_>) -> Drawn {
    Ok(area.draw_text(text, style, (steps(x), steps(y)))?)
}

/// The style of text inside a chart, anchored at its middle left, middle or middle right.
pub fn mark(size: f64, color: RGBColor, horizontal: HPos) -> TextStyle<'static> {
    anchored(size, color, false, horizontal, VPos::Center)
}

/// How a chart is framed.
pub struct Frame<'t> {
    pub x: (f64, f64),
    pub y: (f64, f64),
    pub x_label: &'t str,
    pub y_label: &'t str,
    /// About how many ticks.
    pub x_ticks: usize,
    pub y_ticks: usize,
    /// Room for ticks and labels left of and below the chart, mm; none on the left leaves the y axis out, for a panel that shares its neighbour's.
    pub left: f64,
    pub below: f64,
    /// Tick labels of the x axis where numbers would say nothing.
    pub x_names: Option<&'t dyn Fn(f64) -> String>,
    /// The same of the y axis.
    pub y_names: Option<&'t dyn Fn(f64) -> String>,
    /// Whether the figure draws a grid and ticks of its own.
    pub bare: bool,
}

impl Frame<'_> {
    /// A plan view in cm: `half` to each side of the centre.
    pub fn plan((cx, cy): (f64, f64), half: f64) -> Self {
        Frame {
            x: (cx - half, cx + half),
            y: (cy - half, cy + half),
            x_label: "x, cm",
            y_label: "y, cm",
            x_ticks: 7,
            y_ticks: 7,
            ..Frame::default()
        }
    }
}

impl Default for Frame<'_> {
    fn default() -> Self {
        Frame {
            x: (0.0, 1.0),
            y: (0.0, 1.0),
            x_label: "",
            y_label: "",
            x_ticks: 6,
            y_ticks: 5,
            left: 14.0,
            below: 10.0,
            x_names: None,
            y_names: None,
            bare: false,
        }
    }
}

/// A chart with a light grid, ticks and labels, filling `area`.
pub fn chart<'a, 'b>(area: &'a Area<'b>, frame: &Frame<'_>) -> Result<Chart<'a, 'b>, Box<dyn std::error::Error>> {
    let (x, y) = (spread(frame.x), spread(frame.y));
    let mut builder = ChartBuilder::on(area);
    if 0.0 < frame.left {
        // The axis title hugs the edge of its area; half a millimetre more keeps its ascenders on the sheet.
        builder.margin_left(steps(EDGE)).set_label_area_size(LabelAreaPosition::Left, steps(frame.left - EDGE));
    }
    builder.margin_bottom(steps(EDGE)).set_label_area_size(LabelAreaPosition::Bottom, steps(frame.below - EDGE));
    let mut chart = builder.build_cartesian_2d(x.0..x.1, y.0..y.1)?;
    let x_decimals = decimals(x, frame.x_ticks);
    let y_decimals = decimals(y, frame.y_ticks);
    let x_text = |v: &f64| frame.x_names.map_or_else(|| number::fixed(*v, x_decimals), |names| names(*v));
    let y_text = |v: &f64| frame.y_names.map_or_else(|| number::fixed(*v, y_decimals), |names| names(*v));
    let mut mesh = chart.configure_mesh();
    mesh.x_labels(frame.x_ticks)
        .y_labels(frame.y_ticks)
        .max_light_lines(0)
        .bold_line_style(line(PALE, 0.1))
        .axis_style(line(GREY, 0.15))
        .set_all_tick_mark_size(steps(1.0))
        .label_style(font(SMALL).color(&INK))
        .axis_desc_style(font(LABEL).color(&INK))
        .x_label_formatter(&x_text)
        .y_label_formatter(&y_text);
    if frame.bare {
        mesh.disable_mesh().set_all_tick_mark_size(0).x_label_formatter(&|_| String::new()).y_label_formatter(&|_| String::new());
    }
    // An empty title would be a text without letters.
    if !frame.x_label.is_empty() {
        mesh.x_desc(frame.x_label);
    }
    if !frame.y_label.is_empty() {
        mesh.y_desc(frame.y_label);
    }
    mesh.draw()?;
    drop(mesh);
    Ok(chart)
}

/// A range with room about it: `share` of its width at either end; a range of no width is opened.
pub fn padded(values: impl IntoIterator<Item = f64>, share: f64) -> (f64, f64) {
    let (low, high) = values.into_iter().filter(|v| v.is_finite()).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if high < low {
        return (0.0, 1.0);
    }
    let (low, high) = spread((low, high));
    let margin = share * (high - low);
    (low - margin, high + margin)
}

fn spread((low, high): (f64, f64)) -> (f64, f64) {
    if high - low > 1e-12 * high.abs().max(low.abs()) && 0.0 < high - low {
        return (low, high);
    }
    let half = if low == 0.0 { 0.5 } else { 0.05 * low.abs() };
    (low - half, high + half)
}

/// Places after the point that tell neighbouring ticks apart.
fn decimals((low, high): (f64, f64), ticks: usize) -> usize {
    let step = (high - low) / ticks.max(1) as f64;
    (-step.log10().floor()).clamp(0.0, 9.0) as usize
}

/// A dashed path through `points` of a chart; lengths of dash and gap in mm.
pub fn dashed(chart: &mut Chart<'_, '_>, points: &[(f64, f64)], style: ShapeStyle, dash: f64, gap: f64) -> Drawn {
    chart.draw_series(DashedLineSeries::new(points.to_vec(), steps(dash), steps(gap), style))?;
    Ok(())
}

/// A solid path through `points` of a chart.
pub fn solid(chart: &mut Chart<'_, '_>, points: &[(f64, f64)], style: ShapeStyle) -> Drawn {
    chart.draw_series(std::iter::once(PathElement::new(points.to_vec(), style)))?;
    Ok(())
}

/// Filled dots of `radius` mm.
pub fn dots(chart: &mut Chart<'_, '_>, points: &[(f64, f64)], radius: f64, color: RGBColor) -> Drawn {
    chart.draw_series(points.iter().map(|&p| Circle::new(p, steps(radius), fill(color))))?;
    Ok(())
}

/// Text inside a chart, anchored at a data point and moved right by `aside` mm (left if negative).
pub fn note(chart: &mut Chart<'_, '_>, text: &str, at: (f64, f64), aside: f64, style: TextStyle<'static>) -> Drawn {
    let label = EmptyElement::at(at) + Text::new(text.to_string(), (steps(aside), 0), style);
    chart.draw_series(std::iter::once(label))?;
    Ok(())
}

/// A name of at most `most` letters: a longer one is cut, and says so.
pub fn shortened(name: &str, most: usize) -> String {
    if name.chars().count() <= most { name.to_string() } else { name.chars().take(most - 1).chain(['…']).collect() }
}

/// A run's name above or below its mark, towards the middle of the x range; what is long of it is said elsewhere.
pub fn name_run(chart: &mut Chart<'_, '_>, run: &str, at: (f64, f64), range: (f64, f64), above: bool) -> Drawn {
    let right_half = 0.5 * (range.0 + range.1) < at.0;
    let (aside, anchor) = if right_half { (1.0, HPos::Right) } else { (-1.0, HPos::Left) };
    let up = if above { -2.4 } else { 2.4 };
    let name = Text::new(format!("run {}", shortened(run, 10)), (steps(aside), steps(up)), mark(SMALL, INK, anchor));
    chart.draw_series(std::iter::once(EmptyElement::at(at) + name))?;
    Ok(())
}
