//! One evaluation of curve, tangent, normal and curvature at the feet of all points, eight at a time.
//!
//! A foot is carried as the unit vector e^{it}: it is turned by its Newton step, its multiples are products, and no sine is ever taken. Points,
//! feet and curve move together: with each change of the curve a foot follows to first order, and to second by its own Newton step, so that one
//! evaluation serves one step of both (Ahn, Rauh & Warnecke, Pattern Recognition 34 (2001) 2283–2303; Boggs, Byrd & Schnabel, SIAM J. Sci.
//! Stat. Comput. 8 (1987) 1052–1078).

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, SQRT_2, TAU};

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
    /// Newton step of the feet.
    pub step: Lanes,
    /// Derivatives of the feet by the unknowns with the sign turned, from the last evaluation.
    by: [Lanes; UNKNOWNS],
}

/// All points of one outline about an origin near its middle; lanes beyond the last point hold the first one again and weigh nothing.
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
        let (one, turn_cos, turn_sin) = (V::all(1.0), V::all(curve.cos), V::all(curve.sin));
        // Near crest and valley the angle tells where on a fold a point is: mθ = mt (1 + 2ms/p). In between, where the curve may overhang, the radius.
        let slowed = 1.0 / (1.0 + 2.0 * f64::from(hem.folds) * hem.s.abs() / hem.p);
        let inverse_amplitude = 1.0 / hem.q.abs().max(f64::MIN_POSITIVE);
        for block in &mut all.blocks {
            let (dx, dy) = (V::of(&block.x) - curve.x0, V::of(&block.y) - curve.y0);
            let squared = dx.mul_add(dx, dy * dy);
            let inverse = one / squared.sqrt();
            let (cos, sin) = (dx * inverse, dy * inverse);
            let mut foot = turned((cos, sin), (turn_cos, -turn_sin));
            block.step = Lanes::ZERO;
            if leans {
                let radius = squared * inverse;
                let (cos_angle, sin_angle) = multiple_angle(hem.folds, foot);
                let cos_fold = ((radius - hem.p) * inverse_amplitude).within(1.0);
                let sin_fold = cos_fold.neg_mul_add(cos_fold, one).sqrt();
                let signed = V::choose(sin_angle, V::zero(), -sin_fold, sin_fold);
                let near = V::all(CREST);
                let (cos_fold, sin_fold) = (
                    V::choose(near, cos_angle.abs(), cos_angle, cos_fold),
                    V::choose(near, cos_angle.abs(), sin_angle * slowed, signed),
                );
                let turn = (sin_fold * cos_fold) * (inverse * (-2.0 * hem.s));
                foot = turned(foot, small_turn(turn.within(1.0 / (2.0 * f64::from(hem.folds)))));
                // These feet are near enough for a step of their own.
                let away = away(&local(hem, foot), (dx, dy), turned(foot, (turn_cos, turn_sin)));
                block.step = (away.along / away.stiffness).lanes();
            }
            block.cos = foot.0.lanes();
            block.sin = foot.1.lanes();
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
    let twice = sin_fold + sin_fold;
    let sin_lean = twice * cos_fold;
    let cos_lean = twice.neg_mul_add(sin_fold, V::all(1.0));
    let rho = cos_fold.mul_add(V::all(hem.q), V::all(hem.p));
    let tau = sin_lean * hem.s;
    let rho1 = sin_fold * (-hem.q * m);
    let tau1 = cos_lean * (2.0 * m * hem.s);
    let two = V::all(2.0);
    Local {
        rho,
        tau,
        velocity: (rho1 - tau, rho + tau1),
        acceleration: (tau1.neg_mul_add(two, cos_fold.mul_sub(V::all(-hem.q * m * m), rho)), rho1.mul_add(two, tau * (-4.0 * m * m - 1.0))),
        cos_fold,
        sin_fold,
        sin_lean,
        cos_lean,
    }
}

