//! Even folds: how well an outline of m equal folds describes the points in their order, for every m.
//!
//! A closed curve of m equal folds, run through in any way that is the same on every fold, has the spectral lines `1 + jm` and no others
//! (`z(u) = Σ_j c_j e^{2πi(1+jm)u}`). That is linear in the c_j, needs no foot points, and uses what a distance from the curve does not see:
//! that the points come in order. Where noise is as wide as a fold, nothing else tells the folds.

use std::f64::consts::TAU;

use nalgebra::{Complex, SMatrix, SVector};

use super::akaike;
use super::circle;
use super::outline::fractions;
use crate::experiment::Point;

/// Lines on either side of the first: those that the paper's curve has.
const REACH: usize = 2;
const LINES: usize = 2 * REACH + 1;
/// The lines and the centre.
const UNKNOWNS: usize = LINES + 1;
/// Real parameters of a circle at given places, and the variance.
const CIRCLE_PARAMETERS: f64 = 5.0;
/// Akaike's criterion by which folds have to be better than none, beside the advantage of having been searched for: a weight of twenty to one.
const FOLDED: f64 = 6.0;
/// Most folds looked for.
pub const MOST_FOLDS: u32 = 60;
/// More points than this tell nothing new about the fold count.
const ENOUGH: usize = 2048;

/// The lines of m even folds, fitted to points in order.
#[derive(Debug, Clone)]
pub struct Even {
    /// 0: a circle.
    pub folds: u32,
    /// c_j for j = −2 … 2, and the centre, m.
    pub lines: [Complex<f64>; UNKNOWNS],
    /// The parameter u of each point, ascending, 0 … 1.
    pub parameter: Vec<f64>,
    /// Standard deviation of the points about the curve at their own parameter, each coordinate, m.
    pub noise: f64,
    /// Akaike's criterion over both coordinates of all points.
    pub criterion: f64,
}

impl Even {
    /// The point at parameter `u`, m.
    pub fn point(&self, u: f64) -> Point {
        let (sin, cos) = (TAU * u).sin_cos();
        let (sin_fold, cos_fold) = (TAU * f64::from(self.folds) * u).sin_cos();
        let fold = Complex::new(cos_fold, sin_fold);
        // Horner, from the highest line down; then the turn of the lowest.
        let sum = self.lines[..LINES].iter().rev().fold(Complex::new(0.0, 0.0), |sum, c| sum * fold + c);
        let z = self.lines[LINES] + Complex::new(cos, sin) * sum / fold.powu(REACH as u32);
        Point::new(z.re, z.im)
    }
}

/// What is known of one fold count without a fit.
#[derive(Debug, Clone, Copy)]
pub struct Evidence {
    pub folds: u32,
    /// Akaike's criterion, the least over the ways to run through the points.
    pub criterion: f64,
    /// Root mean square distance of the points from the curve at their own parameter, m.
    pub rms: f64,
}

