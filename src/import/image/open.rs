//! Picture files: bytes → pixels, turned as the camera says, within bounds; truncated and unknown ones refused.

use std::io::Cursor;
use std::path::Path;

use image::error::ImageFormatHint;
use image::metadata::Orientation;
use image::{DynamicImage, ImageBuffer, ImageDecoder, ImageError, ImageReader, Limits, Luma, RgbImage, imageops};

use super::super::cells::one_line;
use super::super::source;
use super::level::Grey;
use crate::error::{Error, Place};
use crate::experiment::Source;

/// Largest side of a picture, px, and most pixels: they bound the memory that a header can ask for.
const LARGEST_SIDE: u32 = 20_000;
const MOST_PIXELS: u64 = 100_000_000;
/// … and so do the bytes of the decoded picture (sixteen-bit colour of 100 megapixels: 0.6 GB).
const LARGEST_BYTES: u64 = 1 << 30;
/// Larger pictures are averaged over squares of 2 × 2, 3 × 3 … pixels before they are traced: 100 bytes a pixel then stay below 1.6 GB.
const TRACED_PIXELS: u64 = 16_000_000;
/// What the reader knows.
const READ: &[&str] = &["png", "jpg", "jpeg", "jpe", "tif", "tiff", "bmp"];
/// Pictures that it does not know, so that they are refused as such.
const KNOWN: &[&str] = &["heic", "heif", "webp", "gif", "avif", "jp2", "jxl", "dng", "cr2", "nef", "arw", "psd", "svg"];

/// A picture, ready to be traced.
pub(super) struct Opened {
    /// Grey values as stored, not yet light; transparent pixels lie on white.
    pub grey: Grey,
    /// Each of its pixels is the mean of a square of this many pixels a side.
    pub averaged: usize,
    /// Width and height of the picture, px, turned.
    pub size: [usize; 2],
    pub source: Source,
    /// Whether a camera says that it took it: its grey values then follow sRGB.
    pub photograph: bool,
    pub notes: Vec<String>,
}

/// Whether a file is taken for a picture, by its extension.
pub fn is_picture(path: &Path) -> bool {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    extension.is_some_and(|e| READ.contains(&e.as_str()) || KNOWN.contains(&e.as_str()))
}

/// Reads a picture for tracing.
pub(super) fn open(path: &Path) -> Result<Opened, Error> {
    let (bytes, source) = source::read(path)?;
    let Decoded { picture, turned, photograph, mut notes } = decode(path, bytes)?;
    let pixels = u64::from(picture.width()) * u64::from(picture.height());
    let averaged = (1..).find(|k| pixels <= TRACED_PIXELS * k * k).unwrap_or(1) as usize;
    if 1 < averaged {
        notes.push(format!("{} × {} pixels, averaged {averaged} × {averaged} before tracing", picture.width(), picture.height()));
    }
    let grey = averaged_grey(&picture, averaged as u32);
    let mut size = [picture.width() as usize, picture.height() as usize];
    drop(picture);
    let grey = match turned {
        Orientation::NoTransforms => grey,
        Orientation::Rotate90 => imageops::rotate90(&grey),
        Orientation::Rotate180 => imageops::rotate180(&grey),
        Orientation::Rotate270 => imageops::rotate270(&grey),
        Orientation::FlipHorizontal => imageops::flip_horizontal(&grey),
        Orientation::FlipVertical => imageops::flip_vertical(&grey),
        Orientation::Rotate90FlipH => imageops::flip_horizontal(&imageops::rotate90(&grey)),
        Orientation::Rotate270FlipH => imageops::flip_horizontal(&imageops::rotate270(&grey)),
    };
    if turned != Orientation::NoTransforms {
        if matches!(turned.to_exif(), 5..=8) {
            size.reverse();
        }
        notes.push(format!("turned as its camera says (orientation {})", turned.to_exif()));
    }
    let grey = Grey { width: grey.width() as usize, height: grey.height() as usize, values: grey.into_raw() };
    Ok(Opened { grey, averaged, size, source, photograph, notes })
}

