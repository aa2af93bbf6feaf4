//! Eight numbers in the registers of x86-64.
//!
//! The operations are called where [`vectorized!`](crate::vectorized) has made sure that the machine has them, and are inlined there.

use std::arch::x86_64::{
    __m256d, __m512d, _CMP_LT_OQ, _mm_add_pd, _mm_add_sd, _mm_cvtsd_f64, _mm_unpackhi_pd, _mm256_add_pd, _mm256_andnot_pd,
    _mm256_blendv_pd, _mm256_castpd256_pd128, _mm256_cmp_pd, _mm256_div_pd, _mm256_extractf128_pd, _mm256_fmadd_pd, _mm256_fmsub_pd,
    _mm256_fnmadd_pd, _mm256_loadu_pd, _mm256_max_pd, _mm256_min_pd, _mm256_mul_pd, _mm256_permute2f128_pd, _mm256_set1_pd,
    _mm256_shuffle_pd, _mm256_sqrt_pd, _mm256_storeu_pd, _mm256_sub_pd, _mm256_xor_pd, _mm512_abs_pd, _mm512_add_pd, _mm512_alignr_epi64,
    _mm512_castpd_si512, _mm512_castpd512_pd256, _mm512_castsi512_pd, _mm512_cmp_pd_mask, _mm512_div_pd, _mm512_extractf64x4_pd,
    _mm512_fmadd_pd, _mm512_fmsub_pd, _mm512_fnmadd_pd, _mm512_loadu_pd, _mm512_mask_blend_pd, _mm512_max_pd, _mm512_min_pd, _mm512_mul_pd,
    _mm512_set1_pd, _mm512_sqrt_pd, _mm512_storeu_pd, _mm512_sub_pd, _mm512_xor_pd,
};
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Lanes, Vector, WIDTH};

/// One register of AVX-512.
#[derive(Debug, Clone, Copy)]
pub struct Single512(__m512d);

/// Two registers of AVX2.
#[derive(Debug, Clone, Copy)]
pub struct Pair256(__m256d, __m256d);

// SAFETY of every block below: values of these types exist in functions only that `vectorized!` runs on machines with the instructions.

macro_rules! arithmetic {
    ($($operation:ident, $function:ident, $single:ident, $half:ident;)*) => {$(
        impl $operation for Single512 {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Single512(unsafe { $single(self.0, other.0) })
            }
        }
        impl $operation for Pair256 {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                unsafe { Pair256($half(self.0, other.0), $half(self.1, other.1)) }
            }
        }
        with_number!($operation, $function, Single512);
        with_number!($operation, $function, Pair256);
    )*};
}

macro_rules! with_number {
    ($operation:ident, $function:ident, $vector:ident) => {
        impl $operation<f64> for $vector {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: f64) -> Self {
                self.$function(Self::all(other))
            }
        }
    };
}

arithmetic! {
    Add, add, _mm512_add_pd, _mm256_add_pd;
    Sub, sub, _mm512_sub_pd, _mm256_sub_pd;
    Mul, mul, _mm512_mul_pd, _mm256_mul_pd;
    Div, div, _mm512_div_pd, _mm256_div_pd;
}

impl Neg for Single512 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Single512(unsafe { _mm512_xor_pd(self.0, _mm512_set1_pd(-0.0)) })
    }
}

impl Neg for Pair256 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            Pair256(_mm256_xor_pd(self.0, sign), _mm256_xor_pd(self.1, sign))
        }
    }
}

impl Vector for Single512 {
    #[inline(always)]
    fn all(value: f64) -> Self {
        Single512(unsafe { _mm512_set1_pd(value) })
    }

    #[inline(always)]
    fn of(lanes: &Lanes) -> Self {
        Single512(unsafe { _mm512_loadu_pd(lanes.0.as_ptr()) })
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        let mut lanes = Lanes([0.0; WIDTH]);
        unsafe { _mm512_storeu_pd(lanes.0.as_mut_ptr(), self.0) };
        lanes
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Single512(unsafe { _mm512_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Single512(unsafe { _mm512_abs_pd(self.0) })
    }

    #[inline(always)]
    fn choose(low: Self, high: Self, yes: Self, no: Self) -> Self {
        Single512(unsafe { _mm512_mask_blend_pd(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(low.0, high.0), no.0, yes.0) })
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, plus: Self) -> Self {
        Single512(unsafe { _mm512_fmadd_pd(self.0, factor.0, plus.0) })
    }

    #[inline(always)]
    fn mul_sub(self, factor: Self, minus: Self) -> Self {
        Single512(unsafe { _mm512_fmsub_pd(self.0, factor.0, minus.0) })
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: Self, plus: Self) -> Self {
        Single512(unsafe { _mm512_fnmadd_pd(self.0, factor.0, plus.0) })
    }

    #[inline(always)]
    fn followed(self, next: Self) -> Self {
        Single512(unsafe { _mm512_castsi512_pd(_mm512_alignr_epi64::<1>(_mm512_castpd_si512(next.0), _mm512_castpd_si512(self.0))) })
    }

    #[inline(always)]
    fn preceded(self, before: Self) -> Self {
        Single512(unsafe { _mm512_castsi512_pd(_mm512_alignr_epi64::<7>(_mm512_castpd_si512(self.0), _mm512_castpd_si512(before.0))) })
    }

    // The instructions take the second where neither is greater or less, as the definitions do.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Single512(unsafe { _mm512_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn within(self, limit: f64) -> Self {
        Single512(unsafe { _mm512_max_pd(_mm512_set1_pd(-limit), _mm512_min_pd(_mm512_set1_pd(limit), self.0)) })
    }

    #[inline(always)]
    fn sum(self) -> f64 {
        unsafe { sum_of_four(_mm256_add_pd(_mm512_castpd512_pd256(self.0), _mm512_extractf64x4_pd::<1>(self.0))) }
    }
}

impl Vector for Pair256 {
    #[inline(always)]
    fn all(value: f64) -> Self {
        unsafe { Pair256(_mm256_set1_pd(value), _mm256_set1_pd(value)) }
    }

