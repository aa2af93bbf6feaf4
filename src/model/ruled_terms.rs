//! The ruled shell under any set of terms: weight and rigidity as in `tangent`, everything else added, each where the cloth is.
//!
//! Unknowns are a_1 … a_K; where rings and generatrices may stretch, the strains of hem and generatrix, `ε = Σ e_k cos kmσ` and `η = Σ g_k cos kmσ`,
//! stand before them: `c' = i R_n (1 + ε) e^{i(σ + ψ)}`, generatrices of length L(1 + η). Without them nothing here is evaluated that is not in.

use std::cell::Cell;
use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use super::energy::{Gaps, Ledger, Spot, Terms};
use super::tangent::{Budget, RuledShell, TangentHem, per_length};
use crate::experiment::Skirt;
use crate::experiment::scene::Term;
use crate::numerics::jet::Jet;
use crate::numerics::layers::{Field, map};
use crate::numerics::minimize::{Expansion, Smooth};
use crate::numerics::quadrature::gauss_legendre;

/// Harmonics of each strain, with the mean: tension along a fold is smoother than the fold.
const STRAINS: usize = 4;

/// A ruled shell of `folds` folds, discretized.
#[derive(Debug, Clone)]
pub struct RuledTerms {
    /// Of the inextensible hem; without weight and rigidity where the hem may stretch.
    shell: RuledShell,
    terms: Terms,
    slant: f64,
    /// Fraction u, cut radius, and weight of dA per radian (m²) along the slant.
    slices: Vec<(f64, f64, f64)>,
    /// cos kφ_n and its derivative by σ, k from 0; no columns where nothing stretches.
    cosines: [DMatrix<f64>; 2],
    /// Strain per unknown, rings and generatrices.
    scales: (f64, f64),
    /// Per radian, m²: what ε² and η² at the hem stand for along the slant, `∫ (u R_n/R)² R dℓ` and `∫ R dℓ`.
    charged: (f64, f64),
    evaluations: Cell<[usize; 7]>,
}

impl RuledTerms {
    /// `half` intervals in half a fold, `slices` nodes along the slant.
    pub fn new(skirt: &Skirt, terms: &Terms, folds: u32, harmonics: usize, half: usize, slices: usize) -> Self {
        let (waist, hem, slant) = (skirt.waist_radius().0, skirt.hem_radius().0, skirt.slant_length().0);
        let own = if terms.stretch.is_some() { (None, None) } else { (terms.gravity, terms.bending) };
        let strains = if terms.stretch.is_some() { STRAINS } else { 0 };
        let m = f64::from(folds);
        let angle = |n: usize, k: usize| (PI * (n * k) as f64 / half as f64).sin_cos();
        let nodes = if terms.beyond_usual() { slices } else { 0 };
        let slice = |(u, w): (f64, f64)| {
            let ring = waist + u * (hem - waist);
            (u, ring, w * ring * slant)
        };
        let slices_of_slant: Vec<(f64, f64, f64)> = gauss_legendre(nodes).into_iter().map(slice).collect();
        let over = |f: &dyn Fn(f64, f64) -> f64| slices_of_slant.iter().map(|(u, ring, measure)| f(*u, *ring) * measure).sum();
        RuledTerms {
            shell: RuledShell::with(skirt, own, folds, harmonics, half, slices),
            terms: *terms,
            slant,
            charged: (over(&|u, ring| (u * hem / ring).powi(2)), over(&|_, _| 1.0)),
            slices: slices_of_slant,
            cosines: [
                DMatrix::from_fn(half + 1, strains, |n, k| angle(n, k).1),
                DMatrix::from_fn(half + 1, strains, |n, k| -m * k as f64 * angle(n, k).0),
            ],
            scales: terms.stretch.map_or((0.0, 0.0), |stretch| stretch.scales(terms.gravity.unwrap_or(1.0) * slant)),
            evaluations: Cell::new([0; 7]),
        }
    }

    pub fn folds(&self) -> u32 {
        self.shell.folds()
    }

    /// How many unknowns stand before a_1.
    pub fn strains(&self) -> usize {
        RuledTerms::strains_under(&self.terms)
    }

    /// How many unknowns stand before a_1 under `terms`.
    pub fn strains_under(terms: &Terms) -> usize {
        if terms.stretch.is_some() { 2 * STRAINS } else { 0 }
    }

