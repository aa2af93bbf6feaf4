//! Which figures a campaign gets, and from what: everything that the document shows and the folder of pictures holds.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::figure::{agreement, fidelities, folds, gap, half_normal, hem, multiples, residuals, rigidity, uneven};
use super::kinds::{KINDS, Kind, Of, Shown, Subject};
use super::number;
use super::words;
use crate::error::Error;
use crate::experiment::{Factor, Run};
use crate::statistics::box_wilson::Analysis;
use crate::statistics::distribution;
use crate::study::campaign::{CampaignStudy, RunStudy};
use crate::study::fidelities::{FIDELITIES, FidelityRun};
use crate::study::identify::{Identified, Through};
use crate::study::overview::spread;
use crate::units::{MICRONEWTON_METRE, MILLIMETRE, PERCENT};

/// SVG by file stem, in a fixed order.
pub type Gallery = BTreeMap<String, String>;

/// Draws all figures of a campaign that are shown without asking.
///
/// # Errors
/// [`Error::Output`] naming the figure that could not be drawn.
pub fn draw(study: &CampaignStudy) -> Result<Gallery, Error> {
    let exhibits = exhibits(study);
    let drawn = exhibits.par_iter().map(|(kind, subject)| (kind.draw)(study, subject)).collect::<Vec<_>>();
    let mut gallery = Gallery::new();
    for ((kind, subject), svg) in exhibits.iter().zip(drawn) {
        match svg {
            Ok(svg) => {
                gallery.insert(kind.stem(subject), svg);
            }
            // This campaign has no such figure.
            Err(Error::Unanswerable(_)) => (),
            Err(error) => return Err(error),
        }
    }
    Ok(gallery)
}

/// Every figure of the campaign as a whole, of each run, cell and response. Of the skirts in space only the first of each cell, of the patterns only one for
/// each cut, and of the paper's own figures only those of the first run: `hemline plot` draws the others.
fn exhibits(study: &CampaignStudy) -> Vec<(&'static Kind, Subject<'_>)> {
    let pages = multiples::pages(&rows(study));
    let cells = cells(&study.runs);
    let firsts: Vec<&RunStudy> = cells.iter().filter_map(|(_, runs)| runs.iter().copied().find(|run| run.fit.is_ok())).collect();
    let mut cuts: Vec<&RunStudy> = vec![];
    for run in study.runs.iter().filter(|run| run.run.skirt.is_some()) {
        if !cuts.iter().any(|known| known.run.skirt == run.run.skirt) {
            cuts.push(run);
        }
    }
    let first = study.runs.iter().find(|run| run.fit.is_ok());
    let mut exhibits = vec![];
    for kind in &KINDS {
        match (kind.of, kind.shown) {
            (Of::Campaign, _) => exhibits.push((kind, Subject::Campaign)),
            (Of::Page, _) => exhibits.extend((1..=pages).map(|page| (kind, Subject::Page(page)))),
            (Of::Run, Shown::All) => exhibits.extend(study.runs.iter().map(|run| (kind, Subject::Run(run)))),
            (Of::Run, Shown::OneOfACell) => exhibits.extend(firsts.iter().map(|run| (kind, Subject::Run(run)))),
            (Of::Run, Shown::OneOfACut) => exhibits.extend(cuts.iter().map(|run| (kind, Subject::Run(run)))),
            (Of::Run, Shown::First) => exhibits.extend(first.map(|run| (kind, Subject::Run(run)))),
            (Of::Cell, _) => exhibits.extend((1..=cells.len()).map(|cell| (kind, Subject::Cell(cell)))),
            (Of::Response, _) => {
                let ranking = ["pareto", "half_normal"].contains(&kind.name);
                let shown = study.regressions.iter().filter(|regression| match &regression.analysis {
                    // One ranking is enough: by t where there is one.
                    Ok(analysis) if ranking => analysis.t_critical.is_some() == (kind.name == "pareto"),
                    Ok(_) => true,
                    Err(_) => false,
                });
                exhibits.extend(shown.map(|regression| (kind, Subject::Response(regression))));
            }
        }
    }
    exhibits
}

/// The common beginning of the names of a response's figures.
pub fn regression_stem(response: &str) -> String {
    format!("regression_{}", words::file_stem(response))
}

