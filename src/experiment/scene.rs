//! A scene: what hangs, of which cloth, over which body, and which effects are to count.

use serde::Serialize;

use super::specimen::{Apparatus, Fabric, Skirt};
use crate::units::Metre;

/// One energy contribution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Term {
    /// The weight of the cloth.
    Gravity,
    /// Flexural rigidity.
    Bending,
    /// The paper's elastic foundation.
    Foundation,
    /// Shear of the weave.
    Shear,
    /// Stretch of rings and generatrices.
    Stretch,
    /// Hips under the skirt.
    BodyContact,
    /// Neighbouring folds that touch.
    SelfContact,
}

impl Term {
    pub const ALL: [Term; 7] =
        [Term::Gravity, Term::Bending, Term::Foundation, Term::Shear, Term::Stretch, Term::BodyContact, Term::SelfContact];

    /// As files, flags and records spell it.
    pub fn name(self) -> &'static str {
        match self {
            Term::Gravity => "gravity",
            Term::Bending => "bending",
            Term::Foundation => "foundation",
            Term::Shear => "shear",
            Term::Stretch => "stretch",
            Term::BodyContact => "body_contact",
            Term::SelfContact => "self_contact",
        }
    }

    pub fn named(name: &str) -> Option<Term> {
        Term::ALL.into_iter().find(|term| term.name() == name)
    }
}

/// A set of terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TermSet(u8);

impl TermSet {
    pub const fn none() -> Self {
        TermSet(0)
    }

    /// Weight and flexural rigidity: without the one nothing falls, without the other folds have no least width.
    pub fn usual() -> Self {
        TermSet::none().with(Term::Gravity).with(Term::Bending)
    }

    pub fn with(self, term: Term) -> Self {
        TermSet(self.0 | 1 << term as u8)
    }

    pub fn without(self, term: Term) -> Self {
        TermSet(self.0 & !(1 << term as u8))
    }

    pub fn contains(self, term: Term) -> bool {
        self.0 & 1 << term as u8 != 0
    }

    /// In the order of [`Term::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Term> {
        Term::ALL.into_iter().filter(move |term| self.contains(*term))
    }

    /// `gravity, bending`.
    pub fn names(self) -> String {
        self.iter().map(Term::name).collect::<Vec<_>>().join(", ")
    }
}

impl FromIterator<Term> for TermSet {
    fn from_iter<I: IntoIterator<Item = Term>>(terms: I) -> Self {
        terms.into_iter().fold(TermSet::none(), TermSet::with)
    }
}

impl Serialize for TermSet {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

/// Which terms are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Choice {
    /// Those whose omission would move the hem by more than the tolerance.
    Auto,
    /// These.
    Exactly(TermSet),
}

/// Which theory is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Theory {
    Ruled,
    Graded,
    Ansatz,
    Polar,
}

/// What a scene knows of its cloth beyond weight and rigidity; `None` where it was not measured.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct ClothDetail {
    /// S, N/m.
    pub shear_stiffness: Option<f64>,
    /// Tension per relative stretch along rings, N/m.
    pub ring_stiffness: Option<f64>,
    /// The same along generatrices, N/m.
    pub generatrix_stiffness: Option<f64>,
    /// h_T.
    pub thickness: Option<Metre>,
    /// E of the paper's elastic foundation, N/m³.
    pub foundation_modulus: Option<f64>,
    /// Flexural rigidity along the warp and along the weft, N·m, where they were measured apart.
    pub warp_and_weft: Option<(f64, f64)>,
}

/// The form of the hips: a body of revolution about the axis of the skirt. How far up and down it goes, its users say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BodyShape {
    /// Straight from the waist to the hips, upright below them.
    Cone,
    /// Upright, of the hips' radius.
    Cylinder,
    /// Its equator at the hips, through the waist.
    Ellipsoid,
}

impl BodyShape {
    pub const ALL: [BodyShape; 3] = [BodyShape::Cone, BodyShape::Cylinder, BodyShape::Ellipsoid];

    pub fn name(self) -> &'static str {
        match self {
            BodyShape::Cone => "cone",
            BodyShape::Cylinder => "cylinder",
            BodyShape::Ellipsoid => "ellipsoid",
        }
    }
}

/// The body under the skirt: a cylinder from the waist down, an ellipsoid down to its equator only.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Body {
    pub shape: BodyShape,
    /// At the height of the skirt's waist; `None`: the skirt's own, less an ease of 2 mm.
    pub waist_radius: Option<Metre>,
    pub hip_radius: Metre,
    /// Height of the waist above the hips; a cylinder needs none.
    pub hip_depth: Option<Metre>,
}

/// How the cloth is held at the waist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WaistEdge {
    /// On a ring about which it turns freely.
    #[default]
    Hinged,
    /// In a direction of its own: flat on a disc, between plates.
    Clamped,
}

/// What a prediction needs to know beyond cut, weight and rigidity; a campaign says it once for all its runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hanging {
    pub detail: ClothDetail,
    pub body: Option<Body>,
    pub choice: Choice,
    pub theory: Theory,
    /// How far a screened-out term may move the hem; also what the hem is resolved to.
    pub tolerance: Option<Metre>,
}

impl Hanging {
    /// Of one skirt of a campaign on `apparatus`.
    pub fn scene(&self, skirt: Skirt, fabric: Fabric, apparatus: Apparatus, gravity: f64) -> Scene {
        let Hanging { detail, body, choice, theory, tolerance } = *self;
        let waist_edge = WaistEdge::default();
        Scene { title: None, apparatus, skirt, waist_edge, seams: 0, fabric, detail, body, choice, theory, folds: None, tolerance, gravity }
    }
}

/// Everything that a prediction needs to know, as a scene file says it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scene {
    pub title: Option<String>,
    pub apparatus: Apparatus,
    pub skirt: Skirt,
    pub waist_edge: WaistEdge,
    /// Seams from waist to hem that are stiffer than the cloth.
    pub seams: u32,
    pub fabric: Fabric,
    pub detail: ClothDetail,
    pub body: Option<Body>,
    pub choice: Choice,
    pub theory: Theory,
    /// `None`: the fold count of least energy.
    pub folds: Option<u32>,
    /// How far a screened-out term may move the hem; also what the hem is resolved to.
    pub tolerance: Option<Metre>,
    /// Acceleration of free fall, m/s².
    pub gravity: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_of_terms_hold_what_was_put_in() {
        let set = TermSet::usual().with(Term::SelfContact).without(Term::Gravity);
        assert_eq!(set.iter().collect::<Vec<_>>(), [Term::Bending, Term::SelfContact]);
        assert_eq!(set.names(), "bending, self_contact");
        assert!(Term::ALL.into_iter().all(|t| Term::named(t.name()) == Some(t)) && Term::named("magic").is_none());
    }
}
