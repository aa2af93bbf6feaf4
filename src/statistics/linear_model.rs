//! Least squares on given regressors: estimates with their errors, and what every single run does to them.
//!
//! By orthogonal factorization in double-double arithmetic ([`crate::numerics::pivoted_qr`]), never by normal equations: what the doubles
//! given determine is returned to nearly the last digit, whatever the condition of the regressors.
//!
//! Source of the formulas: Draper & Smith, Applied Regression Analysis (3rd ed., 1998), chapters 1–8; of the influence measures Cook &
//! Weisberg, Residuals and Influence in Regression (1982).

use serde::Serialize;

use crate::error::Error;
use crate::numerics::double_double::{DoubleDouble, sum};
use crate::numerics::pivoted_qr::{PivotedQr, dot};
use crate::statistics::distribution;

/// Below this part of 1, `1 − leverage` is rounding: the run is fitted exactly whatever its response.
const FULL_LEVERAGE: f64 = 1e-10;

/// A coefficient is said to be [`NearAlias`] if rounding of the numbers given may move it by more than this part: twelve digits are promised otherwise.
const KEPT: f64 = 1e-12;

/// Named columns, one entry per run.
#[derive(Debug, Clone)]
pub struct Regressors {
    names: Vec<String>,
    columns: Vec<Vec<DoubleDouble>>,
    rows: usize,
}

impl Regressors {
    /// `columns[j][row]`, all of one length and finite.
    ///
    /// # Errors
    /// [`Error::Unanswerable`] if there is no column or no row, lengths differ or an entry is not finite.
    pub fn new(names: Vec<String>, columns: Vec<Vec<f64>>) -> Result<Self, Error> {
        let columns = columns.into_iter().map(|column| column.into_iter().map(DoubleDouble::from).collect()).collect();
        Self::from_double_double(names, columns)
    }

    /// `1, x, x², …, x^degree`, the powers in twice the working precision: rounding them to doubles would cost six digits at degree 10.
    ///
    /// # Errors
    /// [`Error::Unanswerable`] if `x` is empty or not finite.
    pub fn polynomial(x: &[f64], degree: usize) -> Result<Self, Error> {
        let mut names = vec!["1".to_string()];
        let mut columns = vec![vec![DoubleDouble::ONE; x.len()]];
        for power in 1..=degree {
            names.push(if power == 1 { "x".into() } else { format!("x^{power}") });
            columns.push(columns[power - 1].iter().zip(x).map(|(&entry, &x)| entry * DoubleDouble::from(x)).collect());
        }
        Self::from_double_double(names, columns)
    }

    fn from_double_double(names: Vec<String>, columns: Vec<Vec<DoubleDouble>>) -> Result<Self, Error> {
        let rows = columns.first().map_or(0, Vec::len);
        if rows == 0 || names.len() != columns.len() {
            return Err(Error::Unanswerable("a regression needs at least one run and one named regressor".into()));
        }
        for (name, column) in names.iter().zip(&columns) {
            if column.len() != rows {
                return Err(Error::Unanswerable(format!("regressor “{name}” has {} entries, the first one {rows}", column.len())));
            }
            if let Some(row) = column.iter().position(|entry| !entry.is_finite()) {
                return Err(Error::Unanswerable(format!("regressor “{name}” is not finite in run {}", row + 1)));
            }
        }
        Ok(Regressors { names, columns, rows })
    }

    /// One more column, behind the others; of the same length and finite.
    pub(crate) fn with_column(mut self, name: String, column: Vec<f64>) -> Self {
        self.names.push(name);
        self.columns.push(column.into_iter().map(DoubleDouble::from).collect());
        self
    }

    pub fn names(&self) -> &[String] {
        &self.names
    }

    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Factorized for any number of responses at equal weights.
    pub fn decompose(&self) -> Decomposition {
        self.decompose_scaled(None)
    }

    /// The same with weights: a run of weight w counts like w runs of weight 1.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a weight is not positive and finite; [`Error::Unanswerable`] if there is not one per run.
    pub fn decompose_weighted(&self, weights: &[f64]) -> Result<Decomposition, Error> {
        if weights.len() != self.rows {
            return Err(Error::Unanswerable(format!("{} weights for {} runs", weights.len(), self.rows)));
        }
        if let Some(&value) = weights.iter().find(|weight| !(weight.is_finite() && **weight > 0.0)) {
            return Err(Error::Invalid { quantity: "weight of a run", value, allowed: "finite and > 0" });
        }
        Ok(self.decompose_scaled(Some(weights.to_vec())))
    }

