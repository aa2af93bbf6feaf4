//! The Hessian of the energy: tangents of every field by the coefficients, weighed with the second derivatives of every local map.
//!
//! `H = Σ_maps Σ_points Tᵀ (λ·∇²F) T`, T the derivatives of a map's inputs and λ the adjoints of its outputs. Around one ring everything depends on its
//! own coefficients a_k and their derivatives by ℓ alone (three *directions* for each k); only z_σ and z_σσ, integrals along the cloth, know the other
//! rings, and have tangents by the α_kj themselves.

use super::Setup;
use super::density::Site;
use super::force::Force;
use super::grid::Grid;
use super::local::{A, ALL, C, CS, CSS, OWN, P, R, T, X, X2, Y, Y2, at, local};
use super::moves::{Moves, moves};
use super::shape::Shape;
use crate::numerics::lanes::product::{Rows, inner_products, product};
use crate::numerics::lanes::{Lanes, Vector, numbers};
use crate::vectorized;

/// A direction's column of the second derivatives: own fields, then ψ, 1 + ψ_σ, −Rψ_ℓ and ψ_σℓ, then z_σ and z_σσ.
type Column = [Lanes; 13];
const BY_PSI: usize = 7;
const BY_T: usize = 8;
const BY_A: usize = 9;
const BY_SL: usize = 10;
const BY_P: usize = 11;
const BY_R: usize = 12;

/// Second derivatives by the coefficients, row by row.
pub(super) fn hessian(grid: &Grid, setup: &Setup, shape: &Shape, forces: &[Force]) -> Vec<f64> {
    let (harmonics, unknowns) = (grid.harmonics, grid.harmonics * grid.modes);
    let (moves, falls) = moves(grid, shape);
    let mut heights = vec![Lanes::ZERO; falls.len()];
    product(Rows { numbers: numbers(&falls), stride: grid.stride(), inner: grid.slices }, &grid.along, grid.blocks, &mut heights);
    let mut weighed = falls;
    let mut rings = vec![[[Lanes::ZERO; 3]; 3]; grid.blocks * harmonics * harmonics];
    weigh(grid, setup, shape, forces, &moves, &heights, &mut rings, &mut weighed);
    let across = inner_products(&heights, &weighed, unknowns);
    let mut out = assemble(grid, &rings);
    for i in 0..unknowns {
        for j in 0..unknowns {
            out[i * unknowns + j] += across[i * unknowns + j] + across[j * unknowns + i];
        }
    }
    out
}

vectorized! {
    /// Second derivatives by the directions of each ring, summed around it, into `rings`; and into `weighed` what the tangents of z_σ and z_σσ have to be
    /// multiplied with, half of what these two do among themselves included.
    #[allow(clippy::too_many_arguments)]
    fn weigh<V>(
        grid: &Grid,
        setup: &Setup,
        shape: &Shape,
        forces: &[Force],
        moves: &[Moves],
        heights: &[Lanes],
        rings: &mut [[[Lanes; 3]; 3]],
        weighed: &mut [Lanes],
    ) -> () {
        let (harmonics, modes, blocks, size) = (grid.harmonics, grid.modes, grid.blocks, grid.size());
        let mut w = [[V::zero(); ALL]; ALL];
        let mut columns: Vec<[Column; 3]> = vec![[[Lanes::ZERO; 13]; 3]; harmonics];
        for block in 0..blocks {
            let band = &grid.bands[block];
            for n in 0..grid.nodes {
                let i = n * blocks + block;
                let (point, force) = (&shape.points[i], &forces[i]);
                let site = Site::<V>::of(point, shape.at(i), band, grid.growth);
                local(&mut w, &site, force, V::of(&band.cloth) * (0.5 * grid.weights[n]), setup);
                let waves = &grid.waves[n * harmonics..][..harmonics];
                for (k, columns) in columns.iter_mut().enumerate() {
                    columns_of(&w, force, &moves[k * size + i], waves[k], site.ring, columns);
                }
                let turn = [V::of(&force.turn[0]), V::of(&force.turn[1]), V::of(&force.turn[2]), V::of(&force.turn[3])];
                for k in 0..harmonics {
                    let (own, wave) = (&moves[k * size + i], waves[k]);
                    for l in k..harmonics {
                        let sum = &mut rings[(block * harmonics + k) * harmonics + l];
                        pair(own, wave, site.ring, &columns[l], turn, waves[l][0], sum);
                    }
                }
                for k in 0..harmonics {
                    let columns = &columns[k];
                    for (j, basis) in grid.basis[block * modes..][..modes].iter().enumerate() {
                        let at = (k * modes + j) * 2 * size + i;
                        let (p, r) = (V::of(&heights[at]), V::of(&heights[at + size]));
                        let mut by_p = w[P][P].mul_add(p, w[P][R] * r) * 0.5;
                        let mut by_r = w[P][R].mul_add(p, w[R][R] * r) * 0.5;
                        for d in 0..3 {
                            by_p = V::of(&columns[d][BY_P]).mul_add(V::of(&basis[d]), by_p);
                            by_r = V::of(&columns[d][BY_R]).mul_add(V::of(&basis[d]), by_r);
                        }
                        (weighed[at], weighed[at + size]) = (by_p.lanes(), by_r.lanes());
                    }
                }
            }
        }
    }
}

