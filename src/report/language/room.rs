//! How much room a word of a figure has: from its anchor to the next word, sign or edge of the sheet on its line.

use crate::report::figure::drawing::pieces;

/// What is kept free between a word and its neighbour, steps of the drawing's grid: 0.6 mm.
const GAP: f64 = 24.0;
/// What is kept free at the edge of the sheet, steps: 0.3 mm.
const MARGIN: f64 = 12.0;
/// Height of a small x over that of the type, as DejaVu Sans has it.
const EX: f64 = 0.547;
/// Capitals and accents rise so far above the line, and tails so far below it, in em; a little less than they do at most, as neighbouring lines interlock.
const ABOVE: f64 = 0.7;
const BELOW: f64 = 0.15;
/// A sign stands beside words if it is no longer and no higher than this, steps: 20 mm and 3 mm. Longer ones are axes and curves, which words may cross.
const LONG: f64 = 800.0;
const HIGH: f64 = 120.0;

/// A box on the sheet, steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Extent {
    /// The sheet turned by a quarter so that words which run upwards run to the right.
    fn turned(self) -> Self {
        Extent { left: -self.bottom, right: -self.top, top: self.left, bottom: self.right }
    }

    fn turned_back(self) -> Self {
        Extent { left: self.top, right: self.bottom, top: -self.right, bottom: -self.left }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Anchor {
    Start,
    Middle,
    End,
}

/// Where a word stands.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// The anchor, in the word's own frame.
    x: f64,
    y: f64,
    anchor: Anchor,
    /// Size of its type, steps.
    pub size: f64,
    pub bold: bool,
    /// From the anchor down to the line that the letters stand on.
    down: f64,
    upwards: bool,
}

impl Place {
    /// From a text's tag; `None` if it is none that figures have.
    pub fn of(tag: &str) -> Option<Place> {
        let number = |name: &str| attribute(tag, name)?.parse::<f64>().ok();
        let (x, y, size) = (number("x")?, number("y")?, number("font-size")?);
        let anchor = match attribute(tag, "text-anchor") {
            Some("middle") => Anchor::Middle,
            Some("end") => Anchor::End,
            _ => Anchor::Start,
        };
        let down = match attribute(tag, "dy") {
            Some(dy) if dy.ends_with("em") => dy.trim_end_matches("em").parse::<f64>().ok()? * size,
            Some(dy) if dy.ends_with("ex") => dy.trim_end_matches("ex").parse::<f64>().ok()? * EX * size,
            _ => 0.0,
        };
        let upwards = match attribute(tag, "transform") {
            None => false,
            Some(turn) if turn.starts_with("rotate(270,") => true,
            Some(_) => return None,
        };
        let (x, y) = if upwards { (-y, x) } else { (x, y) };
        Some(Place { x, y, anchor, size, bold: attribute(tag, "font-weight") == Some("bold"), down, upwards })
    }

    /// The box of a word of this width (steps) on the sheet.
    pub fn extent(&self, width: f64) -> Extent {
        let own = self.own(width);
        if self.upwards { own.turned_back() } else { own }
    }

    fn own(&self, width: f64) -> Extent {
        let left = match self.anchor {
            Anchor::Start => self.x,
            Anchor::Middle => self.x - 0.5 * width,
            Anchor::End => self.x - width,
        };
        let line = self.y + self.down;
        Extent { left, right: left + width, top: line - ABOVE * self.size, bottom: line + BELOW * self.size }
    }

    /// How wide a word may be here whose English had `width`, among other words and signs on a `sheet`; at least as wide as the English.
    pub fn room(&self, width: f64, sheet: Extent, words: &[Extent], signs: &[Extent]) -> f64 {
        let frame = |extent: Extent| if self.upwards { extent.turned() } else { extent };
        let (own, sheet) = (self.own(width), frame(sheet));
        let (mut left, mut right) = (sheet.left + MARGIN, sheet.right - MARGIN);
        let beside = signs.iter().map(|sign| frame(*sign)).filter(|sign| sign.right - sign.left < LONG && sign.bottom - sign.top < HIGH);
        for other in words.iter().map(|word| frame(*word)).chain(beside) {
            let same_line = other.top < own.bottom && own.top < other.bottom;
            if same_line && other.right <= own.left + GAP {
                left = left.max(other.right + GAP);
            } else if same_line && own.right - GAP <= other.left {
                right = right.min(other.left - GAP);
            }
        }
        let room = match self.anchor {
            Anchor::Start => right - self.x,
            Anchor::End => self.x - left,
            Anchor::Middle => 2.0 * (self.x - left).min(right - self.x),
        };
        room.max(width)
    }
}

