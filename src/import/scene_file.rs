//! `scene.toml`: skirt, cloth, body and theory of one prediction, checked key by key. `campaign.toml` has the same tables.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::campaign_file::{Reader, syntax, unknown};
use super::source;
use crate::error::{Error, Place};
use crate::experiment::scene::{Body, BodyShape, Choice, ClothDetail, Scene, Term, TermSet, Theory, WaistEdge};
use crate::experiment::{Apparatus, Fabric, Skirt};
use crate::units::{self, KilogramPerSquareMetre, Metre, NewtonMetre};

/// A table of numbers and words.
pub(super) type Table = BTreeMap<String, Spanned<Entry>>;

#[derive(Debug, Deserialize, Clone)]
#[serde(untagged, expecting = "this is neither a number nor a word")]
pub(super) enum Entry {
    Number(f64),
    Word(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    title: Option<String>,
    skirt: Table,
    cloth: Table,
    body: Option<Table>,
    #[serde(default)]
    theory: TheoryTable,
}

/// `[theory]`.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct TheoryTable {
    terms: Option<Spanned<TermsGiven>>,
    fidelity: Option<Spanned<String>>,
    tolerance_mm: Option<Spanned<f64>>,
    folds: Option<Spanned<Entry>>,
    gravity_m_s2: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "terms is \"auto\" or a list such as [\"gravity\", \"bending\"]")]
enum TermsGiven {
    Word(String),
    List(Vec<String>),
}

/// `[theory]`, checked.
pub(super) struct Asked {
    pub choice: Choice,
    pub theory: Theory,
    pub tolerance: Option<Metre>,
    /// With its place.
    pub folds: Option<(Place, Option<u32>)>,
    gravity: f64,
}

/// Keys of `[cloth]` that say more than weight and rigidity.
pub(super) const DETAIL: [&str; 9] = [
    "shear_stiffness_n_m",
    "ring_stiffness_n_m",
    "generatrix_stiffness_n_m",
    "thickness_mm",
    "thickness_um",
    "thickness_m",
    "foundation_modulus_n_m3",
    "warp_rigidity_un_m",
    "weft_rigidity_un_m",
];

const LENGTHS: [&str; 4] = ["cm", "mm", "m", "in"];

/// Reads and checks a scene file.
///
/// # Errors
/// [`Error::File`] if it cannot be read; [`Error::Input`] with the row for a key that is unknown, missing, doubled or out of range, and what would be right.
pub fn read(path: &Path) -> Result<Scene, Error> {
    let (bytes, _) = source::read(path)?;
    let text = String::from_utf8(bytes).map_err(|_| Error::input(Place::file(path), "this is not UTF-8 text", "save it as UTF-8"))?;
    let document: Document = toml::from_str(&text).map_err(|e| match syntax(path, &text, &e) {
        Error::Input { place, problem, remedy } if remedy.contains("hemline init") => {
            Error::Input { place, problem, remedy: "docs/terms.md shows a whole scene with every key".into() }
        }
        other => other,
    })?;
    let reader = Reader { path, text: &text };
    let Cut { apparatus, skirt, waist_edge, seams } = cut(&reader, document.skirt)?;
    let mut cloth = Numbers::new(&reader, "cloth", document.cloth);
    let detail = cloth_detail(&mut cloth)?;
    let density = cloth.positive("areal_density", &["g_m2", "kg_m2"])?;
    let rigidity = cloth.positive("flexural_rigidity", &["un_m", "n_m"])?;
    cloth.finish()?;
    let need = |what: &str| {
        let remedy = format!("add {what} = …: without it no hem can be predicted");
        Error::input(Place::file(path), format!("[cloth] has no {what}"), remedy)
    };
    // Directions that are alike are as good as one number.
    let rigidity = rigidity.or(detail.warp_and_weft.map(|(warp, weft)| (warp * weft).sqrt()));
    let fabric = Fabric {
        areal_density: Some(KilogramPerSquareMetre(density.ok_or_else(|| need("areal_density_g_m2"))?)),
        flexural_rigidity: Some(NewtonMetre(rigidity.ok_or_else(|| need("flexural_rigidity_un_m"))?)),
    };
    let body = document.body.map(|table| body(&reader, table)).transpose()?;
    let asked = theory(&reader, document.theory)?;
    Ok(Scene {
        title: document.title,
        apparatus,
        skirt,
        waist_edge,
        seams,
        fabric,
        detail,
        body,
        choice: asked.choice,
        theory: asked.theory,
        folds: asked.folds.and_then(|(_, folds)| folds),
        tolerance: asked.tolerance,
        gravity: asked.gravity,
    })
}

