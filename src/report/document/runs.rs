//! What is printed about a single run: its block, and its row in the table of all fits.

use serde_json::{Value, json};

use crate::experiment::Factor;
use crate::fit::Estimate;
use crate::report::gallery::{Gallery, cell_name};
use crate::report::number::{fixed, signed, significant, to_error, with_error};
use crate::report::{note, words};
use crate::study::campaign::{CampaignStudy, RunStudy};
use crate::units::{MILLIMETRE, PERCENT};

/// Whether λ itself is known anywhere, not only λ/(ρ_A g).
pub fn has_cloth(study: &CampaignStudy) -> bool {
    study.runs.iter().any(|r| r.lambda.first_integral.is_some())
}

/// The block of one run.
pub fn block(study: &RunStudy, factors: &[Factor], gallery: &Gallery) -> Value {
    let id = words::file_stem(&study.run.id);
    let figure = |kind: &str| Some(format!("{kind}_{id}")).filter(|name| gallery.contains_key(name));
    let mut treatment = cell_name(factors, &study.run.levels).join(", ");
    if let Some(replicate) = study.run.replicate {
        treatment.push_str(&format!(", replicate {replicate}"));
    }
    json!({
        "id": study.run.id,
        "treatment": treatment,
        "hem": figure("hem"),
        "distance": figure("distance"),
        "rows": rows(study),
        "notes": note::of(study),
    })
}

fn rows(study: &RunStudy) -> Vec<[String; 3]> {
    let mut rows: Vec<[String; 3]> = vec![];
    let mut row = |name: &str, value: String, how: String| rows.push([name.into(), value, how]);
    let mm = |e: Estimate| with_error(e.value / MILLIMETRE, e.standard_error.map(|s| s / MILLIMETRE)) + " mm";
    if let Ok(fit) = &study.fit {
        match fit.folds {
            Some(m) => row("fold count m", m.to_string(), format!("weight of evidence {}", fixed(fit.folds_weight, 2))),
            None => row("fold count m", "round".into(), String::new()),
        }
        row("mean radius p", mm(fit.p), String::new());
        if let Some(q) = fit.q {
            row("fold amplitude q", mm(q), String::new());
        }
        if let Some(s) = fit.s {
            row("lean s", mm(s), if fit.hem.overhangs() { "overhangs".into() } else { String::new() });
        }
        let share = if fit.folds.is_some() { format!("explains {} %", fixed(fit.explained / PERCENT, 0)) } else { String::new() };
        row("misfit rms", format!("{} mm", fixed(fit.rms / MILLIMETRE, 2)), share);
        row("fold depth", format!("{} mm", fixed(fit.fold_depth / MILLIMETRE, 1)), String::new());
        row(
            "hem length",
            format!("{} mm", fixed(fit.perimeter / MILLIMETRE, 0)),
            format!("outline {} mm", fixed(fit.outline_length / MILLIMETRE, 0)),
        );
    }
    if let Some(share) = study.drape_coefficient {
        row("drape coefficient", format!("{} %", fixed(share / PERCENT, 1)), "of the measured outline".into());
    }
    let l = &study.lambda;
    let scientific = |e: Estimate, unit: &str| {
        let text = with_error(e.value, e.standard_error);
        if unit.is_empty() || !text.contains('±') || text.starts_with('(') { format!("{text} {unit}") } else { format!("({text}) {unit}") }
    };
    let by_r2 = |r2: f64| {
        format!(
            "R² {}: {}",
            fixed(r2, 2),
            if r2 < 0.5 {
                "holds badly"
            } else if r2 < 0.9 {
                "holds roughly"
            } else {
                "holds"
            }
        )
    };
    let by_angle = |a: f64| {
        format!(
            "angle {}°: {}",
            fixed(a, 1),
            if a < 5.0 {
                "holds"
            } else if a < 20.0 {
                "holds roughly"
            } else {
                "holds badly"
            }
        )
    };
    if let Some((e, r2)) = l.first_integral {
        row("λ, first integral", scientific(e, "N/m²"), by_r2(r2));
    } else if let Some((e, r2)) = l.over_weight {
        row("λ/(ρg), first integral", scientific(e, ""), by_r2(r2));
    }
    if let Some((e, angle)) = l.ritz {
        row("λ, Ritz", scientific(e, "N/m²"), by_angle(angle));
    } else if let Some((e, angle)) = l.over_weight_ritz {
        row("λ/(ρg), Ritz", scientific(e, ""), by_angle(angle));
    }
    if let Some((e, angle)) = l.ruled {
        row("λ, ruled shell", scientific(e, "N"), by_angle(angle));
    }
    if let (Some(prediction), Some(c)) = (&study.prediction, &study.comparison) {
        let folds = if prediction.folds == 0 { "round".into() } else { format!("m = {}", prediction.folds) };
        row("theory", folds, format!("points {} mm rms from it", fixed(c.rms / MILLIMETRE, 1)));
        row(
            "theory − fit",
            format!("radius {} mm", signed(c.mean_radius / MILLIMETRE, 1)),
            format!("depth {} mm", signed(c.depth / MILLIMETRE, 1)),
        );
    }
    rows
}

/// The row of one run in the table of all fits.
pub fn row(study: &RunStudy) -> Value {
    let Ok(fit) = &study.fit else {
        let mut row = vec![String::new(); 12];
        row[0] = study.run.id.clone();
        row[4] = "no fit".into();
        return json!(row);
    };
    let mm = |e: Estimate| {
        let se = e.standard_error.map(|s| s / MILLIMETRE);
        match se {
            Some(_) => with_error(e.value / MILLIMETRE, se),
            None => to_error(e.value / MILLIMETRE, None),
        }
    };
    let optional = |e: Option<Estimate>| e.map(mm).unwrap_or_default();
    let folded = |text: String| if fit.folds.is_some() { text } else { String::new() };
    let lambda = study.lambda.first_integral.or(study.lambda.over_weight);
    json!([
        format!("{}{}", study.run.id, if fit.held.is_some() { " ※" } else { "" }),
        study.profile.as_ref().map(|p| p.points().len().to_string()).unwrap_or_default(),
        fit.folds.map_or_else(|| "round".into(), |m| m.to_string()),
        folded(fixed(fit.folds_weight, 2)),
        mm(fit.p),
        optional(fit.q),
        optional(fit.s),
        fixed(fit.rms / MILLIMETRE, 2),
        fixed(fit.fold_depth / MILLIMETRE, 1),
        folded(format!("{} %", fixed(fit.explained / PERCENT, 0))),
        lambda.map(|(e, _)| significant(e.value, 3)).unwrap_or_default(),
        lambda.map(|(_, r2)| fixed(r2, 2)).unwrap_or_default(),
    ])
}
