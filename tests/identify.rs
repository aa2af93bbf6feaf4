//! Flexural rigidity from a hem: on the theory's own hems with noise, and what is refused.

use std::f64::consts::TAU;

use hemline::experiment::campaign::Folds as WantedFolds;
use hemline::experiment::{DrapeProfile, Fabric, Point, Skirt};
use hemline::simulate::{Fidelity, Folds, Options, predict};
use hemline::study::identify::{Through, equal_folds, identify, identify_profile};
use hemline::units::{KilogramPerSquareMetre, Metre, NewtonMetre};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const WEIGHT: f64 = 0.2 * 9.81;

fn skirt() -> Skirt {
    Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap()
}

/// The three clothes of docs/model.md, section 5: B and the fold count they are seen with.
const CLOTHES: [(f64, u32); 3] = [(2e-6, 7), (1e-5, 5), (5e-5, 4)];

/// A hem of the theory, its coefficients to twelve harmonics, `n` points of it.
fn hem(rigidity: f64, folds: u32, fidelity: Fidelity, n: usize) -> Vec<Point> {
    let fabric = Fabric { areal_density: Some(KilogramPerSquareMetre(0.2)), flexural_rigidity: Some(NewtonMetre(rigidity)) };
    let options = Options { fidelity, folds: Folds::Exactly(folds), ..Options::default() };
    let outline = predict(&skirt(), &fabric, &options).unwrap().outline;
    let stride = outline.len() / n;
    outline.into_iter().step_by(stride).collect()
}

/// As a laboratory has it: turned, shifted, and with normal noise in both coordinates.
fn measured(points: &[Point], noise: f64, seed: u64) -> DrapeProfile {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    // Box and Muller's pair.
    let mut pair = || {
        let (u, v): (f64, f64) = (random.random(), random.random());
        let r = (-2.0 * (1.0 - u).ln()).sqrt();
        (r * (TAU * v).cos(), r * (TAU * v).sin())
    };
    let ((a, b), (x0, y0)) = (pair(), pair());
    let (sin, cos) = (a + b).sin_cos();
    let moved: Vec<Point> = points
        .iter()
        .map(|p| {
            let (dx, dy) = pair();
            Point::new(0.01 * x0 + p.x * cos - p.y * sin + noise * dx, 0.01 * y0 + p.x * sin + p.y * cos + noise * dy)
        })
        .collect();
    DrapeProfile::new(&moved).unwrap()
}

