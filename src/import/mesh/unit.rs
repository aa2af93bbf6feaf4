//! The unit of a mesh: given, known from the format, or told from the size of what can be a drape.

use super::raw::Refusal;
use super::surface::Surface;
use crate::units;

/// The largest extent of a drape, m: a small drape tester's specimen … a long, wide skirt.
const PLAUSIBLE: std::ops::RangeInclusive<f64> = 0.1..=1.6;
/// Units that are guessed among; inches never, because they are too near to centimetres.
const USUAL: [&str; 3] = ["mm", "cm", "m"];
/// What is refused even if asked for: a hundred metres of cloth or a millimetre.
const POSSIBLE: std::ops::RangeInclusive<f64> = 1e-3..=100.0;

/// Metres per unit of the file.
pub(super) fn decide(surface: &Surface, asked: Option<f64>, standard: Option<f64>, notes: &mut Vec<String>) -> Result<f64, Refusal> {
    let extent = extent(surface);
    if let Some(metres) = asked.or(standard) {
        if !POSSIBLE.contains(&(extent * metres)) {
            let problem = format!("the mesh is {:.3e} m large in the unit given", extent * metres);
            return Err(Refusal::new(problem, "give the unit of the file's coordinates: mm, cm, m or in"));
        }
        return Ok(metres);
    }
    let fits: Vec<(&str, f64)> = USUAL
        .iter()
        .filter_map(|unit| Some((*unit, units::factor(unit)?)))
        .filter(|(_, metres)| PLAUSIBLE.contains(&(extent * metres)))
        .collect();
    match fits[..] {
        [(unit, metres)] => {
            notes.push(format!("the file has no unit: taken as {unit}, because only so is it a drape ({:.3} m large)", extent * metres));
            Ok(metres)
        }
        [] => Err(Refusal::new(
            format!("the unit cannot be told: the mesh is {extent:.4} units large, which is no drape in mm, cm or m"),
            "say the unit of its coordinates: mm, cm, m or in",
        )),
        _ => {
            let readings: Vec<String> = fits.iter().map(|(unit, metres)| format!("{:.2} m if in {unit}", extent * metres)).collect();
            Err(Refusal::new(
                format!("the unit cannot be told: the mesh is {}", readings.join(", ")),
                "say the unit of its coordinates: mm, cm, m or in",
            ))
        }
    }
}

/// Largest side of the box round the mesh.
fn extent(surface: &Surface) -> f64 {
    (0..3)
        .map(|axis| {
            let values = surface.vertices.iter().map(|v| v[axis]);
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            high - low
        })
        .fold(0.0, f64::max)
}
