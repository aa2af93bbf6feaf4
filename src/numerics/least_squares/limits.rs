//! Bounds and fixed values of parameters.

use serde::Serialize;

use crate::error::Error;

/// What a parameter may do.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    #[default]
    Free,
    /// Held at this value.
    At(f64),
    /// Kept within `low..=high`; an infinite end is no bound.
    Between(f64, f64),
}

impl Limit {
    /// Least and greatest value allowed.
    pub fn range(self) -> (f64, f64) {
        match self {
            Limit::Free => (f64::NEG_INFINITY, f64::INFINITY),
            Limit::At(value) => (value, value),
            Limit::Between(low, high) => (low, high),
        }
    }

    /// The same limit in other units; `to` must be increasing.
    pub fn map(self, to: impl Fn(f64) -> f64) -> Limit {
        match self {
            Limit::Free => Limit::Free,
            Limit::At(value) => Limit::At(to(value)),
            Limit::Between(low, high) => Limit::Between(to(low), to(high)),
        }
    }

    /// The allowed value nearest to `value`.
    pub fn nearest(self, value: f64) -> f64 {
        let (low, high) = self.range();
        value.max(low).min(high)
    }

    /// Checks that some number is allowed; `name` is that of the parameter.
    ///
    /// # Errors
    /// [`Error::Unanswerable`] if a fixed value is not finite, a bound is not a number, or the lower bound is not below the upper one.
    pub fn check(self, name: &str) -> Result<(), Error> {
        match self {
            Limit::At(value) if !value.is_finite() => {
                Err(Error::Unanswerable(format!("{name} is fixed at {value}; a fixed value is a finite number")))
            }
            Limit::Between(low, high) if !(low < high && low < f64::INFINITY && f64::NEG_INFINITY < high) => Err(Error::Unanswerable(
                format!("{name} is bounded by {low} and {high}; the lower bound must be below the upper one (to hold a value, fix it)"),
            )),
            _ => Ok(()),
        }
    }
}

/// What became of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Estimated from the residuals.
    Free,
    /// Held at the value asked for.
    Fixed,
    /// At its lower bound, and the sum of squares would fall beyond it.
    AtLower,
    /// At its upper bound, and the sum of squares would fall beyond it.
    AtUpper,
}

/// The limits of all parameters of a problem.
pub(super) struct Bounds {
    low: Vec<f64>,
    high: Vec<f64>,
    limited: bool,
}

impl Bounds {
    /// `limits` is empty (no parameter is limited) or has one entry for each parameter.
    pub(super) fn new(limits: &[Limit], columns: usize) -> Result<Bounds, Error> {
        if !limits.is_empty() && limits.len() != columns {
            return Err(Error::Unanswerable(format!("{} limits for {columns} parameters; one for each, or none", limits.len())));
        }
        for (j, limit) in limits.iter().enumerate() {
            limit.check(&format!("parameter {}", j + 1))?;
        }
        let range = |j: usize| limits.get(j).map_or(Limit::Free.range(), |limit| limit.range());
        let limited = limits.iter().any(|limit| *limit != Limit::Free);
        Ok(Bounds { low: (0..columns).map(|j| range(j).0).collect(), high: (0..columns).map(|j| range(j).1).collect(), limited })
    }

    pub(super) fn limited(&self) -> bool {
        self.limited
    }

    pub(super) fn fixed(&self, j: usize) -> bool {
        self.low[j] == self.high[j]
    }

    /// Moves `x` to the nearest allowed point.
    pub(super) fn clamp(&self, x: &mut [f64]) {
        for (j, x) in x.iter_mut().enumerate() {
            *x = x.max(self.low[j]).min(self.high[j]);
        }
    }

    /// The bound that `value` of parameter `j` is beyond or on, if any.
    pub(super) fn crossed(&self, j: usize, value: f64) -> Option<f64> {
        if value < self.low[j] {
            Some(self.low[j])
        } else if self.high[j] < value {
            Some(self.high[j])
        } else {
            None
        }
    }

    /// What parameter `j` at `value` is doing where the sum of squares has this slope by it.
    pub(super) fn state(&self, j: usize, value: f64, slope: f64) -> State {
        if self.fixed(j) {
            State::Fixed
        } else if value <= self.low[j] && 0.0 < slope {
            State::AtLower
        } else if self.high[j] <= value && slope < 0.0 {
            State::AtUpper
        } else {
            State::Free
        }
    }

    /// Whether `value` of parameter `j` lies strictly between its bounds.
    pub(super) fn inside(&self, j: usize, value: f64) -> bool {
        self.low[j] < value && value < self.high[j]
    }
}
