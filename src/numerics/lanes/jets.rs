//! Second-order jets at eight points at once: as [`Jet`], with lanes for numbers.

use std::ops::{Add, Mul, Sub};

use super::{Lanes, Vector};
use crate::numerics::jet::Jet;

/// Value, gradient and Hessian by N variables at eight points; of the Hessian only `[i][j]` with i ≤ j is kept.
#[derive(Debug, Clone, Copy)]
pub struct Jets<V, const N: usize> {
    pub value: V,
    pub gradient: [V; N],
    pub hessian: [[V; N]; N],
}

impl<V: Vector, const N: usize> Jets<V, N> {
    /// How many lanes one jet is stored in.
    pub const PARTS: usize = 1 + N + N * (N + 1) / 2;

    #[inline(always)]
    pub fn constant(value: V) -> Self {
        Jets { value, gradient: [V::zero(); N], hessian: [[V::zero(); N]; N] }
    }

    /// The same jet at all points.
    #[inline(always)]
    pub fn all(jet: &Jet<N>) -> Self {
        let mut out = Self::constant(V::all(jet.value));
        for i in 0..N {
            out.gradient[i] = V::all(jet.gradient[i]);
            for j in i..N {
                out.hessian[i][j] = V::all(jet.hessian[i][j]);
            }
        }
        out
    }

    /// Part by part, `stride` apart, from `start`.
    #[inline(always)]
    pub fn store(&self, parts: &mut [Lanes], start: usize, stride: usize) {
        parts[start] = self.value.lanes();
        let mut at = start;
        for i in 0..N {
            at += stride;
            parts[at] = self.gradient[i].lanes();
        }
        for i in 0..N {
            for j in i..N {
                at += stride;
                parts[at] = self.hessian[i][j].lanes();
            }
        }
    }

    /// What [`Jets::store`] stored.
    #[inline(always)]
    pub fn load(parts: &[Lanes], start: usize, stride: usize) -> Self {
        let mut out = Self::constant(V::of(&parts[start]));
        let mut at = start;
        for i in 0..N {
            at += stride;
            out.gradient[i] = V::of(&parts[at]);
        }
        for i in 0..N {
            for j in i..N {
                at += stride;
                out.hessian[i][j] = V::of(&parts[at]);
            }
        }
        out
    }

    /// Sum over the eight points.
    #[inline(always)]
    pub fn sum(&self) -> Jet<N> {
        let mut out = Jet::constant(self.value.sum());
        for i in 0..N {
            out.gradient[i] = self.gradient[i].sum();
            for j in i..N {
                out.hessian[i][j] = self.hessian[i][j].sum();
                out.hessian[j][i] = out.hessian[i][j];
            }
        }
        out
    }

    /// f of these jets, from f, f′ and f″ at their values.
    #[inline(always)]
    pub fn chain(&self, value: V, first: V, second: V) -> Self {
        let mut out = Self::constant(value);
        for i in 0..N {
            out.gradient[i] = first * self.gradient[i];
            let twice = second * self.gradient[i];
            for j in i..N {
                out.hessian[i][j] = first.mul_add(self.hessian[i][j], twice * self.gradient[j]);
            }
        }
        out
    }

    /// `outer` of `a` and `b`, from its own jets by the two.
    #[inline(always)]
    pub fn compose(outer: &Jets<V, 2>, a: &Self, b: &Self) -> Self {
        let mut out = Self::constant(outer.value);
        let [by_a, by_b] = outer.gradient;
        let (aa, ab, bb) = (outer.hessian[0][0], outer.hessian[0][1], outer.hessian[1][1]);
        for i in 0..N {
            out.gradient[i] = by_a.mul_add(a.gradient[i], by_b * b.gradient[i]);
            let (with_a, with_b) = (aa.mul_add(a.gradient[i], ab * b.gradient[i]), ab.mul_add(a.gradient[i], bb * b.gradient[i]));
            for j in i..N {
                let curved = by_a.mul_add(a.hessian[i][j], by_b * b.hessian[i][j]);
                out.hessian[i][j] = with_a.mul_add(a.gradient[j], with_b.mul_add(b.gradient[j], curved));
            }
        }
        out
    }

    #[inline(always)]
    pub fn square(&self) -> Self {
        let mut out = Self::constant(self.value * self.value);
        let twice = self.value * 2.0;
        for i in 0..N {
            out.gradient[i] = twice * self.gradient[i];
            let double = self.gradient[i] * 2.0;
            for j in i..N {
                out.hessian[i][j] = twice.mul_add(self.hessian[i][j], double * self.gradient[j]);
            }
        }
        out
    }

