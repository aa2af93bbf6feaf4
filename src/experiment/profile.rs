//! A measured drape profile: the closed plan-view outline of a hem, checked once.

use serde::{Deserialize, Serialize};

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
        (self.x - other.x).hypot(self.y - other.y)
    }
}

/// Fewest points from which six parameters and a noise level can be told: 6 + 1, and AICc needs two more; a few to spare.
pub const FEWEST_POINTS: usize = 12;

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
    /// # Errors
    /// [`Error::Unanswerable`] with fewer than [`FEWEST_POINTS`] distinct points, or if they enclose no area;
    /// [`Error::Invalid`] if a coordinate is not finite.
    pub fn new(points: &[Point]) -> Result<Self, Error> {
        for point in points {
            for (quantity, value) in [("x of an outline point, m", point.x), ("y of an outline point, m", point.y)] {
                if !value.is_finite() {
                    return Err(Error::Invalid { quantity, value, allowed: "a finite number" });
                }
            }
        }
        let mut source_index: Vec<usize> = Vec::with_capacity(points.len());
        for (i, point) in points.iter().enumerate() {
            if source_index.last().is_none_or(|&last| points[last] != *point) {
                source_index.push(i);
            }
        }
        while 1 < source_index.len() && points[source_index[0]] == points[source_index[source_index.len() - 1]] {
            source_index.pop();
        }
        if source_index.len() < FEWEST_POINTS {
            return Err(Error::Unanswerable(format!(
                "a profile of {} distinct points; at least {FEWEST_POINTS} round the whole hem are needed",
                source_index.len()
            )));
        }
        let mut points: Vec<Point> = source_index.iter().map(|&i| points[i]).collect();
        let area = signed_area(&points);
        let extent = points.iter().map(|p| p.distance(points[0])).fold(0.0, f64::max);
        if area.abs() < 1e-6 * extent * extent {
            return Err(Error::Unanswerable("a profile whose points lie on a line and enclose no area".into()));
        }
        if area < 0.0 {
            points.reverse();
            source_index.reverse();
        }
        Ok(DrapeProfile { points, source_index, scattered: false })
    }

    /// The outline, m, counter-clockwise.
    pub fn points(&self) -> &[Point] {
        &self.points
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

/// Area of a polygon, positive counter-clockwise.
fn signed_area(points: &[Point]) -> f64 {
    let closed = points.iter().zip(points.iter().cycle().skip(1));
    0.5 * closed.map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>()
}
