//! Hard tables and tails: regressions and probabilities at growing severity, against closed forms and exact sums.

use std::f64::consts::PI;

use super::{Answer, Case, Outcome, Subject, digits};
use crate::error::Error;
use crate::numerics::double_double::{DoubleDouble, sum};
use crate::statistics::box_wilson::{Analysis, Options, analyse};
use crate::statistics::distribution::{chi_squared_upper, fisher_upper, student_critical, student_two_sided};
use crate::statistics::factorial::{Axis, FactorialDesign};
use crate::statistics::linear_model::{LinearModel, Regressors, ordinary};
use crate::statistics::residuals::{suspects, without_suspects};

/// 2^k corners in standard order, all of them `replicates` times in turn.
pub fn corners(k: usize, replicates: usize) -> Vec<Vec<f64>> {
    (0..replicates << k).map(|run| (0..k).map(|i| if run >> i & 1 == 1 { 1.0 } else { -1.0 }).collect()).collect()
}

/// Factors a, b, c … in coded units.
pub fn axes(k: usize) -> Vec<Axis> {
    ["a", "b", "c", "d", "e", "f"][..k].iter().map(|name| Axis::coded(*name)).collect()
}

/// A fixed irregular sequence within ±½: the finalizer of SplitMix64 (Steele, Lea & Flood 2014) applied to the run number.
pub fn noise(run: usize) -> f64 {
    let mut z = (run as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / 2f64.powi(53) - 0.5
}

fn analysed(design: &FactorialDesign, y: &[f64]) -> Result<Analysis, Error> {
    let y: Vec<Option<f64>> = y.iter().copied().map(Some).collect();
    analyse(design, &y, &Options::default())
}

fn relative(found: f64, exact: f64) -> f64 {
    if found == exact { 0.0 } else { (found - exact).abs() / exact.abs() }
}

/// Notes that tell a reader that something could not be told.
fn careful(analysis: &Analysis) -> Option<String> {
    (!analysis.notes.is_empty()).then(|| analysis.notes.join("; "))
}

/// Effects of order one on an offset of this size: each is a signed mean of the responses, which are what they are.
fn offset(size: f64, _: u64) -> Answer {
    let run = || -> Result<Answer, Error> {
        let design = FactorialDesign::new(axes(3), corners(3, 5))?;
        let y: Vec<f64> = design.levels().iter().enumerate().map(|(i, x)| size + 1.0 + x[0] - 0.5 * x[1] * x[2] + 0.1 * noise(i)).collect();
        let found = analysed(&design, &y)?;
        let mut worst = 0.0_f64;
        for (j, term) in design.term_factors().iter().enumerate() {
            let sign = |x: &[f64]| term.iter().map(|&k| x[k]).product::<f64>();
            let exact = sum(design.levels().iter().zip(&y).map(|(x, y)| sign(x) * y)) / DoubleDouble::from(y.len() as f64);
            // The smallest effects are of order 0.01; digits count in those of order one.
            worst = worst.max((found.coefficients[j].estimate - exact.to_f64()).abs() / exact.abs().to_f64().max(1.0));
        }
        Ok(Answer { condition: Some(size.max(1.0)), ..Answer::judged(digits(worst), 14.0, careful(&found)) })
    };
    run().unwrap_or_else(Answer::refused)
}

fn aliased(model: &LinearModel) -> Option<String> {
    let named: Vec<&str> = model.aliases.iter().map(|alias| alias.term.as_str()).collect();
    (!named.is_empty()).then(|| format!("no coefficient of its own: {}", named.join(", ")))
}

fn nearly_aliased(model: &LinearModel) -> Option<String> {
    let near = &model.near_aliases;
    let fewest = near.iter().map(|alias| alias.digits()).reduce(f64::min)?;
    let named: Vec<&str> = near.iter().map(|alias| alias.term.as_str()).collect();
    Some(format!("nearly combinations of the others, about {:.0} digits: {}", fewest.floor(), named.join(", ")))
}

/// Worst of estimates that should all have these values; aliased ones are no answer.
fn estimates(model: Result<LinearModel, Error>, exact: impl Fn(usize) -> f64, promised: f64, condition: Option<f64>) -> Answer {
    let model = match model {
        Ok(model) => model,
        Err(refused) => return Answer::refused(refused),
    };
    if let Some(said) = aliased(&model) {
        return Answer { condition, ..Answer::refused(said) };
    }
    let error = |(j, e): (usize, &crate::statistics::linear_model::Estimate)| (e.estimate - exact(j)).abs() / exact(j).abs().max(1.0);
    let worst = model.estimates.iter().enumerate().map(error).fold(0.0, f64::max);
    Answer { condition, ..Answer::judged(digits(worst), promised, nearly_aliased(&model)) }
}

/// Powers of 0 … 20 up to this degree, all coefficients 1 (Wampler, J. Amer. Statist. Assoc. 65 (1970) 549–565); sums of integers, so exact up to 12.
fn polynomial(degree: f64, _: u64) -> Answer {
    let x: Vec<f64> = (0..21).map(f64::from).collect();
    let degree = degree as usize;
    // Beyond the number of points nothing exact is needed: the columns are dependent.
    let y: Vec<f64> = x.iter().map(|x| (0..=degree.min(12)).map(|k| x.powi(k as i32)).sum()).collect();
    // Sensitivity of the highest coefficient to a change of the data: h^d d! / Σ|binomials| grows like this.
    let condition = (1..=degree.min(20)).map(|k| 20.0 / k as f64).product::<f64>();
    estimates(Regressors::polynomial(&x, degree).and_then(|columns| ordinary(&columns, &y)), |_| 1.0, 12.0, Some(condition.max(1.0)))
}

/// Two columns alike but for a part in 2ᵏ, exact to the last bit; 99: quite alike.
fn collinear(power: f64, _: u64) -> Answer {
    alike_to(power, |i| (1000.0 * noise(i)).round())
}

/// The same of numbers that do not end: columns and response are rounded to doubles, as all that is measured.
fn collinear_rounded(power: f64, _: u64) -> Answer {
    alike_to(power, noise)
}

fn alike_to(power: f64, entry: impl Fn(usize) -> f64) -> Answer {
    let n = 24;
    let a: Vec<f64> = (0..n).map(&entry).collect();
    let c: Vec<f64> = (0..n).map(|i| entry(i + 100)).collect();
    let alike = 60.0 < power;
    let scale = if alike { 1.0 } else { 2f64.powf(power) };
    let b: Vec<f64> = a.iter().zip(&c).map(|(a, c)| a + if alike { 0.0 } else { c / scale }).collect();
    let y: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + b).collect();
    let names = ["1", "a", "b"].map(String::from).to_vec();
    let columns = Regressors::new(names, vec![vec![1.0; n], a, b]);
    let condition = (!alike).then_some(scale);
    estimates(columns.and_then(|columns| ordinary(&columns, &y)), |j| if j == 0 { 0.0 } else { 1.0 }, 12.0, condition)
}

