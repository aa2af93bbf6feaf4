//! What the figures of single runs and cells are drawn from: hems carried through height, aligned replicates, multipliers.

use super::figure::{lambda, paper_cone, paper_curve, paper_element, paper_projection, paper_shell, replicates, surface};
use super::gallery::{cell_name, cells};
use super::number::{fixed, plain};
use crate::error::Error;
use crate::experiment::{Point, Skirt};
use crate::fit::{Estimate, HemFit};
use crate::model::field::Field;
use crate::model::skirt::Cone;
use crate::model::surface::{LinearSurface, RuledForm};
use crate::study::campaign::{CampaignStudy, RunStudy};
use crate::study::paper::THICKNESS;
use crate::study::surface as fields;
use crate::units::MILLIMETRE;

/// Rings of a coloured surface, and points in each.
const RINGS: usize = 16;
const AROUND: usize = 112;
/// Points of a drawn curve.
const NODES: usize = 360;
/// Generatrices of the space form: enough for a smooth line.
const GENERATRICES: usize = 400;

/// The cut of a run.
fn cut(run: &RunStudy) -> Result<&Skirt, String> {
    run.run.skirt.as_ref().ok_or_else(|| format!("the cut of run {} is not known", run.run.id))
}

/// The cut as a cone.
pub fn cone(run: &RunStudy) -> Result<Cone, String> {
    cut(run).map(Cone::of)
}

/// Cut and fit of a run whose skirt hangs; a drape tester's disc has no height over which its hem could be carried.
fn hanging(run: &RunStudy) -> Result<(&Skirt, &HemFit), String> {
    let skirt = cut(run)?;
    let fit = run.fit.as_ref().map_err(|why| format!("run {} has no fit: {why}", run.run.id))?;
    if 1.0 - 1e-9 <= skirt.conicity() {
        return Err("the disc of a drape tester lies flat before it drapes: there is no cone from waist to hem".into());
    }
    Ok((skirt, fit))
}

fn unanswerable<T>(found: Result<T, String>) -> Result<T, Error> {
    found.map_err(Error::Unanswerable)
}

/// The surface (18) with the fitted hem, coloured by flexure and by stress intensity, or by the curvature of its rings where the cloth is not known.
/// `gravity` in m/s².
pub fn skirt(run: &RunStudy, gravity: f64) -> Result<surface::Scene, String> {
    let (skirt, fit) = hanging(run)?;
    // Heights are counted from the level hem.
    let height = Cone::of(skirt).height;
    let sheet = fields::assumed_sheet(&run.run.fabric, gravity);
    let options = fields::Options { rows: RINGS + 1, columns: AROUND };
    let drawn = fields::of_fit(skirt, fit, fields::Form::Linear, &sheet, &options).map_err(|e| e.to_string())?;
    let rows = |values: &[f64], unit: f64| -> Vec<Vec<f64>> {
        values.chunks(drawn.columns).map(|row| row.iter().map(|v| v / unit).collect()).collect()
    };
    let folds = fit.folds.map_or_else(|| "no folds".to_string(), |m| format!("m = {m}"));
    let mut caption = format!("n = {} · {folds} · the paper’s surface (18) from the round waist to the fitted hem", fit.distances.len());
    let flexure = drawn.values(Field::Flexure)?;
    let second = match (drawn.values(Field::StressIntensity), drawn.values(Field::RingCurvature)) {
        (Ok(stress), _) => {
            caption.push_str(&format!(
                " · stress as if the cloth were {} mm thick with ν = {}",
                plain(THICKNESS / MILLIMETRE),
                plain(fields::ASSUMED_POISSON)
            ));
            surface::Field { name: "stress intensity".into(), unit: "Pa".into(), values: rows(stress, 1.0) }
        }
        (Err(_), curvature) => surface::Field { name: "curvature of the rings".into(), unit: "1/m".into(), values: rows(curvature?, 1.0) },
    };
    Ok(surface::Scene {
        run: run.run.id.clone(),
        caption,
        rings: drawn.positions.chunks(drawn.columns).map(|ring| ring.iter().map(|[x, y, z]| [*x, *y, z + height]).collect()).collect(),
        fields: vec![surface::Field { name: "flexure r − R".into(), unit: "mm".into(), values: rows(flexure, MILLIMETRE) }, second],
    })
}

/// The paper's Figure 1 of a run's cut.
pub fn figure_one(run: &RunStudy) -> Result<String, Error> {
    let cone = unanswerable(cone(run))?;
    if cone.height <= 0.0 {
        return Err(Error::Unanswerable("the disc of a drape tester has no height: there is no cone to draw".into()));
    }
    paper_cone::draw(&format!("Run {}: the truncated cone", run.run.id), &cone)
}

