//! Bias, standard errors and intervals of the fit, against what seeded outlines of known p, q, s do.
//!
//! `cargo test --release --test fit_uncertainty -- --nocapture` prints the tables; `HEMLINE_OUTLINES` in the environment says from
//! how many outlines (docs/uncertainty.md: 1000, coverage 200); the hem of the claims always has a thousand.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use hemline::experiment::campaign::{Folds, HemLength};
use hemline::experiment::{DrapeProfile, Point};
use hemline::fit::intervals::{End, Interval, Intervals, Kind};
use hemline::fit::uncertainty::{Unknown, WhyMissing};
use hemline::fit::{self, BiasCorrection, HemFit, Options, Termination, bias};
use hemline::model::hem::{Hem, Placement};
use hemline::numerics::least_squares;
use hemline::statistics::distribution::student_critical;
use hemline::study::intervals::{self, intervals};
use hemline::units::CENTIMETRE;

/// Standard normal deviate (Box–Muller).
fn normal(random: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (random.random(), random.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}

/// An outline as `peers/bench_fits.py` makes them: irregular points, noise alike in both directions, unknown centre and phase; `seed` and
/// `k` make it.
fn outline(hem: &Hem, n: usize, sigma: f64, seed: u64, k: u64) -> DrapeProfile {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(k);
    let mut uniform = || random.random::<f64>();
    let placement =
        Placement { x0: 0.1 * uniform() - 0.05, y0: 0.1 * uniform() - 0.05, phase: TAU / f64::from(hem.folds.max(1)) * uniform() };
    let start: f64 = uniform();
    let points: Vec<Point> = (0..n)
        .map(|i| {
            let on = hem.point(&placement, TAU * (i as f64 + random.random::<f64>() + start) / n as f64);
            Point::new(on.x + sigma * normal(&mut random), on.y + sigma * normal(&mut random))
        })
        .collect();
    DrapeProfile::new(&points).expect("an outline")
}

fn centimetres(p: f64, q: f64, s: f64, folds: u32) -> Hem {
    Hem { p: p * CENTIMETRE, q: q * CENTIMETRE, s: s * CENTIMETRE, folds }
}

fn fitted(profile: &DrapeProfile, folds: u32, bias_correction: bool) -> HemFit {
    let options = Options { folds: Folds::Exactly(folds), bias_correction, ..Options::default() };
    fit::fit(profile, &options).expect("a fit")
}

/// The hem of the claims: p, q, s = 20, 3, 1.5 cm, eight folds.
fn example() -> Hem {
    centimetres(20.0, 3.0, 1.5, 8)
}

/// How many outlines a table is made from.
fn outlines(few: u64) -> u64 {
    std::env::var("HEMLINE_OUTLINES").ok().and_then(|n| n.parse().ok()).unwrap_or(few)
}

/// What the replicates of one estimate did.
#[derive(Debug, Clone, Copy)]
struct Record {
    /// Mean error over standard deviation.
    bias: f64,
    /// The same of the least-squares optimum before the correction.
    uncorrected: f64,
    /// Mean standard error over standard deviation.
    error: f64,
    /// Share of 95 % intervals that cover the truth, and of those about the optimum before the correction.
    coverage: f64,
    uncorrected_coverage: f64,
}

/// Records of p, q, s over seeded outlines; how many were corrected; mean reported and true correlation of (p, q), (p, s), (q, s).
fn records(hem: &Hem, n: usize, sigma: f64, count: u64) -> ([Record; 3], usize, [(f64, f64); 3]) {
    let fits: Vec<HemFit> = (0..count).into_par_iter().map(|k| fitted(&outline(hem, n, sigma, 11, k), hem.folds, true)).collect();
    let truths = [hem.p, hem.q, hem.s];
    let of = |fit: &HemFit| [fit.p, fit.q.unwrap(), fit.s.unwrap()].map(|e| (e.value, e.standard_error.expect("determined")));
    let removed = |fit: &HemFit| fit.bias_correction.applied().map_or([0.0; 3], |c| [c.p, c.q, c.s]);
    let mean = |pick: &dyn Fn(&HemFit) -> f64| fits.iter().map(pick).sum::<f64>() / count as f64;
    let means: [f64; 3] = std::array::from_fn(|j| mean(&|fit| of(fit)[j].0));
    let product = |i: usize, j: usize| mean(&|fit| (of(fit)[i].0 - means[i]) * (of(fit)[j].0 - means[j]));
    let records = std::array::from_fn(|j| {
        let deviation = product(j, j).sqrt();
        let covers = |value: f64, error: f64, df: usize| f64::from((value - truths[j]).abs() <= student_critical(0.05, df as f64) * error);
        Record {
            bias: (means[j] - truths[j]) / deviation,
            uncorrected: mean(&|fit| of(fit)[j].0 - removed(fit)[j] - truths[j]) / deviation,
            error: mean(&|fit| of(fit)[j].1) / deviation,
            coverage: mean(&|fit| covers(of(fit)[j].0, of(fit)[j].1, fit.degrees_of_freedom)),
            uncorrected_coverage: mean(&|fit| covers(of(fit)[j].0 - removed(fit)[j], of(fit)[j].1, fit.degrees_of_freedom)),
        }
    });
    let correlations = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| {
        let reported = mean(&|fit| fit.correlation.expect("determined")[i + 3][j + 3]);
        (reported, product(i, j) / (product(i, i) * product(j, j)).sqrt())
    });
    (records, fits.iter().filter(|fit| fit.bias_correction.applied().is_some()).count(), correlations)
}

