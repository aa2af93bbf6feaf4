//! `hemline identify`: flexural rigidity of the cloth from the hem it hangs in.

use std::path::Path;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use rayon::prelude::*;

use super::profiles::Profiles;
use super::{folds, print};
use crate::error::Error;
use crate::experiment::Skirt;
use crate::experiment::campaign::Folds;
use crate::import;
use crate::report::identify::{runs, to_json};
use crate::report::number::{fixed, significant, with_error};
use crate::study::identify::{Identified, Through, agreement, campaign, equal_folds, identify};
use crate::units::{CENTIMETRE, GRAM_PER_SQUARE_METRE, MICRONEWTON_METRE, MILLIMETRE, MILLINEWTON, Metre, STANDARD_GRAVITY};

/// Estimate the flexural rigidity of cloth from the hem that it hangs in, with a standard error.
///
/// Weight and cut are known, the hem is measured: the rigidity is the one whose hem of as many folds, in equilibrium, has the measured coefficients of the tangent
/// angle. Where the theory does not apply, or the hem does not determine the rigidity, the reason is said instead. Given a campaign (its folder), every run
/// is identified and compared with the rigidity that the campaign knows.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hemline identify run_01.csv --areal-density-g-m2 147.8 --waist-radius-cm 12.1 --hem-radius-cm 26 --slant-length-cm 53\n  \
hemline identify data --csv > identify.csv\n\n\
The standard error is that of the hem's own scatter; how far the theory itself is from real cloth is said in docs/identify.md.\n\n\
Exit code: 0 every profile has a rigidity, 1 some has none (the reason stands in its place), 2 nothing could be read."
)]
pub struct Identify {
    #[command(flatten)]
    profiles: Profiles,
    /// Mass per area of the cloth, g/m²
    #[arg(long, value_name = "G_M2")]
    areal_density_g_m2: Option<f64>,
    /// Radius of the waist ring, cm
    #[arg(long, value_name = "CM")]
    waist_radius_cm: Option<f64>,
    /// Radius of the round hem as cut, cm
    #[arg(long, value_name = "CM")]
    hem_radius_cm: Option<f64>,
    /// Length of the cloth from waist to hem, cm
    #[arg(long, value_name = "CM")]
    slant_length_cm: Option<f64>,
    /// The energy of the theory: graded (nearer to a real skirt), ruled, or both
    #[arg(long, value_enum, default_value_t = Energies::Both)]
    through: Energies,
    /// Fold count: auto, a number, or a range such as 4-9
    #[arg(long, default_value = "auto", value_parser = folds)]
    folds: Folds,
    /// Acceleration of free fall, m/s²
    #[arg(long, default_value_t = STANDARD_GRAVITY, value_name = "M_S2")]
    gravity_m_s2: f64,
    /// Print one JSON object (SI units)
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Print a table, the columns of identify.csv
    #[arg(long)]
    csv: bool,
}

/// The energies by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Energies {
    Graded,
    Ruled,
    Both,
}

impl Energies {
    fn list(self) -> Vec<Through> {
        match self {
            Energies::Graded => vec![Through::Graded],
            Energies::Ruled => vec![Through::Ruled],
            Energies::Both => Through::ALL.to_vec(),
        }
    }
}

