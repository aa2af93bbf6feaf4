//! `hemline fit`: profiles without a campaign → one row of estimates each.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use rayon::prelude::*;

use super::mesh::Frame;
use super::pictures::{PictureFlags, write_overlay};
use super::told::Told;
use super::{batch, folds, hem_length, interval_kind, level, on_off};
use crate::error::Error;
use crate::experiment::DrapeProfile;
use crate::experiment::campaign::{Folds, HemLength};
use crate::fit::intervals::Kind;
use crate::fit::lambda::Lambda;
use crate::fit::{self, HemFit, Limit, Limits, Loss};
use crate::import::image;
use crate::import::mesh;
use crate::import::table;
use crate::report;
use crate::report::table::{FitRow, fits};
use crate::report::words;
use crate::study::intervals::{self, intervals};
use crate::study::irregular::{Irregular, irregular};
use crate::units::CENTIMETRE;

/// Fit the hem curve to measured drape profiles; one row per profile on stdout.
///
/// A table has columns x_cm and y_cm (or _mm, _m), or angle and radius, and, if it holds several outlines, a column `profile` (or run, sample …); or one column
/// per angle or per profile. A picture is a silhouette, dark on light or light on dark, and needs a scale: --scale-mm-per-px, or a disc, bar or checkerboard of
/// known size in the picture (docs/images.md). Of a mesh the hem is fitted; `hemline mesh` fits the whole surface.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hemline fit outlines.csv > fits.csv\n  hemline fit shadow1.jpg shadow2.jpg --scale-mm-per-px 1.383\n  \
hemline fit photo.jpg --disc-mm 180 --overlay look\n  hemline fit photo.jpg --checkerboard-mm 10 --camera-height-mm 1500 --hem-height-mm -80\n  \
hemline fit skirt.csv --folds 6 --hem-length-cm 163.4\n  \
hemline fit skirt.csv --intervals profile --level 0.99\n  hemline fit skirt.csv --intervals bootstrap --replicates 2000 --seed 7\n  \
hemline fit skirt.csv --table models\n  hemline fit campaign.parquet --into fits\n\n\
Lengths are in mm, the phase in rad. Standard errors are those of independent errors in the points: where the curve itself fits badly\n\
(compare rms_mm and explained_share) they are too small.\n\n\
Exit code: 0 every profile is fitted, 1 some is not (stderr says which and why), 2 nothing could be read."
)]
pub struct Fit {
    /// Tables (CSV, TSV, XLSX, XLS, ODS, Parquet, Arrow, also .gz), silhouettes (.png, .jpg, .tif, .bmp) or meshes (.obj, .ply, .stl, .gltf, .glb).
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Fold count: auto (by evidence among 2 to 24), a number, or a range such as 4-9.
    #[arg(long, default_value = "auto", value_parser = folds)]
    pub folds: Folds,
    /// Hem length: auto (free; held at the outline's own length where the free optimum is no sane curve), free, or a length to hold exactly.
    #[arg(long, default_value = "auto", value_parser = hem_length, value_name = "auto|free|CM")]
    pub hem_length_cm: HemLength,
    #[command(flatten)]
    pub pictures: PictureFlags,
    /// Write each silhouette with its traced outline laid over it into this folder: look whether it is right.
    #[arg(long, value_name = "DIR")]
    pub overlay: Option<PathBuf>,
    #[command(flatten)]
    pub frame: Frame,
    /// Take out the bias that noise has where the curve bends: on, or off for the bare least-squares optimum.
    #[arg(long, default_value = "on", value_parser = on_off, value_name = "on|off", action = clap::ArgAction::Set)]
    pub bias_correction: bool,
    /// Confidence intervals: standard (Student's t), profile (likelihood), bootstrap (distances drawn anew), case-bootstrap (points drawn anew).
    #[arg(long, default_value = "standard", value_parser = interval_kind, value_name = "KIND")]
    pub intervals: Kind,
    /// Confidence level of the intervals.
    #[arg(long, default_value = "0.95", value_parser = level, value_name = "0…1")]
    pub level: f64,
    /// Replicates of a bootstrap.
    #[arg(long, default_value = "1000", value_name = "N", value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    pub replicates: u32,
    /// Seed of a bootstrap: the same seed gives the same numbers, on any number of threads.
    #[arg(long, default_value = "1", value_name = "N")]
    pub seed: u64,
    /// What is summed over the distances: l2 (least squares), or huber, tukey, cauchy, which forgive gross errors.
    #[arg(long, default_value = "l2", value_parser = loss, value_name = "l2|huber|tukey|cauchy")]
    pub loss: Loss,
    /// Hold an unknown: p, q, s, x0, y0 in cm, phase in rad, such as s=0. May be repeated.
    #[arg(long, value_parser = fixed, value_name = "NAME=VALUE")]
    pub fix: Vec<(String, Limit)>,
    /// Keep an unknown between bounds, such as q=0..5 (cm; phase in rad); an end left out is no bound. May be repeated.
    #[arg(long, value_parser = bounded, value_name = "NAME=LOW..HIGH")]
    pub bound: Vec<(String, Limit)>,
    /// What to print: fits, one row per profile; models, the paper's curve, equal folds of any shape and a free outline side by side, with the test of lack of
    /// fit; folds, one row per fold of each outline.
    #[arg(long, default_value = "fits", value_name = "fits|models|folds")]
    pub table: Print,
    /// Write JSON instead of CSV: one object per profile, null where a quantity does not exist.
    #[arg(long)]
    pub json: bool,
    /// For campaigns too large for memory, from Parquet: write the rows into this folder, part by part; a run that was stopped goes on where it was.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["json", "table", "overlay"])]
    pub into: Option<PathBuf>,
    /// Throw away the parts that the folder of --into has, and begin anew.
    #[arg(long, requires = "into")]
    pub again: bool,
    /// Rows of a part of --into, about: each thread holds one part in memory.
    #[arg(long, default_value = "262144", value_name = "N", value_parser = clap::value_parser!(u32).range(1000..=100_000_000), requires = "into")]
    pub part_rows: u32,
    #[command(flatten)]
    pub told: Told,
}

