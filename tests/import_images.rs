//! Pictures: outlines of known shape, rendered here or encoded elsewhere, are traced to fractions of a pixel; what cannot be traced is refused.

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use hemline::experiment::Point;
use hemline::experiment::campaign::{CameraHeight, PictureScale, Pictures, Shade, Tone};
use hemline::import::image::{self, Marked, Silhouette};
use hemline::units::Metre;
use image_crate::{DynamicImage, GrayImage, ImageBuffer, ImageFormat, Luma};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tempfile::TempDir;

use ::image as image_crate;

/// Side of the field of view, m.
const VIEW: f64 = 0.4;

/// A closed curve: radius p + q cos mφ, moved along the tangent by s sin 2mφ (folds that overhang where s is large). m.
#[derive(Debug, Clone, Copy)]
struct Shape {
    p: f64,
    q: f64,
    s: f64,
    m: f64,
}

const SHAPES: [Shape; 5] = [
    Shape { p: 0.130, q: 0.000, s: 0.000, m: 0.0 },
    Shape { p: 0.125, q: 0.040, s: 0.010, m: 4.0 },
    Shape { p: 0.125, q: 0.035, s: 0.022, m: 7.0 },
    Shape { p: 0.130, q: 0.025, s: 0.012, m: 10.0 },
    Shape { p: 0.130, q: 0.020, s: 0.008, m: 14.0 },
];

impl Shape {
    /// A point of the curve; its middle lies off the grid of pixels.
    fn at(self, phi: f64) -> [f64; 2] {
        let angle = self.m * (phi - 0.137);
        let (radius, along) = (self.p + self.q * angle.cos(), self.s * (2.0 * angle).sin());
        [0.2013 + radius * phi.cos() - along * phi.sin(), 0.1978 + radius * phi.sin() + along * phi.cos()]
    }

    fn points(self, n: usize) -> Vec<[f64; 2]> {
        (0..n).map(|i| self.at(TAU * i as f64 / n as f64)).collect()
    }
}

/// Covered share of each of n × n pixels, top row first: exact in x at the crossings of 48 scan lines a pixel with a fine polygon.
fn coverage(polygon: &[[f64; 2]], n: usize) -> Vec<f64> {
    const LINES: usize = 48;
    let pixel = VIEW / n as f64;
    let polygon: Vec<[f64; 2]> = polygon.iter().map(|[x, y]| [x / pixel, n as f64 - y / pixel]).collect();
    let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); n * LINES];
    for (i, a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (low, high) = (a[1].min(b[1]), a[1].max(b[1]));
        let first = (low * LINES as f64 - 0.5).ceil().max(0.0) as usize;
        for (line, found) in crossings.iter_mut().enumerate().skip(first) {
            let y = (line as f64 + 0.5) / LINES as f64;
            if high <= y {
                break;
            }
            found.push(a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]));
        }
    }
    let mut covered = vec![0.0; n * n];
    for (line, found) in crossings.iter_mut().enumerate() {
        found.sort_by(f64::total_cmp);
        for pair in found.chunks_exact(2) {
            for x in (pair[0].max(0.0) as usize)..n.min(pair[1] as usize + 1) {
                let inside = pair[1].min(x as f64 + 1.0) - pair[0].max(x as f64);
                covered[(line / LINES) * n + x] += inside.max(0.0) / LINES as f64;
            }
        }
    }
    covered
}

fn blurred(mut covered: Vec<f64>, n: usize, blur: f64) -> Vec<f64> {
    if blur <= 0.0 {
        return covered;
    }
    let reach = (4.0 * blur).ceil() as isize;
    let weights: Vec<f64> = (-reach..=reach).map(|k| (-0.5 * (k as f64 / blur).powi(2)).exp()).collect();
    let total: f64 = weights.iter().sum();
    let last = n as isize - 1;
    for along_rows in [true, false] {
        let mut next = vec![0.0; n * n];
        for (at, to) in next.iter_mut().enumerate() {
            let (x, y) = ((at % n) as isize, (at / n) as isize);
            let value = |k: isize| match along_rows {
                true => covered[at + (x + k).clamp(0, last) as usize - x as usize],
                false => covered[(y + k).clamp(0, last) as usize * n + x as usize],
            };
            *to = weights.iter().zip(-reach..).map(|(w, k)| w * value(k)).sum::<f64>() / total;
        }
        covered = next;
    }
    covered
}

/// How a picture is taken.
#[derive(Debug, Clone, Copy)]
struct Take {
    /// Of the lens, px.
    blur: f64,
    /// Light object on dark ground.
    light: bool,
    /// Encoded as cameras do.
    srgb: bool,
    /// Light falls by this share from the left to the right, and with the square of the distance from the middle.
    falloff: f64,
    /// Standard deviation, grey levels of 255.
    noise: f64,
    /// Share of pixels that are white or black whatever they see.
    salt: f64,
    jpeg: Option<u8>,
}

