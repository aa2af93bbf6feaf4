//! A closed curve by the Fourier series of its tangent angle: position, derivatives and sensitivities anywhere along its length.
//!
//! `w'(σ) = i e^{i(σ + ψ)}`, `ψ = Σ_k α_k cos kPσ + β_k sin kPσ`, of unit speed in the angle of length σ ∈ [0, 2π), so its length is exactly 2π. P is its
//! symmetry: for P ≥ 2 it closes by itself, for P = 1 only where [`TangentCurve::gap`] vanishes. It lies about the centroid of its length.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix};

pub(super) type C = Complex<f64>;
const I: C = C::new(0.0, 1.0);

/// Nodes for each harmonic: quintic interpolation then leaves 5e-6 of what the highest adds to the curve.
const NODES: usize = 8;
/// … and at least this many in a period: the exponential of a large first harmonic has many of its own.
const FEWEST_NODES: usize = 128;

/// One period of the curve, tabulated; unit radius.
#[derive(Debug, Clone, PartialEq)]
pub struct TangentCurve {
    symmetry: u32,
    cosines: Vec<f64>,
    sines: Vec<f64>,
    /// Node spacing in σ.
    step: f64,
    /// cos and sin at `2πj/nodes`.
    table: Vec<(f64, f64)>,
    /// What turns the first period into each of the others.
    turns: Vec<C>,
    /// Position and its first three derivatives at the nodes, the end of the period included.
    position: Vec<C>,
    first: Vec<C>,
    second: Vec<C>,
    third: Vec<C>,
}

/// Position and two derivatives by σ.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    pub position: C,
    pub first: C,
    pub second: C,
}

/// Where σ lies: node, share of the way to the next, and the turn of its period.
struct Cell {
    node: usize,
    share: f64,
    turn: C,
}

impl TangentCurve {
    /// The curve of these coefficients of the harmonics P, 2P, …; as many sines as cosines.
    pub fn new(symmetry: u32, cosines: &[f64], sines: &[f64]) -> Self {
        assert_eq!(cosines.len(), sines.len(), "as many sines as cosines");
        let nodes = FEWEST_NODES.max(NODES * cosines.len()).next_power_of_two();
        // One period of a curve without symmetry is the whole turn, and its folds need their nodes.
        let nodes = if symmetry == 1 { nodes.max(4 * FEWEST_NODES) } else { nodes };
        let table: Vec<(f64, f64)> = (0..nodes).map(|j| (TAU * j as f64 / nodes as f64).sin_cos()).map(|(s, c)| (c, s)).collect();
        let period = TAU / f64::from(symmetry);
        let step = period / nodes as f64;
        let (mut first, mut second, mut third) =
            (Vec::with_capacity(nodes + 1), Vec::with_capacity(nodes + 1), Vec::with_capacity(nodes + 1));
        for j in 0..=nodes {
            let (mut psi, mut slope, mut bend) = (0.0, 1.0, 0.0);
            for (k, (a, b)) in (1..).zip(cosines.iter().zip(sines)) {
                let (cos, sin) = table[j * k % nodes];
                let order = k as f64 * f64::from(symmetry);
                let value = a * cos + b * sin;
                psi += value;
                slope += order * (b * cos - a * sin);
                bend -= order * order * value;
            }
            let (sin, cos) = (step * j as f64 + psi).sin_cos();
            let f = C::new(-sin, cos);
            first.push(f);
            second.push(f * C::new(0.0, slope));
            third.push(f * C::new(-slope * slope, bend));
        }
        let position = centred(cumulative(&first, &second, &third, step), symmetry);
        let turns = (0..symmetry).map(|turn| C::from_polar(1.0, TAU * f64::from(turn) / f64::from(symmetry))).collect();
        TangentCurve { symmetry, cosines: cosines.to_vec(), sines: sines.to_vec(), step, table, turns, position, first, second, third }
    }

    pub fn symmetry(&self) -> u32 {
        self.symmetry
    }

    /// Coefficients of cos kPσ.
    pub fn cosines(&self) -> &[f64] {
        &self.cosines
    }

    /// Coefficients of sin kPσ.
    pub fn sines(&self) -> &[f64] {
        &self.sines
    }

    /// Mean of the unit tangent: 0 of a curve that closes.
    pub fn gap(&self) -> C {
        let nodes = self.table.len();
        self.first[..nodes].iter().sum::<C>() / nodes as f64
    }

    /// Derivatives of [`TangentCurve::gap`] by all cosines, then all sines.
    pub fn gap_gradient(&self) -> Vec<C> {
        let (nodes, orders) = (self.table.len(), self.cosines.len());
        let mut gradient = vec![C::new(0.0, 0.0); 2 * orders];
        for (j, f) in self.first[..nodes].iter().enumerate() {
            let f = I * f / nodes as f64;
            for k in 1..=orders {
                let (cos, sin) = self.table[j * k % nodes];
                gradient[k - 1] += f * cos;
                gradient[orders + k - 1] += f * sin;
            }
        }
        gradient
    }

