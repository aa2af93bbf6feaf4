//! Work and precision of the predictions: harmonics, modes, nodes, the tolerance asked for, and the search over fold counts.

use super::apart::{self, Apart};
use super::{Asked, Measure, Panel, Row, Setup};
use crate::error::Error;
use crate::experiment::{Fabric, Skirt};
use crate::simulate::{Effort, Fidelity, Folds, Options, Prediction, Termination, graded as graded_shell, predict, ruled as ruled_shell};
use crate::study::drawn::{generator, uniform};
use crate::units::{KilogramPerSquareMetre, MILLIMETRE, Metre, NewtonMetre};

/// A skirt and its cloth.
pub(in crate::study) type Scene = (Skirt, Fabric);

/// The skirt of docs/model.md at rigidity `rigidity`, N·m.
pub(in crate::study) fn scene(rigidity: f64) -> Result<Scene, Error> {
    Ok((Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53))?, cloth(0.2, rigidity)))
}

/// Cloth of so many kg/m² and N·m.
pub(in crate::study) fn cloth(density: f64, rigidity: f64) -> Fabric {
    Fabric { areal_density: Some(KilogramPerSquareMetre(density)), flexural_rigidity: Some(NewtonMetre(rigidity)) }
}

/// Rigidity of an ordinary skirt cloth, N·m.
const RIGIDITY: f64 = 1e-5;
/// Its fold count of least energy.
const FOLDS: Folds = Folds::Exactly(5);
/// The tolerance of a prediction is a promise: the last move of the hem bounds what is left.
pub const TOLERANCE_SLACK: f64 = 1.0;
/// Rounding of a hem in its radius: sums over hundreds of nodes.
const ROUNDING: f64 = 1e-13;

fn ended(termination: Termination) -> &'static str {
    match termination {
        Termination::Converged => "converged",
        Termination::Stalled => "stalled",
        Termination::EvaluationLimit => "evaluation limit",
        Termination::Round => "round",
    }
}

fn row(method: &str, knob: &'static str, setting: f64, asked: &Result<Prediction, Error>, seconds: f64, exact: &Prediction) -> Row {
    let (error, evaluations, termination, claims) = match asked {
        Ok(hem) => {
            let unmet = hem.notes.iter().any(|note| note.contains("tolerance is not met"));
            let said = if unmet { "tolerance not met" } else { ended(hem.termination) };
            (
                apart::hems(&exact.outline, &hem.outline),
                Some(hem.evaluations),
                said.to_string(),
                !unmet && hem.termination == Termination::Converged,
            )
        }
        Err(refused) => (None, None, format!("refused: {refused}"), false),
    };
    Row { method: method.into(), knob, setting, asked: None, error, seconds, evaluations, termination, claims, default: false }
}

/// Tolerances of a prediction, m.
fn tolerances(setup: &Setup<'_>, tightest: i32) -> Vec<f64> {
    let all: Vec<f64> = (0..=tightest).map(|k| 10.0 * MILLIMETRE * 10f64.powi(-k)).collect();
    setup.pick(all.iter().copied().step_by(3).collect(), all.clone(), all.iter().flat_map(|t| [*t, 0.3 * t]).collect())
}

/// Rows of a family whose unknowns are chosen by the tolerance.
fn asked_for(
    setup: &Setup<'_>,
    method: &str,
    fidelity: Fidelity,
    tightest: i32,
    exact: &Prediction,
    rows: &mut Vec<Row>,
) -> Result<(), Error> {
    let (skirt, fabric) = scene(RIGIDITY)?;
    for tolerance in tolerances(setup, tightest) {
        let options = Options { fidelity, folds: FOLDS, tolerance: Some(Metre(tolerance)), ..Options::default() };
        let (hem, seconds) = setup.time(|| predict(&skirt, &fabric, &options));
        let asked = Asked { error: tolerance, measure: Measure::Max, slack: TOLERANCE_SLACK, rounding: ROUNDING * skirt.hem_radius().0 };
        rows.push(Row { asked: Some(asked), ..row(method, "tolerance, mm", tolerance / MILLIMETRE, &hem, seconds, exact) });
    }
    Ok(())
}

