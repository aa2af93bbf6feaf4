//! Beyond the coefficients of a response: what its residuals say, what the design could have seen, where to go next, and theory beside it.

use serde::Serialize;

use crate::error::Error;
use crate::statistics::box_cox::{BoxCox, box_cox};
use crate::statistics::box_wilson::{Analysis, ErrorSource, Options};
use crate::statistics::effects::{EffectComparison, compare};
use crate::statistics::factorial::FactorialDesign;
use crate::statistics::known_errors::{self, KnownErrorRegression};
use crate::statistics::next_runs::{Suggestion, next_runs};
use crate::statistics::permutation::PermutationTest;
use crate::statistics::power::smallest_coefficient;
use crate::statistics::residuals::{Diagnostics, diagnose, without_suspects};
use crate::statistics::steepest_ascent::{self, Goal, Path, steepest_ascent};

/// The chance that names an effect as one that a design finds; 90 % is the custom of sample-size planning.
pub const WANTED_POWER: f64 = 0.9;

/// Replicates to plan for: as many as anyone runs, and always those that were.
const PLANNED: std::ops::RangeInclusive<usize> = 2..=10;

/// The smallest effect that so many replicates find with a chance of [`WANTED_POWER`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Detectable {
    /// Runs of each corner.
    pub replicates: usize,
    /// Change of the response from the low to the high level, in its unit.
    pub smallest_effect: f64,
    /// Whether this is what was done.
    pub done: bool,
}

/// A path of steepest ascent or descent, or why there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    pub goal: Goal,
    pub path: Result<Path, String>,
}

/// All that goes beyond the analysis of one response.
#[derive(Debug, Clone, PartialEq)]
pub struct Further {
    pub diagnostics: Diagnostics,
    /// The analysis without the suspects of `diagnostics`, where there are any.
    pub without_suspects: Option<Analysis>,
    /// By term; the constant and aliased terms have none.
    pub permutation: Vec<PermutationTest>,
    /// `None` where a power makes no sense or is not determined.
    pub box_cox: Option<BoxCox>,
    /// Ascending in replicates; empty where replicates say nothing about the error.
    pub detectable: Vec<Detectable>,
    /// Up and down.
    pub ways: [Way; 2],
    pub next_runs: Vec<Suggestion>,
    /// Weighed by the standard errors that the fits give this response; `None` where they give none.
    pub weighted: Option<KnownErrorRegression>,
    /// Term by term: has the theory the right effects, in sign and size? Or why that cannot be said.
    pub theory: Result<Vec<EffectComparison>, String>,
}

/// What a response has to offer: a number for each run, measured, its own standard error, and predicted.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    pub measured: Vec<Option<f64>>,
    pub standard_errors: Vec<Option<f64>>,
    /// `Err` says why the theory has no such response.
    pub predicted: Result<Vec<Option<f64>>, String>,
}

impl Series {
    fn compare(&self, design: &FactorialDesign, options: &Options) -> Result<Vec<EffectComparison>, String> {
        let predicted = self.predicted.as_ref().map_err(String::clone)?;
        if !self.measured.iter().zip(predicted).any(|(m, p)| m.is_some() && p.is_some()) {
            return Err("no run is both measured and predicted".into());
        }
        compare(design, &self.measured, predicted, options).map_err(|e| e.to_string())
    }
}

