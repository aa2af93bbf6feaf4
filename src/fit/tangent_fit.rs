//! The orthogonal distance fit of curves given by their tangent angle: m equal folds, or free.
//!
//! Unknowns are the centre, the phase (of equal folds), the radius R whose 2πR is the length, and the coefficients. As in
//! [`super::orthogonal`] the foot of each point is stationary, so a row of the Jacobian is `−n·∂c/∂θ`. A free curve closes only if the mean of
//! its unit tangent vanishes; the two directions of the coefficients that close it fastest at the start are solved for, the others are free.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::tangent_curve::{C, Foot, TangentCurve};
use crate::error::Error;
use crate::experiment::Point;
use crate::numerics::least_squares::{self, Options, Problem, Summary};

/// Which curves are fitted.
#[derive(Debug, Clone, PartialEq)]
pub enum Family {
    /// m equal folds by K sines; R held if given, m.
    EqualFolds { folds: u32, radius: Option<f64> },
    /// Any closed curve: K cosines and sines.
    Free,
}

/// A curve and where it lies.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    pub curve: TangentCurve,
    /// m.
    pub centre: Point,
    /// Direction of the crest σ = 0 of equal folds, rad; 0 of a free curve.
    pub phase: f64,
    /// Length over 2π, m.
    pub radius: f64,
}

impl Placed {
    /// With a curve that is [slim](TangentCurve::slim).
    pub fn slim(self) -> Self {
        Placed { curve: self.curve.slim(), ..self }
    }

    /// The point at σ, m.
    pub fn point(&self, sigma: f64) -> Point {
        self.placed(self.curve.at(sigma).position)
    }

    fn placed(&self, w: C) -> Point {
        let z = C::from_polar(self.radius, self.phase) * w;
        Point::new(self.centre.x + z.re, self.centre.y + z.im)
    }

    /// `n` points at equal steps of length, m.
    pub fn outline(&self, n: usize) -> Vec<Point> {
        (0..n).map(|i| self.point(TAU * i as f64 / n as f64)).collect()
    }

    /// Measured points in the frame of the curve, unit radius.
    fn own(&self, points: &[Point]) -> Vec<C> {
        let turn = C::from_polar(1.0 / self.radius, -self.phase);
        points.iter().map(|point| C::new(point.x - self.centre.x, point.y - self.centre.y) * turn).collect()
    }

    /// The foot of each of `points` near the σ of `from`, in the frame of the curve, unit radius.
    pub fn follow(&self, points: &[Point], from: &[f64]) -> Vec<Foot> {
        self.curve.follow(&self.own(points), from)
    }

    /// The feet of `points` that are nearest within `window` of `sigmas` either way.
    pub fn nearest(&self, points: &[Point], sigmas: impl Iterator<Item = f64>, window: f64) -> Vec<f64> {
        let (nodes, own) = (self.curve.nodes(), self.own(points));
        let n = nodes.len() as i64;
        let half = ((window / TAU * n as f64) as i64).clamp(1, n / 2);
        let near = |(own, sigma): (&C, f64)| {
            let middle = (sigma / TAU * n as f64).round() as i64;
            let square = |j: &i64| (nodes[j.rem_euclid(n) as usize].1 - own).norm_sqr();
            let best = (middle - half..=middle + half).min_by(|a, b| square(a).total_cmp(&square(b))).unwrap_or(middle);
            TAU * best as f64 / n as f64
        };
        let from: Vec<f64> = own.iter().zip(sigmas).map(near).collect();
        self.curve.follow(&own, &from).iter().map(|foot| foot.sigma).collect()
    }
}

/// A fitted curve.
#[derive(Debug, Clone)]
pub struct Fitted {
    pub placed: Placed,
    /// σ of each point's foot.
    pub feet: Vec<f64>,
    /// Distances, Jacobian, ending; unknowns x0, y0, (phase,) (R,) then the sines, or R and the directions of [`Closing`].
    pub summary: Summary,
    /// Of a free curve.
    pub closing: Option<Closing>,
}

impl Fitted {
    /// Root mean square distance, m.
    pub fn rms(&self) -> f64 {
        (self.summary.sum_of_squares / self.feet.len() as f64).sqrt()
    }
}

