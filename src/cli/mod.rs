//! One file per command: arguments → options → library call → report.

pub mod check;
pub mod fit;
pub mod init;
pub mod mesh;
pub mod paper;
pub mod predict;
pub mod regress;
pub mod run;

use std::io::Write;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};

use crate::error::Error;
use crate::experiment::campaign::{Folds, HemLength, Shade};
use crate::import::Imported;
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
    Fit(fit::Fit),
    Mesh(mesh::Mesh),
    Predict(predict::Predict),
    Regress(regress::Regress),
    Check(check::Check),
    Init(init::Init),
    Paper(paper::Paper),
}

/// Parses the command line and runs it.
pub fn run() -> ExitCode {
    let cli = Cli::parse();
    let outcome = match cli.command.unwrap_or(Command::Run(run::Run::default())) {
        Command::Run(args) => run::run(&args),
        Command::Fit(args) => fit::run(&args),
        Command::Mesh(args) => mesh::run(&args),
        Command::Predict(args) => predict::run(&args),
        Command::Regress(args) => regress::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Init(args) => init::run(&args),
        Command::Paper(args) => paper::run(&args),
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
    let Imported { campaign, profiles, quarantine, sources, notes } = imported;
    let bar = progress(campaign.design.runs.len(), "Fitting");
    let study = analyse(Measured { campaign, profiles, quarantine, sources, notes }, &|| bar.inc(1));
    (study, bar)
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

/// `auto`, `dark` or `light`.
fn shade(text: &str) -> Result<Shade, String> {
    match text {
        "auto" => Ok(Shade::Auto),
        "dark" => Ok(Shade::Dark),
        "light" => Ok(Shade::Light),
        _ => Err(format!("“{text}” is no shade: use auto, dark or light")),
    }
}
