//! The hems of m folds in equilibrium, and how they move with the cloth: the coefficients a_k as functions of B/(ρ_A g).
//!
//! Energy over weight is G + x U, x = B/(ρ_A g). At a stationary hem ∇G + x∇U = 0, and so `H da/d ln x = −x∇U = ∇G` with H the Hessian: the derivative is as
//! exact as the hem. Cloth is inverted through this (`study::identify`).

use nalgebra::{DMatrix, DVector};

use super::{graded, ruled};
use crate::experiment::Skirt;
use crate::model::energy::bending::Bending;
use crate::model::graded::{GradedShell, HeightBasis, Setup};
use crate::model::tangent::{RuledShell, half_nodes};
use crate::numerics::minimize::{Ending, Expansion, Minimum, Options, Smooth, minimize};

/// Which energy a hem is stationary in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Energy {
    /// Straight generatrices, K harmonics.
    Ruled { harmonics: usize },
    /// Every ring inextensible, K harmonics by J modes.
    Graded { harmonics: usize, modes: usize },
}

/// The family of equilibria of one cut and fold count.
#[derive(Debug, Clone)]
pub struct Equilibria<'a> {
    skirt: &'a Skirt,
    energy: Energy,
    folds: u32,
    /// Of unit weight and rigidity.
    shell: Shell,
}

/// One hem in equilibrium.
#[derive(Debug, Clone)]
pub struct Equilibrium {
    /// ln of B/(ρ_A g) in m³.
    pub log_ratio: f64,
    /// a_1 … a_K at the hem, a_1 > 0.
    pub coefficients: DVector<f64>,
    /// Their derivatives by ln B/(ρ_A g).
    pub derivatives: DVector<f64>,
    pub evaluations: usize,
    /// All unknowns and their derivatives: where a neighbour starts from.
    unknowns: DVector<f64>,
    slope: DVector<f64>,
}

/// Both shells, as what this file needs of them.
#[derive(Debug, Clone)]
enum Shell {
    Ruled(Box<RuledShell>),
    Graded(Box<GradedShell>),
}

/// A shell of unit weight and a given rigidity.
struct Stiff<'a> {
    shell: &'a Shell,
    ratio: f64,
}

impl Smooth for Stiff<'_> {
    fn expand(&self, x: &DVector<f64>) -> Option<Expansion> {
        match self.shell {
            Shell::Ruled(shell) => shell.expand_stiffer(self.ratio, x),
            Shell::Graded(shell) => shell.expand_at(self.ratio, x),
        }
    }
}

impl Shell {
    /// `layer` is B/(ρ_A g) for which the layer below the waist is resolved, m³; graded only.
    fn new(skirt: &Skirt, energy: Energy, folds: u32, layer: f64) -> Shell {
        match energy {
            Energy::Ruled { harmonics } => {
                Shell::Ruled(Box::new(RuledShell::new(skirt, 1.0, 1.0, folds, harmonics, half_nodes(harmonics), Bending::NODES)))
            }
            Energy::Graded { harmonics, modes } => {
                let width = (layer.cbrt() / skirt.slant_length().0).clamp(1e-4, 1.0);
                let (half, slices) = (16.max(6 * harmonics), 16.max(2 * modes + 4));
                let basis = HeightBasis::Layer { width };
                let setup = Setup { weight: 1.0, rigidity: 1.0, shear: 0.0, folds, harmonics, modes, basis, half, slices };
                Shell::Graded(Box::new(GradedShell::new(skirt, setup)))
            }
        }
    }

    /// ∇G, the derivatives of the energy of limp cloth.
    fn gravity_gradient(&self, x: &DVector<f64>) -> Option<DVector<f64>> {
        match self {
            Shell::Ruled(shell) => shell.gravity_gradient(x),
            Shell::Graded(shell) => shell.gradient_at(0.0, x),
        }
    }
}

/// Newton takes about six steps from a neighbour.
const EVALUATIONS: u64 = 60;

impl<'a> Equilibria<'a> {
    /// `ratio` is about B/(ρ_A g), m³, for the layer below the waist; it matters little.
    pub fn new(skirt: &'a Skirt, energy: Energy, folds: u32, ratio: f64) -> Self {
        Equilibria { skirt, energy, folds, shell: Shell::new(skirt, energy, folds, ratio) }
    }

    /// ln of the B/(ρ_A g) above which the round cone is stable against these folds; `None` if it is so at any.
    pub fn threshold(&self) -> Option<f64> {
        let ratio = match self.energy {
            Energy::Ruled { .. } => ruled::threshold_rigidity(self.skirt, 1.0, self.folds),
            Energy::Graded { .. } => graded::threshold_rigidity(self.skirt, 1.0, 0.0, self.folds),
        };
        ratio.map(f64::ln)
    }

    fn unknowns(&self) -> usize {
        match self.energy {
            Energy::Ruled { harmonics } => harmonics,
            Energy::Graded { harmonics, modes } => harmonics * modes,
        }
    }

