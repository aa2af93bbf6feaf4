//! Which figures a campaign gets, and from what: everything that the document shows and the folder of pictures holds.

use std::collections::BTreeMap;

use super::document::irregular::{most_reshaped, most_uneven};
use super::figure::{
    agreement, cube, distance, fidelities, folds, gap, half_normal, hem, interactions, main_effects, multiples, pareto, residuals,
    rigidity, symbols, uneven,
};
use super::number;
use super::words::{self, Response};
use crate::error::Error;
use crate::experiment::Factor;
use crate::statistics::box_wilson::Analysis;
use crate::statistics::distribution;
use crate::study::campaign::{CampaignStudy, RunStudy};
use crate::study::fidelities::{FIDELITIES, FidelityRun};
use crate::study::identify::{Identified, Through};
use crate::study::overview::spread;
use crate::units::{MICRONEWTON_METRE, MILLIMETRE, PERCENT};

/// SVG by file stem, in a fixed order.
pub type Gallery = BTreeMap<String, String>;

/// Draws all figures of a campaign.
///
/// # Errors
/// [`Error::Output`] naming the figure that could not be drawn.
pub fn draw(study: &CampaignStudy) -> Result<Gallery, Error> {
    let mut gallery = Gallery::new();
    gallery.insert("symbols".into(), symbols::draw()?);
    for (i, page) in multiples::draw(&rows(study))?.into_iter().enumerate() {
        gallery.insert(format!("all_runs_{:02}", i + 1), page);
    }
    for run in &study.runs {
        let id = words::file_stem(&run.run.id);
        if let Some(view) = hem::View::of(run) {
            gallery.insert(format!("hem_{id}"), hem::draw(&view)?);
        }
        if let (Some(profile), Ok(fit)) = (&run.profile, &run.fit) {
            gallery.insert(format!("distance_{id}"), distance::draw(&run.run.id, profile.points(), &fit.distances, fit.rms)?);
        }
    }
    for regression in &study.regressions {
        if let Ok(analysis) = &regression.analysis {
            let stem = regression_stem(&regression.response);
            let said = words::response(&regression.response);
            draw_response(&mut gallery, &stem, &said, study, analysis)?;
        }
    }
    draw_folds(&mut gallery, study)?;
    draw_theory(&mut gallery, study)?;
    draw_fidelities(&mut gallery, study)?;
    draw_rigidity(&mut gallery, study)?;
    Ok(gallery)
}

/// The common beginning of the names of a response's figures.
pub fn regression_stem(response: &str) -> String {
    format!("regression_{}", words::file_stem(response))
}

fn draw_response(gallery: &mut Gallery, stem: &str, said: &Response, study: &CampaignStudy, analysis: &Analysis) -> Result<(), Error> {
    let factors = &study.campaign.design.factors;
    let n = analysis.used_runs.len();
    let (label, unit) = (said.label.as_str(), said.unit.as_str());
    let coefficients = &analysis.coefficients;
    if let Some(critical) = analysis.t_critical {
        gallery.insert(format!("{stem}_pareto"), pareto::draw(label, n, coefficients, critical, study.campaign.alpha)?);
    } else {
        let margin = analysis.lenth.map(|l| l.margin);
        gallery.insert(format!("{stem}_half_normal"), half_normal::draw(label, unit, n, &scores(analysis), margin)?);
    }
    gallery.insert(format!("{stem}_main_effects"), main_effects::draw(label, unit, n, factors, coefficients)?);
    if 1 < factors.len() {
        gallery.insert(format!("{stem}_interactions"), interactions::draw(label, unit, n, factors, coefficients)?);
    }
    if let Some(svg) = cube::draw(label, unit, n, factors, coefficients)? {
        gallery.insert(format!("{stem}_cube"), svg);
    }
    gallery.insert(format!("{stem}_residuals"), residuals::draw(label, unit, &observations(study, analysis))?);
    Ok(())
}

