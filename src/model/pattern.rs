//! The flat pattern of the cone as pieces to cut: panels, seam lines and cut lines, of straight lines and arcs.
//!
//! The net of the cone is an annular sector of inner radius R_v, outer R_v + L and central angle α (paper, Figure 1); n equal panels have α/n each.
//! Lengths in m, the apex of the sector in the origin, the panel symmetric about the negative y axis (a half panel lies on its right), hem below.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::skirt::Cone;
use crate::error::Error;
use crate::experiment::Point;

/// How the pattern is divided and what is added to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Equal panels round the body.
    pub panels: u32,
    /// Draw half a panel, its axis of symmetry to be laid on a fold of the cloth.
    pub on_fold: bool,
    /// Added at the side seams, m.
    pub seam_allowance: f64,
    /// Added at the waist, m.
    pub waist_allowance: f64,
    /// Added at the hem, m.
    pub hem_allowance: f64,
}

impl Default for Options {
    /// The bare net in one piece: the sector of the paper.
    fn default() -> Self {
        Options { panels: 1, on_fold: false, seam_allowance: 0.0, waist_allowance: 0.0, hem_allowance: 0.0 }
    }
}

/// A piece of an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stroke {
    Line {
        from: Point,
        to: Point,
    },
    /// About the origin, from one polar angle to another, rad; falling angles run clockwise.
    Arc {
        radius: f64,
        from: f64,
        to: f64,
    },
}

impl Stroke {
    pub fn start(&self) -> Point {
        match *self {
            Stroke::Line { from, .. } => from,
            Stroke::Arc { radius, from, .. } => on_circle(radius, from),
        }
    }

    pub fn end(&self) -> Point {
        match *self {
            Stroke::Line { to, .. } => to,
            Stroke::Arc { radius, to, .. } => on_circle(radius, to),
        }
    }

    /// m.
    pub fn length(&self) -> f64 {
        match *self {
            Stroke::Line { from, to } => from.distance(to),
            Stroke::Arc { radius, from, to } => radius * (to - from).abs(),
        }
    }

    /// The stroke in pieces of at most a quarter turn: what drawing programs hold exactly.
    pub fn quarters(&self) -> Vec<Stroke> {
        match *self {
            Stroke::Line { .. } => vec![*self],
            Stroke::Arc { radius, from, to } => {
                let pieces = ((to - from).abs() / FRAC_PI_2).ceil().max(1.0) as usize;
                let at = |i: usize| from + (to - from) * i as f64 / pieces as f64;
                (0..pieces).map(|i| Stroke::Arc { radius, from: at(i), to: at(i + 1) }).collect()
            }
        }
    }

    /// `n` + 1 points from start to end.
    pub fn points(&self, n: usize) -> Vec<Point> {
        let share = |i: usize| i as f64 / n as f64;
        match *self {
            Stroke::Line { from, to } => {
                (0..=n).map(|i| Point::new(from.x + share(i) * (to.x - from.x), from.y + share(i) * (to.y - from.y))).collect()
            }
            Stroke::Arc { radius, from, to } => (0..=n).map(|i| on_circle(radius, from + share(i) * (to - from))).collect(),
        }
    }

    /// Twice the area between the stroke and the origin, m².
    fn swept(&self) -> f64 {
        match *self {
            Stroke::Line { from, to } => from.x * to.y - to.x * from.y,
            Stroke::Arc { radius, from, to } => radius * radius * (to - from),
        }
    }
}

fn on_circle(radius: f64, angle: f64) -> Point {
    Point::new(radius * angle.cos(), radius * angle.sin())
}

/// One panel; all of them are alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    pub options: Options,
    /// Where it is sewn and where waist and hem are: closed, waist left to right, down the right side, hem right to left, up the left side.
    pub seam: Vec<Stroke>,
    /// Where it is cut, in the same order; equal to `seam` without allowances.
    pub cut: Vec<Stroke>,
    /// Along the warp: the panel's own axis, or parallel to the fold.
    pub grain: (Point, Point),
    /// The line to lay on the fold of the cloth.
    pub fold: Option<(Point, Point)>,
}

impl Pattern {
    /// The panel of a cone.
    ///
    /// # Errors
    /// [`Error::Invalid`] for no or more than 64 panels, or a negative allowance; [`Error::Unanswerable`] where the allowances of a panel overlap
    /// round the apex.
    pub fn of(cone: &Cone, options: &Options) -> Result<Self, Error> {
        if !(1..=64).contains(&options.panels) {
            return Err(Error::Invalid { quantity: "panels", value: f64::from(options.panels), allowed: "1 to 64" });
        }
        for (quantity, value) in [
            ("seam allowance, m", options.seam_allowance),
            ("waist allowance, m", options.waist_allowance),
            ("hem allowance, m", options.hem_allowance),
        ] {
            if !(value.is_finite() && 0.0 <= value) {
                return Err(Error::Invalid { quantity, value, allowed: ">= 0" });
            }
        }
        let (seam, cut) = match cone.pattern_radius {
            Some(inner) => sector(cone, inner, options)?,
            None => rectangle(cone, options),
        };
        let axis = |share: f64, aside: f64| {
            let distance = share * cone.slant_length;
            match cone.pattern_radius {
                Some(inner) => {
                    let angle = aside * cone.pattern_angle / f64::from(options.panels);
                    on_circle(inner + distance, angle - FRAC_PI_2)
                }
                None => Point::new(aside * TAU * cone.waist_radius / f64::from(options.panels), -distance),
            }
        };
        // On the fold the axis is taken: the grain line stands beside it, parallel.
        let top = axis(0.15, 0.0);
        let grain = if options.on_fold {
            let aside = 0.5 * (axis(0.15, 0.5).x - top.x);
            (Point::new(top.x + aside, top.y), Point::new(top.x + aside, axis(0.85, 0.0).y))
        } else {
            (top, axis(0.85, 0.0))
        };
        let fold = options.on_fold.then(|| (cut[0].start(), cut[2].end()));
        Ok(Pattern { options: *options, seam, cut, grain, fold })
    }

