//! `hemline mesh`: a surface mesh of a drape → its horizontal sections, its hem, and the fit of the surface (18).

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::{folds, hem_length, print};
use crate::error::Error;
use crate::experiment::campaign::{Folds, HemLength, Meshes};
use crate::fit;
use crate::fit::surface::SurfaceFit;
use crate::import::mesh::{self, Cut, DrapeMesh};
use crate::units::{self, MILLIMETRE, Metre, PERCENT};

mod document;
mod text;

/// Cut a surface mesh of a drape into horizontal sections and fit the paper's surface to them.
///
/// The mesh (OBJ, PLY, STL, glTF) is an open sheet that ends at the hem, or the closed skin of a thick one. Without --heights-mm or --every-mm, sections
/// are spread evenly between the highest point of the hem and the lowest of the waist.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hemline mesh scan.ply --unit mm\n  hemline mesh scan.obj --heights-mm 50,100,200 --sections > sections.csv\n  \
hemline mesh skirt.glb --count 20 --json > surface.json\n\n\
Surface: p(z) = a1 + b1 z, q(z) = a2 + b2 z, s(z) = a3 + b3 z; z is the height in mm above the lowest point, unless --zero says otherwise.\n\n\
Exit code: 0 every section is closed and the surface is fitted, 1 something is missing (it is named), 2 the mesh could not be used."
)]
pub struct Mesh {
    /// The mesh (.obj, .ply, .stl, .gltf, .glb).
    pub file: PathBuf,
    #[command(flatten)]
    pub frame: Frame,
    /// Heights of the sections.
    #[arg(long, value_name = "MM,MM", value_delimiter = ',', allow_negative_numbers = true, conflicts_with_all = ["every_mm", "count"])]
    pub heights_mm: Vec<f64>,
    /// A section at every multiple of this height.
    #[arg(long, value_name = "MM", conflicts_with = "count")]
    pub every_mm: Option<f64>,
    /// So many sections, evenly spread.
    #[arg(long, default_value_t = 12, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub count: u16,
    /// Where heights are counted from.
    #[arg(long, value_enum, default_value_t = Zero::Lowest)]
    pub zero: Zero,
    /// Holes are bridged up to this share of a section.
    #[arg(long, value_name = "PERCENT", default_value_t = 5.0)]
    pub largest_gap_percent: f64,
    /// Fold count: auto, a number, or a range such as 4-9.
    #[arg(long, default_value = "auto", value_parser = folds)]
    pub folds: Folds,
    /// Hem length of each section's own fit: auto, free, or a length to hold.
    #[arg(long, default_value = "auto", value_parser = hem_length, value_name = "auto|free|CM")]
    pub hem_length_cm: HemLength,
    /// Print the points of all sections as a table: section, x_mm, y_mm, z_mm.
    #[arg(long, conflicts_with_all = ["distances", "json"])]
    pub sections: bool,
    /// Print the distance of every measured point from the fitted surface as a table.
    #[arg(long, conflicts_with = "json")]
    pub distances: bool,
    /// Print everything as JSON, null where a quantity does not exist.
    #[arg(long)]
    pub json: bool,
}

/// The frame of a mesh, where the file does not say it.
#[derive(Debug, Args, Clone, Copy, Default)]
pub struct Frame {
    /// Upward direction in a mesh: auto, x, -x, y, -y, z, -z, or a vector such as 0,0.1,1.
    #[arg(long, default_value = "auto", value_parser = direction, allow_hyphen_values = true, value_name = "AXIS")]
    pub axis: Direction,
    /// Unit of the coordinates of a mesh: auto, um, mm, cm, m or in.
    #[arg(long, default_value = "auto", value_parser = unit, value_name = "UNIT")]
    pub unit: Unit,
}

impl Frame {
    /// What the reader of meshes takes.
    pub fn meshes(self) -> Meshes {
        Meshes { axis: self.axis.0, unit: self.unit.0 }
    }
}

/// A direction, or to be found.
#[derive(Debug, Clone, Copy, Default)]
pub struct Direction(pub Option<[f64; 3]>);