    fn decompose_scaled(&self, weights: Option<Vec<f64>>) -> Decomposition {
        let roots: Option<Vec<DoubleDouble>> =
            weights.as_ref().map(|weights| weights.iter().map(|&w| DoubleDouble::from(w).sqrt()).collect());
        let qr = match &roots {
            None => PivotedQr::new(&self.columns, self.rows),
            Some(roots) => {
                let scaled: Vec<Vec<DoubleDouble>> =
                    self.columns.iter().map(|column| column.iter().zip(roots).map(|(&entry, &root)| entry * root).collect()).collect();
                PivotedQr::new(&scaled, self.rows)
            }
        };
        let constant = roots.clone().unwrap_or_else(|| vec![DoubleDouble::ONE; self.rows]);
        let projected = qr.project(&constant);
        let (whole, seen) = (dot(&constant, &constant), dot(&projected, &projected));
        // 1 lies in the column space if nothing of it is left; squared, hence the square of what counts as dependent, with room for doubles.
        let has_constant = ((whole - seen) / whole).abs().to_f64() < 1e-20;
        let inverse_gram = qr.inverse_gram();
        Decomposition { regressors: self.clone(), weights, roots, qr, has_constant, inverse_gram }
    }
}

/// A regressor that the runs at hand cannot tell from others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Alias {
    pub term: String,
    /// The combination it equals: `(other term, factor)`, factors that vanish left out.
    pub equals: Vec<(String, f64)>,
}

/// A regressor that is nearly a combination of the others: what tells them apart is in the last digits of the numbers given.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NearAlias {
    pub term: String,
    /// How many times errors of the numbers, relative to their column, are enlarged in the coefficient: Stewart's collinearity index.
    pub enlarged: f64,
}

impl NearAlias {
    /// Digits of the coefficient that numbers given as doubles determine.
    pub fn digits(&self) -> f64 {
        (-(ROUNDING * self.enlarged).log10()).max(0.0)
    }
}

/// Of a number that was rounded to a double, half an ulp each in the regressors and in the response, with room for their addition: part of the number.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// One coefficient with its error; the error is `None` where there is nothing to estimate it from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    pub term: String,
    pub estimate: f64,
    /// `√(s² (XᵀX)⁻¹)`; `None` without residual degrees of freedom.
    pub standard_error: Option<f64>,
    /// `None` without, or with no, standard error.
    pub t: Option<f64>,
    pub p: Option<f64>,
}

/// Regressors, factorized once for many responses.
#[derive(Debug, Clone)]
pub struct Decomposition {
    regressors: Regressors,
    weights: Option<Vec<f64>>,
    roots: Option<Vec<DoubleDouble>>,
    qr: PivotedQr,
    has_constant: bool,
    inverse_gram: Vec<Vec<DoubleDouble>>,
}

impl Decomposition {
    pub fn rank(&self) -> usize {
        self.qr.rank()
    }

    pub fn rows(&self) -> usize {
        self.regressors.rows
    }

    /// Whether 1 is a combination of the regressors; if so R² compares with the mean, otherwise with 0.
    pub fn has_constant(&self) -> bool {
        self.has_constant
    }

    /// Names of the regressors that have a coefficient, in the order given.
    pub fn terms(&self) -> impl Iterator<Item = &str> {
        self.qr.independent().iter().map(|&j| self.regressors.names[j].as_str())
    }

    /// The regressors that are combinations of earlier ones.
    pub fn aliases(&self) -> Vec<Alias> {
        self.qr
            .dependent()
            .iter()
            .enumerate()
            .map(|(i, &j)| Alias {
                term: self.regressors.names[j].clone(),
                equals: self
                    .terms()
                    .zip(self.qr.combination(i))
                    .filter(|(_, factor)| factor.abs() > 1e-9)
                    .map(|(term, &factor)| (term.to_string(), factor))
                    .collect(),
            })
            .collect()
    }

    /// The regressors with a coefficient that rounding of the numbers given may move by more than 10⁻¹² of what the regressor explains.
    ///
    /// Their index is `‖xⱼ‖ ‖xⱼ⁺‖ = ‖xⱼ‖ √((XᵀWX)⁻¹)ⱼⱼ`: 1 for an orthogonal column, the root of the variance inflation factor without centring.
    ///
    /// Source: Stewart, Collinearity and least squares regression, Statist. Sci. 2 (1987) 68–84.
    pub fn near_aliases(&self) -> Vec<NearAlias> {
        let index = |(i, &j): (usize, &usize)| {
            let column = self.weigh(&self.regressors.columns[j]);
            let enlarged = (dot(&column, &column) * self.inverse_gram[i][i]).sqrt().to_f64();
            (KEPT < ROUNDING * enlarged).then(|| NearAlias { term: self.regressors.names[j].clone(), enlarged })
        };
        self.qr.independent().iter().enumerate().filter_map(index).collect()
    }

