//! The space-filling trap: forty skirts whose uneven, overhanging folds lead a plain foot-point fit astray.

use std::f64::consts::TAU;

use hemline::experiment::{DrapeProfile, Point};
use hemline::fit::{self, Options, orthogonal};
use hemline::model::hem::{Hem, Placement};
use hemline::units::CENTIMETRE;

/// The outlines that ship with the program.
fn skirts() -> Vec<(usize, DrapeProfile)> {
    (1..=40)
        .map(|run| {
            let path = format!("{}/data/profiles/run_{run:02}.csv", env!("CARGO_MANIFEST_DIR"));
            let text = std::fs::read_to_string(path).expect("the shipped campaign");
            let point = |line: &str| {
                let cells: Vec<f64> = line.split(',').map(|c| c.parse().expect("a number")).collect();
                Point::new(cells[0] * CENTIMETRE, cells[1] * CENTIMETRE)
            };
            let points: Vec<Point> = text.lines().skip(1).map(point).collect();
            (run, DrapeProfile::new(&points).expect("a sound profile"))
        })
        .collect()
}

fn polygon_length(points: &[Point]) -> f64 {
    points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| a.distance(*b)).sum()
}

/// Greatest distance of a point of `from` from the closed polygon `to`.
fn farthest(from: &[Point], to: &[Point]) -> f64 {
    let distance = |p: &Point| {
        let sides = to.iter().zip(to.iter().cycle().skip(1));
        let squares = sides.map(|(a, b)| {
            let (ex, ey) = (b.x - a.x, b.y - a.y);
            let share = (((p.x - a.x) * ex + (p.y - a.y) * ey) / (ex * ex + ey * ey)).clamp(0.0, 1.0);
            (p.x - a.x - share * ex).powi(2) + (p.y - a.y - share * ey).powi(2)
        });
        squares.fold(f64::MAX, f64::min).sqrt()
    };
    from.iter().map(distance).fold(0.0, f64::max)
}

fn crosses_itself(points: &[Point]) -> bool {
    let side = |a: Point, b: Point, c: Point| (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    let n = points.len();
    (0..n).any(|i| {
        let (a, b) = (points[i], points[(i + 1) % n]);
        (i + 2..n).filter(|&j| (j + 1) % n != i).any(|j| {
            let (c, d) = (points[j], points[(j + 1) % n]);
            side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
        })
    })
}

/// A fit as it is usually written: polar harmonics as the start, the nearest foot of each point, the least sum of squares over 3 to 9 folds.
fn plain_fit(profile: &DrapeProfile) -> (Hem, f64) {
    let points = profile.points();
    let n = points.len() as f64;
    let (x0, y0) = (points.iter().map(|p| p.x).sum::<f64>() / n, points.iter().map(|p| p.y).sum::<f64>() / n);
    let polar: Vec<(f64, f64)> = points.iter().map(|p| ((p.y - y0).atan2(p.x - x0), (p.x - x0).hypot(p.y - y0))).collect();
    let mean = polar.iter().map(|(_, r)| r).sum::<f64>() / n;
    let fits = (3..=9).map(|folds| {
        let m = f64::from(folds);
        let (re, im) =
            polar.iter().fold((0.0, 0.0), |(re, im), (a, r)| (re + 2.0 / n * r * (m * a).cos(), im + 2.0 / n * r * (m * a).sin()));
        let phase = im.atan2(re) / m;
        let hem = Hem { p: mean, q: re.hypot(im), s: 0.0, folds };
        let feet = polar.iter().map(|(a, _)| a - phase).collect();
        let fitted =
            orthogonal::fit(points, hem, Placement { x0, y0, phase }, feet, None, f64::INFINITY, &Options::default().solver).unwrap();
        (fitted.hem, fitted.summary.sum_of_squares)
    });
    fits.filter(|(_, square)| square.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1)).expect("seven fits")
}

