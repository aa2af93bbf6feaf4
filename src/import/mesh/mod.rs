//! Meshes (OBJ, PLY, STL, glTF) → the drape's hem and its horizontal sections, in metres, z upwards.
//!
//! A drape mesh is an open sheet (its rim is the hem, and the waist of a skirt) or the closed skin of a thick one. Heights are measured along the
//! axis from the lowest point of the mesh unless told otherwise.

mod axis;
mod gltf;
mod loops;
mod obj;
mod ply;
mod raw;
mod sections;
mod stl;
mod surface;
mod unit;

use std::collections::BTreeMap;
use std::path::Path;

use self::raw::{Raw, Refusal};
use self::sections::{Loop, cut, outermost, rims};
use self::surface::{Space, Surface};
use super::source;
use crate::error::{Error, Place};
use crate::experiment::campaign::Meshes;
use crate::experiment::surface::{MeasuredSurface, Section};
use crate::experiment::{DrapeProfile, Point, Source};

/// Files of meshes, by extension.
const EXTENSIONS: [&str; 5] = ["obj", "ply", "stl", "gltf", "glb"];
/// An axis found by geometry must be twice as good as the next direction.
const LEAST_CONFIDENCE: f64 = 0.5;
/// An outline has at most this many points: more of them repeat the same triangles.
const MOST_POINTS: usize = 2000;
/// A rim is the hem or the waist, not a hole, if it is at least this share of the longest rim that goes round the axis.
const SHORTEST_RIM: f64 = 0.3;
/// Where there is no rim, the lowest closed section is looked for at so many heights over the lowest quarter of the mesh.
const LOOKED_AT: usize = 100;

/// From where heights are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Zero {
    /// The lowest point of the mesh: the lowest point of the hem, for a drape that hangs free. It needs no knowledge of the file's frame.
    #[default]
    Lowest,
    /// The highest point: the waist. Heights are then negative.
    Highest,
    /// The origin of the file's own frame.
    File,
}

/// How a mesh is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Axis and unit, where they are known.
    pub frame: Meshes,
    pub zero: Zero,
    /// Holes are bridged up to this share of a section's length. 5 %: a hole of a third of a fold of six, over which a straight line is
    /// still nearer to the cloth than the folds' own unevenness.
    pub largest_gap: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options { frame: Meshes::default(), zero: Zero::default(), largest_gap: 0.05 }
    }
}

/// Whether a file is read as a mesh, by its extension.
pub fn is_mesh(path: &Path) -> bool {
    extension(path).is_some_and(|e| EXTENSIONS.contains(&e.as_str()))
}

/// A direction as people write it: `z`, `-y`, or a vector `0,0.1,1`; `None` if it is none.
pub fn direction_named(text: &str) -> Option<[f64; 3]> {
    let (sign, name) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    match name {
        "x" => Some([sign, 0.0, 0.0]),
        "y" => Some([0.0, sign, 0.0]),
        "z" => Some([0.0, 0.0, sign]),
        _ => {
            let parts: Vec<f64> =
                text.split(',').map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect::<Option<_>>()?;
            parts.try_into().ok().filter(|v| *v != [0.0; 3])
        }
    }
}

/// The one profile of a mesh that a campaign or `hemline fit` takes: the hem.
#[derive(Debug, Clone, PartialEq)]
pub struct HemProfile {
    pub profile: DrapeProfile,
    pub source: Source,
    /// How the mesh was read and what stands for the hem.
    pub notes: Vec<String>,
}

/// The hem of the drape in a mesh: the longest rim of its lower half that goes round the axis, seen from above; of a closed skin the lowest
/// closed section.
///
/// # Errors
/// As [`read`]; [`Error::Input`] if the mesh has neither.
pub fn hem(path: &Path, options: &Options) -> Result<HemProfile, Error> {
    let mut mesh = read(path, options)?;
    let (profile, note) = mesh.hem().map_err(|problem| {
        Error::input(Place::file(path), problem, "look at the mesh: the whole hem must be in it; `hemline mesh` shows what is there")
    })?;
    mesh.notes.push(note);
    Ok(HemProfile { profile, source: mesh.source, notes: mesh.notes })
}

