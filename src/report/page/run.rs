//! One run: its curves, its surfaces, its numbers with units and standard errors, its folds, its notes.

use serde_json::{Value, json};

use super::table::{Column, of_texts};
use super::{packed, surface};
use crate::experiment::Point;
use crate::fit::fold_table::DEGREES;
use crate::fit::intervals::{End, Interval};
use crate::fit::uncertainty::Unknown;
use crate::fit::{Estimate, HemFit};
use crate::report::figure::hem::View;
use crate::report::gallery::cell_name;
use crate::report::note;
use crate::report::number::{fixed, plain, signed, significant, to_error, with_error};
use crate::study::campaign::{CampaignStudy, RunStudy};
use crate::study::draped;
use crate::units::{MILLIJOULE, MILLIMETRE, PERCENT};

/// How finely runs are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detail {
    /// Points of a curve, about.
    nodes: usize,
    /// Most measured points; of denser outlines every other or every third one.
    most: usize,
    /// To this place curves are sent, m.
    pub step: f64,
    pub surface: draped::Options,
    /// How many times as coarsely as usual places and fields of surfaces are sent.
    pub coarse: f64,
    /// Whether the page has the long tables of fold counts tried, curves compared, folds and branches of the theory, which are files too.
    pub long_tables: bool,
}

/// More runs than these are shown with half the points: the page would take long to open.
const MANY: usize = 120;
/// More than these with still less, about 14 kB for a run: a page of 600 runs stays below 10 MB, which mail and browsers take.
const VERY_MANY: usize = 300;

impl Detail {
    /// For a campaign of so many runs.
    pub fn of(runs: usize) -> Self {
        // Chords of a hem that fills a screen are then nowhere off by a pixel, and a hundredth of a millimetre is less than a screen or an outline resolves.
        let fine =
            Detail { nodes: 300, most: 400, step: 0.01 * MILLIMETRE, surface: draped::Options::default(), coarse: 1.0, long_tables: true };
        if VERY_MANY < runs {
            // Of a hem of half a metre a twentieth of a millimetre is a twentieth of a pixel, and four tenths on a skirt no more than its edges show.
            let surface = draped::Options { round: 48, down: 6 };
            return Detail { nodes: 120, most: 120, step: 0.05 * MILLIMETRE, surface, coarse: 4.0, long_tables: false };
        }
        if MANY < runs {
            return Detail { nodes: 150, most: 200, surface: draped::Options { round: 72, down: 8 }, ..fine };
        }
        fine
    }

    /// What a reader should know who looks closely; nothing of a page that shows all.
    pub fn said(&self) -> Option<String> {
        if *self == Detail::of(0) {
            return None;
        }
        let mut said = format!(
            "At most {} measured points of a run and about {} points of a curve are drawn, as a page of so many runs would be too large.",
            self.most, self.nodes
        );
        if !self.long_tables {
            said.push_str(" Fold counts tried, curves compared, folds and branches of the theory are in candidates.csv, models.csv, folds.csv and predictions.csv.");
        }
        Some(said)
    }
}

/// Everything shown of one run.
pub fn view(study: &RunStudy, campaign: &CampaignStudy, detail: &Detail) -> Value {
    let mut treatment = cell_name(&campaign.campaign.design.factors, &study.run.levels).join(", ");
    if let Some(replicate) = study.run.replicate {
        treatment.push_str(&format!(", replicate {replicate}"));
    }
    json!({
        "id": study.run.id,
        "treatment": treatment,
        "notes": note::of(study),
        "hem": hem(study, detail),
        "surfaces": surface::surfaces(study, campaign.campaign.gravity, &detail.surface, detail.coarse),
        "surface_missing": surface::missing(study),
        "numbers": of_texts(&number_columns(), numbers(study)),
        "folds": of_texts(&fold_columns(), folds(study)),
    })
}

