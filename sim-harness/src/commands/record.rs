//! `cargo ipf record`: a robot's drive as it reads it itself.

use std::cell::RefCell;
use std::io::BufWriter;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use amiro_ipf::event::{Event, Status};
use amiro_ipf::fault::Fault;
use amiro_ipf::health::Health;
use amiro_ipf::sensor::SensorMask;
use clap::Args;
use sim_harness::console;
use sim_harness::device::{
    LinkError, News, QemuOptions, RecordError, post_mortem_in_words, record,
};

use super::health_text::{counters, health_text, report_counters, status_counters};
use super::parts::Parts;
use super::settings::Settings;
use super::{Ending, Outcome, arguments, connect};

/// Arguments of `record`.
#[derive(Debug, Args)]
pub(super) struct Record {
    /// Where the robot is: the name of a serial port, or `qemu`.
    #[arg(long, value_name = "PORT|qemu")]
    on: String,
    /// Speed of the serial port, bits per second; 2000000 if not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    baud: Option<u32>,
    #[command(flatten)]
    settings: Settings,
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

impl Record {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
        connect::check(&self.on, self.baud, None, &[])?;
        let config = self.settings.apply(None)?;
        let parts = RefCell::new(Parts::new(self.out, self.force, &self.on)?);
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
        let mut steps = 0;
        // How the life before ended was printed at the greeting.
        let mut known_end = board.post_mortem().cloned();
        let mut known = None;
        let mut known_mode = None;
        let mut last_status = Status::default();
        let mut last_health = Health::default();
        let open = |part| {
            let mut parts = parts.borrow_mut();
            let file = parts.open()?;
            if let Some(path) = parts.opened().last().filter(|_| part > 1) {
                console::warn(format_args!("it goes on in {}", path.display()));
            }
            Ok(BufWriter::new(file))
        };
        let recorded = record(&mut board, &config, open, |news| {
            match news {
                News::Event(Event::StepDone(_)) => steps += 1,
                News::Event(Event::Status(status)) => {
                    say(status);
                    last_status = *status;
                }
                News::Event(Event::Health(health)) => {
                    last_health = *health;
                    let ailments = health_text(health);
                    if known.is_none() {
                        console::warn(format_args!(
                            "seed {:?}, offsets {:?}",
                            health.seed, health.offsets
                        ));
                    }
                    if known.as_ref() != Some(&ailments) {
                        let said = if ailments.is_empty() {
                            "all is well"
                        } else {
                            &ailments
                        };
                        console::warn(said);
                        known = Some(ailments);
                    }
                }
                News::Event(Event::Supervision(supervision)) => {
                    let mode = connect::unwell(supervision);
                    if mode != known_mode {
                        console::warn(mode.as_deref().unwrap_or("the board's mode: Normal"));
                        known_mode = mode;
                    }
                }
                News::Event(Event::PostMortem(record)) => {
                    if known_end.as_ref() != Some(record) {
                        console::warn(post_mortem_in_words(record));
                        known_end = Some(record.clone());
                    }
                }
                News::Event(Event::BrokeOff { .. }) => console::warn(
                    "BrokeOff: the odometry broke off, what was found before shares no origin with what follows",
                ),
                News::Limited {
                    particles_per_sensor,
                } => console::warn(format_args!(
                    "Limit: steps take too long, {particles_per_sensor} particles a sensor from now on"
                )),
                News::Event(_) | News::Input(_) | News::Waiting | News::Away => {}
                News::Vanished(error) => console::warn(format_args!("{error}; trying again")),
                News::Back => console::warn("the link is back"),
                News::Restarted { .. } => {
                    known_end = None;
                    console::warn("the board started anew");
                }
                News::Junk => console::warn(LinkError::Junk),
                News::Silent => console::warn(
                    "the board sent nothing for 2 s: the recording ends here and is whole",
                ),
            }
            end.is_none_or(|end| Instant::now() < end)
        });
        console::print_text(board.tally());
        report_counters(&[status_counters(&last_status), counters(&last_health)].concat());
        let cycles = last_status.board.step_cycles_max;
        if cycles > 0 {
            console::print(format_args!("longest step: step_cycles_max {cycles}"));
        }
        if let Err(RecordError::Link(LinkError::Refused(Fault::SafeMode))) = recorded {
            connect::print_unwell(&mut board);
        }
        let parts = parts.into_inner();
        let files: Vec<_> = parts
            .opened()
            .iter()
            .map(|path| path.display().to_string())
            .collect();
        if !files.is_empty() {
            console::print(format_args!("{steps} steps in {}", files.join(", ")));
        }
        recorded?;
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
        .map_or(String::new(), |fault| format!(", last fault: {fault:?}"));
    let without: String = SensorMask(node.without)
        .iter()
        .map(|sensor| format!(", without sensor {sensor}"))
        .collect();
    console::show_progress(format_args!(
        "{:.1} s, {} steps, {obstacle}{without}{fault}",
        board.uptime_ms as f64 * 1e-3,
        node.steps
    ));
}
