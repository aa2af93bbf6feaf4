//! Hard cases of the theory: limits, thresholds, crossings, and scenes outside it. Every one ends in an answer or a refusal that says why.

use hemline::experiment::{Fabric, Skirt};
use hemline::simulate::graded;
use hemline::simulate::ruled::threshold_rigidity;
use hemline::simulate::{Fidelity, Folds, Options, Prediction, Termination, predict};
use hemline::units::{KilogramPerSquareMetre, Metre, NewtonMetre};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn skirt(hem: f64) -> Skirt {
    Skirt::new(Metre(0.121), Metre(hem), Metre(0.53)).unwrap()
}

fn fabric(density: f64, rigidity: f64) -> Fabric {
    Fabric { areal_density: Some(KilogramPerSquareMetre(density)), flexural_rigidity: Some(NewtonMetre(rigidity)) }
}

fn ruled(hem: f64, rigidity: f64, folds: Folds, harmonics: usize) -> Prediction {
    let options = Options { fidelity: Fidelity::Ruled { harmonics }, folds, gravity: 9.81, ..Options::default() };
    predict(&skirt(hem), &fabric(0.2, rigidity), &options).unwrap()
}

fn close(value: f64, reference: f64, tolerance: f64, what: &str) {
    assert!((value - reference).abs() <= tolerance, "{what}: {value} against {reference}, {:.1e} apart", (value - reference).abs());
}

#[test]
fn round_cone_folds_exactly_below_its_threshold_rigidity() {
    // Two folds: what an oval hem gains by standing steeper it loses by leaning out; no cloth is soft enough.
    assert_eq!(threshold_rigidity(&skirt(0.2362), 1.962, 2), None);
    for m in 3..=9 {
        let threshold = threshold_rigidity(&skirt(0.2362), 1.962, m).unwrap();
        // The branch bifurcates smoothly, so a part in 10⁴ off the threshold leaves an amplitude of a percent, plain to see.
        let above = ruled(0.2362, threshold * (1.0 + 1e-4), Folds::Exactly(m), 1);
        let below = ruled(0.2362, threshold * (1.0 - 1e-4), Folds::Exactly(m), 1);
        assert_eq!((above.folds, above.termination), (0, Termination::Round), "m = {m}");
        assert_eq!(below.folds, m);
        let at = ruled(0.2362, threshold, Folds::Exactly(m), 8);
        assert!(at.energy.is_finite() && at.folds.is_multiple_of(m), "m = {m}: {at:?}");
    }
}

#[test]
fn stiff_cloth_stays_round_and_says_so() {
    let hem = ruled(0.2362, 1.0, Folds::Auto, 8);
    assert_eq!((hem.folds, hem.termination), (0, Termination::Round));
    assert_eq!((hem.hem_radius_min, hem.hem_radius_max), (0.2362, 0.2362));
    assert!(hem.coefficients.is_empty());
}

#[test]
fn cylinder_hangs_round_whatever_its_cloth() {
    for rigidity in [1e-8, 1e-5, 1.0] {
        let hem = ruled(0.121, rigidity, Folds::Auto, 4);
        assert_eq!((hem.folds, hem.termination), (0, Termination::Round));
    }
}

#[test]
fn low_folds_slide_to_a_subharmonic_and_the_true_period_is_reported() {
    let hem = ruled(0.2362, 2e-6, Folds::Exactly(3), 4);
    let own = ruled(0.2362, 2e-6, Folds::Exactly(6), 4);
    assert_eq!((hem.branches[0].asked, hem.folds), (3, 6));
    close(hem.energy, own.energy, 1e-12 * own.energy, "energy of the slid branch");
}

#[test]
fn softest_cloth_folds_sixty_times() {
    let hem = ruled(0.2362, 4e-10, Folds::Auto, 4);
    println!("{} folds, {} evaluations", hem.folds, hem.evaluations);
    assert!((40..=90).contains(&hem.folds));
    assert_eq!(hem.termination, Termination::Converged);
}