fn print_records(hem: &Hem, n: usize, sigma: f64, count: u64, records: &[Record; 3], corrected: usize) {
    let cm = |v: f64| v / CENTIMETRE;
    let hem = format!("({}, {}, {}; {})", cm(hem.p), cm(hem.q), cm(hem.s), hem.folds);
    for (name, r) in ["p", "q", "s"].iter().zip(records) {
        println!(
            "| {hem} | {n} | {sigma} | {name} | {:+.2} | {:+.2} | {:.1} | {:.1} | {:.2} | {corrected}/{count} |",
            r.uncorrected,
            r.bias,
            100.0 * r.uncorrected_coverage,
            100.0 * r.coverage,
            r.error
        );
    }
}

const RECORD_HEADING: &str =
    "| p, q, s; m, cm | points | σ, cm | | bias before, sd | bias, sd | 95 % covers before, % | covers, % | se/sd | corrected |";

#[test]
fn over_a_thousand_outlines_the_bias_is_below_a_quarter_of_the_scatter_and_intervals_cover() {
    println!("{RECORD_HEADING}");
    for sigma in [0.05, 0.1, 0.2] {
        let (records, corrected, correlations) = records(&example(), 360, sigma * CENTIMETRE, 1000);
        print_records(&example(), 360, sigma, 1000, &records, corrected);
        assert_eq!(corrected, 1000, "σ {sigma}");
        for (name, r) in ["p", "q", "s"].iter().zip(records) {
            // The claims themselves; a thousand outlines leave ±0.03 of the bias and ±0.7 % of the coverage to chance, the seed is fixed.
            assert!(r.bias.abs() <= 0.25, "σ {sigma} {name}: {r:?}");
            assert!((0.93..=0.97).contains(&r.coverage), "σ {sigma} {name}: {r:?}");
            assert!((r.error - 1.0).abs() < 0.1, "σ {sigma} {name}: {r:?}");
        }
        for (reported, seen) in correlations {
            // A correlation of a thousand pairs is known to ±0.03.
            assert!((reported - seen).abs() < 0.1, "σ {sigma}: correlation {reported}, seen {seen}");
        }
        // Were it not for the correction: what it is for, and its sign.
        if sigma == 0.2 {
            assert!(0.4 < records[2].uncorrected && records[2].uncorrected_coverage < 0.93, "{:?}", records[2]);
        }
    }
}

#[test]
fn the_bias_is_small_at_other_shapes_and_with_few_points_too() {
    println!("{RECORD_HEADING}");
    let count = outlines(80);
    for (hem, n, sigma) in [
        (centimetres(20.0, 0.5, 0.1, 8), 360, 0.1),
        (centimetres(20.0, 4.0, 1.5, 5), 360, 0.2),
        (centimetres(20.0, 2.0, 0.5, 14), 360, 0.2),
        (example(), 90, 0.1),
        (example(), 90, 0.2),
        (example(), 360, 0.3),
        (example(), 360, 0.4),
    ] {
        let (records, corrected, _) = records(&hem, n, sigma * CENTIMETRE, count);
        print_records(&hem, n, sigma, count, &records, corrected);
        for r in records {
            // A quarter, and three standard errors of a mean over so many.
            assert!(r.bias.abs() <= 0.25 + 3.0 / (count as f64).sqrt(), "{hem:?} n {n} σ {sigma}: {r:?}");
        }
    }
}

