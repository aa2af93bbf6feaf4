//! One fold count, fitted from a start by Newton steps of curve and feet together.

use std::f64::consts::PI;

use super::super::foot_point::{Centred, Foot, nearest_within};
use super::kernel::{Blocks, Curve, Sums, UNKNOWNS, evaluate, farthest, spread};
use crate::model::hem::Hem;
use crate::numerics::lanes::{Lanes, WIDTH, multiple_angle, turned};
use crate::vectorized;

/// Evaluations after which a fit that has not converged is left to the careful path.
pub(in super::super) const LIMIT: usize = 30;
/// Below this cosine of residual and Jacobian the step takes the exact second derivatives: Gauss–Newton, which leaves a hundredth each time, has
/// brought the curve so near that Newton squares what is left.
const NEAR: f64 = 1e-2;

/// Below this cosine the second derivatives of the step before are good enough for the last one.
const ENOUGH: f64 = 1e-5;

/// When and how to stop.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wish {
    /// Largest cosine between the residuals and a column of the Jacobian.
    pub gradient_tolerance: f64,
    /// A fit that cannot come below this sum of squares is of no interest, m².
    pub beaten: f64,
}

/// How a fit ended.
pub(super) enum Ended {
    /// At a minimum (of the corrected equations, if asked).
    Converged(Box<Optimum>),
    /// No minimum below the sum of squares of interest is near.
    Beaten { sum_of_squares: f64 },
    /// Neither: the careful path knows what to do.
    Lost,
}

/// A minimum.
pub(super) struct Optimum {
    pub curve: Curve,
    pub sums: Sums,
    /// Factor of the second derivatives there, or of what is near enough to them.
    factor: Triangle,
    pub evaluations: usize,
}

/// The root of the equations without the bias of curvature, near a minimum.
pub(super) struct Corrected {
    pub curve: Curve,
    pub sums: Sums,
    /// Noise variance whose shift was taken off, m².
    pub noise_variance: f64,
    pub rounds: usize,
}

/// Rounds of looking for nearer feet. Feet that move lower the sum of squares, so this ends; in practice after one round.
const LOOKS: usize = 5;

/// Fits from `start`.
pub(super) fn fit(all: &mut Blocks, start: &Curve, wish: &Wish) -> Ended {
    let mut evaluations = 0;
    // Plain Gauss–Newton first; a start that it leaves uphill is tried again with damping.
    for damping in [0.0, 0.1] {
        all.feet_by_angle(start);
        let mut ended = descend(all, start, wish, damping, &mut evaluations);
        for _ in 0..LOOKS {
            let Ended::Converged(optimum) = &ended else { break };
            if !look_again(all, &optimum.curve) {
                return ended;
            }
            let curve = optimum.curve;
            ended = descend(all, &curve, wish, 0.0, &mut evaluations);
        }
        if let Ended::Beaten { .. } = ended {
            return ended;
        }
    }
    Ended::Lost
}

/// Whether some point has a nearer foot within half a fold of its own; moves those feet.
///
/// Only points further out than the curve's reach can have one.
fn look_again(all: &mut Blocks, curve: &Curve) -> bool {
    let hem = &curve.hem;
    let window = PI / f64::from(hem.folds);
    let reach = reach(hem);
    if farthest(all) < reach {
        return false;
    }
    let mut moved = false;
    // Lanes beyond the last point too, which go with the first one.
    for i in 0..all.blocks.len() * WIDTH {
        let block = &mut all.blocks[i / WIDTH];
        let lane = i % WIDTH;
        if block.distance.0[lane].abs() < reach {
            continue;
        }
        let (dx, dy) = (block.x.0[lane] - curve.x0, block.y.0[lane] - curve.y0);
        let point = Centred { x: dx * curve.cos + dy * curve.sin, y: dy * curve.cos - dx * curve.sin };
        let t = block.sin.0[lane].atan2(block.cos.0[lane]);
        let here = Foot::at(hem, point, t);
        let found = nearest_within(hem, point, t - window, t + window, 16);
        if found.square() < here.square() * (1.0 - 1e-6) - 1e-18 && (found.t - t).abs() <= window {
            let (sin, cos) = found.t.sin_cos();
            (block.cos.0[lane], block.sin.0[lane]) = (cos, sin);
            moved = true;
        }
    }
    if moved {
        for block in &mut all.blocks {
            block.step = Lanes::ZERO;
        }
    }
    moved
}

