//! The graded shell: every ring between waist and hem keeps its own cloth length, every generatrix is inextensible and free to curve.
//!
//! Ring at fraction u of the slant, radius `R(u)`: tangent angle `σ + ψ`, `ψ(σ, u) = Σ_k a_k(u) sin kmσ`, so its plan is `e^{iσ} h`, `h = R T e^{iψ}` with T the
//! division by 1 + jm of the tangent-angle family. Height from `∂z/∂ℓ = −√(1 − |∂h/∂ℓ|²)`, z = 0 at the hinged waist, where a_k = 0. Energy: gravity
//! `ρ_A g ∫∫ (z + ℓ) R dℓ dσ`, bending `(B/2) ∫∫ (κ_1² + κ_2²) R dℓ dσ` from the full second fundamental form, and if asked shear `(S/2) ∫∫ γ² R dℓ dσ`,
//! `γ² = g_σℓ²/(g_σσ g_ℓℓ)`. Source: docs/model.md, section 5b.
//!
//! Values (`shape`), gradient (`force`) and exact Hessian (`curvature`, from `moves` and `local`) are written by hand, eight slices to a register (`grid`).

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

mod curvature;
mod density;
mod force;
mod grid;
mod local;
mod moves;
mod shape;

pub use super::height::HeightBasis;
use super::tangent::{kernel, per_length};
use crate::experiment::Skirt;
use crate::numerics::lanes::WIDTH;
use crate::numerics::minimize::{Expansion, Smooth};
use crate::numerics::quadrature::{gauss_legendre, running_integral};
use curvature::hessian;
use force::forces;
use grid::{Band, Grid};
use shape::Shape;

/// Material and size of the discretization.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// ρ_A g, N/m²; 0 leaves gravity out.
    pub weight: f64,
    /// B, N·m; 0 leaves bending out.
    pub rigidity: f64,
    /// S, N/m; 0 leaves shear free.
    pub shear: f64,
    pub folds: u32,
    /// K.
    pub harmonics: usize,
    /// J.
    pub modes: usize,
    pub basis: HeightBasis,
    /// Intervals in half a fold.
    pub half: usize,
    /// Gauss–Legendre nodes from waist to hem.
    pub slices: usize,
}

/// Energy term by term, J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradedBudget {
    pub gravity: f64,
    pub bending: f64,
    pub shear: f64,
}

/// The graded shell of one skirt, discretized. Unknowns α_kj, index k·J + j (k from harmonic 1).
#[derive(Debug, Clone)]
pub struct GradedShell {
    setup: Setup,
    hem: f64,
    /// dR/dℓ.
    pub(super) growth: f64,
    /// Trapezoid weights of the half period; they sum to 2π.
    pub(super) weights: Vec<f64>,
    pub(super) sines: DMatrix<f64>,
    pub(super) slopes: DMatrix<f64>,
    pub(super) kernel: DMatrix<f64>,
    pub(super) slices: Vec<Slice>,
    /// Row q: weights of ∫₀^{ℓ_q} dℓ on the slices, m.
    pub(super) running: Vec<Vec<f64>>,
    grid: Grid,
}

#[derive(Debug, Clone)]
pub(super) struct Slice {
    /// Fraction of the way from waist to hem along the slant.
    pub fraction: f64,
    /// R, m.
    pub ring: f64,
    /// R of the cloth as it was cut, m: its area, which a stretch of the ring does not change.
    pub cloth: f64,
    /// Weight of ∫ dℓ, m.
    pub weight: f64,
    /// ∫ R dℓ from here to the hem, m²: what hangs below.
    pub below: f64,
    pub basis: Vec<[f64; 3]>,
}

