//! Figure: the skirt in space, coloured by quantities along its surface.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::sheet::{self, Area, Drawn, FULL_WIDTH, GREY, INK, LABEL, SMALL, line, steps};
use super::space::{Floor, Heights, View, between};
use crate::error::Error;
use crate::model::surface::Space;
use crate::report::number;
use crate::units::CENTIMETRE;

/// Height on paper, mm; the width is shared by two panels.
pub const HEIGHT: f64 = 110.0;
/// The colour bar: its distance from the lower edge, height and share of the panel's width.
const BAR: (f64, f64, f64) = (13.0, 3.0, 0.62);
const BAR_STEPS: usize = 48;

/// A quantity along the surface.
#[derive(Debug, Clone)]
pub struct Field {
    /// “Flexure r − R”.
    pub name: String,
    pub unit: String,
    /// `values[ring][point]`, as the points of the scene.
    pub values: Vec<Vec<f64>>,
}

/// The surface of one skirt, m, its lowest point near z = 0, and what it is coloured by, in at most two panels.
#[derive(Debug, Clone)]
pub struct Scene {
    pub run: String,
    /// The line below the title.
    pub caption: String,
    /// From the waist down; equally many points in each ring, counter-clockwise seen from above.
    pub rings: Vec<Vec<Space>>,
    pub fields: Vec<Field>,
}

/// One panel for each field, with its colour bar.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(scene: &Scene) -> Result<String, Error> {
    let width = 0.5 * FULL_WIDTH * scene.fields.len().clamp(1, 2) as f64;
    sheet::draw(&format!("surface of run {}", scene.run), width, HEIGHT, |area| {
        sheet::title(area, &format!("Run {}: the skirt in space", scene.run), 0.5, 2.5)?;
        sheet::text_left(area, &scene.caption, 0.5, 6.8, sheet::fitted(&scene.caption, width - 1.0, SMALL), INK)?;
        scene.fields.iter().enumerate().try_for_each(|(i, field)| paint(area, scene, field, 0.5 * FULL_WIDTH * i as f64))
    })
}

fn paint(area: &Area<'_>, scene: &Scene, field: &Field, left: f64) -> Drawn {
    let width = 0.5 * FULL_WIDTH;
    let points = || scene.rings.iter().flatten();
    let widest = points().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max);
    let (low, high) = points().map(|p| p[2]).fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(z), h.max(z)));
    let half = (1.05 * widest / (5.0 * CENTIMETRE)).ceil() * 5.0 * CENTIMETRE;
    let elevation: f64 = 0.38;
    let tick = if 0.3 < high - low { 10.0 } else { 5.0 } * CENTIMETRE;
    let heights = Heights { from: low, to: high + 0.4 * tick, tick, unit: CENTIMETRE, name: "z, cm" };
    let (azimuth, from_below) = (0.45_f64, 39.0);
    // As large as the panel allows: sideways, or upwards, where the axis of heights at the left corner ends below the titles.
    let corner = half * (azimuth.cos() - azimuth.sin()) * elevation.sin();
    let scale = (24.0 / half).min((HEIGHT - from_below - 13.5) / ((heights.to - low) * elevation.cos() + corner));
    let origin = (left + 0.5 * width + 3.0, HEIGHT - from_below + low * scale * elevation.cos());
    let view = View { azimuth, elevation, scale, vertical: 1.0, origin };
    view.floor(area, &Floor { half, tick: if 0.16 < half { 10.0 } else { 5.0 } * CENTIMETRE }, &heights)?;
    let (least, most) = field.values.iter().flatten().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    let share = |value: f64| if least < most { (value - least) / (most - least) } else { 0.5 };
    let round = scene.rings.first().map_or(0, Vec::len);
    let colors: Vec<RGBColor> = field
        .values
        .windows(2)
        .flat_map(|pair| {
            (0..round).map(|i| {
                let next = (i + 1) % round;
                share(0.25 * (pair[0][i] + pair[0][next] + pair[1][i] + pair[1][next]))
            })
        })
        .map(shade)
        .collect();
    view.coloured(area, &between(&scene.rings), &colors)?;
    bar(area, field, (least, most), left)
}