const PLAIN: Take = Take { blur: 0.7, light: false, srgb: false, falloff: 0.0, noise: 0.0, salt: 0.0, jpeg: None };

/// Grey values 0…255 of what is seen: light in proportion to the covered area.
fn taken(covered: &[f64], n: usize, take: Take) -> GrayImage {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let (cloth, ground) = if take.light { (0.85, 0.06) } else { (0.05, 0.85) };
    GrayImage::from_fn(n as u32, n as u32, |x, y| {
        let c = covered[y as usize * n + x as usize];
        let (u, v) = (f64::from(x) / n as f64 - 0.5, f64::from(y) / n as f64 - 0.5);
        let lamp = 1.0 - take.falloff * (0.5 * (u + 0.5) + u * u + v * v);
        let light = lamp * (ground + c * (cloth - ground));
        let value = match take.srgb {
            true if light <= 0.0031308 => 12.92 * light,
            true => 1.055 * light.powf(1.0 / 2.4) - 0.055,
            false => light,
        };
        // Sum of twelve uniform numbers: normal to a percent.
        let normal = if 0.0 < take.noise { (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0 } else { 0.0 };
        let mut grey = 255.0 * value + take.noise * normal;
        if 0.0 < take.salt && random.random::<f64>() < take.salt {
            grey = if random.random() { 255.0 } else { 0.0 };
        }
        Luma([grey.round().clamp(0.0, 255.0) as u8])
    })
}

fn saved(folder: &TempDir, picture: &GrayImage, jpeg: Option<u8>) -> PathBuf {
    let path = folder.path().join(if jpeg.is_some() { "drape.jpg" } else { "drape.png" });
    match jpeg {
        None => picture.save(&path).expect("writable"),
        Some(quality) => {
            let mut bytes = Vec::new();
            image_crate::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, quality).encode_image(picture).expect("encodes");
            fs::write(&path, bytes).expect("writable");
        }
    }
    path
}

fn of_pixel(metres: f64) -> Pictures {
    Pictures::of_scale(PictureScale::Pixel(Metre(metres)))
}

fn traced(file: &Path, options: &Pictures) -> Silhouette {
    image::outline(file, options).unwrap_or_else(|e| panic!("{e}"))
}

fn refused(file: &Path, options: &Pictures) -> String {
    match image::outline(file, options) {
        Ok(silhouette) => panic!("{} was traced: {:?}", file.display(), silhouette.reading),
        Err(error) => error.to_string(),
    }
}

fn all_in(text: &str, parts: &[&str]) {
    parts.iter().for_each(|part| assert!(text.contains(part), "“{part}” is not in: {text}"));
}

/// Signed distances of points from a dense closed curve, positive outside, in units of `unit`; both in the same frame.
fn distances(points: &[Point], curve: &[[f64; 2]], unit: f64) -> Vec<f64> {
    // Cells of a hundredth of the view, so that the nearest point is found without asking all.
    const CELLS: usize = 100;
    let cell = |v: f64| ((v / VIEW * CELLS as f64).max(0.0) as usize).min(CELLS - 1);
    let mut cells: Vec<Vec<usize>> = vec![Vec::new(); CELLS * CELLS];
    curve.iter().enumerate().for_each(|(i, c)| cells[cell(c[1]) * CELLS + cell(c[0])].push(i));
    let n = curve.len();
    points
        .iter()
        .map(|p| {
            let (i, j) = (cell(p.x), cell(p.y));
            let near = (j.saturating_sub(1)..=(j + 1).min(CELLS - 1)).flat_map(|j| {
                let cells = &cells;
                (i.saturating_sub(1)..=(i + 1).min(CELLS - 1)).flat_map(move |i| cells[j * CELLS + i].iter().copied())
            });
            let far = |k: usize| (p.x - curve[k][0]).hypot(p.y - curve[k][1]);
            let Some(nearest) = near.min_by(|a, b| far(*a).total_cmp(&far(*b))) else { return f64::INFINITY };
            let (a, b) = (curve[(nearest + n - 1) % n], curve[(nearest + 1) % n]);
            // Counter-clockwise: the outward normal is the tangent turned to the right.
            let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
            ((p.x - curve[nearest][0]) * dy - (p.y - curve[nearest][1]) * dx) / dx.hypot(dy) / unit
        })
        .collect()
}

/// Root mean square, mean, and largest magnitude.
fn summary(distances: &[f64]) -> [f64; 3] {
    let n = distances.len() as f64;
    let mean = distances.iter().sum::<f64>() / n;
    [(distances.iter().map(|d| d * d).sum::<f64>() / n).sqrt(), mean, distances.iter().fold(0.0, |a, d| a.max(d.abs()))]
}

