//! The chapter on irregular folds: three curves through every outline, and how far its folds differ.

use serde_json::{Value, json};

use crate::report::gallery::{Gallery, cells};
use crate::report::number::{fixed, plain, probability, significant};
use crate::study::campaign::{CampaignStudy, RunStudy};
use crate::study::irregular::Irregular;
use crate::study::overview::{Spread, spread};
use crate::units::{MILLIMETRE, PERCENT};

/// For what does not exist.
const NONE: &str = "–";

/// `null` where no outline was fitted.
pub fn chapter(study: &CampaignStudy, gallery: &Gallery) -> Value {
    let known: Vec<(&RunStudy, &Irregular)> =
        cells(&study.runs).into_iter().flat_map(|(_, runs)| runs).filter_map(|run| Some((run, run.irregular.as_ref()?))).collect();
    if known.is_empty() {
        return Value::Null;
    }
    let drawn = |stem: &str, run: Option<&RunStudy>| run.filter(|_| gallery.contains_key(stem)).map(|run| run.run.id.clone());
    json!({
        "words": words(&known, study.campaign.alpha),
        "rows": known.iter().map(|(run, irregular)| row(run, irregular)).collect::<Vec<_>>(),
        "figure": gallery.contains_key("folds"),
        "uneven": drawn("folds_uneven", most_uneven(study)),
        "reshaped": drawn("folds_reshaped", most_reshaped(study)),
    })
}

/// The run whose folds differ most in depth, to be drawn.
pub fn most_uneven(study: &CampaignStudy) -> Option<&RunStudy> {
    let variation = |run: &&RunStudy| run.irregular.as_ref().and_then(|i| i.table.depth_variation);
    let known = study.runs.iter().filter(|run| variation(run).is_some());
    known.max_by(|a, b| variation(a).unwrap_or(0.0).total_cmp(&variation(b).unwrap_or(0.0)))
}

/// The run of which equal folds of another shape explain most of what the paper's curve leaves, to be drawn.
pub fn most_reshaped(study: &CampaignStudy) -> Option<&RunStudy> {
    let known = study.runs.iter().filter(|run| run.irregular.as_ref().is_some_and(|i| gained(i).is_some()));
    let gain = |run: &&RunStudy| run.irregular.as_ref().and_then(gained).unwrap_or(0.0);
    known.max_by(|a, b| gain(a).total_cmp(&gain(b)))
}

/// Share of what the paper's curve leaves that equal folds of another shape explain.
fn gained(irregular: &Irregular) -> Option<f64> {
    let (model, _) = irregular.tangent.as_ref().ok()?;
    Some(1.0 - model.sum_of_squares / irregular.paper.sum_of_squares)
}