/// Reads a mesh and finds its axis and unit.
///
/// # Errors
/// [`Error::File`] if it cannot be read; [`Error::Input`] if it is no mesh, broken, or if its axis or unit cannot be told and was not given.
pub fn read(path: &Path, options: &Options) -> Result<DrapeMesh, Error> {
    let (bytes, source) = source::read(path)?;
    let at = |refusal: Refusal| {
        let mut place = Place::file(path);
        place.row = refusal.row;
        Error::input(place, refusal.problem, refusal.remedy)
    };
    let raw = match extension(path).as_deref() {
        Some("obj") => obj::read(&bytes),
        Some("ply") => ply::read(&bytes),
        Some("stl") => stl::read(&bytes),
        Some("gltf" | "glb") => self::gltf::read(&bytes),
        _ => Err(Refusal::new("no mesh, by its name", "the name must end in .obj, .ply, .stl, .gltf or .glb")),
    };
    drop(bytes);
    raw.and_then(|raw| DrapeMesh::new(raw, source, options)).map_err(at)
}

fn extension(path: &Path) -> Option<String> {
    path.extension().map(|e| e.to_string_lossy().to_lowercase())
}

/// A loop beside the outline, told so that a person can see what was left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OtherLoop {
    /// Length in plan, m.
    pub length: f64,
    /// What it is.
    pub kind: LoopKind,
}

/// What a loop is that is not the outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoopKind {
    /// Closed, inside the outline, round the axis: a body, a lining, the inner side of a thick cloth.
    Inner,
    /// Closed, but not round the axis.
    Beside,
    /// Not closed.
    Open,
}

/// One height, cut.
#[derive(Debug, Clone, PartialEq)]
pub struct Cut {
    /// m from the chosen zero, upwards.
    pub height: f64,
    /// The drape's outline there, or why there is none.
    pub outline: Result<Outline, String>,
    /// All other loops at this height, longest first.
    pub others: Vec<OtherLoop>,
}

/// The outline at one height.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    pub profile: DrapeProfile,
    /// Length in plan, m.
    pub length: f64,
    /// Enclosed area in plan, m².
    pub area: f64,
    /// Share of the length that was bridged over holes.
    pub bridged: f64,
    /// The mesh edges that it crosses.
    edges: Vec<[u32; 2]>,
}

/// A mesh in the frame of the drape: metres, z upwards, heights from the chosen zero.
#[derive(Debug, Clone)]
pub struct DrapeMesh {
    surface: Surface,
    /// Rims that go round the axis and are long enough to be hem or waist.
    rims: Vec<Loop>,
    /// A point of the axis.
    centre: Point,
    /// Unit vector upwards in the file's frame.
    pub up: [f64; 3],
    /// How sure the axis is, 0 … 1; `None` where it was given or belongs to the format.
    pub axis_confidence: Option<f64>,
    /// Metres per unit of the file.
    pub metres_per_unit: f64,
    /// Lowest and highest point, m.
    pub range: [f64; 2],
    pub largest_gap: f64,
    pub source: Source,
    /// How the mesh was read, one sentence each.
    pub notes: Vec<String>,
}

