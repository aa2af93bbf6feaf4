//! Twice the working precision: an unevaluated sum of two doubles, about 32 decimal digits.
//!
//! Error-free sum: Knuth, The Art of Computer Programming 2 (1998), 4.2.2. Error-free product and the arithmetic built on both:
//! Dekker, Numer. Math. 18 (1971) 224–242. Relative error of one operation below 2⁻¹⁰², as long as no intermediate exceeds about 1e300.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `high + low`, |low| ≤ ½ ulp(high).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DoubleDouble {
    high: f64,
    low: f64,
}

impl DoubleDouble {
    pub const ZERO: DoubleDouble = DoubleDouble { high: 0.0, low: 0.0 };
    pub const ONE: DoubleDouble = DoubleDouble { high: 1.0, low: 0.0 };

    /// The nearest double.
    pub fn to_f64(self) -> f64 {
        self.high
    }

    pub fn is_finite(self) -> bool {
        self.high.is_finite() && self.low.is_finite()
    }

    pub fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    /// Square root; 0 for anything not positive.
    pub fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::ZERO;
        }
        // One Newton step from the double root doubles the number of right digits.
        let root = self.high.sqrt();
        let defect = self - two_product(root, root);
        quick_two_sum(root, defect.high / (2.0 * root))
    }

    /// Exact product of two doubles.
    pub fn product(a: f64, b: f64) -> Self {
        two_product(a, b)
    }

    /// Times a power of two: exact.
    pub fn scale(self, power_of_two: f64) -> Self {
        DoubleDouble { high: self.high * power_of_two, low: self.low * power_of_two }
    }
}

impl From<f64> for DoubleDouble {
    fn from(value: f64) -> Self {
        DoubleDouble { high: value, low: 0.0 }
    }
}

#[inline]
fn quick_two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    DoubleDouble { high, low: b - (high - a) }
}

#[inline]
fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    let b_part = high - a;
    DoubleDouble { high, low: (a - (high - b_part)) + (b - b_part) }
}

#[inline]
fn split(a: f64) -> (f64, f64) {
    // 2²⁷ + 1 cuts a 53-bit significand into two halves whose products are exact (Veltkamp).
    let shifted = 134_217_729.0 * a;
    let high = shifted - (shifted - a);
    (high, a - high)
}

#[inline]
fn two_product(a: f64, b: f64) -> DoubleDouble {
    let high = a * b;
    let ((a1, a2), (b1, b2)) = (split(a), split(b));
    DoubleDouble { high, low: ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2 }
}

impl Neg for DoubleDouble {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        DoubleDouble { high: -self.high, low: -self.low }
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        // Both parts are added without error first, so cancellation of the high parts keeps its digits.
        let high = two_sum(self.high, other.high);
        let low = two_sum(self.low, other.low);
        let partial = quick_two_sum(high.high, high.low + low.high);
        quick_two_sum(partial.high, partial.low + low.low)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        let product = two_product(self.high, other.high);
        quick_two_sum(product.high, product.low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        // Long division, three double quotients.
        let first = self.high / other.high;
        let rest = self - other * Self::from(first);
        let second = rest.high / other.high;
        let rest = rest - other * Self::from(second);
        quick_two_sum(first, second) + Self::from(rest.high / other.high)
    }
}

impl std::iter::Sum for DoubleDouble {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::ZERO, |sum, term| sum + term)
    }
}

/// Sum of doubles, rounded once.
pub fn sum(values: impl IntoIterator<Item = f64>) -> DoubleDouble {
    values.into_iter().map(DoubleDouble::from).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_digit_is_kept() {
        // 1e16 + 1 − 1e16 is 0 in double arithmetic.
        assert_eq!(sum([1e16, 1.0, -1e16]).to_f64(), 1.0);
    }

    #[test]
    fn division_and_root_invert_product_and_square_to_thirty_digits() {
        let (a, b) = (DoubleDouble::from(0.1) / DoubleDouble::from(3.0), DoubleDouble::from(7.3));
        // A few operations of 2⁻¹⁰² ≈ 2e-31 each.
        assert!((a * b / b - a).abs().to_f64() < 1e-30 * a.to_f64());
        assert!((b.sqrt() * b.sqrt() - b).abs().to_f64() < 1e-29);
    }

    #[test]
    fn the_square_of_a_double_is_exact() {
        // (2²⁷ + 1)² = 2⁵⁴ + 2²⁸ + 1 needs 55 bits.
        let square = DoubleDouble::product(134_217_729.0, 134_217_729.0);
        assert_eq!((square - DoubleDouble::from(2f64.powi(54)) - DoubleDouble::from(2f64.powi(28))).to_f64(), 1.0);
    }
}