/// The curves in mm, in the frame of the measurement; `null` where the profile was set aside.
fn hem(study: &RunStudy, detail: &Detail) -> Option<Value> {
    let view = View::of(study)?;
    let profile = study.profile.as_ref()?;
    let fit = study.fit.as_ref().ok();
    let stride = view.measured.len().div_ceil(detail.most);
    let every = |points: &[Point], stride: usize| packed::points(points.iter().step_by(stride), detail.step);
    let curve = |points: &[Point]| (!points.is_empty()).then(|| every(points, (points.len() / detail.nodes).max(1)));
    let free = study.irregular.as_ref().and_then(|i| i.free.as_ref().ok()).map(|(_, free)| free.placed.outline(detail.nodes));
    let longest = fit.map_or(0.0, |f| f.distances.iter().fold(0.0_f64, |most, d| most.max(d.abs())));
    // A tenth of the hem's reach is as long as a whisker may grow before whiskers of neighbouring folds meet.
    let magnified = [50, 20, 10, 5, 2].into_iter().find(|f| f64::from(*f) * longest < 0.1 * view.reach()).unwrap_or(1);
    Some(json!({
        "centre": [hundredths(view.centre.x / MILLIMETRE), hundredths(view.centre.y / MILLIMETRE)],
        // Only under a drape tester's cloth is there a disc to be seen from above.
        "support": study.on_support.and(study.run.skirt.as_ref()).map(|s| hundredths(s.waist_radius().0 / MILLIMETRE)),
        "reach": hundredths(view.reach() / MILLIMETRE),
        "rms": fit.map(|f| hundredths(f.rms / MILLIMETRE)),
        "magnified": magnified,
        // Places in the input file, 1 for its first point.
        "index": packed::packed(profile.source_index().iter().step_by(stride).map(|i| *i as f64 + 1.0), 1, 1.0),
        "measured": every(&view.measured, stride),
        "feet": fit.map(|_| every(&view.feet, stride)),
        "distance": fit.map(|f| f.distances.iter().step_by(stride).map(|d| (d / detail.step).round() as i64).collect::<Vec<_>>()),
        "fitted": curve(&view.fitted),
        "predicted": curve(&view.predicted),
        "free": free.as_deref().and_then(curve),
    }))
}

fn hundredths(v: f64) -> f64 {
    format!("{v:.2}").parse::<f64>().unwrap_or(v) + 0.0
}

fn number_columns() -> [Column; 6] {
    [
        Column::text("Quantity"),
        Column::number("Value", ""),
        Column::text("Unit"),
        Column::number("Std. error", ""),
        Column::number("95 % interval", ""),
        Column::words("How well, or why not"),
    ]
}

/// One quantity: value and error are rounded to the place of the error.
struct Row<'a> {
    name: &'a str,
    unit: &'a str,
    /// What a unit is in SI.
    factor: f64,
    estimate: Estimate,
    interval: Option<Interval>,
    remark: String,
}

impl Row<'_> {
    fn texts(self) -> Vec<String> {
        let scaled = |v: f64| v / self.factor;
        let error = self.estimate.standard_error.map(scaled);
        let end = |end: End| match end {
            End::At(v) => to_error(scaled(v), error),
            End::Bound(v) => format!("{} (bound)", to_error(scaled(v), error)),
            End::Open => "open".into(),
            End::Lost => "lost".into(),
        };
        vec![
            self.name.into(),
            to_error(scaled(self.estimate.value), error),
            self.unit.into(),
            error.map(|e| error_alone(scaled(self.estimate.value), e)).unwrap_or_default(),
            self.interval.map(|i| format!("{} … {}", end(i.low), end(i.high))).unwrap_or_default(),
            self.remark,
        ]
    }
}

/// The error as it stands behind its value, to the same place: “0.04”, “0.04 × 10⁻⁶”.
fn error_alone(value: f64, error: f64) -> String {
    let both = with_error(value, Some(error));
    match both.split_once(" ± ").map(|(_, error)| error.split_once(')')) {
        Some(Some((error, power))) => format!("{error}{power}"),
        Some(None) => both.split_once(" ± ").map(|(_, error)| error.to_string()).unwrap_or_default(),
        None => significant(error, 2),
    }
}