vectorized! {
    /// A lower bound of the reach of the curve within half a fold either way, m: a point nearer to it than this has one nearest point only.
    ///
    /// The reach is the least of |c(u) − c(t)|² / 2 |n(t)·(c(u) − c(t))| (Federer, Trans. Amer. Math. Soc. 93 (1959) 418–491), here over nodes.
    fn reach<V>(hem: &Hem) -> f64 {
        /// Nodes in half a fold, and what they may overestimate the reach by.
        const NODES: usize = 24;
        const SAFETY: f64 = 0.7;
        /// Registers of nodes to be touched: half a fold, and some more of the next, which is its mirror image.
        const TOUCHED: usize = NODES / WIDTH + 1;
        // Half a fold before those to be touched, and half a fold after them.
        const ALL: usize = 2 * NODES + TOUCHED * WIDTH;
        let m = f64::from(hem.folds);
        let step = PI / (m * NODES as f64);
        // e^{it} and e^{imt} go on by equal turns: no sine of their own.
        let ((sin_step, cos_step), (fold_sin_step, fold_cos_step)) = (step.sin_cos(), (m * step).sin_cos());
        let mut starts = [Lanes::ZERO; 4];
        let (sin, cos) = (step * -(NODES as f64)).sin_cos();
        let (mut at, mut fold) = ((cos, sin), (-1.0, 0.0));
        for lane in 0..WIDTH {
            (starts[0].0[lane], starts[1].0[lane], starts[2].0[lane], starts[3].0[lane]) = (at.0, at.1, fold.0, fold.1);
            at = (at.0 * cos_step - at.1 * sin_step, at.1 * cos_step + at.0 * sin_step);
            fold = (fold.0 * fold_cos_step - fold.1 * fold_sin_step, fold.1 * fold_cos_step + fold.0 * fold_sin_step);
        }
        let constant = |(a, b): (f64, f64)| (V::all(a), V::all(b));
        let (ahead, fold_ahead) = (multiple_angle(WIDTH as u32, constant((cos_step, sin_step))), multiple_angle(WIDTH as u32, constant((fold_cos_step, fold_sin_step))));
        let [mut x, mut y] = [[0.0; ALL]; 2];
        let mut normals = [(V::zero(), V::zero()); ALL / WIDTH];
        let (mut at, mut fold) = ((V::of(&starts[0]), V::of(&starts[1])), (V::of(&starts[2]), V::of(&starts[3])));
        for k in 0..ALL / WIDTH {
            let twice = fold.1 + fold.1;
            let (rho, tau) = (fold.0 * hem.q + hem.p, twice * fold.0 * hem.s);
            let (vr, vt) = (-(fold.1 * (m * hem.q)) - tau, rho + twice.neg_mul_add(fold.1, V::all(1.0)) * (2.0 * m * hem.s));
            let slowness = V::all(1.0) / vr.mul_add(vr, vt * vt).sqrt();
            let (px, py) = turned(at, (rho, tau));
            x[k * WIDTH..][..WIDTH].copy_from_slice(&px.lanes().0);
            y[k * WIDTH..][..WIDTH].copy_from_slice(&py.lanes().0);
            normals[k] = turned(at, (vt * slowness, -(vr * slowness)));
            (at, fold) = (turned(at, ahead), turned(fold, fold_ahead));
        }
        // The least quotient is divided once, at the end of the comparison.
        let mut squares = [V::all(f64::INFINITY); TOUCHED];
        let mut aways = [V::all(1.0); TOUCHED];
        for offset in 0..=2 * NODES {
            for k in 0..TOUCHED {
                let (first, normal) = (NODES + k * WIDTH, normals[NODES / WIDTH + k]);
                let (dx, dy) = (V::read(&x[first + offset - NODES..]) - V::read(&x[first..]), V::read(&y[first + offset - NODES..]) - V::read(&y[first..]));
                let (square, away) = (dx.mul_add(dx, dy * dy), normal.0.mul_add(dx, normal.1 * dy).abs());
                let (new, old) = (square * aways[k], squares[k] * away);
                squares[k] = V::choose(new, old, square, squares[k]);
                aways[k] = V::choose(new, old, away, aways[k]);
            }
        }
        let mut least = f64::INFINITY;
        for k in 0..TOUCHED {
            least = (squares[k] / aways[k]).lanes().0.into_iter().fold(least, f64::min);
        }
        0.5 * SAFETY * least
    }
}