#[test]
fn the_corrected_curve_is_a_root_of_the_estimating_equations_by_independent_arithmetic() {
    // Distances by a scan of the curve, curvature and Jacobian by differences: nothing of the fit is used but its result.
    let sigma = 0.1 * CENTIMETRE;
    let profile = outline(&example(), 180, sigma, 3, 0);
    let fit = fitted(&profile, 8, true);
    let correction = fit.bias_correction.applied().expect("corrected");
    let unknowns = [fit.placement.x0, fit.placement.y0, fit.placement.phase, fit.hem.p, fit.hem.q, fit.hem.s];
    let curve = |u: &[f64; 6]| (Hem { p: u[3], q: u[4], s: u[5], folds: 8 }, Placement { x0: u[0], y0: u[1], phase: u[2] });
    let distance = |u: &[f64; 6], point: Point, near: f64| -> (f64, f64) {
        let (hem, placement) = curve(u);
        // Golden section: the squared distance is unimodal within a hundredth of a turn of the foot.
        let (mut low, mut high) = (near - 0.01, near + 0.01);
        let at = |t: f64| hem.point(&placement, t).distance(point);
        for _ in 0..80 {
            let (a, b) = (high - 0.618_033_988_749_895 * (high - low), low + 0.618_033_988_749_895 * (high - low));
            if at(a) < at(b) { high = b } else { low = a }
        }
        let t = 0.5 * (low + high);
        let h = 1e-5;
        let (before, after, foot) = (hem.point(&placement, t - h), hem.point(&placement, t + h), hem.point(&placement, t));
        let (ux, uy) = ((after.x - before.x) / (2.0 * h), (after.y - before.y) / (2.0 * h));
        let (ax, ay) = ((after.x - 2.0 * foot.x + before.x) / (h * h), (after.y - 2.0 * foot.y + before.y) / (h * h));
        let side = ux * (point.y - foot.y) - uy * (point.x - foot.x);
        // Counter-clockwise: outside is to the right.
        (at(t).copysign(-side), (ux * ay - uy * ax) / ux.hypot(uy).powi(3))
    };
    let n = profile.points().len();
    let seen: Vec<(f64, f64)> = (0..n).map(|i| distance(&unknowns, profile.points()[i], fit.feet[i])).collect();
    for (i, (d, _)) in seen.iter().enumerate() {
        // The golden section finds t to √ε, the distance to ε.
        assert!((d - fit.distances[i]).abs() < 1e-9, "point {i}: {d} {}", fit.distances[i]);
    }
    let half = 0.5 * correction.sigma * correction.sigma;
    let e: Vec<f64> = seen.iter().map(|(d, kappa)| d - half * kappa).collect();
    let spread = e.iter().map(|e| e * e).sum::<f64>() / (n - 6) as f64;
    let neighbours = (0..n).map(|i| (e[(i + 1) % n] - e[i]).powi(2)).sum::<f64>() / (2 * n) as f64;
    // Curvature by second differences is right to 1e-5 of itself, and is itself a hundredth of e.
    assert!((spread.min(neighbours).sqrt() / correction.sigma - 1.0).abs() < 1e-6, "{spread} {neighbours} {correction:?}");
    for j in 0..6 {
        let h = 1e-6;
        let (mut with, mut without) = (0.0, 0.0);
        let mut square = 0.0;
        for i in 0..n {
            let shifted = |by: f64| {
                let mut u = unknowns;
                u[j] += by;
                distance(&u, profile.points()[i], fit.feet[i]).0
            };
            let row = (shifted(h) - shifted(-h)) / (2.0 * h);
            with += row * e[i];
            without += row * seen[i].0;
            square += row * row;
        }
        // In units of one standard error of the equation.
        let unit = (square * spread).sqrt();
        assert!((with / unit).abs() < 1e-5, "unknown {j}: {}", with / unit);
        if j == 5 {
            assert!(0.05 < (without / unit).abs(), "the correction does nothing to s: {}", without / unit);
        }
    }
}

