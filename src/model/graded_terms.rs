//! The graded shell under any set of terms: weight, rigidity and shear as in `graded`, everything else added, each where the cloth is.
//!
//! Unknowns are α_kj; where rings and generatrices may stretch, coefficients of their strains follow. A ring then has radius `A = R(1 + ε)` in plan, a
//! generatrix length element 1 + η, and the whole energy is taken here, by local maps between linear ones (`numerics/layers`): ring coefficients → sources →
//! plan (kernel) → fall → height (running integral) → density. Otherwise only position is needed, and only terms that depend on it.

use std::cell::Cell;
use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use super::energy::{Gaps, Ledger, Spot, Terms};
use super::graded::{GradedShell, Setup};
use super::tangent::{TangentHem, half_nodes, per_length};
use crate::experiment::Skirt;
use crate::experiment::scene::Term;
use crate::numerics::jet::Jet;
use crate::numerics::layers::{Field, map};
use crate::numerics::minimize::{Expansion, Smooth};

/// Harmonics of each strain, with the mean, and its modes over height.
const STRAINS: (usize, usize) = (3, 3);

/// A graded shell, discretized. A term's stiffness of 0 in `setup` leaves the term out.
#[derive(Debug, Clone)]
pub struct GradedTerms {
    /// Of inextensible cloth; all its terms are out where cloth may stretch.
    shell: GradedShell,
    setup: Setup,
    terms: Terms,
    /// Derivatives of each linear field by the unknowns, node index q·count + n. Only those that are needed.
    linear: Vec<DMatrix<f64>>,
    scales: (f64, f64),
    evaluations: Cell<[usize; 7]>,
}

/// Linear fields: tangent angle, ring radius in plan, strain of the generatrix, and their derivatives by σ (S) and ℓ (L).
#[derive(Clone, Copy)]
enum Linear {
    Psi,
    PsiL,
    A,
    PsiS,
    PsiSl,
    PsiLl,
    AS,
    AL,
    ASl,
    ALl,
    Eta,
    EtaS,
    EtaL,
    EtaSs,
}

use Linear::{A, AL, ALl, AS, ASl, Eta, EtaL, EtaS, EtaSs, Psi, PsiL, PsiLl, PsiS, PsiSl};

/// In the order of the enumeration.
const LINEAR: [Linear; 14] = [Psi, PsiL, A, PsiS, PsiSl, PsiLl, AS, AL, ASl, ALl, Eta, EtaS, EtaL, EtaSs];

impl GradedTerms {
    /// `setup` gives the size; weight, rigidity and shear are those of `terms`.
    pub fn new(skirt: &Skirt, terms: &Terms, setup: Setup) -> Self {
        let asked = Setup {
            weight: terms.gravity.unwrap_or(0.0),
            rigidity: terms.bending.unwrap_or(0.0),
            shear: terms.shear.map_or(0.0, |shear| shear.stiffness()),
            ..setup
        };
        let stretched = terms.stretch.is_some();
        let own = if stretched { Setup { weight: 0.0, rigidity: 0.0, shear: 0.0, ..asked } } else { asked };
        let slant = skirt.slant_length().0;
        let mut shell = GradedTerms {
            shell: GradedShell::new(skirt, own),
            setup: asked,
            terms: *terms,
            linear: Vec::new(),
            scales: terms.stretch.map_or((0.0, 0.0), |stretch| stretch.scales(terms.gravity.unwrap_or(1.0) * slant)),
            evaluations: Cell::new([0; 7]),
        };
        if shell.beyond_sweep() {
            // Without stretch only the angle and its derivative by ℓ are needed, and the ring's radius, which is given.
            let needed = if stretched { 14 } else { 3 };
            shell.linear = LINEAR[..needed].iter().map(|field| shell.tangent(*field)).collect();
        }
        shell
    }

    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Whether a term is in that the sweep of the inextensible shell does not have.
    fn beyond_sweep(&self) -> bool {
        self.terms.stretch.is_some() || self.terms.placed()
    }

    /// How many unknowns follow the α_kj.
    pub fn strains(&self) -> usize {
        if self.terms.stretch.is_some() { 2 * STRAINS.0 * STRAINS.1 } else { 0 }
    }

