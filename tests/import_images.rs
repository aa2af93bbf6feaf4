//! Pictures: outlines of known shape, rendered here or encoded elsewhere, are traced to fractions of a pixel; what cannot be traced is refused.

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use hemline::experiment::Point;
use hemline::experiment::campaign::{CameraHeight, PictureScale, Pictures, Shade, Tone};
use hemline::import::image::{self, Marked, Silhouette};
use hemline::units::Metre;
use image_crate::{GrayImage, ImageFormat, Luma};
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

/// A picture of 400 × 400 pixels: light 0…1 at each place (x, y), m, mean over 6 × 6 points a pixel; `seen` takes a place in the picture (px,
/// x to the right, y down) to the plane.
fn rendered(light: impl Fn(f64, f64) -> f64, seen: impl Fn(f64, f64) -> [f64; 2]) -> GrayImage {
    const POINTS: u32 = 6;
    GrayImage::from_fn(SCENE, SCENE, |x, y| {
        let mut sum = 0.0;
        for (i, j) in (0..POINTS).flat_map(|i| (0..POINTS).map(move |j| (i, j))) {
            let part = |k: u32| (f64::from(k) + 0.5) / f64::from(POINTS);
            let [u, v] = seen(f64::from(x) + part(i), f64::from(y) + part(j));
            sum += light(u, v);
        }
        Luma([(255.0 * sum / f64::from(POINTS * POINTS)).round() as u8])
    })
}

const SCENE: u32 = 400;
/// Side of a pixel of the scenes, m, looked at straight.
const PIXEL: f64 = 1e-3;

fn straight(x: f64, y: f64) -> [f64; 2] {
    [x * PIXEL, 0.4 - y * PIXEL]
}

/// Whether a place is under a hem of five folds about (0.24, 0.16).
fn under_hem(x: f64, y: f64) -> bool {
    let (x, y) = (x - 0.2413, y - 0.1578);
    x.hypot(y) < 0.100 + 0.020 * (5.0 * y.atan2(x)).cos()
}

/// Radius of the circle of the same area as [`under_hem`]: π(p² + q²/2).
fn hem_radius() -> f64 {
    (0.100_f64.powi(2) + 0.5 * 0.020_f64.powi(2)).sqrt()
}

/// Radius of the circle of the same area as the traced outline, m.
fn radius_of(silhouette: &Silhouette) -> f64 {
    let points = silhouette.profile.points();
    let pairs = points.iter().zip(points.iter().cycle().skip(1));
    (0.5 * pairs.map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>() / (0.5 * TAU)).sqrt()
}

fn disc_at(x0: f64, y0: f64, radius: f64) -> impl Fn(f64, f64) -> bool {
    move |x, y| (x - x0).hypot(y - y0) < radius
}

/// Black squares of 12 mm, seven by five, from (0.02, 0.33) down; `None` off the board.
fn board(x: f64, y: f64) -> Option<bool> {
    let (i, j) = (((x - 0.02) / 0.012).floor(), ((0.33 - y) / 0.012).floor());
    ((0.0..7.0).contains(&i) && (-5.0..0.0).contains(&j)).then(|| ((i + j) as i64).rem_euclid(2) == 0)
}

/// A camera tilted so that a pixel's size changes along x and y.
fn tilted(x: f64, y: f64) -> [f64; 2] {
    let w = 1.0 + 3.0e-4 * (x - 200.0) - 2.0e-4 * (y - 200.0);
    [0.2 + (x - 200.0) * PIXEL / w, 0.2 - (y - 200.0) * PIXEL / w]
}

mod scales {
    use super::*;

    /// Reads the scene; the hem's size must be right within three standard errors of the scale, and the error as small as `worst`.
    fn check(name: &str, picture: &GrayImage, scale: PictureScale, worst: f64) -> Silhouette {
        let folder = TempDir::new().expect("a folder");
        let silhouette = traced(&saved(&folder, picture, None), &Pictures::of_scale(scale));
        let error = silhouette.relative_standard_error.expect("found in the picture");
        let off = radius_of(&silhouette) / hem_radius() - 1.0;
        println!(
            "{name:<28} | {:+.3} % off, standard error {:.3} % | {}",
            100.0 * off,
            100.0 * error,
            silhouette.reading.last().expect("a scale")
        );
        assert!(error <= worst, "{error}");
        assert!(off.abs() <= 3.0 * error, "{off} with a standard error of {error}");
        assert!(silhouette.marks.iter().any(|mark| mark.of == Marked::Scale));
        silhouette
    }

