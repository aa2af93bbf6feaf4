//! Effects to look at and to compare: means, Pareto and half-normal order, and theory beside measurement.

use serde::Serialize;

use crate::error::Error;
use crate::statistics::box_wilson::{Analysis, Coefficient, Options, analyse};
use crate::statistics::distribution::normal_critical;
use crate::statistics::factorial::FactorialDesign;
use crate::statistics::variances::mean_and_variance;

/// One bar of a Pareto chart.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParetoBar {
    pub term: String,
    /// |t| where there is an error, otherwise |b| in units of the response.
    pub height: f64,
}

/// Bars of all terms but the constant, highest first, and the reference line: critical t, or Lenth's margin where there is no error.
pub fn pareto(analysis: &Analysis) -> (Vec<ParetoBar>, Option<f64>) {
    let mut bars: Vec<ParetoBar> =
        effects(analysis).map(|c| ParetoBar { term: c.term.clone(), height: c.t.unwrap_or(c.estimate).abs() }).collect();
    bars.sort_by(|a, b| b.height.total_cmp(&a.height));
    (bars, analysis.t_critical.or(analysis.lenth.map(|lenth| lenth.margin)))
}

/// One point of a half-normal plot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HalfNormalPoint {
    pub term: String,
    /// |b|, units of the response.
    pub size: f64,
    /// Expected place of an effect of this rank if all were noise, in standard deviations.
    pub quantile: f64,
}

/// All terms but the constant, smallest first; the i-th of m stands at Φ⁻¹(½ + ½ (i − ½)/m).
///
/// Source: Daniel, Technometrics 1 (1959) 311–341.
pub fn half_normal(analysis: &Analysis) -> Vec<HalfNormalPoint> {
    let mut points: Vec<HalfNormalPoint> =
        effects(analysis).map(|c| HalfNormalPoint { term: c.term.clone(), size: c.estimate.abs(), quantile: 0.0 }).collect();
    points.sort_by(|a, b| a.size.total_cmp(&b.size));
    let count = points.len() as f64;
    for (i, point) in points.iter_mut().enumerate() {
        point.quantile = normal_critical(0.5 - 0.5 * (i as f64 + 0.5) / count);
    }
    points
}

fn effects(analysis: &Analysis) -> impl Iterator<Item = &Coefficient> {
    analysis.coefficients.iter().filter(|c| c.term != "1")
}

/// Mean of the runs at one combination of levels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LevelMean {
    /// Coded levels of the factors asked, in the order asked.
    pub levels: Vec<f64>,
    pub mean: f64,
    /// Of the mean, from the scatter within these runs; `None` for a single run.
    pub standard_error: Option<f64>,
    pub runs: usize,
}

/// Means over the combinations of the factors asked: one factor for a main effect, two for an interaction, all for a cube. Combinations
/// without a run are left out; standard order.
pub fn level_means(design: &FactorialDesign, response: &[Option<f64>], factors: &[usize]) -> Vec<LevelMean> {
    let mut groups: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    for (levels, y) in design.levels().iter().zip(response) {
        let Some(y) = *y else { continue };
        let own: Vec<f64> = factors.iter().map(|&i| levels[i]).collect();
        match groups.iter_mut().find(|(known, _)| *known == own) {
            Some((_, values)) => values.push(y),
            None => groups.push((own, vec![y])),
        }
    }
    groups.sort_by(|(a, _), (b, _)| {
        let pairs = a.iter().zip(b).rev();
        pairs.map(|(x, y)| x.total_cmp(y)).find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    });
    groups
        .into_iter()
        .map(|(levels, values)| {
            let (mean, variance) = mean_and_variance(&values);
            LevelMean { levels, mean, standard_error: variance.map(|v| (v / values.len() as f64).sqrt()), runs: values.len() }
        })
        .collect()
}

/// What theory says about one effect, beside what was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Agreement {
    /// Measured and predicted: same sign, sizes that differ by no more than chance.
    Agrees,
    /// Same sign, or no effect at all in theory, and the sizes differ by more than chance.
    WrongSize,
    /// A measured effect has the other sign in theory.
    WrongSign,
    /// Theory predicts a difference from what was measured, where no effect was measured.
    NotMeasured,
    /// No effect was measured, and theory does not differ from that by more than chance.
    BothAbsent,
    /// There is no error to judge with.
    Undecided,
}

/// One term of the comparison.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectComparison {
    pub term: String,
    pub measured: Coefficient,
    pub predicted: f64,
    /// Predicted minus measured, run by run regressed on the same terms: its test needs no assumption about the two separately.
    pub difference: Coefficient,
    pub agreement: Agreement,
}

