//! The pattern as SVG, one user unit to a millimetre.

use super::{LETTERS, Sheet, lettering};
use crate::model::pattern::{Pattern, Stroke};
use crate::units::MILLIMETRE;

/// The whole panel on a sheet of its own size: cut line solid, seam line dashed, fold dash-dotted, grain line with arrow heads.
pub fn svg(pattern: &Pattern, words: &[String]) -> String {
    let sheet = Sheet::of(pattern);
    let (width, height) = (coordinate(sheet.width), coordinate(sheet.height));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" viewBox=\"0 0 {width} {height}\">\n\
         <g fill=\"none\" stroke=\"#000000\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n"
    );
    out += &format!("<path id=\"cut\" stroke-width=\"0.5\" d=\"{}\"/>\n", path(&sheet, &pattern.cut));
    if pattern.seam != pattern.cut {
        out += &format!("<path id=\"seam\" stroke-width=\"0.3\" stroke-dasharray=\"6 3\" d=\"{}\"/>\n", path(&sheet, &pattern.seam));
    }
    let line = |name: &str, from: (f64, f64), to: (f64, f64), style: &str| {
        let [x1, y1, x2, y2] = [from.0, from.1, to.0, to.1].map(coordinate);
        format!("<path id=\"{name}\" {style} d=\"M{x1} {y1}L{x2} {y2}\"/>\n")
    };
    if let Some((from, to)) = pattern.fold {
        out += &line("fold", sheet.at(from), sheet.at(to), "stroke-width=\"0.9\" stroke-dasharray=\"12 3 2 3\"");
    }
    let (from, to) = (sheet.at(pattern.grain.0), sheet.at(pattern.grain.1));
    out += &line("grain", from, to, "stroke-width=\"0.3\"");
    for (tip, way) in [(from, 1.0), (to, -1.0)] {
        for side in [-2.0, 2.0] {
            out += &line("arrow", tip, (tip.0 + side, tip.1 + 6.0 * way), "stroke-width=\"0.3\"").replace(" id=\"arrow\"", "");
        }
    }
    let (place, bar) = lettering(pattern);
    let (x, y) = sheet.at(place);
    let half = 0.5 * bar / MILLIMETRE;
    let below = y + LETTERS * 1.5 * (0.5 * words.len() as f64 + 1.0);
    out += &line("scale", (x - half, below), (x + half, below), "stroke-width=\"0.5\"");
    for end in [x - half, x + half] {
        out += &line("tick", (end, below - 2.0), (end, below + 2.0), "stroke-width=\"0.5\"").replace(" id=\"tick\"", "");
    }
    out += "</g>\n";
    out += &format!("<g font-family=\"DejaVu Sans\" font-size=\"{LETTERS}\" text-anchor=\"middle\" fill=\"#000000\">\n");
    let say = |text: &str, x: f64, y: f64| format!("<text x=\"{}\" y=\"{}\">{}</text>\n", coordinate(x), coordinate(y), escaped(text));
    for (i, text) in words.iter().enumerate() {
        out += &say(text, x, y + LETTERS * 1.5 * (i as f64 - 0.5 * words.len() as f64));
    }
    out += &say(&format!("{} mm", (bar / MILLIMETRE).round()), x, below + 1.6 * LETTERS);
    out + "</g>\n</svg>\n"
}

/// A closed path of lines and arcs.
fn path(sheet: &Sheet, strokes: &[Stroke]) -> String {
    let (x, y) = sheet.at(strokes[0].start());
    let mut d = format!("M{} {}", coordinate(x), coordinate(y));
    for stroke in strokes.iter().flat_map(Stroke::quarters) {
        let (x, y) = sheet.at(stroke.end());
        let (x, y) = (coordinate(x), coordinate(y));
        match stroke {
            Stroke::Line { .. } => d += &format!("L{x} {y}"),
            Stroke::Arc { radius, from, to } => {
                let radius = coordinate(radius / MILLIMETRE);
                // On the sheet y runs down: rising angles turn against the clock still, which SVG calls sweep 0.
                d += &format!("A{radius} {radius} 0 0 {} {x} {y}", u8::from(to < from));
            }
        }
    }
    d + "Z"
}

/// A thousandth of a millimetre is finer than any cutter.
pub(super) fn coordinate(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
