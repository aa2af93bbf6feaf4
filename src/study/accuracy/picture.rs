//! Work and precision of tracing: the size of a picture against the error of its outline.

use super::apart;
use super::{Panel, Row, Setup};
use crate::error::Error;
use crate::experiment::Point;
use crate::model::hem::Placement;
use crate::study::drawn::{HEM, generator, normal};
use crate::units::Metre;

/// A square grey picture: dark cloth on a light ground.
pub struct Picture {
    /// px.
    pub side: usize,
    /// By rows, the top one first, 0 (black) … 1 (white).
    pub values: Vec<f32>,
    /// Side of a pixel.
    pub pixel: Metre,
}

/// What finds the outline in a picture: points in metres from the lower left corner, x to the right, y up.
pub type Trace<'a> = dyn Fn(&Picture) -> Result<Vec<Point>, Error> + 'a;

/// Side of the field of view, m.
const VIEW: f64 = 0.55;
/// Scan lines a pixel; on each the covered length is exact.
const LINES: usize = 16;
/// Light of cloth and ground, and noise of the camera, in parts of full scale.
const CLOTH: f64 = 0.08;
const GROUND: f64 = 0.85;
const NOISE: f64 = 0.01;

/// Where the hem lies in the picture: its middle off the grid of pixels.
const AT: Placement = Placement { x0: 0.2753, y0: 0.2738, phase: 0.37 };

/// The hem as a camera of `side` pixels sees it from above.
pub fn rendered(side: usize, seed: u64) -> Picture {
    let pixel = VIEW / side as f64;
    // A polygon finer than a hundredth of a pixel's sagitta.
    let corners = HEM.outline(&AT, 20_000.max(20 * side));
    let corner = |p: &Point| (p.x / pixel, side as f64 - p.y / pixel);
    let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); side * LINES];
    for (i, a) in corners.iter().enumerate() {
        let ((ax, ay), (bx, by)) = (corner(a), corner(&corners[(i + 1) % corners.len()]));
        let (low, high) = (ay.min(by), ay.max(by));
        let first = (low * LINES as f64 - 0.5).ceil().max(0.0) as usize;
        for (line, found) in crossings.iter_mut().enumerate().skip(first) {
            let y = (line as f64 + 0.5) / LINES as f64;
            if high <= y {
                break;
            }
            found.push(ax + (bx - ax) * (y - ay) / (by - ay));
        }
    }
    let mut covered = vec![0.0; side * side];
    for (line, found) in crossings.iter_mut().enumerate() {
        found.sort_by(f64::total_cmp);
        for pair in found.chunks_exact(2) {
            for x in pair[0].max(0.0) as usize..side.min(pair[1] as usize + 1) {
                let inside = pair[1].min(x as f64 + 1.0) - pair[0].max(x as f64);
                covered[(line / LINES) * side + x] += inside.max(0.0) / LINES as f64;
            }
        }
    }
    let mut random = generator(seed);
    let value = |share: f64, noise: f64| (GROUND + share * (CLOTH - GROUND) + NOISE * noise).clamp(0.0, 1.0) as f32;
    let values = covered.into_iter().map(|share| value(share, normal(&mut random))).collect();
    Picture { side, values, pixel: Metre(pixel) }
}

/// Pictures of 60 to 3200 pixels a side.
pub(super) fn resolution(setup: &Setup<'_>, trace: &Trace) -> Result<Panel, Error> {
    let sides: Vec<usize> = setup.pick(
        vec![20, 100, 400],
        vec![20, 40, 60, 100, 150, 200, 300, 400, 600, 800, 1200, 1600, 2400],
        vec![20, 40, 60, 100, 150, 200, 300, 400, 600, 800, 1200, 1600, 2400, 3200, 4000],
    );
    let mut rows = Vec::new();
    for side in sides {
        let picture = rendered(side, setup.options.seed.wrapping_add(4000));
        let (outline, seconds) = setup.time(|| trace(&picture));
        let (error, termination) = match &outline {
            Ok(points) => (apart::outline_from_curve(points, &HEM, &AT), "traced".to_string()),
            Err(refused) => (None, format!("refused: {refused}")),
        };
        rows.push(Row {
            method: "traced picture".into(),
            knob: "pixels a side",
            setting: side as f64,
            asked: None,
            error,
            seconds,
            evaluations: Some(side * side),
            termination,
            claims: error.is_some(),
            default: false,
        });
    }
    Ok(Panel {
        name: "tracing",
        title: "Tracing: pixels of a picture 55 cm wide",
        reference: "the curve that was drawn".into(),
        unit: "pixels",
        rows,
    })
}
