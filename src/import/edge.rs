//! The edge of the largest object in a grey picture, to a fraction of a pixel.
//!
//! Three steps. The half level between the two grey modes separates object from background, pixel by pixel. Marching squares puts the
//! boundary between neighbouring pixels. Then every boundary point moves along its normal to where the grey ramp, summed across the edge
//! between the local levels of object and background, balances: the partial area of the pixels is what the camera measured, so the sum is
//! free of the bias of interpolation, and noise and compression average out (Trujillo-Pino et al., Image and Vision Computing 31 (2013)
//! 72–90, for the partial-area principle). Local levels follow uneven lighting.

/// Grey values 0…1 by rows, top row first.
pub(super) struct Grey {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f32>,
}

/// What is the object?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Object {
    Dark,
    Light,
    /// Whatever the margin of the picture is not.
    Unlike,
}

/// The outline of the largest object.
pub(super) struct Edge {
    /// Pixels; x to the right, y down, the centre of the first pixel at (0.5, 0.5); closed, in order.
    pub points: Vec<[f64; 2]>,
    pub object_is_dark: bool,
    /// Grey levels of object and background, 0…1.
    pub levels: [f64; 2],
    /// Pixels of each hole in the object; they were filled.
    pub holes: Vec<usize>,
    /// Pixels of each other object, largest first, and of this one.
    pub others: Vec<usize>,
    pub pixels: usize,
}

/// Why there is no outline: what was found, and what would be right.
pub(super) struct NoEdge {
    pub problem: String,
    pub remedy: &'static str,
}

/// Least difference of the grey levels, of full scale: below it noise and compression are as large as the edge.
const LEAST_CONTRAST: f64 = 0.08;
/// Smaller objects are specks: their outline has too few pixels for any fold. Pixels.
const LEAST_PIXELS: usize = 200;
/// Half-width of the window across the edge, px: blur of one pixel ends inside it.
const WINDOW: f64 = 3.0;
/// The local levels are taken this far out, px.
const REACH: f64 = 6.0;
/// Narrower than this between two edges, px, the grey ramps overlap and the half level alone is used.
const NARROW: f64 = 1.25;
/// Steps across the edge, px.
const STEP: f64 = 0.25;

/// Traces the largest object.
pub(super) fn trace(grey: &Grey, object: Object) -> Result<Edge, NoEdge> {
    let refuse = |problem: String, remedy| Err(NoEdge { problem, remedy });
    if grey.width < 16 || grey.height < 16 {
        return refuse(format!("a picture of {} × {} pixels", grey.width, grey.height), "take one with at least 16 pixels each way");
    }
    let threshold = between_modes(&grey.values);
    let [dark, light] = [median(grey.values.iter().filter(|&&v| v <= threshold)), median(grey.values.iter().filter(|&&v| threshold < v))];
    let (Some(dark), Some(light)) = (dark, light) else {
        return refuse("all pixels have the same grey level".into(), "check the file: nothing is to be seen in it");
    };
    if light - dark < LEAST_CONTRAST {
        let problem = format!("object and background differ by only {:.1} % of full scale", 100.0 * (light - dark));
        return refuse(problem, "photograph the drape against a plain background that contrasts with it");
    }
    let object_is_dark = match object {
        Object::Dark => true,
        Object::Light => false,
        Object::Unlike => 0.5 * (dark + light) < median(grey.margin()).unwrap_or(light),
    };
    let (inner, outer) = if object_is_dark { (dark, light) } else { (light, dark) };
    let field = Field {
        width: grey.width,
        height: grey.height,
        values: grey.values.iter().map(|&v| ((f64::from(v) - outer) / (inner - outer)) as f32).collect(),
    };
    let (labels, sizes) = field.objects();
    let Some(largest) = (0..sizes.len()).max_by_key(|&i| (sizes[i], usize::MAX - i)) else {
        return refuse("no object was found".into(), "say whether the object is dark or light");
    };
    if sizes[largest] < LEAST_PIXELS {
        let problem = format!("the largest object has {} pixels", sizes[largest]);
        return refuse(problem, "check that object = \"dark\" or \"light\" is right, and that the drape fills a good part of the picture");
    }
    let label = largest as u32 + 1;
    let (width, height) = (field.width, field.height);
    let touches = |x: usize, y: usize| labels[y * width + x] == label;
    if (0..width).any(|x| touches(x, 0) || touches(x, height - 1)) || (0..height).any(|y| touches(0, y) || touches(width - 1, y)) {
        return refuse(
            "the object touches the border of the picture".into(),
            "take a picture with background all round it, or correct object = \"dark\" or \"light\"",
        );
    }
    let (solid, holes) = field.filled(&labels, label);
    let points = refined(&field, &boundary(&field, &solid));
    let mut others: Vec<usize> = (0..sizes.len()).filter(|&i| i != largest).map(|i| sizes[i]).collect();
    others.sort_unstable_by(|a, b| b.cmp(a));
    Ok(Edge { points, object_is_dark, levels: [inner, outer], holes, others, pixels: sizes[largest] })
}

