//! Horizontal sections of a surface, and the edge loops where it ends: closed loops, open chains, which of them is the drape's outline.

use std::collections::HashMap;

use super::loops::{self, Chain};
use super::surface::{Space, Surface};
use crate::experiment::Point;
use crate::experiment::profile::signed_area;

/// One loop of a section or of the rim, seen from above.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Loop {
    /// Corners in order, m.
    pub points: Vec<Point>,
    /// The mesh edge (two vertices) that each corner lies on; of a rim twice the vertex itself.
    pub edges: Vec<[u32; 2]>,
    pub closed: bool,
    /// Length of bridged gaps over the length of the whole.
    pub bridged: f64,
    /// Length in plan, m.
    pub length: f64,
    /// Enclosed area in plan, m²; 0 for an open one.
    pub area: f64,
}

impl Loop {
    fn new(chain: &Chain, place: impl Fn(u32) -> Point, edge: impl Fn(u32) -> [u32; 2]) -> Loop {
        let points: Vec<Point> = chain.nodes.iter().map(|&node| place(node)).collect();
        let mut length: f64 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        if chain.closed {
            length += points[points.len() - 1].distance(points[0]);
        }
        Loop {
            area: if chain.closed { signed_area(&points).abs() } else { 0.0 },
            edges: chain.nodes.iter().map(|&node| edge(node)).collect(),
            points,
            closed: chain.closed,
            bridged: if 0.0 < length { chain.bridged / length } else { 0.0 },
            length,
        }
    }

    /// Whether the loop goes round `centre` (winding number not zero).
    pub fn goes_round(&self, centre: Point) -> bool {
        let n = self.points.len();
        let winding: i32 = (0..n)
            .map(|i| {
                let (a, b) = (self.points[i], self.points[(i + 1) % n]);
                let side = (b.x - a.x) * (centre.y - a.y) - (b.y - a.y) * (centre.x - a.x);
                match (a.y <= centre.y, b.y <= centre.y) {
                    (true, false) if 0.0 < side => 1,
                    (false, true) if side < 0.0 => -1,
                    _ => 0,
                }
            })
            .sum();
        self.closed && winding != 0
    }
}

/// All loops and chains in which the plane at `height` cuts `surface`, longest first; gaps up to the share `gap` of a loop are bridged.
pub(super) fn cut(surface: &Surface, height: f64, gap: f64) -> Vec<Loop> {
    // A vertex on the plane counts as above it: every triangle then has two crossed edges or none.
    let above = |vertex: u32| height <= surface.vertices[vertex as usize][2];
    // Looked up, never iterated over.
    let mut number: HashMap<[u32; 2], u32> = HashMap::new();
    let mut edges: Vec<[u32; 2]> = Vec::new();
    let mut segments: Vec<[u32; 2]> = Vec::new();
    for &[a, b, c] in &surface.triangles {
        let crossed = [[a, b], [b, c], [c, a]].into_iter().filter(|&[from, to]| above(from) != above(to));
        let mut ends = crossed.map(|[from, to]| {
            let edge = [from.min(to), from.max(to)];
            *number.entry(edge).or_insert_with(|| {
                edges.push(edge);
                edges.len() as u32 - 1
            })
        });
        if let (Some(from), Some(to)) = (ends.next(), ends.next()) {
            segments.push([from, to]);
        }
    }
    let places: Vec<Point> = edges.iter().map(|edge| crossing(surface, *edge, height)).collect();
    let place = |node: u32| places[node as usize];
    let chains = loops::follow(&segments, |before, here, after| turning(place(before), place(here), place(after)));
    let chains = loops::bridge(chains, gap, |a, b| place(a).distance(place(b)));
    sorted(chains.iter().map(|chain| Loop::new(chain, place, |node| edges[node as usize])).collect())
}

/// The loops of edges that belong to one triangle only, longest first: where the cloth ends, and the rims of holes. Gaps are none.
pub(super) fn rims(surface: &Surface) -> Vec<Loop> {
    let mut edges: Vec<[u32; 2]> =
        surface.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    let single: Vec<[u32; 2]> = edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]).collect();
    let place = |node: u32| plan(surface.vertices[node as usize]);
    let chains = loops::follow(&single, |before, here, after| turning(place(before), place(here), place(after)));
    sorted(chains.iter().map(|chain| Loop::new(chain, place, |node| [node, node])).collect())
}

/// The outline of the drape among the loops of one height: of those that go round `centre` the one that encloses most.
pub(super) fn outermost(loops: &[Loop], centre: Point) -> Option<usize> {
    (0..loops.len()).filter(|&i| loops[i].goes_round(centre)).max_by(|&a, &b| loops[a].area.total_cmp(&loops[b].area))
}

fn sorted(mut loops: Vec<Loop>) -> Vec<Loop> {
    loops.sort_by(|a, b| b.length.total_cmp(&a.length));
    loops
}

fn plan(vertex: Space) -> Point {
    Point::new(vertex[0], vertex[1])
}

fn crossing(surface: &Surface, [a, b]: [u32; 2], height: f64) -> Point {
    let (a, b) = (surface.vertices[a as usize], surface.vertices[b as usize]);
    let share = (height - a[2]) / (b[2] - a[2]);
    Point::new(a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))
}

/// How much the way turns at `here`: 0 straight on, 2 straight back.
fn turning(before: Point, here: Point, after: Point) -> f64 {
    let (ax, ay, bx, by) = (here.x - before.x, here.y - before.y, after.x - here.x, after.y - here.y);
    let lengths = ax.hypot(ay) * bx.hypot(by);
    if 0.0 < lengths { 1.0 - (ax * bx + ay * by) / lengths } else { 1.0 }
}
