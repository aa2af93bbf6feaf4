//! Second-order jets: a number with its exact gradient and Hessian in N variables, carried through arithmetic.
//!
//! Forward differentiation by Taylor arithmetic. For few variables it costs about N² times the plain evaluation and cannot disagree with it.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Value, gradient and (symmetric) Hessian of a function of N variables at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet<const N: usize> {
    pub value: f64,
    pub gradient: [f64; N],
    pub hessian: [[f64; N]; N],
}

impl<const N: usize> Jet<N> {
    /// A number that does not depend on the variables.
    pub const fn constant(value: f64) -> Self {
        Jet { value, gradient: [0.0; N], hessian: [[0.0; N]; N] }
    }

    /// The variable number `index`, at `value`.
    pub fn variable(value: f64, index: usize) -> Self {
        let mut jet = Jet::constant(value);
        jet.gradient[index] = 1.0;
        jet
    }

    /// f of this jet, from f, f′ and f″ at its value.
    pub fn chain(self, value: f64, first: f64, second: f64) -> Self {
        let mut out = Jet { value, gradient: self.gradient.map(|g| first * g), hessian: self.hessian };
        for i in 0..N {
            for j in 0..N {
                out.hessian[i][j] = first * self.hessian[i][j] + second * self.gradient[i] * self.gradient[j];
            }
        }
        out
    }

    /// `outer` of these `inner` numbers, from its own jet by them.
    pub fn compose<const M: usize>(outer: &Jet<M>, inner: &[Self; M]) -> Self {
        let mut out = Jet::constant(outer.value);
        for (a, x) in inner.iter().enumerate() {
            for i in 0..N {
                out.gradient[i] += outer.gradient[a] * x.gradient[i];
                for j in 0..N {
                    out.hessian[i][j] += outer.gradient[a] * x.hessian[i][j];
                }
            }
            for (b, y) in inner.iter().enumerate() {
                for i in 0..N {
                    for j in 0..N {
                        out.hessian[i][j] += outer.hessian[a][b] * x.gradient[i] * y.gradient[j];
                    }
                }
            }
        }
        out
    }

    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root, -0.25 / (root * self.value))
    }

    /// 1/x.
    pub fn recip(self) -> Self {
        let inverse = 1.0 / self.value;
        self.chain(inverse, -inverse * inverse, 2.0 * inverse.powi(3))
    }

    /// Sine and cosine.
    pub fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos();
        (self.chain(sin, cos, -sin), self.chain(cos, -sin, -cos))
    }

    pub fn square(self) -> Self {
        self * self
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self.value += other.value;
        for i in 0..N {
            self.gradient[i] += other.gradient[i];
            for j in 0..N {
                self.hessian[i][j] += other.hessian[i][j];
            }
        }
        self
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl<const N: usize> Neg for Jet<N> {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const N: usize> Mul for Jet<N> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let mut out = Jet::constant(self.value * other.value);
        for i in 0..N {
            out.gradient[i] = self.gradient[i] * other.value + self.value * other.gradient[i];
            for j in 0..N {
                out.hessian[i][j] = self.hessian[i][j] * other.value
                    + self.value * other.hessian[i][j]
                    + self.gradient[i] * other.gradient[j]
                    + other.gradient[i] * self.gradient[j];
            }
        }
        out
    }
}

impl<const N: usize> Div for Jet<N> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        Mul::mul(self, other.recip())
    }
}

impl<const N: usize> Add<f64> for Jet<N> {
    type Output = Self;
    fn add(mut self, other: f64) -> Self {
        self.value += other;
        self
    }
}

impl<const N: usize> Sub<f64> for Jet<N> {
    type Output = Self;
    fn sub(self, other: f64) -> Self {
        self + -other
    }
}

impl<const N: usize> Mul<f64> for Jet<N> {
    type Output = Self;
    fn mul(mut self, other: f64) -> Self {
        self.value *= other;
        for i in 0..N {
            self.gradient[i] *= other;
            for j in 0..N {
                self.hessian[i][j] *= other;
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(x: Jet<2>, y: Jet<2>) -> Jet<2> {
        let (sin, cos) = (x * y).sin_cos();
        (x.square() + y * 3.0 - 0.5).sqrt() * sin / (cos.square() + 2.0) - -y.recip()
    }

    #[test]
    fn composition_is_what_carrying_the_inner_jets_through_would_give() {
        let (x, y) = (Jet::variable(0.7, 0), Jet::variable(1.3, 1));
        let inner = [x * y + 0.4, x.square() + y];
        let outer = sample(Jet::variable(inner[0].value, 0), Jet::variable(inner[1].value, 1));
        let (composed, carried) = (Jet::compose(&outer, &inner), sample(inner[0], inner[1]));
        for i in 0..2 {
            // The same sums in another order.
            assert!((composed.gradient[i] - carried.gradient[i]).abs() < 1e-13);
            assert!((0..2).all(|j| (composed.hessian[i][j] - carried.hessian[i][j]).abs() < 1e-12));
        }
    }

    #[test]
    fn gradient_and_hessian_agree_with_central_differences() {
        let (x, y, h) = (0.7, 1.3, 1e-5);
        let at = |x: f64, y: f64| sample(Jet::variable(x, 0), Jet::variable(y, 1));
        let exact = at(x, y);
        for (i, (dx, dy)) in [(h, 0.0), (0.0, h)].into_iter().enumerate() {
            let (up, down) = (at(x + dx, y + dy), at(x - dx, y - dy));
            // Truncation h²f‴/6 ~ 1e-10 and rounding eps/h ~ 2e-11.
            assert!((exact.gradient[i] - (up.value - down.value) / (2.0 * h)).abs() < 2e-9);
            for j in 0..2 {
                assert!((exact.hessian[i][j] - (up.gradient[j] - down.gradient[j]) / (2.0 * h)).abs() < 2e-9);
            }
        }
    }
}
