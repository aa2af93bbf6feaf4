//! The tangent-angle family: closed, inextensible hems of m equal folds, by the sine coefficients of their tangent angle.
//!
//! `c'(σ) = i R_n e^{i(σ + ψ)}`, `ψ = Σ_k a_k sin kmσ`, σ the material angle. Every such curve has the hem's own length everywhere, and for m ≥ 2 it
//! closes by symmetry, so a constrained problem becomes a free one over a_1 … a_K. In the frame that turns with σ,
//! `h = c e^{−iσ} = R_n Σ_j w_j e^{ijmσ}/(1 + jm)`, w_j the Fourier coefficients of e^{iψ}. Source: docs/model.md, section 5.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};

pub use super::tangent_hem::TangentHem;
use crate::experiment::Skirt;
use crate::model::energy::bending::Bending;
use crate::model::energy::gravity::Gravity;
use crate::numerics::jet::Jet;
use crate::numerics::minimize::{Expansion, Smooth};

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
        for n in 0..count {
            let (x, y) = (hem[n] - self.waist, hem[count + n]);
            if let Some(gravity) = &self.gravity {
                budget.gravity += self.weights[n] * gravity.density(x * x + y * y)?.value;
            }
            if let Some(bending) = &self.bending {
                let (constant, quadratic) = bending.by_cos(psi[n].cos(), self.hem);
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
}
