//! A checkerboard in a picture: its corners, and the plane in which it lies.
//!
//! Where four squares meet the grey values form a saddle. Its place is refined until the grey gradient round it is at right angles to the
//! way there (Förstner & Gülch, ISPRS Intercommission Workshop Interlaken (1987) 281–305); corners are strung into a lattice from one to the
//! next; the lattice gives the homography between picture and plane by least squares of the distances in the picture (Hartley & Zisserman,
//! Multiple View Geometry, 2nd ed., section 4.2), and the covariance of its eight numbers the error of every length in the plane.

use std::collections::BTreeMap;

use super::level::{Grey, Split};
use super::linear::Normal;

/// A checkerboard, found.
pub(super) struct Board {
    /// Corners along the two sides.
    pub corners: [usize; 2],
    pub found: usize,
    /// Distance of the corners from where the lattice puts them, px.
    pub rms: f64,
    /// Side of a square in the middle of the board, px.
    pub square: f64,
    /// The quadrilateral of its outermost corners, px.
    pub frame: Vec<[f64; 2]>,
    /// From the plane (unit: a square) to the picture, its last number being 1.
    plane_to_picture: [f64; 8],
    /// Of these numbers.
    covariance: [[f64; 8]; 8],
}

/// Fewest corners along a side: eight numbers from 2 × 9 coordinates.
const FEWEST: usize = 3;
/// Smallest square, px: the ring by which a corner is known must fit.
const LEAST_SQUARE: f64 = 8.0;
/// Error of a corner that even a perfect picture has, px.
const FLOOR: f64 = 0.02;

/// Finds the largest board in a picture.
pub(super) fn find(grey: &Grey) -> Result<Board, (String, &'static str)> {
    const RIGHT: &str =
        "lay a flat board of black and white squares, at least 4 × 4 squares of at least 8 pixels, in even light beside the drape";
    let smooth = smoothed(grey);
    let corners = corners(&smooth);
    if corners.len() < FEWEST * FEWEST {
        return Err((format!("no checkerboard was found: {} corner(s) of four squares", corners.len()), RIGHT));
    }
    let lattice = lattice(&corners);
    let side = |c: usize| {
        let (low, high) = lattice.keys().fold((i32::MAX, i32::MIN), |(low, high), k| (low.min([k.0, k.1][c]), high.max([k.0, k.1][c])));
        (i64::from(high) - i64::from(low) + 1).max(0) as usize
    };
    let sides = if lattice.is_empty() { [0, 0] } else { [side(0), side(1)] };
    if sides[0].min(sides[1]) < FEWEST || lattice.len() < FEWEST * FEWEST {
        let problem = format!(
            "no checkerboard was found: of {} corners at most {} stand in rows ({} × {})",
            corners.len(),
            lattice.len(),
            sides[0],
            sides[1]
        );
        return Err((problem, RIGHT));
    }
    let mut pairs: Vec<([f64; 2], [f64; 2])> =
        lattice.iter().map(|(&(i, j), &c)| ([f64::from(i), f64::from(j)], corners[c].place)).collect();
    // Seen from above, the plane's y goes up where the picture's goes down.
    let first = homography(&pairs).ok_or((format!("{} corners that fix no plane", pairs.len()), RIGHT))?;
    let middle = [0, 1].map(|c| pairs.iter().map(|(p, _)| p[c]).sum::<f64>() / pairs.len() as f64);
    let mut sides = sides;
    if 0.0 < determinant(&first, middle) {
        pairs.iter_mut().for_each(|(p, _)| p.swap(0, 1));
        sides.reverse();
    }
    let plane_to_picture = homography(&pairs).ok_or((format!("{} corners that fix no plane", pairs.len()), RIGHT))?;
    let mut normal = Normal::<8>::new();
    let mut squares = 0.0;
    for (plane, picture) in &pairs {
        let (rows, [dx, dy]) = linearized(&plane_to_picture, *plane, *picture);
        squares += dx * dx + dy * dy;
        normal.add(&rows[0], dx, 1.0);
        normal.add(&rows[1], dy, 1.0);
    }
    let rms = (squares / pairs.len() as f64).sqrt();
    let square = determinant(&plane_to_picture, middle).abs().sqrt();
    if 0.05 * square < rms {
        let problem =
            format!("the {} corners of the checkerboard lie {rms:.1} px rms off a plane lattice of squares of {square:.1} px", pairs.len());
        return Err((problem, "use a flat board and a lens that draws straight lines straight"));
    }
    let variance = (squares / (2.0 * pairs.len() as f64 - 8.0)).max(FLOOR * FLOOR);
    let covariance =
        normal.inverse().ok_or((format!("{} corners that fix no plane", pairs.len()), RIGHT))?.map(|row| row.map(|v| v * variance));
    let bounds = [0, 1].map(|c| pairs.iter().fold((f64::MAX, f64::MIN), |(low, high), (p, _)| (low.min(p[c]), high.max(p[c]))));
    let frame = [(bounds[0].0, bounds[1].0), (bounds[0].1, bounds[1].0), (bounds[0].1, bounds[1].1), (bounds[0].0, bounds[1].1)];
    let frame = frame.map(|(x, y)| mapped(&plane_to_picture, [x, y])).to_vec();
    Ok(Board { corners: sides, found: pairs.len(), rms, square, frame, plane_to_picture, covariance })
}

