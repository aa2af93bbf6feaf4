//! Sines and cosines of eight angles, by arithmetic alone: the same bits everywhere.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

use super::{Lanes, Vector, WIDTH};
use crate::vectorized;

/// π/2 less the number nearest to it.
const REST: f64 = 6.123_233_995_736_766e-17;
/// Added and taken away it leaves the nearest whole number.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// (sin, cos) of angles up to a million radians either way, each within one and a half units of its last place or of 1e-16 where it is near zero.
///
/// The angle less the nearest quarters of a turn, then the series: 15 and 16 powers are beyond rounding up to an eighth of a turn.
#[inline(always)]
pub fn sin_cos<V: Vector>(angle: V) -> (V, V) {
    let quarters = angle.mul_add(V::all(FRAC_2_PI), V::all(ROUNDER)) - ROUNDER;
    let rest = quarters.neg_mul_add(V::all(REST), quarters.neg_mul_add(V::all(FRAC_PI_2), angle));
    let square = rest * rest;
    let mut sin = V::all(-1.0 / 1_307_674_368_000.0);
    for inverse in [6_227_020_800.0, -39_916_800.0, 362_880.0, -5040.0, 120.0, -6.0] {
        sin = square.mul_add(sin, V::all(1.0 / inverse));
    }
    let sin = (square * rest).mul_add(sin, rest);
    let mut cos = V::all(1.0 / 20_922_789_888_000.0);
    for inverse in [-87_178_291_200.0, 479_001_600.0, -3_628_800.0, 40320.0, -720.0, 24.0, -2.0] {
        cos = square.mul_add(cos, V::all(1.0 / inverse));
    }
    let cos = square.mul_add(cos, V::all(1.0));
    // −2 … 2 quarters are left of whole turns.
    let turns = quarters.mul_add(V::all(0.25), V::all(ROUNDER)) - ROUNDER;
    let left = turns.mul_add(V::all(-4.0), quarters);
    let (one, half, more) = (V::all(1.0), V::all(0.5), V::all(1.5));
    let crossed = (left.abs() - 1.0).abs();
    let (s, c) = (V::choose(crossed, half, cos, sin), V::choose(crossed, half, sin, cos));
    let below = V::choose(left, -half, -one, V::choose(more, left, -one, one));
    let behind = V::choose(half, left, -one, V::choose(left, -more, -one, one));
    (s * below, c * behind)
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

/// `(cos kt, sin kt)` from `(cos t, sin t)` by squaring and multiplying, k ≥ 1: no sine of its own. The relative error is about k ε.
#[inline(always)]
pub fn multiple_angle<V: Vector>(k: u32, (cos, sin): (V, V)) -> (V, V) {
    let mut square = (cos, sin);
    let mut left = k;
    while left & 1 == 0 {
        square = doubled(square);
        left >>= 1;
    }
    let mut power = square;
    left >>= 1;
    while left != 0 {
        square = doubled(square);
        if left & 1 == 1 {
            power = turned(power, square);
        }
        left >>= 1;
    }
    power
}

/// (cos, sin) of the sum of two angles.
#[inline(always)]
pub fn turned<V: Vector>((a, b): (V, V), (c, d): (V, V)) -> (V, V) {
    (a.mul_sub(c, b * d), a.mul_add(d, b * c))
}

/// (cos, sin) of an angle up to a tenth, to rounding: the series, no sine of its own.
#[inline(always)]
pub fn small_angle<V: Vector>(angle: V) -> (V, V) {
    let square = angle * angle;
    let cos = square.mul_add(V::all(1.0 / 40320.0), V::all(-1.0 / 720.0));
    let cos = square.mul_add(square.mul_add(square.mul_add(cos, V::all(1.0 / 24.0)), V::all(-0.5)), V::all(1.0));
    let sin = square.mul_add(V::all(1.0 / 362_880.0), V::all(-1.0 / 5040.0));
    let sin = square.mul_add(square.mul_add(sin, V::all(1.0 / 120.0)), V::all(-1.0 / 6.0));
    (cos, (square * angle).mul_add(sin, angle))
}

#[inline(always)]
fn doubled<V: Vector>((cos, sin): (V, V)) -> (V, V) {
    (cos.mul_sub(cos, sin * sin), (cos + cos) * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_agree_with_the_system_s() {
        for i in -40_000..=40_000 {
            let angle = 1e-3 * f64::from(i) + if i % 7 == 0 { 6000.0 } else { 0.0 };
            let (sin, cos) = sin_cos(Lanes([angle; WIDTH]));
            for (found, exact) in [(sin.0[0], angle.sin()), (cos.0[0], angle.cos())] {
                // One and a half units of the last place, and half of one for the system's.
                assert!((found - exact).abs() <= 2.2e-16 * exact.abs() + 1e-16, "{angle}: {found} {exact}");
            }
        }
        let quarters = Lanes([0.0, 1.0, 2.0, 3.0, 4.0, -1.0, -2.0, -3.0].map(|q| q * FRAC_PI_2));
        let (sin, cos) = sin_cos(quarters);
        for lane in 0..WIDTH {
            let (s, c) = quarters.0[lane].sin_cos();
            assert!((sin.0[lane] - s).abs() < 1e-30 + 2.2e-16 * s.abs() && (cos.0[lane] - c).abs() < 1e-30 + 2.2e-16 * c.abs());
        }
        assert!(sin_cos(Lanes([f64::NAN; WIDTH])).0.0[0].is_nan() && sin_cos(Lanes([f64::INFINITY; WIDTH])).1.0[0].is_nan());
    }

    #[test]
    fn sines_of_a_list_are_those_of_the_system_to_the_last_digit() {
        let quarter = FRAC_PI_2;
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

    #[test]
    fn multiple_angles_agree_with_sines_of_their_own() {
        for k in 1..=180 {
            let angles: [f64; WIDTH] = std::array::from_fn(|i| 0.7 * i as f64 - 2.0);
            let (cos, sin) = multiple_angle(k, (Lanes(angles.map(f64::cos)), Lanes(angles.map(f64::sin))));
            for (lane, angle) in angles.iter().enumerate() {
                let (s, c) = (f64::from(k) * angle).sin_cos();
                // Rounding of cos and sin, multiplied by k.
                assert!((cos.0[lane] - c).abs() + (sin.0[lane] - s).abs() < 1e-15 * f64::from(k) + 1e-15, "{k} {angle}");
            }
        }
    }

    #[test]
    fn small_angles_agree_with_sines_of_their_own() {
        for i in -100..=100 {
            let angle = 1e-3 * f64::from(i);
            let (cos, sin) = small_angle(Lanes([angle; WIDTH]));
            // Half a unit in the last place, twice.
            assert!((cos.0[0] - angle.cos()).abs() < 2.3e-16 && (sin.0[0] - angle.sin()).abs() <= 2.3e-16 * angle.abs(), "{angle}");
        }
    }
}
