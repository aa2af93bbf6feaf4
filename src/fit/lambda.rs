//! The Lagrange multiplier of a fitted hem, three ways, each with how well it holds.

use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

use super::outcome::Estimate;
use crate::experiment::{Fabric, Skirt};
use crate::model::ansatz::AnsatzShell;
use crate::model::functional::{HemJet, PaperFunctional, perimeter};
use crate::model::hem::Hem;

/// λ three ways (docs/model.md, section 3); `None` where a quantity does not exist, with the reason in `missing`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Lambda {
    /// Slope of 2G on v along the curve, N/m²; and R².
    pub first_integral: Option<(Estimate, f64)>,
    /// Least squares of ∇J = λ∇Λ over (p, q, s), N/m²; and the angle between the gradients, degrees.
    pub ritz: Option<(Estimate, f64)>,
    /// The same with the energy of the ruled shell, N; and the angle, degrees.
    pub ruled: Option<(Estimate, f64)>,
    /// λ/(ρ_A g) with E = 0 by the first integral (dimensionless), and R²; exists without cloth data.
    pub over_weight: Option<(Estimate, f64)>,
    /// λ/(ρ_A g) with E = 0 by the Ritz condition (dimensionless), and the angle, degrees; exists without cloth data.
    pub over_weight_ritz: Option<(Estimate, f64)>,
    pub missing: Option<String>,
}

/// λ of a fitted hem.
///
/// `covariance` of (p, q, s), m², from the fit; without it there are no standard errors. `gravity` in m/s², `foundation_modulus` E in N/m³.
/// Standard errors by the delta method: first order in the uncertainty of p, q, s, with exact derivatives; cloth and cut count as known.
pub fn lambda(
    hem: &Hem,
    covariance: Option<&[[f64; 3]; 3]>,
    skirt: Option<&Skirt>,
    fabric: &Fabric,
    gravity: f64,
    foundation_modulus: f64,
) -> Lambda {
    let Some(skirt) = skirt else {
        return Lambda { missing: Some("the cut (waist radius, slant) is not known".into()), ..Lambda::default() };
    };
    let mut missing = Vec::new();
    let length = perimeter(hem);
    let estimate = |value: f64, gradient: Vector3<f64>| Estimate { value, standard_error: standard_error(&gradient, covariance) };
    let from_first = |functional: &PaperFunctional| {
        let (slope, determination) = functional.first_integral(hem)?;
        Some((estimate(slope.value, Vector3::from(slope.gradient)), determination))
    };
    let from_ritz = |objective: HemJet| ritz(&objective, &length).map(|(value, angle, gradient)| (estimate(value, gradient), angle));
    let mut out = Lambda::default();
    // Unit weight and no foundation: what the shape alone says.
    let shape = PaperFunctional::new(skirt, 1.0, 0.0);
    match shape.energy(hem) {
        None => missing.push("the hem reaches further than the slant".to_string()),
        Some(energy) => {
            out.over_weight = from_first(&shape);
            out.over_weight_ritz = from_ritz(energy);
            if out.over_weight.is_none() {
                missing.push("a round hem has one speed and one radius: its first integral says nothing of λ".into());
            }
        }
    }
    let known = |value: Option<f64>| value.filter(|v| v.is_finite() && 0.0 < *v);
    let density = known(fabric.areal_density.map(|d| d.0)).map(|d| d * gravity);
    let rigidity = known(fabric.flexural_rigidity.map(|b| b.0));
    if let Some(weight) = density {
        let functional = PaperFunctional::new(skirt, weight, foundation_modulus);
        if let Some(energy) = functional.energy(hem) {
            out.first_integral = from_first(&functional);
            out.ritz = from_ritz(energy);
        }
    } else {
        missing.push("the areal density is not known".into());
    }
    match (density, rigidity) {
        // A drape tester's disc leans by all its slant: no straight generatrices hang from its edge.
        (Some(_), Some(_)) if 1.0 - 1e-9 <= skirt.conicity() => missing.push("the ruled shell does not apply to a drape tester".into()),
        (Some(weight), Some(rigidity)) => match AnsatzShell::new(skirt, weight, rigidity).energy(hem) {
            Some(energy) => out.ruled = from_ritz(energy.total()),
            None => missing.push("no ruled shell reaches this hem: it leans further than the slant, or is creased".into()),
        },
        (_, None) => missing.push("the flexural rigidity is not known".into()),
        _ => (),
    }
    out.missing = (!missing.is_empty()).then(|| missing.join("; "));
    out
}

/// λ of least |∇f − λ∇Λ|, the angle between the gradients (degrees, 0 at a constrained optimum), and dλ/d(p, q, s); `None` if ∇f vanishes.
fn ritz(objective: &HemJet, length: &HemJet) -> Option<(f64, f64, Vector3<f64>)> {
    let (f, c) = (Vector3::from(objective.gradient), Vector3::from(length.gradient));
    let square = c.norm_squared();
    if !(0.0 < square && 0.0 < f.norm() && f.norm().is_finite()) {
        return None;
    }
    let value = f.dot(&c) / square;
    // The angle from both products keeps its digits near 0, where the arc cosine loses half of them.
    let angle = f.cross(&c).norm().atan2(f.dot(&c)).to_degrees();
    let hessian = |jet: &HemJet| Matrix3::from_fn(|i, j| jet.hessian[i][j]);
    let (of_f, of_c) = (hessian(objective), hessian(length));
    let gradient = (of_f * c + of_c * f - 2.0 * value * (of_c * c)) / square;
    Some((value, angle, gradient))
}