/// The picture in colour, turned, its longer side at most `longest` pixels.
pub(super) fn open_small(path: &Path, longest: u32) -> Result<RgbImage, Error> {
    let (bytes, _) = source::read(path)?;
    let Decoded { mut picture, turned, .. } = decode(path, bytes)?;
    if longest < picture.width().max(picture.height()) {
        picture = picture.thumbnail(longest, longest);
    }
    picture.apply_orientation(turned);
    if picture.color().has_alpha() {
        let on_white = picture.to_rgba8();
        return Ok(RgbImage::from_fn(on_white.width(), on_white.height(), |x, y| {
            let [r, g, b, a] = on_white.get_pixel(x, y).0.map(u16::from);
            image::Rgb([r, g, b].map(|c| ((c * a + 255 * (255 - a)) / 255) as u8))
        }));
    }
    Ok(picture.to_rgb8())
}

struct Decoded {
    picture: DynamicImage,
    turned: Orientation,
    photograph: bool,
    notes: Vec<String>,
}

fn decode(path: &Path, bytes: Vec<u8>) -> Result<Decoded, Error> {
    const AGAIN: &str = "save it again as PNG, JPEG, TIFF or BMP";
    let refuse = |problem: String, remedy: &str| Error::input(Place::file(path), problem, remedy);
    let broken = |error: ImageError| match error {
        ImageError::Limits(_) => refuse(
            "its header asks for more pixels than any photograph has".into(),
            "pictures of at most 20 000 pixels a side, 100 megapixels in all, are read; check the file",
        ),
        ImageError::Unsupported(what) if matches!(what.format_hint(), ImageFormatHint::Unknown) => {
            refuse("the picture cannot be read (it begins like none that is known)".into(), AGAIN)
        }
        ImageError::Unsupported(what) => {
            refuse(format!("this kind of picture is not read ({})", one_line(&what.to_string())), "save it as PNG or JPEG, grey or RGB")
        }
        other => refuse(format!("the picture cannot be read ({})", one_line(&other.to_string())), AGAIN),
    };
    if bytes.is_empty() {
        return Err(refuse("the picture cannot be read (the file is empty)".into(), AGAIN));
    }
    if let Some(kind) = foreign(&bytes) {
        return Err(refuse(format!("a {kind} picture is not read"), "export it as JPEG, PNG or TIFF"));
    }
    if let Some([width, height]) = header_size(&bytes)
        && (width == 0 || height == 0)
    {
        return Err(refuse(format!("a picture of {width} × {height} pixels"), AGAIN));
    }
    let large = |[width, height]: [u32; 2]| LARGEST_SIDE < width.max(height) || MOST_PIXELS < u64::from(width) * u64::from(height);
    let too_large = |[width, height]: [u32; 2]| {
        refuse(
            format!("its header says {width} × {height} pixels"),
            "pictures of at most 20 000 pixels a side, 100 megapixels in all, are read; reduce it, or check the file",
        )
    };
    if let Some(size) = header_size(&bytes)
        && large(size)
    {
        return Err(too_large(size));
    }
    if bytes.starts_with(&[0xff, 0xd8]) && !jpeg_ends(&bytes) {
        return Err(refuse(
            "the picture cannot be read (the file ends in the middle of the picture)".into(),
            "copy it again from the camera",
        ));
    }
    let mut notes = Vec::new();
    if let Some(pages) = further_pages(&bytes) {
        notes.push(format!("{pages}; the first is read"));
    }
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| broken(ImageError::IoError(e)))?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(LARGEST_BYTES);
    reader.limits(limits.clone());
    let mut decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    if large([width, height]) {
        return Err(too_large([width, height]));
    }
    if LARGEST_BYTES < decoder.total_bytes() {
        return Err(refuse(
            format!("{width} × {height} pixels of {} bytes", decoder.color_type().bytes_per_pixel()),
            "reduce it to 8 bits",
        ));
    }
    decoder.set_limits(limits).map_err(broken)?;
    // A damaged note about the camera does not spoil the picture.
    let turned = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let photograph = decoder.exif_metadata().ok().flatten().is_some_and(|exif| names_camera(&exif));
    let picture = DynamicImage::from_decoder(decoder).map_err(broken)?;
    Ok(Decoded { picture, turned, photograph, notes })
}

