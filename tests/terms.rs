//! Energy terms of both shells: derivatives, limits, what is off costs nothing, and the honesty of the screen.

use std::f64::consts::TAU;

use hemline::experiment::scene::{Body, BodyShape, Choice, ClothDetail, Scene, Term, TermSet, Theory, WaistEdge};
use hemline::experiment::{Apparatus, Fabric, Skirt};
use hemline::model::energy::Terms;
use hemline::model::energy::body_contact::BodyContact;
use hemline::model::energy::foundation::Foundation;
use hemline::model::energy::self_contact::SelfContact;
use hemline::model::energy::shear::Shear;
use hemline::model::energy::stretch::Stretch;
use hemline::model::graded::{GradedShell, HeightBasis, Setup};
use hemline::model::graded_terms::GradedTerms;
use hemline::model::ruled_terms::RuledTerms;
use hemline::model::tangent::RuledShell;
use hemline::numerics::minimize::{self, Expansion, Smooth, minimize};
use hemline::simulate::scene::hem_movement;
use hemline::simulate::{Fidelity, Options, Termination, predict, predict_scene, screen_scene};
use hemline::units::{KilogramPerSquareMetre, Metre, NewtonMetre};
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

fn skirt() -> Skirt {
    Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap()
}

fn cylinder(radius: f64) -> Body {
    Body { shape: BodyShape::Cylinder, waist_radius: None, hip_radius: Metre(radius), hip_depth: None }
}

/// Table 1's skirt, 200 g/m², 10 µN·m.
fn scene() -> Scene {
    Scene {
        title: None,
        apparatus: Apparatus::Skirt,
        skirt: skirt(),
        waist_edge: WaistEdge::Hinged,
        seams: 0,
        fabric: Fabric { areal_density: Some(KilogramPerSquareMetre(0.2)), flexural_rigidity: Some(NewtonMetre(1e-5)) },
        detail: ClothDetail::default(),
        body: None,
        choice: Choice::Exactly(TermSet::usual()),
        theory: Theory::Ruled,
        folds: None,
        tolerance: None,
        gravity: 9.81,
    }
}

fn with(terms: &[Term]) -> Choice {
    Choice::Exactly(terms.iter().fold(TermSet::usual(), |set, term| set.with(*term)))
}

/// All terms, over a cylinder of this radius, m.
fn everything(body: f64) -> Terms {
    let skirt = skirt();
    Terms {
        foundation: Some(Foundation::new(&skirt, 3.0)),
        shear: Some(Shear::new(0.02)),
        stretch: Some(Stretch { rings: 40.0, generatrices: 60.0 }),
        body: Some(BodyContact::new(&skirt, &cylinder(body), 1.962).unwrap()),
        folds: Some(SelfContact::new(1.962, 3e-4, 0.53)),
        ..Terms::usual(1.962, 1e-5)
    }
}

const SETUP: Setup = Setup {
    weight: 0.0,
    rigidity: 0.0,
    shear: 0.0,
    folds: 5,
    harmonics: 2,
    modes: 3,
    basis: HeightBasis::Layer { width: 0.05 },
    half: 24,
    slices: 20,
};

/// Largest error of gradient and Hessian against central differences, relative to the largest entry of the Hessian.
fn worst(expand: &dyn Fn(&DVector<f64>) -> Expansion, at: &DVector<f64>) -> (f64, f64) {
    let (exact, h) = (expand(at), 1e-5);
    let scale = exact.hessian.amax();
    let (mut first, mut second) = (0.0_f64, 0.0_f64);
    for k in 0..at.len() {
        let step = DVector::from_fn(at.len(), |i, _| if i == k { h } else { 0.0 });
        let (up, down) = (expand(&(at + &step)), expand(&(at - &step)));
        first = first.max((exact.gradient[k] - (up.value - down.value) / (2.0 * h)).abs() / scale);
        second = second.max((exact.hessian.column(k) - (up.gradient - down.gradient) / (2.0 * h)).amax() / scale);
    }
    (first, second)
}

