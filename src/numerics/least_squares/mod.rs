//! Nonlinear least squares, open to any residual function: Levenberg–Marquardt with limits, weights, robust losses and one equality constraint.
//!
//! Problem, options, summary and covariance are four things. The step comes from a QR decomposition of the Jacobian with its columns
//! scaled to unit length, never from normal equations; the damping follows the gain ratio (Nielsen, Damping Parameter in Marquardt's
//! Method, IMM-REP-1999-05, DTU). An equality constraint `h(x) = 0` is met in its null space, with an ℓ1 merit function; a parameter that
//! comes to its bound stops there, and the step of the others is found anew.
//!
//! # Your own model
//!
//! Residuals as a closure are enough; derivatives are then taken numerically. Misra's dental monomer data (NIST StRD, Misra1a),
//! `y = b1 (1 − exp(−b2 x))`:
//!
//! ```
//! use hemline::numerics::least_squares::{self, FitOptions};
//!
//! let x = [77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0];
//! let y = [10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78];
//! let residuals = |b: &[f64], r: &mut [f64]| {
//!     for i in 0..x.len() {
//!         r[i] = b[0] * (1.0 - (-b[1] * x[i]).exp()) - y[i];
//!     }
//! };
//! let options = FitOptions { observed: y.to_vec(), ..FitOptions::default() };
//! let fit = least_squares::fit(residuals, x.len(), &[500.0, 1e-4], &options)?;
//! println!("{fit}");
//! assert!(fit.termination.converged());
//! // Certified: 2.3894212918E+02 ± 2.7070075241E+00 and 5.5015643181E-04 ± 7.2668688436E-06.
//! assert!((fit.parameters[0].value / 2.3894212918e2 - 1.0).abs() < 1e-9);
//! assert!((fit.parameters[1].standard_error.unwrap() / 7.2668688436e-6 - 1.0).abs() < 1e-7);
//! assert!(fit.r_squared.unwrap() > 0.9999);
//! # Ok::<(), hemline::Error>(())
//! ```
//!
//! With derivatives: [`fit_with_jacobian`]. With state between evaluations, a constraint or a reason to give up: [`Problem`] and [`solve`]
//! (with [`Options::thorough`] where nothing is known of the start).
//! Bounds, fixed parameters, weights and robust losses are fields of [`FitOptions`]:
//!
//! ```
//! use hemline::numerics::least_squares::{self, FitOptions, Limit, Loss, State};
//!
//! // A line with one gross error; its intercept must not be negative.
//! let y = [0.1, 0.9, 2.1, 2.9, 40.0, 5.1, 5.9, 7.1, 7.9, 9.1];
//! let residuals = |b: &[f64], r: &mut [f64]| (0..y.len()).for_each(|i| r[i] = b[0] + b[1] * i as f64 - y[i]);
//! let options = FitOptions {
//!     names: vec!["intercept".into(), "slope".into()],
//!     limits: vec![Limit::Between(0.1, f64::INFINITY), Limit::Free],
//!     loss: Loss::TUKEY,
//!     ..FitOptions::default()
//! };
//! let fit = least_squares::fit(residuals, y.len(), &[1.0, 0.0], &options)?;
//! assert_eq!((fit.parameters[0].value, fit.parameters[0].state), (0.1, State::AtLower));
//! assert!((fit.parameters[1].value - 1.0).abs() < 0.02 && fit.weights[4] == 0.0);
//! # Ok::<(), hemline::Error>(())
//! ```

mod closure;
mod covariance;
mod differences;
mod limits;
mod loss;
mod outcome;
mod problem;
mod reflections;
mod robust;
mod solve;
mod step;

