//! Order round an outline: is the given order one, and if not, which is?
//!
//! Length alone cannot tell: where noise is wider than the spacing of the points, a tour that zigzags through the noise is far shorter than
//! the true order. So the first question is about places: in an outline the next point is among the near ones, seen from its predecessor,
//! however wide the noise; in a shuffled list it is anywhere.

use super::neighbours::{Neighbours, squared_distance};
use super::profile::Point;
use super::tour;

/// A step is a jump if it passes over more than this share of all points: noise of 1 % of the hem length passes over 5 %.
const JUMP_SHARE: f64 = 0.1;
/// … and over at least this many, which the two neighbours on either side and the opposite flank of a narrow fold can make up.
const JUMP_POINTS: usize = 4;
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
/// So many of the longest steps are looked at; more jumps than this make no difference to the verdict.
const LONGEST: usize = 1000;
/// Up to this share of jumps, an order is an order with a few misplaced points.
const FEW: f64 = 0.05;
/// An order so many times longer than the shortest is not the order of a clean outline.
const DETOUR: f64 = 1.5;
/// A tour is the curve itself, not a zigzag through noise, if every second point gives nearly the same length. Noise of a third of the
/// spacing gives 0.93, a tour through a plane cloud below 0.85.
const SMOOTH: f64 = 0.9;
/// Plainly in order is an outline without a step so many times longer than is usual …
const MOST_STEPS: f64 = 8.0;
/// … that goes back by less than an eighth of a turn about its middle, all in all, rad …
const MOST_BACK: f64 = std::f64::consts::FRAC_PI_4;
/// … or half a turn where means are looked at, whose steps are known to be short: overhanging folds go back …
const MOST_BACK_OF_MEANS: f64 = std::f64::consts::PI;
/// … and turns back on the spot at no more than this share of its points: with eight steps each, they add a sixth to its length, far from [`DETOUR`].
const MOST_REVERSALS: f64 = 0.02;

/// Means of two points in a row are taken, again and again, while at least this many are left: eight for each of sixty folds.
const FEWEST_MEANS: usize = 480;
/// Neighbours in the list that make a cloud or a line.
const GROUP: usize = 8;
/// A step of this share of the extent passes, three flanks of a fold together, over less than [`JUMP_SHARE`] of the points.
const SHORT_STEP: f64 = 0.04;
/// Least ratio of the shorter mean square axis of groups to the longer: some 0.25 in a round cloud of eight, nothing on a curve.
const ROUND: f64 = 0.1;

/// `None` if the given order goes round the outline; else the order that does, as indices into `points`.
///
/// Points are finite and distinct, at least four. O(n log n), but for the exchanges of the tour, which are few on a curve.
pub(super) fn reorder(points: &[Point]) -> Option<Vec<usize>> {
    if plainly_in_order(points, MOST_BACK) || in_order_through_noise(points) {
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

/// Whether the order goes round the mean point once, hardly ever back, in steps none of which can be a jump: then all that follows would keep it.
///
/// Going round alone is not enough: the points of an overhanging fold, sorted by angle, go to and fro between its flanks. So turns back on the
/// spot are counted too. Any doubt is left to the neighbours; O(n), without trigonometry.
fn plainly_in_order(points: &[Point], most_back: f64) -> bool {
    let n = points.len();
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.x, y + p.y));
    let middle = Point::new(x / n as f64, y / n as f64);
    let steps = (0..n).map(|i| squared_distance(points[i], points[(i + 1) % n]).sqrt());
    let (sum, longest) = steps.fold((0.0, 0.0_f64), |(sum, longest), step| (sum + step, longest.max(step)));
    // A step of k usual ones passes over some 2k points.
    let most = MOST_STEPS.min(0.5 * JUMP_SHARE * n as f64);
    if most * sum < longest * n as f64 {
        return false;
    }
    let (mut turns, mut back, mut forth, mut reversals) = (0_i32, 0.0, 0.0, 0);
    let (mut a, mut came) = (from(middle, points[n - 1]), from(points[n - 2], points[n - 1]));
    for i in 0..n {
        let (b, goes) = (from(middle, points[i]), from(points[(i + n - 1) % n], points[i]));
        let cross = a.x * b.y - a.y * b.x;
        let along = a.x * b.x + a.y * b.y;
        // Less than an eighth of a turn seen from the middle, where the tangent is a bound of the angle.
        if along <= cross.abs() {
            return false;
        }
        let tangent = cross / along;
        if tangent < 0.0 {
            back -= tangent
        } else {
            forth += tangent
        }
        // Crossings of the half axis x > 0, up and down.
        turns += i32::from(a.y < 0.0 && 0.0 <= b.y && 0.0 < a.x) - i32::from(b.y < 0.0 && 0.0 <= a.y && 0.0 < b.x);
        reversals += usize::from(came.x * goes.x + came.y * goes.y < 0.0);
        (a, came) = (b, goes);
    }
    turns.abs() == 1 && back.min(forth) <= most_back && reversals as f64 <= MOST_REVERSALS * n as f64
}

