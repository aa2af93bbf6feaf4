//! Energy terms: one term, one file; each a local density that several families of shapes share.
//!
//! In the ruled shell every generatrix stays straight and inextensible. With the material angle σ, the hem `c(σ)` and `d = c − R_t e^{iσ}`, the
//! ring at fraction u of the slant is `x = R_t e^{iσ} + u d`, at depth `u √(L² − |d|²)`. Sources: docs/model.md, section 5, and docs/terms.md.

pub mod barrier;
pub mod bending;
pub mod body_contact;
pub mod foundation;
pub mod gravity;
pub mod self_contact;
pub mod shear;
pub mod stretch;

use body_contact::BodyContact;
use foundation::Foundation;
use self_contact::SelfContact;
use shear::Shear;
use stretch::Stretch;

use crate::experiment::scene::{Term, TermSet};
use crate::numerics::jet::Jet;

/// What is in, and with which stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Terms {
    /// ρ_A g, N/m².
    pub gravity: Option<f64>,
    /// B, N·m.
    pub bending: Option<f64>,
    pub foundation: Option<Foundation>,
    pub shear: Option<Shear>,
    pub stretch: Option<Stretch>,
    pub body: Option<BodyContact>,
    pub folds: Option<SelfContact>,
}

impl Terms {
    /// Weight ρ_A g (N/m²) and rigidity B (N·m), nothing else.
    pub fn usual(weight: f64, rigidity: f64) -> Self {
        Terms { gravity: Some(weight), bending: Some(rigidity), ..Terms::default() }
    }

    pub fn set(&self) -> TermSet {
        let there = [
            self.gravity.is_some(),
            self.bending.is_some(),
            self.foundation.is_some(),
            self.shear.is_some(),
            self.stretch.is_some(),
            self.body.is_some(),
            self.folds.is_some(),
        ];
        Term::ALL.into_iter().zip(there).filter(|(_, there)| *there).map(|(term, _)| term).collect()
    }

    /// Those of `set` only.
    pub fn only(&self, set: TermSet) -> Self {
        Terms {
            gravity: self.gravity.filter(|_| set.contains(Term::Gravity)),
            bending: self.bending.filter(|_| set.contains(Term::Bending)),
            foundation: self.foundation.filter(|_| set.contains(Term::Foundation)),
            shear: self.shear.filter(|_| set.contains(Term::Shear)),
            stretch: self.stretch.filter(|_| set.contains(Term::Stretch)),
            body: self.body.filter(|_| set.contains(Term::BodyContact)),
            folds: self.folds.filter(|_| set.contains(Term::SelfContact)),
        }
    }

    /// Whether anything beyond weight and rigidity is in.
    pub fn beyond_usual(&self) -> bool {
        self.set().without(Term::Gravity).without(Term::Bending) != TermSet::none()
    }

    /// Whether a term is in that depends on where the cloth is.
    pub(super) fn placed(&self) -> bool {
        self.foundation.is_some() || self.body.is_some() || self.folds.is_some()
    }

    /// Energy of the terms that depend on where the cloth is, J, at one point of weight `spot.area`; adds to `ledger`.
    ///
    /// `None` inside a body or another fold.
    pub(super) fn placed_density<const N: usize>(&self, spot: &Spot, at: [Jet<N>; 3], ledger: &mut Ledger) -> Option<Jet<N>> {
        let [x, y, z] = at;
        let mut sum = Jet::constant(0.0);
        let mut add = |term: Term, density: Jet<N>| {
            ledger.add(term, spot.area * density.value);
            sum = sum + density * spot.area;
        };
        if let Some(foundation) = &self.foundation {
            add(Term::Foundation, foundation.density(x, y)?);
        }
        if let Some(body) = &self.body {
            add(Term::BodyContact, body.density(x, y, z)?.unwrap_or(Jet::constant(0.0)));
        }
        if let Some(folds) = &self.folds {
            add(Term::SelfContact, folds.density(spot.folds, spot.sigma, spot.ring, x, y)?.unwrap_or(Jet::constant(0.0)));
        }
        Some(sum)
    }
}

/// A point of cloth.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    pub folds: u32,
    /// Material angle from the crest.
    pub sigma: f64,
    /// Radius of its ring as it was cut, m.
    pub ring: f64,
    /// Area of cloth that it stands for, m².
    pub area: f64,
}

/// Energy of each term, J, and whether its density was asked for at all; in the order of [`Term::ALL`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ledger {
    pub energy: [f64; 7],
    pub asked: [bool; 7],
}

impl Ledger {
    pub(super) fn add(&mut self, term: Term, energy: f64) {
        self.energy[term as usize] += energy;
        self.asked[term as usize] = true;
    }

    /// Counts one evaluation of every term that was asked for.
    pub(super) fn count(&self, counts: &mut [usize; 7]) {
        self.asked.iter().zip(counts).filter(|(asked, _)| **asked).for_each(|(_, count)| *count += 1);
    }

    pub fn of(&self, term: Term) -> f64 {
        self.energy[term as usize]
    }

    pub fn total(&self) -> f64 {
        self.energy.iter().sum()
    }
}

/// Smallest distances, m; `None` where there is no wall.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Gaps {
    /// To the body.
    pub body: Option<f64>,
    /// Between the faces of neighbouring flanks.
    pub folds: Option<f64>,
}

impl Gaps {
    /// Whether cloth is inside the body or another fold somewhere.
    pub fn closed(&self) -> bool {
        [self.body, self.folds].into_iter().flatten().any(|gap| gap <= 0.0)
    }

    pub(super) fn see(&mut self, terms: &Terms, spot: &Spot, [x, y, z]: [f64; 3]) {
        let least = |seen: Option<f64>, gap: f64| Some(seen.map_or(gap, |seen| seen.min(gap)));
        if let Some(body) = &terms.body {
            self.body = least(self.body, body.gap_at(x, y, z));
        }
        if let Some(gap) = terms.folds.as_ref().and_then(|folds| folds.gap_at(spot.folds, spot.sigma, spot.ring, x, y)) {
            self.folds = least(self.folds, gap);
        }
    }
}
