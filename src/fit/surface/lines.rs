//! Straight lines over height, one for each unknown of the hem curve.

use nalgebra::DMatrix;

use super::super::outcome::{Estimate, HemFit};
use super::FEWEST_SECTIONS;
use crate::experiment::surface::Section;
use crate::model::hem::{Hem, Placement};

/// The lines of all unknowns of one surface: value at the mean height and slope, phase without slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lines {
    pub folds: u32,
    /// Mean height, m.
    pub middle: f64,
    pub values: [f64; 11],
}

impl Lines {
    pub fn curve(&self, z: f64) -> (Hem, Placement) {
        curve(&self.values, self.folds, z - self.middle)
    }
}

pub(super) fn curve(v: &[f64], folds: u32, dz: f64) -> (Hem, Placement) {
    let at = |value: usize, slope: usize| v[value] + dz * v[slope];
    (Hem { p: at(3, 8), q: at(4, 9), s: at(5, 10), folds }, Placement { x0: at(0, 6), y0: at(1, 7), phase: v[2] })
}

/// Straight lines through the estimates of the sections, weighted by their standard errors, and their covariance raised to the lines' own misfit.
pub(super) fn through_sections(m: u32, sections: &[Section], alone: &[Result<HemFit, String>]) -> Option<(Lines, DMatrix<f64>)> {
    let fitted: Vec<(f64, &HemFit)> = sections
        .iter()
        .zip(alone)
        .filter_map(|(section, fit)| fit.as_ref().ok().map(|fit| (section.height, fit)))
        .filter(|(_, fit)| fit.folds == Some(m))
        .collect();
    if fitted.len() < FEWEST_SECTIONS {
        return None;
    }
    let middle = fitted.iter().map(|(z, _)| z).sum::<f64>() / fitted.len() as f64;
    // The deepest folds know the phase best; the others are taken as turned by whole folds at most.
    let period = std::f64::consts::TAU / f64::from(m);
    let (weight, mut sine, mut cosine) = (|fit: &HemFit| (fit.hem.q / fit.hem.p).powi(2), 0.0, 0.0);
    for (_, fit) in &fitted {
        let (sin, cos) = (f64::from(m) * fit.placement.phase).sin_cos();
        sine += weight(fit) * sin;
        cosine += weight(fit) * cos;
    }
    let phase = (sine.atan2(cosine) / f64::from(m)).rem_euclid(period);
    let mut values = [0.0; 11];
    values[2] = phase;
    let mut matrix = DMatrix::zeros(11, 11);
    type Pick<'a> = &'a dyn Fn(&HemFit) -> (f64, Option<f64>);
    let estimate = |e: Option<Estimate>| e.map_or((0.0, None), |e| (e.value, e.standard_error));
    let turned = |fit: &HemFit| if (f64::from(m) * (fit.placement.phase - phase)).cos() < 0.0 { -1.0 } else { 1.0 };
    let picks: [(usize, usize, Pick); 5] = [
        (0, 6, &|f| (f.placement.x0, f.p.standard_error)),
        (1, 7, &|f| (f.placement.y0, f.p.standard_error)),
        (3, 8, &|f| (f.p.value, f.p.standard_error)),
        // A fold turned by half of one is a negative fold.
        (4, 9, &|f| (turned(f) * f.hem.q, estimate(f.q).1)),
        (5, 10, &|f| estimate(f.s)),
    ];
    for (value, slope, pick) in picks {
        let rows: Vec<(f64, f64, f64)> = fitted
            .iter()
            .map(|(z, fit)| {
                let (y, error) = pick(fit);
                // Without an error of its own a section counts as one of a millimetre: it is a match in order.
                (z - middle, y, error.filter(|e| 0.0 < *e).map_or(1e6, |e| 1.0 / (e * e)))
            })
            .collect();
        let sum = |f: &dyn Fn(&(f64, f64, f64)) -> f64| rows.iter().map(f).sum::<f64>();
        let (w, wz, wzz) = (sum(&|r| r.2), sum(&|r| r.2 * r.0), sum(&|r| r.2 * r.0 * r.0));
        let (wy, wzy) = (sum(&|r| r.2 * r.1), sum(&|r| r.2 * r.0 * r.1));
        let determinant = w * wzz - wz * wz;
        // All at one height, or not finite.
        if determinant.partial_cmp(&(1e-12 * w * wzz)).is_none_or(std::cmp::Ordering::is_le) {
            return None;
        }
        values[value] = (wzz * wy - wz * wzy) / determinant;
        values[slope] = (w * wzy - wz * wy) / determinant;
        let misfit = sum(&|r| r.2 * (r.1 - values[value] - r.0 * values[slope]).powi(2)) / (rows.len() as f64 - 2.0);
        let scale = misfit.max(1.0) / determinant;
        matrix[(value, value)] = wzz * scale;
        matrix[(slope, slope)] = w * scale;
        (matrix[(value, slope)], matrix[(slope, value)]) = (-wz * scale, -wz * scale);
    }
    // Of the weighted mean of the phases, from their scatter.
    let total: f64 = fitted.iter().map(|(_, fit)| weight(fit)).sum();
    let apart = |fit: &HemFit| ((f64::from(m) * (fit.placement.phase - phase)).sin() / f64::from(m)).powi(2);
    matrix[(2, 2)] = fitted.iter().map(|(_, fit)| weight(fit) * apart(fit)).sum::<f64>() / total / (fitted.len() as f64 - 1.0);
    Some((Lines { folds: m, middle, values }, matrix))
}

/// The same surface with q ≥ 0 at the lowest height that matters (the mean) and the phase within one fold.
pub(super) fn canonical(lines: Lines) -> Lines {
    let mut values = lines.values;
    let half = std::f64::consts::PI / f64::from(lines.folds.max(1));
    if values[4] < 0.0 {
        (values[4], values[9]) = (-values[4], -values[9]);
        values[2] += half;
    }
    values[2] = values[2].rem_euclid(2.0 * half);
    Lines { values, ..lines }
}
