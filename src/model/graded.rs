//! The graded shell: every ring between waist and hem keeps its own cloth length, every generatrix is inextensible and free to curve.
//!
//! Ring at fraction u of the slant, radius `R(u)`: tangent angle `σ + ψ`, `ψ(σ, u) = Σ_k a_k(u) sin kmσ`, so its plan is `e^{iσ} h`, `h = R T e^{iψ}` with T the
//! division by 1 + jm of the tangent-angle family. Height from `∂z/∂ℓ = −√(1 − |∂h/∂ℓ|²)`, z = 0 at the hinged waist, where a_k = 0. Energy: gravity
//! `ρ_A g ∫∫ (z + ℓ) R dℓ dσ`, bending `(B/2) ∫∫ (κ_1² + κ_2²) R dℓ dσ` from the full second fundamental form, and if asked shear `(S/2) ∫∫ γ² R dℓ dσ`,
//! `γ² = g_σℓ²/(g_σσ g_ℓℓ)`. Source: docs/model.md, section 5b.
//!
//! One hand-written reverse sweep gives the gradient; dual numbers pushed through it give the exact Hessian.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

pub use super::height::HeightBasis;
use super::tangent::{kernel, per_length};
use crate::experiment::Skirt;
use crate::numerics::dual::Dual;
use crate::numerics::minimize::{Expansion, Smooth};
use crate::numerics::quadrature::{gauss_legendre, running_integral};
use crate::vectorized;

/// Material and size of the discretization.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// ρ_A g, N/m²; 0 leaves gravity out.
    pub weight: f64,
    /// B, N·m; 0 leaves bending out.
    pub rigidity: f64,
    /// S, N/m; 0 leaves shear free.
    pub shear: f64,
    pub folds: u32,
    /// K.
    pub harmonics: usize,
    /// J.
    pub modes: usize,
    pub basis: HeightBasis,
    /// Intervals in half a fold.
    pub half: usize,
    /// Gauss–Legendre nodes from waist to hem.
    pub slices: usize,
}

/// Energy term by term, J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradedBudget {
    pub gravity: f64,
    pub bending: f64,
    pub shear: f64,
}

/// The graded shell of one skirt, discretized. Unknowns α_kj, index k·J + j (k from harmonic 1).
#[derive(Debug, Clone)]
pub struct GradedShell {
    setup: Setup,
    hem: f64,
    /// dR/dℓ.
    pub(super) growth: f64,
    /// Trapezoid weights of the half period; they sum to 2π.
    pub(super) weights: Vec<f64>,
    pub(super) sines: DMatrix<f64>,
    pub(super) slopes: DMatrix<f64>,
    pub(super) kernel: DMatrix<f64>,
    kernel_transposed: DMatrix<f64>,
    pub(super) slices: Vec<Slice>,
    /// Row q: weights of ∫₀^{ℓ_q} dℓ on the slices, m.
    pub(super) running: Vec<Vec<f64>>,
}

#[derive(Debug, Clone)]
pub(super) struct Slice {
    /// Fraction of the way from waist to hem along the slant.
    pub fraction: f64,
    /// R, m.
    pub ring: f64,
    /// R of the cloth as it was cut, m: its area, which a stretch of the ring does not change.
    pub cloth: f64,
    /// Weight of ∫ dℓ, m.
    pub weight: f64,
    /// ∫ R dℓ from here to the hem, m²: what hangs below.
    pub below: f64,
    pub basis: Vec<[f64; 3]>,
}

/// One sweep's result: terms, and the gradient of their sum.
struct Sweep<const N: usize> {
    gravity: Dual<N>,
    bending: Dual<N>,
    shear: Dual<N>,
    gradient: Vec<Dual<N>>,
}

/// Fields at one point of the grid.
#[derive(Clone, Copy)]
struct Cell<const N: usize> {
    sin: Dual<N>,
    cos: Dual<N>,
    psi_sigma: Dual<N>,
    psi_l: Dual<N>,
    psi_sigma_l: Dual<N>,
    /// Sources of h_ℓ and h_ℓℓ.
    first: (Dual<N>, Dual<N>),
    second: (Dual<N>, Dual<N>),
}

