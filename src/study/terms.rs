//! What an effect is worth: every energy term switched off and on, for a scene, for the cells of a campaign, and over a grid of scenes.

use std::cell::Cell;

use rayon::prelude::*;
use serde::Serialize;

use super::accuracy::Depth;
use super::clock::Clock;
use crate::error::Error;
use crate::experiment::scene::{Body, BodyShape, Choice, ClothDetail, Scene, Term, TermSet, Theory, WaistEdge};
use crate::experiment::{Apparatus, Campaign, Fabric, Skirt};
use crate::simulate::scene::{Switched, switch_terms};
use crate::simulate::{Fidelity, Prediction};
use crate::units::{KilogramPerSquareMetre, MILLIMETRE, Metre, NewtonMetre, STANDARD_GRAVITY};

/// One scene, its terms switched.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneTerms {
    pub name: String,
    /// m.
    pub tolerance: f64,
    /// What the screen chose.
    pub chosen: TermSet,
    /// Fold count and evaluations of the hem under the chosen terms.
    pub folds: u32,
    pub evaluations: usize,
    pub screen_evaluations: usize,
    /// In the order of [`Term::ALL`]; terms without data have no row.
    pub rows: Vec<Switched>,
}

/// Steps that each scene is told in: the hem of the chosen terms with the screening before it, and one for each term.
pub const PARTS: usize = 1 + Term::ALL.len();

/// A scene with the name that tables and figures give it.
pub type Named = (String, Scene);

/// Scenes and what came of each, in their order.
#[derive(Debug)]
pub struct TermsStudy {
    /// With the reason where there is no answer.
    pub scenes: Vec<(String, Result<SceneTerms, Error>)>,
}

impl TermsStudy {
    /// Every switched term with its scene.
    pub fn rows(&self) -> impl Iterator<Item = (&SceneTerms, &Switched)> {
        let scenes = self.scenes.iter().filter_map(|(_, answer)| answer.as_ref().ok());
        scenes.flat_map(|scene| scene.rows.iter().map(move |row| (scene, row)))
    }
}

/// Switches every term of every scene; `done` is called [`PARTS`] times for each scene. All but the seconds depends on the scenes alone.
///
/// Scenes are spread over all cores and each is hung on one of them: its seconds are those of one core while the others hang other scenes.
pub fn study(scenes: Vec<Named>, fidelity: Option<Fidelity>, clock: &Clock, done: &(dyn Fn() + Sync)) -> TermsStudy {
    let one = |(name, scene): Named| {
        let told = Cell::new(0);
        let step = || {
            told.set(told.get() + 1);
            done();
        };
        let answer = of_scene(&name, &scene, fidelity, clock, &step);
        // Of terms without data no hem was found.
        (told.get()..PARTS).for_each(|_| done());
        (name, answer)
    };
    TermsStudy { scenes: scenes.into_par_iter().map(one).collect() }
}

/// Switches every term of one scene; `done` is called once for each hem found.
///
/// # Errors
/// As [`switch_terms`]: no theory applies, or a body does not fit.
pub fn of_scene(name: &str, scene: &Scene, fidelity: Option<Fidelity>, clock: &Clock, done: &dyn Fn()) -> Result<SceneTerms, Error> {
    let watch = |hang: &dyn Fn() -> Result<Prediction, Error>| {
        let hung = clock.time(hang);
        done();
        hung
    };
    let (base, rows) = switch_terms(scene, fidelity, &watch)?;
    let screening = base.screening.as_ref();
    Ok(SceneTerms {
        name: name.into(),
        tolerance: screening.map_or(0.0, |s| s.tolerance),
        chosen: rows.iter().filter(|row| row.screened.on).map(|row| row.term).collect(),
        folds: base.folds,
        evaluations: base.evaluations,
        screen_evaluations: screening.map_or(0, |s| s.evaluations),
        rows,
    })
}

/// Every treatment of a campaign whose cut and cloth are known, once, in run order.
pub fn scenes_of(campaign: &Campaign) -> Vec<Named> {
    let mut scenes: Vec<Named> = Vec::new();
    for run in &campaign.design.runs {
        let Some(skirt) = run.skirt else { continue };
        let hanging = campaign.hanging.unwrap_or(crate::experiment::scene::Hanging {
            detail: ClothDetail::default(),
            body: None,
            choice: Choice::Auto,
            theory: Theory::Ruled,
            tolerance: None,
        });
        let scene = hanging.scene(skirt, run.fabric, campaign.apparatus, campaign.gravity);
        if scenes.iter().all(|(_, other)| *other != scene) {
            scenes.push((format!("run {}", run.id), scene));
        }
    }
    scenes
}

