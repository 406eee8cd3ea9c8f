//! The paper's figures from simulated drives, and figures of our own beside them.
//!
//! "The paper" is Korthals et al. 2016. A figure becomes a [`Plate`]: pictures, tables
//! and a caption; plates become one page. A plate is a function of its seeds alone.

mod course;
mod error;
mod figure;
mod figure_9;
mod method;
mod page;
mod percent;
mod plate;

pub use error::FigureError;
pub use figure::Figure;
pub use page::page;
pub use plate::{Panel, Plate, Row, Table};
