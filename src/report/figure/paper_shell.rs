//! Figure 5 of the paper: the one-layer shell by equation (18), p and q linear in height.

use std::f64::consts::TAU;

use super::sheet::{self, Area, Drawn, INK, SMALL};
use super::space::{Floor, Heights, View, between};
use crate::error::Error;
use crate::model::surface::{LinearSurface, Space};
use crate::report::number::fixed;
use crate::units::{CENTIMETRE, MILLIMETRE};

/// Size on paper, mm.
pub const WIDTH: f64 = 120.0;
pub const HEIGHT: f64 = 150.0;
/// Faces in each fold and down the height.
const FACES: (usize, usize) = (24, 24);

/// The surface from the round waist to the folded hem, meshed and shaded.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(heading: &str, surface: &LinearSurface) -> Result<String, Error> {
    sheet::draw("the paper's Figure 5", WIDTH, HEIGHT, |area| paint(area, heading, surface))
}

fn paint(area: &Area<'_>, heading: &str, surface: &LinearSurface) -> Drawn {
    sheet::title(area, heading, 0.5, 2.5)?;
    let hem = surface.hem;
    let mm = |metres: f64| fixed(metres / MILLIMETRE, 1);
    let text = format!(
        "ω = {}; p from {} mm at the waist to {} mm, q from 0 to {} mm, s from 0 to {} mm at the hem, linear in z",
        hem.folds,
        mm(surface.waist_radius),
        mm(hem.p),
        mm(hem.q),
        mm(hem.s)
    );
    sheet::text_left(area, &text, 0.5, 6.8, sheet::fitted(&text, WIDTH - 1.0, SMALL), INK)?;
    let (elevation, azimuth) = (0.38_f64, 0.45);
    let widest = hem.radius_range().1.max(surface.waist_radius);
    let half = (1.05 * widest / (5.0 * CENTIMETRE)).ceil() * 5.0 * CENTIMETRE;
    // As large as the sheet allows, upwards or sideways.
    let scale = (36.0 / half).min(92.0 / surface.height);
    let view = View { azimuth, elevation, scale, vertical: 1.0, origin: (0.5 * WIDTH + 1.0, HEIGHT - 33.0) };
    let heights = Heights { from: 0.0, to: surface.height + 2.0 * CENTIMETRE, tick: 10.0 * CENTIMETRE, unit: CENTIMETRE, name: "z, cm" };
    view.floor(area, &Floor { half, tick: 10.0 * CENTIMETRE }, &heights)?;
    let round = FACES.0 * hem.folds.max(1) as usize;
    let ring =
        |j: usize| -> Vec<Space> { (0..round).map(|i| surface.point(TAU * i as f64 / round as f64, j as f64 / FACES.1 as f64)).collect() };
    let rings: Vec<Vec<Space>> = (0..=FACES.1).map(ring).collect();
    view.faces(area, &between(&rings))
}