/// The colours from least to greatest with round values below.
fn bar(area: &Area<'_>, field: &Field, (least, most): (f64, f64), left: f64) -> Drawn {
    let (up, thick, share) = BAR;
    let width = 0.5 * FULL_WIDTH * share;
    let (from, top) = (left + 0.5 * (0.5 * FULL_WIDTH - width), HEIGHT - up);
    let at = |i: usize| steps(from + width * i as f64 / BAR_STEPS as f64);
    for i in 0..BAR_STEPS {
        let color = shade((i as f64 + 0.5) / BAR_STEPS as f64);
        // Under the next one too: no paper shines through a seam.
        area.draw(&Rectangle::new([(at(i), steps(top)), (at((i + 2).min(BAR_STEPS)), steps(top + thick))], sheet::fill(color)))?;
    }
    area.draw(&Rectangle::new([(at(0), steps(top)), (at(BAR_STEPS), steps(top + thick))], line(GREY, 0.15)))?;
    let unit = if field.unit.is_empty() { field.name.clone() } else { format!("{}, {}", field.name, field.unit) };
    sheet::text_centre(area, &unit, from + 0.5 * width, top + thick + 6.6, LABEL, INK)?;
    if most <= least {
        return sheet::text_centre(area, &number::significant(least, 3), from + 0.5 * width, top + thick + 2.6, SMALL, INK);
    }
    for value in round_values(least, most) {
        let x = from + width * (value - least) / (most - least);
        area.draw(&PathElement::new(vec![(steps(x), steps(top + thick)), (steps(x), steps(top + thick + 0.8))], line(GREY, 0.15)))?;
        area.draw_text(&number::plain(value), &sheet::mark(SMALL, INK, HPos::Center), (steps(x), steps(top + thick + 2.6)))?;
    }
    Ok(())
}

/// Round values within a range: a step of 1, 2 or 5 times a power of ten that gives three to seven of them.
fn round_values(least: f64, most: f64) -> Vec<f64> {
    let raw = (most - least) / 5.0;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|s| s * power).find(|s| raw <= *s).unwrap_or(10.0 * power);
    let first = (least / step).ceil();
    (0..).map(|i| (first + f64::from(i)) * step).take_while(|v| *v <= most).map(|v| if v.abs() < 1e-9 * step { 0.0 } else { v }).collect()
}

/// Dark blue to light yellow: told apart by colour-blind readers, and lighter the larger in grey. Source: the map “cividis”, Nuñez, Anderton & Renslow,
/// PLoS ONE 13 (2018) e0199239, at nine places.
pub fn shade(share: f64) -> RGBColor {
    const STOPS: [[f64; 3]; 9] = [
        [0.0, 34.0, 78.0],
        [33.0, 59.0, 110.0],
        [76.0, 85.0, 108.0],
        [108.0, 110.0, 114.0],
        [124.0, 123.0, 120.0],
        [152.0, 146.0, 114.0],
        [187.0, 173.0, 99.0],
        [224.0, 202.0, 80.0],
        [254.0, 232.0, 56.0],
    ];
    let place = 8.0 * share.clamp(0.0, 1.0);
    let i = (place.floor() as usize).min(7);
    let within = place - i as f64;
    let mix = |k: usize| (STOPS[i][k] + within * (STOPS[i + 1][k] - STOPS[i][k])).round() as u8;
    RGBColor(mix(0), mix(1), mix(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_values_are_lighter_in_grey() {
        // Rec. 709 weights.
        let light = |c: RGBColor| 0.2126 * f64::from(c.0) + 0.7152 * f64::from(c.1) + 0.0722 * f64::from(c.2);
        let lightness: Vec<f64> = (0..=40).map(|i| light(shade(f64::from(i) / 40.0))).collect();
        assert!(lightness.windows(2).all(|pair| pair[0] < pair[1]), "{lightness:?}");
    }

    #[test]
    fn round_values_lie_in_the_range() {
        assert_eq!(round_values(-12.0, 31.0), [-10.0, 0.0, 10.0, 20.0, 30.0]);
        let small = round_values(0.0011, 0.0042);
        assert!((3..=7).contains(&small.len()) && small.iter().all(|v| (0.0011..=0.0042).contains(v)), "{small:?}");
    }
}
