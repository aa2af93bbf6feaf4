//! The Box–Wilson analysis of one response over a two-level factorial: reproducibility, coefficients, adequacy.
//!
//! Source: Box & Wilson, J. R. Statist. Soc. B 13 (1951) 1–45; the order of the tests (Cochran, Student, Fisher) is that of Adler, Markova &
//! Granovsky, The Design of Experiments to Find Optimal Conditions (1975).

use serde::Serialize;

use crate::error::Error;
use crate::numerics::double_double::DoubleDouble;
use crate::statistics::anova::{AnovaRow, LackOfFit};
use crate::statistics::distribution;
use crate::statistics::factorial::{CURVATURE, Cell, FactorialDesign};
use crate::statistics::lenth::{Lenth, lenth};
use crate::statistics::linear_model::{Alias, Decomposition, LinearModel, NearAlias, is_rounding};
use crate::statistics::variances::{brown_forsythe, centred_squares, cochran};

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
    /// Benjamini–Hochberg-adjusted over the same family.
    pub p_benjamini_hochberg: Option<f64>,
    /// |b| > t·s_b at the asked level.
    pub significant: bool,
}

impl Coefficient {
    /// Change of the response from the low to the high level, 2b.
    pub fn effect(&self) -> f64 {
        2.0 * self.estimate
    }
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

/// What to decide with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Level of every test; intervals cover 1 − alpha.
    pub alpha: f64,
}

impl Default for Options {
    /// 0.05, the custom of the field.
    fn default() -> Self {
        Options { alpha: 0.05 }
    }
}

/// Where the error variance comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum ErrorSource {
    /// The scatter of runs of the same treatment (and block).
    PureError,
    /// The residuals of the full model: no treatment was repeated.
    Residual,
}

/// The variance that every test compares with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ErrorVariance {
    /// s²_y, in squared units of the response.
    pub variance: f64,
    pub df: usize,
    pub source: ErrorSource,
}

/// One treatment: what its runs say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CellSummary {
    /// Coded levels.
    pub levels: Vec<f64>,
    /// Indices of its runs in the design, missing ones left out.
    pub runs: Vec<usize>,
    pub mean: f64,
    /// s²_u with n − 1 degrees of freedom; `None` for a single run.
    pub variance: Option<f64>,
}

/// The model of the significant terms alone; of all terms where none can be tested.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reduced {
    /// `(term, coefficient)` in coded units, refitted where the design is not orthogonal.
    pub coded: Vec<(String, f64)>,
    /// The same polynomial in the natural units of the factors.
    pub natural: Vec<(String, f64)>,
    /// The fit, in the order of the used runs; `None` if nothing is significant, so that the model is 0.
    pub model: Option<LinearModel>,
    /// Residual degrees of freedom and sum of squares.
    pub residual: (usize, f64),
    /// By replicates; `None` if there are none.
    pub lack_of_fit: Option<LackOfFit>,
}

/// Everything about one response.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Analysis {
    /// In the order of [`FactorialDesign::term_factors`]; those that the runs cannot tell apart are in [`Analysis::aliases`] instead.
    pub coefficients: Vec<Coefficient>,
    pub aliases: Vec<Alias>,
    /// Mean at the centre minus mean of the corners' model there; only with centre points.
    pub curvature: Option<Coefficient>,
    /// Deviation of each block but the last from the mean of the blocks.
    pub blocks: Vec<Coefficient>,
    /// Indices of the runs that have a response, ascending; residuals and leverages of `full` are in this order.
    pub used_runs: Vec<usize>,
    pub cells: Vec<CellSummary>,
    pub error: Option<ErrorVariance>,
    /// Degrees of freedom of the t tests: those of the pure error, or of the residuals where no treatment was repeated.
    pub residual_df: usize,
    /// |t| above this is significant.
    pub t_critical: Option<f64>,
    /// Cochran's G, or Brown–Forsythe where the cells have unequal numbers of runs.
    pub equal_variances: Option<Verdict>,
    /// Fisher's F of the reduced model on (N − l, pure-error df).
    pub adequacy: Option<Verdict>,
    /// Of the reduced model: regression, residual, lack of fit, pure error, total.
    pub anova: Vec<AnovaRow>,
    /// Only where there is no error variance.
    pub lenth: Option<Lenth>,
    pub full: LinearModel,
    pub reduced: Reduced,
    /// The full model in natural units.
    pub natural: Vec<(String, f64)>,
    /// What does not hold, does not exist or was replaced, in plain words.
    pub notes: Vec<String>,
}

