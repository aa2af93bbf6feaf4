//! The cone and its flat pattern, fields on draped surfaces, and their export: against closed forms, and read back by independent readers.

use std::f64::consts::{PI, TAU};

use hemline::experiment::Skirt;
use hemline::model::pattern::{Options as PatternOptions, Pattern};
use hemline::model::skirt::{Cone, from_body};
use hemline::report::pattern::{Paper, dxf, pdf, svg};
use hemline::units::Metre;

fn table_one() -> Skirt {
    from_body(Metre(0.76), Metre(1.04), Metre(0.20), Metre(0.53)).unwrap()
}

/// A quarter panel with allowances of 15, 10 and 30 mm.
fn quarter() -> Pattern {
    let options = PatternOptions { panels: 4, seam_allowance: 0.015, waist_allowance: 0.010, hem_allowance: 0.030, ..PatternOptions::default() };
    Pattern::of(&Cone::of(&table_one()), &options).unwrap()
}

/// The closed polylines of a drawing, by layer: vertices (x, y, bulge), mm. Reads group codes and values as the format defines them, knows nothing of us.
fn polylines(text: &str) -> Vec<(String, Vec<(f64, f64, f64)>)> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    assert_eq!(lines.len() % 2, 0, "codes and values come in pairs");
    let mut out: Vec<(String, Vec<(f64, f64, f64)>)> = Vec::new();
    let mut entity = "";
    let mut vertex: Option<(f64, f64, f64)> = None;
    for pair in lines.chunks(2) {
        let (code, value) = (pair[0].parse::<i32>().expect("a group code"), pair[1]);
        let number = || value.parse::<f64>().expect("a number");
        match (code, entity) {
            (0, _) => {
                if let (Some(v), Some(last)) = (vertex.take(), out.last_mut()) {
                    last.1.push(v);
                }
                entity = value;
                if entity == "POLYLINE" {
                    out.push((String::new(), vec![]));
                }
                if entity == "VERTEX" {
                    vertex = Some((0.0, 0.0, 0.0));
                }
            }
            (8, "POLYLINE") => out.last_mut().expect("a polyline").0 = value.to_string(),
            (70, "POLYLINE") => assert_eq!(value, "1", "a closed polyline"),
            (10, "VERTEX") => vertex.as_mut().expect("a vertex").0 = number(),
            (20, "VERTEX") => vertex.as_mut().expect("a vertex").1 = number(),
            (42, "VERTEX") => vertex.as_mut().expect("a vertex").2 = number(),
            _ => (),
        }
    }
    out
}

/// Length and area of a closed polyline with bulges: a bulge is tan(angle/4) of an arc over the chord, to its left if positive.
fn length_and_area(vertices: &[(f64, f64, f64)]) -> (f64, f64) {
    let (mut length, mut area) = (0.0, 0.0);
    for (i, &(x, y, bulge)) in vertices.iter().enumerate() {
        let (u, v, _) = vertices[(i + 1) % vertices.len()];
        let (chord, angle) = ((u - x).hypot(v - y), 4.0 * bulge.atan());
        area += 0.5 * (x * v - u * y);
        if bulge == 0.0 {
            length += chord;
        } else {
            let radius = 0.5 * chord / (0.5 * angle).sin();
            length += radius * angle;
            // The segment between chord and arc, with the sign of the turn.
            area += 0.5 * radius * radius * (angle - angle.sin());
        }
    }
    (length, area)
}