/// What cloth and skirts are: rigidity (N·m) with areal density (kg/m²), slant length (m), and a body or none, all with real shear, stretch and
/// thickness. [`Depth::Quick`] has the corners, [`Depth::Usual`] the middles too, [`Depth::Full`] what is between.
pub fn grid(depth: Depth) -> Vec<Named> {
    let cloths =
        [("soft", 1e-6, 0.12), ("rather soft", 3e-6, 0.16), ("medium", 1e-5, 0.2), ("rather stiff", 2.2e-5, 0.25), ("stiff", 5e-5, 0.3)];
    let lengths = [("short", 0.35), ("rather short", 0.43), ("knee", 0.53), ("rather long", 0.69), ("long", 0.9)];
    let step = match depth {
        Depth::Quick => 4,
        Depth::Usual => 2,
        Depth::Full => 1,
    };
    let mut scenes = Vec::new();
    for (cloth, rigidity, density) in cloths.into_iter().step_by(step) {
        for (length, slant) in lengths.into_iter().step_by(step) {
            // Of the same conicity: the paper's Table 1.
            let skirt = Skirt::new(Metre(0.121), Metre(0.121 + 0.217 * slant), Metre(slant));
            for body in [None, Some(BODY)] {
                let Ok(skirt) = skirt else { continue };
                let fabric =
                    Fabric { areal_density: Some(KilogramPerSquareMetre(density)), flexural_rigidity: Some(NewtonMetre(rigidity)) };
                let name = format!("{cloth}, {length}{}", if body.is_some() { ", over hips" } else { "" });
                scenes.push((name, Scene { body, ..plain(skirt, fabric) }));
            }
        }
    }
    scenes
}

/// The size of the theory that a depth takes: a quick look has fewer harmonics, any other the scene's own theory.
pub fn fidelity(depth: Depth) -> Option<Fidelity> {
    (depth == Depth::Quick).then_some(Fidelity::Ruled { harmonics: 3 })
}

/// Hips of 91 cm below a waist of 76 cm.
const BODY: Body = Body { shape: BodyShape::Ellipsoid, waist_radius: None, hip_radius: Metre(0.145), hip_depth: Some(Metre(0.2)) };

/// Woven cloth on the bias at the softest: S of 0.5 N/m, firm threads, 0.3 mm.
fn plain(skirt: Skirt, fabric: Fabric) -> Scene {
    Scene {
        title: None,
        apparatus: Apparatus::Skirt,
        skirt,
        waist_edge: WaistEdge::Hinged,
        seams: 0,
        fabric,
        detail: ClothDetail {
            shear_stiffness: Some(0.5),
            ring_stiffness: Some(2000.0),
            generatrix_stiffness: Some(2000.0),
            thickness: Some(Metre(0.3 * MILLIMETRE)),
            foundation_modulus: None,
            warp_and_weft: None,
        },
        body: None,
        choice: Choice::Auto,
        theory: Theory::Ruled,
        folds: None,
        tolerance: Some(Metre(MILLIMETRE)),
        gravity: STANDARD_GRAVITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deeper_grid_has_the_scenes_of_a_shallower_one() {
        let [quick, usual, full] = [Depth::Quick, Depth::Usual, Depth::Full].map(grid);
        assert_eq!([quick.len(), usual.len(), full.len()], [8, 18, 50]);
        assert!(quick.iter().all(|scene| usual.contains(scene)) && usual.iter().all(|scene| full.contains(scene)));
    }

    #[test]
    fn every_term_with_data_is_switched_about_what_the_screen_chose() {
        let fabric = Fabric { areal_density: Some(KilogramPerSquareMetre(0.2)), flexural_rigidity: Some(NewtonMetre(1e-5)) };
        let skirt = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap();
        let scene = Scene { folds: Some(5), ..plain(skirt, fabric) };
        let study = of_scene("table 1", &scene, Some(Fidelity::Ruled { harmonics: 2 }), &Clock::of(Depth::Quick), &|| ()).unwrap();
        let terms: Vec<Term> = study.rows.iter().map(|row| row.term).collect();
        assert_eq!(terms, [Term::Gravity, Term::Bending, Term::Shear, Term::Stretch, Term::SelfContact]);
        // Without weight the cone is round: the hem moves by about the depth of its folds, as the screen says.
        let gravity = &study.rows[0];
        assert_eq!((gravity.with.as_ref().unwrap().folds, gravity.without.as_ref().unwrap().folds), (5, 0));
        assert!(0.03 < gravity.movement.unwrap());
        for row in study.rows.iter().filter(|row| !row.screened.on) {
            assert!(row.movement.unwrap() < study.tolerance, "{row:?}");
        }
        assert!(study.chosen.contains(Term::Gravity));
    }
}
