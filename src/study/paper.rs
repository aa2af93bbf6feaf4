//! The paper, recomputed: its Table 1, its thin-shell test, and how far its equations hold along its own curve.
//!
//! What is printed stands beside what is computed; what does not hold is said in words.

use serde::Serialize;

use crate::error::Error;
use crate::experiment::Skirt;
use crate::model::functional::{Equations, PaperFunctional};
use crate::model::hem::Hem;
use crate::model::skirt::{Cone, from_body, thinness};
use crate::model::surface::{LinearSurface, RuledForm};
use crate::simulate::{Cloth, ansatz, polar};
use crate::units::Metre;

/// Waist girth of the paper's figure, m.
pub const WAIST_GIRTH: f64 = 0.76;
/// Hip girth, m.
pub const HIP_GIRTH: f64 = 1.04;
/// Height between waist and hip, m.
pub const HIP_DEPTH: f64 = 0.20;
/// Length of the skirt along the slant, m.
pub const SLANT: f64 = 0.53;
/// Cloth thickness of the paper's thin-shell example, m.
pub const THICKNESS: f64 = 1e-3;
/// Fold counts for which equation (4) and the functional are tabulated.
pub const FOLDS: std::ops::RangeInclusive<u32> = 2..=12;
/// Fold count of the paper's surface (18), there called ω.
pub const SURFACE_FOLDS: u32 = 8;
/// Generatrices of the space form: enough for a smooth line.
const GENERATRICES: usize = 400;
/// Conicities (R_n − R_t)/L, twice that of Table 1 and more, that are tried for a hem that overhangs.
const CONICITIES: [f64; 5] = [0.45, 0.5, 0.55, 0.6, 0.65];

/// One line of Table 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableRow {
    pub quantity: &'static str,
    /// `m` or `rad`.
    pub unit: &'static str,
    /// As the paper prints it, in `unit`.
    pub printed: f64,
    /// Half a unit of the last printed digit.
    pub rounding: f64,
    pub computed: f64,
}

impl TableRow {
    /// Whether the printed value is the computed one, rounded.
    pub fn agrees(&self) -> bool {
        // The printed digits were typed, not computed: allow the rounding of that comparison.
        (self.printed - self.computed).abs() <= self.rounding * (1.0 + 1e-9)
    }
}

/// What the functional and equation (4) say about one fold count.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoldRow {
    pub folds: u32,
    /// Least J over p and q at the hem's length (s = 0), N/m; it falls with every fold, so it cannot choose.
    pub functional: Option<f64>,
    /// Its multiplier, N/m².
    pub lambda: Option<f64>,
    /// Hem radius at which equation (4) starts to fold, m.
    pub onset: Option<f64>,
    /// Hem radius at which its polar form ends, m.
    pub limit: Option<f64>,
}

/// The paper's claims against computation.
#[derive(Debug, Clone)]
pub struct PaperCheck {
    /// The skirt of Table 1, from the body.
    pub skirt: Skirt,
    pub table: Vec<TableRow>,
    /// δ = h_T/(2πR_t) of the thin-shell test (1), and whether it is below 1/20.
    pub thinness: (f64, bool),
    /// The curve along which the equations were evaluated: least ruled energy at its fold count.
    pub hem: Hem,
    /// Equations (15) to (17) along it.
    pub equations: Option<Equations>,
    pub folds: Vec<FoldRow>,
    /// Table 1's skirt with its hem as a curve in space; `None` if the slant does not reach the hem.
    pub space: Option<RuledForm>,
    /// The least conic of some wider skirts whose approximate solution overhangs, and that curve; `None` if none of them does.
    pub wide: Option<(Skirt, Hem)>,
    /// The surface (18) with the paper's eight folds, or with those of `hem` where this cloth is too stiff for eight.
    pub surface: LinearSurface,
    /// What does not hold, in words, each with its number.
    pub findings: Vec<String>,
}

/// Recomputes the paper for `cloth`, with the folds of its example or of least energy along its approximate solution.
///
/// `foundation` is E, N/m³, of which the paper gives no usable value (E = B/I has another unit).
///
/// # Errors
/// As [`crate::simulate::predict`].
pub fn check(cloth: &Cloth, foundation: f64) -> Result<PaperCheck, Error> {
    let skirt = from_body(Metre(WAIST_GIRTH), Metre(HIP_GIRTH), Metre(HIP_DEPTH), Metre(SLANT))?;
    let cone = Cone::of(&skirt);
    let hip = HIP_GIRTH / std::f64::consts::TAU;
    let row = |quantity, unit, printed, rounding, computed| TableRow { quantity, unit, printed, rounding, computed };
    let table = vec![
        row("waist radius R_t", "m", 0.121, 0.5e-3, cone.waist_radius),
        row("hip radius R_b", "m", 0.1655, 0.5e-4, hip),
        row("base angle β", "rad", 1.35, 0.5e-2, cone.base_angle),
        row("hem radius R_n", "m", 0.2362, 0.5e-4, cone.hem_radius),
        row("height H", "m", 0.5173, 0.5e-4, cone.height),
        row("pattern radius R_v", "m", 0.5562, 0.5e-4, cone.pattern_radius.unwrap_or(f64::INFINITY)),
        row("pattern angle α", "rad", 1.37, 0.5e-2, cone.pattern_angle),
    ];
    let hem = ansatz::least(&skirt, cloth)?;
    let functional = PaperFunctional::new(&skirt, cloth.weight(), foundation);
    let equations = functional.equations(&hem);
    let folds: Vec<FoldRow> = FOLDS
        .map(|m| {
            let ritz = ansatz::paper(&skirt, cloth.weight(), foundation, m, false);
            let range = polar::range(&skirt, cloth.weight(), foundation, m);
            FoldRow {
                folds: m,
                functional: ritz.map(|r| r.functional),
                lambda: ritz.map(|r| r.lambda),
                onset: range.map(|r| r.onset),
                limit: range.and_then(|r| r.limit),
            }
        })
        .collect();
    let thinness = thinness(&skirt, THICKNESS);
    let mut findings = findings(&table, equations.as_ref(), &folds, cone.hem_radius);
    let space = RuledForm::new(&skirt, &hem, GENERATRICES);
    let wide = overhanging(&skirt, cloth);
    let surface = LinearSurface::new(&skirt, ansatz::at(&skirt, cloth, SURFACE_FOLDS).unwrap_or(hem));
    let (excess, at) = surface.ring_excess();
    findings.push(format!(
            "The surface (18) takes p and q linear in height: {:.0} % of the way down its rings are then {:.1} % {} than their cloth. It is a picture, not an inextensible shell.",
            100.0 * at,
            100.0 * excess.abs(),
            if excess < 0.0 { "shorter" } else { "longer" }
        ));
    Ok(PaperCheck { skirt, table, thinness, hem, equations, folds, space, wide, surface, findings })
}

