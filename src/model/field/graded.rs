//! The graded shell's form: a solution of it, sampled with its derivatives.

use std::f64::consts::{PI, TAU};

use nalgebra::DVector;

use super::sample::{Grid, Sample};
use crate::experiment::Skirt;
use crate::model::graded::Setup;
use crate::model::surface::Space;
use crate::model::tangent::{half_nodes, kernel};
use crate::numerics::quadrature::gauss_legendre;

/// A solution of the graded shell: its discretization and coefficients α, a crest on the x axis.
#[derive(Debug, Clone, PartialEq)]
pub struct GradedShape {
    pub setup: Setup,
    /// Index k·J + j.
    pub alpha: Vec<f64>,
}

/// Position in the frame of the ring's tangent and all derivatives at the nodes of half a fold.
struct Ring {
    /// ψ, (Re h, Im h).
    psi: Vec<f64>,
    h: Vec<[f64; 2]>,
    /// X_ℓ and X_ℓℓ in plan.
    lean: Vec<[f64; 2]>,
    bend: Vec<[f64; 2]>,
    /// ψ_σ, ψ_ℓ.
    psi_sigma: Vec<f64>,
    psi_l: Vec<f64>,
    /// c = −∂z/∂ℓ and its derivatives by σ.
    fall: Vec<[f64; 3]>,
    radius: f64,
}

impl GradedShape {
    /// `rows` rings, denser below the waist where the folds open, and `2·shown·m` columns. `None` where a generatrix would have to be longer than its cloth.
    pub fn sample(&self, skirt: &Skirt, rows: usize, shown: usize) -> Option<Grid> {
        // The series of a ring wants its own number of nodes, however few of them are shown.
        let stride = (2 * half_nodes(self.setup.harmonics)).div_ceil(shown);
        let half = shown * stride;
        let (waist, hem, slant) = (skirt.waist_radius().0, skirt.hem_radius().0, skirt.slant_length().0);
        let m = f64::from(self.setup.folds);
        let table: Vec<(f64, f64)> = (0..2 * half).map(|i| (PI * i as f64 / half as f64).sin_cos()).collect();
        let kernel = kernel(1.0, m, half, &table);
        let growth = (hem - waist) / slant;
        let (harmonics, modes, count) = (self.setup.harmonics, self.setup.modes, half + 1);
        let ring = |s: f64| -> Option<Ring> {
            let (u, _, _) = self.setup.basis.height(s);
            let functions = self.setup.basis.functions(s, modes, slant);
            let radius = waist + u * (hem - waist);
            // a_k and two derivatives by ℓ.
            let a: Vec<[f64; 3]> = (0..harmonics)
                .map(|k| [0, 1, 2].map(|d| functions.iter().zip(&self.alpha[k * modes..]).map(|(f, alpha)| alpha * f[d]).sum()))
                .collect();
            let (mut psi, mut psi_sigma, mut psi_l, mut psi_ll, mut psi_sigma_l) =
                (vec![0.0; count], vec![0.0; count], vec![0.0; count], vec![0.0; count], vec![0.0; count]);
            for n in 0..count {
                for (k, a) in a.iter().enumerate() {
                    let (sin, cos) = table[n * (k + 1) % (2 * half)];
                    let order = m * (k + 1) as f64;
                    psi[n] += a[0] * sin;
                    psi_l[n] += a[1] * sin;
                    psi_ll[n] += a[2] * sin;
                    psi_sigma[n] += a[0] * order * cos;
                    psi_sigma_l[n] += a[1] * order * cos;
                }
            }
            // Sources in the turning frame: R e^{iψ} and its derivatives by ℓ.
            let image = |real: &dyn Fn(usize) -> f64, imaginary: &dyn Fn(usize) -> f64| -> Vec<[f64; 2]> {
                let source = DVector::from_fn(2 * count, |i, _| {
                    let n = i % count;
                    let ((sin, cos), (x, y)) = (psi[n].sin_cos(), (real(n), imaginary(n)));
                    if i < count { x * cos - y * sin } else { x * sin + y * cos }
                });
                let out = &kernel * source;
                (0..count).map(|n| [out[n], out[count + n]]).collect()
            };
            let h = image(&|_| radius, &|_| 0.0);
            let h1 = image(&|_| growth, &|n| radius * psi_l[n]);
            let h2 = image(&|n| -radius * psi_l[n] * psi_l[n], &|n| 2.0 * growth * psi_l[n] + radius * psi_ll[n]);
            // Into the frame of the ring's tangent.
            let turned = |h: &[[f64; 2]]| -> Vec<[f64; 2]> {
                h.iter()
                    .zip(&psi)
                    .map(|([x, y], psi)| {
                        let (sin, cos) = psi.sin_cos();
                        [x * cos + y * sin, y * cos - x * sin]
                    })
                    .collect()
            };
            let (lean, bend) = (turned(&h1), turned(&h2));
            let mut fall = Vec::with_capacity(count);
            for n in 0..count {
                let [x, y] = lean[n];
                let square = 1.0 - x * x - y * y;
                if square.is_nan() || square <= 0.0 {
                    return None;
                }
                let c = square.sqrt();
                let (a, t) = (-radius * psi_l[n], psi_sigma[n] + 1.0);
                let (vx, vy) = (-t * growth - psi_sigma_l[n] * radius, t * a);
                let c_sigma = -(x * a + y * growth) / c;
                let c_sigma_sigma = -(a * a + x * vx + y * vy + c_sigma * c_sigma + growth * growth) / c;
                fall.push([c, c_sigma, c_sigma_sigma]);
            }
            Some(Ring { psi, h, lean, bend, psi_sigma, psi_l, fall, radius })
        };
        // Height and its derivatives by σ: integrals from the waist, Gauss–Legendre from row to row.
        let rule = gauss_legendre(6);
        let mut height = vec![[0.0; 3]; count];
        let (mut half_fold, mut slant_distance): (Vec<Vec<Sample>>, Vec<f64>) = (Vec::new(), Vec::new());
        for row in 0..rows {
            let s = row as f64 / (rows - 1) as f64;
            if 0 < row {
                let (from, width) = ((row - 1) as f64 / (rows - 1) as f64, 1.0 / (rows - 1) as f64);
                for (x, weight) in &rule {
                    let at = from + width * x;
                    let measure = weight * width * self.setup.basis.height(at).1 * slant;
                    for (z, fall) in height.iter_mut().zip(ring(at)?.fall) {
                        (0..3).for_each(|d| z[d] -= measure * fall[d]);
                    }
                }
            }
            let ring = ring(s)?;
            let place = |n: usize| world(&ring, n, PI * n as f64 / (m * half as f64), growth, height[n]);
            half_fold.push((0..=shown).map(|i| place(i * stride)).collect());
            slant_distance.push(self.setup.basis.height(s).0 * slant);
        }
        let columns = 2 * shown * self.setup.folds as usize;
        let mut samples = Vec::with_capacity(rows * columns);
        for row in &half_fold {
            for column in 0..columns {
                let (fold, within) = (column / (2 * shown), column % (2 * shown));
                let turn = TAU * fold as f64 / m;
                samples.push(if within <= shown {
                    rotated(&row[within], turn)
                } else {
                    rotated(&mirrored(&row[2 * shown - within]), turn + TAU / m)
                });
            }
        }
        Some(Grid {
            slant_distance,
            sigma: (0..columns).map(|j| TAU * j as f64 / columns as f64).collect(),
            sigma_rate: vec![1.0; columns],
            samples,
        })
    }
}

