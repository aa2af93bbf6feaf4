//! A figure as a file of its own: SVG, PNG or PDF, in colour or grey, in its own size or another.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::gallery::Gallery;
use super::typeset::{self, Manuscript};
use super::{Progress, date::Date, output, raster};
use crate::error::Error;

/// Families that stand in for the embedded one where it is not installed: nearly as wide, so that nothing runs into its neighbour.
const FAMILIES: &str = "'DejaVu Sans', 'Bitstream Vera Sans', Verdana, Geneva, sans-serif";

/// In which form a figure is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    Svg,
    Png,
    Pdf,
}

impl Form {
    /// By the ending of a file's name.
    pub fn of(path: &Path) -> Option<Form> {
        let ending = path.extension()?.to_str()?.to_lowercase();
        [("svg", Form::Svg), ("png", Form::Png), ("pdf", Form::Pdf)].into_iter().find(|(known, _)| *known == ending).map(|(_, form)| form)
    }

    pub fn ending(self) -> &'static str {
        match self {
            Form::Svg => "svg",
            Form::Png => "png",
            Form::Pdf => "pdf",
        }
    }
}

/// How a figure is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Dots per inch of a PNG.
    pub dpi: f64,
    /// Width on paper, mm; the height and the type go with it. `None`: as it was drawn.
    pub width: Option<f64>,
    /// Every colour as the grey of its lightness.
    pub grey: bool,
    /// Written into a PDF's metadata.
    pub date: Option<Date>,
}

impl Default for Options {
    /// In colour, in its own size, for print.
    fn default() -> Self {
        Options { dpi: raster::DPI, width: None, grey: false, date: None }
    }
}

/// The bytes of one figure; `stem` names it in messages.
///
/// # Errors
/// [`Error::Output`] if it cannot be produced.
pub fn bytes(stem: &str, svg: &str, form: Form, options: &Options) -> Result<Vec<u8>, Error> {
    let mut svg = svg.to_string();
    if options.grey {
        svg = grey(&svg);
    }
    if let Some(width) = options.width {
        svg = resized(&svg, width);
    }
    match form {
        Form::Svg => Ok(standalone(&svg).into_bytes()),
        Form::Png => raster::png_at(&format!("{stem}.png"), &svg, options.dpi),
        Form::Pdf => {
            let (width, height) = size(&svg).unwrap_or((100.0, 100.0));
            let template = format!(
                "#set document(title: \"{stem}\", author: \"hemline\", date: none)\n#set page(width: {width}mm, height: {height}mm, margin: 0mm)\n\
                 #image(\"figure.svg\", width: 100%)"
            );
            let files = [("figure.svg".to_string(), svg.into_bytes())].into_iter().collect();
            typeset::pdf(Manuscript { template, files, date: options.date })
        }
    }
}

/// Writes every figure as `figures/*.svg` and `figures/*.png` into `folder`, and returns the paths, figure by figure in the order of the gallery. One step of
/// progress is one figure.
///
/// # Errors
/// Those of [`bytes`], and [`Error::File`] if the folder cannot be written.
pub fn write_all(gallery: &Gallery, folder: &Path, dpi: f64, progress: &(dyn Fn(Progress) + Sync)) -> Result<Vec<PathBuf>, Error> {
    let figures: Vec<(&String, &String)> = gallery.iter().collect();
    progress(Progress::Ahead(figures.len()));
    let options = Options { dpi, ..Options::default() };
    let one = |(stem, svg): &(&String, &String)| -> Result<[PathBuf; 2], Error> {
        let write = |form: Form| output::write(folder, &format!("figures/{stem}.{}", form.ending()), &bytes(stem, svg, form, &options)?);
        let written = [write(Form::Svg)?, write(Form::Png)?];
        progress(Progress::Step);
        Ok(written)
    };
    // Of several faults the first figure's is told, whichever came first.
    let written: Vec<Result<[PathBuf; 2], Error>> = figures.par_iter().map(one).collect();
    let written: Result<Vec<[PathBuf; 2]>, Error> = written.into_iter().collect();
    Ok(written?.into_iter().flatten().collect())
}

/// The drawing as a file that browsers and editors open: its text stays text, in the family that is nearest to the embedded one.
fn standalone(svg: &str) -> String {
    let named = svg.replace("font-family=\"DejaVu Sans\"", &format!("font-family=\"{FAMILIES}\""));
    format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{named}\n")
}

/// Width and height of a drawing, mm, as its first line states them.
pub fn size(svg: &str) -> Option<(f64, f64)> {
    let head = svg.get(..svg.find('>')?)?;
    let length = |name: &str| head.split(&format!(" {name}=\"")).nth(1)?.split("mm\"").next()?.parse::<f64>().ok();
    Some((length("width")?, length("height")?))
}

/// The same drawing `width` mm wide.
fn resized(svg: &str, width: f64) -> String {
    let Some((was, high)) = size(svg) else { return svg.to_string() };
    let height = high * width / was;
    svg.replacen(&format!("width=\"{was}mm\" height=\"{high}mm\""), &format!("width=\"{width}mm\" height=\"{height}mm\""), 1)
}

/// Every colour as the grey of its luminance (Rec. 709 weights on the coded values, as printers do it).
fn grey(svg: &str) -> String {
    let mut out = String::with_capacity(svg.len());
    let mut rest = svg;
    while let Some(at) = rest.find("=\"#") {
        let (before, after) = rest.split_at(at + 3);
        out.push_str(before);
        let levels = after.get(..6).and_then(|six| u32::from_str_radix(six, 16).ok());
        if let Some(levels) = levels {
            let [_, r, g, b] = levels.to_be_bytes().map(f64::from);
            let light = (0.2126 * r + 0.7152 * g + 0.0722 * b).round() as u8;
            out.push_str(&format!("{light:02X}{light:02X}{light:02X}"));
            rest = &after[6..];
        } else {
            rest = after;
        }
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const SVG: &str = "<svg width=\"20mm\" height=\"10mm\" viewBox=\"0 0 800 400\" xmlns=\"http://www.w3.org/2000/svg\">\n\
        <rect x=\"0\" y=\"0\" width=\"800\" height=\"400\" fill=\"#0072B2\"/>\n</svg>";

    #[test]
    fn a_figure_of_another_width_keeps_its_shape() {
        assert_eq!(size(SVG), Some((20.0, 10.0)));
        assert_eq!(size(&resized(SVG, 85.0)), Some((85.0, 42.5)));
        let options = Options { width: Some(50.8), dpi: 100.0, ..Options::default() };
        let png = bytes("a", SVG, Form::Png, &options).unwrap();
        assert_eq!(u32::from_be_bytes([png[16], png[17], png[18], png[19]]), 200);
    }

    #[test]
    fn grey_has_no_colour_and_the_lightness_of_the_colour() {
        assert!(grey(SVG).contains("fill=\"#5E5E5E\""), "{}", grey(SVG));
        assert_eq!(grey("<a href=\"#x\"/>"), "<a href=\"#x\"/>");
    }

    #[test]
    fn a_pdf_of_one_figure_is_as_large_as_the_figure() {
        let pdf = bytes("a", SVG, Form::Pdf, &Options::default()).unwrap();
        let text = String::from_utf8_lossy(&pdf);
        // 20 mm by 10 mm in points.
        assert!(pdf.starts_with(b"%PDF") && text.contains("56.69") && text.contains("28.34"), "{}", &text[..text.len().min(400)]);
    }
}
