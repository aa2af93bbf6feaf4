//! The paper's curve by Ritz: least energy over p, q, s at the hem's own length; λ is the price of length.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::{Branch, Cloth, Effort, Folds, Multiplier, Prediction, TermEnergy, Termination, ruled};
use crate::error::Error;
use crate::experiment::{Point, Skirt};
use crate::model::ansatz::AnsatzShell;
use crate::model::energy::bending::Bending;
use crate::model::energy::gravity::Gravity;
use crate::model::functional::{HemJet, PaperFunctional, perimeter};
use crate::model::hem::{Hem, Placement};
use crate::numerics::minimize::{Constrained, ConstrainedMinimum, Expansion, Options, minimize_constrained};

/// Amplitudes mq/p to start from: soft cloth hangs near 2; the others serve stiff cloth and short reach.
const STARTS: [f64; 3] = [2.0, 1.0, 0.3];
/// Lean s/q to start from, about what every solution has.
const LEAN: f64 = 0.16;

/// The paper's curve of least ruled energy, and of least energy over fold counts if they are free.
pub(super) fn predict(skirt: &Skirt, cloth: &Cloth, folds: Folds, effort: &Effort) -> Result<Prediction, Error> {
    ruled::refuse_disc(skirt)?;
    let shell = AnsatzShell::new(skirt, cloth.weight(), cloth.rigidity());
    let mut search = Search { skirt, shell, weight: cloth.weight(), evaluations: 0 };
    let round = search.round()?;
    let mut states = Vec::new();
    match folds {
        Folds::Exactly(m) => states.push(search.solve(m, &round)),
        Folds::Auto => {
            // The tangent-angle family with one harmonic knows the neighbourhood at a fraction of the cost.
            let rough = ruled::predict(skirt, cloth, folds, 1, &Effort::default())?;
            search.evaluations += rough.evaluations;
            let from = rough.folds.max(2);
            states.push(search.solve(from, &round));
            let least = |states: &[State]| states.iter().map(|s| s.energy).fold(f64::INFINITY, f64::min);
            for direction in [-1_i64, 1] {
                let (mut m, mut failures) = (i64::from(from) + direction, 0_u32);
                while 2 <= m && m <= i64::from(ruled::MOST_FOLDS) && failures < effort.patience && rough.folds != 0 {
                    let state = search.solve(m as u32, &round);
                    failures = if state.energy < least(&states) { 0 } else { failures + 1 };
                    states.push(state);
                    m += direction;
                }
            }
        }
    }
    states.sort_by_key(|s| s.asked);
    let branches = states.iter().map(State::branch).collect();
    let best = states.iter().min_by(|a, b| a.energy.total_cmp(&b.energy)).unwrap_or(&round);
    let (low, high) = best.hem.radius_range();
    let mut notes = ruled::notes_on(skirt, cloth);
    notes.push("p, q, s cannot follow the exact hem: expect it a few millimetres away, and never identify cloth through it".into());
    Ok(Prediction {
        fidelity: "ansatz(p, q, s)".into(),
        folds: best.hem.folds,
        energy: best.energy,
        energy_unit: "J",
        terms: vec![
            TermEnergy { term: Gravity::NAME, energy: best.gravity, evaluations: search.evaluations },
            TermEnergy { term: Bending::NAME, energy: best.energy - best.gravity, evaluations: search.evaluations },
        ],
        hem_radius_min: low,
        hem_radius_max: high,
        coefficients: Vec::new(),
        outline: even_outline(&best.hem, ruled::outline_points(best.hem.folds)),
        termination: best.termination,
        evaluations: search.evaluations,
        branches,
        notes,
        hem: Some(best.hem),
        hem_rms: Some(0.0),
        multiplier: Some(Multiplier { value: best.multiplier, unit: "N" }),
        turning: None,
        error_estimate: None,
        contacts: Vec::new(),
        screening: None,
        graded: None,
    })
}

/// p, q, s of least ruled energy, the fold count included.
///
/// # Errors
/// As [`super::predict`]; [`Error::Unanswerable`] if the skirt hangs round.
pub fn least(skirt: &Skirt, cloth: &Cloth) -> Result<Hem, Error> {
    let round = || Error::Unanswerable("the skirt hangs round: the paper's curve has no folds to show".into());
    predict(skirt, cloth, Folds::Auto, &Effort::default())?.hem.filter(|hem| hem.folds != 0).ok_or_else(round)
}