    #[test]
    fn a_disc_beside_the_drape_on_it_or_of_its_own_grey_gives_the_scale() {
        let (beside, on_it) = (disc_at(0.061, 0.342, 0.0300), disc_at(0.2413, 0.1578, 0.0450));
        let dark = |x, y| if under_hem(x, y) || beside(x, y) { 0.05 } else { 0.85 };
        check("disc of 60 mm beside", &rendered(dark, straight), PictureScale::Disc(Metre(0.060)), 3e-3);
        let light = |x, y| if under_hem(x, y) || beside(x, y) { 0.85 } else { 0.05 };
        check("the same, light on dark", &rendered(light, straight), PictureScale::Disc(Metre(0.060)), 3e-3);
        let plate = |x, y| if under_hem(x, y) && !on_it(x, y) { 0.05 } else { 0.85 };
        check("white plate of 90 mm on it", &rendered(plate, straight), PictureScale::Disc(Metre(0.090)), 3e-3);
        let own_grey = |x, y| match (on_it(x, y), under_hem(x, y)) {
            (true, _) => 0.25,
            (_, true) => 0.05,
            _ => 0.85,
        };
        check("grey plate of 90 mm on it", &rendered(own_grey, straight), PictureScale::Disc(Metre(0.090)), 3e-3);
    }

    #[test]
    fn a_bar_gives_the_scale_however_it_lies() {
        for degrees in [0.0_f64, 31.0, 90.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let bar = move |x: f64, y: f64| {
                let (x, y) = (x - 0.075, y - 0.325);
                (x * cos + y * sin).abs() < 0.050 && (y * cos - x * sin).abs() < 0.0045
            };
            let scene = |x, y| if under_hem(x, y) || bar(x, y) { 0.05 } else { 0.85 };
            check(&format!("bar of 100 mm at {degrees}°"), &rendered(scene, straight), PictureScale::Bar(Metre(0.100)), 3e-3);
        }
    }

    #[test]
    fn a_checkerboard_gives_the_scale_and_takes_a_tilt_away() {
        let scene = |x, y| match board(x, y) {
            Some(black) => {
                if black {
                    0.05
                } else {
                    0.85
                }
            }
            None => {
                if under_hem(x, y) {
                    0.05
                } else {
                    0.85
                }
            }
        };
        let even = check("checkerboard, straight", &rendered(scene, straight), PictureScale::Checkerboard(Metre(0.012)), 1e-2);
        assert!(even.notes.iter().all(|note| !note.contains("tilted")), "{:?}", even.notes);
        let oblique = check("checkerboard, tilted", &rendered(scene, tilted), PictureScale::Checkerboard(Metre(0.012)), 1e-2);
        assert!(oblique.notes.iter().any(|note| note.contains("tilted")), "{:?}", oblique.notes);
        // The outline itself, turned and moved onto the true one: what is left is the error of the plane, as `check` allows it for the size:
        // three standard errors, of 0.1 m.
        let points = oblique.profile.points();
        let n = points.len() as f64;
        let middle = [points.iter().map(|p| p.x).sum::<f64>() / n, points.iter().map(|p| p.y).sum::<f64>() / n];
        let left = |turn: f64| {
            let polar: Vec<(f64, f64)> = points
                .iter()
                .map(|p| (p.x - middle[0], p.y - middle[1]))
                .map(|(x, y)| (y.atan2(x), x.hypot(y) - 0.100 - 0.020 * (5.0 * (y.atan2(x) - turn)).cos()))
                .collect();
            let [cos, sin] = [f64::cos, f64::sin].map(|f| 2.0 / n * polar.iter().map(|(a, d)| d * f(*a)).sum::<f64>());
            summary(&polar.iter().map(|(a, d)| d - cos * a.cos() - sin * a.sin()).collect::<Vec<_>>())[0]
        };
        let best = (-100..=100).map(|k| left(f64::from(k) * 0.002)).fold(f64::INFINITY, f64::min);
        println!("checkerboard, tilted         | {:.2} mm rms from the true outline", best / 1e-3);
        assert!(best < 3.0 * 0.1 * oblique.relative_standard_error.expect("found"), "{best}");
    }

