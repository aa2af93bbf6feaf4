//! A two-level design in coded units: its runs, its cells, its interaction columns.

use serde::Serialize;

use crate::error::Error;
use crate::numerics::double_double::DoubleDouble;
use crate::statistics::linear_model::Regressors;

/// 2⁶ = 64 cells is the largest full factorial a laboratory replicates; more factors want a fraction and another analysis.
pub const MOST_FACTORS: usize = 6;

/// One factor: its name and the natural levels at coded −1 and +1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    pub name: String,
    pub low: f64,
    pub high: f64,
}

impl Axis {
    /// A factor that is known in coded units only.
    pub fn coded(name: impl Into<String>) -> Self {
        Axis { name: name.into(), low: -1.0, high: 1.0 }
    }

    pub fn centre(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// The interval of variation: natural units per coded unit.
    pub fn interval(&self) -> f64 {
        0.5 * (self.high - self.low)
    }
}

/// Which runs were done where; checked once.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FactorialDesign {
    factors: Vec<Axis>,
    /// `levels[run][factor]`, coded.
    levels: Vec<Vec<f64>>,
    blocks: Option<Vec<String>>,
}

/// The runs that share one treatment.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// Coded, one per factor.
    pub levels: Vec<f64>,
    /// Indices of its runs, ascending.
    pub runs: Vec<usize>,
}

impl Cell {
    /// All factors at coded 0.
    pub fn is_centre(&self) -> bool {
        is_centre(&self.levels)
    }
}

impl FactorialDesign {
    /// `levels[run][factor]` in coded units: ±1 at a corner, all 0 at the centre; anything else enters as the number it is.
    ///
    /// # Errors
    /// [`Error::Unanswerable`] without runs, with no factor or more than [`MOST_FACTORS`], with a name given twice, a natural interval of
    /// zero, a run of another length, or a level that is not finite.
    pub fn new(factors: Vec<Axis>, mut levels: Vec<Vec<f64>>) -> Result<Self, Error> {
        if factors.is_empty() || factors.len() > MOST_FACTORS {
            return Err(Error::Unanswerable(format!("{} factors; a full factorial takes 1 to {MOST_FACTORS}", factors.len())));
        }
        for (i, factor) in factors.iter().enumerate() {
            if factor.name.is_empty()
                || factor.name == "1"
                || factor.name.contains(':')
                || factors[..i].iter().any(|f| f.name == factor.name)
            {
                return Err(Error::Unanswerable(format!("factor name “{}” is empty, given twice, “1” or contains “:”", factor.name)));
            }
            if !(factor.interval().is_finite() && factor.interval() != 0.0) {
                return Err(Error::Unanswerable(format!(
                    "factor “{}” has levels {} and {}; a factor needs two different ones",
                    factor.name, factor.low, factor.high
                )));
            }
        }
        if levels.is_empty() {
            return Err(Error::Unanswerable("a design without runs".into()));
        }
        for (run, row) in levels.iter_mut().enumerate() {
            if row.len() != factors.len() || row.iter().any(|level| !level.is_finite()) {
                return Err(Error::Unanswerable(format!("run {} needs {} finite coded levels", run + 1, factors.len())));
            }
            for level in row {
                // Natural levels coded by their mid and half range miss ±1 and 0 by rounding; replicates must be equal to be recognized.
                let near = level.round();
                if near.abs() <= 1.0 && (*level - near).abs() < 1e-9 {
                    *level = near + 0.0;
                }
            }
        }
        Ok(FactorialDesign { factors, levels, blocks: None })
    }

    /// The same runs, done in blocks (days, operators, bolts of cloth); `blocks[run]`.
    ///
    /// # Errors
    /// [`Error::Unanswerable`] if there is not one block per run.
    pub fn with_blocks(mut self, blocks: Vec<String>) -> Result<Self, Error> {
        if blocks.len() != self.levels.len() {
            return Err(Error::Unanswerable(format!("{} blocks for {} runs", blocks.len(), self.levels.len())));
        }
        self.blocks = Some(blocks);
        Ok(self)
    }

    /// The same runs as if done in one block.
    pub fn without_blocks(&self) -> Self {
        FactorialDesign { blocks: None, ..self.clone() }
    }

    pub fn factors(&self) -> &[Axis] {
        &self.factors
    }

    /// `levels[run][factor]`, coded.
    pub fn levels(&self) -> &[Vec<f64>] {
        &self.levels
    }

    pub fn runs(&self) -> usize {
        self.levels.len()
    }