#[test]
fn derivatives_of_every_term_agree_with_central_differences() {
    let singles = Term::ALL.into_iter().map(|term| TermSet::none().with(term));
    for set in singles.chain([everything(0.05).set().without(Term::SelfContact)]) {
        let wall = set.contains(Term::BodyContact) || set.contains(Term::SelfContact);
        // Folds grow until a wall is felt.
        let mut amplitude = 1.0;
        let (ruled, x) = loop {
            let without = RuledTerms::new(&skirt(), &everything(0.05).only(set.without(Term::BodyContact)), 5, 3, 24, 12);
            let x = DVector::from_fn(without.strains() + 3, |i, _| match i.checked_sub(without.strains()) {
                None => 0.3 - 0.1 * i as f64,
                Some(k) => amplitude * [1.15, -0.08, 0.03][k],
            });
            let valley = without.curve(&x).radius_range().0;
            let shell = RuledTerms::new(&skirt(), &everything(valley - 1.5e-3).only(set), 5, 3, 24, 12);
            let felt = shell.ledger(&x).expect("short of the wall").energy.iter().all(|e| *e == 0.0);
            if !felt || !wall {
                break (shell, x);
            }
            amplitude += 5e-3;
        };
        let (first, second) = worst(&|x| ruled.expand(x).unwrap(), &x);
        let mut amplitude = 1.0;
        let (graded, y) = loop {
            let without = GradedTerms::new(&skirt(), &everything(0.05).only(set.without(Term::BodyContact)), SETUP);
            let alpha = [1.45, -0.25, 0.1, -0.1, 0.05, 0.02];
            let y = DVector::from_fn(6 + without.strains(), |i, _| alpha.get(i).map_or(0.2 - 0.02 * i as f64, |a| amplitude * a));
            let valley = without.curve(&y).radius_range().0;
            let shell = GradedTerms::new(&skirt(), &everything(valley - 1.5e-3).only(set), SETUP);
            let felt = shell.ledger(&y).expect("short of the wall").energy.iter().all(|e| *e == 0.0);
            if !felt || !wall {
                break (shell, y);
            }
            amplitude += 5e-3;
        };
        let (third, fourth) = worst(&|x| graded.expand(x).unwrap(), &y);
        println!("{}: ruled {first:.1e} {second:.1e}, graded {third:.1e} {fourth:.1e}", set.names());
        // Truncation h²f‴/6 and rounding eps·U/h, relative to the scale of the function; a wall's third derivative is steep.
        let (slope, curvature) = if wall { (1e-5, 1e-4) } else { (1e-9, 1e-8) };
        assert!(first < slope && third < slope && second < curvature && fourth < curvature, "{}", set.names());
        // A term that is not felt would prove nothing.
        for ledger in [ruled.ledger(&x).unwrap(), graded.ledger(&y).unwrap()] {
            assert!(set.iter().all(|term| ledger.of(term) != 0.0), "{}: {ledger:?}", set.names());
        }
    }
}

#[test]
fn stretchable_cloth_that_is_not_stretched_has_the_energy_of_inextensible_cloth() {
    // Two independent codes for weight, rigidity and shear: the sweeps of the inextensible shells, and the nested maps of the extensible ones.
    let firm = Stretch { rings: 1e3, generatrices: 1e3 };
    let terms = Terms { stretch: Some(firm), shear: Some(Shear::new(0.02)), ..Terms::usual(1.962, 1e-5) };
    let alpha = DVector::from_vec(vec![1.45, -0.25, 0.1, -0.1, 0.05, 0.02]);
    let own = GradedShell::new(&skirt(), Setup { weight: 1.962, rigidity: 1e-5, shear: 0.02, ..SETUP });
    let budget = own.budget(&alpha).unwrap();
    let graded = GradedTerms::new(&skirt(), &terms, SETUP);
    let ledger = graded.ledger(&alpha.clone().resize_vertically(6 + graded.strains(), 0.0)).unwrap();
    for (term, energy) in [(Term::Gravity, budget.gravity), (Term::Bending, budget.bending), (Term::Shear, budget.shear)] {
        // The same sums in another order.
        assert!((ledger.of(term) / energy - 1.0).abs() < 1e-11, "{}: {} {energy}", term.name(), ledger.of(term));
    }
    let a = DVector::from_vec(vec![1.15, -0.08, 0.03]);
    let budget = RuledShell::new(&skirt(), 1.962, 1e-5, 5, 3, 24, 24).budget(&a).unwrap();
    let ruled = RuledTerms::new(&skirt(), &terms, 5, 3, 24, 24);
    let ledger = ruled.ledger(&DVector::from_fn(ruled.strains() + 3, |i, _| i.checked_sub(ruled.strains()).map_or(0.0, |k| a[k]))).unwrap();
    assert!((ledger.of(Term::Gravity) / budget.gravity - 1.0).abs() < 1e-12);
    // A total derivative that one of them leaves out is integrated here.
    assert!((ledger.of(Term::Bending) / budget.bending - 1.0).abs() < 1e-9, "{} {}", ledger.of(Term::Bending), budget.bending);
}

#[test]
fn foundation_of_the_round_cone_has_its_closed_form() {
    // π E ΔR² L (R_t/3 + ΔR/4): the integral of (E/2)(u ΔR)² over the cone.
    let (modulus, lean) = (7.0, 0.2362 - 0.121);
    let exact = std::f64::consts::PI * modulus * lean * lean * 0.53 * (0.121 / 3.0 + lean / 4.0);
    let terms = Terms { foundation: Some(Foundation::new(&skirt(), modulus)), ..Terms::default() };
    let ruled = RuledTerms::new(&skirt(), &terms, 5, 1, 24, 12).ledger(&DVector::zeros(1)).unwrap();
    let graded = GradedTerms::new(&skirt(), &terms, SETUP).ledger(&DVector::zeros(6)).unwrap();
    for ledger in [ruled, graded] {
        // A polynomial of degree three in u: Gauss–Legendre is exact for it.
        assert!((ledger.of(Term::Foundation) / exact - 1.0).abs() < 1e-13);
        assert_eq!(ledger.total(), ledger.of(Term::Foundation));
    }
}

