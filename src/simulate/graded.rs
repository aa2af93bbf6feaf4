//! The graded shell: least energy over hems of all heights at once, and over fold counts.

use nalgebra::{Cholesky, DVector, SymmetricEigen};

use super::{Branch, Cloth, Folds, Multiplier, Prediction, TermEnergy, Termination, ruled};
use crate::error::Error;
use crate::experiment::Skirt;
use crate::model::field::GradedShape;
use crate::model::graded::{GradedShell, HeightBasis, Setup};
use crate::model::tangent::{TangentHem, half_nodes};
use crate::numerics::minimize::{Minimum, Options, Smooth, minimize};

/// Harmonics and height modes that are right to some tenths of a millimetre on skirts.
pub const HARMONICS: usize = 3;
/// See [`HARMONICS`].
pub const MODES: usize = 6;
/// Most harmonics and most height modes that are offered.
const MOST: (usize, usize) = (12, 24);
/// Harmonics, modes, intervals and slices.
type Size = (usize, usize, usize, usize);

/// Size of the search over fold counts: energy differences between fold counts are right to a percent.
const COARSE: Size = (1, 3, 12, 10);
/// The same for flat cones, whose folds are too deep for one harmonic.
const COARSE_FLAT: Size = (3, 5, 24, 16);
/// Conicity from which a cone is flat in this sense.
const FLAT: f64 = 0.5;
/// Evaluations per minimization. Newton takes about six; where generatrices press against the horizontal it crawls, and more would not help.
const EVALUATIONS: u64 = 60;
/// Fold counts this close in the coarse energy, relative, are compared in full.
const CLOSE: f64 = 0.02;
/// Nodes are doubled until the energy holds to this, relative: a thousandth of a millimetre of hem.
const QUADRATURE: f64 = 1e-6;