#[test]
fn a_circle_loses_its_bias_in_closed_form_and_says_that_it_has_no_folds() {
    // E r = R + σ²/2R: with σ = R/20 and 200 points that is 0.35 standard errors of the radius.
    let round = Hem { p: 0.2, q: 0.0, s: 0.0, folds: 0 };
    let sigma = 0.01;
    let options = Options { folds: Folds::Among { from: 2, to: 4 }, ..Options::default() };
    let fits: Vec<HemFit> = (0..400)
        .into_par_iter()
        .map(|k| fit::fit(&outline(&round, 200, sigma, 5, k), &options).unwrap())
        .filter(|f| f.folds.is_none())
        .collect();
    // With three more unknowns in the curve of two to four folds, about one outline in three looks folded to Akaike's criterion.
    assert!(200 < fits.len(), "{}", fits.len());
    let n = fits.len() as f64;
    let mean = |pick: &dyn Fn(&HemFit) -> f64| fits.iter().map(pick).sum::<f64>() / n;
    let error = mean(&|f| f.p.standard_error.expect("determined"));
    let change = mean(&|f| f.bias_correction.applied().expect("corrected").p);
    assert!((change / (-0.5 * sigma * sigma / 0.2) - 1.0).abs() < 0.1, "{change}");
    let bias = mean(&|f| f.hem.p - 0.2);
    // 4 standard errors of the mean; uncorrected it would be 7.
    assert!(bias.abs() < 4.0 * error / n.sqrt(), "{bias} {error}");
    for fit in &fits {
        let why: Vec<_> = fit.standard_error_missing.iter().map(|m| (m.unknown, m.why)).collect();
        assert_eq!(why, [Unknown::Phase, Unknown::Q, Unknown::S].map(|u| (u, WhyMissing::NoFolds)));
        assert!(fit.q.is_none() && fit.covariance.is_none() && fit.correlation.is_none());
        assert!((fit.rms * fit.rms * 200.0 - fit.distances.iter().map(|d| d * d).sum::<f64>()).abs() < 1e-12);
    }
    let profile = outline(&round, 200, sigma, 5, 0);
    for kind in [Kind::Standard, Kind::Profile, Kind::Bootstrap, Kind::CaseBootstrap] {
        let found = intervals(&profile, &fits[0], &intervals::Options { kind, replicates: 200, ..Default::default() });
        assert!(found.p.is_some() && found.q.is_none() && found.s.is_none() && found.phase.is_none(), "{kind:?}");
    }
}

#[test]
fn without_noise_nothing_is_corrected_and_at_a_held_length_the_length_stays_held() {
    let clean = outline(&example(), 180, 0.0, 1, 0);
    let fit = fitted(&clean, 8, true);
    assert!(fit.bias_correction.applied().is_some_and(|c| c.s.abs() < 1e-12 && c.p.abs() < 1e-12), "{:?}", fit.bias_correction);
    let asked = example().perimeter();
    let held: Vec<HemFit> = (0..100)
        .into_par_iter()
        .map(|k| {
            let options = Options { folds: Folds::Exactly(8), length: HemLength::Held(asked), ..Options::default() };
            fit::fit(&outline(&example(), 360, 0.2 * CENTIMETRE, 11, k), &options).unwrap()
        })
        .collect();
    let (mut moved, mut covered) = (0.0, 0);
    for fit in &held {
        assert_eq!(fit.termination, Termination::LengthAsAsked);
        assert!((fit.perimeter / asked - 1.0).abs() < 1e-9, "{}", fit.perimeter / asked);
        let s = fit.s.unwrap();
        moved += fit.bias_correction.applied().expect("corrected").s / s.standard_error.unwrap();
        covered +=
            usize::from((s.value - example().s).abs() < student_critical(0.05, fit.degrees_of_freedom as f64) * s.standard_error.unwrap());
        assert_eq!(fit.degrees_of_freedom, 355);
    }
    // The bias of s is taken out here too; 95 ± 3 × 2.2 of a hundred intervals cover.
    assert!(moved / 100.0 < -0.1, "{moved}");
    assert!((88..=100).contains(&covered), "{covered}");
}

