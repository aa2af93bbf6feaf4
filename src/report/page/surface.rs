//! The surfaces of a run as the page turns them, and one scale of colours for each field over all runs.

use serde_json::{Value, json};

use super::packed::packed;
use crate::report::number::fixed;
use crate::study::campaign::{CampaignStudy, RunStudy};
use crate::study::draped::{Carried, DrapedSurface, Field, HemOf, Options, Quantity, draped};
use crate::units::{MILLIMETRE, MILLINEWTON};

/// Corners are sent to this place, m: the picture is a few hundred pixels high.
pub const STEP: f64 = 0.1 * MILLIMETRE;

/// How a quantity is shown: label, sentence, unit, what that unit is in SI, the place it is sent to (in that unit), decimals.
struct Shown {
    quantity: Quantity,
    label: &'static str,
    about: &'static str,
    unit: &'static str,
    factor: f64,
    step: f64,
    decimals: usize,
}

const SHOWN: [Shown; 4] = [
    Shown {
        quantity: Quantity::Flexure,
        label: "Flexure",
        about: "Flexure: distance from the axis less that of the unfolded cone.",
        unit: "mm",
        factor: MILLIMETRE,
        step: 0.1,
        decimals: 1,
    },
    Shown {
        quantity: Quantity::Curvature,
        label: "Curvature",
        about: "Curvature: of the level ring; positive where it turns like a circle.",
        unit: "1/m",
        factor: 1.0,
        step: 0.02,
        decimals: 1,
    },
    Shown {
        quantity: Quantity::BendingMoment,
        label: "Bending moment",
        about: "Bending moment: per width, rigidity times curvature; the stress intensity at the faces of the cloth is proportional to it.",
        unit: "mN",
        factor: MILLINEWTON,
        step: 0.0002,
        decimals: 3,
    },
    Shown {
        quantity: Quantity::StressIntensity,
        label: "Stress intensity",
        // The cloth of `assumed_sheet`.
        about: "Stress intensity: von Mises’ stress of hanging and bending, at the face where it is greater, as if the cloth were 1 mm thick with Poisson’s \
                ratio 0.",
        unit: "Pa",
        factor: 1.0,
        step: 5.0,
        decimals: 0,
    },
];

/// Share of the points at either end that may be beyond the scale: sharp bends would take all colours otherwise.
const BEYOND: f64 = 0.02;

/// One field's colours over all runs.
pub struct Scale {
    shown: &'static Shown,
    low: f64,
    high: f64,
}

impl Scale {
    pub fn json(&self) -> Value {
        let Shown { label, about, unit, decimals, .. } = self.shown;
        json!({ "label": label, "about": about, "unit": unit, "decimals": decimals, "low": rounded(self.low, self.shown), "high": rounded(self.high, self.shown) })
    }
}

/// One for each quantity that can be shown, in their order.
pub fn scales(study: &CampaignStudy, options: &Options) -> Vec<Scale> {
    let all: Vec<Field> =
        study.runs.iter().flat_map(|run| draped(run, study.campaign.gravity, options)).flat_map(|surface| surface.fields).collect();
    let one = |shown: &'static Shown| {
        let values = all.iter().filter(|f| f.quantity == shown.quantity).flat_map(|f| &f.values).map(|v| v / shown.factor);
        let (low, high) = range(values.collect());
        Scale { shown, low, high }
    };
    SHOWN.iter().map(one).collect()
}

/// The middle part of the values.
fn range(mut values: Vec<f64>) -> (f64, f64) {
    values.retain(|v| v.is_finite());
    if values.is_empty() {
        return (0.0, 1.0);
    }
    let last = values.len() - 1;
    let cut = (BEYOND * last as f64) as usize;
    let low = *values.select_nth_unstable_by(cut, f64::total_cmp).1;
    let high = *values.select_nth_unstable_by(last - cut, f64::total_cmp).1;
    (low, high)
}

fn rounded(value: f64, shown: &Shown) -> f64 {
    let decimals = shown.decimals + 1;
    format!("{value:.decimals$}").parse::<f64>().unwrap_or(value) + 0.0
}

/// The surfaces of one run; `gravity` in m/s². Everything is sent to places `coarse` times as large as usual.
pub fn surfaces(study: &RunStudy, gravity: f64, options: &Options, coarse: f64) -> Vec<Value> {
    draped(study, gravity, options).iter().map(|drawn| surface(drawn, coarse)).collect()
}

fn surface(surface: &DrapedSurface, coarse: f64) -> Value {
    let (key, label) = match surface.hem_of {
        HemOf::Fit => ("fitted", "fitted hem"),
        HemOf::Theory => ("theory", "theory"),
    };
    let about = match (surface.hem_of, surface.carried) {
        (_, Carried::Linear) => {
            "The fitted hem carried up to the round waist by the paper’s equation (18): p, q and s linear in height. Dots: measured points."
                .to_string()
        }
        (HemOf::Fit, Carried::Straight { beyond }) => {
            let out = match beyond {
                b if STEP < b => format!(
                    " Parts of the hem lie up to {} mm further out than the cloth reaches; they are drawn level.",
                    fixed(b / MILLIMETRE, 1)
                ),
                _ => String::new(),
            };
            format!("The fitted hem below straight generatrices of the specimen’s length.{out}")
        }
        (HemOf::Theory, Carried::Straight { .. }) => {
            "The hem of least energy at the fitted fold count, below straight generatrices as long as the slant; nothing in it is fitted."
                .to_string()
        }
    };
    let fields = surface.fields.iter().filter_map(|field| {
        let (index, shown) = SHOWN.iter().enumerate().find(|(_, s)| s.quantity == field.quantity)?;
        let values = || field.values.iter().map(|v| v / shown.factor);
        let (low, high) = range(values().collect());
        let (low, high) = (rounded(low, shown), rounded(high, shown));
        let step = coarse * shown.step;
        Some(json!({ "field": index, "low": low, "high": high, "step": step, "values": packed(values(), 1, step) }))
    });
    json!({
        "key": key,
        "label": label,
        "about": about,
        "copies": surface.copies,
        "round": surface.round,
        "down": surface.down,
        "level": surface.carried == Carried::Linear,
        "disc": surface.hem_of == HemOf::Fit && surface.carried != Carried::Linear,
        "points": packed(surface.points.iter().flatten().copied(), 3, coarse * STEP),
        "fields": fields.collect::<Vec<_>>(),
    })
}

/// Why a run has no surface; empty where it has one.
pub fn missing(study: &RunStudy) -> &'static str {
    match (&study.fit, &study.run.skirt) {
        (Err(_), _) => "There is no surface without a fit.",
        (_, None) => "There is no surface: the cut is not known.",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::number::plain;
    use crate::study::{paper::THICKNESS, surface::ASSUMED_POISSON};

    #[test]
    fn the_assumption_that_is_said_is_the_one_that_is_made() {
        let said =
            format!("as if the cloth were {} mm thick with Poisson’s ratio {}.", plain(THICKNESS / MILLIMETRE), plain(ASSUMED_POISSON));
        let shown = SHOWN.iter().find(|s| s.quantity == Quantity::StressIntensity).unwrap();
        assert!(shown.about.ends_with(&said), "{said}");
    }
}
