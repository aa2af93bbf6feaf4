//! From pixels to a PNG: as grey or of few colours where that is faithful.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, DecodingError, DeflateCompression, Encoder, EncodingError, Filter, PixelDimensions, Unit};
use vello_cpu::Pixmap;

use crate::units::INCH;

/// Red, green, blue.
type Levels = [u8; 3];

/// Neighbouring pixels of one colour.
type Run = (Levels, usize);

/// The pixels as PNG: without colour as grey; of the few colours of a drawing where that is faithful, which is three times as short and as fast; else of all.
/// The paper is opaque, so alpha is left out.
pub fn png(picture: &Pixmap, dpi: f64) -> Result<Vec<u8>, EncodingError> {
    let runs = runs(picture.data_as_u8_slice());
    let count = usize::from(picture.width()) * usize::from(picture.height());
    let grey = runs.iter().all(|([r, g, b], _)| r == g && g == b);
    let palette = if grey { None } else { Palette::of(&runs, count) };
    let mut bytes = Vec::with_capacity(count / 16);
    let mut encoder = Encoder::new(&mut bytes, picture.width().into(), picture.height().into());
    encoder.set_depth(BitDepth::Eight);
    let per_metre = (dpi / INCH).round() as u32;
    encoder.set_pixel_dims(Some(PixelDimensions { xppu: per_metre, yppu: per_metre, unit: Unit::Meter }));
    // Most rows repeat the one above, and this finds little else: files a fifth longer than with other methods, in a third of the time.
    encoder.set_filter(Filter::Up);
    encoder.set_deflate_compression(DeflateCompression::FdeflateUltraFast);
    let data = match palette {
        Some(palette) => {
            encoder.set_color(ColorType::Indexed);
            let data = unrolled(&runs, count, |color| palette.place(color));
            encoder.set_palette(palette.colors.into_flattened());
            data
        }
        None if grey => {
            encoder.set_color(ColorType::Grayscale);
            unrolled(&runs, count, |[level, ..]| level)
        }
        None => {
            encoder.set_color(ColorType::Rgb);
            // Most of it is paper already.
            let mut data = vec![u8::MAX; 3 * count];
            let mut at = 0;
            for &(color, length) in &runs {
                let next = at + 3 * length;
                if color != [u8::MAX; 3] {
                    data[at..next].as_chunks_mut::<3>().0.fill(color);
                }
                at = next;
            }
            data
        }
    };
    encoder.write_header()?.write_image_data(&data)?;
    Ok(bytes)
}

/// Whether bytes are a PNG that can be read to its end.
pub fn check(bytes: &[u8]) -> Result<(), DecodingError> {
    let mut reader = Decoder::new(Cursor::new(bytes)).read_info()?;
    while reader.next_row()?.is_some() {}
    Ok(())
}

/// Paper and areas come in long runs: whatever is done to the pixels is done to these.
fn runs(rgba: &[u8]) -> Vec<Run> {
    /// Pixels that are compared at once.
    const AT_ONCE: usize = 8;
    let mut found = Vec::new();
    let mut rest = rgba;
    while let [r, g, b, a, ..] = *rest {
        let same = [[r, g, b, a]; AT_ONCE];
        let (same, pixel) = (same.as_flattened(), [r, g, b, a]);
        let whole = rest.chunks_exact(4 * AT_ONCE).take_while(|chunk| *chunk == same).count() * AT_ONCE;
        let more = rest[4 * whole..].as_chunks::<4>().0.iter().take(AT_ONCE).take_while(|next| **next == pixel).count();
        found.push(([r, g, b], whole + more));
        rest = &rest[4 * (whole + more)..];
    }
    found
}

/// One byte a pixel.
fn unrolled(runs: &[Run], count: usize, byte: impl Fn(Levels) -> u8) -> Vec<u8> {
    let mut data = Vec::with_capacity(count);
    runs.iter().for_each(|&(color, length)| data.resize(data.len() + length, byte(color)));
    data
}

