//! A section of the page: rows of pictures, tables, and a caption.

use crate::report::picture::Picture;

/// A figure with its pictures, tables and caption.
#[derive(Clone, Debug, PartialEq)]
pub struct PageSection {
    /// Short name, the beginning of the names of the figure's files: `figure-9`.
    pub name: &'static str,
    /// The headline.
    pub title: &'static str,
    /// Caption: what the figure shows, how it was made and what the paper reports.
    pub caption: &'static str,
    /// Pictures, row by row.
    pub rows: Vec<PanelRow>,
    /// Tables below the pictures.
    pub tables: Vec<PageTable>,
    /// File name and picture for a place with room for one picture; not on the page.
    pub excerpt: Option<(&'static str, Picture)>,
}

/// Pictures side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelRow {
    /// Heading of the row; may be empty.
    pub heading: String,
    /// The pictures, from left to right.
    pub panels: Vec<Panel>,
}

/// One picture of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Name of its file.
    pub file: String,
    /// Text in place of the picture.
    pub alternative: String,
    /// A line below the picture; may be empty.
    pub note: String,
    /// The picture.
    pub picture: Picture,
}

/// Rows of text below a head.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PageTable {
    /// The meaning of its numbers.
    pub caption: &'static str,
    /// The columns' names.
    pub head: Vec<&'static str>,
    /// The rows, as long as the head.
    pub rows: Vec<Vec<String>>,
}

impl PageSection {
    /// All pictures, row by row.
    pub fn panels(&self) -> impl Iterator<Item = &Panel> {
        self.rows.iter().flat_map(|row| &row.panels)
    }
}

impl From<Vec<Panel>> for PanelRow {
    /// A row without a heading.
    fn from(panels: Vec<Panel>) -> Self {
        Self {
            heading: String::new(),
            panels,
        }
    }
}

impl Panel {
    /// A picture in the file `<figure>-<part>.png`, without a note.
    pub(super) fn new(figure: &str, part: &str, alternative: String, picture: Picture) -> Self {
        Self {
            file: format!("{figure}-{part}.png"),
            alternative,
            note: String::new(),
            picture,
        }
    }
}