/// Looks further at a response that was analysed, with its permutation tests.
///
/// # Errors
/// None that the analysis would not have had.
pub fn further(
    design: &FactorialDesign,
    series: &Series,
    analysis: &Analysis,
    permutation: Vec<PermutationTest>,
    options: &Options,
) -> Result<Further, Error> {
    let response = &series.measured;
    let way = |goal| -> Result<Way, Error> {
        let ascent = steepest_ascent::Options { goal, alpha: options.alpha, ..Default::default() };
        match steepest_ascent(design, response, analysis, &ascent) {
            Ok(path) => Ok(Way { goal, path: Ok(as_far_as_possible(design, path)) }),
            Err(Error::Unanswerable(why)) => Ok(Way { goal, path: Err(why) }),
            Err(error) => Err(error),
        }
    };
    let up = steepest_ascent::Options { alpha: options.alpha, ..Default::default() };
    Ok(Further {
        diagnostics: diagnose(design, analysis, options.alpha)?,
        without_suspects: without_suspects(design, response, analysis, options)?,
        permutation,
        box_cox: if response.iter().flatten().all(|y| 0.0 < *y) { box_cox(design, response, options.alpha)? } else { None },
        detectable: detectable(design, analysis, options.alpha),
        ways: [way(Goal::Increase)?, way(Goal::Decrease)?],
        next_runs: possible_runs(design, next_runs(design, response, analysis, &up)?),
        weighted: weighted(design, series, options.alpha)?,
        theory: series.compare(design, options),
    })
}

/// Whether no factor that is positive at both levels has to be 0 or less: rigidities, densities and radii end there.
fn possible(design: &FactorialDesign, natural: &[f64]) -> bool {
    design.factors().iter().zip(natural).all(|(axis, x)| axis.low <= 0.0 || 0.0 < *x)
}

fn as_far_as_possible(design: &FactorialDesign, mut path: Path) -> Path {
    let end = path.steps.iter().position(|step| !possible(design, &step.natural)).unwrap_or(path.steps.len());
    if end < path.steps.len() {
        path.steps.truncate(end);
        path.notes.push("The path ends where a factor would have to be 0 or less.".into());
    }
    path
}

fn possible_runs(design: &FactorialDesign, suggestions: Vec<Suggestion>) -> Vec<Suggestion> {
    let keep = |mut suggestion: Suggestion| {
        let kept: Vec<usize> = (0..suggestion.natural.len()).filter(|&i| possible(design, &suggestion.natural[i])).collect();
        suggestion.coded = kept.iter().map(|&i| suggestion.coded[i].clone()).collect();
        suggestion.natural = kept.iter().map(|&i| suggestion.natural[i].clone()).collect();
        (!kept.is_empty()).then_some(suggestion)
    };
    suggestions.into_iter().filter_map(keep).collect()
}

fn detectable(design: &FactorialDesign, analysis: &Analysis, alpha: f64) -> Vec<Detectable> {
    let Some(error) = analysis.error.filter(|error| error.source == ErrorSource::PureError) else { return Vec::new() };
    let corners = 1_usize << design.factors().len();
    let done: Vec<usize> = analysis.cells.iter().map(|cell| cell.runs.len()).collect();
    let balanced = done.first().copied().filter(|n| done.len() == corners && done.iter().all(|other| other == n));
    let mut planned: Vec<usize> = PLANNED.collect();
    planned.extend(balanced.filter(|n| *n > *PLANNED.end()));
    let effect = |replicates| smallest_coefficient(error.variance, corners, replicates, alpha, WANTED_POWER).ok().map(|b| 2.0 * b);
    let one = |replicates: usize| Some(Detectable { replicates, smallest_effect: effect(replicates)?, done: Some(replicates) == balanced });
    planned.into_iter().filter_map(one).collect()
}

