//! Bending and shear of the cloth at one point, from its two fundamental forms, with first and second derivatives by these.
//!
//! In the frame that turns with the ring's tangent `X_σ = (0, R, p)`, `X_ℓ = (x, y, −c)`; g_ℓℓ is 1. With `e = g_σσ`, `f = g_σℓ`, `w = e − f²` and
//! `(e2, f2, g2)` the second fundamental form times the length of the normal, √w, the sum of the squared principal curvatures is `Q/w²·1/w`,
//! `Q = (e2 − f f2)² + 2 (f2 − f g2)(e f2 − f e2) + (e g2 − f f2)²`.

use super::grid::Band;
use super::shape::Point;
use crate::numerics::lanes::{Lanes, Vector};

/// The forms by their place in derivatives.
pub(super) const E: usize = 0;
pub(super) const F: usize = 1;
pub(super) const E2: usize = 2;
pub(super) const F2: usize = 3;
pub(super) const G2: usize = 4;

/// What the forms depend on, at eight points.
pub(super) struct Site<V> {
    pub x: V,
    pub y: V,
    pub x2: V,
    pub y2: V,
    pub c: V,
    /// 1/c.
    pub inverse: V,
    /// ∂c/∂σ.
    pub cs: V,
    /// 1 + ψ_σ.
    pub t: V,
    /// −R ψ_ℓ.
    pub a: V,
    /// z_σ.
    pub p: V,
    /// z_σσ.
    pub r: V,
    pub ring: V,
    /// dR/dℓ.
    pub growth: V,
}

impl<V: Vector> Site<V> {
    #[inline(always)]
    pub fn of(point: &Point, [p, r]: [&Lanes; 2], band: &Band, growth: f64) -> Self {
        let ring = V::of(&band.ring);
        Site {
            x: V::of(&point.x),
            y: V::of(&point.y),
            x2: V::of(&point.x2),
            y2: V::of(&point.y2),
            c: V::of(&point.c),
            inverse: V::of(&point.inverse),
            cs: V::of(&point.cs),
            t: V::of(&point.t),
            a: -(V::of(&point.psi_l) * ring),
            p: V::of(p),
            r: V::of(r),
            ring,
            growth: V::all(growth),
        }
    }
}

/// First and second fundamental form, at eight points.
pub(super) struct Forms<V> {
    pub e: V,
    pub f: V,
    pub e2: V,
    pub f2: V,
    pub g2: V,
    /// Of length √w.
    pub normal: [V; 3],
    /// ∂c/∂ℓ.
    pub cl: V,
    /// m12 = f2 − f g2, m21 = e f2 − f e2, and the diagonal of the shape operator times w^{3/2}.
    mixed: [V; 4],
    /// 1/w.
    inverse: V,
}

impl<V: Vector> Forms<V> {
    #[inline(always)]
    pub fn of(s: &Site<V>) -> Self {
        let cl = -(s.x.mul_add(s.x2, s.y * s.y2) * s.inverse);
        let (e, f) = (s.p.mul_add(s.p, s.ring * s.ring), s.y.mul_sub(s.ring, s.p * s.c));
        let normal = [-(s.c.mul_add(s.ring, s.p * s.y)), s.p * s.x, -(s.x * s.ring)];
        let e2 = s.r.mul_sub(normal[2], s.t * normal[0] * s.ring);
        let f2 = s.cs.neg_mul_add(normal[2], s.a.mul_add(normal[0], normal[1] * s.growth));
        let g2 = cl.neg_mul_add(normal[2], s.x2.mul_add(normal[0], s.y2 * normal[1]));
        let m11 = f.neg_mul_add(f2, e2);
        let m12 = f.neg_mul_add(g2, f2);
        let m21 = e.mul_sub(f2, f * e2);
        let m22 = e.mul_sub(g2, f * f2);
        let inverse = V::all(1.0) / f.neg_mul_add(f, e);
        Forms { e, f, e2, f2, g2, normal, cl, mixed: [m11, m12, m21, m22], inverse }
    }

    /// Q.
    #[inline(always)]
    fn trace(&self) -> V {
        let [m11, m12, m21, m22] = self.mixed;
        m11.mul_add(m11, m22.mul_add(m22, m12 * m21 * 2.0))
    }

    /// `stiffness · Q/w³`.
    #[inline(always)]
    pub fn bending(&self, stiffness: V) -> V {
        self.trace() * (self.inverse * self.inverse) * (self.inverse * stiffness)
    }