    /// `(XᵀWX)⁻¹` on the terms that have a coefficient; times s² it is their covariance.
    pub fn inverse_gram(&self, i: usize, j: usize) -> f64 {
        self.inverse_gram[i][j].to_f64()
    }

    /// `x (XᵀWX)⁻¹ xᵀ` of a row of regressors `x` (all columns given, in their order): times s² the variance of the prediction there.
    pub fn prediction_variance_factor(&self, row: &[f64]) -> f64 {
        let row: Vec<f64> = self.qr.independent().iter().map(|&j| row[j]).collect();
        let total: DoubleDouble = (0..row.len())
            .flat_map(|i| (0..row.len()).map(move |j| (i, j)))
            .map(|(i, j)| self.inverse_gram[i][j] * DoubleDouble::product(row[i], row[j]))
            .sum();
        total.to_f64()
    }

    /// Orthonormal basis of the (weighted) column space as doubles; `basis[j][row]`.
    pub fn basis(&self) -> Vec<Vec<f64>> {
        self.qr.basis().iter().map(|column| column.iter().map(|entry| entry.to_f64()).collect()).collect()
    }

    /// What each term explains beyond those before it: `(term, sum of squares)`, aliased terms left out.
    ///
    /// # Errors
    /// Those of [`Decomposition::fit`].
    pub fn sequential_sums_of_squares(&self, response: &[f64]) -> Result<Vec<(String, f64)>, Error> {
        let response = self.checked(response)?;
        let projected = self.qr.project(&self.weigh(&response));
        Ok(self.terms().zip(projected).map(|(term, part)| (term.to_string(), (part * part).to_f64())).collect())
    }

    fn checked(&self, response: &[f64]) -> Result<Vec<DoubleDouble>, Error> {
        if response.len() != self.rows() {
            return Err(Error::Unanswerable(format!("{} responses for {} runs", response.len(), self.rows())));
        }
        if let Some(row) = response.iter().position(|value| !value.is_finite()) {
            return Err(Error::Unanswerable(format!("the response of run {} is not finite", row + 1)));
        }
        Ok(response.iter().copied().map(DoubleDouble::from).collect())
    }

    /// Times the roots of the weights.
    fn weigh(&self, values: &[DoubleDouble]) -> Vec<DoubleDouble> {
        match &self.roots {
            None => values.to_vec(),
            Some(roots) => values.iter().zip(roots).map(|(&value, &root)| value * root).collect(),
        }
    }

    /// Least squares of one response.
    ///
    /// # Errors
    /// [`Error::Unanswerable`] if there is not one finite response per run.
    pub fn fit(&self, response: &[f64]) -> Result<LinearModel, Error> {
        let rows = self.rows();
        let exact = self.checked(response)?;
        let projected = self.qr.project(&self.weigh(&exact));
        let coefficients = self.qr.solve(&projected);
        let fitted: Vec<DoubleDouble> = (0..rows)
            .map(|row| self.qr.independent().iter().zip(&coefficients).map(|(&j, &b)| self.regressors.columns[j][row] * b).sum())
            .collect();
        let residuals: Vec<DoubleDouble> = exact.iter().zip(&fitted).map(|(&y, &fit)| y - fit).collect();
        let scaled_residuals = self.weigh(&residuals);
        let residual_sum_of_squares = dot(&scaled_residuals, &scaled_residuals).to_f64();
        let total_sum_of_squares = self.total_sum_of_squares(&exact);

        let residual_df = rows - self.rank();
        let variance = (residual_df > 0).then(|| residual_sum_of_squares / residual_df as f64);
        let perfect = is_rounding(residual_sum_of_squares, response);
        let estimates = self
            .terms()
            .zip(&coefficients)
            .enumerate()
            .map(|(i, (term, &coefficient))| {
                let standard_error = variance.map(|variance| (variance * self.inverse_gram(i, i)).sqrt());
                let t = standard_error.filter(|se| *se > 0.0 && !perfect).map(|se| coefficient.to_f64() / se);
                let p = t.map(|t| distribution::student_two_sided(t, residual_df as f64));
                Estimate { term: term.to_string(), estimate: coefficient.to_f64(), standard_error, t, p }
            })
            .collect();
        let hat: Vec<DoubleDouble> =
            (0..rows).map(|row| self.qr.basis().iter().map(|column| column[row] * column[row]).sum::<DoubleDouble>()).collect();
        let squares = dot(&scaled_residuals, &scaled_residuals);
        let without: Vec<DoubleDouble> =
            scaled_residuals.iter().zip(&hat).map(|(&e, &h)| squares - e * e / (DoubleDouble::ONE - h)).collect();
        Ok(LinearModel {
            estimates,
            aliases: self.aliases(),
            near_aliases: self.near_aliases(),
            residual_df,
            residual_sum_of_squares,
            total_sum_of_squares,
            has_constant: self.has_constant,
            perfect,
            fitted: fitted.iter().map(|value| value.to_f64()).collect(),
            residuals: residuals.iter().map(|value| value.to_f64()).collect(),
            leverage: hat.iter().map(|h| h.to_f64()).collect(),
            weights: self.weights.clone(),
            without: without.iter().map(|left| left.to_f64()).collect(),
        })
    }