/// Fits `family` from a curve and the points' feet on it.
///
/// # Errors
/// [`Error::Unanswerable`] with fewer points than unknowns, or if a free curve cannot be closed from its start.
pub fn fit(points: &[Point], family: &Family, start: Placed, feet: Vec<f64>, options: &Options) -> Result<Fitted, Error> {
    let closing = match family {
        Family::EqualFolds { .. } => None,
        Family::Free => Some(Closing::of(&start.curve).ok_or_else(|| Error::Unanswerable("a curve that cannot be closed".into()))?),
    };
    let mut unknowns = vec![start.centre.x, start.centre.y];
    match family {
        Family::EqualFolds { radius, .. } => {
            unknowns.push(start.phase);
            unknowns.extend(radius.is_none().then_some(start.radius));
            unknowns.extend(start.curve.sines());
        }
        Family::Free => {
            unknowns.push(start.radius);
            unknowns.extend(std::iter::repeat_n(0.0, 2 * start.curve.sines().len() - 2));
        }
    }
    let size = points.iter().map(|p| p.x.abs().max(p.y.abs())).fold(start.radius, f64::max);
    let options = &Options { residual_rounding: 4.0 * f64::EPSILON * size, ..*options };
    let mut problem = Tangent {
        points,
        family: family.clone(),
        closing,
        lambda: [0.0; 2],
        trial_lambda: [0.0; 2],
        feet,
        trial: Vec::new(),
        placed: start,
    };
    let summary = least_squares::solve(&mut problem, &unknowns, options)?;
    if let Some(placed) = problem.at(&summary.parameters) {
        problem.placed = placed;
    }
    Ok(Fitted { placed: problem.placed, feet: problem.feet, summary, closing: problem.closing })
}

struct Tangent<'a> {
    points: &'a [Point],
    family: Family,
    closing: Option<Closing>,
    /// What closes the curve at the iterate, and at the last evaluation.
    lambda: [f64; 2],
    trial_lambda: [f64; 2],
    feet: Vec<f64>,
    /// Feet on the curve last evaluated; none before the first.
    trial: Vec<Foot>,
    /// The curve last evaluated.
    placed: Placed,
}

impl Tangent<'_> {
    fn at(&mut self, unknowns: &[f64]) -> Option<Placed> {
        let centre = Point::new(unknowns[0], unknowns[1]);
        match &self.family {
            Family::EqualFolds { radius, .. } => {
                let (radius, sines) = match radius {
                    Some(radius) => (*radius, &unknowns[3..]),
                    None => (unknowns[3], &unknowns[4..]),
                };
                let curve = self.placed.curve.with(&vec![0.0; sines.len()], sines);
                Some(Placed { curve, centre, phase: unknowns[2], radius })
            }
            Family::Free => {
                let closing = self.closing.as_ref().expect("a free curve is closed");
                let (curve, lambda) = closing.closed(&self.placed.curve, &unknowns[3..], self.lambda)?;
                self.trial_lambda = lambda;
                Some(Placed { curve, centre, phase: 0.0, radius: unknowns[2] })
            }
        }
    }
}

impl Problem for Tangent<'_> {
    fn residual_count(&self) -> usize {
        self.points.len()
    }

    fn residuals(&mut self, unknowns: &[f64], residuals: &mut [f64]) -> bool {
        // A tangent that turns further than this winds the curve into loops.
        if !unknowns.iter().all(|u| u.is_finite()) {
            return false;
        }
        let Some(placed) = self.at(unknowns).filter(|p| 0.0 < p.radius) else { return false };
        self.trial = placed.follow(self.points, &self.feet);
        for (residual, foot) in residuals.iter_mut().zip(&self.trial) {
            *residual = placed.radius * foot.distance;
        }
        self.placed = placed;
        true
    }

    fn jacobian(&mut self, _unknowns: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
        let Placed { curve, phase, radius, .. } = &self.placed;
        let sensitivities = curve.sensitivities();
        let turn = C::from_polar(1.0, *phase);
        let mut raw = DMatrix::zeros(self.points.len(), sensitivities.count());
        for (i, &Foot { sigma, position, normal, .. }) in self.trial.iter().enumerate() {
            // The outward normal in the measurement's frame.
            let world = turn * normal;
            let along = |v: C| normal.re * v.re + normal.im * v.im;
            (jacobian[(i, 0)], jacobian[(i, 1)]) = (-world.re, -world.im);
            let by_radius = -along(position);
            match &self.family {
                Family::EqualFolds { radius: held, .. } => {
                    jacobian[(i, 2)] = -radius * along(C::new(0.0, 1.0) * position);
                    if held.is_none() {
                        jacobian[(i, 3)] = by_radius;
                    }
                }
                Family::Free => jacobian[(i, 2)] = by_radius,
            }
            sensitivities.along(sigma, normal, |column, moved| raw[(i, column)] = -radius * moved);
        }
        match &self.closing {
            None => {
                let before = jacobian.ncols() - raw.ncols();
                jacobian.columns_mut(before, raw.ncols()).copy_from(&raw);
            }
            Some(closing) => jacobian.columns_mut(3, raw.ncols() - 2).copy_from(&closing.free(curve, raw)),
        }
        true
    }

    fn accept(&mut self) -> bool {
        self.feet = self.trial.iter().map(|foot| foot.sigma).collect();
        self.lambda = self.trial_lambda;
        true
    }
}

