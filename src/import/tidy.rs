//! `hemline import`: sources of any kind → the store of a campaign. First a plan that a person can check, then all of it or nothing.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::campaign_file::{self, ForImport};
use super::cells::shortened;
use super::dialect::{Dialect, Layout};
use super::image::{self, Silhouette, is_picture};
use super::mesh::{self, is_mesh};
use super::quarantine::refused;
use super::sources::{self, Sources};
use super::store::{self, Change, DEFAULT_STORE, QUARANTINE, SetAside, Stored, StoredPoint};
use super::table::{self, NamedProfile, Reading};
use super::{design_sheet, source};
use crate::error::{Error, Place};
use crate::experiment::campaign::Pictures;
use crate::experiment::{DrapeProfile, Quarantined};
use crate::units::MILLIMETRE;

/// What is told beside `campaign.toml`, and overrules it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    pub told: Dialect,
    /// Scale of pictures; where `None`, that of `campaign.toml`.
    pub pictures: Option<Pictures>,
    /// Whether a profile takes the place of one that another source gave under the same name; it is set aside unless told.
    pub replace: bool,
}

/// What one table or picture of a source comes to.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    pub source: PathBuf,
    pub content: Content,
}

/// See [`Entry`].
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    Table(Reading),
    Picture {
        points: usize,
    },
    /// The hem of a mesh.
    Mesh {
        points: usize,
    },
    /// A design table on this sheet of a workbook, with so many runs.
    Design {
        sheet: Option<String>,
        runs: usize,
    },
    /// Nothing; why.
    Nothing(String),
}

/// What an import comes to. Nothing has been written.
#[derive(Debug, Clone)]
pub struct Plan {
    campaign: PathBuf,
    changes: Vec<Change>,
    entry: bool,
    /// In the order of the sources.
    pub entries: Vec<Entry>,
    /// What these sources had that is set aside.
    pub set_aside: Vec<Quarantined>,
    pub notes: Vec<String>,
    /// Names of the profiles that these sources give, in order.
    pub profiles: Vec<String>,
    /// Profiles of the campaign after the import, those of earlier imports included.
    pub total: usize,
    /// Where they are, below the campaign.
    pub store: String,
    /// What was traced in the pictures among the sources, by profile.
    pub silhouettes: Vec<(String, Silhouette)>,
}

/// Reads the sources and works out what the store of `campaign` comes to. Only `campaign.toml`, the store and the sources are read.
///
/// # Errors
/// [`Error::Input`] or [`Error::File`] if there is no campaign, a source is not there, the store is no store, or nothing can be imported at all.
pub fn plan(named: &[PathBuf], campaign: &Path, options: &Options) -> Result<Plan, Error> {
    let toml = campaign.join("campaign.toml");
    if !toml.is_file() {
        let remedy = format!("`hemline init {}` writes a campaign to fill in; nothing was changed", campaign.display());
        return Err(Error::input(Place::file(toml), "there is no such file", remedy));
    }
    store::recover(campaign)?;
    let settings = campaign_file::for_import(&toml)?;
    let store_path = settings.store.clone().unwrap_or_else(|| PathBuf::from(DEFAULT_STORE));
    let store_name = store_path.to_string_lossy().into_owned();
    if !store_path.extension().is_some_and(|e| e.eq_ignore_ascii_case("parquet")) {
        let problem = format!("[profiles] names {store_name}, which is no Parquet file; it is left as it is");
        return Err(Error::input(Place::file(toml), problem, "name a .parquet file, or take the line out"));
    }
    let kept = campaign.join(&store_path);
    let before = if kept.is_file() { store::read(&kept)? } else { Vec::new() };
    let set_aside_before = store::read_set_aside(campaign)?;
    let Sources { files, others } = sources::expand(named)?;
    let mut gathering = Gathering::new(campaign, settings, options);
    let own: Vec<PathBuf> =
        [kept, campaign.join(QUARANTINE), campaign.join("design.csv")].iter().filter_map(|p| p.canonicalize().ok()).collect();
    for file in files {
        if file.canonicalize().is_ok_and(|file| own.contains(&file)) {
            gathering.say(&file, Content::Nothing("belongs to the campaign itself".into()));
            continue;
        }
        gathering.read(&file);
    }
    for file in others {
        gathering.say(&file, Content::Nothing("neither table, picture nor mesh".into()));
    }
    gathering.finish(before, set_aside_before, store_name)
}

