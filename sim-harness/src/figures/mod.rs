//! What a finished map is shown as: grids for ROS.

mod map_server;
mod window;

pub use map_server::MapServerPair;
pub use window::Window;
