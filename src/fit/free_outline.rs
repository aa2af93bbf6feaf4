//! The free closed outline: as many harmonics of the tangent angle as the points speak for, fitted by orthogonal distance.
//!
//! It is the saturated model: whatever hem there is, it can follow, so what it leaves is error of the points. Its order is chosen by Schwarz's
//! criterion (Ann. Statist. 6 (1978) 461–464): a harmonic too many would take noise for misfit of other curves, and Akaike's takes one in six.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::outcome::Rule;
use super::outline::{Outline, centroid, fractions};
use super::sane_curve;
use super::tangent_curve::{C, TangentCurve};
use super::tangent_family::sines_of;
use super::tangent_fit::{Closing, Family, Fitted, Placed, fit};
use crate::error::Error;
use crate::experiment::Point;
use crate::model::hem::Hem;
use crate::numerics::least_squares;

/// Highest order tried: 24 folds of four harmonics.
const HIGHEST_ORDER: usize = 96;
/// Share of the outline, to each side of its place along the smooth curve, in which a point's foot is first looked for.
const WINDOW: f64 = TAU / 16.0;
/// A curve that leaves so many times what the free outline does lacks fit whatever the order: errors alone leave it twice as much at most, because no
/// more unknowns are fitted than half the points.
const CLEARLY: f64 = 4.0;

/// A fitted free outline.
#[derive(Debug, Clone)]
pub struct FreeOutline {
    pub placed: Placed,
    /// Highest harmonic of the tangent angle.
    pub order: usize,
    /// σ of each point's foot.
    pub feet: Vec<f64>,
    /// Signed distances, m, positive outside.
    pub distances: Vec<f64>,
    /// m².
    pub sum_of_squares: f64,
    /// Centre, radius and all coefficients but the two that close it.
    pub unknowns: usize,
    pub termination: least_squares::Termination,
    /// The rule of a sane outline that it breaks, if one.
    pub broken: Option<Rule>,
    /// Whether what another curve leaves beyond this one is that curve's lack of fit: this one holds it, or is far nearer to the points.
    pub comparable: bool,
    /// Residual vectors evaluated.
    pub evaluations: usize,
    /// Jacobian of the distances at the end: x0, y0, R and the free coordinates.
    pub(super) jacobian: DMatrix<f64>,
    pub(super) closing: Closing,
}

impl FreeOutline {
    /// σ̂, m: what is left, over its degrees of freedom.
    pub fn noise(&self) -> f64 {
        (self.sum_of_squares / (self.distances.len() - self.unknowns) as f64).sqrt()
    }
}

/// Harmonics that even a round outline is tried with.
const FEWEST_HARMONICS: usize = 6;
/// Harmonics of the tangent angle that deep folds, all alike, have.
const EVEN_HARMONICS: usize = 8;