    fn cell(&self, sigma: f64) -> Cell {
        let nodes = self.table.len();
        let scaled = sigma / self.step;
        let turns = (scaled / nodes as f64).floor();
        let within = scaled - turns * nodes as f64;
        let node = (within as usize).min(nodes - 1);
        let turn = self.turns[turns.rem_euclid(f64::from(self.symmetry)) as usize];
        Cell { node, share: within - node as f64, turn }
    }

    /// Position and derivatives at any σ, by quintic Hermite interpolation.
    pub fn at(&self, sigma: f64) -> Place {
        let Cell { node, share: x, turn } = self.cell(sigma);
        let h = self.step;
        let (p, q) = (self.position[node], self.position[node + 1] - self.position[node]);
        let (u, v) = (self.first[node] * h, self.first[node + 1] * h);
        let (a, b) = (self.second[node] * (h * h), self.second[node + 1] * (h * h));
        let c3 = q * 10.0 - u * 6.0 - v * 4.0 - (a * 3.0 - b) * 0.5;
        let c4 = q * -15.0 + u * 8.0 + v * 7.0 + (a * 3.0 - b * 2.0) * 0.5;
        let c5 = q * 6.0 - (u + v) * 3.0 - (a - b) * 0.5;
        let position = p + (u + (a * 0.5 + (c3 + (c4 + c5 * x) * x) * x) * x) * x;
        let first = (u + (a + (c3 * 3.0 + (c4 * 4.0 + c5 * (5.0 * x)) * x) * x) * x) / h;
        let second = (a + (c3 * 6.0 + (c4 * 12.0 + c5 * (20.0 * x)) * x) * x) / (h * h);
        Place { position: turn * position, first: turn * first, second: turn * second }
    }

    /// Positions at the nodes of one whole turn, with their σ.
    pub fn nodes(&self) -> Vec<(f64, C)> {
        let (nodes, symmetry) = (self.table.len(), self.symmetry as usize);
        let all = (0..nodes * symmetry).map(|j| {
            let turn = C::from_polar(1.0, TAU * (j / nodes) as f64 / symmetry as f64);
            (self.step * j as f64, turn * self.position[j % nodes])
        });
        all.collect()
    }

    /// By how much every point of the curve moves with each coefficient.
    pub fn sensitivities(&self) -> Sensitivities<'_> {
        let (nodes, orders) = (self.table.len(), self.cosines.len());
        let all = if self.symmetry == 1 { 2 * orders } else { orders };
        let mut position = DMatrix::from_element(nodes + 1, all, C::new(0.0, 0.0));
        let (mut g, mut g1, mut g2) =
            (vec![C::new(0.0, 0.0); nodes + 1], vec![C::new(0.0, 0.0); nodes + 1], vec![C::new(0.0, 0.0); nodes + 1]);
        for column in 0..all {
            let (k, sine) = self.harmonic(column);
            let order = k as f64 * f64::from(self.symmetry);
            for j in 0..=nodes {
                let (value, slope) = self.basis(j, k, sine);
                let (slope, bend) = (order * slope, -order * order * value);
                g[j] = I * self.first[j] * value;
                g1[j] = I * (self.first[j] * slope + self.second[j] * value);
                g2[j] = I * (self.first[j] * bend + self.second[j] * (2.0 * slope) + self.third[j] * value);
            }
            let moved = centred(cumulative(&g, &g1, &g2, self.step), self.symmetry);
            position.column_mut(column).copy_from_slice(&moved);
        }
        Sensitivities { curve: self, position }
    }

    /// Harmonic and kind of a column: all cosines, then all sines; only sines where the curve has a symmetry.
    fn harmonic(&self, column: usize) -> (usize, bool) {
        let orders = self.cosines.len();
        match self.symmetry {
            1 if column < orders => (column + 1, false),
            1 => (column - orders + 1, true),
            _ => (column + 1, true),
        }
    }

    /// cos or sin of harmonic k at node j, and its derivative by its own angle.
    fn basis(&self, j: usize, k: usize, sine: bool) -> (f64, f64) {
        let (cos, sin) = self.table[j * k % self.table.len()];
        if sine { (sin, cos) } else { (cos, -sin) }
    }
}

/// Derivatives of the position by the coefficients: cosines, then sines; sines alone where the curve has a symmetry (then its cosines are 0).
pub struct Sensitivities<'a> {
    curve: &'a TangentCurve,
    position: DMatrix<C>,
}

