//! The paper's functional along its own curve: `J = ∮ G(r) dt` under a given perimeter, as printed.
//!
//! `G(r) = ρ_A g (L − √(L² − (r − R_t)²)) + (E/2)(R_t − r)²` (paper, equations 10 and 11). With G in N/m, E is a foundation modulus in N/m³ and the
//! multiplier of the perimeter is in N/m². What the functional lacks (a curvature energy, and so a fold count) is said in docs/model.md, section 3.

use std::f64::consts::{PI, TAU};

use super::hem::Hem;
use crate::experiment::Skirt;
use crate::numerics::jet::Jet;

/// A quantity of a hem with exact gradient and Hessian in (p, q, s).
pub type HemJet = Jet<3>;

/// The paper's functional for one skirt.
#[derive(Debug, Clone, Copy)]
pub struct PaperFunctional {
    waist: f64,
    slant: f64,
    /// ρ_A g, N/m².
    weight: f64,
    /// E, N/m³.
    foundation: f64,
}

/// Position, velocity and acceleration of the hem curve at one parameter, as jets in the turning frame: (radial, tangential), m.
#[derive(Debug, Clone, Copy)]
pub struct HemPoint {
    pub position: (HemJet, HemJet),
    pub velocity: (HemJet, HemJet),
    pub acceleration: (HemJet, HemJet),
}

impl HemPoint {
    /// At fold phase mt = `phase`.
    pub fn at(hem: &Hem, phase: f64) -> Self {
        let m = f64::from(hem.folds.max(1));
        let (sin, cos) = phase.sin_cos();
        let (sin2, cos2) = (2.0 * sin * cos, 1.0 - 2.0 * sin * sin);
        // Everything is linear in p, q, s.
        let linear = |p: f64, q: f64, s: f64| Jet { value: p * hem.p + q * hem.q + s * hem.s, gradient: [p, q, s], hessian: [[0.0; 3]; 3] };
        HemPoint {
            position: (linear(1.0, cos, 0.0), linear(0.0, 0.0, sin2)),
            velocity: (linear(0.0, -m * sin, -sin2), linear(1.0, cos, 2.0 * m * cos2)),
            acceleration: (linear(-1.0, -(m * m + 1.0) * cos, -4.0 * m * cos2), linear(0.0, -2.0 * m * sin, -(4.0 * m * m + 1.0) * sin2)),
        }
    }

    pub fn speed(&self) -> HemJet {
        (self.velocity.0.square() + self.velocity.1.square()).sqrt()
    }

    pub fn radius(&self) -> HemJet {
        (self.position.0.square() + self.position.1.square()).sqrt()
    }
}

/// Mean over the curve, uniform in t, of an even function of the fold phase; nodes are doubled until `settled` is content with two means in a row.
///
/// `None` where the function does not exist somewhere on the curve.
pub(crate) fn settled_mean<const Q: usize>(f: impl Fn(f64) -> Option<[HemJet; Q]>) -> Option<[HemJet; Q]> {
    let mean = |half: usize| {
        let mut sum = [Jet::constant(0.0); Q];
        for n in 0..=half {
            let weight = if n == 0 || n == half { 0.5 } else { 1.0 } / half as f64;
            for (sum, value) in sum.iter_mut().zip(f(PI * n as f64 / half as f64)?) {
                *sum = *sum + value * weight;
            }
        }
        Some(sum)
    };
    let mut half = 16;
    let mut last = mean(half)?;
    loop {
        half *= 2;
        let next = mean(half)?;
        // A curve that stands still somewhere converges algebraically: past 4096 nodes the digits are of no use.
        let still = last.iter().zip(&next).all(|(a, b)| (a.value - b.value).abs() <= 1e-14 * b.value.abs());
        if still || 4096 <= half {
            return Some(next);
        }
        last = next;
    }
}

/// Perimeter Λ, m.
pub fn perimeter(hem: &Hem) -> HemJet {
    // The speed exists everywhere.
    settled_mean(|phase| Some([HemPoint::at(hem, phase).speed()])).map_or(Jet::constant(0.0), |[mean]| mean * TAU)
}

impl PaperFunctional {
    /// `weight` is ρ_A g, N/m²; `foundation` is E, N/m³.
    pub fn new(skirt: &Skirt, weight: f64, foundation: f64) -> Self {
        PaperFunctional { waist: skirt.waist_radius().0, slant: skirt.slant_length().0, weight, foundation }
    }

