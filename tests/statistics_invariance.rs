//! What must not change the analysis, or change it in a known way; and whether tests have the level they claim.

use hemline::statistics::box_wilson::{Analysis, Options, analyse};
use hemline::statistics::factorial::{Axis, FactorialDesign};
use hemline::statistics::permutation::{self, permutation_tests};
use hemline::statistics::residuals::{durbin_watson, durbin_watson_p};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Uniform on (0, 1).
fn uniform(random: &mut ChaCha8Rng) -> f64 {
    ((random.next_u64() >> 11) as f64 + 0.5) / 2f64.powi(53)
}

/// Standard normal by Box and Muller's formula.
fn normal(random: &mut ChaCha8Rng) -> f64 {
    (-2.0 * uniform(random).ln()).sqrt() * (2.0 * std::f64::consts::PI * uniform(random)).cos()
}

fn levels(k: usize, replicates: usize) -> Vec<Vec<f64>> {
    (0..replicates << k).map(|run| (0..k).map(|i| if run >> i & 1 == 1 { 1.0 } else { -1.0 }).collect()).collect()
}

fn design(levels: Vec<Vec<f64>>) -> FactorialDesign {
    let factors = (0..levels[0].len()).map(|i| Axis::coded(["a", "b", "c", "d", "e", "f"][i])).collect();
    FactorialDesign::new(factors, levels).unwrap()
}

fn run(levels: Vec<Vec<f64>>, y: &[f64]) -> Analysis {
    analyse(&design(levels), &y.iter().copied().map(Some).collect::<Vec<_>>(), &Options::default()).unwrap()
}

/// An unbalanced 2³ of 33 runs with a random response.
fn example(seed: u64) -> (Vec<Vec<f64>>, Vec<f64>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut runs = levels(3, 5);
    runs.truncate(33);
    let y = runs.iter().map(|x| 7.0 + x[0] - 0.5 * x[1] * x[2] + 0.3 * normal(&mut random)).collect();
    (runs, y)
}

/// A relative difference that only the last rounding of a result explains.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-13 * a.abs().max(b.abs()).max(1e-3)
}

#[test]
fn the_order_of_the_runs_does_not_matter() {
    let (runs, y) = example(1);
    let forward = run(runs.clone(), &y);
    let backward = run(runs.into_iter().rev().collect(), &y.into_iter().rev().collect::<Vec<_>>());
    for (f, b) in forward.coefficients.iter().zip(&backward.coefficients) {
        assert!(same(f.estimate, b.estimate) && same(f.se.unwrap(), b.se.unwrap()) && same(f.p.unwrap(), b.p.unwrap()), "{}", f.term);
    }
    assert!(same(forward.adequacy.unwrap().statistic, backward.adequacy.unwrap().statistic));
    assert!(same(forward.equal_variances.unwrap().statistic, backward.equal_variances.unwrap().statistic));
}

#[test]
fn shifting_and_scaling_the_response_shifts_and_scales_the_coefficients_and_leaves_the_tests() {
    let (runs, y) = example(2);
    let before = run(runs.clone(), &y);
    // A unit of another size and another zero.
    let after = run(runs, &y.iter().map(|y| 273.0 + 64.0 * y).collect::<Vec<_>>());
    for (b, a) in before.coefficients.iter().zip(&after.coefficients).skip(1) {
        // y itself was rounded by the shift: 4 ulp of 700 against effects of 0.1 · 64.
        assert!((64.0 * b.estimate - a.estimate).abs() < 1e-12, "{}", b.term);
        assert!((b.t.unwrap() - a.t.unwrap()).abs() < 1e-11 * (1.0 + b.t.unwrap().abs()), "{}", b.term);
    }
}

#[test]
fn turning_a_factor_round_turns_the_signs_of_its_terms() {
    let (runs, y) = example(3);
    let before = run(runs.clone(), &y);
    let after = run(runs.into_iter().map(|x| vec![x[0], -x[1], x[2]]).collect(), &y);
    for (b, a) in before.coefficients.iter().zip(&after.coefficients) {
        let sign = if b.term.contains('b') { -1.0 } else { 1.0 };
        assert!(same(sign * b.estimate, a.estimate) && same(b.se.unwrap(), a.se.unwrap()), "{}", b.term);
    }
}

/// Share of `trials` in which an event of probability `level` happened, in standard errors from the level.
fn deviation(hits: u32, trials: u32, level: f64) -> f64 {
    (f64::from(hits) / f64::from(trials) - level) / (level * (1.0 - level) / f64::from(trials)).sqrt()
}