impl Plan {
    /// Carries the plan out; the campaign is then as it was before, or as planned, whatever happens in between. Returns the files that changed, below
    /// the campaign; none if everything was there already.
    ///
    /// # Errors
    /// [`Error::File`] if the operating system refuses.
    pub fn write(&self) -> Result<Vec<String>, Error> {
        store::commit(&self.campaign, &self.changes, self.entry)
    }

    /// The files that [`write`](Self::write) would change.
    pub fn would_change(&self) -> Vec<String> {
        let different = |change: &&Change| !std::fs::read(self.campaign.join(&change.path)).is_ok_and(|there| there == change.bytes);
        let mut paths: Vec<String> = self.changes.iter().filter(different).map(|change| change.path.clone()).collect();
        if self.entry {
            paths.push("campaign.toml".into());
        }
        paths
    }
}

/// The sources while they are read.
struct Gathering<'a> {
    campaign: &'a Path,
    root: Option<PathBuf>,
    settings: ForImport,
    options: &'a Options,
    entries: Vec<Entry>,
    stored: Vec<Stored>,
    set_aside: Vec<(String, String, Quarantined)>,
    notes: Vec<String>,
    /// Digest and name of every source that was read.
    read: Vec<(String, PathBuf)>,
    design: Option<(PathBuf, Vec<u8>)>,
    silhouettes: Vec<(String, Silhouette)>,
}

impl<'a> Gathering<'a> {
    fn new(campaign: &'a Path, settings: ForImport, options: &'a Options) -> Self {
        let root = campaign.canonicalize().ok();
        Gathering {
            campaign,
            root,
            settings,
            options,
            entries: Vec::new(),
            stored: Vec::new(),
            set_aside: Vec::new(),
            notes: Vec::new(),
            read: Vec::new(),
            design: None,
            silhouettes: Vec::new(),
        }
    }

    fn say(&mut self, file: &Path, content: Content) {
        self.entries.push(Entry { source: file.to_path_buf(), content });
    }

    /// A source as the store names it.
    fn name(&self, file: &Path) -> String {
        let inside = || Some(file.canonicalize().ok()?.strip_prefix(self.root.as_ref()?).ok()?.to_path_buf());
        inside().unwrap_or_else(|| file.to_path_buf()).to_string_lossy().replace('\\', "/")
    }

    /// Reads one source; whatever is wrong with it is set aside.
    fn read(&mut self, file: &Path) {
        let name = self.name(file);
        let digest = match source::digest_of(file) {
            Ok(digest) => digest,
            Err(error) => return self.refuse(file, &name, "", error),
        };
        if let Some((_, first)) = self.read.iter().find(|(other, _)| *other == digest) {
            let error = Error::input(
                Place::file(file),
                format!("the same bytes as {}, which was imported", first.display()),
                "leave one of them out; the same measurement would count twice",
            );
            return self.refuse(file, &name, &digest, error);
        }
        self.read.push((digest.clone(), file.to_path_buf()));
        if is_picture(file) {
            self.picture(file, name, digest)
        } else if is_mesh(file) {
            self.mesh(file, name, digest)
        } else {
            self.table(file, name, digest)
        }
    }

    fn refuse(&mut self, file: &Path, name: &str, digest: &str, error: Error) {
        let fault = refused(None, file.to_path_buf(), error);
        self.say(file, Content::Nothing(fault.problem.clone()));
        self.set_aside.push((name.to_owned(), digest.to_owned(), fault));
    }

    fn picture(&mut self, file: &Path, name: String, digest: String) {
        let Some(pictures) = self.options.pictures.or(self.settings.pictures) else {
            let remedy = "add scale_mm_per_px, disc_mm, bar_mm or checkerboard_mm to [profiles] in campaign.toml, or say it by the flag of that name";
            return self.refuse(file, &name, &digest, Error::input(Place::file(file), "a picture, but there is no scale for it", remedy));
        };
        let silhouette = match image::outline(file, &pictures) {
            Ok(silhouette) => silhouette,
            Err(error) => return self.refuse(file, &name, &digest, error),
        };
        self.notes.extend(silhouette.notes.iter().map(|note| format!("{}: {note}", file.display())));
        self.say(file, Content::Picture { points: silhouette.profile.points().len() });
        let unit = format!("{} mm per px", silhouette.pixel.0 / MILLIMETRE);
        let profile = self.store_only(file, name, digest, &silhouette.profile, "picture", unit);
        self.silhouettes.push((profile, silhouette));
    }