/// Half-normal scores of all coefficients but the mean: quantile of (rank − ½)/k of |Z|.
fn scores(analysis: &Analysis) -> Vec<half_normal::Score> {
    let mut ranked: Vec<(&str, f64)> =
        analysis.coefficients.iter().filter(|c| c.term != "1").map(|c| (c.term.as_str(), c.estimate.abs())).collect();
    ranked.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(b.0)));
    let k = ranked.len() as f64;
    let score = |(i, (term, magnitude)): (usize, &(&str, f64))| half_normal::Score {
        term: term.to_string(),
        magnitude: *magnitude,
        quantile: distribution::normal_critical(0.5 - 0.5 * (i as f64 + 0.5) / k),
    };
    ranked.iter().enumerate().map(score).collect()
}

/// Residuals of the reduced model in run order, with Blom's normal scores (rank − 3/8)/(n + 1/4).
fn observations(study: &CampaignStudy, analysis: &Analysis) -> Vec<residuals::Residual> {
    let observed: Vec<f64> = analysis.full.fitted.iter().zip(&analysis.full.residuals).map(|(f, r)| f + r).collect();
    // A model of no significant term predicts 0.
    let fitted = analysis.reduced.model.as_ref().map_or_else(|| vec![0.0; observed.len()], |model| model.fitted.clone());
    let residual: Vec<f64> = observed.iter().zip(&fitted).map(|(y, f)| y - f).collect();
    let mut order: Vec<usize> = (0..residual.len()).collect();
    order.sort_by(|&a, &b| residual[a].total_cmp(&residual[b]).then(a.cmp(&b)));
    let n = residual.len() as f64;
    let mut quantile = vec![0.0; residual.len()];
    for (rank, &i) in order.iter().enumerate() {
        quantile[i] = -distribution::normal_critical((rank as f64 + 1.0 - 0.375) / (n + 0.25));
    }
    let one = |(i, &run): (usize, &usize)| residuals::Residual {
        run: study.runs[run].run.id.clone(),
        fitted: fitted[i],
        residual: residual[i],
        normal_quantile: Some(quantile[i]),
    };
    analysis.used_runs.iter().enumerate().map(one).collect()
}

fn draw_theory(gallery: &mut Gallery, study: &CampaignStudy) -> Result<(), Error> {
    let mm = |v: f64| v / MILLIMETRE;
    let (mut radius, mut depth, mut folds, mut gaps) = (vec![], vec![], vec![], vec![]);
    for (number, (_, cell)) in cells(&study.runs).into_iter().enumerate() {
        for run in cell {
            let (Ok(fit), Some(comparison), Some(prediction)) = (&run.fit, &run.comparison, &run.prediction) else { continue };
            let id = &run.run.id;
            let pair = |fitted: f64, predicted: f64| agreement::Pair { run: id.clone(), fitted, predicted };
            // The circle of equal area, as the comparison means it.
            let mean = (fit.area / std::f64::consts::PI).sqrt();
            radius.push(pair(mm(mean), mm(mean + comparison.mean_radius)));
            depth.push(pair(mm(fit.fold_depth), mm(fit.fold_depth + comparison.depth)));
            if let Some(m) = fit.folds {
                folds.push(pair(f64::from(m), f64::from(prediction.folds)));
            }
            gaps.push(gap::Gap {
                run: id.clone(),
                cell: number,
                rms: mm(comparison.rms),
                mean_radius: mm(comparison.mean_radius),
                depth: mm(comparison.depth),
                fit_rms: mm(fit.rms),
            });
        }
    }
    let median = |pick: fn(&gap::Gap) -> f64| spread(gaps.iter().map(pick)).map(|s| s.median);
    if let (Some(rms), Some(mean_radius), Some(fold_depth)) = (median(|g| g.rms), median(|g| g.mean_radius), median(|g| g.depth)) {
        gallery.insert("theory_agreement".into(), agreement::draw(&radius, &depth, &folds)?);
        gallery.insert("theory_gap".into(), gap::draw(&gaps, [rms, mean_radius, fold_depth])?);
    }
    Ok(())
}

