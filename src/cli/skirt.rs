//! `hemline skirt`: the cone of a skirt from a body or from radii, its flat pattern, and whether hips touch it.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use crate::cli::print;
use crate::error::Error;
use crate::experiment::Skirt;
use crate::experiment::scene::BodyShape;
use crate::model::body::{Body, HipGap, cloth_area};
use crate::model::pattern::{self, Pattern};
use crate::model::skirt::{Cone, from_body, thinness};
use crate::report::pattern::{Paper, write};
use crate::units::{CENTIMETRE, DEGREE, MILLIMETRE, Metre};

/// The cone of a skirt: radii, angles and height, its flat pattern to scale, and whether hips touch it.
///
/// From a body (waist and hip girth, height between them) the skirt is the cone through both; from radii it is what they say, and a body may be given beside
/// them.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  hemline skirt --waist-cm 76 --hip-cm 104 --waist-to-hip-cm 20 --length-cm 53\n  \
hemline skirt --waist-radius-cm 12.1 --hem-radius-cm 23.62 --length-cm 53 --pattern skirt.svg --pattern skirt.dxf\n  \
hemline skirt --waist-cm 76 --hip-cm 104 --waist-to-hip-cm 20 --length-cm 53 --pattern skirt.pdf --paper a4 --panels 4 --seam-allowance-mm 15 --hem-allowance-mm 30\n\n\
Exit code: 0, or 2 if there is no such cone or the pattern could not be written.")]
pub struct SkirtArgs {
    /// Girth of the waist, cm
    #[arg(long, value_name = "CM", conflicts_with = "waist_radius_cm", required_unless_present = "waist_radius_cm")]
    waist_cm: Option<f64>,
    /// Girth of the hips, cm
    #[arg(long, value_name = "CM", requires = "waist_to_hip_cm")]
    hip_cm: Option<f64>,
    /// Height between waist and hips, cm
    #[arg(long, value_name = "CM", requires = "hip_cm")]
    waist_to_hip_cm: Option<f64>,
    /// Length of the cloth from waist to hem, cm
    #[arg(long, value_name = "CM")]
    length_cm: f64,
    /// Radius of the waist ring, cm
    #[arg(long, value_name = "CM")]
    waist_radius_cm: Option<f64>,
    /// Radius of the round hem, cm; without it the cone follows the hips
    #[arg(long, value_name = "CM")]
    hem_radius_cm: Option<f64>,
    /// Thickness of the cloth, mm, for the thin-shell test
    #[arg(long, value_name = "MM")]
    thickness_mm: Option<f64>,
    /// Shape of the body between waist and hips; all three unless told
    #[arg(long, value_enum)]
    body: Option<Shape>,
    /// Write the flat pattern to this file (.svg, .pdf or .dxf); may be repeated
    #[arg(long, value_name = "FILE")]
    pattern: Vec<PathBuf>,
    /// Cut the skirt in so many equal panels: 1 the whole sector, 2 halves, 4 quarters
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    panels: u32,
    /// Draw half a panel, to be cut on the fold of the cloth
    #[arg(long)]
    on_fold: bool,
    /// Allowance at the side seams, mm
    #[arg(long, default_value_t = 0.0, value_name = "MM")]
    seam_allowance_mm: f64,
    /// Allowance at the waist, mm; that of the seams unless told
    #[arg(long, value_name = "MM")]
    waist_allowance_mm: Option<f64>,
    /// Allowance at the hem, mm; that of the seams unless told
    #[arg(long, value_name = "MM")]
    hem_allowance_mm: Option<f64>,
    /// Paper of a PDF: one sheet as large as the pattern, or tiles to glue together
    #[arg(long, value_enum, default_value_t = Sheets::Whole)]
    paper: Sheets,
    /// Print one JSON object (SI units)
    #[arg(long)]
    json: bool,
}

/// The shapes of a body by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Shape {
    Cone,
    Cylinder,
    Ellipsoid,
}

/// The papers by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Sheets {
    Whole,
    A4,
    A3,
    Letter,
}

/// All that is said.
struct Answer {
    cone: Cone,
    body: Option<Body>,
    /// δ and whether it is below 1/20.
    thinness: Option<(f64, bool)>,
    gaps: Vec<HipGap>,
    pattern: Pattern,
    written: Vec<PathBuf>,
}

