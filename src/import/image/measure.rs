//! The size of things of known size in a picture: a disc, a bar.

use super::edge::{self, Contour, Field};
use super::linear::Normal;
use super::trace::{Piece, Scene};

/// A length in the picture, and how well it is known.
pub(super) struct Measured {
    /// px.
    pub length: f64,
    /// Of the length.
    pub relative_standard_error: f64,
    /// What it looks like: numbers for a person.
    pub seen: String,
    /// Its outline in the picture, px.
    pub mark: Vec<[f64; 2]>,
}

/// Least radius of a disc, px: below it half a grey level is a percent.
const LEAST_RADIUS: f64 = 12.0;
/// Departure from an ellipse, rms, of the radius (and half a pixel), up to which a part is a disc.
const ROUND: f64 = 0.008;
/// Half the relative difference of the axes up to which the camera looks straight enough: 0.01 is a tilt of 11°, and 0.7 % rms of size.
const STRAIGHT: f64 = 0.01;
/// Points of an edge this far apart err independently, px.
const INDEPENDENT: f64 = 5.0;
/// What the edge of a perfect picture is known to, px (tests/import_images.rs).
const FLOOR: f64 = 0.02;

/// The diameter of the disc in a picture: a hole (a cover plate or support that shows through), an object beside the drape, or a disc of its
/// own grey in it. The largest round one is taken.
pub(super) fn disc(scene: &Scene) -> Result<Measured, (String, &'static str)> {
    let mut discs: Vec<Circle> = Vec::new();
    let mut closest: Option<Circle> = None;
    let mut consider = |contour: Contour| match Circle::through(contour.points) {
        Some(circle) if circle.is_round() => discs.push(circle),
        Some(circle) if closest.as_ref().is_none_or(|c| circle.off() < c.off()) => closest = Some(circle),
        _ => (),
    };
    let least = (std::f64::consts::PI * LEAST_RADIUS * LEAST_RADIUS) as usize;
    let pieces: Vec<Piece> = scene.holes().into_iter().chain(scene.others()).filter(|p| least <= p.part.pixels).collect();
    pieces.iter().take(20).for_each(|piece| consider(scene.edge_of(piece)));
    if discs.is_empty() {
        let mut consider = |contour: Contour| discs.extend(Circle::through(contour.points).filter(Circle::is_round));
        for (shares, parts) in [true, false].into_iter().filter_map(|lighter| scene.within(lighter)) {
            let field = Field { grey: &scene.grey, shares: &shares, inverted: false };
            let inner = parts.parts.iter().enumerate().filter(|(_, part)| part.inside && least <= part.pixels && !part.touches_border);
            for (label, part) in inner.take(20) {
                consider(edge::contour(&field, part.first, &|at| parts.labels[at] == label as u32, scene.contour.tone));
            }
        }
    }
    let count = discs.len();
    let Some(disc) = discs.into_iter().max_by(|a, b| a.radius.total_cmp(&b.radius)) else {
        let seen = match closest {
            Some(c) => format!(
                "no disc was found: of {} things in the picture the roundest (radius {:.0} px) departs from an ellipse by {:.1} px rms",
                pieces.len().max(1),
                c.radius,
                c.rms
            ),
            None => "no disc was found: the picture shows nothing but the drape".into(),
        };
        return Err((seen, "let a plain disc show whole, beside the drape or as the plate on it, in a shade of its own"));
    };
    if STRAIGHT < disc.flattening {
        let (long, short) = (2.0 * disc.radius * (1.0 + disc.flattening), 2.0 * disc.radius * (1.0 - disc.flattening));
        let tilt = (short / long).acos().to_degrees();
        return Err((
            format!("the disc is seen as an ellipse of {long:.1} × {short:.1} px: the camera is tilted by about {tilt:.0}°"),
            "let the camera look straight down (within 11°), or use a checkerboard, which corrects a tilt",
        ));
    }
    let points = std::f64::consts::TAU * disc.radius / INDEPENDENT;
    let random = disc.rms.max(FLOOR) / points.sqrt() / disc.radius;
    // Round an ellipse the radius varies as a cosine: rms 1/√2.
    let error = random.hypot(disc.flattening / 2_f64.sqrt()).hypot(FLOOR / disc.radius);
    let others = if 1 < count { format!(", the largest of {count}") } else { String::new() };
    Ok(Measured {
        length: 2.0 * disc.radius,
        relative_standard_error: error,
        seen: format!(
            "disc of {:.2} px{others}, round to {:.2} px rms, axes alike to {:.2} %",
            2.0 * disc.radius,
            disc.rms,
            200.0 * disc.flattening
        ),
        mark: disc.points,
    })
}

struct Circle {
    points: Vec<[f64; 2]>,
    radius: f64,
    /// Half the relative difference of the axes.
    flattening: f64,
    /// Departure from the ellipse, px.
    rms: f64,
}

