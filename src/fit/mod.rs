//! Inverse: profile → parameters, by orthogonal least squares.

mod base;
pub mod bias;
pub mod bootstrap;
pub mod circle;
mod crossings;
mod eight_places;
mod estimating;
pub mod even;
pub mod fold_table;
pub mod folds;
pub mod foot_point;
mod frame;
pub mod free_outline;
pub mod intervals;
pub mod lambda;
pub mod limits;
pub mod matching;
mod mended;
pub mod orthogonal;
pub mod outcome;
pub mod outline;
pub mod profile_likelihood;
mod robust;
pub mod rules;
mod sampling;
mod sane_curve;
mod series;
pub mod start;
pub mod surface;
mod swift;
pub mod tangent_curve;
pub mod tangent_family;
pub mod tangent_fit;
mod trial;
pub mod uncertainty;

pub use bias::BiasCorrection;
pub use folds::{Options, fit};
pub use intervals::Intervals;

/// Akaike's criterion of `unknowns` parameters and a variance fitted to n points, corrected for few of them (Hurvich & Tsai, Biometrika 76 (1989)
/// 297–307); infinite where so few are left that it has no value.
pub fn aicc(sum_of_squares: f64, n: usize, unknowns: usize) -> f64 {
    akaike(sum_of_squares / n as f64, n as f64, unknowns as f64 + 1.0)
}

/// The same by the mean square that `parameters` parameters, the variance among them, leave of `values` values.
fn akaike(mean_square: f64, values: f64, parameters: f64) -> f64 {
    let spare = values - parameters - 1.0;
    if spare <= 0.0 {
        return f64::INFINITY;
    }
    values * mean_square.max(f64::MIN_POSITIVE).ln() + 2.0 * parameters + 2.0 * parameters * (parameters + 1.0) / spare
}

/// The middle value, the upper of two; of one value at least.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
pub use limits::Limits;
pub use outcome::{Candidate, Estimate, HeldLength, HemFit, RobustOutcome, Rule, Termination};

// The words in which a fit is asked, for those who may not look into the numerics.
pub use crate::numerics::least_squares::{Limit, Loss};