    /// Least and greatest x and y of the cut line, m.
    pub fn bounds(&self) -> (Point, Point) {
        let mut low = Point::new(f64::INFINITY, f64::INFINITY);
        let mut high = Point::new(f64::NEG_INFINITY, f64::NEG_INFINITY);
        let mut see = |p: Point| {
            low = Point::new(low.x.min(p.x), low.y.min(p.y));
            high = Point::new(high.x.max(p.x), high.y.max(p.y));
        };
        for stroke in &self.cut {
            see(stroke.start());
            see(stroke.end());
            if let Stroke::Arc { radius, from, to } = *stroke {
                // Where the arc passes an axis it is furthest out.
                let (low, high) = (from.min(to), from.max(to));
                let first = (low / FRAC_PI_2).ceil() as i64;
                let last = (high / FRAC_PI_2).floor() as i64;
                (first..=last).for_each(|i| see(on_circle(radius, i as f64 * FRAC_PI_2)));
            }
        }
        (low, high)
    }

    /// Area of one piece of cloth within the cut line, m²; of the whole panel where half of it is drawn.
    pub fn cut_area(&self) -> f64 {
        let half = if self.options.on_fold { 2.0 } else { 1.0 };
        half * enclosed(&self.cut)
    }

    /// The same within the seam line.
    pub fn seam_area(&self) -> f64 {
        let half = if self.options.on_fold { 2.0 } else { 1.0 };
        half * enclosed(&self.seam)
    }
}

fn enclosed(strokes: &[Stroke]) -> f64 {
    0.5 * strokes.iter().map(Stroke::swept).sum::<f64>().abs()
}

/// Seam and cut line of a panel of a cone. Both sides of the cut are parallel to the seam; its corners lie on the arcs of waist and hem.
fn sector(cone: &Cone, inner: f64, options: &Options) -> Result<(Vec<Stroke>, Vec<Stroke>), Error> {
    let half = 0.5 * cone.pattern_angle / f64::from(options.panels);
    let side = options.seam_allowance;
    let (waist, hem) = (inner - options.waist_allowance, inner + cone.slant_length + options.hem_allowance);
    if waist <= side {
        return Err(Error::Unanswerable(
            "the allowances reach over the apex of the pattern: take smaller ones, or cut the waist by the net".into(),
        ));
    }
    // Where the parallel to a side meets the circle of this radius.
    let turned = |radius: f64| half + (side / radius).asin();
    if PI + 1e-12 < turned(waist) {
        return Err(Error::Unanswerable(
            "the seam allowances overlap round the apex of the pattern: divide it into two panels or more".into(),
        ));
    }
    let outline = |waist: f64, hem: f64, at_waist: f64, at_hem: f64| {
        let left = |angle: f64| if options.on_fold { -FRAC_PI_2 } else { -FRAC_PI_2 - angle };
        let right = |angle: f64| angle - FRAC_PI_2;
        let (top, bottom) = (
            Stroke::Arc { radius: waist, from: left(at_waist), to: right(at_waist) },
            Stroke::Arc { radius: hem, from: right(at_hem), to: left(at_hem) },
        );
        closed(top, bottom)
    };
    let seam = outline(inner, inner + cone.slant_length, half, half);
    Ok((seam, outline(waist, hem, turned(waist), turned(hem))))
}

fn rectangle(cone: &Cone, options: &Options) -> (Vec<Stroke>, Vec<Stroke>) {
    let half = 0.5 * TAU * cone.waist_radius / f64::from(options.panels);
    let outline = |side: f64, above: f64, below: f64| {
        let (left, right) = (if options.on_fold { 0.0 } else { -half - side }, half + side);
        let (top, bottom) = (above, -cone.slant_length - below);
        let line = |from, to| Stroke::Line { from, to };
        closed(line(Point::new(left, top), Point::new(right, top)), line(Point::new(right, bottom), Point::new(left, bottom)))
    };
    (outline(0.0, 0.0, 0.0), outline(options.seam_allowance, options.waist_allowance, options.hem_allowance))
}

