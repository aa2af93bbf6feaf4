//! Foot points: which point of the hem curve is nearest to a measured one.

use std::f64::consts::TAU;

use crate::experiment::Point;
use crate::model::hem::{Hem, Local, Placement};

/// A measured point in the frame of the curve: centred, turned back by the phase.
#[derive(Debug, Clone, Copy)]
pub struct Centred {
    pub x: f64,
    pub y: f64,
}

/// A point in the frame of a curve that lies at `placement`.
pub fn centred(point: Point, placement: &Placement) -> Centred {
    let (sin, cos) = placement.phase.sin_cos();
    let (dx, dy) = (point.x - placement.x0, point.y - placement.y0);
    Centred { x: dx * cos + dy * sin, y: dy * cos - dx * sin }
}

/// A foot point: its parameter, what is local there, and the offset of the measured point from it in the turning frame (radial, tangential).
#[derive(Debug, Clone, Copy)]
pub struct Foot {
    pub t: f64,
    pub local: Local,
    pub offset: (f64, f64),
}

impl Foot {
    /// The foot at parameter `t`, whether or not it is nearest.
    pub fn at(hem: &Hem, point: Centred, t: f64) -> Foot {
        let local = hem.local(t);
        let (sin, cos) = t.sin_cos();
        let offset = (point.x * cos + point.y * sin - local.position.0, point.y * cos - point.x * sin - local.position.1);
        Foot { t, local, offset }
    }

    /// Signed distance along the outward normal, m; exact at a foot point.
    pub fn distance(&self) -> f64 {
        let (radial, tangential) = self.local.velocity;
        (self.offset.0 * tangential - self.offset.1 * radial) / self.local.speed()
    }

    /// Squared length of the offset, m².
    pub fn square(&self) -> f64 {
        self.offset.0 * self.offset.0 + self.offset.1 * self.offset.1
    }
}

/// Follows the foot of `point` from `t` downhill to the nearest stationary point of the distance.
///
/// Newton on the squared distance, with the Gauss–Newton curvature where the true one is not positive (a far point inside a bend), the
/// step shortened until the distance falls; each step is at most a twelfth of a fold, so that a foot does not hop to another fold.
pub fn follow(hem: &Hem, point: Centred, t: f64) -> Foot {
    let longest = TAU / (12.0 * f64::from(hem.folds.max(1)));
    let mut foot = Foot::at(hem, point, t);
    for _ in 0..40 {
        let ((ux, uy), (ax, ay)) = (foot.local.velocity, foot.local.acceleration);
        let slope = -(foot.offset.0 * ux + foot.offset.1 * uy);
        let gauss = ux * ux + uy * uy;
        let newton = gauss - (foot.offset.0 * ax + foot.offset.1 * ay);
        let curvature = if 0.1 * gauss < newton { newton } else { gauss };
        if curvature <= 0.0 || !slope.is_finite() {
            return foot;
        }
        let mut step = (-slope / curvature).clamp(-longest, longest);
        // A relative 1e-15 of a turn is rounding of t itself.
        if step.abs() < 1e-15 * (1.0 + foot.t.abs()) {
            return foot;
        }
        // Newton's last steps are below the rounding of the squared distance: that of the position times the distance.
        let square = foot.square();
        let rounding = 8.0 * f64::EPSILON * (hem.p + hem.q.abs() + hem.s.abs()) * square.sqrt();
        let mut cut = false;
        let next = loop {
            let next = Foot::at(hem, point, foot.t + step);
            if next.square() <= square + rounding {
                break next;
            }
            cut = true;
            step *= 0.25;
            if step.abs() < 1e-15 * (1.0 + foot.t.abs()) {
                return foot;
            }
        };
        foot = next;
        // Newton converges quadratically: what is left after such a step is rounding.
        if !cut && 0.1 * gauss < newton && step.abs() < 1e-9 {
            return foot;
        }
    }
    foot
}

/// The nearest foot of `point` over the whole curve, by `samples` starts a fold.
pub fn nearest(hem: &Hem, point: Centred, samples: usize) -> Foot {
    let count = samples * hem.folds.max(1) as usize;
    nearest_within(hem, point, 0.0, TAU * (count - 1) as f64 / count as f64, count)
}

/// The nearest foot among `count` starts spread evenly over `from..=to`.
pub fn nearest_within(hem: &Hem, point: Centred, from: f64, to: f64, count: usize) -> Foot {
    let step = (to - from) / (count.max(2) - 1) as f64;
    let start = (0..count)
        .map(|i| from + step * i as f64)
        .map(|t| (Foot::at(hem, point, t).square(), t))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(from, |(_, t)| t);
    follow(hem, point, start)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEM: Hem = Hem { p: 0.1315, q: 0.0527, s: 0.00873, folds: 5 };

    #[test]
    fn the_offset_is_normal_to_the_curve_at_the_foot() {
        let placement = Placement { x0: 0.02, y0: -0.01, phase: 0.3 };
        for i in 0..200 {
            let t = 0.0314 * f64::from(i);
            let on = HEM.point(&placement, t);
            let point = Point::new(on.x + 0.004 * (7.0 * t).sin(), on.y + 0.004 * (5.0 * t).cos());
            let foot = follow(&HEM, centred(point, &placement), t);
            let along = foot.offset.0 * foot.local.velocity.0 + foot.offset.1 * foot.local.velocity.1;
            // t is held to 1e-15 (1 + t), at most 8e-15; times speed squared, at most 0.2 m².
            assert!(along.abs() < 2e-15, "{along}");
            assert!((foot.square().sqrt() - foot.distance().abs()).abs() < 1e-15);
        }
    }

    #[test]
    fn nearest_agrees_with_a_dense_scan() {
        for i in 0..100 {
            let angle = 0.7 * f64::from(i);
            let point = Centred { x: 0.15 * angle.cos(), y: 0.11 * (1.3 * angle).sin() };
            let scan = (0..20_000).map(|j| Foot::at(&HEM, point, TAU * f64::from(j) / 20_000.0).square()).fold(f64::MAX, f64::min);
            let found = nearest(&HEM, point, 32).square();
            // The scan is off by at most half its spacing, 3e-5 m.
            assert!(found.sqrt() <= scan.sqrt() + 1e-9 && scan.sqrt() - found.sqrt() < 3e-5, "{i}: {found} {scan}");
        }
    }
}
