//! The paper's hem curve: ρ = p + q cos mt along the ray, τ = s sin 2mt across it.
//!
//! `c(t) = ρ(t) e_r(t) + τ(t) e_θ(t)` (paper, equations 17 and 18); measured, it is rotated by a phase φ and shifted to a centre.
//! In complex notation, with `h = ρ + iτ` in the frame that turns with `e_r`, every derivative is one step of `h ↦ h' + ih`.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use serde::Serialize;

use crate::experiment::Point;
use crate::numerics::lanes::{Lanes, WIDTH};
use crate::vectorized;

/// p, q, s (m) and the fold count m of the hem curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hem {
    /// Mean radius, m.
    pub p: f64,
    /// Fold amplitude, m.
    pub q: f64,
    /// Sideways lean, m.
    pub s: f64,
    /// Fold count.
    pub folds: u32,
}

/// Where a measured hem lies: its centre (m) and the direction of one crest (rad).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Placement {
    pub x0: f64,
    pub y0: f64,
    pub phase: f64,
}

impl Placement {
    /// Centred on the origin, a crest on the x axis.
    pub const ORIGIN: Placement = Placement { x0: 0.0, y0: 0.0, phase: 0.0 };
}

/// Position and derivatives at one parameter in the turning frame (e_r, e_θ): each entry is (radial, tangential), m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Local {
    /// Position (ρ, τ).
    pub position: (f64, f64),
    /// First derivative in t.
    pub velocity: (f64, f64),
    /// Second derivative in t.
    pub acceleration: (f64, f64),
    /// cos mt.
    pub cos_fold: f64,
    /// sin 2mt.
    pub sin_lean: f64,
}

impl Local {
    /// |c'(t)|, m.
    pub fn speed(&self) -> f64 {
        let (radial, tangential) = self.velocity;
        (radial * radial + tangential * tangential).sqrt()
    }

    /// Signed curvature, 1/m; positive where the curve turns left.
    pub fn curvature(&self) -> f64 {
        let ((ux, uy), (ax, ay)) = (self.velocity, self.acceleration);
        (ux * ay - uy * ax) / self.speed().powi(3)
    }
}

impl Hem {
    /// Everything local at parameter `t`, in the frame that turns with `e_r(t)`.
    pub fn local(&self, t: f64) -> Local {
        let m = f64::from(self.folds);
        let (sin_fold, cos_fold) = (m * t).sin_cos();
        // Doubled angles: two multiplications instead of a second sine and cosine.
        let sin_lean = 2.0 * sin_fold * cos_fold;
        let cos_lean = 1.0 - 2.0 * sin_fold * sin_fold;
        let rho = self.p + self.q * cos_fold;
        let tau = self.s * sin_lean;
        let rho1 = -self.q * m * sin_fold;
        let tau1 = 2.0 * m * self.s * cos_lean;
        let rho2 = -self.q * m * m * cos_fold;
        let tau2 = -4.0 * m * m * tau;
        Local {
            position: (rho, tau),
            velocity: (rho1 - tau, rho + tau1),
            acceleration: (rho2 - 2.0 * tau1 - rho, tau2 + 2.0 * rho1 - tau),
            cos_fold,
            sin_lean,
        }
    }

    /// The point at parameter `t`, in the frame of the measurement, m.
    pub fn point(&self, placement: &Placement, t: f64) -> Point {
        let m = f64::from(self.folds);
        let (sin, cos) = (t + placement.phase).sin_cos();
        let rho = self.p + self.q * (m * t).cos();
        let tau = self.s * (2.0 * m * t).sin();
        Point::new(placement.x0 + rho * cos - tau * sin, placement.y0 + rho * sin + tau * cos)
    }

    /// `n` points round the curve, equally spaced in t, m.
    pub fn outline(&self, placement: &Placement, n: usize) -> Vec<Point> {
        (0..n).map(|i| self.point(placement, TAU * i as f64 / n as f64)).collect()
    }

