//! Bending of the cloth: the curvature of every horizontal ring.

use crate::experiment::Skirt;
use crate::numerics::jet::Jet;
use crate::numerics::lanes::jets::Jets;
use crate::numerics::lanes::{Lanes, Vector, WIDTH};
use crate::numerics::quadrature::gauss_legendre;
use crate::vectorized;

/// Bending of a ruled shell: `U = ∫₀¹∮ (B/2) κ² (R_t + uL cos β) L dσ du`, κ the plane curvature of the ring at fraction u.
///
/// With the hem's tangent `c' = i r̂ e^{i(σ + ψ)}`, `P = (1 − u) R_t` and `Q = u r̂`, a ring has speed `v² = P² + 2PQ cos ψ + Q²` and curvature
/// `κ = 1/v + ψ' Q (P cos ψ + Q)/v³`: local in ψ and ψ'. The mixed term of κ² is a total derivative and drops out of the closed integral, so
/// `U = ∮ (b_0(ψ) + b_2(ψ) ψ'²) dσ`.
#[derive(Debug, Clone)]
pub struct Bending {
    /// Per node of the slant: P, u, and weight times (B/2)(R_t + uL cos β) L.
    slices: Vec<(f64, f64, f64)>,
}

impl Bending {
    pub const NAME: &'static str = "bending";

    /// Nodes along the slant that resolve the integrand to rounding unless a ring is about to crease.
    pub const NODES: usize = 24;

    /// `rigidity` is B, N·m; `nodes` along the slant.
    pub fn new(skirt: &Skirt, rigidity: f64, nodes: usize) -> Self {
        let (waist, hem, slant) = (skirt.waist_radius().0, skirt.hem_radius().0, skirt.slant_length().0);
        // Equal steps in ln R: the integrand behaves like 1/R near the apex of the cone, and that pole is mapped to infinity.
        let growth = (hem / waist).ln();
        let slice = |(x, w): (f64, f64)| {
            let (u, du) = if growth < 1e-6 {
                (x, w)
            } else {
                ((x * growth).exp_m1() / growth.exp_m1(), w * growth * (x * growth).exp() / growth.exp_m1())
            };
            ((1.0 - u) * waist, u, du * 0.5 * rigidity * (waist + u * (hem - waist)) * slant)
        };
        Bending { slices: gauss_legendre(nodes).into_iter().map(slice).collect() }
    }

    /// b_0 and b_2, J per radian of σ, from cos ψ and the hem's own radius r̂ = |dc/dσ|, m.
    pub fn density<const N: usize>(&self, cos: Jet<N>, hem: Jet<N>) -> (Jet<N>, Jet<N>) {
        let (mut constant, mut quadratic) = (Jet::constant(0.0), Jet::constant(0.0));
        for &(p, u, weight) in &self.slices {
            let q = hem * u;
            let lever = cos * p + q;
            let inverse = (q * (lever + cos * p) + p * p).recip();
            let ratio = q * lever * inverse;
            let scaled = inverse * weight;
            constant = constant + scaled;
            quadratic = quadratic + scaled * ratio.square();
        }
        (constant, quadratic)
    }

    /// b_0 and b_2 (J per radian of σ) of a hem of radius `hem`, each with its first and second derivative by cos ψ.
    ///
    /// The same integrals as [`Bending::density`], differentiated by hand: this is the innermost loop of a prediction.
    pub fn by_cos(&self, cos: f64, hem: f64) -> ([f64; 3], [f64; 3]) {
        let (mut constant, mut quadratic) = ([0.0; 3], [0.0; 3]);
        for &(p, u, weight) in &self.slices {
            let q = u * hem;
            let lever = p * cos + q;
            let inverse = 1.0 / (q * (lever + p * cos) + p * p);
            // d(v²)/d(cos ψ) relative to v², and the same of the lever, kept free of division by a lever that may vanish.
            let (scaled, bend) = (weight * inverse, 2.0 * p * q * inverse);
            constant[0] += scaled;
            constant[1] -= scaled * bend;
            constant[2] += 2.0 * scaled * bend * bend;
            let lead = scaled * (q * inverse) * (q * inverse);
            let arm = lever * bend;
            quadratic[0] += lead * lever * lever;
            quadratic[1] += lead * lever * (2.0 * p - 3.0 * arm);
            quadratic[2] += lead * (2.0 * p * p - 12.0 * p * arm + 12.0 * arm * arm);
        }
        (constant, quadratic)
    }

