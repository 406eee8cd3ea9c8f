//! Charts: what is a function of something else, drawn between two axes.

mod axis;
mod layer;
mod legend;
mod sheet;

pub(crate) use axis::Axis;
pub(crate) use layer::{Bar, Layer, Mark};
pub(crate) use sheet::Chart;
