//! Work and precision of bootstrap intervals: replicates against the error of their ends.

use super::apart::Apart;
use super::fit::ordinary;
use super::{Panel, Row, Setup};
use crate::error::Error;
use crate::experiment::DrapeProfile;
use crate::experiment::campaign::Folds;
use crate::fit::intervals::{Intervals, Kind};
use crate::fit::{Options, fit};
use crate::study::drawn::HEM;
use crate::study::intervals::{self, intervals};

/// Ends of the intervals of p, q and s, m.
fn ends(found: &Intervals) -> Option<Vec<f64>> {
    let mut ends = Vec::with_capacity(6);
    for interval in [found.p?, found.q?, found.s?] {
        ends.extend([interval.low.value()?, interval.high.value()?]);
    }
    Some(ends)
}

/// Ends by 16 … 3200 replicates; the errors of a few seeds together.
pub(super) fn replicates(setup: &Setup<'_>) -> Result<Panel, Error> {
    let n = 90;
    let profile = DrapeProfile::new(&ordinary(setup.options.seed, n))?;
    let fitted = fit(&profile, &Options { folds: Folds::Exactly(HEM.folds), ..Options::default() })?;
    // A quantile of so many draws is a hundredth as uncertain as one of a few.
    let most = setup.pick(2_000, 40_000, 400_000);
    let usual = intervals::Options::default();
    let counts: Vec<usize> = setup.pick(
        vec![16, 100, 400],
        vec![16, 50, 100, 200, 400, 1000, 2000, 4000],
        vec![16, 50, 100, 200, 400, 1000, 2000, 4000, 10_000, 40_000],
    );
    let mut rows = Vec::new();
    for (kind, method) in [(Kind::Bootstrap, "residual bootstrap"), (Kind::CaseBootstrap, "case bootstrap")] {
        let ask = |replicates: usize, seed: u64| intervals(&profile, &fitted, &intervals::Options { kind, replicates, seed, ..usual });
        let exact = ends(&ask(most, setup.options.seed.wrapping_add(77)))
            .ok_or_else(|| Error::Unanswerable("the reference of the bootstrap sweep has no intervals".into()))?;
        for &replicates in &counts {
            let seeds = setup.pick(2, 6, 20);
            let (found, seconds) = setup.time(|| ask(replicates, setup.options.seed.wrapping_add(100)));
            let failed = found.replicates.as_ref().map_or(0, |r| r.failed);
            let all: Vec<Intervals> =
                std::iter::once(found).chain((1..seeds).map(|k| ask(replicates, setup.options.seed.wrapping_add(100 + k)))).collect();
            let ends: Option<Vec<Vec<f64>>> = all.iter().map(ends).collect();
            let termination =
                if ends.is_none() { "refused: too few replicates for a quantile".into() } else { format!("{failed} replicates failed") };
            let error = ends.and_then(|all| Apart::of(all.iter().flat_map(|e| e.iter().zip(&exact).map(|(a, b)| a - b))));
            rows.push(Row {
                method: method.into(),
                knob: "replicates",
                setting: replicates as f64,
                asked: None,
                error,
                seconds,
                evaluations: Some(replicates),
                termination,
                claims: error.is_some(),
                default: kind == Kind::Bootstrap && replicates == usual.replicates,
            });
        }
    }
    // The cheap interval that needs none.
    Ok(Panel {
        name: "bootstrap",
        title: "Bootstrap: ends of the intervals of p, q, s",
        reference: format!("the same with {most} replicates of another seed"),
        unit: "replicates",
        rows,
    })
}