#[test]
fn prediction_scales_with_its_units() {
    // Lengths × s and B × s³ at the same ρ_A g is the same shape, at s³ times the energy.
    let reference = ruled(0.2362, 1e-5, Folds::Auto, 4);
    for s in [1e-6_f64, 1e6] {
        let skirt = Skirt::new(Metre(0.121 * s), Metre(0.2362 * s), Metre(0.53 * s)).unwrap();
        let options = Options { fidelity: Fidelity::Ruled { harmonics: 4 }, ..Options::default() };
        let hem = predict(&skirt, &fabric(0.2, 1e-5 * s.powi(3)), &options).unwrap();
        assert_eq!(hem.folds, reference.folds);
        // Quadratic convergence leaves rounding.
        close(hem.energy / s.powi(3), reference.energy, 1e-13 * reference.energy * 100.0, "energy");
        close(hem.depth() / s, reference.depth(), 1e-9, "depth");
    }
}

#[test]
fn scene_outside_the_theory_is_refused_with_the_reason() {
    let disc = Skirt::drapemeter(Metre(0.09), Metre(0.15)).unwrap();
    let refused = predict(&disc, &fabric(0.2, 1e-5), &Options::default()).unwrap_err().to_string();
    assert!(refused.contains("drape tester"), "{refused}");
    for (density, rigidity) in [(0.0, 1e-5), (-0.2, 1e-5), (0.2, 0.0), (0.2, -1e-5), (f64::NAN, 1e-5), (0.2, f64::INFINITY)] {
        let refused = predict(&skirt(0.2362), &fabric(density, rigidity), &Options::default()).unwrap_err().to_string();
        assert!(refused.contains("allowed is > 0"), "{refused}");
    }
    let unknown = predict(&skirt(0.2362), &Fabric::default(), &Options::default()).unwrap_err().to_string();
    assert!(unknown.contains("areal density"), "{unknown}");
    assert!(predict(&skirt(0.2362), &fabric(0.2, 1e-5), &Options { folds: Folds::Exactly(1), ..Options::default() }).is_err());
}

#[test]
fn every_scene_of_a_wide_sweep_ends_in_an_answer() {
    // 150 scenes: waists 5 to 30 cm, slants 10 to 100 cm, conicity 0 to 0.98, 50 to 500 g/m², 0.1 to 1000 µN·m.
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let mut uniform = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let mut worst = (0, String::new());
    for scene in 0..150 {
        let (waist, slant, conicity) = (uniform(0.05, 0.3), uniform(0.1, 1.0), uniform(0.0, 0.98));
        let (density, rigidity) = (uniform(0.05, 0.5), 10_f64.powf(uniform(-7.0, -3.0)));
        let skirt = Skirt::new(Metre(waist), Metre(waist + conicity * slant), Metre(slant)).unwrap();
        let what =
            format!("scene {scene}: waist {waist:.3}, slant {slant:.3}, conicity {conicity:.3}, {density:.3} kg/m², {rigidity:.2e} N·m");
        let hem = predict(&skirt, &fabric(density, rigidity), &Options::default()).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert!(matches!(hem.termination, Termination::Converged | Termination::Round), "{what}: {:?}", hem.termination);
        assert!(0.0 < hem.hem_radius_min && hem.hem_radius_min <= hem.hem_radius_max, "{what}");
        assert!(hem.branches.iter().all(|b| b.folds == 0 || hem.energy <= b.energy * (1.0 + 1e-9)), "{what}");
        if worst.0 < hem.evaluations {
            worst = (hem.evaluations, what);
        }
    }
    println!("most evaluations: {} in {}", worst.0, worst.1);
}

