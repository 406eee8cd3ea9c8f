//! `cargo ipf record`: a robot's drive as it reads it itself.

use std::cell::RefCell;
use std::io::BufWriter;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use amiro_ipf::node::InputError;
use clap::Args;
use sim_harness::console;
use sim_harness::device::{LinkError, QemuOptions, RecordError, RecordingParts, record};

use super::overrides::Overrides;
use super::record_log::RecordLog;
use super::{CommandResult, ExitStatus, arguments, connect};

/// Arguments of `record`.
#[derive(Debug, Args)]
pub(super) struct RecordCommand {
    /// Where the robot is: the name of a serial port, or `qemu`.
    #[arg(long, value_name = "PORT|qemu")]
    on: String,
    /// Speed of the serial port, bits per second; 2000000 if not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    baud: Option<u32>,
    #[command(flatten)]
    overrides: Overrides,
    /// The recording: a new file (or /dev/null, /dev/stdout), created once the board has taken its configuration. A
    /// board that is reset begins a second one beside it, NAME.2.ipf or the next number
    /// that is free.
    #[arg(long, value_name = "FILE", value_parser = arguments::path())]
    out: PathBuf,
    /// Replace the file of --out if it exists.
    #[arg(long)]
    force: bool,
    /// How long to record; until interrupted (Ctrl-C, SIGTERM), or until the board has sent
    /// nothing for 2 s, if not given.
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32).range(1..))]
    seconds: Option<u32>,
}

impl RecordCommand {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        connect::check(&self.on, self.baud, None, &[])?;
        let config = self.overrides.apply(None)?;
        let parts = RefCell::new(RecordingParts::new(self.out, self.force, &self.on)?);
        let mut board = connect::reach(
            &self.on,
            self.baud,
            None,
            &QemuOptions::default(),
            Some(&config),
        )?;
        connect::greet(&mut board)?;
        connect::check_capacity(&board, &config)?;
        let end = self
            .seconds
            .map(|seconds| Instant::now() + Duration::from_secs(u64::from(seconds)));
        let mut log = RecordLog::new(board.post_mortem());
        let open = |part| {
            let mut parts = parts.borrow_mut();
            let file = parts.open()?;
            if let Some(path) = parts.opened().last().filter(|_| part > 1) {
                console::warn(format_args!("it goes on in {}", path.display()));
            }
            Ok(BufWriter::new(file))
        };
        let recorded = record(&mut board, &config, open, |news| {
            log.take(&news);
            end.is_none_or(|end| Instant::now() < end)
        });
        console::print_text(board.tally());
        log.report();
        if let Err(RecordError::Link(LinkError::Refused(InputError::SafeMode))) = recorded {
            connect::print_unwell(&mut board);
        }
        let parts = parts.into_inner();
        let files: Vec<_> = parts
            .opened()
            .iter()
            .map(|path| path.display().to_string())
            .collect();
        if !files.is_empty() {
            console::print(format_args!(
                "{} steps in {}",
                log.steps(),
                files.join(", ")
            ));
        }
        recorded?;
        Ok(ExitStatus::Good)
    }
}
