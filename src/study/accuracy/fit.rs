//! Work and precision of the fit: tolerance, points, the steps of the method, losses.

use super::apart::{self, Apart};
use super::{Asked, Measure, Panel, Row, Setup};
use crate::error::Error;
use crate::experiment::campaign::Folds;
use crate::experiment::{DrapeProfile, Point};
use crate::fit::foot_point::{centred, nearest};
use crate::fit::outline::smooth;
use crate::fit::{self, HemFit, Limit, Limits, Loss, Options, Termination, orthogonal, start};
use crate::model::hem::{Hem, Placement};
use crate::study::drawn::{AT, HEM, noisy, with_gross_errors};
use crate::study::optimum::optimum;
use crate::units::MILLIMETRE;

/// Noise of the tolerance sweep: an outline traced by hand, m.
const NOISE: f64 = 0.5 * MILLIMETRE;
/// Points of an ordinary outline.
const POINTS: usize = 360;
/// Slack of the tolerance. The tolerance bounds the cosine of the distances with each column of the Jacobian; √6 columns add up at most, and columns of
/// this curve lie within 1 : 4 of being at right angles. Newton's last step delivers far more.
pub const TOLERANCE_SLACK: f64 = 10.0;
/// Rounding of a distance, in the curve's radius: differences of coordinates, summed.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

fn ended(termination: &Termination) -> String {
    match termination {
        Termination::Converged => "converged".into(),
        Termination::HeldLength { .. } => "held length".into(),
        Termination::InOrder { .. } => "matched in order".into(),
        Termination::LengthAsAsked => "length as asked".into(),
        Termination::NotPursued => "not pursued".into(),
        Termination::NoFolds => "no folds".into(),
        Termination::Stalled => "stalled".into(),
        Termination::EvaluationLimit => "evaluation limit".into(),
    }
}

/// Everything that a row needs to know of a fit.
struct Ended {
    error: Option<Apart>,
    evaluations: Option<usize>,
    termination: String,
    claims: bool,
}

impl Ended {
    /// `n` points: an evaluation counts as so many distances.
    fn of(fit: Result<HemFit, Error>, n: usize, error: impl Fn(&Hem, &Placement) -> Option<Apart>) -> Self {
        match fit {
            Ok(fit) => {
                let folded = fit.folds.is_some();
                Ended {
                    error: folded.then(|| error(&fit.hem, &fit.placement)).flatten(),
                    evaluations: Some(fit.evaluations * n),
                    termination: ended(&fit.termination),
                    claims: fit.termination == Termination::Converged,
                }
            }
            Err(refused) => Ended { error: None, evaluations: None, termination: format!("refused: {refused}"), claims: false },
        }
    }

    fn row(self, method: &str, knob: &'static str, setting: f64, seconds: f64) -> Row {
        Row {
            method: method.into(),
            knob,
            setting,
            asked: None,
            error: self.error,
            seconds,
            evaluations: self.evaluations,
            termination: self.termination,
            claims: self.claims,
            default: false,
        }
    }
}