    /// How often each term was evaluated with its derivatives, in the order of [`Term::ALL`].
    pub fn evaluations(&self) -> [usize; 7] {
        self.evaluations.get()
    }

    /// a_1 … a_K of the unknowns.
    pub fn coefficients(&self, x: &DVector<f64>) -> DVector<f64> {
        x.rows(self.strains(), x.len() - self.strains()).into_owned()
    }

    /// Energy of each term; `None` where the cloth cannot be.
    pub fn ledger(&self, x: &DVector<f64>) -> Option<Ledger> {
        let budget = self.shell.budget(&self.coefficients(x))?;
        let mut ledger = if self.terms.beyond_usual() { self.beyond(x)?.1 } else { Ledger::default() };
        ledger.add(Term::Gravity, budget.gravity);
        ledger.add(Term::Bending, budget.bending);
        Some(ledger)
    }

    /// Weight and bending alone, J.
    pub fn budget(&self, x: &DVector<f64>) -> Option<Budget> {
        let ledger = self.ledger(x)?;
        Some(Budget { gravity: ledger.of(Term::Gravity), bending: ledger.of(Term::Bending) })
    }

    /// The multiplier of the hem's length, N, as [`RuledShell::length_multiplier`]; `None` where the hem may stretch: then its tension does its work.
    pub fn length_multiplier(&self, x: &DVector<f64>) -> Option<f64> {
        if self.terms.stretch.is_some() {
            return None;
        }
        let own = self.shell.length_multiplier(x)?;
        if !self.terms.beyond_usual() {
            return Some(own);
        }
        Some(own + per_length(self.shell.hem, |by| self.lengthened(by).beyond(x).map(|(all, _)| all.value))?)
    }

    /// The same cloth, none of it stretching, with its hem's radius grown by `by`, m.
    pub fn lengthened(&self, by: f64) -> RuledTerms {
        RuledTerms { shell: self.shell.lengthened(by), ..self.clone() }
    }

    /// The hem.
    pub fn curve(&self, x: &DVector<f64>) -> TangentHem {
        let strains: Vec<f64> = x.rows(0, self.strains() / 2).iter().map(|e| e * self.scales.0).collect();
        let a = self.coefficients(x);
        TangentHem::stretched(self.shell.folds, self.shell.hem, a.as_slice(), &strains, self.shell.weights.len() - 1)
    }

    /// Smallest distances to the body and between folds, over the nodes.
    pub fn gaps(&self, x: &DVector<f64>) -> Gaps {
        let mut gaps = Gaps::default();
        let [psi, _, eps, _, eta, _] = self.fields(x);
        let count = psi.value.len();
        let source = |n: usize| {
            let (sin, cos) = psi.value[n].sin_cos();
            let length = 1.0 + eps.value[n];
            (length * cos, length * sin)
        };
        let hem = &self.shell.kernel * DVector::from_fn(2 * count, |i, _| if i < count { source(i).0 } else { source(i - count).1 });
        for n in 0..count {
            let (hx, hy) = (hem[n], hem[count + n]);
            let lean = (hx - self.shell.waist).powi(2) + hy * hy;
            let fall = ((self.slant * (1.0 + eta.value[n])).powi(2) - lean).max(0.0).sqrt();
            // The hem itself is no node of the quadrature, and it is where folds come nearest.
            let rings = self.slices.iter().map(|(u, ring, _)| (*u, *ring)).chain([(1.0, self.shell.hem)]);
            for (u, ring) in rings {
                let spot = Spot { folds: self.shell.folds, sigma: self.sigma(n), ring, area: 0.0 };
                gaps.see(&self.terms, &spot, [(1.0 - u) * self.shell.waist + u * hx, u * hy, -u * fall]);
            }
        }
        gaps
    }

    fn sigma(&self, n: usize) -> f64 {
        PI * n as f64 / (self.shell.weights.len() - 1) as f64 / f64::from(self.shell.folds)
    }

