//! `hemline fit --into`: profiles too many for memory → parts of the fits table in a folder, each written when it is whole.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::progress;
use super::told::Told;
use crate::error::{Error, Place};
use crate::experiment::{Quarantined, Source};
use crate::fit::lambda::Lambda;
use crate::fit::{self, HemFit};
use crate::import::batch::{Batch, Stretch};
use crate::report::output;
use crate::report::table::{FitRow, fits, quarantine};
use crate::study::intervals::{self, Quantile, intervals_remembering};

/// What to fit, and where the parts go.
pub(super) struct Batches<'a> {
    pub files: &'a [PathBuf],
    pub folder: &'a Path,
    /// Throw away what the folder has.
    pub again: bool,
    /// Rows of a part, about.
    pub part_rows: usize,
    pub told: &'a Told,
    pub options: fit::Options,
    pub wanted: intervals::Options,
}

const MANIFEST: &str = "manifest.json";

/// What the parts of a folder are made from: parts of another manifest do not belong together.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Manifest {
    /// Version of the program.
    hemline: String,
    sources: Vec<Measured>,
    options: String,
    intervals: String,
    part_rows: usize,
    parts: usize,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Measured {
    file: String,
    bytes: u64,
    digest: String,
    rows: usize,
}

/// What became of the profiles of a part. Written last: a part is done if its tally is there and agrees with it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
struct Tally {
    profiles: usize,
    fitted: usize,
    not_fitted: usize,
    /// Points and profiles that were set aside.
    set_aside: usize,
    /// Of the part's table, and of its table of what was set aside.
    bytes: [u64; 2],
}

/// The profiles that begin in one unit of rows.
struct Part<'a> {
    index: usize,
    batch: &'a Batch,
    stretches: Vec<Stretch>,
    /// Names that stand in several places of the file.
    scattered: &'a BTreeSet<String>,
}

/// Fits what is not done yet, and says on stderr what became of all.
///
/// # Errors
/// Those of a file that cannot be read, a folder that cannot be written, or one whose parts were made from other sources or options.
pub(super) fn run(args: &Batches<'_>) -> Result<ExitCode, Error> {
    let dialect = args.told.dialect();
    let batches: Vec<Batch> = args.files.iter().map(|file| Batch::open(file, &dialect)).collect::<Result<_, _>>()?;
    for batch in &batches {
        eprintln!("note: {}: {}", batch.source.file.display(), batch.reading);
    }
    let stretches: Vec<Vec<Vec<Stretch>>> = batches.iter().map(|batch| scan(batch, args.part_rows)).collect::<Result<_, _>>()?;
    let scattered: Vec<BTreeSet<String>> = stretches.iter().map(|units| repeated(units.iter().flatten())).collect();
    note_shared(&stretches);
    let mut parts: Vec<Part<'_>> = Vec::new();
    for ((batch, units), scattered) in batches.iter().zip(stretches).zip(&scattered) {
        for stretches in units.into_iter().filter(|stretches| !stretches.is_empty()) {
            parts.push(Part { index: parts.len(), batch, stretches, scattered });
        }
    }
    prepare(args, &batches, parts.len())?;
    let profiles: usize = parts.iter().map(|part| part.stretches.len()).sum();
    let bar = progress(profiles, "Fitting");
    // One part is the work of one thread, so no thread holds more than one in memory.
    let tallies: Vec<(Tally, bool)> = parts
        .into_par_iter()
        .with_max_len(1)
        .map(|part| {
            let kept = done(args.folder, part.index);
            let tally = match kept {
                Some(tally) => tally,
                None => fit_part(&part, args)?,
            };
            bar.inc(part.stretches.len() as u64);
            Ok((tally, kept.is_some()))
        })
        .collect::<Result<_, Error>>()?;
    bar.finish_and_clear();
    let sum = |of: &dyn Fn(&Tally) -> usize| tallies.iter().map(|(tally, _)| of(tally)).sum::<usize>();
    let kept: usize = tallies.iter().filter(|(_, kept)| *kept).map(|(tally, _)| tally.profiles).sum();
    let [profiles, fitted, not_fitted, set_aside] =
        [sum(&|t| t.profiles), sum(&|t| t.fitted), sum(&|t| t.not_fitted), sum(&|t| t.set_aside)];
    eprintln!(
        "{profiles} profiles in {} parts in {}: {fitted} fitted, {not_fitted} not fitted, {set_aside} point(s) or profile(s) set aside; {kept} profiles kept from before",
        tallies.len(),
        args.folder.display(),
    );
    if 0 < set_aside {
        eprintln!("set aside: see quarantine-*.csv in {}", args.folder.display());
    }
    if 0 < not_fitted {
        eprintln!("not fitted: rows whose termination is no_fit; their notes say why");
    }
    Ok(if fitted == profiles && set_aside == 0 && 0 < profiles {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(if profiles == 0 { 2 } else { 1 })
    })
}

