//! A campaign to draw in tests: the shipped outlines with a crude curve through each, so that pages look as they will without fitting anything.
//!
//! Numbers have realistic sizes and are not results: the curve is the strongest harmonic of the radius. Theory, λ and statistics are the real ones, on that curve.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use crate::experiment::campaign::{Folds, HemLength};
use crate::experiment::{Apparatus, Campaign, Design, DrapeProfile, Fabric, Factor, Point, Run, Skirt};
use crate::fit::lambda::{Lambda, lambda};
use crate::fit::{Candidate, Estimate, HeldLength, HemFit, Rule, Termination};
use crate::model::hem::{Hem, Placement};
use crate::simulate::{self, Prediction};
use crate::statistics::box_wilson::{Analysis, Coefficient, Options, analyse};
use crate::statistics::factorial::{Axis, FactorialDesign};
use crate::statistics::family::adjust;
use crate::study::campaign::{CampaignStudy, Comparison, Regression, RunStudy};
use crate::units::{CENTIMETRE, GRAM_PER_SQUARE_METRE, KilogramPerSquareMetre, MICRONEWTON_METRE, MILLIMETRE, Metre, NewtonMetre};

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data")
}

pub fn factors() -> Vec<Factor> {
    let factor = |name: &str, label: &str, unit: &str, low: f64, high: f64| Factor {
        name: name.into(),
        label: label.into(),
        unit: Some(unit.into()),
        low,
        high,
    };
    vec![
        factor("rigidity", "flexural rigidity", "µN·m", 5.0, 20.0),
        factor("density", "areal density", "g/m²", 150.0, 250.0),
        factor("conicity", "hem radius", "cm", 20.0, 26.0),
    ]
}

/// The shipped campaign, one run of it set aside.
pub fn study() -> CampaignStudy {
    let table = std::fs::read_to_string(data().join("design.csv")).unwrap();
    let runs: Vec<RunStudy> = table.lines().skip(1).map(run).collect();
    let campaign = Campaign {
        title: "Forty conic skirts, 2³ × 5".into(),
        origin: "Simulated in an independent shell simulator (MuJoCo 4.0 flex shells), not measured in a laboratory.".into(),
        apparatus: Apparatus::Skirt,
        folder: data(),
        design: Design { factors: factors(), runs: runs.iter().map(|r| r.run.clone()).collect() },
        responses: ["p_mm", "q_mm", "s_mm", "m", "rms_mm", "fold_depth_mm"].map(String::from).to_vec(),
        alpha: 0.05,
        folds: Folds::default(),
        hem_length: HemLength::Auto,
        gravity: 9.81,
        foundation_modulus: 0.0,
    };
    let axes = factors().into_iter().map(|f| Axis { name: f.name, low: f.low, high: f.high }).collect();
    let design = FactorialDesign::new(axes, runs.iter().map(|r| r.run.levels.clone()).collect()).unwrap();
    let values = |pick: fn(&HemFit) -> f64| runs.iter().map(|r| r.fit.as_ref().ok().map(pick)).collect::<Vec<_>>();
    let responses: [(&str, fn(&HemFit) -> f64); 6] = [
        ("p_mm", |f| f.hem.p / MILLIMETRE),
        ("q_mm", |f| f.hem.q / MILLIMETRE),
        ("s_mm", |f| f.hem.s / MILLIMETRE),
        ("m", |f| f64::from(f.hem.folds)),
        ("rms_mm", |f| f.rms / MILLIMETRE),
        ("fold_depth_mm", |f| f.fold_depth / MILLIMETRE),
    ];
    let mut analyses: Vec<Analysis> =
        responses.iter().map(|(_, pick)| analyse(&design, &values(*pick), &Options::default()).unwrap()).collect();
    adjust(&mut analyses);
    let regressions = responses.iter().zip(analyses).map(|((name, _), a)| Regression { response: name.to_string(), analysis: Ok(a) });
    CampaignStudy { campaign, regressions: regressions.collect(), notes: vec!["Sample of the tests.".into()], runs }
}

