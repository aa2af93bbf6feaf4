//! Hard outlines: generators at growing severity, and what is made of the fit's answer.

use std::f64::consts::TAU;

use rand::seq::SliceRandom;

use super::{Answer, Case, Outcome, Subject, digits};
use crate::experiment::campaign::Folds;
use crate::experiment::{DrapeProfile, Point};
use crate::fit::{self, HemFit, Loss, Options, Termination};
use crate::model::hem::{Hem, Placement};
use crate::study::accuracy::apart;
use crate::study::drawn::{AT, HEM, generator, noisy, normal, with_gross_errors};
use crate::study::optimum::optimum;

/// The double's solution is to lie this far from the exact optimum at most, in standard errors: nobody could see it then.
const INVISIBLE: f64 = 0.01;
/// … or in the curve's radius, where the points lie on the curve.
const EXACT: f64 = 1e-10;
/// Estimates further from the truth than so many standard errors are wrong: one in 10⁷ by chance.
const FAR: f64 = 5.5;
/// A fold count of less weight is in doubt.
const SURE: f64 = 0.9;
/// Folds whose amplitude has so many standard errors must not be taken for a circle.
const PLAIN: f64 = 10.0;

const OPTIMUM: &str = "least-squares optimum in double-double arithmetic";

/// An outline with what is known of it.
pub struct Outline {
    pub points: Vec<Point>,
    /// The curve it was drawn from.
    pub hem: Hem,
    pub at: Placement,
    /// Whether that curve and noise is all there is: estimates can then be held against it.
    pub exact: bool,
    /// m.
    pub noise: f64,
}

impl Outline {
    fn of(points: Vec<Point>, hem: Hem, noise: f64) -> Self {
        Outline { points, hem, at: AT, exact: true, noise }
    }

    fn mapped(mut self, to: impl Fn(Point) -> Point) -> Self {
        self.points.iter_mut().for_each(|p| *p = to(*p));
        self
    }
}

/// The hem about a centre this many radii away.
pub fn far_centre(radii: f64, seed: u64) -> Outline {
    let mut outline = Outline::of(noisy(&HEM, 360, 5e-4, seed), HEM, 5e-4);
    let (dx, dy) = (0.8 * radii * HEM.p, -0.6 * radii * HEM.p);
    outline.at = Placement { x0: AT.x0 + dx, y0: AT.y0 + dy, ..AT };
    outline.mapped(|p| Point::new(p.x + dx, p.y + dy))
}

/// The hem made smaller by this power of ten.
pub fn small(power: f64, seed: u64) -> Outline {
    let unit = 10f64.powf(-power);
    let mut outline = Outline::of(noisy(&HEM, 360, 5e-4, seed), HEM, 5e-4 * unit);
    outline.hem = Hem { p: unit * HEM.p, q: unit * HEM.q, s: unit * HEM.s, ..HEM };
    outline.at = Placement { x0: unit * AT.x0, y0: unit * AT.y0, ..AT };
    outline.mapped(|p| Point::new(unit * p.x, unit * p.y))
}

/// Noise this many times as wide as the folds are deep.
pub fn noise_of_folds(ratio: f64, seed: u64) -> Outline {
    let hem = Hem { q: 0.01, s: 0.0, ..HEM };
    Outline::of(noisy(&hem, 360, ratio * hem.q, seed), hem, ratio * hem.q)
}

/// This many points on each fold.
pub fn few_points(each: f64, seed: u64) -> Outline {
    Outline::of(noisy(&HEM, (each * f64::from(HEM.folds)).round() as usize, 2e-4, seed), HEM, 2e-4)
}

/// Sideways lean: from none over overhanging folds to a curve that crosses itself.
pub fn leaning(lean: f64, seed: u64) -> Outline {
    let hem = Hem { p: 0.2, q: 0.05, s: lean, folds: 8 };
    Outline::of(noisy(&hem, 720, 1e-4, seed), hem, 1e-4)
}

/// A valley that is a cusp but for this share of its speed.
pub fn near_cusp(share: f64, seed: u64) -> Outline {
    let (p, q, m) = (0.2, 0.05, 6.0);
    // p − q + 2ms: the speed in the valley.
    let hem = Hem { p, q, s: -(1.0 - share) * (p - q) / (2.0 * m), folds: 6 };
    Outline::of(noisy(&hem, 720, 2e-4, seed), hem, 2e-4)
}

/// A piece missing that is this share of the outline.
pub fn missing_piece(share: f64, seed: u64) -> Outline {
    let mut outline = Outline::of(noisy(&HEM, 540, 3e-4, seed), HEM, 3e-4);
    outline.points.truncate((540.0 * (1.0 - share)).round() as usize);
    outline
}

