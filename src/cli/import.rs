//! `hemline import`: whatever a laboratory has → the profiles of a campaign, with where each came from.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::pictures::{PictureFlags, write_overlays};
use super::print;
use super::told::Told;
use crate::error::Error;
use crate::import::tidy::{self, Content, Plan};

/// Read profiles from tables, pictures and meshes, and add them to a campaign: one tidy Parquet file with the source, sheet and row of every point, and
/// quarantine.csv with everything that was set aside and why.
///
/// Importing the same again changes nothing. A source that has changed takes the place of what it gave before. The campaign is never left half
/// changed.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  hemline import spring.xlsx --into spring --dry-run       show how it would be read\n  \
hemline import spring.xlsx --into spring\n  hemline import scans/ \"old/*.csv.gz\" --into spring --unit mm\n\n\
A profile belongs to the run that it is named like: by its column `profile` (or run, sample …), its sheet, or its file.\n\
What is told here overrules [tables] in campaign.toml; docs/import.md describes both.\n\n\
Exit code: 0 all was read, 1 something was set aside (it is named), 2 nothing could be imported, and nothing was changed.")]
pub struct Import {
    /// Tables (CSV, TSV, XLSX, XLS, ODS, Parquet, Arrow, also .gz), pictures, meshes, folders of them, or patterns in quotes.
    #[arg(required = true, value_name = "SOURCE")]
    pub sources: Vec<PathBuf>,
    /// The campaign's folder; `hemline init` makes one.
    #[arg(long, value_name = "CAMPAIGN")]
    pub into: PathBuf,
    /// Show what would be read and changed, and change nothing.
    #[arg(long)]
    pub dry_run: bool,
    /// Let a profile take the place of one that another source gave under the same name.
    #[arg(long)]
    pub replace: bool,
    #[command(flatten)]
    pub pictures: PictureFlags,
    #[command(flatten)]
    pub told: Told,
}

/// Plans, shows the plan, and carries it out.
///
/// # Errors
/// Those of [`tidy::plan`] and [`Plan::write`].
pub fn run(args: &Import) -> Result<ExitCode, Error> {
    let options = tidy::Options { told: args.told.dialect(), pictures: args.pictures.options(), replace: args.replace };
    let plan = tidy::plan(&args.sources, &args.into, &options)?;
    let mut text = table(&plan);
    for note in &plan.notes {
        text.push_str(&format!("note: {note}\n"));
    }
    for fault in &plan.set_aside {
        text.push_str(&format!("set aside: {fault}\n"));
    }
    let into = args.into.display();
    let (changed, verb) = if args.dry_run { (plan.would_change(), "would change") } else { (plan.write()?, "changed") };
    if !args.dry_run {
        for drawing in write_overlays(&plan.silhouettes, "profile", &args.into)? {
            text.push_str(&format!("drawn: {}\n", drawing.display()));
        }
    }
    text.push_str(&format!(
        "\n{} profile(s) from {} source(s), {} set aside; {into}/{} then holds {}\n",
        plan.profiles.len(),
        plan.entries.iter().map(|entry| &entry.source).collect::<std::collections::BTreeSet<_>>().len(),
        plan.set_aside.len(),
        plan.store,
        plan.total
    ));
    text.push_str(&match &changed[..] {
        [] => format!("{into}: nothing {verb}, all of it was there already\n"),
        paths => format!("{into}: {verb} {}\n", paths.join(", ")),
    });
    print(&text)?;
    Ok(if plan.set_aside.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// How every source is read, in columns for a person to check.
fn table(plan: &Plan) -> String {
    let header = [
        "source",
        "sheet",
        "format",
        "encoding",
        "separator",
        "decimal",
        "unit",
        "coordinates",
        "layout",
        "header",
        "profiles",
        "points",
        "rejected",
    ];
    let mut rows: Vec<Vec<String>> = vec![header.map(String::from).to_vec()];
    for entry in &plan.entries {
        let source = entry.source.display().to_string();
        let dash = || "–".to_string();
        let text = |text: &Option<String>| text.clone().unwrap_or_else(dash);
        rows.push(match &entry.content {
            Content::Table(r) => vec![
                source,
                text(&r.sheet),
                r.format.into(),
                text(&r.encoding),
                r.separator.map_or_else(dash, String::from),
                r.decimal.into(),
                r.unit.clone(),
                r.coordinates.clone(),
                r.layout.name().into(),
                format!("row {}", r.header_row),
                r.profiles.to_string(),
                r.points.to_string(),
                r.rejected.to_string(),
            ],
            Content::Picture { points } | Content::Mesh { points } => {
                let kind = if matches!(entry.content, Content::Mesh { .. }) { "mesh" } else { "picture" };
                let mut row = vec![source, dash(), kind.into()];
                row.extend((0..7).map(|_| dash()));
                row.extend(["1".into(), points.to_string(), "0".into()]);
                row
            }
            Content::Design { sheet, runs } => vec![source, text(sheet), format!("design of {runs} runs")],
            Content::Nothing(why) => vec![source, dash(), format!("nothing: {why}")],
        });
    }
    aligned(&rows)
}

/// Columns as wide as their widest cell; the last cell of a short row may run on.
fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let counts = |c: usize| rows.iter().filter(move |row| c + 1 < row.len() || row.len() == columns).filter_map(move |row| row.get(c));
    let widths: Vec<usize> = (0..columns).map(|c| counts(c).map(|cell| cell.chars().count()).max().unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        cells.join("  ").trim_end().to_string() + "\n"
    };
    rows.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_stand_under_each_other_and_a_remark_may_run_on() {
        let rows = [vec!["a", "b", "c"], vec!["long", "1", "2"], vec!["x", "a remark that is longer than its column"]];
        let rows = rows.map(|row| row.into_iter().map(String::from).collect::<Vec<_>>());
        assert_eq!(aligned(&rows), "a     b  c\nlong  1  2\nx     a remark that is longer than its column\n");
    }
}
