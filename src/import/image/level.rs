//! What is background and what is object: grey levels of both, also where the lighting is uneven.
//!
//! The margin of the picture is background, since the object must keep clear of it. A surface of second order through the margin takes the
//! lighting away, Otsu's threshold separates what is left, and surfaces through each of the two classes (background: fourth order, object:
//! second) give the levels at every place. Where both surfaces are flat to a twentieth of the contrast, plain medians are used.

use super::Object;
use super::linear::Normal;

/// Grey values 0…1 by rows, top row first.
pub(super) struct Grey {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f32>,
}

/// Why there is no outline: what was found, and what would be right.
pub(super) struct NoEdge {
    pub problem: String,
    pub remedy: &'static str,
}

/// The two classes of a picture.
pub(super) struct Levels {
    pub object_is_dark: bool,
    pub inner: Surface,
    pub outer: Surface,
    /// Medians of object and background, 0…1.
    pub typical: [f64; 2],
    /// Least and largest level of the background, where it is uneven enough to matter.
    pub uneven: Option<[f64; 2]>,
}

/// Least difference of the grey levels, of full scale: below it noise and compression are as large as the edge.
pub(super) const LEAST_CONTRAST: f64 = 0.08;
/// Share of the scatter of all grey values that two classes must explain. Two clean levels: 1. Noise alone: normal 2/π = 0.64, uniform 3/4.
pub(super) const LEAST_SEPARATION: f64 = 0.8;
/// Unevenness of a level, of the contrast, from which it is followed.
const UNEVEN: f64 = 0.05;
/// Samples along the longer side from which surfaces are fitted.
const SAMPLES: usize = 128;

/// A polynomial of x and y over the picture, each scaled to −1…1, kept between two bounds.
#[derive(Clone)]
pub(super) struct Surface {
    order: usize,
    coefficients: [f64; 15],
    scale: [f64; 2],
    bounds: [f64; 2],
}

impl Surface {
    pub fn flat(level: f64) -> Self {
        let mut coefficients = [0.0; 15];
        coefficients[0] = level;
        Surface { order: 0, coefficients, scale: [1.0; 2], bounds: [level, level] }
    }

    /// Its value at a place in pixels.
    pub fn at(&self, [x, y]: [f64; 2]) -> f64 {
        if self.order == 0 {
            return self.coefficients[0];
        }
        let terms = terms(self.order, [x * self.scale[0] - 1.0, y * self.scale[1] - 1.0]);
        terms.iter().zip(&self.coefficients).map(|(t, c)| t * c).sum::<f64>().clamp(self.bounds[0], self.bounds[1])
    }

    /// Least squares through samples; outliers are left out in a second and third round.
    fn through(samples: &[([f64; 2], f64)], order: usize, size: [usize; 2]) -> Option<Self> {
        let scale = size.map(|n| 2.0 / n as f64);
        let count = (order + 1) * (order + 2) / 2;
        if samples.len() < 10 * count {
            return None;
        }
        let row = |[x, y]: [f64; 2]| terms(order, [x * scale[0] - 1.0, y * scale[1] - 1.0]);
        let mut limit = f64::INFINITY;
        let mut surface = None;
        for _ in 0..3 {
            let mut normal = Normal::<15>::new();
            // Unused terms are held at zero.
            (count..15).for_each(|k| {
                let mut unit = [0.0; 15];
                unit[k] = 1.0;
                normal.add(&unit, 0.0, 1.0);
            });
            let off = |place: [f64; 2], value: f64, c: &Option<[f64; 15]>| {
                c.map_or(0.0, |c| (value - row(place).iter().zip(&c).map(|(t, c)| t * c).sum::<f64>()).abs())
            };
            samples.iter().filter(|(p, v)| off(*p, *v, &surface) <= limit).for_each(|(p, v)| normal.add(&row(*p), *v, 1.0));
            surface = Some(normal.solve()?);
            let mut distances: Vec<f64> = samples.iter().map(|(p, v)| off(*p, *v, &surface)).collect();
            // Three standard deviations of normal noise, from the median; at least a grey level of eight bits.
            limit = (4.4 * middle(&mut distances)?).max(0.004);
        }
        let coefficients = surface?;
        let mut surface = Surface { order, coefficients, scale, bounds: [f64::NEG_INFINITY, f64::INFINITY] };
        let mut values: Vec<f64> = samples.iter().map(|(p, _)| surface.at(*p)).collect();
        values.sort_by(f64::total_cmp);
        surface.bounds = [values[values.len() / 50], values[values.len() - 1 - values.len() / 50]];
        Some(surface)
    }