/// Three factors, three replicates, this many corners without any run: the model can still not do better than the means of the cells.
fn missing_corners(count: f64, _: u64) -> Answer {
    let run = || -> Result<Answer, Error> {
        let design = FactorialDesign::new(axes(3), corners(3, 3))?;
        let y: Vec<Option<f64>> =
            (0..design.runs()).map(|i| (count as usize <= i % 8).then(|| 10.0 + design.levels()[i][0] + noise(i))).collect();
        let found = analyse(&design, &y, &Options::default())?;
        let mut worst = 0.0_f64;
        for (i, fitted) in found.used_runs.iter().zip(&found.full.fitted) {
            let cell = (0..design.runs()).filter(|k| k % 8 == i % 8).filter_map(|k| y[k]);
            worst = worst.max(relative(*fitted, sum(cell).to_f64() / 3.0));
        }
        let said = (!found.aliases.is_empty()).then(|| format!("{} terms aliased", found.aliases.len()));
        let answer = Answer::judged(digits(worst), 14.0, careful(&found).or(said.clone()));
        // What is left is right, but less than was asked; unless that is said, it is wrong.
        Ok(match (count as usize, said) {
            (0, _) => answer,
            (_, Some(said)) => Answer { outcome: answer.outcome.max(Outcome::Warned), said, ..answer },
            (_, None) => Answer { outcome: Outcome::Wrong, said: "aliased terms are not named".into(), ..answer },
        })
    };
    run().unwrap_or_else(Answer::refused)
}

/// Scatter of this share of the responses: its standard deviation, by exact sums.
fn little_scatter(share: f64, _: u64) -> Answer {
    let run = || -> Result<Answer, Error> {
        let design = FactorialDesign::new(axes(2), corners(2, 4))?;
        let y: Vec<f64> = design.levels().iter().enumerate().map(|(i, x)| 5.0 + x[0] + share * noise(i)).collect();
        let found = analysed(&design, &y)?;
        let Some(error) = found.error else { return Ok(Answer::refused(careful(&found).unwrap_or_default())) };
        let mut square = DoubleDouble::ZERO;
        for cell in 0..4 {
            let values = || (0..16).filter(|i| i % 4 == cell).map(|i| y[i]);
            let mean = sum(values()) / DoubleDouble::from(4.0);
            for value in values() {
                let away = DoubleDouble::from(value) - mean;
                square = square + away * away;
            }
        }
        let exact = (square / DoubleDouble::from(12.0)).sqrt().to_f64();
        Ok(Answer { condition: Some(1.0 / share), ..Answer::judged(digits(relative(error.variance.sqrt(), exact)), 12.0, careful(&found)) })
    };
    run().unwrap_or_else(Answer::refused)
}

