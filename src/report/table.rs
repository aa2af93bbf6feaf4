//! Which tables there are, and what stands in each row: lengths in mm, areas in mm², everything else in SI, named in the column.

use super::csv::{Cell, Table};
use super::note;
use super::sureness;
use crate::experiment::DrapeProfile;
use crate::experiment::Quarantined;
use crate::fit::lambda::Lambda;
use crate::fit::{Estimate, HemFit, Termination};
use crate::simulate;
use crate::study::campaign::RunStudy;
use crate::units::{MILLIMETRE, PERCENT};

/// The columns of `fits.csv` in order; the first 23 are fixed for good, later ones may be added to at the end.
pub const FIT_COLUMNS: [&str; 89] = [
    "run",
    "n_points",
    "termination",
    "m",
    "m_weight",
    "p_mm",
    "p_se_mm",
    "q_mm",
    "q_se_mm",
    "s_mm",
    "s_se_mm",
    "x0_mm",
    "y0_mm",
    "phase_rad",
    "rms_mm",
    "perimeter_mm",
    "area_mm2",
    "fold_depth_mm",
    "lambda_first_integral_n_m2",
    "lambda_first_integral_r2",
    "lambda_ritz_n_m2",
    "lambda_ritz_angle_deg",
    "lambda_ruled_n",
    "lambda_first_integral_se_n_m2",
    "lambda_ritz_se_n_m2",
    "lambda_ruled_se_n",
    "lambda_ruled_angle_deg",
    "lambda_over_weight",
    "lambda_over_weight_se",
    "lambda_over_weight_r2",
    "lambda_over_weight_ritz",
    "lambda_over_weight_ritz_angle_deg",
    "lambda_missing",
    "explained_share",
    "overhangs",
    "mean_radius_mm",
    "drape_coefficient_percent",
    "outline_length_mm",
    "held_length_mm",
    "held_multiplier_mm",
    "broken_rule",
    "points_scattered",
    "evaluations",
    "predicted_m",
    "predicted_energy_j",
    "predicted_fidelity",
    "predicted_at_fitted_m_energy_j",
    "predicted_at_fitted_m_radius_min_mm",
    "predicted_at_fitted_m_radius_max_mm",
    "prediction_missing",
    "theory_gap_mm",
    "theory_minus_fit_fold_depth_mm",
    "theory_minus_fit_mean_radius_mm",
    "theory_minus_fit_m",
    "x0_se_mm",
    "y0_se_mm",
    "phase_se_rad",
    "standard_error_missing",
    "degrees_of_freedom",
    "correlation_p_q",
    "correlation_p_s",
    "correlation_q_s",
    "correlation_q_phase",
    "correlation_s_phase",
    "bias_correction",
    "bias_p_mm",
    "bias_q_mm",
    "bias_s_mm",
    "bias_sigma_mm",
    "bias_bend",
    "bias_rounds",
    "interval_kind",
    "interval_level",
    "p_low_mm",
    "p_high_mm",
    "q_low_mm",
    "q_high_mm",
    "s_low_mm",
    "s_high_mm",
    "phase_low_rad",
    "phase_high_rad",
    "intervals_open",
    "replicates",
    "replicates_failed",
    "bootstrap_p_se_mm",
    "bootstrap_q_se_mm",
    "bootstrap_s_se_mm",
    "bootstrap_phase_se_rad",
    "notes",
];

/// What one row of `fits.csv` is made from: a run of a campaign, or a profile that was fitted without one.
#[derive(Debug, Clone, Copy)]
pub struct FitRow<'a> {
    /// The run, or the profile's name.
    pub run: &'a str,
    pub profile: Option<&'a DrapeProfile>,
    pub fit: &'a Result<HemFit, String>,
    pub lambda: &'a Lambda,
    /// Predictions and their comparison, where the run belongs to a campaign.
    pub study: Option<&'a RunStudy>,
}

impl<'a> From<&'a RunStudy> for FitRow<'a> {
    fn from(study: &'a RunStudy) -> Self {
        FitRow { run: &study.run.id, profile: study.profile.as_ref(), fit: &study.fit, lambda: &study.lambda, study: Some(study) }
    }
}

/// `fits.csv`: one row for each run, fitted or not.
pub fn fits<'a>(rows: impl IntoIterator<Item = FitRow<'a>>) -> Table {
    let mut table = Table::new(&FIT_COLUMNS);
    for row in rows {
        table.push(fit_row(&row));
    }
    table
}

