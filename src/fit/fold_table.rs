//! Fold by fold: where each crest of an outline lies, how deep and wide its fold is, and by how much it leans over.
//!
//! Crests and valleys are the extrema of the distance from the centroid of the outline's length, along the free outline. All numbers are functions of its
//! coefficients, so each has a standard error by linear propagation; it assumes independent errors of the points, as all standard errors here do.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};

use super::free_outline::FreeOutline;
use super::outcome::Estimate;
use super::tangent_curve::C;

/// What counts as a fold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// A wave shallower than this share of the mean radius is a ripple: 2 % are 3 mm of a skirt, which nobody counts as a fold.
    pub least_depth: f64,
    /// … and one shallower than this many standard errors of the curve may be noise.
    pub least_errors: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options { least_depth: 0.02, least_errors: 4.0 }
    }
}

/// One fold: a crest between two valleys.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fold {
    /// Direction of the crest from the centroid, rad, 0…2π.
    pub angle: Estimate,
    /// Share of the outline's length from the first crest of the table, 0…1; without an error for that one.
    pub place: Estimate,
    /// Distance of the crest from the centroid, m.
    pub radius: Estimate,
    /// Crest less the mean of both valleys, m.
    pub depth: Estimate,
    /// Share of the outline's length between the valleys.
    pub width: Estimate,
    /// Angle between the valleys, rad.
    pub width_angle: Estimate,
    /// How far the outline runs backwards about the centroid within the fold, on its worse side, rad; 0 without an error if it does not.
    pub overhang_angle: Estimate,
    /// The same as a length at the middle radius of what overhangs, m.
    pub overhang: Estimate,
}

/// All folds of one outline.
#[derive(Debug, Clone, PartialEq)]
pub struct FoldTable {
    /// In order round the outline, from the least angle. None where it is round.
    pub folds: Vec<Fold>,
    /// Standard deviation of the depths over their mean; `None` with fewer than two folds.
    pub depth_variation: Option<f64>,
    /// Standard deviation of the widths (length) over their mean.
    pub width_variation: Option<f64>,
}

/// A stationary point of the radius.
#[derive(Debug, Clone, Copy)]
struct Extremum {
    sigma: f64,
    radius: f64,
    crest: bool,
}

/// Scanned intervals of the outline: 60 folds get 34 each.
const SCAN: usize = 2048;

/// The folds of a free outline.
pub fn fold_table(outline: &FreeOutline, options: &Options) -> FoldTable {
    let spread = outline.noise() * (outline.unknowns as f64 / outline.distances.len() as f64).sqrt();
    let radius = outline.placed.radius;
    // The difference of a crest and a valley has √2 times the error of either.
    let least = (options.least_errors * std::f64::consts::SQRT_2 * spread).max(options.least_depth * radius);
    let extrema = prominent(extrema(outline), least);
    let crests: Vec<usize> = (0..extrema.len()).filter(|&i| extrema[i].crest).collect();
    let mut ask = Asked::of(outline);
    let n = extrema.len();
    let mut rows: Vec<Row> = crests
        .iter()
        .map(|&i| {
            let before = Extremum { sigma: extrema[(i + n - 1) % n].sigma - if i == 0 { TAU } else { 0.0 }, ..extrema[(i + n - 1) % n] };
            let after = Extremum { sigma: extrema[(i + 1) % n].sigma + if i + 1 == n { TAU } else { 0.0 }, ..extrema[(i + 1) % n] };
            ask.row(before, extrema[i], after)
        })
        .collect();
    rows.sort_by(|a, b| a.angle.total_cmp(&b.angle));
    let factor = ask.factor();
    let first = rows.first().map(|row| row.crest);
    let folds: Vec<Fold> = rows.iter().map(|row| row.fold(&ask, &factor, first.expect("a row"))).collect();
    let variation = |pick: fn(&Fold) -> f64| {
        let k = folds.len() as f64;
        let mean = folds.iter().map(pick).sum::<f64>() / k;
        let square = folds.iter().map(|f| (pick(f) - mean).powi(2)).sum::<f64>();
        (1 < folds.len()).then(|| (square / (k - 1.0)).sqrt() / mean)
    };
    FoldTable { depth_variation: variation(|f| f.depth.value), width_variation: variation(|f| f.width.value), folds }
}

/// Crests and valleys in order, alternating.
fn extrema(outline: &FreeOutline) -> Vec<Extremum> {
    let curve = &outline.placed.curve;
    let slope = |sigma: f64| {
        let place = curve.at(sigma);
        place.position.re * place.first.re + place.position.im * place.first.im
    };
    let at = |j: usize| TAU * j as f64 / SCAN as f64;
    let slopes: Vec<f64> = (0..=SCAN).map(|j| slope(at(j))).collect();
    let mut found = Vec::new();
    for j in 0..SCAN {
        if (0.0 < slopes[j]) != (0.0 < slopes[j + 1]) {
            let (mut low, mut high) = (at(j), at(j + 1));
            // 2⁻⁵⁰ of an interval is below the rounding of σ.
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if (0.0 < slope(middle)) == (0.0 < slopes[j]) { low = middle } else { high = middle }
            }
            let sigma = 0.5 * (low + high);
            found.push(Extremum { sigma, radius: outline.placed.radius * curve.at(sigma).position.norm(), crest: 0.0 < slopes[j] });
        }
    }
    found
}

