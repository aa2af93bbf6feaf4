//! `hemline predict`: the hem from cloth and cut.

use std::process::ExitCode;

use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};

use crate::cli::print;
use crate::cli::surface::{self, SurfaceFlags};
use crate::error::Error;
use crate::experiment::{Fabric, Skirt};
use crate::simulate::{Branch, Fidelity, Folds, Options, Prediction, Termination, graded, predict, ruled};
use crate::study::surface::of_prediction;
use crate::units::{self, KilogramPerSquareMetre, Metre, NewtonMetre};

/// Predict how a conic skirt hangs, from its cut and its cloth; nothing is fitted.
///
/// The hem is the one of least energy (weight and bending) among all hems of m equal folds; with `--folds auto` the fold count is the one that
/// costs least. Above a threshold rigidity the skirt hangs round: `folds` is then 0.
#[derive(Debug, Clone, Args)]
#[command(
    after_help = "Example:\n  hemline predict --waist-radius-cm 12.1 --hem-radius-cm 23.62 --slant-length-cm 53 --areal-density-g-m2 200 --rigidity-un-m 10 --json\n  \
hemline predict --waist-radius-cm 12.1 --hem-radius-cm 23.62 --slant-length-cm 53 --areal-density-g-m2 200 --rigidity-un-m 10 --fidelity graded \\\n    \
--thickness-mm 0.5 --poisson 0.2 --surface skirt.glb --field stress-intensity"
)]
pub struct Predict {
    /// Radius of the waist ring, cm
    #[arg(long, value_name = "CM")]
    waist_radius_cm: f64,
    /// Radius of the round hem: half the hem's cloth length over π, cm
    #[arg(long, value_name = "CM")]
    hem_radius_cm: f64,
    /// Length of the cloth from waist to hem, cm
    #[arg(long, value_name = "CM")]
    slant_length_cm: f64,
    /// Mass per area of the cloth, g/m²
    #[arg(long, value_name = "G_M2")]
    areal_density_g_m2: f64,
    /// Flexural rigidity of the cloth per width, µN·m
    #[arg(long, value_name = "UN_M")]
    rigidity_un_m: f64,
    /// Fold count: `auto` for the one of least energy, or a number from 2
    #[arg(long, default_value = "auto", value_name = "auto|M", value_parser = folds)]
    folds: Folds,
    /// Theory: graded (every ring inextensible, generatrices curve; nearest to a real skirt), ruled (generatrices straight), ansatz (the paper's
    /// curve p, q, s in the ruled energy), polar (the paper's equation (4))
    #[arg(long, value_enum, default_value_t = Method::Ruled)]
    fidelity: Method,
    /// Foundation modulus E of the paper's functional, N/m³; equation (4) only
    #[arg(long, default_value_t = 0.0, value_name = "E")]
    foundation_n_m3: f64,
    /// Harmonics of the tangent angle; 8 unless told for ruled (up to 32), 3 for graded (up to 12)
    #[arg(long, value_name = "K")]
    harmonics: Option<usize>,
    /// Modes of each harmonic over height, 2 to 24; graded only
    #[arg(long, default_value_t = graded::MODES, value_name = "J")]
    height_modes: usize,
    /// Shear stiffness of the weave, N/m; graded only, 0 leaves shear free
    #[arg(long, default_value_t = 0.0, value_name = "S")]
    shear_n_m: f64,
    /// Resolve the hem to this distance, mm: harmonics and modes are then chosen (ruled and graded)
    #[arg(long, value_name = "MM")]
    tolerance_mm: Option<f64>,
    /// Acceleration of free fall, m/s²
    #[arg(long, default_value_t = units::STANDARD_GRAVITY, value_name = "M_S2")]
    gravity_m_s2: f64,
    #[command(flatten)]
    surface: SurfaceFlags,
    /// Print one JSON object (SI units)
    #[arg(long)]
    json: bool,
}

