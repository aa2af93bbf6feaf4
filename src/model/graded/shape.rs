//! Where the cloth is: the fields of a graded shell at all points, from its coefficients, and its energy.

use super::Setup;
use super::density::{Forms, Site};
use super::grid::Grid;
use crate::numerics::lanes::product::{Rows, product};
use crate::numerics::lanes::{Lanes, Vector, numbers, sin_cos};
use crate::vectorized;

/// One shape of a shell.
pub(super) struct Shape {
    pub points: Vec<Point>,
    /// z_σ at all points, then z_σσ.
    pub heights: Vec<Lanes>,
}

/// Fields at eight slices of one node.
#[derive(Debug, Clone)]
pub(super) struct Point {
    /// Of ψ.
    pub sin: Lanes,
    pub cos: Lanes,
    pub psi_l: Lanes,
    pub psi_ll: Lanes,
    /// 1 + ψ_σ.
    pub t: Lanes,
    pub psi_sl: Lanes,
    /// h_ℓ and h_ℓℓ in the frame that turns with the ring's tangent.
    pub x: Lanes,
    pub y: Lanes,
    pub x2: Lanes,
    pub y2: Lanes,
    /// −∂z/∂ℓ, and 1 over it.
    pub c: Lanes,
    pub inverse: Lanes,
    /// Derivatives of c by σ.
    pub cs: Lanes,
    pub css: Lanes,
}

impl Point {
    const ZERO: Point = Point {
        sin: Lanes::ZERO,
        cos: Lanes::ZERO,
        psi_l: Lanes::ZERO,
        psi_ll: Lanes::ZERO,
        t: Lanes::ZERO,
        psi_sl: Lanes::ZERO,
        x: Lanes::ZERO,
        y: Lanes::ZERO,
        x2: Lanes::ZERO,
        y2: Lanes::ZERO,
        c: Lanes::ZERO,
        inverse: Lanes::ZERO,
        cs: Lanes::ZERO,
        css: Lanes::ZERO,
    };
}

/// A plane vector at eight points.
pub(super) type Plane<V> = (V, V);

/// Turned by the angle of (cos, sin).
#[inline(always)]
pub(super) fn forth<V: Vector>((x, y): Plane<V>, (cos, sin): (V, V)) -> Plane<V> {
    (x.mul_sub(cos, y * sin), x.mul_add(sin, y * cos))
}

/// Turned by the opposite angle.
#[inline(always)]
pub(super) fn back<V: Vector>((x, y): Plane<V>, (cos, sin): (V, V)) -> Plane<V> {
    (x.mul_add(cos, y * sin), y.mul_sub(cos, x * sin))
}

/// Sources of h_ℓ and h_ℓℓ before they are turned by ψ: `R' + iRψ_ℓ` and `−Rψ_ℓ² + i(2R'ψ_ℓ + Rψ_ℓℓ)`.
#[inline(always)]
pub(super) fn sources<V: Vector>(psi_l: V, psi_ll: V, ring: V, growth: f64) -> [Plane<V>; 2] {
    let turn = psi_l * ring;
    [(V::all(growth), turn), (-(turn * psi_l), psi_l.mul_add(V::all(2.0 * growth), psi_ll * ring))]
}

/// Plane vectors by node, column and block: rows of real parts, then of imaginary ones, as the kernel wants them.
#[inline(always)]
fn spot(grid: &Grid, columns: usize, (n, column, block): (usize, usize, usize)) -> (usize, usize) {
    let real = (n * columns + column) * grid.blocks + block;
    (real, real + grid.nodes * columns * grid.blocks)
}

#[inline(always)]
pub(super) fn read_plan<V: Vector>(plan: &[Lanes], grid: &Grid, columns: usize, place: (usize, usize, usize)) -> Plane<V> {
    let (real, imaginary) = spot(grid, columns, place);
    (V::of(&plan[real]), V::of(&plan[imaginary]))
}

#[inline(always)]
pub(super) fn write_plan<V: Vector>(plan: &mut [Lanes], (x, y): Plane<V>, grid: &Grid, columns: usize, place: (usize, usize, usize)) {
    let (real, imaginary) = spot(grid, columns, place);
    (plan[real], plan[imaginary]) = (x.lanes(), y.lanes());
}

impl Shape {
    /// `alpha` as in [`super::GradedShell`]; `None` where a generatrix would have to be longer than its cloth.
    pub fn of(grid: &Grid, alpha: &[f64]) -> Option<Shape> {
        let (size, rows) = (grid.size(), 2 * grid.nodes);
        let mut points = vec![Point::ZERO; size];
        let mut fields = vec![Lanes::ZERO; 4 * size];
        angles(grid, alpha, &mut points, &mut fields);
        let mut plan = vec![Lanes::ZERO; 4 * size];
        product(Rows { numbers: &grid.around, stride: rows, inner: rows }, &fields, 2 * grid.blocks, &mut plan);
        let falls = &mut fields[..2 * size];
        if !fall(grid, &plan, &mut points, falls) {
            return None;
        }
        let mut heights = vec![Lanes::ZERO; 2 * size];
        product(Rows { numbers: numbers(falls), stride: grid.stride(), inner: grid.slices }, &grid.along, grid.blocks, &mut heights);
        Some(Shape { points, heights })
    }

    /// Gravity, bending and shear, J.
    pub fn energies(&self, grid: &Grid, setup: &Setup) -> [f64; 3] {
        energies(grid, setup, self)
    }

    /// z_σ and z_σσ at point `i`.
    #[inline(always)]
    pub fn at(&self, i: usize) -> [&Lanes; 2] {
        [&self.heights[i], &self.heights[self.points.len() + i]]
    }
}

