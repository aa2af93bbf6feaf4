//! Profiles → fits → responses → regression: one campaign, all of it.

use rayon::prelude::*;

use super::comparison::{Comparison, compare};
use super::fidelities::{self, FidelityRun};
use super::response;
use crate::experiment::{Apparatus, Campaign, DrapeProfile, Point, Quarantined, Run, Skirt, Source};
use crate::fit::lambda::{Lambda, lambda};
use crate::fit::{self, HemFit};
use crate::simulate::{self, Prediction};
use crate::statistics::box_wilson::{self, Analysis};
use crate::statistics::factorial::{Axis, FactorialDesign};
use crate::statistics::family;

/// Everything known about one run.
#[derive(Debug, Clone)]
pub struct RunStudy {
    pub run: Run,
    /// `None`: the profile was set aside; the reason is in the quarantine.
    pub profile: Option<DrapeProfile>,
    /// The fit, or why there is none.
    pub fit: Result<HemFit, String>,
    pub lambda: Lambda,
    /// Drape coefficient of the outline as a share, 0…1 for a hem between support and specimen edge; only on a drape tester.
    pub drape_coefficient: Option<f64>,
    /// The hem of least energy over all fold counts.
    pub prediction: Option<Prediction>,
    /// The hem of least energy at the fitted fold count.
    pub prediction_at_fitted_folds: Option<Prediction>,
    /// Why there is no prediction, where there is none.
    pub prediction_missing: Option<String>,
    pub comparison: Option<Comparison>,
}

/// One response over the whole design.
#[derive(Debug, Clone)]
pub struct Regression {
    /// Its column of the fits table; the suffix is the unit.
    pub response: String,
    /// One per run, in run order; `None` where the run has no such number.
    pub values: Vec<Option<f64>>,
    /// The analysis, or why there is none.
    pub analysis: Result<Analysis, String>,
}

/// One campaign, analysed.
#[derive(Debug, Clone)]
pub struct CampaignStudy {
    pub campaign: Campaign,
    /// In run order.
    pub runs: Vec<RunStudy>,
    /// In the order that the campaign asks for.
    pub regressions: Vec<Regression>,
    /// Every fidelity of the theory against every run of known cloth and cut, in run order.
    pub fidelities: Vec<FidelityRun>,
    /// What was set aside on reading.
    pub quarantine: Vec<Quarantined>,
    /// What was read.
    pub sources: Vec<Source>,
    /// What a reader should know about the campaign as a whole, in words.
    pub notes: Vec<String>,
}

/// What was read from disk, ready to be analysed.
#[derive(Debug, Clone)]
pub struct Measured {
    pub campaign: Campaign,
    /// One per run of the design.
    pub profiles: Vec<Option<DrapeProfile>>,
    pub quarantine: Vec<Quarantined>,
    pub sources: Vec<Source>,
    pub notes: Vec<String>,
}

/// Fits every run, predicts it where cloth and cut are known, compares, and regresses every response. Runs are worked on in parallel; the
/// result does not depend on the number of threads. `progress` is called once for each run that is done.
pub fn analyse(measured: Measured, progress: &(dyn Fn() + Sync)) -> CampaignStudy {
    let Measured { campaign, profiles, quarantine, sources, mut notes } = measured;
    let runs: Vec<RunStudy> = campaign
        .design
        .runs
        .par_iter()
        .zip(profiles)
        .map(|(run, profile)| {
            let study = one_run(&campaign, run, profile);
            progress();
            study
        })
        .collect();
    let regressions = regress(&campaign, &runs, &mut notes);
    let fidelities = fidelities::against(&runs, campaign.gravity);
    CampaignStudy { campaign, runs, regressions, fidelities, quarantine, sources, notes }
}

