//! The kinds of figures: what each is called, what it shows, what it is drawn of and what must be known for it.

use super::figure::{
    agreement, contour, cube, distance, folds, gap, half_normal, hem, interactions, lambda, main_effects, multiples, pareto, pattern,
    polar, replicates, residuals, surface, symbols, uneven,
};
use super::gallery::{against, draw_fidelities, draw_rigidity, folded, medians, observations, regression_stem, rows, scores, uneven_view};
use super::words::{self, Response};
use super::{document, scenes};
use crate::error::Error;
use crate::experiment::Factor;
use crate::statistics::box_wilson::Analysis;
use crate::study::campaign::{CampaignStudy, Regression, RunStudy};

/// What a figure is drawn of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    Campaign,
    /// A page of many.
    Page,
    Run,
    Cell,
    Response,
}

/// What must be known for a figure; each level has that before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Needs {
    Nothing,
    /// The fits of its runs.
    Fits,
    /// Their predicted hems too.
    Theory,
    /// The predictions of every fidelity.
    Fidelities,
    /// The fits and the other curves, without theory.
    Shapes,
}

/// Which of a kind are in the report; any of them can be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    All,
    OneOfACell,
    OneOfACut,
    First,
}

/// What one figure shows.
#[derive(Debug, Clone, Copy)]
pub enum Subject<'a> {
    Campaign,
    /// The first is 1.
    Page(usize),
    Run(&'a RunStudy),
    /// In standard order, the first is 1.
    Cell(usize),
    Response(&'a Regression),
}

/// Draws one figure; [`Error::Unanswerable`] says why there is none.
type Draw = fn(&CampaignStudy, &Subject<'_>) -> Result<String, Error>;

/// One kind of figure.
#[derive(Debug)]
pub struct Kind {
    /// By which it is asked for.
    pub name: &'static str,
    pub of: Of,
    pub needs: Needs,
    pub shown: Shown,
    pub shows: &'static str,
    pub draw: Draw,
}

impl Kind {
    /// Its file without the extension.
    pub fn stem(&self, subject: &Subject<'_>) -> String {
        match subject {
            Subject::Campaign => self.name.into(),
            Subject::Page(page) => format!("{}_{page:02}", self.name),
            Subject::Run(run) => format!("{}_{}", self.name, words::file_stem(&run.run.id)),
            Subject::Cell(cell) => format!("{}_{cell:02}", self.name),
            Subject::Response(regression) => format!("{}_{}", regression_stem(&regression.response), self.name),
        }
    }
}

/// The kind of that name.
pub fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}

const fn of_run(name: &'static str, needs: Needs, shown: Shown, shows: &'static str, draw: Draw) -> Kind {
    Kind { name, of: Of::Run, needs, shown, shows, draw }
}

const fn of_response(name: &'static str, shows: &'static str, draw: Draw) -> Kind {
    Kind { name, of: Of::Response, needs: Needs::Fits, shown: Shown::All, shows, draw }
}

const fn of_campaign(name: &'static str, needs: Needs, shows: &'static str, draw: Draw) -> Kind {
    Kind { name, of: Of::Campaign, needs, shown: Shown::All, shows, draw }
}

/// Every kind, in the order in which they are listed.
pub const KINDS: [Kind; 29] = [
    of_run("hem", Needs::Theory, Shown::All, "one hem from above: measured, fitted, predicted; distances magnified", |_, subject| {
        hem::draw(&view(subject)?)
    }),
    of_run("distance", Needs::Fits, Shown::All, "distance of the points from the fitted curve, along the outline", |_, subject| {
        let run = fitted(subject)?;
        let (Some(profile), Ok(fit)) = (&run.profile, &run.fit) else { return Err(none("there is no fit")) };
        distance::draw(&run.run.id, profile.points(), &fit.distances, fit.rms)
    }),
    of_run("polar", Needs::Theory, Shown::All, "one hem unrolled: radius against polar angle, overhangs marked", |_, subject| {
        polar::draw(&view(fitted_subject(subject)?)?)
    }),
    of_run("skirt", Needs::Fits, Shown::OneOfACell, "the skirt in space, coloured by flexure and by stress intensity", |study, subject| {
        surface::draw(&scenes::skirt(fitted(subject)?, study.campaign.gravity).map_err(|why| none(&why))?)
    }),
    of_run("pattern", Needs::Nothing, Shown::OneOfACut, "the flat pattern to scale, with its dimensions", |_, subject| {
        let run = run(subject)?;
        pattern::draw(&format!("Run {}", run.run.id), &scenes::cone(run).map_err(|why| none(&why))?)
    }),
    of_run("cone", Needs::Nothing, Shown::First, "the truncated cone and its dimensions (paper, Figure 1)", |_, subject| {
        scenes::figure_one(run(subject)?)
    }),
    of_run(
        "plan",
        Needs::Fits,
        Shown::First,
        "the fitted hem from above, and a ray that meets it more than once (paper, Figure 2)",
        |_, subject| scenes::figure_two(fitted(subject)?),
    ),
    of_run("element", Needs::Fits, Shown::First, "the last of the cloth above the hem, in space (paper, Figure 3)", |_, subject| {
        scenes::figure_three(fitted(subject)?)
    }),
    of_run("curve", Needs::Fits, Shown::First, "the fitted curve between its circles (paper, Figure 4)", |_, subject| {
        scenes::figure_four(fitted(subject)?)
    }),
    of_run("shell", Needs::Fits, Shown::First, "the one-layer shell from waist to fitted hem (paper, Figure 5)", |_, subject| {
        scenes::figure_five(fitted(subject)?)
    }),
    Kind {
        name: "replicates",
        of: Of::Cell,
        needs: Needs::Fits,
        shown: Shown::All,
        shows: "the hems of one cell of the design laid over each other",
        draw: |study, subject| {
            let Subject::Cell(number) = subject else { return Err(none("no cell was named")) };
            let cells = scenes::cells_aligned(study);
            let cell = cells.get(number - 1).ok_or_else(|| none(&format!("there are {} cells", cells.len())))?;
            if cell.replicates.is_empty() { Err(none("no run of this cell has a usable profile")) } else { replicates::draw(cell) }
        },
    },
    of_campaign("cells", Needs::Fits, "all hems, cell by cell of the design, at one scale", |study, _| {
        let cells = scenes::cells_aligned(study);
        if cells.iter().all(|cell| cell.replicates.is_empty()) {
            Err(none("no run has a usable profile"))
        } else {
            replicates::draw_cells(&cells)
        }
    }),
    Kind {
        name: "all_runs",
        of: Of::Page,
        needs: Needs::Theory,
        shown: Shown::All,
        shows: "every hem at one scale, a row for each cell: measured, fitted, predicted",
        draw: |study, subject| {
            let page = if let Subject::Page(page) = subject { *page } else { 1 };
            let rows = rows(study);
            let beyond = || none(&format!("there are {} page(s) of all runs", multiples::pages(&rows)));
            multiples::draw(&rows, page)?.ok_or_else(beyond)
        },
    },
    of_response("pareto", "standardized effects of one response, the largest first", |study, subject| {
        let (said, analysis) = response(subject)?;
        let why = "the coefficients have no standard errors, so their effects cannot be standardized; half_normal ranks them without";
        let critical = analysis.t_critical.ok_or_else(|| none(why))?;
        pareto::draw(&said.label, analysis.used_runs.len(), &analysis.coefficients, critical, study.campaign.alpha)
    }),
    of_response("half_normal", "coefficients against half-normal quantiles: which stand out from noise", |_, subject| {
        let (said, analysis) = response(subject)?;
        half_normal::draw(&said.label, &said.unit, analysis.used_runs.len(), &scores(analysis), analysis.lenth.map(|l| l.margin))
    }),
    of_response("main_effects", "one response at either level of each factor", |study, subject| {
        let (said, analysis) = response(subject)?;
        main_effects::draw(&said.label, &said.unit, analysis.used_runs.len(), factors(study), &analysis.coefficients)
    }),
    of_response("interactions", "one response over one factor at either level of another", |study, subject| {
        let (said, analysis) = response(subject)?;
        if factors(study).len() < 2 {
            return Err(none("one factor has nothing to interact with"));
        }
        interactions::draw(&said.label, &said.unit, analysis.used_runs.len(), factors(study), &analysis.coefficients)
    }),
    of_response("cube", "one response at the corners of the design", |study, subject| {
        let (said, analysis) = response(subject)?;
        let drawn = cube::draw(&said.label, &said.unit, analysis.used_runs.len(), factors(study), &analysis.coefficients)?;
        drawn.ok_or_else(|| none("a cube is drawn of two or three factors"))
    }),
    of_response("contour", "lines of equal response over two factors, by the regression model", |study, subject| {
        let (said, analysis) = response(subject)?;
        let (model, called) = contour::model(&analysis.reduced.coded, &analysis.coefficients);
        let drawn = contour::draw(&said.label, &said.unit, analysis.used_runs.len(), factors(study), (&model, called))?;
        drawn.ok_or_else(|| none("contours need two factors, and a model in which one of them acts"))
    }),
    of_response("residuals", "residuals of one response: over the fitted value, in run order, against the normal law", |study, subject| {
        let (said, analysis) = response(subject)?;
        residuals::draw(&said.label, &said.unit, &observations(study, analysis))
    }),
    of_campaign("lambda", Needs::Fits, "the Lagrange multiplier of every run, two ways, and how well each holds", |study, _| {
        let (runs, name, unit) = scenes::multipliers(study);
        if runs.is_empty() { Err(none("no run has a λ: the cut of the skirts must be known")) } else { lambda::draw(&runs, name, unit) }
    }),
    of_campaign("folds", Needs::Shapes, "depth and width of every fold of every run", |study, _| {
        let hems = folded(study);
        if hems.is_empty() { Err(none("no run has folds")) } else { folds::draw(&hems) }
    }),
    of_campaign("folds_uneven", Needs::Shapes, "the most uneven hem under three curves", |study, _| {
        shapes(document::irregular::most_uneven(study))
    }),
    of_campaign("folds_reshaped", Needs::Shapes, "the hem that equal folds of another shape explain best", |study, _| {
        shapes(document::irregular::most_reshaped(study))
    }),
    of_campaign(
        "theory_agreement",
        Needs::Theory,
        "predicted against fitted radius, depth and fold count, with the 1:1 line",
        |study, _| {
            let all = against(study);
            medians(&all.gaps).ok_or_else(|| no_theory(study))?;
            agreement::draw(&all.radius, &all.depth, &all.folds)
        },
    ),
    of_campaign("theory_gap", Needs::Theory, "theory minus measurement, run by run", |study, _| {
        let all = against(study);
        let medians = medians(&all.gaps).ok_or_else(|| no_theory(study))?;
        gap::draw(&all.gaps, medians)
    }),
    of_campaign("theory_fidelities", Needs::Fidelities, "every fidelity of the theory against every run", |study, _| {
        draw_fidelities(study).unwrap_or_else(|| Err(no_theory(study)))
    }),
    of_campaign("rigidity", Needs::Fidelities, "rigidities identified from the hems against the known ones", |study, _| {
        draw_rigidity(study).unwrap_or_else(|| Err(none("no run has both a known rigidity and one identified from its hem")))
    }),
    of_campaign("symbols", Needs::Nothing, "the symbols of the hem curve", |_, _| symbols::draw()),
];

/// Why there is no such figure.
fn none(why: &str) -> Error {
    Error::Unanswerable(why.to_string())
}

fn no_theory(study: &CampaignStudy) -> Error {
    let why = study.runs.iter().find_map(|run| run.prediction_missing.clone());
    none(&format!("there is no theory to compare with: {}", why.unwrap_or_else(|| "no run is predicted at its fitted fold count".into())))
}

fn run<'a>(subject: &Subject<'a>) -> Result<&'a RunStudy, Error> {
    if let Subject::Run(run) = subject { Ok(run) } else { Err(none("no run was named")) }
}

