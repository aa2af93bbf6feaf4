//! Sines and cosines of the harmonics of a tangent angle at the nodes of one period: made once, for every curve of the same symmetry and order.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use super::C;
use crate::numerics::lanes::{Lanes, WIDTH};

/// Nodes for each harmonic: quintic interpolation then leaves 5e-6 of what the highest adds to the curve.
const NODES: usize = 8;
/// … and at least this many in a period: the exponential of a large first harmonic has many of its own.
const FEWEST_NODES: usize = 128;

/// Harmonics P, 2P, … of a curve of symmetry P, tabulated where they are asked for.
#[derive(Debug)]
pub(super) struct Harmonics {
    pub symmetry: u32,
    pub orders: usize,
    /// A power of two, of at least [`FEWEST_NODES`].
    pub nodes: usize,
    /// Node spacing in σ.
    pub step: f64,
    /// What turns the first period into each of the others.
    pub turns: Vec<C>,
    /// kP, eight harmonics in each; 0 where there are no more.
    pub order: Vec<Lanes>,
    tables: OnceLock<Tables>,
}

#[derive(Debug)]
struct Tables {
    /// Node after node, as long as `order` each: cosines at the node, then sines.
    by_node: Vec<Lanes>,
    /// Eight nodes after eight nodes: (cosine, sine) of each harmonic there.
    by_order: Vec<[Lanes; 2]>,
}

impl PartialEq for Harmonics {
    fn eq(&self, other: &Self) -> bool {
        (self.symmetry, self.orders) == (other.symmetry, other.orders)
    }
}

impl Harmonics {
    pub fn new(symmetry: u32, orders: usize) -> Self {
        let nodes = FEWEST_NODES.max(NODES * orders).next_power_of_two();
        // One period of a curve without symmetry is the whole turn, and its folds need their nodes.
        let nodes = if symmetry == 1 { nodes.max(4 * FEWEST_NODES) } else { nodes };
        let mut order = vec![Lanes::ZERO; orders.div_ceil(WIDTH)];
        (0..orders).for_each(|k| order[k / WIDTH].0[k % WIDTH] = (k + 1) as f64 * f64::from(symmetry));
        let turns = (0..symmetry).map(|turn| C::from_polar(1.0, TAU * f64::from(turn) / f64::from(symmetry))).collect();
        Harmonics { symmetry, orders, nodes, step: TAU / f64::from(symmetry) / nodes as f64, turns, order, tables: OnceLock::new() }
    }

    fn tables(&self) -> &Tables {
        self.tables.get_or_init(|| Tables::new(self.nodes, self.orders))
    }

    /// Cosines and sines at node j, 0 … `nodes`; the last is the first.
    #[inline(always)]
    pub fn at(&self, j: usize) -> (&[Lanes], &[Lanes]) {
        let vectors = self.order.len();
        let first = 2 * vectors * if j < self.nodes { j } else { j - self.nodes };
        self.tables().by_node[first..first + 2 * vectors].split_at(vectors)
    }

    /// (Cosine, sine) of each harmonic at the eight nodes from `8 block`.
    #[inline(always)]
    pub fn block(&self, block: usize) -> &[[Lanes; 2]] {
        &self.tables().by_order[self.orders * block..self.orders * (block + 1)]
    }

    /// What turns the first period into the next.
    pub fn turn(&self) -> C {
        self.turns[1 % self.turns.len()]
    }
}

impl Tables {
    fn new(nodes: usize, orders: usize) -> Self {
        let roots: Vec<(f64, f64)> = (0..nodes).map(|j| (TAU * j as f64 / nodes as f64).sin_cos()).collect();
        let vectors = orders.div_ceil(WIDTH);
        let mut by_node = vec![Lanes::ZERO; 2 * vectors * nodes];
        let mut by_order = vec![[Lanes::ZERO; 2]; orders * nodes / WIDTH];
        for k in 1..=orders {
            let (vector, lane) = ((k - 1) / WIDTH, (k - 1) % WIDTH);
            for j in 0..nodes {
                let (sin, cos) = roots[j * k % nodes];
                let row = &mut by_node[2 * vectors * j..2 * vectors * (j + 1)];
                (row[vector].0[lane], row[vectors + vector].0[lane]) = (cos, sin);
                let eight = &mut by_order[orders * (j / WIDTH) + k - 1];
                (eight[0].0[j % WIDTH], eight[1].0[j % WIDTH]) = (cos, sin);
            }
        }
        Tables { by_node, by_order }
    }
}
