//! A drive as records, for any robot: poses and scans in SI units.

mod keyframes;
mod record;

pub use keyframes::Keyframes;
pub use record::{Record, Return, Scan};
