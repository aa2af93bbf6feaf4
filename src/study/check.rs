//! Does a campaign hold what it should? One judgement for each question and each response, run or estimate.

use super::baseline::Baseline;
use super::campaign::{CampaignStudy, Regression, RunStudy};
use super::comparison::Comparison;
use super::response;
use crate::experiment::CheckRules;
use crate::experiment::check::Question;
use crate::fit::Termination;
use crate::statistics::box_wilson::{Analysis, ErrorSource};
use crate::statistics::residuals::Diagnostics;

/// What a judgement is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Subject {
    /// The campaign as a whole.
    Campaign,
    /// A run, by its id.
    Run(String),
    /// Something that was set aside and belongs to no run: file and row.
    Input(String),
    /// A response, by its column.
    Response(String),
    Coefficient {
        response: String,
        term: String,
    },
    /// A quantity of a run: p, q, s or m.
    Estimate {
        run: String,
        quantity: String,
    },
}

/// The number that decided.
#[derive(Debug, Clone, PartialEq)]
pub enum Measure {
    /// Holds if `p >= alpha`.
    Test { test: String, statistic: f64, p: f64, alpha: f64 },
    /// Predicted minus fitted (or their distance), m; holds if not further off than `limit`.
    Length { off: f64, limit: f64 },
    /// Predicted minus fitted fold count.
    Folds { off: i64, limit: u32 },
    /// `moved` is the difference in units of `standard_error`; `None` for an estimate without one, which may not move beyond rounding.
    Drift { baseline: f64, estimate: f64, standard_error: Option<f64>, moved: Option<f64>, limit: f64 },
}

/// How a question is answered.
#[derive(Debug, Clone, PartialEq)]
pub enum Status {
    Holds,
    Fails,
    /// It fails or cannot be answered, and `campaign.toml` says so, with the reason.
    Expected {
        reason: String,
    },
    /// `campaign.toml` expects it to fail, but it does not: the entry hides the next failure and has to go.
    Stale {
        reason: String,
    },
    /// It was asked and cannot be answered.
    Unanswered,
    /// There is no limit or no baseline to hold it against.
    NotAsked,
}

/// One question about one subject, answered.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    pub question: Question,
    pub subject: Subject,
    pub status: Status,
    pub measure: Option<Measure>,
    /// What the measure does not say: why there is none, what is wrong. Empty where there is nothing to say.
    pub remark: String,
}

/// All judgements in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Conclusion {
    /// Everything that was asked holds, or fails as expected.
    Holds,
    /// Something fails, and all that was asked could be answered.
    Fails,
    /// Something that was asked could not be answered; what fails beside it may not be all.
    Unanswered,
}

/// What drift is measured from.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// No baseline was given, for this reason.
    None(String),
    Baseline(Baseline),
    /// One was given but cannot be used.
    Unusable(String),
}

/// Answers every question that the campaign's rules ask, in the order of [`Question::ALL`].
pub fn check(study: &CampaignStudy, reference: &Reference) -> Vec<Judgement> {
    let rules = &study.campaign.check;
    let mut judgements = fitted(study);
    judgements.extend(responses(study, rules));
    judgements.extend(theory(study, rules));
    judgements.extend(drift(study, rules, reference));
    accept(study, rules, &mut judgements);
    judgements.sort_by_key(|j| j.question);
    judgements
}

/// The worst of them decides; a question without an answer is worse than a failure.
pub fn conclusion(judgements: &[Judgement]) -> Conclusion {
    let any = |wanted: fn(&Status) -> bool| judgements.iter().any(|j| wanted(&j.status));
    if any(|s| matches!(s, Status::Unanswered)) {
        Conclusion::Unanswered
    } else if any(|s| matches!(s, Status::Fails | Status::Stale { .. })) {
        Conclusion::Fails
    } else {
        Conclusion::Holds
    }
}

fn judge(question: Question, subject: Subject, status: Status, measure: Option<Measure>, remark: impl Into<String>) -> Judgement {
    Judgement { question, subject, status, measure, remark: remark.into() }
}

fn holds_if(good: bool) -> Status {
    if good { Status::Holds } else { Status::Fails }
}

