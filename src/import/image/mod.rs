//! Silhouette pictures (PNG, JPEG, TIFF, BMP; 8 or 16 bit) → outline in metres, with the scale that is given or lies in the picture.
//!
//! Place of a pixel: the picture's lower left corner is the origin, x to the right, y up; the centre of the pixel in column `i` and row `j`
//! (from 0, top row first) is `x = (i + ½)·scale`, `y = (height − j − ½)·scale`. With a checkerboard the origin is the middle of the outline.

mod checkerboard;
mod edge;
mod level;
mod linear;
mod measure;
mod open;
mod overlay;
mod parts;
mod trace;

use std::path::Path;

pub use open::is_picture;
pub use overlay::{overlay, overlay_width, rule};

use self::checkerboard::{Board, Levelled};
use self::measure::Measured;
use self::trace::Scene;
use crate::error::{Error, Place};
use crate::experiment::Source;
use crate::experiment::campaign::{PictureScale, Pictures, Shade, Tone};
use crate::experiment::{DrapeProfile, Point};
use crate::units::{MILLIMETRE, Metre};

/// An outline has at most this many points: more of them repeat the same grey values. At least a pixel apart.
const MOST_POINTS: f64 = 2000.0;

/// A traced picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Silhouette {
    /// m.
    pub profile: DrapeProfile,
    /// Width and height of the picture, px, turned as its camera says.
    pub size: [usize; 2],
    pub source: Source,
    /// Side of a pixel in the plane of the hem (in the middle of the outline, where the camera is tilted), m.
    pub pixel: Metre,
    /// Of every length of the outline together: that of a scale found in the picture; `None` where the scale was given, and is taken as it is.
    pub relative_standard_error: Option<f64>,
    /// Everything that is drawn over the picture.
    pub marks: Vec<Mark>,
    /// How it was read: grey levels, tone, scale.
    pub reading: Vec<String>,
    /// What a person should know: holes that were filled, other objects, uneven light.
    pub notes: Vec<String>,
}

/// Something that was found in a picture, as a closed line in its pixels: x to the right, y down, from the upper left corner.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    pub of: Marked,
    pub line: Vec<[f64; 2]>,
}

/// What a [`Mark`] is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marked {
    Outline,
    Hole,
    Other,
    /// The disc, bar or checkerboard of known size.
    Scale,
}

/// What is the object?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Object {
    Dark,
    Light,
    /// Whatever the margin of the picture is not.
    Unlike,
}

/// The outline of the largest object in a picture, evenly spaced at one pixel or more, at most 2000 points; docs/images.md says how.
///
/// Measured on rendered hems of known shape: tests/import_images.rs prints the table that docs/images.md shows.
///
/// # Errors
/// [`Error::File`] if it cannot be read; [`Error::Input`] if it is no picture, broken, truncated, too large, without contrast, if the object
/// touches the border, or if the thing of known size is not found; [`Error::Invalid`] as [`Pictures::check`].
pub fn outline(path: &Path, options: &Pictures) -> Result<Silhouette, Error> {
    options.check()?;
    traced(open::open(path)?, path, options)
}

/// The same of a picture in memory: `values` by rows, the top one first, from 0 (black) to 1 (white).
///
/// # Errors
/// As [`outline`], the picture named `in memory`; [`Error::Unanswerable`] if there are no full rows.
pub fn outline_of_pixels(width: usize, values: &[f32], options: &Pictures) -> Result<Silhouette, Error> {
    options.check()?;
    if width == 0 || values.is_empty() || !values.len().is_multiple_of(width) {
        return Err(Error::Unanswerable(format!("{} pixels are no picture {width} pixels wide", values.len())));
    }
    let path = Path::new("in memory");
    let size = [width, values.len() / width];
    let source = Source { file: path.to_path_buf(), bytes: 0, digest: String::new() };
    let grey = level::Grey { width: size[0], height: size[1], values: values.to_vec() };
    traced(open::Opened { grey, averaged: 1, size, source, photograph: false, notes: Vec::new() }, path, options)
}

