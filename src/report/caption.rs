//! Lines of text as a picture, to be set below another one.

use super::raster::{self, DPI};
use crate::error::Error;

/// Height of a line and size of its letters, px.
const LINE: f64 = 21.0;
const SIZE: f64 = 15.0;
/// Mean width of a letter of this size, px: lines are broken by it.
const LETTER: f64 = 8.2;

/// The lines, broken at words to a width in pixels, black on white; PNG bytes.
///
/// # Errors
/// [`Error::Output`] if they cannot be drawn.
pub fn png(lines: &[String], width: usize) -> Result<Vec<u8>, Error> {
    let most = ((width as f64 - 24.0) / LETTER).max(12.0) as usize;
    let broken: Vec<String> = lines.iter().flat_map(|line| broken(line, most)).collect();
    let height = LINE * broken.len() as f64 + 10.0;
    // The rasterizer takes sizes in points of 1/96 inch.
    let unit = 96.0 / DPI;
    let text: String = broken
        .iter()
        .enumerate()
        .map(|(k, line)| format!("<text x=\"12\" y=\"{}\">{}</text>", LINE * (k as f64 + 1.0), escaped(line)))
        .collect();
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"DejaVu Sans\" font-size=\"{SIZE}\">{text}</svg>",
        width as f64 * unit,
        height * unit
    );
    raster::png("caption", &svg)
}

/// Pieces of at most `most` letters; a longer word stands alone.
fn broken(line: &str, most: usize) -> Vec<String> {
    let mut pieces = vec![String::new()];
    for word in line.split_whitespace() {
        let last = pieces.last_mut().expect("one at least");
        if !last.is_empty() && most < last.chars().count() + 1 + word.chars().count() {
            pieces.push(format!("    {word}"));
        } else {
            if !last.is_empty() {
                last.push(' ');
            }
            last.push_str(word);
        }
    }
    pieces
}

fn escaped(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_broken_at_words_and_keep_every_one() {
        let line = "dark object, grey levels 12 % and 85 % of full scale";
        let pieces = broken(line, 20);
        assert!(pieces.iter().all(|p| p.chars().count() <= 24), "{pieces:?}");
        assert_eq!(pieces.join(" ").split_whitespace().collect::<Vec<_>>().join(" "), line);
    }

    #[test]
    fn names_with_markup_in_them_are_text() {
        assert!(png(&["a<b>&\"c\u{1}.png".into()], 400).is_ok());
    }
}