/// Every run of the design, and whatever was set aside without belonging to one of them.
fn fitted(study: &CampaignStudy) -> Vec<Judgement> {
    let about =
        |id: &str| -> Vec<String> { study.quarantine.iter().filter(|q| q.run.as_deref() == Some(id)).map(ToString::to_string).collect() };
    let mut judgements: Vec<Judgement> = study
        .runs
        .iter()
        .map(|run| {
            let set_aside = about(&run.run.id);
            let (status, remark) = match &run.fit {
                Err(_) if run.profile.is_none() && !set_aside.is_empty() => (Status::Fails, set_aside.join("; ")),
                Err(reason) => (Status::Fails, reason.clone()),
                Ok(_) if !set_aside.is_empty() => (Status::Fails, format!("fitted, but something was set aside: {}", set_aside.join("; "))),
                Ok(fit) if matches!(fit.termination, Termination::Stalled | Termination::EvaluationLimit) => {
                    (Status::Fails, "the fit ended before its tolerance".into())
                }
                Ok(_) => (Status::Holds, String::new()),
            };
            judge(Question::Fitted, Subject::Run(run.run.id.clone()), status, None, remark)
        })
        .collect();
    for item in &study.quarantine {
        let subject = match &item.run {
            Some(id) if study.runs.iter().any(|run| run.run.id == *id) => continue,
            Some(id) => Subject::Run(id.clone()),
            None => Subject::Input(match item.row {
                Some(row) => format!("{}, row {row}", item.file.display()),
                None => item.file.display().to_string(),
            }),
        };
        judgements.push(judge(Question::Fitted, subject, Status::Fails, None, item.to_string()));
    }
    judgements
}

/// The regressions that the rules name; `None` for a name that has none.
fn checked<'a>(study: &'a CampaignStudy, rules: &CheckRules) -> Vec<(String, Option<&'a Regression>)> {
    let weighed = response::weighed(&study.campaign);
    let column = |name: &String| response::named(name, weighed).map_or_else(|| name.clone(), |r| r.column.to_string());
    rules.responses.iter().map(column).map(|column| (column.clone(), study.regressions.iter().find(|r| r.response == column))).collect()
}

fn responses(study: &CampaignStudy, rules: &CheckRules) -> Vec<Judgement> {
    let mut judgements = Vec::new();
    for (column, regression) in checked(study, rules) {
        let analysis = match regression.map(|r| &r.analysis) {
            Some(Ok(analysis)) => Ok(analysis),
            Some(Err(reason)) => Err(reason.clone()),
            None => Err("it is not regressed".to_string()),
        };
        let diagnostics = match regression.map(|r| &r.further) {
            Some(further) => further.as_ref().map(|f| &f.diagnostics).map_err(String::clone),
            None => Err("it is not regressed".into()),
        };
        for question in Question::ALL.into_iter().filter(|q| q.of_responses()) {
            let answer = match (&analysis, &diagnostics) {
                (Ok(analysis), Ok(diagnostics)) => answer(question, analysis, diagnostics),
                (Err(reason), _) | (_, Err(reason)) => Answer::None(reason.clone()),
            };
            let (status, measure, remark) = match answer {
                Answer::Test { test, statistic, p } => {
                    (holds_if(rules.alpha <= p), Some(Measure::Test { test, statistic, p, alpha: rules.alpha }), String::new())
                }
                Answer::Holds(remark) => (Status::Holds, None, remark),
                Answer::None(reason) => (Status::Unanswered, None, reason),
            };
            judgements.push(judge(question, Subject::Response(column.clone()), status, measure, remark));
        }
    }
    judgements
}

enum Answer {
    Test {
        test: String,
        statistic: f64,
        p: f64,
    },
    /// True without a test, for this reason.
    Holds(String),
    /// Not to be had, for this reason.
    None(String),
}

fn answer(question: Question, analysis: &Analysis, diagnostics: &Diagnostics) -> Answer {
    let no_residuals = || {
        let why = if analysis.full.residual_df == 0 {
            "the model takes every degree of freedom, so there are no residuals to look at"
        } else {
            "the runs agree with the model to the last digit, so there are no residuals to look at"
        };
        Answer::None(why.into())
    };
    let verdict = match question {
        Question::Reproducibility => &analysis.equal_variances,
        Question::Adequacy => &analysis.adequacy,
        Question::Normality => {
            let found = diagnostics.normality.as_ref();
            return found.map_or_else(no_residuals, |n| Answer::Test { test: "Shapiro–Wilk W".into(), statistic: n.w, p: n.p });
        }
        _ => {
            let found = diagnostics.durbin_watson.zip(diagnostics.durbin_watson_p);
            return found.map_or_else(no_residuals, |(d, p)| Answer::Test { test: "Durbin–Watson d".into(), statistic: d, p });
        }
    };
    if let Some((verdict, p)) = verdict.as_ref().and_then(|v| Some((v, v.p?))) {
        return Answer::Test { test: verdict.test.clone(), statistic: verdict.statistic, p };
    }
    let repeated = analysis.cells.iter().filter(|cell| cell.runs.len() > 1).count();
    match analysis.error.map(|error| error.source) {
        // There is an error to test against, so only the last degree of freedom can be missing.
        Some(ErrorSource::PureError) if question == Question::Adequacy => {
            Answer::Holds("the kept terms are as many as the treatments, so the model meets every mean".into())
        }
        _ if repeated == 0 => Answer::None("no treatment was repeated".into()),
        _ if repeated == 1 && question == Question::Reproducibility => Answer::None("only one treatment was repeated".into()),
        _ => Answer::None("repeated runs agree to the last digit: there is no scatter to test with".into()),
    }
}