#[test]
fn every_scene_of_a_wide_sweep_has_a_graded_answer() {
    // 24 scenes drawn as above.
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut uniform = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let mut ends = Vec::new();
    for scene in 0..24 {
        let (waist, slant, conicity) = (uniform(0.05, 0.3), uniform(0.1, 1.0), uniform(0.0, 0.98));
        let (density, rigidity) = (uniform(0.05, 0.5), 10_f64.powf(uniform(-7.0, -3.0)));
        let skirt = Skirt::new(Metre(waist), Metre(waist + conicity * slant), Metre(slant)).unwrap();
        let what =
            format!("scene {scene}: waist {waist:.3}, slant {slant:.3}, conicity {conicity:.3}, {density:.3} kg/m², {rigidity:.2e} N·m");
        let options = Options { fidelity: Fidelity::Graded { harmonics: 3, modes: 5, shear: 0.0 }, ..Options::default() };
        let hem = predict(&skirt, &fabric(density, rigidity), &options).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert!(0.0 < hem.hem_radius_min && hem.hem_radius_min <= hem.hem_radius_max && hem.energy.is_finite(), "{what}");
        assert!(hem.outline.iter().all(|p| p.x.is_finite() && p.y.is_finite()), "{what}");
        ends.push(hem.termination);
    }
    let unfinished = ends.iter().filter(|t| !matches!(t, Termination::Converged | Termination::Round)).count();
    assert_eq!(unfinished, 0);
}

#[test]
fn nearly_flat_cone_still_has_an_answer_and_the_flat_one_is_refused() {
    // β from 37° down to 1.4e-4°: generatrices near the waist are nearly horizontal, and the round cone's own energy has a square root that is nearly 0.
    for conicity in [0.8, 0.95, 0.99, 0.999, 0.9999, 1.0 - 1e-6, 1.0 - 1e-8] {
        for rigidity in [1e-6, 1e-5, 1e-4] {
            let hem = ruled(0.121 + conicity * 0.53, rigidity, Folds::Auto, 4);
            assert_eq!(hem.termination, Termination::Converged, "conicity {conicity}, B {rigidity}");
            assert!(2 <= hem.folds);
        }
    }
    assert!(predict(&skirt(0.121 + 0.53), &fabric(0.2, 1e-5), &Options::default()).is_err());
}

#[test]
fn hem_longer_than_its_slant_reaches_is_refused_with_what_is_allowed() {
    let refused = Skirt::new(Metre(0.121), Metre(0.66), Metre(0.53)).unwrap_err().to_string();
    assert!(refused.contains("slant length") && refused.contains(">= hem radius"), "{refused}");
}

#[test]
fn two_folds_are_round_at_this_cut_and_an_oval_where_the_waist_is_narrow() {
    let hem = ruled(0.2362, 1e-3, Folds::Exactly(2), 4);
    assert_eq!((hem.folds, hem.termination), (0, Termination::Round));
    assert!(hem.notes.iter().any(|n| n.contains("stable against 2 folds")));
    // A narrow waist and a long slant: an oval hem then gains more by its straighter sides than it loses by its longer axis.
    let narrow = Skirt::new(Metre(0.05), Metre(0.45), Metre(2.0)).unwrap();
    let threshold = threshold_rigidity(&narrow, 1.962, 2).unwrap();
    let options = Options { folds: Folds::Exactly(2), ..Options::default() };
    let oval = predict(&narrow, &fabric(0.2, 0.9 * threshold), &options).unwrap();
    assert_eq!((oval.folds, oval.termination), (2, Termination::Converged));
}

#[test]
fn where_two_fold_counts_cost_the_same_both_are_reported() {
    // Five folds at 1e-5 N·m, six at 5e-6: bisect the rigidity at which they tie.
    let energies = |rigidity: f64| [5, 6].map(|m| ruled(0.2362, rigidity, Folds::Exactly(m), 4).energy);
    let (mut soft, mut stiff) = (5e-6_f64, 1e-5_f64);
    for _ in 0..50 {
        let middle = (soft * stiff).sqrt();
        let [five, six] = energies(middle);
        if five < six { stiff = middle } else { soft = middle }
    }
    let hem = ruled(0.2362, soft, Folds::Auto, 4);
    assert!(matches!(hem.folds, 5 | 6));
    let tied =
        hem.branches.iter().filter(|b| (b.energy / hem.energy - 1.0).abs() < 1e-9 && b.lowest_curvature.is_some_and(|c| 0.0 < c)).count();
    assert_eq!(tied, 2, "{:?}", hem.branches);
    // On either side of the tie the answer is the branch that has become cheaper.
    assert_eq!([ruled(0.2362, 1.001 * soft, Folds::Auto, 4).folds, ruled(0.2362, 0.999 * soft, Folds::Auto, 4).folds], [5, 6]);
}