impl Sensitivities<'_> {
    pub fn count(&self) -> usize {
        self.position.ncols()
    }

    /// What `see` is told of each coefficient at σ: its index, the derivative of the position and that of the tangent `w'`.
    pub fn at(&self, sigma: f64, mut see: impl FnMut(usize, C, C)) {
        let curve = self.curve;
        let Cell { node, share: x, turn } = curve.cell(sigma);
        let h = curve.step;
        // Cubic Hermite weights of values and slopes at both nodes.
        let (b, d) = (x * x * (3.0 - 2.0 * x), x * x * (x - 1.0) * h);
        let (a, c) = (1.0 - b, x * (1.0 - x) * (1.0 - x) * h);
        let (f, g) = (turn * I * curve.first[node], turn * I * curve.first[node + 1]);
        let middle = turn * I * (curve.first[node] * (1.0 - x) + curve.first[node + 1] * x);
        for column in 0..self.count() {
            let (k, sine) = curve.harmonic(column);
            let (here, there) = (curve.basis(node, k, sine).0, curve.basis(node + 1, k, sine).0);
            let moved =
                turn * (self.position[(node, column)] * a + self.position[(node + 1, column)] * b) + f * (here * c) + g * (there * d);
            see(column, moved, middle * (here * (1.0 - x) + there * x));
        }
    }
}

/// Integrals from node 0, by the two-point rule that is exact for quintics.
fn cumulative(f: &[C], f1: &[C], f2: &[C], h: f64) -> Vec<C> {
    let mut sum = C::new(0.0, 0.0);
    let mut all = Vec::with_capacity(f.len());
    all.push(sum);
    for j in 0..f.len() - 1 {
        sum += (f[j] + f[j + 1]) * (h / 2.0) + (f1[j] - f1[j + 1]) * (h * h / 10.0) + (f2[j] + f2[j + 1]) * (h * h * h / 120.0);
        all.push(sum);
    }
    all
}

/// Positions about the centre: of symmetry, where there is one, else of the length.
fn centred(mut position: Vec<C>, symmetry: u32) -> Vec<C> {
    let nodes = position.len() - 1;
    let shift = if symmetry == 1 {
        -position[..nodes].iter().sum::<C>() / nodes as f64
    } else {
        position[nodes] / (C::from_polar(1.0, TAU / f64::from(symmetry)) - 1.0)
    };
    position.iter_mut().for_each(|p| *p += shift);
    position
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interpolated_curve_has_unit_speed_and_closes() {
        let curve = TangentCurve::new(5, &[0.0; 3], &[1.4, -0.1, 0.03]);
        for i in 0..500 {
            let place = curve.at(0.0126 * f64::from(i) - 1.0);
            // The slope of a quintic interpolant is off by at most 0.054 h⁵ w⁽⁶⁾/720, h = 2π/640; the highest harmonic turns 15 times, so w⁽⁶⁾ ~ 15⁵: 5e-9.
            assert!((place.first.norm() - 1.0).abs() < 5e-9, "{i}: {}", place.first.norm());
        }
        let (start, end) = (curve.at(0.0), curve.at(TAU - 1e-12));
        assert!((start.position - end.position).norm() < 1e-11);
    }

    #[test]
    fn a_single_harmonic_agrees_with_its_bessel_series() {
        // e^{ia sin x} = Σ J_j(a) e^{ijx}: the crest of m folds lies at Σ J_j(a)/(1 + jm); Bessel values to 15 digits (DLMF 10.2) at a = 1.
        let bessel = [
            0.765_197_686_557_967,
            0.440_050_585_744_934,
            0.114_903_484_931_901,
            0.019_563_353_982_668,
            0.002_476_638_964_110,
            0.000_249_757_730_211,
            0.000_020_938_338_002,
            0.000_001_502_325_817,
        ];
        let m = 4.0;
        let crest: f64 = bessel
            .iter()
            .enumerate()
            .map(|(j, b)| {
                let j = j as f64;
                let minus = if j as i32 % 2 == 0 { *b } else { -*b };
                if j == 0.0 { *b } else { b / (1.0 + j * m) + minus / (1.0 - j * m) }
            })
            .sum();
        let curve = TangentCurve::new(4, &[0.0], &[1.0]);
        // The eighth term that is left out is 9e-8/31; the quadrature is exact to its seventh power of the step.
        assert!((curve.at(0.0).position - C::new(crest, 0.0)).norm() < 1e-8, "{} {crest}", curve.at(0.0).position);
    }

    #[test]
    fn sensitivities_agree_with_central_differences() {
        let (cosines, sines) = (vec![0.05, -0.1, 0.3, 0.02], vec![-0.02, 0.2, 0.1, -0.05]);
        let curve = TangentCurve::new(1, &cosines, &sines);
        let sensitivities = curve.sensitivities();
        let h = 1e-5;
        for i in 0..40 {
            let sigma = 0.16 * f64::from(i);
            sensitivities.at(sigma, |column, exact, _| {
                let moved = |by: f64| {
                    let (mut a, mut b) = (cosines.clone(), sines.clone());
                    if column < 4 {
                        a[column] += by
                    } else {
                        b[column - 4] += by
                    }
                    TangentCurve::new(1, &a, &b).at(sigma).position
                };
                let numeric = (moved(h) - moved(-h)) / (2.0 * h);
                // Cubic against quintic interpolation: (2π/512)⁴ · 4³/384 ~ 4e-9; differences 1e-10.
                assert!((exact - numeric).norm() < 3e-8, "{i} {column}: {exact} {numeric}");
            });
        }
    }
}
