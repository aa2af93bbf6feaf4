//! By how much every point of a curve moves with each coefficient of its tangent angle.

use super::harmonics::Harmonics;
use super::{C, Cell, I, TangentCurve};
use crate::numerics::lanes::{Lanes, WIDTH};
use crate::vectorized;

/// Derivatives of the position by the coefficients: cosines, then sines; sines alone where the curve has a symmetry (then its cosines are 0).
pub struct Sensitivities<'a> {
    curve: &'a TangentCurve,
    /// Vectors of eight coefficients at each node.
    width: usize,
    /// Node after node, the end of the period included: real and imaginary part of each.
    position: Vec<[Lanes; 2]>,
}

impl<'a> Sensitivities<'a> {
    pub(super) fn of(curve: &'a TangentCurve) -> Self {
        let harmonics = &curve.harmonics;
        let width = harmonics.order.len() * if harmonics.symmetry == 1 { 2 } else { 1 };
        let mut position = vec![[Lanes::ZERO; 2]; width * (harmonics.nodes + 1)];
        integrate(curve, width, &mut position);
        Sensitivities { curve, width, position }
    }

    pub fn count(&self) -> usize {
        let orders = self.curve.harmonics.orders;
        if self.curve.symmetry() == 1 { 2 * orders } else { orders }
    }

    /// What `see` is told of each coefficient at σ: its index, the derivative of the position and that of the tangent `w'`.
    pub fn at(&self, sigma: f64, mut see: impl FnMut(usize, C, C)) {
        let mut moved = vec![C::new(0.0, 0.0); self.count()];
        self.along(sigma, C::new(1.0, 0.0), |column, value| moved[column].re = value);
        self.along(sigma, I, |column, value| moved[column].im = value);
        let Harmonics { symmetry, orders, .. } = *self.curve.harmonics;
        let tangent = I * self.curve.at(sigma).first;
        for (column, moved) in moved.into_iter().enumerate() {
            let (sin, cos) = (f64::from(symmetry) * (column % orders + 1) as f64 * sigma).sin_cos();
            let harmonic = if symmetry == 1 && column < orders { cos } else { sin };
            see(column, moved, tangent * harmonic);
        }
    }

    /// What `see` is told of each coefficient at σ: its index and the derivative of the position along `direction`, by the same quintics as the curve itself.
    pub fn along(&self, sigma: f64, direction: C, mut see: impl FnMut(usize, f64)) {
        let curve = self.curve;
        let Cell { node, share, period } = curve.cell(sigma);
        let turn = curve.harmonics.turns[period];
        let ends = [node, node + 1].map(|node| End { node, tangent: turn * I * curve.first[node], bend: turn * I * curve.second[node] });
        let seen = Seen { ends, weights: hermite(share, curve.harmonics.step), turn, direction };
        let orders = curve.harmonics.orders;
        let mut eight = Lanes::ZERO;
        for vector in 0..self.width {
            moved_along(self, &seen, vector, &mut eight);
            let (kind, part) = (vector / curve.harmonics.order.len(), vector % curve.harmonics.order.len());
            for (lane, value) in eight.0.iter().enumerate().take(orders - WIDTH * part) {
                see(orders * kind + WIDTH * part + lane, *value);
            }
        }
    }
}

/// Quintic Hermite weights of value, slope and second derivative: here, then there.
fn hermite(x: f64, step: f64) -> [[f64; 3]; 2] {
    let (cube, square) = (x * x * x, step * step);
    let there = cube * (10.0 + x * (-15.0 + 6.0 * x));
    [
        [1.0 - there, step * (x + cube * (-6.0 + x * (8.0 - 3.0 * x))), square * 0.5 * x * x * (1.0 + x * (-3.0 + x * (3.0 - x)))],
        [there, step * cube * (-4.0 + x * (7.0 - 3.0 * x)), square * 0.5 * cube * (1.0 + x * (-2.0 + x))],
    ]
}

/// A node beside the place, and i times its tangent and the derivative of that, turned into the place's period.
struct End {
    node: usize,
    tangent: C,
    bend: C,
}

/// One place of the curve, and the direction in which its motion is seen.
struct Seen {
    ends: [End; 2],
    /// Of position, slope and second derivative at either end.
    weights: [[f64; 3]; 2],
    turn: C,
    direction: C,
}