/// Formats that laboratories have and the reader has not, by their first bytes.
fn foreign(bytes: &[u8]) -> Option<&'static str> {
    let at = |from: usize, text: &[u8]| bytes.get(from..from + text.len()) == Some(text);
    match () {
        () if at(4, b"ftyphei") || at(4, b"ftypmif1") || at(4, b"ftyphev") => Some("HEIC (iPhone)"),
        () if at(4, b"ftypavif") => Some("AVIF"),
        () if at(0, b"RIFF") && at(8, b"WEBP") => Some("WebP"),
        () if at(0, b"GIF8") => Some("GIF"),
        () if at(0, b"8BPS") => Some("Photoshop"),
        () if at(4, b"jP  ") => Some("JPEG 2000"),
        () if at(0, b"%PDF") => Some("PDF"),
        () => None,
    }
}

/// Width and height in the header of a PNG, BMP or TIFF, whatever their size: the decoders only say that they are too large.
fn header_size(bytes: &[u8]) -> Option<[u32; 2]> {
    let word = |at: usize| bytes.get(at..at + 4)?.try_into().ok();
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.get(12..16) == Some(b"IHDR") {
        return Some([u32::from_be_bytes(word(16)?), u32::from_be_bytes(word(20)?)]);
    }
    if bytes.starts_with(b"BM") && 40 <= u32::from_le_bytes(word(14)?) {
        return Some([i32::from_le_bytes(word(18)?).unsigned_abs(), i32::from_le_bytes(word(22)?).unsigned_abs()]);
    }
    let little = little_endian(bytes)?;
    let number = |at: usize, length: usize| number(bytes, little, at, length);
    let first = number(4, 4)?;
    let entries: Vec<usize> = (0..number(first, 2)?).map(|k| first + 2 + 12 * k).collect();
    // ImageWidth and ImageLength, each SHORT (3) or LONG (4).
    let side = |tag: usize| {
        let at = *entries.iter().find(|&&at| number(at, 2) == Some(tag))?;
        u32::try_from(number(at + 8, if number(at + 2, 2)? == 3 { 2 } else { 4 })?).ok()
    };
    Some([side(256)?, side(257)?])
}

/// Whether a JPEG goes on to its end marker. The decoder fills what is missing with grey, which has an outline too.
fn jpeg_ends(bytes: &[u8]) -> bool {
    let mut at = 2;
    while at + 1 < bytes.len() {
        if bytes[at] != 0xff {
            // Between segments: data of a scan, in which 0xff is followed by 0 or a restart marker.
            at += 1;
            continue;
        }
        match bytes[at + 1] {
            0xd9 => return true,
            0xff => at += 1,
            0x00 | 0x01 | 0xd0..=0xd8 => at += 2,
            _ => match bytes.get(at + 2..at + 4) {
                Some(length) => at += 2 + usize::from(u16::from_be_bytes([length[0], length[1]])),
                None => return false,
            },
        }
    }
    false
}

/// What a TIFF or PNG holds beside its first picture.
fn further_pages(bytes: &[u8]) -> Option<String> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        let mut at = 8;
        while let Some(head) = bytes.get(at..at + 8) {
            match &head[4..] {
                b"acTL" => return Some("an animated PNG".into()),
                b"IDAT" => return None,
                _ => at = at.checked_add(12 + u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize)?,
            }
        }
        return None;
    }
    let little = little_endian(bytes)?;
    let number = |at: usize, length: usize| number(bytes, little, at, length);
    // A circle of pages ends at the bound.
    const MOST: usize = 1000;
    let mut page = number(4, 4)?;
    let mut pages = 0;
    while page != 0 && pages < MOST {
        pages += 1;
        page = number(page, 2).and_then(|entries| number(page + 2 + 12 * entries, 4)).unwrap_or(0);
    }
    (1 < pages).then(|| format!("a TIFF of {}{pages} pages", if pages == MOST { "at least " } else { "" }))
}

