//! Energy terms of the ruled shell: one term, one file; each a local density that several hem families share.
//!
//! In the ruled shell every generatrix stays straight and inextensible. With the material angle σ, the hem `c(σ)` and `d = c − R_t e^{iσ}`, the
//! ring at fraction u of the slant is `x = R_t e^{iσ} + u d`, at depth `u √(L² − |d|²)`. Source: docs/model.md, section 5.

pub mod bending;
pub mod gravity;
