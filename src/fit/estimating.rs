//! The estimating equations of a fit, Σ wᵢ Jᵢ (dᵢ − bᵢ) = 0, and their root near a curve that is known already.
//!
//! dᵢ is the signed distance of point i (positive outside), `Jᵢ = −n·∂c/∂θ` at its foot, wᵢ how often it counts, bᵢ what its mean distance
//! is taken to be. With b = 0 the root is the least-squares optimum, with b held it is that of the distances so shifted, and with
//! `bᵢ = ½σ̂²κᵢ` it is the optimum without the bias of curvature. Gauss–Newton, damped where the sum of squares would rise; the perimeter may be held,
//! and any unknown may stay where it is.

use nalgebra::{SMatrix, SVector};

use super::foot_point::follow_all;
use super::orthogonal::curve;
use crate::experiment::Point;
use crate::numerics::lanes::sines_and_cosines;

/// x0, y0 (m), phase (rad), p, q, s (m).
pub type Unknowns = [f64; 6];

/// Steps before giving up: near a root each leaves a small share (about σκ) of the last.
const MOST_ROUNDS: usize = 50;
/// … where only the sum of squares has to settle, along unknowns that hardly matter to it.
const MOST_ROUNDS_OF_A_SUM: usize = 200;

/// What the mean distance of each point from the true curve is taken to be.
#[derive(Debug, Clone, Copy)]
pub enum Shift<'a> {
    /// Zero.
    None,
    /// These, m.
    Given(&'a [f64]),
    /// ½σ̂²κ at each foot, with σ̂² of [`noise_variance`], re-estimated in every round.
    Curvature,
}

/// One set of equations.
#[derive(Debug, Clone, Copy)]
pub struct Equations<'a> {
    /// In order round the outline, m.
    pub points: &'a [Point],
    /// How often each point counts; `None`: once.
    pub counts: Option<&'a [f64]>,
    pub folds: u32,
    /// Perimeter to hold, m.
    pub length: Option<f64>,
    /// Which unknowns may move.
    pub free: [bool; 6],
    pub shift: Shift<'a>,
    /// Step at which the root counts as reached, as a share of p.
    pub tolerance: f64,
    /// … or what a step would still take off the sum of squares, as a share of it; 0 asks for the root itself.
    pub gain: f64,
}

/// A curve with what is local at the foot of every point.
#[derive(Debug, Clone)]
pub struct Linearized {
    pub feet: Vec<f64>,
    /// Signed, m; positive outside.
    pub distances: Vec<f64>,
    /// Signed, 1/m; positive where the curve turns left.
    pub curvatures: Vec<f64>,
    /// `−n·∂c/∂θ`.
    pub rows: Vec<Unknowns>,
}

/// A root.
#[derive(Debug, Clone)]
pub struct Root {
    pub unknowns: Unknowns,
    pub at: Linearized,
    /// dᵢ − bᵢ, m.
    pub residuals: Vec<f64>,
    /// σ̂² of [`noise_variance`], m².
    pub variance: f64,
    /// Derivative of half the sum of squares by the held perimeter, m.
    pub multiplier: Option<f64>,
    pub rounds: usize,
}

impl Root {
    /// Σ wᵢ (dᵢ − bᵢ)², m².
    pub fn sum_of_squares(&self, counts: Option<&[f64]>) -> f64 {
        weighed(&self.residuals, counts)
    }
}

/// The curve of `unknowns` with every foot followed from `feet`; `None` where something is not finite.
pub fn linearize(points: &[Point], unknowns: &Unknowns, folds: u32, feet: &[f64]) -> Option<Linearized> {
    let (hem, placement) = curve(unknowns, folds);
    let n = points.len();
    let mut out = Linearized {
        feet: Vec::with_capacity(n),
        distances: Vec::with_capacity(n),
        curvatures: Vec::with_capacity(n),
        rows: Vec::with_capacity(n),
    };
    let feet = follow_all(&hem, &placement, points, feet);
    let turns = sines_and_cosines(feet.iter().map(|foot| foot.t + placement.phase));
    for (foot, (sin, cos)) in feet.iter().zip(turns) {
        let local = &foot.local;
        let speed = local.speed();
        // Outward normal in the turning frame.
        let (nr, nt) = (local.velocity.1 / speed, -local.velocity.0 / speed);
        let row = [
            -(nr * cos - nt * sin),
            -(nr * sin + nt * cos),
            nr * local.position.1 - nt * local.position.0,
            -nr,
            -nr * local.cos_fold,
            -nt * local.sin_lean,
        ];
        let (distance, curvature) = (foot.distance(), local.curvature());
        if !(distance.is_finite() && curvature.is_finite() && row.iter().all(|v| v.is_finite())) {
            return None;
        }
        out.feet.push(foot.t);
        out.distances.push(distance);
        out.curvatures.push(curvature);
        out.rows.push(row);
    }
    Some(out)
}

