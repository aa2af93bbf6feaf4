//! The tangent-angle family: closed, inextensible hems of m equal folds, by the sine coefficients of their tangent angle.
//!
//! `c'(σ) = i R_n e^{i(σ + ψ)}`, `ψ = Σ_k a_k sin kmσ`, σ the material angle. Every such curve has the hem's own length everywhere, and for m ≥ 2 it
//! closes by symmetry, so a constrained problem becomes a free one over a_1 … a_K. In the frame that turns with σ,
//! `h = c e^{−iσ} = R_n Σ_j w_j e^{ijmσ}/(1 + jm)`, w_j the Fourier coefficients of e^{iψ}. Source: docs/model.md, section 5.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};

use crate::experiment::{Point, Skirt};
use crate::model::energy::bending::Bending;
use crate::model::energy::gravity::Gravity;
use crate::numerics::jet::Jet;
use crate::numerics::lanes::{Lanes, WIDTH, sin_cos, turned};
use crate::numerics::minimize::{Expansion, Smooth};
use crate::vectorized;

/// The ruled shell of one skirt over hems of `folds` folds and `harmonics` coefficients, discretized.
///
/// Sine series are odd about a crest, so half a fold says everything: nodes φ_n = mσ_n = πn/half, n = 0 … half.
#[derive(Debug, Clone)]
pub struct RuledShell {
    pub(super) folds: u32,
    pub(super) waist: f64,
    pub(super) hem: f64,
    gravity: Option<Gravity>,
    bending: Option<Bending>,
    /// Trapezoid weights of the half period; they sum to 2π.
    pub(super) weights: Vec<f64>,
    /// sin kφ_n, row n, column k − 1.
    pub(super) sines: DMatrix<f64>,
    /// km cos kφ_n: derivatives of the sines by σ.
    pub(super) slopes: DMatrix<f64>,
    /// (Re h, Im h) from (cos ψ, sin ψ), stacked.
    pub(super) kernel: DMatrix<f64>,
}

/// The energy of a hem, term by term, J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    pub gravity: f64,
    pub bending: f64,
}

impl Budget {
    pub fn total(&self) -> f64 {
        self.gravity + self.bending
    }
}

/// Nodes in half a fold that keep aliasing below rounding for tangent angles up to about two radians.
pub fn half_nodes(harmonics: usize) -> usize {
    // e^{iψ} of a ψ with |ψ| ≤ 2 has Bessel-like spectrum: 24 modes of the first harmonic reach 1e-16, eight nodes per further harmonic keep it so.
    24.max(8 * harmonics)
}

impl RuledShell {
    /// `half` intervals in half a fold, `slices` nodes along the slant; `weight` is ρ_A g (N/m²), `rigidity` B (N·m).
    pub fn new(skirt: &Skirt, weight: f64, rigidity: f64, folds: u32, harmonics: usize, half: usize, slices: usize) -> Self {
        RuledShell::with(skirt, (Some(weight), Some(rigidity)), folds, harmonics, half, slices)
    }

    /// The same without weight or without rigidity, where they are `None`.
    pub fn with(
        skirt: &Skirt,
        (weight, rigidity): (Option<f64>, Option<f64>),
        folds: u32,
        harmonics: usize,
        half: usize,
        slices: usize,
    ) -> Self {
        let (m, count) = (f64::from(folds), half + 1);
        let table: Vec<(f64, f64)> = (0..2 * half).map(|i| (PI * i as f64 / half as f64).sin_cos()).collect();
        let sines = DMatrix::from_fn(count, harmonics, |n, k| table[n * (k + 1) % (2 * half)].0);
        let slopes = DMatrix::from_fn(count, harmonics, |n, k| m * (k + 1) as f64 * table[n * (k + 1) % (2 * half)].1);
        let end = |n: usize| n == 0 || n == half;
        let weights = (0..count).map(|n| TAU / (2 * half) as f64 * if end(n) { 1.0 } else { 2.0 }).collect();
        RuledShell {
            folds,
            waist: skirt.waist_radius().0,
            hem: skirt.hem_radius().0,
            gravity: weight.map(|weight| Gravity::new(skirt, weight)),
            bending: rigidity.map(|rigidity| Bending::new(skirt, rigidity, slices)),
            weights,
            sines,
            slopes,
            kernel: kernel(skirt.hem_radius().0, m, half, &table),
        }
    }

