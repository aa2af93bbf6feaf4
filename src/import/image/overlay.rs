//! What was found, drawn over the picture it was found in, so that a person can see whether it is right.

use std::io::Cursor;
use std::path::Path;

use image::{ImageFormat, Rgb, RgbImage, imageops};

use super::{Marked, Silhouette, open};
use crate::error::{Error, Place};
use crate::units::MILLIMETRE;

/// Longest side of the drawn picture, px: what a screen shows. Small pictures are enlarged by a whole number up to it, so that their pixels show.
const LONGEST: u32 = 1600;
/// Lines are this wide, px.
const WIDTH: f64 = 1.6;

/// Width of the drawing of a picture, px.
pub fn overlay_width(silhouette: &Silhouette) -> usize {
    let [width, _] = drawn(silhouette.size.map(|n| n as u32));
    width as usize
}

/// Size of the drawing of a picture of this size.
fn drawn([width, height]: [u32; 2]) -> [u32; 2] {
    let longest = width.max(height).max(1);
    if longest <= LONGEST {
        let times = (LONGEST / longest).clamp(1, 8);
        return [width * times, height * times];
    }
    let shrunk = |n: u32| ((u64::from(n) * u64::from(LONGEST) + u64::from(longest) / 2) / u64::from(longest)).max(1) as u32;
    [shrunk(width), shrunk(height)]
}

/// The outline in red over its picture, holes in orange, other objects in blue, the disc, bar or board of known size in green, and a bar of a
/// round length at the lower left; PNG bytes. `caption` (PNG bytes, as wide as [`overlay_width`]) is set below it.
///
/// # Errors
/// As [`super::outline`] for the file; [`Error::Input`] if it has changed since; [`Error::Output`] if the caption is no PNG.
pub fn overlay(silhouette: &Silhouette, caption: Option<&[u8]>) -> Result<Vec<u8>, Error> {
    let path: &Path = &silhouette.source.file;
    let photograph = open::open_small(path, LONGEST)?;
    let [width, height] = silhouette.size.map(|n| n as u32);
    let changed = || Error::input(Place::file(path), "the picture has changed since it was traced", "let nothing write to it meanwhile");
    if (width < height) != (photograph.width() < photograph.height()) && width != height {
        return Err(changed());
    }
    let [drawn_width, drawn_height] = drawn([width, height]);
    let photograph = imageops::resize(&photograph, drawn_width, drawn_height, imageops::FilterType::Nearest);
    let failed = |why: String| Error::Output { what: format!("overlay of {}", path.display()), why };
    let caption = match caption {
        Some(bytes) => Some(image::load_from_memory_with_format(bytes, ImageFormat::Png).map_err(|e| failed(e.to_string()))?.to_rgb8()),
        None => None,
    };
    let below = caption.as_ref().map_or(0, RgbImage::height);
    // Paler than the photograph, so that the lines stand out on black too.
    let mut canvas = RgbImage::from_fn(drawn_width, drawn_height + below, |x, y| {
        if y < drawn_height { Rgb(photograph.get_pixel(x, y).0.map(|c| 56 + (u16::from(c) * 25 / 32) as u8)) } else { Rgb([255; 3]) }
    });
    let scale = [f64::from(drawn_width) / f64::from(width.max(1)), f64::from(drawn_height) / f64::from(height.max(1))];
    for of in [Marked::Other, Marked::Hole, Marked::Scale, Marked::Outline] {
        for mark in silhouette.marks.iter().filter(|m| m.of == of) {
            let line: Vec<[f64; 2]> = mark.line.iter().map(|p| [p[0] * scale[0], p[1] * scale[1]]).collect();
            for (a, b) in line.iter().zip(line.iter().cycle().skip(1)) {
                stroke(&mut canvas, *a, *b, WIDTH, colour(of), drawn_height);
            }
        }
    }
    // A length that can be compared with the drape at sight: its label is in the caption.
    let length = rule(silhouette) / silhouette.pixel.0 * scale[0];
    let (x, y) = (12.0, f64::from(drawn_height) - 14.0);
    stroke(&mut canvas, [x - 1.0, y], [x + length + 1.0, y], 6.0, [255; 3], drawn_height);
    stroke(&mut canvas, [x, y], [x + length, y], 3.0, [0; 3], drawn_height);
    if let Some(caption) = caption {
        imageops::replace(&mut canvas, &caption, 0, i64::from(drawn_height));
    }
    let mut bytes = Vec::new();
    canvas.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png).map_err(|e| failed(e.to_string()))?;
    Ok(bytes)
}

/// Length of the bar that is drawn at the lower left of the overlay, m: 1, 2 or 5 times a power of ten, a tenth to a quarter of the picture.
pub fn rule(silhouette: &Silhouette) -> f64 {
    let quarter = 0.25 * silhouette.size[0] as f64 * silhouette.pixel.0 / MILLIMETRE;
    let decade = 10_f64.powf(quarter.log10().floor());
    [5.0, 2.0, 1.0].into_iter().find(|k| k * decade <= quarter).unwrap_or(1.0) * decade * MILLIMETRE
}

fn colour(of: Marked) -> [u8; 3] {
    match of {
        Marked::Outline => [225, 20, 30],
        Marked::Hole => [240, 140, 0],
        Marked::Other => [40, 100, 235],
        Marked::Scale => [0, 165, 70],
    }
}

/// A line with soft edges; only above row `below`.
fn stroke(canvas: &mut RgbImage, a: [f64; 2], b: [f64; 2], width: f64, colour: [u8; 3], below: u32) {
    let half = 0.5 * width;
    let range = |c: usize, end: u32| {
        let low = (a[c].min(b[c]) - half - 1.0).max(0.0);
        let high = (a[c].max(b[c]) + half + 1.0).min(f64::from(end));
        low as u32..high.max(0.0) as u32
    };
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let square = dx * dx + dy * dy;
    for y in range(1, below) {
        for x in range(0, canvas.width()) {
            let (px, py) = (f64::from(x) + 0.5 - a[0], f64::from(y) + 0.5 - a[1]);
            let t = if 0.0 < square { ((px * dx + py * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
            let distance = (px - t * dx).hypot(py - t * dy);
            let cover = (half + 0.5 - distance).clamp(0.0, 1.0);
            if 0.0 < cover {
                let pixel = canvas.get_pixel_mut(x, y);
                for (old, new) in pixel.0.iter_mut().zip(colour) {
                    // Joints of a line are not drawn twice: the darker of both covers.
                    let mixed = f64::from(*old) + cover * (f64::from(new) - f64::from(*old));
                    *old = mixed.round() as u8;
                }
            }
        }
    }
}
