//! The result of `hemline mesh` for programs: tables of points, and one JSON document in mm.

use serde::Serialize;

use crate::error::Error;
use crate::fit::Estimate;
use crate::fit::surface::{LackOfFit, Line, Method, SectionFit, SurfaceFit};
use crate::import::mesh::{Cut, DrapeMesh, LoopKind, OtherLoop};
use crate::report::csv::{Cell, Table};
use crate::units::MILLIMETRE;

/// Every point of every section; the column names are those that a profile table has.
pub(super) fn sections(cuts: &[Cut]) -> Table {
    let mut table = Table::new(&["profile", "x_mm", "y_mm", "z_mm"]);
    for cut in cuts {
        let Ok(outline) = &cut.outline else { continue };
        let name = format!("z{:.1}", cut.height / MILLIMETRE);
        for point in outline.profile.points() {
            let numbers = [point.x, point.y, cut.height].map(|value| Cell::from(value / MILLIMETRE));
            table.push(std::iter::once(Cell::from(name.clone())).chain(numbers).collect());
        }
    }
    table
}

/// Every fitted point and its distance from the surface.
pub(super) fn distances(surface: &SurfaceFit) -> Table {
    let mut table = Table::new(&["x_mm", "y_mm", "z_mm", "distance_mm"]);
    for ([x, y, z], distance) in &surface.distances {
        table.push([*x, *y, *z, *distance].map(|value| Cell::from(value / MILLIMETRE)).to_vec());
    }
    table
}

/// Everything, as JSON.
///
/// # Errors
/// [`Error::Output`] if it cannot be written as JSON.
pub(super) fn json(mesh: &DrapeMesh, cuts: &[Cut], surface: &Result<SurfaceFit, String>) -> Result<String, Error> {
    let (vertices, triangles) = mesh.size();
    let document = Document {
        file: mesh.source.file.display().to_string(),
        digest: &mesh.source.digest,
        vertices,
        triangles,
        up: mesh.up,
        axis_confidence: mesh.axis_confidence,
        metres_per_unit: mesh.metres_per_unit,
        lowest_mm: mesh.range[0] / MILLIMETRE,
        highest_mm: mesh.range[1] / MILLIMETRE,
        hem_heights_mm: mesh.hem_heights().map(|h| h.map(|x| x / MILLIMETRE)),
        sections: cuts.iter().map(|cut| section(cut, surface.as_ref().ok())).collect(),
        surface: surface.as_ref().ok().map(surface_of),
        surface_missing: surface.as_ref().err().map(String::as_str),
        notes: mesh.notes.iter().chain(surface.as_ref().map(|s| &s.notes).into_iter().flatten()).map(String::as_str).collect(),
    };
    let text = serde_json::to_string_pretty(&document);
    text.map(|text| text + "\n").map_err(|why| Error::Output { what: "the JSON result".into(), why: why.to_string() })
}

#[derive(Serialize)]
struct Document<'a> {
    file: String,
    digest: &'a str,
    vertices: usize,
    triangles: usize,
    /// Unit vector in the file's frame.
    up: [f64; 3],
    axis_confidence: Option<f64>,
    metres_per_unit: f64,
    lowest_mm: f64,
    highest_mm: f64,
    hem_heights_mm: Option<[f64; 2]>,
    sections: Vec<SectionJson<'a>>,
    surface: Option<SurfaceJson<'a>>,
    surface_missing: Option<&'a str>,
    notes: Vec<&'a str>,
}

#[derive(Serialize)]
struct SectionJson<'a> {
    height_mm: f64,
    missing: Option<&'a str>,
    points: Option<usize>,
    length_mm: Option<f64>,
    area_mm2: Option<f64>,
    bridged_share: Option<f64>,
    other_loops: Vec<LoopJson>,
    /// Of the section alone.
    m: Option<u32>,
    p_mm: Option<Quantity>,
    q_mm: Option<Quantity>,
    s_mm: Option<Quantity>,
    rms_mm: Option<f64>,
    not_fitted: Option<&'a str>,
    /// Of the section's points about the surface.
    surface_rms_mm: Option<f64>,
}

#[derive(Serialize)]
struct LoopJson {
    kind: &'static str,
    length_mm: f64,
}

#[derive(Serialize, Clone, Copy)]
struct Quantity {
    value: f64,
    se: Option<f64>,
}