    /// ψ, ψ', ε, ε', η, η' at the nodes.
    fn fields(&self, x: &DVector<f64>) -> [Field; 6] {
        let (before, unknowns, count) = (self.strains(), x.len(), self.shell.weights.len());
        let place = |table: &DMatrix<f64>, from: usize, scale: f64| {
            let mut tangent = DMatrix::zeros(count, unknowns);
            tangent.columns_mut(from, table.ncols()).copy_from(&(table * scale));
            Field::linear(0.0, &tangent, x)
        };
        let [cosines, slopes] = &self.cosines;
        let (rings, generatrices) = self.scales;
        [
            place(&self.shell.sines, before, 1.0),
            place(&self.shell.slopes, before, 1.0),
            place(cosines, 0, rings),
            place(slopes, 0, rings),
            place(cosines, before / 2, generatrices),
            place(slopes, before / 2, generatrices),
        ]
    }

    /// Everything that the inextensible shell of weight and rigidity does not have.
    fn beyond(&self, x: &DVector<f64>) -> Option<(Expansion, Ledger)> {
        let unknowns = x.len();
        let fields = self.fields(x);
        let [psi, slope, eps, eps_s, eta, eta_s] = &fields;
        let count = psi.value.len();
        let source = map([psi, eps], |_, [psi, eps]| {
            let ((sin, cos), length) = (psi.sin_cos(), eps + 1.0);
            Some([cos * length, sin * length])
        })?;
        let stacked = |part: &dyn Fn(&Field) -> DMatrix<f64>| {
            let [re, im] = &source.outputs;
            let mut both = DMatrix::zeros(2 * count, part(re).ncols());
            both.rows_mut(0, count).copy_from(&part(re));
            both.rows_mut(count, count).copy_from(&part(im));
            &self.shell.kernel * both
        };
        let value = stacked(&|field| DMatrix::from_column_slice(count, 1, field.value.as_slice()));
        let tangent = stacked(&|field| field.tangent.clone());
        let [hx, hy] = [0, count]
            .map(|at| Field { value: value.column(0).rows(at, count).into_owned(), tangent: tangent.rows(at, count).into_owned() });
        let mut ledger = Ledger::default();
        let ones = DVector::from_element(count, 1.0);
        let mut hessian = DMatrix::zeros(unknowns, unknowns);
        let zero = || Jet::constant(0.0);
        let (sum, hx_back, hy_back) = if self.terms.stretch.is_some() {
            let inputs = [&hx, &hy, psi, slope, eps, eps_s, eta, eta_s];
            let density = map(inputs, |n, v: [Jet<8>; 8]| Some([self.density(n, v, &mut ledger)?]))?;
            let [hx_back, hy_back, ..] = density.back(inputs, [&ones], &mut hessian);
            let [sum] = density.outputs;
            (sum, hx_back, hy_back)
        } else {
            let inputs = [&hx, &hy, psi];
            let density = map(inputs, |n, [x, y, psi]: [Jet<3>; 3]| {
                Some([self.density(n, [x, y, psi, zero(), zero(), zero(), zero(), zero()], &mut ledger)?])
            })?;
            let [hx_back, hy_back, _] = density.back(inputs, [&ones], &mut hessian);
            let [sum] = density.outputs;
            (sum, hx_back, hy_back)
        };
        let back = self.shell.kernel.tr_mul(&DVector::from_fn(2 * count, |i, _| if i < count { hx_back[i] } else { hy_back[i - count] }));
        let [re_back, im_back] = [0, count].map(|at| back.rows(at, count).into_owned());
        source.back([psi, eps], [&re_back, &im_back], &mut hessian);
        Some((Expansion { value: sum.value.sum(), gradient: sum.tangent.tr_mul(&ones), hessian }, ledger))
    }