    pub fn evaluations(&self) -> [usize; 7] {
        self.evaluations.get()
    }

    fn alphas(&self) -> usize {
        self.setup.harmonics * self.setup.modes
    }

    fn alpha(&self, x: &DVector<f64>) -> DVector<f64> {
        x.rows(0, self.alphas()).into_owned()
    }

    /// Energy of each term; `None` where the cloth cannot be.
    pub fn ledger(&self, x: &DVector<f64>) -> Option<Ledger> {
        let mut ledger = if self.beyond_sweep() { self.beyond(x)?.1 } else { Ledger::default() };
        if self.terms.stretch.is_none() {
            let budget = self.shell.budget(&self.alpha(x))?;
            for (term, energy) in [(Term::Gravity, budget.gravity), (Term::Bending, budget.bending), (Term::Shear, budget.shear)] {
                ledger.add(term, energy);
            }
        }
        Some(ledger)
    }

    /// The multiplier of the hem's length, N, as [`GradedShell::length_multiplier`]; `None` where rings may stretch: then their tension does its work.
    pub fn length_multiplier(&self, x: &DVector<f64>) -> Option<f64> {
        if self.terms.stretch.is_some() {
            return None;
        }
        let own = self.shell.length_multiplier(&self.alpha(x))?;
        if !self.beyond_sweep() {
            return Some(own);
        }
        Some(own + per_length(self.shell.hem_radius(), |by| self.lengthened(by).beyond(x).map(|(all, ..)| all.value))?)
    }

    /// The same cloth, none of it stretching, with its hem's radius grown by `by` (m) and the rings above in proportion to their distance from the waist.
    pub fn lengthened(&self, by: f64) -> GradedTerms {
        GradedTerms { shell: self.shell.lengthened(by), ..self.clone() }
    }

    /// The coefficients a_k of the hem, for inextensible cloth.
    pub fn hem_coefficients(&self, x: &DVector<f64>) -> DVector<f64> {
        self.shell.hem_coefficients(x)
    }

    /// The hem, its crest on the axis.
    pub fn curve(&self, x: &DVector<f64>) -> TangentHem {
        let mut hem = self.shell.hem_coefficients(&self.alpha(x));
        let (harmonics, modes) = STRAINS;
        let strains = if self.strains() == 0 { 0 } else { harmonics };
        // At the hem every mode is 1.
        let mut strain: Vec<f64> =
            (0..strains).map(|k| (0..modes).map(|j| x[self.alphas() + k * modes + j]).sum::<f64>() * self.scales.0).collect();
        // A shift by half a fold flips the odd coefficients together.
        if hem.get(0).is_some_and(|first| *first < 0.0) {
            hem.iter_mut().step_by(2).for_each(|a| *a = -*a);
            strain.iter_mut().skip(1).step_by(2).for_each(|e| *e = -*e);
        }
        TangentHem::stretched(self.setup.folds, self.shell.hem_radius(), hem.as_slice(), &strain, 2 * half_nodes(hem.len()))
    }

    /// Smallest distances to the body and between folds, over the nodes.
    pub fn gaps(&self, x: &DVector<f64>) -> Gaps {
        let mut gaps = Gaps::default();
        let Some((_, _, [hx, hy, z])) = self.beyond_sweep().then(|| self.beyond(x)).flatten() else { return gaps };
        for i in 0..hx.len() {
            gaps.see(&self.terms, &self.spot(i), [hx[i], hy[i], z[i]]);
        }
        gaps
    }

    fn spot(&self, i: usize) -> Spot {
        let count = self.shell.weights.len();
        let (n, slice) = (i % count, &self.shell.slices[i / count]);
        let folds = self.setup.folds;
        let sigma = PI * n as f64 / (count - 1) as f64 / f64::from(folds);
        Spot { folds, sigma, ring: slice.cloth, area: self.shell.weights[n] * slice.weight * slice.cloth }
    }

