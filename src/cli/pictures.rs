//! Pictures on the command line: the flags that say how they are read, and the drawings that show what was traced.

use std::path::{Path, PathBuf};

use clap::Args;
use rayon::prelude::*;

use crate::error::Error;
use crate::experiment::campaign::{CameraHeight, PictureScale, Pictures, Shade, Tone};
use crate::import::image::{self, Silhouette};
use crate::report::{caption, output, words};
use crate::units::{MILLIMETRE, Metre};

/// How silhouettes are read: one scale, and what is not found in the picture.
#[derive(Debug, Args)]
#[group(skip)]
pub struct PictureFlags {
    /// Size of a pixel of a silhouette.
    #[arg(long, value_name = "MM", group = "scale")]
    pub scale_mm_per_px: Option<f64>,
    /// The silhouette shows a disc (support, cover plate) of this diameter.
    #[arg(long, value_name = "MM", group = "scale")]
    pub disc_mm: Option<f64>,
    /// The silhouette shows a plain bar of this length.
    #[arg(long, value_name = "MM", group = "scale")]
    pub bar_mm: Option<f64>,
    /// The silhouette shows a checkerboard with squares of this side; corrects a tilted camera.
    #[arg(long, value_name = "MM", group = "scale")]
    pub checkerboard_mm: Option<f64>,
    /// Height of the camera above the plane of the scale.
    #[arg(long, value_name = "MM", requires = "hem_height_mm")]
    pub camera_height_mm: Option<f64>,
    /// Height of the hem above the plane of the scale; negative where it hangs below.
    #[arg(long, value_name = "MM", requires = "camera_height_mm", allow_negative_numbers = true)]
    pub hem_height_mm: Option<f64>,
    /// What is the cloth in a silhouette.
    #[arg(long, default_value = "auto", value_parser = shade, value_name = "auto|dark|light")]
    pub object: Shade,
    /// How grey values go with light: linear (scans, drawn pictures), srgb (photographs).
    #[arg(long, default_value = "auto", value_parser = tone, value_name = "auto|linear|srgb")]
    pub tone: Tone,
}

impl PictureFlags {
    /// What the flags say; `None` without a scale.
    pub fn options(&self) -> Option<Pictures> {
        let length = |millimetres: f64| Metre(millimetres * MILLIMETRE);
        type Scale = fn(Metre) -> PictureScale;
        let given: [(Option<f64>, Scale); 4] = [
            (self.scale_mm_per_px, PictureScale::Pixel),
            (self.disc_mm, PictureScale::Disc),
            (self.bar_mm, PictureScale::Bar),
            (self.checkerboard_mm, PictureScale::Checkerboard),
        ];
        let scale = given.into_iter().find_map(|(value, scale)| Some(scale(length(value?))))?;
        let height = self.camera_height_mm.zip(self.hem_height_mm);
        let height = height.map(|(camera, hem)| CameraHeight { camera: length(camera), hem: length(hem) });
        Some(Pictures { scale, object: self.object, tone: self.tone, height })
    }
}

/// Writes the picture of a run with everything that was found in it drawn over it, and how it was read below, to `folder/stem.png`.
///
/// # Errors
/// If the picture cannot be read again, or the drawing cannot be written.
pub fn write_overlay(name: &str, stem: &str, silhouette: &Silhouette, folder: &Path) -> Result<PathBuf, Error> {
    let file = silhouette.source.file.display();
    let [width, height] = silhouette.size;
    let mut lines = vec![format!("{name}: {file}, {width} × {height} px, {} points", silhouette.profile.points().len())];
    lines.extend(silhouette.reading.iter().chain(&silhouette.notes).cloned());
    let rule = image::rule(silhouette) / MILLIMETRE;
    lines.push(format!("Bar at the lower left: {rule} mm. Red outline, orange holes, blue other objects, green the thing of known size."));
    let caption = caption::png(&lines, image::overlay_width(silhouette))?;
    output::write(folder, &format!("{stem}.png"), &image::overlay(silhouette, Some(&caption))?)
}

/// Every picture with its traced outline laid over it, in `folder/overlays/`; `kind` says what the names are of.
pub fn write_overlays(silhouettes: &[(String, Silhouette)], kind: &str, folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let folder = folder.join("overlays");
    let draw = |(name, silhouette): &(String, Silhouette)| {
        write_overlay(&format!("{kind} {name}"), &format!("{kind}_{}", words::file_stem(name)), silhouette, &folder)
    };
    silhouettes.par_iter().map(draw).collect()
}

/// `auto`, `dark` or `light`.
fn shade(text: &str) -> Result<Shade, String> {
    match text {
        "auto" => Ok(Shade::Auto),
        "dark" => Ok(Shade::Dark),
        "light" => Ok(Shade::Light),
        _ => Err(format!("“{text}” is no shade: use auto, dark or light")),
    }
}

/// `auto`, `linear` or `srgb`.
fn tone(text: &str) -> Result<Tone, String> {
    match text {
        "auto" => Ok(Tone::Auto),
        "linear" => Ok(Tone::Linear),
        "srgb" => Ok(Tone::Srgb),
        _ => Err(format!("“{text}” is no tone: use auto, linear or srgb")),
    }
}
