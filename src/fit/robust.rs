//! Fits in which not every point counts in full: gross errors under a loss that forgives them, and points of weight zero.
//!
//! The fold count, the rules and the start come from an ordinary fit to the points that look sound. At first those are the points near their
//! neighbours in the order of the input (gross errors of many points can spoil an order that was reconstructed), or in the plane where the input has no order; then those
//! near the curve. From there all points are fitted under the loss.

use super::bias::{BiasCorrection, Uncorrected};
use super::folds::{self, Options};
use super::foot_point::{centred, nearest};
use super::median;
use super::mended::{Mended, clockwise};
use super::orthogonal::{Conditions, UNKNOWNS, fit_robustly};
use super::outcome::{Estimate, HemFit, RobustOutcome, Rule, Termination};
use super::outline::{Outline, smooth};
use super::rules::{Evidence, broken};
use super::start::LengthTable;
use super::uncertainty::{MissingError, Unknown, WhyMissing, correlation};
use crate::error::Error;
use crate::experiment::campaign::Folds;
use crate::experiment::profile::FEWEST_POINTS;
use crate::experiment::{DrapeProfile, Point};
use crate::model::hem::{Hem, Placement};
use crate::numerics::least_squares::{self, DOWNWEIGHTED, Loss, Robust, State, check_weights, median_scale};

/// Neighbours on either side that say where a point should be. A majority of them must be sound: with a fifth of gross errors eight neighbours
/// have five bad ones among them for one point in a hundred.
const NEIGHBOURS: usize = 4;
/// A point further from the median of its neighbours than so many times their own median distance is set aside at first; on a circle the
/// middle point is nearer than its neighbours are, at a sharp
/// crest as far as they are.
const ASIDE: f64 = 2.5;
/// A foot may slip along the curve by this share of its length, and by half of what its neighbours' feet do: a fifth of what the rule of order
/// allows.
const SLIP: f64 = 0.002;
/// Passes of that.
const PASSES: usize = 3;
/// Where the input has no order: a point whose third neighbour is so many times further off than is usual is set aside at first.
const ISOLATED: f64 = 3.0;
/// Points within so many scales of the curve are sound; a normal error is beyond once in two thousand.
const SOUND: f64 = 3.5;
/// Rounds of choosing the sound points; after the second hardly a point changes sides.
const ROUNDS: usize = 6;
/// The same where even folds told them: these are nearly all of them at once.
const EVEN_ROUNDS: usize = 3;

/// Whether the ordinary fit cannot answer this alone.
pub(super) fn concerns(options: &Options) -> bool {
    options.loss != Loss::Squares || options.weights.as_ref().is_some_and(|weights| weights.contains(&0.0))
}

/// Checks weights and limits for a profile of `points` points.
///
/// # Errors
/// [`Error::Unanswerable`] or [`Error::Invalid`], saying what is wrong.
pub(super) fn check(points: usize, options: &Options) -> Result<(), Error> {
    options.limits.check()?;
    let Some(weights) = &options.weights else { return Ok(()) };
    if weights.len() != points {
        return Err(Error::Unanswerable(format!("{} weights for {points} points; one for each is needed", weights.len())));
    }
    check_weights(weights, points)?;
    let counted = weights.iter().filter(|&&w| 0.0 < w).count();
    if counted < FEWEST_POINTS {
        return Err(Error::Unanswerable(format!("{counted} points of positive weight; at least {FEWEST_POINTS} are needed")));
    }
    Ok(())
}

