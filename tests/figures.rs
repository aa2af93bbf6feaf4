//! Every figure of the shipped campaign: its labels have room, its picture is the one that was looked at, and `hemline plot` draws it alone.
//!
//! Two switches, for people: `HEMLINE_RENEW_FIGURES=1` writes tests/fixtures/figures/*.png anew (look at them before they are committed), and
//! `HEMLINE_LABELS=FOLDER` checks the labels of all SVG files in a folder besides, such as `reports/figures`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, LazyLock};

use hemline::experiment::campaign::Language;
use hemline::import::{self, Imported};
use hemline::report::gallery::{self, Gallery};
use hemline::report::in_language;
use hemline::report::kinds::{KINDS, Needs, Of, Subject};
use hemline::report::picture::{self, Form};
use hemline::study::campaign::{CampaignStudy, Measured, analyse};
use hemline::study::part::{Part, Runs, analyse_part};
use usvg::fontdb;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn measured(imported: Imported) -> Measured {
    let Imported { campaign, profiles, quarantine, sources, notes, .. } = imported;
    Measured { campaign, profiles, quarantine, sources, notes }
}

/// The shipped campaign, or those of its runs that are kept.
fn shipped(keep: impl Fn(usize) -> bool) -> Measured {
    let mut measured = measured(import::load(&root().join("data")).unwrap());
    let mut number = 0;
    let mut kept = |_: &_| {
        number += 1;
        keep(number - 1)
    };
    let (runs, profiles) = measured.campaign.design.runs.into_iter().zip(measured.profiles).filter(|pair| kept(pair)).unzip();
    (measured.campaign.design.runs, measured.profiles) = (runs, profiles);
    measured
}

static STUDY: LazyLock<CampaignStudy> = LazyLock::new(|| analyse(shipped(|_| true), &|| ()));

/// All figures of the shipped campaign.
static GALLERY: LazyLock<Gallery> = LazyLock::new(|| gallery::draw(&STUDY).unwrap());

/// The figures of a study in Russian, whose words are longer.
fn in_russian(figures: &Gallery, study: &CampaignStudy) -> Gallery {
    figures.iter().map(|(stem, svg)| (stem.clone(), in_language(svg, study, Language::Russian))).collect()
}

// ------------------------------------------------------------------------------------------------------------------------------------ labels

static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    let condensed = [dejavu::sans_condensed::regular(), dejavu::sans_condensed::bold()];
    for data in [dejavu::sans::regular(), dejavu::sans::bold(), dejavu::sans::oblique()].into_iter().chain(condensed) {
        fonts.load_font_source(fontdb::Source::Binary(Arc::new(data)));
    }
    Arc::new(fonts)
});

/// A text with the box round its ink, mm on the sheet.
#[derive(Debug, Clone)]
struct Label {
    text: String,
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

/// Size of the sheet (mm) and its labels.
fn labels(svg: &str) -> (f64, f64, Vec<Label>) {
    let options = usvg::Options { fontdb: Arc::clone(&FONTS), font_family: "DejaVu Sans".into(), ..usvg::Options::default() };
    let tree = usvg::Tree::from_str(svg, &options).unwrap();
    // The reader counts in CSS pixels, 96 to the inch.
    let mm = |pixels: f32| f64::from(pixels) * 25.4 / 96.0;
    let mut found = vec![];
    let mut groups = vec![tree.root()];
    while let Some(group) = groups.pop() {
        for node in group.children() {
            match node {
                usvg::Node::Group(inner) => groups.push(inner),
                usvg::Node::Text(text) => {
                    let said: String = text.chunks().iter().map(|chunk| chunk.text()).collect();
                    // The ink is told in the text's own frame.
                    let ink = text.flattened().bounding_box().transform(text.abs_transform()).unwrap();
                    if !said.trim().is_empty() {
                        let (left, top, right, bottom) = (mm(ink.left()), mm(ink.top()), mm(ink.right()), mm(ink.bottom()));
                        found.push(Label { text: said.trim().to_string(), left, top, right, bottom });
                    }
                }
                _ => (),
            }
        }
    }
    (mm(tree.size().width()), mm(tree.size().height()), found)
}

/// A hair: the ink of two labels may come so near to each other, and to the edge of the sheet, mm.
const HAIR: f64 = 0.05;

/// What is wrong with the labels of a figure, in words.
fn faults(svg: &str) -> Vec<String> {
    let (width, height, labels) = labels(svg);
    let mut faults = vec![];
    for (i, a) in labels.iter().enumerate() {
        if a.left < -HAIR || a.top < -HAIR || width + HAIR < a.right || height + HAIR < a.bottom {
            faults.push(format!(
                "“{}” leaves the sheet: {:.1} to {:.1}, {:.1} to {:.1} of {width:.0} × {height:.0} mm",
                a.text, a.left, a.right, a.top, a.bottom
            ));
        }
        for b in &labels[..i] {
            let across = a.right.min(b.right) - a.left.max(b.left);
            let down = a.bottom.min(b.bottom) - a.top.max(b.top);
            if HAIR < across && HAIR < down {
                faults.push(format!("“{}” lies on “{}” at {:.1}, {:.1} mm ({across:.2} × {down:.2} mm)", a.text, b.text, a.left, a.top));
            }
        }
    }
    faults
}

fn all_faults<'a>(figures: impl IntoIterator<Item = (&'a String, &'a String)>) -> Vec<String> {
    let found = figures.into_iter().flat_map(|(stem, svg)| faults(svg).into_iter().map(move |fault| format!("{stem}: {fault}")));
    found.collect()
}

