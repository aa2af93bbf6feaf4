//! The outline of the largest object of a picture, and everything else that lies in the picture.

use super::Object;
use super::edge::{self, Contour, Field};
use super::level::{self, Grey, Levels, NoEdge};
use super::parts::{self, Part, Parts};
use crate::experiment::campaign::Tone;

/// Smaller objects are specks: their outline has too few pixels for any fold. Pixels.
const LEAST_PIXELS: usize = 200;
/// Of all pixels of the object's shade, the object has at least this share; noise falls into thousands of parts.
const LEAST_SHARE: f64 = 0.1;

/// A traced picture, in its pixels.
pub(super) struct Scene {
    pub grey: Grey,
    pub levels: Levels,
    shares: Vec<f32>,
    parts: Parts,
    /// The parts of the picture when the object and all it encloses is one: the object, its holes, and the rest.
    enclosed: Parts,
    /// The object's part among `parts`.
    object: usize,
    pub contour: Contour,
    /// Isolated pixels that were replaced.
    pub specks: usize,
}

/// Traces the largest object; what lies inside the polygon `board` (a checkerboard) is none.
pub(super) fn trace(mut grey: Grey, object: Object, tone: Tone, board: Option<&[[f64; 2]]>) -> Result<Scene, NoEdge> {
    let refuse = |problem: String, remedy| Err(NoEdge { problem, remedy });
    if grey.width < 16 || grey.height < 16 {
        return refuse(format!("a picture of {} × {} pixels", grey.width, grey.height), "take one with at least 16 pixels each way");
    }
    let specks = level::despeckle(&mut grey);
    let levels = level::levels(&grey, object)?;
    let shares = level::shares(&grey, &levels);
    let (width, height) = (grey.width, grey.height);
    let parts = parts::parts(width, height, |at| 0.5 < shares[at]);
    let mut of_board = vec![false; parts.parts.len()];
    if let Some(board) = board {
        let bounds = |c: usize, n: usize| {
            let low = board.iter().map(|p| p[c]).fold(f64::INFINITY, f64::min).max(0.0) as usize;
            let high = board.iter().map(|p| p[c]).fold(0.0, f64::max) as usize;
            low.min(n - 1)..high.min(n - 1) + 1
        };
        for y in bounds(1, height) {
            for x in bounds(0, width).filter(|&x| encloses(board, [x as f64 + 0.5, y as f64 + 0.5])) {
                of_board[parts.labels[y * width + x] as usize] = true;
            }
        }
    }
    let candidates = || (0..parts.parts.len()).filter(|&i| parts.parts[i].inside && !of_board[i]);
    let Some(largest) = candidates().max_by_key(|&i| (parts.parts[i].pixels, usize::MAX - i)) else {
        return refuse("no object was found".into(), "say whether the object is dark or light");
    };
    let part = parts.parts[largest];
    if part.pixels < LEAST_PIXELS {
        let problem = format!("the largest object has {} pixels", part.pixels);
        return refuse(problem, "check that object = \"dark\" or \"light\" is right, and that the drape fills a good part of the picture");
    }
    let all: usize = candidates().map(|i| parts.parts[i].pixels).sum();
    if (part.pixels as f64) < LEAST_SHARE * all as f64 {
        let problem = format!(
            "what stands out falls into {} parts; the largest has {:.1} % of their area",
            candidates().count(),
            100.0 * part.pixels as f64 / all as f64
        );
        return refuse(problem, "photograph one drape, sharply, against a plain background");
    }
    if part.touches_border {
        return refuse(
            "the object touches the border of the picture".into(),
            "take a picture with background all round it, or correct object = \"dark\" or \"light\"",
        );
    }
    let label = largest as u32;
    let enclosed = parts::parts(width, height, |at| parts.labels[at] == label);
    // The object keeps clear of the border, so the border is one part, the outside.
    let outside = enclosed.labels[0];
    let field = Field { grey: &grey, shares: &shares, inverted: false };
    let contour = edge::contour(&field, part.first, &|at| enclosed.labels[at] != outside, tone);
    Ok(Scene { levels, shares, enclosed, object: largest, contour, specks, parts, grey })
}

