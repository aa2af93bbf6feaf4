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
pub mod irregular;
pub mod kinds;
pub mod note;
pub mod number;
pub mod output;
pub mod paper;
pub mod parallel;
pub mod picture;
pub mod raster;
mod scenes;
pub mod summary;
mod sureness;
pub mod table;
pub mod typeset;
pub mod words;

#[cfg(test)]
mod sample;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

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
    /// Whether `figures/` is wanted: every figure of the document as SVG and PNG.
    pub pictures: bool,
    /// Dots per inch of the PNG files.
    pub dpi: f64,
}

impl Default for Options {
    /// Everything, of unknown provenance.
    fn default() -> Self {
        Options { provenance: Provenance::default(), pictures: true, dpi: raster::DPI }
    }
}

/// Writes the report of a campaign into `folder` and returns the paths, in order: `report.pdf`, the tables of
/// [`table`] and [`analysis_table`] as CSV, `summary.json`, `figures/*.svg` and `figures/*.png`; docs/results.md describes them.
///
/// Each file is written beside its place and then renamed: a file of the report is whole or not there.
///
/// # Errors
/// [`Error::File`] if the folder cannot be written, [`Error::Output`] if a figure or the document cannot be produced.
pub fn write(study: &CampaignStudy, folder: &Path, options: &Options) -> Result<Vec<PathBuf>, Error> {
    write_with(study, folder, options, &|_| ())
}

/// What [`write_with`] tells while it works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// So many steps are ahead.
    Ahead(usize),
    /// One of them is done.
    Step,
}

/// As [`write`], telling how far it is.
///
/// # Errors
/// Those of [`write`].
pub fn write_with(
    study: &CampaignStudy,
    folder: &Path,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Vec<PathBuf>, Error> {
    let gallery = gallery::draw(study)?;
    // The document is set on one core: the others draw the pictures meanwhile.
    let (pictures, pdf) = std::thread::scope(|scope| {
        let pictures = options.pictures.then(|| scope.spawn(|| picture::write_all(&gallery, folder, options.dpi, progress)));
        let pdf = document::pdf(study, &gallery, &options.provenance);
        let pictures = pictures.map(|drawing| drawing.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        (pictures, pdf)
    });
    let (pictures, pdf) = (pictures.transpose()?.unwrap_or_default(), pdf?);
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
    written.extend(pictures);
    Ok(written)
}