/// At most 256 colours of a picture. Neighbours in colour share the one of them that is seen most: plain lines and areas keep theirs to the level, the shades
/// of their soft edges are off by less than 1/32 of the scale, and the rarest shades, where many colours cross, by at most [`FARTHEST`].
struct Palette {
    colors: Vec<Levels>,
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
    /// `None` if some colour of the `count` pixels would be too far from all of the palette's, or too many would change.
    fn of(runs: &[Run], count: usize) -> Option<Palette> {
        /// Colours that share their bits: how many pixels, the one that leads among them and by how many pixels (after Boyer & Moore's majority vote).
        #[derive(Clone, Default)]
        struct Alike {
            seen: usize,
            color: Levels,
            lead: usize,
        }
        let mut all = vec![Alike::default(); 1 << (3 * BITS)];
        for &(color, length) in runs {
            let alike = &mut all[coarse(color)];
            alike.seen += length;
            if alike.color == color {
                alike.lead += length;
            } else if length <= alike.lead {
                alike.lead -= length;
            } else {
                (alike.color, alike.lead) = (color, length - alike.lead);
            }
        }
        let mut order: Vec<usize> = (0..all.len()).filter(|&i| 0 < all[i].seen).collect();
        // The most seen first; equal ones in a fixed order.
        order.sort_by(|&a, &b| all[b].seen.cmp(&all[a].seen).then(a.cmp(&b)));
        let colors: Vec<Levels> = order.iter().take(256).map(|&i| all[i].color).collect();
        let mut places = vec![0; all.len()];
        for (rank, &i) in order.iter().enumerate() {
            let off = |color: &Levels| (0..3).map(|k| color[k].abs_diff(all[i].color[k])).max().unwrap_or(0);
            let nearest = || (0..colors.len()).min_by_key(|&c| off(&colors[c])).filter(|&c| off(&colors[c]) <= FARTHEST);
            let place = if rank < colors.len() { Some(rank) } else { nearest() };
            places[i] = u8::try_from(place?).ok()?;
        }
        let palette = Palette { colors, places };
        // Soft edges are few; a picture of many plain shades keeps them all.
        let changed: usize =
            runs.iter().filter(|(color, _)| palette.colors[usize::from(palette.place(*color))] != *color).map(|run| run.1).sum();
        (changed <= (MOST_CHANGED * count as f64) as usize).then_some(palette)
    }

    fn place(&self, color: Levels) -> u8 {
        self.places[coarse(color)]
    }
}

fn coarse(levels: Levels) -> usize {
    levels.iter().fold(0, |bits, level| bits << BITS | usize::from(level >> (8 - BITS)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_colours_are_kept_to_the_level_and_shades_stay_near() {
        let kept = |pixels: &[[u8; 4]]| -> Option<Vec<[u8; 3]>> {
            let runs = runs(pixels.as_flattened());
            let palette = Palette::of(&runs, pixels.len())?;
            Some(unrolled(&runs, pixels.len(), |color| palette.place(color)).into_iter().map(|i| palette.colors[usize::from(i)]).collect())
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
    fn runs_are_the_pixels_in_order() {
        for lengths in [vec![1], vec![7, 8, 9], vec![1, 1, 1], vec![16, 1, 24, 3], vec![1000, 2]] {
            let level = |i: usize| [i as u8, 7, 0, 255];
            let pixels: Vec<[u8; 4]> = lengths.iter().enumerate().flat_map(|(i, &length)| vec![level(i); length]).collect();
            let expected: Vec<Run> = lengths.iter().enumerate().map(|(i, &length)| ([i as u8, 7, 0], length)).collect();
            assert_eq!(runs(pixels.as_flattened()), expected);
        }
    }

    #[test]
    fn a_picture_cut_short_is_no_picture() {
        let bytes = png(&Pixmap::new(30, 20), 72.0).unwrap();
        assert!(check(&bytes).is_ok());
        assert!(check(&bytes[..bytes.len() - 20]).is_err() && check(b"GIF89a").is_err());
    }
}
