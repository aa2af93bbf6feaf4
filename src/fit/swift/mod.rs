//! The fit of an outline that is nothing but a hem curve and noise: certified in a few dozen evaluations, or left to the careful path.
//!
//! Most outlines of a large batch are of this kind. What is returned is the same optimum that the careful path finds; where there is any doubt
//! about it, or about the rules, nothing is returned.

mod certificate;
mod fit;
mod kernel;
mod spectrum;

use std::ops::RangeInclusive;

pub(super) use self::fit::LIMIT;
use self::fit::{Corrected, Ended, Optimum, Wish, cholesky};
use self::kernel::{Blocks, Curve};
use self::spectrum::{Spectrum, centroid};
use super::bias::{BiasCorrection, Correction, Uncorrected, too_sharp};
use super::trial::Trial;
use super::uncertainty::Known;
use crate::experiment::Point;
use crate::model::hem::Placement;

/// A fit by orthogonal distance reaches this share of the radial misfit of its harmonics, hardly less.
const LEAST_GAIN: f64 = 0.4;
/// A curve whose distance is above that of the best by this factor has no weight left, whichever rule it breaks.
const BEATEN: f64 = 1.2;

/// What is asked of a fit.
pub(super) struct Options {
    /// Largest cosine between the distances and a column of the Jacobian.
    pub gradient_tolerance: f64,
    /// Take out the bias of curvature.
    pub bias_correction: bool,
}

/// Every fold count tried, what to report of those that were fitted, and the outline's own length, m.
pub(super) struct Swift {
    /// The optima of least squares, which are what evidence is taken from.
    pub trials: Vec<Trial>,
    pub finished: Vec<Finished>,
    pub outline_length: f64,
}

/// A certified curve as it is reported.
pub(super) struct Finished {
    pub trial: Trial,
    pub correction: BiasCorrection,
    pub known: Known,
}

/// Fits every fold count in question; `None` where the careful path has to decide.
pub(super) fn fit(points: &[Point], folds: RangeInclusive<u32>, options: &Options) -> Option<Swift> {
    let mut blocks = Blocks::new(points, centroid(points)?);
    let n = points.len() as f64;
    let (from, to) = (*folds.start(), *folds.end());
    let spectrum = if from == to { Spectrum::of_folds(&blocks, from) } else { Spectrum::new(&blocks, 3 * to) };
    let mut order: Vec<(f64, u32)> = folds.map(|m| (spectrum.left_by(m), m)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut wish = Wish { gradient_tolerance: options.gradient_tolerance, beaten: f64::INFINITY };
    let mut swift = Swift { trials: Vec::with_capacity(order.len() + 1), finished: Vec::new(), outline_length: 0.0 };
    for (left, m) in order {
        if (wish.beaten / n).sqrt() < BEATEN * LEAST_GAIN * left {
            swift.trials.push(Trial::left_aside(m, left));
            continue;
        }
        let ended = match spectrum::leaning(&blocks, m).map(|start| fit::fit(&mut blocks, &start, &wish)) {
            None | Some(Ended::Lost) => fit::fit(&mut blocks, &spectrum.upright(m), &wish),
            Some(ended) => ended,
        };
        match ended {
            Ended::Converged(optimum) if wish.beaten < optimum.sums.square => {
                swift.trials.push(Trial::left_aside(m, (optimum.sums.square / n).sqrt()));
            }
            Ended::Converged(optimum) => {
                let (trial, finished, length) = certified(points, &mut blocks, &optimum, options)?;
                if BEATEN * BEATEN * trial.sum_of_squares < wish.beaten {
                    wish.beaten = BEATEN * BEATEN * trial.sum_of_squares;
                    swift.outline_length = length;
                }
                swift.trials.push(trial);
                swift.finished.push(finished);
            }
            Ended::Beaten { sum_of_squares } => swift.trials.push(Trial::left_aside(m, (sum_of_squares / n).sqrt())),
            Ended::Lost => return None,
        }
    }
    swift.trials.sort_by_key(|trial| trial.folds);
    Some(swift)
}

/// The trial of a certified optimum, what to report of it, and the outline's length, m.
fn certified(points: &[Point], blocks: &mut Blocks, optimum: &Optimum, options: &Options) -> Option<(Trial, Finished, f64)> {
    let before = &optimum.curve;
    let square = optimum.sums.square;
    let noise = fit::noise_variance_of(blocks).sqrt();
    let bend = noise * optimum.sums.sharpest;
    let reason = if options.bias_correction { too_sharp(bend).then_some(Uncorrected::SharpBends) } else { Some(Uncorrected::Off) };
    let (curve, sums, correction, rounds) = match reason {
        Some(reason) => (*before, None, BiasCorrection::Left(reason), 0),
        None => {
            let Corrected { curve, sums, noise_variance, rounds } = fit::correct(blocks, optimum, options.gradient_tolerance)?;
            let correction = Correction {
                p: curve.hem.p - before.hem.p,
                q: curve.hem.q.abs() - before.hem.q.abs(),
                s: curve.hem.s - before.hem.s,
                sigma: noise_variance.sqrt(),
                bend,
                rounds,
            };
            (curve, Some(sums), BiasCorrection::Applied(correction), rounds)
        }
    };
    let sums = sums.as_ref().unwrap_or(&optimum.sums);
    let finish = kernel::finish(blocks, &curve);
    let length = certificate::outline_length(blocks, &curve.hem, &finish)?;
    let distances = blocks.each(|block| block.distance);
    let known = Known { inverse: cholesky(&sums.normal, 0.0)?.inverse(), square: sums.corrected };
    let trial = |curve: &Curve, square: f64, evaluations: usize, feet: Vec<f64>, distances: Vec<f64>| {
        let placement = Placement { x0: blocks.origin.x + curve.x0, y0: blocks.origin.y + curve.y0, phase: curve.sin.atan2(curve.cos) };
        Trial::swift(curve.hem, placement, feet, distances, square, evaluations)
    };
    let reported = trial(&curve, sums.square, optimum.evaluations + rounds, finish.feet, distances);
    // Of the optimum itself only its sum of squares is asked for; its distances are as many as there are points.
    let least = trial(before, square, optimum.evaluations, Vec::new(), vec![0.0; points.len()]);
    Some((least, Finished { trial: reported, correction, known }, length))
}

#[cfg(test)]
mod tests;
