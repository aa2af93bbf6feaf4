//! The cheapest way through a band of pairs of samples and nodes, in order, once round.
//!
//! The cost of a cell follows from those of three that lie on the two diagonals before its own, so the cells of a diagonal are reckoned eight at a time.

use crate::experiment::Point;
use crate::numerics::lanes::WIDTH;
use crate::vectorized;

/// The band: node `sample + lag + base` is paired with a sample for lags of up to `half` either way.
#[derive(Clone, Copy)]
pub(super) struct Band {
    pub base: i64,
    pub half: i64,
}

/// Cells (step, column) of a band lie on the diagonal `2 step + column`.
struct Shape {
    steps: usize,
    width: usize,
    /// Room for the cells of one diagonal.
    stride: usize,
}

impl Shape {
    /// First and last step of a diagonal.
    #[inline(always)]
    fn steps_of(&self, diagonal: usize) -> (usize, usize) {
        ((diagonal + 1).saturating_sub(self.width).div_ceil(2), (diagonal / 2).min(self.steps))
    }

    /// Where the cell after that of a step lies, on the diagonal two before this one: two empty diagonals come before the first, and one empty cell
    /// before each.
    #[inline(always)]
    fn after(&self, two_on: usize, step: usize) -> usize {
        let first = (two_on + 1).saturating_sub(self.width + 2).div_ceil(2);
        two_on * self.stride + 2 + step - first
    }
}

/// Samples and nodes in the order in which the diagonals meet them: node `step + column` is the one `step` after `last − diagonal`.
struct Places {
    x: Vec<f64>,
    y: Vec<f64>,
    node_x: Vec<f64>,
    node_y: Vec<f64>,
}

impl Places {
    /// Squared distance of a cell's sample and node, m².
    fn cost(&self, last: usize, step: usize, column: usize) -> f64 {
        let node = last - step - column;
        let (dx, dy) = (self.x[step] - self.node_x[node], self.y[step] - self.node_y[node]);
        dx * dx + dy * dy
    }
}

/// Cells (sample, lag) of the cheapest path from (`from`, `lag`) once round to (`from + n`, `lag`); both curves have as many points. `scratch` is
/// room to be used again.
pub(super) fn path(samples: &[Point], nodes: &[Point], from: usize, lag: i64, band: Band, scratch: &mut Vec<f64>) -> Vec<(usize, i64)> {
    let n = samples.len();
    let width = (2 * band.half + 1) as usize;
    let shape = Shape { steps: n, width, stride: width / 2 + 4 + WIDTH };
    let last = n + width - 1;
    let first = (from as i64 - band.half + band.base + last as i64).rem_euclid(n as i64) as usize;
    // The lanes after the last are read, and count for nothing.
    let all = || samples[from..].iter().chain(samples.iter().cycle()).take(n + 1 + WIDTH);
    let met = || nodes[..=first].iter().rev().chain(nodes.iter().rev().cycle()).take(last + 1 + WIDTH);
    let places = Places {
        x: all().map(|p| p.x).collect(),
        y: all().map(|p| p.y).collect(),
        node_x: met().map(|p| p.x).collect(),
        node_y: met().map(|p| p.y).collect(),
    };
    let start = (lag + band.half) as usize;
    // What is left in it from before is not looked at.
    scratch.resize((2 * n + width + 3) * shape.stride, 0.0);
    scratch[..2 * shape.stride].fill(f64::INFINITY);
    add_up(&shape, &places, start, scratch);
    let mut cells = Vec::with_capacity(2 * n);
    let (mut step, mut column) = (n, start);
    loop {
        cells.push((from + step, column as i64 - band.half));
        if step == 0 {
            if column == start {
                break;
            }
            column -= 1;
            continue;
        }
        // The same comparisons as on the way here.
        let (diagonal, here) = (2 * step + column, places.cost(last, step, column));
        let both = scratch[shape.after(diagonal, step) - 2] + 2.0 * here;
        let sample = scratch[shape.after(diagonal + 1, step) - 2] + here;
        let node = scratch[shape.after(diagonal + 1, step) - 1] + here;
        if node < both.min(sample) {
            column -= 1;
        } else {
            step -= 1;
            column += usize::from(sample < both);
        }
    }
    cells.reverse();
    cells
}

