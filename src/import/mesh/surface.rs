//! Raw polygons → one clean surface: triangles between distinct vertices, each once.

use std::collections::{HashMap, HashSet};

use super::raw::{Raw, Refusal};

/// Vertices nearer than this share of the largest extent are one: ten times the rounding of 32-bit coordinates, a thousandth of a mesh size.
const SAME_PLACE: f64 = 1e-6;
/// Squares and products of coordinates have to stay finite.
const FARTHEST: f64 = 1e100;
/// A polygon with more corners than this that is not convex is cut as if it were: cutting ears takes the square of their number.
const MOST_EARS: usize = 400;

/// A point or direction in space.
pub(super) type Space = [f64; 3];

/// Triangles between distinct vertices; every index is in range, every coordinate finite.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    pub vertices: Vec<Space>,
    /// Corners in the order of the file.
    pub triangles: Vec<[u32; 3]>,
}

/// Welds, triangulates and checks; what was changed goes into `notes`.
pub(super) fn clean(raw: &Raw, notes: &mut Vec<String>) -> Result<Surface, Refusal> {
    if raw.polygons().next().is_none() {
        let problem = if raw.vertices.is_empty() { "the file holds no mesh" } else { "the file holds points but no faces between them" };
        return Err(Refusal::new(problem, "export a surface: vertices and faces"));
    }
    let (vertices, welded) = weld(&raw.vertices)?;
    let mut triangles = Vec::new();
    let mut known: HashSet<[u32; 3]> = HashSet::new();
    let (mut flat, mut doubled, mut polygons) = (0_usize, 0_usize, 0_usize);
    for polygon in raw.polygons() {
        if let Some(&corner) = polygon.iter().find(|&&corner| raw.vertices.len() <= corner as usize) {
            let there = raw.vertices.len();
            let problem = format!("a face names vertex number {corner}, counted from 0, and there are {there} vertices");
            return Err(Refusal::new(problem, "the file was cut off or is broken: export it again"));
        }
        polygons += usize::from(3 < polygon.len());
        let mut corners: Vec<u32> = polygon.iter().map(|&corner| welded[corner as usize]).collect();
        corners.dedup();
        for triangle in triangulated(&corners, &vertices) {
            let mut sorted = triangle;
            sorted.sort_unstable();
            if sorted[0] == sorted[1] || sorted[1] == sorted[2] {
                flat += 1;
            } else if !known.insert(sorted) {
                doubled += 1;
            } else {
                triangles.push(triangle);
            }
        }
    }
    if triangles.is_empty() {
        return Err(Refusal::new("every face of the mesh is a point or a line", "export a surface"));
    }
    let merged = raw.vertices.len() - vertices.len();
    if 0 < merged {
        notes.push(format!("{merged} vertices stood where another stands and were put together"));
    }
    if 0 < polygons {
        notes.push(format!("{polygons} faces with more than three corners were cut into triangles"));
    }
    if 0 < flat + doubled {
        notes.push(format!("{} faces were points, lines or copies of others and were left out", flat + doubled));
    }
    Ok(Surface { vertices, triangles })
}

/// Distinct vertices in order of first appearance, and for each old vertex its new number.
fn weld(vertices: &[Space]) -> Result<(Vec<Space>, Vec<u32>), Refusal> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (at, vertex) in vertices.iter().enumerate() {
        for (axis, &value) in vertex.iter().enumerate() {
            if !(-FARTHEST..=FARTHEST).contains(&value) {
                let problem = format!("vertex {at}, counted from 0, has the coordinate {value}");
                return Err(Refusal::new(problem, "every coordinate must be a finite number"));
            }
            low[axis] = low[axis].min(value);
            high[axis] = high[axis].max(value);
        }
    }
    let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    if extent <= 0.0 {
        return Err(Refusal::new("all vertices stand in one place", "export a surface"));
    }
    let cell = SAME_PLACE * extent;
    let place = |vertex: &Space| -> [i64; 3] { std::array::from_fn(|axis| ((vertex[axis] - low[axis]) / cell) as i64) };
    let mut distinct: Vec<Space> = Vec::new();
    // Looked up, never iterated over: its order is of no influence.
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut number = Vec::with_capacity(vertices.len());
    for vertex in vertices {
        let [i, j, k] = place(vertex);
        let near = (-1..=1).flat_map(|a| (-1..=1).flat_map(move |b| (-1..=1).map(move |c| [i + a, j + b, k + c])));
        // The cell itself first: in a welded file nothing else is ever found.
        let found = std::iter::once([i, j, k])
            .chain(near)
            .filter_map(|cell| cells.get(&cell))
            .flatten()
            .copied()
            .find(|&other| squared_distance(vertex, &distinct[other as usize]) <= cell * cell);
        number.push(found.unwrap_or_else(|| {
            distinct.push(*vertex);
            let new = distinct.len() as u32 - 1;
            cells.entry([i, j, k]).or_default().push(new);
            new
        }));
    }
    Ok((distinct, number))
}