/// Runs the command; prints the cone to standard output and writes the patterns.
///
/// # Errors
/// Where there is no such cone, or a pattern cannot be cut or written.
pub fn run(args: &SkirtArgs) -> Result<ExitCode, Error> {
    let answer = answer(args)?;
    if args.json {
        print(&format!("{:#}\n", to_json(&answer)))?;
    } else {
        print(&to_text(&answer))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn answer(args: &SkirtArgs) -> Result<Answer, Error> {
    let centimetres = |value: f64| Metre(value * CENTIMETRE);
    let millimetres = |value: f64| value * MILLIMETRE;
    let turn = std::f64::consts::TAU;
    let waist_girth = match (args.waist_cm, args.waist_radius_cm) {
        (Some(girth), _) => centimetres(girth),
        (None, Some(radius)) => Metre(turn * radius * CENTIMETRE),
        (None, None) => return Err(Error::Unanswerable("the waist is not given: --waist-cm or --waist-radius-cm".into())),
    };
    let hips = args.hip_cm.zip(args.waist_to_hip_cm).map(|(girth, depth)| (centimetres(girth), centimetres(depth)));
    let length = centimetres(args.length_cm);
    let skirt = match (args.hem_radius_cm, hips) {
        (Some(hem), _) => Skirt::new(Metre(waist_girth.0 / turn), centimetres(hem), length)?,
        (None, Some((girth, depth))) => from_body(waist_girth, girth, depth, length)?,
        (None, None) => {
            let why = "the cone is not determined: give --hip-cm and --waist-to-hip-cm, or --hem-radius-cm";
            return Err(Error::Unanswerable(why.into()));
        }
    };
    let cone = Cone::of(&skirt);
    let body = hips.map(|(girth, depth)| Body::new(waist_girth, girth, depth)).transpose()?;
    if let Some(thickness) = args.thickness_mm
        && !(thickness.is_finite() && 0.0 < thickness)
    {
        return Err(Error::Invalid { quantity: "thickness, mm", value: thickness, allowed: "> 0" });
    }
    let shapes: Vec<BodyShape> = match args.body {
        None => BodyShape::ALL.to_vec(),
        Some(Shape::Cone) => vec![BodyShape::Cone],
        Some(Shape::Cylinder) => vec![BodyShape::Cylinder],
        Some(Shape::Ellipsoid) => vec![BodyShape::Ellipsoid],
    };
    let options = pattern::Options {
        panels: args.panels,
        on_fold: args.on_fold,
        seam_allowance: millimetres(args.seam_allowance_mm),
        waist_allowance: millimetres(args.waist_allowance_mm.unwrap_or(args.seam_allowance_mm)),
        hem_allowance: millimetres(args.hem_allowance_mm.unwrap_or(args.seam_allowance_mm)),
    };
    let pattern = Pattern::of(&cone, &options)?;
    let paper = match args.paper {
        Sheets::Whole => Paper::Whole,
        Sheets::A4 => Paper::A4,
        Sheets::A3 => Paper::A3,
        Sheets::Letter => Paper::LETTER,
    };
    let words = words(&cone, &options);
    let written = args.pattern.iter().map(|path| write(&pattern, &words, paper, path)).collect::<Result<_, _>>()?;
    Ok(Answer {
        cone,
        body,
        thinness: args.thickness_mm.map(|t| thinness(&skirt, millimetres(t))),
        gaps: body.map_or(vec![], |body| shapes.into_iter().map(|shape| body.gap(&cone, shape)).collect()),
        pattern,
        written,
    })
}

/// What is printed on the panel.
fn words(cone: &Cone, options: &pattern::Options) -> Vec<String> {
    let cm = |length: f64| format!("{:.1}", length / CENTIMETRE);
    let turn = std::f64::consts::TAU;
    let fold = if options.on_fold { ", on the fold" } else { "" };
    let mm = |length: f64| (length / MILLIMETRE).round();
    vec![
        format!("skirt: cut {} times{fold}", options.panels),
        format!("waist {} cm, hem {} cm, length {} cm", cm(turn * cone.waist_radius), cm(turn * cone.hem_radius), cm(cone.slant_length)),
        format!(
            "allowances: seams {}, waist {}, hem {} mm",
            mm(options.seam_allowance),
            mm(options.waist_allowance),
            mm(options.hem_allowance)
        ),
    ]
}

/// SI units; null where a quantity does not exist.
fn to_json(answer: &Answer) -> Value {
    let Answer { cone, body, .. } = answer;
    let gap = |g: &HipGap| json!({"shape": g.shape, "gap_at_hips_m": g.at_hips, "least_gap_m": g.least, "least_gap_depth_m": g.least_depth, "touches": g.touches});
    let (low, high) = answer.pattern.bounds();
    json!({
        "waist_radius_m": cone.waist_radius,
        "hip_radius_m": body.as_ref().map(Body::hip_radius),
        "hem_radius_m": cone.hem_radius,
        "slant_length_m": cone.slant_length,
        "base_angle_rad": cone.base_angle,
        "height_m": cone.height,
        "pattern_radius_m": cone.pattern_radius,
        "pattern_angle_rad": cone.pattern_angle,
        "cloth_area_m2": cloth_area(cone),
        "thin_shell": {
            "delta": answer.thinness.map(|t| t.0),
            "limit": 1.0 / 20.0,
            "holds": answer.thinness.map(|t| t.1),
            "missing": if answer.thinness.is_some() { None } else { Some("the thickness of the cloth is not given") },
        },
        "body": answer.gaps.iter().map(gap).collect::<Vec<_>>(),
        "pattern": {
            "panels": answer.pattern.options.panels,
            "on_fold": answer.pattern.options.on_fold,
            "width_m": high.x - low.x,
            "height_m": high.y - low.y,
            "cut_area_of_a_panel_m2": answer.pattern.cut_area(),
            "files": answer.written,
        },
    })
}

fn to_text(answer: &Answer) -> String {
    let Answer { cone, body, .. } = answer;
    let cm = |length: f64| length / CENTIMETRE;
    let mm = |length: f64| length / MILLIMETRE;
    let mut out = format!("waist radius    R_t  {:.2} cm\n", cm(cone.waist_radius));
    if let Some(body) = body {
        out += &format!("hip radius      R_b  {:.2} cm\n", cm(body.hip_radius()));
    }
    out += &format!("base angle      β    {:.3} rad ({:.1}°)\n", cone.base_angle, cone.base_angle / DEGREE);
    out += &format!("hem radius      R_n  {:.2} cm\n", cm(cone.hem_radius));
    out += &format!("length          L    {:.2} cm\n", cm(cone.slant_length));
    out += &format!("height          H    {:.2} cm\n", cm(cone.height));
    match cone.pattern_radius {
        Some(radius) => {
            out += &format!("pattern radius  R_v  {:.2} cm\n", cm(radius));
            out += &format!("pattern angle   α    {:.3} rad ({:.1}°)\n", cone.pattern_angle, cone.pattern_angle / DEGREE);
        }
        None => out += "pattern              a rectangle: the skirt is a cylinder\n",
    }
    // m² with four places: a square centimetre.
    out += &format!("cloth area           {:.4} m²\n", cloth_area(cone));
    out += &match answer.thinness {
        Some((delta, true)) => format!("thin-shell test δ    {delta:.5}, below 1/20: a thin shell\n"),
        Some((delta, false)) => format!("thin-shell test δ    {delta:.5}, not below 1/20: no thin shell\n"),
        None => {
            let limit = mm(std::f64::consts::TAU * cone.waist_radius / 20.0);
            format!("thin-shell test δ    not known without --thickness-mm; cloth thinner than {limit:.0} mm passes\n")
        }
    };
    for gap in &answer.gaps {
        let verdict = match gap {
            HipGap { touches: false, .. } => "hips do not touch the round cone".to_string(),
            HipGap { least, least_depth, .. } if *least < -crate::model::body::TOUCH => {
                format!("hips push the cloth out by up to {:.1} mm, {:.1} cm below the waist", -mm(*least), cm(*least_depth))
            }
            _ => "hips touch the cloth".to_string(),
        };
        let at_hips = gap.at_hips.map_or("the skirt ends above the hips".into(), |g| format!("gap at the hips {:.1} mm", mm(g) + 0.0));
        out += &format!("body as {:<12} {verdict}; {at_hips}\n", gap.shape.name());
    }
    let (low, high) = answer.pattern.bounds();
    let Pattern { options, .. } = &answer.pattern;
    let pieces = match (options.panels, options.on_fold) {
        (1, false) => "one piece".to_string(),
        (n, false) => format!("{n} panels"),
        (n, true) => format!("{n} panels on the fold"),
    };
    let area = answer.pattern.cut_area();
    out += &format!(
        "pattern              {pieces}, each {:.1} × {:.1} cm of paper, {area:.4} m² of cloth\n",
        cm(high.x - low.x),
        cm(high.y - low.y)
    );
    for path in &answer.written {
        out += &format!("written              {}\n", path.display());
    }
    out
}
