//! The ruled shell: least energy over the tangent-angle family, and over fold counts.

use nalgebra::DVector;

use super::hanging::{above, below, contacts, energies};
use super::{Branch, Cloth, Effort, Folds, Multiplier, Prediction, Termination};
use crate::error::Error;
use crate::experiment::{Point, Skirt};
use crate::model::energy::bending::Bending;
use crate::model::energy::gravity::Gravity;
use crate::model::energy::{Gaps, Terms};
use crate::model::ruled_terms::RuledTerms;
use crate::model::tangent::{TangentHem, half_nodes};
use crate::numerics::minimize::{Minimum, Options, minimize};

/// Harmonics unless told otherwise: the hem is then right to a few hundredths of a millimetre, far inside what the theory neglects. Chosen from `hemline
/// study accuracy`: 10⁻⁴ mm on the skirt of docs/model.md, and nothing as accurate is cheaper; four would leave 0.02 mm and save a third.
pub const HARMONICS: usize = 8;
/// Most harmonics that are offered: beyond a dozen a smooth hem gains nothing, a nearly creased one is outside the theory.
pub const MOST_HARMONICS: usize = 32;
/// Most folds that are searched: finer folds than these are narrower than cloth is thick.
pub const MOST_FOLDS: u32 = 512;
/// Points of a predicted outline, about: a fifth of a degree of cloth.
pub(super) const OUTLINE: usize = 720;
/// Nodes are doubled until the energy holds to this, relative.
const QUADRATURE: f64 = 1e-11;
/// A branch that gains less than this over the round cone, relative, is the round cone.
pub(super) const ROUNDING: f64 = 1e-14;

/// Nodes are doubled until the energy holds to this where a wall is in, which is only twice differentiable.
const QUADRATURE_AT_WALLS: f64 = 1e-5;
/// A branch that gains less than this over the round cone is the round cone, where more than weight and rigidity is in.
const ROUNDING_OF_TERMS: f64 = 1e-11;

/// The hem of least energy over `harmonics` coefficients, and over fold counts if they are free.
pub(super) fn predict(skirt: &Skirt, cloth: &Cloth, folds: Folds, harmonics: usize, effort: &Effort) -> Result<Prediction, Error> {
    hang(skirt, cloth, &Terms::usual(cloth.weight(), cloth.rigidity()), folds, harmonics, effort).map(|hung| hung.prediction)
}

/// A prediction with the shape that it comes from.
pub(super) struct Hung {
    pub prediction: Prediction,
    /// `None` where the cone stays round.
    pub shape: Option<(RuledTerms, DVector<f64>)>,
}

