//! Fields on a draped surface: flexure, curvatures, and the stresses of the cloth at both faces, at every point of a grid.
//!
//! A form (ruled, graded, or the paper's linear surface) gives position and exact derivatives by σ (or the hem's own parameter) and ℓ at each grid point; everything
//! here follows from those. Normals point outwards, a curvature is positive where the surface is convex outwards, so bending stress of that sign acts on the outer
//! face. Source of the stresses: docs/surface.md and docs/model.md, section 7.

mod graded;
mod linear;
mod ruled;
mod sample;
mod stress;

use serde::Serialize;

pub use graded::GradedShape;
pub use linear::linear;
pub use ruled::{HemSample, ruled, sampled, sampled_hem};
pub use sample::{Grid, Sample};
pub use stress::Sheet;

use super::surface::Space;
use crate::experiment::Skirt;

/// A quantity that has a value at every point of the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Field {
    /// r − R(ℓ): distance from the axis less that of the round cone, m.
    Flexure,
    /// Curvature of the ring seen from above, 1/m: that of the paper, and of the ruled shell's bending energy.
    RingCurvature,
    /// Normal curvature of the surface along the ring, 1/m.
    NormalCurvatureRing,
    /// Normal curvature of the surface along the generatrix, 1/m.
    NormalCurvatureGeneratrix,
    /// Greatest normal curvature, 1/m.
    PrincipalCurvatureGreatest,
    /// Least normal curvature, 1/m.
    PrincipalCurvatureLeast,
    /// (κ1 + κ2)/2, 1/m.
    MeanCurvature,
    /// κ1 κ2, 1/m²: 0 of a surface that can be laid flat.
    GaussianCurvature,
    /// Length of the ring over that of its cloth, less one: 0 where the form keeps rings inextensible.
    RingStrain,
    /// Tension along the generatrix that carries the cloth below it, N/m.
    MembraneForce,
    /// The same over the thickness, Pa.
    MembraneStress,
    /// E_f h_T κ/2 on the outer face, κ the principal curvature of greater size, Pa.
    BendingStressOuter,
    /// The same on the inner face: its negative.
    BendingStressInner,
    /// von Mises' stress of bending and membrane stress together on the outer face, Pa.
    StressIntensityOuter,
    /// On the inner face, Pa.
    StressIntensityInner,
    /// The greater of both faces, Pa.
    StressIntensity,
}

impl Field {
    pub const ALL: [Field; 16] = [
        Field::Flexure,
        Field::RingCurvature,
        Field::NormalCurvatureRing,
        Field::NormalCurvatureGeneratrix,
        Field::PrincipalCurvatureGreatest,
        Field::PrincipalCurvatureLeast,
        Field::MeanCurvature,
        Field::GaussianCurvature,
        Field::RingStrain,
        Field::MembraneForce,
        Field::MembraneStress,
        Field::BendingStressOuter,
        Field::BendingStressInner,
        Field::StressIntensityOuter,
        Field::StressIntensityInner,
        Field::StressIntensity,
    ];

    /// As flags and files spell it.
    pub fn name(self) -> &'static str {
        match self {
            Field::Flexure => "flexure",
            Field::RingCurvature => "ring-curvature",
            Field::NormalCurvatureRing => "normal-curvature-ring",
            Field::NormalCurvatureGeneratrix => "normal-curvature-generatrix",
            Field::PrincipalCurvatureGreatest => "principal-curvature-greatest",
            Field::PrincipalCurvatureLeast => "principal-curvature-least",
            Field::MeanCurvature => "mean-curvature",
            Field::GaussianCurvature => "gaussian-curvature",
            Field::RingStrain => "ring-strain",
            Field::MembraneForce => "membrane-force",
            Field::MembraneStress => "membrane-stress",
            Field::BendingStressOuter => "bending-stress-outer",
            Field::BendingStressInner => "bending-stress-inner",
            Field::StressIntensityOuter => "stress-intensity-outer",
            Field::StressIntensityInner => "stress-intensity-inner",
            Field::StressIntensity => "stress-intensity",
        }
    }

    /// SI unit; `1` of a ratio.
    pub fn unit(self) -> &'static str {
        match self {
            Field::Flexure => "m",
            Field::GaussianCurvature => "1/m²",
            Field::RingStrain => "1",
            Field::MembraneForce => "N/m",
            Field::RingCurvature
            | Field::NormalCurvatureRing
            | Field::NormalCurvatureGeneratrix
            | Field::PrincipalCurvatureGreatest
            | Field::PrincipalCurvatureLeast
            | Field::MeanCurvature => "1/m",
            _ => "Pa",
        }
    }

    /// Whether both signs mean something: such a field is coloured about 0.
    pub fn signed(self) -> bool {
        !matches!(
            self,
            Field::MembraneForce
                | Field::MembraneStress
                | Field::StressIntensityOuter
                | Field::StressIntensityInner
                | Field::StressIntensity
        )
    }

    /// The field of this name.
    pub fn named(name: &str) -> Option<Field> {
        Field::ALL.into_iter().find(|field| field.name() == name)
    }
}

/// An extreme value and where it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extreme {
    /// In the unit of the field.
    pub value: f64,
    /// Material angle σ from a crest, rad.
    pub sigma: f64,
    /// ℓ from the waist along the cloth, m.
    pub slant_distance: f64,
    /// x, y, z, m: z upwards, 0 at the waist.
    pub position: Space,
}

