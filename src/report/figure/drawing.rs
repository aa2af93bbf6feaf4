//! What the plotting crate draws, written as SVG: neighbours of one ink become one path, however many dashes, whiskers or dots they are.
//!
//! A figure is read by browsers, editors, the rasterizer and the typesetter, and each of them pays by the element.

use std::convert::Infallible;
use std::fmt::Write;

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontStyle, FontTransform,
};

/// Font sizes reach a backend as this many times what is asked for.
pub const FONT_FACTOR: f64 = 1.24;

/// An SVG document in the making; complete once it is presented.
pub struct Drawing<'a> {
    svg: &'a mut String,
    size: (u32, u32),
    /// The path that is still open.
    open: Option<Ink>,
    /// A face whose rim may follow.
    face: Option<(Vec<BackendCoord>, Tint)>,
}

/// How a path is painted.
#[derive(Clone, Copy, PartialEq)]
enum Ink {
    Line { color: Tint, width: u32 },
    Area(Tint),
}

/// Levels of red, green and blue, and the opacity from 0 to 1.
#[derive(Clone, Copy, PartialEq)]
struct Tint {
    levels: (u8, u8, u8),
    alpha: f64,
}

impl From<BackendColor> for Tint {
    fn from(color: BackendColor) -> Tint {
        Tint { levels: color.rgb, alpha: color.alpha }
    }
}

type Done = Result<(), DrawingErrorKind<Infallible>>;

impl<'a> Drawing<'a> {
    /// `size` is the drawing's width and height in its own steps, `paper` in mm.
    pub fn new(svg: &'a mut String, (width, height): (u32, u32), paper: (f64, f64)) -> Self {
        let _ = writeln!(
            svg,
            "<svg width=\"{}mm\" height=\"{}mm\" viewBox=\"0 0 {width} {height}\" xmlns=\"http://www.w3.org/2000/svg\">",
            paper.0, paper.1
        );
        Drawing { svg, size: (width, height), open: None, face: None }
    }

    /// The path of this ink, to write on: the open one, or a new one. What is translucent shows where it overlaps, and stays by itself.
    fn path(&mut self, ink: Ink) -> &mut String {
        self.lay_face();
        let (Ink::Line { color, .. } | Ink::Area(color)) = ink;
        if self.open != Some(ink) || color.alpha != 1.0 {
            self.close();
            self.svg.push_str("<path");
            match ink {
                Ink::Line { color, width } => {
                    self.svg.push_str(" fill=\"none\"");
                    line(self.svg, color, width);
                }
                Ink::Area(color) => paint(self.svg, "fill", color),
            }
            self.svg.push_str(" d=\"");
            self.open = Some(ink);
        }
        self.svg
    }

    fn close(&mut self) {
        if self.open.take().is_some() {
            self.svg.push_str("\"/>\n");
        }
    }

    /// Writes the face that waited for its rim.
    fn lay_face(&mut self) {
        self.rimmed(None);
    }

    fn rimmed(&mut self, rim: Option<(Tint, u32)>) {
        let Some((corners, color)) = self.face.take() else { return };
        self.close();
        self.svg.push_str("<path");
        paint(self.svg, "fill", color);
        if let Some((color, width)) = rim {
            line(self.svg, color, width);
        }
        self.svg.push_str(" d=\"");
        corners_to(self.svg, &corners);
        self.svg.push_str("z\"/>\n");
    }
}

/// `fill="#RRGGBB"` or `stroke=…`, with its opacity if it has one.
fn paint(svg: &mut String, what: &str, color: Tint) {
    let (r, g, b) = color.levels;
    let _ = write!(svg, " {what}=\"#{r:02X}{g:02X}{b:02X}\"");
    if color.alpha != 1.0 {
        let _ = write!(svg, " {what}-opacity=\"{}\"", color.alpha);
    }
}

fn line(svg: &mut String, color: Tint, width: u32) {
    paint(svg, "stroke", color);
    let _ = write!(svg, " stroke-width=\"{width}\"");
}

/// `M` to the first corner and on to the others, each from the one before.
fn corners_to(svg: &mut String, corners: &[BackendCoord]) {
    let Some(&(x, y)) = corners.first() else { return };
    let _ = write!(svg, "M{x},{y}");
    let mut before = 'M';
    for pair in corners.windows(2) {
        let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        if (dx, dy) != (0, 0) {
            let _ = write!(svg, "{}{dx},{dy}", if before == 'l' { ' ' } else { 'l' });
            before = 'l';
        }
    }
}

