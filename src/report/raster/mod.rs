//! From a vector figure to a PNG; the only door to the rasterizer.

mod canvas;
mod encoding;

use std::sync::{Arc, LazyLock};

use usvg::fontdb;

use crate::error::Error;

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
    let most = f64::from(u16::MAX);
    if MOST_PIXELS < width * height || most < width.max(height) {
        return Err(fault(format!("{width} × {height} pixels are too many to draw; ask for fewer dots per inch")));
    }
    if width.min(height) < 1.0 {
        return Err(fault(format!("{width} × {height} pixels are not drawable; ask for more dots per inch")));
    }
    let picture = canvas::painted(&tree, (width as u16, height as u16), scale).map_err(fault)?;
    encoding::png(&picture, dpi).map_err(|error| fault(error.to_string()))
}

/// Whether bytes are a picture of a format, `svg` or `png`, that can be drawn.
///
/// # Errors
/// Why not, in words.
pub fn check(format: &str, bytes: &[u8]) -> Result<(), String> {
    match format {
        "png" => encoding::check(bytes).map_err(|error| error.to_string()),
        _ => usvg::Tree::from_data(bytes, &usvg::Options::default()).map(drop).map_err(|error| error.to_string()),
    }
}

static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    let condensed = [dejavu::sans_condensed::regular(), dejavu::sans_condensed::bold()];
    for data in [dejavu::sans::regular(), dejavu::sans::bold(), dejavu::sans::oblique()].into_iter().chain(condensed) {
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
    fn a_picture_says_how_large_it_is() {
        let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" width="25.4mm" height="50.8mm"/>"#;
        for (dpi, per_metre) in [(300.0, 11811_u32), (72.0, 2835)] {
            let picture = png_at("a.png", svg, dpi).unwrap();
            let at = picture.windows(4).position(|four| four == b"pHYs").unwrap() + 4;
            // Across, down, and that it is per metre (PNG specification, 11.3.4.3 pHYs).
            assert_eq!(picture[at..at + 4], per_metre.to_be_bytes());
            assert_eq!(picture[at + 4..at + 9], [&per_metre.to_be_bytes()[..], &[1]].concat());
        }
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
