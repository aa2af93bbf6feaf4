//! What is asked of a closed polygon again and again, without looking at every side each time.
//!
//! Eight sides in a row lie within a circle about them. Where that is too far from what is sought its sides are passed over; the answers are those of
//! looking at every side.

use super::Point;

/// Sides in one circle.
const SIDES: usize = 8;
/// So much more than their radii do circles reach, as a share: rounding passes over no side.
const MARGIN: f64 = 1.0 + 1e-9;

/// A closed polygon.
#[derive(Debug, Clone)]
pub struct Polygon<'a> {
    corners: &'a [Point],
    /// About every [`SIDES`] sides in order.
    circles: Vec<Circle>,
}

/// A circle about a few sides, m.
#[derive(Debug, Clone, Copy)]
struct Circle {
    x: f64,
    y: f64,
    radius: f64,
}

impl Circle {
    fn about(corners: impl Iterator<Item = Point> + Clone) -> Self {
        let (mut low, mut high) = (Point::new(f64::INFINITY, f64::INFINITY), Point::new(f64::NEG_INFINITY, f64::NEG_INFINITY));
        for corner in corners.clone() {
            (low.x, low.y) = (low.x.min(corner.x), low.y.min(corner.y));
            (high.x, high.y) = (high.x.max(corner.x), high.y.max(corner.y));
        }
        let middle = Point::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y));
        let radius = corners.map(|corner| middle.distance(corner)).fold(0.0, f64::max);
        Circle { x: middle.x, y: middle.y, radius: MARGIN * radius }
    }

    /// Whether it comes within `distance` of a point.
    fn reaches(&self, x: f64, y: f64, distance: f64) -> bool {
        let (dx, dy, reach) = (self.x - x, self.y - y, self.radius + distance);
        dx * dx + dy * dy <= MARGIN * (reach * reach)
    }
}

/// The place of a polygon that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestPlace {
    /// Squared distance, m².
    pub square: f64,
    pub foot: Point,
    /// The corner at which its side begins.
    pub corner: usize,
    /// The side it lies on, from corner to corner, m.
    pub side: (f64, f64),
}

impl<'a> Polygon<'a> {
    /// `corners` in order, at least one; the last is joined to the first.
    pub fn new(corners: &'a [Point]) -> Self {
        let n = corners.len();
        let about = |first: usize| Circle::about((first..=(first + SIDES).min(n)).map(|i| corners[if i < n { i } else { 0 }]));
        Polygon { corners, circles: (0..n).step_by(SIDES).map(about).collect() }
    }