fn traced(opened: open::Opened, path: &Path, options: &Pictures) -> Result<Silhouette, Error> {
    let refuse = |problem: String, remedy: &str| Error::input(Place::file(path), problem, remedy);
    let object = match options.object {
        Shade::Dark => Object::Dark,
        Shade::Light => Object::Light,
        Shade::Auto => Object::Unlike,
    };
    let board = match options.scale {
        PictureScale::Checkerboard(_) => Some(checkerboard::find(&opened.grey).map_err(|(problem, remedy)| refuse(problem, remedy))?),
        _ => None,
    };
    let frame = board.as_ref().map(|b| b.frame.as_slice());
    let tone = if options.tone == Tone::Auto && opened.photograph { Tone::Srgb } else { options.tone };
    let scene = trace::trace(opened.grey, object, tone, frame).map_err(|e| refuse(e.problem, e.remedy))?;
    let even = evenly_spaced(&scene.contour.points);
    // Pixels of the file, not of the averaged picture.
    let unit = opened.averaged as f64;
    let in_file = |points: &[[f64; 2]]| points.iter().map(|p| p.map(|c| c * unit)).collect::<Vec<_>>();
    let scaled =
        scaled(&scene, board.as_ref(), &even, options, unit, opened.size[1]).map_err(|(problem, remedy)| refuse(problem, remedy))?;
    let factor = options.height.map_or(1.0, |height| height.factor());
    let points: Vec<Point> = scaled.points.iter().map(|[x, y]| Point::new(x * factor, y * factor)).collect();
    let profile =
        DrapeProfile::new(&points).map_err(|e| refuse(e.to_string(), "check the picture: the largest object in it is no drape"))?;
    let mut marks = vec![Mark { of: Marked::Outline, line: in_file(&even) }];
    let holes = scene.holes();
    let (shown_holes, shown_others) = (holes.iter().take(MOST_MARKS), scene.others());
    let shown_others = shown_others.iter().take(MOST_MARKS).filter(|piece| scene.pixels() < 1000 * piece.part.pixels);
    marks.extend(shown_holes.filter(|p| 12 <= p.part.pixels).map(|p| Mark { of: Marked::Hole, line: in_file(&scene.edge_of(p).points) }));
    marks.extend(shown_others.filter(|p| 12 <= p.part.pixels).map(|p| Mark { of: Marked::Other, line: in_file(&scene.edge_of(p).points) }));
    marks.extend(scaled.mark.map(|line| Mark { of: Marked::Scale, line: in_file(&line) }));
    let mut reading = reading(&scene);
    reading.push(scaled.sentence);
    if let Some(height) = options.height {
        reading.push(format!(
            "camera {:.0} mm above the plane of the scale, hem {:.0} mm: lengths times {factor:.4}",
            height.camera.0 / MILLIMETRE,
            height.hem.0 / MILLIMETRE
        ));
    }
    let mut notes = opened.notes;
    notes.extend(scaled.note);
    notes.extend(remarks(&scene));
    Ok(Silhouette {
        profile,
        size: opened.size,
        source: opened.source,
        pixel: Metre(scaled.pixel * factor),
        relative_standard_error: scaled.relative_standard_error,
        marks,
        reading,
        notes,
    })
}

/// More holes and other objects than this are dirt, and are not drawn.
const MOST_MARKS: usize = 30;

/// An outline in metres, before the heights are put in.
struct Scaled {
    points: Vec<[f64; 2]>,
    pixel: f64,
    relative_standard_error: Option<f64>,
    mark: Option<Vec<[f64; 2]>>,
    sentence: String,
    note: Option<String>,
}

/// Largest relative standard error of a scale that is worth having: above it the fold depth means nothing.
const WORST_SCALE: f64 = 0.02;

fn scaled(
    scene: &Scene,
    board: Option<&Board>,
    outline: &[[f64; 2]],
    options: &Pictures,
    unit: f64,
    height: usize,
) -> Result<Scaled, (String, &'static str)> {
    let flat = |pixel: f64| outline.iter().map(|[x, y]| [x * unit * pixel, (height as f64 - y * unit) * pixel]).collect::<Vec<_>>();
    let found = |measured: Measured, size: Metre| {
        let pixel = size.0 / measured.length / unit;
        let error = measured.relative_standard_error;
        if WORST_SCALE < error {
            let problem = format!("{}: the scale is known to {:.1} % only", measured.seen, 100.0 * error);
            return Err((problem, "let the thing of known size fill more of the picture"));
        }
        Ok(Scaled {
            points: flat(pixel),
            pixel,
            relative_standard_error: Some(error),
            sentence: format!("{}: {:.5} mm/px ± {:.2} %", measured.seen, pixel / MILLIMETRE, 100.0 * error),
            mark: Some(measured.mark),
            note: None,
        })
    };
    match options.scale {
        PictureScale::Pixel(Metre(pixel)) => Ok(Scaled {
            points: flat(pixel),
            pixel,
            relative_standard_error: None,
            sentence: format!("{:.5} mm/px, as given", pixel / MILLIMETRE),
            mark: None,
            note: None,
        }),
        PictureScale::Disc(diameter) => found(measure::disc(scene)?, diameter),
        PictureScale::Bar(length) => found(measure::bar(scene)?, length),
        PictureScale::Checkerboard(side) => {
            let board = board.expect("found before the outline was traced");
            on_board(board, outline, side, unit)
        }
    }
}