/// The most credible even outline of 2 … [`MOST_FOLDS`] folds, and the evidence for each of them; `None` where there are too few points.
///
/// The curve may be run through by count, by length of the polygon, by direction from the centre, or by the direction of a point's
/// neighbourhood: points at equal steps are even by the first or second, whichever step that is; noise leaves the third alone where folds
/// are shallow, and the fourth where points are dense here and sparse there.
pub fn even_folds(points: &[Point]) -> Option<(Even, Vec<Evidence>)> {
    let stride = points.len().div_ceil(ENOUGH).max(1);
    let some: Vec<usize> = (0..points.len()).step_by(stride).collect();
    // Five lines must be distinct at the points, and leave something.
    let most = MOST_FOLDS.min(((some.len() - 1) / (2 * REACH)) as u32);
    if most < 2 {
        return None;
    }
    let mut least = vec![(f64::INFINITY, f64::INFINITY); most as usize + 1];
    let mut best: Option<Even> = None;
    let mut round: Option<Even> = None;
    for parameter in parametrizations(points) {
        let places: Vec<(Point, f64)> = some.iter().map(|&i| (points[i], parameter[i])).collect();
        let sums = Sums::of(&places, most);
        let mut nearest: Option<Even> = None;
        for folds in 2..=most {
            let Some((lines, square)) = sums.solve(folds) else { continue };
            let values = 2.0 * places.len() as f64;
            let parameters = 2.0 * UNKNOWNS as f64 + 1.0;
            let criterion = akaike(square / values, values, parameters);
            if criterion < least[folds as usize].0 {
                least[folds as usize] = (criterion, (square / places.len() as f64).sqrt());
            }
            if nearest.as_ref().is_none_or(|n| criterion < n.criterion) {
                let noise = (square / (values - parameters).max(1.0)).sqrt();
                nearest = Some(Even { folds, lines, parameter: Vec::new(), noise, criterion });
            }
        }
        let (lines, square) = sums.circle();
        let values = 2.0 * places.len() as f64;
        let criterion = akaike(square / values, values, CIRCLE_PARAMETERS);
        if round.as_ref().is_none_or(|r| criterion < r.criterion) {
            let noise = (square / (values - CIRCLE_PARAMETERS).max(1.0)).sqrt();
            round = Some(Even { folds: 0, lines, parameter: parameter.clone(), noise, criterion });
        }
        if let Some(nearest) = nearest.filter(|n| best.as_ref().is_none_or(|b| n.criterion < b.criterion)) {
            best = Some(Even { parameter, ..nearest });
        }
    }
    // As if all points had been used: the criterion grows with their number.
    let share = points.len() as f64 / some.len() as f64;
    let best = best?;
    // The best of so many counts fits chance better than one alone: without clear evidence of folds the outline is round.
    let searched = 2.0 * f64::from(most).ln() + FOLDED;
    let best = round.filter(|round| round.criterion <= best.criterion + searched).unwrap_or(best);
    let evidence = (2..=most)
        .map(|folds| (folds, least[folds as usize]))
        .map(|(folds, (criterion, rms))| Evidence { folds, criterion: share * criterion, rms })
        .collect();
    Some((Even { criterion: share * best.criterion, ..best }, evidence))
}

/// Ways to run once through the points, each 0 … 1.
fn parametrizations(points: &[Point]) -> [Vec<f64>; 4] {
    let n = points.len();
    let by_count = (0..n).map(|i| i as f64 / n as f64).collect();
    let (by_length, _) = fractions(points);
    // Of the circle through them: neither density nor zigzag nor a missing piece moves it.
    let round = circle::fit(points);
    let centre = Point::new(round.x0, round.y0);
    let direction = |p: Point| ((p.y - centre.y).atan2(p.x - centre.x) / TAU).rem_euclid(1.0);
    let by_direction = points.iter().map(|p| direction(*p)).collect();
    let by_neighbourhood = neighbourhoods(points).into_iter().map(direction).collect();
    [by_count, by_length, by_direction, by_neighbourhood]
}

/// The mean of a twelfth of all points, about each of them: noise and the folds themselves are gone, uneven density is still there.
fn neighbourhoods(points: &[Point]) -> Vec<Point> {
    let n = points.len();
    let half = n / 24;
    let count = (2 * half + 1) as f64;
    let mut sum = (0..2 * half + 1).map(|i| points[(i + n - half) % n]).fold((0.0, 0.0), |s, p| (s.0 + p.x, s.1 + p.y));
    (0..n)
        .map(|i| {
            let mean = Point::new(sum.0 / count, sum.1 / count);
            let (leaves, enters) = (points[(i + n - half) % n], points[(i + half + 1) % n]);
            sum = (sum.0 + enters.x - leaves.x, sum.1 + enters.y - leaves.y);
            mean
        })
        .collect()
}

/// Sums over the points that all fold counts share.
struct Sums {
    /// Σ e^{2πiku}, k = 0 … 4·most.
    turns: Vec<Complex<f64>>,
    /// Σ z e^{−2πiku}, k = −(2·most − 1) … 2·most + 1.
    products: Vec<Complex<f64>>,
    lowest: i64,
    /// Σ |z|².
    square: f64,
    /// What the points are centred by.
    mean: Complex<f64>,
}