vectorized! {
    /// ψ and its derivatives at all points, and the sources of h_ℓ and h_ℓℓ: rows (real part of every node, then imaginary), columns by block.
    fn angles<V>(grid: &Grid, alpha: &[f64], points: &mut [Point], sources_of: &mut [Lanes]) -> () {
        let (harmonics, modes, blocks) = (grid.harmonics, grid.modes, grid.blocks);
        let mut rings = vec![[Lanes::ZERO; 3]; harmonics];
        for block in 0..blocks {
            for (k, ring) in rings.iter_mut().enumerate() {
                let mut sums = [V::zero(); 3];
                for (alpha, basis) in alpha[k * modes..][..modes].iter().zip(&grid.basis[block * modes..][..modes]) {
                    let alpha = V::all(*alpha);
                    for d in 0..3 {
                        sums[d] = alpha.mul_add(V::of(&basis[d]), sums[d]);
                    }
                }
                for d in 0..3 {
                    ring[d] = sums[d].lanes();
                }
            }
            let ring = V::of(&grid.bands[block].ring);
            for n in 0..grid.nodes {
                let (mut psi, mut psi_s, mut psi_l, mut psi_sl, mut psi_ll) = (V::zero(), V::zero(), V::zero(), V::zero(), V::zero());
                for (a, [sine, slope]) in rings.iter().zip(&grid.waves[n * harmonics..][..harmonics]) {
                    let (sine, slope) = (V::all(*sine), V::all(*slope));
                    let (a0, a1, a2) = (V::of(&a[0]), V::of(&a[1]), V::of(&a[2]));
                    psi = a0.mul_add(sine, psi);
                    psi_s = a0.mul_add(slope, psi_s);
                    psi_l = a1.mul_add(sine, psi_l);
                    psi_sl = a1.mul_add(slope, psi_sl);
                    psi_ll = a2.mul_add(sine, psi_ll);
                }
                let (sin, cos) = sin_cos(psi);
                let turn = (cos, sin);
                for (column, source) in sources(psi_l, psi_ll, ring, grid.growth).into_iter().enumerate() {
                    write_plan(sources_of, forth(source, turn), grid, 2, (n, column, block));
                }
                let point = &mut points[n * blocks + block];
                (point.sin, point.cos) = (sin.lanes(), cos.lanes());
                (point.psi_l, point.psi_ll, point.psi_sl) = (psi_l.lanes(), psi_ll.lanes(), psi_sl.lanes());
                point.t = (psi_s + 1.0).lanes();
            }
        }
    }
}

vectorized! {
    /// How the cloth falls, from h_ℓ and h_ℓℓ; c_σ at all points, then c_σσ, into `falls`. Whether every generatrix is long enough.
    fn fall<V>(grid: &Grid, plan: &[Lanes], points: &mut [Point], falls: &mut [Lanes]) -> bool {
        let (blocks, size, b) = (grid.blocks, points.len(), V::all(grid.growth));
        let mut short = V::zero();
        for n in 0..grid.nodes {
            for block in 0..blocks {
                let i = n * blocks + block;
                let point = &mut points[i];
                let turn = (V::of(&point.cos), V::of(&point.sin));
                let (x, y) = back(read_plan(plan, grid, 2, (n, 0, block)), turn);
                let (x2, y2) = back(read_plan(plan, grid, 2, (n, 1, block)), turn);
                let square = x.neg_mul_add(x, y.neg_mul_add(y, V::all(1.0)));
                // Not below zero, and no NaN.
                short = short + V::choose(V::zero(), square, V::zero(), V::all(1.0));
                let c = square.sqrt();
                let inverse = V::all(1.0) / c;
                // X_σℓ = (a, R', −c_σ).
                let (ring, t) = (V::of(&grid.bands[block].ring), V::of(&point.t));
                let a = -(V::of(&point.psi_l) * ring);
                let (vx, vy) = (-(t.mul_add(b, V::of(&point.psi_sl) * ring)), t * a);
                let cs = -(x.mul_add(a, y * b) * inverse);
                let css = -(a.mul_add(a, x.mul_add(vx, y.mul_add(vy, cs.mul_add(cs, b * b)))) * inverse);
                (point.x, point.y, point.x2, point.y2) = (x.lanes(), y.lanes(), x2.lanes(), y2.lanes());
                (point.c, point.inverse) = (c.lanes(), inverse.lanes());
                (point.cs, point.css) = (cs.lanes(), css.lanes());
                (falls[i], falls[size + i]) = (point.cs, point.css);
            }
        }
        short.sum() == 0.0
    }
}

vectorized! {
    fn energies<V>(grid: &Grid, setup: &Setup, shape: &Shape) -> [f64; 3] {
        let mut sums = [V::zero(); 3];
        for n in 0..grid.nodes {
            for block in 0..grid.blocks {
                let i = n * grid.blocks + block;
                let (point, band, weight) = (&shape.points[i], &grid.bands[block], grid.weights[n]);
                let forms = Forms::of(&Site::<V>::of(point, shape.at(i), band, grid.growth));
                let (x, y) = (V::of(&point.x), V::of(&point.y));
                // 1 − c without the cancellation.
                let rise = x.mul_add(x, y * y) / (V::of(&point.c) + 1.0);
                sums[0] = (V::of(&band.hanging) * (setup.weight * weight)).mul_add(rise, sums[0]);
                let cloth = V::of(&band.cloth) * (0.5 * weight);
                if setup.rigidity != 0.0 {
                    sums[1] = sums[1] + forms.bending(cloth * setup.rigidity);
                }
                if setup.shear != 0.0 {
                    sums[2] = sums[2] + forms.shear(cloth * setup.shear);
                }
            }
        }
        [sums[0].sum(), sums[1].sum(), sums[2].sum()]
    }
}