/// The same under any set of terms.
pub(super) fn hang(skirt: &Skirt, cloth: &Cloth, terms: &Terms, folds: Folds, harmonics: usize, effort: &Effort) -> Result<Hung, Error> {
    if !(1..=MOST_HARMONICS).contains(&harmonics) {
        return Err(Error::Invalid { quantity: "harmonics", value: harmonics as f64, allowed: "1 to 32" });
    }
    refuse_disc(skirt)?;
    let mut search = Search { skirt, cloth, terms, effort: *effort, evaluations: 0, counts: [0; 7] };
    let (cone, at_cone) = search.cone()?;
    let round = cone.ledger(&at_cone).ok_or_else(no_cone)?;
    let round_energy = round.total();
    let (mut tried, mut notes) = (Vec::new(), notes_on(skirt, cloth));
    let mut best = match folds {
        Folds::Exactly(m) => {
            let state = search.solve(m, harmonics, None, round_energy);
            tried.push(state.branch.clone());
            state
        }
        Folds::Auto => search.least(harmonics, round_energy, &mut tried, &mut notes),
    };
    // A slid solution is a solution of its true period; solve it there, with all harmonics its own.
    let asked = best.branch.asked;
    if best.branch.folds != 0 && best.branch.folds != asked && best.branch.folds <= MOST_FOLDS {
        notes.push(format!("{asked} folds are not stable: the branch slides to {} folds", best.branch.folds));
        best = search.solve(best.branch.folds, harmonics, Some(&best.canonical()), round_energy);
    }
    if let Folds::Exactly(m) = folds
        && best.branch.termination == Termination::Round
    {
        notes.push(format!("the round cone is stable against {m} folds: the cloth is too stiff for them"));
    }
    tried.sort_by_key(|b| b.asked);
    if best.branch.termination == Termination::Round {
        let curve = cone.curve(&at_cone);
        let radius = if cone.strains() == 0 { skirt.hem_radius().0 } else { curve.radius_range().1 };
        let prediction = Prediction {
            fidelity: format!("ruled(K = {harmonics})"),
            folds: 0,
            energy: round_energy,
            energy_unit: "J",
            terms: energies(&round, terms, search.evaluations, &search.counts),
            hem_radius_min: radius,
            hem_radius_max: radius,
            coefficients: Vec::new(),
            outline: circle(radius),
            termination: Termination::Round,
            evaluations: search.evaluations,
            branches: tried,
            notes,
            hem: None,
            hem_rms: None,
            multiplier: None,
            turning: None,
            error_estimate: None,
            contacts: contacts(terms, &cone.gaps(&at_cone)),
            screening: None,
            graded: None,
        };
        return Ok(Hung { prediction, shape: None });
    }
    if !effort.fixed() && !search.verify(&mut best) {
        notes.push(if terms.body.is_some() || terms.folds.is_some() {
            "contact is sharper than the grid: the energy is not resolved to five digits".into()
        } else {
            "the hem is so nearly creased that its energy is not resolved to ten digits".into()
        });
    }
    let gaps = if search.walls() { search.clear(&mut best) } else { Gaps::default() };
    let curve = best.curve();
    let (low, high) = curve.radius_range();
    let ledger = best.shell.ledger(&best.minimum.x).ok_or_else(|| Error::Unanswerable("the solution has no finite energy".into()))?;
    let prediction = Prediction {
        fidelity: format!("ruled(K = {harmonics})"),
        folds: best.branch.folds,
        energy: ledger.total(),
        energy_unit: "J",
        terms: energies(&ledger, terms, search.evaluations, &search.counts),
        hem_radius_min: low,
        hem_radius_max: high,
        coefficients: curve.coefficients().to_vec(),
        outline: curve.outline(outline_points(best.branch.folds)),
        termination: best.branch.termination,
        evaluations: search.evaluations,
        branches: tried,
        notes,
        hem: None,
        hem_rms: None,
        multiplier: best.shell.length_multiplier(&best.minimum.x).map(|value| Multiplier { value, unit: "N" }),
        turning: None,
        error_estimate: None,
        contacts: contacts(terms, &gaps),
        screening: None,
        graded: None,
    };
    Ok(Hung { prediction, shape: Some((best.shell, best.minimum.x)) })
}

fn no_cone() -> Error {
    Error::Unanswerable("the round cone has no finite energy".into())
}

/// A lean of all the slant is a drape tester's disc; the rise √(L² − |d|²) has no derivative there.
pub(super) fn refuse_disc(skirt: &Skirt) -> Result<(), Error> {
    if skirt.conicity() < 1.0 - 1e-9 {
        return Ok(());
    }
    let why = "the hem is as far out as the slant reaches (base angle 0, a drape tester): straight generatrices hanging from a waist are no theory of that";
    Err(Error::Unanswerable(why.into()))
}

/// How many points an outline of `folds` folds gets: about [`OUTLINE`], the same number in every fold.
pub(super) fn outline_points(folds: u32) -> usize {
    let m = folds.max(1) as usize;
    m * OUTLINE.div_ceil(m)
}

pub(super) fn circle(radius: f64) -> Vec<Point> {
    (0..OUTLINE)
        .map(|i| (std::f64::consts::TAU * i as f64 / OUTLINE as f64).sin_cos())
        .map(|(sin, cos)| Point::new(radius * cos, radius * sin))
        .collect()
}