impl DrawingBackend for Drawing<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        self.lay_face();
        self.close();
        if !self.svg.ends_with("</svg>\n") {
            self.svg.push_str("</svg>\n");
        }
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Done {
        self.draw_rect((x, y), (x + 1, y + 1), &color, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Done {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(&mut self, (left, top): BackendCoord, (right, bottom): BackendCoord, style: &S, fill: bool) -> Done {
        let Some(ink) = ink(style, fill) else { return Ok(()) };
        let (width, height) = (right - left, bottom - top);
        let _ = write!(self.path(ink), "M{left},{top}h{width}v{height}h{}z", -width);
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Done {
        let Some(ink) = ink(style, false) else { return Ok(()) };
        let corners: Vec<BackendCoord> = path.into_iter().collect();
        if let Some((face, _)) = &self.face
            && let [rim @ .., last] = &corners[..]
            && rim == face
            && Some(last) == face.first()
        {
            self.rimmed(Some((style.color().into(), style.stroke_width())));
        } else if corners.iter().any(|corner| *corner != corners[0]) {
            corners_to(self.path(ink), &corners);
        }
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Done {
        if ink(style, true).is_some() {
            self.lay_face();
            self.face = Some((path.into_iter().collect(), style.color().into()));
        }
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(&mut self, (x, y): BackendCoord, radius: u32, style: &S, fill: bool) -> Done {
        let Some(ink) = ink(style, fill) else { return Ok(()) };
        let (r, across) = (i64::from(radius), 2 * i64::from(radius));
        let left = i64::from(x) - r;
        let _ = write!(self.path(ink), "M{left},{y}a{r},{r} 0 1,1 {across},0 {r},{r} 0 1,1 {},0z", -across);
        Ok(())
    }

    /// A text without letters, which a tick without a name has, is left out.
    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Done {
        if style.color().alpha == 0.0 || text.trim().is_empty() {
            return Ok(());
        }
        self.lay_face();
        self.close();
        let anchor = match style.anchor().h_pos {
            HPos::Left => "start",
            HPos::Center => "middle",
            HPos::Right => "end",
        };
        let down = match style.anchor().v_pos {
            VPos::Top => "0.76em",
            VPos::Center => "0.5ex",
            VPos::Bottom => "-0.5ex",
        };
        let (family, size) = (style.family(), (100.0 * style.size() / FONT_FACTOR).round() / 100.0);
        let _ = write!(
            self.svg,
            "<text x=\"{x}\" y=\"{y}\" dy=\"{down}\" text-anchor=\"{anchor}\" font-family=\"{}\" font-size=\"{size}\"",
            family.as_str()
        );
        paint(self.svg, "fill", style.color().into());
        match style.style() {
            FontStyle::Normal => {}
            FontStyle::Bold => self.svg.push_str(" font-weight=\"bold\""),
            slanted => {
                let _ = write!(self.svg, " font-style=\"{}\"", slanted.as_str());
            }
        }
        let turn = match style.transform() {
            FontTransform::None => None,
            FontTransform::Rotate90 => Some(90),
            FontTransform::Rotate180 => Some(180),
            FontTransform::Rotate270 => Some(270),
        };
        if let Some(turn) = turn {
            let _ = write!(self.svg, " transform=\"rotate({turn}, {x}, {y})\"");
        }
        self.svg.push_str(">\n");
        for letter in text.chars() {
            match letter {
                '<' => self.svg.push_str("&lt;"),
                '>' => self.svg.push_str("&gt;"),
                '&' => self.svg.push_str("&amp;"),
                '"' => self.svg.push_str("&quot;"),
                '\'' => self.svg.push_str("&apos;"),
                letter => self.svg.push(letter),
            }
        }
        self.svg.push_str("\n</text>\n");
        Ok(())
    }
}

/// `None` for what would not be seen.
fn ink(style: &impl BackendStyle, fill: bool) -> Option<Ink> {
    let color = Tint::from(style.color());
    let ink = if fill { Ink::Area(color) } else { Ink::Line { color, width: style.stroke_width() } };
    (color.alpha != 0.0).then_some(ink)
}

/// The corners of every piece of a path that a [`Drawing`] wrote, from its `d`; of a circle two opposite corners of the square about it.
pub fn pieces(d: &str) -> Vec<Vec<(f64, f64)>> {
    let mut found: Vec<Vec<(f64, f64)>> = Vec::new();
    for piece in d.split('M').skip(1) {
        let mut corners: Vec<(f64, f64)> = Vec::new();
        let mut at = (0.0, 0.0);
        let starts: Vec<usize> = piece.match_indices(['l', 'h', 'v', 'a', 'z']).map(|(place, _)| place).chain([piece.len()]).collect();
        let numbers = |text: &str| -> Vec<f64> { text.split([' ', ',']).filter_map(|n| n.parse().ok()).collect() };
        if let [x, y] = numbers(&piece[..starts[0]])[..] {
            at = (x, y);
            corners.push(at);
        }
        for pair in starts.windows(2) {
            let (command, numbers) = (piece.as_bytes()[pair[0]], numbers(&piece[pair[0] + 1..pair[1]]));
            match command {
                b'l' => {
                    for step in numbers.as_chunks::<2>().0 {
                        at = (at.0 + step[0], at.1 + step[1]);
                        corners.push(at);
                    }
                }
                b'h' | b'v' => {
                    let step = numbers.first().copied().unwrap_or(0.0);
                    at = if command == b'h' { (at.0 + step, at.1) } else { (at.0, at.1 + step) };
                    corners.push(at);
                }
                b'a' => {
                    let r = numbers.first().copied().unwrap_or(0.0);
                    corners = vec![(at.0, at.1 - r), (at.0 + 2.0 * r, at.1 + r)];
                }
                _ => {}
            }
        }
        found.push(corners);
    }
    found
}

#[cfg(test)]
mod tests {
    use plotters::prelude::*;

    use super::*;

    fn drawn(paint: impl FnOnce(&DrawingArea<Drawing<'_>, plotters::coord::Shift>)) -> String {
        let mut svg = String::new();
        let area = Drawing::new(&mut svg, (400, 200), (10.0, 5.0)).into_drawing_area();
        paint(&area);
        area.present().unwrap();
        drop(area);
        svg
    }

    fn paths(svg: &str) -> Vec<&str> {
        svg.lines().filter(|line| line.starts_with("<path")).collect()
    }

    #[test]
    fn dashes_of_one_ink_are_one_path_and_other_inks_end_it() {
        let thin = ShapeStyle { color: BLACK.to_rgba(), filled: false, stroke_width: 4 };
        let svg = drawn(|area| {
            for x in [0, 20, 40] {
                area.draw(&PathElement::new(vec![(x, 10), (x + 10, 5)], thin)).unwrap();
            }
            area.draw(&PathElement::new(vec![(0, 10), (10, 15), (10, 15), (30, 15)], ShapeStyle { stroke_width: 2, ..thin })).unwrap();
            // No length, no ink.
            area.draw(&PathElement::new(vec![(7, 7), (7, 7)], thin)).unwrap();
            area.draw(&Circle::new((50, 60), 8, BLACK.filled())).unwrap();
            area.draw(&Circle::new((90, 60), 8, BLACK.filled())).unwrap();
        });
        assert_eq!(
            paths(&svg),
            [
                "<path fill=\"none\" stroke=\"#000000\" stroke-width=\"4\" d=\"M0,10l10,-5M20,10l10,-5M40,10l10,-5\"/>",
                "<path fill=\"none\" stroke=\"#000000\" stroke-width=\"2\" d=\"M0,10l10,5 20,0\"/>",
                "<path fill=\"#000000\" d=\"M42,60a8,8 0 1,1 16,0 8,8 0 1,1 -16,0zM82,60a8,8 0 1,1 16,0 8,8 0 1,1 -16,0z\"/>",
            ]
        );
        assert!(svg.starts_with("<svg width=\"10mm\" height=\"5mm\" viewBox=\"0 0 400 200\" ") && svg.ends_with("</svg>\n"), "{svg}");
    }

    #[test]
    fn what_is_translucent_stays_by_itself() {
        let pale = ShapeStyle { color: RED.mix(0.5), filled: false, stroke_width: 4 };
        let svg = drawn(|area| {
            for x in [0, 20] {
                area.draw(&PathElement::new(vec![(x, 10), (x + 30, 10)], pale)).unwrap();
            }
        });
        assert_eq!(paths(&svg).len(), 2);
        assert!(paths(&svg).iter().all(|path| path.contains(" stroke-opacity=\"0.5\" ")), "{svg}");
    }

    #[test]
    fn a_face_and_its_rim_are_one_element_and_a_face_alone_is_another() {
        let corners = vec![(0, 0), (10, 0), (10, 10)];
        let rim: Vec<(i32, i32)> = corners.iter().chain(&corners[..1]).copied().collect();
        let svg = drawn(|area| {
            area.draw(&Polygon::new(corners.clone(), WHITE.filled())).unwrap();
            area.draw(&PathElement::new(rim, ShapeStyle { color: BLACK.to_rgba(), filled: false, stroke_width: 3 })).unwrap();
            area.draw(&Polygon::new(corners, BLUE.filled())).unwrap();
        });
        assert_eq!(
            paths(&svg),
            [
                "<path fill=\"#FFFFFF\" stroke=\"#000000\" stroke-width=\"3\" d=\"M0,0l10,0 0,10z\"/>",
                "<path fill=\"#0000FF\" d=\"M0,0l10,0 0,10z\"/>"
            ]
        );
    }

    #[test]
    fn text_is_escaped_and_one_without_letters_left_out() {
        let style = TextStyle::from(("DejaVu Sans", 100.0 * FONT_FACTOR).into_font());
        let svg = drawn(|area| {
            area.draw_text("p < 0.05 & \"so\"", &style, (10, 20)).unwrap();
            area.draw_text(" ", &style, (10, 20)).unwrap();
        });
        assert_eq!(svg.matches("<text ").count(), 1);
        assert!(svg.contains(" font-size=\"100\" fill=\"#000000\">\np &lt; 0.05 &amp; &quot;so&quot;\n</text>"), "{svg}");
    }

    #[test]
    fn pieces_of_a_path_are_read_back() {
        let d = "M0,10l10,-5 -3,4M20,10h5v-2h-5zM42,60a8,8 0 1,1 16,0 8,8 0 1,1 -16,0z";
        assert_eq!(
            pieces(d),
            [
                vec![(0.0, 10.0), (10.0, 5.0), (7.0, 9.0)],
                vec![(20.0, 10.0), (25.0, 10.0), (25.0, 8.0), (20.0, 8.0)],
                vec![(42.0, 52.0), (58.0, 68.0)]
            ]
        );
    }
}
