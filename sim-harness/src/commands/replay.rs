//! `cargo ipf replay`: a recorded drive, filtered and mapped.

use std::error::Error;
use std::io;
use std::path::PathBuf;

use amiro_ipf::link::Message;
use amiro_ipf::node::{Config, Input, Source, StepRule};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use sim_harness::device::{Board, Equality, QemuOptions, post_mortem_in_words};
use sim_harness::drive::{FilterRecords, Record};
use sim_harness::evaluation::{DriveJudge, DriveScores, ScoreRecord, Truth};
use sim_harness::faults::{Faults, NotOnInputs};
use sim_harness::log::{Overview, StoredRecording};
use sim_harness::mapping::{CountingMapper, FootprintMapper, MAX_CELLS};
use sim_harness::world::{Scenario, ScenarioError};
use sim_harness::{RunRecord, TICK_PERIOD_US, Ticked, console, output, pipeline};

use super::footprint::FootprintSwitch;
use super::replay_on_board::on_board;
use super::replay_run::{Plan, Replayed, on_host};
use super::report::{self, Summary, Walls};
use super::settings::Settings;
use super::{Ending, Outcome, arguments, connect, replay_stream};

/// Map cells of a drive without a scenario, metres.
const CELL_M: f64 = 0.010;

/// Arguments of `replay`.
#[derive(Debug, Args)]
pub(super) struct Replay {
    /// The recording: AMiRo text or frames of the link; `-` for standard input.
    file: PathBuf,
    #[command(flatten)]
    settings: Settings,
    /// Where the filter runs: `host`, `qemu`, or the name of a serial port.
    #[arg(long, default_value = "host", value_name = "host|qemu|PORT")]
    pub(super) on: String,
    /// Speed of the serial port, bits per second; 2000000 if not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    baud: Option<u32>,
    /// What is wrong, in the words of `simulate`: with the line from the filter to the
    /// mapper, as in `link=drop:1e-4x300+off@2s..5s`; with the recorded inputs, as in
    /// `s3=stuck@5s..8s, can=off@10s`. Times count from the recording's first input.
    #[arg(
        long,
        default_value_t,
        hide_default_value = true,
        value_name = "FAULTS"
    )]
    pub(super) fault: Faults,
    /// Seed of what is random about the faults.
    #[arg(long, default_value_t = 1, value_name = "N", requires = "fault", value_parser = arguments::seed)]
    pub(super) seed_of_faults: u64,
    /// Whether cells of the map whose centre has been under the robot's hull are free.
    #[arg(long, value_enum, default_value_t = FootprintSwitch::On, value_name = "on|off")]
    footprint: FootprintSwitch,
    /// Where map, summary and event stream go.
    #[arg(long, default_value = "out/replay", value_name = "DIR", value_parser = arguments::path())]
    pub(super) out: PathBuf,
    /// End with exit code 2 if a line or frame of the recording was refused.
    #[arg(long)]
    strict: bool,
    /// With `--on qemu`: this ELF file instead of one that is built now.
    #[arg(long, value_name = "FILE")]
    image: Option<PathBuf>,
    /// With `--on qemu`: count instructions, one a nanosecond.
    #[arg(long)]
    pub(super) count_instructions: bool,
    /// With `--on qemu`: fill the RAM with this byte before the start.
    #[arg(long, value_name = "BYTE")]
    ram_fill: Option<u8>,
}