/// The certified path, the careful one, and the solver alone from the match in order, at tolerances from 1e-2 to 1e-12.
pub(super) fn tolerance(setup: &Setup<'_>) -> Result<Panel, Error> {
    let points = noisy(&HEM, POINTS, NOISE, setup.options.seed);
    let profile = DrapeProfile::new(&points)?;
    let given = Options { folds: Folds::Exactly(HEM.folds), bias_correction: false, ..Options::default() };
    let first = fit::fit(&profile, &given)?;
    let feet: Vec<f64> = profile.points().iter().map(|p| nearest(&first.hem, centred(*p, &first.placement), 24).t).collect();
    let exact = optimum(profile.points(), first.hem, first.placement, &feet)
        .ok_or_else(|| Error::Unanswerable("the reference of the tolerance sweep was not reached".into()))?;
    let from_exact = |hem: &Hem, at: &Placement| apart::curves((&exact.hem, &exact.placement), (hem, at));
    let tightest = |options: &Options| {
        let mut tight = options.clone();
        tight.solver.gradient_tolerance = 1e-14;
        fit::fit(&profile, &tight)
    };
    let corrected = Options { bias_correction: true, ..given.clone() };
    let unbiased = tightest(&corrected)?;
    // A bound that never holds: the certified path is for free unknowns only.
    let careful = Options { limits: Limits { p: Limit::Between(0.0, 10.0 * HEM.p), ..Limits::default() }, ..given.clone() };
    let outline = smooth(&profile);
    let match_ = start::matched(&outline, HEM.folds);
    let match_feet: Vec<f64> = profile.points().iter().map(|p| nearest(&match_.hem, centred(*p, &match_.placement), 24).t).collect();
    let default = Options::default().solver.gradient_tolerance;
    let settings = setup.pick(vec![1e-2, 1e-6, default, 1e-12], (1..=6).map(|k| 10f64.powi(-2 * k)).collect(), decades(2, 12));
    let mut rows = Vec::new();
    for tolerance in settings {
        let with = |options: &Options| {
            let mut options = options.clone();
            options.solver.gradient_tolerance = tolerance;
            options
        };
        let asked = Asked { error: tolerance * first.rms, measure: Measure::Rms, slack: TOLERANCE_SLACK, rounding: ROUNDING * HEM.p };
        let mut push = |row: Row, default: bool| rows.push(Row { asked: Some(asked), default, ..row });
        for (method, options) in [("fit, least squares", &given), ("fit, careful path", &careful)] {
            let options = with(options);
            let (fitted, seconds) = setup.time(|| fit::fit(&profile, &options));
            let default = method == "fit, least squares" && tolerance == default;
            push(Ended::of(fitted, POINTS, from_exact).row(method, "tolerance", tolerance, seconds), default);
        }
        let options = with(&corrected);
        let (fitted, seconds) = setup.time(|| fit::fit(&profile, &options));
        let from_unbiased = |hem: &Hem, at: &Placement| apart::curves((&unbiased.hem, &unbiased.placement), (hem, at));
        push(Ended::of(fitted, POINTS, from_unbiased).row("fit, bias taken out", "tolerance", tolerance, seconds), false);
        let options = with(&given).solver;
        let (fitted, seconds) = setup.time(|| {
            let feet = match_feet.clone();
            orthogonal::fit(profile.points(), match_.hem, match_.placement, feet, None, outline.length, &options)
        });
        let fitted = fitted?;
        let claims = fitted.summary.termination.converged();
        let own = Ended {
            error: from_exact(&fitted.hem, &fitted.placement),
            evaluations: Some(fitted.evaluations * POINTS),
            termination: format!("{}", fitted.summary.termination),
            claims,
        };
        push(own.row("solver from the match", "tolerance", tolerance, seconds), false);
    }
    Ok(Panel {
        name: "fit_tolerance",
        title: "Fit: tolerance",
        reference: "least-squares optimum in double-double arithmetic; with the bias taken out, the same fit at 1e-14".into(),
        unit: "distances",
        rows,
    })
}

/// Every decade from 1e-`from` to 1e-`to`.
fn decades(from: i32, to: i32) -> Vec<f64> {
    (from..=to).map(|k| 10f64.powi(-k)).collect()
}

/// Noise of the sweep over points: as wide as folds make the bias of curvature matter, m.
const WIDE: f64 = 2.0 * MILLIMETRE;

/// Start only, orthogonal and bias-corrected fits of 36 to 10⁵ points; the errors of a few draws together.
pub(super) fn points(setup: &Setup<'_>) -> Result<Panel, Error> {
    let counts: Vec<usize> = setup.pick(
        vec![24, 36, 360, 3600],
        vec![24, 36, 72, 180, 360, 1000, 3600, 10_000, 36_000, 100_000],
        vec![24, 36, 50, 72, 100, 180, 360, 1000, 2000, 3600, 10_000, 20_000, 36_000, 100_000],
    );
    let mut rows = Vec::new();
    for n in counts {
        let draws = setup.pick(2, if n < 1500 { 60 } else { 4 }, if n < 5000 { 200 } else { 20 });
        let profiles: Vec<DrapeProfile> = (0..draws)
            .map(|k| DrapeProfile::new(&noisy(&HEM, n, WIDE, setup.options.seed.wrapping_add(1000 + k))))
            .collect::<Result<_, _>>()?;
        let from_truth = |hem: &Hem, at: &Placement| apart::curves((&HEM, &AT), (hem, at));
        let per_draw = 1.0 / draws as f64;
        let (found, seconds) = setup.time(|| {
            let found = profiles.iter().map(|profile| start::matched(&smooth(profile), HEM.folds));
            found.map(|start| (start.hem, start.placement)).collect::<Vec<_>>()
        });
        let errors: Option<Vec<Apart>> = found.iter().map(|(hem, at)| from_truth(hem, at)).collect();
        rows.push(Row {
            method: "start only".into(),
            knob: "points",
            setting: n as f64,
            asked: None,
            error: errors.and_then(|errors| Apart::together(&errors)),
            seconds: seconds * per_draw,
            evaluations: None,
            termination: "matched by length".into(),
            claims: false,
            default: false,
        });
        for (method, bias_correction) in [("orthogonal", false), ("bias taken out", true)] {
            let options = Options { folds: Folds::Exactly(HEM.folds), bias_correction, ..Options::default() };
            let (fits, seconds) = setup.time(|| profiles.iter().map(|p| fit::fit(p, &options)).collect::<Vec<_>>());
            let ended: Vec<Ended> = fits.into_iter().map(|fit| Ended::of(fit, n, from_truth)).collect();
            rows.push(Row {
                default: bias_correction && n == POINTS,
                ..together(ended).row(method, "points", n as f64, seconds * per_draw)
            });
        }
    }
    Ok(Panel {
        name: "fit_points",
        title: "Fit: points, 2 mm of noise",
        reference: "the curve that the outlines were drawn from".into(),
        unit: "distances",
        rows,
    })
}