fn numbers(study: &RunStudy) -> Vec<Vec<String>> {
    let mut rows = study.fit.as_ref().map(|fit| of_fit(study, fit)).unwrap_or_default();
    let mut row = |name: &str, value: String, unit: &str, remark: String| {
        rows.push(vec![name.into(), value, unit.into(), String::new(), String::new(), remark]);
    };
    if let Some(share) = study.drape_coefficient {
        row("drape coefficient", fixed(share / PERCENT, 1), "%", "of the measured outline".into());
    }
    if let (Some(prediction), Some(c)) = (&study.prediction, &study.comparison) {
        let folds = if prediction.folds == 0 { "round".into() } else { prediction.folds.to_string() };
        row("theory: fold count", folds, "", prediction.fidelity.clone());
        row("theory: energy", significant(prediction.energy / MILLIJOULE, 4), "mJ", "least over all fold counts".into());
        row("theory: rms distance of the points", fixed(c.rms / MILLIMETRE, 1), "mm", "at the fitted fold count".into());
        row("theory − fit: mean radius", signed(c.mean_radius / MILLIMETRE, 1), "mm", "at the fitted fold count".into());
        row("theory − fit: fold depth", signed(c.depth / MILLIMETRE, 1), "mm", "at the fitted fold count".into());
    }
    let skirt = study.run.skirt.as_ref();
    let mm = |v: f64| plain(v / MILLIMETRE);
    if let Some(skirt) = skirt {
        row("waist radius", mm(skirt.waist_radius().0), "mm", "as cut".into());
        row("hem radius", mm(skirt.hem_radius().0), "mm", "as cut".into());
        row("slant length", mm(skirt.slant_length().0), "mm", "as cut".into());
    }
    if let Some(density) = study.run.fabric.areal_density {
        row("areal density", plain(density.0 / crate::units::GRAM_PER_SQUARE_METRE), "g/m²", "as given".into());
    }
    if let Some(rigidity) = study.run.fabric.flexural_rigidity {
        row("flexural rigidity", plain(rigidity.0 / crate::units::MICRONEWTON_METRE), "µN·m", "as given".into());
    }
    rows
}

fn of_fit(study: &RunStudy, fit: &HemFit) -> Vec<Vec<String>> {
    let why = |unknown: Unknown| {
        let missing = fit.standard_error_missing.iter().find(|m| m.unknown == unknown);
        missing.map(|m| m.why.reason().to_string()).unwrap_or_default()
    };
    let intervals = fit.intervals.as_ref();
    let placed = |value: f64, i: usize| Estimate { value, standard_error: fit.placement_errors[i] };
    let bare = |value: f64| Estimate { value, standard_error: None };
    let folds = fit.folds.map_or_else(|| "round".into(), |m| m.to_string());
    let weight = fit.folds.map(|_| format!("weight of evidence {}", fixed(fit.folds_weight, 2))).unwrap_or_default();
    let mut rows = vec![vec!["fold count m".into(), folds, String::new(), String::new(), String::new(), weight]];
    let mut push = |row: Row<'_>| rows.push(row.texts());
    let mm = |name: &'static str, estimate: Estimate, interval: Option<Interval>, remark: String| Row {
        name,
        unit: "mm",
        factor: MILLIMETRE,
        estimate,
        interval,
        remark,
    };
    push(mm("mean radius p", fit.p, intervals.and_then(|i| i.p), why(Unknown::P)));
    if let Some(q) = fit.q {
        push(mm("fold amplitude q", q, intervals.and_then(|i| i.q), why(Unknown::Q)));
    }
    if let Some(s) = fit.s {
        let leans = if fit.hem.overhangs() { "the fitted hem overhangs" } else { "" };
        let remark = [why(Unknown::S).as_str(), leans].into_iter().filter(|t| !t.is_empty()).collect::<Vec<_>>().join("; ");
        push(mm("lean s", s, intervals.and_then(|i| i.s), remark));
    }
    push(mm("centre x₀", placed(fit.placement.x0, 0), None, why(Unknown::X0)));
    push(mm("centre y₀", placed(fit.placement.y0, 1), None, why(Unknown::Y0)));
    if fit.folds.is_some() {
        let phase = intervals.and_then(|i| i.phase);
        let estimate = placed(fit.placement.phase, 2);
        push(Row { name: "phase φ", unit: "°", factor: DEGREES.recip(), estimate, interval: phase, remark: why(Unknown::Phase) });
    }
    let explains = fit.folds.map(|_| format!("explains {} % of the departure from a circle", fixed(fit.explained / PERCENT, 0)));
    push(mm("misfit rms", bare(fit.rms), None, explains.unwrap_or_default()));
    push(mm("fold depth", bare(fit.fold_depth), None, "greatest less least radius of the fitted curve".into()));
    push(mm("hem length", bare(fit.perimeter), None, format!("the outline itself: {} mm", fixed(fit.outline_length / MILLIMETRE, 0))));
    push(mm("radius of equal area", bare((fit.area / std::f64::consts::PI).sqrt()), None, String::new()));
    let l = &study.lambda;
    let by_r2 = |r2: f64| format!("R² {}: {}", fixed(r2, 2), graded([0.9, 0.5].map(|limit| limit <= r2)));
    let by_angle = |a: f64| format!("angle {}°: {}", fixed(a, 1), graded([5.0, 20.0].map(|limit| a < limit)));
    // Errors of λ come from those of p, q, s.
    let unsure = |e: Estimate| if e.standard_error.is_none() { format!("; {}", why(Unknown::P)) } else { String::new() };
    let lambdas = [
        ("λ, first integral", "N/m²", l.first_integral.map(|(e, r2)| (e, by_r2(r2)))),
        ("λ, Ritz", "N/m²", l.ritz.map(|(e, a)| (e, by_angle(a)))),
        ("λ, ruled shell", "N", l.ruled.map(|(e, a)| (e, by_angle(a)))),
        // Per weight only where the cloth was not weighed.
        ("λ/(ρg), first integral", "", l.over_weight.filter(|_| l.first_integral.is_none()).map(|(e, r2)| (e, by_r2(r2)))),
        ("λ/(ρg), Ritz", "", l.over_weight_ritz.filter(|_| l.ritz.is_none()).map(|(e, a)| (e, by_angle(a)))),
    ];
    for (name, unit, found) in lambdas {
        if let Some((estimate, how)) = found {
            let remark = (how + &unsure(estimate)).trim_end_matches("; ").to_string();
            push(Row { name, unit, factor: 1.0, estimate, interval: None, remark });
        }
    }
    if let Some(missing) = &l.missing {
        rows.push(vec!["λ".into(), String::new(), String::new(), String::new(), String::new(), missing.clone()]);
    }
    rows
}

