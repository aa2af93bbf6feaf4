//! A closed curve by the Fourier series of its tangent angle: position, derivatives and sensitivities anywhere along its length.
//!
//! `w'(σ) = i e^{i(σ + ψ)}`, `ψ = Σ_k α_k cos kPσ + β_k sin kPσ`, of unit speed in the angle of length σ ∈ [0, 2π), so its length is exactly 2π. P is its
//! symmetry: for P ≥ 2 it closes by itself, for P = 1 only where [`TangentCurve::gap`] vanishes. It lies about the centroid of its length.

mod foot;
mod harmonics;
mod sensitivities;

use std::sync::Arc;

use nalgebra::Complex;

pub use self::foot::Foot;
use self::harmonics::Harmonics;
pub use self::sensitivities::Sensitivities;
use crate::numerics::lanes::{Lanes, WIDTH};
use crate::vectorized;

pub(super) type C = Complex<f64>;
const I: C = C::new(0.0, 1.0);

/// One period of the curve, tabulated; unit radius.
#[derive(Debug, Clone, PartialEq)]
pub struct TangentCurve {
    harmonics: Arc<Harmonics>,
    cosines: Vec<f64>,
    sines: Vec<f64>,
    /// The tangent `w'` and its first two derivatives at the nodes, the end of the period included.
    first: Vec<C>,
    second: Vec<C>,
    third: Vec<C>,
    /// From each node to the next the position by powers of the share of the way: the quintic that has its first two derivatives at both.
    cells: Vec<[C; 6]>,
}

/// Position and two derivatives by σ.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    pub position: C,
    pub first: C,
    pub second: C,
}

/// Where σ lies: node, share of the way to the next, and the period.
#[derive(Clone, Copy)]
struct Cell {
    node: usize,
    share: f64,
    period: usize,
}

impl TangentCurve {
    /// The curve of these coefficients of the harmonics P, 2P, …; as many sines as cosines.
    pub fn new(symmetry: u32, cosines: &[f64], sines: &[f64]) -> Self {
        TangentCurve::of(Arc::new(Harmonics::new(symmetry, cosines.len())), cosines, sines)
    }

    /// The curve of the same symmetry with as many other coefficients.
    pub fn with(&self, cosines: &[f64], sines: &[f64]) -> Self {
        TangentCurve::of(self.harmonics.clone(), cosines, sines)
    }

    /// The same without the tables of its harmonics, which are most of it and are made again where they are asked for: to be kept.
    pub fn slim(self) -> Self {
        let Harmonics { symmetry, orders, .. } = *self.harmonics;
        TangentCurve { harmonics: Arc::new(Harmonics::new(symmetry, orders)), ..self }
    }

    fn of(harmonics: Arc<Harmonics>, cosines: &[f64], sines: &[f64]) -> Self {
        assert!(cosines.len() == harmonics.orders && sines.len() == harmonics.orders, "as many sines as cosines");
        let (nodes, step) = (harmonics.nodes, harmonics.step);
        let mut angles = vec![Angle::ZERO; nodes / WIDTH];
        tabulate(&harmonics, cosines, sines, &mut angles);
        let (mut first, mut second, mut third) =
            (Vec::with_capacity(nodes + 1), Vec::with_capacity(nodes + 1), Vec::with_capacity(nodes + 1));
        for j in 0..=nodes {
            let Angle { angle, slope, bend } = &angles[j % nodes / WIDTH];
            let (angle, slope, bend) = (angle.0[j % WIDTH], slope.0[j % WIDTH], bend.0[j % WIDTH]);
            let (sin, cos) = (step * j as f64 + angle).sin_cos();
            let f = C::new(-sin, cos);
            first.push(f);
            second.push(f * C::new(0.0, slope));
            third.push(f * C::new(-slope * slope, bend));
        }
        let position = centred(cumulative(&first, &second, &third, step), &harmonics);
        let cells = (0..nodes)
            .map(|j| {
                let (p, q) = (position[j], position[j + 1] - position[j]);
                let (u, v) = (first[j] * step, first[j + 1] * step);
                let (a, b) = (second[j] * (step * step), second[j + 1] * (step * step));
                let c3 = q * 10.0 - u * 6.0 - v * 4.0 - (a * 3.0 - b) * 0.5;
                let c4 = q * -15.0 + u * 8.0 + v * 7.0 + (a * 3.0 - b * 2.0) * 0.5;
                let c5 = q * 6.0 - (u + v) * 3.0 - (a - b) * 0.5;
                [p, u, a * 0.5, c3, c4, c5]
            })
            .collect();
        TangentCurve { harmonics, cosines: cosines.to_vec(), sines: sines.to_vec(), first, second, third, cells }
    }