    /// [`Bending::by_cos`] of many angles.
    pub fn by_cosines(&self, cosines: &[f64], hem: f64) -> Vec<([f64; 3], [f64; 3])> {
        by_cosines(&self.slices, cosines, hem)
    }

    /// b_0 and b_2 at eight places, with their derivatives by cos ψ and by r̂; differentiated by hand like [`Bending::by_cos`].
    #[inline(always)]
    pub fn densities<V: Vector>(&self, cos: V, hem: V) -> [Jets<V, 2>; 2] {
        let (mut constant, mut quadratic) = (Jets::constant(V::zero()), Jets::constant(V::zero()));
        for &(p, u, weight) in &self.slices {
            let (q, toward) = (hem * u, cos * p);
            let lever = toward + q;
            let inverse = V::all(1.0) / q.mul_add(lever + toward, V::all(p * p));
            // Derivatives of v² relative to v²: g by cos ψ and by r̂, then the second ones (by cos ψ twice there is none).
            let g = [q * inverse * (2.0 * p), lever * inverse * (2.0 * u)];
            let mixed = inverse * (2.0 * p * u);
            let bent = inverse * (2.0 * u * u);
            let scaled = inverse * weight;
            // −1 times the logarithmic derivatives of 1/v².
            constant.value = constant.value + scaled;
            constant.gradient[0] = scaled.neg_mul_add(g[0], constant.gradient[0]);
            constant.gradient[1] = scaled.neg_mul_add(g[1], constant.gradient[1]);
            let twice = [g[0] * 2.0, g[1] * 2.0];
            constant.hessian[0][0] = scaled.mul_add(twice[0] * g[0], constant.hessian[0][0]);
            constant.hessian[0][1] = scaled.mul_add(twice[0].mul_sub(g[1], mixed), constant.hessian[0][1]);
            constant.hessian[1][1] = scaled.mul_add(twice[1].mul_sub(g[1], bent), constant.hessian[1][1]);
            // The arm q·lever and its first derivatives, over v²: the powers of v alone would leave the range of numbers first.
            let arm = q * lever * inverse;
            let by = [q * inverse * p, (lever + q) * inverse * u];
            let slope = [by[0] * 2.0 - arm * g[0] * 3.0, by[1] * 2.0 - arm * g[1] * 3.0];
            let led = scaled * arm;
            quadratic.value = led.mul_add(arm, quadratic.value);
            quadratic.gradient[0] = led.mul_add(slope[0], quadratic.gradient[0]);
            quadratic.gradient[1] = led.mul_add(slope[1], quadratic.gradient[1]);
            let thrice = V::all(1.0) - arm * 3.0;
            let curved = [
                (by[0] * by[0]) * 2.0 + arm * (arm * g[0] - by[0]) * g[0] * 12.0,
                (by[0] * by[1]) * 2.0 + arm * ((arm * g[0] * g[1] * 12.0 - (by[0] * g[1] + by[1] * g[0]) * 6.0) + mixed * thrice),
                (by[1] * by[1]) * 2.0 + arm * ((arm * g[1] - by[1]) * g[1] * 12.0 + bent * (thrice + 1.0)),
            ];
            quadratic.hessian[0][0] = scaled.mul_add(curved[0], quadratic.hessian[0][0]);
            quadratic.hessian[0][1] = scaled.mul_add(curved[1], quadratic.hessian[0][1]);
            quadratic.hessian[1][1] = scaled.mul_add(curved[2], quadratic.hessian[1][1]);
        }
        [constant, quadratic]
    }
}

