//! How irregular the folds of one outline are: the paper's curve, equal folds of any shape, and a free outline, side by side.

use super::lack_of_fit::{LackOfFit, Left, lack_of_fit};
use crate::experiment::{DrapeProfile, Point};
use crate::fit::fold_table::{self, FoldTable, fold_table};
use crate::fit::free_outline::{FreeOutline, free_outline, order_that_holds};
use crate::fit::outline::smooth;
use crate::fit::tangent_family::{TangentFit, tangent_family};
use crate::fit::{HemFit, aicc, circle, orthogonal};
use crate::numerics::least_squares;

/// The three curves are compared on about so many points, spread evenly, or …
const ENOUGH_POINTS: usize = 180;
/// … so many for each fold: neighbours that are closer tell nearly the same, and the work grows with their number.
const ENOUGH_A_FOLD: usize = 20;

/// One curve in the comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    /// Fold count; `None` of a circle and of a free outline.
    pub folds: Option<u32>,
    /// Harmonics of the tangent angle; `None` of the paper's curve.
    pub harmonics: Option<usize>,
    pub unknowns: usize,
    /// m².
    pub sum_of_squares: f64,
    /// Root mean square distance, m.
    pub rms: f64,
    /// Akaike's criterion, corrected for few points.
    pub aicc: f64,
}

impl Model {
    fn new(folds: Option<u32>, harmonics: Option<usize>, unknowns: usize, sum_of_squares: f64, n: usize) -> Self {
        let rms = (sum_of_squares / n as f64).sqrt();
        Model { folds, harmonics, unknowns, sum_of_squares, rms, aicc: aicc(sum_of_squares, n, unknowns) }
    }
}

/// Three curves through one outline, and its folds.
#[derive(Debug, Clone)]
pub struct Irregular {
    /// Points on which they were compared.
    pub points: usize,
    pub paper: Model,
    /// Equal folds of any shape, or why there are none.
    pub tangent: Result<(Model, TangentFit), String>,
    /// The free outline, or why there is none.
    pub free: Result<(Model, FreeOutline), String>,
    /// The test of the paper's curve against the free outline, or why there is none.
    pub lack_of_fit: Result<LackOfFit, String>,
    /// Of the free outline; empty where there is none.
    pub table: FoldTable,
}

impl Irregular {
    /// (Name, model) of those that exist: paper, tangent, free.
    pub fn models(&self) -> Vec<(&'static str, Model)> {
        let tangent = self.tangent.as_ref().ok().map(|(model, _)| ("tangent_angle", *model));
        let free = self.free.as_ref().ok().map(|(model, _)| ("free_outline", *model));
        [Some(("paper", self.paper)), tangent, free].into_iter().flatten().collect()
    }

    /// The least AICc of the three.
    pub fn best(&self) -> f64 {
        self.models().iter().map(|(_, model)| model.aicc).fold(f64::INFINITY, f64::min)
    }
}

/// Fits the other two curves to an outline whose paper's curve is known, and compares.
pub fn irregular(profile: &DrapeProfile, fit: &HemFit) -> Irregular {
    let outline = smooth(profile);
    let enough = ENOUGH_POINTS.max(ENOUGH_A_FOLD * fit.folds.unwrap_or(0) as usize);
    let stride = ((profile.points().len() as f64 / enough as f64).round() as usize).max(1);
    let points: Vec<Point> = profile.points().iter().copied().step_by(stride).collect();
    let n = points.len();
    let (left, feet) = paper(&points, fit, stride);
    let paper = Model::new(fit.folds, None, left.unknowns, left.sum_of_squares, n);
    let tangent = tangent_family(&points, &outline, fit, &feet)
        .map(|t| (Model::new(Some(t.folds), Some(t.coefficients.len()), t.unknowns, t.sum_of_squares, n), t))
        .map_err(|e| e.to_string());
    let holds = order_that_holds(&fit.hem, paper.rms, n);
    let free = free_outline(&points, &outline, holds, paper.sum_of_squares).map_err(|e| e.to_string()).and_then(|f| match f.broken {
        Some(rule) => Err(format!("the free outline breaks the rule of {}", format!("{rule:?}").to_lowercase())),
        None => Ok((Model::new(None, Some(f.order), f.unknowns, f.sum_of_squares, n), f)),
    });
    let lack_of_fit = match &free {
        Err(reason) => Err(reason.clone()),
        Ok((_, free)) if !free.comparable => Err(format!(
            "{n} points are too few: the free outline that holds this curve has {holds} harmonics and needs {} points",
            4 * holds
        )),
        Ok((_, free)) => {
            let saturated = Left { sum_of_squares: free.sum_of_squares, unknowns: free.unknowns };
            lack_of_fit(left, saturated, &free.distances, free.order).ok_or_else(|| "no degree of freedom is left".to_string())
        }
    };
    let none = FoldTable { folds: vec![], depth_variation: None, width_variation: None };
    let table = free.as_ref().map_or(none, |(_, free)| fold_table(free, &fold_table::Options::default()));
    // A campaign keeps many of them.
    let tangent = tangent.map(|(model, fit)| (model, TangentFit { placed: fit.placed.slim(), ..fit }));
    let free = free.map(|(model, mut fit)| {
        fit.placed = fit.placed.slim();
        (model, fit)
    });
    Irregular { points: n, paper, tangent, free, lack_of_fit, table }
}

/// What the paper's curve leaves on these points, and their feet; fitted anew, as it was, where they are not all.
fn paper(points: &[Point], fit: &HemFit, stride: usize) -> (Left, Vec<f64>) {
    let feet: Vec<f64> = fit.feet.iter().copied().step_by(stride).collect();
    let square = |distances: &mut dyn Iterator<Item = &f64>| distances.map(|d| d * d).sum::<f64>();
    let as_it_is = square(&mut fit.distances.iter().step_by(stride));
    let in_order = matches!(fit.termination, crate::fit::Termination::InOrder { .. });
    let unknowns = match (fit.folds, &fit.held) {
        (None, _) => 3,
        (_, Some(_)) => 5,
        _ if in_order => 5,
        _ => 6,
    };
    let sum_of_squares = match fit.folds {
        _ if stride == 1 || in_order => as_it_is,
        None => circle::fit(points).sum_of_squares,
        Some(_) => {
            let length = fit.held.map(|h| h.length);
            let again =
                orthogonal::fit(points, fit.hem, fit.placement, feet.clone(), length, f64::INFINITY, &least_squares::Options::default());
            again.map_or(as_it_is, |f| f.summary.sum_of_squares.min(as_it_is))
        }
    };
    (Left { sum_of_squares, unknowns }, feet)
}
