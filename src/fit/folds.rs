//! The fit of one outline: which fold count, which curve, how sure.

use std::f64::consts::{PI, TAU};

use super::circle::{self, Circle};
use super::limits::Limits;
use super::matching::Matched;
use super::orthogonal::UNKNOWNS;
use super::outcome::{Candidate, Estimate, HemFit, Termination};
use super::outline::{Outline, smooth};
use super::robust;
use super::start::{Start, matched};
use super::trial::{Reached, Trial, Work};
use crate::error::Error;
use crate::experiment::campaign::{Folds, HemLength};
use crate::experiment::{DrapeProfile, Point};
use crate::numerics::least_squares::{self, Loss, State};

/// What to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    pub folds: Folds,
    pub length: HemLength,
    /// The hem's length where the cut is known, 2πR_n, m: what [`HemLength::Auto`] holds to. The outline's own smoothed length otherwise.
    pub cut_length: Option<f64>,
    pub solver: least_squares::Options,
    /// Unknowns that are held or bounded.
    pub limits: Limits,
    /// Weight of each point in the order of the profile's points ([`DrapeProfile::source_index`] leads there from the input), 1/variance of its
    /// distance up to a common factor; a point of weight 0 does not count. `None`: all alike.
    pub weights: Option<Vec<f64>>,
    /// What is summed over the distances: squares, or a loss that forgives gross errors.
    pub loss: Loss,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            folds: Folds::default(),
            length: HemLength::Auto,
            cut_length: None,
            solver: least_squares::Options::default(),
            limits: Limits::default(),
            weights: None,
            loss: Loss::Squares,
        }
    }
}

/// Points round the outline that one fold needs: its second harmonic, twice.
const POINTS_A_FOLD: usize = 4;
/// Fold counts are compared on this many points; the best of them are then fitted to all. The weights of those that are not differ from
/// theirs by more than e⁻¹⁰.
const SCREENING_POINTS: usize = 256;
/// … which are those whose distance is within this factor of the least.
const CONTENDER: f64 = 1.05;

/// Fits the paper's curve to `profile`: every fold count asked for, then the most credible among the curves that obey the rules.
///
/// The sum of squares minimized is that of the signed orthogonal distances. Standard errors are `σ̂²(JᵀJ)⁻¹` with σ̂² from the distances:
/// they assume independent errors, so they are too small where the curve itself fits badly.
///
/// **Evidence for the fold count** is Akaike's criterion over the orthogonal distances of the sane curves, if the most credible of them is a free
/// optimum. If it had to be held, the folds are uneven, and orthogonal distance would favour fine ripples that stay near the outline's mean:
/// the criterion is then taken over the distances of curve and outline matched in order, both ways.
///
/// # Errors
/// [`Error::Unanswerable`] if the points cannot show the fold count asked for, or if no fold count gives a sane curve.
pub fn fit(profile: &DrapeProfile, options: &Options) -> Result<HemFit, Error> {
    let points = profile.points();
    robust::check(points.len(), options)?;
    if robust::concerns(options) {
        return robust::fit(profile, options);
    }
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
    let to = to.min(seen);
    let outline = smooth(profile);
    let work = Work::new(points, &outline, options).weighing(options.weights.iter().flatten().copied());
    let round = circle::fit(points);
    let mut trials = work_through(&work, SCREENING_POINTS, from..=to);
    if !trials.iter().any(Trial::sane) {
        // What was sane on fewer points is not on all of them, and others were not pursued for its sake: once more, with all.
        trials = work_through(&work, points.len(), from..=to);
    }
    if let Folds::Among { .. } = options.folds {
        trials.insert(0, Trial::round(&round, points, &outline));
    }
    let evaluations = trials.iter().map(|t| t.evaluations).sum();

    let Some((best, candidates)) = choose(trials, &work, points.len() as f64) else {
        let tried = if from == to { format!("{from} folds") } else { format!("{from} to {to} folds") };
        return Err(Error::Unanswerable(format!(
            "no sane curve with {tried}: every fit leaves the outline's order or length, crosses itself, or strays from the outline"
        )));
    };
    let notes = notes(options, &outline, &work, points.len(), seen);
    Ok(outcome(best, candidates, &round, &outline, evaluations, notes, &options.limits))
}

