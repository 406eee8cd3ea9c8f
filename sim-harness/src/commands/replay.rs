//! `cargo ipf replay`: a recorded drive, filtered and mapped.

use std::error::Error;
use std::path::PathBuf;

use amiro_ipf::config::{Config, Source, StepRule};
use amiro_ipf::event::Event;
use amiro_ipf::input::Input;
use amiro_ipf::wire::{Encoder, Outgoing, Truth as TruthMessage};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use sim_harness::console;
use sim_harness::device::{
    Comparison, Equality, FaultInjector, HOST_NODE_BOOT_ID, LineRun, QemuOptions, Verdict, drive,
    listen, post_mortem_in_words,
};
use sim_harness::evaluation::{DriveScores, ScoreRecord, Truth};
use sim_harness::faults::Faults;
use sim_harness::log::{self, Recording, RecordingWriter};
use sim_harness::mapping::{CountingMapper, FootprintMapper, MAX_CELLS};
use sim_harness::output;
use sim_harness::world::{Scenario, ScenarioError};
use sim_harness::{RunOutcome, Survey, TICK_PERIOD_US, run, with_ticks};

use super::footprint::FootprintSwitch;
use super::report::{self, Summary, Walls};
use super::settings::Settings;
use super::standstill::Standstill;
use super::{Ending, Outcome, arguments, connect};

/// Map cells of a drive without a scenario, metres.
const CELL_M: f64 = 0.010;

/// Cycles of a core that an emulator lets run at one instruction a nanosecond.
const NANOSECONDS_PER_CYCLE: f64 = 1e9 / 168e6;

/// Arguments of `replay`.
#[derive(Debug, Args)]
pub(super) struct Replay {
    /// The recording: AMiRo text or frames of the link; `-` for standard input.
    file: PathBuf,
    #[command(flatten)]
    settings: Settings,
    /// Where the filter runs: `host`, `qemu`, or the name of a serial port.
    #[arg(long, default_value = "host", value_name = "host|qemu|PORT")]
    on: String,
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
    /// With `--on qemu`: this ELF file instead of one that is built now.
    #[arg(long, value_name = "FILE")]
    image: Option<PathBuf>,
    /// With `--on qemu`: count instructions, one a nanosecond.
    #[arg(long)]
    count_instructions: bool,
    /// With `--on qemu`: fill the RAM with this byte before the start.
    #[arg(long, value_name = "BYTE")]
    ram_fill: Option<u8>,
}

/// Where the filter ran, and what came of it.
struct Run {
    ran_on: &'static str,
    survey: Survey,
    events: Kept,
    stream: Vec<u8>,
    comparison: Option<Verdict>,
}

/// What of a run's events the report needs besides the survey.
struct Kept {
    /// How often the odometry broke off.
    broke_off: usize,
    /// All of them, for the scores on the way, where the recording carries a truth.
    all: Option<Vec<Event>>,
}

impl Kept {
    fn new(is_scored: bool) -> Self {
        Self {
            broke_off: 0,
            all: is_scored.then(Vec::new),
        }
    }

    fn take(&mut self, event: &Event) {
        self.broke_off += usize::from(matches!(event, Event::BrokeOff { .. }));
        if let Some(all) = &mut self.all {
            all.push(event.clone());
        }
    }
}