impl Replay {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
        self.check_options()?;
        let outputs = report::FILES.map(|name| self.out.join(name));
        let image = self.image.iter().map(PathBuf::as_path);
        let inputs: Vec<_> = image.chain([self.file.as_path()]).collect();
        output::check(&outputs, &inputs)?;
        let mut recording = self.open()?;
        let overview = recording.overview().clone();
        if !overview.refusals.is_empty() {
            console::warn_text(&overview.refusals);
        }
        let config = as_replayed(self.settings.apply(overview.config)?);
        let scenario = scenario_of(&overview).map_err(|error| error.of_file(&self.file))?;
        print_what_was_recorded(&mut recording)?;
        self.fault.check_on_inputs()?;
        if !self.fault.are_none() {
            console::print(format_args!(
                "with faults: {}, seed {}",
                self.fault, self.seed_of_faults
            ));
        }
        let plan = Plan {
            config: &config,
            cell_m: scenario.as_ref().map_or(CELL_M, |scenario| scenario.cell_m),
            is_scored: scenario.is_some(),
        };
        let run = match self.on.as_str() {
            "host" => on_host(&self, &plan, &mut recording)?,
            _ => on_board(&self, &plan, &mut recording)?,
        };
        if let Some(standstill) = run.standstill.finish(&config, &run.survey) {
            let what = format!("{}: {standstill}", self.file.display());
            // With a comparison the digests were the point; else there is nothing to show.
            if run.comparison.is_none() {
                return Err(what.into());
            }
            console::warn(what);
        }
        let equality = run.comparison.as_ref().map(|verdict| verdict.equality);
        self.report(&config, &mut recording, scenario.as_ref(), run)?;
        Ok(match equality {
            Some(Equality::Different) => Ending::Failed,
            _ if self.strict && !overview.refusals.is_empty() => Ending::Refused,
            Some(Equality::ParticlesLost) => Ending::ParticlesLost,
            Some(Equality::Equal) | None => Ending::Good,
        })
    }

    /// Checks, before anything is read, what can be known of the options by then.
    fn check_options(&self) -> Result<(), String> {
        let of_emulator = [
            ("--count-instructions", self.count_instructions),
            ("--ram-fill", self.ram_fill.is_some()),
        ];
        connect::check(&self.on, self.baud, self.image.as_deref(), &of_emulator)?;
        if self.has_line_faults() && self.on != "host" {
            return Err("--fault link=... disturbs a run on the host, not on a board".into());
        }
        self.settings.apply(None)?;
        arguments::check_folder("--out", &self.out)
    }

    /// Reads the recording through once.
    fn open(&self) -> Result<StoredRecording, Box<dyn Error>> {
        let mut bar = None;
        let recording = StoredRecording::open(&self.file, |bytes, length| {
            let bar = bar.get_or_insert_with(|| progress("read", length));
            bar.set_position(bytes);
        })?;
        if let Some(bar) = bar {
            bar.finish_and_clear();
        }
        Ok(recording)
    }

    /// Whether the filter runs as it did when it was recorded.
    pub(super) fn is_as_recorded(&self) -> bool {
        self.settings.are_default() && self.fault.parts().is_empty()
    }

    pub(super) fn has_line_faults(&self) -> bool {
        !self.fault.line().is_empty()
    }

    /// The recorded inputs with the faults and ticks that were asked for.
    pub(super) fn replayed<'a>(
        &self,
        inputs: impl Iterator<Item = Input> + 'a,
    ) -> Result<Box<dyn Iterator<Item = Input> + 'a>, NotOnInputs> {
        let faulty = self.fault.on_stream(self.seed_of_faults, inputs)?;
        Ok(if self.settings.fixed() {
            Box::new(Ticked::new(faulty, TICK_PERIOD_US))
        } else {
            Box::new(faulty)
        })
    }

    /// An empty survey.
    pub(super) fn survey(&self, plan: &Plan<'_>) -> RunRecord {
        RunRecord::new(
            plan.config,
            plan.cell_m,
            self.footprint.radius_m(plan.config),
        )
    }

    /// The board or emulator that was asked for.
    pub(super) fn board(&self, config: &Config) -> Result<Board, Box<dyn Error>> {
        let options = QemuOptions {
            count_instructions: self.count_instructions,
            ram_fill: self.ram_fill,
            ..QemuOptions::default()
        };
        connect::reach(
            &self.on,
            self.baud,
            self.image.as_deref(),
            &options,
            Some(config),
        )
    }

    /// Writes the files, then prints what was found.
    fn report(
        &self,
        config: &Config,
        recording: &mut StoredRecording,
        scenario: Option<&Scenario>,
        mut run: Replayed,
    ) -> Result<(), Box<dyn Error>> {
        let figures = run.survey.statistics();
        let scores = match scenario {
            Some(scenario) => self.scores(config, scenario, &mut run)?,
            None => None,
        };
        let survey = &run.survey;
        let walls = scenario.is_none().then(|| Walls::of(survey));
        output::create_folder(&self.out)?;
        let name = self.file.file_stem().unwrap_or_default().to_string_lossy();
        let picture = report::picture(survey, &name, scenario, None);
        report::save_map(survey, &picture, &self.out)?;
        replay_stream::save(self, config, recording, run.answered)?;
        let overview = recording.overview();
        let summary = Summary {
            format: overview.format.to_string(),
            refused: overview.refusals.count(),
            ran_on: run.ran_on,
            config: *config,
            figures,
            scores: scores.as_ref().map(ScoreRecord::from),
            walls,
            comparison: run.comparison,
        };
        summary.save(&self.out)?;
        print_report(&summary, scores.as_ref(), run.events.resets);
        Ok(())
    }

    /// The scores of a run whose events were kept; the events are used up.
    fn scores(
        &self,
        config: &Config,
        scenario: &Scenario,
        run: &mut Replayed,
    ) -> io::Result<Option<DriveScores>> {
        let Some(events) = run.events.all.take() else {
            return Ok(None);
        };
        let poses = run.survey.poses();
        let truth = Truth::of(scenario, poses);
        let mut mapper = FootprintMapper::new(
            CountingMapper::new(scenario.cell_m),
            scenario.cell_m,
            self.footprint.radius_m(config),
        );
        let mut events = events.events()?;
        let mut judge = DriveJudge::new(scenario, &truth, poses);
        let mut records = FilterRecords::new(config.photometry);
        let read = |take: &mut dyn FnMut(&Record)| {
            events
                .by_ref()
                .for_each(|event| records.translate(&event, take));
            events.finish()
        };
        pipeline::run(read, &mut mapper, &mut |record, mapper| {
            judge.take(record, mapper);
        })?;
        Ok(Some(judge.finish(&mapper)))
    }
}