/// A unit of length, or to be told from the size.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unit(pub Option<Metre>);

/// Where heights are counted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Zero {
    /// The lowest point of the mesh.
    Lowest,
    /// The highest point of the mesh.
    Highest,
    /// The origin of the file.
    File,
}

/// Reads, cuts, fits and prints.
///
/// # Errors
/// If the mesh cannot be read, or its axis or unit cannot be told.
pub fn run(args: &Mesh) -> Result<ExitCode, Error> {
    let zero = match args.zero {
        Zero::Lowest => mesh::Zero::Lowest,
        Zero::Highest => mesh::Zero::Highest,
        Zero::File => mesh::Zero::File,
    };
    let options = mesh::Options { frame: args.frame.meshes(), zero, largest_gap: args.largest_gap_percent * PERCENT };
    let mesh = mesh::read(&args.file, &options)?;
    mesh.notes.iter().for_each(|note| eprintln!("note: {}: {note}", args.file.display()));
    let cuts: Vec<Cut> = heights(args, &mesh)?.into_iter().map(|height| mesh.cut(height)).collect();
    for cut in &cuts {
        if let Err(reason) = &cut.outline {
            eprintln!("no section at {:.1} mm: {reason}", cut.height / MILLIMETRE);
        }
    }
    let mut whole = cuts.iter().all(|cut| cut.outline.is_ok());
    if args.sections {
        print(&String::from_utf8_lossy(&document::sections(&cuts).bytes()))?;
        return Ok(ExitCode::from(u8::from(!whole)));
    }
    let fitting = fit::Options { folds: args.folds, length: args.hem_length_cm, ..fit::Options::default() };
    let surface: Result<SurfaceFit, String> = fit::surface::fit(&mesh.measured(&cuts), &fitting).map_err(|e| e.to_string());
    match &surface {
        Ok(surface) => surface.notes.iter().for_each(|note| eprintln!("note: {note}")),
        Err(reason) => eprintln!("no surface: {reason}"),
    }
    whole &= surface.is_ok();
    match &surface {
        _ if args.json => print(&document::json(&mesh, &cuts, &surface)?)?,
        Ok(surface) if args.distances => print(&String::from_utf8_lossy(&document::distances(surface).bytes()))?,
        _ => print(&text::text_of(&mesh, &cuts, &surface))?,
    }
    Ok(ExitCode::from(u8::from(!whole)))
}

fn heights(args: &Mesh, mesh: &DrapeMesh) -> Result<Vec<f64>, Error> {
    if !args.heights_mm.is_empty() {
        if let Some(&value) = args.heights_mm.iter().find(|height| !height.is_finite()) {
            return Err(Error::Invalid { quantity: "a height, mm", value, allowed: "finite numbers" });
        }
        return Ok(args.heights_mm.iter().map(|height| height * MILLIMETRE).collect());
    }
    match args.every_mm {
        Some(step) if !(0.0 < step && step.is_finite()) => Err(Error::Invalid { quantity: "--every-mm", value: step, allowed: "> 0" }),
        Some(step) => Ok(mesh.heights_every(step * MILLIMETRE)),
        None => Ok(mesh.heights(usize::from(args.count))),
    }
}

/// `auto`, `z`, `-y` or `0,0.1,1`.
fn direction(text: &str) -> Result<Direction, String> {
    if text == "auto" {
        return Ok(Direction(None));
    }
    let wrong = || format!("“{text}” is no axis: use auto, x, -x, y, -y, z, -z, or a vector such as 0,0.1,1");
    mesh::direction_named(text).map(|axis| Direction(Some(axis))).ok_or_else(wrong)
}

/// `auto` or a unit of length.
fn unit(text: &str) -> Result<Unit, String> {
    match text {
        "auto" => Ok(Unit(None)),
        "um" | "mm" | "cm" | "m" | "in" => Ok(Unit(units::factor(text).map(Metre))),
        _ => Err(format!("“{text}” is no unit of a mesh: use auto, um, mm, cm, m or in")),
    }
}