    /// Names of the blocks in order of first appearance; empty if there are fewer than two.
    pub fn block_names(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for block in self.blocks.iter().flatten() {
            if !names.contains(block) {
                names.push(block.clone());
            }
        }
        if names.len() > 1 { names } else { Vec::new() }
    }

    /// The block of a run.
    pub fn block(&self, run: usize) -> Option<&str> {
        self.blocks.as_ref().map(|blocks| blocks[run].as_str())
    }

    /// The runs of `keep`, in that order.
    pub fn subset(&self, keep: &[usize]) -> Self {
        FactorialDesign {
            factors: self.factors.clone(),
            levels: keep.iter().map(|&run| self.levels[run].clone()).collect(),
            blocks: self.blocks.as_ref().map(|blocks| keep.iter().map(|&run| blocks[run].clone()).collect()),
        }
    }

    /// The distinct treatments in standard order (first factor fastest).
    pub fn cells(&self) -> Vec<Cell> {
        let mut cells: Vec<Cell> = Vec::new();
        for (run, levels) in self.levels.iter().enumerate() {
            match cells.iter_mut().find(|cell| cell.levels == *levels) {
                Some(cell) => cell.runs.push(run),
                None => cells.push(Cell { levels: levels.clone(), runs: vec![run] }),
            }
        }
        cells.sort_by(|a, b| {
            let pairs = a.levels.iter().zip(&b.levels).rev();
            pairs.map(|(x, y)| x.total_cmp(y)).find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
        });
        cells
    }

    /// Whether some runs, but not all, are at the centre.
    pub fn has_centre(&self) -> bool {
        let centres = self.levels.iter().filter(|levels| is_centre(levels)).count();
        centres > 0 && centres < self.runs()
    }

    /// Subsets of factors that make the terms, by size and then in the order of the factors: 1, a, b, c, a:b, a:c, b:c, a:b:c.
    pub fn term_factors(&self) -> Vec<Vec<usize>> {
        let k = self.factors.len();
        let mut terms: Vec<Vec<usize>> = (0..1_usize << k).map(|mask| (0..k).filter(|i| mask >> i & 1 == 1).collect()).collect();
        terms.sort_by(|a: &Vec<usize>, b: &Vec<usize>| a.len().cmp(&b.len()).then_with(|| a.cmp(b)));
        terms
    }

    /// `1`, `a`, `a:b` … for a subset of factors.
    pub fn term_name(&self, term: &[usize]) -> String {
        if term.is_empty() { "1".into() } else { term.iter().map(|&i| self.factors[i].name.as_str()).collect::<Vec<_>>().join(":") }
    }

    /// Coded column of a term: the product of its factors' levels.
    pub(crate) fn column(&self, term: &[usize]) -> Vec<f64> {
        self.levels.iter().map(|levels| term.iter().map(|&i| levels[i]).product()).collect()
    }

    /// The regressors of all interactions, in the order of [`FactorialDesign::term_factors`].
    pub fn regressors(&self) -> Result<Regressors, Error> {
        self.regressors_of(&self.term_factors(), false)
    }

    /// The regressors of the terms asked, then `curvature` (1 at the centre, 0 elsewhere) if asked, then the blocks as deviations from their mean.
    pub fn regressors_of(&self, terms: &[Vec<usize>], curvature: bool) -> Result<Regressors, Error> {
        let mut names: Vec<String> = terms.iter().map(|term| self.term_name(term)).collect();
        let mut columns: Vec<Vec<f64>> = terms.iter().map(|term| self.column(term)).collect();
        if curvature {
            names.push(CURVATURE.into());
            columns.push(self.levels.iter().map(|levels| f64::from(u8::from(is_centre(levels)))).collect());
        }
        for (name, column) in self.block_columns() {
            names.push(name);
            columns.push(column);
        }
        Regressors::new(names, columns)
    }

    /// One indicator per cell, then the blocks: what replicates can tell apart.
    pub(crate) fn saturated_regressors(&self) -> Result<Regressors, Error> {
        let (mut names, mut columns) = (Vec::new(), Vec::new());
        for (index, cell) in self.cells().iter().enumerate() {
            let mut column = vec![0.0; self.runs()];
            cell.runs.iter().for_each(|&run| column[run] = 1.0);
            names.push(format!("cell {}", index + 1));
            columns.push(column);
        }
        for (name, column) in self.block_columns() {
            names.push(name);
            columns.push(column);
        }
        Regressors::new(names, columns)
    }

