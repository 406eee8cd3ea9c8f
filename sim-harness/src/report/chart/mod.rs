//! Charts: marks between two axes.

mod axis;
mod layer;
mod legend;
mod sheet;

pub(crate) use axis::Axis;
pub(crate) use layer::Mark;
pub(crate) use sheet::Chart;
