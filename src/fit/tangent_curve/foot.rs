//! Feet of many points on one curve, eight at a time.

use super::{C, Cell, TangentCurve};
use crate::numerics::lanes::{Lanes, Vector, WIDTH};
use crate::vectorized;

/// Newton steps at most.
const MOST_STEPS: usize = 30;
/// Newton converges quadratically: what is left after such a step is rounding.
const LAST_STEP: f64 = 1e-9;

/// The foot of a point on a curve; unit radius.
#[derive(Debug, Clone, Copy)]
pub struct Foot {
    pub sigma: f64,
    pub position: C,
    /// Outward, of unit length.
    pub normal: C,
    /// Of the point, positive outside.
    pub distance: f64,
}

impl TangentCurve {
    /// Follows the foot of each of `points` (frame of the curve, unit radius) downhill from its σ.
    ///
    /// Newton, with the Gauss–Newton curvature where the true one is small.
    pub fn follow(&self, points: &[C], from: &[f64]) -> Vec<Foot> {
        let mut feet = Vec::with_capacity(points.len());
        follow_all(self, points, from, &mut feet);
        feet
    }
}

/// Eight places on the curve; real and imaginary parts.
struct Places<V> {
    position: [V; 2],
    first: [V; 2],
    second: [V; 2],
}

/// As [`TangentCurve::at`], to the same bits.
#[inline(always)]
fn places<V: Vector>(curve: &TangentCurve, sigmas: &Lanes) -> Places<V> {
    let mut coefficients = [[Lanes::ZERO; 2]; 6];
    let (mut shares, mut turn) = (Lanes::ZERO, [Lanes::ZERO; 2]);
    for (lane, sigma) in sigmas.0.iter().enumerate() {
        let Cell { node, share, period } = curve.cell(*sigma);
        shares.0[lane] = share;
        for (eight, c) in coefficients.iter_mut().zip(&curve.cells[node]) {
            (eight[0].0[lane], eight[1].0[lane]) = (c.re, c.im);
        }
        let turned = curve.harmonics.turns[period];
        (turn[0].0[lane], turn[1].0[lane]) = (turned.re, turned.im);
    }
    let (x, h) = (V::of(&shares), curve.harmonics.step);
    let [cos, sin] = [V::of(&turn[0]), V::of(&turn[1])];
    let mut unturned = [[V::zero(); 2]; 3];
    for part in 0..2 {
        let [p, u, a, c3, c4, c5] = coefficients.each_ref().map(|c| V::of(&c[part]));
        unturned[0][part] = p + (u + (a + (c3 + (c4 + c5 * x) * x) * x) * x) * x;
        unturned[1][part] = (u + (a * 2.0 + (c3 * 3.0 + (c4 * 4.0 + c5 * (x * 5.0)) * x) * x) * x) / V::all(h);
        unturned[2][part] = (a * 2.0 + (c3 * 6.0 + (c4 * 12.0 + c5 * (x * 20.0)) * x) * x) / V::all(h * h);
    }
    let turn = [cos, sin];
    Places { position: turned(turn, unturned[0]), first: turned(turn, unturned[1]), second: turned(turn, unturned[2]) }
}

#[inline(always)]
fn turned<V: Vector>([cos, sin]: [V; 2], [re, im]: [V; 2]) -> [V; 2] {
    [cos * re - sin * im, cos * im + sin * re]
}

vectorized! {
    fn follow_all<V>(curve: &TangentCurve, points: &[C], from: &[f64], feet: &mut Vec<Foot>) -> () {
        let top = curve.symmetry() as usize * curve.sines().len().clamp(1, 16);
        let longest = std::f64::consts::TAU / (6.0 * top as f64);
        for (points, from) in points.chunks(WIDTH).zip(from.chunks(WIDTH)) {
            // Lanes without a point follow the first.
            let at = |lane: usize| points.get(lane).unwrap_or(&points[0]);
            let point: [V; 2] =
                [V::of(&Lanes(std::array::from_fn(|lane| at(lane).re))), V::of(&Lanes(std::array::from_fn(|lane| at(lane).im)))];
            let mut sigma = V::of(&Lanes(std::array::from_fn(|lane| *from.get(lane).unwrap_or(&from[0]))));
            // 1 while a lane is on its way, 0 from its last step on.
            let mut moving = V::all(1.0);
            for _ in 0..MOST_STEPS {
                let places: Places<V> = places(curve, &sigma.lanes());
                let [dx, dy] = [point[0] - places.position[0], point[1] - places.position[1]];
                let slope = dx * places.first[0] + dy * places.first[1];
                let newton = V::all(1.0) - (dx * places.second[0] + dy * places.second[1]);
                let step = (slope / newton.max(V::all(0.2))).within(longest) * moving;
                sigma = sigma + step;
                moving = V::choose(step.abs(), V::all(LAST_STEP), V::zero(), moving);
                if moving.lanes().0.iter().all(|moving| *moving == 0.0) {
                    break;
                }
            }
            let places: Places<V> = places(curve, &sigma.lanes());
            let ([px, py], [tx, ty]) = (places.position, places.first);
            let outside = ((point[0] - px) * ty - (point[1] - py) * tx).lanes().0;
            let (sigma, px, py) = (sigma.lanes().0, px.lanes().0, py.lanes().0);
            let (tx, ty) = (tx.lanes().0, ty.lanes().0);
            for lane in 0..points.len() {
                let speed = tx[lane].hypot(ty[lane]);
                let normal = C::new(ty[lane] / speed, -tx[lane] / speed);
                feet.push(Foot { sigma: sigma[lane], position: C::new(px[lane], py[lane]), normal, distance: outside[lane] / speed });
            }
        }
    }
}
