//! A campaign at a glance: counts and medians for whoever writes a summary.

use std::collections::BTreeMap;

use serde::Serialize;

use super::campaign::RunStudy;

/// The middle and the extremes of some values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    pub n: usize,
    pub low: f64,
    pub median: f64,
    pub high: f64,
}

/// Theory against measurement over all runs that have both; lengths in m.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TheoryOverview {
    pub fidelity: String,
    /// Runs whose fold count was compared.
    pub runs: usize,
    /// Of these, with the predicted fold count equal to the fitted one.
    pub folds_right: usize,
    /// Of these, within one.
    pub folds_within_one: usize,
    /// Distance of the points from the predicted hem at the fitted fold count.
    pub rms: Option<Spread>,
    /// Predicted minus fitted.
    pub depth: Option<Spread>,
    /// Predicted minus fitted.
    pub mean_radius: Option<Spread>,
}

/// Counts and medians of a campaign; lengths in m.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Overview {
    pub runs: usize,
    pub profiles: usize,
    pub fitted: usize,
    /// Runs by fitted fold count, ascending; 0 counts the round ones.
    pub folds: Vec<(u32, usize)>,
    pub rms: Option<Spread>,
    pub explained: Option<Spread>,
    /// Runs whose hem length had to be held.
    pub held: usize,
    /// `None` where nothing was predicted.
    pub theory: Option<TheoryOverview>,
}

/// Sums a campaign up.
pub fn overview(runs: &[RunStudy]) -> Overview {
    let fits: Vec<_> = runs.iter().filter_map(|r| r.fit.as_ref().ok()).collect();
    let mut folds: BTreeMap<u32, usize> = BTreeMap::new();
    for fit in &fits {
        *folds.entry(fit.folds.unwrap_or(0)).or_default() += 1;
    }
    let compared: Vec<_> = runs.iter().filter_map(|r| r.comparison.as_ref()).collect();
    let fidelity = runs.iter().find_map(|r| r.prediction.as_ref()).map(|p| p.fidelity.clone());
    let theory = fidelity.filter(|_| !compared.is_empty()).map(|fidelity| TheoryOverview {
        fidelity,
        runs: compared.len(),
        folds_right: compared.iter().filter(|c| c.folds == 0).count(),
        folds_within_one: compared.iter().filter(|c| c.folds.abs() <= 1).count(),
        rms: spread(compared.iter().map(|c| c.rms)),
        depth: spread(compared.iter().map(|c| c.depth)),
        mean_radius: spread(compared.iter().map(|c| c.mean_radius)),
    });
    Overview {
        runs: runs.len(),
        profiles: runs.iter().filter(|r| r.profile.is_some()).count(),
        fitted: fits.len(),
        folds: folds.into_iter().collect(),
        rms: spread(fits.iter().map(|f| f.rms)),
        explained: spread(fits.iter().filter(|f| f.folds.is_some()).map(|f| f.explained)),
        held: fits.iter().filter(|f| f.held.is_some()).count(),
        theory,
    }
}

/// `None` of nothing.
pub fn spread(values: impl IntoIterator<Item = f64>) -> Option<Spread> {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (*sorted.first()?, *sorted.last()?);
    let n = sorted.len();
    let median = 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
    Some(Spread { n, low, median, high })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_number_is_between_the_middle_two() {
        assert_eq!(spread([4.0, 1.0, 3.0, 2.0]), Some(Spread { n: 4, low: 1.0, median: 2.5, high: 4.0 }));
        assert_eq!(spread([]), None);
    }
}