/// A part of the picture beside the object or in it.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    pub part: Part,
    /// In the object, of the shade of the background.
    pub hole: bool,
    label: u32,
}

impl Scene {
    pub fn pixels(&self) -> usize {
        self.parts.parts[self.object].pixels
    }

    /// The holes in the object, largest first.
    pub fn holes(&self) -> Vec<Piece> {
        let outside = self.enclosed.labels[0];
        let all = self.enclosed.parts.iter().enumerate().filter(|(i, part)| !part.inside && *i as u32 != outside);
        sorted(all.map(|(i, part)| Piece { part: *part, hole: true, label: i as u32 }).collect())
    }

    /// The other objects that lie whole in the picture and outside this one, largest first.
    pub fn others(&self) -> Vec<Piece> {
        let outside = self.enclosed.labels[0];
        let all =
            self.parts.parts.iter().enumerate().filter(|(i, part)| {
                part.inside && *i != self.object && !part.touches_border && self.enclosed.labels[part.first] == outside
            });
        sorted(all.map(|(i, part)| Piece { part: *part, hole: false, label: i as u32 }).collect())
    }

    /// Pixels of every other object, whether it touches the border or not.
    pub fn other_sizes(&self) -> Vec<usize> {
        let outside = self.enclosed.labels[0];
        let others = self.parts.parts.iter().enumerate();
        let others = others.filter(|(i, part)| part.inside && *i != self.object && self.enclosed.labels[part.first] == outside);
        let mut sizes: Vec<usize> = others.map(|(_, part)| part.pixels).collect();
        sizes.sort_unstable_by(|a, b| b.cmp(a));
        sizes
    }

    /// The field in which a piece stands out.
    pub fn field(&self, piece: &Piece) -> Field<'_> {
        Field { grey: &self.grey, shares: &self.shares, inverted: piece.hole }
    }

    /// The edge of a piece, in the tone of the object's.
    pub fn edge_of(&self, piece: &Piece) -> Contour {
        let labels = if piece.hole { &self.enclosed.labels } else { &self.parts.labels };
        edge::contour(&self.field(piece), piece.part.first, &|at| labels[at] == piece.label, self.contour.tone)
    }

    /// Things of a shade of their own that lie in the object, its grey values split once more: the lighter or the darker of the two classes.
    pub fn within(&self, lighter: bool) -> Option<(Vec<f32>, Parts)> {
        let (width, height) = (self.grey.width, self.grey.height);
        let own = |at: usize| self.parts.labels[at] == self.object as u32;
        // Six pixels clear of the edge, whose ramp has all grey values.
        let deep = |at: usize| {
            const CLEAR: usize = 6;
            let (x, y) = (at % width, at / width);
            CLEAR <= x.min(y)
                && x + CLEAR < width
                && y + CLEAR < height
                && own(at)
                && [at - CLEAR, at + CLEAR, at - CLEAR * width, at + CLEAR * width].into_iter().all(own)
        };
        let values: Vec<f32> = (0..width * height).filter(|&at| deep(at)).map(|at| self.grey.values[at]).collect();
        let split = level::Split::of(values.iter().copied())?;
        if split.light - split.dark < level::LEAST_CONTRAST || split.separation < level::LEAST_SEPARATION {
            return None;
        }
        let (thing, cloth) = if lighter { (split.light, split.dark) } else { (split.dark, split.light) };
        let share = |at: usize| ((f64::from(self.grey.values[at]) - cloth) / (thing - cloth)) as f32;
        let shares: Vec<f32> = (0..width * height).map(|at| if own(at) { share(at) } else { 0.0 }).collect();
        let parts = parts::parts(width, height, |at| 0.5 < shares[at] && deep(at));
        Some((shares, parts))
    }
}

fn sorted(mut pieces: Vec<Piece>) -> Vec<Piece> {
    pieces.sort_by(|a, b| b.part.pixels.cmp(&a.part.pixels).then(a.part.first.cmp(&b.part.first)));
    pieces
}

/// Whether a polygon encloses a place: an odd number of its sides lies to the right.
fn encloses(polygon: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
    sides.filter(|(a, b)| (a[1] <= y) != (b[1] <= y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])).count() % 2 == 1
}