/// Analyses one response; `response[run]` is `None` where the run has none.
///
/// # Errors
/// [`Error::Invalid`] for a level outside (0, 1); [`Error::Unanswerable`] if responses do not match the runs, one is not finite, or all are missing.
pub fn analyse(design: &FactorialDesign, response: &[Option<f64>], options: &Options) -> Result<Analysis, Error> {
    if !(options.alpha > 0.0 && options.alpha < 1.0) {
        return Err(Error::Invalid { quantity: "significance level", value: options.alpha, allowed: "> 0 and < 1" });
    }
    if response.len() != design.runs() {
        return Err(Error::Unanswerable(format!("{} responses for {} runs", response.len(), design.runs())));
    }
    let used_runs: Vec<usize> = (0..response.len()).filter(|&run| response[run].is_some()).collect();
    if used_runs.is_empty() {
        return Err(Error::Unanswerable("no run has a response".into()));
    }
    let y: Vec<f64> = response.iter().copied().flatten().collect();
    let mut notes = Vec::new();
    if used_runs.len() < response.len() {
        notes.push(format!("{} of {} runs have no response and are left out.", response.len() - used_runs.len(), response.len()));
    }
    let used = design.subset(&used_runs);
    let cells = used.cells();
    describe_missing_cells(design, &cells, &mut notes);

    let terms = used.term_factors();
    let curvature = used.has_centre();
    let decomposition = used.regressors_of(&terms, curvature)?.decompose();
    let full = decomposition.fit(&y)?;
    describe_aliases(&full.aliases, &mut notes);
    describe_near_aliases(&full.near_aliases, &mut notes);
    describe_orthogonality(&decomposition, &mut notes);

    let pure_error = pure_error(&used, &cells, &y)?;
    let error = error_variance(&full, &pure_error, &y, &mut notes);
    let residual_df = if pure_error.df > 0 { pure_error.df } else { full.residual_df };
    let t_critical = error.map(|error| distribution::student_critical(options.alpha, error.df as f64));
    let mut coefficients: Vec<Coefficient> = full
        .estimates
        .iter()
        .enumerate()
        .map(|(i, estimate)| coefficient(&estimate.term, estimate.estimate, decomposition.inverse_gram(i, i), error, t_critical))
        .collect();
    let blocks = coefficients.extract_if(.., |c| c.term.starts_with("block ")).collect();
    let curvature = coefficients.extract_if(.., |c| c.term == CURVATURE).next();
    let lenth = if error.is_none() { unreplicated(&mut coefficients, full.residual_df, options.alpha, &mut notes) } else { None };

    let equal_variances = equal_variances(&used, &cells, &y, options.alpha, &mut notes)?;
    let untested = error.is_none() && lenth.is_none();
    if untested {
        notes.push("No term can be tested, so the reduced model keeps them all.".into());
    }
    let keeps = |term: &[usize]| coefficients.iter().any(|c| (c.significant || untested) && c.term == used.term_name(term));
    let kept: Vec<Vec<usize>> = terms.iter().filter(|term| keeps(term)).cloned().collect();
    let keep_curvature = curvature.as_ref().is_some_and(|c| c.significant || untested);
    let (reduced, adequacy, anova) = reduce(&used, &kept, keep_curvature, &y, &pure_error, options.alpha, &mut notes)?;

    let all: Vec<(Vec<usize>, f64)> = terms
        .iter()
        .filter_map(|term| coefficients.iter().find(|c| c.term == used.term_name(term)).map(|c| (term.clone(), c.estimate)))
        .collect();
    let summaries = cells
        .iter()
        .map(|cell| {
            let values: Vec<f64> = cell.runs.iter().map(|&run| y[run]).collect();
            let (mean, variance) = crate::statistics::variances::mean_and_variance(&values);
            CellSummary { levels: cell.levels.clone(), runs: cell.runs.iter().map(|&run| used_runs[run]).collect(), mean, variance }
        })
        .collect();
    Ok(Analysis {
        coefficients,
        aliases: full.aliases.clone(),
        curvature,
        blocks,
        used_runs,
        cells: summaries,
        error,
        residual_df,
        t_critical,
        equal_variances,
        adequacy,
        anova,
        lenth,
        full,
        reduced,
        natural: used.natural_equation(&all),
        notes,
    })
}