/// Terms by their names; `auto` for those that the scene calls for.
///
/// # Errors
/// What is wrong, and what would be right.
pub fn choice(names: &[&str]) -> Result<Choice, String> {
    if names == ["auto"] {
        return Ok(Choice::Auto);
    }
    let known = || Term::ALL.map(|term| format!("“{}”", term.name())).join(", ");
    if names.is_empty() {
        return Err(format!("there are no terms; known are {}, or “auto” alone", known()));
    }
    let mut set = TermSet::none();
    for name in names {
        let term = Term::named(name).ok_or_else(|| format!("unknown term “{name}”; known are {}, or “auto” alone", known()))?;
        if set.contains(term) {
            return Err(format!("the term “{name}” is there twice; keep one"));
        }
        set = set.with(term);
    }
    Ok(Choice::Exactly(set))
}

struct Cut {
    apparatus: Apparatus,
    skirt: Skirt,
    waist_edge: WaistEdge,
    seams: u32,
}

fn cut(reader: &Reader<'_>, table: Table) -> Result<Cut, Error> {
    let mut given = Numbers::new(reader, "skirt", table);
    let apparatus = given.word("apparatus", &[("skirt", Apparatus::Skirt), ("drapemeter", Apparatus::Drapemeter)])?;
    let edge = given.word("waist_edge", &[("hinged", WaistEdge::Hinged), ("clamped", WaistEdge::Clamped)])?;
    let seams = given.number("seams", &[""], "a whole number, 0 or more", |n| 0.0 <= n && n.fract() == 0.0 && n <= 1000.0)?;
    let apparatus = apparatus.unwrap_or(Apparatus::Skirt);
    let skirt = if apparatus == Apparatus::Drapemeter {
        let [support, specimen] = [given.positive("support_radius", &LENGTHS)?, given.positive("specimen_radius", &LENGTHS)?];
        let support = support.ok_or_else(|| given.lacks("support_radius_cm"))?;
        Skirt::drapemeter(Metre(support), Metre(specimen.ok_or_else(|| given.lacks("specimen_radius_cm"))?))
    } else {
        let waist = given.radius("waist")?.ok_or_else(|| given.lacks("waist_radius_cm or waist_girth_cm"))?;
        let hem = given.radius("hem")?;
        let hip = given.radius("hip")?;
        let depth = given.positive("waist_to_hip", &LENGTHS)?;
        let slant = Metre(given.positive("slant_length", &LENGTHS)?.ok_or_else(|| given.lacks("slant_length_cm"))?);
        match (hem, hip, depth) {
            (Some(hem), None, None) => Skirt::new(Metre(waist), Metre(hem), slant),
            (None, Some(hip), Some(depth)) => Skirt::from_body(Metre(TAU * waist), Metre(TAU * hip), Metre(depth), slant),
            (Some(_), ..) => {
                let problem = "[skirt] gives the hem and the hips it should follow from";
                return Err(Error::input(given.place.clone(), problem, "keep hem_radius_cm, or hip_girth_cm with waist_to_hip_cm"));
            }
            _ => return Err(given.lacks("hem_radius_cm or hem_girth_cm, nor both hip_girth_cm and waist_to_hip_cm")),
        }
    };
    let place = given.place.clone();
    given.finish()?;
    let skirt = skirt.map_err(|error| Error::input(place, format!("[skirt] is no cone: {error}"), "correct that number"))?;
    Ok(Cut { apparatus, skirt, waist_edge: edge.unwrap_or_default(), seams: seams.unwrap_or(0.0) as u32 })
}

