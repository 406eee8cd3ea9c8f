//! `cargo ipf offsets`: what a robot's sensors read with nothing near.

use std::path::PathBuf;

use clap::Args;
use sim_harness::console;
use sim_harness::device::{QemuOptions, measure_offsets, offsets_in_words};

use super::{CommandResult, ExitStatus, connect};

/// Arguments of `offsets`.
#[derive(Debug, Args)]
pub(super) struct OffsetsCommand {
    /// Where the robot is: the name of a serial port, or `qemu`.
    #[arg(long, value_name = "PORT|qemu")]
    on: String,
    /// Speed of the serial port, bits per second; 2000000 if not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    baud: Option<u32>,
    /// Only show the offsets that the board has now.
    #[arg(long)]
    read: bool,
    /// With `--on qemu`: this ELF file instead of one that is built now.
    #[arg(long, value_name = "FILE")]
    image: Option<PathBuf>,
}

impl OffsetsCommand {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        connect::check(&self.on, self.baud, self.image.as_deref(), &[])?;
        let options = QemuOptions::default();
        let mut board = connect::reach(&self.on, self.baud, self.image.as_deref(), &options, None)?;
        connect::greet(&mut board)?;
        let report = if self.read {
            board.offsets().copied()
        } else {
            measure_offsets(&mut board)?
        };
        let Some(report) = report else {
            if self.read {
                console::warn("the board reported no offsets");
            } else {
                console::warn(
                    "no offsets were measured: the board reported no measurement within 5 s",
                );
            }
            return Ok(ExitStatus::Failed);
        };
        console::print_text(offsets_in_words(&report));
        let is_refused = report.refused.iter().any(Option::is_some);
        Ok(if is_refused && !self.read {
            ExitStatus::Failed
        } else {
            ExitStatus::Good
        })
    }
}