/// Which table is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Print {
    Fits,
    Models,
    Folds,
}

/// Reads, fits and prints. Files and rows that cannot be used are named on stderr; the others go on.
///
/// # Errors
/// That of the only file, if there is one only; with several files a file that cannot be read is said and left out.
pub fn run(args: &Fit) -> Result<ExitCode, Error> {
    let options = options(args)?;
    let wanted = intervals::Options { kind: args.intervals, level: args.level, replicates: args.replicates as usize, seed: args.seed };
    if let Some(folder) = &args.into {
        return batch::run(&batch::Batches {
            files: &args.files,
            folder,
            again: args.again,
            part_rows: args.part_rows as usize,
            told: &args.told,
            options,
            wanted,
        });
    }
    let mut profiles: Vec<Weighed> = Vec::new();
    let mut whole = true;
    for file in &args.files {
        let reading = Reading { pictures: &args.pictures, overlay: args.overlay.as_deref(), frame: &args.frame, told: &args.told };
        match read(file, &reading) {
            Ok((found, set_aside)) => {
                profiles.extend(found);
                for sentence in &set_aside {
                    eprintln!("set aside: {sentence}");
                }
                whole &= set_aside.is_empty();
            }
            Err(error) if args.files.len() == 1 => return Err(error),
            Err(error) => {
                eprintln!("set aside: {error}");
                whole = false;
            }
        }
    }
    let results: Vec<Result<HemFit, String>> = profiles
        .par_iter()
        .map(|(_, profile, weights)| {
            let options = fit::Options { weights: weights.clone(), ..options.clone() };
            let mut fitted = fit::fit(profile, &options).map_err(|e| e.to_string())?;
            fitted.intervals = Some(intervals(profile, &fitted, &wanted));
            Ok(fitted)
        })
        .collect();
    // Without cloth and cut there is no λ; the table says so in its own column.
    let lambda = Lambda { missing: Some("cloth and cut are not known".into()), ..Lambda::default() };
    let rows = profiles.iter().zip(&results).map(|((name, profile, _), fit)| FitRow {
        run: name,
        profile: Some(profile),
        fit,
        lambda: &lambda,
        study: None,
    });
    if args.table != Print::Fits && profiles.iter().any(|(_, _, weights)| weights.is_some()) {
        eprintln!("note: equal folds of any shape and the free outline do not use the weights of the points");
    }
    let compared: Vec<Option<Irregular>> = if args.table == Print::Fits {
        vec![]
    } else {
        profiles.par_iter().zip(&results).map(|((_, profile, _), fit)| Some(irregular(profile, fit.as_ref().ok()?))).collect()
    };
    let uneven = || profiles.iter().zip(&compared).filter_map(|((name, ..), i)| Some((name.as_str(), i.as_ref()?)));
    let table = match args.table {
        Print::Fits => fits(rows),
        Print::Models => report::irregular::models(uneven()),
        Print::Folds => report::irregular::folds(uneven()),
    };
    let stdout = &mut std::io::stdout().lock();
    let written = if args.json { table.write_json(stdout) } else { table.write(stdout) };
    match written {
        // Somebody closed the pipe: `hemline fit … | head` is no fault.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => return Ok(ExitCode::SUCCESS),
        other => other.map_err(|source| Error::file("stdout", source))?,
    }
    for ((name, ..), result) in profiles.iter().zip(&results) {
        if let Err(reason) = result {
            eprintln!("not fitted: {name}: {reason}");
            whole = false;
        }
    }
    if profiles.is_empty() {
        return Ok(ExitCode::from(2));
    }
    Ok(if whole { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// What is asked of every fit.
fn options(args: &Fit) -> Result<fit::Options, Error> {
    Ok(fit::Options {
        folds: args.folds,
        length: args.hem_length_cm,
        bias_correction: args.bias_correction,
        limits: limits(args)?,
        loss: args.loss,
        ..fit::Options::default()
    })
}

/// Parses the name of a loss.
fn loss(text: &str) -> Result<Loss, String> {
    match text {
        "l2" => Ok(Loss::Squares),
        "huber" => Ok(Loss::HUBER),
        "tukey" => Ok(Loss::TUKEY),
        "cauchy" => Ok(Loss::CAUCHY),
        _ => Err("l2, huber, tukey or cauchy".into()),
    }
}

/// Parses `s=0`.
fn fixed(text: &str) -> Result<(String, Limit), String> {
    let (name, value) = unknown(text)?;
    Ok((name.to_string(), Limit::At(quantity(name, value)?)))
}

/// Parses `q=0..5`, `q=..5` or `q=0..`.
fn bounded(text: &str) -> Result<(String, Limit), String> {
    let (name, range) = unknown(text)?;
    let (low, high) = range.split_once("..").ok_or("bounds are written LOW..HIGH, such as q=0..5")?;
    let end = |text: &str, none: f64| if text.trim().is_empty() { Ok(none) } else { quantity(name, text) };
    let limit = Limit::Between(end(low, f64::NEG_INFINITY)?, end(high, f64::INFINITY)?);
    limit.check(name).map_err(|_| "the lower bound must be below the upper one".to_string())?;
    Ok((name.to_string(), limit))
}

/// The name of an unknown, and what stands after the equals sign.
fn unknown(text: &str) -> Result<(&str, &str), String> {
    let (name, value) = text.split_once('=').ok_or("an unknown and its value are written NAME=VALUE, such as s=0")?;
    let name = name.trim();
    if Limits::default().of(name).is_none() {
        return Err(format!("there is no unknown “{name}”; there are p, q, s, x0, y0 and phase"));
    }
    Ok((name, value))
}

/// A length in cm, or an angle in rad.
fn quantity(name: &str, text: &str) -> Result<f64, String> {
    let value: f64 = text.trim().parse().map_err(|_| format!("“{text}” is no number"))?;
    if !value.is_finite() {
        return Err(format!("“{text}” is no finite number"));
    }
    Ok(if name == "phase" { value } else { value * CENTIMETRE })
}

/// The limits asked for.
fn limits(args: &Fit) -> Result<Limits, Error> {
    let mut limits = Limits::default();
    for (name, limit) in args.fix.iter().chain(&args.bound) {
        let place = limits.of(name).expect("names are checked as they are parsed");
        if *place != Limit::Free {
            return Err(Error::Unanswerable(format!("{name} is fixed or bounded twice")));
        }
        *place = *limit;
    }
    limits.check()?;
    Ok(limits)
}

/// How files of profiles are read.
pub(super) struct Reading<'a> {
    pub pictures: &'a PictureFlags,
    /// Where each silhouette goes with its traced outline laid over it.
    pub overlay: Option<&'a std::path::Path>,
    pub frame: &'a Frame,
    pub told: &'a Told,
}

/// The profiles of one file, and what was set aside, in sentences.
type Read = (Vec<Weighed>, Vec<String>);

/// A profile with its name and, where the table has them, the weights of its points.
type Weighed = (String, DrapeProfile, Option<Vec<f64>>);

/// Reads the profiles of one file: a table, a silhouette or a mesh.
pub(super) fn read(file: &std::path::Path, args: &Reading<'_>) -> Result<Read, Error> {
    if image::is_picture(file) {
        let Some(options) = args.pictures.options() else {
            return Err(Error::Unanswerable(format!(
                "{}: a silhouette needs its scale; add --scale-mm-per-px, or --disc-mm, --bar-mm or --checkerboard-mm for what it shows",
                file.display()
            )));
        };
        let silhouette = image::outline(file, &options)?;
        for note in silhouette.reading.iter().chain(&silhouette.notes) {
            eprintln!("note: {}: {note}", file.display());
        }
        let name = stem(file);
        if let Some(folder) = args.overlay {
            // With its extension: a.png and a.jpg are two pictures.
            let whole = file.file_name().map_or_else(|| name.clone(), |whole| whole.to_string_lossy().into_owned());
            let drawing = write_overlay(&name, &words::file_stem(&whole.replace('.', "_")), &silhouette, folder)?;
            eprintln!("drawn: {}", drawing.display());
        }
        return Ok((vec![(name, silhouette.profile, None)], vec![]));
    }
    if mesh::is_mesh(file) {
        let hem = mesh::hem(file, &mesh::Options { frame: args.frame.meshes(), ..mesh::Options::default() })?;
        for note in &hem.notes {
            eprintln!("note: {}: {note}", file.display());
        }
        return Ok((vec![(stem(file), hem.profile, None)], vec![]));
    }
    let table = table::read(file, &args.told.dialect())?;
    for note in &table.notes {
        eprintln!("note: {}: {note}", file.display());
    }
    let profiles = table.profiles.into_iter().map(|p| {
        let weights = (!p.weights.is_empty()).then(|| p.profile.source_index().iter().map(|&i| p.weights[i]).collect());
        (p.name, p.profile, weights)
    });
    let profiles = profiles.collect();
    Ok((profiles, table.quarantine.iter().map(ToString::to_string).collect()))
}

/// What a profile is called whose file holds only one.
fn stem(file: &std::path::Path) -> String {
    file.file_stem().map_or_else(|| file.display().to_string(), |stem| stem.to_string_lossy().into_owned())
}
