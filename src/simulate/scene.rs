//! A scene → its hem: the terms that it has data for, those that are in, and whether any theory here applies at all.

use nalgebra::DVector;

use super::graded::{self, HARMONICS, MODES};
use super::screen::{Screened, Screening, screen};
use super::{Cloth, Effort, Fidelity, Folds, Options, Prediction, movement, predict, project, ruled, tolerance};
use crate::error::Error;
use crate::experiment::scene::{Choice, Scene, Term, TermSet, Theory, WaistEdge};
use crate::experiment::{Apparatus, Point, Skirt};
use crate::model::energy::Terms;
use crate::model::energy::body_contact::BodyContact;
use crate::model::energy::foundation::Foundation;
use crate::model::energy::self_contact::SelfContact;
use crate::model::energy::shear::Shear;
use crate::model::energy::stretch::Stretch;
use crate::model::graded_terms::GradedTerms;
use crate::model::ruled_terms::RuledTerms;
use crate::units::{MILLIMETRE, Metre};

/// Thickness of cloth of which none is given: a light woven cloth, m.
pub const THICKNESS: f64 = 0.3 * MILLIMETRE;
/// How far a screened-out term may move the hem where the scene does not say, m: what a drape profile is measured to.
pub const TOLERANCE: Metre = Metre(1.0 * MILLIMETRE);
/// Gravity lengths below which a slant is short: the layers at waist and hem, each about one long, then take half of it.
const SHORT: f64 = 4.0;
/// The same where the waist is clamped: the layer there is as stiff as the rest.
const SHORT_CLAMPED: f64 = 10.0;
/// Directions whose rigidities differ by less than this share hang alike within what a laboratory measures.
const ALIKE: f64 = 0.05;

/// The hem of a scene, by the terms that it asks for or that the screen finds needed. `fidelity` overrides the size of the scene's own theory.
///
/// # Errors
/// [`Error::Unanswerable`] if no theory here applies (a drape tester, a short clamped edge, directions that differ, seams), if a term is asked for
/// of which the scene has no data, or if the body does not go through the skirt; [`Error::Invalid`] for a value that makes no sense.
pub fn predict_scene(scene: &Scene, fidelity: Option<Fidelity>) -> Result<Prediction, Error> {
    let cloth = Cloth::of(&scene.fabric, scene.gravity)?;
    let case = match prepare(scene, &cloth, fidelity)? {
        Prepared::Case(case) => case,
        Prepared::Fixed(fidelity, folds) => return fixed(scene, fidelity, folds),
    };
    let (set, screening) = match scene.choice {
        Choice::Exactly(set) => (case.complete(set)?, None),
        Choice::Auto => {
            let (set, screening) = screen(&case, scene.tolerance.unwrap_or(TOLERANCE).0)?;
            (set, Some(screening))
        }
    };
    case.predict(set, scene.tolerance, screening)
}

/// What the screen chooses for a scene, whatever terms it asks for.
///
/// # Errors
/// As [`predict_scene`]; [`Error::Unanswerable`] for a theory whose terms are given.
pub fn screen_scene(scene: &Scene, fidelity: Option<Fidelity>) -> Result<(TermSet, Screening), Error> {
    let cloth = Cloth::of(&scene.fabric, scene.gravity)?;
    match prepare(scene, &cloth, fidelity)? {
        Prepared::Case(case) => screen(&case, scene.tolerance.unwrap_or(TOLERANCE).0),
        Prepared::Fixed(..) => {
            Err(Error::Unanswerable("the terms of ansatz and polar equation are given: there is nothing to screen".into()))
        }
    }
}

enum Prepared<'a> {
    Case(Case<'a>),
    /// A theory whose terms are given.
    Fixed(Fidelity, Folds),
}

