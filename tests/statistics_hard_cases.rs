//! Designs and responses that break a naive analysis: what is said about each.

use hemline::statistics::box_wilson::{Analysis, ErrorSource, Options, analyse};
use hemline::statistics::factorial::FactorialDesign;
use hemline::statistics::residuals::{suspects, without_suspects};
use hemline::study::hard_cases::statistics::{axes, corners, noise};

/// 2^k corners in standard order, each `replicates` times in turn.
fn design(k: usize, replicates: usize) -> FactorialDesign {
    FactorialDesign::new(axes(k), corners(k, replicates)).unwrap()
}

fn run(design: &FactorialDesign, y: &[f64]) -> Analysis {
    let y: Vec<Option<f64>> = y.iter().copied().map(Some).collect();
    analyse(design, &y, &Options::default()).unwrap()
}

fn noted(analysis: &Analysis, part: &str) -> bool {
    analysis.notes.iter().any(|note| note.contains(part))
}

#[test]
fn zero_variance_in_one_cell_still_tests_against_the_others() {
    let design = design(2, 3);
    let y: Vec<f64> = (0..12).map(|i| if i % 4 == 0 { 5.0 } else { 5.0 + noise(i) }).collect();
    let found = run(&design, &y);
    assert_eq!(found.cells[0].variance, Some(0.0));
    assert!(found.coefficients.iter().all(|c| c.se.is_some_and(|se| se > 0.0)));
    assert_eq!(found.equal_variances.unwrap().test, "Cochran G");
}

#[test]
fn zero_variance_everywhere_gives_coefficients_but_no_errors_and_says_why() {
    let design = design(2, 3);
    let y: Vec<f64> = design.levels().iter().map(|x| 0.1 + 0.2 * x[0] - 0.3 * x[1]).collect();
    let found = run(&design, &y);
    assert!((found.coefficients[1].estimate - 0.2).abs() < 1e-15);
    assert!(found.coefficients.iter().all(|c| c.se.is_none() && c.t.is_none() && c.p.is_none() && !c.significant));
    assert!(found.equal_variances.is_none() && found.adequacy.is_none() && found.error.is_none());
    // Nothing was judged insignificant, so nothing is dropped.
    assert_eq!(found.reduced.coded.len(), 4);
    assert!(noted(&found, "no scatter to test against"), "{:?}", found.notes);
}

#[test]
fn all_responses_equal_gives_the_constant_and_no_r_squared() {
    let design = design(3, 2);
    let found = run(&design, &[7.3; 16]);
    assert!((found.coefficients[0].estimate - 7.3).abs() < 1e-15);
    assert!(found.coefficients[1..].iter().all(|c| c.estimate.abs() < 1e-30));
    assert_eq!((found.full.r_squared(), found.full.f(), found.error), (None, None, None));
}

#[test]
fn a_perfect_fit_of_the_full_model_has_no_f() {
    let found = run(&design(2, 1), &[1.0, 2.0, 3.0, 5.0]);
    assert_eq!((found.full.residual_df, found.full.f(), found.full.press()), (0, None, None));
    assert!(found.full.standardized_residuals().iter().all(Option::is_none));
}

#[test]
fn one_replicate_falls_back_on_lenth() {
    // Fifteen effects, two of them large.
    let design = design(4, 1);
    let y: Vec<f64> = design.levels().iter().enumerate().map(|(i, x)| 20.0 + 5.0 * x[0] - 3.0 * x[1] * x[2] + noise(i)).collect();
    let found = run(&design, &y);
    let significant: Vec<&str> = found.coefficients.iter().filter(|c| c.significant).map(|c| c.term.as_str()).collect();
    assert_eq!(significant, ["1", "a", "b:c"]);
    let lenth = found.lenth.unwrap();
    // Lenth (1989): margin = t₀.₉₇₅(m/3) · PSE, t₀.₉₇₅(5) = 2.570582 in any table.
    assert!((lenth.margin / lenth.pseudo_standard_error - 2.570_582).abs() < 1e-6);
    assert!(found.coefficients.iter().all(|c| c.se.is_none()) && noted(&found, "Lenth"));
}

#[test]
fn a_whole_cell_missing_costs_the_highest_interaction_and_names_it() {
    let design = design(3, 4);
    let y: Vec<Option<f64>> = design
        .levels()
        .iter()
        .enumerate()
        .map(|(i, x)| (*x != [1.0, 1.0, 1.0]).then(|| 10.0 + 2.0 * x[0] + x[1] + 0.1 * noise(i)))
        .collect();
    let found = analyse(&design, &y, &Options::default()).unwrap();
    assert_eq!(found.coefficients.len(), 7);
    assert_eq!(found.aliases[0].term, "a:b:c");
    // Where the corner +++ is absent, (1+a)(1+b)(1+c) = 0, so abc = −1 − a − b − c − ab − ac − bc.
    assert!(found.aliases[0].equals.len() == 7 && found.aliases[0].equals.iter().all(|(_, factor)| (factor + 1.0).abs() < 1e-14));
    assert!(noted(&found, "1 of the 8 corners") && noted(&found, "Term a:b:c has no coefficient of its own"), "{:?}", found.notes);
    // 28 runs, 7 cells: the scatter within them is all there is.
    assert_eq!((found.residual_df, found.error.unwrap().source), (21, ErrorSource::PureError));
}