/// An outline in the plane of the board.
pub(super) struct Levelled {
    /// Unit: a square; x to the right and y up about the middle of the outline, as the picture shows it.
    pub points: Vec<[f64; 2]>,
    /// Squares per pixel in the middle of the outline.
    pub pixel: f64,
    /// Least and largest size of a pixel along the outline, over that in the middle.
    pub range: [f64; 2],
    /// Of the outline's size.
    pub relative_standard_error: f64,
}

impl Board {
    /// Takes an outline in pixels to the plane; `None` if a part of it lies beyond the horizon.
    pub fn level(&self, outline: &[[f64; 2]]) -> Option<Levelled> {
        let inverse = inverted(&self.plane_to_picture)?;
        let n = outline.len() as f64;
        let middle = [0, 1].map(|c| outline.iter().map(|p| p[c]).sum::<f64>() / n);
        let sign = denominator(&inverse, middle).signum();
        if outline.iter().any(|p| denominator(&inverse, *p) * sign < 0.05 * denominator(&inverse, middle).abs()) {
            return None;
        }
        let centre = mapped(&inverse, middle);
        let [right_x, right_y] = {
            let beside = mapped(&inverse, [middle[0] + 1.0, middle[1]]);
            [beside[0] - centre[0], beside[1] - centre[1]]
        };
        let (cos, sin) = (right_x / right_x.hypot(right_y), right_y / right_x.hypot(right_y));
        let points: Vec<[f64; 2]> = outline
            .iter()
            .map(|p| {
                let [x, y] = mapped(&inverse, *p);
                let (x, y) = (x - centre[0], y - centre[1]);
                [x * cos + y * sin, y * cos - x * sin]
            })
            .collect();
        let size = |place: [f64; 2]| determinant(&inverse, place).abs().sqrt();
        let pixel = size(middle);
        let sizes = outline.iter().map(|p| size(*p) / pixel);
        let range = sizes.fold([f64::INFINITY, 0.0_f64], |[low, high], s| [low.min(s), high.max(s)]);
        // Half of the relative change of the area for each of the eight numbers.
        let area = |h: &[f64; 8]| inverted(h).map(|inverse| area(outline.iter().map(|p| mapped(&inverse, *p))).abs());
        let whole = area(&self.plane_to_picture)?;
        let mut slopes = [0.0; 8];
        for (k, slope) in slopes.iter_mut().enumerate() {
            let step = 0.1 * self.covariance[k][k].max(0.0).sqrt();
            if 0.0 < step {
                let changed = |sign: f64| {
                    let mut h = self.plane_to_picture;
                    h[k] += sign * step;
                    area(&h)
                };
                *slope = (changed(1.0)? - changed(-1.0)?) / (4.0 * step * whole);
            }
        }
        let variance: f64 =
            (0..8).flat_map(|i| (0..8).map(move |j| (i, j))).map(|(i, j)| slopes[i] * self.covariance[i][j] * slopes[j]).sum();
        Some(Levelled { points, pixel, range, relative_standard_error: variance.max(0.0).sqrt() })
    }
}

fn area(points: impl Iterator<Item = [f64; 2]>) -> f64 {
    let points: Vec<[f64; 2]> = points.collect();
    0.5 * points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>()
}

fn denominator(h: &[f64; 8], [x, y]: [f64; 2]) -> f64 {
    h[6] * x + h[7] * y + 1.0
}

