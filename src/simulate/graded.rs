//! The graded shell: least energy over hems of all heights at once, and over fold counts.

use nalgebra::{Cholesky, DVector, SymmetricEigen};

use super::hanging::{above, below, contacts, energies};
use super::{Branch, Cloth, Effort, Folds, Multiplier, Prediction, Termination, ruled};
use crate::error::Error;
use crate::experiment::Skirt;
use crate::model::energy::shear::Shear;
use crate::model::energy::{Gaps, Terms};
use crate::model::field::GradedShape;
use crate::model::graded::{GradedShell, HeightBasis, Setup};
use crate::model::graded_terms::GradedTerms;
use crate::model::tangent::TangentHem;
use crate::numerics::minimize::{Minimum, Options, Smooth, minimize};

/// Harmonics and height modes that are right to some tenths of a millimetre on skirts. Chosen from `hemline study accuracy`: 0.1 mm, on the front of error
/// against time; 4 × 8 would leave 0.02 mm at twice the time, 2 × 4 0.6 mm at half of it.
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
/// Fold counts this close in the coarse energy, relative, are compared in full. Chosen from `hemline study accuracy`: a fiftieth took a fold count that
/// costs more in one scene of forty, a twelfth finds the same as any wider search, for a tenth more evaluations.
const CLOSE: f64 = 0.08;
/// Nodes are doubled until the energy holds to this, relative: a thousandth of a millimetre of hem.
const QUADRATURE: f64 = 1e-6;

/// The same where a wall is in, which is only twice differentiable.
const QUADRATURE_AT_WALLS: f64 = 1e-4;
/// Intervals in half a fold and slices where a wall is in, at least: it is felt over a few millimetres only.
const AT_WALLS: (usize, usize) = (32, 28);

/// The hem of least energy over harmonics × modes unknowns, and over fold counts if they are free.
pub(super) fn predict(
    skirt: &Skirt,
    cloth: &Cloth,
    folds: Folds,
    size: (usize, usize),
    shear: f64,
    effort: &Effort,
) -> Result<Prediction, Error> {
    if !(shear.is_finite() && 0.0 <= shear) {
        return Err(Error::Invalid { quantity: "shear stiffness, N/m", value: shear, allowed: ">= 0" });
    }
    let shear = (0.0 < shear).then(|| Shear::new(shear));
    let terms = Terms { shear, ..Terms::usual(cloth.weight(), cloth.rigidity()) };
    hang(skirt, cloth, &terms, folds, size, effort).map(|hung| hung.prediction)
}

/// A prediction with the shape that it comes from.
pub(super) struct Hung {
    pub prediction: Prediction,
    /// `None` where the cone stays round.
    pub shape: Option<(GradedTerms, DVector<f64>)>,
}

/// The same under any set of terms.
pub(super) fn hang(
    skirt: &Skirt,
    cloth: &Cloth,
    terms: &Terms,
    folds: Folds,
    (harmonics, modes): (usize, usize),
    effort: &Effort,
) -> Result<Hung, Error> {
    if !(1..=MOST.0).contains(&harmonics) {
        return Err(Error::Invalid { quantity: "harmonics", value: harmonics as f64, allowed: "1 to 12 for the graded shell" });
    }
    if !(2..=MOST.1).contains(&modes) {
        return Err(Error::Invalid { quantity: "height modes", value: modes as f64, allowed: "2 to 24" });
    }
    ruled::refuse_disc(skirt)?;
    let mut search = Search { skirt, cloth, terms, effort: *effort, evaluations: 0, counts: [0; 7] };
    let (shell, at_cone) = search.cone()?;
    let cone = shell.ledger(&at_cone).ok_or_else(no_cone)?;
    let round = cone.total();
    // Sixteen intervals resolve three harmonics of folds as deep as cloth makes them; the layer below the waist asks for the slices.
    let (half, slices) = effort.sizes(16.max(6 * harmonics), 20.max(2 * modes + 8));
    let full = search.size((harmonics, modes, half, slices));
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
    if best.branch.folds != 0 && !effort.fixed() && !search.verify(&mut best, full) {
        notes.push(if search.walls() {
            "contact is sharper than the grid: the energy is not resolved to four digits".into()
        } else {
            "the energy is not resolved to six digits: folds this deep are nearly creased, or generatrices nearly horizontal".into()
        });
    }
    tried.sort_by_key(|b| b.asked);
    let radius = if shell.strains() == 0 { skirt.hem_radius().0 } else { shell.curve(&at_cone).radius_range().1 };
    let mut prediction = Prediction {
        fidelity: format!("graded(K = {harmonics}, J = {modes})"),
        folds: 0,
        energy: round,
        energy_unit: "J",
        terms: energies(&cone, terms, search.evaluations, &search.counts),
        hem_radius_min: radius,
        hem_radius_max: radius,
        coefficients: Vec::new(),
        outline: ruled::circle(radius),
        termination: Termination::Round,
        evaluations: search.evaluations,
        branches: tried,
        notes,
        hem: None,
        hem_rms: None,
        multiplier: None,
        turning: None,
        error_estimate: None,
        contacts: Vec::new(),
        screening: None,
        graded: None,
    };
    if best.branch.folds == 0 {
        prediction.contacts = contacts(terms, &shell.gaps(&at_cone));
        return Ok(Hung { prediction, shape: None });
    }
    let gaps = if search.walls() { search.clear(&mut best) } else { Gaps::default() };
    let ledger = best.shell.ledger(&best.minimum.x).ok_or_else(|| Error::Unanswerable("the solution has no finite energy".into()))?;
    let curve = best.curve();
    (prediction.hem_radius_min, prediction.hem_radius_max) = curve.radius_range();
    prediction.folds = best.branch.folds;
    prediction.multiplier = best.shell.length_multiplier(&best.minimum.x).map(|value| Multiplier { value, unit: "N" });
    prediction.energy = ledger.total();
    prediction.terms = energies(&ledger, terms, search.evaluations, &search.counts);
    prediction.coefficients = curve.coefficients().to_vec();
    prediction.outline = curve.outline(ruled::outline_points(best.branch.folds));
    prediction.termination = best.branch.termination;
    prediction.contacts = contacts(terms, &gaps);
    // The surface is that of inextensible cloth.
    prediction.graded = (best.shell.strains() == 0).then(|| best.shape());
    Ok(Hung { prediction, shape: Some((best.shell, best.minimum.x)) })
}

