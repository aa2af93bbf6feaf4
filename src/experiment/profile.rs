//! A measured drape profile: the closed plan-view outline of a hem, checked once.

use serde::{Deserialize, Serialize};

use super::neighbours::squared_distance;
use super::ordering;
use crate::error::Error;

/// A point of the plan view, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Point {
    pub x: f64,
    pub y: f64,
}

impl Point {
    pub fn new(x: f64, y: f64) -> Self {
        Point { x, y }
    }

    /// Distance to another point, m.
    pub fn distance(self, other: Point) -> f64 {
        // No coordinate of cloth comes near the range of squares that hypot guards, at several times the cost.
        let (x, y) = (self.x - other.x, self.y - other.y);
        (x * x + y * y).sqrt()
    }
}

/// Fewest points from which six parameters and a noise level can be told: 6 + 1, and AICc needs two more; a few to spare.
pub const FEWEST_POINTS: usize = 12;

/// Largest coordinate that is taken for a place on a cloth, m: squares and sums of squares stay far from overflow.
const FARTHEST: f64 = 1e12;

/// A closed outline: finite, distinct, at least [`FEWEST_POINTS`] points, in order round the outline, counter-clockwise, first point not repeated.
#[derive(Debug, Clone, PartialEq)]
pub struct DrapeProfile {
    points: Vec<Point>,
    source_index: Vec<usize>,
    scattered: bool,
}

impl DrapeProfile {
    /// Checks an outline and puts it in order, counter-clockwise. Points in m, in any order and direction, closed or not.
    ///
    /// Points that repeat an earlier one exactly are left out. An order that goes round the outline is kept, also where noise is wider than
    /// the spacing or a few points are far off; scattered points are put in the order of the short closed tour through them, and
    /// [`was_scattered`](Self::was_scattered) says so.
    ///
    /// # Errors
    /// [`Error::Unanswerable`] with fewer than [`FEWEST_POINTS`] distinct points, or if they enclose no area;
    /// [`Error::Invalid`] if a coordinate is not finite, or further out than 1e12 m.
    pub fn new(points: &[Point]) -> Result<Self, Error> {
        for point in points {
            for (quantity, value) in [("x of an outline point, m", point.x), ("y of an outline point, m", point.y)] {
                if !(-FARTHEST..=FARTHEST).contains(&value) {
                    return Err(Error::Invalid { quantity, value, allowed: "a finite number of metres, at most 1e12" });
                }
            }
        }
        let mut source_index = first_occurrences(points);
        if source_index.len() < FEWEST_POINTS {
            return Err(Error::Unanswerable(format!(
                "a profile of {} distinct points; at least {FEWEST_POINTS} round the whole hem are needed",
                source_index.len()
            )));
        }
        let mut distinct: Vec<Point> = source_index.iter().map(|&i| points[i]).collect();
        let order = ordering::reorder(&distinct);
        let scattered = order.is_some();
        if let Some(order) = order {
            source_index = order.iter().map(|&i| source_index[i]).collect();
            distinct = order.iter().map(|&i| distinct[i]).collect();
        }
        let area = signed_area(&distinct);
        let extent = distinct.iter().map(|&p| squared_distance(p, distinct[0])).fold(0.0, f64::max);
        if area.abs() <= 1e-6 * extent {
            return Err(Error::Unanswerable("a profile whose points lie on a line and enclose no area".into()));
        }
        if area < 0.0 {
            distinct.reverse();
            source_index.reverse();
        }
        Ok(DrapeProfile { points: distinct, source_index, scattered })
    }

    /// The outline, m, counter-clockwise.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The same points in another frame; `to` must keep what was checked: shifts, turns and scaling do.
    pub(crate) fn map(&self, to: impl Fn(Point) -> Point) -> DrapeProfile {
        DrapeProfile { points: self.points.iter().map(|p| to(*p)).collect(), ..self.clone() }
    }

    /// `source_index()[i]` is the place that point `i` had in the input.
    pub fn source_index(&self) -> &[usize] {
        &self.source_index
    }

    /// Whether the input came in no order round the outline, so that the order was reconstructed.
    pub fn was_scattered(&self) -> bool {
        self.scattered
    }
}

