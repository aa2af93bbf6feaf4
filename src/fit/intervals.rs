//! Confidence intervals of a fit: which kinds there are, and what one says.

use serde::Serialize;

/// How an interval was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Estimate ± Student's t times the standard error.
    Standard,
    /// Where the profile likelihood falls to the cut-off of Student's t.
    Profile,
    /// From outlines whose distances were drawn anew about the fitted curve.
    Bootstrap,
    /// From outlines whose points were drawn anew from the measured ones.
    CaseBootstrap,
}

impl Kind {
    /// As the command line and tables name it.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Standard => "standard",
            Kind::Profile => "profile",
            Kind::Bootstrap => "bootstrap",
            Kind::CaseBootstrap => "case-bootstrap",
        }
    }
}

/// One end of an interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    At(f64),
    /// The quantity can go no further (q ≥ 0), and the data do not exclude that it does.
    Bound(f64),
    /// The data exclude nothing on this side, as far as was looked.
    Open,
    /// The likelihood could not be followed to where it falls to its cut-off: the other unknowns ceased to be determined on the way.
    Lost,
}

impl End {
    /// Where the interval ends, if it does.
    pub fn value(self) -> Option<f64> {
        match self {
            End::At(value) | End::Bound(value) => Some(value),
            End::Open | End::Lost => None,
        }
    }
}

/// An interval, in the unit of its quantity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    pub low: End,
    pub high: End,
}

impl Interval {
    /// Whether `value` lies in it; an open side excludes nothing.
    pub fn covers(&self, value: f64) -> bool {
        self.low.value().is_none_or(|low| low <= value) && self.high.value().is_none_or(|high| value <= high)
    }
}

/// Intervals of one fit at one level. A quantity without one has its reason in [`HemFit::standard_error_missing`](super::HemFit::standard_error_missing).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Intervals {
    pub kind: Kind,
    /// Confidence level, 0…1.
    pub level: f64,
    /// m.
    pub p: Option<Interval>,
    pub q: Option<Interval>,
    pub s: Option<Interval>,
    /// rad; its ends may lie beyond 0 and 2π/m, where the phase itself is counted.
    pub phase: Option<Interval>,
    /// Of bootstraps only.
    pub replicates: Option<Replicates>,
}

/// What a bootstrap was made of, and what else it found. Arrays are in the order p, q, s (m), phase (rad).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Replicates {
    pub asked: usize,
    /// Those that could not be fitted, and are left out.
    pub failed: usize,
    pub seed: u64,
    /// Standard deviation over the replicates.
    pub standard_errors: [Option<f64>; 4],
    /// Percentile intervals; those of [`Intervals`] are bias-corrected and accelerated.
    pub percentile: [Option<Interval>; 4],
}
