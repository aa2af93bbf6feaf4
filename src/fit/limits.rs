//! Which of the curve's unknowns are held or bounded.

use serde::Serialize;

use crate::error::Error;
use crate::numerics::least_squares::Limit;

/// What each unknown of the hem curve may do; metres, the phase in rad. All free by default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Limits {
    pub x0: Limit,
    pub y0: Limit,
    /// Direction of a crest. With a limited phase, q or s the curve is reported as it was fitted, not in canonical form: q may be negative.
    pub phase: Limit,
    pub p: Limit,
    pub q: Limit,
    pub s: Limit,
}

impl Limits {
    /// In the order of [`UNKNOWNS`](super::orthogonal::UNKNOWNS).
    pub fn in_order(&self) -> [Limit; 6] {
        [self.x0, self.y0, self.phase, self.p, self.q, self.s]
    }

    /// The limit of the unknown of this name.
    pub fn of(&mut self, name: &str) -> Option<&mut Limit> {
        match name {
            "x0" => Some(&mut self.x0),
            "y0" => Some(&mut self.y0),
            "phase" => Some(&mut self.phase),
            "p" => Some(&mut self.p),
            "q" => Some(&mut self.q),
            "s" => Some(&mut self.s),
            _ => None,
        }
    }

    pub fn none(&self) -> bool {
        *self == Limits::default()
    }

    /// Whether p, q and s are all held, so that no length can be.
    pub(super) fn shape_is_held(&self) -> bool {
        [self.p, self.q, self.s].iter().all(|limit| matches!(limit, Limit::At(_)))
    }

    /// Whether a curve may be turned or mirrored into its canonical form without leaving the limits.
    pub(super) fn allow_canonical_form(&self) -> bool {
        [self.phase, self.q, self.s] == [Limit::Free; 3]
    }

    /// # Errors
    /// [`Error::Unanswerable`] if a limit allows no number, or p none above zero.
    pub fn check(&self) -> Result<(), Error> {
        for (name, limit) in super::orthogonal::UNKNOWNS.iter().zip(self.in_order()) {
            limit.check(name)?;
        }
        if self.p.range().1 <= 0.0 {
            return Err(Error::Unanswerable("p is held at or below zero; the mean radius of a hem is positive".into()));
        }
        Ok(())
    }
}
