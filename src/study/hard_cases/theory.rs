//! Hard skirts: predictions at growing severity, against similarity, thresholds in closed form, and finer solutions of the same theory.

use super::{Answer, Case, Subject, digits};
use crate::error::Error;
use crate::experiment::{Fabric, Skirt};
use crate::simulate::ruled::threshold_rigidity;
use crate::simulate::{Effort, Fidelity, Folds, Options, Prediction, Termination, predict};
use crate::study::accuracy::apart;
use crate::units::{KilogramPerSquareMetre, Metre, NewtonMetre};

/// Waist, hem and slant of the skirt of docs/model.md, m; weight of its cloth, kg/m².
const WAIST: f64 = 0.121;
const HEM: f64 = 0.2362;
const SLANT: f64 = 0.53;
const DENSITY: f64 = 0.2;
const RIGIDITY: f64 = 1e-5;

/// Digits of the hem radius that the ruled shell with eight harmonics promises: a few hundredths of a millimetre.
const RULED: f64 = 3.6;
/// The same of the graded shell with 3 × 6 unknowns: some tenths of a millimetre.
const GRADED: f64 = 2.6;

fn cloth(density: f64, rigidity: f64) -> Fabric {
    Fabric { areal_density: Some(KilogramPerSquareMetre(density)), flexural_rigidity: Some(NewtonMetre(rigidity)) }
}

fn skirt(hem: f64) -> Result<Skirt, Error> {
    Skirt::new(Metre(WAIST), Metre(hem), Metre(SLANT))
}

fn ruled(harmonics: usize) -> Options {
    Options { fidelity: Fidelity::Ruled { harmonics }, ..Options::default() }
}

/// What the program said that should make a reader careful.
fn warning(hem: &Prediction) -> Option<String> {
    let mut said = hem.notes.clone();
    // What every prediction of a theory carries says nothing of this one.
    said.retain(|note| !note.contains("expect it a few millimetres away") && !note.contains("as given, not predicted"));
    if !matches!(hem.termination, Termination::Converged | Termination::Round) {
        said.push(format!("{:?}", hem.termination));
    }
    (!said.is_empty()).then(|| said.join("; "))
}

/// An answer held against a better one of the same fold count.
fn against(
    hem: Result<Prediction, Error>,
    better: impl FnOnce(&Prediction) -> Result<Prediction, Error>,
    radius: f64,
    promised: f64,
) -> Answer {
    let hem = match hem {
        Ok(hem) => hem,
        Err(refused) => return Answer::refused(refused),
    };
    let warning = warning(&hem);
    let better = match better(&hem) {
        Ok(better) => better,
        Err(refused) => return Answer { said: format!("no reference: {refused}"), ..Answer::refused("") },
    };
    let kept = if hem.folds == better.folds {
        apart::hems(&better.outline, &hem.outline).map_or(0.0, |apart| digits(apart.rms / radius))
    } else {
        0.0
    };
    // The stiffest direction of the energy over the softest: what a change of the load is enlarged by.
    Answer { evaluations: Some(hem.evaluations), ..Answer::judged(kept, promised, warning) }
}

/// Everything longer by 10ᵏ, and the rigidity so that the shape is the same.
fn units(power: f64, _: u64) -> Answer {
    let scale = 10f64.powf(power);
    let ask = |scale: f64| {
        let skirt = Skirt::new(Metre(WAIST * scale), Metre(HEM * scale), Metre(SLANT * scale))?;
        predict(&skirt, &cloth(DENSITY, RIGIDITY * scale.powi(3)), &ruled(8))
    };
    let shrunk = |hem: Prediction| {
        let outline = hem.outline.iter().map(|p| crate::experiment::Point::new(p.x / scale, p.y / scale)).collect();
        Prediction { outline, ..hem }
    };
    // Newton's last step, 1e-9 of the unknowns, leaves its square.
    against(ask(scale).map(shrunk), |_| ask(1.0), HEM, 10.0)
}

