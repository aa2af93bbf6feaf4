//! Which setting of the factors meets all wishes of a campaign best?

use serde::Serialize;

use super::campaign::Regression;
use super::response;
use crate::experiment::Campaign;
use crate::experiment::campaign::Want;
use crate::statistics::desirability::{self, Wanted, best_setting};

/// What one response would be at the setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Met {
    /// Column of the response; its suffix is the unit.
    pub response: String,
    /// By the model of the significant terms.
    pub predicted: f64,
    /// 0 (worthless) … 1 (perfect).
    pub desirability: f64,
}

/// The most desirable setting within the explored region.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Desirable {
    pub coded: Vec<f64>,
    pub natural: Vec<f64>,
    /// Weighted geometric mean of the single desirabilities.
    pub desirability: f64,
    /// In the order of the wishes.
    pub met: Vec<Met>,
}

/// The best setting, or why there is none; `None` where the campaign wishes nothing.
pub fn desirable(campaign: &Campaign, regressions: &[Regression]) -> Option<Result<Desirable, String>> {
    (!campaign.wishes.is_empty()).then(|| best(campaign, regressions))
}

fn best(campaign: &Campaign, regressions: &[Regression]) -> Result<Desirable, String> {
    let weighed = response::weighed(campaign);
    let factors = &campaign.design.factors;
    let (mut columns, mut wanted) = (Vec::new(), Vec::new());
    for wish in &campaign.wishes {
        let column = response::named(&wish.response, weighed).map_or(wish.response.as_str(), |r| r.column);
        let regression = regressions.iter().find(|r| r.response == column).ok_or_else(|| format!("{column} is not regressed"))?;
        let analysis = regression.analysis.as_ref().map_err(|why| format!("{column}: {why}"))?;
        let place = |name: &str| factors.iter().position(|factor| factor.name == name);
        let subset = |term: &str| if term == "1" { Some(vec![]) } else { term.split(':').map(place).collect::<Option<Vec<usize>>>() };
        let model = analysis.reduced.coded.iter().filter_map(|(term, b)| Some((subset(term)?, *b))).collect();
        wanted.push(Wanted { model, wish: of(wish.want), importance: wish.importance });
        columns.push(column.to_string());
    }
    let best = best_setting(&wanted, factors.len()).map_err(|e| e.to_string())?;
    let natural = factors.iter().zip(&best.coded).map(|(factor, x)| factor.natural(*x)).collect();
    let met = columns
        .into_iter()
        .zip(&wanted)
        .zip(&best.responses)
        .map(|((response, wanted), &predicted)| Met { response, predicted, desirability: wanted.wish.desirability(predicted) })
        .collect();
    Ok(Desirable { coded: best.coded, natural, desirability: best.desirability, met })
}

fn of(want: Want) -> desirability::Wish {
    match want {
        Want::Larger { worthless, perfect } => desirability::Wish::Larger { worthless, perfect },
        Want::Smaller { perfect, worthless } => desirability::Wish::Smaller { perfect, worthless },
        Want::Target { low, target, high } => desirability::Wish::Target { low, target, high },
    }
}
