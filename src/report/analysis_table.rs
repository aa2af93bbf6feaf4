//! The tables of the regressions: coefficients, diagnostics, power, ways to go, and theory beside measurement; in the unit of each response.

use super::csv::{Cell, Table};
use crate::experiment::Factor;
use crate::statistics::box_wilson::{Analysis, Coefficient, Verdict};
use crate::statistics::effects::Agreement;
use crate::statistics::steepest_ascent::Goal;
use crate::study::campaign::{CampaignStudy, Regression};
use crate::study::further::Further;

/// Those that have an analysis, with what goes beyond it.
fn analysed(regressions: &[Regression]) -> impl Iterator<Item = (&str, &Analysis, Option<&Further>)> {
    regressions.iter().filter_map(|r| Some((r.response.as_str(), r.analysis.as_ref().ok()?, r.further.as_ref().ok())))
}

/// `regression.csv`: one row for each response and term, in coded units; then curvature and blocks, where the design has them.
pub fn regression(regressions: &[Regression]) -> Table {
    let mut table = Table::new(&[
        "response",
        "term",
        "estimate",
        "se",
        "t",
        "p",
        "ci_low",
        "ci_high",
        "p_holm",
        "significant",
        "p_benjamini_hochberg",
        "p_permutation",
        "p_permutation_se",
    ]);
    for (response, analysis, further) in analysed(regressions) {
        for c in analysis.coefficients.iter().chain(&analysis.curvature).chain(&analysis.blocks) {
            let permutation = further.and_then(|f| f.permutation.iter().find(|test| test.term == c.term));
            table.push(vec![
                response.into(),
                c.term.as_str().into(),
                c.estimate.into(),
                c.se.into(),
                c.t.into(),
                c.p.into(),
                c.ci_low.into(),
                c.ci_high.into(),
                c.p_holm.into(),
                c.significant.into(),
                c.p_benjamini_hochberg.into(),
                permutation.map(|test| test.p).into(),
                permutation.and_then(|test| test.p_standard_error).into(),
            ]);
        }
    }
    table
}

/// `weighted.csv`: the same regression, each run weighed by the standard error that its fit gives the response.
pub fn weighted(regressions: &[Regression]) -> Table {
    let columns = ["response", "term", "estimate", "se", "z", "p", "ci_low", "ci_high", "between_runs_sd", "q", "q_p"];
    let mut table = Table::new(&columns);
    for (response, _, further) in analysed(regressions) {
        let Some(weighted) = further.and_then(|f| f.weighted.as_ref()) else { continue };
        for c in &weighted.coefficients {
            table.push(vec![
                response.into(),
                c.term.as_str().into(),
                c.estimate.into(),
                c.se.into(),
                c.z.into(),
                c.p.into(),
                c.ci_low.into(),
                c.ci_high.into(),
                weighted.between_runs.into(),
                weighted.q.into(),
                weighted.q_p.into(),
            ]);
        }
    }
    table
}

/// `diagnostics.csv`: one row for each response: the verdicts, its residuals, the power that would suit it, and the runs that do not fit in.
///
/// `run_ids[run]` names the runs.
pub fn diagnostics(regressions: &[Regression], run_ids: &[&str]) -> Table {
    let mut table = Table::new(&[
        "response",
        "variances_test",
        "variances_statistic",
        "variances_critical",
        "variances_p",
        "adequacy_f",
        "adequacy_critical",
        "adequacy_p",
        "shapiro_wilk_w",
        "shapiro_wilk_p",
        "durbin_watson_d",
        "durbin_watson_p",
        "box_cox_lambda",
        "box_cox_low",
        "box_cox_high",
        "r_squared",
        "predicted_r_squared",
        "suspect_runs",
    ]);
    for (response, analysis, further) in analysed(regressions) {
        let diagnostics = further.map(|f| &f.diagnostics);
        let box_cox = further.and_then(|f| f.box_cox);
        let (variances, adequacy) = (analysis.equal_variances.as_ref(), analysis.adequacy.as_ref());
        let number = |verdict: Option<&Verdict>, pick: fn(&Verdict) -> Option<f64>| Cell::from(verdict.and_then(pick));
        let suspects: Vec<&str> = diagnostics.iter().flat_map(|d| &d.suspects).filter_map(|s| run_ids.get(s.run).copied()).collect();
        table.push(vec![
            response.into(),
            variances.map(|v| v.test.as_str()).into(),
            number(variances, |v| Some(v.statistic)),
            number(variances, |v| Some(v.critical)),
            number(variances, |v| v.p),
            number(adequacy, |v| Some(v.statistic)),
            number(adequacy, |v| Some(v.critical)),
            number(adequacy, |v| v.p),
            diagnostics.and_then(|d| d.normality.as_ref()).map(|n| n.w).into(),
            diagnostics.and_then(|d| d.normality.as_ref()).map(|n| n.p).into(),
            diagnostics.and_then(|d| d.durbin_watson).into(),
            diagnostics.and_then(|d| d.durbin_watson_p).into(),
            box_cox.map(|b| b.lambda).into(),
            box_cox.and_then(|b| b.low).into(),
            box_cox.and_then(|b| b.high).into(),
            analysis.full.r_squared().into(),
            analysis.full.predicted_r_squared().into(),
            (!suspects.is_empty()).then(|| suspects.join(" ")).into(),
        ]);
    }
    table
}