fn describe_missing_cells(design: &FactorialDesign, cells: &[Cell], notes: &mut Vec<String>) {
    let corners = cells.iter().filter(|cell| cell.levels.iter().all(|level| level.abs() == 1.0)).count();
    let wanted = 1_usize << design.factors().len();
    if corners < wanted {
        notes.push(format!("{} of the {wanted} corners of the design have no run.", wanted - corners));
    }
    if cells.iter().any(|cell| !cell.is_centre() && cell.levels.iter().any(|level| level.abs() != 1.0)) {
        notes.push(
            "Some runs are neither at a corner (coded ±1) nor at the centre (coded 0); the coefficients are those of a general regression."
                .into(),
        );
    }
}

fn describe_aliases(aliases: &[Alias], notes: &mut Vec<String>) {
    for alias in aliases {
        let equals: Vec<String> = alias.equals.iter().map(|(term, factor)| format!("{factor:+.4}·({term})")).collect();
        let equals = if equals.is_empty() { "0".to_string() } else { equals.join(" ") };
        notes.push(format!("Term {} has no coefficient of its own: in these runs it equals {equals}.", alias.term));
    }
}

fn describe_near_aliases(near: &[NearAlias], notes: &mut Vec<String>) {
    for alias in near {
        notes.push(format!(
            "Term {} is nearly a combination of the others in these runs: its coefficient keeps about {:.0} digits of the numbers given.",
            alias.term,
            alias.digits().floor()
        ));
    }
}

fn describe_orthogonality(decomposition: &Decomposition, notes: &mut Vec<String>) {
    // Curvature is correlated with the constant in every design with centre points; that is no defect of the corners.
    let terms: Vec<usize> = decomposition.terms().enumerate().filter(|(_, term)| *term != CURVATURE).map(|(i, _)| i).collect();
    let correlated = terms.iter().any(|&i| {
        terms.iter().take_while(|&&j| j < i).any(|&j| {
            let scale = (decomposition.inverse_gram(i, i) * decomposition.inverse_gram(j, j)).sqrt();
            decomposition.inverse_gram(i, j).abs() > 1e-12 * scale
        })
    });
    if correlated {
        notes.push("The design is not orthogonal: coefficients are correlated, have different standard errors, and change when another term is dropped.".into());
    }
}

/// What replicates say: degrees of freedom, sum of squares, and the fitted value of each run when every cell (and block) has its own mean.
struct PureError {
    df: usize,
    sum_of_squares: f64,
    fitted: Vec<DoubleDouble>,
}

fn pure_error(design: &FactorialDesign, cells: &[Cell], y: &[f64]) -> Result<PureError, Error> {
    if design.block_names().is_empty() {
        let mut fitted = vec![DoubleDouble::ZERO; y.len()];
        let mut total = DoubleDouble::ZERO;
        for cell in cells {
            let values: Vec<f64> = cell.runs.iter().map(|&run| y[run]).collect();
            let (mean, squares) = centred_squares(&values);
            total = total + squares;
            cell.runs.iter().for_each(|&run| fitted[run] = mean);
        }
        return Ok(PureError { df: y.len() - cells.len(), sum_of_squares: total.to_f64(), fitted });
    }
    let saturated = design.saturated_regressors()?.decompose().fit(y)?;
    let fitted = saturated.fitted.iter().copied().map(DoubleDouble::from).collect();
    Ok(PureError { df: saturated.residual_df, sum_of_squares: saturated.residual_sum_of_squares, fitted })
}

fn error_variance(full: &LinearModel, pure_error: &PureError, y: &[f64], notes: &mut Vec<String>) -> Option<ErrorVariance> {
    let (df, sum_of_squares, source) = if pure_error.df > 0 {
        (pure_error.df, pure_error.sum_of_squares, ErrorSource::PureError)
    } else if full.residual_df > 0 {
        notes.push(
            "No treatment was repeated; the error is taken from the residuals of the full model, so lack of fit counts as error.".into(),
        );
        (full.residual_df, full.residual_sum_of_squares, ErrorSource::Residual)
    } else {
        notes.push("No treatment was repeated and the model takes every degree of freedom: there is no error to test against.".into());
        return None;
    };
    if is_rounding(sum_of_squares, y) {
        notes
            .push("Repeated runs agree to the last digit: there is no scatter to test against, so no standard errors and no tests.".into());
        return None;
    }
    Some(ErrorVariance { variance: sum_of_squares / df as f64, df, source })
}