/// σ̂² of the noise alone, m²: the least of Σe²/(n − unknowns) and von Neumann's mean squared difference of neighbours, ½ Σ(e_{i+1} − e_i)²/n,
/// round the outline. Where the misfit is smooth the latter sees through it: what is smooth has not moved the feet.
///
/// Source: von Neumann, Ann. Math. Statist. 12 (1941) 367–395.
pub fn noise_variance(residuals: &[f64], counts: Option<&[f64]>, unknowns: usize) -> f64 {
    let n = residuals.len();
    let total = counts.map_or(n as f64, |counts| counts.iter().sum());
    let spread = weighed(residuals, counts) / (total - unknowns as f64).max(1.0);
    let differences: f64 = (0..n).map(|i| (residuals[(i + 1) % n] - residuals[i]).powi(2)).sum();
    spread.min(0.5 * differences / n as f64)
}

fn weighed(residuals: &[f64], counts: Option<&[f64]>) -> f64 {
    match counts {
        Some(counts) => residuals.iter().zip(counts).map(|(e, w)| w * e * e).sum(),
        None => residuals.iter().map(|e| e * e).sum(),
    }
}

impl Equations<'_> {
    /// How many unknowns the equations determine, the perimeter's condition taken off.
    pub fn determined(&self) -> usize {
        self.free.iter().filter(|free| **free).count() - usize::from(self.length.is_some())
    }

    /// The root near `start`, each foot followed from `feet`; `None` if the iteration does not get there.
    pub fn root(&self, start: Unknowns, feet: &[f64]) -> Option<Root> {
        let size = self.points.iter().map(|p| p.x.abs().max(p.y.abs())).fold(start[3].abs(), f64::max);
        let rounding = 64.0 * f64::EPSILON * size / start[3].abs();
        let mut x = start;
        let mut at = linearize(self.points, &x, self.folds, feet)?;
        let mut variance = 0.0;
        let mut residuals = self.residuals(&at, &mut variance);
        let (mut damping, mut last, mut stuck) = (0.0_f64, f64::INFINITY, 0);
        for round in 1..=if 0.0 < self.gain { MOST_ROUNDS_OF_A_SUM } else { MOST_ROUNDS } {
            let system = self.system(&x, &at, &residuals);
            let cost = weighed(&residuals, self.counts);
            let (next, linear, moved, gain) = loop {
                if let Some(step) = system.step(damping) {
                    let next: Unknowns = std::array::from_fn(|j| x[j] + step[j]);
                    let moved = share(&step, x[3]);
                    if let Some(linear) = linearize(self.points, &next, self.folds, &at.feet) {
                        // The same shifts as before: only then is this a sum of squares that the step was made to lower.
                        let shifted: Vec<f64> =
                            (0..residuals.len()).map(|i| linear.distances[i] - (at.distances[i] - residuals[i])).collect();
                        let noise = 8.0 * f64::EPSILON * (cost + size * (cost * residuals.len() as f64).sqrt());
                        // A step to the held perimeter may cost; and far below the tolerance of any user the cost is all rounding.
                        if weighed(&shifted, self.counts) <= cost + noise || !system.feasible || moved < 1e-7 {
                            break (next, linear, moved, system.gain(&step));
                        }
                    }
                }
                damping = (10.0 * damping).max(1e-6);
                if 1e8 < damping {
                    return None;
                }
            };
            (x, at) = (next, linear);
            residuals = self.residuals(&at, &mut variance);
            damping = if damping < 1e-6 { 0.0 } else { 0.1 * damping };
            // Steps that no longer shrink are rounding, magnified by how weakly the points determine the curve.
            stuck = if moved < 1e-9 && 0.5 * last < moved { stuck + 1 } else { 0 };
            last = moved;
            let flat = system.feasible && damping < 1e-2 && 0.0 < self.gain && gain <= self.gain * cost;
            if flat || damping == 0.0 && (moved <= self.tolerance + rounding || 2 <= stuck) {
                let multiplier = self.length.map(|_| self.system(&x, &at, &residuals).multiplier());
                return x[3].is_finite().then_some(Root { unknowns: x, at, residuals, variance, multiplier, rounds: round });
            }
        }
        None
    }

    /// d − b at `at`; re-estimates the noise.
    fn residuals(&self, at: &Linearized, variance: &mut f64) -> Vec<f64> {
        let shifted = |variance: f64| -> Vec<f64> {
            match self.shift {
                Shift::None => at.distances.clone(),
                Shift::Given(shift) => at.distances.iter().zip(shift).map(|(d, b)| d - b).collect(),
                Shift::Curvature => at.distances.iter().zip(&at.curvatures).map(|(d, kappa)| d - 0.5 * variance * kappa).collect(),
            }
        };
        *variance = noise_variance(&shifted(*variance), self.counts, self.determined());
        shifted(*variance)
    }

    fn system(&self, x: &Unknowns, at: &Linearized, residuals: &[f64]) -> System {
        let mut normal = SMatrix::<f64, 6, 6>::zeros();
        let mut gradient = SVector::<f64, 6>::zeros();
        for (i, row) in at.rows.iter().enumerate() {
            let weight = self.counts.map_or(1.0, |counts| counts[i]);
            for j in 0..6 {
                let weighed = weight * row[j];
                gradient[j] += weighed * residuals[i];
                for k in 0..=j {
                    normal[(j, k)] += weighed * row[k];
                }
            }
        }
        let unit = SVector::<f64, 6>::from_fn(|j, _| if 0.0 < normal[(j, j)] { normal[(j, j)].sqrt() } else { 1.0 });
        for j in 0..6 {
            gradient[j] /= unit[j];
            for k in 0..=j {
                normal[(j, k)] /= unit[j] * unit[k];
                normal[(k, j)] = normal[(j, k)];
            }
        }
        for j in (0..6).filter(|&j| !self.free[j]) {
            normal.row_mut(j).fill(0.0);
            normal.column_mut(j).fill(0.0);
            normal[(j, j)] = 1.0;
            gradient[j] = 0.0;
        }
        let constraint = self.length.map(|length| {
            let (perimeter, by) = curve(x, self.folds).0.perimeter_gradient();
            let normal = SVector::<f64, 6>::from_fn(|j, _| if 3 <= j && self.free[j] { by[j - 3] / unit[j] } else { 0.0 });
            (perimeter - length, normal)
        });
        let feasible = constraint.is_none_or(|(excess, _)| self.length.is_none_or(|length| excess.abs() <= 1e-10 * length));
        System { normal, gradient, unit, constraint, feasible }
    }
}