/// Byte order of a TIFF; `None` if it is none.
fn little_endian(bytes: &[u8]) -> Option<bool> {
    [(&b"II*\0"[..], true), (&b"MM\0*"[..], false)].into_iter().find(|(mark, _)| bytes.starts_with(mark)).map(|(_, little)| little)
}

/// A number of a TIFF.
fn number(bytes: &[u8], little: bool, at: usize, length: usize) -> Option<usize> {
    let bytes = bytes.get(at..at.checked_add(length)?)?;
    let fold = |n: usize, b: &u8| n << 8 | usize::from(*b);
    Some(if little { bytes.iter().rev().fold(0, fold) } else { bytes.iter().fold(0, fold) })
}

/// Whether the first directory of EXIF data (a TIFF) names the maker or model of a camera.
fn names_camera(exif: &[u8]) -> bool {
    const MAKE: usize = 0x010f;
    const MODEL: usize = 0x0110;
    let find = || {
        let little = little_endian(exif)?;
        let first = number(exif, little, 4, 4)?;
        let entries = number(exif, little, first, 2)?;
        (0..entries).map(|k| number(exif, little, first + 2 + 12 * k, 2)).find(|tag| matches!(tag, Some(MAKE | MODEL) | None)).flatten()
    };
    find().is_some()
}

/// Grey values 0…1 (luma of Rec. 709), mean over squares of `k` pixels a side; what does not fill a square at the right and below is left out.
fn averaged_grey(picture: &DynamicImage, k: u32) -> ImageBuffer<Luma<f32>, Vec<f32>> {
    fn mean<P: image::Pixel>(
        picture: &ImageBuffer<P, Vec<P::Subpixel>>,
        k: u32,
        grey: impl Fn(&[P::Subpixel]) -> f32,
    ) -> ImageBuffer<Luma<f32>, Vec<f32>> {
        let (width, height) = (picture.width() / k, picture.height() / k);
        let mut sums = vec![0.0; width as usize * height as usize];
        for (y, row) in picture.rows().enumerate().take((height * k) as usize) {
            let line = &mut sums[y / k as usize * width as usize..][..width as usize];
            for (x, pixel) in row.enumerate().take((width * k) as usize) {
                line[x / k as usize] += grey(pixel.channels());
            }
        }
        let share = 1.0 / (k * k) as f32;
        sums.iter_mut().for_each(|sum| *sum *= share);
        ImageBuffer::from_raw(width, height, sums).expect("one value for each pixel")
    }
    let luma = |r: f32, g: f32, b: f32| 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let on_white = |grey: f32, alpha: f32| grey * alpha + 1.0 - alpha;
    let (byte, word) = (|v: u8| f32::from(v) / 255.0, |v: u16| f32::from(v) / 65535.0);
    let clean = |v: f32| if v.is_finite() { v.clamp(0.0, 1.0) } else { 0.0 };
    match picture {
        DynamicImage::ImageLuma8(p) => mean(p, k, |c| byte(c[0])),
        DynamicImage::ImageLumaA8(p) => mean(p, k, |c| on_white(byte(c[0]), byte(c[1]))),
        DynamicImage::ImageRgb8(p) => mean(p, k, |c| luma(byte(c[0]), byte(c[1]), byte(c[2]))),
        DynamicImage::ImageRgba8(p) => mean(p, k, |c| on_white(luma(byte(c[0]), byte(c[1]), byte(c[2])), byte(c[3]))),
        DynamicImage::ImageLuma16(p) => mean(p, k, |c| word(c[0])),
        DynamicImage::ImageLumaA16(p) => mean(p, k, |c| on_white(word(c[0]), word(c[1]))),
        DynamicImage::ImageRgb16(p) => mean(p, k, |c| luma(word(c[0]), word(c[1]), word(c[2]))),
        DynamicImage::ImageRgba16(p) => mean(p, k, |c| on_white(luma(word(c[0]), word(c[1]), word(c[2])), word(c[3]))),
        DynamicImage::ImageRgb32F(p) => mean(p, k, |c| luma(clean(c[0]), clean(c[1]), clean(c[2]))),
        other => mean(&other.to_rgba32f(), k, |c| on_white(luma(clean(c[0]), clean(c[1]), clean(c[2])), clean(c[3]))),
    }
}