/// Coordinates of the coefficients in which two close the curve and the others are free.
#[derive(Debug, Clone, PartialEq)]
pub struct Closing {
    /// The coefficients about which it was made, cosines then sines.
    origin: Vec<f64>,
    /// Two Householder reflections: the first two columns of their product are the closing directions.
    mirrors: [DVector<f64>; 2],
}

/// Newton steps that close the curve: quadratic, from nearby.
const CLOSING_STEPS: usize = 12;

impl Closing {
    /// `None` if no coefficient closes the curve.
    fn of(curve: &TangentCurve) -> Option<Closing> {
        let gradient = curve.gap_gradient();
        let n = gradient.len();
        let mirror = |v: DVector<f64>, from: usize| {
            let mut v = v;
            v.rows_mut(0, from).fill(0.0);
            let norm = v.norm();
            v[from] += norm.copysign(v[from]);
            let size = v.norm();
            (1e-6 < norm).then(|| v / size)
        };
        let first = mirror(DVector::from_iterator(n, gradient.iter().map(|g| g.re)), 0)?;
        let mut second = DVector::from_iterator(n, gradient.iter().map(|g| g.im));
        reflect(&first, &mut second);
        let second = mirror(second, 1)?;
        let origin = curve.cosines().iter().chain(curve.sines()).copied().collect();
        Some(Closing { origin, mirrors: [first, second] })
    }

    /// The coefficients at these coordinates.
    fn coefficients(&self, lambda: [f64; 2], free: &[f64]) -> Vec<f64> {
        let mut v = DVector::from_iterator(self.origin.len(), lambda.iter().chain(free).copied());
        reflect(&self.mirrors[1], &mut v);
        reflect(&self.mirrors[0], &mut v);
        self.origin.iter().zip(v.iter()).map(|(o, v)| o + v).collect()
    }

    /// The closed curve of these free coordinates, and what closed it; `like` is any of as many coefficients.
    fn closed(&self, like: &TangentCurve, free: &[f64], mut lambda: [f64; 2]) -> Option<(TangentCurve, [f64; 2])> {
        let orders = self.origin.len() / 2;
        for _ in 0..CLOSING_STEPS {
            let coefficients = self.coefficients(lambda, free);
            let curve = like.with(&coefficients[..orders], &coefficients[orders..]);
            let gap = curve.gap();
            if gap.norm() < 1e-14 {
                return Some((curve, lambda));
            }
            let [a, b] = self.by_lambda(&curve);
            let determinant = a.re * b.im - b.re * a.im;
            if determinant.abs() < 1e-6 {
                return None;
            }
            lambda[0] -= (gap.re * b.im - b.re * gap.im) / determinant;
            lambda[1] -= (a.re * gap.im - gap.re * a.im) / determinant;
        }
        None
    }

    /// Derivatives of the gap by the coordinates, closing ones first.
    fn gap_gradient(&self, curve: &TangentCurve) -> [DVector<f64>; 2] {
        let gradient = curve.gap_gradient();
        let part = |pick: fn(&C) -> f64| {
            let mut v = DVector::from_iterator(gradient.len(), gradient.iter().map(pick));
            reflect(&self.mirrors[0], &mut v);
            reflect(&self.mirrors[1], &mut v);
            v
        };
        [part(|g| g.re), part(|g| g.im)]
    }

    fn by_lambda(&self, curve: &TangentCurve) -> [C; 2] {
        let [re, im] = self.gap_gradient(curve);
        [C::new(re[0], im[0]), C::new(re[1], im[1])]
    }