/// Rigidity below the threshold of five folds by this share: folds grow as its root (Landau), the factor from 10⁻³ and 5·10⁻⁴ below.
fn threshold(share: f64, _: u64) -> Answer {
    let run = || -> Result<Answer, Error> {
        let skirt = skirt(HEM)?;
        let limit = threshold_rigidity(&skirt, DENSITY * crate::units::STANDARD_GRAVITY, 5)
            .ok_or_else(|| Error::Unanswerable("five folds have no threshold".into()))?;
        let at = |share: f64| predict(&skirt, &cloth(DENSITY, limit * (1.0 - share)), &Options { folds: Folds::Exactly(5), ..ruled(8) });
        let hem = at(share)?;
        // Depth is c √δ (1 + b δ + …): two depths give c to a part in 10⁶.
        let factor = |share: f64| at(share).map(|hem| hem.depth() / share.sqrt());
        let (one, half) = (factor(1e-3)?, factor(5e-4)?);
        let slope = (one - half) / 5e-4;
        let expected = (half - slope * 5e-4 + slope * share) * share.sqrt();
        let kept = digits((hem.depth() - expected).abs() / HEM);
        Ok(Answer { condition: Some(1.0 / share.sqrt()), evaluations: Some(hem.evaluations), ..Answer::judged(kept, RULED, warning(&hem)) })
    };
    run().unwrap_or_else(Answer::refused)
}

/// A finer ruled shell at the fold count of `hem`.
fn finer(skirt: &Skirt, fabric: &Fabric, hem: &Prediction) -> Result<Prediction, Error> {
    let folds = if hem.folds == 0 { Folds::Auto } else { Folds::Exactly(hem.folds) };
    predict(skirt, fabric, &Options { folds, effort: Effort { nodes: Some(384), ..Effort::default() }, ..ruled(32) })
}

fn flat_cone(distance: f64, _: u64) -> Answer {
    let run = || -> Result<Answer, Error> {
        let (skirt, fabric) = (skirt(WAIST + (1.0 - distance) * SLANT)?, cloth(DENSITY, RIGIDITY));
        Ok(against(predict(&skirt, &fabric, &ruled(8)), |hem| finer(&skirt, &fabric, hem), skirt.hem_radius().0, RULED))
    };
    run().unwrap_or_else(Answer::refused)
}

fn soft_cloth(rigidity: f64, _: u64) -> Answer {
    let run = || -> Result<Answer, Error> {
        let (skirt, fabric) = (skirt(HEM)?, cloth(DENSITY, rigidity));
        let answer = against(predict(&skirt, &fabric, &ruled(8)), |hem| finer(&skirt, &fabric, hem), HEM, RULED);
        Ok(answer)
    };
    run().unwrap_or_else(Answer::refused)
}

/// Rigidity off the tie of five and six folds by this share, on either side: the cheaper one must be taken.
fn tie(share: f64, _: u64) -> Answer {
    let run = || -> Result<Answer, Error> {
        let skirt = skirt(HEM)?;
        let energy = |rigidity: f64, folds: u32| {
            predict(&skirt, &cloth(DENSITY, rigidity), &Options { folds: Folds::Exactly(folds), ..ruled(4) }).map(|hem| hem.energy)
        };
        let (mut soft, mut stiff) = (5e-6_f64, 1e-5_f64);
        for _ in 0..46 {
            let middle = (soft * stiff).sqrt();
            if energy(middle, 5)? < energy(middle, 6)? { stiff = middle } else { soft = middle }
        }
        let (mut worst, mut evaluations) = (0.0_f64, 0);
        for rigidity in [soft * (1.0 + share), soft * (1.0 - share)] {
            let hem = predict(&skirt, &cloth(DENSITY, rigidity), &ruled(4))?;
            let least = energy(rigidity, 5)?.min(energy(rigidity, 6)?);
            worst = worst.max((hem.energy - least) / least);
            evaluations += hem.evaluations;
        }
        // A branch that gains less than a part in 10¹² is not taken for better.
        Ok(Answer { evaluations: Some(evaluations), ..Answer::judged(digits(worst), 11.0, None) })
    };
    run().unwrap_or_else(Answer::refused)
}

