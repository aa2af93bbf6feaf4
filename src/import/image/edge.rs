//! Where exactly an edge runs: the boundary of a part of a grey picture, to a fraction of a pixel.
//!
//! Marching squares puts the boundary between neighbouring pixels. Then every boundary point moves along its normal to where the light,
//! summed across the edge between the local levels of object and background, balances: the partial area of the pixels is what the camera
//! measured, so the sum is free of the bias of interpolation (Trujillo-Pino et al., Image and Vision Computing 31 (2013) 72–90, for the
//! partial-area principle). Local levels follow uneven lighting. Blur of variance σ² draws an edge of curvature κ inwards by κσ²/2; σ² is
//! measured across the edge and the shift undone. Last, a parabola through the points within a few pixels along the edge averages noise out.

use super::level::Grey;
use crate::experiment::campaign::Tone;

/// What an edge is traced in: pixels by rows, and how far each is inside (1) or outside (0) the class in question.
pub(super) struct Field<'a> {
    pub grey: &'a Grey,
    pub shares: &'a [f32],
    /// Traces what is outside as if it were inside.
    pub inverted: bool,
}

/// A closed edge.
pub(super) struct Contour {
    /// Pixels; x to the right, y down, the centre of the first pixel at (0.5, 0.5); in order, the outside on the left of the walk on screen.
    pub points: Vec<[f64; 2]>,
    /// Which tone it was traced in; never `Auto`.
    pub tone: Tone,
    /// Standard deviation of the blur across the edge, px, where it could be seen.
    pub blur: Option<f64>,
}

/// Half-width of the window across the edge, px: blur of one pixel ends inside it.
const WINDOW: f64 = 3.0;
/// The local levels are taken this far out, px.
const REACH: f64 = 6.5;
/// Narrower than this between two edges, px, the grey ramps overlap and the half level alone is used.
const NARROW: f64 = 1.25;
/// Steps across the edge, px.
const STEP: f64 = 0.25;
/// Light (0…1) of a grey value; IEC 61966-2-1 for sRGB.
pub(super) fn light(tone: Tone, value: f64) -> f64 {
    match tone {
        Tone::Srgb if value <= 0.04045 => value / 12.92,
        Tone::Srgb => ((value + 0.055) / 1.055).powf(2.4),
        Tone::Auto | Tone::Linear => value,
    }
}

impl Field<'_> {
    fn share(&self, at: usize) -> f64 {
        let share = f64::from(self.shares[at]);
        if self.inverted { 1.0 - share } else { share }
    }

    /// Bilinear value of `value` at a place in pixels, clamped at the border.
    fn between(&self, [x, y]: [f64; 2], value: impl Fn(usize) -> f64) -> f64 {
        let (width, height) = (self.grey.width, self.grey.height);
        let x = (x - 0.5).clamp(0.0, (width - 1) as f64);
        let y = (y - 0.5).clamp(0.0, (height - 1) as f64);
        let (i, j) = ((x as usize).min(width - 2), (y as usize).min(height - 2));
        let (u, v) = (x - i as f64, y - j as f64);
        let at = j * width + i;
        (1.0 - v) * ((1.0 - u) * value(at) + u * value(at + 1)) + v * ((1.0 - u) * value(at + width) + u * value(at + width + 1))
    }

    /// Light at a place.
    pub fn light_at(&self, place: [f64; 2], tone: Tone) -> f64 {
        self.between(place, |at| light(tone, f64::from(self.grey.values[at])))
    }

    fn share_at(&self, place: [f64; 2]) -> f64 {
        self.between(place, |at| self.share(at))
    }
}

