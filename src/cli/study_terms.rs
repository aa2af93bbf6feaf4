//! `hemline study terms`: what an effect is worth, term by term.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use serde_json::{Value, json};

use crate::cli::print;
use crate::error::Error;
use crate::experiment::scene::Term;
use crate::import::{self, scene_file};
use crate::report::output;
use crate::simulate::scene::HemNumbers;
use crate::study::terms::{SceneTerms, grid, map, of_campaign, of_scene};
use crate::units::{MILLIMETRE, MILLINEWTON};

/// Switch every energy term off and on: how far the hem moves, what changes, what it saves, and what the screen thought.
///
/// For one scene (--scene), for every treatment of a campaign (--campaign), or over a grid of skirts from soft to stiff, short to long, with and
/// without hips.
#[derive(Debug, Clone, Args)]
pub struct Terms {
    /// One scene (docs/terms.md)
    #[arg(long, value_name = "FILE", conflicts_with = "campaign")]
    scene: Option<PathBuf>,
    /// A campaign folder
    #[arg(long, value_name = "DIR")]
    campaign: Option<PathBuf>,
    /// Folder for terms.csv and terms_map.csv
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON array (SI units)
    #[arg(long)]
    json: bool,
}

/// Runs the study.
///
/// # Errors
/// If the scene or campaign cannot be read, or no theory applies to the scene.
pub fn run(args: &Terms) -> Result<ExitCode, Error> {
    let started = Instant::now();
    let answers = match (&args.scene, &args.campaign) {
        (Some(path), _) => {
            let scene = scene_file::read(path)?;
            let name = scene.title.clone().unwrap_or_else(|| path.display().to_string());
            let study = of_scene(&name, &scene, None)?;
            vec![(name, Ok(study))]
        }
        (None, Some(folder)) => of_campaign(&import::load(folder)?.campaign),
        (None, None) => grid(),
    };
    let seconds = started.elapsed().as_secs_f64();
    if let Some(folder) = &args.out {
        output::write(folder, "terms.csv", csv(&answers).as_bytes())?;
        output::write(folder, "terms_map.csv", map_csv(&answers).as_bytes())?;
    }
    if args.json {
        let one = |(name, answer): &(String, Result<SceneTerms, Error>)| match answer {
            Ok(study) => json!(study),
            Err(why) => json!({ "name": name, "missing": why.to_string() }),
        };
        print(&format!("{}\n", answers.iter().map(one).collect::<Value>()))?;
    } else {
        print(&text(&answers))?;
        print(&format!("{} scenes in {seconds:.1} s\n", answers.len()))?;
    }
    let usable = answers.iter().all(|(_, answer)| answer.is_ok());
    Ok(if usable { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

type Answers = [(String, Result<SceneTerms, Error>)];

fn text(answers: &Answers) -> String {
    let mut out = String::new();
    let show = |value: Option<f64>| value.map_or("–".into(), |m| format!("{:.3}", m / MILLIMETRE));
    for (name, answer) in answers {
        let study = match answer {
            Ok(study) => study,
            Err(why) => {
                out += &format!("{name}: {why}\n\n");
                continue;
            }
        };
        out += &format!("{name}: {} folds under {}\n", study.folds, study.chosen.names());
        out += &format!(
            "  {:<13} {:<4} {:>10} {:>12} {:>9} {:>22} {:>19}\n",
            "term", "is", "moves, mm", "estimate, mm", "folds", "lambda with/out, mN", "evaluations"
        );
        for row in &study.rows {
            let pair = |f: &dyn Fn(&HemNumbers) -> String| {
                let one = |hem: &Option<HemNumbers>| hem.as_ref().map_or("–".into(), f);
                format!("{}/{}", one(&row.with), one(&row.without))
            };
            out += &format!(
                "  {:<13} {:<4} {:>10} {:>12} {:>9} {:>22} {:>19}{}\n",
                row.term.name(),
                if row.screened.on { "on" } else { "off" },
                show(row.movement),
                show(row.screened.movement),
                pair(&|hem| hem.folds.to_string()),
                pair(&|hem| hem.multiplier.map_or("–".into(), |value| format!("{:.4}", value / MILLINEWTON))),
                pair(&|hem| hem.evaluations.to_string()),
                row.missing.as_ref().map_or(String::new(), |why| format!("  {why}"))
            );
        }
        out.push('\n');
    }
    out
}

fn csv(answers: &Answers) -> String {
    let header = "scene,term,on,number,estimate_mm,movement_mm,folds_with,folds_without,lambda_with_n,lambda_without_n,evaluations_with,evaluations_without,why";
    let mut out = format!("{header}\n");
    let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for (name, answer) in answers {
        let Ok(study) = answer else { continue };
        for row in &study.rows {
            let (with, without) = (row.with.as_ref(), row.without.as_ref());
            let folds = |hem: Option<&HemNumbers>| hem.map_or(String::new(), |hem| hem.folds.to_string());
            let count = |hem: Option<&HemNumbers>| hem.map_or(String::new(), |hem| hem.evaluations.to_string());
            let cells = [
                format!("\"{}\"", name.replace('"', "\"\"")),
                row.term.name().into(),
                row.screened.on.to_string(),
                number(row.screened.number),
                number(row.screened.movement.map(|m| m / MILLIMETRE)),
                number(row.movement.map(|m| m / MILLIMETRE)),
                folds(with),
                folds(without),
                number(with.and_then(|hem| hem.multiplier)),
                number(without.and_then(|hem| hem.multiplier)),
                count(with),
                count(without),
                format!("\"{}\"", row.missing.as_ref().unwrap_or(&row.screened.why).replace('"', "\"\"")),
            ];
            out += &format!("{}\n", cells.join(","));
        }
    }
    out
}

fn map_csv(answers: &Answers) -> String {
    let mut out = format!("scene,{}\n", Term::ALL.map(|term| format!("{}_mm", term.name())).join(","));
    for (name, movements) in map(answers) {
        let cells = movements.map(|m| m.map_or(String::new(), |m| m.to_string()));
        out += &format!("\"{}\",{}\n", name.replace('"', "\"\""), cells.join(","));
    }
    out
}