vectorized! {
    fn moved_along<V>(sensitivities: &Sensitivities<'_>, seen: &Seen, vector: usize, moved: &mut Lanes) -> () {
        let (width, harmonics) = (sensitivities.width, &*sensitivities.curve.harmonics);
        let vectors = harmonics.order.len();
        let both = vectors < width;
        let sine = !both || vectors <= vector;
        let part = if both && sine { vector - vectors } else { vector };
        let order = V::of(&harmonics.order[part]);
        let along = |z: C| z.re * seen.direction.re + z.im * seen.direction.im;
        // Along the direction a turned number is its parts along these.
        let (real, imaginary) = (along(seen.turn), along(seen.turn * I));
        let mut sum = V::zero();
        for (End { node, tangent, bend }, [value, slope, second]) in seen.ends.iter().zip(seen.weights) {
            let [re, im] = &sensitivities.position[width * node + vector];
            let (cosines, sines) = harmonics.at(*node);
            let (cos, sin) = (V::of(&cosines[part]), V::of(&sines[part]));
            let (harmonic, steeper) = if sine { (sin, order * cos) } else { (cos, order * -sin) };
            sum = sum + V::of(re) * (value * real) + V::of(im) * (value * imaginary);
            sum = sum + harmonic * (slope * along(*tangent) + second * along(*bend)) + steeper * (second * along(*tangent));
        }
        *moved = sum.lanes();
    }
}

vectorized! {
    /// Positions at all nodes by the two-point rule that is exact for quintics, about the centre: of symmetry, where there is one, else of the length.
    fn integrate<V>(curve: &TangentCurve, width: usize, position: &mut [[Lanes; 2]]) -> () {
        let harmonics = &*curve.harmonics;
        let (nodes, vectors, h) = (harmonics.nodes, harmonics.order.len(), harmonics.step);
        let both = vectors < width;
        for v in 0..width {
            let sine = !both || vectors <= v;
            let part = if both && sine { v - vectors } else { v };
            let order = V::of(&harmonics.order[part]);
            let (mut re, mut im) = (V::zero(), V::zero());
            let (mut total_re, mut total_im) = (V::zero(), V::zero());
            let mut last = [V::zero(); 6];
            for j in 0..=nodes {
                let (cosines, sines) = harmonics.at(j);
                let (cos, sin) = (V::of(&cosines[part]), V::of(&sines[part]));
                let (value, slope) = if sine { (sin, order * cos) } else { (cos, order * -sin) };
                let bend = -order * order * value;
                let (f, f1, f2) = (curve.first[j], curve.second[j], curve.third[j]);
                // The change of the tangent and its two derivatives, each turned by i.
                let next = [
                    value * -f.im,
                    value * f.re,
                    -(slope * f.im + value * f1.im),
                    slope * f.re + value * f1.re,
                    -(bend * f.im + slope * 2.0 * f1.im + value * f2.im),
                    bend * f.re + slope * 2.0 * f1.re + value * f2.re,
                ];
                if 0 < j {
                    let (ends, slopes, bends) = (h / 2.0, h * h / 10.0, h * h * h / 120.0);
                    re = re + ((last[0] + next[0]) * ends + (last[2] - next[2]) * slopes + (last[4] + next[4]) * bends);
                    im = im + ((last[1] + next[1]) * ends + (last[3] - next[3]) * slopes + (last[5] + next[5]) * bends);
                }
                last = next;
                if j < nodes {
                    (total_re, total_im) = (total_re + re, total_im + im);
                }
                position[width * j + v] = [re.lanes(), im.lanes()];
            }
            let (shift_re, shift_im) = if harmonics.symmetry == 1 {
                (-total_re / V::all(nodes as f64), -total_im / V::all(nodes as f64))
            } else {
                let (turned, square) = (harmonics.turn() - 1.0, V::all((harmonics.turn() - 1.0).norm_sqr()));
                ((re * turned.re + im * turned.im) / square, (im * turned.re - re * turned.im) / square)
            };
            for j in 0..=nodes {
                let [re, im] = &mut position[width * j + v];
                (*re, *im) = ((V::of(re) + shift_re).lanes(), (V::of(im) + shift_im).lanes());
            }
        }
    }
}
