//! The short closed tour through scattered points of a curve: greedy joining, then 2-opt and Or-opt.
//!
//! A curve sampled more finely than its folds approach each other is its own shortest tour, overhangs included (Giesen, Discrete &
//! Computational Geometry 24 (2000) 577–603). Greedy joining takes the short edges first, which are those of the curve; the exchanges
//! then remove the crossings it leaves. Neighbour lists and a work queue keep it near-linear: Bentley, ORSA Journal on Computing 4
//! (1992) 387–411.

use std::collections::VecDeque;

use super::neighbours::{Neighbours, squared_distance};
use super::profile::Point;

/// Neighbours looked at per point; beyond eight the tours hardly get shorter (Bentley 1992).
const CANDIDATES: usize = 8;
/// Longest piece that Or-opt moves.
const PIECE: usize = 3;

/// A closed tour through all `points` that no 2-opt or Or-opt exchange between near neighbours shortens; indices into `points`.
///
/// Deterministic: ties are broken by index. At least four points.
pub(super) fn shortest(points: &[Point], tree: &Neighbours) -> Vec<usize> {
    let near: Vec<Vec<(f64, u32)>> = (0..points.len()).map(|i| tree.nearest(i, CANDIDATES, |_| true)).collect();
    let mut tour = Tour::new(points, greedy(points, &near));
    tour.improve(&near);
    tour.order.into_iter().map(|i| i as usize).collect()
}

/// Joins the shortest edges first, as long as every point keeps at most two and no ring closes early.
fn greedy(points: &[Point], near: &[Vec<(f64, u32)>]) -> Vec<u32> {
    let n = points.len();
    let mut links: Vec<[Option<u32>; 2]> = vec![[None; 2]; n];
    let mut parent: Vec<u32> = (0..n as u32).collect();
    let mut fragments = n;
    let mut edges: Vec<(f64, u32, u32)> = Vec::new();
    for (i, list) in near.iter().enumerate() {
        edges.extend(list.iter().map(|&(d, j)| (d, (i as u32).min(j), (i as u32).max(j))));
    }
    loop {
        edges.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        edges.dedup();
        for &(_, a, b) in &edges {
            let open = links[a as usize][1].is_none() && links[b as usize][1].is_none();
            let (root_a, root_b) = (root(&mut parent, a), root(&mut parent, b));
            if open && root_a != root_b {
                link(&mut links, a, b);
                parent[root_a.max(root_b) as usize] = root_a.min(root_b);
                fragments -= 1;
            }
        }
        if fragments == 1 {
            break;
        }
        // What is left are the loose ends of fragments: join each to the nearest end of another fragment, until one is left.
        let ends: Vec<u32> = (0..n as u32).filter(|&i| links[i as usize][1].is_none()).collect();
        let roots: Vec<u32> = ends.iter().map(|&i| root(&mut parent, i)).collect();
        let places: Vec<Point> = ends.iter().map(|&i| points[i as usize]).collect();
        let tree = Neighbours::new(&places);
        edges.clear();
        for (k, &i) in ends.iter().enumerate() {
            for (d, other) in tree.nearest(k, CANDIDATES / 2, |o| roots[o] != roots[k]) {
                let j = ends[other as usize];
                edges.push((d, i.min(j), i.max(j)));
            }
        }
    }
    let start = (0..n as u32).find(|&i| links[i as usize][1].is_none()).unwrap_or(0);
    let mut order = Vec::with_capacity(n);
    let (mut previous, mut at) = (None, Some(start));
    while let Some(i) = at {
        order.push(i);
        let [one, two] = links[i as usize];
        at = if one == previous { two } else { one };
        // A single link is stored first: arriving by it, the way on is the empty second one.
        previous = Some(i);
        if order.len() == n {
            break;
        }
    }
    order
}

fn link(links: &mut [[Option<u32>; 2]], a: u32, b: u32) {
    for (from, to) in [(a, b), (b, a)] {
        let slot = if links[from as usize][0].is_none() { 0 } else { 1 };
        links[from as usize][slot] = Some(to);
    }
}

fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}

struct Tour<'a> {
    points: &'a [Point],
    order: Vec<u32>,
    place: Vec<u32>,
}

impl<'a> Tour<'a> {
    fn new(points: &'a [Point], order: Vec<u32>) -> Self {
        let mut place = vec![0; order.len()];
        for (at, &i) in order.iter().enumerate() {
            place[i as usize] = at as u32;
        }
        Tour { points, order, place }
    }

    fn distance(&self, a: u32, b: u32) -> f64 {
        squared_distance(self.points[a as usize], self.points[b as usize]).sqrt()
    }

    /// The point `steps` further along (backwards if negative).
    fn along(&self, a: u32, steps: isize) -> u32 {
        let n = self.order.len() as isize;
        self.order[(self.place[a as usize] as isize + steps).rem_euclid(n) as usize]
    }

