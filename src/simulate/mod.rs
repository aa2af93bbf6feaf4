//! Forward: skirt + fabric + terms → predicted hem. Nothing here is fitted.

pub mod ansatz;
mod effort;
pub mod equilibrium;
pub mod graded;
mod hanging;
mod movement;
pub mod polar;
mod projection;
pub mod ruled;
pub mod scene;
pub mod screen;
mod tolerance;

use serde::Serialize;

pub use effort::Effort;
pub use polar::Turning;
pub use scene::{predict_scene, screen_scene};
pub use screen::{Screened, Screening};

use crate::error::Error;
use crate::experiment::{Fabric, Point, Skirt};
use crate::model::field::GradedShape;
use crate::model::hem::Hem;
use crate::numerics::minimize::Ending;
use crate::units::{Metre, STANDARD_GRAVITY};

/// Which fold counts to consider.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Folds {
    /// The fold count of least energy.
    Auto,
    /// This one, at least 2: with fewer the hem does not close by symmetry.
    Exactly(u32),
}

/// Which theory predicts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fidelity {
    /// The ruled shell over the tangent-angle family with this many harmonics, 1 … [`ruled::MOST_HARMONICS`].
    Ruled { harmonics: usize },
    /// The graded shell: K = `harmonics` (1 … 12) by J = `modes` (2 … 24) unknowns.
    Graded {
        harmonics: usize,
        modes: usize,
        /// Shear stiffness S of the weave, N/m; 0 leaves shear free.
        shear: f64,
    },
    /// The paper's curve in the energy of the ruled shell.
    Ansatz,
    /// The paper's equation (4); it has no bending, so it cannot choose the fold count.
    Polar {
        /// Foundation modulus E, N/m³.
        foundation: f64,
    },
}

/// What to predict with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    pub fidelity: Fidelity,
    pub folds: Folds,
    /// Acceleration of free fall, m/s².
    pub gravity: f64,
    /// Distance to which the hem must be resolved: harmonics and modes are then chosen, whatever the fidelity names.
    pub tolerance: Option<Metre>,
    pub effort: Effort,
}

impl Default for Options {
    /// The ruled shell answers in milliseconds, to ten digits; the graded shell is nearer to a real skirt and takes ten times as long.
    fn default() -> Self {
        Options {
            fidelity: Fidelity::Ruled { harmonics: ruled::HARMONICS },
            folds: Folds::Auto,
            gravity: STANDARD_GRAVITY,
            tolerance: None,
            effort: Effort::default(),
        }
    }
}

/// How a minimization ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Termination {
    Converged,
    Stalled,
    EvaluationLimit,
    /// The round cone is stable: there are no folds. An answer, not a failure.
    Round,
}

impl From<Ending> for Termination {
    fn from(ending: Ending) -> Self {
        match ending {
            Ending::Converged => Termination::Converged,
            Ending::Stalled => Termination::Stalled,
            Ending::EvaluationLimit => Termination::EvaluationLimit,
        }
    }
}

/// The energy of one term at the solution.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TermEnergy {
    pub term: &'static str,
    /// J.
    pub energy: f64,
    pub evaluations: usize,
}

/// One branch of solutions: its fold count and what it costs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Branch {
    /// Fold count that was asked for.
    pub asked: u32,
    /// True period of the solution: a branch may slide to a subharmonic. 0: it went back to the round cone.
    pub folds: u32,
    /// Harmonics it was solved with: fold counts that one harmonic puts far above the least energy are not refined.
    /// `None` where the family has none.
    pub harmonics: Option<usize>,
    /// In the unit of the prediction's energy.
    pub energy: f64,
    /// max r − min r, m.
    pub depth: f64,
    /// Flexural rigidity above which the round cone is stable against the asked folds, N·m; `None` if it always is, or the theory has no rigidity.
    pub threshold_rigidity: Option<f64>,
    /// Lowest eigenvalue of the energy's Hessian within the branch's own family, J; positive: stable against changes that keep its symmetry.
    /// `None` where the theory gives an extremal, not a minimum.
    pub lowest_curvature: Option<f64>,
    pub termination: Termination,
}

/// A predicted hem.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prediction {
    /// `ruled(K = 8)` …
    pub fidelity: String,
    /// 0: round, no folds.
    pub folds: u32,
    /// In `energy_unit`.
    pub energy: f64,
    /// `J`; `N/m` for the paper's functional, which is no energy as printed.
    pub energy_unit: &'static str,
    pub terms: Vec<TermEnergy>,
    /// m.
    pub hem_radius_min: f64,
    /// m.
    pub hem_radius_max: f64,
    /// a_1 … a_K, a_1 > 0; empty for the round cone.
    pub coefficients: Vec<f64>,
    /// The hem, m: centred, a crest on the x axis, counter-clockwise, equally spaced in cloth length; the same number of points in every fold.
    #[serde(skip)]
    pub outline: Vec<Point>,
    pub termination: Termination,
    /// Evaluations of energy, gradient and Hessian, over all branches.
    pub evaluations: usize,
    /// Every fold count tried, ascending.
    pub branches: Vec<Branch>,
    /// How far the hem may be from that of infinitely many unknowns, m, by the last refinement; `None` where no tolerance was asked.
    pub error_estimate: Option<f64>,
    /// What a reader should know before using the numbers: limits of the theory that this scene meets.
    pub notes: Vec<String>,
    /// p, q, s of the paper's curve: the solution of the ansatz; of other fidelities the nearest curve to the hem.
    pub hem: Option<Hem>,
    /// Root mean square orthogonal distance of the hem from that curve, m; 0 for the ansatz.
    pub hem_rms: Option<f64>,
    /// The Lagrange multiplier of the hem's length, where the fidelity has one.
    pub multiplier: Option<Multiplier>,
    /// Turning points of the paper's equation (4).
    pub turning: Option<Turning>,
    /// The walls that are in: the body's, and those between folds.
    pub contacts: Vec<Contact>,
    /// Why which terms are in, where that was left to the screen.
    pub screening: Option<Screening>,
    /// The whole surface of the graded shell, where that was asked and folds.
    #[serde(skip)]
    pub graded: Option<GradedShape>,
}