/// Traces the edge of the pixels that `solid` names, round the outside of the part that `first` (its first pixel, row by row) belongs to.
/// It must keep clear of the border of the picture.
pub(super) fn contour(field: &Field, first: usize, solid: &impl Fn(usize) -> bool, tone: Tone) -> Contour {
    let boundary = boundary(field, first, solid);
    let refined = match tone {
        Tone::Auto => {
            let [linear, srgb] = [Tone::Linear, Tone::Srgb].map(|tone| Refined::of(field, &boundary, tone));
            if lopsided_as_srgb(&linear, &srgb) { srgb } else { linear }
        }
        known => Refined::of(field, &boundary, known),
    };
    let variance = refined.spread.as_ref().map(|s| s.variance);
    let points = smoothed(&refined.points, variance.unwrap_or(0.5));
    // The interpolation between pixels (1/6) and the pixel itself (1/12) are no blur of the camera.
    let blur = variance.map(|v| (v - 0.25).max(0.0).sqrt());
    Contour { points, tone: refined.tone, blur }
}

/// Marching squares: the crossings of the half level between neighbouring pixel centres, in order round the part.
fn boundary(field: &Field, first: usize, solid: &impl Fn(usize) -> bool) -> Vec<[f64; 2]> {
    let width = field.grey.width as isize;
    let index = |(x, y): (isize, isize)| (y * width + x) as usize;
    let start = ((first as isize % width, first as isize / width), (0_isize, -1_isize));
    let mut points = Vec::new();
    let (mut inside, mut outward) = start;
    loop {
        let beyond = (inside.0 + outward.0, inside.1 + outward.1);
        // A pixel of a filled hole or of another object may lie on the wrong side of the half level: then the edge is half-way.
        let (a, b) = (field.share(index(inside)), field.share(index(beyond)));
        let share = if b <= 0.5 && 0.5 < a { (a - 0.5) / (a - b) } else { 0.5 };
        points.push([inside.0 as f64 + 0.5 + share * outward.0 as f64, inside.1 as f64 + 0.5 + share * outward.1 as f64]);
        let along = (-outward.1, outward.0);
        let (ahead, aside) = ((inside.0 + along.0, inside.1 + along.1), (beyond.0 + along.0, beyond.1 + along.1));
        if !solid(index(ahead)) {
            outward = along;
        } else if !solid(index(aside)) {
            inside = ahead;
        } else {
            inside = aside;
            outward = (-along.0, -along.1);
        }
        if (inside, outward) == start {
            return points;
        }
    }
}

/// The boundary, moved to where the light balances.
struct Refined {
    points: Vec<[f64; 2]>,
    tone: Tone,
    spread: Option<Spread>,
}

/// Blur across the edge, with that of the pixels and of the interpolation between them.
struct Spread {
    /// px².
    variance: f64,
    /// `E(t) + E(−t) − 1` of the ramp E at t = STEP, 2 STEP …: zero where it looks the same from both sides.
    lopsided: [f64; Ramp::HALF],
    /// Mean levels of object and background.
    levels: [f64; 2],
}

/// Whether the edge, read as linear, is lopsided in the way in which the curve of sRGB makes a blurred edge so: more than half as much.
fn lopsided_as_srgb(linear: &Refined, srgb: &Refined) -> bool {
    let (Some(seen), Some(Spread { variance, levels: [inner, outer], .. })) = (&linear.spread, &srgb.spread) else { return false };
    // The ramp that a blur of this width would leave, if the picture were sRGB: encoded, then blurred by the interpolation (1/4).
    let width = (variance - 0.25).max(0.08).sqrt();
    let ramp = |t: f64| {
        let covered = 0.5 * erfc(t / width / 2_f64.sqrt());
        (encoded(outer + covered * (inner - outer)) - encoded(*outer)) / (encoded(*inner) - encoded(*outer))
    };
    // Gauss–Hermite nodes of three points.
    let blurred = |t: f64| [(-0.866, 1.0 / 6.0), (0.0, 2.0 / 3.0), (0.866, 1.0 / 6.0)].iter().map(|(x, w)| w * ramp(t + x)).sum::<f64>();
    const FINE: f64 = 0.02;
    const FAR: usize = 400;
    let mean: f64 = (0..FAR).map(|k| (k as f64 + 0.5) * FINE).map(|t| FINE * (blurred(t) + blurred(-t) - 1.0)).sum();
    let (mut along, mut square) = (0.0, 0.0);
    for (k, seen) in seen.lopsided.iter().enumerate() {
        let t = (k + 1) as f64 * STEP;
        let expected = blurred(mean + t) + blurred(mean - t) - 1.0;
        along += seen * expected;
        square += expected * expected;
    }
    0.5 * square < along
}

