//! A predicted hem, treated as if it had been measured: fitted with the same curve, under the same rules, so that its responses mean the same.

use super::campaign::{RunStudy, fit_options, measure};
use crate::experiment::campaign::Folds;
use crate::experiment::{Campaign, DrapeProfile};

/// Points that stand for a predicted hem; an outline of ten folds then has 36 in each.
const POINTS: usize = 360;

/// The run with its predicted hem (that of least energy over all fold counts) in the place of the measured one.
///
/// `None` if there is no prediction, or the predicted hem cannot be fitted. A hem that is predicted round has no folds and no q, s or λ.
pub fn as_measured(campaign: &Campaign, run: &RunStudy) -> Option<RunStudy> {
    let prediction = run.prediction.as_ref()?;
    let step = (prediction.outline.len() / POINTS).max(1);
    let outline: Vec<_> = prediction.outline.iter().copied().step_by(step).collect();
    let profile = DrapeProfile::new(&outline).ok()?;
    let mut options = fit_options(campaign, &run.run);
    if 2 <= prediction.folds {
        options.folds = Folds::Exactly(prediction.folds);
    }
    let mut predicted = RunStudy::of(run.run.clone(), Some(profile));
    measure(campaign, &mut predicted, &options);
    let agrees = predicted.fit.as_ref().is_ok_and(|fit| fit.folds.unwrap_or(0) == prediction.folds);
    agrees.then_some(predicted)
}