/// Whether a run keeps a limit and by what measure, or why that cannot be said.
type Kept = Result<(bool, Measure), String>;

fn theory(study: &CampaignStudy, rules: &CheckRules) -> Vec<Judgement> {
    let mut judgements = Vec::new();
    let mut ask = |question: Question, asked: bool, judged: &dyn Fn(&RunStudy) -> Kept| {
        if !asked {
            let remark = format!("[check] in campaign.toml sets no {}", limit_key(question));
            judgements.push(judge(question, Subject::Campaign, Status::NotAsked, None, remark));
            return;
        }
        for run in &study.runs {
            let subject = Subject::Run(run.run.id.clone());
            judgements.push(match judged(run) {
                // Counted where fits are asked for; without one there is nothing to compare.
                _ if run.fit.is_err() => judge(question, subject, Status::NotAsked, None, "the run is not fitted"),
                Ok((good, measure)) => judge(question, subject, holds_if(good), Some(measure), ""),
                Err(reason) => judge(question, subject, Status::Unanswered, None, reason),
            });
        }
    };
    let missing = |run: &RunStudy| {
        run.prediction_missing.clone().unwrap_or_else(|| "the theory has no hem with as many folds as are fitted".to_string())
    };
    let mut ask_length = |question: Question, limit: Option<f64>, pick: fn(&Comparison) -> f64| {
        ask(question, limit.is_some(), &|run| {
            let limit = limit.unwrap_or_default();
            let off = run.comparison.as_ref().map(pick).ok_or_else(|| missing(run))?;
            Ok((off.abs() <= limit, Measure::Length { off, limit }))
        });
    };
    ask_length(Question::TheoryRms, rules.theory_rms, |c| c.rms);
    ask_length(Question::TheoryFoldDepth, rules.theory_fold_depth, |c| c.depth);
    ask_length(Question::TheoryMeanRadius, rules.theory_mean_radius, |c| c.mean_radius);
    ask(Question::TheoryFoldCount, rules.theory_fold_count.is_some(), &|run| {
        let limit = rules.theory_fold_count.unwrap_or_default();
        let (fit, prediction) = (run.fit.as_ref()?, run.prediction.as_ref().ok_or_else(|| missing(run))?);
        // A round hem has no folds.
        let off = i64::from(prediction.folds) - i64::from(fit.folds.unwrap_or(0));
        Ok((off.unsigned_abs() <= u64::from(limit), Measure::Folds { off, limit }))
    });
    judgements
}

/// The key of `[check]` that sets the limit of a question.
fn limit_key(question: Question) -> String {
    if question == Question::TheoryFoldCount { format!("{}_off", question.name()) } else { format!("{}_mm", question.name()) }
}

/// A move by less than this share of the estimate is rounding (another machine's sine, another order of summation), however small its error;
/// all that an estimate without a standard error may do.
const ROUNDING: f64 = 1e-9;

fn drift(study: &CampaignStudy, rules: &CheckRules, reference: &Reference) -> Vec<Judgement> {
    let whole = |status, remark: &str| vec![judge(Question::Drift, Subject::Campaign, status, None, remark)];
    let baseline = match reference {
        Reference::None(why) => return whole(Status::NotAsked, why),
        Reference::Unusable(why) => return whole(Status::Unanswered, why),
        Reference::Baseline(baseline) => baseline,
    };
    let columns: Vec<String> = checked(study, rules).into_iter().map(|(column, _)| column).collect();
    let (old, new) = (records(baseline, &columns), records(&Baseline::of(study), &columns));
    let mut judgements: Vec<Judgement> = old
        .iter()
        .map(|(subject, before, before_error)| {
            let (status, measure, remark) = match new.iter().find(|(other, ..)| other == subject) {
                None => (Status::Fails, None, format!("was {before}, does not exist any more")),
                Some((_, estimate, error)) => {
                    let (good, measure) = moved((*before, *before_error), (*estimate, *error), rules.drift);
                    (holds_if(good), Some(measure), String::new())
                }
            };
            judge(Question::Drift, subject.clone(), status, measure, remark)
        })
        .collect();
    let unknown = new.into_iter().filter(|(subject, ..)| !old.iter().any(|(other, ..)| other == subject));
    judgements.extend(unknown.map(|(subject, ..)| {
        judge(Question::Drift, subject, Status::Unanswered, None, "not in the baseline; `--update-baseline` takes it in")
    }));
    judgements
}