fn length(points: &[[f64; 2]]) -> f64 {
    points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).sum()
}

/// Rms and mean miss of a traced picture, px. The whole curve must have been traced: lengths agree.
fn misses(shape: Shape, n: usize, file: &Path, options: &Pictures) -> [f64; 3] {
    let silhouette = traced(file, options);
    let curve = shape.points(12_000);
    let points: Vec<[f64; 2]> = silhouette.profile.points().iter().map(|p| [p.x, p.y]).collect();
    let (found, true_length) = (length(&points), length(&curve));
    assert!((found / true_length - 1.0).abs() < 0.02, "{shape:?}: {found} m of {true_length} m were traced");
    summary(&distances(silhouette.profile.points(), &curve, VIEW / n as f64))
}

mod accuracy {
    use super::*;

    /// Every shape under every take; the worst rms of each take, px.
    fn table(n: usize, takes: &[(&str, Take)], bound: f64) {
        let folder = TempDir::new().expect("a folder");
        let options = of_pixel(VIEW / n as f64);
        let mut failures = vec![];
        let sharp: Vec<Vec<f64>> = SHAPES.iter().map(|shape| coverage(&shape.points(20_000), n)).collect();
        for (name, take) in takes {
            let mut line = format!("{n} px | {name:<44} |");
            for (shape, covered) in SHAPES.iter().zip(&sharp) {
                let picture = taken(&blurred(covered.clone(), n, take.blur), n, *take);
                let [rms, mean, _] = misses(*shape, n, &saved(&folder, &picture, take.jpeg), &options);
                line.push_str(&format!(" {rms:.3} ({mean:+.3})"));
                if bound < rms {
                    failures.push(format!("{n} px, {name}, m = {}: rms {rms:.4} px", shape.m));
                }
            }
            println!("{line}");
        }
        assert!(failures.is_empty(), "{}", failures.join("\n"));
    }

    #[test]
    fn outlines_at_512_pixels_are_traced_to_a_twentieth_of_a_pixel() {
        table(
            512,
            &[
                ("sharp", Take { blur: 0.0, ..PLAIN }),
                ("blur 0.7", PLAIN),
                ("blur 1.5, light on dark", Take { blur: 1.5, light: true, ..PLAIN }),
                ("blur 0.7, JPEG 90", Take { jpeg: Some(90), ..PLAIN }),
                ("blur 1, JPEG 75, light on dark", Take { blur: 1.0, light: true, jpeg: Some(75), ..PLAIN }),
                ("blur 0.7, sRGB, JPEG 90", Take { srgb: true, jpeg: Some(90), ..PLAIN }),
                ("blur 1, sRGB, light on dark", Take { blur: 1.0, srgb: true, light: true, ..PLAIN }),
                ("blur 0.7, light falls by half", Take { falloff: 0.5, ..PLAIN }),
                ("blur 1, sRGB, light on dark, falls by half", Take { blur: 1.0, srgb: true, light: true, falloff: 0.5, ..PLAIN }),
                ("blur 0.7, noise of 2 levels", Take { noise: 2.0, ..PLAIN }),
                ("blur 0.7, noise of 5 levels", Take { noise: 5.0, ..PLAIN }),
                ("blur 0.7, 0.3 % salt", Take { salt: 0.003, ..PLAIN }),
                (
                    "all: sRGB, falls by 0.3, noise 2, salt, JPEG 90",
                    Take { srgb: true, falloff: 0.3, noise: 2.0, salt: 0.001, jpeg: Some(90), ..PLAIN },
                ),
            ],
            0.05,
        );
    }

    #[test]
    fn outlines_at_256_pixels_in_jpeg_are_traced_to_a_seventh_of_a_pixel() {
        table(
            256,
            &[
                ("sharp, JPEG 75", Take { blur: 0.0, jpeg: Some(75), ..PLAIN }),
                ("blur 0.7, JPEG 75", Take { jpeg: Some(75), ..PLAIN }),
                ("blur 0.7, JPEG 90, light on dark", Take { jpeg: Some(90), light: true, ..PLAIN }),
                ("blur 1, sRGB, JPEG 80", Take { blur: 1.0, srgb: true, jpeg: Some(80), ..PLAIN }),
                ("blur 1, light falls by half, JPEG 80", Take { blur: 1.0, falloff: 0.5, jpeg: Some(80), ..PLAIN }),
                ("blur 0.7, noise 3, JPEG 85", Take { noise: 3.0, jpeg: Some(85), ..PLAIN }),
                ("blur 0.7, 0.2 % salt, JPEG 90", Take { salt: 0.002, jpeg: Some(90), ..PLAIN }),
            ],
            0.15,
        );
    }
}
