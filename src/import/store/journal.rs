//! The journal: several files of a campaign change together, or none of them, also if the program is killed in between.
//!
//! All new files are first written and synced into a folder of their own. One rename of that folder is the moment of change: before it nothing has
//! happened; after it the files are moved to their places, and whoever opens the campaign next finishes what was left.

use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Component, Path};

use super::entry::with_entry;
use crate::error::{Error, Place};

/// A change that was decided on, and is carried out.
const DECIDED: &str = ".hemline-import.commit";
/// A change that is being prepared.
const PREPARED: &str = ".hemline-import-";
const PART: &str = ".part";
/// The list of files, one path per line; file `i` of the list is called `i`.
const LIST: &str = "list";
/// A line of the list that stands for the entry in campaign.toml.
const ENTRY: &str = "campaign.toml: entry";

/// A file that is to be there.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Below the folder, with forward slashes.
    pub path: String,
    pub bytes: Vec<u8>,
}

/// Makes the changes, and with `entry` puts the entry into `campaign.toml`; all together or not at all. Returns the paths that changed.
///
/// # Errors
/// [`Error::File`] if the operating system refuses; the campaign is then as it was, or will be finished by [`recover`].
pub fn commit(folder: &Path, changes: &[Change], entry: bool) -> Result<Vec<String>, Error> {
    commit_while(folder, changes, entry, &mut || true)
}

/// As [`commit`], but stops dead where `goes_on` says no: it is asked before every step that can be seen from outside.
fn commit_while(folder: &Path, changes: &[Change], entry: bool, goes_on: &mut dyn FnMut() -> bool) -> Result<Vec<String>, Error> {
    sweep(folder, goes_on)?;
    let different = |change: &&Change| !fs::read(folder.join(&change.path)).is_ok_and(|there| there == change.bytes);
    let changes: Vec<&Change> = changes.iter().filter(different).collect();
    let mut paths: Vec<String> = changes.iter().map(|change| change.path.clone()).collect();
    let toml = folder.join("campaign.toml");
    let text = if entry { fs::read_to_string(&toml).map_err(|e| Error::file(&toml, e))? } else { String::new() };
    let entry = entry && with_entry(&toml, &text)? != text;
    if changes.is_empty() && !entry {
        return Ok(paths);
    }
    let refused = |e: std::io::Error| Error::file(folder, e);
    let prepared = tempfile::Builder::new().prefix(PREPARED).suffix(PART).tempdir_in(folder).map_err(refused)?;
    let mut list: Vec<&str> = changes.iter().map(|change| change.path.as_str()).collect();
    if entry {
        list.push(ENTRY);
    }
    for (i, change) in changes.iter().enumerate() {
        if !goes_on() {
            // As a kill would: what was prepared stays behind.
            let _ = prepared.keep();
            return Ok(Vec::new());
        }
        synced(&prepared.path().join(i.to_string()), &change.bytes)?;
    }
    synced(&prepared.path().join(LIST), list.join("\n").as_bytes())?;
    sync_folder(prepared.path())?;
    let prepared = prepared.keep();
    if !goes_on() {
        return Ok(Vec::new());
    }
    let decided = folder.join(DECIDED);
    fs::rename(&prepared, &decided).map_err(|e| {
        // Another import decided in the meantime; this one has changed nothing.
        let _ = fs::remove_dir_all(&prepared);
        Error::file(&decided, e)
    })?;
    sync_folder(folder)?;
    carry_out(folder, goes_on)?;
    if entry {
        paths.push("campaign.toml".into());
    }
    Ok(paths)
}

/// Finishes a change that was decided on and not carried out to the end.
///
/// # Errors
/// [`Error::File`] if the operating system refuses.
pub fn recover(folder: &Path) -> Result<(), Error> {
    carry_out(folder, &mut || true)
}

/// Takes away what a killed import had prepared, after finishing what one had decided.
fn sweep(folder: &Path, goes_on: &mut dyn FnMut() -> bool) -> Result<(), Error> {
    carry_out(folder, goes_on)?;
    for entry in fs::read_dir(folder).map_err(|e| Error::file(folder, e))?.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with(PREPARED) && name.ends_with(PART) {
            let path = entry.path();
            let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        }
    }
    Ok(())
}

fn carry_out(folder: &Path, goes_on: &mut dyn FnMut() -> bool) -> Result<(), Error> {
    let decided = folder.join(DECIDED);
    let list = match fs::read_to_string(decided.join(LIST)) {
        Ok(list) => list,
        Err(e) if e.kind() == ErrorKind::NotFound => {
            // The list goes last; an empty folder may be left of a change that was carried out.
            let _ = fs::remove_dir(&decided);
            return Ok(());
        }
        Err(e) => return Err(Error::file(decided.join(LIST), e)),
    };
    for (i, path) in list.lines().enumerate() {
        if !goes_on() {
            return Ok(());
        }
        if path == ENTRY {
            enter(folder)?;
            continue;
        }
        let inside = Path::new(path).components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if !inside {
            return Err(Error::input(Place::file(decided.join(LIST)), format!("“{path}” lies outside the campaign"), "delete the folder"));
        }
        let to = folder.join(path);
        if let Some(parent) = to.parent() {
            fs::create_dir_all(parent).map_err(|e| Error::file(parent, e))?;
        }
        match fs::rename(decided.join(i.to_string()), &to) {
            // Moved before the kill, or by somebody who opened the campaign at the same time.
            Err(e) if e.kind() == ErrorKind::NotFound => (),
            other => other.map_err(|e| Error::file(&to, e))?,
        }
    }
    sync_folder(folder)?;
    if !goes_on() {
        return Ok(());
    }
    let _ = fs::remove_file(decided.join(LIST));
    let _ = fs::remove_dir_all(&decided);
    Ok(())
}

