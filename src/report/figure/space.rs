//! Space on paper: parallel projection from above, faces painted from far to near, a floor with axes in cm.

use plotters::prelude::*;

use super::sheet::{self, Area, Drawn, GREY, INK, LABEL, PALE, SMALL, line, steps};
use crate::model::surface::Space;
use crate::report::number;
use crate::units::CENTIMETRE;

/// By how much a face without rim reaches under its neighbours, mm.
const SEAM: f64 = 0.06;

/// From where a scene is looked at, and where on the sheet it lies.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// Turn of the scene about the vertical, rad.
    pub azimuth: f64,
    /// Of the eye above the horizon, rad.
    pub elevation: f64,
    /// Millimetres of paper for a metre.
    pub scale: f64,
    /// Stretch of heights.
    pub vertical: f64,
    /// Where the origin of space lies on the sheet, mm.
    pub origin: (f64, f64),
}

impl View {
    /// Right, away from the eye (both level) and up, mm of paper before the eye is raised.
    fn turned(&self, [x, y, z]: Space) -> [f64; 3] {
        let (sin, cos) = self.azimuth.sin_cos();
        [(x * cos - y * sin) * self.scale, (x * sin + y * cos) * self.scale, z * self.vertical * self.scale]
    }

    /// On the sheet, mm.
    pub fn place(&self, at: Space) -> (f64, f64) {
        let [right, away, up] = self.turned(at);
        (self.origin.0 + right, self.origin.1 - up * self.elevation.cos() - away * self.elevation.sin())
    }

    /// On the sheet, in grid steps.
    pub fn step(&self, at: Space) -> (i32, i32) {
        let (x, y) = self.place(at);
        (steps(x), steps(y))
    }

    /// How near to the eye, mm.
    fn nearness(&self, at: Space) -> f64 {
        let [_, away, up] = self.turned(at);
        up * self.elevation.sin() - away * self.elevation.cos()
    }

    /// A line through points of space.
    pub fn path(&self, area: &Area<'_>, points: impl IntoIterator<Item = Space>, style: ShapeStyle) -> Drawn {
        Ok(area.draw(&PathElement::new(points.into_iter().map(|p| self.step(p)).collect::<Vec<_>>(), style))?)
    }

    /// Every other piece of a line of many points; `run` points are drawn, then as many left out.
    pub fn broken(&self, area: &Area<'_>, points: &[Space], style: ShapeStyle, run: usize) -> Drawn {
        for piece in points.windows(run + 1).step_by(2 * run) {
            self.path(area, piece.iter().copied(), style)?;
        }
        Ok(())
    }

    /// Paints the four-cornered faces of a surface over what is there, the farthest first; the side that the corners run round counter-clockwise
    /// is its outer one, the other is painted darker. Each has a thin rim: the mesh.
    pub fn faces(&self, area: &Area<'_>, faces: &[[Space; 4]]) -> Drawn {
        for i in self.by_depth(faces) {
            let corners: Vec<(i32, i32)> = faces[i].iter().map(|&p| self.step(p)).collect();
            let light = self.lightness(&faces[i]);
            area.draw(&Polygon::new(corners.clone(), grey(light).filled()))?;
            let rim = corners.iter().chain(&corners[..1]).copied().collect::<Vec<_>>();
            area.draw(&PathElement::new(rim, line(grey(light - 0.16), 0.07)))?;
        }
        Ok(())
    }

    /// The same without rims, each face in its own colour, a little darker where it is turned from the light.
    pub fn coloured(&self, area: &Area<'_>, faces: &[[Space; 4]], colors: &[RGBColor]) -> Drawn {
        for i in self.by_depth(faces) {
            let corners: Vec<(f64, f64)> = faces[i].iter().map(|&p| self.place(p)).collect();
            let middle = corners.iter().fold((0.0, 0.0), |sum, c| (sum.0 + 0.25 * c.0, sum.1 + 0.25 * c.1));
            // Neighbours overlap by a hair: no paper shines through the seam.
            let wider = |&(x, y): &(f64, f64)| {
                let (dx, dy) = (x - middle.0, y - middle.1);
                let size = dx.hypot(dy).max(1e-9);
                (steps(x + SEAM * dx / size), steps(y + SEAM * dy / size))
            };
            let light = 0.72 + 0.28 * self.lightness(&faces[i]);
            let dim = |level: u8| (f64::from(level) * light).round() as u8;
            let color = RGBColor(dim(colors[i].0), dim(colors[i].1), dim(colors[i].2));
            area.draw(&Polygon::new(corners.iter().map(wider).collect::<Vec<_>>(), color.filled()))?;
        }
        Ok(())
    }

    /// The numbers of the faces, the farthest first.
    fn by_depth(&self, faces: &[[Space; 4]]) -> Vec<usize> {
        let nearness: Vec<f64> = faces.iter().map(|face| face.iter().map(|&p| self.nearness(p)).sum()).collect();
        let mut order: Vec<usize> = (0..faces.len()).collect();
        order.sort_by(|&a, &b| nearness[a].total_cmp(&nearness[b]).then(a.cmp(&b)));
        order
    }

