//! The least-squares optimum of an outline in twice the working precision: what a fit is held against.
//!
//! Nothing here is shared with the fits: feet and angles are points of the unit circle instead of numbers in radians, so that no sine is needed, and
//! the gradient of the sum of squares is found in double-double arithmetic. Newton's matrix is taken once, by differences of that gradient; it is
//! right to seven digits, so each step leaves a part in a few million of the error.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::experiment::Point;
use crate::model::hem::{Hem, Placement};
use crate::numerics::double_double::DoubleDouble as Double;

/// Unknowns: x0, y0, phase, p, q, s.
const UNKNOWNS: usize = 6;
/// Newton's steps; five reach the last digit from a double's solution.
const STEPS: usize = 40;

/// An optimum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optimum {
    pub hem: Hem,
    pub placement: Placement,
    /// Ratio of the largest to the smallest singular value of the Jacobian, its columns scaled to unit length.
    pub condition: f64,
    /// Greatest difference of (x0, y0, p·phase, p, q, s) from the curve that the search began with, m.
    pub moved: f64,
    /// Greatest standard error of the same, m; infinite where the points do not determine them.
    pub standard_error: f64,
}

#[derive(Clone, Copy)]
struct Complex {
    re: Double,
    im: Double,
}

impl Complex {
    fn of_angle(t: f64) -> Self {
        let (sin, cos) = t.sin_cos();
        Complex { re: cos.into(), im: sin.into() }.unit()
    }

    fn unit(self) -> Self {
        let length = (self.re * self.re + self.im * self.im).sqrt();
        Complex { re: self.re / length, im: self.im / length }
    }

    fn times(self, other: Complex) -> Self {
        Complex { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }

    fn conjugate(self) -> Self {
        Complex { re: self.re, im: -self.im }
    }

    fn power(self, mut n: u32) -> Self {
        let (mut result, mut base) = (Complex { re: Double::ONE, im: Double::ZERO }, self);
        while 0 < n {
            if n % 2 == 1 {
                result = result.times(base);
            }
            base = base.times(base);
            n /= 2;
        }
        result
    }

    /// Turned by a small angle; of second order is enough, since it is normalized and looked at again.
    fn turned(self, by: Double) -> Self {
        let half = by * by.scale(0.5);
        self.times(Complex { re: Double::ONE - half, im: by }).unit()
    }
}

/// The curve at one foot, in the frame that turns with it.
struct Local {
    position: Complex,
    velocity: Complex,
    acceleration: Complex,
    cos_fold: Double,
    sin_lean: Double,
}

#[derive(Clone)]
struct Curve {
    x0: Double,
    y0: Double,
    phase: Complex,
    shape: [Double; 3],
    folds: u32,
}

impl Curve {
    fn local(&self, foot: Complex) -> Local {
        let [p, q, s] = self.shape;
        let m = Double::from(f64::from(self.folds));
        let fold = foot.power(self.folds);
        let (cos, sin) = (fold.re, fold.im);
        let sin_lean = (sin * cos).scale(2.0);
        let cos_lean = Double::ONE - (sin * sin).scale(2.0);
        let position = Complex { re: p + q * cos, im: s * sin_lean };
        let ms = (m * s).scale(2.0);
        // d/dt in the turning frame is ′ + i.
        let first = Complex { re: -(m * q * sin), im: ms * cos_lean };
        let velocity = Complex { re: first.re - position.im, im: first.im + position.re };
        let second = Complex { re: -(m * m * q * cos) - first.im, im: -(ms * m * sin_lean).scale(2.0) + first.re };
        let acceleration = Complex { re: second.re - velocity.im, im: second.im + velocity.re };
        Local { position, velocity, acceleration, cos_fold: cos, sin_lean }
    }

