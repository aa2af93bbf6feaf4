//! `campaign.toml`: what a laboratory says about its campaign, checked key by key.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use super::cells::one_line;
use super::check_table::CheckTable;
use super::column::length_unit;
use super::dialect_table::{DialectTable, Told};
use super::source;
use super::wishes::{WishEntry, wishes};
use crate::error::{Error, Place};
use crate::experiment::Source;
use crate::experiment::campaign::{
    CameraHeight, Folds, HemLength, Language, Meshes, PictureScale, Pictures, RESPONSES, Shade, Tone, USUAL_RESPONSES, Wish,
};
use crate::experiment::{Apparatus, CheckRules, Factor};
use crate::units::{self, Metre};

/// A quantity of the campaign: one number for all runs, or a column of the design table. SI.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Quantity {
    Number(f64),
    Column { name: String, si_factor: f64 },
}

/// How a factor's column is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Levels {
    /// −1 and +1.
    #[default]
    Coded,
    /// The natural levels `low` and `high`.
    Natural,
}

/// `campaign.toml`, checked.
#[derive(Debug, Clone)]
pub(super) struct CampaignFile {
    pub source: Source,
    pub title: String,
    pub origin: String,
    pub apparatus: Apparatus,
    /// Waist, hem and slant of a skirt; support and specimen radius of a drape tester.
    pub geometry: Vec<Quantity>,
    pub areal_density: Option<Quantity>,
    pub flexural_rigidity: Option<Quantity>,
    pub factors: Vec<(Factor, Levels)>,
    /// The column of blocks.
    pub block: Option<String>,
    pub responses: Vec<String>,
    pub wishes: Vec<Wish>,
    pub alpha: f64,
    pub folds: Folds,
    pub hem_length: HemLength,
    pub bias_correction: bool,
    pub gravity: f64,
    pub foundation_modulus: f64,
    pub pictures: Option<Pictures>,
    /// What `hemline import` wrote, below the folder: profiles named like their runs.
    pub store: Option<PathBuf>,
    pub tables: Told,
    pub meshes: Meshes,
    pub check: CheckRules,
    pub language: Language,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    title: Spanned<String>,
    origin: Spanned<String>,
    apparatus: Apparatus,
    #[serde(default)]
    geometry: BTreeMap<String, Spanned<Given>>,
    #[serde(default)]
    cloth: BTreeMap<String, Spanned<Given>>,
    factors: Vec<Spanned<FactorEntry>>,
    #[serde(default)]
    analysis: Analysis,
    #[serde(default)]
    profiles: Profiles,
    #[serde(default)]
    tables: DialectTable,
    #[serde(default)]
    wishes: Vec<Spanned<WishEntry>>,
    #[serde(default)]
    check: CheckTable,
    #[serde(default)]
    language: Language,
}

#[derive(Deserialize, Clone)]
#[serde(untagged, expecting = "this is neither a number nor { column = \"…\" }")]
enum Given {
    Number(f64),
    Column(ColumnName),
}