impl GradedShell {
    pub fn new(skirt: &Skirt, setup: Setup) -> Self {
        let (waist, hem, slant) = (skirt.waist_radius().0, skirt.hem_radius().0, skirt.slant_length().0);
        let (m, half, count) = (f64::from(setup.folds), setup.half, setup.half + 1);
        let table: Vec<(f64, f64)> = (0..2 * half).map(|i| (PI * i as f64 / half as f64).sin_cos()).collect();
        let rule = gauss_legendre(setup.slices);
        let slices: Vec<Slice> = rule
            .iter()
            .map(|(s, w)| {
                let (u, du, _) = setup.basis.height(*s);
                Slice {
                    fraction: u,
                    ring: waist + u * (hem - waist),
                    cloth: waist + u * (hem - waist),
                    weight: w * du * slant,
                    below: slant * (1.0 - u) * (waist + 0.5 * (1.0 + u) * (hem - waist)),
                    basis: setup.basis.functions(*s, setup.modes, slant),
                }
            })
            .collect();
        let mut running = running_integral(setup.slices);
        for (j, (s, _)) in rule.iter().enumerate() {
            let measure = setup.basis.height(*s).1 * slant;
            running.iter_mut().for_each(|row| row[j] *= measure);
        }
        let kernel = kernel(1.0, m, half, &table);
        let growth = (hem - waist) / slant;
        let weights: Vec<f64> = (0..count).map(|n| PI / half as f64 * if n == 0 || n == half { 1.0 } else { 2.0 }).collect();
        let wave = |n: usize, k: usize| {
            let (sin, cos) = table[n * k % (2 * half)];
            [sin, m * k as f64 * cos]
        };
        let grid = Grid {
            nodes: count,
            slices: setup.slices,
            blocks: setup.slices.div_ceil(WIDTH),
            harmonics: setup.harmonics,
            modes: setup.modes,
            growth,
            weights: weights.clone(),
            waves: (0..count).flat_map(|n| (1..=setup.harmonics).map(move |k| (n, k))).map(|(n, k)| wave(n, k)).collect(),
            bands: Band::all(&slices, 0.0),
            basis: Grid::basis(&slices, setup.modes),
            around: kernel.transpose().as_slice().to_vec(),
            around_back: kernel.as_slice().to_vec(),
            along: Grid::along(&running, false),
            along_back: Grid::along(&running, true),
        };
        GradedShell {
            setup,
            hem,
            growth,
            weights,
            sines: DMatrix::from_fn(count, setup.harmonics, |n, k| wave(n, k + 1)[0]),
            slopes: DMatrix::from_fn(count, setup.harmonics, |n, k| wave(n, k + 1)[1]),
            kernel,
            slices,
            running,
            grid,
        }
    }

    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Energy term by term; `None` where a generatrix would have to be longer than its cloth.
    pub fn budget(&self, alpha: &DVector<f64>) -> Option<GradedBudget> {
        let shape = Shape::of(&self.grid, alpha.as_slice())?;
        let [gravity, bending, shear] = shape.energies(&self.grid, &self.setup);
        Some(GradedBudget { gravity, bending, shear })
    }

    /// Mean Lagrange multiplier of the hem's length, N: by how much the energy of the shape with coefficients `alpha` changes per metre of hem.
    ///
    /// Cloth and waist stay as they are; the rings between are lengthened in proportion to their distance from the waist. At a minimum over
    /// `alpha` it is the derivative of the least energy. Central difference: right to about nine digits.
    pub fn length_multiplier(&self, alpha: &DVector<f64>) -> Option<f64> {
        self.length_multiplier_at(self.setup.rigidity, alpha)
    }

    /// The same for cloth of flexural rigidity `rigidity`, N·m.
    pub fn length_multiplier_at(&self, rigidity: f64, alpha: &DVector<f64>) -> Option<f64> {
        let setup = Setup { rigidity, ..self.setup };
        per_length(self.hem, |by| {
            let grid = self.grid.lengthened(by, self.growth_of(by), &self.slices);
            Some(Shape::of(&grid, alpha.as_slice())?.energies(&grid, &setup).iter().sum())
        })
    }

    /// Growth of R per metre of slant where the hem's radius has grown by `by`, m: the waist stays.
    fn growth_of(&self, by: f64) -> f64 {
        self.growth + by / self.slices.iter().map(|slice| slice.weight).sum::<f64>()
    }

