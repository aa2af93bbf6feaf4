//! How sure the estimates of one fit are, and where there is no error bar, why.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::bias::BiasCorrection;
use super::estimating::{Linearized, Unknowns, linearize};
use super::outcome::Termination;
use crate::experiment::Point;
use crate::model::hem::{Hem, Placement};
use crate::numerics::least_squares::State;

/// Ratio of singular values, columns of unit length, beyond which a combination of unknowns is not determined: no digit of it is left.
const DEPENDENT: f64 = 1e-8;
/// Share of an undetermined direction (unit columns) above which an unknown is part of it.
const INVOLVED: f64 = 1e-4;
/// Level of the test for folds at all: an amplitude that noise alone exceeds more often than this is not told from none.
const NO_FOLDS_LEVEL: f64 = 0.05;

/// What a fit estimates, in the order of the unknowns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unknown {
    X0,
    Y0,
    Phase,
    P,
    Q,
    S,
}

impl Unknown {
    /// In the order in which matrices have them.
    pub const ALL: [Unknown; 6] = [Unknown::X0, Unknown::Y0, Unknown::Phase, Unknown::P, Unknown::Q, Unknown::S];

    /// As tables name it.
    pub fn name(self) -> &'static str {
        super::orthogonal::UNKNOWNS[self as usize]
    }
}

/// Why an estimate has no error bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WhyMissing {
    /// The hem is round: q, s, m and the phase do not exist.
    NoFolds,
    /// The fold amplitude is not told from zero at the 5 % level, so neither q nor the phase and s that hang on it have an error that
    /// means anything.
    FoldsWithinNoise,
    /// The points do not tell this unknown from a combination of others.
    NotDetermined,
    /// The curve was matched in order; it is no minimum, and errors are those of a minimum.
    InOrder,
    /// The iteration ended before a minimum.
    NotConverged,
    /// It was held at a value, as asked.
    Held,
    /// It rests at a bound that was set for it.
    AtBound,
    /// Of intervals only: likelihoods and bootstraps are those of points that count alike.
    Weighted,
}

impl WhyMissing {
    /// As tables name it.
    pub fn name(self) -> &'static str {
        match self {
            WhyMissing::NoFolds => "no_folds",
            WhyMissing::FoldsWithinNoise => "folds_within_noise",
            WhyMissing::NotDetermined => "not_determined",
            WhyMissing::InOrder => "in_order",
            WhyMissing::NotConverged => "not_converged",
            WhyMissing::Held => "held",
            WhyMissing::AtBound => "at_bound",
            WhyMissing::Weighted => "weighted",
        }
    }

    /// In words.
    pub fn reason(self) -> &'static str {
        match self {
            WhyMissing::NoFolds => "no standard errors of q, s and phase: the outline is round",
            WhyMissing::FoldsWithinNoise => {
                "no standard errors of q, s and phase: the fold amplitude is not told from zero at the 5 % level"
            }
            WhyMissing::NotDetermined => "no standard errors: the points do not tell the unknowns apart",
            WhyMissing::InOrder => "no standard errors: the curve was matched in order, not fitted by orthogonal distance",
            WhyMissing::NotConverged => "no standard errors: the iteration ended before a minimum",
            WhyMissing::Held => "no standard error of what was held, as asked",
            WhyMissing::AtBound => "no standard error of what rests at its bound",
            WhyMissing::Weighted => "no such intervals where points have weights of their own",
        }
    }
}

/// An estimate without an error bar, and the reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct MissingError {
    pub unknown: Unknown,
    pub why: WhyMissing,
}

/// Standard errors and covariance of (x0, y0, phase, p, q, s).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Uncertainty {
    pub standard_errors: [Option<f64>; 6],
    /// Only where all six have a standard error.
    pub covariance: Option<[[f64; 6]; 6]>,
    pub missing: Vec<MissingError>,
    pub degrees_of_freedom: usize,
}

/// The fit whose uncertainty is asked, in canonical form.
pub(super) struct Fitted<'a> {
    pub points: &'a [Point],
    /// Weight of each point, of mean 1; empty where all are alike.
    pub weights: &'a [f64],
    pub hem: Hem,
    pub placement: Placement,
    pub feet: &'a [f64],
    /// What became of each unknown.
    pub states: &'a [State; 6],
    /// Whether the perimeter was held.
    pub held: bool,
    pub termination: &'a Termination,
    pub correction: &'a BiasCorrection,
    /// What a fit of all six unknowns has computed of it already.
    pub known: Option<Known>,
}

/// The Jacobian of a free fit of determined unknowns, condensed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known {
    /// (JᵀJ)⁻¹.
    pub inverse: [[f64; 6]; 6],
    /// Sum of squared distances less their mean shift, m².
    pub square: f64,
}

