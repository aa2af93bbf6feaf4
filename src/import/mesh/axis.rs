//! The axis of a skirt, found by geometry: the direction across which its sections are closed, round and above one another.

use super::sections::{Loop, cut, rims};
use super::surface::{Space, Surface, cross, dot, subtract, unit};
use crate::experiment::Point;

/// Heights that are looked at, as shares of the extent: away from both rims, where a tilted hem or an uneven waist begins.
const LOOKED_AT: [f64; 7] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8];
/// Gaps while looking: a scan with holes is still seen to be round.
const GAP: f64 = 0.1;
/// A direction within this angle of a coordinate axis is that axis, rad (3°): scans stand on a level table, and folds are uneven.
const LEVEL: f64 = 0.052;
/// Loops of the rim that are looked at: hem, waist, and some holes.
const RIMS: usize = 4;

/// An axis and how sure it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Found {
    /// Unit vector upwards: to the narrower end.
    pub up: Space,
    /// 0 … 1: one less the misfit of this direction over that of the best other one; 0.5 is twice as good.
    pub confidence: f64,
}

/// The best axis among the coordinate axes, the normals of the rims and the principal axes of the surface.
pub(super) fn find(surface: &Surface) -> Found {
    let coordinate = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut directions: Vec<Space> = coordinate.to_vec();
    // The vector area of a closed loop points along the axis however deep its folds are.
    directions.extend(rims(surface).iter().filter(|rim| rim.closed).take(RIMS).map(|rim| unit(vector_area(surface, rim))));
    directions.extend(principal_axes(surface));
    let mut candidates: Vec<(Space, f64)> = Vec::new();
    for direction in directions {
        let near = |other: Space| (1.0 - dot(direction, other).abs()).max(0.0) < 0.5 * LEVEL * LEVEL;
        if 0.5 < dot(direction, direction) && !candidates.iter().any(|(other, _)| near(*other)) {
            candidates.push((direction, misfit(surface, direction)));
        }
    }
    candidates.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (axis, least) = candidates[0];
    // Directions within 30° are the same answer, less exact.
    let next = candidates.iter().find(|(other, _)| dot(axis, *other).abs() < 0.866).map_or(1.0, |(_, misfit)| *misfit);
    let confidence = if 0.0 < next { (1.0 - least / next).clamp(0.0, 1.0) } else { 0.0 };
    Found { up: upwards(surface, axis), confidence }
}

/// `axis` or its opposite: sections grow longer towards the hem.
pub(super) fn upwards(surface: &Surface, axis: Space) -> Space {
    let turned = turned(surface, axis);
    let lengths: Vec<(f64, f64)> =
        heights(&turned).filter_map(|(share, height)| Some((share, cut(&turned, height, GAP).first()?.length))).collect();
    let n = lengths.len().max(1) as f64;
    let mean = lengths.iter().map(|(share, _)| share).sum::<f64>() / n;
    let slope: f64 = lengths.iter().map(|(share, length)| (share - mean) * length).sum();
    if 0.0 < slope { axis.map(|x| -x) } else { axis }
}

/// The surface with `up` turned into z; coordinates only change places where `up` is a coordinate axis.
pub(super) fn turned(surface: &Surface, up: Space) -> Surface {
    let rows = rows(up);
    let turn = |vertex: &Space| rows.map(|row| dot(row, *vertex));
    Surface { vertices: surface.vertices.iter().map(turn).collect(), triangles: surface.triangles.clone() }
}

/// A right-handed frame whose third axis is `up`.
fn rows(up: Space) -> [Space; 3] {
    // The coordinate axis after the one that `up` is nearest to: cyclic, so that coordinate axes stay exact.
    let largest = (0..3).max_by(|&a, &b| up[a].abs().total_cmp(&up[b].abs())).unwrap_or(2);
    let mut first = [0.0; 3];
    first[(largest + 1) % 3] = 1.0;
    let along = dot(first, up);
    let first = unit(subtract(first, up.map(|x| along * x)));
    [first, cross(up, first), up]
}

fn heights(turned: &Surface) -> impl Iterator<Item = (f64, f64)> + use<> {
    let range = turned.vertices.iter().map(|v| v[2]).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
    LOOKED_AT.into_iter().map(move |share| (share, range.0 + share * (range.1 - range.0)))
}

