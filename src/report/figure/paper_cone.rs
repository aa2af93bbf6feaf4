//! Figure 1 of the paper: the truncated cone, its dimensions, and an element between two horizontal planes.

use std::f64::consts::{PI, TAU};

use plotters::prelude::*;

use super::sheet::{self, Area, BLUE, Drawn, GREY, INK, LABEL, SMALL, line};
use super::space::{View, between};
use crate::error::Error;
use crate::model::skirt::Cone;
use crate::model::surface::Space;
use crate::report::number::fixed;
use crate::units::CENTIMETRE;

/// Size on paper, mm.
pub const WIDTH: f64 = 110.0;
pub const HEIGHT: f64 = 94.0;
/// The element, as shares of the height above the base.
const ELEMENT: (f64, f64) = (0.30, 0.38);
/// Points on a ring.
const RING: usize = 180;

/// The cone in parallel projection with R_t, R_n, L, H, β and the element of height Δh.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(heading: &str, cone: &Cone) -> Result<String, Error> {
    sheet::draw("the paper's Figure 1", WIDTH, HEIGHT, |area| paint(area, heading, cone))
}

fn paint(area: &Area<'_>, heading: &str, cone: &Cone) -> Drawn {
    sheet::title(area, heading, 0.5, 2.5)?;
    let (waist, hem, height) = (cone.waist_radius, cone.hem_radius, cone.height);
    let elevation: f64 = 0.28;
    // As large as the sheet allows either way, the base two ring heights above its lower edge.
    let scale = (0.5 * (WIDTH - 46.0) / hem).min((HEIGHT - 14.0) / (height * elevation.cos() + (waist + hem) * elevation.sin()));
    let origin = (0.5 * WIDTH - 6.0, HEIGHT - 3.0 - hem * scale * elevation.sin());
    let view = View { azimuth: 0.0, elevation, scale, vertical: 1.0, origin };
    let at = |radius: f64, angle: f64, z: f64| -> Space { [radius * angle.cos(), radius * angle.sin(), z] };
    let radius_at = |z: f64| hem + (waist - hem) * z / height;
    let arc = |radius: f64, z: f64, from: f64, to: f64| -> Vec<Space> {
        (0..=RING).map(|i| at(radius, from + (to - from) * i as f64 / RING as f64, z)).collect()
    };
    // The visible part of the wall lies between the generatrices that are seen edge-on.
    let edge = ((hem - waist) * elevation.tan() / height).clamp(-1.0, 1.0).asin();
    let (from, to) = (PI - edge, TAU + edge);
    let (low, high) = (ELEMENT.0 * height, ELEMENT.1 * height);
    let band = [arc(radius_at(high), high, from, to), arc(radius_at(low), low, from, to)];
    let mut faces = between(&band);
    // An open band: its last face would lead back to the first point.
    faces.pop();
    let hidden = line(GREY, 0.18);
    for (radius, z) in [(radius_at(high), high), (radius_at(low), low), (hem, 0.0)] {
        view.broken(area, &arc(radius, z, edge, PI - edge), hidden, 3)?;
    }
    // The axis is inside: the element hides a part of it.
    let dimension = line(BLUE, 0.3);
    let axis: Vec<Space> = (0..=60).map(|i| [0.0, 0.0, height * f64::from(i) / 60.0]).collect();
    view.broken(area, &axis, dimension, 1)?;
    view.faces(area, &faces)?;
    let firm = line(INK, 0.35);
    for (radius, z) in [(radius_at(high), high), (radius_at(low), low), (hem, 0.0)] {
        view.path(area, arc(radius, z, from, to), if z == 0.0 { firm } else { line(INK, 0.25) })?;
    }
    view.path(area, arc(waist, height, 0.0, TAU), firm)?;
    for angle in [from, to] {
        view.path(area, [at(hem, angle, 0.0), at(waist, angle, height)], firm)?;
    }
    // The meridian half plane on the right carries the dimensions.
    let base: Vec<Space> = (0..=30).map(|i| [hem * f64::from(i) / 30.0, 0.0, 0.0]).collect();
    view.broken(area, &base, dimension, 1)?;
    view.path(area, [[0.0, 0.0, height], [waist, 0.0, height]], dimension)?;
    view.path(area, [[hem, 0.0, 0.0], [waist, 0.0, height]], dimension)?;
    let reach = 0.22 * hem;
    let angle: Vec<Space> =
        (0..=20).map(|i| cone.base_angle * f64::from(i) / 20.0).map(|a| [hem - reach * a.cos(), 0.0, reach * a.sin()]).collect();
    view.path(area, angle, dimension)?;
    for z in [0.0, height] {
        area.draw(&Circle::new(view.step([0.0, 0.0, z]), sheet::steps(0.5), sheet::fill(INK)))?;
    }
    let cm = |metres: f64| format!("{} cm", fixed(metres / CENTIMETRE, 2));
    let (x, y) = view.place([0.5 * waist, 0.0, height]);
    sheet::text_centre(area, "Rₜ", x, y - 2.0, LABEL, INK)?;
    let (x, y) = view.place([0.5 * hem, 0.0, 0.0]);
    sheet::text_centre(area, "Rₙ", x, y - 2.0, LABEL, INK)?;
    let (x, y) = view.place([0.0, 0.0, 0.64 * height]);
    sheet::text_right(area, "H", x - 1.2, y, LABEL, INK)?;
    let (x, y) = view.place([radius_at(0.62 * height), 0.0, 0.62 * height]);
    sheet::text_left(area, "L", x + 2.0, y, LABEL, INK)?;
    let half = 0.5 * cone.base_angle;
    let (x, y) = view.place([hem - 0.68 * reach * half.cos(), 0.0, 0.68 * reach * half.sin()]);
    sheet::text_centre(area, "β", x, y, LABEL, INK)?;
    // The element's planes, named on the left.
    let left = 0.8;
    for (z, name) in [(low, "z = h"), (high, "z = h + Δh")] {
        let (x, y) = view.place(at(radius_at(z), PI, z));
        area.draw(&PathElement::new(
            vec![(sheet::steps(left), sheet::steps(y)), (sheet::steps(x - 0.6), sheet::steps(y))],
            line(GREY, 0.18),
        ))?;
        let lift = if z == low { 1.9 } else { -1.9 };
        sheet::text_left(area, name, 0.8, y + lift, SMALL, INK)?;
    }
    let values = [
        format!("Rₜ = {}", cm(waist)),
        format!("Rₙ = {}", cm(hem)),
        format!("L = {}", cm(cone.slant_length)),
        format!("H = {}", cm(height)),
        format!("β = {} rad", fixed(cone.base_angle, 3)),
    ];
    for (i, value) in values.iter().enumerate() {
        sheet::text_left(area, value, WIDTH - 25.0, 12.0 + 4.0 * i as f64, LABEL, INK)?;
    }
    Ok(())
}