fn descend(all: &mut Blocks, start: &Curve, wish: &Wish, mut damping: f64, evaluations: &mut usize) -> Ended {
    let mut curve = *start;
    let mut change = [0.0; UNKNOWNS];
    let mut last = f64::INFINITY;
    let mut factor: Option<Triangle> = None;
    let mut curved = false;
    let rounding = rounding(&curve);
    for round in 0..LIMIT {
        let sums = evaluate(all, &curve, &change, 0.0, curved);
        *evaluations += 1;
        if !sums.square.is_finite() {
            return Ended::Lost;
        }
        let norm = sums.square.sqrt();
        let steepest = steepest(&sums);
        let cosine = steepest / norm.max(f64::MIN_POSITIVE);
        if factor.is_none() && NEAR <= cosine {
            if 3 <= round && last < sums.square {
                return Ended::Lost;
            }
            // What the linear model promises says whether this fold count can still come into question.
            if wish.beaten < sums.square && 4 <= round && 0.98 * last < sums.square {
                return Ended::Beaten { sum_of_squares: sums.square };
            }
        }
        let at_rest = sums.slip <= (wish.gradient_tolerance * norm).powi(2) + (rounding * rounding) * all.count as f64;
        let settled = steepest <= wish.gradient_tolerance * norm + rounding;
        if settled && at_rest {
            // A root of the gradient is a minimum only where the second derivatives say so.
            let proof = factor.or_else(|| if curved { cholesky(&sums.hessian, 0.0) } else { None });
            if let Some(factor) = proof {
                return Ended::Converged(Box::new(Optimum { curve, sums, factor, evaluations: *evaluations }));
            }
            if curved {
                return Ended::Lost;
            }
            (change, curved) = ([0.0; UNKNOWNS], true);
            continue;
        }
        if cosine < NEAR && wish.beaten < sums.square {
            return Ended::Beaten { sum_of_squares: sums.square };
        }
        if curved && cosine < NEAR {
            // Not positive definite: a saddle, or not yet near.
            factor = cholesky(&sums.hessian, 0.0);
        }
        // A step of Newton squares what is left: two of them from 1e-3, and the last needs no derivatives any more.
        curved = (ENOUGH..10.0 * NEAR).contains(&cosine);
        let step = match &factor {
            Some(triangle) => triangle.solve(&sums.gradient),
            None => match cholesky(&sums.normal, damping) {
                Some(triangle) => triangle.solve(&sums.gradient),
                None => return Ended::Lost,
            },
        };
        damping *= 0.2;
        last = sums.square;
        change = step;
        curve.take(&step);
    }
    Ended::Lost
}

/// Goes on from a minimum to the root of Σ Jᵢ (dᵢ − ½σ̂²κᵢ) = 0 ([`super::super::bias`]); `None` if it is not reached.
pub(super) fn correct(all: &mut Blocks, optimum: &Optimum, gradient_tolerance: f64) -> Option<Corrected> {
    const ROUNDS: usize = 20;
    let mut curve = optimum.curve;
    let mut change = [0.0; UNKNOWNS];
    let rounding = rounding(&curve);
    let mut noise_variance = noise_variance_of(all);
    for rounds in 1..=ROUNDS {
        let sums = evaluate(all, &curve, &change, 0.5 * noise_variance, false);
        let norm = sums.square.sqrt();
        let steepest = steepest(&sums);
        if !steepest.is_finite() {
            return None;
        }
        let noise = noise_variance_of(all);
        let at_rest = sums.slip <= (gradient_tolerance * norm).powi(2) + (rounding * rounding) * all.count as f64;
        let same_noise = (noise - noise_variance).abs() <= gradient_tolerance * noise;
        if steepest <= gradient_tolerance * norm + rounding && at_rest && same_noise {
            return Some(Corrected { curve, sums, noise_variance, rounds });
        }
        noise_variance = noise;
        change = optimum.factor.solve(&sums.gradient);
        curve.take(&change);
    }
    None
}

