//! The skirt of one run in space, with what is known at every point of it: to be looked at, not to be computed with.

use std::f64::consts::TAU;

use super::campaign::RunStudy;
use super::surface::assumed_sheet;
use crate::experiment::{Point, Skirt};
use crate::model::field::{self, Grid, HemSample, Sheet, surface_fields};
use crate::model::hem::{Hem, Placement};
use crate::model::skirt::Cone;
use crate::model::surface::{LinearSurface, Space};

/// Whose hem a surface ends in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HemOf {
    /// The fitted curve.
    Fit,
    /// The hem of least energy at the fitted fold count.
    Theory,
}

/// How it gets from the waist to the hem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Carried {
    /// The paper's equation (18): p, q, s linear in height.
    Linear,
    /// Straight generatrices of the cut's slant. `beyond`: how much further out than they reach some of the hem lies, m; it is drawn level there.
    Straight { beyond: f64 },
}

/// What a colour can stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Distance from the axis less that of the unfolded cone, m.
    Flexure,
    /// Curvature of the level ring, 1/m; positive where it turns like a circle.
    Curvature,
    /// Rigidity times that curvature: the bending moment per width that intensifies the stress at the faces, N.
    BendingMoment,
    /// von Mises' stress of hanging and bending at the face where it is greater, Pa, with the thickness and Poisson's ratio of
    /// [`assumed_sheet`](super::surface::assumed_sheet).
    StressIntensity,
}

/// One number for each point.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    pub quantity: Quantity,
    /// SI, in the order of the points.
    pub values: Vec<f64>,
}

/// A surface as a grid of points over one fold; the others are copies of it, turned about the axis.
#[derive(Debug, Clone, PartialEq)]
pub struct DrapedSurface {
    pub hem_of: HemOf,
    pub carried: Carried,
    /// How many copies make the whole.
    pub copies: u32,
    /// Points round one copy, the first and last of which touch its neighbours.
    pub round: usize,
    /// Rings, the waist first.
    pub down: usize,
    /// Ring by ring, m: about the axis, the waist at z = 0, z upwards, turned as the hem was measured.
    pub points: Vec<Space>,
    pub fields: Vec<Field>,
}

/// How finely a surface is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Faces round the whole, about; a fold gets 10 to 24 of them.
    pub round: u32,
    /// Faces from waist to hem.
    pub down: usize,
}

impl Default for Options {
    /// Two and a half degrees; down they may be longer, because generatrices are straight or nearly so.
    fn default() -> Self {
        Options { round: 144, down: 16 }
    }
}

/// A round surface is made of so many equal pieces.
const PIECES: u32 = 12;

/// The surfaces that exist for a run, the fitted one first: none without a fit or a cut. `gravity` in m/s².
///
/// Richer fields of the same grid belong into [`DrapedSurface::fields`].
pub fn draped(study: &RunStudy, gravity: f64, options: &Options) -> Vec<DrapedSurface> {
    let (Ok(fit), Some(skirt)) = (&study.fit, &study.run.skirt) else { return vec![] };
    let sheet = &assumed_sheet(&study.run.fabric, gravity);
    let copies = fit.folds.unwrap_or(PIECES);
    // A drape tester's cone is flat: only straight generatrices give its hem a height.
    let fitted = if 0.0 < Cone::of(skirt).height {
        linear(skirt, &fit.hem, copies, fit.placement.phase, sheet, options)
    } else {
        let (hem, places) = by_length(&fit.hem, copies);
        let ends = Ends { hem: &hem, places: &places, copies, phase: fit.placement.phase };
        straight(HemOf::Fit, skirt, &ends, sheet, options)
    };
    let theory = study.prediction_at_fitted_folds.as_ref().map(|prediction| {
        let hem = &prediction.outline;
        // Equally spaced in cloth.
        let places: Vec<f64> = (0..hem.len()).map(|i| TAU * i as f64 / hem.len() as f64).collect();
        let phase = study.comparison.as_ref().map_or(fit.placement.phase, |c| c.placement.phase);
        let copies = if prediction.folds == 0 { PIECES } else { prediction.folds };
        straight(HemOf::Theory, skirt, &Ends { hem, places: &places, copies, phase }, sheet, options)
    });
    std::iter::once(fitted).chain(theory).collect()
}

impl Options {
    /// Faces round one copy.
    fn faces(&self, copies: u32) -> usize {
        (self.round / copies.max(1)).clamp(10, 24) as usize
    }