fn mapped(h: &[f64; 8], [x, y]: [f64; 2]) -> [f64; 2] {
    let w = denominator(h, [x, y]);
    [(h[0] * x + h[1] * y + h[2]) / w, (h[3] * x + h[4] * y + h[5]) / w]
}

/// Determinant of the derivative of a homography: how many times larger areas become there.
fn determinant(h: &[f64; 8], place: [f64; 2]) -> f64 {
    let w = denominator(h, place);
    let [u, v] = mapped(h, place);
    let (a, b, c, d) = ((h[0] - u * h[6]) / w, (h[1] - u * h[7]) / w, (h[3] - v * h[6]) / w, (h[4] - v * h[7]) / w);
    a * d - b * c
}

/// The homography back, scaled to last number 1.
fn inverted(h: &[f64; 8]) -> Option<[f64; 8]> {
    let [a, b, c, d, e, f, g, i] = *h;
    let last = a * e - b * d;
    let back = [e - f * i, c * i - b, b * f - c * e, f * g - d, a - c * g, c * d - a * f, d * i - e * g, b * g - a * i].map(|v| v / last);
    back.iter().all(|v| v.is_finite()).then_some(back)
}

/// Rows of the linearized equations for one corner, and its distance from where it should be.
fn linearized(h: &[f64; 8], plane: [f64; 2], picture: [f64; 2]) -> ([[f64; 8]; 2], [f64; 2]) {
    let [x, y] = plane;
    let w = denominator(h, plane);
    let [u, v] = mapped(h, plane);
    let rows = [[x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y], [0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y]].map(|row| row.map(|r| r / w));
    (rows, [picture[0] - u, picture[1] - v])
}

/// Least squares of the distances in the picture, Gauss–Newton from the linear solution.
fn homography(pairs: &[([f64; 2], [f64; 2])]) -> Option<[f64; 8]> {
    let mut linear = Normal::<8>::new();
    for ([x, y], [u, v]) in pairs {
        linear.add(&[*x, *y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y], *u, 1.0);
        linear.add(&[0.0, 0.0, 0.0, *x, *y, 1.0, -v * x, -v * y], *v, 1.0);
    }
    let mut h = linear.solve()?;
    for _ in 0..10 {
        let mut normal = Normal::<8>::new();
        for (plane, picture) in pairs {
            let (rows, distance) = linearized(&h, *plane, *picture);
            (0..2).for_each(|c| normal.add(&rows[c], distance[c], 1.0));
        }
        let step = normal.solve()?;
        h.iter_mut().zip(&step).for_each(|(h, s)| *h += s);
    }
    h.iter().all(|v| v.is_finite()).then_some(h)
}

struct Corner {
    place: [f64; 2],
    /// Angles of the two lines that cross here, 0…π.
    lines: [f64; 2],
}

/// Gaussian blur of 1 px.
fn smoothed(grey: &Grey) -> Grey {
    const WEIGHTS: [f32; 7] = [0.004433, 0.054006, 0.242036, 0.399050, 0.242036, 0.054006, 0.004433];
    let (w, h) = (grey.width, grey.height);
    let mut rows = grey.values.clone();
    for (to, from) in rows.chunks_exact_mut(w).zip(grey.values.chunks_exact(w)) {
        for x in 3..w.saturating_sub(3) {
            to[x] = (0..7).map(|k| WEIGHTS[k] * from[x + k - 3]).sum();
        }
    }
    let mut values = rows.clone();
    for y in 3..h.saturating_sub(3) {
        for x in 0..w {
            values[y * w + x] = (0..7).map(|k| WEIGHTS[k] * rows[(y + k - 3) * w + x]).sum();
        }
    }
    Grey { width: w, height: h, values }
}

