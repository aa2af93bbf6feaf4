//! The result of `hemline mesh` for a person.

use super::document::{kind, of_height};
use crate::fit::Estimate;
use crate::fit::surface::{Line, Method, SurfaceFit};
use crate::import::mesh::{Cut, DrapeMesh};
use crate::report::number::with_error;
use crate::units::{MILLIMETRE, PERCENT};

/// The mesh, the sections in a table, the surface.
pub(super) fn text_of(mesh: &DrapeMesh, cuts: &[Cut], surface: &Result<SurfaceFit, String>) -> String {
    let (vertices, triangles) = mesh.size();
    let [low, high] = mesh.range.map(|z| z / MILLIMETRE);
    let mut lines = vec![
        format!("{}: {vertices} vertices, {triangles} triangles, z from {low:.1} to {high:.1} mm", mesh.source.file.display()),
        match mesh.hem_heights() {
            Some([from, to]) => format!("hem: a rim between z = {:.1} and {:.1} mm", from / MILLIMETRE, to / MILLIMETRE),
            None => "hem: no rim below".into(),
        },
        String::new(),
        format!(
            "{:>9} {:>7} {:>10} {:>9} {:>4} {:>18} {:>18} {:>18} {:>8} {:>9}  other loops",
            "z, mm", "points", "length, mm", "bridged", "m", "p, mm", "q, mm", "s, mm", "rms, mm", "surface"
        ),
    ];
    lines.extend(cuts.iter().map(|cut| row(cut, surface.as_ref().ok())));
    lines.push(String::new());
    match surface {
        Ok(surface) => lines.extend(of_surface(surface)),
        Err(reason) => lines.push(format!("No surface: {reason}.")),
    }
    lines.join("\n") + "\n"
}

fn row(cut: &Cut, surface: Option<&SurfaceFit>) -> String {
    let z = cut.height / MILLIMETRE;
    let outline = match &cut.outline {
        Ok(outline) => outline,
        Err(reason) => return format!("{z:>9.1} {reason}"),
    };
    let own = surface.and_then(|s| of_height(s, cut.height));
    let alone = own.and_then(|s| s.alone.as_ref().ok());
    let length =
        |e: Option<Estimate>| e.map_or("–".into(), |e| with_error(e.value / MILLIMETRE, e.standard_error.map(|se| se / MILLIMETRE)));
    let number = |value: Option<f64>| value.map_or("–".into(), |v| format!("{:.3}", v / MILLIMETRE));
    let others: Vec<String> = cut.others.iter().take(4).map(|o| format!("{} {:.0} mm", kind(o), o.length / MILLIMETRE)).collect();
    format!(
        "{z:>9.1} {:>7} {:>10.1} {:>9} {:>4} {:>18} {:>18} {:>18} {:>8} {:>9}  {}{}",
        outline.profile.points().len(),
        outline.length / MILLIMETRE,
        format!("{:.1} %", outline.bridged / PERCENT),
        alone.and_then(|f| f.folds).map_or("–".into(), |m| m.to_string()),
        length(alone.map(|f| f.p)),
        length(alone.and_then(|f| f.q)),
        length(alone.and_then(|f| f.s)),
        number(alone.map(|f| f.rms)),
        number(own.map(|s| s.rms)),
        others.join(", "),
        if 4 < cut.others.len() { ", …" } else { "" }
    )
}

fn of_surface(s: &SurfaceFit) -> Vec<String> {
    let how = match &s.method {
        Method::Joint => "all points at once".to_owned(),
        Method::Sections { because } => format!("lines through the sections, because {because}"),
    };
    let (from, to) = (s.range[0] / MILLIMETRE, s.range[1] / MILLIMETRE);
    let mut lines = vec![format!(
        "Surface with {} folds over z = {from:.1} … {to:.1} mm; {how}; {} points, rms {:.3} mm",
        s.folds,
        s.distances.len(),
        s.rms / MILLIMETRE
    )];
    let [x, y] = &s.axis;
    for (name, line, a, b) in
        [("p", &s.p, "a1", "b1"), ("q", &s.q, "a2", "b2"), ("s", &s.s, "a3", "b3"), ("x0", x, "", ""), ("y0", y, "", "")]
    {
        lines.push(straight(name, line, a, b));
    }
    lines.push(format!("  phase  {} rad", with_error(s.phase.value, s.phase.standard_error)));
    for (name, lack) in ["p", "q", "s"].iter().zip(&s.lack_of_fit) {
        let Some(lack) = lack else { continue };
        let explained =
            lack.explained.map_or(String::new(), |e| format!("; the line explains {:.1} % of its change with height", e / PERCENT));
        lines.push(format!(
            "  {name} of the sections departs from its line by {:.3} mm rms, most {:+.3} mm at z = {:.1} mm{explained}",
            lack.rms / MILLIMETRE,
            lack.largest / MILLIMETRE,
            lack.at / MILLIMETRE
        ));
    }
    lines
}

fn straight(name: &str, line: &Line, a: &str, b: &str) -> String {
    let intercept = with_error(line.a.value / MILLIMETRE, line.a.standard_error.map(|se| se / MILLIMETRE));
    let slope = with_error(line.b.value, line.b.standard_error);
    let names = if a.is_empty() { String::new() } else { format!("   {a} = {intercept} mm, {b} = {slope}") };
    if a.is_empty() { format!("  {name}(z) = {intercept} mm + ({slope}) z") } else { format!("  {name}(z) = {a} + {b} z{names}") }
}
