//! The result of `hemline regress` as one document: what JSON shows, and the text is made from.

use serde::Serialize;

use super::{Kind, Regress, Wish};
use crate::error::Error;
use crate::statistics::anova::AnovaRow;
use crate::statistics::box_cox::{BoxCox, box_cox};
use crate::statistics::box_wilson::{Analysis, Coefficient, ErrorSource, Options, Verdict};
use crate::statistics::factorial::{Axis, FactorialDesign};
use crate::statistics::known_errors::KnownErrorRegression;
use crate::statistics::next_runs::{Suggestion, next_runs};
use crate::statistics::permutation::{self, PermutationTest, permutation_tests};
use crate::statistics::power::{replicates_needed, smallest_coefficient};
use crate::statistics::residuals::{Diagnostics, diagnose, without_suspects};
use crate::statistics::steepest_ascent::{self, Goal, Path, steepest_ascent};
use crate::statistics::sums_of_squares::{Adjustment, factorial_anova};

/// The chance that names an effect as one the design can find; 90 % is the custom of sample-size planning.
pub(super) const WANTED_POWER: f64 = 0.9;

#[derive(Serialize)]
pub(super) struct Term {
    pub(super) term: String,
    pub(super) estimate: Option<f64>,
    pub(super) se: Option<f64>,
    pub(super) t: Option<f64>,
    pub(super) p: Option<f64>,
    pub(super) ci_low: Option<f64>,
    pub(super) ci_high: Option<f64>,
    pub(super) p_holm: Option<f64>,
    pub(super) p_benjamini_hochberg: Option<f64>,
    pub(super) significant: bool,
}

impl From<&Coefficient> for Term {
    fn from(c: &Coefficient) -> Self {
        Term {
            term: c.term.clone(),
            estimate: Some(c.estimate),
            se: c.se,
            t: c.t,
            p: c.p,
            ci_low: c.ci_low,
            ci_high: c.ci_high,
            p_holm: c.p_holm,
            p_benjamini_hochberg: c.p_benjamini_hochberg,
            significant: c.significant,
        }
    }
}

#[derive(Serialize)]
pub(super) struct Cochran {
    pub(super) g: Option<f64>,
    pub(super) critical: Option<f64>,
}

#[derive(Serialize)]
pub(super) struct Adequacy {
    pub(super) f: Option<f64>,
    pub(super) critical: Option<f64>,
    pub(super) df: Option<(f64, f64)>,
}

#[derive(Serialize)]
pub(super) struct Monomial {
    pub(super) term: String,
    pub(super) coefficient: f64,
}

/// What one run does to the full model.
#[derive(Serialize)]
pub(super) struct RunUsed {
    /// Line of the file.
    pub(super) row: usize,
    fitted: f64,
    residual: f64,
    leverage: f64,
    standardized_residual: Option<f64>,
    deleted_residual: Option<f64>,
    cook_distance: Option<f64>,
}

/// Runs of each treatment that find an effect with a chance of 90 %.
#[derive(Serialize)]
pub(super) struct Needed {
    /// Change of the response from the low to the high level.
    pub(super) effect: f64,
    pub(super) replicates: usize,
}

