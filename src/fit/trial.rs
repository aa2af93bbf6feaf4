//! One fold count, tried: the best curve of it that obeys the rules.

use std::f64::consts::TAU;

use super::akaike;
use super::circle::Circle;
use super::folds::Options;
use super::foot_point::{Foot, centred, nearest_within};
use super::matching::{self, Matched, stretched, warped};
use super::orthogonal::{self, Conditions, Fitted, UNKNOWNS};
use super::outcome::{HeldLength, Rule, Termination};
use super::outline::Outline;
use super::rules::{Evidence, LENGTH_SLACK, broken};
use super::start::{LengthTable, Start};
use crate::experiment::Point;
use crate::experiment::campaign::HemLength;
use crate::model::hem::{Hem, Placement};
use crate::numerics::least_squares::{self, State};

/// Below this share of the radius a match by equal lengths is near enough to start from; beyond it folds drift apart and are warped.
const CLOSE_MATCH: f64 = 0.03;

/// An orthogonal fit reaches half the distance of its match by equal lengths, hardly less (0.50 to 0.91 on skirts with uneven folds).
const LEAST_GAIN_FROM_LENGTHS: f64 = 0.4;
/// The same for a warped match, which is nearer to what the fit reaches (0.76 to 0.97 where the fit is sane).
const LEAST_GAIN_FROM_WARPING: f64 = 0.6;
/// Relative difference of outline and cut beyond which the cut is not believed to be what the plan view shows.
const CUT_SLACK: f64 = 0.02;
/// A match this much further from the outline than the best curve has no weight left: with a hundred points less than 1 %.
const LEAST_LOSS_FROM_FIT: f64 = 1.05;
/// A curve whose distance is above that of the best by this factor has no weight left, whichever rule it breaks: with the fewest points
/// allowed the weight falls to a tenth, with a hundred to 1e-8.
const BEATEN: f64 = 1.2;

/// An amplitude below this share of what the fit leaves may be a saddle.
const FLAT: f64 = 0.01;

/// One fold count, tried.
pub(super) struct Trial {
    pub folds: u32,
    pub hem: Hem,
    pub placement: Placement,
    pub feet: Vec<f64>,
    /// Fraction of the outline's length at which the crest t = 0 lies.
    pub offset: f64,
    pub distances: Vec<f64>,
    pub sum_of_squares: f64,
    /// Free parameters of the curve.
    pub parameters: usize,
    pub held: Option<HeldLength>,
    pub termination: Termination,
    pub broken: Option<Rule>,
    pub evaluations: usize,
    /// What became of each unknown.
    pub states: [State; 6],
    /// The match itself, where that is what is reported.
    pub matched: Option<Matched>,
}

impl Trial {
    /// The hem without folds; an outline much longer than its circle is none.
    pub(super) fn round(round: &Circle, points: &[Point], outline_length: f64) -> Trial {
        let distances: Vec<f64> = points.iter().map(|p| (p.x - round.x0).hypot(p.y - round.y0) - round.radius).collect();
        let hem = Hem { p: round.radius, q: 0.0, s: 0.0, folds: 0 };
        Trial {
            folds: 0,
            hem,
            placement: Placement { x0: round.x0, y0: round.y0, phase: 0.0 },
            feet: points.iter().map(|p| (p.y - round.y0).atan2(p.x - round.x0)).collect(),
            offset: 0.0,
            distances,
            sum_of_squares: round.sum_of_squares,
            parameters: 3,
            held: None,
            termination: Termination::NoFolds,
            broken: (TAU * round.radius * (1.0 + LENGTH_SLACK) < outline_length).then_some(Rule::Length),
            evaluations: 1,
            states: [State::Free; 6],
            matched: None,
        }
    }

    /// Whether the curve may be chosen.
    pub(super) fn sane(&self) -> bool {
        self.broken.is_none() && self.termination != Termination::NotPursued
    }

