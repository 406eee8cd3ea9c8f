//! `cargo ipf replay`: a recorded drive, filtered and mapped.

use std::error::Error;
use std::path::PathBuf;

use clap::Args;
use sim_harness::device::{Equality, ReplayPlan};
use sim_harness::drive::replayed_config;
use sim_harness::evaluation::recorded_scenario;
use sim_harness::faults::Faults;
use sim_harness::log::StoredRecording;
use sim_harness::report::{RUN_FILES, WALL_FILES};
use sim_harness::{console, output};

use super::footprint::FootprintSwitch;
use super::overrides::Overrides;
use super::progress::PassProgress;
use super::replay_files::ReplayFiles;
use super::replay_target::ReplayTarget;
use super::{CommandResult, ExitStatus, arguments, replay_report};

/// Map cells of a drive without a scenario, metres.
const CELL_M: f64 = 0.010;

/// Arguments of `replay`.
#[derive(Debug, Args)]
pub(super) struct Replay {
    /// The recording: AMiRo text or frames of the link; `-` for standard input.
    file: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    #[command(flatten)]
    target: ReplayTarget,
    /// What is wrong, in the words of `simulate`: with the line from the filter to the
    /// mapper, as in `link=drop:1e-4x300+off@2s..5s`; with the recorded inputs, as in
    /// `s3=stuck@5s..8s, can=off@10s`. Times count from the recording's first input.
    #[arg(
        long,
        default_value_t,
        hide_default_value = true,
        value_name = "FAULTS"
    )]
    fault: Faults,
    /// Seed of what is random about the faults.
    #[arg(long, default_value_t = 1, value_name = "N", requires = "fault", value_parser = arguments::seed)]
    seed_of_faults: u64,
    /// Whether cells of the map whose centre has been under the robot's hull are free.
    #[arg(long, value_enum, default_value_t = FootprintSwitch::On, value_name = "on|off")]
    footprint: FootprintSwitch,
    /// Where map, summary and event stream go.
    #[arg(long, default_value = "out/replay", value_name = "DIR", value_parser = arguments::path())]
    out: PathBuf,
    /// End with exit code 2 if a line or frame of the recording was refused.
    #[arg(long)]
    strict: bool,
}

impl Replay {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        self.check_options()?;
        let outputs = RUN_FILES.iter().chain(&WALL_FILES);
        let outputs: Vec<_> = outputs.map(|name| self.out.join(name)).collect();
        let image = self.target.image.iter().map(PathBuf::as_path);
        let read = image.chain(self.overrides.gains());
        let inputs: Vec<_> = read.chain([self.file.as_path()]).collect();
        output::check(&outputs, &inputs)?;
        let mut recording = self.open()?;
        let overview = recording.overview().clone();
        if !overview.refusals.is_empty() {
            console::warn_text(&overview.refusals);
        }
        let config = replayed_config(self.overrides.apply(overview.config)?);
        let scenario = recorded_scenario(&overview).map_err(|error| error.of_file(&self.file))?;
        replay_report::recorded(&mut recording)?;
        self.fault.check_on_inputs()?;
        if !self.fault.are_none() {
            console::print(format_args!(
                "with faults: {}, seed {}",
                self.fault, self.seed_of_faults
            ));
        }
        let plan = ReplayPlan {
            config: &config,
            is_recorded_config: self.overrides.are_default(),
            is_fixed: self.overrides.fixed(),
            faults: &self.fault,
            seed_of_faults: self.seed_of_faults,
            cell_m: scenario.as_ref().map_or(CELL_M, |scenario| scenario.cell_m),
            hull_radius_m: self.footprint.radius_m(&config),
            is_scored: scenario.is_some(),
        };
        let run = self.target.replay(&plan, &mut recording)?;
        let steps = run.run_record.statistics().steps;
        let why_none = run.input_check.finish(&config, steps, run.outcome.faults());
        if let Some(reason) = why_none {
            let what = format!("{}: {reason}", self.file.display());
            // With a comparison the digests were the point; else there is nothing to show.
            if run.comparison.is_none() {
                return Err(what.into());
            }
            console::warn(what);
        }
        let equality = run.comparison.as_ref().map(|verdict| verdict.equality);
        let files = ReplayFiles {
            out: &self.out,
            title: &self.file.file_stem().unwrap_or_default().to_string_lossy(),
            ran_on: self.target.ran_on(),
            scenario: scenario.as_ref(),
        };
        files.report(&plan, &mut recording, run)?;
        Ok(match equality {
            Some(Equality::Different) => ExitStatus::Failed,
            _ if self.strict && !overview.refusals.is_empty() => ExitStatus::Refused,
            Some(Equality::ParticlesLost) => ExitStatus::ParticlesLost,
            Some(Equality::Equal) | None => ExitStatus::Good,
        })
    }

    /// Checks, before anything is read, what can be known of the options by then.
    fn check_options(&self) -> Result<(), String> {
        self.target.check()?;
        if !self.fault.line().is_empty() && !self.target.is_host() {
            return Err("--fault link=... disturbs a run on the host, not on a board".into());
        }
        self.overrides.apply(None)?;
        arguments::check_folder("--out", &self.out)
    }

    /// Reads the recording through once.
    fn open(&self) -> Result<StoredRecording, Box<dyn Error>> {
        let mut progress = PassProgress::default();
        let show = |bytes, length| progress.show("read", bytes, length);
        Ok(StoredRecording::open(&self.file, show)?)
    }
}