#[test]
fn stretch_vanishes_like_one_over_its_stiffness() {
    for theory in [Theory::Ruled, Theory::Graded] {
        let at = |stiffness: Option<f64>| {
            let detail = ClothDetail { ring_stiffness: stiffness, generatrix_stiffness: stiffness, ..ClothDetail::default() };
            let choice = stiffness.map_or(with(&[]), |_| with(&[Term::Stretch]));
            let size = match theory {
                Theory::Ruled => Fidelity::Ruled { harmonics: 4 },
                _ => Fidelity::Graded { harmonics: 1, modes: 4, shear: 0.0 },
            };
            predict_scene(&Scene { detail, choice, theory, folds: Some(5), ..scene() }, Some(size)).unwrap()
        };
        let rigid = at(None);
        let moved: Vec<f64> = [1e4, 1e5, 1e6].map(|k| hem_movement(&rigid, &at(Some(k)))).to_vec();
        println!("{theory:?}: {moved:?}");
        // First order in 1/K: a tenth each time, to a percent where K is large (the next term is of order ρ_A g L/K ~ 1e-4).
        for pair in moved.windows(2) {
            assert!((pair[0] / pair[1] / 10.0 - 1.0).abs() < 0.01, "{theory:?}: {moved:?}");
        }
        // And the energy comes from below: an unknown more never costs.
        assert!(at(Some(1e4)).energy < rigid.energy);
    }
}

#[test]
fn cloth_that_sags_below_its_own_length_has_an_answer_though_its_energy_is_negative() {
    let detail = ClothDetail { ring_stiffness: Some(10.0), generatrix_stiffness: Some(10.0), ..ClothDetail::default() };
    let heavy = Fabric { areal_density: Some(KilogramPerSquareMetre(0.4)), flexural_rigidity: Some(NewtonMetre(5e-6)) };
    let upright = Skirt::new(Metre(0.12), Metre(0.15), Metre(0.8)).unwrap();
    let sagging = Scene { detail, fabric: heavy, skirt: upright, choice: with(&[Term::Stretch]), ..scene() };
    for (theory, size) in
        [(Theory::Ruled, Fidelity::Ruled { harmonics: 4 }), (Theory::Graded, Fidelity::Graded { harmonics: 1, modes: 4, shear: 0.0 })]
    {
        let hung = predict_scene(&Scene { theory, ..sagging.clone() }, Some(size)).unwrap();
        println!("{theory:?}: {} folds, {} J, {:?} {:?}", hung.folds, hung.energy, hung.termination, hung.notes);
        assert!(hung.energy < 0.0 && matches!(hung.termination, Termination::Converged | Termination::Round));
        // The walk over fold counts found one that costs no more than any that it saw.
        assert!(hung.branches.iter().all(|b| hung.energy <= b.energy + 1e-6 * b.energy.abs()), "{:?}", hung.branches);
    }
}

#[test]
fn what_is_off_is_never_evaluated_and_leaves_every_bit() {
    let plain = predict(&skirt(), &scene().fabric, &Options::default()).unwrap();
    let detail = ClothDetail {
        shear_stiffness: Some(40.0),
        ring_stiffness: Some(1e4),
        foundation_modulus: Some(5.0),
        thickness: Some(Metre(5e-4)),
        ..ClothDetail::default()
    };
    let dressed = Scene { detail, body: Some(cylinder(0.05)), ..scene() };
    let off = predict_scene(&dressed, None).unwrap();
    assert_eq!(plain, off);
    assert_eq!(off.terms.iter().map(|t| t.term).collect::<Vec<_>>(), ["gravity", "bending"]);
    let graded = Fidelity::Graded { harmonics: 2, modes: 4, shear: 0.0 };
    let plain = predict(&skirt(), &scene().fabric, &Options { fidelity: graded, ..Options::default() }).unwrap();
    assert_eq!(plain, predict_scene(&Scene { theory: Theory::Graded, ..dressed }, Some(graded)).unwrap());
    // Each shell counts what it evaluates: of one term, that term alone.
    let all = everything(0.05);
    for term in Term::ALL {
        let terms = all.only(TermSet::none().with(term));
        let ruled = RuledTerms::new(&skirt(), &terms, 5, 3, 24, 12);
        ruled.expand(&DVector::zeros(ruled.strains() + 3)).unwrap();
        let graded = GradedTerms::new(&skirt(), &terms, SETUP);
        graded.expand(&DVector::zeros(6 + graded.strains())).unwrap();
        for counts in [ruled.evaluations(), graded.evaluations()] {
            assert_eq!(counts, std::array::from_fn(|i| usize::from(i == term as usize)), "{}", term.name());
        }
    }
}

