//! One curve of the tangent-angle family, at any material angle: position, outline, radii.

use std::f64::consts::{PI, TAU};

use crate::experiment::Point;
use crate::numerics::lanes::{Lanes, WIDTH, sin_cos, turned};
use crate::vectorized;

/// One curve of the family, to be evaluated at any material angle.
#[derive(Debug, Clone)]
pub struct TangentHem {
    folds: u32,
    hem: f64,
    coefficients: Vec<f64>,
    strains: Vec<f64>,
    /// h = Σ_j (modes_j.0 e^{ijφ} + modes_j.1 e^{−ijφ}).
    modes: Vec<(f64, f64)>,
}

impl TangentHem {
    /// The closed curve of `folds` ≥ 2 folds and length 2π · `hem` (m) with coefficients a_1 … a_K, from `half` intervals in half a fold.
    pub fn new(folds: u32, hem: f64, coefficients: &[f64], half: usize) -> Self {
        TangentHem::stretched(folds, hem, coefficients, &[], half)
    }

    /// The same stretched by ε(σ) = Σ_k strains[k] cos kmσ, k from 0.
    pub fn stretched(folds: u32, hem: f64, coefficients: &[f64], strains: &[f64], half: usize) -> Self {
        let m = f64::from(folds);
        let table: Vec<(f64, f64)> = (0..2 * half).map(|i| (PI * i as f64 / half as f64).sin_cos()).collect();
        let psi = |n: usize| coefficients.iter().enumerate().map(|(k, a)| a * table[n * (k + 1) % (2 * half)].0).sum::<f64>();
        let mut turned: Vec<(f64, f64)> = (0..=half).map(|n| psi(n).sin_cos()).collect();
        for (n, (sin, cos)) in turned.iter_mut().enumerate().filter(|_| !strains.is_empty()) {
            let length = 1.0 + strains.iter().enumerate().map(|(k, e)| e * table[n * k % (2 * half)].1).sum::<f64>();
            (*sin, *cos) = (*sin * length, *cos * length);
        }
        let weight = |n: usize| if n == 0 || n == half { 0.5 } else { 1.0 } / half as f64;
        let modes = (0..half).map(|j| {
            // w_{±j} = C_j ± S_j: e^{iψ} has an even real and an odd imaginary part, so its coefficients are real.
            let (mut even, mut odd) = (0.0, 0.0);
            for (n, (sin_psi, cos_psi)) in turned.iter().enumerate() {
                let (sin, cos) = table[n * j % (2 * half)];
                even += weight(n) * cos_psi * cos;
                odd += weight(n) * sin_psi * sin;
            }
            let jm = m * j as f64;
            if j == 0 { (hem * even, 0.0) } else { (hem * (even + odd) / (1.0 + jm), hem * (even - odd) / (1.0 - jm)) }
        });
        let mut modes: Vec<(f64, f64)> = modes.collect();
        // They fall off faster than geometrically: those that no digit of the curve feels are not carried along.
        let heard = modes.iter().rposition(|(plus, minus)| 1e-18 * hem < plus.abs() + minus.abs());
        modes.truncate(heard.map_or(0, |last| last + 1));
        TangentHem { folds, hem, coefficients: coefficients.to_vec(), strains: strains.to_vec(), modes }
    }

    /// h(φ) and dh/dφ at φ = mσ, m.
    fn turning(&self, phi: f64) -> [[f64; 2]; 2] {
        turnings(self, &[phi])[0]
    }

    /// Positions at many material angles, m.
    pub fn positions(&self, sigmas: &[f64]) -> Vec<[f64; 2]> {
        let m = f64::from(self.folds);
        let phis: Vec<f64> = sigmas.iter().map(|sigma| m * sigma).collect();
        let turned = |([[x, y], _], sigma): ([[f64; 2]; 2], &f64)| {
            let (sin, cos) = sigma.sin_cos();
            [x * cos - y * sin, x * sin + y * cos]
        };
        turnings(self, &phis).into_iter().zip(sigmas).map(turned).collect()
    }

    /// Position (m) and its first and second derivative by σ.
    pub fn local(&self, sigma: f64) -> [[f64; 2]; 3] {
        let m = f64::from(self.folds);
        let [[x, y], _] = self.turning(m * sigma);
        let turned = |(x, y): (f64, f64), angle: f64| {
            let (sin, cos) = angle.sin_cos();
            [x * cos - y * sin, x * sin + y * cos]
        };
        let (mut psi, mut slope) = (0.0, 0.0);
        for (k, a) in (1..).zip(&self.coefficients) {
            let order = m * f64::from(k);
            psi += a * (order * sigma).sin();
            slope += a * order * (order * sigma).cos();
        }
        // c' = i R_n e^{i(σ + ψ)}, c'' = −R_n (1 + ψ') e^{i(σ + ψ)}.
        let angle = sigma + psi;
        [turned((x, y), sigma), turned((0.0, self.hem), angle), turned((-self.hem * (1.0 + slope), 0.0), angle)]
    }

