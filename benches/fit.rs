//! One thread's CPU time for a fit, profile by profile: `cargo bench --bench fit -- PROFILES.csv [REPEATS [ROW]]`.
//!
//! PROFILES.csv is what `bench_fits.py --write` writes: profile,x_cm,y_cm. Prints the median over repeats of the mean milliseconds a profile, for a
//! given fold count and for an unknown one, and the summed squared distance (cm²) to compare with other solvers.

use std::hint::black_box;
use std::sync::LazyLock;
use std::time::Instant;

use hemline::experiment::campaign::{Folds, HemLength};
use hemline::experiment::{DrapeProfile, Point};
use hemline::fit::{Options, fit};

const CENTIMETRE: f64 = 0.01;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let Some(file) = arguments.first() else {
        println!("no profiles given: cargo bench --bench fit -- PROFILES.csv");
        return;
    };
    let repeats: usize = arguments.get(1).and_then(|r| r.parse().ok()).unwrap_or(5);
    let only = arguments.get(2).map_or("", String::as_str);
    let text = std::fs::read_to_string(file).expect("the profiles can be read");
    let mut outlines: Vec<Vec<Point>> = Vec::new();
    for line in text.lines().skip(1) {
        let values: Vec<f64> = line.split(',').map(|v| v.parse().expect("a number")).collect();
        let profile = values[0] as usize;
        outlines.resize(outlines.len().max(profile + 1), Vec::new());
        outlines[profile].push(Point::new(values[1] * CENTIMETRE, values[2] * CENTIMETRE));
    }
    let profiles: Vec<DrapeProfile> = outlines.iter().map(|points| DrapeProfile::new(points).expect("a closed outline")).collect();
    // What the peers do: the free optimum of least squares.
    let free = Options { length: HemLength::Free, bias_correction: false, ..Options::default() };
    for (name, options) in [
        ("m given", Options { folds: Folds::Exactly(8), ..free.clone() }),
        ("m unknown, 2 to 24", Options { folds: Folds::default(), ..free.clone() }),
        ("m unknown, 2 to 60", Options { folds: Folds::Among { from: 2, to: 60 }, ..free.clone() }),
        ("m given, bias taken out", Options { folds: Folds::Exactly(8), bias_correction: true, ..free.clone() }),
    ]
    .into_iter()
    .filter(|(name, _)| name.starts_with(only))
    {
        let (mut evaluations, mut square) = (0, 0.0);
        let milliseconds = median(repeats, || {
            (evaluations, square) = (0, 0.0);
            for profile in &profiles {
                let fit = fit(black_box(profile), &options).expect("a fit");
                evaluations += fit.evaluations;
                square += fit.distances.iter().map(|d| d * d).sum::<f64>();
            }
            profiles.len()
        });
        println!(
            "{name:28} {milliseconds:9.4} ms/profile  {:6.2} evaluations  SS {:.8}",
            evaluations as f64 / profiles.len() as f64,
            square / (CENTIMETRE * CENTIMETRE)
        );
    }
    if !"points".starts_with(only) {
        return;
    }
    let milliseconds = median(repeats, || {
        for points in &outlines {
            black_box(DrapeProfile::new(black_box(points)).expect("a closed outline"));
        }
        outlines.len()
    });
    println!("{:28} {milliseconds:9.4} ms/profile", "points put in order");
}

/// This thread's time on a processor where the kernel tells it, so that a busy machine does not count; else the clock's.
fn seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.as_deref().and_then(|text| text.split(' ').next()).and_then(|n| n.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |n| 1e-9 * n)
}

/// Median over `repeats` of the milliseconds for each of what one pass does.
fn median(repeats: usize, mut pass: impl FnMut() -> usize) -> f64 {
    let mut each: Vec<f64> = (0..repeats)
        .map(|_| {
            let (start, mut count) = (seconds(), 0);
            // Long enough for a clock that moves by a scheduler's tick.
            while seconds() - start < 0.1 {
                for _ in 0..10 {
                    count += pass();
                }
            }
            1e3 * (seconds() - start) / count as f64
        })
        .collect();
    each.sort_by(f64::total_cmp);
    each[repeats / 2]
}