    /// The same cloth with its hem's radius grown by `by`, m.
    pub(super) fn lengthened(&self, by: f64) -> GradedShell {
        let mut longer = self.clone();
        longer.hem += by;
        longer.growth = self.growth_of(by);
        longer.grid = self.grid.lengthened(by, longer.growth, &self.slices);
        for slice in &mut longer.slices {
            slice.ring += slice.fraction * by;
        }
        longer
    }

    /// a_k at the hem, for k = 1 … K: there s = 1 and every T_j is 1.
    pub fn hem_coefficients(&self, alpha: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(self.setup.harmonics, |k, _| alpha.rows(k * self.setup.modes, self.setup.modes).sum())
    }

    /// R_n, m.
    pub fn hem_radius(&self) -> f64 {
        self.hem
    }

    /// The derivatives of the energy by the coefficients, J, of cloth of flexural rigidity `rigidity` (N·m); `None` where [`GradedShell::budget`] is.
    pub fn gradient_at(&self, rigidity: f64, alpha: &DVector<f64>) -> Option<DVector<f64>> {
        let setup = Setup { rigidity, ..self.setup };
        let shape = Shape::of(&self.grid, alpha.as_slice())?;
        Some(DVector::from_vec(forces(&self.grid, &setup, &shape).1))
    }

    /// The expansion for cloth of flexural rigidity `rigidity`, N·m, in place of the shell's own.
    pub fn expand_at(&self, rigidity: f64, alpha: &DVector<f64>) -> Option<Expansion> {
        let (n, setup) = (alpha.len(), Setup { rigidity, ..self.setup });
        let shape = Shape::of(&self.grid, alpha.as_slice())?;
        let value = shape.energies(&self.grid, &setup).iter().sum();
        let (forces, gradient) = forces(&self.grid, &setup, &shape);
        let mut hessian = DMatrix::from_vec(n, n, hessian(&self.grid, &setup, &shape, &forces));
        // Exact derivatives are symmetric up to rounding; the eigenvalue solver wants them exactly so.
        for i in 0..n {
            for j in 0..i {
                let mean = 0.5 * (hessian[(i, j)] + hessian[(j, i)]);
                (hessian[(i, j)], hessian[(j, i)]) = (mean, mean);
            }
        }
        Some(Expansion { value, gradient: DVector::from_vec(gradient), hessian })
    }
}