/// One run of forty off by so many standard deviations: found, and the rest analysed as if it had never been.
fn outlier(deviations: f64, _: u64) -> Answer {
    let run = || -> Result<Answer, Error> {
        let design = FactorialDesign::new(axes(3), corners(3, 5))?;
        let mut y: Vec<f64> = design.levels().iter().enumerate().map(|(i, x)| 10.0 + x[0] - 0.5 * x[1] + 0.2 * noise(i)).collect();
        let mut clean: Vec<Option<f64>> = y.iter().copied().map(Some).collect();
        clean[17] = None;
        let clean = analyse(&design, &clean, &Options::default())?;
        y[17] += deviations * clean.error.map_or(0.0, |error| error.variance.sqrt());
        let disturbed = analysed(&design, &y)?;
        let named: Vec<usize> = suspects(&disturbed, 0.05).iter().map(|suspect| suspect.run).collect();
        if named.is_empty() {
            // Five deviations are beyond what forty runs do by chance; four cells' worth of the run itself hide a part of that.
            return Ok(if deviations < 6.0 { Answer::refused("no run stands out") } else { Answer::judged(0.0, 14.0, None) });
        }
        let all: Vec<Option<f64>> = y.into_iter().map(Some).collect();
        let without = without_suspects(&design, &all, &disturbed, &Options::default());
        let same = matches!(without, Ok(Some(ref without)) if *without == clean);
        Ok(Answer { condition: Some(deviations), ..Answer::judged(if same { 16.0 } else { 0.0 }, 14.0, None) })
    };
    run().unwrap_or_else(Answer::refused)
}

/// Student's t with one degree of freedom is Cauchy's law: P = 2/π · atan(1/t).
fn student_tail(t: f64, _: u64) -> Answer {
    Answer { condition: Some(1.0), ..Answer::judged(digits(relative(student_two_sided(t, 1.0), 2.0 / PI * (1.0 / t).atan())), 12.0, None) }
}

/// F with two degrees of freedom above: P = (1 + 2f/d)^(−d/2).
fn fisher_many(d: f64, _: u64) -> Answer {
    let exact = (-0.5 * d * (6.0 / d).ln_1p()).exp();
    Answer::judged(digits(relative(fisher_upper(3.0, 2.0, d), exact)), 11.0, None)
}

/// χ² with two degrees of freedom is exponential: P = e^(−x/2), whose own rounding grows with x.
fn chi_squared_tail(x: f64, _: u64) -> Answer {
    let condition = 0.5 * x;
    let exact = (-0.5 * x).exp();
    Answer { condition: Some(condition.max(1.0)), ..Answer::judged(digits(relative(chi_squared_upper(x, 2.0), exact)), 11.0, None) }
}

/// Student's quantile with one degree of freedom: t = cot(πα/2), at α = 10⁻ᵏ.
fn student_quantile(power: f64, _: u64) -> Answer {
    let alpha = 10f64.powf(-power);
    Answer::judged(digits(relative(student_critical(alpha, 1.0), 1.0 / (0.5 * PI * alpha).tan())), 11.0, None)
}

/// The statistics' cases.
pub fn cases() -> Vec<Case> {
    let case = |name, title, reference, severities, run| Case { subject: Subject::Statistics, name, title, reference, severities, run };
    let closed = "closed form";
    vec![
        case("offset", "constant on effects of order one", "exact sums", [1.0, 1e2, 1e4, 1e6, 1e8, 1e12, 1e15, 1e17], offset),
        case("polynomial", "degree of a polynomial in 0 … 20", closed, [1.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 25.0], polynomial),
        case("collinear", "regressors alike to a part in 2ᵏ", closed, [0.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 99.0], collinear),
        case(
            "collinear_rounded",
            "the same, rounded to doubles",
            closed,
            [0.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 99.0],
            collinear_rounded,
        ),
        case(
            "missing_corners",
            "corners of 2³ without a run",
            "means of the cells",
            [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0],
            missing_corners,
        ),
        case(
            "little_scatter",
            "scatter, share of the responses",
            "exact sums",
            [1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-12, 1e-15, 1e-18],
            little_scatter,
        ),
        case(
            "outlier",
            "one run off, standard deviations",
            "the analysis without it",
            [1.0, 3.0, 6.0, 10.0, 30.0, 1e3, 1e8, 1e15],
            outlier,
        ),
        case("student_tail", "Student’s t, one degree of freedom", closed, [0.1, 1.0, 1e2, 1e4, 1e8, 1e30, 1e100, 1e150], student_tail),
        case("fisher_many", "F (2, d): degrees of freedom d", closed, [1.0, 10.0, 1e2, 1e3, 1e4, 1e6, 1e8, 1e12], fisher_many),
        case("chi_squared_tail", "χ² (2) at x", closed, [1e-3, 1.0, 10.0, 50.0, 100.0, 300.0, 700.0, 1400.0], chi_squared_tail),
        case(
            "student_quantile",
            "Student’s quantile (1) at 10⁻ᵏ",
            closed,
            [0.5, 1.0, 3.0, 6.0, 12.0, 50.0, 150.0, 290.0],
            student_quantile,
        ),
    ]
}