    /// Sum-to-zero coding: block j against the last one.
    fn block_columns(&self) -> Vec<(String, Vec<f64>)> {
        let (names, Some(blocks)) = (self.block_names(), &self.blocks) else { return Vec::new() };
        let Some((last, others)) = names.split_last() else { return Vec::new() };
        others
            .iter()
            .map(|name| {
                let coded = blocks
                    .iter()
                    .map(|block| {
                        if block == name {
                            1.0
                        } else if block == last {
                            -1.0
                        } else {
                            0.0
                        }
                    })
                    .collect();
                (format!("block {name}"), coded)
            })
            .collect()
    }

    /// A polynomial in coded units, rewritten in natural ones: `Π (xᵢ − centreᵢ)/intervalᵢ` multiplied out.
    ///
    /// `coded` pairs a subset of factors with its coefficient; the result does too, the terms in the usual order.
    pub fn natural_equation(&self, coded: &[(Vec<usize>, f64)]) -> Vec<(String, f64)> {
        let mut natural: Vec<(Vec<usize>, DoubleDouble)> = Vec::new();
        for (term, coefficient) in coded {
            // Every subset of the term takes x/interval from the factors in it and −centre/interval from the others.
            for mask in 0..1_usize << term.len() {
                let mut part = DoubleDouble::from(*coefficient);
                let mut subset = Vec::new();
                for (place, &i) in term.iter().enumerate() {
                    let interval = DoubleDouble::from(self.factors[i].interval());
                    if mask >> place & 1 == 1 {
                        subset.push(i);
                        part = part / interval;
                    } else {
                        part = part * -DoubleDouble::from(self.factors[i].centre()) / interval;
                    }
                }
                match natural.iter_mut().find(|(known, _)| *known == subset) {
                    Some((_, sum)) => *sum = *sum + part,
                    None => natural.push((subset, part)),
                }
            }
        }
        natural.sort_by(|(a, _), (b, _)| a.len().cmp(&b.len()).then_with(|| a.cmp(b)));
        natural.into_iter().map(|(term, value)| (self.term_name(&term), value.to_f64())).collect()
    }
}

/// Name of the curvature regressor.
pub const CURVATURE: &str = "curvature";

fn is_centre(levels: &[f64]) -> bool {
    levels.iter().all(|level| *level == 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full(k: usize) -> FactorialDesign {
        let factors = (0..k).map(|i| Axis::coded(format!("x{}", i + 1))).collect();
        let levels = (0..1 << k).map(|run| (0..k).map(|i| if run >> i & 1 == 1 { 1.0 } else { -1.0 }).collect()).collect();
        FactorialDesign::new(factors, levels).unwrap()
    }

    #[test]
    fn terms_come_by_order_of_interaction() {
        let design = full(3);
        let names: Vec<String> = design.term_factors().iter().map(|term| design.term_name(term)).collect();
        assert_eq!(names, ["1", "x1", "x2", "x3", "x1:x2", "x1:x3", "x2:x3", "x1:x2:x3"]);
    }

    #[test]
    fn coded_and_natural_equations_predict_the_same() {
        let factors = vec![Axis { name: "a".into(), low: 10.0, high: 14.0 }, Axis { name: "b".into(), low: -1.0, high: 5.0 }];
        let design = FactorialDesign::new(factors, vec![vec![-1.0, -1.0], vec![1.0, 1.0]]).unwrap();
        let coded = vec![(vec![], 3.0), (vec![0], 2.0), (vec![1], -1.5), (vec![0, 1], 0.5)];
        let natural = design.natural_equation(&coded);
        // At a = 14, b = −1 (coded +1, −1) the coded equation gives 3 + 2 + 1.5 − 0.5 = 6.
        let value: f64 = natural
            .iter()
            .map(|(term, c)| {
                c * term
                    .split(':')
                    .map(|f| match f {
                        "1" => 1.0,
                        "a" => 14.0,
                        _ => -1.0,
                    })
                    .product::<f64>()
            })
            .sum();
        assert!((value - 6.0).abs() < 1e-14, "{natural:?}");
    }

    #[test]
    fn natural_levels_coded_with_rounding_are_recognized_as_replicates() {
        let design =
            FactorialDesign::new(vec![Axis::coded("a")], vec![vec![1.0 - 1e-15], vec![1.0], vec![-1.0 + 1e-16], vec![-1e-17]]).unwrap();
        assert_eq!(design.cells().len(), 3);
    }
}
