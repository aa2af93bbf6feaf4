//! Cloth from its drape: the flexural rigidity of a hem whose weight and cut are known, with its standard error.
//!
//! Every rigidity has its own hem of m folds in equilibrium, and so its own coefficients a_k(B/(ρ_A g)) of the tangent angle. Those of the profile are fitted with
//! their covariance C; B is where `(â − a)ᵀ C⁻¹ (â − a)` is least. That is generalized least squares of the conditions of equilibrium ∇U = 0 with
//! errors in the a_k, iterated until the hem about which they are expanded is the one that is reported. Source: docs/identify.md.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::Serialize;

use super::campaign::{RunStudy, fit_options};
use super::irregular::irregular;
use crate::error::Error;
use crate::experiment::campaign::Folds;
use crate::experiment::{Apparatus, Campaign, DrapeProfile, Skirt};
use crate::fit::outcome::Estimate;
use crate::fit::tangent_family::TangentFit;
use crate::fit::{self};
use crate::model::tangent::{TangentHem, half_nodes};
use crate::simulate::equilibrium::{Energy, Equilibria, Equilibrium, flipped, stationary_ratio};
use crate::units::MILLIMETRE;

/// Which energy the cloth is identified through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Through {
    /// Straight generatrices.
    Ruled,
    /// Every ring inextensible: nearer to a real skirt.
    Graded,
}

impl Through {
    pub const ALL: [Through; 2] = [Through::Graded, Through::Ruled];

    pub fn name(self) -> &'static str {
        match self {
            Through::Ruled => "ruled",
            Through::Graded => "graded",
        }
    }
}

/// A slant of fewer gravity lengths than this bends as a whole: generatrices that hang are no theory of it.
const FEWEST_GRAVITY_LENGTHS: f64 = 10.0;
/// A rigidity whose logarithm is known no better than this is not determined: a factor of e either way.
const WIDEST: f64 = 1.0;
/// Flanks of a fold nearer than this touch, m: twice the thickness of usual cloth.
const TOUCHING: f64 = MILLIMETRE;
/// Harmonics that the equilibrium of the ruled shell has more of than are compared; eight hold its hem to 0.05 mm.
const RULED_HARMONICS: usize = 8;
/// Harmonics and modes of the graded shell: as `simulate::graded` has them.
const GRADED_SIZE: (usize, usize) = (3, 6);
/// Steps of Gauss and Newton; three to six are usual.
const STEPS: usize = 40;

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Identification {
    pub through: Through,
    pub folds: u32,
    /// Coefficients a_k that were compared.
    pub harmonics: usize,
    /// B, N·m.
    pub rigidity: Estimate,
    /// 95 % interval of B, N·m, by the normal distribution of its logarithm.
    pub interval: [f64; 2],
    /// Standard error of ln B: the relative error of B.
    pub relative_error: f64,
    /// The multiplier of the hem's length, N.
    pub lambda: Estimate,
    /// (â − a)ᵀ C⁻¹ (â − a) at the minimum, and its degrees of freedom.
    pub chi_square: f64,
    pub degrees_of_freedom: usize,
    /// Factor by which the standard errors were raised, because the theory's hem misses the a_k by more than their errors: √(χ²/dof), at least 1.
    pub inflation: f64,
    /// Root mean square distance of the theory's hem at this rigidity from the fitted one, m.
    pub misfit: f64,
    /// L over the gravity length (B/ρ_A g)^⅓.
    pub gravity_lengths: f64,
    /// Evaluations of the energy with its derivatives.
    pub evaluations: usize,
}

