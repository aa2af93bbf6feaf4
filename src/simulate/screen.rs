//! The screen: which terms a scene calls for.
//!
//! A term that is out is judged at the hem found without it. Its dimensionless number tells at once where it cannot matter (a wall out of reach); else
//! one Newton step with its gradient and Hessian in gives the first-order response of the hem. Where that is near the tolerance, or another fold count might
//! become the best, the hem is found with the term in, and measured. The term that moves the hem most is switched on, and the others are judged again.

use std::f64::consts::PI;

use nalgebra::{Cholesky, DVector};
use serde::Serialize;

use super::hanging::below;
use super::scene::{Case, Shape, missing};
use super::{Folds, Prediction, movement};
use crate::error::Error;
use crate::experiment::scene::{Term, TermSet};
use crate::model::energy::Gaps;
use crate::model::graded_terms::GradedTerms;
use crate::model::ruled_terms::RuledTerms;
use crate::numerics::minimize::Smooth;
use crate::units::MILLIMETRE;

/// A response this many times the tolerance is believed without a trial, and so is one this many times smaller: beyond it, second order cannot turn it.
const CLEAR: f64 = 5.0;
/// A trial that moves the hem by this share of the tolerance switches the term on: what is left covers the rest of the discretization.
const MARGIN: f64 = 0.9;

/// Why which terms are in.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Screening {
    /// How far a screened-out term may move the hem, m.
    pub tolerance: f64,
    /// One for each term, in the order of [`Term::ALL`].
    pub rows: Vec<Screened>,
    /// Hems found on the way.
    pub trials: usize,
    /// Evaluations that screening took, with those of the hems found.
    pub evaluations: usize,
}

/// One term, judged.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Screened {
    pub term: Term,
    /// Its dimensionless number; `None` where the scene has no data for it.
    pub number: Option<f64>,
    /// What the number is.
    pub is: &'static str,
    /// How far leaving it out would move the hem, m, where that was estimated.
    pub movement: Option<f64>,
    pub on: bool,
    pub why: String,
}

/// The terms whose omission would move the hem by more than `tolerance` (m).
///
/// # Errors
/// As hanging the scene without any of them.
pub(super) fn screen(case: &Case<'_>, tolerance: f64) -> Result<(TermSet, Screening), Error> {
    if !(tolerance.is_finite() && 0.0 < tolerance) {
        return Err(Error::Invalid { quantity: "tolerance, m", value: tolerance, allowed: "> 0" });
    }
    let mut judge = Judge { case, tolerance, set: TermSet::usual(), trials: 0, evaluations: 0 };
    let candidates: Vec<Term> = case.all.set().iter().filter(|term| !judge.set.contains(*term)).collect();
    let mut switched: Vec<Screened> = Vec::new();
    loop {
        let base = judge.hang(judge.set, case.folds)?;
        let mut rows = Vec::new();
        for &term in &candidates {
            if !judge.set.contains(term) {
                rows.push(judge.of(&base, term)?);
            }
        }
        // The strongest first: it may make the others needless.
        let strongest = (0..rows.len())
            .filter(|i| rows[*i].on)
            .max_by(|i, j| rows[*i].movement.unwrap_or(f64::INFINITY).total_cmp(&rows[*j].movement.unwrap_or(f64::INFINITY)));
        if let Some(strongest) = strongest {
            let row = rows.swap_remove(strongest);
            judge.set = judge.set.with(row.term);
            switched.push(row);
            continue;
        }
        switched.extend(rows);
        switched.extend(judge.always(&base.0));
        let absent = Term::ALL.into_iter().filter(|term| switched.iter().all(|row| row.term != *term)).collect::<Vec<_>>();
        switched.extend(absent.into_iter().map(|term| {
            let taken = match term {
                Term::Shear => ": shear is taken to be free",
                Term::Stretch => ": cloth is taken not to stretch",
                _ => "",
            };
            let why = format!("{}{taken}", missing(term));
            Screened { term, number: None, is: number_is(term), movement: None, on: false, why }
        }));
        switched.sort_by_key(|row| row.term);
        let screening = Screening { tolerance, rows: switched, trials: judge.trials, evaluations: judge.evaluations };
        return Ok((judge.set, screening));
    }
}

/// What the number of a term is.
fn number_is(term: Term) -> &'static str {
    match term {
        Term::Gravity => "slant / gravity length (B/ρ_A g)^⅓",
        Term::Bending => "gravity length (B/ρ_A g)^⅓ / hem radius",
        Term::Foundation => "E R_t / (ρ_A g)",
        Term::Shear => "S / (ρ_A g L)",
        Term::Stretch => "ρ_A g L / K",
        Term::BodyContact => "smallest gap to the body / waist radius",
        Term::SelfContact => "smallest gap between folds / half fold",
    }
}