/// What `[cloth]` says beyond weight and rigidity.
pub(super) fn cloth_detail(given: &mut Numbers<'_>) -> Result<ClothDetail, Error> {
    let not_negative = "0 or more";
    let [warp, weft] = [given.positive("warp_rigidity", &["un_m"])?, given.positive("weft_rigidity", &["un_m"])?];
    if warp.is_some() != weft.is_some() {
        return Err(Error::input(
            given.place.clone(),
            "one of warp_rigidity_un_m and weft_rigidity_un_m is missing",
            "give both, or flexural_rigidity_un_m",
        ));
    }
    Ok(ClothDetail {
        shear_stiffness: given.number("shear_stiffness", &["n_m"], not_negative, |s| 0.0 <= s)?,
        ring_stiffness: given.positive("ring_stiffness", &["n_m"])?,
        generatrix_stiffness: given.positive("generatrix_stiffness", &["n_m"])?,
        thickness: given.positive("thickness", &["mm", "um", "m"])?.map(Metre),
        foundation_modulus: given.number("foundation_modulus", &["n_m3"], not_negative, |e| 0.0 <= e)?,
        warp_and_weft: warp.zip(weft),
    })
}

/// `[body]`.
pub(super) fn body(reader: &Reader<'_>, table: Table) -> Result<Body, Error> {
    let mut given = Numbers::new(reader, "body", table);
    let shapes = BodyShape::ALL.map(|shape| (shape.name(), shape));
    let shape = given.word("shape", &shapes)?.ok_or_else(|| given.lacks("shape (\"cone\", \"cylinder\" or \"ellipsoid\")"))?;
    let hip_radius = Metre(given.radius("hip")?.ok_or_else(|| given.lacks("hip_girth_cm or hip_radius_cm"))?);
    let waist_radius = given.radius("waist")?.map(Metre);
    let hip_depth = given.positive("waist_to_hip", &LENGTHS)?.map(Metre);
    if shape != BodyShape::Cylinder && hip_depth.is_none() {
        return Err(given.lacks("waist_to_hip_cm, which all shapes but the cylinder need"));
    }
    given.finish()?;
    Ok(Body { shape, waist_radius, hip_radius, hip_depth })
}

/// `[theory]`.
pub(super) fn theory(reader: &Reader<'_>, table: TheoryTable) -> Result<Asked, Error> {
    let choice = match &table.terms {
        None => Choice::Exactly(TermSet::usual()),
        Some(given) => {
            let names: Vec<&str> = match given.get_ref() {
                TermsGiven::Word(word) => vec![word],
                TermsGiven::List(list) => list.iter().map(String::as_str).collect(),
            };
            choice(&names).map_err(|why| {
                let (problem, remedy) = why.split_once("; ").unwrap_or((&why, ""));
                Error::input(reader.place(&given.span()), format!("“terms”: {problem}"), remedy)
            })?
        }
    };
    let theories = [("ruled", Theory::Ruled), ("graded", Theory::Graded), ("ansatz", Theory::Ansatz), ("polar", Theory::Polar)];
    let theory = match &table.fidelity {
        None => Theory::Ruled,
        Some(given) => {
            let found = theories.iter().find(|(name, _)| name == given.get_ref());
            let known = theories.map(|(name, _)| name);
            let problem = format!("“fidelity” is “{}”", given.get_ref());
            found.ok_or_else(|| unknown(reader.place(&given.span()), &problem, given.get_ref(), &known))?.1
        }
    };
    let folds = match &table.folds {
        None => None,
        Some(given) => {
            let place = reader.place(&given.span());
            match given.get_ref() {
                Entry::Word(word) if word == "auto" => Some((place, None)),
                Entry::Number(m) if 2.0 <= *m && *m <= 512.0 && m.fract() == 0.0 => Some((place, Some(*m as u32))),
                Entry::Word(word) => {
                    return Err(Error::input(place, format!("“folds” is “{word}”"), "it is \"auto\" or a whole number from 2 to 512"));
                }
                Entry::Number(m) => {
                    return Err(Error::input(place, format!("“folds” is {m}"), "it is \"auto\" or a whole number from 2 to 512"));
                }
            }
        }
    };
    let tolerance =
        table.tolerance_mm.is_some().then_some(reader.number(&table.tolerance_mm, 1.0, "tolerance_mm", "positive", |t| 0.0 < t)?);
    Ok(Asked {
        choice,
        theory,
        tolerance: tolerance.map(|t| Metre(t * units::MILLIMETRE)),
        folds,
        gravity: reader.number(&table.gravity_m_s2, units::STANDARD_GRAVITY, "gravity_m_s2", "positive", |g| 0.0 < g)?,
    })
}

