//! The paper's functional along its own curve: `J = ∮ G(r) dt` under a given perimeter, as printed.
//!
//! `G(r) = ρ_A g (L − √(L² − (r − R_t)²)) + (E/2)(R_t − r)²` (paper, equations 10 and 11). With G in N/m, E is a foundation modulus in N/m³ and the
//! multiplier of the perimeter is in N/m². What the functional lacks (a curvature energy, and so a fold count) is said in docs/model.md, section 3.

use std::f64::consts::{PI, TAU};

use super::hem::{Hem, midpoints};
use crate::experiment::Skirt;
use crate::numerics::jet::Jet;
use crate::numerics::lanes::jets::Jets;
use crate::numerics::lanes::{Vector, WIDTH};
use crate::vectorized;

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

/// The same at eight places, with derivatives by the first N of p, q, s.
#[derive(Debug, Clone, Copy)]
pub struct Places<V, const N: usize> {
    pub position: (Jets<V, N>, Jets<V, N>),
    pub velocity: (Jets<V, N>, Jets<V, N>),
    pub acceleration: (Jets<V, N>, Jets<V, N>),
}

impl<V: Vector, const N: usize> Places<V, N> {
    /// At fold phases of given cosine and sine.
    #[inline(always)]
    pub fn at(hem: &Hem, (cos, sin): (V, V)) -> Self {
        let m = f64::from(hem.folds.max(1));
        let (sin2, cos2) = (sin * cos * 2.0, V::all(1.0) - sin * sin * 2.0);
        let (zero, one) = (V::zero(), V::all(1.0));
        Places {
            position: (linear(hem, [one, cos, zero]), linear(hem, [zero, zero, sin2])),
            velocity: (linear(hem, [zero, sin * -m, -sin2]), linear(hem, [one, cos, cos2 * (2.0 * m)])),
            acceleration: (
                linear(hem, [-one, cos * -(m * m + 1.0), cos2 * (-4.0 * m)]),
                linear(hem, [zero, sin * (-2.0 * m), sin2 * -(4.0 * m * m + 1.0)]),
            ),
        }
    }

    #[inline(always)]
    pub fn speed(&self) -> Jets<V, N> {
        (self.velocity.0.square() + self.velocity.1.square()).sqrt()
    }
}

/// Everything is linear in p, q, s.
#[inline(always)]
fn linear<V: Vector, const N: usize>(hem: &Hem, by: [V; 3]) -> Jets<V, N> {
    let mut out = Jets::constant(by[0].mul_add(V::all(hem.p), by[1].mul_add(V::all(hem.q), by[2] * hem.s)));
    out.gradient[..N].copy_from_slice(&by[..N]);
    out
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
    let mut level = 0;
    let mut last = mean_speed(hem, level);
    loop {
        level += 1;
        let next = mean_speed(hem, level);
        // As in [`settled_mean`].
        if (last.value - next.value).abs() <= 1e-14 * next.value.abs() || 4096 <= 16 << level {
            return next * TAU;
        }
        last = next;
    }
}

vectorized! {
    /// Of 16 · 2^level nodes in half a fold.
    fn mean_speed<V>(hem: &Hem, level: usize) -> HemJet {
        let nodes = midpoints(level);
        let mut sum = Jets::<V, 3>::constant(V::zero());
        for (cos, sin) in nodes {
            sum = sum + Places::at(hem, (V::of(cos), V::of(sin))).speed();
        }
        sum.sum() * (1.0 / (nodes.len() * WIDTH) as f64)
    }
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

/// How well one of the paper's equations can be made to hold along a curve by its own constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EquationFit {
    /// λ of least squares, N/m².
    pub lambda: f64,
    /// Constant of least squares, N/m.
    pub constant: f64,
    /// Root mean square of what is left, relative to the spread of the equation's left side about its mean: 0 holds, 1 says nothing.
    pub residual: f64,
}

/// Equations (15) to (17) of the paper along one curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equations {
    /// (15): G − λ y′²/v = C_1.
    pub fifteen: EquationFit,
    /// (16): G − λ x′²/v = C_2.
    pub sixteen: EquationFit,
    /// Their sum, the one first integral that a Lagrangian free of t has: 2G − λ v = C_1 + C_2.
    pub sum: EquationFit,
    /// Their difference, the second line of (17): rms of (x′² − y′²)/v about its mean, relative to its rms. It has to be 0 and is 1 on any closed
    /// curve of three or more folds: the tangent turns through all directions.
    pub difference: f64,
}