/// All folds, and the most uneven hem.
fn draw_folds(gallery: &mut Gallery, study: &CampaignStudy) -> Result<(), Error> {
    let mut hems = vec![];
    for (number, (_, members)) in cells(&study.runs).into_iter().enumerate() {
        for run in members {
            let Some(table) = run.irregular.as_ref().map(|i| &i.table).filter(|t| !t.folds.is_empty()) else { continue };
            let even = table.folds.len() as f64;
            let fitted = run.fit.as_ref().ok().filter(|fit| fit.folds.is_some());
            hems.push(folds::Hem {
                run: run.run.id.clone(),
                cell: number,
                depths: table.folds.iter().map(|f| f.depth.value / MILLIMETRE).collect(),
                widths: table.folds.iter().map(|f| f.width.value * even).collect(),
                fitted: fitted.map(|fit| fit.fold_depth / MILLIMETRE),
            });
        }
    }
    if !hems.is_empty() {
        gallery.insert("folds".into(), folds::draw(&hems)?);
    }
    for (stem, run) in [("folds_uneven", most_uneven(study)), ("folds_reshaped", most_reshaped(study))] {
        if let Some(view) = run.and_then(uneven_view) {
            gallery.insert(stem.into(), uneven::draw(&view)?);
        }
    }
    Ok(())
}

fn uneven_view(run: &RunStudy) -> Option<uneven::View> {
    const NODES: usize = 400;
    let (profile, fit, irregular) = (run.profile.as_ref()?, run.fit.as_ref().ok()?, run.irregular.as_ref()?);
    let (model, free) = irregular.free.as_ref().ok()?;
    let tangent = irregular.tangent.as_ref().ok();
    let named = |name: &str, rms: f64| format!("{name}, {} mm", number::fixed(rms / MILLIMETRE, 1));
    let centre = free.placed.centre;
    let fold = |f: &crate::fit::fold_table::Fold| {
        let (sin, cos) = f.angle.value.sin_cos();
        uneven::Fold {
            crest: crate::experiment::Point::new(centre.x + f.radius.value * cos, centre.y + f.radius.value * sin),
            depth: (f.depth.value / MILLIMETRE, f.depth.standard_error.map(|e| e / MILLIMETRE)),
            width: (f.width.value / PERCENT, f.width.standard_error.map(|e| e / PERCENT)),
            overhang: f.overhang.value / MILLIMETRE,
        }
    };
    Some(uneven::View {
        run: run.run.id.clone(),
        measured: profile.points().to_vec(),
        paper: fit.outline(NODES),
        tangent: tangent.map(|(_, t)| t.placed.outline(NODES)).unwrap_or_default(),
        free: free.placed.outline(NODES),
        centre,
        names: [
            named("paper’s curve", irregular.paper.rms),
            tangent.map(|(model, _)| named("equal folds", model.rms)).unwrap_or_default(),
            named("free outline", model.rms),
        ],
        folds: irregular.table.folds.iter().map(fold).collect(),
    })
}

/// Every fidelity against every run, if there is a theory for any.
fn draw_fidelities(gallery: &mut Gallery, study: &CampaignStudy) -> Result<(), Error> {
    let (mut names, mut numbers) = (vec![], vec![]);
    for (number, (_, members)) in cells(&study.runs).into_iter().enumerate() {
        for run in members.into_iter().filter(|run| study.fidelities.iter().any(|row| row.run == run.run.id)) {
            names.push(run.run.id.clone());
            numbers.push(number);
        }
    }
    if names.is_empty() {
        return Ok(());
    }
    let series = |pick: &dyn Fn(&FidelityRun) -> Option<f64>| -> Vec<Vec<Option<f64>>> {
        let of = |name: &String, fidelity: &str| study.fidelities.iter().find(|row| row.run == *name && row.fidelity == fidelity);
        FIDELITIES.iter().map(|(fidelity, _)| names.iter().map(|name| of(name, fidelity).and_then(pick)).collect()).collect()
    };
    let panel = |title, unit, reference, series| fidelities::Panel { title, unit, reference, series };
    let panels = [
        panel(
            "Shape: rms distance of the points from the hem predicted at the fitted fold count",
            "mm",
            0.0,
            series(&|row| row.comparison.as_ref().map(|c| c.rms / MILLIMETRE)),
        ),
        panel("Fold depth, predicted / fitted", "ratio", 1.0, series(&|row| row.depth_ratio)),
        panel(
            "Fold count of least energy, predicted − fitted",
            "folds",
            0.0,
            series(&|row| Some(f64::from(row.predicted_folds) - f64::from(row.fitted_folds))),
        ),
    ];
    gallery.insert("theory_fidelities".into(), fidelities::draw(&names, &numbers, &FIDELITIES.map(|(name, _)| name), &panels)?);
    Ok(())
}

