//! A figure of the page: rows of pictures, tables, and what they show in words.

use crate::figures::picture::Picture;

/// A figure with everything that belongs to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Plate {
    /// Short name, which the figure's files begin with: `figure-9`.
    pub name: String,
    /// The headline.
    pub title: String,
    /// What is seen, how it was made and what the paper says, in plain words.
    pub caption: String,
    /// Pictures, row by row.
    pub rows: Vec<Row>,
    /// Tables below the pictures.
    pub tables: Vec<Table>,
    /// The picture for where there is room for only one, not on the page: file, picture.
    pub excerpt: Option<(String, Picture)>,
}

/// Pictures that belong side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What they have in common; may be empty.
    pub heading: String,
    /// The pictures, from left to right.
    pub panels: Vec<Panel>,
}

/// One picture of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Name of its file.
    pub file: String,
    /// What it shows, for those who do not see it.
    pub alternative: String,
    /// A line below it; may be empty.
    pub note: String,
    /// The picture.
    pub picture: Picture,
}

/// Rows of words below a head.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// What its numbers are.
    pub caption: String,
    /// The columns' names.
    pub head: Vec<String>,
    /// The rows, as long as the head.
    pub rows: Vec<Vec<String>>,
}

impl Plate {
    /// All pictures, row by row.
    pub fn panels(&self) -> impl Iterator<Item = &Panel> {
        self.rows.iter().flat_map(|row| &row.panels)
    }
}

impl Table {
    /// A table without rows.
    pub(crate) fn new(caption: &str, head: &[&str]) -> Self {
        Self {
            caption: caption.to_owned(),
            head: head.iter().map(ToString::to_string).collect(),
            rows: Vec::new(),
        }
    }
}