/// The fit of the points that count.
pub(super) fn fit(profile: &DrapeProfile, options: &Options) -> Result<HemFit, Error> {
    let points = profile.points();
    let mean = options.weights.as_ref().map(|weights| weights.iter().sum::<f64>() / weights.iter().filter(|&&w| 0.0 < w).count() as f64);
    let prior: Vec<f64> = options.weights.iter().flatten().map(|w| w / mean.unwrap_or(1.0)).collect();
    let counts = |i: usize| prior.get(i).is_none_or(|&w| 0.0 < w);
    if options.loss == Loss::Squares {
        let sound: Vec<bool> = (0..points.len()).map(counts).collect();
        let Ordinary { mut fit, .. } = ordinary(profile, &sound, options)?;
        // Its distances are those of all points, so what asks for points that count alike has to know.
        fit.bias_correction = BiasCorrection::Left(Uncorrected::Weighted);
        return Ok(fit);
    }
    if let Some(fit) = by_even_folds(profile, options, &prior) {
        return Ok(fit);
    }
    let (first, ordered) = at_first(profile);
    let mut sound: Vec<bool> = first.into_iter().enumerate().map(|(i, near)| near && counts(i)).collect();
    let mut evaluations = 0;
    for round in 1.. {
        let start = ordinary(profile, &sound, options)?;
        evaluations += start.fit.evaluations;
        let weighted: Vec<f64> = start.fit.distances.iter().enumerate().map(|(i, d)| d * prior.get(i).map_or(1.0, |w| w.sqrt())).collect();
        let scale = median_scale(&weighted, &prior);
        // Rounding of the coordinates: where the sound points lie on the curve exactly, none of them is to be lost.
        let near = (SOUND * scale).max(1e-9 * start.outline.radius);
        let counted: Vec<bool> = (0..points.len()).map(|i| counts(i) && weighted[i].abs() <= near).collect();
        let mut next = counted.clone();
        if ordered {
            // A gross error may come to lie on the curve, but hardly where its neighbours are.
            let near = in_order(points, in_input_order(profile).into_iter().filter(|&i| next[i]).collect());
            next = marked(points.len(), in_place(&start.fit.hem, &start.fit.feet, near));
        }
        let changed = next.iter().zip(&sound).filter(|(a, b)| a != b).count();
        let enough = FEWEST_POINTS.max(points.len() / 4) <= next.iter().filter(|&&s| s).count();
        if enough && ROUNDS > round && (if start.fit.termination == Termination::Converged { points.len() / 200 } else { 0 }) < changed {
            sound = next;
            continue;
        }
        let Ordinary { fit, outline, kept, order } = start;
        return Ok(finished(points, HemFit { evaluations, ..fit }, &Setting { outline, kept, order, counted, prior, options }));
    }
    unreachable!("the last round returns")
}

/// The fit where even folds tell the sound points; `None` where they do not, or where what they lead to is no sane free optimum.
///
/// The gross errors are put where the folds say, so that the outline has neither holes nor strays; the ordinary fit to that is the start.
fn by_even_folds(profile: &DrapeProfile, options: &Options, prior: &[f64]) -> Option<HemFit> {
    let points = profile.points();
    let mut input = in_input_order(profile);
    let in_order = |input: &[usize]| input.iter().map(|&i| points[i]).collect::<Vec<Point>>();
    if clockwise(&in_order(&input)) {
        input.reverse();
    }
    let (from, to) = match options.folds {
        Folds::Among { from, to } => (from.max(2), to),
        Folds::Exactly(m) => (m, m),
    };
    let mended = Mended::of(&in_order(&input), from, to)?;
    let weight = |i: usize| prior.get(i).copied().unwrap_or(1.0);
    // By place in the input.
    let mut sound: Vec<bool> = input.iter().zip(&mended.placed).map(|(&i, placed)| *placed && 0.0 < weight(i)).collect();
    let mut evaluations = 0;
    for round in 1.. {
        if 2 * sound.iter().filter(|s| **s).count() < points.len().max(2 * FEWEST_POINTS) {
            return None;
        }
        let whole = DrapeProfile::new(&mended.points(&sound)).ok()?;
        let fit = folds::fit(&whole, &Options { loss: Loss::Squares, weights: None, bias_correction: false, ..options.clone() }).ok()?;
        evaluations += fit.evaluations;
        if !matches!(fit.termination, Termination::Converged | Termination::LengthAsAsked) {
            return None;
        }
        let mut known = vec![None; points.len()];
        for (place, &k) in whole.source_index().iter().enumerate().filter(|(_, k)| sound[**k]) {
            known[input[k]] = Some((fit.feet[place], fit.distances[place]));
        }
        let (feet, distances): (Vec<f64>, Vec<f64>) = points
            .iter()
            .zip(known)
            .map(|(point, known)| {
                known.unwrap_or_else(|| {
                    let foot = nearest(&fit.hem, centred(*point, &fit.placement), 12);
                    (foot.t, foot.distance())
                })
            })
            .unzip();
        let weighted: Vec<f64> = distances.iter().enumerate().map(|(i, d)| d * weight(i).sqrt()).collect();
        let mut among_sound = vec![0.0; points.len()];
        input.iter().zip(&sound).for_each(|(&i, s)| among_sound[i] = f64::from(u8::from(*s)));
        let near = (SOUND * median_scale(&weighted, &among_sound)).max(1e-9 * fit.hem.p);
        let counted: Vec<bool> = (0..points.len()).map(|i| 0.0 < weight(i) && weighted[i].abs() <= near).collect();
        let next: Vec<bool> = input.iter().zip(&mended.placed).map(|(&i, placed)| *placed && counted[i]).collect();
        let changed = next.iter().zip(&sound).filter(|(a, b)| a != b).count();
        if points.len() / 200 < changed && round < EVEN_ROUNDS {
            sound = next;
            continue;
        }
        let places: Vec<usize> = whole.source_index().iter().copied().filter(|&k| sound[k]).collect();
        let setting = Setting {
            outline: smooth(&whole),
            kept: places.iter().map(|&k| points[input[k]]).collect(),
            order: places.iter().map(|&k| input[k]).collect(),
            counted,
            prior: prior.to_vec(),
            options,
        };
        let fit = finished(points, HemFit { feet, distances, evaluations, ..fit }, &setting);
        return fit.robust.as_ref().is_some_and(|robust| !robust.rounds.is_empty()).then_some(fit);
    }
    unreachable!("the last round returns")
}