#[derive(Serialize)]
pub(super) struct Document {
    pub(super) table: String,
    pub(super) response: String,
    pub(super) factors: Vec<Axis>,
    pub(super) alpha: f64,
    pub(super) runs: usize,
    pub(super) treatments: usize,
    pub(super) terms: Vec<Term>,
    pub(super) curvature: Option<Term>,
    pub(super) blocks: Vec<Term>,
    pub(super) error_variance: Option<f64>,
    pub(super) residual_df: usize,
    pub(super) t_critical: Option<f64>,
    pub(super) cochran: Cochran,
    pub(super) equal_variances: Option<Verdict>,
    pub(super) adequacy: Adequacy,
    pub(super) adequate: Option<bool>,
    /// The full model in the units of the table.
    pub(super) natural: Vec<Monomial>,
    /// The significant terms alone, refitted.
    pub(super) reduced_natural: Vec<Monomial>,
    pub(super) anova: Vec<AnovaRow>,
    pub(super) r_squared: Option<f64>,
    pub(super) adjusted_r_squared: Option<f64>,
    pub(super) predicted_r_squared: Option<f64>,
    pub(super) press: Option<f64>,
    pub(super) diagnostics: Option<Diagnostics>,
    /// Line of the file of each run; the run numbers in `diagnostics` count these from 0.
    pub(super) rows: Vec<usize>,
    pub(super) box_cox: Option<BoxCox>,
    /// Found with a chance of 90 %.
    pub(super) smallest_coefficient: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) replicates_needed: Option<Needed>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) permutation: Option<Vec<PermutationTest>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) known_errors: Option<KnownErrorRegression>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) path: Option<Path>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) next_runs: Option<Vec<Suggestion>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) sums_of_squares: Option<Vec<AnovaRow>>,
    pub(super) runs_used: Vec<RunUsed>,
    /// The coefficients without the suspects of `diagnostics`, to lay beside `terms`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) without_suspects: Option<Vec<Term>>,
    pub(super) notes: Vec<String>,
    pub(super) set_aside: Vec<String>,
}

impl Document {
    pub(super) fn new(args: &Regress, design: &FactorialDesign, analysis: &Analysis, rows: Vec<usize>, set_aside: Vec<String>) -> Self {
        // Every term of the model is listed, in its place; one without a coefficient of its own has nulls.
        let terms = design
            .term_factors()
            .iter()
            .map(|term| design.term_name(term))
            .map(|name| match analysis.coefficients.iter().find(|c| c.term == name) {
                Some(coefficient) => coefficient.into(),
                None => Term {
                    term: name,
                    estimate: None,
                    se: None,
                    t: None,
                    p: None,
                    ci_low: None,
                    ci_high: None,
                    p_holm: None,
                    p_benjamini_hochberg: None,
                    significant: false,
                },
            })
            .collect();
        let cochran = analysis.equal_variances.as_ref().filter(|verdict| verdict.test == "Cochran G");
        let adequacy = analysis.adequacy.as_ref();
        Document {
            table: args.table.display().to_string(),
            response: args.response.clone(),
            factors: design.factors().to_vec(),
            alpha: args.alpha,
            runs: analysis.used_runs.len(),
            treatments: analysis.cells.len(),
            terms,
            curvature: analysis.curvature.as_ref().map(Term::from),
            blocks: analysis.blocks.iter().map(Term::from).collect(),
            error_variance: analysis.error.map(|error| error.variance),
            residual_df: analysis.residual_df,
            t_critical: analysis.t_critical,
            cochran: Cochran { g: cochran.map(|v| v.statistic), critical: cochran.map(|v| v.critical) },
            equal_variances: analysis.equal_variances.clone(),
            adequacy: Adequacy { f: adequacy.map(|v| v.statistic), critical: adequacy.map(|v| v.critical), df: adequacy.map(|v| v.df) },
            adequate: adequacy.map(|v| v.holds),
            natural: monomials(&analysis.natural),
            reduced_natural: monomials(&analysis.reduced.natural),
            anova: analysis.anova.clone(),
            r_squared: analysis.full.r_squared(),
            adjusted_r_squared: analysis.full.adjusted_r_squared(),
            predicted_r_squared: analysis.full.predicted_r_squared(),
            press: analysis.full.press(),
            diagnostics: None,
            runs_used: runs_used(analysis, &rows),
            rows,
            box_cox: None,
            smallest_coefficient: None,
            replicates_needed: None,
            permutation: None,
            known_errors: None,
            path: None,
            next_runs: None,
            sums_of_squares: None,
            without_suspects: None,
            notes: analysis.notes.clone(),
            set_aside,
        }
    }

