//! Where `replay` runs the filter.

use std::error::Error;
use std::path::PathBuf;

use clap::Args;
use sim_harness::console;
use sim_harness::device::{
    Pace, QemuOptions, ReplayPass, ReplayPlan, Replayed, replay_on_board, replay_on_host,
};
use sim_harness::log::StoredRecording;

use super::progress::PassProgress;
use super::{connect, replay_report};

/// Arguments of the host, emulator or board on which the filter runs.
#[derive(Debug, Args)]
pub(super) struct ReplayTarget {
    /// Where the filter runs: `host`, `qemu`, or the name of a serial port.
    #[arg(long, default_value = "host", value_name = "host|qemu|PORT")]
    on: String,
    /// Speed of the serial port, bits per second; 2000000 if not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    baud: Option<u32>,
    /// With `--on qemu`: this ELF file instead of one that is built now.
    #[arg(long, value_name = "FILE")]
    pub(super) image: Option<PathBuf>,
    /// With `--on qemu`: count instructions, one per nanosecond, and print the mean and the
    /// longest step.
    #[arg(long)]
    count_instructions: bool,
    /// With `--on qemu`: fill the RAM with this byte before the start.
    #[arg(long, value_name = "BYTE")]
    ram_fill: Option<u8>,
}

impl ReplayTarget {
    /// Checks, before the work, that no option is given that would do nothing.
    pub(super) fn check(&self) -> Result<(), String> {
        let of_emulator = [
            ("--count-instructions", self.count_instructions),
            ("--ram-fill", self.ram_fill.is_some()),
        ];
        connect::check(&self.on, self.baud, self.image.as_deref(), &of_emulator)
    }

    pub(super) fn is_host(&self) -> bool {
        self.on == "host"
    }

    /// What a summary calls it.
    pub(super) fn ran_on(&self) -> &'static str {
        match self.on.as_str() {
            "host" => "host",
            "qemu" => "QEMU (emulated)",
            _ => "board",
        }
    }

    /// Runs the filter where it was asked for, and prints what became of the frames.
    pub(super) fn replay(
        &self,
        plan: &ReplayPlan<'_>,
        recording: &mut StoredRecording,
    ) -> Result<Replayed, Box<dyn Error>> {
        let length = Some(recording.length());
        let mut progress = PassProgress::default();
        let mut show = |pass, bytes| match pass {
            ReplayPass::Replay => progress.show("replayed", bytes, length),
            ReplayPass::Compare => progress.show("compared", bytes, length),
        };
        if self.is_host() {
            let run = replay_on_host(plan, recording, &mut show)?;
            drop(progress);
            replay_report::frames(&run)?;
            return Ok(run);
        }
        let options = QemuOptions {
            count_instructions: self.count_instructions,
            // The status that each step waits for comes without a wait of the host.
            skip_idle: self.count_instructions,
            ram_fill: self.ram_fill,
            ..QemuOptions::default()
        };
        let image = self.image.as_deref();
        let mut board = connect::reach(&self.on, self.baud, image, &options, Some(plan.config))?;
        connect::greet(&mut board)?;
        connect::check_capacity(&board, plan.config)?;
        let pace = if self.count_instructions {
            Pace::StatusPerStep
        } else {
            Pace::Answers
        };
        let run = replay_on_board(plan, &mut board, pace, recording, &mut show)?;
        drop(progress);
        replay_report::refused_inputs(&run.outcome);
        if self.count_instructions {
            replay_report::steps(&run);
        }
        console::print_text(board.tally());
        Ok(run)
    }
}