/// What the fit to all points needs besides its start.
struct Setting<'a> {
    /// Smooth outline of the sound points.
    outline: Outline,
    /// The sound points, in order.
    kept: Vec<Point>,
    /// Which points of the profile these are, in their order: the profile's own may be spoiled by the gross errors.
    order: Vec<usize>,
    /// The points near the curve, these and some whose order is in doubt: those that enter the fit under the loss.
    counted: Vec<bool>,
    /// Weights of all points, of mean one; empty where all are alike.
    prior: Vec<f64>,
    options: &'a Options,
}

/// An ordinary fit to the sound points.
struct Ordinary {
    /// With feet and distances of all points: those of the others are the nearest anywhere on the curve.
    fit: HemFit,
    outline: Outline,
    /// The sound points, in order round the outline, and which points of the profile they are.
    kept: Vec<Point>,
    order: Vec<usize>,
}

fn ordinary(profile: &DrapeProfile, sound: &[bool], options: &Options) -> Result<Ordinary, Error> {
    let points = profile.points();
    // In the order of the input: without the gross errors it may go round the outline.
    let chosen: Vec<usize> = in_input_order(profile).into_iter().filter(|&i| sound[i]).collect();
    let sounder = DrapeProfile::new(&chosen.iter().map(|&i| points[i]).collect::<Vec<Point>>())?;
    let weights = options.weights.as_ref().map(|all| sounder.source_index().iter().map(|&i| all[chosen[i]]).collect());
    let fit = folds::fit(&sounder, &Options { loss: Loss::Squares, weights, bias_correction: false, ..options.clone() })?;
    let mut known = vec![None; points.len()];
    for (place, &i) in sounder.source_index().iter().enumerate() {
        known[chosen[i]] = Some((fit.feet[place], fit.distances[place]));
    }
    let (feet, distances) = points
        .iter()
        .zip(known)
        .map(|(point, known)| {
            known.unwrap_or_else(|| {
                let foot = nearest(&fit.hem, centred(*point, &fit.placement), 24);
                (foot.t, foot.distance())
            })
        })
        .unzip();
    let order = sounder.source_index().iter().map(|&i| chosen[i]).collect();
    Ok(Ordinary { fit: HemFit { feet, distances, ..fit }, outline: smooth(&sounder), kept: sounder.points().to_vec(), order })
}

/// Indices of the profile's points in the order in which they were given.
fn in_input_order(profile: &DrapeProfile) -> Vec<usize> {
    let mut order: Vec<usize> = (0..profile.points().len()).collect();
    order.sort_by_key(|&i| profile.source_index()[i]);
    order
}