fn run(line: &str) -> RunStudy {
    let cells: Vec<&str> = line.split(',').collect();
    let number = |i: usize| cells[i].parse::<f64>().unwrap();
    let skirt = Skirt::new(Metre(0.121), Metre(number(7) * CENTIMETRE), Metre(0.53)).unwrap();
    let run = Run {
        id: cells[0].into(),
        replicate: Some(number(1) as u32),
        levels: vec![number(2), number(3), number(4)],
        skirt: Some(skirt),
        fabric: Fabric {
            areal_density: Some(KilogramPerSquareMetre(number(6) * GRAM_PER_SQUARE_METRE)),
            flexural_rigidity: Some(NewtonMetre(number(5) * MICRONEWTON_METRE)),
        },
        profile: cells[8].into(),
    };
    if run.id == "17" {
        let fit = Err("the profile was set aside: 3 points".into());
        return RunStudy {
            run,
            profile: None,
            fit,
            lambda: Lambda::default(),
            prediction: None,
            prediction_at_fitted_folds: None,
            comparison: None,
        };
    }
    let text = std::fs::read_to_string(data().join(&run.profile)).unwrap();
    let points: Vec<Point> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|c| c.parse::<f64>().unwrap() * CENTIMETRE).collect::<Vec<_>>())
        .map(|c| Point::new(c[0], c[1]))
        .collect();
    let profile = DrapeProfile::new(&points).unwrap();
    let fit = crude_fit(&profile, &run.id);
    let (prediction, prediction_at_fitted_folds, comparison) = predict(&run, &fit);
    let lambda = lambda(&fit.hem, None, run.skirt.as_ref(), &run.fabric, 9.81, 0.0);
    RunStudy { run, profile: Some(profile), fit: Ok(fit), lambda, prediction, prediction_at_fitted_folds, comparison }
}

/// The strongest of 3…10 harmonics of r over the polar angle.
fn crude_fit(profile: &DrapeProfile, run: &str) -> HemFit {
    let points = profile.points();
    let n = points.len() as f64;
    let (x0, y0) = (points.iter().map(|p| p.x).sum::<f64>() / n, points.iter().map(|p| p.y).sum::<f64>() / n);
    let polar: Vec<(f64, f64)> = points.iter().map(|p| ((p.x - x0).hypot(p.y - y0), (p.y - y0).atan2(p.x - x0))).collect();
    let p = polar.iter().map(|v| v.0).sum::<f64>() / n;
    let harmonic = |m: u32| {
        let part = |f: fn(f64) -> f64| 2.0 / n * polar.iter().map(|(r, a)| (r - p) * f(f64::from(m) * a)).sum::<f64>();
        (part(f64::cos).hypot(part(f64::sin)), part(f64::sin).atan2(part(f64::cos)) / f64::from(m))
    };
    let (folds, (q, phase)) = (3..=10).map(|m| (m, harmonic(m))).max_by(|a, b| a.1.0.total_cmp(&b.1.0)).unwrap();
    let (hem, placement) = Hem { p, q, s: 0.12 * q, folds }.canonical(Placement { x0, y0, phase });
    let (mut distances, mut feet) = (vec![], vec![]);
    for point in points {
        let at = |i: u32| TAU * f64::from(i) / 1500.0;
        let t = (0..1500)
            .map(at)
            .min_by(|a, b| hem.point(&placement, *a).distance(*point).total_cmp(&hem.point(&placement, *b).distance(*point)))
            .unwrap();
        let foot = hem.point(&placement, t);
        let outside = foot.distance(Point::new(x0, y0)) < point.distance(Point::new(x0, y0));
        distances.push(if outside { foot.distance(*point) } else { -foot.distance(*point) });
        feet.push(t);
    }
    let rms = (distances.iter().map(|d| d * d).sum::<f64>() / n).sqrt();
    let variance = polar.iter().map(|v| (v.0 - p).powi(2)).sum::<f64>() / n;
    let (low, high) = hem.radius_range();
    let held = run.len() == 2;
    let estimate = |value: f64| Estimate { value, standard_error: Some(rms / n.sqrt()) };
    let candidates = (3..=10).map(|m| {
        let weight = if m == folds { 0.97 } else { 0.03 / 7.0 };
        Candidate {
            folds: m,
            rms: rms * (1.0 + 0.1 * f64::from(m.abs_diff(folds))),
            aicc: 10.0 * f64::from(m.abs_diff(folds)),
            weight: Some(weight),
            termination: Termination::Converged,
            broken: None,
        }
    });
    HemFit {
        hem,
        placement,
        p: estimate(p),
        q: Some(estimate(q)),
        s: Some(estimate(hem.s)),
        folds: Some(folds),
        folds_weight: 0.97,
        candidates: candidates.collect(),
        distances,
        feet,
        rms,
        perimeter: hem.perimeter(),
        area: hem.area(),
        fold_depth: high - low,
        outline_length: points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| a.distance(*b)).sum(),
        explained: (1.0 - rms * rms / variance).clamp(0.0, 1.0),
        held: held.then(|| HeldLength { length: hem.perimeter(), multiplier: 1e-3 }),
        termination: if held { Termination::HeldLength { broken: Rule::Length } } else { Termination::Converged },
        evaluations: 120,
        notes: vec![],
    }
}