/// Whether noise wider than the spacing of the points hides an order that their means show: no tour can find a better one then. O(n).
///
/// Steps are too short to be jumps; neighbours in the list form clouds, not pieces of a line, so that no smooth way leads through them; and the means
/// of so many in a row that the noise is averaged out are plainly in order.
fn in_order_through_noise(points: &[Point]) -> bool {
    let n = points.len();
    if n < 2 * FEWEST_MEANS {
        return false;
    }
    let (mut low, mut high) = (points[0], points[0]);
    for p in points {
        (low, high) = (Point::new(low.x.min(p.x), low.y.min(p.y)), Point::new(high.x.max(p.x), high.y.max(p.y)));
    }
    let most = SHORT_STEP * (high.x - low.x).min(high.y - low.y);
    if (0..n).any(|i| most * most < squared_distance(points[i], points[(i + 1) % n])) || !are_clouds(points) {
        return false;
    }
    let mut means = points.to_vec();
    while 2 * FEWEST_MEANS <= means.len() {
        means = means.chunks(2).map(mean).collect();
        if plainly_in_order(&means, MOST_BACK_OF_MEANS) {
            return true;
        }
    }
    false
}

/// Whether groups of neighbours in the list are, taken together, more nearly round than long.
fn are_clouds(points: &[Point]) -> bool {
    let (mut longer, mut shorter) = (0.0, 0.0);
    for group in points.chunks_exact(GROUP) {
        let middle = mean(group);
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for p in group {
            let (dx, dy) = (p.x - middle.x, p.y - middle.y);
            (xx, xy, yy) = (xx + dx * dx, xy + dx * dy, yy + dy * dy);
        }
        let (half, spread) = (0.5 * (xx + yy), (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt());
        longer += half + spread;
        shorter += half - spread;
    }
    ROUND * longer < shorter
}

fn mean(points: &[Point]) -> Point {
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.x, y + p.y));
    Point::new(x / points.len() as f64, y / points.len() as f64)
}