impl DrapeMesh {
    fn new(raw: Raw, source: Source, options: &Options) -> Result<Self, Refusal> {
        if !(0.0..=0.5).contains(&options.largest_gap) {
            return Err(Refusal::new(format!("a largest gap of {}", options.largest_gap), "it must be a share between 0 and 0.5"));
        }
        let mut notes = raw.notes.clone();
        let surface = surface::clean(&raw, &mut notes)?;
        let metres_per_unit = unit::decide(&surface, options.frame.unit.map(|u| u.0), raw.metres, &mut notes)?;
        let (up, axis_confidence) = decide_axis(&surface, options.frame.axis, raw.up, &mut notes)?;
        let mut surface = axis::turned(&surface, up);
        surface.vertices.iter_mut().flatten().for_each(|x| *x *= metres_per_unit);
        let heights = surface.vertices.iter().map(|v| v[2]);
        let [low, high] = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], z| [l.min(z), h.max(z)]);
        let zero = match options.zero {
            Zero::Lowest => low,
            Zero::Highest => high,
            Zero::File => 0.0,
        };
        surface.vertices.iter_mut().for_each(|v| v[2] -= zero);
        let range = [low - zero, high - zero];
        let centre = centre(&surface, range, options.largest_gap);
        let mut rims: Vec<Loop> = rims(&surface).into_iter().filter(|rim| rim.goes_round(centre)).collect();
        let longest = rims.first().map_or(0.0, |rim| rim.length);
        rims.retain(|rim| SHORTEST_RIM * longest <= rim.length);
        let largest_gap = options.largest_gap;
        Ok(DrapeMesh { surface, rims, centre, up, axis_confidence, metres_per_unit, range, largest_gap, source, notes })
    }

    /// Number of distinct vertices and of triangles.
    pub fn size(&self) -> (usize, usize) {
        (self.surface.vertices.len(), self.surface.triangles.len())
    }

    /// The hem in plan view and a sentence that says what was taken for it.
    ///
    /// # Errors
    /// Why there is none.
    pub fn hem(&self) -> Result<(DrapeProfile, String), String> {
        if let Some(rim) = self.hem_rim() {
            let [low, high] = self.rim_heights(rim);
            let profile = DrapeProfile::new(&thinned(&rim.points)).map_err(|e| e.to_string())?;
            let above = |height: f64| (height - self.range[0]) / crate::units::MILLIMETRE;
            let (count, low, high) = (rim.points.len(), above(low), above(high));
            let note = format!("the hem is the longest rim below: {count} vertices, {low:.1} to {high:.1} mm above the lowest point");
            return Ok((profile, note));
        }
        let [low, high] = self.range;
        let heights = (1..=LOOKED_AT).map(|i| low + 0.25 * (high - low) * i as f64 / LOOKED_AT as f64);
        for height in heights {
            if let Ok(outline) = self.cut(height).outline {
                let above = (height - low) / crate::units::MILLIMETRE;
                let note = format!(
                    "the mesh has no rim below: the lowest closed section, {above:.1} mm above the lowest point, stands for the hem"
                );
                return Ok((outline.profile, note));
            }
        }
        Err("neither a rim nor a closed section goes round the axis in the lower quarter of the mesh".into())
    }

    /// Lowest and highest point of the hem, m, where the mesh has a rim below.
    pub fn hem_heights(&self) -> Option<[f64; 2]> {
        self.hem_rim().map(|rim| self.rim_heights(rim))
    }

    /// The longest rim of the lower half: a lining or a body inside has a shorter one.
    fn hem_rim(&self) -> Option<&Loop> {
        let middle = 0.5 * (self.range[0] + self.range[1]);
        let below = |rim: &&Loop| self.rim_heights(rim).iter().sum::<f64>() <= 2.0 * middle;
        self.rims.iter().filter(below).max_by(|a, b| a.length.total_cmp(&b.length))
    }

    /// The outline of the drape at one height and what else is there.
    pub fn cut(&self, height: f64) -> Cut {
        let mut loops = cut(&self.surface, height, self.largest_gap);
        let Some(at) = outermost(&loops, self.centre) else {
            let reason = self.no_outline(height, &loops);
            return Cut { height, outline: Err(reason), others: loops.iter().map(|l| other(l, self.centre)).collect() };
        };
        let chosen = loops.remove(at);
        let others = loops.iter().map(|l| other(l, self.centre)).collect();
        let outline = DrapeProfile::new(&thinned(&chosen.points)).map_err(|e| e.to_string()).map(|profile| Outline {
            profile,
            length: chosen.length,
            area: chosen.area,
            bridged: chosen.bridged,
            edges: chosen.edges,
        });
        Cut { height, outline, others }
    }

    /// Heights evenly spread over where the drape can have closed sections: above the highest point of the hem, below the lowest of the waist.
    pub fn heights(&self, count: usize) -> Vec<f64> {
        let [low, high] = self.free_range();
        // Not on the rims themselves: half a step away.
        (0..count).map(|i| low + (high - low) * (i as f64 + 0.5) / count as f64).collect()
    }

    /// Multiples of `step` (m) within the mesh.
    pub fn heights_every(&self, step: f64) -> Vec<f64> {
        let [low, high] = self.range;
        let (first, last) = ((low / step).ceil(), (high / step).floor());
        // A step far below the size of the mesh asks for more sections than it has triangles.
        let count = ((last - first).max(-1.0) + 1.0).min(MOST_POINTS as f64) as usize;
        (0..count).map(|i| (first + i as f64) * step).collect()
    }

    /// What the fit of the surface takes from sections at `heights`.
    pub fn measured(&self, cuts: &[Cut]) -> MeasuredSurface {
        let mut sections: Vec<Section> = Vec::new();
        let mut number: BTreeMap<u32, usize> = BTreeMap::new();
        let mut measured = MeasuredSurface::default();
        let mut pairs: Vec<[usize; 2]> = Vec::new();
        for cut in cuts {
            let Ok(outline) = &cut.outline else { continue };
            sections.push(Section { height: cut.height, profile: outline.profile.clone() });
            let mut point = |vertex: u32| {
                *number.entry(vertex).or_insert_with(|| {
                    measured.points.push(self.surface.vertices[vertex as usize]);
                    measured.points.len() - 1
                })
            };
            let ends: Vec<[usize; 2]> = outline.edges.iter().map(|edge| edge.map(&mut point)).collect();
            let next = ends.iter().cycle().skip(1);
            // Along the edge, and across to the vertex that the next edge of the section does not share.
            pairs.extend(
                ends.iter()
                    .zip(next)
                    .flat_map(|(here, next)| {
                        let across = next.iter().find(|v| !here.contains(v)).map(|&new| {
                            let old = if next.contains(&here[0]) { here[1] } else { here[0] };
                            [old.min(new), old.max(new)]
                        });
                        [Some([here[0].min(here[1]), here[0].max(here[1])]), across]
                    })
                    .flatten(),
            );
        }
        pairs.sort_unstable();
        pairs.dedup();
        sections.sort_by(|a, b| a.height.total_cmp(&b.height));
        MeasuredSurface { sections, neighbours: pairs, ..measured }
    }

    /// From the highest point of the hem to the lowest of the waist, where these are rims.
    fn free_range(&self) -> [f64; 2] {
        let middle = 0.5 * (self.range[0] + self.range[1]);
        let [mut low, mut high] = self.range;
        for [least, most] in self.rims.iter().map(|rim| self.rim_heights(rim)) {
            if most < middle {
                low = low.max(most);
            } else if middle < least {
                high = high.min(least);
            }
        }
        [low, high]
    }

    fn rim_heights(&self, rim: &Loop) -> [f64; 2] {
        let heights = rim.edges.iter().map(|edge| self.surface.vertices[edge[0] as usize][2]);
        heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)])
    }

    fn no_outline(&self, height: f64, loops: &[Loop]) -> String {
        let [low, high] = self.range;
        if height <= low || high <= height {
            return "outside of the mesh".into();
        }
        let open = loops.iter().filter(|l| !l.closed).count();
        match self.hem_heights() {
            Some([_, top]) if height < top => "the hem rises above this height: the section is not closed".into(),
            _ if 0 < open => {
                format!("{open} open pieces: holes of more than {:.0} % of the section", self.largest_gap / crate::units::PERCENT)
            }
            _ => "no closed loop goes round the axis".into(),
        }
    }
}

