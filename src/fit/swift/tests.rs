//! The swift path against the careful one.

use std::f64::consts::TAU;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::experiment::DrapeProfile;
use crate::fit::orthogonal;
use crate::fit::outline::smooth;
use crate::fit::rules::{Evidence, broken};
use crate::model::hem::Hem;
use crate::numerics::least_squares;

const PLAIN: Options = Options { gradient_tolerance: 1e-10, bias_correction: false };

fn normal(generator: &mut impl Rng) -> f64 {
    let (u, v): (f64, f64) = (generator.random(), generator.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}

/// A noisy hem somewhere, m: the points in order, irregularly spaced.
fn outline(generator: &mut impl Rng, hem: &Hem, noise: f64, count: usize) -> Vec<Point> {
    let placement = Placement {
        x0: generator.random_range(-0.05..0.05),
        y0: generator.random_range(-0.05..0.05),
        phase: generator.random_range(0.0..TAU / f64::from(hem.folds)),
    };
    (0..count)
        .map(|i| {
            let t = TAU * (i as f64 + generator.random::<f64>()) / count as f64;
            let point = hem.point(&placement, t);
            Point::new(point.x + noise * normal(generator), point.y + noise * normal(generator))
        })
        .collect()
}

#[test]
fn what_is_certified_is_the_careful_optimum_and_obeys_every_rule() {
    let mut generator = ChaCha8Rng::seed_from_u64(8);
    let (mut certified, mut tried) = (0, 0);
    for case in 0..300 {
        let folds = generator.random_range(2..=24);
        let q = generator.random_range(0.01..0.05);
        let hem = Hem { p: 0.2, q, s: generator.random_range(-0.01..0.016), folds };
        let noise = q * [0.0, 1e-3, 0.03, 0.1][case % 4];
        let count = [120, 360, 720][case % 3].max(12 * folds as usize);
        let profile = DrapeProfile::new(&outline(&mut generator, &hem, noise, count)).expect("an outline");
        tried += 1;
        let Some(Swift { finished, outline_length, .. }) = fit(profile.points(), folds..=folds, &PLAIN) else { continue };
        certified += 1;
        let found = &finished[0].trial;
        // Once more from there by the general engine: nothing may move but by rounding.
        let careful = orthogonal::fit(
            profile.points(),
            found.hem,
            found.placement,
            found.feet.clone(),
            None,
            f64::INFINITY,
            &least_squares::Options::default(),
        )
        .expect("more points than unknowns");
        let moved = [careful.hem.p - found.hem.p, careful.hem.q - found.hem.q, careful.hem.s - found.hem.s];
        // 1e-10 of the standard errors, which are below the noise, and rounding of coordinates of 0.2 m.
        assert!(moved.iter().all(|d| d.abs() < 1e-9 * noise + 1e-14), "case {case}: {moved:?}");
        let gain = found.sum_of_squares - careful.summary.sum_of_squares;
        assert!(gain <= 1e-12 * found.sum_of_squares + 1e-28, "case {case}: {gain:e}");
        let smoothed = smooth(&profile);
        let farthest = found.distances.iter().fold(0.0_f64, |a, d| a.max(d.abs()));
        let evidence = Evidence {
            outline: &smoothed,
            points: profile.points(),
            feet: &found.feet,
            distances: &found.distances,
            farthest,
            rms: found.rms(),
            length: outline_length,
        };
        assert_eq!(broken(&found.hem, &found.placement, &evidence), None, "case {case}: {hem:?}");
    }
    // Curves that cross themselves or touch are left to the careful path.
    assert!(tried < 2 * certified, "{certified} of {tried}");
}

#[test]
fn an_outline_with_a_misfit_is_left_to_the_careful_path() {
    let mut generator = ChaCha8Rng::seed_from_u64(3);
    let hem = Hem { p: 0.2, q: 0.03, s: 0.005, folds: 7 };
    let points: Vec<Point> = outline(&mut generator, &hem, 1e-4, 360)
        .into_iter()
        .enumerate()
        // One fold is deeper than the others.
        .map(|(i, p)| if i < 51 { Point::new(1.05 * p.x, 1.05 * p.y) } else { p })
        .collect();
    assert!(fit(&points, 2..=24, &PLAIN).is_none());
}

#[test]
fn another_fold_count_is_found_with_the_right_one_beside_it() {
    let mut generator = ChaCha8Rng::seed_from_u64(5);
    for folds in [2, 3, 5, 8, 13, 24] {
        let hem = Hem { p: 0.2, q: 0.02, s: 0.004, folds };
        let profile = DrapeProfile::new(&outline(&mut generator, &hem, 1e-3, 480)).expect("an outline");
        let Swift { trials, .. } = fit(profile.points(), 2..=24, &PLAIN).expect("a plain hem");
        let best = trials.iter().filter(|t| t.sane()).min_by(|a, b| a.sum_of_squares.total_cmp(&b.sum_of_squares)).expect("one is sane");
        assert_eq!(best.folds, folds);
    }
}

#[test]
fn the_correction_is_that_of_the_careful_path() {
    let mut generator = ChaCha8Rng::seed_from_u64(11);
    let hem = Hem { p: 0.2, q: 0.03, s: 0.015, folds: 8 };
    for noise in [5e-4, 1e-3, 2e-3] {
        let points = outline(&mut generator, &hem, noise, 360);
        let asked = Options { bias_correction: true, ..PLAIN };
        let swift = fit(&points, 8..=8, &asked).expect("a plain hem").finished.remove(0);
        let plain = fit(&points, 8..=8, &PLAIN).expect("a plain hem").finished.remove(0).trial;
        let profile = DrapeProfile::new(&points).expect("an outline");
        let smoothed = smooth(&profile);
        let options = crate::fit::Options::default();
        let work = super::super::trial::Work::new(&points, smoothed.places.clone(), &smoothed, &options);
        let (careful, correction) = crate::fit::bias::correct(plain, &work, true);
        for (found, expected) in
            [(swift.trial.hem.p, careful.hem.p), (swift.trial.hem.q, careful.hem.q), (swift.trial.hem.s, careful.hem.s)]
        {
            // Both stop at a share of 1e-11 or 1e-10 of the noise.
            assert!((found - expected).abs() < 1e-11, "{found} {expected}");
        }
        let (found, expected) = (swift.correction.applied().expect("applied"), correction.applied().expect("applied"));
        for (a, b) in [(found.p, expected.p), (found.q, expected.q), (found.s, expected.s), (found.sigma, expected.sigma)] {
            assert!((a - b).abs() < 1e-11, "{a} {b}");
        }
        assert!((found.bend - expected.bend).abs() < 1e-6, "{} {}", found.bend, expected.bend);
    }
}