    /// The hem of a mesh.
    fn mesh(&mut self, file: &Path, name: String, digest: String) {
        let found = match mesh::hem(file, &mesh::Options { frame: self.settings.meshes, ..mesh::Options::default() }) {
            Ok(found) => found,
            Err(error) => return self.refuse(file, &name, &digest, error),
        };
        self.notes.extend(found.notes.iter().map(|note| format!("{}: {note}", file.display())));
        self.say(file, Content::Mesh { points: found.profile.points().len() });
        self.store_only(file, name, digest, &found.profile, "hem of a mesh", "m".into());
    }

    /// Stores the only profile of a file that is no table; returns what it is called.
    fn store_only(&mut self, file: &Path, source: String, digest: String, profile: &DrapeProfile, layout: &str, unit: String) -> String {
        let name = file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_else(|| source.clone());
        self.stored.push(Stored {
            name: name.clone(),
            source,
            sheet: None,
            digest,
            format: file.extension().map(|e| e.to_string_lossy().to_uppercase()).unwrap_or_default(),
            encoding: None,
            separator: None,
            decimal: None,
            layout: layout.into(),
            coordinates: "x, y".into(),
            unit,
            points: profile.points().iter().map(|p| StoredPoint { x: p.x, y: p.y, weight: None, row: None }).collect(),
        });
        name
    }

    fn table(&mut self, file: &Path, name: String, digest: String) {
        let dialect = self.options.told.or(&self.settings.tables.of(&self.campaign.join(&name)));
        let design = design_sheet::find(file, &self.settings.factors, &dialect);
        let read = table::read(file, &dialect);
        if let Ok(Some(found)) = &design {
            self.say(file, Content::Design { sheet: found.sheet.clone(), runs: found.runs });
            match &self.design {
                Some((other, _)) => {
                    self.notes.push(format!("{}: its design was not used, {} has one too", file.display(), other.display()))
                }
                None => self.design = Some((file.to_path_buf(), found.csv(&name, &digest))),
            }
        }
        let read = match read {
            Ok(read) => read,
            // A workbook may hold the design only.
            Err(_) if matches!(design, Ok(Some(_))) => return,
            Err(error) => return self.refuse(file, &name, &digest, error),
        };
        let design_sheet = design.ok().flatten().and_then(|found| found.sheet);
        let about_design =
            |note: &String| design_sheet.as_ref().is_some_and(|sheet| note.starts_with(&format!("sheet “{sheet}” holds no")));
        self.notes.extend(read.notes.iter().filter(|note| !about_design(note)).map(|note| format!("{}: {note}", file.display())));
        for profile in read.profiles {
            let reading = read.readings.iter().find(|reading| reading.sheet == profile.sheet);
            self.stored.push(stored(profile, reading, &name, &digest));
        }
        read.readings.into_iter().for_each(|reading| self.say(file, Content::Table(reading)));
        self.set_aside.extend(read.quarantine.into_iter().map(|fault| (name.clone(), digest.clone(), fault)));
    }