    /// The hem at this ln B/(ρ_A g), from a neighbour if there is one; `None` where the folds vanish or slide to another count, or where no generatrix
    /// reaches the hem.
    pub fn at(&self, log_ratio: f64, neighbour: Option<&Equilibrium>) -> Option<Equilibrium> {
        let stiff = Stiff { shell: &self.shell, ratio: log_ratio.exp() };
        let n = self.unknowns();
        let start = match neighbour {
            Some(near) => &near.unknowns + &near.slope * (log_ratio - near.log_ratio),
            None => {
                let mut first = DVector::zeros(n);
                first[0] = 1.0;
                first
            }
        };
        let minimum = descend(&stiff, start, neighbour)?;
        if minimum.ending == Ending::EvaluationLimit {
            return None;
        }
        let mut evaluations = minimum.evaluations;
        let solved = minimum.at.hessian.clone().cholesky()?;
        // x∇U = −∇G there.
        let gravity = self.shell.gravity_gradient(&minimum.x)?;
        evaluations += 1;
        let slope = solved.solve(&gravity);
        let (hem, by) = match &self.shell {
            Shell::Ruled(_) => (minimum.x.clone(), slope.clone()),
            Shell::Graded(shell) => (shell.hem_coefficients(&minimum.x), shell.hem_coefficients(&slope)),
        };
        // Without folds, or with those of a multiple of m, there is no a_1.
        let first = hem[0].abs();
        if first < 1e-3 || first < 1e-3 * hem.amax() {
            return None;
        }
        let flip = |v: DVector<f64>| if hem[0] < 0.0 { flipped(&v) } else { v };
        Some(Equilibrium { log_ratio, coefficients: flip(hem.clone()), derivatives: flip(by), evaluations, unknowns: minimum.x, slope })
    }

    /// The multiplier of the length of a hem of this family over ρ_A g, m².
    pub fn multiplier(&self, hem: &Equilibrium) -> Option<f64> {
        let ratio = hem.log_ratio.exp();
        match &self.shell {
            Shell::Ruled(shell) => shell.length_multiplier_stiffer(ratio, &hem.unknowns),
            Shell::Graded(shell) => shell.length_multiplier_at(ratio, &hem.unknowns),
        }
    }
}

/// Downhill from `start`, drawn in until it is within reach.
fn descend(stiff: &Stiff<'_>, mut start: DVector<f64>, neighbour: Option<&Equilibrium>) -> Option<Minimum> {
    // A neighbour's hem is near: a long first step would leave its branch.
    let radius = if neighbour.is_some() { 0.2 } else { 0.5 };
    let options = Options { evaluations: EVALUATIONS, radius, ..Options::default() };
    for _ in 0..20 {
        if let Some(minimum) = minimize(stiff, start.clone(), &options) {
            return Some(minimum);
        }
        start *= 0.7;
    }
    None
}

/// The same hem shifted by half a fold: odd coefficients change their signs.
pub fn flipped(a: &DVector<f64>) -> DVector<f64> {
    DVector::from_fn(a.len(), |k, _| if k.is_multiple_of(2) { -a[k] } else { a[k] })
}

/// The ratio B/(ρ_A g) that best meets the conditions ∇G + x∇U = 0 of the ruled energy at given coefficients, m³: linear least squares weighted by the
/// covariance of the conditions that follows from that of the coefficients. `None` where no positive ratio does.
///
/// Errors of the coefficients draw it towards 0; it serves as a start.
pub fn stationary_ratio(skirt: &Skirt, folds: u32, a: &DVector<f64>, covariance: &DMatrix<f64>) -> Option<f64> {
    let k = a.len();
    let shell = |weight: f64, rigidity: f64| RuledShell::new(skirt, weight, rigidity, folds, k, half_nodes(k), Bending::NODES).expand(a);
    let (gravity, bending) = (shell(1.0, 0.0)?, shell(0.0, 1.0)?);
    let mut ratio: Option<f64> = None;
    for _ in 0..10 {
        let weight = match ratio {
            // Unweighted at first.
            None => DMatrix::identity(k, k),
            Some(x) => {
                let hessian = &gravity.hessian + &bending.hessian * x;
                (&hessian * covariance * &hessian).try_inverse()?
            }
        };
        let weighed = &weight * &bending.gradient;
        let next = -gravity.gradient.dot(&weighed) / bending.gradient.dot(&weighed);
        let still = ratio.is_some_and(|x| (next / x - 1.0).abs() < 1e-6);
        if !(next.is_finite() && 0.0 < next) {
            return ratio;
        }
        ratio = Some(next);
        if still {
            break;
        }
    }
    ratio
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Metre;

    fn skirt() -> Skirt {
        Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap()
    }

    #[test]
    fn derivatives_by_the_cloth_agree_with_central_differences() {
        let skirt = skirt();
        for (energy, tolerance) in [(Energy::Ruled { harmonics: 4 }, 1e-6), (Energy::Graded { harmonics: 2, modes: 4 }, 1e-5)] {
            let family = Equilibria::new(&skirt, energy, 5, 5e-6);
            let log = (1e-5_f64 / 1.962).ln();
            let middle = family.at(log, None).unwrap();
            let h = 1e-3;
            let (up, down) = (family.at(log + h, Some(&middle)).unwrap(), family.at(log - h, Some(&middle)).unwrap());
            let numeric = (&up.coefficients - &down.coefficients) / (2.0 * h);
            // Truncation h²a‴/6 with a‴ of order one; the minima hold to 1e-9 and more.
            assert!((&numeric - &middle.derivatives).amax() < tolerance, "{numeric} {}", middle.derivatives);
        }
    }

    #[test]
    fn ruled_equilibrium_is_the_reference_hem() {
        let skirt = skirt();
        let family = Equilibria::new(&skirt, Energy::Ruled { harmonics: 4 }, 5, 5e-6);
        let hem = family.at((1e-5_f64 / 1.962).ln(), None).unwrap();
        // Birthplace: docs/model.md, section 5, K = 4.
        for (a, exact) in hem.coefficients.iter().zip([1.37939306, -0.10637115, 0.03324207, -0.01015419]) {
            assert!((a - exact).abs() < 1e-7, "{a} {exact}");
        }
        // Stationarity is linear in the ratio: without errors it gives it back.
        let ratio = stationary_ratio(&skirt, 5, &hem.coefficients, &DMatrix::identity(4, 4)).unwrap();
        assert!((ratio * 1.962 / 1e-5 - 1.0).abs() < 1e-6, "{ratio}");
    }
}
