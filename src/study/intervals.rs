//! Confidence intervals of one fit, at a level: by its standard errors, its likelihood, or by bootstrap.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::experiment::DrapeProfile;
use crate::fit::bootstrap::Bootstrap;
use crate::fit::intervals::{End, Interval, Intervals, Kind, Replicates};
use crate::fit::uncertainty::Unknown;
use crate::fit::{HemFit, profile_likelihood};
use crate::statistics::distribution::{normal_critical, normal_upper, student_critical};

/// What to find.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    pub kind: Kind,
    /// Confidence level, 0…1.
    pub level: f64,
    /// Of bootstraps: how many; each end of an interval is then as uncertain as a quantile of so many draws.
    pub replicates: usize,
    /// Of bootstraps: replicate k depends on the seed and k alone.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            kind: Kind::Standard,
            level: 0.95,
            // 25 of them lie beyond each end at 95 %: the end is right to a fifth of its distance in levels. Chosen from `hemline study accuracy`: ends are
            // then 0.01 mm off at 0.5 mm of noise, a tenth of the interval's half width.
            replicates: 1000,
            seed: 1,
        }
    }
}

/// p, q, s, phase as matrices of unknowns have them.
const PARAMETERS: [Unknown; 4] = [Unknown::P, Unknown::Q, Unknown::S, Unknown::Phase];

/// Intervals of p, q, s and the phase of `fit`, which is a fit of `profile`. `None` for a quantity that has none, for the reason in
/// [`HemFit::standard_error_missing`]; the profile likelihood needs no standard error and gives q its upper end also where that is missing.
pub fn intervals(profile: &DrapeProfile, fit: &HemFit, options: &Options) -> Intervals {
    intervals_remembering(profile, fit, options, &mut Quantile::default())
}

/// Student's quantile that was needed last. It costs as much as a good part of a fit, and the profiles of a campaign hardly differ in their points.
#[derive(Debug, Clone, Copy, Default)]
pub struct Quantile {
    /// Level, degrees of freedom, quantile.
    known: Option<(f64, usize, f64)>,
}

impl Quantile {
    fn of(&mut self, level: f64, degrees_of_freedom: usize) -> f64 {
        match self.known {
            Some((of, degrees, quantile)) if of == level && degrees == degrees_of_freedom => quantile,
            _ => {
                let quantile = student_critical(1.0 - level, degrees_of_freedom as f64);
                self.known = Some((level, degrees_of_freedom, quantile));
                quantile
            }
        }
    }
}

/// As [`intervals`], for many fits one after the other.
pub fn intervals_remembering(profile: &DrapeProfile, fit: &HemFit, options: &Options, quantile: &mut Quantile) -> Intervals {
    let found = match options.kind {
        Kind::Standard => (standard(fit, quantile.of(options.level, fit.degrees_of_freedom)), None),
        Kind::Profile => (likely(profile, fit, options.level), None),
        Kind::Bootstrap | Kind::CaseBootstrap => bootstrap(profile, fit, options),
    };
    let ([p, q, s, phase], replicates) = found;
    Intervals { kind: options.kind, level: options.level, p, q, s, phase, replicates }
}

fn standard(fit: &HemFit, critical: f64) -> [Option<Interval>; 4] {
    let estimates = [
        Some((fit.hem.p, fit.p.standard_error)),
        fit.q.map(|e| (e.value, e.standard_error)),
        fit.s.map(|e| (e.value, e.standard_error)),
        fit.folds.map(|_| (fit.placement.phase, fit.placement_errors[2])),
    ];
    estimates.map(|estimate| {
        let (value, error) = estimate?;
        let half = critical * error?;
        Some(Interval { low: End::At(value - half), high: End::At(value + half) })
    })
}

fn likely(profile: &DrapeProfile, fit: &HemFit, level: f64) -> [Option<Interval>; 4] {
    let cutoff = student_critical(1.0 - level, fit.degrees_of_freedom as f64);
    PARAMETERS.map(|parameter| profile_likelihood::interval(profile, fit, parameter, cutoff).ok())
}

fn bootstrap(profile: &DrapeProfile, fit: &HemFit, options: &Options) -> ([Option<Interval>; 4], Option<Replicates>) {
    let Ok(ground) = Bootstrap::of(profile, fit) else { return ([None; 4], None) };
    let drawn: Vec<Option<[f64; 6]>> = (0..options.replicates)
        .into_par_iter()
        .map(|k| {
            let mut random = ChaCha8Rng::seed_from_u64(options.seed);
            random.set_stream(k as u64);
            let draw = |bound: usize| below(bound, &mut random);
            if options.kind == Kind::Bootstrap { ground.residual(draw) } else { ground.case(draw) }
        })
        .collect();
    let fitted: Vec<[f64; 6]> = drawn.into_iter().flatten().collect();
    let failed = options.replicates - fitted.len();
    let mut replicates =
        Replicates { asked: options.replicates, failed, seed: options.seed, standard_errors: [None; 4], percentile: [None; 4] };
    let mut found = [None; 4];
    for (slot, parameter) in PARAMETERS.into_iter().enumerate() {
        let j = parameter as usize;
        // Near a bound the bootstrap does not work (Andrews, Econometrica 68 (2000) 399–405), and these estimates sit on one.
        if fit.standard_error_missing.iter().any(|missing| missing.unknown == parameter) || fitted.len() < FEWEST {
            continue;
        }
        let mut values: Vec<f64> = fitted.iter().map(|unknowns| unknowns[j]).collect();
        values.sort_by(f64::total_cmp);
        let influence: Vec<f64> = ground.influence().iter().map(|unknowns| unknowns[j]).collect();
        let tail = 0.5 * (1.0 - options.level);
        replicates.standard_errors[slot] = Some(deviation(&values));
        replicates.percentile[slot] = Some(between(&values, tail, 1.0 - tail));
        let [low, high] = accelerated(&values, ground.estimate()[j], &influence, tail);
        found[slot] = Some(between(&values, low, high));
    }
    (found, Some(replicates))
}

