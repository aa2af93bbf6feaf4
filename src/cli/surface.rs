//! `hemline surface`: the surface below a fitted hem with its fields, as a mesh; and the flags of surfaces that `predict` shares.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use serde_json::Value;

use super::profiles::Profiles;
use super::{folds, print};
use crate::error::Error;
use crate::experiment::campaign::Folds;
use crate::experiment::{Fabric, Skirt};
use crate::fit;
use crate::model::field::{Field, Sheet, SurfaceFields};
use crate::report::number::significant;
use crate::report::surface;
use crate::study::irregular::irregular;
use crate::study::surface::{Form, Options, of_equal_folds, of_fit, sheet};
use crate::units::{self, CENTIMETRE, KilogramPerSquareMetre, MILLIMETRE, Metre, NewtonMetre};

/// What is asked of a surface.
#[derive(Debug, Clone, Args)]
pub struct SurfaceFlags {
    /// Write the surface to this file (.glb, .gltf, .obj, .ply or .stl), coloured by --field; may be repeated
    #[arg(long, value_name = "FILE")]
    surface: Vec<PathBuf>,
    /// The field that colours it
    #[arg(long, default_value = "flexure", value_name = "FIELD", value_parser = field)]
    field: Field,
    /// Thickness of the cloth, mm: stresses need it
    #[arg(long, value_name = "MM")]
    thickness_mm: Option<f64>,
    /// Poisson's ratio of the cloth, 0 to 0.5: stresses of bending need it (the theory itself bends with 0)
    #[arg(long, value_name = "NU")]
    poisson: Option<f64>,
    /// Values at the ends of the colours, in SI units, such as 0,2e5
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    colour_range: Option<(f64, f64)>,
    /// One unit of an OBJ, PLY or STL file: m, cm, mm or in; m unless told, mm in STL. glTF is always in metres
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    mesh_unit: Option<f64>,
    /// Rings of the surface from waist to hem
    #[arg(long, default_value_t = Options::default().rows, value_name = "N")]
    rings: usize,
    /// Points round a ring, about
    #[arg(long, default_value_t = Options::default().columns, value_name = "N")]
    ring_points: usize,
}

impl SurfaceFlags {
    /// Whether a surface is wanted at all.
    pub fn wanted(&self) -> bool {
        !self.surface.is_empty()
    }

    pub fn options(&self) -> Options {
        Options { rows: self.rings, columns: self.ring_points }
    }

    /// The cloth with what the flags say of it.
    pub fn sheet(&self, fabric: &Fabric, gravity: f64) -> Sheet {
        sheet(fabric, gravity, self.thickness_mm.map(|t| Metre(t * MILLIMETRE)), self.poisson)
    }

    /// Writes the files; the paths.
    ///
    /// # Errors
    /// As [`surface::write`].
    pub fn write(&self, fields: &SurfaceFields) -> Result<Vec<PathBuf>, Error> {
        let options = surface::Options { field: self.field, unit: self.mesh_unit.map(Metre), range: self.colour_range };
        self.surface.iter().map(|path| surface::write(fields, &options, path)).collect()
    }
}

fn field(text: &str) -> Result<Field, String> {
    let names = || Field::ALL.map(Field::name).join(", ");
    Field::named(text).ok_or_else(|| format!("“{text}” is no field; there are {}", names()))
}

fn range(text: &str) -> Result<(f64, f64), String> {
    let wrong = || format!("“{text}” is no range: give two numbers, such as 0,2e5");
    let (low, high) = text.split_once(',').ok_or_else(wrong)?;
    match (low.trim().parse::<f64>(), high.trim().parse::<f64>()) {
        (Ok(low), Ok(high)) if low < high && low.is_finite() && high.is_finite() => Ok((low, high)),
        _ => Err(wrong()),
    }
}

fn unit(text: &str) -> Result<f64, String> {
    ["m", "cm", "mm", "in"].contains(&text).then(|| units::factor(text)).flatten().ok_or_else(|| "m, cm, mm or in".to_string())
}

/// The extremes of every field in words, and what was written.
pub fn to_text(fields: &SurfaceFields, written: &[PathBuf]) -> String {
    let mut out = format!("surface      {}, {} rings of {} points\n", fields.form, fields.rows, fields.columns);
    for field in Field::ALL {
        match (fields.least(field), fields.greatest(field)) {
            (Some(least), Some(greatest)) => {
                let said = |e: crate::model::field::Extreme| {
                    let [x, y, z] = e.position.map(|v| format!("{:.0}", v / MILLIMETRE));
                    format!("{} at l {:.0} mm ({x}, {y}, {z})", significant(e.value, 4), e.slant_distance / MILLIMETRE)
                };
                out += &format!("  {:<28} {} to {} {}\n", field.name(), said(least), said(greatest), field.unit());
            }
            _ => out += &format!("  {:<28} {}\n", field.name(), fields.values(field).err().unwrap_or("no value")),
        }
    }
    for path in written {
        out += &format!("written      {}\n", path.display());
    }
    out
}

/// The same as JSON.
pub fn to_json(fields: &SurfaceFields, written: &[PathBuf]) -> Value {
    let mut out = surface::extremes_json(fields);
    out["files"] = serde_json::json!(written);
    out
}