/// p, q, s of least ruled energy at `folds` folds; `None` where there is no such curve.
pub fn at(skirt: &Skirt, cloth: &Cloth, folds: u32) -> Option<Hem> {
    predict(skirt, cloth, Folds::Exactly(folds), &Effort::default()).ok()?.hem.filter(|hem| hem.folds == folds)
}

/// A Ritz solution of the paper's own functional (10) under the paper's constraint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperRitz {
    pub hem: Hem,
    /// J, N/m.
    pub functional: f64,
    /// N/m².
    pub lambda: f64,
    /// Whether sideways lean was free; without, s = 0.
    pub lean: bool,
    /// Lowest curvature of the Lagrangian along the constraint; positive at a minimum.
    pub lowest_curvature: Option<f64>,
    pub termination: Termination,
    pub evaluations: usize,
}

/// Least J over p, q (and s, if `lean`) at Λ = 2πR_n with `folds` folds, by the paper's functional (10). It cannot choose the fold count: J falls with m.
///
/// `weight` is ρ_A g, N/m²; `foundation` is E, N/m³. `None` where no start is within reach of the slant.
pub fn paper(skirt: &Skirt, weight: f64, foundation: f64, folds: u32, lean: bool) -> Option<PaperRitz> {
    let functional = PaperFunctional::new(skirt, weight, foundation);
    let problem = Ritz { folds, size: skirt.hem_radius().0, lean, energy: |hem: &Hem| functional.energy(hem) };
    let minimum = STARTS.iter().find_map(|amplitude| problem.solve(*amplitude))?;
    let hem = problem.hem(&minimum.x);
    Some(PaperRitz {
        hem,
        functional: minimum.objective.value,
        lambda: minimum.multiplier / problem.size,
        lean,
        lowest_curvature: minimum.lowest_curvature(),
        termination: minimum.ending.into(),
        evaluations: minimum.evaluations,
    })
}

/// Energy over (p, q, s)/R_n, or (p, q)/R_n without lean, at the perimeter of the cut.
struct Ritz<E> {
    folds: u32,
    size: f64,
    lean: bool,
    energy: E,
}

impl<E: Fn(&Hem) -> Option<HemJet>> Ritz<E> {
    fn hem(&self, x: &DVector<f64>) -> Hem {
        Hem { p: x[0] * self.size, q: x[1] * self.size, s: if self.lean { x[2] * self.size } else { 0.0 }, folds: self.folds }
    }

    fn solve(&self, amplitude: f64) -> Option<ConstrainedMinimum> {
        let ratio = amplitude / f64::from(self.folds);
        let shape = Hem { p: 1.0, q: ratio, s: if self.lean { LEAN * ratio } else { 0.0 }, folds: self.folds };
        // The length is proportional to size, so the start can have the right one.
        let scale = TAU / shape.perimeter();
        let start = [scale, scale * shape.q, scale * shape.s];
        let options = Options { radius: 0.1, ..Options::default() };
        minimize_constrained(self, DVector::from_row_slice(&start[..self.unknowns()]), &options)
    }

    fn unknowns(&self) -> usize {
        if self.lean { 3 } else { 2 }
    }

    fn expansion(&self, jet: &HemJet, unit: f64) -> Expansion {
        let n = self.unknowns();
        let size = self.size;
        Expansion {
            value: jet.value / unit,
            gradient: DVector::from_fn(n, |i, _| jet.gradient[i] * size / unit),
            hessian: DMatrix::from_fn(n, n, |i, j| jet.hessian[i][j] * size * size / unit),
        }
    }
}

impl<E: Fn(&Hem) -> Option<HemJet>> Constrained for Ritz<E> {
    fn expand(&self, x: &DVector<f64>) -> Option<(Expansion, Expansion)> {
        let hem = self.hem(x);
        let energy = (self.energy)(&hem)?;
        // Excess length in units of R_n, so that its multiplier is the energy's own unit.
        let excess = perimeter(&hem) - TAU * self.size;
        Some((self.expansion(&energy, 1.0), self.expansion(&excess, self.size)))
    }
}

struct Search<'a> {
    skirt: &'a Skirt,
    shell: AnsatzShell,
    weight: f64,
    evaluations: usize,
}

#[derive(Debug, Clone, Copy)]
struct State {
    asked: u32,
    /// Fold count 0 is the round cone.
    hem: Hem,
    energy: f64,
    gravity: f64,
    multiplier: f64,
    lowest_curvature: Option<f64>,
    threshold_rigidity: Option<f64>,
    termination: Termination,
}