    fn range(&self) -> f64 {
        self.bounds[1] - self.bounds[0]
    }
}

fn terms(order: usize, [x, y]: [f64; 2]) -> [f64; 15] {
    let mut terms = [0.0; 15];
    let mut at = 0;
    for degree in 0..=order {
        for of_y in 0..=degree {
            terms[at] = x.powi((degree - of_y) as i32) * y.powi(of_y as i32);
            at += 1;
        }
    }
    terms
}

/// The levels of object and background.
pub(super) fn levels(grey: &Grey, object: Object) -> Result<Levels, NoEdge> {
    let refuse = |problem: String, remedy| Err(NoEdge { problem, remedy });
    let step = grey.width.max(grey.height).div_ceil(SAMPLES);
    let at = |x: usize, y: usize| f64::from(grey.values[y * grey.width + x]);
    let place = |x: usize, y: usize| [x as f64 + 0.5, y as f64 + 0.5];
    let frame = (grey.width.min(grey.height) / 50).max(2);
    let size = [grey.width, grey.height];
    let all: Vec<(usize, usize)> =
        (0..grey.height).step_by(step).flat_map(|y| (0..grey.width).step_by(step).map(move |x| (x, y))).collect();
    let (w, h) = (grey.width, grey.height);
    let margin: Vec<([f64; 2], f64)> = (0..h)
        .flat_map(|y| (0..w).map(move |x| (x, y)))
        .filter(|&(x, y)| x < frame || y < frame || w <= x + frame || h <= y + frame)
        .step_by((step * frame).max(1))
        .map(|(x, y)| (place(x, y), at(x, y)))
        .collect();
    let plain = Split::of(grey.values.iter().copied());
    let Some(plain) = plain else {
        return refuse("all pixels have the same grey level".into(), "check the file: nothing is to be seen in it");
    };
    let ground = Surface::through(&margin, 2, size).unwrap_or_else(|| {
        let mut values: Vec<f64> = margin.iter().map(|(_, v)| *v).collect();
        Surface::flat(middle(&mut values).unwrap_or(plain.light))
    });
    let free = Surface { bounds: [-0.5, 1.5], ..ground.clone() };
    let split = Split::of(all.iter().map(|&(x, y)| (at(x, y) - free.at(place(x, y))) as f32 * 0.5 + 0.5)).map(Split::doubled);
    let Some(split) = split else {
        return refuse("all pixels have the same grey level".into(), "check the file: nothing is to be seen in it");
    };
    // Levelled by its margin where that tells the classes apart better.
    let (chosen, base) = if plain.separation <= split.separation { (split, Some(&free)) } else { (plain, None) };
    let contrast = chosen.light - chosen.dark;
    if contrast < LEAST_CONTRAST {
        let problem = format!("object and background differ by only {:.1} % of full scale", 100.0 * contrast);
        return refuse(problem, "photograph the drape against a plain background that contrasts with it");
    }
    if chosen.separation < LEAST_SEPARATION {
        let problem = format!(
            "the grey values fall into no two groups (two groups explain {:.0} % of their scatter, noise alone 64 to 75 %)",
            100.0 * chosen.separation
        );
        return refuse(problem, "photograph the drape in even light, sharply, against a plain background that contrasts with it");
    }
    let mut of_margin: Vec<f64> = margin.iter().map(|(p, v)| v - base.map_or(0.0, |s| s.at(*p))).collect();
    let margin_level = middle(&mut of_margin).unwrap_or(chosen.light);
    let margin_is_light = 0.5 * (chosen.dark + chosen.light) < margin_level;
    let object_is_dark = match object {
        Object::Dark => true,
        Object::Light => false,
        Object::Unlike => margin_is_light,
    };
    // Asked for the shade of the margin itself: no margin to level by.
    let base = base.filter(|_| object_is_dark == margin_is_light);
    let base_at = |x: usize, y: usize| base.map_or(0.0, |s| s.at(place(x, y)));
    let chosen = if base.is_some() { chosen } else { plain };
    let (inner, outer) = if object_is_dark { (chosen.dark, chosen.light) } else { (chosen.light, chosen.dark) };
    let mut share = |x: usize, y: usize| (at(x, y) - base_at(x, y) - outer) / (inner - outer);
    let typical = |values: &mut Vec<f64>, else_level: f64| middle(values).unwrap_or(else_level);
    let (mut of_object, mut of_ground) = sorted(&all, size, &mut share);
    let mut surfaces = None;
    for _ in 0..2 {
        let samples = |places: &[(usize, usize)]| places.iter().map(|&(x, y)| (place(x, y), at(x, y))).collect::<Vec<_>>();
        let (object_samples, ground_samples) = (samples(&of_object), samples(&of_ground));
        let fitted = |samples: &[([f64; 2], f64)], order: usize| {
            Surface::through(samples, order, size).or_else(|| Surface::through(samples, 1, size))
        };
        let (Some(inner), Some(outer)) = (fitted(&object_samples, 2), fitted(&ground_samples, 4)) else { break };
        let mut share = |x: usize, y: usize| {
            let (inner, outer) = apart(inner.at(place(x, y)), outer.at(place(x, y)), object_is_dark, contrast);
            (at(x, y) - outer) / (inner - outer)
        };
        (of_object, of_ground) = sorted(&all, size, &mut share);
        surfaces = Some((inner, outer));
    }
    let values = |places: &[(usize, usize)]| places.iter().map(|&(x, y)| at(x, y)).collect::<Vec<f64>>();
    let typical = [
        typical(&mut values(&of_object), if object_is_dark { plain.dark } else { plain.light }),
        typical(&mut values(&of_ground), if object_is_dark { plain.light } else { plain.dark }),
    ];
    let followed = surfaces.filter(|(inner, outer)| UNEVEN * contrast < inner.range().max(outer.range()) && base.is_some());
    Ok(match followed {
        Some((inner, outer)) => {
            let uneven = (UNEVEN * contrast < outer.range()).then_some(outer.bounds);
            Levels { object_is_dark, inner, outer, typical, uneven }
        }
        None => {
            let [inner, outer] = if base.is_some() { typical } else { [inner, outer] };
            Levels { object_is_dark, inner: Surface::flat(inner), outer: Surface::flat(outer), typical: [inner, outer], uneven: None }
        }
    })
}

