//! The paper's curve as the hem of a ruled shell: its energy, with exact derivatives in p, q, s.
//!
//! The curve is given the material angle by its own arc length, `σ(t) = 2π · arc(t)/Λ`, so that it is as evenly stretched as its length allows; at
//! Λ = 2πR_n it is inextensible, and off it the multiplier of the length is a force. Source: docs/model.md, section 5.

use std::f64::consts::{PI, TAU};

use super::energy::bending::Bending;
use super::energy::gravity::Gravity;
use super::functional::{HemJet, HemPoint};
use super::hem::Hem;
use crate::experiment::Skirt;
use crate::numerics::jet::Jet;

/// The ruled shell of one skirt over the paper's curves.
#[derive(Debug, Clone)]
pub struct AnsatzShell {
    waist: f64,
    gravity: Gravity,
    bending: Bending,
}

/// Gravity and bending, J.
#[derive(Debug, Clone, Copy)]
pub struct AnsatzEnergy {
    pub gravity: HemJet,
    pub bending: HemJet,
}

impl AnsatzEnergy {
    pub fn total(&self) -> HemJet {
        self.gravity + self.bending
    }
}

impl AnsatzShell {
    /// `weight` is ρ_A g, N/m²; `rigidity` is B, N·m.
    pub fn new(skirt: &Skirt, weight: f64, rigidity: f64) -> Self {
        AnsatzShell {
            waist: skirt.waist_radius().0,
            gravity: Gravity::new(skirt, weight),
            bending: Bending::new(skirt, rigidity, Bending::NODES),
        }
    }

    /// Energy of the hem; `None` where a generatrix does not reach it. Nodes are doubled until it holds to 1e-11.
    pub fn energy(&self, hem: &Hem) -> Option<AnsatzEnergy> {
        let mut half = 32;
        let mut last = self.energy_on(hem, half)?;
        loop {
            half *= 2;
            let next = self.energy_on(hem, half)?;
            let (a, b) = (last.total().value, next.total().value);
            // A curve with a near-cusp converges slowly; 512 nodes in half a fold resolve all that cloth can do.
            if (a - b).abs() <= 1e-11 * b.abs() || 512 <= half || !b.is_finite() {
                return b.is_finite().then_some(next);
            }
            last = next;
        }
    }

    /// Trapezoid rule on `half` intervals of half a fold.
    fn energy_on(&self, hem: &Hem, half: usize) -> Option<AnsatzEnergy> {
        let m = f64::from(hem.folds.max(1));
        let points: Vec<HemPoint> = (0..=half).map(|n| HemPoint::at(hem, PI * n as f64 / half as f64)).collect();
        let speeds: Vec<HemJet> = points.iter().map(HemPoint::speed).collect();
        let weight = |n: usize| if n == 0 || n == half { 0.5 } else { 1.0 } / half as f64;
        let table: Vec<(f64, f64)> = (0..2 * half).map(|i| (PI * i as f64 / half as f64).sin_cos()).collect();
        // Cosine series of the speed; its integral is a sine series, exact to the last resolved mode.
        let modes: Vec<HemJet> = (0..half)
            .map(|k| (0..=half).fold(Jet::constant(0.0), |sum, n| sum + speeds[n] * (weight(n) * table[n * k % (2 * half)].1)))
            .collect();
        // |dc/dσ|, the same all round: Λ/2π.
        let radius = modes[0];
        let inverse = radius.recip();
        let (mut gravity, mut bending) = (Jet::constant(0.0), Jet::constant(0.0));
        for n in 0..=half {
            let point = &points[n];
            let lag = modes
                .iter()
                .enumerate()
                .skip(1)
                .fold(Jet::constant(0.0), |sum, (k, mode)| sum + *mode * (2.0 * table[n * k % (2 * half)].0 / (k as f64 * m)));
            // e^{i(t − σ)} turns from the frame of t to the frame of σ.
            let (sin, cos) = (-(lag * inverse)).sin_cos();
            let turned = |(x, y): (HemJet, HemJet)| (x * cos - y * sin, x * sin + y * cos);
            let (x, y) = turned(point.position);
            let x = x - self.waist;
            let lean = x.square() + y.square();
            let rise = self.gravity.density(lean.value)?;
            let slowness = speeds[n].recip();
            let cos_psi = turned(point.velocity).1 * slowness;
            let cross = point.velocity.0 * point.acceleration.1 - point.velocity.1 * point.acceleration.0;
            let twist = cross * slowness.square() * slowness * radius - 1.0;
            let (constant, quadratic) = self.bending.density(cos_psi, radius);
            let measure = speeds[n] * inverse * (TAU * weight(n));
            gravity = gravity + lean.chain(rise.value, rise.first, rise.second) * measure;
            bending = bending + (constant + quadratic * twist.square()) * measure;
        }
        Some(AnsatzEnergy { gravity, bending })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::functional::perimeter;
    use crate::units::Metre;

    fn shell() -> AnsatzShell {
        AnsatzShell::new(&Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap(), 1.962, 1e-5)
    }

    #[test]
    fn constrained_optimum_of_the_reference_is_stationary() {
        // Birthplace: docs/model.md, section 5, digits computed outside this crate: U, λ at p, q, s for B 1e-5, 0.2 kg/m², m = 5.
        let hem = Hem { p: 0.13152467, q: 0.05267570, s: 0.00873147, folds: 5 };
        let energy = shell().energy(&hem).unwrap().total();
        let length = perimeter(&hem);
        assert!((energy.value - 0.0021919849).abs() < 2e-10, "{}", energy.value);
        assert!((length.value - TAU * 0.2362).abs() < 2e-7, "{}", length.value);
        for (u, l) in energy.gradient.iter().zip(length.gradient) {
            // Eight digits of p, q, s against curvatures of about 1 J/m².
            assert!((u - 0.0019692184 * l).abs() < 1e-7, "{u} {}", 0.0019692184 * l);
        }
    }

    #[test]
    fn gradient_and_hessian_agree_with_central_differences() {
        let hem = Hem { p: 0.13, q: 0.05, s: 0.01, folds: 5 };
        let at = |d: [f64; 3]| shell().energy(&Hem { p: hem.p + d[0], q: hem.q + d[1], s: hem.s + d[2], ..hem }).unwrap().total();
        let (exact, h) = (at([0.0; 3]), 1e-6);
        for i in 0..3 {
            let step = |sign: f64| at([0, 1, 2].map(|k| if k == i { sign * h } else { 0.0 }));
            let (up, down) = (step(1.0), step(-1.0));
            // Truncation h²U‴/6 ~ 1e-9 with U‴ ~ U/(1 cm)³; for the Hessian one order of 1/(1 cm) more.
            assert!((exact.gradient[i] - (up.value - down.value) / (2.0 * h)).abs() < 1e-8);
            for j in 0..3 {
                assert!((exact.hessian[i][j] - (up.gradient[j] - down.gradient[j]) / (2.0 * h)).abs() < 1e-5);
            }
        }
    }
}
