//! The paper's surface (18): p, q, s linear in height, with its derivatives.

use std::f64::consts::TAU;

use super::sample::{Grid, Sample};
use crate::experiment::Skirt;
use crate::model::hem::Hem;
use crate::model::surface::{LinearSurface, Space};

/// The surface from a round waist to `hem`, level at the height of the cone, on `rows` rings and `columns` points even in t.
///
/// ℓ is the share of the way down times L, σ is t: equation (18) says nothing of where the cloth is.
pub fn linear(skirt: &Skirt, hem: Hem, rows: usize, columns: usize) -> Grid {
    let surface = LinearSurface::new(skirt, hem);
    let slant = skirt.slant_length().0;
    // Everything but p at the waist grows in proportion to the way down.
    let growth = Hem { p: hem.p - surface.waist_radius, ..hem };
    let mut samples = Vec::with_capacity(rows * columns);
    for row in 0..rows {
        let u = row as f64 / (rows - 1) as f64;
        let ring = surface.ring(u);
        for column in 0..columns {
            let t = TAU * column as f64 / columns as f64;
            let (sin, cos) = t.sin_cos();
            let (local, by_u) = (ring.local(t), growth.local(t));
            let turned = |(r, s): (f64, f64), z: f64| -> Space { [r * cos - s * sin, r * sin + s * cos, z] };
            let per_slant = |v: Space| v.map(|x| x / slant);
            samples.push(Sample {
                // From the waist at 0 downwards.
                position: turned(local.position, -u * surface.height),
                by_ring: turned(local.velocity, 0.0),
                by_slant: per_slant(turned(by_u.position, -surface.height)),
                ring_ring: turned(local.acceleration, 0.0),
                ring_slant: per_slant(turned(by_u.velocity, 0.0)),
                slant_slant: [0.0; 3],
            });
        }
    }
    Grid {
        slant_distance: (0..rows).map(|row| slant * row as f64 / (rows - 1) as f64).collect(),
        sigma: (0..columns).map(|j| TAU * j as f64 / columns as f64).collect(),
        sigma_rate: vec![1.0; columns],
        samples,
    }
}
