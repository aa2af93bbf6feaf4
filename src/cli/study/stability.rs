//! `hemline study stability`: hard cases at growing severity.

use std::process::ExitCode;

use clap::Args;

use super::accuracy::depth;
use super::{Common, Drawing, bar, tell};
use crate::error::Error;
use crate::report;
use crate::study::accuracy::Options;
use crate::study::stability::{computation_count, study};

/// Hard cases of fit, theory and statistics at growing severity: outcome, digits kept, condition, evaluations.
#[derive(Debug, Args)]
pub struct Stability {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    drawing: Drawing,
}

/// Runs the study. Exit code 1 if an answer was wrong without saying.
///
/// # Errors
/// [`Error::File`] if the folder cannot be written.
pub fn run(args: &Stability) -> Result<ExitCode, Error> {
    let options = Options { depth: depth(&args.common), seed: args.drawing.seed };
    let bar = bar(computation_count(options.depth), "Hard cases");
    let found = study(&options, &|| bar.inc(1));
    bar.finish_and_clear();
    tell(&report::stability::section(&found)?, &report::stability::json(&found), &args.common)?;
    Ok(if found.wrong().next().is_some() { ExitCode::from(1) } else { ExitCode::SUCCESS })
}