impl GradedShell {
    pub fn new(skirt: &Skirt, setup: Setup) -> Self {
        let (waist, hem, slant) = (skirt.waist_radius().0, skirt.hem_radius().0, skirt.slant_length().0);
        let (m, half, count) = (f64::from(setup.folds), setup.half, setup.half + 1);
        let table: Vec<(f64, f64)> = (0..2 * half).map(|i| (PI * i as f64 / half as f64).sin_cos()).collect();
        let rule = gauss_legendre(setup.slices);
        let slices: Vec<Slice> = rule
            .iter()
            .map(|(s, w)| {
                let (u, du, _) = setup.basis.height(*s);
                Slice {
                    fraction: u,
                    ring: waist + u * (hem - waist),
                    cloth: waist + u * (hem - waist),
                    weight: w * du * slant,
                    below: slant * (1.0 - u) * (waist + 0.5 * (1.0 + u) * (hem - waist)),
                    basis: setup.basis.functions(*s, setup.modes, slant),
                }
            })
            .collect();
        let running = running_integral(setup.slices);
        let measure: Vec<f64> = rule.iter().map(|(s, _)| setup.basis.height(*s).1 * slant).collect();
        let running = running.into_iter().map(|row| row.iter().zip(&measure).map(|(a, b)| a * b).collect()).collect();
        let kernel = kernel(1.0, m, half, &table);
        GradedShell {
            setup,
            hem,
            growth: (hem - waist) / slant,
            weights: (0..count).map(|n| PI / half as f64 * if n == 0 || n == half { 1.0 } else { 2.0 }).collect(),
            sines: DMatrix::from_fn(count, setup.harmonics, |n, k| table[n * (k + 1) % (2 * half)].0),
            slopes: DMatrix::from_fn(count, setup.harmonics, |n, k| m * (k + 1) as f64 * table[n * (k + 1) % (2 * half)].1),
            kernel_transposed: kernel.transpose(),
            kernel,
            slices,
            running,
        }
    }

    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Energy term by term; `None` where a generatrix would have to be longer than its cloth.
    pub fn budget(&self, alpha: &DVector<f64>) -> Option<GradedBudget> {
        let alpha: Vec<Dual<0>> = alpha.iter().map(|a| Dual::constant(*a)).collect();
        let sweep = self.sweep(&alpha)?;
        Some(GradedBudget { gravity: sweep.gravity.value, bending: sweep.bending.value, shear: sweep.shear.value })
    }

    /// Mean Lagrange multiplier of the hem's length, N: by how much the energy of the shape with coefficients `alpha` changes per metre of hem.
    ///
    /// Cloth and waist stay as they are; the rings between are lengthened in proportion to their distance from the waist. At a minimum over
    /// `alpha` it is the derivative of the least energy. Central difference: right to about nine digits.
    pub fn length_multiplier(&self, alpha: &DVector<f64>) -> Option<f64> {
        per_length(self.hem, |by| self.lengthened(by).budget(alpha).map(|budget| budget.gravity + budget.bending + budget.shear))
    }

    /// The same cloth with its hem's radius grown by `by`, m.
    pub(super) fn lengthened(&self, by: f64) -> GradedShell {
        let mut longer = self.clone();
        // The growth of R per metre of slant, from the waist, which stays.
        let slant = self.slices.iter().map(|slice| slice.weight).sum::<f64>();
        longer.hem += by;
        longer.growth += by / slant;
        for slice in &mut longer.slices {
            slice.ring += slice.fraction * by;
        }
        longer
    }

    /// a_k at the hem, for k = 1 … K: there s = 1 and every T_j is 1.
    pub fn hem_coefficients(&self, alpha: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(self.setup.harmonics, |k, _| alpha.rows(k * self.setup.modes, self.setup.modes).sum())
    }

