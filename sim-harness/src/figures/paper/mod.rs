//! The paper's figures from simulated drives, and figures of our own beside them.
//!
//! "The paper" is Korthals et al. 2016. A figure becomes a [`Plate`]: pictures, tables
//! and a caption; plates become one page. A plate is a function of its seeds alone.

mod arc;
mod course;
mod error;
mod figure;
mod figure_1;
mod figure_2;
mod figure_4;
mod figure_5;
mod figure_8;
mod figure_9;
mod influence;
mod moments;
mod one_sensor;
mod page;
mod percent;
mod plate;
mod two_steps;

pub use error::FigureError;
pub use figure::Figure;
pub use page::page;
pub use plate::{Panel, Plate, Row, Table};