/// The same regression on predicted and measured responses: has the theory the right effects, in sign and in size?
///
/// Only runs that have both are used. The difference is tested run by run, so scatter that theory explains does not count as error.
///
/// # Errors
/// Those of [`analyse`].
pub fn compare(
    design: &FactorialDesign,
    measured: &[Option<f64>],
    predicted: &[Option<f64>],
    options: &Options,
) -> Result<Vec<EffectComparison>, Error> {
    if measured.len() != predicted.len() {
        return Err(Error::Unanswerable(format!("{} measured and {} predicted responses", measured.len(), predicted.len())));
    }
    let both = |own: &[Option<f64>], other: &[Option<f64>]| -> Vec<Option<f64>> { own.iter().zip(other).map(|(a, b)| b.and(*a)).collect() };
    let (measured, predicted) = (both(measured, predicted), both(predicted, measured));
    let difference: Vec<Option<f64>> = predicted.iter().zip(&measured).map(|(p, m)| p.zip(*m).map(|(p, m)| p - m)).collect();
    let (of_measured, of_predicted) = (analyse(design, &measured, options)?, analyse(design, &predicted, options)?);
    let of_difference = analyse(design, &difference, options)?;
    // The three analyses have the same runs, hence the same terms in the same order.
    Ok(of_measured
        .coefficients
        .into_iter()
        .zip(of_predicted.coefficients)
        .zip(of_difference.coefficients)
        .map(|((measured, predicted), difference)| {
            let decided = measured.t.is_some() && difference.t.is_some();
            // Where theory knows no such effect, only rounding is left of it, and that has no sign.
            let none = predicted.estimate.abs() <= 1e-9 * measured.estimate.abs();
            let other_sign = !none && measured.estimate.signum() != predicted.estimate.signum();
            let agreement = match (decided, measured.significant, difference.significant) {
                (false, _, _) => Agreement::Undecided,
                (_, true, _) if other_sign => Agreement::WrongSign,
                (_, true, true) => Agreement::WrongSize,
                (_, true, false) => Agreement::Agrees,
                (_, false, true) => Agreement::NotMeasured,
                (_, false, false) => Agreement::BothAbsent,
            };
            EffectComparison { term: measured.term.clone(), predicted: predicted.estimate, measured, difference, agreement }
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::factorial::Axis;

    fn design() -> FactorialDesign {
        let levels = (0..12).map(|run| vec![[-1.0, 1.0][run & 1], [-1.0, 1.0][run >> 1 & 1]]).collect();
        FactorialDesign::new(vec![Axis::coded("a"), Axis::coded("b")], levels).unwrap()
    }

    /// Scatter that sums to 0 over the three replicates of each cell.
    fn scatter(run: usize) -> f64 {
        [-0.1, 0.0, 0.1][run / 4]
    }

    #[test]
    fn theory_is_told_right_from_wrong_term_by_term() {
        let design = design();
        let measured: Vec<Option<f64>> = design.levels().iter().enumerate().map(|(i, x)| Some(5.0 + x[0] - x[1] + scatter(i))).collect();
        let theory: Vec<Option<f64>> = design.levels().iter().map(|x| Some(5.0 + 2.0 * x[0] + x[1] + 0.5 * x[0] * x[1])).collect();
        let found: Vec<Agreement> =
            compare(&design, &measured, &theory, &Options::default()).unwrap().into_iter().map(|c| c.agreement).collect();
        assert_eq!(found, [Agreement::Agrees, Agreement::WrongSize, Agreement::WrongSign, Agreement::NotMeasured]);
    }

    #[test]
    fn level_means_are_the_means() {
        let design = design();
        let y: Vec<Option<f64>> = design.levels().iter().enumerate().map(|(i, x)| (i != 0).then_some(5.0 + x[0])).collect();
        let means = level_means(&design, &y, &[0]);
        assert_eq!(means.iter().map(|m| (m.levels[0], m.mean, m.runs)).collect::<Vec<_>>(), [(-1.0, 4.0, 5), (1.0, 6.0, 6)]);
    }

    #[test]
    fn half_normal_places_follow_the_expected_order() {
        let design = design();
        let y: Vec<Option<f64>> = design.levels().iter().enumerate().map(|(i, x)| Some(x[0] + 3.0 * x[1] + scatter(i))).collect();
        let points = half_normal(&analyse(&design, &y, &Options::default()).unwrap());
        assert_eq!(points.iter().map(|p| p.term.as_str()).collect::<Vec<_>>(), ["a:b", "a", "b"]);
        // Φ⁻¹(½ + ½·½) = 0.6744898 for the middle one of three, in any table.
        assert!((points[1].quantile - 0.674_489_8).abs() < 1e-7);
    }
}