impl Known {
    /// The same for −q.
    pub fn turned(self) -> Known {
        let inverse =
            std::array::from_fn(|i| std::array::from_fn(|j| if (i == 4) != (j == 4) { -self.inverse[i][j] } else { self.inverse[i][j] }));
        Known { inverse, ..self }
    }
}

/// `σ̂²(JᵀJ)⁻¹`, in the null space of a held perimeter; σ̂² = Σe²/(n − unknowns), e the distances less their mean shift.
pub(super) fn uncertainty(fit: &Fitted) -> Uncertainty {
    let round = fit.hem.folds == 0;
    let exists = [true, true, !round, true, !round, !round];
    let free: [bool; 6] = std::array::from_fn(|j| exists[j] && fit.states[j] == State::Free);
    let unknowns = free.iter().filter(|free| **free).count();
    let degrees_of_freedom = (fit.points.len() + usize::from(fit.held)).saturating_sub(unknowns);
    let nothing = |why: WhyMissing| Uncertainty {
        standard_errors: [None; 6],
        covariance: None,
        missing: Unknown::ALL.map(|unknown| MissingError { unknown, why }).to_vec(),
        degrees_of_freedom,
    };
    match fit.termination {
        Termination::InOrder { .. } | Termination::NotPursued => return nothing(WhyMissing::InOrder),
        Termination::Stalled | Termination::EvaluationLimit => return nothing(WhyMissing::NotConverged),
        _ => (),
    }
    if degrees_of_freedom == 0 {
        return nothing(WhyMissing::NotDetermined);
    }
    if let Some(Known { inverse, square }) = fit.known {
        let variance = square / degrees_of_freedom as f64;
        let inverse = DMatrix::from_fn(6, 6, |i, j| inverse[i][j]);
        return judged(fit, variance, &Whitened { inverse, determined: [true; 6] }, degrees_of_freedom);
    }
    let unknowns: Unknowns = [fit.placement.x0, fit.placement.y0, fit.placement.phase, fit.hem.p, fit.hem.q, fit.hem.s];
    let Some(mut at) = linearize(fit.points, &unknowns, fit.hem.folds, fit.feet) else {
        return nothing(WhyMissing::NotDetermined);
    };
    let mut residuals = residuals(&at, fit.correction);
    for (i, weight) in fit.weights.iter().enumerate() {
        residuals[i] *= weight.sqrt();
        at.rows[i].iter_mut().for_each(|entry| *entry *= weight.sqrt());
    }
    let variance = residuals.iter().map(|e| e * e).sum::<f64>() / degrees_of_freedom as f64;
    let length = fit.held.then(|| fit.hem.perimeter_gradient().1);
    judged(fit, variance, &Whitened::of(&at, &free, length), degrees_of_freedom)
}

/// Standard errors where they mean something, and the reason where they do not.
fn judged(fit: &Fitted, variance: f64, whitened: &Whitened, degrees_of_freedom: usize) -> Uncertainty {
    let Whitened { inverse, determined } = whitened;
    let round = fit.hem.folds == 0;
    let mut standard_errors: [Option<f64>; 6] =
        std::array::from_fn(|j| determined[j].then(|| (variance * inverse[(j, j)]).max(0.0).sqrt()));
    let mut why: [Option<WhyMissing>; 6] = std::array::from_fn(|j| (!determined[j]).then_some(WhyMissing::NotDetermined));
    if round {
        [2, 4, 5].into_iter().for_each(|j| why[j] = Some(WhyMissing::NoFolds));
    } else if fit.states[4] == State::Free && standard_errors[4].is_none_or(|error| within_noise(fit.hem.q, error, degrees_of_freedom)) {
        [2, 4, 5].into_iter().for_each(|j| why[j] = Some(WhyMissing::FoldsWithinNoise));
    }
    for (why, state) in why.iter_mut().zip(fit.states) {
        match state {
            State::Free => (),
            State::Fixed => *why = Some(WhyMissing::Held),
            State::AtLower | State::AtUpper => *why = Some(WhyMissing::AtBound),
        }
    }
    (0..6).filter(|&j| why[j].is_some()).for_each(|j| standard_errors[j] = None);
    let whole = standard_errors.iter().all(Option::is_some);
    Uncertainty {
        standard_errors,
        covariance: whole.then(|| std::array::from_fn(|i| std::array::from_fn(|j| variance * inverse[(i, j)]))),
        missing: (0..6).filter_map(|j| Some(MissingError { unknown: Unknown::ALL[j], why: why[j]? })).collect(),
        degrees_of_freedom,
    }
}