/// The theories by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Method {
    Polar,
    Ansatz,
    Ruled,
    Graded,
}

fn folds(text: &str) -> Result<Folds, String> {
    if text == "auto" {
        return Ok(Folds::Auto);
    }
    text.parse().map(Folds::Exactly).map_err(|_| "give `auto` or a whole number of folds, at least 2".into())
}

/// Runs the command; prints the prediction to standard output.
///
/// # Errors
/// As [`predict`]: what is asked makes no sense, or the theory does not apply.
pub fn run(args: &Predict) -> Result<ExitCode, Error> {
    let (skirt, fabric) = scene(args)?;
    let prediction = prediction(args)?;
    let surface = if args.surface.wanted() {
        let sheet = args.surface.sheet(&fabric, args.gravity_m_s2);
        let fields = of_prediction(&skirt, &prediction, &sheet, &args.surface.options())?;
        let written = args.surface.write(&fields)?;
        Some((fields, written))
    } else {
        None
    };
    if args.json {
        let mut out = to_json(&prediction);
        if let Some((fields, written)) = &surface {
            out["surface"] = surface::to_json(fields, written);
        }
        print(&format!("{out}\n"))?;
    } else {
        let said = surface.map(|(fields, written)| surface::to_text(&fields, &written)).unwrap_or_default();
        print(&(to_text(&prediction) + &said))?;
    }
    let usable = matches!(prediction.termination, Termination::Converged | Termination::Round);
    Ok(if usable { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// Cut and cloth.
fn scene(args: &Predict) -> Result<(Skirt, Fabric), Error> {
    let centimetres = |value: f64| Metre(value * units::CENTIMETRE);
    let skirt = Skirt::new(centimetres(args.waist_radius_cm), centimetres(args.hem_radius_cm), centimetres(args.slant_length_cm))?;
    let fabric = Fabric {
        areal_density: Some(KilogramPerSquareMetre(args.areal_density_g_m2 * units::GRAM_PER_SQUARE_METRE)),
        flexural_rigidity: Some(NewtonMetre(args.rigidity_un_m * units::MICRONEWTON_METRE)),
    };
    Ok((skirt, fabric))
}

fn prediction(args: &Predict) -> Result<Prediction, Error> {
    let (skirt, fabric) = scene(args)?;
    let fidelity = match args.fidelity {
        Method::Polar => Fidelity::Polar { foundation: args.foundation_n_m3 },
        Method::Ansatz => Fidelity::Ansatz,
        Method::Ruled => Fidelity::Ruled { harmonics: args.harmonics.unwrap_or(ruled::HARMONICS) },
        Method::Graded => {
            let harmonics = args.harmonics.unwrap_or(graded::HARMONICS);
            Fidelity::Graded { harmonics, modes: args.height_modes, shear: args.shear_n_m }
        }
    };
    predict(
        &skirt,
        &fabric,
        &Options {
            fidelity,
            folds: args.folds,
            gravity: args.gravity_m_s2,
            tolerance: args.tolerance_mm.map(|t| Metre(t * units::MILLIMETRE)),
        },
    )
}

/// The prediction as one JSON object; what a fidelity does not have has no key.
fn to_json(prediction: &Prediction) -> Value {
    let mut out = Map::new();
    out.insert("fidelity".into(), json!(prediction.fidelity));
    out.insert("folds".into(), json!(prediction.folds));
    let unit = if prediction.energy_unit == "J" { "j" } else { "n_m" };
    let total = if prediction.energy_unit == "J" { "energy" } else { "total" };
    out.insert(format!("{total}_{unit}"), json!(prediction.energy));
    for term in &prediction.terms {
        out.insert(format!("{}_{unit}", term.term), json!(term.energy));
    }
    if let Some(hem) = &prediction.hem {
        out.extend([("p_m", hem.p), ("q_m", hem.q), ("s_m", hem.s)].map(|(key, value)| (key.to_string(), json!(value))));
    }
    if let Some(rms) = prediction.hem_rms {
        out.insert("p_q_s_rms_m".into(), json!(rms));
    }
    if let Some(multiplier) = &prediction.multiplier {
        out.insert("lambda".into(), json!(multiplier.value));
        out.insert("lambda_unit".into(), json!(multiplier.unit));
    }
    if let Some(turning) = &prediction.turning {
        out.insert("turning_radius_inner_m".into(), json!(turning.inner));
        out.insert("turning_radius_outer_m".into(), json!(turning.outer));
        out.insert("constant_n_m".into(), json!(turning.constant));
    }
    out.insert("hem_radius_min_m".into(), json!(prediction.hem_radius_min));
    out.insert("hem_radius_max_m".into(), json!(prediction.hem_radius_max));
    out.insert("coefficients".into(), json!(prediction.coefficients));
    out.insert("termination".into(), json!(prediction.termination));
    if let Some(error) = prediction.error_estimate {
        out.insert("error_estimate_m".into(), json!(error));
    }
    out.insert("evaluations".into(), json!(prediction.evaluations));
    let branch = |b: &Branch| {
        json!({
            "asked": b.asked,
            "folds": b.folds,
            "harmonics": b.harmonics,
            (format!("{total}_{unit}")): b.energy,
            "depth_m": b.depth,
            "threshold_rigidity_n_m": b.threshold_rigidity,
            "lowest_curvature": b.lowest_curvature,
            "termination": b.termination,
        })
    };
    out.insert("branches".into(), prediction.branches.iter().map(branch).collect());
    out.insert("notes".into(), json!(prediction.notes));
    Value::Object(out)
}

fn to_text(prediction: &Prediction) -> String {
    let millimetres = |value: f64| value / units::MILLIMETRE;
    let millijoules = |value: f64| value / units::MILLIJOULE;
    let mut out = match prediction.folds {
        0 => "no folds: the skirt hangs round\n".to_string(),
        m => format!("{m} folds\n"),
    };
    out += &format!(
        "hem radius   {:.1} to {:.1} mm, fold depth {:.1} mm\n",
        millimetres(prediction.hem_radius_min),
        millimetres(prediction.hem_radius_max),
        millimetres(prediction.depth())
    );
    if let Some(error) = prediction.error_estimate {
        out += &format!("resolved to  {:.2e} mm\n", millimetres(error));
    }
    if prediction.energy_unit == "J" {
        out += &format!("energy       {:.4} mJ\n", millijoules(prediction.energy));
        for term in &prediction.terms {
            out += &format!("  {:<10} {:.4} mJ\n", term.term, millijoules(term.energy));
        }
    } else {
        out += &format!("functional   {:.6} {}\n", prediction.energy, prediction.energy_unit);
    }
    if let (Some(hem), Some(rms)) = (&prediction.hem, prediction.hem_rms) {
        let (p, q, s, rms) = (millimetres(hem.p), millimetres(hem.q), millimetres(hem.s), millimetres(rms));
        out += &format!("p, q, s      {p:.2}, {q:.2}, {s:.2} mm, which miss this hem by {rms:.1} mm rms\n");
    }
    if let Some(multiplier) = &prediction.multiplier {
        out += &format!("lambda       {:.6} {}\n", multiplier.value, multiplier.unit);
    }
    out += &format!("method       {}, {} evaluations\n", prediction.fidelity, prediction.evaluations);
    let mut others: Vec<_> = prediction.branches.iter().filter(|b| b.folds == b.asked && b.folds != prediction.folds).collect();
    others.sort_by(|a, b| a.energy.total_cmp(&b.energy));
    for branch in others.iter().take(2) {
        let excess = 100.0 * (branch.energy / prediction.energy - 1.0);
        out += &format!("also stable  {} folds, {excess:+.1} % energy, fold depth {:.1} mm\n", branch.folds, millimetres(branch.depth));
    }
    for note in &prediction.notes {
        out += &format!("note         {note}\n");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{FromArgMatches, Parser};

    #[derive(Parser)]
    struct Alone {
        #[command(flatten)]
        predict: Predict,
    }

    fn parse(extra: &[&str]) -> Result<Predict, clap::Error> {
        let scene = ["--waist-radius-cm", "12.1", "--hem-radius-cm", "23.62", "--slant-length-cm", "53", "--areal-density-g-m2", "200"];
        let words = ["predict"].iter().chain(&scene).chain(extra);
        let matches = <Alone as clap::CommandFactory>::command().try_get_matches_from(words)?;
        Ok(Alone::from_arg_matches(&matches)?.predict)
    }

    #[test]
    fn json_has_the_promised_keys_in_si_units() {
        let args = parse(&["--rigidity-un-m", "10", "--folds", "5", "--harmonics", "12", "--json"]).unwrap();
        let out = to_json(&prediction(&args).unwrap());
        assert_eq!(out["folds"], 5);
        assert_eq!(out["termination"], "converged");
        // Birthplace as in tests/theory.rs: the reference's K = 12, in the units of the flags.
        assert!((out["energy_j"].as_f64().unwrap() - 0.002156002405).abs() < 1.5e-12);
        let sum = out["gravity_j"].as_f64().unwrap() + out["bending_j"].as_f64().unwrap();
        assert!((sum - out["energy_j"].as_f64().unwrap()).abs() < 1e-17);
        assert!((out["hem_radius_max_m"].as_f64().unwrap() - 0.18741830).abs() < 1.5e-8);
        assert_eq!(out["coefficients"].as_array().unwrap().len(), 12);
        assert!(0.0 < out["coefficients"][0].as_f64().unwrap());
    }

    #[test]
    fn stiff_cloth_is_reported_round_not_failed() {
        let args = parse(&["--rigidity-un-m", "1e6"]).unwrap();
        let prediction = prediction(&args).unwrap();
        assert_eq!(to_json(&prediction)["termination"], "round");
        assert!(to_text(&prediction).starts_with("no folds"));
    }

    #[test]
    fn every_fidelity_answers_in_its_own_keys() {
        let of =
            |name: &str| to_json(&prediction(&parse(&["--rigidity-un-m", "10", "--folds", "5", "--fidelity", name]).unwrap()).unwrap());
        let polar = of("polar");
        assert!(polar["turning_radius_inner_m"].as_f64().unwrap() < polar["turning_radius_outer_m"].as_f64().unwrap());
        assert_eq!((polar["lambda_unit"].as_str(), polar.get("energy_j")), (Some("N/m²"), None));
        let ansatz = of("ansatz");
        assert!((ansatz["p_m"].as_f64().unwrap() - 0.13152467).abs() < 1e-8 && ansatz["lambda_unit"] == "N");
        let ruled = of("ruled");
        assert!((ruled["p_m"].as_f64().unwrap() / ansatz["p_m"].as_f64().unwrap() - 1.0).abs() < 0.05);
        assert_eq!((ansatz["p_q_s_rms_m"].as_f64(), ruled["lambda_unit"].as_str()), (Some(0.0), Some("N")));
        let graded = of("graded");
        assert_eq!((graded["folds"].as_u64(), graded["coefficients"].as_array().unwrap().len()), (Some(5), 3));
    }

    #[test]
    fn nonsense_is_refused_with_what_is_allowed() {
        assert!(parse(&["--rigidity-un-m", "10", "--folds", "some"]).is_err());
        assert!(prediction(&parse(&["--rigidity-un-m", "10", "--folds", "1"]).unwrap()).unwrap_err().to_string().contains("2 to 512"));
        assert!(prediction(&parse(&["--rigidity-un-m", "0"]).unwrap()).unwrap_err().to_string().contains("> 0"));
    }
}