fn polar(hem: f64, folds: u32) -> Answer {
    let run = || -> Result<Answer, Error> {
        let (skirt, fabric) = (skirt(hem)?, cloth(DENSITY, RIGIDITY));
        let ask = |nodes: Option<usize>| {
            let effort = Effort { nodes, ..Effort::default() };
            let fidelity = Fidelity::Polar { foundation: 0.0 };
            predict(&skirt, &fabric, &Options { fidelity, folds: Folds::Exactly(folds), effort, ..Options::default() })
        };
        Ok(against(ask(None), |_| ask(Some(1024)), hem, 6.0))
    };
    run().unwrap_or_else(Answer::refused)
}

/// Equation (4) for a hem longer than its onset by this share.
fn polar_onset(share: f64, _: u64) -> Answer {
    let weight = DENSITY * crate::units::STANDARD_GRAVITY;
    let onset = skirt(HEM).ok().and_then(|skirt| crate::simulate::polar::range(&skirt, weight, 0.0, 5)).map(|range| range.onset);
    match onset {
        Some(onset) => Answer { condition: Some(1.0 / share.sqrt()), ..polar(onset * (1.0 + share), 5) },
        None => Answer::refused("five folds have no onset"),
    }
}

fn polar_folds(folds: f64, _: u64) -> Answer {
    polar(0.1452, folds as u32)
}

/// The graded shell of cloth this soft, against 5 × 12 unknowns.
fn graded(rigidity: f64, _: u64) -> Answer {
    let run = || -> Result<Answer, Error> {
        let (skirt, fabric) = (skirt(HEM)?, cloth(DENSITY, rigidity));
        let ask = |harmonics: usize, modes: usize, folds: Folds| {
            predict(&skirt, &fabric, &Options { fidelity: Fidelity::Graded { harmonics, modes, shear: 0.0 }, folds, ..Options::default() })
        };
        let folds = |hem: &Prediction| if hem.folds == 0 { Folds::Auto } else { Folds::Exactly(hem.folds) };
        Ok(against(ask(3, 6, Folds::Auto), |hem| ask(5, 12, folds(hem)), HEM, GRADED))
    };
    run().unwrap_or_else(Answer::refused)
}

/// The theory's cases.
pub fn cases() -> Vec<Case> {
    let case = |name, title, reference, severities, run| Case { subject: Subject::Theory, name, title, reference, severities, run };
    let finer = "the same with 32 harmonics and 384 nodes";
    vec![
        case("units", "lengths × 10ᵏ", "similarity", [1.0, 2.0, 3.0, 6.0, 12.0, 30.0, 60.0, 90.0], units),
        case(
            "threshold",
            "ruled: below the threshold rigidity, share",
            "Landau’s law from 10⁻³ below",
            [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-13],
            threshold,
        ),
        case("flat_cone", "ruled: 1 − conicity", finer, [0.8, 0.5, 0.2, 0.1, 1e-2, 1e-4, 1e-8, 0.0], flat_cone),
        case("soft_cloth", "ruled: rigidity, N·m", finer, [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10], soft_cloth),
        case(
            "tie",
            "ruled: rigidity off a tie of 5 and 6 folds",
            "the cheaper of both",
            [1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 0.0],
            tie,
        ),
        case(
            "polar_onset",
            "equation (4): hem above the onset, share",
            "the same with 1024 nodes",
            [0.2, 0.1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12],
            polar_onset,
        ),
        case(
            "polar_folds",
            "equation (4): folds",
            "the same with 1024 nodes",
            [3.0, 4.0, 6.0, 10.0, 20.0, 50.0, 100.0, 500.0],
            polar_folds,
        ),
        case("graded", "graded: rigidity, N·m", "the same with 5 × 12 unknowns", [1e-3, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7], graded),
    ]
}