fn prepare<'a>(scene: &'a Scene, cloth: &'a Cloth, fidelity: Option<Fidelity>) -> Result<Prepared<'a>, Error> {
    refuse(scene, cloth)?;
    let folds = scene.folds.map_or(Folds::Auto, Folds::Exactly);
    let own = match scene.theory {
        Theory::Ruled => Fidelity::Ruled { harmonics: ruled::HARMONICS },
        Theory::Graded => Fidelity::Graded { harmonics: HARMONICS, modes: MODES, shear: 0.0 },
        Theory::Ansatz => Fidelity::Ansatz,
        Theory::Polar => Fidelity::Polar { foundation: scene.detail.foundation_modulus.unwrap_or(0.0) },
    };
    let fidelity = fidelity.unwrap_or(own);
    if let Folds::Exactly(folds) = folds
        && !(2..=ruled::MOST_FOLDS).contains(&folds)
    {
        return Err(Error::Invalid { quantity: "fold count", value: f64::from(folds), allowed: "2 to 512" });
    }
    if !matches!(fidelity, Fidelity::Ruled { .. } | Fidelity::Graded { .. }) {
        return Ok(Prepared::Fixed(fidelity, folds));
    }
    Ok(Prepared::Case(Case { skirt: &scene.skirt, cloth, all: available(scene, cloth)?, folds, fidelity }))
}

/// A scene under one theory, ready to be hung with any of its terms.
pub(super) struct Case<'a> {
    pub(super) skirt: &'a Skirt,
    pub(super) cloth: &'a Cloth,
    /// Every term that the scene has data for.
    pub(super) all: Terms,
    pub(super) folds: Folds,
    pub(super) fidelity: Fidelity,
}

/// The shape behind a prediction.
pub(super) enum Shape {
    Ruled(Box<RuledTerms>, DVector<f64>),
    Graded(Box<GradedTerms>, DVector<f64>),
}

impl Case<'_> {
    /// `set`, if the scene knows enough for all of it.
    fn complete(&self, set: TermSet) -> Result<TermSet, Error> {
        if let Some(term) = set.iter().find(|term| !self.all.set().contains(*term)) {
            return Err(Error::Unanswerable(format!("the term “{}” is asked for, but {}", term.name(), missing(term))));
        }
        if !set.contains(Term::Bending) && self.folds == Folds::Auto {
            let why =
                "without bending ever finer folds cost ever less, so that no fold count is the best: add “bending”, or give a fold count";
            return Err(Error::Unanswerable(why.into()));
        }
        Ok(set)
    }

    /// The hem under `set`, resolved to `tolerance` if there is one.
    fn predict(&self, set: TermSet, tolerance: Option<Metre>, screening: Option<Screening>) -> Result<Prediction, Error> {
        let mut prediction = match tolerance {
            None => self.hang(set, self.folds)?.0,
            Some(Metre(asked)) => {
                let once = |fidelity: Fidelity, folds: Folds| Ok(Case { all: self.all, fidelity, ..*self }.hang(set, folds)?.0);
                tolerance::predict(self.fidelity, self.folds, asked, once)?
            }
        };
        project(&mut prediction);
        prediction.screening = screening;
        Ok(prediction)
    }

    /// One hanging at this size.
    pub(super) fn hang(&self, set: TermSet, folds: Folds) -> Result<(Prediction, Option<Shape>), Error> {
        let terms = self.all.only(set);
        match self.fidelity {
            Fidelity::Ruled { harmonics } => {
                let hung = ruled::hang(self.skirt, self.cloth, &terms, folds, harmonics, &Effort::default())?;
                Ok((hung.prediction, hung.shape.map(|(shell, x)| Shape::Ruled(Box::new(shell), x))))
            }
            Fidelity::Graded { harmonics, modes, .. } => {
                let hung = graded::hang(self.skirt, self.cloth, &terms, folds, (harmonics, modes), &Effort::default())?;
                Ok((hung.prediction, hung.shape.map(|(shell, x)| Shape::Graded(Box::new(shell), x))))
            }
            _ => Err(Error::Unanswerable("this theory has a fixed set of terms".into())),
        }
    }
}

