//! Foot points: which point of the hem curve is nearest to a measured one.

use std::f64::consts::TAU;

use crate::experiment::Point;
use crate::model::hem::{Hem, Local, Placement};
use crate::numerics::lanes::{Lanes, Vector, WIDTH, sin_cos};
use crate::vectorized;

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

/// The foot of each of `points` (where they were measured), as [`follow`] finds it from the parameters `from`; eight at a time.
pub fn follow_all(hem: &Hem, placement: &Placement, points: &[Point], from: &[f64]) -> Vec<Foot> {
    let mut feet = Vec::with_capacity(points.len());
    follow_eights(hem, placement, points, from, &mut feet);
    feet
}

/// Eight feet.
#[derive(Clone, Copy)]
struct Feet<V> {
    t: V,
    position: [V; 2],
    velocity: [V; 2],
    acceleration: [V; 2],
    cos_fold: V,
    sin_lean: V,
    offset: [V; 2],
}

impl<V: Vector> Feet<V> {
    /// As [`Foot::at`].
    #[inline(always)]
    fn at(hem: &Hem, [x, y]: [V; 2], t: V) -> Self {
        let m = f64::from(hem.folds);
        let (sin_fold, cos_fold) = sin_cos(t * m);
        let sin_lean = sin_fold * cos_fold * 2.0;
        let cos_lean = V::all(1.0) - sin_fold * sin_fold * 2.0;
        let (rho, tau) = (cos_fold * hem.q + hem.p, sin_lean * hem.s);
        let (rho1, tau1) = (sin_fold * (-hem.q * m), cos_lean * (2.0 * m * hem.s));
        let (rho2, tau2) = (cos_fold * (-hem.q * m * m), tau * (-4.0 * m * m));
        let (sin, cos) = sin_cos(t);
        Feet {
            t,
            position: [rho, tau],
            velocity: [rho1 - tau, rho + tau1],
            acceleration: [rho2 - tau1 * 2.0 - rho, tau2 + rho1 * 2.0 - tau],
            cos_fold,
            sin_lean,
            offset: [x * cos + y * sin - rho, y * cos - x * sin - tau],
        }
    }

    #[inline(always)]
    fn square(&self) -> V {
        self.offset[0] * self.offset[0] + self.offset[1] * self.offset[1]
    }

    /// Lane by lane `other` where `which` is 1, `self` where it is 0.
    #[inline(always)]
    fn replaced(&self, which: V, other: &Self) -> Self {
        Feet {
            t: either(which, other.t, self.t),
            position: both(which, other.position, self.position),
            velocity: both(which, other.velocity, self.velocity),
            acceleration: both(which, other.acceleration, self.acceleration),
            cos_fold: either(which, other.cos_fold, self.cos_fold),
            sin_lean: either(which, other.sin_lean, self.sin_lean),
            offset: both(which, other.offset, self.offset),
        }
    }

    #[inline(always)]
    fn write(&self, count: usize, feet: &mut Vec<Foot>) {
        let (t, cos_fold, sin_lean) = (self.t.lanes().0, self.cos_fold.lanes().0, self.sin_lean.lanes().0);
        let [[p0, p1], [v0, v1], [a0, a1], [o0, o1]] = [
            [self.position[0].lanes().0, self.position[1].lanes().0],
            [self.velocity[0].lanes().0, self.velocity[1].lanes().0],
            [self.acceleration[0].lanes().0, self.acceleration[1].lanes().0],
            [self.offset[0].lanes().0, self.offset[1].lanes().0],
        ];
        for i in 0..count {
            let local = Local {
                position: (p0[i], p1[i]),
                velocity: (v0[i], v1[i]),
                acceleration: (a0[i], a1[i]),
                cos_fold: cos_fold[i],
                sin_lean: sin_lean[i],
            };
            feet.push(Foot { t: t[i], local, offset: (o0[i], o1[i]) });
        }
    }
}

/// `new` in the lanes in which `which` is 1.
#[inline(always)]
fn either<V: Vector>(which: V, new: V, old: V) -> V {
    V::choose(V::all(0.5), which, new, old)
}

#[inline(always)]
fn both<V: Vector>(which: V, new: [V; 2], old: [V; 2]) -> [V; 2] {
    [either(which, new[0], old[0]), either(which, new[1], old[1])]
}

/// 1 in the lanes in which `low` is less than `high` and `among` is 1.
#[inline(always)]
fn less<V: Vector>(low: V, high: V, among: V) -> V {
    V::choose(low, high, among, V::zero())
}

#[inline(always)]
fn any<V: Vector>(which: V) -> bool {
    which.lanes().0.iter().any(|lane| *lane != 0.0)
}