/// Harmonics of the ruled shell, the tolerance asked of it, and the paper's curve in the same energy.
pub(super) fn ruled(setup: &Setup<'_>) -> Result<Panel, Error> {
    let (skirt, fabric) = scene(RIGIDITY)?;
    let ask = |fidelity: Fidelity, nodes: Option<usize>| {
        let options = Options { fidelity, folds: FOLDS, effort: Effort { nodes, ..Effort::default() }, ..Options::default() };
        predict(&skirt, &fabric, &options)
    };
    let exact = ask(Fidelity::Ruled { harmonics: 32 }, Some(1024))?;
    let mut rows = Vec::new();
    for harmonics in setup.pick(vec![1, 4, 8, 16], (1..=16).collect(), (1..=24).collect::<Vec<usize>>()) {
        let (hem, seconds) = setup.time(|| ask(Fidelity::Ruled { harmonics }, None));
        let default = harmonics == ruled_shell::HARMONICS;
        rows.push(Row { default, ..row("ruled", "harmonics", harmonics as f64, &hem, seconds, &exact) });
    }
    asked_for(setup, "ruled, to a tolerance", Fidelity::Ruled { harmonics: 8 }, 14, &exact, &mut rows)?;
    let (hem, seconds) = setup.time(|| ask(Fidelity::Ansatz, None));
    rows.push(row("ansatz (p, q, s)", "unknowns", 3.0, &hem, seconds, &exact));
    Ok(Panel {
        name: "ruled",
        title: "Ruled shell: harmonics",
        reference: "ruled, K = 32, 1024 nodes in half a fold".into(),
        unit: "energies",
        rows,
    })
}

/// Nodes of both quadratures of the ruled shell, not verified by doubling.
pub(super) fn nodes(setup: &Setup<'_>) -> Result<Panel, Error> {
    let (skirt, fabric) = scene(RIGIDITY)?;
    let fidelity = Fidelity::Ruled { harmonics: ruled_shell::HARMONICS };
    let ask = |nodes: Option<usize>| {
        let options = Options { fidelity, folds: FOLDS, effort: Effort { nodes, ..Effort::default() }, ..Options::default() };
        predict(&skirt, &fabric, &options)
    };
    let exact = ask(Some(1024))?;
    let mut rows = Vec::new();
    for nodes in
        setup.pick(vec![8, 32, 64], vec![4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 256], (2..=64).map(|n| 2 * n).collect::<Vec<usize>>())
    {
        let (hem, seconds) = setup.time(|| ask(Some(nodes)));
        rows.push(row("fixed nodes", "nodes in half a fold", nodes as f64, &hem, seconds, &exact));
    }
    let (hem, seconds) = setup.time(|| ask(None));
    rows.push(Row { default: true, ..row("doubled until it holds", "energy holds to", 1e-11, &hem, seconds, &exact) });
    // Work is nodes times energies: the energies alone hardly differ.
    for row in &mut rows {
        let nodes = if row.default { crate::model::tangent::half_nodes(ruled_shell::HARMONICS) } else { row.setting as usize };
        row.evaluations = row.evaluations.map(|n| n * nodes);
    }
    Ok(Panel {
        name: "nodes",
        title: "Ruled shell, K = 8: quadrature nodes",
        reference: "the same with 1024 nodes in half a fold".into(),
        unit: "energies × nodes",
        rows,
    })
}

/// Nodes of the integrals of the paper's equation (4).
pub(super) fn polar(setup: &Setup<'_>) -> Result<Panel, Error> {
    let (skirt, fabric) = scene(RIGIDITY)?;
    let ask = |nodes: Option<usize>| {
        let options = Options {
            fidelity: Fidelity::Polar { foundation: 0.0 },
            folds: FOLDS,
            effort: Effort { nodes, ..Effort::default() },
            ..Options::default()
        };
        predict(&skirt, &fabric, &options)
    };
    let exact = ask(Some(4096))?;
    let mut rows = Vec::new();
    let all = vec![8, 12, 16, 24, 32, 48, 64, 100, 150, 200, 400];
    for nodes in setup.pick(vec![8, 64, 200], all, (1..=50).map(|n| 8 * n).collect::<Vec<usize>>()) {
        let (hem, seconds) = setup.time(|| ask(Some(nodes)));
        let row = row("fixed nodes", "nodes", nodes as f64, &hem, seconds, &exact);
        rows.push(Row { evaluations: row.evaluations.map(|n| n * nodes), ..row });
    }
    let (hem, seconds) = setup.time(|| ask(None));
    rows.push(Row { default: true, evaluations: None, ..row("doubled until it holds", "integrals hold to", 1e-14, &hem, seconds, &exact) });
    Ok(Panel {
        name: "polar", title: "Equation (4): nodes", reference: "the same with 4096 nodes".into(), unit: "integrals × nodes", rows
    })
}