    /// Energy of node `n` (J) from h, ψ, ψ', ε, ε', η, η' there.
    fn density<const N: usize>(&self, n: usize, v: [Jet<N>; 8], ledger: &mut Ledger) -> Option<Jet<N>> {
        let [hx, hy, psi, slope, eps, eps_s, eta, eta_s] = v;
        let (terms, slant, waist, hem, around) = (&self.terms, self.slant, self.shell.waist, self.shell.hem, self.shell.weights[n]);
        let (dx, square) = (hx - waist, slant * slant);
        let (length, long) = (eps + 1.0, eta + 1.0);
        let lean = dx.square() + hy.square();
        let fall_squared = long.square() * square - lean;
        if fall_squared.value.is_nan() || fall_squared.value <= 0.0 {
            return None;
        }
        let fall = fall_squared.sqrt();
        let zero = Jet::constant(0.0);
        let mut sum = zero;
        let add = |sum: &mut Jet<N>, ledger: &mut Ledger, term: Term, energy: Jet<N>| {
            ledger.add(term, energy.value);
            *sum = *sum + energy;
        };
        let stretched = terms.stretch.is_some();
        if stretched && let Some(weight) = terms.gravity {
            // L − √((1 + η)² L² − |d|²), without the cancellation.
            let rise = (lean - (eta * 2.0 + eta.square()) * square) / (fall + slant);
            let factor = around * weight * slant * (0.5 * waist + (hem - waist) / 3.0);
            add(&mut sum, ledger, Term::Gravity, rise * factor);
        }
        if stretched && let Some(rigidity) = terms.bending {
            // Local in four of the variables: the sum over the slant is taken in those.
            let four: [Jet<4>; 4] = std::array::from_fn(|a| Jet::variable([psi, slope, eps, eps_s][a].value, a));
            add(&mut sum, ledger, Term::Bending, Jet::compose(&self.turning(four), &[psi, slope, eps, eps_s]) * (rigidity * around));
        }
        if let Some(stretch) = &terms.stretch {
            let (rings, area) = self.charged;
            add(&mut sum, ledger, Term::Stretch, (stretch.density(eps, zero) * rings + stretch.density(zero, eta) * area) * around);
        }
        let (sin, cos) = if terms.shear.is_some() { psi.sin_cos() } else { (zero, zero) };
        // How the fall changes along the hem.
        let fall_s = if terms.shear.is_some() {
            let tangent = length * hem;
            (long * eta_s * square - (hy * (tangent * cos - waist) - dx * tangent * sin)) / fall
        } else {
            zero
        };
        if terms.shear.is_none() && !terms.placed() {
            return Some(sum);
        }
        for &(u, ring, measure) in &self.slices {
            let area = measure * around;
            let spot = Spot { folds: self.shell.folds, sigma: self.sigma(n), ring, area };
            let p = (1.0 - u) * waist;
            if let Some(shear) = &terms.shear {
                let q = length * (u * hem);
                let speed_squared = q * cos * (2.0 * p) + q.square() + p * p;
                // Times L: both F and the generatrix's own length.
                let cross = hy * waist + long * eta_s * (u * square);
                let along = speed_squared + (fall_s * u).square();
                add(&mut sum, ledger, Term::Shear, shear.density(cross, along, long.square() * square) * area);
            }
            if terms.placed() {
                sum = sum + terms.placed_density(&spot, [hx * u + p, hy * u, fall * -u], ledger)?;
            }
        }
        Some(sum)
    }

    /// ∫ κ²/2 dA per radian from ψ, ψ', ε, ε'.
    fn turning<const N: usize>(&self, [psi, slope, eps, eps_s]: [Jet<N>; 4]) -> Jet<N> {
        let (waist, hem, length) = (self.shell.waist, self.shell.hem, eps + 1.0);
        let (sin, cos) = psi.sin_cos();
        let (straight, square, sideways) = (length * cos, length.square(), eps_s * sin);
        let mut sum = Jet::constant(0.0);
        for &(u, _, measure) in &self.slices {
            let (p, q) = ((1.0 - u) * waist, u * hem);
            let (pq, qq) = (straight * (p * q), square * (q * q));
            let speed_squared = pq * 2.0 + qq + p * p;
            let turning = speed_squared + slope * (pq + qq) + sideways * (p * q);
            let inverse = speed_squared.recip();
            sum = sum + (turning * inverse).square() * inverse * (0.5 * measure);
        }
        sum
    }
}

impl Smooth for RuledTerms {
    /// Energy (J), gradient and Hessian by all unknowns.
    fn expand(&self, x: &DVector<f64>) -> Option<Expansion> {
        let mut counts = self.evaluations.get();
        let expansion = if self.terms.stretch.is_some() {
            let (all, ledger) = self.beyond(x)?;
            ledger.count(&mut counts);
            all
        } else {
            let mut own = self.shell.expand(x)?;
            counts[Term::Gravity as usize] += usize::from(self.shell.has().0);
            counts[Term::Bending as usize] += usize::from(self.shell.has().1);
            if self.terms.beyond_usual() {
                let (more, ledger) = self.beyond(x)?;
                ledger.count(&mut counts);
                own += more;
            }
            own
        };
        self.evaluations.set(counts);
        Some(expansion)
    }
}