fn words(known: &[(&RunStudy, &Irregular)], alpha: f64) -> Vec<String> {
    let n = known.len();
    let mut said = vec![];
    let tests: Vec<_> = known.iter().filter_map(|(_, i)| i.lack_of_fit.as_ref().ok()).collect();
    if !tests.is_empty() {
        let lacking = tests.iter().filter(|t| t.p < alpha).count();
        let correlated = tests.iter().filter(|t| t.p_correlated < alpha).count();
        let also = if correlated == lacking {
            "; so it does where the errors of neighbouring points are allowed to be correlated".to_string()
        } else {
            format!("; in {correlated} where the errors of neighbouring points are allowed to be correlated")
        };
        said.push(format!(
            "The paper’s curve lacks fit in {lacking} of {} runs (α = {}){also}: their folds are not equal, or not of its shape.",
            tests.len(),
            plain(alpha)
        ));
    }
    if let Some(noise) = spread(known.iter().filter_map(|(_, i)| i.free.as_ref().ok()).map(|(_, free)| free.noise())) {
        said.push(format!("The free outline leaves {} per point: what the points are in error.", millimetres(&noise)));
    }
    let least =
        |name: &str| known.iter().filter(|(_, i)| i.models().iter().any(|(other, model)| *other == name && model.aicc <= i.best())).count();
    said.push(format!(
        "By AICc the free outline is the best of the three in {} of {n} runs, equal folds of any shape in {}, the paper’s curve in {}.",
        least("free_outline"),
        least("tangent_angle"),
        least("paper")
    ));
    if let Some(gained) = spread(known.iter().filter_map(|(_, i)| gained(i))) {
        said.push(format!(
            "Of what the paper’s curve leaves, a better shape of equal folds explains {} % (median; {} to {}); the rest is error of the points, or that the folds differ from each other.",
            fixed(gained.median / PERCENT, 0),
            fixed(gained.low / PERCENT, 0),
            fixed(gained.high / PERCENT, 0)
        ));
    }
    let variation = |pick: fn(&Irregular) -> Option<f64>| spread(known.iter().filter_map(|(_, i)| pick(i)));
    if let (Some(depth), Some(width)) = (variation(|i| i.table.depth_variation), variation(|i| i.table.width_variation)) {
        said.push(format!(
            "Folds of one hem differ by {} % in depth and {} % in width (coefficient of variation, median; up to {} and {} %).",
            fixed(depth.median / PERCENT, 0),
            fixed(width.median / PERCENT, 0),
            fixed(depth.high / PERCENT, 0),
            fixed(width.high / PERCENT, 0)
        ));
    }
    let counted: Vec<(u32, usize)> =
        known.iter().filter_map(|(run, i)| Some((run.fit.as_ref().ok()?.folds.unwrap_or(0), i.table.folds.len()))).collect();
    let same = counted.iter().filter(|(m, crests)| *m as usize == *crests).count();
    let leaning = known.iter().filter(|(_, i)| i.table.folds.iter().any(|f| 0.0 < f.overhang.value)).count();
    said.push(format!(
        "The crests of the outline are as many as the fitted folds in {same} of {} runs. Some fold overhangs in {leaning}.",
        counted.len()
    ));
    said
}

fn millimetres(spread: &Spread) -> String {
    format!(
        "{} mm (median; {} to {})",
        fixed(spread.median / MILLIMETRE, 2),
        fixed(spread.low / MILLIMETRE, 2),
        fixed(spread.high / MILLIMETRE, 2)
    )
}

fn row(run: &RunStudy, irregular: &Irregular) -> Vec<String> {
    let table = &irregular.table;
    let some = |v: Option<f64>, decimals: usize| v.map_or_else(|| NONE.into(), |v| fixed(v, decimals));
    let depths = spread(table.folds.iter().map(|f| f.depth.value));
    let mean = |pick: fn(&crate::fit::fold_table::Fold) -> f64| {
        (!table.folds.is_empty()).then(|| table.folds.iter().map(pick).sum::<f64>() / table.folds.len() as f64)
    };
    let overhang = table.folds.iter().map(|f| f.overhang.value).fold(0.0, f64::max);
    let models = irregular.models();
    let of = |name: &str| models.iter().find(|(other, _)| *other == name).map(|(_, model)| *model);
    let names = ["paper", "tangent_angle", "free_outline"];
    let fit = run.fit.as_ref().ok();
    let mut cells = vec![
        run.run.id.clone(),
        fit.and_then(|f| f.folds).map_or_else(|| NONE.into(), |m| m.to_string()),
        table.folds.len().to_string(),
        some(mean(|f| f.depth.value).map(|d| d / MILLIMETRE), 0),
        depths.map_or_else(|| NONE.into(), |d| format!("{}–{}", fixed(d.low / MILLIMETRE, 0), fixed(d.high / MILLIMETRE, 0))),
        some(table.depth_variation.map(|v| v / PERCENT), 0),
        some(table.width_variation.map(|v| v / PERCENT), 0),
        if 0.0 < overhang { fixed(overhang / MILLIMETRE, 1) } else { NONE.into() },
    ];
    cells.extend(names.map(|name| some(of(name).map(|m| m.rms / MILLIMETRE), 2)));
    cells.push(of("tangent_angle").and_then(|m| m.harmonics).map_or_else(|| NONE.into(), |k| k.to_string()));
    cells.push(of("free_outline").and_then(|m| m.harmonics).map_or_else(|| NONE.into(), |k| k.to_string()));
    cells.extend(["paper", "tangent_angle"].map(|name| some(of(name).map(|m| m.aicc - irregular.best()), 0)));
    cells.extend(match &irregular.lack_of_fit {
        Ok(test) => [significant(test.f, 3), probability(test.p), probability(test.p_correlated)],
        Err(_) => [NONE, NONE, NONE].map(String::from),
    });
    cells
}
