//! Figure 3 of the paper: the space form of a surface element, the last of the cloth above the hem.

use super::sheet::{self, Area, Drawn, GREY, INK, SMALL, line};
use super::space::{Floor, Heights, View, between};
use crate::error::Error;
use crate::model::surface::{RuledForm, Space};
use crate::report::number::{fixed, plain};
use crate::units::{CENTIMETRE, MILLIMETRE};

/// Size on paper, mm.
pub const WIDTH: f64 = 150.0;
pub const HEIGHT: f64 = 112.0;
/// Heights are a few millimetres where the hem is decimetres wide.
const STRETCH: f64 = 8.0;
/// Slant length of the element.
const ELEMENT: f64 = 8.0 * MILLIMETRE;

/// The last of the slant, heights stretched, over its plan view. `slant` in m.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(heading: &str, form: &RuledForm, slant: f64, folds: u32) -> Result<String, Error> {
    sheet::draw("the paper's Figure 3", WIDTH, HEIGHT, |area| paint(area, heading, form, slant, folds))
}

fn paint(area: &Area<'_>, heading: &str, form: &RuledForm, slant: f64, folds: u32) -> Drawn {
    sheet::title(area, heading, 0.5, 2.5)?;
    let hem = form.ring(1.0);
    let height = |ring: &[Space]| ring.iter().map(|p| p[2]).fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(z), h.max(z)));
    let (low, high) = height(&hem);
    let text = format!(
        "m = {folds}; the last {} mm of the slant, heights stretched {} times; heights along the hem differ by {} mm",
        plain(ELEMENT / MILLIMETRE),
        plain(STRETCH),
        fixed((high - low) / MILLIMETRE, 1)
    );
    sheet::text_left(area, &text, 0.5, 6.8, SMALL, INK)?;
    // Heights count from the lowest point; the floor lies a centimetre below it.
    let lift = |ring: Vec<Space>| -> Vec<Space> { ring.into_iter().map(|[x, y, z]| [x, y, z - low]).collect() };
    let widest = hem.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max);
    let half = (1.05 * widest / (5.0 * CENTIMETRE)).ceil() * 5.0 * CENTIMETRE;
    // So much paper for half the floor, whatever the skirt.
    let scale = 42.0 / half;
    let view = View { azimuth: 0.55, elevation: 0.5, scale, vertical: STRETCH, origin: (0.5 * WIDTH, 0.5 * HEIGHT - 3.0) };
    let floor = -CENTIMETRE;
    let heights = Heights { from: floor, to: 1.55 * CENTIMETRE, tick: 0.5 * CENTIMETRE, unit: MILLIMETRE, name: "z, mm" };
    view.floor(area, &Floor { half, tick: 10.0 * CENTIMETRE }, &heights)?;
    let shadow = hem.iter().chain(&hem[..1]).map(|p| [p[0], p[1], floor]);
    view.path(area, shadow, line(GREY, 0.3))?;
    let rings: Vec<Vec<Space>> = (0..=4).map(|i| lift(form.ring(1.0 - ELEMENT / slant * (1.0 - f64::from(i) / 4.0)))).collect();
    view.faces(area, &between(&rings))?;
    Ok(())
}