/// Indices of the points that repeat no earlier one, ascending.
fn first_occurrences(points: &[Point]) -> Vec<usize> {
    // Where no two x are alike, and they hardly ever are, no two points are.
    let mut abscissae: Vec<f64> = points.iter().map(|p| p.x + 0.0).collect();
    abscissae.sort_unstable_by(f64::total_cmp);
    if abscissae.windows(2).all(|pair| pair[0] != pair[1]) {
        return (0..points.len()).collect();
    }
    let mut sorted: Vec<usize> = (0..points.len()).collect();
    // Adding zero makes -0.0 the same place as 0.0.
    let key = |i: usize| (points[i].x + 0.0, points[i].y + 0.0);
    sorted.sort_unstable_by(|&a, &b| key(a).0.total_cmp(&key(b).0).then(key(a).1.total_cmp(&key(b).1)).then(a.cmp(&b)));
    sorted.dedup_by(|later, earlier| points[*later] == points[*earlier]);
    sorted.sort_unstable();
    sorted
}

/// Area of a closed polygon of at least one corner, m², positive counter-clockwise; taken about its first point, so that a far origin costs no digits.
pub fn signed_area(points: &[Point]) -> f64 {
    let o = points[0];
    let cross = |a: &Point, b: &Point| (a.x - o.x) * (b.y - o.y) - (b.x - o.x) * (a.y - o.y);
    0.5 * points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| cross(a, b)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn ellipse(n: usize) -> Vec<Point> {
        (0..n).map(|i| TAU * i as f64 / n as f64).map(|t| Point::new(0.3 * t.cos(), 0.2 * t.sin())).collect()
    }

    #[test]
    fn direction_repeats_and_the_closing_point_are_put_right_and_the_sources_kept() {
        let mut points = ellipse(40);
        points.reverse();
        points.insert(5, points[4]);
        points.push(points[0]);
        points.insert(20, points[3]);
        let profile = DrapeProfile::new(&points).expect("an outline");
        assert_eq!(profile.points().len(), 40);
        assert!(0.0 < signed_area(profile.points()) && !profile.was_scattered());
        for (point, &source) in profile.points().iter().zip(profile.source_index()) {
            assert_eq!(*point, points[source]);
        }
        assert!(profile.source_index().windows(2).all(|pair| pair[1] < pair[0]));
    }

    #[test]
    fn an_outline_traced_twice_is_one_outline() {
        let once = ellipse(60);
        let profile = DrapeProfile::new(&[once.clone(), once].concat()).expect("an outline");
        assert_eq!((profile.points().len(), profile.was_scattered()), (60, false));
    }

    #[test]
    fn scattered_points_say_so_and_keep_their_sources() {
        let clean = ellipse(41);
        // 17 is coprime to 41: every point once, in no order round the outline.
        let points: Vec<Point> = (0..41).map(|i| clean[17 * i % 41]).collect();
        let profile = DrapeProfile::new(&points).expect("an outline");
        assert!(profile.was_scattered());
        for (i, (point, &source)) in profile.points().iter().zip(profile.source_index()).enumerate() {
            assert_eq!(*point, points[source]);
            let next = profile.points()[(i + 1) % 41];
            // Largest step of the ellipse in order: 0.3·2π/41.
            assert!(point.distance(next) < 0.3 * TAU / 41.0);
        }
    }

    #[test]
    fn what_is_no_outline_is_refused_with_its_reason() {
        let text = |points: &[Point]| DrapeProfile::new(points).expect_err("no outline").to_string();
        assert!(text(&ellipse(3)).contains("3 distinct points"));
        assert!(text(&vec![Point::new(0.1, 0.2); 50]).contains("1 distinct points"));
        assert!(text(&(0..50).map(|i| Point::new(f64::from(i), 2.0 * f64::from(i))).collect::<Vec<_>>()).contains("on a line"));
        for bad in [f64::NAN, f64::INFINITY, 1e200] {
            let mut points = ellipse(20);
            points[7].y = bad;
            assert!(text(&points).contains("y of an outline point"));
        }
    }
}
