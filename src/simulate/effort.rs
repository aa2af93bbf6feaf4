//! How much work a prediction spends: nodes of its integrals, and how far fold counts are searched.

/// Work, unless told: all that is needed. `hemline study accuracy` turns these knobs; nothing else should have to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Intervals in half a fold (ruled and graded; the nodes along the slant go with them) or between the turning points (polar). `None`: as many
    /// as the answer needs, doubled until it holds. The ansatz always doubles its own.
    pub nodes: Option<usize>,
    /// A walk over fold counts ends on either side after so many in a row that cost more.
    pub patience: u32,
    /// Fold counts are compared in full if their rough energies are as close as usual, times this; 0: only the roughly best one.
    pub closeness: f64,
}

impl Default for Effort {
    /// Refinement shifts the best fold count by one, not by three: two in a row are enough. Chosen from `hemline study accuracy` (docs/studies.md): a
    /// search half as wide is a third cheaper and takes a fold count that is not the best in some scenes, a wider one costs more and finds the same.
    fn default() -> Self {
        Effort { nodes: None, patience: 2, closeness: 1.0 }
    }
}

impl Effort {
    /// `usual` nodes along the slant, or in proportion to the nodes in half a fold, of which `half` are usual.
    pub(super) fn sizes(&self, half: usize, slices: usize) -> (usize, usize) {
        match self.nodes {
            None => (half, slices),
            Some(nodes) => (nodes.max(2), (slices * nodes.max(2)).div_ceil(half).max(2)),
        }
    }

    /// The same for integrals that are not verified by doubling.
    pub(super) fn fixed(&self) -> bool {
        self.nodes.is_some()
    }
}
