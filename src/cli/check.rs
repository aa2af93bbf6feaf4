//! `hemline check`: a campaign folder → verdicts for continuous integration.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use serde_json::Value;

use crate::error::Error;
use crate::import;
use crate::report::check::{annotations, baseline, json, junit, text};
use crate::report::output;
use crate::study::baseline::Baseline;
use crate::study::check::{Reference, check, conclusion};

/// Check a campaign, as continuous integration would: one verdict for each question and each run, response or estimate.
///
/// Asked are: is every run fitted (fitted); do replicates scatter alike (reproducibility, Cochran); do the significant terms meet the cell means
/// (adequacy, Fisher); are residuals normal (normality, Shapiro–Wilk) and unrelated in run order (independence, Durbin–Watson); are predicted and
/// measured hems near each other (theory_rms, theory_fold_depth, theory_mean_radius, theory_fold_count); and is every estimate where the baseline
/// has it, in units of its own standard error (drift). The table [check] of campaign.toml sets limits and lists the failures that are expected.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  hemline check                                                     the campaign in data/\n  \
hemline check spring --baseline spring/baseline.json --update-baseline\n  \
hemline check spring --baseline spring/baseline.json --junit check.xml\n\n\
In campaign.toml, all keys optional:\n  \
[check]\n  alpha = 0.05                  level of the tests; that of [analysis] unless told\n  \
responses = [\"p\", \"q\"]        which responses are checked; all unless told\n  \
drift_standard_errors = 1.0   how far an estimate may move\n  \
theory_rms_mm = 20            not asked unless told; as the next three\n  \
theory_fold_depth_mm = 10\n  theory_mean_radius_mm = 10\n  theory_fold_count_off = 1\n\n  \
[[check.expected]]            a failure that is accepted, until it does not fail any more\n  \
check = \"normality\"\n  responses = [\"m\"]             or runs = [\"17\"], for checks of runs\n  \
reason = \"the fold count is a small integer\"\n\n\
Inside a GitHub workflow (GITHUB_ACTIONS=true) failures are annotated.\n\n\
Exit code:\n  0  everything that was asked holds, or fails as campaign.toml expects\n  \
1  something fails, or something that was expected to fail does not\n  \
2  something that was asked could not be answered (no scatter to test with, no prediction to compare, no usable baseline, an estimate that the\n     \
baseline does not know), or the campaign could not be read; this outweighs 1, because what fails may not be all")]
pub struct Check {
    /// The campaign's folder.
    #[arg(default_value = "data")]
    pub campaign: PathBuf,
    /// Estimates of an earlier check, to measure drift from.
    #[arg(long, value_name = "FILE")]
    pub baseline: Option<PathBuf>,
    /// Write the baseline anew from this campaign, instead of measuring drift.
    #[arg(long, requires = "baseline")]
    pub update_baseline: bool,
    /// Write the verdicts as JUnit XML too.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Print JSON on stdout instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// Reads, analyses, judges; prints the verdicts on stdout and what was set aside on stderr.
///
/// # Errors
/// Those of [`import::load`] (JUnit and JSON then say so too), and [`Error::File`] where a result cannot be written.
pub fn run(args: &Check) -> Result<ExitCode, Error> {
    let imported = match import::load(&args.campaign) {
        Ok(imported) => imported,
        Err(error) => {
            let why = error.to_string();
            write_junit(args, &junit::failure(&why))?;
            if args.json {
                show(&json::failure(&why))?;
            }
            annotate(args, &annotations::annotation("error", &settings(args), "hemline check could not read the campaign", &why))?;
            return Err(error);
        }
    };
    let (study, bar) = super::analysed(imported);
    bar.finish_and_clear();
    let reference = match &args.baseline {
        None => Reference::None("give --baseline FILE".into()),
        Some(path) if args.update_baseline => {
            let found = Baseline::of(&study);
            if found.is_empty() {
                return Err(Error::Unanswerable("no run was fitted: the baseline was left as it is".into()));
            }
            baseline::write(path, &found)?;
            Reference::None(format!("the baseline was written anew, {} estimates in {}", found.len(), path.display()))
        }
        Some(path) => baseline::read(path).map_or_else(|why| Reference::Unusable(why.to_string()), Reference::Baseline),
    };
    let judgements = check(&study, &reference);
    write_junit(args, &junit::junit(&judgements))?;
    if args.json {
        show(&json::json(&study.campaign.title, &judgements))?;
    } else {
        super::print(&text::text(&study.campaign.title, &judgements))?;
    }
    annotate(args, &annotations::annotations(&settings(args), &judgements))?;
    Ok(ExitCode::from(json::exit_code(conclusion(&judgements))))
}

fn settings(args: &Check) -> PathBuf {
    args.campaign.join("campaign.toml")
}

fn write_junit(args: &Check, xml: &str) -> Result<(), Error> {
    let Some(path) = &args.junit else { return Ok(()) };
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    output::write(folder, &name, xml.as_bytes()).map(|_| ())
}

fn show(value: &Value) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(value).map_err(|e| Error::Output { what: "the JSON result".into(), why: e.to_string() })?;
    super::print(&(text + "\n"))
}

/// GitHub reads both streams; JSON has stdout for itself.
fn annotate(args: &Check, commands: &str) -> Result<(), Error> {
    if std::env::var_os("GITHUB_ACTIONS").is_none_or(|value| value != "true") {
        return Ok(());
    }
    if args.json {
        eprint!("{commands}");
        return Ok(());
    }
    super::print(commands)
}
