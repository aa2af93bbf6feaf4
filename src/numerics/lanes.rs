//! Eight numbers at a time: arithmetic that a compiler turns into vector instructions.
//!
//! Every operation is the plain IEEE one on each lane, and sums are taken in one fixed order, so that results do not depend on which vector
//! instructions a machine has.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers in one [`Lanes`]: one 512-bit register, or two of 256 bit.
pub const WIDTH: usize = 8;

/// Eight numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; WIDTH]);

impl Lanes {
    pub const ZERO: Lanes = Lanes([0.0; WIDTH]);

    /// The same number in every lane.
    #[inline(always)]
    pub fn all(value: f64) -> Lanes {
        Lanes([value; WIDTH])
    }

    #[inline(always)]
    pub fn sqrt(self) -> Lanes {
        self.map(f64::sqrt)
    }

    #[inline(always)]
    pub fn abs(self) -> Lanes {
        self.map(f64::abs)
    }

    /// Each lane held within ± `limit`; NaN stays NaN.
    #[inline(always)]
    pub fn within(self, limit: f64) -> Lanes {
        self.map(|x| {
            let below = if limit < x { limit } else { x };
            if below < -limit { -limit } else { below }
        })
    }

    /// Lane by lane `self` where it is greater than `bound`, else `other`.
    #[inline(always)]
    pub fn where_above(self, bound: Lanes, other: Lanes) -> Lanes {
        let mut result = other.0;
        for (result, (own, bound)) in result.iter_mut().zip(self.0.iter().zip(&bound.0)) {
            if bound < own {
                *result = *own;
            }
        }
        Lanes(result)
    }

    /// The greater of each pair.
    #[inline(always)]
    pub fn max(self, other: Lanes) -> Lanes {
        self.where_above(other, other)
    }

    /// Sum of all lanes, always in the same order.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }

    /// The greatest lane.
    pub fn greatest(self) -> f64 {
        self.0.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Lanes {
        let mut result = self.0;
        for value in &mut result {
            *value = f(*value);
        }
        Lanes(result)
    }
}

macro_rules! lane_by_lane {
    ($operation:ident, $function:ident, $sign:tt) => {
        impl $operation for Lanes {
            type Output = Lanes;
            #[inline(always)]
            #[allow(clippy::assign_op_pattern)] // The sign is a token of its own.
            fn $function(self, other: Lanes) -> Lanes {
                let mut result = self.0;
                for (own, other) in result.iter_mut().zip(&other.0) {
                    *own = *own $sign other;
                }
                Lanes(result)
            }
        }
        impl $operation<f64> for Lanes {
            type Output = Lanes;
            #[inline(always)]
            fn $function(self, other: f64) -> Lanes {
                self.map(|x| x $sign other)
            }
        }
        impl $operation<Lanes> for f64 {
            type Output = Lanes;
            #[inline(always)]
            fn $function(self, other: Lanes) -> Lanes {
                other.map(|x| self $sign x)
            }
        }
    };
}

lane_by_lane!(Add, add, +);
lane_by_lane!(Sub, sub, -);
lane_by_lane!(Mul, mul, *);
lane_by_lane!(Div, div, /);

impl Neg for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn neg(self) -> Lanes {
        self.map(|x| -x)
    }
}

/// `(cos kt, sin kt)` from `(cos t, sin t)` by squaring and multiplying, k ≥ 1: no sine of its own. The relative error is about k ε.
#[inline(always)]
pub fn multiple_angle(k: u32, (cos, sin): (Lanes, Lanes)) -> (Lanes, Lanes) {
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
pub fn turned((a, b): (Lanes, Lanes), (c, d): (Lanes, Lanes)) -> (Lanes, Lanes) {
    (a * c - b * d, a * d + b * c)
}

#[inline(always)]
fn doubled((cos, sin): (Lanes, Lanes)) -> (Lanes, Lanes) {
    (cos * cos - sin * sin, 2.0 * (cos * sin))
}

/// Runs `$body` compiled for the widest vector instructions that this machine has.
///
/// `vectorized! { fn name(argument: Type, …) -> Type { body } }`; the body is compiled three times, and gives the same bits each time, because no
/// operation is fused or reordered.
#[macro_export]
macro_rules! vectorized {
    ($(#[$meta:meta])* $visibility:vis fn $name:ident($($argument:ident: $kind:ty),* $(,)?) -> $result:ty $body:block) => {
        $(#[$meta])*
        $visibility fn $name($($argument: $kind),*) -> $result {
            #[inline(always)]
            fn plain($($argument: $kind),*) -> $result $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx512f,avx512dq,avx512vl")]
                fn widest($($argument: $kind),*) -> $result {
                    plain($($argument),*)
                }
                #[target_feature(enable = "avx2")]
                fn wide($($argument: $kind),*) -> $result {
                    plain($($argument),*)
                }
                if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") && is_x86_feature_detected!("avx512vl") {
                    // SAFETY: the machine has just been asked for these instructions.
                    return unsafe { widest($($argument),*) };
                }
                if is_x86_feature_detected!("avx2") {
                    // SAFETY: the machine has just been asked for these instructions.
                    return unsafe { wide($($argument),*) };
                }
            }
            plain($($argument),*)
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn wide_instructions_give_the_same_bits_as_plain_ones() {
        fn plain(x: Lanes) -> f64 {
            let mut sum = Lanes::ZERO;
            for i in 0..100 {
                sum = sum + (x * f64::from(i) + 0.1).sqrt() / (x + 0.3);
            }
            sum.sum()
        }
        vectorized! {
            fn wide(x: Lanes) -> f64 {
                let mut sum = Lanes::ZERO;
                for i in 0..100 {
                    sum = sum + (x * f64::from(i) + 0.1).sqrt() / (x + 0.3);
                }
                sum.sum()
            }
        }
        let x = Lanes([0.1, 0.2, 0.3, 0.7, 1.9, 2.3, 5.5, 7.1]);
        assert_eq!(plain(x).to_bits(), wide(x).to_bits());
    }
}
