//! The hem carried through height: the paper's surface (18), and the space form of a ring below straight generatrices.

use std::f64::consts::TAU;

use super::hem::{Hem, Placement};
use crate::experiment::Skirt;

/// A point in space, m: x, y in plan, z upwards.
pub type Space = [f64; 3];

/// The paper's surface (18): at every height the same curve, with p, q (and s, which must vanish where q does) linear in the height z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearSurface {
    /// Radius of the round waist at z = `height`, m.
    pub waist_radius: f64,
    /// The curve at z = 0.
    pub hem: Hem,
    /// H, m.
    pub height: f64,
}

impl LinearSurface {
    /// From the hem, level at z = 0, to the round waist of `skirt` at the height of its cone.
    pub fn new(skirt: &Skirt, hem: Hem) -> Self {
        LinearSurface { waist_radius: skirt.waist_radius().0, hem, height: super::skirt::Cone::of(skirt).height }
    }

    /// The curve at the share `fraction` of the way down, 0 at the waist and 1 at the hem.
    pub fn ring(&self, fraction: f64) -> Hem {
        let p = self.waist_radius + fraction * (self.hem.p - self.waist_radius);
        Hem { p, q: fraction * self.hem.q, s: fraction * self.hem.s, folds: self.hem.folds }
    }

    /// The point at parameter `t` and the share `fraction` of the way down, m.
    pub fn point(&self, t: f64, fraction: f64) -> Space {
        let plan = self.ring(fraction).point(&Placement::ORIGIN, t);
        [plan.x, plan.y, (1.0 - fraction) * self.height]
    }

    /// Relative excess of the ring's length over its cloth (linear from waist to hem circumference) where that is largest in size, and where: the
    /// share of the way down. A surface of inextensible rings has none.
    pub fn ring_excess(&self) -> (f64, f64) {
        let hem_length = self.hem.perimeter();
        let waist_length = TAU * self.waist_radius;
        let excess = |fraction: f64| self.ring(fraction).perimeter() / (waist_length + fraction * (hem_length - waist_length)) - 1.0;
        // Hundredths of the height: smooth in between.
        (0..=100)
            .map(|i| f64::from(i) / 100.0)
            .map(|u| (excess(u), u))
            .fold((0.0, 0.0), |a, b| if f64::abs(a.0) < b.0.abs() { b } else { a })
    }
}

/// The ring of cloth below straight generatrices of length L: from waist points R_t e^{iσ}, σ the share of the hem's own length, to the hem c(t).
#[derive(Debug, Clone, PartialEq)]
pub struct RuledForm {
    /// Hem and waist points, one pair for each of even parameters t, m.
    ends: Vec<(Space, Space)>,
}

impl RuledForm {
    /// `n` generatrices below the waist at z = 0; `None` where the hem lies further out than the slant reaches.
    pub fn new(skirt: &Skirt, hem: &Hem, n: usize) -> Option<Self> {
        let (waist, slant) = (skirt.waist_radius().0, skirt.slant_length().0);
        // Arc length by the midpoint rule between neighbours; eight substeps hold it to a millionth of a fold.
        let substeps = 8;
        let step = TAU / (n * substeps) as f64;
        let mut lengths = vec![0.0; n + 1];
        for i in 0..n {
            let within: f64 = (0..substeps).map(|j| hem.local(step * ((i * substeps + j) as f64 + 0.5)).speed() * step).sum();
            lengths[i + 1] = lengths[i] + within;
        }
        let whole = lengths[n];
        let end = |i: usize| {
            let at = hem.point(&Placement::ORIGIN, TAU * i as f64 / n as f64);
            let (sin, cos) = (TAU * lengths[i] / whole).sin_cos();
            let (dx, dy) = (at.x - waist * cos, at.y - waist * sin);
            let fall = slant * slant - dx * dx - dy * dy;
            (0.0 <= fall).then(|| ([at.x, at.y, -fall.sqrt()], [waist * cos, waist * sin, 0.0]))
        };
        Some(RuledForm { ends: (0..n).map(end).collect::<Option<_>>()? })
    }

    /// The ring at the share `fraction` of the slant from the waist, one point for each generatrix, m.
    pub fn ring(&self, fraction: f64) -> Vec<Space> {
        let between = |(hem, waist): &(Space, Space)| std::array::from_fn(|k| waist[k] + fraction * (hem[k] - waist[k]));
        self.ends.iter().map(between).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Metre;

    fn skirt() -> Skirt {
        Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap()
    }

    const HEM: Hem = Hem { p: 0.13152467, q: 0.05267570, s: 0.00873147, folds: 5 };

    #[test]
    fn linear_surface_joins_the_round_waist_to_the_hem() {
        let surface = LinearSurface::new(&skirt(), HEM);
        for i in 0..50 {
            let t = TAU * f64::from(i) / 50.0;
            let ([x, y, z], hem) = (surface.point(t, 0.0), HEM.point(&Placement::ORIGIN, t));
            assert!((x.hypot(y) - 0.121).abs() < 1e-15 && (z - surface.height).abs() < 1e-15);
            let [x, y, z] = surface.point(t, 1.0);
            assert!((x - hem.x).hypot(y - hem.y) < 1e-15 && z == 0.0);
        }
    }

    #[test]
    fn a_cone_has_no_ring_excess_and_a_folded_surface_lacks_length_in_between() {
        // Without folds the rings are circles of the cone.
        let cone = LinearSurface::new(&skirt(), Hem { p: 0.2362, q: 0.0, s: 0.0, folds: 5 });
        assert!(cone.ring_excess().0.abs() < 1e-12);
        // Length grows with the square of shallow folds: in between there is less than linear.
        let (excess, at) = LinearSurface::new(&skirt(), HEM).ring_excess();
        assert!(excess < -0.01 && 0.0 < at && at < 1.0, "{excess} at {at}");
    }

    #[test]
    fn every_generatrix_is_as_long_as_the_slant_and_crests_rise() {
        let form = RuledForm::new(&skirt(), &HEM, 200).unwrap();
        for (a, b) in form.ring(0.0).iter().zip(form.ring(1.0)) {
            let length = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
            assert!((length - 0.53).abs() < 1e-14);
        }
        let hem = form.ring(1.0);
        // t = 0 is a crest, half a fold later a trough; by symmetry their generatrices stand in radial planes.
        let rise = |d: f64| 0.53 - (0.53 * 0.53 - d * d).sqrt();
        assert!((hem[0][2] + 0.53 - rise(HEM.p + HEM.q - 0.121)).abs() < 1e-12);
        assert!((hem[20][2] + 0.53 - rise(HEM.p - HEM.q - 0.121)).abs() < 1e-9);
    }

    #[test]
    fn a_hem_out_of_reach_of_the_slant_has_no_space_form() {
        assert!(RuledForm::new(&skirt(), &Hem { p: 0.7, ..HEM }, 100).is_none());
    }
}
