//! Results → files; computes nothing.

pub mod analysis_table;
pub mod caption;
pub mod check;
mod columnar;
pub mod csv;
pub mod date;
pub mod document;
pub mod fidelities;
pub mod figure;
pub mod gallery;
pub mod identify;
pub mod irregular;
pub mod language;
pub mod letterhead;
pub mod note;
pub mod number;
pub mod output;
pub mod paper;
pub mod pattern;
pub mod raster;
pub mod section;
mod spreadsheet;
pub mod summary;
pub mod surface;
mod sureness;
pub mod table;
pub mod tables;
pub mod typeset;
pub mod words;

#[cfg(test)]
mod sample;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

pub use date::Date;

use crate::error::Error;
use crate::experiment::campaign::Language;
use crate::study::campaign::CampaignStudy;
use language::Translator;
use letterhead::Letterhead;
use section::Section;

/// What is printed beside the study's own sources and quarantine, and never used.
#[derive(Debug, Clone, Default)]
pub struct Provenance {
    /// Options of the program in words: (“Hem length”, “auto”).
    pub settings: Vec<(String, String)>,
    /// The date on the document; see [`Date::from_environment`].
    pub date: Option<Date>,
}

/// A part of the report that can be asked for by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// `report.pdf`.
    Pdf,
    /// Every table as CSV, Parquet and sheet of `report.xlsx`.
    Tables,
    /// `figures/`.
    Figures,
    /// `summary.json`.
    Summary,
}

impl Part {
    /// All of them, in the order in which they are written.
    pub const ALL: [Part; 4] = [Part::Pdf, Part::Tables, Part::Summary, Part::Figures];

    /// As the command line spells it.
    pub fn name(self) -> &'static str {
        match self {
            Part::Pdf => "pdf",
            Part::Tables => "tables",
            Part::Figures => "figures",
            Part::Summary => "summary",
        }
    }
}

/// The size of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Paper {
    /// 210 × 297 mm: ISO 216, what most laboratories print on.
    #[default]
    A4,
    /// 8½ × 11 inch.
    Letter,
}

/// What to write, and how.
#[derive(Debug, Clone)]
pub struct Options {
    pub provenance: Provenance,
    /// What is wanted; work that only the others need is not done.
    pub parts: BTreeSet<Part>,
    /// Of the PDF, the figures and the words of the workbook; names in tables and keys of the summary are the same in all.
    pub language: Language,
    pub paper: Paper,
    pub letterhead: Letterhead,
    /// Chapters of studies that were made beside the campaign's analysis.
    pub sections: Vec<Section>,
}

impl Default for Options {
    /// Everything, of unknown provenance, in English on A4.
    fn default() -> Self {
        Options {
            provenance: Provenance::default(),
            parts: Part::ALL.into(),
            language: Language::default(),
            paper: Paper::default(),
            letterhead: Letterhead::default(),
            sections: vec![],
        }
    }
}

impl Options {
    /// Whether a part is wanted.
    pub fn wants(&self, part: Part) -> bool {
        self.parts.contains(&part)
    }
}

/// Writes the report of a campaign into `folder` and returns the paths, in order: `report.pdf`, every table of [`tables`] as CSV, then as Parquet
/// and in `report.xlsx`, `summary.json`, `figures/*.png`; docs/results.md describes them.
///
/// Each file is written beside its place and then renamed: a file of the report is whole or not there.
///
/// # Errors
/// [`Error::File`] if the folder cannot be written, [`Error::Output`] if a figure or the document cannot be produced.
pub fn write(study: &CampaignStudy, folder: &Path, options: &Options) -> Result<Vec<PathBuf>, Error> {
    let translator = Translator::new(options.language, language::names(study));
    let mut written = vec![];
    let mut put = |name: &str, bytes: &[u8]| output::write(folder, name, bytes).map(|path| written.push(path));
    let drawn = options.wants(Part::Pdf) || options.wants(Part::Figures);
    let gallery = if drawn { gallery_in(study, options, &translator)? } else { gallery::Gallery::new() };
    if options.wants(Part::Pdf) {
        put("report.pdf", &document::pdf(study, &gallery, options, &translator)?)?;
    }
    if options.wants(Part::Tables) {
        let tables = tables::all(study);
        for named in &tables {
            put(&format!("{}.csv", named.stem), &named.table.bytes())?;
        }
        for named in &tables {
            let name = format!("parquet/{}.parquet", named.stem);
            put(&name, &columnar::parquet(&name, &named.table)?)?;
        }
        put("report.xlsx", &spreadsheet::workbook(study, &tables, &options.provenance, &translator)?)?;
    }
    if options.wants(Part::Summary) {
        put("summary.json", summary::text(study, &options.provenance)?.as_bytes())?;
    }
    if options.wants(Part::Figures) {
        for (name, bytes) in rasterize(&gallery)? {
            put(&name, &bytes)?;
        }
    }
    Ok(written)
}

/// Every string of the report that its language has no words for, in order; none in English.
///
/// # Errors
/// Those of the figures.
pub fn untranslated(study: &CampaignStudy, options: &Options) -> Result<Vec<String>, Error> {
    let translator = Translator::strict(options.language, language::names(study));
    let gallery = gallery_in(study, options, &translator)?;
    document::untranslated(study, &gallery, options, &translator);
    spreadsheet::workbook(study, &tables::all(study), &options.provenance, &translator)?;
    Ok(translator.missing())
}

/// Every figure of the campaign and of the sections, in the language asked for.
fn gallery_in(study: &CampaignStudy, options: &Options, translator: &Translator) -> Result<gallery::Gallery, Error> {
    let mut gallery = gallery::draw(study)?;
    gallery.extend(options.sections.iter().flat_map(|s| &s.figures).map(|f| (f.stem.clone(), f.svg.clone())));
    for figure in gallery.values_mut() {
        *figure = translator.svg(figure, &typeset::Sans);
    }
    Ok(gallery)
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