    /// Derivatives of a field by the unknowns at all nodes.
    fn tangent(&self, field: Linear) -> DMatrix<f64> {
        let (shell, modes, m) = (&self.shell, self.setup.modes, f64::from(self.setup.folds));
        let count = shell.weights.len();
        let mut out = DMatrix::zeros(count * shell.slices.len(), self.alphas() + self.strains());
        // By ℓ: which derivative of the basis.
        let order = match field {
            Psi | PsiS | A | AS | Eta | EtaS | EtaSs => 0,
            PsiL | PsiSl | AL | ASl | EtaL => 1,
            PsiLl | ALl => 2,
        };
        for (q, slice) in shell.slices.iter().enumerate() {
            for n in 0..count {
                let row = q * count + n;
                match field {
                    Psi | PsiL | PsiLl | PsiS | PsiSl => {
                        let around = if matches!(field, PsiS | PsiSl) { &shell.slopes } else { &shell.sines };
                        for k in 0..self.setup.harmonics {
                            for (j, basis) in slice.basis.iter().enumerate() {
                                out[(row, k * modes + j)] = around[(n, k)] * basis[order];
                            }
                        }
                    }
                    _ if self.strains() == 0 => {}
                    _ => {
                        let ring = matches!(field, A | AS | AL | ASl | ALl);
                        let first = self.alphas() + if ring { 0 } else { STRAINS.0 * STRAINS.1 };
                        for k in 0..STRAINS.0 {
                            let (sin, cos) = (PI * (n * k) as f64 / (count - 1) as f64).sin_cos();
                            let km = m * k as f64;
                            let around = match field {
                                AS | ASl | EtaS => -km * sin,
                                EtaSs => -km * km * cos,
                                _ => cos,
                            };
                            for (j, basis) in slice.basis.iter().take(STRAINS.1).enumerate() {
                                // ε is R's relative growth: A = R + Rε, with R linear in ℓ.
                                let by_ring = match order {
                                    0 => slice.ring * basis[0],
                                    1 => slice.ring * basis[1] + shell.growth * basis[0],
                                    _ => slice.ring * basis[2] + 2.0 * shell.growth * basis[1],
                                };
                                let value = if ring { by_ring * self.scales.0 } else { basis[order] * self.scales.1 };
                                out[(row, first + k * STRAINS.1 + j)] = around * value;
                            }
                        }
                    }
                }
            }
        }
        out
    }

    /// A linear field at all nodes.
    fn field(&self, field: Linear, x: &DVector<f64>) -> Field {
        let count = self.shell.weights.len();
        let mut out = Field::linear(0.0, &self.linear[field as usize], x);
        match field {
            A => out.value.iter_mut().enumerate().for_each(|(i, a)| *a += self.shell.slices[i / count].ring),
            AL => out.value.add_scalar_mut(self.shell.growth),
            _ => {}
        }
        out
    }

    /// `h = T s` on every ring.
    fn plan(&self, re: &Field, im: &Field) -> [Field; 2] {
        let unknowns = re.tangent.ncols();
        let mut out = [Field::zero(re.value.len(), unknowns), Field::zero(re.value.len(), unknowns)];
        let image = self.kernel([re.value.as_slice(), im.value.as_slice()], false);
        for (out, image) in out.iter_mut().zip(image) {
            out.value.copy_from_slice(&image);
        }
        let image = self.kernel([re.tangent.as_slice(), im.tangent.as_slice()], false);
        for (out, image) in out.iter_mut().zip(image) {
            out.tangent.copy_from_slice(&image);
        }
        out
    }

    /// The kernel, or its adjoint, along each run of `count` numbers.
    fn kernel(&self, parts: [&[f64]; 2], adjoint: bool) -> [Vec<f64>; 2] {
        let count = self.shell.weights.len();
        let rings = parts[0].len() / count;
        let both =
            DMatrix::from_fn(2 * count, rings, |i, r| if i < count { parts[0][r * count + i] } else { parts[1][r * count + i - count] });
        let image = if adjoint { self.shell.kernel.tr_mul(&both) } else { &self.shell.kernel * both };
        [0, count].map(|at| image.rows(at, count).into_owned().as_slice().to_vec())
    }

