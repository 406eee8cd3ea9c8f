//! What a finished map is shown as: pictures for people, grids for ROS.
//!
//! Every figure is a function of its input alone: the same map gives the same bytes on
//! every run and machine. No clock, no system font, and of the float functions only
//! those that round the same everywhere.

mod chart;
mod fit_picture;
mod lettering;
mod map_picture;
mod map_server;
mod paper;
mod picture;
mod raster;
mod scale_bar;
mod stroke;
mod window;

pub use fit_picture::fit_picture;
pub use map_picture::{MAX_SIDE_PX, MapPicture, OUTLINE, PATH};
pub use map_server::MapServerPair;
pub use paper::{Figure, FigureError, Panel, Plate, Row, Table, page};
pub use picture::{Colour, Picture, beside};
pub use raster::{FREE, OCCUPIED, UNKNOWN};
pub use window::Window;