impl Smooth for GradedShell {
    fn expand(&self, alpha: &DVector<f64>) -> Option<Expansion> {
        self.expand_at(self.setup.rigidity, alpha)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Metre;

    fn shell(basis: HeightBasis, harmonics: usize, modes: usize, shear: f64) -> GradedShell {
        let skirt = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap();
        let setup = Setup { weight: 1.962, rigidity: 1e-5, shear, folds: 5, harmonics, modes, basis, half: 24, slices: 24 };
        GradedShell::new(&skirt, setup)
    }

    #[test]
    fn energy_at_the_reference_coefficients_is_the_reference_energy() {
        // Birthplace: docs/model.md, section 5b: K 1, J 4 in the polynomial basis; α printed to six digits, and the energy is stationary there.
        let alpha = DVector::from_vec(vec![2.441794, -1.448642, 0.425606, -0.094354]);
        let budget = shell(HeightBasis::Polynomial, 1, 4, 0.0).budget(&alpha).unwrap();
        assert!((budget.gravity + budget.bending - 0.0033096787).abs() < 1e-10);
    }

    #[test]
    fn length_multiplier_of_a_round_limp_cone_is_the_closed_form() {
        // Without rigidity the cone's energy is weight·∫∫ below (1 − √(1 − g²)) dℓ dσ with g = (R_n − R_t)/L; its derivative by R_n over 2π:
        let (waist, hem, slant, weight) = (0.121_f64, 0.2362_f64, 0.53_f64, 1.962);
        let growth = (hem - waist) / slant;
        let below = slant * slant * (0.5 * waist + (hem - waist) / 3.0);
        let exact = weight * below * growth / (1.0 - growth * growth).sqrt() / slant;
        let skirt = Skirt::new(Metre(waist), Metre(hem), Metre(slant)).unwrap();
        let setup = Setup { rigidity: 0.0, ..*shell(HeightBasis::Polynomial, 1, 2, 0.0).setup() };
        let found = GradedShell::new(&skirt, setup).length_multiplier(&DVector::zeros(2)).unwrap();
        // Central differences keep nine digits.
        assert!((found / exact - 1.0).abs() < 1e-8, "{found} {exact}");
    }

    #[test]
    fn gradient_and_hessian_agree_with_central_differences() {
        let layer = HeightBasis::Layer { width: 0.05 };
        // Slices that fill their registers, and slices that do not; every term.
        let cases = [(HeightBasis::Polynomial, 2, 3, 24, 0.0), (layer, 2, 3, 24, 0.02), (layer, 3, 4, 13, 0.0), (layer, 1, 2, 7, 0.5)];
        for (basis, harmonics, modes, slices, shear) in cases {
            let setup = Setup { slices, ..*shell(basis, harmonics, modes, shear).setup() };
            let shell = GradedShell::new(&Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap(), setup);
            let n = harmonics * modes;
            let alpha = DVector::from_fn(n, |i, _| if i == 0 { 1.3 } else { 0.3 * (2.5 * i as f64).cos() / (1 + i) as f64 });
            let exact = shell.expand(&alpha).unwrap();
            let h = 1e-5;
            for k in 0..n {
                let step = DVector::from_fn(n, |i, _| if i == k { h } else { 0.0 });
                let (up, down) = (shell.expand(&(&alpha + &step)).unwrap(), shell.expand(&(&alpha - &step)).unwrap());
                let scale = exact.hessian.amax();
                // Truncation h²f‴/6 ~ 1e-10 and rounding eps/h ~ 2e-11, both relative to the scale of the function.
                assert!((exact.gradient[k] - (up.value - down.value) / (2.0 * h)).abs() < 1e-8 * scale, "{setup:?} {k}");
                assert!((exact.hessian.column(k) - (up.gradient - down.gradient) / (2.0 * h)).amax() < 1e-7 * scale, "{setup:?} {k}");
            }
        }
    }

    #[test]
    fn cloth_of_another_rigidity_is_a_shell_of_its_own() {
        let basis = HeightBasis::Layer { width: 0.05 };
        let alpha = DVector::from_vec(vec![1.3, -0.3, 0.1, -0.1, 0.05, 0.02]);
        let shell = shell(basis, 2, 3, 0.02);
        let setup = Setup { rigidity: 4e-5, ..*shell.setup() };
        let stiff = GradedShell::new(&Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap(), setup);
        let (own, other) = (stiff.expand(&alpha).unwrap(), shell.expand_at(4e-5, &alpha).unwrap());
        assert_eq!((own.value, &own.gradient, own.hessian), (other.value, &other.gradient, other.hessian));
        assert_eq!(shell.gradient_at(4e-5, &alpha).unwrap(), own.gradient);
        assert_eq!(stiff.length_multiplier(&alpha), shell.length_multiplier_at(4e-5, &alpha));
    }

    #[test]
    fn slices_that_only_fill_a_register_change_nothing() {
        // Of 23 slices one lane is left over, of 24 none.
        let energy = |slices: usize| {
            let setup = Setup { slices, ..*shell(HeightBasis::Layer { width: 0.3 }, 1, 2, 0.01).setup() };
            let shell = GradedShell::new(&Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap(), setup);
            shell.budget(&DVector::from_vec(vec![0.4, -0.1])).unwrap()
        };
        let (odd, even) = (energy(23), energy(24));
        for (a, b) in [(odd.gravity, even.gravity), (odd.bending, even.bending), (odd.shear, even.shear)] {
            // Gauss–Legendre converges geometrically; 23 nodes are far beyond rounding here.
            assert!((a / b - 1.0).abs() < 1e-11, "{a} {b}");
        }
    }

    #[test]
    fn generatrices_that_are_too_short_have_no_energy() {
        let shell = shell(HeightBasis::Layer { width: 0.05 }, 1, 2, 0.0);
        let alpha = DVector::from_vec(vec![40.0, 0.0]);
        assert!(shell.budget(&alpha).is_none() && shell.expand(&alpha).is_none());
        assert!(shell.budget(&DVector::from_vec(vec![f64::NAN, 0.0])).is_none());
    }
}