/// Without the pairs of neighbours that differ by less than `least`, the least different first: what is left are folds.
fn prominent(mut extrema: Vec<Extremum>, least: f64) -> Vec<Extremum> {
    loop {
        let n = extrema.len();
        if n < 2 {
            return Vec::new();
        }
        let step = |i: usize| (extrema[i].radius - extrema[(i + 1) % n].radius).abs();
        let i = (0..n).min_by(|a, b| step(*a).total_cmp(&step(*b))).expect("two at least");
        if least <= step(i) {
            return extrema;
        }
        let j = (i + 1) % n;
        extrema.remove(i.max(j));
        extrema.remove(i.min(j));
    }
}

/// One fold before its errors are known: quantities that were asked for, by index.
struct Row {
    angle: f64,
    crest: Quantities,
    before: Quantities,
    after: Quantities,
    /// Ends of what overhangs most: angles asked for, their values, and the middle radius.
    overhang: Option<(usize, usize, f64)>,
}

/// Indices of radius, σ and angle of one extremum.
#[derive(Clone, Copy)]
struct Quantities {
    radius: usize,
    sigma: usize,
    angle: usize,
}

/// Quantities of the curve with their gradients by its coefficients.
struct Asked<'a> {
    outline: &'a FreeOutline,
    sensitivities: super::tangent_curve::Sensitivities<'a>,
    values: Vec<f64>,
    by_radius: Vec<f64>,
    by_coefficients: Vec<DVector<f64>>,
}

impl<'a> Asked<'a> {
    fn of(outline: &'a FreeOutline) -> Self {
        Asked { outline, sensitivities: outline.placed.curve.sensitivities(), values: vec![], by_radius: vec![], by_coefficients: vec![] }
    }

    fn ask(&mut self, value: f64, by_radius: f64, gradient: DVector<f64>) -> usize {
        self.values.push(value);
        self.by_radius.push(by_radius);
        self.by_coefficients.push(gradient);
        self.values.len() - 1
    }

    /// The angle of the point at σ, near `near`; `moving` is how σ itself moves with the coefficients, if it does.
    fn angle(&mut self, sigma: f64, near: f64, moving: Option<&DVector<f64>>) -> usize {
        let place = self.outline.placed.curve.at(sigma);
        let w = place.position;
        let square = w.norm_sqr();
        let mut gradient = DVector::zeros(self.sensitivities.count());
        self.sensitivities.at(sigma, |column, moved, _| gradient[column] = (w.re * moved.im - w.im * moved.re) / square);
        if let Some(moving) = moving {
            gradient.axpy((w.re * place.first.im - w.im * place.first.re) / square, moving, 1.0);
        }
        let angle = w.im.atan2(w.re);
        self.ask(angle - TAU * ((angle - near) / TAU).round(), 0.0, gradient)
    }

    fn extremum(&mut self, e: Extremum, near: f64) -> Quantities {
        let place = self.outline.placed.curve.at(e.sigma);
        let (w, t) = (place.position, place.first);
        let dot = |a: C, b: C| a.re * b.re + a.im * b.im;
        let count = self.sensitivities.count();
        let (mut radius, mut sigma) = (DVector::zeros(count), DVector::zeros(count));
        // Stationary: d/dσ (w·t) moves σ by the change of w·t.
        let bend = dot(t, t) + dot(w, place.second);
        let size = w.norm();
        let scale = self.outline.placed.radius;
        self.sensitivities.at(e.sigma, |column, moved, turned| {
            radius[column] = scale * dot(w, moved) / size;
            sigma[column] = -(dot(moved, t) + dot(w, turned)) / bend;
        });
        let angle = self.angle(e.sigma, near, Some(&sigma));
        Quantities { radius: self.ask(e.radius, size, radius), sigma: self.ask(e.sigma, 0.0, sigma), angle }
    }

