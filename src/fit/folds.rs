//! The fit of one outline: which fold count, which curve, how sure.

use super::circle;
use super::foot_point::{Foot, centred, nearest_within};
use super::matching::{Matched, stretched, warped};
use super::orthogonal::{self, Fitted, UNKNOWNS};
use super::outcome::{Candidate, Estimate, HeldLength, HemFit, Rule, Termination};
use super::outline::{Outline, smooth};
use super::rules::{Evidence, broken};
use super::start::{LengthTable, Start, matched};
use crate::error::Error;
use crate::experiment::campaign::{Folds, HemLength};
use crate::experiment::{DrapeProfile, Point};
use crate::model::hem::{Hem, Placement};
use crate::numerics::least_squares::{self, covariance};

/// What to fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    pub folds: Folds,
    pub length: HemLength,
    /// The hem's length where the cut is known, 2πR_n, m: what [`HemLength::Auto`] holds to. The outline's own smoothed length otherwise.
    pub cut_length: Option<f64>,
    pub solver: least_squares::Options,
}

impl Default for Options {
    fn default() -> Self {
        Options { folds: Folds::default(), length: HemLength::Auto, cut_length: None, solver: least_squares::Options::default() }
    }
}

/// Points round the outline that one fold needs: its second harmonic, twice.
const POINTS_A_FOLD: usize = 4;
/// Below this share of the radius a match by equal lengths is near enough to start from; beyond it folds drift apart and are warped.
const CLOSE_MATCH: f64 = 0.03;

/// An orthogonal fit reaches half the distance of its match by equal lengths, hardly less (0.50 to 0.91 on skirts with uneven folds).
const LEAST_GAIN_FROM_LENGTHS: f64 = 0.4;
/// The same for a warped match, which is nearer to what the fit reaches (0.76 to 0.97 where the fit is sane).
const LEAST_GAIN_FROM_WARPING: f64 = 0.6;
/// Relative difference of outline and cut beyond which the cut is not believed to be what the plan view shows.
const CUT_SLACK: f64 = 0.02;
/// A curve whose distance is above that of the best by this factor has no weight left, whichever rule it breaks: with the fewest points
/// allowed the weight falls to a tenth, with a hundred to 1e-8.
const BEATEN: f64 = 1.2;

