//! How far one hem is from another, point of cloth by point of cloth.

use crate::experiment::Point;

/// Points at which hems of different fold counts are compared.
const POINTS: usize = 1440;

/// Greatest distance (m) between the same points of cloth of two hems, each from a crest on the x axis and equally spaced in cloth length.
pub(super) fn between(a: &[Point], b: &[Point]) -> f64 {
    if a.len() == b.len() {
        return a.iter().zip(b).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
    }
    let at = |outline: &[Point], i: usize| {
        let place = i as f64 / POINTS as f64 * outline.len() as f64;
        let (from, share) = (place as usize, place.fract());
        let (p, q) = (outline[from % outline.len()], outline[(from + 1) % outline.len()]);
        Point::new(p.x + share * (q.x - p.x), p.y + share * (q.y - p.y))
    };
    (0..POINTS).map(|i| at(a, i).distance(at(b, i))).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circles_of_any_number_of_points_differ_by_their_radii() {
        let circle = |radius: f64, n: usize| -> Vec<Point> {
            (0..n)
                .map(|i| (std::f64::consts::TAU * i as f64 / n as f64).sin_cos())
                .map(|(s, c)| Point::new(radius * c, radius * s))
                .collect()
        };
        assert!((between(&circle(1.0, 720), &circle(1.1, 720)) - 0.1).abs() < 1e-12);
        // Chords of 721 points sag by (π/721)²/2 ~ 1e-5.
        assert!((between(&circle(1.0, 720), &circle(1.1, 721)) - 0.1).abs() < 2e-5);
    }
}