    /// −∫ f dℓ from the waist.
    fn height(&self, f: &Field) -> Field {
        let mut out = Field::zero(f.value.len(), f.tangent.ncols());
        self.integrate(f.value.as_slice(), out.value.as_mut_slice(), false);
        self.integrate(f.tangent.as_slice(), out.tangent.as_mut_slice(), false);
        out
    }

    /// Of each column of numbers at all nodes; or the adjoint.
    fn integrate(&self, f: &[f64], out: &mut [f64], adjoint: bool) {
        let count = self.shell.weights.len();
        let size = count * self.shell.slices.len();
        for (f, out) in f.chunks_exact(size).zip(out.chunks_exact_mut(size)) {
            for (q, row) in self.shell.running.iter().enumerate() {
                for (j, weight) in row.iter().enumerate() {
                    let (to, from) = if adjoint { (j, q) } else { (q, j) };
                    for n in 0..count {
                        out[to * count + n] -= weight * f[from * count + n];
                    }
                }
            }
        }
    }

    /// Terms that the sweep does not have (all of them, where cloth may stretch), and where the cloth is: h and z at the nodes.
    #[allow(clippy::type_complexity)]
    fn beyond(&self, x: &DVector<f64>) -> Option<(Expansion, Ledger, [DVector<f64>; 3])> {
        let ones = DVector::from_element(self.shell.weights.len() * self.shell.slices.len(), 1.0);
        let mut hessian = DMatrix::zeros(x.len(), x.len());
        let mut ledger = Ledger::default();
        let [psi, psi_l, a] = [Psi, PsiL, A].map(|field| self.field(field, x));
        let place = map([&psi, &a], |_, [psi, a]: [Jet<2>; 2]| {
            let (sin, cos) = psi.sin_cos();
            Some([a * cos, a * sin])
        })?;
        let [hx, hy] = self.plan(&place.outputs[0], &place.outputs[1]);
        let mut value = 0.0;
        let mut gradient = DVector::zeros(x.len());
        let mut take = |sum: &Field| {
            value += sum.value.sum();
            gradient += sum.tangent.tr_mul(&ones);
        };
        let z;
        if self.terms.stretch.is_some() {
            let rest: Vec<Field> = LINEAR[3..].iter().map(|field| self.field(*field, x)).collect();
            let [psi_s, psi_sl, psi_ll, a_s, a_l, a_sl, a_ll, eta, eta_s, eta_l, eta_ss] = &rest[..] else { return None };
            let inputs = [&psi, &psi_l, psi_ll, &a, a_l, a_ll];
            let source = map(inputs, |_, [psi, psi_l, psi_ll, a, a_l, a_ll]: [Jet<6>; 6]| {
                let (sin, cos) = psi.sin_cos();
                let (turn, inward, along) = (a * psi_l, a_ll - a * psi_l.square(), a_l * psi_l * 2.0 + a * psi_ll);
                Some([a_l * cos - turn * sin, a_l * sin + turn * cos, inward * cos - along * sin, inward * sin + along * cos])
            })?;
            let [h1x, h1y] = self.plan(&source.outputs[0], &source.outputs[1]);
            let [h2x, h2y] = self.plan(&source.outputs[2], &source.outputs[3]);
            let falls = [&h1x, &h1y, &psi, psi_s, &psi_l, psi_sl, &a, a_s, a_l, a_sl, eta, eta_s, eta_ss];
            let fall = map(falls, |_, v: [Jet<13>; 13]| fall(v))?;
            let [c, c_s, c_ss] = &fall.outputs;
            let [height, height_s, height_ss] = [c, c_s, c_ss].map(|field| self.height(field));
            let shapes = [&h1x, &h1y, &h2x, &h2y, &psi, psi_s, &psi_l, &a, a_s, a_l, c, c_s, &height_s, &height_ss, eta, eta_l];
            let shape = map(shapes, |i, v: [Jet<16>; 16]| Some([self.shape(i, v, &mut ledger)]))?;
            take(&shape.outputs[0]);
            let mut back = shape.back(shapes, [&ones], &mut hessian);
            let mut z_back = DVector::zeros(ones.len());
            let (mut hx_back, mut hy_back) = (z_back.clone(), z_back.clone());
            if self.terms.placed() {
                let inputs = [&hx, &hy, &height];
                let density = map(inputs, |i, at: [Jet<3>; 3]| Some([self.terms.placed_density(&self.spot(i), at, &mut ledger)?]))?;
                take(&density.outputs[0]);
                [hx_back, hy_back, z_back] = density.back(inputs, [&ones], &mut hessian);
            }
            let mut c_back = [back[10].clone(), back[11].clone(), DVector::zeros(ones.len())];
            for (out, from) in c_back.iter_mut().zip([&z_back, &back[12], &back[13]]) {
                self.integrate(from.as_slice(), out.as_mut_slice(), true);
            }
            let more = fall.back(falls, [&c_back[0], &c_back[1], &c_back[2]], &mut hessian);
            back[0] += &more[0];
            back[1] += &more[1];
            let adjoint = |x: &DVector<f64>, y: &DVector<f64>| self.kernel([x.as_slice(), y.as_slice()], true).map(DVector::from_vec);
            let ([s1, s2], [s3, s4]) = (adjoint(&back[0], &back[1]), adjoint(&back[2], &back[3]));
            source.back(inputs, [&s1, &s2, &s3, &s4], &mut hessian);
            let [p1, p2] = adjoint(&hx_back, &hy_back);
            place.back([&psi, &a], [&p1, &p2], &mut hessian);
            z = height.value;
        } else {
            let growth = self.shell.growth;
            let inputs = [&psi, &psi_l];
            let source = map(inputs, |i, [psi, psi_l]: [Jet<2>; 2]| {
                let ((sin, cos), turn) = (psi.sin_cos(), psi_l * a.value[i]);
                Some([cos * growth - turn * sin, sin * growth + turn * cos])
            })?;
            let [h1x, h1y] = self.plan(&source.outputs[0], &source.outputs[1]);
            let falls = [&h1x, &h1y];
            let fall = map(falls, |_, [x, y]: [Jet<2>; 2]| {
                let square = (x.square() + y.square()) * -1.0 + 1.0;
                (0.0 < square.value).then(|| [square.sqrt()])
            })?;
            let height = self.height(&fall.outputs[0]);
            let places = [&hx, &hy, &height];
            let density = map(places, |i, at: [Jet<3>; 3]| Some([self.terms.placed_density(&self.spot(i), at, &mut ledger)?]))?;
            take(&density.outputs[0]);
            let [hx_back, hy_back, z_back] = density.back(places, [&ones], &mut hessian);
            let mut c_back = DVector::zeros(ones.len());
            self.integrate(z_back.as_slice(), c_back.as_mut_slice(), true);
            let [x_back, y_back] = fall.back(falls, [&c_back], &mut hessian);
            let adjoint = |x: &DVector<f64>, y: &DVector<f64>| self.kernel([x.as_slice(), y.as_slice()], true).map(DVector::from_vec);
            let [s1, s2] = adjoint(&x_back, &y_back);
            source.back(inputs, [&s1, &s2], &mut hessian);
            let [p1, p2] = adjoint(&hx_back, &hy_back);
            place.back([&psi, &a], [&p1, &p2], &mut hessian);
            z = height.value;
        }
        Some((Expansion { value, gradient, hessian }, ledger, [hx.value, hy.value, z]))
    }

