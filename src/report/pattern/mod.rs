//! The flat pattern as a drawing to scale: SVG, PDF and DXF, in millimetres.

mod dxf;
mod pdf;
mod svg;

use std::path::{Path, PathBuf};

use super::output;
use crate::error::Error;
use crate::experiment::Point;
use crate::model::pattern::{Pattern, Stroke};
use crate::units::MILLIMETRE;

pub use dxf::dxf;
pub use pdf::pdf;
pub use svg::svg;

/// White margin round the pattern on a sheet of its own size, mm.
pub const MARGIN: f64 = 10.0;
/// Height of the lettering, mm: readable on cloth.
const LETTERS: f64 = 5.0;

/// Paper that a pattern is printed on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Paper {
    /// One sheet as large as the pattern.
    Whole,
    /// Sheets of this width and height, mm, that are glued together.
    Tiles { width: f64, height: f64 },
}

impl Paper {
    pub const A4: Paper = Paper::Tiles { width: 210.0, height: 297.0 };
    pub const A3: Paper = Paper::Tiles { width: 297.0, height: 420.0 };
    pub const LETTER: Paper = Paper::Tiles { width: 215.9, height: 279.4 };
}

/// Writes the pattern to `path`, whose ending says the format; `words` are printed on the panel, one line each.
///
/// # Errors
/// [`Error::Unanswerable`] for an ending other than .svg, .pdf or .dxf; [`Error::File`], [`Error::Output`] if it cannot be written.
pub fn write(pattern: &Pattern, words: &[String], paper: Paper, path: &Path) -> Result<PathBuf, Error> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let bytes = match ending.as_deref() {
        Some("svg") => svg(pattern, words).into_bytes(),
        Some("pdf") => pdf(pattern, words, paper)?,
        Some("dxf") => dxf(pattern, words).into_bytes(),
        _ => {
            let why = format!("{}: a pattern is written as .svg, .pdf or .dxf", path.display());
            return Err(Error::Unanswerable(why));
        }
    };
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    output::write(path.parent().unwrap_or(Path::new("")), &name, &bytes)
}

/// Where things stand on a sheet of the pattern's own size: mm, x to the right, y down.
struct Sheet {
    width: f64,
    height: f64,
    left: f64,
    top: f64,
}

impl Sheet {
    fn of(pattern: &Pattern) -> Self {
        let (low, high) = pattern.bounds();
        let mm = |length: f64| length / MILLIMETRE;
        Sheet {
            width: mm(high.x - low.x) + 2.0 * MARGIN,
            height: mm(high.y - low.y) + 2.0 * MARGIN,
            left: mm(low.x) - MARGIN,
            top: mm(high.y) + MARGIN,
        }
    }

    fn at(&self, p: Point) -> (f64, f64) {
        (p.x / MILLIMETRE - self.left, self.top - p.y / MILLIMETRE)
    }
}

/// Where the lettering stands: its anchor (m) beside the grain line, and the length of the bar that tells the scale, m.
fn lettering(pattern: &Pattern) -> (Point, f64) {
    let middle = |stroke: &Stroke| stroke.points(2)[1];
    let (waist, hem) = (middle(&pattern.seam[0]), middle(&pattern.seam[2]));
    let right = middle(&pattern.seam[1]);
    // Half-way down, between the grain line and the right side.
    let (x, y) = (pattern.grain.0.x, 0.5 * (waist.y + hem.y));
    let room = right.x - x;
    let place = Point::new(x + 0.5 * room, y);
    let bar = [100.0, 50.0, 20.0, 10.0].map(|mm| mm * MILLIMETRE).into_iter().find(|bar| 1.4 * bar <= room);
    (place, bar.unwrap_or(10.0 * MILLIMETRE))
}
