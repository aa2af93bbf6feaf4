//! The fit of the paper's surface (18): p, q and s linear in height, one fold count, one phase, one straight axis for all heights.
//!
//! Distances are horizontal: each measured point is held against the curve at its own height, along that curve's normal.

mod joint;
mod lines;

use nalgebra::DMatrix;
use serde::Serialize;

use self::joint::{distances, foot, joint};
use self::lines::{Lines, canonical, through_sections};
use super::folds::{self, Options};
use super::outcome::{Estimate, HemFit};
use crate::error::Error;
use crate::experiment::Point;
use crate::experiment::campaign::Folds;
use crate::experiment::surface::{MeasuredSurface, Section};
use crate::model::hem::{Hem, Placement};
use crate::numerics::least_squares::covariance;

/// Fewest sections: a straight line, and something to tell whether it is one.
pub const FEWEST_SECTIONS: usize = 3;
/// Points that are fitted at most; more of them repeat the same folds.
const MOST_POINTS: usize = 20_000;
/// A correlation of neighbours below this many of its own standard errors is none.
const SIGNIFICANT: f64 = 3.0;

/// Names of the unknowns, in order; a … are values at the mean height, b … slopes.
const UNKNOWNS: [&str; 11] = ["x", "y", "phase", "p", "q", "s", "x by height", "y by height", "p by height", "q by height", "s by height"];

/// A straight line over height: value at height zero, and slope.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Line {
    /// At z = 0, m.
    pub a: Estimate,
    /// Change with height, m/m.
    pub b: Estimate,
    /// Covariance of a and b, m; `None` where they have no standard error.
    pub covariance: Option<f64>,
}

impl Line {
    /// Value at height `z` (m) and its standard error, m.
    pub fn at(&self, z: f64) -> Estimate {
        let variance = |a: f64, b: f64, c: f64| (a * a + 2.0 * z * c + z * z * b * b).max(0.0).sqrt();
        let standard_error = match (self.a.standard_error, self.b.standard_error, self.covariance) {
            (Some(a), Some(b), Some(c)) => Some(variance(a, b, c)),
            _ => None,
        };
        Estimate { value: self.a.value + z * self.b.value, standard_error }
    }
}

/// How the surface was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// All points at once, by their distances.
    Joint,
    /// Straight lines through the estimates of the sections, weighted by their standard errors, because the joint fit is no sane surface.
    Sections { because: String },
}

/// One quantity of the sections against its straight line: how far from straight it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LackOfFit {
    /// Root mean square departure of the sections' own estimates from the fitted line, m.
    pub rms: f64,
    /// Largest departure in size, m, with its sign.
    pub largest: f64,
    /// Height at which that is, m.
    pub at: f64,
    /// Share of the variation of the estimates over height that the straight line explains; `None` where they do not vary.
    pub explained: Option<f64>,
}

/// One section, fitted alone with the surface's fold count.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SectionFit {
    /// m.
    pub height: f64,
    /// Its own fit, or why there is none.
    pub alone: Result<HemFit, String>,
    /// The surface's curve at this height.
    pub hem: Hem,
    pub placement: Placement,
    /// Root mean square distance of the section's points from the surface's curve, m.
    pub rms: f64,
}

/// The paper's surface (18), fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfaceFit {
    pub method: Method,
    pub folds: u32,
    /// p(z) = a1 + b1 z.
    pub p: Line,
    /// q(z) = a2 + b2 z; negative where the line, drawn on, leaves the folds.
    pub q: Line,
    /// s(z) = a3 + b3 z.
    pub s: Line,
    /// Direction of one crest, rad, in [0, 2π/m).
    pub phase: Estimate,
    /// The axis: its place at z = 0 (m) and its lean (m/m) in x and y.
    pub axis: [Line; 2],
    /// Heights between which points were fitted, m.
    pub range: [f64; 2],
    /// Signed distance of each point from the surface's curve at its height, m, positive outside; `(point, distance)`.
    pub distances: Vec<([f64; 3], f64)>,
    /// Root mean square distance, m.
    pub rms: f64,
    /// Correlation of the distances of neighbouring points; `None` where no neighbours are known.
    pub neighbour_correlation: Option<f64>,
    /// The factor by which standard errors were raised because neighbours are alike: 1 where they are independent.
    pub inflation: f64,
    pub sections: Vec<SectionFit>,
    /// Of p, q, s.
    pub lack_of_fit: [Option<LackOfFit>; 3],
    /// Residual vectors evaluated by the joint fits.
    pub evaluations: usize,
    /// What a reader of the numbers should know, in words.
    pub notes: Vec<String>,
}

