//! The gradient of the energy: backward through density, height, fall and plan, by hand.

use super::Setup;
use super::density::{E, E2, F, F2, Forms, G2, Site};
use super::grid::Grid;
use super::shape::{Shape, back, forth, read_plan, sources, write_plan};
use crate::numerics::lanes::product::{Rows, product};
use crate::numerics::lanes::{Lanes, Vector, numbers};
use crate::vectorized;

/// Adjoints of the local fields at eight points: derivatives of the energy by each.
#[derive(Debug, Clone)]
pub(super) struct Force {
    pub x: Lanes,
    pub y: Lanes,
    pub x2: Lanes,
    pub y2: Lanes,
    /// Of c, c_σ and c_σσ, over c.
    pub fall: [Lanes; 3],
    t: Lanes,
    a: Lanes,
    psi: Lanes,
    psi_sl: Lanes,
    /// Second derivatives that the sources of h_ℓ and h_ℓℓ and the turning frame contribute: by ψ twice, ψ and ψ_ℓ, ψ and ψ_ℓℓ, ψ_ℓ twice.
    pub turn: [Lanes; 4],
}

impl Force {
    const ZERO: Force = Force {
        x: Lanes::ZERO,
        y: Lanes::ZERO,
        x2: Lanes::ZERO,
        y2: Lanes::ZERO,
        fall: [Lanes::ZERO; 3],
        t: Lanes::ZERO,
        a: Lanes::ZERO,
        psi: Lanes::ZERO,
        psi_sl: Lanes::ZERO,
        turn: [Lanes::ZERO; 4],
    };
}

/// Forces at all points, and the gradient by the coefficients.
pub(super) fn forces(grid: &Grid, setup: &Setup, shape: &Shape) -> (Vec<Force>, Vec<f64>) {
    let (size, rows) = (grid.size(), 2 * grid.nodes);
    let mut forces = vec![Force::ZERO; size];
    let mut fields = vec![Lanes::ZERO; 4 * size];
    let mut image = vec![Lanes::ZERO; 4 * size];
    density(grid, setup, shape, &mut forces, &mut fields[..2 * size]);
    let heights = Rows { numbers: numbers(&fields[..2 * size]), stride: grid.stride(), inner: grid.slices };
    product(heights, &grid.along_back, grid.blocks, &mut image[..2 * size]);
    fall(grid, shape, &image, &mut forces, &mut fields);
    product(Rows { numbers: &grid.around_back, stride: rows, inner: rows }, &fields, 2 * grid.blocks, &mut image);
    let gradient = angles(grid, shape, &image, &mut forces);
    (forces, gradient)
}

vectorized! {
    /// By the density; the adjoints of z_σ and z_σσ into `heights`.
    fn density<V>(grid: &Grid, setup: &Setup, shape: &Shape, forces: &mut [Force], heights: &mut [Lanes]) -> () {
        let size = forces.len();
        for n in 0..grid.nodes {
            for block in 0..grid.blocks {
                let i = n * grid.blocks + block;
                let (band, weight) = (&grid.bands[block], grid.weights[n]);
                let s = Site::<V>::of(&shape.points[i], shape.at(i), band, grid.growth);
                let forms = Forms::of(&s);
                let slopes = slopes(&forms, V::of(&band.cloth) * (0.5 * weight), setup);
                let [e, f, e2, f2, g2] = [slopes[E], slopes[F], slopes[E2], slopes[F2], slopes[G2]];
                let [n0, n1, n2] = forms.normal;
                let normal = [
                    s.a.mul_add(f2, s.x2.mul_sub(g2, s.t * s.ring * e2)),
                    s.y2.mul_add(g2, f2 * s.growth),
                    s.r.mul_sub(e2, s.cs.mul_add(f2, forms.cl * g2)),
                ];
                let scaled = -(s.inverse * n2 * g2);
                let force = &mut forces[i];
                force.t = (-(n0 * e2 * s.ring)).lanes();
                force.a = (n0 * f2).lanes();
                force.x = s.x2.neg_mul_add(scaled, s.p.mul_sub(normal[1], normal[2] * s.ring)).lanes();
                force.y = s.y2.neg_mul_add(scaled, f.mul_sub(s.ring, s.p * normal[0])).lanes();
                force.x2 = n0.mul_sub(g2, s.x * scaled).lanes();
                force.y2 = n1.mul_sub(g2, s.y * scaled).lanes();
                let c = normal[0].mul_add(s.ring, s.p.mul_add(f, forms.cl * scaled));
                force.fall[0] = (-(c + V::of(&band.hanging) * (setup.weight * weight))).lanes();
                force.fall[1] = (-(n2 * f2)).lanes();
                heights[i] = s.x.mul_sub(normal[1], s.y.mul_add(normal[0], s.c.mul_sub(f, s.p * e * 2.0))).lanes();
                heights[size + i] = (n2 * e2).lanes();
            }
        }
    }
}