#[test]
fn the_dxf_read_back_has_the_cloth_s_lengths_and_area_in_millimetres() {
    let words = ["skirt β = 1.35".to_string()];
    for (pattern, pieces) in [(Pattern::of(&Cone::of(&table_one()), &PatternOptions::default()).unwrap(), 1.0), (quarter(), 4.0)] {
        let text = dxf(&pattern, &words);
        assert!(text.is_ascii() && text.contains("\\U+03B2") && text.ends_with("EOF\n"));
        let read = polylines(&text);
        assert_eq!(read.iter().map(|(layer, _)| layer.as_str()).collect::<Vec<_>>(), ["CUT", "SEAM"]);
        let (length, area) = length_and_area(&read[1].1);
        let cone = Cone::of(&table_one());
        let girths = TAU * (cone.waist_radius + cone.hem_radius) / pieces;
        // Coordinates have nine places after the point, in mm.
        assert!((length - 1e3 * (girths + 2.0 * cone.slant_length)).abs() < 1e-6, "{length}");
        let cloth = PI * (cone.waist_radius + cone.hem_radius) * cone.slant_length / pieces;
        assert!((area.abs() - 1e6 * cloth).abs() < 1e-3, "{area}");
        let (_, cut) = length_and_area(&read[0].1);
        assert!((cut.abs() - 1e6 * pattern.cut_area()).abs() < 1e-3);
    }
}

#[test]
fn the_svg_is_as_large_as_the_pattern_and_its_margin_in_millimetres() {
    let pattern = quarter();
    let text = svg(&pattern, &["<cut> & sew".into()]);
    let (low, high) = pattern.bounds();
    let attribute = |name: &str| {
        let at = text.find(&format!(" {name}=\"")).expect("the attribute") + name.len() + 3;
        text[at..].split('"').next().expect("a value").to_string()
    };
    let size = |name: &str| attribute(name).strip_suffix("mm").expect("millimetres").parse::<f64>().unwrap();
    // Coordinates are rounded to a thousandth of a millimetre.
    assert!((size("width") - (1e3 * (high.x - low.x) + 20.0)).abs() < 1e-3 && (size("height") - (1e3 * (high.y - low.y) + 20.0)).abs() < 1e-3);
    let view: Vec<f64> = attribute("viewBox").split(' ').map(|v| v.parse().unwrap()).collect();
    assert_eq!(view, [0.0, 0.0, size("width"), size("height")]);
    // The arc of the waist's seam has the radius of the pattern, R_v = R_t/cos β.
    let radius = 1e3 * Cone::of(&table_one()).pattern_radius.unwrap();
    assert!(text.contains(&format!("A{radius:.2}")), "{radius}");
    assert!(text.contains("&lt;cut&gt; &amp; sew") && !text.contains("NaN"));
}

/// Width and height of every page box of a PDF, mm.
fn page_boxes(bytes: &[u8]) -> Vec<(f64, f64)> {
    let text: String = bytes.iter().map(|&b| char::from(b)).collect();
    let boxes = text.match_indices("/MediaBox").map(|(at, _)| {
        let inside = text[at..].split_once('[').and_then(|(_, rest)| rest.split_once(']')).expect("a box").0;
        let sides: Vec<f64> = inside.split_whitespace().map(|v| v.parse().unwrap()).collect();
        ((sides[2] - sides[0]) * 25.4 / 72.0, (sides[3] - sides[1]) * 25.4 / 72.0)
    });
    boxes.collect()
}

#[test]
fn the_pdf_has_pages_of_true_size_whole_or_in_tiles() {
    let pattern = quarter();
    let (low, high) = pattern.bounds();
    let whole = page_boxes(&pdf(&pattern, &[], Paper::Whole).unwrap());
    assert_eq!(whole.len(), 1);
    // A point is 0.35 mm and the typesetter keeps it to a hundredth.
    assert!((whole[0].0 - (1e3 * (high.x - low.x) + 20.0)).abs() < 0.01 && (whole[0].1 - (1e3 * (high.y - low.y) + 20.0)).abs() < 0.01);
    let tiles = page_boxes(&pdf(&pattern, &[], Paper::A4).unwrap());
    // 429 × 606 mm on windows of 190 × 277 mm that overlap by 10: 3 columns by 3 rows.
    assert_eq!(tiles.len(), 9);
    assert!(tiles.iter().all(|(w, h)| (w - 210.0).abs() < 0.01 && (h - 297.0).abs() < 0.01));
}