fn fit_row(row: &FitRow<'_>) -> Vec<Cell> {
    let fit = row.fit.as_ref().ok();
    let mm = |pick: &dyn Fn(&HemFit) -> f64| Cell::from(fit.map(|f| pick(f) / MILLIMETRE));
    let value = |pick: &dyn Fn(&HemFit) -> Option<Estimate>| Cell::from(fit.and_then(pick).map(|e| e.value / MILLIMETRE));
    let error =
        |pick: &dyn Fn(&HemFit) -> Option<Estimate>| Cell::from(fit.and_then(pick).and_then(|e| e.standard_error).map(|e| e / MILLIMETRE));
    let (p, q, s) = (|f: &HemFit| Some(f.p), |f: &HemFit| f.q, |f: &HemFit| f.s);
    let folds = fit.and_then(|f| f.folds);
    let termination = match row.fit {
        Ok(fit) => note::termination(&fit.termination),
        Err(_) if row.profile.is_none() => "set_aside",
        Err(_) => "no_fit",
    };
    let broken = fit.and_then(|f| match f.termination {
        Termination::HeldLength { broken } | Termination::InOrder { broken } => Some(note::rule_name(broken)),
        _ => None,
    });
    let l = row.lambda;
    let prediction = row.study.and_then(|s| s.prediction.as_ref());
    let at_fitted = row.study.and_then(|s| s.prediction_at_fitted_folds.as_ref());
    let comparison = row.study.and_then(|s| s.comparison.as_ref());
    let notes = row.study.map_or_else(|| fit_notes(row.fit), note::of);
    let mut cells: Vec<Cell> = vec![
        row.run.into(),
        row.profile.map(|p| p.points().len()).into(),
        termination.into(),
        folds.into(),
        folds.and(fit).map(|f| f.folds_weight).into(),
        value(&p),
        error(&p),
        value(&q),
        error(&q),
        value(&s),
        error(&s),
        mm(&|f| f.placement.x0),
        mm(&|f| f.placement.y0),
        folds.and(fit).map(|f| f.placement.phase).into(),
        mm(&|f| f.rms),
        mm(&|f| f.perimeter),
        fit.map(|f| f.area / (MILLIMETRE * MILLIMETRE)).into(),
        mm(&|f| f.fold_depth),
        l.first_integral.map(|(e, _)| e.value).into(),
        l.first_integral.map(|(_, r2)| r2).into(),
        l.ritz.map(|(e, _)| e.value).into(),
        l.ritz.map(|(_, angle)| angle).into(),
        l.ruled.map(|(e, _)| e.value).into(),
        l.first_integral.and_then(|(e, _)| e.standard_error).into(),
        l.ritz.and_then(|(e, _)| e.standard_error).into(),
        l.ruled.and_then(|(e, _)| e.standard_error).into(),
        l.ruled.map(|(_, angle)| angle).into(),
        l.over_weight.map(|(e, _)| e.value).into(),
        l.over_weight.and_then(|(e, _)| e.standard_error).into(),
        l.over_weight.map(|(_, r2)| r2).into(),
        l.over_weight_ritz.map(|(e, _)| e.value).into(),
        l.over_weight_ritz.map(|(_, angle)| angle).into(),
        l.missing.clone().into(),
        folds.and(fit).map(|f| f.explained).into(),
        fit.map(|f| f.hem.overhangs()).into(),
        mm(&|f| (f.area / std::f64::consts::PI).sqrt()),
        row.study.and_then(|s| s.drape_coefficient).map(|share| share / PERCENT).into(),
        mm(&|f| f.outline_length),
        fit.and_then(|f| f.held).map(|h| h.length / MILLIMETRE).into(),
        fit.and_then(|f| f.held).map(|h| h.multiplier / MILLIMETRE).into(),
        broken.into(),
        row.profile.map(DrapeProfile::was_scattered).into(),
        fit.map(|f| f.evaluations).into(),
        prediction.map(|p| p.folds).into(),
        prediction.map(|p| p.energy).into(),
        prediction.map(|p| p.fidelity.clone()).into(),
        at_fitted.map(|p| p.energy).into(),
        at_fitted.map(|p| p.hem_radius_min / MILLIMETRE).into(),
        at_fitted.map(|p| p.hem_radius_max / MILLIMETRE).into(),
        row.study.and_then(|s| s.prediction_missing.clone()).into(),
        comparison.map(|c| c.rms / MILLIMETRE).into(),
        comparison.map(|c| c.depth / MILLIMETRE).into(),
        comparison.map(|c| c.mean_radius / MILLIMETRE).into(),
        comparison.map(|c| c.folds).into(),
    ];
    cells.extend(sureness::cells(fit));
    cells.push((!notes.is_empty()).then(|| notes.join(" ")).into());
    cells
}