fn on_board(board: &Board, outline: &[[f64; 2]], side: Metre, unit: f64) -> Result<Scaled, (String, &'static str)> {
    let [columns, rows] = board.corners;
    let seen = format!("checkerboard of {columns} × {rows} corners ({} found, {:.2} px rms off a plane)", board.found, board.rms);
    let Some(Levelled { points, pixel, range, relative_standard_error: error }) = board.level(outline) else {
        return Err((format!("{seen}: a part of the drape lies beyond its horizon"), "let the camera look down more steeply"));
    };
    if WORST_SCALE < error {
        let problem = format!(
            "{seen}: carried on to the drape, the scale is known to {:.1} % only (squares of {:.1} px)",
            100.0 * error,
            board.square
        );
        return Err((problem, "use a board of more or larger squares, near the drape"));
    }
    let change = range[1] / range[0] - 1.0;
    if 0.5 < change {
        let problem = format!("{seen}: the size of a pixel changes by {:.0} % along the outline", 100.0 * change);
        return Err((problem, "let the camera look straight down: so oblique a view hides folds behind others"));
    }
    // Half a percent of change is a tilt that moves folds by as much.
    let note = (0.005 < change)
        .then(|| format!("the camera was tilted: a pixel's size changes by {:.1} % along the outline; corrected", 100.0 * change));
    let millimetres = pixel * side.0 / unit / MILLIMETRE;
    Ok(Scaled {
        points: points.into_iter().map(|p| p.map(|c| c * side.0)).collect(),
        pixel: pixel * side.0 / unit,
        relative_standard_error: Some(error),
        mark: Some(board.frame.clone()),
        sentence: format!("{seen}: {millimetres:.5} mm/px ± {:.2} % in the middle of the outline", 100.0 * error),
        note,
    })
}

fn reading(scene: &Scene) -> Vec<String> {
    let shade = if scene.levels.object_is_dark { "dark" } else { "light" };
    let [object, ground] = scene.levels.typical.map(|level| 100.0 * level);
    let tone = if scene.contour.tone == Tone::Srgb { "sRGB" } else { "linear" };
    let blur = scene.contour.blur.map(|b| format!(", edge blurred by {b:.1} px")).unwrap_or_default();
    vec![format!("{shade} object, grey levels {object:.0} % and {ground:.0} % of full scale, tone {tone}{blur}")]
}

fn remarks(scene: &Scene) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some([low, high]) = scene.levels.uneven {
        notes.push(format!("uneven light: the background runs from {:.0} to {:.0} % of full scale; levelled", 100.0 * low, 100.0 * high));
    }
    if 0 < scene.specks {
        notes.push(format!("{} isolated pixel(s) were replaced by the median of their neighbours", scene.specks));
    }
    let holes = scene.holes();
    if let Some(largest) = holes.first() {
        notes.push(format!("{} hole(s) in the object were filled, the largest of {} pixels", holes.len(), largest.part.pixels));
    }
    // Specks of dust and compression are of no interest; a label or a second drape is.
    let others: Vec<usize> = scene.other_sizes().into_iter().filter(|&pixels| scene.pixels() < 200 * pixels).collect();
    if let Some(&largest) = others.first() {
        let share = 100.0 * largest as f64 / scene.pixels() as f64;
        let doubt = if 50.0 <= share { ": look whether the right one was taken" } else { "" };
        notes.push(format!(
            "{} other object(s) were left out, the largest {share:.1} % of the size of the outlined one{doubt}",
            others.len()
        ));
    }
    notes
}

/// Points at equal steps along a closed polygon, a pixel or more apart.
fn evenly_spaced(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let n = points.len();
    let steps: Vec<f64> = (0..n).map(|i| (points[(i + 1) % n][0] - points[i][0]).hypot(points[(i + 1) % n][1] - points[i][1])).collect();
    let length: f64 = steps.iter().sum();
    let count = length.floor().clamp(1.0, MOST_POINTS) as usize;
    let spacing = length / count as f64;
    let (mut at, mut passed) = (0, 0.0);
    (0..count)
        .map(|k| {
            let wanted = k as f64 * spacing;
            while passed + steps[at] < wanted && at + 1 < n {
                passed += steps[at];
                at += 1;
            }
            let share = if 0.0 < steps[at] { (wanted - passed) / steps[at] } else { 0.0 };
            let (a, b) = (points[at], points[(at + 1) % n]);
            [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
        })
        .collect()
}