/// The rigidity of the cloth that hangs in this fitted hem; `weight` is ρ_A g, N/m².
///
/// # Errors
/// [`Error::Unanswerable`] where the theory does not apply (a drape tester, a slant of few gravity lengths, folds whose flanks touch) or where the hem does not
/// determine B; the reason is said. [`Error::Invalid`] for a weight that is not positive.
pub fn identify(skirt: &Skirt, weight: f64, hem: &TangentFit, through: Through) -> Result<Identification, Error> {
    if !(weight.is_finite() && 0.0 < weight) {
        return Err(Error::Invalid { quantity: "weight per area, N/m²", value: weight, allowed: "> 0" });
    }
    let refuse = |why: String| Err(Error::Unanswerable(why));
    if 1.0 - 1e-9 <= skirt.conicity() {
        return refuse(
            "a drape tester: its cloth is clamped flat and bends over the support, which no theory of hanging generatrices describes"
                .into(),
        );
    }
    let Some(covariance) = &hem.covariance else {
        let why = hem.undetermined.clone().unwrap_or_else(|| "its coefficients have no standard errors".into());
        return refuse(format!("the hem is not determined: {why}"));
    };
    let (a, covariance) = canonical(hem, covariance);
    if let Some(gap) = flank_gap(hem.folds, hem.radius.value, a.as_slice()).filter(|gap| *gap < TOUCHING) {
        return refuse(if gap <= 0.0 {
            "the flanks of the folds cross: they touch each other, which the energy knows nothing of".into()
        } else {
            format!(
                "the flanks of the folds are {:.1} mm apart: they touch each other, which the energy knows nothing of",
                gap / MILLIMETRE
            )
        });
    }
    let most = if through == Through::Graded { GRADED_SIZE.0 } else { usize::MAX };
    let compared = a.len().min(most);
    let (a, covariance) = (a.rows(0, compared).into_owned(), covariance.view((0, 0), (compared, compared)).into_owned());
    let Some(precision) = covariance.clone().cholesky().map(|c| c.inverse()) else {
        return refuse("the coefficients of the hem are not determined apart from each other".into());
    };
    let slant = skirt.slant_length().0;
    let energy = match through {
        Through::Ruled => Energy::Ruled { harmonics: RULED_HARMONICS.max(compared + 2) },
        Through::Graded => Energy::Graded { harmonics: GRADED_SIZE.0, modes: GRADED_SIZE.1 },
    };
    let start = stationary_ratio(skirt, hem.folds, &a, &covariance);
    let family = Equilibria::new(skirt, energy, hem.folds, start.unwrap_or((0.04 * slant).powi(3)));
    let Some(threshold) = family.threshold() else {
        return refuse(format!(
            "the round cone is stable against {} folds at any rigidity: this hem is no equilibrium of the theory",
            hem.folds
        ));
    };
    // A gravity length of a thousandth of the slant: threads, not cloth.
    let limpest = 3.0 * (1e-3 * slant).ln();
    let first = start.map_or(threshold - 2.0, f64::ln).clamp(limpest + 1.0, threshold - 0.5);
    let search = Search { family: &family, a: &a, precision: &precision, limpest, threshold };
    let (found, chi_square, evaluations) = match search.run(first) {
        Ok(found) => found,
        Err(why) => return refuse(why),
    };
    let ratio = found.log_ratio.exp();
    let gravity_lengths = slant / ratio.cbrt();
    if gravity_lengths < FEWEST_GRAVITY_LENGTHS {
        return refuse(format!(
            "the slant would be only {gravity_lengths:.1} gravity lengths (B/ρ_A g)^⅓ of such cloth: it bends as a whole, and the theory is for {FEWEST_GRAVITY_LENGTHS} and more"
        ));
    }
    let by = found.derivatives.rows(0, compared).into_owned();
    let information = by.dot(&(&precision * &by));
    let degrees_of_freedom = compared - 1;
    let inflation = if degrees_of_freedom == 0 { 1.0 } else { (chi_square / degrees_of_freedom as f64).sqrt().max(1.0) };
    let relative_error = inflation / information.sqrt();
    let rigidity = ratio * weight;
    if relative_error.is_nan() || WIDEST <= relative_error {
        return refuse(format!(
            "B is not determined: {rigidity:.1e} N·m, but a factor of {:.1} either way fits these folds as well",
            relative_error.min(99.0).exp()
        ));
    }
    // λ moves along the equilibria; a hundredth of a factor of e is a small step of a smooth curve.
    let Some(multiplier) = family.multiplier(&found) else { return refuse("the length of the hem has no multiplier".into()) };
    let near = family.at(found.log_ratio + 0.01, Some(&found)).and_then(|near| family.multiplier(&near));
    let lambda_slope = near.map(|near| weight * (near - multiplier) / 0.01);
    Ok(Identification {
        through,
        folds: hem.folds,
        harmonics: compared,
        rigidity: Estimate { value: rigidity, standard_error: Some(rigidity * relative_error) },
        interval: [-1.959_963_985, 1.959_963_985].map(|z| rigidity * (z * relative_error).exp()),
        relative_error,
        lambda: Estimate { value: weight * multiplier, standard_error: lambda_slope.map(|slope| slope.abs() * relative_error) },
        chi_square,
        degrees_of_freedom,
        inflation,
        misfit: misfit(skirt, hem, &found.coefficients),
        gravity_lengths,
        evaluations,
    })
}