#[test]
fn no_label_of_the_shipped_campaign_lies_on_another_or_leaves_its_sheet() {
    let mut figures = GALLERY.clone();
    assert!(150 < figures.len(), "{}", figures.len());
    assert!(figures.values().all(|svg| !labels(svg).2.is_empty()), "a figure without a label was not understood");
    if let Some(folder) = std::env::var_os("HEMLINE_LABELS") {
        for path in std::fs::read_dir(&folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|e| e == "svg"))
        {
            figures.insert(path.display().to_string(), std::fs::read_to_string(&path).unwrap());
        }
        println!("checked besides: {}", Path::new(&folder).display());
    }
    let faults = all_faults(&figures);
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn no_label_in_russian_lies_on_another_or_leaves_its_sheet() {
    let figures = in_russian(&GALLERY, &STUDY);
    let said = figures.values().flat_map(|svg| labels(svg).2).filter(|label| label.text.chars().any(|c| ('а'..='я').contains(&c))).count();
    assert!(1000 < said, "{said} labels with Russian words");
    let faults = all_faults(&figures);
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

/// The texts of a drawing with the places of their x and y: (whole tag from `<text`, x, y) in grid steps.
fn tags(svg: &str) -> Vec<(&str, f64, f64)> {
    let number = |tag: &str, name: &str| tag.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
    let found = svg.match_indices("<text ").map(|(at, _)| &svg[at..at + svg[at..].find('>').unwrap()]);
    found.map(|tag| (tag, number(tag, "x"), number(tag, "y"))).collect()
}

/// The drawing with one text moved by so many mm.
fn moved(svg: &str, (tag, x, y): (&str, f64, f64), by: (f64, f64)) -> String {
    // Forty steps of the drawing's grid are a millimetre.
    let (to_x, to_y) = (x + 40.0 * by.0, y + 40.0 * by.1);
    let there =
        tag.replacen(&format!(" x=\"{x}\""), &format!(" x=\"{to_x}\""), 1).replacen(&format!(" y=\"{y}\""), &format!(" y=\"{to_y}\""), 1);
    // A turned text turns about its own place.
    let there = there.replacen(&format!(", {x}, {y})"), &format!(", {to_x}, {to_y})"), 1);
    assert_ne!(there, tag);
    svg.replacen(tag, &there, 1)
}

#[test]
fn a_label_that_is_moved_onto_another_or_off_the_sheet_is_found() {
    let svg = &GALLERY["hem_7"];
    assert_eq!(faults(svg), Vec::<String>::new());
    let tags = tags(svg);
    let (title, caption) = (tags[0], tags[1]);
    let down = (caption.2 - title.2) / 40.0;
    let onto = faults(&moved(svg, title, (0.0, down)));
    assert!(onto.iter().any(|fault| fault.contains("“Run 7”")), "{onto:?}");
    // The letters of the title are 8.5 points high: three millimetres up is off.
    let off = faults(&moved(svg, title, (0.0, -3.0)));
    assert!(off.len() == 1 && off[0].contains("leaves the sheet"), "{off:?}");
}

#[test]
fn campaigns_of_two_factors_of_one_run_and_of_no_factor_have_room_for_their_labels_too() {
    let mut two = shipped(|i| i < 8);
    two.campaign.design.factors.pop();
    two.campaign.design.runs.iter_mut().for_each(|run| run.levels.truncate(2));
    let mut one = shipped(|i| i == 4);
    one.campaign.design.runs[0].id = "a run with quite a long name, 2026-11-22".into();
    let mut none = shipped(|i| (8..11).contains(&i));
    none.campaign.design.factors.clear();
    none.campaign.design.runs.iter_mut().for_each(|run| run.levels.clear());
    for (name, campaign, some) in [("two", two, "regression_q_mm_main_effects"), ("one", one, "symbols"), ("none", none, "theory_gap")] {
        let study = analyse(campaign, &|| ());
        let figures = gallery::draw(&study).unwrap();
        assert!(figures.contains_key(some), "{name}: {:?}", figures.keys());
        let russian = in_russian(&figures, &study);
        let faults = all_faults(figures.iter().chain(&russian));
        assert!(faults.is_empty(), "{name}: {} faults:\n{}", faults.len(), faults.join("\n"));
    }
}

// -------------------------------------------------------------------------------------------------------------------------------- the pictures

/// One picture of each sort of drawing, small and in grey.
const GOLDEN: [&str; 12] = [
    "hem_7",
    "polar_3",
    "distance_7",
    "replicates_05",
    "cells",
    "skirt_1",
    "pattern_1",
    "lambda",
    "theory_agreement",
    "regression_q_mm_pareto",
    "regression_q_mm_contour",
    "regression_q_mm_interactions",
];

/// Dots per inch of the golden pictures: three dots to the millimetre show where the thinnest letter stands.
const DPI: f64 = 76.2;

/// A grey picture.
#[derive(Debug, Clone, PartialEq)]
struct Picture {
    width: usize,
    levels: Vec<u8>,
}

fn picture(svg: &str) -> Picture {
    let options = picture::Options { dpi: DPI, grey: true, ..picture::Options::default() };
    decoded(&picture::bytes("golden", svg, Form::Png, &options).unwrap())
}

fn decoded(bytes: &[u8]) -> Picture {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut data).unwrap();
    let bytes = info.line_size / info.width as usize;
    Picture { width: info.width as usize, levels: data[..info.buffer_size()].iter().step_by(bytes).copied().collect() }
}

