//! `hemline init`: an empty campaign folder for a laboratory to fill in.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::workbook::{self, Outlines};
use crate::error::{Error, Place};
use crate::experiment::Apparatus;
use crate::experiment::campaign::{RESPONSES, USUAL_RESPONSES};

/// Write an empty campaign: campaign.toml with a comment on every key, design.csv with the runs laid out in random order, profiles/.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hemline init spring                                       2 × 2 × 2 levels, 5 replicates, a skirt\n  \
hemline init shadows --apparatus drapemeter --factors fabric,finish --replicates 4\n  \
hemline init spring --workbook                            a spreadsheet to fill in; hemline import reads it back\n\n\
Run the trials in the order of design.csv, save each outline under the name in its column `profile` (a table, or a picture: then change the\n\
name), fill in campaign.toml, and analyse with `hemline run DIR`. Nothing is ever overwritten.\n\n\
Exit code: 0 written, 2 not written."
)]
pub struct Init {
    /// The folder to write; it must be new or empty.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Names of the two-level factors, as columns of design.csv.
    #[arg(long, value_delimiter = ',', default_value = "rigidity,density,conicity", value_name = "A,B,…")]
    pub factors: Vec<String>,
    /// Replicates of every combination of levels.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub replicates: u32,
    /// What the specimens hang from: skirt or drapemeter.
    #[arg(long, default_value = "skirt", value_parser = apparatus)]
    pub apparatus: Apparatus,
    /// Seed of the random run order.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Write workbook.xlsx to fill in, instead of design.csv and profiles/; `hemline import` reads it back. All outlines on one sheet, or
    /// --workbook=sheets for a sheet per run.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "long", value_parser = outlines, value_name = "long|sheets")]
    pub workbook: Option<Outlines>,
}

/// More factors than this make more cells than a laboratory can run.
const MOST_FACTORS: usize = 6;
/// What is measured on every cloth.
const CLOTH_COLUMNS: [&str; 2] = ["areal_density_g_m2", "flexural_rigidity_un_m"];
/// Columns of design.csv that no factor may be called.
const TAKEN: [&str; 5] = ["run", "replicate", "profile", "areal_density_g_m2", "flexural_rigidity_un_m"];

fn apparatus(text: &str) -> Result<Apparatus, String> {
    match text {
        "skirt" => Ok(Apparatus::Skirt),
        "drapemeter" => Ok(Apparatus::Drapemeter),
        _ => Err(format!("“{text}” is no apparatus: use skirt or drapemeter")),
    }
}

fn outlines(text: &str) -> Result<Outlines, String> {
    match text {
        "long" => Ok(Outlines::Long),
        "sheets" => Ok(Outlines::Sheets),
        _ => Err(format!("“{text}” is no way to write outlines down: use long (one sheet) or sheets (one for each run)")),
    }
}

/// Writes the folder and says what to do next.
///
/// # Errors
/// [`Error::Input`] if the folder holds anything already; [`Error::Unanswerable`] if the factors' names cannot be used; [`Error::File`] if
/// it cannot be written.
pub fn run(args: &Init) -> Result<ExitCode, Error> {
    check(&args.factors)?;
    if args.dir.exists() {
        let mut entries = fs::read_dir(&args.dir).map_err(|e| Error::file(&args.dir, e))?;
        if entries.next().is_some() {
            return Err(Error::input(Place::file(&args.dir), "the folder is not empty", "name a new one; nothing was changed"));
        }
    }
    let dir = args.dir.display();
    if let Some(outlines) = args.workbook {
        fs::create_dir_all(&args.dir).map_err(|e| Error::file(&args.dir, e))?;
        write(&args.dir.join("campaign.toml"), &campaign_toml(args))?;
        let design: Vec<Vec<Option<f64>>> = design(args).iter().map(Trial::numbers).collect();
        let columns = ["run", "replicate"].into_iter().chain(args.factors.iter().map(String::as_str)).chain(CLOTH_COLUMNS).collect();
        let factors = 2..2 + args.factors.len();
        let contents = workbook::Contents { columns, design: &design, factors, outlines, campaign: &dir.to_string() };
        workbook::write(&args.dir.join("workbook.xlsx"), &contents)?;
        crate::cli::print(&format!(
            "{dir}/campaign.toml  what was measured on what: fill in the lines marked with an arrow\n\
             {dir}/workbook.xlsx  {} runs in random order (seed {}), and room for their outlines\n\
             then: hemline import {dir}/workbook.xlsx --into {dir} --dry-run, the same without --dry-run, and hemline run {dir}\n",
            runs(args),
            args.seed
        ))?;
        return Ok(ExitCode::SUCCESS);
    }
    let profiles = args.dir.join("profiles");
    fs::create_dir_all(&profiles).map_err(|e| Error::file(&profiles, e))?;
    write(&args.dir.join("campaign.toml"), &campaign_toml(args))?;
    write(&args.dir.join("design.csv"), &design_csv(args))?;
    write(&profiles.join("README.md"), PROFILES)?;
    crate::cli::print(&format!(
        "{dir}/campaign.toml  what was measured on what: fill in the lines marked with an arrow\n\
         {dir}/design.csv     {} runs in random order (seed {}): fill in what was measured on each cloth\n\
         {dir}/profiles/      one outline per run; README.md there shows the format\n\
         then: hemline run {dir}\n",
        runs(args),
        args.seed
    ))?;
    Ok(ExitCode::SUCCESS)
}