/// Rigidities from the hem against known ones, if there are any.
fn draw_rigidity(gallery: &mut Gallery, study: &CampaignStudy) -> Result<(), Error> {
    let series: Vec<rigidity::Series> = Through::ALL
        .into_iter()
        .map(|through| {
            let own = study.identified.iter().filter(|row| row.through == through);
            let point = |row: &Identified| {
                let (found, known) = (row.found.as_ref().ok()?, row.known?);
                let (known, estimated) = (known / MICRONEWTON_METRE, found.rigidity.value / MICRONEWTON_METRE);
                Some(rigidity::Point { known, estimated, relative_error: found.relative_error })
            };
            rigidity::Series { name: through.name().into(), points: own.filter_map(point).collect() }
        })
        .collect();
    if series.iter().any(|s| !s.points.is_empty()) {
        gallery.insert("rigidity".into(), rigidity::draw(&series)?);
    }
    Ok(())
}

/// Runs by cell of the design, cells in standard order (first factor fastest), runs in run order.
pub fn cells(runs: &[RunStudy]) -> Vec<(&[f64], Vec<&RunStudy>)> {
    let mut cells: Vec<(&[f64], Vec<&RunStudy>)> = vec![];
    for run in runs {
        match cells.iter_mut().find(|(levels, _)| *levels == run.run.levels.as_slice()) {
            Some((_, members)) => members.push(run),
            None => cells.push((&run.run.levels, vec![run])),
        }
    }
    let standard = |a: &[f64], b: &[f64]| a.iter().rev().zip(b.iter().rev()).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne());
    cells.sort_by(|a, b| standard(a.0, b.0).unwrap_or(std::cmp::Ordering::Equal));
    cells
}

/// “hem radius 26 cm”, one for each factor.
pub fn cell_name(factors: &[Factor], levels: &[f64]) -> Vec<String> {
    let name = |(factor, coded): (&Factor, &f64)| {
        let unit = factor.unit.as_deref().map(|u| format!(" {u}")).unwrap_or_default();
        format!("{} {}{unit}", factor.name, number::plain(factor.natural(*coded)))
    };
    factors.iter().zip(levels).map(name).collect()
}

fn rows(study: &CampaignStudy) -> Vec<multiples::Row> {
    let factors = &study.campaign.design.factors;
    let row = |(levels, runs): (&[f64], Vec<&RunStudy>)| multiples::Row {
        name: cell_name(factors, levels),
        hems: runs.into_iter().filter_map(|run| Some((hem::View::of(run)?, thumb_caption(run)))).collect(),
    };
    cells(&study.runs).into_iter().map(row).filter(|row| !row.hems.is_empty()).collect()
}

fn thumb_caption(run: &RunStudy) -> String {
    match &run.fit {
        Ok(fit) => {
            let folds = fit.folds.map_or_else(|| "round".into(), |m| format!("m {m}"));
            format!("run {} · {folds} · rms {} mm", run.run.id, number::fixed(fit.rms / MILLIMETRE, 1))
        }
        Err(_) => format!("run {} · no fit", run.run.id),
    }
}
