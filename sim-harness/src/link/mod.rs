//! Live boards: a serial port, the flash image in QEMU, a terminal in memory.
//!
//! All three are a [`Board`]: bytes out, bytes in. [`drive`] feeds one in lock-step,
//! [`Comparison`] holds its answers against the host's own run. [`record`] listens to a
//! robot that reads its own sensors, [`measure_offsets`] has it measure their offsets.

mod board;
mod comparison;
mod image;
mod lockstep;
mod memory;
mod offsets;
mod qemu;
mod record;
mod serial;
mod srecord;

pub use board::{Board, LinkError};
pub use comparison::{Comparison, Verdict};
pub use image::{Image, ImageError, Layout, build_image};
pub use lockstep::drive;
pub use offsets::{measure_offsets, offsets_in_words};
pub use qemu::QemuOptions;
pub use record::{RecordError, record};
pub use srecord::to_s_records;