pub(super) fn notes_on(skirt: &Skirt, cloth: &Cloth) -> Vec<String> {
    let lengths = skirt.slant_length().0 / cloth.gravity_length();
    // Straight generatrices are an outer solution; the layers where they curve are about one gravity length at the waist.
    if lengths < 10.0 {
        vec![format!(
            "the slant is only {lengths:.1} gravity lengths (B/ρ_A g)^⅓: generatrices curve, and the theory of straight ones is rough here"
        )]
    } else {
        Vec::new()
    }
}

/// Flexural rigidity (N·m) above which the round cone is stable against `folds` folds; `None` if it is stable at any: weight then holds it round.
///
/// Second variation of the ruled energy at a_m = 0, linear in B. `weight` is ρ_A g, N/m².
pub fn threshold_rigidity(skirt: &Skirt, weight: f64, folds: u32) -> Option<f64> {
    let (hem, lean, m) = (skirt.hem_radius().0, skirt.hem_radius().0 - skirt.waist_radius().0, f64::from(folds));
    let rise = Gravity::new(skirt, weight).density(lean * lean)?;
    let spread = 1.0 / (m + 1.0).powi(2) + 1.0 / (m - 1.0).powi(2);
    let swing = (lean * hem * m / (m * m - 1.0)).powi(2);
    let gravity = rise.first * (0.25 * hem * hem * spread - 0.5 * lean * hem) + rise.second * swing;
    let (around, along) = unit_bending(skirt);
    let threshold = -gravity / (-0.25 * around + 0.5 * m * m * along);
    (0.0 < threshold).then_some(threshold)
}

/// At ψ = 0 and B = 1: derivative of b_0 by cos ψ, and b_2.
fn unit_bending(skirt: &Skirt) -> (f64, f64) {
    let (constant, quadratic) = Bending::new(skirt, 1.0, Bending::NODES).by_cos(1.0, skirt.hem_radius().0);
    (constant[1], quadratic[0])
}

/// Harmonics of the walk over fold counts: they leave a part in 10⁴ of the energy, as a rule nearly the same for neighbours.
const WALK: usize = 4;
/// Fold counts this close in energy at [`WALK`] harmonics, relative, are compared with all of them.
const CLOSE: f64 = 2e-3;

struct State {
    shell: RuledTerms,
    minimum: Minimum,
    branch: Branch,
}

impl State {
    /// Unknowns of the true period, a_1 > 0, as many as there are; strains start anew.
    fn canonical(&self) -> DVector<f64> {
        let own = canonical(&self.shell.coefficients(&self.minimum.x), self.branch.folds / self.branch.asked);
        let before = self.shell.strains();
        DVector::from_fn(before + own.len(), |i, _| if i < before { 0.0 } else { own[i - before] })
    }

    fn harmonics(&self) -> usize {
        self.minimum.x.len() - self.shell.strains()
    }

    fn curve(&self) -> TangentHem {
        self.shell.curve(&self.minimum.x)
    }
}

fn canonical(a: &DVector<f64>, step: u32) -> DVector<f64> {
    let step = step.max(1) as usize;
    let mut own = DVector::from_iterator(a.len() / step, a.iter().copied().skip(step - 1).step_by(step));
    // A shift by half a fold flips the odd coefficients together: put a crest, not a valley, on the axis.
    if own[0] < 0.0 {
        own.iter_mut().step_by(2).for_each(|a| *a = -*a);
    }
    own
}