    /// Signed area, m². Exact: A = π(p² + q²/2 + s²/2).
    pub fn area(&self) -> f64 {
        PI * (self.p * self.p + 0.5 * self.q * self.q + 0.5 * self.s * self.s)
    }

    /// Perimeter Λ, m, by the periodic trapezoid rule, which converges spectrally.
    pub fn perimeter(&self) -> f64 {
        self.perimeter_gradient().0
    }

    /// Perimeter Λ (m) and its derivatives by p, q, s, to rounding.
    pub fn perimeter_gradient(&self) -> (f64, [f64; 3]) {
        self.perimeter_to(1e-14)
    }

    /// Perimeter Λ (m) and its derivatives by p, q, s, until doubling the nodes changes it by less than `tolerance` (relative).
    ///
    /// A deeply folded curve gets the nodes it needs; one that nearly stands still somewhere converges algebraically, and gets 2¹⁴ a fold at most.
    pub fn perimeter_to(&self, tolerance: f64) -> (f64, [f64; 3]) {
        let mut last = f64::INFINITY;
        for level in 0.. {
            let mean = perimeter_mean(self, midpoints(level));
            let change = (mean[0] - last).abs() / mean[0].abs().max(f64::MIN_POSITIVE);
            last = mean[0];
            if change < tolerance || level + 1 == LEVELS || !mean[0].is_finite() {
                let [length, by_p, by_q, by_s] = mean.map(|value| TAU * value);
                return (length, [by_p, by_q, by_s]);
            }
        }
        unreachable!("the last level returns")
    }

    /// Least and greatest distance from the centre, m.
    pub fn radius_range(&self) -> (f64, f64) {
        // r² = (p + qc)² + 4s²c²(1 − c²) with c = cos mt: a quartic in c, so its extrema are the ends and the roots of a cubic.
        let radius = |c: f64| ((self.p + self.q * c).powi(2) + 4.0 * self.s * self.s * c * c * (1.0 - c * c)).max(0.0).sqrt();
        let mut low = radius(1.0).min(radius(-1.0));
        let mut high = radius(1.0).max(radius(-1.0));
        // d(r²)/dc; bracket its sign changes on a grid and bisect, which no multiple root can upset.
        let slope = |c: f64| 2.0 * self.q * (self.p + self.q * c) + 8.0 * self.s * self.s * c * (1.0 - 2.0 * c * c);
        const CELLS: usize = 64;
        let mut before = slope(-1.0);
        for i in 0..CELLS {
            let (mut a, mut b) = (-1.0 + 2.0 * i as f64 / CELLS as f64, -1.0 + 2.0 * (i + 1) as f64 / CELLS as f64);
            let (at_a, at_b) = (before, slope(b));
            before = at_b;
            if at_a * at_b <= 0.0 {
                for _ in 0..60 {
                    let mid = 0.5 * (a + b);
                    if at_a * slope(mid) <= 0.0 { b = mid } else { a = mid }
                }
                let r = radius(0.5 * (a + b));
                low = low.min(r);
                high = high.max(r);
            }
        }
        (low, high)
    }

    /// Whether the curve overhangs: several radii for one polar angle, i.e. c × c' changes sign.
    pub fn overhangs(&self) -> bool {
        const NODES: usize = 256;
        let m = f64::from(self.folds.max(1));
        (0..NODES).any(|i| {
            let local = self.local(TAU / m * i as f64 / NODES as f64);
            local.position.0 * local.velocity.1 - local.position.1 * local.velocity.0 < 0.0
        })
    }