/// What one term adds or takes: the same scene hung with and without it, the others as the screen chose.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Switched {
    pub term: Term,
    /// What the screen said.
    pub screened: Screened,
    pub with: Option<HemNumbers>,
    pub without: Option<HemNumbers>,
    /// How far the hem moves, m.
    pub movement: Option<f64>,
    /// Why there is no movement, where there is none.
    pub missing: Option<String>,
}

/// The numbers of a hem that a switched term may change.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct HemNumbers {
    pub folds: u32,
    /// λ, N; `None` under terms that have no closed form for it.
    pub multiplier: Option<f64>,
    pub evaluations: usize,
    /// By the watch that was handed over.
    pub seconds: f64,
}

impl HemNumbers {
    fn of(prediction: &Prediction, seconds: f64) -> Self {
        let multiplier = prediction.multiplier.map(|m| m.value);
        HemNumbers { folds: prediction.folds, multiplier, evaluations: prediction.evaluations, seconds }
    }
}

/// Computes a hem, and says how many seconds that took: there is no clock in this layer.
pub type Watch<'a> = dyn Fn(&dyn Fn() -> Result<Prediction, Error>) -> (Result<Prediction, Error>, f64) + 'a;

/// Switches every term that the scene has data for about the set that the screen chooses, which comes first; `watch` computes each hem.
///
/// # Errors
/// As [`screen_scene`].
pub fn switch_terms(scene: &Scene, fidelity: Option<Fidelity>, watch: &Watch<'_>) -> Result<(Prediction, Vec<Switched>), Error> {
    let (set, screening) = screen_scene(scene, fidelity)?;
    let hang = |set: TermSet| {
        let scene = Scene { choice: Choice::Exactly(set), tolerance: None, ..scene.clone() };
        watch(&|| predict_scene(&scene, fidelity))
    };
    let (base, seconds) = hang(set);
    let mut base = base?;
    let rows = screening.rows.iter().filter(|row| row.number.is_some());
    let switched = rows
        .map(|row| {
            let (other, took) = hang(if row.on { set.without(row.term) } else { set.with(row.term) });
            let changed = other.as_ref().ok().map(|other| HemNumbers::of(other, took));
            let chosen = Some(HemNumbers::of(&base, seconds));
            let (with, without) = if row.on { (chosen, changed) } else { (changed, chosen) };
            Switched {
                term: row.term,
                screened: row.clone(),
                with,
                without,
                movement: other.as_ref().ok().map(|other| hem_movement(&base, other)),
                missing: other.err().map(|why| why.to_string()),
            }
        })
        .collect();
    base.screening = Some(screening);
    Ok((base, switched))
}

/// Greatest distance (m) between the same points of cloth of two predicted hems, each from a crest.
pub fn hem_movement(a: &Prediction, b: &Prediction) -> f64 {
    movement::between(&a.outline, &b.outline)
}

impl Shape {
    pub(super) fn outline(&self, folds: u32) -> Vec<Point> {
        let n = ruled::outline_points(folds);
        match self {
            Shape::Ruled(shell, x) => shell.curve(x).outline(n),
            Shape::Graded(shell, x) => shell.curve(x).outline(n),
        }
    }
}

/// What a scene must give for a term.
pub(super) fn missing(term: Term) -> &'static str {
    match term {
        Term::Gravity | Term::Bending | Term::SelfContact => "the cloth is not known",
        Term::Foundation => "the scene gives no foundation_modulus_n_m3 above 0",
        Term::Shear => "the scene gives no shear_stiffness_n_m above 0",
        Term::Stretch => "the scene gives no ring_stiffness_n_m or generatrix_stiffness_n_m",
        Term::BodyContact => "the scene has no [body]",
    }
}

