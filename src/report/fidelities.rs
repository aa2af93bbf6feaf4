//! Tables: every fidelity of the theory against every run, and summed up per cell.

use super::csv::{Cell, Table};
use crate::study::fidelities::{FidelityRun, FidelitySummary};
use crate::units::MILLIMETRE;

/// `fidelities.csv`: one line per run and fidelity.
pub fn runs(rows: &[FidelityRun]) -> Table {
    let columns =
        ["run", "fidelity", "predicted_m", "fitted_m", "rms_mm", "depth_difference_mm", "depth_ratio", "mean_radius_difference_mm"];
    let mut table = Table::new(&columns);
    for row in rows {
        let comparison = row.comparison.as_ref();
        table.push(vec![
            row.run.as_str().into(),
            row.fidelity.into(),
            row.predicted_folds.into(),
            row.fitted_folds.into(),
            comparison.map(|c| c.rms / MILLIMETRE).into(),
            comparison.map(|c| c.depth / MILLIMETRE).into(),
            row.depth_ratio.into(),
            comparison.map(|c| c.mean_radius / MILLIMETRE).into(),
        ]);
    }
    table
}

/// `fidelity_summary.csv`: one line per fidelity and cell, all runs first; `factors` names the levels.
pub fn summary(rows: &[FidelitySummary], factors: &[&str]) -> Table {
    let mut columns = vec!["fidelity"];
    columns.extend(factors);
    columns.extend(["runs", "fold_count_exact", "fold_count_within_one", "compared", "rms_mm", "depth_ratio", "mean_radius_difference_mm"]);
    let mut table = Table::new(&columns);
    for row in rows {
        let mut cells: Vec<Cell> = vec![row.fidelity.into()];
        cells.extend((0..factors.len()).map(|i| Cell::from(row.levels.as_ref().and_then(|l| l.get(i).copied()))));
        cells.extend([
            row.runs.into(),
            row.exact.into(),
            row.within_one.into(),
            row.compared.into(),
            row.rms.map(|v| v / MILLIMETRE).into(),
            row.depth_ratio.into(),
            row.mean_radius.map(|v| v / MILLIMETRE).into(),
        ]);
        table.push(cells);
    }
    table
}
