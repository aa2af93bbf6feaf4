//! The geometry of a surface at one point: fundamental forms and curvatures from position and derivatives.

use crate::model::surface::Space;

/// Position (m) and derivatives by the parameter of the ring (σ, rad, or the hem's own) and by ℓ (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    pub position: Space,
    pub by_ring: Space,
    pub by_slant: Space,
    pub ring_ring: Space,
    pub ring_slant: Space,
    pub slant_slant: Space,
}

/// A form, sampled: rings from waist to hem, points round each; sample `row * columns + column`.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// ℓ of each row, m, from 0 to L.
    pub slant_distance: Vec<f64>,
    /// σ of each column, rad.
    pub sigma: Vec<f64>,
    /// dσ by the ring's parameter: 1 where that is σ itself.
    pub sigma_rate: Vec<f64>,
    pub samples: Vec<Sample>,
}

/// What the derivatives say about the surface at one point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    /// Unit, outwards.
    pub normal: Space,
    /// Curvature of the ring seen from above, 1/m.
    pub plan: f64,
    /// Normal curvatures along ring and generatrix, 1/m.
    pub ring: f64,
    pub generatrix: f64,
    /// Curvature tensor (11, 12, 22) on the ring's unit tangent and its perpendicular in the surface, downwards, 1/m.
    pub tensor: [f64; 3],
    /// Unit vector along the generatrix on the same axes.
    pub along: [f64; 2],
    /// Length of `by_ring`.
    pub ring_speed: f64,
    /// Share of the vertical in the generatrix: sin β on the cone.
    pub steepness: f64,
}

impl Shape {
    /// Greatest and least principal curvature, 1/m.
    pub fn principal(&self) -> (f64, f64) {
        let [a, b, c] = self.tensor;
        let (mean, half) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
        (mean + half, mean - half)
    }
}

impl Sample {
    pub(super) fn shape(&self) -> Shape {
        let (u, v) = (self.by_ring, self.by_slant);
        // Down along the generatrix times counter-clockwise round the ring points outwards.
        let cross = cross(v, u);
        let size = dot(cross, cross).sqrt();
        let normal = cross.map(|x| x / size);
        let (e, f, g) = (dot(u, u), dot(u, v), dot(v, v));
        let bent = |second: Space| -dot(second, normal);
        let (second_e, second_f, second_g) = (bent(self.ring_ring), bent(self.ring_slant), bent(self.slant_slant));
        let speed = e.sqrt();
        // by_slant = oblique · tangent + upright · perpendicular.
        let (oblique, upright) = (f / speed, size / speed);
        let k11 = second_e / e;
        let k12 = (second_f / speed - oblique * k11) / upright;
        let k22 = (second_g - oblique * oblique * k11 - 2.0 * oblique * upright * k12) / (upright * upright);
        let w = self.ring_ring;
        let slant_speed = g.sqrt();
        Shape {
            normal,
            plan: (u[0] * w[1] - u[1] * w[0]) / u[0].hypot(u[1]).powi(3),
            ring: k11,
            generatrix: second_g / g,
            tensor: [k11, k12, k22],
            along: [oblique / slant_speed, upright / slant_speed],
            ring_speed: speed,
            steepness: -v[2] / slant_speed,
        }
    }
}

fn dot(a: Space, b: Space) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Space, b: Space) -> Space {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A torus about the z axis, tube r round a circle R, at angle a of the axis and b of the tube (0 outside, rising downwards).
    fn torus(big: f64, small: f64, a: f64, b: f64) -> Sample {
        let ((sa, ca), (sb, cb)) = (a.sin_cos(), b.sin_cos());
        let ring = big + small * cb;
        Sample {
            position: [ring * ca, ring * sa, -small * sb],
            by_ring: [-ring * sa, ring * ca, 0.0],
            by_slant: [-small * sb * ca, -small * sb * sa, -small * cb],
            ring_ring: [-ring * ca, -ring * sa, 0.0],
            ring_slant: [small * sb * sa, -small * sb * ca, 0.0],
            slant_slant: [-small * cb * ca, -small * cb * sa, small * sb],
        }
    }

    #[test]
    fn a_torus_has_its_closed_curvatures() {
        // Principal curvatures 1/r and cos b/(R + r cos b): do Carmo, Differential Geometry of Curves and Surfaces, section 3-3, example 5.
        for b in [0.0, 0.7, 2.5, -1.1] {
            let shape = torus(0.3, 0.1, 0.4, b).shape();
            let (greatest, least) = shape.principal();
            let ring = b.cos() / (0.3 + 0.1 * b.cos());
            assert!((greatest - 10.0).abs() < 1e-12 && (least - ring).abs() < 1e-12, "{b}: {greatest} {least}");
            assert!((shape.generatrix - 10.0).abs() < 1e-12 && (shape.ring - ring).abs() < 1e-12);
            // Outwards: away from the middle of the tube.
            assert!((shape.normal[2] + b.sin()).abs() < 1e-12);
        }
    }

    #[test]
    fn curvatures_do_not_depend_on_how_the_surface_is_run_through() {
        // The same torus with generatrices that also turn round the axis by their own angle: a = σ + k b.
        let (k, a, b) = (0.8, 0.4, 0.7);
        let s = torus(0.3, 0.1, a, b);
        let mix = |x: Space, y: Space, f: f64| [0, 1, 2].map(|i| x[i] + f * y[i]);
        let oblique = Sample {
            by_slant: mix(s.by_slant, s.by_ring, k),
            ring_slant: mix(s.ring_slant, s.ring_ring, k),
            slant_slant: mix(mix(s.slant_slant, s.ring_slant, 2.0 * k), s.ring_ring, k * k),
            ..s
        };
        let ((g1, l1), (g2, l2)) = (s.shape().principal(), oblique.shape().principal());
        assert!((g1 - g2).abs() < 1e-12 && (l1 - l2).abs() < 1e-12 && (s.shape().ring - oblique.shape().ring).abs() < 1e-12);
    }
}
