//! How often an outline crosses itself, and whether a hem curve does so more often.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use super::eight_places::{in_eights, points_at};
use crate::experiment::Point;
use crate::experiment::polygon::Polygon;
use crate::model::hem::{Hem, Placement};
use crate::numerics::lanes::Lanes;
use crate::vectorized;

/// How often a closed polygon crosses itself.
pub fn crossings(points: &[Point]) -> usize {
    Polygon::new(points).crossings_of(points.len())
}

/// Whether the hem curve crosses itself more than so often; a crossing of two folds is counted from both.
pub fn crosses_more_than(hem: &Hem, crossings: usize) -> bool {
    let winds_once = hem.q.abs() < hem.p;
    let Bends { overhangs, lean } = bends(hem, bend_angles());
    // One radius for each polar angle: nothing to cross.
    if winds_once && !overhangs {
        return false;
    }
    // A crossing smaller than a hundredth of a fold is not seen.
    const NODES: usize = 128;
    let folds = hem.folds.max(1) as usize;
    // All folds are alike: the sides of one are held against all. A hem of few folds gets the nodes of six.
    let nodes = NODES * 6_usize.div_ceil(folds);
    let n = nodes * folds;
    let corners = points_at(hem, &Placement::ORIGIN, (0..n).map(|i| TAU * i as f64 / n as f64));
    // Where the curve winds once round its centre, points that meet lean over by as much as they are apart; a little more, because the lean is known
    // at some places only.
    let reach = if winds_once { (2.2 * lean.atan() / TAU * n as f64) as usize + nodes / 8 } else { n };
    crossings / folds < Polygon::new(&corners).crossings_within(nodes, reach, crossings / folds + 1)
}

/// What one fold shows of where its curve may meet another's.
struct Bends {
    /// Whether there are several radii for one polar angle, as [`Hem::overhangs`] says.
    overhangs: bool,
    /// The largest |τ|/ρ.
    lean: f64,
}

/// Places of one fold that are looked at.
const BENDS: usize = 256;

/// (cos, sin) of the fold's angle at equal steps of it.
fn bend_angles() -> &'static [[Lanes; 2]] {
    static ANGLES: OnceLock<Vec<[Lanes; 2]>> = OnceLock::new();
    ANGLES.get_or_init(|| {
        let angles = in_eights((0..BENDS).map(|i| TAU * i as f64 / BENDS as f64), 0.0);
        angles.iter().map(|eight| [Lanes(eight.0.map(f64::cos)), Lanes(eight.0.map(f64::sin))]).collect()
    })
}

vectorized! {
    fn bends<V>(hem: &Hem, angles: &[[Lanes; 2]]) -> Bends {
        let m = f64::from(hem.folds);
        let (mut least, mut lean) = (V::all(-f64::INFINITY), V::zero());
        for [cos, sin] in angles {
            let (cos, sin) = (V::of(cos), V::of(sin));
            let (sin_lean, cos_lean) = (sin * cos * 2.0, V::all(1.0) - sin * sin * 2.0);
            let (rho, tau) = (cos * hem.q + hem.p, sin_lean * hem.s);
            let (radial, tangential) = (sin * (-hem.q * m) - tau, rho + cos_lean * (2.0 * m * hem.s));
            least = (tau * radial - rho * tangential).max(least);
            lean = (tau.abs() / rho.abs()).max(lean);
        }
        Bends { overhangs: 0.0 < least.greatest(), lean: lean.greatest() }
    }
}
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hem_crosses_itself_as_often_as_all_its_sides_cross_one_another() {
        let mut seen = [false; 2];
        for (folds, q) in [(2, 0.3), (3, 0.05), (6, 0.05), (7, 0.01), (12, 0.04), (24, 0.1), (9, 0.16)] {
            for share in 0..12 {
                let hem = Hem { p: 0.15, q, s: 0.012 * f64::from(share), folds };
                let nodes = 128 * 6_usize.div_ceil(folds as usize);
                let corners = hem.outline(&Placement::ORIGIN, nodes * folds as usize);
                let count = Polygon::new(&corners).crossings_of(nodes) * folds as usize;
                let count = if hem.q < hem.p && !hem.overhangs() { 0 } else { count };
                for limit in [0, 1, 5, 12, 100, count.saturating_sub(1), count, count + 1] {
                    assert_eq!(crosses_more_than(&hem, limit), limit < count, "{hem:?}: {count}, {limit}");
                    seen[usize::from(limit < count)] = true;
                }
            }
        }
        assert_eq!(seen, [true; 2]);
    }

    #[test]
    fn a_figure_of_eight_crosses_itself_once() {
        let points: Vec<Point> =
            (0..200).map(|i| f64::from(i) * TAU / 200.0 + 0.01).map(|t| Point::new(t.cos(), (2.0 * t).sin())).collect();
        assert_eq!(crossings(&points), 1);
    }
}