struct Judge<'a> {
    case: &'a Case<'a>,
    tolerance: f64,
    /// What is in so far.
    set: TermSet,
    trials: usize,
    evaluations: usize,
}

type Hung = (Prediction, Option<Shape>);

impl Judge<'_> {
    fn hang(&mut self, set: TermSet, folds: Folds) -> Result<Hung, Error> {
        let hung = self.case.hang(set, folds)?;
        self.trials += 1;
        self.evaluations += hung.0.evaluations;
        Ok(hung)
    }

    fn number(&self, term: Term, folds: u32, gaps: &Gaps) -> Option<f64> {
        let (skirt, cloth, all) = (self.case.skirt, self.case.cloth, &self.case.all);
        let (waist, hem, slant) = (skirt.waist_radius().0, skirt.hem_radius().0, skirt.slant_length().0);
        let load = cloth.weight() * slant;
        match term {
            Term::Gravity => Some(slant / cloth.gravity_length()),
            Term::Bending => Some(cloth.gravity_length() / hem),
            Term::Foundation => all.foundation.map(|f| f.modulus() * waist / cloth.weight()),
            Term::Shear => all.shear.map(|s| s.stiffness() / load),
            Term::Stretch => all.stretch.map(|s| load / s.rings.min(s.generatrices)),
            Term::BodyContact => gaps.body.map(|gap| gap / waist),
            Term::SelfContact => gaps.folds.map(|gap| gap * f64::from(folds.max(1)) / (PI * hem)),
        }
    }

    /// Weight and rigidity are what hanging is.
    fn always(&self, base: &Prediction) -> [Screened; 2] {
        let row = |term: Term, movement: Option<f64>, why: &str| Screened {
            term,
            number: self.number(term, base.folds, &Gaps::default()),
            is: number_is(term),
            movement,
            on: true,
            why: why.into(),
        };
        let round = super::ruled::circle(self.case.skirt.hem_radius().0);
        [
            row(Term::Gravity, Some(movement::between(&base.outline, &round)), "without weight the cone stays round"),
            row(Term::Bending, None, "without rigidity no fold count is the best"),
        ]
    }

    /// One term that is not in.
    fn of(&mut self, base: &Hung, term: Term) -> Result<Screened, Error> {
        let (prediction, shape) = base;
        let gaps = shape.as_ref().map_or(Gaps::default(), |shape| self.candidate(shape, term).gaps());
        let number = self.number(term, prediction.folds, &gaps);
        let row = |movement: f64, on: bool, why: String| Screened { term, number, is: number_is(term), movement: Some(movement), on, why };
        let millimetres = |x: f64| x / MILLIMETRE;
        let Some(shape) = shape else {
            if matches!(term, Term::Shear | Term::SelfContact) {
                return Ok(row(0.0, false, "the cone is round: it neither shears nor touches itself".into()));
            }
            let why = "the cone is round";
            return self.trial(prediction, term, self.case.folds, why);
        };
        if let Some((gap, reach)) = self.wall(term, &gaps) {
            if reach <= gap {
                let why = format!("no nearer than {:.1} mm, and felt from {:.1} mm on", millimetres(gap), millimetres(reach));
                return Ok(row(0.0, false, why));
            }
            if CLEAR * self.tolerance < -gap {
                return Ok(row(-gap, true, format!("without it the cloth goes {:.1} mm into it", millimetres(-gap))));
            }
            return self.trial(prediction, term, self.case.folds, &format!("comes within {:.1} mm", millimetres(gap)));
        }
        let candidate = self.candidate(shape, term);
        let Some(response) = candidate.respond(term, prediction) else {
            return self.trial(prediction, term, self.case.folds, "no first-order response exists");
        };
        self.evaluations += 1;
        // Which other fold count is nearest in energy, and whether the term could make it the better one.
        let rival = self.rival(prediction);
        if self.case.folds == Folds::Auto && rival <= response.cost {
            return self.trial(prediction, term, Folds::Auto, "it costs more than another fold count does");
        }
        if CLEAR * self.tolerance <= response.movement {
            let why = format!("first-order response, {CLEAR} times the tolerance or more");
            return Ok(row(response.movement, true, why));
        }
        if response.movement <= self.tolerance / CLEAR {
            return Ok(row(response.movement, false, format!("first-order response, a {CLEAR}th of the tolerance or less")));
        }
        self.trial(prediction, term, Folds::Exactly(prediction.folds), "the first-order response is near the tolerance")
    }

    /// The smallest gap of a wall, and from how far it is felt (between faces).
    fn wall(&self, term: Term, gaps: &Gaps) -> Option<(f64, f64)> {
        match term {
            Term::BodyContact => Some((gaps.body?, self.case.all.body?.barrier().reach)),
            // The gap is between two faces, each of which feels the plane between them.
            Term::SelfContact => Some((gaps.folds.unwrap_or(f64::INFINITY), 2.0 * self.case.all.folds?.barrier().reach)),
            _ => None,
        }
    }

    /// The hem with the term in, measured against the hem without it.
    fn trial(&mut self, base: &Prediction, term: Term, folds: Folds, because: &str) -> Result<Screened, Error> {
        let (with, shape) = self.hang(self.set.with(term), folds)?;
        let moved = movement::between(&base.outline, &with.outline);
        let gaps = shape.as_ref().map_or(Gaps::default(), |shape| self.candidate(shape, term).gaps());
        let on = MARGIN * self.tolerance < moved;
        let changed = if with.folds == base.folds { String::new() } else { format!(", {} folds instead of {}", with.folds, base.folds) };
        Ok(Screened {
            term,
            number: self.number(term, with.folds, &gaps),
            is: number_is(term),
            movement: Some(moved),
            on,
            why: format!("{because}: found with it in{changed}"),
        })
    }

    /// How much more the next best fold count costs, J; a count that was solved with fewer unknowns is given what they may still gain.
    fn rival(&self, base: &Prediction) -> f64 {
        let finest = base.branches.iter().filter_map(|b| b.harmonics).max().unwrap_or(0);
        let coarse = |harmonics: Option<usize>| match harmonics {
            Some(k) if k == finest => 0.0,
            Some(k) if 4 <= k => 5e-4,
            _ => 2e-2,
        };
        let others = base.branches.iter().filter(|b| b.folds != base.folds);
        others.map(|b| below(b.energy, if b.folds == 0 { 0.0 } else { coarse(b.harmonics) }) - base.energy).fold(f64::INFINITY, f64::min)
    }

    /// The shape `shape` as one under `term` as well, unchanged.
    fn candidate(&self, shape: &Shape, term: Term) -> Candidate {
        let terms = self.case.all.only(self.set.with(term));
        match shape {
            Shape::Ruled(shell, x) => {
                let a = shell.coefficients(x);
                let (half, slices) = (2 * crate::model::tangent::half_nodes(a.len()), 48);
                let next = RuledTerms::new(self.case.skirt, &terms, shell.folds(), a.len(), half, slices);
                let before = next.strains();
                let kept = shell.strains();
                let x =
                    DVector::from_fn(
                        before + a.len(),
                        |i, _| if i < before { if kept == before { x[i] } else { 0.0 } } else { a[i - before] },
                    );
                Candidate::Ruled(Box::new(next), x)
            }
            Shape::Graded(shell, x) => {
                let mut setup = *shell.setup();
                if matches!(term, Term::BodyContact | Term::SelfContact) {
                    (setup.half, setup.slices) = (2 * setup.half, 2 * setup.slices);
                }
                let next = GradedTerms::new(self.case.skirt, &terms, setup);
                let x = x.clone().resize_vertically(setup.harmonics * setup.modes + next.strains(), 0.0);
                Candidate::Graded(Box::new(next), x)
            }
        }
    }
}