/// Triangles of a polygon: a fan where it is convex, ears cut off one by one where it is not.
fn triangulated(corners: &[u32], vertices: &[Space]) -> Vec<[u32; 3]> {
    let n = corners.len();
    let at = |i: usize| vertices[corners[i % n] as usize];
    // The normal of the whole, by Newell: twice its area.
    let normal = (0..n).fold([0.0; 3], |sum, i| add(sum, cross(subtract(at(i), at(0)), subtract(at(i + 1), at(0)))));
    let turns_back = |a: Space, b: Space, c: Space| dot(cross(subtract(b, a), subtract(c, b)), normal) < 0.0;
    let fan = |corners: &[u32]| (2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]).collect::<Vec<_>>();
    if !(4..=MOST_EARS).contains(&n) || (0..n).all(|i| !turns_back(at(i), at(i + 1), at(i + 2))) {
        return fan(corners);
    }
    let mut left = corners.to_vec();
    let mut triangles = Vec::with_capacity(n);
    while 3 < left.len() {
        let count = left.len();
        let ear = (0..count).find(|&i| {
            let [a, b, c] = [left[(i + count - 1) % count], left[i], left[(i + 1) % count]];
            let [p, q, r] = [a, b, c].map(|v| vertices[v as usize]);
            let inside = |v: u32| {
                let x = vertices[v as usize];
                ![(p, q), (q, r), (r, p)].iter().any(|&(from, to)| dot(cross(subtract(to, from), subtract(x, to)), normal) <= 0.0)
            };
            !turns_back(p, q, r) && !left.iter().any(|&v| v != a && v != b && v != c && inside(v))
        });
        // A polygon that crosses itself has no ear; what is left of it is cut as it comes.
        let Some(i) = ear else { break };
        triangles.push([left[(i + count - 1) % count], left[i], left[(i + 1) % count]]);
        left.remove(i);
    }
    triangles.extend(fan(&left));
    triangles
}

pub(super) fn add(a: Space, b: Space) -> Space {
    std::array::from_fn(|k| a[k] + b[k])
}

pub(super) fn subtract(a: Space, b: Space) -> Space {
    std::array::from_fn(|k| a[k] - b[k])
}

pub(super) fn cross(a: Space, b: Space) -> Space {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn dot(a: Space, b: Space) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a` at length one; zero stays zero.
pub(super) fn unit(a: Space) -> Space {
    let length = dot(a, a).sqrt();
    a.map(|x| if 0.0 < length { x / length } else { 0.0 })
}

fn squared_distance(a: &Space, b: &Space) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polygon_that_is_not_convex_keeps_its_area() {
        // An arrow head: its fan from the first corner would reach outside.
        let vertices = [[0.0, 0.0, 0.0], [2.0, -1.0, 0.0], [0.5, 0.0, 0.0], [2.0, 1.0, 0.0]];
        for turn in 0..4 {
            let corners: Vec<u32> = (0..4).map(|i| (i + turn) % 4).collect();
            let triangles = triangulated(&corners, &vertices);
            let area = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|v| vertices[v as usize]);
                0.5 * cross(subtract(b, a), subtract(c, a))[2]
            };
            // The triangle without its notch: ½·2·2 − ½·2·1.5.
            let areas: Vec<f64> = triangles.iter().map(area).collect();
            assert!(areas.iter().all(|a| 0.0 < *a), "{areas:?}");
            assert!((areas.iter().sum::<f64>() - 0.5).abs() < 1e-15, "{areas:?}");
        }
    }

    #[test]
    fn vertices_that_differ_by_rounding_are_one_also_across_the_edge_of_a_cell() {
        let mut vertices = vec![[0.0; 3], [1.0, 1.0, 1.0]];
        // Cells are 1e-6 wide: these pairs straddle their edges.
        for k in 1..50 {
            let x = 1e-6 * f64::from(k) + 0.1;
            vertices.extend([[x - 1e-8, 0.5, 0.01 * f64::from(k)], [x + 1e-8, 0.5, 0.01 * f64::from(k)]]);
        }
        let (distinct, number) = weld(&vertices).expect("finite");
        assert_eq!(distinct.len(), 2 + 49);
        assert!((0..49).all(|k| number[2 + 2 * k] == number[3 + 2 * k]));
    }
}