    /// 0 black … 1 white: light from the upper left, behind the eye.
    fn lightness(&self, face: &[Space; 4]) -> f64 {
        let [a, b, c, d] = face.map(|p| self.turned(p));
        let diagonal = |p: [f64; 3], q: [f64; 3]| [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
        let (u, v) = (diagonal(a, c), diagonal(b, d));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let size = normal.iter().map(|n| n * n).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        let along = |direction: [f64; 3]| normal.iter().zip(direction).map(|(n, d)| n * d).sum::<f64>() / size;
        let outside = 0.0 < along([0.0, -self.elevation.cos(), self.elevation.sin()]);
        // A unit vector: left, towards the eye, up.
        let lit = along([-0.48, -0.64, 0.6]) * if outside { 1.0 } else { -1.0 };
        let (dark, bright) = if outside { (0.55, 0.97) } else { (0.38, 0.68) };
        dark + (bright - dark) * lit.max(0.0)
    }

    /// A square floor about the axis, with x and y in cm along its near edges and heights up its left corner.
    pub fn floor(&self, area: &Area<'_>, floor: &Floor, heights: &Heights) -> Drawn {
        let (half, z) = (floor.half, heights.from);
        let count = (half / floor.tick).floor() as i32;
        let mark = |foot: (f64, f64), by: (f64, f64)| {
            let ends = vec![(steps(foot.0), steps(foot.1)), (steps(foot.0 + by.0), steps(foot.1 + by.1))];
            area.draw(&PathElement::new(ends, line(GREY, 0.15)))
        };
        for at in (-count..=count).map(|i| f64::from(i) * floor.tick) {
            for ends in [[[at, -half, z], [at, half, z]], [[-half, at, z], [half, at, z]]] {
                self.path(area, ends, line(PALE, 0.12))?;
            }
            // A corner belongs to two axes: it is left without a number.
            if half - at.abs() < 1e-9 {
                continue;
            }
            let text = number::plain(at / CENTIMETRE);
            let (x, y) = self.place([at, -half, z]);
            mark((x, y), (0.4, 1.0))?;
            sheet::text_centre(area, &text, x + 0.8, y + 2.7, SMALL, INK)?;
            let (x, y) = self.place([-half, at, z]);
            mark((x, y), (-0.9, 0.6))?;
            sheet::text_right(area, &text, x - 1.4, y + 1.2, SMALL, INK)?;
        }
        self.path(area, [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z], [-half, -half, z]], line(GREY, 0.15))?;
        let (x, y) = self.place([0.0, -half, z]);
        sheet::text_centre(area, "x, cm", x + 4.0, y + 7.5, LABEL, INK)?;
        let (x, y) = self.place([-half, 0.0, z]);
        sheet::text_right(area, "y, cm", x - 6.0, y + 4.5, LABEL, INK)?;
        self.path(area, [[-half, half, z], [-half, half, heights.to]], line(GREY, 0.15))?;
        let levels = ((heights.to - z) / heights.tick + 1e-9).floor() as i32;
        for height in (0..=levels).map(|i| z + f64::from(i) * heights.tick) {
            let (x, y) = self.place([-half, half, height]);
            mark((x, y), (-1.0, 0.0))?;
            sheet::text_right(area, &number::fixed(height / heights.unit, 0), x - 1.6, y, SMALL, INK)?;
        }
        let (x, y) = self.place([-half, half, heights.to]);
        sheet::text_centre(area, heights.name, x, y - 2.6, LABEL, INK)
    }
}

/// The floor of a scene, m.
#[derive(Debug, Clone, Copy)]
pub struct Floor {
    /// Half its side.
    pub half: f64,
    pub tick: f64,
}

/// The upright axis of a scene, m; it stands on the floor.
#[derive(Debug, Clone, Copy)]
pub struct Heights {
    pub from: f64,
    pub to: f64,
    pub tick: f64,
    /// What its numbers count in.
    pub unit: f64,
    pub name: &'static str,
}

fn grey(lightness: f64) -> RGBColor {
    let level = (255.0 * lightness.clamp(0.0, 1.0)).round() as u8;
    RGBColor(level, level, level)
}

/// The faces between neighbouring rings of equally many points, the first ring above the next; outer side outwards where points run
/// counter-clockwise seen from above.
pub fn between(rings: &[Vec<Space>]) -> Vec<[Space; 4]> {
    let strip = |pair: &[Vec<Space>]| -> Vec<[Space; 4]> {
        let (upper, lower) = (&pair[0], &pair[1]);
        (0..upper.len())
            .map(|i| {
                let next = (i + 1) % upper.len();
                [lower[i], lower[next], upper[next], upper[i]]
            })
            .collect()
    };
    rings.windows(2).flat_map(strip).collect()
}