    /// Root mean square orthogonal distance, m; of the match where no fit was pursued.
    pub(super) fn rms(&self) -> f64 {
        (self.sum_of_squares / self.distances.len().max(1) as f64).sqrt()
    }

    /// Whether the curve is so much farther from the outline than another (rms `reached`, m) that keeping to the rules cannot save it.
    fn beaten(&self, reached: f64) -> bool {
        self.sum_of_squares.is_finite() && BEATEN * reached < self.rms()
    }

    /// A fold count whose match is so far from the outline that no fit of it can compete.
    pub(super) fn not_pursued(start: &Start, rms: f64) -> Trial {
        Trial {
            folds: start.hem.folds,
            hem: start.hem,
            placement: start.placement,
            feet: Vec::new(),
            offset: start.offset,
            distances: Vec::new(),
            sum_of_squares: rms * rms,
            parameters: UNKNOWNS.len(),
            held: None,
            termination: Termination::NotPursued,
            broken: None,
            evaluations: 0,
            states: [State::Free; 6],
            matched: None,
        }
    }

    /// A fold count set aside by the swift path: no curve of it comes nearer than `rms`, m.
    pub(super) fn left_aside(folds: u32, rms: f64) -> Trial {
        let start = Start { hem: Hem { p: 0.0, q: 0.0, s: 0.0, folds }, placement: Placement::ORIGIN, offset: 0.0, rms };
        Trial::not_pursued(&start, rms)
    }

    /// A certified free optimum of the swift path.
    pub(super) fn swift(
        hem: Hem,
        placement: Placement,
        feet: Vec<f64>,
        distances: Vec<f64>,
        sum_of_squares: f64,
        evaluations: usize,
    ) -> Trial {
        Trial {
            folds: hem.folds,
            hem,
            placement,
            feet,
            offset: 0.0,
            distances,
            sum_of_squares,
            parameters: UNKNOWNS.len(),
            held: None,
            termination: Termination::Converged,
            broken: None,
            evaluations,
            states: [State::Free; 6],
            matched: None,
        }
    }

    /// Akaike's criterion for n points at this rms distance, m.
    pub(super) fn aicc(&self, rms: f64, n: f64) -> f64 {
        akaike(rms * rms, n, self.parameters as f64 + 1.0)
    }
}

/// The best that any fold count has reached so far, m; infinite at first.
#[derive(Clone, Copy)]
pub(super) struct Reached {
    /// Least root mean square orthogonal distance of a free optimum.
    pub free: f64,
    /// Least distance of a held curve and the outline matched in order.
    pub apart: f64,
}

impl Reached {
    pub(super) fn nothing() -> Reached {
        Reached { free: f64::INFINITY, apart: f64::INFINITY }
    }

    /// Takes a sane trial into account.
    pub(super) fn note(&mut self, trial: &Trial, work: &Work) {
        match trial.termination {
            _ if !trial.sane() => (),
            Termination::Converged => self.free = self.free.min(trial.rms()),
            _ => self.apart = self.apart.min(work.apart(trial)),
        }
    }
}

/// Whether the outline is as long as the cloth was cut: not if the hem rises and falls, or the scale is wrong.
pub(super) fn agrees(outline_length: f64, cut: f64) -> bool {
    (outline_length / cut - 1.0).abs() <= CUT_SLACK
}

/// What every fold count of one outline is tried with.
pub(super) struct Work<'a> {
    pub points: &'a [Point],
    /// Fraction of the outline's length at which each point lies.
    fractions: Vec<f64>,
    pub outline: &'a Outline,
    pub options: &'a Options,
    /// Weight of each point, of mean 1; empty where all are alike.
    pub weights: Vec<f64>,
}

impl<'a> Work<'a> {
    /// `fractions[i]` is the place of `points[i]` along the outline.
    pub(super) fn new(points: &'a [Point], fractions: Vec<f64>, outline: &'a Outline, options: &'a Options) -> Self {
        Work { points, fractions, outline, options, weights: Vec::new() }
    }