    #[inline(always)]
    fn of(lanes: &Lanes) -> Self {
        unsafe { Pair256(_mm256_loadu_pd(lanes.0.as_ptr()), _mm256_loadu_pd(lanes.0[4..].as_ptr())) }
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        let mut lanes = Lanes([0.0; WIDTH]);
        let (low, high) = lanes.0.split_at_mut(WIDTH / 2);
        unsafe {
            _mm256_storeu_pd(low.as_mut_ptr(), self.0);
            _mm256_storeu_pd(high.as_mut_ptr(), self.1);
        }
        lanes
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        unsafe { Pair256(_mm256_sqrt_pd(self.0), _mm256_sqrt_pd(self.1)) }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            Pair256(_mm256_andnot_pd(sign, self.0), _mm256_andnot_pd(sign, self.1))
        }
    }

    #[inline(always)]
    fn choose(low: Self, high: Self, yes: Self, no: Self) -> Self {
        unsafe {
            let below = _mm256_cmp_pd::<_CMP_LT_OQ>(low.0, high.0);
            let above = _mm256_cmp_pd::<_CMP_LT_OQ>(low.1, high.1);
            Pair256(_mm256_blendv_pd(no.0, yes.0, below), _mm256_blendv_pd(no.1, yes.1, above))
        }
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, plus: Self) -> Self {
        unsafe { Pair256(_mm256_fmadd_pd(self.0, factor.0, plus.0), _mm256_fmadd_pd(self.1, factor.1, plus.1)) }
    }

    #[inline(always)]
    fn mul_sub(self, factor: Self, minus: Self) -> Self {
        unsafe { Pair256(_mm256_fmsub_pd(self.0, factor.0, minus.0), _mm256_fmsub_pd(self.1, factor.1, minus.1)) }
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: Self, plus: Self) -> Self {
        unsafe { Pair256(_mm256_fnmadd_pd(self.0, factor.0, plus.0), _mm256_fnmadd_pd(self.1, factor.1, plus.1)) }
    }

    #[inline(always)]
    fn followed(self, next: Self) -> Self {
        unsafe {
            let (low, high) = (_mm256_permute2f128_pd::<0x21>(self.0, self.1), _mm256_permute2f128_pd::<0x21>(self.1, next.0));
            Pair256(_mm256_shuffle_pd::<0b0101>(self.0, low), _mm256_shuffle_pd::<0b0101>(self.1, high))
        }
    }

    #[inline(always)]
    fn preceded(self, before: Self) -> Self {
        unsafe {
            let (low, high) = (_mm256_permute2f128_pd::<0x21>(before.1, self.0), _mm256_permute2f128_pd::<0x21>(self.0, self.1));
            Pair256(_mm256_shuffle_pd::<0b0101>(low, self.0), _mm256_shuffle_pd::<0b0101>(high, self.1))
        }
    }

    // The instructions take the second where neither is greater or less, as the definitions do.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        unsafe { Pair256(_mm256_max_pd(self.0, other.0), _mm256_max_pd(self.1, other.1)) }
    }

    #[inline(always)]
    fn within(self, limit: f64) -> Self {
        unsafe {
            let (least, greatest) = (_mm256_set1_pd(-limit), _mm256_set1_pd(limit));
            Pair256(_mm256_max_pd(least, _mm256_min_pd(greatest, self.0)), _mm256_max_pd(least, _mm256_min_pd(greatest, self.1)))
        }
    }

    #[inline(always)]
    fn sum(self) -> f64 {
        unsafe { sum_of_four(_mm256_add_pd(self.0, self.1)) }
    }
}

/// (a + c) + (b + d).
#[inline(always)]
unsafe fn sum_of_four(four: __m256d) -> f64 {
    unsafe {
        let two = _mm_add_pd(_mm256_castpd256_pd128(four), _mm256_extractf128_pd::<1>(four));
        _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)))
    }
}