    /// R_n, m.
    pub fn hem_radius(&self) -> f64 {
        self.hem
    }

    /// `h = T g` at all slices at once, or its adjoint.
    fn apply<const N: usize>(&self, fields: [&[(Dual<N>, Dual<N>)]; 2], matrix: &DMatrix<f64>) -> [Vec<(Dual<N>, Dual<N>)>; 2] {
        let (count, slices, width) = (self.weights.len(), self.slices.len(), N + 1);
        let rows = 2 * slices * width;
        let mut packed = DMatrix::zeros(rows, 2 * count);
        for (f, field) in fields.iter().enumerate() {
            for n in 0..count {
                for q in 0..slices {
                    let (x, y) = field[n * slices + q];
                    let row = (f * slices + q) * width;
                    for (column, dual) in [(n, x), (count + n, y)] {
                        packed[(row, column)] = dual.value;
                        for i in 0..N {
                            packed[(row + 1 + i, column)] = dual.slope[i];
                        }
                    }
                }
            }
        }
        let image = packed * matrix;
        [0, 1].map(|f| {
            let mut out = vec![(Dual::ZERO, Dual::ZERO); count * slices];
            for n in 0..count {
                for q in 0..slices {
                    let row = (f * slices + q) * width;
                    let read = |column: usize| {
                        let mut dual = Dual::constant(image[(row, column)]);
                        for i in 0..N {
                            dual.slope[i] = image[(row + 1 + i, column)];
                        }
                        dual
                    };
                    out[n * slices + q] = (read(n), read(count + n));
                }
            }
            out
        })
    }

