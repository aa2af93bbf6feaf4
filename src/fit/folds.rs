//! The fit of one outline: which fold count, which curve, how sure.

use std::f64::consts::{PI, TAU};

use super::bias::{self, BiasCorrection, Uncorrected};
use super::circle::{self, Circle};
use super::even::Evidence;
use super::frame::Frame;
use super::limits::Limits;
use super::matching::Matched;
use super::orthogonal::UNKNOWNS;
use super::outcome::{Candidate, Estimate, HemFit, Termination};
use super::outline::{Outline, fractions, smooth};
use super::robust;
use super::sampling::{POINTS_A_FOLD, most_folds, note, plainly_seen};
use super::start::{Radii, Start};
use super::swift::{self, Swift};
use super::trial::{Reached, Trial, Work, agrees};
use super::uncertainty::{Fitted, Known, correlation, uncertainty};
use crate::error::Error;
use crate::experiment::campaign::{Folds, HemLength};
use crate::experiment::{DrapeProfile, Point};
use crate::model::hem::{Hem, Placement};
use crate::numerics::least_squares::{self, Loss, State};

/// What to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    pub folds: Folds,
    pub length: HemLength,
    /// The hem's length where the cut is known, 2πR_n, m: what [`HemLength::Auto`] holds to. The outline's own smoothed length otherwise.
    pub cut_length: Option<f64>,
    /// Take out the bias that noise has where the curve bends (docs/uncertainty.md).
    pub bias_correction: bool,
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
            // With noise of a tenth of the lean, half a standard error of s is bias.
            bias_correction: true,
            // At a gradient of 1e-10 the curve is at its optimum to rounding, for hardly more time than at 1e-2 (`hemline study accuracy`).
            solver: least_squares::Options::default(),
            limits: Limits::default(),
            weights: None,
            loss: Loss::Squares,
        }
    }
}

/// Fold counts tie if their Akaike weight is at least this share of the best: evidence of ten to one is the least that is called strong.
const TIE: f64 = 0.1;
/// … or, where the curve misses more than noise, if they are this near in distance: what it misses is no new evidence at every point, so weights
/// then say more than is known.
const TIE_IN_DISTANCE: f64 = 1.02;
/// The circle is compared by distance, whatever the folds had to be held to, if Akaike's criterion puts it no further behind than this: a weight of
/// e⁻¹⁵ is a certainty even among sixty counts.
const ROUND: f64 = 30.0;
/// A curve that leaves this many times the noise misses more than noise.
const MISFIT: f64 = 2.0;
/// Fold counts are compared on this many points; the best of them are then fitted to all. The weights of those that are not differ from
/// theirs by more than e⁻¹⁰.
const SCREENING_POINTS: usize = 256;
/// … which are those whose distance is within this factor of the least.
const CONTENDER: f64 = 1.05;
/// Akaike's criterion of even folds above the least by this puts a fold count out of the question: a weight of e⁻²⁰, and to spare for what
/// the paper's curve cannot do of what even folds can.
const HOPELESS: f64 = 40.0;
/// The same where folds are not even: even folds this many times nearer to the points leave no other count a chance. An orthogonal fit reaches
/// half the distance of a match in order, hardly less.
const FAR_OFF: f64 = 0.3;

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
    robust::check(profile.points().len(), options)?;
    if options.weights.is_some() && alike(options) {
        return fit(profile, &Options { weights: None, ..options.clone() });
    }
    match Frame::of(profile) {
        Some(frame) => fit_here(&frame.profile(profile), &frame.options(options)).map(|fit| frame.back(fit)),
        None => fit_here(profile, options),
    }
}

