//! Sines and cosines of eight angles at a time, to the last digit or nearly so.

use crate::numerics::lanes::{Lanes, Vector, WIDTH};
use crate::vectorized;

/// π/2 as a double, and what that leaves out: for |n| below 2²⁰ their n-fold is off by less than 1e-26.
const QUARTER: [f64; 2] = [std::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17];
/// Added and taken off again, it leaves the nearest whole number.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// Taylor coefficients of `(sin r − r)/r³` and `(cos r − 1)/r²` by powers of r², from the highest: within |r| ≤ π/4 the next would add 2e-18 at most.
const SINE: [f64; 8] = [
    1.0 / 355_687_428_096_000.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 39_916_800.0,
    1.0 / 362_880.0,
    -1.0 / 5_040.0,
    1.0 / 120.0,
    -1.0 / 6.0,
];
const COSINE: [f64; 8] = [
    1.0 / 20_922_789_888_000.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 479_001_600.0,
    -1.0 / 3_628_800.0,
    1.0 / 40_320.0,
    -1.0 / 720.0,
    1.0 / 24.0,
    -1.0 / 2.0,
];

/// (sin, cos) of angles up to a million radians either way; the error is below one unit in the last place of 1.
#[inline(always)]
pub fn sin_cos<V: Vector>(angle: V) -> (V, V) {
    let turns = (angle * std::f64::consts::FRAC_2_PI + WHOLE) - WHOLE;
    let rest = turns.neg_mul_add(V::all(QUARTER[0]), angle);
    let rest = turns.neg_mul_add(V::all(QUARTER[1]), rest);
    let square = rest * rest;
    let sine = (rest * square).mul_add(series(SINE, square), rest);
    let cosine = square.mul_add(series(COSINE, square), V::all(1.0));
    // Which quarter of the turn: 0, 1, 2 or 3.
    let quarter = turns - (((turns - 1.5) * 0.25 + WHOLE) - WHOLE) * 4.0;
    let half = V::all(0.5);
    let crosswise = ((quarter - 2.0).abs() - 1.0).abs();
    let (sin, cos) = (V::choose(crosswise, half, cosine, sine), V::choose(crosswise, half, sine, cosine));
    (V::choose(V::all(1.5), quarter, -sin, sin), V::choose((quarter - 1.5).abs(), V::all(1.0), -cos, cos))
}

#[inline(always)]
fn series<V: Vector>(coefficients: [f64; 8], square: V) -> V {
    let mut sum = V::all(coefficients[0]);
    for coefficient in &coefficients[1..] {
        sum = sum.mul_add(square, V::all(*coefficient));
    }
    sum
}

vectorized! {
    fn turn_all<V>(angles: &mut [Lanes], cosines: &mut [Lanes]) -> () {
        for (angle, cosine) in angles.iter_mut().zip(cosines) {
            let (sin, cos) = sin_cos(V::of(angle));
            (*angle, *cosine) = (sin.lanes(), cos.lanes());
        }
    }
}

/// (sin, cos) of every angle, as [`sin_cos`].
pub fn sines_and_cosines(angles: impl ExactSizeIterator<Item = f64>) -> Vec<(f64, f64)> {
    let count = angles.len();
    let mut sines = vec![Lanes::ZERO; count.div_ceil(WIDTH)];
    angles.enumerate().for_each(|(i, angle)| sines[i / WIDTH].0[i % WIDTH] = angle);
    let mut cosines = vec![Lanes::ZERO; sines.len()];
    turn_all(&mut sines, &mut cosines);
    (0..count).map(|i| (sines[i / WIDTH].0[i % WIDTH], cosines[i / WIDTH].0[i % WIDTH])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_those_of_the_system_to_the_last_digit() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let near = (-40..40).flat_map(|n| [-1e-9, 0.0, 1e-9, 0.3, 0.785].map(|d| f64::from(n) * quarter + d));
        let far = (0..4000).map(|i| 1e6 * (f64::from(i) * 0.618).sin());
        let angles: Vec<f64> = near.chain(far).chain([-0.0, 1e-300, f64::MIN_POSITIVE]).collect();
        let found = sines_and_cosines(angles.iter().copied());
        assert_eq!(found.len(), angles.len());
        for (angle, (sin, cos)) in angles.iter().zip(found) {
            let (s, c) = angle.sin_cos();
            assert!((sin - s).abs() <= f64::EPSILON && (cos - c).abs() <= f64::EPSILON, "{angle}: {sin} {s}, {cos} {c}");
        }
    }

    #[test]
    fn what_is_no_angle_has_no_sine() {
        for angle in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let [(sin, cos)] = sines_and_cosines([angle].into_iter())[..] else { unreachable!("one for one") };
            assert!(sin.is_nan() && cos.is_nan());
        }
    }
}
