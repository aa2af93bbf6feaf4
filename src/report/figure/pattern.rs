//! Figure: the flat pattern of the skirt, to scale, with its dimensions.

use std::f64::consts::TAU;

use plotters::prelude::*;

use super::sheet::{self, Area, BLUE, Drawn, GREY, INK, LABEL, SMALL, line, steps};
use crate::error::Error;
use crate::experiment::Point;
use crate::model::skirt::Cone;
use crate::report::number::{fixed, plain};
use crate::units::{CENTIMETRE, DEGREE, MILLIMETRE};

/// Width on paper, and height less the drawing's own, mm.
pub const WIDTH: f64 = 120.0;
const AROUND: f64 = 39.0;
/// Room for the drawing.
const ROOM: (f64, f64) = (104.0, 96.0);
/// Scales that a ruler has.
const SCALES: [f64; 9] = [1.0, 2.0, 2.5, 5.0, 10.0, 20.0, 25.0, 50.0, 100.0];
/// Points on each arc.
const POINTS: usize = 181;

/// The pattern of one cut; `name` says whose it is (“Run 7”).
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(name: &str, cone: &Cone) -> Result<String, Error> {
    let outline = cone.pattern(POINTS);
    let ends = |pick: fn(&Point) -> f64| outline.iter().map(pick).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    let (x, y) = (ends(|p| p.x), ends(|p| p.y));
    let fits = |scale: &f64| x.1 - x.0 <= scale * ROOM.0 * MILLIMETRE && y.1 - y.0 <= scale * ROOM.1 * MILLIMETRE;
    let scale = SCALES.into_iter().find(fits).unwrap_or(200.0);
    // Millimetres of paper for a metre of cloth.
    let by = 1.0 / (scale * MILLIMETRE);
    let height = AROUND + by * (y.1 - y.0);
    sheet::draw(&format!("flat pattern of {name}"), WIDTH, height, |area| {
        sheet::title(area, &format!("{name}: the flat pattern, 1 : {}", plain(scale)), 0.5, 2.5)?;
        sheet::text_left(area, "without seam allowance; the two straight edges are sewn together", 0.5, 6.8, SMALL, INK)?;
        let place = |p: &Point| (0.5 * WIDTH + by * (p.x - 0.5 * (x.0 + x.1)), 14.0 + by * (y.1 - p.y));
        paint(area, cone, &outline, &place)?;
        legend(area, cone, height, by)
    })
}

fn paint(area: &Area<'_>, cone: &Cone, outline: &[Point], place: &dyn Fn(&Point) -> (f64, f64)) -> Drawn {
    let path = |points: &[Point], style: ShapeStyle| -> Drawn {
        let on_paper: Vec<(i32, i32)> = points.iter().map(place).map(|(x, y)| (steps(x), steps(y))).collect();
        Ok(area.draw(&PathElement::new(on_paper, style))?)
    };
    let mut closed = outline.to_vec();
    closed.extend(outline.first().copied());
    path(&closed, line(INK, 0.5))?;
    let (waist, hem) = outline.split_at(POINTS);
    // The grain: the line of symmetry, from waist to hem.
    let middle = [waist[POINTS / 2], hem[POINTS / 2]];
    let along =
        |share: f64| Point::new(middle[0].x + share * (middle[1].x - middle[0].x), middle[0].y + share * (middle[1].y - middle[0].y));
    for i in 0..20 {
        let from = f64::from(i) / 20.0;
        path(&[along(from), along(from + 0.03)], line(GREY, 0.2))?;
    }
    let (_, y) = place(&middle[0]);
    sheet::text_centre(area, "waist", 0.5 * WIDTH, y - 2.4, LABEL, INK)?;
    let (_, y) = place(&middle[1]);
    sheet::text_centre(area, "hem", 0.5 * WIDTH, y + 2.4, LABEL, INK)?;
    // The slant along one straight edge.
    let (from, to) = (place(&waist[POINTS - 1]), place(&hem[0]));
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let size = dx.hypot(dy);
    // Along the middle of the edge, on the side away from the cloth.
    let (across, down) = (dy / size, -dx / size);
    let aside = if 0.0 < across { 1.0 } else { -1.0 };
    let (x, y) = (0.5 * (from.0 + to.0) + aside * 2.6 * across, 0.5 * (from.1 + to.1) + aside * 2.6 * down);
    sheet::text_left(area, "L", x - 0.8, y, LABEL, BLUE)?;
    if cone.pattern_radius.is_some() {
        let inner: Vec<Point> = [waist[0], waist[POINTS - 1]].to_vec();
        let apex = Point::new(0.0, 0.0);
        // The apex only where it is on the paper: otherwise the angle is said in the list.
        let (_, y) = place(&apex);
        if 9.5 < y {
            for end in &inner {
                path(&[apex, *end], line(GREY, 0.2))?;
            }
        }
    }
    Ok(())
}

fn legend(area: &Area<'_>, cone: &Cone, height: f64, by: f64) -> Drawn {
    let cm = |metres: f64| format!("{} cm", fixed(metres / CENTIMETRE, 1));
    let mut said = vec![
        format!("waist 2πRₜ = {}", cm(TAU * cone.waist_radius)),
        format!("hem 2πRₙ = {}", cm(TAU * cone.hem_radius)),
        format!("L = {}", cm(cone.slant_length)),
    ];
    match cone.pattern_radius {
        Some(inner) => {
            said.push(format!("inner radius Rᵥ = {}", cm(inner)));
            said.push(format!("outer radius Rᵥ + L = {}", cm(inner + cone.slant_length)));
            said.push(format!("angle α = {}°", fixed(cone.pattern_angle / DEGREE, 1)));
        }
        None => said.push("a cylinder: the pattern is a rectangle".into()),
    }
    for (i, text) in said.iter().enumerate() {
        sheet::text_left(area, text, 3.0 + 41.0 * (i % 3) as f64, height - 15.0 + 4.0 * (i / 3) as f64, SMALL, INK)?;
    }
    let bar = 10.0 * CENTIMETRE * by;
    let y = height - 4.0;
    for (i, color) in [INK, GREY].into_iter().enumerate() {
        let from = 3.0 + 0.5 * bar * i as f64;
        area.draw(&PathElement::new(vec![(steps(from), steps(y)), (steps(from + 0.5 * bar), steps(y))], line(color, 0.8)))?;
    }
    sheet::text_left(area, "10 cm", 5.0 + bar, y, SMALL, INK)
}