/// Dots of either picture that have no like within one dot of their place in the other: soft edges that fall a little otherwise have one, a label that stands
/// elsewhere has not.
fn strays(a: &Picture, b: &Picture) -> usize {
    assert_eq!((a.width, a.levels.len()), (b.width, b.levels.len()), "the pictures differ in size");
    // The rasterizer measures how much of a dot is covered: an edge that is rounded otherwise, by half a step of the drawing's grid, changes a dot by a
    // twenty-fifth of the scale, 10 levels; the thinnest letter in the lightest colour of type makes its dots darker by 60 and more.
    const LIKE: u8 = 48;
    let (width, height) = (a.width, a.levels.len() / a.width);
    let near = |i: usize, j: usize, other: &Picture, level: u8| {
        let (rows, columns) = (i.saturating_sub(1)..=(i + 1).min(height - 1), j.saturating_sub(1)..=(j + 1).min(width - 1));
        rows.flat_map(|r| columns.clone().map(move |c| (r, c))).any(|(r, c)| level.abs_diff(other.levels[r * width + c]) < LIKE)
    };
    let one_way = |from: &Picture, to: &Picture| {
        (0..height).flat_map(|i| (0..width).map(move |j| (i, j))).filter(|&(i, j)| !near(i, j, to, from.levels[i * width + j])).count()
    };
    one_way(a, b) + one_way(b, a)
}

/// So many stray dots may come from rounding; a label of one letter, moved by two millimetres, makes more.
const MOST_STRAYS: usize = 2;

fn golden(stem: &str) -> PathBuf {
    root().join(format!("tests/fixtures/figures/{stem}.png"))
}