#[test]
fn the_correction_is_left_out_and_the_reason_said_where_it_does_not_hold() {
    let profile = outline(&example(), 360, 0.1 * CENTIMETRE, 11, 0);
    let off = fitted(&profile, 8, false);
    assert_eq!(off.bias_correction, BiasCorrection::Left(bias::Uncorrected::Off));
    let on = fitted(&profile, 8, true);
    let c = on.bias_correction.applied().expect("corrected");
    assert!(
        (on.hem.s - off.hem.s - c.s).abs() < 1e-12
            && (on.hem.q - off.hem.q - c.q).abs() < 1e-12
            && (on.hem.p - off.hem.p - c.p).abs() < 1e-12
    );
    assert!(off.rms <= on.rms, "the optimum has the least rms");
    // Bends of 3 mm radius under noise of 2 mm.
    let wide = fitted(&outline(&centimetres(20.0, 1.0, 1.1, 10), 360, 0.2 * CENTIMETRE, 11, 0), 10, true);
    assert_eq!(wide.bias_correction, BiasCorrection::Left(bias::Uncorrected::SharpBends));
    assert!(wide.notes.iter().any(|note| note.contains("bends as narrowly")), "{:?}", wide.notes);
    // Few evaluations: no minimum, so neither a correction nor an error bar.
    let hasty = Options {
        folds: Folds::Exactly(8),
        solver: least_squares::Options { evaluation_limit: 3, ..Default::default() },
        ..Options::default()
    };
    let hasty = fit::fit(&profile, &hasty).expect("a sane curve all the same");
    assert_eq!(hasty.termination, Termination::EvaluationLimit);
    assert_eq!(hasty.bias_correction, BiasCorrection::Left(bias::Uncorrected::NotConverged));
    assert!(hasty.p.standard_error.is_none() && hasty.standard_error_missing.iter().all(|m| m.why == WhyMissing::NotConverged));
    assert_eq!(hasty.standard_error_missing.len(), 6);
    let found = intervals(&profile, &hasty, &intervals::Options { kind: Kind::Profile, ..Default::default() });
    assert_eq!((found.p, found.q, found.s, found.phase), (None, None, None, None));
}

#[test]
fn folds_below_the_noise_have_no_error_bars_but_an_upper_end() {
    // Eight folds are asked for, none are there: the amplitude is the length of a random vector of two components.
    let round = Hem { p: 0.2, q: 0.0, s: 0.0, folds: 8 };
    let fits: Vec<(DrapeProfile, HemFit)> = (0..100)
        .into_par_iter()
        .map(|k| outline(&round, 180, 0.001, 7, k))
        .filter_map(|profile| {
            let options = Options { folds: Folds::Exactly(8), ..Options::default() };
            let fit = fit::fit(&profile, &options).ok()?;
            Some((profile, fit))
        })
        .collect();
    let unsure: Vec<&(DrapeProfile, HemFit)> = fits.iter().filter(|(_, f)| f.q.unwrap().standard_error.is_none()).collect();
    // A test at the 5 % level lets one in twenty through; 95 ± 3 × 2.2 % here, some more for s, which is searched too.
    assert!(0.85 <= unsure.len() as f64 / fits.len() as f64, "{} of {}", unsure.len(), fits.len());
    // Without folds the phase moves nothing, and one fit in six does not come to rest; it says so, and that is its reason.
    let rested: Vec<_> = unsure.iter().filter(|(_, f)| f.termination == Termination::Converged).collect();
    assert!(2 * fits.len() < 3 * rested.len(), "{} of {}", rested.len(), fits.len());
    let ends: Vec<[bool; 3]> = rested
        .par_iter()
        .map(|(profile, fit)| {
            let why: Vec<_> = fit.standard_error_missing.iter().map(|m| (m.unknown, m.why)).collect();
            assert_eq!(why, [Unknown::Phase, Unknown::Q, Unknown::S].map(|u| (u, WhyMissing::FoldsWithinNoise)));
            assert!(fit.p.standard_error.is_some() && fit.covariance.is_none());
            assert!(fit.notes.iter().any(|note| note.contains("not told from zero")));
            let found = intervals(profile, fit, &intervals::Options { kind: Kind::Profile, ..Default::default() });
            // Whatever end is given lies beyond the estimate.
            let q = found.q.expect("a likelihood");
            if let End::At(high) = q.high {
                assert!(fit.hem.q < high && high < 0.001, "{q:?}");
            }
            if let End::At(low) = q.low {
                assert!(0.0 <= low && low < fit.hem.q, "{q:?}");
            }
            let both = matches!(found.p, Some(Interval { low: End::At(_), high: End::At(_) }));
            [matches!(q.low, End::At(_)), matches!(q.high, End::At(_)), both]
        })
        .collect();
    for (profile, fit) in rested.iter().take(6) {
        for kind in [Kind::Standard, Kind::Bootstrap] {
            let found = intervals(profile, fit, &intervals::Options { kind, replicates: 100, ..Default::default() });
            assert!(found.q.is_none() && found.s.is_none() && found.phase.is_none(), "{kind:?}");
        }
    }
    let [excluded, bounded, mean] = [0, 1, 2].map(|which| ends.iter().filter(|e| e[which]).count());
    let n = ends.len();
    println!("of {n} amplitudes within the noise {bounded} have an upper end, {excluded} a lower one; {mean} mean radii have both ends");
    // The likelihood of the amplitude alone is stricter than the test of amplitude and phase together: it excludes zero where the squared length of the
    // random vector lies between the 95 % points of χ² with one and with two degrees of freedom, e^−1.92 − e^−3 = 0.1 of them; three standard errors more.
    assert!(excluded as f64 <= 0.2 * n as f64, "{excluded} of {n}");
    // A third to a half have an end; at others the fit does not come to rest on the way there, and the end is said to be lost.
    assert!(n < 4 * bounded && n < 2 * mean, "{bounded} {mean} of {n}");
}

