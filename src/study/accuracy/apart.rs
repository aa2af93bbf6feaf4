//! How far two profiles are apart, in metres.

use serde::Serialize;

use crate::experiment::Point;
use crate::fit::foot_point::{centred, nearest};
use crate::model::hem::{Hem, Placement};

/// Root mean square and greatest distance of two profiles, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Apart {
    pub rms: f64,
    pub max: f64,
}

impl Apart {
    /// Of distances, m; `None` if one is not finite or there are none.
    pub fn of(distances: impl IntoIterator<Item = f64>) -> Option<Apart> {
        let (mut square, mut max, mut count) = (0.0, 0.0_f64, 0.0);
        for d in distances {
            square += d * d;
            max = max.max(d.abs());
            count += 1.0;
        }
        (0.0 < count && f64::is_finite(square)).then(|| Apart { rms: (square / count).sqrt(), max })
    }

    /// Several draws as one: the mean square of their errors, the greatest of all.
    pub fn together(all: &[Apart]) -> Option<Apart> {
        let count = all.len() as f64;
        let square: f64 = all.iter().map(|a| a.rms * a.rms).sum();
        (!all.is_empty()).then(|| Apart { rms: (square / count).sqrt(), max: all.iter().map(|a| a.max).fold(0.0, f64::max) })
    }
}

/// Nodes on the reference; folds of a tenth of the hem get seventy each.
const NODES: usize = 720;

/// Orthogonal distances of evenly spread points of the `true_` curve from another one.
pub fn curves(true_: (&Hem, &Placement), other: (&Hem, &Placement)) -> Option<Apart> {
    let points = true_.0.outline(true_.1, NODES);
    Apart::of(points.iter().map(|point| nearest(other.0, centred(*point, other.1), 24).distance()))
}

/// Distances of points of an outline from a curve.
pub fn outline_from_curve(points: &[Point], hem: &Hem, at: &Placement) -> Option<Apart> {
    Apart::of(points.iter().map(|point| nearest(hem, centred(*point, at), 24).distance()))
}

/// Distances of the same points of cloth of two predicted hems; outlines are equally spaced in cloth length from a crest on the x axis.
///
/// Where one hem has more points (fold counts differ) the coarser one is interpolated linearly: folds are then centimetres apart anyway.
pub fn hems(true_: &[Point], other: &[Point]) -> Option<Apart> {
    if true_.len() == other.len() {
        return Apart::of(true_.iter().zip(other).map(|(a, b)| a.distance(*b)));
    }
    let at = |points: &[Point], share: f64| {
        let place = share * points.len() as f64;
        let i = (place as usize).min(points.len() - 1);
        let (a, b, rest) = (points[i], points[(i + 1) % points.len()], place - i as f64);
        Point::new(a.x + rest * (b.x - a.x), a.y + rest * (b.y - a.y))
    };
    let n = true_.len();
    (!other.is_empty()).then(|| Apart::of((0..n).map(|i| true_[i].distance(at(other, i as f64 / n as f64)))))?
}