/// 0 where every section across `axis` is one closed loop, equally wide in all directions and above the others; 1 where none is closed.
fn misfit(surface: &Surface, axis: Space) -> f64 {
    let turned = turned(surface, axis);
    let moments: Vec<Option<Moments>> =
        heights(&turned).map(|(_, height)| cut(&turned, height, GAP).first().filter(|l| l.closed).map(Moments::of)).collect();
    let closed: Vec<&Moments> = moments.iter().flatten().collect();
    let n = closed.len() as f64;
    if closed.is_empty() {
        return 1.0;
    }
    let mean = |pick: &dyn Fn(&Moments) -> f64| closed.iter().map(|m| pick(m)).sum::<f64>() / n;
    let (x, y, width) = (mean(&|m| m.centre.x), mean(&|m| m.centre.y), mean(&|m| m.width));
    let apart = mean(&|m| m.centre.distance(Point::new(x, y))) / width;
    let goodness = closed.iter().map(|m| m.evenness).sum::<f64>() / moments.len() as f64;
    (1.0 - goodness * (1.0 - apart).max(0.0)).clamp(0.0, 1.0)
}

/// What matters of a closed loop.
struct Moments {
    centre: Point,
    /// Root of the largest second moment about the centre, m.
    width: f64,
    /// Root of the ratio of smallest to largest second moment: 1 for a circle with any number of even folds above two.
    evenness: f64,
}

impl Moments {
    /// By length, so that the density of corners does not matter.
    fn of(of: &Loop) -> Moments {
        let n = of.points.len();
        let pieces: Vec<(f64, Point)> = (0..n)
            .map(|i| (of.points[i], of.points[(i + 1) % n]))
            .map(|(a, b)| (a.distance(b), Point::new(0.5 * (a.x + b.x), 0.5 * (a.y + b.y))))
            .collect();
        let length = pieces.iter().map(|(l, _)| l).sum::<f64>().max(f64::MIN_POSITIVE);
        let mean = |pick: &dyn Fn(Point) -> f64| pieces.iter().map(|(l, p)| l * pick(*p)).sum::<f64>() / length;
        let centre = Point::new(mean(&|p| p.x), mean(&|p| p.y));
        let (xx, yy) = (mean(&|p| (p.x - centre.x).powi(2)), mean(&|p| (p.y - centre.y).powi(2)));
        let xy = mean(&|p| (p.x - centre.x) * (p.y - centre.y));
        let (half, apart) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        let (most, least) = (half + apart, (half - apart).max(0.0));
        let evenness = if 0.0 < most { (least / most).sqrt() } else { 0.0 };
        Moments { centre, width: most.max(f64::MIN_POSITIVE).sqrt(), evenness }
    }
}

fn vector_area(surface: &Surface, rim: &Loop) -> Space {
    let n = rim.edges.len();
    let at = |i: usize| surface.vertices[rim.edges[i % n][0] as usize];
    (0..n).fold([0.0; 3], |sum, i| super::surface::add(sum, cross(subtract(at(i), at(0)), subtract(at(i + 1), at(0)))))
}

/// Axes of inertia of the surface, by Jacobi rotations; exact to rounding after a few sweeps.
fn principal_axes(surface: &Surface) -> [Space; 3] {
    let n = surface.vertices.len() as f64;
    let mean: Space = std::array::from_fn(|k| surface.vertices.iter().map(|v| v[k]).sum::<f64>() / n);
    let mut a = [[0.0; 3]; 3];
    for vertex in &surface.vertices {
        let d = subtract(*vertex, mean);
        (0..3).for_each(|i| (0..3).for_each(|j| a[i][j] += d[i] * d[j] / n));
    }
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..10 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let angle = 0.5 * (2.0 * a[p][q]).atan2(a[q][q] - a[p][p]);
            let (sin, cos) = angle.sin_cos();
            for row in &mut a {
                (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
            }
            let (from, to) = (a[p], a[q]);
            a[p] = std::array::from_fn(|k| cos * from[k] - sin * to[k]);
            a[q] = std::array::from_fn(|k| sin * from[k] + cos * to[k]);
            let (from, to) = (axes[p], axes[q]);
            axes[p] = std::array::from_fn(|k| cos * from[k] - sin * to[k]);
            axes[q] = std::array::from_fn(|k| sin * from[k] + cos * to[k]);
        }
    }
    axes
}
