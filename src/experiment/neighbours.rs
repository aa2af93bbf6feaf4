//! Nearest neighbours: which points of the plane lie close to a given one.

use super::profile::Point;

/// Points per leaf: small enough that a leaf is scanned in a cache line or two, large enough that the tree stays shallow.
const LEAF: usize = 8;

/// A k-d tree over points of the plane: O(n log n) to build, O(log n) a query, whatever the shape of the cloud.
pub(super) struct Neighbours<'a> {
    points: &'a [Point],
    /// Point indices; every subtree is a contiguous range whose middle entry splits it.
    order: Vec<u32>,
}

impl<'a> Neighbours<'a> {
    pub(super) fn new(points: &'a [Point]) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        split(points, &mut order, true);
        Neighbours { points, order }
    }

    /// The at most `k` points nearest to point `of` (itself left out) that `keep` admits, nearest first, ties by index.
    pub(super) fn nearest(&self, of: usize, k: usize, keep: impl Fn(usize) -> bool) -> Vec<(f64, u32)> {
        let mut found = Vec::with_capacity(k + 1);
        if 0 < k {
            self.visit(&self.order, true, of, k, &keep, &mut found);
        }
        found.iter_mut().for_each(|(square, _)| *square = square.sqrt());
        found
    }

    /// `found` holds squared distances.
    fn visit(&self, range: &[u32], by_x: bool, of: usize, k: usize, keep: &impl Fn(usize) -> bool, found: &mut Vec<(f64, u32)>) {
        if range.len() <= LEAF {
            range.iter().for_each(|&i| self.offer(i, of, k, keep, found));
            return;
        }
        let middle = range.len() / 2;
        let offset = key(self.points, of as u32, by_x) - key(self.points, range[middle], by_x);
        let (near, far) = if offset < 0.0 { (&range[..middle], &range[middle + 1..]) } else { (&range[middle + 1..], &range[..middle]) };
        self.visit(near, !by_x, of, k, keep, found);
        self.offer(range[middle], of, k, keep, found);
        if found.len() < k || offset * offset <= found[found.len() - 1].0 {
            self.visit(far, !by_x, of, k, keep, found);
        }
    }

    fn offer(&self, i: u32, of: usize, k: usize, keep: &impl Fn(usize) -> bool, found: &mut Vec<(f64, u32)>) {
        if i as usize == of || !keep(i as usize) {
            return;
        }
        let candidate = (squared_distance(self.points[of], self.points[i as usize]), i);
        let at = found.partition_point(|known| *known < candidate);
        if at < k {
            found.insert(at, candidate);
            found.truncate(k);
        }
    }
}

/// m²; several times faster than [`Point::distance`], which guards against overflow that the bounds of a profile exclude.
pub(super) fn squared_distance(a: Point, b: Point) -> f64 {
    (a.x - b.x).powi(2) + (a.y - b.y).powi(2)
}

fn key(points: &[Point], i: u32, by_x: bool) -> f64 {
    if by_x { points[i as usize].x } else { points[i as usize].y }
}

fn split(points: &[Point], order: &mut [u32], by_x: bool) {
    if order.len() <= LEAF {
        return;
    }
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| key(points, a, by_x).total_cmp(&key(points, b, by_x)).then(a.cmp(&b)));
    let (left, right) = order.split_at_mut(middle);
    split(points, left, !by_x);
    split(points, &mut right[1..], !by_x);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_what_a_full_scan_finds() {
        // A lattice with ties, a line, and a far point: the shapes that upset a grid.
        let mut points: Vec<Point> = (0..400).map(|i| Point::new(f64::from(i % 20), f64::from(i / 20))).collect();
        points.extend((0..200).map(|i| Point::new(0.01 * f64::from(i), 30.0)));
        points.push(Point::new(1e5, -1e5));
        let tree = Neighbours::new(&points);
        for of in 0..points.len() {
            let keep = |i: usize| !i.is_multiple_of(3);
            let mut scan: Vec<(f64, u32)> = (0..points.len())
                .filter(|&i| i != of && keep(i))
                .map(|i| (squared_distance(points[of], points[i]).sqrt(), i as u32))
                .collect();
            scan.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            scan.truncate(7);
            assert_eq!(tree.nearest(of, 7, keep), scan, "point {of}");
        }
    }
}
