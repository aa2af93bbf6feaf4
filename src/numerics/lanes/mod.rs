//! Eight numbers at a time: the same bits whichever vector instructions a machine has.
//!
//! Every operation is the plain IEEE one on each lane, products are fused with sums only where the kernel says so ([`Vector::mul_add`]), and sums are
//! taken in one fixed order. [`Lanes`] is how eight numbers lie in memory; a kernel is written once over [`Vector`] and compiled for each kind of
//! register ([`vectorized!`](crate::vectorized)).

pub mod angles;
pub mod jets;
pub mod product;
#[cfg(target_arch = "x86_64")]
pub mod registers;

use std::ops::{Add, Div, Mul, Neg, Sub};

pub use angles::{multiple_angle, sin_cos, sines_and_cosines, small_angle, turned};

/// Numbers in one [`Lanes`]: one 512-bit register, or two of 256 bit.
pub const WIDTH: usize = 8;

/// Eight numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; WIDTH]);

/// The numbers of several in a row.
pub fn numbers(lanes: &[Lanes]) -> &[f64] {
    // SAFETY: `Lanes` is eight numbers and nothing else: its size is its alignment.
    unsafe { std::slice::from_raw_parts(lanes.as_ptr().cast(), lanes.len() * WIDTH) }
}

/// Eight numbers under arithmetic, in whatever registers hold them.
pub trait Vector:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// The same number in every lane.
    fn all(value: f64) -> Self;

    /// From memory.
    fn of(lanes: &Lanes) -> Self;

    /// To memory.
    fn lanes(self) -> Lanes;

    fn sqrt(self) -> Self;

    fn abs(self) -> Self;

    /// Lane by lane `yes` where `low` is less than `high`, else `no`.
    fn choose(low: Self, high: Self, yes: Self, no: Self) -> Self;

    /// `self · factor + plus`, rounded once.
    ///
    /// A machine without such an instruction computes it by a function of the system's: slowly, but to the same bits.
    fn mul_add(self, factor: Self, plus: Self) -> Self;

    /// `self · factor − minus`, rounded once.
    #[inline(always)]
    fn mul_sub(self, factor: Self, minus: Self) -> Self {
        self.mul_add(factor, -minus)
    }

    /// `plus − self · factor`, rounded once.
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, plus: Self) -> Self {
        (-self).mul_add(factor, plus)
    }

    /// Each lane's follower: all lanes but the first, then the first of `next`.
    #[inline(always)]
    fn followed(self, next: Self) -> Self {
        let (Lanes([_, b, c, d, e, f, g, h]), Lanes([first, ..])) = (self.lanes(), next.lanes());
        Self::of(&Lanes([b, c, d, e, f, g, h, first]))
    }

    /// Each lane's forerunner: the last of `before`, then all lanes but the last.
    #[inline(always)]
    fn preceded(self, before: Self) -> Self {
        let (Lanes([a, b, c, d, e, f, g, _]), Lanes([.., last])) = (self.lanes(), before.lanes());
        Self::of(&Lanes([last, a, b, c, d, e, f, g]))
    }

    /// The first eight of `values`.
    #[inline(always)]
    fn read(values: &[f64]) -> Self {
        let mut lanes = Lanes::ZERO;
        lanes.0.copy_from_slice(&values[..WIDTH]);
        Self::of(&lanes)
    }

    /// Zero in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::all(0.0)
    }

    /// Lane by lane `self` where it is greater than `bound`, else `other`.
    #[inline(always)]
    fn where_above(self, bound: Self, other: Self) -> Self {
        Self::choose(bound, self, self, other)
    }

    /// The greater of each pair.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.where_above(other, other)
    }

    /// Each lane held within ± `limit`; NaN stays NaN.
    #[inline(always)]
    fn within(self, limit: f64) -> Self {
        let (greatest, least) = (Self::all(limit), Self::all(-limit));
        let below = Self::choose(greatest, self, greatest, self);
        Self::choose(below, least, least, below)
    }

    /// Sum of all lanes, always in the same order.
    #[inline(always)]
    fn sum(self) -> f64 {
        let Lanes([a, b, c, d, e, f, g, h]) = self.lanes();
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }

    /// The greatest lane.
    #[inline(always)]
    fn greatest(self) -> f64 {
        self.lanes().0.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Lanes {
    pub const ZERO: Lanes = Lanes([0.0; WIDTH]);

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Lanes {
        let mut result = self.0;
        for value in &mut result {
            *value = f(*value);
        }
        Lanes(result)
    }
}

impl Vector for Lanes {
    #[inline(always)]
    fn all(value: f64) -> Lanes {
        Lanes([value; WIDTH])
    }

    #[inline(always)]
    fn of(lanes: &Lanes) -> Lanes {
        *lanes
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        self
    }

    #[inline(always)]
    fn sqrt(self) -> Lanes {
        self.map(f64::sqrt)
    }

    #[inline(always)]
    fn abs(self) -> Lanes {
        self.map(f64::abs)
    }

    #[inline(always)]
    fn choose(low: Lanes, high: Lanes, yes: Lanes, no: Lanes) -> Lanes {
        Lanes(std::array::from_fn(|lane| if low.0[lane] < high.0[lane] { yes.0[lane] } else { no.0[lane] }))
    }

    #[inline(always)]
    fn mul_add(self, factor: Lanes, plus: Lanes) -> Lanes {
        Lanes(std::array::from_fn(|lane| self.0[lane].mul_add(factor.0[lane], plus.0[lane])))
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

/// Runs `$body` in the widest registers that this machine has.
///
/// `vectorized! { fn name<V>(argument: Type, …) -> Type { body } }`; V is the [`Vector`](crate::numerics::lanes::Vector) of the registers. The body is
/// compiled three times, and gives the same bits each time, because nothing is fused or reordered that is not so written.
#[macro_export]
macro_rules! vectorized {
    ($(#[$meta:meta])* $visibility:vis fn $name:ident<$vector:ident>($($argument:ident: $kind:ty),* $(,)?) -> $result:ty $body:block) => {
        $(#[$meta])*
        $visibility fn $name($($argument: $kind),*) -> $result {
            #[inline(always)]
            #[allow(clippy::extra_unused_type_parameters)] // A body may leave it to the compiler to fill the registers.
            fn on<$vector: $crate::numerics::lanes::Vector>($($argument: $kind),*) -> $result $body

            #[cfg(target_arch = "x86_64")]
            {
                use $crate::numerics::lanes::registers::{Pair256, Single512};
                #[target_feature(enable = "avx512f,avx512dq,avx512vl")]
                fn widest($($argument: $kind),*) -> $result {
                    on::<Single512>($($argument),*)
                }
                #[target_feature(enable = "avx2,fma")]
                fn wide($($argument: $kind),*) -> $result {
                    on::<Pair256>($($argument),*)
                }
                if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") && is_x86_feature_detected!("avx512vl") {
                    // SAFETY: the machine has just been asked for these instructions.
                    return unsafe { widest($($argument),*) };
                }
                if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                    // SAFETY: the machine has just been asked for these instructions.
                    return unsafe { wide($($argument),*) };
                }
            }
            on::<$crate::numerics::lanes::Lanes>($($argument),*)
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation of [`Vector`], some of them often enough for a rounding to show.
    #[inline(always)]
    fn every_operation<V: Vector>(x: V) -> V {
        let mut sum = V::zero();
        for i in 0..100 {
            let y = (x * f64::from(i) + 0.1).sqrt() / (x.abs() + V::all(0.3)) - 1.0;
            let (cos, sin) = multiple_angle(7, (y.within(0.8), -y));
            sum = sum + cos.where_above(V::all(0.1), sin).max(y - x);
            sum = y.mul_add(x, sum) + x.mul_sub(x, y) - y.neg_mul_add(y, x);
            sum = sum.followed(y) * 0.5 + x.preceded(sum) * 0.25;
        }
        sum + sum.sum() + V::read(&sum.lanes().0).greatest()
    }

    const TRIED: [Lanes; 3] = [
        Lanes([0.1, 0.2, 0.3, 0.7, 1.9, 2.3, 5.5, 7.1]),
        Lanes([-0.0, 0.0, -1.0, 3.0, 1e-300, -1e-300, 1e100, 2.0]),
        Lanes([-0.0, 0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 1e-300]),
    ];

    /// A NaN is a NaN whatever its sign.
    fn bits(v: Lanes) -> [u64; WIDTH] {
        v.0.map(|v| if v.is_nan() { f64::NAN.to_bits() } else { v.to_bits() })
    }

    #[test]
    fn wide_instructions_give_the_same_bits_as_plain_ones() {
        vectorized! {
            fn wide<V>(x: &Lanes) -> Lanes {
                every_operation(V::of(x)).lanes()
            }
        }
        for x in TRIED {
            let (plain, wide) = (every_operation(x), wide(&x));
            assert_eq!(bits(plain), bits(wide), "{plain:?} {wide:?}");
        }
    }

    /// On a machine with wider ones too.
    #[cfg(target_arch = "x86_64")]
    #[test]
    fn pairs_of_registers_give_the_same_bits_as_plain_numbers() {
        #[target_feature(enable = "avx2,fma")]
        fn pairs(x: &Lanes) -> Lanes {
            every_operation(registers::Pair256::of(x)).lanes()
        }
        if !(is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")) {
            println!("not tried: this machine has no AVX2 with fused products");
            return;
        }
        for x in TRIED {
            // SAFETY: the machine has just been asked for these instructions.
            let (plain, pairs) = (every_operation(x), unsafe { pairs(&x) });
            assert_eq!(bits(plain), bits(pairs), "{plain:?} {pairs:?}");
        }
    }

    #[test]
    fn operations_lane_by_lane_are_those_of_single_numbers() {
        vectorized! {
            fn each<V>(x: &Lanes, y: &Lanes, z: &Lanes) -> [Lanes; 8] {
                let (x, y, z) = (V::of(x), V::of(y), V::of(z));
                [
                    x.mul_add(y, z).lanes(),
                    x.mul_sub(y, z).lanes(),
                    x.neg_mul_add(y, z).lanes(),
                    x.followed(y).lanes(),
                    x.preceded(y).lanes(),
                    x.max(y).lanes(),
                    x.within(0.5).lanes(),
                    V::all(x.sum()).lanes(),
                ]
            }
        }
        let third = 1.0 / 3.0;
        // Products that cancel but for what one rounding keeps of them; zeros and NaN for the order of comparisons.
        let x = Lanes([third, 0.1, -0.3, 7.0, 0.0, -0.0, f64::NAN, 1.0]);
        let y = Lanes([3.0, 10.0, 1.0, third, -0.0, 0.0, 1.0, f64::NAN]);
        let z = Lanes([-1.0, 1.0, 0.3, -7.0, 0.0, 0.0, 1.0, 1.0]);
        let [sum, difference, rest, followed, preceded, greater, held, total] = each(&x, &y, &z);
        let single = |f: &dyn Fn(f64, f64, f64) -> f64| Lanes(std::array::from_fn(|lane| f(x.0[lane], y.0[lane], z.0[lane])));
        assert_eq!(bits(sum), bits(single(&|x, y, z| x.mul_add(y, z))));
        assert_eq!(bits(difference), bits(single(&|x, y, z| x.mul_add(y, -z))));
        assert_eq!(bits(rest), bits(single(&|x, y, z| (-x).mul_add(y, z))));
        assert_eq!(bits(followed), bits(Lanes(std::array::from_fn(|lane| if lane < 7 { x.0[lane + 1] } else { y.0[0] }))));
        assert_eq!(bits(preceded), bits(Lanes(std::array::from_fn(|lane| if 0 < lane { x.0[lane - 1] } else { y.0[7] }))));
        assert_eq!(bits(greater), bits(single(&|x, y, _| if y < x { x } else { y })));
        assert_eq!(bits(held), bits(single(&|x, _, _| x.clamp(-0.5, 0.5))));
        assert!(total.0[0].is_nan());
    }
}