    #[test]
    fn the_heights_of_camera_and_hem_shrink_and_stretch_by_similar_triangles() {
        let folder = TempDir::new().expect("a folder");
        let file = saved(&folder, &rendered(|x, y| if under_hem(x, y) { 0.05 } else { 0.85 }, straight), None);
        let plain = of_pixel(PIXEL);
        let size = |hem: f64| {
            let height = Some(CameraHeight { camera: Metre(1.5), hem: Metre(hem) });
            radius_of(&traced(&file, &Pictures { height, ..plain })) / radius_of(&traced(&file, &plain))
        };
        // (H − h)/H: 0.15 m above the plane of the scale a hem looks a tenth too large, 0.15 m below a tenth too small.
        assert!((size(0.15) - 0.9).abs() < 1e-12 && (size(-0.15) - 1.1).abs() < 1e-12 && (size(0.0) - 1.0).abs() < 1e-12);
        let wrong = |camera: f64, hem: f64| {
            refused(&file, &Pictures { height: Some(CameraHeight { camera: Metre(camera), hem: Metre(hem) }), ..plain })
        };
        all_in(&wrong(0.0, -0.1), &["height of the camera", "> 0"]);
        all_in(&wrong(1.0, 1.0), &["height of the hem", "less than the camera's"]);
    }

    #[test]
    fn a_scale_that_is_not_there_or_not_fit_for_use_is_refused_with_numbers() {
        let folder = TempDir::new().expect("a folder");
        let refusal = |light: &dyn Fn(f64, f64) -> f64, seen: &dyn Fn(f64, f64) -> [f64; 2], scale| {
            refused(&saved(&folder, &rendered(light, seen), None), &Pictures::of_scale(scale))
        };
        let only = |x, y| if under_hem(x, y) { 0.05 } else { 0.85 };
        all_in(&refusal(&only, &straight, PictureScale::Disc(Metre(0.06))), &["drape.png", "no disc was found", "plain disc"]);
        all_in(&refusal(&only, &straight, PictureScale::Bar(Metre(0.1))), &["no bar was found", "four times as long"]);
        all_in(&refusal(&only, &straight, PictureScale::Checkerboard(Metre(0.01))), &["no checkerboard was found", "4 × 4 squares"]);
        // The same hem and disc, seen at 30°.
        let disc = disc_at(0.065, 0.335, 0.035);
        let both = |x, y| if under_hem(x, y) || disc(x, y) { 0.05 } else { 0.85 };
        let slanting = |x: f64, y: f64| [x * PIXEL, 0.2 + (200.0 - y) * PIXEL / 30_f64.to_radians().cos()];
        all_in(&refusal(&both, &slanting, PictureScale::Disc(Metre(0.07))), &["ellipse", "tilted by about 30°", "checkerboard"]);
    }
}

mod files {
    use super::*;

    /// The hem of scripts/picture_fixtures.py.
    fn hem() -> Vec<[f64; 2]> {
        let at = |phi: f64| {
            let radius = 0.125 + 0.030 * (6.0 * (phi - 0.137)).cos();
            [0.2013 + radius * phi.cos(), 0.1978 + radius * phi.sin()]
        };
        (0..12_000).map(|i| at(TAU * f64::from(i) / 12_000.0)).collect()
    }