/// Several draws as one: errors together, evaluations of one, the first ending that is not the usual one.
fn together(all: Vec<Ended>) -> Ended {
    let errors: Option<Vec<Apart>> = all.iter().map(|e| e.error).collect();
    let counts: Option<Vec<usize>> = all.iter().map(|e| e.evaluations).collect();
    let odd = all.iter().find(|e| !e.claims).or(all.first());
    Ended {
        error: errors.and_then(|errors| Apart::together(&errors)),
        evaluations: counts.map(|counts| counts.iter().sum::<usize>() / counts.len().max(1)),
        termination: odd.map_or_else(String::new, |e| e.termination.clone()),
        claims: all.iter().all(|e| e.claims),
    }
}

/// Tuning constants of the losses at a tenth of gross errors, in multiples of the usual ones.
pub(super) fn losses(setup: &Setup<'_>) -> Result<Panel, Error> {
    const FAR: f64 = 50.0 * MILLIMETRE;
    const SHARE: f64 = 0.1;
    let draws = setup.pick(1, 8, 60);
    let drawn = |k: u64| with_gross_errors(&HEM, POINTS, NOISE, SHARE, FAR, setup.options.seed.wrapping_add(2000 + k));
    let profiles: Vec<DrapeProfile> = (0..draws).map(|k| DrapeProfile::new(&drawn(k))).collect::<Result<_, _>>()?;
    let factors: Vec<f64> =
        setup.pick(vec![1.0], vec![0.3, 0.5, 1.0, 2.0, 4.0], (0..=12).map(|k| 2f64.powf(f64::from(k - 6) / 2.0)).collect());
    let mut asked = vec![(Loss::Squares, 1.0)];
    for factor in factors {
        let tuned = |tuning: Option<f64>| factor * tuning.unwrap_or(1.0);
        asked.push((Loss::Huber { tuning: tuned(Loss::HUBER.tuning()) }, factor));
        asked.push((Loss::Cauchy { tuning: tuned(Loss::CAUCHY.tuning()) }, factor));
        asked.push((Loss::Tukey { tuning: tuned(Loss::TUKEY.tuning()) }, factor));
    }
    let mut rows = Vec::new();
    for (loss, factor) in asked {
        let options = Options { folds: Folds::Exactly(HEM.folds), loss, ..Options::default() };
        let (fits, seconds) = setup.time(|| profiles.iter().map(|p| fit::fit(p, &options)).collect::<Vec<_>>());
        let from_truth = |hem: &Hem, at: &Placement| apart::curves((&HEM, &AT), (hem, at));
        let ended: Vec<Ended> = fits.into_iter().map(|fit| Ended::of(fit, POINTS, from_truth)).collect();
        let row = together(ended).row(loss_name(loss), "tuning, times the usual", factor, seconds / draws as f64);
        rows.push(Row { default: loss == Loss::Squares, ..row });
    }
    Ok(Panel {
        name: "fit_losses",
        title: "Fit: losses, a tenth of the points 5 cm off",
        reference: "the curve that the outlines were drawn from".into(),
        unit: "distances",
        rows,
    })
}

fn loss_name(loss: Loss) -> &'static str {
    match loss {
        Loss::Squares => "squares",
        Loss::Huber { .. } => "Huber",
        Loss::Tukey { .. } => "Tukey",
        Loss::Cauchy { .. } => "Cauchy",
    }
}

/// For the point of view of other panels: an outline as measured.
pub(super) fn ordinary(seed: u64, n: usize) -> Vec<Point> {
    noisy(&HEM, n, NOISE, seed)
}