/// Derivatives of bending and shear by the forms; `cloth` is half the area of cloth, m².
#[inline(always)]
pub(super) fn slopes<V: Vector>(forms: &Forms<V>, cloth: V, setup: &Setup) -> [V; 5] {
    let mut slopes = [V::zero(); 5];
    if setup.rigidity != 0.0 {
        slopes = forms.bending_slopes(cloth * setup.rigidity);
    }
    if setup.shear != 0.0 {
        let [e, f] = forms.shear_slopes(cloth * setup.shear);
        (slopes[E], slopes[F]) = (slopes[E] + e, slopes[F] + f);
    }
    slopes
}

vectorized! {
    /// By the fall, with the adjoints of c_σ and c_σσ that `along` brings; those of h_ℓ and h_ℓℓ into `plan`.
    fn fall<V>(grid: &Grid, shape: &Shape, along: &[Lanes], forces: &mut [Force], plan: &mut [Lanes]) -> () {
        let (blocks, size, b) = (grid.blocks, forces.len(), V::all(grid.growth));
        for n in 0..grid.nodes {
            for block in 0..blocks {
                let i = n * blocks + block;
                let (point, force) = (&shape.points[i], &mut forces[i]);
                let ring = V::of(&grid.bands[block].ring);
                let (x, y, inverse) = (V::of(&point.x), V::of(&point.y), V::of(&point.inverse));
                let (cs, css, t, a) = (V::of(&point.cs), V::of(&point.css), V::of(&point.t), -(V::of(&point.psi_l) * ring));
                let (vx, vy) = (-(t.mul_add(b, V::of(&point.psi_sl) * ring)), t * a);
                let second = inverse * V::of(&along[size + i]);
                let first = inverse * (cs * -2.0).mul_add(second, V::of(&force.fall[1]) + V::of(&along[i]));
                let itself = inverse * css.neg_mul_add(second, cs.neg_mul_add(first, V::of(&force.fall[0])));
                let (vx_back, vy_back) = (-(x * second), -(y * second));
                let a_back = x.neg_mul_add(first, t.mul_add(vy_back, (a * -2.0).mul_add(second, V::of(&force.a))));
                let x_back = x.neg_mul_add(itself, a.neg_mul_add(first, vx.neg_mul_add(second, V::of(&force.x))));
                let y_back = y.neg_mul_add(itself, b.neg_mul_add(first, vy.neg_mul_add(second, V::of(&force.y))));
                let t_back = a.mul_add(vy_back, b.neg_mul_add(vx_back, V::of(&force.t)));
                let (x2, y2, x2_back, y2_back) = (V::of(&point.x2), V::of(&point.y2), V::of(&force.x2), V::of(&force.y2));
                force.psi = x_back.mul_add(y, x2_back.mul_sub(y2, y_back.mul_add(x, y2_back * x2))).lanes();
                (force.x, force.y) = (x_back.lanes(), y_back.lanes());
                (force.t, force.a) = (t_back.lanes(), a_back.lanes());
                force.psi_sl = (-(vx_back * ring)).lanes();
                force.fall = [itself.lanes(), first.lanes(), second.lanes()];
                let turn = (V::of(&point.cos), V::of(&point.sin));
                for (column, own) in [(x_back, y_back), (x2_back, y2_back)].into_iter().enumerate() {
                    write_plan(plan, forth(own, turn), grid, 2, (n, column, block));
                }
            }
        }
    }
}

