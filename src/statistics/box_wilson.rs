//! The Box–Wilson analysis of one response over a two-level factorial: reproducibility, coefficients, adequacy.

use serde::Serialize;

/// One coefficient of the full factorial model in coded units.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coefficient {
    /// `1`, `a`, `a:b` …
    pub term: String,
    pub estimate: f64,
    /// `None` when there is nothing to estimate an error from.
    pub se: Option<f64>,
    pub t: Option<f64>,
    pub p: Option<f64>,
    pub ci_low: Option<f64>,
    pub ci_high: Option<f64>,
    /// Holm-adjusted over the whole family of responses and terms, once that family is known.
    pub p_holm: Option<f64>,
    /// |b| > t·s_b at the asked level.
    pub significant: bool,
}

/// One test: its statistic beside its critical value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// `Cochran G`, `Brown–Forsythe F`, `Fisher F` …
    pub test: String,
    pub statistic: f64,
    pub critical: f64,
    /// Degrees of freedom, numerator and denominator.
    pub df: (f64, f64),
    pub p: Option<f64>,
    /// The hypothesis (equal variances, adequate model) is not rejected.
    pub holds: bool,
}