    /// The same with these weights of the points.
    pub(super) fn weighing(self, weights: impl Iterator<Item = f64>) -> Self {
        let weights: Vec<f64> = weights.collect();
        let mean = weights.iter().sum::<f64>() / weights.len().max(1) as f64;
        Work { weights: weights.into_iter().map(|w| w / mean).collect(), ..self }
    }

    /// The same curve fitted to these points: from a trial of fewer points of the same outline.
    pub(super) fn refined(&self, coarse: Trial, fewer: &Work) -> Trial {
        if coarse.folds == 0 || coarse.termination == Termination::NotPursued {
            return coarse;
        }
        if let Some(matched) = &coarse.matched {
            let Termination::InOrder { broken } = coarse.termination else { unreachable!("only a match in order is kept") };
            return Trial { evaluations: coarse.evaluations, ..self.in_order(matched.clone(), broken) };
        }
        let feet = fewer.feet_at(&coarse.feet, &self.fractions);
        let length = coarse.held.map(|held| held.length);
        let fine = self.orthogonal(coarse.hem, coarse.placement, feet, length, coarse.termination.clone());
        Trial { evaluations: coarse.evaluations + fine.evaluations, ..fine }
    }

    /// Feet at other fractions of the outline, between those of this work's points.
    fn feet_at(&self, feet: &[f64], fractions: &[f64]) -> Vec<f64> {
        // Feet ascend but for noise; unwrapped they can be interpolated.
        let n = feet.len();
        let mut unwrapped = Vec::with_capacity(n + 1);
        let mut last = feet[0];
        for i in 0..=n {
            let step = feet[i % n] - last;
            last += step - TAU * (step / TAU).round();
            unwrapped.push(last);
        }
        let places = |i: usize| if i < n { self.fractions[i] } else { 1.0 };
        fractions
            .iter()
            .map(|&f| {
                let i = self.fractions.partition_point(|&g| g <= f).clamp(1, n);
                let share = (f - places(i - 1)) / (places(i) - places(i - 1)).max(f64::MIN_POSITIVE);
                unwrapped[i - 1] + share * (unwrapped[i] - unwrapped[i - 1])
            })
            .collect()
    }

    /// How far the curve and the outline are apart when matched in order, both ways, m.
    pub(super) fn apart(&self, trial: &Trial) -> f64 {
        matching::apart(self.outline, &trial.hem, &trial.placement, trial.offset)
    }

    /// Fraction of the outline's length at which the crest t = 0 lies: the mean over all feet, taken round the circle.
    fn offset(&self, hem: &Hem, feet: &[f64]) -> f64 {
        let table = LengthTable::of(hem);
        let turns = feet.iter().zip(&self.fractions).map(|(&t, f)| (TAU * (f - table.fraction(t))).sin_cos());
        let (sin, cos) = turns.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        sin.atan2(cos) / TAU
    }

    /// The length that a sane curve has, m.
    pub(super) fn length(&self) -> f64 {
        match self.options.length {
            HemLength::Held(length) => length,
            HemLength::Auto => self.options.cut_length.filter(|cut| self.agrees(*cut)).unwrap_or(self.outline.length),
            HemLength::Free => self.outline.length,
        }
    }

    fn agrees(&self, cut: f64) -> bool {
        agrees(self.outline.length, cut)
    }

