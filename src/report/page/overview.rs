//! The table of all runs, and by what it can be filtered.

use serde_json::{Value, json};

use super::table::{Column, of_texts};
use crate::fit::Estimate;
use crate::report::note;
use crate::report::number::{fixed, plain, significant, with_error};
use crate::study::campaign::{CampaignStudy, RunStudy};
use crate::units::{MILLIMETRE, PERCENT};

/// One row for each run, in run order; columns that no run fills are left out.
pub fn runs(study: &CampaignStudy) -> Value {
    let factors = &study.campaign.design.factors;
    let weighed = study.runs.iter().any(|r| r.lambda.first_integral.is_some());
    let mut columns = vec![Column::text("Run")];
    columns.extend(factors.iter().map(|f| Column::number(f.name.as_str(), f.unit.clone().unwrap_or_default())));
    columns.extend([
        Column::number("Rep.", ""),
        Column::number("n", ""),
        Column::number("m", ""),
        Column::number("p", "mm"),
        Column::number("q", "mm"),
        Column::number("s", "mm"),
        Column::number("rms", "mm"),
        Column::number("Depth", "mm"),
        Column::number("Expl.", "%"),
        Column::number("Drape", "coeff., %"),
        if weighed { Column::number("λ", "N/m²") } else { Column::number("λ/(ρg)", "") },
        Column::number("R²", "of λ"),
        Column::number("m", "theory"),
        Column::number("rms", "theory, mm"),
        Column::text("Ended"),
    ]);
    let rows: Vec<Vec<String>> = study.runs.iter().map(|run| row(run, study)).collect();
    let kept: Vec<usize> = (0..columns.len()).filter(|&i| rows.iter().any(|row| !row[i].is_empty())).collect();
    let columns: Vec<Column> = kept.iter().map(|&i| columns[i].clone()).collect();
    of_texts(&columns, rows.into_iter().map(|row| kept.iter().map(|&i| row[i].clone()).collect()))
}

fn row(study: &RunStudy, campaign: &CampaignStudy) -> Vec<String> {
    let fit = study.fit.as_ref().ok();
    let folded = fit.filter(|f| f.folds.is_some());
    let mm =
        |e: Option<Estimate>| e.map(|e| with_error(e.value / MILLIMETRE, e.standard_error.map(|s| s / MILLIMETRE))).unwrap_or_default();
    let some = |v: Option<f64>, decimals: usize| v.map(|v| fixed(v, decimals)).unwrap_or_default();
    let lambda = study.lambda.first_integral.or(study.lambda.over_weight);
    let mut row = vec![study.run.id.clone()];
    row.extend(campaign.campaign.design.factors.iter().zip(&study.run.levels).map(|(factor, coded)| plain(factor.natural(*coded))));
    row.extend([
        study.run.replicate.map(|r| r.to_string()).unwrap_or_default(),
        study.profile.as_ref().map(|p| p.points().len().to_string()).unwrap_or_default(),
        fit.map(|f| f.folds.map_or_else(|| "round".into(), |m| m.to_string())).unwrap_or_default(),
        mm(fit.map(|f| f.p)),
        mm(fit.and_then(|f| f.q)),
        mm(fit.and_then(|f| f.s)),
        some(fit.map(|f| f.rms / MILLIMETRE), 2),
        some(fit.map(|f| f.fold_depth / MILLIMETRE), 1),
        some(folded.map(|f| f.explained / PERCENT), 0),
        some(study.drape_coefficient.map(|share| share / PERCENT), 1),
        lambda.map(|(e, _)| significant(e.value, 3)).unwrap_or_default(),
        some(lambda.map(|(_, r2)| r2), 2),
        study.prediction.as_ref().map(|p| if p.folds == 0 { "round".into() } else { p.folds.to_string() }).unwrap_or_default(),
        some(study.comparison.as_ref().map(|c| c.rms / MILLIMETRE), 1),
        match &study.fit {
            Ok(fit) => note::termination(&fit.termination).replace('_', " "),
            Err(_) if study.profile.is_none() => "set aside".into(),
            Err(_) => "no fit".into(),
        },
    ]);
    row
}

/// Each factor with the levels that occur, and which of them every run has.
pub fn filters(study: &CampaignStudy) -> Vec<Value> {
    let one = |(i, factor): (usize, &crate::experiment::Factor)| {
        let mut levels: Vec<f64> = study.runs.iter().filter_map(|r| r.run.levels.get(i).copied()).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        let of_run = |run: &RunStudy| levels.iter().position(|l| Some(l) == run.run.levels.get(i));
        let unit = factor.unit.as_deref().map(|u| format!(" {u}")).unwrap_or_default();
        json!({
            "name": factor.name,
            "levels": levels.iter().map(|l| format!("{}{unit}", plain(factor.natural(*l)))).collect::<Vec<_>>(),
            "of_run": study.runs.iter().map(of_run).collect::<Vec<_>>(),
        })
    };
    study.campaign.design.factors.iter().enumerate().map(one).collect()
}
