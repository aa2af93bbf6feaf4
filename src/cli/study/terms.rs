//! `hemline study terms`: what an effect is worth, term by term.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::accuracy::depth;
use super::{Common, bar, machine, tell};
use crate::error::Error;
use crate::import::{self, scene_file};
use crate::report;
use crate::study::clock::Clock;
use crate::study::terms::{PARTS, fidelity, grid, scenes_of, study};

/// What each effect is worth: every energy term switched off and on, how far the hem moves, what changes, and what the automatic choice thought.
///
/// For one scene (--scene), for every treatment of a campaign (--campaign), or over a grid of skirts from soft to stiff, short to long, with and
/// without hips. --quick and --full are sizes of that grid; a quick look also has fewer harmonics, whatever it looks at.
#[derive(Debug, Args)]
pub struct Terms {
    /// One scene (docs/terms.md)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["campaign", "full"])]
    scene: Option<PathBuf>,
    /// A campaign folder
    #[arg(long, value_name = "DIR", conflicts_with = "full")]
    campaign: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// Runs the study. Exit code 1 if some scene has no answer.
///
/// # Errors
/// If the scene or campaign cannot be read, and [`Error::File`] if the folder cannot be written.
pub fn run(args: &Terms) -> Result<ExitCode, Error> {
    let depth = depth(&args.common);
    let scenes = match (&args.scene, &args.campaign) {
        (Some(path), _) => {
            let scene = scene_file::read(path)?;
            vec![(scene.title.clone().unwrap_or_else(|| path.display().to_string()), scene)]
        }
        (None, Some(folder)) => scenes_of(&import::load(folder)?.campaign),
        (None, None) => grid(depth),
    };
    let bar = bar(PARTS * scenes.len(), "Hems");
    let found = study(scenes, fidelity(depth), &Clock::of(depth), &|| bar.inc(1));
    bar.finish_and_clear();
    tell(&report::terms::section(&found, &machine())?, &report::terms::json(&found), &args.common)?;
    let usable = found.scenes.iter().all(|(_, answer)| answer.is_ok());
    Ok(if usable { ExitCode::SUCCESS } else { ExitCode::from(1) })
}