/// Replicates below which there are no quantiles worth naming.
const FEWEST: usize = 20;

/// The levels between which the bias-corrected and accelerated interval lies; `influence` is the change of the estimate when a point is left out.
///
/// Source: Efron, J. Amer. Statist. Assoc. 82 (1987) 171–185.
fn accelerated(sorted: &[f64], estimate: f64, influence: &[f64], tail: f64) -> [f64; 2] {
    let n = sorted.len() as f64;
    let (below, upto) = (sorted.partition_point(|v| *v < estimate), sorted.partition_point(|v| *v <= estimate));
    // Half of the ties; never 0 or 1, where the normal law has no quantile.
    let share = (0.5 * (below + upto) as f64 / n).clamp(0.5 / n, 1.0 - 0.5 / n);
    let offset = -normal_critical(share);
    let mean = influence.iter().sum::<f64>() / influence.len() as f64;
    let (square, cube) = influence.iter().map(|v| mean - v).fold((0.0, 0.0), |(s, c), v| (s + v * v, c + v * v * v));
    let acceleration = if 0.0 < square { cube / (6.0 * square.powf(1.5)) } else { 0.0 };
    [-normal_critical(tail), normal_critical(tail)].map(|z| {
        let shifted = offset + z;
        1.0 - normal_upper(offset + shifted / (1.0 - acceleration * shifted))
    })
}

fn between(sorted: &[f64], low: f64, high: f64) -> Interval {
    Interval { low: End::At(quantile(sorted, low)), high: End::At(quantile(sorted, high)) }
}

/// The value that a share of the draws stays below: place `share·(n + 1)` in order, in between linear.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let n = sorted.len();
    let place = (share * (n + 1) as f64 - 1.0).clamp(0.0, (n - 1) as f64);
    let i = (place as usize).min(n - 2);
    sorted[i] + (place - i as f64) * (sorted[i + 1] - sorted[i])
}

fn deviation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
}

/// Uniform integer in 0..bound by rejection, so that it depends on the generator alone.
fn below(bound: usize, random: &mut ChaCha8Rng) -> usize {
    let bound = bound as u64;
    let limit = u64::MAX - u64::MAX % bound;
    loop {
        let draw = random.next_u64();
        if draw < limit {
            return (draw % bound) as usize;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_bias_and_skewness_the_accelerated_interval_is_the_percentile_one() {
        let sorted: Vec<f64> = (0..999).map(f64::from).collect();
        let [low, high] = accelerated(&sorted, 499.0, &[1.0, -1.0, 0.5, -0.5], 0.025);
        assert!((low - 0.025).abs() < 1e-12 && (high - 0.975).abs() < 1e-12, "{low} {high}");
        // Places 25 and 975 of 999, counted from 1.
        let interval = between(&sorted, low, high);
        assert!((interval.low.value().unwrap() - 24.0).abs() < 1e-6 && (interval.high.value().unwrap() - 974.0).abs() < 1e-6);
    }

    #[test]
    fn bias_and_acceleration_move_the_levels_as_published() {
        // z0 = Φ⁻¹(0.6) = 0.2533471, a = 0.05, z = ±1.9599640: levels Φ(z0 + (z0 + z)/(1 − a(z0 + z))), by 50-digit arithmetic 0.0668938… and 0.9961…;
        // computed here from the definition with the error function's own tail as the only thing shared.
        let sorted: Vec<f64> = (0..1000).map(f64::from).collect();
        let a: f64 = 0.05;
        // Two values u (k times) and v with mean 0 and Σ(−x)³/(6 (Σx²)^1.5) = a.
        let influence: Vec<f64> = influence_of(a);
        let [low, high] = accelerated(&sorted, 599.5, &influence, 0.025);
        let z0 = 0.253_347_103_135_8;
        let expected = [-1.959_963_984_540_054, 1.959_963_984_540_054].map(|z| {
            let shifted: f64 = z0 + z;
            1.0 - normal_upper(z0 + shifted / (1.0 - a * shifted))
        });
        assert!((low - expected[0]).abs() < 1e-9 && (high - expected[1]).abs() < 1e-9, "{low} {high} {expected:?}");
        assert!(0.025 < low && 0.975 < high);
    }

    /// n − 1 values of 1/(n − 1) and one of −1: mean zero; Σ(−x)³/(Σx²)^1.5 follows in closed form, n chosen and the size solved for `a` by
    /// mixing with a symmetric pair.
    fn influence_of(a: f64) -> Vec<f64> {
        let base = |pair: f64| vec![-1.0, 0.5, 0.5, pair, -pair];
        let skew = |values: &[f64]| {
            let (s, c) = values.iter().fold((0.0, 0.0), |(s, c), v| (s + v * v, c - v * v * v));
            c / (6.0 * f64::powf(s, 1.5))
        };
        let (mut low, mut high) = (0.0, 10.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if a < skew(&base(middle)) { low = middle } else { high = middle }
        }
        base(low)
    }
}
