//! Profiles → fits → responses → regression: one campaign, all of it.

use rayon::prelude::*;

use super::as_measured::as_measured;
use super::comparison::{Comparison, compare};
use super::desirable::{Desirable, desirable};
use super::fidelities::{self, FidelityRun};
use super::further::{self, Further, Series};
use super::identify::{Identified, identify_all};
use super::intervals::{self, intervals};
use super::irregular::{Irregular, irregular};
use super::response;
use crate::error::Error;
use crate::experiment::campaign::Response;
use crate::experiment::profile::signed_area;
use crate::experiment::{Apparatus, Campaign, DrapeProfile, Point, Quarantined, Run, Scene, Skirt, Source};
use crate::fit::lambda::{Lambda, lambda};
use crate::fit::{self, HemFit};
use crate::model::hem::Placement;
use crate::simulate::{self, Prediction};
use crate::statistics::box_wilson::{self, Analysis};
use crate::statistics::factorial::{Axis, FactorialDesign};
use crate::statistics::family;
use crate::statistics::permutation::{self, PermutationTest};
use crate::units::MILLIMETRE;

/// Everything known about one run.
#[derive(Debug, Clone)]
pub struct RunStudy {
    pub run: Run,
    /// `None`: the profile was set aside; the reason is in the quarantine.
    pub profile: Option<DrapeProfile>,
    /// The fit, or why there is none.
    pub fit: Result<HemFit, String>,
    /// Other curves through the same outline, and its folds one by one; `None` without a fit.
    pub irregular: Option<Irregular>,
    pub lambda: Lambda,
    /// Drape coefficient of the outline as a share, 0…1 for a hem between support and specimen edge; only on a drape tester.
    pub drape_coefficient: Option<f64>,
    /// Share of the outline's points that lie on the support disc's edge: there the disc is seen, and the cloth hangs below it, inside. Only on
    /// a drape tester.
    pub on_support: Option<f64>,
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
    /// What goes beyond it, or why there is nothing.
    pub further: Result<Further, String>,
}

/// One campaign, analysed.
#[derive(Debug, Clone)]
pub struct CampaignStudy {
    pub campaign: Campaign,
    /// In run order.
    pub runs: Vec<RunStudy>,
    /// In the order that the campaign asks for.
    pub regressions: Vec<Regression>,
    /// The setting that meets the campaign's wishes best, or why there is none; `None` where it wishes nothing.
    pub desirable: Option<Result<Desirable, String>>,
    /// Every fidelity of the theory against every run of known cloth and cut, in run order.
    pub fidelities: Vec<FidelityRun>,
    /// The cloth of every run of known weight and cut, identified from its hem; in run order.
    pub identified: Vec<Identified>,
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
    let design = factorial(&campaign);
    if let Err(reason) = &design {
        notes.push(format!("no regression: {reason}"));
    }
    let regressions = regress(&campaign, &design, &runs);
    let desirable = desirable(&campaign, &regressions);
    let fidelities = fidelities::against(&runs, campaign.gravity);
    let identified = identify_all(&campaign, &runs);
    CampaignStudy { campaign, runs, regressions, desirable, fidelities, identified, quarantine, sources, notes }
}

impl RunStudy {
    /// A run of which nothing is known yet but its profile.
    pub(super) fn of(run: Run, profile: Option<DrapeProfile>) -> Self {
        RunStudy {
            run,
            profile,
            fit: Err("the profile was set aside; the quarantine says why".into()),
            irregular: None,
            lambda: Lambda::default(),
            drape_coefficient: None,
            on_support: None,
            prediction: None,
            prediction_at_fitted_folds: None,
            prediction_missing: None,
            comparison: None,
        }
    }
}

