//! Where to go next: steps along the gradient of the fitted response, each with what to expect there.

use serde::Serialize;

use crate::error::Error;
use crate::statistics::box_wilson::Analysis;
use crate::statistics::distribution::student_critical;
use crate::statistics::factorial::FactorialDesign;

/// Which way is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Goal {
    Increase,
    Decrease,
}

/// How to walk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    pub goal: Goal,
    /// Step of the factor that moves most, in its own interval of variation.
    pub step: f64,
    pub steps: usize,
    /// Intervals cover 1 − alpha.
    pub alpha: f64,
}

impl Default for Options {
    /// Quarter intervals, as far as three intervals from the centre: the linear model is not worth more.
    fn default() -> Self {
        Options { goal: Goal::Increase, step: 0.25, steps: 12, alpha: 0.05 }
    }
}

/// One point of the path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Step {
    /// 0 = the centre of the design.
    pub number: usize,
    pub coded: Vec<f64>,
    pub natural: Vec<f64>,
    pub predicted: f64,
    /// Of the mean response there; `None` without an error estimate.
    pub ci: Option<(f64, f64)>,
    /// Of a single run there.
    pub prediction: Option<(f64, f64)>,
    /// All coded levels within ±1: the model was fitted here.
    pub explored: bool,
}

/// The path and where it leaves what is known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Path {
    pub steps: Vec<Step>,
    /// Change per step in natural units: proportional to b·J, J the interval of variation.
    pub natural_change: Vec<f64>,
    /// Number of steps (with fraction) after which the first factor leaves ±1.
    pub leaves_after: f64,
    pub notes: Vec<String>,
}