/// Points denser on one side: dt/du from 1 − `swing` to 1 + `swing`.
pub fn uneven_density(swing: f64, seed: u64) -> Outline {
    let mut random = generator(seed);
    let points = (0..480)
        .map(|i| TAU * f64::from(i) / 480.0)
        .map(|u| HEM.point(&AT, u + swing * u.sin()))
        .map(|p| Point::new(p.x + 5e-4 * normal(&mut random), p.y + 5e-4 * normal(&mut random)))
        .collect();
    Outline::of(points, HEM, 5e-4)
}

/// This share of the points thrown about by 5 cm.
pub fn gross_errors(share: f64, seed: u64) -> Outline {
    Outline::of(with_gross_errors(&HEM, 180, 5e-4, share, 0.05, seed), HEM, 5e-4)
}

/// A second wave of seven folds, this many times as high as that of eight.
pub fn rival_wave(ratio: f64, seed: u64) -> Outline {
    let mut random = generator(seed);
    let noise = 1e-4;
    let points = (0..480)
        .map(|i| TAU * f64::from(i) / 480.0)
        .map(|t| (t, 0.2 + 0.005 * ((8.0 * t).cos() + ratio * (7.0 * t).cos())))
        .map(|(t, r)| Point::new(r * t.cos() + noise * normal(&mut random), r * t.sin() + noise * normal(&mut random)))
        .collect();
    let hem = Hem { p: 0.2, q: 0.005, s: 0.0, folds: 8 };
    Outline { exact: false, at: Placement::ORIGIN, ..Outline::of(points, hem, noise) }
}

/// So many folds, five points on each.
pub fn many_folds(folds: f64, seed: u64) -> Outline {
    let hem = Hem { p: 0.2, q: 0.01, s: 0.0005, folds: folds as u32 };
    Outline::of(noisy(&hem, 5 * folds as usize, 1e-4, seed), hem, 1e-4)
}

/// Points in no order, with noise this many times as wide as they are apart.
pub fn scattered(ratio: f64, seed: u64) -> Outline {
    let noise = ratio * HEM.perimeter() / 360.0;
    let mut points = noisy(&HEM, 360, noise, seed);
    points.shuffle(&mut generator(seed.wrapping_add(1)));
    Outline::of(points, HEM, noise)
}

/// Seen from the side: the outline shortened along y to this share.
pub fn tilted(share: f64, seed: u64) -> Outline {
    Outline { exact: false, ..Outline::of(noisy(&HEM, 360, 3e-4, seed), HEM, 3e-4) }.mapped(|p| Point::new(p.x, share * p.y))
}

/// What the fit says of an outline, and whether that is right.
pub fn judged(outline: &Outline, options: &Options) -> Answer {
    let profile = match DrapeProfile::new(&outline.points) {
        Ok(profile) => profile,
        Err(refused) => return Answer::refused(refused),
    };
    match fit::fit(&profile, options) {
        Ok(fit) => answer(outline, &profile, &fit),
        Err(refused) => Answer::refused(refused),
    }
}

fn answer(outline: &Outline, profile: &DrapeProfile, fit: &HemFit) -> Answer {
    let mut said: Vec<String> = fit.notes.clone();
    if !matches!(fit.termination, Termination::Converged) {
        said.push(format!("{:?}", fit.termination));
    }
    if fit.folds_weight < SURE {
        said.push(format!("weight of {:?} folds {:.2}", fit.folds, fit.folds_weight));
    }
    let said = (!said.is_empty()).then(|| said.join("; "));
    let base = Answer {
        outcome: Outcome::Right,
        digits: None,
        promised: None,
        condition: None,
        evaluations: Some(fit.evaluations),
        said: String::new(),
    };
    let Some(folds) = fit.folds else {
        let n = outline.points.len() as f64;
        let plain = PLAIN * outline.noise * (2.0 / n).sqrt() < outline.hem.q;
        let outcome = match (plain, fit.notes.is_empty()) {
            (false, _) => Outcome::NoAnswer,
            (true, false) => Outcome::Warned,
            (true, true) => Outcome::Wrong,
        };
        return Answer { outcome, said: format!("no folds; {}", said.unwrap_or_default()), ..base };
    };
    if folds != outline.hem.folds {
        let outcome = if said.is_some() { Outcome::Warned } else { Outcome::Wrong };
        return Answer {
            outcome,
            digits: Some(0.0),
            said: format!("{folds} folds for {}; {}", outline.hem.folds, said.unwrap_or_default()),
            ..base
        };
    }
    let exact = match (&fit.termination, &fit.robust) {
        (Termination::Converged, None) => optimum(profile.points(), fit.hem, fit.placement, &fit.feet),
        _ => None,
    };
    let condition = exact.as_ref().map(|exact| exact.condition);
    let (kept, promised) = match &exact {
        Some(exact) => {
            let allowed = (INVISIBLE * exact.standard_error / fit.hem.p).max(EXACT);
            (digits(exact.moved / fit.hem.p), digits(allowed))
        }
        // No optimum to hold it against: by the curve, as well as the noise and the ending allow.
        None => {
            let apart = apart::curves((&outline.hem, &outline.at), (&fit.hem, &fit.placement));
            let noise = 6.0 * outline.noise / (outline.points.len() as f64 / 6.0).sqrt();
            let kept = apart.map_or(0.0, |apart| digits(apart.rms / fit.hem.p));
            (kept, digits((noise + EXACT * fit.hem.p) / fit.hem.p))
        }
    };
    let mut answer = Answer { condition, evaluations: Some(fit.evaluations), ..Answer::judged(kept, promised, said.clone()) };
    if outline.exact
        && let Some(fault) = beyond_its_errors(fit, outline)
    {
        answer.outcome = answer.outcome.max(if said.is_some() { Outcome::Warned } else { Outcome::Wrong });
        answer.said = format!("{fault}; {}", said.unwrap_or_default());
    }
    answer
}

