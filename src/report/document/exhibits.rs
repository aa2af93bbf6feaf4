//! Figures that stand in the document where a campaign has them: contours, multipliers, replicates, skirts in space, patterns.

use serde_json::{Value, json};

use crate::report::gallery::{Gallery, regression_stem};
use crate::report::words;
use crate::study::campaign::CampaignStudy;

/// Stems of the figures that are there, each with what it is of.
pub fn exhibits(study: &CampaignStudy, gallery: &Gallery) -> Value {
    let there = |stem: String| gallery.contains_key(&stem).then_some(stem);
    let of_runs = |kind: &str| -> Vec<Value> {
        let one = |id: &str| Some(json!({ "stem": there(format!("{kind}_{}", words::file_stem(id)))?, "of": id }));
        study.runs.iter().filter_map(|run| one(&run.run.id)).collect()
    };
    let contour = |response: &str| {
        let stem = there(format!("{}_contour", regression_stem(response)))?;
        Some(json!({ "stem": stem, "of": words::response(response).label }))
    };
    json!({
        "contours": study.regressions.iter().filter_map(|r| contour(&r.response)).collect::<Vec<_>>(),
        "multipliers": there("lambda".into()),
        "cells": there("cells".into()),
        "replicates": gallery.keys().filter(|stem| stem.starts_with("replicates_")).collect::<Vec<_>>(),
        "skirts": of_runs("skirt"),
        "patterns": of_runs("pattern"),
    })
}
