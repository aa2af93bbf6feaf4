//! Hard outlines: what a fit must say of each.

use std::f64::consts::TAU;

use hemline::experiment::campaign::Folds;
use hemline::experiment::{DrapeProfile, Point};
use hemline::fit::{self, HemFit, Options, Termination};
use hemline::model::hem::Hem;
use hemline::study::drawn::{AT, HEM, noisy, normal};
use hemline::study::hard_cases::fit::near_cusp;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn fitted(points: &[Point], folds: Folds) -> Result<HemFit, String> {
    let profile = DrapeProfile::new(points).map_err(|e| e.to_string())?;
    fit::fit(&profile, &Options { folds, ..Options::default() }).map_err(|e| e.to_string())
}

fn free(points: &[Point]) -> HemFit {
    fitted(points, Folds::default()).expect("a fit")
}

/// p, q, s within `times` standard errors of the truth, and the fold count right.
fn agrees(fit: &HemFit, truth: &Hem, times: f64, case: &str) {
    assert_eq!(fit.folds, Some(truth.folds), "{case}: {:?}", fit.notes);
    for (name, estimate, value) in [("p", Some(fit.p), truth.p), ("q", fit.q, truth.q), ("s", fit.s, truth.s)] {
        let estimate = estimate.expect("folds have all three");
        let error = estimate.standard_error.unwrap_or_else(|| panic!("{case}: {name} has no standard error: {:?}", fit.notes));
        assert!((estimate.value - value).abs() <= times * error + 1e-12, "{case}: {name} {} ± {error} for {value}", estimate.value);
    }
}

fn same(a: &HemFit, b: &HemFit, tolerance: f64, case: &str) {
    assert_eq!((a.folds, &a.termination), (b.folds, &b.termination), "{case}");
    for (x, y) in [(a.hem.p, b.hem.p), (a.hem.q, b.hem.q), (a.hem.s, b.hem.s), (a.rms, b.rms), (a.perimeter, b.perimeter)] {
        assert!((x - y).abs() <= tolerance * a.hem.p, "{case}: {x} {y}");
    }
}

#[test]
fn an_exact_circle_has_no_folds_and_its_radius_to_rounding() {
    let circle = Hem { p: 0.2, q: 0.0, s: 0.0, folds: 1 };
    let fit = free(&circle.outline(&AT, 360));
    assert_eq!((fit.folds, fit.q, fit.s, &fit.termination), (None, None, None, &Termination::NoFolds));
    assert!((fit.hem.p - 0.2).abs() < 1e-14 && fit.rms < 1e-15, "{} {}", fit.hem.p, fit.rms);
}

#[test]
fn folds_far_below_the_noise_are_not_reported() {
    // A hundredth of the noise: no fold count has evidence.
    let hem = Hem { q: 2e-5, s: 0.0, ..HEM };
    let mut round = 0;
    for seed in 0..20 {
        let fit = free(&noisy(&hem, 360, 2e-3, seed));
        // The best of 23 chance waves is drawn now and then, but never as a certainty.
        assert!(fit.folds.is_none() || fit.folds_weight < 0.99, "{seed}: {:?} {}", fit.folds, fit.folds_weight);
        round += u32::from(fit.folds.is_none() || fit.ties.contains(&0));
    }
    assert!(round >= 15, "{round} of 20 round");
}

#[test]
fn overhanging_folds_are_fitted_freely_and_right() {
    let hem = Hem { p: 0.2, q: 0.05, s: 0.02, folds: 8 };
    assert!(hem.overhangs());
    let fit = free(&noisy(&hem, 720, 2e-4, 3));
    assert_eq!(fit.termination, Termination::Converged);
    agrees(&fit, &hem, 4.5, "overhang");
}