    /// Energy and gradient, forward and back.
    #[inline(always)]
    fn sweep<const N: usize>(&self, alpha: &[Dual<N>]) -> Option<Sweep<N>> {
        let (harmonics, modes) = (self.setup.harmonics, self.setup.modes);
        let (count, slices, b) = (self.weights.len(), self.slices.len(), self.growth);
        let size = count * slices;
        let zero = Dual::<N>::ZERO;

        // Forward: coefficients of every ring and their derivatives by ℓ.
        let mut rings = vec![[zero; 3]; harmonics * slices];
        for (q, slice) in self.slices.iter().enumerate() {
            for k in 0..harmonics {
                for (j, basis) in slice.basis.iter().enumerate() {
                    for d in 0..3 {
                        rings[k * slices + q][d] += alpha[k * modes + j] * basis[d];
                    }
                }
            }
        }
        let mut cells = Vec::with_capacity(size);
        for n in 0..count {
            for (q, slice) in self.slices.iter().enumerate() {
                let (mut psi, mut psi_sigma, mut psi_l, mut psi_sigma_l, mut psi_ll) = (zero, zero, zero, zero, zero);
                for k in 0..harmonics {
                    let (sine, slope, ring) = (self.sines[(n, k)], self.slopes[(n, k)], &rings[k * slices + q]);
                    psi += ring[0] * sine;
                    psi_sigma += ring[0] * slope;
                    psi_l += ring[1] * sine;
                    psi_sigma_l += ring[1] * slope;
                    psi_ll += ring[2] * sine;
                }
                let (sin, cos) = psi.sin_cos();
                // (R' + iRψ_ℓ) e^{iψ} and (−Rψ_ℓ² + i(2R'ψ_ℓ + Rψ_ℓℓ)) e^{iψ}.
                let turn = psi_l * slice.ring;
                let (inward, along) = (turn * psi_l * -1.0, psi_l * (2.0 * b) + psi_ll * slice.ring);
                cells.push(Cell {
                    sin,
                    cos,
                    psi_sigma,
                    psi_l,
                    psi_sigma_l,
                    first: (cos * b - turn * sin, sin * b + turn * cos),
                    second: (inward * cos - along * sin, inward * sin + along * cos),
                });
            }
        }
        let firsts: Vec<_> = cells.iter().map(|c| c.first).collect();
        let seconds: Vec<_> = cells.iter().map(|c| c.second).collect();
        let [h1, h2] = self.apply([&firsts, &seconds], &self.kernel_transposed);

        // In the frame that turns with the ring's tangent: X_ℓ = (x, y, −c), X_ℓℓ = (x2, y2, −c_ℓ).
        let rotate = |cell: &Cell<N>, h: (Dual<N>, Dual<N>)| (h.0 * cell.cos + h.1 * cell.sin, h.1 * cell.cos - h.0 * cell.sin);
        let lean: Vec<_> = cells.iter().zip(&h1).map(|(cell, h)| rotate(cell, *h)).collect();
        let bend: Vec<_> = cells.iter().zip(&h2).map(|(cell, h)| rotate(cell, *h)).collect();
        let mut fall = Vec::with_capacity(size);
        let (mut c_sigma, mut c_sigma_sigma) = (Vec::with_capacity(size), Vec::with_capacity(size));
        for (i, cell) in cells.iter().enumerate() {
            let ((x, y), ring) = (lean[i], self.slices[i % slices].ring);
            let square = (x.square() + y.square()) * -1.0 + 1.0;
            if square.value.is_nan() || square.value <= 0.0 {
                return None;
            }
            let c = square.sqrt();
            let inverse = c.recip();
            // X_σℓ = (a, R', −c_σ).
            let (a, t) = (cell.psi_l * -ring, cell.psi_sigma + 1.0);
            let (vx, vy) = (t * -b - cell.psi_sigma_l * ring, t * a);
            let cs = (x * a + y * b) * inverse * -1.0;
            c_sigma_sigma.push((a.square() + x * vx + y * vy + cs.square() + b * b) * inverse * -1.0);
            c_sigma.push(cs);
            fall.push((c, inverse));
        }
        let integrate = |f: &[Dual<N>]| {
            let mut out = vec![zero; size];
            for n in 0..count {
                for q in 0..slices {
                    for (j, weight) in self.running[q].iter().enumerate() {
                        out[n * slices + q] += f[n * slices + j] * -weight;
                    }
                }
            }
            out
        };
        let (slope, twist) = (integrate(&c_sigma), integrate(&c_sigma_sigma));

        // Density, and backward through it.
        let (mut gravity, mut bending, mut shear) = (zero, zero, zero);
        let mut back = vec![Back::<N>::ZERO; size];
        let (mut slope_back, mut twist_back) = (vec![zero; size], vec![zero; size]);
        for n in 0..count {
            for (q, slice) in self.slices.iter().enumerate() {
                let i = n * slices + q;
                let cell = &cells[i];
                let area = self.weights[n] * slice.weight;
                let (k_gravity, k_bending) = (self.setup.weight * slice.below * area, 0.5 * self.setup.rigidity * slice.cloth * area);
                let k_shear = 0.5 * self.setup.shear * slice.cloth * area;
                let ring = slice.ring;
                let ((x, y), (x2, y2), (c, inverse)) = (lean[i], bend[i], fall[i]);
                let (p, r, cs) = (slope[i], twist[i], c_sigma[i]);
                let (a, t) = (cell.psi_l * -ring, cell.psi_sigma + 1.0);
                let cl = (x * x2 + y * y2) * inverse * -1.0;
                let (e, f) = (p.square() + ring * ring, y * ring - p * c);
                let w = e - f.square();
                let normal = ((c * ring + p * y) * -1.0, p * x, x * -ring);
                let e2 = t * normal.0 * -ring + r * normal.2;
                let f2 = a * normal.0 + normal.1 * b - cs * normal.2;
                let g2 = x2 * normal.0 + y2 * normal.1 - cl * normal.2;
                let (m11, m12, m21, m22) = (e2 - f * f2, f2 - f * g2, e * f2 - f * e2, e * g2 - f * f2);
                if k_gravity != 0.0 {
                    gravity += (x.square() + y.square()) / (c + 1.0) * k_gravity;
                }
                let (mut e_back, mut f_back, e2_back, f2_back, g2_back) = if k_bending != 0.0 {
                    let trace = m11.square() + m12 * m21 * 2.0 + m22.square();
                    let w_inverse = w.recip();
                    let cubed = w_inverse.square() * w_inverse;
                    bending += trace * cubed * k_bending;
                    let trace_back = cubed * (2.0 * k_bending);
                    let w_back = trace * cubed * w_inverse * (-3.0 * k_bending);
                    let (b11, b12, b21, b22) = (trace_back * m11, trace_back * m21, trace_back * m12, trace_back * m22);
                    (
                        f2 * b21 + g2 * b22 + w_back,
                        (f2 * (b11 + b22) + g2 * b12 + e2 * b21) * -1.0 - f * w_back * 2.0,
                        b11 - f * b21,
                        b12 - f * (b11 + b22) + e * b21,
                        e * b22 - f * b12,
                    )
                } else {
                    (zero, zero, zero, zero, zero)
                };
                if k_shear != 0.0 {
                    let ratio = f / e;
                    shear += f * ratio * k_shear;
                    f_back += ratio * (2.0 * k_shear);
                    e_back += ratio.square() * -k_shear;
                }
                let normal_back = (
                    t * e2_back * -ring + a * f2_back + x2 * g2_back,
                    f2_back * b + y2 * g2_back,
                    r * e2_back - cs * f2_back - cl * g2_back,
                );
                let cl_back = normal.2 * g2_back * -1.0;
                let out = &mut back[i];
                out.t = normal.0 * e2_back * -ring;
                out.a = normal.0 * f2_back;
                out.c_sigma = normal.2 * f2_back * -1.0;
                let scaled = inverse * cl_back;
                out.x = p * normal_back.1 - normal_back.2 * ring - x2 * scaled;
                out.y = f_back * ring - p * normal_back.0 - y2 * scaled;
                out.x2 = normal.0 * g2_back - x * scaled;
                out.y2 = normal.1 * g2_back - y * scaled;
                out.c = (normal_back.0 * ring + p * f_back + cl * scaled) * -1.0 + -k_gravity;
                slope_back[i] = x * normal_back.1 - y * normal_back.0 - c * f_back + p * e_back * 2.0;
                twist_back[i] = normal.2 * e2_back;
            }
        }
        let mut c_sigma_sigma_back = vec![zero; size];
        for n in 0..count {
            for (q, row) in self.running.iter().enumerate() {
                for (j, weight) in row.iter().enumerate() {
                    back[n * slices + j].c_sigma += slope_back[n * slices + q] * -weight;
                    c_sigma_sigma_back[n * slices + j] += twist_back[n * slices + q] * -weight;
                }
            }
        }
        let (mut h1_back, mut h2_back) = (Vec::with_capacity(size), Vec::with_capacity(size));
        // Adjoints of ψ, ψ_σ, ψ_ℓ, ψ_σℓ, ψ_ℓℓ.
        let mut angle_back = vec![[zero; 5]; size];
        for (i, cell) in cells.iter().enumerate() {
            let ring = self.slices[i % slices].ring;
            let ((x, y), (_, inverse)) = (lean[i], fall[i]);
            let (a, t, cs) = (cell.psi_l * -ring, cell.psi_sigma + 1.0, c_sigma[i]);
            let (vx, vy) = (t * -b - cell.psi_sigma_l * ring, t * a);
            let out = &mut back[i];
            let s = inverse * c_sigma_sigma_back[i];
            let (vx_back, vy_back) = (x * s * -1.0, y * s * -1.0);
            let d = inverse * (out.c_sigma - cs * s * 2.0);
            let c_back = (out.c - c_sigma_sigma[i] * s - cs * d) * inverse;
            let a_back = out.a - a * s * 2.0 + t * vy_back - x * d;
            let x_back = out.x - vx * s - a * d - x * c_back;
            let y_back = out.y - vy * s - d * b - y * c_back;
            let t_back = out.t - vx_back * b + a * vy_back;
            let (x2, y2) = bend[i];
            angle_back[i] = [x_back * y - y_back * x + out.x2 * y2 - out.y2 * x2, t_back, a_back * -ring, vx_back * -ring, zero];
            h1_back.push((x_back * cell.cos - y_back * cell.sin, x_back * cell.sin + y_back * cell.cos));
            h2_back.push((out.x2 * cell.cos - out.y2 * cell.sin, out.x2 * cell.sin + out.y2 * cell.cos));
        }
        let [g1, g2] = self.apply([&h1_back, &h2_back], &self.kernel);
        let mut ring_back = vec![[zero; 3]; harmonics * slices];
        for n in 0..count {
            for (q, slice) in self.slices.iter().enumerate() {
                let i = n * slices + q;
                let (cell, ring, (g1, g2)) = (&cells[i], slice.ring, (g1[i], g2[i]));
                let (inward, along) = (cell.cos * g2.0 + cell.sin * g2.1, cell.cos * g2.1 - cell.sin * g2.0);
                let [psi, psi_sigma, psi_l, psi_sigma_l, _] = angle_back[i];
                let psi = psi + g1.1 * cell.first.0 - g1.0 * cell.first.1 + g2.1 * cell.second.0 - g2.0 * cell.second.1;
                let psi_l = psi_l + (cell.cos * g1.1 - cell.sin * g1.0) * ring + along * (2.0 * b) - cell.psi_l * inward * (2.0 * ring);
                let psi_ll = along * ring;
                for k in 0..harmonics {
                    let (sine, cosine, out) = (self.sines[(n, k)], self.slopes[(n, k)], &mut ring_back[k * slices + q]);
                    out[0] += psi * sine + psi_sigma * cosine;
                    out[1] += psi_l * sine + psi_sigma_l * cosine;
                    out[2] += psi_ll * sine;
                }
            }
        }
        let mut gradient = vec![zero; harmonics * modes];
        for (q, slice) in self.slices.iter().enumerate() {
            for k in 0..harmonics {
                for (j, basis) in slice.basis.iter().enumerate() {
                    for d in 0..3 {
                        gradient[k * modes + j] += ring_back[k * slices + q][d] * basis[d];
                    }
                }
            }
        }
        Some(Sweep { gravity, bending, shear, gradient })
    }
}