    fn improve(&mut self, near: &[Vec<(f64, u32)>]) {
        let mut queue: VecDeque<u32> = self.order.iter().copied().collect();
        let mut queued = vec![true; self.order.len()];
        while let Some(a) = queue.pop_front() {
            queued[a as usize] = false;
            while let Some(touched) = self.two_opt(a, &near[a as usize]).or_else(|| self.or_opt(a, &near[a as usize])) {
                for i in touched {
                    if !queued[i as usize] {
                        queued[i as usize] = true;
                        queue.push_back(i);
                    }
                }
            }
        }
    }

    /// Gains below rounding are none: they would go round in circles.
    fn gains(&self, removed: f64, added: f64) -> bool {
        added < removed * (1.0 - 1e-12)
    }

    /// Replaces two edges, one of them at `a`, by two shorter ones.
    fn two_opt(&mut self, a: u32, near: &[(f64, u32)]) -> Option<Vec<u32>> {
        for step in [1, -1] {
            let b = self.along(a, step);
            let ab = self.distance(a, b);
            for &(ac, c) in near {
                if ab <= ac {
                    break;
                }
                let d = self.along(c, step);
                if c != b && d != a && self.gains(ab + self.distance(c, d), ac + self.distance(b, d)) {
                    self.exchange(a, b, c, d);
                    return Some(vec![a, b, c, d]);
                }
            }
        }
        None
    }

    /// Moves a piece of one to three points that ends at `a` to where `a` has a nearer neighbour, turned round if that is shorter.
    fn or_opt(&mut self, a: u32, near: &[(f64, u32)]) -> Option<Vec<u32>> {
        for length in 1..=PIECE as isize {
            for way in [1, -1] {
                // The piece runs from `a` to `z` in direction `way`, between `before` and `after`.
                let (z, before, after) = (self.along(a, way * (length - 1)), self.along(a, -way), self.along(a, way * length));
                let freed = self.distance(before, a) + self.distance(z, after) - self.distance(before, after);
                for &(ac, c) in near {
                    if freed <= ac {
                        break;
                    }
                    if self.within(c, a, way, length) {
                        continue;
                    }
                    for side in [1, -1] {
                        let d = self.along(c, side);
                        if self.within(d, a, way, length) {
                            continue;
                        }
                        let cd = self.distance(c, d);
                        let kept = freed + self.distance(before, after);
                        if self.gains(kept + cd, self.distance(before, after) + ac + self.distance(z, d)) {
                            self.relocate([before, a, z, after], c, d, side * way);
                            return Some(vec![before, a, z, after, c, d]);
                        }
                    }
                }
            }
        }
        None
    }

    /// Whether `c` belongs to the piece of `length` points from `a` in direction `way`.
    fn within(&self, c: u32, a: u32, way: isize, length: isize) -> bool {
        let n = self.order.len() as isize;
        let ahead = (way * (self.place[c as usize] as isize - self.place[a as usize] as isize)).rem_euclid(n);
        ahead < length
    }

    /// Puts the piece `a … z`, now between `before` and `after`, between the neighbours `c` and `d`, `a` beside `c`.
    ///
    /// `side` is +1 if, going on from `after`, `c` comes before `d`. The move is a chain of two or three exchanges.
    fn relocate(&mut self, [mut before, a, z, mut after]: [u32; 4], c: u32, d: u32, side: isize) {
        let (mut head, mut tail) = (a, z);
        let (mut first, mut second) = if 0 < side { (c, d) } else { (d, c) };
        if second == before {
            (before, after) = (after, before);
            (head, tail) = (tail, head);
            (first, second) = (second, first);
        }
        self.exchange(before, head, first, second);
        if first != after {
            self.exchange(before, first, after, tail);
        }
        // Now `first, tail … head, second`.
        let beside_first = if first == c { a } else { z };
        if beside_first != tail {
            self.exchange(first, tail, head, second);
        }
    }

    /// Replaces the edges a–b and c–d by a–c and b–d. In tour order, or against it: a, b, …, c, d.
    fn exchange(&mut self, a: u32, b: u32, c: u32, d: u32) {
        if self.along(a, 1) == b && self.along(c, 1) == d {
            self.reverse(b, c);
        } else {
            self.reverse(c, b);
        }
    }

    /// Reverses the path from `from` on to `to`, or the rest of the ring, which makes the same ring, whichever is shorter.
    fn reverse(&mut self, from: u32, to: u32) {
        let n = self.order.len();
        let (mut i, mut j) = (self.place[from as usize] as usize, self.place[to as usize] as usize);
        let inside = (j + n - i) % n + 1;
        let mut swaps = inside / 2;
        if n < 2 * inside {
            (i, j) = ((j + 1) % n, (i + n - 1) % n);
            swaps = (n - inside) / 2;
        }
        for _ in 0..swaps {
            self.order.swap(i, j);
            self.place[self.order[i] as usize] = i as u32;
            self.place[self.order[j] as usize] = j as u32;
            i = if i + 1 == n { 0 } else { i + 1 };
            j = if j == 0 { n - 1 } else { j - 1 };
        }
    }
}
