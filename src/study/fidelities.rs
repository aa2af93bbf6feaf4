//! Which theory comes nearest to the measurements: every fidelity against every run, and per cell of the design.

use rayon::prelude::*;
use serde::Serialize;

use super::campaign::RunStudy;
use super::comparison::{Comparison, compare};
use crate::simulate::{Fidelity, Folds, Options, graded, predict, ruled};

/// One fidelity against one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FidelityRun {
    pub run: String,
    /// Coded levels: the cell of the design.
    pub levels: Vec<f64>,
    /// `graded`, `ruled` or `ansatz`.
    pub fidelity: &'static str,
    /// Fold count of least energy; 0 is round.
    pub predicted_folds: u32,
    /// Fold count of the fitted curve; 0 is round.
    pub fitted_folds: u32,
    /// Predicted over fitted fold depth at the fitted fold count.
    pub depth_ratio: Option<f64>,
    /// At the fitted fold count; `None` where the theory has no such branch.
    pub comparison: Option<Comparison>,
}

/// One fidelity against many runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FidelitySummary {
    pub fidelity: &'static str,
    /// The cell; `None` for all runs.
    pub levels: Option<Vec<f64>>,
    pub runs: usize,
    /// Runs whose fold count is predicted exactly, and within one.
    pub exact: usize,
    pub within_one: usize,
    /// Runs with a branch of the fitted fold count, of which the medians below are.
    pub compared: usize,
    /// Median root mean square distance of the measured points from the predicted hem, m.
    pub rms: Option<f64>,
    /// Median of predicted over fitted depth.
    pub depth_ratio: Option<f64>,
    /// Median of predicted minus fitted mean radius, m: positive where the theory hangs too far out.
    pub mean_radius: Option<f64>,
}

/// The fidelities that are compared, the most complete first.
const FIDELITIES: [(&str, Fidelity); 3] = [
    ("graded", Fidelity::Graded { harmonics: graded::HARMONICS, modes: graded::MODES, shear: 0.0 }),
    ("ruled", Fidelity::Ruled { harmonics: ruled::HARMONICS }),
    ("ansatz", Fidelity::Ansatz),
];

/// Every fidelity against every run that was fitted and whose cloth and cut are known; in run order, the fidelities of a run together.
///
/// Runs are worked on in parallel; the result does not depend on the number of threads. `gravity` in m/s².
pub fn against(runs: &[RunStudy], gravity: f64) -> Vec<FidelityRun> {
    runs.par_iter().flat_map_iter(|run| FIDELITIES.iter().filter_map(move |(name, fidelity)| one(run, name, *fidelity, gravity))).collect()
}

fn one(study: &RunStudy, name: &'static str, fidelity: Fidelity, gravity: f64) -> Option<FidelityRun> {
    let (skirt, profile, fit) = (study.run.skirt.as_ref()?, study.profile.as_ref()?, study.fit.as_ref().ok()?);
    let options = Options { fidelity, gravity, ..Options::default() };
    let chosen = predict(skirt, &study.run.fabric, &options).ok()?;
    // Cloth is metastable, so shapes are compared at the fold count that was measured.
    let at_fitted = fit.folds.and_then(|m| {
        if chosen.folds == m {
            return Some(chosen.clone());
        }
        predict(skirt, &study.run.fabric, &Options { folds: Folds::Exactly(m), ..options }).ok().filter(|p| p.folds == m)
    });
    Some(FidelityRun {
        run: study.run.id.clone(),
        levels: study.run.levels.clone(),
        fidelity: name,
        predicted_folds: chosen.folds,
        fitted_folds: fit.folds.unwrap_or(0),
        depth_ratio: at_fitted.as_ref().filter(|_| 0.0 < fit.fold_depth).map(|p| p.depth() / fit.fold_depth),
        comparison: at_fitted.as_ref().map(|p| compare(profile, fit, p, &chosen)),
    })
}

/// All runs of each fidelity, then each cell, in the order in which the cells occur.
pub fn summarize(rows: &[FidelityRun]) -> Vec<FidelitySummary> {
    let mut cells: Vec<&[f64]> = Vec::new();
    for row in rows {
        if !cells.contains(&row.levels.as_slice()) {
            cells.push(&row.levels);
        }
    }
    let scopes = std::iter::once(None).chain(cells.into_iter().map(Some));
    scopes
        .flat_map(|cell| FIDELITIES.iter().map(move |(name, _)| (cell, *name)))
        .map(|(cell, name)| {
            let chosen: Vec<&FidelityRun> = rows.iter().filter(|r| r.fidelity == name && cell.is_none_or(|c| c == r.levels)).collect();
            let off = |most: u32| chosen.iter().filter(|r| r.predicted_folds.abs_diff(r.fitted_folds) <= most).count();
            let over = |f: &dyn Fn(&Comparison) -> f64| median(chosen.iter().filter_map(|r| r.comparison.as_ref().map(f)).collect());
            FidelitySummary {
                fidelity: name,
                levels: cell.map(<[f64]>::to_vec),
                runs: chosen.len(),
                exact: off(0),
                within_one: off(1),
                compared: chosen.iter().filter(|r| r.comparison.is_some()).count(),
                rms: over(&|c| c.rms),
                depth_ratio: median(chosen.iter().filter_map(|r| r.depth_ratio).collect()),
                mean_radius: over(&|c| c.mean_radius),
            }
        })
        .collect()
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (0 < n).then(|| 0.5 * (values[(n - 1) / 2] + values[n / 2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(fidelity: &'static str, level: f64, predicted: u32, fitted: u32, ratio: f64) -> FidelityRun {
        FidelityRun {
            run: "1".into(),
            levels: vec![level],
            fidelity,
            predicted_folds: predicted,
            fitted_folds: fitted,
            depth_ratio: Some(ratio),
            comparison: None,
        }
    }

    #[test]
    fn summary_counts_each_fidelity_over_all_runs_and_over_each_cell() {
        let rows =
            [row("graded", -1.0, 5, 5, 0.9), row("graded", 1.0, 6, 5, 1.0), row("graded", 1.0, 8, 5, 1.3), row("ruled", -1.0, 7, 5, 2.0)];
        let all = summarize(&rows);
        let of = |fidelity: &str, levels: Option<Vec<f64>>| all.iter().find(|s| s.fidelity == fidelity && s.levels == levels).unwrap();
        let graded = of("graded", None);
        assert_eq!((graded.runs, graded.exact, graded.within_one, graded.compared, graded.depth_ratio), (3, 1, 2, 0, Some(1.0)));
        assert_eq!(of("graded", Some(vec![1.0])).depth_ratio, Some(1.15));
        assert_eq!((of("ruled", Some(vec![1.0])).runs, of("ruled", Some(vec![1.0])).depth_ratio), (0, None));
        assert_eq!(of("ruled", None).within_one, 0);
    }
}