/// A draped surface with its fields on a grid of rings (waist first) and generatrices (counter-clockwise, the first on a crest).
///
/// Point `row * columns + column`; the last column is followed by the first.
#[derive(Debug, Clone)]
pub struct SurfaceFields {
    /// Which form it is: `ruled shell`, `graded shell`, `linear surface (18)`.
    pub form: &'static str,
    /// Fold count; 0 is round.
    pub folds: u32,
    pub rows: usize,
    pub columns: usize,
    /// ℓ of each row, m.
    pub slant_distance: Vec<f64>,
    /// σ of each column, rad.
    pub sigma: Vec<f64>,
    /// m, z upwards, 0 at the waist.
    pub positions: Vec<Space>,
    /// Unit, outwards.
    pub normals: Vec<Space>,
    values: Vec<Result<Vec<f64>, String>>,
}

/// All fields of a form; those of which cloth data are missing say so.
pub fn surface_fields(form: &'static str, folds: u32, skirt: &Skirt, grid: &Grid, sheet: &Sheet) -> SurfaceFields {
    let (rows, columns) = (grid.slant_distance.len(), grid.sigma.len());
    assert_eq!(rows * columns, grid.samples.len(), "a sample for each grid point");
    let shapes: Vec<sample::Shape> = grid.samples.iter().map(Sample::shape).collect();
    let cone = super::skirt::Cone::of(skirt);
    let ring = |i: usize| cone.ring_radius(grid.slant_distance[i / columns]);
    let of = |pick: &dyn Fn(usize, &sample::Shape) -> f64| -> Vec<f64> { shapes.iter().enumerate().map(|(i, s)| pick(i, s)).collect() };
    let values = Field::ALL
        .into_iter()
        .map(|field| match field {
            Field::Flexure => Ok(of(&|i, _| {
                let [x, y, _] = grid.samples[i].position;
                x.hypot(y) - ring(i)
            })),
            Field::RingCurvature => Ok(of(&|_, s| s.plan)),
            Field::NormalCurvatureRing => Ok(of(&|_, s| s.ring)),
            Field::NormalCurvatureGeneratrix => Ok(of(&|_, s| s.generatrix)),
            Field::PrincipalCurvatureGreatest => Ok(of(&|_, s| s.principal().0)),
            Field::PrincipalCurvatureLeast => Ok(of(&|_, s| s.principal().1)),
            Field::MeanCurvature => Ok(of(&|_, s| 0.5 * (s.tensor[0] + s.tensor[2]))),
            Field::GaussianCurvature => Ok(of(&|_, s| s.tensor[0] * s.tensor[2] - s.tensor[1] * s.tensor[1])),
            Field::RingStrain => Ok(of(&|i, s| s.ring_speed / (ring(i) * grid.sigma_rate[i % columns]) - 1.0)),
            _ => stress::stress(field, skirt, grid, &shapes, sheet),
        })
        .collect();
    SurfaceFields {
        form,
        folds,
        rows,
        columns,
        slant_distance: grid.slant_distance.clone(),
        sigma: grid.sigma.clone(),
        positions: grid.samples.iter().map(|s| s.position).collect(),
        normals: shapes.iter().map(|s| s.normal).collect(),
        values,
    }
}

impl SurfaceFields {
    /// A value for each point, in the field's unit.
    ///
    /// # Errors
    /// Why there are none: which property of the cloth is missing.
    pub fn values(&self, field: Field) -> Result<&[f64], &str> {
        let at = Field::ALL.iter().position(|f| *f == field).expect("every field is in the list");
        self.values[at].as_deref().map_err(String::as_str)
    }

    /// The greatest value; by symmetry it stands in every fold, and the first place is told.
    pub fn greatest(&self, field: Field) -> Option<Extreme> {
        self.extreme(field, 1.0)
    }

    /// The least value, likewise.
    pub fn least(&self, field: Field) -> Option<Extreme> {
        self.extreme(field, -1.0)
    }

    fn extreme(&self, field: Field, sign: f64) -> Option<Extreme> {
        let values = self.values(field).ok()?;
        let best = values.iter().map(|v| sign * v).fold(f64::NEG_INFINITY, f64::max);
        let size = values.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        // Equal folds differ by rounding: the first of them is told.
        let at = values.iter().position(|v| best - 1e-9 * size <= sign * v)?;
        Some(Extreme {
            value: values[at],
            sigma: self.sigma[at % self.columns],
            slant_distance: self.slant_distance[at / self.columns],
            position: self.positions[at],
        })
    }

    /// Two triangles to each cell, counter-clockwise seen from outside; the sheet is closed round the axis and open at waist and hem.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let point = |row: usize, column: usize| (row * self.columns + column % self.columns) as u32;
        let mut out = Vec::with_capacity(2 * (self.rows - 1) * self.columns);
        for row in 0..self.rows - 1 {
            for column in 0..self.columns {
                let (a, b) = (point(row, column), point(row, column + 1));
                let (d, c) = (point(row + 1, column), point(row + 1, column + 1));
                out.push([a, d, b]);
                out.push([b, d, c]);
            }
        }
        out
    }
}