#[test]
fn every_reported_branch_is_a_minimum_within_its_symmetry() {
    let hem = ruled(0.2362, 5e-6, Folds::Auto, 8);
    for branch in hem.branches.iter().filter(|b| b.folds != 0) {
        assert!(branch.lowest_curvature.is_some_and(|c| 0.0 < c), "{branch:?}");
        // It exists because its cloth is softer than the threshold of its fold count.
        assert!(branch.threshold_rigidity.is_some_and(|b| 5e-6 < b), "{branch:?}");
    }
    assert!(hem.branches.windows(2).all(|pair| pair[0].asked < pair[1].asked));
}

#[test]
fn same_question_has_the_same_answer_to_the_last_bit() {
    for fidelity in [Fidelity::Ruled { harmonics: 8 }, Fidelity::Graded { harmonics: 2, modes: 4, shear: 0.0 }, Fidelity::Ansatz] {
        let ask = || predict(&skirt(0.2362), &fabric(0.2, 1e-5), &Options { fidelity, ..Options::default() }).unwrap();
        assert_eq!(ask(), ask());
    }
}

#[test]
fn shear_stiffness_costs_energy_and_softer_cloth_than_none_is_refused() {
    let ask = |shear: f64| {
        let fidelity = Fidelity::Graded { harmonics: 2, modes: 5, shear };
        predict(&skirt(0.2362), &fabric(0.2, 1e-5), &Options { fidelity, folds: Folds::Exactly(5), ..Options::default() })
    };
    let energies: Vec<f64> = [0.0, 1e-3, 1e-2, 0.1].iter().map(|s| ask(*s).unwrap().energy).collect();
    assert!(energies.windows(2).all(|pair| pair[0] < pair[1]), "{energies:?}");
    assert!(0.0 < ask(1e-2).unwrap().energy_of("shear").unwrap());
    assert!(ask(0.0).unwrap().energy_of("shear").is_none());
    assert!(ask(-1.0).is_err());
}

#[test]
fn graded_cone_folds_exactly_below_its_own_threshold_which_is_lower_than_the_ruled_one() {
    for m in [3, 5, 8] {
        let threshold = graded::threshold_rigidity(&skirt(0.2362), 1.962, 0.0, m).unwrap();
        // Rings that keep their length are stiffer than rings that need not.
        assert!(threshold < threshold_rigidity(&skirt(0.2362), 1.962, m).unwrap());
        let at = |rigidity: f64| {
            let fidelity = Fidelity::Graded { harmonics: 1, modes: 8, shear: 0.0 };
            predict(&skirt(0.2362), &fabric(0.2, rigidity), &Options { fidelity, folds: Folds::Exactly(m), ..Options::default() }).unwrap()
        };
        // Eight modes of another width: the threshold itself holds to three digits or better.
        assert_eq!((at(1.002 * threshold).folds, at(0.998 * threshold).folds), (0, m), "m = {m}");
    }
}

#[test]
fn evaluation_counts_are_as_they_were() {
    // Golden: what a prediction costs, in evaluations of energy, gradient and Hessian. A change of these is a change of the method: say so.
    let count = |fidelity: Fidelity, folds: Folds, tolerance: Option<f64>| {
        let options = Options { fidelity, folds, tolerance: tolerance.map(Metre), ..Options::default() };
        predict(&skirt(0.2362), &fabric(0.2, 1e-5), &options).unwrap().evaluations
    };
    let counts = [
        count(Fidelity::Ruled { harmonics: 8 }, Folds::Exactly(5), None),
        count(Fidelity::Ruled { harmonics: 8 }, Folds::Auto, None),
        count(Fidelity::Ruled { harmonics: 8 }, Folds::Auto, Some(1e-4)),
        count(Fidelity::Graded { harmonics: 3, modes: 6, shear: 0.0 }, Folds::Exactly(5), None),
        count(Fidelity::Graded { harmonics: 3, modes: 6, shear: 0.0 }, Folds::Auto, None),
        count(Fidelity::Ansatz, Folds::Exactly(5), None),
        count(Fidelity::Polar { foundation: 0.0 }, Folds::Exactly(5), None),
    ];
    // Whether a last step is still needed hangs on rounding, and sine and cosine round differently on another processor: one evaluation or 2 %.
    for (count, golden) in counts.into_iter().zip([20_usize, 130, 243, 18, 131, 5, 102]) {
        assert!(count.abs_diff(golden) <= 1.max(golden / 50), "{counts:?}: {count} where {golden} were needed");
    }
}