/// The hem of least energy over harmonics × modes unknowns, and over fold counts if they are free.
pub(super) fn predict(skirt: &Skirt, cloth: &Cloth, folds: Folds, harmonics: usize, modes: usize, shear: f64) -> Result<Prediction, Error> {
    if !(1..=MOST.0).contains(&harmonics) {
        return Err(Error::Invalid { quantity: "harmonics", value: harmonics as f64, allowed: "1 to 12 for the graded shell" });
    }
    if !(2..=MOST.1).contains(&modes) {
        return Err(Error::Invalid { quantity: "height modes", value: modes as f64, allowed: "2 to 24" });
    }
    if !(shear.is_finite() && 0.0 <= shear) {
        return Err(Error::Invalid { quantity: "shear stiffness, N/m", value: shear, allowed: ">= 0" });
    }
    ruled::refuse_disc(skirt)?;
    let mut search = Search { skirt, cloth, shear, evaluations: 0 };
    let cone = search
        .shell(2, COARSE.0, COARSE.1, 4, 4 * COARSE.3)
        .budget(&DVector::zeros(COARSE.0 * COARSE.1))
        .ok_or_else(|| Error::Unanswerable("the round cone has no finite energy".into()))?;
    let round = cone.gravity + cone.bending;
    // Sixteen intervals resolve three harmonics of folds as deep as cloth makes them; the layer below the waist asks for the slices.
    let full = (harmonics, modes, 16.max(6 * harmonics), 20.max(2 * modes + 8));
    let mut notes = Vec::new();
    let (mut best, mut tried) = match folds {
        Folds::Exactly(m) => {
            let state = search.solve(m, full, None, round);
            let branch = state.branch.clone();
            (state, vec![branch])
        }
        Folds::Auto => search.least(full, round)?,
    };
    let asked = best.branch.asked;
    if best.branch.folds != 0 && best.branch.folds != asked {
        notes.push(format!("{asked} folds are not stable: the branch slides to {} folds", best.branch.folds));
        best = search.solve(best.branch.folds, full, None, round);
    }
    if let Folds::Exactly(m) = folds
        && best.branch.folds == 0
    {
        notes.push(format!("the round cone is stable against {m} folds: the cloth is too stiff for them"));
    }
    if best.branch.folds != 0 && !search.verify(&mut best, full) {
        notes
            .push("the energy is not resolved to six digits: folds this deep are nearly creased, or generatrices nearly horizontal".into());
    }
    tried.sort_by_key(|b| b.asked);
    let terms = |gravity: f64, bending: f64, shearing: f64, evaluations: usize| {
        let term = |term: &'static str, energy: f64| TermEnergy { term, energy, evaluations };
        let mut terms = vec![term("gravity", gravity), term("bending", bending)];
        if 0.0 < shear {
            terms.push(term("shear", shearing));
        }
        terms
    };
    let mut prediction = Prediction {
        fidelity: format!("graded(K = {harmonics}, J = {modes})"),
        folds: 0,
        energy: round,
        energy_unit: "J",
        terms: terms(cone.gravity, cone.bending, 0.0, search.evaluations),
        hem_radius_min: skirt.hem_radius().0,
        hem_radius_max: skirt.hem_radius().0,
        coefficients: Vec::new(),
        outline: ruled::circle(skirt.hem_radius().0),
        termination: Termination::Round,
        evaluations: search.evaluations,
        branches: tried,
        notes,
        hem: None,
        hem_rms: None,
        multiplier: None,
        turning: None,
        error_estimate: None,
        graded: None,
    };
    if best.branch.folds != 0 {
        let budget = best.shell.budget(&best.minimum.x).ok_or_else(|| Error::Unanswerable("the solution has no finite energy".into()))?;
        let curve = best.curve();
        (prediction.hem_radius_min, prediction.hem_radius_max) = curve.radius_range();
        prediction.folds = best.branch.folds;
        prediction.graded = Some(best.shape());
        prediction.multiplier = best.shell.length_multiplier(&best.minimum.x).map(|value| Multiplier { value, unit: "N" });
        prediction.energy = budget.gravity + budget.bending + budget.shear;
        prediction.terms = terms(budget.gravity, budget.bending, budget.shear, search.evaluations);
        prediction.coefficients = curve.coefficients().to_vec();
        prediction.outline = curve.outline(ruled::outline_points(best.branch.folds));
        prediction.termination = best.branch.termination;
    }
    Ok(prediction)
}

/// Flexural rigidity (N·m) above which the round cone is stable against `folds` folds of the graded shell; `None` if it is stable at any.
///
/// Second variation at the cone, `H_g + B H_b`: the largest B at which it is singular. `weight` is ρ_A g, N/m²; `shear` is S, N/m.
pub fn threshold_rigidity(skirt: &Skirt, weight: f64, shear: f64, folds: u32) -> Option<f64> {
    // Eight modes of a layer of a thirtieth of the slant converge to four digits; the buckling mode itself has no thinner layer.
    let modes = 8;
    let variation = |weight: f64, rigidity: f64, shear: f64| {
        let basis = HeightBasis::Layer { width: 1.0 / 30.0 };
        let setup = Setup { weight, rigidity, shear, folds, harmonics: 1, modes, basis, half: 12, slices: 24 };
        Some(GradedShell::new(skirt, setup).expand(&DVector::zeros(modes))?.hessian)
    };
    let bending = Cholesky::new(variation(0.0, 1.0, 0.0)?)?;
    let rest = variation(weight, 0.0, shear)?;
    // B is an eigenvalue of −H_b⁻¹ H_g, brought to symmetric form by the factor of H_b.
    let half = bending.l().solve_lower_triangular(&rest)?;
    let symmetric = bending.l().solve_lower_triangular(&half.transpose())?;
    let largest = -SymmetricEigen::new(symmetric).eigenvalues.min();
    (0.0 < largest).then_some(largest)
}

struct State {
    shell: GradedShell,
    minimum: Minimum,
    branch: Branch,
}