#[test]
fn a_plain_fit_ends_in_nonsense_on_most_skirts_and_this_one_on_none() {
    let mut trapped = Vec::new();
    for (run, profile) in skirts() {
        let outline = profile.points();
        let length = polygon_length(outline);
        let (hem, _) = plain_fit(&profile);
        // Curves that fill space begin at a tenth more length than the outline has; cloth does not stretch.
        let stretch = hem.perimeter() / length;
        if !stretch.is_finite() || 1.1 <= stretch {
            trapped.push(run);
        }

        let fit = fit::fit(&profile, &Options::default()).unwrap_or_else(|e| panic!("run {run}: {e}"));
        let curve = fit.outline(2000);
        let folds = fit.folds.unwrap_or_else(|| panic!("run {run}: no folds"));
        assert!((3..=9).contains(&folds), "run {run}: {folds} folds");
        assert!((fit.perimeter / length - 1.0).abs() < 0.06, "run {run}: length {} of {length}", fit.perimeter);
        assert!(!crosses_itself(&curve), "run {run} crosses itself");
        let (there, back) = (farthest(outline, &curve), farthest(&curve, outline));
        // Near both ways: no spike of the curve into a place where no point sees it. A hundredth of the radius for the chords.
        assert!(back < 1.6 * there + 0.01 * fit.hem.p, "run {run}: {there} {back}");
        let mut turned = 0.0;
        for i in 0..fit.feet.len() {
            let step = fit.feet[(i + 1) % fit.feet.len()] - fit.feet[i];
            turned += step - TAU * (step / TAU).round();
        }
        assert!((turned - TAU).abs() < 1e-6, "run {run}: the feet turn by {turned}");
        assert!(fit.hem.q >= 0.0 && (0.0..TAU / f64::from(folds)).contains(&fit.placement.phase));
    }
    println!("a plain fit falls into the trap on {} of 40 runs: {trapped:?}", trapped.len());
    assert!(trapped.len() >= 25, "{trapped:?}");
}

/// Standard normal deviates from a seeded generator (Box–Muller).
fn normal(generator: &mut rand_chacha::ChaCha8Rng) -> f64 {
    use rand::RngExt;
    let (u, v): (f64, f64) = (generator.random(), generator.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}

#[test]
fn over_a_seeded_sweep_the_fold_count_is_right_and_the_free_optimum_is_found() {
    use rand::{RngExt, SeedableRng};
    let mut generator = rand_chacha::ChaCha8Rng::seed_from_u64(2026);
    let (mut tried, mut free) = (0, 0);
    for case in 0..400 {
        let folds = generator.random_range(2..=24_u32);
        let p = 0.1 + 0.2 * generator.random::<f64>();
        // Deep folds where there are few; many deep ones would lie on each other.
        let q = p * (0.02 + 0.38 * generator.random::<f64>()) * (8.0 / f64::from(folds)).min(1.0);
        let s = q * (0.6 * generator.random::<f64>() - 0.2);
        let hem = Hem { p, q, s, folds };
        let n = generator.random_range((8 * folds as usize).max(60)..600);
        let noise = q * [0.0, 0.002, 0.01, 0.03][generator.random_range(0..4)];
        let at = Placement { x0: 0.1 * generator.random::<f64>(), y0: 0.1 * generator.random::<f64>(), phase: generator.random() };
        let points: Vec<Point> = (0..n)
            .map(|i| {
                let t = TAU * (i as f64 + 0.3 * normal(&mut generator).clamp(-1.0, 1.0)) / n as f64;
                let on = hem.point(&at, t);
                Point::new(on.x + noise * normal(&mut generator), on.y + noise * normal(&mut generator))
            })
            .collect();
        if crosses_itself(&hem.outline(&Placement::ORIGIN, 1000)) {
            continue;
        }
        tried += 1;
        let fit =
            fit::fit(&DrapeProfile::new(&points).unwrap(), &Options::default()).unwrap_or_else(|e| panic!("case {case} {hem:?}: {e}"));
        assert_eq!(fit.folds, Some(folds), "case {case} {hem:?} n {n} noise {noise}");
        if fit.termination == fit::Termination::Converged {
            free += 1;
            // Five standard errors, plus the curvature bias of orthogonal fits, of the order of noise²/q.
            let error = fit.q.unwrap().standard_error.expect("determined");
            let allowed = 5.0 * error + 3.0 * noise * noise / q * f64::from(folds) + 1e-9;
            assert!((fit.hem.q - q).abs() < allowed, "case {case} {hem:?}: q {} ± {error}", fit.hem.q);
        }
    }
    println!("{free} of {tried} hems fitted at their free optimum, the others at held length");
    // Folds that all but touch may break a rule by their noise; they are held, and said to be.
    assert!(tried > 350 && free as f64 > 0.99 * f64::from(tried), "{free} of {tried}");
}