/// The fit of an outline about the origin and about a metre large.
fn fit_here(profile: &DrapeProfile, options: &Options) -> Result<HemFit, Error> {
    let points = profile.points();
    if robust::concerns(options) {
        return robust::fit(profile, options);
    }
    let (from, to) = match options.folds {
        Folds::Among { from, to } => (from.max(2), to),
        Folds::Exactly(m) => (m, m),
    };
    let plain = plainly_seen(points, to);
    let (fractions, seen) = if plain {
        (Vec::new(), u32::MAX)
    } else {
        let (fractions, _) = fractions(points);
        let seen = most_folds(&fractions);
        (fractions, seen)
    };
    if seen < from {
        return Err(Error::Unanswerable(format!(
            "{} points round the outline, as they lie, show at most {seen} folds; {from} folds need {} or more, {POINTS_A_FOLD} on each",
            points.len(),
            POINTS_A_FOLD * from as usize
        )));
    }
    let to = to.min(seen);
    if from <= to
        && swift::LIMIT <= options.solver.evaluation_limit
        && let Some(fit) = swiftly(points, from..=to, plain.then_some(to), seen, options)
    {
        return Ok(fit);
    }
    let fractions = if plain { super::outline::fractions(points).0 } else { fractions };
    let seen = if plain { most_folds(&fractions) } else { seen };
    let outline = smooth(profile);
    let work = Work::new(points, outline.places.clone(), &outline, options).weighing(options.weights.iter().flatten().copied());
    let round = circle::fit(points);
    let mut trials = work_through(&work, SCREENING_POINTS, from..=to);
    if !trials.iter().any(Trial::sane) {
        // What was sane on fewer points is not on all of them, and others were not pursued for its sake: once more, with all.
        trials = work_through(&work, points.len(), from..=to);
    }
    if let Folds::Among { .. } = options.folds {
        trials.insert(0, Trial::round(&round, points, outline.length));
    }
    let evaluations: usize = trials.iter().map(|t| t.evaluations).sum();

    let Some((best, candidates)) = choose(trials, &|trial| work.apart(trial), points.len() as f64) else {
        let tried = if from == to { format!("{from} folds") } else { format!("{from} to {to} folds") };
        return Err(Error::Unanswerable(format!(
            "no sane curve with {tried}: every fit leaves the outline's order or length, crosses itself, or strays from the outline"
        )));
    };
    let mut notes = notes(options, outline.length, points.len(), seen);
    notes.extend(note(&fractions, best.folds));
    let before = best.evaluations;
    let (best, correction) = bias::correct(best, &work, options.bias_correction);
    let evaluations = evaluations + best.evaluations - before;
    let seen = Seen {
        points,
        round: &round,
        outline_length: outline.length,
        noise: outline.noise,
        weights: &work.weights,
        limits: &options.limits,
    };
    Ok(outcome(best, correction, None, candidates, &seen, evaluations, notes))
}

/// The fit where the outline is a hem curve and noise beyond doubt.
///
/// `plain` is a fold count that the points are known to show all round.
fn swiftly(points: &[Point], folds: std::ops::RangeInclusive<u32>, plain: Option<u32>, seen: u32, options: &Options) -> Option<HemFit> {
    if matches!(options.length, HemLength::Held(_)) || options.weights.is_some() || !options.limits.none() {
        return None;
    }
    let asked = swift::Options { gradient_tolerance: options.solver.gradient_tolerance, bias_correction: options.bias_correction };
    let Swift { mut trials, finished, outline_length } = swift::fit(points, folds, &asked)?;
    let round = circle::fit(points);
    if let Folds::Among { .. } = options.folds {
        trials.insert(0, Trial::round(&round, points, outline_length));
    }
    let evaluations: usize = trials.iter().map(|t| t.evaluations).sum();
    let (best, candidates) = choose(trials, &|_| f64::INFINITY, points.len() as f64)?;
    // A stretch without enough points has to be told of, by the careful path.
    if plain != Some(best.folds) && !plainly_seen(points, best.folds) {
        return None;
    }
    let notes = notes(options, outline_length, points.len(), seen);
    let noise = best.rms();
    let before = best.evaluations;
    // The circle is left to the careful path, which knows what else to say of it.
    let finished = finished.into_iter().find(|f| f.trial.folds == best.folds)?;
    let evaluations = evaluations + finished.trial.evaluations - before;
    let seen = Seen { points, round: &round, outline_length, noise, weights: &[], limits: &options.limits };
    Some(outcome(finished.trial, finished.correction, Some(finished.known), candidates, &seen, evaluations, notes))
}

/// Whether all points weigh the same.
fn alike(options: &Options) -> bool {
    options.weights.as_ref().is_none_or(|weights| weights.windows(2).all(|pair| pair[0] == pair[1]))
}