/// Largest step of an unknown as a share of p; an angle moves points by p times itself.
fn share(step: &Unknowns, p: f64) -> f64 {
    step.iter().enumerate().map(|(j, v)| if j == 2 { v.abs() } else { (v / p).abs() }).fold(0.0, f64::max)
}

/// Normal equations in unknowns of unit columns, with the condition on the perimeter.
struct System {
    normal: SMatrix<f64, 6, 6>,
    gradient: SVector<f64, 6>,
    unit: SVector<f64, 6>,
    constraint: Option<(f64, SVector<f64, 6>)>,
    feasible: bool,
}

impl System {
    /// The damped step to where the linearized equations hold.
    fn step(&self, damping: f64) -> Option<Unknowns> {
        let mut matrix = SMatrix::<f64, 7, 7>::zeros();
        let mut right = SVector::<f64, 7>::zeros();
        for j in 0..6 {
            for k in 0..6 {
                matrix[(j, k)] = self.normal[(j, k)];
            }
            matrix[(j, j)] += damping;
            right[j] = -self.gradient[j];
        }
        matrix[(6, 6)] = 1.0;
        if let Some((excess, normal)) = &self.constraint {
            let length = normal.norm();
            for j in 0..6 {
                matrix[(6, j)] = normal[j] / length;
                matrix[(j, 6)] = normal[j] / length;
            }
            matrix[(6, 6)] = 0.0;
            right[6] = -excess / length;
        }
        let solved = matrix.lu().solve(&right)?;
        let step: Unknowns = std::array::from_fn(|j| solved[j] / self.unit[j]);
        step.iter().all(|v| v.is_finite()).then_some(step)
    }

    /// What the linearized equations promise that a step takes off the sum of squares, m².
    fn gain(&self, step: &Unknowns) -> f64 {
        (0..6).map(|j| -self.gradient[j] * self.unit[j] * step[j]).sum()
    }

    fn multiplier(&self) -> f64 {
        self.constraint.as_ref().map_or(0.0, |(_, normal)| normal.dot(&self.gradient) / normal.norm_squared())
    }
}