fn corners(smooth: &Grey) -> Vec<Corner> {
    let (w, h) = (smooth.width, smooth.height);
    let Some(split) = Split::of(smooth.values.iter().copied()) else { return vec![] };
    let contrast = (split.light - split.dark) as f32;
    let value = |x: usize, y: usize| smooth.values[y * w + x];
    // Of two crossing edges of this contrast, blurred to σ: I_xy = contrast/(π σ²). A fifth of the contrast and σ = 3 px still count.
    let least = (0.2 * contrast / (std::f32::consts::PI * 9.0)).powi(2);
    const BORDER: usize = 8;
    if w < 2 * BORDER + 1 || h < 2 * BORDER + 1 {
        return vec![];
    }
    let saddle = |x: usize, y: usize| {
        let xx = value(x + 1, y) - 2.0 * value(x, y) + value(x - 1, y);
        let yy = value(x, y + 1) - 2.0 * value(x, y) + value(x, y - 1);
        let xy = 0.25 * (value(x + 1, y + 1) - value(x - 1, y + 1) - value(x + 1, y - 1) + value(x - 1, y - 1));
        xy * xy - xx * yy
    };
    let mut strengths = vec![0.0_f32; w * h];
    for y in BORDER..h - BORDER {
        for x in BORDER..w - BORDER {
            strengths[y * w + x] = saddle(x, y);
        }
    }
    let mut found: Vec<Corner> = Vec::new();
    for y in BORDER..h - BORDER {
        for x in BORDER..w - BORDER {
            let own = strengths[y * w + x];
            if own < least {
                continue;
            }
            let larger = |dx: isize, dy: isize| {
                let other = strengths[(y as isize + dy) as usize * w + (x as isize + dx) as usize];
                own < other || (own == other && (dy, dx) < (0, 0))
            };
            if (-3..=3).any(|dy| (-3..=3).any(|dx| larger(dx, dy))) {
                continue;
            }
            if let Some(corner) =
                refined(smooth, [x as f64 + 0.5, y as f64 + 0.5]).and_then(|place| crossing(smooth, place, f64::from(contrast)))
                && found.iter().rev().take(50).all(|c| 2.0 < (c.place[0] - corner.place[0]).hypot(c.place[1] - corner.place[1]))
            {
                found.push(corner);
            }
        }
    }
    found
}

/// Moves a corner to where the gradients round it are at right angles to the way there.
fn refined(smooth: &Grey, start: [f64; 2]) -> Option<[f64; 2]> {
    const REACH: isize = 4;
    let (w, h) = (smooth.width as isize, smooth.height as isize);
    let mut place = start;
    for _ in 0..8 {
        let mut normal = Normal::<2>::new();
        let (cx, cy) = (place[0].floor() as isize, place[1].floor() as isize);
        if cx < REACH + 1 || cy < REACH + 1 || w <= cx + REACH + 1 || h <= cy + REACH + 1 {
            return None;
        }
        for y in cy - REACH..=cy + REACH {
            for x in cx - REACH..=cx + REACH {
                let value = |x: isize, y: isize| f64::from(smooth.values[(y * w + x) as usize]);
                let gradient = [0.5 * (value(x + 1, y) - value(x - 1, y)), 0.5 * (value(x, y + 1) - value(x, y - 1))];
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let weight = (-((px - place[0]).powi(2) + (py - place[1]).powi(2)) / 8.0).exp();
                // g·p = g·q, in numbers about the start.
                let right = gradient[0] * (px - start[0]) + gradient[1] * (py - start[1]);
                normal.add(&gradient, right, weight);
            }
        }
        let [dx, dy] = normal.solve()?;
        let next = [start[0] + dx, start[1] + dy];
        if 2.5 < dx.hypot(dy) {
            return None;
        }
        let moved = (next[0] - place[0]).hypot(next[1] - place[1]);
        place = next;
        if moved < 1e-3 {
            break;
        }
    }
    Some(place)
}

/// Whether the grey values on a ring change four times, as where four squares meet; and along which lines.
fn crossing(smooth: &Grey, [x, y]: [f64; 2], contrast: f64) -> Option<Corner> {
    const ON_RING: usize = 48;
    const RADIUS: f64 = 4.0;
    let at = |angle: f64| {
        let (px, py) = (x + RADIUS * angle.cos() - 0.5, y + RADIUS * angle.sin() - 0.5);
        let (i, j) = (px.floor() as usize, py.floor() as usize);
        let (u, v) = (px - px.floor(), py - py.floor());
        let value = |i: usize, j: usize| f64::from(smooth.values[j * smooth.width + i]);
        (1.0 - v) * ((1.0 - u) * value(i, j) + u * value(i + 1, j)) + v * ((1.0 - u) * value(i, j + 1) + u * value(i + 1, j + 1))
    };
    let angle = |k: f64| k / ON_RING as f64 * std::f64::consts::TAU;
    let ring: Vec<f64> = (0..ON_RING).map(|k| at(angle(k as f64))).collect();
    let (low, high) = ring.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
    if high - low < 0.35 * contrast {
        return None;
    }
    let level = 0.5 * (low + high);
    let changes: Vec<f64> = (0..ON_RING)
        .filter_map(|k| {
            let (a, b) = (ring[k] - level, ring[(k + 1) % ON_RING] - level);
            ((a < 0.0) != (b < 0.0)).then(|| angle(k as f64 + a / (a - b)))
        })
        .collect();
    let [a, b, c, d] = changes[..] else { return None };
    // Opposite changes belong to one line.
    let straight = |from: f64, to: f64| (to - from - std::f64::consts::PI).abs() < 0.5;
    let apart = b - a;
    if !(straight(a, c) && straight(b, d) && 0.35 < apart && apart < std::f64::consts::PI - 0.35) {
        return None;
    }
    // Opposite squares are alike.
    let half = ON_RING / 2;
    let unlike = (0..half).filter(|&k| (ring[k] < level) != (ring[k + half] < level)).count();
    if half / 4 < unlike {
        return None;
    }
    let line = |from: f64, to: f64| (0.5 * (from + to - std::f64::consts::PI)).rem_euclid(std::f64::consts::PI);
    Some(Corner { place: [x, y], lines: [line(a, c), line(b, d)] })
}

