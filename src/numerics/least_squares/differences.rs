//! Derivatives of a residual function by differences: rough ones on the way, accurate ones at the end.
//!
//! On the way plain central differences do. Where the iteration has come to rest they are replaced by Richardson extrapolation with the step
//! chosen column by column from its own error estimate (Ridders, Advances in Engineering Software 4 (1982) 75–76), which leaves 10 to 13 digits.

use nalgebra::DMatrix;

use super::limits::Limit;

/// First step of the extrapolation, relative to the parameter; halved until the error estimate no longer falls. Wide, because rounding
/// counts by its inverse.
const WIDEST: f64 = 1.0 / 4.0;
/// Rows of the extrapolation: the smallest step is 2⁻¹³ of the widest.
const ROWS: usize = 14;
/// The next extrapolation of the same column begins so much wider than the best step was.
const WIDER: f64 = 8.0;
/// An extrapolation that differs from the plain quotient by more than this share has stepped over what it should see (a narrow peak).
const ASTRAY: f64 = 1e-3;
/// Relative step of plain central differences: ∛ε balances truncation and rounding.
const PLAIN: f64 = 6e-6;

/// Numeric derivatives of one residual function.
pub(super) struct Differences {
    accurate: bool,
    /// Residual vectors evaluated.
    pub evaluations: usize,
    /// Size of each parameter where it is zero itself: its start, or 1.
    typical: Vec<f64>,
    limits: Vec<Limit>,
    /// Relative step at which each column's next extrapolation begins.
    widest: Vec<f64>,
    ahead: Vec<f64>,
    behind: Vec<f64>,
    moved: Vec<f64>,
}

impl Differences {
    pub(super) fn new(rows: usize, start: &[f64], limits: &[Limit]) -> Differences {
        Differences {
            accurate: false,
            evaluations: 0,
            typical: start.iter().map(|s| if *s == 0.0 { 1.0 } else { s.abs() }).collect(),
            limits: if limits.is_empty() { vec![Limit::Free; start.len()] } else { limits.to_vec() },
            widest: vec![WIDEST; start.len()],
            ahead: vec![0.0; rows],
            behind: vec![0.0; rows],
            moved: vec![0.0; start.len()],
        }
    }

    /// Asks for accurate derivatives from now on; `false` if they are already.
    pub(super) fn refine(&mut self) -> bool {
        !std::mem::replace(&mut self.accurate, true)
    }

    /// Fills the Jacobian at `x`; `false` where a derivative cannot be had. A column of a fixed parameter is zero: nobody asks for it.
    pub(super) fn fill(&mut self, residuals: &mut impl FnMut(&[f64], &mut [f64]), x: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
        (0..x.len()).all(|j| {
            if matches!(self.limits[j], Limit::At(_)) {
                jacobian.column_mut(j).fill(0.0);
                return true;
            }
            let column = if self.accurate { self.extrapolated(residuals, x, j) } else { self.plain(residuals, x, j) };
            let Some(column) = column else { return false };
            jacobian.column_mut(j).copy_from_slice(&column);
            true
        })
    }

    /// Size by which steps of parameter `j` are measured.
    fn size(&self, x: &[f64], j: usize) -> f64 {
        // A parameter that has become small against its start is still known no better than the residuals show.
        x[j].abs().max(1e-3 * self.typical[j])
    }

    fn plain(&mut self, residuals: &mut impl FnMut(&[f64], &mut [f64]), x: &[f64], j: usize) -> Option<Vec<f64>> {
        let mut step = PLAIN * self.size(x, j);
        // Where the function is not defined on both sides a smaller step may be.
        for _ in 0..4 {
            if let Some(column) = self.quotient(residuals, x, j, step) {
                return Some(column);
            }
            step *= 1.0 / 16.0;
        }
        None
    }

    fn extrapolated(&mut self, residuals: &mut impl FnMut(&[f64], &mut [f64]), x: &[f64], j: usize) -> Option<Vec<f64>> {
        let anchor = self.plain(residuals, x, j)?;
        let near = ASTRAY * anchor.iter().map(|a| a * a).sum::<f64>().sqrt();
        let size = self.size(x, j);
        let mut step = self.widest[j] * size;
        let mut last: Vec<Vec<f64>> = Vec::new();
        let mut best: Option<(f64, Vec<f64>)> = None;
        let mut worse = 0;
        for _ in 0..ROWS {
            let Some(first) = self.quotient(residuals, x, j, step) else {
                step *= 0.5;
                last.clear();
                continue;
            };
            let mut row = vec![first];
            // Central quotients err by even powers of the step, one-sided ones of order four by all from the fourth on; extrapolating the
            // latter as if they were even still gains what the first column gains, and the error estimate sees what it does not.
            let mut factor = 1.0;
            for before in &last {
                factor *= 4.0;
                let newest: &Vec<f64> = row.last().expect("never empty");
                let next: Vec<f64> = newest.iter().zip(before).map(|(new, old)| new + (new - old) / (factor - 1.0)).collect();
                let error = distance(&next, newest).max(distance(&next, before));
                if best.as_ref().is_none_or(|(least, _)| error < *least) && distance(&next, &anchor) <= near {
                    best = Some((error, next.clone()));
                    self.widest[j] = (WIDER * step / size).min(WIDEST);
                    worse = 0;
                }
                row.push(next);
            }
            worse += 1;
            // Two rows without gain: rounding has taken over.
            if 2 < worse && best.is_some() {
                break;
            }
            last = row;
            step *= 0.5;
        }
        Some(best.map_or(anchor, |(_, column)| column))
    }

    /// The central difference quotient; one-sided, of order four, where a bound is in the way.
    fn quotient(&mut self, residuals: &mut impl FnMut(&[f64], &mut [f64]), x: &[f64], j: usize, step: f64) -> Option<Vec<f64>> {
        let (low, high) = self.limits[j].range();
        // A step that is exact in floating point.
        let (up, down) = (x[j] + step, x[j] - step);
        if up <= high && low <= down {
            return self.central(residuals, x, j, up, down);
        }
        let sign = if x[j] + 4.0 * step <= high { 1.0 } else { -1.0 };
        if sign < 0.0 && x[j] - 4.0 * step < low {
            return None;
        }
        // Five points: −25, 48, −36, 16, −3 over 12 h.
        let step = sign * step;
        let mut sum = vec![0.0; self.ahead.len()];
        for (k, weight) in [-25.0, 48.0, -36.0, 16.0, -3.0].into_iter().enumerate() {
            self.moved.copy_from_slice(x);
            self.moved[j] += k as f64 * step;
            residuals(&self.moved, &mut self.ahead);
            self.evaluations += 1;
            sum.iter_mut().zip(&self.ahead).for_each(|(sum, value)| *sum += weight * value);
        }
        sum.iter_mut().for_each(|sum| *sum /= 12.0 * step);
        sum.iter().all(|value| value.is_finite()).then_some(sum)
    }

    fn central(&mut self, residuals: &mut impl FnMut(&[f64], &mut [f64]), x: &[f64], j: usize, up: f64, down: f64) -> Option<Vec<f64>> {
        self.moved.copy_from_slice(x);
        self.moved[j] = up;
        residuals(&self.moved, &mut self.ahead);
        self.moved[j] = down;
        residuals(&self.moved, &mut self.behind);
        self.evaluations += 2;
        let column: Vec<f64> = self.ahead.iter().zip(&self.behind).map(|(a, b)| (a - b) / (up - down)).collect();
        column.iter().all(|value| value.is_finite()).then_some(column)
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