    fn moved(&self, by: &[f64; UNKNOWNS]) -> Curve {
        let [p, q, s] = self.shape;
        Curve {
            x0: self.x0 + by[0].into(),
            y0: self.y0 + by[1].into(),
            phase: self.phase.turned(by[2].into()),
            shape: [p + by[3].into(), q + by[4].into(), s + by[5].into()],
            folds: self.folds,
        }
    }
}

/// Moves every foot to where the distance is stationary; gradient of half the sum of squares, normal matrix, and that sum itself.
fn gradient(points: &[Point], curve: &Curve, feet: &mut [Complex]) -> ([Double; UNKNOWNS], DMatrix<f64>, f64) {
    let mut gradient = [Double::ZERO; UNKNOWNS];
    let mut normal = DMatrix::zeros(UNKNOWNS, UNKNOWNS);
    let mut square = 0.0;
    let back = curve.phase.conjugate();
    for (point, foot) in points.iter().zip(feet) {
        let from_centre = Complex { re: Double::from(point.x) - curve.x0, im: Double::from(point.y) - curve.y0 };
        let centred = from_centre.times(back);
        let mut local = curve.local(*foot);
        let mut offset = Complex { re: Double::ZERO, im: Double::ZERO };
        for _ in 0..8 {
            let turned = centred.times(foot.conjugate());
            offset = Complex { re: turned.re - local.position.re, im: turned.im - local.position.im };
            let (u, a) = (local.velocity, local.acceleration);
            let slope = offset.re * u.re + offset.im * u.im;
            let speed = u.re * u.re + u.im * u.im;
            let bend = speed - (offset.re * a.re + offset.im * a.im);
            let step = slope / if 0.1 * speed.to_f64() < bend.to_f64() { bend } else { speed };
            *foot = foot.turned(step);
            local = curve.local(*foot);
            // Newton squares what is left: below this it is beyond the last digit.
            if step.abs().to_f64() < 1e-16 {
                let turned = centred.times(foot.conjugate());
                offset = Complex { re: turned.re - local.position.re, im: turned.im - local.position.im };
                break;
            }
        }
        let (u, p) = (local.velocity, local.position);
        let speed = (u.re * u.re + u.im * u.im).sqrt();
        let (nr, nt) = (u.im / speed, -(u.re / speed));
        let distance = offset.re * nr + offset.im * nt;
        let direction = curve.phase.times(*foot);
        let row = [
            -(nr * direction.re - nt * direction.im),
            -(nr * direction.im + nt * direction.re),
            -(nt * p.re - nr * p.im),
            -nr,
            -(nr * local.cos_fold),
            -(nt * local.sin_lean),
        ];
        for (sum, column) in gradient.iter_mut().zip(row) {
            *sum = *sum + column * distance;
        }
        let row = row.map(Double::to_f64);
        for i in 0..UNKNOWNS {
            for j in 0..UNKNOWNS {
                normal[(i, j)] += row[i] * row[j];
            }
        }
        square += distance.to_f64().powi(2);
    }
    (gradient, normal, square)
}

/// The optimum next to a curve whose feet are known; `None` where it is not reached, or the points do not determine it.
pub fn optimum(points: &[Point], hem: Hem, placement: Placement, feet: &[f64]) -> Option<Optimum> {
    let mut feet: Vec<Complex> = feet.iter().map(|t| Complex::of_angle(*t)).collect();
    let begun = Curve {
        x0: placement.x0.into(),
        y0: placement.y0.into(),
        phase: Complex::of_angle(placement.phase),
        shape: [hem.p.into(), hem.q.into(), hem.s.into()],
        folds: hem.folds,
    };
    let mut curve = begun.clone();
    let (at_start, normal, square) = gradient(points, &curve, &mut feet);
    let scale: Vec<f64> = (0..UNKNOWNS).map(|j| normal[(j, j)].sqrt()).collect();
    if scale.iter().any(|s| !(s.is_finite() && 0.0 < *s)) {
        return None;
    }
    let scaled = DMatrix::from_fn(UNKNOWNS, UNKNOWNS, |i, j| normal[(i, j)] / (scale[i] * scale[j]));
    let values = SymmetricEigen::new(scaled.clone()).eigenvalues;
    let condition = (values.max() / values.min().max(0.0)).sqrt();
    let variance = square / (points.len() as f64 - UNKNOWNS as f64).max(1.0);
    let standard_error = scaled.try_inverse().map_or(f64::INFINITY, |inverse| {
        let error = |j: usize| (variance * inverse[(j, j)]).max(0.0).sqrt() / scale[j] * if j == 2 { hem.p } else { 1.0 };
        (0..UNKNOWNS).map(error).fold(0.0, f64::max)
    });
    // Newton's matrix by central differences of an exact gradient: the step is a millionth of the curve.
    let mut hessian = DMatrix::zeros(UNKNOWNS, UNKNOWNS);
    for j in 0..UNKNOWNS {
        let step = 1e-6 * if j == 2 { 1.0 } else { hem.p };
        let at = |sign: f64, feet: &[Complex]| {
            let mut by = [0.0; UNKNOWNS];
            by[j] = sign * step;
            gradient(points, &curve.moved(&by), &mut feet.to_vec()).0
        };
        let (up, down) = (at(1.0, &feet), at(-1.0, &feet));
        for i in 0..UNKNOWNS {
            hessian[(i, j)] = (up[i] - down[i]).to_f64() / (2.0 * step) / (scale[i] * scale[j]);
        }
    }
    let inverse = (0.5 * (&hessian + hessian.transpose())).try_inverse()?;
    let mut slope = at_start;
    let mut least = f64::INFINITY;
    for _ in 0..STEPS {
        let right = DVector::from_fn(UNKNOWNS, |j, _| -slope[j].to_f64() / scale[j]);
        let step = &inverse * right;
        let by: [f64; UNKNOWNS] = std::array::from_fn(|j| step[j] / scale[j]);
        let size = by.iter().enumerate().map(|(j, v)| v.abs() * if j == 2 { hem.p } else { 1.0 }).fold(0.0, f64::max);
        if !size.is_finite() || 0.5 * hem.p < size {
            return None;
        }
        curve = curve.moved(&by);
        if size < 1e-24 * hem.p {
            least = size;
            break;
        }
        least = least.min(size);
        slope = gradient(points, &curve, &mut feet).0;
    }
    // A step that short leaves more than twice the digits of a double.
    if 1e-18 * hem.p < least {
        return None;
    }
    let shift = curve.phase.times(begun.phase.conjugate()).im;
    let [p, q, s] = [0, 1, 2].map(|k| curve.shape[k] - begun.shape[k]);
    let moved = [curve.x0 - begun.x0, curve.y0 - begun.y0, shift * hem.p.into(), p, q, s];
    let moved = moved.iter().map(|d| d.abs().to_f64()).fold(0.0, f64::max);
    let [p, q, s] = curve.shape.map(Double::to_f64);
    Some(Optimum {
        hem: Hem { p, q, s, folds: hem.folds },
        placement: Placement { x0: curve.x0.to_f64(), y0: curve.y0.to_f64(), phase: placement.phase + shift.to_f64() },
        condition,
        moved,
        standard_error,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::drawn::{AT, HEM, noisy};

    #[test]
    fn the_optimum_does_not_depend_on_where_it_is_looked_for() {
        let points = noisy(&HEM, 120, 1e-3, 1);
        let feet = |hem: &Hem, at: &Placement| -> Vec<f64> {
            use crate::fit::foot_point::{centred, nearest};
            points.iter().map(|p| nearest(hem, centred(*p, at), 24).t).collect()
        };
        let from = |hem: Hem, at: Placement| optimum(&points, hem, at, &feet(&hem, &at)).expect("a minimum");
        let near = from(HEM, AT);
        let far = from(Hem { p: 0.2003, q: 0.0297, s: 0.0082, ..HEM }, Placement { x0: 0.0302, phase: 0.301, ..AT });
        for (a, b) in [(near.hem.p, far.hem.p), (near.hem.q, far.hem.q), (near.hem.s, far.hem.s), (near.placement.x0, far.placement.x0)] {
            // Both are doubles rounded from twice as many digits.
            assert!((a - b).abs() <= 2.0 * f64::EPSILON * 0.2, "{a} {b}");
        }
        assert!(1.0 <= near.condition && near.condition < 10.0 && near.moved < 1e-3);
    }

    #[test]
    fn points_on_a_curve_give_that_curve() {
        let feet: Vec<f64> = (0..90).map(|i| std::f64::consts::TAU * f64::from(i) / 90.0).collect();
        let found = optimum(&HEM.outline(&AT, 90), HEM, AT, &feet).expect("a minimum");
        // The points are rounded to 1e-17 m or so each.
        assert!(found.moved < 1e-16 && found.standard_error < 1e-16, "{found:?}");
    }
}