/// Estimate and standard error of each subject, of the responses that are checked.
fn records(baseline: &Baseline, columns: &[String]) -> Vec<(Subject, f64, Option<f64>)> {
    let coefficients = baseline
        .coefficients
        .iter()
        .filter(|c| columns.contains(&c.response))
        .map(|c| (Subject::Coefficient { response: c.response.clone(), term: c.term.clone() }, c.estimate, c.se));
    let runs = baseline.runs.iter().map(|r| (Subject::Estimate { run: r.run.clone(), quantity: r.quantity.clone() }, r.estimate, r.se));
    coefficients.chain(runs).collect()
}

/// How far an estimate went. The smaller of the two standard errors is the measure, so that one that has grown cannot hide a move.
fn moved((before, before_error): (f64, Option<f64>), (estimate, error): (f64, Option<f64>), limit: f64) -> (bool, Measure) {
    let difference = estimate - before;
    let standard_error = [before_error, error].into_iter().flatten().filter(|e| 0.0 < *e).reduce(f64::min);
    let moved = standard_error.map(|e| difference / e);
    let good = difference.abs() <= ROUNDING * before.abs().max(estimate.abs()) || moved.is_some_and(|moved| moved.abs() <= limit);
    (good, Measure::Drift { baseline: before, estimate, standard_error, moved, limit })
}

/// Marks the failures that the campaign expects, and the expectations that nothing meets any more.
fn accept(study: &CampaignStudy, rules: &CheckRules, judgements: &mut Vec<Judgement>) {
    let weighed = response::weighed(&study.campaign);
    for expected in &rules.expected {
        for name in &expected.subjects {
            let reason = expected.reason.clone();
            let subject = match expected.question.of_responses() {
                true => Subject::Response(response::named(name, weighed).map_or_else(|| name.clone(), |r| r.column.to_string())),
                false => Subject::Run(name.clone()),
            };
            let met = judgements.iter_mut().find(|j| j.question == expected.question && j.subject == subject);
            match met {
                Some(j) if matches!(j.status, Status::Fails | Status::Unanswered) => j.status = Status::Expected { reason },
                Some(j) if j.status == Status::Holds => j.status = Status::Stale { reason },
                // Said twice.
                Some(j) if matches!(j.status, Status::Expected { .. } | Status::Stale { .. }) => (),
                _ => judgements.push(judge(expected.question, subject, Status::Stale { reason }, None, "it is not asked")),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_has_grown_cannot_hide_a_move() {
        let (good, measure) = moved((10.0, Some(0.1)), (10.3, Some(100.0)), 1.0);
        let Measure::Drift { moved: Some(moved), .. } = measure else { panic!("{measure:?}") };
        assert!(!good && (moved - 3.0).abs() < 1e-12);
        assert!(super::moved((10.0, Some(0.4)), (10.3, Some(0.4)), 1.0).0);
    }

    #[test]
    fn an_estimate_without_an_error_may_not_move() {
        assert!(moved((6.0, None), (6.0, None), 1.0).0 && !moved((6.0, None), (7.0, None), 1.0).0);
        assert!(moved((0.0, None), (0.0, None), 1.0).0);
        // A summation in another order is no move.
        assert!(moved((1.0, None), (1.0 + 1e-15, None), 1.0).0 && moved((1.0, Some(1e-18)), (1.0 + 1e-15, Some(1e-18)), 1.0).0);
    }

    #[test]
    fn what_cannot_be_answered_outweighs_what_fails() {
        let of = |status: Status| judge(Question::Fitted, Subject::Campaign, status, None, "");
        let stale = Status::Stale { reason: "r".into() };
        assert_eq!(conclusion(&[of(Status::Holds), of(Status::NotAsked), of(Status::Expected { reason: "r".into() })]), Conclusion::Holds);
        assert_eq!(conclusion(&[of(Status::Holds), of(stale)]), Conclusion::Fails);
        assert_eq!(conclusion(&[of(Status::Fails), of(Status::Unanswered)]), Conclusion::Unanswered);
    }
}
