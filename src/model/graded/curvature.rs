//! The Hessian of the energy: tangents of every field by the coefficients, weighed with the second derivatives of every local map.
//!
//! `H = Σ_maps Σ_points Tᵀ (λ·∇²F) T`, T the derivatives of a map's inputs and λ the adjoints of its outputs. Around one ring everything depends on its
//! own coefficients a_k and their derivatives by ℓ alone (three *directions* for each k); only z_σ and z_σσ, integrals along the cloth, know the other
//! rings, and have tangents by the α_kj themselves.

use super::Setup;
use super::density::{E, E2, F, F2, Forms, G2, Site};
use super::force::{Force, slopes};
use super::grid::Grid;
use super::shape::{Shape, back, forth, read_plan, sources, write_plan};
use crate::numerics::lanes::product::{Rows, inner_products, product};
use crate::numerics::lanes::{Lanes, Vector, numbers};
use crate::vectorized;

/// Fields by their place in tangents and second derivatives: those that a ring's directions move in their own way …
const X: usize = 0;
const Y: usize = 1;
const X2: usize = 2;
const Y2: usize = 3;
const C: usize = 4;
const CS: usize = 5;
const CSS: usize = 6;
const OWN: usize = 7;
/// … 1 + ψ_σ and −Rψ_ℓ, and the two that come from all rings.
const T: usize = 7;
const A: usize = 8;
const P: usize = 9;
const R: usize = 10;
const ALL: usize = 11;

/// Sources whose plan is needed for each harmonic.
const SOURCES: usize = 4;