/// Every fold count tried, ascending: on about `enough` points, the best of them then on all.
fn work_through(work: &Work, enough: usize, folds: std::ops::RangeInclusive<u32>) -> Vec<Trial> {
    let stride = work.points.len() / enough.max(8 * *folds.end() as usize);
    let fewer: Vec<Point> = work.points.iter().copied().step_by(stride.max(1)).collect();
    let screening = Work::new(&fewer, work.outline, work.options).weighing(work.weights.iter().copied().step_by(stride.max(1)));
    // The nearest match first: what it reaches tells which of the others can still compete.
    let mut starts: Vec<Start> = folds.map(|m| matched(work.outline, m)).collect();
    starts.sort_by(|a, b| a.rms.total_cmp(&b.rms));
    let mut trials: Vec<Trial> = Vec::with_capacity(starts.len() + 1);
    let mut reached = Reached::nothing();
    let mut starts = starts.into_iter();
    for start in starts.by_ref() {
        let trial = screening.trial(&start, None, reached);
        reached.note(&trial, &screening);
        let sane = trial.sane();
        trials.push(trial);
        if sane {
            break;
        }
    }
    // Where folds are uneven the matches by length are all poor; the warped ones tell better which to try next.
    let warp = reached.apart.is_finite();
    let mut rest: Vec<(Option<Matched>, Start)> = starts.map(|start| (warp.then(|| screening.ordered(&start)), start)).collect();
    if warp {
        rest.sort_by(|a, b| a.0.as_ref().map_or(0.0, |m| m.rms).total_cmp(&b.0.as_ref().map_or(0.0, |m| m.rms)));
    }
    for (ordered, start) in rest {
        let trial = screening.trial(&start, ordered, reached);
        reached.note(&trial, &screening);
        trials.push(trial);
    }
    if fewer.len() < work.points.len() {
        let least = |measure: &dyn Fn(&Trial) -> f64| trials.iter().filter(|t| t.sane()).map(measure).fold(f64::INFINITY, f64::min);
        let (near, matched) = (CONTENDER * least(&|t| t.rms()), CONTENDER * least(&|t| screening.apart(t)));
        trials = trials
            .into_iter()
            .map(|t| if t.sane() && (t.rms() <= near || screening.apart(&t) <= matched) { work.refined(t, &screening) } else { t })
            .collect();
    }
    trials.sort_by_key(|t| t.folds);
    trials
}

