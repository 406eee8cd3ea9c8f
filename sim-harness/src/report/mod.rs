//! Maps and results as files: pictures, charts, a page of figures, grids for ROS.
//!
//! Every picture is a function of its input alone: the same map gives the same bytes on
//! every run and machine. No clock, no system font, and of the float functions only
//! those that round the same everywhere.

mod cell_window;
mod chart;
mod contact_sheet;
mod drive_files;
mod drive_maps_files;
mod fit_chart;
mod line_drawing;
mod map_overlay;
mod map_picture;
mod map_server;
mod paper;
mod picture;
mod pixel_grid;
mod roc_chart;
mod run_files;
mod scale_bar;
mod servo_scan_picture;
mod text;
mod wall_files;
mod wall_overlay;

pub use cell_window::CellWindow;
pub use contact_sheet::ContactSheet;
pub use drive_files::{DRIVE_FILES, DriveMapSummary};
pub use drive_maps_files::{DriveMapsFiles, summary_of};
pub use fit_chart::fit_chart;
pub use map_picture::{MAX_SIDE_PX, MapPicture, OUTLINE, PATH, outlines};
pub use map_server::MapServerPair;
pub use paper::{FigureError, PageSection, PageTable, Panel, PanelRow, PaperFigure, page};
pub use picture::{Colour, Picture, beside};
pub use pixel_grid::{FREE, OCCUPIED, UNKNOWN};
pub use roc_chart::{RocCurve, roc_chart};
pub use run_files::{RUN_FILES, RunSummary, WallCount, WallReports, run_picture, save_run_map};
pub use servo_scan_picture::servo_scan_picture;
pub use wall_files::{WALL_FILES, save_walls};
pub use wall_overlay::WALL;