#[test]
fn pictures_are_those_that_were_looked_at() {
    let mut faults = vec![];
    for stem in GOLDEN {
        let svg = &GALLERY[stem];
        if std::env::var_os("HEMLINE_RENEW_FIGURES").is_some() {
            let options = picture::Options { dpi: DPI, grey: true, ..picture::Options::default() };
            std::fs::create_dir_all(golden(stem).parent().unwrap()).unwrap();
            std::fs::write(golden(stem), picture::bytes(stem, svg, Form::Png, &options).unwrap()).unwrap();
        }
        let known = decoded(&std::fs::read(golden(stem)).unwrap());
        let strays = strays(&picture(svg), &known);
        if MOST_STRAYS < strays {
            let folder = std::env::temp_dir().join("hemline-figures");
            std::fs::create_dir_all(&folder).unwrap();
            let now = folder.join(format!("{stem}.svg"));
            std::fs::write(&now, svg).unwrap();
            faults.push(format!("{stem}: {strays} dots differ; now it is {}", now.display()));
        }
    }
    assert!(
        faults.is_empty(),
        "{}\nlook at them; if they are right, HEMLINE_RENEW_FIGURES=1 cargo test --release --test figures",
        faults.join("\n")
    );
}

#[test]
fn golden_pictures_are_small() {
    let bytes: u64 = GOLDEN.iter().map(|stem| std::fs::metadata(golden(stem)).unwrap().len()).sum();
    assert!(bytes < 300_000, "{bytes} bytes");
}

#[test]
fn a_label_that_is_moved_by_two_millimetres_makes_another_picture_and_soft_edges_do_not() {
    let proof = |stem: &str| {
        let svg = &GALLERY[stem];
        let known = picture(svg);
        let mut faults = vec![];
        for (i, tag) in tags(svg).into_iter().enumerate() {
            let strays = strays(&picture(&moved(svg, tag, (0.0, 2.0))), &known);
            if strays <= MOST_STRAYS {
                faults.push(format!("{stem}: label {i} ({}) moved, {strays} dots differ", tag.0));
            }
        }
        // All by half a step of the drawing's grid, twelve thousandths of a millimetre: every soft edge falls a little otherwise.
        let (head, body) = svg.split_at(svg.find('>').unwrap() + 1);
        let shifted = format!("{head}<g transform=\"translate(0.5 0.5)\">{}</g></svg>", body.trim_end().trim_end_matches("</svg>"));
        let edges = picture(&shifted);
        if edges == known {
            faults.push(format!("{stem}: nothing was shifted"));
        }
        let strays = strays(&edges, &known);
        if MOST_STRAYS < strays {
            faults.push(format!("{stem}: {strays} dots differ where only edges fell otherwise"));
        }
        faults
    };
    let faults: Vec<String> = std::thread::scope(|scope| {
        let proofs = GOLDEN.map(|stem| scope.spawn(move || proof(stem)));
        proofs.into_iter().flat_map(|proof| proof.join().unwrap()).collect()
    });
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

// ------------------------------------------------------------------------------------------------------------------------------- hemline plot

/// The subjects that a kind can have in a campaign.
fn subjects<'a>(of: Of, study: &'a CampaignStudy) -> Vec<Subject<'a>> {
    match of {
        Of::Campaign => vec![Subject::Campaign],
        Of::Page => vec![Subject::Page(1)],
        Of::Run => study.runs.iter().map(Subject::Run).collect(),
        Of::Cell => (1..=8).map(Subject::Cell).collect(),
        Of::Response => study.regressions.iter().map(Subject::Response).collect(),
    }
}

#[test]
fn a_figure_by_itself_is_the_same_as_in_the_whole_report() {
    let sixteen = || shipped(|i| i < 16);
    let responses: Vec<String> = sixteen().campaign.responses.clone();
    let whole = gallery::draw(&analyse(sixteen(), &|| ())).unwrap();
    let mut compared: BTreeMap<&str, usize> = BTreeMap::new();
    // No more than its need is computed for a figure; the two that take longest share one part.
    for needs in [vec![Needs::Nothing], vec![Needs::Fits], vec![Needs::Theory], vec![Needs::Fidelities, Needs::Shapes]] {
        let part = Part {
            runs: if needs == [Needs::Nothing] { Runs::None } else { Runs::All },
            theory: needs.iter().any(|need| [Needs::Theory, Needs::Fidelities].contains(need)),
            shapes: needs.contains(&Needs::Shapes),
            fidelities: needs.contains(&Needs::Fidelities),
            responses: if needs == [Needs::Fits] { responses.clone() } else { vec![] },
        };
        let study = analyse_part(sixteen(), &part, &|| ());
        for kind in KINDS.iter().filter(|kind| needs.contains(&kind.needs)) {
            for subject in subjects(kind.of, &study) {
                if let Some(known) = whole.get(&kind.stem(&subject)) {
                    let alone = (kind.draw)(&study, &subject).unwrap();
                    assert!(alone == *known, "{} differs", kind.stem(&subject));
                    *compared.entry(kind.name).or_default() += 1;
                }
            }
        }
    }
    // The other ranking of the coefficients is drawn where there is no t.
    let missing: Vec<&str> =
        KINDS.iter().map(|kind| kind.name).filter(|name| !compared.contains_key(name) && *name != "half_normal").collect();
    assert!(missing.is_empty(), "not compared: {missing:?}");
}

