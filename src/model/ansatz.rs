//! The paper's curve as the hem of a ruled shell: its energy, with exact derivatives in p, q, s.
//!
//! The curve is given the material angle by its own arc length, `σ(t) = 2π · arc(t)/Λ`, so that it is as evenly stretched as its length allows; at
//! Λ = 2πR_n it is inextensible, and off it the multiplier of the length is a force. Source: docs/model.md, section 5.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use super::energy::bending::Bending;
use super::energy::gravity::Gravity;
use super::functional::{HemJet, Places};
use super::hem::{Hem, midpoints};
use crate::experiment::Skirt;
use crate::numerics::jet::Jet;
use crate::numerics::lanes::jets::Jets;
use crate::numerics::lanes::product::{Rows, product};
use crate::numerics::lanes::{Lanes, Vector, WIDTH, numbers, sin_cos};
use crate::vectorized;

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
        let mut level = FIRST;
        let mut last = value(self, hem, level)?;
        loop {
            level += 1;
            let next = value(self, hem, level)?;
            // A curve with a near-cusp converges slowly; 512 nodes in half a fold resolve all that cloth can do.
            if (last - next).abs() <= 1e-11 * next.abs() || LAST <= level || !next.is_finite() {
                // Derivatives are worth their time only where the energy holds.
                return if next.is_finite() { expansion(self, hem, level) } else { None };
            }
            last = next;
        }
    }
}

/// Levels of the midpoint rule, 32 to 512 nodes in half a fold.
const FIRST: usize = 1;
const LAST: usize = 5;

/// m times the lag t − σ from the speeds, over the mean speed: rows by node of the speed, lanes by node of the lag.
///
/// The cosine series of the speed is integrated term by term: `Σ_k (2/N) Σ_n v_n cos kφ_n sin kφ/k`, exact to the last resolved mode.
fn lags(level: usize) -> &'static [Lanes] {
    static LAGS: [OnceLock<Vec<Lanes>>; LAST + 1] = [const { OnceLock::new() }; LAST + 1];
    LAGS[level].get_or_init(|| {
        let count = 16 << level;
        let sines: Vec<f64> = (0..2 * count).map(|i| (PI * i as f64 / count as f64).sin()).collect();
        // Σ_k sin(kδ)/k over the resolved modes, on the grid of shifts.
        let shifted: Vec<f64> = (0..2 * count).map(|d| (1..count).map(|k| sines[k * d % (2 * count)] / k as f64).sum()).collect();
        // sin a cos b = (sin(a + b) + sin(a − b))/2, and midpoints differ by whole steps.
        let entry = |from: usize, to: usize| {
            (shifted[(to + from + 1) % (2 * count)] + shifted[(to + 2 * count - from) % (2 * count)]) / count as f64
        };
        let block = |from: usize, block: usize| Lanes(std::array::from_fn(|lane| entry(from, block * WIDTH + lane)));
        (0..count).flat_map(|from| (0..count / WIDTH).map(move |b| block(from, b))).collect()
    })
}

vectorized! {
    /// Gravity and bending together, J.
    fn value<V>(shell: &AnsatzShell, hem: &Hem, level: usize) -> Option<f64> {
        integrals::<V, 0>(shell, hem, level).map(|[gravity, bending]| gravity.value + bending.value)
    }
}

vectorized! {
    fn expansion<V>(shell: &AnsatzShell, hem: &Hem, level: usize) -> Option<AnsatzEnergy> {
        integrals::<V, 3>(shell, hem, level).map(|[gravity, bending]| AnsatzEnergy { gravity, bending })
    }
}

/// Gravity and bending by the midpoint rule, with derivatives by the first N of p, q, s.
#[inline(always)]
fn integrals<V: Vector, const N: usize>(shell: &AnsatzShell, hem: &Hem, level: usize) -> Option<[Jet<N>; 2]> {
    let (nodes, m) = (midpoints(level), f64::from(hem.folds.max(1)));
    let (blocks, parts) = (nodes.len(), Jets::<V, N>::PARTS);
    let mut speeds = vec![Lanes::ZERO; parts * blocks];
    let mut mean = Jets::constant(V::zero());
    for (block, (cos, sin)) in nodes.iter().enumerate() {
        let speed = Places::<V, N>::at(hem, (V::of(cos), V::of(sin))).speed();
        speed.store(&mut speeds, block, blocks);
        mean = mean + speed;
    }
    let count = blocks * WIDTH;
    // |dc/dσ|, the same all round: Λ/2π.
    let radius: Jet<N> = mean.sum() * (1.0 / count as f64);
    let mut lags_of = vec![Lanes::ZERO; parts * blocks];
    product(Rows { numbers: numbers(&speeds), stride: count, inner: count }, lags(level), blocks, &mut lags_of);
    let (radius, inverse) = (Jets::all(&radius), Jets::all(&radius.recip()));
    let (mut gravity, mut bending) = (Jets::constant(V::zero()), Jets::constant(V::zero()));
    let mut short = V::zero();
    for (block, (cos, sin)) in nodes.iter().enumerate() {
        let place = Places::<V, N>::at(hem, (V::of(cos), V::of(sin)));
        let speed = Jets::load(&speeds, block, blocks);
        // e^{i(t − σ)} turns from the frame of t to the frame of σ.
        let lag = Jets::load(&lags_of, block, blocks).scaled(V::all(-1.0 / m)) * inverse;
        let (sin, cos) = sin_cos(lag.value);
        let (sin, cos) = (lag.chain(sin, cos, -sin), lag.chain(cos, -sin, -cos));
        let x = (place.position.0 * cos - place.position.1 * sin).shifted(V::all(-shell.waist));
        let y = place.position.0 * sin + place.position.1 * cos;
        let lean = x.square() + y.square();
        let (rise, reaches) = shell.gravity.densities(lean.value);
        short = short + (V::all(1.0) - reaches);
        let slowness = speed.recip();
        let cos_psi = (place.velocity.0 * sin + place.velocity.1 * cos) * slowness;
        let cross = place.velocity.0 * place.acceleration.1 - place.velocity.1 * place.acceleration.0;
        let twist = (cross * slowness.square() * slowness * radius).shifted(V::all(-1.0));
        let [constant, quadratic] = shell.bending.densities(cos_psi.value, radius.value);
        let constant = Jets::compose(&constant, &cos_psi, &radius);
        let quadratic = Jets::compose(&quadratic, &cos_psi, &radius);
        let measure = (speed * inverse).scaled(V::all(TAU / count as f64));
        gravity = gravity + lean.chain(rise[0], rise[1], rise[2]) * measure;
        bending = bending + (constant + quadratic * twist.square()) * measure;
    }
    (short.sum() == 0.0).then(|| [gravity.sum(), bending.sum()])
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
