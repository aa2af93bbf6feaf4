//! How far the program can be trusted: the catalogue of hard cases, each at growing severity up to breakdown.

use rayon::prelude::*;
use serde::Serialize;

use super::accuracy::{Depth, Options, Settings};
use super::hard_cases::{Answer, Case, Outcome, SEVERITIES, Subject, catalogue};

/// A case at one severity: the worst of its draws.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    pub severity: f64,
    /// The worst outcome of all draws, and what was said there.
    pub outcome: Outcome,
    pub said: String,
    /// The fewest digits kept.
    pub digits: Option<f64>,
    /// The most that was promised of any draw.
    pub promised: Option<f64>,
    /// The largest.
    pub condition: Option<f64>,
    /// Of all draws.
    pub evaluations: Option<usize>,
    pub draws: usize,
}

/// A row of the heat map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseStudy {
    pub subject: Subject,
    pub name: &'static str,
    pub title: &'static str,
    pub reference: &'static str,
    pub cells: Vec<Cell>,
}

/// The whole study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StabilityStudy {
    pub options: Settings,
    pub cases: Vec<CaseStudy>,
}

impl StabilityStudy {
    /// Every cell that was wrong without saying, with its case.
    pub fn wrong(&self) -> impl Iterator<Item = (&CaseStudy, &Cell)> {
        let cells = self.cases.iter().flat_map(|case| case.cells.iter().map(move |cell| (case, cell)));
        cells.filter(|(_, cell)| cell.outcome == Outcome::Wrong)
    }
}

/// How many times a case is drawn: only outlines are.
fn draws(case: &Case, depth: Depth) -> u64 {
    match (case.subject, depth) {
        (Subject::Fit, Depth::Full) => 30,
        (Subject::Fit, Depth::Usual) => 5,
        _ => 1,
    }
}

/// How many computations a study has.
pub fn computation_count(depth: Depth) -> usize {
    catalogue().iter().map(|case| draws(case, depth) as usize * SEVERITIES).sum()
}

/// Runs the catalogue on all cores; `done` is called once for each computation. The result depends on depth and seed alone.
pub fn study(options: &Options, done: &(dyn Fn() + Sync)) -> StabilityStudy {
    let cases = catalogue();
    let cells: Vec<Cell> = (0..cases.len() * SEVERITIES)
        .into_par_iter()
        .map(|i| {
            let (case, severity) = (&cases[i / SEVERITIES], cases[i / SEVERITIES].severities[i % SEVERITIES]);
            cell(case, severity, options, done)
        })
        .collect();
    let cases = cases.iter().zip(cells.chunks(SEVERITIES)).map(|(case, cells)| CaseStudy {
        subject: case.subject,
        name: case.name,
        title: case.title,
        reference: case.reference,
        cells: cells.to_vec(),
    });
    StabilityStudy { options: Settings { depth: options.depth, seed: options.seed }, cases: cases.collect() }
}

fn cell(case: &Case, severity: f64, options: &Options, done: &(dyn Fn() + Sync)) -> Cell {
    let one = |k: u64| {
        let answer = (case.run)(severity, options.seed.wrapping_mul(1000).wrapping_add(k));
        done();
        answer
    };
    let answers: Vec<Answer> = (0..draws(case, options.depth)).map(one).collect();
    let worst = answers.iter().fold(&answers[0], |worst, answer| if worst.outcome < answer.outcome { answer } else { worst });
    let least = |pick: fn(&Answer) -> Option<f64>| answers.iter().filter_map(pick).reduce(f64::min);
    let most = |pick: fn(&Answer) -> Option<f64>| answers.iter().filter_map(pick).reduce(f64::max);
    Cell {
        severity,
        outcome: worst.outcome,
        said: worst.said.clone(),
        digits: least(|a| a.digits),
        promised: most(|a| a.promised),
        condition: most(|a| a.condition),
        evaluations: answers.iter().map(|a| a.evaluations).sum(),
        draws: answers.len(),
    }
}