/// Grey value of light by IEC 61966-2-1.
fn encoded(light: f64) -> f64 {
    if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

/// Complementary error function to 1.2e-7: Press et al., Numerical Recipes, 2nd ed., section 6.2 (Chebyshev).
fn erfc(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.5 * x.abs());
    const C: [f64; 10] =
        [-1.26551223, 1.00002368, 0.37409196, 0.09678418, -0.18628806, 0.27886807, -1.13520398, 1.48851587, -0.82215223, 0.17087277];
    let tail = t * (-x * x + C.iter().rev().fold(0.0, |sum, c| sum * t + c)).exp();
    if x < 0.0 { 2.0 - tail } else { tail }
}

/// What the light across the edge says at one boundary point.
struct Across {
    /// Unit vector out of the object.
    normal: [f64; 2],
    /// Light every [`STEP`] from inside to outside, as far as the window goes on either side.
    values: Vec<f64>,
    /// Half-width of the window, px.
    half: f64,
    /// Levels of object and background beside this point, where there is room to see them.
    inner: Option<f64>,
    outer: Option<f64>,
}

impl Refined {
    fn of(field: &Field, boundary: &[[f64; 2]], tone: Tone) -> Self {
        let n = boundary.len();
        // Chord over about five pixels: shorter ones follow the pixel steps, longer ones cut the folds.
        let reach = 4.min(n / 8).max(1);
        let across: Vec<Across> = (0..n)
            .map(|i| {
                let (a, b) = (boundary[(i + n - reach) % n], boundary[(i + reach) % n]);
                let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
                // The walk keeps the outside on its left, y down: the outward normal is (dy, −dx).
                look_across(field, boundary[i], [dy / length, -dx / length], tone)
            })
            .collect();
        let inner = beside(&across.iter().map(|a| a.inner).collect::<Vec<_>>());
        let outer = beside(&across.iter().map(|a| a.outer).collect::<Vec<_>>());
        let (Some(inner), Some(outer)) = (inner, outer) else { return Refined { points: boundary.to_vec(), tone, spread: None } };
        let mut ramp = Ramp::default();
        let points = (0..n)
            .map(|i| {
                let (across, [x, y]) = (&across[i], boundary[i]);
                let contrast = inner[i] - outer[i];
                if across.half < NARROW || contrast.abs() < 0.02 {
                    return [x, y];
                }
                // Trapezoid rule for the covered length of the window.
                let ends = 0.5 * (across.values[0] + across.values[across.values.len() - 1]);
                let sum = STEP * (across.values.iter().sum::<f64>() - ends);
                let shift = (sum - 2.0 * across.half * outer[i]) / contrast - across.half;
                // More than a pixel and a half from the half level is no edge of this shape.
                if 1.5 < shift.abs() {
                    return [x, y];
                }
                if across.half == WINDOW {
                    ramp.add(across, shift, inner[i], outer[i]);
                }
                [x + shift * across.normal[0], y + shift * across.normal[1]]
            })
            .collect();
        Refined { points, tone, spread: ramp.spread() }
    }
}

/// Mean ramp across the edge, from 1 inside to 0 outside, centred where it balances.
#[derive(Default)]
struct Ramp {
    sums: [f64; 2 * Ramp::HALF + 1],
    levels: [f64; 2],
    count: usize,
}

impl Ramp {
    /// Steps to either side; the window must hold them wherever in the middle pixel it balances.
    const HALF: usize = 10;