    /// The place nearest to `point`; of several equally near ones that on the first side.
    pub fn nearest(&self, point: Point) -> NearestPlace {
        // A corner's distance bounds the least one from above. Every sixteenth corner will do.
        let near = (0..self.corners.len()).step_by(16).map(|i| (square(point, self.corners[i]), i));
        self.nearest_from(point, near.fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a }).1)
    }

    /// The same, fastest where `corner` is near to it.
    pub fn nearest_from(&self, point: Point, corner: usize) -> NearestPlace {
        let n = self.corners.len();
        let mut bound = square(point, self.corners[corner]).sqrt();
        let mut found = NearestPlace { square: f64::INFINITY, foot: self.corners[0], corner: 0, side: (0.0, 0.0) };
        for (k, circle) in self.circles.iter().enumerate() {
            if !circle.reaches(point.x, point.y, bound) {
                continue;
            }
            for i in SIDES * k..(SIDES * (k + 1)).min(n) {
                let (a, b) = (self.corners[i], self.corners[if i + 1 < n { i + 1 } else { 0 }]);
                let (dx, dy) = (point.x - a.x, point.y - a.y);
                let (ex, ey) = (b.x - a.x, b.y - a.y);
                let share = ((dx * ex + dy * ey) / (ex * ex + ey * ey).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                let square = (dx - share * ex).powi(2) + (dy - share * ey).powi(2);
                if square < found.square {
                    found = NearestPlace { square, foot: Point::new(a.x + share * ex, a.y + share * ey), corner: i, side: (ex, ey) };
                }
            }
            bound = bound.min(found.square.sqrt());
        }
        found
    }

    /// How often the first `sides` sides cross a later side.
    pub fn crossings_of(&self, sides: usize) -> usize {
        self.crossings_within(sides, self.corners.len(), usize::MAX)
    }

    /// The same of sides that are no further than `reach` sides apart, one way round or the other; not counted on from `most`.
    pub fn crossings_within(&self, sides: usize, reach: usize, most: usize) -> usize {
        let n = self.corners.len();
        let end = |k: usize| (SIDES * (k + 1)).min(n);
        let mut count = 0;
        for (k, own) in self.circles.iter().enumerate().take(sides.div_ceil(SIDES)) {
            for (l, other) in self.circles.iter().enumerate().skip(k) {
                if !other.reaches(own.x, own.y, own.radius) {
                    continue;
                }
                for i in SIDES * k..end(k).min(sides) {
                    for j in (SIDES * l).max(i + 2)..end(l) {
                        let apart = j - i;
                        // The first side and the last are neighbours.
                        if apart + 1 < n && (apart <= reach || n <= apart + reach) && self.cross(i, j) {
                            count += 1;
                            if most <= count {
                                return count;
                            }
                        }
                    }
                }
            }
        }
        count
    }

    /// Whether two sides cross.
    fn cross(&self, i: usize, j: usize) -> bool {
        let corner = |i: usize| self.corners[if i < self.corners.len() { i } else { 0 }];
        let (a, b, c, d) = (corner(i), corner(i + 1), corner(j), corner(j + 1));
        let side = |a: Point, b: Point, c: Point| (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
    }
}

/// Squared distance, m².
fn square(a: Point, b: Point) -> f64 {
    let (dx, dy) = (a.x - b.x, a.y - b.y);
    dx * dx + dy * dy
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// An overhanging, uneven hem of `n` corners.
    fn hem(n: usize, lean: f64) -> Vec<Point> {
        (0..n)
            .map(|i| {
                let t = TAU * (i as f64 + 0.3 * (i as f64 * 1.7).sin()) / n as f64;
                let (sin, cos) = (7.0 * t).sin_cos();
                let (rho, tau) = (0.2 + 0.06 * cos, 2.0 * lean * sin * cos);
                Point::new(rho * t.cos() - tau * t.sin(), rho * t.sin() + tau * t.cos())
            })
            .collect()
    }

    #[test]
    fn nearest_place_is_that_of_looking_at_every_side() {
        for n in [1, 2, 3, 17, 360] {
            let corners = hem(n, 0.04);
            let polygon = Polygon::new(&corners);
            for k in 0..400 {
                let (r, angle) = (0.001 * f64::from(k), 2.399 * f64::from(k));
                let point = if k < 20 { corners[k as usize % n] } else { Point::new(r * angle.cos(), r * angle.sin()) };
                let mut least = (f64::INFINITY, Point::new(0.0, 0.0));
                for i in 0..n {
                    let (a, b) = (corners[i], corners[(i + 1) % n]);
                    let (ex, ey) = (b.x - a.x, b.y - a.y);
                    let along = (point.x - a.x) * ex + (point.y - a.y) * ey;
                    let share = (along / (ex * ex + ey * ey).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                    let foot = Point::new(a.x + share * ex, a.y + share * ey);
                    let square = (point.x - a.x - share * ex).powi(2) + (point.y - a.y - share * ey).powi(2);
                    if square < least.0 {
                        least = (square, foot);
                    }
                }
                // Whatever corner it is looked for from.
                for found in [polygon.nearest(point), polygon.nearest_from(point, 0), polygon.nearest_from(point, 5 * k as usize % n)] {
                    assert_eq!((found.square, found.foot), least, "{n} corners, point {k}");
                    assert_eq!(found, polygon.nearest_from(point, found.corner));
                }
            }
        }
    }

    #[test]
    fn crossings_are_those_of_comparing_all_sides() {
        let side = |a: Point, b: Point, c: Point| (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        let mut seen = 0;
        for lean in [0.0, 0.04, 0.08, 0.2] {
            let corners = hem(300, lean);
            let n = corners.len();
            let mut expected = 0;
            for i in 0..n {
                for j in i + 2..n - usize::from(i == 0) {
                    let (a, b, c, d) = (corners[i], corners[i + 1], corners[j], corners[(j + 1) % n]);
                    let crosses = side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0;
                    expected += usize::from(crosses);
                }
            }
            let polygon = Polygon::new(&corners);
            assert_eq!(polygon.crossings_of(n), expected, "lean {lean}");
            assert_eq!(polygon.crossings_within(n, n / 2, usize::MAX), expected);
            assert_eq!(polygon.crossings_within(n, n, 3), expected.min(3));
            assert_eq!(polygon.crossings_within(n, 1, usize::MAX), 0);
            seen += expected;
        }
        assert!(0 < seen);
    }
}