/// Fits the free outline to the points that `outline` smooths, so that it can be held against another curve.
///
/// Where that one leaves no more than [`CLEARLY`] times as much (`left`, m²), the order is at least `holds`, from which on the free outline holds it.
///
/// # Errors
/// [`Error::Unanswerable`] if there are fewer than eight points, or if even a few harmonics do not close.
pub fn free_outline(points: &[Point], outline: &Outline, holds: usize, left: f64) -> Result<FreeOutline, Error> {
    let most = (points.len() / 4).min(HIGHEST_ORDER);
    if most < 2 {
        return Err(Error::Unanswerable(format!("{} points are too few for a free outline", points.len())));
    }
    // The smooth outline's own order is evidence already, of another series: a few more are enough to choose from. Even folds say less of it:
    // the tangent angle of deep ones has eight harmonics.
    let enough = if outline.even { EVEN_HARMONICS * (outline.order / 2) } else { outline.order + 4 };
    let highest = enough.max(FEWEST_HARMONICS).min(most);
    let (start, turn) = start(outline, highest);
    let (places, _) = fractions(points);
    let feet = start.nearest(points, places.iter().map(|f| TAU * f + turn), WINDOW);
    // Only the linear model about it is wanted, and the last digits of the minimum do not move that.
    let rough = least_squares::Options { gradient_tolerance: 1e-2, evaluation_limit: 30, ..least_squares::Options::default() };
    let wide = fit(points, &Family::Free, start, feet, &rough)?;
    let orders = Orders::of(&wide);
    let (mut order, expected) = orders.by_evidence();
    let near = left <= CLEARLY * expected;
    let least = if near { holds.clamp(2, most) } else { 2 };
    order = order.max(least);
    let mut evaluations = wide.summary.evaluations;
    loop {
        // A cosine of 1e-7 leaves the sum of squares right to 1e-14.
        let fine = least_squares::Options { gradient_tolerance: 1e-7, evaluation_limit: 60, ..least_squares::Options::default() };
        let fitted = fit(points, &Family::Free, orders.placed(order), wide.feet.clone(), &fine)?;
        evaluations += fitted.summary.evaluations;
        let farthest = fitted.summary.residuals.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
        let broken = sane_curve::broken(&fitted.placed, outline, &fitted.feet, farthest, outline.length);
        if broken.is_none() || order <= least {
            return Ok(FreeOutline {
                order,
                unknowns: 2 * order + 1,
                feet: fitted.feet,
                sum_of_squares: fitted.summary.sum_of_squares,
                distances: fitted.summary.residuals,
                termination: fitted.summary.termination,
                broken,
                comparable: !near || holds <= order,
                evaluations,
                jacobian: fitted.summary.jacobian,
                closing: fitted.closing.expect("a free curve is closed"),
                placed: fitted.placed,
            });
        }
        order = (3 * order / 4).max(least);
    }
}

/// The order from which on the free outline holds the paper's curve, to a third of the standard error of its mean position.
///
/// The rms distance `rms` (m) of n points stands for their error: where it is misfit instead, the difference is large at any order.
pub fn order_that_holds(hem: &Hem, rms: f64, n: usize) -> usize {
    if hem.folds == 0 {
        return 1;
    }
    let sines = sines_of(hem, 32);
    let radius = hem.perimeter() / TAU;
    let allowed = (rms / 3.0).powi(2) / n as f64;
    // A coefficient a of harmonic k moves the curve by about a/k radii.
    let mut left = 0.0;
    for (k, a) in (1..).zip(&sines).collect::<Vec<(usize, &f64)>>().into_iter().rev() {
        left += 0.5 * (radius * a / (k as f64 * f64::from(hem.folds))).powi(2);
        if allowed < left {
            return k * hem.folds as usize;
        }
    }
    hem.folds as usize
}

/// The tangent angle of the smooth outline, to `order` harmonics, and σ of its first sample.
fn start(outline: &Outline, order: usize) -> (Placed, f64) {
    let samples = &outline.samples;
    let n = samples.len();
    let mut psi = Vec::with_capacity(n);
    let mut last = f64::NAN;
    for j in 0..n {
        let (before, after) = (samples[(j + n - 1) % n], samples[(j + 1) % n]);
        let angle = (after.y - before.y).atan2(after.x - before.x) - TAU * (0.25 + j as f64 / n as f64);
        let angle = if last.is_nan() { angle } else { angle - TAU * ((angle - last) / TAU).round() };
        psi.push(angle);
        last = angle;
    }
    // Its mean is the σ of the first sample: with it ψ has none.
    let turn = psi.iter().sum::<f64>() / n as f64;
    let table: Vec<(f64, f64)> = (0..n).map(|j| (TAU * j as f64 / n as f64).sin_cos()).collect();
    let (mut cosines, mut sines) = (Vec::with_capacity(order), Vec::with_capacity(order));
    for k in 1..=order {
        let sums = psi.iter().enumerate().map(|(j, v)| (v * table[j * k % n].1, v * table[j * k % n].0));
        let (a, b) = sums.fold((0.0, 0.0), |s, v| (s.0 + v.0, s.1 + v.1));
        // From the place along the outline to σ.
        let turned = C::new(a, -b) * C::from_polar(2.0 / n as f64, -(k as f64) * turn);
        cosines.push(turned.re);
        sines.push(-turned.im);
    }
    let (x, y) = centroid(samples);
    let placed =
        Placed { curve: TangentCurve::new(1, &cosines, &sines), centre: Point::new(x, y), phase: 0.0, radius: outline.length / TAU };
    (placed, turn)
}