/// Largest gradient by an unknown whose column has unit length, m.
fn steepest(sums: &Sums) -> f64 {
    (0..UNKNOWNS).map(|k| sums.gradient[k].abs() / sums.normal[k][k].sqrt()).fold(0.0, f64::max)
}

/// The curve's size times the rounding of a coordinate difference, m.
fn rounding(curve: &Curve) -> f64 {
    32.0 * f64::EPSILON * (curve.hem.p + curve.hem.q.abs())
}

/// The noise in the corrected distances: their mean square with its degrees of freedom, or that of their differences along the outline if it is
/// less (von Neumann, Annals of Mathematical Statistics 12 (1941) 367–395): a smooth misfit is not noise.
pub(super) fn noise_variance_of(all: &Blocks) -> f64 {
    let (squares, differences) = spread(all, true);
    let n = all.count as f64;
    (squares / (n - UNKNOWNS as f64)).min(0.5 * differences / n)
}

impl Curve {
    fn take(&mut self, step: &[f64; UNKNOWNS]) {
        self.x0 += step[0];
        self.y0 += step[1];
        let (sin, cos) = step[2].sin_cos();
        (self.cos, self.sin) = (self.cos * cos - self.sin * sin, self.sin * cos + self.cos * sin);
        self.hem.p += step[3];
        self.hem.q += step[4];
        self.hem.s += step[5];
    }
}

/// A lower triangle L with LLᵀ the scaled matrix, and the scales.
#[derive(Clone, Copy)]
pub(super) struct Triangle {
    /// Below the diagonal.
    lower: [[f64; UNKNOWNS]; UNKNOWNS],
    /// One over the diagonal.
    pivots: [f64; UNKNOWNS],
    scale: [f64; UNKNOWNS],
}

/// The Cholesky factor of a matrix scaled to a unit diagonal, which is raised by `damping`; `None` if it is not safely positive definite.
#[allow(clippy::needless_range_loop)] // Indices as in the formula.
pub(super) fn cholesky(matrix: &[[f64; UNKNOWNS]; UNKNOWNS], damping: f64) -> Option<Triangle> {
    let mut scale = [0.0; UNKNOWNS];
    for i in 0..UNKNOWNS {
        if !(0.0 < matrix[i][i] && matrix[i][i].is_finite()) {
            return None;
        }
        scale[i] = 1.0 / matrix[i][i].sqrt();
    }
    let (mut lower, mut pivots) = ([[0.0; UNKNOWNS]; UNKNOWNS], [0.0; UNKNOWNS]);
    for i in 0..UNKNOWNS {
        for j in 0..=i {
            let mut sum = matrix[i][j] * scale[i] * scale[j] + if i == j { damping } else { 0.0 };
            for k in 0..j {
                sum -= lower[i][k] * lower[j][k];
            }
            if i == j {
                // The square of the distance of a column from the span of those before it.
                if sum < 1e-10 {
                    return None;
                }
                pivots[i] = 1.0 / sum.sqrt();
            } else {
                lower[i][j] = sum * pivots[j];
            }
        }
    }
    Some(Triangle { lower, pivots, scale })
}

impl Triangle {
    /// The step that takes a gradient to zero.
    #[allow(clippy::needless_range_loop)] // Indices as in the formula.
    pub(super) fn solve(&self, gradient: &[f64; UNKNOWNS]) -> [f64; UNKNOWNS] {
        let mut step = [0.0; UNKNOWNS];
        for i in 0..UNKNOWNS {
            let mut sum = -gradient[i] * self.scale[i];
            for k in 0..i {
                sum -= self.lower[i][k] * step[k];
            }
            step[i] = sum * self.pivots[i];
        }
        for i in (0..UNKNOWNS).rev() {
            let mut sum = step[i];
            for k in i + 1..UNKNOWNS {
                sum -= self.lower[k][i] * step[k];
            }
            step[i] = sum * self.pivots[i];
        }
        for i in 0..UNKNOWNS {
            step[i] *= self.scale[i];
        }
        step
    }

    /// The inverse of the matrix.
    pub(super) fn inverse(&self) -> [[f64; UNKNOWNS]; UNKNOWNS] {
        std::array::from_fn(|column| {
            let mut unit = [0.0; UNKNOWNS];
            unit[column] = -1.0;
            self.solve(&unit)
        })
    }
}