    /// What goes beyond the coefficients: residuals, transformation, power, and what was asked for by flags.
    pub(super) fn look_further(
        &mut self,
        args: &Regress,
        design: &FactorialDesign,
        response: &[Option<f64>],
        analysis: &Analysis,
    ) -> Result<(), Error> {
        self.diagnostics = Some(diagnose(design, analysis, args.alpha)?);
        let without = without_suspects(design, response, analysis, &Options { alpha: args.alpha })?;
        self.without_suspects = without.map(|without| without.coefficients.iter().map(Term::from).collect());
        if response.iter().flatten().all(|y| *y > 0.0) {
            self.box_cox = box_cox(design, response, args.alpha)?;
        } else {
            self.notes.push("Box–Cox needs positive responses.".into());
        }
        let replicates = analysis.cells.iter().map(|cell| cell.runs.len()).min().unwrap_or(0);
        let balanced = analysis.cells.iter().all(|cell| cell.runs.len() == replicates) && analysis.blocks.is_empty();
        match analysis.error.filter(|error| error.source == ErrorSource::PureError && balanced && analysis.curvature.is_none()) {
            Some(error) => {
                self.smallest_coefficient =
                    smallest_coefficient(error.variance, analysis.cells.len(), replicates, args.alpha, WANTED_POWER).ok()
            }
            None if analysis.error.is_none() => (),
            None => self.notes.push("The smallest effect that would be found is computed for balanced, replicated designs only.".into()),
        }
        if let Some(effect) = args.effect {
            match analysis.error.filter(|error| error.source == ErrorSource::PureError) {
                Some(error) => {
                    let corners = 1 << design.factors().len();
                    let replicates = replicates_needed(0.5 * effect, error.variance, corners, args.alpha, WANTED_POWER)?;
                    self.replicates_needed = Some(Needed { effect, replicates });
                }
                None => self.notes.push("How many runs an effect needs is not known: no scatter of repeated runs to plan with.".into()),
            }
        }
        if let Some(kind) = args.sums_of_squares {
            let adjustment = match kind {
                Kind::Sequential => Adjustment::Sequential,
                Kind::Hierarchical => Adjustment::Hierarchical,
                Kind::Partial => Adjustment::Partial,
            };
            let y: Vec<f64> = response.iter().copied().flatten().collect();
            self.sums_of_squares = Some(factorial_anova(&design.subset(&analysis.used_runs), &y, adjustment)?);
        }
        if args.permutation {
            self.permutation = Some(permutation_tests(design, response, &permutation::Options::default())?);
        }
        if let Some(wish) = args.next {
            let goal = if wish == Wish::Larger { Goal::Increase } else { Goal::Decrease };
            let ascent = steepest_ascent::Options { goal, alpha: args.alpha, ..Default::default() };
            match steepest_ascent(design, response, analysis, &ascent) {
                Ok(path) => self.path = Some(path),
                Err(Error::Unanswerable(why)) => self.notes.push(format!("No path: {why}.")),
                Err(why) => return Err(why),
            }
            self.next_runs = Some(next_runs(design, response, analysis, &ascent)?);
        }
        Ok(())
    }
}

fn runs_used(analysis: &Analysis, rows: &[usize]) -> Vec<RunUsed> {
    let model = &analysis.full;
    let (standardized, deleted, cook) = (model.standardized_residuals(), model.deleted_residuals(), model.cook_distances());
    analysis
        .used_runs
        .iter()
        .enumerate()
        .map(|(i, &run)| RunUsed {
            row: rows[run],
            fitted: model.fitted[i],
            residual: model.residuals[i],
            leverage: model.leverage[i],
            standardized_residual: standardized[i],
            deleted_residual: deleted[i],
            cook_distance: cook[i],
        })
        .collect()
}

fn monomials(equation: &[(String, f64)]) -> Vec<Monomial> {
    equation.iter().map(|(term, coefficient)| Monomial { term: term.clone(), coefficient: *coefficient }).collect()
}