#[test]
fn every_scene_of_a_wide_sweep_has_an_ansatz_and_a_polar_answer_or_a_reason() {
    // 40 scenes drawn as above; equation (4) at 2 to 12 folds.
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let mut uniform = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let mut refused = Vec::new();
    for scene in 0..40 {
        let (waist, slant, conicity) = (uniform(0.05, 0.3), uniform(0.1, 1.0), uniform(0.0, 0.98));
        let (density, rigidity) = (uniform(0.05, 0.5), 10_f64.powf(uniform(-7.0, -3.0)));
        let skirt = Skirt::new(Metre(waist), Metre(waist + conicity * slant), Metre(slant)).unwrap();
        let fabric = fabric(density, rigidity);
        let what =
            format!("scene {scene}: waist {waist:.3}, slant {slant:.3}, conicity {conicity:.3}, {density:.3} kg/m², {rigidity:.2e} N·m");
        let ansatz = predict(&skirt, &fabric, &Options { fidelity: Fidelity::Ansatz, ..Options::default() }).unwrap();
        assert!(matches!(ansatz.termination, Termination::Converged | Termination::Round), "{what}: {:?}", ansatz.termination);
        // A Ritz family within a wider one cannot do better than it (the ruled shell at many harmonics), whatever its fold count.
        let ruled = predict(&skirt, &fabric, &Options { fidelity: Fidelity::Ruled { harmonics: 12 }, ..Options::default() }).unwrap();
        assert!(ruled.energy <= ansatz.energy * (1.0 + 1e-6), "{what}: {} {}", ruled.energy, ansatz.energy);
        for m in 2..=12 {
            let options = Options { fidelity: Fidelity::Polar { foundation: 0.0 }, folds: Folds::Exactly(m), ..Options::default() };
            match predict(&skirt, &fabric, &options) {
                Ok(polar) => {
                    assert!(polar.energy.is_finite() && polar.outline.iter().all(|p| p.x.is_finite() && p.y.is_finite()), "{what}, m {m}")
                }
                Err(reason) => refused.push(format!("{what}, m {m}: {reason}")),
            }
        }
    }
    println!("{} of 440 polar questions refused; the first: {:?}", refused.len(), refused.first());
    assert!(refused.iter().all(|r| r.contains("reach further than the slant")), "{refused:?}");
}

#[test]
fn graded_prediction_scales_with_its_units() {
    let ask = |s: f64| {
        let skirt = Skirt::new(Metre(0.121 * s), Metre(0.2362 * s), Metre(0.53 * s)).unwrap();
        let options = Options { fidelity: Fidelity::Graded { harmonics: 2, modes: 4, shear: 0.0 }, ..Options::default() };
        predict(&skirt, &fabric(0.2, 1e-5 * s.powi(3)), &options).unwrap()
    };
    let reference = ask(1.0);
    for s in [1e-6_f64, 1e6] {
        let hem = ask(s);
        // Powers of ten round, so that a last step may be needed in one scale and not in the other.
        assert_eq!(hem.folds, reference.folds);
        assert!(hem.evaluations.abs_diff(reference.evaluations) <= 1.max(reference.evaluations / 50));
        close(hem.energy / s.powi(3), reference.energy, 1e-11 * reference.energy, "energy");
        close(hem.depth() / s, reference.depth(), 1e-9, "depth");
    }
}
