//! One file per command: arguments → options → library call → report.

mod batch;
pub mod check;
pub mod fit;
pub mod identify;
pub mod import;
pub mod init;
mod memory;
pub mod mesh;
pub mod paper;
mod pictures;
pub mod plot;
pub mod predict;
mod profiles;
pub mod regress;
pub mod report;
pub mod run;
mod study;
pub mod skirt;
pub mod surface;
pub mod told;
pub mod workbook;

use std::io::Write;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};

use crate::error::Error;
use crate::experiment::campaign::{Folds, HemLength};
use crate::fit::intervals::Kind;
use crate::import::Imported;
use crate::report::Progress;
use crate::study::campaign::{CampaignStudy, Measured, analyse};
use crate::units::CENTIMETRE;

/// How cloth drapes: fits the hem curve to measured drape profiles, predicts the hem from cloth and cut, runs the factorial regression, and
/// writes a report.
#[derive(Debug, Parser)]
#[command(
    name = "hemline",
    version,
    after_help = "Without a command, `hemline` analyses the campaign in data/ and writes reports/, like `hemline run`.\n\n\
Exit code: 0 all is usable, 1 finished but something is not usable (it is named), 2 the input could not be used."
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(run::Run),
    Report(report::Report),
    Fit(fit::Fit),
    Mesh(mesh::Mesh),
    Predict(predict::Predict),
    Regress(regress::Regress),
    Check(check::Check),
    Init(init::Init),
    Import(import::Import),
    Paper(paper::Paper),
    Plot(plot::Plot),
    Study(study::Study),
    Skirt(skirt::SkirtArgs),
    Surface(surface::Surface),
    Identify(identify::Identify),
}

/// Parses the command line and runs it.
pub fn run() -> ExitCode {
    let cli = Cli::parse();
    let outcome = match cli.command.unwrap_or(Command::Run(run::Run::default())) {
        Command::Run(args) => run::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Fit(args) => fit::run(&args),
        Command::Mesh(args) => mesh::run(&args),
        Command::Predict(args) => predict::run(&args),
        Command::Regress(args) => regress::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Init(args) => init::run(&args),
        Command::Import(args) => import::run(&args),
        Command::Paper(args) => paper::run(&args),
        Command::Plot(args) => plot::run(&args),
        Command::Study(args) => study::run(&args),
        Command::Skirt(args) => skirt::run(&args),
        Command::Surface(args) => surface::run(&args),
        Command::Identify(args) => identify::run(&args),
    };
    outcome.unwrap_or_else(|error: Error| {
        eprintln!("hemline: {error}");
        ExitCode::from(2)
    })
}

/// A bar for `runs` runs; drawn on a terminal only, in a pipe indicatif is silent.
fn progress(runs: usize, message: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}").expect("a template that indicatif knows");
    let bar = ProgressBar::new(runs as u64).with_style(style.progress_chars("━╸ "));
    bar.set_message(message);
    bar
}

/// Says what was set aside on reading, one sentence each, and analyses the rest; the progress bar goes on to what comes next.
fn analysed(imported: Imported) -> (CampaignStudy, ProgressBar) {
    imported.quarantine.iter().for_each(|row| eprintln!("set aside: {row}"));
    let Imported { campaign, profiles, quarantine, sources, notes, .. } = imported;
    let bar = progress(campaign.design.runs.len(), "Fitting");
    let study = analyse(Measured { campaign, profiles, quarantine, sources, notes }, &|| bar.inc(1));
    (study, bar)
}

/// Moves the bar on by the steps of a report.
fn steps(bar: &ProgressBar) -> impl Fn(Progress) + Sync + '_ {
    |told| match told {
        Progress::Ahead(steps) => bar.inc_length(steps as u64),
        Progress::Step => bar.inc(1),
    }
}

/// Writes to stdout. Somebody who closed the pipe (`hemline … | head`) has read enough: no fault.
fn print(text: &str) -> Result<(), Error> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(fault) if fault.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::file("stdout", fault)),
        _ => Ok(()),
    }
}

/// `auto`, `6` or `4-9`.
fn folds(text: &str) -> Result<Folds, String> {
    let wrong = || format!("“{text}” is no fold count: use auto, a number such as 6, or a range such as 4-9");
    let count = |text: &str| text.trim().parse::<u32>().ok().filter(|m| (2..=200).contains(m)).ok_or_else(wrong);
    match text.split_once('-') {
        _ if text == "auto" => Ok(Folds::default()),
        Some((from, to)) => match (count(from)?, count(to)?) {
            (from, to) if from <= to => Ok(Folds::Among { from, to }),
            _ => Err(wrong()),
        },
        None => Ok(Folds::Exactly(count(text)?)),
    }
}

/// `auto`, `free` or a length in cm.
fn hem_length(text: &str) -> Result<HemLength, String> {
    match text {
        "auto" => Ok(HemLength::Auto),
        "free" => Ok(HemLength::Free),
        _ => match text.parse::<f64>() {
            Ok(length) if length.is_finite() && 0.0 < length => Ok(HemLength::Held(length * CENTIMETRE)),
            _ => Err(format!("“{text}” is no hem length: use auto, free, or a length in cm such as 163.4")),
        },
    }
}

/// Dots per inch.
fn dots(text: &str) -> Result<f64, String> {
    let wrong = || format!("“{text}” is no number of dots per inch: use one from 20 to 2400, such as 300");
    text.parse::<f64>().ok().filter(|dots| (20.0..=2400.0).contains(dots)).ok_or_else(wrong)
}

/// `on` or `off`.
fn on_off(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err(format!("“{text}” is neither on nor off")),
    }
}

/// A kind of confidence interval.
fn interval_kind(text: &str) -> Result<Kind, String> {
    let kinds = [Kind::Standard, Kind::Profile, Kind::Bootstrap, Kind::CaseBootstrap];
    let found = kinds.into_iter().find(|kind| kind.name() == text);
    found.ok_or_else(|| format!("“{text}” is no kind of interval: use standard, profile, bootstrap or case-bootstrap"))
}

/// A confidence level.
fn level(text: &str) -> Result<f64, String> {
    let wrong = || format!("“{text}” is no confidence level: use a number such as 0.95, from 0.5 to 0.9999");
    text.parse::<f64>().ok().filter(|level| (0.5..=0.9999).contains(level)).ok_or_else(wrong)
}