/// The surface from the waist to a measured hem: fit the hem, draw the cloth above it, give every field on it.
///
/// The hem is fitted as by `hemline fit`; the surface goes from there to the round waist of the cut. Nothing is predicted: cloth data serve the stresses alone.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  hemline surface run_01.csv --waist-radius-cm 12.1 --slant-length-cm 53 --surface skirt.glb\n  \
hemline surface run_01.csv --waist-radius-cm 12.1 --hem-radius-cm 26 --slant-length-cm 53 --form ruled --areal-density-g-m2 150 --rigidity-un-m 20 \\\n    \
--thickness-mm 0.4 --poisson 0.2 --field stress-intensity --surface skirt.ply\n\n\
Exit code: 0, or 2 if the profile could not be used or a file not be written.")]
pub struct Surface {
    #[command(flatten)]
    profiles: Profiles,
    /// Which profile, where the files hold several
    #[arg(long, value_name = "NAME")]
    profile: Option<String>,
    /// Radius of the waist ring, cm
    #[arg(long, value_name = "CM")]
    waist_radius_cm: f64,
    /// Radius of the round hem as cut, cm; the length of the fitted hem over 2π unless told
    #[arg(long, value_name = "CM")]
    hem_radius_cm: Option<f64>,
    /// Length of the cloth from waist to hem, cm
    #[arg(long, value_name = "CM")]
    slant_length_cm: f64,
    /// How the surface is drawn
    #[arg(long, value_enum, default_value_t = Drawn::Linear)]
    form: Drawn,
    /// Fold count: auto, a number, or a range such as 4-9
    #[arg(long, default_value = "auto", value_parser = folds)]
    folds: Folds,
    /// Mass per area of the cloth, g/m²
    #[arg(long, value_name = "G_M2")]
    areal_density_g_m2: Option<f64>,
    /// Flexural rigidity of the cloth per width, µN·m
    #[arg(long, value_name = "UN_M")]
    rigidity_un_m: Option<f64>,
    /// Acceleration of free fall, m/s²
    #[arg(long, default_value_t = units::STANDARD_GRAVITY, value_name = "M_S2")]
    gravity_m_s2: f64,
    #[command(flatten)]
    flags: SurfaceFlags,
    /// Print one JSON object (SI units)
    #[arg(long)]
    json: bool,
}

/// The forms by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Drawn {
    /// The paper's equation (18): p, q and s linear in height
    Linear,
    /// Straight generatrices of the cloth's own length to the paper's curve
    Ruled,
    /// Straight generatrices to equal folds of any shape
    EqualFolds,
}

/// Runs the command; prints the extremes of every field to standard output and writes the meshes.
///
/// # Errors
/// If the profile cannot be read or fitted, or the surface not be drawn or written.
pub fn run(args: &Surface) -> Result<ExitCode, Error> {
    let (mut profiles, _) = args.profiles.read()?;
    if let Some(name) = &args.profile {
        profiles.retain(|(own, _)| own == name);
    }
    let (_, profile) = match profiles.as_slice() {
        [one] => one,
        [] => return Err(Error::Unanswerable("there is no such profile in the files".into())),
        many => {
            let names: Vec<&str> = many.iter().take(8).map(|(name, _)| name.as_str()).collect();
            return Err(Error::Unanswerable(format!("{} profiles: choose one by --profile ({} …)", many.len(), names.join(", "))));
        }
    };
    let centimetres = |value: f64| Metre(value * CENTIMETRE);
    let cut_length = args.hem_radius_cm.map(|r| std::f64::consts::TAU * r * CENTIMETRE);
    let fitted = fit::fit(profile, &fit::Options { folds: args.folds, cut_length, ..fit::Options::default() })?;
    let hem_radius = args.hem_radius_cm.map_or(Metre(fitted.perimeter / std::f64::consts::TAU), centimetres);
    let skirt = Skirt::new(centimetres(args.waist_radius_cm), hem_radius, centimetres(args.slant_length_cm))?;
    let fabric = Fabric {
        areal_density: args.areal_density_g_m2.map(|d| KilogramPerSquareMetre(d * units::GRAM_PER_SQUARE_METRE)),
        flexural_rigidity: args.rigidity_un_m.map(|b| NewtonMetre(b * units::MICRONEWTON_METRE)),
    };
    let (sheet, options) = (args.flags.sheet(&fabric, args.gravity_m_s2), args.flags.options());
    let fields = match args.form {
        Drawn::Linear => of_fit(&skirt, &fitted, Form::Linear, &sheet, &options)?,
        Drawn::Ruled => of_fit(&skirt, &fitted, Form::Ruled, &sheet, &options)?,
        Drawn::EqualFolds => {
            let (_, tangent) = irregular(profile, &fitted).tangent.map_err(Error::Unanswerable)?;
            of_equal_folds(&skirt, &tangent, &sheet, &options)?
        }
    };
    let written = args.flags.write(&fields)?;
    if args.json {
        print(&format!("{:#}\n", to_json(&fields, &written)))?;
    } else {
        print(&to_text(&fields, &written))?;
    }
    Ok(ExitCode::SUCCESS)
}
