//! `hemline study`: the three studies, each a subcommand.

mod accuracy;
mod stability;
mod terms;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};

use crate::error::Error;
use crate::report;
use crate::report::section::Section;
use crate::report::study_section::{Machine, StudySection, markdown, write};
use crate::study::accuracy::{Depth, Options};
use crate::study::clock::Clock;
use crate::study::terms::{fidelity, grid, study as terms_study};

/// Study the program itself: what accuracy costs in time, how far it can be trusted on hard cases, and what each effect is worth.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hemline study accuracy --out studies\n  hemline study stability --out studies --full\n  hemline study terms --out studies"
)]
pub struct Study {
    #[command(subcommand)]
    which: Which,
}

#[derive(Debug, Subcommand)]
enum Which {
    Accuracy(accuracy::Accuracy),
    Stability(stability::Stability),
    Terms(terms::Terms),
}

/// Runs the study that is named.
///
/// # Errors
/// Those of the study, and [`Error::File`] if its files cannot be written.
pub fn run(args: &Study) -> Result<ExitCode, Error> {
    match &args.which {
        Which::Accuracy(args) => accuracy::run(args),
        Which::Stability(args) => stability::run(args),
        Which::Terms(args) => terms::run(args),
    }
}

/// What every study takes.
#[derive(Debug, Args)]
struct Common {
    /// Folder for the tables (CSV), figures (SVG, PNG) and a page of text (.md); made if it is not there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Look deeper: finer sweeps and more draws, minutes instead of one
    #[arg(long)]
    full: bool,
    /// Seconds only: every question, few of its settings
    #[arg(long, conflicts_with = "full")]
    quick: bool,
    /// Print one JSON object (SI units) instead of words
    #[arg(long)]
    json: bool,
}

/// What a study takes that draws data.
#[derive(Debug, Args)]
struct Drawing {
    /// Seed of everything that is drawn
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
}

/// Every study at its quickest, as chapters of a report, in the order of docs/studies.md.
///
/// # Errors
/// Those of the studies.
pub(super) fn chapters(bar: &ProgressBar) -> Result<Vec<Section>, Error> {
    let options = Options { depth: Depth::Quick, seed: 1 };
    bar.set_message("Studies");
    bar.inc_length(3);
    let step = || bar.inc(1);
    let machine = machine();
    let accuracy = report::accuracy::section(&crate::study::accuracy::study(&options, &accuracy::traced, &|_| ())?, &machine)?;
    step();
    let stability = report::stability::section(&crate::study::stability::study(&options, &|| ()))?;
    step();
    let quick = terms_study(grid(Depth::Quick), fidelity(Depth::Quick), &Clock::of(Depth::Quick), &|| ());
    let terms = report::terms::section(&quick, &machine)?;
    step();
    Ok([accuracy, stability, terms].iter().map(StudySection::chapter).collect())
}

/// Writes the files where a folder is given, and prints the words or the JSON object.
fn tell(section: &StudySection, json: &serde_json::Value, args: &Common) -> Result<(), Error> {
    let written = args.out.as_deref().map(|folder: &Path| write(section, folder)).transpose()?;
    if args.json {
        return super::print(&format!("{json:#}\n"));
    }
    let mut text = match written {
        // The page names its files; on a terminal they are only there if they were written.
        Some(_) => String::new(),
        None => markdown(&StudySection { figures: Vec::new(), ..section.clone() }),
    };
    if let Some(paths) = &written {
        text = format!("{}\n\n{}\n\nWritten:\n", section.title, section.sentences.join("\n"));
        paths.iter().for_each(|path| text.push_str(&format!("  {}\n", path.display())));
    }
    super::print(&text)
}

/// The processor and system, and the threads that the program may use.
fn machine() -> Machine {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_string())
    });
    let name = format!("{}, {}", cpu.unwrap_or_else(|| std::env::consts::ARCH.into()), std::env::consts::OS);
    Machine { name, threads: rayon::current_num_threads() }
}

/// A bar for `steps` steps that shows the time gone, so that it moves while a long step lasts; drawn on a terminal only.
fn bar(steps: usize, message: &'static str) -> ProgressBar {
    let bar = super::progress(steps, message);
    let style = ProgressStyle::with_template("{msg} {prefix} {wide_bar} {pos}/{len} {elapsed}").expect("a template that indicatif knows");
    bar.set_style(style.progress_chars("━╸ "));
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}