/// The most credible sane trial, and all of them with their weights; `None` if none is sane.
fn choose(trials: Vec<Trial>, work: &Work, n: f64) -> Option<(Trial, Vec<Candidate>)> {
    let best_by = |criterion: &dyn Fn(&Trial) -> f64| {
        let sane = trials.iter().enumerate().filter(|(_, t)| t.sane());
        sane.map(|(i, t)| (i, criterion(t))).min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let near = |t: &Trial| t.aicc(t.rms(), n);
    let (nearest, _) = best_by(&near)?;
    let free = matches!(trials[nearest].termination, Termination::Converged | Termination::NoFolds);
    let asked = matches!(trials[nearest].termination, Termination::LengthAsAsked);
    let matched: Vec<f64> = if free || asked {
        Vec::new()
    } else {
        // A circle is out of the question where folds had to be held to their length.
        trials.iter().map(|t| if t.sane() && t.folds != 0 { t.aicc(work.apart(t), n) } else { f64::INFINITY }).collect()
    };
    let criterion = |i: usize| if matched.is_empty() { near(&trials[i]) } else { matched[i] };
    let considered = |i: &usize| trials[*i].sane() && criterion(*i).is_finite();
    let chosen = (0..trials.len()).filter(considered).min_by(|a, b| criterion(*a).total_cmp(&criterion(*b)))?;
    let likelihood = |i: usize| (0.5 * (criterion(chosen) - criterion(i))).exp();
    let total: f64 = (0..trials.len()).filter(considered).map(likelihood).sum();
    let candidates = trials
        .iter()
        .enumerate()
        .map(|(i, t)| Candidate {
            folds: t.folds,
            rms: t.rms(),
            aicc: if considered(&i) { criterion(i) } else { near(t) },
            weight: considered(&i).then(|| likelihood(i) / total),
            termination: t.termination.clone(),
            broken: t.broken,
        })
        .collect();
    let best = trials.into_iter().nth(chosen)?;
    Some((best, candidates))
}

fn notes(options: &Options, outline: &Outline, work: &Work, points: usize, seen: u32) -> Vec<String> {
    let mut notes = Vec::new();
    if let Folds::Among { to, .. } = options.folds
        && seen < to
    {
        notes.push(format!("{points} points round the outline cannot show more than {seen} folds"));
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
    notes
}

/// Bounds at which the fit came to rest, in words.
pub(super) fn bounds_met(states: &[State; 6]) -> impl Iterator<Item = String> {
    let end = |state: &State| match state {
        State::AtLower => Some("lower"),
        State::AtUpper => Some("upper"),
        State::Free | State::Fixed => None,
    };
    let met = UNKNOWNS.iter().zip(states).filter_map(move |(name, state)| Some((name, end(state)?)));
    met.map(|(name, end)| format!("{name} is at its {end} bound; the other standard errors hold while it stays there"))
}

fn outcome(
    best: Trial,
    candidates: Vec<Candidate>,
    round: &Circle,
    outline: &Outline,
    evaluations: usize,
    mut notes: Vec<String>,
    limits: &Limits,
) -> HemFit {
    let rms = best.rms();
    let weight = candidates.iter().find(|c| c.folds == best.folds).and_then(|c| c.weight).unwrap_or(0.0);
    let canonical = limits.allow_canonical_form();
    let (hem, placement) = if canonical { best.hem.canonical(best.placement) } else { (best.hem, best.placement) };
    // Canonical form moves the crest, and with it the origin of t.
    let turned = best.placement.phase - placement.phase + if canonical && best.hem.p < 0.0 { PI } else { 0.0 };
    let feet = best.feet.iter().map(|t| (t + turned).rem_euclid(TAU)).collect();
    let covariance = match best.covariance {
        // q → −q turns its covariances with p and s.
        Ok(c) if canonical && (best.hem.q < 0.0) != (best.hem.p < 0.0) => {
            Some(std::array::from_fn(|i| std::array::from_fn(|j| if (i == 1) != (j == 1) { -c[i][j] } else { c[i][j] })))
        }
        Ok(c) => Some(c),
        Err(reason) => {
            notes.push(format!("no standard errors: {reason}"));
            None
        }
    };
    let moved = |i: usize| best.states[i + 3] == State::Free;
    let [p, q, s] = [0, 1, 2].map(|i| covariance.filter(|_| moved(i)).map(|c: [[f64; 3]; 3]| c[i][i].max(0.0).sqrt()));
    notes.extend(bounds_met(&best.states));
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
        rms,
        perimeter: if folded { hem.perimeter() } else { TAU * hem.p },
        area: hem.area(),
        fold_depth: high - low,
        outline_length: outline.length,
        explained: (1.0 - best.sum_of_squares / round.sum_of_squares).clamp(0.0, 1.0),
        held: best.held,
        termination: best.termination,
        states: best.states,
        robust: None,
        distances: best.distances,
        hem,
        placement,
        feet,
        evaluations,
        notes,
    }
}
