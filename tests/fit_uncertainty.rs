//! Bias, standard errors and intervals of the fit, against what seeded outlines of known p, q, s do.
//!
//! The tables are printed with `cargo test --release --test fit_uncertainty -- --nocapture`; `HEMLINE_REPLICATES=1000` makes the coverage of the
//! bootstraps as fine as docs/uncertainty.md has it (some minutes).

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use hemline::experiment::campaign::Folds;
use hemline::experiment::{DrapeProfile, Point};
use hemline::fit::{self, HemFit, Options};
use hemline::model::hem::{Hem, Placement};
use hemline::study::intervals;
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

/// What replicates of one estimate did: bias over standard deviation, claimed over true standard deviation, coverage of the 95 % interval.
#[derive(Debug, Clone, Copy)]
struct Record {
    bias: f64,
    error: f64,
    coverage: f64,
}

fn record(truth: f64, rows: &[(f64, f64, bool)]) -> Record {
    let n = rows.len() as f64;
    let mean = rows.iter().map(|r| r.0).sum::<f64>() / n;
    let deviation = (rows.iter().map(|r| (r.0 - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    Record {
        bias: (mean - truth) / deviation,
        error: rows.iter().map(|r| r.1).sum::<f64>() / n / deviation,
        coverage: rows.iter().filter(|r| r.2).count() as f64 / n,
    }
}

/// Records of p, q, s over seeded outlines, without and with the correction, and how many were corrected.
fn records(hem: &Hem, n: usize, sigma: f64, replicates: u64) -> ([[Record; 3]; 2], usize) {
    let fits: Vec<[HemFit; 2]> = (0..replicates)
        .into_par_iter()
        .map(|k| {
            let profile = outline(hem, n, sigma, 11, k);
            [false, true].map(|correction| fitted(&profile, hem.folds, correction))
        })
        .collect();
    let corrected = fits.iter().filter(|pair| pair[1].bias_correction.applied().is_some()).count();
    let truths = [hem.p, hem.q, hem.s];
    let of = |which: usize| -> [Record; 3] {
        std::array::from_fn(|j| {
            let rows: Vec<(f64, f64, bool)> = fits
                .iter()
                .map(|pair| {
                    let fit = &pair[which];
                    let interval = intervals::intervals(&outline(hem, 12.max(n.min(12)), 0.0, 0, 0), fit, &intervals::Options::default());
                    let found = [interval.p, interval.q, interval.s][j].expect("an interval");
                    let estimate = [Some(fit.p), fit.q, fit.s][j].expect("folds");
                    (estimate.value, estimate.standard_error.expect("an error"), found.covers(truths[j]))
                })
                .collect();
            record(truths[j], &rows)
        })
    };
    ([of(0), of(1)], corrected)
}

#[test]
fn explore() {
    for (hem, n, sigmas) in [
        (centimetres(20.0, 3.0, 1.5, 8), 360, vec![0.05, 0.1, 0.2, 0.4]),
        (centimetres(20.0, 0.5, 0.1, 8), 360, vec![0.05, 0.1, 0.2]),
        (centimetres(20.0, 4.0, 1.5, 5), 360, vec![0.1, 0.2]),
        (centimetres(20.0, 2.0, 0.5, 14), 360, vec![0.1, 0.2]),
        (centimetres(20.0, 3.0, 1.5, 8), 90, vec![0.05, 0.1, 0.2]),
    ] {
        for sigma in sigmas {
            let start = std::time::Instant::now();
            let ([without, with], corrected) = records(&hem, n, sigma * CENTIMETRE, 1000);
            println!("{hem:?} n {n} sigma {sigma} corrected {corrected} {:.2}s", start.elapsed().as_secs_f64());
            for (name, record) in [("off", without), ("on", with)] {
                let show = |r: Record| format!("{:+.3} {:.3} {:.3}", r.bias, r.error, r.coverage);
                println!("   {name:4} p {}   q {}   s {}", show(record[0]), show(record[1]), show(record[2]));
            }
        }
    }
}