/// Boxes of the short lines, circles and bars of a figure.
pub fn signs(figure: &str) -> Vec<Extent> {
    // Of a curve with more corners than a sign has nothing is kept.
    const CORNERS: usize = 8;
    let mut found = vec![];
    for element in figure.split('<') {
        let number = |name: &str| attribute(element, name).and_then(|value| value.parse::<f64>().ok());
        let Some(path) = attribute(element, "d").filter(|_| element.starts_with("path")) else { continue };
        let half = 0.5 * number("stroke-width").unwrap_or(0.0);
        let none = Extent { left: f64::INFINITY, top: f64::INFINITY, right: f64::NEG_INFINITY, bottom: f64::NEG_INFINITY };
        for corners in pieces(path).iter().filter(|corners| (1..=CORNERS).contains(&corners.len())) {
            found.push(corners.iter().fold(none, |all, &(x, y)| Extent {
                left: all.left.min(x - half),
                top: all.top.min(y - half),
                right: all.right.max(x + half),
                bottom: all.bottom.max(y + half),
            }));
        }
    }
    found
}

/// The sheet of a figure, from its view box.
pub fn sheet(figure: &str) -> Option<Extent> {
    let numbers: Vec<f64> = attribute(figure, "viewBox")?.split_whitespace().filter_map(|n| n.parse().ok()).collect();
    let [left, top, width, height] = numbers.try_into().ok()?;
    Some(Extent { left, top, right: left + width, bottom: top + height })
}

/// The value of an attribute.
fn attribute<'t>(tag: &'t str, name: &str) -> Option<&'t str> {
    let from = tag.match_indices(name).find(|(at, _)| tag[..*at].ends_with(' ') && tag[at + name.len()..].starts_with("=\""))?.0;
    let value = &tag[from + name.len() + 2..];
    value.find('"').map(|to| &value[..to])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHEET: Extent = Extent { left: 0.0, top: 0.0, right: 1000.0, bottom: 400.0 };

    #[test]
    fn a_word_may_grow_to_its_neighbour_and_to_the_edge() {
        let at = |anchor: &str| {
            Place::of(&format!("<text x=\"400\" y=\"200\" dy=\"0.5ex\" text-anchor=\"{anchor}\" font-size=\"100\"")).unwrap()
        };
        let neighbour = Extent { left: 700.0, right: 760.0, top: 190.0, bottom: 210.0 };
        let elsewhere = Extent { top: 10.0, bottom: 50.0, ..neighbour };
        assert_eq!(at("start").room(100.0, SHEET, &[neighbour], &[]), 300.0 - GAP);
        assert_eq!(at("start").room(100.0, SHEET, &[elsewhere], &[]), 600.0 - MARGIN);
        assert_eq!(at("end").room(100.0, SHEET, &[neighbour], &[]), 400.0 - MARGIN);
        // As far to the left as to the right.
        assert_eq!(at("middle").room(100.0, SHEET, &[neighbour], &[]), 2.0 * (300.0 - GAP));
        // A legend's line is a neighbour; an axis is not.
        let line = Extent { left: 650.0, right: 690.0, top: 199.0, bottom: 201.0 };
        let axis = Extent { left: 640.0, right: 641.0, top: 0.0, bottom: 400.0 };
        assert_eq!(at("start").room(100.0, SHEET, &[neighbour], &[line, axis]), 250.0 - GAP);
    }

    #[test]
    fn a_word_that_runs_upwards_has_the_room_above_and_below() {
        let tag = "<text x=\"20\" y=\"250\" dy=\"0.76em\" text-anchor=\"middle\" font-size=\"100\" transform=\"rotate(270, 20, 250)\"";
        let place = Place::of(tag).unwrap();
        let box_of = place.extent(100.0);
        assert_eq!((box_of.top, box_of.bottom), (200.0, 300.0));
        assert!(20.0 < box_of.left && box_of.right < 120.0, "{box_of:?}");
        let title = Extent { left: 20.0, right: 500.0, top: 10.0, bottom: 60.0 };
        assert_eq!(place.room(100.0, SHEET, &[title], &[]), 2.0 * (400.0 - MARGIN - 250.0));
        let lower = Extent { top: 100.0, bottom: 150.0, ..title };
        assert_eq!(place.room(100.0, SHEET, &[lower], &[]), 2.0 * (100.0 - GAP));
    }

    #[test]
    fn signs_are_found_and_curves_are_not() {
        let figure = "<svg viewBox=\"0 0 1000 400\"><path fill=\"#000000\" d=\"M5,20a5,5 0 1,1 10,0 5,5 0 1,1 -10,0z\"/>\
                      <path stroke-width=\"2\" d=\"M0,0l30,0M0,0l1,1 1,-1 1,1 1,-1 1,1 1,-1 1,1 1,-1 1,1\"/></svg>";
        let found = signs(figure);
        assert_eq!(found.len(), 2);
        assert_eq!(found[0], Extent { left: 5.0, top: 15.0, right: 15.0, bottom: 25.0 });
        assert_eq!(found[1], Extent { left: -1.0, top: -1.0, right: 31.0, bottom: 1.0 });
        assert_eq!(sheet(figure), Some(SHEET));
    }
}