/// Every term that the scene has data for.
fn available(scene: &Scene, cloth: &Cloth) -> Result<Terms, Error> {
    let (detail, skirt) = (&scene.detail, &scene.skirt);
    let positive = |quantity: &'static str, value: Option<f64>| match value {
        Some(value) if !(value.is_finite() && 0.0 < value) => Err(Error::Invalid { quantity, value, allowed: "> 0" }),
        other => Ok(other),
    };
    let rings = positive("stretch stiffness of rings, N/m", detail.ring_stiffness)?;
    let generatrices = positive("stretch stiffness of generatrices, N/m", detail.generatrix_stiffness)?;
    let thickness = positive("thickness of the cloth, m", detail.thickness.map(|t| t.0))?.unwrap_or(THICKNESS);
    // Zero is what cloth without it has.
    let above = |quantity: &'static str, value: Option<f64>| positive(quantity, value.filter(|value| *value != 0.0));
    // One direction speaks for the other where only one was measured.
    let stretch = rings.or(generatrices).zip(generatrices.or(rings)).map(|(rings, generatrices)| Stretch { rings, generatrices });
    Ok(Terms {
        foundation: above("foundation modulus, N/m³", detail.foundation_modulus)?.map(|modulus| Foundation::new(skirt, modulus)),
        shear: above("shear stiffness, N/m", detail.shear_stiffness)?.map(Shear::new),
        stretch,
        body: scene.body.as_ref().map(|body| BodyContact::new(skirt, body, cloth.weight())).transpose()?,
        folds: Some(SelfContact::new(cloth.weight(), thickness, skirt.slant_length().0)),
        ..Terms::usual(cloth.weight(), cloth.rigidity())
    })
}

/// The theories whose terms are given.
fn fixed(scene: &Scene, fidelity: Fidelity, folds: Folds) -> Result<Prediction, Error> {
    let (own, name) = match fidelity {
        Fidelity::Polar { foundation } => {
            let own = TermSet::none().with(Term::Gravity);
            (if 0.0 < foundation { own.with(Term::Foundation) } else { own }, "the polar equation")
        }
        _ => (TermSet::usual(), "the ansatz"),
    };
    if let Choice::Exactly(set) = scene.choice
        && set != own
    {
        return Err(Error::Unanswerable(format!("{name} has the terms {} and no others, asked are {}", own.names(), set.names())));
    }
    let options = Options { fidelity, folds, gravity: scene.gravity, tolerance: scene.tolerance, ..Options::default() };
    let mut prediction = predict(&scene.skirt, &scene.fabric, &options)?;
    if scene.choice == Choice::Auto {
        prediction.notes.push(format!("{name} has the terms {} and no others: nothing was screened", own.names()));
    }
    Ok(prediction)
}

/// Says why no theory here applies, if none does.
fn refuse(scene: &Scene, cloth: &Cloth) -> Result<(), Error> {
    let no = |why: String| Err(Error::Unanswerable(format!("no fidelity here applies: {why}")));
    if scene.apparatus == Apparatus::Drapemeter {
        return no("cloth on a drape tester is clamped flat and bends over the support; all theories here hang from a hinged waist".into());
    }
    let lengths = scene.skirt.slant_length().0 / cloth.gravity_length();
    if scene.waist_edge == WaistEdge::Clamped && lengths < SHORT_CLAMPED {
        return no(format!(
            "the slant is {lengths:.1} gravity lengths (B/ρ_A g)^⅓ long and clamped at the waist; the clamped edge, which is in no theory here, \
             can be left out from about {SHORT_CLAMPED} on"
        ));
    }
    if lengths < SHORT {
        return no(format!(
            "the slant is only {lengths:.1} gravity lengths (B/ρ_A g)^⅓ long: it stands off rather than hangs; the theories here begin at about {SHORT}"
        ));
    }
    if let Some((warp, weft)) = scene.detail.warp_and_weft
        && ALIKE < (warp - weft).abs() / warp.max(weft)
    {
        return no(format!(
            "warp and weft differ in rigidity by a factor {:.2}, so that folds differ round the hem; the theories here have m equal folds, and this \
             needs the full period",
            warp.max(weft) / warp.min(weft)
        ));
    }
    if 0 < scene.seams {
        return no(format!(
            "{} seam(s) are stiffer than the cloth between them, so that folds differ round the hem; the theories here have m equal folds, and this \
             needs the full period",
            scene.seams
        ));
    }
    Ok(())
}
