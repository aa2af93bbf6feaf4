//! A campaign: what `campaign.toml` says about a set of runs, checked.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::check::CheckRules;
use super::design::Design;
use super::specimen::Apparatus;
use crate::error::Error;
use crate::units::Metre;

/// How many folds a fit may choose from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Folds {
    /// By weight of evidence among `from..=to`.
    Among { from: u32, to: u32 },
    /// Given.
    Exactly(u32),
}

impl Default for Folds {
    /// 2…24: skirts and drape testers show 3 to about 15 folds; the margin makes a wrong edge visible.
    fn default() -> Self {
        Folds::Among { from: 2, to: 24 }
    }
}

/// Which length the fitted curve is held to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum HemLength {
    /// Free; held at the outline's own length (2πR_n where the cut is known) only where the free optimum is no sane curve.
    Auto,
    /// Free; where the free optimum is no sane curve there is no fit.
    Free,
    /// Held at this length, m.
    Held(f64),
}

/// Which language a report is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Language {
    #[default]
    #[serde(rename = "en")]
    English,
    #[serde(rename = "ru")]
    Russian,
}

impl Language {
    /// As campaign files and the command line spell it.
    pub fn code(self) -> &'static str {
        match self {
            Language::English => "en",
            Language::Russian => "ru",
        }
    }
}

/// Which grey of a picture is the cloth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shade {
    Dark,
    Light,
    /// Whatever the margin of the picture is not.
    #[default]
    Auto,
}

/// How the grey values of a picture go with light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// The one under which the edge of the object looks the same from both sides.
    #[default]
    Auto,
    /// In proportion: scanners, scientific cameras, drawn pictures.
    Linear,
    /// By the curve of sRGB: photographs.
    Srgb,
}

/// What says how large a picture is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PictureScale {
    /// Side of a pixel, m.
    Pixel(Metre),
    /// Diameter of a disc that shows in the picture, m.
    Disc(Metre),
    /// Length of a plain bar that shows in the picture, m.
    Bar(Metre),
    /// Side of a square of a checkerboard that shows in the picture, m.
    Checkerboard(Metre),
}

/// Where the eye of the camera (or the lamp that casts a shadow) and the hem are above the plane of the scale.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CameraHeight {
    /// > 0, m.
    pub camera: Metre,
    /// Below the camera; negative where the hem hangs below the plane of the scale. m.
    pub hem: Metre,
}

impl CameraHeight {
    /// True size over apparent size of the hem, `(H − h)/H`: similar triangles from the eye, for any tilt of the camera.
    pub fn factor(self) -> f64 {
        (self.camera.0 - self.hem.0) / self.camera.0
    }
}

/// How pictures of drapes are read.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pictures {
    pub scale: PictureScale,
    pub object: Shade,
    pub tone: Tone,
    /// `None`: the hem lies in the plane of the scale.
    pub height: Option<CameraHeight>,
}

impl Pictures {
    /// Pictures of this scale, everything else found in the picture.
    pub fn of_scale(scale: PictureScale) -> Self {
        Pictures { scale, object: Shade::Auto, tone: Tone::Auto, height: None }
    }

    /// Whether its lengths are possible.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a length of the scale or a camera height that is not positive and finite, or a hem at or above the camera.
    pub fn check(&self) -> Result<(), Error> {
        let (quantity, value) = match self.scale {
            PictureScale::Pixel(Metre(value)) => ("side of a pixel, m", value),
            PictureScale::Disc(Metre(value)) => ("diameter of the disc, m", value),
            PictureScale::Bar(Metre(value)) => ("length of the bar, m", value),
            PictureScale::Checkerboard(Metre(value)) => ("side of a square of the checkerboard, m", value),
        };
        if !(0.0 < value && value.is_finite()) {
            return Err(Error::Invalid { quantity, value, allowed: "> 0" });
        }
        match self.height {
            Some(CameraHeight { camera: Metre(value), .. }) if !(0.0 < value && value.is_finite()) => {
                Err(Error::Invalid { quantity: "height of the camera above the plane of the scale, m", value, allowed: "> 0" })
            }
            Some(CameraHeight { camera, hem: Metre(value) }) if !(value < camera.0 && value.is_finite()) => Err(Error::Invalid {
                quantity: "height of the hem above the plane of the scale, m",
                value,
                allowed: "less than the camera's",
            }),
            _ => Ok(()),
        }
    }
}