    /// Gravity, bending, shear and stretch of cloth that may stretch, J at node `i`.
    fn shape(&self, i: usize, v: [Jet<16>; 16], ledger: &mut Ledger) -> Jet<16> {
        let [h1x, h1y, h2x, h2y, psi, psi_s, psi_l, a, a_s, a_l, c, c_s, p, r, eta, eta_l] = v;
        let count = self.shell.weights.len();
        let (slice, spot) = (&self.shell.slices[i / count], self.spot(i));
        let mut sum = Jet::constant(0.0);
        let mut add = |term: Term, energy: Jet<16>| {
            ledger.add(term, energy.value);
            sum = sum + energy;
        };
        if let Some(weight) = self.terms.gravity {
            add(Term::Gravity, (c * -1.0 + 1.0) * (weight * slice.below * self.shell.weights[i % count] * slice.weight));
        }
        if let Some(stretch) = &self.terms.stretch {
            add(Term::Stretch, stretch.density(a * (1.0 / slice.ring) - 1.0, eta) * spot.area);
        }
        // In the frame that turns with the ring's tangent: X_σ = (0, A, p), X_ℓ = (x, y, −c).
        let (sin, cos) = psi.sin_cos();
        let (x, y) = (h1x * cos + h1y * sin, h1y * cos - h1x * sin);
        let (e, f, g) = (a.square() + p.square(), a * y - p * c, (eta + 1.0).square());
        if let Some(shear) = &self.terms.shear {
            add(Term::Shear, shear.density(f, e, g) * spot.area);
        }
        if let Some(rigidity) = self.terms.bending {
            let (x2, y2) = (h2x * cos + h2y * sin, h2y * cos - h2x * sin);
            let c_l = ((eta + 1.0) * eta_l - x * x2 - y * y2) / c;
            let normal = [(a * c + p * y) * -1.0, p * x, a * x * -1.0];
            let along = |v: [Jet<16>; 3]| v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2];
            // Second fundamental form, times the length of the normal.
            let (e2, f2, g2) =
                (along([a * (psi_s + 1.0) * -1.0, a_s, r]), along([a * psi_l * -1.0, a_l, c_s * -1.0]), along([x2, y2, c_l * -1.0]));
            let w = e * g - f.square();
            let (m11, m12, m21, m22) = (e2 * g - f * f2, f2 * g - f * g2, e * f2 - f * e2, e * g2 - f * f2);
            let trace = m11.square() + m12 * m21 * 2.0 + m22.square();
            let inverse = w.recip();
            add(Term::Bending, trace * inverse.square() * inverse * (0.5 * rigidity * spot.area));
        }
        sum
    }
}