    /// Shares of the way down.
    fn fractions(&self) -> impl Iterator<Item = f64> {
        let down = self.down;
        (0..=down).map(move |j| j as f64 / down as f64)
    }
}

/// The paper's surface below the waist of `skirt`.
fn linear(skirt: &Skirt, hem: &Hem, copies: u32, phase: f64, sheet: &Sheet, options: &Options) -> DrapedSurface {
    let surface = LinearSurface::new(skirt, *hem);
    let faces = options.faces(copies);
    let (mut points, mut curvature) = (vec![], vec![]);
    for fraction in options.fractions() {
        let ring = surface.ring(fraction);
        for t in (0..=faces).map(|i| TAU / f64::from(copies) * i as f64 / faces as f64) {
            let [x, y, z] = surface.point(t, fraction);
            points.push(turned([x, y, z - surface.height], phase));
            curvature.push(ring.local(t).curvature());
        }
    }
    let whole = field::linear(skirt, *hem, options.down + 1, faces * copies as usize);
    // The first of the copies, and where the next one begins.
    let columns = whole.sigma.len();
    let stress =
        stress(skirt, &whole, sheet).map(|all| all.chunks(columns).flat_map(|ring| (0..=faces).map(|i| ring[i % columns])).collect());
    let fields = fields(skirt, &points, (faces + 1, options.down), curvature, sheet.rigidity, stress);
    DrapedSurface { hem_of: HemOf::Fit, carried: Carried::Linear, copies, round: faces + 1, down: options.down + 1, points, fields }
}

/// Where generatrices end: a dense closed hem about the axis, m, as many points in each of its copies, and the share of cloth at each as an angle.
struct Ends<'a> {
    hem: &'a [Point],
    places: &'a [f64],
    copies: u32,
    phase: f64,
}

impl Ends<'_> {
    /// The ring at the share `fraction` of the way down, in plan.
    fn ring(&self, waist: f64, fraction: f64, i: usize) -> Point {
        let (hem, (sin, cos)) = (self.hem[i], self.places[i].sin_cos());
        let between = |waist: f64, hem: f64| waist + fraction * (hem - waist);
        Point::new(between(waist * cos, hem.x), between(waist * sin, hem.y))
    }

    /// The hem at point `i` with its derivatives by the number of the point.
    fn sample(&self, i: usize) -> HemSample {
        let n = self.hem.len();
        // Five neighbours; angles grow on beyond the end of the hem.
        let near = std::array::from_fn(|k| i + n + k - 2);
        let x = by_number(near.map(|j: usize| self.hem[j % n].x));
        let y = by_number(near.map(|j| self.hem[j % n].y));
        let sigma = by_number(near.map(|j| self.places[j % n] + TAU * (j / n) as f64));
        HemSample { position: [x[0], y[0]], first: [x[1], y[1]], second: [x[2], y[2]], sigma }
    }
}

/// Straight generatrices of the slant of `skirt` from its waist to a hem.
fn straight(hem_of: HemOf, skirt: &Skirt, ends: &Ends<'_>, sheet: &Sheet, options: &Options) -> DrapedSurface {
    let (waist, slant) = (skirt.waist_radius().0, skirt.slant_length().0);
    let (n, faces) = (ends.hem.len(), options.faces(ends.copies));
    let in_copy = n / ends.copies as usize;
    let (mut points, mut curvature) = (vec![], vec![]);
    let mut beyond = 0.0_f64;
    for fraction in options.fractions() {
        for i in (0..=faces).map(|face| (in_copy * face + faces / 2) / faces) {
            let near = |k: usize| ends.ring(waist, fraction, (i + n + k - 2) % n);
            let top = ends.ring(waist, 0.0, i % n);
            let along = top.distance(ends.hem[i % n]);
            beyond = beyond.max(along - slant);
            let fall = (slant * slant - along * along).max(0.0).sqrt();
            points.push(turned([near(2).x, near(2).y, -fraction * fall], ends.phase));
            curvature.push(bend(std::array::from_fn(near)));
        }
    }
    let samples: Vec<HemSample> = (0..=faces).map(|face| ends.sample((in_copy * face + faces / 2) / faces)).collect();
    let stress = field::ruled(skirt, &samples, options.down + 1).and_then(|grid| stress(skirt, &grid, sheet));
    let fields = fields(skirt, &points, (faces + 1, options.down), curvature, sheet.rigidity, stress);
    let carried = Carried::Straight { beyond: beyond.max(0.0) };
    DrapedSurface { hem_of, carried, copies: ends.copies, round: faces + 1, down: options.down + 1, points, fields }
}