/// What was found, for the terminal.
fn print_report(summary: &Summary, scores: Option<&DriveScores>, resets: usize) {
    let figures = &summary.figures;
    console::print(format_args!(
        "{} steps over {:.3} m, mean step {}, {} occupied and {} free cells",
        figures.steps,
        figures.path_m,
        figures
            .mean_step_m
            .map_or("n/a".to_owned(), |step| format!("{:.2} mm", 1e3 * step)),
        figures.cells_occupied,
        figures.cells_free
    ));
    if figures.cells_refused > 0 {
        console::print(format_args!(
            "THE MAP IS CUT: it holds at most {MAX_CELLS} cells, {} updates of cells were refused",
            figures.cells_refused
        ));
    }
    if let Some(radius_m) = figures.footprint_radius_m {
        console::print(format_args!(
            "the robot's footprint is free in the map: hull of {:.0} mm radius",
            1e3 * radius_m
        ));
    }
    match resets {
        0 => {}
        times => console::print(format_args!(
            "BrokeOff {times} times: parts of the map share no origin"
        )),
    }
    if let Some(scores) = scores {
        console::print_text(scores.last);
        console::print("(the figures are explained by `cargo ipf demo` and in docs/evaluation.md)");
    }
    if let Some(walls) = &summary.walls {
        console::print_text(walls);
    }
    if let Some(comparison) = &summary.comparison {
        console::print_text(comparison);
    }
}

/// The world that a simulated recording carries.
fn scenario_of(overview: &Overview) -> Result<Option<Scenario>, ScenarioError> {
    let text = overview
        .truth
        .as_ref()
        .and_then(|truth| truth.scenario.as_ref());
    text.map(|text| Scenario::parse(text)).transpose()
}

/// A configuration under which everything comes in with the recording, whatever the
/// recorded board read or counted itself.
fn as_replayed(config: Config) -> Config {
    let step_rule = match config.step_rule {
        StepRule::PerTick { .. } => StepRule::PerTick { own_clock: false },
        rule @ StepRule::PerDistance { .. } => rule,
    };
    Config {
        step_rule,
        source: Source::Link,
        ..config
    }
}

/// Prints what was broken on purpose in the recorded run, and how its board's boot before
/// had ended.
fn print_what_was_recorded(recording: &mut StoredRecording) -> Result<(), Box<dyn Error>> {
    let overview = recording.overview();
    let faults = overview.truth.iter().flat_map(|truth| &truth.faults);
    for (text, seed) in faults {
        console::print(format_args!("recorded with faults: {text}, seed {seed}"));
    }
    if overview.post_mortems == 0 {
        return Ok(());
    }
    let mut messages = recording.messages(|_| ())?;
    for message in messages.by_ref() {
        if let Message::PostMortem(record) = message {
            console::print(format_args!("recorded: {}", post_mortem_in_words(&record)));
        }
    }
    messages.finish()?;
    Ok(())
}

/// A bar over the bytes of a source on a terminal, nothing in a pipe.
pub(super) fn progress(done: &'static str, length: Option<u64>) -> ProgressBar {
    if !console::is_interactive() {
        return ProgressBar::hidden();
    }
    let (bar, template) = match length {
        Some(length) => (
            ProgressBar::new(length),
            "{bar:40} {decimal_bytes} of {decimal_total_bytes} ",
        ),
        None => (ProgressBar::new_spinner(), "{spinner} {decimal_bytes} "),
    };
    match ProgressStyle::with_template(&format!("{template}{done}")) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