#[test]
fn a_near_cusp_is_fitted_with_an_error_or_held_and_said() {
    // Speed at the valley: p − q + 2ms cos 2π = p − q − … nearly zero where 2ms = −(p − q) within 2 %.
    let outline = near_cusp(0.02, 5);
    let Hem { p, q, s, .. } = outline.hem;
    let hem = outline.hem;
    let slowest = (0..10_000).map(|i| hem.local(TAU * f64::from(i) / 10_000.0).speed()).fold(f64::MAX, f64::min);
    assert!(slowest < 0.03 * p, "{slowest}");
    let fit = free(&outline.points);
    assert_eq!(fit.folds, Some(6));
    assert!((fit.hem.q - q).abs() < 0.01 * q && (fit.hem.s - s).abs() < 0.02 * s.abs(), "{:?} {:?}", fit.hem, fit.termination);
}

#[test]
fn a_self_crossing_outline_may_have_a_self_crossing_curve() {
    let hem = Hem { p: 0.2, q: 0.08, s: 0.06, folds: 5 };
    let fit = free(&noisy(&hem, 720, 1e-4, 7));
    assert_eq!(fit.folds, Some(5), "{:?}", fit.termination);
    assert!((fit.hem.q - hem.q).abs() < 1e-3 && (fit.hem.s - hem.s).abs() < 1e-3, "{:?} {:?}", fit.hem, fit.termination);
}

#[test]
fn a_third_of_the_outline_missing_is_said_and_the_rest_still_tells_the_folds() {
    let points = noisy(&HEM, 540, 3e-4, 9);
    let fit = free(&points[..360]);
    assert_eq!(fit.folds, Some(8), "{:?} {:?}", fit.termination, fit.hem);
    assert!(fit.notes.iter().any(|n| n.contains("fewer than 4 points a fold")), "{:?}", fit.notes);
    assert!((fit.hem.p - 0.2).abs() < 2e-3 && (fit.hem.q - 0.03).abs() < 2e-3, "{:?} {:?}", fit.hem, fit.termination);
}

#[test]
fn seven_points_are_an_error_that_says_how_many_are_needed() {
    let error = fitted(&HEM.outline(&AT, 7), Folds::default()).expect_err("too few");
    assert!(error.contains("7 distinct points") && error.contains("12"), "{error}");
}

#[test]
fn fewer_than_four_points_a_fold_are_an_error_that_says_which_folds_could_not_be_seen() {
    let hem = Hem { folds: 10, ..HEM };
    let error = fitted(&noisy(&hem, 39, 1e-4, 1), Folds::Exactly(10)).expect_err("39 points, ten folds");
    assert!(error.contains("at most 9 folds") && error.contains("need 40"), "{error}");
    // By evidence: the answer names what it could not look for.
    let fit = free(&noisy(&Hem { folds: 4, ..HEM }, 39, 1e-4, 1));
    assert_eq!(fit.folds, Some(4));
    assert!(fit.notes.iter().any(|n| n.contains("cannot show more than 9 folds")), "{:?}", fit.notes);
}

#[test]
fn sparse_stretches_limit_what_can_be_seen_and_are_said() {
    // Three hundred points on a tenth of the hem, forty on the rest: n/4 = 85, but eight folds have four each there.
    let t = (0..300).map(|i| 0.1 * TAU * f64::from(i) / 300.0).chain((0..40).map(|i| TAU * (0.1 + 0.9 * f64::from(i) / 40.0)));
    let points: Vec<Point> = t.map(|t| HEM.point(&AT, t)).collect();
    let error = fitted(&points, Folds::Exactly(24)).expect_err("24 folds cannot be seen");
    assert!(error.contains("show at most"), "{error}");
    let fit = fitted(&points, Folds::default()).expect("eight folds can");
    assert_eq!(fit.folds, Some(8), "{:?}", fit.notes);
    assert!(fit.notes.iter().any(|n| n.contains("cannot show more than")), "{:?}", fit.notes);
}