    /// The best sane curve of one fold count: free if that is sane, else at the held length, else at the held length and in order.
    ///
    /// `ordered` is the match at the held length, if it is known already. Not pursued if that is too far from the outline to compete with what
    /// other fold counts have `reached`.
    pub(super) fn trial(&self, start: &Start, ordered: Option<Matched>, reached: Reached) -> Trial {
        if reached.free < LEAST_GAIN_FROM_LENGTHS * start.rms {
            return Trial::not_pursued(start, start.rms);
        }
        let known = reached.free.min(reached.apart).is_finite() && self.options.length != HemLength::Free;
        let ordered = ordered.or_else(|| known.then(|| self.ordered(start)));
        // A warped match is the nearest that curve and outline can come in order; fits by orthogonal distance are further apart.
        let hopeless = |m: &Matched| reached.free < LEAST_GAIN_FROM_WARPING * m.rms || LEAST_LOSS_FROM_FIT * reached.apart < m.rms;
        if let Some(ordered) = ordered.as_ref().filter(|m| hopeless(m)) {
            return Trial::not_pursued(start, ordered.rms);
        }
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
                Some(_) if trial.beaten(reached.free) => {
                    return Trial { evaluations, ..Trial::not_pursued(start, trial.rms()) };
                }
                Some(_) => last = Some(trial),
            }
        }
        let rule = last.as_ref().and_then(|t| t.broken);
        if self.options.length == HemLength::Free || last.is_some() && self.options.limits.shape_is_held() {
            return Trial { evaluations, ..last.expect("a free fit was tried") };
        }
        let held = match rule {
            Some(broken) => Termination::HeldLength { broken },
            None => Termination::LengthAsAsked,
        };
        let ordered = ordered.unwrap_or_else(|| self.ordered(start));
        let (hem, placement, feet) = self.feet_by_warping(&ordered);
        let trial = self.orthogonal(hem, placement, feet, Some(self.length()), held.clone());
        evaluations += trial.evaluations;
        if trial.broken.is_none() {
            return Trial { evaluations, ..trial };
        }
        if trial.beaten(reached.free) {
            return Trial { evaluations, ..Trial::not_pursued(start, trial.rms()) };
        }
        let (hem, placement, feet) = self.feet_by_length(&Start { hem: stretched(start.hem, self.length(), 1e-5), ..start.clone() });
        let again = self.orthogonal(hem, placement, feet, Some(self.length()), held);
        evaluations += again.evaluations;
        if again.broken.is_none() {
            return Trial { evaluations, ..again };
        }
        if !self.options.limits.none() {
            // A match in order knows nothing of limits.
            return Trial { evaluations, ..again };
        }
        let in_order = self.in_order(ordered, trial.broken.expect("just seen"));
        Trial { evaluations, ..in_order }
    }

    /// The match at the length that a sane curve has.
    pub(super) fn ordered(&self, start: &Start) -> Matched {
        warped(self.outline, start, Some(self.length()))
    }

    fn feet_by_length(&self, start: &Start) -> (Hem, Placement, Vec<f64>) {
        let table = LengthTable::of(&start.hem);
        (start.hem, start.placement, self.fractions.iter().map(|f| table.parameter(f - start.offset)).collect())
    }

    fn feet_by_warping(&self, matched: &Matched) -> (Hem, Placement, Vec<f64>) {
        (matched.hem, matched.placement, self.fractions.iter().map(|&f| matched.parameter(f)).collect())
    }

    /// The orthogonal fit from a curve and the feet on it.
    ///
    /// Where no amplitude is left the phase moves nothing, and folds elsewhere may be nearer: a saddle, from which those that are seen are tried.
    fn orthogonal(&self, hem: Hem, placement: Placement, feet: Vec<f64>, length: Option<f64>, termination: Termination) -> Trial {
        let first = self.orthogonal_from(hem, placement, feet, length, termination.clone());
        let flat = first.hem.q.abs() < FLAT * first.rms();
        if !flat {
            return first;
        }
        // The folds that the distances from a round hem show, to first order.
        let m = f64::from(hem.folds.max(1));
        let (mut along, mut across) = (0.0, 0.0);
        for (distance, foot) in first.distances.iter().zip(&first.feet) {
            let (sin, cos) = (m * foot).sin_cos();
            along += distance * cos;
            across += distance * sin;
        }
        let turn = across.atan2(along) / m;
        let q = 2.0 * along.hypot(across) / first.distances.len().max(1) as f64;
        let hem = Hem { q, ..first.hem };
        let placement = Placement { phase: first.placement.phase + turn, ..first.placement };
        let feet = first.feet.iter().map(|t| t - turn).collect();
        let second = self.orthogonal_from(hem, placement, feet, length, termination);
        let evaluations = first.evaluations + second.evaluations;
        let better = (second.broken.is_none(), -second.sum_of_squares) > (first.broken.is_none(), -first.sum_of_squares);
        // Folds that break a rule are not reported, but a round hem that they leave behind is no minimum.
        let saddle = !better && second.sum_of_squares < first.sum_of_squares * (1.0 - 1e-9);
        let termination = if saddle { Termination::Stalled } else { first.termination.clone() };
        if better { Trial { evaluations, ..second } } else { Trial { evaluations, termination, ..first } }
    }

    fn orthogonal_from(&self, hem: Hem, placement: Placement, feet: Vec<f64>, length: Option<f64>, termination: Termination) -> Trial {
        let conditions = Conditions { length, outline_length: self.length(), weights: &self.weights, limits: &self.options.limits };
        let fitted = orthogonal::fit_under(self.points, hem, placement, feet, &conditions, &self.options.solver)
            .expect("a profile has more points than the curve has unknowns, and limits are checked");
        let Fitted { hem, placement, feet, distances, summary, evaluations } = fitted;
        let broken = if summary.parameters.iter().all(|v| v.is_finite()) && summary.termination != least_squares::Termination::Abandoned {
            self.broken(&hem, &placement, &feet, &distances)
        } else {
            Some(Rule::Length)
        };
        let termination = match summary.termination {
            least_squares::Termination::Stalled => Termination::Stalled,
            least_squares::Termination::EvaluationLimit => Termination::EvaluationLimit,
            _ => termination,
        };
        let held = length.zip(summary.multiplier).map(|(length, multiplier)| HeldLength { length, multiplier });
        Trial {
            folds: hem.folds,
            hem,
            placement,
            offset: self.offset(&hem, &feet),
            feet,
            sum_of_squares: summary.sum_of_squares,
            distances,
            parameters: orthogonal::free(&summary.states).saturating_sub(usize::from(length.is_some())),
            held,
            termination,
            broken,
            evaluations,
            states: std::array::from_fn(|j| summary.states[j]),
            matched: None,
        }
    }

    /// The matched curve itself, each point's foot looked for only between its neighbours' matches, so that the order cannot break.
    fn in_order(&self, matched: Matched, rule: Rule) -> Trial {
        let (hem, placement, along) = self.feet_by_warping(&matched);
        let n = along.len();
        let (mut feet, mut distances) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for i in 0..n {
            let before = if i == 0 { along[n - 1] - TAU } else { along[i - 1] };
            let after = if i + 1 == n { along[0] + TAU } else { along[i + 1] };
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
        Trial {
            folds: hem.folds,
            hem,
            placement,
            offset: self.offset(&hem, &feet),
            feet,
            sum_of_squares: distances.iter().map(|d| d * d).sum(),
            distances,
            parameters: UNKNOWNS.len() - 1,
            held: None,
            termination: Termination::InOrder { broken: rule },
            broken,
            evaluations: 0,
            states: [State::Free; 6],
            matched: Some(matched),
        }
    }

    pub(super) fn broken(&self, hem: &Hem, placement: &Placement, feet: &[f64], distances: &[f64]) -> Option<Rule> {
        let farthest = distances.iter().fold(0.0_f64, |a, d| a.max(d.abs()));
        let rms = (distances.iter().map(|d| d * d).sum::<f64>() / distances.len() as f64).sqrt();
        broken(
            hem,
            placement,
            &Evidence { outline: self.outline, points: self.points, feet, distances, farthest, rms, length: self.length() },
        )
    }
}
