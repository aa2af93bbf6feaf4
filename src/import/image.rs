//! Silhouette pictures (PNG, JPEG; 8 or 16 bit) → outline in metres, and the outline laid over the picture for a person to check.
//!
//! Place of a pixel: the picture's lower left corner is the origin, x to the right, y up; the centre of the pixel in column `i` and row `j`
//! (from 0, top row first) is `x = (i + ½)·scale`, `y = (height − j − ½)·scale`.

use std::io::Cursor;
use std::path::Path;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageReader, Limits, Rgb, RgbImage};

use super::cells::one_line;
use super::edge::{self, Edge, Grey};
use super::source;
use crate::error::{Error, Place};
use crate::experiment::Source;
use crate::experiment::campaign::{Pictures, Shade};
use crate::experiment::{DrapeProfile, Point};
use crate::units::Metre;

/// Largest side of a picture, px; it bounds the memory that a header can ask for.
const LARGEST_SIDE: u32 = 20_000;
/// … and so do the bytes of the decoded picture.
const LARGEST_BYTES: u64 = 1 << 30;
/// An outline has at most this many points: more of them repeat the same grey values. At least a pixel apart.
const MOST_POINTS: f64 = 2000.0;

/// A traced picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Silhouette {
    /// m.
    pub profile: DrapeProfile,
    /// Width and height of the picture, px, turned as its camera says.
    pub size: [usize; 2],
    pub source: Source,
    /// What a person should know: grey levels, holes that were filled, other objects.
    pub notes: Vec<String>,
}

/// Whether a file is read as a picture, by its extension.
pub fn is_picture(path: &Path) -> bool {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    extension.is_some_and(|e| ["png", "jpg", "jpeg"].contains(&e.as_str()))
}

/// The outline of the largest object in a picture, evenly spaced at one pixel or more, at most 2000 points.
///
/// Grey values are taken as linear in the covered area. Measured on rendered hems of known shape, blurred up to 1.5 px and compressed: at most
/// 0.05 px rms at 512 px and 0.10 px at 256 px JPEG, mean within 0.02 px (tests/import.rs prints the figures).
///
/// # Errors
/// [`Error::File`] if it cannot be read; [`Error::Input`] if it is no picture, broken, larger than 20 000 px a side, without contrast, or if
/// the object touches the border; [`Error::Invalid`] if the pixel size is no positive number.
pub fn outline(path: &Path, options: &Pictures) -> Result<Silhouette, Error> {
    if !(0.0 < options.pixel.0 && options.pixel.0.is_finite()) {
        return Err(Error::Invalid { quantity: "side of a pixel, m", value: options.pixel.0, allowed: "> 0" });
    }
    let (picture, source) = open(path)?;
    let grey = grey(&picture);
    let object = match options.object {
        Shade::Dark => edge::Object::Dark,
        Shade::Light => edge::Object::Light,
        Shade::Auto => edge::Object::Unlike,
    };
    let edge = edge::trace(&grey, object).map_err(|e| Error::input(Place::file(path), e.problem, e.remedy))?;
    let scale = options.pixel.0;
    let height = grey.height as f64;
    let points: Vec<Point> = evenly_spaced(&edge.points).iter().map(|[x, y]| Point::new(x * scale, (height - y) * scale)).collect();
    let profile = DrapeProfile::new(&points)
        .map_err(|e| Error::input(Place::file(path), e.to_string(), "check the picture: the largest object in it is no drape"))?;
    Ok(Silhouette { profile, size: [grey.width, grey.height], source, notes: notes(&edge) })
}

fn notes(edge: &Edge) -> Vec<String> {
    let shade = if edge.object_is_dark { "dark" } else { "light" };
    let percent = edge.levels.map(|level| 100.0 * level);
    let mut notes = vec![format!("{shade} object, grey levels {:.0} % and {:.0} % of full scale", percent[0], percent[1])];
    if let Some(largest) = edge.holes.iter().max() {
        notes.push(format!("{} hole(s) in the object were filled, the largest of {largest} pixels", edge.holes.len()));
    }
    // Specks of dust and compression are of no interest; a label or a second drape is.
    let others: Vec<usize> = edge.others.iter().copied().filter(|&pixels| edge.pixels < 200 * pixels).collect();
    if let Some(&largest) = others.first() {
        let share = 100.0 * largest as f64 / edge.pixels as f64;
        notes.push(format!("{} other object(s) were left out, the largest {share:.1} % of the size of the outlined one", others.len()));
    }
    notes
}