/// Half-normal scores of all coefficients but the mean: quantile of (rank − ½)/k of |Z|.
pub(super) fn scores(analysis: &Analysis) -> Vec<half_normal::Score> {
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
pub(super) fn observations(study: &CampaignStudy, analysis: &Analysis) -> Vec<residuals::Residual> {
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

/// Theory against measurement, run by run; lengths in mm.
pub(super) struct Against {
    pub radius: Vec<agreement::Pair>,
    pub depth: Vec<agreement::Pair>,
    pub folds: Vec<agreement::Pair>,
    pub gaps: Vec<gap::Gap>,
}

pub(super) fn against(study: &CampaignStudy) -> Against {
    let mm = |v: f64| v / MILLIMETRE;
    let mut against = Against { radius: vec![], depth: vec![], folds: vec![], gaps: vec![] };
    for (number, (_, cell)) in cells(&study.runs).into_iter().enumerate() {
        for run in cell {
            let (Ok(fit), Some(comparison), Some(prediction)) = (&run.fit, &run.comparison, &run.prediction) else { continue };
            let id = &run.run.id;
            let pair = |fitted: f64, predicted: f64| agreement::Pair { run: id.clone(), fitted, predicted };
            // The circle of equal area, as the comparison means it.
            let mean = (fit.area / std::f64::consts::PI).sqrt();
            against.radius.push(pair(mm(mean), mm(mean + comparison.mean_radius)));
            against.depth.push(pair(mm(fit.fold_depth), mm(fit.fold_depth + comparison.depth)));
            if let Some(m) = fit.folds {
                against.folds.push(pair(f64::from(m), f64::from(prediction.folds)));
            }
            against.gaps.push(gap::Gap {
                run: id.clone(),
                cell: number,
                rms: mm(comparison.rms),
                mean_radius: mm(comparison.mean_radius),
                depth: mm(comparison.depth),
                fit_rms: mm(fit.rms),
            });
        }
    }
    against
}

/// Medians of the distances from theory: shape, mean radius, depth; `None` where nothing is compared.
pub(super) fn medians(gaps: &[gap::Gap]) -> Option<[f64; 3]> {
    let median = |pick: fn(&gap::Gap) -> f64| spread(gaps.iter().map(pick)).map(|s| s.median);
    Some([median(|g| g.rms)?, median(|g| g.mean_radius)?, median(|g| g.depth)?])
}

/// The folds of every run that has some.
pub(super) fn folded(study: &CampaignStudy) -> Vec<folds::Hem> {
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
    hems
}

pub(super) fn uneven_view(run: &RunStudy) -> Option<uneven::View> {
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

/// Every fidelity against every run; `None` if there is a theory for none.
pub(super) fn draw_fidelities(study: &CampaignStudy) -> Option<Result<String, Error>> {
    let (mut names, mut numbers) = (vec![], vec![]);
    for (number, (_, members)) in cells(&study.runs).into_iter().enumerate() {
        for run in members.into_iter().filter(|run| study.fidelities.iter().any(|row| row.run == run.run.id)) {
            names.push(run.run.id.clone());
            numbers.push(number);
        }
    }
    if names.is_empty() {
        return None;
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
    Some(fidelities::draw(&names, &numbers, &FIDELITIES.map(|(name, _)| name), &panels))
}

/// Rigidities from the hem against known ones, if there are any.
pub(super) fn draw_rigidity(study: &CampaignStudy) -> Option<Result<String, Error>> {
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
    series.iter().any(|s| !s.points.is_empty()).then(|| rigidity::draw(&series))
}

/// Runs by cell of the design, cells in standard order (first factor fastest), runs in run order.
pub fn cells(runs: &[RunStudy]) -> Vec<(&[f64], Vec<&RunStudy>)> {
    grouped(runs, |run| &run.run.levels)
}

/// The same of runs of which nothing is known yet.
pub fn cells_of(runs: &[Run]) -> Vec<(&[f64], Vec<&Run>)> {
    grouped(runs, |run| &run.levels)
}

fn grouped<T>(runs: &[T], levels: impl Fn(&T) -> &[f64]) -> Vec<(&[f64], Vec<&T>)> {
    let mut cells: Vec<(&[f64], Vec<&T>)> = vec![];
    for run in runs {
        match cells.iter_mut().find(|(known, _)| *known == levels(run)) {
            Some((_, members)) => members.push(run),
            None => cells.push((levels(run), vec![run])),
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

pub(super) fn rows(study: &CampaignStudy) -> Vec<multiples::Row> {
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
