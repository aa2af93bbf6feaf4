//! Surfaces with their fields: of a prediction, and of a fitted hem.
//!
//! One function for each source: [`of_prediction`] and [`of_fit`]. Both return [`SurfaceFields`], which `report::surface` writes as a mesh.

use crate::error::Error;
use crate::experiment::{Fabric, Skirt};
use crate::fit::HemFit;
use crate::fit::tangent_family::TangentFit;
use crate::model::field::{GradedShape, HemSample, Sheet, SurfaceFields, linear, ruled, sampled, sampled_hem, surface_fields};
use crate::model::hem::Hem;
use crate::model::tangent::{TangentHem, half_nodes};
use crate::simulate::Prediction;
use crate::units::Metre;

/// How finely a surface is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Rings from waist to hem, at least 2.
    pub rows: usize,
    /// Points round a ring, about: the same number in each half of a fold.
    pub columns: usize,
}

impl Default for Options {
    /// A point each degree, and as far apart along the slant: extremes are then right to a part in a thousand, and a mesh has 46 000 triangles.
    fn default() -> Self {
        Options { rows: 65, columns: 360 }
    }
}

impl Options {
    fn check(&self) -> Result<(), Error> {
        if !(2..=4000).contains(&self.rows) {
            return Err(Error::Invalid { quantity: "rings", value: self.rows as f64, allowed: "2 to 4000" });
        }
        if !(12..=20_000).contains(&self.columns) {
            return Err(Error::Invalid { quantity: "points round a ring", value: self.columns as f64, allowed: "12 to 20000" });
        }
        Ok(())
    }

    /// Intervals in half a fold.
    fn half(&self, folds: u32) -> usize {
        self.columns.div_ceil(2 * folds.max(1) as usize).max(2)
    }

    fn columns(&self, folds: u32) -> usize {
        2 * self.half(folds) * folds.max(1) as usize
    }
}

/// How a surface is drawn from a fitted hem to the round waist.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// The paper's equation (18): p, q, s linear in height.
    Linear,
    /// Straight generatrices of the cloth's own length to the paper's curve.
    Ruled,
}

/// The cloth of a fabric in a field of gravity; `thickness` and Poisson's ratio where they are known.
pub fn sheet(fabric: &Fabric, gravity: f64, thickness: Option<Metre>, poisson: Option<f64>) -> Sheet {
    Sheet {
        weight: fabric.areal_density.map(|d| d.0 * gravity),
        rigidity: fabric.flexural_rigidity.map(|b| b.0),
        thickness: thickness.map(|t| t.0),
        poisson,
    }
}

/// The same as if the cloth were as thick as the paper's and stretched without growing narrower: no campaign measures thickness or Poisson's ratio. What is
/// drawn with it says so.
pub fn assumed_sheet(fabric: &Fabric, gravity: f64) -> Sheet {
    sheet(fabric, gravity, Some(Metre(super::paper::THICKNESS)), Some(ASSUMED_POISSON))
}

/// Poisson's ratio of [`assumed_sheet`]: that of loose weaves is small, and 0 keeps bending moment and curvature in proportion.
pub const ASSUMED_POISSON: f64 = 0.0;

/// The surface of a prediction in the form that its theory has, with all fields that the cloth data allow.
///
/// # Errors
/// [`Error::Invalid`] for a grid of no size; [`Error::Unanswerable`] where the theory has no surface (equation (4) is a plane curve), or where it
/// cannot be drawn at some point because a generatrix would have to be longer than its cloth.
pub fn of_prediction(skirt: &Skirt, prediction: &Prediction, sheet: &Sheet, options: &Options) -> Result<SurfaceFields, Error> {
    options.check()?;
    check(sheet)?;
    if prediction.turning.is_some() {
        return Err(Error::Unanswerable("equation (4) is about the hem alone: it has no surface; ask ruled or graded".into()));
    }
    let folds = prediction.folds;
    if let Some(shape) = &prediction.graded {
        return of_graded(skirt, shape, folds, sheet, options);
    }
    let hem = match &prediction.hem {
        // The ansatz is its own curve; other fidelities give their nearest p, q, s beside the exact hem.
        Some(hem) if prediction.coefficients.is_empty() && folds != 0 => sampled_hem(hem, options.columns(folds)),
        _ => {
            // A round hem is one of two folds without depth.
            let coefficients = if prediction.coefficients.is_empty() { vec![0.0] } else { prediction.coefficients.clone() };
            let curve = TangentHem::new(folds.max(2), skirt.hem_radius().0, &coefficients, 2 * half_nodes(coefficients.len()));
            sampled(&curve, options.columns(folds))
        }
    };
    of_hem(skirt, &hem, folds, sheet, options)
}