fn one_run(campaign: &Campaign, run: &Run, profile: Option<DrapeProfile>) -> RunStudy {
    let mut study = RunStudy {
        run: run.clone(),
        profile,
        fit: Err("the profile was set aside; the quarantine says why".into()),
        lambda: Lambda::default(),
        drape_coefficient: None,
        prediction: None,
        prediction_at_fitted_folds: None,
        prediction_missing: None,
        comparison: None,
    };
    let Some(profile) = &study.profile else { return study };
    // A skirt's hem hangs nearly level, so its plan view is as long as the cloth was cut; the edge on a drape tester rises and falls.
    let cut = run.skirt.as_ref().filter(|_| campaign.apparatus == Apparatus::Skirt);
    let cut_length = cut.map(|skirt| std::f64::consts::TAU * skirt.hem_radius().0);
    let options = fit::Options { folds: campaign.folds, length: campaign.hem_length, cut_length, ..fit::Options::default() };
    study.fit = fit::fit(profile, &options).map_err(|e| e.to_string());
    study.drape_coefficient =
        run.skirt.as_ref().filter(|_| campaign.apparatus == Apparatus::Drapemeter).map(|s| drape_coefficient(s, profile.points()));
    let Ok(fitted) = &study.fit else { return study };
    if fitted.folds.is_some() {
        study.lambda =
            lambda(&fitted.hem, fitted.covariance.as_ref(), run.skirt.as_ref(), &run.fabric, campaign.gravity, campaign.foundation_modulus);
    } else {
        study.lambda.missing = Some("the outline is round: no fold stores energy".into());
    }
    let Some(skirt) = &run.skirt else {
        study.prediction_missing = Some("the cut is not known".into());
        return study;
    };
    let theory = simulate::Options { gravity: campaign.gravity, ..simulate::Options::default() };
    match simulate::predict(skirt, &run.fabric, &theory) {
        Err(reason) => study.prediction_missing = Some(reason.to_string()),
        Ok(chosen) => {
            // At the fold count that was measured: cloth is metastable, and a hem of six folds is best compared with six.
            let at_fitted = fitted.folds.and_then(|m| {
                let same = simulate::Options { folds: simulate::Folds::Exactly(m), ..theory };
                if chosen.folds == m { Some(chosen.clone()) } else { simulate::predict(skirt, &run.fabric, &same).ok() }
            });
            study.comparison = at_fitted.as_ref().filter(|p| Some(p.folds) == fitted.folds).map(|p| compare(profile, fitted, p, &chosen));
            study.prediction = Some(chosen);
            study.prediction_at_fitted_folds = at_fitted;
        }
    }
    study
}

/// (A − πR_t²)/(π(R_n² − R_t²)) of the measured outline (ISO 9073-9).
fn drape_coefficient(tester: &Skirt, outline: &[Point]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    let area = 0.5 * outline.iter().zip(next).map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>();
    let disc = |radius: f64| std::f64::consts::PI * radius * radius;
    let (support, specimen) = (disc(tester.waist_radius().0), disc(tester.hem_radius().0));
    (area - support) / (specimen - support)
}

fn regress(campaign: &Campaign, runs: &[RunStudy], notes: &mut Vec<String>) -> Vec<Regression> {
    let weighed = response::weighed(campaign);
    let axes = campaign.design.factors.iter().map(|f| Axis { name: f.name.clone(), low: f.low, high: f.high }).collect();
    let levels = runs.iter().map(|r| r.run.levels.clone()).collect();
    let design = if campaign.design.factors.is_empty() {
        Err("the campaign names no factors".to_string())
    } else {
        FactorialDesign::new(axes, levels).map_err(|e| e.to_string())
    };
    if let Err(reason) = &design {
        notes.push(format!("no regression: {reason}"));
    }
    let options = box_wilson::Options { alpha: campaign.alpha };
    let mut studies: Vec<Regression> = campaign
        .responses
        .iter()
        .filter_map(|name| response::named(name, weighed))
        .map(|response| {
            let values: Vec<Option<f64>> = runs.iter().map(|run| response::value(&response, run)).collect();
            let analysis = match &design {
                Ok(design) if values.iter().any(Option::is_some) => {
                    box_wilson::analyse(design, &values, &options).map_err(|e| e.to_string())
                }
                Ok(_) => Err("no run has this number".into()),
                Err(reason) => Err(reason.clone()),
            };
            Regression { response: response.column.to_string(), values, analysis }
        })
        .collect();
    let mut analyses: Vec<Analysis> = studies.iter().filter_map(|s| s.analysis.as_ref().ok().cloned()).collect();
    family::adjust(&mut analyses);
    let mut adjusted = analyses.into_iter();
    for study in &mut studies {
        if let Ok(analysis) = &mut study.analysis {
            *analysis = adjusted.next().expect("one adjusted analysis for each");
        }
    }
    studies
}