fn coefficient(term: &str, estimate: f64, inverse_gram: f64, error: Option<ErrorVariance>, t_critical: Option<f64>) -> Coefficient {
    let se = error.map(|error| (error.variance * inverse_gram).sqrt());
    let t = se.map(|se| estimate / se);
    let p = t.zip(error).map(|(t, error)| distribution::student_two_sided(t, error.df as f64));
    let reach = se.zip(t_critical).map(|(se, critical)| se * critical);
    Coefficient {
        term: term.to_string(),
        estimate,
        se,
        t,
        p,
        ci_low: reach.map(|reach| estimate - reach),
        ci_high: reach.map(|reach| estimate + reach),
        p_holm: None,
        p_benjamini_hochberg: None,
        significant: t.zip(t_critical).is_some_and(|(t, critical)| t.abs() > critical),
    }
}

/// Without replicates and residual degrees of freedom only Lenth's margin can tell effects from noise.
fn unreplicated(coefficients: &mut [Coefficient], residual_df: usize, alpha: f64, notes: &mut Vec<String>) -> Option<Lenth> {
    if residual_df > 0 {
        return None;
    }
    let contrasts: Vec<f64> = coefficients.iter().filter(|c| c.term != "1").map(|c| c.estimate).collect();
    let Some(margins) = lenth(&contrasts, alpha) else {
        notes.push("Lenth's method needs at least three effects, half of them not zero; no effect can be called significant.".into());
        return None;
    };
    notes.push("Significance is by Lenth's margin of error, which takes most effects for noise; the constant is kept untested.".into());
    for coefficient in coefficients {
        coefficient.significant = coefficient.term == "1" || coefficient.estimate.abs() > margins.margin;
    }
    Some(margins)
}

fn equal_variances(
    design: &FactorialDesign,
    cells: &[Cell],
    y: &[f64],
    alpha: f64,
    notes: &mut Vec<String>,
) -> Result<Option<Verdict>, Error> {
    // Differences between blocks are no scatter of a cell.
    let blocked = !design.block_names().is_empty();
    let values: Vec<f64> = if blocked { without_blocks(design, y)? } else { y.to_vec() };
    let groups: Vec<Vec<f64>> = cells.iter().map(|cell| cell.runs.iter().map(|&run| values[run]).collect()).collect();
    let fewest = groups.iter().map(Vec::len).min().unwrap_or(0);
    let equal = groups.iter().all(|group| group.len() == fewest);
    if groups.len() < 2 || groups.iter().filter(|group| group.len() > 1).count() < 2 {
        notes.push("Fewer than two treatments were repeated: whether they scatter alike cannot be tested.".into());
        return Ok(None);
    }
    let (name, test) = if equal && !blocked {
        let variances: Vec<f64> = groups.iter().map(|group| (centred_squares(group).1.to_f64()) / (fewest - 1) as f64).collect();
        let scatters = !is_rounding(variances.iter().sum::<f64>() * (fewest - 1) as f64, y);
        ("Cochran G", if scatters { cochran(&variances, fewest, alpha) } else { None })
    } else {
        notes.push(if blocked {
            "Blocks were removed from the responses before comparing variances, so Cochran's test does not apply; Brown–Forsythe is used, as an approximation.".into()
        } else {
            "The treatments have unequal numbers of runs, so Cochran's test does not apply; Brown–Forsythe is used instead.".to_string()
        });
        ("Brown–Forsythe F", brown_forsythe(&groups, alpha))
    };
    if test.is_none() {
        notes.push("The repeated runs do not scatter enough to compare their variances.".into());
    }
    Ok(test.map(|test| Verdict {
        test: name.into(),
        statistic: test.statistic,
        critical: test.critical,
        df: test.df,
        p: Some(test.p),
        holds: test.statistic <= test.critical,
    }))
}

/// What is left of the responses without the means of cells and blocks.
fn without_blocks(design: &FactorialDesign, y: &[f64]) -> Result<Vec<f64>, Error> {
    Ok(design.saturated_regressors()?.decompose().fit(y)?.residuals)
}