vectorized! {
    /// By the sources, with their adjoints that `plan` brings, to the coefficients.
    fn angles<V>(grid: &Grid, shape: &Shape, plan: &[Lanes], forces: &mut [Force]) -> Vec<f64> {
        let (harmonics, modes, blocks, b) = (grid.harmonics, grid.modes, grid.blocks, grid.growth);
        let mut gradient = vec![0.0; harmonics * modes];
        let mut rings = vec![[Lanes::ZERO; 3]; harmonics];
        for block in 0..blocks {
            rings.fill([Lanes::ZERO; 3]);
            let ring = V::of(&grid.bands[block].ring);
            for n in 0..grid.nodes {
                let i = n * blocks + block;
                let (point, force) = (&shape.points[i], &mut forces[i]);
                let turn = (V::of(&point.cos), V::of(&point.sin));
                // Adjoints in the frame of the sources.
                let (u1, v1) = back(read_plan(plan, grid, 2, (n, 0, block)), turn);
                let (u2, v2) = back(read_plan(plan, grid, 2, (n, 1, block)), turn);
                let psi_l = V::of(&point.psi_l);
                let [(in1, on1), (in2, on2)] = sources(psi_l, V::of(&point.psi_ll), ring, b);
                let psi = V::of(&force.psi) + (v1.mul_sub(in1, u1 * on1) + v2.mul_sub(in2, u2 * on2));
                let (t, psi_sl) = (V::of(&force.t), V::of(&force.psi_sl));
                let turned = psi_l * ring;
                let by_l = ring.mul_add(v1 - V::of(&force.a), (v2 * b - turned * u2) * 2.0);
                let by_ll = v2 * ring;
                let frame = V::of(&force.x).mul_add(V::of(&point.x), V::of(&force.y) * V::of(&point.y));
                let frame = V::of(&force.x2).mul_add(V::of(&point.x2), V::of(&force.y2).mul_add(V::of(&point.y2), frame));
                force.turn = [
                    (frame - u1.mul_add(in1, v1 * on1) - u2.mul_add(in2, v2 * on2)).lanes(),
                    (-(ring.mul_add(u1, (turned * v2 + u2 * b) * 2.0))).lanes(),
                    (-(ring * u2)).lanes(),
                    (ring * u2 * -2.0).lanes(),
                ];
                for (sums, [sine, slope]) in rings.iter_mut().zip(&grid.waves[n * harmonics..][..harmonics]) {
                    let (sine, slope) = (V::all(*sine), V::all(*slope));
                    sums[0] = psi.mul_add(sine, t.mul_add(slope, V::of(&sums[0]))).lanes();
                    sums[1] = by_l.mul_add(sine, psi_sl.mul_add(slope, V::of(&sums[1]))).lanes();
                    sums[2] = by_ll.mul_add(sine, V::of(&sums[2])).lanes();
                }
            }
            for (k, sums) in rings.iter().enumerate() {
                for (j, basis) in grid.basis[block * modes..][..modes].iter().enumerate() {
                    let mut sum = V::zero();
                    for d in 0..3 {
                        sum = V::of(&sums[d]).mul_add(V::of(&basis[d]), sum);
                    }
                    gradient[k * modes + j] += sum.sum();
                }
            }
        }
        gradient
    }
}
