//! The ruled form: straight generatrices from the waist to any hem, with its derivatives.

use std::f64::consts::TAU;

use super::sample::{Grid, Sample};
use crate::experiment::Skirt;
use crate::model::hem::Hem;
use crate::model::surface::Space;
use crate::model::tangent::TangentHem;

/// A point of the hem seen from above with two derivatives by the hem's own parameter, and the material angle that hangs there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HemSample {
    /// m.
    pub position: [f64; 2],
    pub first: [f64; 2],
    pub second: [f64; 2],
    /// σ, rad, with its derivatives by the same parameter.
    pub sigma: [f64; 3],
}

/// `columns` points of a hem of the tangent-angle family, even in σ, the first on the crest.
pub fn sampled(hem: &TangentHem, columns: usize) -> Vec<HemSample> {
    let at = |j: usize| {
        let sigma = TAU * j as f64 / columns as f64;
        let [position, first, second] = hem.local(sigma);
        HemSample { position, first, second, sigma: [sigma, 1.0, 0.0] }
    };
    (0..columns).map(at).collect()
}

/// `columns` points of the paper's curve, even in its parameter t; σ is the share of its own length.
pub fn sampled_hem(hem: &Hem, columns: usize) -> Vec<HemSample> {
    // Simpson's rule on eight substeps between neighbours: right to eight digits on folds as deep as cloth makes them.
    let (substeps, step) = (8, TAU / columns as f64);
    let speed = |t: f64| hem.local(t).speed();
    let small = step / f64::from(substeps);
    let mut lengths = vec![0.0];
    for j in 0..columns {
        let from = step * j as f64;
        let piece: f64 = (0..substeps)
            .map(|i| from + small * f64::from(i))
            .map(|t| (speed(t) + 4.0 * speed(t + 0.5 * small) + speed(t + small)) * small / 6.0)
            .sum();
        lengths.push(lengths[j] + piece);
    }
    let scale = TAU / lengths[columns];
    let at = |j: usize| {
        let t = step * j as f64;
        let (local, (sin, cos)) = (hem.local(t), t.sin_cos());
        let turned = |(r, s): (f64, f64)| [r * cos - s * sin, r * sin + s * cos];
        let v = local.speed();
        let quicker = (local.velocity.0 * local.acceleration.0 + local.velocity.1 * local.acceleration.1) / v;
        HemSample {
            position: turned(local.position),
            first: turned(local.velocity),
            second: turned(local.acceleration),
            sigma: [scale * lengths[j], scale * v, scale * quicker],
        }
    };
    (0..columns).map(at).collect()
}

/// Straight generatrices of the cloth's own length from R_t e^{iσ} to the hem, `rows` rings evenly from waist to hem.
///
/// `None` where a generatrix does not reach its point of the hem.
pub fn ruled(skirt: &Skirt, hem: &[HemSample], rows: usize) -> Option<Grid> {
    let (waist, slant) = (skirt.waist_radius().0, skirt.slant_length().0);
    let share = |row: usize| row as f64 / (rows - 1) as f64;
    let mut columns = Vec::with_capacity(hem.len());
    for point in hem {
        let [sigma, rate, quicker] = point.sigma;
        let (sin, cos) = sigma.sin_cos();
        // The waist's point and its derivatives, and the lean from there to the hem.
        let w = [waist * cos, waist * sin];
        let w1 = [-waist * sin * rate, waist * cos * rate];
        let w2 = [-w[0] * rate * rate - waist * sin * quicker, -w[1] * rate * rate + waist * cos * quicker];
        let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let (d, d1, d2) = (minus(point.position, w), minus(point.first, w1), minus(point.second, w2));
        let square = slant * slant - dot(d, d);
        if square.is_nan() || square <= 0.0 {
            return None;
        }
        // How deep the hem hangs below the waist, with two derivatives.
        let deep = square.sqrt();
        let deep1 = -dot(d, d1) / deep;
        let deep2 = -(dot(d1, d1) + dot(d, d2) + deep1 * deep1) / deep;
        columns.push((w, w1, w2, d, d1, d2, deep, deep1, deep2));
    }
    let mut samples = Vec::with_capacity(rows * hem.len());
    for row in 0..rows {
        let u = share(row);
        for (w, w1, w2, d, d1, d2, deep, deep1, deep2) in &columns {
            let space = |a: &[f64; 2], b: &[f64; 2], u: f64, z: f64| -> Space { [a[0] + u * b[0], a[1] + u * b[1], z] };
            let along = |b: &[f64; 2], z: f64| -> Space { [b[0] / slant, b[1] / slant, z / slant] };
            samples.push(Sample {
                position: space(w, d, u, -u * deep),
                by_ring: space(w1, d1, u, -u * deep1),
                by_slant: along(d, -deep),
                ring_ring: space(w2, d2, u, -u * deep2),
                ring_slant: along(d1, -deep1),
                slant_slant: [0.0; 3],
            });
        }
    }
    Some(Grid {
        slant_distance: (0..rows).map(|row| slant * share(row)).collect(),
        sigma: hem.iter().map(|p| p.sigma[0]).collect(),
        sigma_rate: hem.iter().map(|p| p.sigma[1]).collect(),
        samples,
    })
}
