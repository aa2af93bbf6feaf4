//! What a mesh file holds before anything is concluded from it: places and the polygons between them.

/// Vertices in the file's own unit and axes, polygons by vertex number; nothing is checked yet.
#[derive(Debug, Clone, Default)]
pub(super) struct Raw {
    pub vertices: Vec<[f64; 3]>,
    /// Corners of all polygons, one polygon after the other.
    corners: Vec<u32>,
    /// Where each polygon ends in `corners`.
    ends: Vec<usize>,
    /// The upward direction, where the format has one.
    pub up: Option<[f64; 3]>,
    /// Metres per unit, where the format has one.
    pub metres: Option<f64>,
    /// What a person should know about how it was read.
    pub notes: Vec<String>,
}

/// Why a file is no mesh, and what would be right.
#[derive(Debug)]
pub(super) struct Refusal {
    pub row: Option<usize>,
    pub problem: String,
    pub remedy: String,
}

impl Refusal {
    pub fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Refusal { row: None, problem: problem.into(), remedy: remedy.into() }
    }
}

impl Raw {
    /// Adds one polygon; what has fewer than three corners is no surface and is left out.
    pub fn polygon(&mut self, corners: impl IntoIterator<Item = u32>) {
        let from = self.corners.len();
        self.corners.extend(corners);
        if self.corners.len() < from + 3 {
            self.corners.truncate(from);
        } else {
            self.ends.push(self.corners.len());
        }
    }

    /// The polygons, each by its corners.
    pub fn polygons(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(from, &to)| &self.corners[from..to])
    }
}
