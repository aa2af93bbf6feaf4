//! One evaluation of curve, tangent, normal and curvature at the feet of all points, eight at a time.
//!
//! A foot is carried as the unit vector e^{it}: it is turned by its Newton step, its multiples are products, and no sine is ever taken. Points,
//! feet and curve move together: with each change of the curve a foot follows to first order, and to second by its own Newton step, so that one
//! evaluation serves one step of both (Ahn, Rauh & Warnecke, Pattern Recognition 34 (2001) 2283–2303; Boggs, Byrd & Schnabel, SIAM J. Sci.
//! Stat. Comput. 8 (1987) 1052–1078).

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, SQRT_2};

use crate::experiment::Point;
use crate::model::hem::Hem;
use crate::numerics::lanes::{Lanes, Vector, WIDTH, multiple_angle, turned};
use crate::vectorized;

/// Unknowns: x0, y0, phase, p, q, s.
pub(super) const UNKNOWNS: usize = 6;
/// Above this |cos mθ| a point is near crest or valley.
const CREST: f64 = 0.8;
/// Entries of the lower triangle of a matrix over the unknowns.
const TRIANGLE: usize = UNKNOWNS * (UNKNOWNS + 1) / 2;

/// Eight points with their feet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    pub x: Lanes,
    pub y: Lanes,
    /// cos t and sin t of the feet.
    pub cos: Lanes,
    pub sin: Lanes,
    /// Signed distance, positive outside, m.
    pub distance: Lanes,
    /// Distance less the shift that noise makes of the curvature, m.
    pub corrected: Lanes,
    /// Newton step of the feet, and their derivatives by the unknowns with the sign turned.
    pub step: Lanes,
    pub by: [Lanes; UNKNOWNS],
}

/// All points of one outline about an origin near its middle; lanes beyond the last point weigh nothing.
pub(super) struct Blocks {
    pub blocks: Vec<Block>,
    /// Weights of the last block's lanes.
    tail: Lanes,
    pub count: usize,
    /// The origin, in the frame of the measurement, m.
    pub origin: Point,
}

/// A curve with its place; the phase as a unit vector.
#[derive(Debug, Clone, Copy)]
pub(super) struct Curve {
    pub x0: f64,
    pub y0: f64,
    pub cos: f64,
    pub sin: f64,
    pub hem: Hem,
}

/// Sums over all points at one evaluation.
pub(super) struct Sums {
    /// JᵀJ of the distances.
    pub normal: [[f64; UNKNOWNS]; UNKNOWNS],
    /// Second derivatives of half the sum of squares with the feet eliminated, where asked for.
    pub hessian: [[f64; UNKNOWNS]; UNKNOWNS],
    /// Jᵀ times the corrected distances.
    pub gradient: [f64; UNKNOWNS],
    /// Sum of squared offsets of the points from their feet, m².
    pub square: f64,
    /// Sum of squared offsets along the tangent: zero where the feet are the nearest points, m².
    pub slip: f64,
    /// Sum of squared corrected distances, m².
    pub corrected: f64,
    /// Greatest curvature in size, 1/m.
    pub sharpest: f64,
}

impl Blocks {
    pub(super) fn new(points: &[Point], origin: Point) -> Blocks {
        // Lanes without a point hold one that keeps every operation finite.
        let far = points[0];
        let empty = Block {
            x: Lanes::all(far.x - origin.x),
            y: Lanes::all(far.y - origin.y),
            cos: Lanes::all(1.0),
            sin: Lanes::ZERO,
            distance: Lanes::ZERO,
            corrected: Lanes::ZERO,
            step: Lanes::ZERO,
            by: [Lanes::ZERO; UNKNOWNS],
        };
        let mut blocks = vec![empty; points.len().div_ceil(WIDTH)];
        for (block, points) in blocks.iter_mut().zip(points.chunks(WIDTH)) {
            for (lane, point) in points.iter().enumerate() {
                block.x.0[lane] = point.x - origin.x;
                block.y.0[lane] = point.y - origin.y;
            }
        }
        let last = points.len() - (blocks.len() - 1) * WIDTH;
        let tail = Lanes(std::array::from_fn(|lane| f64::from(u8::from(lane < last))));
        Blocks { blocks, tail, count: points.len(), origin }
    }

    /// Weight of each lane of block `index`.
    #[inline(always)]
    pub(super) fn live(&self, index: usize) -> Lanes {
        if index + 1 == self.blocks.len() { self.tail } else { Lanes::all(1.0) }
    }

