//! How often chance alone would show as large an effect, without a normal law: permutation p-values beside the t tests.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::Serialize;

use crate::error::Error;
use crate::numerics::lanes::{Lanes, WIDTH};
use crate::statistics::factorial::FactorialDesign;
use crate::statistics::linear_model::{Decomposition, LinearModel};
use crate::vectorized;

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
    tests_of_all(design, &[response], options).remove(0)
}

/// The tests of several responses of one design, as [`permutation_tests`] has them one by one: those of the same runs share their arrangements.
pub fn tests_of_all(design: &FactorialDesign, responses: &[&[Option<f64>]], options: &Options) -> Vec<Result<Vec<PermutationTest>, Error>> {
    let mut tests: Vec<Option<Result<Vec<PermutationTest>, Error>>> = responses.iter().map(|_| None).collect();
    let used: Vec<Vec<usize>> =
        responses.iter().map(|response| (0..response.len()).filter(|&run| response[run].is_some()).collect()).collect();
    for first in 0..responses.len() {
        if tests[first].is_some() {
            continue;
        }
        let alike =
            |&other: &usize| tests[other].is_none() && responses[other].len() == responses[first].len() && used[other] == used[first];
        let group: Vec<usize> = (first..responses.len()).filter(alike).take(WIDTH).collect();
        let values: Vec<Vec<f64>> = group.iter().map(|&i| responses[i].iter().copied().flatten().collect()).collect();
        match of_eight(design, responses[first].len(), &used[first], &values, options) {
            Ok(found) => group.iter().zip(found).for_each(|(&i, found)| tests[i] = Some(Ok(found))),
            Err(error) if group.len() == 1 => tests[first] = Some(Err(error)),
            // One that cannot be tested must not spoil the others.
            Err(_) => group.iter().for_each(|&i| tests[i] = Some(permutation_tests(design, responses[i], options))),
        }
    }
    tests.into_iter().map(|tests| tests.expect("each has been in a group")).collect()
}

/// The tests of up to eight responses of the same runs.
fn of_eight(
    design: &FactorialDesign,
    runs: usize,
    used: &[usize],
    responses: &[Vec<f64>],
    options: &Options,
) -> Result<Vec<Vec<PermutationTest>>, Error> {
    if runs != design.runs() {
        return Err(Error::Unanswerable(format!("{runs} responses for {} runs", design.runs())));
    }
    if used.is_empty() {
        return Err(Error::Unanswerable("no run has a response".into()));
    }
    let design = design.subset(used);
    let terms = design.term_factors();
    let full = design.regressors_of(&terms, design.has_centre())?.decompose();
    let models = responses.iter().map(|y| full.fit(y)).collect::<Result<Vec<LinearModel>, Error>>()?;
    let space = Space::new(&full, &design);
    let known: Vec<String> = full.terms().map(String::from).collect();
    let mut tests = vec![Vec::new(); responses.len()];
    for (index, term) in terms.iter().enumerate().skip(1).filter(|(_, term)| known.contains(&design.term_name(term))) {
        // The direction that only this term explains, of unit length; without the term the fit differs by its share along it.
        let others: Vec<Vec<usize>> = terms.iter().filter(|other| *other != term).cloned().collect();
        let column = design.column(term);
        let reduced = design.regressors_of(&others, design.has_centre())?.decompose().fit(&column)?;
        let length = reduced.residual_sum_of_squares.sqrt();
        let direction: Vec<f64> = reduced.residuals.iter().map(|e| e / length).collect();
        let mut residuals = vec![Lanes::ZERO; used.len()];
        for (lane, (model, y)) in models.iter().zip(responses).enumerate() {
            let share = inner(&direction, y);
            let without = model.residuals.iter().zip(&direction).map(|(e, z)| e + share * z);
            residuals.iter_mut().zip(without).for_each(|(eight, value)| eight.0[lane] = value);
        }
        let question = Question { residuals, direction, space: &space, saturated: models[0].residual_df == 0 };
        let identity: Vec<usize> = (0..used.len()).collect();
        // Equal statistics of different arrangements differ by rounding.
        let threshold = Lanes(statistics(&question, &identity).0.map(|observed| observed * (1.0 - 1e-9)));
        let mut hits = [0_u64; WIDTH];
        let mut count = |order: &[usize]| {
            let found = statistics(&question, order);
            hits.iter_mut().zip(found.0.iter().zip(&threshold.0)).for_each(|(hits, (found, least))| *hits += u64::from(found >= least));
        };
        let exact = arrangements(&design).filter(|count| *count <= options.most_exact);
        let total = match exact {
            Some(total) => {
                each_arrangement(&design, &mut count);
                total
            }
            None => {
                let mut random = ChaCha8Rng::seed_from_u64(options.seed);
                random.set_stream(index as u64);
                let groups: Vec<Group> = block_groups(&design).into_iter().map(Group::new).collect();
                let mut order = identity;
                for _ in 0..options.draws {
                    groups.iter().for_each(|group| group.shuffle(&mut order, &mut random));
                    count(&order);
                }
                // The arrangement at hand counts.
                hits.iter_mut().for_each(|hits| *hits += 1);
                u64::from(options.draws) + 1
            }
        };
        for (tests, hits) in tests.iter_mut().zip(hits) {
            let p = hits as f64 / total as f64;
            let p_standard_error = exact.is_none().then(|| (p * (1.0 - p) / total as f64).sqrt());
            tests.push(PermutationTest { term: design.term_name(term), p, p_standard_error, arrangements: total });
        }
    }
    Ok(tests)
}