fn hemline(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_hemline")).current_dir(folder).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[test]
fn plot_writes_one_figure_in_the_form_that_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let data = root().join("data");
    let data = data.to_str().unwrap();
    let plot = |rest: &[&str]| hemline(folder.path(), &[&["plot", "--campaign", data], rest].concat());
    assert_eq!(plot(&["distance", "--run", "7"]), (0, "distance_7.svg\n".into(), String::new()));
    let svg = std::fs::read_to_string(folder.path().join("distance_7.svg")).unwrap();
    assert!(svg.starts_with("<?xml") && svg.contains(">\nRun 7: distance along the outline") && svg.contains("sans-serif"));
    // The name of a file in a report is understood too.
    assert_eq!(plot(&["distance_7", "--out", "-"]).1, svg);
    assert_eq!(plot(&["hem_7", "--out", "hem.png", "--dpi", "100", "--width-mm", "50.8", "--grey"]).0, 0);
    let png = std::fs::read(folder.path().join("hem.png")).unwrap();
    assert_eq!(png[16..20], 200_u32.to_be_bytes());
    let picture = decoded(&png);
    assert_eq!(picture.width, 200);
    assert_eq!(plot(&["pattern", "--run", "3", "--out", "sub/pattern.pdf"]).0, 0);
    assert!(std::fs::read(folder.path().join("sub/pattern.pdf")).unwrap().starts_with(b"%PDF"));
    let list = plot(&["--list"]).1;
    assert!(KINDS.iter().all(|kind| list.contains(&format!("  {} ", kind.name))), "{list}");
}

#[test]
fn plot_draws_a_profile_file_without_a_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let profile = root().join("data/profiles/run_07.csv");
    let (code, out, _) = hemline(folder.path(), &["plot", "hem", profile.to_str().unwrap(), "--out", "hem.svg"]);
    assert_eq!((code, out.as_str()), (0, "hem.svg\n"));
    let svg = std::fs::read_to_string(folder.path().join("hem.svg")).unwrap();
    assert!(svg.contains("Run run_07") || svg.contains("run_07"), "{}", &svg[..600]);
    assert!(svg.contains("\nmeasured\n") && svg.contains("\nfitted\n") && !svg.contains("\npredicted\n"));
}

#[test]
fn plot_says_in_one_sentence_what_would_be_right() {
    let folder = tempfile::tempdir().unwrap();
    let data = root().join("data");
    let profile = root().join("data/profiles/run_07.csv");
    let (data, profile) = (data.to_str().unwrap(), profile.to_str().unwrap());
    for (arguments, said) in [
        (vec!["flower", "--campaign", data], "there is no figure “flower”; there are hem, distance, polar"),
        (vec!["hem", "--campaign", data], "“hem” shows one run: add --run with one of 1, 2, 3"),
        (vec!["hem", "--run", "99", "--campaign", data], "there is no run “99”; there are 1, 2"),
        (vec!["pareto", "--campaign", data], "“pareto” shows one response: add --response with one of p, q"),
        (vec!["pareto", "--response", "colour", "--campaign", data], "there is no response “colour”; there are p, q"),
        (vec!["replicates", "--campaign", data], "add --cell with a number from 1 to 8"),
        (vec!["replicates", "--cell", "9", "--campaign", data], "there is no cell 9; the design has 8"),
        (
            vec!["hem", "--run", "7", "--campaign", data, "--out", "hem.jpg"],
            "hem.jpg: the ending says what is written; use .svg, .png or .pdf",
        ),
        (vec!["skirt", profile], "the cut of run run_07 is not known"),
        (vec!["hem", "--campaign", "nowhere"], "there is no such file"),
    ] {
        let (code, out, error) = hemline(folder.path(), &[vec!["plot"], arguments.clone()].concat());
        assert_eq!((code, out.as_str()), (2, ""), "{arguments:?}");
        let told = error.lines().last().unwrap();
        assert!(told.starts_with("hemline: ") && told.contains(said), "{arguments:?}: {error}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "something was written");
}