    pub fn folds(&self) -> u32 {
        self.folds
    }

    /// Whether weight and rigidity are in.
    pub fn has(&self) -> (bool, bool) {
        (self.gravity.is_some(), self.bending.is_some())
    }

    /// Gravity and bending of the hem with coefficients `a`; `None` where a generatrix does not reach it.
    pub fn budget(&self, a: &DVector<f64>) -> Option<Budget> {
        let (psi, slope) = (&self.sines * a, &self.slopes * a);
        let hem = self.position(&psi);
        let count = psi.len();
        let mut budget = Budget { gravity: 0.0, bending: 0.0 };
        let bent = self.bent(psi.map(f64::cos).as_slice());
        for n in 0..count {
            let (x, y) = (hem[n] - self.waist, hem[count + n]);
            if let Some(gravity) = &self.gravity {
                budget.gravity += self.weights[n] * gravity.density(x * x + y * y)?.value;
            }
            if let Some((constant, quadratic)) = bent.get(n) {
                budget.bending += self.weights[n] * (constant[0] + quadratic[0] * slope[n] * slope[n]);
            }
        }
        Some(budget)
    }

    /// Mean Lagrange multiplier of the hem's length, N: by how much the energy of the shape with coefficients `a` changes per metre of hem.
    ///
    /// Derivative by |dc/dσ| alone, over 2π; cloth and waist stay as they are. At a minimum over `a` it is the derivative of the least energy.
    pub fn length_multiplier(&self, a: &DVector<f64>) -> Option<f64> {
        self.length_multiplier_stiffer(1.0, a)
    }

    /// The same for cloth `stiffer` times as rigid as the shell's own.
    pub fn length_multiplier_stiffer(&self, stiffer: f64, a: &DVector<f64>) -> Option<f64> {
        let (psi, slope) = (&self.sines * a, &self.slopes * a);
        let hem = self.position(&psi);
        let count = psi.len();
        let mut sum = 0.0;
        for n in 0..count {
            let (x, y) = (hem[n] - self.waist, hem[count + n]);
            if let Some(gravity) = &self.gravity {
                // h is proportional to the hem's radius.
                sum += self.weights[n] * gravity.density(x * x + y * y)?.first * 2.0 * (x * hem[n] + y * hem[count + n]) / self.hem;
            }
            if let Some(bending) = &self.bending {
                let (constant, quadratic) = bending.density(Jet::<1>::constant(psi[n].cos()), Jet::variable(self.hem, 0));
                sum += stiffer * self.weights[n] * (constant.gradient[0] + quadratic.gradient[0] * slope[n] * slope[n]);
            }
        }
        Some(sum / TAU)
    }

    /// The same cloth with its hem's radius grown by `by`, m.
    pub(super) fn lengthened(&self, by: f64) -> RuledShell {
        let hem = self.hem + by;
        RuledShell { hem, kernel: &self.kernel * (hem / self.hem), ..self.clone() }
    }

    /// b_0 and b_2 with their derivatives at every node, from cos ψ there; none without rigidity.
    fn bent(&self, cosines: &[f64]) -> Vec<([f64; 3], [f64; 3])> {
        self.bending.as_ref().map_or_else(Vec::new, |bending| bending.by_cosines(cosines, self.hem))
    }

    /// (Re h, Im h) at the nodes, stacked, m.
    fn position(&self, psi: &DVector<f64>) -> DVector<f64> {
        let count = psi.len();
        &self.kernel * DVector::from_fn(2 * count, |i, _| if i < count { psi[i].cos() } else { psi[i - count].sin() })
    }

    /// The curve with coefficients `a`, for evaluation anywhere.
    pub fn curve(&self, a: &DVector<f64>) -> TangentHem {
        TangentHem::new(self.folds, self.hem, a.as_slice(), self.weights.len() - 1)
    }
}