/// Adjoints of the local fields.
#[derive(Clone, Copy)]
struct Back<const N: usize> {
    x: Dual<N>,
    y: Dual<N>,
    x2: Dual<N>,
    y2: Dual<N>,
    c: Dual<N>,
    c_sigma: Dual<N>,
    a: Dual<N>,
    t: Dual<N>,
}

impl<const N: usize> Back<N> {
    const ZERO: Self = Back {
        x: Dual::ZERO,
        y: Dual::ZERO,
        x2: Dual::ZERO,
        y2: Dual::ZERO,
        c: Dual::ZERO,
        c_sigma: Dual::ZERO,
        a: Dual::ZERO,
        t: Dual::ZERO,
    };
}

/// Hessian columns per sweep: as many as the widest vector register holds.
const COLUMNS: usize = 8;

vectorized! {
    /// [`GradedShell::sweep`] in the widest registers: the slopes of a dual number fill one.
    fn swept<V>(shell: &GradedShell, alpha: &[Dual<COLUMNS>]) -> Option<Sweep<COLUMNS>> {
        shell.sweep(alpha)
    }
}

impl Smooth for GradedShell {
    fn expand(&self, alpha: &DVector<f64>) -> Option<Expansion> {
        let n = alpha.len();
        let mut out = Expansion { value: 0.0, gradient: DVector::zeros(n), hessian: DMatrix::zeros(n, n) };
        for from in (0..n).step_by(COLUMNS) {
            let seeded: Vec<Dual<COLUMNS>> = (0..n)
                .map(|i| {
                    let mut dual = Dual::constant(alpha[i]);
                    if (from..from + COLUMNS).contains(&i) {
                        dual.slope[i - from] = 1.0;
                    }
                    dual
                })
                .collect();
            let sweep = swept(self, &seeded)?;
            out.value = (sweep.gravity + sweep.bending + sweep.shear).value;
            for (i, entry) in sweep.gradient.iter().enumerate() {
                out.gradient[i] = entry.value;
                for column in from..n.min(from + COLUMNS) {
                    out.hessian[(i, column)] = entry.slope[column - from];
                }
            }
        }
        // Exact derivatives are symmetric up to rounding; the eigenvalue solver wants them exactly so.
        out.hessian = 0.5 * (&out.hessian + out.hessian.transpose());
        Some(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Metre;

    fn shell(basis: HeightBasis, harmonics: usize, modes: usize, shear: f64) -> GradedShell {
        let skirt = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap();
        let setup = Setup { weight: 1.962, rigidity: 1e-5, shear, folds: 5, harmonics, modes, basis, half: 24, slices: 24 };
        GradedShell::new(&skirt, setup)
    }

    #[test]
    fn energy_at_the_reference_coefficients_is_the_reference_energy() {
        // Birthplace: docs/model.md, section 5b: K 1, J 4 in the polynomial basis; α printed to six digits, and the energy is stationary there.
        let alpha = DVector::from_vec(vec![2.441794, -1.448642, 0.425606, -0.094354]);
        let budget = shell(HeightBasis::Polynomial, 1, 4, 0.0).budget(&alpha).unwrap();
        assert!((budget.gravity + budget.bending - 0.0033096787).abs() < 1e-10);
    }

    #[test]
    fn length_multiplier_of_a_round_limp_cone_is_the_closed_form() {
        // Without rigidity the cone's energy is weight·∫∫ below (1 − √(1 − g²)) dℓ dσ with g = (R_n − R_t)/L; its derivative by R_n over 2π:
        let (waist, hem, slant, weight) = (0.121_f64, 0.2362_f64, 0.53_f64, 1.962);
        let growth = (hem - waist) / slant;
        let below = slant * slant * (0.5 * waist + (hem - waist) / 3.0);
        let exact = weight * below * growth / (1.0 - growth * growth).sqrt() / slant;
        let skirt = Skirt::new(Metre(waist), Metre(hem), Metre(slant)).unwrap();
        let setup = Setup { rigidity: 0.0, ..*shell(HeightBasis::Polynomial, 1, 2, 0.0).setup() };
        let found = GradedShell::new(&skirt, setup).length_multiplier(&DVector::zeros(2)).unwrap();
        // Central differences keep nine digits.
        assert!((found / exact - 1.0).abs() < 1e-8, "{found} {exact}");
    }

    #[test]
    fn gradient_and_hessian_agree_with_central_differences() {
        for (basis, shear) in [(HeightBasis::Polynomial, 0.0), (HeightBasis::Layer { width: 0.05 }, 0.02)] {
            let shell = shell(basis, 2, 3, shear);
            let alpha = DVector::from_vec(vec![1.3, -0.3, 0.1, -0.1, 0.05, 0.02]);
            let exact = shell.expand(&alpha).unwrap();
            let h = 1e-5;
            for k in 0..6 {
                let step = DVector::from_fn(6, |i, _| if i == k { h } else { 0.0 });
                let (up, down) = (shell.expand(&(&alpha + &step)).unwrap(), shell.expand(&(&alpha - &step)).unwrap());
                let scale = exact.hessian.amax();
                // Truncation h²f‴/6 ~ 1e-10 and rounding eps/h ~ 2e-11, both relative to the scale of the function.
                assert!((exact.gradient[k] - (up.value - down.value) / (2.0 * h)).abs() < 1e-8 * scale, "{k}");
                assert!((exact.hessian.column(k) - (up.gradient - down.gradient) / (2.0 * h)).amax() < 1e-7 * scale, "{k}");
            }
        }
    }
}