impl SurfaceFit {
    /// The curve at height `z` (m) and where it lies.
    pub fn curve(&self, z: f64) -> (Hem, Placement) {
        let value = |line: &Line| line.a.value + z * line.b.value;
        let hem = Hem { p: value(&self.p), q: value(&self.q), s: value(&self.s), folds: self.folds };
        (hem, Placement { x0: value(&self.axis[0]), y0: value(&self.axis[1]), phase: self.phase.value })
    }
}

/// Fits the surface to measured points: a joint orthogonal fit for every fold count that a section votes for, the nearest of them.
///
/// Standard errors are `σ̂²(JᵀJ)⁻¹`, raised where the distances of neighbouring points are alike (an uneven fold, a smoothed scan): with a
/// correlation r of neighbours that falls off exponentially, n points are worth as much as n over the sum of all correlations with one.
///
/// # Errors
/// [`Error::Unanswerable`] with fewer than [`FEWEST_SECTIONS`] sections, if none of them shows folds, or if they lie at one height.
pub fn fit(measured: &MeasuredSurface, options: &Options) -> Result<SurfaceFit, Error> {
    let sections = &measured.sections;
    if sections.len() < FEWEST_SECTIONS {
        return Err(Error::Unanswerable(format!(
            "{} section(s) with a closed outline; the fit of the surface needs at least {FEWEST_SECTIONS}",
            sections.len()
        )));
    }
    let own: Vec<Result<HemFit, String>> = sections.iter().map(|s| folds::fit(&s.profile, options).map_err(|e| e.to_string())).collect();
    let mut votes: Vec<u32> = own.iter().filter_map(|f| f.as_ref().ok()?.folds).collect();
    votes.sort_unstable();
    votes.dedup();
    if votes.is_empty() {
        let reason = own.iter().find_map(|f| f.as_ref().err()).map_or("every section is round".into(), Clone::clone);
        return Err(Error::Unanswerable(format!("no section shows folds ({reason}): there is no surface of folds to fit")));
    }
    let mut trials: Vec<(f64, Trial)> = Vec::new();
    for m in votes {
        let alone: Vec<Result<HemFit, String>> = sections
            .iter()
            .zip(&own)
            .map(|(section, own)| match own {
                Ok(fit) if fit.folds == Some(m) => Ok(fit.clone()),
                _ => folds::fit(&section.profile, &Options { folds: Folds::Exactly(m), ..options.clone() }).map_err(|e| e.to_string()),
            })
            .collect();
        if let Some(trial) = Trial::of(m, measured, alone, options)? {
            trials.push((trial.rms(), trial));
        }
    }
    trials.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, trial)) = trials.into_iter().next() else {
        return Err(Error::Unanswerable("no fold count could be fitted to three sections or more".into()));
    };
    Ok(trial.outcome(measured, options))
}

/// One fold count, tried.
struct Trial {
    lines: Lines,
    method: Method,
    /// Covariance of the unknowns, not raised.
    covariance: Result<DMatrix<f64>, String>,
    points: Vec<usize>,
    distances: Vec<f64>,
    alone: Vec<Result<HemFit, String>>,
    evaluations: usize,
}

impl Trial {
    /// `None` if fewer than three sections can be fitted with this fold count.
    fn of(m: u32, measured: &MeasuredSurface, alone: Vec<Result<HemFit, String>>, options: &Options) -> Result<Option<Trial>, Error> {
        let Some((start, start_covariance)) = through_sections(m, &measured.sections, &alone) else { return Ok(None) };
        // Evenly over the list, which goes section by section.
        let stride = measured.points.len().div_ceil(MOST_POINTS).max(1);
        let points: Vec<usize> = (0..measured.points.len()).step_by(stride).collect();
        let places: Vec<[f64; 3]> = points.iter().map(|&i| measured.points[i]).collect();
        let mut evaluations = 0;
        let because = match joint(&start, &places, options, &mut evaluations)? {
            None => "the joint fit did not converge".into(),
            Some((lines, summary)) => match insane(&lines, &measured.sections) {
                Some(fault) => fault,
                None => {
                    let covariance = covariance(&summary, &UNKNOWNS).map(|c| c.matrix).map_err(|e| e.to_string());
                    let distances = summary.residuals;
                    return Ok(Some(Trial { lines, method: Method::Joint, covariance, points, distances, alone, evaluations }));
                }
            },
        };
        let (method, covariance) = (Method::Sections { because }, Ok(start_covariance));
        let distances = distances(&start, &places);
        Ok(Some(Trial { lines: start, method, covariance, points, distances, alone, evaluations }))
    }