impl RuledShell {
    /// The derivatives of gravity's energy by a_1 … a_K, J; `None` where a generatrix does not reach the hem.
    pub fn gravity_gradient(&self, a: &DVector<f64>) -> Option<DVector<f64>> {
        let psi = &self.sines * a;
        let (hem, count) = (self.position(&psi), psi.len());
        let mut force = DVector::zeros(2 * count);
        for n in 0..count {
            let (x, y) = (hem[n] - self.waist, hem[count + n]);
            if let Some(gravity) = &self.gravity {
                let first = 2.0 * self.weights[n] * gravity.density(x * x + y * y)?.first;
                (force[n], force[count + n]) = (first * x, first * y);
            }
        }
        let adjoint = self.kernel.tr_mul(&force);
        let by_psi = DVector::from_fn(count, |n, _| {
            let (sin, cos) = psi[n].sin_cos();
            adjoint[count + n] * cos - adjoint[n] * sin
        });
        Some(self.sines.tr_mul(&by_psi))
    }

    /// Energy (J), gradient and Hessian by a_1 … a_K for cloth `stiffer` times as rigid as the shell's own.
    pub fn expand_stiffer(&self, stiffer: f64, a: &DVector<f64>) -> Option<Expansion> {
        let (psi, slope) = (&self.sines * a, &self.slopes * a);
        let (count, harmonics) = (psi.len(), a.len());
        // Column 0: e^{iψ}; column k: its derivative i sin kφ e^{iψ}.
        let mut source = DMatrix::zeros(2 * count, 1 + harmonics);
        for n in 0..count {
            (source[(count + n, 0)], source[(n, 0)]) = psi[n].sin_cos();
        }
        for k in 0..harmonics {
            for n in 0..count {
                source[(n, k + 1)] = -self.sines[(n, k)] * source[(count + n, 0)];
                source[(count + n, k + 1)] = self.sines[(n, k)] * source[(n, 0)];
            }
        }
        let image = &self.kernel * &source;
        let tangent = image.columns(1, harmonics);
        let mut value = 0.0;
        let mut force = DVector::zeros(2 * count);
        // Rows of the Gauss–Newton part: stiffness applied to the tangents.
        let mut loaded = DMatrix::zeros(2 * count, harmonics);
        let mut by_psi = DVector::zeros(count);
        let mut by_slope = DVector::zeros(count);
        let mut second = DMatrix::<f64>::zeros(count, 3);
        let bent = self.bent(&source.as_slice()[..count]);
        for n in 0..count {
            let (x, y) = (image[(n, 0)] - self.waist, image[(count + n, 0)]);
            let w = self.weights[n];
            if let Some(gravity) = &self.gravity {
                let rise = gravity.density(x * x + y * y)?;
                let (first, twist) = (2.0 * w * rise.first, 4.0 * w * rise.second);
                value += w * rise.value;
                force[n] = first * x;
                force[count + n] = first * y;
                for k in 0..harmonics {
                    let (tx, ty) = (tangent[(n, k)], tangent[(count + n, k)]);
                    let along = twist * (x * tx + y * ty);
                    loaded[(n, k)] = first * tx + along * x;
                    loaded[(count + n, k)] = first * ty + along * y;
                }
            }
            let Some((constant, quadratic)) = bent.get(n) else { continue };
            let (cos, sin) = (source[(n, 0)], source[(count + n, 0)]);
            let (constant, quadratic) = (constant.map(|b| stiffer * b), quadratic.map(|b| stiffer * b));
            // From derivatives by cos ψ to derivatives by ψ.
            let by_angle = |b: &[f64; 3]| (-sin * b[1], sin * sin * b[2] - cos * b[1]);
            let ((c1, c2), (q1, q2)) = (by_angle(&constant), by_angle(&quadratic));
            let s = slope[n];
            value += w * (constant[0] + quadratic[0] * s * s);
            by_psi[n] = w * (c1 + q1 * s * s);
            by_slope[n] = 2.0 * w * quadratic[0] * s;
            second[(n, 0)] = w * (c2 + q2 * s * s);
            second[(n, 1)] = 2.0 * w * q1 * s;
            second[(n, 2)] = 2.0 * w * quadratic[0];
        }
        // What the second derivative of e^{iψ}, −sin kφ sin lφ e^{iψ}, contributes: the adjoint of the kernel brings the force back to the nodes.
        let adjoint = self.kernel.tr_mul(&force);
        for n in 0..count {
            second[(n, 0)] -= source[(n, 0)] * adjoint[n] + source[(count + n, 0)] * adjoint[count + n];
        }
        let gradient = tangent.tr_mul(&force) + self.sines.tr_mul(&by_psi) + self.slopes.tr_mul(&by_slope);
        let mixed_s = DMatrix::from_fn(count, harmonics, |n, k| second[(n, 0)] * self.sines[(n, k)] + second[(n, 1)] * self.slopes[(n, k)]);
        let mixed_c = DMatrix::from_fn(count, harmonics, |n, k| second[(n, 1)] * self.sines[(n, k)] + second[(n, 2)] * self.slopes[(n, k)]);
        let hessian = tangent.tr_mul(&loaded) + self.sines.tr_mul(&mixed_s) + self.slopes.tr_mul(&mixed_c);
        Some(Expansion { value, gradient, hessian })
    }
}