/// Which rows hold which profile, by the unit in which it begins.
fn scan(batch: &Batch, part_rows: usize) -> Result<Vec<Vec<Stretch>>, Error> {
    let mut units: Vec<Vec<Stretch>> =
        batch.units(part_rows).into_par_iter().map(|rows| batch.stretches(rows)).collect::<Result<_, _>>()?;
    let mut last: Option<usize> = None;
    for unit in 0..units.len() {
        let (before, here) = units.split_at_mut(unit);
        let (Some(open), Some(first)) = (last.and_then(|last| before[last].last_mut()), here[0].first()) else {
            last = (!here[0].is_empty()).then_some(unit).or(last);
            continue;
        };
        // Rows without a name belong to what they follow.
        if open.name == first.name || first.name.is_empty() {
            open.rows.end = first.rows.end;
            here[0].remove(0);
        }
        last = (!here[0].is_empty()).then_some(unit).or(last);
    }
    Ok(units)
}

/// Names that several stretches have.
fn repeated<'a>(stretches: impl Iterator<Item = &'a Stretch>) -> BTreeSet<String> {
    let mut names: Vec<&str> = stretches.map(|stretch| stretch.name.as_str()).collect();
    names.sort_unstable();
    names.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0].to_owned()).collect()
}

/// Profiles of one name in several files are several profiles, as without --into; it is said.
fn note_shared(files: &[Vec<Vec<Stretch>>]) {
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    if files.len() < 2 {
        return;
    }
    for units in files {
        let names: BTreeSet<&str> = units.iter().flatten().map(|stretch| stretch.name.as_str()).collect();
        names.into_iter().for_each(|name| *seen.entry(name).or_default() += 1);
    }
    let shared: Vec<&str> = seen.into_iter().filter(|(_, files)| 1 < *files).map(|(name, _)| name).collect();
    if let Some(first) = shared.first() {
        eprintln!("note: {} profile name(s) stand in more than one file, such as “{first}”; each has a row of its own", shared.len());
    }
}

/// Makes the folder ready: its parts, if it has any, are of this very task.
fn prepare(args: &Batches<'_>, batches: &[Batch], parts: usize) -> Result<(), Error> {
    let measured = |batch: &Batch| {
        let Source { file, bytes, digest } = &batch.source;
        let name = file.file_name().map_or_else(|| file.display().to_string(), |name| name.to_string_lossy().into_owned());
        Measured { file: name, bytes: *bytes, digest: digest.clone(), rows: batch.rows() }
    };
    let manifest = Manifest {
        hemline: env!("CARGO_PKG_VERSION").into(),
        sources: batches.iter().map(measured).collect(),
        options: format!("{:?} {:?}", args.options, args.told.dialect()),
        intervals: format!("{:?}", args.wanted),
        part_rows: args.part_rows,
        parts,
    };
    let path = args.folder.join(MANIFEST);
    let old = ours(args.folder)?;
    if args.again {
        // Before the manifest: parts are never left beside one that is not theirs.
        old.iter().try_for_each(|file| fs::remove_file(file).map_err(|e| Error::file(file, e)))?;
    } else if path.is_file() {
        let text = fs::read(&path).map_err(|e| Error::file(&path, e))?;
        let refuse = |problem: String| {
            Error::input(Place::file(&path), problem, "name another folder, or add --again to throw away what this one has and begin anew")
        };
        let begun: Manifest =
            serde_json::from_slice(&text).map_err(|e| refuse(format!("this is no manifest of `hemline fit --into` ({e})")))?;
        let differ = [
            ("by another version of hemline", begun.hemline != manifest.hemline),
            ("from other files", begun.sources != manifest.sources),
            ("with other options", begun.options != manifest.options),
            ("with other intervals", begun.intervals != manifest.intervals),
            ("in other parts", (begun.part_rows, begun.parts) != (manifest.part_rows, manifest.parts)),
        ];
        let differ: Vec<&str> = differ.into_iter().filter(|(_, differs)| *differs).map(|(what, _)| what).collect();
        if !differ.is_empty() {
            return Err(refuse(format!("the parts in this folder were made {}", differ.join(" and "))));
        }
        return Ok(());
    } else if let Some(file) = old.first() {
        let problem = "the folder has parts and no manifest.json that says what they were made from";
        return Err(Error::input(Place::file(file), problem, "name another folder, or add --again to throw them away"));
    }
    let text = serde_json::to_vec_pretty(&manifest).map_err(|e| Error::Output { what: MANIFEST.into(), why: e.to_string() })?;
    output::write(args.folder, MANIFEST, &text)?;
    Ok(())
}