    /// One value of every point, in order.
    pub(super) fn each(&self, of: impl Fn(&Block) -> Lanes) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.blocks.len() * WIDTH);
        for block in &self.blocks {
            values.extend_from_slice(&of(block).0);
        }
        values.truncate(self.count);
        values
    }

    /// Feet near the polar angles of the points about the curve's centre, less what its lean turns them by.
    pub(super) fn feet_by_angle(&mut self, curve: &Curve) {
        feet_by_angle(self, curve);
    }
}

vectorized! {
    fn feet_by_angle<V>(all: &mut Blocks, curve: &Curve) -> () {
        let hem = &curve.hem;
        let leans = hem.s != 0.0;
        // Near crest and valley the angle tells where on a fold a point is: mθ = mt (1 + 2ms/p). In between, where the curve may overhang, the radius.
        let slowed = 1.0 / (1.0 + 2.0 * f64::from(hem.folds) * hem.s.abs() / hem.p);
        let inverse_amplitude = 1.0 / hem.q.abs().max(f64::MIN_POSITIVE);
        for block in &mut all.blocks {
            let (dx, dy) = (V::of(&block.x) - curve.x0, V::of(&block.y) - curve.y0);
            let squared = dx * dx + dy * dy;
            let inverse = V::all(1.0) / squared.sqrt();
            let (cos, sin) = (dx * inverse, dy * inverse);
            let mut foot = (cos * curve.cos + sin * curve.sin, sin * curve.cos - cos * curve.sin);
            if leans {
                let radius = squared * inverse;
                let (cos_angle, sin_angle) = multiple_angle(hem.folds, foot);
                let cos_fold = ((radius - hem.p) * inverse_amplitude).within(1.0);
                let sin_fold = (V::all(1.0) - cos_fold * cos_fold).sqrt();
                let signed = V::choose(sin_angle, V::zero(), -sin_fold, sin_fold);
                let near = V::all(CREST);
                let (cos_fold, sin_fold) = (
                    V::choose(near, cos_angle.abs(), cos_angle, cos_fold),
                    V::choose(near, cos_angle.abs(), sin_angle * slowed, signed),
                );
                let turn = sin_fold * cos_fold * (-2.0 * hem.s) * inverse;
                foot = turned(foot, small_turn(turn.within(1.0 / (2.0 * f64::from(hem.folds)))));
            }
            block.cos = foot.0.lanes();
            block.sin = foot.1.lanes();
            block.step = Lanes::ZERO;
            if leans {
                // These feet are near enough for a step of their own.
                let Local { rho, tau, velocity: (vr, vt), acceleration: (ar, at), .. } = local(hem, foot);
                let (ex, ey) = (foot.0 * curve.cos - foot.1 * curve.sin, foot.0 * curve.sin + foot.1 * curve.cos);
                let (or, ot) = (dx * ex + dy * ey - rho, dy * ex - dx * ey - tau);
                let gauss = vr * vr + vt * vt;
                let stiffness = (gauss - (or * ar + ot * at)).where_above(gauss * 0.1, gauss);
                block.step = ((or * vr + ot * vt) / stiffness).lanes();
            }
            block.by = [Lanes::ZERO; UNKNOWNS];
        }
    }
}

/// The point, tangent and curvature of the curve at feet e^{it}, in the frame that turns with them: each pair is (radial, tangential).
struct Local<V> {
    rho: V,
    tau: V,
    velocity: (V, V),
    acceleration: (V, V),
    cos_fold: V,
    sin_fold: V,
    sin_lean: V,
    cos_lean: V,
}

#[inline(always)]
fn local<V: Vector>(hem: &Hem, foot: (V, V)) -> Local<V> {
    let m = f64::from(hem.folds);
    let (cos_fold, sin_fold) = multiple_angle(hem.folds, foot);
    let sin_lean = (sin_fold * cos_fold) * 2.0;
    let cos_lean = V::all(1.0) - (sin_fold * sin_fold) * 2.0;
    let rho = cos_fold * hem.q + hem.p;
    let tau = sin_lean * hem.s;
    let rho1 = sin_fold * (-hem.q * m);
    let tau1 = cos_lean * (2.0 * m * hem.s);
    let rho2 = cos_fold * (-hem.q * m * m);
    let tau2 = tau * (-4.0 * m * m);
    Local {
        rho,
        tau,
        velocity: (rho1 - tau, rho + tau1),
        acceleration: (rho2 - tau1 * 2.0 - rho, tau2 + rho1 * 2.0 - tau),
        cos_fold,
        sin_fold,
        sin_lean,
        cos_lean,
    }
}