#[test]
fn rigidity_of_own_hems_with_half_a_millimetre_of_noise_comes_back_within_five_percent() {
    const REPLICATES: u64 = 8;
    for (rigidity, folds) in CLOTHES {
        let exact = hem(rigidity, folds, Fidelity::Ruled { harmonics: 12 }, 180);
        let mut standardized = Vec::new();
        let mut relative = Vec::new();
        for seed in 0..REPLICATES {
            let profile = measured(&exact, 5e-4, 1000 * u64::from(folds) + seed);
            let found = identify_profile(&profile, &skirt(), WEIGHT, WantedFolds::default(), Through::Ruled).unwrap();
            assert_eq!(found.folds, folds);
            let off = found.rigidity.value / rigidity - 1.0;
            eprintln!(
                "B {rigidity:e} m {folds}: K {} off {:+.2} % se {:.2} % chi2 {:.1}/{} misfit {:.2} mm lambda {:.5}±{:.5} {} evaluations",
                found.harmonics,
                100.0 * off,
                100.0 * found.relative_error,
                found.chi_square,
                found.degrees_of_freedom,
                1e3 * found.misfit,
                found.lambda.value,
                found.lambda.standard_error.unwrap(),
                found.evaluations
            );
            relative.push(off);
            standardized.push(off / found.relative_error);
        }
        let n = relative.len() as f64;
        let bias = relative.iter().sum::<f64>() / n;
        let scatter = (relative.iter().map(|r| (r - bias).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        eprintln!("B {rigidity:e}: bias {:+.2} %, scatter {:.2} %", 100.0 * bias, 100.0 * scatter);
        assert!(relative.iter().all(|r| r.abs() < 0.05), "{relative:?}");
        // Errors claimed are errors made: eight squares of standardized errors lie between 1 and 28 in all but one of 1 000 draws.
        let squares: f64 = standardized.iter().map(|z| z * z).sum();
        assert!(0.8 < squares && squares < 28.0, "{standardized:?}");
    }
}

#[test]
fn rigidity_of_a_graded_hem_comes_back_through_the_graded_energy() {
    // Its own three harmonics by six modes: what is left is the fit's truncation and 0.5 mm of noise.
    for (rigidity, folds) in CLOTHES {
        let exact = hem(rigidity, folds, Fidelity::Graded { harmonics: 3, modes: 6, shear: 0.0 }, 180);
        let found = identify_profile(&measured(&exact, 5e-4, 77), &skirt(), WEIGHT, WantedFolds::default(), Through::Graded).unwrap();
        let off = found.rigidity.value / rigidity - 1.0;
        eprintln!("graded, B {rigidity:e} m {folds}: off {:+.2} %, se {:.2} %", 100.0 * off, 100.0 * found.relative_error);
        assert!(off.abs() < 0.05 && found.folds == folds, "{off}");
    }
}

#[test]
fn an_exact_hem_gives_its_rigidity_and_its_multiplier_back() {
    let (rigidity, folds) = CLOTHES[1];
    let fabric = Fabric { areal_density: Some(KilogramPerSquareMetre(0.2)), flexural_rigidity: Some(NewtonMetre(rigidity)) };
    let options = Options { fidelity: Fidelity::Ruled { harmonics: 8 }, folds: Folds::Exactly(folds), ..Options::default() };
    let prediction = predict(&skirt(), &fabric, &options).unwrap();
    let profile = DrapeProfile::new(&prediction.outline).unwrap();
    let found = identify_profile(&profile, &skirt(), WEIGHT, WantedFolds::default(), Through::Ruled).unwrap();
    // Eight harmonics on either side: what is left is the fit's own tolerance and the two harmonics that the identification has more.
    assert!((found.rigidity.value / rigidity - 1.0).abs() < 1e-3, "{found:?}");
    assert!((found.lambda.value / prediction.multiplier.unwrap().value - 1.0).abs() < 1e-3, "{found:?}");
    assert!(found.misfit < 1e-4 && 4 <= found.harmonics);
    // Weight scales rigidity and multiplier alike: a hem knows their ratio only.
    let double = identify_profile(&profile, &skirt(), 2.0 * WEIGHT, WantedFolds::default(), Through::Ruled).unwrap();
    assert!(
        (double.rigidity.value / found.rigidity.value - 2.0).abs() < 1e-9 && (double.lambda.value / found.lambda.value - 2.0).abs() < 1e-9
    );
}

#[test]
fn what_cannot_be_identified_is_refused_with_its_reason() {
    let exact = hem(1e-5, 5, Fidelity::Ruled { harmonics: 8 }, 180);
    let profile = measured(&exact, 5e-4, 5);
    let tangent = equal_folds(&profile, &skirt(), WantedFolds::default()).unwrap();
    let why = |skirt: &Skirt| identify(skirt, WEIGHT, &tangent, Through::Ruled).unwrap_err().to_string();
    let tester = Skirt::drapemeter(Metre(0.09), Metre(0.2362)).unwrap();
    assert!(why(&tester).contains("drape tester"), "{}", why(&tester));
    // As wide a hem on a slant so short that only cloth far too stiff would fold like this.
    let short = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.14)).unwrap();
    let said = why(&short);
    assert!(said.contains("gravity lengths") || said.contains("not determined") || said.contains("no hem"), "{said}");
    // A hem without folds.
    let round: Vec<Point> = (0..180).map(|i| f64::from(i) * TAU / 180.0).map(|t| Point::new(0.2 * t.cos(), 0.2 * t.sin())).collect();
    let round = identify_profile(&measured(&round, 2e-4, 6), &skirt(), WEIGHT, WantedFolds::default(), Through::Ruled).unwrap_err();
    assert!(round.to_string().contains("round"), "{round}");
    assert!(identify(&skirt(), 0.0, &tangent, Through::Ruled).is_err());
    // Folds whose flanks cross: a tangent that turns by more than the curve can.
    let mut crossed = tangent.clone();
    crossed.coefficients[0].value = 2.6;
    assert!(identify(&skirt(), WEIGHT, &crossed, Through::Ruled).unwrap_err().to_string().contains("flanks"));
    // Coefficients that are known to nothing.
    let mut vague = tangent.clone();
    vague.covariance = vague.covariance.map(|c| c * 1e6);
    let said = identify(&skirt(), WEIGHT, &vague, Through::Ruled).unwrap_err().to_string();
    assert!(said.contains("not determined"), "{said}");
    vague.covariance = None;
    assert!(identify(&skirt(), WEIGHT, &vague, Through::Ruled).unwrap_err().to_string().contains("not determined"));
}