/// A table from which entries are taken one by one; what is left over is unknown.
pub(super) struct Numbers<'a> {
    reader: &'a Reader<'a>,
    section: &'static str,
    given: Table,
    known: Vec<String>,
    /// Of the table.
    pub place: Place,
}

impl<'a> Numbers<'a> {
    pub fn new(reader: &'a Reader<'a>, section: &'static str, given: Table) -> Self {
        let header = format!("[{section}]");
        let place = Place::file(reader.path);
        let row = reader.text.lines().position(|line| line.trim_start().starts_with(&header));
        let place = match row {
            Some(row) => place.row(row + 1),
            None => place,
        };
        Numbers { reader, section, given, known: Vec::new(), place }
    }

    /// `name_suffix = number`, in SI; at most one of the suffixes.
    pub fn number(&mut self, name: &str, suffixes: &[&str], allowed: &str, good: impl Fn(f64) -> bool) -> Result<Option<f64>, Error> {
        let mut found: Option<(String, f64)> = None;
        for suffix in suffixes {
            let key = if suffix.is_empty() { name.to_owned() } else { format!("{name}_{suffix}") };
            self.known.push(key.clone());
            let Some(entry) = self.given.remove(&key) else { continue };
            let place = self.reader.place(&entry.span());
            let value = match entry.get_ref() {
                Entry::Number(value) if value.is_finite() && good(*value) => value * units::factor(suffix).unwrap_or(1.0),
                Entry::Number(value) => return Err(Error::input(place, format!("“{key}” is {value}"), format!("it must be {allowed}"))),
                Entry::Word(word) => {
                    return Err(Error::input(place, format!("“{key}” is “{word}”"), format!("it must be a number, {allowed}")));
                }
            };
            if let Some((first, _)) = &found {
                return Err(Error::input(place, format!("“{key}” says again what “{first}” says"), "keep one of them"));
            }
            found = Some((key, value));
        }
        Ok(found.map(|(_, value)| value))
    }

    pub fn positive(&mut self, name: &str, suffixes: &[&str]) -> Result<Option<f64>, Error> {
        self.number(name, suffixes, "positive", |x| 0.0 < x)
    }

    /// A radius, or the girth that it follows from, m.
    fn radius(&mut self, of: &str) -> Result<Option<f64>, Error> {
        let radius = self.positive(&format!("{of}_radius"), &LENGTHS)?;
        let girth = self.positive(&format!("{of}_girth"), &LENGTHS)?;
        match (radius, girth) {
            (Some(_), Some(_)) => {
                Err(Error::input(self.place.clone(), format!("[{}] gives radius and girth of the {of}", self.section), "keep one of them"))
            }
            (radius, girth) => Ok(radius.or(girth.map(|girth| girth / TAU))),
        }
    }

    fn word<T: Copy>(&mut self, key: &str, meanings: &[(&str, T)]) -> Result<Option<T>, Error> {
        self.known.push(key.to_owned());
        let Some(entry) = self.given.remove(key) else { return Ok(None) };
        let place = self.reader.place(&entry.span());
        let names: Vec<&str> = meanings.iter().map(|(name, _)| *name).collect();
        match entry.get_ref() {
            Entry::Word(word) => match meanings.iter().find(|(name, _)| name == word) {
                Some((_, meaning)) => Ok(Some(*meaning)),
                None => Err(unknown(place, &format!("“{key}” is “{word}”"), word, &names)),
            },
            Entry::Number(value) => Err(Error::input(place, format!("“{key}” is {value}"), format!("it is one of {}", names.join(", ")))),
        }
    }

    fn lacks(&self, what: &str) -> Error {
        Error::input(self.place.clone(), format!("[{}] has no {what}", self.section), "add it; docs/terms.md shows a whole scene")
    }

    /// # Errors
    /// If a key is left over.
    pub fn finish(self) -> Result<(), Error> {
        match self.given.iter().next() {
            None => Ok(()),
            Some((key, entry)) => {
                let known: Vec<&str> = self.known.iter().map(String::as_str).collect();
                Err(unknown(self.reader.place(&entry.span()), &format!("unknown key “{key}” in [{}]", self.section), key, &known))
            }
        }
    }
}