    /// The same curve in canonical form: p > 0, q ≥ 0, phase in [0, 2π/m).
    pub fn canonical(self, placement: Placement) -> (Hem, Placement) {
        let (mut hem, mut phase) = (self, placement.phase);
        if hem.p < 0.0 {
            (hem.p, hem.q, hem.s) = (-hem.p, -hem.q, -hem.s);
            phase += PI;
        }
        let m = f64::from(hem.folds.max(1));
        if hem.q < 0.0 {
            hem.q = -hem.q;
            phase += PI / m;
        }
        let period = TAU / m;
        let mut phase = phase.rem_euclid(period);
        // rem_euclid of a tiny negative number rounds up to the period itself.
        if period <= phase {
            phase = 0.0;
        }
        (hem, Placement { phase, ..placement })
    }
}

/// Levels of the midpoint rule: 32, 64, … 2¹⁴ nodes a fold.
const LEVELS: usize = 10;

/// cos mt and sin mt at the midpoints of half a fold (the other half is its mirror image), 16 · 2^level of them.
pub(super) fn midpoints(level: usize) -> &'static [(Lanes, Lanes)] {
    static NODES: [OnceLock<Vec<(Lanes, Lanes)>>; LEVELS] = [const { OnceLock::new() }; LEVELS];
    NODES[level].get_or_init(|| {
        let count = 16 << level;
        let angle = |i: usize| PI * (i as f64 + 0.5) / count as f64;
        let block = |b: usize| -> (Lanes, Lanes) {
            let angles: [f64; WIDTH] = std::array::from_fn(|lane| angle(WIDTH * b + lane));
            (Lanes(angles.map(f64::cos)), Lanes(angles.map(f64::sin)))
        };
        (0..count / WIDTH).map(block).collect()
    })
}