/// Fits the paper's curve to `profile`: every fold count asked for, then the most credible among the curves that obey the rules.
///
/// The sum of squares minimized is that of the signed orthogonal distances. Standard errors are `σ̂²(JᵀJ)⁻¹` with σ̂² from the distances:
/// they assume independent errors, so they are too small where the curve itself fits badly.
///
/// # Errors
/// [`Error::Unanswerable`] if the points cannot show the fold count asked for, or if no fold count gives a sane curve.
pub fn fit(profile: &DrapeProfile, options: &Options) -> Result<HemFit, Error> {
    let points = profile.points();
    let (from, to) = match options.folds {
        Folds::Among { from, to } => (from.max(2), to),
        Folds::Exactly(m) => (m, m),
    };
    let seen = (points.len() / POINTS_A_FOLD) as u32;
    if seen < from {
        return Err(Error::Unanswerable(format!(
            "{} points round the outline show at most {seen} folds; {from} folds need {}",
            points.len(),
            POINTS_A_FOLD * from as usize
        )));
    }
    let outline = smooth(profile);
    let work = Work { points, fractions: fractions(points), outline: &outline, options };
    let round = circle::fit(points);

    // The nearest match first: what it reaches tells which of the others can still compete.
    let mut starts: Vec<Start> = (from..=to.min(seen)).map(|m| matched(&outline, m)).collect();
    starts.sort_by(|a, b| a.rms.total_cmp(&b.rms));
    let mut trials = Vec::with_capacity(starts.len() + 1);
    let mut reached = f64::INFINITY;
    for start in &starts {
        let trial = work.trial(start, reached);
        if trial.broken.is_none() && trial.termination != Termination::NotPursued {
            reached = reached.min((trial.sum_of_squares / points.len() as f64).sqrt());
        }
        trials.push(trial);
    }
    trials.sort_by_key(|t| t.folds);
    if let Folds::Among { .. } = options.folds {
        trials.insert(0, Trial::round(&round, points));
    }
    let evaluations = trials.iter().map(|t| t.evaluations).sum();
    let n = points.len() as f64;
    let sane = Trial::sane;
    let least = trials.iter().filter(|t| sane(t)).map(|t| t.aicc(n)).fold(f64::INFINITY, f64::min);
    let total: f64 = trials.iter().filter(|t| sane(t)).map(|t| (0.5 * (least - t.aicc(n))).exp()).sum();
    let candidates: Vec<Candidate> = trials
        .iter()
        .map(|t| Candidate {
            folds: t.folds,
            rms: (t.sum_of_squares / n).sqrt(),
            aicc: t.aicc(n),
            weight: sane(t).then(|| (0.5 * (least - t.aicc(n))).exp() / total),
            termination: t.termination.clone(),
            broken: t.broken,
        })
        .collect();
    let best = trials.into_iter().filter(sane).min_by(|a, b| a.aicc(n).total_cmp(&b.aicc(n)));
    let Some(best) = best else {
        let tried = if from == to { format!("{from} folds") } else { format!("{from} to {} folds", to.min(seen)) };
        return Err(Error::Unanswerable(format!(
            "no sane curve with {tried}: every fit leaves the outline's order or length, crosses itself, or strays from the outline"
        )));
    };
    let weight = candidates.iter().find(|c| c.folds == best.folds).and_then(|c| c.weight).unwrap_or(0.0);
    let mut notes = Vec::new();
    if to > seen {
        notes.push(format!("{} points round the outline cannot show more than {seen} folds", points.len()));
    }
    if let (HemLength::Auto, Some(cut)) = (options.length, options.cut_length)
        && !work.agrees(cut)
    {
        let percent = 100.0 * (outline.length / cut - 1.0);
        notes.push(format!(
            "the outline is {:.1} % {} than the hem was cut (tilted hem, wrong scale or missing cloth?): its own length counts",
            percent.abs(),
            if percent < 0.0 { "shorter" } else { "longer" }
        ));
    }
    Ok(work.outcome(best, weight, candidates, round, evaluations, notes))
}

/// Fraction of the polygon's length at which each point lies.
fn fractions(points: &[Point]) -> Vec<f64> {
    let mut fractions = Vec::with_capacity(points.len());
    let mut length = 0.0;
    for (i, point) in points.iter().enumerate() {
        fractions.push(length);
        length += point.distance(points[(i + 1) % points.len()]);
    }
    fractions.iter_mut().for_each(|f| *f /= length);
    fractions
}

/// One fold count, tried.
struct Trial {
    folds: u32,
    hem: Hem,
    placement: Placement,
    feet: Vec<f64>,
    distances: Vec<f64>,
    sum_of_squares: f64,
    /// Free parameters of the curve.
    parameters: usize,
    held: Option<HeldLength>,
    termination: Termination,
    broken: Option<Rule>,
    /// Covariance of (p, q, s), m², or why there is none.
    covariance: Result<[[f64; 3]; 3], String>,
    evaluations: usize,
}

impl Trial {
    fn round(round: &circle::Circle, points: &[Point]) -> Trial {
        let distances: Vec<f64> = points.iter().map(|p| (p.x - round.x0).hypot(p.y - round.y0) - round.radius).collect();
        let hem = Hem { p: round.radius, q: 0.0, s: 0.0, folds: 0 };
        Trial {
            folds: 0,
            hem,
            placement: Placement { x0: round.x0, y0: round.y0, phase: 0.0 },
            feet: points.iter().map(|p| (p.y - round.y0).atan2(p.x - round.x0)).collect(),
            distances,
            sum_of_squares: round.sum_of_squares,
            parameters: 3,
            held: None,
            termination: Termination::NoFolds,
            broken: None,
            covariance: Ok([[round.radius_error * round.radius_error, 0.0, 0.0], [0.0; 3], [0.0; 3]]),
            evaluations: 1,
        }
    }