    fn rms(&self) -> f64 {
        (self.distances.iter().map(|d| d * d).sum::<f64>() / self.distances.len().max(1) as f64).sqrt()
    }

    fn outcome(self, measured: &MeasuredSurface, options: &Options) -> SurfaceFit {
        let mut notes = Vec::new();
        let (correlation, inflation) = if self.method == Method::Joint {
            self.inflation(measured)
        } else {
            // The lines' own scatter about the sections' estimates is in their errors already.
            (self.correlation(measured), 1.0)
        };
        if 1.0 < inflation {
            notes.push(format!(
                "distances of neighbouring points are alike (correlation {:.2}): standard errors are {inflation:.1} times those of independent points",
                correlation.unwrap_or(0.0)
            ));
        }
        if let Method::Sections { because } = &self.method {
            notes.push(format!("lines through the sections' estimates instead of a joint fit: {because}"));
        }
        if let Err(reason) = &self.covariance {
            notes.push(format!("no standard errors: {reason}"));
        }
        let lines = canonical(self.lines);
        // q → −q turns its covariances with the others.
        let signs: [f64; 11] = std::array::from_fn(|i| if lines.values[i] == -self.lines.values[i] { -1.0 } else { 1.0 });
        let c = |i: usize, j: usize| self.covariance.as_ref().ok().map(|c| signs[i] * signs[j] * c[(i, j)] * inflation * inflation);
        let line = |value: usize, slope: usize| {
            let z = -lines.middle;
            let (v, b) = (lines.values[value], lines.values[slope]);
            let (vv, vb, bb) = (c(value, value), c(value, slope), c(slope, slope));
            let at_zero = vv.zip(vb).zip(bb).map(|((vv, vb), bb)| (vv + 2.0 * z * vb + z * z * bb).max(0.0).sqrt());
            Line {
                a: Estimate { value: v + z * b, standard_error: at_zero },
                b: Estimate { value: b, standard_error: bb.map(|x| x.max(0.0).sqrt()) },
                covariance: vb.zip(bb).map(|(vb, bb)| vb + z * bb),
            }
        };
        let (p, q, s) = (line(3, 8), line(4, 9), line(5, 10));
        let axis = [line(0, 6), line(1, 7)];
        let phase = Estimate { value: lines.values[2], standard_error: c(2, 2).map(|x| x.max(0.0).sqrt()) };
        let sections: Vec<SectionFit> = measured
            .sections
            .iter()
            .zip(self.alone)
            .map(|(section, alone)| {
                let (hem, placement) = lines.curve(section.height);
                let distance = |point: &Point| foot(&lines, &[point.x, point.y, section.height]).distance();
                let squares: f64 = section.profile.points().iter().map(|point| distance(point).powi(2)).sum();
                let rms = (squares / section.profile.points().len() as f64).sqrt();
                SectionFit { height: section.height, alone, hem, placement, rms }
            })
            .collect();
        let lack_of_fit = [
            lack_of_fit(&p, &sections, |fit| Some(fit.p.value)),
            lack_of_fit(&q, &sections, |fit| fit.q.map(|e| e.value)),
            lack_of_fit(&s, &sections, |fit| fit.s.map(|e| e.value)),
        ];
        if options.folds != Folds::Exactly(lines.folds) {
            let voted = sections.iter().filter(|s| s.alone.as_ref().is_ok_and(|f| f.candidates.len() > 1)).count();
            if voted < sections.len() {
                notes.push(format!("{voted} of {} sections show {} folds by themselves", sections.len(), lines.folds));
            }
        }
        let heights = self.points.iter().map(|&i| measured.points[i][2]);
        let range = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
        let rms = (self.distances.iter().map(|d| d * d).sum::<f64>() / self.distances.len().max(1) as f64).sqrt();
        SurfaceFit {
            method: self.method,
            folds: lines.folds,
            p,
            q,
            s,
            phase,
            axis,
            range,
            distances: self.points.iter().map(|&i| measured.points[i]).zip(self.distances).collect(),
            rms,
            neighbour_correlation: correlation,
            inflation,
            sections,
            lack_of_fit,
            evaluations: self.evaluations,
            notes,
        }
    }