    fn total_sum_of_squares(&self, response: &[DoubleDouble]) -> f64 {
        let weight = |row: usize| self.weights.as_ref().map_or(DoubleDouble::ONE, |weights| weights[row].into());
        let centre = if self.has_constant {
            let total: DoubleDouble = (0..response.len()).map(weight).sum();
            response.iter().enumerate().map(|(row, &y)| weight(row) * y).sum::<DoubleDouble>() / total
        } else {
            DoubleDouble::ZERO
        };
        response.iter().enumerate().map(|(row, &y)| weight(row) * (y - centre) * (y - centre)).sum::<DoubleDouble>().to_f64()
    }
}

/// Whether residuals are no more than the rounding of the responses themselves: rms below 4 ulp of the largest.
///
/// A response that was computed or read carries an error of about half an ulp; four leave room for a few operations.
pub fn is_rounding(residual_sum_of_squares: f64, response: &[f64]) -> bool {
    let largest = response.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
    residual_sum_of_squares <= rounding(response.len(), largest)
}

/// Sum of squares of that rounding.
fn rounding(count: usize, largest: f64) -> f64 {
    count as f64 * (4.0 * f64::EPSILON * largest).powi(2)
}

/// One response on its regressors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LinearModel {
    /// In the order of the regressors, those without a coefficient left out.
    pub estimates: Vec<Estimate>,
    /// Those left out, each with what it equals.
    pub aliases: Vec<Alias>,
    /// Those with a coefficient that keeps less than twelve digits of the numbers given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub near_aliases: Vec<NearAlias>,
    pub residual_df: usize,
    pub residual_sum_of_squares: f64,
    /// About the (weighted) mean if the model has a constant, about 0 otherwise.
    pub total_sum_of_squares: f64,
    pub has_constant: bool,
    /// The residuals are no larger than the rounding of the responses: there is no error to test against.
    pub perfect: bool,
    pub fitted: Vec<f64>,
    /// Observed − fitted.
    pub residuals: Vec<f64>,
    /// Diagonal of the hat matrix, 0…1.
    pub leverage: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    weights: Option<Vec<f64>>,
    /// Residual sum of squares of the fit without each run; meaningless at leverage 1.
    #[serde(skip)]
    without: Vec<f64>,
}

impl LinearModel {
    fn runs(&self) -> usize {
        self.residuals.len()
    }

    fn rank(&self) -> usize {
        self.estimates.len()
    }