/// Words for a relation that holds, holds roughly, or neither.
fn graded([well, roughly]: [bool; 2]) -> &'static str {
    match (well, roughly) {
        (true, _) => "holds",
        (_, true) => "holds roughly",
        _ => "holds badly",
    }
}

fn fold_columns() -> [Column; 7] {
    [
        Column::number("Fold", ""),
        Column::number("Crest at", "°"),
        Column::number("Crest radius", "mm"),
        Column::number("Depth", "mm"),
        Column::number("Width", "% of the length"),
        Column::number("Width", "°"),
        Column::number("Overhang", "mm"),
    ]
}

fn folds(study: &RunStudy) -> Vec<Vec<String>> {
    let with = |e: &Estimate, factor: f64| with_error(factor * e.value, e.standard_error.map(|s| factor * s));
    let folds = study.irregular.iter().flat_map(|i| &i.table.folds).enumerate();
    folds
        .map(|(i, fold)| {
            vec![
                (i + 1).to_string(),
                with(&fold.angle, DEGREES),
                with(&fold.radius, 1.0 / MILLIMETRE),
                with(&fold.depth, 1.0 / MILLIMETRE),
                with(&fold.width, 1.0 / PERCENT),
                with(&fold.width_angle, DEGREES),
                if 0.0 < fold.overhang.value { with(&fold.overhang, 1.0 / MILLIMETRE) } else { String::new() },
            ]
        })
        .collect()
}

/// The chapter on irregular folds: its sentences, and a table whose rows lead to their runs; `null` where no outline was fitted.
pub fn irregular(study: &CampaignStudy, chapter: &Value) -> Value {
    if chapter.is_null() {
        return Value::Null;
    }
    let rows = super::response::texts(&chapter["rows"]);
    let runs: Vec<Option<usize>> = rows.iter().map(|row| study.runs.iter().position(|r| r.run.id == row[0])).collect();
    let n = |name: &str, unit: &str| Column::number(name, unit);
    let columns = [
        Column::text("Run"),
        n("m", "fitted"),
        n("Folds", "counted"),
        n("Depth", "mm"),
        Column::text("from–to"),
        n("CV", "depth, %"),
        n("CV", "width, %"),
        n("Lean", "mm"),
        n("rms", "paper, mm"),
        n("rms", "equal, mm"),
        n("rms", "free, mm"),
        n("Harm.", "equal"),
        n("Harm.", "free"),
        n("ΔAICc", "paper"),
        n("ΔAICc", "equal"),
        n("F", "lack of fit"),
        n("p", "of F"),
        n("p", "corr."),
    ];
    json!([
        { "title": "", "items": chapter["words"] },
        {
            "title": "Three curves through every outline",
            "table": of_texts(&columns, rows),
            "runs": runs,
            "caption": "m: folds of the paper’s curve. Harm.: harmonics. CV: coefficient of variation over the folds of the hem. Lean: by how much the fold that leans over most \
                        runs backwards. Curves: the paper’s, equal folds by their tangent angle, free outline. ΔAICc: against the best of the three. Lack of fit: \
                        of the paper’s curve against the free outline; p corr.: with correlated errors of neighbouring points allowed for.",
        },
    ])
}