/// How the campaign wants a run of its to be fitted.
pub(super) fn fit_options(campaign: &Campaign, run: &Run) -> fit::Options {
    // A skirt's hem hangs nearly level, so its plan view is as long as the cloth was cut; the edge on a drape tester rises and falls.
    let cut = run.skirt.as_ref().filter(|_| campaign.apparatus == Apparatus::Skirt);
    let cut_length = cut.map(|skirt| std::f64::consts::TAU * skirt.hem_radius().0);
    fit::Options {
        folds: campaign.folds,
        length: campaign.hem_length,
        cut_length,
        bias_correction: campaign.bias_correction,
        ..fit::Options::default()
    }
}

/// Fits the profile and takes everything from the fit that needs no theory.
pub(super) fn measure(campaign: &Campaign, study: &mut RunStudy, options: &fit::Options) {
    let (Some(profile), run) = (&study.profile, &study.run) else { return };
    study.fit = fit::fit(profile, options).map_err(|e| e.to_string());
    if let Ok(fitted) = &mut study.fit {
        fitted.intervals = Some(intervals(profile, fitted, &intervals::Options::default()));
    }
    study.drape_coefficient =
        run.skirt.as_ref().filter(|_| campaign.apparatus == Apparatus::Drapemeter).map(|s| drape_coefficient(s, profile.points()));
    let Ok(fitted) = &study.fit else { return };
    let tester = run.skirt.as_ref().filter(|_| campaign.apparatus == Apparatus::Drapemeter);
    study.on_support = tester.map(|tester| on_support(tester, profile.points(), &fitted.placement));
    if fitted.folds.is_some() {
        study.lambda =
            lambda(&fitted.hem, fitted.covariance.as_ref(), run.skirt.as_ref(), &run.fabric, campaign.gravity, campaign.foundation_modulus);
    } else {
        study.lambda.missing = Some("the outline is round: no fold stores energy".into());
    }
}

fn one_run(campaign: &Campaign, run: &Run, profile: Option<DrapeProfile>) -> RunStudy {
    let mut study = RunStudy::of(run.clone(), profile);
    measure(campaign, &mut study, &fit_options(campaign, run));
    let (Some(profile), Ok(fitted)) = (&study.profile, &study.fit) else { return study };
    study.irregular = Some(irregular(profile, fitted));
    predict(campaign, &mut study);
    study
}

/// Predicts the hem of a fitted run where its cloth and cut are known, and compares.
pub(super) fn predict(campaign: &Campaign, study: &mut RunStudy) {
    let (Some(profile), Ok(fitted), run) = (&study.profile, &study.fit, &study.run) else { return };
    let Some(skirt) = &run.skirt else {
        study.prediction_missing = Some("the cut is not known".into());
        return;
    };
    let ask = |folds: Option<u32>| match &campaign.hanging {
        Some(hanging) => {
            let scene = hanging.scene(*skirt, run.fabric, campaign.apparatus, campaign.gravity);
            simulate::predict_scene(&Scene { folds, ..scene }, None)
        }
        None => {
            let folds = folds.map_or(simulate::Folds::Auto, simulate::Folds::Exactly);
            simulate::predict(skirt, &run.fabric, &simulate::Options { folds, gravity: campaign.gravity, ..simulate::Options::default() })
        }
    };
    match ask(None) {
        Err(reason) => study.prediction_missing = Some(reason.to_string()),
        Ok(chosen) => {
            // At the fold count that was measured: cloth is metastable, and a hem of six folds is best compared with six.
            let at_fitted = fitted.folds.and_then(|m| if chosen.folds == m { Some(chosen.clone()) } else { ask(Some(m)).ok() });
            study.comparison = at_fitted.as_ref().filter(|p| Some(p.folds) == fitted.folds).map(|p| compare(profile, fitted, p, &chosen));
            study.prediction = Some(chosen);
            study.prediction_at_fitted_folds = at_fitted;
        }
    }
}

/// (A − πR_t²)/(π(R_n² − R_t²)) of the measured outline (ISO 9073-9).
fn drape_coefficient(tester: &Skirt, outline: &[Point]) -> f64 {
    let disc = |radius: f64| std::f64::consts::PI * radius * radius;
    let (support, specimen) = (disc(tester.waist_radius().0), disc(tester.hem_radius().0));
    (signed_area(outline) - support) / (specimen - support)
}

