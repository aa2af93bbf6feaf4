//! A study as a section of a report: sentences, tables and figures, as files in a folder or for a document to set.

use std::path::{Path, PathBuf};

use super::csv::Table;
use super::section::{Figure, Grid, Section};
use super::{output, raster};
use crate::error::Error;

/// A table with the stem of its file and what it shows.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionTable {
    pub stem: String,
    pub caption: String,
    pub table: Table,
    /// A short form for the page of a document: a header and a few rows of rounded words. Empty where the document needs none.
    pub short: Vec<Vec<String>>,
}

/// A figure with the stem of its file and what it shows.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionFigure {
    pub stem: String,
    pub caption: String,
    pub svg: String,
}

/// Everything that a report shows of one study.
#[derive(Debug, Clone, PartialEq)]
pub struct StudySection {
    /// `study_accuracy` …: the stem of its own file.
    pub stem: String,
    pub title: String,
    /// One finding each, in the order of importance.
    pub sentences: Vec<String>,
    pub tables: Vec<SectionTable>,
    pub figures: Vec<SectionFigure>,
}

impl StudySection {
    /// The same as a chapter of the document: tables in their short form.
    pub fn chapter(&self) -> Section {
        let grid = |table: &SectionTable| {
            let (columns, rows) = table.short.split_first()?;
            let number = |cell: &String| cell == "–" || cell.starts_with(|c: char| c.is_ascii_digit());
            let text = |column: usize| rows.iter().any(|row| !number(&row[column]));
            let text_columns = (0..columns.len()).take_while(|&column| text(column)).count();
            Some(Grid { caption: table.caption.clone(), columns: columns.clone(), rows: rows.to_vec(), text_columns })
        };
        let figure =
            |figure: &SectionFigure| Figure { stem: figure.stem.clone(), caption: figure.caption.clone(), svg: figure.svg.clone() };
        Section {
            title: self.title.clone(),
            paragraphs: self.sentences.clone(),
            tables: self.tables.iter().filter_map(grid).collect(),
            figures: self.figures.iter().map(figure).collect(),
        }
    }
}

/// On what times were taken, as it stands in the header of a study.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Machine {
    /// Processor and system, as they call themselves.
    pub name: String,
    /// Threads that the program may use.
    pub threads: usize,
}

/// Writes `STEM.md`, then each table as CSV and each figure as SVG and PNG into `folder`; the paths, in that order.
///
/// # Errors
/// [`Error::File`] if the folder cannot be written, [`Error::Output`] if a figure cannot be rasterized.
pub fn write(section: &StudySection, folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut files = vec![(format!("{}.md", section.stem), markdown(section).into_bytes())];
    files.extend(section.tables.iter().map(|table| (format!("{}.csv", table.stem), table.table.bytes())));
    for figure in &section.figures {
        let picture = format!("{}.png", figure.stem);
        let png = raster::png(&picture, &figure.svg)?;
        files.push((format!("{}.svg", figure.stem), figure.svg.clone().into_bytes()));
        files.push((picture, png));
    }
    files.iter().map(|(name, bytes)| output::write(folder, name, bytes)).collect()
}

/// The section as a page of its own.
pub fn markdown(section: &StudySection) -> String {
    let mut text = format!("# {}\n\n", section.title);
    section.sentences.iter().for_each(|sentence| text += &format!("{sentence}\n\n"));
    for table in &section.tables {
        text += &format!("{} (`{}.csv`)\n\n", table.caption, table.stem);
        for (i, row) in table.short.iter().enumerate() {
            text += &format!("| {} |\n", row.join(" | "));
            if i == 0 {
                text += &format!("|{}\n", "---|".repeat(row.len()));
            }
        }
        if !table.short.is_empty() {
            text.push('\n');
        }
    }
    for figure in &section.figures {
        text += &format!("![{}]({}.png)\n\n{}\n\n", figure.caption, figure.stem, figure.caption);
    }
    text
}