fn fitted<'a>(subject: &Subject<'a>) -> Result<&'a RunStudy, Error> {
    let run = run(subject)?;
    match &run.fit {
        Ok(_) => Ok(run),
        Err(why) => Err(none(&format!("run {} has no fit: {why}", run.run.id))),
    }
}

fn fitted_subject<'s, 'a>(subject: &'s Subject<'a>) -> Result<&'s Subject<'a>, Error> {
    fitted(subject).map(|_| subject)
}

fn view(subject: &Subject<'_>) -> Result<hem::View, Error> {
    let run = run(subject)?;
    hem::View::of(run).ok_or_else(|| none(&format!("run {} has no usable profile", run.run.id)))
}

fn response<'a>(subject: &Subject<'a>) -> Result<(Response, &'a Analysis), Error> {
    let Subject::Response(regression) = subject else { return Err(none("no response was named")) };
    let said = words::response(&regression.response);
    match &regression.analysis {
        Ok(analysis) => Ok((said, analysis)),
        Err(why) => Err(none(&format!("{} has no regression: {why}", regression.response))),
    }
}

fn factors(study: &CampaignStudy) -> &[Factor] {
    &study.campaign.design.factors
}

fn shapes(run: Option<&RunStudy>) -> Result<String, Error> {
    let view = run.and_then(uneven_view).ok_or_else(|| none("no run has folds that can be compared"))?;
    uneven::draw(&view)
}
