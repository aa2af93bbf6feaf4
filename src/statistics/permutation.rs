//! How often chance alone would show as large an effect, without a normal law: permutation p-values beside the t tests.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::Serialize;

use crate::error::Error;
use crate::statistics::factorial::FactorialDesign;
use crate::statistics::linear_model::Decomposition;

/// How many arrangements to look at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// All arrangements are taken if there are no more than this: 300 000 take a fraction of a second.
    pub most_exact: u64,
    /// Random ones otherwise: 9 999 give p = 0.05 a standard error of 0.002.
    pub draws: u32,
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Options { most_exact: 300_000, draws: 9_999, seed: 1 }
    }
}

/// The p-value of one term.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PermutationTest {
    pub term: String,
    pub p: f64,
    /// Monte-Carlo error of p; `None` if all arrangements were taken.
    pub p_standard_error: Option<f64>,
    /// Arrangements looked at.
    pub arrangements: u64,
}

/// Two-sided permutation tests of all terms but the constant (which no rearrangement of runs can test); aliased terms are left out.
///
/// Residuals of the model without the term are rearranged over the runs (within blocks, if there are any) and |t| of the term is compared. For
/// one factor this is the exact two-sample test; with other terms present its level is exact only asymptotically, because residuals of a fitted
/// model are not exchangeable to the last.
///
/// Source: Freedman & Lane, J. Bus. Econ. Stat. 1 (1983) 292–298; Winkler et al., NeuroImage 92 (2014) 381–397. The random p-value counts the
/// arrangement at hand: Phipson & Smyth, Stat. Appl. Genet. Mol. Biol. 9 (2010) 39.
///
/// # Errors
/// [`Error::Unanswerable`] if responses do not match the runs or are not finite.
pub fn permutation_tests(design: &FactorialDesign, response: &[Option<f64>], options: &Options) -> Result<Vec<PermutationTest>, Error> {
    if response.len() != design.runs() {
        return Err(Error::Unanswerable(format!("{} responses for {} runs", response.len(), design.runs())));
    }
    let used: Vec<usize> = (0..response.len()).filter(|&run| response[run].is_some()).collect();
    if used.is_empty() {
        return Err(Error::Unanswerable("no run has a response".into()));
    }
    let design = design.subset(&used);
    let y: Vec<f64> = response.iter().copied().flatten().collect();
    let terms = design.term_factors();
    let full = design.regressors_of(&terms, design.has_centre())?.decompose();
    let model = full.fit(&y)?;
    let space = Space::new(&full, &design);
    let known: Vec<String> = full.terms().map(String::from).collect();
    let mut tests = Vec::new();
    for (index, term) in terms.iter().enumerate().skip(1).filter(|(_, term)| known.contains(&design.term_name(term))) {
        // The direction that only this term explains, of unit length; without the term the fit differs by its share along it.
        let others: Vec<Vec<usize>> = terms.iter().filter(|other| *other != term).cloned().collect();
        let column = design.column(term);
        let reduced = design.regressors_of(&others, design.has_centre())?.decompose().fit(&column)?;
        let length = reduced.residual_sum_of_squares.sqrt();
        let direction: Vec<f64> = reduced.residuals.iter().map(|e| e / length).collect();
        let share = inner(&direction, &y);
        let residuals: Vec<f64> = model.residuals.iter().zip(&direction).map(|(e, z)| e + share * z).collect();
        let statistic = |arranged: &[f64]| -> f64 {
            let explained = inner(&direction, arranged).powi(2);
            if model.residual_df == 0 {
                return explained;
            }
            let all: f64 = inner(arranged, arranged);
            let left = all - space.explained(arranged);
            // t² up to a factor; where nothing is left the term explains everything.
            if left > 1e-12 * all { explained / left } else { f64::INFINITY }
        };
        let observed = statistic(&residuals);
        // Equal statistics of different arrangements differ by rounding.
        let threshold = observed * (1.0 - 1e-9);
        let name = design.term_name(term);
        tests.push(match arrangements(&design).filter(|count| *count <= options.most_exact) {
            Some(count) => {
                let mut hits = 0_u64;
                each_arrangement(&design, &residuals, |arranged| hits += u64::from(statistic(arranged) >= threshold));
                PermutationTest { term: name, p: hits as f64 / count as f64, p_standard_error: None, arrangements: count }
            }
            None => {
                let mut random = ChaCha8Rng::seed_from_u64(options.seed);
                random.set_stream(index as u64);
                let groups = block_groups(&design);
                let mut arranged = residuals.clone();
                let mut hits = 1_u64;
                for _ in 0..options.draws {
                    groups.iter().for_each(|group| shuffle(&mut arranged, group, &mut random));
                    hits += u64::from(statistic(&arranged) >= threshold);
                }
                let total = u64::from(options.draws) + 1;
                let p = hits as f64 / total as f64;
                PermutationTest { term: name, p, p_standard_error: Some((p * (1.0 - p) / total as f64).sqrt()), arrangements: total }
            }
        });
    }
    Ok(tests)
}

