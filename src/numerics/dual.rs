//! Dual numbers: a value with its exact derivatives in N directions at once.
//!
//! Pushed through a model they give its exact Jacobian, through a hand-written gradient N columns of the Hessian; with N = 0 they are plain numbers.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// Value and directional derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<const N: usize> {
    pub value: f64,
    pub slope: [f64; N],
}

impl<const N: usize> Dual<N> {
    pub const ZERO: Self = Dual { value: 0.0, slope: [0.0; N] };

    pub const fn constant(value: f64) -> Self {
        Dual { value, slope: [0.0; N] }
    }

    /// f of this number, from f and f′ at its value.
    #[inline(always)]
    pub fn chain(self, value: f64, first: f64) -> Self {
        let mut slope = self.slope;
        // A loop, since a map over an array is not inlined into a function of wider registers.
        for d in &mut slope {
            *d *= first;
        }
        Dual { value, slope }
    }

    #[inline(always)]
    pub fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }

    #[inline(always)]
    pub fn recip(self) -> Self {
        let inverse = 1.0 / self.value;
        self.chain(inverse, -inverse * inverse)
    }

    #[inline(always)]
    pub fn square(self) -> Self {
        self * self
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl<const N: usize> AddAssign for Dual<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        for i in 0..N {
            self.slope[i] += other.slope[i];
        }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        self.value -= other.value;
        for i in 0..N {
            self.slope[i] -= other.slope[i];
        }
        self
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let mut out = Dual::constant(self.value * other.value);
        for i in 0..N {
            out.slope[i] = self.slope[i] * other.value + self.value * other.slope[i];
        }
        out
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Mul::mul(self, other.recip())
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: f64) -> Self {
        self.value += other;
        self
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, other: f64) -> Self {
        self.value *= other;
        for i in 0..N {
            self.slope[i] *= other;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_agree_with_central_differences() {
        let f = |x: Dual<2>, y: Dual<2>| {
            let (sin, cos) = (x * y).sin_cos();
            (x.square() + y * 3.0 + -0.5).sqrt() * sin / (cos.square() + 2.0) - -y.recip()
        };
        let at = |x: f64, y: f64| f(Dual { value: x, slope: [1.0, 0.0] }, Dual { value: y, slope: [0.0, 1.0] });
        let (x, y, h) = (0.7, 1.3, 1e-5);
        // Truncation h²f‴/6 ~ 1e-10 and rounding eps/h ~ 2e-11.
        assert!((at(x, y).slope[0] - (at(x + h, y).value - at(x - h, y).value) / (2.0 * h)).abs() < 1e-9);
        assert!((at(x, y).slope[1] - (at(x, y + h).value - at(x, y - h).value) / (2.0 * h)).abs() < 1e-9);
    }
}
