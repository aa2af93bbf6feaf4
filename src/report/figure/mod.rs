//! Results → vector figures (SVG). Drawing geometry only: every number that is shown was computed elsewhere.

pub mod agreement;
pub mod contour;
pub mod asked;
pub mod cube;
pub mod distance;
pub mod drawing;
pub mod fidelities;
pub mod folds;
pub mod gap;
pub mod half_normal;
pub mod heat_map;
pub mod hem;
pub mod interactions;
pub mod lambda;
pub mod main_effects;
pub mod multiples;
pub mod paper_cone;
pub mod paper_curve;
pub mod paper_element;
pub mod paper_projection;
pub mod paper_shell;
pub mod pareto;
pub mod pattern;
pub mod polar;
pub mod replicates;
pub mod residuals;
pub mod run_axes;
pub mod rigidity;
pub mod sheet;
pub mod space;
pub mod surface;
pub mod symbols;
pub mod term_map;
pub mod uneven;
pub mod work_precision;

#[cfg(test)]
mod tests;