    fn weight(&self, run: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |weights| weights[run])
    }

    /// s² on [`LinearModel::residual_df`]; `None` if that is 0.
    pub fn residual_variance(&self) -> Option<f64> {
        (self.residual_df > 0).then(|| self.residual_sum_of_squares / self.residual_df as f64)
    }

    pub fn residual_standard_deviation(&self) -> Option<f64> {
        self.residual_variance().map(f64::sqrt)
    }

    /// `1 − RSS/TSS`; `None` if the responses do not vary.
    pub fn r_squared(&self) -> Option<f64> {
        (self.total_sum_of_squares > 0.0).then(|| 1.0 - self.residual_sum_of_squares / self.total_sum_of_squares)
    }

    /// `1 − s²/(TSS/df)`; `None` without residual degrees of freedom.
    pub fn adjusted_r_squared(&self) -> Option<f64> {
        let total_df = self.runs() - usize::from(self.has_constant);
        let variance = self.residual_variance()?;
        (self.total_sum_of_squares > 0.0).then(|| 1.0 - variance * total_df as f64 / self.total_sum_of_squares)
    }

    /// Degrees of freedom that the regressors take beyond the constant.
    pub fn model_df(&self) -> usize {
        self.rank() - usize::from(self.has_constant)
    }

    pub fn regression_sum_of_squares(&self) -> f64 {
        self.total_sum_of_squares - self.residual_sum_of_squares
    }

    /// Overall F of the regression on (model_df, residual_df); `None` where it has no denominator.
    pub fn f(&self) -> Option<f64> {
        let variance = self.residual_variance()?;
        (self.model_df() > 0 && !self.perfect).then(|| self.regression_sum_of_squares() / self.model_df() as f64 / variance)
    }

    /// Prediction sum of squares, Σ w (e/(1 − h))²; `None` if a run has leverage 1 (nothing is left to predict it from).
    ///
    /// Source: Allen, Technometrics 16 (1974) 125–127.
    pub fn press(&self) -> Option<f64> {
        let parts: Option<Vec<f64>> = (0..self.runs())
            .map(|run| {
                let rest = 1.0 - self.leverage[run];
                (rest > FULL_LEVERAGE).then(|| self.weight(run) * (self.residuals[run] / rest).powi(2))
            })
            .collect();
        parts.map(|parts| sum(parts).to_f64())
    }

    /// `1 − PRESS/TSS`; may be negative.
    pub fn predicted_r_squared(&self) -> Option<f64> {
        self.press().filter(|_| self.total_sum_of_squares > 0.0).map(|press| 1.0 - press / self.total_sum_of_squares)
    }

    /// Residual over its own standard deviation, `e √w / (s √(1 − h))`; `None` at leverage 1, without degrees of freedom or in a perfect fit.
    pub fn standardized_residuals(&self) -> Vec<Option<f64>> {
        let scale = self.residual_standard_deviation().filter(|s| *s > 0.0 && !self.perfect);
        (0..self.runs())
            .map(|run| {
                let rest = 1.0 - self.leverage[run];
                scale.filter(|_| rest > FULL_LEVERAGE).map(|s| self.residuals[run] * self.weight(run).sqrt() / (s * rest.sqrt()))
            })
            .collect()
    }

    /// Residual from the fit without its own run, over its standard deviation: Student t on `residual_df − 1`. `None` as in
    /// [`LinearModel::standardized_residuals`], and where the fit without the run is perfect.
    ///
    /// A run that is off by so much that the others drown in it, even in twice the working precision, gets what it has at least.
    pub fn deleted_residuals(&self) -> Vec<Option<f64>> {
        // Of a difference of double-double numbers, with room for the sums.
        const RESOLVED: f64 = 1e-29;
        let df = self.residual_df as f64;
        let standardized = self.standardized_residuals();
        let size = |run: usize| (self.fitted[run] + self.residuals[run]).abs();
        let largest = (0..self.runs()).max_by(|i, j| size(*i).total_cmp(&size(*j))).unwrap_or(0);
        let second = (0..self.runs()).filter(|run| *run != largest).map(size).fold(0.0, f64::max);
        (0..self.runs())
            .map(|run| {
                standardized[run]?;
                let left = self.without[run].max(RESOLVED * self.residual_sum_of_squares);
                let perfect = left / self.weight(run) <= rounding(self.runs() - 1, if run == largest { second } else { size(largest) });
                if self.residual_df <= 1 || perfect {
                    return None;
                }
                Some(self.residuals[run] * self.weight(run).sqrt() / (left / (df - 1.0) * (1.0 - self.leverage[run])).sqrt())
            })
            .collect()
    }

    /// How far the coefficients move without the run: `r² h / (rank (1 − h))`.
    pub fn cook_distances(&self) -> Vec<Option<f64>> {
        let rank = self.rank() as f64;
        self.standardized_residuals().into_iter().zip(&self.leverage).map(|(r, &h)| r.map(|r| r * r * h / ((1.0 - h) * rank))).collect()
    }
}

/// Least squares of one response at equal weights.
///
/// # Errors
/// Those of [`Decomposition::fit`].
pub fn ordinary(regressors: &Regressors, response: &[f64]) -> Result<LinearModel, Error> {
    regressors.decompose().fit(response)
}

/// Least squares of one response; only the ratios of the weights matter, the scale is estimated.
///
/// # Errors
/// Those of [`Regressors::decompose_weighted`] and [`Decomposition::fit`].
pub fn weighted(regressors: &Regressors, response: &[f64], weights: &[f64]) -> Result<LinearModel, Error> {
    regressors.decompose_weighted(weights)?.fit(response)
}
