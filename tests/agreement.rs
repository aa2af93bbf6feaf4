//! The fit against an independent orthogonal distance regression (`scripts/orthogonal_reference.py`, scipy.odr and its own Newton polish).

use std::collections::BTreeMap;

use hemline::experiment::campaign::HemLength;
use hemline::experiment::{DrapeProfile, Point};
use hemline::fit::{self, Options, Termination};
use hemline::units::CENTIMETRE;

const OUTLINES: &str = include_str!("fixtures/outlines.csv");
const REFERENCE: &str = include_str!("fixtures/orthogonal_reference.csv");

fn numbers(line: &str) -> Vec<f64> {
    line.split(',').map(|cell| cell.parse().expect("fixtures hold numbers")).collect()
}

fn outlines() -> BTreeMap<usize, Vec<Point>> {
    let mut outlines: BTreeMap<usize, Vec<Point>> = BTreeMap::new();
    for line in OUTLINES.lines().skip(1) {
        let row = numbers(line);
        outlines.entry(row[0] as usize).or_default().push(Point::new(row[1] * CENTIMETRE, row[2] * CENTIMETRE));
    }
    outlines
}

#[test]
fn p_q_s_m_and_the_sum_of_squares_agree_with_an_independent_orthogonal_fit() {
    let outlines = outlines();
    for line in REFERENCE.lines().skip(2) {
        let row = numbers(line);
        let (case, folds, square) = (row[0] as usize, row[1] as u32, row[7] * CENTIMETRE * CENTIMETRE);
        let profile = DrapeProfile::new(&outlines[&case]).unwrap();
        for length in [HemLength::Auto, HemLength::Free] {
            // The reference is the bare least-squares optimum.
            let fit = fit::fit(&profile, &Options { length, bias_correction: false, ..Options::default() }).unwrap();
            assert_eq!(fit.folds, Some(folds), "case {case}");
            assert_eq!(fit.termination, Termination::Converged, "case {case}");
            let found: f64 = fit.distances.iter().map(|d| d * d).sum();
            // 1e-9 of the sum of squares; the clean outline's is the rounding of its twelve decimals.
            assert!(found <= square * (1.0 + 1e-9) + 1e-24, "case {case}: {found:e} {square:e}");
            for (name, ours, theirs) in [("p", fit.hem.p, row[2]), ("q", fit.hem.q, row[3]), ("s", fit.hem.s, row[4])] {
                let theirs = theirs * CENTIMETRE;
                assert!((ours / theirs - 1.0).abs() < 1e-6, "case {case} {name}: {ours} {theirs}");
            }
            let centre = (fit.placement.x0 - row[5] * CENTIMETRE).hypot(fit.placement.y0 - row[6] * CENTIMETRE);
            assert!(centre < 1e-8, "case {case}: centre off by {centre} m");
        }
    }
}

#[test]
fn the_order_of_the_points_and_the_place_of_the_hem_do_not_matter() {
    for (case, points) in outlines() {
        let fit = |points: &[Point]| fit::fit(&DrapeProfile::new(points).unwrap(), &Options::default()).unwrap();
        let reference = fit(&points);
        let turned: Vec<Point> = points
            .iter()
            .map(|p| {
                let (sin, cos) = 2.1_f64.sin_cos();
                Point::new(3.0 + p.x * cos - p.y * sin, -1.0 + p.x * sin + p.y * cos)
            })
            .collect();
        let mut backwards = points.clone();
        backwards.reverse();
        backwards.rotate_left(points.len() / 3);
        for (what, other) in [("turned", fit(&turned)), ("backwards", fit(&backwards))] {
            assert_eq!(other.folds, reference.folds, "case {case} {what}");
            for (ours, theirs) in [(other.hem.p, reference.hem.p), (other.hem.q, reference.hem.q), (other.hem.s, reference.hem.s)] {
                // Three metres off centre, rounding of the coordinates is 4e-16 m; the fit averages it.
                assert!((ours - theirs).abs() < 1e-10, "case {case} {what}: {ours} {theirs}");
            }
        }
    }
}
