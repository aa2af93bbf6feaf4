//! A chapter that comes from elsewhere: what the studies hand over to be printed between the runs and the appendix.

/// A chapter under “Studies”. Strings are finished English sentences; the report translates, numbers and captions them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Section {
    pub title: String,
    pub paragraphs: Vec<String>,
    pub tables: Vec<Grid>,
    pub figures: Vec<Figure>,
}

/// A table as it is printed: rounded, in words.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Grid {
    pub caption: String,
    pub columns: Vec<String>,
    /// As many cells as columns in each.
    pub rows: Vec<Vec<String>>,
    /// This many columns from the left hold text and are set to the left; the others hold numbers.
    pub text_columns: usize,
}

/// A drawing, as SVG of at most 170 mm width.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Figure {
    /// Name of its file, without folder and ending; unlike every other figure's.
    pub stem: String,
    pub caption: String,
    pub svg: String,
}
