//! The pattern as PDF at true scale: on one sheet of its own size, or on sheets that are glued together.

use std::collections::BTreeMap;

use super::svg::{coordinate, svg};
use super::{LETTERS, MARGIN, Paper, Sheet, lettering};
use crate::error::Error;
use crate::model::pattern::{Pattern, Stroke};
use crate::report::typeset::{self, Manuscript};

/// Neighbouring sheets share a strip this wide, to glue them by, mm.
const OVERLAP: f64 = 10.0;
/// Largest side of a page, mm: 14 400 points, the limit of PDF 1.7, annex C.
const LARGEST: f64 = 14_400.0 * 25.4 / 72.0;

/// The drawing of [`svg`] on `paper`. Sheets that nothing is drawn on are left out.
///
/// # Errors
/// [`Error::Unanswerable`] if the pattern is larger than a page can be; [`Error::Output`] if it cannot be set.
pub fn pdf(pattern: &Pattern, words: &[String], paper: Paper) -> Result<Vec<u8>, Error> {
    let sheet = Sheet::of(pattern);
    let template = match paper {
        Paper::Whole if LARGEST < sheet.width.max(sheet.height) => {
            return Err(Error::Unanswerable("the pattern is longer than a page can be (5 m): print it in tiles".into()));
        }
        Paper::Whole => {
            let (width, height) = (coordinate(sheet.width), coordinate(sheet.height));
            format!("#set page(width: {width}mm, height: {height}mm, margin: 0mm)\n#image(\"pattern.svg\", width: {width}mm)\n")
        }
        Paper::Tiles { width, height } => tiles(pattern, &sheet, words.len(), width, height),
    };
    let template = format!("#set document(title: \"Flat pattern of a skirt\", date: none)\n{template}");
    let files = BTreeMap::from([("pattern.svg".to_string(), svg(pattern, words).into_bytes())]);
    typeset::pdf(Manuscript { template, files, date: None })
}

/// One page for each tile that something is drawn on: a window of the drawing within a frame to cut or glue along, and its place in words.
fn tiles(pattern: &Pattern, sheet: &Sheet, lines: usize, width: f64, height: f64) -> String {
    let (wide, high) = (width - 2.0 * MARGIN, height - 2.0 * MARGIN);
    let count = |length: f64, tile: f64| ((length - OVERLAP) / (tile - OVERLAP)).ceil().max(1.0) as usize;
    let (columns, rows) = (count(sheet.width, wide), count(sheet.height, high));
    // Everything drawn, as points no further apart than a tile is wide.
    let mut drawn: Vec<(f64, f64)> =
        pattern.cut.iter().chain(&pattern.seam).flat_map(|s: &Stroke| s.points(200)).map(|p| sheet.at(p)).collect();
    let (place, bar) = lettering(pattern);
    let (x, y) = sheet.at(place);
    let (half, high_up) = (0.5 * bar / crate::units::MILLIMETRE, LETTERS * (1.0 + lines as f64));
    drawn.extend([-1.0, 0.0, 1.0].iter().flat_map(|i| [-1.0, 0.0, 1.0].map(|j| (x + i * half, y + j * high_up))));
    let mut pages = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let (left, top) = (column as f64 * (wide - OVERLAP), row as f64 * (high - OVERLAP));
            let within = |(x, y): &(f64, f64)| left <= *x && *x <= left + wide && top <= *y && *y <= top + high;
            if drawn.iter().any(within) {
                pages.push((row, column, left, top));
            }
        }
    }
    let total = pages.len();
    let [wide, high] = [wide, high].map(coordinate);
    let mut out = format!(
        "#set page(width: {}mm, height: {}mm, margin: 0mm)\n#set text(font: \"DejaVu Sans\", size: 8pt)\n",
        coordinate(width),
        coordinate(height)
    );
    // Both sides: a picture of which only one is given is cut to the window that it stands in.
    let (drawing, tall) = (coordinate(sheet.width), coordinate(sheet.height));
    for (i, (row, column, left, top)) in pages.into_iter().enumerate() {
        let [left, top] = [left, top].map(|v| coordinate(-v));
        if 0 < i {
            out += "#pagebreak()\n";
        }
        out += &format!(
            "#place(top + left, dx: {MARGIN}mm, dy: {MARGIN}mm, box(width: {wide}mm, height: {high}mm, clip: true, \
             place(top + left, dx: {left}mm, dy: {top}mm, image(\"pattern.svg\", width: {drawing}mm, height: {tall}mm))))\n\
             #place(top + left, dx: {MARGIN}mm, dy: {MARGIN}mm, rect(width: {wide}mm, height: {high}mm, stroke: (paint: gray, thickness: 0.2mm, dash: \"dashed\")))\n\
             #place(top + left, dx: {MARGIN}mm, dy: 4mm)[row {} of {rows}, column {} of {columns} (sheet {} of {total}); frames overlap by {OVERLAP} mm; print at 100 %]\n",
            row + 1,
            column + 1,
            i + 1,
        );
    }
    out
}