#[derive(Deserialize, Clone)]
#[serde(deny_unknown_fields)]
struct ColumnName {
    column: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FactorEntry {
    name: String,
    label: Option<String>,
    unit: Option<String>,
    low: f64,
    high: f64,
    #[serde(default)]
    levels: Levels,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct Analysis {
    block: Option<String>,
    responses: Option<Spanned<Vec<String>>>,
    alpha: Option<Spanned<f64>>,
    folds: Option<Spanned<FoldsGiven>>,
    hem_length: Option<Spanned<HemLengthGiven>>,
    hem_length_cm: Option<Spanned<f64>>,
    hem_length_mm: Option<Spanned<f64>>,
    hem_length_m: Option<Spanned<f64>>,
    bias_correction: Option<OnOff>,
    gravity_m_s2: Option<Spanned<f64>>,
    foundation_modulus_n_m3: Option<Spanned<f64>>,
}

#[derive(Deserialize, Clone)]
#[serde(untagged, expecting = "folds is \"auto\", a number, or { from = 2, to = 24 }")]
enum FoldsGiven {
    Word(Auto),
    Exactly(u32),
    Among(FoldRange),
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum Auto {
    Auto,
}

#[derive(Deserialize, Clone)]
#[serde(deny_unknown_fields)]
struct FoldRange {
    from: u32,
    to: u32,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum HemLengthGiven {
    Auto,
    Free,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum OnOff {
    On,
    Off,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct Profiles {
    scale_mm_per_px: Option<Spanned<f64>>,
    disc_mm: Option<Spanned<f64>>,
    bar_mm: Option<Spanned<f64>>,
    checkerboard_mm: Option<Spanned<f64>>,
    camera_height_mm: Option<Spanned<f64>>,
    hem_height_mm: Option<Spanned<f64>>,
    #[serde(default)]
    object: Shade,
    file: Option<Spanned<String>>,
    #[serde(default)]
    tone: Tone,
    mesh_axis: Option<Spanned<String>>,
    mesh_unit: Option<Spanned<String>>,
}

/// Reads and checks `campaign.toml`.
///
/// # Errors
/// [`Error::File`] if it cannot be read; [`Error::Input`] with the row for a key that is unknown, missing, or has a value out of range.
pub(super) fn read(path: &Path) -> Result<CampaignFile, Error> {
    let (bytes, source) = source::read(path)?;
    let text = String::from_utf8(bytes).map_err(|_| Error::input(Place::file(path), "this is not UTF-8 text", "save it as UTF-8"))?;
    let document: Document = toml::from_str(&text).map_err(|e| syntax(path, &text, &e))?;
    Reader { path, text: &text }.check(document, source)
}

/// What an import needs of `campaign.toml`; the rest may still have to be filled in.
pub(super) struct ForImport {
    pub factors: Vec<String>,
    pub store: Option<PathBuf>,
    pub tables: Told,
    pub pictures: Option<Pictures>,
    pub meshes: Meshes,
}

#[derive(Deserialize)]
struct DocumentForImport {
    #[serde(default)]
    factors: Vec<FactorName>,
    #[serde(default)]
    profiles: Profiles,
    #[serde(default)]
    tables: DialectTable,
}

#[derive(Deserialize)]
struct FactorName {
    name: String,
}

/// Reads what an import needs.
///
/// # Errors
/// As [`read`], for these parts only.
pub(super) fn for_import(path: &Path) -> Result<ForImport, Error> {
    let (bytes, _) = source::read(path)?;
    let text = String::from_utf8(bytes).map_err(|_| Error::input(Place::file(path), "this is not UTF-8 text", "save it as UTF-8"))?;
    let document: DocumentForImport = toml::from_str(&text).map_err(|e| syntax(path, &text, &e))?;
    let reader = Reader { path, text: &text };
    Ok(ForImport {
        factors: document.factors.into_iter().map(|factor| factor.name).collect(),
        store: reader.store(&document.profiles.file)?,
        pictures: reader.pictures(&document.profiles)?,
        meshes: reader.meshes(&document.profiles)?,
        tables: document.tables.told(&reader)?,
    })
}

/// A fault that the TOML reader found, with its row, and for an unknown key the nearest known one.
fn syntax(path: &Path, text: &str, error: &toml::de::Error) -> Error {
    let mut place = Place::file(path);
    if let Some(span) = error.span() {
        place = place.row(row_of(text, &span));
    }
    let message = one_line(error.message());
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    if message.starts_with("unknown field") && 1 < quoted.len() {
        return unknown(place, &format!("unknown key “{}”", quoted[0]), quoted[0], &quoted[1..]);
    }
    if let (true, [key]) = (message.starts_with("missing field"), &quoted[..]) {
        return Error::input(place, format!("the key “{key}” is missing"), "write it; `hemline init` shows every key with an example");
    }
    Error::input(place, message, "`hemline init` shows every key with an example")
}

fn row_of(text: &str, span: &Range<usize>) -> usize {
    text.as_bytes().iter().take(span.start).filter(|&&b| b == b'\n').count() + 1
}

/// An error that names what could have been meant.
pub(super) fn unknown(place: Place, problem: &str, name: &str, known: &[&str]) -> Error {
    let nearest =
        known.iter().min_by_key(|k| letters_apart(name, k)).filter(|k| letters_apart(name, k) <= name.chars().count().max(3) / 2 + 1);
    let all = known.iter().map(|k| format!("“{k}”")).collect::<Vec<_>>().join(", ");
    let remedy = match nearest {
        Some(nearest) => format!("did you mean “{nearest}”? Known are {all}"),
        None => format!("known are {all}"),
    };
    Error::input(place, problem, remedy)
}

/// Levenshtein's distance.
fn letters_apart(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.to_lowercase().chars().collect(), b.to_lowercase().chars().collect());
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// What a significance level may be.
pub(super) const LEVEL: &str = "between 0 and 1, both excluded";

pub(super) struct Reader<'a> {
    pub(super) path: &'a Path,
    text: &'a str,
}

impl Reader<'_> {
    pub(super) fn place(&self, span: &Range<usize>) -> Place {
        Place::file(self.path).row(row_of(self.text, span))
    }

    fn check(&self, document: Document, source: Source) -> Result<CampaignFile, Error> {
        let Document { title, origin, apparatus, geometry, cloth, factors, analysis, profiles, tables, wishes: wanted, check, language } =
            document;
        for (key, value, what) in
            [("title", &title, "what the campaign is about"), ("origin", &origin, "who measured what, where and when")]
        {
            if value.get_ref().trim().is_empty() {
                return Err(Error::input(self.place(&value.span()), format!("“{key}” is empty"), format!("write {what}")));
            }
        }
        let names: &[&str] = match apparatus {
            Apparatus::Skirt => &["waist_radius", "hem_radius", "slant_length"],
            Apparatus::Drapemeter => &["support_radius", "specimen_radius"],
        };
        let mut lengths = self.quantities("geometry", geometry, names, &["cm", "mm", "m", "in"])?;
        let mut found = Vec::new();
        for name in names {
            let missing = || {
                let place = Place::file(self.path);
                Error::input(
                    place,
                    format!("[geometry] has no {name}"),
                    format!("add {name}_cm = … (or _mm, _m, _in), or {name}_cm = {{ column = \"…\" }}"),
                )
            };
            found.push(lengths.remove(*name).ok_or_else(missing)?);
        }
        let mut cloth = self.quantities("cloth", cloth, &["areal_density", "flexural_rigidity"], &["g_m2", "kg_m2", "un_m", "n_m"])?;
        let (hem_length, folds) = (self.hem_length(&analysis)?, self.folds(&analysis)?);
        let alpha = self.number(&analysis.alpha, 0.05, "alpha", LEVEL, |a| 0.0 < a && a < 1.0)?;
        let responses = self.responses(&analysis.responses)?;
        Ok(CampaignFile {
            source,
            title: title.into_inner(),
            origin: origin.into_inner(),
            apparatus,
            geometry: found,
            areal_density: cloth.remove("areal_density"),
            flexural_rigidity: cloth.remove("flexural_rigidity"),
            factors: self.factors(factors)?,
            block: analysis.block,
            check: check.rules(self, alpha, &responses)?,
            wishes: wishes(self, wanted, &responses)?,
            responses,
            alpha,
            folds,
            hem_length,
            bias_correction: !matches!(analysis.bias_correction, Some(OnOff::Off)),
            gravity: self.number(&analysis.gravity_m_s2, units::STANDARD_GRAVITY, "gravity_m_s2", "positive", |g| 0.0 < g)?,
            foundation_modulus: self
                .number(&analysis.foundation_modulus_n_m3, 0.0, "foundation_modulus_n_m3", "0 or more", |e| 0.0 <= e)?,
            store: self.store(&profiles.file)?,
            tables: tables.told(self)?,
            pictures: self.pictures(&profiles)?,
            meshes: self.meshes(&profiles)?,
            language,
        })
    }

    /// What `[profiles]` says about pictures; `None` where it gives no scale.
    fn pictures(&self, profiles: &Profiles) -> Result<Option<Pictures>, Error> {
        type Scale = fn(Metre) -> PictureScale;
        let scales: [(&str, &Option<Spanned<f64>>, Scale); 4] = [
            ("scale_mm_per_px", &profiles.scale_mm_per_px, PictureScale::Pixel),
            ("disc_mm", &profiles.disc_mm, PictureScale::Disc),
            ("bar_mm", &profiles.bar_mm, PictureScale::Bar),
            ("checkerboard_mm", &profiles.checkerboard_mm, PictureScale::Checkerboard),
        ];
        let mut given = None;
        for (key, value, scale) in scales {
            let Some(spanned) = value else { continue };
            let length = Metre(self.number(value, 0.0, key, "positive", |s| 0.0 < s)? * units::MILLIMETRE);
            if let Some((first, _)) = given.replace((key, scale(length))) {
                let problem = format!("pictures have two scales, “{first}” and “{key}”");
                return Err(Error::input(self.place(&spanned.span()), problem, "keep one of them"));
            }
        }
        let height = match (&profiles.camera_height_mm, &profiles.hem_height_mm) {
            (None, None) => None,
            (Some(camera), Some(_)) => {
                let above = self.number(&profiles.camera_height_mm, 0.0, "camera_height_mm", "positive", |h| 0.0 < h)?;
                let hem = self.number(&profiles.hem_height_mm, 0.0, "hem_height_mm", "less than camera_height_mm", |h| h < above)?;
                if given.is_none() {
                    let problem = "camera_height_mm corrects a scale, and there is none";
                    return Err(Error::input(
                        self.place(&camera.span()),
                        problem,
                        "add scale_mm_per_px, disc_mm, bar_mm or checkerboard_mm",
                    ));
                }
                Some(CameraHeight { camera: Metre(above * units::MILLIMETRE), hem: Metre(hem * units::MILLIMETRE) })
            }
            (Some(one), None) | (None, Some(one)) => {
                let problem = "one of camera_height_mm and hem_height_mm is missing";
                return Err(Error::input(self.place(&one.span()), problem, "give both, from the plane of the scale upwards"));
            }
        };
        Ok(given.map(|(_, scale)| Pictures { scale, object: profiles.object, tone: profiles.tone, height }))
    }

    fn meshes(&self, profiles: &Profiles) -> Result<Meshes, Error> {
        let refuse = |given: &Spanned<String>, key: &str, remedy: &str| {
            Error::input(self.place(&given.span()), format!("“{key}” is “{}”", given.get_ref()), remedy)
        };
        let axis = profiles.mesh_axis.as_ref().map(|given| {
            super::mesh::direction_named(given.get_ref())
                .ok_or_else(|| refuse(given, "mesh_axis", "use x, -x, y, -y, z, -z, or a vector such as \"0,0.1,1\""))
        });
        let unit = profiles.mesh_unit.as_ref().map(|given| {
            length_unit(given.get_ref()).map(Metre).ok_or_else(|| refuse(given, "mesh_unit", "use \"mm\", \"cm\", \"m\", \"um\" or \"in\""))
        });
        Ok(Meshes { axis: axis.transpose()?, unit: unit.transpose()? })
    }

    /// A number that the file gives, or `default`.
    pub(super) fn number(
        &self,
        given: &Option<Spanned<f64>>,
        default: f64,
        key: &str,
        allowed: &str,
        good: impl Fn(f64) -> bool,
    ) -> Result<f64, Error> {
        match given {
            None => Ok(default),
            Some(value) if value.get_ref().is_finite() && good(*value.get_ref()) => Ok(*value.get_ref()),
            Some(value) => {
                let problem = format!("“{key}” is {}", value.get_ref());
                Err(Error::input(self.place(&value.span()), problem, format!("it must be {allowed}")))
            }
        }
    }

    /// The file of all profiles, below the campaign's folder.
    fn store(&self, given: &Option<Spanned<String>>) -> Result<Option<PathBuf>, Error> {
        let Some(given) = given else { return Ok(None) };
        let path = PathBuf::from(given.get_ref().replace('\\', "/"));
        let inside = path.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if !inside || path.as_os_str().is_empty() {
            let problem = format!("“file” is “{}”, which is no file below the campaign's folder", given.get_ref());
            return Err(Error::input(self.place(&given.span()), problem, "`hemline import` writes profiles.parquet there"));
        }
        Ok(Some(path))
    }

    /// A section of `name_unit = number` or `name_unit = { column = … }`.
    fn quantities(
        &self,
        section: &str,
        given: BTreeMap<String, Spanned<Given>>,
        names: &[&str],
        suffixes: &[&str],
    ) -> Result<BTreeMap<String, Quantity>, Error> {
        let mut found = BTreeMap::new();
        for (key, value) in given {
            let place = self.place(&value.span());
            let split = names.iter().find_map(|name| Some((*name, key.strip_prefix(name)?.strip_prefix('_')?)));
            let fits =
                |suffix: &str| suffixes.contains(&suffix) && (section != "cloth" || key.starts_with("areal") == suffix.ends_with("m2"));
            let Some((name, si_factor)) = split.and_then(|(name, suffix)| Some((name, units::factor(suffix).filter(|_| fits(suffix))?)))
            else {
                let known: Vec<String> = names.iter().flat_map(|n| suffixes.iter().map(move |s| format!("{n}_{s}"))).collect();
                let sensible = |k: &&String| section != "cloth" || k.starts_with("areal") == k.ends_with("m2");
                let known: Vec<&str> = known.iter().filter(sensible).map(String::as_str).collect();
                return Err(unknown(place, &format!("unknown key “{key}” in [{section}]"), &key, &known));
            };
            let quantity = match value.get_ref() {
                Given::Number(number) if number.is_finite() && 0.0 < *number => Quantity::Number(number * si_factor),
                Given::Number(number) => return Err(Error::input(place, format!("“{key}” is {number}"), "it must be a positive number")),
                Given::Column(ColumnName { column }) => {
                    // `hem_radius_cm = { column = "hem_radius_mm" }` is a slip of a factor ten.
                    let stated =
                        column.rsplit(['_', ' ', '[', '(', ',']).next().map(|u| u.trim_end_matches([']', ')'])).and_then(length_unit);
                    if section == "geometry" && stated.is_some_and(|stated| stated != si_factor) {
                        let problem = format!("mixed units: “{key}” names column “{column}”");
                        return Err(Error::input(place, problem, "let the key end in the unit of its column"));
                    }
                    Quantity::Column { name: column.clone(), si_factor }
                }
            };
            if found.insert(name.to_owned(), quantity).is_some() {
                return Err(Error::input(place, format!("{name} is given twice in [{section}]"), "keep one of them"));
            }
        }
        Ok(found)
    }

    fn factors(&self, given: Vec<Spanned<FactorEntry>>) -> Result<Vec<(Factor, Levels)>, Error> {
        let mut factors: Vec<(Factor, Levels)> = Vec::new();
        if given.is_empty() {
            return Err(Error::input(Place::file(self.path), "there are no factors", "add at least one [[factors]] section"));
        }
        for entry in given {
            let place = self.place(&entry.span());
            let FactorEntry { name, label, unit, low, high, levels } = entry.into_inner();
            // A colon joins the factors of an interaction in every table of results.
            if name.trim().is_empty() || name.contains(':') || name == "1" {
                return Err(Error::input(
                    place,
                    format!("“{name}” is no name for a factor"),
                    "give it the name of its column, without a colon",
                ));
            }
            if factors.iter().any(|(other, _)| other.name == name) {
                return Err(Error::input(place, format!("factor “{name}” is there twice"), "keep one of them"));
            }
            if !(low.is_finite() && high.is_finite() && low < high) {
                let problem = format!("factor “{name}” has low = {low} and high = {high}");
                return Err(Error::input(place, problem, "low must be less than high; both natural levels"));
            }
            let label = label.filter(|l| !l.trim().is_empty()).unwrap_or_else(|| name.clone());
            factors.push((Factor { name, label, unit, low, high }, levels));
        }
        Ok(factors)
    }

    fn responses(&self, given: &Option<Spanned<Vec<String>>>) -> Result<Vec<String>, Error> {
        let known = RESPONSES.map(|r| r.name);
        let Some(given) = given else { return Ok(USUAL_RESPONSES.map(String::from).to_vec()) };
        for name in given.get_ref() {
            if !RESPONSES.iter().any(|r| r.name == name || r.column == name) {
                return Err(unknown(self.place(&given.span()), &format!("unknown response “{name}”"), name, &known));
            }
        }
        let mut responses: Vec<String> = Vec::new();
        given.get_ref().iter().for_each(|name| {
            if !responses.contains(name) {
                responses.push(name.clone());
            }
        });
        Ok(responses)
    }

    fn folds(&self, analysis: &Analysis) -> Result<Folds, Error> {
        let Some(given) = &analysis.folds else { return Ok(Folds::default()) };
        let refuse = |problem: String| Err(Error::input(self.place(&given.span()), problem, "a hem has 2 to 60 folds"));
        match given.get_ref() {
            FoldsGiven::Word(Auto::Auto) => Ok(Folds::default()),
            FoldsGiven::Exactly(m) if (2..=60).contains(m) => Ok(Folds::Exactly(*m)),
            FoldsGiven::Exactly(m) => refuse(format!("folds is {m}")),
            FoldsGiven::Among(FoldRange { from, to }) if 2 <= *from && from <= to && *to <= 60 => Ok(Folds::Among { from: *from, to: *to }),
            FoldsGiven::Among(FoldRange { from, to }) => refuse(format!("folds runs from {from} to {to}")),
        }
    }

    fn hem_length(&self, analysis: &Analysis) -> Result<HemLength, Error> {
        let held: Vec<(&Spanned<f64>, f64)> =
            [(&analysis.hem_length_cm, units::CENTIMETRE), (&analysis.hem_length_mm, units::MILLIMETRE), (&analysis.hem_length_m, 1.0)]
                .into_iter()
                .filter_map(|(given, unit)| Some((given.as_ref()?, unit)))
                .collect();
        match (&analysis.hem_length, &held[..]) {
            (None, []) => Ok(HemLength::Auto),
            (Some(word), []) => Ok(match word.get_ref() {
                HemLengthGiven::Auto => HemLength::Auto,
                HemLengthGiven::Free => HemLength::Free,
            }),
            (None, [(value, unit)]) if value.get_ref().is_finite() && 0.0 < *value.get_ref() => Ok(HemLength::Held(value.get_ref() * unit)),
            (None, [(value, _)]) => {
                Err(Error::input(self.place(&value.span()), format!("the hem length is {}", value.get_ref()), "it must be positive"))
            }
            (_, [.., (value, _)]) => Err(Error::input(
                self.place(&value.span()),
                "the hem length is given twice",
                "keep hem_length = \"auto\" or \"free\", or one hem_length_cm",
            )),
        }
    }
}