/// Decodes a picture, turned as its camera says.
fn open(path: &Path) -> Result<(DynamicImage, Source), Error> {
    let (bytes, source) = source::read(path)?;
    let refuse = |why: String| {
        Error::input(Place::file(path), format!("the picture cannot be read ({})", one_line(&why)), "save it again as PNG or JPEG")
    };
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| refuse(e.to_string()))?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST_SIDE);
    limits.max_image_height = Some(LARGEST_SIDE);
    limits.max_alloc = Some(LARGEST_BYTES);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(|e| refuse(e.to_string()))?;
    let turned = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut picture = DynamicImage::from_decoder(decoder).map_err(|e| refuse(e.to_string()))?;
    picture.apply_orientation(turned);
    Ok((picture, source))
}

/// Grey values 0…1; transparent pixels lie on white.
fn grey(picture: &DynamicImage) -> Grey {
    let values = if picture.color().has_alpha() {
        picture.to_luma_alpha32f().pixels().map(|p| p.0[0] * p.0[1] + 1.0 - p.0[1]).collect()
    } else {
        picture.to_luma32f().into_raw()
    };
    Grey { width: picture.width() as usize, height: picture.height() as usize, values }
}

/// Points at equal steps along a closed polygon, a pixel or more apart.
fn evenly_spaced(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let n = points.len();
    let steps: Vec<f64> = (0..n).map(|i| (points[(i + 1) % n][0] - points[i][0]).hypot(points[(i + 1) % n][1] - points[i][1])).collect();
    let length: f64 = steps.iter().sum();
    let count = length.floor().clamp(1.0, MOST_POINTS) as usize;
    let spacing = length / count as f64;
    let (mut at, mut passed) = (0, 0.0);
    (0..count)
        .map(|k| {
            let wanted = k as f64 * spacing;
            while passed + steps[at] < wanted && at + 1 < n {
                passed += steps[at];
                at += 1;
            }
            let share = if 0.0 < steps[at] { (wanted - passed) / steps[at] } else { 0.0 };
            let (a, b) = (points[at], points[(at + 1) % n]);
            [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
        })
        .collect()
}

/// Writes the outline (m, as [`outline`] gives it) in red over its picture, enlarged so that fractions of a pixel can be seen; PNG.
///
/// # Errors
/// As [`outline`] for the picture; [`Error::Output`] if the PNG cannot be written.
pub fn overlay(picture: &Path, outline: &[Point], pixel: Metre, to: &Path) -> Result<(), Error> {
    const WANTED: u32 = 1024;
    let (photograph, _) = open(picture)?;
    let enlarged = (WANTED / photograph.width().max(photograph.height()).max(1)).clamp(1, 8);
    let photograph = photograph.to_rgb8();
    let mut canvas = RgbImage::from_fn(photograph.width() * enlarged, photograph.height() * enlarged, |x, y| {
        // Paler than the photograph, so that the line stands out on black too.
        let Rgb(colour) = *photograph.get_pixel(x / enlarged, y / enlarged);
        Rgb(colour.map(|c| 64 + c / 4 * 3))
    });
    let factor = f64::from(enlarged) / pixel.0;
    let height = f64::from(canvas.height());
    // Thick enough to survive the shrinking of a large picture to a screen.
    let thickness = (canvas.width().max(canvas.height()) / 700).max(1);
    for (i, a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        let steps = (2.0 * a.distance(b) * factor).ceil().clamp(1.0, 1e4) as usize;
        for k in 0..steps {
            let share = k as f64 / steps as f64;
            let (x, y) = ((a.x + share * (b.x - a.x)) * factor, height - (a.y + share * (b.y - a.y)) * factor);
            if !(0.0 <= x && 0.0 <= y && x < f64::from(canvas.width()) && y < height) {
                continue;
            }
            for (dx, dy) in (0..thickness).flat_map(|dx| (0..thickness).map(move |dy| (dx, dy))) {
                if let Some(colour) = canvas.get_pixel_mut_checked(x as u32 + dx, y as u32 + dy) {
                    *colour = Rgb([220, 30, 30]);
                }
            }
        }
    }
    let failed = |why: String| Error::Output { what: to.display().to_string(), why };
    let mut bytes = Vec::new();
    canvas.write_to(&mut Cursor::new(&mut bytes), image::ImageFormat::Png).map_err(|e| failed(e.to_string()))?;
    std::fs::write(to, bytes).map_err(|e| failed(e.to_string()))
}