    fn folder() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/images")
    }

    #[test]
    fn pictures_of_other_encoders_are_traced_as_well_as_our_own() {
        // Bounds at 256 px: lossless 0.05 px; JPEG 0.15 px; 64 grey levels of a palette are 0.01 px of edge.
        for (name, bound, said) in [
            ("pillow_75.jpg", 0.15, ""),
            ("magick_progressive_85.jpg", 0.15, ""),
            ("phone_orientation_6.jpg", 0.15, "orientation 6"),
            ("pillow_cmyk.jpg", 0.15, ""),
            ("magick_cmyk.jpg", 0.15, ""),
            ("pillow_palette.png", 0.05, ""),
            ("magick_16.png", 0.05, ""),
            ("pillow_alpha.png", 0.05, ""),
            ("magick_lzw_16.tif", 0.05, ""),
            ("magick_zip_rgb.tif", 0.05, ""),
            ("pillow_16.tif", 0.05, ""),
            ("pillow_two_pages.tif", 0.05, "a TIFF of 2 pages; the first is read"),
            ("pillow_8.bmp", 0.05, ""),
            ("animated.png", 0.05, "an animated PNG; the first is read"),
        ] {
            let silhouette = traced(&folder().join(name), &of_pixel(VIEW / 256.0));
            let [rms, mean, most] = summary(&distances(silhouette.profile.points(), &hem(), VIEW / 256.0));
            println!("{name:<28} | rms {rms:.3}, mean {mean:+.3}, most {most:.3} px | {}", silhouette.reading[0]);
            assert!(rms <= bound, "{name}: {rms} px");
            all_in(&silhouette.notes.join("; "), &[said]);
        }
    }

    #[test]
    fn kinds_that_are_not_read_are_refused_by_name() {
        let file = |name: &str| refused(&folder().join(name), &of_pixel(1e-3));
        all_in(&file("pillow_gif.gif"), &["pillow_gif.gif", "GIF", "export it as JPEG"]);
        all_in(&file("pillow_palette.tif"), &["pillow_palette.tif", "not read", "grey or RGB"]);
        let scratch = TempDir::new().expect("a folder");
        let heic = scratch.path().join("photo.HEIC");
        fs::write(&heic, b"\0\0\0\x18ftypheic\0\0\0\0mif1heic").expect("writable");
        assert!(image::is_picture(&heic));
        all_in(&refused(&heic, &of_pixel(1e-3)), &["photo.HEIC", "HEIC", "export it as JPEG"]);
    }

    #[test]
    fn truncated_files_and_impossible_headers_are_refused_in_one_sentence() {
        let scratch = TempDir::new().expect("a folder");
        let with = |name: &str, bytes: &[u8]| {
            let path = scratch.path().join(name);
            fs::write(&path, bytes).expect("writable");
            let text = refused(&path, &of_pixel(1e-3));
            assert!(text.contains(name) && text.len() < 400 && !text.contains('\n'), "{text}");
            text
        };
        for name in ["pillow_75.jpg", "magick_progressive_85.jpg", "magick_16.png", "magick_lzw_16.tif", "pillow_8.bmp"] {
            let bytes = fs::read(folder().join(name)).expect("shipped");
            for share in [0.1, 0.5, 0.95] {
                all_in(&with(name, &bytes[..(share * bytes.len() as f64) as usize]), &["cannot be read"]);
            }
        }
        all_in(&with("empty.png", b""), &["the file is empty"]);
        all_in(&with("text.jpg", b"this is no picture"), &["cannot be read", "save it again"]);
        let mut png = fs::read(folder().join("magick_16.png")).expect("shipped");
        // Width and height of a PNG, and the checksum of its header, which is not looked at before the size.
        png[16..24].copy_from_slice(&[0x3b, 0x9a, 0xca, 0x00, 0x3b, 0x9a, 0xca, 0x00]);
        all_in(&with("huge.png", &png), &["1000000000 × 1000000000 pixels", "20 000 pixels a side"]);
        png[16..24].copy_from_slice(&[0; 8]);
        all_in(&with("nothing.png", &png), &["0 × 0 pixels"]);
        let mut bmp = fs::read(folder().join("pillow_8.bmp")).expect("shipped");
        bmp[18..26].copy_from_slice(&[0x00, 0xca, 0x9a, 0x3b, 0x00, 0xca, 0x9a, 0x3b]);
        all_in(&with("huge.bmp", &bmp), &["1000000000 × 1000000000 pixels"]);
        let mut tiff = fs::read(folder().join("pillow_16.tif")).expect("shipped");
        // Little-endian entries 256 (width) and 257 (height) of the first directory, of type LONG or SHORT: made LONG 10⁹.
        let first = u32::from_le_bytes([tiff[4], tiff[5], tiff[6], tiff[7]]) as usize;
        for entry in (first + 2..).step_by(12).take(usize::from(u16::from_le_bytes([tiff[first], tiff[first + 1]]))) {
            if matches!(u16::from_le_bytes([tiff[entry], tiff[entry + 1]]), 256 | 257) {
                tiff[entry + 2..entry + 4].copy_from_slice(&4_u16.to_le_bytes());
                tiff[entry + 8..entry + 12].copy_from_slice(&1_000_000_000_u32.to_le_bytes());
            }
        }
        all_in(&with("huge.tif", &tiff), &["1000000000 × 1000000000 pixels"]);
    }

    #[test]
    fn damaged_pictures_are_traced_or_refused_and_never_a_panic() {
        let scratch = TempDir::new().expect("a folder");
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let names = [
            "pillow_75.jpg",
            "magick_progressive_85.jpg",
            "pillow_palette.png",
            "magick_lzw_16.tif",
            "pillow_two_pages.tif",
            "pillow_8.bmp",
        ];
        let scales = [
            PictureScale::Pixel(Metre(1e-3)),
            PictureScale::Disc(Metre(0.1)),
            PictureScale::Bar(Metre(0.1)),
            PictureScale::Checkerboard(Metre(0.01)),
        ];
        for name in names {
            let sound = fs::read(folder().join(name)).expect("shipped");
            for k in 0..12 {
                let mut bytes = sound.clone();
                for _ in 0..random.random_range(1..5) {
                    // Half of the damage to the header.
                    let end = if random.random() { bytes.len().min(200) } else { bytes.len() };
                    bytes[random.random_range(0..end)] = random.random();
                }
                let path = scratch.path().join(name);
                fs::write(&path, bytes).expect("writable");
                let _ = image::outline(&path, &Pictures::of_scale(scales[k % 4]));
            }
        }
    }

    #[test]
    fn a_picture_of_seventeen_megapixels_is_averaged_and_says_so() {
        let scratch = TempDir::new().expect("a folder");
        let n = 4112;
        let picture = GrayImage::from_fn(n, n, |x, y| {
            let (x, y) = ((f64::from(x) + 0.5) * VIEW / f64::from(n) - 0.2, (f64::from(y) + 0.5) * VIEW / f64::from(n) - 0.2);
            Luma([if x.hypot(y) < 0.13 { 20 } else { 220 }])
        });
        let silhouette = traced(&saved(&scratch, &picture, None), &of_pixel(VIEW / f64::from(n)));
        all_in(&silhouette.notes.join("; "), &["averaged 2 × 2"]);
        // A disc of hard pixels: its mean radius is known to a hundredth of a pixel of the file.
        assert!((radius_of(&silhouette) - 0.13).abs() < 0.05 * VIEW / f64::from(n), "{}", radius_of(&silhouette));
        assert_eq!(silhouette.size, [4112, 4112]);
    }
}