/// e^{iδ} for a small δ, about: a foot's step need not be right to more than its fifth power, and what its length is off is taken back after.
#[inline(always)]
fn small_turn<V: Vector>(angle: V) -> (V, V) {
    let z = angle * angle;
    let cos = V::all(1.0) - z * (V::all(0.5) - z * (1.0 / 24.0));
    let sin = angle * (V::all(1.0) - z * (1.0 / 6.0));
    (cos, sin)
}

vectorized! {
    /// Moves the feet by their own step and by what `change` of the unknowns makes of them, and evaluates `curve` there.
    ///
    /// `half_variance` is half the noise variance (m²) whose shift of the distances is taken off; 0 for none.
    pub(super) fn evaluate<V>(all: &mut Blocks, curve: &Curve, change: &[f64; UNKNOWNS], half_variance: f64, curved: bool) -> Sums {
        if curved {
            evaluate_on::<V, true>(all, curve, change, half_variance)
        } else {
            evaluate_on::<V, false>(all, curve, change, half_variance)
        }
    }
}

/// [`evaluate`] in one kind of register; without second derivatives unless `CURVED`.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // Maps over arrays are not inlined into a function of other instructions.
fn evaluate_on<V: Vector, const CURVED: bool>(all: &mut Blocks, curve: &Curve, change: &[f64; UNKNOWNS], half_variance: f64) -> Sums {
    let hem = &curve.hem;
    let m = f64::from(hem.folds);
    // A foot moves by a twentieth of a fold at most, so that it does not hop to another one.
    let longest = 1.0 / (3.0 * m);
    let mut normal = [V::zero(); TRIANGLE];
    let mut second = [V::zero(); TRIANGLE];
    let mut gradient = [V::zero(); UNKNOWNS];
    let (mut square, mut slip, mut residual, mut sharpest) = (V::zero(), V::zero(), V::zero(), V::zero());
    let last = all.blocks.len() - 1;
    let tail = V::of(&all.tail);
    for (index, block) in all.blocks.iter_mut().enumerate() {
        let live = if index == last { tail } else { V::all(1.0) };
        let follow = (V::of(&block.by[0]) * change[0] + V::of(&block.by[1]) * change[1])
            + (V::of(&block.by[2]) * change[2] + V::of(&block.by[3]) * change[3])
            + (V::of(&block.by[4]) * change[4] + V::of(&block.by[5]) * change[5]);
        let (cos, sin) = turned((V::of(&block.cos), V::of(&block.sin)), small_turn((V::of(&block.step) - follow).within(longest)));
        // Back to length one, to first order of what it is off.
        let length = V::all(1.5) - (cos * cos + sin * sin) * 0.5;
        let (cos, sin) = (cos * length, sin * length);
        (block.cos, block.sin) = (cos.lanes(), sin.lanes());
        let Local { rho, tau, velocity: (vr, vt), acceleration: (ar, at), cos_fold, sin_fold, sin_lean, cos_lean } = local(hem, (cos, sin));
        // e_r in the frame of the measurement, and the point's offset in the turning frame.
        let (ex, ey) = (cos * curve.cos - sin * curve.sin, cos * curve.sin + sin * curve.cos);
        let (dx, dy) = (V::of(&block.x) - curve.x0, V::of(&block.y) - curve.y0);
        let (or, ot) = (dx * ex + dy * ey - rho, dy * ex - dx * ey - tau);
        let gauss = vr * vr + vt * vt;
        let along = or * vr + ot * vt;
        // Half the second derivative of the squared distance by t; Gauss's where a far point lies inside a bend.
        let stiffness = (gauss - (or * ar + ot * at)).where_above(gauss * 0.1, gauss);
        let reciprocal = V::all(1.0) / (gauss * stiffness);
        let (by_square, softness) = (reciprocal * stiffness, reciprocal * gauss);
        let slowness = gauss.sqrt() * by_square;
        let (nr, nt) = (vt * slowness, -(vr * slowness));
        let distance = or * nr + ot * nt;
        block.distance = distance.lanes();
        block.step = (along * softness).lanes();
        let curvature = (vr * at - vt * ar) * (slowness * by_square);
        let corrected = distance - curvature * half_variance;
        block.corrected = corrected.lanes();
        residual = residual + live * (corrected * corrected);
        sharpest = sharpest.max(curvature.abs());
        square = square + live * (or * or + ot * ot);
        slip = slip + live * (along * along * by_square);
        // n·∂c/∂θ: the derivatives of the distance with the sign turned.
        let (wr, wt) = (live * nr, live * nt);
        let row = [wr * ex - wt * ey, wr * ey + wt * ex, wt * rho - wr * tau, wr, wr * cos_fold, wt * sin_lean];
        // ∂c/∂θ along the velocity, then less what the offset makes of ∂c'/∂θ: the mixed derivatives by foot and unknown.
        let drag = [vr * ex - vt * ey, vr * ey + vt * ex, vt * rho - vr * tau, vr, vr * cos_fold, vt * sin_lean];
        let mixed = [
            drag[0],
            drag[1],
            drag[2] - (ot * vr - or * vt),
            drag[3] - ot,
            drag[4] - (ot * cos_fold - or * sin_fold * m),
            drag[5] - (ot * cos_lean * (2.0 * m) - or * sin_lean),
        ];
        let mut by = [V::zero(); UNKNOWNS];
        for i in 0..UNKNOWNS {
            by[i] = mixed[i] * softness;
            block.by[i] = by[i].lanes();
        }
        let mut entry = 0;
        for i in 0..UNKNOWNS {
            gradient[i] = gradient[i] - row[i] * corrected;
            for j in 0..=i {
                normal[entry] = normal[entry] + row[i] * row[j];
                entry += 1;
            }
        }
        if CURVED {
            let mut entry = 0;
            for i in 0..UNKNOWNS {
                let (tangent, elimination) = (live * (drag[i] * by_square), live * by[i]);
                // What the feet have still to go is part of a Newton step of both.
                gradient[i] = gradient[i] - (tangent - elimination) * along;
                for j in 0..=i {
                    second[entry] = second[entry] + (tangent * drag[j] - elimination * mixed[j]);
                    entry += 1;
                }
            }
            // −o·∂²c/∂θ∂θ: only turning acts twice.
            second[5] = second[5] + live * (or * rho + ot * tau);
            second[8] = second[8] - live * ot;
            second[12] = second[12] - live * (ot * cos_fold);
            second[17] = second[17] + live * (or * sin_lean);
        }
    }
    let mut sums = Sums {
        normal: [[0.0; UNKNOWNS]; UNKNOWNS],
        hessian: [[0.0; UNKNOWNS]; UNKNOWNS],
        gradient: [0.0; UNKNOWNS],
        square: square.sum(),
        slip: slip.sum(),
        corrected: residual.sum(),
        sharpest: sharpest.greatest(),
    };
    let mut entry = 0;
    for i in 0..UNKNOWNS {
        sums.gradient[i] = gradient[i].sum();
        for j in 0..=i {
            let value = normal[entry].sum();
            sums.normal[i][j] = value;
            sums.normal[j][i] = value;
            let value = value + second[entry].sum();
            sums.hessian[i][j] = value;
            sums.hessian[j][i] = value;
            entry += 1;
        }
    }
    sums
}

