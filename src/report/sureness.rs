//! How sure a fit is, in cells: standard errors that are missing and why, correlations, the bias taken out, intervals.

use super::csv::Cell;
use crate::fit::HemFit;
use crate::fit::bias::BiasCorrection;
use crate::fit::intervals::{End, Interval, Intervals};
use crate::units::MILLIMETRE;

/// The cells of `fits.csv` from `x0_se_mm` to `bootstrap_phase_se_rad`.
pub fn cells(fit: Option<&HemFit>) -> Vec<Cell> {
    let error = |i: usize| fit.and_then(|f| f.placement_errors[i]);
    // x0, y0, phase, p, q, s.
    let correlation = |i: usize, j: usize| Cell::from(fit.and_then(|f| f.correlation).map(|c| c[i][j]));
    let bias = fit.and_then(|f| f.bias_correction.applied());
    let mut cells: Vec<Cell> = vec![
        error(0).map(|e| e / MILLIMETRE).into(),
        error(1).map(|e| e / MILLIMETRE).into(),
        error(2).into(),
        fit.and_then(missing).into(),
        fit.map(|f| f.degrees_of_freedom).into(),
        correlation(3, 4),
        correlation(3, 5),
        correlation(4, 5),
        correlation(4, 2),
        correlation(5, 2),
        fit.map(|f| correction(&f.bias_correction)).into(),
        bias.map(|c| c.p / MILLIMETRE).into(),
        bias.map(|c| c.q / MILLIMETRE).into(),
        bias.map(|c| c.s / MILLIMETRE).into(),
        bias.map(|c| c.sigma / MILLIMETRE).into(),
        bias.map(|c| c.bend).into(),
        bias.map(|c| c.rounds).into(),
    ];
    cells.extend(intervals(fit.and_then(|f| f.intervals.as_ref())));
    cells
}

/// `q:no_folds s:no_folds phase:no_folds`, for every estimate without a standard error.
fn missing(fit: &HemFit) -> Option<String> {
    let said: Vec<String> = fit.standard_error_missing.iter().map(|m| format!("{}:{}", m.unknown.name(), m.why.name())).collect();
    (!said.is_empty()).then(|| said.join(" "))
}

fn correction(correction: &BiasCorrection) -> &'static str {
    match correction {
        BiasCorrection::Applied(_) => "applied",
        BiasCorrection::Left(why) => why.name(),
    }
}

fn intervals(found: Option<&Intervals>) -> Vec<Cell> {
    let named: [(&str, Option<Interval>, f64); 4] = [
        ("p", found.and_then(|i| i.p), MILLIMETRE),
        ("q", found.and_then(|i| i.q), MILLIMETRE),
        ("s", found.and_then(|i| i.s), MILLIMETRE),
        ("phase", found.and_then(|i| i.phase), 1.0),
    ];
    let mut cells: Vec<Cell> = vec![found.map(|i| i.kind.name()).into(), found.map(|i| i.level).into()];
    let mut open = Vec::new();
    for (name, interval, unit) in named {
        for (side, end) in [("low", interval.map(|i| i.low)), ("high", interval.map(|i| i.high))] {
            cells.push(end.and_then(End::value).map(|value| value / unit).into());
            match end {
                Some(End::Open) => open.push(format!("{name}_{side}:open")),
                Some(End::Lost) => open.push(format!("{name}_{side}:lost")),
                Some(End::Bound(_)) => open.push(format!("{name}_{side}:bound")),
                Some(End::At(_)) | None => (),
            }
        }
    }
    cells.push((!open.is_empty()).then(|| open.join(" ")).into());
    let replicates = found.and_then(|i| i.replicates.as_ref());
    cells.push(replicates.map(|r| r.asked).into());
    cells.push(replicates.map(|r| r.failed).into());
    for (slot, unit) in [MILLIMETRE, MILLIMETRE, MILLIMETRE, 1.0].into_iter().enumerate() {
        cells.push(replicates.and_then(|r| r.standard_errors[slot]).map(|e| e / unit).into());
    }
    cells
}
