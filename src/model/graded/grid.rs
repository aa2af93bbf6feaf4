//! The points of a graded shell, eight slices to a register, and the linear maps between their fields: all that does not depend on the shape.
//!
//! A field lies node by node (around half a fold), each node's slices in `blocks` registers. Lanes past the last slice repeat it with no weight, so that
//! nothing has to ask for them.

use super::Slice;
use crate::numerics::lanes::{Lanes, WIDTH};

/// Tables for all points.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    pub nodes: usize,
    pub slices: usize,
    /// Registers that hold the slices of one node.
    pub blocks: usize,
    pub harmonics: usize,
    pub modes: usize,
    /// dR/dℓ.
    pub growth: f64,
    /// Trapezoid weights of the nodes.
    pub weights: Vec<f64>,
    /// sin kφ_n and its derivative by σ, index n · harmonics + k.
    pub waves: Vec<[f64; 2]>,
    pub bands: Vec<Band>,
    /// Functions of height and their derivatives by ℓ, index block · modes + j.
    pub basis: Vec<[Lanes; 3]>,
    /// Around: h from its sources, and the transpose, row by row.
    pub around: Vec<f64>,
    pub around_back: Vec<f64>,
    /// Along: −∫ dℓ from the waist (columns: where to), and the transpose.
    pub along: Vec<Lanes>,
    pub along_back: Vec<Lanes>,
}

/// Eight slices.
#[derive(Debug, Clone)]
pub(super) struct Band {
    /// R, m.
    pub ring: Lanes,
    /// Weight of ∫ dℓ times R as it was cut, m².
    pub cloth: Lanes,
    /// Weight of ∫ dℓ times what hangs below, m³.
    pub hanging: Lanes,
}

/// Eight at a time of what `value` gives for each slice, past the last `beyond` of it.
fn lanes(slices: &[Slice], block: usize, value: impl Fn(&Slice) -> f64, beyond: impl Fn(f64) -> f64) -> Lanes {
    let last = slices.len() - 1;
    Lanes(std::array::from_fn(|lane| {
        let q = block * WIDTH + lane;
        if q <= last { value(&slices[q]) } else { beyond(value(&slices[last])) }
    }))
}

impl Band {
    /// Of rings that have grown by their share of `by`, m.
    pub fn all(slices: &[Slice], by: f64) -> Vec<Band> {
        let band = |block| Band {
            ring: lanes(slices, block, |slice| slice.ring + slice.fraction * by, |last| last),
            cloth: lanes(slices, block, |slice| slice.weight * slice.cloth, |_| 0.0),
            hanging: lanes(slices, block, |slice| slice.weight * slice.below, |_| 0.0),
        };
        (0..slices.len().div_ceil(WIDTH)).map(band).collect()
    }
}

impl Grid {
    /// Functions of height, eight slices at a time.
    pub fn basis(slices: &[Slice], modes: usize) -> Vec<[Lanes; 3]> {
        let one = |block, j: usize| std::array::from_fn(|d| lanes(slices, block, |slice| slice.basis[j][d], |last| last));
        (0..slices.len().div_ceil(WIDTH)).flat_map(|block| (0..modes).map(move |j| one(block, j))).collect()
    }

    /// `running[q][j]`, negative, as rows by j of lanes by q; or rows by q of lanes by j.
    pub fn along(running: &[Vec<f64>], back: bool) -> Vec<Lanes> {
        let slices = running.len();
        let entry = |row: usize, lane: usize| if back { running[row].get(lane) } else { running.get(lane).map(|to| &to[row]) };
        let one = |row: usize, block: usize| Lanes(std::array::from_fn(|lane| entry(row, block * WIDTH + lane).map_or(0.0, |w| -w)));
        (0..slices).flat_map(|row| (0..slices.div_ceil(WIDTH)).map(move |block| one(row, block))).collect()
    }

    /// The same cloth with its hem's radius grown by `by`, m.
    pub fn lengthened(&self, by: f64, growth: f64, slices: &[Slice]) -> Grid {
        Grid { growth, bands: Band::all(slices, by), ..self.clone() }
    }

    /// Registers of one field.
    pub fn size(&self) -> usize {
        self.nodes * self.blocks
    }

    /// Numbers from one node to the next in a field.
    pub fn stride(&self) -> usize {
        self.blocks * WIDTH
    }
}
