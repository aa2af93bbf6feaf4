//! `hemline report`: a campaign folder → only the parts of its report that are asked for, in the form that is asked for.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;

use crate::cli::print;
use crate::error::Error;
use crate::experiment::campaign::Language;
use crate::import;
use crate::report::letterhead::Letterhead;
use crate::report::{self, Paper, Part};
use crate::study::campaign::CampaignStudy;

/// What of the report is written, and in which form; the same for `hemline run`.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "The report")]
pub struct ReportFlags {
    /// Only this part, or these with commas between: pdf, html, tables, figures, summary; may be given several times. Work that only the others need is not done.
    #[arg(long, value_name = "PART", value_delimiter = ',', value_parser = part)]
    pub only: Vec<Part>,
    /// A laboratory's own header: a folder with template.toml (or just logo.svg, logo.png), a TOML file, or a whole template in Typst (docs/report.md).
    #[arg(long, value_name = "FILE|DIR")]
    pub template: Option<PathBuf>,
    /// Language of the document, the page, the figures and the workbook's first sheet: en or ru; `language` of campaign.toml unless told.
    #[arg(long, value_name = "en|ru", value_parser = language)]
    pub language: Option<Language>,
    /// Size of a page: a4 or letter.
    #[arg(long, value_name = "a4|letter", default_value = "a4", value_parser = paper)]
    pub paper: Paper,
    /// Dots per inch of figures/*.png, 20 to 2400; 300 unless told.
    #[arg(long, value_parser = super::dots, value_name = "DPI")]
    pub dpi: Option<f64>,
}

impl ReportFlags {
    /// What to hand to [`report::write`] for a study.
    ///
    /// # Errors
    /// Those of [`Letterhead::read`].
    pub(super) fn options(&self, study: &CampaignStudy) -> Result<report::Options, Error> {
        Ok(report::Options {
            provenance: report::Provenance { settings: super::run::settings(study), date: report::Date::from_environment() },
            parts: self.parts(),
            language: self.language.unwrap_or(study.campaign.language),
            paper: self.paper,
            letterhead: self.letterhead()?,
            dpi: self.dpi.unwrap_or(report::raster::DPI),
            ..report::Options::default()
        })
    }

    /// The laboratory's head, or none.
    ///
    /// # Errors
    /// Those of [`Letterhead::read`].
    pub(super) fn letterhead(&self) -> Result<Letterhead, Error> {
        self.template.as_deref().map(Letterhead::read).transpose().map(Option::unwrap_or_default)
    }

    fn parts(&self) -> BTreeSet<Part> {
        if self.only.is_empty() { Part::ALL.into() } else { self.only.iter().copied().collect() }
    }
}

/// Write the report of a campaign, or only parts of it, in a language, on a paper, under a laboratory's own header.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  hemline report spring --only pdf --language ru --paper a4 --template our-lab/\n  \
hemline report --only tables,summary --out tables\n\n\
The paths of the files are printed, one a line. The campaign is analysed as by `hemline run`; pictures are drawn only where the PDF or the figures need them.\n\n\
Exit code: 0 every run is fitted, 1 some run is not, 2 no campaign could be read or the template is not usable.")]
pub struct Report {
    /// The campaign's folder.
    #[arg(default_value = "data")]
    pub campaign: PathBuf,
    /// Where the report goes; made if it is not there.
    #[arg(long, default_value = "reports", value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub flags: ReportFlags,
}

/// Reads, analyses, writes; the paths on stdout.
///
/// # Errors
/// Those of [`import::load`], [`Letterhead::read`] and [`report::write`].
pub fn run(args: &Report) -> Result<ExitCode, Error> {
    super::memory::share_heaps();
    // A header that cannot be used is said before the campaign is analysed.
    args.flags.letterhead()?;
    let imported = import::load(&args.campaign)?;
    let (study, bar) = super::analysed(imported);
    bar.set_message("Writing the report");
    let written = report::write_with(&study, &args.out, &args.flags.options(&study)?, &super::steps(&bar))?;
    bar.finish_and_clear();
    let lines: Vec<String> = written.iter().map(|path: &PathBuf| format!("{}\n", Path::display(path))).collect();
    print(&lines.concat())?;
    Ok(super::run::exit(&study))
}

fn part(text: &str) -> Result<Part, String> {
    let names = Part::ALL.map(Part::name);
    Part::ALL
        .into_iter()
        .find(|part| part.name() == text)
        .ok_or_else(|| format!("“{text}” is no part of a report: use {}", names.join(", ")))
}

/// `en` or `ru`.
pub(super) fn language(text: &str) -> Result<Language, String> {
    let found = [Language::English, Language::Russian].into_iter().find(|language| language.code() == text);
    found.ok_or_else(|| format!("“{text}” is no language of reports: use en or ru"))
}

fn paper(text: &str) -> Result<Paper, String> {
    match text {
        "a4" => Ok(Paper::A4),
        "letter" => Ok(Paper::Letter),
        _ => Err(format!("“{text}” is no paper: use a4 or letter")),
    }
}