/// Points of the hem for straight generatrices to end in, and the share of its length at each as an angle.
fn by_length(hem: &Hem, copies: u32) -> (Vec<Point>, Vec<f64>) {
    // As dense as predicted hems are; the midpoint rule between neighbours then errs by less than a millionth.
    const IN_COPY: usize = 240;
    let n = IN_COPY * copies as usize;
    let step = TAU / n as f64;
    let mut lengths = vec![0.0; n + 1];
    for i in 0..n {
        lengths[i + 1] = lengths[i] + hem.local(step * (i as f64 + 0.5)).speed() * step;
    }
    (hem.outline(&Placement::ORIGIN, n), lengths[..n].iter().map(|l| TAU * l / lengths[n]).collect())
}

/// Curvature at the middle of five points of a smooth curve, evenly spaced in its parameter, 1/m.
fn bend(five: [Point; 5]) -> f64 {
    let ([_, dx, ddx], [_, dy, ddy]) = (by_number(five.map(|p| p.x)), by_number(five.map(|p| p.y)));
    (dx * ddy - dy * ddx) / dx.hypot(dy).powi(3)
}

/// The middle one of five even values with its first and second derivative by their number: fourth order.
fn by_number([a, b, c, d, e]: [f64; 5]) -> [f64; 3] {
    [c, (a - 8.0 * b + 8.0 * d - e) / 12.0, (-a + 16.0 * b - 30.0 * c + 16.0 * d - e) / 12.0]
}

/// Stress intensity at every point of a grid; `None` where the cloth is not known, or hangs from nothing.
fn stress(skirt: &Skirt, grid: &Grid, sheet: &Sheet) -> Option<Vec<f64>> {
    surface_fields("surface", 0, skirt, grid, sheet).values(field::Field::StressIntensity).ok().map(<[f64]>::to_vec)
}

fn turned([x, y, z]: Space, phase: f64) -> Space {
    let (sin, cos) = phase.sin_cos();
    [x * cos - y * sin, x * sin + y * cos, z]
}