fn fit_notes(fit: &Result<HemFit, String>) -> Vec<String> {
    match fit {
        Ok(fit) => note::of_fit(fit),
        Err(reason) => vec![format!("No fit: {}.", reason.trim_end_matches('.'))],
    }
}

/// `quarantine.csv`: what was set aside, where it stood, and what would be right.
pub fn quarantine(set_aside: &[Quarantined]) -> Table {
    let mut table = Table::new(&["run", "file", "sheet", "row", "value", "problem", "remedy"]);
    for item in set_aside {
        table.push(vec![
            item.run.clone().into(),
            item.file.display().to_string().into(),
            item.sheet.clone().into(),
            item.row.into(),
            item.value.as_str().into(),
            item.problem.as_str().into(),
            item.remedy.as_str().into(),
        ]);
    }
    table
}

/// `candidates.csv`: every fold count that was tried for every run; 0 is the circle.
pub fn candidates<'a>(rows: impl IntoIterator<Item = FitRow<'a>>) -> Table {
    let mut table = Table::new(&["run", "m", "rms_mm", "aicc", "weight", "termination", "broken_rule", "chosen"]);
    for row in rows {
        let Ok(fit) = row.fit else { continue };
        for c in &fit.candidates {
            table.push(vec![
                row.run.into(),
                c.folds.into(),
                (c.rms / MILLIMETRE).into(),
                c.aicc.into(),
                c.weight.into(),
                note::termination(&c.termination).into(),
                c.broken.map(note::rule_name).into(),
                (c.folds == fit.folds.unwrap_or(0)).into(),
            ]);
        }
    }
    table
}

/// `predictions.csv`: every branch of the theory for every run, the chosen one marked.
pub fn predictions(runs: &[RunStudy]) -> Table {
    let columns = ["run", "fidelity", "m_asked", "m", "energy_j", "fold_depth_mm", "termination", "chosen", "at_fitted_m"];
    let mut table = Table::new(&columns);
    for study in runs {
        let Some(prediction) = &study.prediction else { continue };
        let fitted = study.fit.as_ref().ok().and_then(|f| f.folds);
        for branch in &prediction.branches {
            table.push(vec![
                study.run.id.as_str().into(),
                prediction.fidelity.as_str().into(),
                branch.asked.into(),
                branch.folds.into(),
                branch.energy.into(),
                (branch.depth / MILLIMETRE).into(),
                ended(branch.termination).into(),
                (branch.folds == prediction.folds).into(),
                (Some(branch.folds) == fitted).into(),
            ]);
        }
    }
    table
}

fn ended(termination: simulate::Termination) -> &'static str {
    match termination {
        simulate::Termination::Converged => "converged",
        simulate::Termination::Stalled => "stalled",
        simulate::Termination::EvaluationLimit => "evaluation_limit",
        simulate::Termination::Round => "round",
    }
}

/// `points.csv`: every measured point of every fitted run, in order round the hem, with its distance from the curve.
///
/// `point` is its place in the input file, 1 for the first point.
pub fn points<'a>(rows: impl IntoIterator<Item = FitRow<'a>>) -> Table {
    let mut table = Table::new(&["run", "point", "x_mm", "y_mm", "t_rad", "distance_mm"]);
    for row in rows {
        let (Some(profile), Ok(fit)) = (row.profile, row.fit) else { continue };
        for (i, point) in profile.points().iter().enumerate() {
            table.push(vec![
                row.run.into(),
                (profile.source_index()[i] + 1).into(),
                (point.x / MILLIMETRE).into(),
                (point.y / MILLIMETRE).into(),
                fit.feet.get(i).copied().into(),
                fit.distances.get(i).map(|d| d / MILLIMETRE).into(),
            ]);
        }
    }
    table
}