/// All points fitted under the loss from an ordinary fit to the sound ones.
fn finished(points: &[Point], start: HemFit, setting: &Setting) -> HemFit {
    let Setting { prior, options, .. } = setting;
    let loss = options.loss;
    let free = matches!(start.termination, Termination::Converged | Termination::Stalled | Termination::EvaluationLimit);
    let held = start.held.map(|held| held.length);
    if start.folds.is_none() || !free && held.is_none() {
        // A circle, or a match in order: no minimum of the orthogonal distance to be weighed anew. The points are judged by it all the same.
        let note = format!("{loss} chose the points; the curve is that of an ordinary fit to the sound ones");
        return judged(start, &setting.prior, loss, note);
    }
    // Under Huber's loss gross errors on one side still pull, each as much as one at 1.345 scales: those set aside stay aside.
    let among_sound: Vec<f64> =
        setting.counted.iter().enumerate().map(|(i, sound)| if *sound { prior.get(i).copied().unwrap_or(1.0) } else { 0.0 }).collect();
    let prior = &among_sound;
    let conditions = Conditions { length: held, outline_length: start.outline_length, weights: prior, limits: &options.limits };
    let fitted = fit_robustly(points, start.hem, start.placement, start.feet.clone(), &conditions, loss, &options.solver);
    let (hem, placement, new_feet, mut robust) = match fitted {
        Ok(fitted) => fitted,
        Err(reason) => {
            let note = format!("not fitted under {loss} ({reason}); the curve is that of an ordinary fit to the sound points");
            return judged(start, &setting.prior, loss, note);
        }
    };
    let spent = start.evaluations + robust.summary.evaluations;
    if let Some(rule) = rule_broken(&hem, &placement, &new_feet, &robust, setting, held.unwrap_or(start.outline_length)) {
        let note = format!("under {loss} the curve breaks a rule ({rule:?}); it is that of an ordinary fit to the sound points");
        return judged(HemFit { evaluations: spent, ..start }, &setting.prior, loss, note);
    }
    for (weight, sound) in robust.weights.iter_mut().zip(&setting.counted) {
        if !sound {
            *weight = 0.0;
        }
    }
    robust.downweighted = robust.weights.iter().filter(|&&w| w < DOWNWEIGHTED).count();
    weighed(points, start, (hem, placement, new_feet), robust, spent, setting, prior)
}

/// The rule that a curve breaks by the points that count.
fn rule_broken(hem: &Hem, placement: &Placement, feet: &[f64], robust: &Robust, setting: &Setting, length: f64) -> Option<Rule> {
    let counted: Vec<usize> = setting.order.iter().copied().filter(|&i| DOWNWEIGHTED <= robust.weights[i]).collect();
    let distances: Vec<f64> = counted.iter().map(|&i| robust.summary.residuals[i]).collect();
    let feet: Vec<f64> = counted.iter().map(|&i| feet[i]).collect();
    if feet.len() < FEWEST_POINTS {
        return Some(Rule::Nearness);
    }
    let rms = (distances.iter().map(|d| d * d).sum::<f64>() / distances.len() as f64).sqrt();
    let farthest = distances.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
    let evidence = Evidence { outline: &setting.outline, points: &setting.kept, feet: &feet, distances: &distances, farthest, rms, length };
    broken(hem, placement, &evidence)
}