/// Distances less what curvature has shifted their mean by, m.
pub(super) fn residuals(at: &Linearized, correction: &BiasCorrection) -> Vec<f64> {
    let half_variance = correction.applied().map_or(0.0, |c| 0.5 * c.sigma * c.sigma);
    at.distances.iter().zip(&at.curvatures).map(|(d, kappa)| d - half_variance * kappa).collect()
}

/// Whether noise alone would make an amplitude as large more often than [`NO_FOLDS_LEVEL`].
///
/// Amplitude and phase are a vector of two components with the same error where there are no folds; its squared length over twice that error
/// squared follows F(2, ν), whose upper quantile has the closed form `(ν/2)(α^{−2/ν} − 1)`.
fn within_noise(amplitude: f64, error: f64, degrees_of_freedom: usize) -> bool {
    let nu = degrees_of_freedom as f64;
    // As a difference of logarithms, so that many degrees of freedom keep their digits.
    let quantile = 0.5 * nu * (-2.0 / nu * NO_FOLDS_LEVEL.ln()).exp_m1();
    amplitude * amplitude < 2.0 * quantile * error * error
}

/// (JᵀJ)⁻¹ over the unknowns that may move and are determined, in the null space of the perimeter's gradient if that is held.
pub(super) struct Whitened {
    pub inverse: DMatrix<f64>,
    /// Which unknowns the points determine.
    pub determined: [bool; 6],
}

impl Whitened {
    /// From the rows of the Jacobian; `length` is the perimeter's gradient by p, q, s, if that is held.
    pub fn of(at: &Linearized, free: &[bool; 6], length: Option<[f64; 3]>) -> Self {
        let index: Vec<usize> = (0..6).filter(|&j| free[j]).collect();
        let columns = index.len();
        let norm = |j: usize| at.rows.iter().map(|row| row[j] * row[j]).sum::<f64>().sqrt();
        let unit: Vec<f64> = index.iter().map(|&j| norm(j)).map(|norm| if 0.0 < norm { norm } else { 1.0 }).collect();
        let scaled = DMatrix::from_fn(at.rows.len(), columns, |i, k| at.rows[i][index[k]] / unit[k]);
        let basis = match length {
            Some(by) => null_space(&DVector::from_fn(columns, |k, _| if 3 <= index[k] { by[index[k] - 3] / unit[k] } else { 0.0 })),
            None => DMatrix::identity(columns, columns),
        };
        let svd = (scaled.qr().r() * &basis).svd(false, true);
        let directions = &basis * svd.v_t.expect("asked for").transpose();
        let largest = svd.singular_values.max();
        let mut inverse = DMatrix::zeros(6, 6);
        let mut determined = *free;
        for (direction, &singular) in directions.column_iter().zip(svd.singular_values.iter()) {
            if largest * DEPENDENT < singular {
                for (k, &i) in index.iter().enumerate() {
                    for (l, &j) in index.iter().enumerate() {
                        inverse[(i, j)] += direction[k] * direction[l] / (singular * singular * unit[k] * unit[l]);
                    }
                }
            } else {
                index.iter().enumerate().filter(|(k, _)| INVOLVED < direction[*k].abs()).for_each(|(_, &j)| determined[j] = false);
            }
        }
        Whitened { inverse, determined }
    }

    /// (JᵀJ)⁻¹ times a row.
    pub fn solve(&self, row: &Unknowns) -> Unknowns {
        std::array::from_fn(|i| (0..6).map(|j| self.inverse[(i, j)] * row[j]).sum())
    }

    /// What a point of this row has of its own fitted value, 0…1.
    pub fn leverage(&self, row: &Unknowns) -> f64 {
        self.solve(row).iter().zip(row).map(|(a, b)| a * b).sum()
    }
}

/// Orthonormal basis of the vectors normal to `normal`: the Householder reflection that takes it to an axis, without that axis.
fn null_space(normal: &DVector<f64>) -> DMatrix<f64> {
    let n = normal.len();
    let axis = normal.iamax();
    let mut mirror = normal.clone();
    mirror[axis] += normal.norm().copysign(normal[axis]);
    let reflection = DMatrix::identity(n, n) - (2.0 / mirror.norm_squared()) * &mirror * mirror.transpose();
    reflection.remove_column(axis)
}

/// Correlations from covariances; a variable of no variance is uncorrelated with the others.
pub(super) fn correlation(covariance: &[[f64; 6]; 6]) -> [[f64; 6]; 6] {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let scale = (covariance[i][i] * covariance[j][j]).sqrt();
            if i == j {
                1.0
            } else if 0.0 < scale {
                (covariance[i][j] / scale).clamp(-1.0, 1.0)
            } else {
                0.0
            }
        })
    })
}