    pub fn symmetry(&self) -> u32 {
        self.harmonics.symmetry
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
        let nodes = self.harmonics.nodes;
        self.first[..nodes].iter().sum::<C>() / nodes as f64
    }

    /// Derivatives of [`TangentCurve::gap`] by all cosines, then all sines.
    pub fn gap_gradient(&self) -> Vec<C> {
        let Harmonics { nodes, orders, ref order, .. } = *self.harmonics;
        let turned: Vec<C> = self.first[..nodes].iter().map(|f| I * f / nodes as f64).collect();
        let mut sums = vec![[Lanes::ZERO; 2]; 2 * order.len()];
        sum_over_nodes(&self.harmonics, &turned, &mut sums);
        let of = |first: usize, k: usize| {
            let [re, im] = sums[first + k / WIDTH];
            C::new(re.0[k % WIDTH], im.0[k % WIDTH])
        };
        (0..orders).map(|k| of(0, k)).chain((0..orders).map(|k| of(order.len(), k))).collect()
    }

    #[inline(always)]
    fn cell(&self, sigma: f64) -> Cell {
        let Harmonics { nodes, step, turns, .. } = &*self.harmonics;
        let scaled = sigma / step;
        let periods = (scaled / *nodes as f64).floor();
        let within = scaled - periods * *nodes as f64;
        let node = (within as usize).min(nodes - 1);
        let period = periods as i64;
        // A division of whole numbers is slow, and hardly ever needed.
        let once = (0..turns.len() as i64).contains(&period);
        let period = if once { period as usize } else { period.rem_euclid(turns.len() as i64) as usize };
        Cell { node, share: within - node as f64, period }
    }

    /// Position and derivatives at any σ, by quintic Hermite interpolation.
    pub fn at(&self, sigma: f64) -> Place {
        let Cell { node, share: x, period } = self.cell(sigma);
        let (h, turn) = (self.harmonics.step, self.harmonics.turns[period]);
        let [p, u, a, c3, c4, c5] = self.cells[node];
        let position = p + (u + (a + (c3 + (c4 + c5 * x) * x) * x) * x) * x;
        let first = (u + (a * 2.0 + (c3 * 3.0 + (c4 * 4.0 + c5 * (5.0 * x)) * x) * x) * x) / h;
        let second = (a * 2.0 + (c3 * 6.0 + (c4 * 12.0 + c5 * (20.0 * x)) * x) * x) / (h * h);
        Place { position: turn * position, first: turn * first, second: turn * second }
    }

    /// Positions at the nodes of one whole turn, with their σ.
    pub fn nodes(&self) -> Vec<(f64, C)> {
        let Harmonics { nodes, step, turns, .. } = &*self.harmonics;
        (0..nodes * turns.len()).map(|j| (step * j as f64, turns[j / nodes] * self.cells[j % nodes][0])).collect()
    }

    /// By how much every point of the curve moves with each coefficient.
    pub fn sensitivities(&self) -> Sensitivities<'_> {
        Sensitivities::of(self)
    }
}

/// ψ, `1 + ψ'` and `ψ''` at eight nodes.
#[derive(Clone, Copy)]
struct Angle {
    angle: Lanes,
    slope: Lanes,
    bend: Lanes,
}

