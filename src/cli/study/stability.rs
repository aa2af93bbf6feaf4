//! `hemline study stability`: hard cases at growing severity.

use std::process::ExitCode;

use clap::Args;

use super::Common;
use crate::error::Error;

/// Hard cases
#[derive(Debug, Args)]
pub struct Stability {
    #[command(flatten)]
    common: Common,
}

pub fn run(args: &Stability) -> Result<ExitCode, Error> {
    let _ = &args.common;
    Ok(ExitCode::SUCCESS)
}
