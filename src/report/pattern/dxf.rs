//! The pattern as DXF (release 12, ASCII, mm), which every cutter and CAD program reads.
//!
//! Layers: CUT and SEAM (closed polylines whose bulges are exact arcs), FOLD, GRAIN, SCALE, TEXT. The apex of the sector is the origin, y upwards.
//! Source: AutoCAD Release 12 Customization Manual, chapter 11 (Drawing Interchange Files); a bulge is the tangent of a quarter of the arc's angle.

use super::{LETTERS, lettering};
use crate::experiment::Point;
use crate::model::pattern::{Pattern, Stroke};
use crate::units::MILLIMETRE;

/// Layer names and their colour numbers.
const LAYERS: [(&str, u8); 6] = [("CUT", 7), ("SEAM", 5), ("FOLD", 1), ("GRAIN", 3), ("SCALE", 8), ("TEXT", 8)];

/// The drawing.
pub fn dxf(pattern: &Pattern, words: &[String]) -> String {
    let mut out = Pairs::default();
    let (low, high) = pattern.bounds();
    out.section("HEADER", |out| {
        out.text(9, "$ACADVER").text(1, "AC1009");
        // 4: millimetres. Release 12 has no such variable, but programs that know it obey it.
        out.text(9, "$INSUNITS").integer(70, 4);
        out.text(9, "$MEASUREMENT").integer(70, 1);
        out.text(9, "$EXTMIN").point(low);
        out.text(9, "$EXTMAX").point(high);
    });
    out.section("TABLES", |out| {
        out.text(0, "TABLE").text(2, "LTYPE").integer(70, 1);
        out.text(0, "LTYPE").text(2, "CONTINUOUS").integer(70, 0).text(3, "Solid line").integer(72, 65).integer(73, 0).number(40, 0.0);
        out.text(0, "ENDTAB");
        out.text(0, "TABLE").text(2, "LAYER").integer(70, LAYERS.len() as i64);
        for (name, colour) in LAYERS {
            out.text(0, "LAYER").text(2, name).integer(70, 0).integer(62, i64::from(colour)).text(6, "CONTINUOUS");
        }
        out.text(0, "ENDTAB");
    });
    out.section("ENTITIES", |out| {
        out.polyline("CUT", &pattern.cut);
        out.polyline("SEAM", &pattern.seam);
        if let Some((from, to)) = pattern.fold {
            out.line("FOLD", from, to);
        }
        out.line("GRAIN", pattern.grain.0, pattern.grain.1);
        let (place, bar) = lettering(pattern);
        let letters = LETTERS * MILLIMETRE;
        let below = place.y - letters * 1.5 * (0.5 * words.len() as f64 + 1.0);
        out.line("SCALE", Point::new(place.x - 0.5 * bar, below), Point::new(place.x + 0.5 * bar, below));
        for (i, text) in words.iter().enumerate() {
            out.label(text, Point::new(place.x - 0.5 * bar, place.y - letters * 1.5 * (i as f64 - 0.5 * words.len() as f64)));
        }
        out.label(&format!("{} mm", (bar / MILLIMETRE).round()), Point::new(place.x - 0.5 * bar, below - 1.6 * letters));
    });
    out.text(0, "EOF");
    out.0
}

/// Group codes and values, a line each.
#[derive(Default)]
struct Pairs(String);

impl Pairs {
    fn text(&mut self, code: u16, value: &str) -> &mut Self {
        self.0 += &format!("{code:>3}\n{value}\n");
        self
    }

    fn integer(&mut self, code: u16, value: i64) -> &mut Self {
        self.text(code, &value.to_string())
    }

    fn number(&mut self, code: u16, value: f64) -> &mut Self {
        self.text(code, &format!("{value:.9}"))
    }

    /// In millimetres.
    fn point(&mut self, p: Point) -> &mut Self {
        self.number(10, p.x / MILLIMETRE).number(20, p.y / MILLIMETRE)
    }

    fn section(&mut self, name: &str, fill: impl FnOnce(&mut Self)) {
        self.text(0, "SECTION").text(2, name);
        fill(self);
        self.text(0, "ENDSEC");
    }

    fn line(&mut self, layer: &str, from: Point, to: Point) {
        self.text(0, "LINE").text(8, layer).point(from).number(30, 0.0);
        self.number(11, to.x / MILLIMETRE).number(21, to.y / MILLIMETRE).number(31, 0.0);
    }

    /// A closed polyline; a bulge belongs to the vertex that its arc starts from.
    fn polyline(&mut self, layer: &str, strokes: &[Stroke]) {
        self.text(0, "POLYLINE").text(8, layer).integer(66, 1).integer(70, 1);
        self.number(10, 0.0).number(20, 0.0).number(30, 0.0);
        for stroke in strokes.iter().flat_map(Stroke::quarters) {
            let bulge = match stroke {
                Stroke::Line { .. } => 0.0,
                Stroke::Arc { from, to, .. } => (0.25 * (to - from)).tan(),
            };
            self.text(0, "VERTEX").text(8, layer).point(stroke.start()).number(30, 0.0).number(42, bulge);
        }
        self.text(0, "SEQEND").text(8, layer);
    }

    /// Release 12 has no Unicode: what is not ASCII is written by its code.
    fn label(&mut self, text: &str, at: Point) {
        let plain: String = text.chars().map(|c| if c.is_ascii() { c.to_string() } else { format!("\\U+{:04X}", u32::from(c)) }).collect();
        self.text(0, "TEXT").text(8, "TEXT").point(at).number(30, 0.0).number(40, LETTERS).text(1, &plain);
    }
}
