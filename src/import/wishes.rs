//! The tables `[[wishes]]` of `campaign.toml`: what is wanted of which response.

use serde::Deserialize;
use toml::Spanned;

use super::campaign_file::Reader;
use super::check_table::listed;
use crate::error::Error;
use crate::experiment::campaign::{Want, Wish};

/// One wish as it is written; exactly one of the three ways to want.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WishEntry {
    response: String,
    larger: Option<Side>,
    smaller: Option<Side>,
    target: Option<Target>,
    importance: Option<f64>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(deny_unknown_fields)]
struct Side {
    worthless: f64,
    perfect: f64,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(deny_unknown_fields)]
struct Target {
    low: f64,
    target: f64,
    high: f64,
}

/// The wishes, about responses that are regressed.
///
/// # Errors
/// [`Error::Input`] with the row for a wish about another response, limits out of order, or more or less than one want.
pub(super) fn wishes(reader: &Reader<'_>, given: Vec<Spanned<WishEntry>>, regressed: &[String]) -> Result<Vec<Wish>, Error> {
    given.into_iter().map(|entry| wish(reader, entry, regressed)).collect()
}

fn wish(reader: &Reader<'_>, entry: Spanned<WishEntry>, regressed: &[String]) -> Result<Wish, Error> {
    let place = reader.place(&entry.span());
    let WishEntry { response, larger, smaller, target, importance } = entry.into_inner();
    let response = listed(regressed, &response, place.clone())?;
    let (want, ascending) = match (larger, smaller, target) {
        (Some(Side { worthless, perfect }), None, None) => (Want::Larger { worthless, perfect }, vec![worthless, perfect]),
        (None, Some(Side { worthless, perfect }), None) => (Want::Smaller { perfect, worthless }, vec![perfect, worthless]),
        (None, None, Some(Target { low, target, high })) => (Want::Target { low, target, high }, vec![low, target, high]),
        _ => {
            let remedy = "give it one of larger = { worthless = 10, perfect = 30 }, smaller = { perfect = 10, worthless = 30 }, \
target = { low = 10, target = 20, high = 30 }";
            return Err(Error::input(place, format!("the wish about “{response}” does not say one thing"), remedy));
        }
    };
    if !ascending.iter().all(|x| x.is_finite()) || ascending.windows(2).any(|pair| pair[1] <= pair[0]) {
        let problem = format!("the limits of the wish about “{response}” are out of order");
        return Err(Error::input(
            place,
            problem,
            "larger: worthless below perfect; smaller: perfect below worthless; target: low, target, high ascending",
        ));
    }
    let importance = importance.unwrap_or(1.0);
    if !(importance.is_finite() && 0.0 < importance) {
        return Err(Error::input(place, format!("importance is {importance}"), "it must be positive; 1 unless told"));
    }
    Ok(Wish { response, want, importance })
}
