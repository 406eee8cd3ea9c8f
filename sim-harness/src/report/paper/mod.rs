//! The paper's figures from simulated drives, and two more figures.
//!
//! "The paper" is Korthals et al. 2016. A figure becomes a [`PageSection`]: pictures,
//! tables and a caption. A section is a function of its seeds alone.

mod figure_1;
mod figure_2;
mod figure_4;
mod figure_5;
mod figure_8;
mod figure_9;
mod influence;
mod map_row;
mod one_sensor;
mod page;
mod page_section;
mod paper_figure;
mod scenario_maps;
mod scores;
mod tracked_steps;
mod two_steps;
mod walls;

pub use page::page;
pub use page_section::{PageSection, PageTable, Panel, PanelRow};
pub use paper_figure::{FigureError, PaperFigure};
