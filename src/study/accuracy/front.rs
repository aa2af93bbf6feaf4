//! Which rows nothing beats: the Pareto front of error against work, and how far from it the program's default lies.

use super::{Panel, Row};

/// What is paid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cost {
    Seconds,
    Evaluations,
}

impl Cost {
    pub fn of(self, row: &Row) -> Option<f64> {
        match self {
            Cost::Seconds => Some(row.seconds),
            Cost::Evaluations => row.evaluations.map(|n| n as f64),
        }
    }
}

/// Indices of the rows that no other row beats in both error and cost, cheapest first. Rows without a result or a cost are not on it.
pub fn front(panel: &Panel, cost: Cost) -> Vec<usize> {
    let mut rows: Vec<(f64, f64, usize)> = panel
        .rows
        .iter()
        .enumerate()
        .filter_map(|(i, row)| Some((cost.of(row)?, row.error?.rms, i)))
        .filter(|(cost, error, _)| cost.is_finite() && error.is_finite())
        .collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut least = f64::INFINITY;
    rows.retain(|(_, error, _)| {
        let better = *error < least;
        least = least.min(*error);
        better
    });
    rows.into_iter().map(|(_, _, i)| i).collect()
}

/// How many times as much as the cheapest row that is at least as accurate the default row costs: 1 on the front. `None` without a default row.
pub fn default_excess(panel: &Panel, cost: Cost) -> Option<f64> {
    let row = panel.rows.iter().find(|row| row.default)?;
    let (own, error) = (cost.of(row)?, row.error?.rms);
    let as_good = panel.rows.iter().filter(|other| other.error.is_some_and(|e| e.rms <= error));
    let cheapest = as_good.filter_map(|other| cost.of(other)).fold(f64::INFINITY, f64::min);
    (0.0 < cheapest && cheapest.is_finite()).then(|| own / cheapest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::accuracy::apart::Apart;

    fn row(error: f64, evaluations: usize, default: bool) -> Row {
        Row {
            method: "a".into(),
            knob: "k",
            setting: 1.0,
            asked: None,
            error: Some(Apart { rms: error, max: error }),
            seconds: evaluations as f64,
            evaluations: Some(evaluations),
            termination: "converged".into(),
            claims: true,
            default,
        }
    }

    #[test]
    fn the_front_holds_what_nothing_beats_and_the_excess_is_the_ratio_to_it() {
        let rows = vec![row(1.0, 1, false), row(0.5, 4, true), row(0.5, 2, false), row(0.7, 3, false), row(0.1, 9, false)];
        let panel = Panel { name: "p", title: "p", reference: "r".into(), unit: "u", rows };
        assert_eq!(front(&panel, Cost::Evaluations), [0, 2, 4]);
        assert_eq!(default_excess(&panel, Cost::Evaluations), Some(2.0));
    }
}
