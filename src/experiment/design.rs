//! Factors, runs and the design they make: coded units, replicates, run order.

use std::path::PathBuf;

use serde::Serialize;

use super::specimen::{Fabric, Skirt};

/// One factor of a two-level design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Factor {
    /// Column of the design table; the name of the regressor.
    pub name: String,
    /// What it is, in words; the name where none is given.
    pub label: String,
    /// Unit of the natural levels.
    pub unit: Option<String>,
    /// Natural level at coded −1.
    pub low: f64,
    /// Natural level at coded +1.
    pub high: f64,
}

impl Factor {
    /// Natural value at a coded one.
    pub fn natural(&self, coded: f64) -> f64 {
        0.5 * (self.high + self.low) + 0.5 * (self.high - self.low) * coded
    }

    /// Coded value of a natural one.
    pub fn coded(&self, natural: f64) -> f64 {
        (natural - 0.5 * (self.high + self.low)) / (0.5 * (self.high - self.low))
    }
}

/// One treatment, executed once.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Run {
    /// As the design table names it; unique within a campaign.
    pub id: String,
    /// Replicate within its cell, as the table has it.
    pub replicate: Option<u32>,
    /// What it was done together with (day, operator, bolt of cloth …), where the campaign names a column for it.
    pub block: Option<String>,
    /// Coded levels, −1 and +1 at a corner and 0 at the centre, one per factor, in the order of [`Design::factors`].
    pub levels: Vec<f64>,
    /// The cut, where the campaign knows it.
    pub skirt: Option<Skirt>,
    /// The cloth, as far as it was measured.
    pub fabric: Fabric,
    /// The profile file, relative to the campaign folder.
    pub profile: PathBuf,
}

/// Factors, and the runs in the order in which they were executed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Design {
    pub factors: Vec<Factor>,
    pub runs: Vec<Run>,
}