fn write(path: &Path, text: &str) -> Result<(), Error> {
    fs::write(path, text).map_err(|e| Error::file(path, e))
}

/// Names must serve as CSV columns, TOML strings and terms such as `a:b`.
fn check(factors: &[String]) -> Result<(), Error> {
    let refuse = |why: String| Err(Error::Unanswerable(why));
    if factors.is_empty() || MOST_FACTORS < factors.len() {
        return refuse(format!("{} factors; 1 to {MOST_FACTORS} can be laid out", factors.len()));
    }
    for (i, name) in factors.iter().enumerate() {
        let plain = name.starts_with(|c: char| c.is_alphabetic()) && name.chars().all(|c| c.is_alphanumeric() || c == '_');
        if !plain {
            return refuse(format!("“{name}” is no name for a factor: use letters, digits and _, a letter first"));
        }
        if TAKEN.contains(&name.as_str()) || factors[..i].contains(name) {
            return refuse(format!("the name “{name}” is taken: give the factor another one"));
        }
    }
    Ok(())
}

fn runs(args: &Init) -> usize {
    (1 << args.factors.len()) * args.replicates as usize
}

/// One run that is to be carried out.
struct Trial {
    run: usize,
    replicate: u32,
    /// −1 or +1, one per factor.
    levels: Vec<i8>,
}

impl Trial {
    /// The cells of its row, what is to be filled in empty.
    fn numbers(&self) -> Vec<Option<f64>> {
        let levels = self.levels.iter().map(|&level| Some(f64::from(level)));
        [Some(self.run as f64), Some(self.replicate.into())].into_iter().chain(levels).chain(CLOTH_COLUMNS.map(|_| None)).collect()
    }
}

/// Every combination of levels, replicated, in random order.
fn design(args: &Init) -> Vec<Trial> {
    let mut order: Vec<(usize, u32)> =
        (1..=args.replicates).flat_map(|replicate| (0..1 << args.factors.len()).map(move |cell| (cell, replicate))).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(args.seed));
    let levels = |cell: usize| (0..args.factors.len()).map(|k| if cell >> k & 1 == 1 { 1 } else { -1 }).collect();
    order.into_iter().enumerate().map(|(i, (cell, replicate))| Trial { run: i + 1, replicate, levels: levels(cell) }).collect()
}

/// One row per run.
fn design_csv(args: &Init) -> String {
    let trials = design(args);
    let digits = trials.len().to_string().len();
    let mut text = format!("run,replicate,{},{},profile\n", args.factors.join(","), CLOTH_COLUMNS.join(","));
    for Trial { run, replicate, levels } in trials {
        let levels: Vec<String> = levels.iter().map(i8::to_string).collect();
        text.push_str(&format!("{run},{replicate},{},,,profiles/run_{run:0digits$}.csv\n", levels.join(",")));
    }
    text
}

fn campaign_toml(args: &Init) -> String {
    let (word, geometry) = match args.apparatus {
        Apparatus::Skirt => ("skirt", SKIRT),
        Apparatus::Drapemeter => ("drapemeter", DRAPEMETER),
    };
    let factors: String = args.factors.iter().map(|name| FACTOR.replace("NAME", name)).collect();
    let quoted = |names: &[&str]| names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    let further: Vec<&str> = RESPONSES.iter().map(|r| r.name).filter(|name| !USUAL_RESPONSES.contains(name)).collect();
    let analysis = ANALYSIS.replace("USUAL", &quoted(&USUAL_RESPONSES)).replace("FURTHER", &further.join(", "));
    HEAD.replace("APPARATUS", word) + geometry + CLOTH + &factors + &analysis
}