#[test]
fn t_cochran_and_fisher_reject_a_true_hypothesis_as_often_as_they_say() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let design = design(levels(3, 5));
    let trials = 4000;
    let (mut t, mut g, mut f) = (0, 0, 0);
    for _ in 0..trials {
        // Only the constant is there; it is large enough to be kept always.
        let y: Vec<Option<f64>> = (0..40).map(|_| Some(100.0 + normal(&mut random))).collect();
        let found = analyse(&design, &y, &Options::default()).unwrap();
        t += u32::from(found.coefficients[5].significant);
        g += u32::from(!found.equal_variances.unwrap().holds);
        // Adequacy of the model of the constant alone, whatever was significant by chance: compare the F of the model with 7, 32.
        f += u32::from(found.full.f().unwrap() > hemline::statistics::distribution::fisher_critical(0.05, 7.0, 32.0));
    }
    // Four standard errors: one honest run in 16 000 fails.
    for (name, hits) in [("t", t), ("Cochran", g), ("Fisher", f)] {
        let deviation = deviation(hits, trials, 0.05);
        assert!(deviation.abs() < 4.0, "{name}: {hits} of {trials} rejections at 0.05, {deviation:.1} standard errors off");
    }
}

#[test]
fn intervals_cover_the_truth_as_often_as_they_say() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut runs = levels(3, 5);
    runs.truncate(33);
    let design = design(runs);
    let trials = 4000;
    let mut missed = 0;
    for _ in 0..trials {
        let y: Vec<Option<f64>> = design.levels().iter().map(|x| Some(3.0 - 1.5 * x[0] * x[1] + normal(&mut random))).collect();
        let found = analyse(&design, &y, &Options::default()).unwrap();
        let c = found.coefficients.iter().find(|c| c.term == "a:b").unwrap();
        missed += u32::from(!(c.ci_low.unwrap()..=c.ci_high.unwrap()).contains(&-1.5));
    }
    assert!(deviation(missed, trials, 0.05).abs() < 4.0, "{missed} of {trials} intervals miss");
}

#[test]
fn durbin_watson_rejects_independent_errors_as_often_as_it_says() {
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let design = design(levels(3, 5));
    let decomposition = design.regressors().unwrap().decompose();
    let basis = decomposition.basis();
    let trials = 20_000;
    let mut hits = [0, 0];
    for _ in 0..trials {
        let mut e: Vec<f64> = (0..40).map(|_| normal(&mut random)).collect();
        for q in &basis {
            let share: f64 = q.iter().zip(&e).map(|(q, e)| q * e).sum();
            e.iter_mut().zip(q).for_each(|(e, q)| *e -= share * q);
        }
        let p = durbin_watson_p(durbin_watson(&e).unwrap(), &basis).unwrap();
        hits[0] += u32::from(p < 0.05);
        hits[1] += u32::from(p < 0.01);
    }
    assert!(deviation(hits[0], trials, 0.05).abs() < 4.0 && deviation(hits[1], trials, 0.01).abs() < 4.0, "{hits:?} of {trials}");
}

#[test]
fn permutation_p_of_a_fold_count_has_its_level_though_other_terms_are_there() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let design = design(levels(2, 4));
    let options = permutation::Options { draws: 199, ..Default::default() };
    let trials = 2000_u32;
    let mut hits = 0;
    for trial in 0..trials {
        // Small integers with a strong effect of a and none of b.
        let y: Vec<Option<f64>> = design.levels().iter().map(|x| Some((6.5 + 1.5 * x[0] + 0.8 * normal(&mut random)).round())).collect();
        let tests = permutation_tests(&design, &y, &permutation::Options { seed: u64::from(trial), most_exact: 0, ..options }).unwrap();
        hits += u32::from(tests[1].p <= 0.05);
    }
    // Integers make ties, which only lower the share; Freedman and Lane's test is exact in the limit, so a little more is allowed for.
    let share = f64::from(hits) / f64::from(trials);
    assert!((0.03..0.07).contains(&share), "{share}");
}

#[test]
fn permutation_p_values_do_not_depend_on_anything_but_the_seed() {
    let (runs, y) = example(8);
    let design = design(runs);
    let y: Vec<Option<f64>> = y.into_iter().map(Some).collect();
    let with_seed = |seed| permutation_tests(&design, &y, &permutation::Options { draws: 499, seed, ..Default::default() }).unwrap();
    assert_eq!(with_seed(1), with_seed(1));
    assert_ne!(with_seed(1), with_seed(2));
}