/// `power.csv`: the smallest effect (change from low to high level) that so many replicates would find with a chance of 90 %.
pub fn power(regressions: &[Regression]) -> Table {
    let mut table = Table::new(&["response", "replicates", "smallest_effect", "done"]);
    for (response, _, further) in analysed(regressions) {
        for d in further.iter().flat_map(|f| &f.detectable) {
            table.push(vec![response.into(), d.replicates.into(), d.smallest_effect.into(), d.done.into()]);
        }
    }
    table
}

/// `ascent.csv`: the paths of steepest ascent and descent: factors in natural units, the response predicted at each step, with the interval of
/// its mean and that of a single run.
pub fn ascent(regressions: &[Regression], factors: &[Factor]) -> Table {
    let names = factors.iter().map(|f| f.name.as_str());
    let columns: Vec<&str> = ["response", "goal", "step"]
        .into_iter()
        .chain(names)
        .chain(["predicted", "ci_low", "ci_high", "single_run_low", "single_run_high", "explored"])
        .collect();
    let mut table = Table::new(&columns);
    for (response, _, further) in analysed(regressions) {
        for way in further.iter().flat_map(|f| &f.ways) {
            let Ok(path) = &way.path else { continue };
            for step in &path.steps {
                let mut row: Vec<Cell> = vec![response.into(), goal(way.goal).into(), step.number.into()];
                row.extend(step.natural.iter().map(|x| Cell::from(*x)));
                row.push(step.predicted.into());
                for interval in [step.ci, step.prediction] {
                    row.push(interval.map(|(low, _)| low).into());
                    row.push(interval.map(|(_, high)| high).into());
                }
                row.push(step.explored.into());
                table.push(row);
            }
        }
    }
    table
}

/// `next_runs.csv`: runs that would teach most next, in natural units, and why.
pub fn next_runs(regressions: &[Regression], factors: &[Factor]) -> Table {
    let columns: Vec<&str> = ["response", "priority", "reason"].into_iter().chain(factors.iter().map(|f| f.name.as_str())).collect();
    let mut table = Table::new(&columns);
    for (response, _, further) in analysed(regressions) {
        for (i, suggestion) in further.iter().flat_map(|f| &f.next_runs).enumerate() {
            for levels in &suggestion.natural {
                let mut row: Vec<Cell> = vec![response.into(), (i + 1).into(), suggestion.reason.as_str().into()];
                row.extend(levels.iter().map(|x| Cell::from(*x)));
                table.push(row);
            }
        }
    }
    table
}

/// `desirability.csv`: the setting that meets all wishes of the campaign best: factors in natural units, and what each response would be there.
pub fn desirability(study: &CampaignStudy) -> Table {
    let names = study.campaign.design.factors.iter().map(|f| f.name.as_str());
    let columns: Vec<&str> = ["response", "predicted", "desirability", "overall"].into_iter().chain(names).collect();
    let mut table = Table::new(&columns);
    let Some(Ok(best)) = &study.desirable else { return table };
    for met in &best.met {
        let mut row: Vec<Cell> =
            vec![met.response.as_str().into(), met.predicted.into(), met.desirability.into(), best.desirability.into()];
        row.extend(best.natural.iter().map(|x| Cell::from(*x)));
        table.push(row);
    }
    table
}

/// `theory_effects.csv`: the same regression on the predicted and on the measured responses, term by term.
pub fn theory_effects(regressions: &[Regression]) -> Table {
    let mut table = Table::new(&[
        "response",
        "term",
        "measured",
        "measured_se",
        "measured_p",
        "predicted",
        "difference",
        "difference_se",
        "difference_p",
        "agreement",
    ]);
    for (response, _, further) in analysed(regressions) {
        for c in further.iter().filter_map(|f| f.theory.as_ref().ok()).flatten() {
            let (measured, difference): (&Coefficient, &Coefficient) = (&c.measured, &c.difference);
            table.push(vec![
                response.into(),
                c.term.as_str().into(),
                measured.estimate.into(),
                measured.se.into(),
                measured.p.into(),
                c.predicted.into(),
                difference.estimate.into(),
                difference.se.into(),
                difference.p.into(),
                agreement(c.agreement).into(),
            ]);
        }
    }
    table
}

/// The name of a goal in tables.
pub fn goal(goal: Goal) -> &'static str {
    match goal {
        Goal::Increase => "increase",
        Goal::Decrease => "decrease",
    }
}

/// The name of an agreement in tables.
pub fn agreement(agreement: Agreement) -> &'static str {
    match agreement {
        Agreement::Agrees => "agrees",
        Agreement::WrongSize => "wrong_size",
        Agreement::WrongSign => "wrong_sign",
        Agreement::NotMeasured => "not_measured",
        Agreement::BothAbsent => "both_absent",
        Agreement::Undecided => "undecided",
    }
}