/// The largest lattice that corners can be strung into: from (column, row) to the corner there.
fn lattice(corners: &[Corner]) -> BTreeMap<(i32, i32), usize> {
    let mut best: BTreeMap<(i32, i32), usize> = BTreeMap::new();
    let mut used = vec![false; corners.len()];
    // Boxes of corners, so that neighbours are found without asking all.
    const BOX: f64 = 64.0;
    let cell = |p: [f64; 2]| ((p[0] / BOX).floor() as i64, (p[1] / BOX).floor() as i64);
    let mut boxes: BTreeMap<(i64, i64), Vec<usize>> = BTreeMap::new();
    corners.iter().enumerate().for_each(|(i, c)| boxes.entry(cell(c.place)).or_default().push(i));
    let near = |place: [f64; 2], reach: f64| {
        let (low, high) = (cell([place[0] - reach, place[1] - reach]), cell([place[0] + reach, place[1] + reach]));
        let all = (low.1..=high.1).flat_map(move |y| (low.0..=high.0).map(move |x| (x, y)));
        let mut found: Vec<(f64, usize)> = all
            .filter_map(|b| boxes.get(&b))
            .flatten()
            .map(|&i| ((corners[i].place[0] - place[0]).hypot(corners[i].place[1] - place[1]), i))
            .filter(|(d, _)| *d <= reach)
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found
    };
    for seed in 0..corners.len() {
        if used[seed] {
            continue;
        }
        // The nearest corner along each of the two lines, either way.
        let from = &corners[seed];
        let along = |angle: f64| {
            near(from.place, 400.0).into_iter().find_map(|(d, i)| {
                let [dx, dy] = [corners[i].place[0] - from.place[0], corners[i].place[1] - from.place[1]];
                let off = (dy.atan2(dx) - angle).rem_euclid(std::f64::consts::PI);
                (LEAST_SQUARE <= d && off.min(std::f64::consts::PI - off) < 0.12).then_some([dx, dy])
            })
        };
        let [Some(first), Some(second)] = from.lines.map(along) else { continue };
        let ratio = first[0].hypot(first[1]) / second[0].hypot(second[1]);
        if !(0.4..2.5).contains(&ratio) {
            continue;
        }
        let mut placed = BTreeMap::from([((0, 0), seed)]);
        let mut taken = BTreeMap::from([(seed, [first, second])]);
        let mut queue = std::collections::VecDeque::from([(0, 0)]);
        while let Some(key) = queue.pop_front() {
            let here = placed[&key];
            let steps = taken[&here];
            for (c, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
                let step = [sign * steps[c][0], sign * steps[c][1]];
                let whole = sign as i32;
                let next = if c == 0 { (key.0 + whole, key.1) } else { (key.0, key.1 + whole) };
                if placed.contains_key(&next) {
                    continue;
                }
                let there = [corners[here].place[0] + step[0], corners[here].place[1] + step[1]];
                let found = near(there, 0.25 * step[0].hypot(step[1])).into_iter().find(|(_, i)| !taken.contains_key(i));
                let Some((_, corner)) = found else { continue };
                let mut own = steps;
                own[c] = [0, 1].map(|k| sign * (corners[corner].place[k] - corners[here].place[k]));
                placed.insert(next, corner);
                taken.insert(corner, own);
                queue.push_back(next);
            }
        }
        placed.values().for_each(|&i| used[i] = true);
        if best.len() < placed.len() {
            best = placed;
        }
    }
    best
}
