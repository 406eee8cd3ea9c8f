//! Live boards: a serial port, the flash image in QEMU, a terminal in memory.
//!
//! All three are a [`Board`]: bytes out, bytes in. [`drive`] feeds one in lock-step,
//! [`Comparison`] holds its answers against the host's own run. [`record`] listens to a
//! robot that reads its own sensors, [`measure_offsets`] has it measure their offsets.
//! A [`LossyLine`] lies between where faults are wanted, and an [`Account`] tells what
//! became of every frame.

mod account;
mod board;
mod comparison;
mod expected;
mod greeting;
#[cfg(unix)]
mod hang_up;
mod image;
mod interrupt;
mod junk;
mod line;
mod line_run;
mod lockstep;
mod memory;
mod offsets;
mod order;
mod post_mortem;
mod qemu;
mod record;
mod serial;
mod srecord;
mod verdict;

pub use account::{Account, FrameTally, Imbalance};
pub use board::{Board, Ends, LinkError};
pub use comparison::Comparison;
pub use image::{Image, ImageError, Layout, build_image};
pub use interrupt::Interrupt;
pub use line::{LineFault, LineFaultError, LineFaults, LineTally, LossyLine, Window};
pub use line_run::{LineOutcome, LineRun};
pub use lockstep::{AnswerAudit, drive, drive_streamed, listen};
pub use memory::boot_on_host;
pub use offsets::{measure_offsets, offsets_in_words};
pub use order::InOrder;
pub use post_mortem::post_mortem_in_words;
pub use qemu::QemuOptions;
pub use record::{MOST_RESETS, News, RecordError, record};
pub use srecord::to_s_records;
pub use verdict::{Equality, Verdict};