/// c = −∂z/∂ℓ and its first and second derivative by σ; `None` where a generatrix would have to be longer than its cloth.
fn fall(v: [Jet<13>; 13]) -> Option<[Jet<13>; 3]> {
    let [x, y, psi, psi_s, psi_l, psi_sl, a, a_s, a_l, a_sl, eta, eta_s, eta_ss] = v;
    let long = eta + 1.0;
    let square = long.square() - x.square() - y.square();
    if square.value.is_nan() || square.value <= 0.0 {
        return None;
    }
    let c = square.sqrt();
    let inverse = c.recip();
    let (sin, cos) = psi.sin_cos();
    // q = (A_ℓ + iAψ_ℓ) e^{iψ}: in the frame that turns with σ, ∂_σ x_ℓ = iq and ∂_σσ x_ℓ = iq_σ − q.
    let turn = a * psi_l;
    let q = (a_l * cos - turn * sin, a_l * sin + turn * cos);
    let (re, im) = (a_sl - turn * psi_s, a_l * psi_s + a_s * psi_l + a * psi_sl);
    let q_s = (re * cos - im * sin, re * sin + im * cos);
    let c_s = (long * eta_s - (y * q.0 - x * q.1)) * inverse;
    let bent = y * q_s.0 - x * q_s.1 - x * q.0 - y * q.1;
    let c_ss = (long * eta_ss + eta_s.square() - q.0.square() - q.1.square() - bent - c_s.square()) * inverse;
    Some([c, c_s, c_ss])
}

impl Smooth for GradedTerms {
    /// Energy (J), gradient and Hessian by all unknowns.
    fn expand(&self, x: &DVector<f64>) -> Option<Expansion> {
        let mut counts = self.evaluations.get();
        let expansion = if self.terms.stretch.is_some() {
            let (all, ledger, _) = self.beyond(x)?;
            ledger.count(&mut counts);
            all
        } else {
            let mut own = self.shell.expand(x)?;
            let asked = [(Term::Gravity, self.setup.weight), (Term::Bending, self.setup.rigidity), (Term::Shear, self.setup.shear)];
            asked.iter().for_each(|(term, stiffness)| counts[*term as usize] += usize::from(*stiffness != 0.0));
            if self.beyond_sweep() {
                let (more, ledger, _) = self.beyond(x)?;
                ledger.count(&mut counts);
                own += more;
            }
            own
        };
        self.evaluations.set(counts);
        Some(expansion)
    }
}
