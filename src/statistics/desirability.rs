//! Several responses at once: how desirable is a setting, and which setting is most desirable?

use serde::Serialize;

use crate::error::Error;

/// What is wanted of one response.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum Wish {
    /// Worthless at `worthless` and below, perfect at `perfect` and above.
    Larger { worthless: f64, perfect: f64 },
    /// Worthless at `worthless` and above, perfect at `perfect` and below.
    Smaller { perfect: f64, worthless: f64 },
    /// Perfect at `target`, worthless at `low` and `high`.
    Target { low: f64, target: f64, high: f64 },
}

impl Wish {
    fn check(&self) -> Result<(), Error> {
        let ordered = match *self {
            Wish::Larger { worthless, perfect } => worthless < perfect,
            Wish::Smaller { perfect, worthless } => perfect < worthless,
            Wish::Target { low, target, high } => low < target && target < high,
        };
        if ordered { Ok(()) } else { Err(Error::Unanswerable(format!("the limits of {self:?} are not in ascending order"))) }
    }

    /// 0 (worthless) … 1 (perfect), linear between.
    ///
    /// Source: Derringer & Suich, J. Qual. Technol. 12 (1980) 214–219, with exponent 1.
    pub fn desirability(&self, response: f64) -> f64 {
        let value: f64 = match *self {
            Wish::Larger { worthless, perfect } => (response - worthless) / (perfect - worthless),
            Wish::Smaller { perfect, worthless } => (worthless - response) / (worthless - perfect),
            Wish::Target { low, target, .. } if response <= target => (response - low) / (target - low),
            Wish::Target { target, high, .. } => (high - response) / (high - target),
        };
        value.clamp(0.0, 1.0)
    }
}

/// One response as a polynomial in coded factors, and what is wanted of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// `(subset of factors, coefficient)`.
    pub model: Vec<(Vec<usize>, f64)>,
    pub wish: Wish,
    /// Exponent in the weighted geometric mean, > 0.
    pub importance: f64,
}

impl Wanted {
    fn response(&self, coded: &[f64]) -> f64 {
        self.model.iter().map(|(term, b)| b * term.iter().map(|&i| coded[i]).product::<f64>()).sum()
    }
}

/// The best setting found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Best {
    pub coded: Vec<f64>,
    /// Predicted responses there, in the order asked.
    pub responses: Vec<f64>,
    /// Weighted geometric mean of the single desirabilities, 0…1.
    pub desirability: f64,
}

/// Weighted geometric mean of the desirabilities at a coded setting; 0 if one response is worthless.
pub fn overall(wanted: &[Wanted], coded: &[f64]) -> f64 {
    let weight: f64 = wanted.iter().map(|w| w.importance).sum();
    let product: f64 = wanted.iter().map(|w| w.wish.desirability(w.response(coded)).powf(w.importance / weight)).product();
    if wanted.is_empty() { 0.0 } else { product }
}

/// The most desirable setting of `factors` factors within the explored region, all coded levels in −1…1.
///
/// Pattern search with halved steps from the centre and every corner, in that order; ties keep the earlier. The function has flat and kinked
/// parts, so a gradient would mislead; with at most 2⁶ + 1 starts and multilinear responses this finds the best hill for all practical purposes,
/// but it is a search, not a proof.
///
/// # Errors
/// [`Error::Unanswerable`] if nothing is wanted, limits are out of order, or every setting tried is worthless.
pub fn best_setting(wanted: &[Wanted], factors: usize) -> Result<Best, Error> {
    if wanted.is_empty() || factors == 0 {
        return Err(Error::Unanswerable("a desirable setting needs at least one response and one factor".into()));
    }
    for one in wanted {
        one.wish.check()?;
        if !(one.importance.is_finite() && one.importance > 0.0) {
            return Err(Error::Invalid { quantity: "importance of a response", value: one.importance, allowed: "finite and > 0" });
        }
    }
    let corners = (0..1_usize << factors).map(|mask| (0..factors).map(|i| if mask >> i & 1 == 1 { 1.0 } else { -1.0 }).collect());
    let starts = std::iter::once(vec![0.0; factors]).chain(corners);
    let mut best: Option<(Vec<f64>, f64)> = None;
    for start in starts {
        let (place, value) = pattern_search(start, |coded| overall(wanted, coded));
        if best.as_ref().is_none_or(|(_, known)| value > *known) {
            best = Some((place, value));
        }
    }
    match best {
        Some((coded, desirability)) if desirability > 0.0 => {
            let responses = wanted.iter().map(|one| one.response(&coded)).collect();
            Ok(Best { coded, responses, desirability })
        }
        _ => Err(Error::Unanswerable("no setting within the explored region is acceptable in every response".into())),
    }
}

/// Hooke and Jeeves' moves along the axes within the cube, step halved from ½ to 2⁻²⁰ when no move helps.
fn pattern_search(mut place: Vec<f64>, value: impl Fn(&[f64]) -> f64) -> (Vec<f64>, f64) {
    let mut best = value(&place);
    let mut step = 0.5;
    while step > 2f64.powi(-20) {
        let mut moved = false;
        for i in 0..place.len() {
            for change in [step, -step] {
                let before = place[i];
                place[i] = (before + change).clamp(-1.0, 1.0);
                let there = value(&place);
                if there > best {
                    best = there;
                    moved = true;
                } else {
                    place[i] = before;
                }
            }
        }
        if !moved {
            step *= 0.5;
        }
    }
    (place, best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_wishes_meet_where_their_product_is_largest() {
        // y1 = x wants 1, worthless at −1; y2 = x wants −1, worthless at 1: d1 d2 = (1 + x)(1 − x)/4, largest at 0 with 1/4, its root 1/2.
        let model = vec![(vec![0], 1.0)];
        let wanted = [
            Wanted { model: model.clone(), wish: Wish::Larger { worthless: -1.0, perfect: 1.0 }, importance: 1.0 },
            Wanted { model, wish: Wish::Smaller { perfect: -1.0, worthless: 1.0 }, importance: 1.0 },
        ];
        let best = best_setting(&wanted, 1).unwrap();
        assert!(best.coded[0].abs() < 1e-5 && (best.desirability - 0.5).abs() < 1e-10);
    }

    #[test]
    fn a_target_inside_the_region_is_met() {
        let wanted = [Wanted {
            model: vec![(vec![], 5.0), (vec![0], 1.0), (vec![1], -2.0), (vec![0, 1], 0.5)],
            wish: Wish::Target { low: 6.0, target: 6.75, high: 8.0 },
            importance: 1.0,
        }];
        let best = best_setting(&wanted, 2).unwrap();
        assert!((best.responses[0] - 6.75).abs() < 1e-5 && best.desirability > 0.99999, "{best:?}");
    }

    #[test]
    fn wishes_that_cannot_be_met_are_refused() {
        let wanted = [Wanted { model: vec![(vec![0], 1.0)], wish: Wish::Larger { worthless: 5.0, perfect: 6.0 }, importance: 1.0 }];
        assert!(best_setting(&wanted, 1).is_err());
    }
}