impl PaperFunctional {
    /// Equations (15) to (17) along the curve, its constants fitted; `None` where the hem reaches further than the slant or is a circle.
    pub fn equations(&self, hem: &Hem) -> Option<Equations> {
        const NODES: usize = 4096;
        let mut rows = Vec::with_capacity(NODES);
        for i in 0..NODES {
            let t = TAU * i as f64 / NODES as f64;
            let (local, (sin, cos)) = (hem.local(t), t.sin_cos());
            let g = self.density(Jet::<0>::constant(local.position.0.hypot(local.position.1)))?.value;
            let velocity = (local.velocity.0 * cos - local.velocity.1 * sin, local.velocity.0 * sin + local.velocity.1 * cos);
            rows.push((g, velocity, local.speed()));
        }
        let fit = |left: &dyn Fn(f64) -> f64, right: &dyn Fn((f64, f64), f64) -> f64| {
            let samples: Vec<(f64, f64)> = rows.iter().map(|(g, velocity, v)| (left(*g), right(*velocity, *v))).collect();
            least_squares(&samples)
        };
        let skewness: Vec<f64> = rows.iter().map(|(_, (x, y), v)| (x * x - y * y) / v).collect();
        let count = NODES as f64;
        let (mean, square) = (skewness.iter().sum::<f64>() / count, skewness.iter().map(|d| d * d).sum::<f64>() / count);
        Some(Equations {
            fifteen: fit(&|g| g, &|(_, y), v| y * y / v)?,
            sixteen: fit(&|g| g, &|(x, _), v| x * x / v)?,
            sum: fit(&|g| 2.0 * g, &|_, v| v)?,
            difference: ((square - mean * mean).max(0.0) / square).sqrt(),
        })
    }
}

/// left = λ right + constant.
fn least_squares(samples: &[(f64, f64)]) -> Option<EquationFit> {
    let count = samples.len() as f64;
    let mean = samples.iter().fold((0.0, 0.0), |m, s| (m.0 + s.0 / count, m.1 + s.1 / count));
    let (mut ll, mut lr, mut rr) = (0.0, 0.0, 0.0);
    for (l, r) in samples.iter().map(|s| (s.0 - mean.0, s.1 - mean.1)) {
        ll += l * l;
        lr += l * r;
        rr += r * r;
    }
    if rr <= 1e-18 * count * mean.1 * mean.1 || ll <= 0.0 {
        return None;
    }
    let lambda = lr / rr;
    Some(EquationFit { lambda, constant: mean.0 - lambda * mean.1, residual: (1.0 - lr * lr / (ll * rr)).max(0.0).sqrt() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::lanes::Lanes;
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
            let (sin, cos) = (5.0 * t).sin_cos();
            let eight = Places::<Lanes, 3>::at(&HEM, (Lanes([cos; WIDTH]), Lanes([sin; WIDTH])));
            let pairs = [(jet.position, eight.position), (jet.velocity, eight.velocity), (jet.acceleration, eight.acceleration)];
            for (jet, eight) in pairs.iter().flat_map(|(a, b)| [(a.0, b.0), (a.1, b.1)]) {
                assert!((jet.value - eight.value.0[0]).abs() < 1e-13);
                assert!((0..3).all(|i| (jet.gradient[i] - eight.gradient[i].0[0]).abs() < 1e-13));
            }
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

    #[test]
    fn paper_s_equations_do_not_hold_along_its_own_curve() {
        let skirt = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap();
        let functional = PaperFunctional::new(&skirt, 1.962, 0.0);
        let equations = functional.equations(&HEM).unwrap();
        // The sum is the relation of `first_integral`: two roads to one number.
        let (lambda, r2) = functional.first_integral(&HEM).unwrap();
        assert!((equations.sum.lambda - lambda.value).abs() < 1e-12);
        assert!((equations.sum.residual - (1.0 - r2).sqrt()).abs() < 1e-9);
        // Birthplace: docs/model.md, section 3: R² = 0.037.
        assert!((equations.sum.residual - (1.0_f64 - 0.037).sqrt()).abs() < 1e-3);
        assert!(0.9 < equations.fifteen.residual && 0.9 < equations.sixteen.residual);
        assert!((equations.difference - 1.0).abs() < 1e-9);
    }
}