/// The outcome of a fit under the loss.
fn weighed(
    points: &[Point],
    start: HemFit,
    (hem, placement, feet): (Hem, Placement, Vec<f64>),
    robust: Robust,
    evaluations: usize,
    setting: &Setting,
    prior: &[f64],
) -> HemFit {
    let options = setting.options;
    let mut notes = start.notes.clone();
    notes.retain(|note| !note.starts_with("no standard errors") && !note.contains("bound;"));
    let known = robust.covariance(options.loss, prior, &UNKNOWNS);
    if let Err(reason) = &known {
        notes.push(format!("no standard errors: {reason}"));
    }
    let degrees_of_freedom = known.as_ref().map_or(0, |c| c.degrees_of_freedom);
    let whole: Option<[[f64; 6]; 6]> = known.ok().map(|c| std::array::from_fn(|i| std::array::from_fn(|j| c.matrix[(i, j)])));
    let covariance = whole.map(|c| std::array::from_fn(|i| std::array::from_fn(|j| c[i + 3][j + 3])));
    let states: [State; 6] = std::array::from_fn(|j| robust.summary.states[j]);
    notes.extend(folds::bounds_met(&states));
    let estimate = |i: usize, value: f64| Estimate {
        value,
        standard_error: covariance.filter(|_| states[i + 3] == State::Free).map(|c: [[f64; 3]; 3]| c[i][i].max(0.0).sqrt()),
    };
    let error = |i: usize| whole.filter(|_| states[i] == State::Free).map(|c| c[i][i].max(0.0).sqrt());
    let missing = |i: usize| match (whole, states[i]) {
        (_, State::Fixed) => Some(WhyMissing::Held),
        (_, State::AtLower | State::AtUpper) => Some(WhyMissing::AtBound),
        (None, State::Free) => Some(WhyMissing::NotDetermined),
        (Some(_), State::Free) => None,
    };
    let distances = robust.summary.residuals.clone();
    let weight = |i: usize| robust.weights[i] * prior.get(i).unwrap_or(&1.0);
    let total: f64 = (0..points.len()).map(weight).sum();
    let square: f64 = (0..points.len()).map(|i| weight(i) * distances[i] * distances[i]).sum();
    let (low, high) = hem.radius_range();
    let termination = match robust.summary.termination {
        least_squares::Termination::Stalled => Termination::Stalled,
        least_squares::Termination::EvaluationLimit => Termination::EvaluationLimit,
        _ => start.termination.clone(),
    };
    if !robust.settled && robust.scale > 0.0 {
        notes.push("the weights of the points have not settled".into());
    }
    let rms = (square / total).sqrt();
    HemFit {
        p: estimate(0, hem.p),
        q: Some(estimate(1, hem.q)),
        s: Some(estimate(2, hem.s)),
        covariance,
        placement_errors: [error(0), error(1), error(2)],
        correlation: whole.filter(|_| states == [State::Free; 6]).as_ref().map(correlation),
        standard_error_missing: (0..6).filter_map(|i| Some(MissingError { unknown: Unknown::ALL[i], why: missing(i)? })).collect(),
        degrees_of_freedom,
        rms,
        // The same total, the squares that the curve now leaves.
        explained: if 0.0 < start.rms {
            (1.0 - (1.0 - start.explained) * (rms / start.rms).powi(2)).clamp(0.0, 1.0)
        } else {
            start.explained
        },
        perimeter: hem.perimeter(),
        area: hem.area(),
        fold_depth: high - low,
        held: start
            .held
            .map(|held| super::outcome::HeldLength { multiplier: robust.summary.multiplier.unwrap_or(held.multiplier), ..held }),
        hem,
        placement,
        feet,
        distances,
        termination,
        states,
        bias_correction: BiasCorrection::Left(Uncorrected::Weighted),
        evaluations,
        notes,
        robust: Some(RobustOutcome {
            loss: options.loss,
            scale: robust.scale,
            weights: robust.weights,
            downweighted: robust.downweighted,
            rounds: robust.rounds,
            settled: robust.settled,
        }),
        ..start
    }
}

/// An ordinary fit, with the points weighed by their distances from it.
fn judged(mut fit: HemFit, prior: &[f64], loss: Loss, note: String) -> HemFit {
    let weighted: Vec<f64> = fit.distances.iter().enumerate().map(|(i, d)| d * prior.get(i).map_or(1.0, |w| w.sqrt())).collect();
    let scale = median_scale(&weighted, prior);
    let weights: Vec<f64> = weighted.iter().map(|d| if 0.0 < scale { loss.weight(d / scale) } else { 1.0 }).collect();
    let downweighted = weights.iter().filter(|&&w| w < DOWNWEIGHTED).count();
    fit.notes.push(note);
    fit.bias_correction = BiasCorrection::Left(Uncorrected::Weighted);
    fit.robust = Some(RobustOutcome { loss, scale, weights, downweighted, rounds: vec![], settled: true });
    fit
}

/// The points that look sound before any curve is known, and whether the input has an order by which that could be told.
fn at_first(profile: &DrapeProfile) -> (Vec<bool>, bool) {
    let points = profile.points();
    let left = near_in_the_plane(points, in_order(points, in_input_order(profile)));
    let kept: Vec<Point> = left.iter().map(|&i| points[i]).collect();
    if points.len() < 2 * kept.len() && DrapeProfile::new(&kept).is_ok_and(|kept| !kept.was_scattered()) {
        return (marked(points.len(), left), true);
    }
    (marked(points.len(), near_in_the_plane(points, (0..points.len()).collect())), false)
}