#[test]
fn the_multiplier_is_what_a_longer_hem_changes_of_the_least_energy_under_all_terms_but_stretch() {
    /// The least energy near `x`, J.
    fn least(shell: &impl Smooth, x: &DVector<f64>) -> f64 {
        let minimum = minimize(shell, x.clone(), &minimize::Options::default()).unwrap();
        assert!(0.0 < minimum.lowest_curvature());
        minimum.at.value
    }
    // Truncation h² U‴/6 with U‴ ~ U/(3 mm)³ at a wall's reach; rounding eps·U/h.
    let h = 1e-5;
    let set = Term::ALL.into_iter().filter(|term| *term != Term::Stretch).fold(TermSet::none(), |set, term| set.with(term));
    // The valley would come within 78 mm of the axis: the body is in touch.
    let terms = everything(0.0765).only(set);
    let ruled = RuledTerms::new(&skirt(), &terms, 5, 3, 32, 24);
    let graded = GradedTerms::new(&skirt(), &terms, SETUP);
    let at = minimize(&ruled, DVector::from_vec(vec![1.1, -0.08, 0.03]), &minimize::Options::default()).unwrap().x;
    assert!(ruled.gaps(&at).body.is_some_and(|gap| gap < 3e-3), "the body is felt");
    let numeric = (least(&ruled.lengthened(h), &at) - least(&ruled.lengthened(-h), &at)) / (2.0 * h) / TAU;
    let multiplier = ruled.length_multiplier(&at).unwrap();
    assert!((multiplier / numeric - 1.0).abs() < 1e-4, "ruled {multiplier} {numeric}");
    let start = DVector::from_fn(6, |i, _| if i == 0 { 1.0 } else { 0.0 });
    let at = minimize(&graded, start, &minimize::Options::default()).unwrap().x;
    let numeric = (least(&graded.lengthened(h), &at) - least(&graded.lengthened(-h), &at)) / (2.0 * h) / TAU;
    let multiplier = graded.length_multiplier(&at).unwrap();
    assert!((multiplier / numeric - 1.0).abs() < 1e-4, "graded {multiplier} {numeric}");
    // Where rings stretch no length is held.
    let stretched = RuledTerms::new(&skirt(), &everything(0.05), 5, 3, 24, 12);
    assert_eq!(stretched.length_multiplier(&DVector::zeros(stretched.strains() + 3)), None);
}

#[test]
fn a_body_out_of_reach_changes_nothing() {
    let far = Scene { body: Some(cylinder(0.05)), choice: with(&[Term::BodyContact]), folds: Some(5), ..scene() };
    let (touched, free) = (predict_scene(&far, None).unwrap(), predict_scene(&Scene { folds: Some(5), ..scene() }, None).unwrap());
    // Found on twice the nodes; the energy holds to the quadrature's ten digits, the hem to five.
    assert!(hem_movement(&touched, &free) < 1e-7, "{}", hem_movement(&touched, &free));
    assert_eq!(touched.energy_of("body_contact"), Some(0.0));
    // The valley is 78 mm from the axis.
    assert!((touched.contacts[0].smallest_gap.unwrap() - (free.hem_radius_min - 0.05)).abs() < 2e-3);
    // And the screen does not even ask for it.
    let auto = predict_scene(&Scene { choice: Choice::Auto, ..far }, None).unwrap();
    assert!(auto.terms.iter().all(|t| t.term != "body_contact") && hem_movement(&auto, &free) < 1e-12);
}

#[test]
fn cloth_never_goes_through_a_body_or_another_fold() {
    // Valleys that would hang at 78 mm from the axis, over a body of 80 to 118 mm; by every shape.
    let hips = |shape: BodyShape, hip: f64| Body { shape, waist_radius: None, hip_radius: Metre(hip), hip_depth: Some(Metre(0.2)) };
    let bodies = [cylinder(0.09), cylinder(0.118), hips(BodyShape::Cone, 0.15), hips(BodyShape::Ellipsoid, 0.145)];
    for body in bodies {
        for (theory, size) in
            [(Theory::Ruled, Fidelity::Ruled { harmonics: 4 }), (Theory::Graded, Fidelity::Graded { harmonics: 1, modes: 4, shear: 0.0 })]
        {
            let hung =
                predict_scene(&Scene { body: Some(body), choice: with(&[Term::BodyContact]), theory, ..scene() }, Some(size)).unwrap();
            let contact = hung.contacts[0];
            println!(
                "{:?} {:?} {theory:?}: {} folds, {contact:?}, {:?} {:?}",
                body.shape, body.hip_radius, hung.folds, hung.termination, hung.notes
            );
            assert!(contact.smallest_gap.is_some_and(|gap| 0.0 < gap));
            // Where the wall is felt it costs, and nowhere else; the gap is seen on a finer grid than the energy.
            let (energy, gap) = (hung.energy_of("body_contact").unwrap(), contact.smallest_gap.unwrap());
            assert!(if gap < 0.9 * contact.reach { 0.0 < energy } else { energy < 1e-6 * hung.energy } && 0.0 < contact.stiffness);
            // The hem itself, wherever it is looked at: it hangs lower than the hips, outside a cylinder all the same.
            if body.shape == BodyShape::Cylinder {
                assert!(hung.outline.iter().all(|p| body.hip_radius.0 < p.x.hypot(p.y)), "{}", hung.hem_radius_min);
            }
        }
    }
}

