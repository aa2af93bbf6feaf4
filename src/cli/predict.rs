//! `hemline predict`: the hem from cloth and cut.

use std::process::ExitCode;

use clap::Args;
use serde_json::{Map, Value, json};

use crate::error::Error;
use crate::experiment::{Fabric, Skirt};
use crate::simulate::{Fidelity, Folds, Options, Prediction, Termination, predict};
use crate::units::{self, KilogramPerSquareMetre, Metre, NewtonMetre};

/// Predict how a conic skirt hangs, from its cut and its cloth; nothing is fitted.
///
/// The hem is the one of least energy (weight and bending) among all hems of m equal folds; with `--folds auto` the fold count is the one that
/// costs least. Above a threshold rigidity the skirt hangs round: `folds` is then 0.
#[derive(Debug, Clone, Args)]
#[command(
    after_help = "Example:\n  hemline predict --waist-radius-cm 12.1 --hem-radius-cm 23.62 --slant-length-cm 53 --areal-density-g-m2 200 --rigidity-un-m 10 --json"
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
    /// Harmonics of the hem's tangent angle, 1 to 32; eight are right to hundredths of a millimetre
    #[arg(long, default_value_t = 8, value_name = "K")]
    harmonics: usize,
    /// Acceleration of free fall, m/s²
    #[arg(long, default_value_t = units::STANDARD_GRAVITY, value_name = "M_S2")]
    gravity_m_s2: f64,
    /// Print one JSON object (SI units)
    #[arg(long)]
    json: bool,
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
    let prediction = prediction(args)?;
    if args.json {
        println!("{}", to_json(&prediction));
    } else {
        print!("{}", to_text(&prediction));
    }
    let usable = matches!(prediction.termination, Termination::Converged | Termination::Round);
    Ok(if usable { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

fn prediction(args: &Predict) -> Result<Prediction, Error> {
    let centimetres = |value: f64| Metre(value * units::CENTIMETRE);
    let skirt = Skirt::new(centimetres(args.waist_radius_cm), centimetres(args.hem_radius_cm), centimetres(args.slant_length_cm))?;
    let fabric = Fabric {
        areal_density: Some(KilogramPerSquareMetre(args.areal_density_g_m2 * units::GRAM_PER_SQUARE_METRE)),
        flexural_rigidity: Some(NewtonMetre(args.rigidity_un_m * units::MICRONEWTON_METRE)),
    };
    predict(
        &skirt,
        &fabric,
        &Options { fidelity: Fidelity::Ruled { harmonics: args.harmonics }, folds: args.folds, gravity: args.gravity_m_s2 },
    )
}

/// The prediction as one JSON object; a term that is not in has no key.
fn to_json(prediction: &Prediction) -> Value {
    let mut out = Map::new();
    out.insert("fidelity".into(), json!(prediction.fidelity));
    out.insert("folds".into(), json!(prediction.folds));
    out.insert("energy_j".into(), json!(prediction.energy));
    for term in &prediction.terms {
        out.insert(format!("{}_j", term.term), json!(term.energy));
    }
    out.insert("hem_radius_min_m".into(), json!(prediction.hem_radius_min));
    out.insert("hem_radius_max_m".into(), json!(prediction.hem_radius_max));
    out.insert("coefficients".into(), json!(prediction.coefficients));
    out.insert("termination".into(), json!(prediction.termination));
    out.insert("evaluations".into(), json!(prediction.evaluations));
    out.insert("branches".into(), json!(prediction.branches));
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
    out += &format!("energy       {:.4} mJ\n", millijoules(prediction.energy));
    for term in &prediction.terms {
        out += &format!("  {:<10} {:.4} mJ\n", term.term, millijoules(term.energy));
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
    fn nonsense_is_refused_with_what_is_allowed() {
        assert!(parse(&["--rigidity-un-m", "10", "--folds", "some"]).is_err());
        assert!(prediction(&parse(&["--rigidity-un-m", "10", "--folds", "1"]).unwrap()).unwrap_err().to_string().contains("2 to 512"));
        assert!(prediction(&parse(&["--rigidity-un-m", "0"]).unwrap()).unwrap_err().to_string().contains("> 0"));
    }
}
