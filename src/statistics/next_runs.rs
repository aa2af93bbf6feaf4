//! Which runs would teach most next, and why.

use serde::Serialize;

use crate::error::Error;
use crate::statistics::box_wilson::{Analysis, ErrorSource};
use crate::statistics::factorial::FactorialDesign;
use crate::statistics::residuals::suspects;
use crate::statistics::steepest_ascent::{self, steepest_ascent};

/// Runs that answer one open question.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Suggestion {
    /// What is open, and what these runs decide.
    pub reason: String,
    /// Coded levels, one row per run.
    pub coded: Vec<Vec<f64>>,
    /// The same in natural units.
    pub natural: Vec<Vec<f64>>,
}

/// Suggestions in the order of urgency: repair the design first, then test it, then refine or leave it. Empty if nothing is open.
///
/// Source of the order: Box, Hunter & Hunter, Statistics for Experimenters (2nd ed., 2005), chapters 11–12.
///
/// # Errors
/// Those of [`steepest_ascent`] that are not about the response having no direction.
pub fn next_runs(
    design: &FactorialDesign,
    response: &[Option<f64>],
    analysis: &Analysis,
    ascent: &steepest_ascent::Options,
) -> Result<Vec<Suggestion>, Error> {
    let k = design.factors().len();
    let corners: Vec<Vec<f64>> =
        (0..1_usize << k).map(|mask| (0..k).map(|i| if mask >> i & 1 == 1 { 1.0 } else { -1.0 }).collect()).collect();
    let done = |levels: &Vec<f64>| analysis.cells.iter().find(|cell| cell.levels == *levels).map_or(0, |cell| cell.runs.len());
    let most = corners.iter().map(done).max().unwrap_or(0);
    let mut suggestions = Vec::new();
    let mut suggest = |reason: String, coded: Vec<Vec<f64>>| {
        if !coded.is_empty() {
            let axes = design.factors();
            let natural =
                coded.iter().map(|row| row.iter().zip(axes).map(|(x, axis)| axis.centre() + x * axis.interval()).collect()).collect();
            suggestions.push(Suggestion { reason, coded, natural });
        }
    };
    let doubtful = suspects(analysis, 0.05);
    suggest(
        "These treatments hold a run that the others do not expect: repeat it before believing or dropping it.".into(),
        doubtful.iter().map(|suspect| design.levels()[suspect.run].clone()).collect(),
    );
    let missing: Vec<Vec<f64>> = corners.iter().filter(|levels| done(levels) == 0).cloned().collect();
    if !missing.is_empty() {
        let aliased: Vec<&str> = analysis.aliases.iter().map(|alias| alias.term.as_str()).collect();
        let confused =
            if aliased.is_empty() { String::new() } else { format!("; they would separate {} from the other terms", aliased.join(", ")) };
        suggest(format!("These corners of the design have no run{confused}."), missing);
    }
    let uneven: Vec<Vec<f64>> = corners
        .iter()
        .filter(|levels| done(levels) > 0)
        .flat_map(|levels| std::iter::repeat_n(levels.clone(), most - done(levels)))
        .collect();
    suggest(
        "These runs make the design balanced: coefficients independent of each other and of equal error, Cochran's test exact.".into(),
        uneven,
    );
    let measured = analysis.error.is_some_and(|error| error.source == ErrorSource::PureError);
    if !measured && analysis.full.residual_df == 0 {
        suggest("No treatment was repeated: a second run of each gives an error to test against.".into(), corners.clone());
    }
    let centred = design.has_centre();
    let inadequate = analysis.adequacy.as_ref().is_some_and(|verdict| !verdict.holds);
    let curved = analysis.curvature.as_ref().is_some_and(|c| c.significant);
    if !centred {
        // Four centre runs: their mean is about as precise as that of the corners of a 2³ at n = 1, and they replicate.
        suggest("No run at the centre: four there test whether the response is curved between the levels.".into(), vec![vec![0.0; k]; 4]);
    }
    if curved || (inadequate && centred) {
        // Rotatable: axial distance (2^k)^¼.
        let distance = ((1_usize << k) as f64).powf(0.25);
        let axial = (0..k).flat_map(|i| [-distance, distance].map(|x| (0..k).map(|j| if i == j { x } else { 0.0 }).collect())).collect();
        suggest("The response is curved: these axial runs complete a rotatable second-order design.".into(), axial);
    } else if let Ok(path) = steepest_ascent(design, response, analysis, ascent) {
        let beyond: Vec<Vec<f64>> = path.steps.iter().filter(|step| !step.explored).take(3).map(|step| step.coded.clone()).collect();
        let wish = if ascent.goal == steepest_ascent::Goal::Increase { "larger" } else { "smaller" };
        suggest(format!("The first steps beyond the explored region along the steepest path, towards a {wish} response."), beyond);
    }
    Ok(suggestions)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::box_wilson::{Options, analyse};
    use crate::statistics::factorial::Axis;

    fn suggestions(levels: Vec<Vec<f64>>, y: impl Fn(usize, &[f64]) -> f64) -> Vec<Suggestion> {
        let axes = vec![Axis { name: "a".into(), low: 10.0, high: 20.0 }, Axis::coded("b")];
        let design = FactorialDesign::new(axes, levels).unwrap();
        let y: Vec<Option<f64>> = design.levels().iter().enumerate().map(|(i, x)| Some(y(i, x))).collect();
        let analysis = analyse(&design, &y, &Options::default()).unwrap();
        next_runs(&design, &y, &analysis, &steepest_ascent::Options::default()).unwrap()
    }

    fn square(replicates: usize) -> Vec<Vec<f64>> {
        (0..4 * replicates).map(|run| vec![[-1.0, 1.0][run & 1], [-1.0, 1.0][run >> 1 & 1]]).collect()
    }

    #[test]
    fn a_missing_corner_comes_first_and_in_natural_units() {
        let levels = square(2).into_iter().filter(|x| *x != [1.0, 1.0]).collect();
        let found = suggestions(levels, |i, x| 5.0 + x[0] + [0.1, -0.1, 0.05, 0.0, -0.03, 0.02][i]);
        assert_eq!((&found[0].coded, &found[0].natural), (&vec![vec![1.0, 1.0]], &vec![vec![20.0, 1.0]]));
        assert!(found[0].reason.contains("a:b"));
    }

    #[test]
    fn curvature_asks_for_axial_runs_and_a_slope_for_steps_beyond() {
        let mut levels = square(2);
        levels.extend(vec![vec![0.0, 0.0]; 3]);
        let scatter = |i: usize| [0.1, -0.1, 0.05, 0.0, -0.05, 0.02, 0.1, -0.12, 0.03, 0.0, -0.04][i];
        let curved = suggestions(levels.clone(), |i, x| 5.0 - 3.0 * x[0] * x[0] + scatter(i));
        assert!(curved.iter().any(|s| s.reason.contains("axial") && s.coded.len() == 4 && (s.coded[1][0] - 2f64.sqrt()).abs() < 1e-15));
        let sloped = suggestions(levels, |i, x| 5.0 + 3.0 * x[0] + scatter(i));
        let path = sloped.iter().find(|s| s.reason.contains("steepest")).unwrap();
        assert!(path.coded.iter().all(|x| x[0] > 1.0));
    }
}
