//! `hemline plot`: one figure, by name.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;

use super::fit::{Reading, read};
use super::mesh::Frame;
use super::pictures::PictureFlags;
use super::told::Told;
use super::{print, progress};
use crate::error::Error;
use crate::experiment::campaign::{Folds, HemLength, Language, RESPONSES};
use crate::experiment::{Apparatus, Campaign, CheckRules, Design, DrapeProfile, Fabric, Run};
use crate::import;
use crate::report::figure::sheet;
use crate::report::gallery::{cell_name, cells_of};
use crate::report::kinds::{self, KINDS, Kind, Needs, Of, Subject};
use crate::report::number::fixed;
use crate::report::picture::{self, Form};
use crate::report::{self, Date, output, raster, words};
use crate::study::campaign::{CampaignStudy, Measured};
use crate::study::part::{Part, Runs, analyse_part};
use crate::study::response;
use crate::units::{INCH, MILLIMETRE, STANDARD_GRAVITY};

/// Draw one figure: of a campaign, or of profile files alone. Nothing is computed that the figure does not show.
///
/// `hemline plot --list` names every figure. A figure of one run needs --run, of one response --response, of one cell --cell; a name as in reports/figures/
/// (hem_7, regression_q_mm_pareto) has it in itself.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  hemline plot --list\n  hemline plot hem --run 7\n  hemline plot hem_7 --out hem.pdf\n  \
hemline plot contour --response q --out contour.png --dpi 600 --width-mm 85 --grey\n  hemline plot skirt --run 12 --campaign spring\n  \
hemline plot hem outline.csv --out hem.png\n\n\
Exit code: 0 the figure is written, 2 there is no such figure (it is said why).")]
pub struct Plot {
    /// The figure.
    #[arg(value_name = "FIGURE", required_unless_present = "list")]
    pub figure: Option<String>,
    /// Profile tables, silhouettes or meshes instead of a campaign, as `hemline fit` takes them.
    #[arg(value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// The campaign's folder.
    #[arg(long, default_value = "data", value_name = "DIR", conflicts_with = "files")]
    pub campaign: PathBuf,
    /// Say which figures there are, and exit.
    #[arg(long)]
    pub list: bool,
    /// Of which run; of which profile, where a file holds several.
    #[arg(long)]
    pub run: Option<String>,
    /// Of which response: p, q, s, m, lambda …, or a column of fits.csv.
    #[arg(long)]
    pub response: Option<String>,
    /// Of which cell of the design, counted with the first factor fastest from 1.
    #[arg(long)]
    pub cell: Option<usize>,
    /// Which page, where a figure has several.
    #[arg(long, default_value_t = 1)]
    pub page: usize,
    /// Where it goes: a file ending in .svg, .png or .pdf, or - for SVG on stdout; FIGURE.svg here unless told.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Dots per inch of a PNG, 20 to 2400.
    #[arg(long, default_value_t = raster::DPI, value_parser = super::dots, value_name = "DPI")]
    pub dpi: f64,
    /// Width on paper; height and type go with it. As it was drawn unless told.
    #[arg(long, value_parser = width, value_name = "MM")]
    pub width_mm: Option<f64>,
    /// In grey.
    #[arg(long)]
    pub grey: bool,
    /// Language of the words in it: en or ru; `language` of campaign.toml unless told.
    #[arg(long, value_parser = super::report::language, value_name = "en|ru")]
    pub language: Option<Language>,
    #[command(flatten)]
    pub pictures: PictureFlags,
    #[command(flatten)]
    pub frame: Frame,
    #[command(flatten)]
    pub told: Told,
}

/// What was asked for, before anything is read but the names.
struct Wanted {
    kind: &'static Kind,
    run: Option<String>,
    response: Option<String>,
    cell: Option<usize>,
    page: usize,
}