/// The first of some wider skirts, as long and as wide at the waist, whose curve meets some ray more than once.
fn overhanging(skirt: &Skirt, cloth: &Cloth) -> Option<(Skirt, Hem)> {
    CONICITIES.iter().find_map(|conicity| {
        let hem_radius = Metre(skirt.waist_radius().0 + conicity * skirt.slant_length().0);
        let wide = Skirt::new(skirt.waist_radius(), hem_radius, skirt.slant_length()).ok()?;
        Some((wide, ansatz::least(&wide, cloth).ok().filter(Hem::overhangs)?))
    })
}

fn findings(table: &[TableRow], equations: Option<&Equations>, folds: &[FoldRow], hem_radius: f64) -> Vec<String> {
    let mut out = Vec::new();
    let differing: Vec<&str> = table.iter().filter(|r| !r.agrees()).map(|r| r.quantity).collect();
    out.push(if differing.is_empty() {
        "Table 1 follows from the body measures to every printed digit.".to_string()
    } else {
        format!("Table 1 differs from what follows from the body measures in: {}.", differing.join(", "))
    });
    out.push("E = B/I, as printed, is in Pa; the functional needs N/m³. E is taken as given data.".into());
    if let Some(e) = equations {
        out.push(format!(
            "Equations (15) and (16) claim two first integrals; a Lagrangian free of t has one. With their constants fitted they leave {:.0} % and {:.0} % of the spread of G unexplained along the approximate solution.",
            100.0 * e.fifteen.residual,
            100.0 * e.sixteen.residual
        ));
        out.push(format!(
            "Their sum, λ v = 2G − C, is the one that follows from the Lagrangian; along the approximate solution it leaves {:.0} % unexplained: the curve is no solution of the equations.",
            100.0 * e.sum.residual
        ));
        out.push(format!(
            "Their difference, the second line of (17), asks (x′² − y′²)/v to be constant. Its variation is {:.0} % of its size: no closed curve satisfies it, because the tangent turns through all directions.",
            100.0 * e.difference
        ));
    }
    let known: Vec<(u32, f64)> = folds.iter().filter_map(|row| Some((row.folds, row.functional?))).collect();
    // Folds that do not exist yet (a hem below the onset) all share the circle's value.
    if let (Some((first, high)), Some((last, low))) = (known.first(), known.last()) {
        let falls = known.windows(2).all(|pair| pair[1].1 <= pair[0].1);
        out.push(format!(
            "The functional (10) has no curvature energy: from {first} to {last} folds it {} from {high:.4} to {low:.4} N/m, so it cannot choose the fold count.",
            if falls { "falls steadily" } else { "goes" }
        ));
    }
    let ended: Vec<u32> = folds.iter().filter(|row| row.limit.is_some_and(|limit| limit < hem_radius)).map(|row| row.folds).collect();
    out.push(if ended.is_empty() {
        "At this hem the polar equation (4) is within its limits at every tabulated fold count.".to_string()
    } else {
        format!("At this hem the polar form of equation (4) has ended for m = {ended:?}: the curve overhangs.")
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Fabric;
    use crate::units::{KilogramPerSquareMetre, NewtonMetre, STANDARD_GRAVITY};

    #[test]
    fn paper_s_table_stands_and_its_first_integrals_fall() {
        let fabric = Fabric { areal_density: Some(KilogramPerSquareMetre(0.2)), flexural_rigidity: Some(NewtonMetre(1e-5)) };
        let check = check(&Cloth::of(&fabric, STANDARD_GRAVITY).unwrap(), 0.0).unwrap();
        assert!(check.table.iter().all(TableRow::agrees), "{:?}", check.table);
        assert!(check.thinness.1);
        assert_eq!(check.hem.folds, 5);
        let equations = check.equations.unwrap();
        assert!(0.9 < equations.sum.residual && 0.9 < equations.fifteen.residual && 0.99 < equations.difference);
        let functional: Vec<f64> = check.folds.iter().filter_map(|row| row.functional).collect();
        assert!(functional.windows(2).all(|pair| pair[1] <= pair[0]), "{functional:?}");
        for row in &check.folds {
            assert!(row.onset.unwrap() < row.limit.unwrap_or(f64::INFINITY), "{row:?}");
        }
        assert_eq!(check.findings.len(), 8);
    }
}