    /// Whether the curve may be chosen.
    fn sane(&self) -> bool {
        self.broken.is_none() && self.termination != Termination::NotPursued
    }

    fn rms(&self) -> f64 {
        (self.sum_of_squares / self.distances.len().max(1) as f64).sqrt()
    }

    /// Whether the curve is so much farther from the outline than another (rms `reached`, m) that keeping to the rules cannot save it.
    fn beaten(&self, reached: f64) -> bool {
        self.sum_of_squares.is_finite() && BEATEN * reached < self.rms()
    }

    /// A fold count whose match is so far from the outline that no fit of it can compete.
    fn not_pursued(start: &Start, rms: f64, points: usize) -> Trial {
        Trial {
            folds: start.hem.folds,
            hem: start.hem,
            placement: start.placement,
            feet: Vec::new(),
            distances: Vec::new(),
            sum_of_squares: rms * rms * points as f64,
            parameters: UNKNOWNS.len(),
            held: None,
            termination: Termination::NotPursued,
            broken: None,
            covariance: Err("not fitted".into()),
            evaluations: 0,
        }
    }

    /// Akaike's criterion for n points, corrected for few of them (Hurvich & Tsai, Biometrika 76 (1989) 297–307).
    fn aicc(&self, n: f64) -> f64 {
        let k = self.parameters as f64 + 1.0;
        n * (self.sum_of_squares / n).max(f64::MIN_POSITIVE).ln() + 2.0 * k + 2.0 * k * (k + 1.0) / (n - k - 1.0)
    }
}

struct Work<'a> {
    points: &'a [Point],
    fractions: Vec<f64>,
    outline: &'a Outline,
    options: &'a Options,
}