/// Greatest common divisor of the indices of coefficients that matter: the number of true folds per asked fold.
pub(super) fn period(a: &DVector<f64>) -> u32 {
    let largest = a.amax();
    let gcd = |mut a: u32, mut b: u32| {
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    // A slid branch holds its other coefficients at rounding; a true one has them at a percent. A millionth separates the two.
    (1..).zip(a.iter()).filter(|(_, a)| 1e-6 * largest < a.abs()).fold(0, |g, (k, _)| gcd(g, k)).max(1)
}

/// Levels of the continuation: each refines the one before.
fn levels(harmonics: usize) -> impl Iterator<Item = usize> {
    [1, 2, 4, 8, 12, 16, 24].into_iter().filter(move |k| *k < harmonics).chain([harmonics])
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
    /// `fineness` multiplies the nodes of both quadratures.
    fn shell(&self, folds: u32, harmonics: usize, fineness: usize) -> RuledTerms {
        // A wall is felt over a few millimetres only.
        let fineness = if self.walls() { 2 * fineness } else { fineness };
        let (half, slices) = self.effort.sizes(half_nodes(harmonics), Bending::NODES);
        let (half, slices) = (fineness * half, fineness * slices);
        RuledTerms::new(self.skirt, self.terms, folds, harmonics, half, slices)
    }

    fn walls(&self) -> bool {
        self.terms.body.is_some() || self.terms.folds.is_some()
    }

    /// The round cone and its strains.
    fn cone(&mut self) -> Result<(RuledTerms, DVector<f64>), Error> {
        if self.terms.stretch.is_none() {
            return Ok((self.shell(2, 1, 1), DVector::zeros(1)));
        }
        // No fold is among the unknowns: the cone alone stretches.
        let shell = self.shell(2, 0, 1);
        let minimum = minimize(&shell, DVector::zeros(shell.strains()), &Options::default()).ok_or_else(no_cone)?;
        self.evaluations += minimum.evaluations;
        self.count(&shell);
        Ok((shell, minimum.x))
    }

    fn count(&mut self, shell: &RuledTerms) {
        self.counts.iter_mut().zip(shell.evaluations()).for_each(|(sum, more)| *sum += more);
    }

    /// What a branch must gain over the round cone, relative.
    fn rounding(&self) -> f64 {
        if self.terms.beyond_usual() { ROUNDING_OF_TERMS } else { ROUNDING }
    }

    /// The branch of `folds` folds, from one harmonic upward, or from `start`.
    fn solve(&mut self, folds: u32, harmonics: usize, start: Option<&DVector<f64>>, round: f64) -> State {
        let before = RuledTerms::strains_under(self.terms);
        let mut a = start.cloned().unwrap_or_else(|| DVector::from_fn(before + 1, |i, _| if i < before { 0.0 } else { 1.0 }));
        let mut reached = None;
        for level in levels(harmonics).filter(|k| a.len() - before <= *k).collect::<Vec<_>>() {
            let shell = self.shell(folds, level, 1);
            a = a.resize_vertically(before + level, 0.0);
            let minimum = self.descend(&shell, &a);
            a = minimum.x.clone();
            // Without folds at one harmonic there is nothing to refine.
            let flat = round - minimum.at.value <= self.rounding() * round.abs();
            reached = Some((shell, minimum));
            if flat {
                break;
            }
        }
        let (shell, mut minimum) = reached.unwrap_or_else(|| {
            let shell = self.shell(folds, harmonics, 1);
            let minimum = self.descend(&shell, &a);
            (shell, minimum)
        });
        let branch = self.describe(&shell, &mut minimum, round);
        State { shell, minimum, branch }
    }

    /// Downhill from `a`, drawn in towards the round cone until every generatrix reaches the hem.
    fn descend(&mut self, shell: &RuledTerms, a: &DVector<f64>) -> Minimum {
        let mut start = a.clone();
        loop {
            let spent = shell.evaluations();
            if let Some(minimum) = minimize(shell, start.clone(), &Options::default()) {
                self.evaluations += minimum.evaluations;
                self.counts.iter_mut().zip(shell.evaluations()).zip(spent).for_each(|((sum, now), before)| *sum += now - before);
                return minimum;
            }
            start *= 0.5;
            // The round cone itself is reachable: `predict` has seen its energy.
            if start.amax() < 1e-9 {
                start.fill(0.0);
            }
        }
    }

    fn describe(&self, shell: &RuledTerms, minimum: &mut Minimum, round: f64) -> Branch {
        let asked = shell.folds();
        let lowest_curvature = Some(minimum.lowest_curvature());
        let before = shell.strains();
        let harmonics = Some(minimum.x.len() - before);
        let usual = self.terms.gravity.is_some() && self.terms.bending.is_some() && !self.terms.beyond_usual();
        let threshold_rigidity = if usual { threshold_rigidity(self.skirt, self.cloth.weight(), asked) } else { None };
        if round - minimum.at.value <= self.rounding() * round.abs() {
            return Branch {
                asked,
                folds: 0,
                harmonics,
                energy: round,
                depth: 0.0,
                threshold_rigidity,
                lowest_curvature,
                termination: Termination::Round,
            };
        }
        let coefficients = shell.coefficients(&minimum.x);
        let step = period(&coefficients);
        if step == 1 {
            let own = canonical(&coefficients, 1);
            // The shift by half a fold that puts a crest on the axis turns the odd strains as well.
            if own[0] != coefficients[0] {
                (0..before).filter(|i| i % (before / 2) % 2 == 1).for_each(|i| minimum.x[i] = -minimum.x[i]);
            }
            minimum.x.rows_mut(before, own.len()).copy_from(&own);
        }
        let (low, high) = shell.curve(&minimum.x).radius_range();
        Branch {
            asked,
            folds: asked * step,
            harmonics,
            energy: minimum.at.value,
            depth: high - low,
            threshold_rigidity,
            lowest_curvature,
            termination: minimum.ending.into(),
        }
    }

    /// The branch of least energy: a scan with one harmonic, then all harmonics around its minimum.
    fn least(&mut self, harmonics: usize, round: f64, tried: &mut Vec<Branch>, notes: &mut Vec<String>) -> State {
        let scan = self.scan(round);
        let rough = (0..scan.len()).min_by(|i, j| scan[*i].branch.energy.total_cmp(&scan[*j].branch.energy)).unwrap_or(0);
        let from = scan[rough].branch.asked;
        if from == MOST_FOLDS {
            notes.push(format!("the energy still falls at {MOST_FOLDS} folds, where the search ends"));
        }
        let start = |m: u32| scan.iter().find(|s| s.branch.asked == m && s.branch.folds != 0).map(|s| s.minimum.x.clone());
        let walk = harmonics.min(WALK);
        let mut best = self.solve(from, walk, start(from).as_ref(), round);
        let mut walked = vec![best.branch.clone()];
        // Failures in a row on either side end the walk: refinement shifts the minimum by one fold, not by three.
        for direction in [-1_i64, 1] {
            let (mut m, mut failures) = (i64::from(from) + direction, 0_u32);
            while 2 <= m && m <= i64::from(MOST_FOLDS) && failures < self.effort.patience {
                let asked = m as u32;
                let state = self.solve(asked, walk, start(asked).as_ref(), round);
                walked.push(state.branch.clone());
                // A slid branch ties with the branch it slid to up to rounding; the honest one wins.
                if state.branch.energy < below(best.branch.energy, 1e-12) {
                    (best, failures) = (state, 0);
                } else {
                    failures += 1;
                }
                m += direction;
            }
        }
        if walk < harmonics && best.branch.folds != 0 {
            // More harmonics lower neighbours by nearly the same: only a close rival can still win.
            let rivals = walked
                .iter()
                .filter(|b| b.folds != 0 && b.energy <= above(best.branch.energy, self.effort.closeness * CLOSE))
                .map(|b| b.asked)
                .collect::<Vec<_>>();
            let from_walk = best.minimum.x.clone();
            let leader = best.branch.asked;
            best = self.solve(leader, harmonics, Some(&from_walk), round);
            tried.push(best.branch.clone());
            for asked in rivals.into_iter().filter(|m| *m != leader) {
                let state = self.solve(asked, harmonics, start(asked).as_ref(), round);
                tried.push(state.branch.clone());
                if state.branch.energy < below(best.branch.energy, 1e-12) {
                    best = state;
                }
            }
        }
        for branch in walked {
            if tried.iter().all(|b| b.asked != branch.asked) {
                tried.push(branch);
            }
        }
        for state in scan {
            if tried.iter().all(|b| b.asked != state.branch.asked) {
                tried.push(state.branch);
            }
        }
        best
    }

    /// Every fold count worth asking, with one harmonic.
    fn scan(&mut self, round: f64) -> Vec<State> {
        let mut scan: Vec<State> = Vec::new();
        let (mut best, mut best_energy) = (0, f64::INFINITY);
        let last = self.most_unstable().max(3) + 2;
        for m in 2..=last.min(MOST_FOLDS) {
            let warm = scan.last().filter(|s| s.branch.folds != 0).map(|s| s.minimum.x.clone());
            let state = self.solve(m, 1, warm.as_ref(), round);
            if state.branch.folds != 0 && state.branch.energy < best_energy {
                (best, best_energy) = (m, state.branch.energy);
            }
            scan.push(state);
            // Energy over m falls to one minimum and rises; half as many again is well past it.
            if best != 0 && best + best / 2 + 4 < m {
                break;
            }
        }
        scan
    }

    /// No fold count above this one can fold: there the bending of the second variation outweighs all that gravity can give.
    fn most_unstable(&self) -> u32 {
        let (hem, lean) = (self.skirt.hem_radius().0, self.skirt.hem_radius().0 - self.skirt.waist_radius().0);
        let weight = self.terms.gravity.map_or(Some(0.0), |weight| Some(Gravity::new(self.skirt, weight).density(lean * lean)?.first));
        let Some(weight) = weight else { return MOST_FOLDS };
        // The foundation draws inwards like a weight: ∫ (E/2) u² dA per |d|².
        let springs = self.terms.foundation.map_or(0.0, |foundation| {
            0.5 * foundation.modulus() * self.skirt.slant_length().0 * (self.skirt.waist_radius().0 / 3.0 + lean / 4.0)
        });
        let (_, along) = unit_bending(self.skirt);
        ((weight + springs) * lean * hem / (self.cloth.rigidity() * along)).sqrt().min(f64::from(MOST_FOLDS)) as u32
    }

    /// The gaps on a grid that is finer than the solution's; where cloth went through a wall between its nodes, the solution is found on that one.
    fn clear(&mut self, best: &mut State) -> Gaps {
        let fine = self.shell(best.shell.folds(), best.harmonics(), 4);
        let gaps = fine.gaps(&best.minimum.x);
        if !gaps.closed() {
            return gaps;
        }
        let start = best.minimum.x.clone();
        best.minimum = self.descend(&fine, &start);
        best.branch.termination = best.minimum.ending.into();
        best.branch.energy = best.minimum.at.value;
        best.shell = fine;
        best.shell.gaps(&best.minimum.x)
    }

    /// Doubles the nodes until the energy holds; whether it did.
    fn verify(&mut self, best: &mut State) -> bool {
        let (folds, harmonics) = (best.shell.folds(), best.harmonics());
        let (levels, quadrature): (&[usize], f64) = if self.walls() { (&[2, 4], QUADRATURE_AT_WALLS) } else { (&[2, 4, 8], QUADRATURE) };
        for &fineness in levels {
            let fine = self.shell(folds, harmonics, fineness);
            let agreed =
                fine.ledger(&best.minimum.x).is_some_and(|l| (l.total() - best.minimum.at.value).abs() <= quadrature * l.total().abs());
            if agreed {
                return true;
            }
            let a = best.minimum.x.clone();
            best.minimum = self.descend(&fine, &a);
            best.branch.termination = best.minimum.ending.into();
            best.branch.energy = best.minimum.at.value;
            best.shell = fine;
        }
        false
    }
}