impl State {
    fn branch(&self) -> Branch {
        let (low, high) = self.hem.radius_range();
        Branch {
            asked: self.asked,
            folds: self.hem.folds,
            harmonics: None,
            energy: self.energy,
            depth: high - low,
            threshold_rigidity: self.threshold_rigidity,
            lowest_curvature: self.lowest_curvature,
            termination: self.termination,
        }
    }
}

impl Search<'_> {
    fn round(&mut self) -> Result<State, Error> {
        let hem = Hem { p: self.skirt.hem_radius().0, q: 0.0, s: 0.0, folds: 0 };
        let energy = self.shell.energy(&hem).ok_or_else(|| Error::Unanswerable("the round cone has no finite energy".into()))?;
        let multiplier = energy.total().gradient[0] / TAU;
        let (gravity, energy) = (energy.gravity.value, energy.total().value);
        Ok(State {
            asked: 0,
            hem,
            energy,
            gravity,
            multiplier,
            lowest_curvature: None,
            threshold_rigidity: None,
            termination: Termination::Round,
        })
    }

    fn solve(&mut self, folds: u32, cone: &State) -> State {
        let round = cone.energy;
        let problem =
            Ritz { folds, size: self.skirt.hem_radius().0, lean: true, energy: |hem: &Hem| self.shell.energy(hem).map(|e| e.total()) };
        let mut best: Option<ConstrainedMinimum> = None;
        for amplitude in STARTS {
            let Some(minimum) = problem.solve(amplitude) else { continue };
            self.evaluations += minimum.evaluations;
            let better = best.as_ref().is_none_or(|b| minimum.objective.value < b.objective.value);
            if better {
                best = Some(minimum);
            }
            // A folded minimum is found: other starts lead to the same one.
            if best.as_ref().is_some_and(|b| b.objective.value < round * (1.0 - ruled::ROUNDING)) {
                break;
            }
        }
        let folded = best.and_then(|minimum| {
            let mut hem = problem.hem(&minimum.x);
            // (q, t) and (−q, t + π/m) are one curve.
            hem.q = hem.q.abs();
            let energy = self.shell.energy(&hem)?;
            (energy.total().value < round * (1.0 - ruled::ROUNDING)).then(|| State {
                asked: folds,
                hem,
                energy: energy.total().value,
                gravity: energy.gravity.value,
                multiplier: minimum.multiplier / problem.size,
                lowest_curvature: minimum.lowest_curvature(),
                threshold_rigidity: None,
                termination: minimum.ending.into(),
            })
        });
        // To first order the paper's curve buckles like any other.
        let threshold_rigidity = ruled::threshold_rigidity(self.skirt, self.weight, folds);
        State { threshold_rigidity, ..folded.unwrap_or(State { asked: folds, ..*cone }) }
    }
}

/// `n` points equally spaced in length, as many in every fold, the first at t = 0, m. They lie on the curve to rounding; their spacing is even to a part
/// in 10⁶.
fn even_outline(hem: &Hem, n: usize) -> Vec<Point> {
    let folds = hem.folds.max(1);
    let own = n / folds as usize;
    // An even number, so that a mirror image ends half a fold.
    let steps = 16 * own;
    let angle = |step: f64| TAU * step / (f64::from(folds) * steps as f64);
    let speeds: Vec<f64> = (0..=steps / 2).map(|i| hem.local(angle(i as f64)).speed()).collect();
    let speed = |i: usize| speeds[i.min(steps - i)];
    let mut reached = vec![0.0];
    for i in 0..steps {
        reached.push(reached[i] + 0.5 * (speed(i) + speed(i + 1)));
    }
    let whole = reached[steps];
    let mut cell = 0;
    let mut outline = Vec::with_capacity(n);
    for i in 0..own {
        let target = whole * i as f64 / own as f64;
        while cell + 1 < steps && reached[cell + 1] <= target {
            cell += 1;
        }
        let fraction = (target - reached[cell]) / (reached[cell + 1] - reached[cell]);
        outline.push(hem.point(&Placement::ORIGIN, angle(cell as f64 + fraction)));
    }
    for fold in 1..folds {
        let (sin, cos) = (TAU * f64::from(fold) / f64::from(folds)).sin_cos();
        for i in 0..own {
            let Point { x, y, .. } = outline[i];
            outline.push(Point::new(x * cos - y * sin, x * sin + y * cos));
        }
    }
    outline
}