    #[inline(always)]
    pub fn sqrt(&self) -> Self {
        let root = self.value.sqrt();
        let first = V::all(0.5) / root;
        self.chain(root, first, -(first * 0.5) / self.value)
    }

    /// 1/x.
    #[inline(always)]
    pub fn recip(&self) -> Self {
        let inverse = V::all(1.0) / self.value;
        let square = inverse * inverse;
        self.chain(inverse, -square, square * inverse * 2.0)
    }

    /// Every part times a number of its point.
    #[inline(always)]
    pub fn scaled(mut self, by: V) -> Self {
        self.value = self.value * by;
        for i in 0..N {
            self.gradient[i] = self.gradient[i] * by;
            for j in i..N {
                self.hessian[i][j] = self.hessian[i][j] * by;
            }
        }
        self
    }

    /// A number of each point more.
    #[inline(always)]
    pub fn shifted(mut self, by: V) -> Self {
        self.value = self.value + by;
        self
    }
}

impl<V: Vector, const N: usize> Add for Jets<V, N> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self.value = self.value + other.value;
        for i in 0..N {
            self.gradient[i] = self.gradient[i] + other.gradient[i];
            for j in i..N {
                self.hessian[i][j] = self.hessian[i][j] + other.hessian[i][j];
            }
        }
        self
    }
}

impl<V: Vector, const N: usize> Sub for Jets<V, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        self.value = self.value - other.value;
        for i in 0..N {
            self.gradient[i] = self.gradient[i] - other.gradient[i];
            for j in i..N {
                self.hessian[i][j] = self.hessian[i][j] - other.hessian[i][j];
            }
        }
        self
    }
}

impl<V: Vector, const N: usize> Mul for Jets<V, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let mut out = Self::constant(self.value * other.value);
        for i in 0..N {
            out.gradient[i] = self.gradient[i].mul_add(other.value, self.value * other.gradient[i]);
            for j in i..N {
                let curved = self.hessian[i][j].mul_add(other.value, self.value * other.hessian[i][j]);
                out.hessian[i][j] = self.gradient[i].mul_add(other.gradient[j], other.gradient[i].mul_add(self.gradient[j], curved));
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lanes(x: f64, y: f64) -> [Jets<Lanes, 2>; 2] {
        [Jets::all(&Jet::variable(x, 0)), Jets::all(&Jet::variable(y, 1))]
    }

    fn first(jets: &Jets<Lanes, 2>) -> Jet<2> {
        let mut out = Jet::constant(jets.value.0[0]);
        for i in 0..2 {
            out.gradient[i] = jets.gradient[i].0[0];
            for j in i..2 {
                out.hessian[i][j] = jets.hessian[i][j].0[0];
                out.hessian[j][i] = out.hessian[i][j];
            }
        }
        out
    }

    #[test]
    fn every_operation_is_that_of_single_jets() {
        let ([x, y], (u, v)) = (lanes(0.7, 1.3), (Jet::<2>::variable(0.7, 0), Jet::<2>::variable(1.3, 1)));
        let two = Lanes([2.0; 8]);
        let found = (x * y + y.square()).sqrt() * (x.scaled(two).shifted(two) - y).recip();
        let single = (u * v + v.square()).sqrt() * (u * 2.0 + 2.0 - v).recip();
        let composed = Jets::compose(&found, &(x * y), &(y - x.square()));
        let carried = Jet::compose(&single, &[u * v, v - u.square()]);
        for (found, single) in [(first(&found), single), (first(&composed), carried)] {
            assert!((found.value - single.value).abs() < 1e-15);
            for i in 0..2 {
                // The same sums, fused.
                assert!((found.gradient[i] - single.gradient[i]).abs() < 1e-13);
                assert!((0..2).all(|j| (found.hessian[i][j] - single.hessian[i][j]).abs() < 1e-12));
            }
        }
    }

    #[test]
    fn stored_jets_are_loaded_as_they_were_and_sum_over_their_points() {
        let [x, y] = lanes(0.7, 1.3);
        let jets = x * y + x.square();
        let mut parts = vec![Lanes::ZERO; 3 * Jets::<Lanes, 2>::PARTS];
        jets.store(&mut parts, 1, 3);
        let again = Jets::<Lanes, 2>::load(&parts, 1, 3);
        assert_eq!(first(&jets), first(&again));
        // Eight times the same: exact.
        assert_eq!(again.sum().hessian[0][1], 8.0 * first(&jets).hessian[0][1]);
    }
}