    /// Correlation of the distances of neighbours, and the number of pairs.
    fn pairs(&self, measured: &MeasuredSurface) -> Option<(f64, f64)> {
        let mut distance = vec![None; measured.points.len()];
        self.points.iter().zip(&self.distances).for_each(|(&i, &d)| distance[i] = Some(d));
        let products: Vec<f64> = measured.neighbours.iter().filter_map(|&[i, j]| Some(distance[i]? * distance[j]?)).collect();
        let variance = self.rms() * self.rms();
        let n = products.len() as f64;
        (0.0 < n && 0.0 < variance).then(|| (products.iter().sum::<f64>() / n / variance, n))
    }

    fn correlation(&self, measured: &MeasuredSurface) -> Option<f64> {
        self.pairs(measured).map(|(r, _)| r)
    }

    /// Correlation of neighbours, and the factor on standard errors that follows from it.
    fn inflation(&self, measured: &MeasuredSurface) -> (Option<f64>, f64) {
        let Some((r, n)) = self.pairs(measured) else { return (None, 1.0) };
        if r < SIGNIFICANT / n.sqrt() {
            return (Some(r), 1.0);
        }
        // Σ over a square lattice of r^distance, at most the number of points: what one point's distance says about all others.
        let r = r.min(0.999);
        let mut worth = 0.0;
        let reach = ((1e-6_f64.ln() / r.ln()).ceil() as i64).clamp(1, 300);
        for i in -reach..=reach {
            for j in -reach..=reach {
                worth += r.powf((i as f64).hypot(j as f64));
            }
        }
        (Some(r), worth.clamp(1.0, self.distances.len() as f64).sqrt())
    }
}

/// What is wrong with a surface as the outline of these sections, if anything: length and simplicity at the lowest and highest section and between.
fn insane(lines: &Lines, sections: &[Section]) -> Option<String> {
    sections.iter().find_map(|section| {
        let (hem, _) = lines.curve(section.height);
        let at = section.height / crate::units::MILLIMETRE;
        if !(0.0 < hem.p && hem.q.abs() < hem.p && hem.s.abs() < hem.p) {
            return Some(format!("at {at:.0} mm its curve winds through its centre"));
        }
        let outline = super::outline::smooth(&section.profile);
        let ratio = hem.perimeter_to(1e-6).0 / outline.length;
        // Twice the slack of a single outline: a straight line over height need not be right at every height.
        (2.0 * super::rules::LENGTH_SLACK < ratio - 1.0)
            .then(|| format!("at {at:.0} mm its curve is {:.0} % longer than the section", 100.0 * (ratio - 1.0)))
    })
}

fn lack_of_fit(line: &Line, sections: &[SectionFit], pick: impl Fn(&HemFit) -> Option<f64>) -> Option<LackOfFit> {
    let values: Vec<(f64, f64)> =
        sections.iter().filter_map(|s| Some((s.height, pick(s.alone.as_ref().ok().filter(|f| f.folds == Some(s.hem.folds))?)?))).collect();
    if values.len() < FEWEST_SECTIONS {
        return None;
    }
    let n = values.len() as f64;
    let departure = |(z, y): &(f64, f64)| y - line.at(*z).value;
    let squares: f64 = values.iter().map(|v| departure(v).powi(2)).sum();
    let mean = values.iter().map(|(_, y)| y).sum::<f64>() / n;
    let total: f64 = values.iter().map(|(_, y)| (y - mean).powi(2)).sum();
    let (at, largest) = values.iter().map(|v| (v.0, departure(v))).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0.0, 0.0));
    let explained = (0.0 < total).then(|| (1.0 - squares / total).max(0.0));
    Some(LackOfFit { rms: (squares / n).sqrt(), largest, at, explained })
}