enum Candidate {
    Ruled(Box<RuledTerms>, DVector<f64>),
    Graded(Box<GradedTerms>, DVector<f64>),
}

/// First-order response to a term.
struct Response {
    /// Of the hem, m.
    movement: f64,
    /// What the term costs at the hem without it, or gains by letting it go, J.
    cost: f64,
}

impl Candidate {
    fn gaps(&self) -> Gaps {
        match self {
            Candidate::Ruled(shell, x) => shell.gaps(x),
            Candidate::Graded(shell, x) => shell.gaps(x),
        }
    }

    /// One Newton step with the term in, from the hem without it.
    fn respond(&self, term: Term, base: &Prediction) -> Option<Response> {
        let at = match self {
            Candidate::Ruled(shell, x) => shell.expand(x)?,
            Candidate::Graded(shell, x) => shell.expand(x)?,
        };
        let step = -Cholesky::new(at.hessian.clone())?.solve(&at.gradient);
        let gain = -0.5 * at.gradient.dot(&step);
        let (moved, energy) = match self {
            Candidate::Ruled(shell, x) => {
                let moved = Shape::Ruled(shell.clone(), x + &step);
                (moved, shell.ledger(x)?)
            }
            Candidate::Graded(shell, x) => {
                let moved = Shape::Graded(shell.clone(), x + &step);
                (moved, shell.ledger(x)?)
            }
        };
        // No term but stretch can lower the energy, so what it costs at the hem without it bounds what it can do to the order of fold counts.
        let cost = if term == Term::Stretch { 2.0 * gain } else { energy.of(term) };
        Some(Response { movement: movement::between(&base.outline, &moved.outline(base.folds)), cost })
    }
}
