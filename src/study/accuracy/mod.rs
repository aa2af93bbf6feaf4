//! What accuracy costs in time: work and precision of everything that has a knob.
//!
//! One panel is one problem: its rows have the same reference and can be set against each other. Errors are those of the profile. Failures stay in.

pub mod apart;
mod bootstrap;
mod fit;
pub mod front;
pub mod picture;
mod theory;

use serde::Serialize;

use self::apart::Apart;
use self::picture::Trace;
use super::clock::Clock;
use crate::error::Error;

/// How deep to look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Depth {
    /// Every sweep, few of its settings, timed once: seconds. For tests.
    Quick,
    /// A minute on two cores.
    Usual,
    /// Finer sweeps, more draws: ten minutes.
    Full,
}

/// What to study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    pub depth: Depth,
    /// Of everything that is drawn.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Options { depth: Depth::Usual, seed: 1 }
    }
}

/// In which measure an accuracy was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    Rms,
    Max,
}

/// Accuracy that was asked for in metres of the profile, and what the method promises of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Asked {
    /// m.
    pub error: f64,
    pub measure: Measure,
    /// The error is at most this many times what was asked …
    pub slack: f64,
    /// … and the rounding of the numbers themselves, m.
    pub rounding: f64,
}

/// One computation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    pub method: String,
    pub knob: &'static str,
    pub setting: f64,
    pub asked: Option<Asked>,
    /// Of the profile, m; `None` where there is no result.
    pub error: Option<Apart>,
    pub seconds: f64,
    /// In [`Panel::unit`]; `None` where nothing is counted.
    pub evaluations: Option<usize>,
    /// `converged` …; of a failure its reason.
    pub termination: String,
    /// Whether it says that it did what was asked: only then is the accuracy promised.
    pub claims: bool,
    /// Whether this is what the program does unless told.
    pub default: bool,
}

impl Row {
    /// Whether what was asked was delivered; `None` where nothing was asked, or the method said that it did not do it.
    pub fn delivered(&self) -> Option<bool> {
        let asked = self.asked.filter(|_| self.claims)?;
        let error = self.error.map(|error| match asked.measure {
            Measure::Rms => error.rms,
            Measure::Max => error.max,
        });
        Some(error.is_some_and(|error| error <= asked.slack * asked.error + asked.rounding))
    }
}

/// One problem, solved in many ways.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Panel {
    /// `fit_tolerance` …
    pub name: &'static str,
    pub title: &'static str,
    /// What the error is measured against.
    pub reference: String,
    /// What an evaluation is.
    pub unit: &'static str,
    pub rows: Vec<Row>,
}

/// The whole study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AccuracyStudy {
    pub options: Settings,
    pub panels: Vec<Panel>,
}

/// What was asked, as it is written beside results.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Settings {
    pub depth: Depth,
    pub seed: u64,
}

/// A panel to be computed.
type Task<'a> = Box<dyn Fn(&Setup<'_>) -> Result<Panel, Error> + 'a>;

/// What every panel is told.
struct Setup<'a> {
    options: Options,
    clock: Clock,
    told: &'a dyn Fn(Progress),
}

/// How far the study is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// The next panel has begun, of so many in all.
    Panel(&'static str, usize),
    /// One more computation of it has been timed.
    Computed,
}

impl Setup<'_> {
    /// What `compute` returns, and its seconds.
    fn time<T>(&self, compute: impl Fn() -> T) -> (T, f64) {
        let timed = self.clock.time(compute);
        (self.told)(Progress::Computed);
        timed
    }

    /// One of three by the depth.
    fn pick<T>(&self, quick: T, usual: T, full: T) -> T {
        match self.options.depth {
            Depth::Quick => quick,
            Depth::Usual => usual,
            Depth::Full => full,
        }
    }
}

/// Computes every panel, one after the other so that none disturbs another's time; `told` hears how far it is.
///
/// `trace` finds the outline in a picture: pictures are no matter of this layer.
///
/// # Errors
/// Of the reference solutions; a method that fails is a row.
pub fn study(options: &Options, trace: &Trace, told: &dyn Fn(Progress)) -> Result<AccuracyStudy, Error> {
    let setup = Setup { options: *options, clock: Clock::of(options.depth), told };
    let tasks: Vec<(&'static str, Task)> = vec![
        ("fit: tolerance", Box::new(fit::tolerance)),
        ("fit: points", Box::new(fit::points)),
        ("fit: losses", Box::new(fit::losses)),
        ("bootstrap", Box::new(bootstrap::replicates)),
        ("ruled shell", Box::new(theory::ruled)),
        ("quadrature", Box::new(theory::nodes)),
        ("equation (4)", Box::new(theory::polar)),
        ("graded shell", Box::new(theory::graded)),
        ("search for folds", Box::new(theory::search)),
        ("tracing", Box::new(move |setup: &Setup<'_>| picture::resolution(setup, trace))),
    ];
    let count = tasks.len();
    let mut panels = Vec::with_capacity(count);
    for (name, task) in tasks {
        told(Progress::Panel(name, count));
        panels.push(task(&setup)?);
    }
    Ok(AccuracyStudy { options: Settings { depth: options.depth, seed: options.seed }, panels })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_beyond_what_was_asked_and_claimed_is_not_delivered() {
        let row = |error: f64, claims: bool| Row {
            method: "a".into(),
            knob: "tolerance",
            setting: 1.0,
            asked: Some(Asked { error: 1e-3, measure: Measure::Rms, slack: 2.0, rounding: 1e-12 }),
            error: Some(Apart { rms: error, max: 10.0 * error }),
            seconds: 1.0,
            evaluations: None,
            termination: String::new(),
            claims,
            default: false,
        };
        assert_eq!((row(1.9e-3, true).delivered(), row(2.1e-3, true).delivered()), (Some(true), Some(false)));
        // Who says that it did not get there has promised nothing.
        assert_eq!(row(2.1e-3, false).delivered(), None);
    }
}
