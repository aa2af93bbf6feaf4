//! Which theory comes nearest to the measurements: every fidelity against every run, and per cell of the design.

use rayon::prelude::*;
use serde::Serialize;

use super::campaign::RunStudy;
use super::comparison::{Comparison, compare};
use crate::experiment::{DrapeProfile, Fabric, Skirt};
use crate::fit::HemFit;
use crate::simulate::{Fidelity, Folds, Options, Prediction, graded, predict, ruled};

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
pub const FIDELITIES: [(&str, Fidelity); 3] = [
    ("graded", Fidelity::Graded { harmonics: graded::HARMONICS, modes: graded::MODES, shear: 0.0 }),
    ("ruled", Fidelity::Ruled { harmonics: ruled::HARMONICS }),
    ("ansatz", Fidelity::Ansatz),
];

/// The compared fidelities with the sizes they were solved at: `graded(K = 3, J = 6)` …
pub fn described() -> Vec<String> {
    let one = |(name, fidelity): &(&str, Fidelity)| match fidelity {
        Fidelity::Graded { harmonics, modes, .. } => format!("{name}(K = {harmonics}, J = {modes})"),
        Fidelity::Ruled { harmonics } => format!("{name}(K = {harmonics})"),
        _ => (*name).to_string(),
    };
    FIDELITIES.iter().map(one).collect()
}

/// Every fidelity against every run that was fitted and whose cloth and cut are known; in run order, the fidelities of a run together.
///
/// Replicates share their cut and cloth, so each theory is asked once for each treatment (and fold count), not for each run. Worked on in
/// parallel; the result does not depend on the number of threads. `gravity` is that of the campaign, m/s².
pub fn against(runs: &[RunStudy], gravity: f64) -> Vec<FidelityRun> {
    let known: Vec<Known<'_>> = runs.iter().filter_map(Known::of).collect();
    let mut scenes: Vec<(Skirt, Fabric)> = Vec::new();
    for run in &known {
        if !scenes.contains(&run.scene()) {
            scenes.push(run.scene());
        }
    }
    let scene_of: Vec<usize> = known.iter().map(|run| scenes.iter().position(|s| *s == run.scene()).unwrap_or(0)).collect();
    // The campaign's own theory has been asked and compared already, unless it predicts by other terms or another size.
    let names = described();
    let as_is =
        |fidelity: usize| runs.iter().filter_map(|r| r.prediction.as_ref()).all(|p| p.fidelity == names[fidelity] && p.terms.len() == 2);
    let own = |fidelity: usize| FIDELITIES[fidelity].1 == Options::default().fidelity && as_is(fidelity);
    let ask = |scene: usize, fidelity: usize, folds: Folds| {
        let options = Options { fidelity: FIDELITIES[fidelity].1, folds, gravity, ..Options::default() };
        let (skirt, fabric) = &scenes[scene];
        predict(skirt, fabric, &options).ok()
    };
    let pairs: Vec<(usize, usize)> =
        (0..scenes.len()).flat_map(|scene| (0..FIDELITIES.len()).map(move |fidelity| (scene, fidelity))).collect();
    let chosen: Vec<Option<Prediction>> =
        pairs.par_iter().map(|&(scene, fidelity)| if own(fidelity) { None } else { ask(scene, fidelity, Folds::Auto) }).collect();
    let chosen_of = |scene: usize, fidelity: usize| chosen[scene * FIDELITIES.len() + fidelity].as_ref();
    // Cloth is metastable, so shapes are compared at the fold count that was measured.
    let mut others: Vec<(usize, usize, u32)> = Vec::new();
    for (run, &scene) in known.iter().zip(&scene_of) {
        for fidelity in 0..FIDELITIES.len() {
            if let (Some(m), Some(chosen)) = (run.fit.folds, chosen_of(scene, fidelity))
                && m != chosen.folds
                && !others.contains(&(scene, fidelity, m))
            {
                others.push((scene, fidelity, m));
            }
        }
    }
    let at_others: Vec<Option<Prediction>> =
        others.par_iter().map(|&(scene, fidelity, m)| ask(scene, fidelity, Folds::Exactly(m)).filter(|p| p.folds == m)).collect();
    known
        .par_iter()
        .zip(&scene_of)
        .flat_map_iter(|(run, &scene)| {
            let (others, at_others) = (&others, &at_others);
            (0..FIDELITIES.len()).filter_map(move |fidelity| {
                if own(fidelity) {
                    return run.own(FIDELITIES[fidelity].0);
                }
                let chosen = chosen_of(scene, fidelity)?;
                let at_fitted = run.fit.folds.and_then(|m| {
                    if m == chosen.folds {
                        return Some(chosen);
                    }
                    at_others[others.iter().position(|o| *o == (scene, fidelity, m))?].as_ref()
                });
                let comparison = at_fitted.map(|p| compare(run.profile, run.fit, p, chosen));
                Some(run.row(FIDELITIES[fidelity].0, chosen, at_fitted, comparison))
            })
        })
        .collect()
}

/// A run with all that a comparison needs.
struct Known<'a> {
    study: &'a RunStudy,
    skirt: Skirt,
    profile: &'a DrapeProfile,
    fit: &'a HemFit,
}

impl<'a> Known<'a> {
    fn of(study: &'a RunStudy) -> Option<Self> {
        Some(Known { study, skirt: study.run.skirt?, profile: study.profile.as_ref()?, fit: study.fit.as_ref().ok()? })
    }

    /// What a theory is told.
    fn scene(&self) -> (Skirt, Fabric) {
        (self.skirt, self.study.run.fabric)
    }

    /// The campaign's own theory.
    fn own(&self, fidelity: &'static str) -> Option<FidelityRun> {
        let at_fitted = self.study.prediction_at_fitted_folds.as_ref().filter(|p| Some(p.folds) == self.fit.folds);
        Some(self.row(fidelity, self.study.prediction.as_ref()?, at_fitted, self.study.comparison.clone()))
    }

    fn row(
        &self,
        fidelity: &'static str,
        chosen: &Prediction,
        at_fitted: Option<&Prediction>,
        comparison: Option<Comparison>,
    ) -> FidelityRun {
        FidelityRun {
            run: self.study.run.id.clone(),
            levels: self.study.run.levels.clone(),
            fidelity,
            predicted_folds: chosen.folds,
            fitted_folds: self.fit.folds.unwrap_or(0),
            depth_ratio: at_fitted.filter(|_| 0.0 < self.fit.fold_depth).map(|p| p.depth() / self.fit.fold_depth),
            comparison,
        }
    }
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