vectorized! {
    /// Eight angles at a time, the last of them as often as it takes.
    fn by_cosines<V>(slices: &[(f64, f64, f64)], cosines: &[f64], hem: f64) -> Vec<([f64; 3], [f64; 3])> {
        let mut out = Vec::with_capacity(cosines.len());
        for chunk in cosines.chunks(WIDTH) {
            let mut lanes = Lanes([chunk[chunk.len() - 1]; WIDTH]);
            lanes.0[..chunk.len()].copy_from_slice(chunk);
            let cos = V::of(&lanes);
            let (mut constant, mut quadratic) = ([V::zero(); 3], [V::zero(); 3]);
            for &(p, u, weight) in slices {
                let (q, toward) = (u * hem, cos * p);
                let lever = toward + q;
                let inverse = V::all(1.0) / (lever + toward).mul_add(V::all(q), V::all(p * p));
                let (scaled, bend) = (inverse * weight, inverse * (2.0 * p * q));
                constant[0] = constant[0] + scaled;
                constant[1] = scaled.neg_mul_add(bend, constant[1]);
                constant[2] = (scaled * 2.0 * bend).mul_add(bend, constant[2]);
                let reach = inverse * q;
                let (lead, arm) = (scaled * reach * reach, lever * bend);
                let turned = lead * lever;
                quadratic[0] = turned.mul_add(lever, quadratic[0]);
                quadratic[1] = turned.mul_add((arm * -3.0) + 2.0 * p, quadratic[1]);
                quadratic[2] = lead.mul_add((arm * 12.0).mul_add(arm - p, V::all(2.0 * p * p)), quadratic[2]);
            }
            let (constant, quadratic) =
                ([constant[0].lanes(), constant[1].lanes(), constant[2].lanes()], [quadratic[0].lanes(), quadratic[1].lanes(), quadratic[2].lanes()]);
            for lane in 0..chunk.len() {
                let one = |of: &[Lanes; 3]| [of[0].0[lane], of[1].0[lane], of[2].0[lane]];
                out.push((one(&constant), one(&quadratic)));
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Metre;

    #[test]
    fn derivatives_by_hand_agree_with_jets() {
        let skirt = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap();
        let bending = Bending::new(&skirt, 1e-5, Bending::NODES);
        for i in -9..=10 {
            let cos = 0.1 * f64::from(i);
            let (constant, quadratic) = bending.density(Jet::<1>::variable(cos, 0), Jet::constant(0.2362));
            let many = bending.by_cosines(&[0.3, cos, 0.1, 0.2, 0.4, 0.5, 0.6, 0.7, cos], 0.2362);
            for hand in [bending.by_cos(cos, 0.2362), many[1], many[8]] {
                for (jet, hand) in [(constant, hand.0), (quadratic, hand.1)] {
                    // The same sums in another order.
                    for (a, b) in [(jet.value, hand[0]), (jet.gradient[0], hand[1]), (jet.hessian[0][0], hand[2])] {
                        assert!((a - b).abs() <= 1e-12 * a.abs().max(1e-6), "cos {cos}: {a} {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn derivatives_by_angle_and_radius_of_eight_places_agree_with_jets() {
        let skirt = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap();
        let bending = Bending::new(&skirt, 1e-5, Bending::NODES);
        let cosines = Lanes(std::array::from_fn(|lane| -0.6 + 0.2 * lane as f64));
        let places = bending.densities(cosines, Lanes([0.23; WIDTH]));
        for (lane, cos) in cosines.0.iter().enumerate() {
            let (constant, quadratic) = bending.density(Jet::<2>::variable(*cos, 0), Jet::variable(0.23, 1));
            for (jet, place) in [(constant, places[0]), (quadratic, places[1])] {
                let pairs = [
                    (jet.value, place.value),
                    (jet.gradient[0], place.gradient[0]),
                    (jet.gradient[1], place.gradient[1]),
                    (jet.hessian[0][0], place.hessian[0][0]),
                    (jet.hessian[0][1], place.hessian[0][1]),
                    (jet.hessian[1][1], place.hessian[1][1]),
                ];
                for (a, b) in pairs {
                    // The same sums in another order.
                    assert!((a - b.0[lane]).abs() <= 1e-12 * a.abs().max(1e-6), "cos {cos}: {a} {}", b.0[lane]);
                }
            }
        }
    }

    #[test]
    fn slices_resolve_every_angle_short_of_a_crease() {
        for hem in [0.1210001, 0.15, 0.2362, 0.6, 2.0] {
            let skirt = Skirt::new(Metre(0.121), Metre(hem), Metre(2.0)).unwrap();
            let [coarse, fine] = [1, 3].map(|factor| Bending::new(&skirt, 1e-5, factor * Bending::NODES));
            for cos in [1.0, 0.5, 0.0, -0.3] {
                let (a, b) = (coarse.by_cos(cos, hem), fine.by_cos(cos, hem));
                // Gauss–Legendre converges geometrically, slower where a ring nears a crease (cos ψ → −1) and where the hem is many waists wide.
                let tolerance = if cos < 0.5 { 1e-8 } else { 1e-14 };
                for (a, b) in [(a.0[0], b.0[0]), (a.1[0], b.1[0])] {
                    assert!((a / b - 1.0).abs() < tolerance, "hem {hem}, cos {cos}: {:e}", a / b - 1.0);
                }
            }
        }
    }
}