vectorized! {
    /// The least total of each cell: both curves advance, or the sample alone, or the node alone.
    fn add_up<V>(shape: &Shape, places: &Places, start: usize, totals: &mut [f64]) -> () {
        let last = shape.steps + shape.width - 1;
        for diagonal in 0..=2 * shape.steps + shape.width - 1 {
            let (low, high) = shape.steps_of(diagonal);
            let mut step = low;
            while step <= high {
                let (node, here) = (last + step - diagonal, shape.after(diagonal + 2, step) - 1);
                let dx = V::read(&places.x[step..]) - V::read(&places.node_x[node..]);
                let dy = V::read(&places.y[step..]) - V::read(&places.node_y[node..]);
                let cost = dx * dx + dy * dy;
                let before = shape.after(diagonal + 1, step);
                let both = V::read(&totals[shape.after(diagonal, step) - 2..]) + cost * 2.0;
                let sample = V::read(&totals[before - 2..]) + cost;
                let node = V::read(&totals[before - 1..]) + cost;
                let best = V::choose(sample, both, sample, both);
                let best = V::choose(node, best, node, best);
                totals[here..here + WIDTH].copy_from_slice(&best.lanes().0);
                step += WIDTH;
            }
            if diagonal == start {
                let (dx, dy) = (places.x[0] - places.node_x[last - start], places.y[0] - places.node_y[last - start]);
                totals[shape.after(diagonal + 2, 0) - 1] = dx * dx + dy * dy;
            }
            // What lies beside the band cannot be come from.
            totals[(diagonal + 2) * shape.stride] = f64::INFINITY;
            totals[shape.after(diagonal + 2, high)] = f64::INFINITY;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Total cost of a path, and whether each cell follows the one before.
    fn total(samples: &[Point], nodes: &[Point], band: Band, cells: &[(usize, i64)]) -> f64 {
        let n = samples.len();
        let cost = |(i, lag): (usize, i64)| {
            let node = nodes[(i as i64 + lag + band.base).rem_euclid(n as i64) as usize];
            (samples[i % n].x - node.x).powi(2) + (samples[i % n].y - node.y).powi(2)
        };
        let steps = cells.windows(2).map(|pair| match (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1) {
            (1, 0) => 2.0 * cost(pair[1]),
            (1, -1) | (0, 1) => cost(pair[1]),
            step => panic!("{step:?}"),
        });
        cost(cells[0]) + steps.sum::<f64>()
    }

    #[test]
    fn the_path_is_the_cheapest_of_all() {
        for (n, half, from, lag, base) in [(24, 4, 0, 0, 0), (24, 7, 5, -2, 3), (40, 12, 39, 12, -11), (17, 4, 8, -4, 40)] {
            let curve = |shift: f64, wave: f64| -> Vec<Point> {
                let angle = |i: usize| TAU * i as f64 / n as f64;
                (0..n).map(|i| angle(i) + wave * (3.0 * angle(i)).sin()).map(|a| Point::new((a + shift).cos(), (a + shift).sin())).collect()
            };
            let (samples, nodes) = (curve(0.1, 0.2), curve(0.0, -0.1));
            let band = Band { base, half };
            let cells = path(&samples, &nodes, from, lag, band, &mut vec![7.0; 11]);
            assert_eq!((cells[0], *cells.last().unwrap()), ((from, lag), (from + n, lag)));
            assert!(cells.iter().all(|cell| cell.1.abs() <= half));
            // Cell by cell, in rows.
            let width = (2 * half + 1) as usize;
            let mut above = vec![f64::INFINITY; width + 1];
            for step in 0..=n {
                let mut left = f64::INFINITY;
                for column in 0..width {
                    let sample = samples[(from + step) % n];
                    let node = nodes[(from as i64 + step as i64 + column as i64 - half + base).rem_euclid(n as i64) as usize];
                    let here = (sample.x - node.x).powi(2) + (sample.y - node.y).powi(2);
                    let first = step == 0 && column as i64 == lag + half;
                    left = if first { here } else { (above[column] + 2.0 * here).min(above[column + 1] + here).min(left + here) };
                    above[column] = left;
                }
            }
            let (found, least) = (total(&samples, &nodes, band, &cells), above[(lag + half) as usize]);
            // Sums of the same costs in different order.
            assert!((found / least - 1.0).abs() < 1e-13, "{n}: {found} {least}");
        }
    }
}