/// The free outlines of all orders below that of a fitted one, from the linear model about it.
///
/// One triangle serves all: without the harmonics above k the sum of squares grows by the square of what they alone reach.
struct Orders<'a> {
    wide: &'a Fitted,
    /// Of the distances by x0, y0, R, then cosine and sine of each harmonic; two heavy rows keep the curve closed.
    triangle: DMatrix<f64>,
    /// Cosine and sine of each harmonic, after three zeros.
    coefficients: Vec<f64>,
}

impl<'a> Orders<'a> {
    fn of(wide: &'a Fitted) -> Self {
        let curve = &wide.placed.curve;
        let (n, orders) = (wide.feet.len(), curve.sines().len());
        let sensitivities = curve.sensitivities();
        let mut rows = DMatrix::zeros(n + 2, 3 + 2 * orders);
        let place = |column: usize| 3 + if column < orders { 2 * column } else { 2 * (column - orders) + 1 };
        for (i, &sigma) in wide.feet.iter().enumerate() {
            let at = curve.at(sigma);
            let normal = at.first * C::new(0.0, -1.0) / at.first.norm();
            let along = |v: C| normal.re * v.re + normal.im * v.im;
            (rows[(i, 0)], rows[(i, 1)], rows[(i, 2)]) = (normal.re, normal.im, along(at.position));
            sensitivities.along(sigma, normal, |column, moved| rows[(i, place(column))] = wide.placed.radius * moved);
        }
        let heavy = 1e4 * wide.placed.radius * (n as f64).sqrt();
        for (column, gap) in curve.gap_gradient().into_iter().enumerate() {
            (rows[(n, place(column))], rows[(n + 1, place(column))]) = (heavy * gap.re, heavy * gap.im);
        }
        let pairs = curve.cosines().iter().zip(curve.sines()).flat_map(|(a, b)| [*a, *b]);
        Orders { wide, triangle: rows.qr().r(), coefficients: [0.0; 3].into_iter().chain(pairs).collect() }
    }

    /// The order of least criterion, and the sum of squares expected of it, m².
    fn by_evidence(&self) -> (usize, f64) {
        let columns = self.triangle.ncols();
        let points = self.wide.feet.len() as f64;
        let criterion =
            |order: usize, square: f64| points * (square / points).max(f64::MIN_POSITIVE).ln() + (2 * order + 1) as f64 * points.ln();
        let mut square = self.wide.summary.sum_of_squares;
        let highest = (columns - 3) / 2;
        let mut best = (criterion(highest, square), highest, square);
        for order in (2..highest).rev() {
            for row in [3 + 2 * order, 4 + 2 * order] {
                let reached: f64 = (row..columns).map(|j| self.triangle[(row, j)] * self.coefficients[j]).sum();
                square += reached * reached;
            }
            let value = criterion(order, square);
            if value <= best.0 {
                best = (value, order, square);
            }
        }
        (best.1, best.2)
    }

    /// Where the minimum of this order is expected; of a higher order, the curve itself.
    fn placed(&self, order: usize) -> Placed {
        let (columns, wide) = (self.triangle.ncols(), &self.wide.placed);
        let kept = 3 + 2 * order;
        let mut all = self.coefficients.clone();
        let mut moved = [0.0; 3];
        if kept < columns {
            // R₁₁ δ₁ = R₁₂ a₂: the harmonics that stay take over what they can of those that go.
            let gone = DVector::from_column_slice(&all[kept..]);
            let right = self.triangle.view((0, kept), (kept, columns - kept)) * gone;
            if let Some(step) = self.triangle.view((0, 0), (kept, kept)).solve_upper_triangular(&right) {
                moved = [step[0], step[1], step[2]];
                all[3..kept].iter_mut().zip(step.iter().skip(3)).for_each(|(a, d)| *a += d);
            }
        }
        all.resize(kept, 0.0);
        let (cosines, sines): (Vec<f64>, Vec<f64>) = all[3..].chunks(2).map(|pair| (pair[0], pair[1])).unzip();
        let centre = Point::new(wide.centre.x + moved[0], wide.centre.y + moved[1]);
        Placed { curve: TangentCurve::new(1, &cosines, &sines), centre, radius: wide.radius + moved[2], ..*wide }
    }
}