/// A wall that cloth leans on, and how near it comes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Contact {
    pub term: &'static str,
    /// κ of the barrier, N/m³.
    pub stiffness: f64,
    /// From how far it is felt, m.
    pub reach: f64,
    /// The smallest gap of the solution, m, on twice the nodes or more that it was found on; `None` where no cloth can touch.
    pub smallest_gap: Option<f64>,
}

/// What a longer hem would cost or save.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Multiplier {
    pub value: f64,
    /// `N` for an energy, `N/m²` for the paper's functional.
    pub unit: &'static str,
}

impl Prediction {
    /// Energy of one term, J; `None` if the term was not in.
    pub fn energy_of(&self, term: &str) -> Option<f64> {
        self.terms.iter().find(|t| t.term == term).map(|t| t.energy)
    }

    /// max r − min r, m.
    pub fn depth(&self) -> f64 {
        self.hem_radius_max - self.hem_radius_min
    }
}

/// The hem of a skirt from its cut and its cloth.
///
/// # Errors
/// [`Error::Invalid`] if the cloth data or an option is zero, negative or not finite; [`Error::Unanswerable`] if the cloth data are missing or
/// the theory does not apply: a cone of base angle 0 (a drape tester) has no straight generatrices to hang from.
pub fn predict(skirt: &Skirt, fabric: &Fabric, options: &Options) -> Result<Prediction, Error> {
    let Some(tolerance) = options.tolerance else { return predict_once(skirt, fabric, options) };
    tolerance::predict(options.fidelity, options.folds, tolerance.0, |fidelity, folds| {
        predict_once(skirt, fabric, &Options { fidelity, folds, tolerance: None, ..*options })
    })
}

fn predict_once(skirt: &Skirt, fabric: &Fabric, options: &Options) -> Result<Prediction, Error> {
    let cloth = Cloth::of(fabric, options.gravity)?;
    if let Folds::Exactly(folds) = options.folds
        && !(2..=ruled::MOST_FOLDS).contains(&folds)
    {
        return Err(Error::Invalid { quantity: "fold count", value: f64::from(folds), allowed: "2 to 512" });
    }
    let mut prediction = match options.fidelity {
        Fidelity::Ruled { harmonics } => ruled::predict(skirt, &cloth, options.folds, harmonics, &options.effort),
        Fidelity::Graded { harmonics, modes, shear } => {
            graded::predict(skirt, &cloth, options.folds, (harmonics, modes), shear, &options.effort)
        }
        Fidelity::Ansatz => ansatz::predict(skirt, &cloth, options.folds, &options.effort),
        Fidelity::Polar { foundation } => polar::predict(skirt, cloth.weight(), foundation, options.folds, &options.effort),
    }?;
    project(&mut prediction);
    Ok(prediction)
}

/// The paper's curve nearest to a hem that has none yet.
fn project(prediction: &mut Prediction) {
    if prediction.hem.is_none() && prediction.folds != 0 {
        (prediction.hem, prediction.hem_rms) = projection::onto_paper_curve(&prediction.outline, prediction.folds).unzip();
    }
}

/// Cloth in a field of gravity, checked: weight per area ρ_A g (N/m²) and flexural rigidity B (N·m), both positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cloth {
    weight: f64,
    rigidity: f64,
}

impl Cloth {
    /// # Errors
    /// [`Error::Unanswerable`] where a property was not measured, [`Error::Invalid`] where it is not a positive number.
    pub fn of(fabric: &Fabric, gravity: f64) -> Result<Self, Error> {
        let missing = |what: &str| Error::Unanswerable(format!("the {what} of the cloth is not known, so its hem cannot be predicted"));
        let density = fabric.areal_density.ok_or_else(|| missing("areal density"))?.0;
        let rigidity = fabric.flexural_rigidity.ok_or_else(|| missing("flexural rigidity"))?.0;
        for (quantity, value) in
            [("areal density, kg/m²", density), ("flexural rigidity, N·m", rigidity), ("acceleration of free fall, m/s²", gravity)]
        {
            if !(value.is_finite() && 0.0 < value) {
                return Err(Error::Invalid { quantity, value, allowed: "> 0" });
            }
        }
        Ok(Cloth { weight: density * gravity, rigidity })
    }

    /// ρ_A g, N/m².
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// B, N·m.
    pub fn rigidity(&self) -> f64 {
        self.rigidity
    }

    /// (B/ρ_A g)^⅓, m: the length over which this cloth holds itself up.
    pub fn gravity_length(&self) -> f64 {
        (self.rigidity / self.weight).cbrt()
    }
}