impl Smooth for RuledShell {
    /// Energy (J), gradient and Hessian by a_1 … a_K.
    fn expand(&self, a: &DVector<f64>) -> Option<Expansion> {
        self.expand_stiffer(1.0, a)
    }
}

/// By how much an energy changes per metre of hem, N: `energy` of a hem (m, radius `hem`) whose radius has grown by so much.
///
/// Central difference: truncation falls with the square of the step, rounding grows with its inverse; 1e-5 leaves both at 1e-10 of the result.
pub(super) fn per_length(hem: f64, energy: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let step = 1e-5 * hem;
    Some((energy(step)? - energy(-step)?) / (2.0 * step) / TAU)
}

/// The discrete map from (cos ψ, sin ψ) on the half period to (Re h, Im h): division by 1 + jm in Fourier space, folded by symmetry.
pub(super) fn kernel(hem: f64, m: f64, half: usize, table: &[(f64, f64)]) -> DMatrix<f64> {
    let period = 2 * half;
    // T(δ) = (1/N) Σ_j e^{ijδ}/(1 + jm) on the grid of shifts; the highest mode is shared between +half and −half.
    let shares: Vec<(f64, f64)> = (1..=half)
        .map(|j| {
            let jm = m * j as f64;
            let share = if j == half { 0.5 } else { 1.0 } * 2.0 / (1.0 - jm * jm);
            (share, share * jm)
        })
        .collect();
    let scale = hem / period as f64;
    let mut shifts = vec![(0.0, 0.0); period];
    for n in 0..=half {
        let (mut real, mut imaginary, mut at) = (1.0, 0.0, 0);
        for (even, odd) in &shares {
            at += n;
            if period <= at {
                at -= period;
            }
            let (sin, cos) = table[at];
            real += even * cos;
            imaginary -= odd * sin;
        }
        // Back by as much: the conjugate.
        shifts[(period - n) % period] = (scale * real, -scale * imaginary);
        shifts[n] = (scale * real, scale * imaginary);
    }
    let count = half + 1;
    let mut kernel = DMatrix::zeros(2 * count, 2 * count);
    for l in 0..count {
        let alone = l == 0 || l == half;
        for n in 0..count {
            let minus = if l <= n { shifts[n - l] } else { shifts[n + period - l] };
            let plus = if n + l < period { shifts[n + l] } else { shifts[0] };
            let mirrored = if alone { (0.0, 0.0) } else { plus };
            kernel[(n, l)] = minus.0 + mirrored.0;
            kernel[(count + n, l)] = minus.1 + mirrored.1;
            if !alone {
                kernel[(n, count + l)] = -minus.1 + plus.1;
                kernel[(count + n, count + l)] = minus.0 - plus.0;
            }
        }
    }
    kernel
}

/// One curve of the family, to be evaluated at any material angle.
#[derive(Debug, Clone)]
pub struct TangentHem {
    folds: u32,
    hem: f64,
    coefficients: Vec<f64>,
    strains: Vec<f64>,
    /// h = Σ_j (modes_j.0 e^{ijφ} + modes_j.1 e^{−ijφ}).
    modes: Vec<(f64, f64)>,
}

impl TangentHem {
    /// The closed curve of `folds` ≥ 2 folds and length 2π · `hem` (m) with coefficients a_1 … a_K, from `half` intervals in half a fold.
    pub fn new(folds: u32, hem: f64, coefficients: &[f64], half: usize) -> Self {
        TangentHem::stretched(folds, hem, coefficients, &[], half)
    }