impl Replay {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
        self.check_options()?;
        let outputs = report::FILES.map(|name| self.out.join(name));
        let image = self.image.iter().map(PathBuf::as_path);
        let inputs: Vec<_> = image.chain([self.file.as_path()]).collect();
        output::check(&outputs, &inputs)?;
        let recording = log::read(&self.file)?;
        if !recording.refusals.is_empty() {
            console::warn_text(&recording.refusals);
        }
        let config = as_replayed(self.settings.apply(recording.config)?);
        let scenario = scenario_of(&recording).map_err(|error| error.of_file(&self.file))?;
        let cell_m = scenario.as_ref().map_or(CELL_M, |scenario| scenario.cell_m);
        let told_faults = recording.truth.iter().flat_map(|truth| &truth.faults);
        for (text, seed) in told_faults {
            console::print(format_args!("recorded with faults: {text}, seed {seed}"));
        }
        for event in &recording.events {
            if let Event::PostMortem(record) = event {
                console::print(format_args!("recorded: {}", post_mortem_in_words(record)));
            }
        }
        let inputs = self
            .fault
            .on_inputs(self.seed_of_faults, &recording.inputs)?;
        let inputs = if self.settings.fixed() {
            with_ticks(&inputs, TICK_PERIOD_US)
        } else {
            inputs
        };
        if !self.fault.are_none() {
            console::print(format_args!(
                "with faults: {}, seed {}",
                self.fault, self.seed_of_faults
            ));
        }
        let is_scored = scenario.is_some();
        let run = match self.on.as_str() {
            "host" => self.on_host(&config, &inputs, &recording, (cell_m, is_scored))?,
            _ => self.on_board(&config, &inputs, (cell_m, is_scored))?,
        };
        if let Some(standstill) = Standstill::of(&config, &inputs, &run.survey) {
            let what = format!("{}: {standstill}", self.file.display());
            // With a comparison the digests were the point; else there is nothing to show.
            if run.comparison.is_none() {
                return Err(what.into());
            }
            console::warn(what);
        }
        self.report(&config, &inputs, &recording, scenario.as_ref(), &run)?;
        let equality = run.comparison.map(|verdict| verdict.equality);
        Ok(match equality {
            Some(Equality::Different) => Ending::Failed,
            _ if self.strict && !recording.refusals.is_empty() => Ending::Refused,
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

    fn has_line_faults(&self) -> bool {
        !self.fault.line().is_empty()
    }

    /// On the host's node; recorded events of the same configuration must be met.
    fn on_host(
        &self,
        config: &Config,
        inputs: &[Input],
        recording: &Recording,
        (cell_m, is_scored): (f64, bool),
    ) -> Result<Run, Box<dyn Error>> {
        let is_recorded = recording.config.is_some()
            && self.settings.are_default()
            && self.fault.parts().is_empty()
            && recording
                .events
                .iter()
                .any(|event| matches!(event, Event::StepDone(_)));
        let mut survey = Survey::with_footprint(cell_m, self.footprint.radius_m(config));
        let mut events = Kept::new(is_scored);
        let mut line = self
            .has_line_faults()
            .then(|| LineRun::new(FaultInjector::new(&self.fault, self.seed_of_faults)));
        let (mut encoder, mut stream) = (Encoder::new(HOST_NODE_BOOT_ID), Vec::new());
        let mut comparison = Comparison::default();
        let bar = progress("steps", None);
        let mut arrive = |event: &Event| {
            survey.take(event);
            events.take(event);
        };
        let outcome = run(config, inputs, |event| {
            if is_recorded {
                comparison.expect(event);
            }
            if let Some(line) = &mut line {
                line.send(event, &mut arrive);
            } else {
                stream.extend_from_slice(encoder.encode(Outgoing::Event(event)));
                arrive(event);
            }
            bar.inc(u64::from(matches!(event, Event::StepDone(_))));
        })?;
        let arrived = line.map(|line| line.finish(&mut arrive));
        bar.finish_and_clear();
        if let Some(arrived) = arrived {
            let (frames, line) = (arrived.frames, arrived.line);
            console::print(format_args!("{frames}; {} damaged", line.damaged));
            frames.balance(line.sent)?;
            stream = arrived.bytes;
        }
        warn_of_refused_inputs(&outcome);
        if is_recorded {
            recording
                .events
                .iter()
                .for_each(|event| comparison.meet(event));
        }
        Ok(Run {
            ran_on: "host",
            survey,
            events,
            stream,
            comparison: is_recorded.then(|| comparison.verdict_of_recording()),
        })
    }

    /// On a board or in QEMU, held against the host's own run.
    fn on_board(
        &self,
        config: &Config,
        inputs: &[Input],
        (cell_m, is_scored): (f64, bool),
    ) -> Result<Run, Box<dyn Error>> {
        let ran_on = if self.on == "qemu" {
            "QEMU (emulated)"
        } else {
            "board"
        };
        let options = QemuOptions {
            count_instructions: self.count_instructions,
            ram_fill: self.ram_fill,
            ..QemuOptions::default()
        };
        let mut board = connect::reach(
            &self.on,
            self.baud,
            self.image.as_deref(),
            &options,
            Some(config),
        )?;
        connect::greet(&mut board)?;
        connect::check_capacity(&board, config)?;
        let mut comparison = Comparison::default();
        let outcome = run(config, inputs, |event| comparison.expect(event))?;
        warn_of_refused_inputs(&outcome);
        // The configuration goes in front.
        let refusals: Vec<_> = outcome
            .refusals
            .iter()
            .map(|&(input, fault)| (input + 1, fault))
            .collect();
        comparison.expect_refusals(&refusals);
        let mut survey = Survey::with_footprint(cell_m, self.footprint.radius_m(config));
        let mut events = Kept::new(is_scored);
        let mut slowest_step = 0;
        let mut all = vec![Input::Configure(*config)];
        all.extend_from_slice(inputs);
        let bar = progress("inputs", Some(all.len() as u64));
        let mut answers = Vec::with_capacity(all.len());
        let driven = drive(
            &mut board,
            &all,
            |event| {
                survey.take(event);
                events.take(event);
                comparison.meet(event);
                if let Event::Status(status) = event {
                    slowest_step = slowest_step.max(status.board.step_cycles_max);
                }
            },
            |input, refused| {
                answers.push((input, refused));
                bar.inc(1);
            },
        );
        bar.finish_and_clear();
        comparison.take_audit(driven?);
        listen(&mut board, |event| comparison.meet(event))?;
        for (input, refused) in answers {
            comparison.meet_answer(input, refused);
        }
        if self.count_instructions {
            let instructions = f64::from(slowest_step) * NANOSECONDS_PER_CYCLE / 1e6;
            console::print(format_args!(
                "longest step: {instructions:.2} million instructions (emulated)"
            ));
        }
        console::print_text(board.tally());
        let verdict = comparison.verdict(board.boot(), &board.tally());
        Ok(Run {
            ran_on,
            survey,
            events,
            stream: board.take_raw(),
            comparison: Some(verdict),
        })
    }

    /// Writes the files, then prints what was found.
    fn report(
        &self,
        config: &Config,
        inputs: &[Input],
        recording: &Recording,
        scenario: Option<&Scenario>,
        run: &Run,
    ) -> Result<(), Box<dyn Error>> {
        let survey = &run.survey;
        let figures = survey.figures();
        let scores = scenario.map(|scenario| {
            let truth = Truth::of(scenario, survey.poses());
            let mut mapper = FootprintMapper::new(
                CountingMapper::new(scenario.cell_m),
                scenario.cell_m,
                self.footprint.radius_m(config),
            );
            let events = run.events.all.as_deref().unwrap_or_default();
            DriveScores::of(&mut mapper, events, scenario, &truth)
        });
        let walls = scenario.is_none().then(|| Walls::of(survey));
        output::create_folder(&self.out)?;
        let name = self.file.file_stem().unwrap_or_default().to_string_lossy();
        let picture = report::picture(survey, &name, scenario, None);
        report::save_map(survey, &picture, &self.out)?;
        self.save_stream(config, inputs, recording, &run.stream)?;
        let summary = Summary {
            format: recording.format.to_string(),
            refused: recording.refusals.count(),
            ran_on: run.ran_on,
            config: *config,
            figures,
            scores: scores.as_ref().map(ScoreRecord::from),
            walls,
            comparison: run.comparison.clone(),
        };
        summary.save(&self.out)?;
        print_report(&summary, scores.as_ref(), run.events.broke_off);
        Ok(())
    }

    /// What was broken when it was recorded, and what is broken now.
    fn faults_of_all(&self, recording: &Recording) -> Vec<(String, u64)> {
        let truth = recording.truth.as_ref();
        let mut all = truth.map_or_else(Vec::new, |truth| truth.faults.clone());
        if self.fault.are_none() {
            return all;
        }
        match all.last_mut() {
            // Texts of one seed are one text.
            Some((text, seed)) if *seed == self.seed_of_faults => {
                text.push_str(&format!(", {}", self.fault));
            }
            _ => all.push((self.fault.to_string(), self.seed_of_faults)),
        }
        all
    }

    /// The bytes of the link: a recording that replays itself.
    fn save_stream(
        &self,
        config: &Config,
        inputs: &[Input],
        recording: &Recording,
        answered: &[u8],
    ) -> Result<(), Box<dyn Error>> {
        output::write_with(&self.out.join("stream.ipf"), |file| {
            let mut writer = RecordingWriter::new(file)?;
            if let Some(truth) = &recording.truth {
                if let Some(seed) = truth.seed {
                    writer.write_truth(&TruthMessage::Seed(seed))?;
                }
                if let Some(text) = &truth.scenario {
                    writer.write_scenario(text)?;
                }
            }
            for (text, seed) in self.faults_of_all(recording) {
                writer.write_faults(&text, seed)?;
            }
            if let Some(truth) = &recording.truth {
                for &(stamp_us, pose) in &truth.poses {
                    writer.write_truth(&TruthMessage::Pose { stamp_us, pose })?;
                }
            }
            writer.write_input(&Input::Configure(*config))?;
            for input in inputs {
                writer.write_input(input)?;
            }
            writer.write_frames(answered)?;
            writer.finish()?;
            Ok(())
        })?;
        Ok(())
    }
}

/// What was found, for the terminal.
fn print_report(summary: &Summary, scores: Option<&DriveScores>, broke_off: usize) {
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
    match broke_off {
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
fn scenario_of(recording: &Recording) -> Result<Option<Scenario>, ScenarioError> {
    let text = recording
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

fn warn_of_refused_inputs(outcome: &RunOutcome) {
    for (fault, count) in outcome.faults() {
        console::warn(format_args!("{count} inputs refused: {fault:?}, {fault}"));
    }
}

/// A bar on a terminal, nothing in a pipe.
fn progress(unit: &'static str, length: Option<u64>) -> ProgressBar {
    if !console::is_interactive() {
        return ProgressBar::hidden();
    }
    let (bar, template) = match length {
        Some(length) => (ProgressBar::new(length), "{bar:40} {pos}/{len} "),
        None => (ProgressBar::new_spinner(), "{spinner} {pos} "),
    };
    match ProgressStyle::with_template(&format!("{template}{unit}")) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
