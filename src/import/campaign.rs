//! A campaign folder: `campaign.toml`, `design.csv` and the profile files → everything that was measured, and what was set aside.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Component, Path, PathBuf};

use super::design::{self, DesignTable};
use super::image::{self, is_picture};
use super::mesh::{self, is_mesh};
use super::table::{self, Table};
use super::{campaign_file, delimited};
use crate::error::{Error, Place};
use crate::experiment::Quarantined;
use crate::experiment::Source;
use crate::experiment::campaign::{Meshes, Pictures};
use crate::experiment::{Campaign, DrapeProfile, Run};

/// A campaign folder, read.
#[derive(Debug, Clone)]
pub struct Imported {
    pub campaign: Campaign,
    /// One per run of `campaign.design.runs`; `None` where it was set aside, and then the quarantine says why.
    pub profiles: Vec<Option<DrapeProfile>>,
    /// Every row, cell, file and run that was set aside.
    pub quarantine: Vec<Quarantined>,
    /// Every file that was read, in the order of reading.
    pub sources: Vec<Source>,
    /// What a person should know; one sentence each.
    pub notes: Vec<String>,
}

/// Reads a campaign folder. Bad rows and files go to the quarantine; the other runs go on.
///
/// # Errors
/// If `campaign.toml` or `design.csv` cannot be read or understood, or if not one run has a usable profile: [`Error::File`], [`Error::Input`].
pub fn load(folder: &Path) -> Result<Imported, Error> {
    let toml = folder.join("campaign.toml");
    if !toml.is_file() {
        let remedy = format!("a campaign folder has one; `hemline init {}` writes it", folder.display());
        return Err(Error::input(Place::file(toml), "there is no such file", remedy));
    }
    let file = campaign_file::read(&toml)?;
    let table = folder.join("design.csv");
    if !table.is_file() {
        return Err(Error::input(Place::file(table), "there is no such file", "a campaign folder has one, with one row per run"));
    }
    let DesignTable { design, rows, quarantine, notes, source } = design::read(&table, &file)?;
    let mut reader = Profiles {
        folder,
        design: &table,
        pictures: file.pictures,
        meshes: file.meshes,
        tables: BTreeMap::new(),
        quarantine,
        sources: vec![file.source.clone(), source],
        notes,
    };
    let profiles: Vec<Option<DrapeProfile>> = design.runs.iter().zip(&rows).map(|(run, &row)| reader.profile(run, row)).collect();
    reader.note_repeats(&design.runs);
    reader.note_strays(&design.runs);
    let Profiles { quarantine, sources, notes, .. } = reader;
    if profiles.iter().all(Option::is_none) {
        let first = quarantine.first().map(|q| format!(" (first: {q})")).unwrap_or_default();
        let problem = format!("not one of the {} runs has a usable profile{first}", profiles.len());
        return Err(Error::input(Place::file(table), problem, "put the profile files where the column “profile” says"));
    }
    let campaign = Campaign {
        title: file.title,
        origin: file.origin,
        apparatus: file.apparatus,
        folder: folder.to_path_buf(),
        design,
        responses: file.responses,
        wishes: file.wishes,
        alpha: file.alpha,
        folds: file.folds,
        hem_length: file.hem_length,
        gravity: file.gravity,
        foundation_modulus: file.foundation_modulus,
        pictures: file.pictures,
        meshes: file.meshes,
        check: file.check,
    };
    known_runs(&toml, &campaign, &quarantine)?;
    Ok(Imported { campaign, profiles, quarantine, sources, notes })
}