#[test]
fn aliased_columns_of_a_fraction_are_named_not_dropped() {
    // Half fraction with c = ab: every term has one alias.
    let levels: Vec<Vec<f64>> = corners(2, 3).into_iter().map(|x| vec![x[0], x[1], x[0] * x[1]]).collect();
    let fraction = FactorialDesign::new(axes(3), levels).unwrap();
    let y: Vec<f64> = (0..12).map(|i| 4.0 + noise(i)).collect();
    let found = run(&fraction, &y);
    let pairs: Vec<(String, Vec<(String, f64)>)> = found.aliases.iter().map(|alias| (alias.term.clone(), alias.equals.clone())).collect();
    let exact = [("a:b", "c"), ("a:c", "b"), ("b:c", "a"), ("a:b:c", "1")];
    assert_eq!(pairs.len(), 4);
    for ((term, equals), (alias, other)) in pairs.iter().zip(exact) {
        assert_eq!((term.as_str(), equals.len(), equals[0].0.as_str()), (alias, 1, other));
        assert!((equals[0].1 - 1.0).abs() < 1e-14);
    }
}

#[test]
fn an_offset_of_1e8_on_an_effect_of_1e_minus_3_changes_nothing_but_the_constant() {
    let design = design(3, 5);
    // Multiples of 2⁻²⁵ ≈ 3e-8: exact with and without the offset, so any difference would be the arithmetic's.
    let grid = 2f64.powi(-25);
    let small: Vec<f64> =
        design.levels().iter().enumerate().map(|(i, x)| ((1e-3 * x[0] + 1e-4 * noise(i)) / grid).round() * grid).collect();
    let large: Vec<f64> = small.iter().map(|y| y + 1e8).collect();
    let (small, large) = (run(&design, &small), run(&design, &large));
    for (s, l) in small.coefficients.iter().zip(&large.coefficients).skip(1) {
        // The last digits of a quotient of sums that agree to 30.
        assert!((s.estimate - l.estimate).abs() <= 1e-15 * s.estimate.abs(), "{}: {} vs {}", s.term, s.estimate, l.estimate);
        assert!((s.se.unwrap() / l.se.unwrap() - 1.0).abs() < 1e-14);
    }
    assert!((small.equal_variances.unwrap().statistic - large.equal_variances.unwrap().statistic).abs() < 1e-14);
}

#[test]
fn a_run_100_sigma_off_is_flagged_and_the_analysis_without_it_is_the_undisturbed_one() {
    let design = design(3, 5);
    let mut y: Vec<f64> = design.levels().iter().enumerate().map(|(i, x)| 10.0 + x[0] - 0.5 * x[1] + 0.2 * noise(i)).collect();
    let mut clean: Vec<Option<f64>> = y.iter().copied().map(Some).collect();
    clean[17] = None;
    let clean = analyse(&design, &clean, &Options::default()).unwrap();
    y[17] += 100.0 * clean.error.unwrap().variance.sqrt();
    let disturbed = run(&design, &y);
    let found = suspects(&disturbed, 0.05);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].run, 17);
    // Its own cell of five sees 4/5 of the shift; Cook's distance of such a run is far above the rule-of-thumb 1 of the literature.
    assert!(found[0].deleted_residual > 50.0 && found[0].cook_distance.unwrap() > 0.9, "{found:?}");
    assert!(!disturbed.equal_variances.as_ref().unwrap().holds);
    let y: Vec<Option<f64>> = y.into_iter().map(Some).collect();
    let without = without_suspects(&design, &y, &disturbed, &Options::default()).unwrap().unwrap();
    assert_eq!(without, clean);
}

#[test]
fn a_run_that_drowns_all_others_is_still_named() {
    // Beyond 10⁶ standard deviations the others are lost in the sum of squares of doubles; at 10¹⁵ even the response itself has no digit of them.
    let design = design(3, 5);
    let clean: Vec<f64> = design.levels().iter().enumerate().map(|(i, x)| 10.0 + x[0] - 0.5 * x[1] + 0.2 * noise(i)).collect();
    for far in [1e6, 1e8, 1e12, 1e15, 1e20] {
        let mut y = clean.clone();
        y[17] += 0.06 * far;
        let found = suspects(&run(&design, &y), 0.05);
        assert!(found.len() == 1 && found[0].run == 17, "{far:e}: {found:?}");
        // Its cell of five sees 4/5 of it: e/√(1 − h) = 0.89 of the shift, at least what twice the working precision can tell.
        assert!(0.5 * far.min(1e14) < found[0].deleted_residual, "{far:e}: {found:?}");
    }
}