impl State {
    /// The hem, its crest on the axis.
    fn curve(&self) -> TangentHem {
        let mut hem = self.shell.hem_coefficients(&self.minimum.x);
        // A shift by half a fold flips the odd coefficients together.
        if hem[0] < 0.0 {
            hem.iter_mut().step_by(2).for_each(|a| *a = -*a);
        }
        TangentHem::new(self.branch.asked, self.shell.hem_radius(), hem.as_slice(), 2 * half_nodes(hem.len()))
    }
}

impl State {
    /// The whole shell, its crest on the axis.
    fn shape(&self) -> GradedShape {
        let setup = *self.shell.setup();
        let flip = self.shell.hem_coefficients(&self.minimum.x)[0] < 0.0;
        // As in `curve`: a shift by half a fold flips the odd coefficients together.
        let sign = |i: usize| if flip && (i / setup.modes).is_multiple_of(2) { -1.0 } else { 1.0 };
        GradedShape { setup, alpha: self.minimum.x.iter().enumerate().map(|(i, a)| sign(i) * a).collect() }
    }
}

struct Search<'a> {
    skirt: &'a Skirt,
    cloth: &'a Cloth,
    shear: f64,
    evaluations: usize,
}

impl Search<'_> {
    fn shell(&self, folds: u32, harmonics: usize, modes: usize, half: usize, slices: usize) -> GradedShell {
        // Over about one gravity length below the waist cloth resists the square-root opening that inextensible rings ask for.
        let width = (self.cloth.gravity_length() / self.skirt.slant_length().0).clamp(1e-4, 1.0);
        let setup = Setup {
            weight: self.cloth.weight(),
            rigidity: self.cloth.rigidity(),
            shear: self.shear,
            folds,
            harmonics,
            modes,
            basis: HeightBasis::Layer { width },
            half,
            slices,
        };
        GradedShell::new(self.skirt, setup)
    }

    /// The size of a first solution on the way to `full`.
    fn coarse(&self, full: Size) -> Size {
        let (harmonics, modes, half, slices) = if self.skirt.conicity() < FLAT { COARSE } else { COARSE_FLAT };
        (harmonics.min(full.0), modes.min(full.1), half, slices)
    }

    /// The branch of `folds` folds: a few modes first, then all; or from `start` (harmonics, modes, coefficients).
    fn solve(&mut self, folds: u32, size: Size, start: Option<&State>, round: f64) -> State {
        let (harmonics, modes, half, slices) = size;
        let mut state = match start {
            Some(start) => {
                let shell = self.shell(folds, harmonics, modes, half, slices);
                let padded = pad(&start.minimum.x, start.shell.setup(), harmonics, modes);
                let minimum = self.descend(&shell, padded);
                self.describe(shell, minimum, round)
            }
            None => {
                let (k, j, half, slices) = self.coarse(size);
                let shell = self.shell(folds, k, j, half, slices);
                let mut first = DVector::zeros(k * j);
                first[0] = 1.0;
                let minimum = self.descend(&shell, first);
                self.describe(shell, minimum, round)
            }
        };
        let reached = state.shell.setup();
        if (reached.harmonics, reached.modes, reached.half) != (harmonics, modes, half) {
            state = self.solve(folds, size, Some(&state), round);
        }
        state
    }

    /// Downhill from `start`, drawn in towards the cone until every generatrix is long enough.
    fn descend(&mut self, shell: &GradedShell, mut start: DVector<f64>) -> Minimum {
        let options = Options { evaluations: EVALUATIONS, ..Options::default() };
        loop {
            if let Some(minimum) = minimize(shell, start.clone(), &options) {
                self.evaluations += minimum.evaluations;
                return minimum;
            }
            start *= 0.7;
            // The cone itself is within reach: `predict` has seen its energy.
            if start.amax() < 1e-6 {
                start.fill(0.0);
            }
        }
    }

    fn describe(&self, shell: GradedShell, minimum: Minimum, round: f64) -> State {
        let (asked, harmonics, modes) = (shell.setup().folds, shell.setup().harmonics, shell.setup().modes);
        let sizes = DVector::from_fn(harmonics, |k, _| minimum.x.rows(k * modes, modes).norm());
        // The cone's energy is an integral of smooth functions, but on other nodes than this shell's: a part in 10⁹ tells folds from rounding.
        let folded = 1e-9 * round < round - minimum.at.value && 1e-6 < sizes.amax();
        let branch = Branch {
            asked,
            folds: if folded { asked * ruled::period(&sizes) } else { 0 },
            harmonics: Some(harmonics),
            energy: if folded { minimum.at.value } else { round },
            depth: 0.0,
            threshold_rigidity: None,
            lowest_curvature: Some(minimum.lowest_curvature()),
            termination: if folded { minimum.ending.into() } else { Termination::Round },
        };
        let mut state = State { shell, minimum, branch };
        if folded {
            let (low, high) = state.curve().radius_range();
            state.branch.depth = high - low;
        }
        state
    }

    /// The branch of least energy: a coarse walk over fold counts from where the ruled shell has its minimum, then the close ones in full.
    fn least(&mut self, full: Size, round: f64) -> Result<(State, Vec<Branch>), Error> {
        let rough = ruled::predict(self.skirt, self.cloth, Folds::Auto, 1)?;
        self.evaluations += rough.evaluations;
        // Where even the ruled shell, which folds more readily, stays round, its least stable fold count is asked.
        let from = if rough.folds != 0 { rough.folds } else { 3 };
        let coarse = self.coarse(full);
        let mut walked = vec![self.solve(from, coarse, None, round)];
        let mut least = walked[0].branch.energy;
        for direction in [1_i64, -1] {
            let (mut m, mut failures) = (i64::from(from) + direction, 0);
            while 2 <= m && m <= i64::from(ruled::MOST_FOLDS) && failures < 2 {
                let state = self.solve(m as u32, coarse, None, round);
                if state.branch.folds != 0 && state.branch.energy < least {
                    (least, failures) = (state.branch.energy, 0);
                } else {
                    failures += 1;
                }
                walked.push(state);
                m += direction;
            }
        }
        let mut tried: Vec<Branch> = Vec::new();
        let mut best: Option<State> = None;
        for start in &walked {
            let close = start.branch.folds != 0 && start.branch.energy <= least * (1.0 + CLOSE);
            if !close {
                tried.push(start.branch.clone());
                continue;
            }
            let state = self.solve(start.branch.asked, full, Some(start), round);
            tried.push(state.branch.clone());
            if best.as_ref().is_none_or(|b| state.branch.energy < b.branch.energy * (1.0 - 1e-9)) {
                best = Some(state);
            }
        }
        let best = match best {
            Some(best) => best,
            None => walked.swap_remove(0),
        };
        Ok((best, tried))
    }

    /// Doubles the nodes until the energy holds; whether it did.
    fn verify(&mut self, best: &mut State, full: Size) -> bool {
        let (harmonics, modes, mut half, mut slices) = full;
        for _ in 0..2 {
            (half, slices) = (2 * half, 2 * slices);
            let fine = self.shell(best.branch.asked, harmonics, modes, half, slices);
            let energy = fine.budget(&best.minimum.x).map(|b| b.gravity + b.bending + b.shear);
            if energy.is_some_and(|e| (e - best.minimum.at.value).abs() <= QUADRATURE * e) {
                return true;
            }
            let start = best.minimum.x.clone();
            let minimum = self.descend(&fine, start);
            best.branch.termination = minimum.ending.into();
            best.branch.energy = minimum.at.value;
            (best.minimum, best.shell) = (minimum, fine);
        }
        false
    }
}

/// Coefficients of a smaller expansion as those of a larger one.
fn pad(alpha: &DVector<f64>, from: &Setup, harmonics: usize, modes: usize) -> DVector<f64> {
    let mut out = DVector::zeros(harmonics * modes);
    for k in 0..from.harmonics.min(harmonics) {
        for j in 0..from.modes.min(modes) {
            out[k * modes + j] = alpha[k * from.modes + j];
        }
    }
    out
}
