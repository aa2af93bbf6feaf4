//! Whether an order plainly goes round an outline, which can be seen without looking for neighbours.

use super::{JUMP_SHARE, Point, squared_distance};

/// Plainly in order is an outline without a step so many times longer than is usual …
const MOST_STEPS: f64 = 8.0;
/// … that goes back by less than half a turn about its middle, all in all, as overhanging folds do, rad …
const MOST_BACK: f64 = std::f64::consts::PI;
/// … and turns back on the spot so rarely, or in so short steps, that the ways there and back are no more than this share of its length: far from
/// [`DETOUR`](super::DETOUR), and from an overhanging hem sorted by angle, which goes to and fro between the flanks of its folds.
const MOST_TO_AND_FRO: f64 = 0.1;

/// Means of two points in a row are taken, again and again, while at least this many are left: eight for each of sixty folds.
const FEWEST_MEANS: usize = 480;
/// Neighbours in the list that make a cloud or a line.
const GROUP: usize = 8;
/// A step of this share of the extent passes, three flanks of a fold together, over less than [`JUMP_SHARE`] of the points.
const SHORT_STEP: f64 = 0.04;
/// Least ratio of the shorter mean square axis of groups to the longer: some 0.25 in a round cloud of eight, nothing on a curve.
const ROUND: f64 = 0.1;

/// Whether the order goes round the mean point once, hardly ever back, in steps none of which can be a jump: then all that follows would keep it.
///
/// Going round alone is not enough: the points of an overhanging fold, sorted by angle, go to and fro between its flanks. So turns back on the
/// spot are counted too. Any doubt is left to the neighbours; O(n), without trigonometry.
pub(super) fn plainly_in_order(points: &[Point]) -> bool {
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
    let (mut turns, mut back, mut forth, mut to_and_fro) = (0_i32, 0.0, 0.0, 0.0);
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
        if came.x * goes.x + came.y * goes.y < 0.0 {
            to_and_fro += 2.0 * (came.x * came.x + came.y * came.y).min(goes.x * goes.x + goes.y * goes.y).sqrt();
        }
        (a, came) = (b, goes);
    }
    turns.abs() == 1 && back.min(forth) <= MOST_BACK && to_and_fro <= MOST_TO_AND_FRO * sum
}

/// Whether noise wider than the spacing of the points hides an order that their means show: no tour can find a better one then. O(n).
///
/// Steps are too short to be jumps; neighbours in the list form clouds, not pieces of a line, so that no smooth way leads through them; and the means
/// of so many in a row that the noise is averaged out are plainly in order.
pub(super) fn in_order_through_noise(points: &[Point]) -> bool {
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
        if plainly_in_order(&means) {
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
