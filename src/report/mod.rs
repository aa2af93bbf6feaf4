//! Results → files; computes nothing.

pub mod accuracy;
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
pub mod kinds;
pub mod language;
pub mod letterhead;
pub mod note;
pub mod number;
pub mod output;
pub mod page;
pub mod paper;
pub mod picture;
pub mod pattern;
pub mod raster;
mod scenes;
pub mod section;
mod spreadsheet;
pub mod stability;
pub mod study_section;
pub mod summary;
pub mod surface;
mod sureness;
pub mod table;
pub mod tables;
pub mod terms;
pub mod typeset;
pub mod words;

#[cfg(test)]
mod sample;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

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
    /// `report.html`.
    Html,
    /// Every table as CSV, Parquet and sheet of `report.xlsx`.
    Tables,
    /// `figures/`.
    Figures,
    /// `summary.json`.
    Summary,
}

impl Part {
    /// All of them, in the order in which their paths are told.
    pub const ALL: [Part; 5] = [Part::Pdf, Part::Html, Part::Tables, Part::Summary, Part::Figures];

    /// As the command line spells it.
    pub fn name(self) -> &'static str {
        match self {
            Part::Pdf => "pdf",
            Part::Html => "html",
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
    /// Of the PDF, the page, the figures and the words of the workbook; names in tables and keys of the summary are the same in all.
    pub language: Language,
    pub paper: Paper,
    pub letterhead: Letterhead,
    /// Chapters of studies that were made beside the campaign's analysis.
    pub sections: Vec<Section>,
    /// Dots per inch of the PNG files.
    pub dpi: f64,
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
            dpi: raster::DPI,
        }
    }
}

impl Options {
    /// Whether a part is wanted.
    pub fn wants(&self, part: Part) -> bool {
        self.parts.contains(&part)
    }
}

/// Writes the report of a campaign into `folder` and returns the paths, in order: `report.pdf`, `report.html`, every table of [`tables`] as CSV, then as Parquet
/// and in `report.xlsx`, `summary.json`, `figures/*.svg` and `figures/*.png`; docs/results.md describes them.
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

/// As [`write()`], telling how far it is.
///
/// # Errors
/// Those of [`write()`].
pub fn write_with(
    study: &CampaignStudy,
    folder: &Path,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Vec<PathBuf>, Error> {
    let translator = Translator::new(options.language, language::names(study));
    let drawn = options.wants(Part::Pdf) || options.wants(Part::Figures);
    let gallery = if drawn { gallery_in(study, options, &translator)? } else { gallery::Gallery::new() };
    // The document comes last and alone: with anything beside it it would need the room of both. It takes the figures as its own.
    let mut pictures = Ok(vec![]);
    let rest = rayon::in_place_scope(|scope| {
        if options.wants(Part::Figures) {
            scope.spawn(|_| pictures = picture::write_all(&gallery, folder, options.dpi, progress));
        }
        write_rest(study, folder, options, &translator)
    });
    let (pictures, rest) = (pictures?, rest?);
    let mut written = vec![];
    if options.wants(Part::Pdf) {
        let document = typeset::pdf(document::manuscript(study, gallery, options, &translator))?;
        written.push(output::write(folder, "report.pdf", &document)?);
    }
    written.extend(rest);
    written.extend(pictures);
    Ok(written)
}

/// The page, the tables and the summary.
fn write_rest(study: &CampaignStudy, folder: &Path, options: &Options, translator: &Translator) -> Result<Vec<PathBuf>, Error> {
    let mut written = vec![];
    let mut put = |name: &str, bytes: &[u8]| output::write(folder, name, bytes).map(|path| written.push(path));
    if options.wants(Part::Html) {
        put("report.html", page::html(study, options, translator).as_bytes())?;
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
        put("report.xlsx", &spreadsheet::workbook(study, &tables, &options.provenance, translator)?)?;
    }
    if options.wants(Part::Summary) {
        put("summary.json", summary::text(study, &options.provenance)?.as_bytes())?;
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
    page::html(study, options, &translator);
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

/// A figure in a language, its words measured in the embedded family.
pub fn in_language(svg: &str, study: &CampaignStudy, language: Language) -> String {
    Translator::new(language, language::names(study)).svg(svg, &typeset::Sans)
}
