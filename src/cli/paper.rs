//! `hemline paper`: the paper, recomputed.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use crate::cli::print;
use crate::error::Error;
use crate::experiment::Fabric;
use crate::report;
use crate::simulate::Cloth;
use crate::study::paper::check;
use crate::units::{self, KilogramPerSquareMetre, NewtonMetre};

/// Recompute the paper behind the hem curve: its Table 1, its thin-shell test, its functional (10), how far its equations (15) to (17) hold along
/// its approximate solution, and where its equation (4) starts and ends; redraw its figures; and say in words what does not hold.
#[derive(Debug, Clone, Args)]
pub struct Paper {
    /// Folder for paper.txt, table1.csv, equations.csv, folds.csv, paper.json and figures 1 to 5 as SVG and PNG; made if it is not there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Mass per area of the cloth, g/m²; the paper gives none
    #[arg(long, default_value_t = 200.0, value_name = "G_M2")]
    areal_density_g_m2: f64,
    /// Flexural rigidity of the cloth per width, µN·m; the paper gives none
    #[arg(long, default_value_t = 10.0, value_name = "UN_M")]
    rigidity_un_m: f64,
    /// Foundation modulus E, N/m³; the paper's E = B/I has another unit
    #[arg(long, default_value_t = 0.0, value_name = "E")]
    foundation_n_m3: f64,
    /// Acceleration of free fall, m/s²
    #[arg(long, default_value_t = units::STANDARD_GRAVITY, value_name = "M_S2")]
    gravity_m_s2: f64,
    /// Print one JSON object (SI units) instead of words
    #[arg(long)]
    json: bool,
}

/// Runs the command: words or JSON on standard output, files if a folder is given.
///
/// # Errors
/// Those of [`check`], and [`Error::File`] if the folder cannot be written.
pub fn run(args: &Paper) -> Result<ExitCode, Error> {
    let fabric = Fabric {
        areal_density: Some(KilogramPerSquareMetre(args.areal_density_g_m2 * units::GRAM_PER_SQUARE_METRE)),
        flexural_rigidity: Some(NewtonMetre(args.rigidity_un_m * units::MICRONEWTON_METRE)),
    };
    let check = check(&Cloth::of(&fabric, args.gravity_m_s2)?, args.foundation_n_m3)?;
    let written = args.out.as_ref().map(|folder| report::paper::write(&check, folder)).transpose()?;
    if args.json {
        print(&format!("{:#}\n", report::paper::json(&check)))?;
    } else {
        let mut text = report::paper::text(&check);
        if let Some(paths) = written {
            text.push_str("\nWritten:\n");
            paths.iter().for_each(|path| text.push_str(&format!("  {}\n", path.display())));
        }
        print(&text)?;
    }
    Ok(ExitCode::SUCCESS)
}