    /// G(r), N/m; `None` where |r − R_t| ≥ L.
    pub fn density<const N: usize>(&self, radius: Jet<N>) -> Option<Jet<N>> {
        let lean = radius - self.waist;
        let height_squared = lean.square() * -1.0 + self.slant * self.slant;
        if height_squared.value.is_nan() || height_squared.value <= 0.0 {
            return None;
        }
        // x²/(L + √(L² − x²)) is L − √(L² − x²) without cancellation.
        let rise = lean.square() / (height_squared.sqrt() + self.slant);
        Some(rise * self.weight + lean.square() * (0.5 * self.foundation))
    }

    /// J = ∮ G dt, N/m; `None` where the hem reaches further than the slant.
    pub fn energy(&self, hem: &Hem) -> Option<HemJet> {
        settled_mean(|phase| Some([self.density(HemPoint::at(hem, phase).radius())?])).map(|[mean]| mean * TAU)
    }

    /// Least squares of `λ v = 2G − C` along the curve, uniform in t: λ (N/m²) and R². Equations (15) and (16) of the paper, added.
    ///
    /// `None` where the hem reaches further than the slant, or is a circle: then v is constant and the relation says nothing of λ.
    pub fn first_integral(&self, hem: &Hem) -> Option<(HemJet, f64)> {
        let sample = |phase: f64| {
            let point = HemPoint::at(hem, phase);
            Some((point.speed(), self.density(point.radius())? * 2.0))
        };
        let [speed, double] = settled_mean(|phase| sample(phase).map(|(v, g)| [v, g]))?;
        // Second moments about the means, which loses no digits to cancellation.
        let [vv, vg, gg] = settled_mean(|phase| {
            let (v, g) = sample(phase)?;
            let (v, g) = (v - speed, g - double);
            Some([v.square(), v * g, g.square()])
        })?;
        if vv.value <= (1e-9 * speed.value).powi(2) || gg.value <= 0.0 {
            return None;
        }
        Some((vg / vv, vg.value * vg.value / (vv.value * gg.value)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Metre;

    const HEM: Hem = Hem { p: 0.1315, q: 0.0527, s: 0.00873, folds: 5 };

    #[test]
    fn perimeter_agrees_with_the_hem_s_own() {
        let (own, gradient) = HEM.perimeter_gradient();
        let jet = perimeter(&HEM);
        assert!((jet.value - own).abs() < 1e-13);
        // Two converged trapezoid rules of the same integrand.
        assert!(jet.gradient.iter().zip(gradient).all(|(a, b)| (a - b).abs() < 1e-11));
    }

    #[test]
    fn local_frame_agrees_with_the_hem_s_own() {
        for i in 0..20 {
            let t = 0.06 * f64::from(i);
            let (jet, own) = (HemPoint::at(&HEM, 5.0 * t), HEM.local(t));
            let pairs = [(jet.position, own.position), (jet.velocity, own.velocity), (jet.acceleration, own.acceleration)];
            assert!(pairs.iter().all(|(a, b)| (a.0.value - b.0).abs() < 1e-14 && (a.1.value - b.1).abs() < 1e-13));
        }
    }

    #[test]
    fn functional_s_derivatives_agree_with_central_differences() {
        let skirt = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap();
        let functional = PaperFunctional::new(&skirt, 1.962, 20.0);
        let at = |d: [f64; 3]| {
            let hem = Hem { p: HEM.p + d[0], q: HEM.q + d[1], s: HEM.s + d[2], ..HEM };
            (functional.energy(&hem).unwrap(), functional.first_integral(&hem).unwrap().0)
        };
        let (exact, h) = (at([0.0; 3]), 1e-6);
        for i in 0..3 {
            let step = |sign: f64| at([0, 1, 2].map(|k| if k == i { sign * h } else { 0.0 }));
            let (up, down) = (step(1.0), step(-1.0));
            let check = |exact: HemJet, up: HemJet, down: HemJet| {
                let size = exact.gradient.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
                // Truncation h²f‴/6f′ ~ 1e-8 with lengths of centimetres.
                assert!((exact.gradient[i] - (up.value - down.value) / (2.0 * h)).abs() < 1e-6 * size);
                for j in 0..3 {
                    let numeric = (up.gradient[j] - down.gradient[j]) / (2.0 * h);
                    assert!((exact.hessian[i][j] - numeric).abs() < 1e-5 * (numeric.abs() + size / HEM.q));
                }
            };
            check(exact.0, up.0, down.0);
            check(exact.1, up.1, down.1);
        }
    }
}