/// Figure 2 of its fitted hem.
pub fn figure_two(run: &RunStudy) -> Result<String, Error> {
    let (skirt, fit) = unanswerable(cut_and_fit(run))?;
    paper_projection::draw(&format!("Run {}: plan view of the fitted hem", run.run.id), "fitted", skirt, &fit.hem)
}

/// Figure 3 of its fitted hem.
pub fn figure_three(run: &RunStudy) -> Result<String, Error> {
    let (skirt, fit) = unanswerable(hanging(run))?;
    let form = RuledForm::new(skirt, &fit.hem, GENERATRICES);
    let form =
        form.ok_or_else(|| Error::Unanswerable(format!("the fitted hem of run {} lies further out than its slant reaches", run.run.id)))?;
    let folds = fit.folds.unwrap_or(0);
    paper_element::draw(&format!("Run {}: the surface element at the fitted hem", run.run.id), &form, skirt.slant_length().0, folds)
}

/// Figure 4 of its fitted hem.
pub fn figure_four(run: &RunStudy) -> Result<String, Error> {
    let (skirt, fit) = unanswerable(cut_and_fit(run))?;
    let origin = format!("fitted, rms {} mm", fixed(fit.rms / MILLIMETRE, 2));
    paper_curve::draw(&format!("Run {}: the fitted middle curve", run.run.id), &origin, skirt, &fit.hem)
}

/// Figure 5 of its fitted hem.
pub fn figure_five(run: &RunStudy) -> Result<String, Error> {
    let (skirt, fit) = unanswerable(hanging(run))?;
    paper_shell::draw(&format!("Run {}: the one-layer shell by equation (18)", run.run.id), &LinearSurface::new(skirt, fit.hem))
}

fn cut_and_fit(run: &RunStudy) -> Result<(&Skirt, &HemFit), String> {
    Ok((cut(run)?, run.fit.as_ref().map_err(|why| format!("run {} has no fit: {why}", run.run.id))?))
}

/// Every cell in standard order with its usable hems, each centred and turned back by its phase.
pub fn cells_aligned(study: &CampaignStudy) -> Vec<replicates::Cell> {
    let factors = &study.campaign.design.factors;
    let cell = |(levels, runs): (&[f64], Vec<&RunStudy>)| replicates::Cell {
        name: cell_name(factors, levels),
        replicates: runs.into_iter().filter_map(replicate).collect(),
    };
    cells(&study.runs).into_iter().map(cell).collect()
}

fn replicate(run: &RunStudy) -> Option<replicates::Replicate> {
    let measured = run.profile.as_ref()?.points();
    let fit = run.fit.as_ref().ok()?;
    let (centre, phase) = (Point::new(fit.placement.x0, fit.placement.y0), if fit.folds.is_some() { fit.placement.phase } else { 0.0 });
    Some(replicates::Replicate {
        run: run.run.id.clone(),
        measured: replicates::aligned(measured, centre, phase),
        fitted: replicates::aligned(&fit.outline(NODES), centre, phase),
        folds: fit.folds,
        rms: fit.rms,
    })
}

/// λ of every fitted run, cell by cell, with its name and unit: per weight of cloth where no cloth was weighed. Empty where no run has one.
pub fn multipliers(study: &CampaignStudy) -> (Vec<lambda::Run>, &'static str, &'static str) {
    let weighed = study.runs.iter().any(|run| run.lambda.first_integral.is_some() || run.lambda.ritz.is_some());
    let way = |(estimate, measure): (Estimate, f64), holds: fn(f64) -> lambda::Holds| lambda::Way {
        value: estimate.value,
        standard_error: estimate.standard_error,
        measure,
        holds: holds(measure),
    };
    let mut runs = vec![];
    for (cell, (_, members)) in cells(&study.runs).into_iter().enumerate() {
        for run in members.into_iter().filter(|run| run.fit.is_ok()) {
            let l = &run.lambda;
            let (first, ritz) = if weighed { (l.first_integral, l.ritz) } else { (l.over_weight, l.over_weight_ritz) };
            runs.push(lambda::Run {
                run: run.run.id.clone(),
                cell,
                first_integral: first.map(|found| way(found, lambda::Holds::by_determination)),
                ritz: ritz.map(|found| way(found, lambda::Holds::by_angle)),
            });
        }
    }
    if runs.iter().all(|run| run.first_integral.is_none() && run.ritz.is_none()) {
        runs.clear();
    }
    let (name, unit) = if weighed { ("λ", "N/m²") } else { ("λ/(ρg)", "") };
    (runs, name, unit)
}