#[test]
fn profile_likelihood_ends_are_where_an_independent_fit_says_they_are() {
    // Uncorrected, so that the likelihood is that of the bare distances; the four other unknowns and the parameter's neighbours are fitted anew by
    // the generic solver with numeric derivatives and feet found from scratch.
    struct Held<'a> {
        points: &'a [Point],
        feet: &'a [f64],
        index: usize,
        value: f64,
    }
    impl Held<'_> {
        fn full(&self, x: &[f64]) -> [f64; 6] {
            let mut full = [0.0; 6];
            let mut rest = x.iter();
            (0..6).for_each(|j| full[j] = if j == self.index { self.value } else { *rest.next().unwrap() });
            full
        }
        fn distances(&self, x: &[f64]) -> Vec<f64> {
            let u = self.full(x);
            let (hem, placement) = (Hem { p: u[3], q: u[4], s: u[5], folds: 8 }, Placement { x0: u[0], y0: u[1], phase: u[2] });
            let foot = |i: usize| {
                hemline::fit::foot_point::nearest_within(
                    &hem,
                    hemline::fit::foot_point::centred(self.points[i], &placement),
                    self.feet[i] - 0.05,
                    self.feet[i] + 0.05,
                    9,
                )
            };
            (0..self.points.len()).map(|i| foot(i).distance()).collect()
        }
    }
    impl least_squares::Problem for Held<'_> {
        fn residual_count(&self) -> usize {
            self.points.len()
        }
        fn residuals(&mut self, x: &[f64], residuals: &mut [f64]) -> bool {
            residuals.copy_from_slice(&self.distances(x));
            true
        }
        fn jacobian(&mut self, x: &[f64], jacobian: &mut nalgebra::DMatrix<f64>) -> bool {
            for j in 0..x.len() {
                let h = 1e-6;
                let shifted = |by: f64| {
                    let mut x = x.to_vec();
                    x[j] += by;
                    self.distances(&x)
                };
                let (above, below) = (shifted(h), shifted(-h));
                (0..above.len()).for_each(|i| jacobian[(i, j)] = (above[i] - below[i]) / (2.0 * h));
            }
            true
        }
    }
    let profile = outline(&example(), 120, 0.2 * CENTIMETRE, 21, 0);
    let fit = fitted(&profile, 8, false);
    let found = intervals(&profile, &fit, &intervals::Options { kind: Kind::Profile, level: 0.99, ..Default::default() });
    let all = [fit.placement.x0, fit.placement.y0, fit.placement.phase, fit.hem.p, fit.hem.q, fit.hem.s];
    let sum: f64 = fit.distances.iter().map(|d| d * d).sum();
    let t = student_critical(0.01, 114.0);
    for (index, interval) in [(3, found.p), (4, found.q), (5, found.s), (2, found.phase)] {
        let interval = interval.expect("a likelihood");
        for end in [interval.low, interval.high] {
            let End::At(value) = end else { panic!("{index}: {end:?}") };
            let start: Vec<f64> = (0..6).filter(|&j| j != index).map(|j| all[j]).collect();
            let mut problem = Held { points: profile.points(), feet: &fit.feet, index, value };
            let options = least_squares::Options { gradient_tolerance: 1e-6, ..Default::default() };
            let held = least_squares::solve(&mut problem, &start, &options).unwrap();
            let ratio = (held.sum_of_squares / sum - 1.0) * 114.0;
            // The end is right to 1e-7, so the ratio to 2e-7 of itself; the numeric derivatives' optimum is short by their square.
            assert!((ratio / (t * t) - 1.0).abs() < 1e-5, "unknown {index}: {ratio} {}", t * t);
        }
    }
}