/// Every fold count tried, ascending: on about `enough` points, the best of them then on all.
fn work_through(work: &Work, enough: usize, folds: std::ops::RangeInclusive<u32>) -> Vec<Trial> {
    let stride = work.points.len() / enough.max(8 * *folds.end() as usize);
    let fewer: Vec<Point> = work.points.iter().copied().step_by(stride.max(1)).collect();
    let places = work.outline.places.iter().copied().step_by(stride.max(1)).collect();
    let screening = Work::new(&fewer, places, work.outline, work.options).weighing(work.weights.iter().copied().step_by(stride.max(1)));
    let (hopeless, folds) = out_of_question(work.outline, folds);
    // The nearest match first: what it reaches tells which of the others can still compete.
    let radii = Radii::of(work.outline);
    let mut starts: Vec<Start> = folds.into_iter().map(|m| radii.matched(m)).collect();
    starts.sort_by(|a, b| a.rms.total_cmp(&b.rms));
    let mut trials: Vec<Trial> = hopeless;
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

/// Fold counts that the lines of even folds rule out, as trials not pursued, and those that are left.
fn out_of_question(outline: &Outline, folds: std::ops::RangeInclusive<u32>) -> (Vec<Trial>, Vec<u32>) {
    let evidence = |m: u32| outline.evidence.iter().find(|e| e.folds == m);
    let best = folds.clone().filter_map(evidence).min_by(|a, b| a.criterion.total_cmp(&b.criterion));
    let Some(best) = best else { return (Vec::new(), folds.collect()) };
    let beaten = |e: &Evidence| best.rms < FAR_OFF * e.rms || outline.even && best.criterion + HOPELESS < e.criterion;
    // Lines of half as many folds include those of a curve without lean: which of the two it is, the fit has to tell.
    let akin = |m: u32| m == 2 * best.folds || 2 * m == best.folds;
    let (out, left): (Vec<u32>, Vec<u32>) = folds.partition(|&m| !akin(m) && evidence(m).is_some_and(beaten));
    let round = |m: u32| Start {
        hem: Hem { p: outline.radius, q: 0.0, s: 0.0, folds: m },
        placement: Placement::ORIGIN,
        offset: 0.0,
        rms: evidence(m).map_or(f64::INFINITY, |e| e.rms),
    };
    (out.into_iter().map(round).map(|start| Trial::not_pursued(&start, start.rms)).collect(), left)
}

/// The most credible sane trial, and all of them with their weights; `None` if none is sane.
///
/// `apart` is how far a curve and the outline are apart when matched in order, both ways, m.
fn choose(trials: Vec<Trial>, apart: &dyn Fn(&Trial) -> f64, n: f64) -> Option<(Trial, Vec<Candidate>)> {
    let best_by = |criterion: &dyn Fn(&Trial) -> f64| {
        let sane = trials.iter().enumerate().filter(|(_, t)| t.sane());
        sane.map(|(i, t)| (i, criterion(t))).min_by(|a, b| a.1.total_cmp(&b.1))
    };
    // One of many counts fits chance better than one alone: each has to be as much better than the circle as the best of so many is by chance.
    let search = 2.0 * (trials.iter().filter(|t| t.folds != 0).count().max(1) as f64).ln();
    let near = |t: &Trial| t.aicc(t.rms(), n) - if t.folds == 0 { search } else { 0.0 };
    let (nearest, least) = best_by(&near)?;
    // Where the circle is nearly as good, what is held is noise.
    let round = trials.iter().any(|t| t.folds == 0 && t.sane() && near(t) <= least + ROUND);
    let free = round || matches!(trials[nearest].termination, Termination::Converged | Termination::NoFolds);
    let asked = matches!(trials[nearest].termination, Termination::LengthAsAsked);
    let matched: Vec<f64> = if free || asked {
        Vec::new()
    } else {
        // A circle is out of the question where folds had to be held to their length.
        trials.iter().map(|t| if t.sane() && t.folds != 0 { t.aicc(apart(t), n) } else { f64::INFINITY }).collect()
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

fn notes(options: &Options, outline_length: f64, points: usize, seen: u32) -> Vec<String> {
    let mut notes = Vec::new();
    if let Folds::Among { to, .. } = options.folds
        && seen < to
    {
        notes.push(format!("{points} points round the outline, as they lie, cannot show more than {seen} folds"));
    }
    if let (HemLength::Auto, Some(cut)) = (options.length, options.cut_length)
        && !agrees(outline_length, cut)
    {
        let percent = 100.0 * (outline_length / cut - 1.0);
        notes.push(format!(
            "the outline is {:.1} % {} than the hem was cut (tilted hem, wrong scale or missing cloth?): its own length counts",
            percent.abs(),
            if percent < 0.0 { "shorter" } else { "longer" }
        ));
    }
    notes
}

/// An angle in [0, 2π).
fn wrapped(t: f64) -> f64 {
    let once = if t < 0.0 { t + TAU } else { t };
    // The remainder proper is slow, and hardly ever needed.
    if (0.0..TAU).contains(&once) { once } else { t.rem_euclid(TAU) }
}

/// Fold counts as credible as the chosen one, with it; empty if there are none.
fn ties(candidates: &[Candidate], chosen: u32, n: f64, misfit: bool) -> Vec<u32> {
    let Some(best) = candidates.iter().find(|c| c.folds == chosen) else { return Vec::new() };
    let near = |c: &&Candidate| {
        c.weight.is_some_and(|weight| {
            TIE * best.weight.unwrap_or(0.0) <= weight || misfit && c.folds != 0 && c.aicc - best.aicc <= 2.0 * n * TIE_IN_DISTANCE.ln()
        })
    };
    let ties: Vec<u32> = candidates.iter().filter(near).map(|c| c.folds).collect();
    if ties.len() < 2 { Vec::new() } else { ties }
}

/// What is known of an outline besides its fit.
struct Seen<'a> {
    points: &'a [Point],
    round: &'a Circle,
    /// m.
    outline_length: f64,
    /// m.
    noise: f64,
    /// Weight of each point, of mean 1; empty where all are alike.
    weights: &'a [f64],
    limits: &'a Limits,
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
    correction: BiasCorrection,
    known: Option<Known>,
    candidates: Vec<Candidate>,
    seen: &Seen,
    evaluations: usize,
    mut notes: Vec<String>,
) -> HemFit {
    let rms = best.rms();
    let ties = ties(&candidates, best.folds, best.distances.len() as f64, MISFIT * seen.noise < rms);
    if !ties.is_empty() {
        let weighed = ties.iter().filter_map(|m| candidates.iter().find(|c| c.folds == *m));
        let told: Vec<String> = weighed.map(|c| format!("{} (weight {:.2})", c.folds, c.weight.unwrap_or(0.0))).collect();
        notes.push(format!("fold counts are tied: {}", told.join(", ")));
    }
    let weight = candidates.iter().find(|c| c.folds == best.folds).and_then(|c| c.weight).unwrap_or(0.0);
    let canonical = seen.limits.allow_canonical_form();
    let (hem, placement) = if canonical { best.hem.canonical(best.placement) } else { (best.hem, best.placement) };
    // Canonical form moves the crest, and with it the origin of t.
    let turned = best.placement.phase - placement.phase + if canonical && best.hem.p < 0.0 { PI } else { 0.0 };
    let feet: Vec<f64> = best.feet.iter().map(|t| wrapped(t + turned)).collect();
    notes.extend(bounds_met(&best.states));
    let sure = uncertainty(&Fitted {
        points: seen.points,
        weights: seen.weights,
        hem,
        placement,
        feet: &feet,
        states: &best.states,
        held: best.held.is_some(),
        termination: &best.termination,
        correction: &correction,
        // q → −q turns its covariances with all others.
        known: known.map(|known| if best.hem.q < 0.0 { known.turned() } else { known }),
    });
    let folded = best.folds != 0;
    if !folded && MISFIT * seen.noise < rms {
        notes.push("no fold count gave a sane curve nearer than the circle, which misses the outline by far more than its noise".into());
    }
    if folded && let Some(first) = sure.missing.first() {
        notes.push(first.why.reason().into());
    }
    if let BiasCorrection::Left(why @ (Uncorrected::SharpBends | Uncorrected::NoRoot | Uncorrected::BreaksRule)) = correction {
        notes.push(format!("the bias of curvature was left in: {}", why.reason()));
    }
    if correction.applied().is_some_and(|c| bias::NOTABLE_BEND < c.bend) {
        notes.push("the noise is wide against the sharpest bend: standard errors are too small by a tenth or more".into());
    }
    let [x0_error, y0_error, phase_error, p_error, q_error, s_error] = sure.standard_errors;
    let (low, high) = if folded { hem.radius_range() } else { (hem.p, hem.p) };
    HemFit {
        p: Estimate { value: hem.p, standard_error: p_error },
        q: folded.then_some(Estimate { value: hem.q, standard_error: q_error }),
        s: folded.then_some(Estimate { value: hem.s, standard_error: s_error }),
        placement_errors: [x0_error, y0_error, phase_error],
        covariance: sure.covariance.map(|c| std::array::from_fn(|i| std::array::from_fn(|j| c[i + 3][j + 3]))),
        correlation: sure.covariance.as_ref().map(correlation),
        standard_error_missing: sure.missing,
        degrees_of_freedom: sure.degrees_of_freedom,
        bias_correction: correction,
        intervals: None,
        folds: folded.then_some(best.folds),
        folds_weight: weight,
        ties,
        candidates,
        rms,
        perimeter: if folded { hem.perimeter() } else { TAU * hem.p },
        area: hem.area(),
        fold_depth: high - low,
        outline_length: seen.outline_length,
        explained: (1.0 - best.sum_of_squares / seen.round.sum_of_squares).clamp(0.0, 1.0),
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