/// On the runs that have both a response and a positive standard error of it.
fn weighted(design: &FactorialDesign, series: &Series, alpha: f64) -> Result<Option<KnownErrorRegression>, Error> {
    let known =
        |run: usize| Some((series.measured[run]?, series.standard_errors.get(run).copied()?.filter(|e| 0.0 < *e && e.is_finite())?));
    let used: Vec<usize> = (0..series.measured.len()).filter(|&run| known(run).is_some()).collect();
    if used.is_empty() {
        return Ok(None);
    }
    let (response, errors): (Vec<f64>, Vec<f64>) = used.iter().filter_map(|&run| known(run)).unzip();
    let design = design.subset(&used);
    let regressors = design.regressors_of(&design.term_factors(), design.has_centre())?;
    known_errors::regress(&regressors, &response, &errors, alpha).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::box_wilson::analyse;
    use crate::statistics::effects::Agreement;
    use crate::statistics::factorial::Axis;
    use crate::statistics::permutation::permutation_tests;

    fn looked_at(replicates: usize, predicted: Result<Vec<Option<f64>>, String>) -> Further {
        looked_at_between(Axis::coded("a"), replicates, predicted)
    }

    fn looked_at_between(a: Axis, replicates: usize, predicted: Result<Vec<Option<f64>>, String>) -> Further {
        let levels = (0..4 * replicates).map(|run| vec![[-1.0, 1.0][run & 1], [-1.0, 1.0][run >> 1 & 1]]).collect();
        let design = FactorialDesign::new(vec![a, Axis::coded("b")], levels).unwrap();
        let scatter = |i: usize| [0.1, -0.1, 0.05, -0.05, -0.1, 0.1, -0.05, 0.05][i % 8];
        let measured: Vec<Option<f64>> = design.levels().iter().enumerate().map(|(i, x)| Some(5.0 + x[0] + scatter(i))).collect();
        let analysis = analyse(&design, &measured, &Options::default()).unwrap();
        let series = Series { standard_errors: vec![Some(0.2); measured.len()], measured, predicted };
        let permutation = permutation_tests(&design, &series.measured, &Default::default()).unwrap();
        further(&design, &series, &analysis, permutation, &Options::default()).unwrap()
    }

    #[test]
    fn what_the_design_could_see_falls_with_the_replicates_and_says_which_were_done() {
        let seen = looked_at(4, Err("no cloth".into())).detectable;
        assert_eq!(seen.iter().map(|d| d.replicates).collect::<Vec<_>>(), (2..=10).collect::<Vec<_>>());
        assert!(seen.windows(2).all(|pair| pair[1].smallest_effect < pair[0].smallest_effect));
        assert_eq!(seen.iter().filter(|d| d.done).map(|d| d.replicates).collect::<Vec<_>>(), [4]);
        // More than anyone plans for are listed all the same, if they were run.
        assert_eq!(looked_at(12, Err("no cloth".into())).detectable.last().map(|d| (d.replicates, d.done)), Some((12, true)));
    }

    #[test]
    fn the_two_ways_go_in_opposite_directions() {
        let [up, down] = looked_at(2, Err("no cloth".into())).ways;
        let end = |way: &Way| way.path.as_ref().unwrap().steps.last().unwrap().coded[0];
        assert!(0.0 < end(&up) && end(&down) == -end(&up));
    }

    #[test]
    fn a_quantity_that_is_positive_stays_so() {
        let rigidity = Axis { name: "a".into(), low: 5.0, high: 20.0 };
        let found = looked_at_between(rigidity, 2, Err("no cloth".into()));
        let [up, down] = found.ways.each_ref().map(|way| way.path.as_ref().unwrap());
        // From the centre 12.5 down by 1.875 a step: six steps leave 1.25, the seventh would be negative.
        assert_eq!((up.steps.len(), down.steps.len(), down.steps[6].natural[0]), (13, 7, 1.25));
        assert!(down.notes.iter().any(|note| note.contains("0 or less")));
        assert!(found.next_runs.iter().flat_map(|s| &s.natural).all(|x| 0.0 < x[0]));
    }

    #[test]
    fn own_errors_larger_than_the_scatter_leave_none_between_runs() {
        let found = looked_at(2, Err("no cloth".into())).weighted.unwrap();
        // Eight runs of standard error 0.2.
        assert!(found.between_runs == 0.0 && (found.coefficients[0].se - 0.2 / 8f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn theory_is_laid_beside_each_effect_or_its_absence_explained() {
        let twice = (0..8).map(|run| Some(5.0 + 2.0 * [-1.0, 1.0][run & 1])).collect();
        let compared = looked_at(2, Ok(twice)).theory.unwrap();
        assert_eq!((compared[1].term.as_str(), compared[1].agreement), ("a", Agreement::WrongSize));
        assert_eq!(looked_at(2, Err("no cloth".into())).theory, Err("no cloth".into()));
        assert!(looked_at(2, Ok(vec![None; 8])).theory.unwrap_err().contains("no run"));
    }
}
