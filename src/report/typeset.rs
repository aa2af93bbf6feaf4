//! From a Typst template and files in memory to the bytes of a PDF; the only door to the typesetter.
//!
//! Fonts are embedded in the program and nothing is read from the machine, so the same input gives the same bytes.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use typst::diag::{FileError, FileResult, SourceDiagnostic};
use typst::foundations::{Bytes, Datetime, Duration, Smart};
use typst::layout::Abs;
use typst::syntax::{FileId, RootedPath, Source, VirtualPath, VirtualRoot};
use typst::text::{Font, FontBook, FontInstance, FontVariant, FontVariations};
use typst::utils::LazyHash;
use typst::{Library, LibraryExt, World, WorldExt};
use typst_layout::PagedDocument;
use typst_pdf::PdfOptions;

use super::date::Date;
use super::language::Measure;
use crate::error::Error;

/// The name under which the template itself is known in messages.
const MAIN: &str = "report.typ";

/// What a document is set from.
#[derive(Debug, Clone, Default)]
pub struct Manuscript {
    /// Typst markup.
    pub template: String,
    /// Everything the template reads, by path: data, pictures, further markup.
    pub files: BTreeMap<String, Vec<u8>>,
    /// Written into the document's metadata; `None` writes none.
    pub date: Option<Date>,
}

/// Sets the manuscript and returns the PDF. Deterministic: no clock, no fonts or files of the machine.
///
/// # Errors
/// [`Error::Output`] with the file, line and column of the markup that could not be set.
pub fn pdf(manuscript: Manuscript) -> Result<Vec<u8>, Error> {
    let desk = Desk::new(manuscript)?;
    let set = typst::compile::<PagedDocument>(&desk);
    let document = set.output.map_err(|faults| desk.error(&faults))?;
    // The typesetter memoizes without bound. What it remembers of the setting is of no use to the writing of the file, which needs the room.
    typst::comemo::evict(0);
    let options = PdfOptions {
        ident: Smart::Auto,
        creator: Smart::Custom(Some(concat!("hemline ", env!("CARGO_PKG_VERSION")).to_string())),
        ..PdfOptions::default()
    };
    let bytes = typst_pdf::pdf(&document, &options).map_err(|faults| desk.error(&faults))?;
    // A program that sets many documents would keep what it remembers of them all.
    typst::comemo::evict(0);
    Ok(bytes)
}

/// The fonts of the program: a serif for text, one for equations, a sans for figures and tables.
static FONTS: LazyLock<(Vec<Font>, LazyHash<FontBook>)> = LazyLock::new(|| {
    let embedded = typst_assets::fonts().chain([
        dejavu::sans::regular(),
        dejavu::sans::bold(),
        dejavu::sans::oblique(),
        dejavu::sans_condensed::regular(),
        dejavu::sans_condensed::bold(),
    ]);
    let fonts: Vec<Font> = embedded.flat_map(|data| Font::iter(Bytes::new(data))).collect();
    let book = FontBook::from_fonts(&fonts);
    (fonts, LazyHash::new(book))
});

/// Widths of the sans of figures, for words that must keep their room.
pub struct Sans;

impl Measure for Sans {
    fn width(&self, text: &str) -> f64 {
        /// A letter that the font has not; about the width of any other.
        const UNKNOWN: f64 = 0.6;
        let Some(font) = SANS_UPRIGHT.as_ref() else { return UNKNOWN * text.chars().count() as f64 };
        let advance = |c: char| font.ttf().glyph_index(c).and_then(|glyph| font.x_advance(glyph.0)).map_or(UNKNOWN, |em| em.get());
        text.chars().map(advance).sum()
    }
}

static SANS_UPRIGHT: LazyLock<Option<FontInstance>> = LazyLock::new(|| {
    let plain = FontVariant::default();
    let font = FONTS.0.iter().find(|font| font.info().family == SANS && font.info().variant == plain)?;
    Some(font.clone().instantiate(plain, Abs::pt(10.0), &FontVariations::default()))
});

/// The family of figures and tables.
const SANS: &str = "DejaVu Sans";

/// The typesetter's whole world: one template, its files, the embedded fonts.
struct Desk {
    library: LazyHash<Library>,
    main: FileId,
    source: Source,
    files: BTreeMap<String, Bytes>,
    date: Option<Date>,
}