fn no_cone() -> Error {
    Error::Unanswerable("the round cone has no finite energy".into())
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
    shell: GradedTerms,
    minimum: Minimum,
    branch: Branch,
}

impl State {
    /// The hem, its crest on the axis.
    fn curve(&self) -> TangentHem {
        self.shell.curve(&self.minimum.x)
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
    terms: &'a Terms,
    effort: Effort,
    evaluations: usize,
    /// Of each term.
    counts: [usize; 7],
}

impl Search<'_> {
    fn shell(&self, folds: u32, harmonics: usize, modes: usize, half: usize, slices: usize) -> GradedTerms {
        // Over about one gravity length below the waist cloth resists the square-root opening that inextensible rings ask for.
        let width = (self.cloth.gravity_length() / self.skirt.slant_length().0).clamp(1e-4, 1.0);
        let basis = HeightBasis::Layer { width };
        let setup = Setup { weight: 0.0, rigidity: 0.0, shear: 0.0, folds, harmonics, modes, basis, half, slices };
        GradedTerms::new(self.skirt, self.terms, setup)
    }

    fn walls(&self) -> bool {
        self.terms.body.is_some() || self.terms.folds.is_some()
    }

    /// A size, made fine enough for walls.
    fn size(&self, (harmonics, modes, half, slices): Size) -> Size {
        if self.walls() { (harmonics, modes, half.max(AT_WALLS.0), slices.max(AT_WALLS.1)) } else { (harmonics, modes, half, slices) }
    }

    /// The round cone and its strains.
    fn cone(&mut self) -> Result<(GradedTerms, DVector<f64>), Error> {
        if self.terms.stretch.is_none() {
            return Ok((self.shell(2, COARSE.0, COARSE.1, 4, 4 * COARSE.3), DVector::zeros(COARSE.0 * COARSE.1)));
        }
        // No fold is among the unknowns: the cone alone stretches.
        let shell = self.shell(2, 0, 3, 4, 4 * COARSE.3);
        let minimum = minimize(&shell, DVector::zeros(shell.strains()), &Options::default()).ok_or_else(no_cone)?;
        self.evaluations += minimum.evaluations;
        self.counts.iter_mut().zip(shell.evaluations()).for_each(|(sum, more)| *sum += more);
        Ok((shell, minimum.x))
    }