impl Angle {
    const ZERO: Angle = Angle { angle: Lanes::ZERO, slope: Lanes::ZERO, bend: Lanes::ZERO };
}

vectorized! {
    fn tabulate<V>(harmonics: &Harmonics, cosines: &[f64], sines: &[f64], angles: &mut [Angle]) -> () {
        for (block, eight) in angles.iter_mut().enumerate() {
            let (mut psi, mut slope, mut bend) = (V::zero(), V::all(1.0), V::zero());
            for (k, [cos, sin]) in harmonics.block(block).iter().enumerate() {
                let (a, b, order) = (cosines[k], sines[k], (k + 1) as f64 * f64::from(harmonics.symmetry));
                let (cos, sin) = (V::of(cos), V::of(sin));
                let value = cos * a + sin * b;
                psi = psi + value;
                slope = slope + (cos * b - sin * a) * order;
                bend = bend - value * (order * order);
            }
            *eight = Angle { angle: psi.lanes(), slope: slope.lanes(), bend: bend.lanes() };
        }
    }
}

vectorized! {
    /// Sums over the nodes of `tangents` times each cosine, then each sine.
    fn sum_over_nodes<V>(harmonics: &Harmonics, tangents: &[C], sums: &mut [[Lanes; 2]]) -> () {
        let vectors = harmonics.order.len();
        for (v, sum) in sums.iter_mut().enumerate() {
            let (mut re, mut im) = (V::zero(), V::zero());
            for (j, f) in tangents.iter().enumerate() {
                let (cosines, sines) = harmonics.at(j);
                let basis = V::of(if v < vectors { &cosines[v] } else { &sines[v - vectors] });
                (re, im) = (re + basis * f.re, im + basis * f.im);
            }
            *sum = [re.lanes(), im.lanes()];
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
fn centred(mut position: Vec<C>, harmonics: &Harmonics) -> Vec<C> {
    let nodes = harmonics.nodes;
    let shift = if harmonics.symmetry == 1 {
        -position[..nodes].iter().sum::<C>() / nodes as f64
    } else {
        position[nodes] / (harmonics.turn() - 1.0)
    };
    position.iter_mut().for_each(|p| *p += shift);
    position
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

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
        let few = (vec![0.05, -0.1, 0.3, 0.02], vec![-0.02, 0.2, 0.1, -0.05]);
        let wave = |k: i32| 0.3 / f64::from(1 + k) * f64::from(k).sin();
        let many = ((0..40).map(wave).collect::<Vec<f64>>(), (3..43).map(wave).collect::<Vec<f64>>());
        for (symmetry, (cosines, sines)) in [(1, few.clone()), (1, many), (5, (vec![0.0; 4], few.1))] {
            let curve = TangentCurve::new(symmetry, &cosines, &sines);
            let sensitivities = curve.sensitivities();
            let h = 1e-5;
            for i in 0..40 {
                let sigma = 0.16 * f64::from(i);
                sensitivities.at(sigma, |column, exact, turned| {
                    let place = |by: f64| {
                        let (mut a, mut b) = (cosines.clone(), sines.clone());
                        if symmetry == 1 && column < a.len() {
                            a[column] += by
                        } else {
                            b[column % cosines.len()] += by
                        }
                        TangentCurve::new(symmetry, &a, &b).at(sigma)
                    };
                    let (up, down) = (place(h), place(-h));
                    let numeric = (up.position - down.position) / (2.0 * h);
                    // The same quintics, so that only the differences are off, by h²/6 times a third derivative of some units.
                    assert!((exact - numeric).norm() < 1e-9, "{i} {column}: {exact} {numeric}");
                    let numeric = (up.first - down.first) / (2.0 * h);
                    // A slope of the quintic is off by at most 0.054 (π/4)⁵/720 of what the highest harmonic adds.
                    assert!((turned - numeric).norm() < 1e-4, "{i} {column}: {turned} {numeric}");
                });
            }
        }
    }
}