vectorized! {
    /// Sum of squares of the corrected distances, and of their differences from each point to the next, round the outline, m².
    pub(super) fn spread<V>(all: &Blocks) -> (f64, f64) {
        let (mut squares, mut differences) = (V::zero(), V::zero());
        let (last, full) = all.blocks.split_last().expect("a profile has points");
        for (index, block) in full.iter().enumerate() {
            let here = V::of(&block.corrected);
            let [_, b, c, d, e, f, g, h] = block.corrected.0;
            let step = V::of(&Lanes([b, c, d, e, f, g, h, all.blocks[index + 1].corrected.0[0]])) - here;
            squares = squares + here * here;
            differences = differences + step * step;
        }
        let (mut squares, mut differences) = (squares.sum(), differences.sum());
        let held = all.count - full.len() * WIDTH;
        for lane in 0..held {
            let here = last.corrected.0[lane];
            let next = if lane + 1 < held { last.corrected.0[lane + 1] } else { all.blocks[0].corrected.0[0] };
            squares += here * here;
            differences += (next - here) * (next - here);
        }
        (squares, differences)
    }
}

vectorized! {
    /// The greatest distance in size, m.
    pub(super) fn farthest<V>(all: &Blocks) -> f64 {
        let mut greatest = V::zero();
        for block in &all.blocks {
            greatest = greatest.max(V::of(&block.distance).abs());
        }
        greatest.greatest()
    }
}