pub use closure::{Fit, FitOptions, Parameter, fit, fit_with_jacobian};
pub use covariance::{Covariance, covariance};
pub use limits::{Limit, State};
pub use loss::{Loss, median_scale};
pub use outcome::{Options, Summary, Termination};
pub use problem::Problem;
pub use robust::{DOWNWEIGHTED, Robust, Round, check_weights, solve_robust};
pub use solve::{solve, solve_within};

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// y = a exp(b x), with exact data.
    struct Exponential {
        x: Vec<f64>,
        y: Vec<f64>,
        sum_held_at: Option<f64>,
    }

    impl Problem for Exponential {
        fn residual_count(&self) -> usize {
            self.x.len()
        }
        fn residuals(&mut self, p: &[f64], residuals: &mut [f64]) -> bool {
            for (i, r) in residuals.iter_mut().enumerate() {
                *r = p[0] * (p[1] * self.x[i]).exp() - self.y[i];
            }
            true
        }
        fn jacobian(&mut self, p: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
            for (i, &x) in self.x.iter().enumerate() {
                jacobian[(i, 0)] = (p[1] * x).exp();
                jacobian[(i, 1)] = p[0] * x * (p[1] * x).exp();
            }
            true
        }
        fn constraint(&mut self, p: &[f64]) -> Option<(f64, DVector<f64>)> {
            self.sum_held_at.map(|sum| (p[0] + p[1] * p[1] - sum, DVector::from_vec(vec![1.0, 2.0 * p[1]])))
        }
    }

    fn exponential(noise: f64, sum_held_at: Option<f64>) -> Exponential {
        let x: Vec<f64> = (0..20).map(|i| 0.1 * f64::from(i)).collect();
        let y = x.iter().enumerate().map(|(i, x)| 2.0 * (-1.3 * x).exp() + if i % 2 == 0 { noise } else { -noise }).collect();
        Exponential { x, y, sum_held_at }
    }

    #[test]
    fn exact_data_give_the_parameters_to_rounding() {
        let summary = solve(&mut exponential(0.0, None), &[1.0, 0.0], &Options::default()).unwrap();
        assert!(summary.termination.converged(), "{:?}", summary.termination);
        // Rounding of y, 2e-16, times the condition of the problem, about 10.
        assert!((summary.parameters[0] - 2.0).abs() < 1e-13 && (summary.parameters[1] + 1.3).abs() < 1e-13);
    }

    #[test]
    fn the_gradient_vanishes_at_the_end() {
        let summary = solve(&mut exponential(0.1, None), &[1.0, 0.0], &Options::default()).unwrap();
        let gradient = summary.jacobian.transpose() * DVector::from_vec(summary.residuals.clone());
        // The asked cosine, 1e-10, times the norms involved, about 3 and 0.5.
        assert!(summary.termination.converged() && gradient.amax() < 1e-9);
    }

    #[test]
    fn a_held_value_is_met_exactly_and_its_multiplier_is_the_slope_of_the_cost() {
        let held = |sum: f64| solve(&mut exponential(0.1, Some(sum)), &[1.0, -0.5], &Options::default()).unwrap();
        let (middle, low, high) = (held(3.0), held(3.0 - 1e-4), held(3.0 + 1e-4));
        assert!(middle.termination.converged(), "{:?}", middle.termination);
        let [a, b] = middle.parameters[..] else { unreachable!() };
        assert!((a + b * b - 3.0).abs() < 1e-12);
        let slope = 0.5 * (high.sum_of_squares - low.sum_of_squares) / 2e-4;
        // Central difference of a smooth function: h² times its third derivative.
        assert!((middle.multiplier.unwrap() - slope).abs() < 1e-6, "{:?} {slope}", middle.multiplier);
    }

    #[test]
    fn parameters_that_the_data_do_not_tell_apart_have_no_covariance_and_are_named() {
        struct Sum;
        impl Problem for Sum {
            fn residual_count(&self) -> usize {
                5
            }
            fn residuals(&mut self, p: &[f64], residuals: &mut [f64]) -> bool {
                for (i, r) in residuals.iter_mut().enumerate() {
                    *r = p[0] + p[1] + p[2] * i as f64 - if i == 2 { 1.0 } else { 0.0 };
                }
                true
            }
            fn jacobian(&mut self, _p: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
                for i in 0..5 {
                    jacobian.row_mut(i).copy_from_slice(&[1.0, 1.0, i as f64]);
                }
                true
            }
        }
        let summary = solve(&mut Sum, &[0.3, 0.1, 0.0], &Options::default()).unwrap();
        let message = covariance(&summary, &["level", "offset", "slope"]).unwrap_err().to_string();
        assert!(message.contains("level") && message.contains("offset") && !message.contains("slope"), "{message}");
    }

    #[test]
    fn covariance_of_a_straight_line_is_the_textbook_one() {
        struct Line(Vec<f64>);
        impl Problem for Line {
            fn residual_count(&self) -> usize {
                self.0.len()
            }
            fn residuals(&mut self, p: &[f64], residuals: &mut [f64]) -> bool {
                for (i, r) in residuals.iter_mut().enumerate() {
                    *r = p[0] + p[1] * i as f64 - self.0[i];
                }
                true
            }
            fn jacobian(&mut self, _p: &[f64], jacobian: &mut DMatrix<f64>) -> bool {
                for i in 0..self.0.len() {
                    jacobian.row_mut(i).copy_from_slice(&[1.0, i as f64]);
                }
                true
            }
        }
        let summary = solve(&mut Line(vec![1.0, 2.5, 2.0, 4.5, 4.0]), &[0.0, 0.0], &Options::default()).unwrap();
        let covariance = covariance(&summary, &["level", "slope"]).unwrap();
        // Σ(x − x̄)² = 10, Σx² = 30, n = 5.
        let variance = summary.sum_of_squares / 3.0;
        assert!((covariance.matrix[(1, 1)] - variance / 10.0).abs() < 1e-14);
        assert!((covariance.matrix[(0, 0)] - variance * 30.0 / 50.0).abs() < 1e-14);
    }
}