mod objects {
    use super::*;

    fn shape_at(n: usize) -> Vec<f64> {
        blurred(coverage(&SHAPES[1].points(20_000), n), n, 0.7)
    }

    #[test]
    fn holes_are_filled_and_other_objects_left_out_and_all_is_said_and_marked() {
        let folder = TempDir::new().expect("a folder");
        let mut picture = taken(&shape_at(512), 512, PLAIN);
        for (x, y) in (0..9).flat_map(|x| (0..9).map(move |y| (x, y))) {
            picture.put_pixel(252 + x, 250 + y, Luma([230]));
        }
        for (x, y) in (0..40).flat_map(|x| (0..20).map(move |y| (x, y))) {
            picture.put_pixel(8 + x, 8 + y, Luma([20]));
        }
        let file = saved(&folder, &picture, None);
        let options = of_pixel(VIEW / 512.0);
        assert!(misses(SHAPES[1], 512, &file, &options)[0] <= 0.05);
        let silhouette = traced(&file, &options);
        all_in(&silhouette.notes.join("\n"), &["1 hole(s)", "81 pixels", "1 other object(s)"]);
        let count = |of| silhouette.marks.iter().filter(|mark| mark.of == of).count();
        assert_eq!((count(Marked::Outline), count(Marked::Hole), count(Marked::Other)), (1, 1, 1));
    }