    /// The same stretched by ε(σ) = Σ_k strains[k] cos kmσ, k from 0.
    pub fn stretched(folds: u32, hem: f64, coefficients: &[f64], strains: &[f64], half: usize) -> Self {
        let m = f64::from(folds);
        let table: Vec<(f64, f64)> = (0..2 * half).map(|i| (PI * i as f64 / half as f64).sin_cos()).collect();
        let psi = |n: usize| coefficients.iter().enumerate().map(|(k, a)| a * table[n * (k + 1) % (2 * half)].0).sum::<f64>();
        let mut turned: Vec<(f64, f64)> = (0..=half).map(|n| psi(n).sin_cos()).collect();
        for (n, (sin, cos)) in turned.iter_mut().enumerate().filter(|_| !strains.is_empty()) {
            let length = 1.0 + strains.iter().enumerate().map(|(k, e)| e * table[n * k % (2 * half)].1).sum::<f64>();
            (*sin, *cos) = (*sin * length, *cos * length);
        }
        let weight = |n: usize| if n == 0 || n == half { 0.5 } else { 1.0 } / half as f64;
        let modes = (0..half).map(|j| {
            // w_{±j} = C_j ± S_j: e^{iψ} has an even real and an odd imaginary part, so its coefficients are real.
            let (mut even, mut odd) = (0.0, 0.0);
            for (n, (sin_psi, cos_psi)) in turned.iter().enumerate() {
                let (sin, cos) = table[n * j % (2 * half)];
                even += weight(n) * cos_psi * cos;
                odd += weight(n) * sin_psi * sin;
            }
            let jm = m * j as f64;
            if j == 0 { (hem * even, 0.0) } else { (hem * (even + odd) / (1.0 + jm), hem * (even - odd) / (1.0 - jm)) }
        });
        let mut modes: Vec<(f64, f64)> = modes.collect();
        // They fall off faster than geometrically: those that no digit of the curve feels are not carried along.
        let heard = modes.iter().rposition(|(plus, minus)| 1e-18 * hem < plus.abs() + minus.abs());
        modes.truncate(heard.map_or(0, |last| last + 1));
        TangentHem { folds, hem, coefficients: coefficients.to_vec(), strains: strains.to_vec(), modes }
    }

    /// h(φ) and dh/dφ at φ = mσ, m.
    fn turning(&self, phi: f64) -> [[f64; 2]; 2] {
        turnings(self, &[phi])[0]
    }

    /// Positions at many material angles, m.
    pub fn positions(&self, sigmas: &[f64]) -> Vec<[f64; 2]> {
        let m = f64::from(self.folds);
        let phis: Vec<f64> = sigmas.iter().map(|sigma| m * sigma).collect();
        let turned = |([[x, y], _], sigma): ([[f64; 2]; 2], &f64)| {
            let (sin, cos) = sigma.sin_cos();
            [x * cos - y * sin, x * sin + y * cos]
        };
        turnings(self, &phis).into_iter().zip(sigmas).map(turned).collect()
    }

    /// Position (m) and its first and second derivative by σ.
    pub fn local(&self, sigma: f64) -> [[f64; 2]; 3] {
        let m = f64::from(self.folds);
        let [[x, y], _] = self.turning(m * sigma);
        let turned = |(x, y): (f64, f64), angle: f64| {
            let (sin, cos) = angle.sin_cos();
            [x * cos - y * sin, x * sin + y * cos]
        };
        let (mut psi, mut slope) = (0.0, 0.0);
        for (k, a) in (1..).zip(&self.coefficients) {
            let order = m * f64::from(k);
            psi += a * (order * sigma).sin();
            slope += a * order * (order * sigma).cos();
        }
        // c' = i R_n e^{i(σ + ψ)}, c'' = −R_n (1 + ψ') e^{i(σ + ψ)}.
        let angle = sigma + psi;
        [turned((x, y), sigma), turned((0.0, self.hem), angle), turned((-self.hem * (1.0 + slope), 0.0), angle)]
    }

