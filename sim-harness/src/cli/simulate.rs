//! `cargo ipf simulate`: a scenario, driven and recorded.

use std::error::Error;
use std::fmt::Display;
use std::io::Write;
use std::path::PathBuf;
use std::slice;

use clap::Args;
use sim_harness::device::{counters, counters_in_words};
use sim_harness::faults::Faults;
use sim_harness::robot::SimulatedDrive;
use sim_harness::world::{Options, Scenario};
use sim_harness::{console, output};

use super::differences::Differences;
use super::simulate_report::print_untrusted;
use super::{CommandResult, ExitStatus, arguments};

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub(super) struct Simulate {
    /// The scenario, a TOML file; `-` for standard input. A first line of options in it, as recordings have it,
    /// does not count: the flags do.
    scenario: PathBuf,
    /// Seed of the sensors' noise, and of the filter when the recording is replayed.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = arguments::seed)]
    seed: u64,
    /// Where the recording goes; `-` for standard output, the report then goes to standard
    /// error.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// What breaks when: PART=WORD with @FROM, @FROM..TO, @..TO or nothing behind it, and
    /// commas between.
    ///
    /// Parts are s0 to s7, ring (all of these), bus1, bus2, mux1, mux2, can (the odometry)
    /// and link. Words are ok, off, stuck, garbage, wrong:+200 (counts; of can wrong:+500mm),
    /// slow:20Hz, delayed:50ms, intermittent:0.3 and saturated; the link has its own, such
    /// as link=ber:1e-3+off@2s..5s. Times are those of the drive. With a part other than
    /// the link, if only ring=ok, a whole robot is simulated, with its buses and senses.
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
    #[command(flatten)]
    differences: Differences,
}

impl Simulate {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        let options = self.differences.options();
        let options = options.map_err(|error| format!("--{error}"))?;
        self.check_out()?;
        let (scenario, text) = Scenario::load_with_text(&self.scenario)?;
        let drive = SimulatedDrive {
            scenario: &scenario,
            text: &text,
            seed: self.seed,
            options,
            faults: &self.fault,
            seed_of_faults: self.seed_of_faults,
        };
        let (simulation, healths) = drive.simulate()?;
        let write = |file: &mut dyn Write| drive.write(&simulation, file).map(drop);
        // Lines of a report would lie within the recording.
        let report: fn(&dyn Display) = if self.is_to_stdout() {
            console::print_bytes(write)?;
            |line| console::warn(line)
        } else {
            output::write_with(&self.out, write)?;
            |line| console::print(line)
        };
        report(&format_args!(
            "{}: {} samples of {:.1} s, {}",
            self.out.display(),
            simulation.poses.len(),
            scenario.duration_s(),
            scenario.name
        ));
        if options != Options::default() {
            report(&format_args!("simulated with: {options}"));
        }
        if !self.fault.are_none() {
            report(&format_args!(
                "faults: {}, seed {}",
                self.fault, self.seed_of_faults
            ));
        }
        print_untrusted(&healths, report);
        if let Some((_, last)) = healths.last() {
            let counters = counters_in_words(&counters(last));
            counters.iter().for_each(|line| report(line));
        }
        Ok(ExitStatus::Good)
    }

    fn is_to_stdout(&self) -> bool {
        self.out.as_os_str() == "-"
    }

    fn check_out(&self) -> Result<(), Box<dyn Error>> {
        if !self.is_to_stdout() {
            arguments::check_file("--out", &self.out)?;
            output::check(slice::from_ref(&self.out), &[&self.scenario])?;
        } else if console::is_stdout_interactive() {
            return Err("--out -: a recording is no text, and standard output a terminal".into());
        }
        Ok(())
    }
}