/// Keeps two levels at least a third of the contrast apart, in the right order.
fn apart(inner: f64, outer: f64, object_is_dark: bool, contrast: f64) -> (f64, f64) {
    let sign = if object_is_dark { -1.0 } else { 1.0 };
    (outer + sign * (sign * (inner - outer)).max(0.3 * contrast), outer)
}

/// Column and row.
type Pixel = (usize, usize);

/// Places well inside the object, and well outside it.
fn sorted(all: &[(usize, usize)], [width, height]: [usize; 2], share: &mut impl FnMut(usize, usize) -> f64) -> (Vec<Pixel>, Vec<Pixel>) {
    const CLEAR: usize = 5;
    let (mut object, mut ground) = (vec![], vec![]);
    for &(x, y) in all {
        let class = 0.5 < share(x, y);
        let around =
            [(x.saturating_sub(CLEAR), y), ((x + CLEAR).min(width - 1), y), (x, y.saturating_sub(CLEAR)), (x, (y + CLEAR).min(height - 1))];
        if around.into_iter().all(|(x, y)| (0.5 < share(x, y)) == class) {
            if class { object.push((x, y)) } else { ground.push((x, y)) }
        }
    }
    (object, ground)
}

/// The picture scaled so that the background is 0 and the object 1.
pub(super) fn shares(grey: &Grey, levels: &Levels) -> Vec<f32> {
    let contrast = (levels.typical[0] - levels.typical[1]).abs();
    if levels.inner.order == 0 && levels.outer.order == 0 {
        let (inner, outer) = (levels.inner.at([0.0; 2]), levels.outer.at([0.0; 2]));
        return grey.values.iter().map(|&v| ((f64::from(v) - outer) / (inner - outer)) as f32).collect();
    }
    // Lighting changes slowly: the surfaces are taken every few pixels, and straight between.
    const STEP: usize = 8;
    let mut shares = Vec::with_capacity(grey.values.len());
    for y in 0..grey.height {
        let mut next = None;
        for block in (0..grey.width).step_by(STEP) {
            let pair = |x: usize| {
                let place = [x as f64 + 0.5, y as f64 + 0.5];
                apart(levels.inner.at(place), levels.outer.at(place), levels.object_is_dark, contrast)
            };
            let (here, there) = (next.unwrap_or_else(|| pair(block)), pair(block + STEP));
            next = Some(there);
            for x in block..(block + STEP).min(grey.width) {
                let t = (x - block) as f64 / STEP as f64;
                let (inner, outer) = (here.0 + t * (there.0 - here.0), here.1 + t * (there.1 - here.1));
                shares.push(((f64::from(grey.values[y * grey.width + x]) - outer) / (inner - outer)) as f32);
            }
        }
    }
    shares
}