const HEAD: &str = r#"# A drape campaign, read by `hemline run`. Lines marked with ← are to be filled in; the rest works as it is.
# Lengths carry their unit in the key: _cm, _mm, _m or _in.

title = ""          # ← what the campaign is about
origin = ""         # ← who measured what, where and when; printed wherever the numbers appear
# language = "ru"   # of the report: "en" (unless told) or "ru"
apparatus = "APPARATUS"  # "skirt": a conic skirt hanging from a waist ring; "drapemeter": a disc of cloth on a support disc
"#;

const SKIRT: &str = r#"
# The cut, as the flat cloth has it. A quantity that changes from run to run is a column of design.csv:
#   hem_radius_cm = { column = "hem_radius_cm" }
[geometry]
waist_radius_cm = 0     # ← girth of the waist ring / 2π
hem_radius_cm = 0       # ← length of the hem along the cloth / 2π
slant_length_cm = 0     # ← from the waist ring to the hem along the cloth
"#;

const DRAPEMETER: &str = r#"
# The tester. A quantity that changes from run to run is a column of design.csv:
#   specimen_radius_cm = { column = "specimen_radius_cm" }
[geometry]
support_radius_cm = 0   # ← 9 on a Cusick tester
specimen_radius_cm = 0  # ← 12, 15 or 18 on a Cusick tester
"#;

const CLOTH: &str = r#"
# The cloth: a number, or a column of design.csv. Delete what was not measured; an empty cell is allowed, and listed.
# Without areal density λ is given per weight of cloth; without rigidity there is no prediction.
[cloth]
areal_density_g_m2 = { column = "areal_density_g_m2" }          # or _kg_m2
flexural_rigidity_un_m = { column = "flexural_rigidity_un_m" }  # µN·m; or _n_m
"#;

const FACTOR: &str = r#"
[[factors]]
name = "NAME"       # the column of design.csv
label = "NAME"      # in words, for the report
unit = ""           # of low and high
low = 0             # ← natural level at −1
high = 0            # ← natural level at +1
levels = "coded"    # the column holds −1 and 1; "natural": it holds low and high. Centre points: 0, or the middle, in all factors
"#;

const ANALYSIS: &str = r#"
# Everything below may be left out; the values shown are what is used then.
[analysis]
# What to regress on the factors; there are also FURTHER.
# responses = [USUAL]
# alpha = 0.05                  # significance level of every test
# folds = "auto"                # by evidence among 2 to 24; or a number; or { from = 3, to = 12 }
# hem_length = "auto"           # "free", or hem_length_cm = 94.2 to hold the fitted curve at that length
# bias_correction = "on"        # take out the bias that noise has where the curve bends, or "off"
# gravity_m_s2 = 9.81
# foundation_modulus_n_m3 = 0   # E of the functional
# block = "day"                 # the column of design.csv that says what was done together (day, operator, bolt of cloth …); none unless told

# What is wanted of several responses together, in the unit of their columns: the best setting of the factors is in desirability.csv.
# [[wishes]]
#   response = "fold_depth"
#   larger = { worthless = 40, perfect = 120 }    # or smaller = { perfect = …, worthless = … }
# [[wishes]]
#   response = "m"
#   target = { low = 4, target = 6, high = 8 }
#   importance = 2                                # 1 unless told

[profiles]
# scale_mm_per_px = 1.383       # pictures (PNG, JPEG, TIFF, BMP) need one scale: the side of a pixel …
# disc_mm = 180                 # … or the diameter of a disc that shows in each picture
# bar_mm = 100                  # … or the length of a plain bar
# checkerboard_mm = 10          # … or the side of a square of a checkerboard, which also corrects a tilted camera
# camera_height_mm = 1500       # where the hem is not in the plane of the scale: the camera's height above that plane
# hem_height_mm = -80           # … and the hem's; negative below
# tone = "auto"                 # "linear" (scans), "srgb" (photographs)
# object = "auto"               # "dark", "light", or "auto": what the margin of the picture is not
# file = "profiles.parquet"     # written by `hemline import`: the profiles of runs, named like them

