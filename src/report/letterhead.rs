//! A laboratory's own head of the report: logo, name, address, accreditation, colours, and a template of its own if it wants one.
//!
//! docs/report.md describes the file; `docs/letterhead/` is an example.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::raster;
use crate::error::{Error, Place};

/// The name of the file in a folder given as template.
const FILE: &str = "template.toml";
/// Names of a logo that is found without a file that says so.
const LOGOS: [&str; 2] = ["logo.svg", "logo.png"];

/// A picture of the laboratory's.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Logo {
    /// `svg` or `png`.
    pub format: &'static str,
    pub bytes: Vec<u8>,
}

/// What stands at the head of the title page and of every page.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Letterhead {
    pub laboratory: Option<String>,
    pub address: Vec<String>,
    pub accreditation: Option<String>,
    /// One more line at the foot of every page.
    pub footer: Option<String>,
    /// Colours as `#rrggbb`: of small heads and marks, and of the line beside the origin of the data.
    pub accent: Option<String>,
    pub rule: Option<String>,
    #[serde(skip)]
    pub logo: Option<Logo>,
    /// A template in Typst that takes the place of the shipped one and reads the same data.
    #[serde(skip)]
    pub own_template: Option<String>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct Document {
    laboratory: Option<String>,
    address: Vec<String>,
    accreditation: Option<String>,
    footer: Option<String>,
    accent: Option<String>,
    rule: Option<String>,
    logo: Option<PathBuf>,
    template: Option<PathBuf>,
}

impl Letterhead {
    /// Reads a folder with `template.toml` (or only a `logo.svg` or `logo.png`), a TOML file, or a template in Typst.
    ///
    /// # Errors
    /// [`Error::File`] if a file cannot be read; [`Error::Input`] naming the file with what is wrong in it: a key that is unknown, a colour that is none,
    /// a logo that is damaged.
    pub fn read(path: &Path) -> Result<Self, Error> {
        if path.extension().is_some_and(|e| e == "typ") {
            return Ok(Letterhead { own_template: Some(text(path)?), ..Letterhead::default() });
        }
        if !path.is_dir() {
            return from_toml(path);
        }
        let file = path.join(FILE);
        if file.is_file() {
            return from_toml(&file);
        }
        let Some(logo) = LOGOS.iter().map(|name| path.join(name)).find(|logo| logo.is_file()) else {
            let remedy = format!("put {FILE} there (docs/report.md has an example), or logo.svg, or logo.png");
            return Err(Error::input(Place::file(path), "this folder holds no template", remedy));
        };
        Ok(Letterhead { logo: Some(read_logo(&logo)?), ..Letterhead::default() })
    }
}

fn from_toml(path: &Path) -> Result<Letterhead, Error> {
    let text_of_it = text(path)?;
    let document: Document = toml::from_str(&text_of_it).map_err(|fault| {
        let line = fault.span().map(|span| text_of_it[..span.start.min(text_of_it.len())].matches('\n').count() + 1);
        let at = line.map(|line| format!("line {line}: ")).unwrap_or_default();
        let remedy = "known are laboratory, address, accreditation, footer, logo, accent, rule and template (docs/report.md)";
        Error::input(Place::file(path), format!("{at}{}", fault.message().trim()), remedy)
    })?;
    let folder = path.parent().unwrap_or(Path::new("."));
    for (key, colour) in [("accent", &document.accent), ("rule", &document.rule)] {
        if let Some(colour) = colour.as_ref().filter(|colour| !is_colour(colour)) {
            return Err(Error::input(Place::file(path), format!("{key} = “{colour}” is no colour"), "write it as “#0072b2”"));
        }
    }
    Ok(Letterhead {
        laboratory: document.laboratory,
        address: document.address,
        accreditation: document.accreditation,
        footer: document.footer,
        accent: document.accent,
        rule: document.rule,
        logo: document.logo.map(|logo| read_logo(&folder.join(logo))).transpose()?,
        own_template: document.template.map(|own| text(&folder.join(own))).transpose()?,
    })
}

fn is_colour(text: &str) -> bool {
    text.strip_prefix('#').is_some_and(|digits| digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit()))
}

/// Reads a logo and looks whether it can be drawn, so that a damaged one is named and not the document.
fn read_logo(path: &Path) -> Result<Logo, Error> {
    let ending = path.extension().map(|e| e.to_ascii_lowercase());
    let format = match ending.as_ref().and_then(|e| e.to_str()) {
        Some("svg") => "svg",
        Some("png") => "png",
        _ => return Err(Error::input(Place::file(path), "a logo of this format is not read", "give it as SVG or PNG")),
    };
    let bytes = fs::read(path).map_err(|source| Error::file(path, source))?;
    let damaged = |why: String| {
        Error::input(Place::file(path), format!("this is no {} picture: {why}", format.to_uppercase()), "save the logo again")
    };
    raster::check(format, &bytes).map_err(damaged)?;
    Ok(Logo { format, bytes })
}

fn text(path: &Path) -> Result<String, Error> {
    let bytes = fs::read(path).map_err(|source| Error::file(path, source))?;
    String::from_utf8(bytes).map_err(|_| Error::input(Place::file(path), "this is not UTF-8 text", "save it as UTF-8"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SVG: &str = r#"<svg xmlns="http://www.w3.org/2000/svg" width="10" height="10"><circle cx="5" cy="5" r="4"/></svg>"#;

    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        files.iter().for_each(|(name, text)| fs::write(folder.path().join(name), text).unwrap());
        folder
    }

    #[test]
    fn a_folder_with_a_file_and_a_logo_is_read() {
        let toml = "laboratory = \"Лаборатория\"\naddress = [\"one\", \"two\"]\naccent = \"#112233\"\nlogo = \"sign.svg\"\n";
        let folder = folder(&[("template.toml", toml), ("sign.svg", SVG)]);
        let read = Letterhead::read(folder.path()).unwrap();
        assert_eq!(read.laboratory.as_deref(), Some("Лаборатория"));
        assert_eq!(read.address, ["one", "two"]);
        assert_eq!(read.logo.as_ref().map(|logo| logo.format), Some("svg"));
        assert_eq!(Letterhead::read(&folder.path().join("template.toml")).unwrap(), read);
    }

    #[test]
    fn a_folder_with_nothing_but_a_logo_is_enough_and_an_empty_one_is_not() {
        assert!(Letterhead::read(folder(&[("logo.svg", SVG)]).path()).unwrap().logo.is_some());
        assert!(Letterhead::read(folder(&[]).path()).unwrap_err().to_string().contains("template.toml"));
    }

    #[test]
    fn a_missing_a_damaged_and_a_foreign_logo_are_named() {
        for (logo, content, said) in [
            ("none.svg", None, "none.svg"),
            ("bad.svg", Some("<svg"), "bad.svg"),
            ("bad.png", Some("x"), "bad.png"),
            ("a.gif", Some("x"), "SVG or PNG"),
        ] {
            let folder = folder(&[("template.toml", &format!("logo = \"{logo}\"\n"))]);
            if let Some(content) = content {
                fs::write(folder.path().join(logo), content).unwrap();
            }
            let error = Letterhead::read(folder.path()).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
    }

    #[test]
    fn an_unknown_key_and_a_colour_that_is_none_are_located() {
        let fault = |toml: &str| Letterhead::read(folder(&[("template.toml", toml)]).path()).unwrap_err().to_string();
        assert!(fault("\nlabratory = \"x\"\n").contains("line 2"));
        assert!(fault("accent = \"blue\"\n").contains("#0072b2"));
    }
}
