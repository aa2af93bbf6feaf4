//! A part of a campaign, no further than asked: what a single figure needs.

use rayon::prelude::*;

use super::campaign::{CampaignStudy, Measured, Regression, RunStudy, factorial, fit_options, measure, predict};
use super::fidelities;
use super::identify::identify_all;
use super::irregular::irregular;
use super::response;
use crate::experiment::{Campaign, DrapeProfile, Run};
use crate::statistics::box_wilson;

/// Which runs, and what of them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Part {
    pub runs: Runs,
    /// Predict the hems of these runs, and compare.
    pub theory: bool,
    /// Fit the other curves too, and look at the folds one by one.
    pub shapes: bool,
    /// Predict by every fidelity; says nothing without `theory`.
    pub fidelities: bool,
    /// Responses to regress, by either of their names.
    pub responses: Vec<String>,
}

/// Which runs are looked at.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Runs {
    #[default]
    None,
    /// By id.
    These(Vec<String>),
    All,
}

impl Part {
    /// Whether this run is fitted.
    pub fn takes(&self, run: &Run) -> bool {
        match &self.runs {
            Runs::None => false,
            Runs::These(ids) => ids.contains(&run.id),
            Runs::All => true,
        }
    }
}

/// As [`super::campaign::analyse`], of a part. The other runs are there without a fit; a regression has its analysis and nothing further, unadjusted for the
/// responses that were not asked for. What is computed is the same as in the whole.
pub fn analyse_part(measured: Measured, part: &Part, progress: &(dyn Fn() + Sync)) -> CampaignStudy {
    let Measured { campaign, profiles, quarantine, sources, notes } = measured;
    let runs: Vec<RunStudy> = campaign
        .design
        .runs
        .par_iter()
        .zip(profiles)
        .map(|(run, profile)| {
            if !part.takes(run) {
                let mut left = RunStudy::of(run.clone(), profile);
                left.fit = Err("it was not asked for".into());
                return left;
            }
            let study = one_run(&campaign, run, profile, part);
            progress();
            study
        })
        .collect();
    let regressions = part.responses.iter().filter_map(|name| regression(&campaign, name, &runs)).collect();
    let fidelities = if part.fidelities { fidelities::against(&runs, campaign.gravity) } else { vec![] };
    let identified = if part.fidelities { identify_all(&campaign, &runs) } else { vec![] };
    CampaignStudy { campaign, runs, regressions, desirable: None, fidelities, identified, quarantine, sources, notes }
}

fn one_run(campaign: &Campaign, run: &Run, profile: Option<DrapeProfile>, part: &Part) -> RunStudy {
    let mut study = RunStudy::of(run.clone(), profile);
    measure(campaign, &mut study, &fit_options(campaign, run));
    if part.shapes
        && let (Some(profile), Ok(fitted)) = (&study.profile, &study.fit)
    {
        study.irregular = Some(irregular(profile, fitted));
    }
    if part.theory {
        predict(campaign, &mut study);
    }
    study
}

/// The response over the design; `None` if there is no such response.
fn regression(campaign: &Campaign, name: &str, runs: &[RunStudy]) -> Option<Regression> {
    let response = response::named(name, response::weighed(campaign))?;
    let values: Vec<Option<f64>> = runs.iter().map(|run| response::value(&response, run)).collect();
    let options = box_wilson::Options { alpha: campaign.alpha };
    let analysis = factorial(campaign).and_then(|design| match values.iter().any(Option::is_some) {
        true => box_wilson::analyse(&design, &values, &options).map_err(|e| e.to_string()),
        false => Err("no run has this number".into()),
    });
    Some(Regression { response: response.column.to_string(), values, analysis, further: Err("it was not asked for".into()) })
}