/// Walks from the centre along the significant main effects; the others stay at the centre.
///
/// The response is predicted by the main effects that move and all significant terms, with intervals from the error variance of the analysis;
/// a significant interaction bends the true path, and that is said.
///
/// Source: Box & Wilson, J. R. Statist. Soc. B 13 (1951) 1–45, section 3.
///
/// # Errors
/// [`Error::Unanswerable`] if no main effect is significant; [`Error::Invalid`] for a step that is not positive.
pub fn steepest_ascent(design: &FactorialDesign, response: &[Option<f64>], analysis: &Analysis, options: &Options) -> Result<Path, Error> {
    if !(options.step.is_finite() && options.step > 0.0) {
        return Err(Error::Invalid { quantity: "step of the ascent", value: options.step, allowed: "> 0" });
    }
    if !(options.alpha > 0.0 && options.alpha < 1.0) {
        return Err(Error::Invalid { quantity: "significance level", value: options.alpha, allowed: "> 0 and < 1" });
    }
    let axes = design.factors();
    let sign = if options.goal == Goal::Increase { 1.0 } else { -1.0 };
    let slope = |name: &str| analysis.coefficients.iter().find(|c| c.term == name && c.significant).map_or(0.0, |c| sign * c.estimate);
    let slopes: Vec<f64> = axes.iter().map(|axis| slope(&axis.name)).collect();
    let steepest = slopes.iter().fold(0.0, |most: f64, b| most.max(b.abs()));
    if steepest == 0.0 {
        return Err(Error::Unanswerable("no main effect is significant: the response has no direction to follow".into()));
    }
    let change: Vec<f64> = slopes.iter().map(|b| options.step * b / steepest).collect();
    let mut notes = Vec::new();
    let resting: Vec<&str> = axes.iter().zip(&slopes).filter(|(_, b)| **b == 0.0).map(|(axis, _)| axis.name.as_str()).collect();
    if !resting.is_empty() {
        notes.push(format!("No significant main effect of {}: kept at the centre.", resting.join(", ")));
    }
    let bent: Vec<&str> = analysis.coefficients.iter().filter(|c| c.significant && c.term.contains(':')).map(|c| c.term.as_str()).collect();
    if !bent.is_empty() {
        notes.push(format!(
            "Significant interactions ({}) bend the steepest path; the straight one is its tangent at the centre.",
            bent.join(", ")
        ));
    }
    if analysis.curvature.as_ref().is_some_and(|c| c.significant) {
        notes.push(
            "The centre points show curvature that this prediction does not have: an optimum may be near; plan a second-order design."
                .into(),
        );
    }

    // Constant and every significant term, refitted.
    let used = design.subset(&analysis.used_runs);
    let y: Vec<f64> = analysis.used_runs.iter().filter_map(|&run| response.get(run).copied().flatten()).collect();
    let terms: Vec<Vec<usize>> = used
        .term_factors()
        .into_iter()
        .filter(|term| term.is_empty() || analysis.coefficients.iter().any(|c| c.significant && c.term == used.term_name(term)))
        .collect();
    let curvature = used.has_centre();
    let decomposition = used.regressors_of(&terms, curvature)?.decompose();
    let model = decomposition.fit(&y)?;
    let others = decomposition.rank() - terms.len();
    let error = analysis.error.map(|error| (error.variance, student_critical(options.alpha, error.df as f64)));
    let steps = (0..=options.steps)
        .map(|number| {
            let coded: Vec<f64> = change.iter().map(|c| c * number as f64).collect();
            let mut row: Vec<f64> = terms.iter().map(|term| term.iter().map(|&i| coded[i]).product()).collect();
            // Neither centre nor any block: the corners' model over the mean of the blocks.
            row.resize(terms.len() + others, 0.0);
            let predicted = model.estimates.iter().zip(&row).map(|(estimate, x)| estimate.estimate * x).sum();
            let factor = decomposition.prediction_variance_factor(&row);
            let around = |variance: f64, critical: f64| {
                let reach = critical * variance.sqrt();
                (predicted - reach, predicted + reach)
            };
            Step {
                number,
                natural: coded.iter().zip(axes).map(|(x, axis)| axis.centre() + x * axis.interval()).collect(),
                predicted,
                ci: error.map(|(variance, critical)| around(variance * factor, critical)),
                prediction: error.map(|(variance, critical)| around(variance * (1.0 + factor), critical)),
                explored: coded.iter().all(|x| x.abs() <= 1.0 + 1e-12),
                coded,
            }
        })
        .collect();
    let natural_change = change.iter().zip(axes).map(|(c, axis)| c * axis.interval()).collect();
    Ok(Path { steps, natural_change, leaves_after: 1.0 / options.step, notes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::box_wilson::{self, analyse};
    use crate::statistics::factorial::Axis;

    fn design() -> FactorialDesign {
        let levels = (0..12).map(|run| vec![[-1.0, 1.0][run & 1], [-1.0, 1.0][run >> 1 & 1]]).collect();
        let axes = vec![Axis { name: "a".into(), low: 10.0, high: 20.0 }, Axis { name: "b".into(), low: 0.0, high: 1.0 }];
        FactorialDesign::new(axes, levels).unwrap()
    }

    fn responses(design: &FactorialDesign) -> Vec<Option<f64>> {
        design.levels().iter().enumerate().map(|(i, x)| Some(50.0 + 4.0 * x[0] - 2.0 * x[1] + [-0.3, 0.0, 0.3][i / 4])).collect()
    }

    #[test]
    fn steps_are_proportional_to_coefficient_times_interval_and_leave_where_the_steepest_factor_does() {
        let (design, options) = (design(), Options::default());
        let y = responses(&design);
        let analysis = analyse(&design, &y, &box_wilson::Options::default()).unwrap();
        let path = steepest_ascent(&design, &y, &analysis, &options).unwrap();
        // b·J: 4·5 against −2·0.5, so −0.05 of b for each 1 of a; 0.25 interval of a is 1.25.
        assert!((path.natural_change[0] - 1.25).abs() < 1e-14 && (path.natural_change[1] + 0.0625).abs() < 1e-14);
        assert_eq!(path.steps.iter().position(|step| !step.explored), Some(5));
        // 50 + 4·0.25 + 2·0.125 per step.
        assert!((path.steps[4].predicted - 55.0).abs() < 1e-12);
        // Mean of 12 runs and two slopes: variance s² (1 + 1² + ½²)/12 at step 4; s² = 8·0.09/8.
        let critical = crate::statistics::distribution::student_critical(0.05, 8.0);
        let reach = critical * (0.09 * 2.25 / 12.0_f64).sqrt();
        let (low, high) = path.steps[4].ci.unwrap();
        assert!((high - low - 2.0 * reach).abs() < 1e-12);
    }

    #[test]
    fn without_a_significant_main_effect_there_is_no_direction() {
        let design = design();
        let y: Vec<Option<f64>> = (0..12).map(|i| Some([1.0, 2.0, 0.0, 1.5, 0.2, 1.1, 2.2, 0.4, 1.9, 0.3, 1.2, 0.8][i])).collect();
        let analysis = analyse(&design, &y, &box_wilson::Options::default()).unwrap();
        assert!(matches!(steepest_ascent(&design, &y, &analysis, &Options::default()), Err(Error::Unanswerable(_))));
    }
}
