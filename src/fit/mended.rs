//! An outline whose gross errors are found by its even folds in the order of its points, and put where those say.
//!
//! A closed curve of m equal folds has the spectral lines 1 + jm and no others, whichever way it is run through, if it is the same on every
//! fold. Run through by count a point's parameter does not depend on where the point lies, so a gross error is one of the
//! response and never one of the design: the lines of least absolute distance, a convex problem, are hardly moved by a fifth of them.

use nalgebra::{Complex, DMatrix, DVector};

use super::median;
use crate::experiment::Point;

/// Lines on either side of the first at most: two are those of the paper's curve run through at an even parameter, more allow for other ways.
const MOST_REACH: usize = 4;
/// … and at least.
const LEAST_REACH: usize = 2;
/// The lines must be distinct at the points with a margin, some of which are gross errors.
const MARGIN: f64 = 0.7;
/// Rounds of reweighting that tell the fold counts apart …
const SCREENING: usize = 5;
/// … on about this many points, and the rounds after which the lines move no more.
const SCREENING_POINTS: usize = 160;
const SETTLING: usize = 20;
/// Fold counts that are settled: the count, its half and its double can be near to each other.
const SETTLED: usize = 3;
/// Rounds of the bounded loss after that.
const BOUNDED: usize = 8;
/// Its tuning constant in scales of one coordinate: 95 % efficiency, as in one dimension.
const TUNING: f64 = 4.685;
/// Points within so many scales of their own place are sound; a normal error of two coordinates is beyond once in three thousand.
const PLACED: f64 = 4.0;
/// Lines that leave more than this share of the folds' own depth do not describe them.
const POOR: f64 = 0.25;
/// With less than this no other way through the points is tried.
const GOOD: f64 = 0.08;
/// Median of Rayleigh's distribution, √(2 ln 2).
const RAYLEIGH: f64 = 1.177_410_022_515_474_7;

type Complexes = Vec<Complex<f64>>;

/// An outline in order, with what its even folds say of every point.
pub(super) struct Mended {
    z: Complexes,
    turn: Complexes,
    lines: Lines,
    /// Which points lie where their folds say.
    pub placed: Vec<bool>,
}

impl Mended {
    /// Finds the even folds among `from..=to` that most points agree with; points in order, counterclockwise. `None` where none describes them.
    pub(super) fn of(points: &[Point], from: u32, to: u32) -> Option<Mended> {
        let z: Complexes = points.iter().map(|p| Complex::new(p.x, p.y)).collect();
        let n = z.len() as f64;
        let by_count: Complexes = (0..z.len()).map(|k| Complex::from_polar(1.0, std::f64::consts::TAU * k as f64 / n)).collect();
        let mut best = settled(&z, &by_count, from, to).map(|found| (found, by_count));
        if best.as_ref().is_none_or(|(found, _)| GOOD * found.lines.depth() < found.scale) {
            let centre = middle(&z);
            let by_direction: Complexes = z.iter().map(|z| (z - centre) / (z - centre).norm().max(f64::MIN_POSITIVE)).collect();
            let other = settled(&z, &by_direction, from, to).map(|found| (found, by_direction));
            best = [best, other].into_iter().flatten().min_by(|a, b| a.0.scale.total_cmp(&b.0.scale));
        }
        let (found, turn) = best?;
        if POOR * found.lines.depth() < found.scale {
            return None;
        }
        // Where points lie on the lines exactly, rounding is no error.
        let near = (PLACED * found.scale).max(1e-9 * found.lines.radius());
        Some(Mended { placed: found.sizes.iter().map(|size| *size <= near).collect(), z, turn, lines: found.lines })
    }

    /// The points, those that are not `sound` put where the folds of the sound ones say.
    pub(super) fn points(&self, sound: &[bool]) -> Vec<Point> {
        let fold = folded(&self.turn, self.lines.folds);
        let weights: Vec<f64> = sound.iter().map(|&s| f64::from(u8::from(s))).collect();
        let lines = Lines::fit(&self.z, &self.turn, &fold, &weights, self.lines.folds, self.lines.reach);
        let lines = lines.as_ref().unwrap_or(&self.lines);
        let place = |k: usize| if sound[k] { self.z[k] } else { lines.at(self.turn[k], fold[k]) };
        (0..self.z.len()).map(place).map(|z| Point::new(z.re, z.im)).collect()
    }
}

/// Whether points in order run round their middle clockwise, most of them.
pub(super) fn clockwise(points: &[Point]) -> bool {
    let z: Complexes = points.iter().map(|p| Complex::new(p.x, p.y)).collect();
    let centre = middle(&z);
    let n = z.len();
    let ahead = (n / 16).max(1);
    let back = (0..n).filter(|&k| ((z[(k + ahead) % n] - centre) * (z[k] - centre).conj()).im < 0.0).count();
    n < 2 * back
}

/// e^{2πi(1+jm)u} for j = −reach … reach, and the centre, weighed.
struct Lines {
    folds: u32,
    reach: usize,
    /// From the lowest line to the highest, then the centre, m.
    values: Complexes,
}