    #[test]
    fn two_drapes_of_nearly_the_same_size_are_said() {
        let folder = TempDir::new().expect("a folder");
        let (one, two) = (disc_at(0.1, 0.2, 0.080), disc_at(0.3, 0.2, 0.078));
        let file = saved(&folder, &rendered(|x, y| if one(x, y) || two(x, y) { 0.05 } else { 0.85 }, straight), None);
        let silhouette = traced(&file, &of_pixel(PIXEL));
        assert!((radius_of(&silhouette) - 0.080).abs() < 1e-4);
        all_in(&silhouette.notes.join("\n"), &["95.", "look whether the right one"]);
    }

    #[test]
    fn pictures_without_an_outline_are_refused_with_a_remedy() {
        let folder = TempDir::new().expect("a folder");
        let refusal = |picture: &GrayImage, object: Shade| refused(&saved(&folder, picture, None), &Pictures { object, ..of_pixel(1e-3) });
        let sound = taken(&shape_at(256), 256, PLAIN);
        let touching = image_crate::imageops::crop_imm(&sound, 0, 128, 256, 128).to_image();
        all_in(&refusal(&touching, Shade::Dark), &["drape.png", "touches the border", "background all round"]);
        all_in(&refusal(&sound, Shade::Light), &["touches the border", "correct object"]);
        all_in(&refusal(&GrayImage::from_pixel(64, 64, Luma([90])), Shade::Auto), &["same grey level"]);
        let faint = GrayImage::from_fn(128, 128, |x, y| Luma([if x.abs_diff(64).max(y.abs_diff(64)) < 30 { 128 } else { 120 }]));
        all_in(&refusal(&faint, Shade::Auto), &["differ by only", "contrast"]);
        all_in(&refusal(&GrayImage::new(3, 3), Shade::Auto), &["3 × 3 pixels"]);
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let noise = GrayImage::from_fn(256, 256, |_, _| Luma([random.random()]));
        all_in(&refusal(&noise, Shade::Auto), &["no two groups"]);
        // Noise of two levels only: two groups, but no object.
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let dots = GrayImage::from_fn(256, 256, |_, _| Luma([if random.random() { 20 } else { 220 }]));
        all_in(&refusal(&dots, Shade::Auto), &["falls into", "parts"]);
        let gradient = GrayImage::from_fn(256, 256, |x, _| Luma([x as u8]));
        all_in(&refusal(&gradient, Shade::Auto), &["drape.png"]);
    }

    #[test]
    fn a_given_tone_is_taken() {
        let folder = TempDir::new().expect("a folder");
        let round = blurred(coverage(&SHAPES[0].points(20_000), 256), 256, 0.7);
        let file = saved(&folder, &taken(&round, 256, Take { srgb: true, ..PLAIN }), None);
        let size = |tone| radius_of(&traced(&file, &Pictures { tone, ..of_pixel(VIEW / 256.0) })) / (VIEW / 256.0);
        // Read as linear the dark object loses a third of a pixel all round (closed form: the mean of encoded erf, 0.33 px for this blur).
        assert!((size(Tone::Srgb) - size(Tone::Linear) - 0.33).abs() < 0.05, "{} {}", size(Tone::Srgb), size(Tone::Linear));
        assert_eq!(size(Tone::Auto), size(Tone::Srgb));
    }
}

mod overlays {
    use super::*;