impl Grey {
    /// The outermost pixels.
    fn margin(&self) -> impl Iterator<Item = &f32> {
        let (w, h) = (self.width, self.height);
        let rows = self.values[..w].iter().chain(&self.values[(h - 1) * w..]);
        rows.chain((0..h).flat_map(move |y| [&self.values[y * w], &self.values[y * w + w - 1]]))
    }
}

/// The threshold that separates two classes best: Otsu, IEEE Transactions SMC 9 (1979) 62–66, on 1024 levels.
fn between_modes(values: &[f32]) -> f32 {
    const LEVELS: usize = 1024;
    let mut histogram = [0.0_f64; LEVELS];
    for &v in values {
        histogram[((v * LEVELS as f32) as usize).min(LEVELS - 1)] += 1.0;
    }
    let total: f64 = histogram.iter().sum();
    let moment: f64 = histogram.iter().enumerate().map(|(i, n)| i as f64 * n).sum();
    let (mut below, mut moment_below) = (0.0, 0.0);
    // Between two clean modes every threshold is equally good: the middle of the best ones.
    let (mut best, mut first, mut last) = (-1.0, 0, 0);
    for (i, n) in histogram.iter().enumerate().take(LEVELS - 1) {
        below += n;
        moment_below += i as f64 * n;
        if below == 0.0 || below == total {
            continue;
        }
        let apart = moment_below / below - (moment - moment_below) / (total - below);
        let between = below * (total - below) * apart * apart;
        if best * (1.0 + 1e-12) < between {
            (best, first, last) = (between, i, i);
        } else if best * (1.0 - 1e-12) <= between {
            last = i;
        }
    }
    (0.5 * (first + last) as f32 + 1.0) / LEVELS as f32
}

fn median<'a>(values: impl Iterator<Item = &'a f32>) -> Option<f64> {
    let mut values: Vec<f32> = values.copied().collect();
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| f64::from(*values.select_nth_unstable_by(middle, f32::total_cmp).1))
}

/// The picture scaled so that the background is 0 and the object 1.
struct Field {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Field {
    /// Labels 1, 2, … of 4-connected objects (0 is background), and their sizes in pixels.
    fn objects(&self) -> (Vec<u32>, Vec<usize>) {
        let mut labels = vec![0; self.values.len()];
        let mut sizes = Vec::new();
        let mut stack = Vec::new();
        for start in 0..self.values.len() {
            if labels[start] != 0 || self.values[start] <= 0.5 {
                continue;
            }
            let label = sizes.len() as u32 + 1;
            labels[start] = label;
            stack.push(start);
            let mut size = 0;
            while let Some(at) = stack.pop() {
                size += 1;
                for next in self.beside(at) {
                    if labels[next] == 0 && 0.5 < self.values[next] {
                        labels[next] = label;
                        stack.push(next);
                    }
                }
            }
            sizes.push(size);
        }
        (labels, sizes)
    }

    /// The pixels above, below, left and right.
    fn beside(&self, at: usize) -> impl Iterator<Item = usize> + use<> {
        let (w, h) = (self.width, self.height);
        let (x, y) = (at % w, at / w);
        let all = [(0 < x).then(|| at - 1), (x + 1 < w).then(|| at + 1), (0 < y).then(|| at - w), (y + 1 < h).then(|| at + w)];
        all.into_iter().flatten()
    }

    /// The pixels of one object with its holes filled, and the size of each hole. A gap that is open only across a corner is a hole.
    fn filled(&self, labels: &[u32], label: u32) -> (Vec<bool>, Vec<usize>) {
        let mut outside = vec![false; labels.len()];
        let flood = |from: usize, outside: &mut Vec<bool>| {
            let mut stack = vec![from];
            outside[from] = true;
            let mut size = 0;
            while let Some(at) = stack.pop() {
                size += 1;
                for next in self.beside(at) {
                    if labels[next] != label && !outside[next] {
                        outside[next] = true;
                        stack.push(next);
                    }
                }
            }
            size
        };
        // The object keeps clear of the border, so the border is one piece of outside.
        flood(0, &mut outside);
        let solid: Vec<bool> = outside.iter().map(|&o| !o).collect();
        let mut holes = Vec::new();
        for at in 0..labels.len() {
            if labels[at] != label && !outside[at] {
                holes.push(flood(at, &mut outside));
            }
        }
        (solid, holes)
    }

    /// Bilinear value at a place in pixels, clamped at the border.
    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let x = (x - 0.5).clamp(0.0, (self.width - 1) as f64);
        let y = (y - 0.5).clamp(0.0, (self.height - 1) as f64);
        let (i, j) = ((x as usize).min(self.width - 2), (y as usize).min(self.height - 2));
        let (u, v) = (x - i as f64, y - j as f64);
        let value = |di: usize, dj: usize| f64::from(self.values[(j + dj) * self.width + i + di]);
        (1.0 - v) * ((1.0 - u) * value(0, 0) + u * value(1, 0)) + v * ((1.0 - u) * value(0, 1) + u * value(1, 1))
    }
}