    fn add(&mut self, across: &Across, shift: f64, inner: f64, outer: f64) {
        let first = (shift + across.half) / STEP - Ramp::HALF as f64;
        if first < 0.0 || ((across.values.len() - 1) as f64) < first + 2.0 * Ramp::HALF as f64 {
            return;
        }
        for (k, sum) in self.sums.iter_mut().enumerate() {
            let place = first + k as f64;
            let i = (place as usize).min(across.values.len() - 2);
            let value = across.values[i] + (place - i as f64) * (across.values[i + 1] - across.values[i]);
            *sum += (value - outer) / (inner - outer);
        }
        self.levels = [self.levels[0] + inner, self.levels[1] + outer];
        self.count += 1;
    }

    /// The second moment of the slope, by parts, and what is lopsided; `None` with too few points for a mean.
    fn spread(&self) -> Option<Spread> {
        if self.count < 30 {
            return None;
        }
        let at = |k: isize| self.sums[(Ramp::HALF as isize + k) as usize] / self.count as f64;
        let mut second = 0.0;
        let mut lopsided = [0.0; Ramp::HALF];
        for k in 1..=Ramp::HALF as isize {
            let t = k as f64 * STEP;
            let weight = if k == Ramp::HALF as isize { 0.5 * STEP } else { STEP };
            second += weight * 2.0 * t * (at(k) + 1.0 - at(-k));
            lopsided[k as usize - 1] = at(k) + at(-k) - 1.0;
        }
        (0.05 < second).then(|| Spread { variance: second, lopsided, levels: self.levels.map(|l| l / self.count as f64) })
    }
}

fn look_across(field: &Field, [x, y]: [f64; 2], normal: [f64; 2], tone: Tone) -> Across {
    let place = |s: f64, t: f64| [x + s * normal[0] - t * normal[1], y + s * normal[1] + t * normal[0]];
    // Mean over one pixel of width along the edge: the sum of partial areas is exact for a straight edge only over whole pixels.
    let value = |s: f64| LINES.iter().map(|t| field.light_at(place(s, *t), tone)).sum::<f64>() / LINES.len() as f64;
    // Each side is looked at until half-way to the next edge.
    let free = |side: f64, inside: bool| {
        let mut s = 1.0;
        while s <= 2.0 * REACH {
            if (0.5 < field.share_at(place(side * s, 0.0))) != inside {
                return 0.5 * s;
            }
            s += 0.5;
        }
        REACH
    };
    let (inside, outside) = (free(-1.0, true), free(1.0, false));
    let level = |side: f64, room: f64| {
        let count = ((room - WINDOW) / (2.0 * STEP)) as usize;
        (2 <= count).then(|| (0..=count).map(|k| value(side * (WINDOW + 2.0 * k as f64 * STEP))).sum::<f64>() / (count + 1) as f64)
    };
    let steps = (WINDOW.min(inside).min(outside) / STEP) as i32;
    Across {
        normal,
        values: (-steps..=steps).map(|k| value(f64::from(k) * STEP)).collect(),
        half: f64::from(steps) * STEP,
        inner: level(-1.0, inside),
        outer: level(1.0, outside),
    }
}

/// Lines along which the light across an edge is summed, px from the middle one.
const LINES: [f64; 5] = [-0.4, -0.2, 0.0, 0.2, 0.4];
/// Their variance, px².
const OF_LINES: f64 = 0.08;

/// Mean of the levels seen within a dozen points on either side, or of all where none is; `None` if there are none at all.
fn beside(levels: &[Option<f64>]) -> Option<Vec<f64>> {
    const BESIDE: usize = 12;
    let n = levels.len();
    let near = BESIDE.min(n / 4);
    let mean = |seen: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = seen.fold((0.0, 0.0), |(sum, count), level| (sum + level, count + 1.0));
        (0.0 < count).then(|| sum / count)
    };
    let usual = mean(&mut levels.iter().flatten().copied())?;
    Some((0..n).map(|i| mean(&mut (0..=2 * near).filter_map(|k| levels[(i + n + k - near) % n])).unwrap_or(usual)).collect())
}