vectorized! {
    fn follow_eights<V>(hem: &Hem, placement: &Placement, points: &[Point], from: &[f64], feet: &mut Vec<Foot>) -> () {
        let longest = TAU / (12.0 * f64::from(hem.folds.max(1)));
        let (sin, cos) = placement.phase.sin_cos();
        let size = 8.0 * f64::EPSILON * (hem.p + hem.q.abs() + hem.s.abs());
        for (points, from) in points.chunks(WIDTH).zip(from.chunks(WIDTH)) {
            // Lanes without a point follow the first.
            let at = |lane: usize| if lane < points.len() { lane } else { 0 };
            let dx = V::of(&Lanes(std::array::from_fn(|lane| points[at(lane)].x - placement.x0)));
            let dy = V::of(&Lanes(std::array::from_fn(|lane| points[at(lane)].y - placement.y0)));
            let point = [dx * cos + dy * sin, dy * cos - dx * sin];
            let mut foot = Feet::at(hem, point, V::of(&Lanes(std::array::from_fn(|lane| from[at(lane)]))));
            // 1 while a lane is on its way.
            let mut moving = V::all(1.0);
            for _ in 0..40 {
                let ([ux, uy], [ax, ay], [ox, oy]) = (foot.velocity, foot.acceleration, foot.offset);
                let slope = -(ox * ux + oy * uy);
                let gauss = ux * ux + uy * uy;
                let newton = gauss - (ox * ax + oy * ay);
                let sound = less(gauss * 0.1, newton, V::all(1.0));
                let curvature = V::choose(gauss * 0.1, newton, newton, gauss);
                moving = less(V::zero(), curvature, less(slope.abs(), V::all(f64::INFINITY), moving));
                let mut step = (-slope / curvature).within(longest);
                let rounding_of_t = (foot.t.abs() + 1.0) * 1e-15;
                moving = moving - less(step.abs(), rounding_of_t, moving);
                if !any(moving) {
                    break;
                }
                let square = foot.square();
                let most = square + square.sqrt() * size;
                let (mut pending, mut cut) = (moving, V::zero());
                loop {
                    let next = Feet::at(hem, point, foot.t + step);
                    let nearer = V::choose(most, next.square(), V::zero(), less(next.square(), V::all(f64::INFINITY), pending));
                    foot = foot.replaced(nearer, &next);
                    pending = pending - nearer;
                    if !any(pending) {
                        break;
                    }
                    cut = cut.max(pending);
                    step = V::choose(V::zero(), pending, step * 0.25, step);
                    let given_up = less(step.abs(), rounding_of_t, pending);
                    (pending, moving) = (pending - given_up, moving - given_up);
                    if !any(pending) {
                        break;
                    }
                }
                let uncut = less(cut, V::all(0.5), moving);
                moving = moving - less(step.abs(), V::all(1e-9), uncut * sound);
            }
            foot.write(points.len(), feet);
        }
    }
}

/// The nearest foot of `point` over the whole curve, by `samples` starts a fold.
pub fn nearest(hem: &Hem, point: Centred, samples: usize) -> Foot {
    let count = samples * hem.folds.max(1) as usize;
    nearest_within(hem, point, 0.0, TAU * (count - 1) as f64 / count as f64, count)
}

/// The nearest foot among `count` starts spread evenly over `from..=to`.
pub fn nearest_within(hem: &Hem, point: Centred, from: f64, to: f64, count: usize) -> Foot {
    follow(hem, point, nearest_start(hem, &point, from, to, count))
}

vectorized! {
    /// The nearest of `count` parameters spread evenly over `from..=to`; of several equally near ones the first.
    fn nearest_start<V>(hem: &Hem, point: &Centred, from: f64, to: f64, count: usize) -> f64 {
        let step = (to - from) / (count.max(2) - 1) as f64;
        let mut best = (f64::INFINITY, from);
        for first in (0..count).step_by(WIDTH) {
            let t = V::of(&Lanes(std::array::from_fn(|lane| from + step * (first + lane) as f64)));
            let squares = Feet::at(hem, [V::all(point.x), V::all(point.y)], t).square().lanes();
            for (lane, square) in squares.0.iter().enumerate().take(count - first) {
                if *square < best.0 {
                    best = (*square, from + step * (first + lane) as f64);
                }
            }
        }
        best.1
    }
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
    fn eight_at_a_time_are_followed_to_the_same_feet_as_one_at_a_time() {
        let placement = Placement { x0: 0.02, y0: -0.01, phase: 0.3 };
        // Near and far, inside bends too: steps are cut short, and curvatures are negative; not a multiple of eight.
        let points: Vec<Point> = (0..203).map(|i| 0.37 * f64::from(i)).map(|a| Point::new(0.2 * a.cos(), 0.14 * (1.3 * a).sin())).collect();
        let from: Vec<f64> = (0..203).map(|i| 0.31 * f64::from(i)).collect();
        let feet = follow_all(&HEM, &placement, &points, &from);
        assert_eq!(feet.len(), points.len());
        for (i, foot) in feet.iter().enumerate() {
            let alone = follow(&HEM, centred(points[i], &placement), from[i]);
            // Newton's last step is below 1e-9, and what it leaves is rounding.
            assert!((foot.t - alone.t).abs() < 1e-12, "{i}: {} {}", foot.t, alone.t);
            assert!(
                (foot.distance() - alone.distance()).abs() < 1e-15 && (foot.local.curvature() / alone.local.curvature() - 1.0).abs() < 1e-9
            );
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