/// Files in the folder that this command writes, besides the manifest.
fn ours(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    if !folder.exists() {
        return Ok(vec![]);
    }
    let entries = fs::read_dir(folder).map_err(|e| Error::file(folder, e))?;
    let mut found: Vec<PathBuf> = entries
        .flatten()
        .filter(|entry| {
            let name = entry.file_name().to_string_lossy().into_owned();
            let numbered = |before: &str, after: &str| {
                let number = name.strip_prefix(before).and_then(|rest| rest.strip_suffix(after));
                number.is_some_and(|n| 5 <= n.len() && n.bytes().all(|b| b.is_ascii_digit()))
            };
            numbered("part-", ".csv") || numbered("part-", ".json") || numbered("quarantine-", ".csv")
        })
        .map(|entry| entry.path())
        .collect();
    found.sort();
    Ok(found)
}

/// Names of a part's table, of what was set aside, and of its tally.
fn names(index: usize) -> [String; 3] {
    [format!("part-{index:05}.csv"), format!("quarantine-{index:05}.csv"), format!("part-{index:05}.json")]
}

/// The tally of a part that is whole.
fn done(folder: &Path, index: usize) -> Option<Tally> {
    let [table, aside, tally] = names(index);
    let tally: Tally = serde_json::from_slice(&fs::read(folder.join(tally)).ok()?).ok()?;
    let size = |name: &str| fs::metadata(folder.join(name)).map(|m| m.len());
    let whole = size(&table).is_ok_and(|bytes| bytes == tally.bytes[0]) && size(&aside).unwrap_or(0) == tally.bytes[1];
    whole.then_some(tally)
}

/// Reads, fits and writes one part.
fn fit_part(part: &Part<'_>, args: &Batches<'_>) -> Result<Tally, Error> {
    let (outlines, mut set_aside): (Vec<_>, Vec<Quarantined>) = part.batch.read(&part.stretches)?;
    // Without cloth and cut there is no λ; the table says so in its own column.
    let lambda = Lambda { missing: Some("cloth and cut are not known".into()), ..Lambda::default() };
    let mut quantile = Quantile::default();
    let mut table = fits([]);
    let mut tally = Tally { profiles: part.stretches.iter().filter(|s| !s.name.is_empty()).count(), ..Tally::default() };
    set_aside.extend(part.stretches.iter().filter(|s| part.scattered.contains(&s.name)).map(|s| part.batch.scattered(s)));
    for outline in outlines.iter().filter(|outline| !part.scattered.contains(&outline.name)) {
        let options = fit::Options { weights: outline.weights.clone(), ..args.options.clone() };
        let result: Result<HemFit, String> = fit::fit(&outline.profile, &options).map_err(|e| e.to_string()).map(|mut fitted| {
            fitted.intervals = Some(intervals_remembering(&outline.profile, &fitted, &args.wanted, &mut quantile));
            fitted
        });
        if result.is_ok() {
            tally.fitted += 1
        } else {
            tally.not_fitted += 1
        }
        let row = FitRow { run: &outline.name, profile: Some(&outline.profile), fit: &result, lambda: &lambda, study: None };
        // The row is all that stays of a fit.
        table.rows.append(&mut fits([row]).rows);
    }
    set_aside.sort_by_key(|q| q.row);
    tally.set_aside = set_aside.len();
    let [name, aside, done] = names(part.index);
    let rows = table.bytes();
    let quarantined = if set_aside.is_empty() { vec![] } else { quarantine(&set_aside).bytes() };
    tally.bytes = [rows.len() as u64, quarantined.len() as u64];
    if !quarantined.is_empty() {
        output::write(args.folder, &aside, &quarantined)?;
    }
    output::write(args.folder, &name, &rows)?;
    let text = serde_json::to_vec(&tally).map_err(|e| Error::Output { what: done.clone(), why: e.to_string() })?;
    output::write(args.folder, &done, &text)?;
    Ok(tally)
}