impl Circle {
    /// Radius as a function of the angle about the centre, up to the second harmonic; the centre is moved until the first vanishes.
    fn through(points: Vec<[f64; 2]>) -> Option<Self> {
        let n = points.len() as f64;
        let mut centre = [0, 1].map(|c| points.iter().map(|p| p[c]).sum::<f64>() / n);
        let mut found = None;
        for _ in 0..6 {
            let mut normal = Normal::<5>::new();
            let row = |angle: f64| [1.0, angle.cos(), angle.sin(), (2.0 * angle).cos(), (2.0 * angle).sin()];
            let polar: Vec<(f64, f64)> =
                points.iter().map(|p| (p[0] - centre[0], p[1] - centre[1])).map(|(x, y)| (y.atan2(x), x.hypot(y))).collect();
            polar.iter().for_each(|(angle, radius)| normal.add(&row(*angle), *radius, 1.0));
            let c = normal.solve()?;
            centre = [centre[0] + c[1], centre[1] + c[2]];
            let squares: f64 = polar.iter().map(|(a, r)| (r - row(*a).iter().zip(&c).map(|(x, y)| x * y).sum::<f64>()).powi(2)).sum();
            found = Some((c, (squares / n).sqrt()));
        }
        let (c, rms) = found?;
        Some(Circle { points, radius: c[0], flattening: c[3].hypot(c[4]) / c[0], rms })
    }

    /// Departure from an ellipse, of what a disc may have.
    fn off(&self) -> f64 {
        self.rms / (ROUND * self.radius + 0.5)
    }

    fn is_round(&self) -> bool {
        // A wider ellipse is no tilted disc but a thing of its own.
        LEAST_RADIUS <= self.radius && self.off() <= 1.0 && self.flattening <= 0.15
    }
}

/// Least length over width of a bar.
const SLENDER: f64 = 4.0;
/// Least share of its rectangle that a bar fills.
const FULL: f64 = 0.85;

/// The length of the bar beside the drape.
pub(super) fn bar(scene: &Scene) -> Result<Measured, (String, &'static str)> {
    const RIGHT: &str = "let one plain straight bar, at least four times as long as wide, show whole beside the drape, in its shade";
    let pieces: Vec<Piece> = scene.others().into_iter().chain(scene.holes()).filter(|p| 40 <= p.part.pixels).collect();
    let mut bars: Vec<(&Piece, super::parts::Extent)> = pieces
        .iter()
        .map(|piece| (piece, piece.part.extent(scene.grey.width)))
        .filter(|(piece, e)| {
            20.0 <= e.length && 2.5 <= e.width && SLENDER * e.width <= e.length && FULL * e.length * e.width <= piece.part.pixels as f64
        })
        .collect();
    bars.sort_by(|a, b| b.1.length.total_cmp(&a.1.length));
    if let [(_, a), (_, b), ..] = &bars[..]
        && 0.5 * a.length < b.length
    {
        return Err((
            format!("{} bars were found, of {:.0} and {:.0} px", bars.len(), a.length, b.length),
            "leave only one bar in the picture",
        ));
    }
    let Some((piece, extent)) = bars.into_iter().next() else {
        return Err((format!("no bar was found among {} things beside the drape", pieces.len()), RIGHT));
    };
    let [ux, uy] = extent.along;
    let at = |u: f64, v: f64| [extent.centre[0] + u * ux - v * uy, extent.centre[1] + u * uy + v * ux];
    let field = scene.field(piece);
    let tone = scene.contour.tone;
    // As long as what a line along the bar is covered, in light: as for the edge of the drape.
    const STEP: f64 = 0.25;
    const BEYOND: f64 = 6.0;
    let half = 0.5 * extent.length + BEYOND;
    let steps = (2.0 * half / STEP) as usize;
    let line = |v: f64| {
        let values: Vec<f64> = (0..=steps).map(|k| field.light_at(at(k as f64 * STEP - half, v), tone)).collect();
        let mean = |from: usize, to: usize| values[from..to].iter().sum::<f64>() / (to - from) as f64;
        let beyond = (2.0 / STEP) as usize;
        let inner = mean(steps / 4, 3 * steps / 4);
        let outer = 0.5 * (mean(0, beyond) + mean(steps - beyond, steps));
        STEP * values.iter().map(|v| (v - outer) / (inner - outer)).sum::<f64>()
    };
    let lines: Vec<f64> = (-5..=5).map(|k| line(f64::from(k) * 0.06 * extent.width)).collect();
    let n = lines.len() as f64;
    let length = lines.iter().sum::<f64>() / n;
    let spread = (lines.iter().map(|l| (l - length).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    if !(length.is_finite() && spread <= 0.02 * length + 0.5) {
        return Err((format!("the bar's ends are ragged: {length:.1} ± {spread:.1} px"), RIGHT));
    }
    // Lines a pixel apart err independently.
    let independent = (0.6 * extent.width).clamp(1.0, n);
    let error = (spread / independent.sqrt()).hypot(2_f64.sqrt() * FLOOR) / length;
    let corner = |su: f64, sv: f64| at(0.5 * su * length, 0.5 * sv * extent.width);
    Ok(Measured {
        length,
        relative_standard_error: error,
        seen: format!("bar of {length:.2} × {:.1} px, ends even to {spread:.2} px", extent.width),
        mark: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
    })
}