impl Sums {
    fn of(places: &[(Point, f64)], most: u32) -> Sums {
        let highest = 2 * REACH * most as usize;
        let lowest = 1 - (REACH * most as usize) as i64;
        let wide = REACH * most as usize + 2;
        let mut turns = vec![Complex::new(0.0, 0.0); highest + 1];
        let mut products = vec![Complex::new(0.0, 0.0); 2 * REACH * most as usize + 1];
        let mut square = 0.0;
        let n = places.len() as f64;
        let (cx, cy) = (places.iter().map(|p| p.0.x).sum::<f64>() / n, places.iter().map(|p| p.0.y).sum::<f64>() / n);
        let centred: Vec<Complex<f64>> = places.iter().map(|(p, _)| Complex::new(p.x - cx, p.y - cy)).collect();
        let unit: Vec<Complex<f64>> = places.iter().map(|(_, u)| Complex::from_polar(1.0, TAU * u)).collect();
        let mut turned = vec![Complex::new(1.0, 0.0); places.len()];
        square += centred.iter().map(|z| z.norm_sqr()).sum::<f64>();
        for (k, sum) in turns.iter_mut().enumerate() {
            let (mut turn, mut ahead, mut back) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
            for ((t, u), z) in turned.iter_mut().zip(&unit).zip(&centred) {
                turn += *t;
                if k < wide {
                    ahead += z * t.conj();
                    back += z * *t;
                }
                *t *= u;
            }
            *sum = turn;
            for (at, value) in [(k as i64, ahead), (-(k as i64), back)] {
                if let Some(place) = usize::try_from(at - lowest).ok().and_then(|i| products.get_mut(i)) {
                    *place = value;
                }
            }
        }
        Sums { turns, products, lowest, square, mean: Complex::new(cx, cy) }
    }

    /// The circle of least squares about a free centre, and the sum of squares that it leaves, m².
    fn circle(&self) -> ([Complex<f64>; UNKNOWNS], f64) {
        let n = self.turns[0].re;
        let turn = self.turns[1];
        let product = |k: i64| self.products[(k - self.lowest) as usize];
        let (along, across) = (product(1), product(0));
        // [n, conj(turn); turn, n] · [circle; centre] = [along; across], by Cramer's rule.
        let determinant = n * n - turn.norm_sqr();
        let circle = (along * n - turn.conj() * across) / determinant;
        let centre = (across * n - turn * along) / determinant;
        let explained = (circle.conj() * along).re + (centre.conj() * across).re;
        let mut lines = [Complex::new(0.0, 0.0); UNKNOWNS];
        lines[REACH] = circle;
        lines[LINES] = centre + self.mean;
        (lines, (self.square - explained).max(1e-15 * self.square))
    }

    /// Lines of least squares for `folds` folds about a free centre, and the sum of squares that they leave, m²; `None` if the points do
    /// not tell them apart.
    fn solve(&self, folds: u32) -> Option<([Complex<f64>; UNKNOWNS], f64)> {
        let m = i64::from(folds);
        let wave: [i64; UNKNOWNS] = std::array::from_fn(|a| if a < LINES { 1 + (a as i64 - REACH as i64) * m } else { 0 });
        let normal = SMatrix::<Complex<f64>, UNKNOWNS, UNKNOWNS>::from_fn(|a, b| {
            // ⟨e_a, e_b⟩ = Σ e^{2πi(k_b − k_a)u}.
            let turn = self.turns[(wave[b] - wave[a]).unsigned_abs() as usize];
            if wave[a] <= wave[b] { turn } else { turn.conj() }
        });
        let right = SVector::<Complex<f64>, UNKNOWNS>::from_fn(|a, _| self.products[(wave[a] - self.lowest) as usize]);
        let factor = normal.cholesky()?;
        let diagonal = factor.l_dirty().diagonal().map(|d| d.re);
        if diagonal.min() < 1e-3 * diagonal.max() {
            return None;
        }
        let lines = factor.solve(&right);
        let explained: f64 = lines.iter().zip(right.iter()).map(|(c, r)| (c.conj() * r).re).sum();
        // Rounding of sums of this size.
        let square = (self.square - explained).max(1e-15 * self.square);
        let mut lines: [Complex<f64>; UNKNOWNS] = std::array::from_fn(|a| lines[a]);
        lines[LINES] += self.mean;
        Some((lines, square))
    }
}
