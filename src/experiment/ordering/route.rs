//! A way round through points: its length, how smooth it is, and where it jumps.

use super::{JUMP_SHARE, Point, squared_distance};

/// … and over at least this many, which the two neighbours on either side and the opposite flank of a narrow fold can make up.
const JUMP_POINTS: usize = 4;
/// So many of the longest steps are looked at; more jumps than this make no difference to the verdict.
pub(super) const LONGEST: usize = 1000;

/// Steps that leave the neighbourhood, among the [`LONGEST`].
pub(super) struct Jumps {
    pub count: usize,
    /// Sum of their lengths, m.
    pub length: f64,
}

/// A closed way round through some of the points.
pub(super) struct Route {
    order: Vec<usize>,
    /// `steps[i]`: from `order[i]` to the next, m.
    steps: Vec<f64>,
    /// Length through every second point, mean of the two ways to choose them, m.
    every_second: f64,
}

impl Route {
    pub fn new(points: &[Point], order: Vec<usize>) -> Self {
        let n = order.len();
        let stride = |by: usize| (0..n).map(|i| points[order[i]].distance(points[order[(i + by) % n]])).collect::<Vec<f64>>();
        let (steps, every_second) = (stride(1), 0.5 * stride(2).iter().sum::<f64>());
        Route { order, steps, every_second }
    }

    /// Length through every second point over length through all: 1 on a finely sampled curve, lower the more it zigzags.
    pub fn smoothness(&self) -> f64 {
        self.every_second / self.length()
    }

    pub fn length(&self) -> f64 {
        self.steps.iter().sum()
    }

    pub fn jumps(&self, points: &[Point]) -> Jumps {
        let n = self.order.len();
        let allowed = JUMP_POINTS.max((JUMP_SHARE * n as f64) as usize);
        let mut longest: Vec<usize> = (0..n).collect();
        longest.sort_unstable_by(|&a, &b| self.steps[b].total_cmp(&self.steps[a]).then(a.cmp(&b)));
        longest.truncate(LONGEST);
        let mut jumps = Jumps { count: 0, length: 0.0 };
        for at in longest {
            let (from, reach) = (points[self.order[at]], self.steps[at] * self.steps[at]);
            let nearer = self.order.iter().filter(|&&i| squared_distance(points[i], from) < reach).count();
            let passed = nearer.saturating_sub(1);
            if allowed < passed {
                jumps.count += 1;
                jumps.length += self.steps[at];
            }
        }
        jumps
    }
}