    /// `n` points round the hem, equally spaced in cloth length, the first on a crest on the x axis, counter-clockwise, m.
    pub fn outline(&self, n: usize) -> Vec<Point> {
        let m = f64::from(self.folds);
        // Where the points fall alike in every fold, one fold says everything.
        let period = if n.is_multiple_of(self.folds as usize) { n / self.folds as usize } else { n };
        let fold = turnings(self, &(0..period).map(|i| m * TAU * i as f64 / n as f64).collect::<Vec<f64>>());
        let place = |i: usize| {
            let ([[x, y], _], (sin, cos)) = (fold[i % period], (TAU * i as f64 / n as f64).sin_cos());
            Point::new(x * cos - y * sin, x * sin + y * cos)
        };
        (0..n).map(place).collect()
    }

    /// Least and greatest distance of the hem from the axis, m.
    pub fn radius_range(&self) -> (f64, f64) {
        const CELLS: usize = 64;
        let polar = |[[x, y], [dx, dy]]: [[f64; 2]; 2]| (x.hypot(y), x * dx + y * dy);
        let at = |phi: f64| polar(self.turning(phi));
        // The crest and the valley are extrema by symmetry; others show as sign changes of the slope between them.
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        let mut see = |r: f64| (low, high) = (low.min(r), high.max(r));
        see(at(0.0).0);
        see(at(PI).0);
        let phis: Vec<f64> = (0..=CELLS).map(|i| PI * i as f64 / CELLS as f64).collect();
        let slopes = turnings(self, &phis).into_iter().map(|place| polar(place).1);
        let edges: Vec<(f64, f64)> = phis.iter().copied().zip(slopes).collect();
        for pair in edges[1..CELLS].windows(2) {
            let ((mut a, sa), (mut b, sb)) = (pair[0], pair[1]);
            if sa * sb < 0.0 {
                for _ in 0..52 {
                    let middle = 0.5 * (a + b);
                    if sa * at(middle).1 < 0.0 { b = middle } else { a = middle }
                }
                see(at(0.5 * (a + b)).0);
            }
        }
        (low, high)
    }

    /// a_1 … a_K.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }
}

vectorized! {
    /// h(φ) and dh/dφ at many φ = mσ, m; eight at a time, the last of them as often as it takes.
    fn turnings<V>(hem: &TangentHem, phis: &[f64]) -> Vec<[[f64; 2]; 2]> {
        let m = f64::from(hem.folds);
        let mut out = Vec::with_capacity(phis.len());
        for chunk in phis.chunks(WIDTH) {
            let mut lanes = Lanes([chunk[chunk.len() - 1]; WIDTH]);
            lanes.0[..chunk.len()].copy_from_slice(chunk);
            let (sin, cos) = sin_cos(V::of(&lanes));
            let (mut x, mut y, mut psi, mut strain) = (V::zero(), V::zero(), V::zero(), V::zero());
            // e^{ijφ} as powers of e^{iφ}: one sine for all of them.
            let mut power = (V::all(1.0), V::zero());
            for j in 0..hem.modes.len().max(hem.coefficients.len()).max(hem.strains.len()) {
                if let Some((plus, minus)) = hem.modes.get(j) {
                    x = power.0.mul_add(V::all(plus + minus), x);
                    y = power.1.mul_add(V::all(plus - minus), y);
                }
                if let Some(e) = hem.strains.get(j) {
                    strain = power.0.mul_add(V::all(*e), strain);
                }
                power = turned(power, (cos, sin));
                if let Some(a) = hem.coefficients.get(j) {
                    psi = power.1.mul_add(V::all(*a), psi);
                }
            }
            let (sin, cos) = sin_cos(psi);
            let stretched = (strain + 1.0) * hem.hem;
            // From h − i m dh/dφ = R_n (1 + ε) e^{iψ}.
            let (dx, dy) = ((y - stretched * sin) / V::all(m), (stretched * cos - x) / V::all(m));
            let (x, y, dx, dy) = (x.lanes(), y.lanes(), dx.lanes(), dy.lanes());
            for lane in 0..chunk.len() {
                out.push([[x.0[lane], y.0[lane]], [dx.0[lane], dy.0[lane]]]);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn velocity_identity_agrees_with_differences_of_the_series() {
        let curve = TangentHem::new(3, 0.2362, &[1.0, 0.2], 24);
        for i in 0..40 {
            let (phi, h) = (0.17 * f64::from(i), 1e-5);
            let [_, exact] = curve.turning(phi);
            let (up, down) = (curve.turning(phi + h)[0], curve.turning(phi - h)[0]);
            // Rounding eps·R/h ~ 1e-11, truncation h²h‴/6 ~ 1e-11.
            assert!((0..2).all(|d| (exact[d] - (up[d] - down[d]) / (2.0 * h)).abs() < 1e-9));
        }
    }
}