/// Moves every point to a parabola through its neighbours along the edge, and out by what blur drew it in.
fn smoothed(points: &[[f64; 2]], variance: f64) -> Vec<[f64; 2]> {
    let n = points.len();
    if n < 24 {
        return points.to_vec();
    }
    let places = lengths(points);
    let first: Vec<Local> = (0..n).map(|i| Local::at(points, &places, i, 3.0)).collect();
    (0..n)
        .map(|i| {
            // Mean over a few neighbours: one second derivative over six pixels is mostly noise.
            let near = 4;
            let curvature = (0..=2 * near).map(|k| first[(i + n + k - near) % n].curvature()).sum::<f64>() / (2 * near + 1) as f64;
            let radius = 1.0 / curvature.abs().max(1e-6);
            // A parabola over ± M departs by 3 M⁴/35/(24 R³) from a circle of radius R: M such that it stays below 0.01 px.
            let reach = (2.8 * radius.powi(3)).powf(0.25).clamp(2.0, 6.0);
            let local = Local::at(points, &places, i, reach);
            // Where the blur is as wide as the curve is round, there is no edge to be restored.
            let out = if 2.0 * variance.sqrt() < radius { 0.5 * curvature * (variance + OF_LINES) } else { 0.0 };
            let [nx, ny] = local.normal();
            [local.place[0] + out * nx, local.place[1] + out * ny]
        })
        .collect()
}

/// Length along a closed polygon up to each corner, and in all.
fn lengths(points: &[[f64; 2]]) -> Vec<f64> {
    let mut places = vec![0.0];
    for (i, a) in points.iter().enumerate() {
        let b = points[(i + 1) % points.len()];
        places.push(places[i] + (b[0] - a[0]).hypot(b[1] - a[1]));
    }
    places
}

/// A parabola along the edge.
struct Local {
    place: [f64; 2],
    first: [f64; 2],
    second: [f64; 2],
}

impl Local {
    /// Least squares through the points within `reach` of point `i`, nearer ones counting more.
    fn at(points: &[[f64; 2]], places: &[f64], i: usize, reach: f64) -> Self {
        let n = points.len();
        let whole = places[n];
        let mut moments = [0.0; 5];
        let mut sums = [[0.0; 3]; 2];
        let mut add = |k: usize, s: f64| {
            let weight = 1.0 - (s / (reach + 1.0)).powi(2);
            let powers = [1.0, s, s * s, s * s * s, s * s * s * s];
            (0..5).for_each(|p| moments[p] += weight * powers[p]);
            (0..2).for_each(|c| (0..3).for_each(|p| sums[c][p] += weight * powers[p] * (points[k][c] - points[i][c])));
        };
        add(i, 0.0);
        for side in [1, n - 1] {
            let mut k = (i + side) % n;
            for _ in 0..n / 2 {
                let s = places[k] - places[i];
                let s = if side == 1 { s.rem_euclid(whole) } else { -(-s).rem_euclid(whole) };
                if reach < s.abs() {
                    break;
                }
                add(k, s);
                k = (k + side) % n;
            }
        }
        let mut normal = super::linear::Normal::<3>::new();
        let fitted = sums.map(|right| {
            normal.matrix =
                [[moments[0], moments[1], moments[2]], [moments[1], moments[2], moments[3]], [moments[2], moments[3], moments[4]]];
            normal.right = right;
            normal.solve().unwrap_or([0.0; 3])
        });
        let [x, y] = points[i];
        Local {
            place: [x + fitted[0][0], y + fitted[1][0]],
            first: [fitted[0][1], fitted[1][1]],
            second: [2.0 * fitted[0][2], 2.0 * fitted[1][2]],
        }
    }

    /// Unit vector out of the part.
    fn normal(&self) -> [f64; 2] {
        let length = self.first[0].hypot(self.first[1]);
        if length < 1e-9 { [0.0; 2] } else { [self.first[1] / length, -self.first[0] / length] }
    }

    /// Positive where the part bulges, 1/px.
    fn curvature(&self) -> f64 {
        let [nx, ny] = self.normal();
        let speed = self.first[0].powi(2) + self.first[1].powi(2);
        if speed < 1e-9 { 0.0 } else { -(self.second[0] * nx + self.second[1] * ny) / speed }
    }
}