    /// `n` points round the hem, equally spaced in cloth length, the first on a crest on the x axis, counter-clockwise, m.
    pub fn outline(&self, n: usize) -> Vec<Point> {
        let m = f64::from(self.folds);
        // Where the points fall alike in every fold, one fold says everything.
        let period = if n.is_multiple_of(self.folds as usize) { n / self.folds as usize } else { n };
        let fold = turnings(self, &(0..period).map(|i| m * TAU * i as f64 / n as f64).collect::<Vec<f64>>());
        let place = |i: usize| {
            let ([[x, y], _], (sin, cos)) = (fold[i % period], (TAU * i as f64 / n as f64).sin_cos());
            Point::new(x * cos - y * sin, x * sin + y * cos)
        };
        (0..n).map(place).collect()
    }

    /// Least and greatest distance of the hem from the axis, m.
    pub fn radius_range(&self) -> (f64, f64) {
        const CELLS: usize = 64;
        let polar = |[[x, y], [dx, dy]]: [[f64; 2]; 2]| (x.hypot(y), x * dx + y * dy);
        let at = |phi: f64| polar(self.turning(phi));
        // The crest and the valley are extrema by symmetry; others show as sign changes of the slope between them.
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        let mut see = |r: f64| (low, high) = (low.min(r), high.max(r));
        see(at(0.0).0);
        see(at(PI).0);
        let phis: Vec<f64> = (0..=CELLS).map(|i| PI * i as f64 / CELLS as f64).collect();
        let slopes = turnings(self, &phis).into_iter().map(|place| polar(place).1);
        let edges: Vec<(f64, f64)> = phis.iter().copied().zip(slopes).collect();
        for pair in edges[1..CELLS].windows(2) {
            let ((mut a, sa), (mut b, sb)) = (pair[0], pair[1]);
            if sa * sb < 0.0 {
                for _ in 0..52 {
                    let middle = 0.5 * (a + b);
                    if sa * at(middle).1 < 0.0 { b = middle } else { a = middle }
                }
                see(at(0.5 * (a + b)).0);
            }
        }
        (low, high)
    }

    /// a_1 … a_K.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }
}

