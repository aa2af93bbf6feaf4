//! Order round an outline: is the given order one, and if not, which is?
//!
//! Length alone cannot tell: where noise is wider than the spacing of the points, a tour that zigzags through the noise is far shorter than
//! the true order. So the first question is about places: in an outline the next point is among the near ones, seen from its predecessor,
//! however wide the noise; in a shuffled list it is anywhere.

mod plain;
mod route;
#[cfg(test)]
mod tests;

use self::plain::{in_order_through_noise, plainly_in_order};
use self::route::{LONGEST, Route};
use super::neighbours::{Neighbours, squared_distance};
use super::profile::Point;
use super::tour;

/// A step is a jump if it passes over more than this share of all points: noise of 1 % of the hem length passes over 5 %.
const JUMP_SHARE: f64 = 0.1;
/// A point is isolated if its third neighbour is this many times further off than is usual: a gross outlier, which belongs nowhere in any
/// order and so says nothing about it. The tail of a normal noise band stays below 5.
const ISOLATION: f64 = 10.0;
/// Neighbours on each side among which a point is astray …
const ASTRAY_WINDOW: usize = 4;
/// … if it is this many usual steps from their middle: the end of the window is four.
const ASTRAY: f64 = 6.0;
/// … and fewer than this share are: the middle of nine stays right with four of them astray, which then is rare.
const ASTRAY_SHARE: f64 = 0.35;
/// Points astray are outliers, not points misplaced in the list, if the third neighbours of most are this many times further off than is usual.
const APART: f64 = 1.5;
/// Up to this share of jumps, an order is an order with a few misplaced points.
const FEW: f64 = 0.05;
/// An order so many times longer than the shortest is not the order of a clean outline.
const DETOUR: f64 = 1.5;
/// A tour is the curve itself, not a zigzag through noise, if every second point gives nearly the same length. Noise of a third of the
/// spacing gives 0.93, a tour through a plane cloud below 0.85.
const SMOOTH: f64 = 0.9;

/// `None` if the given order goes round the outline; else the order that does, as indices into `points`.
///
/// Points are finite and distinct, at least four. O(n log n), but for the exchanges of the tour, which are few on a curve.
pub(super) fn reorder(points: &[Point]) -> Option<Vec<usize>> {
    if plainly_in_order(points) || in_order_through_noise(points) {
        return None;
    }
    let tree = Neighbours::new(points);
    let astray = astray(points);
    let (kept, shortest_possible) = not_isolated(points, &tree, &astray);
    let given = Route::new(points, kept.clone());
    let length = given.length();
    let jumps = given.jumps(points);
    // No tour is shorter than half the sum of everyone's two nearest neighbours.
    if jumps.count == 0 && length <= DETOUR * shortest_possible {
        return None;
    }
    let order = tour::shortest(points, &tree);
    let mut is_kept = vec![false; points.len()];
    kept.iter().for_each(|&i| is_kept[i] = true);
    let short = Route::new(points, order.iter().copied().filter(|&i| is_kept[i]).collect());
    let smooth = SMOOTH <= short.smoothness();
    let few_jumps = jumps.count < LONGEST.min(kept.len()) && jumps.count as f64 <= FEW * kept.len() as f64;
    // Half the extent: a real gap in the outline has to be crossed by any tour and cancels; a misplaced point costs the way there and back.
    let misplaced = short.jumps(points).length + 0.5 * extent(points, &kept) < jumps.length;
    let scrambled_nearby = smooth && DETOUR * short.length() < length;
    // A few misplaced points in wide noise do less harm than a tour that zigzags through it.
    ((misplaced && (smooth || !few_jumps)) || scrambled_nearby).then_some(order)
}

/// Points that lie far from the middle of their neighbours in the given order, which are near each other: gross outliers of an outline in order.
/// In a shuffled list everybody is as far from his neighbours as anybody, and nobody is astray.
fn astray(points: &[Point]) -> Vec<bool> {
    let n = points.len();
    let half = ASTRAY_WINDOW.min(n / 10);
    if half < 2 {
        return vec![false; n];
    }
    let median = |values: &mut Vec<f64>| {
        let middle = values.len() / 2;
        *values.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let mut steps: Vec<f64> = (0..n).map(|i| points[i].distance(points[(i + 1) % n])).collect();
    let usual = median(&mut steps);
    let mut astray: Vec<bool> = (0..n)
        .map(|i| {
            let window = || (0..2 * half + 1).map(|j| points[(i + n + j - half) % n]);
            let (mut x, mut y): (Vec<f64>, Vec<f64>) = (window().map(|p| p.x).collect(), window().map(|p| p.y).collect());
            ASTRAY * usual < points[i].distance(Point::new(median(&mut x), median(&mut y)))
        })
        .collect();
    // Sparse stretches and folds with few points look alike all round: outliers are few.
    if ASTRAY_SHARE * n as f64 <= astray.iter().filter(|&&a| a).count() as f64 {
        astray.fill(false);
    }
    astray
}

/// The points that are not isolated, in the given order, and half the sum of their distances to their two nearest neighbours.
fn not_isolated(points: &[Point], tree: &Neighbours, astray: &[bool]) -> (Vec<usize>, f64) {
    let near: Vec<[f64; 3]> = (0..points.len())
        .map(|i| {
            let found = tree.nearest(i, 3, |_| true);
            [found[0].0, found[1].0, found[2].0]
        })
        .collect();
    let mut third: Vec<f64> = near.iter().map(|d| d[2]).collect();
    let middle = third.len() / 2;
    let usual = *third.select_nth_unstable_by(middle, f64::total_cmp).1;
    let apart = (0..points.len()).filter(|&i| astray[i] && APART * usual < near[i][2]).count();
    let outliers = astray.iter().filter(|&&a| a).count() < 2 * apart;
    let kept: Vec<usize> = (0..points.len()).filter(|&i| near[i][2] <= ISOLATION * usual && !(outliers && astray[i])).collect();
    let half_sum = kept.iter().map(|&i| 0.5 * (near[i][0] + near[i][1])).sum();
    (kept, half_sum)
}

/// Largest distance from the mean point, times two, m.
fn extent(points: &[Point], kept: &[usize]) -> f64 {
    let n = kept.len() as f64;
    let (x, y) = kept.iter().fold((0.0, 0.0), |(x, y), &i| (x + points[i].x / n, y + points[i].y / n));
    2.0 * kept.iter().map(|&i| points[i].distance(Point::new(x, y))).fold(0.0, f64::max)
}