    #[test]
    fn the_red_line_lies_on_the_edge_of_the_picture() {
        let folder = TempDir::new().expect("a folder");
        let covered = blurred(coverage(&SHAPES[1].points(20_000), 256), 256, 0.5);
        let file = saved(&folder, &taken(&covered, 256, PLAIN), None);
        let silhouette = traced(&file, &of_pixel(VIEW / 256.0));
        let bytes = image::overlay(&silhouette, None).unwrap_or_else(|e| panic!("{e}"));
        let overlay = image_crate::load_from_memory_with_format(&bytes, ImageFormat::Png).expect("a PNG").to_rgb8();
        assert_eq!((overlay.width() as usize, overlay.width()), (image::overlay_width(&silhouette), 1536));
        let source = image_crate::open(&file).expect("a picture").to_luma8();
        let red: Vec<(u32, u32)> =
            overlay.enumerate_pixels().filter(|(_, _, p)| 200 < p.0[0] && p.0[1] < 50).map(|(x, y, _)| (x / 6, y / 6)).collect();
        assert!(3000 < red.len(), "{} red pixels", red.len());
        // Among the source pixels around every red one there are dark and light ones.
        for (x, y) in red {
            let around = (x - 2..=x + 2).flat_map(|i| (y - 2..=y + 2).map(move |j| (i, j))).map(|(i, j)| source.get_pixel(i, j).0[0]);
            let (low, high) = around.fold((255, 0), |(low, high), v| (low.min(v), high.max(v)));
            assert!(low < 100 && 130 < high, "at {x}, {y}");
        }
    }

    #[test]
    fn fit_and_run_write_one_for_every_picture() {
        let folder = TempDir::new().expect("a folder");
        let beside = disc_at(0.061, 0.342, 0.0300);
        let scene = rendered(|x, y| if under_hem(x, y) || beside(x, y) { 0.05 } else { 0.85 }, straight);
        let hemline = |arguments: &[&str]| {
            let output = Command::new(env!("CARGO_BIN_EXE_hemline")).current_dir(folder.path()).args(arguments).output().expect("runs");
            (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
        };
        fs::create_dir(folder.path().join("campaign")).expect("writable");
        scene.save(folder.path().join("campaign/a.png")).expect("writable");
        scene.save(folder.path().join("campaign/b.tif")).expect("writable");
        let (code, said) = hemline(&["fit", "campaign/a.png", "campaign/b.tif", "--disc-mm", "60", "--overlay", "look", "--folds", "5"]);
        assert_eq!(code, Some(0), "{said}");
        all_in(&said, &["disc of", "mm/px ±", "drawn: look"]);
        let drawn = |folder: PathBuf| {
            let mut names: Vec<_> = fs::read_dir(folder).expect("written").map(|f| f.expect("readable").path()).collect();
            names.sort();
            for name in &names {
                assert!(image_crate::open(name).expect("a picture").width() == 1600, "{}", name.display());
            }
            names.len()
        };
        assert_eq!(drawn(folder.path().join("look")), 2);
        let (code, said) = hemline(&["fit", "campaign/a.png", "--disc-mm", "60", "--bar-mm", "60"]);
        assert_eq!(code, Some(2), "{said}");
        let (_, said) = hemline(&["fit", "campaign/a.png"]);
        all_in(&said, &["--scale-mm-per-px", "--checkerboard-mm"]);
        let toml = "title = \"t\"\norigin = \"made for a test\"\napparatus = \"drapemeter\"\n[geometry]\nsupport_radius_cm = 4\nspecimen_radius_cm = 15\n\
                    [[factors]]\nname = \"a\"\nlow = 0\nhigh = 1\n[profiles]\ndisc_mm = 60\ncamera_height_mm = 1500\nhem_height_mm = -50\n[analysis]\nfolds = 5\n";
        fs::write(folder.path().join("campaign/campaign.toml"), toml).expect("writable");
        fs::write(folder.path().join("campaign/design.csv"), "run,a,profile\n1,-1,a.png\n2,1,b.tif\n").expect("writable");
        let (code, said) = hemline(&["run", "campaign", "--out", "report", "--no-pictures"]);
        assert_eq!(code, Some(0), "{said}");
        assert_eq!(drawn(folder.path().join("report/overlays")), 2);
        let imported = hemline::import::load(&folder.path().join("campaign")).unwrap_or_else(|e| panic!("{e}"));
        all_in(&imported.notes.join("\n"), &["the scale was found in 2 picture(s)", "relative standard error at most"]);
        fs::write(folder.path().join("campaign/campaign.toml"), toml.replace("hem_height_mm = -50", "bar_mm = 100")).expect("writable");
        let (_, said) = hemline(&["run", "campaign", "--out", "report"]);
        all_in(&said, &["campaign.toml, row", "two scales", "“disc_mm” and “bar_mm”"]);
    }
}
