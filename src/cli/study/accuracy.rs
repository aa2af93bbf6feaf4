//! `hemline study accuracy`: what accuracy costs in time.

use std::process::ExitCode;

use clap::Args;
use indicatif::ProgressBar;

use super::{Common, Drawing, bar, machine, tell};
use crate::error::Error;
use crate::experiment::Point;
use crate::experiment::campaign::{PictureScale, Pictures};
use crate::import::image;
use crate::report;
use crate::study::accuracy::picture::Picture;
use crate::study::accuracy::{Depth, Options, Progress, study};

/// Work and precision of everything that has a knob: fit, bootstrap, theory, tracing; what was asked against what was delivered.
#[derive(Debug, Args)]
pub struct Accuracy {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    drawing: Drawing,
}

/// Runs the study. Exit code 1 if an accuracy that was asked for and claimed was not delivered.
///
/// # Errors
/// Those of [`study`], and [`Error::File`] if the folder cannot be written.
pub fn run(args: &Accuracy) -> Result<ExitCode, Error> {
    let options = Options { depth: depth(&args.common), seed: args.drawing.seed };
    let bar = bar(0, "Accuracy");
    let found = study(&options, &traced, &|told| show(&bar, told))?;
    bar.finish_and_clear();
    let machine = machine();
    let section = report::accuracy::section(&found, &machine)?;
    tell(&section, &report::accuracy::json(&found, &machine), &args.common)?;
    let broken = found.panels.iter().flat_map(|panel| &panel.rows).any(|row| row.delivered() == Some(false));
    Ok(if broken { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

/// The bar goes by panels; what they compute is counted behind their name.
fn show(bar: &ProgressBar, told: Progress) {
    match told {
        Progress::Panel(name, count) => {
            let first = bar.length() != Some(count as u64);
            bar.set_length(count as u64);
            bar.inc(u64::from(!first));
            bar.set_prefix("0");
            bar.set_message(name);
        }
        Progress::Computed => {
            let computed: u64 = bar.prefix().parse().unwrap_or(0);
            bar.set_prefix((computed + 1).to_string());
        }
    }
}

pub(super) fn depth(common: &Common) -> Depth {
    match (common.quick, common.full) {
        (true, _) => Depth::Quick,
        (_, true) => Depth::Full,
        _ => Depth::Usual,
    }
}

/// The outline in a picture of the study.
pub fn traced(picture: &Picture) -> Result<Vec<Point>, Error> {
    let found = image::outline_of_pixels(picture.side, &picture.values, &Pictures::of_scale(PictureScale::Pixel(picture.pixel)))?;
    Ok(found.profile.points().to_vec())
}