vectorized! {
    /// h(φ) and dh/dφ at many φ = mσ, m; eight at a time, the last of them as often as it takes.
    fn turnings<V>(hem: &TangentHem, phis: &[f64]) -> Vec<[[f64; 2]; 2]> {
        let m = f64::from(hem.folds);
        let mut out = Vec::with_capacity(phis.len());
        for chunk in phis.chunks(WIDTH) {
            let mut lanes = Lanes([chunk[chunk.len() - 1]; WIDTH]);
            lanes.0[..chunk.len()].copy_from_slice(chunk);
            let (sin, cos) = sin_cos(V::of(&lanes));
            let (mut x, mut y, mut psi, mut strain) = (V::zero(), V::zero(), V::zero(), V::zero());
            // e^{ijφ} as powers of e^{iφ}: one sine for all of them.
            let mut power = (V::all(1.0), V::zero());
            for j in 0..hem.modes.len().max(hem.coefficients.len()).max(hem.strains.len()) {
                if let Some((plus, minus)) = hem.modes.get(j) {
                    x = power.0.mul_add(V::all(plus + minus), x);
                    y = power.1.mul_add(V::all(plus - minus), y);
                }
                if let Some(e) = hem.strains.get(j) {
                    strain = power.0.mul_add(V::all(*e), strain);
                }
                power = turned(power, (cos, sin));
                if let Some(a) = hem.coefficients.get(j) {
                    psi = power.1.mul_add(V::all(*a), psi);
                }
            }
            let (sin, cos) = sin_cos(psi);
            let stretched = (strain + 1.0) * hem.hem;
            // From h − i m dh/dφ = R_n (1 + ε) e^{iψ}.
            let (dx, dy) = ((y - stretched * sin) / V::all(m), (stretched * cos - x) / V::all(m));
            let (x, y, dx, dy) = (x.lanes(), y.lanes(), dx.lanes(), dy.lanes());
            for lane in 0..chunk.len() {
                out.push([[x.0[lane], y.0[lane]], [dx.0[lane], dy.0[lane]]]);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Metre;

    fn shell(folds: u32, harmonics: usize) -> RuledShell {
        let skirt = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap();
        RuledShell::new(&skirt, 1.962, 1e-5, folds, harmonics, half_nodes(harmonics), Bending::NODES)
    }

    #[test]
    fn gradient_and_hessian_agree_with_central_differences() {
        let shell = shell(5, 4);
        let a = DVector::from_vec(vec![1.2, -0.2, 0.1, 0.05]);
        let exact = shell.expand(&a).unwrap();
        assert!((exact.value - shell.budget(&a).unwrap().total()).abs() < 1e-15);
        let h = 1e-5;
        for k in 0..4 {
            let step = DVector::from_fn(4, |i, _| if i == k { h } else { 0.0 });
            let (up, down) = (shell.expand(&(&a + &step)).unwrap(), shell.expand(&(&a - &step)).unwrap());
            // Rounding eps·U/h ~ 5e-14; truncation h²U‴/6 ~ 1e-12 at U of a few mJ.
            assert!((exact.gradient[k] - (up.value - down.value) / (2.0 * h)).abs() < 1e-11);
            let column = (up.gradient - down.gradient) / (2.0 * h);
            assert!((exact.hessian.column(k) - column).amax() < 1e-11);
        }
    }

    #[test]
    fn gradient_of_gravity_is_that_of_a_shell_without_rigidity() {
        let skirt = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap();
        let limp = RuledShell::with(&skirt, (Some(1.962), None), 5, 4, half_nodes(4), Bending::NODES);
        let a = DVector::from_vec(vec![1.2, -0.2, 0.1, 0.05]);
        let exact = limp.expand(&a).unwrap().gradient;
        // The same sums in another order.
        assert!((shell(5, 4).gravity_gradient(&a).unwrap() - &exact).amax() < 1e-13 * exact.amax());
    }

    #[test]
    fn stiffer_cloth_is_a_shell_of_that_rigidity() {
        let skirt = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap();
        let stiff = RuledShell::new(&skirt, 1.962, 3e-5, 5, 4, half_nodes(4), Bending::NODES);
        let a = DVector::from_vec(vec![1.2, -0.2, 0.1, 0.05]);
        let (own, stiffer) = (stiff.expand(&a).unwrap(), shell(5, 4).expand_stiffer(3.0, &a).unwrap());
        assert!((own.value - stiffer.value).abs() < 1e-14 * own.value && (own.hessian - stiffer.hessian).amax() < 1e-15);
        let (own, stiffer) = (stiff.length_multiplier(&a).unwrap(), shell(5, 4).length_multiplier_stiffer(3.0, &a).unwrap());
        assert!((own / stiffer - 1.0).abs() < 1e-13);
    }

    #[test]
    fn length_multiplier_agrees_with_a_longer_hem() {
        let a = DVector::from_vec(vec![1.2, -0.2, 0.1, 0.05]);
        let h = 1e-6;
        let at = |by: f64| shell(5, 4).lengthened(by).budget(&a).unwrap().total();
        let numeric = (at(h) - at(-h)) / (2.0 * h) / TAU;
        // Truncation h²U‴/6 with U‴ ~ U/(1 cm)³, rounding eps·U/h.
        assert!((shell(5, 4).length_multiplier(&a).unwrap() - numeric).abs() < 1e-8, "{numeric}");
    }

    #[test]
    fn hem_has_the_cloth_s_own_length_everywhere() {
        let curve = shell(5, 4).curve(&DVector::from_vec(vec![1.2, -0.2, 0.1, 0.05]));
        let n = 20_000;
        let points = curve.outline(n);
        for i in 0..n {
            let chord = points[i].distance(points[(i + 1) % n]) * n as f64 / TAU;
            // A chord is shorter than its arc by (arc·κ)²/24 ~ 1e-8; this includes the closing one.
            assert!((chord - 0.2362).abs() < 1e-7, "{i}: {chord}");
        }
    }

    #[test]
    fn velocity_identity_agrees_with_differences_of_the_series() {
        let curve = shell(3, 2).curve(&DVector::from_vec(vec![1.0, 0.2]));
        for i in 0..40 {
            let (phi, h) = (0.17 * f64::from(i), 1e-5);
            let [_, exact] = curve.turning(phi);
            let (up, down) = (curve.turning(phi + h)[0], curve.turning(phi - h)[0]);
            // Rounding eps·R/h ~ 1e-11, truncation h²h‴/6 ~ 1e-11.
            assert!((0..2).all(|d| (exact[d] - (up[d] - down[d]) / (2.0 * h)).abs() < 1e-9));
        }
    }
}