/// Runs the command; prints the rigidities to standard output.
///
/// # Errors
/// If nothing can be read, or weight and cut are not given.
pub fn run(args: &Identify) -> Result<ExitCode, Error> {
    let (rows, whole) = match args.profiles.files.as_slice() {
        [folder] if folder.is_dir() => of_campaign(args, folder)?,
        _ => of_profiles(args)?,
    };
    if args.json {
        print(&format!("{:#}\n", to_json(&rows, &agreement(&rows))))?;
    } else if args.csv {
        print(&String::from_utf8_lossy(&runs(&rows).bytes()))?;
    } else {
        print(&to_text(&rows))?;
    }
    if rows.is_empty() {
        return Ok(ExitCode::from(2));
    }
    let all = whole && rows.iter().all(|row| row.found.is_ok());
    Ok(if all { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

fn of_campaign(args: &Identify, folder: &Path) -> Result<(Vec<Identified>, bool), Error> {
    let imported = import::load(folder)?;
    imported.quarantine.iter().for_each(|row| eprintln!("set aside: {row}"));
    let wanted = args.through.list();
    let rows = campaign(&imported.campaign, &imported.profiles);
    Ok((rows.into_iter().filter(|row| wanted.contains(&row.through)).collect(), imported.quarantine.is_empty()))
}

fn of_profiles(args: &Identify) -> Result<(Vec<Identified>, bool), Error> {
    let needed = |value: Option<f64>, flag: &str| {
        value.ok_or_else(|| Error::Unanswerable(format!("{flag} is not given: without weight and cut a hem says nothing of its cloth")))
    };
    let density = needed(args.areal_density_g_m2, "--areal-density-g-m2")? * GRAM_PER_SQUARE_METRE;
    let length = |value: Option<f64>, flag: &str| Ok::<_, Error>(Metre(needed(value, flag)? * CENTIMETRE));
    let skirt = Skirt::new(
        length(args.waist_radius_cm, "--waist-radius-cm")?,
        length(args.hem_radius_cm, "--hem-radius-cm")?,
        length(args.slant_length_cm, "--slant-length-cm")?,
    )?;
    let weight = density * args.gravity_m_s2;
    if !(weight.is_finite() && 0.0 < weight) {
        return Err(Error::Invalid { quantity: "weight per area, N/m²", value: weight, allowed: "> 0" });
    }
    let (profiles, whole) = args.profiles.read()?;
    let rows = profiles.par_iter().flat_map_iter(|(name, profile)| {
        let hem = equal_folds(profile, &skirt, args.folds).map_err(|e| e.to_string());
        args.through.list().into_iter().map(move |through| Identified {
            run: name.clone(),
            known: None,
            through,
            found: hem.clone().and_then(|hem| identify(&skirt, weight, &hem, through).map_err(|e| e.to_string())),
        })
    });
    Ok((rows.collect(), whole))
}

fn to_text(rows: &[Identified]) -> String {
    let un = |value: f64| value / MICRONEWTON_METRE;
    let mut out = String::new();
    for row in rows {
        out += &format!("{} ({}): ", row.run, row.through.name());
        match &row.found {
            Err(reason) => out += &format!("no rigidity: {reason}\n"),
            Ok(found) => {
                out += &format!(
                    "B = {} µN·m (95 %: {} to {}), {} folds, λ = {} mN\n",
                    with_error(un(found.rigidity.value), found.rigidity.standard_error.map(un)),
                    significant(un(found.interval[0]), 3),
                    significant(un(found.interval[1]), 3),
                    found.folds,
                    with_error(found.lambda.value / MILLINEWTON, found.lambda.standard_error.map(|e| e / MILLINEWTON)),
                );
                let known = row.known.map_or_else(String::new, |k| {
                    format!("; known {} µN·m, estimated/known {}", significant(un(k), 3), fixed(found.rigidity.value / k, 2))
                });
                out += &format!(
                    "    {} coefficients, its hem misses the fitted one by {} mm rms, L is {} gravity lengths{known}\n",
                    found.harmonics,
                    fixed(found.misfit / MILLIMETRE, 1),
                    fixed(found.gravity_lengths, 0)
                );
            }
        }
    }
    for a in agreement(rows) {
        if let (Some(factor), Some(scatter)) = (a.factor, a.scatter) {
            out += &format!(
                "{}: estimated/known {} (geometric mean of {}), scatter a factor of {}\n",
                a.through.name(),
                fixed(factor, 2),
                a.compared,
                fixed(scatter, 2)
            );
        }
    }
    out
}