/// Draws the figure and says where it is.
///
/// # Errors
/// [`Error::Unanswerable`] if there is no such figure; those of [`import::load`] and of writing.
pub fn run(args: &Plot) -> Result<ExitCode, Error> {
    let form = form(args.out.as_deref())?;
    let files = if args.files.is_empty() { None } else { Some(of_files(args)?) };
    // The design alone says which runs there are; profiles are read for the runs that the figure shows.
    let campaign = match &files {
        Some(measured) => measured.campaign.clone(),
        None => import::load_some(&args.campaign, &|_| false)?.campaign,
    };
    let Some(name) = args.figure.as_deref().filter(|_| !args.list) else {
        print(&list(&campaign))?;
        return Ok(ExitCode::SUCCESS);
    };
    let wanted = wanted(name, args, &campaign)?;
    let part = part(&wanted, &campaign)?;
    let measured = match files {
        Some(measured) => measured,
        None => {
            let imported = import::load_some(&args.campaign, &|run| part.takes(run))?;
            let of_interest =
                |id: &Option<String>| id.as_ref().is_none_or(|id| campaign.design.runs.iter().any(|run| run.id == *id && part.takes(run)));
            imported.quarantine.iter().filter(|row| of_interest(&row.run)).for_each(|row| eprintln!("set aside: {row}"));
            Measured {
                campaign: imported.campaign,
                profiles: imported.profiles,
                quarantine: imported.quarantine,
                sources: imported.sources,
                notes: imported.notes,
            }
        }
    };
    let bar = progress(measured.campaign.design.runs.iter().filter(|run| part.takes(run)).count(), "Fitting");
    let study = analyse_part(measured, &part, &|| bar.inc(1));
    bar.finish_and_clear();
    let subject = subject(&wanted, &study)?;
    let stem = wanted.kind.stem(&subject);
    let svg = (wanted.kind.draw)(&study, &subject)?;
    let svg = report::in_language(&svg, &study, args.language.unwrap_or(study.campaign.language));
    let options = picture::Options { dpi: args.dpi, width: args.width_mm, grey: args.grey, date: Date::from_environment() };
    if let Some(points) = smallest_type(&svg, args.width_mm).filter(|points| *points < LEGIBLE) {
        eprintln!("note: at this width the type is as small as {} points", fixed(points, 1));
    }
    let bytes = picture::bytes(&stem, &svg, form, &options)?;
    match &args.out {
        Some(out) if out.as_os_str() == "-" => print(&String::from_utf8_lossy(&bytes))?,
        out => {
            let path = out.clone().unwrap_or_else(|| PathBuf::from(format!("{stem}.svg")));
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            output::write(folder, &name, &bytes)?;
            print(&format!("{}\n", path.display()))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Type below this, in points, is hard to read in print.
const LEGIBLE: f64 = 4.5;

/// The smallest type of a drawing that is scaled to a width, points; `None` where it is drawn in its own size.
fn smallest_type(svg: &str, width: Option<f64>) -> Option<f64> {
    let scale = width? / picture::size(svg)?.0;
    let sizes = svg.split(" font-size=\"").skip(1).filter_map(|rest| rest.split('"').next()?.parse::<f64>().ok());
    let steps = sizes.fold(f64::INFINITY, f64::min);
    Some(scale * steps / sheet::GRID * MILLIMETRE / INCH * 72.0)
}

/// By the ending of the file that is asked for; SVG where none is.
fn form(out: Option<&Path>) -> Result<Form, Error> {
    match out {
        None => Ok(Form::Svg),
        Some(path) if path.as_os_str() == "-" => Ok(Form::Svg),
        Some(path) => Form::of(path)
            .ok_or_else(|| Error::Unanswerable(format!("{}: the ending says what is written; use .svg, .png or .pdf", path.display()))),
    }
}

/// A width on paper, mm.
fn width(text: &str) -> Result<f64, String> {
    let wrong = || format!("“{text}” is no width: use millimetres from 20 to 2000, such as 85");
    text.parse::<f64>().ok().filter(|width| (20.0..=2000.0).contains(width)).ok_or_else(wrong)
}

/// The profiles of files as a campaign without cut, cloth and design.
fn of_files(args: &Plot) -> Result<Measured, Error> {
    let reading = Reading { pictures: &args.pictures, overlay: None, frame: &args.frame, told: &args.told };
    let mut profiles: Vec<(String, DrapeProfile)> = vec![];
    for file in &args.files {
        let (found, set_aside) = read(file, &reading)?;
        set_aside.iter().for_each(|sentence| eprintln!("set aside: {sentence}"));
        for (name, profile, weights) in found {
            if weights.is_some() {
                eprintln!("note: {}: the weights of its points are not used in a figure; “hemline fit” uses them", file.display());
            }
            // Two files may call their profiles alike.
            let taken = |name: &str| profiles.iter().any(|(other, _)| other == name);
            let name = (1..).map(|i| if i == 1 { name.clone() } else { format!("{name} ({i})") }).find(|name| !taken(name)).unwrap_or(name);
            profiles.push((name, profile));
        }
    }
    if profiles.is_empty() {
        return Err(Error::Unanswerable("there is no usable profile in what was given".into()));
    }
    let run = |(id, _): &(String, DrapeProfile)| Run {
        id: id.clone(),
        replicate: None,
        block: None,
        levels: vec![],
        skirt: None,
        fabric: Fabric::default(),
        profile: PathBuf::new(),
    };
    let campaign = Campaign {
        title: String::new(),
        origin: String::new(),
        apparatus: Apparatus::Skirt,
        folder: PathBuf::new(),
        design: Design { factors: vec![], runs: profiles.iter().map(run).collect() },
        responses: vec![],
        wishes: vec![],
        alpha: 0.05,
        folds: Folds::default(),
        hem_length: HemLength::Auto,
        bias_correction: true,
        gravity: STANDARD_GRAVITY,
        foundation_modulus: 0.0,
        pictures: None,
        meshes: Default::default(),
        check: CheckRules::usual(0.05, vec![]),
        language: Language::default(),
        hanging: None,
    };
    let profiles = profiles.into_iter().map(|(_, profile)| Some(profile)).collect();
    Ok(Measured { campaign, profiles, quarantine: vec![], sources: vec![], notes: vec![] })
}

/// The figure by its kind, or by the name that its file has in a report.
fn wanted(name: &str, args: &Plot, campaign: &Campaign) -> Result<Wanted, Error> {
    let name = name.trim().trim_end_matches(".svg").trim_end_matches(".png").replace('-', "_");
    let (run, response, cell) = (args.run.clone(), args.response.clone(), args.cell);
    if let Some(kind) = kinds::kind(&name) {
        return Ok(Wanted { kind, run, response, cell, page: args.page });
    }
    for kind in &KINDS {
        let found = match kind.of {
            Of::Run => {
                let rest = name.strip_prefix(&format!("{}_", kind.name));
                let run = rest.and_then(|rest| campaign.design.runs.iter().find(|run| words::file_stem(&run.id).replace('-', "_") == rest));
                run.map(|run| Wanted { kind, run: Some(run.id.clone()), response: None, cell: None, page: 1 })
            }
            Of::Response => {
                let stem = name.strip_prefix("regression_").and_then(|rest| rest.strip_suffix(&format!("_{}", kind.name)));
                stem.map(|response| Wanted { kind, run: None, response: Some(response.into()), cell: None, page: 1 })
            }
            Of::Cell | Of::Page => {
                let number = name.strip_prefix(&format!("{}_", kind.name)).and_then(|rest| rest.parse::<usize>().ok());
                number.map(|number| Wanted { kind, run: None, response: None, cell: Some(number), page: number })
            }
            Of::Campaign => None,
        };
        if let Some(found) = found {
            return Ok(found);
        }
    }
    let names: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
    Err(Error::Unanswerable(format!("there is no figure “{name}”; there are {}", names.join(", "))))
}

/// What must be computed for it. Which run, cell or response is meant is settled here.
fn part(wanted: &Wanted, campaign: &Campaign) -> Result<Part, Error> {
    let kind = wanted.kind;
    let runs = match kind.of {
        _ if kind.needs == Needs::Nothing => Runs::None,
        Of::Run => Runs::These(vec![run_id(wanted, campaign)?]),
        Of::Cell => {
            let cells = cells_of(&campaign.design.runs);
            let number = cell_number(wanted, campaign)?;
            Runs::These(cells[number - 1].1.iter().map(|run| run.id.clone()).collect())
        }
        _ => Runs::All,
    };
    let responses = if kind.of == Of::Response { vec![response_name(wanted, campaign)?] } else { vec![] };
    let of_theory = responses.iter().any(|name| name == "theory_gap_mm");
    Ok(Part {
        runs,
        theory: of_theory || [Needs::Theory, Needs::Fidelities].contains(&kind.needs),
        shapes: kind.needs == Needs::Shapes,
        fidelities: kind.needs == Needs::Fidelities,
        responses,
    })
}

fn run_id(wanted: &Wanted, campaign: &Campaign) -> Result<String, Error> {
    let ids: Vec<&str> = campaign.design.runs.iter().map(|run| run.id.as_str()).collect();
    match (&wanted.run, ids.as_slice()) {
        (Some(id), _) if ids.contains(&id.as_str()) => Ok(id.clone()),
        (Some(id), _) => Err(Error::Unanswerable(format!("there is no run “{id}”; there are {}", few(&ids)))),
        (None, [only]) => Ok((*only).to_string()),
        (None, _) => Err(Error::Unanswerable(format!("“{}” shows one run: add --run with one of {}", wanted.kind.name, few(&ids)))),
    }
}

fn cell_number(wanted: &Wanted, campaign: &Campaign) -> Result<usize, Error> {
    let cells = cells_of(&campaign.design.runs).len();
    match wanted.cell {
        Some(number) if (1..=cells).contains(&number) => Ok(number),
        Some(number) => Err(Error::Unanswerable(format!("there is no cell {number}; the design has {cells}, the first is 1"))),
        None if cells == 1 => Ok(1),
        None => {
            let name = wanted.kind.name;
            Err(Error::Unanswerable(format!(
                "“{name}” shows one cell of the design: add --cell with a number from 1 to {cells}; --list names them"
            )))
        }
    }
}

/// The column of the response that is asked for.
fn response_name(wanted: &Wanted, campaign: &Campaign) -> Result<String, Error> {
    let names = || RESPONSES.iter().map(|r| r.name).collect::<Vec<_>>().join(", ");
    let name = wanted.response.as_deref();
    let name = name
        .ok_or_else(|| Error::Unanswerable(format!("“{}” shows one response: add --response with one of {}", wanted.kind.name, names())))?;
    let found = response::named(name, response::weighed(campaign));
    found.map(|r| r.column.to_string()).ok_or_else(|| Error::Unanswerable(format!("there is no response “{name}”; there are {}", names())))
}

fn subject<'a>(wanted: &Wanted, study: &'a CampaignStudy) -> Result<Subject<'a>, Error> {
    Ok(match wanted.kind.of {
        Of::Campaign => Subject::Campaign,
        Of::Page => Subject::Page(wanted.page),
        Of::Run => {
            let id = run_id(wanted, &study.campaign)?;
            Subject::Run(study.runs.iter().find(|run| run.run.id == id).expect("the campaign has a run of this name"))
        }
        Of::Cell => Subject::Cell(cell_number(wanted, &study.campaign)?),
        Of::Response => Subject::Response(study.regressions.first().expect("the response that was asked for")),
    })
}

/// The first dozen names, and how many there are.
fn few(names: &[&str]) -> String {
    const MOST: usize = 12;
    let shown = names.iter().take(MOST).copied().collect::<Vec<_>>().join(", ");
    if MOST < names.len() { format!("{shown} … ({} in all)", names.len()) } else { shown }
}

/// Every figure, and what it can be asked of.
fn list(campaign: &Campaign) -> String {
    let mut text = String::new();
    for (of, heading) in [
        (Of::Run, "Of one run (--run)"),
        (Of::Cell, "Of one cell of the design (--cell)"),
        (Of::Response, "Of one response (--response)"),
        (Of::Campaign, "Of the campaign"),
    ] {
        text.push_str(&format!("{heading}\n"));
        let alike = |kind: &&Kind| kind.of == of || (of == Of::Campaign && kind.of == Of::Page);
        for kind in KINDS.iter().filter(alike) {
            text.push_str(&format!("  {:<18} {}\n", kind.name, kind.shows));
        }
        text.push('\n');
    }
    let ids: Vec<&str> = campaign.design.runs.iter().map(|run| run.id.as_str()).collect();
    text.push_str(&format!("Runs       {}\n", ids.join(", ")));
    let cells = cells_of(&campaign.design.runs);
    if !campaign.design.factors.is_empty() {
        for (i, (levels, _)) in cells.iter().enumerate() {
            let head = if i == 0 { "Cells" } else { "" };
            text.push_str(&format!("{head:<10} {}: {}\n", i + 1, cell_name(&campaign.design.factors, levels).join(", ")));
        }
        text.push_str(&format!("Responses  {}\n", RESPONSES.iter().map(|r| r.name).collect::<Vec<_>>().join(", ")));
    }
    text
}