/// Harmonics and modes of the graded shell, and the tolerance asked of it.
pub(super) fn graded(setup: &Setup<'_>) -> Result<Panel, Error> {
    let (skirt, fabric) = scene(RIGIDITY)?;
    let ask = |harmonics: usize, modes: usize| {
        let fidelity = Fidelity::Graded { harmonics, modes, shear: 0.0 };
        predict(&skirt, &fabric, &Options { fidelity, folds: FOLDS, ..Options::default() })
    };
    let (k, j) = setup.pick((4, 10), (6, 16), (8, 22));
    let exact = ask(k, j)?;
    let usual = vec![(1, 2), (1, 4), (2, 3), (2, 4), (2, 6), (3, 4), (3, 6), (3, 8), (4, 6), (4, 8), (4, 10), (5, 10)];
    let sizes = setup.pick(vec![(1, 2), (3, 6)], usual, (1..=5).flat_map(|k| (1..=5).map(move |j| (k, 2 * j + 2))).collect());
    let mut rows = Vec::new();
    for (harmonics, modes) in sizes {
        let (hem, seconds) = setup.time(|| ask(harmonics, modes));
        let default = (harmonics, modes) == (graded_shell::HARMONICS, graded_shell::MODES);
        let method = format!("graded, K = {harmonics}, J = {modes}");
        rows.push(Row { default, ..row(&method, "unknowns", (harmonics * modes) as f64, &hem, seconds, &exact) });
    }
    let fidelity = Fidelity::Graded { harmonics: graded_shell::HARMONICS, modes: graded_shell::MODES, shear: 0.0 };
    asked_for(setup, "graded, to a tolerance", fidelity, setup.pick(0, 2, 3), &exact, &mut rows)?;
    Ok(Panel {
        name: "graded",
        title: "Graded shell: harmonics × modes",
        reference: format!("graded, K = {k}, J = {j}"),
        unit: "energies",
        rows,
    })
}

/// Widths of the search over fold counts: (patience, closeness).
const WIDTHS: [(u32, f64); 7] = [(1, 0.0), (1, 1.0), (2, 0.0), (2, 0.25), (2, 1.0), (4, 1.0), (4, 4.0)];

/// Narrow and wide searches over fold counts, over scenes drawn at random; the errors of all scenes together.
pub(super) fn search(setup: &Setup<'_>) -> Result<Panel, Error> {
    let mut random = generator(setup.options.seed.wrapping_add(3000));
    let mut between = |low: f64, high: f64| low + (high - low) * uniform(&mut random);
    let count = setup.pick(4, 24, 200);
    let scenes: Vec<Scene> = (0..count)
        .map(|_| {
            let (waist, slant, conicity) = (between(0.08, 0.2), between(0.3, 0.8), between(0.1, 0.6));
            let (density, rigidity) = (between(0.1, 0.4), 10f64.powf(between(-6.5, -4.5)));
            Ok((Skirt::new(Metre(waist), Metre(waist + conicity * slant), Metre(slant))?, cloth(density, rigidity)))
        })
        .collect::<Result<_, Error>>()?;
    let methods = [
        ("ruled", Fidelity::Ruled { harmonics: ruled_shell::HARMONICS }, count),
        ("ansatz", Fidelity::Ansatz, setup.pick(2, 10, 60)),
        ("graded, K = 2, J = 4", Fidelity::Graded { harmonics: 2, modes: 4, shear: 0.0 }, setup.pick(1, 8, 60)),
    ];
    let mut rows = Vec::new();
    for (method, fidelity, scenes_of_it) in methods {
        let scenes = &scenes[..scenes_of_it];
        let ask = |(patience, closeness): (u32, f64)| {
            let options = Options { fidelity, effort: Effort { nodes: None, patience, closeness }, ..Options::default() };
            scenes.iter().map(|(skirt, fabric)| predict(skirt, fabric, &options)).collect::<Result<Vec<Prediction>, Error>>()
        };
        let exact = ask(setup.pick((4, 4.0), (6, 20.0), (10, 50.0)))?;
        for width in WIDTHS {
            let (hems, seconds) = setup.time(|| ask(width));
            let hems = hems?;
            let errors: Option<Vec<Apart>> =
                hems.iter().zip(&exact).map(|(hem, exact)| apart::hems(&exact.outline, &hem.outline)).collect();
            let other = hems.iter().zip(&exact).filter(|(hem, exact)| hem.folds != exact.folds).count();
            let usual = Effort::default();
            rows.push(Row {
                method: format!("{method}, close ones × {}", width.1),
                knob: "dearer fold counts in a row",
                setting: f64::from(width.0),
                asked: None,
                error: errors.and_then(|errors| Apart::together(&errors)),
                seconds: seconds / scenes_of_it as f64,
                evaluations: Some(hems.iter().map(|hem| hem.evaluations).sum::<usize>() / scenes_of_it),
                termination: format!("{other} of {scenes_of_it} scenes with another fold count"),
                claims: other == 0,
                default: method == "ruled" && width == (usual.patience, usual.closeness),
            });
        }
    }
    Ok(Panel { name: "search", title: "Search for the fold count", reference: "the widest search".into(), unit: "energies", rows })
}
