//! Responses over the design; knows nothing of curves or cloth.

pub mod anova;
pub mod box_cox;
pub mod box_wilson;
pub mod desirability;
pub mod distribution;
pub mod effects;
pub mod factorial;
pub mod family;
pub mod incomplete_beta;
pub mod known_errors;
pub mod lenth;
pub mod linear_model;
pub mod next_runs;
pub mod permutation;
pub mod power;
pub mod residuals;
pub mod steepest_ascent;
pub mod sums_of_squares;
pub mod variances;
