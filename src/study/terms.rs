//! What an effect is worth: every energy term switched off and on, for a scene, for the cells of a campaign, and over a grid of scenes.

use rayon::prelude::*;
use serde::Serialize;

use crate::error::Error;
use crate::experiment::scene::{Body, BodyShape, Choice, ClothDetail, Scene, Term, TermSet, Theory, WaistEdge};
use crate::experiment::{Apparatus, Campaign, Fabric, Skirt};
use crate::simulate::Fidelity;
use crate::simulate::scene::{Switched, switch_terms};
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

/// Switches every term of one scene.
///
/// # Errors
/// As [`switch_terms`]: no theory applies, or a body does not fit.
pub fn of_scene(name: &str, scene: &Scene, fidelity: Option<Fidelity>) -> Result<SceneTerms, Error> {
    let (base, rows) = switch_terms(scene, fidelity)?;
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

/// Every treatment of a campaign whose cut and cloth are known, once, in run order; with the reason where there is no answer.
pub fn of_campaign(campaign: &Campaign) -> Vec<(String, Result<SceneTerms, Error>)> {
    let mut scenes: Vec<(String, Scene)> = Vec::new();
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
    answer(scenes)
}

/// The corners and middles of what cloth and skirts are: rigidity, length, and a body or none, all with real shear, stretch and thickness.
pub fn grid() -> Vec<(String, Result<SceneTerms, Error>)> {
    let mut scenes = Vec::new();
    for (cloth, rigidity, density) in [("soft", 1e-6, 0.12), ("medium", 1e-5, 0.2), ("stiff", 5e-5, 0.3)] {
        for (length, slant) in [("short", 0.35), ("knee", 0.53), ("long", 0.9)] {
            // Of the same conicity: the paper's Table 1.
            let skirt = Skirt::new(Metre(0.121), Metre(0.121 + 0.217 * slant), Metre(slant));
            for body in [None, Some(BODY)] {
                let Ok(skirt) = skirt else { continue };
                let fabric =
                    Fabric { areal_density: Some(KilogramPerSquareMetre(density)), flexural_rigidity: Some(NewtonMetre(rigidity)) };
                let name = format!("{cloth}, {length}{}", if body.is_some() { ", over hips" } else { "" });
                scenes.push((name, Scene { skirt, fabric, body, ..plain(skirt, fabric) }));
            }
        }
    }
    answer(scenes)
}

/// Hips of 94 cm below a waist of 76 cm.
const BODY: Body = Body { shape: BodyShape::Ellipsoid, waist_radius: None, hip_radius: Metre(0.1496), hip_depth: Some(Metre(0.2)) };

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

fn answer(scenes: Vec<(String, Scene)>) -> Vec<(String, Result<SceneTerms, Error>)> {
    scenes
        .into_par_iter()
        .map(|(name, scene)| {
            let answer = of_scene(&name, &scene, None);
            (name, answer)
        })
        .collect()
}

/// The map: for every scene and term the movement in mm, `None` where the scene has no such term or no answer.
pub fn map(answers: &[(String, Result<SceneTerms, Error>)]) -> Vec<(String, [Option<f64>; 7])> {
    let row = |(name, answer): &(String, Result<SceneTerms, Error>)| {
        let of = |term: Term| answer.as_ref().ok()?.rows.iter().find(|row| row.term == term)?.movement.map(|m| m / MILLIMETRE);
        (name.clone(), Term::ALL.map(of))
    };
    answers.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_term_with_data_is_switched_about_what_the_screen_chose() {
        let fabric = Fabric { areal_density: Some(KilogramPerSquareMetre(0.2)), flexural_rigidity: Some(NewtonMetre(1e-5)) };
        let skirt = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap();
        let scene = Scene { folds: Some(5), ..plain(skirt, fabric) };
        let study = of_scene("table 1", &scene, Some(Fidelity::Ruled { harmonics: 2 })).unwrap();
        let terms: Vec<Term> = study.rows.iter().map(|row| row.term).collect();
        assert_eq!(terms, [Term::Gravity, Term::Bending, Term::Shear, Term::Stretch, Term::SelfContact]);
        // Without weight the cone is round: the hem moves by about the depth of its folds, as the screen says.
        let gravity = &study.rows[0];
        assert_eq!((gravity.with.as_ref().unwrap().folds, gravity.without.as_ref().unwrap().folds), (5, 0));
        assert!(0.03 < gravity.movement.unwrap());
        for row in study.rows.iter().filter(|row| !row.screened.on) {
            assert!(row.movement.unwrap() < study.tolerance, "{row:?}");
        }
        assert!(study.chosen.contains(Term::Gravity) && map(&[("one".into(), Ok(study))])[0].1[Term::Foundation as usize].is_none());
    }
}