/// The same from a measured outline: the paper's curve first, then equal folds of any shape, then their cloth.
///
/// # Errors
/// As [`identify`]; [`Error::Unanswerable`] also where the outline cannot be fitted or shows no folds.
pub fn identify_profile(
    profile: &DrapeProfile,
    skirt: &Skirt,
    weight: f64,
    folds: Folds,
    through: Through,
) -> Result<Identification, Error> {
    identify(skirt, weight, &equal_folds(profile, skirt, folds)?, through)
}

/// Equal folds fitted to an outline whose cut is known.
///
/// # Errors
/// [`Error::Unanswerable`] where the outline cannot be fitted or shows no folds.
pub fn equal_folds(profile: &DrapeProfile, skirt: &Skirt, folds: Folds) -> Result<TangentFit, Error> {
    let cut_length = Some(TAU * skirt.hem_radius().0);
    let fitted = fit::fit(profile, &fit::Options { folds, cut_length, ..fit::Options::default() })?;
    if fitted.folds.is_none() {
        return Err(Error::Unanswerable("the outline is round: without folds it does not tell how stiff the cloth is".into()));
    }
    irregular(profile, &fitted).tangent.map(|(_, tangent)| tangent).map_err(Error::Unanswerable)
}

/// Gauss and Newton in ln B/(ρ_A g), each hem from its neighbour's.
struct Search<'a> {
    family: &'a Equilibria<'a>,
    a: &'a DVector<f64>,
    precision: &'a DMatrix<f64>,
    limpest: f64,
    threshold: f64,
}

impl Search<'_> {
    /// χ² and the step to its minimum as it looks from here.
    fn look(&self, hem: &Equilibrium) -> (f64, f64) {
        let n = self.a.len();
        let (left, by) = (self.a - hem.coefficients.rows(0, n), hem.derivatives.rows(0, n).into_owned());
        let weighed = self.precision * &left;
        (left.dot(&weighed), by.dot(&weighed) / by.dot(&(self.precision * &by)))
    }

    /// The hem of least χ², χ², and evaluations; or why there is none.
    fn run(&self, first: f64) -> Result<(Equilibrium, f64, usize), String> {
        let no_hem = || "the theory has no hem of this fold count near the measured one".to_string();
        // From the first place where the folds exist: a start near their end may be beyond it.
        let mut here = (0..12).find_map(|i| self.family.at(first - 0.5 * f64::from(i), None)).ok_or_else(no_hem)?;
        let mut evaluations = here.evaluations;
        let (mut chi, mut step) = self.look(&here);
        for _ in 0..STEPS {
            // A factor of two at most: the next hem is found from this one.
            let mut length = step.clamp(-0.7, 0.7);
            if length.abs() < 1e-7 {
                return Ok((here, chi, evaluations));
            }
            let mut moved = false;
            for _ in 0..12 {
                let place = here.log_ratio + length;
                if place < self.limpest {
                    return Err("B is not determined: the folds are deeper or finer than those of the limpest cloth in this theory".into());
                }
                if let Some(next) = self.family.at(place, Some(&here)) {
                    evaluations += next.evaluations;
                    let (lower, further) = self.look(&next);
                    if lower <= chi * (1.0 + 1e-12) {
                        // Where nothing is gained any more the minimum is reached.
                        let settled = chi - lower <= 1e-10 * chi;
                        (here, chi, step) = (next, lower, further);
                        if settled {
                            return Ok((here, chi, evaluations));
                        }
                        moved = true;
                        break;
                    }
                }
                length *= 0.5;
                if length.abs() < 1e-7 {
                    break;
                }
            }
            if !moved {
                // Downhill is where the folds end, or rounding is reached.
                return if step.abs() < 1e-3 {
                    Ok((here, chi, evaluations))
                } else if 0.0 < step && self.threshold - 0.3 < here.log_ratio {
                    Err("B is not determined: the folds are shallower than those of the stiffest cloth that folds so in this theory".into())
                } else {
                    Err("B is not determined: the branch of this fold count ends before it meets the measured hem".into())
                };
            }
        }
        Err("B is not determined: the search does not come to rest".into())
    }
}