/// An expected failure must speak of a run that is there, or that is known to be missing.
fn known_runs(toml: &Path, campaign: &Campaign, quarantine: &[Quarantined]) -> Result<(), Error> {
    let runs = campaign.design.runs.iter().map(|run| run.id.as_str());
    let known: Vec<&str> = runs.chain(quarantine.iter().filter_map(|q| q.run.as_deref())).collect();
    for expected in campaign.check.expected.iter().filter(|expected| !expected.question.of_responses()) {
        if let Some(stranger) = expected.subjects.iter().find(|id| !known.contains(&id.as_str())) {
            let place = Place::file(toml).row(expected.row);
            return Err(Error::input(place, format!("there is no run “{stranger}”"), "name runs as the design table does"));
        }
    }
    Ok(())
}

struct Profiles<'a> {
    folder: &'a Path,
    design: &'a Path,
    pictures: Option<Pictures>,
    meshes: Meshes,
    /// Profile tables that were read; several runs may share one. A refused one keeps its reason.
    tables: BTreeMap<PathBuf, Result<Table, Quarantined>>,
    quarantine: Vec<Quarantined>,
    sources: Vec<Source>,
    notes: Vec<String>,
}

impl Profiles<'_> {
    fn set_aside(&mut self, run: &Run, row: usize, problem: &str, remedy: &str) {
        self.quarantine.push(Quarantined {
            run: Some(run.id.clone()),
            file: self.design.to_path_buf(),
            row: Some(row),
            value: delimited::shortened(&run.profile.display().to_string()),
            problem: problem.into(),
            remedy: remedy.into(),
        });
    }

    /// The profile of one run, whose row in the design table is `row`.
    fn profile(&mut self, run: &Run, row: usize) -> Option<DrapeProfile> {
        if run.profile.as_os_str().is_empty() {
            self.set_aside(run, row, "column “profile” is empty", "name the profile file of this run");
            return None;
        }
        // A path in a cell is data: it may not lead out of the folder.
        if !run.profile.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir)) {
            self.set_aside(run, row, "the profile file lies outside the campaign folder", "copy it into the folder");
            return None;
        }
        let path = self.folder.join(&run.profile);
        if !path.is_file() {
            self.set_aside(run, row, "missing profile: there is no such file in the campaign folder", "add the file, or correct its name");
            return None;
        }
        let profile = match () {
            () if is_picture(&path) => self.picture(run, row, &path),
            () if is_mesh(&path) => self.mesh(run, &path),
            () => self.outline(run, &path),
        }?;
        if profile.was_scattered() {
            self.notes.push(format!("run {}: the points were not in order round the outline; the order was reconstructed", run.id));
        }
        Some(profile)
    }

    fn picture(&mut self, run: &Run, row: usize, path: &Path) -> Option<DrapeProfile> {
        let Some(options) = self.pictures else {
            self.set_aside(
                run,
                row,
                "a picture, but the campaign has no scale for it",
                "add scale_mm_per_px to [profiles] in campaign.toml",
            );
            return None;
        };
        match image::outline(path, &options) {
            Ok(silhouette) => {
                self.sources.push(silhouette.source);
                // The first note, the grey levels, is of interest only to who looks at one picture.
                self.notes.extend(silhouette.notes.iter().skip(1).map(|note| format!("run {}: {note}", run.id)));
                Some(silhouette.profile)
            }
            Err(error) => {
                self.quarantine.push(super::quarantine::refused(Some(run.id.clone()), path.to_path_buf(), error));
                None
            }
        }
    }

    /// The hem of a mesh.
    fn mesh(&mut self, run: &Run, path: &Path) -> Option<DrapeProfile> {
        match mesh::hem(path, &mesh::Options { frame: self.meshes, ..mesh::Options::default() }) {
            Ok(hem) => {
                self.sources.push(hem.source);
                self.notes.extend(hem.notes.iter().map(|note| format!("run {}: {note}", run.id)));
                Some(hem.profile)
            }
            Err(error) => {
                self.quarantine.push(super::quarantine::refused(Some(run.id.clone()), path.to_path_buf(), error));
                None
            }
        }
    }

    fn outline(&mut self, run: &Run, path: &Path) -> Option<DrapeProfile> {
        if !self.tables.contains_key(path) {
            let table = table::profiles(path).map_err(|e| super::quarantine::refused(None, path.to_path_buf(), e));
            if let Ok(table) = &table {
                self.sources.push(table.source.clone());
                // Rows that name no profile belong to no run; they are listed once.
                self.quarantine.extend(table.quarantine.iter().filter(|q| q.run.is_none()).cloned());
            }
            self.tables.insert(path.to_path_buf(), table);
        }
        let table = match &self.tables[path] {
            Ok(table) => table,
            Err(reason) => {
                self.quarantine.push(Quarantined { run: Some(run.id.clone()), ..reason.clone() });
                return None;
            }
        };
        let mut names: Vec<&str> = table.profiles.iter().map(|p| p.name.as_str()).collect();
        for name in table.quarantine.iter().filter_map(|q| q.run.as_deref()) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let name = match names[..] {
            [only] => only.to_owned(),
            _ => run.id.clone(),
        };
        let found = table.profiles.iter().find(|p| p.name == name).map(|p| p.profile.clone());
        let mut faults: Vec<Quarantined> = table.quarantine.iter().filter(|q| q.run.as_deref() == Some(&name)).cloned().collect();
        if found.is_none() && faults.is_empty() {
            faults.push(Quarantined {
                run: None,
                file: path.to_path_buf(),
                row: None,
                value: names.join(", "),
                problem: format!("the file holds {} profiles, none of them named “{}”", names.len(), run.id),
                remedy: "name the profile like the run, or give each run its own file".into(),
            });
        }
        self.quarantine.extend(faults.into_iter().map(|fault| Quarantined { run: Some(run.id.clone()), ..fault }));
        found
    }

    /// The same bytes under two names, or one single-profile file for two runs, is one measurement counted twice.
    fn note_repeats(&mut self, runs: &[Run]) {
        let mut first: BTreeMap<&str, &Path> = BTreeMap::new();
        let mut notes = Vec::new();
        for source in &self.sources {
            match first.get(source.digest.as_str()) {
                Some(other) if *other != source.file => {
                    notes.push(format!("{} and {} are the same file under two names", other.display(), source.file.display()));
                }
                _ => {
                    first.insert(&source.digest, &source.file);
                }
            }
        }
        let mut users: BTreeMap<&Path, Vec<&str>> = BTreeMap::new();
        for run in runs.iter().filter(|run| !run.profile.as_os_str().is_empty()) {
            users.entry(&run.profile).or_default().push(&run.id);
        }
        for (file, ids) in users {
            let shared = self.tables.get(&self.folder.join(file)).is_some_and(|t| t.as_ref().is_ok_and(|t| 1 < t.profiles.len()));
            if 1 < ids.len() && !shared {
                notes.push(format!("runs {} share the profile file {}", ids.join(", "), file.display()));
            }
        }
        self.notes.extend(notes);
    }

    /// Profile files that belong to no run.
    fn note_strays(&mut self, runs: &[Run]) {
        let mut folders: Vec<PathBuf> =
            runs.iter().filter_map(|run| Some(self.folder.join(run.profile.parent()?))).filter(|f| *f != self.folder).collect();
        folders.sort();
        folders.dedup();
        for folder in folders {
            let Ok(entries) = std::fs::read_dir(&folder) else { continue };
            let mut strays: Vec<String> = entries
                .flatten()
                .map(|entry| entry.path())
                .filter(|path| is_picture(path) || is_mesh(path) || path.extension().is_some_and(|e| e == OsStr::new("csv")))
                .filter(|path| !runs.iter().any(|run| self.folder.join(&run.profile) == *path))
                .filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned()))
                .collect();
            strays.sort();
            if !strays.is_empty() {
                self.notes.push(format!(
                    "{} file(s) in {} belong to no run: {}",
                    strays.len(),
                    folder.display(),
                    delimited::shortened(&strays.join(", "))
                ));
            }
        }
    }
}