/// Share of the outline's points that are no further from the centre than the support disc's edge and [`EDGE`].
fn on_support(tester: &Skirt, outline: &[Point], centre: &Placement) -> f64 {
    let edge = tester.waist_radius().0 + EDGE;
    let inside = outline.iter().filter(|p| (p.x - centre.x0).hypot(p.y - centre.y0) <= edge).count();
    inside as f64 / outline.len() as f64
}

/// A pixel or two of a photograph, and what the centre may be off: 2 mm.
const EDGE: f64 = 2.0 * MILLIMETRE;

pub(super) fn factorial(campaign: &Campaign) -> Result<FactorialDesign, String> {
    let design = &campaign.design;
    if design.factors.is_empty() {
        return Err("the campaign names no factors".into());
    }
    let axes = design.factors.iter().map(|f| Axis { name: f.name.clone(), low: f.low, high: f.high }).collect();
    let levels = design.runs.iter().map(|run| run.levels.clone()).collect();
    let blocks: Option<Vec<String>> = design.runs.iter().map(|run| run.block.clone()).collect();
    let factorial = FactorialDesign::new(axes, levels);
    let factorial = match blocks {
        Some(blocks) => factorial.and_then(|design| design.with_blocks(blocks)),
        None => factorial,
    };
    factorial.map_err(|e| e.to_string())
}

fn regress(campaign: &Campaign, design: &Result<FactorialDesign, String>, runs: &[RunStudy]) -> Vec<Regression> {
    let weighed = response::weighed(campaign);
    let options = box_wilson::Options { alpha: campaign.alpha };
    let predicted: Vec<Option<RunStudy>> = runs.par_iter().map(|run| as_measured(campaign, run)).collect();
    let responses: Vec<Response> = campaign.responses.iter().filter_map(|name| response::named(name, weighed)).collect();
    let series: Vec<Series> = responses.iter().map(|response| series(response, runs, &predicted)).collect();
    let permutation = match design {
        Ok(design) => {
            let measured: Vec<&[Option<f64>]> = series.iter().map(|series| series.measured.as_slice()).collect();
            permutation::tests_of_all(design, &measured, &permutation::Options::default())
        }
        Err(reason) => responses.iter().map(|_| Err(Error::Unanswerable(reason.clone()))).collect(),
    };
    let asked: Vec<_> = responses.iter().zip(series).zip(permutation).collect();
    let mut studies: Vec<Regression> = asked
        .into_par_iter()
        .map(|((response, series), permutation)| regression(response, design, series, permutation, &options))
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

fn series(response: &Response, runs: &[RunStudy], predicted: &[Option<RunStudy>]) -> Series {
    Series {
        standard_errors: runs.iter().map(|run| response::standard_error(response, run)).collect(),
        predicted: response::predicted(response, runs, predicted),
        measured: runs.iter().map(|run| response::value(response, run)).collect(),
    }
}

fn regression(
    response: &Response,
    design: &Result<FactorialDesign, String>,
    series: Series,
    permutation: Result<Vec<PermutationTest>, Error>,
    options: &box_wilson::Options,
) -> Regression {
    let analysis = match design {
        Ok(design) if series.measured.iter().any(Option::is_some) => {
            box_wilson::analyse(design, &series.measured, options).map_err(|e| e.to_string())
        }
        Ok(_) => Err("no run has this number".into()),
        Err(reason) => Err(reason.clone()),
    };
    let further = match (design, &analysis) {
        (Ok(design), Ok(analysis)) => {
            permutation.and_then(|permutation| further::further(design, &series, analysis, permutation, options)).map_err(|e| e.to_string())
        }
        (_, Err(reason)) | (Err(reason), _) => Err(reason.clone()),
    };
    Regression { response: response.column.to_string(), values: series.measured, analysis, further }
}
