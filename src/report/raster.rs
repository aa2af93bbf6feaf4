//! From a vector figure to a PNG; the only door to the rasterizer.

use std::sync::{Arc, LazyLock};

use png::{BitDepth, ColorType, Compression, Encoder, Filter, PixelDimensions, Unit};
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{self, fontdb};

use crate::error::Error;
use crate::units::INCH;

/// Dots per inch of every picture unless told otherwise, what printers ask for.
pub const DPI: f64 = 300.0;

/// CSS pixels per inch: the unit in which the SVG reader states sizes.
const CSS_DPI: f64 = 96.0;

/// More pixels than an A0 sheet at 300 dpi has are a mistake, and would not fit into memory.
const MOST_PIXELS: f64 = 1.4e8;

/// The SVG as PNG bytes at [`DPI`] on white, its text set in the embedded font. `name` is for messages.
///
/// # Errors
/// [`Error::Output`] if the SVG cannot be read or is too large to draw.
pub fn png(name: &str, svg: &str) -> Result<Vec<u8>, Error> {
    png_at(name, svg, DPI)
}

/// The same at `dpi` dots per inch; the picture says so itself, so that it is printed in its size.
///
/// # Errors
/// As [`png`].
pub fn png_at(name: &str, svg: &str, dpi: f64) -> Result<Vec<u8>, Error> {
    let fault = |why: String| Error::Output { what: name.to_string(), why };
    let options = usvg::Options { fontdb: Arc::clone(&FONTS), font_family: "DejaVu Sans".into(), ..usvg::Options::default() };
    let tree = usvg::Tree::from_str(svg, &options).map_err(|error| fault(error.to_string()))?;
    let scale = dpi / CSS_DPI;
    let size = tree.size();
    let (width, height) = ((f64::from(size.width()) * scale).round(), (f64::from(size.height()) * scale).round());
    if MOST_PIXELS < width * height {
        return Err(fault(format!("{width} × {height} pixels are too many to draw; ask for fewer dots per inch")));
    }
    let undrawable = || fault(format!("{width} × {height} pixels are not drawable; ask for more dots per inch"));
    let mut pixmap = Pixmap::new(width as u32, height as u32).ok_or_else(undrawable)?;
    pixmap.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(scale as f32, scale as f32), &mut pixmap.as_mut());
    encoded(&pixmap, dpi).map_err(|error| fault(error.to_string()))
}

/// The pixels as PNG. The paper is opaque, so alpha is left out; a picture without colour keeps one byte a pixel.
fn encoded(pixmap: &Pixmap, dpi: f64) -> Result<Vec<u8>, png::EncodingError> {
    let pixels = pixmap.data().as_chunks::<4>().0;
    let grey = pixels.iter().all(|[r, g, b, _]| r == g && g == b);
    let data: Vec<u8> =
        if grey { pixels.iter().map(|p| p[0]).collect() } else { pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect() };
    let mut bytes = Vec::with_capacity(data.len() / 16);
    let mut encoder = Encoder::new(&mut bytes, pixmap.width(), pixmap.height());
    encoder.set_color(if grey { ColorType::Grayscale } else { ColorType::Rgb });
    encoder.set_depth(BitDepth::Eight);
    let per_metre = (dpi / INCH).round() as u32;
    encoder.set_pixel_dims(Some(PixelDimensions { xppu: per_metre, yppu: per_metre, unit: Unit::Meter }));
    encoder.set_compression(Compression::Fast);
    // Plain paper: most rows repeat the one above.
    encoder.set_filter(Filter::Up);
    encoder.write_header()?.write_image_data(&data)?;
    Ok(bytes)
}

static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    for data in [dejavu::sans::regular(), dejavu::sans::bold(), dejavu::sans::oblique()] {
        fonts.load_font_source(fontdb::Source::Binary(Arc::new(data)));
    }
    Arc::new(fonts)
});

#[cfg(test)]
mod tests {
    use super::*;

    /// Width and height in a PNG's header (PNG specification, 11.2.2 IHDR).
    fn dimensions(png: &[u8]) -> (u32, u32) {
        let at = |i: usize| u32::from_be_bytes([png[i], png[i + 1], png[i + 2], png[i + 3]]);
        (at(16), at(20))
    }

    #[test]
    fn an_inch_becomes_three_hundred_pixels() {
        let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" width="25.4mm" height="50.8mm"/>"#;
        assert_eq!(dimensions(&png("a.png", svg).unwrap()), (300, 600));
    }

    #[test]
    fn cyrillic_text_leaves_ink() {
        let with = |text: &str| {
            let svg = format!(
                r#"<svg xmlns="http://www.w3.org/2000/svg" width="60" height="20"><text x="2" y="15" font-family="DejaVu Sans" font-size="12">{text}</text></svg>"#
            );
            png("a.png", &svg).unwrap()
        };
        assert_ne!(with("Изгиб"), with(""));
        assert_ne!(with("Изгиб"), with("Ткань"));
    }

    #[test]
    fn what_is_no_svg_is_refused_by_name() {
        let error = png("figures/hem_7.png", "<svg").unwrap_err().to_string();
        assert!(error.contains("figures/hem_7.png"), "{error}");
    }
}