vectorized! {
    /// Means of |c'| and of its derivatives by p, q, s over half a fold: all are alike, and mirror images of each other.
    fn perimeter_mean<V>(hem: &Hem, nodes: &[(Lanes, Lanes)]) -> [f64; 4] {
        let m = f64::from(hem.folds.max(1));
        let mut sums = [V::zero(); 4];
        for (cos_fold, sin_fold) in nodes {
            let (cos_fold, sin_fold) = (V::of(cos_fold), V::of(sin_fold));
            let sin_lean = sin_fold * cos_fold * 2.0;
            let cos_lean = V::all(1.0) - sin_fold * sin_fold * 2.0;
            let radial = -(sin_fold * (m * hem.q) + sin_lean * hem.s);
            let tangential = cos_fold * hem.q + hem.p + cos_lean * (2.0 * m * hem.s);
            let speed = (radial * radial + tangential * tangential).sqrt();
            // Where the curve stands still it has no direction; both components are zero there.
            let inverse = V::all(1.0) / speed.max(V::all(f64::MIN_POSITIVE));
            let (ur, ut) = (radial * inverse, tangential * inverse);
            sums[0] = sums[0] + speed;
            sums[1] = sums[1] + ut;
            sums[2] = sums[2] + (cos_fold * ut - sin_fold * ur * m);
            sums[3] = sums[3] + (cos_lean * ut * (2.0 * m) - sin_lean * ur);
        }
        let count = (WIDTH * nodes.len()) as f64;
        [sums[0].sum() / count, sums[1].sum() / count, sums[2].sum() / count, sums[3].sum() / count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXAMPLE: Hem = Hem { p: 0.1315, q: 0.0527, s: 0.00873, folds: 5 };

    #[test]
    fn derivatives_agree_with_central_differences() {
        let h = 1e-6;
        for i in 0..50 {
            let t = 0.13 * f64::from(i);
            let at = |t: f64| EXAMPLE.point(&Placement::ORIGIN, t);
            let local = EXAMPLE.local(t);
            let (sin, cos) = t.sin_cos();
            let turn = |(r, u): (f64, f64)| (r * cos - u * sin, r * sin + u * cos);
            let (a, b, c) = (at(t - h), at(t), at(t + h));
            let velocity = turn(local.velocity);
            // Rounding eps·|c|/h ≈ 3e-11 and truncation h²|c'''|/6 ≈ 1e-11.
            assert!((velocity.0 - (c.x - a.x) / (2.0 * h)).abs() < 1e-9);
            assert!((velocity.1 - (c.y - a.y) / (2.0 * h)).abs() < 1e-9);
            let acceleration = turn(local.acceleration);
            // Rounding 4·eps·|c|/h² ≈ 1e-4.
            assert!((acceleration.0 - (c.x - 2.0 * b.x + a.x) / (h * h)).abs() < 5e-4);
            assert!((acceleration.1 - (c.y - 2.0 * b.y + a.y) / (h * h)).abs() < 5e-4);
        }
    }

    #[test]
    fn perimeter_gradient_agrees_with_central_differences() {
        let (_, gradient) = EXAMPLE.perimeter_gradient();
        let h = 1e-6;
        let shifted = |dp: f64, dq: f64, ds: f64| Hem { p: EXAMPLE.p + dp, q: EXAMPLE.q + dq, s: EXAMPLE.s + ds, ..EXAMPLE }.perimeter();
        let numeric = [
            (shifted(h, 0.0, 0.0) - shifted(-h, 0.0, 0.0)) / (2.0 * h),
            (shifted(0.0, h, 0.0) - shifted(0.0, -h, 0.0)) / (2.0 * h),
            (shifted(0.0, 0.0, h) - shifted(0.0, 0.0, -h)) / (2.0 * h),
        ];
        for (exact, numeric) in gradient.iter().zip(numeric) {
            // Truncation h²Λ'''/6 dominates: Λ''' is of order m³/q² ~ 1e5, so 1e-8.
            assert!((exact - numeric).abs() < 1e-7, "{exact} {numeric}");
        }
    }

    #[test]
    fn area_formula_agrees_with_the_polygon() {
        let outline = EXAMPLE.outline(&Placement::ORIGIN, 20_000);
        let next = outline.iter().cycle().skip(1);
        let polygon: f64 = 0.5 * outline.iter().zip(next).map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>();
        // A polygon of n corners misses (2π/n)²/6 of the area, more where it curves.
        assert!((EXAMPLE.area() - polygon).abs() < 1e-5 * polygon);
    }

    #[test]
    fn radius_range_agrees_with_a_dense_scan() {
        for hem in [EXAMPLE, Hem { s: 0.04, ..EXAMPLE }, Hem { q: 0.0, s: 0.02, ..EXAMPLE }] {
            let (low, high) = hem.radius_range();
            let radii = hem.outline(&Placement::ORIGIN, 100_000).into_iter().map(|p| p.x.hypot(p.y));
            let (scan_low, scan_high) = radii.fold((f64::MAX, 0.0_f64), |(l, h), r| (l.min(r), h.max(r)));
            // The scan misses an extremum by at most (spacing·m)²·r/2 ~ 1e-8.
            assert!((low - scan_low).abs() < 1e-7 && (high - scan_high).abs() < 1e-7);
        }
    }

    #[test]
    fn canonical_form_is_the_same_curve() {
        let placement = Placement { x0: 0.01, y0: -0.02, phase: -0.4 };
        for hem in [
            Hem { q: -0.05, ..EXAMPLE },
            EXAMPLE,
            Hem { p: -0.13, q: 0.05, s: 0.01, folds: 6 },
            Hem { p: -0.13, q: 0.05, s: 0.01, folds: 7 },
        ] {
            let (canonical, at) = hem.canonical(placement);
            assert!(0.0 < canonical.p && 0.0 <= canonical.q && (0.0..TAU / f64::from(hem.folds)).contains(&at.phase));
            let target = canonical.outline(&at, 4000);
            for point in hem.outline(&placement, 40) {
                let nearest = target.iter().map(|q| q.distance(point)).fold(f64::MAX, f64::min);
                // Half the spacing of 4 000 points round a metre of hem.
                assert!(nearest < 3e-4, "{hem:?} {nearest}");
            }
        }
    }
}
