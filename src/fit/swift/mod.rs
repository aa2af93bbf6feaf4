//! The fit of an outline that is nothing but a hem curve and noise: certified in a few dozen evaluations, or left to the careful path.
//!
//! Most outlines of a large batch are of this kind. What is returned is the same optimum that the careful path finds; where there is any doubt
//! about it, or about the rules, nothing is returned.

mod certificate;
mod fit;
mod kernel;
mod spectrum;

use std::ops::RangeInclusive;

use self::fit::{Ended, Optimum, Wish, cholesky};
use self::kernel::{Blocks, UNKNOWNS};
use self::spectrum::{Spectrum, centroid};
use super::trial::Trial;
use crate::experiment::Point;
use crate::model::hem::Placement;

/// A fit by orthogonal distance reaches this share of the radial misfit of its harmonics, hardly less.
const LEAST_GAIN: f64 = 0.4;
/// A curve whose distance is above that of the best by this factor has no weight left, whichever rule it breaks.
const BEATEN: f64 = 1.2;

/// Every fold count tried, and the outline's own length, m.
pub(super) struct Swift {
    pub trials: Vec<Trial>,
    pub outline_length: f64,
}

/// Fits every fold count in question; `None` where the careful path has to decide.
pub(super) fn fit(points: &[Point], folds: RangeInclusive<u32>, gradient_tolerance: f64) -> Option<Swift> {
    let mut blocks = Blocks::new(points, centroid(points)?);
    let n = points.len() as f64;
    let (from, to) = (*folds.start(), *folds.end());
    let spectrum = if from == to { Spectrum::of_folds(&blocks, from) } else { Spectrum::new(&blocks, 3 * to) };
    let mut order: Vec<(f64, u32)> = folds.map(|m| (spectrum.left_by(m), m)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut wish = Wish { gradient_tolerance, bias_correction: false, beaten: f64::INFINITY };
    let mut trials = Vec::with_capacity(order.len() + 1);
    let mut outline_length = 0.0;
    for (left, m) in order {
        if (wish.beaten * n).sqrt() < BEATEN * LEAST_GAIN * left * n {
            trials.push(Trial::left_aside(m, left));
            continue;
        }
        let start = spectrum.curve(m, false);
        let ended = match fit::fit(&mut blocks, &start, &wish) {
            Ended::Lost => fit::fit(&mut blocks, &spectrum.curve(m, true), &wish),
            ended => ended,
        };
        match ended {
            Ended::Converged(optimum) if wish.beaten < optimum.sums.square => {
                trials.push(Trial::left_aside(m, (optimum.sums.square / n).sqrt()));
            }
            Ended::Converged(optimum) => {
                let (trial, length) = certified(points, &blocks, &optimum)?;
                if BEATEN * BEATEN * trial.sum_of_squares < wish.beaten {
                    wish.beaten = BEATEN * BEATEN * trial.sum_of_squares;
                    outline_length = length;
                }
                trials.push(trial);
            }
            Ended::Beaten { sum_of_squares } => trials.push(Trial::left_aside(m, (sum_of_squares / n).sqrt())),
            Ended::Lost => return None,
        }
    }
    trials.sort_by_key(|trial| trial.folds);
    Some(Swift { trials, outline_length })
}

/// The trial of a certified optimum, and the outline's length, m.
fn certified(points: &[Point], blocks: &Blocks, optimum: &Optimum) -> Option<(Trial, f64)> {
    let Optimum { curve, sums, evaluations, .. } = optimum;
    let finish = kernel::finish(blocks, curve);
    let distances = blocks.each(|block| block.distance);
    let length = certificate::outline_length(points, &curve.hem, &distances, &finish)?;
    let freedom = points.len().checked_sub(UNKNOWNS).filter(|&f| 0 < f)?;
    let inverse = cholesky(&sums.normal, 0.0)?.inverse();
    let variance = sums.square / freedom as f64;
    let covariance = std::array::from_fn(|i| std::array::from_fn(|j| variance * inverse[i + 3][j + 3]));
    let placement = Placement { x0: blocks.origin.x + curve.x0, y0: blocks.origin.y + curve.y0, phase: curve.sin.atan2(curve.cos) };
    let trial = Trial::swift(curve.hem, placement, finish.feet, distances, sums.square, covariance, *evaluations);
    Some((trial, length))
}

#[cfg(test)]
mod tests;
