//! Tables: three curves through every outline, and the folds of every outline one by one.

use super::csv::{Cell, Table};
use crate::fit::Estimate;
use crate::fit::fold_table::DEGREES;
use crate::study::irregular::{Irregular, Model};
use crate::units::MILLIMETRE;

/// Most coefficients a tangent angle has.
const COEFFICIENTS: usize = 8;

/// One outline's name and what is known of its folds.
pub type Row<'a> = (&'a str, &'a Irregular);

/// `models.csv`: one line per outline and curve.
pub fn models<'a>(rows: impl IntoIterator<Item = Row<'a>>) -> Table {
    let mut columns: Vec<String> = [
        "run",
        "model",
        "missing",
        "m",
        "harmonics",
        "unknowns",
        "n_points",
        "sum_of_squares_mm2",
        "rms_mm",
        "aicc",
        "delta_aicc",
        "lack_sum_of_squares_mm2",
        "lack_df",
        "error_sum_of_squares_mm2",
        "error_df",
        "lack_f",
        "lack_p",
        "error_correlation",
        "lack_inflation",
        "lack_p_correlated",
        "lack_missing",
        "length_mm",
        "length_se_mm",
    ]
    .map(String::from)
    .to_vec();
    columns.extend((1..=COEFFICIENTS).flat_map(|k| [format!("a_{k}_rad"), format!("a_{k}_se_rad")]));
    let mut table = Table { columns, rows: vec![] };
    for (run, irregular) in rows {
        let best = irregular.best();
        let known = |model: &Model| model_cells(model, irregular.points, best);
        let mut line = |name: &str, model: Result<&Model, &String>, rest: Vec<Cell>| {
            let mut cells: Vec<Cell> = vec![run.into(), name.into()];
            match model {
                Ok(model) => {
                    cells.push(Cell::Empty);
                    cells.extend(known(model));
                }
                Err(reason) => {
                    cells.push(reason.as_str().into());
                    cells.resize(11, Cell::Empty);
                }
            }
            cells.extend(rest);
            cells.resize(table.columns.len(), Cell::Empty);
            table.push(cells);
        };
        let square = MILLIMETRE * MILLIMETRE;
        let test = match &irregular.lack_of_fit {
            Ok(test) => vec![
                (test.lack_sum_of_squares / square).into(),
                test.lack_df.into(),
                (test.error_sum_of_squares / square).into(),
                test.error_df.into(),
                test.f.into(),
                test.p.into(),
                test.correlation.into(),
                test.inflation.into(),
                test.p_correlated.into(),
            ],
            Err(reason) => [vec![Cell::Empty; 9], vec![reason.as_str().into()]].concat(),
        };
        line("paper", Ok(&irregular.paper), test);
        let tangent = irregular.tangent.as_ref();
        let shape = tangent.map_or(vec![], |(_, fit)| {
            let mut cells = vec![Cell::Empty; 10];
            cells.extend(both(&fit.radius, std::f64::consts::TAU / MILLIMETRE));
            cells.extend(fit.coefficients.iter().flat_map(|a| both(a, 1.0)));
            cells
        });
        line("tangent_angle", tangent.map(|(model, _)| model), shape);
        let free = irregular.free.as_ref();
        let length = free.map_or(vec![], |(_, fit)| {
            let mut cells = vec![Cell::Empty; 10];
            cells.push((std::f64::consts::TAU * fit.placed.radius / MILLIMETRE).into());
            cells
        });
        line("free_outline", free.map(|(model, _)| model), length);
    }
    table
}

fn model_cells(model: &Model, n: usize, best: f64) -> [Cell; 8] {
    let criterion = |v: f64| Cell::from(Some(v).filter(|v| v.is_finite()));
    [
        model.folds.into(),
        model.harmonics.into(),
        model.unknowns.into(),
        n.into(),
        (model.sum_of_squares / (MILLIMETRE * MILLIMETRE)).into(),
        (model.rms / MILLIMETRE).into(),
        criterion(model.aicc),
        criterion(model.aicc - best),
    ]
}

/// Value and standard error, `factor` to the unit of the column.
fn both(estimate: &Estimate, factor: f64) -> [Cell; 2] {
    [(factor * estimate.value).into(), estimate.standard_error.map(|se| factor * se).into()]
}

/// `folds.csv`: one line per fold, in order round each outline.
pub fn folds<'a>(rows: impl IntoIterator<Item = Row<'a>>) -> Table {
    let mut table = Table::new(&[
        "run",
        "fold",
        "angle_deg",
        "angle_se_deg",
        "place_share",
        "place_se_share",
        "crest_radius_mm",
        "crest_radius_se_mm",
        "depth_mm",
        "depth_se_mm",
        "width_share",
        "width_se_share",
        "width_deg",
        "width_se_deg",
        "overhang_mm",
        "overhang_se_mm",
        "overhang_deg",
        "overhang_se_deg",
    ]);
    for (run, irregular) in rows {
        for (i, fold) in irregular.table.folds.iter().enumerate() {
            let mut cells: Vec<Cell> = vec![run.into(), (i + 1).into()];
            cells.extend(both(&fold.angle, DEGREES));
            cells.extend(both(&fold.place, 1.0));
            cells.extend(both(&fold.radius, 1.0 / MILLIMETRE));
            cells.extend(both(&fold.depth, 1.0 / MILLIMETRE));
            cells.extend(both(&fold.width, 1.0));
            cells.extend(both(&fold.width_angle, DEGREES));
            cells.extend(both(&fold.overhang, 1.0 / MILLIMETRE));
            cells.extend(both(&fold.overhang_angle, DEGREES));
            table.push(cells);
        }
    }
    table
}