/// Everything that a point may be coloured by.
fn fields(
    skirt: &Skirt,
    points: &[Space],
    (round, down): (usize, usize),
    curvature: Vec<f64>,
    rigidity: Option<f64>,
    stress: Option<Vec<f64>>,
) -> Vec<Field> {
    let cone = Cone::of(skirt);
    let unfolded = |i: usize| cone.ring_radius(cone.slant_length * (i / round) as f64 / down as f64);
    let flexure = points.iter().enumerate().map(|(i, [x, y, _])| x.hypot(*y) - unfolded(i)).collect();
    let moment = rigidity.map(|b| Field { quantity: Quantity::BendingMoment, values: curvature.iter().map(|k| b * k).collect() });
    let stress = stress.map(|values| Field { quantity: Quantity::StressIntensity, values });
    [Field { quantity: Quantity::Flexure, values: flexure }, Field { quantity: Quantity::Curvature, values: curvature }]
        .into_iter()
        .chain(moment)
        .chain(stress)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Metre;

    const DOWN: usize = 16;
    const HEM: Hem = Hem { p: 0.15, q: 0.05, s: 0.004, folds: 5 };

    fn skirt() -> Skirt {
        Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap()
    }

    fn sheet() -> Sheet {
        Sheet { weight: Some(2.0), rigidity: Some(1e-5), thickness: Some(5e-4), poisson: Some(0.2) }
    }

    fn straight_fit(skirt: &Skirt) -> DrapedSurface {
        let (hem, places) = by_length(&HEM, HEM.folds);
        straight(HemOf::Fit, skirt, &Ends { hem: &hem, places: &places, copies: HEM.folds, phase: 0.3 }, &sheet(), &Options::default())
    }

    fn values(surface: &DrapedSurface, quantity: Quantity) -> &[f64] {
        &surface.fields.iter().find(|f| f.quantity == quantity).unwrap().values
    }

    #[test]
    fn both_surfaces_join_the_waist_to_the_hem_and_close_copy_by_copy() {
        for surface in [linear(&skirt(), &HEM, 5, 0.3, &Sheet::default(), &Options::default()), straight_fit(&skirt())] {
            let last = &surface.points[surface.points.len() - surface.round..];
            assert_eq!(surface.points.len(), surface.round * surface.down);
            for point in &surface.points[..surface.round] {
                assert!((point[0].hypot(point[1]) - 0.121).abs() < 1e-14 && point[2].abs() < 1e-15);
            }
            for (ring, radius) in [(&surface.points[..surface.round], 0.121), (last, HEM.p + HEM.q)] {
                let (first, end) = (ring[0], ring[surface.round - 1]);
                let next = turned(first, TAU / 5.0);
                assert!((first[0].hypot(first[1]) - radius).abs() < 1e-12);
                assert!((0..3).all(|k| (next[k] - end[k]).abs() < 1e-12), "{next:?} {end:?}");
            }
        }
    }

    #[test]
    fn curvature_by_differences_is_that_of_the_curve() {
        let surface = straight_fit(&skirt());
        let faces = surface.round - 1;
        let found = &values(&surface, Quantity::Curvature)[DOWN * surface.round..];
        for (i, found) in found.iter().enumerate() {
            let exact = HEM.local(TAU / 5.0 * i as f64 / faces as f64).curvature();
            // Fourth order in a step of a 240th of a fold: (2π/240)⁴/30·16 of the second harmonic, about 1e-6.
            assert!((found / exact - 1.0).abs() < 1e-4, "{i}: {found} {exact}");
        }
    }

    #[test]
    fn every_generatrix_is_as_long_as_the_slant_and_the_moment_is_rigidity_times_curvature() {
        let surface = straight_fit(&skirt());
        assert_eq!(surface.carried, Carried::Straight { beyond: 0.0 });
        for i in 0..surface.round {
            let (top, end) = (surface.points[i], surface.points[DOWN * surface.round + i]);
            let length = (0..3).map(|k| (top[k] - end[k]).powi(2)).sum::<f64>().sqrt();
            assert!((length - 0.53).abs() < 1e-12);
        }
        for (moment, curvature) in values(&surface, Quantity::BendingMoment).iter().zip(values(&surface, Quantity::Curvature)) {
            assert_eq!(*moment, 1e-5 * curvature);
        }
    }

    #[test]
    fn an_unfolded_cone_has_no_flexure() {
        let cone = Hem { p: 0.2362, q: 0.0, s: 0.0, folds: 1 };
        let surface = linear(&skirt(), &cone, PIECES, 0.0, &Sheet::default(), &Options::default());
        assert!(values(&surface, Quantity::Flexure).iter().all(|f| f.abs() < 1e-14));
        assert_eq!(surface.fields.len(), 2);
    }

    #[test]
    fn a_hem_out_of_reach_is_level_and_says_by_how_much() {
        let tester = Skirt::drapemeter(Metre(0.09), Metre(0.15)).unwrap();
        let wide = Hem { p: 0.153, q: 0.0, s: 0.0, folds: 1 };
        let (hem, places) = by_length(&wide, PIECES);
        let surface = straight(
            HemOf::Fit,
            &tester,
            &Ends { hem: &hem, places: &places, copies: PIECES, phase: 0.0 },
            &Sheet::default(),
            &Options::default(),
        );
        let Carried::Straight { beyond } = surface.carried else { panic!("{:?}", surface.carried) };
        assert!((beyond - 0.003).abs() < 1e-12);
        assert!(surface.points.iter().all(|p| p[2] == 0.0));
    }

    /// One copy of the exact field at the columns that are drawn.
    fn exact(grid: &Grid, round: usize) -> Vec<f64> {
        let columns = grid.sigma.len();
        stress(&skirt(), grid, &sheet()).unwrap().chunks(columns).flat_map(|ring| (0..round).map(|i| ring[i % columns])).collect()
    }

    #[test]
    fn stress_of_drawn_points_is_that_of_the_exact_surface() {
        let drawn = linear(&skirt(), &HEM, 5, 0.3, &sheet(), &Options::default());
        let whole = field::linear(&skirt(), HEM, DOWN + 1, 5 * (drawn.round - 1));
        assert_eq!(values(&drawn, Quantity::StressIntensity), exact(&whole, drawn.round));
        // Even in t, as the drawn ones: 24 faces of a fold of 240 points.
        let drawn = straight_fit(&skirt());
        let hem = field::sampled_hem(&HEM, 5 * (drawn.round - 1));
        let expected = exact(&field::ruled(&skirt(), &hem, DOWN + 1).unwrap(), drawn.round);
        for (i, (found, expected)) in values(&drawn, Quantity::StressIntensity).iter().zip(&expected).enumerate() {
            // As the curvature by differences.
            assert!((found / expected - 1.0).abs() < 2e-4, "{i}: {found} {expected}");
        }
    }
}
