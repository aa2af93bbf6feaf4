//! A campaign folder: `campaign.toml`, `design.csv` and the profile files → everything that was measured, and what was set aside.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use super::design::{self, DesignTable};
use super::dialect_table::Told;
use super::image::{self, Silhouette, is_picture};
use super::mesh::{self, is_mesh};
use super::store;
use super::table::{self, Table};
use super::{campaign_file, cells};
use crate::error::{Error, Place};
use crate::experiment::Quarantined;
use crate::experiment::Source;
use crate::experiment::campaign::{Meshes, Pictures};
use crate::experiment::{Campaign, DrapeProfile, Run};
use crate::units::{MILLIMETRE, PERCENT};

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
    /// The runs that were read from a picture, by id, in the order of the design; for the drawings that show what was traced.
    pub silhouettes: Vec<(String, Silhouette)>,
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
    // An import that was killed after it was decided on is finished first.
    store::recover(folder)?;
    let file = campaign_file::read(&toml)?;
    let table = design_table(folder)?;
    let DesignTable { design, rows, quarantine, notes, source } = design::read(&table, &file)?;
    let mut reader = Profiles {
        folder,
        design: &table,
        pictures: file.pictures,
        store: file.store.as_ref().map(|store| folder.join(store)),
        told: &file.tables,
        stored_beside: Vec::new(),
        meshes: file.meshes,
        tables: BTreeMap::new(),
        quarantine,
        sources: vec![file.source.clone(), source],
        silhouettes: vec![],
        notes,
    };
    reader.open_store(&toml)?;
    let profiles: Vec<Option<DrapeProfile>> = design.runs.iter().zip(&rows).map(|(run, &row)| reader.profile(run, row)).collect();
    reader.note_scales();
    reader.note_repeats(&design.runs);
    reader.note_strays(&design.runs);
    let Profiles { quarantine, sources, silhouettes, notes, .. } = reader;
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
        bias_correction: file.bias_correction,
        gravity: file.gravity,
        foundation_modulus: file.foundation_modulus,
        pictures: file.pictures,
        meshes: file.meshes,
        check: file.check,
        language: file.language,
    };
    known_runs(&toml, &campaign, &quarantine)?;
    Ok(Imported { campaign, profiles, quarantine, sources, silhouettes, notes })
}

/// What to say of weights, which the fits of a campaign do not take.
fn unused_weights(run: &Run, profile: &table::NamedProfile) -> Option<String> {
    (!profile.weights.is_empty())
        .then(|| format!("run {}: the weights of its points are not used in a campaign; “hemline fit” uses them", run.id))
}

/// The design table, in whichever format it is; there may be one only.
fn design_table(folder: &Path) -> Result<PathBuf, Error> {
    const NAMES: [&str; 10] = ["csv", "csv.gz", "tsv", "txt", "xlsx", "xls", "ods", "parquet", "arrow", "feather"];
    let there: Vec<PathBuf> = NAMES.iter().map(|end| folder.join(format!("design.{end}"))).filter(|path| path.is_file()).collect();
    match &there[..] {
        [only] => Ok(only.clone()),
        [] => {
            let remedy = "a campaign folder has one, with one row per run; if it is in a workbook, `hemline import` takes it over";
            Err(Error::input(Place::file(folder.join("design.csv")), "there is no such file", remedy))
        }
        [first, others @ ..] => {
            let names: Vec<String> = others.iter().map(|path| path.display().to_string()).collect();
            Err(Error::input(Place::file(first), format!("there is also {}", names.join(", ")), "keep one design table"))
        }
    }
}

/// Whether a profile is named like a run: alike, or alike but for a word such as “run” and zeros in front.
fn named_alike(profile: &str, run: &str) -> bool {
    const WORDS: [&str; 9] = ["run", "profile", "outline", "specimen", "sample", "опыт", "образец", "профиль", "versuch"];
    let bare = |name: &str| {
        let name: String = name.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect();
        let name = WORDS.iter().find_map(|word| name.strip_prefix(word)).filter(|rest| !rest.is_empty()).unwrap_or(&name).to_owned();
        match name.trim_start_matches('0') {
            number if !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()) => number.to_owned(),
            _ => name,
        }
    };
    profile == run || bare(profile) == bare(run)
}