    /// Joins what was read with what is there.
    fn finish(mut self, before: Vec<Stored>, set_aside_before: Vec<SetAside>, store: String) -> Result<Plan, Error> {
        let sources: BTreeSet<String> = self.entries.iter().map(|entry| self.name(&entry.source)).collect();
        let digests: BTreeSet<&str> = self.read.iter().map(|(digest, _)| digest.as_str()).collect();
        let superseded = |source: &str, digest: &str| sources.contains(source) || digests.contains(digest);
        let mut kept: Vec<Stored> = before.into_iter().filter(|old| !superseded(&old.source, &old.digest)).collect();
        let mut profiles = Vec::new();
        let mut fresh: Vec<Stored> = Vec::new();
        for new in std::mem::take(&mut self.stored) {
            let clash = fresh.iter().find(|other| other.name == new.name).or(kept.iter().find(|other| other.name == new.name));
            match clash {
                Some(other) if !self.options.replace || fresh.iter().any(|fresh| fresh.name == new.name) => {
                    let fault = Quarantined {
                        run: Some(new.name.clone()),
                        file: PathBuf::from(&new.source),
                        sheet: new.sheet.clone(),
                        row: new.points.first().and_then(|p| p.row),
                        value: format!("{} points", new.points.len()),
                        problem: format!("a profile of this name came from {} already", other.source),
                        remedy: "give one of them another name, or import with --replace to take this one".into(),
                    };
                    self.set_aside.push((new.source, new.digest, fault));
                }
                _ => {
                    kept.retain(|other| other.name != new.name);
                    profiles.push(new.name.clone());
                    fresh.push(new);
                }
            }
        }
        if profiles.is_empty() && self.design.is_none() {
            let first = self.set_aside.first().map(|(_, _, fault)| format!(" ({fault})")).unwrap_or_default();
            let problem = format!("not one profile could be read from {} source(s){first}", self.entries.len());
            return Err(Error::input(Place::file(self.campaign), problem, "nothing was changed"));
        }
        let mut all = kept;
        all.extend(fresh);
        // In an order that does not depend on which import came first.
        all.sort_by(|a, b| a.source.cmp(&b.source));
        let mut rows: Vec<SetAside> = set_aside_before.into_iter().filter(|old| !superseded(&old.source, old.digest())).collect();
        rows.extend(self.set_aside.iter().map(|(source, digest, fault)| row(source, digest, fault)));
        rows.sort_by(|a, b| a.source.cmp(&b.source));
        let mut changes = vec![
            Change { path: store.clone(), bytes: store::write(&all)? },
            Change { path: QUARANTINE.into(), bytes: store::write_set_aside(&rows) },
        ];
        if let Some((file, bytes)) = self.design.take() {
            match design_sheet::may_replace(&self.campaign.join("design.csv"), &bytes) {
                true => changes.push(Change { path: "design.csv".into(), bytes }),
                false => self
                    .notes
                    .push(format!("{}: its design was not used, because the campaign has a design.csv of its own", file.display())),
            }
        }
        Ok(Plan {
            campaign: self.campaign.to_path_buf(),
            changes,
            entry: self.settings.store.is_none(),
            entries: self.entries,
            set_aside: self.set_aside.into_iter().map(|(_, _, fault)| fault).collect(),
            notes: self.notes,
            profiles,
            total: all.len(),
            store,
            silhouettes: self.silhouettes,
        })
    }
}

fn stored(profile: NamedProfile, reading: Option<&Reading>, source: &str, digest: &str) -> Stored {
    let NamedProfile { name, sheet, input, input_rows, weights, .. } = profile;
    let points = input.iter().zip(&input_rows).enumerate();
    let points = points.map(|(i, (p, &row))| StoredPoint { x: p.x, y: p.y, weight: weights.get(i).copied(), row: Some(row) }).collect();
    let layout = reading.map_or(Layout::Long, |reading| reading.layout);
    Stored {
        name,
        source: source.to_owned(),
        sheet,
        digest: digest.to_owned(),
        format: reading.map(|r| r.format.to_owned()).unwrap_or_default(),
        encoding: reading.and_then(|r| r.encoding.clone()),
        separator: reading.and_then(|r| r.separator.map(String::from)),
        decimal: reading.map(|r| r.decimal.to_owned()),
        layout: layout.name().to_owned(),
        coordinates: reading.map(|r| r.coordinates.clone()).unwrap_or_default(),
        unit: reading.map(|r| r.unit.clone()).unwrap_or_default(),
        points,
    }
}

fn row(source: &str, digest: &str, fault: &Quarantined) -> SetAside {
    let text = |text: &str| store::harmless(&shortened(text));
    let long = |text: &str| super::cells::one_line(text);
    SetAside {
        source: source.to_owned(),
        cells: [
            fault.run.as_deref().map(text).unwrap_or_default(),
            fault.sheet.clone().unwrap_or_default(),
            fault.row.map(|row| row.to_string()).unwrap_or_default(),
            text(&fault.value),
            long(&fault.problem),
            long(&fault.remedy),
            digest.to_owned(),
        ],
    }
}