#[test]
fn direction_closing_point_and_duplicates_change_nothing() {
    let points = noisy(&HEM, 360, 5e-4, 11);
    let plain = free(&points);
    let mut clockwise = points.clone();
    clockwise.reverse();
    // Another order of summation: rounding only.
    same(&plain, &free(&clockwise), 1e-9, "clockwise");
    let mut closed = points.clone();
    closed.push(points[0]);
    same(&plain, &free(&closed), 0.0, "closing point");
    let doubled: Vec<Point> = points.iter().flat_map(|p| [*p, *p]).collect();
    same(&plain, &free(&doubled), 0.0, "duplicates");
}

#[test]
fn scattered_points_are_put_in_order_and_said() {
    let mut points = noisy(&HEM, 360, 2e-4, 13);
    let plain = free(&points);
    points.shuffle(&mut ChaCha8Rng::seed_from_u64(1));
    let profile = DrapeProfile::new(&points).expect("an outline");
    assert!(profile.was_scattered());
    same(&plain, &fit::fit(&profile, &Options::default()).expect("a fit"), 1e-8, "scattered");
}

#[test]
fn a_centre_a_million_radii_away_costs_the_digits_that_the_coordinates_lost_and_says_so() {
    let points = noisy(&HEM, 360, 5e-4, 15);
    let near = free(&points);
    let (dx, dy) = (2e5, -1.6e5);
    let far = free(&points.iter().map(|p| Point::new(p.x + dx, p.y + dy)).collect::<Vec<_>>());
    // Coordinates are rounded to 1.5e-11 m; parameters are means of hundreds of them, s enters through slopes of order one.
    same(&near, &far, 1e-9, "far");
    assert!((far.placement.x0 - dx - near.placement.x0).abs() < 1e-10 && (far.placement.y0 - dy - near.placement.y0).abs() < 1e-10);
    assert!(far.notes.iter().any(|n| n.contains("rounded to")), "{:?}", far.notes);
    assert!(near.notes.is_empty(), "{:?}", near.notes);
}

#[test]
fn units_from_micrometres_to_kilometres_give_the_same_curve() {
    for noise in [0.0, 5e-4, 8e-3] {
        let points = noisy(&HEM, 300, noise, 17);
        let metre = free(&points);
        for unit in [1e-6, 1e-3, 1e-2, 1e3, 1e6] {
            let scaled = free(&points.iter().map(|p| Point::new(unit * p.x, unit * p.y)).collect::<Vec<_>>());
            let case = format!("noise {noise} unit {unit}");
            assert_eq!((metre.folds, &metre.termination), (scaled.folds, &scaled.termination), "{case}");
            let pairs = [
                (metre.hem.p, scaled.hem.p),
                (metre.hem.q, scaled.hem.q),
                (metre.hem.s, scaled.hem.s),
                (metre.placement.x0, scaled.placement.x0),
                (metre.perimeter, scaled.perimeter),
                (metre.fold_depth, scaled.fold_depth),
                (metre.p.standard_error.unwrap_or(0.0), scaled.p.standard_error.unwrap_or(0.0)),
            ];
            for (a, b) in pairs {
                assert!((a * unit - b).abs() <= 1e-9 * 0.2 * unit, "{case}: {a} {b}");
            }
            assert!((metre.area * unit * unit - scaled.area).abs() <= 1e-9 * scaled.area, "{case}");
        }
    }
}

#[test]
fn tenfold_uneven_density_does_not_mislead() {
    // dt/du from 0.18 to 1.82.
    let mut generator = ChaCha8Rng::seed_from_u64(19);
    for case in 0..20 {
        let hem = Hem { folds: 4 + case, s: 0.003, ..HEM };
        let points: Vec<Point> = (0..480)
            .map(|i| TAU * f64::from(i) / 480.0)
            .map(|u| hem.point(&AT, u + 0.82 * u.sin()))
            .map(|p| Point::new(p.x + 5e-4 * normal(&mut generator), p.y + 5e-4 * normal(&mut generator)))
            .collect();
        agrees(&free(&points), &hem, 5.0, &format!("density, {} folds", hem.folds));
    }
}