impl Desk {
    fn new(manuscript: Manuscript) -> Result<Self, Error> {
        let main = id(MAIN)?;
        let files = manuscript.files.into_iter().map(|(path, bytes)| (path, Bytes::new(bytes))).collect();
        let source = Source::new(main, manuscript.template);
        Ok(Desk { library: LazyHash::new(Library::default()), main, source, files, date: manuscript.date })
    }

    /// All faults as one sentence each, with their place in the template.
    fn error(&self, faults: &[SourceDiagnostic]) -> Error {
        let sentences = faults.iter().map(|fault| {
            let mut sentence = fault.message.to_string();
            if let Some(range) = self.range(fault.span)
                && let Some((line, column)) = self.source.lines().byte_to_line_column(range.start)
            {
                sentence = format!("{MAIN}, line {}, column {}: {sentence}", line + 1, column + 1);
            }
            for hint in &fault.hints {
                sentence = format!("{sentence} ({})", hint.v);
            }
            sentence
        });
        Error::Output { what: "report.pdf".into(), why: sentences.collect::<Vec<_>>().join("; ") }
    }
}

impl World for Desk {
    fn library(&self) -> &LazyHash<Library> {
        &self.library
    }

    fn book(&self) -> &LazyHash<FontBook> {
        &FONTS.1
    }

    fn main(&self) -> FileId {
        self.main
    }

    fn source(&self, id: FileId) -> FileResult<Source> {
        if id == self.main {
            return Ok(self.source.clone());
        }
        let text = String::from_utf8(self.file(id)?.to_vec()).map_err(|_| FileError::InvalidUtf8)?;
        Ok(Source::new(id, text))
    }

    fn file(&self, id: FileId) -> FileResult<Bytes> {
        self.files.get(id.get().vpath().get_without_slash()).cloned().ok_or_else(|| missing(id))
    }

    fn font(&self, index: usize) -> Option<Font> {
        FONTS.0.get(index).cloned()
    }

    fn today(&self, _offset: Option<Duration>) -> Option<Datetime> {
        let date = self.date?;
        Datetime::from_ymd(date.year, date.month, date.day)
    }
}

fn id(path: &str) -> Result<FileId, Error> {
    let virtual_path = VirtualPath::new(path)
        .map_err(|_| Error::Output { what: "report.pdf".into(), why: format!("“{path}” is no path inside it") })?;
    Ok(RootedPath::new(VirtualRoot::Project, virtual_path).intern())
}

fn missing(id: FileId) -> FileError {
    FileError::NotFound(id.get().vpath().get_without_slash().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manuscript(template: &str) -> Manuscript {
        Manuscript { template: template.into(), ..Manuscript::default() }
    }

    #[test]
    fn the_same_manuscript_gives_the_same_bytes() {
        let text = "#set document(title: \"t\", date: none)\n= Heading\nШирина $lambda = integral_0^1 x dif x$";
        assert_eq!(pdf(manuscript(text)).unwrap(), pdf(manuscript(text)).unwrap());
    }

    #[test]
    fn a_fault_in_the_template_is_located() {
        let error = pdf(manuscript("first line\n#let x = (1 + \"a\")\n")).unwrap_err().to_string();
        assert!(error.contains("line 2"), "{error}");
    }

    #[test]
    fn a_missing_picture_is_named() {
        let error = pdf(manuscript("#image(\"figures/none.svg\")")).unwrap_err().to_string();
        assert!(error.contains("figures/none.svg"), "{error}");
    }

    #[test]
    fn text_of_an_embedded_picture_is_set_in_the_embedded_font() {
        let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" width="100" height="20"><text x="0" y="15" font-family="DejaVu Sans" font-size="10">Изгиб</text></svg>"#;
        let mut with_picture = manuscript("#image(\"a.svg\")");
        with_picture.files.insert("a.svg".into(), svg.as_bytes().to_vec());
        let bytes = pdf(with_picture).unwrap();
        let name = b"DejaVuSans";
        assert!(bytes.windows(name.len()).any(|window| window == name));
    }

    #[test]
    fn widths_are_those_of_the_embedded_sans() {
        // Advances in DejaVuSans.ttf (hmtx, 2048 units per em): n 1298, ж 1848.
        assert!((Sans.width("n") - 1298.0 / 2048.0).abs() < 1e-9);
        assert!(Sans.width("жж") > 1.2 * Sans.width("nn"));
    }
}