fn other(of: &Loop, centre: Point) -> OtherLoop {
    let kind = match (of.closed, of.goes_round(centre)) {
        (false, _) => LoopKind::Open,
        (true, true) => LoopKind::Inner,
        (true, false) => LoopKind::Beside,
    };
    OtherLoop { length: of.length, kind }
}

/// Every k-th point, so that few enough are left.
fn thinned(points: &[Point]) -> Vec<Point> {
    points.iter().copied().step_by(points.len().div_ceil(MOST_POINTS).max(1)).collect()
}

/// A point of the axis: the mean of the centroids of the longest sections.
fn centre(surface: &Surface, [low, high]: [f64; 2], gap: f64) -> Point {
    let mut sum = [0.0; 3];
    for share in [0.3, 0.4, 0.5, 0.6, 0.7] {
        let loops = cut(surface, low + share * (high - low), gap);
        if let Some(longest) = loops.iter().find(|l| l.closed) {
            let n = longest.points.len();
            let pieces = (0..n).map(|i| (longest.points[i], longest.points[(i + 1) % n]));
            let [x, y, length] = pieces.fold([0.0; 3], |[x, y, l], (a, b)| {
                let d = a.distance(b);
                [x + 0.5 * d * (a.x + b.x), y + 0.5 * d * (a.y + b.y), l + d]
            });
            if 0.0 < length {
                sum = [sum[0] + x / length, sum[1] + y / length, sum[2] + 1.0];
            }
        }
    }
    let of_vertices = |k: usize| surface.vertices.iter().map(|v| v[k]).sum::<f64>() / surface.vertices.len() as f64;
    if 0.0 < sum[2] { Point::new(sum[0] / sum[2], sum[1] / sum[2]) } else { Point::new(of_vertices(0), of_vertices(1)) }
}