#[test]
fn a_fifth_of_gross_outliers_is_seen_in_what_the_fit_says() {
    let mut generator = ChaCha8Rng::seed_from_u64(21);
    let mut points = noisy(&HEM, 360, 5e-4, 23);
    for point in points.iter_mut() {
        if generator.random::<f64>() < 0.2 {
            point.x += 0.05 * normal(&mut generator);
            point.y += 0.05 * normal(&mut generator);
        }
    }
    let fit = free(&points);
    // Least squares believes every point: the count survives, the distances tell that something is wrong, and errors are wide or absent.
    assert_eq!(fit.folds, Some(8), "{:?}", fit.termination);
    assert!(10.0 * 5e-4 < fit.rms, "{}", fit.rms);
    assert!(fit.hem.p.is_finite() && (fit.hem.p - 0.2).abs() < 0.02 && (fit.hem.q - 0.03).abs() < 0.02, "{:?}", fit.hem);
}

#[test]
fn noise_as_large_as_the_folds_gives_the_count_by_order_and_says_how_unsure_it_is() {
    let mut right = 0;
    for seed in 0..20 {
        let fit = free(&noisy(&Hem { s: 0.0, q: 0.01, ..HEM }, 360, 0.01, 100 + seed));
        right += u32::from(fit.folds == Some(8));
        // Where it is wrong it must not be sure.
        assert!(fit.folds == Some(8) || fit.folds_weight < 0.9 || !fit.ties.is_empty(), "{seed}: {:?} {}", fit.folds, fit.folds_weight);
        assert!(0.0 < fit.hem.p && (fit.hem.p - 0.2).abs() < 0.005, "{:?}", fit.hem);
    }
    // q / se(q) = 13: the evidence is there.
    assert!(right >= 18, "{right} of 20");
}

#[test]
fn sixty_folds_are_found_by_evidence_where_they_are_asked_for() {
    let hem = Hem { p: 0.2, q: 0.01, s: 0.0005, folds: 60 };
    for (n, noise) in [(720, 3e-3), (720, 1e-4), (360, 1e-3), (250, 1e-4)] {
        let fit = fitted(&noisy(&hem, n, noise, 29), Folds::Among { from: 2, to: 60 }).expect("a fit");
        assert_eq!(fit.folds, Some(60), "{n} {noise}: {:?}", fit.termination);
    }
}

#[test]
fn two_nearly_equal_fold_counts_are_a_tie_that_is_said() {
    // Waves of seven and of eight, equally high: either leaves the other.
    let points: Vec<Point> = (0..480)
        .map(|i| TAU * f64::from(i) / 480.0)
        .map(|t| (t, 0.2 + 0.005 * ((7.0 * t).cos() + (8.0 * t).cos())))
        .map(|(t, r)| Point::new(r * t.cos(), r * t.sin()))
        .collect();
    let fit = free(&points);
    assert!(fit.ties.contains(&7) && fit.ties.contains(&8), "{:?} {:?} {:?}", fit.folds, fit.ties, fit.candidates);
    assert!(fit.notes.iter().any(|n| n.contains("tied")), "{:?}", fit.notes);
    // Clean folds are no tie.
    assert!(free(&noisy(&HEM, 360, 5e-4, 1)).ties.is_empty());
}

#[test]
fn nothing_and_what_is_no_number_are_refused_with_their_place() {
    assert!(fitted(&[], Folds::default()).expect_err("empty").contains("0 distinct points"));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        let mut points = HEM.outline(&AT, 100);
        points[42].x = bad;
        let error = fitted(&points, Folds::default()).expect_err("not a number");
        assert!(error.contains("x of an outline point"), "{error}");
    }
}