/// What is asked of every arrangement of the residuals of eight responses.
struct Question<'a> {
    /// Run by run, one lane for each response.
    residuals: Vec<Lanes>,
    direction: Vec<f64>,
    space: &'a Space,
    /// Whether the full model leaves nothing.
    saturated: bool,
}

vectorized! {
    /// t² up to a factor, of each response with the residual of run `order[i]` at run i; where nothing is left the term explains everything.
    fn statistics<V>(question: &Question<'_>, order: &[usize]) -> Lanes {
        let (mut along, mut all) = (V::zero(), V::zero());
        for (&run, z) in order.iter().zip(&question.direction) {
            let value = V::of(&question.residuals[run]);
            (along, all) = (along + value * *z, all + value * value);
        }
        let explained = along * along;
        if question.saturated {
            return explained.lanes();
        }
        let mut by_all = V::zero();
        match question.space {
            Space::Cells(cells) => {
                for runs in cells {
                    let mut sum = V::zero();
                    for &run in runs {
                        sum = sum + V::of(&question.residuals[order[run]]);
                    }
                    by_all = by_all + sum * sum / V::all(runs.len() as f64);
                }
            }
            Space::Basis(basis) => {
                for column in basis {
                    let mut sum = V::zero();
                    for (&run, q) in order.iter().zip(column) {
                        sum = sum + V::of(&question.residuals[run]) * *q;
                    }
                    by_all = by_all + sum * sum;
                }
            }
        }
        let left = all - by_all;
        V::choose(all * 1e-12, left, explained / left, V::all(f64::INFINITY)).lanes()
    }
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

/// Calls `visit` with every way to deal the runs' values to the cells, once each: at each run the index of the value that it gets.
fn each_arrangement(design: &FactorialDesign, mut visit: impl FnMut(&[usize])) {
    let cells = design.cells();
    // labels[i] is the cell that value i goes to; lexicographic order of a multiset runs through all dealings.
    let mut labels: Vec<usize> = cells.iter().enumerate().flat_map(|(index, cell)| vec![index; cell.runs.len()]).collect();
    let mut order = vec![0; labels.len()];
    loop {
        let mut taken = vec![0; cells.len()];
        for (value, &label) in labels.iter().enumerate() {
            order[cells[label].runs[taken[label]]] = value;
            taken[label] += 1;
        }
        visit(&order);
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

/// Runs that may change places, with what drawing from so many needs.
struct Group {
    runs: Vec<usize>,
    /// For 1 … as many as there are runs.
    bounds: Vec<Bound>,
}

impl Group {
    fn new(runs: Vec<usize>) -> Self {
        let bounds = (1..=runs.len() as u64).map(Bound::new).collect();
        Group { runs, bounds }
    }

    /// Fisher–Yates.
    fn shuffle(&self, order: &mut [usize], random: &mut ChaCha8Rng) {
        for last in (1..self.runs.len()).rev() {
            order.swap(self.runs[last], self.runs[self.bounds[last].draw(random) as usize]);
        }
    }
}

/// Uniform integers in 0..bound by rejection, so that the sequence depends on the generator alone.
struct Bound {
    bound: u64,
    /// Greater draws are rejected.
    limit: u64,
    /// 2⁶⁴ over the bound, or one less.
    inverse: u64,
}

impl Bound {
    fn new(bound: u64) -> Self {
        Bound { bound, limit: u64::MAX - u64::MAX % bound, inverse: u64::MAX / bound }
    }

    fn draw(&self, random: &mut ChaCha8Rng) -> u64 {
        loop {
            let draw = random.next_u64();
            if draw < self.limit {
                return self.remainder(draw);
            }
        }
    }

    /// `draw % bound`, by a product instead of a division.
    fn remainder(&self, draw: u64) -> u64 {
        let quotient = ((u128::from(draw) * u128::from(self.inverse)) >> 64) as u64;
        let mut rest = draw - quotient * self.bound;
        // The inverse is too small by less than one, so the quotient is by less than two.
        while self.bound <= rest {
            rest -= self.bound;
        }
        rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::factorial::Axis;

    #[test]
    fn remainders_are_those_of_division() {
        for bound in (1..200).chain([1 << 33, u64::MAX - 5, u64::MAX]) {
            let near = (0..8)
                .flat_map(|i: u64| [i, bound.wrapping_add(i).wrapping_sub(4), u64::MAX - i, (u64::MAX / bound * bound).wrapping_sub(i)]);
            for draw in near.chain((0..100).map(|i| 0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(i))) {
                assert_eq!(Bound::new(bound).remainder(draw), draw % bound, "{draw} % {bound}");
            }
        }
    }

    #[test]
    fn tests_of_several_responses_are_those_of_each_alone() {
        let levels = (0..12).map(|run| vec![[-1.0, 1.0][run & 1], [-1.0, 1.0][run >> 1 & 1]]).collect();
        let design = FactorialDesign::new(vec![Axis::coded("a"), Axis::coded("b")], levels).unwrap();
        let response = |seed: usize| -> Vec<Option<f64>> {
            (0..12).map(|run| Some(((run + 1) * (seed + 3) * 7919 % 101) as f64 + 20.0 * design.levels()[run][0])).collect()
        };
        let mut responses: Vec<Vec<Option<f64>>> = (0..11).map(response).collect();
        // Missing runs, a wrong length, and a number that is none.
        (responses[2][5], responses[4][5], responses[7][0]) = (None, None, Some(f64::NAN));
        responses[9].pop();
        for most_exact in [1_000_000, 100] {
            let options = Options { most_exact, draws: 400, seed: 3 };
            let together = tests_of_all(&design, &responses.iter().map(Vec::as_slice).collect::<Vec<_>>(), &options);
            for (i, (response, found)) in responses.iter().zip(together).enumerate() {
                let alone = permutation_tests(&design, response, &options);
                assert_eq!(found.is_ok(), i != 7 && i != 9);
                assert_eq!(found.map_err(|e| e.to_string()), alone.map_err(|e| e.to_string()), "response {i}");
            }
        }
    }
}