/// Puts the entry into campaign.toml as it is now: what its owner wrote since is kept.
fn enter(folder: &Path) -> Result<(), Error> {
    let path = folder.join("campaign.toml");
    let refused = |e: std::io::Error| Error::file(&path, e);
    let text = fs::read_to_string(&path).map_err(refused)?;
    let written = with_entry(&path, &text)?;
    if written == text {
        return Ok(());
    }
    let mut beside = tempfile::Builder::new().prefix(PREPARED).suffix(PART).tempfile_in(folder).map_err(refused)?;
    beside.write_all(written.as_bytes()).and_then(|()| beside.as_file().sync_all()).map_err(refused)?;
    if let Ok(status) = fs::metadata(&path) {
        let _ = beside.as_file().set_permissions(status.permissions());
    }
    beside.persist(&path).map_err(|failed| refused(failed.error))?;
    Ok(())
}

fn synced(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let write = || {
        let mut file = File::create(path)?;
        file.write_all(bytes)?;
        file.sync_all()
    };
    write().map_err(|e| Error::file(path, e))
}

/// A rename is on the disk when its folder is.
fn sync_folder(folder: &Path) -> Result<(), Error> {
    #[cfg(unix)]
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(|e| Error::file(folder, e))?;
    #[cfg(not(unix))]
    let _ = folder;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const OLD: &str = "title = \"a\"\n";

    fn change(path: &str, text: &str) -> Change {
        Change { path: path.into(), bytes: text.into() }
    }

    fn state(folder: &Path) -> [String; 3] {
        ["profiles.parquet", "quarantine.csv", "campaign.toml"].map(|name| fs::read_to_string(folder.join(name)).unwrap_or_default())
    }

    #[test]
    fn an_import_that_is_cut_off_anywhere_leaves_the_old_state_or_the_new_one() {
        let changes = [change("profiles.parquet", "new points"), change("quarantine.csv", "new rows")];
        let mut seen = [0, 0];
        for stop in 0..40 {
            let folder = tempfile::TempDir::new().expect("a folder");
            fs::write(folder.path().join("campaign.toml"), OLD).expect("writable");
            fs::write(folder.path().join("profiles.parquet"), "old points").expect("writable");
            fs::write(folder.path().join("quarantine.csv"), "old rows").expect("writable");
            let old = state(folder.path());
            let new = ["new points".into(), "new rows".into(), with_entry(Path::new("t"), OLD).expect("a place")];
            let mut steps = 0;
            commit_while(folder.path(), &changes, true, &mut || {
                steps += 1;
                steps <= stop
            })
            .unwrap_or_else(|e| panic!("{e}"));
            recover(folder.path()).unwrap_or_else(|e| panic!("{e}"));
            let found = state(folder.path());
            assert!(found == old || found == new, "stopped after {stop}: {found:?}");
            seen[usize::from(found == new)] += 1;
            // The next import goes through, and leaves nothing lying about.
            commit(folder.path(), &changes, true).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(state(folder.path()), new);
            assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 3, "stopped after {stop}");
            if steps < stop {
                break;
            }
        }
        assert!(seen.iter().all(|&n| 2 <= n), "{seen:?}");
    }

    #[test]
    fn what_is_there_already_is_not_touched() {
        let folder = tempfile::TempDir::new().expect("a folder");
        let changes = [change("sub/a.parquet", "points")];
        assert_eq!(commit(folder.path(), &changes, false).expect("writable"), ["sub/a.parquet"]);
        let written = || fs::metadata(folder.path().join("sub/a.parquet")).and_then(|m| m.modified()).expect("there");
        let before = written();
        assert_eq!(commit(folder.path(), &changes, false).expect("writable"), Vec::<String>::new());
        assert_eq!(written(), before);
    }

    #[test]
    fn an_edit_of_the_owner_between_a_kill_and_the_recovery_is_kept() {
        let folder = tempfile::TempDir::new().expect("a folder");
        let toml = folder.path().join("campaign.toml");
        fs::write(&toml, OLD).expect("writable");
        let mut steps = 0;
        commit_while(folder.path(), &[change("a", "b")], true, &mut || {
            steps += 1;
            steps <= 3
        })
        .expect("writable");
        assert!(folder.path().join(DECIDED).is_dir());
        fs::write(&toml, "title = \"b\"\n").expect("writable");
        recover(folder.path()).unwrap_or_else(|e| panic!("{e}"));
        let text = fs::read_to_string(&toml).expect("there");
        assert!(text.starts_with("title = \"b\"\n") && text.contains("profiles.parquet"), "{text}");
    }
}