fn standard_error(gradient: &Vector3<f64>, covariance: Option<&[[f64; 3]; 3]>) -> Option<f64> {
    let covariance = Matrix3::from_fn(|i, j| covariance.map_or(f64::NAN, |c| c[i][j]));
    let variance = gradient.dot(&(covariance * gradient));
    (variance.is_finite() && 0.0 <= variance).then(|| variance.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::{KilogramPerSquareMetre, Metre, NewtonMetre};

    const HEM: Hem = Hem { p: 0.1315, q: 0.0527, s: 0.00873, folds: 5 };

    fn skirt() -> Skirt {
        Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap()
    }

    fn fabric() -> Fabric {
        Fabric { areal_density: Some(KilogramPerSquareMetre(0.2)), flexural_rigidity: Some(NewtonMetre(1e-5)) }
    }

    #[test]
    fn paper_s_own_curve_gives_the_known_values() {
        // Birthplace: docs/model.md, section 3, digits as printed there.
        let out = lambda(&HEM, None, Some(&skirt()), &fabric(), 9.81, 0.0);
        let (first, r2) = out.first_integral.unwrap();
        assert!((first.value - 0.0237).abs() < 0.5e-4 && (r2 - 0.037).abs() < 0.5e-3, "{first:?} {r2}");
        let (ritz, angle) = out.ritz.unwrap();
        assert!((ritz.value - 0.0240).abs() < 0.5e-4 && (angle - 38.1).abs() < 0.05, "{ritz:?} {angle}");
        assert_eq!((first.standard_error, ritz.standard_error, out.missing), (None, None, None));
        // E = 0: λ is proportional to the weight.
        assert!((out.over_weight.unwrap().0.value * 1.962 - first.value).abs() < 1e-14);
        assert!((out.over_weight_ritz.unwrap().0.value * 1.962 - ritz.value).abs() < 1e-14);
    }

    #[test]
    fn ruled_multiplier_at_the_constrained_optimum_is_exact() {
        // Birthplace: docs/model.md, section 5; p, q, s are printed to eight digits, which leaves the angle at 1e-5.
        let cases =
            [(5, 1e-5, [0.13152467, 0.05267570, 0.00873147], 0.0019692184), (7, 2e-6, [0.12459092, 0.03867800, 0.00632280], 0.00089491739)];
        for (folds, rigidity, [p, q, s], expected) in cases {
            let fabric = Fabric { flexural_rigidity: Some(NewtonMetre(rigidity)), ..fabric() };
            let (ruled, angle) = lambda(&Hem { p, q, s, folds }, None, Some(&skirt()), &fabric, 9.81, 0.0).ruled.unwrap();
            assert!((ruled.value - expected).abs() < 1e-6 * expected, "{ruled:?}");
            assert!(angle < 1e-3, "{angle}");
        }
    }

    #[test]
    fn standard_errors_agree_with_the_scatter_of_shifted_hems() {
        // λ is smooth: with errors of 1e-5 m its differences along the axes of a diagonal covariance are its standard error to first order.
        let step = 1e-6;
        let covariance = [[step * step, 0.0, 0.0], [0.0, 4.0 * step * step, 0.0], [0.0, 0.0, step * step]];
        let at = |hem: Hem| lambda(&hem, Some(&covariance), Some(&skirt()), &fabric(), 9.81, 20.0);
        let moved = [Hem { p: HEM.p + step, ..HEM }, Hem { q: HEM.q + 2.0 * step, ..HEM }, Hem { s: HEM.s + step, ..HEM }].map(at);
        let centre = at(HEM);
        let three = |l: &Lambda| [l.first_integral.unwrap().0, l.ritz.unwrap().0, l.ruled.unwrap().0];
        for way in 0..3 {
            let scatter = moved.iter().map(|l| (three(l)[way].value - three(&centre)[way].value).powi(2)).sum::<f64>().sqrt();
            let claimed = three(&centre)[way].standard_error.unwrap();
            // One-sided differences: second order in step/q ~ 2e-5, times curvatures of some tens.
            assert!((claimed / scatter - 1.0).abs() < 5e-3, "way {way}: {claimed} {scatter}");
        }
    }

    #[test]
    fn what_is_not_known_is_missing_with_its_reason() {
        let without_cut = lambda(&HEM, None, None, &fabric(), 9.81, 0.0);
        assert!(without_cut.over_weight.is_none() && without_cut.missing.unwrap().contains("cut"));
        let without_cloth = lambda(&HEM, None, Some(&skirt()), &Fabric::default(), 9.81, 0.0);
        assert!(without_cloth.first_integral.is_none() && without_cloth.ritz.is_none() && without_cloth.ruled.is_none());
        assert!(without_cloth.over_weight.is_some() && without_cloth.over_weight_ritz.is_some());
        assert!(without_cloth.missing.unwrap().contains("areal density"));
        let round = lambda(&Hem { p: 0.2, q: 0.0, s: 0.0, folds: 0 }, None, Some(&skirt()), &fabric(), 9.81, 0.0);
        assert!(round.first_integral.is_none() && round.missing.unwrap().contains("round"));
        let far = lambda(&Hem { p: 0.8, ..HEM }, None, Some(&skirt()), &fabric(), 9.81, 0.0);
        assert!(far.over_weight.is_none() && far.ruled.is_none() && far.missing.unwrap().contains("further than the slant"));
        let disc = Skirt::drapemeter(Metre(0.09), Metre(0.15)).unwrap();
        let tester = lambda(&Hem { p: 0.12, q: 0.02, s: 0.0, folds: 6 }, None, Some(&disc), &fabric(), 9.81, 0.0);
        assert!(tester.ritz.is_some() && tester.ruled.is_none() && tester.missing.unwrap().contains("drape tester"));
    }
}
