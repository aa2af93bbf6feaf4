//! What is asked of a closed polygon again and again, without looking at every side each time.
//!
//! Corners follow one another at no more than the longest side, so a corner far from where something is sought says how many sides after it are
//! too far as well. They are leapt over; the answers are those of looking at every side.

use super::Point;

/// A closed polygon.
#[derive(Debug, Clone, Copy)]
pub struct Polygon<'a> {
    corners: &'a [Point],
    /// Length of the longest side, m.
    longest: f64,
}

/// The place of a polygon that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestPlace {
    /// Squared distance, m².
    pub square: f64,
    pub foot: Point,
    /// The side it lies on, from corner to corner, m.
    pub side: (f64, f64),
}

impl<'a> Polygon<'a> {
    /// `corners` in order, at least one; the last is joined to the first.
    pub fn new(corners: &'a [Point]) -> Self {
        let longest = corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        Polygon { corners, longest }
    }

    /// The place nearest to `point`; of several equally near ones that on the first side.
    pub fn nearest(&self, point: Point) -> NearestPlace {
        let n = self.corners.len();
        // A corner's distance bounds the least one from above. Every sixteenth corner will do.
        let square_to = |corner: &Point| (point.x - corner.x).powi(2) + (point.y - corner.y).powi(2);
        let mut bound = self.corners.iter().step_by(16).map(square_to).fold(f64::INFINITY, f64::min).sqrt();
        let mut found = NearestPlace { square: f64::INFINITY, foot: self.corners[0], side: (0.0, 0.0) };
        let mut i = 0;
        while i < n {
            let (a, b) = (self.corners[i], self.corners[if i + 1 < n { i + 1 } else { 0 }]);
            let (dx, dy) = (point.x - a.x, point.y - a.y);
            let away = (dx * dx + dy * dy).sqrt();
            let sides = self.leap(away - bound);
            if 0 < sides {
                i += sides;
                continue;
            }
            let (ex, ey) = (b.x - a.x, b.y - a.y);
            let share = ((dx * ex + dy * ey) / (ex * ex + ey * ey).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let square = (dx - share * ex).powi(2) + (dy - share * ey).powi(2);
            if square < found.square {
                found = NearestPlace { square, foot: Point::new(a.x + share * ex, a.y + share * ey), side: (ex, ey) };
                bound = bound.min(square.sqrt());
            }
            i += 1;
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
        let side = |a: Point, b: Point, c: Point| (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        let mut count = 0;
        for i in 0..sides {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % n]);
            let mut j = i + 2;
            while j < n {
                if i + reach < j && j + reach < n + i {
                    j = n + i - reach;
                    continue;
                }
                let (c, d) = (self.corners[j], self.corners[(j + 1) % n]);
                // Two sides that touch have their first corners within two sides.
                let leap = self.leap(a.distance(c) - 2.0 * self.longest);
                if 0 < leap {
                    j += leap;
                    continue;
                }
                let neighbours = i == 0 && j == n - 1;
                if !neighbours && side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0 {
                    count += 1;
                    if most <= count {
                        return count;
                    }
                }
                j += 1;
            }
        }
        count
    }

    /// How many sides from a corner on are too far, if that corner is too far by `excess` (m).
    fn leap(&self, excess: f64) -> usize {
        // A little less, so that rounding never leaps over a side that touches; a polygon that is one place has nothing to leap over.
        let sides = excess / self.longest * (1.0 - 1e-9) - 1e-9;
        if sides.is_finite() && 0.0 < sides { sides as usize } else { 0 }
    }
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
                let found = polygon.nearest(point);
                assert_eq!((found.square, found.foot), least, "{n} corners, point {k}");
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
            assert_eq!(Polygon::new(&corners).crossings_of(n), expected, "lean {lean}");
            seen += expected;
        }
        assert!(0 < seen);
    }
}
