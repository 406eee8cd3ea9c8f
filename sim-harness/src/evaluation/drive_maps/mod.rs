//! The maps of a recorded drive by several methods, with their scores.

mod map_row;
mod map_table;
mod maps;
mod peak_memory;
mod recorded_drive;

pub use map_row::MapRow;
pub use map_table::MapTable;
pub use maps::{DriveMaps, MapProgress, MapSettings, MethodMap};
pub use recorded_drive::{RecordedDrive, RecordedDriveError};