    /// `stiffness · f²/e`.
    #[inline(always)]
    pub fn shear(&self, stiffness: V) -> V {
        self.f * self.f / self.e * stiffness
    }

    /// Half the derivatives of Q by the forms, w held.
    #[inline(always)]
    fn half_slopes(&self) -> [V; 5] {
        let [m11, m12, m21, m22] = self.mixed;
        let (e, f) = (self.e, self.f);
        let sum = m11 + m22;
        [
            self.f2.mul_add(m12, self.g2 * m22),
            -(self.f2.mul_add(sum, self.g2.mul_add(m21, self.e2 * m12))),
            f.neg_mul_add(m12, m11),
            e.mul_add(m12, f.neg_mul_add(sum, m21)),
            e.mul_sub(m22, f * m21),
        ]
    }

    /// Derivatives of [`Forms::bending`] by the forms.
    #[inline(always)]
    pub fn bending_slopes(&self, stiffness: V) -> [V; 5] {
        let base = self.inverse * self.inverse * (self.inverse * stiffness);
        let twice = base * 2.0;
        let mut slopes = self.half_slopes();
        for slope in &mut slopes {
            *slope = *slope * twice;
        }
        // By w, which is e − f².
        let by_w = self.trace() * base * self.inverse * -3.0;
        slopes[E] = slopes[E] + by_w;
        slopes[F] = (self.f * -2.0).mul_add(by_w, slopes[F]);
        slopes
    }

    /// Derivatives of [`Forms::shear`] by e and f.
    #[inline(always)]
    pub fn shear_slopes(&self, stiffness: V) -> [V; 2] {
        let ratio = self.f / self.e;
        [-(ratio * ratio * stiffness), ratio * stiffness * 2.0]
    }

    /// Second derivatives of [`Forms::bending`] by the forms.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // Places in a symmetric table, not elements of a list.
    pub fn bending_curvatures(&self, stiffness: V) -> [[V; 5]; 5] {
        let (e, f, e2, f2, g2) = (self.e, self.f, self.e2, self.f2, self.g2);
        let base = self.inverse * self.inverse * (self.inverse * stiffness);
        let (two, four) = (base * 2.0, base * 4.0);
        let (f_e, ff, ee) = (f * e, f * f, e * e);
        // Second derivatives of Q: it is a quadratic form in (e2, f2, g2).
        let m12 = self.mixed[1];
        let mut out = [[V::zero(); 5]; 5];
        out[E][E] = two * g2 * g2;
        out[E][F] = -(four * f2 * g2);
        out[F][F] = four * e2.mul_add(g2, f2 * f2);
        out[E][F2] = four * m12;
        out[E][G2] = four * self.mixed[3];
        out[F][E2] = -(four * m12);
        out[F][F2] = four * (f * 2.0).mul_sub(f2, e.mul_add(g2, e2));
        out[F][G2] = -(four * self.mixed[2]);
        out[E2][E2] = two;
        out[E2][F2] = -(four * f);
        out[E2][G2] = two * ff;
        out[F2][F2] = four * (ff + e);
        out[F2][G2] = -(four * f_e);
        out[G2][G2] = two * ee;
        // And of w⁻³: w_e = 1, w_f = −2f, w_ff = −2.
        let slopes = self.half_slopes();
        let wi = self.inverse;
        let (first, q) = (base * wi * -6.0, self.trace() * base * wi);
        let second = q * wi * 12.0;
        let by_w = [V::all(1.0), f * -2.0];
        for i in [E, F] {
            for j in 0..5 {
                if j < i {
                    continue;
                }
                let mut more = slopes[j] * by_w[i];
                if j <= F {
                    more = slopes[i].mul_add(by_w[j], more);
                    out[i][j] = (second * by_w[i]).mul_add(by_w[j], out[i][j]);
                }
                out[i][j] = first.mul_add(more, out[i][j]);
            }
        }
        out[F][F] = q.mul_add(V::all(6.0), out[F][F]);
        for i in E..=G2 {
            for j in E..i {
                out[i][j] = out[j][i];
            }
        }
        out
    }

    /// Second derivatives of [`Forms::shear`]: by e twice, by e and f, by f twice.
    #[inline(always)]
    pub fn shear_curvatures(&self, stiffness: V) -> [V; 3] {
        let by = stiffness / self.e * 2.0;
        let ratio = self.f / self.e;
        [by * ratio * ratio, -(by * ratio), by]
    }
}