    /// The size of a first solution on the way to `full`.
    fn coarse(&self, full: Size) -> Size {
        let (harmonics, modes, half, slices) = if self.skirt.conicity() < FLAT { COARSE } else { COARSE_FLAT };
        self.size((harmonics.min(full.0), modes.min(full.1), half, slices))
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
                let mut first = DVector::zeros(k * j + shell.strains());
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
    fn descend(&mut self, shell: &GradedTerms, mut start: DVector<f64>) -> Minimum {
        let options = Options { evaluations: EVALUATIONS, ..Options::default() };
        loop {
            let spent = shell.evaluations();
            if let Some(minimum) = minimize(shell, start.clone(), &options) {
                self.evaluations += minimum.evaluations;
                self.counts.iter_mut().zip(shell.evaluations()).zip(spent).for_each(|((sum, now), before)| *sum += now - before);
                return minimum;
            }
            start *= 0.7;
            // The cone itself is within reach: `predict` has seen its energy.
            if start.amax() < 1e-6 {
                start.fill(0.0);
            }
        }
    }

    fn describe(&self, shell: GradedTerms, minimum: Minimum, round: f64) -> State {
        let (asked, harmonics, modes) = (shell.setup().folds, shell.setup().harmonics, shell.setup().modes);
        let sizes = DVector::from_fn(harmonics, |k, _| minimum.x.rows(k * modes, modes).norm());
        // The cone's energy is an integral of smooth functions, but on other nodes than this shell's: a part in 10⁹ tells folds from rounding.
        let folded = 1e-9 * round.abs() < round - minimum.at.value && 1e-6 < sizes.amax();
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
        let rough = self.rough()?;
        self.evaluations += rough.evaluations;
        // Where even the ruled shell, which folds more readily, stays round, its least stable fold count is asked.
        let from = if rough.folds != 0 { rough.folds } else { 3 };
        let coarse = self.coarse(full);
        let mut walked = vec![self.solve(from, coarse, None, round)];
        let mut least = walked[0].branch.energy;
        for direction in [1_i64, -1] {
            let (mut m, mut failures) = (i64::from(from) + direction, 0_u32);
            // A term that resists folds can leave only few of them, far from where the ruled shell has its minimum.
            let (usual, down) = (self.effort.patience, direction < 0 && self.terms.beyond_usual());
            let patience = |least: f64| if down && round <= least { u32::MAX } else { usual };
            while 2 <= m && m <= i64::from(ruled::MOST_FOLDS) && failures < patience(least) {
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
            let close = start.branch.folds != 0 && start.branch.energy <= above(least, self.effort.closeness * CLOSE);
            if !close {
                tried.push(start.branch.clone());
                continue;
            }
            let state = self.solve(start.branch.asked, full, Some(start), round);
            tried.push(state.branch.clone());
            if best.as_ref().is_none_or(|b| state.branch.energy < below(b.branch.energy, 1e-9)) {
                best = Some(state);
            }
        }
        let best = match best {
            Some(best) => best,
            None => walked.swap_remove(0),
        };
        Ok((best, tried))
    }

    /// The ruled shell's answer, from where the walk over fold counts starts.
    fn rough(&self) -> Result<Prediction, Error> {
        // Walls and stretch shift it little, and the walk goes on from there; a weave that resists shear folds far less.
        let terms = Terms { stretch: None, body: None, folds: None, ..*self.terms };
        // What the graded sweep alone has, the walk has always found from the shell of weight and rigidity.
        let usual = Terms { shear: None, ..terms };
        Ok(ruled::hang(self.skirt, self.cloth, &usual, Folds::Auto, 1, &Effort::default())?.prediction)
    }

    /// The gaps on twice the nodes of the solution; where cloth went through a wall between those, the solution is found on these.
    fn clear(&mut self, best: &mut State) -> Gaps {
        let Setup { harmonics, modes, half, slices, .. } = *best.shell.setup();
        let fine = self.shell(best.branch.asked, harmonics, modes, 2 * half, 2 * slices);
        let gaps = fine.gaps(&best.minimum.x);
        if !gaps.closed() {
            return gaps;
        }
        let start = best.minimum.x.clone();
        best.minimum = self.descend(&fine, start);
        best.branch.termination = best.minimum.ending.into();
        best.branch.energy = best.minimum.at.value;
        best.shell = fine;
        best.shell.gaps(&best.minimum.x)
    }

    /// Doubles the nodes until the energy holds; whether it did.
    fn verify(&mut self, best: &mut State, full: Size) -> bool {
        let (harmonics, modes, mut half, mut slices) = full;
        let (rounds, quadrature) = if self.walls() { (1, QUADRATURE_AT_WALLS) } else { (2, QUADRATURE) };
        for _ in 0..rounds {
            (half, slices) = (2 * half, 2 * slices);
            let fine = self.shell(best.branch.asked, harmonics, modes, half, slices);
            let energy = fine.ledger(&best.minimum.x).map(|ledger| ledger.total());
            if energy.is_some_and(|e| (e - best.minimum.at.value).abs() <= quadrature * e.abs()) {
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
    // Strains follow the coefficients, as many in every size.
    let (own, strains) = (from.harmonics * from.modes, alpha.len() - from.harmonics * from.modes);
    let mut out = DVector::zeros(harmonics * modes + strains);
    out.rows_mut(harmonics * modes, strains).copy_from(&alpha.rows(own, strains));
    for k in 0..from.harmonics.min(harmonics) {
        for j in 0..from.modes.min(modes) {
            out[k * modes + j] = alpha[k * from.modes + j];
        }
    }
    out
}
