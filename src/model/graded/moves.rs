//! How every field moves with the coefficients: tangents, ring by ring, and of the fall by every coefficient.

use super::grid::Grid;
use super::local::OWN;
use super::shape::{Shape, back, forth, read_plan, sources, write_plan};
use crate::numerics::lanes::Lanes;
use crate::numerics::lanes::product::{Rows, product};
use crate::vectorized;

/// Sources whose plan is needed for each harmonic.
const SOURCES: usize = 4;

/// Tangents of the own fields by a_k and by its first derivative. By its second one h_ℓℓ moves as h_ℓ does by the first, and nothing else does.
pub(super) type Moves = [[Lanes; OWN]; 2];

/// Moves at all points, harmonic by harmonic; and by each coefficient c_σ at all points, then c_σσ.
pub(super) fn moves(grid: &Grid, shape: &Shape) -> (Vec<Moves>, Vec<Lanes>) {
    let (harmonics, size, rows) = (grid.harmonics, grid.size(), 2 * grid.nodes);
    let mut fields = vec![Lanes::ZERO; SOURCES * harmonics * 2 * size];
    swings(grid, shape, &mut fields);
    let mut plan = vec![Lanes::ZERO; fields.len()];
    product(Rows { numbers: &grid.around, stride: rows, inner: rows }, &fields, SOURCES * harmonics * grid.blocks, &mut plan);
    let mut moves = vec![[[Lanes::ZERO; OWN]; 2]; harmonics * size];
    let mut falls = vec![Lanes::ZERO; harmonics * grid.modes * 2 * size];
    tangents(grid, shape, &plan, &mut moves, &mut falls);
    (moves, falls)
}

vectorized! {
    /// How the sources of h_ℓ and h_ℓℓ swing with a_k and its derivatives: first by a_k, both by the highest derivative in them, second by a_k, second by a_k′.
    fn swings<V>(grid: &Grid, shape: &Shape, out: &mut [Lanes]) -> () {
        let (harmonics, blocks) = (grid.harmonics, grid.blocks);
        for n in 0..grid.nodes {
            for block in 0..blocks {
                let point = &shape.points[n * blocks + block];
                let (turn, ring) = ((V::of(&point.cos), V::of(&point.sin)), V::of(&grid.bands[block].ring));
                let psi_l = V::of(&point.psi_l);
                let [(in1, on1), (in2, on2)] = sources(psi_l, V::of(&point.psi_ll), ring, grid.growth);
                let swings = [
                    forth((-on1, in1), turn),
                    (-(ring * turn.1), ring * turn.0),
                    forth((-on2, in2), turn),
                    forth((psi_l * ring * -2.0, V::all(2.0 * grid.growth)), turn),
                ];
                for (k, [sine, _]) in grid.waves[n * harmonics..][..harmonics].iter().enumerate() {
                    for (s, (x, y)) in swings.iter().enumerate() {
                        let (own, columns) = ((*x * *sine, *y * *sine), SOURCES * harmonics);
                        write_plan(out, own, grid, columns, (n, SOURCES * k + s, block));
                    }
                }
            }
        }
    }
}

vectorized! {
    /// Tangents of the own fields by the directions, and of c_σ and c_σσ by the coefficients.
    fn tangents<V>(grid: &Grid, shape: &Shape, plan: &[Lanes], moves: &mut [Moves], falls: &mut [Lanes]) -> () {
        let (harmonics, modes, blocks, size, b) = (grid.harmonics, grid.modes, grid.blocks, grid.size(), grid.growth);
        for n in 0..grid.nodes {
            for block in 0..blocks {
                let i = n * blocks + block;
                let (point, ring) = (&shape.points[i], V::of(&grid.bands[block].ring));
                let turn = (V::of(&point.cos), V::of(&point.sin));
                let (x, y, x2, y2) = (V::of(&point.x), V::of(&point.y), V::of(&point.x2), V::of(&point.y2));
                let (inverse, cs, css) = (V::of(&point.inverse), V::of(&point.cs), V::of(&point.css));
                let (t, a) = (V::of(&point.t), -(V::of(&point.psi_l) * ring));
                let (vx, vy) = (-(t.mul_add(V::all(b), V::of(&point.psi_sl) * ring)), t * a);
                for (k, [sine, slope]) in grid.waves[n * harmonics..][..harmonics].iter().enumerate() {
                    let (sine, slope) = (V::all(*sine), V::all(*slope));
                    let (mut by_plan, columns) = ([(V::zero(), V::zero()); SOURCES], SOURCES * harmonics);
                    for (s, by) in by_plan.iter_mut().enumerate() {
                        *by = back(read_plan(plan, grid, columns, (n, SOURCES * k + s, block)), turn);
                    }
                    let [(x0, y0), (x1, y1), (x20, y20), (x21, y21)] = by_plan;
                    // The frame turns with a_k.
                    let (x0, y0) = (y.mul_add(sine, x0), x.neg_mul_add(sine, y0));
                    let (x20, y20) = (y2.mul_add(sine, x20), x2.neg_mul_add(sine, y20));
                    let a1 = -(ring * sine);
                    let (vx0, vx1, vy0, vy1) = (slope * -b, -(slope * ring), a * slope, t * a1);
                    let c0 = -(x.mul_add(x0, y * y0) * inverse);
                    let c1 = -(x.mul_add(x1, y * y1) * inverse);
                    let cs0 = -(x0.mul_add(a, y0.mul_add(V::all(b), cs * c0)) * inverse);
                    let cs1 = -(x1.mul_add(a, x.mul_add(a1, y1.mul_add(V::all(b), cs * c1))) * inverse);
                    let half0 = x0.mul_add(vx, x.mul_add(vx0, y0.mul_add(vy, y.mul_add(vy0, css * c0))));
                    let half1 = x1.mul_add(vx, x.mul_add(vx1, y1.mul_add(vy, y.mul_add(vy1, css * c1))));
                    let css0 = -((cs * 2.0).mul_add(cs0, half0) * inverse);
                    let css1 = -((cs * 2.0).mul_add(cs1, (a * 2.0).mul_add(a1, half1)) * inverse);
                    let own = &mut moves[k * size + i];
                    own[0] = [x0.lanes(), y0.lanes(), x20.lanes(), y20.lanes(), c0.lanes(), cs0.lanes(), css0.lanes()];
                    own[1] = [x1.lanes(), y1.lanes(), x21.lanes(), y21.lanes(), c1.lanes(), cs1.lanes(), css1.lanes()];
                    for (j, basis) in grid.basis[block * modes..][..modes].iter().enumerate() {
                        let (value, first) = (V::of(&basis[0]), V::of(&basis[1]));
                        let at = (k * modes + j) * 2 * size + i;
                        falls[at] = cs0.mul_add(value, cs1 * first).lanes();
                        falls[at + size] = css0.mul_add(value, css1 * first).lanes();
                    }
                }
            }
        }
    }
}