/// The second derivatives by every field and one direction, for the three directions of one harmonic.
#[inline(always)]
fn columns_of<V: Vector>(w: &[[V; ALL]; ALL], force: &Force, moves: &Moves, [sine, slope]: [f64; 2], ring: V, out: &mut [Column; 3]) {
    let zero = V::zero();
    let (sine, slope) = (V::all(sine), V::all(slope));
    // What the turning frame contributes, by ψ; and the fall by ψ_σℓ, which moves c_σσ with x.
    let turned = [-V::of(&force.y), V::of(&force.x), -V::of(&force.y2), V::of(&force.x2)];
    let by_sl = V::of(&force.fall[2]) * ring;
    for d in 0..2 {
        let mut own = [zero; OWN];
        for (own, lanes) in own.iter_mut().zip(&moves[d]) {
            *own = V::of(lanes);
        }
        let (t, a) = if d == 0 { (slope, zero) } else { (zero, -(ring * sine)) };
        let mut column = [zero; ALL];
        for to in 0..ALL {
            if to == CSS {
                // Through the fall alone.
                column[CSS] = w[C][CSS] * own[C];
                continue;
            }
            let mut sum = if d == 0 { at(w, to, T) * t } else { at(w, to, A) * a };
            for from in [X, Y, X2, Y2, C, CS] {
                sum = at(w, to, from).mul_add(own[from], sum);
            }
            if to == C {
                sum = w[C][CSS].mul_add(own[CSS], sum);
            }
            column[to] = sum;
        }
        let mut by_psi = zero;
        for from in [X, Y, X2, Y2] {
            by_psi = turned[from].mul_add(own[from], by_psi);
            if d == 0 {
                column[from] = turned[from].mul_add(sine, column[from]);
            }
        }
        if d == 1 {
            column[X] = by_sl.mul_add(slope, column[X]);
        }
        let to = &mut out[d];
        for i in 0..OWN {
            to[i] = column[i].lanes();
        }
        (to[BY_PSI], to[BY_T], to[BY_A]) = (by_psi.lanes(), column[T].lanes(), column[A].lanes());
        to[BY_SL] = (by_sl * own[X]).lanes();
        (to[BY_P], to[BY_R]) = (column[P].lanes(), column[R].lanes());
    }
    // By the second derivative of a_k only h_ℓℓ moves.
    let (x2, y2) = (V::of(&moves[1][X]), V::of(&moves[1][Y]));
    let to = &mut out[2];
    for (i, field) in [(X, X), (Y, Y), (X2, X2), (Y2, Y2), (C, C), (CS, CS), (BY_T, T), (BY_A, A), (BY_P, P), (BY_R, R)] {
        to[i] = at(w, field, X2).mul_add(x2, at(w, field, Y2) * y2).lanes();
    }
    to[BY_PSI] = turned[X2].mul_add(x2, turned[Y2] * y2).lanes();
}

/// Second derivatives by the directions of two harmonics, added to `sum`.
#[inline(always)]
fn pair<V: Vector>(
    moves: &Moves,
    [sine, slope]: [f64; 2],
    ring: V,
    columns: &[Column; 3],
    turn: [V; 4],
    other_sine: f64,
    sum: &mut [[Lanes; 3]; 3],
) {
    let (a, both) = (-(ring * sine), sine * other_sine);
    let (sine, slope) = (V::all(sine), V::all(slope));
    for (d, column) in columns.iter().enumerate() {
        // By ψ, ψ_ℓ and ψ_ℓℓ of the sources.
        let own = [
            turn[d].mul_add(V::all(both), V::of(&sum[0][d])),
            if d < 2 { turn[if d == 0 { 1 } else { 3 }].mul_add(V::all(both), V::of(&sum[1][d])) } else { V::of(&sum[1][d]) },
            if d == 0 { turn[2].mul_add(V::all(both), V::of(&sum[2][d])) } else { V::of(&sum[2][d]) },
        ];
        let mut zeroth = V::of(&column[BY_PSI]).mul_add(sine, own[0]);
        zeroth = V::of(&column[BY_T]).mul_add(slope, zeroth);
        let mut first = V::of(&column[BY_A]).mul_add(a, own[1]);
        first = V::of(&column[BY_SL]).mul_add(slope, first);
        for i in 0..OWN {
            let by = V::of(&column[i]);
            zeroth = by.mul_add(V::of(&moves[0][i]), zeroth);
            first = by.mul_add(V::of(&moves[1][i]), first);
        }
        let mut second = V::of(&column[X2]).mul_add(V::of(&moves[1][X]), own[2]);
        second = V::of(&column[Y2]).mul_add(V::of(&moves[1][Y]), second);
        (sum[0][d], sum[1][d], sum[2][d]) = (zeroth.lanes(), first.lanes(), second.lanes());
    }
}

vectorized! {
    /// From second derivatives by the directions of every ring to those by the coefficients, row by row.
    fn assemble<V>(grid: &Grid, rings: &[[[Lanes; 3]; 3]]) -> Vec<f64> {
        let (harmonics, modes) = (grid.harmonics, grid.modes);
        let unknowns = harmonics * modes;
        let mut out = vec![0.0; unknowns * unknowns];
        for k in 0..harmonics {
            for l in k..harmonics {
                for i in 0..modes {
                    for j in 0..modes {
                        let mut sum = V::zero();
                        for block in 0..grid.blocks {
                            let (own, others) = (&grid.basis[block * modes + i], &grid.basis[block * modes + j]);
                            let by = &rings[(block * harmonics + k) * harmonics + l];
                            for d in 0..3 {
                                let mut inner = V::zero();
                                for e in 0..3 {
                                    inner = V::of(&by[d][e]).mul_add(V::of(&others[e]), inner);
                                }
                                sum = V::of(&own[d]).mul_add(inner, sum);
                            }
                        }
                        let sum = sum.sum();
                        let (row, column) = (k * modes + i, l * modes + j);
                        out[row * unknowns + column] = sum;
                        if k != l {
                            out[column * unknowns + row] = sum;
                        }
                    }
                }
            }
        }
        out
    }
}