/// Marching squares: the crossings of the half level between neighbouring pixel centres, in order round the object.
fn boundary(field: &Field, solid: &[bool]) -> Vec<[f64; 2]> {
    let width = field.width as isize;
    let index = |(x, y): (isize, isize)| (y * width + x) as usize;
    let Some(first) = solid.iter().position(|&s| s) else { return Vec::new() };
    let start = ((first as isize % width, first as isize / width), (0_isize, -1_isize));
    let mut points = Vec::new();
    let (mut inside, mut outward) = start;
    loop {
        let beyond = (inside.0 + outward.0, inside.1 + outward.1);
        // A pixel of a filled hole or of another object may lie on the wrong side of the half level: then the edge is half-way.
        let (a, b) = (f64::from(field.values[index(inside)]), f64::from(field.values[index(beyond)]));
        let share = if b <= 0.5 && 0.5 < a { (a - 0.5) / (a - b) } else { 0.5 };
        points.push([inside.0 as f64 + 0.5 + share * outward.0 as f64, inside.1 as f64 + 0.5 + share * outward.1 as f64]);
        let along = (-outward.1, outward.0);
        let (ahead, aside) = ((inside.0 + along.0, inside.1 + along.1), (beyond.0 + along.0, beyond.1 + along.1));
        if !solid[index(ahead)] {
            outward = along;
        } else if !solid[index(aside)] {
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

/// What the grey ramp across the edge says at one boundary point.
struct Across {
    /// Unit vector out of the object.
    normal: [f64; 2],
    /// Values every [`STEP`] from inside to outside, as far as the window goes on either side.
    values: Vec<f64>,
    /// Half-width of the window, px.
    half: f64,
    /// Levels of object and background beside this point, where there is room to see them.
    inner: Option<f64>,
    outer: Option<f64>,
}

/// Moves every boundary point along its normal to where the summed ramp balances.
fn refined(field: &Field, boundary: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let n = boundary.len();
    // Chord over about five pixels: shorter ones follow the pixel steps, longer ones cut the folds.
    let reach = 4.min(n / 8).max(1);
    let across: Vec<Across> = (0..n)
        .map(|i| {
            let (a, b) = (boundary[(i + n - reach) % n], boundary[(i + reach) % n]);
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
            // The walk keeps the outside on its left, y down: the outward normal is (dy, −dx).
            look_across(field, boundary[i], [dy / length, -dx / length])
        })
        .collect();
    let inner = smoothed(&across.iter().map(|a| a.inner).collect::<Vec<_>>(), 1.0);
    let outer = smoothed(&across.iter().map(|a| a.outer).collect::<Vec<_>>(), 0.0);
    (0..n)
        .map(|i| {
            let (across, [x, y]) = (&across[i], boundary[i]);
            if across.half < NARROW || inner[i] - outer[i] < 0.25 {
                return [x, y];
            }
            // Trapezoid rule for the covered length of the window.
            let ends = 0.5 * (across.values[0] + across.values[across.values.len() - 1]);
            let sum = STEP * (across.values.iter().sum::<f64>() - ends);
            let shift = (sum - 2.0 * across.half * outer[i]) / (inner[i] - outer[i]) - across.half;
            // More than a pixel from the half level is no edge of this shape.
            if 1.0 < shift.abs() { [x, y] } else { [x + shift * across.normal[0], y + shift * across.normal[1]] }
        })
        .collect()
}

fn look_across(field: &Field, [x, y]: [f64; 2], normal: [f64; 2]) -> Across {
    // Mean over one pixel of width along the edge: the sum of partial areas is exact for a straight edge only over whole pixels.
    let value = |s: f64| {
        const LINES: [f64; 5] = [-0.4, -0.2, 0.0, 0.2, 0.4];
        let sum: f64 = LINES.iter().map(|t| field.at([x + s * normal[0] - t * normal[1], y + s * normal[1] + t * normal[0]])).sum();
        sum / LINES.len() as f64
    };
    // Each side is looked at until half-way to the next edge.
    let free = |side: f64, beyond: &dyn Fn(f64) -> bool| {
        let mut s = 1.0;
        while s <= 2.0 * REACH {
            if beyond(value(side * s)) {
                return 0.5 * s;
            }
            s += 0.5;
        }
        REACH
    };
    let (inside, outside) = (free(-1.0, &|v| v < 0.5), free(1.0, &|v| 0.5 < v));
    let level = |side: f64, room: f64| {
        let count = ((room - WINDOW) / STEP) as usize;
        (4 <= count).then(|| (0..=count).map(|k| value(side * (WINDOW + k as f64 * STEP))).sum::<f64>() / (count + 1) as f64)
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

/// Mean of the levels seen within a dozen points on either side; `usual` where none is.
fn smoothed(levels: &[Option<f64>], usual: f64) -> Vec<f64> {
    const BESIDE: usize = 12;
    let n = levels.len();
    let beside = BESIDE.min(n / 4);
    (0..n)
        .map(|i| {
            let seen = (0..=2 * beside).filter_map(|k| levels[(i + n + k - beside) % n]);
            let (sum, count) = seen.fold((0.0, 0.0), |(sum, count), level| (sum + level, count + 1.0));
            if 0.0 < count { sum / count } else { usual }
        })
        .collect()
}