/// How meshes of drapes are read, where a mesh does not say it itself.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Meshes {
    /// The upward direction in the file's frame, of any length; found by geometry where it is not given.
    pub axis: Option<[f64; 3]>,
    /// Metres per unit of the file; told from the size where it is not given.
    pub unit: Option<Metre>,
}

/// A response: the short name by which a campaign asks for it, and its column of the fits table, whose suffix is its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Response {
    pub name: &'static str,
    pub column: &'static str,
}

/// Every response that a campaign may ask for, by either name.
pub const RESPONSES: [Response; 15] = [
    Response { name: "p", column: "p_mm" },
    Response { name: "q", column: "q_mm" },
    Response { name: "s", column: "s_mm" },
    Response { name: "m", column: "m" },
    Response { name: "lambda", column: "lambda_first_integral_n_m2" },
    Response { name: "lambda_over_weight", column: "lambda_over_weight" },
    Response { name: "lambda_ritz", column: "lambda_ritz_n_m2" },
    Response { name: "lambda_ruled", column: "lambda_ruled_n" },
    Response { name: "rms", column: "rms_mm" },
    Response { name: "fold_depth", column: "fold_depth_mm" },
    Response { name: "mean_radius", column: "mean_radius_mm" },
    Response { name: "perimeter", column: "perimeter_mm" },
    Response { name: "explained", column: "explained_share" },
    Response { name: "drape_coefficient", column: "drape_coefficient_percent" },
    Response { name: "theory_gap", column: "theory_gap_mm" },
];

/// What is wanted of a response, in the unit of its column; desirability is linear between worthless and perfect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Want {
    Larger { worthless: f64, perfect: f64 },
    Smaller { perfect: f64, worthless: f64 },
    Target { low: f64, target: f64, high: f64 },
}

/// One wish among several that are to be met together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Wish {
    /// Name of the response.
    pub response: String,
    pub want: Want,
    /// Exponent in the geometric mean of all wishes, > 0.
    pub importance: f64,
}

/// What is regressed where a campaign does not say: p, q, s, m, λ, rms and fold depth.
pub const USUAL_RESPONSES: [&str; 7] = ["p", "q", "s", "m", "lambda", "rms", "fold_depth"];

/// Everything about a campaign but its measured outlines.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Campaign {
    pub title: String,
    /// Where the measurements come from; printed wherever their numbers appear.
    pub origin: String,
    pub apparatus: Apparatus,
    /// The folder it was read from.
    pub folder: PathBuf,
    pub design: Design,
    /// Names of the responses to regress, in order.
    pub responses: Vec<String>,
    /// What is wanted of them, together; empty where nothing is.
    pub wishes: Vec<Wish>,
    /// Significance level of every test, 0.05 unless told.
    pub alpha: f64,
    pub folds: Folds,
    pub hem_length: HemLength,
    /// Take the bias of curvature out of every fit.
    pub bias_correction: bool,
    /// Acceleration of free fall, m/s².
    pub gravity: f64,
    /// Foundation modulus E of the paper's functional, N/m³; 0 unless told.
    pub foundation_modulus: f64,
    /// How pictures among the profile files are read; `None` where the campaign has no scale for them.
    pub pictures: Option<Pictures>,
    /// How meshes among them are read.
    pub meshes: Meshes,
    /// What `hemline check` holds it to.
    pub check: CheckRules,
    /// Of the report, unless another is asked for.
    pub language: Language,
}