#[test]
fn folds_that_would_cross_lean_on_each_other() {
    // Limp cloth in a wide hem: without the term the flanks of a fold pass through each other.
    let limp = Fabric { areal_density: Some(KilogramPerSquareMetre(0.2)), flexural_rigidity: Some(NewtonMetre(1e-5)) };
    let wide = Skirt::new(Metre(0.08), Metre(0.33), Metre(0.55)).unwrap();
    let base = Scene { skirt: wide, fabric: limp, folds: Some(4), ..scene() };
    let size = Some(Fidelity::Ruled { harmonics: 4 });
    let free = predict_scene(&base, size).unwrap();
    let leaning = predict_scene(&Scene { choice: with(&[Term::SelfContact]), ..base.clone() }, size).unwrap();
    let contact = leaning.contacts[0];
    println!("{contact:?}, moved {} m, {:?}", hem_movement(&free, &leaning), leaning.notes);
    // In polar angle, the crest's flank crosses its mirror plane in the one and stays on its side in the other.
    let least = |outline: &[hemline::experiment::Point]| outline[1..outline.len() / 8].iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    assert!(least(&free.outline) < 0.0, "the scene is no test: {}", least(&free.outline));
    assert!(0.0 < least(&leaning.outline) && contact.smallest_gap.is_some_and(|gap| 0.0 < gap));
    assert!(free.energy < leaning.energy);
    let (set, screening) = screen_scene(&base, size).unwrap();
    assert!(set.contains(Term::SelfContact), "{screening:?}");
}

#[test]
fn what_no_theory_covers_is_said() {
    let ask = |scene: Scene| predict_scene(&scene, None).unwrap_err().to_string();
    let tester = Scene { apparatus: Apparatus::Drapemeter, skirt: Skirt::drapemeter(Metre(0.09), Metre(0.15)).unwrap(), ..scene() };
    assert!(ask(tester).contains("no fidelity here applies: cloth on a drape tester"));
    let short = Skirt::new(Metre(0.09), Metre(0.12), Metre(0.06)).unwrap();
    assert!(ask(Scene { skirt: short, ..scene() }).contains("stands off rather than hangs"));
    let middle = Skirt::new(Metre(0.09), Metre(0.12), Metre(0.12)).unwrap();
    assert!(ask(Scene { skirt: middle, waist_edge: WaistEdge::Clamped, ..scene() }).contains("clamped"));
    assert!(predict_scene(&Scene { skirt: middle, ..scene() }, None).is_ok());
    let woven = |ratio: f64| ClothDetail { warp_and_weft: Some((1e-5 * ratio, 1e-5)), ..ClothDetail::default() };
    assert!(ask(Scene { detail: woven(1.5), ..scene() }).contains("full period"));
    assert!(predict_scene(&Scene { detail: woven(1.02), ..scene() }, None).is_ok());
    assert!(ask(Scene { seams: 2, ..scene() }).contains("seam"));
    assert!(ask(Scene { choice: with(&[Term::Shear]), ..scene() }).contains("shear_stiffness_n_m"));
    assert!(ask(Scene { choice: Choice::Exactly(TermSet::none().with(Term::Gravity)), ..scene() }).contains("add “bending”"));
    let wide = Body { shape: BodyShape::Cone, waist_radius: None, hip_radius: Metre(0.19), hip_depth: Some(Metre(0.2)) };
    assert!(ask(Scene { body: Some(wide), choice: with(&[Term::BodyContact]), ..scene() }).contains("do not go through the skirt"));
    assert!(
        ask(Scene { theory: Theory::Ansatz, choice: with(&[Term::Shear]), ..scene() })
            .contains("has the terms gravity, bending and no others")
    );
    assert!(ask(Scene { folds: Some(1), ..scene() }).contains("2 to 512"));
}

#[test]
fn weight_and_rigidity_can_be_left_out_each() {
    let alone = |term: Term| Scene { choice: Choice::Exactly(TermSet::none().with(term)), folds: Some(5), ..scene() };
    let weightless = predict_scene(&alone(Term::Bending), None).unwrap();
    assert_eq!((weightless.folds, weightless.termination), (0, Termination::Round));
    assert_eq!(weightless.terms.iter().map(|t| t.term).collect::<Vec<_>>(), ["bending"]);
    let limp = predict_scene(&alone(Term::Gravity), Some(Fidelity::Ruled { harmonics: 2 })).unwrap();
    assert_eq!(limp.terms.iter().map(|t| t.term).collect::<Vec<_>>(), ["gravity"]);
    // Less energy than the weight of the hem that rigidity holds out.
    let stiff = predict_scene(&Scene { folds: Some(5), ..scene() }, None).unwrap();
    assert!(limp.energy < stiff.energy_of("gravity").unwrap());
}