/// Fits the kept terms alone and asks whether they are enough.
fn reduce(
    design: &FactorialDesign,
    kept: &[Vec<usize>],
    curvature: bool,
    y: &[f64],
    pure_error: &PureError,
    alpha: f64,
    notes: &mut Vec<String>,
) -> Result<(Reduced, Option<Verdict>, Vec<AnovaRow>), Error> {
    let names: Vec<String> = kept.iter().map(|term| design.term_name(term)).collect();
    let empty = kept.is_empty() && !curvature && design.block_names().is_empty();
    let model = if empty { None } else { Some(design.regressors_of(kept, curvature)?.decompose().fit(y)?) };
    if !kept.iter().any(Vec::is_empty) {
        notes.push("The constant is not significant; the reduced model goes through 0, and its sums of squares are about 0.".into());
    }
    let fitted = model.as_ref().map_or_else(|| vec![0.0; y.len()], |model| model.fitted.clone());
    let from_zero = y.iter().map(|&y| DoubleDouble::product(y, y)).sum::<DoubleDouble>().to_f64();
    let residual = model.as_ref().map_or((y.len(), from_zero), |model| (model.residual_df, model.residual_sum_of_squares));
    let coded: Vec<(String, f64)> = model
        .iter()
        .flat_map(|model| &model.estimates)
        .filter(|estimate| names.contains(&estimate.term))
        .map(|estimate| (estimate.term.clone(), estimate.estimate))
        .collect();
    let by_factors: Vec<(Vec<usize>, f64)> = kept
        .iter()
        .zip(&names)
        .filter_map(|(term, name)| coded.iter().find(|(known, _)| known == name).map(|(_, b)| (term.clone(), *b)))
        .collect();
    let replicated = pure_error.df > 0 && !is_rounding(pure_error.sum_of_squares, y);
    let lack_of_fit = replicated.then(|| LackOfFit::new(residual, (pure_error.df, pure_error.sum_of_squares)));

    let adequacy = adequacy(&fitted, residual.0, pure_error, replicated, alpha, notes);
    let total =
        model.as_ref().map_or((y.len(), from_zero), |model| (y.len() - usize::from(model.has_constant), model.total_sum_of_squares));
    let mut anova = vec![AnovaRow::new("regression", total.0 - residual.0, total.1 - residual.1)];
    match &lack_of_fit {
        Some(split) => {
            let error = pure_error.sum_of_squares / pure_error.df as f64;
            anova[0] = anova[0].clone().against(error, pure_error.df);
            anova.push(AnovaRow::new("residual", residual.0, residual.1));
            anova.push(AnovaRow::new("lack of fit", split.df, split.sum_of_squares).against(error, pure_error.df));
            anova.push(AnovaRow::new("pure error", pure_error.df, pure_error.sum_of_squares));
        }
        None => {
            if residual.0 > 0 && !is_rounding(residual.1, y) {
                anova[0] = anova[0].clone().against(residual.1 / residual.0 as f64, residual.0);
            }
            anova.push(AnovaRow::new("residual", residual.0, residual.1));
        }
    }
    anova.push(AnovaRow::new("total", total.0, total.1));
    Ok((Reduced { natural: design.natural_equation(&by_factors), coded, model, residual, lack_of_fit }, adequacy, anova))
}

/// Fisher's F: the distance of the reduced model from the means of the treatments, in units of their own scatter.
fn adequacy(
    fitted: &[f64],
    residual_df: usize,
    pure_error: &PureError,
    replicated: bool,
    alpha: f64,
    notes: &mut Vec<String>,
) -> Option<Verdict> {
    if !replicated {
        notes.push("Adequacy cannot be tested: there is no scatter of repeated runs to compare the lack of fit with.".into());
        return None;
    }
    let df = residual_df - pure_error.df;
    if df == 0 {
        notes.push("Adequacy cannot be tested: the kept terms are as many as the treatments, so the model meets every mean.".into());
        return None;
    }
    let misfit: DoubleDouble = pure_error
        .fitted
        .iter()
        .zip(fitted)
        .map(|(&mean, &fit)| {
            let distance = mean - DoubleDouble::from(fit);
            distance * distance
        })
        .sum();
    let statistic = misfit.to_f64() / df as f64 / (pure_error.sum_of_squares / pure_error.df as f64);
    let (numerator, denominator) = (df as f64, pure_error.df as f64);
    let critical = distribution::fisher_critical(alpha, numerator, denominator);
    Some(Verdict {
        test: "Fisher F".into(),
        statistic,
        critical,
        df: (numerator, denominator),
        p: Some(distribution::fisher_upper(statistic, numerator, denominator)),
        holds: statistic <= critical,
    })
}
