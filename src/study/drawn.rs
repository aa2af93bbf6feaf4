//! Outlines drawn from a known curve: what a fit should find in them is known beforehand.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::experiment::Point;
use crate::model::hem::{Hem, Placement};

/// Where drawn curves lie unless a case says otherwise: off the origin and turned, so that nothing is right by accident.
pub const AT: Placement = Placement { x0: 0.03, y0: -0.02, phase: 0.3 };
/// An ordinary hem of eight folds, m.
pub const HEM: Hem = Hem { p: 0.2, q: 0.03, s: 0.008, folds: 8 };

/// A generator that depends on the seed alone.
pub fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// A number uniform in 0 … 1.
pub fn uniform(generator: &mut ChaCha8Rng) -> f64 {
    generator.random()
}

/// A standard normal number (Box & Muller, Annals of Mathematical Statistics 29 (1958) 610–611).
pub fn normal(generator: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (generator.random(), generator.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}

/// `n` points of a hem at [`AT`], even in t, with noise of standard deviation `noise` (m) in both coordinates.
pub fn noisy(hem: &Hem, n: usize, noise: f64, seed: u64) -> Vec<Point> {
    let mut generator = generator(seed);
    hem.outline(&AT, n)
        .into_iter()
        .map(|p| Point::new(p.x + noise * normal(&mut generator), p.y + noise * normal(&mut generator)))
        .collect()
}

/// The same with this share of the points thrown about by `far` (m, standard deviation in both coordinates).
pub fn with_gross_errors(hem: &Hem, n: usize, noise: f64, share: f64, far: f64, seed: u64) -> Vec<Point> {
    let mut points = noisy(hem, n, noise, seed);
    let mut generator = generator(seed ^ 0x6772_6f73_7300_0000);
    for point in points.iter_mut() {
        if uniform(&mut generator) < share {
            point.x += far * normal(&mut generator);
            point.y += far * normal(&mut generator);
        }
    }
    points
}