/// a_1 > 0, with the covariance of the same signs.
fn canonical(hem: &TangentFit, covariance: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let a = DVector::from_iterator(hem.coefficients.len(), hem.coefficients.iter().map(|e| e.value));
    if 0.0 < a[0] {
        return (a, covariance.clone());
    }
    let sign = flipped(&DVector::from_element(a.len(), 1.0));
    let turned = DMatrix::from_fn(a.len(), a.len(), |i, j| sign[i] * sign[j] * covariance[(i, j)]);
    (flipped(&a), turned)
}

/// How near the flanks of one fold come to each other beside its own end, m; `None` where they only spread.
fn flank_gap(folds: u32, radius: f64, a: &[f64]) -> Option<f64> {
    let curve = TangentHem::new(folds, radius, a, 2 * half_nodes(a.len()));
    let m = f64::from(folds);
    const NODES: usize = 400;
    // Across the axis of a crest (σ = 0) and of a valley (σ = π/m), from that axis outwards.
    let across = |axis: f64, way: f64| {
        let (sin, cos) = axis.sin_cos();
        let sigmas: Vec<f64> = (0..=NODES).map(|i| axis + way * PI / m * i as f64 / NODES as f64).collect();
        curve.positions(&sigmas).into_iter().map(|[x, y]| way * (y * cos - x * sin)).collect::<Vec<f64>>()
    };
    let waists = [across(0.0, 1.0), across(PI / m, 1.0)];
    // A waist of the fold: a minimum between its end and the next axis.
    let minima = waists.iter().flat_map(|d| d.windows(3).filter(|w| w[1] < w[0] && w[1] <= w[2]).map(|w| 2.0 * w[1]));
    minima.min_by(f64::total_cmp)
}

/// Root mean square distance between the same points of cloth of the theory's hem and the fitted one, m.
fn misfit(skirt: &Skirt, hem: &TangentFit, theory: &DVector<f64>) -> f64 {
    const POINTS: usize = 720;
    let values: Vec<f64> = hem.coefficients.iter().map(|e| e.value).collect();
    let own = DVector::from_vec(values);
    let own = if own[0] < 0.0 { flipped(&own) } else { own };
    let fitted = TangentHem::new(hem.folds, hem.radius.value, own.as_slice(), 2 * half_nodes(own.len()));
    let theory = TangentHem::new(hem.folds, skirt.hem_radius().0, theory.as_slice(), 2 * half_nodes(theory.len()));
    let squares = fitted.outline(POINTS).iter().zip(theory.outline(POINTS)).map(|(p, q)| p.distance(q).powi(2)).sum::<f64>();
    (squares / POINTS as f64).sqrt()
}

/// One run of a campaign, identified through one energy.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    pub run: String,
    /// B that was measured on its cloth, N·m.
    pub known: Option<f64>,
    pub through: Through,
    /// What was found, or why nothing.
    pub found: Result<Identification, String>,
}