/// The way from one point to another, m.
fn from(start: Point, end: Point) -> Point {
    Point::new(end.x - start.x, end.y - start.y)
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

/// Steps that leave the neighbourhood, among the [`LONGEST`].
struct Jumps {
    count: usize,
    /// Sum of their lengths, m.
    length: f64,
}

/// A closed way round through some of the points.
struct Route {
    order: Vec<usize>,
    /// `steps[i]`: from `order[i]` to the next, m.
    steps: Vec<f64>,
    /// Length through every second point, mean of the two ways to choose them, m.
    every_second: f64,
}

impl Route {
    fn new(points: &[Point], order: Vec<usize>) -> Self {
        let n = order.len();
        let stride = |by: usize| (0..n).map(|i| points[order[i]].distance(points[order[(i + by) % n]])).collect::<Vec<f64>>();
        let (steps, every_second) = (stride(1), 0.5 * stride(2).iter().sum::<f64>());
        Route { order, steps, every_second }
    }

    /// Length through every second point over length through all: 1 on a finely sampled curve, lower the more it zigzags.
    fn smoothness(&self) -> f64 {
        self.every_second / self.length()
    }

    fn length(&self) -> f64 {
        self.steps.iter().sum()
    }

    fn jumps(&self, points: &[Point]) -> Jumps {
        let n = self.order.len();
        let allowed = JUMP_POINTS.max((JUMP_SHARE * n as f64) as usize);
        let mut longest: Vec<usize> = (0..n).collect();
        longest.sort_unstable_by(|&a, &b| self.steps[b].total_cmp(&self.steps[a]).then(a.cmp(&b)));
        longest.truncate(LONGEST);
        let mut jumps = Jumps { count: 0, length: 0.0 };
        for at in longest {
            let (from, reach) = (points[self.order[at]], self.steps[at] * self.steps[at]);
            let nearer = self.order.iter().filter(|&&i| squared_distance(points[i], from) < reach).count();
            let passed = nearer.saturating_sub(1);
            if allowed < passed {
                jumps.count += 1;
                jumps.length += self.steps[at];
            }
        }
        jumps
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use rand::seq::SliceRandom;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// A hem with folds; a lean of 0.1 m/m² overhangs.
    fn hem(n: usize, folds: f64, depth: f64, lean: f64) -> Vec<Point> {
        (0..n)
            .map(|i| {
                let t = TAU * i as f64 / n as f64;
                let (r, across) = (0.2 + depth * (folds * t).cos(), lean * (2.0 * folds * t).sin());
                Point::new(r * t.cos() - across * t.sin(), r * t.sin() + across * t.cos())
            })
            .collect()
    }

    fn shaken(points: &[Point], sigma: f64, random: &mut ChaCha8Rng) -> Vec<Point> {
        // Twelve uniform numbers: variance one, near enough normal.
        let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
        points.iter().map(|p| Point::new(p.x + sigma * normal(), p.y + sigma * normal())).collect()
    }

    /// How many neighbours in `order` are neighbours on the ring 0, 1, …, n − 1.
    fn right_links(order: &[usize]) -> usize {
        let n = order.len();
        (0..n).filter(|&i| [1, n - 1].contains(&((order[i] + n - order[(i + 1) % n]) % n))).count()
    }

    /// Shuffles `points` and returns how many links of the found order are links of the ring.
    fn restored(points: &[Point], random: &mut ChaCha8Rng) -> usize {
        let mut shuffle: Vec<usize> = (0..points.len()).collect();
        shuffle.shuffle(random);
        let scattered: Vec<Point> = shuffle.iter().map(|&i| points[i]).collect();
        let order = reorder(&scattered).expect("a shuffled outline is not in order");
        right_links(&order.iter().map(|&i| shuffle[i]).collect::<Vec<_>>())
    }

    #[test]
    fn an_outline_is_kept_from_twelve_points_to_a_hundred_thousand() {
        for n in [12, 13, 20, 36, 180, 2000, 100_000] {
            assert_eq!(reorder(&hem(n, 5.0, 0.05, 0.01)), None, "{n} points");
            assert_eq!(reorder(&hem(n, 5.0, 0.0, 0.0)), None, "circle of {n} points");
        }
        assert_eq!(reorder(&hem(180, 8.0, 0.06, 0.03)), None, "overhanging");
    }

    #[test]
    fn scattered_points_get_the_order_round_the_outline_overhangs_included() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for (n, folds, depth, lean) in
            [(24, 3.0, 0.03, 0.0), (180, 5.0, 0.05, 0.01), (360, 8.0, 0.06, 0.03), (720, 7.0, 0.08, 0.04), (4000, 12.0, 0.08, 0.02)]
        {
            for _ in 0..5 {
                assert_eq!(restored(&hem(n, folds, depth, lean), &mut random), n, "{n} points, {folds} folds");
            }
        }
    }

    #[test]
    fn scattered_points_with_digitiser_noise_are_misplaced_by_neighbours_only() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let clean = hem(360, 8.0, 0.06, 0.03);
        // Noise of a fifth of the mean spacing of 8 mm.
        let points = shaken(&clean, 0.0016, &mut random);
        let right = restored(&points, &mut random);
        // Where points crowd at the crests, neighbours change places: a few in a hundred.
        assert!(330 <= right, "{right} of 360 links");
    }

    #[test]
    fn dense_noise_is_seen_through_by_means_and_a_scrambled_curve_is_not_taken_for_it() {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        for (n, sigma) in [(20_000, 0.001), (100_000, 0.001), (100_000, 0.0003)] {
            let noisy = shaken(&hem(n, 8.0, 0.06, 0.03), sigma, &mut random);
            assert!(!plainly_in_order(&noisy, MOST_BACK) && in_order_through_noise(&noisy), "{n} points, noise {sigma} m");
            let mut shuffled = noisy;
            shuffled.shuffle(&mut random);
            assert!(!in_order_through_noise(&shuffled), "{n} points shuffled");
        }
        // Neighbours that have changed places on a clean curve lie on a line, not in a cloud.
        let mut scrambled = hem(20_000, 8.0, 0.06, 0.03);
        scrambled.chunks_mut(16).for_each(|window| window.shuffle(&mut random));
        assert!(!in_order_through_noise(&scrambled));
        // One point out of place is a jump.
        let mut misplaced = shaken(&hem(20_000, 8.0, 0.06, 0.03), 0.001, &mut random);
        misplaced.swap(100, 10_000);
        assert!(!in_order_through_noise(&misplaced));
    }

    #[test]
    fn noise_wider_than_the_spacing_does_not_lose_the_given_order() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        for (n, sigma) in [(360, 0.004), (360, 0.012), (2000, 0.002), (2000, 0.01), (20_000, 0.005)] {
            assert_eq!(reorder(&shaken(&hem(n, 5.0, 0.05, 0.01), sigma, &mut random)), None, "{n} points, noise {sigma} m");
        }
    }

    #[test]
    fn a_few_gross_outliers_do_not_lose_the_given_order() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        for sigma in [0.0, 0.0005, 0.004] {
            let mut points = shaken(&hem(180, 5.0, 0.05, 0.01), sigma, &mut random);
            // A lost decimal point, a swapped sign outside the outline, a slip towards the centre.
            points[20] = Point::new(10.0 * points[20].x, points[20].y);
            points[77] = Point::new(-1.7 * points[77].x, -1.4 * points[77].y);
            points[140] = Point::new(0.01, 0.02);
            assert_eq!(reorder(&points), None, "noise {sigma} m");
        }
    }

    #[test]
    fn a_partly_shuffled_outline_is_put_in_order() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        for share in [0.02, 0.1, 0.3, 0.6] {
            let points = hem(200, 6.0, 0.05, 0.01);
            let mut shuffle: Vec<usize> = (0..points.len()).collect();
            let mut moved = shuffle.clone();
            moved.shuffle(&mut random);
            moved.truncate((share * points.len() as f64) as usize);
            let mut places = moved.clone();
            places.rotate_left(1);
            for (&to, &from) in places.iter().zip(&moved) {
                shuffle[to] = from;
            }
            let mixed: Vec<Point> = shuffle.iter().map(|&i| points[i]).collect();
            let order = reorder(&mixed).unwrap_or_else(|| panic!("{share} misplaced went unnoticed"));
            assert_eq!(right_links(&order.iter().map(|&i| shuffle[i]).collect::<Vec<_>>()), 200, "{share}");
        }
    }

    #[test]
    fn rows_mixed_up_with_their_neighbours_are_put_in_order() {
        let mut random = ChaCha8Rng::seed_from_u64(6);
        let points = hem(200, 6.0, 0.05, 0.01);
        let mut shuffle: Vec<usize> = (0..200).collect();
        shuffle.chunks_mut(10).for_each(|rows| rows.shuffle(&mut random));
        let order = reorder(&shuffle.iter().map(|&i| points[i]).collect::<Vec<_>>()).expect("scrambled nearby");
        assert_eq!(right_links(&order.iter().map(|&i| shuffle[i]).collect::<Vec<_>>()), 200);
    }

    #[test]
    fn two_halves_that_both_run_left_to_right_are_joined() {
        let points = hem(180, 5.0, 0.05, 0.01);
        // The upper half as it is, the lower half turned round: as a sheet with two branches has them.
        let halves: Vec<Point> = points[..90].iter().chain(points[90..].iter().rev()).copied().collect();
        let order = reorder(&halves).expect("two branches are not a ring");
        let back: Vec<usize> = order.iter().map(|&i| if i < 90 { i } else { 269 - i }).collect();
        assert_eq!(right_links(&back), 180);
    }

    #[test]
    fn points_of_an_overhanging_hem_sorted_by_angle_are_not_plainly_in_order() {
        let points = hem(360, 8.0, 0.06, 0.03);
        assert_eq!(reorder(&points), None);
        let angle = |i: &usize| points[*i].y.atan2(points[*i].x);
        let mut sorted: Vec<usize> = (0..360).collect();
        sorted.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        assert!(right_links(&sorted) < 300, "the hem does not overhang");
        assert!(!plainly_in_order(&sorted.iter().map(|&i| points[i]).collect::<Vec<_>>(), MOST_BACK));
    }

    #[test]
    fn what_is_plainly_in_order_is_so_in_both_directions_with_and_without_noise() {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        for n in [90, 360, 10_000] {
            let points = hem(n, 5.0, 0.04, 0.005);
            // A sixth of the mean spacing.
            let noisy = shaken(&points, 0.2 / n as f64, &mut random);
            for mut points in [points, noisy] {
                assert!(plainly_in_order(&points, MOST_BACK), "{n} points");
                points.reverse();
                assert!(plainly_in_order(&points, MOST_BACK), "{n} points, clockwise");
            }
        }
    }

    #[test]
    fn no_way_to_mix_up_an_outline_is_plainly_in_order() {
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let points = hem(360, 6.0, 0.05, 0.01);
        let mixed = |order: &[usize]| order.iter().map(|&i| points[i]).collect::<Vec<_>>();
        let ring = || (0..360).collect::<Vec<usize>>();
        // Two points far from each other exchanged; neighbours exchanged all round; a stretch turned round; every second point, then the others.
        for at in 0..300 {
            let mut order = ring();
            order.swap(at, at + 40);
            assert!(!plainly_in_order(&mixed(&order), MOST_BACK), "{at}");
            let mut order = ring();
            order[at..at + 60].reverse();
            assert!(!plainly_in_order(&mixed(&order), MOST_BACK), "{at} turned round");
        }
        let mut order = ring();
        order.chunks_mut(2).for_each(|pair| pair.reverse());
        assert!(!plainly_in_order(&mixed(&order), MOST_BACK));
        order.sort_by_key(|i| (i % 2, *i));
        assert!(!plainly_in_order(&mixed(&order), MOST_BACK));
        for block in [3, 5, 20, 360] {
            let mut order = ring();
            order.chunks_mut(block).for_each(|rows| rows.shuffle(&mut random));
            assert!(!plainly_in_order(&mixed(&order), MOST_BACK), "blocks of {block}");
        }
    }

    #[test]
    fn a_gap_in_an_outline_is_no_reason_to_reorder_it() {
        let points = hem(360, 5.0, 0.05, 0.01);
        assert_eq!(reorder(&points[..270]), None);
        let mut random = ChaCha8Rng::seed_from_u64(7);
        assert_eq!(reorder(&shaken(&points[60..], 0.006, &mut random)), None);
    }

    #[test]
    fn a_hundred_thousand_scattered_points_are_put_in_order() {
        // Quadratic work would be 1e10 distances; the suite's patience is the measure.
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let clean = hem(100_000, 7.0, 0.06, 0.02);
        assert_eq!(restored(&clean, &mut random), 100_000);
        let noisy = shaken(&clean, 0.0005, &mut random);
        let mut shuffled = noisy.clone();
        shuffled.shuffle(&mut random);
        assert!(reorder(&shuffled).is_some());
    }
}