/// Tangents of the own fields by a_k and by its first derivative. By its second one h_ℓℓ moves as h_ℓ does by the first, and nothing else does.
type Moves = [[Lanes; OWN]; 2];

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
    let (harmonics, size, rows) = (grid.harmonics, grid.size(), 2 * grid.nodes);
    let unknowns = harmonics * grid.modes;
    let mut fields = vec![Lanes::ZERO; SOURCES * harmonics * 2 * size];
    swings(grid, shape, &mut fields);
    let mut plan = vec![Lanes::ZERO; fields.len()];
    product(Rows { numbers: &grid.around, stride: rows, inner: rows }, &fields, SOURCES * harmonics * grid.blocks, &mut plan);
    let mut moves = vec![[[Lanes::ZERO; OWN]; 2]; harmonics * size];
    // By each coefficient: c_σ at all points, then c_σσ.
    let mut falls = vec![Lanes::ZERO; unknowns * 2 * size];
    tangents(grid, shape, &plan, &mut moves, &mut falls);
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
        let mut columns: Vec<[Column; 3]> = vec![[[Lanes::ZERO; 13]; 3]; harmonics];
        for block in 0..blocks {
            let band = &grid.bands[block];
            for n in 0..grid.nodes {
                let i = n * blocks + block;
                let (point, force) = (&shape.points[i], &forces[i]);
                let site = Site::<V>::of(point, shape.at(i), band, grid.growth);
                let w = local(&site, force, V::of(&band.cloth) * (0.5 * grid.weights[n]), setup);
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

/// Second derivatives of density and fall by the fields; symmetric, only `[i][j]` with i ≤ j is filled.
#[inline(always)]
fn local<V: Vector>(s: &Site<V>, force: &Force, cloth: V, setup: &Setup) -> [[V; ALL]; ALL] {
    let mut w = [[V::zero(); ALL]; ALL];
    let forms = Forms::of(s);
    let slopes = slopes(&forms, cloth, setup);
    let mut bent = [[V::zero(); 5]; 5];
    if setup.rigidity != 0.0 {
        bent = forms.bending_curvatures(cloth * setup.rigidity);
    }
    if setup.shear != 0.0 {
        let [ee, ef, ff] = forms.shear_curvatures(cloth * setup.shear);
        bent[E][E] = bent[E][E] + ee;
        (bent[E][F], bent[F][E]) = (bent[E][F] + ef, bent[F][E] + ef);
        bent[F][F] = bent[F][F] + ff;
    }
    let [n0, n1, n2] = forms.normal;
    let (ring, over) = (s.ring, s.ring * s.inverse);
    let dot = s.x.mul_add(s.x2, s.y * s.y2);
    // Fields that enter one form only: their derivative of it.
    let single = [
        (X2, G2, (over * s.x).neg_mul_add(s.x, n0)),
        (Y2, G2, (over * s.x).neg_mul_add(s.y, n1)),
        (CS, F2, -n2),
        (T, E2, -(n0 * ring)),
        (A, F2, n0),
        (R, E2, n2),
    ];
    // Fields that enter several: derivatives of the forms.
    let zero = V::zero();
    let bent_x = s.p.mul_sub(s.y2, over * s.x.mul_add(s.x2, dot));
    let bent_y = -(s.p.mul_add(s.x2, over * s.x * s.y2));
    let bent_c = (over * s.x * s.inverse).mul_sub(dot, s.x2 * ring);
    let bent_p = s.x.mul_sub(s.y2, s.y * s.x2);
    let several = [
        (X, [zero, zero, -(s.r * ring), s.growth.mul_add(s.p, s.cs * ring), bent_x]),
        (Y, [zero, ring, s.t * ring * s.p, -(s.a * s.p), bent_y]),
        (C, [zero, -s.p, s.t * ring * ring, -(s.a * ring), bent_c]),
        (P, [s.p * 2.0, -s.c, s.t * ring * s.y, s.growth.mul_sub(s.x, s.a * s.y), bent_p]),
    ];
    for (i, (field, own)) in several.iter().enumerate() {
        let mut by = [zero; 5];
        for to in 0..5 {
            by[to] = own[F] * bent[to][F];
            for from in [E2, F2, G2] {
                by[to] = own[from].mul_add(bent[to][from], by[to]);
            }
            if *field == P {
                by[to] = own[E].mul_add(bent[to][E], by[to]);
            }
        }
        for (other, theirs) in &several[i..] {
            let mut sum = theirs[F] * by[F];
            for form in [E2, F2, G2] {
                sum = theirs[form].mul_add(by[form], sum);
            }
            if *other == P {
                sum = theirs[E].mul_add(by[E], sum);
            }
            add(&mut w, *field, *other, sum);
        }
        for (other, form, theirs) in &single {
            add(&mut w, *field, *other, *theirs * by[*form]);
        }
    }
    for (i, (field, form, own)) in single.iter().enumerate() {
        for (other, to, theirs) in &single[i..] {
            add(&mut w, *field, *other, *own * *theirs * bent[*form][*to]);
        }
    }
    // Curvature of the forms themselves.
    let [e, f, e2, f2, g2] = [slopes[E], slopes[F], slopes[E2], slopes[F2], slopes[G2]];
    let (along, lever) = (over * g2, over * s.inverse * g2);
    add(&mut w, P, P, e * 2.0);
    add(&mut w, C, P, -f);
    add(&mut w, C, T, ring * ring * e2);
    add(&mut w, T, P, ring * s.y * e2);
    add(&mut w, Y, T, ring * s.p * e2);
    add(&mut w, Y, P, (s.t * ring).mul_sub(e2, s.a.mul_add(f2, s.x2 * g2)));
    add(&mut w, X, R, -(ring * e2));
    add(&mut w, C, A, -(ring * f2));
    add(&mut w, A, P, -(s.y * f2));
    add(&mut w, Y, A, -(s.p * f2));
    add(&mut w, X, P, s.growth.mul_add(f2, s.y2 * g2));
    add(&mut w, X, CS, ring * f2);
    add(&mut w, X2, C, (lever * s.x).mul_sub(s.x, ring * g2));
    add(&mut w, X2, P, -(s.y * g2));
    add(&mut w, Y, X2, -(s.p * g2));
    add(&mut w, Y2, P, s.x * g2);
    add(&mut w, X, Y2, s.p.mul_sub(g2, along * s.y));
    add(&mut w, X, X, along * s.x2 * -2.0);
    add(&mut w, X, Y, -(along * s.y2));
    add(&mut w, X, X2, along * s.x * -2.0);
    add(&mut w, Y, Y2, -(along * s.x));
    add(&mut w, X, C, lever * s.x.mul_add(s.x2, dot));
    add(&mut w, Y, C, lever * s.x * s.y2);
    add(&mut w, Y2, C, lever * s.x * s.y);
    add(&mut w, C, C, lever * s.inverse * s.x * dot * -2.0);
    // And of the fall.
    let [itself, first, second] = [V::of(&force.fall[0]), V::of(&force.fall[1]), V::of(&force.fall[2])];
    for field in [X, Y, C] {
        add(&mut w, field, field, -itself);
    }
    add(&mut w, C, CS, -first);
    add(&mut w, C, CSS, -second);
    add(&mut w, CS, CS, second * -2.0);
    add(&mut w, X, A, -first);
    add(&mut w, A, A, second * -2.0);
    add(&mut w, X, T, second * s.growth);
    add(&mut w, Y, T, -(second * s.a));
    add(&mut w, Y, A, -(second * s.t));
    add(&mut w, T, A, -(second * s.y));
    w
}

#[inline(always)]
fn add<V: Vector>(w: &mut [[V; ALL]; ALL], i: usize, j: usize, more: V) {
    let (i, j) = if i < j { (i, j) } else { (j, i) };
    w[i][j] = w[i][j] + more;
}

#[inline(always)]
fn at<V: Vector>(w: &[[V; ALL]; ALL], i: usize, j: usize) -> V {
    if i < j { w[i][j] } else { w[j][i] }
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