/// Where points lie, seen from their feet.
struct Away<V> {
    /// Offset, (radial, tangential), m.
    offset: (V, V),
    /// Square of the curve's velocity, m².
    gauss: V,
    /// Offset times velocity, m².
    along: V,
    /// Half the second derivative of the squared distance by t; Gauss's where a far point lies inside a bend.
    stiffness: V,
}

/// `here` is the curve at the feet; (dx, dy) leads from its middle to the points, and (ex, ey) is e_r at the feet, both in the frame of the
/// measurement.
#[inline(always)]
fn away<V: Vector>(here: &Local<V>, (dx, dy): (V, V), (ex, ey): (V, V)) -> Away<V> {
    let ((vr, vt), (ar, at)) = (here.velocity, here.acceleration);
    let offset = (dx.mul_add(ex, dy.mul_sub(ey, here.rho)), dy.mul_sub(ex, dx.mul_add(ey, here.tau)));
    let gauss = vr.mul_add(vr, vt * vt);
    let along = offset.0.mul_add(vr, offset.1 * vt);
    let bent = offset.1.neg_mul_add(at, offset.0.neg_mul_add(ar, gauss));
    Away { offset, gauss, along, stiffness: bent.where_above(gauss * 0.1, gauss) }
}

/// e^{iδ} for a small δ, about: a foot's step need not be right to more than its fifth power, and what its length is off is taken back after.
#[inline(always)]
fn small_turn<V: Vector>(angle: V) -> (V, V) {
    let (z, one) = (angle * angle, V::all(1.0));
    let cos = z.neg_mul_add(z.neg_mul_add(V::all(1.0 / 24.0), V::all(0.5)), one);
    let sin = angle * z.neg_mul_add(V::all(1.0 / 6.0), one);
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

/// Blocks gone through together: first the curve at their feet, where each result waits for the one before, then the sums, which keep every register
/// busy. So the next block's feet are on their way while this one's wait.
const GROUP: usize = 8;

/// What one block adds to the first derivatives; lanes that weigh nothing hold zeros.
#[derive(Clone, Copy)]
struct Rows<V> {
    /// n·∂c/∂θ: the derivatives of the distance with the sign turned.
    across: [V; UNKNOWNS],
    corrected: V,
}

/// What it adds to the second.
#[derive(Clone, Copy)]
struct Curved<V> {
    /// The unit tangent times ∂c/∂θ.
    along: [V; UNKNOWNS],
    /// The mixed derivatives of half the squared distance by foot and unknown, with the sign turned.
    mixed: [V; UNKNOWNS],
    /// What the feet have still to go: the offset along the unit tangent, and along the velocity.
    behind: (V, V),
}

/// [`evaluate`] in one kind of register; without second derivatives unless `CURVED`.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // Maps over arrays are not inlined into a function of other instructions.
fn evaluate_on<V: Vector, const CURVED: bool>(all: &mut Blocks, curve: &Curve, change: &[f64; UNKNOWNS], half_variance: f64) -> Sums {
    let hem = &curve.hem;
    let m = f64::from(hem.folds);
    // A foot moves by a twentieth of a fold at most, so that it does not hop to another one.
    let longest = 1.0 / (3.0 * m);
    let follows = *change != [0.0; UNKNOWNS];
    let (zero, one) = (V::zero(), V::all(1.0));
    let mut normal = [zero; TRIANGLE];
    let mut second = [zero; TRIANGLE];
    let mut gradient = [zero; UNKNOWNS];
    // −o·∂²c/∂θ∂θ: only turning acts twice, on itself, p, q and s.
    let mut turning = [zero; 4];
    let (mut square, mut slip, mut residual, mut sharpest) = (zero, zero, zero, zero);
    let mut rows = [Rows { across: [zero; UNKNOWNS], corrected: zero }; GROUP];
    let mut bends = [Curved { along: [zero; UNKNOWNS], mixed: [zero; UNKNOWNS], behind: (zero, zero) }; GROUP];
    let mut left = all.blocks.len();
    for group in all.blocks.chunks_mut(GROUP) {
        for ((block, rows), bends) in group.iter_mut().zip(&mut rows).zip(&mut bends) {
            left -= 1;
            let live = if left == 0 { V::of(&all.tail) } else { one };
            let mut turn = V::of(&block.step);
            if follows {
                let by = |k: usize| V::of(&block.by[k]);
                let change = |k: usize| V::all(change[k]);
                turn = by(0).neg_mul_add(change(0), by(1).neg_mul_add(change(1), by(2).neg_mul_add(change(2), turn)))
                    - by(3).mul_add(change(3), by(4).mul_add(change(4), by(5) * change(5)));
            }
            let (cos, sin) = turned((V::of(&block.cos), V::of(&block.sin)), small_turn(turn.within(longest)));
            // Back to length one, to first order of what it is off.
            let length = cos.mul_add(cos, sin * sin).neg_mul_add(V::all(0.5), V::all(1.5));
            let (cos, sin) = (cos * length, sin * length);
            (block.cos, block.sin) = (cos.lanes(), sin.lanes());
            let here = local(hem, (cos, sin));
            let (ex, ey) = turned((cos, sin), (V::all(curve.cos), V::all(curve.sin)));
            let Away { offset: (or, ot), gauss, along, stiffness } =
                away(&here, (V::of(&block.x) - curve.x0, V::of(&block.y) - curve.y0), (ex, ey));
            let Local { rho, tau, velocity: (vr, vt), acceleration: (ar, at), cos_fold, sin_fold, sin_lean, cos_lean } = here;
            let reciprocal = one / (gauss * stiffness);
            let (by_square, softness) = (reciprocal * stiffness, reciprocal * gauss);
            let slowness = gauss.sqrt() * by_square;
            block.step = (along * softness).lanes();
            let distance = or.mul_sub(vt, ot * vr) * slowness;
            block.distance = distance.lanes();
            let curvature = vr.mul_sub(at, vt * ar) * (slowness * by_square);
            let corrected = curvature.neg_mul_add(V::all(half_variance), distance);
            block.corrected = corrected.lanes();
            sharpest = sharpest.max(curvature.abs());
            residual = (live * corrected).mul_add(corrected, residual);
            square = live.mul_add(or.mul_add(or, ot * ot), square);
            slip = (live * along).mul_add(along * by_square, slip);
            // ∂c/∂θ along the velocity, and along the unit normal.
            let (px, py) = (vr.mul_sub(ex, vt * ey), vr.mul_add(ey, vt * ex));
            let weight = live * slowness;
            let (wr, wt) = (vt * weight, -(vr * weight));
            rows.across = [py * weight, -(px * weight), wt.mul_sub(rho, wr * tau), wr, wr * cos_fold, wt * sin_lean];
            rows.corrected = corrected;
            // The same along the velocity, less what the offset makes of ∂c'/∂θ.
            let outward = vr - ot;
            let mixed = [
                px,
                py,
                vt.mul_sub(rho + or, vr * (tau + ot)),
                outward,
                outward.mul_add(cos_fold, (or * sin_fold) * m),
                (vt + or).mul_sub(sin_lean, (ot * cos_lean) * (2.0 * m)),
            ];
            for i in 0..UNKNOWNS {
                block.by[i] = (mixed[i] * softness).lanes();
            }
            if CURVED {
                let (tr, tt) = (-wt, wr);
                bends.along = [px * weight, py * weight, tt.mul_sub(rho, tr * tau), tr, tr * cos_fold, tt * sin_lean];
                for i in 0..UNKNOWNS {
                    bends.mixed[i] = live * mixed[i];
                }
                bends.behind = (slowness * along, live * along);
                let across = live * ot;
                turning[0] = live.mul_add(or.mul_add(rho, ot * tau), turning[0]);
                turning[1] = turning[1] - across;
                turning[2] = across.neg_mul_add(cos_fold, turning[2]);
                turning[3] = (live * or).mul_add(sin_lean, turning[3]);
            }
        }
        for Rows { across, corrected } in &rows[..group.len()] {
            let mut entry = 0;
            for i in 0..UNKNOWNS {
                gradient[i] = across[i].neg_mul_add(*corrected, gradient[i]);
                for j in 0..=i {
                    normal[entry] = across[i].mul_add(across[j], normal[entry]);
                    entry += 1;
                }
            }
        }
        if CURVED {
            for (Curved { along, mixed, behind }, block) in bends.iter().zip(group.iter()) {
                let mut entry = 0;
                for i in 0..UNKNOWNS {
                    let elimination = V::of(&block.by[i]);
                    // What the feet have still to go is part of a Newton step of both.
                    gradient[i] = elimination.mul_add(behind.1, along[i].neg_mul_add(behind.0, gradient[i]));
                    for j in 0..=i {
                        second[entry] = elimination.neg_mul_add(mixed[j], along[i].mul_add(along[j], second[entry]));
                        entry += 1;
                    }
                }
            }
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
    for (entry, turning) in [5, 8, 12, 17].into_iter().zip(turning) {
        second[entry] = second[entry] + turning;
    }
    let mut entry = 0;
    for i in 0..UNKNOWNS {
        sums.gradient[i] = gradient[i].sum();
        for j in 0..=i {
            let value = normal[entry].sum();
            sums.normal[i][j] = value;
            sums.normal[j][i] = value;
            if CURVED {
                let value = value + second[entry].sum();
                sums.hessian[i][j] = value;
                sums.hessian[j][i] = value;
            }
            entry += 1;
        }
    }
    sums
}

vectorized! {
    /// Sum of squares of the distances, corrected or not, and of their differences from each point to the next, round the outline, m².
    pub(super) fn spread<V>(all: &Blocks, corrected: bool) -> (f64, f64) {
        let of = |block: &Block| V::of(if corrected { &block.corrected } else { &block.distance });
        let (mut squares, mut differences) = (V::zero(), V::zero());
        let first = of(&all.blocks[0]);
        let mut here = first;
        for index in 0..all.blocks.len() {
            let next = all.blocks.get(index + 1).map_or(first, of);
            let live = V::of(&all.live(index));
            let step = here.followed(next) - here;
            squares = (live * here).mul_add(here, squares);
            differences = (live * step).mul_add(step, differences);
            here = next;
        }
        (squares.sum(), differences.sum())
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

/// What the finished fit tells of its feet and of the way from each to the next, round the outline.
pub(super) struct Finish {
    /// Curve parameter of each foot, rad, in [−π, π].
    pub feet: Vec<f64>,
    /// The curve's parameter from first foot to first foot, rad.
    pub turned: f64,
    /// The curve from each foot to the next, m; zeros beyond the last point.
    pub arcs: Vec<f64>,
    /// The sum of those that run back, m, 0 or less.
    pub back: f64,
    /// The greatest excess of an arc over π/2 times the chord of its points, m.
    pub excess: f64,
    /// The outline along the curve's tangents, m: noise across the curve has no part in it.
    pub length: f64,
    /// Whether the position turns counter-clockwise at every foot: no overhang there.
    pub ascends: bool,
}

/// A block's points and their feet on the finished curve.
#[derive(Clone, Copy)]
struct Passed<V> {
    point: (V, V),
    /// Parameter, rad.
    foot: V,
    /// |c'|, m.
    speed: V,
    /// Unit tangent in the frame of the measurement.
    tangent: (V, V),
    /// Radius squared times the rate of turning, m².
    turns: V,
}

#[inline(always)]
fn passed<V: Vector>(block: &Block, curve: &Curve) -> Passed<V> {
    let foot = (V::of(&block.cos), V::of(&block.sin));
    let Local { rho, tau, velocity: (vr, vt), .. } = local(&curve.hem, foot);
    let speed = vr.mul_add(vr, vt * vt).sqrt();
    let slowness = V::all(1.0) / speed;
    let (ex, ey) = turned(foot, (V::all(curve.cos), V::all(curve.sin)));
    Passed {
        point: (V::of(&block.x), V::of(&block.y)),
        foot: angle(foot),
        speed,
        tangent: (vr.mul_sub(ex, vt * ey) * slowness, vr.mul_add(ey, vt * ex) * slowness),
        turns: rho.mul_sub(vt, tau * vr),
    }
}

vectorized! {
    /// Feet as they are, and the way from each to the next.
    pub(super) fn finish<V>(all: &Blocks, curve: &Curve) -> Finish {
        let size = all.blocks.len() * WIDTH;
        let (mut feet, mut arcs) = (Vec::with_capacity(size), Vec::with_capacity(size));
        let (zero, half_turn, whole_turn) = (V::zero(), V::all(PI), V::all(TAU));
        let (mut turned, mut back, mut length) = (zero, zero, zero);
        let (mut excess, mut least_turn) = (V::all(f64::NEG_INFINITY), V::all(f64::INFINITY));
        let first = passed::<V>(&all.blocks[0], curve);
        let mut here = first;
        for index in 0..all.blocks.len() {
            let next = all.blocks.get(index + 1).map_or(first, |block| passed(block, curve));
            let live = V::of(&all.live(index));
            let ahead = |of: fn(&Passed<V>) -> V| of(&here).followed(of(&next));
            let turn = ahead(|p| p.foot) - here.foot;
            let turn = V::choose(half_turn, turn, turn - whole_turn, turn);
            let turn = live * V::choose(turn, -half_turn, turn + whole_turn, turn);
            let arc = (here.speed + ahead(|p| p.speed)) * turn * 0.5;
            let (dx, dy) = (ahead(|p| p.point.0) - here.point.0, ahead(|p| p.point.1) - here.point.1);
            let chord = dx.mul_add(dx, dy * dy).sqrt();
            let (tx, ty) = (here.tangent.0 + ahead(|p| p.tangent.0), here.tangent.1 + ahead(|p| p.tangent.1));
            let both = tx.mul_add(tx, ty * ty).sqrt().max(V::all(f64::MIN_POSITIVE));
            length = live.mul_add(dx.mul_add(tx, dy * ty) / both, length);
            turned = turned + turn;
            excess = chord.neg_mul_add(V::all(0.5 * PI), arc).max(excess);
            back = back - (-arc).max(zero);
            least_turn = V::choose(here.turns, least_turn, here.turns, least_turn);
            feet.extend_from_slice(&here.foot.lanes().0);
            arcs.extend_from_slice(&arc.lanes().0);
            here = next;
        }
        feet.truncate(all.count);
        Finish {
            feet,
            turned: turned.sum(),
            arcs,
            back: back.sum(),
            excess: excess.greatest(),
            length: length.sum(),
            ascends: 0.0 < -(-least_turn).greatest(),
        }
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
fn angle<V: Vector>((cos, sin): (V, V)) -> V {
    let (across, up) = (cos.abs(), sin.abs());
    let (small, large) = (V::choose(across, up, across, up), V::choose(across, up, up, across));
    // Between 22.5° and 45° the angle less 45°.
    let beyond = large * (SQRT_2 - 1.0);
    let x = V::choose(beyond, small, small - large, small) / V::choose(beyond, small, small + large, large);
    let z = x * x;
    let mut series = V::all(ARCTANGENT[11]);
    for k in (0..11).rev() {
        series = series.mul_add(z, V::all(ARCTANGENT[k]));
    }
    let octant = x.mul_add(series, V::choose(beyond, small, V::all(FRAC_PI_4), V::zero()));
    let quadrant = V::choose(across, up, V::all(FRAC_PI_2) - octant, octant);
    let half = V::choose(cos, V::zero(), V::all(PI) - quadrant, quadrant);
    V::choose(sin, V::zero(), -half, half)
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
