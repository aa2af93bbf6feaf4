//! From a vector figure to a PNG; the only door to the rasterizer.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{self, fontdb};

use crate::error::Error;

/// Dots per inch of every picture, what printers ask for.
pub const DPI: f64 = 300.0;

/// CSS pixels per inch: the unit in which the SVG reader states sizes.
const CSS_DPI: f64 = 96.0;

/// The SVG as PNG bytes at [`DPI`] on white, its text set in the embedded font. `name` is for messages.
///
/// # Errors
/// [`Error::Output`] if the SVG cannot be read or is too large to draw.
pub fn png(name: &str, svg: &str) -> Result<Vec<u8>, Error> {
    let fault = |why: String| Error::Output { what: name.to_string(), why };
    let options = usvg::Options { fontdb: Arc::clone(&FONTS), font_family: "DejaVu Sans".into(), ..usvg::Options::default() };
    let tree = usvg::Tree::from_str(svg, &options).map_err(|error| fault(error.to_string()))?;
    let scale = (DPI / CSS_DPI) as f32;
    let size = tree.size();
    let (width, height) = ((size.width() * scale).round() as u32, (size.height() * scale).round() as u32);
    let mut pixmap = Pixmap::new(width, height).ok_or_else(|| fault(format!("{width} × {height} pixels are not drawable")))?;
    pixmap.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixmap.as_mut());
    pixmap.encode_png().map_err(|error| fault(error.to_string()))
}

/// Whether bytes are a picture of a format, `svg` or `png`, that can be drawn.
///
/// # Errors
/// Why not, in words.
pub fn check(format: &str, bytes: &[u8]) -> Result<(), String> {
    match format {
        "png" => Pixmap::decode_png(bytes).map(drop).map_err(|error| error.to_string()),
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