/// A scene drawn from wide ranges.
fn drawn(seed: u64) -> (Scene, Fidelity) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    loop {
        let (waist, slant, conicity) = (uniform(0.08, 0.2), uniform(0.25, 0.9), uniform(0.02, 0.6));
        let (density, rigidity) = (uniform(0.08, 0.4), 10_f64.powf(uniform(-6.5, -4.3)));
        let mut maybe = |low: f64, high: f64| {
            let (there, value) = (uniform(0.0, 1.0) < 0.6, 10_f64.powf(uniform(low, high)));
            there.then_some(value)
        };
        let detail = ClothDetail {
            shear_stiffness: maybe(-5.0, 1.5),
            ring_stiffness: maybe(1.0, 5.0),
            generatrix_stiffness: maybe(1.0, 5.0),
            foundation_modulus: maybe(-4.0, 1.5),
            thickness: maybe(-4.0, -3.0).map(Metre),
            warp_and_weft: None,
        };
        let skirt = Skirt::new(Metre(waist), Metre(waist + conicity * slant), Metre(slant)).unwrap();
        let hip_depth = uniform(0.1, 0.3);
        // From well inside the valleys to just inside the cone.
        let hip = uniform(0.4, 0.98) * (waist + conicity / (1.0 - conicity * conicity).sqrt() * hip_depth);
        let shape = match uniform(0.0, 5.0) as u32 {
            0 => Some(BodyShape::Cylinder),
            1 => Some(BodyShape::Cone),
            2 => Some(BodyShape::Ellipsoid),
            _ => None,
        };
        let body = shape.map(|shape| {
            let hip_radius = if shape == BodyShape::Cylinder { hip.min(waist - 1e-3) } else { hip };
            Body {
                shape,
                waist_radius: Some(Metre(0.9 * hip_radius.min(waist))),
                hip_radius: Metre(hip_radius),
                hip_depth: Some(Metre(hip_depth)),
            }
        });
        let graded = uniform(0.0, 1.0) < 0.1;
        let (theory, size) = if graded {
            (Theory::Graded, Fidelity::Graded { harmonics: 1, modes: 4, shear: 0.0 })
        } else {
            (Theory::Ruled, Fidelity::Ruled { harmonics: 4 })
        };
        let tolerance = Some(Metre(1e-3 * 10_f64.powf(uniform(-0.7, 0.7))));
        let fabric = Fabric { areal_density: Some(KilogramPerSquareMetre(density)), flexural_rigidity: Some(NewtonMetre(rigidity)) };
        let choice = Choice::Auto;
        let drawn = Scene { skirt, fabric, detail, body, choice, theory, tolerance, ..scene() };
        // Short skirts are refused, and need no screen.
        if 4.0 < slant / (rigidity / (density * 9.81)).cbrt() {
            return (drawn, size);
        }
    }
}

#[test]
fn a_screened_out_term_moves_the_hem_by_less_than_the_tolerance() {
    // The whole sweep: HEMLINE_SCENES=500 cargo test --release --test terms screened -- --nocapture
    let scenes: u64 = std::env::var("HEMLINE_SCENES").ok().and_then(|n| n.parse().ok()).unwrap_or(16);
    let told: Vec<(u64, Vec<String>, [usize; 4], usize)> = (0..scenes)
        .into_par_iter()
        .map(|seed| {
            let (scene, size) = drawn(seed);
            let tolerance = scene.tolerance.unwrap().0;
            let hang = |set: TermSet| predict_scene(&Scene { choice: Choice::Exactly(set), tolerance: None, ..scene.clone() }, Some(size));
            // Off and held, off and not held, on and needed, on in vain.
            let (mut faults, mut counts) = (Vec::new(), [0; 4]);
            let (set, screening) = match screen_scene(&scene, Some(size)) {
                Ok(found) => found,
                Err(why) => return (seed, vec![format!("refused: {why}")], counts, 0),
            };
            let base = hang(set).unwrap();
            assert!(base.contacts.iter().all(|c| c.smallest_gap.is_none_or(|gap| 0.0 < gap)), "{seed}: {:?}", base.contacts);
            for row in screening.rows.iter().filter(|row| row.number.is_some() && !TermSet::usual().contains(row.term)) {
                let other = if row.on { set.without(row.term) } else { set.with(row.term) };
                let moved = hem_movement(&base, &hang(other).unwrap());
                let kind = match (row.on, moved < tolerance) {
                    (false, true) => 0,
                    (false, false) => 1,
                    (true, false) => 2,
                    (true, true) => 3,
                };
                counts[kind] += 1;
                if kind == 1 {
                    faults.push(format!("moved {moved:.2e} m, tolerance {tolerance:.2e}, {row:?}"));
                }
            }
            (seed, faults, counts, screening.trials)
        })
        .collect();
    let sum = told.iter().fold([0; 4], |sum, (_, _, counts, _)| std::array::from_fn::<usize, 4, _>(|i| sum[i] + counts[i]));
    let refused = told.iter().filter(|(_, faults, ..)| faults.iter().any(|f| f.starts_with("refused"))).count();
    let trials: usize = told.iter().map(|(.., trials)| trials).sum();
    println!("{scenes} scenes, {refused} refused, {trials} hems found by the screen");
    println!("off and within the tolerance {}, off and beyond it {}, on and needed {}, on in vain {}", sum[0], sum[1], sum[2], sum[3]);
    for (seed, faults, ..) in told.iter().filter(|(_, faults, ..)| !faults.is_empty()) {
        println!("  {seed}: {faults:?}");
    }
    assert_eq!(sum[1], 0);
    // Refusals are bodies that do not fit, not a way out of the question.
    assert!(refused * 4 < scenes as usize && 0 < sum[0] && 0 < sum[2]);
}

