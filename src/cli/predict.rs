//! `hemline predict`: the hem from cloth and cut.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};

use crate::cli::print;
use crate::cli::surface::{self, SurfaceFlags};
use crate::error::Error;
use crate::experiment::scene::{Choice, ClothDetail, TermSet, Theory, WaistEdge};
use crate::experiment::{Apparatus, Fabric, Scene, Skirt};
use crate::import::scene_file;
use crate::simulate::{
    Branch, Contact, Fidelity, Folds, Options, Prediction, Screened, Screening, Termination, graded, predict, predict_scene, ruled,
};
use crate::study::surface::of_prediction;
use crate::units::{self, KilogramPerSquareMetre, Metre, NewtonMetre};

/// Predict how a conic skirt hangs, from its cut and its cloth; nothing is fitted.
///
/// The hem is the one of least energy (weight and bending) among all hems of m equal folds; with `--folds auto` the fold count is the one that
/// costs least. Above a threshold rigidity the skirt hangs round: `folds` is then 0.
#[derive(Debug, Clone, Args)]
#[command(
    after_help = "Examples:\n  hemline predict --scene scene.toml --terms auto\n  hemline predict --waist-radius-cm 12.1 --hem-radius-cm 23.62 --slant-length-cm 53 --areal-density-g-m2 200 --rigidity-un-m 10 --json\n  \
hemline predict --waist-radius-cm 12.1 --hem-radius-cm 23.62 --slant-length-cm 53 --areal-density-g-m2 200 --rigidity-un-m 10 --fidelity graded \\\n    \
--thickness-mm 0.5 --poisson 0.2 --surface skirt.glb --field stress-intensity"
)]
pub struct Predict {
    /// Skirt, cloth, body, terms and tolerance from this file (docs/terms.md); other flags overrule it
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// Energy terms that are in: `auto` for those whose omission would move the hem by more than the tolerance, or a list of gravity, bending,
    /// foundation, shear, stretch, body_contact, self_contact
    #[arg(long, value_name = "auto|TERM,…")]
    terms: Option<String>,
    /// Radius of the waist ring, cm
    #[arg(long, value_name = "CM", required_unless_present = "scene", conflicts_with = "scene")]
    waist_radius_cm: Option<f64>,
    /// Radius of the round hem: half the hem's cloth length over π, cm
    #[arg(long, value_name = "CM", required_unless_present = "scene", conflicts_with = "scene")]
    hem_radius_cm: Option<f64>,
    /// Length of the cloth from waist to hem, cm
    #[arg(long, value_name = "CM", required_unless_present = "scene", conflicts_with = "scene")]
    slant_length_cm: Option<f64>,
    /// Mass per area of the cloth, g/m²
    #[arg(long, value_name = "G_M2", required_unless_present = "scene", conflicts_with = "scene")]
    areal_density_g_m2: Option<f64>,
    /// Flexural rigidity of the cloth per width, µN·m
    #[arg(long, value_name = "UN_M", required_unless_present = "scene", conflicts_with = "scene")]
    rigidity_un_m: Option<f64>,
    /// Fold count: `auto` for the one of least energy, or a number from 2 [default: auto]
    #[arg(long, value_name = "auto|M", value_parser = folds)]
    folds: Option<Folds>,
    /// Theory: graded (every ring inextensible, generatrices curve; nearest to a real skirt), ruled (generatrices straight), ansatz (the paper's
    /// curve p, q, s in the ruled energy), polar (the paper's equation (4)) [default: ruled]
    #[arg(long, value_enum)]
    fidelity: Option<Method>,
    /// Foundation modulus E of the paper's functional, N/m³; equation (4), and with --terms
    #[arg(long, default_value_t = 0.0, value_name = "E")]
    foundation_n_m3: f64,
    /// Harmonics of the tangent angle; 8 unless told for ruled (up to 32), 3 for graded (up to 12)
    #[arg(long, value_name = "K")]
    harmonics: Option<usize>,
    /// Modes of each harmonic over height, 2 to 24; graded only
    #[arg(long, default_value_t = graded::MODES, value_name = "J")]
    height_modes: usize,
    /// Shear stiffness of the weave, N/m; graded, and with --terms; 0 leaves shear free
    #[arg(long, default_value_t = 0.0, value_name = "S")]
    shear_n_m: f64,
    /// Resolve the hem to this distance, mm: harmonics and modes are then chosen (ruled and graded)
    #[arg(long, value_name = "MM")]
    tolerance_mm: Option<f64>,
    #[arg(long, value_name = "M_S2", help = format!("Acceleration of free fall, m/s² [default: {}]", units::STANDARD_GRAVITY))]
    gravity_m_s2: Option<f64>,
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
    let prediction = prediction(args)?;
    let surface = if args.surface.wanted() {
        if prediction.terms.iter().any(|term| term.term == "stretch") {
            return Err(Error::Unanswerable("fields are those of inextensible cloth: leave the term stretch out, or --surface".into()));
        }
        let (skirt, fabric, gravity) = hung(args)?;
        let sheet = args.surface.sheet(&fabric, gravity);
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

/// Cut, cloth and acceleration of free fall, from the scene or the flags.
fn hung(args: &Predict) -> Result<(Skirt, Fabric, f64), Error> {
    if let Some(path) = &args.scene {
        let scene = scene_file::read(path)?;
        return Ok((scene.skirt, scene.fabric, args.gravity_m_s2.unwrap_or(scene.gravity)));
    }
    Ok((skirt(args)?, fabric(args), args.gravity_m_s2.unwrap_or(units::STANDARD_GRAVITY)))
}

fn prediction(args: &Predict) -> Result<Prediction, Error> {
    if args.scene.is_some() || args.terms.is_some() {
        return of_scene(args);
    }
    let tolerance = args.tolerance_mm.map(|t| Metre(t * units::MILLIMETRE));
    let options = Options {
        fidelity: fidelity(args, args.fidelity.unwrap_or(Method::Ruled)),
        folds: args.folds.unwrap_or(Folds::Auto),
        gravity: args.gravity_m_s2.unwrap_or(units::STANDARD_GRAVITY),
        tolerance,
        ..Options::default()
    };
    predict(&skirt(args)?, &fabric(args), &options)
}

fn skirt(args: &Predict) -> Result<Skirt, Error> {
    let centimetres = |value: Option<f64>| Metre(value.unwrap_or(0.0) * units::CENTIMETRE);
    Skirt::new(centimetres(args.waist_radius_cm), centimetres(args.hem_radius_cm), centimetres(args.slant_length_cm))
}

fn fabric(args: &Predict) -> Fabric {
    Fabric {
        areal_density: args.areal_density_g_m2.map(|density| KilogramPerSquareMetre(density * units::GRAM_PER_SQUARE_METRE)),
        flexural_rigidity: args.rigidity_un_m.map(|rigidity| NewtonMetre(rigidity * units::MICRONEWTON_METRE)),
    }
}

fn fidelity(args: &Predict, method: Method) -> Fidelity {
    match method {
        Method::Polar => Fidelity::Polar { foundation: args.foundation_n_m3 },
        Method::Ansatz => Fidelity::Ansatz,
        Method::Ruled => Fidelity::Ruled { harmonics: args.harmonics.unwrap_or(ruled::HARMONICS) },
        Method::Graded => {
            let harmonics = args.harmonics.unwrap_or(graded::HARMONICS);
            Fidelity::Graded { harmonics, modes: args.height_modes, shear: args.shear_n_m }
        }
    }
}

/// The scene of a file or of the flags, and its hem.
fn of_scene(args: &Predict) -> Result<Prediction, Error> {
    let mut scene = match &args.scene {
        Some(path) => scene_file::read(path)?,
        None => Scene {
            title: None,
            apparatus: Apparatus::Skirt,
            skirt: skirt(args)?,
            waist_edge: WaistEdge::default(),
            seams: 0,
            fabric: fabric(args),
            detail: ClothDetail::default(),
            body: None,
            choice: Choice::Exactly(TermSet::usual()),
            theory: Theory::Ruled,
            folds: None,
            tolerance: None,
            gravity: units::STANDARD_GRAVITY,
        },
    };
    if let Some(names) = &args.terms {
        let names: Vec<&str> = names.split(',').map(str::trim).collect();
        scene.choice = scene_file::choice(&names).map_err(|why| Error::Unanswerable(format!("--terms: {why}")))?;
    }
    match args.folds {
        Some(Folds::Auto) => scene.folds = None,
        Some(Folds::Exactly(m)) => scene.folds = Some(m),
        None => {}
    }
    scene.tolerance = args.tolerance_mm.map(|t| Metre(t * units::MILLIMETRE)).or(scene.tolerance);
    scene.gravity = args.gravity_m_s2.unwrap_or(scene.gravity);
    if 0.0 < args.shear_n_m {
        scene.detail.shear_stiffness = Some(args.shear_n_m);
    }
    if 0.0 < args.foundation_n_m3 {
        scene.detail.foundation_modulus = Some(args.foundation_n_m3);
    }
    let method = args.fidelity.unwrap_or(match scene.theory {
        Theory::Ruled => Method::Ruled,
        Theory::Graded => Method::Graded,
        Theory::Ansatz => Method::Ansatz,
        Theory::Polar => Method::Polar,
    });
    let foundation = scene.detail.foundation_modulus.unwrap_or(0.0);
    let size = match fidelity(args, method) {
        Fidelity::Polar { .. } => Fidelity::Polar { foundation },
        other => other,
    };
    predict_scene(&scene, Some(size))
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
    let evaluations: Map<String, Value> = prediction.terms.iter().map(|t| (t.term.to_string(), json!(t.evaluations))).collect();
    out.insert("term_evaluations".into(), Value::Object(evaluations));
    if !prediction.contacts.is_empty() {
        let contact =
            |c: &Contact| json!({ "term": c.term, "stiffness_n_m3": c.stiffness, "reach_m": c.reach, "smallest_gap_m": c.smallest_gap });
        out.insert("contacts".into(), prediction.contacts.iter().map(contact).collect());
    }
    if let Some(screening) = &prediction.screening {
        let row = |row: &Screened| {
            json!({
                "term": row.term, "number": row.number, "number_is": row.is, "movement_m": row.movement, "on": row.on, "why": row.why,
            })
        };
        let rows: Vec<Value> = screening.rows.iter().map(row).collect();
        out.insert(
            "screening".into(),
            json!({ "tolerance_m": screening.tolerance, "trials": screening.trials, "evaluations": screening.evaluations, "terms": rows }),
        );
    }
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
            out += &format!("  {:<12} {:.4} mJ\n", term.term, millijoules(term.energy));
        }
    } else {
        out += &format!("functional   {:.6} {}\n", prediction.energy, prediction.energy_unit);
    }
    for contact in &prediction.contacts {
        let gap = contact.smallest_gap.map_or("no cloth that could touch".into(), |gap| format!("smallest gap {:.2} mm", millimetres(gap)));
        let (reach, stiffness) = (millimetres(contact.reach), contact.stiffness);
        out += &format!("{:<12} {gap}; a wall of {stiffness:.3e} N/m³, felt from {reach:.1} mm on\n", contact.term);
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
    if let Some(screening) = &prediction.screening {
        out += &table(screening);
    }
    out
}

/// The screen's table.
fn table(screening: &Screening) -> String {
    let tolerance = screening.tolerance / units::MILLIMETRE;
    let mut out = format!(
        "\nterms that would move the hem by more than {tolerance} mm are in ({} evaluations to find out):\n",
        screening.evaluations
    );
    out += &format!("{:<13} {:>10}  {:>11}  {:<4} why; the number is\n", "term", "number", "moves, mm", "");
    for row in &screening.rows {
        let number = row.number.map_or(String::new(), |number| format!("{number:.3e}"));
        let movement = row.movement.map_or(String::new(), |movement| format!("{:.3}", movement / units::MILLIMETRE));
        let state = if row.on { "on" } else { "off" };
        out += &format!("{:<13} {number:>10}  {movement:>11}  {state:<4} {}; {}\n", row.term.name(), row.why, row.is);
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