impl Lines {
    /// Weighted least squares; `None` if the points do not tell the lines apart.
    fn fit(z: &[Complex<f64>], turn: &[Complex<f64>], fold: &[Complex<f64>], weights: &[f64], folds: u32, reach: usize) -> Option<Lines> {
        let count = 2 * reach + 1;
        let zero = Complex::new(0.0, 0.0);
        let mut powers = [zero; 2 * MOST_REACH + 1];
        let mut lines = [zero; 2 * MOST_REACH + 1];
        let mut right = [zero; 2 * MOST_REACH + 2];
        for k in 0..z.len() {
            let w = weights[k];
            if w == 0.0 {
                continue;
            }
            // f^d e^{2πi·lowest·u}, d = 0 … 2 reach; the sums of f^d alone make the matrix, which is Toeplitz.
            let (mut power, mut line) = (Complex::new(w, 0.0), turn[k] * w);
            let back = fold[k].conj();
            for _ in 0..reach {
                line *= back;
            }
            for d in 0..count {
                powers[d] += power;
                lines[d] += line;
                right[d] += line.conj() * z[k];
                power *= fold[k];
                line *= fold[k];
            }
            right[count] += z[k] * w;
        }
        let matrix = DMatrix::<Complex<f64>>::from_fn(count + 1, count + 1, |a, b| match (a == count, b == count) {
            (true, true) => powers[0],
            (true, false) => lines[b],
            (false, true) => lines[a].conj(),
            (false, false) if a <= b => powers[b - a],
            (false, false) => powers[a - b].conj(),
        });
        let factor = matrix.cholesky()?;
        let diagonal = factor.l_dirty().diagonal().map(|d| d.re);
        if diagonal.min() < 1e-2 * diagonal.max() {
            return None;
        }
        let values = factor.solve(&DVector::from_iterator(count + 1, right[..=count].iter().copied()));
        Some(Lines { folds, reach, values: values.iter().copied().collect() })
    }

    /// The point at parameter u, from e^{2πiu} and e^{2πimu}.
    fn at(&self, turn: Complex<f64>, fold: Complex<f64>) -> Complex<f64> {
        let (centre, lines) = self.values.split_last().expect("a centre");
        let sum = lines.iter().rev().fold(Complex::new(0.0, 0.0), |sum, c| sum * fold + c);
        let back = fold.conj();
        centre + (0..self.reach).fold(turn * sum, |z, _| z * back)
    }

    fn sizes(&self, z: &[Complex<f64>], turn: &[Complex<f64>], fold: &[Complex<f64>]) -> Vec<f64> {
        (0..z.len()).map(|k| (z[k] - self.at(turn[k], fold[k])).norm()).collect()
    }

    fn radius(&self) -> f64 {
        self.values[self.reach].norm()
    }

    /// Root mean square departure from the circle, m.
    fn depth(&self) -> f64 {
        let all: f64 = self.values[..=2 * self.reach].iter().map(|c| c.norm_sqr()).sum();
        (all - self.radius().powi(2)).max(0.0).sqrt()
    }
}

/// Lines that most points agree with.
struct Found {
    lines: Lines,
    /// Distance of each point from its own place, m.
    sizes: Vec<f64>,
    /// Standard deviation of one coordinate by the median over all points, m: a fifth too wide with a fifth of gross errors.
    scale: f64,
}

/// The fold count whose lines leave the least scale.
fn settled(z: &[Complex<f64>], turn: &[Complex<f64>], from: u32, to: u32) -> Option<Found> {
    let stride = (z.len() / SCREENING_POINTS.max(6 * to as usize)).max(1);
    let some = |all: &[Complex<f64>]| -> Complexes { all.iter().copied().step_by(stride).collect() };
    let (few, few_turns) = (some(z), some(turn));
    let mut order: Vec<(f64, u32)> = (from..=to)
        .filter_map(|m| (from == to).then_some((0.0, m)).or_else(|| Some((nearest(&few, &few_turns, m, SCREENING, 0)?.scale, m))))
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let found = order.into_iter().take(SETTLED).filter_map(|(_, m)| nearest(z, turn, m, SETTLING, BOUNDED));
    found.min_by(|a, b| a.scale.total_cmp(&b.scale))
}

/// The lines of `folds` folds after so many rounds of absolute distances, and so many of a bounded loss.
fn nearest(z: &[Complex<f64>], turn: &[Complex<f64>], folds: u32, absolute: usize, bounded: usize) -> Option<Found> {
    let n = z.len();
    let reach = ((MARGIN * n as f64 / (2.0 * f64::from(folds))) as usize).min(MOST_REACH);
    if reach < LEAST_REACH {
        return None;
    }
    let fold = folded(turn, folds);
    let centre = middle(z);
    let radii: Vec<f64> = z.iter().map(|z| (z - centre).norm()).collect();
    let usual = median(radii.clone());
    let mut sizes: Vec<f64> = radii.iter().map(|r| (r - usual).abs()).collect();
    let mut lines = None;
    for _ in 0..absolute {
        // Beside the point itself the weight stays finite.
        let floor = (0.3 * median(sizes.clone())).max(1e-12 * usual);
        let weights: Vec<f64> = sizes.iter().map(|size| floor / size.max(floor)).collect();
        let next = Lines::fit(z, turn, &fold, &weights, folds, reach)?;
        sizes = next.sizes(z, turn, &fold);
        lines = Some(next);
    }
    let mut scale = median(sizes.clone()) / RAYLEIGH;
    for _ in 0..bounded {
        let wide = (TUNING * scale).max(1e-9 * usual);
        let weights: Vec<f64> = sizes.iter().map(|size| (1.0 - (size / wide).powi(2)).max(0.0).powi(2)).collect();
        let next = Lines::fit(z, turn, &fold, &weights, folds, reach)?;
        sizes = next.sizes(z, turn, &fold);
        lines = Some(next);
        // Over all points: over those within reach only, lines that a third of the points agree with would look the best.
        scale = median(sizes.clone()) / RAYLEIGH;
    }
    Some(Found { lines: lines?, sizes, scale })
}

fn folded(turn: &[Complex<f64>], folds: u32) -> Complexes {
    turn.iter().map(|t| t.powu(folds)).collect()
}

/// The median of each coordinate.
fn middle(z: &[Complex<f64>]) -> Complex<f64> {
    Complex::new(median(z.iter().map(|z| z.re).collect()), median(z.iter().map(|z| z.im).collect()))
}