/// What the full model can explain.
enum Space {
    /// Any combination of cell means, because there are as many coefficients as cells: then cell sums are enough, at a fraction of the cost.
    Cells(Vec<Vec<usize>>),
    Basis(Vec<Vec<f64>>),
}

impl Space {
    fn new(full: &Decomposition, design: &FactorialDesign) -> Self {
        let cells: Vec<Vec<usize>> = design.cells().into_iter().map(|cell| cell.runs).collect();
        if full.rank() == cells.len() && design.block_names().is_empty() { Space::Cells(cells) } else { Space::Basis(full.basis()) }
    }

    /// Squared length of the projection.
    fn explained(&self, values: &[f64]) -> f64 {
        match self {
            Space::Cells(cells) => {
                cells.iter().map(|runs| runs.iter().map(|&run| values[run]).sum::<f64>().powi(2) / runs.len() as f64).sum()
            }
            Space::Basis(basis) => basis.iter().map(|q| inner(q, values).powi(2)).sum(),
        }
    }
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Number of ways to deal the runs to the cells; `None` if it exceeds 10¹⁵ or there are blocks (then only random ones are drawn).
fn arrangements(design: &FactorialDesign) -> Option<u64> {
    if !design.block_names().is_empty() {
        return None;
    }
    let mut count: u64 = 1;
    let mut placed: u64 = 0;
    for cell in design.cells() {
        for own in 1..=cell.runs.len() as u64 {
            placed += 1;
            // A binomial coefficient built factor by factor stays an integer.
            count = count.checked_mul(placed)? / own;
            if count > 1_000_000_000_000_000 {
                return None;
            }
        }
    }
    Some(count)
}

/// Calls `visit` with the values in every way to deal them to the cells, once each.
fn each_arrangement(design: &FactorialDesign, values: &[f64], mut visit: impl FnMut(&[f64])) {
    let cells = design.cells();
    // labels[i] is the cell that value i goes to; lexicographic order of a multiset runs through all dealings.
    let mut labels: Vec<usize> = cells.iter().enumerate().flat_map(|(index, cell)| vec![index; cell.runs.len()]).collect();
    let mut arranged = vec![0.0; values.len()];
    loop {
        let mut taken = vec![0; cells.len()];
        for (&label, &value) in labels.iter().zip(values) {
            arranged[cells[label].runs[taken[label]]] = value;
            taken[label] += 1;
        }
        visit(&arranged);
        let Some(fall) = (1..labels.len()).rev().find(|&i| labels[i - 1] < labels[i]) else { return };
        if let Some(swap) = (fall..labels.len()).rev().find(|&i| labels[i] > labels[fall - 1]) {
            labels.swap(fall - 1, swap);
        }
        labels[fall..].reverse();
    }
}

/// Runs that may change places.
fn block_groups(design: &FactorialDesign) -> Vec<Vec<usize>> {
    let names = design.block_names();
    if names.is_empty() {
        return vec![(0..design.runs()).collect()];
    }
    names.iter().map(|name| (0..design.runs()).filter(|&run| design.block(run) == Some(name.as_str())).collect()).collect()
}

/// Fisher–Yates on the places of `group`.
fn shuffle(values: &mut [f64], group: &[usize], random: &mut ChaCha8Rng) {
    for last in (1..group.len()).rev() {
        let other = below(last as u64 + 1, random) as usize;
        values.swap(group[last], group[other]);
    }
}

/// Uniform integer in 0..bound by rejection, so that the sequence depends on the generator alone.
fn below(bound: u64, random: &mut ChaCha8Rng) -> u64 {
    let limit = u64::MAX - u64::MAX % bound;
    loop {
        let draw = random.next_u64();
        if draw < limit {
            return draw % bound;
        }
    }
}