# How tables are written. All of it is found out from the files; tell it where a file cannot say (docs/import.md).
# [tables]
# decimal = ","                 # or "."
# separator = ";"               # "comma", "semicolon", "tab" or "bar"
# encoding = "windows-1251"     # utf-8, utf-16le, windows-1252 …
# unit = "cm"                   # of lengths whose column states none
# angle = "deg"                 # or "rad", "gon"; of angles whose column states none
# clockwise = true              # angles grow clockwise
# layout = "rows"               # "long": a row per point; "rows": a row per profile; "columns": a column per profile
# header_row = 3
# sheets = ["run 1"]
# [[tables.files]]              # the same keys for some files only
#   match = "old/*.csv"
# mesh_axis = "z"               # meshes (OBJ, PLY, STL, glTF): which direction of the file is up; found by geometry unless told
# mesh_unit = "mm"              # unit of their coordinates, where their size does not tell

# What `hemline check` holds the campaign to; theory is not asked unless a limit is set.
[check]
# alpha = 0.05                  # level of the tests
# responses = [USUAL]
# drift_standard_errors = 1.0   # how far an estimate may be from the baseline
# theory_rms_mm = 20            # how far the points of a run may be from its predicted hem
# theory_fold_depth_mm = 10
# theory_mean_radius_mm = 10
# theory_fold_count_off = 1
# [[check.expected]]            # a failure that is known and accepted, with the reason
#   check = "normality"
#   responses = ["m"]           # or runs = ["17"], for checks of runs
#   reason = "the fold count is a small integer"
"#;

const PROFILES: &str = r#"# One outline per run

The column `profile` of design.csv names the file of each run. Two kinds are read.

**A table** (CSV, TSV, XLSX, XLS, ODS, Parquet, Arrow; decimal point or comma) with the hem seen from above, one row per point, at least 12 points round
the whole hem, in any order. The header says the unit: `x_cm,y_cm`, or `_mm`, `_m`, `_in`. Centre and rotation do not matter; other columns
are left alone.

    x_cm,y_cm
    21.43,0.52
    20.97,1.61
    19.88,2.94

With a further column `profile` one file can hold several outlines; each is then named like its run.

