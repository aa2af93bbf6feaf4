//! The baseline's file: JSON with one estimate a line, so that a version control system shows which ones moved.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::{Error, Place};
use crate::report::output;
use crate::study::baseline::{Baseline, SCHEMA};

/// What to do about a baseline that cannot be used.
const REMEDY: &str = "`hemline check --update-baseline` writes a new one";

/// Writes `baseline` to `path`, beside it first; a baseline that was there is replaced in one step.
///
/// # Errors
/// [`Error::File`] if the operating system refuses.
pub fn write(path: &Path, baseline: &Baseline) -> Result<PathBuf, Error> {
    let (folder, name) = (path.parent().unwrap_or(Path::new("")), path.file_name().unwrap_or_default().to_string_lossy());
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    output::write(folder, &name, text(baseline)?.as_bytes())
}

/// Reads a baseline back.
///
/// # Errors
/// [`Error::File`] if it cannot be read; [`Error::Input`] if it is no baseline, or one of another version.
pub fn read(path: &Path) -> Result<Baseline, Error> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(Error::input(Place::file(path), "there is no such baseline", REMEDY));
        }
        Err(error) => return Err(Error::file(path, error)),
    };
    let refused = |line: usize, why: String| {
        let place = if line == 0 { Place::file(path) } else { Place::file(path).row(line) };
        Error::input(place, why, REMEDY)
    };
    let value: serde_json::Value = serde_json::from_str(&text).map_err(|e| refused(e.line(), format!("this baseline is broken: {e}")))?;
    match value.get("schema").and_then(|schema| schema.as_str()) {
        Some(SCHEMA) => (),
        Some(other) => return Err(refused(0, format!("this baseline is of the kind “{other}”, not “{SCHEMA}”"))),
        None => return Err(refused(0, "this is no baseline: it has no “schema”".into())),
    }
    // From the text again, so that a fault has its line.
    serde_json::from_str(&text).map_err(|e| refused(e.line(), format!("this baseline is broken: {e}")))
}

fn text(baseline: &Baseline) -> Result<String, Error> {
    let failed = |error: serde_json::Error| Error::Output { what: "the baseline".into(), why: error.to_string() };
    let mut out = String::from("{\n");
    for (key, value) in [("schema", &baseline.schema), ("program", &baseline.program), ("campaign", &baseline.campaign)] {
        out += &format!("  \"{key}\": {},\n", serde_json::to_string(value).map_err(failed)?);
    }
    out += &format!("  \"coefficients\": {},\n", lines(&baseline.coefficients).map_err(failed)?);
    out += &format!("  \"runs\": {}\n}}\n", lines(&baseline.runs).map_err(failed)?);
    Ok(out)
}

fn lines<T: Serialize>(records: &[T]) -> Result<String, serde_json::Error> {
    let lines = records
        .iter()
        .map(|record| Ok(format!("    {}", serde_json::to_string(record)?)))
        .collect::<Result<Vec<_>, serde_json::Error>>()?;
    Ok(if lines.is_empty() { "[]".into() } else { format!("[\n{}\n  ]", lines.join(",\n")) })
}
