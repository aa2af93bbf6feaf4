//! How much each source takes when the design is not orthogonal: sums of squares of types I, II and III.

use crate::error::Error;
use crate::statistics::anova::AnovaRow;
use crate::statistics::factorial::{CURVATURE, FactorialDesign};
use crate::statistics::linear_model::Regressors;

/// What a term is adjusted for.
///
/// Source: Searle, Linear Models for Unbalanced Data (1987), chapters 4 and 12. In a balanced design the three agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Adjustment {
    /// Type I: the terms before it (constant, main effects, two-factor interactions …).
    Sequential,
    /// Type II: all terms that do not contain it.
    Hierarchical,
    /// Type III: all other terms, in ±1 coding.
    Partial,
}

/// Analysis of variance of the full factorial model: one row per term of one degree of freedom, then `curvature` and `blocks` where there are
/// centre points and blocks, then `residual`; F against the residual. Terms are adjusted for curvature and blocks in every type, those for all terms.
///
/// A term that the runs cannot tell from those it is adjusted for has 0 degrees of freedom.
///
/// # Errors
/// [`Error::Unanswerable`] if responses do not match the runs or are not finite.
pub fn factorial_anova(design: &FactorialDesign, response: &[f64], adjustment: Adjustment) -> Result<Vec<AnovaRow>, Error> {
    let terms = design.term_factors();
    let regressors = |subset: &[Vec<usize>]| design.regressors_of(subset, design.has_centre());
    let decomposition = regressors(&terms)?.decompose();
    let full = decomposition.fit(response)?;
    let residual = (full.residual_df, full.residual_sum_of_squares);
    let mut rows = Vec::new();
    for (index, term) in terms.iter().enumerate().skip(1) {
        let name = design.term_name(term);
        let before: Vec<Vec<usize>> = match adjustment {
            Adjustment::Sequential => terms[..index].to_vec(),
            Adjustment::Hierarchical => terms.iter().filter(|other| !term.iter().all(|factor| other.contains(factor))).cloned().collect(),
            Adjustment::Partial => terms.iter().filter(|other| *other != term).cloned().collect(),
        };
        // The last coefficient of a full-rank model carries its sum of squares: b²/(XᵀX)⁻¹.
        let direct =
            decomposition.terms().position(|known| known == name).filter(|_| adjustment == Adjustment::Partial && full.aliases.is_empty());
        rows.push(match direct {
            Some(i) => AnovaRow::new(name, 1, full.estimates[i].estimate.powi(2) / decomposition.inverse_gram(i, i)),
            None => last_of(design, &before, term, response)?,
        });
    }
    if design.has_centre() {
        rows.push(extra(CURVATURE.into(), &design.regressors_of(&terms, false)?, &regressors(&terms)?, response)?);
    }
    if !design.block_names().is_empty() {
        let unblocked = design.without_blocks().regressors_of(&terms, design.has_centre())?;
        rows.push(extra("blocks".into(), &unblocked, &regressors(&terms)?, response)?);
    }
    if residual.0 > 0 && !full.perfect {
        let variance = residual.1 / residual.0 as f64;
        rows = rows.into_iter().map(|row| row.against(variance, residual.0)).collect();
    }
    rows.push(AnovaRow::new("residual", residual.0, residual.1));
    Ok(rows)
}

/// What a term explains beyond the terms before it, the curvature and the blocks.
fn last_of(design: &FactorialDesign, before: &[Vec<usize>], term: &[usize], response: &[f64]) -> Result<AnovaRow, Error> {
    let decomposition =
        design.regressors_of(before, design.has_centre())?.with_column(design.term_name(term), design.column(term)).decompose();
    let name = design.term_name(term);
    let parts = decomposition.sequential_sums_of_squares(response)?;
    Ok(parts
        .into_iter()
        .find(|(known, _)| *known == name)
        .map_or_else(|| AnovaRow::new(&name, 0, 0.0), |(_, part)| AnovaRow::new(&name, 1, part)))
}

/// What the larger model explains beyond the smaller one it contains.
fn extra(source: String, smaller: &Regressors, larger: &Regressors, response: &[f64]) -> Result<AnovaRow, Error> {
    let (smaller, larger) = (smaller.decompose().fit(response)?, larger.decompose().fit(response)?);
    let sum_of_squares = (smaller.residual_sum_of_squares - larger.residual_sum_of_squares).max(0.0);
    Ok(AnovaRow::new(source, smaller.residual_df - larger.residual_df, sum_of_squares))
}