**A picture** (PNG, JPEG, TIFF, BMP): a silhouette, dark on light or light on dark, background all round it. campaign.toml needs
scale_mm_per_px, or disc_mm, bar_mm or checkerboard_mm for a thing of known size that the picture shows.
"#;

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::import;

    fn written(change: impl FnOnce(&mut Init)) -> (tempfile::TempDir, Init) {
        let folder = tempfile::TempDir::new().expect("a folder");
        let factors = ["rigidity", "density", "conicity"].map(String::from).to_vec();
        let mut args =
            Init { dir: folder.path().join("spring"), factors, replicates: 5, apparatus: Apparatus::Skirt, seed: 1, workbook: None };
        change(&mut args);
        run(&args).unwrap_or_else(|e| panic!("{e}"));
        (folder, args)
    }

    fn edit(path: PathBuf, change: impl FnOnce(String) -> String) {
        let text = fs::read_to_string(&path).expect("written");
        fs::write(&path, change(text)).expect("writable");
    }

    #[test]
    fn every_combination_of_levels_has_its_replicates_in_random_order() {
        let (_folder, args) = written(|_| ());
        let design = fs::read_to_string(args.dir.join("design.csv")).expect("written");
        let mut cells: Vec<String> = design.lines().skip(1).map(|l| l.split(',').skip(1).take(4).collect::<Vec<_>>().join(",")).collect();
        let in_order = cells.is_sorted();
        cells.sort();
        cells.dedup();
        assert!(!in_order && cells.len() == 40, "{} distinct", cells.len());
        let (_folder, other) = written(|args| args.seed = 2);
        assert_ne!(design, fs::read_to_string(other.dir.join("design.csv")).expect("written"));
        let (_folder, same) = written(|_| ());
        assert_eq!(design, fs::read_to_string(same.dir.join("design.csv")).expect("written"));
    }

    #[test]
    fn filling_in_follows_the_errors_one_by_one_until_the_campaign_loads() {
        for (apparatus, lengths) in [
            (Apparatus::Skirt, vec![("waist_radius_cm", 12), ("hem_radius_cm", 24), ("slant_length_cm", 53)]),
            (Apparatus::Drapemeter, vec![("support_radius_cm", 9), ("specimen_radius_cm", 15)]),
        ] {
            let (_folder, args) = written(|args| {
                (args.apparatus, args.replicates) = (apparatus, 2);
                args.factors = vec!["fabric".into(), "finish".into()];
            });
            let toml = || args.dir.join("campaign.toml");
            let refusal = || import::load(&args.dir).expect_err("not filled in yet").to_string();
            for key in ["title", "origin"] {
                let error = refusal();
                assert!(error.contains("campaign.toml, row ") && error.contains(&format!("“{key}” is empty")), "{error}");
                edit(toml(), |text| text.replace(&format!("{key} = \"\""), &format!("{key} = \"filled in\"")));
            }
            for (key, value) in lengths {
                let error = refusal();
                assert!(error.contains(" is 0") && error.contains("positive"), "{error}");
                edit(toml(), |text| text.replace(&format!("{key} = 0"), &format!("{key} = {value}")));
            }
            let error = refusal();
            assert!(error.contains("factor “fabric” has low = 0 and high = 0"), "{error}");
            edit(toml(), |text| text.replace("low = 0 ", "low = 5 ").replace("high = 0 ", "high = 20 "));
            let error = refusal();
            assert!(error.contains("not one of the 8 runs") && error.contains("run"), "{error}");
            for run in 1..=8 {
                let rows = (0..40)
                    .map(|i| TAU * f64::from(i) / 40.0)
                    .map(|t| format!("{:.3};{:.3}\n", 20.0 * t.cos(), 20.0 * t.sin()).replace('.', ","));
                let text = String::from("x [cm];y [cm]\n") + &rows.collect::<String>();
                fs::write(args.dir.join(format!("profiles/run_{run}.csv")), text).expect("writable");
            }
            let imported = import::load(&args.dir).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(imported.profiles.iter().flatten().count(), 8);
            // Two cloth cells per run are still empty, and listed.
            assert_eq!(imported.quarantine.len(), 16);
            assert!(imported.quarantine.iter().all(|q| q.problem.ends_with("is empty")));
        }
    }

    #[test]
    fn the_commented_defaults_are_the_defaults() {
        let (_folder, args) = written(|args| args.replicates = 1);
        let plain = |text: &str| {
            text.replace("title = \"\"", "title = \"a\"")
                .replace("origin = \"\"", "origin = \"b\"")
                .replace("_cm = 0 ", "_cm = 20 ")
                .replace("high = 0 ", "high = 1 ")
        };
        edit(args.dir.join("campaign.toml"), |text| plain(&text));
        for run in 1..=8 {
            let rows: String = (0..40).map(|i| TAU * f64::from(i) / 40.0).map(|t| format!("{},{}\n", t.cos(), t.sin())).collect();
            fs::write(args.dir.join(format!("profiles/run_{run}.csv")), String::from("x_cm,y_cm\n") + &rows).expect("writable");
        }
        let default = import::load(&args.dir).unwrap_or_else(|e| panic!("{e}")).campaign;
        assert_eq!(default.check.theory_rms, None);
        edit(args.dir.join("campaign.toml"), |text| {
            [
                "responses",
                "alpha",
                "folds",
                "hem_length",
                "bias_correction",
                "gravity_m_s2",
                "foundation_modulus_n_m3",
                "drift_standard_errors",
            ]
            .iter()
            .fold(text, |text, key| text.replace(&format!("# {key} ="), &format!("{key} =")))
        });
        let stated = import::load(&args.dir).unwrap_or_else(|e| panic!("{e}")).campaign;
        assert_eq!(default, stated);
    }

    #[test]
    fn nothing_is_overwritten_and_unusable_names_are_refused() {
        let (_folder, args) = written(|_| ());
        let before = fs::read_to_string(args.dir.join("design.csv")).expect("written");
        let error = run(&Init { seed: 9, ..args_like(&args) }).expect_err("not empty").to_string();
        assert!(error.contains("not empty") && error.contains("nothing was changed"), "{error}");
        assert_eq!(before, fs::read_to_string(args.dir.join("design.csv")).expect("still there"));
        for names in [vec!["a:b"], vec!["run"], vec!["a", "a"], vec![""], vec!["a"; 7]] {
            let factors = names.into_iter().map(String::from).collect();
            let folder = tempfile::TempDir::new().expect("a folder");
            let dir = folder.path().join("new");
            assert!(run(&Init { factors, dir: dir.clone(), ..args_like(&args) }).is_err());
            assert!(!dir.exists());
        }
    }

    fn args_like(args: &Init) -> Init {
        Init {
            workbook: None,
            dir: args.dir.clone(),
            factors: args.factors.clone(),
            replicates: args.replicates,
            apparatus: args.apparatus,
            seed: args.seed,
        }
    }
}
