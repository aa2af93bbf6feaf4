//! The table `[check]` of `campaign.toml`: limits of the checks, and the failures that the campaign expects.

use serde::Deserialize;
use toml::Spanned;

use super::campaign_file::{LEVEL, Reader, unknown};
use crate::error::{Error, Place};
use crate::experiment::CheckRules;
use crate::experiment::campaign::RESPONSES;
use crate::experiment::check::{Expected, Question};
use crate::units::MILLIMETRE;

/// `[check]` as it is written.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct CheckTable {
    alpha: Option<Spanned<f64>>,
    responses: Option<Spanned<Vec<String>>>,
    drift_standard_errors: Option<Spanned<f64>>,
    theory_rms_mm: Option<Spanned<f64>>,
    theory_fold_depth_mm: Option<Spanned<f64>>,
    theory_mean_radius_mm: Option<Spanned<f64>>,
    theory_fold_count_off: Option<u32>,
    #[serde(default)]
    expected: Vec<Spanned<ExpectedEntry>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ExpectedEntry {
    check: String,
    #[serde(default)]
    responses: Vec<String>,
    #[serde(default)]
    runs: Vec<String>,
    reason: String,
}

impl CheckTable {
    /// The rules; what is not said is taken from the analysis, whose level and responses these are.
    ///
    /// # Errors
    /// [`Error::Input`] with the row for a value out of range, and for an expected failure that can be none.
    pub(super) fn rules(self, reader: &Reader<'_>, alpha: f64, regressed: &[String]) -> Result<CheckRules, Error> {
        let usual = CheckRules::usual(alpha, regressed.to_vec());
        let responses = match &self.responses {
            None => usual.responses,
            Some(given) => {
                let place = reader.place(&given.span());
                given.get_ref().iter().map(|name| listed(regressed, name, place.clone())).collect::<Result<_, _>>()?
            }
        };
        let limit = |given: &Option<Spanned<f64>>, key: &str| -> Result<Option<f64>, Error> {
            let millimetres = reader.number(given, f64::NAN, key, "positive", |x| 0.0 < x)?;
            Ok((!millimetres.is_nan()).then_some(millimetres * MILLIMETRE))
        };
        Ok(CheckRules {
            alpha: reader.number(&self.alpha, alpha, "alpha", LEVEL, |a| 0.0 < a && a < 1.0)?,
            drift: reader.number(&self.drift_standard_errors, usual.drift, "drift_standard_errors", "positive", |d| 0.0 < d)?,
            theory_rms: limit(&self.theory_rms_mm, "theory_rms_mm")?,
            theory_fold_depth: limit(&self.theory_fold_depth_mm, "theory_fold_depth_mm")?,
            theory_mean_radius: limit(&self.theory_mean_radius_mm, "theory_mean_radius_mm")?,
            theory_fold_count: self.theory_fold_count_off,
            expected: self.expected.into_iter().map(|entry| expected(reader, entry, &responses)).collect::<Result<_, _>>()?,
            responses,
        })
    }
}

/// The name under which `responses` lists `name`; the short name and the column mean the same.
pub(super) fn listed(responses: &[String], name: &str, place: Place) -> Result<String, Error> {
    let same = |listed: &&String| {
        *listed == name || RESPONSES.iter().any(|r| [r.name, r.column].contains(&name) && [r.name, r.column].contains(&listed.as_str()))
    };
    let known: Vec<&str> = responses.iter().map(String::as_str).collect();
    let missing = || unknown(place, &format!("response “{name}” is not among those that are regressed"), name, &known);
    responses.iter().find(same).cloned().ok_or_else(missing)
}

fn expected(reader: &Reader<'_>, entry: Spanned<ExpectedEntry>, responses: &[String]) -> Result<Expected, Error> {
    let place = reader.place(&entry.span());
    let ExpectedEntry { check, responses: of_responses, runs, reason } = entry.into_inner();
    let names: Vec<&str> = Question::ALL.iter().filter(|q| **q != Question::Drift).map(|q| q.name()).collect();
    let Some(question) = Question::ALL.into_iter().find(|q| q.name() == check) else {
        return Err(unknown(place, &format!("unknown check “{check}”"), &check, &names));
    };
    if question == Question::Drift {
        return Err(Error::input(place, "a drift cannot be expected", "accept it with `hemline check --update-baseline`"));
    }
    if reason.trim().is_empty() {
        return Err(Error::input(place, "“reason” is empty", "say why this failure is accepted"));
    }
    let (key, wanted, other) = if question.of_responses() { ("responses", of_responses, runs) } else { ("runs", runs, of_responses) };
    if wanted.is_empty() || !other.is_empty() {
        let example = if question.of_responses() { "responses = [\"q\"]" } else { "runs = [\"17\"]" };
        return Err(Error::input(place, format!("the check “{check}” is about {key}"), format!("name them: {example}")));
    }
    let subjects = match question.of_responses() {
        true => wanted.iter().map(|name| listed(responses, name, place.clone())).collect::<Result<_, _>>()?,
        false => wanted,
    };
    Ok(Expected { question, subjects, reason, row: place.row.unwrap_or_default() })
}
