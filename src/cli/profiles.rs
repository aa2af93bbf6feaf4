//! The profiles that a command is given as files: tables, silhouettes, meshes.

use std::path::{Path, PathBuf};

use clap::Args;

use super::mesh::Frame;
use super::pictures::PictureFlags;
use super::told::Told;
use crate::error::Error;
use crate::experiment::DrapeProfile;
use crate::import::{image, mesh, table};

/// Files of profiles and how they are read.
#[derive(Debug, Args)]
pub struct Profiles {
    /// Tables (CSV, TSV, XLSX, XLS, ODS, Parquet, Arrow, also .gz), silhouettes (.png, .jpg, .tif, .bmp) or meshes (.obj, .ply, .stl, .gltf, .glb)
    #[arg(required = true, value_name = "PROFILE")]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub pictures: PictureFlags,
    #[command(flatten)]
    pub frame: Frame,
    #[command(flatten)]
    pub told: Told,
}

impl Profiles {
    /// All profiles by name, and whether none was set aside; what was is said on stderr, like the notes of the readers.
    ///
    /// # Errors
    /// That of the only file, if there is one only; with several, a file that cannot be read is said and left out.
    pub fn read(&self) -> Result<(Vec<(String, DrapeProfile)>, bool), Error> {
        let (mut profiles, mut whole) = (Vec::new(), true);
        for file in &self.files {
            match self.read_one(file) {
                Ok((found, complete)) => {
                    profiles.extend(found);
                    whole &= complete;
                }
                Err(error) if self.files.len() == 1 => return Err(error),
                Err(error) => {
                    eprintln!("set aside: {error}");
                    whole = false;
                }
            }
        }
        Ok((profiles, whole))
    }

    fn read_one(&self, file: &Path) -> Result<(Vec<(String, DrapeProfile)>, bool), Error> {
        let stem = || file.file_stem().map_or_else(|| file.display().to_string(), |stem| stem.to_string_lossy().into_owned());
        let say = |notes: &[String]| notes.iter().for_each(|note| eprintln!("note: {}: {note}", file.display()));
        if image::is_picture(file) {
            let Some(options) = self.pictures.options() else {
                let why =
                    format!("{}: a silhouette needs its scale; add --scale-mm-per-px, or what of known size it shows", file.display());
                return Err(Error::Unanswerable(why));
            };
            let silhouette = image::outline(file, &options)?;
            say(&silhouette.reading);
            say(&silhouette.notes);
            return Ok((vec![(stem(), silhouette.profile)], true));
        }
        if mesh::is_mesh(file) {
            let hem = mesh::hem(file, &mesh::Options { frame: self.frame.meshes(), ..mesh::Options::default() })?;
            say(&hem.notes);
            return Ok((vec![(stem(), hem.profile)], true));
        }
        let table = table::read(file, &self.told.dialect())?;
        say(&table.notes);
        table.quarantine.iter().for_each(|row| eprintln!("set aside: {row}"));
        let complete = table.quarantine.is_empty();
        Ok((table.profiles.into_iter().map(|p| (p.name, p.profile)).collect(), complete))
    }
}