/// `docs/scene.toml` with some text replaced, read.
fn reread(from: &str, to: &str) -> Result<Scene, String> {
    let shown = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/scene.toml")).unwrap();
    assert!(shown.contains(from), "{from}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, shown.replacen(from, to, 1)).unwrap();
    hemline::import::scene_file::read(&path).map_err(|e| e.to_string())
}

#[test]
fn the_scene_that_the_documentation_shows_is_read_in_si_units() {
    let scene = reread("title", "title").unwrap();
    let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    near(scene.skirt.waist_radius().0, 0.76 / std::f64::consts::TAU);
    near(scene.skirt.hem_radius().0, 0.2362);
    near(scene.fabric.flexural_rigidity.unwrap().0, 1e-5);
    near(scene.detail.shear_stiffness.unwrap(), 0.05);
    near(scene.detail.thickness.unwrap().0, 4e-4);
    near(scene.body.unwrap().hip_radius.0, 0.94 / std::f64::consts::TAU);
    near(scene.tolerance.unwrap().0, 1e-3);
    assert_eq!((scene.choice, scene.theory, scene.folds, scene.seams), (Choice::Auto, Theory::Ruled, None, 0));
    // The cone that follows from hips is that of the paper's Table 1.
    let cut = reread("hem_radius_cm = 23.62", "hip_girth_cm = 104\nwaist_to_hip_cm = 20").unwrap().skirt;
    assert!((cut.hem_radius().0 - 0.2362).abs() < 1e-4);
    let listed = reread("terms = \"auto\"", "terms = [\"bending\", \"gravity\", \"shear\"]").unwrap();
    assert_eq!(listed.choice, with(&[Term::Shear]));
    let tester = "apparatus = \"drapemeter\"\nsupport_radius_cm = 9\nspecimen_radius_cm = 15 #";
    let shown = reread("apparatus = \"skirt\"               # optional; \"drapemeter\"", tester).unwrap_err();
    assert!(shown.contains("unknown key “hem_radius_cm” in [skirt]"), "{shown}");
}

#[test]
fn a_fault_in_a_scene_names_its_row_its_key_its_value_and_what_would_be_right() {
    for (from, to, said) in [
        ("areal_density_g_m2 = 200", "areal_density_g_m2 = -200", ["row 13", "“areal_density_g_m2” is -200", "positive"]),
        (
            "areal_density_g_m2 = 200",
            "areal_density_gm2 = 200",
            ["row 13", "unknown key “areal_density_gm2”", "did you mean “areal_density_g_m2”"],
        ),
        ("areal_density_g_m2 = 200", "", ["[cloth] has no areal_density_g_m2", "add", "no hem"]),
        ("shape = \"cone\"", "shape = \"cube\"", ["“shape” is “cube”", "cone", "ellipsoid"]),
        ("hip_girth_cm = 94", "hip_girth_cm = \"wide\"", ["“hip_girth_cm” is “wide”", "number", "positive"]),
        ("hip_girth_cm = 94", "hip_girth_cm = 94\nhip_radius_cm = 15", ["[body]", "radius and girth of the hip", "keep one"]),
        ("terms = \"auto\"", "terms = [\"gravity\", \"wind\"]", ["unknown term “wind”", "body_contact", "auto"]),
        ("terms = \"auto\"", "terms = []", ["there are no terms", "known are", "auto"]),
        ("fidelity = \"ruled\"", "fidelity = \"rulde\"", ["“fidelity” is “rulde”", "did you mean “ruled”", "polar"]),
        ("tolerance_mm = 1 ", "tolerance_mm = 0 ", ["“tolerance_mm” is 0", "it must be", "positive"]),
        ("folds = \"auto\"", "folds = 1.5", ["“folds” is 1.5", "whole number", "2 to 512"]),
        ("hem_radius_cm = 23.62", "hem_radius_cm = 10", ["no cone", "hem radius", ">= the waist radius"]),
        ("seams = 0", "seams = 0.5", ["“seams” is 0.5", "whole number", "0 or more"]),
        ("[theory]", "[theories]", ["unknown key “theories”", "did you mean “theory”", "skirt"]),
        ("waist_girth_cm = 76", "waist_girth_cm = 76\nwaist_girth_mm = 760", ["says again", "waist_girth", "keep one"]),
    ] {
        let fault = reread(from, to).unwrap_err();
        assert!(said.iter().all(|said| fault.contains(said)), "{to}: {fault}");
    }
}

fn hemline(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_hemline")).args(arguments).output().unwrap();
    (output.status.code(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn predict_takes_a_scene_and_terms_and_shows_why_which_are_in() {
    let shown = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/scene.toml");
    let (code, text, fault) = hemline(&["predict", "--scene", shown, "--tolerance-mm", "2", "--folds", "8"]);
    assert_eq!(code, Some(0), "{fault}");
    for term in Term::ALL {
        assert!(text.contains(term.name()), "{text}");
    }
    assert!(text.contains("terms that would move the hem by more than 2 mm are in"), "{text}");
    let (_, text, _) = hemline(&["predict", "--scene", shown, "--tolerance-mm", "2", "--folds", "8", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let rows = json["screening"]["terms"].as_array().unwrap();
    assert_eq!(rows.len(), 7);
    assert!(rows.iter().any(|row| row["term"] == "body_contact" && row["on"] == true && row["why"].is_string()));
    assert!(
        0.0 < json["contacts"][0]["smallest_gap_m"].as_f64().unwrap() && 0 < json["term_evaluations"]["body_contact"].as_u64().unwrap()
    );
    assert!(json["term_evaluations"].get("stretch").is_none());
    // From flags, without a file.
    let flags =
        "predict --waist-radius-cm 12.1 --hem-radius-cm 23.62 --slant-length-cm 53 --areal-density-g-m2 200 --rigidity-un-m 10 --folds 5";
    let flags: Vec<&str> = flags.split(' ').collect();
    let (code, text, fault) = hemline(&[&flags[..], &["--shear-n-m", "0.05", "--terms", "gravity,bending,shear", "--json"]].concat());
    assert_eq!(code, Some(0), "{fault}");
    assert!(0.0 < serde_json::from_str::<serde_json::Value>(&text).unwrap()["shear_j"].as_f64().unwrap());
    let (code, _, fault) = hemline(&[&flags[..], &["--terms", "gravity,magic"]].concat());
    assert!(code == Some(2) && fault.contains("unknown term “magic”"), "{fault}");
    let (code, _, fault) = hemline(&["predict", "--scene", shown, "--waist-radius-cm", "12"]);
    assert!(code == Some(2) && fault.contains("cannot be used with"), "{fault}");
}

#[test]
fn a_campaign_has_the_same_tables() {
    let folder = tempfile::tempdir().unwrap();
    let data = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    for entry in std::fs::read_dir(&data).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_file()) {
        std::fs::copy(&entry, folder.path().join(entry.file_name().unwrap())).unwrap();
    }
    let toml = std::fs::read_to_string(data.join("campaign.toml")).unwrap();
    let profiles = data.join("profiles");
    if profiles.is_dir() {
        std::fs::create_dir(folder.path().join("profiles")).unwrap();
        for entry in std::fs::read_dir(&profiles).unwrap().map(|e| e.unwrap().path()) {
            std::fs::copy(&entry, folder.path().join("profiles").join(entry.file_name().unwrap())).unwrap();
        }
    }
    let more = toml.replacen(
        "[cloth]",
        "[body]\nshape = \"cylinder\"\nhip_radius_cm = 8\n\n[theory]\nterms = \"auto\"\n\n[cloth]\nshear_stiffness_n_m = 0.5",
        1,
    );
    let load = |text: &str| {
        std::fs::write(folder.path().join("campaign.toml"), text).unwrap();
        hemline::import::load(folder.path()).map(|imported| imported.campaign.hanging).map_err(|e| e.to_string())
    };
    assert_eq!(load(&toml).unwrap(), None);
    let hanging = load(&more).unwrap().unwrap();
    assert_eq!((hanging.choice, hanging.detail.shear_stiffness), (Choice::Auto, Some(0.5)));
    assert_eq!(hanging.body.map(|b| b.shape), Some(BodyShape::Cylinder));
    let fault = load(&more.replace("hip_radius_cm = 8", "hip_radius_cm = 0")).unwrap_err();
    assert!(fault.contains("“hip_radius_cm” is 0") && fault.contains("positive"), "{fault}");
    let fault = load(&more.replace("terms = \"auto\"", "folds = 5")).unwrap_err();
    assert!(fault.contains("[analysis]"), "{fault}");
}