/// The upward direction and, where geometry found it, how sure it is.
fn decide_axis(
    surface: &Surface,
    asked: Option<[f64; 3]>,
    standard: Option<Space>,
    notes: &mut Vec<String>,
) -> Result<(Space, Option<f64>), Refusal> {
    if let Some(asked) = asked {
        let up = surface::unit(asked);
        if surface::dot(up, up).partial_cmp(&0.5).is_none_or(std::cmp::Ordering::is_lt) {
            return Err(Refusal::new("the axis asked for has no direction", "give one as z, -y or 0.1,0,1"));
        }
        return Ok((up, None));
    }
    let found = axis::find(surface);
    let name = direction(found.up);
    if let Some(up) = standard {
        if surface::dot(up, found.up) < 0.9 && LEAST_CONFIDENCE <= found.confidence {
            notes.push(format!("up is {} by the format; the mesh itself looks as if up were {name}: if so, ask for it", direction(up)));
        }
        return Ok((up, None));
    }
    if found.confidence < LEAST_CONFIDENCE {
        let problem = format!("it cannot be told which way is up: {name} is likeliest, with confidence {:.2}", found.confidence);
        return Err(Refusal::new(problem, "say which direction of the file is up: z, -z, y …"));
    }
    notes.push(format!("up is {name} of the file, found by its round sections, confidence {:.2}", found.confidence));
    Ok((found.up, Some(found.confidence)))
}

/// A direction in words: `z`, `-y`, `(0.02, 0.00, 1.00)`.
fn direction(up: Space) -> String {
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        if 1.0 - 1e-12 < up[axis].abs() {
            return if 0.0 < up[axis] { (*name).into() } else { format!("-{name}") };
        }
    }
    format!("({:.3}, {:.3}, {:.3})", up[0], up[1], up[2])
}