#[test]
fn with_little_noise_all_four_kinds_of_interval_are_the_same() {
    let profile = outline(&example(), 360, 0.005 * CENTIMETRE, 31, 0);
    let fit = fitted(&profile, 8, true);
    let found = |kind: Kind| intervals(&profile, &fit, &intervals::Options { kind, replicates: 1000, ..Default::default() });
    let ends = |i: &Intervals| -> Vec<f64> {
        [i.p, i.q, i.s, i.phase].iter().flat_map(|i| [i.unwrap().low, i.unwrap().high]).map(|e| e.value().unwrap()).collect()
    };
    let standard = ends(&found(Kind::Standard));
    // A quantile at 2.5 % of a thousand draws is known to ±6 % of half the interval; 20 % is three of that. The likelihood has no such noise:
    // curvature of the model at σ/q = 0.002 is all that is left.
    for (kind, allowed) in [(Kind::Profile, 0.005), (Kind::Bootstrap, 0.2), (Kind::CaseBootstrap, 0.2)] {
        let found = found(kind);
        if let Some(replicates) = &found.replicates {
            assert_eq!(replicates.failed, 0, "{kind:?}");
            let claimed = [fit.p.standard_error, fit.q.unwrap().standard_error, fit.s.unwrap().standard_error, fit.placement_errors[2]];
            for (ours, theirs) in replicates.standard_errors.iter().zip(claimed) {
                // ±2.2 % by a thousand draws; cases differ from the model by the sample's own fourth moments, a few percent more.
                assert!((ours.unwrap() / theirs.unwrap() - 1.0).abs() < 0.15, "{kind:?}: {ours:?} {theirs:?}");
            }
        }
        for (j, pair) in ends(&found).chunks(2).enumerate() {
            let half = 0.5 * (standard[2 * j + 1] - standard[2 * j]);
            for side in 0..2 {
                assert!((pair[side] - standard[2 * j + side]).abs() < allowed * half, "{kind:?} parameter {j}: {pair:?} {standard:?}");
            }
        }
    }
}

#[test]
fn bootstraps_are_the_same_on_one_two_and_three_threads() {
    let profile = outline(&example(), 120, 0.1 * CENTIMETRE, 41, 0);
    let fit = fitted(&profile, 8, true);
    for kind in [Kind::Bootstrap, Kind::CaseBootstrap] {
        let with = |threads: usize, seed: u64| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| intervals(&profile, &fit, &intervals::Options { kind, replicates: 150, seed, ..Default::default() }))
        };
        let one = with(1, 9);
        // Bit for bit: equality of f64.
        assert_eq!(one, with(2, 9), "{kind:?}");
        assert_eq!(one, with(3, 9), "{kind:?}");
        assert_ne!(one.p, with(2, 10).p, "the seed does nothing");
    }
}

