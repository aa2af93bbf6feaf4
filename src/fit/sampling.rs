//! How many folds can the points of an outline show?

use crate::experiment::Point;

/// Points round the outline that one fold needs: its second harmonic, twice.
pub(super) const POINTS_A_FOLD: usize = 4;
/// A stretch of four points may be this much longer than a fold: points are never quite even.
const UNEVEN: f64 = 1.25;
/// Folds that are seen along less than this share of the outline are not seen: the rest could hold any number of them.
const LEAST_SHARE: f64 = 0.5;
/// Share of the outline without enough points above which a fit says so.
const SAID: f64 = 0.1;

/// The most folds that points at these fractions of the outline's length (ascending, 0 … 1) can show: four points a fold in all, and along at least
/// half of the outline.
pub(super) fn most_folds(fractions: &[f64]) -> u32 {
    let mut most = (fractions.len() / POINTS_A_FOLD) as u32;
    while 0 < most && unseen(fractions, most) > 1.0 - LEAST_SHARE {
        most -= 1;
    }
    most
}

/// Whether every stretch of the outline shows `folds` folds beyond doubt: its longest step is short enough everywhere.
pub(super) fn plainly_seen(points: &[Point], folds: u32) -> bool {
    let mut last = points[points.len() - 1];
    let (mut longest, mut length) = (0.0_f64, 0.0);
    for &point in points {
        let (dx, dy) = (point.x - last.x, point.y - last.y);
        let step = (dx * dx + dy * dy).sqrt();
        longest = longest.max(step);
        length += step;
        last = point;
    }
    POINTS_A_FOLD as f64 * f64::from(folds) * longest <= UNEVEN * length && POINTS_A_FOLD * folds as usize <= points.len()
}

/// Share of the outline that has fewer than four points a fold.
pub(super) fn unseen(fractions: &[f64], folds: u32) -> f64 {
    let n = fractions.len();
    let at = |i: usize| fractions[i % n] + (i / n) as f64;
    (0..n)
        .filter(|&i| {
            UNEVEN
                < (0..POINTS_A_FOLD).map(|back| at(i + n + POINTS_A_FOLD - back) - at(i + n - back)).fold(f64::INFINITY, f64::min)
                    * f64::from(folds)
        })
        .map(|i| at(i + 1) - at(i))
        .sum()
}

/// What to say of a stretch without enough points.
pub(super) fn note(fractions: &[f64], folds: u32) -> Option<String> {
    let share = unseen(fractions, folds);
    (SAID < share).then(|| {
        format!(
            "{:.0} % of the outline has fewer than {POINTS_A_FOLD} points a fold: what it does there is taken from the rest",
            100.0 * share
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_points_show_a_quarter_of_their_number_and_a_hole_costs_its_share() {
        let even: Vec<f64> = (0..40).map(|i| f64::from(i) / 40.0).collect();
        assert_eq!(most_folds(&even), 10);
        assert_eq!(unseen(&even, 10), 0.0);
        // A third missing: the rest shows its folds.
        let hole: Vec<f64> = (0..40).map(|i| f64::from(i) / 60.0).collect();
        assert_eq!(most_folds(&hole), 10);
        let missing = unseen(&hole, 10);
        assert!((missing - 1.0 / 3.0).abs() < 0.05, "{missing}");
    }

    #[test]
    fn dense_points_on_one_side_do_not_show_the_folds_of_the_other() {
        // 100 points on a tenth of the outline, 20 on the rest: 30 folds would need four on every thirtieth.
        let fractions: Vec<f64> = (0..100).map(|i| f64::from(i) / 1000.0).chain((0..20).map(|i| 0.1 + 0.9 * f64::from(i) / 20.0)).collect();
        // 0.045 between points: four of them span 0.18 of the outline, a fold of six with 1.25 to spare.
        assert_eq!(most_folds(&fractions), 6);
    }
}