/// How estimated rigidities lie about known ones.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Agreement {
    pub through: Through,
    /// Runs with known cut and weight, and those of them with an estimate and a known rigidity.
    pub runs: usize,
    pub compared: usize,
    /// Geometric mean of estimated over known.
    pub factor: Option<f64>,
    /// Scatter about it, as a factor: exp of the standard deviation of the logarithm.
    pub scatter: Option<f64>,
    /// Median of the relative standard errors that the estimates claim.
    pub claimed: Option<f64>,
}

/// Every run of a skirt whose cut and weight are known, through both energies, in run order; those whose theory does not apply say so.
pub fn identify_all(campaign: &Campaign, runs: &[RunStudy]) -> Vec<Identified> {
    if campaign.apparatus != Apparatus::Skirt {
        return Vec::new();
    }
    let pairs: Vec<(&RunStudy, Through)> = runs.iter().flat_map(|run| Through::ALL.map(|through| (run, through))).collect();
    pairs.par_iter().filter_map(|(run, through)| of_run(campaign, run, *through)).collect()
}

/// The same without the rest of a campaign's analysis: fits what is needed and identifies; `profiles` are one per run of the design.
pub fn campaign(campaign: &Campaign, profiles: &[Option<DrapeProfile>]) -> Vec<Identified> {
    let studies: Vec<RunStudy> = campaign
        .design
        .runs
        .par_iter()
        .zip(profiles)
        .map(|(run, profile)| {
            let mut study = RunStudy::of(run.clone(), profile.clone());
            if let Some(profile) = &study.profile {
                study.fit = fit::fit(profile, &fit_options(campaign, run)).map_err(|e| e.to_string());
                study.irregular = study.fit.as_ref().ok().map(|fitted| irregular(profile, fitted));
            }
            study
        })
        .collect();
    identify_all(campaign, &studies)
}

fn of_run(campaign: &Campaign, study: &RunStudy, through: Through) -> Option<Identified> {
    let (skirt, density) = (study.run.skirt.as_ref()?, study.run.fabric.areal_density?);
    let found = match (&study.fit, &study.irregular) {
        (Err(reason), _) => Err(reason.clone()),
        (Ok(fit), _) if fit.folds.is_none() => Err("the outline is round: without folds it does not tell how stiff the cloth is".into()),
        (_, Some(irregular)) => match &irregular.tangent {
            Ok((_, tangent)) => identify(skirt, density.0 * campaign.gravity, tangent, through).map_err(|e| e.to_string()),
            Err(reason) => Err(reason.clone()),
        },
        (_, None) => Err("no curve of equal folds was fitted".into()),
    };
    Some(Identified { run: study.run.id.clone(), known: study.run.fabric.flexural_rigidity.map(|b| b.0), through, found })
}

/// Bias and scatter of the estimates about the known rigidities, for each energy.
pub fn agreement(rows: &[Identified]) -> Vec<Agreement> {
    Through::ALL
        .into_iter()
        .map(|through| {
            let own: Vec<&Identified> = rows.iter().filter(|r| r.through == through).collect();
            let logs: Vec<f64> = own.iter().filter_map(|r| Some((r.found.as_ref().ok()?.rigidity.value / r.known?).ln())).collect();
            let n = logs.len() as f64;
            let mean = logs.iter().sum::<f64>() / n;
            let deviation = (logs.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
            let mut claimed: Vec<f64> = own.iter().filter_map(|r| r.found.as_ref().ok().map(|f| f.relative_error)).collect();
            claimed.sort_by(f64::total_cmp);
            Agreement {
                through,
                runs: own.len(),
                compared: logs.len(),
                factor: (!logs.is_empty()).then(|| mean.exp()),
                scatter: (1 < logs.len()).then(|| deviation.exp()),
                claimed: (!claimed.is_empty()).then(|| claimed[claimed.len() / 2]),
            }
        })
        .collect()
}