#[test]
fn coverage_of_the_four_kinds_of_interval() {
    // As many outlines, and replicates of each, as asked; few by default, so that the tolerance is wide.
    let count = outlines(40);
    let replicates = 200;
    println!("| points | σ, cm | interval | p covered, % | q, % | s, % | width of s, standard = 1 | replicates failed |");
    let cases = [(90, 0.2), (360, 0.1), (360, 0.2)];
    for (n, sigma) in if 200 <= count { &cases[..] } else { &cases[..1] } {
        let (n, sigma) = (*n, *sigma);
        let fits: Vec<(DrapeProfile, HemFit)> = (0..count)
            .into_par_iter()
            .map(|k| outline(&example(), n, sigma * CENTIMETRE, 12, k))
            .map(|profile| {
                let fit = fitted(&profile, 8, true);
                (profile, fit)
            })
            .collect();
        let mut widths = f64::NAN;
        for kind in [Kind::Standard, Kind::Profile, Kind::Bootstrap, Kind::CaseBootstrap] {
            let options = intervals::Options { kind, replicates, ..Default::default() };
            let found: Vec<Intervals> = fits.par_iter().map(|(profile, fit)| intervals(profile, fit, &options)).collect();
            let truths = [example().p, example().q, example().s];
            let covered: [f64; 3] = std::array::from_fn(|j| {
                found.iter().filter(|i| [i.p, i.q, i.s][j].is_some_and(|i| i.covers(truths[j]))).count() as f64 / count as f64
            });
            let width = |i: &Intervals| i.s.and_then(|s| Some(s.high.value()? - s.low.value()?)).expect("closed");
            let mean = found.iter().map(width).sum::<f64>() / count as f64;
            if kind == Kind::Standard {
                widths = mean;
            }
            let failed: usize = found.iter().filter_map(|i| i.replicates.as_ref()).map(|r| r.failed).sum();
            let [p, q, s] = covered.map(|share| 100.0 * share);
            println!("| {n} | {sigma} | {} | {p:.1} | {q:.1} | {s:.1} | {:.3} | {failed} |", kind.name(), mean / widths);
            // 95 % less a percent of modelling and three binomial standard errors, and what 2.5 % quantiles of so few draws are short by.
            // Cases vary in how they lie along the hem, too: of 90 points, their intervals of p are known to fall short by some percent.
            let nominal = if kind == Kind::CaseBootstrap { 0.90 } else { 0.94 };
            let least = nominal - 3.0 * (0.05 * 0.95 / count as f64).sqrt() - 2.0 / replicates as f64;
            assert!(covered.iter().all(|share| least <= *share), "n {n} σ {sigma} {kind:?}: {covered:?}");
        }
    }
}

#[test]
fn the_command_gives_intervals_of_every_kind_and_the_same_ones_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("outline.csv");
    let profile = outline(&example(), 120, 0.1 * CENTIMETRE, 51, 0);
    let rows: String = profile.points().iter().map(|p| format!("{},{}\n", p.x / CENTIMETRE, p.y / CENTIMETRE)).collect();
    std::fs::write(&file, format!("x_cm,y_cm\n{rows}")).unwrap();
    let run = |arguments: &[&str], threads: &str| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_hemline"));
        command.arg("fit").arg(&file).args(["--folds", "8"]).args(arguments).env("RAYON_NUM_THREADS", threads);
        command.output().unwrap()
    };
    let json = |arguments: &[&str]| -> serde_json::Value {
        let out = run(&[arguments, &["--json"]].concat(), "2");
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        serde_json::from_slice::<serde_json::Value>(&out.stdout).unwrap()[0].clone()
    };
    for kind in ["standard", "profile", "bootstrap", "case-bootstrap"] {
        let row = json(&["--intervals", kind, "--level", "0.9", "--replicates", "200", "--seed", "3"]);
        assert_eq!((row["interval_kind"].as_str(), row["interval_level"].as_f64()), (Some(kind), Some(0.9)));
        for name in ["p", "q", "s"] {
            let number = |column: String| row[&column].as_f64().unwrap_or_else(|| panic!("{kind}: {column}"));
            let (low, value, high) = (number(format!("{name}_low_mm")), number(format!("{name}_mm")), number(format!("{name}_high_mm")));
            assert!(low < value && value < high, "{kind} {name}: {low} {value} {high}");
        }
        assert_eq!(row["replicates"].is_null(), !kind.contains("bootstrap"));
        assert!(row["standard_error_missing"].is_null() && row["intervals_open"].is_null());
        assert_eq!(row["bias_correction"].as_str(), Some("applied"));
    }
    let off = json(&["--bias-correction", "off"]);
    assert_eq!(off["bias_correction"].as_str(), Some("off"));
    assert!(off["bias_s_mm"].is_null() && off["s_mm"] != json(&[])["s_mm"]);
    let bootstrap = ["--intervals", "bootstrap", "--replicates", "150"];
    assert_eq!(run(&bootstrap, "1").stdout, run(&bootstrap, "3").stdout);
    for wrong in [["--level", "95"], ["--intervals", "exact"], ["--bias-correction", "maybe"], ["--replicates", "3"]] {
        assert_eq!(run(&wrong, "1").status.code(), Some(2), "{wrong:?}");
    }
}
