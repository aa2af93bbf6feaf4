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

    /// Where a coefficient is found: vector and lane.
    fn place(&self, column: usize) -> (usize, usize) {
        let orders = self.curve.harmonics.orders;
        let (first, k) = if column < orders { (0, column) } else { (self.curve.harmonics.order.len(), column - orders) };
        (first + k / WIDTH, k % WIDTH)
    }

    /// What `see` is told of each coefficient at σ: its index, the derivative of the position and that of the tangent `w'`.
    pub fn at(&self, sigma: f64, mut see: impl FnMut(usize, C, C)) {
        let curve = self.curve;
        let Cell { node, share: x, period } = curve.cell(sigma);
        let turn = curve.harmonics.turns[period];
        let [a, b, c, d] = hermite(x, curve.harmonics.step);
        let (f, g) = (turn * I * curve.first[node], turn * I * curve.first[node + 1]);
        let middle = turn * I * (curve.first[node] * (1.0 - x) + curve.first[node + 1] * x);
        for column in 0..self.count() {
            let (vector, lane) = self.place(column);
            let harmonic = |j: usize| basis(&curve.harmonics, self.width, j, vector).0[lane];
            let position = |j: usize| {
                let [re, im] = &self.position[self.width * j + vector];
                C::new(re.0[lane], im.0[lane])
            };
            let (here, there) = (harmonic(node), harmonic(node + 1));
            let moved = turn * (position(node) * a + position(node + 1) * b) + f * (here * c) + g * (there * d);
            see(column, moved, middle * (here * (1.0 - x) + there * x));
        }
    }

    /// What `see` is told of each coefficient at σ: its index and the derivative of the position along `direction`.
    pub fn along(&self, sigma: f64, direction: C, mut see: impl FnMut(usize, f64)) {
        let curve = self.curve;
        let Cell { node, share, period } = curve.cell(sigma);
        let turn = curve.harmonics.turns[period];
        let tangents = [turn * I * curve.first[node], turn * I * curve.first[node + 1]];
        let seen = Seen { node, weights: hermite(share, curve.harmonics.step), turn, tangents, direction };
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

/// Cubic Hermite weights of both values, then of both slopes.
fn hermite(x: f64, step: f64) -> [f64; 4] {
    let there = x * x * (3.0 - 2.0 * x);
    [1.0 - there, there, x * (1.0 - x) * (1.0 - x) * step, x * x * (x - 1.0) * step]
}

/// Eight harmonics at node j: cosines before sines where there are both.
#[inline(always)]
fn basis(harmonics: &Harmonics, width: usize, j: usize, vector: usize) -> &Lanes {
    let (cosines, sines) = harmonics.at(j);
    let both = harmonics.order.len() < width;
    if both && vector < cosines.len() { &cosines[vector] } else { &sines[if both { vector - cosines.len() } else { vector }] }
}

/// One place of the curve, and the direction in which its motion is seen.
struct Seen {
    node: usize,
    /// Of position here and there, of slope here and there.
    weights: [f64; 4],
    turn: C,
    /// i times the tangent, here and there.
    tangents: [C; 2],
    direction: C,
}

vectorized! {
    fn moved_along<V>(sensitivities: &Sensitivities<'_>, seen: &Seen, vector: usize, moved: &mut Lanes) -> () {
        let Seen { node, weights: [a, b, c, d], turn, tangents: [f, g], direction } = seen;
        let width = sensitivities.width;
        let [re, im] = &sensitivities.position[width * node + vector];
        let [next_re, next_im] = &sensitivities.position[width * (node + 1) + vector];
        let (re, im) = (V::of(re) * *a + V::of(next_re) * *b, V::of(im) * *a + V::of(next_im) * *b);
        let harmonics = &sensitivities.curve.harmonics;
        let here = V::of(basis(harmonics, width, *node, vector)) * *c;
        let there = V::of(basis(harmonics, width, node + 1, vector)) * *d;
        let (re, im) = (re * turn.re - im * turn.im, im * turn.re + re * turn.im);
        let (re, im) = (re + here * f.re + there * g.re, im + here * f.im + there * g.im);
        *moved = (re * direction.re + im * direction.im).lanes();
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
