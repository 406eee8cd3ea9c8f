//! `cargo ipf record`: a robot's drive as it reads it itself.

use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use amiro_ipf::event::{Event, Status};
use clap::Args;
use sim_harness::link::{QemuOptions, record};
use sim_harness::log::RecordingWriter;

use super::settings::Settings;
use super::{Ending, Outcome, target};

/// Arguments of `record`.
#[derive(Debug, Args)]
pub(super) struct Record {
    /// Where the robot is: the name of a serial port, or `qemu`.
    #[arg(long, value_name = "PORT|qemu")]
    on: String,
    /// Speed of the serial port, bits a second.
    #[arg(long, default_value_t = 2_000_000, value_name = "N")]
    baud: u32,
    #[command(flatten)]
    settings: Settings,
    /// The recording.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// How long to record; without end if not given, until interrupted.
    #[arg(long, value_name = "S")]
    seconds: Option<u32>,
}

impl Record {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
        let config = self.settings.apply(None)?;
        let mut board = target::reach(&self.on, self.baud, None, &QemuOptions::default())?;
        target::greet(&mut board)?;
        let file =
            File::create(&self.out).map_err(|error| format!("{}: {error}", self.out.display()))?;
        let mut writer = RecordingWriter::new(BufWriter::new(file))?;
        let end = self
            .seconds
            .map(|seconds| Instant::now() + Duration::from_secs(u64::from(seconds)));
        let mut steps = 0;
        let recorded = record(&mut board, &config, &mut writer, |event| {
            match event {
                Event::StepDone(_) => steps += 1,
                Event::Status(status) => say(status),
                _ => {}
            }
            end.is_none_or(|end| Instant::now() < end)
        });
        eprintln!();
        // Whatever ended it: what came is kept.
        writer.finish()?;
        recorded?;
        println!(
            "{steps} steps in {}; {} frames were lost",
            self.out.display(),
            board.lost_frames()
        );
        Ok(Ending::Good)
    }
}

/// One line that overwrites itself.
fn say(status: &Status) {
    let (node, board) = (&status.node, &status.board);
    let obstacle = node.obstacle.map_or("nothing near".to_owned(), |obstacle| {
        format!(
            "nearest {:.0} mm at {:.0} deg",
            1e3 * obstacle.range_m,
            obstacle.bearing_rad.to_degrees()
        )
    });
    let fault = node
        .last_fault
        .map_or(String::new(), |fault| format!(", last fault: {fault}"));
    eprint!(
        "\r\x1b[K{:.1} s, {} steps, {obstacle}{fault}",
        board.uptime_ms as f64 * 1e-3,
        node.steps
    );
}
