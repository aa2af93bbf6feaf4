//! Results → files; computes nothing.

pub mod analysis_table;
pub mod caption;
pub mod check;
pub mod csv;
pub mod date;
pub mod document;
pub mod fidelities;
pub mod figure;
pub mod gallery;
pub mod identify;
pub mod irregular;
pub mod note;
pub mod number;
pub mod output;
pub mod paper;
pub mod pattern;
pub mod raster;
pub mod summary;
pub mod surface;
mod sureness;
pub mod table;
pub mod typeset;
pub mod words;

#[cfg(test)]
mod sample;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

pub use date::Date;

use crate::error::Error;
use crate::study::campaign::CampaignStudy;

/// What is printed beside the study's own sources and quarantine, and never used.
#[derive(Debug, Clone, Default)]
pub struct Provenance {
    /// Options of the program in words: (“Hem length”, “auto”).
    pub settings: Vec<(String, String)>,
    /// The date on the document; see [`Date::from_environment`].
    pub date: Option<Date>,
}

/// What to write.
#[derive(Debug, Clone)]
pub struct Options {
    pub provenance: Provenance,
    /// Whether `figures/*.png` are wanted; they take longer than everything else together.
    pub pictures: bool,
}

impl Default for Options {
    /// Everything, of unknown provenance.
    fn default() -> Self {
        Options { provenance: Provenance::default(), pictures: true }
    }
}

/// Writes the report of a campaign into `folder` and returns the paths, in order: `report.pdf`, the tables of
/// [`table`] and [`analysis_table`] as CSV, `summary.json`, `figures/*.png`; docs/results.md describes them.
///
/// Each file is written beside its place and then renamed: a file of the report is whole or not there.
///
/// # Errors
/// [`Error::File`] if the folder cannot be written, [`Error::Output`] if a figure or the document cannot be produced.
pub fn write(study: &CampaignStudy, folder: &Path, options: &Options) -> Result<Vec<PathBuf>, Error> {
    let gallery = gallery::draw(study)?;
    let pictures = if options.pictures { rasterize(&gallery)? } else { vec![] };
    let pdf = document::pdf(study, &gallery, &options.provenance)?;
    let mut summary = serde_json::to_string_pretty(&summary::summary(study, &options.provenance))
        .map_err(|error| Error::Output { what: "summary.json".into(), why: error.to_string() })?;
    summary.push('\n');
    let factor_names: Vec<&str> = study.campaign.design.factors.iter().map(|f| f.name.as_str()).collect();
    let rows = || study.runs.iter().map(Into::into);
    let (regressions, factors) = (study.regressions.as_slice(), study.campaign.design.factors.as_slice());
    let ids: Vec<&str> = study.runs.iter().map(|run| run.run.id.as_str()).collect();
    let uneven = || study.runs.iter().filter_map(|run| Some((run.run.id.as_str(), run.irregular.as_ref()?)));
    let files = [
        ("report.pdf", pdf),
        ("fits.csv", table::fits(rows()).bytes()),
        ("regression.csv", analysis_table::regression(regressions).bytes()),
        ("weighted.csv", analysis_table::weighted(regressions).bytes()),
        ("diagnostics.csv", analysis_table::diagnostics(regressions, &ids).bytes()),
        ("power.csv", analysis_table::power(regressions).bytes()),
        ("ascent.csv", analysis_table::ascent(regressions, factors).bytes()),
        ("next_runs.csv", analysis_table::next_runs(regressions, factors).bytes()),
        ("desirability.csv", analysis_table::desirability(study).bytes()),
        ("theory_effects.csv", analysis_table::theory_effects(regressions).bytes()),
        ("candidates.csv", table::candidates(rows()).bytes()),
        ("predictions.csv", table::predictions(&study.runs).bytes()),
        ("fidelities.csv", fidelities::runs(&study.fidelities).bytes()),
        ("fidelity_summary.csv", fidelities::summary(&crate::study::fidelities::summarize(&study.fidelities), &factor_names).bytes()),
        ("identify.csv", identify::runs(&study.identified).bytes()),
        ("models.csv", irregular::models(uneven()).bytes()),
        ("folds.csv", irregular::folds(uneven()).bytes()),
        ("points.csv", table::points(rows()).bytes()),
        ("quarantine.csv", table::quarantine(&study.quarantine).bytes()),
        ("summary.json", summary.into_bytes()),
    ];
    let mut written = vec![];
    for (name, bytes) in &files {
        written.push(output::write(folder, name, bytes)?);
    }
    for (name, bytes) in &pictures {
        written.push(output::write(folder, name, bytes)?);
    }
    Ok(written)
}

/// All pictures, each on the next free core; the order of the result is that of the gallery.
fn rasterize(gallery: &gallery::Gallery) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let figures: Vec<(&String, &String)> = gallery.iter().collect();
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::with_capacity(figures.len()));
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some((i, (stem, svg))) = Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|i| Some((i, figures.get(i)?))) {
                    let name = format!("figures/{stem}.png");
                    let picture = raster::png(&name, svg).map(|png| (name, png));
                    done.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push((i, picture));
                }
            });
        }
    });
    let mut done = done.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    done.sort_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, picture)| picture).collect()
}