    fn row(&mut self, before: Extremum, crest: Extremum, after: Extremum) -> Row {
        // The angle is followed along the curve: it may run backwards, and far.
        let steps = (((after.sigma - before.sigma) / TAU * SCAN as f64).ceil() as usize).max(8);
        let curve = &self.outline.placed.curve;
        let at = |i: usize| before.sigma + (after.sigma - before.sigma) * i as f64 / steps as f64;
        let mut angles: Vec<f64> = Vec::with_capacity(steps + 1);
        for i in 0..=steps {
            let w = curve.at(at(i)).position;
            let angle = w.im.atan2(w.re);
            let near = angles.last().copied().unwrap_or(angle);
            angles.push(angle - TAU * ((angle - near) / TAU).round());
        }
        let (mut high, mut back, mut ends) = (0, 0.0_f64, None);
        for i in 0..=steps {
            if angles[high] < angles[i] {
                high = i;
            }
            // Rounding of an angle is no overhang.
            if back.max(1e-9) < angles[high] - angles[i] {
                back = angles[high] - angles[i];
                ends = Some((high, i));
            }
        }
        let middle = ((crest.sigma - before.sigma) / (after.sigma - before.sigma) * steps as f64).round() as usize;
        let near = angles[middle];
        let (first, last) = (angles[0], angles[steps]);
        let ends =
            ends.map(|(i, j)| (turning(curve, at(i), TAU / SCAN as f64), turning(curve, at(j), TAU / SCAN as f64), angles[i], angles[j]));
        let overhang = ends.map(|(a, b, from, to)| {
            let size = |s: f64| self.outline.placed.curve.at(s).position.norm();
            let middle = 0.5 * self.outline.placed.radius * (size(a) + size(b));
            (self.angle(a, from, None), self.angle(b, to, None), middle)
        });
        let crest = self.extremum(crest, near);
        let angle = self.values[crest.angle].rem_euclid(TAU);
        Row { angle, before: self.extremum(before, first), after: self.extremum(after, last), crest, overhang }
    }

    /// One column for each quantity: its gradient through the triangle of the distances' Jacobian, in units of its error.
    fn factor(&self) -> DMatrix<f64> {
        let (count, m) = (self.sensitivities.count(), self.values.len());
        let rows = DMatrix::from_fn(m, count, |i, j| self.by_coefficients[i][j]);
        let free = self.outline.closing.free(&self.outline.placed.curve, rows);
        let mut gradients = DMatrix::zeros(self.outline.jacobian.ncols(), m);
        for i in 0..m {
            gradients[(2, i)] = self.by_radius[i];
            for j in 0..free.ncols() {
                gradients[(3 + j, i)] = free[(i, j)];
            }
        }
        let triangle = self.outline.jacobian.clone().qr().r();
        let solved = triangle.transpose().solve_lower_triangular(&gradients);
        solved.unwrap_or_else(|| DMatrix::from_element(gradients.nrows(), m, f64::NAN)) * self.outline.noise()
    }

    /// Σ weight · quantity, times `scale`.
    fn estimate(&self, factor: &DMatrix<f64>, terms: &[(usize, f64)], scale: f64) -> Estimate {
        let value = scale * terms.iter().map(|(i, weight)| weight * self.values[*i]).sum::<f64>();
        let mut moved = DVector::zeros(factor.nrows());
        for (i, weight) in terms {
            moved.axpy(*weight, &factor.column(*i), 1.0);
        }
        let error = scale * moved.norm();
        Estimate { value, standard_error: (error.is_finite() && 0.0 < error).then_some(error) }
    }
}

impl Row {
    fn fold(&self, asked: &Asked, factor: &DMatrix<f64>, first: Quantities) -> Fold {
        let of = |terms: &[(usize, f64)], scale: f64| asked.estimate(factor, terms, scale);
        let (c, a, b) = (self.crest, self.before, self.after);
        let wrapped = |e: Estimate, turn: f64| {
            let value = e.value.rem_euclid(turn);
            Estimate { value: if turn - value < 1e-12 { 0.0 } else { value }, ..e }
        };
        let none = Estimate { value: 0.0, standard_error: None };
        Fold {
            angle: wrapped(of(&[(c.angle, 1.0)], 1.0), TAU),
            place: if c.sigma == first.sigma { none } else { wrapped(of(&[(c.sigma, 1.0), (first.sigma, -1.0)], 1.0 / TAU), 1.0) },
            radius: of(&[(c.radius, 1.0)], 1.0),
            depth: of(&[(c.radius, 1.0), (a.radius, -0.5), (b.radius, -0.5)], 1.0),
            width: of(&[(b.sigma, 1.0), (a.sigma, -1.0)], 1.0 / TAU),
            width_angle: of(&[(b.angle, 1.0), (a.angle, -1.0)], 1.0),
            overhang_angle: self.overhang.map_or(none, |(from, to, _)| of(&[(from, 1.0), (to, -1.0)], 1.0)),
            overhang: self.overhang.map_or(none, |(from, to, middle)| of(&[(from, 1.0), (to, -1.0)], middle)),
        }
    }
}

/// Where, within `reach` of σ, the angle about the centroid turns round: `w × w' = 0`; σ itself if it does not.
fn turning(curve: &super::tangent_curve::TangentCurve, sigma: f64, reach: f64) -> f64 {
    let slope = |s: f64| {
        let place = curve.at(s);
        place.position.re * place.first.im - place.position.im * place.first.re
    };
    let (mut low, mut high) = (sigma - reach, sigma + reach);
    let sign = 0.0 < slope(low);
    if sign == (0.0 < slope(high)) {
        return sigma;
    }
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if sign == (0.0 < slope(middle)) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Degrees in a radian, for whoever prints angles.
pub const DEGREES: f64 = 180.0 / PI;