#[derive(Serialize)]
struct SurfaceJson<'a> {
    method: &'static str,
    method_because: Option<&'a str>,
    m: u32,
    a1_mm: Quantity,
    b1: Quantity,
    a2_mm: Quantity,
    b2: Quantity,
    a3_mm: Quantity,
    b3: Quantity,
    phase_rad: Quantity,
    /// Place of the axis at z = 0 and its lean.
    x0_mm: Quantity,
    x_by_z: Quantity,
    y0_mm: Quantity,
    y_by_z: Quantity,
    from_mm: f64,
    to_mm: f64,
    points: usize,
    rms_mm: f64,
    neighbour_correlation: Option<f64>,
    se_inflation: f64,
    lack_of_fit: [Option<LackJson>; 3],
    evaluations: usize,
    /// x, y, z and distance of every fitted point.
    distances_mm: Vec<[f64; 4]>,
}

#[derive(Serialize)]
struct LackJson {
    of: &'static str,
    rms_mm: f64,
    largest_mm: f64,
    at_mm: f64,
    explained_share: Option<f64>,
}

/// What a loop beside the outline is called.
pub(super) fn kind(of: &OtherLoop) -> &'static str {
    match of.kind {
        LoopKind::Inner => "inner",
        LoopKind::Beside => "beside",
        LoopKind::Open => "open",
    }
}

fn section<'a>(cut: &'a Cut, surface: Option<&'a SurfaceFit>) -> SectionJson<'a> {
    let outline = cut.outline.as_ref().ok();
    let own = surface.and_then(|s| of_height(s, cut.height));
    let alone = own.and_then(|s| s.alone.as_ref().ok());
    SectionJson {
        height_mm: cut.height / MILLIMETRE,
        missing: cut.outline.as_ref().err().map(String::as_str),
        points: outline.map(|o| o.profile.points().len()),
        length_mm: outline.map(|o| o.length / MILLIMETRE),
        area_mm2: outline.map(|o| o.area / MILLIMETRE / MILLIMETRE),
        bridged_share: outline.map(|o| o.bridged),
        other_loops: cut.others.iter().map(|o| LoopJson { kind: kind(o), length_mm: o.length / MILLIMETRE }).collect(),
        m: alone.and_then(|f| f.folds),
        p_mm: alone.map(|f| length(f.p)),
        q_mm: alone.and_then(|f| f.q).map(length),
        s_mm: alone.and_then(|f| f.s).map(length),
        rms_mm: alone.map(|f| f.rms / MILLIMETRE),
        not_fitted: own.and_then(|s| s.alone.as_ref().err()).map(String::as_str),
        surface_rms_mm: own.map(|s| s.rms / MILLIMETRE),
    }
}

/// The section of the fit at the height of a cut; heights are carried over unchanged.
pub(super) fn of_height(surface: &SurfaceFit, height: f64) -> Option<&SectionFit> {
    surface.sections.iter().find(|s| s.height == height)
}

fn surface_of(s: &SurfaceFit) -> SurfaceJson<'_> {
    let (method, method_because) = match &s.method {
        Method::Joint => ("joint", None),
        Method::Sections { because } => ("sections", Some(because.as_str())),
    };
    let lack = |of: &'static str, l: &Option<LackOfFit>| {
        l.map(|l| LackJson {
            of,
            rms_mm: l.rms / MILLIMETRE,
            largest_mm: l.largest / MILLIMETRE,
            at_mm: l.at / MILLIMETRE,
            explained_share: l.explained,
        })
    };
    let ([x, y], b) = (&s.axis, |line: &Line| pure(line.b));
    SurfaceJson {
        method,
        method_because,
        m: s.folds,
        a1_mm: length(s.p.a),
        b1: b(&s.p),
        a2_mm: length(s.q.a),
        b2: b(&s.q),
        a3_mm: length(s.s.a),
        b3: b(&s.s),
        phase_rad: pure(s.phase),
        x0_mm: length(x.a),
        x_by_z: b(x),
        y0_mm: length(y.a),
        y_by_z: b(y),
        from_mm: s.range[0] / MILLIMETRE,
        to_mm: s.range[1] / MILLIMETRE,
        points: s.distances.len(),
        rms_mm: s.rms / MILLIMETRE,
        neighbour_correlation: s.neighbour_correlation,
        se_inflation: s.inflation,
        lack_of_fit: [lack("p", &s.lack_of_fit[0]), lack("q", &s.lack_of_fit[1]), lack("s", &s.lack_of_fit[2])],
        evaluations: s.evaluations,
        distances_mm: s.distances.iter().map(|([x, y, z], d)| [*x, *y, *z, *d].map(|v| v / MILLIMETRE)).collect(),
    }
}

fn length(e: Estimate) -> Quantity {
    Quantity { value: e.value / MILLIMETRE, se: e.standard_error.map(|se| se / MILLIMETRE) }
}

fn pure(e: Estimate) -> Quantity {
    Quantity { value: e.value, se: e.standard_error }
}
