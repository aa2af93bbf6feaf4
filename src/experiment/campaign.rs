//! A campaign: what `campaign.toml` says about a set of runs, checked.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::design::Design;
use super::specimen::Apparatus;
use crate::units::Metre;

/// How many folds a fit may choose from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Folds {
    /// By weight of evidence among `from..=to`.
    Among { from: u32, to: u32 },
    /// Given.
    Exactly(u32),
}

impl Default for Folds {
    /// 2…24: skirts and drape testers show 3 to about 15 folds; the margin makes a wrong edge visible.
    fn default() -> Self {
        Folds::Among { from: 2, to: 24 }
    }
}

/// Which length the fitted curve is held to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum HemLength {
    /// Free; held at the outline's own length (2πR_n where the cut is known) only where the free optimum is no sane curve.
    Auto,
    /// Free; where the free optimum is no sane curve there is no fit.
    Free,
    /// Held at this length, m.
    Held(f64),
}

/// Which grey of a picture is the cloth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shade {
    Dark,
    Light,
    /// Whatever the margin of the picture is not.
    #[default]
    Auto,
}

impl std::str::FromStr for Shade {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "dark" => Ok(Shade::Dark),
            "light" => Ok(Shade::Light),
            "auto" => Ok(Shade::Auto),
            _ => Err(format!("“{text}” is no shade: use dark, light or auto")),
        }
    }
}

/// How pictures of drapes are read.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pictures {
    /// Side of a pixel on the cloth, m.
    pub pixel: Metre,
    pub object: Shade,
}

/// One response that can be regressed on the factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Response {
    /// As campaign files and result tables name it.
    pub name: &'static str,
    /// What it is, in words.
    pub label: &'static str,
    /// Unit in which tables show it.
    pub unit: &'static str,
}

/// Every response that a campaign may ask for, in the order of the tables.
pub const RESPONSES: [Response; 9] = [
    Response { name: "p", label: "mean radius p", unit: "mm" },
    Response { name: "q", label: "fold amplitude q", unit: "mm" },
    Response { name: "s", label: "sideways lean s", unit: "mm" },
    Response { name: "m", label: "fold count m", unit: "1" },
    Response { name: "lambda_first_integral", label: "λ by the first integral", unit: "N/m²" },
    Response { name: "lambda_ritz", label: "λ by the Ritz condition", unit: "N/m²" },
    Response { name: "lambda_ruled", label: "λ of the ruled shell", unit: "N" },
    Response { name: "rms", label: "rms distance", unit: "mm" },
    Response { name: "fold_depth", label: "fold depth", unit: "mm" },
];

/// Everything about a campaign but its measured outlines.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Campaign {
    pub title: String,
    /// Where the measurements come from; printed wherever their numbers appear.
    pub origin: String,
    pub apparatus: Apparatus,
    /// The folder it was read from.
    pub folder: PathBuf,
    pub design: Design,
    /// Names of the responses to regress, in order.
    pub responses: Vec<String>,
    /// Significance level of every test, 0.05 unless told.
    pub alpha: f64,
    pub folds: Folds,
    pub hem_length: HemLength,
    /// Acceleration of free fall, m/s².
    pub gravity: f64,
    /// Foundation modulus E of the paper's functional, N/m³; 0 unless told.
    pub foundation_modulus: f64,
    /// How pictures among the profile files are read; `None` where the campaign has no scale for them.
    pub pictures: Option<Pictures>,
}