/// The surface from the round waist of `skirt` to a fitted hem of the paper, with all fields that the cloth data allow.
///
/// # Errors
/// As [`of_prediction`]; [`Error::Unanswerable`] also if the hem lies further out than the cloth reaches.
pub fn of_fit(skirt: &Skirt, fit: &HemFit, form: Form, sheet: &Sheet, options: &Options) -> Result<SurfaceFields, Error> {
    options.check()?;
    check(sheet)?;
    let folds = fit.folds.unwrap_or(0);
    let hem = if folds == 0 { Hem { p: fit.p.value, q: 0.0, s: 0.0, folds: 2 } } else { fit.hem };
    match form {
        Form::Linear if crate::model::skirt::Cone::of(skirt).height <= 0.0 => {
            Err(Error::Unanswerable("the cone has no height (a drape tester): equation (18) has no surface there".into()))
        }
        Form::Linear => {
            let grid = linear(skirt, hem, options.rows, options.columns(folds));
            Ok(surface_fields("linear surface (18)", folds, skirt, &grid, sheet))
        }
        Form::Ruled => of_hem(skirt, &sampled_hem(&hem, options.columns(folds)), folds, sheet, options),
    }
}

/// The surface of straight generatrices to a fitted hem of equal folds of any shape.
///
/// # Errors
/// As [`of_fit`].
pub fn of_equal_folds(skirt: &Skirt, fit: &TangentFit, sheet: &Sheet, options: &Options) -> Result<SurfaceFields, Error> {
    options.check()?;
    check(sheet)?;
    let coefficients: Vec<f64> = fit.coefficients.iter().map(|a| a.value).collect();
    let curve = TangentHem::new(fit.folds, fit.radius.value, &coefficients, 2 * half_nodes(coefficients.len()));
    of_hem(skirt, &sampled(&curve, options.columns(fit.folds)), fit.folds, sheet, options)
}

fn of_hem(skirt: &Skirt, hem: &[HemSample], folds: u32, sheet: &Sheet, options: &Options) -> Result<SurfaceFields, Error> {
    let grid = ruled(skirt, hem, options.rows).ok_or_else(out_of_reach)?;
    Ok(surface_fields("ruled shell", folds, skirt, &grid, sheet))
}

fn of_graded(skirt: &Skirt, shape: &GradedShape, folds: u32, sheet: &Sheet, options: &Options) -> Result<SurfaceFields, Error> {
    let grid = shape.sample(skirt, options.rows, options.half(shape.setup.folds)).ok_or_else(out_of_reach)?;
    Ok(surface_fields("graded shell", folds, skirt, &grid, sheet))
}

fn out_of_reach() -> Error {
    Error::Unanswerable("the hem lies further out than the cloth reaches somewhere: a generatrix would have to be longer than it is".into())
}

fn check(sheet: &Sheet) -> Result<(), Error> {
    if let Some(thickness) = sheet.thickness
        && !(thickness.is_finite() && 0.0 < thickness)
    {
        return Err(Error::Invalid { quantity: "thickness, m", value: thickness, allowed: "> 0" });
    }
    if let Some(poisson) = sheet.poisson
        && !(0.0..=0.5).contains(&poisson)
    {
        return Err(Error::Invalid { quantity: "Poisson's ratio", value: poisson, allowed: "0 to 0.5" });
    }
    Ok(())
}