fn marked(n: usize, chosen: Vec<usize>) -> Vec<bool> {
    let mut marked = vec![false; n];
    chosen.into_iter().for_each(|i| marked[i] = true);
    marked
}

/// Those of the chosen points, in this order, that lie where their neighbours say.
///
/// What looked sound among gross errors may not without them: a few passes, each over what the last one left.
fn in_order(points: &[Point], mut chosen: Vec<usize>) -> Vec<usize> {
    for _ in 0..PASSES {
        if chosen.len() < FEWEST_POINTS {
            break;
        }
        let near = near_their_neighbours(&chosen.iter().map(|&i| points[i]).collect::<Vec<Point>>());
        chosen = chosen.into_iter().zip(near).filter_map(|(i, near)| near.then_some(i)).collect();
    }
    chosen
}

/// Those of the chosen points, in this order, whose feet lie along the curve where those of their neighbours say.
fn in_place(hem: &Hem, feet: &[f64], mut chosen: Vec<usize>) -> Vec<usize> {
    let table = LengthTable::of(hem);
    for _ in 0..PASSES {
        let n = chosen.len();
        if n < FEWEST_POINTS {
            break;
        }
        let places: Vec<f64> = chosen.iter().map(|&i| table.fraction(feet[i])).collect();
        let keep = |k: usize| {
            // Ahead of this one's place, by at most half a turn.
            let ahead: Vec<f64> = (1..=NEIGHBOURS)
                .flat_map(|j| [(k + j) % n, (k + n - j) % n])
                .map(|j| places[j] - places[k])
                .map(|d| d - d.round())
                .collect();
            let middle = median(ahead.clone());
            let usual = median(ahead.iter().map(|d| (d - middle).abs()).collect());
            middle.abs() <= SLIP + 0.5 * usual
        };
        let kept: Vec<bool> = (0..n).map(keep).collect();
        chosen = chosen.into_iter().zip(kept).filter_map(|(i, keep)| keep.then_some(i)).collect();
    }
    chosen
}

/// Those of the chosen points that lie in a crowd, after a few passes.
fn near_in_the_plane(points: &[Point], mut chosen: Vec<usize>) -> Vec<usize> {
    for _ in 0..PASSES {
        let crowded = not_isolated(&chosen.iter().map(|&i| points[i]).collect::<Vec<Point>>());
        chosen = chosen.into_iter().zip(crowded).filter_map(|(i, crowded)| crowded.then_some(i)).collect();
    }
    chosen
}

/// For each point of an ordered outline whether it lies where its neighbours say: not much further from their median than they are themselves.
fn near_their_neighbours(points: &[Point]) -> Vec<bool> {
    let n = points.len();
    let reach = NEIGHBOURS.min((n - 1) / 2);
    (0..n)
        .map(|i| {
            let around = || (1..=reach).flat_map(|k| [points[(i + k) % n], points[(i + n - k) % n]]);
            let middle = Point::new(median(around().map(|p| p.x).collect()), median(around().map(|p| p.y).collect()));
            let usual = median(around().map(|p| p.distance(middle)).collect());
            points[i].distance(middle) <= ASIDE * usual
        })
        .collect()
}

/// For each point whether its third neighbour in the plane is as near as is usual.
fn not_isolated(points: &[Point]) -> Vec<bool> {
    let n = points.len();
    // Along x no neighbour is nearer than the difference of abscissas.
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| points[a].x.total_cmp(&points[b].x));
    let mut third = vec![0.0; n];
    for (place, &i) in order.iter().enumerate() {
        let mut nearest = [f64::INFINITY; 3];
        let mut take = |j: usize| {
            if points[i].x.max(points[j].x) - points[i].x.min(points[j].x) >= nearest[2] {
                return false;
            }
            let distance = points[i].distance(points[j]);
            if distance < nearest[2] {
                nearest[2] = distance;
                nearest.sort_by(f64::total_cmp);
            }
            true
        };
        let _ = order[place + 1..].iter().all(|&j| take(j));
        let _ = order[..place].iter().rev().all(|&j| take(j));
        third[i] = nearest[2];
    }
    let usual = median(third.clone());
    third.into_iter().map(|distance| distance <= ISOLATED * usual).collect()
}
