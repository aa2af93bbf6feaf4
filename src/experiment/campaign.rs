//! A campaign: what `campaign.toml` says about a set of runs, checked.

use std::path::PathBuf;

use serde::Serialize;

use super::design::Design;
use super::specimen::Apparatus;

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
}