/// The real theory, laid over the crude fit by its centre and phase.
fn predict(run: &Run, fit: &HemFit) -> (Option<Prediction>, Option<Prediction>, Option<Comparison>) {
    let skirt = run.skirt.unwrap();
    let free = simulate::predict(&skirt, &run.fabric, &simulate::Options::default()).unwrap();
    let options = simulate::Options { folds: simulate::Folds::Exactly(fit.hem.folds), ..simulate::Options::default() };
    let same = simulate::predict(&skirt, &run.fabric, &options).unwrap();
    let outline = &same.outline;
    let area = 0.5 * outline.iter().zip(outline.iter().cycle().skip(1)).map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>();
    let comparison = Comparison {
        folds: i64::from(free.folds) - i64::from(fit.hem.folds),
        rms: 1.3 * fit.rms,
        depth: same.depth() - fit.fold_depth,
        mean_radius: (area / std::f64::consts::PI).sqrt() - (fit.area / std::f64::consts::PI).sqrt(),
        placement: fit.placement,
    };
    (Some(free), Some(same), Some(comparison))
}

/// Coefficients of a full 2³ model with one error for all.
pub fn coefficients() -> Vec<Coefficient> {
    let terms = [
        ("1", 161.22),
        ("rigidity", 6.31),
        ("density", -1.12),
        ("conicity", 17.4),
        ("rigidity:density", 0.31),
        ("rigidity:conicity", 2.2),
        ("density:conicity", -0.44),
        ("rigidity:density:conicity", 0.9),
    ];
    let se = 0.52;
    let coefficient = |(term, estimate): (&str, f64)| Coefficient {
        term: term.into(),
        estimate,
        se: Some(se),
        t: Some(estimate / se),
        p: Some(if estimate.abs() < 2.0369 * se { 0.2 } else { 1e-5 }),
        ci_low: Some(estimate - 2.0369 * se),
        ci_high: Some(estimate + 2.0369 * se),
        p_benjamini_hochberg: None,
        p_holm: Some(if estimate.abs() < 2.0369 * se { 1.0 } else { 1e-4 }),
        significant: 2.0369 * se < estimate.abs(),
    };
    terms.map(coefficient).to_vec()
}

/// Where somebody wants to look at what the tests draw: `HEMLINE_LOOK=folder cargo test report`.
pub fn look(name: &str, bytes: &[u8]) {
    if let Some(folder) = std::env::var_os("HEMLINE_LOOK") {
        super::output::write(Path::new(&folder), name, bytes).unwrap();
    }
}