/// An estimate further from the truth than its standard error allows.
fn beyond_its_errors(fit: &HemFit, outline: &Outline) -> Option<String> {
    let (truth, _) = outline.hem.canonical(outline.at);
    let estimates = [("p", Some(fit.p), truth.p), ("q", fit.q, truth.q), ("s", fit.s, truth.s)];
    // The bias of curvature, ½σ²κ, is left in here; the sharpest bend is that of the truth.
    let sharpest = (0..720).map(|i| outline.hem.local(TAU * f64::from(i) / 720.0).curvature().abs()).fold(0.0, f64::max);
    let bias = 0.5 * outline.noise.powi(2) * sharpest;
    estimates.into_iter().find_map(|(name, estimate, value)| {
        let (found, error) = (estimate?.value, estimate?.standard_error?);
        let far = (found - value).abs() - FAR * error - bias;
        (1e-12 * truth.p < far).then(|| format!("{name} is {found:e} ± {error:e} for {value:e}"))
    })
}

/// Least squares at any fold count from 2 to 24.
fn plain() -> Options {
    // The optimum itself: with the bias taken out there is none to hold it against.
    Options { bias_correction: false, ..Options::default() }
}

/// The fit's cases.
pub fn cases() -> Vec<Case> {
    let case = |name, title, severities, run| Case { subject: Subject::Fit, name, title, reference: OPTIMUM, severities, run };
    vec![
        case("far_centre", "centre away, radii", [0.0, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12, 1e15], |v, seed| {
            judged(&far_centre(v, seed), &plain())
        }),
        case("small", "size, 10⁻ᵏ m", [0.0, 3.0, 6.0, 30.0, 80.0, 140.0, 155.0, 300.0], |v, seed| judged(&small(v, seed), &plain())),
        case("noise", "noise / fold amplitude", [0.01, 0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 10.0], |v, seed| {
            judged(&noise_of_folds(v, seed), &plain())
        }),
        case("few_points", "points on a fold", [100.0, 30.0, 10.0, 7.0, 6.0, 5.0, 4.0, 3.0], |v, seed| {
            judged(&few_points(v, seed), &plain())
        }),
        case("leaning", "sideways lean s, m", [0.0, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.2], |v, seed| judged(&leaning(v, seed), &plain())),
        case("near_cusp", "speed in the valley, share", [0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 1e-3, 0.0], |v, seed| {
            judged(&near_cusp(v, seed), &plain())
        }),
        case("missing_piece", "share of the outline missing", [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 0.9], |v, seed| {
            judged(&missing_piece(v, seed), &plain())
        }),
        case("uneven_density", "swing of the density", [0.0, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999], |v, seed| {
            judged(&uneven_density(v, seed), &plain())
        }),
        Case {
            reference: "the curve drawn, within the noise",
            ..case("gross_errors", "share of gross errors, Tukey’s loss", [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8], |v, seed| {
                judged(&gross_errors(v, seed), &Options { loss: Loss::TUKEY, ..plain() })
            })
        },
        case("gross_squares", "share of gross errors, least squares", [0.0, 0.003, 0.01, 0.02, 0.05, 0.1, 0.2, 0.8], |v, seed| {
            judged(&gross_errors(v, seed), &plain())
        }),
        case("rival_wave", "second wave of 7 folds, share of 8", [0.0, 0.2, 0.5, 0.8, 0.9, 0.95, 0.99, 1.0], |v, seed| {
            judged(&rival_wave(v, seed), &plain())
        }),
        case("many_folds", "folds, five points each", [8.0, 16.0, 24.0, 40.0, 60.0, 80.0, 100.0, 120.0], |v, seed| {
            judged(&many_folds(v, seed), &Options { folds: Folds::Among { from: 2, to: 200 }, ..plain() })
        }),
        case("scattered", "no order; noise / spacing", [0.01, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 2.0], |v, seed| {
            judged(&scattered(v, seed), &plain())
        }),
        case("tilted", "outline shortened to a share", [1.0, 0.99, 0.95, 0.9, 0.8, 0.6, 0.3, 0.1], |v, seed| {
            judged(&tilted(v, seed), &plain())
        }),
    ]
}