/// The only name that means a run; one that is exactly alike goes first.
fn name_of_run<'a>(names: &[&'a str], run: &str) -> Option<&'a str> {
    let alike: Vec<&str> = names.iter().copied().filter(|name| named_alike(name, run)).collect();
    match alike[..] {
        [only] => Some(only),
        _ => alike.into_iter().find(|name| *name == run),
    }
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
    /// What `hemline import` wrote.
    store: Option<PathBuf>,
    told: &'a Told,
    /// Runs whose profile is in the store and in a file of their own too.
    stored_beside: Vec<String>,
    meshes: Meshes,
    /// Profile tables that were read; several runs may share one. A refused one keeps its reason.
    tables: BTreeMap<PathBuf, Result<Table, Quarantined>>,
    quarantine: Vec<Quarantined>,
    sources: Vec<Source>,
    silhouettes: Vec<(String, Silhouette)>,
    notes: Vec<String>,
}

impl Profiles<'_> {
    fn set_aside(&mut self, run: &Run, row: usize, problem: &str, remedy: &str) {
        self.quarantine.push(Quarantined {
            run: Some(run.id.clone()),
            file: self.design.to_path_buf(),
            sheet: None,
            row: Some(row),
            value: cells::shortened(&run.profile.display().to_string()),
            problem: problem.into(),
            remedy: remedy.into(),
        });
    }

    /// Reads the store, if the campaign names one.
    fn open_store(&mut self, toml: &Path) -> Result<(), Error> {
        let Some(store) = self.store.clone() else { return Ok(()) };
        if !store.is_file() {
            let problem = format!("[profiles] names {}, and there is no such file", store.display());
            return Err(Error::input(Place::file(toml), problem, "import into the campaign again, or take the line out"));
        }
        let table = table::read(&store, &self.told.of(&store))?;
        self.sources.push(table.source.clone());
        self.quarantine.extend(table.quarantine.iter().filter(|q| q.run.is_none()).cloned());
        self.tables.insert(store, Ok(table));
        let rejected = store::read_set_aside(self.folder).map_or(0, |rows| rows.len());
        if 0 < rejected {
            let list = self.folder.join(store::QUARANTINE);
            self.notes.push(format!("{} lists {rejected} row(s), cell(s) or file(s) that were set aside on import", list.display()));
        }
        Ok(())
    }

    /// The profile of one run in the store; `Some(None)` if it is there and cannot be used.
    fn stored(&mut self, run: &Run) -> Option<Option<DrapeProfile>> {
        let Ok(table) = self.tables.get(self.store.as_ref()?)? else { return None };
        let mut names: Vec<&str> = table.profiles.iter().map(|p| p.name.as_str()).collect();
        names.extend(table.quarantine.iter().filter_map(|q| q.run.as_deref()).filter(|run| !table.profiles.iter().any(|p| p.name == *run)));
        let name = name_of_run(&names, &run.id)?;
        let faults = table.quarantine.iter().filter(|q| q.run.as_deref() == Some(name));
        self.quarantine.extend(faults.map(|fault| Quarantined { run: Some(run.id.clone()), ..fault.clone() }));
        let found = table.profiles.iter().find(|p| p.name == name);
        self.notes.extend(found.and_then(|p| unused_weights(run, p)));
        let found = found.map(|p| p.profile.clone());
        if !run.profile.as_os_str().is_empty() && self.folder.join(&run.profile).is_file() {
            self.stored_beside.push(run.id.clone());
        }
        Some(found)
    }

    /// The profile of one run, whose row in the design table is `row`.
    fn profile(&mut self, run: &Run, row: usize) -> Option<DrapeProfile> {
        if let Some(stored) = self.stored(run) {
            if stored.as_ref().is_some_and(DrapeProfile::was_scattered) {
                self.notes.push(format!("run {}: the points were not in order round the outline; the order was reconstructed", run.id));
            }
            return stored;
        }
        if let (Some(store), true) = (self.store.clone(), run.profile.as_os_str().is_empty()) {
            let problem = format!("{} holds no profile named like the run", store.display());
            self.set_aside(run, row, &problem, "import its outline; name it, its sheet or its file like the run");
            return None;
        }
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
                "add scale_mm_per_px, disc_mm, bar_mm or checkerboard_mm to [profiles] in campaign.toml",
            );
            return None;
        };
        match image::outline(path, &options) {
            Ok(silhouette) => {
                self.sources.push(silhouette.source.clone());
                self.notes.extend(silhouette.notes.iter().map(|note| format!("run {}: {note}", run.id)));
                let profile = silhouette.profile.clone();
                self.silhouettes.push((run.id.clone(), silhouette));
                Some(profile)
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
            let table = table::read(path, &self.told.of(path)).map_err(|e| super::quarantine::refused(None, path.to_path_buf(), e));
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
            _ => name_of_run(&names, &run.id).unwrap_or(&run.id).to_owned(),
        };
        let found = table.profiles.iter().find(|p| p.name == name);
        self.notes.extend(found.and_then(|p| unused_weights(run, p)));
        let found = found.map(|p| p.profile.clone());
        let mut faults: Vec<Quarantined> = table.quarantine.iter().filter(|q| q.run.as_deref() == Some(&name)).cloned().collect();
        if found.is_none() && faults.is_empty() {
            faults.push(Quarantined {
                run: None,
                file: path.to_path_buf(),
                sheet: None,
                row: None,
                value: names.join(", "),
                problem: format!("the file holds {} profiles, none of them named “{}”", names.len(), run.id),
                remedy: "name the profile like the run, or give each run its own file".into(),
            });
        }
        self.quarantine.extend(faults.into_iter().map(|fault| Quarantined { run: Some(run.id.clone()), ..fault }));
        found
    }

    /// Scales that were found in the pictures, and how well.
    fn note_scales(&mut self) {
        let found: Vec<(&str, f64, f64)> = self
            .silhouettes
            .iter()
            .filter_map(|(id, s)| Some((id.as_str(), s.pixel.0 / MILLIMETRE, s.relative_standard_error? / PERCENT)))
            .collect();
        let Some(worst) = found.iter().max_by(|a, b| a.2.total_cmp(&b.2)) else { return };
        let (low, high) = found.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), f| (low.min(f.1), high.max(f.1)));
        self.notes.push(format!(
            "the scale was found in {} picture(s): {low:.4} to {high:.4} mm/px; relative standard error at most {:.2} % (run {})",
            found.len(),
            worst.2,
            worst.0
        ));
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
        if !self.stored_beside.is_empty() {
            let runs = cells::shortened(&self.stored_beside.join(", "));
            self.notes.push(format!("the imported profile was used, not the run's own file, for run(s) {runs}"));
        }
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
                .filter(|path| is_picture(path) || is_mesh(path) || table::is_table(path))
                .filter(|path| !runs.iter().any(|run| self.folder.join(&run.profile) == *path))
                .filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned()))
                .collect();
            strays.sort();
            if !strays.is_empty() {
                self.notes.push(format!(
                    "{} file(s) in {} belong to no run: {}",
                    strays.len(),
                    folder.display(),
                    cells::shortened(&strays.join(", "))
                ));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_are_known_by_the_number_of_their_run() {
        for name in ["7", "run 7", "Run_07", "опыт 7", "Run #7"] {
            assert!(named_alike(name, "7"), "{name}");
        }
        for name in ["17", "7a", "run", "70"] {
            assert!(!named_alike(name, "7"), "{name}");
        }
        assert_eq!(name_of_run(&["7", "run 7"], "7"), Some("7"));
        assert_eq!(name_of_run(&["07", "run 7"], "7"), None);
    }
}