impl Work<'_> {
    /// The length that a sane curve has, m.
    fn length(&self) -> f64 {
        match self.options.length {
            HemLength::Held(length) => length,
            HemLength::Auto => self.options.cut_length.filter(|cut| self.agrees(*cut)).unwrap_or(self.outline.length),
            HemLength::Free => self.outline.length,
        }
    }

    /// Whether the outline is as long as the cloth was cut: not if the hem rises and falls, or the scale is wrong.
    fn agrees(&self, cut: f64) -> bool {
        (self.outline.length / cut - 1.0).abs() <= CUT_SLACK
    }

    /// The best sane curve of one fold count: free if that is sane, else at the held length, else at the held length and in order.
    ///
    /// Not pursued if its match is far worse than what another fold count has `reached` (rms, m).
    fn trial(&self, start: &Start, reached: f64) -> Trial {
        if reached < LEAST_GAIN_FROM_LENGTHS * start.rms {
            return Trial::not_pursued(start, start.rms, self.points.len());
        }
        let ordered = if reached.is_finite() && self.options.length != HemLength::Free {
            let ordered = warped(self.outline, start, Some(self.length()));
            if reached < LEAST_GAIN_FROM_WARPING * ordered.rms {
                return Trial::not_pursued(start, ordered.rms, self.points.len());
            }
            Some(ordered)
        } else {
            None
        };
        let mut evaluations = 0;
        let mut last: Option<Trial> = None;
        if !matches!(self.options.length, HemLength::Held(_)) {
            let close = start.rms < CLOSE_MATCH * self.outline.radius;
            let (hem, placement, feet) =
                if close { self.feet_by_length(start) } else { self.feet_by_warping(&warped(self.outline, start, None)) };
            let trial = self.orthogonal(hem, placement, feet, None, Termination::Converged);
            evaluations += trial.evaluations;
            match trial.broken {
                None => return Trial { evaluations, ..trial },
                Some(_) if trial.beaten(reached) => {
                    return Trial { evaluations, ..Trial::not_pursued(start, trial.rms(), self.points.len()) };
                }
                Some(_) => last = Some(trial),
            }
        }
        let rule = last.as_ref().and_then(|t| t.broken);
        if self.options.length == HemLength::Free {
            return Trial { evaluations, ..last.expect("a free fit was tried") };
        }
        let held = match rule {
            Some(broken) => Termination::HeldLength { broken },
            None => Termination::LengthAsAsked,
        };
        let ordered = ordered.unwrap_or_else(|| warped(self.outline, start, Some(self.length())));
        let (hem, placement, feet) = self.feet_by_warping(&ordered);
        let trial = self.orthogonal(hem, placement, feet, Some(self.length()), held.clone());
        evaluations += trial.evaluations;
        if trial.broken.is_none() {
            return Trial { evaluations, ..trial };
        }
        if trial.beaten(reached) {
            return Trial { evaluations, ..Trial::not_pursued(start, trial.rms(), self.points.len()) };
        }
        let (hem, placement, feet) = self.feet_by_length(&Start { hem: stretched(start.hem, self.length()), ..start.clone() });
        let again = self.orthogonal(hem, placement, feet, Some(self.length()), held);
        evaluations += again.evaluations;
        if again.broken.is_none() {
            return Trial { evaluations, ..again };
        }
        let in_order = self.in_order(&ordered, trial.broken.expect("just seen"));
        Trial { evaluations, ..in_order }
    }

    fn feet_by_length(&self, start: &Start) -> (Hem, Placement, Vec<f64>) {
        let table = LengthTable::of(&start.hem);
        (start.hem, start.placement, self.fractions.iter().map(|f| table.parameter(f - start.offset)).collect())
    }

    fn feet_by_warping(&self, matched: &Matched) -> (Hem, Placement, Vec<f64>) {
        (matched.hem, matched.placement, self.fractions.iter().map(|&f| matched.parameter(f)).collect())
    }

    fn orthogonal(&self, hem: Hem, placement: Placement, feet: Vec<f64>, length: Option<f64>, termination: Termination) -> Trial {
        let fitted = orthogonal::fit(self.points, hem, placement, feet, length, self.length(), &self.options.solver)
            .expect("a profile has more points than the curve has unknowns");
        let Fitted { hem, placement, feet, summary, evaluations } = fitted;
        let broken = if summary.parameters.iter().all(|v| v.is_finite()) && summary.termination != least_squares::Termination::Abandoned {
            self.broken(&hem, &placement, &feet, &summary.residuals)
        } else {
            Some(Rule::Length)
        };
        let termination = match summary.termination {
            least_squares::Termination::Stalled => Termination::Stalled,
            least_squares::Termination::EvaluationLimit => Termination::EvaluationLimit,
            _ => termination,
        };
        let covariance = covariance(&summary, &UNKNOWNS)
            .map_err(|e| e.to_string())
            .map(|c| std::array::from_fn(|i| std::array::from_fn(|j| c.matrix[(i + 3, j + 3)])));
        let held = length.zip(summary.multiplier).map(|(length, multiplier)| HeldLength { length, multiplier });
        Trial {
            folds: hem.folds,
            hem,
            placement,
            feet,
            sum_of_squares: summary.sum_of_squares,
            distances: summary.residuals,
            parameters: UNKNOWNS.len() - usize::from(length.is_some()),
            held,
            termination,
            broken,
            covariance,
            evaluations,
        }
    }

    /// The matched curve itself, each point's foot looked for only between its neighbours' matches, so that the order cannot break.
    fn in_order(&self, matched: &Matched, rule: Rule) -> Trial {
        let (hem, placement, along) = self.feet_by_warping(matched);
        let n = along.len();
        let (mut feet, mut distances) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for i in 0..n {
            let before = if i == 0 { along[n - 1] - std::f64::consts::TAU } else { along[i - 1] };
            let after = if i + 1 == n { along[0] + std::f64::consts::TAU } else { along[i + 1] };
            let (low, high) = (0.5 * (before + along[i]), 0.5 * (after + along[i]));
            let point = centred(self.points[i], &placement);
            let free = nearest_within(&hem, point, low, high, 5);
            let foot = if (low..=high).contains(&free.t) {
                free
            } else {
                let (a, b) = (Foot::at(&hem, point, low), Foot::at(&hem, point, high));
                if a.square() < b.square() { a } else { b }
            };
            // Not normal to the curve where the order holds it: the distance is that of the points, with the side's sign.
            distances.push(foot.square().sqrt().copysign(foot.distance()));
            feet.push(foot.t);
        }
        let broken = self.broken(&hem, &placement, &feet, &distances);
        let reason = "the curve was matched in order, not fitted by orthogonal distance".to_string();
        Trial {
            folds: hem.folds,
            hem,
            placement,
            feet,
            sum_of_squares: distances.iter().map(|d| d * d).sum(),
            distances,
            parameters: UNKNOWNS.len() - 1,
            held: None,
            termination: Termination::InOrder { broken: rule },
            broken,
            covariance: Err(reason),
            evaluations: 0,
        }
    }

    fn broken(&self, hem: &Hem, placement: &Placement, feet: &[f64], distances: &[f64]) -> Option<Rule> {
        let farthest = distances.iter().fold(0.0_f64, |a, d| a.max(d.abs()));
        let rms = (distances.iter().map(|d| d * d).sum::<f64>() / distances.len() as f64).sqrt();
        broken(hem, placement, &Evidence { outline: self.outline, points: self.points, feet, farthest, rms, length: self.length() })
    }

    fn outcome(
        &self,
        best: Trial,
        weight: f64,
        candidates: Vec<Candidate>,
        round: circle::Circle,
        evaluations: usize,
        mut notes: Vec<String>,
    ) -> HemFit {
        let n = self.points.len() as f64;
        let (hem, placement) = best.hem.canonical(best.placement);
        // Canonical form moves the crest, and with it the origin of t.
        let turned = best.placement.phase - placement.phase + if best.hem.p < 0.0 { std::f64::consts::PI } else { 0.0 };
        let feet = best.feet.iter().map(|t| (t + turned).rem_euclid(std::f64::consts::TAU)).collect();
        let covariance = match best.covariance {
            // q → −q turns its covariances with p and s.
            Ok(c) if (best.hem.q < 0.0) != (best.hem.p < 0.0) => {
                Some(std::array::from_fn(|i| std::array::from_fn(|j| if (i == 1) != (j == 1) { -c[i][j] } else { c[i][j] })))
            }
            Ok(c) => Some(c),
            Err(reason) => {
                notes.push(format!("no standard errors: {reason}"));
                None
            }
        };
        let [p, q, s] = [0, 1, 2].map(|i| covariance.map(|c: [[f64; 3]; 3]| c[i][i].max(0.0).sqrt()));
        let folded = best.folds != 0;
        if folded && q.is_some_and(|se| hem.q < 2.0 * se) {
            notes.push("the fold amplitude is within two standard errors of zero: phase and fold count are hardly determined".into());
        }
        let (low, high) = if folded { hem.radius_range() } else { (hem.p, hem.p) };
        HemFit {
            p: Estimate { value: hem.p, standard_error: p },
            q: folded.then_some(Estimate { value: hem.q, standard_error: q }),
            s: folded.then_some(Estimate { value: hem.s, standard_error: s }),
            covariance,
            folds: folded.then_some(best.folds),
            folds_weight: weight,
            candidates,
            rms: (best.sum_of_squares / n).sqrt(),
            perimeter: if folded { hem.perimeter() } else { std::f64::consts::TAU * hem.p },
            area: hem.area(),
            fold_depth: high - low,
            outline_length: self.outline.length,
            explained: (1.0 - best.sum_of_squares / round.sum_of_squares).clamp(0.0, 1.0),
            held: best.held,
            termination: best.termination,
            distances: best.distances,
            hem,
            placement,
            feet,
            evaluations,
            notes,
        }
    }
}