/// Replaces isolated pixels (salt and pepper) by the median of their neighbours, and counts them: a pixel that leaves the range of all its
/// neighbours but one by a quarter of the contrast. Lines, even of one pixel, have two neighbours of their own kind and stay.
pub(super) fn despeckle(grey: &mut Grey) -> usize {
    let Some(split) = Split::of(grey.values.iter().copied()) else { return 0 };
    let margin = (0.25 * (split.light - split.dark).max(LEAST_CONTRAST)) as f32;
    let (w, h) = (grey.width, grey.height);
    let mut found = Vec::new();
    for y in 1..h.saturating_sub(1) {
        for x in 1..w.saturating_sub(1) {
            let value = grey.values[y * w + x];
            // Most pixels are like the one before.
            if (value - grey.values[y * w + x - 1]).abs() < margin && (value - grey.values[y * w + x + 1]).abs() < margin {
                continue;
            }
            let row = |y: usize| &grey.values[y * w + x - 1..y * w + x + 2];
            let (a, b, c) = (row(y - 1), row(y), row(y + 1));
            let mut around = [a[0], a[1], a[2], b[0], b[2], c[0], c[1], c[2]];
            around.sort_unstable_by(f32::total_cmp);
            if value < around[1] - margin || around[6] + margin < value {
                found.push((y * w + x, 0.5 * (around[3] + around[4])));
            }
        }
    }
    found.iter().for_each(|&(at, value)| grey.values[at] = value);
    found.len()
}

fn middle(values: &mut [f64]) -> Option<f64> {
    let half = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(half, f64::total_cmp).1)
}

/// Two classes of grey values.
#[derive(Clone, Copy)]
pub(super) struct Split {
    /// Medians of the classes.
    pub dark: f64,
    pub light: f64,
    /// Variance between the classes over the whole variance.
    pub separation: f64,
}

impl Split {
    /// The classes that Otsu's threshold makes of values 0…1; `None` if all are alike. Otsu, IEEE Transactions SMC 9 (1979) 62–66.
    pub fn of(values: impl Iterator<Item = f32> + Clone) -> Option<Self> {
        const LEVELS: usize = 4096;
        let mut histogram = vec![0.0_f64; LEVELS];
        let level = |v: f32| ((v * LEVELS as f32) as usize).min(LEVELS - 1);
        values.for_each(|v| histogram[level(v)] += 1.0);
        let total: f64 = histogram.iter().sum();
        let moment: f64 = histogram.iter().enumerate().map(|(i, n)| i as f64 * n).sum();
        let whole: f64 = histogram.iter().enumerate().map(|(i, n)| n * (i as f64 - moment / total).powi(2)).sum();
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
        if best <= 0.0 {
            return None;
        }
        let threshold = (first + last) / 2;
        // Medians to within a level of the histogram, the place in it by the share of its values.
        let median = |from: usize, to: usize| {
            let half = 0.5 * histogram[from..to].iter().sum::<f64>();
            let mut passed = 0.0;
            (from..to).find_map(|i| {
                passed += histogram[i];
                (half <= passed && 0.0 < histogram[i]).then(|| (i as f64 + 0.5) / LEVELS as f64)
            })
        };
        let (dark, light) = (median(0, threshold + 1)?, median(threshold + 1, LEVELS)?);
        Some(Split { dark, light, separation: best / total / whole })
    }

    /// Of values that were halved and moved to the middle of 0…1.
    fn doubled(self) -> Self {
        Split { dark: 2.0 * self.dark - 1.0, light: 2.0 * self.light - 1.0, ..self }
    }
}