/// What the finished fit tells of every foot.
pub(super) struct Finish {
    /// Curve parameter of each foot, rad, in (−π, π].
    pub feet: Vec<f64>,
    /// |c'| at each foot, m.
    pub speed: Vec<f64>,
    /// Unit tangent at each foot in the frame of the measurement.
    pub tangent: Vec<(f64, f64)>,
    /// Whether the position turns counter-clockwise at every foot: no overhang there.
    pub ascends: bool,
}

vectorized! {
    /// Parameters, speeds and tangents at the feet as they are.
    pub(super) fn finish<V>(all: &Blocks, curve: &Curve) -> Finish {
        let size = all.blocks.len() * WIDTH;
        let mut finish = Finish {
            feet: Vec::with_capacity(size),
            speed: Vec::with_capacity(size),
            tangent: Vec::with_capacity(size),
            ascends: true,
        };
        let mut least_turn = V::all(f64::INFINITY);
        for block in &all.blocks {
            let foot = (V::of(&block.cos), V::of(&block.sin));
            let Local { rho, tau, velocity: (vr, vt), .. } = local(&curve.hem, foot);
            let speed = (vr * vr + vt * vt).sqrt();
            let (ex, ey) = (foot.0 * curve.cos - foot.1 * curve.sin, foot.0 * curve.sin + foot.1 * curve.cos);
            let (tx, ty) = ((vr * ex - vt * ey) / speed, (vr * ey + vt * ex) / speed);
            least_turn = -((-least_turn).max(-(rho * vt - tau * vr)));
            finish.feet.extend_from_slice(&angle((block.cos, block.sin)).0);
            finish.speed.extend_from_slice(&speed.lanes().0);
            finish.tangent.extend(tx.lanes().0.into_iter().zip(ty.lanes().0));
        }
        finish.feet.truncate(all.count);
        finish.speed.truncate(all.count);
        finish.tangent.truncate(all.count);
        finish.ascends = 0.0 < -(-least_turn).greatest();
        finish
    }
}

/// Coefficients of atan(x)/x in powers of x² for |x| ≤ tan π/8, interpolated at Chebyshev nodes: right to 1.3e-18.
const ARCTANGENT: [f64; 12] = [
    1.0,
    -0.333_333_333_333_331_2,
    0.199_999_999_999_408_93,
    -0.142_857_142_792_502_45,
    0.111_111_107_449_196_58,
    -0.090_908_968_090_640_27,
    0.076_920_453_309_022_25,
    -0.066_629_518_136_291_91,
    0.058_468_782_973_308_72,
    -0.050_351_024_566_015_52,
    0.037_965_257_453_866_94,
    -0.017_805_397_205_419_446,
];

/// The angle of a unit vector, [−π, π], to rounding.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // Lane by lane, which compiles to vectors.
fn angle((cos, sin): (Lanes, Lanes)) -> Lanes {
    let mut result = [0.0; WIDTH];
    for lane in 0..WIDTH {
        let (c, s) = (cos.0[lane], sin.0[lane]);
        let (across, up) = (c.abs(), s.abs());
        let steep = across < up;
        let (small, large) = if steep { (across, up) } else { (up, across) };
        // Between 22.5° and 45° the angle less 45°.
        let beyond = (SQRT_2 - 1.0) * large < small;
        let (numerator, denominator) = if beyond { (small - large, small + large) } else { (small, large) };
        let x = numerator / denominator;
        let z = x * x;
        let mut series = ARCTANGENT[11];
        for k in (0..11).rev() {
            series = series * z + ARCTANGENT[k];
        }
        let octant = x * series + if beyond { FRAC_PI_4 } else { 0.0 };
        let quadrant = if steep { FRAC_PI_2 - octant } else { octant };
        let half = if c < 0.0 { PI - quadrant } else { quadrant };
        result[lane] = if s < 0.0 { -half } else { half };
    }
    Lanes(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_agree_with_the_arctangent() {
        for i in -4000..=4000 {
            let t = PI * f64::from(i) / 4000.0 + 1e-9 * f64::from(i);
            let t = t.clamp(-PI, PI);
            let found = angle((Lanes::all(t.cos()), Lanes::all(t.sin()))).0[3];
            let expected = t.sin().atan2(t.cos());
            assert!((found - expected).abs() <= 1e-15, "{t}: {found} {expected}");
        }
    }
}
