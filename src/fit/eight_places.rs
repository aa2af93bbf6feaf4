//! The hem curve at eight parameters at a time, and how it moves with its unknowns.

use crate::experiment::Point;
use crate::model::hem::{Hem, Placement};
use crate::numerics::lanes::{Lanes, Vector, WIDTH, sin_cos};
use crate::vectorized;

/// Eight places on a placed hem; pairs are (radial, tangential) in the frame that turns with `e_r`, m.
pub(super) struct Places<V> {
    /// Of the angle at which `e_r` lies.
    sin: V,
    cos: V,
    position: [V; 2],
    velocity: [V; 2],
    cos_fold: V,
    sin_lean: V,
}

impl<V: Vector> Places<V> {
    #[inline(always)]
    pub fn at(hem: &Hem, placement: &Placement, t: V) -> Self {
        let m = f64::from(hem.folds);
        let (sin, cos) = sin_cos(t + placement.phase);
        let (sin_fold, cos_fold) = sin_cos(t * m);
        let sin_lean = sin_fold * cos_fold * 2.0;
        let cos_lean = V::all(1.0) - sin_fold * sin_fold * 2.0;
        let (rho, tau) = (cos_fold * hem.q + hem.p, sin_lean * hem.s);
        let velocity = [sin_fold * (-hem.q * m) - tau, rho + cos_lean * (2.0 * m * hem.s)];
        Places { sin, cos, position: [rho, tau], velocity, cos_fold, sin_lean }
    }

    /// From the turning frame to that of the measurement.
    #[inline(always)]
    fn world(&self, [radial, tangential]: [V; 2]) -> [V; 2] {
        [radial * self.cos - tangential * self.sin, radial * self.sin + tangential * self.cos]
    }

    #[inline(always)]
    pub fn point(&self, placement: &Placement) -> [V; 2] {
        let [x, y] = self.world(self.position);
        [x + placement.x0, y + placement.y0]
    }

    /// By the parameter, in the frame of the measurement.
    #[inline(always)]
    pub fn velocity(&self) -> [V; 2] {
        self.world(self.velocity)
    }

    #[inline(always)]
    pub fn speed(&self) -> V {
        (self.velocity[0] * self.velocity[0] + self.velocity[1] * self.velocity[1]).sqrt()
    }

    /// How x and y move with x0, y0, phase, p, q and s.
    #[inline(always)]
    pub fn moved(&self) -> [[V; 2]; 6] {
        let [x, y] = self.world(self.position);
        let (zero, one) = (V::zero(), V::all(1.0));
        [
            [one, zero],
            [zero, one],
            [-y, x],
            [self.cos, self.sin],
            [self.cos_fold * self.cos, self.cos_fold * self.sin],
            [-(self.sin_lean * self.sin), self.sin_lean * self.cos],
        ]
    }
}

/// Numbers in eights; the last is filled up with `rest`.
pub(super) fn in_eights(numbers: impl Iterator<Item = f64>, rest: f64) -> Vec<Lanes> {
    let mut eights: Vec<Lanes> = Vec::with_capacity(numbers.size_hint().0.div_ceil(WIDTH));
    for (i, number) in numbers.enumerate() {
        if i % WIDTH == 0 {
            eights.push(Lanes([rest; WIDTH]));
        }
        eights.last_mut().expect("just pushed").0[i % WIDTH] = number;
    }
    eights
}

/// Points of the hem at these parameters, m.
pub(super) fn points_at(hem: &Hem, placement: &Placement, parameters: impl ExactSizeIterator<Item = f64>) -> Vec<Point> {
    let count = parameters.len();
    let mut points = Vec::with_capacity(count + WIDTH);
    write_points(hem, placement, &in_eights(parameters, 0.0), &mut points);
    points.truncate(count);
    points
}

vectorized! {
    fn write_points<V>(hem: &Hem, placement: &Placement, parameters: &[Lanes], points: &mut Vec<Point>) -> () {
        for t in parameters {
            let [x, y] = Places::at(hem, placement, V::of(t)).point(placement);
            let (x, y) = (x.lanes().0, y.lanes().0);
            for lane in 0..WIDTH {
                points.push(Point::new(x[lane], y[lane]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_places_are_those_of_one_at_a_time() {
        let hem = Hem { p: 0.15, q: 0.05, s: 0.02, folds: 7 };
        let placement = Placement { x0: 0.02, y0: -0.01, phase: 0.3 };
        let parameters: Vec<f64> = (0..83).map(|i| 0.17 * f64::from(i) - 3.0).collect();
        let points = points_at(&hem, &placement, parameters.iter().copied());
        assert_eq!(points.len(), parameters.len());
        for (point, &t) in points.iter().zip(&parameters) {
            assert!(point.distance(hem.point(&placement, t)) < 1e-15);
        }
        for eight in in_eights(parameters.iter().copied(), 0.0) {
            let places = Places::at(&hem, &placement, eight);
            let velocity = places.velocity();
            for (lane, &t) in eight.0.iter().enumerate() {
                let (local, (sin, cos)) = (hem.local(t), (t + placement.phase).sin_cos());
                assert!((places.speed().0[lane] - local.speed()).abs() < 1e-14);
                let exact = (local.velocity.0 * cos - local.velocity.1 * sin, local.velocity.0 * sin + local.velocity.1 * cos);
                assert!((velocity[0].0[lane] - exact.0).abs() + (velocity[1].0[lane] - exact.1).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn motions_agree_with_central_differences() {
        let unknowns = [0.02, -0.01, 0.3, 0.15, 0.05, 0.02];
        let of = |u: [f64; 6]| (Hem { p: u[3], q: u[4], s: u[5], folds: 7 }, Placement { x0: u[0], y0: u[1], phase: u[2] });
        let t = Lanes(std::array::from_fn(|lane| 0.7 * lane as f64));
        let (hem, placement) = of(unknowns);
        let moved = Places::at(&hem, &placement, t).moved();
        for (j, [by_x, by_y]) in moved.iter().enumerate() {
            let at = |step: f64, t: f64| {
                let mut changed = unknowns;
                changed[j] += step;
                let (hem, placement) = of(changed);
                hem.point(&placement, t)
            };
            for lane in 0..WIDTH {
                let (more, less) = (at(1e-6, t.0[lane]), at(-1e-6, t.0[lane]));
                // The third derivative by the phase is of the size of the curve: 1e-13; rounding 1e-10.
                assert!(((more.x - less.x) / 2e-6 - by_x.0[lane]).abs() < 1e-9 && ((more.y - less.y) / 2e-6 - by_y.0[lane]).abs() < 1e-9);
            }
        }
    }
}