#[test]
fn levels_that_tell_two_factors_apart_in_their_last_digits_only_are_said_to() {
    // b is a but for a part in 2³⁰: the coefficient keeps 15.4 − 9 digits of the levels given.
    let levels = |part: f64| -> Vec<Vec<f64>> { (0..12).map(|i| vec![noise(i), noise(i) + part * noise(i + 50)]).collect() };
    let y: Vec<f64> = (0..12).map(|i| 10.0 + noise(i + 7)).collect();
    let notes = |part: f64| run(&FactorialDesign::new(axes(2), levels(part)).unwrap(), &y).notes;
    let near = notes(2f64.powi(-30));
    assert!(near.iter().any(|note| note.starts_with("Term a is nearly a combination") && note.contains("about 6 digits")), "{near:?}");
    assert!(notes(0.1).iter().all(|note| !note.contains("nearly a combination")));
}

#[test]
fn six_factors_with_two_replicates_are_analysed() {
    let design = design(6, 2);
    let y: Vec<f64> = design
        .levels()
        .iter()
        .enumerate()
        .map(|(i, x)| 1.0 + x[5] + 0.5 * x[0] * x[1] * x[2] * x[3] * x[4] * x[5] + 0.1 * noise(i))
        .collect();
    let found = run(&design, &y);
    assert_eq!((found.coefficients.len(), found.residual_df), (64, 64));
    assert_eq!(found.coefficients[63].term, "a:b:c:d:e:f");
    assert!(found.coefficients[63].significant && found.coefficients[6].significant);
}

#[test]
fn in_the_balanced_case_every_coefficient_has_the_same_error() {
    let design = design(3, 5);
    let y: Vec<f64> = (0..40).map(|i| 3.0 + noise(i)).collect();
    let found = run(&design, &y);
    let exact = (found.error.unwrap().variance / 40.0).sqrt();
    assert!(found.coefficients.iter().all(|c| (c.se.unwrap() / exact - 1.0).abs() < 1e-14));
    // t₀.₉₇₅(32) = 2.0369 in any table.
    assert!((found.t_critical.unwrap() - 2.0369).abs() < 5e-5);
}

#[test]
fn centre_points_measure_curvature_and_leave_the_effects_alone() {
    let mut levels = corners(2, 2);
    levels.extend(vec![vec![0.0, 0.0]; 4]);
    let with_centre = FactorialDesign::new(axes(2), levels).unwrap();
    // A pure quadratic raises the corners by 3 over the centre.
    let y: Vec<f64> = with_centre.levels().iter().enumerate().map(|(i, x)| 5.0 + x[0] + 3.0 * x[0] * x[0] + 0.1 * noise(i)).collect();
    let found = run(&with_centre, &y);
    let corners_only = run(&design(2, 2), &y[..8]);
    let curvature = found.curvature.unwrap();
    let centre_mean = y[8..].iter().sum::<f64>() / 4.0;
    assert!((curvature.estimate - (centre_mean - corners_only.coefficients[0].estimate)).abs() < 1e-14);
    assert!(curvature.significant && (curvature.estimate + 3.0).abs() < 0.1);
    for (with, without) in found.coefficients.iter().zip(&corners_only.coefficients) {
        assert!((with.estimate - without.estimate).abs() < 1e-14);
    }
    // 12 runs, 5 treatments.
    assert_eq!(found.residual_df, 7);
}

#[test]
fn blocks_take_their_own_degrees_of_freedom_and_no_effect() {
    let design = design(2, 3);
    let blocks: Vec<String> = (0..12).map(|i| ["Monday", "Tuesday", "Friday"][i / 4].to_string()).collect();
    let y: Vec<f64> = design.levels().iter().enumerate().map(|(i, x)| 10.0 + x[0] + [4.0, -1.0, -3.0][i / 4] + 0.1 * noise(i)).collect();
    let plain = run(&design, &y);
    let blocked = run(&design.clone().with_blocks(blocks).unwrap(), &y);
    for (b, p) in blocked.coefficients.iter().zip(&plain.coefficients) {
        assert!((b.estimate - p.estimate).abs() < 1e-14, "complete blocks are orthogonal to the effects");
    }
    assert_eq!((plain.residual_df, blocked.residual_df, blocked.blocks.len()), (8, 6, 2));
    assert!((blocked.blocks[0].estimate - 4.0).abs() < 0.1 && blocked.error.unwrap().variance < 0.05 * plain.error.unwrap().variance);
    let split = blocked.reduced.lack_of_fit.unwrap().f().unwrap();
    assert!((split / blocked.adequacy.as_ref().unwrap().statistic - 1.0).abs() < 1e-10);
}

#[test]
fn missing_and_impossible_responses_are_told_apart() {
    let design = design(1, 2);
    assert!(analyse(&design, &[None; 4], &Options::default()).is_err());
    assert!(analyse(&design, &[Some(f64::NAN), Some(1.0), Some(2.0), Some(3.0)], &Options::default()).is_err());
    assert!(analyse(&design, &[Some(1.0); 3], &Options::default()).is_err());
    assert!(analyse(&design, &[Some(1.0), None, Some(2.0), Some(3.0)], &Options { alpha: 1.5 }).is_err());
}
