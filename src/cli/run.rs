//! `hemline run`: a campaign folder → fits, predictions, regression, report.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;

use crate::cli::memory;
use crate::cli::pictures::write_overlays;
use crate::cli::print;
use crate::cli::report::ReportFlags;
use crate::error::Error;
use crate::import;
use crate::report::number::fixed;
use crate::report::{self, Part, words};
use crate::statistics::box_wilson::Analysis;
use crate::study::campaign::CampaignStudy;
use crate::study::overview::overview;
use crate::units::{MILLIMETRE, PERCENT};

/// Analyse a campaign: fit every profile, predict every hem, regress every response, write the report.
///
/// A campaign is a folder with campaign.toml (what was measured on what), design.csv (one row per run) and the profile files that the rows
/// name: tables or silhouette pictures. `hemline init DIR` writes an empty one to fill in.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  hemline run                         the campaign in data/, the report in reports/\n  \
hemline run spring --out spring-report\n\n\
Writes report.pdf, report.html, summary.json, figures/*.svg and *.png, overlays/*.png (each silhouette with its traced outline), and as CSV, in parquet/ and as sheets of\n\
report.xlsx: fits, models, folds, candidates,\n\
predictions, points, quarantine; regression, weighted,\n\
diagnostics, power, ascent, next_runs, desirability, theory_effects;\n\
fidelities, fidelity_summary, identify. docs/results.md describes every column.\n\n\
Exit code: 0 every run is fitted, 1 some run is not (quarantine.csv and fits.csv say which and why), 2 no campaign could be read.")]
pub struct Run {
    /// The campaign's folder.
    #[arg(default_value = "data")]
    pub campaign: PathBuf,
    /// Where the report goes; made if it is not there.
    #[arg(long, default_value = "reports", value_name = "DIR")]
    pub out: PathBuf,
    /// Leave out figures/ (the figures of the PDF stay): faster.
    #[arg(long)]
    pub no_pictures: bool,
    /// Print summary.json on stdout instead of the summary in words.
    #[arg(long)]
    pub json: bool,
    /// Run the three studies of `hemline study`, quickly, and print them as a chapter of report.pdf with figures of their own.
    #[arg(long)]
    pub studies: bool,
    #[command(flatten)]
    pub flags: ReportFlags,
}

impl Default for Run {
    fn default() -> Self {
        Run {
            campaign: "data".into(),
            out: "reports".into(),
            no_pictures: false,
            json: false,
            studies: false,
            flags: ReportFlags::default(),
        }
    }
}

/// Reads, analyses, writes, prints a summary on stdout; what was set aside goes to stderr, one sentence each.
///
/// # Errors
/// Those of [`import::load`] and [`report::write`].
pub fn run(args: &Run) -> Result<ExitCode, Error> {
    memory::share_heaps();
    // A header that cannot be used is said before the campaign is analysed.
    args.flags.letterhead()?;
    let mut imported = import::load(&args.campaign)?;
    let silhouettes = std::mem::take(&mut imported.silhouettes);
    let (study, bar) = super::analysed(imported);
    bar.set_message("Writing the report");
    let mut options = args.flags.options(&study)?;
    if args.no_pictures {
        options.parts.remove(&Part::Figures);
    }
    if args.studies && (options.wants(Part::Pdf) || options.wants(Part::Figures)) {
        options.sections = super::study::chapters(&bar)?;
        bar.set_message("Writing the report");
    }
    let mut written = report::write_with(&study, &args.out, &options, &super::steps(&bar))?;
    written.extend(write_overlays(&silhouettes, "run", &args.out)?);
    bar.finish_and_clear();
    if args.json {
        let json = report::summary::text(&study, &options.provenance)?;
        print(&json)?;
    } else {
        print(&summary(&study, &args.out, &written))?;
    }
    Ok(exit(&study))
}

/// 0 where every run is fitted and nothing was set aside, else 1.
pub(super) fn exit(study: &CampaignStudy) -> ExitCode {
    let whole = study.quarantine.is_empty() && study.runs.iter().all(|run| run.fit.is_ok());
    if whole { ExitCode::SUCCESS } else { ExitCode::from(1) }
}

/// What was asked, in words, for the provenance page.
pub(super) fn settings(study: &CampaignStudy) -> Vec<(String, String)> {
    use crate::experiment::campaign::{Folds, HemLength};
    let campaign = &study.campaign;
    let folds = match campaign.folds {
        Folds::Among { from, to } => format!("by evidence among {from} to {to}"),
        Folds::Exactly(m) => format!("{m}, as asked"),
    };
    let length = match campaign.hem_length {
        HemLength::Auto => "free; held where the free optimum is no sane curve".to_string(),
        HemLength::Free => "free".to_string(),
        HemLength::Held(length) => format!("held at {} mm", fixed(length / MILLIMETRE, 1)),
    };
    vec![
        ("Fold count".into(), folds),
        ("Hem length".into(), length),
        ("Bias of curvature".into(), if campaign.bias_correction { "taken out".into() } else { "left in, as asked".into() }),
        ("Significance level".into(), format!("{}", campaign.alpha)),
        ("Free fall".into(), format!("{} m/s²", campaign.gravity)),
        ("Foundation modulus E".into(), format!("{} N/m³", campaign.foundation_modulus)),
    ]
}

/// What a person wants to know before opening the report.
fn summary(study: &CampaignStudy, out: &Path, written: &[PathBuf]) -> String {
    let seen = overview(&study.runs);
    let mut text = format!("{}\n{}\n\n", study.campaign.title, study.campaign.origin);
    let mut say = |line: String| {
        text.push_str(&line);
        text.push('\n');
    };
    let millimetres = |metres: f64| fixed(metres / MILLIMETRE, 1);
    say(format!("Runs      {} of {} fitted", seen.fitted, seen.runs));
    let counts: Vec<String> =
        seen.folds.iter().map(|(m, n)| if *m == 0 { format!("round: {n}") } else { format!("{m} folds: {n}") }).collect();
    if !counts.is_empty() {
        say(format!("Folds     {}", counts.join(", ")));
    }
    if let Some(rms) = seen.rms {
        say(format!(
            "Misfit    {} mm rms (median; {} to {}), {} held at the hem's length",
            millimetres(rms.median),
            millimetres(rms.low),
            millimetres(rms.high),
            seen.held
        ));
    }
    if let Some(explained) = seen.explained {
        say(format!(
            "Curve     explains {} % of the outline's departure from a circle (median; {} to {})",
            fixed(explained.median / PERCENT, 0),
            fixed(explained.low / PERCENT, 0),
            fixed(explained.high / PERCENT, 0)
        ));
    }
    match &seen.theory {
        Some(theory) => {
            let mut line = format!("Theory    {}: fold count right in {} of {} runs", theory.fidelity, theory.folds_right, theory.runs);
            line.push_str(&format!(", within one in {}", theory.folds_within_one));
            if let (Some(radius), Some(depth), Some(rms)) = (theory.mean_radius, theory.depth, theory.rms) {
                line.push_str(&format!(
                    ";\n          at the fitted fold count hem {} mm {}, folds {} mm {}, {} mm rms apart (medians)",
                    millimetres(radius.median.abs()),
                    if radius.median < 0.0 { "too far in" } else { "too far out" },
                    millimetres(depth.median.abs()),
                    if depth.median < 0.0 { "too shallow" } else { "too deep" },
                    millimetres(rms.median)
                ));
            }
            say(line);
        }
        None => {
            if let Some(reason) = study.runs.iter().find_map(|run| run.prediction_missing.as_deref()) {
                say(format!("Theory    none: {reason}"));
            }
        }
    }
    for regression in &study.regressions {
        let response = words::response(&regression.response);
        let said = match &regression.analysis {
            Ok(analysis) => effects(analysis),
            Err(reason) => format!("not regressed: {reason}"),
        };
        say(format!("{:<24} {said}", response.label));
    }
    for note in &study.notes {
        say(format!("Note      {note}"));
    }
    let files = written.len();
    match written.first() {
        Some(first) => say(format!("\n{} ({files} files in {})", first.display(), out.display())),
        None => say("\nNothing was written.".into()),
    }
    text
}

/// The effects that hold against the whole family of tests, largest first.
fn effects(analysis: &Analysis) -> String {
    let mut terms: Vec<_> = analysis
        .coefficients
        .iter()
        .filter(|c| c.term != "1" && c.p_holm.is_some_and(|p| p < 0.05))
        .map(|c| (c.t.map_or(0.0, f64::abs), format!("{}{}", if c.estimate < 0.0 { "−" } else { "+" }, c.term)))
        .collect();
    terms.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut said =
        if terms.is_empty() { "no effect".to_string() } else { terms.into_iter().map(|(_, term)| term).collect::<Vec<_>>().join(", ") };
    if analysis.equal_variances.as_ref().is_some_and(|v| !v.holds) {
        said.push_str("; cells differ in scatter");
    }
    if analysis.adequacy.as_ref().is_some_and(|v| !v.holds) {
        said.push_str("; model not adequate");
    }
    said
}
