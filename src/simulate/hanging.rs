//! What a shape under several terms reports: the energy of each, and the walls it leans on.

use super::{Contact, TermEnergy};
use crate::experiment::scene::Term;
use crate::model::energy::{Gaps, Ledger, Terms};

/// `energy` made larger by this share of its size. Cloth that stretches can hang below its own length, and its energy is then negative.
pub(super) fn above(energy: f64, share: f64) -> f64 {
    if energy < 0.0 { energy * (1.0 - share) } else { energy * (1.0 + share) }
}

/// `energy` made smaller by this share of its size.
pub(super) fn below(energy: f64, share: f64) -> f64 {
    if energy < 0.0 { energy * (1.0 + share) } else { energy * (1.0 - share) }
}

/// The terms that are in, in their order. `all` evaluations were made of the whole; `counts` of each term.
pub(super) fn energies(ledger: &Ledger, terms: &Terms, all: usize, counts: &[usize; 7]) -> Vec<TermEnergy> {
    let count = |term: Term| if terms.beyond_usual() { counts[term as usize] } else { all };
    let one = |term: Term| TermEnergy { term: term.name(), energy: ledger.of(term), evaluations: count(term) };
    terms.set().iter().map(one).collect()
}

/// The walls that are in.
pub(super) fn contacts(terms: &Terms, gaps: &Gaps) -> Vec<Contact> {
    let walls = [
        (Term::BodyContact, terms.body.map(|b| b.barrier()), gaps.body),
        (Term::SelfContact, terms.folds.map(|f| f.barrier()), gaps.folds),
    ];
    let one = |(term, barrier, gap): (Term, Option<_>, Option<f64>)| {
        let barrier: crate::model::energy::barrier::Barrier = barrier?;
        Some(Contact { term: term.name(), stiffness: barrier.stiffness, reach: barrier.reach, smallest_gap: gap })
    };
    walls.into_iter().filter_map(one).collect()
}
