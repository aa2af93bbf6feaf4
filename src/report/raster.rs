//! From a vector figure to a PNG; the only door to the rasterizer.

use std::sync::{Arc, LazyLock};

use png::{BitDepth, ColorType, DeflateCompression, Encoder, Filter, PixelDimensions, Unit};
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

/// The pixels as PNG: without colour as grey; of the few colours of a drawing where that is faithful, which is three times as short and as fast; else of all.
/// The paper is opaque, so alpha is left out.
fn encoded(pixmap: &Pixmap, dpi: f64) -> Result<Vec<u8>, png::EncodingError> {
    let pixels = pixmap.data().as_chunks::<4>().0;
    let grey = pixels.iter().all(|[r, g, b, _]| r == g && g == b);
    let palette = if grey { None } else { Palette::of(pixels) };
    let mut bytes = Vec::with_capacity(pixels.len() / 16);
    let mut encoder = Encoder::new(&mut bytes, pixmap.width(), pixmap.height());
    encoder.set_depth(BitDepth::Eight);
    let per_metre = (dpi / INCH).round() as u32;
    encoder.set_pixel_dims(Some(PixelDimensions { xppu: per_metre, yppu: per_metre, unit: Unit::Meter }));
    // Most rows repeat the one above, and this finds little else: files a fifth longer than with other methods, in a third of the time.
    encoder.set_filter(Filter::Up);
    encoder.set_deflate_compression(DeflateCompression::FdeflateUltraFast);
    let data: Vec<u8> = match &palette {
        Some(palette) => {
            encoder.set_color(ColorType::Indexed);
            encoder.set_palette(palette.colors.iter().flatten().copied().collect::<Vec<u8>>());
            palette.indices(pixels)
        }
        None if grey => {
            encoder.set_color(ColorType::Grayscale);
            pixels.iter().map(|pixel| pixel[0]).collect()
        }
        None => {
            encoder.set_color(ColorType::Rgb);
            pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect()
        }
    };
    encoder.write_header()?.write_image_data(&data)?;
    Ok(bytes)
}

/// At most 256 colours of a picture. Neighbours in colour share the one of them that is seen most: plain lines and areas keep theirs to the level, the shades
/// of their soft edges are off by less than 1/32 of the scale, and the rarest shades, where many colours cross, by at most [`FARTHEST`].
struct Palette {
    colors: Vec<[u8; 3]>,
    /// Place of a colour by its [`coarse`] bits.
    places: Vec<u8>,
}

/// Bits of each level by which colours are told apart.
const BITS: u32 = 5;

/// An eighth of the scale: more than that would be seen.
const FARTHEST: u8 = 32;

/// Share of the pixels that may change their colour at all.
const MOST_CHANGED: f64 = 0.1;

impl Palette {
    /// `None` if some colour would be too far from all of the palette's, or too many would change.
    fn of(pixels: &[[u8; 4]]) -> Option<Palette> {
        /// Colours that share their bits: how many pixels, the one that leads among them and by how many pixels (after Boyer & Moore's majority vote).
        #[derive(Clone, Default)]
        struct Alike {
            seen: usize,
            color: [u8; 3],
            lead: usize,
        }
        let mut all = vec![Alike::default(); 1 << (3 * BITS)];
        let mut start = 0;
        // Paper comes in long runs: one look-up for each.
        while let Some(&[r, g, b, _]) = pixels.get(start) {
            let run = pixels[start..].iter().take_while(|pixel| pixel[..3] == [r, g, b]).count();
            let alike = &mut all[coarse([r, g, b])];
            alike.seen += run;
            if alike.color == [r, g, b] {
                alike.lead += run;
            } else if run <= alike.lead {
                alike.lead -= run;
            } else {
                (alike.color, alike.lead) = ([r, g, b], run - alike.lead);
            }
            start += run;
        }
        let mut order: Vec<usize> = (0..all.len()).filter(|&i| 0 < all[i].seen).collect();
        // The most seen first; equal ones in a fixed order.
        order.sort_by(|&a, &b| all[b].seen.cmp(&all[a].seen).then(a.cmp(&b)));
        let colors: Vec<[u8; 3]> = order.iter().take(256).map(|&i| all[i].color).collect();
        let mut places = vec![0; all.len()];
        for (rank, &i) in order.iter().enumerate() {
            let off = |color: &[u8; 3]| (0..3).map(|k| color[k].abs_diff(all[i].color[k])).max().unwrap_or(0);
            let nearest = || (0..colors.len()).min_by_key(|&c| off(&colors[c])).filter(|&c| off(&colors[c]) <= FARTHEST);
            let place = if rank < colors.len() { Some(rank) } else { nearest() };
            places[i] = u8::try_from(place?).ok()?;
        }
        let palette = Palette { colors, places };
        // Soft edges are few; a picture of many plain shades keeps them all.
        let changed =
            pixels.iter().filter(|&&[r, g, b, _]| palette.colors[usize::from(palette.places[coarse([r, g, b])])] != [r, g, b]).count();
        (changed <= (MOST_CHANGED * pixels.len() as f64) as usize).then_some(palette)
    }

    fn indices(&self, pixels: &[[u8; 4]]) -> Vec<u8> {
        pixels.iter().map(|&[r, g, b, _]| self.places[coarse([r, g, b])]).collect()
    }
}

fn coarse(levels: [u8; 3]) -> usize {
    levels.iter().fold(0, |bits, level| bits << BITS | usize::from(level >> (8 - BITS)))
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
    fn plain_colours_are_kept_to_the_level_and_shades_stay_near() {
        let kept = |pixels: &[[u8; 4]]| -> Option<Vec<[u8; 3]>> {
            let palette = Palette::of(pixels)?;
            Some(palette.indices(pixels).into_iter().map(|i| palette.colors[usize::from(i)]).collect())
        };
        // Plain colours, the rarer one seldom, with a thousand shades about the other.
        let mut edges = vec![[0, 114, 178, 255]; 20_000];
        edges.extend(vec![[222, 222, 222, 255]; 700]);
        edges.extend((0..1000_u32).map(|i| [(i % 10) as u8, (100 + i / 10 % 10) as u8, (170 + i / 100) as u8, 255]));
        let back = kept(&edges).unwrap();
        assert_eq!((back[0], back[20_000]), ([0, 114, 178], [222, 222, 222]));
        assert!(edges.iter().zip(&back).all(|(a, b)| (0..3).all(|k| a[k].abs_diff(b[k]) < 8)));
        // A thousand shades on much paper: some of them share a place, and stay near.
        let mut ramp = vec![[255, 255, 255, 255]; 20_000];
        ramp.extend((0..1000_u32).map(|i| [(i % 256) as u8, (i / 4) as u8, 128, 255]));
        assert!(ramp.iter().zip(kept(&ramp).unwrap()).all(|(a, b)| (0..3).all(|k| a[k].abs_diff(b[k]) <= FARTHEST + 8)));
        // Without the paper they are the picture, and all are kept.
        assert!(kept(&ramp[20_000..]).is_none());
        // So are all colours of the rainbow.
        let all: Vec<[u8; 4]> =
            (0..32_u32.pow(3)).map(|i| [(i % 32 * 8) as u8, (i / 32 % 32 * 8) as u8, (i / 1024 * 8) as u8, 255]).collect();
        assert!(kept(&all).is_none());
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