    /// Derivatives by the free coordinates along closed curves, from rows of derivatives by the coefficients.
    pub(super) fn free(&self, curve: &TangentCurve, mut rows: DMatrix<f64>) -> DMatrix<f64> {
        for mirror in &self.mirrors {
            let along = &rows * mirror;
            rows.ger(-2.0, &along, mirror, 1.0);
        }
        let [re, im] = self.gap_gradient(curve);
        let determinant = re[0] * im[1] - re[1] * im[0];
        let n = rows.ncols();
        let mut free = rows.columns(2, n - 2).into_owned();
        // dλ/du = −G_λ⁻¹ G_u, both rows at once.
        let by = |sign: usize| {
            DVector::from_fn(n - 2, |j, _| match sign {
                0 => -(im[1] * re[j + 2] - re[1] * im[j + 2]) / determinant,
                _ => -(re[0] * im[j + 2] - im[0] * re[j + 2]) / determinant,
            })
        };
        free.ger(1.0, &rows.column(0), &by(0), 1.0);
        free.ger(1.0, &rows.column(1), &by(1), 1.0);
        free
    }
}

fn reflect(mirror: &DVector<f64>, v: &mut DVector<f64>) {
    let along = mirror.dot(v);
    v.axpy(-2.0 * along, mirror, 1.0);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A problem about `start`, its points a little off the curve.
    fn problem(points: &[Point], family: Family, start: Placed) -> Tangent<'_> {
        let closing = (family == Family::Free).then(|| Closing::of(&start.curve).expect("it closes"));
        let feet: Vec<f64> = (0..points.len()).map(|i| TAU * i as f64 / points.len() as f64).collect();
        Tangent { points, family, closing, lambda: [0.0; 2], trial_lambda: [0.0; 2], feet, trial: Vec::new(), placed: start }
    }

    fn agrees(family: Family, start: Placed, unknowns: &[f64]) {
        let mut points = start.outline(60);
        for (i, p) in points.iter_mut().enumerate() {
            p.x += 0.001 * (5.0 * i as f64).sin();
            p.y += 0.001 * (3.0 * i as f64).cos();
        }
        let mut problem = problem(&points, family, start);
        let mut exact = DMatrix::zeros(points.len(), unknowns.len());
        let mut distances = vec![0.0; points.len()];
        assert!(problem.residuals(unknowns, &mut distances) && problem.jacobian(unknowns, &mut exact));
        let h = 1e-6;
        for column in 0..unknowns.len() {
            let mut at = |by: f64| {
                let mut moved = unknowns.to_vec();
                moved[column] += by;
                let mut distances = vec![0.0; points.len()];
                assert!(problem.residuals(&moved, &mut distances));
                distances
            };
            let (up, down) = (at(h), at(-h));
            for i in 0..points.len() {
                let numeric = (up[i] - down[i]) / (2.0 * h);
                // Rounding eps·R/h ~ 1e-10; a foot is stationary to 1e-9; cubic against quintic interpolation 1e-7 of a column of at most 0.2.
                assert!((exact[(i, column)] - numeric).abs() < 1e-6, "{column} {i}: {} {numeric}", exact[(i, column)]);
            }
        }
    }

    #[test]
    fn the_jacobian_of_equal_folds_agrees_with_central_differences() {
        let curve = TangentCurve::new(5, &[0.0; 2], &[0.9, -0.05]);
        let start = Placed { curve, centre: Point::new(0.02, -0.01), phase: 0.3, radius: 0.2 };
        agrees(Family::EqualFolds { folds: 5, radius: None }, start.clone(), &[0.02, -0.01, 0.3, 0.2, 0.9, -0.05]);
        agrees(Family::EqualFolds { folds: 5, radius: Some(0.2) }, start, &[0.02, -0.01, 0.3, 0.9, -0.05]);
    }

    #[test]
    fn the_jacobian_of_a_free_outline_agrees_with_central_differences_along_closed_curves() {
        let curve = TangentCurve::new(1, &[0.05, -0.1, 0.3, 0.02], &[-0.02, 0.2, 0.1, -0.05]);
        // It does not close as it stands: what closes it is found first, and stays so along every column.
        let start = Placed { curve, centre: Point::new(0.02, -0.01), phase: 0.0, radius: 0.2 };
        let closing = Closing::of(&start.curve).expect("it closes");
        let (closed, _) = closing.closed(&start.curve, &[0.0; 6], [0.0; 2]).expect("it closes");
        assert!(closed.gap().norm() < 1e-14);
        let start = Placed { curve: closed, ..start };
        agrees(Family::Free, start, &[0.02, -0.01, 0.2, 0.01, -0.02, 0.0, 0.015, 0.0, 0.01]);
    }
}