/// Waist, right side, hem, left side.
fn closed(top: Stroke, bottom: Stroke) -> Vec<Stroke> {
    let right = Stroke::Line { from: top.end(), to: bottom.start() };
    let left = Stroke::Line { from: bottom.end(), to: top.start() };
    vec![top, right, bottom, left]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Skirt;
    use crate::units::Metre;

    fn cone(waist: f64, hem: f64, slant: f64) -> Cone {
        Cone::of(&Skirt::new(Metre(waist), Metre(hem), Metre(slant)).unwrap())
    }

    #[test]
    fn panels_sew_up_to_waist_hem_slant_and_area_of_the_cone() {
        for (waist, hem, slant) in [(0.121, 0.2362, 0.53), (0.121, 0.121, 0.53), (0.1, 0.45, 0.5)] {
            let cone = cone(waist, hem, slant);
            for (panels, on_fold) in [(1, false), (2, false), (4, false), (2, true)] {
                let pattern = Pattern::of(&cone, &Options { panels, on_fold, ..Options::default() }).unwrap();
                let pieces = f64::from(panels) * if on_fold { 2.0 } else { 1.0 };
                let length = |i: usize| pieces * pattern.seam[i].length();
                assert!((length(0) - TAU * waist).abs() < 1e-12 && (length(2) - TAU * hem).abs() < 1e-12);
                assert!((pattern.seam[1].length() - slant).abs() < 1e-12 && (pattern.seam[3].length() - slant).abs() < 1e-12);
                assert!((f64::from(panels) * pattern.seam_area() - PI * (waist + hem) * slant).abs() < 1e-12);
                assert_eq!(pattern.cut, pattern.seam);
            }
        }
    }

    #[test]
    fn allowances_lie_parallel_to_the_seams() {
        let options = Options { panels: 4, seam_allowance: 0.015, waist_allowance: 0.01, hem_allowance: 0.03, ..Options::default() };
        let pattern = Pattern::of(&cone(0.121, 0.2362, 0.53), &options).unwrap();
        let distance = |p: Point, line: &Stroke| {
            let (a, b) = (line.start(), line.end());
            ((p.x - a.x) * (b.y - a.y) - (p.y - a.y) * (b.x - a.x)) / a.distance(b)
        };
        for side in [1, 3] {
            for p in pattern.cut[side].points(4) {
                assert!((distance(p, &pattern.seam[side]).abs() - 0.015).abs() < 1e-12);
            }
        }
        let radius = |stroke: &Stroke| stroke.start().x.hypot(stroke.start().y);
        assert!((radius(&pattern.seam[0]) - radius(&pattern.cut[0]) - 0.01).abs() < 1e-12);
        assert!((radius(&pattern.cut[2]) - radius(&pattern.seam[2]) - 0.03).abs() < 1e-12);
        // A fold of cloth has no allowance.
        let on_fold = Pattern::of(&cone(0.121, 0.2362, 0.53), &Options { on_fold: true, ..options }).unwrap();
        assert!(on_fold.cut[3].points(3).iter().all(|p| p.x.abs() < 1e-12) && on_fold.fold.is_some());
    }

    #[test]
    fn bounds_hold_every_point_of_the_cut_line_and_touch_it() {
        for panels in [1, 2, 4] {
            let pattern = Pattern::of(&cone(0.1, 0.45, 0.5), &Options { panels, seam_allowance: 0.01, ..Options::default() });
            let pattern = pattern.unwrap();
            let (low, high) = pattern.bounds();
            let all: Vec<Point> = pattern.cut.iter().flat_map(|s| s.points(4000)).collect();
            let extreme = |pick: fn(&Point) -> f64, best: fn(f64, f64) -> f64, start: f64| all.iter().map(pick).fold(start, best);
            // 4 000 chords of at most a turn miss the top of an arc by R(π/4000)²/2 ~ 3e-7.
            for (bound, seen) in [
                (low.x, extreme(|p| p.x, f64::min, f64::INFINITY)),
                (low.y, extreme(|p| p.y, f64::min, f64::INFINITY)),
                (-high.x, -extreme(|p| p.x, f64::max, f64::NEG_INFINITY)),
                (-high.y, -extreme(|p| p.y, f64::max, f64::NEG_INFINITY)),
            ] {
                assert!(bound <= seen + 1e-15 && seen - bound < 1e-6, "{panels}: {bound} {seen}");
            }
        }
    }

    #[test]
    fn what_cannot_be_cut_is_refused_with_what_would_be_right() {
        let flat = Cone::of(&Skirt::drapemeter(Metre(0.09), Metre(0.15)).unwrap());
        assert!(Pattern::of(&flat, &Options::default()).is_ok());
        let asked = Options { seam_allowance: 0.01, ..Options::default() };
        assert!(Pattern::of(&flat, &asked).unwrap_err().to_string().contains("two panels"));
        assert!(Pattern::of(&flat, &Options { panels: 2, ..asked }).is_ok());
        assert!(Pattern::of(&flat, &Options { waist_allowance: 0.1, ..asked }).unwrap_err().to_string().contains("apex"));
        assert!(Pattern::of(&flat, &Options { panels: 0, ..asked }).is_err());
        assert!(Pattern::of(&flat, &Options { hem_allowance: -1.0, ..asked }).is_err());
    }
}
