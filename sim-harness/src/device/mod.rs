//! Boards at the other end of a byte stream: a serial port, the flash image in QEMU, a
//! device endpoint in memory.
//!
//! All three are a [`Board`]: bytes out, bytes in. [`drive`] feeds one in lock-step,
//! [`Comparison`] compares its answers with the host's own run. [`record`] records a robot
//! that reads its own sensors, [`measure_offsets`] has it measure their offsets. A
//! [`FaultInjector`] disturbs the bytes of a transport, and [`LossStats`] count received,
//! dropped and lost frames.

mod baud_check;
mod board;
mod comparison;
mod expected;
mod fault_injector;
mod geometric;
mod greeting;
mod handshake;
mod health_text;
mod image;
mod image_error;
mod in_order;
mod interrupt;
mod line_run;
mod link_error;
mod lockstep;
mod loopback;
mod loss_stats;
mod offsets;
mod post_mortem;
mod qemu;
mod raw;
mod record;
mod recording_parts;
mod replay;
mod serial;
mod srecord;
mod transport;
#[cfg(unix)]
mod unix_socket;
mod verdict;

pub use board::Board;
pub use comparison::Comparison;
pub use fault_injector::{FaultInjector, LineTally};
pub use health_text::{counters, counters_in_words, health_text, status_counters};
pub use image::{Image, Layout, build_image};
pub use image_error::ImageError;
pub use in_order::InOrder;
pub use interrupt::Interrupt;
pub use line_run::{HOST_NODE_BOOT_ID, LineOutcome, LineRun};
pub use link_error::LinkError;
pub use lockstep::{AnswerAudit, Pace, drive, drive_streamed, listen};
pub use loopback::boot_on_host;
pub use loss_stats::{FrameTally, Imbalance, LossStats};
pub use offsets::{measure_offsets, offsets_in_words};
pub use post_mortem::post_mortem_in_words;
pub use qemu::QemuOptions;
pub use record::{MOST_RESETS, RecordError, RecordingEvent, record};
pub use recording_parts::RecordingParts;
pub use replay::{
    KeptEvents, ReplayError, ReplayPass, ReplayPlan, Replayed, StepCycles, replay_on_board,
    replay_on_host,
};
pub use srecord::to_s_records;
pub use transport::Ends;
pub use verdict::{Equality, Verdict};