/// One node of half a fold in the frame of the crest.
fn world(ring: &Ring, n: usize, sigma: f64, growth: f64, [z, z_sigma, z_sigma_sigma]: [f64; 3]) -> Sample {
    let turned = |[x, y]: [f64; 2], angle: f64, z: f64| -> Space {
        let (sin, cos) = angle.sin_cos();
        [x * cos - y * sin, x * sin + y * cos, z]
    };
    let angle = sigma + ring.psi[n];
    let (radius, t, [c, c_sigma, _]) = (ring.radius, ring.psi_sigma[n] + 1.0, ring.fall[n]);
    let ([x, y], [x2, y2]) = (ring.lean[n], ring.bend[n]);
    Sample {
        position: turned(ring.h[n], sigma, z),
        by_ring: turned([0.0, radius], angle, z_sigma),
        by_slant: turned([x, y], angle, -c),
        ring_ring: turned([-radius * t, 0.0], angle, z_sigma_sigma),
        ring_slant: turned([-radius * ring.psi_l[n], growth], angle, -c_sigma),
        slant_slant: turned([x2, y2], angle, (x * x2 + y * y2) / c),
    }
}

/// The point at −σ: folds are symmetric about their crests.
fn mirrored(s: &Sample) -> Sample {
    let flip = |v: Space, sign: f64| -> Space { [sign * v[0], -sign * v[1], sign * v[2]] };
    Sample {
        position: flip(s.position, 1.0),
        by_ring: flip(s.by_ring, -1.0),
        by_slant: flip(s.by_slant, 1.0),
        ring_ring: flip(s.ring_ring, 1.0),
        ring_slant: flip(s.ring_slant, -1.0),
        slant_slant: flip(s.slant_slant, 1.0),
    }
}

fn rotated(s: &Sample, angle: f64) -> Sample {
    let (sin, cos) = angle.sin_cos();
    let turn = |v: Space| -> Space { [v[0] * cos - v[1] * sin, v[0] * sin + v[1] * cos, v[2]] };
    Sample {
        position: turn(s.position),
        by_ring: turn(s.by_ring),
        by_slant: turn(s.by_slant),
        ring_ring: turn(s.ring_ring),
        ring_slant: turn(s.ring_slant),
        slant_slant: turn(s.slant_slant),
    }
}
